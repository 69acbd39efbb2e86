"""MuJoCo as a peer: a flex of lines, which is springs without gas, one force a step, float64, one thread."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from benchmarks.peers import GRAVITY, MASS, STIFFNESS
from softbody import Mesh


def mujoco_stepping(mesh: Mesh, h: float, steps: int, velocity: ArrayLike = 0.0) -> Callable[[], np.ndarray]:
    """Return a call that steps the mesh by symplectic Euler, from `velocity` (n, 3); it returns the positions."""

    def text(rows: np.ndarray) -> str:
        return " ".join(map(repr, rows.ravel().tolist()))

    model = mujoco.MjModel.from_xml_string(f"""
        <mujoco>
          <option timestep="{h!r}" gravity="0 0 {GRAVITY}" integrator="Euler">
            <flag contact="disable" constraint="disable" eulerdamp="disable"/>
          </option>
          <worldbody>
            <flexcomp name="body" type="direct" dim="1" mass="{MASS}" radius="1e-3"
                      point="{text(mesh.vertices)}" element="{text(mesh.edges)}">
              <contact selfcollide="none" contype="0" conaffinity="0"/>
              <edge stiffness="{STIFFNESS}"/>
            </flexcomp>
          </worldbody>
        </mujoco>""")
    data = mujoco.MjData(model)
    data.qvel.reshape(-1, 3)[:] = velocity

    def call() -> np.ndarray:
        mujoco.mj_step(model, data, nstep=steps)
        return mesh.vertices + data.qpos.reshape(-1, 3)

    return call
