"""Contact manifold of two boxes: up to eight points, by clipping a face of one against the other's.

Boxes that touch exactly are in contact, at depth 0; a box inside another one leaves through the face that is nearest.
Points lie half-way between the two surfaces. Whoever asks for a margin gets boxes as contacts too that are no farther
apart than that, with negative depths. With a slop, boxes that move by less than that keep the points they had: the
reference face is as much wider. Boxes that move without turning are clipped where they will meet, and boxes that turn
only if they come near within the step, so that those that pass each other are left alone.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from softbody.collision.boxes.sat_boxes import (
    AFTER,
    BoxFrames,
    Limits,
    PlacedBoxes,
    SatMemory,
    frames_of,
    least_overlap,
    placed_box,
    rounding_of,
)
from softbody.collision.boxes.single_contact import box_box_contact
from softbody.collision.boxes.swept_boxes import (
    NEAR,
    NEVER,
    NO_SWEEP,
    STILL,
    Meeting,
    Sweep,
    come_near,
    grazing_depth,
    meeting_of,
    rests_on_face,
    write_normal,
)
from softbody.collision.edge_edge import nearest_places
from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.vec import Vec, add, cross, dot, load, norm, scale, store, sub

MOST_POINTS = 8  # of two rectangles' intersection
ALL_BUT_FLAT = 0.999  # cosine of 2.5°, between the normal of two edges and that of a face


class Manifold(NamedTuple):
    """The points of one manifold, and working memory; made once for many."""

    sat: SatMemory  # with the normal: unit, from b to a
    polygon: np.ndarray  # (2, 64, 3) corners [m]: two along the reference face, one above it
    side: np.ndarray  # (2, 64) which line the edge after each corner lies on
    edge: np.ndarray  # (2, 3) middle of an edge of a and of one of b [m]
    point: np.ndarray  # (8, 3) [m]
    depth: np.ndarray  # (8,) [m]
    feature: np.ndarray  # (8,) what touches what: the same number, the same corner or crossing of edges


class Faces(NamedTuple):
    """Which face of a reference box is clipped against, and which box's face that faces it is clipped."""

    reference: int  # box
    incident: int  # box
    axis: int  # of the reference box, normal to the face
    towards_reference: float  # 1 if the manifold's normal points to the reference box, −1 if from it


def new_manifold() -> Manifold:
    """Return room for one manifold, and working memory."""
    return Manifold(
        SatMemory(np.empty((3, 3)), np.empty((2, 3)), np.empty((2, 3)), np.empty(3)),
        np.empty((2, 64, 3)),
        np.empty((2, 64), np.int64),
        np.empty((2, 3)),
        np.empty((MOST_POINTS, 3)),
        np.empty(MOST_POINTS),
        np.empty(MOST_POINTS, np.int64),
    )


new_manifold_in_kernel = jit(new_manifold)


@jit_lean
def box_box_manifold(boxes: BoxFrames, a: int, b: int, limits: Limits, manifold: Manifold) -> int:
    """Find where boxes `a` and `b` touch; return the number of points, which `manifold` then holds; paper §4.5."""
    separation, axis = least_overlap(boxes, a, b, limits, manifold.sat)
    if separation > limits.margin:
        return 0
    return _points_of_overlap(boxes, (a, b), (separation, axis), limits, manifold)


@jit_lean
def swept_manifold(boxes: BoxFrames, pair: tuple[int, int], sweep: Sweep, limits: Limits, manifold: Manifold) -> int:
    """Find where two boxes touch or will meet within a step; return the number of points, which `manifold` then holds.

    `limits.margin` [m] is the farthest that they can be apart now. Depths are those of now: negative where the boxes
    will meet. Boxes that overlap, and that rest on each other, have the points of `box_box_manifold`.
    """
    separation, axis = least_overlap(boxes, pair[0], pair[1], limits, manifold.sat)
    if separation > limits.margin:
        return 0
    graze = grazing_depth(boxes.size, pair, limits.slop)
    if separation <= -graze:
        return _points_of_overlap(boxes, pair, (separation, axis), limits, manifold)
    resting = separation <= limits.slop and axis < 6 and norm(sweep.travel) <= graze
    if resting and rests_on_face(boxes, pair, axis, graze, manifold.sat):
        return _clip_along(boxes, pair, axis, limits, NO_SWEEP, manifold)
    if sweep.turn > graze:
        near = separation <= 0.0 or come_near(boxes, pair, sweep, NEAR * graze, separation, manifold.sat)
        return _points_of_turning(boxes, pair, (separation, axis), sweep, limits, manifold) if near else 0
    return _points_of_meeting(boxes, pair, sweep, limits, manifold)


