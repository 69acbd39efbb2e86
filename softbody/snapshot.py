"""What a world is at one instant, as named arrays: to go back to, to keep in a file, to compare."""

from __future__ import annotations

import hashlib
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from softbody.errors import ParameterError

Snapshot = dict[str, np.ndarray]
Part = TypeVar("Part", bound=NamedTuple)


def named_arrays(name: str, part: Any) -> Iterator[tuple[str, np.ndarray]]:
    """Yield "name.field" and a copy of each field of a named tuple, and of the named tuples in it."""
    for field, value in part._asdict().items():
        if hasattr(value, "_asdict"):
            yield from named_arrays(f"{name}.{field}", value)
        else:
            yield f"{name}.{field}", np.array(value)


def rebuilt(name: str, like: Part, snapshot: Snapshot) -> Part:
    """Return the named tuple of the kind of `like` that `named_arrays` took apart; raises ParameterError."""
    values: list[Any] = []
    for field, value in like._asdict().items():
        key = f"{name}.{field}"
        if hasattr(value, "_asdict"):
            values.append(rebuilt(key, value, snapshot))
        elif isinstance(value, np.ndarray):
            values.append(entry(snapshot, key).astype(value.dtype))
        else:
            values.append(_number(entry(snapshot, key), key, type(value)))
    return type(like)(*values)


def _number(array: np.ndarray, key: str, kind: type) -> Any:
    try:
        return kind(array.item())
    except (TypeError, ValueError) as error:
        raise ParameterError(f"{key} is {array!r}; it was one number in the world that was saved") from error


def entry(snapshot: Snapshot, key: str) -> np.ndarray:
    """Return one array of a snapshot; raises ParameterError if it is not there."""
    if key not in snapshot:
        raise ParameterError(
            f"{key!r} is missing: this is no snapshot of a world, or one of another version of softbody"
        )
    return np.asarray(snapshot[key])


def digest(arrays: Iterator[tuple[str, np.ndarray]]) -> str:
    """Return a SHA-256 of names and bits, in hexadecimal."""
    result = hashlib.sha256()
    for name, array in arrays:
        result.update(f"{name} {array.dtype.str} {array.shape}".encode())
        result.update(array.tobytes())
    return result.hexdigest()


def write(path: str | Path, snapshot: Snapshot) -> None:
    """Write a snapshot to an NPZ file, whole or not at all."""
    path = Path(path)
    temporary = path.with_name(f".{path.name}.part")
    with temporary.open("wb") as file:
        np.savez(file, **snapshot)  # type: ignore[arg-type]
    temporary.replace(path)


def read(path: str | Path) -> Snapshot:
    """Read what `write` wrote; raises ParameterError for a file of another kind."""
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except (ValueError, EOFError, AttributeError, zipfile.BadZipFile) as error:
        raise ParameterError(f"{path} is no NPZ file of a world: write one with World.save") from error
