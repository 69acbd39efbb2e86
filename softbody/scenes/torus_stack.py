"""Scene 4: a stack of equal soft bodies; paper §9."""

from __future__ import annotations

from softbody.mesh.mesh import torus
from softbody.model.validation import check_whole
from softbody.scenes.world_to_fill import world_to_fill
from softbody.world import World

DRAG = 2.0  # [1/s] so that the bounce of the stack, which springs and gas alone would keep up for minutes, ends in 4 s


def build(bodies: int = 4, world: World | None = None) -> World:
    """Return `world`, or a new one, with `bodies` tori, copies of one mesh, one above the other."""
    bodies = check_whole(bodies, "bodies", 1)
    world = world_to_fill(world)
    world.add_ground()
    ring = torus(1.0, 0.4, 24, 12)
    for k in range(bodies):
        position = (0.0, 0.0, 0.45 + 0.85 * k)
        world.add_soft_body(ring, mass=1.0, stiffness=400.0, gas=120.0, position=position, drag=DRAG)
    return world
