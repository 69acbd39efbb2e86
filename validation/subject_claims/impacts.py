"""Boxes that strike each other, walls, plates and the ground, and boxes that do not."""

from __future__ import annotations

import numpy as np

from validation.cases import random_orientations
from validation.check import DISAGREEMENTS, Comparison, Run
from validation.subject import asks
from validation.subject_claims.boxes import COULOMB, HELD, STILL, Answer, boxes
from validation.subject_claims.heaps import became

FAMILY = "hits and misses"
IMPACT = "closed form: central impact"
SWEEPS = "sweeps over four corners that say the same: 3e-5 at worst, as of `meet_face_to_face`"
STEP = 1.0 / 240.0  # [s]


def row_of(masses: np.ndarray, gaps: np.ndarray, side: float, speed: float) -> list[tuple]:
    """Return cubes in a row along x, the first of which flies at the others, at rest behind each other."""
    places = np.cumsum([0.0, *(side + gaps)])
    speeds = [speed] + [0.0] * (len(masses) - 1)
    return [((side,) * 3, m, (x, 0.0, 0.0), STILL, (v, 0.0, 0.0)) for m, x, v in zip(masses, places, speeds)]


@asks(
    "move_boxes",
    roundings=600 * 4,
    reference=IMPACT,
    unit="of the first speed",
    tolerance=7e-4,
    because=f"seven impacts at most, each at 1e-4: {SWEEPS}",
)
def cradle(run: Run, move: Answer) -> Comparison:
    """Newton's cradle: the last of equal boxes flies off, the others stop.

    Three to eight boxes in a row, 1 mm to 5 cm apart, without loss.
    """
    rng, measured, expected = run.fresh_rng(), [], []
    for count in range(3, 3 + run.count(6, 6, 6)):
        side, speed, gaps = rng.uniform(0.2, 1.0), rng.uniform(1.0, 10.0), rng.uniform(1e-3, 0.05, count - 1)
        steps = int(gaps.sum() / speed / STEP) + 3 * count
        end = move(boxes(*row_of(np.ones(count), gaps, side, speed), restitution=1.0), STEP, steps, steps)
        measured.append([*end.velocity[-1, [0, -2, -1], 0] / speed, np.abs(end.velocity[-1, 1:-1]).max() / speed])
        expected.append([0.0, 0.0, 1.0, 0.0])
    return Comparison(np.array(measured), np.array(expected))


@asks(
    "move_boxes",
    roundings=600 * 4,
    reference=IMPACT,
    unit="of the last speed",
    tolerance=4e-4,
    because=f"four impacts, each at 1e-4: {SWEEPS}",
)
def chain(run: Run, move: Answer) -> Comparison:
    """A blow down a row of lighter and lighter boxes grows as it goes.

    Each of five boxes has q of the mass before it, q < e, and flies off with (1 + e) / (1 + q) of the speed before it.
    """
    rng, measured, expected, scale = run.fresh_rng(), [], [], []
    for _ in range(run.count(6, 30, 200)):
        e = rng.uniform(0.5, 1.0)
        q, speed, gaps = e * rng.uniform(0.3, 0.9), rng.uniform(0.5, 2.0), rng.uniform(0.02, 0.1, 4)
        struck = speed * ((1.0 + e) / (1.0 + q)) ** np.arange(5)  # [m/s] of each before it strikes the next
        steps = int((gaps / struck[:4]).sum() / STEP) + 15
        end = move(boxes(*row_of(q ** np.arange(5.0), gaps, 0.5, speed), restitution=e), STEP, steps, steps)
        measured.append(end.velocity[-1, :, 0])
        expected.append([*struck[:4] * (1.0 - e * q) / (1.0 + q), struck[4]])
        scale.append(struck[4])
    return Comparison(np.array(measured), np.array(expected), np.array(scale))


