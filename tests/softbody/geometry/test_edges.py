"""Edges are found by their ends, and measured."""

import numpy as np
import pytest

from softbody import icosphere, torus
from softbody.geometry.edges import edges_of_sides, lengths_of, rows_of_edges, triangles_at

pytestmark = pytest.mark.interpreted


def test_each_edge_is_found_from_both_ends():
    mesh = torus(1.0, 0.4, 12, 8)
    count, edges = len(mesh.vertices), mesh.edges
    first, second = edges.T.copy()
    rows = np.arange(len(edges))
    assert np.array_equal(rows_of_edges(edges, count, first, second), rows)
    assert np.array_equal(rows_of_edges(edges, count, second, first), rows)


def test_sides_are_edges_of_two_triangles_or_of_one():
    mesh = icosphere(1)
    count, edges, triangles = len(mesh.vertices), mesh.edges, mesh.triangles
    sides = edges_of_sides(triangles, edges, count)
    assert np.array_equal(np.sort(edges[sides]), np.sort(np.stack([triangles, np.roll(triangles, -1, 1)], axis=2)))
    assert (triangles_at(triangles, edges, count) == 2).all()
    at = triangles_at(triangles[1:], edges, count)
    assert sorted(np.flatnonzero(at == 1)) == sorted(sides[0])


def test_lengths_are_those_of_numpy():
    mesh = icosphere(1)
    expected = np.linalg.norm(np.diff(mesh.vertices[mesh.edges], axis=1)[:, 0], axis=1)
    assert np.array_equal(lengths_of(mesh.vertices.copy(), mesh.edges), expected)
