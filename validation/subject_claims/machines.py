"""Lifts, turntables, belts, pushers, wedges and jaws: held boxes that move, and what they do to others."""

from __future__ import annotations

import numpy as np

from validation.cases import rotation_matrix
from validation.check import DISAGREEMENTS, Comparison, Run
from validation.subject import asks
from validation.subject_claims.boxes import COULOMB, HELD, STILL, Answer, G, boxes
from validation.subject_claims.heaps import STANDS, STEP, became, tilted, unrest

FAMILY = "belts, lifts and grippers"
NONE = 0.0, 0.0, 0.0
CLEAR = 0.01  # [m] of air between held boxes: some engines let them meet


@asks("move_boxes", roundings=240 * 2, **STANDS)
def lift(run: Run, move: Answer) -> Comparison:
    """A lift carries a box up, down and aslant.

    At 0.5 to 3 m/s; both begin at that speed.
    """
    rng, found, kinds = run.fresh_rng(), [], []
    for k in range(run.count(6, 20, 200)):
        way = np.array([(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), rng.normal(size=3)][k % 3])
        velocity, side = rng.uniform(0.5, 3.0) * way / np.linalg.norm(way), rng.uniform(0.3, 0.6)
        floor = (2.0, 2.0, 0.2), HELD, (0.0, 0.0, -0.1), STILL, velocity
        box = (side, side, 0.8 * side), 10.0 ** rng.uniform(-1.0, 1.0), (0.0, 0.0, 0.4 * side), STILL, velocity
        found.append(unrest(move, boxes(floor, box, gravity=G, friction=0.5), 1, 1.0))
        kinds.append(("up", "down", "aslant")[k % 3])
    return Comparison(np.array(found), np.zeros(len(found)), groups=kinds)


@asks("move_boxes", roundings=240 * 2, **STANDS)
def jaws(run: Run, move: Answer) -> Comparison:
    """Two jaws that form a V carry the box between them up.

    Held plates, each turned by 45°, and a cube on its edge, without friction or with it; at 0.3 to 2 m/s.
    """
    rng, found, kinds = run.fresh_rng(), [], []
    for k in range(run.count(6, 20, 200)):
        side, speed, friction = rng.uniform(0.3, 0.6), rng.uniform(0.3, 2.0), 0.5 * (k % 2)
        velocity, rows = (0.0, 0.0, speed), []
        for sign in (-1.0, 1.0):
            across = 0.5 * (side + 0.1) / np.sqrt(2.0)  # the jaw's middle is that far aside of the cube's, and below
            place = sign * across, 0.0, -across
            rows.append(((0.1, 1.0, side - 2.0 * 0.1), HELD, place, tilted(sign * 0.25 * np.pi), velocity))
        cube = (side, side, side), 1.0, NONE, tilted(0.25 * np.pi), velocity
        found.append(unrest(move, boxes(*rows, cube, gravity=G, friction=friction), 1, 1.0))
        kinds.append(f"friction {friction}")
    return Comparison(np.array(found), np.zeros(len(found)), groups=kinds)


@asks("move_boxes", roundings=240 * 3, **STANDS)
def stop(run: Run, move: Answer) -> Comparison:
    """A box that a belt pushes against a stop stays there."""
    rng, found = run.fresh_rng(), []
    for _ in range(run.count(6, 20, 200)):
        size, friction = rng.uniform([0.4, 0.4, 0.2], [0.8, 0.8, 0.4]), rng.uniform(0.1, 0.6)
        belt = (200.0, 200.0, 2.0), HELD, (0.0, 0.0, -1.0), STILL, (rng.uniform(0.5, 3.0), 0.0, 0.0)
        post = (0.5, 3.0, 2.0), HELD, (0.25 + 0.5 * size[0], 0.0, 1.0 + CLEAR)
        box = size, 10.0 ** rng.uniform(-1.0, 1.0), (0.0, 0.0, 0.5 * size[2])
        found.append(unrest(move, boxes(belt, post, box, gravity=G, friction=friction), 1, 1.0))
    return Comparison(np.array(found), np.zeros(len(found)))


@asks(
    "move_boxes",
    reference=COULOMB,
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="a yes-or-no answer; ω² r is 5 % or more off μ g, and a box that is carried gains ω h/2 of r a radian: 2 %",
)
def turntable(run: Run, move: Answer) -> Comparison:
    """A turntable carries a box if and only if ω² r < μ g."""
    rng, measured, expected = run.fresh_rng(), [], []
    for k in range(run.count(6, 30, 200)):
        radius, friction = rng.uniform(1.0, 4.0), rng.uniform(0.2, 0.8)
        rate = np.sqrt(friction * G / radius * (1.0 + rng.uniform(0.05, 0.3) * (1.0 if k % 2 else -1.0)))
        angle, spin = rng.uniform(0.0, 2.0 * np.pi), np.array([0.0, 0.0, rate])
        place = radius * np.array([np.cos(angle), np.sin(angle), 0.0])
        table = (40.0, 40.0, 1.0), HELD, (0.0, 0.0, -0.5), STILL, NONE, spin
        box = (0.4, 0.4, 0.1), 1.0, (*place[:2], 0.05), STILL, np.cross(spin, place), spin
        steps = int(6.0 / rate / STEP)
        end = move(boxes(table, box, gravity=G, friction=friction), STEP, steps, steps)
        measured.append(became(end, int(np.linalg.norm(end.position[-1, 1, :2]) > 1.1 * radius)))
        expected.append(k % 2)
    return Comparison(np.array(measured), np.array(expected))


