"""Has the gas the pressure and the energy of an ideal gas in the volume of its body?"""

from math import log

import pytest

import softbody
from softbody.dynamics.pressure import gas_energy, gas_pressure, soft_volume


def test_half_the_volume_doubles_the_pressure():
    assert gas_pressure(6.0, 3.0) == 2.0
    assert gas_pressure(6.0, 1.5) == 4.0


def test_the_gas_gives_up_energy_as_it_expands():
    assert gas_energy(3.0, 2.0) == pytest.approx(-3.0 * log(2.0), rel=1e-15)
    assert gas_energy(3.0, 1.0) == 0.0


def test_each_volume_is_that_of_its_own_body():
    world = softbody.World()
    world.add_soft_body(softbody.octahedron(), 1.0, 1.0, 0.0)
    world.add_soft_body(softbody.box((1.0, 2.0, 3.0)), 1.0, 1.0, 0.0, position=(1e3, 0.0, 0.0))
    assert soft_volume(world.model, world.state.particle_position, 0) == pytest.approx(4 / 3, rel=1e-14)
    assert soft_volume(world.model, world.state.particle_position, 1) == pytest.approx(6.0, rel=1e-11)
