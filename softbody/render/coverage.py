"""Samples of a grid that a flat triangle covers, with their barycentric weights."""

from __future__ import annotations

from softbody.compiler.jit import jit_lean


@jit_lean
def weights_at(a, b, c, x, y):
    """Return the barycentric weights of (x, y) in a triangle that has an area."""
    area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    u = ((b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x)) / area
    v = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / area
    return u, v, 1.0 - u - v


@jit_lean
def span(a, b, c, axis, count):
    """Return the range of the `count` rows or columns that a triangle may cover."""
    first, last = min(a[axis], b[axis], c[axis]), max(a[axis], b[axis], c[axis])
    # (What is just before the eye is as far off in the picture as any number.)
    return range(int(min(max(first, 0.0), count)), int(max(min(last, count - 1.0), -1.0)) + 1)


@jit_lean
def faces_up(a, b, c):
    """Tell whether a triangle on a plane runs counter-clockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) >= 0.0
