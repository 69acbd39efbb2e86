"""Three bags of water, in which a box rises, hangs or sinks, and a ball of jelly, in which one is hung up."""

from __future__ import annotations

from softbody.mesh.mesh import icosphere
from softbody.scenes.world_to_fill import world_to_fill
from softbody.world import World

WATER = 1000.0  # [kg/m³]
DENSITIES = (200.0, 1005.0, 3000.0)  # [kg/m³] of the boxes in bags; a bag at rest is a little denser than water
RADIUS, EDGE = 0.4, 0.2  # [m]
SKIN, GAS = 3.0, 6e3  # [kg]; [Pa] in the jelly
SPACING = 1.0  # [m]
DRAG = 200.0  # [N s/m³]


def build(world: World | None = None) -> World:
    """Return `world`, or a new one, with three bags and a jelly above the ground."""
    world = world_to_fill(world)
    world.add_ground()
    ball, edges = icosphere(2, RADIUS), (EDGE, EDGE, EDGE)
    for k, density in enumerate(DENSITIES):
        place = (SPACING * (k - 1.5), 0.0, 1.05 * RADIUS)
        bag = world.add_soft_body(ball, SKIN, 6e3, 0.0, place, drag=2.0, liquid_density=WATER, liquid_drag=DRAG)
        world.add_box(edges, density * EDGE**3, place, inside=bag, name=f"{density:.0f} kg/m³")
    place = (SPACING * 1.5, 0.0, 2.0 * RADIUS)
    jelly = world.add_soft_body(ball, SKIN, 6e3, GAS * ball.volume, place, drag=2.0, name="jelly")
    marble = world.add_box(edges, SKIN, place, (0.8, 0.6, 0.0, 0.0), name="marble")
    world.suspend(marble, jelly)
    return world
