"""Where two segments come nearest to each other."""

from __future__ import annotations

from softbody.compiler.jit import jit
from softbody.linalg.vec import Vec, add, dot, scale, sub

PARALLEL = 1e-12  # squared sine below which two segments count as parallel: some of all nearest pairs is taken


@jit
def closest_places_on_segments(p: Vec, q: Vec, r: Vec, s: Vec) -> tuple[float, float, float]:
    """Return (u, v, d² [m²]): the places, 0 … 1, on p–q and r–s that are nearest; Ericson 2005 §5.1.9.

    Both segments must have a length.
    """
    along, other, apart = sub(q, p), sub(s, r), sub(p, r)
    a, e, f = dot(along, along), dot(other, other), dot(other, apart)
    c, b = dot(along, apart), dot(along, other)
    rest = a * e - b * b
    u = min(max((b * f - c * e) / rest, 0.0), 1.0) if rest > PARALLEL * a * e else 0.0
    v = (b * u + f) / e
    if v < 0.0:
        u, v = min(max(-c / a, 0.0), 1.0), 0.0
    elif v > 1.0:
        u, v = min(max((b - c) / a, 0.0), 1.0), 1.0
    way = sub(add(p, scale(u, along)), add(r, scale(v, other)))
    return u, v, dot(way, way)
