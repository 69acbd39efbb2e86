"""Do springs pull as Hooke says, does the gas push as P ∂V/∂x says, and is the acceleration their sum over the mass?"""

import numpy as np
import pytest

import softbody
from softbody.dynamics.energy import potential_energy
from softbody.dynamics.reference_forces import (
    add_pressure_forces,
    add_spring_forces,
    plain_accelerations,
    spring_energy,
    spring_virial,
)
from softbody.geometry.polyhedron import signed_volume

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


MESHES = [
    softbody.tetrahedron(),
    softbody.box((1.0, 2.0, 3.0), 2).moved((4.0, 5.0, 6.0)),
    softbody.icosphere(1),
    softbody.torus(1.0, 0.4, 8, 6),
]
meshes = pytest.mark.parametrize("mesh", MESHES, ids=["tetrahedron", "box", "ball", "torus"])


def pressure_force(position, mesh, pressure=7.0):
    force = np.zeros_like(position)
    add_pressure_forces(position, mesh.triangles, pressure, force)
    return force


def test_each_corner_of_a_triangle_gets_a_third_of_pressure_times_area():
    """A triangle of 6 m² facing up under 5 Pa: 30 N, 10 N on each corner, added to what is there."""
    position = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0]])
    force = np.ones((3, 3))
    add_pressure_forces(position, np.array([[0, 1, 2]]), 5.0, force)
    assert force == pytest.approx(np.array([[1.0, 1.0, 11.0]] * 3), rel=1e-15)


@meshes
def test_the_force_is_pressure_times_the_gradient_of_volume(mesh):
    position = mesh.vertices + np.random.default_rng(3).normal(0.0, 0.05, mesh.vertices.shape)
    force = pressure_force(position, mesh)
    d = 1e-4
    for i in range(0, len(position), 5):
        for c in range(3):
            ahead, behind = position.copy(), position.copy()
            ahead[i, c] += d
            behind[i, c] -= d
            # The volume is linear in each coordinate: the difference is exact up to rounding.
            slope = (signed_volume(ahead, mesh.triangles) - signed_volume(behind, mesh.triangles)) / (2 * d)
            assert force[i, c] == pytest.approx(7.0 * slope, abs=1e-9)


@meshes
def test_a_closed_mesh_feels_no_net_force_and_no_net_torque(mesh):
    position = mesh.vertices + np.random.default_rng(4).normal(0.0, 0.05, mesh.vertices.shape)
    force = pressure_force(position, mesh)
    assert np.abs(force).max() > 0.1
    assert force.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-12)
    assert np.cross(position, force).sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-11)


@meshes
def test_the_virial_of_the_pressure_is_3_p_v(mesh):
    force = pressure_force(mesh.vertices, mesh)
    assert np.sum(force * mesh.vertices) == pytest.approx(3.0 * 7.0 * mesh.volume, rel=1e-12)


@pytest.fixture
def world():
    """A large and a small body out of shape, of different mass, stiffness and gas."""
    world = softbody.World(gravity=(1.0, 2.0, -3.0))
    world.add_soft_body(softbody.icosahedron(), 6.0, 40.0, 5.0)
    world.add_soft_body(softbody.tetrahedron(0.5), 0.8, 90.0, 0.7, position=(3.0, 0.0, 0.0))
    world.state.particle_position[:] += np.random.default_rng(5).normal(0.0, 0.05, (16, 3))
    return world


def accelerations(world, position):
    out = np.full_like(position, np.nan)
    plain_accelerations(world.model, world.controls, position, out)
    return out


def test_mass_times_acceleration_is_the_downhill_slope_of_the_potential_energy(world):
    model, controls, state = world.model, world.controls, world.state
    force = accelerations(world, state.particle_position) / model.particle_inverse_mass[:, None]
    d = 1e-6
    for i, c in ((0, 0), (5, 1), (11, 2), (12, 0), (14, 1), (15, 2)):
        ahead, behind = state.copy(), state.copy()
        ahead.particle_position[i, c] += d
        behind.particle_position[i, c] -= d
        slope = (potential_energy(model, controls, ahead) - potential_energy(model, controls, behind)) / (2 * d)
        assert force[i, c] == pytest.approx(-slope, rel=1e-7, abs=1e-6)


def test_each_body_as_a_whole_falls_with_gravity(world):
    a = accelerations(world, world.state.particle_position)
    assert np.abs(a - [1.0, 2.0, -3.0]).max() > 1.0
    assert a[:12].mean(axis=0) == pytest.approx([1.0, 2.0, -3.0], abs=1e-13)
    assert a[12:].mean(axis=0) == pytest.approx([1.0, 2.0, -3.0], abs=1e-13)


def test_a_body_does_not_feel_another(world):
    position = world.state.particle_position.copy()
    before = accelerations(world, position)
    position[12:] *= 1.1
    assert accelerations(world, position)[:12].tolist() == before[:12].tolist()


def test_particles_of_equal_mass_share_the_mass_of_the_body(world):
    assert 1.0 / world.model.particle_inverse_mass == pytest.approx([0.5] * 12 + [0.2] * 4, rel=1e-15)
