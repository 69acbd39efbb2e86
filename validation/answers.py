"""Answers to a claim's cases, gathered while they are asked: the core's beside the judge's."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

import numpy as np

from validation.check import Comparison

Asked = TypeVar("Asked")


class Answers:
    """What the core answered and what the judge answered, case after case."""

    def __init__(self) -> None:
        self._measured: list[np.ndarray] = []
        self._expected: list[np.ndarray] = []
        self._scales: list[np.ndarray] = []
        self._kinds: list[str] = []
        self._inputs: dict[str, list[np.ndarray]] = {}

    def __len__(self) -> int:
        return sum(len(part) for part in self._measured)

    def add(self, measured: Any, expected: Any, scale: float = 1.0, kind: str = "", **inputs: Any) -> None:
        """Add one case: a number, yes or no, or (k,) of them; what errors are divided by; what was asked, by name."""
        rows = {name: np.asarray(value)[None] for name, value in inputs.items()}
        self.extend(np.asarray(measured)[None], np.asarray(expected)[None], scale, kind, **rows)

    def extend(self, measured: Any, expected: Any, scale: Any = 1.0, kind: Any = "", **inputs: Any) -> None:
        """Add cases, (n,) or (n, k); `scale` and `kind` are one for all, or (n,); inputs have a row a case.

        Raises ValueError where there are not as many of one as of the other.
        """
        ours, theirs = np.asarray(measured), np.asarray(expected)
        kinds = [kind] * len(ours) if isinstance(kind, str) else list(kind)
        counts = {len(theirs), len(kinds), *(len(rows) for rows in inputs.values())}
        if counts != {len(ours)}:
            raise ValueError(f"{len(ours)} answers of the core, and of the judge, kinds or inputs {sorted(counts)}")
        self._measured.append(ours)
        self._expected.append(theirs)
        self._scales.append(np.broadcast_to(np.asarray(scale, float), ours.shape[:1]))
        self._kinds += kinds
        for name, rows in inputs.items():
            self._inputs.setdefault(name, []).append(np.asarray(rows))

    def comparison(self, **more: Any) -> Comparison:
        """Return all cases as one comparison; `more` are other fields of it, such as `printed` or `notes`."""
        return Comparison(
            np.concatenate(self._measured) if self._measured else [],
            np.concatenate(self._expected) if self._expected else [],
            np.concatenate(self._scales) if self._scales else 1.0,
            groups=self._kinds if any(self._kinds) else None,
            **{"inputs": {name: np.concatenate(rows) for name, rows in self._inputs.items()}, **more},
        )


def compare(
    cases: Mapping[str, Asked] | Iterable[tuple[str, Asked]],
    ours: Callable[[Asked], Any],
    judge: Callable[[Asked], Any],
    scale: Callable[[Asked], Any] = lambda case: 1.0,
    **more: Any,
) -> Comparison:
    """Ask the core and the judge about each case, of a kind: both map it to answers, (n,) or (n, k)."""
    answers = Answers()
    for kind, case in cases.items() if isinstance(cases, Mapping) else cases:
        answers.extend(ours(case), judge(case), scale(case), kind)
    return answers.comparison(**more)
