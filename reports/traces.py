"""Traces from a record: claims by the piece of the core that they judge, by section of the paper, and their judges."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from reports.rows import Row
from reports.sensitivity import CAUGHT
from reports.verdicts import verdict
from validation.record import FAILS, HOLDS, OUTSIDE, ClaimRecord, Report

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
    pieces, without = pieces_of([row.claim for row in rows])
    row_of = {id(row.claim): row for row in rows}
    named = {piece: [row_of[id(claim)] for claim in claims] for piece, claims in pieces.items()}
    alone = {piece: named[piece] for piece in without}
    seen = {
        (fault.name, claim): fault.verdict == CAUGHT
        for fault in (report.sensitivity.faults if report.sensitivity else [])
        for claim in fault.claims
    }
    found: dict[str, dict[str, Trace]] = {}
    for piece, those in named.items():
        for row in those:
            for section in parts_of(row.claim.section) or ["no section"]:
                trace = found.setdefault(section, {}).setdefault(piece, Trace(piece, piece in alone))
                trace.rows.append(row)
                kind = row.claim.kind or "not recorded"
                trace.kinds[kind] = trace.kinds.get(kind, 0) + 1
                for fault in row.claim.faults:
                    trace.faults[fault] = seen.get((fault, row.claim.id), trace.faults.get(fault))
    sections = {section: list(found[section].values()) for section in sorted(found, key=in_order)}
    return Traces(sections, named, alone)


def pieces_of(claims: list[ClaimRecord]) -> tuple[dict[str, list[ClaimRecord]], list[str]]:
    """Return the pieces of the core, by name, with the claims on each, and those without a judge from outside."""
    pieces: dict[str, list[ClaimRecord]] = {}
    for claim in claims:
        for piece in parts_of(claim.piece):
            pieces.setdefault(piece, []).append(claim)
    pieces = dict(sorted(pieces.items()))
    return pieces, [piece for piece, those in pieces.items() if not any(from_outside(claim) for claim in those)]


def parts_of(text: str) -> list[str]:
    """Return the sections, or the pieces, that a claim names; each once."""
    return [*dict.fromkeys(part.strip() for part in text.split(",", MOST_PARTS) if part.strip())]


def from_outside(claim: ClaimRecord) -> bool:
    """Tell whether a claim was judged, in this run, by who answers apart from the core; where nobody knows, it was."""
    return verdict(claim) in (HOLDS, FAILS) and (claim.kind in OUTSIDE or not claim.kind)


def in_order(section: str) -> tuple[bool, list[int], str]:
    """Return what sorts §2.3 before §10.4, and what is no number last."""
    numbers = [int(digits) for digits in re.findall(r"\d{1,9}", section)]
    return not section[:1].isdigit(), numbers, section
