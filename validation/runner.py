"""Run many checks, each in a process that may crash, or hang, without taking the others along."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable, Generator, Iterable
from dataclasses import asdict, dataclass
from itertools import zip_longest
from multiprocessing.connection import wait
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.check import Check, Run
from validation.judge import blank_record, judge
from validation.leftovers import changed, children_now, core_now, end_children
from validation.plain_text import plain
from validation.record import FAILS, HOLDS, ClaimRecord, finite, from_json
from validation.subject import find_check
from validation.worker import RAISED, Ended, Task, Worker, leave_after_answer, memory_each

if TYPE_CHECKING:
    from validation.cluster import Cluster

# Seconds that one claim may take, the compilation of its kernels included, on a machine that does something else too.
LIMITS = {"quick": 900.0, "standard": 1_200.0, "full": 7_200.0}
MOST_NAMED = 3  # of the names that a claim has changed
# What a claim is declared as, and nobody who judges it changes.
FRAME = ("id", "claim", "piece", "engines", "unit", "tolerance", "because", "seed", "kind", "faults")
GLANCE = 0.1  # [s] between two looks at time and memory


def run_checks(
    runs: list[tuple[Check, int]],
    level: str,
    jobs: int,
    started: Callable[[str], None],
    limit: float | None = None,
    memory: float | None = None,
    cluster: Cluster | None = None,
) -> Generator[ClaimRecord, None, None]:
    """Yield the record of each check and seed as it ends; `started` hears the id, and the seed of a later draw.

    `jobs` workers take the lanes of checks one after the other, so that each kernel is compiled in one process only,
    and help with what is left of others in the end; the lanes of later draws come last, when all is compiled. A
    worker process that dies, holds more than `memory` [bytes] or takes longer than `limit` [s], which is the level's
    else, fails the claim it was at, and a new one goes on with the next. A cluster, if there is one, judges instead: it
    takes the lanes in turn, as its machines compile for themselves.
    """
    here: dict[int, dict[str, list[Check]]] = {}  # seed → lane → its checks
    for check, seed in runs:
        if check.hindrance:
            record = blank_record(check, seed)
            record.verdict, record.why = check.hindrance
            yield record
        else:
            here.setdefault(seed, {}).setdefault(check.lane, []).append(check)
    first = next(iter(here), None)
    lanes = [
        [
            Task(
                check.id if seed == first else f"{check.id} (seed {seed})",
                judged,
                (check.id, level, seed),
                limit or LIMITS[level],
            )
            for check in lane
        ]
        for seed, of_seed in here.items()
        # First the lane with most claims, which is that of worlds: its kernel takes longer to compile than all others.
        for lane in sorted(of_seed.values(), key=len, reverse=True)
    ]
    for ended in (
        cluster.run([task for turn in zip_longest(*lanes) for task in turn if task], started)
        if cluster
        else run_tasks(lanes, jobs, started, memory)
    ):
        yield record_of(ended)


def judged(check_id: str, level: str, seed: int) -> dict[str, Any]:
    """Return the record of a check, as JSON would hold it."""
    check, core, children = find_check(check_id), core_now(), children_now()
    with np.errstate():  # what an engine makes of NumPy's warnings is gone with it
        record = judge(check, Run(level, seed, check_id))
    if left := end_children(children):
        _blame(record, f"left processes that went on: {', '.join(left)}")
    if names := changed(core):
        leave_after_answer()
        _blame(record, f"left the core changed: {', '.join(names[:MOST_NAMED])}")
    data: dict[str, Any] = finite(asdict(record))
    try:
        json.dumps(data)
    except (TypeError, ValueError) as error:
        blank = blank_record(check, seed)
        _blame(blank, f"its record cannot be kept: {plain(error)}")
        return asdict(blank)
    return data


def _blame(record: ClaimRecord, why: str) -> None:
    """Let a claim fail for what it has done, besides what it has compared."""
    record.verdict, record.why = FAILS, plain("; ".join(filter(None, [why, record.why])))


def record_of(ended: Ended) -> ClaimRecord:
    """Return what became of a check, whatever became of its process."""
    check_id, _, seed = ended.task.arguments
    record = blank_record(find_check(check_id), seed)
    why = ended.why
    if ended.how is None:
        try:
            return _framed(record, from_json(ClaimRecord, ended.answer), find_check(check_id))
        except (TypeError, ValueError) as error:
            why = f"its record cannot be kept: {error}"
    record.verdict, record.why, record.seconds = FAILS, why, ended.seconds
    if ended.last_words and ended.how != RAISED:
        record.notes = [f"the process’s last words: {ended.last_words}"]
    return record


def _framed(declared: ClaimRecord, told: ClaimRecord, check: Check) -> ClaimRecord:
    """Return what was found about a claim, in the frame of what it was declared as; raises ValueError."""
    for name in FRAME:
        if getattr(told, name) != getattr(declared, name):
            raise ValueError(f"it says that its {name} is {getattr(told, name)!r}, not {getattr(declared, name)!r}")
    if told.verdict == HOLDS and not (
        told.value is not None and told.value <= check.tolerance and told.n >= check.least
    ):
        raise ValueError(f"it says that it holds, with an error of {told.value} in {told.n} cases")
    return told


@dataclass
class _Lane:
    """Tasks that share what is compiled for them."""

    tasks: deque[Task]
    is_compiled: bool = False  # its first task has ended


def _longest(lanes: Iterable[_Lane]) -> _Lane:
    """Return the lane with most tasks left, of those that may be shared; one without tasks if there is none."""
    return max((lane for lane in lanes if lane.is_compiled), key=lambda lane: len(lane.tasks), default=_Lane(deque()))


def run_tasks(
    lanes: list[list[Task]], jobs: int, started: Callable[[str], None], memory: float | None = None
) -> Generator[Ended, None, None]:
    """Yield what becomes of each task as it ends; one worker does a lane's tasks, one after the other.

    When no lane waits any more, idle workers help with the longest of those whose first task has ended: what they share
    is compiled then, and on disk.
    """
    if memory is None:
        memory = memory_each(jobs)
    waiting = deque(_Lane(deque(lane)) for lane in lanes)
    workers: dict[Worker, _Lane] = {}
    try:
        for _ in range(min(jobs, sum(map(len, lanes)))):
            workers[Worker(memory)] = _Lane(deque())
        while True:
            for worker, lane in workers.items():
                if worker.is_idle and not lane.tasks:
                    lane = waiting.popleft() if waiting else _longest(workers.values())
                if worker.is_idle and lane.tasks:
                    workers[worker], task = lane, lane.tasks.popleft()
                    started(task.name)
                    worker.begin(task)
            busy = [worker for worker in workers if not worker.is_idle]
            if not busy:
                return
            wait([one for worker in busy for one in worker.news], GLANCE)
            for worker in busy:
                ended = worker.look()
                if ended is not None:
                    workers[worker].is_compiled = True
                    yield ended
    finally:
        for worker in workers:
            worker.stop()
