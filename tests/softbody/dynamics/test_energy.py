"""Are energy and momentum those of the textbook, summed over all that can move?"""

from math import cos, log, pi, sin

import numpy as np
import pytest

import softbody
from softbody.dynamics.energy import (
    angular_momentum,
    kinetic_energy,
    linear_momentum,
    potential_energy,
    total_energy,
)


@pytest.fixture
def world():
    """An octahedron of 6 kg that flies past a spinning box of 12 kg and a static one."""
    world = softbody.World(gravity=(0.0, 0.0, -10.0))
    world.add_soft_body(softbody.octahedron(), 6.0, 100.0, 3.0, position=(0.0, 0.0, 2.0), velocity=(1.0, 0.0, 0.0))
    world.add_box((1.0, 2.0, 3.0), 12.0, (5.0, 0.0, 1.0), velocity=(0.0, 2.0, 0.0), angular_velocity=(1.0, 2.0, 3.0))
    world.add_box((1.0, 1.0, 1.0), None, position=(0.0, 0.0, 100.0))
    return world


def test_the_kinetic_energy_is_that_of_flight_and_spin(world):
    """½ 6·1 + ½ 12·4 + ½ (13·1 + 10·4 + 5·9) = 3 + 24 + 49."""
    assert kinetic_energy(world.model, world.state) == pytest.approx(76.0, rel=1e-14)


def test_the_potential_energy_is_that_of_springs_gas_and_height(world):
    height = 6.0 * 10.0 * 2.0 + 12.0 * 10.0 * 1.0
    gas = -3.0 * log(4 / 3)
    assert potential_energy(world.model, world.controls, world.state) == pytest.approx(height + gas, rel=1e-14)
    world.state.particle_position[0] += [1.0, 0.0, 0.0]  # the corner at +x, to twice its distance
    stretched = 4 * 0.5 * 100.0 * (5**0.5 - 2**0.5) ** 2
    assert potential_energy(world.model, world.controls, world.state) == pytest.approx(
        height + stretched - 3.0 * log(2.0), rel=1e-14
    )
    assert total_energy(world.model, world.controls, world.state) == pytest.approx(
        76.0 + height + stretched - 3.0 * log(2.0), rel=1e-14
    )


def test_the_linear_momentum_is_the_sum_of_m_v(world):
    assert linear_momentum(world.model, world.state) == pytest.approx((6.0, 24.0, 0.0), abs=1e-14)


def test_the_angular_momentum_is_orbit_plus_spin(world):
    """(0,0,2)×(6,0,0) + (5,0,1)×(0,24,0) + (13, 20, 15)."""
    expected = np.array([0.0, 12.0, 0.0]) + [-24.0, 0.0, 120.0] + [13.0, 20.0, 15.0]
    assert angular_momentum(world.model, world.state) == pytest.approx(expected, abs=1e-13)


def test_the_spin_of_a_turned_box_uses_its_turned_inertia():
    """A quarter turn about z swaps Ixx = 13 and Iyy = 10."""
    world = softbody.World()
    quarter = (cos(pi / 4), 0.0, 0.0, sin(pi / 4))
    world.add_box((1.0, 2.0, 3.0), 12.0, orientation=quarter, angular_velocity=(1.0, 2.0, 3.0))
    assert angular_momentum(world.model, world.state) == pytest.approx((10.0, 26.0, 15.0), rel=1e-14)
    assert kinetic_energy(world.model, world.state) == pytest.approx(0.5 * (10.0 + 52.0 + 45.0), rel=1e-14)


def test_an_empty_world_has_no_energy_and_no_momentum():
    world = softbody.World()
    assert total_energy(world.model, world.controls, world.state) == 0.0
    assert linear_momentum(world.model, world.state) == (0.0, 0.0, 0.0)
    assert angular_momentum(world.model, world.state) == (0.0, 0.0, 0.0)


def test_a_body_without_gas_has_an_energy_whatever_its_volume():
    world = softbody.World(gravity=(0.0, 0.0, 0.0))
    world.add_soft_body(softbody.octahedron(), 1.0, 1.0, 0.0)
    world.state.particle_position[:] *= -1.0
    assert potential_energy(world.model, world.controls, world.state) == 0.0
