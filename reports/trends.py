"""How timings have changed: `python -m reports.trends FOLDER` reads trends.json there and writes trends.html.

The document is `reports.trends_document.Trends`.
"""

from __future__ import annotations

from pathlib import Path

import click

from reports.reading import read, write
from reports.trends_document import CURE, read_trends


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
def main(folder: Path) -> None:
    """Make FOLDER/trends.html, one self-contained page, from FOLDER/trends.json.

    Exit code: 0 the page is written, 2 there is no record that could be read, 4 the page cannot be written.
    """
    trends = read(folder / "trends.json", read_trends, CURE)

    from reports.trends_page import page

    target = folder / "trends.html"
    write(target, page(trends))
    click.echo(target)


if __name__ == "__main__":
    main(prog_name="python -m reports.trends")
