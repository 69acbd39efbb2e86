"""MuJoCo's boxes, whose contacts are springs with damping (double precision)."""

from __future__ import annotations

import mujoco
import numpy as np

from references.analytic import rotation_matrix
from validation.effort import iterations
from validation.subject import Boxes, Motion, moving

PACKAGES = {"mujoco": "mujoco"}  # import name, and the name to install it by
SETTINGS = {  # what was chosen against the defaults, and why
    "integrator RK4 (Euler)": "a box that tumbles keeps its angular momentum to 5e-9 so, to 8e-2 by the implicit ones",
    "contacts swing at 1/2 rad a step, damped as restitution asks (solref)": (
        "MuJoCo has no restitution: it is what a damped spring gives back. Softer contacts are too deep, stiffer ones"
        " wrong by more"
    ),
    "a contact takes 0.999 of what is asked (solimp, 0.9 to 0.95)": "it gives in less: steps are small",
    "elliptic cones, impratio 10 (pyramids, 1)": "Coulomb's cone; boxes that are held by friction creep less",
    "a held box that moves weighs 1e5 kg, and is carried (gravcomp)": (
        "bodies without a joint have no speed in contacts; ones heavier by 1e4 carry worse"
    ),
}
CANNOT = {  # question → why it has no answer
    "gas_volume": "its soft bodies are elastic throughout, or shells, and have no gas",
    "gas_period": "its soft bodies are elastic throughout, or shells, and have no gas",
    "points_in_mesh": "its meshes collide as their convex hulls, and are asked no points",
    "move_soft": "its soft bodies are elastic throughout, or shells, and have no gas",
}

HEAVY = 1e5  # [kg]
SWING = 0.5  # [rad] of a contact in a step
FAR = 1e3  # [m] apart, and farther, boxes count as so far apart


def move_boxes(boxes: Boxes, step: float, steps: int, every: int) -> Motion:
    """Let boxes move."""
    model = mujoco.MjModel.from_xml_string(_scene(boxes, step))
    data = mujoco.MjData(model)
    places = [int(model.jnt_dofadr[joint]) if joint >= 0 else None for joint in model.body_jntadr[1:]]
    for place, box in zip(places, boxes.rows()):
        if place is not None:
            *_, orientation, velocity, spin = box
            data.qvel[place : place + 6] = [*velocity, *(rotation_matrix(orientation).T @ spin)]

    def now() -> tuple[np.ndarray, ...]:
        mujoco.mj_kinematics(model, data)
        speeds = np.zeros((len(places), 6))
        for row, place, turn in zip(speeds, places, data.xmat[1:].reshape(-1, 3, 3)):
            if place is not None:
                row[:] = [*data.qvel[place : place + 3], *(turn @ data.qvel[place + 3 : place + 6])]
        return data.xpos[1:], data.xquat[1:], speeds[:, :3], speeds[:, 3:]

    return moving(now, lambda count: mujoco.mj_step(model, data, nstep=count), steps, every)


def boxes_overlap(*pairs: np.ndarray) -> np.ndarray:
    """Tell whether boxes overlap: whether MuJoCo's distance of them is 0 or less."""
    geoms = '<geom type="box" size="1 1 1"/>' * 2
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{geoms}</worldbody></mujoco>")
    data, found = mujoco.MjData(model), []
    for pair in zip(*pairs):
        for geom, (size, position, orientation) in enumerate((pair[:3], pair[3:])):
            model.geom_size[geom] = 0.5 * size
            data.geom_xpos[geom] = position
            data.geom_xmat[geom] = rotation_matrix(orientation).ravel()
        found.append(mujoco.mj_geomDistance(model, data, 0, 1, FAR, None) <= 0.0)
    return np.array(found)


def _scene(boxes: Boxes, step: float) -> str:
    """Return boxes in MuJoCo's own language."""
    swing, loss = SWING / step, -np.log(np.clip(boxes.restitution, 1e-9, 1.0))
    damped = loss / np.hypot(np.pi, loss) if boxes.restitution > 0.0 else 1.0
    bodies = []
    for size, mass, position, orientation, velocity, spin in boxes.rows():
        held, moves = bool(np.isinf(mass)), bool(np.any(velocity) or np.any(spin))
        joint = "" if held and not moves else "<freejoint/>"
        kilogram = f'mass="{HEAVY if held else float(mass)!r}"' if joint else ""
        pose = f'pos="{_text(position)}" quat="{_text(orientation)}" gravcomp="{int(held)}"'
        bodies.append(f'<body {pose}>{joint}<geom size="{_text(0.5 * size)}" {kilogram}/></body>')
    return f"""
        <mujoco>
          <option timestep="{step!r}" gravity="0 0 {-boxes.gravity!r}" integrator="RK4" cone="elliptic" impratio="10"
                  iterations="{iterations(100)}"/>
          <default>
            <geom type="box" condim="{3 if boxes.friction else 1}" friction="{boxes.friction!r} 0 0"
                  solref="{_text(np.array([-(swing**2), -2.0 * damped * swing]))}" solimp="0.999 0.999 0.001"/>
          </default>
          <worldbody>{"".join(bodies)}</worldbody>
        </mujoco>"""


def _text(numbers: np.ndarray) -> str:
    return " ".join(map(repr, numbers.tolist()))
