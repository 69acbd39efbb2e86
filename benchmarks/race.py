"""What one benchmark is: a call of ours, its peers, the row of a table that it fills, and where each round starts."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

Peer = tuple[Callable[[], Any], float]  # what to call, and how many units of work one call does


def short_name(nodeid: str) -> str:
    """Return pytest's name of a benchmark without the folders: bench_step.py::bench_step[1]."""
    file, colons, rest = nodeid.partition("::")
    return file.rpartition("/")[2] + colons + rest


def nothing() -> None:
    """Do nothing: a call that changes nothing needs no putting back."""


@dataclass(frozen=True)
class Race:
    """A call of ours and the peers that do the same work; see the fixture `race`."""

    ours: Callable[[], Any]
    units: float
    table: str
    name: str
    size: int
    of: str
    per: str
    peers: Mapping[str, Peer] | Callable[[], Mapping[str, Peer]] = field(default_factory=dict)
    errors: Mapping[str, float] = field(default_factory=dict)
    restore: Callable[[], None] = nothing
    answer: Callable[[], Any] | None = None
    threads: int = 1
    own: Collection[str] = ()
    clock: float | None = None

    def rivals(self) -> dict[str, Peer]:
        """Return the peers; those that take long to make are made only now."""
        return dict(self.peers() if callable(self.peers) else self.peers)

    def ask(self) -> list[np.ndarray]:
        """Do one call from the start and return what it has computed; raises ValueError if that is nothing."""
        self.restore()
        returned = self.ours()
        arrays = arrays_of(self.answer() if self.answer else returned)
        if not arrays:
            raise ValueError("its answer cannot be checked: return it from the call, or give race(…, answer=…)")
        return arrays


def arrays_of(value: Any) -> list[np.ndarray]:
    """Return all numbers in a value as arrays, in order; raises TypeError for what is neither number nor container."""
    if value is None:
        return []
    if isinstance(value, np.ndarray | np.generic | bool | int | float):
        return [np.array(value)]
    if isinstance(value, tuple | list):
        return [array for each in value for array in arrays_of(each)]
    raise TypeError(f"an answer of type {type(value).__name__} cannot be compared; give arrays, numbers or tuples")
