"""Do free boxes fly, fall and turn as Euler–Cromer says?"""

from math import cos, sin

import numpy as np
import pytest

import softbody
from softbody.dynamics.rigid import move_boxes

G = np.array([1.0, 0.0, -10.0])


@pytest.fixture
def world():
    world = softbody.World(gravity=G)
    world.add_box((1.0, 2.0, 3.0), 4.0, velocity=(1.0, 2.0, 3.0), angular_velocity=(0.0, 0.0, 0.5))
    world.add_box((1.0, 1.0, 1.0), None, position=(9.0, 9.0, 9.0))
    return world


def test_velocity_moves_first_then_position_by_the_new_velocity(world):
    move_boxes(world.model, world.state, 0.5)
    assert world.state.box_velocity[0].tolist() == [1.5, 2.0, -2.0]
    assert world.state.box_position[0].tolist() == [0.75, 1.0, -1.0]


def test_a_box_turns_by_its_angular_velocity_times_the_step(world):
    for _ in range(10):
        move_boxes(world.model, world.state, 0.1)
    assert world.state.box_orientation[0] == pytest.approx([cos(0.25), 0.0, 0.0, sin(0.25)], abs=1e-15)


def test_a_turn_about_a_fixed_axis_is_exact_whatever_the_step():
    fine, coarse = softbody.World(), softbody.World()
    for world, steps in ((fine, 1000), (coarse, 1)):
        world.add_box((1.0, 2.0, 3.0), 4.0, angular_velocity=(0.3, -0.2, 0.7))
        for _ in range(steps):
            move_boxes(world.model, world.state, 1.0 / steps)
    assert coarse.state.box_orientation == pytest.approx(fine.state.box_orientation, abs=1e-13)


def test_a_static_box_stays_where_it_is(world):
    move_boxes(world.model, world.state, 0.5)
    assert world.state.box_position[1].tolist() == [9.0, 9.0, 9.0]
    assert not world.state.box_velocity[1].any()


def test_an_orientation_stays_of_unit_length():
    world = softbody.World()
    world.add_box((1.0, 2.0, 3.0), 4.0, angular_velocity=(3.0, -20.0, 7.0))
    for _ in range(1000):
        move_boxes(world.model, world.state, 0.01)
    assert np.linalg.norm(world.state.box_orientation[0]) == pytest.approx(1.0, abs=1e-15)
