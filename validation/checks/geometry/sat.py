"""The separating-axis test on pairs of boxes: hit or miss, and how deep."""

from __future__ import annotations

import importlib
from types import ModuleType

import numpy as np

from softbody.collision.boxes import sat_boxes
from validation.answers import Answers
from validation.arbitration import US, arbitrate
from validation.cases import (
    BoxPairs,
    box_separations,
    gap_along,
    random_box_pairs,
    random_orientations,
    rotation_matrix,
)
from validation.check import Comparison, Misprint, Run, check
from validation.engines import missing
from validation.fault import Fault

FAMILY = "separating axes"

FOURTEEN_AXES = Fault(
    "the last of fifteen axes left out",
    sat_boxes.box_box_separation,
    "6 if paper_axes_ else 15 → 6 if paper_axes_ else 14",
)
LESS_REACH = Fault(
    "one box of three percent less reach",
    sat_boxes.box_box_separation,
    "distance_ - reach_a_ - reach_b_ → distance_ - reach_a_ - 0.97 * reach_b_",
)
PIECE = "softbody.collision.boxes.sat_boxes.box_box_separation"
PAIRS = "softbody.collision.boxes.sat_boxes.box_pairs_overlap"


def separations(pairs: BoxPairs) -> np.ndarray:
    """Return the core's separation (m,) [m] of each pair."""
    return sat_boxes.box_pairs_separation(pairs.a, pairs.b)[0]


def _beyond(margin: float, pairs: BoxPairs) -> np.ndarray:
    """Tell of which pairs (m,) the separation is more than a margin, in units of their size."""
    return np.abs(separations(pairs)) > margin * pairs.extent


def _random_pairs_by(run: Run, count: int, engine: ModuleType) -> Comparison:
    """Ask about random boxes beyond an engine's margin; of all where it differs, exact arithmetic says who is right."""
    from references import exact

    pairs, name = random_box_pairs(run.fresh_rng(), count), engine.__name__.rpartition(".")[2]
    expected, measured = engine.boxes_overlap(*pairs), sat_boxes.box_pairs_overlap(pairs.a, pairs.b)
    trusted = _beyond(engine.MARGIN, pairs)
    truth, doubtful = measured.copy(), np.flatnonzero(measured != expected)
    if len(doubtful):
        truth[doubtful] = exact.boxes_overlap(*pairs.select(doubtful)) >= 0
    by, answers = "exact arithmetic where they differ", {US: measured, name: expected}
    return Comparison(
        measured[trusted],
        expected[trusted],
        groups=np.where(expected, "overlapping", "apart")[trusted],
        notes=[f"{int((~trusted).sum())} pairs within the margin of {name} passed over"],
        inputs=pairs.select(trusted)._asdict(),
        arbitrations=[arbitrate(by, truth, answers, inputs=pairs._asdict())],
    )


@check(
    section="4.5",
    piece=PAIRS,
    reference="FCL",
    engines=("fcl",),
    because="outside FCL's own rounding band",
    faults=(FOURTEEN_AXES,),
    erratum=Misprint("E11", "face normals only", "face normals and edge × edge: fifteen axes"),
)
def random_pairs(run: Run) -> Comparison:
    """Random boxes overlap exactly when they do for FCL."""
    from references import fcl

    comparison = _random_pairs_by(run, run.count(2_000, 20_000, 1_000_000), fcl)
    pairs = BoxPairs(**comparison.inputs)
    comparison.printed = sat_boxes.box_pairs_overlap(pairs.a, pairs.b, True)
    return comparison


