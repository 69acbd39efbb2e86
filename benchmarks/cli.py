"""The command line of the benchmarks: measure, compare, calibrate, look back."""

from __future__ import annotations

import json
import re
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from benchmarks.progress import show, show_progress

if TYPE_CHECKING:
    from benchmarks.calibration import Calibration
    from benchmarks.compare import Plan, Result
    from benchmarks.history import History
    from benchmarks.trends import Trend

ALL_WELL, SLOWER_OR_WRONG, WRONG_USAGE, INTERRUPTED = 0, 1, 2, 130
ROOT = Path(__file__).parent.parent
STORE = Path("build/benchmarks")  # of the history, and of revisions with their machine code


class Duration(click.ParamType):
    """A number with a unit: 90s, 5m, 1h."""

    name = "duration"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return seconds."""
        found = re.fullmatch(r"(\d+(?:\.\d+)?)(s|m|h)", str(value))
        if not found:
            self.fail(f"{value!r} is no duration; write 90s, 5m or 1h", param, ctx)
        return float(found[1]) * {"s": 1.0, "m": 60.0, "h": 3600.0}[found[2]]


class Percent(click.ParamType):
    """A share: 3% or 0.03."""

    name = "percent"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return it as a number."""
        found = re.fullmatch(r"(\d+(?:\.\d+)?)(%?)", str(value))
        if not found:
            self.fail(f"{value!r} is no share; write 3% or 0.03", param, ctx)
        return float(found[1]) * (0.01 if found[2] else 1.0)


LEVEL = click.option("--level", type=click.Choice(["quick", "standard", "full"]), default="quick", show_default=True)
HISTORY = click.option(
    "--history",
    "history_path",
    type=click.Path(dir_okay=False, path_type=Path),
    default=STORE / "history.sqlite",
    show_default=True,
)
MACHINE = click.option("--machine", default=None, help="Another one, by its checksum. Default: this one.")


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
def main() -> None:
    """Measure what the pieces cost, and tell whether a change made them slower.

    Exit code: 0 all well, 1 something is slower than allowed, or wrong, 2 wrong usage.
    """


@main.command()
@LEVEL
@HISTORY
@click.option("-k", "pattern", default="", metavar="PATTERN", help="Only benchmarks whose name contains it.")
@click.option(
    "--json", "json_path", type=click.Path(dir_okay=False, path_type=Path), help="pytest-benchmark's file, too."
)
@click.option("--no-history", is_flag=True, help="Store nothing.")
@click.option("--page", is_flag=True, help="Only what the report's page has at the level.")
@click.argument("files", nargs=-1)
def run(
    level: str,
    history_path: Path,
    pattern: str,
    json_path: Path | None,
    no_history: bool,
    page: bool,
    files: tuple[str, ...],
) -> None:
    """Run the suite, or some FILES of it, show tables across sizes and what goals come to, and store every round."""
    from benchmarks import suite
    from benchmarks.exchange import write_whole
    from benchmarks.goals import NOT_MEASURED, outcomes
    from benchmarks.history import History, run_record
    from benchmarks.running import run_suite
    from benchmarks.tables import goals_table, timing_tables

    document, interrupted = run_suite(level, pattern, files, page)
    found = list(outcomes(document, suite.goals()))
    document["goals"] = [asdict(outcome) for outcome in found]
    show(*timing_tables(document), goals_table(one for one in found if one.verdict != NOT_MEASURED))
    if json_path:
        write_whole(json_path, json.dumps(document))
    if not no_history:
        History(history_path).add([run_record(document)])
        click.echo(f"stored in {history_path}")
    if interrupted:
        click.echo("interrupted: what was measured is kept", err=True)
        sys.exit(INTERRUPTED)


@main.command()
@click.argument("a")
@click.argument("b")
@LEVEL
@HISTORY
@click.option("-k", "patterns", multiple=True, metavar="PATTERN", help="Whose name contains it. Default: the usual.")
@click.option("--budget", type=Duration(), default="5m", show_default=True, help="For measuring, after compiling.")
@click.option("--fail-slower", type=Percent(), default=None, help="Exit with 1 if one is shown to be slower by more.")
@click.option("--answers-may-differ", is_flag=True, help="Other answers are no failure.")
@click.option("--instructions", is_flag=True, help="Count them, too, by Valgrind: takes minutes more.")
@click.option("--resume", is_flag=True, help="Go on with the last comparison of the same two, and add to it.")
def compare(
    a: str,
    b: str,
    level: str,
    history_path: Path,
    patterns: tuple[str, ...],
    budget: float,
    fail_slower: float | None,
    answers_may_differ: bool,
    instructions: bool,
    resume: bool,
) -> None:
    """Say which benchmarks are faster or slower with core B than with core A.

    A and B are revisions, or "." for the working tree. Both run in turns, with the working tree's benchmarks.
    """
    from benchmarks.history import History
    from benchmarks.resuming import keep, kept

    plan = plan_of((a, b), level, patterns, budget)
    history = History(history_path)
    results = kept(history, plan) if resume else {}
    interrupted = compared(plan, results)
    keep(history, plan, results)
    if instructions and not interrupted:
        count_instructions(plan, results)
    calibration = latest_calibration(history)
    report(plan, results, calibration)
    if calibration and fail_slower is not None:
        click.echo(calibration.gate(fail_slower))
    if interrupted:
        sys.exit(INTERRUPTED)
    sys.exit(exit_code(results, fail_slower, answers_may_differ))


