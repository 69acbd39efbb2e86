"""Rigid boxes are dropped in a heap."""

from __future__ import annotations

import numpy as np

from softbody.model.validation import check_whole
from softbody.scenes.world_to_fill import world_to_fill
from softbody.world import World

ACROSS = 1.3  # [m] between neighbours at the start, give or take 0.2: few boxes have so long a diagonal, none overlap


def build(boxes: int = 40, world: World | None = None) -> World:
    """Return `world`, or a new one, with `boxes` boxes of several sizes, each turned its own way, in layers.

    A layer holds 3 × 3 boxes, so that more of them make a higher heap; the same number falls the same way each time.
    """
    boxes = check_whole(boxes, "boxes", 1)
    world = world_to_fill(world)
    world.add_ground(friction=0.6)
    rng = np.random.default_rng(2008)
    for k in range(boxes):
        size = rng.uniform(0.35, 0.75, 3)
        turn = rng.normal(size=4)
        place = np.array([k % 3 - 1.0, k // 3 % 3 - 1.0, k // 9 + 0.6])
        position = ACROSS * place + rng.uniform(-0.1, 0.1, 3)
        world.add_box(size, 400.0 * size.prod(), position, turn / np.linalg.norm(turn), friction=0.6)
    return world
