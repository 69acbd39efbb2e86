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
        sentence=sentence(trends),
        wears=wears(trends),
        rates=rates(trends.calibration) if trends.calibration else [],
    )


def sentence(trends: Trends) -> str:
    """Return what has become of all benchmarks by their last steps; those of too few runs show none."""
    few = len(_too_short(trends))
    if few == len(trends.trends):
        runs = max((len(trend.values) for trend in trends.trends), default=0)
        return f"Too few runs to see a step: {runs} of {trends.fewest}"
    slower = sum(_last_ratio(trend) > 1.0 for trend in trends.trends)
    faster = sum(_last_ratio(trend) < 1.0 for trend in trends.trends)
    count = len(trends.trends)
    benchmarks = f"{count} benchmark{'s' if count > 1 else ''}"
    words = [(n, word) for n, word in ((slower, "slower"), (faster, "faster")) if n]
    rest = [f"{n} {word}" for n, word in words[1:]] + ([f"{few} with too few runs"] if few else [])
    first = f"{words[0][0]} of {benchmarks} became {words[0][1]}" if words else f"No step in {benchmarks}"
    return ", ".join([first, *rest])


def wears(trends: Trends) -> tuple[str, str]:
    """Return the class and the sign of the page: good only if every benchmark has enough runs, and none is slower."""
    if any(_last_ratio(trend) > 1.0 for trend in trends.trends):
        return "open", "▲"
    return ("open", "–") if _too_short(trends) or not trends.trends else ("holds", "✓")


def _too_short(trends: Trends) -> list[Trend]:
    """Return the benchmarks of too few runs to see a step in."""
    return [trend for trend in trends.trends if len(trend.values) < trends.fewest]


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
