"""Do bodies move the same alone and together, in one go and in many, and is the one that fails named?"""

import numpy as np
import pytest

import softbody
from softbody import SimulationError, World
from softbody.dynamics.integrators import INTEGRATORS
from softbody.dynamics.motion import COLLAPSED, DIVERGED, LOOK, find_fault

SOLID = softbody.octahedron()

integrators = pytest.mark.parametrize("integrator", INTEGRATORS)


@pytest.fixture
def rows():
    """An octahedron at rest: positions, then velocities, (6, 6)."""
    return np.concatenate([SOLID.vertices.T, np.zeros((3, 6))])


def test_a_body_at_rest_is_without_fault(rows):
    assert find_fault(rows, 6, 0.01, 1.0, 0.0) == 0


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("row", range(3, 6))
def test_a_velocity_that_is_not_finite_is_a_fault(rows, row, value):
    rows[row, 2] = value
    assert find_fault(rows, 6, 0.01, 1.0, 0.0) == DIVERGED


@pytest.mark.parametrize("volume", [np.nan, np.inf, -np.inf])
def test_a_volume_that_is_not_finite_is_a_fault(rows, volume):
    assert find_fault(rows, 6, 0.01, volume, 0.0) == DIVERGED


def test_a_particle_that_would_cross_its_body_in_one_step_is_a_fault(rows):
    """Extent 2 m, step 0.01 s: 200 m/s from the mean velocity, of which the particle itself takes a sixth."""
    limit = 200.0 * 6 / 5
    rows[5, 1] = 0.99 * limit
    assert find_fault(rows, 6, 0.01, 1.0, 0.0) == 0
    rows[5, 1] = 1.01 * limit
    assert find_fault(rows, 6, 0.01, 1.0, 0.0) == DIVERGED


@pytest.mark.parametrize(("volume", "least"), [(0.0, 0.0), (-1.0, 0.0), (0.1, 0.2)])
def test_a_body_without_enough_volume_has_collapsed(rows, volume, least):
    assert find_fault(rows, 6, 0.01, volume, least) == COLLAPSED


def shaken(seeds, integrator="rk4_velocity"):
    """A world of balls, each shaken by its own seed."""
    world = World(gravity=(0.0, 0.0, 0.0), integrator=integrator)
    for seed in seeds:
        body = world.add_soft_body(softbody.icosphere(1), 1.0, 100.0, 5.0, position=(3.0 * seed, 0.0, 0.0))
        body.velocities[:] = np.random.default_rng(seed).normal(0.0, 0.5, (42, 3))
    return world


@pytest.mark.filterwarnings("ignore:soft bodies collide")
@integrators
def test_bodies_move_alone_as_they_do_together_to_the_same_bits(integrator):
    together = shaken([0, 1, 2], integrator)
    together.step(1e-3, 77)
    for seed in range(3):
        alone = shaken([seed], integrator)
        alone.step(1e-3, 77)
        rows = slice(42 * seed, 42 * (seed + 1))
        assert alone.state.position.tolist() == together.state.position[rows].tolist()


@integrators
def test_a_run_in_parts_gives_the_same_bits(integrator):
    whole, parts = shaken([4], integrator), shaken([4], integrator)
    whole.step(1e-3, 2 * LOOK + 3)
    for steps in (1, 2, LOOK, LOOK):
        parts.step(1e-3, steps)
    assert whole.state.position.tolist() == parts.state.position.tolist()
    assert whole.state.velocity.tolist() == parts.state.velocity.tolist()


@integrators
def test_a_step_in_parts_is_as_many_steps(integrator):
    steps, parts = shaken([4], integrator), shaken([4], integrator)
    steps.step(1e-3, 30)
    parts.step(3e-3, 10, substeps=3)
    assert steps.state.position.tolist() == parts.state.position.tolist()
    assert parts.time == pytest.approx(steps.time)
    assert parts.steps == 10


@pytest.mark.filterwarnings("ignore:soft bodies collide")
@pytest.mark.parametrize("ground", [False, True])
@pytest.mark.parametrize("substeps", [1, 3])
def test_the_state_after_a_failure_is_that_of_the_last_good_step(ground, substeps):
    """The second body fails, with a step far too long; the first would not, but stops with it."""

    def world():
        world = World(gravity=(0.0, 0.0, 0.0))
        if ground:
            world.add_ground(-100.0)
        world.add_soft_body(SOLID, 1.0, 1.0, 0.1)
        stiff = world.add_soft_body(SOLID, 1.0, 100.0, 0.1, position=(5.0, 0.0, 0.0))
        stiff.velocities[0] = (0.0, 1e-9, 0.0)
        return world

    failing, good = world(), world()
    h = 1.5 * substeps * failing.stable_time_step()
    with pytest.raises(SimulationError, match=r"soft body 1 (diverged|collapsed).* in step") as error:
        failing.step(h, 10_000, substeps=substeps, allow_unstable=True)
    assert 1 < error.value.step < 10_000
    good.step(h, error.value.step, substeps=substeps, allow_unstable=True)
    assert good.state.position.tolist() == failing.state.position.tolist()
    with pytest.raises(SimulationError):
        good.step(h, 20, substeps=substeps, allow_unstable=True)


def test_a_leaking_body_is_reported_when_it_has_deflated():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(softbody.icosphere(1), 1.0, 50.0, 20.0, rest_length=0.3, deflated_below=0.5)

    def leak():
        for _ in range(200):
            body.gas *= 0.9
            world.step(1e-3, 50)

    with pytest.raises(SimulationError, match=r"soft body 0 collapsed \(deflated to 1\.") as error:
        leak()
    assert body.volume > 0.5 * softbody.icosphere(1).volume
    assert error.value.body == "soft body 0"
