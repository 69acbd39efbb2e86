"""Every claim can fail: damage the core under it, and it turns red. `python -m validation.faults` shows all of it."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from validation.bench import Seen
    from validation.fault_trials import Outcome


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("-k", "pattern", default="", metavar="TEXT", help="Only faults that name TEXT, or claims with it.")
@click.option("--jobs", type=click.IntRange(min=1), default=min(os.cpu_count() or 1, 4), show_default=True)
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), default=Path("build/faults.json"))
def main(pattern: str, jobs: int, out: Path) -> None:
    """Plant every fault in a copy of the core, and see that the claims that name it turn red.

    Exit code: 0 all are caught, 1 one escapes, 2 wrong usage, 130 interrupted; what was done by then is written.
    """
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    from validation.fault_trials import (
        CAUGHT,
        ESCAPED,
        Judges,
        all_at_once,
        in_any_order,
        line_of,
        planted_faults,
        try_fault,
        write,
    )

    faults = {
        fault: claims
        for fault, claims in planted_faults().items()
        if any(pattern in text for text in (fault.name, *claims))
    }
    if not faults:
        raise click.UsageError(f"no fault and no claim has {pattern!r} in its name")
    outcomes: list[Outcome] = []
    console = Console(stderr=True)
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    bar = Progress(*columns, TextColumn("left:"), TimeRemainingColumn(), console=console)
    interrupted = False
    with tempfile.TemporaryDirectory(prefix="faults-") as folder, bar:
        try:
            judges = Judges(faults, Path(folder), jobs)
        except ValueError as error:
            raise click.ClickException(str(error)) from error
        try:
            claims = in_any_order(faults)
            task = bar.add_task("the claims without faults", total=len(claims))
            sound: dict[str, Seen] = {}

            def judge(claim: str) -> None:
                sound[claim] = judges.asleep(claim)
                bar.advance(task)

            list(all_at_once(judge, zip(claims), jobs))
            bar.reset(task, description="faults", total=len(faults))
            tasks = [(fault, claims, judges, sound) for fault, claims in faults.items()]
            for outcome in all_at_once(try_fault, tasks, jobs):
                outcomes.append(outcome)
                console.print(line_of(outcome), highlight=False, markup=False, soft_wrap=True)
                bar.advance(task)
        except KeyboardInterrupt:
            interrupted = True
        finally:
            judges.close()
    caught, escaped = (sum(each.verdict == verdict for each in outcomes) for verdict in (CAUGHT, ESCAPED))
    write(outcomes, caught, out)
    for outcome in outcomes:  # those above may be far above, or cut off
        if outcome.verdict == ESCAPED:
            click.echo(line_of(outcome))
    click.echo(f"{len(outcomes)} of {len(faults)} faults: {caught} caught, {escaped} escaped; {out}")
    sys.exit(130 if interrupted else 1 if escaped else 0)


if __name__ == "__main__":
    main()
