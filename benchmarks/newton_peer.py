"""Newton as a peer, where somebody has installed it: springs without gas, one force a step, float32.

It runs on Warp, whose kernels on a CPU keep to one thread.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from benchmarks.peers import GRAVITY, MASS, STIFFNESS
from softbody import Mesh

try:
    import newton
    import warp
except ImportError:
    newton = None
else:
    warp.config.quiet = True


def newton_stepping(mesh: Mesh, h: float, steps: int, velocity: ArrayLike = 0.0) -> Callable[[], np.ndarray]:
    """Return a call that steps the mesh by symplectic Euler, from `velocity` (n, 3); it returns the positions."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, GRAVITY))
    n = len(mesh.vertices)
    builder.add_particles(mesh.vertices.tolist(), np.broadcast_to(velocity, (n, 3)).tolist(), [MASS / n] * n)
    for i, j in mesh.edges.tolist():
        builder.add_spring(i, j, STIFFNESS, 0.0, 0.0)
    model = builder.finalize(device="cpu")
    model.particle_grid = None  # of contacts between particles
    solver = newton.solvers.SolverSemiImplicit(model, enable_tri_contact=False)
    now, then, control = model.state(), model.state(), model.control(clone_variables=False)

    def call() -> np.ndarray:
        nonlocal now, then
        for _ in range(steps):
            now.clear_forces()
            solver.step(now, then, control, None, h)
            now, then = then, now
        return now.particle_q.numpy()

    return call
