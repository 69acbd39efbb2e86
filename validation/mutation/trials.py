"""Judge many mutants, in the order that costs least: interpreted first, then compiled; quick claims before long."""

from __future__ import annotations

import inspect
import queue
import re
import sys
import tempfile
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import inf
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from validation.bench import CRASHED, GREEN, HUNG, MEASURED, Bench, Seen, limit_of
from validation.check import Check
from validation.mutation.core import mutants_at, write_core
from validation.mutation.results import CRASHED as HAS_CRASHED
from validation.mutation.results import HUNG as HAS_HUNG
from validation.mutation.results import KILLED as IS_KILLED
from validation.mutation.results import STILLBORN, Fate, Ledger
from validation.mutation.sites import Mutant, digest_of

CHEAP = 2.0  # seconds of the processor that a claim may take to be judged interpreted
BUDGET = 8.0  # and all claims on one mutant: compiled they take a small part of it
ASLEEP = 1_200.0  # and compiled, with all mutants asleep, the compilation of its kernels included
TIMED = {"penetration.an_order_of_magnitude_faster"}  # measures time, and switches take some
INTERPRETED, COMPILED = "interpreted", "compiled"


@dataclass(frozen=True)
class Stage:
    """One way of judging: how the core is run, and at which level of the claims."""

    form: str
    level: str
    limit: float  # seconds that a claim may take while all mutants are asleep
    budget: float = inf  # and all claims together, on one mutant


