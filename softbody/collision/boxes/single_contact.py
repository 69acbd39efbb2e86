"""Contact of two boxes at one point: on their surfaces or, as in the paper, between the two; §4.4."""

from __future__ import annotations

import numpy as np

from softbody.collision.boxes.sat_boxes import PlacedBox, box_box_separation
from softbody.collision.edge_edge import midpoint_of_lines
from softbody.compiler.jit import jit
from softbody.geometry.box import box_corner
from softbody.linalg.quaternion import rotate, rotate_inverse
from softbody.linalg.vec import Vec, add, dot, multiply, scale, sub

# Corners that lie less deep than the deepest one by up to this part of the box's size count as equally deep:
# rounding separates the corners of a face that rests flat.
FLAT = 1e-9


@jit
def paper_contact(a: PlacedBox, b: PlacedBox, paper_axes: bool = False) -> tuple[float, Vec, Vec]:
    """Return (depth [m], point [m], normal) of the paper's contact of two boxes; §4.4, E18.

    That of `box_box_contact` where a corner or edges touch. Where one box lies on the other with a face or an edge, it
    is half-way between the two centres, as the paper has it for stacks: a box that lies off-centre is turned by it.
    """
    depth, point, normal, touching = _contact(a, b, paper_axes)
    return depth, (point if touching == 1 else scale(0.5, add(a.position, b.position))), normal


@jit
def box_box_contact(a: PlacedBox, b: PlacedBox, paper_axes: bool = False) -> tuple[float, Vec, Vec]:
    """Return (depth [m], point [m], normal) of the contact of two boxes; paper §4.4, §4.5.

    A negative depth is a gap: there is no contact. `normal` is the unit vector from b to a; moving a by depth
    along it parts the boxes. `point` is half-way between the surfaces: at the deepest corner (the mean of the
    deepest ones where a face or an edge lies flat) or between the two edges that cross.
    """
    depth, point, normal, _ = _contact(a, b, paper_axes)
    return depth, point, normal


@jit
def _contact(a: PlacedBox, b: PlacedBox, paper_axes: bool) -> tuple[float, Vec, Vec, int]:
    """Return (depth [m], point [m] half-way between the surfaces, normal, how many corners or crossings touch)."""
    separation, normal, axis = box_box_separation(a, b, paper_axes)
    depth = -separation
    back = scale(-1.0, normal)
    if axis < 3:
        point, touching = _deepest_point(b, normal, a)
        return depth, sub(point, scale(0.5 * depth, normal)), normal, touching
    if axis < 6:
        point, touching = _deepest_point(a, back, b)
        return depth, add(point, scale(0.5 * depth, normal)), normal, touching
    edge_a, along_a = _foremost_edge(a, back, (axis - 6) // 3)
    edge_b, along_b = _foremost_edge(b, normal, (axis - 6) % 3)
    return depth, midpoint_of_lines(edge_a, along_a, edge_b, along_b), normal, 1


@jit
def _deepest_point(box: PlacedBox, direction: Vec, other: PlacedBox) -> tuple[Vec, int]:
    """Return (point [m], count): the mean of those corners that lie farthest along `direction`, and how many.

    Each is moved over the face of the other box.

    The corners of a wide box lie outside the face of a narrow one that rests on it: without the move the point
    would be the middle of the wide face, and the narrow box would be struck where it is not. For faces that lie
    twisted on each other the mean is near their common part only, not always within it.
    """
    size, position = box.size, box.position
    farthest = -np.inf
    for k in range(8):
        farthest = max(farthest, dot(sub(box_corner(size, position, box.orientation, k), position), direction))
    total = (0.0, 0.0, 0.0)
    count = 0
    for k in range(8):
        arm = sub(box_corner(size, position, box.orientation, k), position)
        if dot(arm, direction) >= farthest - FLAT * (size[0] + size[1] + size[2]):
            # From the corner to the nearest point of the other box, as far as that is across the direction.
            local = rotate_inverse(other.orientation, sub(add(position, arm), other.position))
            over = rotate(other.orientation, sub(_nearest_in_box(other.size, local), local))
            aside = sub(over, scale(dot(over, direction), direction))
            total = add(total, add(arm, aside))
            count += 1
    return add(position, scale(1.0 / count, total)), count


@jit
def _nearest_in_box(size: Vec, local: Vec) -> Vec:
    """Return the point of a box nearest to `local`, both in the box's own frame."""
    return (
        min(max(local[0], -0.5 * size[0]), 0.5 * size[0]),
        min(max(local[1], -0.5 * size[1]), 0.5 * size[1]),
        min(max(local[2], -0.5 * size[2]), 0.5 * size[2]),
    )


@jit
def _foremost_edge(box: PlacedBox, direction: Vec, axis: int) -> tuple[Vec, Vec]:
    """Return the middle and the unit direction of the edge along `axis` that lies farthest along `direction`."""
    local = rotate_inverse(box.orientation, direction)
    signs = (
        0.0 if axis == 0 else (0.5 if local[0] >= 0.0 else -0.5),
        0.0 if axis == 1 else (0.5 if local[1] >= 0.0 else -0.5),
        0.0 if axis == 2 else (0.5 if local[2] >= 0.0 else -0.5),
    )
    along = (1.0 if axis == 0 else 0.0, 1.0 if axis == 1 else 0.0, 1.0 if axis == 2 else 0.0)
    return add(box.position, rotate(box.orientation, multiply(signs, box.size))), rotate(box.orientation, along)
