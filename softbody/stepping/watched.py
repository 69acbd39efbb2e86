"""A body alone that holds itself is moved by many steps at once, while it is watched: from where to where."""

from __future__ import annotations

from math import inf

from softbody.collision.soft.skin import HEIGHTS, Skin, is_seen_whole
from softbody.collision.soft.surface import Surfaces
from softbody.compiler.jit import jit, jit_lean
from softbody.dynamics.watch import Watch
from softbody.linalg.vec import load, store
from softbody.model.arrays import Model, State


@jit
def give_room(model: Model, state: State, surfaces: Surfaces | None, skin: Skin | None, watch: Watch) -> bool:
    """Let the only body be watched, and tell whether nothing of it is near itself. Without a skin all may be."""
    if surfaces is None or skin is None:
        return True
    skin.is_listed[0] = skin.begins_whole[0] = False
    is_whole = is_seen_whole(model, surfaces, skin, 0, state)
    if is_whole:
        watch.room[0], watch.height[0] = skin.room[0], HEIGHTS * skin.distance[0]
    return is_whole


@jit_lean
def take_room(skin: Skin | None, watch: Watch, steps: int, has_left: bool) -> None:
    """Note what was seen of the only body in so many `steps`, after which it leaves its room or not."""
    if skin is not None:
        if watch.room[0] < inf:
            skin.room[0], watch.room[0] = watch.room[0], inf
        if has_left:
            skin.room[0] = -1.0
        skin.pause[0] = max(0, skin.pause[0] - steps)


@jit
def note_places(skin: Skin | None, state: State) -> None:
    """Note where particles are, and how fast, so that a step can be undone."""
    if skin is not None:
        for i in range(skin.place.shape[0]):
            store(skin.place, i, load(state.particle_position, i))
            store(skin.speed, i, load(state.particle_velocity, i))


@jit
def stays_whole(model: Model, state: State, surfaces: Surfaces | None, skin: Skin | None) -> bool:
    """Tell whether a step has left the only body so that nothing of it is near itself; if not, undo the step."""
    if surfaces is None or skin is None or is_seen_whole(model, surfaces, skin, 0, state):
        return True
    for i in range(skin.place.shape[0]):
        store(state.particle_position, i, load(skin.place, i))
        store(state.particle_velocity, i, load(skin.speed, i))
    return False
