"""Boxes and balls of five densities in water: four float, higher or lower, and one sinks."""

from __future__ import annotations

import numpy as np

from softbody.mesh.mesh import icosphere
from softbody.scenes.world_to_fill import world_to_fill
from softbody.world import World

DENSITIES = (200.0, 400.0, 600.0, 800.0, 1300.0)  # [kg/m³] of what is as large as its mesh
SIZE = (0.6, 0.7, 0.4)  # [m] of each box
RADIUS = 0.3  # [m] of each ball
SPACING = 1.1  # [m] between them
DEPTH = 1.2  # [m] of the water


def build(world: World | None = None) -> World:
    """Return `world`, or a new one, with five boxes and five soft balls above water, whose surface is z = 0."""
    world = world_to_fill(world)
    world.add_ground(-DEPTH)
    world.add_liquid(1000.0, 0.0, drag=150.0)
    ball = icosphere(2, RADIUS)
    for k, density in enumerate(DENSITIES):
        x, tilt = SPACING * (k - 2), 0.3 + 0.1 * k
        turn = np.cos(0.5 * tilt), np.sin(0.5 * tilt), 0.0, 0.0
        world.add_box(SIZE, density * float(np.prod(SIZE)), (x, 0.6, 0.5), turn, name=f"box of {density:.0f} kg/m³")
        world.add_soft_body(ball, density * ball.volume, 3e4, 2e3, (x, -0.6, 0.5), name=f"ball of {density:.0f} kg/m³")
    return world
