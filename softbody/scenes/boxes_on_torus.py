"""Scene 3: rigid boxes fall on a soft torus; paper §9."""

from __future__ import annotations

from softbody.mesh import torus
from softbody.parameters import check_whole
from softbody.world import World


def build(boxes: int = 3, world: World | None = None) -> World:
    """Return `world`, or a new one, with a torus, and above its hole `boxes` planks, each across the one below."""
    check_whole(boxes, "boxes", 0)
    world = World() if world is None else world
    world.add_ground()
    world.add_soft_body(
        torus(1.0, 0.4, 36, 18), mass=2.0, stiffness=600.0, gas=200.0, position=(0.0, 0.0, 0.45), friction=0.8
    )
    for k in range(boxes):
        size = (2.2, 0.5, 0.2) if k % 2 == 0 else (0.5, 2.2, 0.2)
        world.add_box(size, mass=0.3, position=(0.0, 0.0, 1.1 + 0.35 * k), friction=0.8)
    return world
