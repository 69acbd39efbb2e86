"""Every claim can fail: damage the core under it, and it turns red. `python -m validation.faults` shows all of it.

What has changed, and some of the rest, is enough between two releases: `--changed-since REVISION --draw N`.
"""

from __future__ import annotations

import os
import random
import sys
import tempfile
import time
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from validation.bench import Seen
    from validation.fault_draw import Faults
    from validation.fault_trials import Outcome


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("-k", "pattern", default="", metavar="TEXT", help="Only faults that name TEXT, or claims with it.")
@click.option("--changed-since", "since", metavar="REVISION", help="Only faults where the core, or they, have changed.")
@click.option("--most", type=click.IntRange(min=1), metavar="N", help="Of more that have changed, only N, drawn.")
@click.option("--draw", "count", type=click.IntRange(min=0), metavar="N", help="Only N of the others, drawn by --seed.")
@click.option("--seed", type=click.IntRange(min=0), help="Of the draw; the commit's if there is none.")
@click.option("--minutes", type=click.FloatRange(min=0.0), metavar="N", help="Begin no fault later than that.")
@click.option("--jobs", type=click.IntRange(min=1), default=min(os.cpu_count() or 1, 4), show_default=True)
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), default=Path("build/faults.json"))
def main(
    pattern: str,
    since: str | None,
    most: int | None,
    count: int | None,
    seed: int | None,
    minutes: float | None,
    jobs: int,
    out: Path,
) -> None:
    """Plant every fault in a copy of the core, and see that the claims that name it turn red.

    With --changed-since and --draw only those are planted. What has only moved to another file has not changed. A
    draw is of one kind of world and few files of claims without worlds, for which it compiles; each commit draws
    others, and over some tens of them all have their turn; their order is drawn, too.

    Exit code: 0 all that were tried are caught, or there is none to try, 1 one escapes, or the minutes were over before
    the first, 2 wrong usage, 130 interrupted; what was done by then is written.
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
        TOO_LATE,
        Judges,
        claims_by_group,
        line_of,
        side_by_side,
        try_in_time,
        write,
    )

    faults, told = chosen(pattern, since, most, count, seed)
    click.echo(told)
    if not faults:
        write([], 0, out)
        return
    outcomes: list[Outcome] = []
    end = inf if minutes is None else time.monotonic() + 60.0 * minutes
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
            groups = claims_by_group(faults)
            task = bar.add_task("the claims without faults", total=sum(map(len, groups)))
            sound: dict[str, Seen] = {}

            def judge(claim: str) -> None:
                if time.monotonic() < end:
                    sound[claim] = judges.asleep(claim)
                bar.advance(task)

            list(side_by_side(judge, [[(claim,) for claim in group] for group in groups], jobs))
            bar.reset(task, description="faults", total=len(faults))
            tasks = [[(fault, claims, judges, sound, end)] for fault, claims in faults.items()]
            for outcome in side_by_side(try_in_time, tasks, jobs):
                if outcome.why != TOO_LATE:
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
    sys.exit(130 if interrupted else 1 if escaped or not outcomes else 0)


def chosen(
    pattern: str, since: str | None, most: int | None, count: int | None, seed: int | None
) -> tuple[Faults, str]:
    """Return the faults to try, with the claims that are to see them, and a sentence that says which these are."""
    from validation.changed_faults import changed_faults
    from validation.check import all_checks
    from validation.fault_draw import draw
    from validation.fault_trials import planted_faults
    from validation.mutation.revision import number_of_head

    checks = all_checks()
    faults = {
        fault: claims
        for fault, claims in planted_faults().items()
        if any(pattern in text for text in (fault.name, *claims))
    }
    if not faults:
        raise click.UsageError(f"no fault and no claim has {pattern!r} in its name")
    if since is None and count is None:
        return faults, f"{len(faults)} faults" + (f" that name {pattern!r}" if pattern else "")
    try:
        news = set() if since is None else changed_faults(checks, since)
        seed = number_of_head() if seed is None and (count or most) else seed or 0
    except ValueError as error:
        raise click.UsageError(str(error)) from error
    some = {fault: claims for fault, claims in faults.items() if fault in news}
    said = [] if since is None else [f"{len(some)} faults that are new or changed since {since}"]
    if most is not None and len(some) > most:
        few = draw(some, checks, most, seed)
        said[0] = f"{few.pairs} of {few.of} that are new or changed since {since}: {'; '.join(few.groups)}"
        some = few.faults
    if count is not None:
        drawn = draw({fault: claims for fault, claims in faults.items() if fault not in news}, checks, count, seed)
        some |= drawn.faults
        said += [f"{drawn.pairs} drawn of {drawn.of} others by seed {seed}: {'; '.join(drawn.groups) or 'none'}"]
    order = list(some.items())
    random.Random(seed).shuffle(order)  # those for which no minutes are left are others the next time
    return dict(order), ", ".join(said)


if __name__ == "__main__":
    main()
