"""Verdicts on claims in words: one verdict a claim, one sentence for all of them."""

from __future__ import annotations

import shlex

from validation.record import BROKEN, FAILS, HOLDS, KINDS, NOT_RUN, ClaimRecord, Report

SYMBOLS = {HOLDS: "✓", FAILS: "✗", BROKEN: "!", NOT_RUN: "–"}
CSS = {HOLDS: "holds", FAILS: "fails", BROKEN: "open", NOT_RUN: "open"}
COUNTED = "disagreements"  # the unit of claims that count wrong yes-or-no answers instead of measuring an error


def verdict(claim: ClaimRecord) -> str:
    """Return HOLDS, FAILS, BROKEN or NOT_RUN. What claims to hold without numbers that say so, fails."""
    if claim.verdict in (NOT_RUN, BROKEN):
        return claim.verdict
    return FAILS if claim.verdict != HOLDS or contradiction(claim) else HOLDS


def contradiction(claim: ClaimRecord) -> str | None:
    """Return why a claim recorded as holding cannot have held, or None if its numbers agree."""
    if claim.verdict != HOLDS:
        return None
    if claim.n == 0:
        return "recorded as holding, but nothing was compared"
    if claim.value is None or claim.tolerance is None:
        return "recorded as holding, but its error or its tolerance is not a number"
    if claim.value > claim.tolerance:
        return "recorded as holding, but its error exceeds its tolerance"
    return None


def why(claim: ClaimRecord) -> str | None:
    """Return why a claim fails or was not run; None for one that holds."""
    if verdict(claim) == HOLDS:
        return None
    return contradiction(claim) or claim.why or "the record does not say why"


def tally(claims: list[ClaimRecord]) -> dict[str, int]:
    """Return the number of claims that hold, fail, whose engine is broken, and that were not run."""
    found = [verdict(claim) for claim in claims]
    return {name: found.count(name) for name in SYMBOLS}


def kinds(claims: list[ClaimRecord]) -> list[tuple[str, str, int, int]]:
    """Return, for each kind of judge that there is, its name, what it is, its claims, and how many of them hold."""
    rows = []
    for kind, meaning in KINDS.items():
        those = [claim for claim in claims if claim.kind == kind]
        if those:
            rows.append((kind, meaning, len(those), tally(those)[HOLDS]))
    return rows


def sentence(claims: list[ClaimRecord]) -> str:
    """Return the verdict of the whole run. "Not run" is named, and is never part of an "all"."""
    n, counts = len(claims), tally(claims)
    claims_word = "claim" if n == 1 else "claims"
    if n == 0:
        return "Nothing was claimed, so nothing is shown"
    if counts[FAILS]:
        verb = "FAILS" if counts[FAILS] == 1 else "FAIL"
        return f"{counts[FAILS]} of {n} {claims_word} {verb}{_rest(counts)}"
    if counts[NOT_RUN] == n:
        return f"None of {n} {claims_word} was run"
    if counts[NOT_RUN] or counts[BROKEN]:
        return f"{counts[HOLDS]} hold{'s' if counts[HOLDS] == 1 else ''}{_rest(counts)}"
    return "The only claim holds" if n == 1 else f"All {n} claims hold"


def headline(report: Report) -> str:
    """Return the verdict of a run in words. A run of some claims says so first."""
    told = sentence(report.claims)
    if not report.patterns:
        return told
    known = f" of {report.registered}" if report.registered else ""
    which = f"-k {shlex.quote(report.patterns[0])}"
    which += f" and {len(report.patterns) - 1} more" if report.patterns[1:] else ""
    return f"{len(report.claims)}{known} selected ({which}): {told[0].lower()}{told[1:]}"


def worn(report: Report) -> str:
    """Return the verdict that a run wears: one of some claims is never HOLDS."""
    wears = overall(report.claims)
    return NOT_RUN if wears == HOLDS and report.patterns else wears


def _rest(counts: dict[str, int]) -> str:
    """Return what else there is besides claims that hold or fail, to be added to a sentence."""
    broken = f", {counts[BROKEN]} with a broken engine" if counts[BROKEN] else ""
    return broken + (f", {counts[NOT_RUN]} not run" if counts[NOT_RUN] else "")


def overall(claims: list[ClaimRecord]) -> str:
    """Return the verdict that the whole run wears: HOLDS only if every claim was run and holds."""
    counts = tally(claims)
    if counts[FAILS]:
        return FAILS
    return HOLDS if claims and counts[HOLDS] == len(claims) else NOT_RUN


def is_count(claim: ClaimRecord) -> bool:
    """Tell whether a claim counts cases instead of measuring an error against a tolerance above 0."""
    return claim.unit == COUNTED or claim.tolerance == 0.0


def wrong_cases(claim: ClaimRecord) -> int | None:
    """Return how many cases disagree, for a claim that counts; None if nobody knows."""
    if claim.unit == COUNTED:
        return None if claim.value is None else round(claim.value)
    return None if claim.errors is None or claim.value is None else claim.n - claim.errors.zeros
