"""Judge of a claim: runs its comparison, weighs the errors, and records the verdict."""

from __future__ import annotations

import importlib.util
import time
import traceback
from dataclasses import replace
from pathlib import Path

import numpy as np

from validation.check import DISAGREEMENTS, Check, Comparison, NotHereError, Run
from validation.engines import DECLARED
from validation.one_case import case_of
from validation.plain_text import plain
from validation.record import BROKEN, FAILS, HOLDS, NOT_RUN, ClaimRecord, Distribution, Erratum, Group
from validation.subject import subjects

BINS = 40  # of the histogram of a claim's errors
MOST_KINDS = 1_000  # of cases that a claim may name
MOST_NOTES = 100
MOST_WHOLE = 2**53  # up to which whole numbers are doubles
LEAST_SCALE, MOST_SCALE = 1e-18, 1e12  # what errors may be divided by: no answer is of another size


def judge(check: Check, run: Run) -> ClaimRecord:
    """Run one check; whatever goes wrong makes it fail, but for an engine that is missing or broken.

    That holds for what an engine raises to end the process, too: it ends the claim.
    """
    record, declared = blank_record(check, run.seed), replace(check)
    start = time.perf_counter()
    run.seed_engines()
    try:
        comparison = check.compare(run)
        if check != declared:
            raise RuntimeError("the claim has changed what it was declared as")
        weigh(declared, comparison, record)
    except BaseException as error:
        record.verdict, record.why = verdict_on(error, declared.engines)
    record.seconds = time.perf_counter() - start
    return record


def verdict_on(error: BaseException, engines: tuple[str, ...]) -> tuple[str, str]:
    """Return the verdict on a check that raised, and why: only an engine of its own excuses it.

    One that is not installed, that cannot be imported, or that raised: called by a reference or by the check itself,
    and not by way of the core; and that was not given numbers which are none.
    """
    if isinstance(error, NotHereError):
        return NOT_RUN, plain(error)
    where = traceback.extract_tb(error.__traceback__)
    name = plain(type(error).__name__)
    why = f"raised {name}: {plain(error)} (in {plain(where[-1].name)}, line {where[-1].lineno})"
    if isinstance(error, ModuleNotFoundError) and error.name in engines and not _folders(error.name):
        return NOT_RUN, f"{error.name} is not installed"
    core, judges = _folders("softbody"), [one.path for one in [*DECLARED, *subjects().values()]]
    theirs = judges + [folder for engine in engines for folder in _folders(engine)]
    through_core = any(_is_in(frame.filename, core) for frame in where)
    if given := _no_numbers(error, theirs):
        return FAILS, f"{', '.join(engines)} was given {given} that is not finite, and {why}"
    if engines and not through_core and (isinstance(error, ImportError) or _is_in(where[-1].filename, theirs)):
        return BROKEN, f"{', '.join(engines)} {why}"
    return FAILS, why


def _no_numbers(error: BaseException, files: list[Path]) -> str:
    """Return what is not finite of the arguments that functions in some files were called with, or ""."""
    for frame, _ in traceback.walk_tb(error.__traceback__):
        code = frame.f_code
        if _is_in(code.co_filename, files):
            for name in code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]:
                value = frame.f_locals.get(name)
                if isinstance(value, (float, np.ndarray)):
                    numbers = np.asarray(value)
                    if numbers.dtype.kind == "f" and not np.isfinite(numbers).all():
                        return plain(name)
    return ""


def _folders(package: str) -> list[Path]:
    """Return where a package lies, or the file of a module; nothing if it is not installed."""
    spec = importlib.util.find_spec(package)
    if spec is None:
        return []
    return [Path(place) for place in spec.submodule_search_locations or [spec.origin or ""]]


def _is_in(file: str, folders: list[Path]) -> bool:
    return any(Path(file).is_relative_to(folder) for folder in folders)


