"""Steps by time: a run of so many seconds, or frame by frame, by the world's own steps or by a user's."""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil, inf

from softbody.bodies.contact_points import ContactPoints, of_all_steps
from softbody.model.validation import check_range
from softbody.stepping.runner import Runner
from softbody.stepping.time_steps import BOX_STEP, OF_STABLE, check_own_steps, whole_steps, whole_steps_owed


def run(runner: Runner, seconds: float, time_step: float | None, substeps: int | None, allow_unstable: bool) -> None:
    """Do what `World.run` says."""
    seconds = check_range(seconds, "seconds", "s", least=0.0)
    check_own_steps(time_step, substeps, allow_unstable)
    if time_step is None:
        for _ in frames(runner, seconds):
            pass
        return
    time_step = check_range(time_step, "time_step", "s", above=0.0)
    check_range(seconds / time_step, "seconds / time_step", most=2.0**62)
    steps, h = whole_steps(seconds, time_step)
    runner.step(h, steps, substeps, allow_unstable)


def step_frame(runner: Runner, seconds: float, time_step: float | None = None) -> int:
    """Do what `World.step_frame` says."""
    seconds = check_range(seconds, "seconds", "s", least=0.0)
    if time_step is not None:
        time_step = check_range(time_step, "time_step", "s", above=0.0)
        check_range(seconds / time_step, "seconds / time_step", most=2.0**53)
        count, runner.store.owed = whole_steps_owed(runner.store.owed, seconds, time_step)
        runner.step(time_step, count)
        return count
    count = _steps_of_frame(runner, seconds)
    if count:
        runner.step(seconds / count, count)
    return count


def step_frame_contacts(runner: Runner, seconds: float) -> ContactPoints:
    """Do what `World.step_frame_contacts` says."""
    seconds = check_range(seconds, "seconds", "s", above=0.0)
    count, found = _steps_of_frame(runner, seconds), list[ContactPoints]()
    for _ in range(count):
        runner.step(seconds / count)
        found.append(runner.contact_points())
    return of_all_steps(found, seconds / count)


def _steps_of_frame(runner: Runner, seconds: float) -> int:
    """Return in how many steps the world takes a frame."""
    longest = min(OF_STABLE * runner.stable_time_step(), BOX_STEP if runner.store.model.box_count else inf)
    check_range(seconds / longest, "seconds / stable_time_step", most=2.0**53)
    return max(1, ceil(seconds / longest)) if seconds > 0.0 else 0


def frames(runner: Runner, seconds: float, per_second: float = 60.0, time_step: float | None = None) -> Iterator[int]:
    """Do what `World.frames` says."""
    seconds = check_range(seconds, "seconds", "s", least=0.0)
    frame = 1.0 / check_range(per_second, "per_second", "1/s", above=0.0)
    check_range(seconds / frame, "seconds × per_second", most=2.0**53)
    count, even = whole_steps(seconds, frame)
    for number in range(count):
        last = seconds - (count - 1) * frame
        step_frame(runner, frame if even == frame or number < count - 1 else last, time_step)
        yield number


def frames_by_steps(
    runner: Runner,
    seconds: float,
    time_step: float,
    rate: float,
    taken: tuple[int, float],
    substeps: int | None = None,
    allow_unstable: bool = False,
) -> Iterator[None]:
    """Advance by `seconds` in steps of `time_step` [s], and yield whenever it is time for a frame, `rate` a second.

    `taken`: how many frames there were before, and the time [s] of the first: frame k is that of the step nearest to
    k / rate since then. Raises ParameterError for a step that is longer than a frame stays.
    """
    h = check_range(time_step, "time_step", "s", above=0.0, most=1.0 / rate)
    store, (count, begun) = runner.store, taken
    first, now = store.steps, store.time
    last = first + round(seconds / h)
    while store.steps < last:
        due = first + round((begun + count / rate - now) / h)
        runner.step(h, max(0, min(due, last) - store.steps), substeps, allow_unstable)
        if store.steps >= due:
            count += 1
            yield
