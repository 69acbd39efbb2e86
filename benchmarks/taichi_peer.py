"""Taichi as a peer, where somebody has installed it: the same method, springs and gas scattered, on one thread."""

# No postponed annotations here: Taichi reads those of a function when it is made.
import os
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.peers import GAS, GRAVITY, MASS, STIFFNESS
from softbody import Mesh

os.environ.setdefault("ENABLE_TAICHI_HEADER_PRINT", "0")
try:
    import taichi
except ImportError:
    taichi = None
else:
    # A second init would drop the fields of the first.
    taichi.init(arch=taichi.cpu, default_fp=taichi.f64, cpu_max_num_threads=1, log_level=taichi.ERROR)


def taichi_stepping(mesh: Mesh, h: float, steps: int) -> Callable[[], Any]:
    """Return a call that steps the mesh by the paper's integrator in float64; it returns the field of positions.

    All steps run in one kernel, whose outer loop is serial: Taichi then needs neither launches nor atomics, and takes
    an eighth of the time at 10 242 particles of a kernel for every loop, its usual way.
    """
    ti = taichi
    n, e, t = len(mesh.vertices), len(mesh.edges), len(mesh.triangles)
    edge, corner = ti.Vector.field(2, ti.i32, e), ti.Vector.field(3, ti.i32, t)
    edge.from_numpy(mesh.edges.astype(np.int32))
    corner.from_numpy(mesh.triangles.astype(np.int32))
    rest_length = ti.field(ti.f64, e)
    rest_length.from_numpy(np.linalg.norm(mesh.vertices[mesh.edges[:, 1]] - mesh.vertices[mesh.edges[:, 0]], axis=1))
    position, velocity, stage, force, total = (ti.Vector.field(3, ti.f64, n) for _ in range(5))
    position.from_numpy(mesh.vertices)
    inverse_mass = n / MASS

    @ti.func
    def add_forces(x: ti.template()):
        for i in range(n):
            force[i] = ti.Vector([0.0, 0.0, 0.0])
        for s in range(e):
            d = x[edge[s][1]] - x[edge[s][0]]
            length = d.norm()
            pull = STIFFNESS * (length - rest_length[s]) / length * d
            force[edge[s][0]] += pull
            force[edge[s][1]] -= pull
        volume = 0.0
        for s in range(t):
            volume += x[corner[s][0]].dot(x[corner[s][1]].cross(x[corner[s][2]])) / 6.0
        for s in range(t):
            a = x[corner[s][0]]
            push = GAS / volume / 6.0 * (x[corner[s][1]] - a).cross(x[corner[s][2]] - a)
            for k in ti.static(range(3)):
                force[corner[s][k]] += push

    @ti.kernel
    def run():
        gravity = ti.Vector([0.0, 0.0, GRAVITY])
        ti.loop_config(serialize=True)
        for _ in range(steps):
            add_forces(position)
            for i in range(n):
                a = force[i] * inverse_mass + gravity
                total[i] = a
                stage[i] = position[i] + 0.5 * h * (velocity[i] + 0.5 * h * a)
            for lead in ti.static((0.5 * h, h)):
                add_forces(stage)
                for i in range(n):
                    a = force[i] * inverse_mass + gravity
                    total[i] += 2.0 * a
                    stage[i] = position[i] + lead * (velocity[i] + lead * a)
            add_forces(stage)
            for i in range(n):
                velocity[i] += h / 6.0 * (total[i] + force[i] * inverse_mass + gravity)
                position[i] += h * velocity[i]

    def call() -> Any:
        run()
        ti.sync()
        return position

    return call
