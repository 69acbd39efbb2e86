"""Separating-axis test of two boxes: whether they overlap, and along which axis least, in two forms.

`box_box_separation` takes two boxes as they are, and every axis as its formula says: it serves the paper's single
contact. `least_overlap` is what a World runs for all other pairs: the same axes, seen from the frames of the two boxes,
with preferences that let boxes that move by less than a slop keep the points they had. `box_pairs_overlap` and
`box_pairs_separation` are for geometry users.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from softbody.collision.edge_edge import PARALLEL_SINE
from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.quaternion import Quaternion, load_quaternion, rotate
from softbody.linalg.vec import Vec, cross, dot, load, norm, scale, store, sub
from softbody.model.arrays import Model, State

# An edge–edge axis replaces a face axis only if its overlap is smaller by this part of it: equal overlaps,
# decided by rounding, would make the contact jump between a face and an edge from step to step.
FACE_PREFERENCE = 1e-9

# The rounding of a separation, as a part of the boxes' sizes. Boxes that lie parallel and barely overlap have faces and
# edges with the same axis: without this much preference, edges that do not even cross would win now and then.
ROUNDING = 4e-15

AFTER = (1, 2, 0, 1)  # the axes after axis i, round and round: AFTER[i] and AFTER[i + 1]

# Cosine of 1e-3 rad: so much a face may be tilted that lies, or comes down, flat on another.
SAME_COSINE = 1.0 - 5e-7


class PlacedBox(NamedTuple):
    """A box where it is."""

    size: Vec  # full extent [m]
    position: Vec  # centre [m]
    orientation: Quaternion


class PlacedBoxes(NamedTuple):
    """Many boxes where they are, a row each."""

    size: np.ndarray  # (m, 3) full extent [m]
    position: np.ndarray  # (m, 3) centre [m]
    orientation: np.ndarray  # (m, 4) unit quaternion (w, x, y, z), box frame to world


@jit_lean
def placed_at(model: Model, state: State, box: int) -> PlacedBox:
    """Return a box where it is in a state."""
    orientation = load_quaternion(state.box_orientation, box)
    return PlacedBox(load(model.box_size, box), load(state.box_position, box), orientation)


@jit
def placed_box(boxes: PlacedBoxes, i: int) -> PlacedBox:
    """Return box `i`."""
    return PlacedBox(load(boxes.size, i), load(boxes.position, i), load_quaternion(boxes.orientation, i))


@jit
def _half_extent(size: Vec, axes: tuple[Vec, Vec, Vec], direction: Vec) -> float:
    """Return half the length [m] of a box's projection on a unit `direction`; `axes` are its own in the world."""
    return 0.5 * (
        size[0] * abs(dot(axes[0], direction))
        + size[1] * abs(dot(axes[1], direction))
        + size[2] * abs(dot(axes[2], direction))
    )


@jit
def _axes(orientation: Quaternion) -> tuple[Vec, Vec, Vec]:
    return (
        rotate(orientation, (1.0, 0.0, 0.0)),
        rotate(orientation, (0.0, 1.0, 0.0)),
        rotate(orientation, (0.0, 0.0, 1.0)),
    )


