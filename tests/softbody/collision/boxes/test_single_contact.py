"""Is the contact of two boxes where they touch?"""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings

from softbody.collision.boxes.sat_boxes import PlacedBox, box_box_separation
from softbody.collision.boxes.single_contact import box_box_contact, paper_contact
from softbody.linalg.quaternion import product, rotate, rotate_inverse
from softbody.linalg.vec import add, scale, sub
from tests.softbody.placed_boxes import CUBE, ORIGIN, REST, boxes, cube, places, quaternions


def test_a_cube_flat_on_a_cube_touches_in_the_middle_of_the_overlap():
    depth, point, normal = box_box_contact(cube((0.0, 0.0, 0.9)), CUBE)
    assert depth == pytest.approx(0.1, abs=1e-15)
    assert normal == (0.0, 0.0, 1.0)
    assert point == pytest.approx((0.0, 0.0, 0.45), abs=1e-15)


@pytest.mark.parametrize("swap", [False, True])
def test_a_small_box_on_a_wide_plate_is_touched_under_itself(swap):
    small, plate = cube((5.0, 3.0, 0.999)), PlacedBox((20.0, 20.0, 1.0), ORIGIN, REST)
    _, point, normal = box_box_contact(plate, small) if swap else box_box_contact(small, plate)
    assert point == pytest.approx((5.0, 3.0, 0.4995), abs=1e-13)
    assert normal == (0.0, 0.0, -1.0 if swap else 1.0)


@pytest.mark.parametrize("swap", [False, True])
def test_a_cube_that_overhangs_is_touched_in_the_middle_of_the_common_part(swap):
    upper, lower = cube((0.6, 0.2, 0.99)), CUBE
    _, point, _ = box_box_contact(lower, upper) if swap else box_box_contact(upper, lower)
    assert point == pytest.approx((0.3, 0.1, 0.495), abs=1e-14)


@pytest.mark.parametrize("swap", [False, True])
def test_a_box_that_lies_on_another_is_touched_half_way_between_the_two_as_in_the_paper(swap):
    upper, lower = cube((0.6, 0.2, 0.99)), CUBE
    depth, point, normal = paper_contact(lower, upper) if swap else paper_contact(upper, lower)
    assert depth == pytest.approx(0.01, abs=1e-14)
    assert normal == (0.0, 0.0, -1.0 if swap else 1.0)
    assert point == pytest.approx((0.3, 0.1, 0.495), abs=1e-15)
    assert paper_contact(PlacedBox((9.0, 9.0, 1.0), ORIGIN, REST), cube((3.0, 2.0, 0.99)))[1] == (1.5, 1.0, 0.495)


def test_elsewhere_the_papers_contact_is_on_the_surfaces():
    rng = np.random.default_rng(0)
    for _ in range(200):
        size, place, turn = rng.uniform(0.5, 2.0, (2, 3)), rng.uniform(-0.5, 0.5, (2, 3)), rng.normal(size=(2, 4))
        turn /= np.linalg.norm(turn, axis=1)[:, None]
        a, b = (PlacedBox(*(tuple(row[k].tolist()) for row in (size, place, turn))) for k in range(2))
        assert paper_contact(a, b) == box_box_contact(a, b)


def test_a_corner_touches_at_the_corner():
    axis = np.cross([1, 1, 1], [0, 0, 1]) / np.linalg.norm(np.cross([1, 1, 1], [0, 0, 1]))
    angle = np.arccos(1 / sqrt(3))
    corner_down = tuple(float(c) for c in (cos(angle / 2), *(sin(angle / 2) * axis)))
    depth, point, normal = box_box_contact(cube((0.2, 0.1, 1.3), corner_down), CUBE)
    assert depth == pytest.approx(0.5 + sqrt(3) / 2 - 1.3, abs=1e-14)
    assert normal == pytest.approx((0.0, 0.0, 1.0), abs=1e-14)
    assert point == pytest.approx((0.2, 0.1, 0.5 - depth / 2), abs=1e-14)


def test_an_edge_flat_on_a_face_touches_at_its_middle():
    turned = (cos(pi / 8), 0.0, sin(pi / 8), 0.0)
    depth, point, _ = box_box_contact(cube((0.1, 0.0, 1.2), turned), CUBE)
    assert point == pytest.approx((0.1, 0.0, 0.5 - depth / 2), abs=1e-14)


