"""Point-in-mesh test of many points: triangles binned on a grid seen from above; for geometry users.

The same answers as `point_in_polyhedron`, bit for bit. The bounding box is cut into columns along z, and each column
into LEVELS. A triangle is listed in every column that its projection's bounding box meets, and marks the levels that it
passes through. No surface passes through an unmarked block, so all its points are on the same side, if the mesh is
closed: that side is found once for a run of blocks, often from a neighbour's, and most points need no triangle at all.
A point in a marked block counts the triangles between itself and the next block above whose side is known.

A mesh that is not closed has no sides: then every block but the topmost counts as marked.
"""

from __future__ import annotations

from math import isfinite, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from softbody.compiler.jit import jit, jit_lean
from softbody.geometry.aabb import bounding_box
from softbody.geometry.polyhedron import ray_hits_triangle
from softbody.geometry.triangle_list import checked_triangles, edges_meet_evenly
from softbody.linalg.vec import Vec, load

# Of a column: one bit each of a 64-bit word. Triangles and points keep to 1 … 62; 0 lies below the mesh, 63 above it.
LEVELS = 64
LOWEST, HIGHEST = 1, LEVELS - 2

# Fewer columns are listed faster, more leave fewer triangles in each. For one point a triangle 1/4 is best in sum
# (twice or half as many cost 10 to 20 % more, from 1e3 to 1e6 triangles); for a hundred points a triangle 4 is.
COLUMNS_PER_TRIANGLE = 0.25

STEP_BITS = 4
STEPS = 1 << STEP_BITS  # fine steps across a column, for a box test inside the column

# An entry of a column's list is one word: the triangle's index, and what part of the column its bounding box takes, as
# six numbers each with a guard bit above it. With these, all six comparisons of the box test are one subtraction.
_RIGHT, _LEFT, _BACK, _FRONT, _TOP, _BOTTOM = (np.uint64(shift) for shift in (32, 37, 42, 47, 52, 58))
_GUARDS = np.uint64((1 << 36) | (1 << 41) | (1 << 46) | (1 << 51) | (1 << 57) | (1 << 63))
_INDEX = np.uint64(0xFFFFFFFF)

_NONE, _ONE, _ALL = np.uint64(0), np.uint64(1), np.uint64(0xFFFFFFFFFFFFFFFF)

BLOCK = 2048  # points answered at a time: those in unmarked blocks first, without a branch


class ParityGrid(NamedTuple):
    """The grid of one mesh; made by `build_parity_grid` once, by `rebuild_parity_grid` each time the mesh has moved."""

    triangles: np.ndarray  # (t, 3) int32
    closed: bool  # does every edge belong to an even number of triangles?
    columns: float  # how many are wanted
    frame: np.ndarray  # (10,): low and high corner [m], fine steps (x, y) and levels (z) a metre, lowest z of points
    shape: np.ndarray  # (2,) columns along x and y
    start: np.ndarray  # (columns + 2,) where in `entries` the list of each column starts
    entries: np.ndarray  # (capacity,) uint64, see above
    marked: np.ndarray  # (columns,) uint64: bit l is set if a triangle passes through level l
    inside: np.ndarray  # (columns,) uint64: bit l is set if level l is known to be inside
    outside: np.ndarray  # (columns,) uint64: the same for outside
    unsorted_column: np.ndarray  # (capacity,) int32
    unsorted_entry: np.ndarray  # (capacity,) uint64
    lattice: np.ndarray  # (n, 3) int32: the vertices in fine steps and levels


Frame = tuple[float, float, float, float, float, float, float, float, float, float, int, int]


