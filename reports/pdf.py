"""PDF of a page, printed by a browser without a screen, all that folds open."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import click

from reports.reading import CannotRead, CannotWrite

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")
OPTIONS = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-pdf-header-footer")
LONGEST = 120.0  # [s]
NO_BROWSER = 3


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--to", "target", type=click.Path(dir_okay=False, path_type=Path), help="[default: FOLDER/report.pdf]")
def main(folder: Path, target: Path | None) -> None:
    """Print FOLDER/index.html to a PDF, by Chromium or Chrome.

    Exit code: 0 it is written, 2 there is no page, 3 not run: no browser, 4 it cannot be printed or written.
    """
    page = folder / "index.html"
    if not page.is_file():
        raise CannotRead(f"{page} does not exist; `python -m reports {folder}` makes it")
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        click.echo("not run: no browser; install Chromium or Chrome, or print index.html from any other", err=True)
        sys.exit(NO_BROWSER)
    target = target or folder / "report.pdf"
    print_page(browser, page, target)
    click.echo(target)


def print_page(browser: str, page: Path, target: Path) -> None:
    """Print a page to a PDF, whole or not at all; raises CannotWrite."""
    part = target.with_name(f".{target.stem}.{os.getpid()}.pdf")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
            printed = Path(profile) / "page.pdf"
            command = [browser, *OPTIONS, f"--user-data-dir={profile}", f"--print-to-pdf={printed}"]
            done = subprocess.run(
                [*command, page.resolve().as_uri()], capture_output=True, text=True, timeout=LONGEST, errors="replace"
            )
            data = printed.read_bytes() if printed.is_file() else b""
        if not data.startswith(b"%PDF") or b"%%EOF" not in data[-32:]:
            said = (done.stderr.strip().splitlines() or ["it said nothing"])[-1]
            raise CannotWrite(f"{browser} printed no PDF ({said}); print {page} from another browser")
        with part.open("wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        part.replace(target)
    except subprocess.TimeoutExpired:
        raise CannotWrite(f"{browser} was not done after {LONGEST:g} s; print {page} from another browser") from None
    except OSError as error:
        raise CannotWrite(f"{target} cannot be written: {error.strerror}; make room, or choose another --to") from error
    finally:
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)
