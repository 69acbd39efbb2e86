"""Which file is at fault? What cannot be read ends a command with 2, the name of the file and the cure."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import click

Document = TypeVar("Document")


class CannotRead(click.ClickException):
    """A record that is missing, damaged or of another schema; the command ends with 2."""

    exit_code = 2


def read(path: Path, reader: Callable[[Path], Document], cure: str) -> Document:
    """Return what a reader makes of a file; raises CannotRead."""
    if not path.is_file():
        raise CannotRead(f"{path} does not exist; {cure}")
    try:
        return reader(path)
    except (KeyError, TypeError, AttributeError) as error:
        raise CannotRead(f"{path} is damaged ({type(error).__name__}: {error}); {cure}") from error
    except (ValueError, OSError) as error:
        raise CannotRead(str(error)) from error
