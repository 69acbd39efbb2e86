"""Scene 3: rigid cubes fall on a soft torus; paper §9."""

from __future__ import annotations

import numpy as np

from softbody.mesh.mesh import torus
from softbody.model.validation import check_whole
from softbody.scenes.world_to_fill import world_to_fill
from softbody.world import World

LARGEST, SMALLER = 1.0, 0.75  # [m] side of the lowest cube, and that of each other one, of the one below
DENSITY = 0.4  # [kg/m³]: three cubes weigh a third of what the torus does
GAP = 0.2  # [m] between them at the start


def build(boxes: int = 3, world: World | None = None) -> World:
    """Return `world`, or a new one, with a torus, and above its hole a tower of `boxes` cubes.

    Each is smaller than the one below, and turned by 45° from it. The lowest is wider across its corners than the hole
    of the torus (1.2 m), so that the torus carries all.
    """
    boxes = check_whole(boxes, "boxes", 0)
    world = world_to_fill(world)
    world.add_ground()
    world.add_soft_body(
        torus(1.0, 0.4, 36, 18), mass=2.0, stiffness=600.0, gas=200.0, position=(0.0, 0.0, 0.45), friction=0.8
    )
    base = 0.85  # [m] the top of the torus
    for k in range(boxes):
        side, half_turn = LARGEST * SMALLER**k, 0.125 * np.pi * k
        base += GAP
        turn = (np.cos(half_turn), 0.0, 0.0, np.sin(half_turn))
        world.add_box((side, side, side), DENSITY * side**3, (0.0, 0.0, base + 0.5 * side), turn, friction=0.8)
        base += side
    return world
