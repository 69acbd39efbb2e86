"""Do boxes pass what they do not touch, and hit what they would hit? On a World as it comes, and without gravity."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody import World
from softbody.collision import manifold, swept_boxes
from softbody.geometry.box import box_corners
from validation.cases import random_orientations
from validation.check import DISAGREEMENTS, Comparison, Run, check
from validation.fault import Fault

FAMILY = "boxes that pass"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

# Speeds [m/s] and steps [s], in all of which boxes go from 1 cm to 3 m a step.
PACES = [
    (v, h) for v in (1.0, 3.0, 10.0, 30.0, 100.0) for h in (1.0 / 30.0, 1.0 / 60.0, 1.0 / 240.0, 1e-3) if v * h >= 0.01
]
APART = 400.0  # [m] from pair to pair
MOST_IN_A_WORLD = 100


class Passing(NamedTuple):
    """A box a that flies by another one, b, or against it."""

    size: np.ndarray  # (2, 3) [m] of a and b
    orientation: np.ndarray  # (2, 4)
    offset: np.ndarray  # (3,) [m] from b to a, at the start
    way: np.ndarray  # (3,) unit: a's, seen from b
    spin: np.ndarray  # (3,) [rad/s] of a
    hull: tuple[
        np.ndarray, np.ndarray
    ]  # size and orientation of a box that holds a however it turns; a, if it does not


def corners(size: np.ndarray, orientation: np.ndarray) -> np.ndarray:
    """Return the corners (8, 3) [m] of a box about the origin."""
    return np.asarray(box_corners(tuple(size), (0.0, 0.0, 0.0), tuple(orientation)))


def passing(rng: np.random.Generator, air: float | None, turns: bool = False) -> Passing:
    """Return a box that passes another one with so much `air` [m], or for None hits it somewhere, if only just."""
    size = np.exp(rng.uniform(-2.0, 0.7, (2, 3)))
    orientation, way = random_orientations(rng, 2), rng.normal(size=3)
    if rng.random() < 0.3:  # side by side, as boxes in games are
        orientation[:], way = (1.0, 0.0, 0.0, 0.0), np.eye(3)[rng.integers(3)] * rng.choice([-1.0, 1.0])
    way /= np.linalg.norm(way)
    across = np.cross(way, rng.permutation(np.eye(3))[0] + 1e-3 * way[[1, 2, 0]])
    across /= np.linalg.norm(across)
    a, b = (corners(size[k], orientation[k]) for k in range(2))
    spin, hull = np.zeros(3), (size[0], orientation[0])
    if turns:
        from scipy.spatial.transform import Rotation

        # A ball holds it, and a cube holds that, one axis of it across the way.
        spin = rng.uniform(0.0, 20.0) * rng.normal(size=3)
        frame = np.stack([across, way, np.cross(across, way)], axis=1)
        hull = np.full(3, np.linalg.norm(size[0])), Rotation.from_matrix(frame).as_quat()[[3, 0, 1, 2]]
        a = corners(*hull)
    apart = (b @ across).max() - (a @ across).min()
    offset = across * (apart + air if air is not None else apart * rng.uniform(-1.0, 1.0))
    return Passing(size, orientation, offset + way * ((b @ way).min() - (a @ way).max()), way, spin, hull)


def flown(cases: list[Passing], rng: np.random.Generator) -> tuple[list[bool], list[bool]]:
    """Let all fly, a hundred at one pace; return whether any velocity changed, and whether it should have.

    In two worlds of three both boxes fall alike, so that they pass each other as straight as without gravity. Where
    boxes fall, an overlap of less than two ways that gravity moves a box in a step is neither a hit nor a miss.
    """
    from references.analytic import passing_overlap

    changed: list[bool] = []
    doubt: list[float] = []
    for turn, start in enumerate(range(0, len(cases), MOST_IN_A_WORLD)):
        speed, h = PACES[turn % len(PACES)]
        falls = turn % 3 != 0
        world, given = World() if falls else World(gravity=(0.0, 0.0, 0.0)), []
        for place, case in enumerate(cases[start : start + MOST_IN_A_WORLD]):
            middle = APART * np.array([place % 10, place // 10, 0.0])
            held = rng.random() < 0.5 and not falls
            frame = np.zeros(3) if held else 0.3 * speed * rng.normal(size=3)  # in which b rests
            lead = rng.uniform(0.5, 3.0) * speed * h
            position = middle + case.offset - lead * case.way
            velocity = frame + speed * case.way
            bounce, rub = rng.random(2), rng.uniform(0.0, 1.0, 2)
            a = world.add_box(
                case.size[0], np.exp(rng.uniform(-2.0, 2.0)), position, case.orientation[0], velocity, case.spin,
                restitution=bounce[0], friction=rub[0],
            )  # fmt: skip
            b = world.add_box(
                case.size[1], None if held else np.exp(rng.uniform(-2.0, 2.0)), middle, case.orientation[1], frame,
                restitution=bounce[1], friction=rub[1],
            )  # fmt: skip
            given.append(((a, velocity, case.spin), (b, frame, np.zeros(3))))
        steps = int(8.0 / (speed * h)) + 5
        world.step(h, steps)
        fall = np.array([0.0, 0.0, -9.81 if falls else 0.0]) * h * steps
        changed += [
            any(
                (np.abs(box.velocity - fall - velocity) > steps * 1e-15 * (speed - fall[2]) * falls).any()
                or (box.angular_velocity != spin).any()
                for box, velocity, spin in pair
            )
            for pair in given
        ]
        doubt += [2.0 * 9.81 * h * h * falls + 1e-9] * len(given)
    size, q = np.array([case.hull[0] for case in cases]), np.array([case.hull[1] for case in cases])
    size_b, q_b = np.array([case.size[1] for case in cases]), np.array([case.orientation[1] for case in cases])
    offset, way = np.array([case.offset for case in cases]), np.array([case.way for case in cases])
    overlap = passing_overlap(size, q, size_b, q_b, offset, way)
    clear = (overlap < -1e-9) | (overlap > doubt)  # else rounding would decide
    return [bool(c) for c in np.array(changed)[clear]], [bool(c) for c in overlap[clear] > 0.0]


@check(
    family=FAMILY,
    claim="Boxes that pass each other with 1 mm to 10 cm of air, turning or not, falling or not, at 1 to 100 m/s and "
    "in steps of 1 ms to 1/30 s, fly on as if each were alone: to the bit, or to rounding where they fall.",
    section="4.5",
    piece="softbody.collision.manifold.swept_manifold",
    reference="closed form: the outlines of two boxes, seen along their relative motion, are apart",
    engines=("scipy",),
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="what is not touched is not struck",
    detects="one ghost of 10 000",
    faults=(
        Fault(
            "boxes met where they are nearest, not where they will meet",
            manifold.swept_manifold,
            "_points_of_meeting(boxes_, pair_, sweep_, limits_, manifold_)",
            "_points_of_overlap(boxes, pair, (separation, axis), limits, manifold)",
        ),
        Fault(
            "boxes that turn taken for balls",
            swept_boxes.come_near,
            "gap_ - pulled_ > closing_ * (1.0 - when_)",
            "False",
        ),
        Fault(
            "boxes that have passed on one axis met on another",
            swept_boxes.meeting_of,
            "best_.axis == NEVER or (acts_ and _fly_past(boxes_, pair_, sweep_, paper_, memory_))",
            "best_.axis == NEVER",
        ),
    ),
)
def near_misses(run: Run) -> Comparison:
    rng = run.fresh_rng()
    count = run.count(1600, 10_000, 40_000)
    air = [float(10.0 ** rng.uniform(-3.0, -1.0)) for _ in range(count)]
    return Comparison(*flown([passing(rng, gap, turns=k % 4 == 3) for k, gap in enumerate(air)], rng))


@check(
    family=FAMILY,
    claim="Boxes that do not turn fly on as if each were alone if, and only if, they do not meet, at 1 to 100 m/s and "
    "in steps of 1 ms to 1/30 s: without gravity however little they would overlap, else by 2 g h² or more.",
    section="4.5",
    piece="softbody.collision.manifold.swept_manifold",
    reference="closed form: the outlines of two boxes, seen along their relative motion, overlap or are apart",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="a hit changes a velocity by far more than rounding",
    detects="one hit of 3 000 that is missed",
    faults=(
        Fault(
            "boxes that meet and part within a step not seen",
            swept_boxes._fly_past,
            "enter_, leave_ = 0.0, 1.0",
            "enter, leave = 1.0, 1.0",
        ),
        Fault("edges that never meet", manifold._points_of_meeting, "1 if gap_ <= most_ else 0", "0"),
    ),
)
def hits(run: Run) -> Comparison:
    rng = run.fresh_rng()
    cases = [passing(rng, None) for _ in range(run.count(600, 4000, 20_000))]
    return Comparison(*flown(cases, rng))


@check(
    family=FAMILY,
    claim="A smooth box slides over flush tiles, with and without weight, as over one plate: straight on, at its "
    "speed.",
    section="4.5",
    piece="softbody.collision.swept_boxes.meeting_of",
    reference="closed form: v(t) = v(0), ω = 0",
    unit="of the speed",
    tolerance=1.7e-4,
    because="the solver ends when no speed changes by more than 1e-3 of what gravity adds in a step: 1.64e-4 of 1 m/s",
    detects="a seam that is felt as an edge",
    faults=(
        Fault(
            "seams of tiles that are felt",
            swept_boxes.meeting_of,
            "graze_ if separation_ <= touching_ else apart_",
            "apart_",
        ),
    ),
)
def flush_tiles(run: Run) -> Comparison:
    rng = run.fresh_rng()
    measured, expected = [], []
    for k in range(run.count(8, 40, 200)):
        world = World(gravity=(0.0, 0.0, -9.81 if k % 2 else 0.0))
        tile = np.array([*rng.uniform(0.4, 1.5, 2), 0.5])
        for i in range(-2, 12):
            for j in range(-2, 3):
                world.add_box(tile, None, (i * tile[0], j * tile[1], -0.25), friction=0.0)
        size, speed, yaw = (
            rng.uniform(0.2, 0.8, 3),
            rng.uniform(1.0, 5.0),
            rng.uniform(0.0, 2.0 * np.pi) if k % 4 > 1 else 0.0,
        )
        velocity = np.array([speed, 0.0, 0.0])
        box = world.add_box(
            size, 1.0, (0.0, rng.uniform(-0.2, 0.2), 0.5 * size[2]), (np.cos(0.5 * yaw), 0.0, 0.0, np.sin(0.5 * yaw)),
            velocity, friction=0.0,
        )  # fmt: skip
        world.run(8.0 * tile[0] / speed, float(rng.choice([1.0 / 60.0, 1.0 / 240.0, 1e-3])))
        measured.append([*box.velocity / speed, *box.angular_velocity * size.max() / speed])
        expected.append([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    return Comparison(measured, expected)
