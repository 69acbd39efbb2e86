"""Balls full of liquids of three densities, or of gas alone: some lie on the ground, some hang."""

from __future__ import annotations

import numpy as np

from softbody.mesh.mesh import icosphere
from softbody.scenes.world_to_fill import world_to_fill
from softbody.world import World

DENSITIES = (0.0, 300.0, 600.0, 1000.0)  # [kg/m³] of what is in each
RADIUS = 0.4  # [m]
SKIN = 3.0  # [kg]
SPACING = 1.2  # [m]
PINS = 12  # particles, the highest, on which one hangs


def build(world: World | None = None) -> World:
    """Return `world`, or a new one, with four balls above the ground, and four that hang."""
    world = world_to_fill(world)
    world.add_ground()
    ball = icosphere(2, RADIUS)
    highest = np.argsort(-ball.vertices[:, 2], kind="stable")[:PINS]
    for k, density in enumerate(DENSITIES):
        x, gas = SPACING * (k - 1.5), 6e3 * ball.volume
        for way, y, z, fixed in (("lies", 0.0, 1.05 * RADIUS, ()), ("hangs", 1.2, 1.6, highest)):
            name = f"{density:.0f} kg/m³, {way}"
            full = {"drag": 2.0, "liquid_density": density}
            world.add_soft_body(ball, SKIN, 6e3, gas, (x, y, z), fixed=fixed, name=name, **full)
    return world
