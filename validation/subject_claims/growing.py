"""Bodies by the dozen and by the hundred: how errors and costs grow with their number."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from references import exact
from references import scipy as soft_bodies
from validation.cases import random_orientations
from validation.check import Comparison, Run
from validation.subject import Boxes, SoftScene, asks
from validation.subject_claims.boxes import G, boxes, ground
from validation.subject_claims.soft import ball, on_a_face, springs

FAMILY = "many bodies"
SIDE = 0.2  # [m]
STEP, STEPS = 1.0 / 240.0, 480
FALLEN, NEVER = 0.7, 1e3  # part of its mean height at the start that a heap may have; the error of one that is higher

Answer = Callable  # the function of the subject that is asked


def heap(rng: np.random.Generator, count: int) -> Boxes:
    """Return so many boxes, turned anyhow, in layers of a square above the ground, which will fall on each other."""
    across = max(2, round((0.5 * count) ** (1.0 / 3.0)))
    cells = np.array(np.unravel_index(np.arange(count), (count, across, across))).T[:, ::-1]  # layer by layer
    places = 1.5 * SIDE * (cells - [0.5 * (across - 1), 0.5 * (across - 1), 0.0]) + [0.0, 0.0, 1.5 * SIDE]
    sizes = SIDE * rng.uniform(0.6, 1.0, (count, 3))
    rows = [(size, float(size.prod() * 1e3), place, turn) for size, place, turn in zip(sizes, places, random_orientations(rng, count))]  # fmt: skip  # noqa: E501
    return boxes(ground(), *rows, gravity=G, friction=0.5)


def deepest(size: np.ndarray, position: np.ndarray, orientation: np.ndarray) -> float:
    """Return how deep [m] any two boxes, the first of which is the ground, are in each other."""
    reach = 0.5 * np.linalg.norm(size[1:], axis=1)
    pairs = cKDTree(position[1:]).query_pairs(2.0 * reach.max(), output_type="ndarray")
    pairs = pairs[
        np.linalg.norm(position[1:][pairs[:, 0]] - position[1:][pairs[:, 1]], axis=1) < reach[pairs].sum(axis=1)
    ]
    low = np.flatnonzero(position[1:, 2] < reach) + 1
    a, b = np.append(pairs[:, 0] + 1, low), np.append(pairs[:, 1] + 1, np.zeros(len(low), int))
    if not len(a):
        return 0.0
    rows = [part[side] for side in (a, b) for part in (size, position, orientation)]
    return float(max(0.0, -exact.box_separation(*rows).min()))


@asks(
    "move_boxes",
    roundings=20_000,
    reference="exact arithmetic: separations of all pairs that are near",
    kind="bound",
    unit="of a hundredth of the side",
    tolerance=1.0,
    because="a bound: what is deeper than a hundredth of its side is seen",
)
def dropped(run: Run, move: Answer) -> Comparison:
    """Boxes that are dropped in a heap come to lie on each other and not in each other."""
    rng, measured, kinds = run.fresh_rng(), [], []
    numbers = (4, 8, 12, 18, 27, 40)[: run.count(6, 6, 6)] + (100, 300)[: run.count(0, 1, 2)] + (1_000,)[: run.count(0, 0, 1)]  # fmt: skip  # noqa: E501
    for number in numbers:
        start = heap(rng, number)
        end = move(start, STEP, STEPS, STEPS)
        depth = deepest(start.size, end.position[-1], end.orientation[-1]) / (0.01 * SIDE)
        has_fallen = end.position[-1, 1:, 2].mean() < FALLEN * start.position[1:, 2].mean()
        measured.append(depth if has_fallen else NEVER)
        kinds.append(f"{number} boxes")
    return Comparison(np.array(measured), np.zeros(len(measured)), groups=kinds)


@asks(
    "move_soft",
    roundings=5_000,
    reference="SciPy: the least energy of springs, gas and weight above the ground",
    kind="third-party library",
    unit="of the size",
    tolerance=1e-3,
    because="what is left of the fall after 2 s of fading at 8/s, and contacts that give way by less",
)
def stand(run: Run, move: Answer) -> Comparison:
    """Icosahedra with gas that stand side by side on the ground are as high as the least energy says."""
    rng, measured, expected, scale, kinds = run.fresh_rng(), [], [], [], []
    for number in (1, 2, 4, 8, 16, 32)[: run.count(6, 6, 6)] + (64, 128)[: run.count(0, 1, 2)]:
        one = on_a_face(ball(rng, subdivisions=0))
        height = float(np.ptp(one.vertices[:, 2]))
        aside = 2.0 * height * (np.arange(number) - 0.5 * (number - 1))
        up = 0.005 - one.vertices[:, 2].min()
        bodies = tuple(one._replace(vertices=one.vertices + [0.0, y, up]) for y in aside)
        still = tuple(np.zeros_like(body.vertices) for body in bodies)
        end = move(SoftScene(bodies, still, boxes(ground(), gravity=G), drag=8.0), 1e-3, 2000, 2000)
        shell = bodies[0].vertices, *springs(one), one.triangles, one.gas
        least, _ = soft_bodies.between_plates(*shell, one.mass * G, 1e3)
        heights = np.array([place[-1, :, 2].mean() for place in end.position])
        measured.append(heights[np.argmax(np.abs(heights - least[:, 2].mean()))])
        expected.append(least[:, 2].mean())
        scale.append(height)
        kinds.append(f"{number} bodies")
    return Comparison(np.array(measured), np.array(expected), np.array(scale), kinds)
