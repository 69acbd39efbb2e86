"""A claim of a record as the page shows it: its row, with its worst case."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from markupsafe import Markup

from reports import notation, overview
from validation.record import Case, ClaimRecord

MOST_ANSWERS = 12  # numbers of an answer that are shown


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
    ratio: float | None  # largest error / tolerance
    plot: Markup | None
    not_finite: int  # errors that no plot can show
    command: str
    worst: Worst | None


@dataclass
class Worst:
    """The worst case of a claim as the page shows it."""

    case: Case
    inputs: list[tuple[str, str]]  # names and values
    answers: list[tuple[str, str, str]]  # place in the answer, measured, expected; the places that differ most
    more: int  # numbers of the answers that are not shown


def worst_of(case: Case) -> Worst:
    """Return a case as the page shows it: of long answers the numbers that differ most."""
    pairs = list(zip(case.measured, case.expected))
    gaps = [_gap(*pair) for pair in pairs]
    kept = sorted(sorted(range(len(pairs)), key=lambda k: -gaps[k])[:MOST_ANSWERS])
    return Worst(
        case,
        [(name, digits(value)) for name, value in case.inputs.items()],
        [(str(k) if len(pairs) > 1 else "", digits(pairs[k][0]), digits(pairs[k][1])) for k in kept],
        max(case.length, len(pairs)) - len(kept),
    )


def _gap(a: object, b: object) -> float:
    if isinstance(a, (int, float)) and isinstance(b, (int, float)):
        return abs(float(a) - float(b))
    return math.inf  # one of them is no number


def digits(value: object) -> str:
    """Return a number of a record with all its digits, for it is to be compared bit by bit; lists in brackets."""
    if isinstance(value, list):
        return ", ".join(f"({digits(one)})" if isinstance(one, list) else digits(one) for one in value)
    if value is None or isinstance(value, bool):
        return notation.NOT_A_NUMBER if value is None else "yes" if value else "no"
    return repr(value) if isinstance(value, float) else str(value)


def anchor(name: str) -> str:
    """Return an id for the page's own links."""
    return "claim-" + re.sub(r"[^\w.-]+", "-", name)


def relation(claim: ClaimRecord) -> str:
    """Return the sign between a claim's value and its tolerance."""
    if claim.value is None or claim.tolerance is None:
        return "≰" if claim.n else ", "
    return "≤" if claim.value <= claim.tolerance else ">"