def build_parity_grid(
    vertices: ArrayLike, triangles: ArrayLike, columns_per_triangle: float = COLUMNS_PER_TRIANGLE
) -> ParityGrid:
    """Return a grid for a mesh: `vertices` (n, 3) [m], `triangles` (t, 3), which may be open or meet itself.

    Holds arrays for triangles that keep their indices while the vertices move, about 170 bytes a triangle. Raises
    MeshError if an index is out of range or a vertex not finite.
    """
    vertices, triangles = checked_triangles(vertices, triangles)
    count = len(triangles)
    columns = max(1.0, columns_per_triangle * count)
    room = int(1.3 * columns) + 8192  # the grid's sides are rounded to whole numbers, and it may be one column thin
    # Of equal-sided triangles each meets 1 + 1.9 √c columns in either direction. A mesh that has more gets fewer
    # columns.
    capacity = int(1.6 * (1.0 + 1.9 * sqrt(columns_per_triangle)) ** 2 * count) + 1000
    grid = ParityGrid(
        triangles=triangles.astype(np.int32),
        closed=edges_meet_evenly(triangles),
        columns=columns,
        frame=np.zeros(10),
        shape=np.zeros(2, np.int64),
        start=np.zeros(room, np.int32),
        entries=np.zeros(capacity, np.uint64),
        marked=np.zeros(room, np.uint64),
        inside=np.zeros(room, np.uint64),
        outside=np.zeros(room, np.uint64),
        unsorted_column=np.zeros(capacity, np.int32),
        unsorted_entry=np.zeros(capacity, np.uint64),
        lattice=np.zeros((len(vertices), 3), np.int32),
    )
    rebuild_parity_grid(grid, vertices)
    return grid


@jit
def rebuild_parity_grid(grid: ParityGrid, vertices: np.ndarray) -> None:
    """Bin the triangles where `vertices` (n, 3) [m] now are. If any is not finite, no point is inside."""
    low, high = bounding_box(vertices)
    if not (isfinite(low[0] + low[1] + low[2]) and isfinite(high[0] + high[1] + high[2])):
        grid.frame[:] = np.nan
        grid.shape[:] = 1
        return
    columns = grid.columns
    while True:
        _lay_out(grid, vertices, low, high, columns)
        count = _list_triangles(grid)
        if count >= 0:
            break
        columns *= 0.25  # one column holds each triangle once, for which there is always room
    _sort_entries(grid, count)
    _find_sides(grid, vertices)


@jit_lean
def _lay_out(grid: ParityGrid, vertices: np.ndarray, low: Vec, high: Vec, columns: float) -> None:
    """Choose the grid's shape and frame, and put the vertices on its lattice."""
    tiny = 1e-300  # a flat side gets one column
    width, length, height = (
        max(high[0] - low[0], tiny),
        max(high[1] - low[1], tiny),
        max(high[2] - low[2], tiny),
    )
    along_x = max(1, min(2047, int(sqrt(columns * min(width / length, 1e12)) + 0.5)))
    along_y = max(1, min(2047, int(columns / along_x + 0.5)))
    grid.shape[0], grid.shape[1] = along_x, along_y
    frame = grid.frame
    frame[0], frame[1], frame[2] = low
    frame[3], frame[4], frame[5] = high
    frame[6] = STEPS * along_x / width
    frame[7] = STEPS * along_y / length
    frame[8] = (HIGHEST - LOWEST + 1) / height
    frame[9] = low[2] if grid.closed else -np.inf
    f = _frame(grid)
    lattice = grid.lattice
    for i in range(vertices.shape[0]):
        lattice[i, 0] = _step(vertices[i, 0], f[0], f[6], STEPS * f[10])
        lattice[i, 1] = _step(vertices[i, 1], f[1], f[7], STEPS * f[11])
        lattice[i, 2] = LOWEST + _step(vertices[i, 2], f[2], f[8], HIGHEST - LOWEST + 1)


@jit_lean
def _frame(grid: ParityGrid) -> Frame:
    """Return frame and shape as numbers: a kernel that stores into arrays would read them again and again."""
    f, s = grid.frame, grid.shape
    return f[0], f[1], f[2], f[3], f[4], f[5], f[6], f[7], f[8], f[9], s[0], s[1]


@jit_lean
def _step(x: float, low: float, per_metre: float, steps: int) -> int:
    """Return in which of `steps` steps from `low` [m] up `x` is; what lies beyond an end is in the last one.

    Never falls while x rises, rounding included. All that is exact here rests on that.
    """
    return int(min(max((x - low) * per_metre, 0.0), steps - 0.5))


