"""The part of a closed surface that is below a level: its volume, and what pressure that grows with depth does to it.

A triangle is cut at the level exactly. What counts of the cut part are integrals of polynomials over it, in closed
form: a corner that is alone on its side of the level cuts a small triangle off, and the rest is the whole less that.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.vec import Vec, cross, load, norm, scale, sub


class Wet(NamedTuple):
    """Integrals over the part of a triangle below a level, by its whole area; φ_i is 1 at corner i and 0 at others."""

    load: Vec  # of depth · φ_i [m]
    share: Vec  # of φ_i
    square: float  # of depth² [m²]


@jit_lean
def wet_part(depth: Vec) -> Wet:
    """Return the integrals for a triangle whose corners are `depth` (3,) [m] below the level, or less than 0: above."""
    a, b, c = depth
    if not (a > 0.0 or b > 0.0 or c > 0.0):
        return Wet((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0)
    if a > 0.0 and b > 0.0 and c > 0.0:
        return _whole(depth)
    # Which corner is alone on its side?
    lone = 2 if (a > 0.0) == (b > 0.0) else 1 if (a > 0.0) == (c > 0.0) else 0
    at, next_, last = depth[lone], depth[(lone + 1) % 3], depth[(lone + 2) % 3]
    cut = _turned(_cut_off(at, next_, last), (3 - lone) % 3)
    if at > 0.0:
        return cut
    whole = _whole(depth)
    return Wet(sub(whole.load, cut.load), sub(whole.share, cut.share), whole.square - cut.square)


@jit_lean
def _whole(depth: Vec) -> Wet:
    """Return the integrals over a whole triangle."""
    a, b, c = depth
    total = a + b + c
    square = (a * a + b * b + c * c + a * b + b * c + c * a) / 6.0
    return Wet(scale(1.0 / 12.0, (total + a, total + b, total + c)), (1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0), square)


@jit_lean
def _cut_off(a: float, b: float, c: float) -> Wet:
    """Return the integrals over what the level cuts off at corner a, alone on its side of it."""
    t, u = a / (a - b), a / (a - c)  # how far along the edges to b and c
    part = t * u
    load = scale(part * a / 12.0, (4.0 - t - u, t, u))
    return Wet(load, scale(part / 3.0, (3.0 - t - u, t, u)), part * a * a / 6.0)


@jit_lean
def _turned(wet: Wet, by: int) -> Wet:
    """Return the integrals where corner i is what was corner i + by."""
    p, q, r = by, (by + 1) % 3, (by + 2) % 3
    return Wet((wet.load[p], wet.load[q], wet.load[r]), (wet.share[p], wet.share[q], wet.share[r]), wet.square)


@jit_lean
def double_area(a: Vec, b: Vec, c: Vec) -> Vec:
    """Return the normal of a triangle, as long as twice its area [m²]."""
    return cross(sub(b, a), sub(c, a))


class Submerged(NamedTuple):
    """What is below a level of a closed surface."""

    volume: float  # [m³]
    moment: Vec  # [m⁴] volume times its centre
    depth: float  # [m⁴] volume times its mean depth
    wet_area: float  # [m²] of the surface


@jit
def submerged_part(points: np.ndarray, triangles: np.ndarray, level: float) -> Submerged:
    """Return what is below z = `level` [m] of a closed surface, `points` (n, 3) [m] and `triangles` (t, 3).

    By Gauss's theorem: of the fields (0, 0, −depth), (0, 0, −x depth), (0, 0, −y depth) and (0, 0, −depth²/2).
    """
    volume, x, y, depth, area = 0.0, 0.0, 0.0, 0.0, 0.0
    for t in range(triangles.shape[0]):
        a, b, c = load(points, triangles[t, 0]), load(points, triangles[t, 1]), load(points, triangles[t, 2])
        wet, normal = wet_part((level - a[2], level - b[2], level - c[2])), double_area(a, b, c)
        down = -0.5 * normal[2]
        volume += down * (wet.load[0] + wet.load[1] + wet.load[2])
        x += down * (wet.load[0] * a[0] + wet.load[1] * b[0] + wet.load[2] * c[0])
        y += down * (wet.load[0] * a[1] + wet.load[1] * b[1] + wet.load[2] * c[1])
        depth += 0.5 * down * wet.square
        area += 0.5 * norm(normal) * (wet.share[0] + wet.share[1] + wet.share[2])
    return Submerged(volume, (x, y, level * volume - depth), depth, area)