def near_ties(rng: np.random.Generator, count: int) -> tuple[BoxPairs, np.ndarray]:
    """Return pairs whose gap or overlap is 1e-3 … 1e-14 of their size, and what kind of contact each has.

    b is moved along the axis that parts the pair most until the core sees them just touch, then a little on.
    Which side of the tie a pair is on is for exact arithmetic to say.
    """
    pairs = random_box_pairs(rng, count)
    half, quarter = count // 2, count // 2 // 2
    # Every other pair: nearly or exactly parallel, as boxes that lie on each other.
    pairs.orientation_b[:half] = pairs.orientation_a[:half]
    pairs.orientation_a[:quarter] = pairs.orientation_b[:quarter] = (1.0, 0.0, 0.0, 0.0)
    kinds = np.repeat(["aligned with the axes", "parallel", ""], [quarter, half - quarter, count - half])
    for i, (separation, normal, axis) in enumerate(box_separations(pairs)):
        gap = rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-14.0, -3.0)
        pairs.position_b[i] += (separation - gap) * normal
        if not kinds[i]:
            kinds[i] = "edge on edge" if axis >= 6 else "corner on face"
    # And some that lie inside the other, their projections inside its own on every axis.
    inner = np.arange(count) % 10 == 9
    pairs.size_b[inner] = 0.1 * pairs.size_a[inner].min(axis=1)[:, None]
    pairs.position_b[inner] = pairs.position_a[inner] + rng.uniform(-0.1, 0.1, (int(inner.sum()), 3))
    kinds = np.where(inner, "one inside the other", kinds)
    return pairs, kinds


@check(
    section="4.5",
    piece=PIECE,
    reference="exact rational arithmetic on the same floating-point inputs",
    kind="exact arithmetic",
    because="pairs whose exact separation is below the core's rounding, 4e-15 of the size, are passed over",
    faults=(
        Fault(
            "boxes grown by 1e-12",
            sat_boxes.box_box_separation,
            "distance_ - reach_a_ - reach_b_ → distance_ - reach_a_ - reach_b_ - 1e-12",
        ),
    ),
)
def near_touching_pairs(run: Run) -> Comparison:
    """Boxes that hardly miss or touch each other are told apart rightly.

    They miss or touch by 1e-3 to 1e-14 of their size.
    """
    from references import exact

    pairs, kinds = near_ties(run.fresh_rng(), run.count(200, 2_000, 100_000))
    clear = _beyond(4e-15, pairs)
    notes = [f"{int((~clear).sum())} of {len(clear)} pairs lie within 4e-15 of their size: passed over"]
    pairs, kinds = pairs.select(clear), kinds[clear]
    measured, expected = separations(pairs) <= 0.0, exact.boxes_overlap(*pairs) >= 0
    said = {US: measured}
    for name in ("fcl", "coal"):
        if not missing((name,)):
            said[name] = importlib.import_module(f"references.{name}").boxes_overlap(*pairs)
    inputs = pairs._asdict()
    judged = [arbitrate("exact arithmetic", expected, said, groups=kinds, inputs=inputs)]
    return Comparison(measured, expected, groups=kinds, notes=notes, inputs=inputs, arbitrations=judged)


@check(
    section="4.5",
    piece=PAIRS,
    reference="coal; exact arithmetic says who is right",
    engines=("coal",),
    because="coal is right beyond 1e-6 m, and nearer pairs are passed over",
    faults=(FOURTEEN_AXES,),
)
def random_pairs_by_coal(run: Run) -> Comparison:
    """Random boxes overlap exactly when they do for coal."""
    from references import coal

    return _random_pairs_by(run, run.count(1_000, 10_000, 1_000_000), coal)


def _pose_families(rng: np.random.Generator, count: int) -> dict[str, BoxPairs]:
    """Return `count` pairs of boxes of each family of sizes and poses."""
    rods = random_box_pairs(rng, count)
    rods.size_a[:] = rods.size_b[:] = (0.1, 0.1, 2.0)
    cubes = random_box_pairs(rng, count)
    cubes.size_a[:] = cubes.size_b[:] = 1.0
    for pairs, reach in ((rods, 0.7), (cubes, 1.8)):
        pairs.position_b[:] = pairs.position_a + rng.uniform(-reach, reach, (count, 3))
    families = {"sides 0.4 to 2": random_box_pairs(rng, count), "unit cubes": cubes, "rods 1:1:20": rods}
    for gap in (0.1, 0.01, 0.001):
        near = random_box_pairs(rng, count)
        near.size_a[:] = near.size_b[:] = 1.0
        for i, (separation, normal, _) in enumerate(box_separations(near)):
            near.position_b[i] += (separation - gap) * normal
        families[f"cubes {gap} apart"] = near
    return families


