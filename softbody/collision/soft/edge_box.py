"""Intersection of a mesh's edge with a box: where, how deep, and along which direction they part.

The paper tests vertices only, so that a soft body sags over an edge of a box until a particle is inside (§6).
"""

from __future__ import annotations

from softbody.collision.edge_edge import PARALLEL_SINE
from softbody.compiler.jit import jit_lean
from softbody.linalg.quaternion import Quaternion, rotate, rotate_inverse
from softbody.linalg.vec import Vec, cross, dot, norm, scale, sub


@jit_lean
def edge_in_box(p: Vec, q: Vec, size: Vec, position: Vec, orientation: Quaternion) -> tuple[float, Vec, float]:
    """Return (depth [m], normal, place) of the segment from `p` to `q` [m] in a box; a depth ≤ 0: it is outside.

    The shortest way to part them is `depth` along the unit `normal`, from the box to the segment: normal to a face,
    or to the segment and a side of the box (separating axes, complete for a segment and a box). They touch at the
    segment's `place`, 0 at p … 1 at q. `size` is the full extent [m].
    """
    half = scale(0.5, size)
    a, b = rotate_inverse(orientation, sub(p, position)), rotate_inverse(orientation, sub(q, position))
    for axis in range(3):  # most edges are beyond a face, and need no division
        if min(a[axis], b[axis]) >= half[axis] or max(a[axis], b[axis]) <= -half[axis]:
            return 0.0, (0.0, 0.0, 0.0), 0.0
    along = sub(b, a)
    first, last = 0.0, 1.0  # the part of the segment that is inside
    for axis in range(3):
        if along[axis] != 0.0:
            one, other = (-half[axis] - a[axis]) / along[axis], (half[axis] - a[axis]) / along[axis]
            first, last = max(first, min(one, other)), min(last, max(one, other))
    if not first < last:
        return 0.0, (0.0, 0.0, 0.0), 0.0
    depth, place = half[0] + half[1] + half[2], 0.0
    normal = (0.0, 0.0, 0.0)
    for axis in range(3):
        up, down = half[axis] - min(a[axis], b[axis]), half[axis] + max(a[axis], b[axis])
        if min(up, down) < depth:
            depth = min(up, down)
            side = 1.0 if up < down else -1.0
            normal = (side if axis == 0 else 0.0, side if axis == 1 else 0.0, side if axis == 2 else 0.0)
            rise = side * along[axis]
            place = first if rise > 0.0 else last if rise < 0.0 else 0.5 * (first + last)
    for axis in range(3):
        direction = (1.0 if axis == 0 else 0.0, 1.0 if axis == 1 else 0.0, 1.0 if axis == 2 else 0.0)
        across = cross(along, direction)
        length = norm(across)
        if length <= PARALLEL_SINE * norm(along):
            continue
        height = dot(across, a) / length
        reach = (half[0] * abs(across[0]) + half[1] * abs(across[1]) + half[2] * abs(across[2])) / length
        if reach - abs(height) < depth:
            depth = reach - abs(height)
            normal = scale((1.0 if height > 0.0 else -1.0) / length, across)
            # The side of the box that is farthest along the normal, and the segment's point nearest to its line.
            corner = (
                half[0] if normal[0] > 0.0 else -half[0],
                half[1] if normal[1] > 0.0 else -half[1],
                half[2] if normal[2] > 0.0 else -half[2],
            )
            place = dot(cross(sub(corner, a), direction), across) / (length * length)
    return depth, rotate(orientation, normal), min(max(place, first), last)
