"""Claims that boxes pass what they do not touch, and hit what they would. On a World as it comes, also weightless."""

from __future__ import annotations

from functools import partial
from itertools import groupby
from operator import itemgetter
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from softbody import World
from softbody.collision.boxes import box_contacts, manifold, sat_boxes, swept_boxes
from softbody.geometry.box import box_corners
from validation.answers import Answers
from validation.arbitration import US, arbitrate
from validation.cases import corners_of, random_orientations
from validation.check import Comparison, Run, check
from validation.checks.boxes.cases import about, rotation, wxyz
from validation.fault import Fault

FAMILY = "boxes that pass"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

# Speeds [m/s] and steps [s], in all of which boxes go from 1 cm to 3 m a step.
PACES = [
    (v, h) for v in (1.0, 3.0, 10.0, 30.0, 100.0) for h in (1.0 / 30.0, 1.0 / 60.0, 1.0 / 240.0, 1e-3) if v * h >= 0.01
]
APART = 400.0  # [m] from pair to pair
MOST_IN_A_WORLD = 100
NEAREST = Fault(
    "boxes met where they are nearest, not where they will meet",
    manifold.swept_manifold,
    "_points_of_meeting(boxes_, pair_, sweep_, limits_, manifold_)"
    " → _points_of_overlap(boxes, pair, (separation, axis), limits, manifold)",
)
BALLS = Fault(
    "boxes that turn taken for balls", swept_boxes.come_near, "gap_ - pulled_ > closing_ * (1.0 - when_) → False"
)
OTHER_AXIS = Fault(
    "boxes that have passed on one axis met on another",
    swept_boxes.meeting_of,
    "best_.axis == NEVER or (acts_ and _fly_past(boxes_, pair_, sweep_, paper_, memory_)) → best_.axis == NEVER",
)
THROUGH = Fault(
    "boxes that meet and part within a step not seen",
    swept_boxes._fly_past,
    "enter_, leave_ = 0.0, 1.0 → enter, leave = 1.0, 1.0",
)
NO_EDGES = Fault("edges that never meet", manifold._points_of_meeting, "1 if gap_ <= most_ else 0 → 0")
FINE = 2e-3  # [m] that a box goes in a step of an engine, and [s], for it goes at 1 m/s
CLEAR = 1e-3  # [m] of overlap below which such a step may jump over it; single precision is good for 1e-5 m
SWEPT = "softbody.collision.boxes.manifold.swept_manifold"


class Pace(NamedTuple):
    """How fast a comes, in which steps, and whether both fall on their way."""

    speed: float  # [m/s]
    step: float  # [s]
    falls: bool


class Passing(NamedTuple):
    """A box a that flies by another one, b, or against it."""

    size: np.ndarray  # (2, 3) [m] of a and b
    orientation: np.ndarray  # (2, 4)
    offset: np.ndarray  # (3,) [m] from b to a, at the start
    way: np.ndarray  # (3,) unit: a's, seen from b
    spin: np.ndarray  # (3,) [rad/s] of a
    hull: tuple[np.ndarray, np.ndarray]  # size and orientation of a, or of a box that holds it however it turns


def corners(size: np.ndarray, orientation: np.ndarray) -> np.ndarray:
    """Return the corners (8, 3) [m] of a box about the origin."""
    return np.asarray(box_corners(tuple(size), (0.0, 0.0, 0.0), tuple(orientation)))


