import numpy as np
import pytest

from references import analytic, multicontact

UPRIGHT = np.array([[1.0, 0.0, 0.0, 0.0]])
ONE = np.ones((1, 3))
REST = np.zeros((1, 3))


def cube_on_floor(velocity, spin=(0.0, 0.0, 0.0)):
    box = (
        ONE,
        np.array([2.0]),
        np.array([[0.0, 0.0, 0.5]]),
        UPRIGHT,
        np.array([velocity], float),
        np.array([spin], float),
    )
    return (*box, ONE, np.array([np.inf]), np.array([[0.0, 0.0, -0.5]]), UPRIGHT, REST, REST)


CORNERS = np.array([[x, y, 0.0] for x in (-0.5, 0.5) for y in (-0.5, 0.5)])
UP = np.tile([0.0, 0.0, 1.0], (4, 1))


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_a_cube_that_lands_flat_bounces_straight_up(e):
    after, _ = multicontact.manifold_impact(cube_on_floor((1.0, 0.0, -3.0)), CORNERS, UP, e)
    assert after == pytest.approx([1.0, 0.0, 3.0 * e, *[0.0] * 9], abs=1e-14)


def test_one_contact_is_the_closed_form(cases, rng):
    case, normal = cases.impacts(rng, 50, "corner")
    point = case[2] + 0.3 * rng.normal(size=(50, 3))
    expected = np.concatenate(analytic.box_impact(*case, point, normal, 0.5), axis=1)
    for i in range(50):
        bodies = tuple(x[i : i + 1] for x in case)
        after, _ = multicontact.manifold_impact(bodies, point[i : i + 1], normal[i : i + 1], 0.5)
        assert after == pytest.approx(expected[i], rel=1e-11, abs=1e-11)


def test_no_contact_pulls_and_none_goes_on_closing():
    rng = np.random.default_rng(1)
    for _ in range(50):
        bodies = cube_on_floor(rng.normal(size=3), rng.normal(size=3))
        after, turns = multicontact.manifold_impact(bodies, CORNERS, UP, 0.5)
        before = np.concatenate([np.asarray(bodies[k])[0] for k in (4, 5)])
        arms = CORNERS - bodies[2]
        was, now = (v[2] + np.cross(v[3:6], arms)[:, 2] for v in (before, after))
        assert (now >= -1e-12).all()
        assert turns > 1 or (now >= 0.5 * np.maximum(0.0, -was) - 1e-12).all()
        if was.min() >= 0.0:
            assert after[:6] == pytest.approx(before)


def test_a_rod_that_strikes_with_one_end_strikes_with_the_other_and_keeps_its_energy():
    tilted = cube_on_floor((0.0, 0.0, -0.5), (0.0, 1.2, 0.0))  # its end at +x comes down, that at −x rises
    ends, up = CORNERS[[0, 2]] * (1.0, 0.0, 1.0), UP[:2]
    after, turns = multicontact.manifold_impact(tilted, ends, up, 1.0)
    change, _, energy = multicontact.energy_change(tilted, ends, up, np.zeros(2), after)
    assert turns > 1
    assert abs(change) < 1e-12 * energy


def test_energy_and_momenta_by_hand():
    bodies = cube_on_floor((0.0, 0.0, -3.0))
    after, _ = multicontact.manifold_impact(bodies, CORNERS, UP, 0.0)
    change, work, energy = multicontact.energy_change(bodies, CORNERS, UP, np.full(4, 1.5), after)
    assert (change, work, energy) == pytest.approx((-9.0, -9.0, 9.0))
    free = (*bodies[:6], ONE, np.array([1.0]), REST, UPRIGHT, REST, REST)
    assert multicontact.momenta(free, np.array([1.0, 0, 0, 0, 0, 3.0, *[0.0] * 6])) == pytest.approx([2, 0, 0, 0, 1, 1])