@check(
    section="4.5",
    piece=PAIRS,
    reference="FCL",
    engines=("fcl",),
    because="outside FCL's own rounding band",
    faults=(FOURTEEN_AXES,),
)
def families_of_poses(run: Run) -> Comparison:
    """Boxes in every family of poses overlap exactly when FCL says so.

    Also thin rods and small gaps: fifteen axes see FCL's hits and no others.
    """
    from references import fcl

    answers, notes = Answers(), []
    for kind, pairs in _pose_families(run.fresh_rng(), run.count(300, 2_000, 50_000)).items():
        trusted = pairs.select(_beyond(fcl.MARGIN, pairs))
        truth = fcl.boxes_overlap(*trusted)
        answers.extend(sat_boxes.box_pairs_overlap(trusted.a, trusted.b), truth, kind=kind, **trusted._asdict())
        paper = sat_boxes.box_pairs_overlap(trusted.a, trusted.b, True)
        false = 100.0 * (paper & ~truth).sum()
        notes.append(
            f"{kind}: {false / max(1, paper.sum()):.1f} % of the hits of face normals alone are false, and"
            f" {false / max(1, (~truth).sum()):.1f} % of misses seem hits"
        )
    return answers.comparison(notes=notes)


@check(
    section="4.5",
    piece=PIECE,
    reference="exact rational arithmetic, rounded once",
    unit="of the size",
    kind="exact arithmetic",
    tolerance=4e-15,
    because="some twenty roundings of lengths up to three times the size",
    faults=(FOURTEEN_AXES,),
)
def separation_by_exact_arithmetic(run: Run) -> Comparison:
    """The gap or depth of boxes is exact arithmetic's over fifteen axes."""
    from references import exact

    pairs = random_box_pairs(run.fresh_rng(), run.count(200, 1_500, 50_000))
    found = separations(pairs)
    kinds = np.where(found < 0.0, "depth", "gap")
    return Comparison(found, exact.box_separation(*pairs), pairs.extent, kinds, inputs=pairs._asdict())


@check(
    section="4.5",
    piece=PIECE,
    reference="FCL contacts, whose code prefers a face unless an edge pair is shallower by a factor of 1.05",
    engines=("fcl",),
    unit="of the depth",
    tolerance=5e-11,
    because="rounding, 1e-15 of the size on both sides, of overlaps of at least 1e-3 of it: 8e-12 at worst; FCL's"
    " preference is allowed for as it is coded",
    faults=(
        Fault(
            "a normal from a to b",
            sat_boxes.box_box_separation,
            "1.0 if distance_ >= 0.0 else -1.0 → -1.0 if distance_ >= 0.0 else 1.0",
        ),
        Fault(
            "no normal where edges cross",
            sat_boxes.box_box_separation,
            "scale(1.0 if distance_ >= 0.0 else -1.0, direction_)"
            " → scale((1.0 if distance >= 0.0 else -1.0) if k < 6 else 0.0, direction)",
        ),
    ),
)
def contact_by_fcl(run: Run) -> Comparison:
    """Normal and depth of overlapping boxes are FCL's along the core's axis.

    Elsewhere FCL's contact is up to 5 % deeper. The core's depth, along its own normal, parts the boxes: their corners
    then just touch.
    """
    from scipy.spatial.transform import Rotation

    from references import fcl

    pairs = random_box_pairs(run.fresh_rng(), run.count(500, 4_000, 100_000))
    ours, normals, _ = map(np.array, zip(*box_separations(pairs)))
    deep = ours < -1e-3 * pairs.extent
    pairs, depth, normals = pairs.select(deep), -ours[deep], normals[deep]
    judged, theirs = fcl.box_contacts(*pairs)
    # FCL's normals point from a to b, the core's from b to a.
    along = (normals * theirs).sum(axis=1)
    # Within 1.4e-6 rad. Seen at full: an axis of FCL 4e-5 rad beside the one that exact arithmetic says is least.
    same = np.abs(along) > 1.0 - 1e-12
    ratio = judged / depth
    allowed, share = np.where(same, 1.0, np.clip(ratio, 1.0, 1.05)), 100.0 * (~same).mean()
    notes = [f"FCL takes another axis in {share:.1f} % of overlaps, up to {ratio.max():.4f} times as deep as the least"]
    # How deep the boxes overlap along the core's own normal, from their projections on it.
    reach = np.zeros(len(depth))
    for size, orientation in ((pairs.size_a, pairs.orientation_a), (pairs.size_b, pairs.orientation_b)):
        sides = Rotation.from_quat(orientation[:, [1, 2, 3, 0]]).inv().apply(normals)
        reach += 0.5 * (size * np.abs(sides)).sum(axis=1)
    overlap = reach - (normals * (pairs.position_a - pairs.position_b)).sum(axis=1)
    measured = np.column_stack([ratio, np.where(same, along, -np.linalg.norm(normals, axis=1)), overlap / depth])
    expected = np.column_stack([allowed, np.full(len(depth), -1.0), np.ones(len(depth))])
    groups = np.where(same, "same axis", "FCL takes another")
    return Comparison(measured, expected, groups=groups, notes=notes, inputs=pairs._asdict())


