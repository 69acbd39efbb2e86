"""Soft bodies that hold themselves: what is known of their surfaces from step to step, and what a step asks of it.

A body that is seen whole from its middle, high above all its triangles, has nothing near itself, and is left alone
while no particle has moved far since that was seen. Of others there is a list of near features. How far each particle
has moved is counted, besides what all of a body move in common: features are listed anew where particles have moved
far, and distances measured where they may be short. None of this shows in the result: what touches is found from where
a step begins and ends, in an order of its own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.collision.contact import Contacts, fit, with_room
from softbody.collision.soft.guard import LEFT, cut_motion, give_back
from softbody.collision.soft.near_features import (
    NEW,
    Members,
    gap_at,
    has_new,
    least_gap,
    least_gap_of_all,
    list_all,
    list_near_features,
    members,
    most_of,
    sort_pairs,
)
from softbody.collision.soft.self_rows import add_self_contacts
from softbody.collision.soft.surface import Solid, Surface, Surfaces, build_surfaces, memory_at, surface_of, tree_at
from softbody.compiler.jit import jit, jit_lean
from softbody.geometry.affine_fit import fit_affine
from softbody.geometry.bvh import refit_bvh
from softbody.geometry.drift import drift
from softbody.geometry.self_intersections import self_intersections
from softbody.geometry.star import corners_of, room_of_vertices
from softbody.linalg.vec import load, norm, store, sub
from softbody.mesh.weld import first_at_place
from softbody.model.arrays import Model, State
from softbody.model.material import combined, material_of_soft
from softbody.model.sleep_state import SleepState, sleeps

# Distances of the skin by which the middle of a body must be above its triangles, so that only neighbours are near.
HEIGHTS = 3.0

# Within what distance features are listed: distances of the skin at least, altitudes of the lowest triangle at most, as
# many as may be while there are no more pairs than so many for each particle. And the part of that, beyond the skin's
# distance, by which a particle may move until its features are listed anew. Of two that are not on the list, one was
# listed last: since then both have moved, the other by twice as much at most.
LISTED, OF_ALTITUDE, FEW, ROOM = 4.0, 0.8, 12, 1.0 / 3.0

# The skin's distance: parts of the body's size, of its lowest altitude, and of the least distance of two features.
OF_SIZE, OF_LOWEST, OF_LEAST = 2e-3, 0.25, 0.5
SUSPECT = 0.5  # of what the mesh allows, below which it is looked at whether it meets itself

# The part of the least gap that particles may drift, so that no guard would cut such motion. The part of the lowest
# altitude that it must be to be of use. And for how many steps no gap is searched again, and if it was of no use.
OF_GAP, OF_ROOM, PAUSE, LONG_PAUSE = 0.35, 0.1, 8, 32

FIRST_PAIRS = 64

AS_LISTED, ANEW, NO_ROOM = 0, 1, 2


class Skin(NamedTuple):
    """Memory for the bodies that hold themselves, whichever these are now."""

    distance: np.ndarray  # (b,) [m] that features keep; 0: the body does not hold itself
    altitude: np.ndarray  # (b,) [m] of the lowest triangle as the body was when memory was made
    margin: np.ndarray  # (b,) [m] within which near features are listed
    seen: np.ndarray  # (n, 3) [m] where particles were when a body was last seen whole
    room: np.ndarray  # (b,) [m] that they might drift from there; < 0: it was not seen whole
    corners: np.ndarray  # (s,) uint32, of triangles, see star.py; those of body i
    corner_start: np.ndarray  # (b + 1,) begin there
    pause: np.ndarray  # (b,) steps for which its near features are not searched for the least gap
    is_listed: np.ndarray  # (b,) of bool: whether there is a list of near features
    is_whole: np.ndarray  # (b,) of bool: whether nothing is near in this step, as far as it is known
    begins_whole: np.ndarray  # (b,) of bool: whether the last step has left it so that nothing is near
    way: np.ndarray  # (n,) [m] that each particle has moved, besides what all of its body move in common
    listed: np.ndarray  # (n,) [m] that it had moved when its features were listed
    step: np.ndarray  # (n,) [m] that it moves in this step
    first: np.ndarray  # (b + 1,) rows of pairs from first[i] to first[i + 1] are for those of body i
    number: np.ndarray  # (b,) of pairs; perhaps more than there is room for
    pairs: np.ndarray  # (p,) see near_features.py, sorted
    gaps: np.ndarray  # (p,) [m] when the step began; < 0: not measured
    base: np.ndarray  # (p,) [m] as short as the gap may be, and what its particles have moved in all
    carried: np.ndarray  # (n, 3) [m] where the motion that all particles of a body have in common takes them
    place: np.ndarray  # (n, 3) [m] where particles were before motion was cut
    speed: np.ndarray  # (n, 3) [m/s] and how fast


def build_skin(model: Model, position: np.ndarray, seen: np.ndarray) -> Skin:
    """Return memory for all soft bodies of a model whose particles are at `position` (n, 3) [m].

    `seen` is that of a watch, which the skin then shares with it; or empty.
    """
    count, particles = model.soft_count, len(position)
    lowest, corners = [], []
    for body in range(count):
        triangles = model.triangle_particles[model.soft_triangle_start[body] : model.soft_triangle_start[body + 1]]
        lowest.append(lowest_altitude(position[triangles]))
        first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
        corners.append(corners_of(triangles - first, 3 * np.arange(end - first)))
    return Skin(
        np.zeros(count),
        np.array(lowest),
        np.zeros(count),
        seen if len(seen) else np.zeros_like(position),
        np.full(count, -1.0),
        np.concatenate(corners),
        np.cumsum([0, *(len(each) for each in corners)]),
        np.zeros(count, np.int64),
        np.zeros(count, bool),
        np.zeros(count, bool),
        np.zeros(count, bool),
        np.zeros(particles),
        np.zeros(particles),
        np.zeros(particles),
        np.arange(count + 1) * FIRST_PAIRS,
        np.zeros(count, np.int64),
        np.empty(count * FIRST_PAIRS, np.int64),
        np.empty(count * FIRST_PAIRS),
        np.empty(count * FIRST_PAIRS),
        np.empty_like(position),
        np.empty_like(position),
        np.empty_like(position),
    )


def with_room_for_pairs(skin: Skin) -> Skin:
    """Return the memory with room for as many pairs as there are, and as many more, and no lists."""
    first = np.concatenate([[0], np.cumsum(np.maximum(np.diff(skin.first), 2 * skin.number))])
    skin.is_listed[:] = False
    room = int(first[-1])
    return skin._replace(first=first, pairs=np.empty(room, np.int64), gaps=np.empty(room), base=np.empty(room))


@jit_lean
def forget(skin: Skin | None) -> None:
    """Forget what is known of where particles are: they were put elsewhere."""
    if skin is not None:
        skin.is_listed[:] = False
        skin.begins_whole[:] = False
        skin.room[:] = -1.0
        skin.pause[:] = 0


def lowest_altitude(corners: np.ndarray) -> float:
    """Return the lowest altitude [m] of triangles with `corners` (t, 3, 3) [m]."""
    sides = np.roll(corners, -1, axis=1) - corners
    twice_area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    return float((twice_area / np.linalg.norm(sides, axis=2).max(axis=1)).min())


def skin_distance(model: Model, state: State) -> float:
    """Return the distance [m] that the skin of the only body of a model can keep in a state.

    Where it meets itself, features that are near do not count.
    """
    position = state.particle_position
    corners = position[model.triangle_particles]
    lowest, size = lowest_altitude(corners), float(np.ptp(position, axis=0).max())
    distance = min(OF_SIZE * size, OF_LOWEST * lowest)
    surfaces = build_surfaces(model, position)
    pairs = np.empty(FIRST_PAIRS, np.int64)
    while True:
        count, least = near_features_of(model, state, surfaces, distance / OF_LEAST, pairs)
        if count <= len(pairs):
            break
        pairs = np.empty(count, np.int64)
    if OF_LEAST * least < SUSPECT * distance:
        meets, _ = self_intersections(position, model.triangle_particles, first_at_place(position))
        least = np.inf if len(meets) else least
    return min(distance, OF_LEAST * least)


@jit
def near_features_of(
    model: Model, state: State, surfaces: Surfaces, margin: float, pairs: np.ndarray
) -> tuple[int, float]:
    """Write the pairs of the first body that are nearer than a `margin` [m]; return how many, and the least gap [m]."""
    shapes, scratch = surfaces.shapes, surfaces.scratch
    surface, tree = surface_of(model, state, shapes, scratch, 0, 0), tree_at(shapes, scratch, 0, 0)
    vertices = surface.vertices.position
    refit_bvh(tree, vertices)
    count = list_all(Solid(surface, tree), memory_at(scratch, 0).search, vertices, margin, pairs)
    return count, least_gap(surface, vertices, pairs[: min(count, pairs.shape[0])])


@jit_lean
def least_gap_of_body(model: Model, state: State, surfaces: Surfaces, body: int, most: float) -> float:
    """Return the least distance [m] of a body's features that have no vertex in common; `most`, if that is wider."""
    surface = surface_of(model, state, surfaces.shapes, surfaces.scratch, 0, body)
    tree, vertices = tree_at(surfaces.shapes, surfaces.scratch, 0, body), surface.vertices.position
    refit_bvh(tree, vertices)
    return least_gap_of_all(Solid(surface, tree), memory_at(surfaces.scratch, 0).search, vertices, most)


