"""Command line of the pages: `python -m reports FOLDER`, `… pdf`, `… diff`, `… league`, `… readme`."""

from __future__ import annotations

from pathlib import Path

import click

from reports import compare, pdf, readme
from reports.reading import read, write


class PageUnlessNamed(click.Group):
    """A first argument that is no command is the folder of a page."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command that the arguments ask for."""
        if args and args[0] not in self.commands:
            args = ["page", *args]
        return super().resolve_command(ctx, args)


@click.group(
    cls=PageUnlessNamed,
    context_settings={"help_option_names": ["-h", "--help"]},
    subcommand_metavar="FOLDER | diff BEFORE NOW | league FOLDER | pdf FOLDER | readme",
)
def main() -> None:
    """Make FOLDER/index.html from FOLDER/report.json, tell two reports apart, print a page, or fill in the README."""


@main.command(name="page")
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
def make_page(folder: Path) -> None:
    """Make FOLDER/index.html, one self-contained page, and badge.svg, from FOLDER/report.json; `page` need not be said.

    Exit code: 0 the page is written, 2 there is no record that could be read, 4 the page cannot be written.
    """
    from validation.record import read_report

    report = read(folder / "report.json", read_report, f"run `python -m validation --out {folder}`")

    from reports.badge import badge
    from reports.page import page

    target = folder / "index.html"
    text = page(report, folder)  # before anything is written: it may refuse a picture
    write(folder / "badge.svg", badge(report))
    write(target, text)
    click.echo(target)


@main.command(name="league")
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option(
    "--beside",
    "others",
    multiple=True,
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Show the engines of another league.json, too; it is named by its folder. May be said more than once.",
)
def make_league(folder: Path, others: tuple[Path, ...]) -> None:
    """Make FOLDER/index.html from FOLDER/league.json.

    Exit code: 0 the page is written, 2 a record cannot be read, or is of other tasks, 4 the page cannot be written.
    """
    from reports.league import page
    from validation.league.record import NAME, merged, read_league

    league = read(folder / NAME, read_league, f"run `python -m validation.league --out {folder}`")
    for path in others:
        try:
            league = merged(league, read(path, read_league, "name a league.json"), path.resolve().parent.name)
        except ValueError as error:
            raise click.UsageError(str(error)) from None
    target = folder / "index.html"
    write(target, page(league))
    click.echo(target)


main.add_command(compare.main, "diff")
main.add_command(pdf.main, "pdf")
main.add_command(readme.main, "readme")

if __name__ == "__main__":
    main(prog_name="python -m reports")