def test_edges_that_cross_touch_where_they_cross():
    """The upper cube stands on an edge along x, the lower one has its uppermost edge along y."""
    upper = (cos(pi / 8), sin(pi / 8), 0.0, 0.0)
    lower = (cos(pi / 8), 0.0, sin(pi / 8), 0.0)
    depth, point, normal = box_box_contact(cube((0.2, 0.3, 1.4), upper), cube(ORIGIN, lower))
    assert depth == pytest.approx(sqrt(2) - 1.4, abs=1e-14)
    assert normal == pytest.approx((0.0, 0.0, 1.0), abs=1e-14)
    assert point == pytest.approx((0.0, 0.3, 0.7), abs=1e-14)


def test_boxes_apart_have_a_negative_depth():
    assert box_box_contact(cube((0.0, 0.0, 1.5)), CUBE)[0] == -0.5


def test_a_box_beyond_the_papers_axes_is_touched_by_them_only():
    upper = (cos(pi / 8), sin(pi / 8), 0.0, 0.0)
    lower = (cos(pi / 8), 0.0, sin(pi / 8), 0.0)
    pair = cube((0.0, 0.0, 1.45), upper), cube(ORIGIN, lower)
    assert box_box_contact(*pair)[0] < 0.0
    assert box_box_contact(*pair, True)[0] > 0.0


def outside(point, box):
    """How far [m] a point lies beyond the faces of a box; negative inside."""
    size, place, q = box
    local = rotate_inverse(q, sub(point, place))
    return max(abs(c) - s / 2 for c, s in zip(local, size))


def barely_touching(a, b, depth=1e-6):
    """Box a moved along the normal until it overlaps b by `depth` only."""
    deep, _, normal = box_box_contact(a, b)
    return a._replace(position=add(a.position, scale(deep - depth, normal)))


def lies_flat(box, direction):
    """Whether an edge or a face of a box, and not one corner, lies farthest along `direction`."""
    size, _, q = box
    reach = sorted(abs(s * c) for s, c in zip(size, rotate_inverse(q, direction)))
    return reach[0] < 1e-4


@settings(suppress_health_check=[HealthCheck.filter_too_much])  # four pairs in five are apart
@given(boxes, boxes)
def test_the_point_lies_on_the_surface_of_both_boxes_that_barely_touch_at_a_corner_or_edge(a, b):
    """Where faces lie flat but twisted, the point is only near both: there the contact is a polygon."""
    assume(box_box_contact(a, b)[0] > 0.0)
    a = barely_touching(a, b)
    depth, point, normal = box_box_contact(a, b)
    assume(0.5e-6 < depth < 2e-6)
    assume(not (lies_flat(a, normal) and lies_flat(b, normal)))
    assert abs(outside(point, a)) < 1e-5
    assert abs(outside(point, b)) < 1e-5


@given(boxes, boxes)
def test_the_point_is_half_way_between_the_surfaces_along_the_normal(a, b):
    depth, point, normal = box_box_contact(a, b)
    assume(depth > 1e-3)
    corners = (np.indices((2, 2, 2)).reshape(3, 8).T - 0.5) * 1.0
    lowest = min(np.dot(add(a[1], rotate(a[2], tuple(c * a[0]))), normal) for c in corners)
    highest = max(np.dot(add(b[1], rotate(b[2], tuple(c * b[0]))), normal) for c in corners)
    assert np.dot(point, normal) == pytest.approx(0.5 * (lowest + highest), abs=1e-8)


@given(boxes, boxes, quaternions, places)
def test_the_point_moves_and_turns_with_the_boxes(a, b, turn, offset):
    def moved(box):
        return PlacedBox(box.size, add(rotate(turn, box.position), offset), product(turn, box.orientation))

    # Where axes tie, rounding picks one; boxes with faces on each other have one normal from either's face.
    assume(box_box_separation(a, b)[2] == box_box_separation(moved(a), moved(b))[2])
    depth, point, normal = box_box_contact(a, b)
    depth_moved, point_moved, normal_moved = box_box_contact(moved(a), moved(b))
    assume(np.dot(rotate(turn, normal), normal_moved) > 1.0 - 1e-9)  # a tie of edges gives one axis two signs
    assert depth_moved == pytest.approx(depth, rel=3e-9, abs=1e-12)
    assert point_moved == pytest.approx(add(rotate(turn, point), offset), abs=1e-6)
