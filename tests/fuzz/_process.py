"""How is an attempt made so that its crash or hang harms nobody? In a process that may be lost."""

from __future__ import annotations

import faulthandler
import os
import signal
import tempfile
import time
from dataclasses import dataclass
from importlib import import_module
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from traceback import extract_tb

FIRST = (
    10.0  # times its limit may the first attempt of a campaign in a process take: it may compile, or be a second one
)


@dataclass(frozen=True)
class Attempt:
    """One attempt of a campaign."""

    campaign: str  # full name of its module
    seed: int


@dataclass(frozen=True)
class Outcome:
    """What became of an attempt."""

    attempt: Attempt
    broken: str | None  # what broke, in a sentence; None if the promise held
    seconds: float
    slow: bool = False  # it had to be made again, with more time


def made(attempt: Attempt) -> str | None:
    """Make an attempt here; return what broke, be it told by an exception."""
    try:
        return import_module(attempt.campaign).attempt(attempt.seed)
    except BaseException as error:  # an exit, too, or an interrupt: nothing may leave an attempt
        where = extract_tb(error.__traceback__)[-1]
        return f"{type(error).__name__}: {error} (line {where.lineno} of {where.filename})"


def _serve(pipe: Connection, output: str) -> None:
    """Make the attempts that come through a pipe until it closes; what they write goes to a file."""
    os.setsid()  # Ctrl-C at the terminal is not for them, and what they start can be ended with them
    file = os.open(output, os.O_WRONLY | os.O_APPEND)
    os.dup2(file, 1)
    os.dup2(file, 2)
    faulthandler.enable()
    while True:
        try:
            attempt = pipe.recv()
        except EOFError:
            return
        pipe.send(made(attempt))


class Process:
    """A process that makes one attempt after the other, and another one in its place when it is lost."""

    def __init__(self, limit: float) -> None:
        """`limit` [s] of an attempt."""
        self._limit = limit
        self._output = tempfile.NamedTemporaryFile()  # noqa: SIM115 (it lives as long as this)
        self._start()

    def _start(self) -> None:
        os.truncate(self._output.name, 0)
        context = get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, self._output.name))
        self._process.start()
        theirs.close()
        self._known: set[str] = set()
        self._is_second = False  # the attempt is made again
        self.attempt: Attempt | None = None
        self._begun = 0.0

    @property
    def seconds(self) -> float:
        """How long the attempt has taken so far [s]."""
        return time.monotonic() - self._begun if self.attempt else 0.0

    def make(self, attempt: Attempt) -> None:
        """Begin an attempt; the process must have none."""
        self.attempt, self._begun = attempt, time.monotonic()
        self.pipe.send(attempt)

    def outcome(self) -> Outcome | None:
        """Return what became of the attempt, or None if it is still being made."""
        attempt, seconds = self.attempt, self.seconds
        assert attempt
        if self.pipe.poll():
            try:
                broken = self.pipe.recv()
            except (EOFError, ConnectionError):
                return self._lost(attempt, seconds)
            self._known.add(attempt.campaign)
            self.attempt = None
            outcome = Outcome(attempt, broken, seconds, self._is_second)
            self._is_second = False
            return outcome
        if attempt.campaign not in self._known:
            if seconds > FIRST * self._limit:
                return self._lost(attempt, seconds, f"no end after {seconds:.0f} s")
        elif seconds > self._limit:
            # Perhaps it compiled: once more, with the time that the first attempt of a process has.
            self.end()
            self._start()
            self.make(attempt)
            self._is_second = True
        return None

    def _lost(self, attempt: Attempt, seconds: float, how: str = "") -> Outcome:
        """Take another process; return that the attempt ended the one before, or had no end."""
        if not how:
            self._process.join(5.0)
            code = self._process.exitcode
            how = f"crash: {signal.Signals(-code).name}" if code is not None and code < 0 else f"exit with {code}"
        self.end()
        said = Path(self._output.name).read_text(errors="replace").strip()[-1500:]
        self._start()
        return Outcome(attempt, f"{how}\n{said}".strip(), seconds)

    def end(self) -> None:
        """End the process, and what it has started."""
        try:
            os.killpg(self._process.pid or 0, signal.SIGKILL)
        except (ProcessLookupError, PermissionError):  # gone, or not yet the leader of a group of its own
            self._process.kill()
        self._process.join()
        self.pipe.close()
