"""Share of the core's small faults that the claims see: `python -m validation.mutants`, or `make mutants`.

Mutants are drawn evenly over all sites of the core, and all of them sleep in one copy of it, which is compiled once.
Each is judged by the claims that come by, first at level quick, then at level standard, until one turns red. A claim is
used only if it holds on the same copy while all mutants are asleep.
"""

from __future__ import annotations

import os
import sys
from fnmatch import fnmatch
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from rich.console import Console

    from validation.mutation.results import Fate
    from validation.mutation.sites import Mutant

SEED = 20080101  # of the sample, and of the claims' cases


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--mutants", "count", type=click.IntRange(min=1), default=60, show_default=True, help="How many to try.")
@click.option("--seed", type=click.IntRange(min=0), default=SEED, show_default=True, help="Of sample and claims.")
@click.option(
    "--files", multiple=True, metavar="PATTERN", help="Only of files of softbody/ that contain or match PATTERN."
)
@click.option("--only", multiple=True, metavar="TEXT", help="Only mutants whose `key` in OUT contains TEXT.")
@click.option("--changed-since", metavar="REVISION", help="Only of functions that have changed since then.")
@click.option(
    "-k", "claims", multiple=True, metavar="PATTERN", help="Only claims whose id contains or matches PATTERN."
)
@click.option("--level", type=click.Choice(["quick", "standard"]), default="standard", show_default=True)
@click.option(
    "--form",
    type=click.Choice(["compiled", "interpreted", "both"]),
    default="compiled",
    show_default=True,
    help="Interpreted, only claims are used that are quick so; nothing waits for the compiler.",
)
@click.option("--batch", type=click.IntRange(1, 20_000), default=1000, show_default=True, help="Mutants in one core.")
@click.option("--jobs", type=click.IntRange(min=1), default=min(os.cpu_count() or 1, 4), show_default=True)
@click.option(
    "--least", type=click.FloatRange(0.0, 1.0), default=1.0, show_default=True, help="Share to be seen for exit code 0."
)
@click.option("--resume", is_flag=True, help="Go on from the last run of this seed, also with another core.")
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), default=Path("build/mutants.json"))
def main(
    count: int,
    seed: int,
    files: tuple[str, ...],
    only: tuple[str, ...],
    changed_since: str | None,
    claims: tuple[str, ...],
    level: str,
    form: str,
    batch: int,
    jobs: int,
    least: float,
    resume: bool,
    out: Path,
) -> None:
    """Mutate the core, and see which claims turn red by what they measure.

    Each mutant's fate is kept beside OUT, in JSON lines, as soon as it is known: --resume goes on, also with more
    mutants, and tries those anew whose functions have changed since, and those that survived on claims that have.
    Exit code: 0 every mutant is seen or explained, or of those that are not explained as many as --least says, 1 more
    survive, 2 wrong usage, 130 interrupted.
    """
    from rich.console import Console

    from softbody.compiler.core_digest import core_digest
    from validation.check import all_checks
    from validation.mutation.explained import EXPLAINED
    from validation.mutation.results import Ledger, counted, share_seen, survivors_of, write_summary
    from validation.mutation.trials import Trials

    chosen = sample(count, seed, files, only, changed_since)
    used = [each for each in all_checks().values() if matches(each.id, claims)]
    if not used:
        raise click.UsageError(f"no claim matches {' or '.join(claims)}; python -m validation --list shows them all")
    heading = {"core": core_digest(), "seed": seed}
    try:
        ledger = Ledger(out.with_suffix(".jsonl"), core_digest(), seed, resume)
    except ValueError as error:
        raise click.UsageError(str(error)) from error
    console = Console(stderr=True)
    trials = Trials(used, seed, jobs, ledger, console)
    interrupted = False
    try:
        trials.run(chosen, level, ["interpreted", "compiled"] if form == "both" else [form], batch)
    except KeyboardInterrupt:
        interrupted = True
    fates = [ledger.fate_of(mutant) for mutant in chosen]
    write_summary(fates, EXPLAINED, heading | {"level": level}, out)
    for fate in survivors_of(fates, EXPLAINED):
        tell(fate, console)
    totals = counted(fates, EXPLAINED)
    click.echo(f"{len(fates)} mutants: " + ", ".join(f"{n} {name}" for name, n in totals.items() if n) + f"; {out}")
    sys.exit(130 if interrupted else 0 if share_seen(totals) >= least else 1)


def matches(name: str, patterns: tuple[str, ...]) -> bool:
    """Tell whether a name contains, or matches, one of some patterns; all do if there are none."""
    return not patterns or any(pattern in name or fnmatch(name, pattern) for pattern in patterns)


def sample(
    count: int, seed: int, files: tuple[str, ...], only: tuple[str, ...], changed_since: str | None
) -> list[Mutant]:
    """Return the mutants to try; wrong usage if there is no file, or no change, of which they could be."""
    from validation.mutation.core import all_mutants
    from validation.mutation.sample import changed_functions, in_fair_order

    some = [each for each in in_fair_order(all_mutants(), seed) if matches(each.file, files)]
    if not some:
        raise click.UsageError(f"no file of the core that is mutated matches {' or '.join(files)}")
    some = [each for each in some if not only or any(text in each.key for text in only)]
    if not some:
        raise click.UsageError(f"no mutant there has {' or '.join(only)} in its key; mutants.json shows keys")
    if changed_since is not None:
        try:
            changed = changed_functions(changed_since)
        except ValueError as error:
            raise click.UsageError(str(error)) from error
        some = [each for each in some if (each.file, each.function) in changed]
    return some[:count]


def tell(fate: Fate, console: Console) -> None:
    """Print a mutant that survived: where it is, what it says, who looked at it."""
    one = fate.mutant
    tried = ", ".join(fate.claims()) or "no claim comes there"
    place = f"softbody/{one.file}:{one.line} {one.function} ({one.operator})"
    lines = place, f"  - {one.before}", f"  + {one.after}", f"    {tried}"
    console.print("\n".join(lines), highlight=False, markup=False, soft_wrap=True)


if __name__ == "__main__":
    main()
