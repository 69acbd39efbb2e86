"""One cell of the league: one engine at one task, trying so hard; its error, and the work that it took."""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from validation import effort
from validation.check import DISAGREEMENTS, Comparison, NotHereError, Run
from validation.effort import USUAL, Effort
from validation.judge import errors_of
from validation.plain_text import plain
from validation.record import FAILS, NOT_RUN, finite
from validation.subject import CLAIMS, Boxes, SoftScene, SubjectClaim, checks_of, point_of, the_subject

ANSWERED, CANNOT = "answered", "cannot"
STATES = (ANSWERED, CANNOT, NOT_RUN, FAILS)
MOTIONS = ("move_boxes", "move_soft")  # questions about what moves, step by step
MATTERS = 1e-3  # of the size, the speed, the way: an error that a user may see
LEAST_GROWTH = 5  # different numbers of bodies, to see how something grows with them


@dataclass
class Cell:
    """What became of a task."""

    task: str
    engine: str
    steps: float  # as many as asked for, times this
    iterations: float  # as many as usual, times this
    state: str = NOT_RUN  # one of STATES
    why: str | None = None  # it was not answered
    seconds: float = 0.0  # that it took, without what is loaded or compiled first
    n: int = 0  # cases
    error: float | None = None  # the worst, in the task's unit; of yes-or-no answers, the share that is wrong
    median: float | None = None
    bias: float | None = None  # mean of measured − expected, in the task's unit; of answers of one number
    scatter: float | None = None  # standard deviation of the same
    growth: list[list[float]] = field(default_factory=list)  # bodies, cost and error, where tasks differ in bodies
    costs: list[float] = field(default_factory=list)  # quartiles: seconds of the processor per `cost_of`

    @property
    def is_usual(self) -> bool:
        """Whether the engine tries as hard as its adapter says."""
        return Effort(self.steps, self.iterations) == USUAL


def matters(claim: SubjectClaim) -> float:
    """Return the error of a task that a user may see, in its unit: a thousandth, or all of a bound."""
    return 1.0 if claim.check.kind == "bound" else MATTERS


def cost_of(claim: SubjectClaim) -> str:
    """Return what a cost is of."""
    per = {**dict.fromkeys(MOTIONS, "second of the world"), "boxes_overlap": "pair", "points_in_mesh": "point"}
    return per.get(claim.question, "answer")


# Of each question, the least of one, which is asked before work is counted.
FIRST: dict[str, Callable[..., tuple[Any, ...]]] = {
    "move_boxes": lambda boxes, step, *_: (boxes, step, 1, 1),
    "move_soft": lambda scene, step, *_: (scene, step, 1, 1),
    "boxes_overlap": lambda *pairs: tuple(rows[:2] for rows in pairs),
    "points_in_mesh": lambda points, *mesh: (points[:2], *mesh),
}


class CannotTryError(Exception):
    """A question cannot be asked with such steps."""


def play(task: str, engine: str, level: str, seed: int, steps: float, iterations: float) -> dict[str, Any]:
    """Return the cell of a task, as JSON would hold it; what goes wrong is in it."""
    checks_of(engine)
    claim, cell = CLAIMS[task], Cell(task, engine, steps, iterations)
    subject = the_subject(engine)
    try:
        answer = getattr(importlib.import_module(point_of(subject)), claim.question)
        asked = Asked(answer, claim.question, Effort(steps, iterations))
        run = Run(level, seed, claim.check.id)
        run.seed_engines()
        begun = time.perf_counter()
        errors = weigh(cell, claim, claim.compare(run, asked))
        cell.seconds = time.perf_counter() - begun - asked.loading
        cell.costs = np.quantile(asked.costs, [0.25, 0.5, 0.75]).tolist() if asked.costs else []
        if len(set(asked.bodies)) >= LEAST_GROWTH and len(asked.bodies) == len(errors):
            cell.growth = [list(row) for row in zip(asked.bodies, asked.costs, errors.tolist())]
    except (NotHereError, CannotTryError, ModuleNotFoundError) as error:
        cell.why = plain(error)
    except BaseException as error:
        cell.state, cell.why = FAILS, f"raised {type(error).__name__}: {plain(error)}"
    told: dict[str, Any] = finite(asdict(cell))
    return told