@check(
    section="4.5",
    piece=PIECE,
    reference="FCL distance with signed result",
    engines=("fcl",),
    unit="of the size",
    tolerance=1e-14,
    because="1.4e-15 at worst of ten seeds and at full; FCL is as near but for nearly parallel boxes, never drawn",
    faults=(FOURTEEN_AXES,),
)
def depth(run: Run) -> Comparison:
    """The depth of overlapping boxes is the least one that FCL finds."""
    from references import fcl

    pairs = random_box_pairs(run.fresh_rng(), run.count(1_000, 5_000, 100_000))
    ours = separations(pairs)
    judged = fcl.box_distance(*pairs)
    # For boxes apart, the distance is not along an axis of the test, and can only be larger.
    overlap = judged < 0.0
    pairs = pairs.select(overlap)
    return Comparison(ours[overlap], judged[overlap], pairs.extent, inputs=pairs._asdict())


@check(
    section="4.5",
    piece=PIECE,
    reference="FCL",
    engines=("fcl",),
    because="every axis that parts the boxes for six parts them for fifteen",
    faults=(LESS_REACH,),
    erratum=Misprint(
        "E12",
        "overlap if a point of one lies between two points of the other",
        "overlap if the intervals meet, whichever contains the other",
    ),
)
def paper_axes_never_miss(run: Run) -> Comparison:
    """The paper's six axes never miss an overlap, but see false ones."""
    from references import fcl, printed

    pairs = random_box_pairs(run.fresh_rng(), run.count(1_000, 10_000, 100_000), low=0.1, high=3.0)
    hits = pairs.select(fcl.boxes_overlap(*pairs))
    seen, one_way = sat_boxes.box_pairs_overlap(hits.a, hits.b, True), printed.boxes_overlap_one_way(*hits)
    return Comparison(seen, np.ones(len(seen), bool), printed=one_way, inputs=hits._asdict())


@check(
    section="4.5",
    piece=PIECE,
    reference="invariant: exchange, rotation, translation by 1 000 m",
    unit="of the size",
    kind="invariant",
    tolerance=4e-13,
    because="positions near 1 000 m are rounded to 1e-13 m",
    faults=(LESS_REACH,),
)
def invariance(run: Run) -> Comparison:
    """The separation of boxes depends on neither order, place nor orientation."""
    rng = run.fresh_rng()
    pairs = random_box_pairs(rng, run.count(500, 3_000, 30_000))
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
    answers, before = Answers(), separations(pairs)
    for kind, asked in (("exchanged", pairs.swapped()), ("moved", moved)):
        answers.extend(separations(asked), before, pairs.extent, kind, **asked._asdict())
    return answers.comparison()


