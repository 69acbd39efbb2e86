// The paper's step of one soft body as one would write it in C++: springs scattered edge by edge, gas triangle by
// triangle. The peer of benchmarks/bench_step.py: the same method, the same doubles, one thread.
#include <cmath>
#include <vector>

namespace {

struct Body {
    long particles, edges, triangles;
    const int *edge, *triangle;
    const double *rest_length;
    double stiffness, gas, inverse_mass, gravity;
};

void forces(const Body &body, const double *x, double *force) {
    for (long i = 0; i < 3 * body.particles; i++) force[i] = 0.0;
    for (long e = 0; e < body.edges; e++) {
        const int i = 3 * body.edge[2 * e], j = 3 * body.edge[2 * e + 1];
        const double dx = x[j] - x[i], dy = x[j + 1] - x[i + 1], dz = x[j + 2] - x[i + 2];
        const double length = std::sqrt(dx * dx + dy * dy + dz * dz);
        const double pull = body.stiffness * (length - body.rest_length[e]) / length;
        force[i] += pull * dx, force[i + 1] += pull * dy, force[i + 2] += pull * dz;
        force[j] -= pull * dx, force[j + 1] -= pull * dy, force[j + 2] -= pull * dz;
    }
    double volume = 0.0;
    for (long t = 0; t < body.triangles; t++) {
        const double *a = x + 3 * body.triangle[3 * t], *b = x + 3 * body.triangle[3 * t + 1];
        const double *c = x + 3 * body.triangle[3 * t + 2];
        volume += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                  a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    const double share = body.gas / (volume / 6.0) / 6.0;
    for (long t = 0; t < body.triangles; t++) {
        const int a = 3 * body.triangle[3 * t], b = 3 * body.triangle[3 * t + 1], c = 3 * body.triangle[3 * t + 2];
        const double ux = x[b] - x[a], uy = x[b + 1] - x[a + 1], uz = x[b + 2] - x[a + 2];
        const double vx = x[c] - x[a], vy = x[c + 1] - x[a + 1], vz = x[c + 2] - x[a + 2];
        const double nx = share * (uy * vz - uz * vy), ny = share * (uz * vx - ux * vz);
        const double nz = share * (ux * vy - uy * vx);
        for (const int corner : {a, b, c}) force[corner] += nx, force[corner + 1] += ny, force[corner + 2] += nz;
    }
}

}  // namespace

extern "C" void rk4_velocity_steps(double *x, double *v, long particles, const int *edge, const double *rest_length,
                                   long edges, const int *triangle, long triangles, double stiffness, double gas,
                                   double inverse_mass, double gravity, double h, long steps, double *work) {
    const Body body{particles, edges, triangles, edge, triangle, rest_length, stiffness, gas, inverse_mass, gravity};
    const long n = 3 * particles;
    double *force = work, *stage = work + n, *total = work + 2 * n;
    for (long step = 0; step < steps; step++) {
        for (int k = 0; k < 4; k++) {
            forces(body, k == 0 ? x : stage, force);
            const double lead = k == 2 ? h : 0.5 * h, weight = k == 1 || k == 2 ? 2.0 : 1.0;
            for (long i = 0; i < n; i++) {
                const double a = force[i] * inverse_mass + (i % 3 == 2 ? gravity : 0.0);
                if (k < 3) {
                    total[i] = k == 0 ? a : total[i] + weight * a;
                    stage[i] = x[i] + lead * (v[i] + lead * a);
                } else {
                    v[i] += h / 6.0 * (total[i] + a);
                    x[i] += h * v[i];
                }
            }
        }
    }
}
