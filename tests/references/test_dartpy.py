import numpy as np
import pytest

from references.dartpy import DartWorld

G = 9.81
UPRIGHT = (1.0, 0.0, 0.0, 0.0)
STILL = np.zeros(3)
DEEP = 1e-9  # [m] inside what it stands on


def yawed(angle):
    return np.cos(0.5 * angle), 0.0, 0.0, np.sin(0.5 * angle)


@pytest.fixture
def world():
    made = DartWorld(1e-3)
    made.add_ground(0.3)
    return made


def test_a_box_falls_as_semi_implicit_euler_says_and_lands(world):
    world.add_box((1.0, 1.0, 1.0), 2.0, (0.0, 0.0, 0.6), UPRIGHT, STILL, STILL, 0.5)
    world.step(100)
    assert world.positions()[0] == pytest.approx([0.0, 0.0, 0.6 - G * 1e-6 * 5050.0], abs=1e-12)
    assert world.velocities()[0] == pytest.approx([0.0, 0.0, -0.981, 0.0, 0.0, 0.0], abs=1e-12)
    world.step(900)
    assert world.positions()[0] == pytest.approx([0.0, 0.0, 0.5], abs=2e-3)
    assert world.velocities()[0] == pytest.approx(np.zeros(6), abs=1e-5)


@pytest.mark.parametrize("direction", [0.0, 0.5, np.pi / 4.0, 2.0])
def test_friction_is_a_cone_and_not_a_pyramid(world, direction):
    way = np.array([np.cos(direction), np.sin(direction), 0.0])
    world.add_box((1.0, 0.8, 0.3), 2.0, (0.0, 0.0, 0.15 - DEEP), yawed(0.7), 1.5 * way, STILL, 0.9)
    world.step(200)
    assert world.velocities()[0, :3] == pytest.approx((1.5 - 0.3 * G * 0.2) * way, abs=1e-6)
    world.step(800)
    assert world.velocities()[0] == pytest.approx(np.zeros(6), abs=1e-6)


def test_the_smaller_friction_of_two_counts():
    for ground, box in ((0.3, 0.9), (0.9, 0.3)):
        world = DartWorld(1e-3)
        world.add_ground(ground)
        world.add_box((1.0, 0.8, 0.3), 2.0, (0.0, 0.0, 0.15 - DEEP), UPRIGHT, (1.5, 0.0, 0.0), STILL, box)
        world.step(200)
        assert world.velocities()[0, 0] == pytest.approx(1.5 - 0.3 * G * 0.2, abs=1e-6)


def test_a_box_that_spins_is_slowed_at_four_corners(world):
    world.add_box((1.0, 0.8, 0.3), 2.0, (0.1, 0.2, 0.15 - DEEP), yawed(0.7), STILL, (0.0, 0.0, 5.0), 0.3)
    world.step(200)
    slowing = 6.0 * 0.3 * G / np.hypot(1.0, 0.8)
    assert world.velocities()[0] == pytest.approx([0.0, 0.0, 0.0, 0.0, 0.0, 5.0 - 0.2 * slowing], abs=1e-6)


def test_a_box_drags_the_free_one_under_it():
    world = DartWorld(1e-3)
    world.add_ground(0.0)
    world.add_box((2.0, 2.0, 0.2), 3.0, (0.0, 0.0, 0.1 - DEEP), UPRIGHT, STILL, STILL, 0.4)
    world.add_box((0.5, 0.5, 0.2), 1.0, (0.0, 0.0, 0.3 - 2.0 * DEEP), yawed(0.3), (0.0, 1.0, 0.0), STILL, 0.4)
    world.step(100)
    lower, upper = world.velocities()
    assert upper[1] == pytest.approx(1.0 - 0.4 * G * 0.1, abs=1e-5)
    assert lower[1] == pytest.approx(0.4 * G * 0.1 / 3.0, abs=1e-5)
    world.step(400)
    assert world.velocities()[:, 1] == pytest.approx([0.25, 0.25], abs=1e-5)


def test_the_motion_is_that_of_the_world_frame_and_a_quiet_box_does_not_sleep():
    world = DartWorld(1e-2, gravity=0.0)
    turn = (0.5, 0.5, 0.5, 0.5)  # by 120° about (1, 1, 1): x becomes y
    world.add_box((1.0, 1.0, 1.0), 1.0, STILL, turn, (1e-3, 2e-3, 3e-3), (1e-3, 0.0, 0.0), 0.5)
    assert world.rotations()[0] @ [1.0, 0.0, 0.0] == pytest.approx([0.0, 1.0, 0.0], abs=1e-15)
    world.step(200)
    assert world.positions()[0] == pytest.approx([2e-3, 4e-3, 6e-3], abs=1e-12)
    assert world.velocities()[0] == pytest.approx([1e-3, 2e-3, 3e-3, 1e-3, 0.0, 0.0], abs=1e-12)
