"""Two workers, one of each side, in lock step, for openings of a benchmark in both."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.serving import cores_here
from benchmarks.verdicts import opening_ratio
from benchmarks.worker import Worker, WorkerError

PAIRS, FEW_PAIRS = 6, 2  # rounds of each side an opening: more cost time that another opening spends better
ROUND = 10e-3  # [s] that a round takes at least: the clock costs nothing then, and neighbours change little in it
LONG = 0.1  # [s] of a call: then there are few rounds

Arrays = list[np.ndarray]


@dataclass(frozen=True)
class Opening:
    """What was measured in one opening."""

    ratio: float  # logarithm of the second side's time over the first's
    seconds: tuple[float, float]  # of a call, the median of each side


class UnableError(Exception):
    """A benchmark that a side cannot run, or that gives answers which are not to be trusted: why."""


class Duel:
    """Both workers, and the answers that they have given."""

    def __init__(self, workers: Sequence[Worker], rng: random.Random) -> None:
        self.workers, self.rng = workers, rng
        self.offers = [worker.hear() for worker in workers]
        for worker, offer in zip(workers, self.offers):
            if not offer["core"].startswith(str(worker.side.folder)):
                raise WorkerError(f"{worker.side.name} was to be taken from {worker.side.folder}, not {offer['core']}")

    def benchmarks(self, which: str = "benchmarks") -> list[str]:
        """Return those that either side has, or the "usual" ones of them."""
        return list(dict.fromkeys(name for offer in self.offers for name in offer[which]))

    def broken(self) -> dict[str, str]:
        """Return the files that a side cannot read, and why."""
        return {
            file: f"{worker.side.name} cannot run it: {why}"
            for worker, offer in zip(self.workers, self.offers)
            for file, why in offer["broken"].items()
        }

    def open(self, name: str) -> tuple[Opening, float | None]:
        """Open a benchmark in both; return what was measured, and how far the answers differ (None: not a bit).

        Raises UnableError, or WorkerError where the workers cannot go on.
        """
        for worker, offer in zip(self.workers, self.offers):
            if name not in offer["benchmarks"]:
                raise UnableError(f"{worker.side.name} has no such benchmark")
        core = self.rng.choice(sorted(cores_here()))
        self._tell_both((name, core, self.rng.getrandbits(30)))
        ready = self._hear_both()
        missing = [reply.get("why") for reply in ready]
        if any("why" in reply for reply in ready):
            for worker, reply in zip(self.workers, ready):  # the other one is closed
                if "why" not in reply:
                    worker.tell(None)
                    worker.hear(), worker.hear()
            raise UnableError(_blame([worker.side.name for worker in self.workers], missing))
        kind = 1 if ready[0]["threads"] == 1 else 0  # threads are waited for: only the clock on the wall sees that
        seconds = max(1e-9, min(reply["times"][kind] for reply in ready))
        repeats = max(1, round(ROUND / seconds))
        pairs = [self._pair(repeats, kind, first) for first in self._orders(FEW_PAIRS if seconds > LONG else PAIRS)]
        self._tell_both(None)
        for worker, reply in zip(self.workers, ready):
            last = self._hear(worker)
            if difference(reply["answer"], last["answer"]) is not None:
                raise WorkerError(f"{worker.side.name} answers differently when asked again: give race(…, restore=…)")
        self._hear_both()
        a, b = np.median(pairs, axis=0) / repeats
        return Opening(opening_ratio(pairs), (float(a), float(b))), difference(*(reply["answer"] for reply in ready))

    def _orders(self, count: int) -> list[int]:
        """Return who is first in each pair: either as often, in random order."""
        orders = [0, 1] * (count // 2)
        self.rng.shuffle(orders)
        return orders

    def _pair(self, repeats: int, kind: int, first: int) -> tuple[float, float]:
        times = [0.0, 0.0]
        for k in (first, 1 - first):
            self.workers[k].tell(repeats)
            times[k] = self._hear(self.workers[k])[kind]
        return times[0], times[1]

    def _hear(self, worker: Worker) -> Any:
        """Return what an open benchmark says; raises WorkerError if it has failed: the other one is still open."""
        reply = worker.hear()
        if "why" in reply:
            raise WorkerError(f"{worker.side.name} fails: {reply['why']}")
        return reply

    def _tell_both(self, message: Any) -> None:
        for worker in self.workers:
            worker.tell(message)

    def _hear_both(self) -> list[Any]:
        return [worker.hear() for worker in self.workers]


def difference(a: Arrays, b: Arrays) -> float | None:
    """Return the largest difference between two answers, relative to their size; None if all bits are equal."""
    if [x.shape for x in a] != [x.shape for x in b]:
        return float("inf")
    if all(x.tobytes() == y.tobytes() for x, y in zip(a, b)):
        return None
    pairs = [(np.asarray(x, float), np.asarray(y, float)) for x, y in zip(a, b) if x.size]
    size = max((float(np.abs(x).max()) for x, _ in pairs), default=0.0)
    apart = max((float(np.abs(x - y).max()) for x, y in pairs), default=0.0)
    return apart / size if size > 0.0 else apart


def _blame(names: list[str], reasons: list[str | None]) -> str:
    """Return who cannot run it and why; both for the same reason are said once."""
    if reasons[0] == reasons[1]:
        return str(reasons[0])
    return "; ".join(f"{name} cannot run it: {why}" for name, why in zip(names, reasons) if why)
