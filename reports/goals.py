"""Chart of the goals of speed, on a logarithmic axis of measured / wanted."""

from __future__ import annotations

import math
from dataclasses import dataclass

from validation.record import MET, MISSED, UNMEASURED, Goal, Report

CSS = {MET: "holds", MISSED: "fails"}
MARKS = {0.25: "¼", 0.5: "½", 1.0: "1", 2.0: "2", 4.0: "4"}
ENDS = 4.0  # the axis goes from a quarter to four times what is wanted: what lies beyond sits at the edge


@dataclass(frozen=True)
class Line:
    """A goal that was measured, and where its rounds lie on the axis, in percent; None for a cost that grows."""

    goal: Goal
    css: str
    place: float | None
    low: float | None
    high: float | None


@dataclass(frozen=True)
class Goals:
    """All goals of a run."""

    lines: list[Line]
    unmeasured: list[Goal]

    @property
    def ticks(self) -> list[tuple[float, str]]:
        """Places and labels of the axis, which has marks at powers of two."""
        return [(place_of(ratio), label) for ratio, label in MARKS.items()]

    @property
    def met(self) -> int:
        """How many of the lines are met."""
        return sum(line.goal.verdict == MET for line in self.lines)


def place_of(ratio: float) -> float:
    """Return the place of a ratio on the logarithmic axis, in percent."""
    inside = min(max(ratio, 1.0 / ENDS), ENDS)
    return round(50.0 + 50.0 * math.log(inside) / math.log(ENDS), 2)


def goals_of(report: Report) -> Goals:
    """Return the goals of a run, those that were measured apart."""

    def at(goal: Goal, value: float | None) -> float | None:
        return place_of(value / goal.wanted) if goal.is_least and value is not None else None

    measured = [goal for goal in report.goals if goal.verdict != UNMEASURED]
    lines = [
        Line(goal, CSS.get(goal.verdict, "open"), at(goal, goal.measured), at(goal, goal.low), at(goal, goal.high))
        for goal in measured
    ]
    return Goals(lines, [goal for goal in report.goals if goal.verdict == UNMEASURED])
