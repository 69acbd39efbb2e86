"""What have the claims been seen to detect? Planted faults and mutants of a record, sorted for the page."""

from __future__ import annotations

from dataclasses import dataclass, field

from markupsafe import Markup, escape

from validation.record import PlantedFault, Report

CAUGHT = "caught"
PITCH, MARGIN = 3, 4  # of the matrix's dots, and around them


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
