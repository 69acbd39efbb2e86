"""Which claims judge which piece of the core, by which section of the paper, and who judges? Gathered from a record."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from reports.sensitivity import CAUGHT
from validation.record import FAILS, HOLDS, OUTSIDE, Report

if TYPE_CHECKING:
    from reports.page import Row

MOST_PARTS = 20  # sections, and pieces, of one claim: what comes after is one more


@dataclass
class Trace:
    """The claims of one section of the paper that judge one piece of the core."""

    piece: str
    alone: bool  # nobody from outside has judged it, in any section
    rows: list[Row] = field(default_factory=list)
    kinds: dict[str, int] = field(default_factory=dict)  # of judge, with the number of claims
    faults: dict[str, bool | None] = field(default_factory=dict)  # planted: were they caught? None: not tried

    @property
    def caught(self) -> int:
        """How many faults were."""
        return sum(caught is True for caught in self.faults.values())

    @property
    def was_tried(self) -> bool:
        """Whether any fault was."""
        return any(caught is not None for caught in self.faults.values())


@dataclass
class Traces:
    """Paper × pieces × claims × judges × planted faults."""

    sections: dict[str, list[Trace]]
    pieces: dict[str, list[Row]]  # all, with the claims that name them
    alone: dict[str, list[Row]]  # of these, those that nobody from outside has judged


def traces_of(report: Report, rows: list[Row]) -> Traces:
    """Return the sections of the paper in its order, and in each the pieces by name."""
    pieces: dict[str, list[Row]] = {}
    for row in rows:
        for piece in parts_of(row.claim.piece):
            pieces.setdefault(piece, []).append(row)
    pieces = dict(sorted(pieces.items()))
    alone = {piece: those for piece, those in pieces.items() if not any(from_outside(row) for row in those)}

    seen = {
        (fault.name, claim): fault.verdict == CAUGHT
        for fault in (report.sensitivity.faults if report.sensitivity else [])
        for claim in fault.claims
    }
    found: dict[str, dict[str, Trace]] = {}
    for piece, those in pieces.items():
        for row in those:
            for section in parts_of(row.claim.section) or ["no section"]:
                trace = found.setdefault(section, {}).setdefault(piece, Trace(piece, piece in alone))
                trace.rows.append(row)
                kind = row.claim.kind or "not recorded"
                trace.kinds[kind] = trace.kinds.get(kind, 0) + 1
                for fault in row.claim.faults:
                    trace.faults[fault] = seen.get((fault, row.claim.id), trace.faults.get(fault))
    sections = {section: list(found[section].values()) for section in sorted(found, key=in_order)}
    return Traces(sections, pieces, alone)


def parts_of(text: str) -> list[str]:
    """Return the sections, or the pieces, that a claim names; each once."""
    return [*dict.fromkeys(part.strip() for part in text.split(",", MOST_PARTS) if part.strip())]


def from_outside(row: Row) -> bool:
    """Tell whether a claim was judged, in this run, by who answers apart from the core; where nobody knows, it was."""
    return row.verdict in (HOLDS, FAILS) and (row.claim.kind in OUTSIDE or not row.claim.kind)


def in_order(section: str) -> tuple[bool, list[int], str]:
    """Return what sorts §2.3 before §10.4, and what is no number last."""
    numbers = [int(digits) for digits in re.findall(r"\d{1,9}", section)]
    return not section[:1].isdigit(), numbers, section
