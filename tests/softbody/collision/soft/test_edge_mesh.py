"""Edges of soft bodies against surfaces: is what goes through found, and does the way out part them?"""

import numpy as np
import pytest

import softbody
from softbody import World
from softbody.collision.soft.edge_mesh import Ridge, edge_across_edge

pytestmark = pytest.mark.interpreted

# The upper edges of a cube of 2 m, and its faces on both sides.
RIDGE = Ridge((1.0, -1.0, 1.0), (1.0, 1.0, 1.0), (-1.0, 0.0, 1.0), (1.0, 0.0, -1.0))
DEEPEST = 0.5


def turned(ridge: Ridge) -> Ridge:
    return Ridge(ridge.end, ridge.start, ridge.right, ridge.left)


# An edge of another body, above and beside it, that goes through that of the cube.
ACROSS = Ridge((1.3, 0.1, 0.5), (0.5, 0.1, 1.3), (1.5, 1.1, 1.5), (1.5, -0.9, 1.5))


def test_two_ridges_that_cross_are_parted_at_right_angles_to_both():
    depth, normal, place, other_place, _ = edge_across_edge(ACROSS, RIDGE, DEEPEST)
    assert depth == pytest.approx((2.0 - 1.8) / np.sqrt(2.0))
    assert normal == pytest.approx((np.sqrt(0.5), 0.0, np.sqrt(0.5)))
    assert (place, other_place) == (pytest.approx(0.5), pytest.approx(0.55))


def test_neither_edge_is_treated_otherwise_and_no_order_counts():
    one = edge_across_edge(ACROSS, RIDGE, DEEPEST)
    other = edge_across_edge(RIDGE, ACROSS, DEEPEST)
    assert other.depth == pytest.approx(one.depth)
    assert np.array(other.normal) == pytest.approx(-np.array(one.normal))
    assert (other.place, other.other_place) == (pytest.approx(one.other_place), pytest.approx(one.place))
    back = edge_across_edge(turned(ACROSS), turned(RIDGE), DEEPEST)
    assert (back.depth, back.normal) == (pytest.approx(one.depth), pytest.approx(one.normal))
    assert (1.0 - back.place, 1.0 - back.other_place) == (pytest.approx(one.place), pytest.approx(one.other_place))


def test_the_wing_that_faces_the_way_out_is_told():
    steep = Ridge((1.0, -1.0, 1.0), (1.0, 1.0, 1.0), (-1.0, 0.0, 0.9), (0.8, 0.0, -1.0))
    level = ACROSS._replace(start=(1.3, 0.1, 0.95), end=(0.5, 0.1, 0.97))
    assert edge_across_edge(level, steep, DEEPEST).on_left
    assert not edge_across_edge(level, turned(steep), DEEPEST).on_left


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (ACROSS._replace(start=(1.6, 0.1, 0.5), end=(0.8, 0.1, 1.3)), RIDGE),  # passes above
        (ACROSS._replace(start=(1.3, 1.1, 0.5), end=(0.5, 1.1, 1.3)), RIDGE),  # beyond the end
        (ACROSS._replace(start=(0.2, 0.1, -0.5), end=(-0.6, 0.1, 0.3)), RIDGE),  # too deep
        (RIDGE._replace(start=(0.9, -1.0, 0.9), end=(0.9, 1.0, 0.9)), RIDGE),  # parallel
        (ACROSS._replace(left=(-1.0, 0.0, 0.0)), RIDGE),  # its body reaches beyond the plane
        (ACROSS, RIDGE._replace(left=(3.0, 0.0, 1.0))),  # the other's does
        (ACROSS, turned(RIDGE)._replace(left=RIDGE.left, right=RIDGE.right)),  # a valley
    ],
)
def test_edges_that_are_not_across_each_other_are_told_so(one, other):
    assert edge_across_edge(one, other, DEEPEST).depth == 0.0


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
