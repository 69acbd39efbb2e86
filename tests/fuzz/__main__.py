"""Does anything break the core? `make fuzz MINUTES=n` tries for n minutes, as Murphy would.

A campaign is a module of this package, found by listing it: the first line of its docstring is the promise, and
`attempt(seed)` tries to break it, once or as often as its TRIES say, and returns None, or what broke in a sentence;
its GOAL is the number of tries after which the promise is believed. Attempts are made in processes of their own: a
crash, an exception of any kind that leaves the attempt, and one that does not end count as broken. One that takes too
long is made again, with ten times the time, for it may have compiled. Modules whose names begin with an underscore are
no campaigns. The same seed tries the same thing:

    python -m tests.fuzz --campaign files --seed 123
"""

from __future__ import annotations

import json
import os
import sys
import time
from math import inf
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from tests.fuzz._process import Outcome
from tests.fuzz._rounds import Campaign, campaigns_in, play
from validation.record import write_whole

PACKAGE = "tests.fuzz"


@click.command()
@click.option("--minutes", type=click.FloatRange(min=0.0), help="How long new attempts are begun.")
@click.option("--attempts", type=click.IntRange(min=1), help="How many of each campaign are made.")
@click.option("--campaign", "names", multiple=True, metavar="NAME", help="Only this one; may be given again.")
@click.option("--seed", type=click.IntRange(min=0), help="The first one (0); alone, or with campaigns: the only one.")
@click.option("--jobs", type=click.IntRange(min=1), default=os.cpu_count(), show_default=True, help="Processes.")
@click.option("--limit", type=float, default=120.0, show_default=True, help="Seconds that an attempt may take.")
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), help="A JSON file for totals and examples.")
@click.option("--package", default=PACKAGE, hidden=True)
def main(
    minutes: float | None,
    attempts: int | None,
    names: tuple[str, ...],
    seed: int | None,
    jobs: int,
    limit: float,
    out: Path | None,
    package: str,
) -> None:
    """Try to break the core; exit with 1 if anything breaks. Ctrl-C keeps what is done."""
    if minutes is None and attempts is None:
        minutes, attempts = (None, 1) if seed is not None else (1.0, None)
    every = campaigns_in(package, seed or 0)
    known = {campaign.name: campaign for campaign in every}
    for name in names:
        if name not in known:
            raise click.UsageError(f"there is no campaign {name!r}; choose from {', '.join(known)}")
    campaigns = [known[name] for name in dict.fromkeys(names)] or every
    if out and not (out.parent.is_dir() and os.access(out.parent, os.W_OK)):
        raise click.UsageError(f"{out.parent} is no folder that can be written to; give another --out")

    begun, seconds = time.monotonic(), inf if minutes is None else 60.0 * minutes
    total = seconds if attempts is None else float(attempts * len(campaigns))
    columns = (BarColumn(), TextColumn("{task.description}"), TimeElapsedColumn(), TextColumn("left:"))
    interrupted = False
    with Progress(*columns, TimeRemainingColumn(), console=Console(stderr=True)) as bar:
        task = bar.add_task("", total=total)

        def each(campaign: Campaign, outcome: Outcome | None) -> None:
            done = sum(one.attempts for one in campaigns)
            counts = ", ".join(f"{one.name} {one.attempts}" for one in campaigns)
            spent = min(time.monotonic() - begun, seconds) if attempts is None else done
            bar.update(task, completed=spent, description=f"{counts}; {sum(one.bad for one in campaigns)} bad")
            if outcome and outcome.broken is not None:
                bar.console.print(f"{again(outcome)}: {outcome.broken}", style="red", markup=False, highlight=False)

        try:
            play(campaigns, inf if attempts is None else attempts, seconds, jobs, limit, each)
        except KeyboardInterrupt:
            interrupted = True
    for campaign in campaigns:
        mark = "✗" if campaign.bad else "✓" if campaign.attempts else "–"
        goal = f" (goal {campaign.goal})" if campaign.goal else ""
        click.echo(f"{mark} {campaign.name}: {campaign.bad} bad of {campaign.tries}{goal}. {campaign.promise}")
    if interrupted:
        click.echo("interrupted: what had ended by then is counted")
    if out:
        write_whole(out, json.dumps(totals(campaigns, seed or 0, time.monotonic() - begun), indent=1))
    sys.exit(1 if any(campaign.bad for campaign in campaigns) else 0)


def totals(campaigns: list[Campaign], seed: int, seconds: float) -> dict[str, Any]:
    """Return what is written as JSON."""
    return {
        "first_seed": seed,
        "seconds": round(seconds, 1),
        "campaigns": {
            one.name: {
                "promise": one.promise,
                "goal": one.goal,
                "tries": one.tries,
                "attempts": one.attempts,
                "bad": one.bad,
                "slow": one.slow,
                "examples": [
                    {"seed": bad.attempt.seed, "broken": bad.broken, "again": again(bad)} for bad in one.examples
                ],
            }
            for one in campaigns
        },
    }


def again(outcome: Outcome) -> str:
    """Return the command that makes an attempt again."""
    package, _, name = outcome.attempt.campaign.rpartition(".")
    other = "" if package == PACKAGE else f" --package {package}"
    return f"python -m tests.fuzz{other} --campaign {name} --seed {outcome.attempt.seed}"


if __name__ == "__main__":
    main()