@main.command()
@HISTORY
@MACHINE
def goals(history_path: Path, machine: str | None) -> None:
    """Show how far each goal was met in the last run that is stored.

    A goal is how many times as fast as a peer, or as the clock, ours is to be; what counts is the worst size.
    """
    from benchmarks import suite
    from benchmarks.goals import outcomes
    from benchmarks.history import History
    from benchmarks.machine import machine_here
    from benchmarks.tables import goals_table

    records = History(history_path).records(machine=machine or machine_here())
    if not records:
        raise nothing_stored(History(history_path), machine)
    click.echo(f"run of {records[-1].started}, revision {records[-1].document['commit_info']['id'][:12]}")
    show(goals_table(outcomes(records[-1].document, suite.goals())))


@main.command()
@click.option("-k", "pattern", default="", metavar="PATTERN", help="Only worlds whose name contains it.")
@click.option("--rounds", type=click.IntRange(min=2), default=100, show_default=True, help="Of both sides in turns.")
def guards(pattern: str, rounds: int) -> None:
    """Say what guards, and listening for interrupts, cost steps and runs: in percent, the median, and the quartiles."""
    from benchmarks.guarding import costs

    for cost in costs(rounds, pattern):
        click.echo(str(cost))


@main.command()
@HISTORY
@click.option("--budget", type=Duration(), default="20m", show_default=True, help="For measuring, after compiling.")
def calibrate(history_path: Path, budget: float) -> None:
    """Measure how often verdicts err on this machine, now, and store it: every later verdict says it."""
    from benchmarks import calibration
    from benchmarks.history import History, Record
    from benchmarks.machine import machine_here

    plan = plan_of((".", "."), "quick", (), budget)
    with show_progress() as said:
        found = calibration.calibrate(plan, said)
    click.echo(str(found))
    click.echo(f"it took {found.seconds / 60.0:.0f} minutes")
    History(history_path).add([Record("calibration", found.started, machine_here(), found.document())])


@main.command()
@HISTORY
@MACHINE
@click.option("--plot", type=click.Path(dir_okay=False, path_type=Path), help="Draw it, too: a PNG or SVG file.")
@click.option("--json", "json_path", type=click.Path(dir_okay=False, path_type=Path), help="Write it as JSON, too.")
@click.argument("benchmark", default="")
def history(history_path: Path, machine: str | None, plot: Path | None, json_path: Path | None, benchmark: str) -> None:
    """Show how each BENCHMARK has changed from run to run, and its steps."""
    from benchmarks.exchange import write_whole
    from benchmarks.trends import draw, lines_of

    trends, document = stored_trends(history_path, machine, benchmark)
    for trend in trends:
        for line in lines_of(trend):
            click.echo(line)
    if plot:
        draw(trends, plot)
        click.echo(f"drawn in {plot}")
    if json_path:
        write_whole(json_path, json.dumps(document))


@main.command()
@HISTORY
@MACHINE
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path))
def publish(history_path: Path, machine: str | None, folder: Path) -> None:
    """Write FOLDER/trends.html: how every benchmark has changed from run to run, and how often verdicts err here.

    It needs no network and nothing beside it; trends.json has the same for programs. Other files stay as they are.
    """
    from benchmarks import publish

    _, document = stored_trends(history_path, machine)
    publish.publish(document, folder)
    click.echo(folder / "trends.html")


@main.command()
@HISTORY
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
def export(history_path: Path, file: Path) -> None:
    """Write every run to FILE.jsonl, a line each, or the newest to FILE.json as pytest-benchmark has it."""
    from benchmarks import exchange
    from benchmarks.history import History

    count = exchange.export(History(history_path).records(), file)
    click.echo(f"{count} of them in {file}")


@main.command("import")
@HISTORY
@click.argument("file", type=click.Path(exists=True, dir_okay=False, path_type=Path))
def import_(history_path: Path, file: Path) -> None:
    """Add what `export`, or pytest-benchmark, has written to FILE."""
    from benchmarks import exchange
    from benchmarks.history import History

    click.echo(f"{exchange.import_file(file, History(history_path))} new in {history_path}")


