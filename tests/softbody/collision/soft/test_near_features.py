"""Are pairs of features one number each, and in order however they were found?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from softbody.collision.soft.near_features import EDGE, TRIANGLE, features_of, kind_of, pair_of, sort_pairs


@pytest.mark.parametrize("kind", [TRIANGLE, EDGE])
@pytest.mark.parametrize("features", [(0, 0), (3, 2**30 - 1), (2**30 - 1, 5)])
def test_a_pair_tells_its_kind_and_features(kind, features):
    pair = pair_of(kind, *features)
    assert (kind_of(pair), features_of(pair)) == (kind, features)


@given(st.lists(st.integers(0, 2**61), unique=True), st.integers(0, 20))
def test_pairs_are_sorted_with_their_numbers(pairs, already):
    already = min(already, len(pairs))
    one = np.array([*sorted(pairs[:already]), *pairs[already:]], np.int64)
    base = one.astype(float)
    sort_pairs(one, base, already)
    assert one.tolist() == sorted(pairs)
    assert base.tolist() == [float(pair) for pair in sorted(pairs)]