@jit_lean
def closes(boxes: BoxFrames, pair: tuple[int, int], flight: Sweep, found: int, slop: float, manifold: Manifold) -> bool:
    """Tell whether any of so many points of a manifold closes in flight, and goes deeper than `slop` [m].

    Corners are taken to go straight, as the solver takes them.
    """
    a, b = pair
    normal = manifold.sat.normal[0], manifold.sat.normal[1], manifold.sat.normal[2]
    rounding = rounding_of(boxes.size, pair[0], pair[1])
    for k in range(found):
        point = load(manifold.point, k)
        arm_a, arm_b = sub(point, load(boxes.position, a)), sub(point, load(boxes.position, b))
        way = add(flight.travel, sub(cross(flight.spin_a, arm_a), cross(flight.spin_b, arm_b)))
        if dot(way, normal) < manifold.depth[k] - slop - rounding:
            return True
    return False


@jit_lean
def _points_of_turning(
    boxes: BoxFrames,
    pair: tuple[int, int],
    overlap: tuple[float, int],
    sweep: Sweep,
    limits: Limits,
    manifold: Manifold,
) -> int:
    """Find the points at which two boxes that turn overlap, or will meet within the step: there is one at least.

    Where those that are apart will meet, the sweep does not tell that leaves their turning out: they are taken along
    the axis that parts them most now. But from farther off than turning can matter, it is the travel that decides.
    """
    if overlap[0] > sweep.turn:
        found = _points_of_meeting(boxes, pair, sweep, limits, manifold)
        if found > 0:
            return found
        overlap = least_overlap(boxes, pair[0], pair[1], limits, manifold.sat)
    found = _points_all_but_flat(boxes, pair, overlap[1], limits, NO_SWEEP, manifold)
    return found if found > 0 else _points_of_overlap(boxes, pair, overlap, limits, manifold)


@jit_lean
def _points_of_meeting(
    boxes: BoxFrames, pair: tuple[int, int], sweep: Sweep, limits: Limits, manifold: Manifold
) -> int:
    """Find the points at which two boxes that are apart, or graze each other, will meet if they do not turn."""
    meeting = meeting_of(boxes, pair, sweep, limits, manifold.sat)
    if meeting.axis == NEVER:
        return 0
    to_meet = Sweep(scale(meeting.when, sweep.travel), STILL, STILL, STILL, sweep.turn, sweep.share)
    if meeting.axis < 6:
        return _clip_along(boxes, pair, meeting.axis, limits, to_meet, manifold)
    found = _points_all_but_flat(boxes, pair, meeting.axis, limits, to_meet, manifold)
    if found > 0:
        return found
    gap = _edge_point(boxes, pair, meeting, to_meet, manifold)
    normal = manifold.sat.normal[0], manifold.sat.normal[1], manifold.sat.normal[2]
    left = abs(meeting.separation + dot(to_meet.travel, normal))
    # Edges that are farther apart then than along the normal pass beside each other.
    return 1 if gap <= left + sweep.turn + grazing_depth(boxes.size, pair, limits.slop) else 0


