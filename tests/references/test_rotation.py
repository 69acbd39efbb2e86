import numpy as np
import pytest

from references import analytic, rotation


def test_a_spin_about_a_principal_axis_stays():
    turn, spin = rotation.free_rotation((1.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.5), 2.0)
    assert spin == pytest.approx([0.0, 0.0, 0.5], abs=1e-12)
    assert turn == pytest.approx(
        np.array([[np.cos(1), -np.sin(1), 0], [np.sin(1), np.cos(1), 0], [0, 0, 1]]), abs=1e-10
    )


def test_angular_momentum_and_energy_stay():
    size, q, start = (1.0, 0.6, 0.3), np.array([0.5, 0.5, -0.5, 0.5]), np.array([0.3, 2.0, -0.4])
    inertia = np.diag(analytic.box_inertia(size, 1.0))
    before, (after, spin) = analytic.rotation_matrix(q), rotation.free_rotation(size, q, start, 3.0)
    was, now = before @ inertia @ before.T @ start, after @ inertia @ after.T @ spin
    assert now == pytest.approx(was, abs=1e-10)
    assert now @ spin == pytest.approx(was @ start, rel=1e-10)


def test_half_way_is_the_shortest_arc_whatever_the_signs():
    one, other = [1.0, 0.0, 0.0, 0.0], [np.cos(0.4), 0.0, 0.0, np.sin(0.4)]
    for sign in (1.0, -1.0):
        middle = rotation.half_way(one, sign * np.array(other))
        assert abs(middle @ [np.cos(0.2), 0.0, 0.0, np.sin(0.2)]) == pytest.approx(1.0)
