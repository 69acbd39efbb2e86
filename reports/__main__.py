"""How is a page made from the shell? `python -m reports FOLDER` reads report.json there and writes index.html."""

from __future__ import annotations

from pathlib import Path

import click


class CannotRead(click.ClickException):
    """A record that is missing, damaged or of another schema; the command ends with 2."""

    exit_code = 2


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
def main(folder: Path) -> None:
    """Make FOLDER/index.html, one self-contained page, from FOLDER/report.json.

    Exit code: 0 the page is written, 2 there is no record that could be read.
    """
    from validation.record import read_report, write_whole

    source = folder / "report.json"
    if not source.is_file():
        raise CannotRead(f"{source} does not exist; run `python -m validation --out {folder}` first")
    try:
        report = read_report(source)
    except (KeyError, TypeError) as error:
        raise CannotRead(f"{source} is damaged ({type(error).__name__}: {error}); run the validation again") from error
    except (ValueError, OSError) as error:
        raise CannotRead(str(error)) from error

    from reports.page import page

    target = folder / "index.html"
    write_whole(target, page(report, folder))
    click.echo(target)


if __name__ == "__main__":
    main(prog_name="python -m reports")