def blank_record(check: Check, seed: int) -> ClaimRecord:
    """Return the record of a check that has not been run."""
    misprint = check.erratum
    return ClaimRecord(
        id=plain(check.id),
        family=plain(check.family),
        claim=plain(check.claim),
        detail=plain(check.detail),
        room=plain(check.room),
        section=plain(check.section),
        piece=plain(check.piece),
        reference=plain(check.reference),
        engines=[plain(engine) for engine in check.engines],
        unit=plain(check.unit),
        value=None,
        tolerance=check.tolerance,
        because=plain(check.because),
        n=0,
        seed=seed,
        verdict=NOT_RUN,
        why=None,
        seconds=0.0,
        erratum=Erratum(plain(misprint.id), plain(misprint.prints), plain(misprint.right)) if misprint else None,
        kind=plain(check.kind),
        faults=[plain(fault.name) for fault in check.faults],
    )


def weigh(check: Check, comparison: Comparison, record: ClaimRecord) -> None:
    """Fill in value, distribution and verdict. Comparing nothing fails, and so does anything not finite."""
    counts = check.unit == DISAGREEMENTS
    errors = errors_of(comparison.measured, comparison.expected, comparison.scale, counts)
    record.n = different_cases(comparison, errors)
    record.notes = notes_of(comparison.notes)
    record.arbitrations = list(comparison.arbitrations)
    if record.n < check.least:
        few = f"compared {record.n} different cases, and is to compare {check.least} at least"
        record.verdict, record.why = FAILS, few if len(errors) else "compared nothing"
        return
    record.value = float(errors.sum() if counts else errors.max())
    record.errors = distribution(errors)
    record.groups = groups(errors, comparison.groups, counts)
    record.worst = case_of(comparison, errors, int(errors.argmax()))
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
    counts = check.unit == DISAGREEMENTS
    errors = errors_of(comparison.printed, comparison.expected, comparison.scale, counts)
    if not np.isfinite(errors).all():
        record.verdict, record.why = FAILS, "the printed form gives no number in some cases: choose others"
        return
    value = float(errors.sum() if counts else errors.max())
    record.erratum.printed_value = value
    record.erratum.printed_median = float(np.median(errors))
    record.erratum.printed_wrong = float((~(errors <= (0.0 if counts else check.tolerance))).mean())
    if record.verdict == HOLDS and value <= check.tolerance:
        record.verdict, record.why = FAILS, "the printed form is as good as the right one on these cases"


def different_cases(comparison: Comparison, errors: np.ndarray) -> int:
    """Return how many cases were compared: those with the same answers, inputs and kind are one.

    But for yes-or-no and whole numbers, which are often the same, and for two answers that are exactly 0.
    """
    measured, expected = np.asarray(comparison.measured), np.asarray(comparison.expected)
    if len(errors) == 0 or (measured.dtype.kind != "f" and expected.dtype.kind != "f"):
        return len(errors)
    inputs = [np.asarray(rows) for rows in comparison.inputs.values()]
    asked = [rows for rows in inputs if rows.dtype.kind in "biuf" and len(rows) == len(errors)]
    sides = [rows.reshape(len(errors), -1).astype(float) for rows in (measured, expected, *asked)]
    if comparison.groups is not None and len(comparison.groups) == len(errors):
        sides.append(np.unique(np.asarray(comparison.groups), return_inverse=True)[1][:, None].astype(float))
    is_zero = (measured == 0.0).reshape(len(errors), -1).all(axis=1) & (expected == 0.0).reshape(len(errors), -1).all(1)
    return int(is_zero.sum()) + len(np.unique(np.concatenate(sides, axis=1)[~is_zero], axis=0))


