"""Plots of the distribution of errors and of the cost of steps, by Matplotlib, as SVG for the page."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import matplotlib
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from reports.notation import count, number, power_of_ten
from validation.record import ClaimRecord, Timing

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDTH, HEIGHT = 400, 230  # of a plot, in its own units: at this width its 11.5-unit letters are read on a phone
BASE = 0.6  # of the bars on their logarithmic axis: below 1, so that a single case has a bar
LEAST_DECADES = 2.0  # of an error axis, so that errors that are all alike do not fill it

# Colours that the page's style sheet owns. Matplotlib wants numbers: each stands for a CSS variable.
INK, MUTED, LINE, HOLDS, FAILS = "#010101", "#020202", "#030303", "#040404", "#050505"
SERIES = tuple(f"#0000{n:02x}" for n in range(0xA1, 0xA7))
MARKERS = {"o": "●", "s": "■", "^": "▲", "D": "◆", "v": "▼", "P": "✚"}
VARIABLES = {INK: "--ink", MUTED: "--muted", LINE: "--line", HOLDS: "--holds", FAILS: "--fails"}
VARIABLES |= {colour: f"--series-{n}" for n, colour in enumerate(SERIES, 1)}

STYLE = {
    "svg.fonttype": "none",
    "font.size": 11.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "grid.color": LINE,
    "grid.linewidth": 0.8,
    "path.simplify": True,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
}


def error_plot(claim: ClaimRecord, name: str) -> str | None:
    """Return the histogram of a claim's errors with its tolerance, as SVG; None if there is nothing to draw."""
    errors = claim.errors
    if errors is None or not (any(errors.counts) or (errors.zeros and claim.tolerance)):
        return None
    return svg(name, lambda axes: _draw_errors(axes, claim))


def _draw_errors(axes: Axes, claim: ClaimRecord) -> None:
    errors = claim.errors
    assert errors is not None
    limit = math.log10(claim.tolerance) if claim.tolerance else None
    low, high = _span([*errors.log10_edges[:1], *errors.log10_edges[-1:], *([] if limit is None else [limit])])
    if any(errors.counts):
        pairs = list(zip(errors.log10_edges, errors.log10_edges[1:]))
        fails = limit is None or (claim.value is not None and claim.value > claim.tolerance)
        over = [fails and (limit is None or right > limit) for _, right in pairs]
        for colour, wanted in ((HOLDS, False), (FAILS, True)):
            heights = [n if n and o == wanted else BASE for n, o in zip(errors.counts, over)]
            if max(heights) > BASE:
                axes.stairs(heights, errors.log10_edges, baseline=BASE, fill=True, facecolor=colour, edgecolor="none")
    step = max(1, math.ceil((high - low) / 6))
    powers = [p for p in range(math.ceil(low), math.floor(high) + 1) if p % step == 0]
    places, labels = [float(p) for p in powers], [power_of_ten(p) for p in powers]
    if errors.zeros:  # 0 has no logarithm: its bar stands apart, left of a gap in the axis
        width = 0.035 * (high - low)
        zero, low = low - 2.0 * width, low - 3.5 * width
        axes.bar([zero], [errors.zeros - BASE], width, bottom=BASE, color=HOLDS)
        axes.axvline(zero + 1.5 * width, color=MUTED, linewidth=0.8, linestyle=(0, (1, 3)))
        places, labels = [zero, *places], ["0", *labels]
    axes.set_xlim(low, high)
    axes.set_xticks(places, labels)
    axes.set_xlabel(f"error [{claim.unit}]", parse_math=False)
    _count_axis(axes, max([errors.zeros, *errors.counts]))
    if limit is not None:
        axes.axvline(limit, color=FAILS, linewidth=1.6)
        share = (limit - low) / (high - low)
        side = "right" if share > 0.75 else "left" if share < 0.25 else "center"
        label = f"tolerance {number(claim.tolerance)}"
        axes.text(limit, 1.03, label, color=FAILS, ha=side, transform=axes.get_xaxis_transform())


