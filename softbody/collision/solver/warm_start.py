"""Warm starting: contacts of boxes that were there a step ago start from the impulse they had.

What held a pile a step ago holds it now. What an impact gave does not: the same once more would throw apart what it has
struck, and sweeps that stop early leave some of that. So where contacts that push part, each island of contacts starts
from the multiple of its impulses that leaves least to be solved. What bounces now starts from what that gives, in full.
"""

from __future__ import annotations

import numpy as np

from softbody.collision.contact import Contacts, ImpulseCache, first_of_pair, rows_of
from softbody.collision.islands import find_islands
from softbody.collision.solver.solver_row import (
    NORMAL,
    NORMAL_IMPULSE,
    SECOND,
    SECOND_IMPULSE,
    TANGENT,
    TANGENT_IMPULSE,
    TARGET,
    apply_impulse,
    component,
    load_motion,
    load_pair,
    speed_along,
)
from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.vec import load, store
from softbody.model.arrays import RigidBodies

# Times what is worth a sweep: the speed at which a contact that pushes parts only if an impact has given it its
# impulse. It is four times the speed that gravity gives in a step.
THROWN = 4e4


@jit_lean
def warm_start(contacts: Contacts) -> None:
    """Give each contact of boxes the impulse that it had a step ago, else none.

    It is known by its bodies and features. Where a feature is gone, its impulse goes to the contact of that pair that
    is nearest to it now: so boxes that slide over each other's edges keep what holds them.
    """
    cache, number = contacts.cache, contacts.number[1]
    for k in range(number):
        store(contacts.impulse, k, (0.0, 0.0, 0.0))
    first = 0
    for old in range(cache.number[0] - cache.soft[0]):
        # The contacts of the same pair: both lists are sorted.
        a, b = cache.box[old, 0], cache.box[old, 1]
        first = first_of_pair(contacts, first, number, a, b)
        # Of them the one of the same feature, else the nearest.
        matched = -1
        nearest = np.inf
        k = first
        while k < number and contacts.box[k, 0] == a and contacts.box[k, 1] == b:
            distance = 0.0
            for c in range(3):
                distance += (contacts.point[k, c] - cache.point[old, c]) ** 2
            if contacts.feature[k] == cache.feature[old]:
                distance = -1.0
            if distance < nearest:
                nearest = distance
                matched = k
            k += 1
        if matched >= 0:
            for c in range(3):
                contacts.impulse[matched, c] += cache.impulse[old, c]


@jit
def start_from_cache(contacts: Contacts, bodies: RigidBodies, motion: np.ndarray, enough: float) -> None:
    """Give every contact its impulse of the last step, along the directions of this one, or a bounce's.

    `motion` (m + 1, 6) is that of `bodies`, and changed by the impulses. Speeds up to THROWN times `enough` [m/s] at
    which contacts part are left to the sweeps.
    """
    row, number = contacts.row, contacts.number[1]
    bounces = row[:number, NORMAL_IMPULSE].copy()
    row[:number, TANGENT_IMPULSE : SECOND_IMPULSE + 1] = 0.0
    _apply_start(contacts, motion)
    bounced, thrown = motion.copy(), False
    for k in range(number):
        p = load(contacts.impulse, k)
        row[k, NORMAL_IMPULSE] = max(bounces[k], component(row, k, NORMAL, p))
        keeps = row[k, NORMAL_IMPULSE] > 0.0 and contacts.friction[k] > 0.0
        row[k, TANGENT_IMPULSE] = component(row, k, TANGENT, p) if keeps else 0.0
        row[k, SECOND_IMPULSE] = component(row, k, SECOND, p) if keeps else 0.0
    motion[:] = load_motion(bodies)
    _apply_start(contacts, motion)
    for k in range(number):
        if row[k, NORMAL_IMPULSE] > bounces[k]:
            parting = speed_along(row, k, NORMAL, load_pair(motion, contacts.box[k, 0], contacts.box[k, 1]))
            thrown = thrown or parting > row[k, TARGET] + THROWN * enough
    if thrown:
        _scale_start(contacts, bodies, bounces, bounced, motion)
        motion[:] = load_motion(bodies)
        _apply_start(contacts, motion)


