"""Division of a stretch of time into equal steps that end where it was asked to."""

from __future__ import annotations

from math import ceil

from softbody.errors import ParameterError
from softbody.model.validation import check_yes_or_no, shown

WHOLE = 1e-12  # of their number: so far from a whole number of steps is rounding
OF_STABLE = 0.8  # of the stable step, where a World chooses: it shrinks when bodies are stretched within a frame
BOX_STEP = 1.0 / 240.0  # [s] at most, where there are boxes and a World chooses


def check_own_steps(time_step: float | None, substeps: int | None, allow_unstable: bool) -> None:
    """Raise ParameterError for what is said of steps, without a `time_step`, where the world chooses them."""
    if time_step is None and (substeps is not None or check_yes_or_no(allow_unstable, "allow_unstable")):
        said = f"substeps is {shown(substeps)}" if substeps is not None else "allow_unstable is True"
        raise ParameterError(
            f"{said}, and there is no time_step, so that the world chooses its steps: give one, or set world.substeps"
        )


def whole_steps(seconds: float, time_step: float) -> tuple[int, float]:
    """Return how many steps of which equal length [s], at most `time_step`, make `seconds`.

    It is `time_step` itself, to the last bit, where that goes into `seconds` but for rounding.
    """
    count = round(seconds / time_step)
    if abs(seconds / time_step - count) <= WHOLE * count:
        return count, time_step
    count = ceil(seconds / time_step)
    return count, seconds / count


def whole_steps_owed(owed: float, seconds: float, time_step: float) -> tuple[int, float]:
    """Return how many whole steps there are in `seconds` and what was `owed` before, and what is owed after them [s].

    That is too short for another step: it is added to what is asked for next.
    """
    owed += seconds
    count = int(owed / time_step * (1.0 + WHOLE))
    return count, max(0.0, owed - count * time_step)
