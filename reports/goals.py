"""How far is each goal of speed met? Places what was measured on a logarithmic axis of measured / wanted."""

from __future__ import annotations

import math
from dataclasses import dataclass

from validation.record import MET, MISSED, UNMEASURED, Goal, Report

CSS = {MET: "holds", MISSED: "fails"}
MARKS = {0.25: "¼", 0.5: "½", 1.0: "1", 2.0: "2", 4.0: "4"}
ENDS = 4.0  # the axis goes from a quarter to four times what is wanted: what lies beyond sits at the edge


@dataclass(frozen=True)
class Axis:
    """A logarithmic axis of measured / wanted, marked at powers of two."""

    def at(self, ratio: float) -> float:
        """Return the place of a ratio, in percent of the axis."""
        inside = min(max(ratio, 1.0 / ENDS), ENDS)
        return round(50.0 + 50.0 * math.log(inside) / math.log(ENDS), 2)

    @property
    def ticks(self) -> list[tuple[float, str]]:
        """Places and labels."""
        return [
            (self.at(ratio), label) for ratio, label in ((0.25, "¼"), (0.5, "½"), (1.0, "1"), (2.0, "2"), (4.0, "4"))
        ]


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

    axis: Axis
    lines: list[Line]
    unmeasured: list[Goal]

    @property
    def met(self) -> int:
        """How many of the lines are met."""
        return sum(line.goal.verdict == MET for line in self.lines)


def goals_of(report: Report) -> Goals:
    """Return the goals of a run, those that were measured apart."""
    axis = Axis()

    def at(goal: Goal, value: float | None) -> float | None:
        return axis.at(value / goal.wanted) if goal.is_least and value is not None else None

    measured = [goal for goal in report.goals if goal.verdict != UNMEASURED]
    lines = [
        Line(goal, CSS.get(goal.verdict, "open"), at(goal, goal.measured), at(goal, goal.low), at(goal, goal.high))
        for goal in measured
    ]
    return Goals(axis, lines, [goal for goal in report.goals if goal.verdict == UNMEASURED])
