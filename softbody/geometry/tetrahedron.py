"""What is the volume of a tetrahedron, and is a point in it?"""

from __future__ import annotations

from softbody.jit import jit
from softbody.vec import Vec, cross, dot, sub


@jit
def tetrahedron_volume(a: Vec, b: Vec, c: Vec, d: Vec) -> float:
    """Return the signed volume [m³]: positive when (b, c, d) turns counter-clockwise seen from outside."""
    return dot(sub(b, a), cross(sub(c, a), sub(d, a))) / 6.0


@jit
def barycentric_in_tetrahedron(p: Vec, a: Vec, b: Vec, c: Vec, d: Vec) -> tuple[float, float, float, float]:
    """Return the weights (they sum to 1) that make `p` of a, b, c, d; NaN for a flat tetrahedron; paper §10.10."""
    whole = tetrahedron_volume(a, b, c, d)
    return (
        tetrahedron_volume(p, b, c, d) / whole,
        tetrahedron_volume(a, p, c, d) / whole,
        tetrahedron_volume(a, b, p, d) / whole,
        tetrahedron_volume(a, b, c, p) / whole,
    )


@jit
def point_in_tetrahedron(p: Vec, a: Vec, b: Vec, c: Vec, d: Vec) -> bool:
    """Tell whether `p` lies in the tetrahedron or on its border, whatever its orientation; paper §10.10.

    The five determinants must be of one *sign* (the paper prints "size"). A flat one contains nothing.
    """
    whole = tetrahedron_volume(a, b, c, d)
    sign = 1.0 if whole > 0.0 else -1.0
    return (
        whole != 0.0
        and sign * tetrahedron_volume(p, b, c, d) >= 0.0
        and sign * tetrahedron_volume(a, p, c, d) >= 0.0
        and sign * tetrahedron_volume(a, b, p, d) >= 0.0
        and sign * tetrahedron_volume(a, b, c, p) >= 0.0
    )
