"""Interrupts: heard while a kernel runs, and never between what belongs together.

Python handles signals between two of its own instructions, in the main thread: so not while a kernel runs, and perhaps
just when it has ended: what it returned is then lost, and only what it wrote to arrays is there. (So kernels that move
a world write all of it, and its clock.)
"""

from __future__ import annotations

import mmap
import os
import signal
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any

import numpy as np

MOST_TOLD = 2**16 - 1  # signals of one call that others are told of: no more go into a pipe at once


def assign_together(*pairs: tuple[np.ndarray, Any]) -> None:
    """Overwrite each array with what comes with it: all of them, without an instruction of Python on the way."""
    arrays, values = zip(*pairs, strict=True)
    list(map(np.ndarray.__setitem__, arrays, [...] * len(arrays), values))


def set_together(*attributes: tuple[object, str, Any]) -> None:
    """Set attributes (object, name, value): all of them, without an instruction of Python on the way."""
    objects, names, values = zip(*attributes, strict=True)
    list(map(object.__setattr__, objects, names, values))


class InterruptFlag:
    """A byte that a kernel can look at: a signal sets it, before Python handles the signal."""

    def __init__(self, is_set: np.ndarray, file: int = -1) -> None:
        """`is_set` (1,) of uint8 is where `file` begins; −1: nobody sets it."""
        self.is_set = is_set
        self.file = file
        self.others = -1  # whose file signals were written to before

    def clear(self) -> None:
        """Set the byte to 0. A signal that came before is handled before the next call of a kernel."""
        if self.file < 0 or os.lseek(self.file, 0, os.SEEK_CUR) == 0:
            return
        # A signal may come between any two of these. Where it does, the next one still comes to the byte.
        first, self.is_set[0] = int(self.is_set[0]), 0
        os.lseek(self.file, 0, os.SEEK_SET)
        if self.others >= 0:
            with suppress(BlockingIOError):  # it is full: whoever reads there has signals to handle
                os.write(self.others, bytes([first]) + os.pread(self.file, MOST_TOLD, 1))
        os.ftruncate(self.file, 1)


NEVER_SET = InterruptFlag(np.zeros(1, np.uint8))
_flags: dict[int, InterruptFlag] = {}  # one for each process: what is forked must not share its parent's


@contextmanager
def listening() -> Iterator[InterruptFlag]:
    """Yield an InterruptFlag that signals set, or one that nobody sets where signals are not handled: in other threads.

    Python writes the number of each signal, when it comes, to a file of one's choice: here one that lies in memory.
    Somebody else's choice, such as asyncio's, is put back, and told what came.
    """
    if os.name != "posix" or threading.current_thread() is not threading.main_thread():
        yield NEVER_SET
        return
    flag = _flag_of_process()
    flag.others = -1
    flag.clear()
    before = signal.set_wakeup_fd(flag.file, warn_on_full_buffer=False)
    flag.others = before if before != flag.file else -1
    try:
        yield flag
    finally:
        signal.set_wakeup_fd(flag.others, warn_on_full_buffer=False)
        flag.clear()


@contextmanager
def later() -> Iterator[Callable[[], None]]:
    """Have signals handled when the block has ended: what a handler raises in it, some libraries do not bear.

    trimesh, for one, takes anything that is raised while it makes a colour, or looks for a library, for an answer.
    Yields a function that handles, in the block, what has come so far.
    """
    if threading.current_thread() is not threading.main_thread():  # no handler is called here
        yield lambda: None
        return
    came: dict[int, FrameType | None] = {}  # once for all of a number, as the system does; where the last one came
    is_over = False
    every = {int(number): signal.getsignal(number) for number in signal.valid_signals()}
    handlers = {number: handler for number, handler in every.items() if callable(handler)}

    def hear() -> None:
        while came:
            number, frame = came.popitem()
            handlers[number](number, frame)

    def put_off(number: int, frame: FrameType | None) -> None:
        came[number] = frame
        if is_over:  # and this is still the handler: another one, put back before, has raised
            hear()

    try:
        for number in handlers:
            signal.signal(number, put_off)
        yield hear
    finally:
        try:
            for number, handler in handlers.items():
                signal.signal(number, handler)
        finally:
            is_over = True
            hear()


def _flag_of_process() -> InterruptFlag:
    """Return the flag of this process; it is never closed, so that no signal is written to a file in its place."""
    flag = _flags.get(os.getpid())
    if flag is None:
        file = os.memfd_create("softbody") if hasattr(os, "memfd_create") else _file_on_disk()
        os.ftruncate(file, 1)
        os.set_blocking(file, False)
        flag = InterruptFlag(np.frombuffer(mmap.mmap(file, 1), np.uint8), file)
        _flags[os.getpid()] = flag
    return flag


def _file_on_disk() -> int:
    """Return a file that is gone when nobody has it open."""
    with tempfile.TemporaryFile() as file:
        return os.dup(file.fileno())
