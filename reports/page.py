"""The page: gathers it from a record and pours it into the template, as one self-contained text."""

from __future__ import annotations

import base64
import hashlib
import math
import re
import shlex
import statistics
import zlib
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup

from reports import ledger, motions, notation, overview, plots, sensitivity, traces, verdicts
from reports.goals import goals_of
from reports.reading import CannotRead
from reports.rows import Row, Worst, anchor, relation, worst_of
from reports.template import HERE, rendered
from reports.three_js import three_js
from validation.record import HOLDS, Arbitration, ClaimRecord, Erratum, OpenErratum, Picture, Report, Timing

ERRATA = CONFIRMED, NOT_CONFIRMED, UNMEASURED = "confirmed", "not confirmed", "not measured"  # what one may be
NEAREST = 3  # to failing, of the claims that are named first
LARGEST_IMAGE = 8 * 2**20  # bytes
IMAGES = {".png": b"\x89PNG", ".webp": b"RIFF"}  # how such files begin


@dataclass
class Dispute:
    """A question that several answered, with what each was wrong about."""

    row: Row  # of the claim that asked it
    arbitration: Arbitration
    examples: list[tuple[str, Worst]]  # who was wrong, and the worst case of it


@dataclass
class Film:
    """A scene as the page shows it: its images are in the page itself."""

    name: str
    caption: str
    animation: str
    still: str
    motion: motions.Motion | None


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
class Glance:
    """A run in one look."""

    nearest: list[tuple[Row, float]]  # claims that hold, with the largest error / tolerance
    kinds: list[tuple[str, str, int, int, float, float]]  # of judge; the last two: where its bar begins, and its width
    speed: Timing | None  # ours, in the middle of the first table
    beside: Timing | None  # the fastest peer there


@dataclass
class ErratumRow:
    """A formula as printed, beside the right one."""

    erratum: Erratum | OpenErratum
    row: Row | None  # of the claim that measures it, if this run has it
    right: float | None = None  # places on the axis, in percent
    printed: overview.Strip | None = None

    @property
    def status(self) -> str:
        """CONFIRMED if the printed form is wrong in some case of the claim."""
        wrong = self.erratum.printed_wrong if isinstance(self.erratum, Erratum) else None
        return UNMEASURED if wrong is None else CONFIRMED if wrong > 0.0 else NOT_CONFIRMED


def page(report: Report, folder: Path | None = None) -> str:
    """Return the whole page; the same record, and pictures in `folder`, give the same text."""
    ratios = [overview.ratios(claim) for claim in report.claims]
    axis = overview.axis_of(value for three in ratios if three for value in three)
    rows = [row_of(report, claim, number, axis) for number, claim in enumerate(report.claims, 1)]
    errata_axis, errata = errata_of(rows, report.open_errata)
    films = films_of(report, folder)
    three = three_js() if any(film.motion for film in films) else None
    scripts = [(HERE / name).read_text(encoding="utf-8") for name in (["player.js"] if three else []) + ["page.js"]]
    return rendered(
        "page.html.jinja",
        report=report,
        rows=rows,
        claims=families_of(rows),
        axis=axis,
        errata=errata,
        errata_axis=errata_axis,
        errata_tally={status: n for status in ERRATA if (n := sum(line.status == status for line in errata))},
        traces=None if report.subject else traces.traces_of(report, rows),
        verdicts=verdicts,
        contents=contents_of(report),
        glance=glance_at(report, rows),
        sentence=verdicts.headline(report),
        subject=subject_of(report),
        settings=ledger.settings_of(report),
        answerers=ledger.answerers_of(report),
        disputes=disputes_of(rows),
        overall=verdicts.worn(report),
        tally=verdicts.tally(report.claims),
        kinds=verdicts.kinds(report.claims),
        planted=sensitivity.by_family(report),
        matrix=sensitivity.matrix(report),
        rooms=sensitivity.rooms(report),
        room_plot=sensitivity.room_plot(report),
        course=(course := sensitivity.soonest(report)),
        course_plot=Markup(plot) if (plot := plots.course_plot(course)) else None,
        seconds_for=sensitivity.seconds_for,
        command=command_of(report),
        tables=tables_of(report.timings),
        goals=goals_of(report),
        has_trends=any(timing.trend for timing in report.timings),
        pictures=films,
        three=base64.b64encode(zlib.compress(three.encode(), 9)).decode() if three else None,
        scripts=[Markup(script) for script in scripts],
        hashes=[hash_of(script) for script in [*scripts, three] if script],
    )


def hash_of(script: str) -> str:
    """Return by what the page's policy knows a script; no other runs there."""
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()


def contents_of(report: Report) -> list[tuple[str, str]]:
    """Return the anchor and the title of each part that the page has."""
    parts = [
        ("claims", "The claims", True),
        ("sensitivity", "What they detect", report.sensitivity is not None),
        (
            "traces",
            "What is judged",
            report.subject is None and any(claim.piece.strip(" ,") for claim in report.claims),
        ),
        ("errata", "Errata", report.subject is None or any(claim.erratum for claim in report.claims)),
        ("rules", "The paper’s rules", bool(report.behaviours)),
        ("timings", "What it costs", report.subject is None or bool(report.timings)),
        ("right", "Who was right", any(claim.arbitrations for claim in report.claims)),
        ("engines", "Fair play", bool(report.settings)),
        ("reading", "How to read this page", True),
        ("environment", "Where it ran", True),
        ("reproduce", "To reproduce", True),
    ]
    return [(anchor, title) for anchor, title, is_there in parts if is_there]


