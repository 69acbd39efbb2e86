"""Scene 1: a soft sphere comes to rest on a soft torus; paper §9."""

from __future__ import annotations

from softbody.mesh import icosphere, torus
from softbody.world import World


def build(subdivisions: int = 3, world: World | None = None) -> World:
    """Return `world`, or a new one, with a torus of 36 × 18 particles, and above it a sphere of 10·4ˢ + 2."""
    world = World() if world is None else world
    world.add_ground()
    world.add_soft_body(torus(1.0, 0.4, 36, 18), mass=2.0, stiffness=400.0, gas=150.0, position=(0.0, 0.0, 0.45))
    ball = icosphere(subdivisions, radius=0.6)
    world.add_soft_body(ball, mass=1.0, stiffness=300.0, gas=60.0, position=(0.0, 0.0, 1.4))
    return world
