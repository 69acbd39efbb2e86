"""Warm starting: contacts of boxes that were there a step ago keep the impulse they had."""

from __future__ import annotations

import numpy as np

from softbody.collision.contact import Contacts, ImpulseCache
from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.vec import load, store


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
        while first < number and (
            contacts.box[first, 0] < a or (contacts.box[first, 0] == a and contacts.box[first, 1] < b)
        ):
            first += 1
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