@asks(
    "move_boxes",
    roundings=480 * 4,
    reference=COULOMB,
    unit="of the table's spin",
    tolerance=5e-6,
    because="impulses at which sweeps stop, as of `ride`: what friction holds is right to 2e-11",
)
def spin_up(run: Run, move: Answer) -> Comparison:
    """A box put on the middle of a turntable comes to spin with it."""
    rng, measured, expected = run.fresh_rng(), [], []
    for _ in range(run.count(6, 20, 100)):
        rate, friction = rng.uniform(1.0, 4.0) * rng.choice([-1.0, 1.0]), rng.uniform(0.3, 0.8)
        table = (10.0, 10.0, 1.0), HELD, (0.0, 0.0, -0.5), STILL, NONE, (0.0, 0.0, rate)
        box = (0.5, 0.5, 0.2), 10.0 ** rng.uniform(-1.0, 1.0), (0.0, 0.0, 0.1)
        end = move(boxes(table, box, gravity=G, friction=friction), STEP, 480, 480)
        measured.append(end.spin[-1, 1] / rate)
        expected.append([0.0, 0.0, 1.0])
    return Comparison(np.array(measured), np.array(expected))


@asks(
    "move_boxes",
    roundings=480 * 4,
    reference="closed form: the pusher's way",
    unit="of the way, and of the speed",
    tolerance=1.0 / 240.0,
    because="the box is struck within a step, V h of V t, t = 240 h",
)
def push(run: Run, move: Answer) -> Comparison:
    """A pusher drives a box along the ground at its own speed, before it."""
    rng, measured, expected = run.fresh_rng(), [], []
    for _ in range(run.count(6, 20, 200)):
        length, friction, speed = rng.uniform(0.4, 0.8), rng.uniform(0.1, 0.8), rng.uniform(0.3, 2.0)
        pusher = (0.5, 1.0, 0.3), HELD, (-0.251, 0.0, 0.15 + CLEAR), STILL, (speed, 0.0, 0.0)  # 1 mm before the box
        box = (length, 0.6, 0.3), 10.0 ** rng.uniform(-1.0, 1.0), (0.5 * length, 0.0, 0.15)
        under = (200.0, 200.0, 2.0), HELD, (0.0, 0.0, -1.0)
        end = move(boxes(under, pusher, box, gravity=G, friction=friction), STEP, 240, 240)
        way = speed * 240.0 * STEP
        place = end.position[-1, 2] - [0.5 * length - 0.001, 0.0, 0.15]
        measured.append(np.concatenate([place / way, end.velocity[-1, 2] / speed]))
        expected.append([1.0, 0.0, 0.0, 1.0, 0.0, 0.0])
    return Comparison(np.array(measured), np.array(expected))


@asks(
    "move_boxes",
    roundings=120 * 12,
    reference="bound: what is struck without restitution is no faster than what strikes",
    kind="bound",
    unit="of g h",
    tolerance=1.0,
    because="what contacts with the ground know of speeds: a fall in a step, g h",
)
def outrun(run: Run, move: Answer) -> Comparison:
    """No box of a row outruns the pusher that strikes it.

    Four boxes on smooth ground, 1 mm apart, struck without restitution at 0.5 to 1.5 m/s; nor is any slower in the end.
    """
    rng, found = run.fresh_rng(), []
    for _ in range(run.count(6, 20, 200)):
        speed, mass = rng.uniform(0.5, 1.5), 10.0 ** rng.uniform(-0.5, 0.5, 4)
        pusher = (0.5, 1.0, 0.3), HELD, (-0.251, 0.0, 0.15 + CLEAR), STILL, (speed, 0.0, 0.0)
        row = [((0.5, 0.6, 0.3), m, (0.25 + 0.501 * k, 0.0, 0.15)) for k, m in enumerate(mass)]
        under = (200.0, 200.0, 2.0), HELD, (0.0, 0.0, -1.0)
        way = move(boxes(under, pusher, *row, gravity=G), STEP, 120, 1)
        speeds = way.velocity[:, 2:, 0] - speed
        found.append(np.max([0.0, speeds.max(), -speeds[-1].min()]) / (G * STEP))
    return Comparison(np.array(found), np.zeros(len(found)))


