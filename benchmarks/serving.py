"""One side of a comparison: a pytest plugin that opens benchmarks, and runs rounds of them, as it is told.

It is told by a process that has another such worker, of another core, and lets them work in turns: nothing runs here
between the rounds. A benchmark is opened again and again, each time with its arrays at other places in memory, which
alone can make the same work some percent slower or faster.
"""

from __future__ import annotations

import ctypes
import gc
import mmap
import os
import random
from collections import deque
from multiprocessing.connection import Connection
from time import perf_counter, process_time
from typing import Any

import pytest
from _pytest.runner import runtestprotocol

from benchmarks.older import understand
from benchmarks.race import Race, nothing, short_name

PIPE = "SOFTBODY_BENCHMARKS_PIPE"  # the environment variable with the number of the pipe's end that is the worker's
COUNTER = "SOFTBODY_BENCHMARKS_COUNTER"  # the one with the library that tells Valgrind what to count
COUNT = "count"  # asked in place of a number of calls
MOST_PADDING = 1024  # pages of memory by which places are moved
KEPT = 400  # openings whose memory is kept, so that the next cannot have it …
MOST_KEPT = 1 << 30  # … and of large ones fewer: this many bytes

Times = tuple[float, float]  # [s] on the clock, and of the processor: the latter leaves out what else it did meanwhile


class Server:
    """What a worker answers."""

    def __init__(self, pipe: Connection) -> None:
        self.pipe = pipe
        self.core = 0  # on which rounds are run
        self.kept: deque[Any] = deque(maxlen=KEPT)
        self.broken: dict[str, str] = {}  # file → why it could not be read

    def serve(self, race: Race) -> None:
        """Say what the benchmark answers and how long a call takes; then run rounds until told to close it."""
        answer = race.ask()
        self.kept.append(race)
        while memory_of_process() > MOST_KEPT and len(self.kept) > 2:
            self.kept.popleft()
        if race.threads == 1:
            on_cores({self.core})  # where the other side is: it meets the same neighbours there
        self.pipe.send({"answer": answer, "times": times_of(race, 1), "threads": race.threads})
        while (asked := self.pipe.recv()) is not None:
            self.pipe.send(count_call(race) if asked == COUNT else times_of(race, asked))
        self.pipe.send({"answer": race.ask()})

    def move(self, seed: int) -> None:
        """Take some memory, so that what comes next lies elsewhere."""
        rng = random.Random(seed)
        pages = mmap.mmap(-1, mmap.PAGESIZE * rng.randint(1, MOST_PADDING))
        self.kept.append((pages, [bytearray(rng.randint(16, mmap.PAGESIZE)) for _ in range(64)]))


def memory_of_process() -> int:
    """Return how much memory this process has [bytes]; 0 where that cannot be read."""
    try:
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * mmap.PAGESIZE
    except OSError:
        return 0


def on_cores(cores: set[int]) -> None:
    """Stay on some cores, where the system can be told so."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, cores)


def cores_here() -> set[int]:
    """Return the cores that this process may run on."""
    return set(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else {0}


def times_of(race: Race, repeats: int) -> Times:
    """Return how long some calls took in all, each from the start."""
    gc.disable()
    clocks, cpus = 0.0, 0.0
    # Where nothing must be put back, the clock is read once: it takes a microsecond.
    turns, calls = (1, repeats) if race.restore is nothing else (repeats, 1)
    for _ in range(turns):
        race.restore()
        cpu, clock = process_time(), perf_counter()
        for _ in range(calls):
            race.ours()
        clocks, cpus = clocks + perf_counter() - clock, cpus + process_time() - cpu
    gc.enable()
    return clocks, cpus


def count_call(race: Race) -> str:
    """Have the instructions of a call counted: twice, for the first time there is more around it."""
    counter = ctypes.CDLL(os.environ[COUNTER])
    gc.disable()
    for _ in range(2):
        race.restore()
        counter.begin()
        race.ours()
        counter.end()
    gc.enable()
    return COUNT


SERVER = pytest.StashKey[Server]()


class Serving:
    """The plugin."""

    def __init__(self, server: Server) -> None:
        self.server = server

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Note which file cannot be read, such as one that imports what this core has not."""
        if report.failed:
            self.server.broken[short_name(report.nodeid)] = last_line(report.longreprtext)

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Say which benchmarks there are; then open one after another as told, in place of running them all."""
        import softbody

        pipe, cores = self.server.pipe, cores_here()
        items = {short_name(item.nodeid): item for item in session.items}
        offer = {"benchmarks": list(items), "usual": [name for name, item in items.items() if is_usual(item)]}
        pipe.send(offer | {"broken": self.server.broken, "core": softbody.__file__})
        while (asked := pipe.recv()) is not None:
            name, self.server.core, seed = asked
            on_cores(cores)  # while it is made ready
            self.server.move(seed)
            items[name]._initrequest()  # type: ignore[attr-defined]  # as plugins do that run a test again
            pipe.send({"why": why_not(items[name])})
        return True


def pytest_configure(config: pytest.Config) -> None:
    """Take the worker's end of the pipe, and get to know the core."""
    understand()
    server = Server(Connection(int(os.environ[PIPE])))
    config.stash[SERVER] = server
    config.pluginmanager.register(Serving(server))


def is_usual(item: Any) -> bool:
    """Tell whether a benchmark, or this size of it, is compared when nobody says which."""
    usual = item.function.benchmark.usual
    return usual if isinstance(usual, bool) else item.callspec.id in map(str, usual)


def why_not(item: pytest.Item) -> str | None:
    """Run a benchmark; return why it did not come to its end, or None if it did."""
    for report in runtestprotocol(item, log=False, nextitem=None):
        if not report.passed:
            return report.longrepr[2] if isinstance(report.longrepr, tuple) else last_line(report.longreprtext)
    return None


def last_line(text: str) -> str:
    """Return the line of a traceback that says what is wrong."""
    lines = [line for line in text.splitlines() if line.startswith("E ")] or text.splitlines() or [""]
    return lines[-1].removeprefix("E").strip()
