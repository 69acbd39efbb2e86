"""Contacts that share what moves are of one island, by SciPy's connected components; others are not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from softbody.collision.contact import Touch, add_contact, box_side, new_contacts, rows_of, soft_side
from softbody.collision.islands import find_islands
from softbody.model.arrays import NOBODY
from softbody.model.material import Material
from softbody.model.surface_point import SurfacePoint

pytestmark = pytest.mark.interpreted


@given(st.integers(0, 10**6), st.integers(1, 40))
def test_islands_are_the_components_of_what_contacts_share(seed: int, count: int) -> None:
    random = np.random.default_rng(seed)
    particles, inverse_mass = int(random.integers(6, 150)), np.where(random.random(5) < 0.4, 0.0, 1.0)
    contacts, shared = new_contacts(count), []
    for k in range(count):
        a, b = random.choice(particles, (2, 3), replace=False).tolist()
        box = int(random.integers(-5, 5))
        other = box_side(box) if box >= 0 else soft_side(SurfacePoint(tuple(b), (0.2, 0.3, 0.5)))
        touch = Touch((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.1, 0)
        add_contact(contacts, soft_side(SurfacePoint(tuple(a), (0.2, 0.3, 0.5))), other, touch, Material(0.0, 0.0))
        moves = [particles + box] if box >= 0 and inverse_mass[box] > 0.0 else b if box < 0 else []
        shared += [(count, k, of) for of in a + moves]
    owner = np.full(particles, NOBODY)
    islands = find_islands(rows_of(contacts, contacts.number, 0, count), inverse_mass, owner)
    assert (owner == NOBODY).all()
    _, rows, columns = np.array(shared).T
    nodes = count + particles + 5
    graph = coo_matrix((np.ones(len(rows)), (rows, count + columns)), (nodes, nodes))
    labels = connected_components(graph, directed=False)[1][:count]
    found = [islands.contact[a:b].tolist() for a, b in zip(islands.start, islands.start[1:])]
    firsts = dict.fromkeys(labels.tolist())
    assert found == [np.flatnonzero(labels == label).tolist() for label in firsts]
