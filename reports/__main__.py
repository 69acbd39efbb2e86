"""How is a page made from the shell? `python -m reports FOLDER` reads report.json there and writes index.html."""

from __future__ import annotations

from pathlib import Path

import click

from reports.reading import read


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
def main(folder: Path) -> None:
    """Make FOLDER/index.html, one self-contained page, from FOLDER/report.json.

    Exit code: 0 the page is written, 2 there is no record that could be read.
    """
    from validation.record import read_report, write_whole

    report = read(folder / "report.json", read_report, f"run `python -m validation --out {folder}`")

    from reports.page import page

    target = folder / "index.html"
    write_whole(target, page(report, folder))
    click.echo(target)


if __name__ == "__main__":
    main(prog_name="python -m reports")
