"""Boxes on their edges and corners: struck there, rocking, tipping over and sliding down a wall."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from scipy.special import ellipj

from references.analytic import box_impact, box_inertia
from validation.cases import corners_of, random_orientations, rotation_matrix
from validation.check import Comparison, Run
from validation.record import LIBRARY
from validation.subject import Boxes, Motion, asks
from validation.subject_claims.boxes import HELD, Answer, G, boxes, ground
from validation.subject_claims.heaps import tilted

FAMILY = "edges and corners"
ONE_IMPULSE: dict[str, Any] = {
    "roundings": 100 * 4,
    "reference": "closed form: an impulse at one point, by Newton's law",
    "unit": "of the momentum, at 1 m",
    "tolerance": 1e-9,
    "because": "one impulse; nothing turns before it, so that it does not matter when in a step it is",
}
FINE, COARSER = 5e-4, 1e-3  # [s]
PIVOT = "Euler's steps, first order: half of p h, p = √(3g/4R) < 5/s the rate at which it falls, h = 5e-4 s"


def momentum(boxes_: Boxes, k: int, orientation: np.ndarray, velocity: np.ndarray, spin: np.ndarray) -> np.ndarray:
    """Return (6,): momentum of box k, and its angular momentum about its centre."""
    turn = rotation_matrix(orientation)
    about = turn @ (box_inertia(boxes_.size[k], boxes_.mass[k]) * (turn.T @ spin))
    return np.concatenate([boxes_.mass[k] * velocity, about])


def struck(move: Answer, pair: Boxes, gap: float, closing: float, point: np.ndarray, normal: np.ndarray) -> tuple:
    """Return (measured, expected): what momenta free boxes have after a has met b.

    `point` [m] of b is where they meet, a is `gap` [m] away from it along `normal`, and comes at `closing` [m/s].
    """
    steps = int(gap / closing / FINE) + 6
    end = move(pair, FINE, steps, steps)
    met = pair._replace(position=pair.position - [gap * normal, np.zeros(3)])
    asked: list[Any] = [part[k : k + 1] for k in (0, 1) for part in met[:6]]
    asked += point[None], normal[None], pair.restitution
    after = box_impact(*asked)
    now, then = [], []
    for k, speeds in enumerate((after[:2], after[2:])):
        if np.isfinite(pair.mass[k]):
            now.append(momentum(pair, k, end.orientation[-1, k], end.velocity[-1, k], end.spin[-1, k]))
            then.append(momentum(pair, k, pair.orientation[k], speeds[0][0], speeds[1][0]))
    return np.concatenate(now), np.concatenate(then)


@asks("move_boxes", **ONE_IMPULSE)
def on_a_corner(run: Run, move: Answer) -> Comparison:
    """A box that strikes the ground with a corner leaves as one impulse says.

    Turned anyhow, one corner 5 cm or more below the others; without friction, of any restitution.
    """
    rng, up, wanted = run.fresh_rng(), np.array([0.0, 0.0, 1.0]), run.count(6, 40, 400)
    measured: list[np.ndarray] = []
    expected, scale = [], []
    while len(measured) < wanted:
        size, turn = rng.uniform(0.4, 1.0, 3), random_orientations(rng, 1)[0]
        corners = corners_of(size) @ rotation_matrix(turn).T
        lowest, second = np.argsort(corners[:, 2])[:2]
        if corners[second, 2] - corners[lowest, 2] < 0.05:
            continue
        down, gap, e = rng.uniform(0.5, 1.5), 5e-3, rng.random()
        place = np.array([0.0, 0.0, gap - corners[lowest, 2]])
        velocity = np.array([*rng.normal(size=2), -down])
        pair = boxes((size, rng.uniform(0.5, 2.0), place, turn, velocity), ground(), restitution=e)
        now, then = struck(move, pair, gap, down, place + corners[lowest] - gap * up, up)
        measured.append(now)
        expected.append(then)
        scale.append(pair.mass[0] * np.linalg.norm(velocity))
    return Comparison(np.array(measured), np.array(expected), np.array(scale))


@asks("move_boxes", **ONE_IMPULSE)
def crossing(run: Run, move: Answer) -> Comparison:
    """Two boxes whose edges cross part as one impulse says.

    Cubes on edge, one edge across the other and off their middles, all turned anyhow; without friction.
    """
    rng, measured, expected, scale = run.fresh_rng(), [], [], []
    for _ in range(run.count(6, 40, 400)):
        frame = Rotation.random(random_state=int(rng.integers(2**31)))
        (a, b), gap, closing, e = rng.uniform(0.4, 0.8, 2), 5e-3, rng.uniform(0.5, 1.5), rng.random()
        off_a, off_b = rng.uniform(-0.3, 0.3, 2) * (a, b)  # [m] of the crossing from the middles of the edges
        on_edge = Rotation.from_rotvec(0.25 * np.pi * np.eye(3)[:2])  # about x, and about y
        turns = np.roll((frame * on_edge).as_quat(), 1, axis=1)
        drift = rng.normal(size=3)
        mass, velocity = rng.uniform(0.5, 2.0, 2), drift + frame.apply([0.0, 0.0, -closing])
        above, below = frame.apply([[-off_a, 0.0, a / 2**0.5 + gap], [0.0, -off_b, -b / 2**0.5]])
        rows = ((a,) * 3, mass[0], above, turns[0], velocity), ((b,) * 3, mass[1], below, turns[1], drift)
        pair = boxes(*rows, restitution=e)
        now, then = struck(move, pair, gap, closing, np.zeros(3), frame.apply([0.0, 0.0, 1.0]))
        measured.append(now)
        expected.append(then)
        scale.append(pair.mass.sum() * np.linalg.norm(pair.velocity, axis=1).max())
    return Comparison(np.array(measured), np.array(expected), np.array(scale))


def leaning(motion: Motion, box: int) -> np.ndarray:
    """Return by how much [rad] a box leans towards +x, at each time."""
    return np.array([np.arctan2(m[0, 2], m[2, 2]) for m in map(rotation_matrix, motion.orientation[:, box])])


def fallen(start: float, rate: float, time: float) -> float:
    """Return how far [rad] what begins at rest `start` off its unstable balance is from it: φ'' = rate² sin φ."""
    m = np.cos(0.5 * start) ** 2
    _, cn, dn, _ = ellipj(rate * time, m)
    return float(2.0 * np.arccos(np.sqrt(m) * cn / dn))


@asks(
    "move_boxes",
    roundings=4_000,
    reference="closed form: a pendulum upside down, by Jacobi's elliptic functions",
    unit="of the angle",
    tolerance=5e-3,
    because=PIVOT,
)
def tip_over(run: Run, move: Answer) -> Comparison:
    """A tower past its balance falls about its edge as a pendulum does."""
    rng, measured, expected = run.fresh_rng(), [], []
    for _ in range(run.count(6, 30, 200)):
        size = np.array([rng.uniform(0.1, 0.3), 0.5, 1.0])
        balance, reach = np.arctan(size[0]), 0.5 * np.hypot(size[0], 1.0)
        start, rate = rng.uniform(0.05, 0.15), np.sqrt(0.75 * G / reach)
        lean = balance + start
        place = reach * np.array([np.sin(start), 0.0, np.cos(start)])
        end_angle = rng.uniform(0.35, 0.5)
        steps = int(np.arccosh(end_angle / start) / rate / FINE)
        end = move(boxes(ground(), (size, 1.0, place, tilted(lean)), gravity=G, friction=1.0), FINE, steps, steps)
        measured.append(leaning(end, 1)[-1] - balance)
        expected.append(fallen(start, rate, steps * FINE))
    return Comparison(np.array(measured), np.array(expected), np.array(expected))


@asks(
    "move_boxes",
    roundings=4_000,
    reference="closed form: Housner's rocking block",
    unit="of the tilt",
    tolerance=1e-2,
    because=f"{PIVOT}, on both swings; and the impact is seen up to ω h early",
)
def rock(run: Run, move: Answer) -> Comparison:
    """A rocking block keeps 1 − 3/2 sin² α of its spin at each impact.

    Let go on one edge it comes to stand on the other as high as that says: α is the angle of its diagonal.
    """
    rng, measured, expected = run.fresh_rng(), [], []
    for _ in range(run.count(6, 30, 200)):
        size = np.array([rng.uniform(0.15, 0.3), 0.4, 1.0])
        alpha, reach = np.arctan(size[0]), 0.5 * np.hypot(size[0], 1.0)
        start, rate = alpha * rng.uniform(0.4, 0.8), np.sqrt(0.75 * G / reach)
        keeps = 1.0 - 1.5 * np.sin(alpha) ** 2
        rest = np.cos(alpha)
        peak = alpha - np.arccos(rest + keeps**2 * (np.cos(alpha - start) - rest))
        times = [np.arccosh(1.0 / (1.0 - swing / alpha)) / rate for swing in (start, peak)]
        place = reach * np.array([-np.sin(alpha - start), 0.0, np.cos(alpha - start)])
        block = boxes(ground(), (size, 1.0, place, tilted(start)), gravity=G, friction=0.8)
        way = move(block, FINE, int(1.1 * sum(times) / FINE) // 8 * 8, 8)
        measured.append(-leaning(way, 1).min())
        expected.append(peak)
    return Comparison(np.array(measured), np.array(expected), np.array(expected))


@asks(
    "move_boxes",
    roundings=4_000,
    reference="Lagrange's equation, solved by SciPy's DOP853",
    kind=LIBRARY,
    unit="of the angle that it gains",
    tolerance=1e-2,
    because="Euler's steps, first order: p h, p < 5/s, h = 1 ms",
)
def slip_down(run: Run, move: Answer) -> Comparison:
    """A plank without friction slides down a wall as Lagrange says.

    Until its foot is far out: not yet where it leaves the wall.
    """
    rng, measured, expected = run.fresh_rng(), [], []
    for _ in range(run.count(6, 30, 200)):
        start, thick, wall = rng.uniform(0.3, 0.6), rng.uniform(0.03, 0.1), ((1.0, 20.0, 20.0), HELD, (0.5, 0.0, 0.0))
        end_angle = np.arccos(0.8 * np.cos(start))

        def rates(_: float, state: np.ndarray, t: float = thick) -> list[float]:
            s, c = np.sin(state[0]), np.cos(state[0])
            inertia = (1.0 + t * t) / 3.0 - t * s * c  # of 1 kg and 1 m: the centre's motion, and (1 + t²) / 12
            force = 0.5 * G * (s - t * c) + 0.5 * t * (c * c - s * s) * state[1] ** 2
            return [state[1], force / inertia]

        def there(_: float, state: np.ndarray, limit: float = end_angle) -> float:
            return float(state[0] - limit)

        there.terminal = True  # type: ignore[attr-defined]
        path = solve_ivp(
            rates, (0.0, 5.0), [start, 0.0], "DOP853", events=there, rtol=1e-11, atol=1e-12, dense_output=True
        )
        steps = int(path.t[-1] / COARSER)
        place = -0.5 * (thick * np.cos(start) + np.sin(start)), 0.0, 0.5 * (thick * np.sin(start) + np.cos(start))
        plank = (thick, 0.5, 1.0), 1.0, place, tilted(start)
        end = move(boxes(ground(), wall, plank, gravity=G), COARSER, steps, steps)
        measured.append(leaning(end, 2)[-1] - start)
        expected.append(float(path.sol(steps * COARSER)[0]) - start)
    return Comparison(np.array(measured), np.array(expected), np.array(expected))
