"""What tells in one pass over a closed mesh that it, or a part of it, does not meet itself.

Both answers rest on the same: seen from a point, or along a direction, all triangles face the viewer, and somewhere one
alone is seen. Then nowhere two are seen behind each other: a map that is a covering, of a sphere or a disc, and covers
one point once is one-to-one. "No" says nothing.
"""

from __future__ import annotations

import numpy as np

from softbody.compiler.jit import jit
from softbody.linalg.vec import Vec, accumulate, add, cross, dot, load, norm, scale, store, sub

LEAST = 1e-9  # sine from which the side that a point is on is sure: far beyond rounding


@jit
def is_star_shaped(vertices: np.ndarray, triangles: np.ndarray) -> bool:
    """Tell whether all of a closed mesh is seen from its vertices' mean: then it does not meet itself."""
    mean = (0.0, 0.0, 0.0)
    for i in range(vertices.shape[0]):
        mean = add(mean, load(vertices, i))
    mean = scale(1.0 / vertices.shape[0], mean)
    ahead = (0.0, 0.0, 0.0)
    for t in range(triangles.shape[0]):
        a, b, c = _seen_from(mean, vertices, triangles, t)
        if not dot(cross(a, b), c) > LEAST * norm(a) * norm(b) * norm(c):
            return False
        if t == 0:
            ahead = add(add(a, b), c)
        elif _is_within(ahead, a, b) and _is_within(ahead, b, c) and _is_within(ahead, c, a):
            return False
    return True


@jit
def _seen_from(eye: Vec, vertices: np.ndarray, triangles: np.ndarray, t: int) -> tuple[Vec, Vec, Vec]:
    """Return the ways [m] from a point to the corners of a triangle."""
    a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    return sub(load(vertices, a), eye), sub(load(vertices, b), eye), sub(load(vertices, c), eye)


@jit
def _is_within(way: Vec, a: Vec, b: Vec) -> bool:
    """Tell whether a way is on the left of the plane through two others, or close to it."""
    return dot(cross(a, b), way) >= -LEAST * norm(a) * norm(b) * norm(way)


@jit
def find_unfolded(vertices: np.ndarray, triangles: np.ndarray, memory: np.ndarray, unfolded: np.ndarray) -> None:
    """Tell in `unfolded` (n,) around which vertices of a closed mesh triangles meet in their common edges only.

    All of them are seen along the sum of their normals, and none behind another. `memory` is (2, n, 3).
    """
    normals, ahead = memory
    memory[:] = 0.0
    unfolded[:] = True
    for t in range(triangles.shape[0]):
        a = load(vertices, triangles[t, 0])
        normal = cross(sub(load(vertices, triangles[t, 1]), a), sub(load(vertices, triangles[t, 2]), a))
        for k in range(3):
            accumulate(normals, triangles[t, k], normal)
    for t in range(triangles.shape[0]):
        for k in range(3):
            i = triangles[t, k]
            if not unfolded[i]:
                continue
            corner, normal = load(vertices, i), load(normals, i)
            a = sub(load(vertices, triangles[t, (k + 1) % 3]), corner)
            b = sub(load(vertices, triangles[t, (k + 2) % 3]), corner)
            way = load(ahead, i)
            if not dot(cross(a, b), normal) > LEAST * norm(a) * norm(b) * norm(normal):
                unfolded[i] = False
            elif way == (0.0, 0.0, 0.0):
                store(ahead, i, add(a, b))
            elif _is_between(way, a, b, normal):
                unfolded[i] = False


@jit
def _is_between(way: Vec, a: Vec, b: Vec, normal: Vec) -> bool:
    """Tell whether a way is between two others, or close to them, as seen along a normal."""
    least = -LEAST * norm(way) * norm(normal)
    return dot(cross(a, way), normal) >= least * norm(a) and dot(cross(way, b), normal) >= least * norm(b)