@jit_lean
def _list_triangles(grid: ParityGrid) -> int:
    """Write an entry for each triangle and column that it meets, unsorted; return how many, or −1 for too many."""
    along_x, columns = grid.shape[0], grid.shape[0] * grid.shape[1]
    triangles, lattice = grid.triangles, grid.lattice
    start, marked, of_column, entries = grid.start, grid.marked, grid.unsorted_column, grid.unsorted_entry
    start[: columns + 2] = 0
    marked[:columns] = _NONE
    count = 0
    room = entries.shape[0] - 4
    for t in range(triangles.shape[0]):
        # The triangle's bounding box, in fine steps across and in levels up.
        i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        left = min(lattice[i, 0], lattice[j, 0], lattice[k, 0])
        right = max(lattice[i, 0], lattice[j, 0], lattice[k, 0])
        front = min(lattice[i, 1], lattice[j, 1], lattice[k, 1])
        back = max(lattice[i, 1], lattice[j, 1], lattice[k, 1])
        bottom = min(lattice[i, 2], lattice[j, 2], lattice[k, 2])
        highest = max(lattice[i, 2], lattice[j, 2], lattice[k, 2])
        levels = ((np.uint64(2) << np.uint64(highest - bottom)) - _ONE) << np.uint64(bottom)
        first_x, last_x, first_y, last_y = left >> STEP_BITS, right >> STEP_BITS, front >> STEP_BITS, back >> STEP_BITS
        entry = np.uint64(t) | np.uint64(highest >> 1) << _TOP | np.uint64(31 - (bottom >> 1)) << _BOTTOM
        if count > room:
            return -1
        if last_x - first_x <= 1 and last_y - first_y <= 1:
            # Up to 2 × 2 columns, as most triangles: all four are written, without a branch, and counted if they
            # differ.
            wide, deep = last_x - first_x, last_y - first_y
            # The four columns, and what part of each the box takes.
            a = first_y * along_x + first_x
            b = a + wide
            c = a + deep * along_x
            d = c + wide
            in_right = (right - last_x * STEPS) if wide == 0 else STEPS - 1
            in_back = (back - last_y * STEPS) if deep == 0 else STEPS - 1
            west = np.uint64(in_right) << _RIGHT | np.uint64(STEPS - 1 - (left - first_x * STEPS)) << _LEFT
            east = np.uint64(right - last_x * STEPS) << _RIGHT | np.uint64(STEPS - 1) << _LEFT
            south = np.uint64(in_back) << _BACK | np.uint64(STEPS - 1 - (front - first_y * STEPS)) << _FRONT
            north = np.uint64(back - last_y * STEPS) << _BACK | np.uint64(STEPS - 1) << _FRONT
            # How many entries each column gets, which of its levels are marked, and the entries themselves.
            start[a + 2] += 1
            start[b + 2] += wide
            start[c + 2] += deep
            start[d + 2] += wide * deep
            marked[a] |= levels
            marked[b] |= levels
            marked[c] |= levels
            marked[d] |= levels
            of_column[count], entries[count] = a, entry | west | south
            count += 1
            of_column[count], entries[count] = b, entry | east | south
            count += wide
            of_column[count], entries[count] = c, entry | west | north
            count += deep
            of_column[count], entries[count] = d, entry | east | north
            count += wide * deep
        else:
            if count + (last_x - first_x + 1) * (last_y - first_y + 1) > room:
                return -1
            count = _list_wide_triangle(grid, (left, right, front, back), entry, levels, count)
    return count


@jit_lean
def _list_wide_triangle(
    grid: ParityGrid, footprint: tuple[int, int, int, int], entry: np.uint64, levels: np.uint64, count: int
) -> int:
    """Write an entry for each column under a triangle's `footprint`, a box in fine steps; return the count."""
    left, right, front, back = footprint
    along_x, start, marked = grid.shape[0], grid.start, grid.marked
    of_column, entries = grid.unsorted_column, grid.unsorted_entry
    for y in range(front >> STEP_BITS, (back >> STEP_BITS) + 1):
        in_front = max(front - y * STEPS, 0)
        in_back = min(back - y * STEPS, STEPS - 1)
        row = np.uint64(in_back) << _BACK | np.uint64(STEPS - 1 - in_front) << _FRONT
        for x in range(left >> STEP_BITS, (right >> STEP_BITS) + 1):
            in_left = max(left - x * STEPS, 0)
            in_right = min(right - x * STEPS, STEPS - 1)
            cell = np.uint64(in_right) << _RIGHT | np.uint64(STEPS - 1 - in_left) << _LEFT
            column = y * along_x + x
            start[column + 2] += 1
            marked[column] |= levels
            of_column[count], entries[count] = column, entry | row | cell
            count += 1
    return count


