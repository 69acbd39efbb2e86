"""Box: its corners, the depth of a point in it, and its inertia."""

from __future__ import annotations

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.quaternion import Quaternion, rotate, rotate_inverse
from softbody.linalg.vec import Vec, add, multiply, scale, sub


@jit
def box_inertia(size: Vec, mass: float) -> Vec:
    """Return the diagonal [kg m²] of the inertia of a homogeneous box in its own frame; paper §3, §10.8.

    `size` is the full extent (x, y, z) [m]. The x entry holds y and z, and so on round: the paper lists them
    in two different orders.
    """
    x2 = size[0] * size[0]
    y2 = size[1] * size[1]
    z2 = size[2] * size[2]
    return scale(mass / 12.0, (y2 + z2, x2 + z2, x2 + y2))


@jit
def box_corner(size: Vec, position: Vec, orientation: Quaternion, k: int) -> Vec:
    """Return corner k = 0 … 7 [m] in the world: bit 0 of k chooses the side along x, bit 1 y, bit 2 z."""
    return add(position, rotate(orientation, scale(0.5, multiply(corner_signs(k), size))))


@jit_lean
def corner_signs(k: int) -> Vec:
    """Return on which side corner k = 0 … 7 is, −1 or 1 along each axis of its box."""
    return 1.0 if k & 1 else -1.0, 1.0 if k & 2 else -1.0, 1.0 if k & 4 else -1.0


@jit
def box_corners(size: Vec, position: Vec, orientation: Quaternion) -> np.ndarray:
    """Return the eight corners (8, 3) [m] in the world, in the order of `box_corner`."""
    corners = np.empty((8, 3))
    for k in range(8):
        corners[k, 0], corners[k, 1], corners[k, 2] = box_corner(size, position, orientation, k)
    return corners


@jit_lean
def way_back(before: Vec, now: Vec, half: Vec) -> tuple[float, Vec]:
    """Return (depth [m], normal): how far a point has come behind the face of a box through which it came in.

    `before` and `now` [m] are seen from the box, which may have moved, too; `half` is half of its extent [m]. It goes
    back by that face, however deep it is, right through, or out again by a side: the box would have stopped it. What
    was inside before goes back by the face that was closest then. A depth of 0: it has not been inside.
    """
    if is_in(before, half):
        axis, side = _closest_face(before, half)
    else:
        axis, side = _face_of_entry(before, now, half)
        if axis < 0 and is_in(now, half):  # to rounding it was on the face, or has grazed a side
            axis, side = _closest_face(now, half)
    if axis < 0 or half[axis] <= side * now[axis]:
        return 0.0, (0.0, 0.0, 0.0)
    normal = (side if axis == 0 else 0.0, side if axis == 1 else 0.0, side if axis == 2 else 0.0)
    return half[axis] - side * now[axis], normal


@jit_lean
def is_in(point: Vec, half: Vec) -> bool:
    """Tell whether a point is in a box of `half` the extent [m], whose frame it is seen from."""
    return abs(point[0]) < half[0] and abs(point[1]) < half[1] and abs(point[2]) < half[2]


@jit_lean
def _closest_face(point: Vec, half: Vec) -> tuple[int, float]:
    """Return the axis and the side, −1 or 1, of the face that is closest to a point in a box."""
    closest, axis = np.inf, 0
    for k in range(3):
        if half[k] - abs(point[k]) < closest:
            closest, axis = half[k] - abs(point[k]), k
    return axis, (1.0 if point[axis] >= 0.0 else -1.0)


@jit_lean
def _face_of_entry(before: Vec, now: Vec, half: Vec) -> tuple[int, float]:
    """Return the axis and side of the face by which a way leads into a box; the axis is −1 for one that does not."""
    enters, leaves, axis, side = -np.inf, np.inf, -1, 1.0
    for k in range(3):
        way = now[k] - before[k]
        if way == 0.0:
            if abs(before[k]) >= half[k]:
                return -1, 1.0
            continue
        from_side = -1.0 if way > 0.0 else 1.0
        first, last = (from_side * half[k] - before[k]) / way, (-from_side * half[k] - before[k]) / way
        if first > enters:
            enters, axis, side = first, k, from_side
        leaves = min(leaves, last)
    if not 0.0 <= enters < leaves or enters > 1.0:
        return -1, 1.0
    return axis, side


@jit_lean
def point_in_box(p: Vec, size: Vec, position: Vec, orientation: Quaternion) -> tuple[float, Vec]:
    """Return (depth [m], normal): how far `p` is behind the closest face, and that face's outward normal; paper §4.7.

    A negative depth: outside. `size` is the full extent [m].
    """
    local = rotate_inverse(orientation, sub(p, position))
    depth = np.inf
    normal = (0.0, 0.0, 0.0)
    for axis in range(3):
        behind = 0.5 * size[axis] - abs(local[axis])
        if behind < depth:
            depth = behind
            side = 1.0 if local[axis] >= 0.0 else -1.0
            normal = (side if axis == 0 else 0.0, side if axis == 1 else 0.0, side if axis == 2 else 0.0)
    return depth, rotate(orientation, normal)
