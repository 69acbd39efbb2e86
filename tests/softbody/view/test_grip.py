"""A body that is pulled comes to where the mouse is, and is left as it was when it is let go."""

from __future__ import annotations

import numpy as np
import pytest

import softbody
from softbody.view.grip import MOST_PULL, Grip

TARGET = np.array([0.5, 0.2, 3.0])


def soft_world():
    world = softbody.World()
    body = world.add_soft_body(softbody.icosphere(2), 2.0, 300.0, 30.0, (0.0, 0.0, 1.0), damping=0.2)
    body.external_force = (1e-3, 0.0, 0.0)
    return world, body, lambda: body.centre


def box_world():
    world = softbody.World()
    box = world.add_box((1.0, 1.0, 1.0), 3.0, (0.0, 0.0, 1.0))
    box.apply_force((0.25, 0.0, 0.0))
    return world, box, lambda: box.position


def act(world):
    controls = world.controls
    return np.concatenate([controls.particle_force, controls.box_force, controls.box_torque])


@pytest.mark.parametrize("make", [soft_world, box_world])
def test_what_is_pulled_comes_to_the_mouse_and_hangs_a_little_below(make):
    world, body, centre = make()
    before, grip = act(world).copy(), Grip(world.store)
    grip.grab(body, centre() + [0.0, 0.0, 0.5])
    grip.target = TARGET
    for _ in range(1500):
        grip.pull()
        world.step(2e-3, 2)
    line = grip.line()
    sag = 9.81 / (2.0 * np.pi * 1.5) ** 2  # g / ω²
    np.testing.assert_allclose(line[1] - line[0], (0.0, 0.0, sag), atol=0.03)
    assert centre()[2] < line[0][2]
    grip.let_go()
    assert not grip.is_holding
    assert grip.line() is None
    np.testing.assert_array_equal(act(world), before)


@pytest.mark.parametrize("make", [soft_world, box_world])
def test_a_mouse_that_is_far_away_tears_nothing(make):
    world, body, centre = make()
    before, grip = act(world).copy(), Grip(world.store)
    grip.grab(body, centre())
    grip.target = np.array([1e9, 0.0, 0.0])
    grip.pull()
    mass = 2.0 if isinstance(body, softbody.SoftBody) else 3.0
    assert np.linalg.norm((act(world) - before).sum(axis=0)) == pytest.approx(mass * MOST_PULL)


def test_a_box_that_cannot_move_is_not_pulled():
    world = softbody.World()
    box = world.add_box((1.0, 1.0, 1.0), None)
    grip = Grip(world.store)
    grip.grab(box, box.position)
    grip.target = TARGET
    grip.pull()
    np.testing.assert_array_equal(act(world), 0.0)


def test_a_second_grab_lets_go_of_the_first():
    world, body, centre = soft_world()
    other = world.add_soft_body(softbody.icosphere(1), 1.0, 300.0, 30.0, (5.0, 0.0, 1.0))
    before, grip = act(world).copy(), Grip(world.store)
    grip.grab(body, centre())
    grip.target = TARGET
    grip.pull()
    grip.grab(other, other.centre)
    np.testing.assert_array_equal(act(world), before)


def test_an_empty_hand_pulls_nothing():
    world, _, _ = soft_world()
    before = act(world).copy()
    Grip(world.store).pull()
    np.testing.assert_array_equal(act(world), before)


def test_a_body_that_tears_in_the_hand_slips_out_of_it():
    world = softbody.World(gravity=(0.0, 0.0, 0.0))
    ball = world.add_soft_body(softbody.icosphere(2), 1.0, 100.0, 1.0, tear_at=1.5)
    grip = Grip(world.store)
    grip.grab(ball, ball.positions[0])
    grip.target = ball.positions[0] + (0.0, 0.0, 2.0)
    grip.pull()
    assert ball.external_force.any()
    ball.positions = 1.6 * ball.positions
    world.step(1e-6)
    assert world.events
    grip.line()
    grip.pull()
    assert not grip.is_holding
    assert not any(each.external_force.any() for each in world.soft_bodies)
