"""Atomic files: written beside their place, flushed to the disk, and put there whole or not at all."""

from __future__ import annotations

import os
import secrets
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import BufferedWriter
from pathlib import Path

from softbody.errors import OutputError, ParameterError
from softbody.model.validation import shown

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]


def path_of(path: str | os.PathLike[str]) -> Path:
    """Return the path of a file; raises ParameterError for what cannot be one."""
    try:
        result = Path(path)
    except TypeError as error:
        raise ParameterError(f"path is {shown(path)}; give the name of a file") from error
    if not result.name or "\0" in str(result):
        raise ParameterError(f"path is {shown(path)}; give the name of a file")
    return result


@contextmanager
def whole_file(path: Path) -> Iterator[BufferedWriter]:
    """Yield a file to write to, which takes the place of what stood at `path`, be it a link, when the block has ended.

    Until then it has a name of its own. If anything goes wrong, what stood there stays, and nothing else is left.
    Raises OSError as the disk does.
    """
    part = path.with_name(f".{secrets.token_hex(8)}.part")  # not longer than a name may be, whatever the path's is
    try:
        with part.open("xb") as file:  # never through a link, and never one that exists
            yield file
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    except BaseException as error:
        part.unlink(missing_ok=True)
        if isinstance(error.__context__, KeyboardInterrupt):  # an archive that is closed half-written hides it
            raise error.__context__ from None
        raise
    _flush_folder(path.parent)


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Let nobody else be in such a block for the same folder, in this process or another; wait a while for them.

    Raises OutputError if they are in it still. Systems and disks that have no locks let all in, and so does a folder
    that is gone.
    """
    if fcntl is None or not folder.is_dir():
        yield
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        end = time.monotonic() + PATIENCE
        while not _locked(descriptor):
            if time.monotonic() > end:
                raise OutputError(f"{folder} is being written to by somebody else; give the name of another folder")
            time.sleep(0.01)
        yield
    finally:
        os.close(descriptor)


PATIENCE = 10.0  # [s]


def _locked(descriptor: int) -> bool:
    """Lock what is open, until it is closed; return False if somebody else has locked it."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # this disk has no locks
        return True
    return True


def _flush_folder(folder: Path) -> None:
    """Let the disk know the new name; where folders cannot be flushed, it will some day."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
