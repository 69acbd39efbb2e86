"""Pairs of boxes that overlap, or do not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from references import exact
from validation.cases import random_box_pairs
from validation.check import DISAGREEMENTS, Comparison, Run
from validation.checks.geometry.sat import near_ties
from validation.subject import asks

FAMILY = "boxes that overlap"

Answer = Callable  # the function of the subject that is asked


@asks(
    "boxes_overlap",
    reference="exact rational arithmetic on the same floating-point inputs",
    kind="exact arithmetic",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="a yes-or-no answer; ties are too rare to be drawn",
)
def at_random(run: Run, overlap: Answer) -> Comparison:
    """Random boxes overlap if and only if exact arithmetic says so."""
    pairs = random_box_pairs(run.fresh_rng(), run.count(200, 2_000, 50_000))
    return Comparison(np.asarray(overlap(*pairs)), exact.boxes_overlap(*pairs) >= 0, inputs=pairs._asdict())


@asks(
    "boxes_overlap",
    reference="exact rational arithmetic on the same floating-point inputs",
    kind="exact arithmetic",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="pairs whose exact separation is below the rounding of doubles, 4e-15 of the size, are passed over",
)
def nearly(run: Run, overlap: Answer) -> Comparison:
    """Boxes that miss or touch each other by 1e-3 to 1e-14 of their size are told apart rightly."""
    pairs, kinds = near_ties(run.fresh_rng(), run.count(200, 2_000, 50_000))
    clear = np.abs(exact.box_separation(*pairs)) > 4e-15 * pairs.extent
    pairs = pairs.select(clear)
    truth = exact.boxes_overlap(*pairs) >= 0
    return Comparison(np.asarray(overlap(*pairs)), truth, groups=kinds[clear], inputs=pairs._asdict())
