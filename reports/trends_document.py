"""The document of how timings have changed: trends.json, read and checked.

`Trends` is the document, and with `validation.record.Trend` its schema; `python -m benchmarks publish` writes it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from validation.record import Trend, read_document

SCHEMA = "softbody-trends/1"
CURE = "write it by `python -m benchmarks publish FOLDER`"


@dataclass
class Run:
    """One run of the benchmarks."""

    started: str  # ISO 8601
    revision: str  # with "+" if the working tree differed
    level: str | None
    load: float | None  # of the machine, when it began
    versions: dict[str, str]


@dataclass
class Rate:
    """How many of some comparisons of two revisions ended in a verdict."""

    percent: int  # slow-down that was planted; 0: none, and `found` are false alarms
    comparisons: int
    found: int
    openings: int  # from which they are drawn


@dataclass
class Calibration:
    """How often verdicts err, as the machine was found on some day."""

    started: str
    revision: str
    load: float | None
    rates: list[Rate]


@dataclass
class Trends:
    """All benchmarks of one machine."""

    machine: dict[str, str]
    runs: list[Run]  # oldest first
    fewest: int  # runs in which a step can be found
    calibration: Calibration | None
    trends: list[Trend]
    schema: str = SCHEMA


def read_trends(path: Path) -> Trends:
    """Read the document; raises ValueError, naming the file, if it is not of this schema."""
    return read_document(path, Trends, (SCHEMA,), CURE)
