"""Do springs pull as Hooke says?"""

import numpy as np
import pytest

import softbody
from softbody.dynamics.springs import add_spring_forces, spring_energy, spring_virial

PAIR = np.array([[0, 1]])


def test_a_stretched_spring_pulls_both_ends_together():
    """5 m long, 3 m at rest, 10 N/m: 20 N along (3, 4, 0)/5 on the first end, 20 J, virial 100 J."""
    position = np.array([[1.0, 1.0, 1.0], [4.0, 5.0, 1.0]])
    force = np.zeros((2, 3))
    add_spring_forces(position, PAIR, np.array([3.0]), np.array([10.0]), force)
    assert force == pytest.approx(np.array([[12.0, 16.0, 0.0], [-12.0, -16.0, 0.0]]), rel=1e-15)
    assert spring_energy(position, PAIR, np.array([3.0]), np.array([10.0])) == 20.0
    assert spring_virial(position, PAIR, np.array([3.0]), np.array([10.0])) == 100.0


def test_a_compressed_spring_pushes_and_a_relaxed_one_does_nothing():
    position = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 2.0]])
    force = np.zeros((2, 3))
    add_spring_forces(position, PAIR, np.array([3.0]), np.array([10.0]), force)
    assert force.tolist() == [[0.0, 0.0, -10.0], [0.0, 0.0, 10.0]]
    force[:] = 0.0
    add_spring_forces(position, PAIR, np.array([2.0]), np.array([10.0]), force)
    assert not force.any()


def test_forces_are_added_to_what_is_there():
    force = np.ones((2, 3))
    add_spring_forces(np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]), PAIR, np.array([1.0]), np.array([1.0]), force)
    assert force.tolist() == [[2.0, 1.0, 1.0], [0.0, 1.0, 1.0]]


@pytest.fixture
def net():
    """A ball out of shape, its springs of unequal stiffness."""
    random = np.random.default_rng(7)
    mesh = softbody.icosphere(1)
    edges = mesh.edges
    position = mesh.vertices + random.normal(0.0, 0.1, mesh.vertices.shape)
    rest_length = np.linalg.norm(np.diff(mesh.vertices[edges], axis=1)[:, 0], axis=1)
    return position, edges, rest_length, random.uniform(1.0, 100.0, len(edges))


def test_the_force_is_the_downhill_slope_of_the_energy(net):
    position, *springs = net
    force = np.zeros_like(position)
    add_spring_forces(position, *springs, force)
    d = 1e-6
    for i, c in ((0, 0), (5, 1), (17, 2), (41, 0)):
        ahead, behind = position.copy(), position.copy()
        ahead[i, c] += d
        behind[i, c] -= d
        slope = (spring_energy(ahead, *springs) - spring_energy(behind, *springs)) / (2 * d)
        assert force[i, c] == pytest.approx(-slope, rel=1e-7, abs=1e-6)


def test_the_springs_of_a_body_exert_no_net_force_and_no_net_torque_on_it(net):
    position, *springs = net
    force = np.zeros_like(position)
    add_spring_forces(position, *springs, force)
    assert np.abs(force).max() > 1.0
    assert force.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-12)
    assert np.cross(position, force).sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-12)


def test_the_virial_is_minus_the_force_times_the_position(net):
    position, *springs = net
    force = np.zeros_like(position)
    add_spring_forces(position, *springs, force)
    assert spring_virial(position, *springs) == pytest.approx(-np.sum(force * position), rel=1e-12)
