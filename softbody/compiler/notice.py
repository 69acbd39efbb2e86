"""What is said once, where a program waits for its first kernels: that they compile, and how not to wait."""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Timer

AFTER = 2.0  # [s]
TEXT = (
    "softbody compiles machine code for what this program uses, once on this machine; it may take a minute or two "
    "(`python -m softbody warmup` does it ahead for all kinds of worlds)"
)
_is_said = False


@contextmanager
def told_if_long() -> Iterator[None]:
    """Say once a process, if this takes long, what is waited for: on a terminal, or else to the log `softbody`."""
    if _is_said:
        yield
        return
    timer = Timer(AFTER, _say)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def _say() -> None:
    global _is_said
    if _is_said:
        return
    _is_said = True
    if sys.stderr is not None and sys.stderr.isatty():
        print(TEXT, file=sys.stderr, flush=True)
    else:
        logging.getLogger("softbody").info(TEXT)
