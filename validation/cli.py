"""The command line of the validation: what to run, how to show it, which exit code it ends with."""

from __future__ import annotations

import fnmatch
import os
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

if TYPE_CHECKING:
    from validation.check import Check
    from validation.declared import Declared
    from validation.record import Report
    from validation.run import Plan
    from validation.terminal import Terminal

ALL_HOLD, A_CLAIM_FAILS, WRONG_USAGE, ENGINE_MISSING, CANNOT_WRITE, NO_CLUSTER, INTERRUPTED = 0, 1, 2, 3, 4, 5, 130
EXIT_CODES = """\b
Exit code:
  0    all claims hold, or were not run
  1    a claim fails
  2    wrong usage
  3    an engine that was demanded is missing or broken
  4    the output cannot be written: disk, permission
  5    the cluster cannot judge: no scheduler, no workers, or they have another core, claims or engines
  130  interrupted; what was done by then is written, and --resume goes on
"""

# The level of a plain run, and the seed of all random cases.
LEVEL, SEED = "standard", 20080101
OUT, OUT_OF_SOME = Path("build/report"), Path("build/report-k")  # a run of some claims leaves the full report alone

level_option = click.option(
    "--level", type=click.Choice(["quick", "standard", "full"]), default=LEVEL, show_default=True
)
seed_option = click.option(
    "--seed",
    type=click.IntRange(min=0, max=2**63 - 1),
    default=SEED,
    show_default=True,
    help="Of all random cases.",
)


class CannotWrite(click.ClickException):
    """The output cannot be written; the command ends with CANNOT_WRITE."""

    exit_code = CANNOT_WRITE


class NoCluster(click.ClickException):
    """The cluster cannot judge; the command ends with NO_CLUSTER."""

    exit_code = NO_CLUSTER


