"""A compilation that nothing disturbs: signals wait until Numba and LLVM bear them, and the garbage collector rests."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from numba.core.compiler_lock import global_compiler_lock

from softbody.compiler.interrupts import later
from softbody.compiler.notice import told_if_long

_waiting: list[Callable[[], None]] = []  # what handles the signals that have come since a kernel began to compile


def hear() -> None:
    """Handle the signals that have come, where Numba and LLVM bear what a handler raises."""
    for each in _waiting:
        each()


@contextmanager
def undisturbed() -> Iterator[None]:
    """Let signals wait for `hear`, and Python's garbage collector rest, while a kernel and its parts are compiled.

    What is raised where Numba looks for new functions ends a generator: nothing compiles in that process any more.
    Where LLVM makes or frees an object, it is swallowed, or the process crashes.
    The collector would walk the millions of objects that compiling makes, a sixth of the time.
    """
    with global_compiler_lock._lock:  # a signal is handled at once while another thread compiles
        if _waiting:  # this is a part
            yield
            return
        with later() as handle, told_if_long():
            was_on = gc.isenabled()
            gc.disable()
            _waiting.append(handle)
            try:
                yield
            finally:
                _waiting.clear()
                if was_on:
                    gc.enable()


def first_cause(error: BaseException) -> BaseException:
    """Return what has led to an error, and to those that it has led to."""
    while isinstance(error, SystemError) and error.__cause__ is not None:
        error = error.__cause__
    return error
