"""What a tree lists for eight boxes, where segments go through triangles, and on which sides of a mesh points are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from softbody.geometry import aabb, bvh, bvh_boxes, bvh_rays, penetration, segments
from softbody.geometry.bvh import build_bvh, refit_bvh, search_space
from validation.answers import Answers
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "soft–soft narrow phase"

CLEAR = 1e-6  # of the mesh's half size: between 0 and this, a box of float32 may be listed or not


@check(
    section="6",
    piece="softbody.geometry.bvh_boxes.list_near",
    reference="bounding boxes in NumPy",
    unit="times that it is listed",
    kind="closed form",
    tolerance=0.0,
    because="boxes are grown by more than float32 rounds, and by less than a millionth; those between are left out",
    faults=(
        Fault(
            "boxes that meet beside each other",
            bvh_boxes.list_near,
            "bits_at_most(y0_, boxes_[node_, 4, child_]) & bits_at_most(boxes_[node_, 1, child_], y1_)"
            " → bits_at_most(y0_, boxes_[node_, 4, child_]) | bits_at_most(boxes_[node_, 1, child_], y1_)",
        ),
        Fault(
            "boxes in metres", bvh.refit_bvh, "1.0 / half if half > 0.0 else 1.0 → 1.0 / half if half > 1.0 else 1.0"
        ),
        Fault(
            "boxes around two corners of each triangle",
            bvh._fit_leaves,
            "_least(_least(a_[axis_], b_[axis_]), c_[axis_]) → _least(a_[axis_], b_[axis_])",
        ),
        Fault("boxes that begin at each triangle's last corner", bvh._least, "where_less(a_, b_, a_, b_) → b_"),
        Fault("a leaf without the margin of its third corner", bvh_boxes.ask_leaf, "c_[2] - margin_ → c_[2] + margin_"),
        Fault(
            "the last leaf's triangle again",
            bvh_boxes.list_near,
            "level_ == 0 and WIDTH * (number_ + 1) > tree_.triangles.shape[0]"
            " → level_ < 0 and WIDTH * (number_ + 1) > tree_.triangles.shape[0]",
        ),
    ),
)
def what_is_near(run: Run) -> Comparison:
    """A tree lists each triangle whose bounding box meets those asked for.

    Eight boxes, rays or grown leaves are asked for at once: it lists a triangle once, and for the right ones. It lists
    none that is a millionth of the mesh's half size away. Meshes are of any size and place, also stretched a
    thousandfold, after they have moved.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(60, 300, 5_000)):
        count = int(rng.integers(1, 200))
        middles, sizes = rng.normal(size=(count, 1, 3)), 10.0 ** rng.uniform(-3.0, 0.0, (count, 1, 1))
        corners = middles + sizes * rng.normal(size=(count, 3, 3))
        vertices, triangles = corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)
        tree = build_bvh(vertices, triangles)
        vertices = vertices * 10.0 ** rng.uniform(-1.5, 1.5, 3) + rng.normal(size=3) * 10.0 ** rng.uniform(0.0, 3.0)
        vertices *= 10.0 ** rng.uniform(-6.0, 6.0)
        refit_bvh(tree, vertices)
        low, high = vertices[triangles].min(axis=1), vertices[triangles].max(axis=1)
        half = 0.5 * float((high.max(axis=0) - low.min(axis=0)).max())
        search, leaf = search_space(tree), int(rng.integers(len(tree.corners)))
        kind = ("boxes", "rays", "a leaf")[rng.integers(3)]
        bvh_boxes.ask_nothing(search)
        if kind == "a leaf":
            margin = half * float(rng.choice([0.0, 0.01, 0.3]))
            asked, lanes = np.unique(tree.order[8 * leaf : 8 * leaf + 8], return_index=True)
            asked_low, asked_high = low[asked] - margin, high[asked] + margin
            bvh_boxes.ask_leaf(search, leaf, tree, vertices, margin)
        else:
            # Boxes that hardly meet, or hardly miss, a triangle along one axis.
            lanes = rng.permutation(8)[: rng.integers(1, 9)]
            near, axis = rng.integers(count, size=len(lanes)), rng.integers(3, size=len(lanes))
            span = rng.uniform(0.0, 0.5, (len(lanes), 3)) * (high - low)[near]
            asked_low = low[near] + 0.25 * (high - low)[near]
            gap = half * rng.choice([-1.0, 1.0], len(lanes)) * 10.0 ** rng.uniform(-5.5, -1.0, len(lanes))
            rows = np.arange(len(lanes))
            asked_low[rows, axis] = high[near, axis] + gap
            asked_high = asked_low + span
            below = rng.random(len(lanes)) < 0.5  # or on the other side of it
            width = span[rows, axis]
            asked_high[rows[below], axis[below]] = (low[near, axis] - gap)[below]
            asked_low[rows[below], axis[below]] = (low[near, axis] - gap - width)[below]
            if kind == "rays":
                asked_high = asked_low.copy()
                asked_high[:, 2] = np.inf
            for lane, *ends in zip(lanes, asked_low.tolist(), asked_high.tolist()):
                bvh_boxes.ask_box(search, int(lane), tuple(ends[0]), tuple(ends[1]), tree)
        found = bvh_boxes.list_near(tree, search)
        times = np.zeros((8, count))
        for triangle, bits in zip(search.listed[:found], search.meets[:found]):
            times[:, triangle] += (bits >> np.arange(8)) & 1
        apart = np.full((8, count), np.inf)
        apart[lanes] = np.maximum(low - asked_high[:, None], asked_low[:, None] - high).max(axis=2) / half
        sure = (apart <= 0.0) | (apart > CLEAR)
        answers.extend(times[sure], (apart <= 0.0)[sure].astype(float), kind=kind)
    return answers.comparison()