class Trials:
    """What judges mutants, and keeps what becomes of them."""

    def __init__(self, checks: Sequence[Check], seed: int, jobs: int, ledger: Ledger, console: Console) -> None:
        self._checks = {each.id: each for each in checks if each.id not in TIMED and not each.hindrance}
        self._seed, self._jobs, self._ledger, self._console = seed, jobs, ledger, console
        self._files = {
            id: digest_of(inspect.getsource(sys.modules[one.compare.__module__])) for id, one in self._checks.items()
        }
        self._killers: dict[tuple[str, str], list[str]] = {}  # claims that have seen mutants of a function, or ""

    def run(self, mutants: Sequence[Mutant], level: str, forms: Sequence[str], batch: int) -> None:
        """Judge mutants, those of earlier runs by what has not been tried on them yet."""
        fates = [self._ledger.fate_of(mutant) for mutant in mutants]
        for fate in fates:
            if fate.by is not None:
                for function in (fate.mutant.function, ""):
                    self._killers.setdefault((fate.mutant.file, function), []).append(fate.by)
        if INTERPRETED in forms:
            self._run_together(fates, [Stage(INTERPRETED, "quick", CHEAP, BUDGET)])
        levels = ["quick", "standard"] if level == "standard" else ["quick"]
        left = [fate for fate in fates if not fate.is_over] if COMPILED in forms else []
        for first in range(0, len(left), batch):
            self._run_together(left[first : first + batch], [Stage(COMPILED, each, ASLEEP) for each in levels])

    def _open(self, fates: Sequence[Fate], stage: Stage) -> list[str]:
        """Return the claims that have yet to be tried on some of the mutants."""
        waiting = [self._ledger.known(fate) for fate in fates if not fate.is_over]
        slow = self._ledger.slow if stage.form == INTERPRETED else set()
        names = ((claim, self._named(stage.level, claim)) for claim in self._checks)
        return [claim for claim, name in names if name not in slow and any(name not in known for known in waiting)]

    def _named(self, level: str, claim: str) -> str:
        """Return what says that a claim was tried: another one, once its file has changed."""
        return f"{level} {claim} {self._files[claim]}"

    def _run_together(self, fates: Sequence[Fate], stages: Sequence[Stage]) -> None:
        """Judge mutants that are in one core; again without those that do not compile, by the claims that need them."""
        some_do_not_compile = True
        while some_do_not_compile:
            fates = [fate for fate in fates if not fate.is_over]
            if not any(self._open(fates, stage) for stage in stages):
                return
            numbered = dict(enumerate(fates))
            mutants = {number: fate.mutant for number, fate in numbered.items()}
            with tempfile.TemporaryDirectory(prefix="mutants-") as folder, self._bar() as bar:
                place = Path(folder).resolve()
                write_core(mutants, place)
                with Bench(place, stages[0].form == INTERPRETED, self._jobs) as bench:
                    for stage, lane in product(stages, self._lanes()):
                        asleep = self._asleep(numbered, stage, lane, bench, place, bar)
                        self._judge_all(numbered, stage, asleep, bench, bar)
            some_do_not_compile = any(fate.verdict == STILLBORN for fate in fates)

    def _lanes(self) -> list[list[str]]:
        """Return the claims, those together that share kernels; last lanes of several families: those of worlds."""
        lanes: dict[str, list[str]] = {}
        for claim, check in self._checks.items():
            lanes.setdefault(check.lane, []).append(claim)
        families = {lane: len({self._checks[claim].family for claim in claims}) for lane, claims in lanes.items()}
        return [lanes[lane] for lane in sorted(lanes, key=lambda each: (families[each], len(lanes[each])))]

    def _bar(self) -> Progress:
        columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
        return Progress(*columns, TextColumn("left:"), TimeRemainingColumn(), console=self._console)

    def _asleep(
        self, fates: Mapping[int, Fate], stage: Stage, lane: Sequence[str], bench: Bench, place: Path, bar: Progress
    ) -> dict[str, Seen]:
        """Return what claims show that hold while all mutants are asleep; mutants that do not compile are noted."""
        claims = [claim for claim in self._open(list(fates.values()), stage) if claim in lane]
        task = bar.add_task(f"{stage.form}, {stage.level}: claims on the sound core", total=len(claims))
        asleep: dict[str, Seen] = {}
        for claim in claims:
            seen = bench.run_asleep(claim, stage.level, self._seed, stage.limit)
            bar.advance(task)
            if seen.what == GREEN:
                asleep[claim] = seen
            elif stage.form == INTERPRETED and seen.what == HUNG:
                self._ledger.is_slow(self._named(stage.level, claim))
            else:
                bar.console.print(f"{claim} is not used, {seen.what}: {seen.why}", markup=False, soft_wrap=True)
                for number in culprits(seen.why, place):
                    fates[number].verdict, fates[number].form, fates[number].why = STILLBORN, stage.form, seen.why
                    self._ledger.note(fates[number])
        bar.remove_task(task)
        return asleep

    def _judge_all(
        self, fates: Mapping[int, Fate], stage: Stage, asleep: Mapping[str, Seen], bench: Bench, bar: Progress
    ) -> None:
        """Judge mutants side by side, one after the other in each job."""
        if not asleep:
            return
        bench.split()
        waiting: queue.SimpleQueue[int] = queue.SimpleQueue()
        left = [number for number, fate in fates.items() if not fate.is_over]
        for number in left:
            waiting.put(number)
        done: queue.SimpleQueue[BaseException | None] = queue.SimpleQueue()
        stop = threading.Event()
        all_tried: list[Mutant] = []
        task = bar.add_task(f"{stage.form}, {stage.level}: mutants", total=len(left))

        def work(job: int) -> None:
            try:
                while not stop.is_set():
                    try:
                        number = waiting.get_nowait()
                    except queue.Empty:
                        return
                    if self._judge_one(number, fates[number], stage, asleep, bench, job, stop):
                        all_tried.append(fates[number].mutant)
                    done.put(None)
            except BaseException as error:
                done.put(error)

        for job in range(self._jobs):
            threading.Thread(target=work, args=(job,), daemon=True).start()
        try:
            for _ in left:
                error = done.get()
                if error is not None:
                    raise error
                bar.advance(task)
        finally:
            stop.set()
            self._ledger.is_done([self._named(stage.level, claim) for claim in asleep], all_tried)
        bench.join()
        bar.remove_task(task)

    def _judge_one(
        self,
        number: int,
        fate: Fate,
        stage: Stage,
        asleep: Mapping[str, Seen],
        bench: Bench,
        job: int,
        stop: threading.Event,
    ) -> bool:
        """Judge one mutant by the claims that reach it until one sees it; return whether that was not given up before.

        First those that have seen others of its function, or of its file, then the quickest. A mutant that only crashes
        claims is tried on some more, for what they measure; one that hangs is not.
        """
        known, spent = self._ledger.known(fate), 0.0
        one = fate.mutant
        here, near = (self._killers.setdefault(place, []) for place in ((one.file, one.function), (one.file, "")))
        reaching = [claim for claim, seen in asleep.items() if number in seen.reached]
        names = {claim: self._named(stage.level, claim) for claim in reaching}
        waiting = [claim for claim in reaching if names[claim] not in known]
        for claim in sorted(waiting, key=lambda each: (each not in here, each not in near, asleep[each].seconds)):
            if stop.is_set() or spent > stage.budget:
                self._ledger.note(fate)
                return False
            seen = bench.judge(number, claim, stage.level, self._seed, limit_of(asleep[claim].seconds), job)
            fate.seconds += seen.seconds
            spent += seen.seconds
            fate.tried.append(names[claim])
            if seen.what == GREEN:
                if asleep[claim].bits and seen.bits != asleep[claim].bits:
                    fate.changed.append(claim)
                continue
            fate.crashes += seen.what == CRASHED
            fate.by, fate.why, fate.level, fate.form = claim, seen.why, stage.level, stage.form
            fate.verdict = {MEASURED: IS_KILLED, HUNG: HAS_HUNG, CRASHED: HAS_CRASHED}[seen.what]
            if fate.is_over:
                break
        if fate.verdict in (IS_KILLED, HAS_HUNG) and fate.by is not None:
            here.append(fate.by)
            near.append(fate.by)
        if waiting:
            self._ledger.note(fate)
        return True


def culprits(why: str, folder: Path) -> set[int]:
    """Return the mutants that Numba's message is about: those in the first line of the core that it names."""
    if "numba" not in why and "nopython" not in why and "Numba" not in why:
        return set()
    for file, line in re.findall(r'File "([^"]*)", line (\d+)', why):
        _, found, below = file.rpartition("softbody/")
        if found and (folder / "softbody" / below).exists():
            return mutants_at(folder, below, int(line))
    return set()
