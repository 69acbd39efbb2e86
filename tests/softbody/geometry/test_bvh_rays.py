"""Do rays through a tree find where a segment goes in and out, and what is inside?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import softbody
from softbody.geometry.bvh import build_bvh, search_space
from softbody.geometry.bvh_rays import point_in_bvh, segment_hits

CUBE = softbody.box((2.0, 2.0, 2.0))
TREE = build_bvh(CUBE.vertices, CUBE.triangles)
SEARCH = search_space(TREE)

numbers = st.floats(-2.0, 2.0).map(lambda x: round(x, 3) + 0.0003)
points = st.tuples(numbers, numbers, numbers)


def hits_of(p, q, vertices=CUBE.vertices, triangles=CUBE.triangles):
    """Return where the segment from p to q goes through a cube, in order."""
    places = np.empty(len(triangles))
    return np.sort(places[: segment_hits(p, q, build_bvh(vertices, triangles), vertices, SEARCH, places)])


@given(points, points)
def test_hits_are_where_a_segment_goes_in_and_out(p, q):
    hits = hits_of(p, q)
    t = np.linspace(0.0, 1.0, 2001)[1:-1, None]
    inside = (np.abs((1.0 - t) * np.array(p) + t * np.array(q)) < 1.0).all(axis=1)
    assert int(np.abs(np.diff(inside.astype(int))).sum()) <= len(hits) <= 2
    for place in hits:
        x = (1.0 - place) * np.array(p) + place * np.array(q)
        assert np.abs(x).max() == pytest.approx(1.0, abs=1e-9)


# To the last bit through diagonals of faces, through an edge, past one that it only touches, and through corners.
@pytest.mark.parametrize(
    ("p", "q", "inside"),
    [
        ((0.25, 0.25, -2.0), (0.25, 0.25, 2.0), 2),
        ((-0.25, 0.25, -2.0), (-0.25, 0.25, 2.0), 2),
        ((0.25, 0.25, -2.0), (0.25, 0.25, 0.0), 1),
        ((-2.0, 0.25, -2.0), (0.0, 0.25, 0.0), 1),
        ((2.0, 0.5, -2.0), (0.0, 0.5, 0.0), 1),
        ((-2.0, 0.25, 0.0), (0.0, 0.25, -2.0), 0),
        ((-2.0, -2.0, -2.0), (0.25, 0.25, 0.25), 1),
        ((-2.0, -2.0, -2.0), (2.0, 2.0, 2.0), 2),
        ((2.0, 0.0, 1.0), (0.0, 2.0, 1.0), 0),
    ],
)
def test_what_goes_through_an_edge_to_the_last_bit_goes_in_as_often_as_out(p, q, inside):
    rng = np.random.default_rng(0)
    for _ in range(10):
        order = rng.permutation(8)
        turned = [np.roll(np.argsort(order)[t], rng.integers(3)) for t in rng.permutation(CUBE.triangles)]
        assert len(hits_of(p, q, CUBE.vertices[order], np.array(turned))) % 2 == inside % 2


@given(points)
def test_points_in_a_tree_are_those_in_the_mesh(p):
    assert point_in_bvh(p, TREE, CUBE.vertices, SEARCH) == (np.abs(p) < 1.0).all()
