"""Numba's threads, as a world uses them: as many as it asks for where they pay, and asleep while they wait for long."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import ceil
from time import perf_counter

import numba

from softbody.errors import ParameterError

STINT = 0.02  # [s] at least, and so many steps, before the clock says what a step takes
STINT_STEPS = 16
SHARE_OF_TRIALS = 0.02  # of all time may be lost by trying what was slower before
MOST_BETWEEN_TRIALS = 60.0  # [s] though what was slower by far is tried so often: the machine may be another one by now

# How OpenMP's threads wait. GNU's look so often before they sleep, which takes them a few tenths of a millisecond.
WAITING = {"OMP_WAIT_POLICY": "passive", "GOMP_SPINCOUNT": "30000"}

_lost: list[int] = []  # processes that were forked off when threads had been launched, which do not live on in them


@contextmanager
def team_of(threads: int) -> Iterator[None]:
    """Let Numba have that many threads; one, and nothing runs on Numba's threads."""
    if threads == 1:
        yield
        return
    if os.getpid() in _lost:
        raise ParameterError(
            f"threads is {threads}, and this process was forked off one that had launched threads, which it does not "
            "have: take threads=1 here, or start processes by 'spawn' or 'forkserver'"
        )
    with _soon_asleep_while_waiting():
        before = numba.get_num_threads()  # launches them, if nothing has yet
    numba.set_num_threads(threads)
    try:
        yield
    finally:
        numba.set_num_threads(before)


class Team:
    """All threads that a world may have, or one where that is faster just now, as the clock says.

    Several threads wait for the last of them at each meeting. On a machine that others use too they may be slower than
    one, for as long as others do. Steps have the same bits for any number: so each is tried, the faster one goes on,
    and the other one has a turn every now and then.
    """

    def __init__(self, most: int, clock: Callable[[], float] = perf_counter) -> None:
        self.now = self.most = most
        self._clock = clock
        self._is_warm = False  # a first turn may compile, and tells nothing
        self._step_times: dict[int, float] = {}  # [s] by threads, as they were last
        self._stints: dict[int, float] = {}  # [s] that the last took
        self._steps, self._seconds = 0, 0.0  # of the stint that goes on
        self._since_trial = 0.0  # [s]
        self._begun = 0.0

    def turn(self, steps: int) -> int:
        """Begin a turn, and return how many of so many steps it should have."""
        known = self._step_times.get(self.now)
        self._begun = self._clock()
        return min(steps, STINT_STEPS if known is None else max(STINT_STEPS, ceil(STINT / known)))

    def note(self, steps: int) -> None:
        """End a turn in which so many steps were done, and choose who has the next."""
        seconds = self._clock() - self._begun
        if not self._is_warm:
            self._is_warm = True
            return
        self._steps += steps
        self._seconds += seconds
        self._since_trial += seconds
        if self._steps >= STINT_STEPS and self._seconds >= STINT:
            self._step_times[self.now], self._stints[self.now] = self._seconds / self._steps, self._seconds
            self._steps, self._seconds = 0, 0.0
            self.now = self._next()

    def _next(self) -> int:
        """Return how many threads go on: the faster ones, unless the others are due for a trial."""
        if len(self._step_times) == 1:
            return 1 if self.now == self.most else self.most
        best, other = sorted(self._step_times, key=lambda threads: self._step_times[threads])
        if self.now == other:
            self._since_trial = 0.0
        lost = self._stints[other] * (1.0 - self._step_times[best] / self._step_times[other])
        is_due = self._since_trial >= min(lost / SHARE_OF_TRIALS, MOST_BETWEEN_TRIALS)
        return other if is_due and self.now == best else best


@contextmanager
def _soon_asleep_while_waiting() -> Iterator[None]:
    """Let OpenMP, if it is loaded now, put threads to sleep that wait for long, unless the user chose otherwise.

    By default they spin: where others use the machine too, each meeting then lasts until the one that all wait for has
    its turn again. On a busy machine two threads were up to 15 times slower than one. But to wake one that sleeps takes
    some 50 µs, and they meet ten times a step: those of GNU's OpenMP spin for a moment first.
    """
    if any(name in os.environ for name in WAITING):
        yield
        return
    os.environ.update(WAITING)
    try:
        yield
    finally:
        for name in WAITING:
            os.environ.pop(name, None)


def _note_fork() -> None:
    """Note that threads were lost, if any had been launched: to use them would end the process, or wait for ever."""
    try:
        numba.threading_layer()
    except ValueError:  # none was launched
        return
    _lost.append(os.getpid())


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_note_fork)
