"""At which points do two boxes touch? Up to eight, by clipping a face of one against a face of the other.

Boxes that touch exactly are in contact, at depth 0; a box inside another one leaves through the face that is nearest.
Points lie half-way between the two surfaces. Whoever asks for a `margin` gets boxes as contacts too that are no farther
apart than that, with negative depths. With `slack`, boxes that move by less than that keep the points they had: an axis
replaces an earlier one (faces of a, faces of b, edges) only if it parts the boxes by `slack` more, and the reference
face is as much wider.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from softbody.collision.box_box import box_box_contact
from softbody.collision.sat import FACE_PREFERENCE, PARALLEL_SINE
from softbody.jit import jit, jit_lean
from softbody.quaternion import load_quaternion, rotate
from softbody.vec import load

MOST_POINTS = 8  # of two rectangles' intersection

# The rounding of a separation, as a part of the boxes' sizes. Boxes that lie parallel and barely overlap have faces and
# edges with the same axis: without this much preference, edges that do not even cross would win now and then.
ROUNDING = 4e-15


AFTER = (1, 2, 0, 1)  # the axes after axis i, round and round: AFTER[i] and AFTER[i + 1]


class Scratch(NamedTuple):
    """Working memory of one manifold, made once for many."""

    cosine: np.ndarray  # (3, 3) of the angles between the axes of a and of b
    apart: np.ndarray  # (2, 3) [m] from b to a, in the frame of a and of b
    polygon: np.ndarray  # (2, 64, 3) corners [m]: two along the reference face, one above it
    side: np.ndarray  # (2, 64) which line the edge after each corner lies on
    edge: np.ndarray  # (2, 3) middle of an edge of a and of one of b [m]
    normal: np.ndarray  # (3,) unit, from b to a
    point: np.ndarray  # (8, 3) [m]
    depth: np.ndarray  # (8,) [m]
    feature: np.ndarray  # (8,) what touches what: the same number, the same corner or crossing of edges


@jit
def new_scratch() -> Scratch:
    """Return working memory for `box_box_manifold`."""
    return Scratch(
        np.empty((3, 3)),
        np.empty((2, 3)),
        np.empty((2, 64, 3)),
        np.empty((2, 64), np.int64),
        np.empty((2, 3)),
        np.empty(3),
        np.empty((MOST_POINTS, 3)),
        np.empty(MOST_POINTS),
        np.empty(MOST_POINTS, np.int64),
    )


@jit
def box_axes(orientation: np.ndarray) -> np.ndarray:
    """Return the unit axes (m, 3, 3) in the world of boxes of `orientation` (m, 4): [i, k] is axis k of box i."""
    axes = np.empty((orientation.shape[0], 3, 3))
    for i in range(orientation.shape[0]):
        q = load_quaternion(orientation, i)
        axes[i, 0, 0], axes[i, 0, 1], axes[i, 0, 2] = rotate(q, (1.0, 0.0, 0.0))
        axes[i, 1, 0], axes[i, 1, 1], axes[i, 1, 2] = rotate(q, (0.0, 1.0, 0.0))
        axes[i, 2, 0], axes[i, 2, 1], axes[i, 2, 2] = rotate(q, (0.0, 0.0, 1.0))
    return axes


@jit_lean
def box_box_manifold(
    size: np.ndarray,
    position: np.ndarray,
    orientation: np.ndarray,
    axes: np.ndarray,
    a: int,
    b: int,
    margin: float,
    slack: float,
    paper_axes: bool,
    scratch: Scratch,
) -> int:
    """Find where boxes `a` and `b` touch; return the number of points, which `scratch` then holds; paper §4.5.

    `size` (m, 3) full extents [m], `position` (m, 3) [m], `orientation` (m, 4), `axes` (m, 3, 3) of `box_axes`,
    `margin` and `slack` [m] ≥ 0. `paper_axes` tries face normals only.
    """
    separation, axis = least_overlap(size, position, axes, a, b, margin, slack, paper_axes, scratch)
    if separation > margin:
        return 0
    if axis >= 6:
        _edge_point(size, position, axes, a, b, (axis - 6) // 3, (axis - 6) % 3, separation, scratch)
        return 1
    if axis < 3:
        count = _clip_faces(size, position, axes, a, b, axis, 1.0, margin, slack, scratch)
    else:
        count = _clip_faces(size, position, axes, b, a, axis - 3, -1.0, margin, slack, scratch)
    if count == 0:
        # The deepest corner lies beside the reference face, and what lies over it is not in contact.
        depth, point, _ = box_box_contact(
            load(size, a), load(position, a), load_quaternion(orientation, a),
            load(size, b), load(position, b), load_quaternion(orientation, b), paper_axes,
        )  # fmt: skip
        for c in range(3):
            scratch.point[0, c] = point[c]
        scratch.depth[0] = depth
        scratch.feature[0] = 1 << 20
        count = 1
    return count


@jit_lean
def least_overlap(
    size: np.ndarray,
    position: np.ndarray,
    axes: np.ndarray,
    a: int,
    b: int,
    margin: float,
    slack: float,
    paper_axes: bool,
    scratch: Scratch,
) -> tuple[float, int]:
    """Return (separation [m], axis) as `box_box_separation`, and leave the normal in `scratch`; arguments as above.

    A gap wider than `margin` is returned as soon as one axis shows it. The products are those of Gottschalk, Lin and
    Manocha (1996): every axis is seen from the frames of the two boxes, and edges that cannot win are not normalised.
    """
    cosine, apart, normal = scratch.cosine, scratch.apart, scratch.normal
    x = position[a, 0] - position[b, 0]
    y = position[a, 1] - position[b, 1]
    z = position[a, 2] - position[b, 2]
    best = -np.inf
    best_axis = -1
    for i in range(3):
        for j in range(3):
            cosine[i, j] = axes[a, i, 0] * axes[b, j, 0] + axes[a, i, 1] * axes[b, j, 1] + axes[a, i, 2] * axes[b, j, 2]
        t = x * axes[a, i, 0] + y * axes[a, i, 1] + z * axes[a, i, 2]
        apart[0, i] = t
        reach = size[a, i]
        for j in range(3):
            reach += size[b, j] * abs(cosine[i, j])
        separation = abs(t) - 0.5 * reach
        if separation > margin:
            return separation, i
        if separation > best:
            best, best_axis = separation, i
    rounding = ROUNDING * (size[a, 0] + size[a, 1] + size[a, 2] + size[b, 0] + size[b, 1] + size[b, 2])
    for j in range(3):
        t = x * axes[b, j, 0] + y * axes[b, j, 1] + z * axes[b, j, 2]
        apart[1, j] = t
        reach = size[b, j]
        for i in range(3):
            reach += size[a, i] * abs(cosine[i, j])
        separation = abs(t) - 0.5 * reach
        if separation > margin:
            return separation, 3 + j
        if separation > best + (slack + rounding if best_axis < 3 else 0.0):
            best, best_axis = separation, 3 + j
    sine = 0.0
    if not paper_axes:
        for i in range(3):
            i1, i2 = AFTER[i], AFTER[i + 1]
            for j in range(3):
                j1, j2 = AFTER[j], AFTER[j + 1]
                # On the axis a_i × b_j, times the sine of their angle.
                t = apart[0, i2] * cosine[i1, j] - apart[0, i1] * cosine[i2, j]
                shadow = abs(t) - 0.5 * (
                    size[a, i1] * abs(cosine[i2, j])
                    + size[a, i2] * abs(cosine[i1, j])
                    + size[b, j1] * abs(cosine[i, j2])
                    + size[b, j2] * abs(cosine[i, j1])
                )
                if shadow <= best:
                    continue  # with a sine of at most 1, an overlap only grows
                u = axes[a, i, 1] * axes[b, j, 2] - axes[a, i, 2] * axes[b, j, 1]
                v = axes[a, i, 2] * axes[b, j, 0] - axes[a, i, 0] * axes[b, j, 2]
                w = axes[a, i, 0] * axes[b, j, 1] - axes[a, i, 1] * axes[b, j, 0]
                length = sqrt(u * u + v * v + w * w)
                if length < PARALLEL_SINE:
                    continue
                separation = shadow / length
                if separation > margin:
                    return separation, 6 + 3 * i + j
                # What rounding does to a separation, the division by a small sine makes larger.
                preference = FACE_PREFERENCE * abs(best) + slack + rounding / length
                if separation > best + (preference if best_axis < 6 else 0.0):
                    best, best_axis = separation, 6 + 3 * i + j
                    sine = 1.0 / length if t >= 0.0 else -1.0 / length
                    normal[0], normal[1], normal[2] = sine * u, sine * v, sine * w
    if best_axis < 3:
        sign = 1.0 if apart[0, best_axis] >= 0.0 else -1.0
        for c in range(3):
            normal[c] = sign * axes[a, best_axis, c]
    elif best_axis < 6:
        sign = 1.0 if apart[1, best_axis - 3] >= 0.0 else -1.0
        for c in range(3):
            normal[c] = sign * axes[b, best_axis - 3, c]
    return best, best_axis


@jit_lean
def _clip_faces(
    size: np.ndarray,
    position: np.ndarray,
    axes: np.ndarray,
    r: int,
    s: int,
    axis: int,
    towards_r: float,
    margin: float,
    slack: float,
    scratch: Scratch,
) -> int:
    """Clip the face of box `s` that faces a face of box `r` along `axis` against its sides (Sutherland, Hodgman 1974).

    The normal in `scratch` points to r if `towards_r` is 1, from it if −1. Keeps the points no higher than `margin`.
    """
    normal, polygon, side = scratch.normal, scratch.polygon, scratch.side
    # Out of the reference face, towards s.
    n0, n1, n2 = -towards_r * normal[0], -towards_r * normal[1], -towards_r * normal[2]
    facing = 0
    least = 2.0
    sign = 1.0
    for k in range(3):
        cosine = n0 * axes[s, k, 0] + n1 * axes[s, k, 1] + n2 * axes[s, k, 2]
        if -abs(cosine) < least:
            least = -abs(cosine)
            facing = k
            sign = -1.0 if cosine > 0.0 else 1.0
    u, v = AFTER[axis], AFTER[axis + 1]
    f, g = AFTER[facing], AFTER[facing + 1]
    half_u, half_v, height = 0.5 * size[r, u], 0.5 * size[r, v], 0.5 * size[r, axis]
    # Middle and half edges of the facing face, seen from the reference box: along u, along v, above the face.
    m0 = position[s, 0] - position[r, 0] + 0.5 * sign * size[s, facing] * axes[s, facing, 0]
    m1 = position[s, 1] - position[r, 1] + 0.5 * sign * size[s, facing] * axes[s, facing, 1]
    m2 = position[s, 2] - position[r, 2] + 0.5 * sign * size[s, facing] * axes[s, facing, 2]
    mu = m0 * axes[r, u, 0] + m1 * axes[r, u, 1] + m2 * axes[r, u, 2]
    mv = m0 * axes[r, v, 0] + m1 * axes[r, v, 1] + m2 * axes[r, v, 2]
    mw = m0 * n0 + m1 * n1 + m2 * n2 - height
    hf, hg = 0.5 * size[s, f], 0.5 * size[s, g]
    fu = hf * (axes[s, f, 0] * axes[r, u, 0] + axes[s, f, 1] * axes[r, u, 1] + axes[s, f, 2] * axes[r, u, 2])
    fv = hf * (axes[s, f, 0] * axes[r, v, 0] + axes[s, f, 1] * axes[r, v, 1] + axes[s, f, 2] * axes[r, v, 2])
    fw = hf * (axes[s, f, 0] * n0 + axes[s, f, 1] * n1 + axes[s, f, 2] * n2)
    gu = hg * (axes[s, g, 0] * axes[r, u, 0] + axes[s, g, 1] * axes[r, u, 1] + axes[s, g, 2] * axes[r, u, 2])
    gv = hg * (axes[s, g, 0] * axes[r, v, 0] + axes[s, g, 1] * axes[r, v, 1] + axes[s, g, 2] * axes[r, v, 2])
    gw = hg * (axes[s, g, 0] * n0 + axes[s, g, 1] * n1 + axes[s, g, 2] * n2)
    for k in range(4):
        p = 1.0 if k == 0 or k == 3 else -1.0
        q = 1.0 if k < 2 else -1.0
        polygon[0, k, 0] = mu + p * fu + q * gu
        polygon[0, k, 1] = mv + p * fv + q * gv
        polygon[0, k, 2] = mw + p * fw + q * gw
        side[0, k] = k
    count, at = 4, 0
    for plane in range(4):
        c = plane // 2
        # Corners that lie on each other would else be now in and now out, by rounding.
        half = (half_u if c == 0 else half_v) + slack
        outwards = 1.0 if plane % 2 == 0 else -1.0
        outside = False
        for k in range(count):
            outside = outside or outwards * polygon[at, k, c] > half
        if not outside:
            continue
        to = 1 - at
        kept = 0
        for k in range(count):
            after = k + 1 if k + 1 < count else 0
            here = outwards * polygon[at, k, c] - half
            there = outwards * polygon[at, after, c] - half
            if here <= 0.0:
                for d in range(3):
                    polygon[to, kept, d] = polygon[at, k, d]
                side[to, kept] = side[at, k]
                kept += 1
            if (here <= 0.0) != (there <= 0.0):
                t = here / (here - there)
                for d in range(3):
                    polygon[to, kept, d] = polygon[at, k, d] + t * (polygon[at, after, d] - polygon[at, k, d])
                side[to, kept] = 4 + plane if here <= 0.0 else side[at, k]
                kept += 1
        count, at = kept, to

    kept = 0
    face = (axis * 2 + (1 if towards_r > 0.0 else 0)) * 6 + facing * 2 + (1 if sign > 0.0 else 0)
    for k in range(count):
        above = polygon[at, k, 2]
        if above <= margin and kept < MOST_POINTS:
            before = k - 1 if k > 0 else count - 1
            pu, pv, pw = polygon[at, k, 0], polygon[at, k, 1], 0.5 * above + height
            for c in range(3):
                n = n0 if c == 0 else (n1 if c == 1 else n2)
                scratch.point[kept, c] = position[r, c] + pu * axes[r, u, c] + pv * axes[r, v, c] + pw * n
            scratch.depth[kept] = -above
            scratch.feature[kept] = (face * 8 + side[at, before]) * 8 + side[at, k]
            kept += 1
    return kept


@jit_lean
def _edge_point(
    size: np.ndarray,
    position: np.ndarray,
    axes: np.ndarray,
    a: int,
    b: int,
    i: int,
    j: int,
    separation: float,
    scratch: Scratch,
) -> None:
    """Put into `scratch` the middle of the shortest way between edge `i` of a and edge `j` of b (Ericson 2005, §5.1.9).

    Of the four edges along that axis of each box, the ones that lie farthest towards the other box.
    """
    normal = scratch.normal
    feature = 0
    edge = scratch.edge
    for c in range(3):
        edge[0, c] = position[a, c]
        edge[1, c] = position[b, c]
    for k in range(3):
        if k != i:
            towards = normal[0] * axes[a, k, 0] + normal[1] * axes[a, k, 1] + normal[2] * axes[a, k, 2]
            sign = -0.5 if towards >= 0.0 else 0.5
            feature = 2 * feature + (towards >= 0.0)
            for c in range(3):
                edge[0, c] += sign * size[a, k] * axes[a, k, c]
        if k != j:
            towards = normal[0] * axes[b, k, 0] + normal[1] * axes[b, k, 1] + normal[2] * axes[b, k, 2]
            sign = 0.5 if towards >= 0.0 else -0.5
            feature = 2 * feature + (towards >= 0.0)
            for c in range(3):
                edge[1, c] += sign * size[b, k] * axes[b, k, c]
    cosine = scratch.cosine[i, j]
    x, y, z = edge[0, 0] - edge[1, 0], edge[0, 1] - edge[1, 1], edge[0, 2] - edge[1, 2]
    along_a = x * axes[a, i, 0] + y * axes[a, i, 1] + z * axes[a, i, 2]
    along_b = x * axes[b, j, 0] + y * axes[b, j, 1] + z * axes[b, j, 2]
    half_a, half_b = 0.5 * size[a, i], 0.5 * size[b, j]
    s = (cosine * along_b - along_a) / (1.0 - cosine * cosine)
    s = min(max(s, -half_a), half_a)
    t = min(max(along_b + s * cosine, -half_b), half_b)
    s = min(max(t * cosine - along_a, -half_a), half_a)
    for c in range(3):
        scratch.point[0, c] = 0.5 * (edge[0, c] + s * axes[a, i, c] + edge[1, c] + t * axes[b, j, c])
    scratch.depth[0] = -separation
    scratch.feature[0] = (1 << 16) + (feature * 3 + i) * 3 + j


@jit
def box_pairs_manifolds(
    size_a: np.ndarray,
    position_a: np.ndarray,
    orientation_a: np.ndarray,
    size_b: np.ndarray,
    position_b: np.ndarray,
    orientation_b: np.ndarray,
    margin: float = 0.0,
    paper_axes: bool = False,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return where the boxes of each of m pairs touch: count (m,), normal (m, 3), point (m, 8, 3), depth (m, 8) [m].

    Sizes and positions (m, 3) [m], orientations (m, 4) unit quaternions; row i of a against row i of b. Rows of points
    from `count` on mean nothing, nor does the normal where `count` is 0; normals point from b to a.
    """
    pairs = size_a.shape[0]
    size = np.concatenate((size_a, size_b))
    position = np.concatenate((position_a, position_b))
    orientation = np.concatenate((orientation_a, orientation_b))
    axes = box_axes(orientation)
    count = np.empty(pairs, np.int64)
    normal = np.zeros((pairs, 3))
    point = np.zeros((pairs, MOST_POINTS, 3))
    depth = np.zeros((pairs, MOST_POINTS))
    scratch = new_scratch()
    for i in range(pairs):
        found = box_box_manifold(size, position, orientation, axes, i, pairs + i, margin, 0.0, paper_axes, scratch)
        count[i] = found
        for c in range(3 if found else 0):
            normal[i, c] = scratch.normal[c]
        for k in range(found):
            depth[i, k] = scratch.depth[k]
            for c in range(3):
                point[i, k, c] = scratch.point[k, c]
    return count, normal, point, depth
