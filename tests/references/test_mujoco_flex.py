import numpy as np
import pytest

from references import analytic, mujoco_flex, scipy

KICK, STIFFNESS, MASS = 0.3, 50.0, 6.0  # 1 kg a particle, so that Σ m x² = 6 and k Σ l0² = 50 × 24


@pytest.fixture
def octahedron(cases):
    vertices, triangles = cases.solid("octahedron", 1.0)
    return vertices, cases.edges(triangles), triangles


def scale(octahedron, damping, gas, step, steps, integrator):
    vertices, edges, triangles = octahedron
    positions = mujoco_flex.motion(
        vertices, edges, triangles, KICK * vertices, STIFFNESS, damping, gas, MASS, 0.0, step, steps, integrator
    )
    assert positions == pytest.approx(np.linalg.norm(positions[0]) * vertices, abs=1e-13)
    return np.linalg.norm(positions[0])


def test_springs_swing_as_the_matrix_of_symplectic_euler_says(octahedron):
    frequency = (STIFFNESS * 24.0 / MASS) ** 0.5
    step = 0.5 / frequency
    x, _ = np.linalg.matrix_power(analytic.amplification_matrix("symplectic_euler", 0.5), 7) @ (0.0, KICK / frequency)
    assert scale(octahedron, 0.0, 0.0, step, 7, "symplectic_euler") == pytest.approx(1.0 + x, abs=1e-13)


def test_springs_and_gas_breathe_as_the_scalar_equation_says(octahedron):
    gas = 100.0
    expected, _ = scipy.scale_motion(np.array([0.5]), 1.0, KICK, MASS, STIFFNESS * 24.0, gas)
    assert scale(octahedron, 0.0, gas, 0.5 / 1000, 1000, "rk4") == pytest.approx(expected[0], abs=1e-9)


def test_damping_acts_on_the_speed_at_which_ends_part(octahedron):
    # On the scale λ: M λ'' = −(λ − 1) k Σ l0² − d Σ l0² λ', so the rate is d Σ l0² / M.
    frequency, rate = (STIFFNESS * 24.0 / MASS) ** 0.5, 0.5 * 24.0 / MASS
    fading = (frequency**2 - 0.25 * rate**2) ** 0.5
    expected = 1.0 + KICK / fading * np.exp(-0.5 * rate * 0.5) * np.sin(fading * 0.5)
    assert scale(octahedron, 0.5, 0.0, 0.5 / 1000, 1000, "rk4") == pytest.approx(expected, abs=1e-9)


def test_a_body_falls(octahedron):
    vertices, edges, triangles = octahedron
    moved = mujoco_flex.motion(
        vertices, edges, triangles, 0.0 * vertices, STIFFNESS, 0.1, 0.0, MASS, -9.81, 0.1, 2, "symplectic_euler"
    )
    assert moved - vertices == pytest.approx(np.tile([0.0, 0.0, -0.2943], (6, 1)), abs=1e-14)
