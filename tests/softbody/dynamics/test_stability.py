"""Is the estimate of the highest frequency a bound, and close enough to be of use?"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import softbody
from softbody import SimulationError
from softbody.dynamics.integrators import STABILITY_LIMIT
from softbody.dynamics.reference_forces import plain_accelerations
from softbody.dynamics.stability import highest_frequency, longest_stable_step
from softbody.model.settings import INTEGRATORS

MESHES = [softbody.tetrahedron(), softbody.octahedron(), softbody.icosahedron(), softbody.box((1.0, 2.0, 3.0))]


def bound_of(world, position, body=0):
    return highest_frequency(world.model, world.controls, position, body)


def true_highest_frequency(world, position):
    """√ of the largest eigenvalue of −∂a/∂x, by central differences; all particles have one mass."""
    d, n = 1e-6, position.size
    jacobian = np.empty((n, n))
    ahead, behind = np.empty_like(position), np.empty_like(position)
    for k in range(n):
        moved = position.copy()
        moved.flat[k] += d
        plain_accelerations(world.model, world.controls, moved, ahead)
        moved.flat[k] -= 2 * d
        plain_accelerations(world.model, world.controls, moved, behind)
        jacobian[:, k] = ((ahead - behind) / (2 * d)).ravel()
    return np.sqrt(max(np.linalg.eigvalsh(-0.5 * (jacobian + jacobian.T)).max(), 0.0))


@settings(max_examples=60)
@given(
    st.sampled_from(MESHES),
    st.floats(0.0, 50.0),
    st.tuples(*[st.floats(0.7, 1.6)] * 3),
    st.floats(0.1, 100.0),
    st.integers(0, 999),
)
def test_the_estimate_bounds_the_true_frequency_and_is_at_most_three_times_too_high(
    mesh, gas, stretch, stiffness, seed
):
    random = np.random.default_rng(seed)
    world = softbody.World()
    world.add_soft_body(mesh, 2.0, stiffness * random.uniform(0.5, 2.0, len(mesh.edges)), gas)
    position = mesh.vertices * stretch + random.normal(0.0, 0.05, mesh.vertices.shape)
    bound = bound_of(world, position)
    true = true_highest_frequency(world, position)
    assert true <= bound * (1.0 + 1e-6)
    assert bound < 3.0 * true


def test_a_skin_without_springs_is_bounded_by_the_bending_of_its_gas():
    """On a fine mesh neighbours slip past each other faster than the whole breathes."""
    world = softbody.World()
    ball = softbody.icosphere(2)
    world.add_soft_body(ball, 2.0, 0.0, 5.0)
    bound = bound_of(world, ball.vertices)
    true = true_highest_frequency(world, ball.vertices)
    assert true <= bound < 3.0 * true


def test_each_body_is_asked_for_by_its_index():
    world = softbody.World()
    world.add_soft_body(softbody.tetrahedron(), 1.0, 10.0, 1.0)
    world.add_soft_body(softbody.octahedron(), 1.0, 90.0, 2.0, position=(5.0, 0.0, 0.0))
    alone = softbody.World()
    alone.add_soft_body(softbody.octahedron(), 1.0, 90.0, 2.0)
    second = bound_of(world, world.state.particle_position, 1)
    assert second == pytest.approx(bound_of(alone, alone.state.particle_position), rel=1e-12)
    assert second > bound_of(world, world.state.particle_position)


def test_four_times_the_stiffness_doubles_the_frequency_of_a_body_without_gas():
    frequencies = []
    for stiffness in (10.0, 40.0):
        world = softbody.World()
        world.add_soft_body(softbody.octahedron(), 1.0, stiffness, 0.0)
        frequencies.append(bound_of(world, world.state.particle_position))
    assert frequencies[1] == pytest.approx(2.0 * frequencies[0], rel=1e-14)


def shaken_ball(integrator):
    """A ball with gas near its equilibrium, every particle nudged."""
    world = softbody.World(gravity=(0.0, 0.0, 0.0), integrator="rk4_velocity")
    world.add_soft_body(softbody.icosphere(1), 1.0, 100.0, 5.0)
    world.step(0.005, 4000)
    world.state.particle_velocity[:] = np.random.default_rng(1).normal(0.0, 0.01, (42, 3))
    world.integrator = integrator
    return world


def radii(world):
    return np.linalg.norm(world.state.particle_position - world.state.particle_position.mean(axis=0), axis=1)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_ball_is_stable_just_below_the_estimate_and_not_at_three_times_it(integrator):
    world = shaken_ball(integrator)
    before = radii(world)
    stable = world.stable_time_step()
    world.step(0.95 * stable, 5000)
    assert radii(world) == pytest.approx(before, abs=0.02)
    with pytest.raises(SimulationError, match="stable time step"):
        world.step(3.0 * stable, 5000, allow_unstable=True)


def test_a_world_without_soft_bodies_has_no_limit():
    assert softbody.World().stable_time_step() == np.inf


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 1.0, 2.0, 5.0])
def test_the_longest_step_is_stable_with_damping_too(integrator, share):
    """A regular solid without gas is a damped oscillator: its step, as a matrix, must not grow."""
    world = softbody.World(gravity=(0.0, 0.0, 0.0), integrator=integrator)
    solid = softbody.octahedron()
    world.add_soft_body(solid, 1.0, 10.0, 0.0)
    squared = (world.model.edge_rest_length**2).sum()
    frequency = np.sqrt(10.0 * squared)  # Σ m x² = 1
    world.model.soft_damping[:] = share * frequency / squared
    limit = STABILITY_LIMIT[INTEGRATORS[integrator]]
    for rate in np.linspace(0.2, 1.0, 5):
        h = rate * longest_stable_step(frequency, share * frequency, limit)
        columns = []
        for stretch, speed in ((1e-3, 0.0), (0.0, 1e-3)):
            world.state.particle_position[:] = (1.0 + stretch) * solid.vertices
            world.state.particle_velocity[:] = speed * frequency * solid.vertices
            world.step(h, allow_unstable=True)
            x, v = world.state.particle_position, world.state.particle_velocity
            of = [(array * solid.vertices).sum() / 6.0 for array in (x, v)]
            columns.append([(of[0] - 1.0) / 1e-3, of[1] / frequency / 1e-3])
        assert np.abs(np.linalg.eigvals(np.array(columns).T)).max() < 1.0 + 1e-9


def test_without_springs_or_damping_any_step_is_stable():
    assert longest_stable_step(0.0, 0.0, 2.0) == np.inf
    assert longest_stable_step(4.0, 0.0, 2.0) == 0.5


def test_damping_shortens_the_stable_step_of_a_world():
    world = softbody.World()
    world.add_soft_body(softbody.octahedron(), 1.0, 10.0, 0.0)
    free = world.stable_time_step()
    world.add_soft_body(softbody.octahedron(), 1.0, 10.0, 0.0, damping=1.0, position=(5.0, 0.0, 0.0))
    assert world.stable_time_step() < free
