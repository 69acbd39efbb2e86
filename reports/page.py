"""What stands on the page? Gathers it from a record and pours it into the template, as one self-contained text."""

from __future__ import annotations

import base64
import hashlib
import math
import re
import shlex
import statistics
from dataclasses import dataclass, replace
from pathlib import Path

from markupsafe import Markup

from reports import notation, overview, plots, verdicts
from reports.template import HERE, rendered
from validation.record import ClaimRecord, Picture, Report, Timing


@dataclass
class Row:
    """A claim as the page shows it."""

    claim: ClaimRecord
    anchor: str
    verdict: str
    why: str | None
    is_count: bool
    wrong: int | None  # cases that disagree, of a claim that counts
    value: str
    tolerance: str
    relation: str  # between the two
    strip: overview.Strip | None
    plot: Markup | None
    not_finite: int  # errors that no plot can show
    command: str


@dataclass
class Table:
    """A table of timings and its plot."""

    title: str
    rows: list[Timing]
    plot: Markup | None
    series: list[tuple[str, str, str]]  # name, colour and marker of each competitor
    growth: float | None  # exponent with which our whole cost grows with the size
    of_motion: bool  # times are per second of motion, so that they have a real-time factor
    cheapest: list[tuple[float, Timing]]  # for each error that was asked for, where errors were measured
    trends: list[Timing]  # those of the rows that have one


@dataclass
class ErratumRow:
    """A formula as printed, beside the right one."""

    row: Row
    right: float | None  # places on the axis, in percent
    printed: overview.Strip | None


def page(report: Report, folder: Path | None = None) -> str:
    """Return the whole page; the same record, and pictures in `folder`, give the same text."""
    ratios = [overview.ratios(claim) for claim in report.claims]
    axis = overview.axis_of(value for three in ratios if three for value in three)
    rows = [row_of(report, claim, number, axis) for number, claim in enumerate(report.claims, 1)]
    errata_axis, errata = errata_of(rows)
    script = (HERE / "page.js").read_text(encoding="utf-8")
    return rendered(
        "page.html.jinja",
        report=report,
        rows=rows,
        families=families_of(rows),
        axis=axis,
        errata=errata,
        errata_axis=errata_axis,
        verdicts=verdicts,
        sentence=verdicts.sentence(report.claims),
        overall=verdicts.overall(report.claims),
        tally=verdicts.tally(report.claims),
        kinds=verdicts.kinds(report.claims),
        command=f"python -m validation --seed {report.seed} --level {shlex.quote(report.level)}",
        tables=tables_of(report.timings),
        has_trends=any(timing.trend for timing in report.timings),
        pictures=pictures_of(report, folder),
        script=Markup(script),
        script_hash=base64.b64encode(hashlib.sha256(script.encode()).digest()).decode(),
    )


def row_of(report: Report, claim: ClaimRecord, number: int, axis: overview.Axis) -> Row:
    """Return a claim as the page shows it; `number` keeps apart claims whose ids differ in odd characters only."""
    verdict = verdicts.verdict(claim)
    ratios = overview.ratios(claim)
    plot = None if claim.unit == verdicts.COUNTED else plots.error_plot(claim, f"{number} {claim.id}")
    errors = claim.errors
    return Row(
        claim=claim,
        anchor=anchor(claim.id) if re.fullmatch(r"[\w.-]+", claim.id) else f"{anchor(claim.id)}-{number}",
        verdict=verdict,
        why=verdicts.why(claim),
        is_count=verdicts.is_count(claim),
        wrong=verdicts.wrong_cases(claim),
        value=notation.DASH if claim.n == 0 else notation.number_beside(claim.value, claim.tolerance),
        tolerance=notation.number(claim.tolerance),
        relation=relation(claim),
        strip=overview.strip(axis, *ratios) if ratios else None,
        plot=Markup(plot) if plot else None,
        not_finite=claim.n - errors.zeros - sum(errors.counts) if errors else 0,
        command=f"python -m validation -k {shlex.quote(claim.id)} --seed {claim.seed} "
        f"--level {shlex.quote(report.level)}",
    )


def anchor(name: str) -> str:
    """Return an id for the page's own links."""
    return "claim-" + re.sub(r"[^\w.-]+", "-", name)


