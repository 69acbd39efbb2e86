"""Many arrays as parts of a few: each array that a kernel takes is some eight scalars of every call that is compiled.

A table of spans (parts, 2) says where each part is among the entries of its type: columns FIRST and END.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import prod
from typing import Any

import numba
import numpy as np

FIRST, END = 0, 1
CACHE_LINE = 64  # bytes

if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]

    def part_of(row: np.ndarray, spans: np.ndarray, part: int, shape: tuple[int, ...]) -> np.ndarray:
        """Return a view of a `part` of the contiguous `row` (n,): an array (k, *shape), of as many k as it has."""
        assert 0 <= spans[part, FIRST] <= spans[part, END] <= len(row)
        return row[spans[part, FIRST] : spans[part, END]].reshape(-1, *shape)

else:
    from softbody.compiler.part_views import part_of as part_of  # type: ignore[assignment]


def spans_of(parts: Sequence[np.ndarray], taken: dict[np.dtype[Any], int]) -> np.ndarray:
    """Return spans (parts, 2) for arrays, those of each type one after the other, each at the start of a cache line.

    `taken` counts the entries of each type that there are before, and is counted on.
    """
    spans = np.empty((len(parts), 2), np.int64)
    for span, part in zip(spans, parts, strict=True):
        span[FIRST] = taken[part.dtype]
        span[END] = span[FIRST] + part.size
        taken[part.dtype] = _line(part.dtype) * -(-int(span[END]) // _line(part.dtype))
    return spans


def odd_lines(size: int, dtype: np.dtype[Any]) -> int:
    """Return so many entries, or some more, that they are an odd number of cache lines.

    Rows a multiple of 4 096 bytes apart would evict each other.
    """
    return (size // _line(dtype) // 2 * 2 + 1) * _line(dtype)


def room_for(shape: tuple[int, ...], dtype: np.dtype[Any]) -> np.ndarray:
    """Return zeros, the first of which is at the start of a cache line."""
    size = prod(shape) * dtype.itemsize
    memory = np.zeros(size + CACHE_LINE, np.uint8)
    first = -memory.ctypes.data % CACHE_LINE
    return memory[first : first + size].view(dtype).reshape(shape)


def _line(dtype: np.dtype[Any]) -> int:
    """Return how many entries a cache line holds."""
    return CACHE_LINE // dtype.itemsize