def glance_at(report: Report, rows: list[Row]) -> Glance:
    """Return what is told of a run in one look."""
    near = [(row, row.ratio) for row in rows if row.ratio is not None and row.verdict == HOLDS]
    near.sort(key=lambda pair: -pair[1])
    kinds, left = [], 0.0
    for kind, meaning, count, good in verdicts.kinds(report.claims):
        width = round(100.0 * count / len(rows), 2)
        kinds.append((kind, meaning, count, good, round(left, 2), width))
        left += width
    first = [timing for timing in report.timings if timing.table == report.timings[0].table]
    ours = [timing for timing in first if timing.name == first[0].name]
    speed = ours[len(ours) // 2] if ours else None
    peers = [t for t in first if speed and t.size == speed.size and t.ratio and not t.own]
    return Glance(near[:NEAREST], kinds, speed, min(peers, key=lambda t: t.ratio or 0.0, default=None))


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
        ratio=ratios[2] if ratios else None,
        plot=Markup(plot) if plot else None,
        not_finite=claim.n - errors.zeros - sum(errors.counts) if errors else 0,
        command=f"python -m validation replay {shlex.quote(claim.id)} --seed {claim.seed} "
        f"--level {shlex.quote(report.level)}",
        worst=worst_of(claim.worst) if claim.worst else None,
    )


def command_of(report: Report) -> str:
    """Return the command that makes the report again."""
    subject = f" --subject {shlex.quote(report.subject.name)}" if report.subject else ""
    patterns = subject + "".join(f" -k {shlex.quote(pattern)}" for pattern in report.patterns)
    draws = f" --draws {report.draws}" if report.draws > 1 else ""
    return f"python -m validation{patterns} --seed {report.seed} --level {shlex.quote(report.level)}{draws}"


def subject_of(report: Report) -> str:
    """Return name and version of who was judged; nothing if it is the core."""
    return " ".join(filter(None, (report.subject.name, report.subject.version))) if report.subject else ""


def disputes_of(rows: list[Row]) -> list[Dispute]:
    """Return all questions that several answered, those that most were wrong about first."""
    found = [
        Dispute(row, one, [(who.who, worst_of(who.case)) for who in one.standings if who.case])
        for row in rows
        for one in row.claim.arbitrations
    ]
    return sorted(found, key=lambda dispute: -sum(who.wrong for who in dispute.arbitration.standings))


def families_of(rows: list[Row]) -> dict[str, dict[str, list[Row]]]:
    """Return the claims by room and family, in the record's order."""
    rooms: dict[str, dict[str, list[Row]]] = {}
    for row in rows:
        rooms.setdefault(row.claim.room, {}).setdefault(row.claim.family, []).append(row)
    return rooms


def films_of(report: Report, folder: Path | None) -> list[Film]:
    """Return the films with the files themselves in place of their names; those that are not there are left out.

    Raises CannotRead for a file that lies elsewhere, is too large, or is no image.
    """
    if folder is None:
        return []
    found = []
    for number, picture in enumerate(report.pictures):
        files = [folder / name for name in (picture.animation, picture.still)]
        if all(file.is_file() for file in files):
            animation, still = (data_address(file, folder, f"pictures[{number}]") for file in files)
            found.append(Film(picture.name, picture.caption, animation, still, motion_of(picture, folder, number)))
    return found


def motion_of(picture: Picture, folder: Path, number: int) -> motions.Motion | None:
    """Return what moved in a scene, if that was kept."""
    file = folder / picture.motion if picture.motion else None
    return motions.read_motion(file, folder, f"pictures[{number}]") if file and file.is_file() else None


def data_address(file: Path, folder: Path, entry: str) -> str:
    """Return an image as an address that asks no network; raises CannotRead, naming the entry of the record."""
    if not file.resolve().is_relative_to(folder.resolve()):
        raise CannotRead(f"{entry}: {file} leads out of the report's folder; a page shows what lies inside")
    if file.stat().st_size > LARGEST_IMAGE:
        raise CannotRead(f"{entry}: {file} has more than {LARGEST_IMAGE} bytes; make a smaller one")
    data = file.read_bytes()
    if not data.startswith(IMAGES[file.suffix]):
        raise CannotRead(f"{entry}: {file} is no image of its kind; film it again")
    return f"data:image/{file.suffix[1:]};base64,{base64.b64encode(data).decode()}"


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


def errata_of(rows: list[Row], unmeasured: list[OpenErratum]) -> tuple[overview.Axis, list[ErratumRow]]:
    """Return all errata, E2 before E10, with the places of both forms on an axis of their own."""
    found, forms = [], []
    for row in rows:
        claim, erratum = row.claim, row.claim.erratum
        if erratum is None:
            continue
        known = [v for v in (claim.value, erratum.printed_median, erratum.printed_value) if v is not None]
        comparable = claim.tolerance and not row.is_count and len(known) == 3
        found.append(ErratumRow(erratum, row))
        forms.append([value / claim.tolerance for value in known] if comparable else None)
    axis = overview.axis_of(ratio for form in forms if form for ratio in form)
    for line, form in zip(found, forms):
        if form:
            line.right, line.printed = axis.at(form[0]), overview.strip(axis, form[1], form[1], form[2])
    found += [ErratumRow(erratum, None) for erratum in unmeasured]
    return axis, sorted(found, key=_id_of_erratum)


def _id_of_erratum(line: ErratumRow) -> tuple[int, str, str]:
    digits = re.search(r"\d{1,9}", line.erratum.id)
    return (int(digits[0]) if digits else 10**9, line.erratum.id, line.row.claim.id if line.row else "")
