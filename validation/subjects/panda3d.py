"""Bullet's soft body with gas, by way of Panda3D (single precision)."""

from __future__ import annotations

from references import panda3d
from validation.effort import finer
from validation.subject import GasBody

PACKAGES = {"panda3d": "panda3d"}  # import name, and the name to install it by
SETTINGS = {  # what was chosen against the defaults, and why
    "steps of ωh = 0.2 and 0.1, extrapolated": "what serves solids best; single precision is left, more below 0.1"
}
PRECISION = "single"
CANNOT = {  # question → why it has no answer
    "move_boxes": "its adapter does not ask it so far: pybullet has the same boxes in double precision",
    "boxes_overlap": "its adapter does not ask it so far",
    "points_in_mesh": "its meshes are surfaces, and have no inside",
    "move_soft": "its links pull as springs do in one shape only, which its adapter chooses for regular solids",
}

PHASE = 0.2  # [rad] of the breathing in a step


def gas_volume(body: GasBody) -> float:
    """Return the volume at rest."""
    return panda3d.volume_at_rest(body.vertices, body.edges, body.triangles, body.stiffness, body.gas, PHASE / finer())


def gas_period(body: GasBody, swing: float) -> float:
    """Return the time of a breath."""
    shape = body.vertices, body.edges, body.triangles
    return panda3d.breathing_period(*shape, body.stiffness, body.gas, body.mass, swing, PHASE / finer())
