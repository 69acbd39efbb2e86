"""At which steps is it time for a frame, where steps are of a length of somebody's own?"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from softbody.model.validation import check_range

if TYPE_CHECKING:
    from softbody.world import World


def frames_by_steps(
    world: World,
    seconds: float,
    time_step: float,
    rate: float,
    frames: tuple[int, float],
    substeps: int | None = None,
    allow_unstable: bool = False,
) -> Iterator[None]:
    """Advance by `seconds` in steps of `time_step` [s], and yield whenever it is time for a frame, `rate` a second.

    `frames`: how many there were before, and the time [s] of the first: frame k is that of the step nearest to
    k / rate since then. Raises ParameterError for a step that is longer than a frame stays.
    """
    h = check_range(time_step, "time_step", "s", above=0.0, most=1.0 / rate)
    taken, begun = frames
    first, now = world.steps, world.time
    last = first + round(seconds / h)
    while world.steps < last:
        due = first + round((begun + taken / rate - now) / h)
        world.step(h, max(0, min(due, last) - world.steps), substeps=substeps, allow_unstable=allow_unstable)
        if world.steps >= due:
            taken += 1
            yield
