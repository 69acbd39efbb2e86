"""Snapshots as NPZ files: written whole or not at all, and read as untrusted input."""

from __future__ import annotations

import io
import os
import stat
import zipfile
from math import prod
from typing import IO, NamedTuple

import numpy as np

from softbody.errors import SnapshotError
from softbody.storage.atomic_file import path_of, whole_file

MOST_BYTES = 2**30  # that a file may have, and that its arrays may take: a world of some five million particles

MOST_ENTRIES = 1_000  # a world has some 70
MOST_HEADER = 1_000  # bytes that say what an array is; those of a world take 120
KINDS = "biufU"  # of what arrays may hold: truth values, numbers, words
PACKED = {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}  # as np.savez and np.savez_compressed do


class Kind(NamedTuple):
    """Which files are read, as messages call them."""

    what: str
    writer: str
    reader: str


WORLD = Kind("a world", "World.save", "World.load")


def write(path: str | os.PathLike[str], snapshot: dict[str, np.ndarray]) -> None:
    """Write a snapshot to an NPZ file, whole or not at all.

    If anything goes wrong, what stood there stays, and nothing else is left. Raises OSError as the disk does.
    """
    with whole_file(path_of(path)) as file:
        np.savez(file, **snapshot)  # type: ignore[arg-type]


def read(path: str | os.PathLike[str], most_bytes: int, kind: Kind = WORLD) -> dict[str, np.ndarray]:
    """Return the arrays of a file that `write` may have written; they must be checked.

    Raises SnapshotError for a file of another kind, a damaged one, and one that is, or unpacks to, more than
    `most_bytes`, before memory is taken for that; OSError if it cannot be read.
    """
    path = path_of(path)
    if not stat.S_ISREG(path.stat().st_mode):
        raise SnapshotError(f"{path} is no file; give one that {kind.writer} wrote")
    with path.open("rb") as file:
        # (A file that is asked for a number of bytes takes memory for that many, however few it has.)
        raw = file.read(min(most_bytes, os.fstat(file.fileno()).st_size) + 1)
    try:
        if len(raw) > most_bytes:
            raise _too_large(len(raw), most_bytes, kind)
        with zipfile.ZipFile(io.BytesIO(raw)) as archive:
            _check_archive(archive, most_bytes, kind)
            return {name.removesuffix(".npy"): _array(archive, name) for name in archive.namelist()}
    except SnapshotError as error:
        raise SnapshotError(f"{path}: {error}") from error
    except Exception as error:  # whatever zipfile, zlib and NumPy raise where bytes are not what they expect
        raise SnapshotError(
            f"{path} is no NPZ file of {kind.what}, or a damaged one: write one with {kind.writer}"
        ) from error


def _check_archive(archive: zipfile.ZipFile, most_bytes: int, kind: Kind) -> None:
    """Raise SnapshotError unless all that an archive holds are different small enough arrays."""
    entries = archive.infolist()
    if len(entries) > MOST_ENTRIES:
        raise SnapshotError(f"it has {len(entries)} entries, and {kind.what} less than {MOST_ENTRIES}")
    total, names = 0, set[str]()
    for entry in entries:
        name = entry.filename
        if name in names:
            raise SnapshotError(f"{name!r} is there twice")
        names.add(name)
        if entry.flag_bits & 1:
            raise SnapshotError(f"{name!r} is encrypted; it must not be")
        if entry.compress_type not in PACKED or not name.endswith(".npy"):
            raise SnapshotError(f"{name!r} is no array as np.savez packs it")
        with archive.open(entry) as file:
            shape, _, number = _header(file)
            size = prod(shape) * number.itemsize
            if number.kind not in KINDS or entry.file_size != file.tell() + size:
                raise SnapshotError(
                    f"{name!r} is not what it says: {number} of shape {shape} in {entry.file_size} bytes"
                )
        total += size
        if total > most_bytes:
            raise _too_large(total, most_bytes, kind)


def _header(file: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype]:
    """Return shape, whether columns come first, and kind of an array, as its first bytes say."""
    version = np.lib.format.read_magic(file)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    return read(file, max_header_size=MOST_HEADER)


def _array(archive: zipfile.ZipFile, name: str) -> np.ndarray:
    with archive.open(name) as file:
        return np.lib.format.read_array(file, allow_pickle=False, max_header_size=MOST_HEADER)


def _too_large(size: int, most_bytes: int, kind: Kind) -> SnapshotError:
    return SnapshotError(
        f"it has, or unpacks to, {size} bytes and more, and {most_bytes} are allowed; if you trust it, give "
        f"{kind.reader} a larger most_bytes"
    )
