"""Boxes that fly, meet, slide, ride and stand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from references.accounts import of_boxes
from validation.cases import corners_of, random_orientations, rotation_matrix
from validation.check import DISAGREEMENTS, Comparison, Run
from validation.checks.boxes.passing import overlap_of, paces, passing
from validation.checks.boxes.rigid import turned_by
from validation.subject import Boxes, asks

FAMILY = "boxes in motion"
G = 9.81  # [m/s²]
STILL = (1.0, 0.0, 0.0, 0.0)
HELD = np.inf  # [kg]
NEWTON, COULOMB = "closed form: Newton's law", "closed form: Coulomb's law"

Answer = Callable  # the function of the subject that is asked


def boxes(*rows: tuple, gravity: float = 0.0, friction: float = 0.0, restitution: float = 0.0) -> Boxes:
    """Return boxes of rows: size, mass, position, and if they have them orientation, velocity and spin."""
    whole = [(*row, *(STILL, (0.0,) * 3, (0.0,) * 3)[len(row) - 3 :]) for row in rows]
    size, mass, position, orientation, velocity, spin = (np.array(column, float) for column in zip(*whole))
    return Boxes(size, mass, position, orientation, velocity, spin, float(gravity), float(friction), float(restitution))


@asks(
    "move_boxes",
    roundings=1_000,
    reference=NEWTON,
    unit="of the speed",
    tolerance=1e-12,
    because="a thousand additions, each rounded at 1e-16",
)
def fly(run: Run, move: Answer) -> Comparison:
    """A box that flies moves evenly, and gains g t of speed."""
    rng, measured, expected, scale = run.fresh_rng(), [], [], []
    for _ in range(run.count(6, 30, 300)):
        velocity, h, steps = 3.0 * rng.normal(size=3), rng.uniform(1e-3, 1e-2), int(rng.integers(10, 1000))
        box = ((1.0, 0.6, 0.3), 2.0, rng.normal(size=3), STILL, velocity)
        end = move(boxes(box, gravity=G), h, steps, steps)
        measured.append(end.velocity[-1, 0])
        expected.append(velocity - [0.0, 0.0, G * h * steps])
        scale.append(np.linalg.norm(velocity) + G * h * steps)
    return Comparison(np.array(measured), np.array(expected), np.array(scale))


@asks(
    "move_boxes",
    roundings=4_000,
    reference="closed form: Rodrigues' formula for the whole turn",
    unit="of the rotation matrix",
    tolerance=1e-10,
    because="a thousand products of quaternions, and a torque that is 0 but for rounding: 2e-11 after 50 rad",
)
def turn(run: Run, move: Answer) -> Comparison:
    """A box that spins about its longest or shortest axis turns by |ω| t about it."""
    rng, measured, expected = run.fresh_rng(), [], []
    for k, start in enumerate(random_orientations(rng, run.count(6, 30, 300))):
        matrix = rotation_matrix(start)
        spin, h, steps = (
            matrix[:, 2 * (k % 2)] * rng.uniform(0.5, 5.0),
            rng.uniform(1e-3, 1e-2),
            int(rng.integers(10, 1000)),
        )
        end = move(boxes(((1.0, 0.6, 0.3), 2.0, np.zeros(3), start, np.zeros(3), spin)), h, steps, steps)
        measured.append(rotation_matrix(end.orientation[-1, 0]).ravel())
        expected.append((turned_by(spin * h * steps) @ matrix).ravel())
    return Comparison(np.array(measured), np.array(expected))


@asks(
    "move_boxes",
    roundings=4_000,
    reference="invariant",
    kind="invariant",
    tolerance=1e-11,
    because="rounding of a thousand steps, 1e-15 each, always the same way at worst",
)
def tumble(run: Run, move: Answer) -> Comparison:
    """A free box of three different inertias tumbles for 10 s, and keeps its angular momentum."""
    rng, measured, expected = run.fresh_rng(), [], []
    for start in random_orientations(rng, run.count(6, 20, 100)):
        size, spin = np.array([1.0, 0.6, 0.3]) * rng.uniform(0.8, 1.2, 3), 2.0 * rng.normal(size=3)
        free = boxes((size, 1.0, np.zeros(3), start, np.zeros(3), spin))
        end = move(free, 1e-2, 1000, 1000)
        before = momenta(free.orientation, free.velocity, free.spin, free.position, free)
        after = momenta(end.orientation[-1], end.velocity[-1], end.spin[-1], end.position[-1], free)
        length = np.linalg.norm(before[3:6])
        measured.append(after[3:6] / length)
        expected.append(before[3:6] / length)
    return Comparison(np.array(measured), np.array(expected))


def momenta(
    orientation: np.ndarray, velocity: np.ndarray, spin: np.ndarray, position: np.ndarray, all_boxes: Boxes
) -> np.ndarray:
    """Return (7,): momentum, angular momentum about the origin, and kinetic energy."""
    has = of_boxes(all_boxes.size, all_boxes.mass, position, orientation, velocity, spin, np.zeros(3))
    return np.array([*has.momentum, *has.angular_momentum, has.kinetic])


def collisions(rng: np.random.Generator, count: int) -> list[Boxes]:
    """Return pairs of free boxes that fly at each other, and spin, turned anyhow."""
    found = []
    for _ in range(count):
        way = rng.normal(size=3)
        way /= np.linalg.norm(way)
        rows = []
        for side, start in zip((-1.0, 1.0), random_orientations(rng, 2)):
            size = rng.uniform(0.3, 1.0, 3)
            aside = 0.1 * rng.normal(size=3)
            rows.append((size, float(np.exp(rng.uniform(-1.0, 1.0))), side * way + aside, start, -side * rng.uniform(1.0, 3.0) * way, rng.normal(size=3)))  # fmt: skip  # noqa: E501
        found.append(boxes(*rows, restitution=float(rng.random())))
    return found


@asks(
    "move_boxes",
    roundings=500,
    reference="invariant",
    kind="invariant",
    unit="of the momenta",
    tolerance=1e-11,
    because="rounding of some hundred steps and impulses",
)
def keep_momentum(run: Run, move: Answer) -> Comparison:
    """Two boxes that collide, turned anyhow and spinning, keep their momentum."""
    return kept(run, move, slice(0, 3))


@asks(
    "move_boxes",
    roundings=500,
    reference="invariant",
    kind="invariant",
    unit="of the momenta, at 1 m",
    tolerance=5e-3,
    because="an impulse acts where boxes meet within a step of 1/240 s, and they go on from where the step ends: 3e-3",
)
def keep_angular_momentum(run: Run, move: Answer) -> Comparison:
    """Two boxes that collide, turned anyhow and spinning, keep their angular momentum."""
    return kept(run, move, slice(3, 6))


def kept(run: Run, move: Answer, part: slice) -> Comparison:
    """Compare a part of `momenta` after a collision with that before it."""
    measured, expected, scale = [], [], []
    for pair in collisions(run.fresh_rng(), run.count(6, 40, 400)):
        end = move(pair, 1.0 / 240.0, 240, 240)
        measured.append(momenta(end.orientation[-1], end.velocity[-1], end.spin[-1], end.position[-1], pair)[part])
        expected.append(momenta(pair.orientation, pair.velocity, pair.spin, pair.position, pair)[part])
        scale.append(pair.mass @ np.linalg.norm(pair.velocity, axis=1))
    return Comparison(np.array(measured), np.array(expected), np.array(scale))


@asks(
    "move_boxes",
    roundings=500,
    reference="invariant: kinetic energy",
    kind="invariant",
    unit="of the energy before",
    tolerance=1e-6,
    because="impulses at which sweeps over several contacts stop",
)
def gain_nothing(run: Run, move: Answer) -> Comparison:
    """Two boxes that collide, turned anyhow and spinning, of any restitution up to 1, gain no energy."""
    gained = []
    for pair in collisions(run.fresh_rng(), run.count(6, 40, 400)):
        before = momenta(pair.orientation, pair.velocity, pair.spin, pair.position, pair)[6]
        end = move(pair, 1.0 / 240.0, 240, 240)
        after = momenta(end.orientation[-1], end.velocity[-1], end.spin[-1], end.position[-1], pair)[6]
        gained.append(np.maximum(0.0, after / before - 1.0))
    return Comparison(np.array(gained), np.zeros(len(gained)))


@asks(
    "move_boxes",
    roundings=500,
    reference="closed form: central impact",
    unit="of the closing speed",
    tolerance=1e-4,
    because="sweeps over four corners that say the same: 3e-5 at worst",
)
def meet_face_to_face(run: Run, move: Answer) -> Comparison:
    """Two boxes that meet face to face part with e times their speed, as their masses say."""
    rng, measured, expected, scale = run.fresh_rng(), [], [], []
    for _ in range(run.count(6, 50, 500)):
        size, e, speed = rng.uniform(0.3, 0.6, 3), float(rng.random()), 10.0 ** rng.uniform(0.0, 1.5)
        (m, n), gap = np.exp(rng.uniform(-2.0, 2.0, 2)), rng.uniform(0.05, 0.5)
        own = rng.uniform(-1.0, 0.5) * speed
        rows = [
            (size, m, np.zeros(3), STILL, (speed, 0.0, 0.0)),
            (size, n, (size[0] + gap, 0.0, 0.0), STILL, (own, 0.0, 0.0)),
        ]
        end = move(boxes(*rows, restitution=e), h := 1.0 / 240.0, steps := int(gap / (speed - own) / h) + 12, steps)
        common = (m * speed + n * own) / (m + n)
        measured.append(end.velocity[-1, :, 0])
        expected.append([common - e * n * (speed - own) / (m + n), common + e * m * (speed - own) / (m + n)])
        scale.append(speed - own)
    return Comparison(np.array(measured), np.array(expected), np.array(scale))


@asks(
    "move_boxes",
    roundings=8_000,
    reference="closed form e²ⁿ h",
    unit="of the first height",
    tolerance=2e-3,
    because="an impact is seen up to a step early, v h = 1e-3 m above the ground, v = 4.4 m/s, h = 1/4 ms",
)
def bounce(run: Run, move: Answer) -> Comparison:
    """A box dropped flat bounces to e², e⁴ and e⁶ of its height."""
    measured, expected, kinds = [], [], []
    for e in (0.5, 0.8, 1.0):
        for size in ((1.0, 1.0, 1.0), (1.0, 0.6, 0.4))[: run.count(1, 2, 2)]:
            fall = boxes(ground(), (size, 1.0, (0.0, 0.0, 1.0 + 0.5 * size[2])), gravity=G, restitution=e)
            first = np.sqrt(2.0 / G)
            turns = np.cumsum([first, *(2.0 * first * e**n for n in (1, 2, 3))])
            way = move(fall, 2.5e-4, int(turns[-1] / 2.5e-4), 4)
            height, times = way.position[:, 1, 2] - 0.5 * size[2], 1e-3 * np.arange(1, len(way.position) + 1)
            for n in (1, 2, 3):
                arc = height[(times >= turns[n - 1]) & (times <= turns[n])]
                measured.append(arc.max(initial=0.0))
                expected.append(e ** (2 * n))
                kinds.append(f"e = {e}")
    return Comparison(measured, expected, groups=kinds)


def ground(height: float = 0.0, speed: object = (0.0, 0.0, 0.0)) -> tuple:
    """Return a large held box whose top is at a height [m]."""
    return (200.0, 200.0, 2.0), HELD, (0.0, 0.0, height - 1.0), STILL, speed


@asks(
    "move_boxes",
    roundings=1_000,
    reference=COULOMB,
    unit="of the way",
    tolerance=5e-3,
    because="Euler's steps: the way differs by v h / 2 of v²/2μg, which is μ g h / v",
)
def slide(run: Run, move: Answer) -> Comparison:
    """A box that slides on the ground stops after v²/2μg."""
    rng, measured, expected = run.fresh_rng(), [], []
    for _ in range(run.count(6, 20, 200)):
        friction, speed, angle = rng.uniform(0.2, 0.8), rng.uniform(1.0, 3.0), rng.uniform(0.0, 2.0 * np.pi)
        size = np.array([1.0, 1.0, 0.2]) * rng.uniform(0.7, 1.3, 3)  # low and wide: friction cannot lift its rear
        velocity = speed * np.array([np.cos(angle), np.sin(angle), 0.0])
        box = (size, rng.uniform(0.1, 10.0), (0.0, 0.0, 0.5 * size[2]), STILL, velocity)
        steps = int(1.2 * speed / (friction * G) / 5e-4)
        end = move(boxes(ground(), box, gravity=G, friction=friction), 5e-4, steps, steps)
        measured.append(np.linalg.norm(end.position[-1, 1, :2]))
        expected.append(speed**2 / (2.0 * friction * G))
    return Comparison(measured, expected, np.array(expected))


@asks(
    "move_boxes",
    roundings=1_000,
    reference=COULOMB,
    unit="of g t²/2",
    tolerance=2e-3,
    because="Euler's steps: t² becomes t (t + h), h/t = 1e-3; θ is 1 % or more off the threshold",
)
def slope(run: Run, move: Answer) -> Comparison:
    """A box on a slope holds if and only if tan θ < μ; else it slides down by g (sin θ − μ cos θ) t²/2."""
    rng, measured, expected, kinds = run.fresh_rng(), [], [], []
    for k in range(run.count(6, 20, 200)):
        friction = rng.uniform(0.2, 0.8)
        angle = np.arctan(friction * (1.0 + rng.uniform(0.01, 0.3) * (1.0 if k % 2 else -1.0)))
        tilt = (np.cos(0.5 * angle), 0.0, np.sin(0.5 * angle), 0.0)
        up = np.array([np.sin(angle), 0.0, np.cos(angle)])
        rows = ((50.0, 50.0, 1.0), HELD, np.zeros(3), tilt), ((1.0, 1.0, 0.2), 1.0, 0.6 * up, tilt)
        end = move(boxes(*rows, gravity=G, friction=friction), 1e-3, 1000, 1000)
        measured.append(np.linalg.norm(end.position[-1, 1] - 0.6 * up) / (0.5 * G))
        expected.append(np.maximum(0.0, np.sin(angle) - friction * np.cos(angle)))
        kinds.append("slides" if k % 2 else "holds")
    return Comparison(measured, expected, groups=kinds)


@asks(
    "move_boxes",
    roundings=1_000,
    reference=COULOMB,
    unit="of the belt's speed",
    tolerance=5e-6,
    because="impulses at which sweeps stop: 6.5e-7 at worst, sliding; what friction holds, 2e-11",
)
def ride(run: Run, move: Answer) -> Comparison:
    """A box that is put on a belt gains μ g t until it is as fast as the belt, and then goes with it."""
    rng, measured, expected, kinds = run.fresh_rng(), [], [], []
    for _ in range(run.count(6, 20, 100)):
        size = rng.uniform(0.3, 0.6, 3) * [1.0, 1.0, 0.3]  # low, so that it does not tip
        mass, friction = float(np.exp(rng.uniform(-3.0, 3.0))), rng.uniform(0.1, 0.8)
        angle, speed = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(1.0, 3.0)
        way = np.array([np.cos(angle), np.sin(angle), 0.0])
        on_belt = boxes(
            ground(speed=speed * way), (size, mass, (0.0, 0.0, 0.5 * size[2])), gravity=G, friction=friction
        )
        h, steps = 1.0 / 480.0, int(rng.uniform(0.3, 0.9) * speed / (friction * G) * 480.0)
        gains = move(on_belt, h, steps, steps)
        rides = move(on_belt, h, last := int(2.0 * speed / (friction * G) * 480.0), last)
        measured += [gains.velocity[-1, 1] @ way / speed, np.linalg.norm(rides.velocity[-1, 1] - speed * way) / speed]
        expected += [friction * G * h * steps / speed, 0.0]
        kinds += ["sliding", "carried"]
    return Comparison(measured, expected, groups=kinds)


@asks(
    "move_boxes",
    reference="bounds",
    kind="bound",
    unit="of the bound",
    tolerance=1.0,
    because="bounds: sinking 10 g h² (one fall in a step at each contact), drift 1 % of a side, speed at rest g h / 4",
)
def stack(run: Run, move: Answer) -> Comparison:
    """A stack of ten boxes stands for 20 s: it hardly sinks, drifts or moves."""
    h = 1.0 / 240.0
    rows = [((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, 0.5 + k)) for k in range(10)]
    end = move(boxes(ground(), *rows, gravity=G, friction=0.5), h, 4800, 4800)
    off = end.position[-1, 1:] - [row[2] for row in rows]
    drift = np.linalg.norm(off[:, :2], axis=1).max()
    speed = np.linalg.norm(np.hstack([end.velocity[-1, 1:], end.spin[-1, 1:]]), axis=1).max()
    found = np.array([np.abs(off[:, 2]).max(), drift, speed])
    return Comparison(
        found, np.zeros(3), np.array([10.0 * G * h * h, 0.01, 0.25 * G * h]), ["sinking", "drift", "speed"]
    )


@asks(
    "move_boxes",
    reference="closed form: the edge is under the centre at tan θ = width / height",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="a yes-or-no answer, 1 % or more of the angle off the threshold",
)
def topple(run: Run, move: Answer) -> Comparison:
    """A tower that leans on its edge falls back or topples as its centre is inside or outside that edge."""
    rng, measured, expected = run.fresh_rng(), [], []
    for k in range(run.count(6, 30, 200)):
        width, height = rng.uniform(0.4, 1.0), rng.uniform(0.8, 1.5)
        angle = np.arctan(width / height) * (1.0 + rng.uniform(0.01, 0.2) * (1.0 if k % 2 else -1.0))
        lean, size = np.array((np.cos(0.5 * angle), 0.0, np.sin(0.5 * angle), 0.0)), np.array((width, 0.7, height))
        low = (corners_of(size) @ rotation_matrix(lean).T)[:, 2].min()
        end = move(boxes(ground(), (size, 1.0, (0.0, 0.0, -low), lean), gravity=G, friction=1.0), 2e-3, 1500, 1500)
        measured.append(bool(abs(rotation_matrix(end.orientation[-1, 1])[2, 2]) < 0.5))
        expected.append(bool(k % 2))
    return Comparison(np.array(measured), np.array(expected))


@asks(
    "move_boxes",
    reference="closed form: outlines of two boxes, seen along their relative motion, overlap or are apart",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="what is not touched is not struck; overlaps below 1 mm are left out",
)
def pass_or_meet(run: Run, move: Answer) -> Comparison:
    """Boxes that fly past each other with 1 mm to 10 cm of air, at 1 to 100 m/s, are not struck; those whose outlines
    overlap are, however far they go in a step."""
    rng = run.fresh_rng()
    count = run.count(60, 300, 3_000)
    cases = [passing(rng, float(10.0 ** rng.uniform(-3.0, -1.0)) if k % 2 else None) for k in range(count)]
    overlap, struck, kinds = overlap_of(cases), [], []
    for case, pace in zip(cases, paces(count)):
        start = case.offset - rng.uniform(0.5, 3.0) * pace.speed * pace.step * case.way
        pair = boxes(
            (case.size[0], 1.0, start, case.orientation[0], pace.speed * case.way),
            (case.size[1], 1.0, np.zeros(3), case.orientation[1]),
        )
        steps = int(8.0 / (pace.speed * pace.step)) + 5
        end = move(pair, pace.step, steps, steps)
        struck.append(bool(np.abs(end.velocity[-1] - pair.velocity).max() > 1e-3 * pace.speed))
        kinds.append(f"{pace.speed * pace.step:.2g} m a step")
    clear = (overlap < 0.0) | (overlap > 1e-3)
    return Comparison(np.array(struck)[clear], overlap[clear] > 0.0, groups=np.array(kinds)[clear])
