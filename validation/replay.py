"""Replay of one case of a claim: shows what was asked and what both sides answered."""

from __future__ import annotations

import sys
import traceback
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from validation.check import DISAGREEMENTS, Check, Run
from validation.judge import errors_of, verdict_on
from validation.one_case import case_of
from validation.plain_text import plain
from validation.record import FAILS, HOLDS, Case
from validation.terminal import wide_enough

SHOWN = 24  # numbers of an answer: those that differ most


def replay_case(check: Check, run: Run, number: int | None) -> str:
    """Run a check, print one case of it, the worst if no number is given, and return the case's verdict.

    Raises IndexError for a number that no case has.
    """
    console = wide_enough()
    if check.hindrance:
        verdict, why = check.hindrance
        console.print(f"{check.id}: {verdict}, {why}", markup=False)
        return verdict
    try:
        with Console(stderr=True).status(f"running {check.id}, level {run.level}, seed {run.seed}"):
            run.seed_engines()
            comparison = check.compare(run)
            errors = errors_of(comparison.measured, comparison.expected, comparison.scale)
            if not len(errors):
                raise ValueError("compared nothing")
            worst = int(errors.argmax())
            case = case_of(comparison, errors, worst if number is None or number >= len(errors) else number)
    except Exception as error:
        verdict, why = verdict_on(error, check.engines)
        traceback.print_exception(error, file=sys.stderr)
        console.print(f"{check.id}: {verdict}, {why}", markup=False, soft_wrap=True)
        return verdict
    if number is not None and number >= len(errors):
        raise IndexError(f"{check.id} has cases 0 to {len(errors) - 1} at level {run.level}: there is no case {number}")
    tolerance = 0.0 if check.unit == DISAGREEMENTS else check.tolerance
    verdict = HOLDS if errors[case.number] <= tolerance else FAILS
    which = "the worst" if case.number == worst else f"the worst is case {worst}"
    console.print(f"{check.id}, case {case.number} of {len(errors)} ({which})", style="bold", markup=False)
    console.print(check.claim, markup=False)
    printed = None if comparison.printed is None else np.atleast_1d(np.asarray(comparison.printed)[case.number])
    console.print(answers(case, printed))
    unit = "yes or no" if check.unit == DISAGREEMENTS else check.unit
    console.print(
        f"error {errors[case.number]:.17g}, scale {case.scale:.17g}, tolerance {tolerance:g} ({unit}): {verdict}",
        style="green" if verdict == HOLDS else "bold red",
        markup=False,
        highlight=False,
    )
    return verdict


def answers(case: Case, printed: np.ndarray | None) -> Table:
    """Return a case as a table: kind and inputs, then both answers number by number, and the paper's if there is."""
    table = Table(show_header=True, header_style="bold")
    for heading in ("", "measured", "expected", "difference", *(["as printed"] if printed is not None else [])):
        table.add_column(heading, overflow="fold")
    if case.group is not None:
        table.add_row("kind of case", case.group)
    for name, value in case.inputs.items():
        table.add_row(plain(name), shown(value))
    table.add_section()
    pairs = list(zip(case.measured, case.expected))
    gaps = np.array([abs(float(a) - float(b)) for a, b in pairs])
    kept = np.sort(np.argsort(-np.nan_to_num(gaps, nan=np.inf), kind="stable")[:SHOWN])
    for k in kept.tolist():
        name = "answer" if case.length == 1 else f"answer [{k}]"
        row = [name, shown(pairs[k][0]), shown(pairs[k][1]), f"{gaps[k]:.3g}"]
        table.add_row(*row, *([shown(printed.ravel()[k].item())] if printed is not None else []))
    if len(kept) < case.length:
        table.add_row("", f"… {case.length - len(kept)} numbers more")
    return table


def shown(value: Any) -> str:
    """Return a number with all its digits, or numbers row by row."""
    if isinstance(value, list):
        return ", ".join(f"({shown(one)})" if isinstance(one, list) else shown(one) for one in value)
    return f"{value:.17g}" if isinstance(value, float) else plain(value)