SHIFT = np.array([2**20, 2**10, 1], object)  # in units of 2⁻³⁰: next to nothing along x, less along y, least along z


@check(
    section="4.3",
    piece="softbody.geometry.bvh_rays.segment_hits",
    reference="Python's integers, of segments that are moved",
    unit="hits; and of a segment's length",
    kind="exact arithmetic",
    tolerance=0.0,
    because="whole numbers: a place is one quotient, rounded once",
    faults=(
        Fault(
            "lines that are past a triangle if one side is on their left",
            segments.bits_not_past,
            "~(left_ & right_) → ~left_",
        ),
        Fault(
            "moved along x and z only",
            bvh_rays._is_positive,
            "slope_[1] if slope_[1] != 0.0 else slope_[2] → slope_[2]",
        ),
        Fault(
            "moved along x and y only",
            bvh_rays._is_positive,
            "slope_[1] if slope_[1] != 0.0 else slope_[2] → slope_[1]",
        ),
        Fault(
            "places from the end",
            bvh_rays._place_in_triangle,
            "before_ / (before_ - beyond_) → beyond_ / (beyond_ - before_)",
        ),
    ),
)
def segments_of_whole_numbers(run: Run) -> Comparison:
    """Segments and triangles meet as they do once segments have hardly moved.

    By next to nothing along x, less along y and least along z: how often, and where; all in whole numbers.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(60, 300, 5_000)):
        count = int(rng.integers(1, 30))
        corners, ends = rng.integers(-2, 3, (count, 3, 3)), rng.integers(-3, 4, (8, 2, 3))
        vertices, triangles = corners.reshape(-1, 3).astype(float), np.arange(3 * count).reshape(-1, 3)
        tree, eight = build_bvh(vertices, triangles), np.zeros((9, 8))
        for lane, (p, q) in enumerate(ends.astype(float).tolist()):
            segments.put_segment(eight, lane, tuple(p), tuple(q))
        hits, place = np.zeros(8, np.int64), np.zeros((8, count))
        bvh_rays.segment_hits(eight, 8, tree, vertices, search_space(tree), hits, place)
        for segment, found, number in zip(ends, place, hits):
            answers.add(_row(found[:number]), _row(_places(segment, corners)), segment=segment.ravel())
    return answers.comparison()


def _row(places: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return how many places there are, and places in order, as a row that is as long as any."""
    return np.concatenate([[len(places)], np.sort(places), np.full(30 - len(places), -1.0)])


