"""Faults that claims have been seen to detect: planted faults and mutants of a record, sorted for the page."""

from __future__ import annotations

from dataclasses import dataclass, field

from markupsafe import Markup, escape

from reports.overview import axis_of, ratios
from validation.order import faults_a_second
from validation.record import PlantedFault, Report

CAUGHT = "caught"
PITCH, MARGIN = 3, 4  # of the matrix's dots, and around them
WIDE, TALL, LABELS = 4, 200, 40  # of a tolerance among the others, of their axis, and of what is written beside it


@dataclass
class Caught:
    """The faults that claims of one family were to see."""

    family: str
    claims: int = 0  # of the family
    faults: list[PlantedFault] = field(default_factory=list)

    @property
    def caught(self) -> int:
        """How many of them every such claim saw."""
        return sum(fault.verdict == CAUGHT for fault in self.faults)


def by_family(report: Report) -> list[Caught]:
    """Return the faults by families of the claims that name them first, in the order of the claims."""
    found: dict[str, Caught] = {}
    family_of = {claim.id: claim.family for claim in report.claims}
    for claim in report.claims:
        found.setdefault(claim.family, Caught(claim.family)).claims += 1
    for fault in report.sensitivity.faults if report.sensitivity else []:
        families = [family_of[claim] for claim in fault.claims if claim in family_of]
        if families:
            found[families[0]].faults.append(fault)
    return list(found.values())


@dataclass(frozen=True)
class Room:
    """How far a tolerance is from what the sound core shows, and from the smallest error that a fault has shown."""

    claim: str
    seen: float  # largest error of the sound core, in tolerances
    fault: str  # the planted fault that is off by least
    off: float  # by so many tolerances: they may widen as much before it escapes


def rooms(report: Report) -> list[Room]:
    """Return the room of each tolerance that faults have been tried on, the one that may widen least first."""
    largest = {claim.id: errors[2] for claim in report.claims if (errors := ratios(claim)) is not None}
    found: dict[str, Room] = {}
    for fault in report.sensitivity.faults if report.sensitivity else []:
        for claim, off in fault.off.items():
            if claim in largest and not (claim in found and found[claim].off <= off):
                found[claim] = Room(claim, largest[claim], fault.name, off)
    return sorted(found.values(), key=lambda room: room.off)


def room_plot(report: Report) -> Markup | None:
    """Return a picture of all tolerances, side by side: below the line what the core shows, above it faults."""
    rows = rooms(report)
    if not rows:
        return None
    axis = axis_of([value for room in rows for value in (room.seen, room.off)])
    width, height = LABELS + 2 * MARGIN + WIDE * len(rows), TALL + 2 * MARGIN

    def level(ratio: float) -> float:
        return MARGIN + TALL * (1.0 - axis.at(ratio) / 100.0)

    parts = [f'<svg class="matrix" viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img"']
    parts.append(' aria-label="How far each tolerance is from what the core and what faults show">')
    for place, label in axis.ticks:
        y = MARGIN + TALL * (1.0 - place / 100.0)
        parts.append(f'<path class="rule" d="M{LABELS}{y:g}H{width - MARGIN}"/>')
        parts.append(f'<text x="{LABELS - 3}" y="{y + 3:g}" text-anchor="end">{escape(label)}</text>')
    parts.append(f'<path class="limit" d="M{LABELS} {level(1.0):g}H{width - MARGIN}"/>')
    for k, room in enumerate(rows):
        x = LABELS + MARGIN + WIDE * (k + 0.5)
        title = escape(f"{room.claim}: {room.seen:.2g} of the tolerance; {room.off:.3g} × it with “{room.fault}”")
        for kind, ratio in (("holds", room.seen), ("fails", room.off)):
            parts.append(
                f'<circle class="{kind}" cx="{x:g}" cy="{level(ratio):g}" r="1.7"><title>{title}</title></circle>'
            )
    return Markup("".join([*parts, "</svg>"]))


def soonest(report: Report) -> list[tuple[float, int]]:
    """Return after how many seconds of this run's claims how many of the caught faults have turned one red.

    The claims come in the order in which a run judges them that has this report in its folder.
    """
    seconds, seen, course = 0.0, set[int](), [(0.0, 0)]
    tried = [fault for fault in (report.sensitivity.faults if report.sensitivity else []) if fault.verdict == CAUGHT]
    judged = [claim for claim in report.claims if claim.value is not None]
    for claim in sorted(judged, key=lambda one: -faults_a_second(len(one.faults), one.seconds)):
        seconds += claim.seconds
        seen |= {k for k, fault in enumerate(tried) if claim.id in fault.claims}
        course.append((seconds, len(seen)))
    return course if seen else []


def seconds_for(course: list[tuple[float, int]], share: float) -> float:
    """Return after how many seconds a share of all that a course finds is found."""
    return next(seconds for seconds, found in course if found >= share * course[-1][1])


def matrix(report: Report) -> Markup | None:
    """Return faults × claims as a picture: a dot where a claim was to see a fault; None without faults."""
    rows = [fault for family in by_family(report) for fault in family.faults]
    if not rows:
        return None
    column = {claim.id: k for k, claim in enumerate(report.claims)}
    width, height = (2 * MARGIN + PITCH * n for n in (len(column), len(rows)))
    parts = [f'<svg class="matrix" viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img"']
    parts.append(' aria-label="Which claim was to see which planted fault">')
    place = 0
    for family in by_family(report):
        place += len(family.faults)
        parts.append(f'<path class="rule" d="M{MARGIN} {MARGIN + PITCH * place}H{width - MARGIN}"/>')
    for row, fault in enumerate(rows):
        for claim in fault.claims:
            if claim in column:
                x, y = (MARGIN + PITCH * (k + 0.5) for k in (column[claim], row))
                kind = "holds" if fault.verdict == CAUGHT else "fails"
                title = escape(f"{fault.name}: {fault.verdict} by {claim}")
                parts.append(f'<circle class="{kind}" cx="{x:g}" cy="{y:g}" r="1.4"><title>{title}</title></circle>')
    return Markup("".join([*parts, "</svg>"]))
