"""Rigid boxes stand one on another."""

from __future__ import annotations

from softbody.model.validation import check_range, check_whole
from softbody.scenes.world_to_fill import world_to_fill
from softbody.world import World


def build(boxes: int = 8, gap: float = 0.05, world: World | None = None) -> World:
    """Return `world`, or a new one, with a tower of `boxes` plates, each a `gap` [m] above the one below.

    Every other plate lies across, and each is a little off the axis, by less than lets the tower lean.
    """
    boxes = check_whole(boxes, "boxes", 1)
    gap = check_range(gap, "gap", "m", least=0.0)
    world = world_to_fill(world)
    world.add_ground(friction=0.6)
    for k in range(boxes):
        size = (1.2, 0.8, 0.3) if k % 2 == 0 else (0.8, 1.2, 0.3)
        aside = 0.04 if k % 3 == 0 else -0.02  # the mean of every three is 0
        world.add_box(size, mass=1.0, position=(aside, -aside, 0.15 + gap + (0.3 + gap) * k), friction=0.6)
    return world