class Commands(click.Group):
    """Ends with the codes of its own, also where click or Python would end with 1: "a claim fails"."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            click.echo("Interrupted.", err=True)
            ctx.exit(INTERRUPTED)
        except OSError as error:
            raise CannotWrite(str(error)) from error


@click.group(
    cls=Commands,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog=EXIT_CODES,
)
@level_option
@seed_option
@click.option(
    "-k",
    "patterns",
    multiple=True,
    metavar="PATTERN",
    help="Only claims whose id or family contains or matches PATTERN.",
)
@click.option("--subject", metavar="ENGINE", help="Judge ENGINE instead of the core; --list names its claims.")
@click.option("--list", "list_only", is_flag=True, help="List the claims and stop.")
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    help=f"Folder for index.html, report.json and junit.xml.  [default: {OUT}, with -k {OUT_OF_SOME}; of a subject "
    f"{OUT}-ENGINE]",
)
@click.option("--resume", is_flag=True, help="Go on with the run that was cut short in the output folder.")
@click.option(
    "--require", "required", multiple=True, metavar="ENGINE", help="Exit with 3 if ENGINE is missing or broken."
)
@click.option("--require-all", is_flag=True, help="Exit with 3 if any engine that a claim needs is missing or broken.")
@click.option("--timings/--no-timings", default=None, help="Measure step costs too. Default: yes, but not with -k.")
@click.option("--pictures/--no-pictures", default=None, help="Run, film and compare scenes too. Default: as --timings.")
@click.option(
    "--workers",
    "--jobs",
    "jobs",
    type=click.IntRange(min=1),
    default=min(os.cpu_count() or 1, 4),
    show_default=True,
    help="Processes that judge claims side by side; results are the same for any number.",
)
@click.option(
    "--scheduler", metavar="ADDRESS", help="Judge on the workers of a dask cluster, such as tcp://host:8786, instead."
)
@click.option(
    "--draws",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    help="Judge each claim so often, on cases drawn by the seeds from --seed on.",
)
@click.option("--quiet", is_flag=True, help="Say only what does not hold, and the sum.")
@click.pass_context
def main(
    ctx: click.Context,
    level: str,
    seed: int,
    patterns: tuple[str, ...],
    subject: str | None,
    list_only: bool,
    out: Path | None,
    resume: bool,
    required: tuple[str, ...],
    require_all: bool,
    timings: bool | None,
    pictures: bool | None,
    jobs: int,
    scheduler: str | None,
    draws: int,
    quiet: bool,
) -> None:
    """Check every claim about the core against its judge, and write a report.

    Each claim is on disk, in claims.jsonl of the output folder, as soon as it has ended.
    """
    if ctx.invoked_subcommand:
        pass_on(ctx, level, seed)
        return
    judged = None if subject is None else subject_called(subject)
    if judged is not None and (timings or pictures):
        raise click.UsageError("--timings and --pictures are of the core; --subject goes without them")
    checks = chosen(patterns, subject)
    if list_only:
        for check in checks:
            click.echo(f"{check.id:44} {check.claim}")
        return
    required = (*required, *(judged.packages if judged else ()))  # who is judged must be there
    refuse_missing_engines(checks, required, require_all)
    out = out or (Path(f"{OUT}-{subject}") if subject else OUT_OF_SOME if patterns else OUT)
    try_folder(out)

    from validation.journal import CannotRunHereError, Journal, identity
    from validation.run import Plan, run_all
    from validation.terminal import Terminal

    timings = not (patterns or subject) if timings is None else timings
    pictures = timings if pictures is None else pictures
    plan = Plan(checks, level, seed, jobs, out, timings, pictures, list(patterns), judged, draws=draws)
    terminal = Terminal(quiet)
    with judging_on(scheduler, plan, terminal) as plan:
        try:
            journal = Journal(out, identity(level, seed, subject), resume, terminal.say)
        except CannotRunHereError as error:
            raise click.UsageError(str(error)) from error
        with journal:
            try:
                report, cut_short = run_all(plan, journal, terminal)
                write_outputs(report, out, terminal)
            except OSError as error:
                kept = f"; {len(journal.records)} claims are kept in {journal.path}: make room, and go on with --resume"
                raise CannotWrite(f"{error}{kept if journal.records else ''}") from error
            terminal.summarize(report, out)
            if cut_short:
                terminal.say("To go on: the same command with --resume.")
                sys.exit(INTERRUPTED if isinstance(cut_short, KeyboardInterrupt) else NO_CLUSTER)
            journal.remove()
    sys.exit(exit_code(report, required, require_all))


@contextmanager
def judging_on(scheduler: str | None, plan: Plan, terminal: Terminal) -> Iterator[Plan]:
    """Have the plan carried out by a cluster, if a scheduler is named; raises NoCluster."""
    if scheduler is None:
        yield plan
        return
    from validation.cluster import CannotJudgeThereError, Cluster

    try:
        subject = plan.subject.name if plan.subject else None
        cluster = Cluster(scheduler, plan.level, plan.seed, subject, terminal.say)
    except CannotJudgeThereError as error:
        raise NoCluster(str(error)) from error
    with closing(cluster):
        yield replace(plan, cluster=cluster)


def pass_on(ctx: click.Context, level: str, seed: int) -> None:
    """Give level and seed to the command that follows; wrong usage if other options stand before it."""
    for parameter in ctx.params:
        source = ctx.get_parameter_source(parameter)
        if parameter not in ("level", "seed") and source not in (ParameterSource.DEFAULT, None):
            raise click.UsageError(f"{ctx.invoked_subcommand} takes no option {parameter!r}; only --level and --seed")
    ctx.default_map = {"replay": {"level": level, "seed": seed}}


@main.command(
    epilog="Exit code: 0 the case is within the tolerance, 1 it is not, 2 wrong usage, 3 the engine is broken."
)
@click.argument("claim")
@click.option("--case", "number", type=click.IntRange(min=0), metavar="N", help="From 0.  [default: the worst]")
@level_option
@seed_option
def replay(claim: str, number: int | None, level: str, seed: int) -> None:
    """Run CLAIM again and show one case: its inputs, both answers, its error and the tolerance."""
    from validation.check import Run
    from validation.record import BROKEN, HOLDS, NOT_RUN
    from validation.replay import replay_case

    check = the_claim(claim)
    try:
        verdict = replay_case(check, Run(level, seed, check.id), number)
    except IndexError as error:
        raise click.UsageError(str(error)) from error
    sys.exit(ALL_HOLD if verdict == HOLDS else ENGINE_MISSING if verdict in (BROKEN, NOT_RUN) else A_CLAIM_FAILS)


@main.command()
@click.argument("claim")
def explain(claim: str) -> None:
    """Say what CLAIM compares, who judges it, why its tolerance is what it is, and which faults it sees."""
    from validation.explain import explanation
    from validation.terminal import wide_enough

    wide_enough().print(explanation(the_claim(claim)))


def the_claim(name: str) -> Check:
    """Return the check of an id; wrong usage, with the nearest ones, if there is none."""
    from validation.check import all_checks
    from validation.subject import MARK, checks_of

    subject, mark, _ = name.partition(MARK)
    if mark:
        subject_called(subject)
    checks = checks_of(subject) if mark else all_checks()
    if name not in checks:
        near = [*dict.fromkeys([*(one for one in checks if name in one), *get_close_matches(name, checks)])][:5]
        cure = f"did you mean {', '.join(near)}?" if near else "`python -m validation --list` shows them all"
        raise click.UsageError(f"no claim is called {name!r}; {cure}")
    return checks[name]


def subject_called(name: str) -> Declared:
    """Return who is to be judged; wrong usage, with the nearest name and all of them, if there is no such subject."""
    from validation.subject import UnknownSubjectError, the_subject

    try:
        return the_subject(name)
    except UnknownSubjectError as error:
        raise click.UsageError(str(error)) from None


def chosen(patterns: tuple[str, ...], subject: str | None = None) -> list[Check]:
    """Return the checks that match any of the patterns, or all if there are none; wrong usage if one finds nothing."""
    from validation.check import all_checks
    from validation.subject import checks_of

    checks = list((checks_of(subject) if subject else all_checks()).values())
    for pattern in patterns:
        if not any(matches(check, pattern) for check in checks):
            raise click.UsageError(f"no claim matches {pattern!r}; --list shows them all")
    return [check for check in checks if not patterns or any(matches(check, pattern) for pattern in patterns)]


def matches(check: Check, pattern: str) -> bool:
    """Tell whether a pattern is part of, or matches, the check's id or family."""
    wanted = pattern.lower()
    return any(wanted in name or fnmatch.fnmatch(name, wanted) for name in (check.id.lower(), check.family.lower()))