@jit
def find_self_contacts(
    model: Model,
    state: State,
    start: State,
    surfaces: Surfaces | None,
    skin: Skin | None,
    rest: SleepState | None,
    contacts: Contacts,
) -> tuple[Contacts, bool]:
    """Add the contacts of soft bodies with themselves in the step from `start`; return all, with room for them.

    False: there is no room for all near features, of which `skin.number` tells how many there are.
    """
    if surfaces is None or skin is None:
        return contacts, True
    kept = contacts.number[0]
    while True:
        for body in range(model.soft_count):
            holds_itself = skin.distance[body] > 0.0 and not sleeps(rest, body)
            if holds_itself and not _add_contacts_of(model, state, start, surfaces, skin, contacts, body):
                return contacts, False
        if fit(contacts):
            return contacts, True
        contacts = with_room(contacts, kept)


@jit_lean
def _add_contacts_of(
    model: Model, state: State, start: State, surfaces: Surfaces, skin: Skin, contacts: Contacts, body: int
) -> bool:
    """Add the contacts of one body with itself; tell whether there was room for its near features."""
    first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
    before, after = start.particle_position[first:end], state.particle_position[first:end]
    skin.pause[body] = max(0, skin.pause[body] - 1)
    begins_whole = skin.begins_whole[body] or is_seen_whole(model, surfaces, skin, body, start)
    skin.begins_whole[body] = False
    if begins_whole and is_seen_whole(model, surfaces, skin, body, state):
        skin.is_whole[body], skin.is_listed[body] = True, False
        return True
    skin.is_whole[body] = False
    if not skin.is_listed[body]:
        _choose_margin(skin, body, end - first)
    stretch = _note_ways(model, skin, body, before, after)
    surface = surface_of(model, start, surfaces.shapes, surfaces.scratch, 0, body)
    if _list_anew(surfaces, surface, skin, body, before, stretch) == NO_ROOM:
        return False
    distance, rows = skin.distance[body], slice_of(skin, body)
    _measure(surface, skin, body, before, True)
    pairs, gaps = skin.pairs[rows[0] : rows[1]], skin.gaps[rows[0] : rows[1]]
    material = combined(material_of_soft(model, body), material_of_soft(model, body))
    moved = before, after, skin.carried[first:end], stretch
    add_self_contacts(surface, moved, pairs, gaps, distance, material, contacts)
    return True


