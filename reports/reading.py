"""Reading and writing of files, with errors that name the file: exit code 2 for reading, 4 for writing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import click

from validation.record import write_whole

Document = TypeVar("Document")


class CannotRead(click.ClickException):
    """A record that is missing, damaged or of another schema; the command ends with 2."""

    exit_code = 2


class CannotWrite(click.ClickException):
    """A page that cannot be written: disk, permission; the command ends with 4."""

    exit_code = 4


def read(path: Path, reader: Callable[[Path], Document], cure: str) -> Document:
    """Return what a reader makes of a file; raises CannotRead."""
    if not path.is_file():
        raise CannotRead(f"{path} does not exist; {cure}")
    try:
        return reader(path)
    except (ValueError, OSError) as error:
        raise CannotRead(str(error)) from error


def write(path: Path, text: str) -> None:
    """Write a page, whole or not at all; raises CannotWrite."""
    try:
        write_whole(path, text)
    except OSError as error:
        raise CannotWrite(
            f"{path} cannot be written: {error.strerror}; make room, and run the command again"
        ) from error
