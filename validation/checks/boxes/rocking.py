"""A claim that blocks rock as real ones do, and so for as long."""

from __future__ import annotations

import numpy as np

from softbody import World
from softbody.collision.boxes import box_contacts
from softbody.collision.solver import sequential_impulses
from softbody.geometry.box import box_corners
from validation.answers import Answers
from validation.check import Comparison, Run, check
from validation.checks.boxes.cases import about
from validation.fault import Fault

FAMILY = "boxes in motion"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

SWINGS = 3
STEPS = (1.0 / 240.0, 1.0 / 2000.0)  # [s]
LOST = 0.95  # of what a step's weight does, by an impact: half of it by the phase in the step, half by Euler's rule


@check(
    section="4.4, 5.2",
    piece="softbody.collision.solver.sequential_impulses.solve_velocities",
    reference="Housner's rocking block: SciPy between impacts, angular momentum about the new edge in them",
    engines=("scipy",),
    unit="of what a step's weight does",
    tolerance=0.8,
    because="an impact falls anywhere in a step: 0.40 to 1.52 are seen of eighty blocks, at both steps alike, and 0 is"
    " Housner's. At 2000 steps a second that is half a percent of a swing",
    faults=(
        Fault("contacts that pull", sequential_impulses._sweep, "where_less(0.0, normal_, normal_, 0.0) → normal_"),
        Fault(
            "a first corner that the ground does not see", box_contacts._add_ground_contacts, "range(8) → range(1, 8)"
        ),
    ),
)
def blocks_rock(run: Run) -> Comparison:
    """A block rocks for as long as Housner says, and no longer.

    It is two to ten times as high as wide, and leans by 0.3 to 0.7 of what would topple it. At each impact it loses
    what Housner says and, as it falls into a step, what the weight does in a quarter to seven quarters of one. So say
    the angles and the times of its next three swings, at 240 and 2000 steps a second.
    """
    from references.rocking import rocking_block

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(4, 20, 100)):
        width = rng.uniform(0.3, 1.0)
        size = width, rng.uniform(0.3, 1.0), width * rng.uniform(2.0, 10.0)
        lean = np.arctan2(width, size[2]) * rng.uniform(0.3, 0.7)
        judged = rocking_block(width, size[2], lean, SWINGS)
        for step in STEPS:
            found = rocked(size, lean, step, float(judged[1][-1]) + 0.1)
            late = rocking_block(width, size[2], lean, SWINGS, late=step)
            for kind, ours, theirs, theirs_late in zip(("angle", "time"), found, judged, late, strict=True):
                answers.extend((theirs - ours) / (theirs - theirs_late), np.full(SWINGS, LOST), kind=kind)
    return answers.comparison()


def rocked(size: tuple[float, float, float], lean: float, step: float, until: float) -> tuple[np.ndarray, np.ndarray]:
    """Return how far [rad] a box of ours leans at the end of each swing, and when [s]."""
    world, q = World(), about(1, lean)
    world.add_ground(friction=1.0)
    low = box_corners(size, (0.0, 0.0, 0.0), tuple(q))[:, 2].min()
    box = world.add_box(size, 1.0, (0.0, 0.0, -low), q, friction=1.0)
    angles = []
    while world.time < until:
        world.step(step)
        angles.append(2.0 * np.arctan2(box.orientation[2], box.orientation[0]))
    angle = np.array(angles)
    ends = np.flatnonzero(angle[1:] * angle[:-1] <= 0.0) + 1
    peaks = [start + np.abs(angle[start:end]).argmax() for start, end in zip(ends, [*ends[1:], len(angle)])][:SWINGS]
    peaks += [peaks[-1] if peaks else 0] * (SWINGS - len(peaks))  # of a block that stands sooner
    return np.abs(angle[peaks]), step * (np.array(peaks) + 1.0)
