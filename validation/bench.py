"""Judge claims on a damaged core, one damage awake at a time, each in a process of its own that may crash or hang.

The server is a process that has imported the damaged core and all claims. For each damage, a planted fault or a mutant,
it forks, and what is forked wakes the damage and runs a claim. So a damage costs what its claims cost, and nothing is
left behind. What a claim shows while all are asleep says which mutants it comes by.
"""

from __future__ import annotations

import os
import resource
import signal
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import nan
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from validation.record import FAILS, HOLDS

PARTS = Path(__file__).parents[1] / "softbody" / "compiler" / "__pycache__" / "parts"  # of the sound core

ASLEEP = -1  # the number of no damage
LEAST_TIME, TIMES = 5.0, 10.0  # a claim may take that many seconds, and times its own, before it is said to hang
PATIENCE = 20.0  # times as long by the clock: other programs may have the processor
MEMORY = 8 << 30  # bytes that a claim may take beyond what the server has

SPLIT, JOIN = ("split",), ("join",)  # what the server is told

MEASURED, CRASHED, HUNG, GREEN = "measured", "crashed", "hung", "green"


@dataclass(frozen=True)
class Seen:
    """What a claim showed of a damage: MEASURED (red by what it compared), CRASHED, HUNG or GREEN; and why."""

    what: str
    why: str = ""
    seconds: float = 0.0  # of the processor
    reached: frozenset[int] = frozenset()  # damages that it came by
    used_threads: bool = False
    bits: str = ""  # digest of all that it measured, and of its worlds after each call; "" if no two runs agree
    off: float = nan  # its largest error, in tolerances; not a number where it counts, or has measured nothing


def seen_of(verdict: str, n: int, why: str) -> str:
    """Return what a claim's record shows of a damage.

    Values off by more than the tolerance, not finite, of another shape or number, and the core's own SimulationError
    are measured. Any other exception is a crash, whatever raised it.
    """
    if verdict == HOLDS:
        return GREEN
    told = why.startswith(("raised SimulationError", "raised ValueError: measured has shape"))
    return MEASURED if verdict == FAILS and (n > 0 or told) else CRASHED


class Bench:
    """A damaged core in a folder, and the server that judges claims on it."""

    def __init__(self, folder: Path, interpreted: bool = False, jobs: int = 1) -> None:
        """Start the server of the core in `folder`, which has a switch; `interpreted`: without Numba's compiler.

        Raises RuntimeError if what the server imports is another core.
        """
        context = get_context("spawn")
        pipes = [context.Pipe() for _ in range(jobs)]
        self._ends = [ours for ours, _ in pipes]
        theirs = [end for _, end in pipes]
        self._server = context.Process(target=_serve, args=(theirs, str(folder), interpreted))
        # Memory that is taken and not filled must not hold what an earlier run of the same claim has left there.
        os.environ["MALLOC_PERTURB_"] = "85"
        self._server.start()
        del os.environ["MALLOC_PERTURB_"]
        for end in theirs:
            end.close()
        place = self._ends[0].recv()
        if Path(place) != folder / "softbody":
            self.close()
            raise RuntimeError(f"the damaged core is {folder / 'softbody'}, and {place} was imported")

    def run_asleep(self, claim: str, level: str, seed: int, limit: float) -> Seen:
        """Judge a claim with all damages asleep, within `limit` seconds of the processor, and have its kernels ready.

        It is judged twice: in a fork, as damages are, and then in the server, whose forks need not compile any more;
        in a fork again, which finds its kernels on the disk, if it starts threads, which no fork survives. So the
        seconds are those without the compiler's.
        """
        seen = self.judge(ASLEEP, claim, level, seed, limit)
        if seen.what != GREEN:
            return seen
        if seen.used_threads:
            again = self.judge(ASLEEP, claim, level, seed, limit)
        else:
            self._ends[0].send(("here", claim, level, seed))
            again = _received(self._ends[0])
        return again if again.bits == seen.bits else replace(again, bits="")

    def split(self) -> None:
        """Let the server fork, so that each job has one of its own, whose kernels are ready; until `join`."""
        self._ends[0].send(SPLIT)
        self._ends[0].recv()

    def join(self) -> None:
        """End all servers but the first."""
        for end in self._ends[1:]:
            end.send(JOIN)

    def judge(self, number: int, claim: str, level: str, seed: int, limit: float, job: int = 0) -> Seen:
        """Judge a claim in a fork with one damage awake; each job asks for itself, once the server is split."""
        self._ends[job].send((number, claim, level, seed, limit))
        return _received(self._ends[job])

    def close(self) -> None:
        """End the server."""
        for end in self._ends:
            end.close()
        self._server.join(2.0)
        self._server.kill()
        self._server.join()

    def __enter__(self) -> Bench:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def limit_of(seconds: float) -> float:
    """Return how long [s of the processor] a claim may take that takes `seconds` with all damages asleep."""
    return LEAST_TIME + TIMES * seconds


