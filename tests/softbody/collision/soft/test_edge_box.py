"""Is a segment found in a box exactly where it is inside, and does the way out part them?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from softbody.collision.boxes.sat_boxes import PlacedBox
from softbody.collision.soft.edge_box import edge_in_box

pytestmark = pytest.mark.interpreted

SIZE, HERE, UPRIGHT = (2.0, 2.0, 2.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)

numbers = st.floats(-2.0, 2.0).map(lambda x: round(x, 3))
points = st.tuples(numbers, numbers, numbers)


def shortest_way_out(p, q, place=HERE, orientation=UPRIGHT):
    """The answer for an edge that has been where it is."""
    box = PlacedBox(SIZE, place, orientation)
    return edge_in_box((p, q), box, (p, q), box)


def inside_somewhere(p, q, size=SIZE):
    """Whether some point of the segment is strictly inside, by clipping in another way: finely spaced points."""
    t = np.linspace(0.0, 1.0, 4001)[:, None]
    x = (1.0 - t) * np.array(p) + t * np.array(q)
    return bool((np.abs(x) < 0.5 * np.array(size)).all(axis=1).any())


def test_an_edge_that_cuts_a_side_of_the_box_is_pushed_out_at_right_angles_to_both():
    depth, normal, place = shortest_way_out((1.2, 0.0, 0.5), (0.5, 0.0, 1.2))
    assert depth == pytest.approx((2.0 - 1.7) / np.sqrt(2.0))
    assert normal == pytest.approx((np.sqrt(0.5), 0.0, np.sqrt(0.5)))
    assert place == pytest.approx(0.5)


def test_an_edge_that_lies_below_a_face_is_pushed_out_through_it_at_its_middle():
    depth, normal, place = shortest_way_out((-3.0, 0.3, 0.9), (3.0, 0.3, 0.9))
    assert depth == pytest.approx(0.1)
    assert normal == (0.0, 0.0, 1.0)
    assert place == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("p", "q"),
    [
        ((1.5, 0.0, 0.0), (3.0, 0.0, 0.0)),  # beyond a face
        ((2.1, 0.0, 0.0), (0.0, 0.0, 2.1)),  # past a side
        ((1.0, -5.0, 0.0), (1.0, 5.0, 0.0)),  # in a face
        ((1.5, 0.0, 0.0), (1.5, 0.0, 0.0)),  # a point
    ],
)
def test_an_edge_outside_has_no_depth(p, q):
    assert shortest_way_out(p, q)[0] <= 0.0


@given(points, points)
def test_the_depth_says_whether_any_point_is_inside_and_the_way_out_parts_them(p, q):
    depth, normal, place = shortest_way_out(p, q)
    if inside_somewhere(p, q):
        assert depth > 0.0
    if depth > 0.0:
        assert np.linalg.norm(normal) == pytest.approx(1.0)
        assert (np.abs((1.0 - place) * np.array(p) + place * np.array(q)) <= 1.0 + 1e-12).all()
        out = (1.0 + 1e-9) * depth * np.array(normal)
        assert not inside_somewhere(out + p, out + q)
        nearly = 0.99 * depth * np.array(normal)
        moved = shortest_way_out(tuple(nearly + p), tuple(nearly + q))[0]
        assert moved == pytest.approx(0.01 * depth, rel=1e-6, abs=1e-12)


BOX = PlacedBox(SIZE, HERE, UPRIGHT)


@pytest.mark.parametrize(
    ("before", "depth", "normal"),
    [
        (((-1.0, 0.5, 1.2), (1.0, 0.5, 1.2)), 1.8, (0.0, 0.0, 1.0)),  # it came from above
        (((-1.0, 0.5, 0.9), (1.0, 0.5, 0.9)), 1.8, (0.0, 0.0, 1.0)),  # it was a little inside already
        (((-1.0, 1.2, -0.8), (1.0, 1.2, -0.8)), 0.5, (0.0, 1.0, 0.0)),  # from aside
        (((-1.0, 2.0, 1.1), (1.0, 2.0, 1.1)), 0.5, (0.0, 1.0, 0.0)),  # from both: in by the side at last
        (((-1.0, 0.5, -1.2), (1.0, 0.5, -1.2)), 0.2, (0.0, 0.0, -1.0)),  # from below
    ],
)
def test_an_edge_goes_back_by_the_way_it_came(before, depth, normal):
    found = edge_in_box(((-1.0, 0.5, -0.8), (1.0, 0.5, -0.8)), BOX, before, BOX)
    assert found[0] == pytest.approx(depth)
    assert found[1] == pytest.approx(normal)


def test_an_edge_that_turns_while_it_cuts_a_side_goes_back_across_that_side():
    depth, normal, _ = edge_in_box(((0.8, -0.1, 0.5), (0.5, 0.1, 0.8)), BOX, ((1.6, 0.1, 0.5), (0.5, -0.1, 1.6)), BOX)
    assert min(normal[0], normal[2]) > 0.5
    assert depth > 0.4


@given(points, points, st.tuples(numbers, numbers, numbers, numbers).filter(lambda q: np.linalg.norm(q) > 0.1), points)
def test_the_answer_turns_and_moves_with_both(p, q, turn, shift):
    from softbody.linalg.quaternion import rotate

    unit = tuple(np.array(turn) / np.linalg.norm(turn))
    depth = shortest_way_out(p, q)[0]
    moved = [tuple(np.array(rotate(unit, x)) + shift) for x in (p, q)]
    there = shortest_way_out(*moved, shift, unit)
    if max(depth, there[0]) > 1e-9:
        assert there[0] == pytest.approx(depth, abs=1e-12)
