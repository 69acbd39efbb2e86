"""Does the separating-axis test find overlap, depth and normal, for any two boxes either way round?"""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from softbody.collision.boxes.sat_boxes import (
    PlacedBox,
    PlacedBoxes,
    box_box_separation,
    box_pairs_overlap,
    box_pairs_separation,
)
from softbody.linalg.quaternion import product, rotate
from softbody.linalg.vec import add, norm, scale
from tests.softbody.placed_boxes import CUBE, ORIGIN, REST, boxes, cube, places, quaternions, sizes


def about_z(angle):
    return cos(angle / 2), 0.0, 0.0, sin(angle / 2)


def about(axis, angle):
    axis = np.array(axis) / np.linalg.norm(axis)
    return tuple(float(c) for c in (cos(angle / 2), *(sin(angle / 2) * axis)))


def test_two_cubes_side_by_side_overlap_by_their_faces():
    separation, normal, axis = box_box_separation(cube((0.9, 0.2, 0.1)), CUBE)
    assert separation == pytest.approx(-0.1, abs=1e-15)
    assert (normal, axis) == ((1.0, 0.0, 0.0), 0)


def test_the_normal_points_from_b_to_a():
    for x in (0.9, -0.9):
        assert box_box_separation(cube((x, 0.0, 0.0)), CUBE)[1] == (np.sign(x), 0.0, 0.0)


def test_a_gap_is_positive_and_as_wide_as_it_is():
    assert box_box_separation(cube((0.0, 1.25, 0.0)), CUBE) == (0.25, (0.0, 1.0, 0.0), 1)


def test_an_edge_that_points_down_at_a_face_is_half_a_diagonal_deep():
    """A cube turned by 45° about y, its lowest edge √½ below its centre at 1.2."""
    turned = (cos(pi / 8), 0.0, sin(pi / 8), 0.0)
    separation, normal, axis = box_box_separation(cube((0.0, 0.0, 1.2), turned), CUBE)
    assert separation == pytest.approx(1.2 - 0.5 - sqrt(0.5), abs=1e-15)
    assert normal == pytest.approx((0.0, 0.0, 1.0), abs=1e-15)
    assert axis == 5


def test_a_corner_that_points_down_at_a_face_is_half_a_space_diagonal_deep():
    corner_down = about(np.cross([1, 1, 1], [0, 0, 1]), np.arccos(1 / sqrt(3)))
    separation, normal, axis = box_box_separation(cube((0.0, 0.0, 1.3), corner_down), CUBE)
    assert separation == pytest.approx(1.3 - 0.5 - sqrt(3) / 2, abs=1e-14)
    assert normal == pytest.approx((0.0, 0.0, 1.0), abs=1e-14)
    assert axis == 5


def crossing_edges(height):
    """Two cubes, each standing on an edge: the upper one's along x, the lower one's along y."""
    upper = (cos(pi / 8), sin(pi / 8), 0.0, 0.0)
    lower = (cos(pi / 8), 0.0, sin(pi / 8), 0.0)
    return cube((0.0, 0.0, height), upper), cube(ORIGIN, lower)


def test_two_edges_that_cross_part_along_their_cross_product():
    separation, normal, axis = box_box_separation(*crossing_edges(1.4))
    assert separation == pytest.approx(1.4 - sqrt(2), abs=1e-14)
    assert normal == pytest.approx((0.0, 0.0, 1.0), abs=1e-14)
    assert axis == 6 + 3 * 0 + 1


@pytest.mark.parametrize("i", range(3))
@pytest.mark.parametrize("j", range(3))
def test_each_edge_of_a_is_tried_across_each_edge_of_b(i, j):
    """The same picture with the cubes turned about (1, 1, 1), so that edge i of a lies along x and j of b along y."""
    upper, lower = crossing_edges(1.45)
    upper = cube(upper.position, product(upper.orientation, about((1, 1, 1), -2 * pi / 3 * i)))
    lower = cube(lower.position, product(lower.orientation, about((1, 1, 1), 2 * pi / 3 * (1 - j))))
    separation, normal, axis = box_box_separation(upper, lower)
    assert separation == pytest.approx(1.45 - sqrt(2), abs=1e-14)
    assert normal == pytest.approx((0.0, 0.0, 1.0), abs=1e-14)
    assert axis == 6 + 3 * i + j


def test_the_papers_axes_see_a_hit_where_two_edges_pass_each_other():
    assert box_box_separation(*crossing_edges(1.45))[0] == pytest.approx(1.45 - sqrt(2), abs=1e-14)
    assert box_box_separation(*crossing_edges(1.45), True)[0] < 0.0


def parting(a, b, direction):
    """The gap of two boxes along `direction` from b to a, from their corners."""
    corners = [
        np.array(p) + [rotate(q, tuple(c)) for c in np.array(s) * (np.indices((2, 2, 2)).reshape(3, 8).T - 0.5)]
        for s, p, q in (a, b)
    ]
    return (corners[0] @ direction).min() - (corners[1] @ direction).max()


