"""Does a point of a surface move as its corners do, and feel an impulse where it is?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from softbody.model.surface_point import SurfacePoint, add_at, at_particle, on_edge, value_at


@given(st.integers(0, 10**6))
def test_an_impulse_at_a_point_is_the_same_impulse_on_its_corners_and_moves_it_by_w2_over_m(seed):
    random = np.random.default_rng(seed)
    position, velocity, inverse_mass = (
        random.normal(size=(4, 3)),
        random.normal(size=(4, 3)),
        random.uniform(0.1, 10, 4),
    )
    weights, push = random.dirichlet((1.0, 1.0, 1.0)), random.normal(size=3)

    def momenta():
        return velocity.T @ (1.0 / inverse_mass), np.cross(position, velocity).T @ (1.0 / inverse_mass)

    before = momenta()
    point = SurfacePoint((0, 1, 2), tuple(weights))
    speed = np.array(value_at(velocity, point))
    add_at(velocity, inverse_mass, point, tuple(push))
    after = momenta()
    np.testing.assert_allclose(after[0] - before[0], push, atol=1e-12)
    np.testing.assert_allclose(after[1] - before[1], np.cross(weights @ position[:3], push), atol=1e-12)
    gained = np.array(value_at(velocity, point)) - speed
    np.testing.assert_allclose(gained, (weights**2 @ inverse_mass[:3]) * push, atol=1e-12)


def test_a_point_is_named_by_its_particle_or_its_place_on_an_edge():
    rows = np.random.default_rng(0).normal(size=(9, 3))
    assert value_at(rows, at_particle(4)) == pytest.approx(rows[4], abs=1e-15)
    assert value_at(rows, on_edge(4, 6, 0.25)) == pytest.approx(0.75 * rows[4] + 0.25 * rows[6], abs=1e-15)
