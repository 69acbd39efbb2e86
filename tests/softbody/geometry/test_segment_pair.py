"""Where do two segments come nearest: no two points of them are nearer, in any position?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from softbody.geometry.segment_pair import closest_places_on_segments

NUMBERS = st.floats(-1.0, 1.0).map(lambda x: round(x, 3))
POINTS = st.tuples(NUMBERS, NUMBERS, NUMBERS)


@given(POINTS, POINTS, POINTS, POINTS)
def test_no_two_points_are_nearer(p, q, r, s):
    p, q, r, s = map(np.array, (p, q, r, s))
    if np.linalg.norm(q - p) < 1e-2 or np.linalg.norm(s - r) < 1e-2:
        return
    u, v, square = closest_places_on_segments(*map(tuple, (p, q, r, s)))
    assert 0.0 <= u <= 1.0
    assert 0.0 <= v <= 1.0
    assert square == pytest.approx(((p + u * (q - p) - r - v * (s - r)) ** 2).sum(), abs=1e-12)
    places = np.linspace(0.0, 1.0, 21)
    ways = (p + np.multiply.outer(places, q - p))[:, None] - (r + np.multiply.outer(places, s - r))[None]
    assert square <= (ways**2).sum(axis=2).min() + 1e-9


def test_parallel_segments_have_the_distance_of_their_lines():
    u, v, square = closest_places_on_segments((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.5, 0.3, 0.0), (1.5, 0.3, 0.0))
    assert square == pytest.approx(0.09)
    assert 2.0 * u == pytest.approx(0.5 + v)