def _product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return the Hamilton products of one quaternion and rows of others."""
    w = p[0] * q[:, 0] - q[:, 1:] @ p[1:]
    xyz = p[0] * q[:, 1:] + q[:, :1] * p[1:] + np.cross(p[1:], q[:, 1:])
    return np.column_stack([w, xyz])


@check(
    section="4.5",
    piece="softbody.collision.boxes.sat_boxes.box_pairs_separation",
    reference="corners and axes by NumPy",
    kind="closed form",
    unit="of the size",
    tolerance=1e-14,
    because="rounding of some dozen terms",
    faults=(
        Fault("no normal", sat_boxes.box_box_separation, "normal = scale(1.0 if distance_ >= 0.0 else -1.0, d_) → "),
        Fault("the number of the axis before", sat_boxes.box_box_separation, "best_axis = k → best_axis = k - 1"),
        Fault(
            "normals of many pairs a row late",
            sat_boxes.box_pairs_separation,
            "store(normals_, i_, normal_) → store(normals_, max(i_ - 1, 0), normal_)",
        ),
        Fault(
            "edges are taken where faces part boxes as well",
            sat_boxes.box_box_separation,
            "FACE_PREFERENCE * abs(best_) if edges_ else 0.0 → -FACE_PREFERENCE * abs(best_) if edges_ else 0.0",
        ),
    ),
)
def normals_and_axes(run: Run) -> Comparison:
    """Corners of boxes are as far apart along the normal as said.

    Or overlap by as much; the normal goes from b to a. It is the axis that is named: a face's, for boxes turned about
    an axis they share.
    """
    rng, count = run.fresh_rng(), run.count(300, 3_000, 30_000)
    anyhow = random_box_pairs(rng, count)
    sharing = _turned_about_an_axis_of_a(random_box_pairs(rng, count), rng)
    answers = Answers()
    for kind, pairs in (("turned anyhow", anyhow), ("turned about an axis they share", sharing)):
        found, normals, axes = sat_boxes.box_pairs_separation(pairs.a, pairs.b)
        named = [_along_axis(normals[i], int(axes[i]), pairs, i) for i in range(count)]
        is_face = (axes < 6) | (pairs is anyhow)
        measured = np.column_stack([found / pairs.extent, np.ones(count), is_face])
        expected = np.column_stack([gap_along(pairs, normals) / pairs.extent, named, np.ones(count)])
        answers.extend(measured, expected, kind=kind)
    return answers.comparison()


def _turned_about_an_axis_of_a(pairs: BoxPairs, rng: np.random.Generator) -> BoxPairs:
    """Return the pairs with b in the orientation of a, turned about an axis of both."""
    half, axis = 0.5 * rng.uniform(0.1, 1.4, len(pairs.size_a)), rng.integers(0, 3, len(pairs.size_a))
    turns = np.column_stack([np.cos(half), np.sin(half)[:, None] * np.eye(3)[axis]])
    turned = [_product(a, turn[None])[0] for a, turn in zip(pairs.orientation_a, turns)]
    return pairs._replace(orientation_b=np.array(turned))


def _along_axis(normal: np.ndarray, axis: int, pairs: BoxPairs, i: int) -> float:
    """Return the component of a normal along the axis of a number, either way, of pair i."""
    a, b = rotation_matrix(pairs.orientation_a[i]), rotation_matrix(pairs.orientation_b[i])
    named = np.hstack([a, b])[:, axis] if axis < 6 else np.cross(a[:, (axis - 6) // 3], b[:, (axis - 6) % 3])
    return float(abs(normal @ named) / np.linalg.norm(named))


@check(
    section="4.5",
    piece=PAIRS,
    reference="whole numbers",
    kind="exact arithmetic",
    faults=(
        Fault("boxes that touch are apart", sat_boxes.box_pairs_overlap, "separation_ <= 0.0 → separation_ < 0.0"),
        Fault(
            "the search ends where boxes touch along one axis",
            sat_boxes.box_box_separation,
            "any_gap and best > 0.0 → any_gap and best >= 0.0",
        ),
    ),
)
def upright_boxes_that_touch(run: Run) -> Comparison:
    """Upright boxes overlap or touch exactly if they do along each axis.

    Along x, y and z: half-integer places, whole sizes, a third of the pairs touching along an axis.
    """
    rng, count = run.fresh_rng(), run.count(1_000, 10_000, 100_000)
    size_a, size_b = rng.integers(1, 4, (2, count, 3))
    twice_a, twice_b = rng.integers(-3, 4, (2, count, 3))  # twice the places
    upright = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
    pairs = BoxPairs(size_a.astype(float), 0.5 * twice_a, upright, size_b.astype(float), 0.5 * twice_b, upright)
    room = np.abs(twice_a - twice_b) - (size_a + size_b)  # twice the gap along each axis
    touching = (room == 0).any(axis=1)
    kinds = np.where(touching, "touching along an axis", "clear")
    return Comparison(sat_boxes.box_pairs_overlap(pairs.a, pairs.b), (room <= 0).all(axis=1), groups=kinds)