def passing(rng: np.random.Generator, air: float | None, turns: bool = False, often: float = 0.3) -> Passing:
    """Return a box that passes another one with so much `air` [m], or for None hits it somewhere, if only just.

    So `often` they are side by side, as boxes in games are.
    """
    size = np.exp(rng.uniform(-2.0, 0.7, (2, 3)))
    orientation, way = random_orientations(rng, 2), rng.normal(size=3)
    if rng.random() < often:
        orientation[:], way = (1.0, 0.0, 0.0, 0.0), np.eye(3)[rng.integers(3)] * rng.choice([-1.0, 1.0])
    way /= np.linalg.norm(way)
    across = np.cross(way, rng.permutation(np.eye(3))[0] + 1e-3 * way[[1, 2, 0]])
    across /= np.linalg.norm(across)
    a, b = (corners(size[k], orientation[k]) for k in range(2))
    spin, hull = np.zeros(3), (size[0], orientation[0])
    if turns:
        # A ball holds it, and a cube holds that, one axis of it across the way.
        spin = rng.uniform(0.0, 20.0) * rng.normal(size=3)
        frame = np.stack([across, way, np.cross(across, way)], axis=1)
        hull = np.full(3, np.linalg.norm(size[0])), wxyz(Rotation.from_matrix(frame))
        a = corners(*hull)
    apart = (b @ across).max() - (a @ across).min()
    offset = across * (apart + air if air is not None else apart * rng.uniform(-1.0, 1.0))
    return Passing(size, orientation, offset + way * ((b @ way).min() - (a @ way).max()), way, spin, hull)


