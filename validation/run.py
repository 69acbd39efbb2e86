"""A validation run: claims, then timings, films and rules; whatever cuts it short, what is done is kept."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass, field
from datetime import datetime, timezone
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import softbody
from validation.check import Check, all_checks
from validation.cluster import CannotJudgeThereError
from validation.coverage import unnamed_functions
from validation.declared import Declared
from validation.draws import seeds_of, together
from validation.engines import environment, revision, version_of, versions
from validation.errata import open_errata
from validation.journal import Journal
from validation.judge import blank_record
from validation.order import soonest_first
from validation.plain_text import plain
from validation.record import Report, Setting, Subject
from validation.runner import LIMITS, run_checks, run_tasks
from validation.sensitivity import sensitivity
from validation.subject import checks_of, settings_of
from validation.terminal import Terminal
from validation.worker import Task

if TYPE_CHECKING:
    from validation.cluster import Cluster

TRIED = Path("build")  # where planted faults and mutants leave what they have shown


@dataclass(frozen=True)
class Plan:
    """What to run, and where to leave it."""

    checks: list[Check]
    level: str
    seed: int
    jobs: int
    out: Path
    timings: bool
    pictures: bool
    patterns: list[str]
    subject: Declared | None = None  # who is judged; None: the core
    cluster: Cluster | None = None  # who judges; None: processes here
    draws: int = 1  # of each claim's cases

    @property
    def seeds(self) -> list[int]:
        """One a draw."""
        return seeds_of(self.seed, self.draws)


@dataclass
class Now:
    """What is running, so that it can be named when it is cut short."""

    part: str = "the claims"
    names: set[str] = field(default_factory=set)

    def __str__(self) -> str:
        return self.part + (f", at {', '.join(sorted(self.names))}" if self.names else "")


def run_all(
    plan: Plan, journal: Journal, terminal: Terminal
) -> tuple[Report, KeyboardInterrupt | CannotJudgeThereError | None]:
    """Run what is planned; return the report, and what cut it short. Raises OSError if nothing can be kept.

    Claims that the journal has are not judged again.
    """
    start, now = time.perf_counter(), Now()
    report = blank_report(plan)
    cut_short = None
    try:
        judge_all(plan, journal, terminal, now)
        if plan.timings:
            now.part = "the timings"
            add_timings(report, terminal)
        if plan.pictures:
            now.part = "the films"
            add_pictures(report, plan, terminal, now)
    except (KeyboardInterrupt, CannotJudgeThereError) as stop:
        cut_short = stop
        terminal.say(f"{plain(stop) or 'Interrupted'} in {now}: writing what is done.")
        if now.part == "the timings":
            report.timings_why = "interrupted"
    for check in plan.checks:
        done = [journal.records[check.id, seed] for seed in plan.seeds if (check.id, seed) in journal.records]
        record = together(done) if done else blank_record(check, plan.seed)
        if not done:
            record.why = "interrupted while it ran" if check.id in now.names else "interrupted before it began"
        elif len(done) < plan.draws:
            record.notes = [*record.notes, f"interrupted: {len(done)} of {plan.draws} draws are judged"]
        report.claims.append(record)
    report.seconds = time.perf_counter() - start
    return report, cut_short


def blank_report(plan: Plan) -> Report:
    """Return a report without any result."""
    return Report(
        level=plan.level,
        seed=plan.seed,
        draws=plan.draws,
        created=datetime.now(timezone.utc).isoformat(timespec="seconds"),
        seconds=0.0,
        softbody_version=softbody.__version__,
        revision=revision(Path(softbody.__file__).parent),
        environment=environment(),
        engines=versions(),
        claims=[],
        timings_why="not asked for (--timings)",
        patterns=plan.patterns,
        registered=len(checks_of(plan.subject.name) if plan.subject else all_checks()),
        sensitivity=None if plan.subject else sensitivity(TRIED),
        subject=Subject(plan.subject.name, version_of(plan.subject)) if plan.subject else None,
        settings=[Setting(*map(plain, row)) for row in settings_of(plan.subject)],
        open_errata=[] if plan.subject else open_errata(plan.checks),
        unnamed=[] if plan.subject else unnamed_functions(),
    )


def judge_all(plan: Plan, journal: Journal, terminal: Terminal, now: Now) -> None:
    """Judge all claims that the journal has not, and write each to it as it ends."""
    every = [(check, seed) for seed in plan.seeds for check in soonest_first(plan.checks, plan.out)]
    left = [(check, seed) for check, seed in every if (check.id, seed) not in journal.records]
    if len(left) < len(every):
        what = "claims" if plan.draws == 1 else "claims, by seeds of their own,"
        terminal.say(f"{len(every) - len(left)} of {len(every)} {what} have been judged before.")
    if not left:
        return

    def started(name: str) -> None:
        now.names.add(name)
        terminal.started(name)

    records = run_checks(left, plan.level, plan.jobs, started, cluster=plan.cluster)
    with terminal.following("claims", len(left)), closing(records):
        for record in records:
            journal.add(record)
            now.names -= {record.id, f"{record.id} (seed {record.seed})"}
            terminal.ended(record)


def add_timings(report: Report, terminal: Terminal) -> None:
    """Measure what steps cost, and how long a start takes; what fails is left out, and said."""
    from validation.startup import measure_startup
    from validation.timings import add_trends, measure_timings

    terminal.say("timing …")
    try:
        report.timings, report.goals, why = measure_timings(report.level)
        report.timings_why = None if report.timings else why
        report.trends_why = add_trends(report.timings) if report.timings else None
        report.figures = measure_startup(report.level)
    except Exception as error:
        failed = plain(f"{type(error).__name__}: {error}")
        terminal.say(f"timings: {failed}")
        if not report.timings:
            report.timings_why = failed


def add_pictures(report: Report, plan: Plan, terminal: Terminal, now: Now) -> None:
    """Film the scenes, and run the paper's by its own rules beside the defaults; what fails is left out, and said."""
    from validation import behaviour, pictures

    film = partial(pictures.make_picture, folder=plan.out / "pictures")
    for picture in each_scene("films", {one.name: (film, one) for one in pictures.SCENES}, plan, terminal, now):
        report.pictures.append(picture)
    now.part = "the paper's rules"
    scenes = {one: (behaviour.behaviours_of, one) for one in [*behaviour.SCENES, behaviour.SHOTS]}
    for rules in each_scene("rules", scenes, plan, terminal, now):
        report.behaviours.extend(rules)


def each_scene(
    label: str, scenes: dict[str, tuple[Callable[..., Any], Any]], plan: Plan, terminal: Terminal, now: Now
) -> Iterator[Any]:
    """Yield what becomes of each scene that ends well, in the order of the scenes."""
    lanes = [[Task(name, work, (scene,), LIMITS[plan.level])] for name, (work, scene) in scenes.items()]
    seen: dict[str, Any] = {}

    def started(name: str) -> None:
        now.names.add(name)
        terminal.started(f"{label}: {name}")

    ending = run_tasks(lanes, plan.jobs, started)
    with terminal.following(label, len(scenes)), closing(ending):
        for ended in ending:
            now.names.discard(ended.task.name)
            terminal.ended()
            if ended.how is None:
                seen[ended.task.name] = ended.answer
            else:
                terminal.say(f"{label}: {ended.task.name} is left out: {ended.why}")
    yield from (seen[name] for name in scenes if name in seen)
