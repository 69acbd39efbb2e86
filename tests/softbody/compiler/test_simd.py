"""Are lanes the same compiled as NumPy's arrays of eight, to the last bit, and is what does not fit refused?"""

import os
import subprocess
import sys

import numba
import numpy as np
import pytest

from softbody.compiler.jit import jit, jit_lean
from softbody.compiler.simd import (
    LANES,
    bits_at_most,
    first_lanes,
    gather_lanes,
    in_double,
    in_single,
    least_lane,
    load_lanes,
    lowest_bit,
    scatter_lanes,
    spread,
    square_root,
    store_lanes,
    sum_of_lanes,
    where_less,
)

compiled = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")
precisions = pytest.mark.parametrize("real", [np.float64, np.float32])


@jit_lean
def formula(x, y, s, out):
    """Use every operator, with lanes and with one real on either side."""
    a, b = load_lanes(x, 1), load_lanes(y, 2)
    c = s - (a + b) * (s * a) / (b - s) + (a - b) / s
    store_lanes(out, 3, where_less(a, b, c, s) + square_root(b) * spread(s))


@precisions
def test_arithmetic_is_that_of_arrays_to_the_last_bit(real):
    rng = np.random.default_rng(1)
    for _ in range(50):
        x, y = (rng.uniform(0.5, 2.0, 12) * 10.0 ** rng.uniform(-3, 3, 12)).astype(real), rng.uniform(3.0, 4.0, 12)
        y, s, out = y.astype(real), real(rng.normal()), np.full(12, -1.0, real)
        formula(x, y, s, out)
        a, b = x[1:9], y[2:10]
        c = s - (a + b) * (s * a) / (b - s) + (a - b) / s
        assert out[3:11].tolist() == (np.where(a < b, c, s) + np.sqrt(b) * s).tolist()
        assert out[:3].tolist() + out[11:].tolist() == [-1.0] * 4


@jit_lean
def gathered(x, index, e, out):
    store_lanes(out, 0, gather_lanes(x, index, e))


@precisions
def test_lanes_are_gathered_from_where_the_index_says(real):
    x, index, out = (
        np.arange(20.0).astype(real),
        np.array([9, 3, 3, 19, 0, 7, 8, 1, 2, 5], np.uint32),
        np.empty(8, real),
    )
    gathered(x, index, 2, out)
    assert out.tolist() == [3.0, 19.0, 0.0, 7.0, 8.0, 1.0, 2.0, 5.0]


@precisions
def test_lanes_of_the_other_precision_are_rounded_where_they_are_stored(real):
    other = np.float32 if real is np.float64 else np.float64
    x = (np.arange(8.0) / 3.0).astype(other)
    stored, put = np.zeros(8, real), np.zeros(8, real)
    gathered(x, np.arange(8, dtype=np.uint32), 0, stored)
    scattered(put, np.arange(8, dtype=np.uint32)[::-1].copy(), 0, x)
    assert stored.tolist() == x.astype(real).tolist()
    assert put.tolist() == x.astype(real)[::-1].tolist()


@jit_lean
def scattered(x, index, e, lanes):
    scatter_lanes(x, index, e, load_lanes(lanes, 0))


@precisions
def test_lanes_are_scattered_to_where_the_index_says_and_the_last_one_stays(real):
    x, index = np.full(20, -1.0, real), np.array([9, 3, 3, 19, 0, 7, 8, 3, 2, 5], np.uint32)
    scattered(x, index, 2, np.arange(8.0).astype(real))
    assert {k: x[k] for k in range(20) if x[k] >= 0.0} == {3: 5.0, 19: 1.0, 0: 2.0, 7: 3.0, 8: 4.0, 2: 6.0, 5: 7.0}


@jit_lean
def sums(x, number):
    first = in_double(first_lanes(load_lanes(x, 0), number))
    return sum_of_lanes(first), least_lane(load_lanes(x, 0))


@precisions
@pytest.mark.parametrize("number", [-3, 0, 1, 5, 8, 11])
def test_the_first_lanes_are_summed_in_double_precision(real, number):
    x = np.array([1e8, 1.0, 2.0, -3.0, 5.0, 0.25, 7.0, 9.0], real)
    total, least = sums(x, number)
    assert total == x[: max(0, number)].astype(np.float64).sum()
    assert least == -3.0


@jit_lean
def rounded(x, out):
    store_lanes(out, 0, in_single(load_lanes(x, 0)))


@precisions
def test_lanes_are_rounded_to_single_precision(real):
    x, out = np.array([0.1, -1.0 / 3.0, 1e300, -1e-50, 2.0**-149, np.inf, 16777217.0, 3.0]), np.empty(8, np.float32)
    with np.errstate(over="ignore"):
        x = x.astype(real)
        rounded(x, out)
        assert out.tolist() == x.astype(np.float32).tolist()


