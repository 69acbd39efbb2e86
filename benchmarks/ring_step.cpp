// The same step as in plain_step.cpp, as somebody would write it who wants the last of it: a pass over the particles,
// eight at once, each with the ring of its neighbours, springs and areas from one load of each neighbour. No
// approximate root or division, no gather instruction (single loads are faster), the same doubles, one thread.
//
// A block holds eight particles of the same degree, in a row; in a short one, what is computed of the particles after
// them, which are another block's, is not stored. There must be room for seven more after the last.
#include <cmath>
#ifdef __AVX512F__
#include <immintrin.h>
#endif

namespace {

typedef double Lanes __attribute__((vector_size(64), aligned(8)));
constexpr int WIDTH = 8;

struct Body {
    long particles, blocks;
    const int *degree, *first, *own, *used;  // of each block: first row of its rings, its particle, lanes in use
    const int *ring;                         // WIDTH particles a row
    const double *rest_length;               // the same
    double stiffness, gas, inverse_mass, gravity;
};

struct Three {
    Lanes x, y, z;
};

inline Lanes gathered(const double *from, const int *i) {
#ifdef __AVX512F__
    const __m256d low = _mm256_set_pd(from[i[3]], from[i[2]], from[i[1]], from[i[0]]);
    const __m256d high = _mm256_set_pd(from[i[7]], from[i[6]], from[i[5]], from[i[4]]);
    return (Lanes)_mm512_insertf64x4(_mm512_castpd256_pd512(low), high, 1);
#else
    return Lanes{from[i[0]], from[i[1]], from[i[2]], from[i[3]], from[i[4]], from[i[5]], from[i[6]], from[i[7]]};
#endif
}

inline Lanes loaded(const double *from) {
    Lanes found;
    __builtin_memcpy(&found, from, sizeof found);
    return found;
}

inline Lanes root(Lanes of) {
#ifdef __AVX512F__
    return (Lanes)_mm512_sqrt_pd((__m512d)of);
#else
    Lanes found;
    for (int k = 0; k < WIDTH; k++) found[k] = std::sqrt(of[k]);
    return found;
#endif
}

inline void add_cross(Three &sum, const Three &a, const Three &b) {
    sum.x += a.y * b.z - a.z * b.y, sum.y += a.z * b.x - a.x * b.z, sum.z += a.x * b.y - a.y * b.x;
}

inline Three way_to(const int *ring, const double *place, long n, const Three &at) {
    return {gathered(place, ring) - at.x, gathered(place + n, ring) - at.y, gathered(place + 2 * n, ring) - at.z};
}

inline void add_spring(Three &pull, const Three &way, Lanes rest_length, double stiffness) {
    const Lanes length = root(way.x * way.x + way.y * way.y + way.z * way.z);
    const Lanes share = stiffness * (length - rest_length) / length;
    pull.x += share * way.x, pull.y += share * way.y, pull.z += share * way.z;
}

// Rows of three times `n`, from `own` on; no more than are used.
inline void store(const Three &what, double *rows, long n, int own, int used) {
    const Lanes *three[] = {&what.x, &what.y, &what.z};
    for (int c = 0; c < 3; c++) {
        if (used == WIDTH) __builtin_memcpy(rows + c * n + own, three[c], sizeof(Lanes));
        else for (int k = 0; k < used; k++) rows[c * n + own + k] = (*three[c])[k];
    }
}

// Springs on each particle, the area of the triangles around it, and the volume; rows of n: x, y, z.
double sums(const Body &body, const double *place, double *spring, double *area) {
    const long n = body.particles;
    Lanes volume{};
    double rest = 0.0;
    for (long block = 0; block < body.blocks; block++) {
        const int own = body.own[block], used = body.used[block], degree = body.degree[block];
        const int *ring = body.ring + WIDTH * body.first[block];
        const double *length = body.rest_length + WIDTH * body.first[block];
        const Three at{loaded(place + own), loaded(place + n + own), loaded(place + 2 * n + own)};
        Three pull{}, around{};
        const Three first = way_to(ring, place, n, at);
        Three before = first;
        add_spring(pull, first, loaded(length), body.stiffness);
        for (int k = 1; k < degree; k++) {
            ring += WIDTH, length += WIDTH;
            const Three way = way_to(ring, place, n, at);
            add_spring(pull, way, loaded(length), body.stiffness);
            add_cross(around, before, way);
            before = way;
        }
        add_cross(around, before, first);
        const Lanes wedge = at.x * around.x + at.y * around.y + at.z * around.z;
        store(pull, spring, n, own, used), store(around, area, n, own, used);
        if (used == WIDTH) volume += wedge;
        else for (int k = 0; k < used; k++) rest += wedge[k];
    }
    for (int k = 0; k < WIDTH; k++) rest += volume[k];
    return rest / 18.0;
}

}  // namespace

extern "C" void ring_steps(double *x, double *v, long particles, const int *degree,
                           const int *first, const int *own, const int *used, long blocks, const int *ring,
                           const double *rest_length, double stiffness, double gas, double inverse_mass,
                           double gravity, double h, long steps, double *work) {
    const Body body{particles, blocks,      degree,    first, own,          used,
                    ring,      rest_length, stiffness, gas,   inverse_mass, gravity};
    const long n = 3 * particles;
    double *spring = work, *area = work + n, *stage = work + 2 * n, *total = work + 3 * n;
    for (long step = 0; step < steps; step++) {
        for (int k = 0; k < 4; k++) {
            const double share = gas / sums(body, k == 0 ? x : stage, spring, area) / 6.0;
            const double lead = k == 2 ? h : 0.5 * h, weight = k == 1 || k == 2 ? 2.0 : 1.0, kept = k == 0 ? 0.0 : 1.0;
            for (int c = 0; c < 3; c++) {
                const long from = c * particles, end = from + particles;
                const double g = c == 2 ? gravity : 0.0;
                if (k < 3) {
#pragma GCC ivdep
                    for (long i = from; i < end; i++) {
                        const double a = (spring[i] + share * area[i]) * inverse_mass + g;
                        total[i] = kept * total[i] + weight * a;
                        stage[i] = x[i] + lead * (v[i] + lead * a);
                    }
                } else {
#pragma GCC ivdep
                    for (long i = from; i < end; i++) {
                        const double a = (spring[i] + share * area[i]) * inverse_mass + g;
                        v[i] += h / 6.0 * (total[i] + a);
                        x[i] += h * v[i];
                    }
                }
            }
        }
    }
}
