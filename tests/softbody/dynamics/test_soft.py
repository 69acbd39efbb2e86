"""Is the acceleration of every particle the sum of its springs, its gas and gravity, over its mass?"""

import numpy as np
import pytest

import softbody
from softbody.dynamics.energy import potential_energy
from softbody.dynamics.soft import body_volume, soft_accelerations


@pytest.fixture
def world():
    """A large and a small body out of shape, of different mass, stiffness and gas."""
    world = softbody.World(gravity=(1.0, 2.0, -3.0))
    world.add_soft_body(softbody.icosahedron(), 6.0, 40.0, 5.0)
    world.add_soft_body(softbody.tetrahedron(0.5), 0.8, 90.0, 0.7, position=(3.0, 0.0, 0.0))
    world.state.position[:] += np.random.default_rng(5).normal(0.0, 0.05, (16, 3))
    return world


def accelerations(world, position):
    out = np.full_like(position, np.nan)
    soft_accelerations(world.model, position, out)
    return out


def test_mass_times_acceleration_is_the_downhill_slope_of_the_potential_energy(world):
    model, state = world.model, world.state
    force = accelerations(world, state.position) / model.inverse_mass[:, None]
    d = 1e-6
    for i, c in ((0, 0), (5, 1), (11, 2), (12, 0), (14, 1), (15, 2)):
        ahead, behind = state.copy(), state.copy()
        ahead.position[i, c] += d
        behind.position[i, c] -= d
        slope = (potential_energy(model, ahead) - potential_energy(model, behind)) / (2 * d)
        assert force[i, c] == pytest.approx(-slope, rel=1e-7, abs=1e-6)


def test_each_body_as_a_whole_falls_with_gravity(world):
    a = accelerations(world, world.state.position)
    assert np.abs(a - [1.0, 2.0, -3.0]).max() > 1.0
    assert a[:12].mean(axis=0) == pytest.approx([1.0, 2.0, -3.0], abs=1e-13)
    assert a[12:].mean(axis=0) == pytest.approx([1.0, 2.0, -3.0], abs=1e-13)


def test_a_body_does_not_feel_another(world):
    position = world.state.position.copy()
    before = accelerations(world, position)
    position[12:] *= 1.1
    assert accelerations(world, position)[:12].tolist() == before[:12].tolist()


def test_particles_of_equal_mass_share_the_mass_of_the_body(world):
    assert 1.0 / world.model.inverse_mass == pytest.approx([0.5] * 12 + [0.2] * 4, rel=1e-15)


def test_each_volume_is_that_of_its_own_body():
    world = softbody.World()
    world.add_soft_body(softbody.octahedron(), 1.0, 1.0, 0.0)
    world.add_soft_body(softbody.box((1.0, 2.0, 3.0)), 1.0, 1.0, 0.0, position=(1e3, 0.0, 0.0))
    assert body_volume(world.model, world.state.position, 0) == pytest.approx(4 / 3, rel=1e-14)
    assert body_volume(world.model, world.state.position, 1) == pytest.approx(6.0, rel=1e-11)
