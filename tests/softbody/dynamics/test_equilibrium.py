"""Does relaxation end where forces vanish, and say so where they cannot?"""

import numpy as np
import pytest

import softbody
from softbody import SimulationError, World
from softbody.dynamics.reference_forces import plain_accelerations


def residual(world):
    out = np.empty_like(world.state.particle_position)
    plain_accelerations(world.model, world.controls, world.state.particle_position, out)
    return np.abs(out).max()


def test_bodies_without_weight_come_to_rest_where_they_are():
    world = World(gravity=(0.0, 0.0, 0.0))
    world.add_ground()
    a = world.add_soft_body(softbody.icosphere(2), 1.0, 50.0, 20.0, position=(1.0, 2.0, 3.0), velocity=(1.0, 0.0, 0.0))
    world.add_soft_body(softbody.torus(1.0, 0.4, 16, 8), 2.0, 80.0, 5.0, position=(9.0, 2.0, 3.0))
    world.equilibrium()
    assert residual(world) < 1e-12 * 80.0 * 3.0 * 162
    assert a.centre == pytest.approx([1.0, 2.0, 3.0], abs=1e-12)
    assert not world.state.particle_velocity.any()
    assert world.steps == 0


def test_a_body_held_by_a_fixed_particle_hangs_in_equilibrium():
    world = World()
    body = world.add_soft_body(softbody.icosphere(1), 1.0, 50.0, 2.0, fixed=[4])
    held = body.positions[4].copy()
    world.equilibrium()
    assert residual(world) < 1e-9
    assert body.positions[4].tolist() == held.tolist()
    assert body.centre[2] < held[2]


def test_a_body_that_is_pushed_away_finds_no_rest():
    world = World()
    body = world.add_soft_body(softbody.octahedron(), 1.0, 50.0, 2.0)
    body.external_force = (1.0, 0.0, 0.0)
    before = body.positions.copy()
    with pytest.raises(SimulationError, match=r"soft body 0 is not at rest after 1000 steps.*fixed particles hold"):
        world.equilibrium(steps=1000)
    assert body.positions.tolist() == before.tolist()


def test_a_body_without_springs_and_gas_stays_as_it_is_unless_something_pulls():
    world = World()
    ball = world.add_soft_body(softbody.icosphere(1), mass=1.0, stiffness=0.0, gas=0.0)
    before = ball.positions.copy()
    world.equilibrium()
    np.testing.assert_array_equal(ball.positions, before)
    ball.fixed = [0]
    with pytest.raises(SimulationError, match="is not at rest"):
        world.equilibrium()
    world.gravity = (0.0, 0.0, 0.0)
    world.equilibrium()
    np.testing.assert_array_equal(ball.positions, before)
