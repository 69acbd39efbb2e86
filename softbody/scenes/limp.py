"""Limp bodies that hold themselves: a ball with too little gas, a ring under a plate, an empty pillow over a rod."""

from __future__ import annotations

from softbody.mesh.mesh import box, icosphere, torus
from softbody.scenes.world_to_fill import world_to_fill
from softbody.world import World


def build(world: World | None = None) -> World:
    """Return `world`, or a new one, with three bodies that fold on to themselves.

    In a world with the paper's contacts, which know none of a body with itself, they go through themselves.
    """
    world = world_to_fill(world)
    world.add_ground()
    holds = not world.store.settings.single_soft_contact
    ball = icosphere(3, 0.5)
    world.add_soft_body(ball, 1.0, 12.0, 0.4, (-1.6, 0.0, 0.6), self_contact=holds, name="ball")
    ring = torus(0.6, 0.22, 36, 18)
    world.add_soft_body(ring, 1.0, 60.0, 0.3, (0.0, 0.0, 0.24), self_contact=holds, name="ring")
    world.add_box((1.1, 1.1, 0.1), 4.0, (0.0, 0.0, 0.7), name="plate")
    pillow = box((1.2, 0.8, 0.1), 8)
    world.add_soft_body(pillow, 0.5, 80.0, 0.0, (1.7, 0.0, 0.7), self_contact=holds, name="pillow")
    world.add_box((0.1, 1.4, 0.1), None, (1.75, 0.0, 0.5), name="rod")
    return world
