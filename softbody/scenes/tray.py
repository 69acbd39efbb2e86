"""Soft balls fall into an open tray."""

from __future__ import annotations

from math import ceil, sqrt

import numpy as np

from softbody.mesh.mesh import icosphere
from softbody.model.validation import check_whole
from softbody.scenes.world_to_fill import world_to_fill
from softbody.world import World

RADIUS = 0.5  # [m] of each ball
SPACING = 1.15  # [m] between centres at the start
LAYERS = 2  # the tray is as wide as this many layers of balls ask for
WALL, HEIGHT = 0.3, 1.6  # [m] thickness and height of the walls


def build(bodies: int = 30, world: World | None = None) -> World:
    """Return `world`, or a new one, with `bodies` balls of 162 particles above a tray of four static walls.

    Loose layers, in which each ball is a little aside from the one below, so that none stands on another's top.
    """
    bodies = check_whole(bodies, "bodies", 1)
    world = world_to_fill(world)
    world.add_ground()
    side = ceil(sqrt(bodies / LAYERS))
    inner = SPACING * side
    for sign in (-0.5, 0.5):
        place = sign * (inner + WALL)
        world.add_box((WALL, inner + 2.0 * WALL, HEIGHT), None, (place, 0.0, 0.5 * HEIGHT))
        world.add_box((inner, WALL, HEIGHT), None, (0.0, place, 0.5 * HEIGHT))
    ball = icosphere(2, RADIUS)
    for k, aside in enumerate(np.random.default_rng(2008).uniform(-0.06, 0.06, (bodies, 2))):
        x, y, z = k % side, k // side % side, k // side**2
        corner = np.array([x - 0.5 * (side - 1), y - 0.5 * (side - 1), z + 1.0])
        position = SPACING * corner + np.append(aside, 0.0)
        world.add_soft_body(ball, mass=1.0, stiffness=120.0, gas=20.0, position=position)
    return world