@asks(
    "move_boxes",
    roundings=100 * 4,
    reference=COULOMB,
    unit="of the speed",
    tolerance=1e-4,
    because=SWEEPS,
)
def strike_aslant(run: Run, move: Answer) -> Comparison:
    """A flat box that strikes the ground aslant does not turn.

    It leaves at e v_n, and loses μ (1 + e) v_n of its speed along the ground, or all of it.
    """
    rng, measured, expected, scale, kinds = run.fresh_rng(), [], [], [], []
    for k in range(run.count(8, 40, 400)):
        e, friction, down = rng.random(), rng.uniform(0.1, 0.8), rng.uniform(0.5, 5.0)
        most, angle = friction * (1.0 + e) * down, rng.uniform(0.0, 2.0 * np.pi)
        along = most * (rng.uniform(1.1, 3.0) if k % 2 else rng.uniform(0.2, 0.9))
        way, size = np.array([np.cos(angle), np.sin(angle), 0.0]), rng.uniform([0.8, 0.8, 0.05], [1.2, 1.2, 0.15])
        ground = (200.0, 200.0, 2.0), HELD, (0.0, 0.0, -1.0)
        box = size, 1.0, (0.0, 0.0, 0.5 * size[2] + 0.1), STILL, along * way - [0.0, 0.0, down]
        steps = int(0.1 / down / STEP) + 8
        end = move(boxes(ground, box, friction=friction, restitution=e), STEP, steps, steps)
        measured.append(np.concatenate([end.velocity[-1, 1], end.spin[-1, 1]]))
        expected.append([*(max(0.0, along - most) * way)[:2], e * down, 0.0, 0.0, 0.0])
        scale.append(np.hypot(along, down))
        kinds.append("slides on" if k % 2 else "stops along it")
    return Comparison(np.array(measured), np.array(expected), np.array(scale), kinds)


@asks("move_boxes", roundings=100 * 4, reference=IMPACT, unit="of the speed", tolerance=1e-4, because=SWEEPS)
def rebound(run: Run, move: Answer) -> Comparison:
    """A box comes back from a wall at e v, at 1 to 300 m/s.

    Steps of 1/240 s, in which it goes up to six times its size and the wall's thickness.
    """
    rng, measured, expected, scale, kinds = run.fresh_rng(), [], [], [], []
    for k in range(run.count(6, 40, 400)):
        speed, e, side = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0)[k % 6], rng.uniform(0.2, 1.0), rng.uniform(0.15, 0.4)
        gap = speed * rng.uniform(0.02, 0.1)
        wall = (0.2, 4.0, 4.0), HELD, (gap + 0.1 + 0.5 * side, 0.0, 0.0)
        box = (side, 0.3, 0.2), 1.0, (0.0, 0.0, 0.0), STILL, (speed, 0.0, 0.0)
        steps = int(gap / speed / STEP) + 12
        end = move(boxes(wall, box, restitution=e), STEP, steps, steps)
        measured.append(np.concatenate([end.velocity[-1, 1], end.spin[-1, 1]]))
        expected.append([-e * speed, 0.0, 0.0, 0.0, 0.0, 0.0])
        scale.append(speed)
        kinds.append(f"{speed:g} m/s")
    return Comparison(np.array(measured), np.array(expected), np.array(scale), kinds)


