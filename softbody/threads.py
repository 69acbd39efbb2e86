"""Numba's threads, as a world uses them: as many as it asks for, and asleep while they wait."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

import numba

from softbody.errors import ParameterError

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
    with _asleep_while_waiting():
        before = numba.get_num_threads()  # launches them, if nothing has yet
    numba.set_num_threads(threads)
    try:
        yield
    finally:
        numba.set_num_threads(before)


@contextmanager
def _asleep_while_waiting() -> Iterator[None]:
    """Let OpenMP, if it is loaded now, put threads to sleep that wait for each other, unless the user chose otherwise.

    By default they spin: where others use the machine too, each meeting then lasts until the one that all wait for has
    its turn again. On a busy machine two threads were up to 15 times slower than one.
    """
    if "OMP_WAIT_POLICY" in os.environ:
        yield
        return
    os.environ["OMP_WAIT_POLICY"] = "passive"
    try:
        yield
    finally:
        os.environ.pop("OMP_WAIT_POLICY", None)


def _note_fork() -> None:
    """Note that threads were lost, if any had been launched: to use them would end the process, or wait for ever."""
    try:
        numba.threading_layer()
    except ValueError:  # none was launched
        return
    _lost.append(os.getpid())


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_note_fork)
