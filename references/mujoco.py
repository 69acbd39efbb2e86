"""Impacts by MuJoCo's mass matrix and Jacobian, and the rotation of a free box.

MuJoCo's own contact is a soft constraint, and so is not asked. Inertia of the boxes, orientation, the frames of the
velocities and the Jacobian of a point are all MuJoCo's; Newton's law is one line of algebra on top.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from references.analytic import Velocities, rotation_matrix

PACKAGES = {"mujoco": "mujoco"}  # import name, and the name to install it by
KIND = "third-party engine"  # of judge
SETTINGS = {  # what was chosen against the defaults, and why
    "gravity 0, contacts off": "an impact is asked about alone",
    "integrator RK4 for the rotation (Euler)": "the default is of first order",
}


def box_impact(*case: ArrayLike) -> Velocities:
    """Return the velocities after m frictionless impacts at one point each; arguments of `analytic.box_impact`."""
    arrays = [np.asarray(x, float) for x in case]
    *bodies, point, normal, restitution = arrays
    count = len(point)
    e = np.broadcast_to(restitution, (count,))
    after = np.zeros((count, 4, 3))
    for i in range(count):
        a, b = [x[i] for x in bodies[:6]], [x[i] for x in bodies[6:]]
        after[i] = _one_impact(a, b, point[i], normal[i], float(e[i]))
    return Velocities(after[:, 0], after[:, 1], after[:, 2], after[:, 3])


def _one_impact(
    a: list[np.ndarray], b: list[np.ndarray], point: np.ndarray, normal: np.ndarray, e: float
) -> np.ndarray:
    model = _model([a, b])
    data = mujoco.MjData(model)
    rows = _place(data, [a, b])
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, mass, data.qM) if hasattr(data, "qM") else mujoco.mj_fullM(model, data, mass)
    jacobian = np.zeros(model.nv)
    for body, sign in ((1, 1.0), (2, -1.0)):
        of_point = np.zeros((3, model.nv))
        mujoco.mj_jac(model, data, of_point, None, point, body)
        jacobian += sign * normal @ of_point
    speed = jacobian @ data.qvel
    if speed < 0.0:
        spread = np.linalg.solve(mass, jacobian)
        data.qvel += -(1.0 + e) * speed / (jacobian @ spread) * spread
    result = np.zeros((4, 3))
    for k, (box, row) in enumerate(zip((a, b), rows)):
        if row is not None:
            result[2 * k] = data.qvel[row : row + 3]
            result[2 * k + 1] = rotation_matrix(box[3]) @ data.qvel[row + 3 : row + 6]
    return result


def free_rotation(
    size: ArrayLike, mass: float, orientation: ArrayLike, angular_velocity: ArrayLike, seconds: float, step: float
) -> np.ndarray:
    """Return the rotation matrix (3, 3) of a free box after `seconds` [s] of MuJoCo's RK4 with `step` [s]."""
    zeros = np.zeros(3)
    box = [np.asarray(size, float), np.asarray(mass), zeros, np.asarray(orientation, float), zeros]
    box.append(np.asarray(angular_velocity, float))
    model = _model([box])
    model.opt.timestep = step
    data = mujoco.MjData(model)
    _place(data, [box])
    for _ in range(round(seconds / step)):
        mujoco.mj_step(model, data)
    return rotation_matrix(data.qpos[3:7])


def _model(boxes: list[list[np.ndarray]]) -> mujoco.MjModel:
    bodies = []
    for size, mass, position, orientation, _, _ in boxes:
        half = " ".join(repr(float(x)) for x in 0.5 * size)
        free = np.isfinite(mass)
        pose = "" if free else f'pos="{_text(position)}" quat="{_text(orientation)}"'
        joint = "<freejoint/>" if free else ""
        kilogram = f'mass="{float(mass)!r}"' if free else ""
        bodies.append(f'<body {pose}>{joint}<geom type="box" size="{half}" {kilogram}/></body>')
    return mujoco.MjModel.from_xml_string(
        '<mujoco><option gravity="0 0 0" integrator="RK4"><flag contact="disable"/></option>'
        f"<worldbody>{''.join(bodies)}</worldbody></mujoco>"
    )


def _text(numbers: np.ndarray) -> str:
    return " ".join(repr(float(x)) for x in numbers)


def _place(data: mujoco.MjData, boxes: list[list[np.ndarray]]) -> list[int | None]:
    """Set poses and velocities; return where each box's six velocities begin. MuJoCo's ω is in the body's frame."""
    rows: list[int | None] = []
    q = v = 0
    for _, mass, position, orientation, velocity, spin in boxes:
        if not np.isfinite(mass):
            rows.append(None)
            continue
        data.qpos[q : q + 7] = [*position, *orientation]
        data.qvel[v : v + 6] = [*velocity, *(rotation_matrix(orientation).T @ spin)]
        rows.append(v)
        q, v = q + 7, v + 6
    return rows
