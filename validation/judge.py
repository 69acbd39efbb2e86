"""Does a claim hold? Run its comparison, weigh the errors, and say so in a record."""

from __future__ import annotations

import time
import traceback

import numpy as np

from validation.check import DISAGREEMENTS, Check, Comparison, Run
from validation.record import FAILS, HOLDS, NOT_RUN, ClaimRecord, Distribution, Erratum, Group

BINS = 40  # of the histogram of a claim's errors


def judge(check: Check, run: Run) -> ClaimRecord:
    """Run one check. A missing engine makes it "not run"; anything else that goes wrong makes it fail."""
    record = blank_record(check, run.seed)
    start = time.perf_counter()
    try:
        weigh(check, check.compare(run), record)
    except Exception as error:
        record.verdict, record.why = verdict_on(error, check.engines)
    record.seconds = time.perf_counter() - start
    return record


def verdict_on(error: Exception, engines: tuple[str, ...]) -> tuple[str, str]:
    """Return the verdict on a check that raised, and why: only a missing engine of its own excuses it."""
    if isinstance(error, ModuleNotFoundError) and error.name and error.name.split(".")[0] in engines:
        return NOT_RUN, f"{error.name} is not installed"
    where = traceback.extract_tb(error.__traceback__)[-1]
    return FAILS, f"raised {type(error).__name__}: {error} (in {where.name}, line {where.lineno})"


def blank_record(check: Check, seed: int) -> ClaimRecord:
    """Return the record of a check that has not been run."""
    misprint = check.erratum
    return ClaimRecord(
        id=check.id,
        family=check.family,
        claim=check.claim,
        section=check.section,
        piece=check.piece,
        reference=check.reference,
        engines=list(check.engines),
        unit=check.unit,
        value=None,
        tolerance=check.tolerance,
        because=check.because,
        detects=check.detects,
        n=0,
        seed=seed,
        verdict=NOT_RUN,
        why=None,
        seconds=0.0,
        erratum=None if misprint is None else Erratum(misprint.id, misprint.prints, misprint.right),
    )


def weigh(check: Check, comparison: Comparison, record: ClaimRecord) -> None:
    """Fill in value, distribution and verdict. Comparing nothing fails, and so does anything not finite."""
    errors = errors_of(comparison.measured, comparison.expected, comparison.scale)
    record.n = len(errors)
    record.notes = comparison.notes
    if len(errors) == 0:
        record.verdict, record.why = FAILS, "compared nothing"
        return
    counts = check.unit == DISAGREEMENTS
    record.value = float(errors.sum() if counts else errors.max())
    record.errors = distribution(errors)
    record.groups = groups(errors, comparison.groups, counts)
    if not np.isfinite(errors).all():
        record.verdict = FAILS
        record.why = f"{int((~np.isfinite(errors)).sum())} of {len(errors)} comparisons are not finite"
    elif record.value > check.tolerance:
        wrong = int((errors > (0.0 if counts else check.tolerance)).sum())
        record.verdict = FAILS
        record.why = f"{wrong} of {len(errors)} cases exceed the tolerance; the worst is case {int(errors.argmax())}"
    else:
        record.verdict = HOLDS
    if record.erratum is not None:
        weigh_printed(check, comparison, record)


def weigh_printed(check: Check, comparison: Comparison, record: ClaimRecord) -> None:
    """Measure the paper's printed form on the same cases. An erratum holds only if that form is really wrong."""
    assert record.erratum is not None
    errors = errors_of(comparison.printed, comparison.expected, comparison.scale)
    counts = check.unit == DISAGREEMENTS
    value = float(errors.sum() if counts else errors.max())
    record.erratum.printed_value = value
    record.erratum.printed_median = float(np.median(errors))
    record.erratum.printed_wrong = float((~(errors <= (0.0 if counts else check.tolerance))).mean())
    if record.verdict == HOLDS and value <= check.tolerance:
        record.verdict, record.why = FAILS, "the printed form is as good as the right one on these cases"


def errors_of(measured: object, expected: object, scale: object) -> np.ndarray:
    """Return the error (n,) of each case; raises ValueError if there are not as many answers on both sides."""
    a, b = np.asarray(measured), np.asarray(expected)
    if a.shape != b.shape:
        raise ValueError(f"measured has shape {a.shape} and expected {b.shape}: they must be the same")
    if a.dtype == bool or b.dtype == bool:
        if a.dtype != b.dtype:
            raise ValueError(f"measured is {a.dtype} and expected {b.dtype}: compare yes-or-no with yes-or-no")
        return (a != b).astype(float)
    with np.errstate(all="ignore"):  # what is not finite fails the claim; it needs no warning
        difference = a.astype(float) - b.astype(float)
        if difference.ndim == 2:
            difference = np.linalg.norm(difference, axis=1)
        return np.abs(difference) / np.asarray(scale, float)


def distribution(errors: np.ndarray) -> Distribution:
    """Return quantiles and a histogram, over the logarithm, of the finite errors."""
    finite = errors[np.isfinite(errors)]
    if len(finite) == 0:
        return Distribution({}, 0, [], [])
    positive = finite[finite > 0.0]
    quantiles = {q: float(np.quantile(finite, float(q))) for q in ("0", "0.5", "0.9", "0.99", "1")}
    if len(positive) == 0:
        return Distribution(quantiles, len(finite), [], [])
    logs = np.log10(positive)
    low, high = float(logs.min()), float(logs.max())
    edges = np.linspace(low - 0.05, high + 0.05, BINS + 1)
    counts, _ = np.histogram(logs, edges)
    return Distribution(quantiles, len(finite) - len(positive), edges.tolist(), counts.tolist())


def groups(errors: np.ndarray, labels: object, counts: bool) -> list[Group]:
    """Return the errors by kind of case; of yes-or-no answers, `max` is the number of disagreements."""
    if labels is None:
        return []
    names = np.asarray(labels)
    if len(names) != len(errors):
        raise ValueError(f"{len(names)} group names for {len(errors)} cases")
    rows = []
    for name in dict.fromkeys(names.tolist()):
        part = errors[names == name]
        worst = part.sum() if counts else part.max()
        rows.append(Group(str(name), len(part), float(np.median(part)), float(np.quantile(part, 0.99)), float(worst)))
    return rows