@asks(
    "move_boxes",
    reference="closed form: what is in the way stops, what is not does not",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="a yes-or-no answer; what passes has 1 cm of air, what is stopped meets a plate of 4 m in its middle",
)
def thin_plate(run: Run, move: Answer) -> Comparison:
    """No box goes through a plate of 1 mm, at 1 to 100 m/s.

    Turned anyhow and spinning, e = 0.5. Half of the plates are out of its way.
    """
    rng, measured, expected, kinds = run.fresh_rng(), [], [], []
    count = run.count(12, 60, 600)
    for k, turn in enumerate(random_orientations(rng, count)):
        speed, size = (1.0, 3.0, 10.0, 30.0, 60.0, 100.0)[k // 2 % 6], rng.uniform(0.1, 0.4, 3)
        reach = 0.5 * np.linalg.norm(size)
        aside = 2.0 + reach + 0.01 if k % 2 else 0.0
        gap = reach + speed * rng.uniform(0.02, 0.1)
        plate = (1e-3, 4.0, 4.0), HELD, (gap, aside, 0.0)
        box = size, 1.0, (0.0, 0.0, 0.0), turn, (speed, 0.0, 0.0), rng.normal(size=3)
        steps = int((gap + reach) / speed / STEP) + 12
        end = move(boxes(plate, box, restitution=0.5), STEP, steps, steps)
        measured.append(became(end, int(end.position[-1, 1, 0] > gap)))
        expected.append(k % 2)
        kinds.append(f"{speed:g} m/s")
    return Comparison(np.array(measured), np.array(expected), groups=kinds)


@asks(
    "move_boxes",
    roundings=100 * 4,
    reference=IMPACT,
    unit="of the closing speed",
    tolerance=1e-4,
    because=f"{SWEEPS}; places are rounded at 1e-11 m",
)
def far_away(run: Run, move: Answer) -> Comparison:
    """Boxes meet 1 to 1 000 km from the origin as they do there."""
    rng, measured, expected, scale, kinds = run.fresh_rng(), [], [], [], []
    for k in range(run.count(6, 40, 400)):
        away = (1e3, 1e4, 1e6)[k % 3]
        origin = away * (unit := rng.normal(size=3)) / np.linalg.norm(unit)
        side, e, speed, gap = rng.uniform(0.3, 0.6), rng.random(), 10.0 ** rng.uniform(0.0, 1.0), rng.uniform(0.05, 0.5)
        (m, n), drift = np.exp(rng.uniform(-2.0, 2.0, 2)), rng.uniform(-1.0, 1.0, 3)
        rows = [
            ((side,) * 3, m, origin, STILL, drift + [speed, 0.0, 0.0]),
            ((side,) * 3, n, origin + [side + gap, 0.0, 0.0], STILL, drift),
        ]
        steps = int(gap / speed / STEP) + 12
        end = move(boxes(*rows, restitution=e), STEP, steps, steps)
        common = m * speed / (m + n)
        after = [common - e * n * speed / (m + n), common + e * m * speed / (m + n)]
        measured.append(np.concatenate(end.velocity[-1] - drift))
        expected.append([after[0], 0.0, 0.0, after[1], 0.0, 0.0])
        scale.append(speed)
        kinds.append(f"{away / 1e3:g} km")
    return Comparison(np.array(measured), np.array(expected), np.array(scale), kinds)


@asks(
    "move_boxes",
    roundings=500,
    reference="closed form: what is not touched goes on",
    unit="of the speed",
    tolerance=1e-9,
    because="nothing touches it: rounding of some hundred steps",
)
def slot(run: Run, move: Answer) -> Comparison:
    """A box flies through a slot with 0.1 to 1 mm of air.

    Between two held plates of 1 m, at 1 to 30 m/s, without friction.
    """
    rng, measured, expected, scale = run.fresh_rng(), [], [], []
    for k in range(run.count(6, 30, 300)):
        speed, height, air = (1.0, 5.0, 30.0)[k % 3], rng.uniform(0.1, 0.3), 10.0 ** rng.uniform(-4.0, -3.0)
        plates = [((1.0, 2.0, 0.1), HELD, (1.0, 0.0, side * (0.5 * height + 0.05 + air))) for side in (-1.0, 1.0)]
        box = (rng.uniform(0.2, 0.4), 0.3, height), 1.0, (0.0, 0.0, 0.0), STILL, (speed, 0.0, 0.0)
        steps = int(2.0 / speed / STEP)
        end = move(boxes(*plates, box, restitution=rng.random()), STEP, steps, steps)
        measured.append(np.concatenate([end.velocity[-1, 2], end.spin[-1, 2]]))
        expected.append([speed, 0.0, 0.0, 0.0, 0.0, 0.0])
        scale.append(speed)
    return Comparison(np.array(measured), np.array(expected), np.array(scale))