@given(boxes, boxes, st.lists(places, min_size=5, max_size=5))
def test_no_direction_parts_overlapping_boxes_with_less_motion_than_the_depth(a, b, directions):
    separation, _, _ = box_box_separation(a, b)
    assume(separation < 0.0)
    for d in directions:
        if np.linalg.norm(d) > 0.1:
            assert parting(a, b, np.array(d) / np.linalg.norm(d)) <= separation * (1 - 2e-9) + 1e-12


@given(boxes, boxes)
def test_moving_a_by_the_depth_along_the_normal_just_parts_them(a, b):
    separation, normal, _ = box_box_separation(a, b)
    assume(separation < -1e-3)

    def after(part):
        return box_box_separation(a._replace(position=add(a.position, scale(-part * separation, normal))), b)[0]

    assert after(0.99) < 0.0
    assert after(1.0 + 1e-8) > 0.0


@given(sizes, quaternions)
def test_identical_boxes_overlap_by_their_shortest_side(size, q):
    separation, normal, axis = box_box_separation(PlacedBox(size, ORIGIN, q), PlacedBox(size, ORIGIN, q))
    assert separation == pytest.approx(-min(size), rel=1e-8)
    assert norm(normal) == pytest.approx(1.0, rel=1e-14)
    assert axis < 6


@given(quaternions, places)
def test_a_box_within_another_is_a_hit(q, place):
    inner = tuple(0.1 * c for c in place)
    separation, _, _ = box_box_separation(
        PlacedBox((0.2, 0.3, 0.4), inner, q), PlacedBox((3.0, 3.0, 3.0), ORIGIN, REST)
    )
    assert separation < -1.0


@pytest.mark.parametrize("angle", [0.0, 1e-17, 1e-12, 1e-9, 1e-8, 1e-7, 1e-4, pi / 2, pi / 2 + 1e-9, pi])
def test_nearly_parallel_edges_give_no_false_axis(angle):
    hit = box_box_separation(cube((0.3, 0.2, 0.99), about_z(angle)), CUBE)
    assert hit[0] == pytest.approx(-0.01, abs=1e-3)
    assert hit[1] == pytest.approx((0.0, 0.0, 1.0), abs=1e-12)
    assert hit[2] in (2, 5)
    assert box_box_separation(cube((0.3, 0.2, 1.01), about_z(angle)), CUBE)[0] > 0.0


def test_an_edge_axis_of_equal_overlap_leaves_the_contact_to_the_face():
    """Twisted about z on top of each other: x × x also points along z, with the very same overlap."""
    assert box_box_separation(cube((0.0, 0.0, 0.9), about_z(0.5)), CUBE)[2] == 2


def test_boxes_that_just_touch_count_as_hit():
    assert box_box_separation(cube((1.0, 0.0, 0.0)), CUBE)[0] == 0.0
    still = PlacedBoxes(np.ones((3, 3)), np.zeros((3, 3)), np.tile(REST, (3, 1)))
    moved = still._replace(position=np.array([[1.0, 0.0, 0.0], [1.0 + 1e-12, 0.0, 0.0], [0.0, -0.5, 0.0]]))
    assert box_pairs_overlap(moved, still).tolist() == [True, False, True]


def row(boxes, i):
    return PlacedBox(*(tuple(rows[i].tolist()) for rows in boxes))


def test_pairs_of_an_array_are_judged_as_one_by_one():
    random = np.random.default_rng(2)
    many = []
    for _ in range(2):
        q = random.normal(size=(500, 4))
        size, position = random.uniform(0.2, 2.0, (500, 3)), random.uniform(-1.0, 1.0, (500, 3))
        many.append(PlacedBoxes(size, position, q / np.linalg.norm(q, axis=1, keepdims=True)))
    hits = {paper: box_pairs_overlap(*many, paper) for paper in (False, True)}
    for paper in hits:
        pairs = ((row(boxes, i) for boxes in many) for i in range(500))
        singly = [box_box_separation(*pair, paper)[0] <= 0.0 for pair in pairs]
        assert hits[paper].tolist() == singly
    assert not (hits[False] & ~hits[True]).any()
    assert (hits[True] & ~hits[False]).any()


def test_many_boxes_at_once_are_each_as_alone():
    rng = np.random.default_rng(0)
    sizes, places, turns = rng.uniform(0.3, 2.0, (2, 30, 3)), rng.normal(size=(2, 30, 3)), rng.normal(size=(2, 30, 4))
    turns /= np.linalg.norm(turns, axis=2, keepdims=True)
    pairs = [PlacedBoxes(*rows) for rows in zip(sizes, places, turns)]
    for paper in (False, True):
        separations, normals, axes = box_pairs_separation(*pairs, paper)
        for i in range(30):
            alone = box_box_separation(*(row(boxes, i) for boxes in pairs), paper)
            assert (separations[i], tuple(normals[i]), axes[i]) == alone
        assert box_pairs_overlap(*pairs, paper).tolist() == (separations <= 0.0).tolist()
