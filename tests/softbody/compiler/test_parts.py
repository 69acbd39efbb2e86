"""Is a part of a row a view of the entries that its span says, compiled or not, and does it begin a cache line?"""

import numpy as np
import pytest

from softbody.compiler.jit import jit
from softbody.compiler.parts import CACHE_LINE, odd_lines, part_of, room_for, spans_of

KINDS = [np.dtype(kind) for kind in (np.float64, np.float32, np.int32, np.uint8)]
WIDTH = 8


@jit
def pair(row, spans, part):
    """Return a part as (k,) and as (k, 3, 8)."""
    return part_of(row, spans, part, ()), part_of(row, spans, part, (3, WIDTH))


@jit
def count_in(rows, spans):
    """Add 1 to each entry of the second part of the last row."""
    part = part_of(rows[rows.shape[0] - 1], spans, 1, (2,))
    for k in range(part.shape[0]):
        for c in range(part.shape[1]):
            part[k, c] += 1
    return part.shape[0]


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_a_part_is_a_view_of_the_entries_of_its_span(kind):
    row, spans = np.arange(200).astype(kind), np.array([[0, 24], [40, 40], [56, 200]])
    for part, (first, end) in enumerate(spans):
        flat, blocks = pair(row, spans, part)
        assert np.shares_memory(flat, row) or first == end
        for found, shape in ((flat, (-1,)), (blocks, (-1, 3, WIDTH))):
            assert found.dtype == kind
            assert found.flags.c_contiguous
            np.testing.assert_array_equal(found, row[first:end].reshape(shape))


def test_what_is_written_to_a_part_is_written_to_its_row_alone():
    rows = np.zeros((3, 20))
    assert count_in(rows, np.array([[0, 4], [6, 12]])) == 3
    assert rows[2, 6:12].tolist() == [1.0] * 6
    assert rows.sum() == 6.0


def test_parts_of_one_type_follow_each_other_and_begin_cache_lines():
    shapes = [(5, 3), (0,), (1,), (16,), (2, 9, 8)]
    arrays = [np.empty(shape, kind) for shape in shapes for kind in KINDS]
    taken = dict.fromkeys(KINDS, 0)
    spans = spans_of(arrays, taken)
    ends = dict.fromkeys(KINDS, 0)
    for array, (first, end) in zip(arrays, spans, strict=True):
        assert first >= ends[array.dtype]
        assert first * array.itemsize % CACHE_LINE == 0
        assert end - first == array.size
        ends[array.dtype] = end
    assert all(ends[kind] <= taken[kind] < ends[kind] + CACHE_LINE // kind.itemsize for kind in KINDS)


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_rows_are_zeros_that_begin_cache_lines_an_odd_number_apart(kind):
    line = CACHE_LINE // kind.itemsize
    for lines in range(6):
        size = odd_lines(lines * line, kind)
        assert size in (lines * line, (lines + 1) * line)
        assert size // line % 2 == 1
        rows = room_for((3, size), kind)
        assert rows.shape == (3, size)
        assert rows.dtype == kind
        assert not rows.any()
        assert all(row.ctypes.data % CACHE_LINE == 0 for row in rows)
