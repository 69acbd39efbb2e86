"""Many boxes between walls: thrown about, and poured."""

from __future__ import annotations

from typing import Any

import numpy as np

from references import exact
from validation.cases import random_orientations
from validation.check import Comparison, Run
from validation.subject import Boxes, Motion, asks
from validation.subject_claims.boxes import HELD, Answer, G, boxes, momenta

FAMILY = "bins and rooms"
STEP, COARSE = 1.0 / 240.0, 1.0 / 120.0  # [s]
THICK = 0.5  # [m] of walls


def walls(inside: float, height: float, roof: bool = True) -> list[tuple]:
    """Return the held walls of a room, its floor at 0."""
    wide, tall = inside + 2.0 * THICK, height + 2.0 * THICK
    off, middle = 0.5 * (inside + THICK), 0.5 * height
    found = [((THICK, wide, tall), HELD, (side * off, 0.0, middle)) for side in (-1.0, 1.0)]
    found += [((wide, THICK, tall), HELD, (0.0, side * off, middle)) for side in (-1.0, 1.0)]
    return found + [
        ((wide, wide, THICK), HELD, (0.0, 0.0, z)) for z in (-0.5 * THICK, height + 0.5 * THICK)[: 1 + roof]
    ]


def gaps_of(all_boxes: Boxes, end: Motion) -> np.ndarray:
    """Return (f, m) [m]: how far, at the end, each of f boxes that may move is from each of m; minus the depth inside.

    Of what is far apart, how far the balls about both are. What is nowhere is no number from anything.
    """
    size, place, turn = all_boxes.size, end.position[-1], end.orientation[-1]
    reach, free = 0.5 * np.linalg.norm(size, axis=1), np.flatnonzero(np.isfinite(all_boxes.mass))
    if not np.isfinite([*place.flat, *turn.flat]).all():
        return np.full((len(free), len(size)), np.nan)
    gaps = np.linalg.norm(place[free, None] - place, axis=2) - reach[free, None] - reach
    for row, i in zip(gaps, free):
        near = row < 0.0
        row[i], near[i] = np.inf, False
        for j in np.flatnonzero(near):
            row[j] = exact.box_separation(size[i], place[i], turn[i], size[j], place[j], turn[j])
    return gaps


@asks(
    "move_boxes",
    roundings=720 * 4,
    reference="invariant: kinetic energy",
    kind="invariant",
    unit="of the energy before",
    tolerance=1e-4,
    because="impulses at which sweeps stop, 1e-6 as of `gain_nothing`, in some 100 impacts; a box outside counts as 1",
)
def room(run: Run, move: Answer) -> Comparison:
    """Boxes that fly about in a closed room stay and keep their energy.

    Eight cubes, whose flight is no question of steps, without loss and friction, for 3 s.
    """
    rng, measured = run.fresh_rng(), []
    for _ in range(run.count(6, 20, 100)):
        rows = []
        for cell, turn in zip(np.ndindex(2, 2, 2), random_orientations(rng, 8)):
            place = np.array(cell) * [1.2, 1.2, 1.2] + [-0.6, -0.6, 0.9]
            rows.append(
                (
                    (rng.uniform(0.2, 0.6),) * 3,
                    rng.uniform(0.5, 2.0),
                    place,
                    turn,
                    2.0 * rng.normal(size=3),
                    rng.normal(size=3),
                )
            )
        full = boxes(*walls(3.0, 3.0), *rows, restitution=1.0)
        end = move(full, STEP, 720, 720)
        parts: list[Any] = [part[6:] for part in full[:6]]
        free = Boxes(*parts)
        before = momenta(free.orientation, free.velocity, free.spin, free.position, free)[6]
        after = momenta(end.orientation[-1, 6:], end.velocity[-1, 6:], end.spin[-1, 6:], end.position[-1, 6:], free)[6]
        out = np.abs(end.position[-1, 6:] - [0.0, 0.0, 1.5]).max() > 1.5
        measured.append(after / before + float(out))
    return Comparison(np.array(measured), np.ones(len(measured)))


@asks(
    "move_boxes",
    roundings=720 * 4,
    reference="bounds, and exact rational arithmetic for depths",
    kind="bound",
    unit="of the bound",
    tolerance=1.0,
    because="bounds: depth, or air under a box, 10 g h² (one fall in a step at each contact), speed at rest g h / 4",
)
def pour(run: Run, move: Answer) -> Comparison:
    """Boxes poured into a bin come to rest on each other.

    Six of them, turned anyhow: none is inside another after 6 s, and none floats.
    """
    rng, measured, kinds = run.fresh_rng(), [], []
    for _ in range(run.count(3, 10, 50)):
        rows = [
            (rng.uniform(0.25, 0.45, 3), rng.uniform(0.5, 2.0), (*rng.uniform(-0.15, 0.15, 2), 0.5 + 0.8 * k), turn)
            for k, turn in enumerate(random_orientations(rng, 6))
        ]
        full = boxes(*walls(1.2, 2.0, roof=False), *rows, gravity=G, friction=0.5)
        end = move(full, COARSE, 720, 720)
        speed = np.linalg.norm(np.hstack([end.velocity[-1, 5:], end.spin[-1, 5:]]), axis=1).max()
        gaps, fall = gaps_of(full, end), 10.0 * G * COARSE**2
        measured += [-gaps.min(initial=0.0) / fall, gaps.min(axis=1).max() / fall, speed / (0.25 * G * COARSE)]
        kinds += ["depth", "air", "speed"]
    return Comparison(np.array(measured), np.zeros(len(measured)), groups=kinds)
