"""Claims about boxes that turn, tilt and lie in each other: strikes, and axes that part them."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from softbody import World
from softbody.collision.boxes import manifold, sat_boxes, swept_boxes
from validation.answers import Answers
from validation.cases import depths_of_boxes
from validation.check import Comparison, Run, check
from validation.checks.boxes.cases import any_turn, any_yaw, other_axes, renamed, wxyz
from validation.checks.boxes.passing import BALLS
from validation.fault import Fault

FAMILY = "boxes that pass"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

STEP = 1.0 / 60.0  # [s]
CASES = ("spins", "spins past", "is twisted from rest", "spins and is twisted")


def rise(angle: float, size: np.ndarray) -> float:
    """Return how far [m] the end of a box, of length size[0], rises as it turns by an angle about its middle."""
    return float(0.5 * size[0] * np.sin(angle) - 0.5 * size[2] * (1.0 - np.cos(angle)))


@check(
    section="4.5",
    piece="softbody.collision.boxes.swept_boxes.come_near",
    reference="closed form: how far an end rises by semi-implicit steps, ω + h I⁻¹ τ for a step",
    engines=("scipy",),
    kind="closed form",
    because="yes or no; gaps a hundredth and more from the limit",
    faults=(
        Fault(
            "a size for a spin",
            swept_boxes.come_near,
            "_turning_along(b.size, sweep.spin_b, normal) → _turning_along(sweep.spin_b, b.size, normal)",
        ),
        Fault("torques that turn nothing", swept_boxes.come_near, "near += max(0.0, sweep.turn - turning) → "),
        Fault(
            "a spin a hundredth faster",
            swept_boxes.come_near,
            "0.5 * (n_ * w_ + m_ * u_) → 0.505 * (n_ * w_ + m_ * u_)",
        ),
        BALLS,
    ),
)
def ends_that_rise(run: Run) -> Comparison:
    """The end of a turning box strikes what it rises to.

    It turns about its middle, by its spin, by a torque from rest, or by both. Its end strikes a box above it within the
    step exactly if it rises as far as that is away; to a hundredth, where nothing twists it. Boxes are of any shape,
    the other one fixed or very heavy, as the first or the second.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(80, 400, 4_000)):
        kind = CASES[trial % 4]
        # It turns about y. (A torque is taken to act about the axis that is turned most easily: here that is y.)
        length, wide = rng.uniform(0.5, 2.0), rng.uniform(1.0, 1.3)
        wide = wide if "twisted" in kind else 10.0 ** rng.uniform(-1.5, 0.0)
        size, mass = np.array([1.0, wide, rng.uniform(0.01, 0.05)]) * length, 10.0 ** rng.uniform(-1.0, 1.0)
        inertia = mass / 12.0 * (size[0] ** 2 + size[2] ** 2)
        spins = rng.uniform(0.05, 0.3) if "spins" in kind else 0.0
        twists = (spins / rng.uniform(20.0, 60.0) if spins else rng.uniform(0.01, 0.1)) if "twisted" in kind else 0.0
        free, whole = rise(spins, size), rise(spins + twists, size)
        gap = free * rng.uniform(1.01, 1.5) if "past" in kind else free + rng.uniform(0.03, 0.97) * (whole - free)
        gap = free * rng.uniform(0.5, 0.99) if kind == "spins" else gap
        block = np.array([0.4 * length, 2.0 * size[1], rng.uniform(0.1, 0.5) * length])
        above = np.array([0.5 * length, 0.0, 0.5 * (size[2] + block[2]) + gap])
        # All of it anyhow in the world, and the boxes' axes in any order.
        turn = any_turn(rng)
        boxes = [
            (*renamed(extent, turn, other_axes(rng)), turn.apply(place))
            for extent, place in ((size, np.zeros(3)), (block, above))
        ]
        world, is_fixed, is_second = World(gravity=(0.0, 0.0, 0.0)), trial // 4 % 2 == 0, trial // 8 % 2 == 1
        axis = turn.apply((0.0, -1.0, 0.0))
        for number in (1, 0) if is_second else (0, 1):
            own, q, place = boxes[number]
            if number:
                world.add_box(own, None if is_fixed else 1e6 * mass, place, q, restitution=0.5)
            else:
                ours = world.add_box(own, mass, place, q, angular_velocity=spins / STEP * axis, restitution=0.5)
                ours.apply_torque(twists / STEP**2 * inertia * axis)
        world.step(STEP)
        slower = (spins + twists) / STEP - ours.angular_velocity @ axis
        answers.add(bool(slower > 1e-6 * (spins + twists) / STEP), "past" not in kind, kind=kind)
    return answers.comparison()


def axes_of(turns: np.ndarray) -> np.ndarray:
    """Return the fifteen axes (15, 3) of two boxes, unit: their faces' normals, and of an edge of each; 0 of none."""
    edges = np.cross(turns[0].T[:, None], turns[1].T[None]).reshape(9, 3)
    lengths = np.linalg.norm(edges, axis=1, keepdims=True)
    return np.concatenate([turns[0].T, turns[1].T, np.where(lengths > 1e-6, edges / np.maximum(lengths, 1e-6), 0.0)])


