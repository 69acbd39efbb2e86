"""Pairs of boxes that overlap, or do not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from references import exact
from validation.cases import random_box_pairs
from validation.check import DISAGREEMENTS, Comparison, Run
from validation.checks.sat import near_ties
from validation.subject import asks

FAMILY = "boxes that overlap"

Answer = Callable  # the function of the subject that is asked


@asks(
    "boxes_overlap",
    family=FAMILY,
    claim="Random boxes overlap if and only if exact arithmetic says so.",
    reference="exact rational arithmetic on the same floating-point inputs",
    kind="exact arithmetic",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="a yes-or-no answer; ties are too rare to be drawn",
    detects="one wrong answer",
)
def at_random(run: Run, overlap: Answer) -> Comparison:
    pairs = random_box_pairs(run.fresh_rng(), run.count(200, 2_000, 50_000))
    return Comparison(np.asarray(overlap(*pairs)), exact.boxes_overlap(*pairs) >= 0, inputs=pairs._asdict())


@asks(
    "boxes_overlap",
    family=FAMILY,
    claim="Boxes that miss or touch each other by 1e-3 to 1e-14 of their size are told apart rightly.",
    reference="exact rational arithmetic on the same floating-point inputs",
    kind="exact arithmetic",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="pairs whose exact separation is below the rounding of doubles, 4e-15 of the size, are passed over",
    detects="one wrong answer; any tolerance inside the test",
)
def nearly(run: Run, overlap: Answer) -> Comparison:
    pairs, kinds = near_ties(run.fresh_rng(), run.count(200, 2_000, 50_000))
    clear = np.abs(exact.box_separation(*pairs)) > 4e-15 * pairs.extent
    pairs = pairs.select(clear)
    truth = exact.boxes_overlap(*pairs) >= 0
    return Comparison(np.asarray(overlap(*pairs)), truth, groups=kinds[clear], inputs=pairs._asdict())