def errors_of(measured: object, expected: object, scale: object, counts: bool = False) -> np.ndarray:
    """Return the error (n,) of each case; where it `counts` disagreements, each is 0 or 1, or no number.

    Raises ValueError for answers that are no yes-or-no, double or exact whole numbers, in shapes (n,) or (n, k) that
    are the same on both sides; for sides that share memory, or that are no arrays and cannot be told from such; and for
    a scale that is not finite and above 0, or of a size that no answer has.
    """
    a, b = _answers(measured, "measured"), _answers(expected, "expected")
    if a.shape != b.shape:
        raise ValueError(f"measured has shape {a.shape} and expected {b.shape}: they must be the same")
    if measured is expected or np.shares_memory(a, b):
        raise ValueError("measured and expected share memory: what is compared with itself agrees")
    is_plain = type(measured) is np.ndarray and type(expected) is np.ndarray
    if not is_plain and a.dtype.kind == b.dtype.kind == "f" and np.array_equal(a, b) and (a != np.rint(a)).any():
        raise ValueError("measured and expected are the same to the last bit: give arrays, of which it can be seen why")
    if a.dtype == bool or b.dtype == bool:
        if a.dtype != b.dtype:
            raise ValueError(f"measured is {a.dtype} and expected {b.dtype}: compare yes-or-no with yes-or-no")
        wrong = a != b
        return (wrong if wrong.ndim == 1 else wrong.any(axis=1)).astype(float)
    if a.dtype != b.dtype and any(side.dtype.kind in "iu" and _largest(side) > MOST_WHOLE for side in (a, b)):
        raise ValueError("whole numbers beyond 2⁵³ are no doubles: compare them with whole numbers of their kind")
    unit = np.asarray(scale, float)
    if unit.shape not in ((), a.shape[:1]) or not ((unit > 0.0) & np.isfinite(unit)).all():
        raise ValueError(f"scale is {scale}: it must be a number, or ({len(a)},) of them, finite and above 0")
    if unit.size and not (LEAST_SCALE <= unit.min() <= unit.max() <= MOST_SCALE):
        raise ValueError(f"scale is from {unit.min():g} to {unit.max():g}: no answer is of that size")
    with np.errstate(all="ignore"):  # what is not finite fails the claim; it needs no warning
        difference = a.astype(float) - b.astype(float)
        difference[(difference == 0.0) & (a != b)] = 1.0  # of whole numbers that are one double
        if difference.ndim == 2:
            difference = np.linalg.norm(difference, axis=1)
        errors = np.abs(difference) / unit
    return np.where(np.isfinite(errors), np.sign(errors), errors) if counts else errors


def _answers(side: object, name: str) -> np.ndarray:
    """Return the answers of one side, as they are, if they can be compared; raises ValueError."""
    answers = np.asarray(side)
    if answers.dtype.kind not in "biuf" or (answers.dtype.kind == "f" and answers.dtype != np.float64):
        raise ValueError(f"{name} is {answers.dtype}: give yes-or-no, whole numbers or doubles")
    if answers.ndim not in (1, 2) or (answers.ndim == 2 and answers.shape[1] == 0):
        raise ValueError(f"{name} has shape {answers.shape}: give (n,), or (n, k) with k ≥ 1")
    return answers


def _largest(whole: np.ndarray) -> int:
    """Return the largest absolute value of whole numbers."""
    return max(abs(int(whole.min())), abs(int(whole.max()))) if whole.size else 0


def notes_of(notes: object) -> list[str]:
    """Return what a claim has noted as texts that can be shown; raises TypeError for what is no list."""
    if not isinstance(notes, (list, tuple)):
        raise TypeError(f"notes are {type(notes).__name__}: give a list of texts")
    kept = [plain(note) for note in notes[:MOST_NOTES]]
    return kept + [f"and {len(notes) - MOST_NOTES} notes more"] * (len(notes) > MOST_NOTES)


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
    kinds = dict.fromkeys(names.tolist())
    if len(kinds) > MOST_KINDS:
        raise ValueError(f"{len(kinds)} kinds of cases are named: name {MOST_KINDS} at most")
    for name in kinds:
        part = errors[names == name]
        worst = part.sum() if counts else part.max()
        rows.append(Group(plain(name), len(part), float(np.median(part)), float(np.quantile(part, 0.99)), float(worst)))
    return rows