@jit_lean
def _sort_entries(grid: ParityGrid, count: int) -> None:
    """Gather the entries column by column: a counting sort, which keeps triangles in order."""
    start = grid.start
    for k in range(2, grid.shape[0] * grid.shape[1] + 2):
        start[k] += start[k - 1]
    for p in range(count):
        k = grid.unsorted_column[p] + 1
        grid.entries[start[k]] = grid.unsorted_entry[p]
        start[k] += 1


@jit
def _find_sides(grid: ParityGrid, vertices: np.ndarray) -> None:
    """Find for each run of unmarked levels of each column whether it is inside."""
    f = _frame(grid)
    along_x, along_y = grid.shape[0], grid.shape[1]
    marked, inside, outside = grid.marked, grid.inside, grid.outside
    for y in range(along_y):
        for x in range(along_x):
            k = y * along_x + x
            below_top = marked[k]
            for shift in (1, 2, 4, 8, 16, 32):
                below_top |= below_top >> np.uint64(shift)
            now_inside, now_outside = _NONE, ~below_top  # above all triangles: outside
            left = ~marked[k] & below_top if grid.closed else _NONE
            while left != _NONE:
                lowest = left & (~left + _ONE)
                run = left & ~(left + lowest)
                left ^= run
                side_in, side_out = _NONE, run & _ONE  # below all triangles: outside
                if x > 0 and side_out == _NONE:
                    side_in, side_out = inside[k - 1] & run, outside[k - 1] & run
                if y > 0 and (side_in | side_out) == _NONE:
                    side_in, side_out = inside[k - along_x] & run, outside[k - along_x] & run
                if (side_in | side_out) == _NONE:
                    answer = _ask_block(grid, vertices, f, (x, y, _bit_number(lowest)))
                    side_in = run if answer == 1 else _NONE
                    side_out = run if answer == 0 else _NONE
                if side_in != _NONE:
                    now_inside |= run
                elif side_out != _NONE:
                    now_outside |= run
            inside[k], outside[k] = now_inside, now_outside


@jit
def _ask_block(grid: ParityGrid, vertices: np.ndarray, f: Frame, block: tuple[int, int, int]) -> int:
    """Return whether an unmarked block, (column along x, along y, level), is inside, 1 or 0, by its middle.

    Or −1, unknown: in a mesh only a few roundings wide, the middle of a block may round into another one.
    """
    x, y, level = block
    p = (
        f[0] + (STEPS * x + 0.5 * STEPS) / f[6],
        f[1] + (STEPS * y + 0.5 * STEPS) / f[7],
        f[2] + (level - LOWEST + 0.5) / f[8],
    )
    fine_x, fine_y, k, at_level = _place(p, f)
    if k != y * f[10] + x or at_level != level:
        return -1
    wanted = _wanted(fine_x, fine_y, level, LEVELS - 1)
    return 1 if _odd_hits(_columns(grid), vertices, p, wanted, k) else 0


@jit
def _bit_number(bit: np.uint64) -> int:
    number = 0
    while bit > _ONE:
        bit >>= _ONE
        number += 1
    return number


@jit_lean
def _place(p: Vec, f: Frame) -> tuple[int, int, int, int]:
    """Return where a point that is `_within` lies: fine steps along x and y in its column, column, level."""
    x = min(int((p[0] - f[0]) * f[6]), STEPS * f[10] - 1)
    y = min(int((p[1] - f[1]) * f[7]), STEPS * f[11] - 1)
    level = min(LOWEST + int(max((p[2] - f[2]) * f[8], 0.0)), HIGHEST)
    return x & (STEPS - 1), y & (STEPS - 1), (y >> STEP_BITS) * f[10] + (x >> STEP_BITS), level


@jit_lean
def _wanted(x: int, y: int, from_level: int, to_level: int) -> np.uint64:
    """Return the word that an entry, its guards set, can be subtracted by without a borrow if its box is met.

    That is, if it covers the fine step (x, y) of the column and reaches from `to_level` or below to `from_level` or
    above. Levels are halved to fit: a triangle one level below `from_level` or above `to_level` may be met, too.
    Below, it is not hit; above, there would be one hit too many: so nothing may start at the level next to
    `to_level`.
    """
    return (
        np.uint64(x) << _RIGHT
        | np.uint64(STEPS - 1 - x) << _LEFT
        | np.uint64(y) << _BACK
        | np.uint64(STEPS - 1 - y) << _FRONT
        | np.uint64(from_level >> 1) << _TOP
        | np.uint64(31 - (to_level >> 1)) << _BOTTOM
    )