@jit_lean
def slice_of(skin: Skin, body: int) -> tuple[int, int]:
    """Return first and end of the pairs of a body."""
    return skin.first[body], skin.first[body] + skin.number[body]


@jit_lean
def _choose_margin(skin: Skin, body: int, particles: int) -> None:
    """Choose within what distance [m] features of a body are listed; if another than now, all are listed anew."""
    least, most = LISTED * skin.distance[body], OF_ALTITUDE * skin.altitude[body]
    margin = skin.margin[body]
    if margin == 0.0:
        margin = most
    elif skin.is_listed[body] and skin.number[body] > FEW * particles:
        margin = 0.5 * margin
    elif skin.is_listed[body] and skin.number[body] < FEW * particles // 16:
        margin = 2.0 * margin
    margin = max(least, min(most, margin))
    if margin != skin.margin[body]:
        skin.margin[body], skin.is_listed[body] = margin, False


@jit_lean
def _room(skin: Skin, body: int) -> float:
    """Return how far [m] particles of a body may move until their features are listed anew."""
    return ROOM * (skin.margin[body] - skin.distance[body])


@jit_lean
def _note_ways(model: Model, skin: Skin, body: int, before: np.ndarray, after: np.ndarray) -> float:
    """Note how far each particle of a body moves in a step, and what all have in common; return the stretch of that.

    What holds a body in place has no motion in common with it.
    """
    first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
    carried, stretch, is_held = skin.carried[first:end], 1.0, False
    for i in range(first, end):
        is_held = is_held or model.particle_inverse_mass[i] == 0.0
    if is_held:
        for i in range(end - first):
            store(carried, i, load(before, i))
    else:
        stretch = fit_affine(before, after, carried)
    # What the common motion presses together, all count half of: two features that are near, the whole of it.
    pressed = 0.5 * (1.0 - stretch) * skin.margin[body]
    for i in range(end - first):
        skin.step[first + i] = pressed + norm(sub(load(after, i), load(carried, i)))
    return stretch


