"""Soft balls of several stiffnesses are dropped on the ground."""

from __future__ import annotations

from collections.abc import Sequence

from softbody.errors import ParameterError
from softbody.mesh.mesh import icosphere
from softbody.model.validation import NO_NUMBERS, check_range, doubles, shown
from softbody.scenes.world_to_fill import world_to_fill
from softbody.world import World


def build(
    stiffnesses: Sequence[float] = (100.0, 400.0, 1600.0),
    height: float = 1.0,
    subdivisions: int = 3,
    world: World | None = None,
) -> World:
    """Return `world`, or a new one, with a ball for each of `stiffnesses` [N/m], side by side, `height` [m] up.

    Each has 10·4ˢ + 2 particles, weighs 1 kg, and its gas is in proportion to its springs: all have the same shape.
    """
    height = check_range(height, "height", "m", least=0.0)
    world = world_to_fill(world)
    world.add_ground()
    ball = icosphere(subdivisions, radius=0.5)
    try:
        springs = doubles(stiffnesses).ravel().tolist()
    except NO_NUMBERS as error:
        raise ParameterError(f"stiffnesses is {shown(stiffnesses)}; give a number for each ball [N/m]") from error
    for k, stiffness in enumerate(springs):
        place = (1.4 * (k - 0.5 * (len(springs) - 1)), 0.0, 0.5 + height)
        world.add_soft_body(ball, mass=1.0, stiffness=stiffness, gas=0.15 * stiffness, position=place)
    return world
