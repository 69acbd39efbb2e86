"""Run many checks, each in a process that may crash without taking the others along."""

from __future__ import annotations

import queue
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context

from validation.check import Check, Run, all_checks
from validation.engines import missing
from validation.judge import blank_record, judge
from validation.record import FAILS, NOT_RUN, ClaimRecord


def run_checks(
    checks: list[Check], level: str, seed: int, jobs: int, started: Callable[[Check], None]
) -> Iterator[ClaimRecord]:
    """Yield the record of each check as it ends; `started` hears of each as it begins.

    `jobs` workers take the lanes of checks one after the other, so that each kernel is compiled in one process only. A
    worker process that dies fails the claim it was at, and a new one goes on with the next.
    """
    waiting: queue.SimpleQueue[list[Check]] = queue.SimpleQueue()
    # First the lane with most claims, which is that of worlds: its kernel takes longer to compile than all others.
    sizes = Counter(check.lane for check in checks)
    for lane_name in sorted(sizes, key=lambda name: -sizes[name]):
        waiting.put([check for check in checks if check.lane == lane_name])
    done: queue.SimpleQueue[ClaimRecord | BaseException] = queue.SimpleQueue()
    stop = threading.Event()
    lanes = [
        threading.Thread(target=_lane, args=(waiting, done, stop, level, seed, started), daemon=True)
        for _ in range(jobs)
    ]
    for lane in lanes:
        lane.start()
    try:
        for _ in checks:
            record = done.get()
            if isinstance(record, BaseException):
                raise record
            yield record
    finally:
        stop.set()


def _lane(
    waiting: queue.SimpleQueue[list[Check]],
    done: queue.SimpleQueue[ClaimRecord | BaseException],
    stop: threading.Event,
    level: str,
    seed: int,
    started: Callable[[Check], None],
) -> None:
    worker = _new_worker()
    try:
        while not stop.is_set():
            try:
                checks = waiting.get_nowait()
            except queue.Empty:
                return
            for check in checks:
                if stop.is_set():
                    return
                started(check)
                absent = missing(check.engines)
                if absent:
                    record = blank_record(check, seed)
                    record.verdict, record.why = NOT_RUN, f"{', '.join(absent)} is not installed"
                    done.put(record)
                    continue
                try:
                    done.put(worker.submit(_judge_by_id, check.id, level, seed).result())
                except BrokenProcessPool:
                    record = blank_record(check, seed)
                    record.verdict, record.why = FAILS, "the process crashed"
                    done.put(record)
                    worker = _new_worker()
    except BaseException as error:
        done.put(error)
    finally:
        worker.shutdown(wait=False, cancel_futures=True)


def _new_worker() -> ProcessPoolExecutor:
    return ProcessPoolExecutor(max_workers=1, mp_context=get_context("spawn"))


def _judge_by_id(check_id: str, level: str, seed: int) -> ClaimRecord:
    """Judge one check, in the worker process."""
    return judge(all_checks()[check_id], Run(level, seed, check_id))