@asks(
    "move_boxes",
    reference="closed form: moments about the front edge",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="a yes-or-no answer; the height is 10 % or more off the threshold",
)
def push_over(run: Run, move: Answer) -> Comparison:
    """A bar that pushes a box tips it above w (1 + μ²) / 2μ only.

    Below that height the box slides: friction at the bar, of the same μ, holds its rear down as well.
    """
    rng, measured, expected = run.fresh_rng(), [], []
    for k in range(run.count(6, 30, 200)):
        friction, width, bar, speed = rng.uniform(0.4, 0.8), rng.uniform(0.4, 0.8), 0.02, 0.3
        limit = 0.5 * width * (1.0 + friction**2) / friction
        off = rng.uniform(0.1, 0.3)
        middle = limit * (1.0 + off) + 0.5 * bar if k % 2 else limit * (1.0 - off) - 0.5 * bar
        tall, velocity = 1.5 * limit, (speed, 0.0, 0.0)
        rows = (
            ((200.0, 200.0, 2.0), HELD, (0.0, 0.0, -1.0)),
            ((0.5, 2.0, bar), HELD, (-0.25 - 0.5 * width, 0.0, middle), STILL, velocity),
            ((width, 0.6, tall), 1.0, (0.0, 0.0, 0.5 * tall), STILL, velocity),
        )
        end = move(boxes(*rows, gravity=G, friction=friction), STEP, 480, 480)
        measured.append(became(end, int(rotation_matrix(end.orientation[-1, 2])[2, 2] < np.cos(0.2))))
        expected.append(k % 2)
    return Comparison(np.array(measured), np.array(expected))


@asks(
    "move_boxes",
    roundings=1000 * 4,
    reference=COULOMB,
    unit="of the belt's speed",
    tolerance=5e-6,
    because="impulses at which sweeps stop, as of `ride`; tan θ is 10 % or more off the threshold",
)
def climb(run: Run, move: Answer) -> Comparison:
    """A belt up a slope carries a box up if and only if tan θ < μ.

    Put on it at rest the box gains g (μ cos θ − sin θ) t up to the belt's speed, or slides down all the same.
    """
    rng, measured, expected, kinds = run.fresh_rng(), [], [], []
    for k in range(run.count(6, 20, 100)):
        friction, speed = rng.uniform(0.3, 0.8), rng.uniform(0.5, 1.5)
        angle = np.arctan(friction * (1.0 + rng.uniform(0.1, 0.3) * (1.0 if k % 2 else -1.0)))
        up, along = np.array([np.sin(angle), 0.0, np.cos(angle)]), np.array([-np.cos(angle), 0.0, np.sin(angle)])
        gain = G * (friction * np.cos(angle) - np.sin(angle))
        steps = int((1.5 if k % 3 else 0.6) * speed / abs(gain) / STEP)
        belt = (200.0, 50.0, 2.0), HELD, -up, tilted(angle), speed * along
        box = (0.6, 0.6, 0.1), 10.0 ** rng.uniform(-1.0, 1.0), 0.05 * up, tilted(angle)
        end = move(boxes(belt, box, gravity=G, friction=friction), STEP, steps, steps)
        measured.append(end.velocity[-1, 1] / speed)
        expected.append(min(1.0, gain * steps * STEP / speed) * along)
        kinds.append("down" if gain < 0.0 else "carried" if k % 3 else "gaining")
    return Comparison(np.array(measured), np.array(expected), groups=kinds)


@asks(
    "move_boxes",
    roundings=500 * 4,
    reference="closed form: V tan θ",
    unit="of the rise, and of its speed",
    tolerance=2e-3,
    because="a fall in a step at the contact, g h² = 1.7e-4 m, of a rise of 0.15 m",
)
def wedge(run: Run, move: Answer) -> Comparison:
    """A wedge that is driven under a box lifts it at V tan θ, along a wall."""
    rng, measured, expected = run.fresh_rng(), [], []
    for _ in range(run.count(6, 20, 100)):
        angle, speed, rise = rng.uniform(0.3, 0.5), rng.uniform(0.2, 0.5), 0.15
        up, climbs = np.array([np.sin(angle), 0.0, np.cos(angle)]), speed * np.tan(angle)
        rows = (
            ((4.0, 3.0, 1.0), HELD, -0.5 * up, tilted(angle), (speed, 0.0, 0.0)),
            ((0.3, 0.5, 0.8), 1.0, (0.15, 0.0, 0.4), STILL, (0.0, 0.0, climbs)),
            ((0.2, 2.0, 4.0), HELD, (0.4, 0.0, 2.0 + rise + CLEAR)),
        )
        steps = int(rise / climbs / STEP)
        end = move(boxes(*rows, gravity=G), STEP, steps, steps)
        off = end.position[-1, 1] - [0.15, 0.0, 0.4]
        measured.append(np.concatenate([off / (climbs * steps * STEP), end.velocity[-1, 1] / climbs]))
        expected.append([0.0, 0.0, 1.0] * 2)
    return Comparison(np.array(measured), np.array(expected))
