"""A league is played: cell by cell, engines in turns, each in a process of its own."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass
from datetime import datetime, timezone
from math import inf
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any

import softbody
from validation.check import Run
from validation.effort import USUAL
from validation.engines import environment, missing, revision, version_of
from validation.foreign.__main__ import engines as foreign_engines
from validation.foreign.__main__ import made
from validation.from_json import from_json
from validation.journal import digest_of, identity
from validation.league.cells import CANNOT, Cell, cost_of, efforts, matters, play
from validation.league.drawing import drawn
from validation.league.record import EngineRow, League, TaskRow
from validation.record import FAILS, NOT_RUN
from validation.runner import GLANCE
from validation.subject import CLAIMS, SubjectClaim, checks_of, settings_of, subjects
from validation.terminal import Terminal
from validation.worker import Ended, Task, Worker, memory_each

HOST = "softbody"
# Seconds that a cell may be expected to take: an engine that is slow as usual does not try harder at a low level.
BUDGETS = {"quick": 15.0, "standard": 60.0, "full": inf}
LIMITS = {"quick": 300.0, "standard": 300.0, "full": 1_800.0}  # seconds of a cell
JOURNAL = "league.jsonl"
Place = tuple[str, str, float, float]  # of a cell: task, engine, steps, iterations


@dataclass(frozen=True)
class Plan:
    """What is played, and where it is kept."""

    level: str
    seed: int
    jobs: int
    out: Path
    tasks: list[str]
    engines: list[str]
    resume: bool = False
    limit: float | None = None  # [s] of a cell; None: the level's


class OtherRunError(Exception):
    """What was begun there is another run."""


def played(plan: Plan, terminal: Terminal) -> League:
    """Return the league of a plan; after an interrupt, what is done of it."""
    begun, started = time.monotonic(), datetime.now(timezone.utc).isoformat(timespec="seconds")
    checks_of(HOST)
    hindered = _hindrances(plan.engines, terminal)
    cells: dict[Place, Cell] = {}
    waiting: list[Place] = []
    for task in plan.tasks:
        claim = CLAIMS[task]
        for engine in plan.engines:
            usual: Place = task, engine, USUAL.steps, USUAL.iterations
            if claim.question not in subjects()[engine].functions:
                why = subjects()[engine].cannot.get(claim.question, f"its adapter has no {claim.question}")
                cells[usual] = Cell(*usual, state=CANNOT, why=why)
            elif hindered.get(engine):
                cells[usual] = Cell(*usual, state=NOT_RUN, why=hindered[engine])
        able = [one for one in plan.engines if (task, one, USUAL.steps, USUAL.iterations) not in cells]
        waiting += [(task, one, hard.steps, hard.iterations) for hard in efforts(claim, plan.level) for one in able]
    with _Journal(plan) as journal:
        cells |= {place: cell for place, cell in journal.kept.items() if place in set(waiting)}
        rest = [place for place in waiting if place not in cells]
        with terminal.following("the league", len(rest)), suppress(KeyboardInterrupt):
            for cell in _cells(rest, plan, terminal):
                cells[cell.task, cell.engine, cell.steps, cell.iterations] = cell
                journal.keep(cell)
                terminal.ended()
                if cell.state == FAILS:
                    terminal.say(f"{cell.engine} at {cell.task}: {cell.why}")
    return League(
        level=plan.level,
        seed=plan.seed,
        started=started,
        seconds=time.monotonic() - begun,
        revision=revision(Path(softbody.__file__).parent),
        machine=environment(),
        suite=suite(),
        engines=[_engine(name) for name in plan.engines],
        tasks=[_task(name, plan) for name in plan.tasks],
        cells=list(cells.values()),
        left=sum(place not in cells for place in waiting),
    )


def suite() -> str:
    """Return a digest of what is asked: cells can be put side by side if theirs is the same."""
    return digest_of("validation.subject_claims", "references")[:16]


def _hindrances(engines: list[str], terminal: Terminal) -> dict[str, str]:
    """Return why engines cannot be asked; environments of their own are made before."""
    found = {}
    for engine in engines:
        if absent := missing(tuple(subjects()[engine].packages)):
            found[engine] = f"{', '.join(absent)} is not installed"
        elif engine in foreign_engines() and (why := made(engine, terminal.say)):
            found[engine] = why
    return found


def _cells(places: list[Place], plan: Plan, terminal: Terminal) -> Iterator[Cell]:
    """Yield cells as they end: at most `jobs` at once, and one of an engine, whose process goes on with its next."""
    waiting, busy, took = list(places), dict[str, Place](), dict[tuple[str, str], float]()
    workers: dict[str, Worker] = {}
    try:
        while waiting or busy:
            for place in list(waiting):
                engine = place[1]
                if len(busy) < plan.jobs and engine not in busy:
                    waiting.remove(place)
                    expected = took.get(place[:2], 0.0) * place[2] * place[3]
                    if expected > BUDGETS[plan.level]:
                        yield Cell(*place, why=f"it would take some {expected:.0f} s, too long for level {plan.level}")
                        continue
                    busy[engine] = place
                    terminal.started(f"{place[0]} · {engine}")
                    if engine not in workers:
                        workers[engine] = Worker(memory_each(plan.jobs))
                    workers[engine].begin(_asked(place, plan))
            wait([one for engine in busy for one in workers[engine].news], GLANCE)
            for engine in list(busy):
                if ended := workers[engine].look():
                    cell = _cell_of(ended, busy.pop(engine))
                    if cell.is_usual:
                        took[cell.task, engine] = cell.seconds
                    yield cell
    finally:
        for worker in workers.values():
            worker.stop()


def _asked(place: Place, plan: Plan) -> Task:
    task, engine, steps, iterations = place
    arguments = task, engine, plan.level, plan.seed, steps, iterations
    return Task(f"{engine}:{task}", play, arguments, plan.limit or LIMITS[plan.level])


def _cell_of(ended: Ended, place: Place) -> Cell:
    """Return what became of a cell, whatever became of its process."""
    try:
        if ended.how is None:
            cell = from_json(Cell, ended.answer)
            if (cell.task, cell.engine, cell.steps, cell.iterations) == place:
                return cell
        why = ended.why or "its answer is about something else"
        return Cell(*place, state=FAILS, why=why, seconds=ended.seconds)
    except (TypeError, ValueError) as error:
        return Cell(*place, state=FAILS, why=f"its answer cannot be kept: {error}")


class _Journal:
    """Cells that have ended, a line of JSON each, after a line that says of which run."""

    def __init__(self, plan: Plan) -> None:
        self._path = plan.out / JOURNAL
        self._run = {**identity(plan.level, plan.seed, "league"), "schema": "softbody-league-cells/1"}
        self._run["subjects"] = {name: version_of(one) for name, one in subjects().items()}
        self.kept: dict[Place, Cell] = {}
        if plan.resume and self._path.is_file():
            self._read()

    def _read(self) -> None:
        first, *lines = self._path.read_text(encoding="utf-8").split("\n")[:-1] or ["{}"]
        if json.loads(first) != self._run:
            raise OtherRunError(f"{self._path} is of another run: level, seed, core, tasks or engines differ")
        for line in lines:
            cell = from_json(Cell, json.loads(line))
            self.kept[cell.task, cell.engine, cell.steps, cell.iterations] = cell

    def __enter__(self) -> _Journal:
        self._path.parent.mkdir(parents=True, exist_ok=True)
        self._file = self._path.open("w", encoding="utf-8")
        self._line(self._run)
        for cell in self.kept.values():
            self.keep(cell)
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def keep(self, cell: Cell) -> None:
        """Write a cell."""
        self._line(asdict(cell))

    def _line(self, data: dict[str, Any]) -> None:
        self._file.write(json.dumps(data, ensure_ascii=False) + "\n")
        self._file.flush()


def _engine(name: str) -> EngineRow:
    subject = subjects()[name]
    version = version_of(subject) or softbody.__version__
    chosen = [list(row) for row in settings_of(subject)]
    return EngineRow(
        name,
        subject.title,
        version,
        subject.precision,
        chosen,
        dict(subject.cannot),
        is_host=name == HOST,
    )


def _task(name: str, plan: Plan) -> TaskRow:
    claim = CLAIMS[name]
    check = claim.check
    return TaskRow(
        id=name,
        family=check.family,
        claim=check.claim,
        detail=check.detail,
        question=claim.question,
        reference=check.reference,
        kind=check.kind,
        because=check.because,
        unit=check.unit,
        tolerance=check.tolerance,
        roundings=claim.roundings,
        matters=matters(claim),
        cost_of=cost_of(claim),
        bodies=drawn(_first(claim, Run(plan.level, plan.seed, name))),
    )


class _SeenError(Exception):
    """A question has been seen."""


def _first(claim: SubjectClaim, run: Run) -> tuple[Any, ...]:
    """Return what a task asks about first."""
    seen: list[Any] = []

    def look(*arguments: Any) -> None:
        seen.extend(arguments)
        raise _SeenError

    with suppress(_SeenError):
        claim.compare(run, look)
    return tuple(seen)
