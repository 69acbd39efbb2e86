"""Warp as a peer, where somebody has installed it: the same method, a kernel for every loop, atomics to scatter.

Warp's kernels on a CPU run on the thread that launches them, and on no other.
"""

# No postponed annotations here: Warp reads those of a kernel when it is made, inside a function.
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.peers import GAS, GRAVITY, MASS, STIFFNESS
from softbody import Mesh

try:
    import warp
except ImportError:
    warp = None
else:
    warp.config.quiet = True


def warp_stepping(mesh: Mesh, h: float, steps: int, precision: str) -> Callable[[], Any]:
    """Return a call that steps the mesh by the paper's integrator; it returns the array of positions.

    `precision` is "float32" or "float64". Launches are recorded once and played back, which is cheaper than launching.
    """
    wp = warp
    real = getattr(wp, precision)
    vec = wp.types.vector(3, real)
    vectors, reals = wp.array(dtype=vec), wp.array(dtype=real)
    indices = wp.array2d(dtype=wp.int32)
    sixth = real(1.0 / 6.0)

    @wp.kernel(module="unique")
    def add_springs(x: vectors, edge: indices, rest_length: reals, stiffness: real, force: vectors):
        s = wp.tid()
        d = x[edge[s, 1]] - x[edge[s, 0]]
        length = wp.length(d)
        pull = stiffness * (length - rest_length[s]) / length * d
        wp.atomic_add(force, edge[s, 0], pull)
        wp.atomic_sub(force, edge[s, 1], pull)

    @wp.kernel(module="unique")
    def add_volume(x: vectors, corner: indices, volume: reals):
        s = wp.tid()
        wp.atomic_add(volume, 0, sixth * wp.dot(x[corner[s, 0]], wp.cross(x[corner[s, 1]], x[corner[s, 2]])))

    @wp.kernel(module="unique")
    def add_gas(x: vectors, corner: indices, volume: reals, gas: real, force: vectors):
        s = wp.tid()
        a = x[corner[s, 0]]
        push = sixth * gas / volume[0] * wp.cross(x[corner[s, 1]] - a, x[corner[s, 2]] - a)
        for k in range(3):
            wp.atomic_add(force, corner[s, k], push)

    @wp.kernel(module="unique")
    def take_stage(
        x: vectors, v: vectors, force: vectors, inverse_mass: real, g: vec, lead: real, weight: real,
        total: vectors, stage: vectors,
    ):  # fmt: skip
        i = wp.tid()
        a = force[i] * inverse_mass + g
        total[i] += weight * a
        stage[i] = x[i] + lead * (v[i] + lead * a)

    @wp.kernel(module="unique")
    def take_step(x: vectors, v: vectors, force: vectors, inverse_mass: real, g: vec, h: real, total: vectors):
        i = wp.tid()
        v[i] += h * sixth * (total[i] + force[i] * inverse_mass + g)
        x[i] += h * v[i]

    n, e, t = len(mesh.vertices), len(mesh.edges), len(mesh.triangles)
    i, j = mesh.edges.T
    lengths = np.linalg.norm(mesh.vertices[j] - mesh.vertices[i], axis=1)
    with wp.ScopedDevice("cpu"):
        x = wp.array(mesh.vertices.astype(precision), dtype=vec)
        v, force, total, stage = (wp.zeros(n, dtype=vec) for _ in range(4))
        volume, rest_length = wp.zeros(1, dtype=real), wp.array(lengths.astype(precision))
        edge, corner = wp.array(mesh.edges.astype(np.int32)), wp.array(mesh.triangles.astype(np.int32))
        load, g = n / MASS, vec(0.0, 0.0, GRAVITY)

        def recorded(kernel: Any, dim: int, *inputs: Any) -> Callable[[], None]:
            return wp.launch(kernel, dim, list(inputs), record_cmd=True).launch

        orders: list[Callable[[], Any]] = []
        for here, lead, weight in ((x, 0.5 * h, 1.0), (stage, 0.5 * h, 2.0), (stage, h, 2.0), (stage, 0.0, 0.0)):
            orders += [
                force.zero_,
                volume.zero_,
                recorded(add_springs, e, here, edge, rest_length, STIFFNESS, force),
                recorded(add_volume, t, here, corner, volume),
                recorded(add_gas, t, here, corner, volume, GAS, force),
            ]
            if weight:
                orders.append(recorded(take_stage, n, x, v, force, load, g, lead, weight, total, stage))
        orders += [recorded(take_step, n, x, v, force, load, g, h, total), total.zero_]

    def call() -> Any:
        for _ in range(steps):
            for order in orders:
                order()
        return x

    return call
