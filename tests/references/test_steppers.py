"""Are the judge's schemes the schemes? Two particles on one spring, and a fall, step by step by hand."""

import numpy as np
import pytest

from references import analytic, steppers

# Two particles of 1 kg on a spring of 1 N/m: the stretch swings with ω² = 2.
PAIR = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
TRIANGLES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def pair(**changed):
    still = {
        "edges": np.array([[0, 1]]),
        "rest_length": np.ones(1),
        "stiffness": np.ones(1),
        "triangles": TRIANGLES,
        "gas": 0.0,
        "particle_mass": 1.0,
        "gravity": np.zeros(3),
        "force": np.zeros((4, 3)),
        "damping": 0.0,
        "drag": 0.0,
        "free": np.ones(4, bool),
    }
    return steppers.SoftBody(**(still | changed))


@pytest.mark.parametrize("scheme", steppers.SCHEMES)
def test_a_spring_swings_by_the_scheme_s_amplification_matrix(scheme):
    stretched = PAIR + np.outer([-1.0, 1.0, 0.0, 0.0], [0.05, 0.0, 0.0])
    step = 0.3
    x, v = steppers.motion(pair(), stretched, np.zeros((4, 3)), step, 7, scheme)
    matrix = np.linalg.matrix_power(analytic.amplification_matrix(scheme, np.sqrt(2.0) * step), 7)
    swing, pace = matrix @ [0.1, 0.0]
    assert np.isclose(x[1, 0] - x[0, 0] - 1.0, swing, rtol=1e-12)
    assert np.isclose(v[1, 0] - v[0, 0], pace * np.sqrt(2.0), rtol=1e-12)


@pytest.mark.parametrize("scheme", steppers.SCHEMES)
def test_what_is_pinned_stays_and_what_is_free_falls(scheme):
    free = np.array([True, True, False, True])
    body = pair(stiffness=np.zeros(1), gravity=np.array([0.0, 0.0, -10.0]), free=free)
    x, v = steppers.motion(body, PAIR, np.ones((4, 3)), 0.1, 1, scheme)
    assert np.array_equal(x[2], PAIR[2])
    assert np.allclose(v[~free], 0.0)
    assert np.allclose(v[free], [1.0, 1.0, 0.0])


def test_damping_is_along_the_spring_and_keeps_momentum():
    body, velocity = pair(stiffness=np.zeros(1), damping=2.0), np.zeros((4, 3))
    velocity[1] = 1.0, 3.0, 0.0
    acceleration = body.acceleration(PAIR, velocity)
    assert np.allclose(acceleration[0], [2.0, 0.0, 0.0])
    assert np.allclose(acceleration.sum(axis=0), 0.0)


def test_drag_is_of_the_velocity():
    velocity = np.arange(12.0).reshape(4, 3)
    assert np.allclose(pair(drag=0.5).acceleration(PAIR, velocity), -0.5 * velocity)
