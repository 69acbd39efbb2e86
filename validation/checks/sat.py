"""The separating-axis test on pairs of boxes: hit or miss, and how deep."""

from __future__ import annotations

import numpy as np

from softbody.collision import sat
from validation.cases import BoxPairs, box_separations, random_box_pairs, random_orientations, rotation_matrix
from validation.check import DISAGREEMENTS, Comparison, Misprint, Run, check

FAMILY = "separating axes"
PIECE = "softbody.collision.sat.box_box_separation"


def separations(pairs: BoxPairs, paper_axes: bool = False) -> np.ndarray:
    """Return the core's separation (m,) [m] of each pair."""
    return np.array([separation for separation, _, _ in box_separations(pairs, paper_axes)])


@check(
    family=FAMILY,
    claim="Random boxes overlap for the core if and only if they overlap for FCL.",
    section="4.5",
    piece="softbody.collision.sat.box_pairs_overlap",
    reference="FCL",
    engines=("fcl",),
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="a yes-or-no answer, outside FCL's own rounding band",
    detects="one wrong answer",
    erratum=Misprint("E11", "face normals only", "face normals and edge × edge: fifteen axes"),
)
def random_pairs(run: Run) -> Comparison:
    from references import fcl

    pairs = random_box_pairs(run.rng, run.count(2_000, 20_000, 1_000_000))
    expected = fcl.boxes_overlap(*pairs)
    measured = sat.box_pairs_overlap(*pairs, False)
    paper = sat.box_pairs_overlap(*pairs, True)
    trusted = np.abs(separations(pairs)) > fcl.MARGIN * pairs.extent
    return Comparison(
        measured[trusted],
        expected[trusted],
        groups=np.where(expected, "overlapping", "apart")[trusted],
        printed=paper[trusted],
        notes=[f"{int((~trusted).sum())} pairs within FCL's rounding band passed over"],
    )


def near_ties(rng: np.random.Generator, count: int) -> tuple[BoxPairs, np.ndarray]:
    """Return pairs whose gap or overlap is 1e-3 … 1e-13 of their size, and what kind of contact each has.

    b is moved along the axis that parts the pair most until the core sees them just touch, then a little on.
    Which side of the tie a pair is on is for exact arithmetic to say.
    """
    pairs = random_box_pairs(rng, count)
    half = count // 2
    # Every other pair: nearly or exactly parallel, as boxes that lie on each other.
    pairs.orientation_b[:half] = pairs.orientation_a[:half]
    quarter = half // 2
    pairs.orientation_a[:quarter] = pairs.orientation_b[:quarter] = (1.0, 0.0, 0.0, 0.0)
    kinds = np.where(np.arange(count) < quarter, "aligned with the axes", "")
    kinds = np.where((np.arange(count) >= quarter) & (np.arange(count) < half), "parallel", kinds)
    for i, (separation, normal, axis) in enumerate(box_separations(pairs)):
        gap = rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-13.0, -3.0)
        pairs.position_b[i] += (separation - gap) * normal
        if not kinds[i]:
            kinds[i] = "edge on edge" if axis >= 6 else "corner on face"
    return pairs, kinds


@check(
    family=FAMILY,
    claim="Boxes that miss or touch each other by 1e-3 to 1e-13 of their size are told apart rightly.",
    section="4.5",
    piece=PIECE,
    reference="exact rational arithmetic on the same floating-point inputs",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="pairs whose exact separation is below the core's rounding, 4e-15 of the size, are passed over",
    detects="one wrong answer",
)
def near_touching_pairs(run: Run) -> Comparison:
    from references import exact

    pairs, kinds = near_ties(run.rng, run.count(200, 2_000, 20_000))
    signs = exact.boxes_overlap(*pairs)
    found = separations(pairs)
    clear = np.abs(found) > 4e-15 * pairs.extent
    return Comparison(
        (found <= 0.0)[clear],
        (signs >= 0)[clear],
        groups=kinds[clear],
        notes=[f"{int((~clear).sum())} of {len(clear)} pairs lie within 4e-15 of their size: passed over"],
    )


@check(
    family=FAMILY,
    claim="The depth of overlapping boxes is the least one that FCL finds.",
    section="4.5",
    piece=PIECE,
    reference="FCL distance with signed result",
    engines=("fcl",),
    unit="of the size",
    tolerance=1e-13,
    because="rounding on both sides; FCL is within 2e-15 but for nearly parallel boxes, which random poses do not meet",
    detects="a wrong axis; an edge axis that is not normalised",
)
def depth(run: Run) -> Comparison:
    from references import fcl

    pairs = random_box_pairs(run.rng, run.count(1_000, 5_000, 100_000))
    ours = separations(pairs)
    judged = fcl.box_distance(*pairs)
    # For boxes apart, the distance is not along an axis of the test, and can only be larger.
    overlap = judged < 0.0
    return Comparison(ours[overlap], judged[overlap], pairs.extent[overlap])


@check(
    family=FAMILY,
    claim="The paper's six axes never miss an overlap: their only fault is to see some that are not there.",
    section="4.5",
    piece=PIECE,
    reference="FCL",
    engines=("fcl",),
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="every axis that parts the boxes for six parts them for fifteen",
    detects="one missed overlap",
    erratum=Misprint(
        "E12",
        "overlap if a point of one lies between two points of the other",
        "overlap if the intervals meet, whichever contains the other",
    ),
)
def paper_axes_never_miss(run: Run) -> Comparison:
    from references import fcl, printed

    pairs = random_box_pairs(run.rng, run.count(1_000, 10_000, 100_000), low=0.1, high=3.0)
    overlapping = fcl.boxes_overlap(*pairs)
    hits = pairs.select(overlapping)
    return Comparison(
        sat.box_pairs_overlap(*hits, True),
        np.ones(len(hits.size_a), bool),
        printed=printed.boxes_overlap_one_way(*hits),
    )


@check(
    family=FAMILY,
    claim="The answer does not depend on which box is called a, nor on where and how the pair is placed.",
    section="4.5",
    piece=PIECE,
    reference="invariant: exchange, rotation, translation by 1 000 m",
    unit="of the size",
    tolerance=4e-13,
    because="positions near 1 000 m are rounded to 1e-13 m",
    detects="a one-sided interval test; a sign of the normal that follows the order",
)
def invariance(run: Run) -> Comparison:
    rng = run.rng
    pairs = random_box_pairs(rng, run.count(500, 3_000, 30_000))
    before = separations(pairs)
    turn = random_orientations(rng, 1)[0]
    matrix, offset = rotation_matrix(turn), rng.uniform(-1000.0, 1000.0, 3)
    moved = BoxPairs(
        pairs.size_a,
        pairs.position_a @ matrix.T + offset,
        _product(turn, pairs.orientation_a),
        pairs.size_b,
        pairs.position_b @ matrix.T + offset,
        _product(turn, pairs.orientation_b),
    )
    after = np.concatenate([separations(pairs.swapped()), separations(moved)])
    kinds = ["exchanged"] * len(before) + ["moved"] * len(before)
    return Comparison(after, np.tile(before, 2), np.tile(pairs.extent, 2), kinds)


def _product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return the Hamilton products of one quaternion and rows of others."""
    w = p[0] * q[:, 0] - q[:, 1:] @ p[1:]
    xyz = p[0] * q[:, 1:] + q[:, :1] * p[1:] + np.cross(p[1:], q[:, 1:])
    return np.column_stack([w, xyz])
