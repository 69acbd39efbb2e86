"""Edges of soft bodies against skins: is what goes through found, and does the way out part them?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import softbody
from softbody import World
from softbody.collision.edge_skin import edge_inside, edge_over_ridge
from softbody.geometry.tree_hits import first_hits, point_in_tree
from softbody.geometry.triangle_tree import build_triangle_tree, search_space

ROOF = softbody.box((2.0, 2.0, 2.0))
TREE = build_triangle_tree(ROOF.vertices, ROOF.triangles)
SEARCH = search_space(TREE)

numbers = st.floats(-2.0, 2.0).map(lambda x: round(x, 3) + 0.0003)
points = st.tuples(numbers, numbers, numbers)


def hits_of(p, q):
    return first_hits(p, q, TREE, ROOF.vertices, SEARCH)


def point_of(triangle, weights):
    return np.array(weights) @ ROOF.vertices[ROOF.triangles[triangle]]


def test_two_ridges_that_cross_are_parted_at_right_angles_to_both():
    p, q = (1.3, 0.1, 0.5), (0.5, 0.1, 1.3)
    depth, normal, place, triangle, weights = edge_over_ridge(p, q, hits_of(p, q), ROOF.vertices, ROOF.triangles)
    assert depth == pytest.approx((2.0 - 1.8) / np.sqrt(2.0))
    assert normal == pytest.approx((np.sqrt(0.5), 0.0, np.sqrt(0.5)))
    assert place == pytest.approx(0.5)
    assert point_of(triangle, weights) == pytest.approx((1.0, 0.1, 1.0))


def test_an_edge_through_both_sides_is_parted_at_its_middle():
    p, q = (-1.5, 0.1, 0.9), (1.5, 0.1, 0.9)
    hits = hits_of(p, q)
    assert edge_over_ridge(p, q, hits, ROOF.vertices, ROOF.triangles)[3] == -1
    depth, normal, place, triangle, weights = edge_inside(p, q, hits, TREE, ROOF.vertices, SEARCH)
    assert (depth, place) == (pytest.approx(0.1), pytest.approx(0.5))
    assert normal == pytest.approx((0.0, 0.0, 1.0))
    assert point_of(triangle, weights) == pytest.approx((0.0, 0.1, 1.0))


@given(points, points)
def test_hits_are_where_a_segment_goes_in_and_out(p, q):
    enter, one, leave, other = hits_of(p, q)
    t = np.linspace(0.0, 1.0, 2001)[1:-1, None]
    inside = (np.abs((1.0 - t) * np.array(p) + t * np.array(q)) < 1.0).all(axis=1)
    sides = inside.astype(int) + 0
    changes = int(np.abs(np.diff(sides)).sum())
    assert changes <= (one >= 0) + (other >= 0)
    assert enter <= leave
    for place, triangle in ((enter, one), (leave, other)):
        if triangle >= 0:
            x = (1.0 - place) * np.array(p) + place * np.array(q)
            assert np.abs(x).max() == pytest.approx(1.0, abs=1e-9)


@given(points)
def test_points_in_a_tree_are_those_in_the_mesh(p):
    assert point_in_tree(p, TREE, ROOF.vertices, SEARCH) == (np.abs(p) < 1.0).all()


@pytest.mark.parametrize("edges", [True, False])
def test_two_crossed_ridges_hold_each_other_up(edges):
    """Two coarse wedges fall crosswise on each other: without edges no particle of one ever is in the other."""
    prism = np.array(
        [[-1.0, -0.3, 0.0], [-1.0, 0.3, 0.0], [-1.0, 0.0, 0.5], [1.0, -0.3, 0.0], [1.0, 0.3, 0.0], [1.0, 0.0, 0.5]]
    )
    faces = [[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]]
    upper = prism[:, [1, 0, 2]] * [1.0, 1.0, -1.0]  # upside down and across: a proper turn
    lower = softbody.Mesh(prism, faces)
    world = World(edge_contacts=edges)
    world.add_ground()
    world.add_soft_body(lower, 6.0, 2e4, 200.0)
    falling = world.add_soft_body(softbody.Mesh(upper + [0.0, 0.0, 1.1], faces), 0.6, 2e3, 20.0)
    height = falling.centre[2]
    world.run(0.45, 0.5 * world.stable_time_step())
    assert (falling.centre[2] > height - 0.25) == edges