@jit_lean
def _apply_start(contacts: Contacts, motion: np.ndarray) -> None:
    """Change `motion` (m + 1, 6) by the impulses of all contacts."""
    for k in range(contacts.number[1]):
        for direction in (NORMAL, TANGENT, SECOND):
            impulse = contacts.row[k, NORMAL_IMPULSE + direction]
            if impulse != 0.0:
                apply_impulse(contacts.row, k, direction, impulse, motion, (contacts.box[k, 0], contacts.box[k, 1]))


@jit
def _scale_start(
    contacts: Contacts, bodies: RigidBodies, bounces: np.ndarray, before: np.ndarray, after: np.ndarray
) -> None:
    """Scale what impulses there are besides `bounces` (c,), p, in each island by the part, at most all, that is best.

    They turn motions `before` (m + 1, 6) into `after`. With speeds u of contacts before, and t that they should have,
    and A p what impulses change them by, ½ pᵀ A p + pᵀ (u − t) is least for what is looked for.
    """
    rows = rows_of(contacts, contacts.number[1:], 0, contacts.number[1])
    islands = find_islands(rows, bodies.inverse_mass, np.empty(0, np.int64))
    for island in range(islands.start.shape[0] - 1):
        gain = square = 0.0
        for place in range(islands.start[island], islands.start[island + 1]):
            k = islands.contact[place]
            pair = contacts.box[k, 0], contacts.box[k, 1]
            for direction in (NORMAL, TANGENT, SECOND):
                bounce = bounces[k] if direction == NORMAL else 0.0
                impulse = contacts.row[k, NORMAL_IMPULSE + direction] - bounce
                u = speed_along(contacts.row, k, direction, load_pair(before, pair[0], pair[1]))
                changed = speed_along(contacts.row, k, direction, load_pair(after, pair[0], pair[1])) - u
                target = contacts.row[k, TARGET] if direction == NORMAL else 0.0
                gain += impulse * (target - u)
                square += impulse * changed
        part = min(1.0, max(0.0, gain / square)) if square > 0.0 else 1.0
        for place in range(islands.start[island], islands.start[island + 1]):
            k = islands.contact[place]
            for direction in (NORMAL, TANGENT, SECOND):
                bounce = bounces[k] if direction == NORMAL else 0.0
                column = NORMAL_IMPULSE + direction
                contacts.row[k, column] = bounce + part * (contacts.row[k, column] - bounce)


@jit_lean
def cache_impulses(contacts: Contacts) -> None:
    """Keep what `warm_start` will ask for."""
    cache = contacts.cache
    cache.number[0], cache.soft[0] = contacts.number[1], 0
    for k in range(contacts.number[1]):
        cache.box[k, 0], cache.box[k, 1] = contacts.box[k, 0], contacts.box[k, 1]
        cache.feature[k] = contacts.feature[k]
        store(cache.point, k, load(contacts.point, k))
        store(cache.impulse, k, load(contacts.impulse, k))


@jit
def copied_cache(cache: ImpulseCache) -> ImpulseCache:
    """Return a cache of the same contacts that shares no memory with this one."""
    return ImpulseCache(
        cache.number.copy(),
        cache.soft.copy(),
        cache.box.copy(),
        cache.feature.copy(),
        cache.point.copy(),
        cache.impulse.copy(),
    )


@jit_lean
def copy_cache(source: ImpulseCache, cache: ImpulseCache) -> None:
    """Overwrite a cache with what another one holds, for which it has room."""
    cache.number[0], cache.soft[0] = source.number[0], source.soft[0]
    for k in range(source.number[0]):
        cache.box[k, 0], cache.box[k, 1] = source.box[k, 0], source.box[k, 1]
        cache.feature[k] = source.feature[k]
        store(cache.point, k, load(source.point, k))
        store(cache.impulse, k, load(source.impulse, k))
