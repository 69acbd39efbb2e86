"""Do two boxes overlap, and along which axis least? The separating-axis test."""

from __future__ import annotations

import numpy as np

from softbody.jit import jit
from softbody.quaternion import Quaternion, load_quaternion, rotate
from softbody.vec import Vec, cross, dot, load, norm, scale, store, sub

# Edge pairs whose angle has a smaller sine give no axis of their own. Below √ε the direction of their cross
# product is rounding noise, while the face axes then miss the true gap by less than this part of the size.
PARALLEL_SINE = 1e-8

# An edge–edge axis replaces a face axis only if its overlap is smaller by this part of it: equal overlaps,
# decided by rounding, would make the contact jump between a face and an edge from step to step.
FACE_PREFERENCE = 1e-9


@jit
def _reach(size: Vec, x: Vec, y: Vec, z: Vec, axis: Vec) -> float:
    """Return half the length [m] of a box's shadow on `axis`; x, y, z are its unit axes in the world."""
    return 0.5 * (size[0] * abs(dot(x, axis)) + size[1] * abs(dot(y, axis)) + size[2] * abs(dot(z, axis)))


@jit
def box_box_separation(
    size_a: Vec,
    position_a: Vec,
    orientation_a: Quaternion,
    size_b: Vec,
    position_b: Vec,
    orientation_b: Quaternion,
    paper_axes: bool = False,
    any_gap: bool = False,
) -> tuple[float, Vec, int]:
    """Return (separation [m], normal, axis) of two boxes along the axis that parts them most; paper §4.5.

    Sizes are full extents [m]. A positive separation is a gap: the boxes are apart. Otherwise they overlap or
    touch, and −separation is the depth of the overlap along `normal`, the unit vector from b to a. `axis` is
    0 … 2 for a face of a, 3 … 5 for a face of b, 6 + 3 i + j for edge i of a across edge j of b.

    `paper_axes` tries the six face normals only: then boxes can seem to overlap that are apart (Gottschalk,
    Lin and Manocha 1996 show that all fifteen are needed). `any_gap` stops at the first axis that parts the boxes, for
    those who only ask whether they overlap. Boxes that touch, to the last bit, overlap by 0.
    """
    axes_a = (
        rotate(orientation_a, (1.0, 0.0, 0.0)),
        rotate(orientation_a, (0.0, 1.0, 0.0)),
        rotate(orientation_a, (0.0, 0.0, 1.0)),
    )
    axes_b = (
        rotate(orientation_b, (1.0, 0.0, 0.0)),
        rotate(orientation_b, (0.0, 1.0, 0.0)),
        rotate(orientation_b, (0.0, 0.0, 1.0)),
    )
    apart = sub(position_a, position_b)
    best = -np.inf
    best_axis = -1
    normal = (0.0, 0.0, 0.0)
    for k in range(6 if paper_axes else 15):
        if k < 3:
            direction = axes_a[k]
        elif k < 6:
            direction = axes_b[k - 3]
        else:
            direction = cross(axes_a[(k - 6) // 3], axes_b[(k - 6) % 3])
            length = norm(direction)
            if length < PARALLEL_SINE:
                continue
            direction = scale(1.0 / length, direction)
        distance = dot(apart, direction)
        reach_a = _reach(size_a, axes_a[0], axes_a[1], axes_a[2], direction)
        reach_b = _reach(size_b, axes_b[0], axes_b[1], axes_b[2], direction)
        separation = abs(distance) - reach_a - reach_b
        preference = FACE_PREFERENCE * abs(best) if k >= 6 else 0.0
        if separation > best + preference:
            best = separation
            best_axis = k
            normal = scale(1.0 if distance >= 0.0 else -1.0, direction)
            if any_gap and best > 0.0:
                break
    return best, normal, best_axis


@jit
def box_pairs_overlap(
    size_a: np.ndarray,
    position_a: np.ndarray,
    orientation_a: np.ndarray,
    size_b: np.ndarray,
    position_b: np.ndarray,
    orientation_b: np.ndarray,
    paper_axes: bool = False,
) -> np.ndarray:
    """Tell for each pair of boxes whether they overlap or touch: (m,) of bool; paper §4.5.

    Sizes and positions (m, 3) [m], orientations (m, 4) unit quaternions; row i of a against row i of b.
    """
    overlap = np.empty(size_a.shape[0], np.bool_)
    for i in range(size_a.shape[0]):
        separation, _, _ = box_box_separation(
            load(size_a, i),
            load(position_a, i),
            load_quaternion(orientation_a, i),
            load(size_b, i),
            load(position_b, i),
            load_quaternion(orientation_b, i),
            paper_axes,
            True,
        )
        overlap[i] = separation <= 0.0
    return overlap


@jit
def box_pairs_separation(
    size_a: np.ndarray,
    position_a: np.ndarray,
    orientation_a: np.ndarray,
    size_b: np.ndarray,
    position_b: np.ndarray,
    orientation_b: np.ndarray,
    paper_axes: bool = False,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return separations (m,) [m], normals (m, 3) and axes (m,) of pairs of boxes; see `box_box_separation`.

    Sizes and positions (m, 3) [m], orientations (m, 4) unit quaternions; row i of a against row i of b.
    """
    separations = np.empty(size_a.shape[0])
    normals = np.empty((size_a.shape[0], 3))
    axes = np.empty(size_a.shape[0], np.int64)
    for i in range(size_a.shape[0]):
        separations[i], normal, axes[i] = box_box_separation(
            load(size_a, i),
            load(position_a, i),
            load_quaternion(orientation_a, i),
            load(size_b, i),
            load(position_b, i),
            load_quaternion(orientation_b, i),
            paper_axes,
        )
        store(normals, i, normal)
    return separations, normals, axes
