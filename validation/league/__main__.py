"""`python -m validation.league`: every engine at every task, and the page of it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import click

from validation.cli import CANNOT_WRITE, INTERRUPTED, level_option, seed_option

OUT = Path("build/league")


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@level_option
@seed_option
@click.option("-k", "patterns", multiple=True, metavar="PATTERN", help="Only tasks whose id contains PATTERN.")
@click.option("--engine", "chosen", multiple=True, metavar="ENGINE", help="Only ENGINE; may be said more than once.")
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), default=OUT, show_default=True)
@click.option("--resume", is_flag=True, help="Go on with the run that was cut short in the output folder.")
@click.option(
    "--jobs", type=click.IntRange(min=1), default=min(os.cpu_count() or 1, 4), show_default=True, help="Cells at once."
)
@click.option(
    "--limit",
    type=click.FloatRange(min=0.0, min_open=True),
    metavar="SECONDS",
    help="That a cell may take.  [default: 300 at quick, 300 at standard, 1800 at full]",
)
@click.option("--quiet", is_flag=True, help="Say only what cannot be done.")
def main(
    level: str,
    seed: int,
    patterns: tuple[str, ...],
    chosen: tuple[str, ...],
    out: Path,
    resume: bool,
    jobs: int,
    limit: float | None,
    quiet: bool,
) -> None:
    """Put every engine beside every other: how right it is, and what that costs.

    Exit code: 0 the page is made, 2 wrong usage, 4 the output cannot be written, 130 interrupted (--resume goes on).
    `python -m reports league FOLDER --beside FILE` puts the engines of another league.json beside those here.
    """
    from validation.league.record import NAME, write
    from validation.league.run import HOST, OtherRunError, Plan, played
    from validation.subject import CLAIMS, UnknownSubjectError, checks_of, subjects, the_subject
    from validation.terminal import Terminal

    terminal = Terminal(quiet)
    try:
        checks_of(HOST)
        tasks = [name for name in CLAIMS if not patterns or any(one in name for one in patterns)]
        if not tasks:
            raise click.UsageError(f"no task's id contains {' or '.join(patterns)}; tasks are {', '.join(CLAIMS)}")
        engines = sorted(the_subject(name).name for name in chosen or subjects())
        league = played(Plan(level, seed, jobs, out, tasks, engines, resume, limit), terminal)
        write(league, out / NAME)
        made = subprocess.run([sys.executable, "-m", "reports", "league", str(out)], capture_output=True, text=True)
        if made.returncode:
            raise OSError(f"the page could not be made: {made.stderr.strip()[-600:]}")
    except (UnknownSubjectError, OtherRunError) as error:
        raise click.UsageError(str(error)) from None
    except OSError as error:
        click.echo(f"Error: {error}", err=True)
        sys.exit(CANNOT_WRITE)
    except KeyboardInterrupt:
        click.echo("Interrupted.", err=True)
        sys.exit(INTERRUPTED)
    if league.left:
        click.echo(f"Interrupted; {out / 'index.html'} has what is done, and --resume goes on.", err=True)
        sys.exit(INTERRUPTED)
    click.echo(f"{len(league.engines)} engines at {len(league.tasks)} tasks: {out / 'index.html'}")


if __name__ == "__main__":
    main()
