"""Worlds put back to where they were, so that every round does the same work."""

from __future__ import annotations

from collections.abc import Callable

from softbody import World
from softbody.collision.contact import ImpulseCache, remembered, remembering


def putting_back(world: World) -> Callable[[], None]:
    """Return a function that puts a world back to where it is now, with the impulses that the next step starts from."""
    start, room = world.state.copy(), len(world.store.contacts.depth)
    cache = ImpulseCache(*(rows.copy() for rows in remembered(world.store.contacts)))

    def restore() -> None:
        for now, then in zip(world.state, start, strict=True):
            now[:] = then
        world.store.contacts = remembering(cache, room)

    return restore
