"""Islands: contacts that share a particle or a box that moves, and so must be solved together; others need not be."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.collision.contact import Listing
from softbody.compiler.jit import jit, jit_lean
from softbody.model.arrays import NOBODY


class Islands(NamedTuple):
    """Contacts, one island after another; in each in the order of the list."""

    start: np.ndarray  # (i + 1,) contact[start[j]:start[j + 1]] are those of island j
    contact: np.ndarray  # (c,)


@jit
def find_islands(contacts: Listing, inverse_mass: np.ndarray, owner: np.ndarray) -> Islands:
    """Return the islands of contacts, in the order of their first ones.

    `inverse_mass` (m,) is that of boxes: what is fixed joins nobody. `owner` (n,) is memory that holds NOBODY, and is
    left so; (0,) says that no contact is of particles.
    """
    count, with_particles = contacts.depth.shape[0], owner.shape[0] > 0
    parent, of_box = np.empty(count, np.int64), np.full(inverse_mass.shape[0], NOBODY)
    for k in range(count):
        parent[k] = k
        for side in range(2):
            box = contacts.box[k, side]
            if box != NOBODY:
                if inverse_mass[box] > 0.0:
                    _share(of_box, box, k, parent)
                continue
            for c in range(3 if with_particles else 0):
                _share(owner, contacts.particles[k, side, c], k, parent)
    # Islands are numbered by their first contacts, which are their roots: a root comes before all that it is that of.
    number, islands = np.empty(count, np.int64), 0
    for k in range(count):
        root = _root(parent, k)
        if root == k:
            number[k] = islands
            islands += 1
        number[k] = number[root]
    start, contact = np.zeros(islands + 1, np.int64), np.empty(count, np.int64)
    for k in range(count):
        start[number[k] + 1] += 1
    for j in range(islands):
        start[j + 1] += start[j]
    filled = start[:islands].copy()
    for k in range(count):
        contact[filled[number[k]]] = k
        filled[number[k]] += 1
        for side in range(2):
            for c in range(3 if with_particles else 0):
                if contacts.particles[k, side, c] != NOBODY:
                    owner[contacts.particles[k, side, c]] = NOBODY
    return Islands(start, contact)


@jit_lean
def _share(owner: np.ndarray, of: int, k: int, parent: np.ndarray) -> None:
    """Let contact `k` be in the island of what it shares."""
    if owner[of] == NOBODY:
        owner[of] = k
        return
    one, other = _root(parent, owner[of]), _root(parent, k)
    if one != other:
        parent[max(one, other)] = min(one, other)


@jit_lean
def _root(parent: np.ndarray, k: int) -> int:
    """Return the first contact of the island of contact `k`, as far as it is known."""
    while parent[k] != k:
        parent[k] = parent[parent[k]]
        k = parent[k]
    return k
