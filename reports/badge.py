"""Badge of a run for a README, in a line: who was judged, and how many claims hold."""

from __future__ import annotations

from reports import verdicts
from reports.template import rendered
from validation.record import BROKEN, FAILS, HOLDS, NOT_RUN, Report

COLOURS = {HOLDS: "#00704a", FAILS: "#b3261e", BROKEN: "#8a5a00", NOT_RUN: "#8a5a00"}  # white on them has 4.5 : 1
ADVANCE, MARGIN = 6.0, 8.0  # [px] of a character of 11 px, on the average; beside the text


def badge(report: Report) -> str:
    """Return the badge of a run, as SVG."""
    overall, counts = verdicts.worn(report), verdicts.tally(report.claims)
    label = f"{report.subject.name if report.subject else 'softbody'} claims"
    selected = " selected" if report.patterns else ""
    text = f"{verdicts.SYMBOLS[overall]} {counts[HOLDS]} of {len(report.claims)}{selected} hold"
    text += "".join(f", {counts[name]} {word}" for name, word in ((FAILS, "fail"), (BROKEN, "broken")) if counts[name])
    widths = [round(len(part) * ADVANCE + 2.0 * MARGIN, 1) for part in (label, text)]
    return rendered("badge.svg.jinja", label=label, text=text, widths=widths, margin=MARGIN, colour=COLOURS[overall])
