"""What claims about files and films share: rows of which either side may lack some."""

from __future__ import annotations

import numpy as np

from validation.answers import Answers


def row_of(time: float, positions: np.ndarray, velocities: np.ndarray) -> np.ndarray:
    """Return time, middle and mean velocity (7,) of a body, of whose points there is a row each."""
    return np.hstack([time, positions.mean(axis=0), velocities.mean(axis=0)])


def extend_evenly(
    answers: Answers, measured: np.ndarray, expected: np.ndarray, kind: str, is_relative: bool = False
) -> None:
    """Add rows (n, k) of the core and of the judge; what either side lacks is zeros.

    Relative errors are of the length of the judge's row, of which 1 is the least.
    """
    count = max(len(measured), len(expected))
    ours, judged = (np.vstack([rows, np.zeros((count - len(rows), rows.shape[1]))]) for rows in (measured, expected))
    answers.extend(ours, judged, 1.0 + np.linalg.norm(judged, axis=1) if is_relative else 1.0, kind)
