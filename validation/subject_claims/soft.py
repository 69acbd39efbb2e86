"""Bodies with gas that fly, turn, stand, are pressed, bounce and meet."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import softbody
from references import analytic, ground
from references import scipy as soft_bodies
from validation.cases import random_orientations, rotation_matrix
from validation.check import DISAGREEMENTS, Comparison, Run
from validation.subject import NO_BOXES, Boxes, GasBody, SoftScene, asks
from validation.subject_claims.boxes import COULOMB, HELD, NEWTON, STILL, G, boxes
from validation.subject_claims.boxes import ground as floor

FAMILY = "soft bodies in motion"
STEP = 1e-3  # [s]

Answer = Callable  # the function of the subject that is asked


def ball(rng: np.random.Generator, place: object = (0.0, 0.0, 0.0), subdivisions: int = 1) -> GasBody:
    """Return a ball of about half a metre, of 100 to 300 N/m, that its gas swells by 10 to 20 %, turned anyhow."""
    mesh = softbody.icosphere(subdivisions, radius=rng.uniform(0.2, 0.3))
    matrix = rotation_matrix(random_orientations(rng, 1)[0])
    vertices = mesh.vertices @ matrix.T + np.asarray(place, float)
    stiffness, mass = rng.uniform(100.0, 300.0), rng.uniform(0.5, 1.0)
    i, j = mesh.edges.T
    rest_squared = float(stiffness * ((vertices[i] - vertices[j]) ** 2).sum())
    gas = rng.uniform(0.2, 0.5) * rest_squared / 3.0
    inertia = mass / len(vertices) * float(((vertices - vertices.mean(axis=0)) ** 2).sum())
    frequency = float(analytic.breathing_frequency(gas, rest_squared, inertia))
    return GasBody(vertices, mesh.edges, mesh.triangles, stiffness, gas, mass, frequency)


def on_a_face(body: GasBody) -> GasBody:
    """Return a ball turned such that a face is below, and the opposite one above: it stands, and does not roll."""
    a, b, c = body.vertices[body.triangles[0]]
    below = np.cross(b - a, c - a)
    below /= np.linalg.norm(below)
    across = (b - a) / np.linalg.norm(b - a)
    turned = (body.vertices - body.vertices.mean(axis=0)) @ np.array([across, np.cross(across, below), -below]).T
    return body._replace(vertices=turned)


def alone(body: GasBody, velocity: np.ndarray, among: Boxes = NO_BOXES, drag: float = 0.0) -> SoftScene:
    """Return a scene of one body."""
    return SoftScene((body,), (np.broadcast_to(velocity, body.vertices.shape).copy(),), among, drag)


def springs(body: GasBody) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return edges, rest lengths and stiffnesses."""
    i, j = body.edges.T
    return body.edges, np.linalg.norm(body.vertices[i] - body.vertices[j], axis=1), np.full(len(i), body.stiffness)


@asks(
    "move_soft",
    roundings=2_000,
    reference=NEWTON,
    unit="of the way",
    tolerance=2e-3,
    because="Euler's steps: the way differs by g t h / 2, at most h / t of it, of half a second and more",
)
def fall(run: Run, move: Answer) -> Comparison:
    """The middle of a body with gas that is thrown goes along a parabola."""
    rng, measured, expected, scale = run.fresh_rng(), [], [], []
    for _ in range(run.count(6, 20, 100)):
        body, velocity, seconds = ball(rng), rng.normal(size=3), rng.uniform(0.5, 1.0)
        steps = round(seconds / STEP)
        end = move(alone(body, velocity, NO_BOXES._replace(gravity=G)), STEP, steps, steps)
        t = steps * STEP
        measured.append(end.position[0][-1].mean(axis=0) - body.vertices.mean(axis=0))
        expected.append(velocity * t - [0.0, 0.0, 0.5 * G * t**2])
        scale.append(np.linalg.norm(velocity) * t + 0.5 * G * t**2)
    return Comparison(np.array(measured), np.array(expected), np.array(scale))


@asks(
    "move_soft",
    roundings=2_000,
    reference="invariant",
    kind="invariant",
    unit="of the angular momentum",
    tolerance=1e-3,
    because="forces along springs and of gas turn nothing; a step of 1 ms is a thousandth of a turn",
)
def spin(run: Run, move: Answer) -> Comparison:
    """A free body with gas that spins and breathes keeps its angular momentum."""
    rng, measured, expected = run.fresh_rng(), [], []
    for _ in range(run.count(6, 20, 100)):
        body = ball(rng)
        velocity = np.cross(rng.uniform(2.0, 5.0) * rng.normal(size=3), body.vertices - body.vertices.mean(axis=0))
        end = move(SoftScene((body,), (velocity,), NO_BOXES), STEP, 1000, 1000)
        before, after = _turning(body.vertices, velocity), _turning(end.position[0][-1], end.velocity[0][-1])
        measured.append(after / np.linalg.norm(before))
        expected.append(before / np.linalg.norm(before))
    return Comparison(np.array(measured), np.array(expected))