def paces(count: int) -> list[Pace]:
    """Return the pace of each of so many cases; neighbours share one, and a world, up to a hundred of them.

    In two worlds of three both boxes fall alike, so that they pass each other as straight as without gravity.
    """
    together = min(MOST_IN_A_WORLD, -(-count // len(PACES)))
    turns = [k // together for k in range(count)]
    return [Pace(*PACES[turn % len(PACES)], falls=turn % 3 != 0) for turn in turns]


def in_doubt(count: int) -> np.ndarray:
    """Return the overlap [m] below which nobody can say whether the boxes of each case meet, for they fall unevenly."""
    return np.array([2.0 * 9.81 * pace.step**2 * pace.falls for pace in paces(count)])


def margin(count: int) -> np.ndarray:
    """Return the overlap [m] of each case, and the air, below which it is too close for engines."""
    return np.maximum(CLEAR, in_doubt(count))


def earlier(case: Passing, to_go: float, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """Return where a was [m], seen from b, and how it lay, when it had so many metres to go until it is beside b."""
    turn = Rotation.from_rotvec(-case.spin * to_go / speed) * rotation(case.orientation[0])
    return case.offset - to_go * case.way, wxyz(turn)


def add_pair(world: World, case: Passing, middle: np.ndarray, pace: Pace, rng: np.random.Generator) -> None:
    """Add a, up to three steps before it is beside b, and b, at `middle` [m], which may be held, or both may drift."""
    held = rng.random() < 0.5 and not pace.falls
    frame = np.zeros(3) if held else 0.3 * pace.speed * rng.normal(size=3)  # in which b rests
    offset, orientation = earlier(case, rng.uniform(0.5, 3.0) * pace.speed * pace.step, pace.speed)
    bounce, rub = rng.random(2) * (rng.random() < 0.5), rng.uniform(0.0, 1.0, 2)
    boxes: list[tuple[Any, ...]] = [
        (np.exp(rng.uniform(-2.0, 2.0)), middle + offset, orientation, frame + pace.speed * case.way, case.spin),
        (None if held else np.exp(rng.uniform(-2.0, 2.0)), middle, case.orientation[1], frame),
    ]
    for k, box in enumerate(boxes):
        world.add_box(case.size[k], *box, restitution=bounce[k], friction=rub[k])


def flown(cases: list[Passing], rng: np.random.Generator) -> np.ndarray:
    """Let each fly past the other in our World, at its pace; return whether (n,) any velocity changed."""
    changed: list[np.ndarray] = []
    for pace, group in groupby(zip(paces(len(cases)), cases), key=itemgetter(0)):
        world = World(gravity=(0.0, 0.0, -9.81 * pace.falls))
        for place, (_, case) in enumerate(group):
            add_pair(world, case, APART * np.array([place % 10, place // 10, 0.0]), pace, rng)
        velocity, spin = world.state.box_velocity.copy(), world.state.box_angular_velocity.copy()
        steps = int(8.0 / (pace.speed * pace.step)) + 5
        world.step(pace.step, steps)
        velocity += np.multiply(world.controls.gravity, pace.step * steps)
        rounding = pace.falls * steps * 1e-15 * (pace.speed + 9.81 * pace.step * steps)
        pushed = (np.abs(world.state.box_velocity - velocity) > rounding).any(axis=1)
        turned = (world.state.box_angular_velocity != spin).any(axis=1)
        changed.append((pushed | turned).reshape(-1, 2).any(axis=1))
    return np.concatenate(changed)


def overlap_of(cases: list[Passing]) -> np.ndarray:
    """Return by how much (n,) [m] the outlines overlap, by a closed form: negative where boxes pass."""
    from references.analytic import passing_overlap

    size = np.array([(case.hull[0], case.size[1]) for case in cases])
    orientation = np.array([(case.hull[1], case.orientation[1]) for case in cases])
    offset, way = np.array([case.offset for case in cases]), np.array([case.way for case in cases])
    return passing_overlap(size[:, 0], orientation[:, 0], size[:, 1], orientation[:, 1], offset, way)


def beside_outlines(cases: list[Passing], rng: np.random.Generator) -> Comparison:
    """Compare who is struck with whose outlines overlap.

    Where boxes fall, an overlap of less than two ways that gravity moves a box in a step is neither a hit nor a miss.
    """
    changed, overlap = flown(cases, rng), overlap_of(cases)
    clear = (overlap < -1e-9) | (overlap > in_doubt(len(cases)) + 1e-9)  # else rounding would decide
    return Comparison(changed[clear], overlap[clear] > 0.0)


def beside_engines(cases: list[Passing], rng: np.random.Generator, clear: np.ndarray) -> Comparison:
    """Compare who is struck, of the cases that are `clear` (n,), with who is struck in Bullet, and in Rapier."""
    from references import pybullet_world, rapier

    ours, overlap = flown(cases, rng)[clear], overlap_of(cases)[clear]
    theirs = {"pybullet": touched(pybullet_world, cases)[clear], "rapier3d": touched(rapier, cases)[clear]}
    answers = Answers()
    for name, struck in zip(("Bullet", "Rapier"), theirs.values()):
        answers.extend(ours, struck, kind=name)
    bullets, rapiers = (struck.sum() for struck in theirs.values())
    notes = [f"{ours.sum()} of {len(ours)} pairs are struck; Bullet {bullets}, Rapier {rapiers}"]
    asked = {
        name: np.array([getattr(case, name) for case in cases])[clear]
        for name in ("size", "orientation", "offset", "way", "spin")
    }
    # (Outlines are those of what holds a box that turns: whether that hits, they do not tell, only that it passes.)
    if (asked["spin"].any(axis=1) & (overlap > 0.0)).any():
        return answers.comparison(notes=notes)
    found = arbitrate("closed form", overlap > 0.0, {US: ours, **theirs}, inputs=asked)
    return answers.comparison(notes=notes, arbitrations=[found])


def turning(case: Passing, pace: Pace, rng: np.random.Generator) -> Passing:
    """Return the case with a spin about an axis of a's own, which every engine keeps, of 1 to 100 mrad a step."""
    axis = rotation(case.orientation[0]).apply(np.eye(3)[rng.integers(3)])
    return case._replace(spin=10.0 ** rng.uniform(-3.0, -1.0) / pace.step * axis)


def spinning(case: Passing, pace: Pace, rng: np.random.Generator) -> Passing:
    """Return the case with a spin about any axis, of 0.1 to 1 rad a step."""
    axis = rng.normal(size=3)
    return case._replace(spin=10.0 ** rng.uniform(-1.0, 0.0) / pace.step * axis / np.linalg.norm(axis))


def swollen(cases: list[Passing], by: np.ndarray) -> list[Passing]:
    """Return the cases with an a that reaches so much (n,) [m] farther to all sides."""
    return [case._replace(size=case.size + [[2.0 * more], [0.0]]) for case, more in zip(cases, by)]


def touched(engine: ModuleType, cases: list[Passing]) -> np.ndarray:
    """Let each fly past the other in an engine; return whether (n,) a velocity changed.

    There b rests (every other one is held), and a comes along x at 1 m/s, in steps of 2 mm, turned on its way as far as
    in our World. Whether they meet depends neither on the frame nor on the masses.
    """
    changed: list[np.ndarray] = []
    for start in range(0, len(cases), MOST_IN_A_WORLD):
        group = list(zip(paces(len(cases)), cases))[start : start + MOST_IN_A_WORLD]
        boxes = [box for k, (pace, case) in enumerate(group) for box in _in_frame(case, pace.speed, k)]
        size, mass, position, orientation, velocity, spin = (np.array(column) for column in zip(*boxes))
        steps = round(max(_way_past(case) for _, case in group) / FINE) + 10
        after = engine.velocities_after(size, mass, position, orientation, velocity, spin, FINE, steps)
        moved = np.abs(after[:, :3] - velocity).max(axis=1) > 1e-4
        changed.append(moved.reshape(-1, 2).any(axis=1))
    return np.concatenate(changed)


def _way_past(case: Passing) -> float:
    """Return how far [m] a flies while it is beside b."""
    return float(sum(np.ptp(corners(*box) @ case.way) for box in (case.hull, (case.size[1], case.orientation[1]))))


def _in_frame(case: Passing, speed: float, place: int) -> list[tuple[Any, ...]]:
    """Return size, mass, place, orientation, velocity and spin of a and b where a flies along x, 1 cm before b."""
    frame = Rotation.align_vectors([(1.0, 0.0, 0.0)], [case.way])[0]
    offset, orientation = earlier(case, 0.01, speed)
    a, b = wxyz(frame * rotation(np.array([orientation, case.orientation[1]])))
    middle = 20.0 * np.array([0.0, place % 10 - 4.5, place // 10 - 4.5])
    return [
        (case.size[0], 1.0, middle + frame.apply(offset), a, (1.0, 0.0, 0.0), frame.apply(case.spin / speed)),
        (case.size[1], 1.0 if place % 2 else np.inf, middle, b, np.zeros(3), np.zeros(3)),
    ]


by_outlines = partial(check, section="4.5", piece=SWEPT, engines=("scipy",), kind="closed form")
by_engines = partial(
    check,
    section="4.5",
    reference="the same boxes in Bullet and in Rapier, in steps of 2 mm",
    engines=("pybullet", "rapier3d", "scipy"),
)


@by_outlines(
    reference="closed form: the outlines of two boxes, seen along their relative motion, are apart",
    because="what is not touched is not struck",
    faults=(
        NEAREST,
        BALLS,
        OTHER_AXIS,
        Fault(
            "boxes that turn past each other not followed to the end",
            swept_boxes.come_near,
            "ADVANCES → ADVANCES // 20",
        ),
    ),
)
def near_misses(run: Run) -> Comparison:
    """Boxes that pass each other fly on as if each were alone.

    They have 1 mm to 10 cm of air, at 1 to 100 m/s and in steps of 1 ms to 1/30 s. They turn by up to 1 rad a step or
    not, and fall or not. Their velocities stay to the bit, or to rounding where they fall.
    """
    rng = run.fresh_rng()
    count = run.count(1600, 10_000, 40_000)
    cases = []
    for k, pace in enumerate(paces(count)):
        air = float(10.0 ** rng.uniform(-3.0, -1.0))
        if k % 4 == 1:  # side by side, with little air
            cases.append(spinning(passing(rng, 1e-3 * (100.0 * air) ** 0.5, turns=True, often=1.0), pace, rng))
        else:
            cases.append(passing(rng, air, turns=k % 4 == 3))
    return beside_outlines(cases, rng)


@by_outlines(
    reference="closed form: the outlines of two boxes, seen along their relative motion, overlap or are apart",
    because="a hit changes a velocity by far more than rounding",
    faults=(THROUGH, NO_EDGES),
)
def hits(run: Run) -> Comparison:
    """Boxes that do not turn are struck exactly if they meet.

    Else they fly on as if each were alone: at 1 to 100 m/s and in steps of 1 ms to 1/30 s. Without gravity it does not
    matter how little they would overlap; where they fall it is by 2 g h² or more.
    """
    rng = run.fresh_rng()
    return beside_outlines([passing(rng, None) for _ in range(run.count(600, 4000, 20_000))], rng)


@by_engines(piece=SWEPT, because="what is not touched is not struck, here or there", faults=(NEAREST, OTHER_AXIS))
def near_misses_by_engines(run: Run) -> Comparison:
    """Boxes that pass fly on alone, as in Bullet and Rapier.

    They have 1 mm to 10 cm of air, turn or not, and fall or not.
    """
    rng = run.fresh_rng()
    air = [float(10.0 ** rng.uniform(-3.0, -1.0)) for _ in range(run.count(170, 800, 4000))]
    cases = [passing(rng, gap, turns=k % 4 == 3) for k, gap in enumerate(air)]
    return beside_engines(cases, rng, np.ones(len(cases), bool))


@by_engines(
    piece=SWEPT,
    because="below 1 mm a step of 2 mm may jump over an overlap; beyond, both engines were right in 3 700 of 3 700",
    faults=(THROUGH, NO_EDGES),
)
def hits_by_engines(run: Run) -> Comparison:
    """Boxes without spin are struck exactly if engines let them meet.

    The engines are Bullet and Rapier. Left out are boxes that overlap by less than 1 mm, or in their fall by less than
    2 g h². So are those that pass with less than 1 mm of air.
    """
    rng = run.fresh_rng()
    count = run.count(170, 600, 4000)
    grazes = [passing(rng, -float(10.0 ** rng.uniform(-3.0, -1.0))) for _ in range(count // 2)]
    cases = [case for pair in zip(grazes, [passing(rng, None) for _ in grazes]) for case in pair]
    overlap = overlap_of(cases)
    return beside_engines(cases, rng, (overlap < -CLEAR) | (overlap > margin(len(cases))))


@by_engines(
    piece="softbody.collision.boxes.swept_boxes.come_near",
    because="no disagreement in 1 900 pairs; of 1 200 with 0.1 to 1 rad a step one is missed",
    faults=(BALLS, NO_EDGES),
)
def turning_hits_by_engines(run: Run) -> Comparison:
    """Turning boxes are struck exactly if engines let them meet.

    They turn about an axis of their own, by up to 0.1 rad a step; the engines are Bullet and Rapier. Left out are those
    for whom 1 mm more or less of one box (2 g h² where they fall) would decide.
    """
    from references import rapier

    rng = run.fresh_rng()
    count = run.count(68, 340, 2000)
    cases = [turning(passing(rng, None, turns=True), pace, rng) for pace in paces(count)]
    smaller, bigger = (touched(rapier, swollen(cases, sign * margin(count))) for sign in (-1.0, 1.0))
    return beside_engines(cases, rng, smaller == bigger)


class Pair(NamedTuple):
    """Two boxes that turn, fall and come from far, and the step [s] in which our World was wrong about them once."""

    step: float  # [s]
    size: np.ndarray  # (2, 3) [m]
    mass: np.ndarray  # (2,) [kg]
    offset: np.ndarray  # (3,) [m] from b to a
    orientation: np.ndarray  # (2, 4)
    velocity: np.ndarray  # (2, 3) [m/s]
    spin: np.ndarray  # (3,) [rad/s] of a


ONCE_WRONG = {
    "taken along the axis that parts them before": Pair(
        1.0 / 30.0,
        np.array([(0.23701, 1.0871, 0.38378), (0.26649, 0.9494, 0.41864)]),
        np.array([1.236, 0.4496]),
        np.array([10.39888, 1.69079, -0.0937]),
        np.array([(0.01496, -0.6013, -0.52227, -0.60452), (-0.03195, -0.44968, -0.88601, -0.10843)]),
        np.array([(-123.06471, -11.84429, 22.04035), (-24.48048, 4.21222, 17.20949)]),
        np.array([1.16795, 1.06626, -0.44111]),
    ),
    "corners taken to go straight": Pair(
        1.0 / 240.0,
        np.array([(0.22071, 0.18128, 0.21424), (0.81719, 1.83718, 0.17053)]),
        np.array([0.2373, 3.904]),
        np.array([0.0, -1.92169, -0.27791]),
        np.array([(0.99441, 0.00593, -0.10188, -0.02693), (1.0, 0.0, 0.0, 0.0)]),
        np.array([(-2.75227, 76.28266, -48.8954), (-2.75227, -23.71734, -48.8954)]),
        np.array([-1.44214, 24.75739, 6.54485]),
    ),
}
IN_STEPS = 10  # they are past each other, or have met


@by_engines(
    piece=SWEPT,
    because="the pairs meet, or pass, by more than a centimetre",
    faults=(
        Fault(
            "boxes that turn, and come from far, held along the axis that parts them before",
            manifold._points_of_turning,
            "overlap_[0] > sweep_.turn → False",
        ),
    ),
)
def once_wrong_by_engines(run: Run) -> Comparison:
    """Two pairs of boxes once misjudged meet or pass as in engines.

    One meets after 10 m in three steps, one passes by 14 mm, in Bullet and in Rapier. So it is from wherever they are
    looked at, and whichever of the two is the first.
    """
    from references import pybullet_world, rapier

    rng, answers = run.fresh_rng(), Answers()
    for kind, pair in ONCE_WRONG.items():
        speed = float(np.linalg.norm(pair.velocity[0] - pair.velocity[1]))
        for k in range(run.count(3, 10, 30)):
            turn = rotation(random_orientations(rng, 1)[0]) if k else Rotation.identity()
            place, velocity = turn.apply([pair.offset, np.zeros(3)]), turn.apply(pair.velocity)
            lie, spin = wxyz(turn * rotation(pair.orientation)), turn.apply([pair.spin, np.zeros(3)])
            ours = []
            for order in (slice(None), slice(None, None, -1)):  # whichever is the first
                world = World(gravity=turn.apply((0.0, 0.0, -9.81)))
                for box in list(zip(pair.size, pair.mass, place, lie, velocity, spin))[order]:
                    world.add_box(*box)
                world.step(pair.step, IN_STEPS)
                ours.append(_is_struck(velocity, world.state.box_velocity[order], 1e-9))
            # They need not fall: both do alike.
            flight, theirs = (place, lie, velocity - velocity[1], spin), []
            for engine in (pybullet_world, rapier):
                steps = round(IN_STEPS * pair.step * speed / FINE)
                after = engine.velocities_after(pair.size, pair.mass, *flight, FINE / speed, steps)
                theirs.append(_is_struck(flight[2], after[:, :3], 1e-2))  # Rapier is of single precision
            answers.extend(np.tile(ours, 2), np.repeat(theirs, 2), kind=kind)
    return answers.comparison()


def _is_struck(before: np.ndarray, after: np.ndarray, rounding: float) -> bool:
    """Tell whether the boxes' velocities (2, 3) [m/s], seen from each other, have changed."""
    return bool(np.abs((after[0] - after[1]) - (before[0] - before[1])).max() > rounding)


@check(
    section="4.5",
    piece="softbody.collision.boxes.swept_boxes.rests_on_face",
    reference="projections of all corners, by NumPy, and SciPy's rotations",
    kind="closed form",
    engines=("scipy",),
    unit="m, or yes and no",
    tolerance=5e-14,
    because="rounding: 2.2e-15 at worst of four seeds; left out are overlaps within 1e-9 m of that length, and normals"
    " whose cosine is from 0.98 to 0.99995, of which it does not matter whether they count as parallel",
    faults=(
        Fault("axes beyond the last", swept_boxes.project_travel, "range(3) → range(4)"),
        Fault("faces of a alone", swept_boxes.rests_on_face, "range(6) → range(3)"),
        Fault("edges as well", swept_boxes.rests_on_face, "range(6) → range(7)"),
        Fault("overlaps by half of it", swept_boxes.rests_on_face, "d_ > -least → d_ > -0.5 * least"),
    ),
)
def resting_by_projections(run: Run) -> Comparison:
    """Two boxes rest on a face if they overlap along all others.

    Of two boxes anyhow, a travel is seen from both. They rest exactly if they overlap by more than some length along
    all other faces' normals, but for those all but parallel to it. Asked as plain Python, which allows no index beside
    an array.
    """
    rng, answers = run.fresh_rng(), Answers()
    turns = Rotation.create_group("O")
    for trial in range(run.count(120, 600, 6_000)):
        size, travel = rng.uniform(0.3, 2.0, (2, 3)), rng.normal(size=3)
        orientation = random_orientations(rng, 2)
        if trial % 2:  # nearly as the other lies, any way up
            lean = Rotation.from_rotvec(10.0 ** rng.uniform(-3.0, -0.5) * rng.normal(size=3))
            orientation[1] = wxyz(rotation(orientation[0]) * lean * turns[int(rng.integers(24))])
        place = np.zeros((2, 3))
        place[1] = rng.uniform(0.0, 0.8) * rng.normal(size=3)
        boxes = sat_boxes.frames_of(sat_boxes.PlacedBoxes(size, place, orientation))
        memory = sat_boxes.SatMemory(np.zeros((3, 3)), np.zeros((2, 3)), np.zeros((2, 3)), np.zeros(3))
        sat_boxes.least_overlap(boxes, 0, 1, sat_boxes.Limits(np.inf, 0.0, True), memory)
        frames = [rotation(each).as_matrix() for each in orientation]
        axes = np.concatenate([frame.T for frame in frames])
        seen = _in_python(swept_boxes.project_travel, boxes, (0, 1), tuple(travel), memory)
        answers.extend(memory.travel.ravel() if seen is None else np.full(6, seen), axes @ travel, kind="travel")
        points = [x + corners_of(each) @ frame.T for x, each, frame in zip(place, size, frames)]
        one, other = (rows @ axes.T for rows in points)
        overlap = np.minimum(one.max(axis=0) - other.min(axis=0), other.max(axis=0) - one.min(axis=0))
        alike = np.abs(axes @ axes.T)
        for axis in range(6):
            least = rng.uniform(-0.2, 0.5)
            others = (alike[axis] < 0.99) & (np.arange(6) != axis)
            others[:3] |= (axis < 3) & (np.arange(3) != axis)
            others[3:] |= (axis >= 3) & (np.arange(3, 6) != axis)
            if np.abs(overlap[others] - least).min() < 1e-9 or (np.abs(alike[axis] - 0.99) < 0.00995).any():
                continue
            rests = (overlap[others] > least).all()
            said = _in_python(swept_boxes.rests_on_face, boxes, (0, 1), axis, least, memory)
            answers.add(float(said), float(rests), kind="rests" if rests else "does not rest")
    return answers.comparison()


def _in_python(kernel: Any, *asked: Any) -> Any:
    """Return what a kernel answers as plain Python, or NaN where it goes beside an array."""
    try:
        return getattr(kernel, "py_func", kernel)(*asked)
    except IndexError:
        return np.nan


@check(
    section="4.5",
    piece="softbody.collision.boxes.swept_boxes.meeting_of",
    reference="closed form: v(t) = v(0), ω = 0",
    unit="of the speed",
    kind="closed form",
    tolerance=3e-5,
    because="the solver ends when no speed changes by more than 1e-4 of what gravity adds in a step, 1.64e-5 m/s, and"
    " what that leaves of a lean adds up: 1.4e-5 at worst of ten seeds",
    faults=(
        Fault(
            "seams of tiles that are felt",
            swept_boxes.meeting_of,
            "graze_ if separation_ <= touching_ else apart_ → apart_",
        ),
        Fault(
            "boxes that slide along a face of their own",
            box_contacts._find_pair,
            "model_.box_inverse_mass[pair_[1]] == 0.0 → False",
        ),
    ),
)
def flush_tiles(run: Run) -> Comparison:
    """A smooth box slides over flush tiles as over one plate.

    It goes straight on, at its speed, with and without weight.
    """
    rng, answers = run.fresh_rng(), Answers()
    for k in range(run.count(8, 40, 200)):
        world = World(gravity=(0.0, 0.0, -9.81 if k % 2 else 0.0))
        tile = np.array([*rng.uniform(0.4, 1.5, 2), 0.5])
        for i, j in np.ndindex(14, 5):
            world.add_box(tile, None, ((i - 2) * tile[0], (j - 2) * tile[1], -0.25), friction=0.0)
        size, speed = rng.uniform(0.2, 0.8, 3), rng.uniform(1.0, 5.0)
        yaw = (0.0, 0.0, rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.02, 0.2))[k % 4]
        place = 0.0, rng.uniform(-0.2, 0.2), 0.5 * size[2]
        box = world.add_box(size, 1.0, place, about(2, yaw), (speed, 0.0, 0.0), friction=0.0)
        world.run(8.0 * tile[0] / speed, float(rng.choice([1.0 / 60.0, 1.0 / 240.0, 1e-3])))
        # The solver is judged where it works: at the corners that stand on the tiles.
        spin = box.angular_velocity * 0.5 * size[:2].min()
        asked: dict[str, Any] = {"size": size, "speed": speed, "tile": tile, "yaw": yaw}
        answers.add([*box.velocity / speed, *spin / speed], [1.0, 0.0, 0.0, 0.0, 0.0, 0.0], **asked)
    return answers.comparison()


@check(
    section="4.4, 4.5",
    piece="softbody.collision.boxes.swept_boxes.meeting_of",
    reference="closed form: v = 0 across, ω = 0, and what falls comes no nearer",
    unit="of the speed; without weight of a hundredth of it",
    kind="closed form",
    tolerance=1e-5,
    because="sweeps end where one corrects less than 1e-4 g h, 1.6e-5 m/s at 60 steps a second, of a speed of 1 m/s and"
    " more: 1.2e-7 at worst of ten seeds; a tilt of 1e-5 rad alone, without weight, leaves 3e-8",
    faults=(Fault("one point for a face", manifold._clip_faces, "kept < MOST_POINTS → kept < 1"),),
)
def flat_landings(run: Run) -> Comparison:
    """A box that lands flat gets no kick sideways and no spin.

    It comes down on another, turned and anywhere on it, but for a tilt of 1e-12 to 1e-5 rad. With weight and without,
    it is stopped in a step.
    """
    rng, answers = run.fresh_rng(), Answers()
    for k in range(run.count(200, 400, 4_000)):
        heavy, tilt = k % 2 == 0, 10.0 ** rng.uniform(-12.0, -5.0)
        world = World() if heavy else World(gravity=(0.0, 0.0, 0.0))
        yaws = rng.uniform(-np.pi, np.pi, 2) if k % 3 else rng.uniform(-1e-9, 1e-9, 2)
        h, speed = float(rng.choice([1.0 / 60.0, 1.0 / 240.0, 1e-3])), rng.uniform(1.0, 5.0)
        sizes = rng.uniform(0.5, 1.5, (2, 3))
        world.add_box(sizes[0], None, (0.0, 0.0, -0.5 * sizes[0][2]), about(2, yaws[0]))
        lean = rng.normal(size=2)
        lean *= 0.5 * tilt / np.linalg.norm(lean)
        turn = about(2, yaws[1]) + (0.0, *lean, 0.0)
        place = (*rng.uniform(-0.15, 0.15, 2), 0.5 * sizes[1][2] + rng.uniform(0.05, 0.95) * speed * h)
        box = world.add_box(sizes[1], 1.0, place, turn / np.linalg.norm(turn), (0.0, 0.0, -speed))
        world.step(h, 2)
        aside = [*box.velocity[:2], np.maximum(0.0, -box.velocity[2]), *(box.angular_velocity * sizes[1].max())]
        # Weight presses on what is solved by sweeps.
        scale, kind = (1.0, "with weight") if heavy else (0.01, "without")
        answers.add(np.array(aside) / speed, np.zeros(6), scale, kind)
    return answers.comparison()
