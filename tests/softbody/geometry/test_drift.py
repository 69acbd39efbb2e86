"""How far have points drifted apart?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from softbody.geometry.drift import drift, drift_of_rows

pytestmark = pytest.mark.interpreted


@given(st.integers(0, 2**32 - 1), st.integers(1, 30))
def test_no_point_has_moved_farther_from_where_a_shift_takes_it(seed, count):
    rng = np.random.default_rng(seed)
    seen, way = rng.normal(size=(2, count, 3))
    far = drift(seen + way + [5.0, -3.0, 2.0], seen)
    middle = (way.max(axis=0) + way.min(axis=0)) / 2.0
    assert np.linalg.norm(way - middle, axis=1).max() <= far * (1.0 + 1e-12) + 1e-14
    assert far == pytest.approx(np.linalg.norm(np.ptp(way, axis=0)) / 2.0, rel=1e-9, abs=1e-14)


@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("last", range(24))
def test_rows_tell_the_same(real, last):
    rng = np.random.default_rng(last)
    seen, now = rng.normal(size=(2, 3, 24)).astype(real)
    now[:, last] += 9.0
    assert drift_of_rows(now, seen, 24) == pytest.approx(drift(now.T.astype(float), seen.T.astype(float)), rel=1e-6)


def test_what_is_no_number_is_in_no_room():
    assert not drift(np.array([[0.0, 0.0, 0.0], [np.nan, 0.0, 0.0]]), np.zeros((2, 3))) <= 1.0
