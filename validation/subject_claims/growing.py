"""Boxes by the dozen and by the hundred: how errors and costs grow with their number."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from references import exact
from validation.cases import random_orientations
from validation.check import Comparison, Run
from validation.subject import Boxes, asks
from validation.subject_claims.boxes import G, boxes, ground

FAMILY = "many boxes"
SIDE = 0.2  # [m]
STEP, STEPS = 1.0 / 240.0, 480

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
        measured.append(deepest(start.size, end.position[-1], end.orientation[-1]) / (0.01 * SIDE))
        kinds.append(f"{number} boxes")
    return Comparison(np.array(measured), np.zeros(len(measured)), groups=kinds)