def _span(logs: list[float]) -> tuple[float, float]:
    """Return the ends of an error axis that holds all of `logs`, with some room."""
    low, high = (min(logs), max(logs)) if logs else (-LEAST_DECADES, 0.0)
    room = max(0.0, LEAST_DECADES - (high - low)) / 2.0 + 0.06 * (high - low)
    return low - room, high + room


def _count_axis(axes: Axes, most: int) -> None:
    """Make the vertical axis logarithmic, so that one outlier among thousands is seen."""
    axes.set_yscale("log")
    axes.set_ylim(BASE, 1.5 * max(most, 10))
    powers = range(0, math.floor(math.log10(max(most, 10))) + 1)
    axes.set_yticks([10.0**p for p in powers], [count(10**p) if p < 4 else power_of_ten(p) for p in powers])
    axes.yaxis.set_minor_locator(NullLocator())
    axes.grid(axis="y")
    axes.set_axisbelow(True)
    axes.text(-0.13, 1.16, "comparisons", transform=axes.transAxes)


def timing_plot(timings: list[Timing]) -> str | None:
    """Return the costs of one table against the size, a series a name, as SVG; None if there is nothing to draw."""
    rows = drawable(timings)
    return svg(rows[0].table, lambda axes: _draw_timings(axes, rows)) if rows else None


def work_plot(timings: list[Timing]) -> str | None:
    """Return the errors of one table against their costs, a series a name, as SVG; None if there is nothing to draw."""
    rows = [t for t in drawable(timings) if t.error]
    return svg(rows[0].table, lambda axes: _draw_work(axes, rows)) if rows else None


def course_plot(course: list[tuple[float, int]]) -> str | None:
    """Return how many faults are seen after how many seconds, as SVG; None if there is nothing to draw."""
    return svg("soonest", lambda axes: _draw_course(axes, course)) if course else None


def _draw_course(axes: Axes, course: list[tuple[float, int]]) -> None:
    axes.step(*zip(*course), where="post", color=HOLDS, linewidth=1.6)
    axes.set_xlim(0.0, 1.02 * course[-1][0])
    axes.set_ylim(0.0, 1.05 * course[-1][1])
    axes.grid(axis="y")
    axes.set_xlabel("seconds of claims, one after the other")
    axes.set_title("planted faults that have turned a claim red", loc="left", fontsize="medium", color=MUTED)


def drawable(timings: list[Timing]) -> list[Timing]:
    """Return the timings that have a place on logarithmic axes."""
    return [t for t in timings if t.size > 0 and t.nanoseconds and t.nanoseconds > 0.0]


