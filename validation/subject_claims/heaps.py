"""Heaps, piles and buildings of boxes that stand, and those that fall."""

from __future__ import annotations

import numpy as np

from validation.cases import rotation_matrix
from validation.check import DISAGREEMENTS, Comparison, Run
from validation.subject import Boxes, Motion, asks
from validation.subject_claims.boxes import HELD, Answer, G, boxes, ground

FAMILY = "heaps and towers"
STEP = 1.0 / 240.0  # [s]
LOST = 9  # what becomes of boxes that are nowhere: the outcome of no case
BOUNDS = (
    "bounds: sinking g h² a layer (one fall in a step at each contact), drift 1 % of a metre, speed at rest g h / 4"
)
STANDS = {"reference": "bounds", "kind": "bound", "unit": "of the bound", "tolerance": 1.0, "because": BOUNDS}


def tilted(angle: float) -> tuple[float, ...]:
    """Return the orientation of what is turned about y, its top towards +x."""
    return np.cos(0.5 * angle), 0.0, np.sin(0.5 * angle), 0.0


def unrest(move: Answer, built: Boxes, layers: int, seconds: float) -> float:
    """Return how far boxes that may move got from where they should be, or how fast, in units of BOUNDS: the worst.

    They should go as they began.
    """
    steps = int(seconds / STEP)
    end, free = move(built, STEP, steps, steps), np.isfinite(built.mass)
    off = (end.position[-1] - built.position - seconds * built.velocity)[free]
    speed = np.hstack([end.velocity[-1] - built.velocity, end.spin[-1] - built.spin])[free]
    parts = np.abs(off[:, 2]) / (layers * G * STEP**2), np.linalg.norm(off[:, :2], axis=1) / 0.01
    return float(np.max([*parts, np.linalg.norm(speed, axis=1) / (0.25 * G * STEP)]))


def became(end: Motion, outcome: int) -> int:
    """Return an outcome, or LOST if boxes are nowhere."""
    return outcome if np.isfinite(end.position).all() and np.isfinite(end.orientation).all() else LOST


def all_stand(move: Answer, cases: list[tuple[str, list[tuple], int]], seconds: float) -> Comparison:
    """Compare the unrest of rows of boxes on the ground, of so many layers, with none."""
    found = [
        unrest(move, boxes(ground(), *rows, gravity=G, friction=0.5), layers, seconds) for _, rows, layers in cases
    ]
    return Comparison(np.array(found), np.zeros(len(found)), groups=[kind for kind, *_ in cases])


def cube(*place: float, mass: float = 1.0) -> tuple:
    """Return a cube of 1 m that stands at x, y and the height of its lower face."""
    x, y, z = place
    return (1.0, 1.0, 1.0), mass, (x, y, z + 0.5)


@asks("move_boxes", roundings=120 * 27, **STANDS)
def heap(run: Run, move: Answer) -> Comparison:
    """A heap of boxes stays as it was put.

    From 2 × 2 × 2 to 3 × 3 × 3: side by side in contact, or 1 mm apart, or each other layer a third of a box aside.
    """
    shapes = [(2, 2, 2), (3, 2, 2), (2, 2, 3), (2, 2, 4), (4, 1, 3), (3, 3, 3)] + [(4, 4, 4)] * run.count(0, 3, 3)
    cases = []
    for n, shape in enumerate(shapes):
        kind, apart, aside = (("in contact", 1.0, 0.0), ("1 mm apart", 1.001, 0.0), ("shifted", 1.001, 1.0 / 3.0))[
            n % 3
        ]
        rows = [cube(apart * i + aside * (k % 2), apart * j, k) for i, j, k in np.ndindex(shape)]
        cases.append((kind, rows, shape[2]))
    return all_stand(move, cases, 0.5 * run.count(1, 4, 4))


@asks("move_boxes", roundings=120 * 10, **STANDS)
def mixed_pile(run: Run, move: Answer) -> Comparison:
    """A pile of ten boxes of mixed masses stands.

    Masses from 0.3 to 3 kg in any order, each box up to a twentieth of its side off the line.
    """
    rng, cases = run.fresh_rng(), []
    for _ in range(run.count(6, 20, 100)):
        rows = [cube(*rng.uniform(-0.05, 0.05, 2), k, mass=10.0 ** rng.uniform(-0.5, 0.5)) for k in range(10)]
        cases.append(("drawn masses", rows, 10))
    return all_stand(move, cases, 0.5 * run.count(1, 10, 10))


