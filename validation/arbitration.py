"""Arbitration where answers differ: exact arithmetic or a closed form decides, over the core as over engines."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from validation.check import Comparison
from validation.judge import errors_of
from validation.one_case import case_of
from validation.record import Arbitration, Standing

US = "softbody"


def arbitrate(
    by: str,
    truth: Any,
    answers: Mapping[str, Any],
    *,
    tolerance: float = 0.0,
    scale: Any = 1.0,
    groups: Any = None,
    inputs: Mapping[str, Any] | None = None,
) -> Arbitration:
    """Return how often each of `answers`, of the core (US) and of engines, misses the truth by more than a tolerance.

    `by` says what knows the truth, in words. Truth and answers are (n,) or (n, k), as in a Comparison, and so are
    scale, groups and inputs. Raises ValueError as the judge does.
    """
    standings, all_wrong = [], []
    for who, answer in answers.items():
        comparison = Comparison(answer, truth, scale, groups, inputs=inputs or {})
        errors = errors_of(answer, truth, scale)
        wrong = ~(errors <= tolerance)
        all_wrong.append(wrong)
        worst = int(np.argmax(errors)) if len(errors) else 0
        standings.append(
            Standing(
                who=who,
                n=len(errors),
                wrong=int(wrong.sum()),
                worst=float(errors[worst]) if len(errors) else None,
                case=case_of(comparison, errors, worst) if wrong.any() else None,
            )
        )
    differ = np.any([wrong != all_wrong[0] for wrong in all_wrong], axis=0)
    return Arbitration(by, int(np.sum(differ)), tolerance, standings)