@jit_lean
def _list_anew(surfaces: Surfaces, surface: Surface, skin: Skin, body: int, before: np.ndarray, stretch: float) -> int:
    """List the features of particles that have moved far, or would in this step: AS_LISTED, ANEW or NO_ROOM."""
    first, n = surface.first, before.shape[0]
    margin, distance, room = skin.margin[body], skin.distance[body], _room(skin, body)
    most, is_any = 0.0, False
    for i in range(first, first + n):
        if not skin.is_listed[body]:
            skin.listed[i] = NEW
        if skin.way[i] - skin.listed[i] + skin.step[i] > room:
            is_any, most, skin.listed[i] = True, max(most, skin.step[i]), NEW
    if not is_any:
        return AS_LISTED
    if not skin.is_listed[body]:
        skin.number[body] = 0
    begin, end = skin.first[body], skin.first[body + 1]
    pairs, base, is_new = skin.pairs[begin:end], skin.base[begin:end], skin.listed[first : first + n]
    kept = 0
    for k in range(skin.number[body]):
        i, j, a, b = members(surface, pairs[k])
        if not has_new(is_new, (i, j, a, b)):
            pairs[kept], base[kept] = pairs[k], base[k]
            kept += 1
    tree, search = tree_at(surfaces.shapes, surfaces.scratch, 0, body), memory_at(surfaces.scratch, 0).search
    refit_bvh(tree, before)
    # Those that move farther in one step than they may are listed in every step, as far as they may meet each other.
    margin = max(margin, (distance + 2.0 * most + room) / stretch)
    skin.number[body] = list_near_features(Solid(surface, tree), search, before, margin, is_new, pairs, kept)
    skin.is_listed[body] = skin.number[body] <= pairs.shape[0]
    if not skin.is_listed[body]:
        return NO_ROOM
    for k in range(kept, skin.number[body]):
        four = members(surface, pairs[k])
        base[k] = min(skin.margin[body], gap_at(surface, pairs[k], before)) + _ways(skin.way, first, four)
    sort_pairs(pairs[: skin.number[body]], base[: skin.number[body]], kept)
    for i in range(first, first + n):
        if skin.listed[i] == NEW:
            skin.listed[i] = skin.way[i]
    return ANEW


@jit_lean
def _ways(way: np.ndarray, first: int, four: Members) -> float:
    """Return how far [m] four particles of a body have moved together."""
    return way[first + four[0]] + way[first + four[1]] + way[first + four[2]] + way[first + four[3]]


@jit_lean
def _measure(surface: Surface, skin: Skin, body: int, before: np.ndarray, is_first: bool) -> None:
    """Measure the gaps of features that may come to the skin's distance in this step; or those that were not, yet."""
    first, distance, cap = surface.first, skin.distance[body], skin.margin[body]
    step = skin.step[first : first + before.shape[0]]
    for k in range(skin.first[body], skin.first[body] + skin.number[body]):
        if not is_first and skin.gaps[k] >= 0.0:
            continue
        four = members(surface, skin.pairs[k])
        ways = _ways(skin.way, first, four)
        least, way = skin.base[k] - ways, most_of(skin.pairs[k], step, four)
        skin.gaps[k] = -1.0
        if least <= distance or least - way <= distance or (1.0 - LEFT) * least <= way:
            skin.gaps[k] = gap_at(surface, skin.pairs[k], before)
            skin.base[k] = min(cap, skin.gaps[k]) + ways