@asks("move_boxes", roundings=480 * 3, **STANDS)
def heavy_on_light(run: Run, move: Answer) -> Comparison:
    """Light boxes carry one of up to 10 000 times their mass."""
    cases = []
    for ratio in (10.0, 100.0, 1e4):
        for light in (1, 3, 5)[: run.count(2, 3, 3)]:
            rows = [*(cube(0.0, 0.0, k) for k in range(light)), cube(0.0, 0.0, light, mass=ratio)]
            cases.append((f"1 : {ratio:g}", rows, light + 1))
    return all_stand(move, cases, 2.0)


def brick(x: float, course: int, length: float = 1.0, mass: float = 1.0) -> tuple:
    """Return a brick of a wall along x: its middle and course; 1 mm shorter than its place."""
    return (length - 1e-3, 0.5, 0.5), mass * length, (x, 0.0, 0.5 * course + 0.25)


def pyramid(base: int) -> list[tuple]:
    """Return bricks, one fewer in each course."""
    return [brick(k - 0.5 * (base - course), course) for course in range(base) for k in range(base - course)]


def gates(storeys: int) -> list[tuple]:
    """Return legs of two bricks and lintels, on each other."""
    found = []
    for floor in range(0, 3 * storeys, 3):
        found += [brick(side, floor + k) for side in (-1.0, 1.0) for k in (0, 1)] + [brick(0.0, floor + 2, 3.0)]
    return found


def wall(courses: int) -> list[tuple]:
    """Return a wall in running bond, five bricks long, whose opening in the lower half a lintel bridges."""
    found, half = [], courses // 2
    for course in range(courses):
        middles = np.arange(-2.0, 3.0) if course % 2 == 0 else np.arange(-1.5, 2.0)
        if course < half:
            middles = middles[np.abs(middles) > 0.9]
        elif course == half:
            middles = middles[np.abs(middles) > 1.4]
            found.append(brick(0.0, course, 3.0 if course % 2 == 0 else 2.0))
        found += [brick(x, course) for x in middles]
        if course % 2:
            found += [brick(x, course, 0.5) for x in (-2.25, 2.25)]
    return found


@asks("move_boxes", roundings=120 * 20, **STANDS)
def built(run: Run, move: Answer) -> Comparison:
    """Pyramids, gates and walls with an opening stay as they were built."""
    cases = [("pyramid", pyramid(n), n) for n in (3, 4)] + [("gates", gates(n), 3 * n) for n in (1, 2)]
    return all_stand(move, [*cases, *(("wall", wall(n), n) for n in (4, 6))], 0.5 * run.count(1, 8, 8))


@asks(
    "move_boxes",
    reference="closed form: the centre of the upper bricks is over the one below",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="a yes-or-no answer; the weakest joint is 5 % or more of half a brick off its threshold, others 10 %",
)
def overhang(run: Run, move: Answer) -> Comparison:
    """A leaning pile of bricks falls only beyond the harmonic reach.

    It stands if and only if the centre of all bricks above each joint is over the brick below.
    """
    rng, measured, expected = run.fresh_rng(), [], []
    for k in range(run.count(6, 30, 200)):
        above = int(rng.integers(2, 6))
        reach = rng.uniform(0.5, 0.9, above)  # of the harmonic one: half a brick
        reach[rng.integers(above)] = 1.0 + rng.uniform(0.05, 0.15) * (1.0 if k % 2 else -1.0)
        middles = [0.0]
        for part in reach:
            middles.append(np.mean(middles) - 0.5 * part)
        rows = [((1.0, 0.5, 0.2), 1.0, (x, 0.0, 0.1 + 0.2 * (above - j))) for j, x in enumerate(middles)]
        end = move(boxes(ground(), *rows, gravity=G, friction=0.6), STEP, 480, 480)
        measured.append(became(end, int(rotation_matrix(end.orientation[-1, 1])[2, 2] < np.cos(0.05))))
        expected.append(k % 2)
    return Comparison(np.array(measured), np.array(expected))


