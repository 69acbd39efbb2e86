"""MuJoCo as a peer: a flex of lines, which is springs without gas, one force a step, float64, one thread."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from benchmarks.peers import GRAVITY, MASS, STIFFNESS
from references.mujoco_flex import flex_of_lines
from softbody import Mesh


def mujoco_stepping(mesh: Mesh, h: float, steps: int, velocity: ArrayLike = 0.0) -> Callable[[], np.ndarray]:
    """Return a call that steps the mesh by symplectic Euler, from `velocity` (n, 3); it returns the positions."""
    model = flex_of_lines(mesh.vertices, mesh.edges, STIFFNESS, 0.0, MASS, GRAVITY, h)
    data = mujoco.MjData(model)
    data.qvel.reshape(-1, 3)[:] = velocity

    def call() -> np.ndarray:
        mujoco.mj_step(model, data, nstep=steps)
        return mesh.vertices + data.qpos.reshape(-1, 3)

    return call