Columns = tuple[np.ndarray, np.ndarray, np.ndarray]


@jit
def _columns(grid: ParityGrid) -> Columns:
    """Return what a ray reads of a grid: its triangles, and the lists of its columns."""
    return grid.triangles, grid.start, grid.entries


@jit
def _odd_hits(columns: Columns, vertices: np.ndarray, p: Vec, wanted: np.uint64, k: int) -> bool:
    """Tell whether the +z ray from `p` meets an odd number of those triangles of column `k` that `wanted` asks for."""
    triangles, start, entries = columns
    odd = False
    for e in range(start[k], start[k + 1]):
        entry = entries[e]
        if ((entry | _GUARDS) - wanted) & _GUARDS == _GUARDS:
            t = np.int64(entry & _INDEX)
            a = load(vertices, triangles[t, 0])
            b = load(vertices, triangles[t, 1])
            c = load(vertices, triangles[t, 2])
            odd ^= ray_hits_triangle(p, a, b, c)
    return odd


@jit_lean
def _within(p: Vec, f: Frame) -> bool:
    """Tell whether `p` can be inside: is in the grid's box, or below it if the mesh is open; no number is NaN then."""
    # `&` and not `and`: without a branch for each comparison.
    across = (p[0] >= f[0]) & (p[0] <= f[3]) & (p[1] >= f[1]) & (p[1] <= f[4])
    return across & (p[2] >= f[9]) & (p[2] <= f[5]) & (p[2] > -np.inf)


@jit_lean
def _next_known(inside: np.uint64, outside: np.uint64, level: int) -> int:
    """Return the first level above `level` whose side is known; the topmost always is."""
    known = (inside | outside) >> np.uint64(level + 1)
    while known & _ONE == _NONE:
        known >>= _ONE
        level += 1
    return level + 1


@jit
def point_in_parity_grid(p: Vec, grid: ParityGrid, vertices: np.ndarray) -> bool:
    """Tell whether `p` [m] is inside the mesh of a grid built for `vertices` (n, 3) [m]: as `point_in_polyhedron`."""
    f = _frame(grid)
    if not _within(p, f):
        return False
    x, y, k, level = _place(p, f)
    if ((grid.inside[k] | grid.outside[k]) >> np.uint64(level)) & _ONE == _NONE:
        known = _next_known(grid.inside[k], grid.outside[k], level)
        wanted = _wanted(x, y, level, known - 1)
        odd = _odd_hits(_columns(grid), vertices, p, wanted, k)
        return odd ^ ((grid.inside[k] >> np.uint64(known)) & _ONE != _NONE)
    return (grid.inside[k] >> np.uint64(level)) & _ONE != _NONE


@jit
def points_in_parity_grid(
    points: np.ndarray, grid: ParityGrid, vertices: np.ndarray, answers: np.ndarray, share: tuple[int, int]
) -> None:
    """Write into the answers from share[0] to share[1] whether these of `points` (m, 3) [m] are inside a mesh.

    The grid must have been built for `vertices` (n, 3) [m]; `answers` is (m,) of bool. Threads take shares of the work.
    """
    f = _frame(grid)
    inside, outside = grid.inside, grid.outside
    columns = _columns(grid)
    first, last = share
    unclear = np.empty(min(BLOCK, last - first), np.int64)
    for begin in range(first, last, BLOCK):
        # Points in blocks whose side is known are answered without a branch, the others put aside.
        count = 0
        for q in range(begin, min(begin + BLOCK, last)):
            p = load(points, q)
            if _within(p, f):
                _, _, k, level = _place(p, f)
                is_in = (inside[k] >> np.uint64(level)) & _ONE
                is_out = (outside[k] >> np.uint64(level)) & _ONE
                answers[q] = is_in != _NONE
                unclear[count] = q
                count += (is_in | is_out) == _NONE
            else:
                answers[q] = False
        # The others count the triangles up to the next block whose side is known.
        for u in range(count):
            p = load(points, unclear[u])
            x, y, k, level = _place(p, f)
            known = _next_known(inside[k], outside[k], level)
            odd = _odd_hits(columns, vertices, p, _wanted(x, y, level, known - 1), k)
            answers[unclear[u]] = odd ^ ((inside[k] >> np.uint64(known)) & _ONE != _NONE)
