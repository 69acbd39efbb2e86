"""Warm starting: contacts of soft bodies that were there a step ago begin with the impulse they had."""

from __future__ import annotations

import numpy as np

from softbody.collision.contact import Contacts
from softbody.collision.soft.surface import Surfaces
from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.vec import load, store
from softbody.model.arrays import NOBODY

# What touches what is known by a number below a prime of 40 bits: that two are the same is no harm, and all but never.
PRIME, BASE = 1_099_511_627_689, 4_194_301


@jit_lean
def _what_touches_what(contacts: Contacts, k: int) -> int:
    """Return a number of the particles and the box of contact `k`: the same in each step, and of that contact alone."""
    number = contacts.box[k, 1] + 1
    for side in range(2):
        for c in range(3):
            number = (number * BASE + contacts.particles[k, side, c] + 1) % PRIME
    return number


@jit
def start_from_last_step(contacts: Contacts, surfaces: Surfaces | None) -> None:
    """Give each contact of soft bodies the impulse that it had a step ago, else none."""
    first, end, cache = contacts.number[1], contacts.number[0], contacts.cache
    if surfaces is None or first == end:
        return
    size = 16
    while size < 2 * cache.soft[0]:
        size *= 2
    table = np.full(size, NOBODY)
    for old in range(cache.number[0] - cache.soft[0], cache.number[0]):
        place = cache.feature[old] % size
        while table[place] != NOBODY:
            place = (place + 1) % size
        table[place] = old
    for k in range(first, end):
        contacts.feature[k] = _what_touches_what(contacts, k)
        place = contacts.feature[k] % size
        while table[place] != NOBODY and cache.feature[table[place]] != contacts.feature[k]:
            place = (place + 1) % size
        if table[place] != NOBODY:
            store(contacts.impulse, k, load(cache.impulse, table[place]))


@jit
def keep_impulses(contacts: Contacts, surfaces: Surfaces | None) -> None:
    """Keep what `start_from_last_step` will ask for, after what is kept of boxes."""
    if surfaces is None:
        return
    cache = contacts.cache
    cache.number[0], cache.soft[0] = contacts.number[0], contacts.number[0] - contacts.number[1]
    for k in range(contacts.number[1], contacts.number[0]):
        cache.box[k, 0], cache.box[k, 1] = contacts.box[k, 0], contacts.box[k, 1]
        cache.feature[k] = contacts.feature[k]
        store(cache.point, k, load(contacts.point, k))
        store(cache.impulse, k, load(contacts.impulse, k))
