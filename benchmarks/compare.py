"""Comparison of one core's benchmarks with another's: both run in one session, in turns."""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from benchmarks.duel import Duel, Opening, UnableError
from benchmarks.sides import Side
from benchmarks.verdicts import LOOKS, Verdict, verdict_of
from benchmarks.worker import Worker, WorkerError

Said = Callable[[str], None]

SESSION = 4  # openings of a benchmark in the same two processes


@dataclass
class Result:
    """What is known of one benchmark."""

    name: str
    openings: list[Opening] = field(default_factory=list)
    answers_differ: float | None = None  # by how much, relative; None: the same bits
    why: str | None = None  # it could not be compared
    instructions: tuple[int, int] | None = None  # of a call with either core, if they were counted

    @property
    def verdict(self) -> Verdict:
        """What its openings say."""
        return verdict_of([opening.ratio for opening in self.openings])


@dataclass(frozen=True)
class Plan:
    """What is to be compared, and for how long."""

    sides: tuple[Side, Side]
    root: Path  # of the repository, whose benchmarks are run
    level: str
    patterns: tuple[str, ...]  # each is part of the names of some; none: the usual
    budget: float  # [s]
    seed: int = 20081


def compare(plan: Plan, results: dict[str, Result], said: Said) -> None:
    """Fill `results` until all is clear, or the budget is spent. What is in it stays there when this is interrupted.

    After every SESSION openings there are new processes: what one has by chance, the next has not.
    """
    rng, end = random.Random(plan.seed), None
    for count in range(SESSION, LOOKS[-1] + 1, SESSION):
        left = [result for result in results.values() if not result.why and not _is_clear(result)]
        if results and not any(len(result.openings) < count for result in left):
            continue
        try:
            with dueling(plan, rng) as duel:
                if not results:
                    results.update(chosen(duel, plan.patterns))
                    left = [result for result in results.values() if not result.why]
                    if not left:
                        return
                if end is None:
                    _compile(duel, left, said)
                    end = time.monotonic() + plan.budget
                _open_until(count, duel, left, end, said)
        except WorkerError:
            if not any(result.why for result in left):  # none of them was open: the workers cannot start
                raise
        if end is not None and time.monotonic() >= end:
            return


def _compile(duel: Duel, left: list[Result], said: Said) -> None:
    """Open each benchmark once, uncounted: its machine code is made, or loaded."""
    for result in left:
        said(f"{result.name}: ready?")
        _try(duel, result)


def _is_clear(result: Result) -> bool:
    return len(result.openings) in LOOKS and result.verdict.clear


def _open_until(count: int, duel: Duel, left: list[Result], end: float, said: Said) -> None:
    """Open the benchmarks in turns until each has been opened `count` times, or time is up."""
    while True:
        due = [result for result in left if not result.why and len(result.openings) < count]
        if not due:
            return
        for result in due:
            if time.monotonic() >= end:
                return
            said(f"{result.name}, opening {len(result.openings) + 1}")
            opening = _try(duel, result)
            if opening:
                result.openings.append(opening)


def _try(duel: Duel, result: Result) -> Opening | None:
    """Open a benchmark; None, and the reason in the result, if that cannot be."""
    try:
        opening, differ = duel.open(result.name)
    except UnableError as unable:
        result.why = str(unable)
        return None
    except WorkerError as error:
        result.why = str(error)
        raise
    if differ is not None:
        result.answers_differ = max(differ, result.answers_differ or 0.0)
    return opening


@contextmanager
def dueling(plan: Plan, rng: random.Random) -> Iterator[Duel]:
    """Start a worker of each side."""
    with ExitStack() as stack:
        workers = [stack.enter_context(Worker(side, plan.root, plan.level)) for side in plan.sides]
        yield Duel(workers, rng)


def chosen(duel: Duel, patterns: tuple[str, ...]) -> dict[str, Result]:
    """Return an empty result of what the patterns name, or of the usual ones; WorkerError if no file can be read."""
    names = [name for name in duel.benchmarks() if any(one.lower() in name.lower() for one in patterns)]
    names = names if patterns else duel.benchmarks("usual")
    results = {name: Result(name) for name in names}
    broken = duel.broken()
    for result in results.values():
        result.why = broken.get(result.name.split("::")[0])
    if not results and broken:
        raise WorkerError("; ".join(f"{file}: {why}" for file, why in broken.items()))
    return results