@asks(
    "move_boxes",
    reference="closed form: the lever rule",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="left, level or right: the centre is 5 % or more of half the rest's width off its edge",
)
def seesaw(run: Run, move: Answer) -> Comparison:
    """A loaded beam tips to the side that the lever rule says."""
    rng, measured, expected, width = run.fresh_rng(), [], [], 0.6
    for k in range(run.count(6, 30, 200)):
        side = (-1.0, 1.0)[k % 2]
        tips = k % 3 > 0
        centre = side * 0.5 * width * (1.0 + rng.uniform(0.05, 0.3) * (1.0 if tips else -1.0))
        left, right, mass = rng.uniform(0.8, 1.5), rng.uniform(0.9, 1.5), rng.uniform(1.5, 3.0)
        other = (centre * (1.0 + mass) + mass * left) / (right - centre)  # [kg]: the lever rule
        loads = [((0.3, 0.3, 0.2), m, (x, 0.0, 0.2)) for m, x in ((mass, -left), (other, right))]
        rows = ((width, 1.0, 1.0), HELD, (0.0, 0.0, -0.5)), ((4.0, 0.4, 0.1), 1.0, (0.0, 0.0, 0.05)), *loads
        end = move(boxes(*rows, gravity=G, friction=0.6), STEP, 600, 600)
        down = -rotation_matrix(end.orientation[-1, 1])[2, 0]
        measured.append(became(end, int(np.sign(down)) if abs(down) > 0.05 else 0))
        expected.append(int(side) if tips else 0)
    return Comparison(np.array(measured), np.array(expected))


@asks(
    "move_boxes",
    reference="closed form: forces and moments of a plank that slips at both ends",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="a yes-or-no answer; friction is 5 % or more off the threshold",
)
def lean(run: Run, move: Answer) -> Comparison:
    """A plank that leans against a wall slips below its least friction only.

    Of a thin one that is tan θ/2, at the angle θ to the wall.
    """
    rng, measured, expected = run.fresh_rng(), [], []
    for k in range(run.count(6, 30, 200)):
        angle, thick = rng.uniform(0.4, 1.0), rng.uniform(0.04, 0.1)
        s, c = np.sin(angle), np.cos(angle)
        arm = 0.5 * (s - thick * c)  # [m] from the foot to under the centre of a plank of 1 m
        least = (np.sqrt(c * c + 4.0 * arm * (s - arm)) - c) / (2.0 * (s - arm))
        friction = least * (1.0 + rng.uniform(0.05, 0.3) * (-1.0 if k % 2 else 1.0))
        place = -0.5 * (thick * c + s), 0.0, 0.5 * (thick * s + c)
        rows = ((1.0, 20.0, 20.0), HELD, (0.5, 0.0, 0.0)), ((thick, 0.5, 1.0), 1.0, place, tilted(angle))
        end = move(boxes(ground(), *rows, gravity=G, friction=friction), STEP, 480, 480)
        measured.append(became(end, int(end.position[-1, 2, 2] < 0.8 * place[2])))
        expected.append(k % 2)
    return Comparison(np.array(measured), np.array(expected))


@asks(
    "move_boxes",
    reference="closed form: a domino reaches as far as it is high",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="a yes-or-no answer: spaces of 0.3 to 0.6 of the height, or of 1.02 to 1.2; a tenth of it tips a domino",
)
def dominoes(run: Run, move: Answer) -> Comparison:
    """A row of dominoes falls if each can reach the next.

    Five of them, the first leaning past its balance; all fall, or that one only.
    """
    rng, measured, expected = run.fresh_rng(), [], []
    for k in range(run.count(6, 20, 100)):
        thick = rng.uniform(0.08, 0.12)
        pitch = thick + (rng.uniform(0.3, 0.6) if k % 2 else rng.uniform(1.02, 1.2))
        lean = np.arctan(thick) + 0.1
        low = 0.5 * (thick * np.sin(lean) + np.cos(lean))
        foot = 0.5 * (thick - thick * np.cos(lean) + np.sin(lean))  # [m] on its front edge, where it would stand
        first = (thick, 0.5, 1.0), 1.0, (foot, 0.0, low), tilted(lean)
        others = [((thick, 0.5, 1.0), 1.0, (n * pitch, 0.0, 0.5)) for n in range(1, 5)]
        end = move(boxes(ground(), first, *others, gravity=G, friction=0.4), STEP, 480, 480)
        down = sum(rotation_matrix(turn)[2, 2] < 0.9 for turn in end.orientation[-1, 1:])
        measured.append(became(end, {1: 0, 5: 1}.get(down, 2)))
        expected.append(k % 2)
    return Comparison(np.array(measured), np.array(expected))