def series(timings: list[Timing]) -> dict[str, tuple[str, str]]:
    """Return, for each name, its colour and its marker in the plot; once the colours are used up, the markers shift."""
    names = dict.fromkeys(t.name for t in timings)
    markers = list(MARKERS)
    shifts = len(SERIES)
    return {name: (SERIES[i % shifts], markers[(i + i // shifts) % len(markers)]) for i, name in enumerate(names)}


def _draw_timings(axes: Axes, timings: list[Timing]) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    rows = sorted(timings, key=lambda t: t.size)
    for name, (colour, marker) in series(timings).items():
        part = [t for t in rows if t.name == name]
        below = [max(0.0, t.nanoseconds - t.low) if t.low else 0.0 for t in part]
        above = [max(0.0, t.high - t.nanoseconds) if t.high else 0.0 for t in part]
        axes.errorbar(
            [t.size for t in part],
            [t.nanoseconds for t in part],
            yerr=[below, above],
            color=colour,
            marker=marker,
            markersize=5,
            linewidth=1.4,
            capsize=3,
        )
    sizes = sorted({t.size for t in rows})
    axes.set_xlim(sizes[0] / 1.5, sizes[-1] * 1.5)
    if len(sizes) <= 6:
        axes.set_xticks(sizes, [count(n) for n in sizes])
    axes.xaxis.set_minor_locator(NullLocator())
    ends = [v for t in rows for v in (t.low or t.nanoseconds, t.high or t.nanoseconds)]
    bottom, top = min(ends) / 1.4, max(ends) * 1.4
    axes.set_ylim(bottom, top)
    ticks = [m * 10.0**p for p in range(-3, 12) for m in (1, 2, 5) if bottom <= m * 10.0**p <= top]
    ticks = ticks if len(ticks) <= 8 else [t for t in ticks if math.log10(t) % 1.0 == 0.0]
    axes.set_yticks(ticks, [number(t) for t in ticks])
    axes.yaxis.set_minor_locator(NullLocator())
    axes.grid(axis="y")
    axes.set_axisbelow(True)
    axes.set_xlabel(rows[0].of, parse_math=False)
    axes.text(-0.13, 1.08, f"ns per {rows[0].per}", transform=axes.transAxes, parse_math=False)


def _draw_work(axes: Axes, timings: list[Timing]) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    rows = sorted(timings, key=lambda t: t.nanoseconds)
    for name, (colour, marker) in series(timings).items():
        part = [t for t in rows if t.name == name]
        costs, errors = [t.nanoseconds for t in part], [t.error or 0.0 for t in part]
        axes.plot(costs, errors, color=colour, marker=marker, markersize=5, linewidth=1.4)
    axes.set_xlim(rows[0].nanoseconds / 1.5, rows[-1].nanoseconds * 1.5)
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_minor_locator(NullLocator())
    axes.grid(axis="both")
    axes.set_axisbelow(True)
    axes.set_xlabel(f"ns per {rows[0].per}", parse_math=False)
    axes.text(-0.13, 1.08, "relative error", transform=axes.transAxes)


def svg(name: str, draw: Callable[[Axes], None]) -> str:
    """Return a drawing as an <svg> for a page: no metadata, ids of its own, the page's colours and fonts."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()  # not what a matplotlibrc of the reader's says
        settings: Any = STYLE | {"svg.hashsalt": name}
        matplotlib.rcParams.update(settings)
        figure = Figure(figsize=(WIDTH / 72, HEIGHT / 72))
        draw(figure.add_axes((0.125, 0.21, 0.845, 0.60)))
        written = io.StringIO()
        figure.savefig(written, format="svg", metadata={"Creator": None, "Date": None, "Format": None, "Type": None})
    text = written.getvalue()
    return tidied(text[text.index("<svg") :])


def tidied(svg: str) -> str:
    """Return Matplotlib's SVG without what a page does not need, and with the page's colours for the stand-ins."""
    svg = re.sub(r"<!--.*?-->|<metadata>.*?</metadata>|<style.*?</style>|<clipPath.*?</clipPath>", "", svg, flags=re.S)
    svg = re.sub(r"<svg[^>]*>", f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" aria-hidden="true">', svg, count=1)
    svg = re.sub(r"<[^>]+>", lambda tag: _tidied_tag(tag[0]), svg)  # never what stands between the tags: the labels
    return re.sub(r"<defs>\s*</defs>", "", re.sub(r">\s+<", "><", svg)).strip()


def _tidied_tag(tag: str) -> str:
    tag = re.sub(r'^<g id="[^"]*"', "<g", tag)  # figure_1, axes_1 …: the same in every plot of the page
    tag = re.sub(r' clip-path="[^"]*"| transform="rotate\(-0 [^"]*"', "", tag)  # nothing is drawn outside its axes
    tag = re.sub(r"font: ([\d.]+)px [^;\"]*", r"font-size: \1px", tag)  # Matplotlib before 3.11
    tag = re.sub(r"font-family: [^;\"]*;? ?", "", tag)
    tag = re.sub(r"#0[0-9a-f]{5}\b", lambda m: f"var({VARIABLES[m[0]]})" if m[0] in VARIABLES else m[0], tag)
    tag = re.sub(r"(\d\.\d{2})\d+", r"\1", tag)
    return re.sub(r"\s+", " ", tag.replace("xlink:href", "href")).replace(' "', '"')
