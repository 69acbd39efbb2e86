"""Does the gas push as P ∂V/∂x says?"""

from math import log

import numpy as np
import pytest

import softbody
from softbody.dynamics.pressure import add_pressure_forces, gas_energy, gas_pressure
from softbody.geometry.polyhedron import signed_volume

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


def test_half_the_volume_doubles_the_pressure():
    assert gas_pressure(6.0, 3.0) == 2.0
    assert gas_pressure(6.0, 1.5) == 4.0


def test_the_gas_gives_up_energy_as_it_expands():
    assert gas_energy(3.0, 2.0) == pytest.approx(-3.0 * log(2.0), rel=1e-15)
    assert gas_energy(3.0, 1.0) == 0.0


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
