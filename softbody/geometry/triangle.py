"""What is the area of a triangle, and is a point in it?"""

from __future__ import annotations

from softbody.jit import jit
from softbody.vec import Vec, cross, dot, norm, scale, sub


@jit
def area_vector(a: Vec, b: Vec, c: Vec) -> Vec:
    """Return the vector of length area [m²] along the outward (counter-clockwise) normal; paper §2.2."""
    return scale(0.5, cross(sub(b, a), sub(c, a)))


@jit
def triangle_area(a: Vec, b: Vec, c: Vec) -> float:
    """Return the area [m²] of the triangle (a, b, c)."""
    return norm(area_vector(a, b, c))


@jit
def point_in_triangle(p: Vec, a: Vec, b: Vec, c: Vec) -> bool:
    """Tell whether `p`, projected along the normal, lies in the triangle (a, b, c) or on its border; paper §4.8.

    The three sub-triangles that `p` spans with the edges must all turn the way of the whole. The paper asks
    only that they turn the way of the first one, which is also met on the extension of that edge; and a
    triangle without area, which here contains nothing, would contain everything.
    """
    n = cross(sub(b, a), sub(c, a))
    if dot(n, n) == 0.0:
        return False
    pa = sub(a, p)
    pb = sub(b, p)
    pc = sub(c, p)
    return dot(cross(pb, pc), n) >= 0.0 and dot(cross(pc, pa), n) >= 0.0 and dot(cross(pa, pb), n) >= 0.0
