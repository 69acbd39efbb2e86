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
    signs = (
        0.5 if k & 1 else -0.5,
        0.5 if k & 2 else -0.5,
        0.5 if k & 4 else -0.5,
    )
    return add(position, rotate(orientation, multiply(signs, size)))


@jit
def box_corners(size: Vec, position: Vec, orientation: Quaternion) -> np.ndarray:
    """Return the eight corners (8, 3) [m] in the world, in the order of `box_corner`."""
    corners = np.empty((8, 3))
    for k in range(8):
        corners[k, 0], corners[k, 1], corners[k, 2] = box_corner(size, position, orientation, k)
    return corners


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