@jit
def box_box_separation(
    a: PlacedBox, b: PlacedBox, paper_axes: bool = False, any_gap: bool = False
) -> tuple[float, Vec, int]:
    """Return (separation [m], normal, axis) of two boxes along the axis that parts them most; paper §4.5.

    A positive separation is a gap: the boxes are apart. Otherwise they overlap or touch, and −separation is the depth
    of the overlap along `normal`, the unit vector from b to a. `axis` is 0 … 2 for a face of a, 3 … 5 for a face of b,
    6 + 3 i + j for edge i of a across edge j of b.

    `paper_axes` tries the six face normals only: then boxes can seem to overlap that are apart (Gottschalk,
    Lin and Manocha 1996 show that all fifteen are needed). `any_gap` stops at the first axis that parts the boxes, for
    those who only ask whether they overlap. Boxes that touch, to the last bit, overlap by 0.
    """
    axes_a, axes_b = _axes(a.orientation), _axes(b.orientation)
    apart = sub(a.position, b.position)
    best = -np.inf
    best_axis = -1
    normal = (0.0, 0.0, 0.0)
    for k in range(6 if paper_axes else 15):
        # The axis: a face normal of a, one of b, or an edge of a across an edge of b.
        if k < 3:
            direction = axes_a[k]
        elif k < 6:
            direction = axes_b[k - 3]
        else:
            direction = cross(axes_a[(k - 6) // 3], axes_b[(k - 6) % 3])
            length = norm(direction)
            if length < PARALLEL_SINE:
                continue  # face axes then miss the true gap by less than this part of the size
            direction = scale(1.0 / length, direction)
        # The gap between the two projections on it.
        distance = dot(apart, direction)
        separation = abs(distance) - _half_extent(a.size, axes_a, direction) - _half_extent(b.size, axes_b, direction)
        preference = FACE_PREFERENCE * abs(best) if k >= 6 else 0.0
        if separation > best + preference:
            best = separation
            best_axis = k
            normal = scale(1.0 if distance >= 0.0 else -1.0, direction)
            if any_gap and best > 0.0:
                break
    return best, normal, best_axis


class BoxFrames(NamedTuple):
    """All boxes of a world, with the axes that are made once for many pairs."""

    size: np.ndarray  # (m, 3) full extent [m]
    position: np.ndarray  # (m, 3) centre [m]
    orientation: np.ndarray  # (m, 4)
    axes: np.ndarray  # (m, 3, 3) unit, in the world: [i, k] is axis k of box i
    half_extent: np.ndarray  # (m, 3) [m] half the lengths of the projections on the world's axes


class Limits(NamedTuple):
    """What counts as a contact of two boxes."""

    margin: float  # [m] that they may be apart
    slop: float  # [m] by which they may move and keep the points they had
    paper_axes: bool  # try face normals only


class SatMemory(NamedTuple):
    """Working memory of `least_overlap`, made once for many pairs."""

    cosine: np.ndarray  # (3, 3) of the angles between the axes of a and of b
    apart: np.ndarray  # (2, 3) [m] from b to a, in the frame of a and of b
    travel: np.ndarray  # (2, 3) [m] of a in a step, seen from b, in the frame of a and of b
    normal: np.ndarray  # (3,) the answer: unit, from b to a


@jit
def frames_of(boxes: PlacedBoxes) -> BoxFrames:
    """Return boxes with their axes."""
    axes = np.empty((boxes.size.shape[0], 3, 3))
    half_extent = np.zeros((boxes.size.shape[0], 3))
    for i in range(axes.shape[0]):
        x, y, z = _axes(load_quaternion(boxes.orientation, i))
        axes[i, 0, 0], axes[i, 0, 1], axes[i, 0, 2] = x
        axes[i, 1, 0], axes[i, 1, 1], axes[i, 1, 2] = y
        axes[i, 2, 0], axes[i, 2, 1], axes[i, 2, 2] = z
        for k in range(3):
            for c in range(3):
                half_extent[i, c] += 0.5 * boxes.size[i, k] * abs(axes[i, k, c])
    return BoxFrames(boxes.size, boxes.position, boxes.orientation, axes, half_extent)


@jit_lean
def bounds_apart(boxes: BoxFrames, a: int, b: int, margin: float) -> bool:
    """Tell whether two boxes are more than `margin` [m] apart along one of the world's axes: three quick tests."""
    position, extent = boxes.position, boxes.half_extent
    for c in range(3):  # noqa: SIM110 (Numba has no any() of a generator)
        if abs(position[a, c] - position[b, c]) > extent[a, c] + extent[b, c] + margin:
            return True
    return False


@jit_lean
def least_overlap(boxes: BoxFrames, a: int, b: int, limits: Limits, memory: SatMemory) -> tuple[float, int]:
    """Return (separation [m], axis) as `box_box_separation`, and leave the normal in `memory`.

    A gap wider than the margin is returned as soon as one axis shows it. The products are those of Gottschalk, Lin and
    Manocha (1996): every axis is seen from the frames of the two boxes, and edges that cannot win are not normalised.
    An axis replaces an earlier one (faces of a, faces of b, edges) only if it parts the boxes by the slop more.
    """
    best, best_axis = _best_face(boxes, a, b, limits, memory)
    if best <= limits.margin and not limits.paper_axes:
        best, best_axis = _best_edge_pair(boxes, (a, b), limits, (best, best_axis), memory)
    if best_axis < 6 and best <= limits.margin:
        box, axis, frame = (a, best_axis, 0) if best_axis < 3 else (b, best_axis - 3, 1)
        sign = 1.0 if memory.apart[frame, axis] >= 0.0 else -1.0
        for c in range(3):
            memory.normal[c] = sign * boxes.axes[box, axis, c]
    return best, best_axis


@jit_lean
def _best_face(boxes: BoxFrames, a: int, b: int, limits: Limits, memory: SatMemory) -> tuple[float, int]:
    """Return (separation [m], axis) of the best of six faces, or of the first that shows a gap beyond the margin."""
    cosine, apart = memory.cosine, memory.apart
    size, axes = boxes.size, boxes.axes
    x = boxes.position[a, 0] - boxes.position[b, 0]
    y = boxes.position[a, 1] - boxes.position[b, 1]
    z = boxes.position[a, 2] - boxes.position[b, 2]
    best = -np.inf
    best_axis = -1
    # Faces of a.
    for i in range(3):
        for j in range(3):
            cosine[i, j] = axes[a, i, 0] * axes[b, j, 0] + axes[a, i, 1] * axes[b, j, 1] + axes[a, i, 2] * axes[b, j, 2]
        t = x * axes[a, i, 0] + y * axes[a, i, 1] + z * axes[a, i, 2]
        apart[0, i] = t
        reach = size[a, i]
        for j in range(3):
            reach += size[b, j] * abs(cosine[i, j])
        separation = abs(t) - 0.5 * reach
        if separation > limits.margin:
            return separation, i
        if separation > best:
            best, best_axis = separation, i
    # Faces of b.
    for j in range(3):
        t = x * axes[b, j, 0] + y * axes[b, j, 1] + z * axes[b, j, 2]
        apart[1, j] = t
        reach = size[b, j]
        for i in range(3):
            reach += size[a, i] * abs(cosine[i, j])
        separation = abs(t) - 0.5 * reach
        if separation > limits.margin:
            return separation, 3 + j
        if separation > best + (limits.slop + rounding_of(size, a, b) if best_axis < 3 else 0.0):
            best, best_axis = separation, 3 + j
    return best, best_axis


@jit_lean
def rounding_of(size: np.ndarray, a: int, b: int) -> float:
    """Return what rounding can do to the separation [m] of two boxes."""
    return ROUNDING * (size[a, 0] + size[a, 1] + size[a, 2] + size[b, 0] + size[b, 1] + size[b, 2])


@jit_lean
def _best_edge_pair(
    boxes: BoxFrames, pair: tuple[int, int], limits: Limits, face: tuple[float, int], memory: SatMemory
) -> tuple[float, int]:
    """Return (separation [m], axis) of the best of nine pairs of edges, if one is better than the best `face`.

    Else those of the face. The normal of a pair of edges is left in `memory`, which must know the boxes' faces.
    """
    cosine, apart, normal = memory.cosine, memory.apart, memory.normal
    size, axes = boxes.size, boxes.axes
    a, b = pair
    best, best_axis = face
    rounding = rounding_of(size, a, b)
    for i in range(3):
        i1, i2 = AFTER[i], AFTER[i + 1]
        for j in range(3):
            j1, j2 = AFTER[j], AFTER[j + 1]
            # The separation on the axis a_i × b_j, times the sine of their angle.
            t = apart[0, i2] * cosine[i1, j] - apart[0, i1] * cosine[i2, j]
            gap = abs(t) - 0.5 * (
                size[a, i1] * abs(cosine[i2, j])
                + size[a, i2] * abs(cosine[i1, j])
                + size[b, j1] * abs(cosine[i, j2])
                + size[b, j2] * abs(cosine[i, j1])
            )
            if gap <= best:
                continue  # with a sine of at most 1, an overlap only grows
            u = axes[a, i, 1] * axes[b, j, 2] - axes[a, i, 2] * axes[b, j, 1]
            v = axes[a, i, 2] * axes[b, j, 0] - axes[a, i, 0] * axes[b, j, 2]
            w = axes[a, i, 0] * axes[b, j, 1] - axes[a, i, 1] * axes[b, j, 0]
            sine = sqrt(u * u + v * v + w * w)
            if sine < PARALLEL_SINE or (best_axis < 6 and axes_are_one(best_axis, 6 + 3 * i + j, sine, memory)):
                continue
            separation = gap / sine
            if separation > limits.margin:
                return separation, 6 + 3 * i + j
            # What rounding does to a separation, the division by a small sine makes larger.
            preference = FACE_PREFERENCE * abs(best) + limits.slop + rounding / sine
            if separation > best + (preference if best_axis < 6 else 0.0):
                best, best_axis = separation, 6 + 3 * i + j
                sign = 1.0 / sine if t >= 0.0 else -1.0 / sine
                normal[0], normal[1], normal[2] = sign * u, sign * v, sign * w
    return best, best_axis


@jit_lean
def axes_are_one(face: int, edges: int, sine: float, memory: SatMemory) -> bool:
    """Tell whether the axis of two edges is all but the normal of a face: then the points of the faces are what meets.

    Edges of faces that lie or come flat on each other, but for rounding, would part the boxes by a rounding more, or
    come a rounding later, and hold them at one point.
    """
    i, j = (edges - 6) // 3, (edges - 6) % 3
    if face < 3:
        along = memory.cosine[3 - i - face, j] if face != i else 0.0
    else:
        along = memory.cosine[i, 6 - j - face] if face - 3 != j else 0.0
    return abs(along) > SAME_COSINE * sine


@jit
def box_pairs_overlap(a: PlacedBoxes, b: PlacedBoxes, paper_axes: bool = False) -> np.ndarray:
    """Tell for each pair of boxes, row i of a and of b, whether they overlap or touch: (m,) of bool; paper §4.5."""
    overlap = np.empty(a.size.shape[0], np.bool_)
    for i in range(a.size.shape[0]):
        separation, _, _ = box_box_separation(placed_box(a, i), placed_box(b, i), paper_axes, True)
        overlap[i] = separation <= 0.0
    return overlap


@jit
def box_pairs_separation(
    a: PlacedBoxes, b: PlacedBoxes, paper_axes: bool = False
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return separations (m,) [m], normals (m, 3) and axes (m,) of pairs of boxes, row i of a and row i of b.

    See `box_box_separation`.
    """
    separations = np.empty(a.size.shape[0])
    normals = np.empty((a.size.shape[0], 3))
    axes = np.empty(a.size.shape[0], np.int64)
    for i in range(a.size.shape[0]):
        separations[i], normal, axes[i] = box_box_separation(placed_box(a, i), placed_box(b, i), paper_axes)
        store(normals, i, normal)
    return separations, normals, axes
