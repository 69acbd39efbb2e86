"""Do rays through a tree find where a segment goes in and out, and what is inside?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import softbody
from softbody.geometry.bvh import build_bvh, search_space
from softbody.geometry.bvh_rays import (
    Heading,
    point_in_bvh,
    points_in_bvh_filtered,
    segment_hits,
    shortest_way_out,
)
from softbody.geometry.segments import put_segment

CUBE = softbody.box((2.0, 2.0, 2.0))
TREE = build_bvh(CUBE.vertices, CUBE.triangles)
SEARCH = search_space(TREE)

UP = Heading(0, 1, 2, 1.0)
HEADINGS = [UP, Heading(1, 2, 0, 1.0), Heading(2, 0, 1, 1.0)]
HEADINGS += [Heading(x, y, z, -1.0) for x, y, z, _ in HEADINGS]

numbers = st.floats(-2.0, 2.0).map(lambda x: round(x, 3) + 0.0003)
points = st.tuples(numbers, numbers, numbers)


def hits_of(p, q, vertices=CUBE.vertices, triangles=CUBE.triangles):
    """Return where the segment from p to q goes through a cube, in order; three others are asked about with it."""
    hits, places, tree = np.empty(8, np.int64), np.empty((8, len(triangles))), build_bvh(vertices, triangles)
    ends = np.array([(q, p), (p, q), (p, np.zeros(3)), (np.full(3, np.nan), q), *[(p, q)] * 4])
    segments = np.empty((9, 8))
    for lane in range(8):
        put_segment(segments, lane, *(tuple(float(x) for x in end) for end in ends[lane]))
    segment_hits(segments, 4, tree, vertices, SEARCH, hits, places)
    assert hits[0] == hits[1]
    assert hits[3] == 0
    return np.sort(places[1, : hits[1]])


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


@given(points, st.sampled_from(HEADINGS))
def test_points_in_a_tree_are_those_in_the_mesh(p, heading):
    assert point_in_bvh(0, np.array([p]), TREE, CUBE.vertices, SEARCH, heading) == (np.abs(p) < 1.0).all()


@given(st.lists(points, min_size=1, max_size=8), st.sampled_from(HEADINGS))
def test_of_eight_points_each_has_its_own_answer(some, heading):
    rows = np.array([(np.nan,) * 3, *some])
    asked = np.arange(1, len(rows))[::-1].copy()
    inside, in_doubt = points_in_bvh_filtered(asked, rows, TREE, CUBE.vertices, SEARCH, heading)
    for lane, i in enumerate(asked):
        assert (in_doubt >> lane) & 1 or (inside >> lane) & 1 == (np.abs(rows[i]) < 1.0).all()
    assert points_in_bvh_filtered(np.zeros(1, np.int64), rows, TREE, CUBE.vertices, SEARCH, heading) == (0, 0)


def test_a_point_under_an_edge_is_in_doubt_and_its_neighbours_are_not():
    rows = np.array([(0.0, 0.0, 0.0), (0.3, 0.2, 0.0), (3.0, 3.0, 0.0)])
    assert points_in_bvh_filtered(np.arange(3), rows, TREE, CUBE.vertices, SEARCH, UP) == (0b010, 0b001)


@given(points, st.sampled_from(HEADINGS))
def test_a_ray_meets_what_is_ahead_of_it_and_asks_for_no_more(p, heading):
    """Of a tree of small boxes only those that the ray passes are listed."""
    mesh = softbody.icosphere(3, 1.9)
    tree = build_bvh(mesh.vertices, mesh.triangles)
    search = search_space(tree)
    point_in_bvh(0, np.array([p]), tree, mesh.vertices, search, heading)
    asked = search.asked[:, 0]
    ahead = 3 + heading.z if heading.sign > 0.0 else heading.z
    assert asked[ahead] == (np.inf if heading.sign > 0.0 else -np.inf)
    assert np.isfinite(np.delete(asked, ahead)).all()


def test_the_shortest_way_out_of_a_box_is_through_its_nearest_side():
    bounds = (0.0, 0.0, 0.0), (10.0, 10.0, 10.0)
    ways = {(5, 5, 8): (2, 1.0), (5, 5, 2): (2, -1.0), (5, 8, 6): (1, 1.0), (5, 2, 6): (1, -1.0), (8, 5, 6): (0, 1.0)}
    for p, way in ({**ways, (2, 5, 6): (0, -1.0), (5, 5, 5): (2, 1.0)}).items():
        found = shortest_way_out(tuple(map(float, p)), bounds)
        assert (found.z, found.sign) == way
        assert found in HEADINGS
