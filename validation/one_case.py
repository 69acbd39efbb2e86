"""One case of a claim's comparison: its inputs, both answers and its error."""

from __future__ import annotations

from typing import Any

import numpy as np

from validation.check import Comparison
from validation.plain_text import plain
from validation.record import Case

MOST_NUMBERS = 100  # of an answer or an input that are kept


def case_of(comparison: Comparison, errors: np.ndarray, number: int) -> Case:
    """Return a comparison's case; `errors` (n,) are those of all cases.

    Raises ValueError for inputs that have not one row a case.
    """
    measured, expected = (_row(side, number) for side in (comparison.measured, comparison.expected))
    scale = np.broadcast_to(np.asarray(comparison.scale, float), errors.shape)[number]
    return Case(
        number=number,
        error=float(errors[number]),
        scale=float(scale),
        measured=measured.ravel()[:MOST_NUMBERS].tolist(),
        expected=expected.ravel()[:MOST_NUMBERS].tolist(),
        group=None if comparison.groups is None else plain(np.asarray(comparison.groups)[number]),
        inputs=inputs_of(comparison, len(errors), number),
        length=measured.size,
    )


def inputs_of(comparison: Comparison, count: int, number: int) -> dict[str, Any]:
    """Return what a case was about: name → value, or what it is where it is too large; raises ValueError."""
    found: dict[str, Any] = {}
    for name, rows in comparison.inputs.items():
        if len(rows) != count:
            raise ValueError(f"inputs[{name!r}] has {len(rows)} rows for {count} cases: give one a case")
        row = _row(rows, number)
        if row.size > MOST_NUMBERS:
            found[name] = f"array of shape {row.shape}"
        else:
            found[name] = row.tolist() if row.dtype.kind in "biuf" else plain(rows[number])
    return found


def _row(rows: Any, number: int) -> np.ndarray:
    return np.asarray(np.asarray(rows)[number])
