"""The world that a scene is built in."""

from __future__ import annotations

from softbody.errors import ParameterError
from softbody.model.validation import shown
from softbody.world import World


def world_to_fill(world: World | None) -> World:
    """Return a world that a scene is to be built in: the one given, or a new one; raises ParameterError."""
    if not isinstance(world, (World, type(None))):
        raise ParameterError(f"world is {shown(world)}; give a softbody.World, or none for a new one")
    return World() if world is None else world