def _places(ends: np.ndarray, corners: np.ndarray) -> list[float]:
    """Return where a segment (2, 3) that is moved goes through triangles (t, 3, 3), 0 at its start … 1 at its end."""
    (p, q), (a, b, c) = ends.astype(object), corners.astype(object).transpose(1, 0, 2)
    n = np.cross(b - a, c - a)
    start, end = 2**30 * p + SHIFT, 2**30 * q + SHIFT
    before, beyond = ((n * (each - 2**30 * a)).sum(axis=1) for each in (start, end))
    pa, pb, pc = (2**30 * each - start for each in (a, b, c))
    u, v, w = (np.cross(one, two) @ (q - p) for one, two in ((pb, pc), (pc, pa), (pa, pb)))
    through = ((before > 0) != (beyond > 0)) & ((u > 0) == (v > 0)) & ((v > 0) == (w > 0))
    at_start, at_end = (n * (p - a)).sum(axis=1), (n * (q - a)).sum(axis=1)
    return [int(at_start[t]) / int(at_start[t] - at_end[t]) for t in np.flatnonzero(through)]


@check(
    section="6",
    piece="softbody.geometry.penetration.find_outcodes, softbody.geometry.aabb.boxes_meet",
    reference="whole numbers in NumPy",
    kind="exact arithmetic",
    faults=(
        Fault("two sides with one bit", penetration.find_outcodes, "(p_[2] > x_) << 5 → (p_[2] > x_) << 6"),
        Fault("a side without a bit", penetration.find_outcodes, "(p_[0] < low_[0]) | x_ → (p_[0] < low_[0]) & x_"),
        Fault(
            "points on the plane are beyond it",
            penetration.find_outcodes,
            "reach_ += ROUNDING * norm(axis_) * size_ → reach_ -= ROUNDING * norm(axis_) * size_",
        ),
        Fault("bounding boxes that touch are apart", aabb.boxes_meet, "b[0][k_] <= a[1][k_] → b[0][k_] < a[1][k_]"),
    ),
)
def sides_of_a_mesh(run: Run) -> Comparison:
    """Outcodes name the sides of a mesh that points are beyond.

    Sides of its bounding box, and whether they are beyond its farthest vertex on the way to the points' box. Boxes that
    have a point in common meet. All in whole numbers.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(300, 1_000, 20_000)):
        mesh = rng.integers(-3, 4, (int(rng.integers(1, 12)), 3)) + rng.integers(-2, 3, 3)
        points = rng.integers(-3, 4, (int(rng.integers(1, 12)), 3)) + rng.integers(-4, 5, 3)
        ours, theirs = penetration.points_of(points.astype(float)), penetration.points_of(mesh.astype(float))
        code = np.full(len(points), 255, np.uint8)
        left = penetration.find_outcodes(ours, theirs, code)
        low, high, first, last = mesh.min(axis=0), mesh.max(axis=0), points.min(axis=0), points.max(axis=0)
        # Twice the middles and the way between them are whole.
        way = (first + last) - (low + high)
        along, reach = (2 * points - low - high) @ way, ((2 * mesh - low - high) @ way).max()
        beyond = np.stack([points < low, points > high], axis=2).reshape(-1, 6)
        bits = np.column_stack([beyond, along > reach, np.zeros(len(points), bool)])
        found = np.unpackbits(code[:, None], axis=1, bitorder="little").astype(bool)
        answers.extend(found.ravel(), bits.ravel(), kind="outcodes")
        meet = bool((first <= high).all() and (low <= last).all())
        for a, b in ((ours, theirs), (theirs, ours)):
            answers.add(aabb.boxes_meet(a.bounds, b.bounds), meet, kind="boxes")
        answers.add(left == (~bits.any(axis=1)).sum(), True, kind="how many are beyond none")
    return answers.comparison()
