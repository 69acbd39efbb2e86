"""Numba's threads, as a world uses them: as many as it asks for, and asleep while they wait."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

import numba


@contextmanager
def team_of(threads: int) -> Iterator[None]:
    """Let Numba have that many threads; one, and nothing runs on Numba's threads."""
    if threads == 1:
        yield
        return
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
