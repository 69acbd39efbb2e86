"""What it takes to ask what is inside soft bodies: a tree for each skin, and memory for the answers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.geometry.penetration import Penetrations, room_for_penetrations
from softbody.geometry.triangle_tree import Search, TriangleTree, build_triangle_tree, search_space
from softbody.jit import jit
from softbody.state import Model


class Skins(NamedTuple):
    """What finds the contacts of soft bodies: the trees of all skins, one body's rows after another's, and scratch.

    What follows a skin as it moves (corners, boxes, frame) has room for the largest: one skin is asked at a time.
    """

    trees: TriangleTree
    start: np.ndarray  # (b + 1, fields of a TriangleTree) first row of each body in each of its arrays
    search: Search  # for the largest of them
    low: np.ndarray  # (b, 3) [m] corner of the bounding box of each body
    high: np.ndarray  # (b, 3) [m]
    mark: np.ndarray  # (most particles of a body or corners of a box,) see `mark_points`
    found: Penetrations  # as many
    edge: np.ndarray  # (most edges of a body + 1,) see `_edges_left`
    hint: np.ndarray  # (n,) see `find_closest`
    corners: np.ndarray  # (8, 3) [m] of the box that is asked
    corner_hint: np.ndarray  # (8,)
    crowd: np.ndarray  # (n,) see `part_contacts`
    deepest: np.ndarray  # (1,) [m] of all contacts since it was last set to 0
    deepest_pair: np.ndarray  # (2,) the bodies of that contact, boxes numbered after soft bodies


def build_skins(model: Model, position: np.ndarray) -> Skins:
    """Return the skins of all soft bodies of a model whose particles are at `position` (n, 3) [m]."""
    # Of the first mesh no row is kept: it tells what arrays look like where there are no bodies.
    meshes = [(np.eye(4, 3), np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))]
    for body in range(len(model.gas)):
        first, end = model.particle_start[body : body + 2]
        faces = slice(*model.triangle_start[body : body + 2])
        meshes.append((position[first:end], model.triangles[faces] - first))
    trees = [build_triangle_tree(*mesh) for mesh in meshes]
    joined = TriangleTree(*(np.concatenate([rows[0][:0], *rows[1:]]) for rows in zip(*trees, strict=True)))
    lengths = [[len(rows) for rows in tree] for tree in trees]
    lengths[0] = [0] * len(joined)
    largest = max(trees, key=lambda tree: len(tree.order))
    bodies, most = len(model.gas), int(np.diff(model.particle_start).max(initial=8))
    return Skins(
        joined._replace(corners=largest.corners, boxes=largest.boxes, frame=largest.frame),
        np.cumsum(lengths, axis=0),
        search_space(largest),
        np.zeros((bodies, 3)),
        np.zeros((bodies, 3)),
        np.zeros(most, np.uint8),
        room_for_penetrations(most),
        np.zeros(int(np.diff(model.edge_start).max(initial=0)) + 1, np.int64),
        np.full(len(position), -1),
        np.zeros((8, 3)),
        np.full(8, -1),
        np.zeros(len(position)),
        np.zeros(1),
        np.zeros(2, np.int64),
    )


@jit
def tree_of(skins: Skins, body: int) -> TriangleTree:
    """Return the tree of one body; fit it before it is asked, and before another one is fitted."""
    trees, first, end = skins.trees, skins.start[body], skins.start[body + 1]
    return TriangleTree(
        trees.triangles[first[0] : end[0]],
        trees.order[first[1] : end[1]],
        trees.corners[: end[2] - first[2]],
        trees.level_start[first[3] : end[3]],
        trees.level_count[first[4] : end[4]],
        trees.boxes,
        trees.frame,
    )
