"""What is the area of a triangle, is a point in it, and which of its points is closest to another?"""

from __future__ import annotations

from softbody.jit import jit
from softbody.vec import Vec, add, cross, dot, norm, scale, sub


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


@jit
def _along_edge(start: Vec, edge: Vec) -> tuple[float, float]:
    """Return how far along `edge` its point closest to the origin lies, 0 … 1, and its squared distance [m²].

    `start` is where the edge starts. An edge without length is its start.
    """
    square = dot(edge, edge)
    forward = -dot(start, edge)
    t = forward / square if square > 0.0 else 0.0
    t = t if t > 0.0 else 0.0
    t = t if t < 1.0 else 1.0
    foot = add(start, scale(t, edge))
    return t, dot(foot, foot)


@jit
def nearest_on_triangle(p: Vec, a: Vec, b: Vec, c: Vec) -> tuple[float, float, float, float, int]:
    """Return (d² [m²], u, v, w, feature): the squared distance of `p` and the weights of the closest point; see below.

    `feature` is 0, 1, 2 for a point of the edge ab, bc, ca and 3 for one of the face. The best of four candidates: the
    closest point of each edge, and the foot of the perpendicular if that falls inside. So a triangle without area is its
    edges, and one without length a point; nothing is ever closer than some point of the triangle. Of equals the first.

    Without a branch, so that eight triangles can be tried at once: both the exhaustive search and the tree call this,
    and get the same bits.
    """
    pa, pb, pc = sub(a, p), sub(b, p), sub(c, p)
    ab, bc, ca = sub(b, a), sub(c, b), sub(a, c)
    t, square = _along_edge(pa, ab)
    u, v, w, feature = 1.0 - t, t, 0.0, 0
    t, next_square = _along_edge(pb, bc)
    closer = next_square < square
    square = next_square if closer else square
    u, v, w = (0.0 if closer else u), (1.0 - t if closer else v), (t if closer else w)
    feature = 1 if closer else feature
    t, next_square = _along_edge(pc, ca)
    closer = next_square < square
    square = next_square if closer else square
    u, v, w = (t if closer else u), (0.0 if closer else v), (1.0 - t if closer else w)
    feature = 2 if closer else feature
    # The foot of the perpendicular: its weights are as the areas that it spans with the edges.
    n = cross(ca, ab)
    whole = dot(n, n)
    share_b = dot(cross(pc, pa), n) / whole
    share_c = dot(cross(pa, pb), n) / whole
    share_a = 1.0 - share_b - share_c
    foot = add(pa, sub(scale(share_b, ab), scale(share_c, ca)))
    next_square = dot(foot, foot)
    closer = (share_a > 0.0) & (share_b > 0.0) & (share_c > 0.0) & (next_square < square)  # not if NaN: no area
    square = next_square if closer else square
    u, v, w = (share_a if closer else u), (share_b if closer else v), (share_c if closer else w)
    feature = 3 if closer else feature
    return square, u, v, w, feature


@jit
def weighted_point(u: float, v: float, w: float, a: Vec, b: Vec, c: Vec) -> Vec:
    """Return the point [m] with barycentric weights u, v, w in a triangle: u a + v b + w c.

    Taken from the corner with the largest weight: so a corner is met exactly, and little is lost far from the origin.
    """
    if u >= v and u >= w:
        return add(a, add(scale(v, sub(b, a)), scale(w, sub(c, a))))
    if v >= w:
        return add(b, add(scale(u, sub(a, b)), scale(w, sub(c, b))))
    return add(c, add(scale(u, sub(a, c)), scale(v, sub(b, c))))


@jit
def closest_point_on_triangle(p: Vec, a: Vec, b: Vec, c: Vec) -> tuple[Vec, Vec]:
    """Return (point [m], weights): the point of the triangle (a, b, c) closest to `p`; paper §4.3, Ericson 2005, §5.1.5.

    The barycentric weights, of a, b and c, are ≥ 0 and sum to 1 (to rounding). The triangle may be without area, or
    without any extent: then the point is on its longest edge, or its corner.
    """
    _, u, v, w, _ = nearest_on_triangle(p, a, b, c)
    return weighted_point(u, v, w, a, b, c), (u, v, w)
