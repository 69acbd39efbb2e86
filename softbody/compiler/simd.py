"""Eight reals side by side as one value: a kernel says what is vectorised, and does not depend on what LLVM sees.

Lanes are added, subtracted, multiplied and divided one by one, with each other or with one real of their precision:
strict IEEE, the same bits on every processor, compiled or interpreted. Interpreted they are NumPy arrays of eight, and
this is what the functions mean; `softbody.compiler.simd_types` makes the same of them in registers. (Write a = a + b:
what a += b changes is, interpreted, every name that the lanes have.)
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np

LANES = 8

Lanes = Any  # eight reals, as annotations name them

if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]

    def load_lanes(array: np.ndarray, i: int) -> Lanes:
        """Return entries i … i + 7 of a contiguous array (n,)."""
        assert i >= 0
        assert i + LANES <= len(array)
        return array[i : i + LANES].copy()

    def store_lanes(array: np.ndarray, i: int, lanes: Lanes) -> None:
        """Overwrite entries i … i + 7 of a contiguous array (n,), rounded to its precision."""
        assert i >= 0
        assert i + LANES <= len(array)
        array[i : i + LANES] = lanes

    def gather_lanes(array: np.ndarray, index: np.ndarray, i: int) -> Lanes:
        """Return the entries of `array` (n,) that `index` (e,), unsigned, names at i … i + 7."""
        assert i >= 0
        assert i + LANES <= len(index)
        return array[index[i : i + LANES]]

    def scatter_lanes(array: np.ndarray, index: np.ndarray, i: int, lanes: Lanes) -> None:
        """Overwrite what `gather_lanes` returns, rounded; an entry that the index names twice gets the last lane."""
        assert i >= 0
        assert i + LANES <= len(index)
        array[index[i : i + LANES]] = lanes

    def spread(value: float) -> Lanes:
        """Return a real of np.float64 or np.float32 in all lanes."""
        return np.full(LANES, value)

    def square_root(lanes: Lanes) -> Lanes:
        """Return the square roots."""
        return np.sqrt(lanes)

    def where_less(a: Lanes, b: Lanes, yes: Lanes, no: Lanes) -> Lanes:
        """Return `yes` in the lanes where a < b, and `no` in all others; each may be one real."""
        return np.where(a < b, yes, no)

    def bits_at_most(a: Lanes, b: Lanes) -> int:
        """Return bits: the lowest tells whether a ≤ b in the first lane, and so on; one of both may be one real."""
        return int(np.packbits(a <= b, bitorder="little")[0])

    def lowest_bit(bits: int) -> int:
        """Return the place, from 0 on, of the lowest bit that is set; one must be."""
        return (int(bits) & -int(bits)).bit_length() - 1

    def first_lanes(lanes: Lanes, number: int) -> Lanes:
        """Return the first `number` lanes, and zero in the others."""
        return np.where(np.arange(LANES) < number, lanes, lanes.dtype.type(0.0))

    def in_double(lanes: Lanes) -> Lanes:
        """Return the lanes in double precision."""
        return lanes.astype(np.float64)

    def in_single(lanes: Lanes) -> Lanes:
        """Return the lanes rounded to single precision."""
        return lanes.astype(np.float32)

    def least_lane(lanes: Lanes) -> float:
        """Return the least of all lanes; what is no number is passed over, but for the first."""
        least = lanes[0]
        for lane in range(1, LANES):
            least = lanes[lane] if lanes[lane] < least else least
        return least

    def sum_of_lanes(lanes: Lanes) -> float:
        """Return the sum of all lanes, of neighbours first."""
        a, b, c, d, e, f, g, h = lanes
        return ((a + b) + (c + d)) + ((e + f) + (g + h))

else:
    from softbody.compiler.simd_types import (  # type: ignore[assignment]  # noqa: F401
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
