import numpy as np
import pytest

from references import analytic, mujoco, rotation


def test_an_impact_is_the_closed_form(cases, rng):
    case, normal = cases.impacts(rng, 40, "corner")
    point = case[2] + 0.3 * rng.normal(size=(40, 3))
    got = np.concatenate(mujoco.box_impact(*case, point, normal, 0.5), axis=1)
    expected = np.concatenate(analytic.box_impact(*case, point, normal, 0.5), axis=1)
    assert got == pytest.approx(expected, rel=1e-10, abs=1e-10)


def test_mujoco_and_scipy_turn_a_free_box_alike():
    size, q, spin = (1.0, 0.6, 0.3), (0.5, 0.5, -0.5, 0.5), (0.3, 2.0, -0.4)
    got = mujoco.free_rotation(size, 2.0, q, spin, 2.0, 1e-3)
    assert got == pytest.approx(rotation.free_rotation(size, q, spin, 2.0)[0], abs=1e-8)