def relation(claim: ClaimRecord) -> str:
    """Return the sign between a claim's value and its tolerance."""
    if claim.value is None or claim.tolerance is None:
        return "≰" if claim.n else ", "
    return "≤" if claim.value <= claim.tolerance else ">"


def families_of(rows: list[Row]) -> dict[str, list[Row]]:
    """Return the claims by family, in the record's order."""
    families: dict[str, list[Row]] = {}
    for row in rows:
        families.setdefault(row.claim.family, []).append(row)
    return families


def pictures_of(report: Report, folder: Path | None) -> list[Picture]:
    """Return the pictures with the files themselves in place of their names; those that are not there are left out."""
    if folder is None:
        return []
    found = []
    for picture in report.pictures:
        files = [folder / name for name in (picture.animation, picture.still)]
        if all(file.is_file() for file in files):
            animation, still = (data_address(file) for file in files)
            found.append(replace(picture, animation=animation, still=still))
    return found


def data_address(file: Path) -> str:
    """Return a file's contents as an address that asks no network."""
    return f"data:image/{file.suffix[1:]};base64,{base64.b64encode(file.read_bytes()).decode()}"


def tables_of(timings: list[Timing]) -> list[Table]:
    """Return the timings table by table, in the record's order, each with its plot."""
    tables = []
    for title in dict.fromkeys(timing.table for timing in timings):
        rows = [timing for timing in timings if timing.table == title]
        of_motion = rows[0].per == "simulated second"
        plot = plots.work_plot(rows) or (None if of_motion else plots.timing_plot(rows))
        series = [(name, plots.VARIABLES[c], plots.MARKERS[m]) for name, (c, m) in plots.series(rows).items()]
        drawn = Markup(plot) if plot else None
        trends = [timing for timing in rows if timing.trend]
        tables.append(Table(title, rows, drawn, series, growth_of(rows), of_motion, cheapest_of(rows), trends))
    return tables


def cheapest_of(rows: list[Timing]) -> list[tuple[float, Timing]]:
    """Return the cheapest row that errs by no more than each of some powers of ten, as far as there is one."""
    found = []
    for power in range(-1, -9, -1):
        near = [row for row in plots.drawable(rows) if row.error is not None and row.error <= 10.0**power]
        if near:
            found.append((10.0**power, min(near, key=lambda row: row.nanoseconds)))
    return found


def growth_of(rows: list[Timing]) -> float | None:
    """Return g of cost ~ size^g, of all that our rows cost in all, by least squares; None for fewer than three sizes.

    Sizes below a thousandth of the largest are left out: what is the same at every size counts there.
    """
    ours = [t for t in plots.drawable(rows) if t.name == rows[0].name and t.error is None]
    ours = [t for t in ours if t.size >= max(t.size for t in ours) / 1_000]
    if len(ours) < 3:
        return None
    x = [math.log(t.size) for t in ours]
    y = [math.log(t.size * t.nanoseconds) for t in ours]
    return statistics.linear_regression(x, y).slope


def errata_of(rows: list[Row]) -> tuple[overview.Axis, list[ErratumRow]]:
    """Return the errata, E2 before E10, with the places of both forms on an axis of their own."""
    found = [row for row in rows if row.claim.erratum is not None]
    found.sort(key=lambda row: _id_of_erratum(row.claim))
    forms = []
    for row in found:
        claim, erratum = row.claim, row.claim.erratum
        measured = (claim.value, erratum.printed_median, erratum.printed_value) if erratum else ()
        known = [value for value in measured if value is not None]
        comparable = claim.tolerance and not row.is_count and len(known) == 3
        forms.append([value / claim.tolerance for value in known] if comparable else None)
    axis = overview.axis_of(ratio for form in forms if form for ratio in form)
    return axis, [
        ErratumRow(row, axis.at(form[0]), overview.strip(axis, form[1], form[1], form[2]))
        if form
        else ErratumRow(row, None, None)
        for row, form in zip(found, forms)
    ]


def _id_of_erratum(claim: ClaimRecord) -> tuple[int, str, str]:
    name = claim.erratum.id if claim.erratum else ""
    digits = re.search(r"\d+", name)
    return (int(digits[0]) if digits else 10**9, name, claim.id)
