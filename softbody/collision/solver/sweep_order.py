"""Order in which the solver sweeps over pairs of boxes: from what holds still up to the tops."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.collision.contact import Contacts
from softbody.compiler.jit import jit
from softbody.model.arrays import RigidBodies


class SweepOrder(NamedTuple):
    """The pairs of boxes, or boxes and the ground, that touch, and how far from the ground each box is."""

    pairs: np.ndarray  # (p, 2) first contact of each pair, and the one after its last; the pairs from below
    level: np.ndarray  # (m + 1,) pairs from a body to one that cannot move, or m + 1; the last is the ground


@jit
def sweep_order(contacts: Contacts, bodies: RigidBodies) -> SweepOrder:
    """Return the pairs by the levels of their bodies; those of the same levels as they are listed.

    A sweep that goes up from the ground carries support through a whole pile, one that goes down its weight. In the
    order in which boxes were added, each may take as many sweeps as there are boxes.
    """
    pairs = _pairs_as_listed(contacts)
    level = _levels(contacts, bodies, pairs)
    # Counting sort by the sum of both levels.
    number, unreached = pairs.shape[0], level.shape[0]
    start = np.zeros(2 * unreached + 2, np.int64)
    for pair in range(number):
        start[_height(contacts, level, pairs[pair, 0]) + 1] += 1
    for height in range(2 * unreached + 1):
        start[height + 1] += start[height]
    result = np.empty((number, 2), np.int64)
    for pair in range(number):
        height = _height(contacts, level, pairs[pair, 0])
        result[start[height], 0], result[start[height], 1] = pairs[pair, 0], pairs[pair, 1]
        start[height] += 1
    return SweepOrder(result, level)


@jit
def _height(contacts: Contacts, level: np.ndarray, k: int) -> int:
    """Return the sum of the levels of the bodies of contact `k`."""
    return level[contacts.box[k, 0]] + level[contacts.box[k, 1]]


@jit
def _pairs_as_listed(contacts: Contacts) -> np.ndarray:
    """Return (p, 2): the first contact of each pair of bodies, and the one after its last."""
    count, box = contacts.number[1], contacts.box
    pairs = np.empty((count, 2), np.int64)
    number = 0
    for k in range(count):
        if k == 0 or box[k, 0] != box[k - 1, 0] or box[k, 1] != box[k - 1, 1]:
            pairs[number, 0] = k
            number += 1
        pairs[number - 1, 1] = k + 1
    return pairs[:number]


@jit
def _levels(contacts: Contacts, bodies: RigidBodies, pairs: np.ndarray) -> np.ndarray:
    """Return (m + 1,): how many pairs are between each body and one that cannot move; m + 1 if none is."""
    count, number = bodies.inverse_mass.shape[0], pairs.shape[0]
    level = np.full(count + 1, count + 1)
    level[count] = 0
    for i in range(count):
        if bodies.inverse_mass[i] == 0.0:
            level[i] = 0
    # Forth and back, as the list may go up or down.
    changed, forth = True, True
    while changed:
        changed = False
        for place in range(number):
            k = pairs[place if forth else number - 1 - place, 0]
            a, b = contacts.box[k, 0], contacts.box[k, 1]
            if level[a] > level[b] + 1:
                level[a] = level[b] + 1
                changed = True
            elif level[b] > level[a] + 1:
                level[b] = level[a] + 1
                changed = True
        forth = not forth
    return level