def weigh(cell: Cell, claim: SubjectClaim, comparison: Comparison) -> np.ndarray:
    """Fill in errors, and return them; answers that are no numbers fail."""
    counts = claim.check.unit == DISAGREEMENTS
    errors = errors_of(comparison.measured, comparison.expected, comparison.scale, counts)
    cell.n = len(errors)
    if not len(errors) or not np.isfinite(errors).all():
        cell.state, cell.why = FAILS, f"{int((~np.isfinite(errors)).sum())} of {len(errors)} answers are not finite"
        return errors
    cell.state = ANSWERED
    cell.error, cell.median = float(errors.mean() if counts else errors.max()), float(np.median(errors))
    measured, expected = (np.asarray(side, float) for side in (comparison.measured, comparison.expected))
    if measured.ndim == 1 and not counts:
        off = (measured - expected) / comparison.scale
        cell.bias, cell.scatter = float(off.mean()), float(off.std())
    return errors


def number_of_bodies(scene: Boxes | SoftScene) -> int:
    """Return how many bodies a question is about, without the ground, or what holds them."""
    boxes, soft = (scene.boxes, len(scene.bodies)) if isinstance(scene, SoftScene) else (scene, 0)
    return soft + int(np.isfinite(boxes.mass).sum())


class Asked:
    """An engine's function that is asked to try so hard, and whose work is counted."""

    def __init__(self, answer: Callable[..., Any], question: str, hard: Effort) -> None:
        self._answer, self._question, self._hard = answer, question, hard
        self.costs: list[float] = []
        self.loading = 0.0  # [s] of what is no work of its steps
        self.bodies: list[int] = []  # of each question

    def __call__(self, *arguments: Any) -> Any:
        """Return its answer to a question with so many steps more, and so much shorter ones."""
        with effort.trying(self._hard):
            if self._question in MOTIONS:
                scene, step, steps, every = arguments
                self.bodies.append(number_of_bodies(scene))
                arguments = scene, *refined(step, steps, every, self._hard.steps)
            if not self.costs and self._question in FIRST:  # it may compile, or load: that is no work
                begun = time.perf_counter()
                self._answer(*FIRST[self._question](*arguments))
                self.loading = time.perf_counter() - begun
            effort.taken()
            with effort.spending():
                answer = self._answer(*arguments)
        self.costs.append(effort.taken() / self._of(arguments))
        return answer

    def _of(self, arguments: tuple[Any, ...]) -> float:
        """Return what a cost is divided by, as `cost_of` says."""
        if self._question in MOTIONS:
            _, step, steps, _ = arguments
            return float(step * steps)
        return float(len(arguments[0])) if isinstance(arguments[0], np.ndarray) else 1.0


def refined(step: float, steps: int, every: int, factor: float) -> tuple[float, int, int]:
    """Return step, steps and every of a question with `factor` times as many; raises CannotTryError."""
    frames, finer = steps // every, round(factor * every)
    if finer < 1:
        raise CannotTryError(f"a step is looked at each {every} already")
    return step * every / finer, frames * finer, finer


def efforts(claim: SubjectClaim, level: str) -> Iterator[Effort]:
    """Yield how hard engines try at a task: as usual first, then with other steps, then with other iterations."""
    yield USUAL
    reach = {"quick": 1, "standard": 1, "full": 2}[level]
    others = [4.0**n for n in range(-reach, reach + 1) if n]
    if claim.question in (*MOTIONS, "gas_volume", "gas_period"):
        yield from (Effort(steps=one) for one in others)
    if claim.question in MOTIONS and level != "quick":
        yield from (Effort(iterations=one) for one in others)