@jit_lean
def _points_all_but_flat(
    boxes: BoxFrames, pair: tuple[int, int], axis: int, limits: Limits, sweep: Sweep, manifold: Manifold
) -> int:
    """Find the points of faces that come down all but flat on each other, if along `axis` edges meet first, else none.

    The first point alone would not hold the boxes: in the same step they turn about it, into each other.
    """
    if axis < 6 or limits.paper_axes:
        return 0
    normal = manifold.sat.normal[0], manifold.sat.normal[1], manifold.sat.normal[2]
    face, most = 0, 0.0
    for k in range(6):
        along = abs(dot(load(boxes.axes[pair[k // 3]], k % 3), normal))
        if along > most:
            face, most = k, along
    if most < ALL_BUT_FLAT:
        return 0
    write_normal(boxes, pair, face, manifold.sat)
    found = _clip_along(boxes, pair, face, limits, sweep, manifold)
    if found == 0:
        write_normal(boxes, pair, axis, manifold.sat)
    return found


@jit_lean
def _points_of_overlap(
    boxes: BoxFrames, pair: tuple[int, int], overlap: tuple[float, int], limits: Limits, manifold: Manifold
) -> int:
    """Find the points along the (separation, axis) that parts boxes most; there is one at least."""
    separation, axis = overlap
    if axis >= 6:
        _edge_point(boxes, pair, Meeting(axis, separation, 0.0), NO_SWEEP, manifold)
        return 1
    count = _clip_along(boxes, pair, axis, limits, NO_SWEEP, manifold)
    if count == 0:
        # The deepest corner lies beside the reference face, and what lies over it is not in contact.
        placed = PlacedBoxes(boxes.size, boxes.position, boxes.orientation)
        a, b = placed_box(placed, pair[0]), placed_box(placed, pair[1])
        depth, point, _ = box_box_contact(a, b, limits.paper_axes)
        store(manifold.point, 0, point)
        manifold.depth[0] = depth
        manifold.feature[0] = 1 << 20
        count = 1
    return count


@jit_lean
def _clip_along(
    boxes: BoxFrames, pair: tuple[int, int], axis: int, limits: Limits, sweep: Sweep, manifold: Manifold
) -> int:
    """Clip the faces of two boxes that face each other along the normal of a face of one, after `sweep`."""
    a, b = pair
    faces = Faces(a, b, axis, 1.0) if axis < 3 else Faces(b, a, axis - 3, -1.0)
    return _clip_faces(boxes, faces, limits, sweep, manifold)


@jit_lean
def _clip_faces(boxes: BoxFrames, faces: Faces, limits: Limits, sweep: Sweep, manifold: Manifold) -> int:
    """Clip the incident face against the sides of the reference face (Sutherland, Hodgman 1974), after `sweep`.

    Keeps the points no higher than the margin, and returns how many. Heights are those of now; a point lies where the
    lighter box has it now, to which the other one comes.
    """
    size, axes = boxes.size, boxes.axes
    r, axis = faces.reference, faces.axis
    out, facing, sign = _incident_face(axes, faces, manifold.sat.normal)
    u, v = AFTER[axis], AFTER[axis + 1]
    height = 0.5 * size[r, axis]
    # How far the incident face moves along the reference face, and the part that its points lie behind.
    ahead = scale(-faces.towards_reference, sweep.travel)
    shift = _along_axis(axes, r, u, ahead), _along_axis(axes, r, v, ahead)
    behind = 1.0 - sweep.share if faces.towards_reference > 0.0 else sweep.share
    _project_incident_face(boxes, faces, (out, facing, sign), shift, manifold)
    half = 0.5 * size[r, u] + limits.slop, 0.5 * size[r, v] + limits.slop
    count, at = _clip_polygon(manifold.polygon, manifold.side, half)

    # What is left and not too high above the reference face, half-way between the two, in the world.
    polygon, side = manifold.polygon, manifold.side
    kept = 0
    towards = 1 if faces.towards_reference > 0.0 else 0
    face = (axis * 2 + towards) * 6 + facing * 2 + (1 if sign > 0.0 else 0)
    for k in range(count):
        above = polygon[at, k, 2]
        if above <= limits.margin and kept < MOST_POINTS:
            before = k - 1 if k > 0 else count - 1
            pu, pv = polygon[at, k, 0] - behind * shift[0], polygon[at, k, 1] - behind * shift[1]
            pw = 0.5 * above + height
            for c in range(3):
                manifold.point[kept, c] = boxes.position[r, c] + pu * axes[r, u, c] + pv * axes[r, v, c] + pw * out[c]
            manifold.depth[kept] = -above
            manifold.feature[kept] = (face * 8 + side[at, before]) * 8 + side[at, k]
            kept += 1
    return kept


@jit_lean
def _along_axis(axes: np.ndarray, box: int, k: int, v: Vec) -> float:
    """Return the component of `v` along axis `k` of a box."""
    return v[0] * axes[box, k, 0] + v[1] * axes[box, k, 1] + v[2] * axes[box, k, 2]


@jit_lean
def _incident_face(axes: np.ndarray, faces: Faces, normal: np.ndarray) -> tuple[Vec, int, float]:
    """Return the normal out of the reference face, and which face of the other box faces it most: (axis, sign)."""
    s, towards = faces.incident, -faces.towards_reference
    out = towards * normal[0], towards * normal[1], towards * normal[2]
    facing = 0
    least = 2.0
    sign = 1.0
    for k in range(3):
        cosine = out[0] * axes[s, k, 0] + out[1] * axes[s, k, 1] + out[2] * axes[s, k, 2]
        if -abs(cosine) < least:
            least = -abs(cosine)
            facing = k
            sign = -1.0 if cosine > 0.0 else 1.0
    return out, facing, sign


@jit_lean
def _project_incident_face(
    boxes: BoxFrames,
    faces: Faces,
    incident: tuple[Vec, int, float],
    shift: tuple[float, float],
    manifold: Manifold,
) -> None:
    """Write the corners of the incident face, moved by `shift` [m], seen from the reference box: u, v, above."""
    size, position, axes = boxes.size, boxes.position, boxes.axes
    r, s, axis = faces.reference, faces.incident, faces.axis
    (n0, n1, n2), facing, sign = incident
    u, v = AFTER[axis], AFTER[axis + 1]
    f, g = AFTER[facing], AFTER[facing + 1]
    # Its middle.
    m0 = position[s, 0] - position[r, 0] + 0.5 * sign * size[s, facing] * axes[s, facing, 0]
    m1 = position[s, 1] - position[r, 1] + 0.5 * sign * size[s, facing] * axes[s, facing, 1]
    m2 = position[s, 2] - position[r, 2] + 0.5 * sign * size[s, facing] * axes[s, facing, 2]
    mu = m0 * axes[r, u, 0] + m1 * axes[r, u, 1] + m2 * axes[r, u, 2] + shift[0]
    mv = m0 * axes[r, v, 0] + m1 * axes[r, v, 1] + m2 * axes[r, v, 2] + shift[1]
    mw = m0 * n0 + m1 * n1 + m2 * n2 - 0.5 * size[r, axis]
    # Half its edges.
    hf, hg = 0.5 * size[s, f], 0.5 * size[s, g]
    fu = hf * (axes[s, f, 0] * axes[r, u, 0] + axes[s, f, 1] * axes[r, u, 1] + axes[s, f, 2] * axes[r, u, 2])
    fv = hf * (axes[s, f, 0] * axes[r, v, 0] + axes[s, f, 1] * axes[r, v, 1] + axes[s, f, 2] * axes[r, v, 2])
    fw = hf * (axes[s, f, 0] * n0 + axes[s, f, 1] * n1 + axes[s, f, 2] * n2)
    gu = hg * (axes[s, g, 0] * axes[r, u, 0] + axes[s, g, 1] * axes[r, u, 1] + axes[s, g, 2] * axes[r, u, 2])
    gv = hg * (axes[s, g, 0] * axes[r, v, 0] + axes[s, g, 1] * axes[r, v, 1] + axes[s, g, 2] * axes[r, v, 2])
    gw = hg * (axes[s, g, 0] * n0 + axes[s, g, 1] * n1 + axes[s, g, 2] * n2)
    # Its four corners, round and round.
    polygon, side = manifold.polygon, manifold.side
    for k in range(4):
        p = 1.0 if k == 0 or k == 3 else -1.0
        q = 1.0 if k < 2 else -1.0
        polygon[0, k, 0] = mu + p * fu + q * gu
        polygon[0, k, 1] = mv + p * fv + q * gv
        polygon[0, k, 2] = mw + p * fw + q * gw
        side[0, k] = k


@jit_lean
def _clip_polygon(polygon: np.ndarray, side: np.ndarray, half: tuple[float, float]) -> tuple[int, int]:
    """Clip the four corners in polygon[0] against a rectangle of `half` extents [m]; return (corners, where they are).

    With the slop in it: corners that lie on each other would else be now in and now out, by rounding.
    """
    count, at = 4, 0
    for plane in range(4):
        c = plane // 2
        outwards = 1.0 if plane % 2 == 0 else -1.0
        outside = False
        for k in range(count):
            outside = outside or outwards * polygon[at, k, c] > half[c]
        if not outside:
            continue
        # Corners inside are kept; where an edge crosses the line, there is a new one.
        to = 1 - at
        kept = 0
        for k in range(count):
            after = k + 1 if k + 1 < count else 0
            here = outwards * polygon[at, k, c] - half[c]
            there = outwards * polygon[at, after, c] - half[c]
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
    return count, at


@jit_lean
def _edge_point(boxes: BoxFrames, pair: tuple[int, int], meeting: Meeting, sweep: Sweep, manifold: Manifold) -> float:
    """Put into `manifold` the middle of the shortest way between an edge of each box, after `sweep`; return its length.

    Of the four edges along that axis of each box, the ones that lie farthest towards the other box.
    """
    a, b = pair
    i, j = (meeting.axis - 6) // 3, (meeting.axis - 6) % 3
    size, axes = boxes.size, boxes.axes
    normal, edge = manifold.sat.normal, manifold.edge
    # The middles of the two edges, and which of four they are.
    feature = 0
    for c in range(3):
        edge[0, c] = boxes.position[a, c] + sweep.travel[c]
        edge[1, c] = boxes.position[b, c]
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
    # Where they come nearest to each other.
    x, y, z = edge[0, 0] - edge[1, 0], edge[0, 1] - edge[1, 1], edge[0, 2] - edge[1, 2]
    along_a = x * axes[a, i, 0] + y * axes[a, i, 1] + z * axes[a, i, 2]
    along_b = x * axes[b, j, 0] + y * axes[b, j, 1] + z * axes[b, j, 2]
    s, t = nearest_places(manifold.sat.cosine[i, j], along_a, along_b, 0.5 * size[a, i], 0.5 * size[b, j])
    square = 0.0
    for c in range(3):
        on_a, on_b = edge[0, c] + s * axes[a, i, c], edge[1, c] + t * axes[b, j, c]
        manifold.point[0, c] = 0.5 * (on_a + on_b) - sweep.share * sweep.travel[c]
        square += (on_a - on_b) * (on_a - on_b)
    manifold.depth[0] = -meeting.separation
    manifold.feature[0] = (1 << 16) + (feature * 3 + i) * 3 + j
    return sqrt(square)


@jit
def box_pairs_manifolds(
    a: PlacedBoxes, b: PlacedBoxes, margin: float = 0.0, paper_axes: bool = False
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return where the boxes of each of m pairs touch: count (m,), normal (m, 3), point (m, 8, 3), depth (m, 8) [m].

    For geometry users; row i of a against row i of b. Rows of points from `count` on mean nothing, nor does the normal
    where `count` is 0; normals point from b to a.
    """
    pairs = a.size.shape[0]
    boxes = frames_of(
        PlacedBoxes(
            np.concatenate((a.size, b.size)),
            np.concatenate((a.position, b.position)),
            np.concatenate((a.orientation, b.orientation)),
        )
    )
    limits = Limits(margin, 0.0, paper_axes)
    count = np.empty(pairs, np.int64)
    normal = np.zeros((pairs, 3))
    point = np.zeros((pairs, MOST_POINTS, 3))
    depth = np.zeros((pairs, MOST_POINTS))
    manifold = new_manifold_in_kernel()
    for i in range(pairs):
        found = box_box_manifold(boxes, i, pairs + i, limits, manifold)
        count[i] = found
        for c in range(3 if found else 0):
            normal[i, c] = manifold.sat.normal[c]
        for k in range(found):
            depth[i, k] = manifold.depth[k]
            store(point[i], k, load(manifold.point, k))
    return count, normal, point, depth
