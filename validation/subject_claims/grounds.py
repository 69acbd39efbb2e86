"""Boxes that slide, or tip, over slopes, tiles and grounds of any size."""

from __future__ import annotations

import numpy as np

from validation.cases import rotation_matrix
from validation.check import DISAGREEMENTS, Comparison, Run
from validation.subject import asks
from validation.subject_claims.boxes import COULOMB, HELD, STILL, Answer, G, boxes
from validation.subject_claims.heaps import STEP, became, tilted

FAMILY = "slopes and seams"
STAYS, SLIDES, TIPS = range(3)
EULER = "Euler's steps: the way differs by v h / 2 of v²/2μg, which is μ g h / v"


@asks(
    "move_boxes",
    reference="closed form: Coulomb's law, and the moment about the lower edge",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="one of three answers; tan θ is 5 % or more off μ and w / h, and these 10 % off each other",
)
def slide_or_tip(run: Run, move: Answer) -> Comparison:
    """A box on a slope stays, slides or tips as μ and w / h say.

    It stays if tan θ is below both, slides if μ, and tips if w / h, is the lower one and below tan θ.
    """
    rng, measured, expected = run.fresh_rng(), [], []
    for k in range(run.count(9, 30, 200)):
        outcome = (STAYS, SLIDES, TIPS)[k % 3]
        low = rng.uniform(0.25, 0.6)
        high = low * rng.uniform(1.1, 1.5)
        slope = np.arctan(low * (1.0 + rng.uniform(0.05, 0.3) * (1.0 if outcome else -1.0)))
        friction, shape = (low, high) if outcome == SLIDES or (outcome == STAYS and k % 2) else (high, low)
        size, up = (shape, 0.5, 1.0), np.array([np.sin(slope), 0.0, np.cos(slope)])
        rows = ((50.0, 50.0, 1.0), HELD, np.zeros(3), tilted(slope)), (size, 1.0, up, tilted(slope))
        end = move(boxes(*rows, gravity=G, friction=friction), STEP, 600, 600)
        off = np.linalg.norm(end.position[-1, 1] - up)
        leans = rotation_matrix(end.orientation[-1, 1])[:, 2] @ up < np.cos(0.25)
        measured.append(became(end, TIPS if leans else SLIDES if off > 0.1 else STAYS))
        expected.append(outcome)
    return Comparison(np.array(measured), np.array(expected))


@asks("move_boxes", roundings=1500 * 4, reference=COULOMB, unit="of the way", tolerance=5e-3, because=EULER)
def tiles(run: Run, move: Answer) -> Comparison:
    """A box that slides over seams of tiles stops after v²/2μg.

    Tiles of 0.4 to 0.6 m, side by side in contact: none of them trips it.
    """
    rng, measured, expected = run.fresh_rng(), [], []
    for _ in range(run.count(6, 20, 200)):
        friction, speed, tile = rng.uniform(0.3, 0.7), rng.uniform(1.5, 3.0), rng.uniform(0.4, 0.6)
        way = speed**2 / (2.0 * friction * G)
        rows = [((tile, 3.0, 1.0), HELD, ((k + 0.5) * tile, 0.0, -0.5)) for k in range(-2, int(way / tile) + 3)]
        box = (0.5, 0.4, 0.1), 1.0, (0.0, 0.0, 0.05), STILL, (speed, 0.0, 0.0)
        steps = int(1.2 * speed / (friction * G) / 1e-3)
        end = move(boxes(*rows, box, gravity=G, friction=friction), 1e-3, steps, steps)
        measured.append((end.position[-1, -1] - [0.0, 0.0, 0.05]) / way)
        expected.append([1.0, 0.0, 0.0])
    return Comparison(np.array(measured), np.array(expected))


@asks("move_boxes", roundings=3000 * 4, reference=COULOMB, unit="of the way", tolerance=5e-3, because=EULER)
def any_size(run: Run, move: Answer) -> Comparison:
    """A box slides v²/2μg whether it has millimetres or kilometres.

    Its weight, speed and steps are those of its size, by Froude's law.
    """
    rng, measured, expected, kinds = run.fresh_rng(), [], [], []
    for k in range(run.count(6, 20, 200)):
        metre = (1e-3, 1e-2, 1e-1, 1e1, 1e2, 1e3)[k % 6]
        second = metre**0.5
        friction, speed = rng.uniform(0.3, 0.8), rng.uniform(1.0, 3.0) * metre / second
        way, step = speed**2 / (2.0 * friction * G), 5e-4 * second
        under = (200.0 * metre, 200.0 * metre, 2.0 * metre), HELD, (0.0, 0.0, -metre)
        size = metre * rng.uniform([0.7, 0.7, 0.1], [1.3, 1.3, 0.2])
        box = size, 1000.0 * size.prod(), (0.0, 0.0, 0.5 * size[2]), STILL, (speed, 0.0, 0.0)
        steps = int(1.2 * speed / (friction * G) / step)
        end = move(boxes(under, box, gravity=G, friction=friction), step, steps, steps)
        measured.append((end.position[-1, 1] - [0.0, 0.0, 0.5 * size[2]]) / way)
        expected.append([1.0, 0.0, 0.0])
        kinds.append(f"{metre:g} m")
    return Comparison(np.array(measured), np.array(expected), groups=kinds)


@asks(
    "move_boxes",
    roundings=1200 * 4,
    reference=COULOMB,
    unit="of the box",
    tolerance=2e-7,
    because="what friction holds is right to 2e-11 of some m/s (`ride`): 1e-10 m a step at most, in 1200 steps",
)
def creep(run: Run, move: Answer) -> Comparison:
    """A box that a sloping belt just holds does not creep on it.

    Cubes of 1 m and low boxes, tan θ 5 to 30 % below μ, for 20 s in steps of 1/60 s; after the first second.
    """
    rng, measured, expected = run.fresh_rng(), [], []
    for k in range(run.count(6, 20, 100)):
        friction, height, speed = rng.uniform(0.3, 0.7), (0.2, 1.0)[k % 2], rng.uniform(0.1, 1.0)
        slope = np.arctan(friction * rng.uniform(0.7, 0.95))
        up, climbs = np.array([np.sin(slope), 0.0, np.cos(slope)]), np.array([-np.cos(slope), 0.0, np.sin(slope)])
        belt = (100.0, 50.0, 1.0), HELD, np.zeros(3), tilted(slope), speed * climbs
        box = (1.0, 1.0, height), 1.0, (0.5 + 0.5 * height) * up, tilted(slope), speed * climbs
        way = move(boxes(belt, box, gravity=G, friction=friction), 1.0 / 60.0, 1200, 60).position[:, 1]
        measured.append((way[-1] - way[0]) @ climbs)
        expected.append(19.0 * speed)
    return Comparison(np.array(measured), np.array(expected))
