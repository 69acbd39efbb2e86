"""Do free boxes fly, fall and turn as Euler–Cromer says?"""

from math import cos, sin

import numpy as np
import pytest

import softbody
from softbody.dynamics.rigid_boxes import accelerate_boxes, advance_boxes, nearest_right_angles
from softbody.linalg.quaternion import product


def fly(world, h):
    accelerate_boxes(world.model, world.controls, world.state, h)
    advance_boxes(world.model, world.state, h, False)


G = np.array([1.0, 0.0, -10.0])


@pytest.fixture
def world():
    world = softbody.World(gravity=G)
    world.add_box((1.0, 2.0, 3.0), 4.0, velocity=(1.0, 2.0, 3.0), angular_velocity=(0.0, 0.0, 0.5))
    world.add_box((1.0, 1.0, 1.0), None, position=(9.0, 9.0, 9.0))
    return world


def test_velocity_moves_first_then_position_by_the_new_velocity(world):
    fly(world, 0.5)
    assert world.state.box_velocity[0].tolist() == [1.5, 2.0, -2.0]
    assert world.state.box_position[0].tolist() == [0.75, 1.0, -1.0]


def test_a_box_turns_by_its_angular_velocity_times_the_step(world):
    for _ in range(10):
        fly(world, 0.1)
    assert world.state.box_orientation[0] == pytest.approx([cos(0.25), 0.0, 0.0, sin(0.25)], abs=1e-15)


def test_a_turn_about_a_fixed_axis_is_exact_whatever_the_step():
    fine, coarse = softbody.World(), softbody.World()
    for world, steps in ((fine, 1000), (coarse, 1)):
        world.add_box((1.0, 2.0, 3.0), 4.0, angular_velocity=(0.3, -0.2, 0.7))
        for _ in range(steps):
            fly(world, 1.0 / steps)
    assert coarse.state.box_orientation == pytest.approx(fine.state.box_orientation, abs=1e-13)


def test_a_static_box_stays_where_it_is(world):
    fly(world, 0.5)
    assert world.state.box_position[1].tolist() == [9.0, 9.0, 9.0]
    assert not world.state.box_velocity[1].any()


def test_an_orientation_stays_of_unit_length():
    world = softbody.World()
    world.add_box((1.0, 2.0, 3.0), 4.0, angular_velocity=(3.0, -20.0, 7.0))
    for _ in range(1000):
        fly(world, 0.01)
    assert np.linalg.norm(world.state.box_orientation[0]) == pytest.approx(1.0, abs=1e-15)


def test_forces_and_torques_act_until_they_are_cleared():
    world = softbody.World(gravity=(0.0, 0.0, 0.0))
    box = world.add_box((1.0, 2.0, 3.0), 12.0)  # inertia 13, 10, 5
    box.apply_force((24.0, 0.0, 0.0), point=(0.0, 0.0, 1.0))
    box.apply_torque((13.0, 0.0, 5.0))
    world.step(1.0)
    assert box.velocity == pytest.approx([2.0, 0.0, 0.0])
    assert box.angular_velocity == pytest.approx([1.0, 2.4, 1.0])
    box.clear_forces()
    world.step(1.0)
    assert box.velocity == pytest.approx([2.0, 0.0, 0.0])
    with pytest.raises(softbody.ParameterError, match="force"):
        box.apply_force((np.nan, 0.0, 0.0))
    with pytest.raises(softbody.ParameterError, match="point"):
        box.apply_force((0.0, 0.0, 0.0), point=(1.0, 2.0))


def tumbling(gyroscopic, h, seconds=2.0):
    world = softbody.World(gravity=(0.0, 0.0, 0.0), gyroscopic=gyroscopic)
    world.add_box((1.0, 2.0, 0.3), 4.0, angular_velocity=(0.1, 3.0, 0.2))
    before = world.angular_momentum(), world.energy()
    world.step(h, round(seconds / h))
    return np.linalg.norm(world.angular_momentum() - before[0]), world.energy() / before[1] - 1.0


def test_with_the_gyroscopic_torque_angular_momentum_stays_and_energy_nearly_does():
    momentum, coarse = tumbling(True, 1e-2)
    assert momentum < 1e-12
    _, fine = tumbling(True, 1e-3)
    assert abs(coarse) < 1e-3
    assert abs(fine) < 2e-2 * abs(coarse)


def test_without_it_angular_momentum_drifts():
    assert tumbling(False, 1e-3)[0] > 0.05


def test_long_fast_tumbling_with_coarse_steps_does_not_blow_up():
    world = softbody.World(gravity=(0.0, 0.0, 0.0), gyroscopic=True)
    box = world.add_box((1.0, 2.0, 0.1), 4.0, angular_velocity=(1.0, 30.0, 2.0))
    world.step(1.0 / 60.0, 10_000)
    assert np.linalg.norm(box.angular_velocity) < 100.0


def test_the_nearest_right_angles_are_those_of_least_turn():
    half, root = 0.5, 0.5**0.5
    group = [np.array(q, float) for q in np.eye(4)]
    group += [np.array([half, s * half, t * half, u * half]) for s in (1, -1) for t in (1, -1) for u in (1, -1)]
    for i in range(4):
        for j in range(i):
            for sign in (1, -1):
                q = np.zeros(4)
                q[i], q[j] = root, sign * root
                group.append(q)
    assert len(group) == 24
    random = np.random.default_rng(1)
    for q in random.normal(size=(300, 4)):
        q /= np.linalg.norm(q)
        best = max(group, key=lambda g: abs(g @ q))
        assert abs(np.array(nearest_right_angles(tuple(q.tolist()))) @ best) == pytest.approx(1.0, abs=1e-15)


def test_speeds_are_cut_to_their_ceilings():
    world = softbody.World(gravity=(0.0, 0.0, 0.0), speed_ceiling=5.0, angular_speed_ceiling=2.0)
    box = world.add_box((1.0, 1.0, 1.0), 1.0, velocity=(6.0, 8.0, 0.0), angular_velocity=(0.0, 0.0, -7.0))
    world.step(1e-3)
    assert box.velocity == pytest.approx([3.0, 4.0, 0.0])
    assert box.angular_velocity == pytest.approx([0.0, 0.0, -2.0])


@pytest.mark.parametrize("contact", ["manifold", "single"])
def test_a_slow_box_snaps_to_right_angles_on_the_ground_but_not_in_the_air(contact):
    tilt = (cos(0.05), sin(0.05), 0.0, 0.0)
    for height, expected in ((0.54, (1.0, 0.0, 0.0, 0.0)), (3.0, tilt)):
        world = softbody.World(contact=contact, angular_speed_floor=0.5)
        world.add_ground()
        box = world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, height), tilt)
        world.step(1e-3, 2)
        assert box.orientation == pytest.approx(expected, abs=1e-3)
    assert product(tilt, (1.0, 0.0, 0.0, 0.0)) == tilt
