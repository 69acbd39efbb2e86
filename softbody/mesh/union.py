"""Two closed surfaces become one: by a tube between two triangles, or where triangles of both lie on each other."""

from __future__ import annotations

import numpy as np

from softbody.errors import MeshError
from softbody.mesh.mesh import check_surface
from softbody.mesh.weld import first_at_place, first_within


def zipped(points: np.ndarray, triangles: np.ndarray, a: int, b: int) -> np.ndarray:
    """Return the triangles (t + 4, 3) where a tube of six, the last ones, joins triangles `a` and `b` of two surfaces.

    `points` (n, 3) [m], `triangles` (t, 3). Corners are paired so that the tube is shortest.
    """
    first, second = triangles[a], triangles[b][::-1]
    ahead, ways = np.roll(first, -1), [np.roll(second, k) for k in range(3)]
    lengths = [np.square(points[[first, first]] - points[[way, np.roll(way, -1)]]).sum() for way in ways]
    opposite = ways[int(np.argmin(lengths))]
    beyond = np.roll(opposite, -1)
    tube = np.concatenate([np.stack([first, ahead, beyond], axis=1), np.stack([first, beyond, opposite], axis=1)])
    return np.concatenate([np.delete(triangles, [a, b], axis=0), tube])


def glued(points: np.ndarray, triangles: np.ndarray, count: int, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return who each vertex becomes (n,), and the triangles of it, where those of two surfaces that match are gone.

    `points` (n, 3) [m], the first `count` of one surface, the others of the other. Two triangles match whose corners
    are at most `tolerance` [m] apart, each from its own. Raises MeshError if none do, or too many are that near.
    """
    group = first_within(points, first_at_place(points), tolerance)
    members = np.bincount(group, minlength=len(points))
    of_first = np.bincount(group[:count], minlength=len(points))
    pair = (members == 2) & (of_first == 1)
    corners = np.where(pair[group[triangles]], group[triangles], -1)
    is_first, whole = triangles[:, 0] < count, (corners >= 0).all(axis=1)
    found = {tuple(np.sort(corners[row])): row for row in np.flatnonzero(whole & is_first).tolist()}
    match = [(found.get(tuple(np.sort(corners[row]))), row) for row in np.flatnonzero(whole & ~is_first).tolist()]
    gone = np.array([both for both in match if both[0] is not None], np.int64).reshape(-1, 2)
    if not len(gone):
        crowded = int((members > 2).sum() + ((members == 2) & (of_first != 1)).sum())
        raise MeshError(
            f"within {tolerance:g} m there are {int(pair.sum())} pairs of particles of both"
            + (f", {crowded} crowds of more, or of one of them" if crowded else "")
            + ", and no two triangles that lie on each other; bring them nearer, or give another distance"
        )
    glue = np.zeros(len(points), bool)
    glue[triangles[gone.ravel()].ravel()] = True
    becomes = np.where(glue, group, np.arange(len(points)))
    rows = becomes[np.delete(triangles, gone.ravel(), axis=0)]
    used, renumbered = np.unique(rows, return_inverse=True)
    if not len(used):
        raise MeshError("all triangles lie on each other; nothing would be left")
    check_surface(renumbered.reshape(-1, 3), len(used))
    return becomes, rows
