"""Does the judge of joints know what closed forms know?"""

import numpy as np
import pytest

from references.joined import Cube, Joined, Net, motion

REST = np.zeros(3)


def cube(position=REST, mass=2.0, edge=0.3, velocity=REST, spin=REST):
    return Cube(
        edge, mass, np.asarray(position, float), np.eye(3), np.asarray(velocity, float), np.asarray(spin, float)
    )


@pytest.mark.parametrize("damping", [0.0, 3.0])
def test_a_cube_on_a_spring_swings_as_a_damped_oscillator(damping):
    hold = Joined(("cube", 0, REST), ("place", REST), 50.0, damping, 0.0)
    where, velocity = motion([cube((0.4, 0.0, 0.0))], [], [hold], REST, 1.7)
    rate = damping / 4.0
    omega = np.sqrt(25.0 - rate**2)
    fade = 0.4 * np.exp(-1.7 * rate)
    swing = fade * (np.cos(1.7 * omega) + rate / omega * np.sin(1.7 * omega))
    assert where[0] == pytest.approx([swing, 0.0, 0.0], abs=1e-9)
    assert velocity[0, 0] == pytest.approx(-fade * 25.0 / omega * np.sin(1.7 * omega), abs=1e-8)


def test_two_cubes_swing_by_their_reduced_mass_about_a_length_at_rest():
    cubes = [cube(mass=1.0), cube((1.2, 0.0, 0.0), mass=3.0)]
    joint = Joined(("cube", 0, REST), ("cube", 1, REST), 30.0, 0.0, 1.0)
    where, _ = motion(cubes, [], [joint], REST, 0.9)
    assert where[1, 0] - where[0, 0] == pytest.approx(1.0 + 0.2 * np.cos(0.9 * np.sqrt(30.0 / 0.75)), abs=1e-9)
    assert np.array([1.0, 3.0]) @ where[:, 0] == pytest.approx(3.6, abs=1e-9)


def test_a_cube_that_hangs_by_a_face_swings_as_a_physical_pendulum():
    arm, angle = np.array([0.0, 0.0, 1.0]), 1e-4
    turn = np.array([[np.cos(angle), 0.0, np.sin(angle)], [0.0, 1.0, 0.0], [-np.sin(angle), 0.0, np.cos(angle)]])
    mass, edge, stiffness = 2.0, 0.3, 1e6
    hang = Cube(edge, mass, -turn @ arm - (0.0, 0.0, mass * 9.81 / stiffness), turn, REST, REST)
    pull = Joined(("cube", 0, arm), ("place", REST), stiffness, 0.0, 0.0)
    omega = np.sqrt(mass * 9.81 / (mass + mass * edge**2 / 6.0))
    where, _ = motion([hang], [], [pull], np.array([0.0, 0.0, -9.81]), np.pi / omega)
    assert where[0, 0] == pytest.approx(-hang.position[0], rel=1e-3)


def test_a_net_keeps_momenta_with_what_it_is_joined_to():
    net = Net(0.5, np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)]), np.array([(0.0, 1.0, 0.0), REST]),
              np.array([[0, 1]]), np.array([0.8]), 40.0)  # fmt: skip
    joint = Joined(("net", 0, np.array([0.25, 0.75])), ("cube", 0, np.array([0.1, 0.0, 0.0])), 20.0, 1.0, 0.5)
    where, velocity = motion([cube((2.0, 0.3, 0.0))], [net], [joint], REST, 1.0)
    masses = np.array([2.0, 0.5, 0.5])
    assert masses @ velocity == pytest.approx([0.0, 0.5, 0.0], abs=1e-9)
    centre = masses @ np.array([(2.0, 0.3, 0.0), *net.position])
    assert masses @ where == pytest.approx(centre + (0.0, 0.5, 0.0), abs=1e-9)
