"""Checks of a snapshot's entries: kind, shape and range of each; errors name the entry and the cure."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

import numpy as np

from softbody.errors import SnapshotError
from softbody.model.arrays import Rows

Snapshot = dict[str, np.ndarray]

# The largest size, in SI units, of any number that a snapshot may hold, and the inverse of the least of those that must
# be positive: what a step makes of them, such as a product of squares, is neither 0 nor inf.
LARGEST = 1e50

KINDS = {"b": "true or false", "i": "whole numbers", "f": "real numbers", "U": "a word"}


class Entries:
    """The entries of a snapshot, each to be taken once; nothing in them is believed."""

    def __init__(self, snapshot: Mapping[str, Any], what: str = "a snapshot of a world") -> None:
        """`what` they are meant to be, as messages call it."""
        self._what = what
        if not isinstance(snapshot, Mapping):
            raise SnapshotError(f"a snapshot is a dict of arrays, and this is a {type(snapshot).__name__}")
        self._left = dict(snapshot)

    def names(self) -> list[str]:
        """Return the names of those that are left."""
        return [str(name) for name in self._left]

    def length(self, name: str) -> int:
        """Return the number of rows of an entry that is left, 0 if there are none."""
        value = self._left.get(name)
        return len(value) if isinstance(value, np.ndarray) and value.ndim else 0

    def leave_out(self, prefix: str) -> None:
        """Forget entries whose names begin with `prefix`."""
        self._left = {name: value for name, value in self._left.items() if not str(name).startswith(prefix)}

    def put(self, name: str, array: np.ndarray) -> None:
        """Add an entry that older formats do not have."""
        self._left.setdefault(name, array)

    def word(self, name: str) -> str:
        """Take a word."""
        return str(self._one(name, "U"))

    def words(self, name: str, count: int) -> list[str]:
        """Take so many words."""
        array = self._take(name)
        self._check_shape(name, array, (count,))
        if array.dtype.kind != "U":
            raise SnapshotError(f"{name} holds {array.dtype}; it must be words")
        _check_letters(name, array)
        return [str(word) for word in array.tolist()]

    def truth(self, name: str) -> bool:
        """Take a truth value."""
        return bool(self._one(name, "b"))

    def whole(self, name: str, least: int = 0, most: int = 2**62) -> int:
        """Take a whole number."""
        value = int(self._one(name, "iu"))
        if not least <= value <= most:
            raise SnapshotError(f"{name} is {value}; it must be a whole number from {least} to {most}")
        return value

    def any_real(self, name: str) -> float:
        """Take a real number, which may be infinite or NaN."""
        return float(self._one(name, "f"))

    def real(self, name: str, limits: Rows, none: float | None = None) -> float:
        """Take a real number within limits, or the one that stands for `none`."""
        value = self._one(name, "f")
        if value != none:
            _check(name, np.array(value, np.float64), limits)
        return float(value)

    def rows(self, name: str, shape: tuple[int, ...], rows: Rows) -> np.ndarray:
        """Take an array of real or whole numbers as a copy of its own, finite and within the limits of `rows`."""
        array = self._take(name)
        self._check_shape(name, array, shape)
        kind = np.dtype(np.int64 if rows.whole else np.float64)
        if array.dtype.newbyteorder("=") != kind:
            raise SnapshotError(f"{name} holds {array.dtype}; it must hold {kind}")
        copy = np.array(array, kind, order="C", subok=False)
        _check(name, copy, rows)
        return copy

    def none_left(self) -> None:
        """Raise SnapshotError if there is an entry that nobody took."""
        for name in self._left:
            raise SnapshotError(f"{name!r} is no entry of {self._what}; take it out")

    def _one(self, name: str, kinds: str) -> Any:
        array = self._take(name)
        self._check_shape(name, array, ())
        if array.dtype.kind not in kinds:
            raise SnapshotError(f"{name} holds {array.dtype}; it must be {KINDS[kinds[0]]}")
        if array.dtype.kind == "U":
            _check_letters(name, array)
        return array.item()

    def _take(self, name: str) -> np.ndarray:
        if name not in self._left:
            raise SnapshotError(f"{name!r} is missing: this is not {self._what}, or one of another version of softbody")
        value = self._left.pop(name)
        if isinstance(value, np.ndarray):
            return np.asarray(value)  # not below: what a handler of signals raises there would be taken for damage
        try:
            return np.asarray(value)
        except Exception as error:  # whatever an object that is asked to be an array may raise
            raise SnapshotError(f"{name} is no array") from error

    @staticmethod
    def _check_shape(name: str, array: np.ndarray, shape: tuple[int, ...]) -> None:
        if array.shape != shape:
            raise SnapshotError(f"{name} has shape {array.shape}; it must be {shape}, to go with the other entries")


def _check(name: str, array: np.ndarray, rows: Rows) -> None:
    """Raise SnapshotError for the first number that is not finite or not within limits."""
    good = np.isfinite(array) & (array >= rows.least) & (array > rows.above) & (array <= rows.most)
    good &= (array == 0.0) | (np.abs(array) > rows.beyond)
    if not rows.whole:
        good &= np.abs(array) <= LARGEST
        if rows.above >= 0.0:
            good &= array >= 1.0 / LARGEST
    if not good.all():
        place = np.unravel_index(int(np.argmin(good)), array.shape)
        where = f"{name}[{', '.join(map(str, place))}]" if array.ndim else name
        raise SnapshotError(f"{where} is {array[place]}; it must be {_limits(rows)}")


def _limits(rows: Rows) -> str:
    """Return in words what the numbers of an array may be."""
    if rows.beyond > -np.inf:
        return f"0, or a finite number of a size > {rows.beyond:g}, up to {LARGEST:g}"
    limits = [
        f"> {rows.above:g}" if rows.above > -np.inf else "",
        f"≥ {rows.least:g}" if rows.least > -np.inf else "",
        f"≤ {rows.most:g}" if rows.most < np.inf else "",
    ]
    bounds = " and ".join(limit for limit in limits if limit)
    sizes = f"between {1 / LARGEST:g} and {LARGEST:g}" if rows.above >= 0.0 else f"up to {LARGEST:g}"
    return f"a whole number {bounds}".strip() if rows.whole else f"a finite number {bounds}".strip() + f", {sizes}"


def _check_letters(name: str, words: np.ndarray) -> None:
    """Raise SnapshotError for words of numbers that no letter has: Python would stop with a SystemError at them."""
    letters = np.frombuffer(words.tobytes(), np.dtype(np.uint32).newbyteorder(words.dtype.byteorder))
    if letters.size and letters.max() > sys.maxunicode:
        raise SnapshotError(f"{name} holds {letters.max():#x}, which is no letter")
