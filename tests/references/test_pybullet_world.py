import numpy as np
import pytest

from references.pybullet_world import BulletWorld, closest, velocities_after


def test_a_box_falls_as_semi_implicit_euler_says_and_lands():
    world = BulletWorld(1e-2, 50)
    world.add_ground()
    world.add_box((1.0, 1.0, 1.0), 2.0, (0.0, 0.0, 2.0))
    world.step(10)
    assert world.positions()[0] == pytest.approx([0.0, 0.0, 2.0 - 9.81e-4 * 55], abs=1e-9)
    assert world.velocities()[0] == pytest.approx([0.0, 0.0, -0.981, 0.0, 0.0, 0.0], abs=1e-9)
    world.step(290)
    assert world.positions()[0, 2] == pytest.approx(0.5, abs=1e-2)
    world.close()


def test_the_depth_of_two_cubes_by_hand():
    upright = np.array([[1.0, 0.0, 0.0, 0.0]])
    distance, normal = closest(np.ones((1, 3)), [[0.1, 0.2, 0.9]], upright, np.ones((1, 3)), np.zeros((1, 3)), upright)
    assert distance == pytest.approx([-0.1], abs=1e-15)
    assert normal[0] == pytest.approx([0.0, 0.0, 1.0], abs=1e-15)


def test_deepest_tells_boxes_from_the_ground():
    world = BulletWorld(1e-3, 50)
    world.add_ground()
    world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, 0.48))
    world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, 1.45))
    world.step()
    assert world.deepest() == pytest.approx((0.03, 0.02), abs=2e-3)
    world.close()


@pytest.mark.parametrize(("aside", "struck"), [(0.999, True), (1.001, False)])
def test_cubes_that_pass_are_struck_if_they_overlap(aside, struck):
    velocity, spin = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]), np.zeros((2, 3))
    upright = [[1.0, 0.0, 0.0, 0.0]] * 2
    place = [[-1.5, aside, 0.0], [0.0, 0.0, 0.0]]
    after = velocities_after(np.ones((2, 3)), [1.0, np.inf], place, upright, velocity, spin, 1e-3, 3000)
    assert (np.abs(after[:, :3] - velocity).max() > 1e-4) == struck
    assert np.array_equal(after[1], np.zeros(6))
