"""Where do two boxes touch?"""

from __future__ import annotations

import numpy as np

from softbody.collision.sat import box_box_separation
from softbody.geometry.box import box_corner
from softbody.jit import jit
from softbody.quaternion import Quaternion, rotate, rotate_inverse
from softbody.vec import Vec, add, cross, dot, multiply, scale, sub

# Corners that lie less deep than the deepest one by up to this part of the box's size count as equally deep:
# rounding separates the corners of a face that rests flat.
FLAT = 1e-9


@jit
def box_box_contact(
    size_a: Vec,
    position_a: Vec,
    orientation_a: Quaternion,
    size_b: Vec,
    position_b: Vec,
    orientation_b: Quaternion,
    paper_axes: bool = False,
) -> tuple[float, Vec, Vec]:
    """Return (depth [m], point [m], normal) of the contact of two boxes; paper §4.4, §4.5.

    A negative depth is a gap: there is no contact. `normal` is the unit vector from b to a; moving a by depth
    along it parts the boxes. `point` is half-way between the surfaces: at the deepest corner (the mean of the
    deepest ones where a face or an edge lies flat) or between the two edges that cross.
    """
    separation, normal, axis = box_box_separation(
        size_a, position_a, orientation_a, size_b, position_b, orientation_b, paper_axes
    )
    depth = -separation
    if axis < 3:
        point = _deepest_point(size_b, position_b, orientation_b, normal, size_a, position_a, orientation_a)
        return depth, sub(point, scale(0.5 * depth, normal)), normal
    if axis < 6:
        back = scale(-1.0, normal)
        point = _deepest_point(size_a, position_a, orientation_a, back, size_b, position_b, orientation_b)
        return depth, add(point, scale(0.5 * depth, normal)), normal
    edge_a, along_a = _foremost_edge(size_a, position_a, orientation_a, scale(-1.0, normal), (axis - 6) // 3)
    edge_b, along_b = _foremost_edge(size_b, position_b, orientation_b, normal, (axis - 6) % 3)
    return depth, _between_lines(edge_a, along_a, edge_b, along_b), normal


@jit
def _deepest_point(
    size: Vec,
    position: Vec,
    orientation: Quaternion,
    direction: Vec,
    face_size: Vec,
    face_position: Vec,
    face_orientation: Quaternion,
) -> Vec:
    """Return the mean of the corners that lie farthest along `direction`, each moved over the other box's face.

    The corners of a wide box lie outside the face of a narrow one that rests on it: without the move the point
    would be the middle of the wide face, and the narrow box would be struck where it is not. For faces that lie
    twisted on each other the mean is near their common part only, not always within it.
    """
    farthest = -np.inf
    for k in range(8):
        farthest = max(farthest, dot(sub(box_corner(size, position, orientation, k), position), direction))
    total = (0.0, 0.0, 0.0)
    count = 0
    for k in range(8):
        arm = sub(box_corner(size, position, orientation, k), position)
        if dot(arm, direction) >= farthest - FLAT * (size[0] + size[1] + size[2]):
            local = rotate_inverse(face_orientation, sub(add(position, arm), face_position))
            over = rotate(face_orientation, sub(_nearest_in_box(face_size, local), local))
            aside = sub(over, scale(dot(over, direction), direction))
            total = add(total, add(arm, aside))
            count += 1
    return add(position, scale(1.0 / count, total))


@jit
def _nearest_in_box(size: Vec, local: Vec) -> Vec:
    """Return the point of a box nearest to `local`, both in the box's own frame."""
    return (
        min(max(local[0], -0.5 * size[0]), 0.5 * size[0]),
        min(max(local[1], -0.5 * size[1]), 0.5 * size[1]),
        min(max(local[2], -0.5 * size[2]), 0.5 * size[2]),
    )


@jit
def _foremost_edge(size: Vec, position: Vec, orientation: Quaternion, direction: Vec, axis: int) -> tuple[Vec, Vec]:
    """Return the middle and the unit direction of the edge along `axis` that lies farthest along `direction`."""
    local = rotate_inverse(orientation, direction)
    signs = (
        0.0 if axis == 0 else (0.5 if local[0] >= 0.0 else -0.5),
        0.0 if axis == 1 else (0.5 if local[1] >= 0.0 else -0.5),
        0.0 if axis == 2 else (0.5 if local[2] >= 0.0 else -0.5),
    )
    along = (1.0 if axis == 0 else 0.0, 1.0 if axis == 1 else 0.0, 1.0 if axis == 2 else 0.0)
    return add(position, rotate(orientation, multiply(signs, size))), rotate(orientation, along)


@jit
def _between_lines(p: Vec, u: Vec, q: Vec, v: Vec) -> Vec:
    """Return the middle of the shortest segment between the lines p + s u and q + t v (Ericson 2005, §5.1.8)."""
    n = cross(u, v)
    apart = sub(q, p)
    s = dot(cross(apart, v), n) / dot(n, n)
    t = dot(cross(apart, u), n) / dot(n, n)
    return scale(0.5, add(add(p, scale(s, u)), add(q, scale(t, v))))
