"""Closest approach of two edges, and when they count as parallel; Ericson 2005, §5.1.8 and §5.1.9."""

from __future__ import annotations

from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.vec import Vec, add, cross, dot, scale, sub

# Sine of the angle between two edges, of boxes or meshes, below which they count as parallel: below √ε the direction of
# their cross product is rounding noise.
PARALLEL_SINE = 1e-8


@jit
def midpoint_of_lines(p: Vec, u: Vec, q: Vec, v: Vec) -> Vec:
    """Return the middle [m] of the shortest segment between the lines p + s u and q + t v, which are not parallel."""
    n = cross(u, v)
    apart = sub(q, p)
    s = dot(cross(apart, v), n) / dot(n, n)
    t = dot(cross(apart, u), n) / dot(n, n)
    return scale(0.5, add(add(p, scale(s, u)), add(q, scale(t, v))))


@jit_lean
def nearest_places(cosine: float, along_a: float, along_b: float, half_a: float, half_b: float) -> tuple[float, float]:
    """Return how far [m] from their middles two segments come nearest to each other.

    `cosine` of the angle between them; `along_a` and `along_b` [m]: the way from b's middle to a's, seen along either;
    `half_a` and `half_b` [m] are half their lengths.
    """
    s = (cosine * along_b - along_a) / (1.0 - cosine * cosine)
    s = min(max(s, -half_a), half_a)
    t = min(max(along_b + s * cosine, -half_b), half_b)
    s = min(max(t * cosine - along_a, -half_a), half_a)
    return s, t
