"""Do the points of a manifold lie where the boxes touch, as deep as the boxes overlap there?"""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import assume, given

from softbody.collision.boxes.manifold import box_box_manifold, box_pairs_manifolds, new_manifold
from softbody.collision.boxes.sat_boxes import (
    FACE_PREFERENCE,
    ROUNDING,
    SAME_COSINE,
    Limits,
    PlacedBoxes,
    box_box_separation,
    frames_of,
)
from softbody.collision.edge_edge import PARALLEL_SINE
from softbody.linalg.quaternion import rotate_inverse
from tests.softbody.placed_boxes import ORIGIN, REST, UNIT, boxes


def manifold(a, b, margin=0.0):
    """Points sorted by x, y, z; their depths; and the normal."""
    pair = [PlacedBoxes(*(np.array([part], float) for part in box)) for box in (a, b)]
    count, normal, point, depth = box_pairs_manifolds(*pair, margin, False)
    rows = sorted((*p, d) for p, d in zip(np.round(point[0, : count[0]], 12).tolist(), depth[0, : count[0]].tolist()))
    return [row[:3] for row in rows], [row[3] for row in rows], normal[0].tolist()


def test_a_cube_flat_on_a_cube_touches_at_four_corners():
    points, depths, normal = manifold((UNIT, (0.0, 0.0, 0.9), REST), (UNIT, ORIGIN, REST))
    assert points == [(x, y, 0.45) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
    assert depths == pytest.approx([0.1] * 4, abs=1e-15)
    assert normal == [0.0, 0.0, 1.0]


def test_a_small_box_on_a_wide_plate_touches_under_its_corners_whichever_is_a():
    small, plate = ((1.0, 2.0, 1.0), (5.0, 3.0, 0.999), REST), ((20.0, 20.0, 1.0), ORIGIN, REST)
    corners = [(x, y, 0.4995) for x in (4.5, 5.5) for y in (2.0, 4.0)]
    assert manifold(small, plate)[0] == corners
    assert manifold(plate, small)[0] == corners
    assert manifold(plate, small)[2] == [0.0, 0.0, -1.0]


def test_a_cube_that_overhangs_touches_at_the_corners_of_the_common_part():
    points, _, _ = manifold((UNIT, (0.6, 0.2, 0.99), REST), (UNIT, ORIGIN, REST))
    assert points == [(x, y, 0.495) for x in (0.1, 0.5) for y in (-0.3, 0.5)]


def test_a_cube_turned_by_45_degrees_on_another_touches_at_the_eight_corners_of_an_octagon():
    turned = (cos(pi / 8), 0.0, 0.0, sin(pi / 8))
    points, depths, _ = manifold((UNIT, (0.0, 0.0, 1.0), turned), (UNIT, ORIGIN, REST))
    a = round(sqrt(0.5) - 0.5, 12)
    octagon = [(x * s, y * t, 0.5) for x, y in ((0.5, a), (a, 0.5)) for s in (1, -1) for t in (1, -1)]
    assert points == sorted(octagon)
    assert depths == pytest.approx([0.0] * 8, abs=1e-15)


def test_a_corner_touches_at_the_corner():
    axis = np.cross([1, 1, 1], [0, 0, 1]) / sqrt(2)
    angle = np.arccos(1 / sqrt(3))
    corner_down = tuple(float(c) for c in (cos(angle / 2), *(sin(angle / 2) * axis)))
    points, depths, normal = manifold((UNIT, (0.2, 0.1, 1.3), corner_down), (UNIT, ORIGIN, REST))
    depth = 0.5 + sqrt(3) / 2 - 1.3
    assert points == [pytest.approx((0.2, 0.1, 0.5 - depth / 2), abs=1e-12)]
    assert depths == pytest.approx([depth], abs=1e-14)
    assert normal == pytest.approx((0.0, 0.0, 1.0), abs=1e-14)


def test_an_edge_flat_on_a_face_touches_at_both_ends():
    turned = (cos(pi / 8), 0.0, sin(pi / 8), 0.0)
    points, depths, _ = manifold((UNIT, (0.1, 0.0, 1.2), turned), (UNIT, ORIGIN, REST))
    z = round(0.5 - depths[0] / 2, 12)
    assert points == [(0.1, -0.5, z), (0.1, 0.5, z)]


def test_edges_that_cross_touch_once_where_they_cross():
    upper, lower = (cos(pi / 8), sin(pi / 8), 0.0, 0.0), (cos(pi / 8), 0.0, sin(pi / 8), 0.0)
    points, depths, normal = manifold((UNIT, (0.2, 0.3, 1.4), upper), (UNIT, ORIGIN, lower))
    assert points == [pytest.approx((0.0, 0.3, 0.7), abs=1e-12)]
    assert depths == pytest.approx([sqrt(2) - 1.4], abs=1e-14)
    assert normal == pytest.approx((0.0, 0.0, 1.0), abs=1e-14)


def test_a_box_inside_a_larger_one_leaves_by_the_nearest_face():
    points, depths, normal = manifold((UNIT, (0.0, 0.0, 3.0), REST), ((10.0, 10.0, 8.0), ORIGIN, REST))
    assert len(points) == 4
    assert depths == [1.5] * 4
    assert normal == [0.0, 0.0, 1.0]


def test_touching_is_contact_and_the_margin_is_how_far_it_reaches():
    lower = (UNIT, ORIGIN, REST)
    assert len(manifold((UNIT, (0.0, 0.0, 1.0), REST), lower)[0]) == 4
    above = (UNIT, (0.0, 0.0, 1.001), REST)
    assert manifold(above, lower)[0] == []
    points, depths, _ = manifold(above, lower, margin=0.002)
    assert len(points) == 4
    assert depths == pytest.approx([-0.001] * 4, abs=1e-15)


def outside(point, box):
    """How far [m] a point lies beyond the faces of a box; negative inside."""
    size, place, q = box
    return max(abs(c) - s / 2 for c, s in zip(rotate_inverse(q, tuple(np.subtract(point, place).tolist())), size))


def smallest_sine(a, b):
    """The sine of the smallest angle between an edge of a and one of b that are not parallel."""
    axes = frames_of(PlacedBoxes(*(np.array([one, other], float) for one, other in zip(a, b)))).axes
    sines = [np.linalg.norm(np.cross(one, other)) for one in axes[0] for other in axes[1]]
    return min((sine for sine in sines if sine >= PARALLEL_SINE), default=1.0)


@given(boxes, boxes)
def test_a_manifold_has_the_normal_of_the_separating_axis_test_and_no_greater_depth(a, b):
    separation, normal, _ = box_box_separation(a, b)
    points, depths, found = manifold(a, b)
    rounding = ROUNDING * sum(a.size + b.size)
    if abs(separation) > rounding:  # boxes that just touch: the two forms round differently
        assert bool(points) == (separation < 0.0)
    if points:
        assert np.linalg.norm(found) == pytest.approx(1.0, abs=1e-14)
        # A face is preferred to a pair of edges by this much, the more the more nearly these are parallel.
        preference = FACE_PREFERENCE * abs(separation) + rounding / smallest_sine(a, b)
        # And to a pair of edges whose axis is all but its own normal.
        preference += (1.0 - SAME_COSINE) * sum(a.size + b.size)
        assert max(depths) <= -separation + preference
        assert found == pytest.approx(normal, abs=1e-9) or max(depths) == pytest.approx(-separation, abs=preference)


@given(boxes, boxes)
def test_the_points_of_boxes_that_barely_overlap_lie_on_the_surfaces_of_both(a, b):
    separation, normal, _ = box_box_separation(a, b)
    assume(separation < 0.0)
    a = a._replace(position=tuple((np.array(a.position) + (-separation - 1e-6) * np.array(normal)).tolist()))
    points, depths, _ = manifold(a, b)
    for point, depth in zip(points, depths):
        assert depth <= 2e-6
        assert abs(outside(point, a)) < 1e-5
        assert abs(outside(point, b)) < 1e-5


def test_features_stay_the_same_while_boxes_move_a_little():
    random = np.random.default_rng(5)
    size = np.array([[1.0, 1.2, 0.8], [1.1, 0.9, 1.0]])
    place = np.array([[0.1, 0.2, 0.89], [0.0, 0.0, 0.0]])
    turn = np.array([[1.0, 0.01, 0.02, 0.1], [1.0, 0.0, 0.0, 0.0]])
    seen = set()
    for _ in range(50):
        q = turn + 1e-5 * random.normal(size=(2, 4))
        q /= np.linalg.norm(q, axis=1, keepdims=True)
        found = new_manifold()
        x = place + 1e-5 * random.normal(size=(2, 3))
        count = box_box_manifold(frames_of(PlacedBoxes(size, x, q)), 0, 1, Limits(0.0, 0.0, False), found)
        seen.add(tuple(found.feature[:count].tolist()))
    assert len(seen) == 1