def refuse_missing_engines(checks: list[Check], required: tuple[str, ...], require_all: bool) -> None:
    """End with ENGINE_MISSING, before anything runs, if a demanded engine is not there."""
    from validation.engines import PACKAGES, missing

    unknown = [engine for engine in required if engine not in PACKAGES]
    if unknown:
        raise click.UsageError(f"unknown engine {unknown[0]!r}; choose from {', '.join(PACKAGES)}")
    demanded = set(required)
    if require_all:
        demanded |= {engine for check in checks for engine in check.engines}
    absent = missing(tuple(sorted(demanded)))
    if absent:
        names = ", ".join(f"{engine} (install {PACKAGES[engine]})" for engine in absent)
        click.echo(f"Required but missing: {names}.", err=True)
        sys.exit(ENGINE_MISSING)


def try_folder(folder: Path) -> None:
    """Raise CannotWrite, before anything runs, if files cannot be written to a folder."""
    trial = folder / f".trial.{os.getpid()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        trial.write_bytes(b"x" * 4096)
        trial.unlink()
    except OSError as error:
        raise CannotWrite(
            f"cannot write to {folder}: {error.strerror}; make room there, or choose another folder with --out"
        ) from error
    for name in ("index.html", "badge.svg", "report.json", "junit.xml", "claims.jsonl"):
        if (folder / name).is_dir():
            raise CannotWrite(f"{folder / name} is a folder; choose another one with --out")


def write_outputs(report: Report, out: Path, terminal: Any) -> None:
    """Write report.json and junit.xml, then have the page made from the record; raises OSError."""
    import signal
    import subprocess

    from validation.junit import write_junit
    from validation.record import write_report

    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # a second Ctrl-C costs the page, not the verdicts
    write_report(report, out / "report.json")
    write_junit(report, out / "junit.xml")
    signal.signal(signal.SIGINT, before)
    try:
        made = subprocess.run([sys.executable, "-m", "reports", str(out)], capture_output=True, text=True)
    except KeyboardInterrupt:
        terminal.say(f"Interrupted while the page was made; `python -m reports {out}` makes it.")
        return
    if made.returncode == CANNOT_WRITE:
        raise OSError(made.stderr.strip())
    if made.returncode:
        terminal.say(f"The page could not be made:\n{made.stderr.strip()}")


def exit_code(report: Report, required: tuple[str, ...] = (), require_all: bool = False) -> int:
    """Return ALL_HOLD, A_CLAIM_FAILS, or ENGINE_MISSING if a demanded engine is broken. "Not run" is no failure."""
    if any(record.verdict == "fails" for record in report.claims):
        return A_CLAIM_FAILS
    broken = [set(record.engines) for record in report.claims if record.verdict == "engine broken"]
    return ENGINE_MISSING if any(require_all or engines & set(required) for engines in broken) else ALL_HOLD
