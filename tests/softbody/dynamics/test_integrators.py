"""Does each scheme have the order, the damping, the limit and the conservation that it claims?

On a regular solid without gas, the uniformly scaled motion is an exact harmonic oscillator of any amplitude: the
scale λ obeys λ'' = −ω² (λ − 1) with ω² = k Σ l0² / Σ m |x|².
"""

from math import cos, log2, pi, sqrt

import numpy as np
import pytest

import softbody
from softbody.dynamics.integrators import STABILITY_LIMIT
from softbody.model.settings import INTEGRATORS

SOLIDS = {
    "tetrahedron": softbody.tetrahedron(),
    "octahedron": softbody.octahedron(),
    "icosahedron": softbody.icosahedron(),
}
MASS, STIFFNESS = 2.0, 30.0

solids = pytest.mark.parametrize("solid", SOLIDS.values(), ids=SOLIDS.keys())
integrators = pytest.mark.parametrize("integrator", INTEGRATORS)


def oscillator(solid, integrator):
    """A solid at rest without gas, damping or gravity, and its ω."""
    world = softbody.World(gravity=(0.0, 0.0, 0.0), integrator=integrator)
    world.add_soft_body(solid, MASS, STIFFNESS, 0.0, damping=0.0)
    inertia = MASS / len(solid.vertices) * np.sum(solid.vertices**2)
    return world, sqrt(STIFFNESS * np.sum(world.model.edge_rest_length**2) / inertia)


def scale_of(world, solid):
    return float(np.sum(world.state.particle_position * solid.vertices) / np.sum(solid.vertices**2))


def error_after(solid, integrator, steps, phase=1.0):
    """Error of λ − 1 when a solid, let go at λ = 1.2, has gone through `phase` [rad] in `steps` steps."""
    world, omega = oscillator(solid, integrator)
    world.state.particle_position[:] *= 1.2
    world.step(phase / omega / steps, steps)
    return abs(scale_of(world, solid) - 1.0 - 0.2 * cos(phase))


@solids
@pytest.mark.parametrize(("integrator", "order"), [("rk4_velocity", 1), ("rk4", 4), ("symplectic_euler", 1)])
def test_half_the_step_divides_the_error_by_two_to_the_order(solid, integrator, order):
    errors = [error_after(solid, integrator, steps) for steps in (20, 40, 80)]
    assert log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)
    assert log2(errors[1] / errors[2]) == pytest.approx(order, abs=0.05)


@solids
def test_rk4_comes_back_after_one_period(solid):
    assert error_after(solid, "rk4", 1000, 2.0 * pi) < 1e-11


def step_matrix(solid, integrator, z):
    """The 2 × 2 matrix by which one step with ω h = z maps (λ − 1, λ'/ω)."""
    columns = []
    for stretch, speed in ((1e-3, 0.0), (0.0, 1e-3)):
        world, omega = oscillator(solid, integrator)
        world.state.particle_position[:] *= 1.0 + stretch
        world.state.particle_velocity[:] = speed * omega * solid.vertices
        world.step(z / omega, allow_unstable=True)
        rate = np.sum(world.state.particle_velocity * solid.vertices) / np.sum(solid.vertices**2)
        columns.append([(scale_of(world, solid) - 1.0) / 1e-3, rate / omega / 1e-3])
    return np.array(columns).T


@solids
@pytest.mark.parametrize("z", [0.05, 0.1])
def test_rk4_velocity_loses_a_quarter_of_omega_h_squared_a_step(solid, z):
    amplitude = sqrt(np.linalg.det(step_matrix(solid, "rk4_velocity", z)))
    assert 1.0 - amplitude == pytest.approx(z**2 / 4.0, rel=0.01)


@pytest.mark.parametrize("z", [0.1, 0.5, 1.9])
def test_symplectic_euler_keeps_the_area_of_phase_space(z):
    assert np.linalg.det(step_matrix(SOLIDS["octahedron"], "symplectic_euler", z)) == pytest.approx(1.0, abs=1e-11)


@integrators
def test_each_scheme_grows_beyond_its_stability_limit_and_not_before(integrator):
    def growth(z):
        return np.abs(np.linalg.eigvals(step_matrix(SOLIDS["octahedron"], integrator, z))).max()

    limit = STABILITY_LIMIT[INTEGRATORS[integrator]]
    assert growth(0.995 * limit) <= 1.0 + 1e-10
    assert growth(1.005 * limit) > 1.001


def spinning(integrator, gas=0.0):
    """A lopsided body that spins and flies."""
    world = softbody.World(gravity=(0.0, 0.0, 0.0), integrator=integrator)
    world.add_soft_body(softbody.icosahedron(), MASS, STIFFNESS, gas, damping=0.0)
    random = np.random.default_rng(9)
    world.state.particle_position[:] += random.normal(0.0, 0.1, (12, 3))
    world.state.particle_velocity[:] = np.cross([0.5, 1.0, 2.0], world.state.particle_position) + [1.0, 2.0, 3.0]
    return world


@integrators
def test_linear_momentum_is_kept_to_rounding(integrator):
    world = spinning(integrator, gas=2.0)
    before = world.linear_momentum()
    world.step(0.01, 1000)
    assert world.linear_momentum() == pytest.approx(before, rel=1e-13)


def test_symplectic_euler_keeps_angular_momentum_to_rounding():
    world = spinning("symplectic_euler", gas=2.0)
    before = world.angular_momentum()
    world.step(0.01, 1000)
    assert world.angular_momentum() == pytest.approx(before, rel=1e-12)


@pytest.mark.parametrize("integrator", ["rk4_velocity", "rk4"])
def test_the_others_keep_angular_momentum_only_as_the_step_goes_to_zero(integrator):
    def drift(h, steps):
        world = spinning(integrator, gas=2.0)
        before = world.angular_momentum()
        world.step(h, steps)
        return np.linalg.norm(world.angular_momentum() - before)

    coarse, fine = drift(0.02, 50), drift(0.01, 100)
    assert coarse > 1e-9
    assert fine < 0.6 * coarse


@pytest.mark.parametrize(("integrator", "order"), [("rk4_velocity", 1), ("rk4", 4)])
def test_the_energy_of_a_body_with_gas_is_kept_to_the_order_of_the_scheme(integrator, order):
    def drift(h, steps):
        world = spinning(integrator, gas=2.0)
        before = world.energy()
        world.step(h, steps)
        return abs(world.energy() - before)

    assert log2(drift(0.0025, 200) / drift(0.00125, 400)) > order - 0.2


def test_symplectic_euler_neither_gains_nor_loses_energy_in_the_long_run():
    world = spinning("symplectic_euler", gas=2.0)
    energies = []
    for _ in range(200):
        world.step(0.005, 50)
        energies.append(world.energy())
    assert np.mean(energies[100:]) == pytest.approx(np.mean(energies[:100]), rel=0.01)