def _received(end: Connection) -> Seen:
    seen: Seen = end.recv()
    return seen


def _serve(ends: list[Connection], folder: str, interpreted: bool) -> None:
    """Answer until nobody asks any more; Ctrl-C is for who asks."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.environ |= {"NUMBA_CACHE_DIR": f"{folder}/cache", "NUMBA_DISABLE_JIT": str(int(interpreted))}
    os.environ.setdefault("SOFTBODY_PARTS_IN", str(PARTS))  # what no damage has changed is linked as it is
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    sys.path.insert(0, folder)
    import softbody
    from validation.check import all_checks

    ends[0].send(os.path.dirname(softbody.__file__))
    all_checks()
    _silence()
    end = ends[0]
    while True:
        try:
            asked = end.recv()
        except EOFError:
            return
        if asked == JOIN:
            os._exit(0)
        elif asked == SPLIT:
            end = _forked(ends)
            if end is ends[0]:
                end.send(True)
        else:
            end.send(_judged(asked[1:], ASLEEP) if asked[0] == "here" else _judged_in_fork(*asked))


def _forked(ends: list[Connection]) -> Connection:
    """Return the end that this process, or the fork of it that returns, is to listen to."""
    for other in ends[1:]:
        if os.fork() == 0:
            return other
    return ends[0]


def _judged(run: Sequence[Any], number: int) -> Seen:
    """Judge a claim in this process, with a damage awake."""
    from softbody import switch  # type: ignore[attr-defined]
    from validation.check import Run, all_checks
    from validation.judge import judge
    from validation.trace import traced

    claim, level, seed = run
    switch.AWAKE.value = number
    for k in _set_bits(switch.REACHED):
        switch.REACHED[k] = 0
    start = time.process_time()
    with traced(all_checks()[claim]) as (check, bits):
        record = judge(check, Run(level, seed, claim))
    seconds = time.process_time() - start
    what = seen_of(record.verdict, record.n, record.why or "")
    return Seen(
        what,
        record.why or "",
        seconds,
        frozenset(_set_bits(switch.REACHED)),
        _has_threads(),
        bits.hexdigest(),
        nan if record.value is None or not record.tolerance else record.value / record.tolerance,
    )


def _set_bits(flags: Any) -> Iterator[int]:
    raw = bytes(flags)
    place = raw.find(1)
    while place >= 0:
        yield place
        place = raw.find(1, place + 1)


def _has_threads() -> bool:
    """Tell whether Numba has started threads in this process."""
    parallel = sys.modules.get("numba.np.ufunc.parallel")
    return bool(getattr(parallel, "_is_initialized", False))


def _judged_in_fork(number: int, claim: str, level: str, seed: int, limit: float) -> Seen:
    """Judge a claim in a fork of this process, with a damage awake, and be patient with it for `limit` seconds."""
    ours, theirs = get_context("fork").Pipe(duplex=False)
    child = os.fork()
    if child == 0:
        with suppress(BaseException):
            ours.close()
            _confine(limit)
            theirs.send(_judged((claim, level, seed), number))
        os._exit(0)
    theirs.close()
    try:
        if not ours.poll(PATIENCE * limit):
            return Seen(HUNG, f"it was not done after {PATIENCE * limit:g} s", limit)
        return _received(ours)
    except (EOFError, OSError):
        status = os.waitpid(child, 0)[1]
        child = 0
        if os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGXCPU:
            return Seen(HUNG, f"it was not done after {limit:g} s of the processor", limit)
        return Seen(CRASHED, f"the process ended with status {status}")
    finally:
        ours.close()
        if child:
            with suppress(ProcessLookupError):
                os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)


def _confine(limit: float) -> None:
    """Let this process have so many seconds of the processor, and some memory."""
    used = time.process_time()
    whole = int(used + limit) + 1
    resource.setrlimit(resource.RLIMIT_CPU, (whole, whole + 5))
    with open("/proc/self/statm") as sizes:
        have = int(sizes.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (have + MEMORY, have + MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _silence() -> None:
    """Take the voice of this process: engines talk, and worlds that overlap on purpose warn."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