@jit_lean
def least(x):
    return least_lane(load_lanes(x, 0))


def test_what_is_no_number_is_not_the_least():
    x = np.array([2.0, np.nan, 1.0, 3.0, np.nan, 4.0, 5.0, 6.0])
    assert least(x) == 1.0


@jit_lean
def bits_of(x, y, s):
    a, b = load_lanes(x, 0), load_lanes(y, 0)
    return bits_at_most(a, b), bits_at_most(a, s), bits_at_most(s, a) & bits_at_most(s, b)


@precisions
def test_bits_tell_in_which_lanes_one_is_at_most_the_other(real):
    rng = np.random.default_rng(3)
    for _ in range(50):
        x, y = rng.integers(-2, 3, (2, 8)).astype(real)
        x[rng.integers(8)] = np.nan
        s = real(1.0)
        expected = [int(np.packbits(lanes, bitorder="little")[0]) for lanes in (x <= y, x <= s, (s <= x) & (s <= y))]
        assert list(bits_of(x, y, s)) == expected


@jit_lean
def places_of(bits, out):
    count = 0
    while bits != 0:
        out[count] = lowest_bit(bits)
        bits &= bits - 1
        count += 1
    return count


@pytest.mark.parametrize("bits", [0, 1, 128, 255, 0b1010_0110, 1 << 40])
def test_the_lowest_bit_is_where_it_is(bits):
    out = np.empty(64, np.int64)
    assert out[: places_of(bits, out)].tolist() == [k for k in range(64) if bits >> k & 1]


@jit
def carried(x):
    """Lanes pass through tuples, loops and other kernels."""
    low, high = load_lanes(x, 0), spread(0.0)
    for i in range(0, x.shape[0], LANES):
        low, high = _narrowed(low, high, load_lanes(x, i))
    return sum_of_lanes(low), sum_of_lanes(high)


@jit
def _narrowed(low, high, here):
    return where_less(here, low, here, low), where_less(high, here, here, high)


def test_lanes_pass_through_tuples_loops_and_kernels():
    x = np.random.default_rng(2).uniform(0.0, 1.0, 40)
    rows = x.reshape(-1, LANES)
    assert carried(x) == (pytest.approx(rows.min(axis=0).sum()), pytest.approx(rows.max(axis=0).sum()))


@compiled
@pytest.mark.parametrize("rows", [np.zeros((4, 16))[:, 3], np.zeros(16)[::2], np.zeros((2, 8)), np.zeros(16, np.int64)])
def test_an_array_with_gaps_or_without_reals_is_refused(rows):
    with pytest.raises(numba.TypingError):
        least(rows)


@compiled
def test_lanes_of_two_precisions_are_not_mixed():
    @numba.njit
    def mixed(x, y):
        return sum_of_lanes(load_lanes(x, 0) + load_lanes(y, 0))

    with pytest.raises(numba.TypingError):
        mixed(np.zeros(8), np.zeros(8, np.float32))


OUTSIDE = """
import numba, numpy as np
from softbody.compiler.simd import gather_lanes, load_lanes, scatter_lanes, store_lanes, sum_of_lanes

@numba.njit(nogil=True)
def load(x, i): return sum_of_lanes(load_lanes(x, i))

@numba.njit(nogil=True)
def keep(x, i): store_lanes(x, i, load_lanes(x, 0))

@numba.njit(nogil=True)
def gather(x, index, i): return sum_of_lanes(gather_lanes(x, index, i))

@numba.njit(nogil=True)
def scatter(x, index, i): scatter_lanes(x, index, i, load_lanes(x, 0))

x, index = np.zeros(10), np.full(8, 10, np.uint32)
for call, *arguments in (
    (load, x, 3), (load, x, -1), (keep, x, 3), (gather, x, index, 0), (gather, np.zeros(11), index, 1),
    (scatter, x, index, 0), (scatter, np.zeros(11), index, 1)
):
    try:
        call(*arguments)
    except (IndexError, AssertionError):
        print("refused")
load(x, 2), keep(x, 2), gather(np.zeros(11), index, 0), scatter(np.zeros(11), index, 0)
"""


@pytest.mark.parametrize("flags", [{"NUMBA_BOUNDSCHECK": "1"}, {"NUMBA_DISABLE_JIT": "1"}])
def test_lanes_outside_of_an_array_are_seen_by_bounds_checks_and_without_the_compiler(flags):
    run = [sys.executable, "-c", OUTSIDE]
    done = subprocess.run(run, env={**os.environ, **flags}, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["refused"] * 7