def _turning(position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Return the angular momentum (3,) about the middle, a kilogram a particle."""
    return np.asarray(np.cross(position - position.mean(axis=0), velocity - velocity.mean(axis=0)).sum(axis=0))


@asks(
    "move_soft",
    roundings=5_000,
    reference="SciPy: the least energy of springs, gas and weight above the ground",
    kind="third-party library",
    unit="of the size",
    tolerance=1e-3,
    because="what is left of the fall after 5 s of fading at 8/s, and contacts that give way by less",
)
def stand(run: Run, move: Answer) -> Comparison:
    """An icosahedron with gas on the ground is as high as the least energy says."""
    rng, measured, expected, scale = run.fresh_rng(), [], [], []
    for _ in range(run.count(6, 12, 40)):
        body = on_a_face(ball(rng, subdivisions=0))
        body = body._replace(vertices=body.vertices - [0.0, 0.0, body.vertices[:, 2].min() - 0.01])
        end = move(alone(body, np.zeros(3), boxes(floor(), gravity=G), drag=8.0), STEP, 5000, 5000)
        least, _ = soft_bodies.between_plates(
            body.vertices, *springs(body), body.triangles, body.gas, body.mass * G, 1e3
        )
        measured.append(_heights(end.position[0][-1]))
        expected.append(_heights(least))
        scale.append(float(np.ptp(body.vertices[:, 2])))
    return Comparison(np.array(measured), np.array(expected), np.array(scale))


def _heights(position: np.ndarray) -> list[float]:
    """Return the heights [m] of the middle and of the top."""
    return [float(position[:, 2].mean()), float(position[:, 2].max())]


@asks(
    "move_soft",
    roundings=5_000,
    reference="SciPy: the least energy of springs and gas between two planes",
    kind="third-party library",
    unit="of the volume",
    tolerance=5e-4,
    because="plates of 5 cm/s against fading at 20/s",
)
def pressed(run: Run, move: Answer) -> Comparison:
    """An icosahedron between plates that close slowly keeps the volume of least energy."""
    rng, measured, expected = run.fresh_rng(), [], []
    for _ in range(run.count(6, 12, 40)):
        body = on_a_face(ball(rng, subdivisions=0))
        height, speed = float(np.ptp(body.vertices[:, 2])), 0.05
        low = ((2.0, 2.0, 0.4), HELD, (0.0, 0.0, -0.6 * height - 0.2), STILL, (0.0, 0.0, 0.5 * speed))
        high = ((2.0, 2.0, 0.4), HELD, (0.0, 0.0, 0.6 * height + 0.2), STILL, (0.0, 0.0, -0.5 * speed))
        steps = round(0.25 * height / speed / STEP)
        end = move(alone(body, np.zeros(3), boxes(low, high), drag=20.0), STEP, steps, steps)
        gap = 1.2 * height - speed * steps * STEP
        raised = body.vertices + [0.0, 0.0, 0.5 * gap]
        least, _ = soft_bodies.between_plates(
            raised * [1.0, 1.0, 0.9 * gap / height], *springs(body), body.triangles, body.gas, 0.0, gap
        )
        volume = _volume(least, body.triangles)
        measured.append(_volume(end.position[0][-1], body.triangles) / volume)
        expected.append(1.0)
    return Comparison(np.array(measured), np.array(expected))


def _volume(position: np.ndarray, triangles: np.ndarray) -> float:
    a, b, c = (position[triangles[:, k]] - position.mean(axis=0) for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6.0)


@asks(
    "move_soft",
    roundings=2_000,
    reference="SciPy: DOP853 between events, at which particles meet the ground or leave it",
    kind="third-party library",
    unit="of the size",
    tolerance=1e-2,
    because="particles meet the ground up to a step late, 0.4 mm of 500, and breathing makes more of it",
)
def bounce(run: Run, move: Answer) -> Comparison:
    """An icosahedron with gas that is dropped on smooth ground bounces as it does from event to event."""
    rng, measured, expected, scale = run.fresh_rng(), [], [], []
    for _ in range(run.count(6, 10, 20)):
        body = ball(rng, subdivisions=0)
        body = body._replace(vertices=body.vertices - [0.0, 0.0, body.vertices[:, 2].min() - 0.1])
        step, steps = 0.25 * STEP, 1000
        end = move(alone(body, np.zeros(3), boxes(floor(), gravity=G)), step, steps, steps)
        still = np.zeros_like(body.vertices)
        part = body.mass / len(body.vertices)
        right, _ = ground.bounce(body.vertices, still, springs(body), body.triangles, body.gas, part, G, steps * step)
        measured.append(_heights(end.position[0][-1]))
        expected.append(_heights(right))
        scale.append(float(np.ptp(body.vertices[:, 2])))
    return Comparison(np.array(measured), np.array(expected), np.array(scale))


@asks(
    "move_soft",
    reference="specification: a wall is a wall",
    kind="specification",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="a yes-or-no answer",
)
def hit_a_wall(run: Run, move: Answer) -> Comparison:
    """No particle of a body with gas that is thrown at a plate comes out behind it."""
    rng, through, kinds = run.fresh_rng(), [], []
    for speed in np.repeat([1.0, 3.0, 10.0, 30.0], run.count(2, 5, 20)):
        body, thick = ball(rng, (-0.5, 0.0, 0.0)), 10.0 ** rng.uniform(-2.5, -0.5)
        wall = boxes(((thick, 4.0, 4.0), HELD, (0.5 * thick, 0.0, 0.0)))
        steps = round((1.0 / speed + 0.2) / STEP)
        end = move(alone(body, np.array([speed, 0.0, 0.0]), wall), STEP, steps, steps)
        through.append(bool((end.position[0][-1, :, 0] > 0.5 * thick).any()))
        kinds.append(f"{speed:g} m/s")
    return Comparison(np.array(through), np.zeros(len(through), bool), groups=kinds)


@asks(
    "move_soft",
    roundings=2_000,
    reference="invariant",
    kind="invariant",
    unit="of the momentum before",
    tolerance=1e-9,
    because="impulses are the same on both sides, to rounding",
)
def strike(run: Run, move: Answer) -> Comparison:
    """A box that flies into a body with gas gives it what momentum it loses."""
    rng, measured, expected = run.fresh_rng(), [], []
    for _ in range(run.count(6, 20, 100)):
        body, mass, speed = ball(rng), float(np.exp(rng.uniform(-1.0, 1.0))), rng.uniform(1.0, 4.0)
        (turn,) = random_orientations(rng, 1)
        striker = boxes((rng.uniform(0.2, 0.4, 3), mass, (-0.8, *rng.uniform(-0.1, 0.1, 2)), turn, (speed, 0.0, 0.0)))
        end = move(alone(body, np.zeros(3), striker), STEP, steps := round(1.5 / speed / STEP), steps)
        after = mass * end.boxes.velocity[-1, 0] + body.mass * end.velocity[0][-1].mean(axis=0)
        met = np.linalg.norm(end.boxes.velocity[-1, 0] - striker.velocity[0]) > 0.01 * speed
        measured.append(after / (mass * speed) if met else np.zeros(3))  # who goes through keeps it, too
        expected.append([1.0, 0.0, 0.0])
    return Comparison(np.array(measured), np.array(expected))


@asks(
    "move_soft",
    reference="specification: bodies are not in each other",
    kind="specification",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="a yes-or-no answer: they fly at each other along a line, and one cannot be where the other was",
)
def meet(run: Run, move: Answer) -> Comparison:
    """Two bodies with gas that fly at each other do not go through each other."""
    rng, passed, kinds = run.fresh_rng(), [], []
    for k in range(run.count(6, 20, 100)):
        pair = ball(rng, (-0.5, 0.0, 0.0)), ball(rng, (0.5, 0.0, 0.0))
        speed = float(rng.uniform(0.5, 4.0))
        velocity = tuple(
            np.broadcast_to([way * speed, 0.0, 0.0], one.vertices.shape) for way, one in zip((1, -1), pair)
        )
        steps = round(1.5 / speed / STEP)
        end = move(SoftScene(pair, velocity, NO_BOXES), STEP, steps, steps)
        passed.append(bool(end.position[0][-1, :, 0].mean() > end.position[1][-1, :, 0].mean()))
        kinds.append(f"{k}")
    return Comparison(np.array(passed), np.zeros(len(passed), bool), groups=kinds)


@asks(
    "move_soft",
    roundings=2_000,
    reference=COULOMB,
    unit="of g t²/2",
    tolerance=3e-3,
    because="Euler's steps: h / t = 1.4e-3 of it; and a soft body sinks a little while it slides",
)
def slope(run: Run, move: Answer) -> Comparison:
    """A body with gas slides down a smooth slope by g sin θ t²/2."""
    rng, measured, expected = run.fresh_rng(), [], []
    for _ in range(run.count(6, 20, 100)):
        angle = rng.uniform(0.2, 0.7)
        tilt = (np.cos(0.5 * angle), 0.0, np.sin(0.5 * angle), 0.0)
        up, down = np.array([np.sin(angle), 0.0, np.cos(angle)]), np.array([np.cos(angle), 0.0, -np.sin(angle)])
        body = ball(rng)
        body = body._replace(vertices=body.vertices + up * (1e-3 - (body.vertices @ up).min()))
        plane = boxes(((50.0, 50.0, 1.0), HELD, -0.5 * up, tilt), gravity=G)
        end = move(alone(body, np.zeros(3), plane), STEP, 700, 700)
        way = (end.position[0][-1].mean(axis=0) - body.vertices.mean(axis=0)) @ down
        measured.append(way / (0.5 * G * 0.49))
        expected.append(np.sin(angle))
    return Comparison(np.array(measured), np.array(expected))
