"""The page of trends: gathers it from the document and pours it into the template."""

from __future__ import annotations

import re
from dataclasses import dataclass

from markupsafe import Markup

from reports.notation import THIN, percent
from reports.template import rendered
from reports.trend_plots import trend_plot
from reports.trends_document import Calibration, Trends
from validation.record import Trend


@dataclass
class Panel:
    """A benchmark as the page shows it."""

    trend: Trend
    anchor: str
    plot: Markup


def page(trends: Trends) -> str:
    """Return the whole page; the same document gives the same text."""
    panels = [
        Panel(trend, f"{number}-{re.sub(r'[^A-Za-z0-9_]+', '-', trend.name)}", Markup(trend_plot(trend)))
        for number, trend in enumerate(trends.trends, 1)
    ]
    files: dict[str, list[Panel]] = {}
    for panel in panels:
        files.setdefault(panel.trend.file, []).append(panel)
    newest_first = sorted(
        ((step, panel) for panel in panels for step in panel.trend.steps), key=lambda one: one[0].started, reverse=True
    )
    return rendered(
        "trends.html.jinja",
        trends=trends,
        files=files,
        stepped=newest_first,
        sentence=sentence(trends.trends),
        is_slower=any(_last_ratio(trend) > 1.0 for trend in trends.trends),
        rates=rates(trends.calibration) if trends.calibration else [],
    )


def sentence(trends: list[Trend]) -> str:
    """Return what has become of all benchmarks by their last steps."""
    slower = sum(_last_ratio(trend) > 1.0 for trend in trends)
    faster = sum(_last_ratio(trend) < 1.0 for trend in trends)
    benchmarks = f"{len(trends)} benchmark{'s' if len(trends) > 1 else ''}"
    words = [(n, word) for n, word in ((slower, "slower"), (faster, "faster")) if n]
    if not words:
        return f"No step in {benchmarks}"
    (first, became), *rest = words
    return ", ".join([f"{first} of {benchmarks} became {became}", *(f"{n} {word}" for n, word in rest)])


def _last_ratio(trend: Trend) -> float:
    return trend.steps[-1].ratio if trend.steps else 1.0


def rates(calibration: Calibration) -> list[tuple[str, str]]:
    """Return what was planted, and in how many comparisons something was found."""
    return [
        (
            f"slow-downs by {rate.percent}{THIN}% found" if rate.percent else "false alarms",
            f"{percent(rate.found / rate.comparisons)} of {rate.comparisons} comparisons, "
            f"drawn from {rate.openings} openings",
        )
        for rate in calibration.rates
        if rate.comparisons
    ]
