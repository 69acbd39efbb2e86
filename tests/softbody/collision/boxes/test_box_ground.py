"""Does the ground stop what comes down on it, as restitution and friction say?"""

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import softbody
from softbody.collision.boxes.box_ground import bounce_box, resolve_ground_of_boxes
from softbody.collision.impulse import velocity_of_point
from softbody.dynamics.energy import kinetic_energy
from softbody.geometry.box import box_corners
from softbody.model.arrays import boxes_of
from softbody.model.material import Material
from tests.softbody.placed_boxes import quaternions


def landing(size, height, velocity, angular_velocity=(0.0, 0.0, 0.0), q=(1.0, 0.0, 0.0, 0.0), e=0.0, friction=0.0):
    world = softbody.World()
    world.add_ground(restitution=e, friction=friction)
    world.add_box(size, 2.0, (0.0, 0.0, height), q, velocity, angular_velocity, restitution=e, friction=friction)
    return world


def ground(world):
    grounded = np.ones(len(world.state.box_position), np.bool_)
    resolve_ground_of_boxes(world.model, world.state, boxes_of(world.model, world.state), grounded)
    return grounded


def test_the_boxes_on_the_ground_are_told():
    world = landing((1.0, 1.0, 1.0), 0.4, (0.0, 0.0, 0.0))
    world.add_box((1.0, 1.0, 1.0), 1.0, (5.0, 0.0, 0.6))
    assert ground(world).tolist() == [True, False]


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("size", [(1.0, 1.0, 1.0), (1.0, 2.0, 0.5), (3.0, 0.2, 0.2)])
def test_a_box_that_lands_flat_bounces_straight_up(size, e):
    world = landing(size, size[2] / 2 - 0.01, (0.0, 0.0, -2.0), e=e)
    ground(world)
    assert world.state.box_velocity[0] == pytest.approx([0.0, 0.0, 2.0 * e], abs=1e-6)
    assert world.state.box_angular_velocity[0] == pytest.approx(np.zeros(3), abs=1e-5)
    assert world.state.box_position[0].tolist() == pytest.approx([0.0, 0.0, size[2] / 2])


def test_a_box_that_lands_on_one_corner_obeys_the_law_there():
    q = (cos(0.3), sin(0.3) * 0.6, sin(0.3) * 0.8, 0.0)
    world = landing((1.0, 1.0, 1.0), 0.75, (0.3, 0.2, -2.0), (0.1, 0.2, 0.3), q, e=0.5)
    bodies = boxes_of(world.model, world.state)
    corners = box_corners((1.0, 1.0, 1.0), (0.0, 0.0, 0.75), q)
    low = [tuple(c) for c in corners.tolist() if c[2] < 0.0]
    assert len(low) == 1
    before = velocity_of_point(bodies, 0, low[0])
    bounce_box(bodies, 0, (1.0, 1.0, 1.0), 0.0, Material(0.5, 0.0))
    assert velocity_of_point(bodies, 0, low[0])[2] == pytest.approx(-0.5 * before[2], rel=1e-12)


speeds = st.tuples(*[st.floats(-3.0, 3.0)] * 3)


@given(quaternions, speeds, speeds, st.floats(0.0, 1.0), st.floats(0.0, 2.0), st.floats(0.0, 1.0))
def test_the_ground_leaves_no_corner_below_it_and_never_adds_energy_of_motion(q, v, w, e, friction, height):
    world = landing((1.0, 2.0, 0.5), height, v, w, q, e, friction)
    before = kinetic_energy(world.model, world.state)
    ground(world)
    assert kinetic_energy(world.model, world.state) <= before * (1.0 + 1e-9) + 1e-12
    corners = box_corners((1.0, 2.0, 0.5), tuple(world.state.box_position[0].tolist()), q)
    assert corners[:, 2].min() >= -1e-12


def test_a_box_above_the_ground_and_a_static_box_below_it_are_left_alone():
    world = softbody.World()
    world.add_ground()
    world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, 0.5), velocity=(1.0, 2.0, -3.0))
    world.add_box((1.0, 1.0, 1.0), None, (5.0, 0.0, -2.0))
    before = world.state.copy()
    ground(world)
    assert all((a == b).all() for a, b in zip(world.state, before))


def test_a_box_that_slides_stops_after_v2_over_2_mu_g():
    world = landing((1.0, 1.0, 0.2), 0.1, (2.0, 0.0, 0.0), friction=0.5)
    world.step(1e-3, 1000)
    assert world.state.box_position[0, 0] == pytest.approx(2.0**2 / (2 * 0.5 * 9.81), rel=0.02)
    assert world.state.box_velocity[0] == pytest.approx(np.zeros(3), abs=1e-3)


def test_a_box_slides_for_ever_without_friction():
    world = landing((1.0, 1.0, 0.2), 0.1, (2.0, 0.0, 0.0))
    world.step(1e-3, 1000)
    assert world.state.box_velocity[0, 0] == pytest.approx(2.0, rel=1e-9)


def test_a_box_on_its_edge_falls_on_its_side():
    q = (cos(pi / 8 + 0.02), 0.0, sin(pi / 8 + 0.02), 0.0)
    world = landing((1.0, 1.0, 1.0), 0.71, (0.0, 0.0, 0.0), q=q, friction=0.5)
    world.step(1e-3, 4000)
    assert world.state.box_position[0, 2] == pytest.approx(0.5, abs=1e-3)
    assert np.abs(world.state.box_angular_velocity).max() < 1e-2
