"""Run many checks, each in a process that may crash, or hang, without taking the others along."""

from __future__ import annotations

import queue
import signal
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from multiprocessing import get_context
from multiprocessing.connection import Connection

from validation.check import Check, Run, all_checks
from validation.engines import missing
from validation.judge import blank_record, judge
from validation.record import FAILS, NOT_RUN, ClaimRecord

# Seconds that one claim may take, the compilation of its kernels included, on a machine that does something else too.
LIMITS = {"quick": 900.0, "standard": 1_200.0, "full": 7_200.0}


def run_checks(
    checks: list[Check], level: str, seed: int, jobs: int, started: Callable[[Check], None]
) -> Iterator[ClaimRecord]:
    """Yield the record of each check as it ends; `started` hears of each as it begins.

    `jobs` workers take the lanes of checks one after the other, so that each kernel is compiled in one process only. A
    worker process that dies, or takes longer than the level's limit, fails the claim it was at, and a new one goes on
    with the next.
    """
    waiting: queue.SimpleQueue[list[Check]] = queue.SimpleQueue()
    # First the lane with most claims, which is that of worlds: its kernel takes longer to compile than all others.
    sizes = Counter(check.lane for check in checks)
    for lane_name in sorted(sizes, key=lambda name: -sizes[name]):
        waiting.put([check for check in checks if check.lane == lane_name])
    done: queue.SimpleQueue[ClaimRecord | BaseException] = queue.SimpleQueue()
    stop = threading.Event()
    how = level, seed, LIMITS[level]
    lanes = [threading.Thread(target=_lane, args=(waiting, done, stop, how, started), daemon=True) for _ in range(jobs)]
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
    how: tuple[str, int, float],
    started: Callable[[Check], None],
) -> None:
    worker = Worker()
    level, seed, limit = how
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
                record = blank_record(check, seed)
                absent = missing(check.engines)
                if absent:
                    record.verdict, record.why = NOT_RUN, f"{', '.join(absent)} is not installed"
                else:
                    try:
                        record = worker.judge(check.id, level, seed, limit)
                    except (EOFError, ConnectionError):
                        record.verdict, record.why = FAILS, "the process crashed"
                    except TimeoutError:
                        record.verdict, record.why = FAILS, f"it was not done after {limit:g} s"
                        record.seconds = limit
                done.put(record)
    except BaseException as error:
        done.put(error)
    finally:
        worker.stop()


class Worker:
    """A process that judges one claim at a time; a new one takes its place when it ends, or is ended."""

    def __init__(self) -> None:
        self._start()

    def _start(self) -> None:
        self._end, theirs = get_context("spawn").Pipe()
        self._process = get_context("spawn").Process(target=_serve, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()

    def judge(self, check_id: str, level: str, seed: int, limit: float) -> ClaimRecord:
        """Return the record of a check; raises EOFError or ConnectionError if the process dies, and TimeoutError."""
        try:
            self._end.send((check_id, level, seed))
            if not self._end.poll(limit):
                raise TimeoutError
            record: ClaimRecord = self._end.recv()
        except (OSError, EOFError):  # of which TimeoutError is one
            self.stop()
            self._start()
            raise
        return record

    def stop(self) -> None:
        """End the process, whatever it does."""
        self._process.kill()
        self._process.join()
        self._end.close()


def _serve(end: Connection) -> None:
    """Judge what is asked for, until nobody asks any more; Ctrl-C is for who asks."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    while True:
        try:
            check_id, level, seed = end.recv()
        except EOFError:
            return
        end.send(judge(all_checks()[check_id], Run(level, seed, check_id)))
