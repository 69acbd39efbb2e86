"""Does a step find faults, part boxes, and stop before it spoils the state?"""

import numpy as np
import pytest

import softbody
from softbody import World
from softbody.state import boxes_of
from softbody.step import COLLAPSED, DIVERGED, collide_boxes, find_fault, separate

SOLID = softbody.octahedron()


@pytest.fixture
def pair():
    """Two octahedra, the second at x = 5, at rest."""
    world = World()
    world.add_soft_body(SOLID, 1.0, 1.0, 1.0)
    world.add_soft_body(SOLID, 1.0, 1.0, 1.0, position=(5.0, 0.0, 0.0))
    return world.model, world.state.position, world.state.velocity


def test_bodies_at_rest_are_without_fault(pair):
    assert find_fault(*pair, 0.01) == (0, -1)


@pytest.mark.parametrize(("particle", "body"), [(2, 0), (8, 1)])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("array", [1, 2], ids=["position", "velocity"])
def test_a_particle_that_is_not_finite_is_a_fault_of_its_body(pair, particle, body, value, array):
    pair[array][particle, 1] = value
    assert find_fault(*pair, 0.01) == (DIVERGED, body)


def test_a_particle_that_would_cross_its_body_in_one_step_is_a_fault(pair):
    """Extent 2 m, step 0.01 s: 200 m/s from the mean velocity, of which the particle itself takes a sixth."""
    limit = 200.0 * 6 / 5
    pair[2][7, 2] = 0.99 * limit
    assert find_fault(*pair, 0.01) == (0, -1)
    pair[2][7, 2] = 1.01 * limit
    assert find_fault(*pair, 0.01) == (DIVERGED, 1)


@pytest.mark.parametrize("squeeze", [0.0, -1.0])
def test_a_body_that_is_flat_or_inside_out_has_collapsed(pair, squeeze):
    pair[1][6:, 2] *= squeeze
    assert find_fault(*pair, 0.01) == (COLLAPSED, 1)


def boxes(static=False):
    world = World()
    world.add_box((1.0, 1.0, 1.0), None if static else 1.0)
    world.add_box((1.0, 1.0, 1.0), 3.0, (0.9, 0.0, 0.0), velocity=(-4.0, 0.0, 0.0))
    return world


def test_boxes_part_by_their_depth_in_inverse_proportion_to_their_masses():
    world = boxes()
    collide_boxes(world.model, world.state, boxes_of(world.model, world.state), world.rules)
    assert world.state.box_position[:, 0] == pytest.approx([-0.075, 0.925], abs=1e-14)
    assert world.state.box_velocity[:, 0] == pytest.approx([-3.0, -3.0], rel=1e-14)


def test_a_static_box_does_not_give_way():
    world = boxes(static=True)
    collide_boxes(world.model, world.state, boxes_of(world.model, world.state), world.rules)
    assert world.state.box_position[:, 0] == pytest.approx([0.0, 1.0], abs=1e-14)
    assert world.state.box_velocity[:, 0].tolist() == [0.0, 0.0]


def test_two_static_boxes_may_overlap_for_ever():
    world = World()
    world.add_box((1.0, 1.0, 1.0), None)
    world.add_box((1.0, 1.0, 1.0), None, (0.5, 0.0, 0.0))
    before = world.state.copy()
    world.step(1e-3, 10)
    assert all((a == b).all() for a, b in zip(world.state, before))


def test_separation_keeps_the_centre_of_mass():
    world = boxes()
    bodies = boxes_of(world.model, world.state)
    separate(bodies, 1, 0, (3.0, 6.0, 9.0))
    assert bodies.position.tolist() == [[-3.0, -6.0, -9.0], [0.9 + 1.0, 2.0, 3.0]]