@jit_lean
def is_seen_whole(model: Model, surfaces: Surfaces, skin: Skin, body: int, state: State) -> bool:
    """Tell whether nothing of a body is near itself in a state, as is known without a list of what is near.

    It is seen whole from its middle; or the least of all gaps is wide, which takes a search, and so is not asked often.
    """
    first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
    vertices, seen, distance = state.particle_position[first:end], skin.seen[first:end], skin.distance[body]
    if skin.room[body] > 0.0 and drift(vertices, seen) <= skin.room[body]:
        return True
    corners = skin.corners[skin.corner_start[body] : skin.corner_start[body + 1]]
    room = room_of_vertices(vertices, corners, HEIGHTS * distance)
    if room <= 0.0 and skin.pause[body] == 0:
        gap = least_gap_of_body(model, state, surfaces, body, skin.altitude[body])
        room = min(0.5 * (gap - distance), OF_GAP * gap)
        if room < OF_ROOM * skin.altitude[body]:
            room = -1.0
        skin.pause[body] = PAUSE if room > 0.0 else LONG_PAUSE
    skin.room[body] = room
    if room > 0.0:
        for i in range(end - first):
            store(seen, i, load(vertices, i))
    return bool(room > 0.0)


@jit
def keep_whole(
    model: Model,
    state: State,
    start: State,
    surfaces: Surfaces | None,
    skin: Skin | None,
    rest: SleepState | None,
    h: float,
) -> None:
    """Cut what motion, in a step of `h` [s] from `start`, might take a body through itself; see guard.py."""
    if surfaces is None or skin is None:
        return
    for body in range(model.soft_count):
        if not skin.distance[body] > 0.0 or sleeps(rest, body):
            continue
        first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
        before, after = start.particle_position[first:end], state.particle_position[first:end]
        skin.begins_whole[body] = skin.is_whole[body] and is_seen_whole(model, surfaces, skin, body, state)
        if skin.begins_whole[body]:
            continue
        if skin.is_whole[body]:
            _choose_margin(skin, body, end - first)
        stretch = _note_ways(model, skin, body, before, after)
        surface = surface_of(model, start, surfaces.shapes, surfaces.scratch, 0, body)
        how = _list_anew(surfaces, surface, skin, body, before, stretch)  # contacts may have moved it farther
        rows = slice_of(skin, body)
        pairs, gaps = skin.pairs[rows[0] : rows[1]], skin.gaps[rows[0] : rows[1]]
        if how != NO_ROOM:
            _measure(surface, skin, body, before, how == ANEW or skin.is_whole[body])
        else:
            most = 0.0
            for i in range(first, end):
                most = max(most, skin.step[i])
            reach = max(skin.distance[body], 2.0 * most / (stretch - LEFT))
            pairs, gaps = _pairs_within(start, surfaces, surface, body, reach)
        velocity, place, speed = state.particle_velocity[first:end], skin.place[first:end], skin.speed[first:end]
        for i in range(end - first):
            store(place, i, load(after, i))
            store(speed, i, load(velocity, i))
        moved = before, after, skin.carried[first:end], stretch
        steps, distance = skin.step[first:end], skin.distance[body]
        count = cut_motion(surface, pairs, gaps, distance, moved, steps, velocity, h)
        if count > 0:
            give_back(model.particle_inverse_mass[first:end], after, velocity, place, speed)
        for i in range(first, end):
            skin.way[i] += skin.step[i]
        _choose_margin(skin, body, end - first)


@jit
def _pairs_within(
    start: State, surfaces: Surfaces, surface: Surface, body: int, reach: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs (p,) of a body that were nearer than `reach` [m] when the step began, and their gaps (p,)."""
    tree, search = tree_at(surfaces.shapes, surfaces.scratch, 0, body), memory_at(surfaces.scratch, 0).search
    vertices = start.particle_position[surface.first : surface.first + surface.touching.shape[0]]
    refit_bvh(tree, vertices)
    pairs = np.empty(FIRST_PAIRS, np.int64)
    count = list_all(Solid(surface, tree), search, vertices, reach, pairs)
    if count > pairs.shape[0]:
        pairs = np.empty(count, np.int64)
        list_all(Solid(surface, tree), search, vertices, reach, pairs)
    pairs = pairs[:count]
    gaps = np.empty(count)
    for k in range(count):
        gaps[k] = gap_at(surface, pairs[k], vertices)
    return pairs, gaps
