"""Plots of trends: every run a dot, every level a line, every step a mark."""

from __future__ import annotations

import statistics
from itertools import pairwise
from typing import TYPE_CHECKING

from matplotlib.ticker import MaxNLocator

from reports.notation import faster, number
from reports.plots import FAILS, HOLDS, INK, MUTED, SERIES, svg
from validation.record import Trend

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LEAST_SPAN = 0.2  # of the median, that an axis shows: noise of a percent is not to look like an alp

SPARK_WIDTH, SPARK_HEIGHT = 96, 22


def span(values: list[float]) -> tuple[float, float]:
    """Return the ends of an axis that holds all values, and is not narrower than LEAST_SPAN."""
    low, high, middle = min(values), max(values), statistics.median(values)
    room = max(0.0, LEAST_SPAN * middle - (high - low)) / 2.0 + 0.08 * (high - low)
    return max(0.0, low - room), high + room


def levels(trend: Trend) -> list[tuple[int, int, float]]:
    """Return first run, end and median of each level."""
    ends = [0, *(step.at for step in trend.steps), len(trend.values)]
    return [(start, end, statistics.median(trend.values[start:end])) for start, end in pairwise(ends)]


def sparkline(trend: Trend) -> str:
    """Return a trend as a small <svg> for a line of a table, its steps upright lines; page.css has its colours."""
    count, (low, high) = len(trend.values), span(trend.values)

    def x(run: float) -> float:
        return round(SPARK_WIDTH * (run + 0.5) / count, 1)

    points = [(x(k), round(SPARK_HEIGHT * (high - v) / (high - low), 1)) for k, v in enumerate(trend.values)]
    marks = "".join(
        f'<line class="{"slower" if step.ratio > 1.0 else "faster"}" x1="{x(step.at - 0.5)}" x2="{x(step.at - 0.5)}" '
        f'y1="0" y2="{SPARK_HEIGHT}"/>'
        for step in trend.steps
    )
    line = " ".join(f"{x},{y}" for x, y in points)
    return (
        f'<svg class="spark" viewBox="0 0 {SPARK_WIDTH} {SPARK_HEIGHT}" width="{SPARK_WIDTH}" height="{SPARK_HEIGHT}" '
        f'aria-hidden="true">{marks}<polyline points="{line}"/>'
        f'<circle cx="{points[-1][0]}" cy="{points[-1][1]}" r="2"/></svg>'
    )


def trend_plot(trend: Trend) -> str:
    """Return a trend against the number of the run, as SVG."""
    return svg(f"{trend.file} {trend.name}", lambda axes: _draw(axes, trend))


def _draw(axes: Axes, trend: Trend) -> None:
    count = len(trend.values)
    axes.set_xlim(0.5, count + 0.5)
    axes.set_ylim(*span(trend.values))
    for step in trend.steps:
        colour = FAILS if step.ratio > 1.0 else HOLDS
        axes.axvline(step.at + 0.5, color=colour, linewidth=1.2, linestyle=(0, (4, 3)))
        share = step.at / count
        side = "right" if share > 0.85 else "left" if share < 0.15 else "center"
        label = faster(1.0 / step.ratio)
        axes.text(step.at + 0.5, 1.03, label, color=colour, ha=side, transform=axes.get_xaxis_transform())
    for start, end, level in levels(trend):
        axes.plot([start + 0.5, end + 0.5], [level, level], color=MUTED, linewidth=1.4)
    axes.plot(range(1, count + 1), trend.values, "o", markersize=4, color=SERIES[0])
    axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))
    axes.yaxis.set_major_locator(MaxNLocator(5))
    axes.yaxis.set_major_formatter(lambda value, _: number(value))
    axes.grid(axis="y")
    axes.set_axisbelow(True)
    axes.set_xlabel("run")
    axes.text(-0.13, 1.16, trend.unit, color=INK, transform=axes.transAxes, parse_math=False)
