"""Scene 1: a soft sphere comes to rest on a soft torus; paper §9."""

from __future__ import annotations

from softbody.mesh.mesh import icosphere, torus
from softbody.scenes.world_to_fill import world_to_fill
from softbody.world import World

RADIUS = 0.9  # [m] of the sphere; the hole's is 0.6 m, and the loaded sphere and torus both give by some centimetres


def build(subdivisions: int = 3, world: World | None = None) -> World:
    """Return `world`, or a new one, with a torus of 36 × 18 particles, and above it a sphere of 10·4ˢ + 2.

    The sphere (RADIUS) is so much wider than the hole that the torus carries it, well above the ground.
    """
    world = world_to_fill(world)
    world.add_ground()
    world.add_soft_body(torus(1.0, 0.4, 36, 18), mass=2.0, stiffness=400.0, gas=150.0, position=(0.0, 0.0, 0.45))
    ball = icosphere(subdivisions, RADIUS)
    world.add_soft_body(ball, mass=1.0, stiffness=300.0, gas=150.0, position=(0.0, 0.0, 1.7))
    return world
