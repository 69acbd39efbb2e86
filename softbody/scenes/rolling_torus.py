"""Scene 2: a soft torus on end balances and rolls under a constant force; paper §9."""

from __future__ import annotations

import numpy as np

from softbody.mesh.mesh import Mesh, torus
from softbody.model.validation import check_range
from softbody.scenes.world_to_fill import world_to_fill
from softbody.world import World


def build(force: float = 0.5, tilt: float = 0.0, world: World | None = None) -> World:
    """Return `world`, or a new one, with a torus whose axis is y, pushed along x by `force` times its weight.

    It has 36 × 18 particles; `tilt` [rad] leans it at the start. It rolls by friction. The paper has none (E21), and
    its torus could only slide; and a force too small lets it topple before it is as fast as a hoop must be to stay
    upright (v² > g R/3).
    """
    force = check_range(force, "force")
    tilt = check_range(tilt, "tilt", "rad")
    mass = 2.0
    world = world_to_fill(world)
    world.add_ground(friction=0.8)
    ring = torus(1.0, 0.4, 36, 18)
    # (x, y, z) → (x, −z, y) puts the axis along y; then lean about x.
    upright = np.column_stack([ring.vertices[:, 0], -ring.vertices[:, 2], ring.vertices[:, 1]])
    c, s = np.cos(tilt), np.sin(tilt)
    leaning = upright @ np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]).T
    body = world.add_soft_body(
        Mesh(leaning, ring.triangles),
        mass=mass,
        stiffness=400.0,
        gas=150.0,
        position=(0.0, 0.0, -leaning[:, 2].min()),
        friction=0.8,
    )
    body.external_force = (force * mass * float(np.linalg.norm(world.controls.gravity)) / len(leaning), 0.0, 0.0)
    return world