def gaps_along(axes: np.ndarray, sizes: np.ndarray, turns: np.ndarray, apart: np.ndarray) -> np.ndarray:
    """Return the gap (15,) [m] between two boxes along each axis; −∞ of no axis."""
    reach = sum(0.5 * np.abs(axes @ turn) @ size for turn, size in zip(turns, sizes))
    return np.where(np.abs(axes).max(axis=1) > 0.0, np.abs(axes @ apart) - reach, -np.inf)


@check(
    section="4.5",
    piece="softbody.collision.boxes.sat_boxes.least_overlap",
    reference="that rule on gaps along fifteen axes, by NumPy",
    engines=("scipy",),
    kind="specification",
    unit="of a unit vector",
    tolerance=1e-12,
    because="rounding of a normal; axes are compared where they part by 1e-6 m more or less than they need, at least",
    faults=(
        Fault(
            "edges that may be worse",
            sat_boxes._best_edge_pair,
            "f_ * abs(best) + limits.slop + r_ → f_ * abs(best) - limits.slop + r_",
        ),
        Fault(
            "edges that need not be better",
            sat_boxes._best_edge_pair,
            "f_ * abs(best) + limits.slop + r_ → f_ * abs(best) + r_",
        ),
        Fault("the better face", sat_boxes._best_face, "limits.slop + rounding_of(size, a, b) → 0.0"),
        Fault("twice as much", sat_boxes._best_face, "limits.slop + rounding_of(size, a, b) → 2.0 * limits.slop"),
    ),
)
def axes_that_are_taken(run: Run) -> Comparison:
    """Boxes in each other part along the face that parts most.

    It is a face of the one that is fixed, or else of the later one. The other box's takes its place if that parts them
    by more than gravity moves a body in a step besides; and so does an edge of each. A World as it comes has steps in
    which that is a centimetre.
    """
    rng, slop, answers = run.fresh_rng(), 0.01, Answers()
    for _ in range(run.count(3, 12, 120)):
        world = World(gravity=slop / STEP**2 * any_turn(rng).apply((0.0, 0.0, 1.0)))
        rules: list[np.ndarray] = []
        kinds = []
        while len(rules) < 100:
            sizes, turns = rng.uniform(0.3, 1.2, (2, 3)), Rotation.random(2, random_state=rng)
            apart = rng.uniform(0.3, 0.8) * any_turn(rng).apply((0.0, 0.0, 1.0))
            fixed = (None, 0, 1)[int(rng.integers(3))]  # of the two, in the order in which they are added
            first = 1 if fixed is None else fixed
            order = [first, 1 - first]
            matrices = turns.as_matrix()[order]
            axes = axes_of(matrices)
            gaps = gaps_along(axes, sizes[order], matrices, apart)
            own, others, edges = (int(part[0] + gaps[part].argmax()) for part in np.split(np.arange(15), (3, 6)))
            face = others if gaps[others] > gaps[own] + slop else own
            taken = edges if gaps[edges] > gaps[face] + slop else face
            doubts = [gaps[others] - gaps[own] - slop, gaps[edges] - gaps[face] - slop]
            best_edges = np.sort(gaps[6:])
            alike = np.abs(axes[edges] @ axes[:6].T).max() > 1.0 - 1e-5  # (edges along a face's normal: its points)
            if gaps.max() > -0.03 or np.abs(doubts).min() < 1e-6 or best_edges[-1] - best_edges[-2] < 1e-6 or alike:
                continue
            middle = np.array([20.0 * (len(rules) % 10), 20.0 * (len(rules) // 10), 0.0])
            for k in range(2):
                place = middle + (0.0 if k else 1.0) * apart
                world.add_box(sizes[k], None if fixed == k else 1.0, place, wxyz(turns[k]))
            rules.append(axes[taken])
            kinds.append("an edge of each" if taken >= 6 else "a face of the first" if taken < 3 else "of the second")
        world.step(STEP)
        contacts = world.store.contacts
        normals = np.zeros((100, 3))
        for row in range(contacts.number[0]):
            normals[contacts.box[row].max() // 2] = contacts.normal[row]
        answers.extend(np.abs((normals * np.array(rules)).sum(axis=1)), np.ones(100), kind=kinds)
    return answers.comparison()


def over(rng: np.random.Generator, sizes: np.ndarray, tilt: float, most: float) -> tuple[float, np.ndarray]:
    """Return the speed [m/s] of a box that comes down on another, and where it is [m], `most` of a step's way above."""
    speed = rng.uniform(1.0, 5.0)
    aside = rng.uniform(-0.7, 0.7, 2) * (sizes[0, :2] + sizes[1, :2]) / 2.0
    above = 0.5 * sizes[:, 2].sum() + tilt * sizes[1].sum() + rng.uniform(0.1, most) * speed * STEP
    return speed, np.array([*aside, above])


def leaning(tilt: float, way: float) -> Rotation:
    """Return a turn by a small angle about the horizontal axis that points some way."""
    return Rotation.from_rotvec(tilt * np.array([np.cos(way), np.sin(way), 0.0]))


@check(
    section="4.5",
    piece="softbody.collision.boxes.swept_boxes.meeting_of",
    reference="gaps along fifteen axes and how fast they close, by NumPy: those in which edges meet last",
    engines=("scipy",),
    kind="specification",
    unit="of a unit vector",
    tolerance=1e-12,
    because="rounding of a normal; edges are off a face's by 1e-9 and more",
    faults=(
        Fault(
            "the normal of two edges",
            swept_boxes.meeting_of,
            "write_normal(boxes_, pair_, best.axis, memory_) → write_normal(boxes_, pair_, 6, memory_)",
        ),
    ),
)
def as_good_as_flat(run: Run) -> Comparison:
    """A box as good as flat touches another along a face.

    It comes down on a fixed one, its edges within a thousandth of a radian of flat and beside the other's. Though they
    meet a little later than the faces, it touches it along a face of one of the two. They are turned anyhow about their
    common normal, and in the world.
    """
    rng, answers = run.fresh_rng(), Answers()
    while len(answers) < run.count(60, 300, 3_000):
        sizes, tilt = rng.uniform(0.3, 1.0, (2, 3)), rng.uniform(1e-4, 9e-4)
        yaw, way = any_yaw(rng), rng.uniform(-np.pi, np.pi)
        turns = [Rotation.identity(), leaning(tilt, way) * yaw]
        speed, apart = over(rng, sizes, tilt, 0.9)
        matrices = np.array([turn.as_matrix() for turn in turns])
        axes = axes_of(matrices)
        gaps, closing = gaps_along(axes, sizes, matrices, apart), np.abs(axes[:, 2]) * speed * STEP
        flat = np.abs(axes[6:] @ axes[[2, 5]].T).min(axis=1) > 1.0 - 0.4e-6
        enter = np.where(np.abs(axes[:, 2]) > 0.5, gaps / np.maximum(closing, 1e-9), -np.inf)
        faces_meet, edges_meet = enter[:6].max(), enter[6:].max()
        beside = (gaps[np.abs(axes[:, 2]) < 0.5] < -1e-3).all()  # and it does not pass it
        if not (beside and faces_meet + 1e-7 < edges_meet < 0.95 and flat[enter[6:] > faces_meet].all()):
            continue
        turn, world, is_second, boxes = any_turn(rng), World(gravity=(0.0, 0.0, 0.0)), rng.random() < 0.5, []
        for k in range(2):
            own, q = renamed(sizes[k], turn * turns[k], other_axes(rng))
            boxes.append((own, 1.0 if k else None, turn.apply(k * apart), q, turn.apply((0.0, 0.0, -speed * k))))
        for each in boxes[::-1] if is_second else boxes:
            world.add_box(*each)
        world.step(STEP)
        normal = world.store.contacts.normal[0] if world.store.contacts.number[0] else np.zeros(3)
        faces = turn.apply(np.concatenate([matrices[0].T, matrices[1].T]))
        kind = "the fixed one second" if is_second else "the fixed one first"
        answers.add(np.abs(faces @ normal).max(), 1.0, kind=kind)
    return answers.comparison()


@check(
    section="4.5",
    piece="softbody.World.step",
    reference="FCL",
    engines=("fcl",),
    unit="of a step's way",
    tolerance=0.1,
    because="a box turns within the step, about the point that comes down first, by up to 0.2 rad: its corners do not"
    " go straight; 0.035 at ten seeds, and the whole way where a point is missed",
    faults=(
        Fault("one point for all", manifold._points_all_but_flat, "most_ < ALL_BUT_FLAT → True"),
        Fault("all but flat to a fiftieth of that", manifold._points_all_but_flat, "ALL_BUT_FLAT → 0.99999"),
        Fault("the face across", manifold._points_all_but_flat, "along_ > most_ → along < most or most == 0.0"),
    ),
)
def however_tilted(run: Run) -> Comparison:
    """A tilted box that comes down is not inside the other.

    It comes down on a fixed one, tilted by a thousandth of a degree to 2°, over its face or its rim. FCL looks after
    the step in which they meet.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(150, 600, 6_000)):
        sizes, tilt = rng.uniform(0.3, 1.0, (2, 3)), 10.0 ** rng.uniform(-4.7, -1.5)
        turn = leaning(tilt, rng.uniform(-np.pi, np.pi)) * any_yaw(rng)
        speed, place = over(rng, sizes, tilt, 0.6)
        world = World(gravity=(0.0, 0.0, 0.0))
        world.add_box(sizes[0], None)
        world.add_box(sizes[1], 1.0, place, wxyz(turn), (0.0, 0.0, -speed))
        world.step(STEP)
        answers.add(depths_of_boxes(world)[0] / (speed * STEP), 0.0)
    return answers.comparison()