def stored_trends(
    history_path: Path, machine: str | None, benchmark: str = ""
) -> tuple[list[Trend], dict[str, object]]:
    """Return the trends of a machine, and the document of them; ClickException if there are none."""
    from benchmarks.history import History
    from benchmarks.machine import machine_here
    from benchmarks.publish import document_of
    from benchmarks.trends import trends_of

    stored = History(history_path)
    records = stored.records(machine=machine or machine_here())
    trends = [trend for trend in trends_of(records) if benchmark.lower() in trend.name.lower()]
    if not trends:
        raise nothing_stored(stored, machine, benchmark)
    return trends, document_of(records, trends, latest_calibration(stored, machine))


def nothing_stored(stored: History, machine: str | None, benchmark: str = "") -> click.ClickException:
    """Return the error that a history has nothing of a benchmark, on a machine or on this one."""
    others = sorted({record.machine for record in stored.records()})
    return click.ClickException(
        f"nothing is stored of {benchmark or 'any benchmark'} on {machine or 'this machine'} in {stored.path}"
        + "; `python -m benchmarks run` measures something"
        + (f", --machine chooses a machine; machines there: {', '.join(others)}" if others else "")
    )


def plan_of(names: tuple[str, str], level: str, patterns: tuple[str, ...], budget: float) -> Plan:
    """Return what is to be compared; both cores are laid out."""
    from benchmarks import cores
    from benchmarks.compare import Plan
    from benchmarks.sides import checked_out

    store = (STORE / "cores").absolute()
    a, b = (checked_out(name, ROOT, store) for name in names)
    for side in (a, b):
        if side.revision.endswith("+"):
            click.echo(f"{side.name} is {side.revision[:-1]} with changes that are not committed", err=True)
    gone = cores.prune(store)
    if gone:
        click.echo(f"removed {gone} of the cores in {store}: the newest {cores.KEPT} are kept", err=True)
    return Plan((a, b), ROOT, level, patterns, budget)


def compared(plan: Plan, results: dict[str, Result]) -> bool:
    """Compare; return whether it was cut short. What is measured is in the results all the same."""
    from benchmarks import compare
    from benchmarks.worker import WorkerError

    try:
        with show_progress() as said:
            compare.compare(plan, results, said)
    except KeyboardInterrupt:
        click.echo("interrupted: what is measured is kept; --resume goes on", err=True)
        return True
    except WorkerError as error:
        if not any(result.openings for result in results.values()):
            raise click.ClickException(f"the benchmarks do not start: {error}") from error
        click.echo(f"cut short: {error}; what is measured is kept, and --resume goes on", err=True)
        return True
    if not results:
        raise click.UsageError(f"no benchmark at level {plan.level} matches {', '.join(plan.patterns)!r}")
    return False


def count_instructions(plan: Plan, results: dict[str, Result]) -> None:
    """Count what can be counted; say why, where nothing can."""
    from benchmarks.instructions import CannotCountError, count
    from benchmarks.worker import WorkerError

    try:
        with show_progress() as said:
            count(plan, results, said)
    except (CannotCountError, WorkerError, KeyboardInterrupt) as error:  # the verdicts are there all the same
        click.echo(f"instructions are not counted: {str(error) or 'interrupted'}", err=True)


def report(plan: Plan, results: dict[str, Result], calibration: Calibration | None) -> None:
    """Print the verdicts, what could not be compared, whose answers differ, and how far verdicts are to be trusted."""
    from benchmarks.tables import verdict_table

    a, b = (f"{side.name} ({side.revision})" if side.name != side.revision else side.name for side in plan.sides)
    click.echo(f"from {a} to {b}")
    show(verdict_table(results.values(), (plan.sides[0].name, plan.sides[1].name)))
    for result in results.values():
        if result.why:
            click.echo(f"{result.name}: not compared, {result.why}")
        if result.answers_differ is not None:
            click.echo(f"{result.name}: answers differ by {result.answers_differ:.2g} of their size")
    unclear = sum(not result.why and not result.verdict.clear for result in results.values())
    if unclear:
        click.echo(f"{unclear} of {len(results)} not clear yet (*): give more by --budget, or go on by --resume")
    click.echo(
        str(calibration)
        if calibration
        else "not calibrated here: `python -m benchmarks calibrate` says how often verdicts err"
    )


def exit_code(results: dict[str, Result], fail_slower: float | None, answers_may_differ: bool) -> int:
    """Return SLOWER_OR_WRONG if anything is slower than allowed, gives other answers, or could not be compared."""
    for result in results.values():
        if result.why and result.why.startswith("Skipped"):  # it is for a higher level
            continue
        if result.why or (result.answers_differ is not None and not answers_may_differ):
            return SLOWER_OR_WRONG
        if fail_slower is not None and result.verdict.is_slower_than(fail_slower):
            return SLOWER_OR_WRONG
    return ALL_WELL


def latest_calibration(history: History, machine: str | None = None) -> Calibration | None:
    """Return the last calibration of a machine, or of this one, if there is one."""
    from benchmarks.calibration import from_document
    from benchmarks.machine import machine_here

    records = history.records("calibration", machine or machine_here())
    return from_document(records[-1].document) if records else None
