"""A process of its own that works for us: it may crash, hang, flood its output or eat memory, and only it ends."""

from __future__ import annotations

import contextlib
import ctypes
import faulthandler
import io
import os
import pickle
import secrets
import signal
import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any

import psutil

from validation.plain_text import plain

KEPT = 4_000  # bytes of what a process has said last
SHOWN = 600  # characters of them that are shown
LONGEST = 1 << 26  # bytes of an answer
CHUNK = 1 << 16  # bytes that are taken from its output at once
PR_SET_PDEATHSIG = 1  # of Linux' prctl
# Bytes that one process may hold at least, and of the machine's memory what all may hold together.
LEAST_MEMORY, SHARE_OF_MEMORY = 2 * 2**30, 0.8

DIED, TOO_LONG, TOO_LARGE, RAISED = "died", "took too long", "took too much memory", "raised"


@dataclass(frozen=True)
class Task:
    """A call that a worker makes: of a function that can be imported by its name, for so long at most."""

    name: str
    work: Callable[..., Any]
    arguments: tuple[Any, ...]
    limit: float  # [s]


@dataclass(frozen=True)
class Ended:
    """What became of a task: its answer, or how and why there is none."""

    task: Task
    seconds: float
    answer: Any = None
    how: str | None = None  # DIED, TOO_LONG, TOO_LARGE or RAISED; None: there is an answer
    why: str | None = None  # in words
    last_words: str = ""  # what the process wrote last, if it was ended


class Worker:
    """A process that does one task at a time; a new one takes its place when it ends, or is ended.

    What it writes is swallowed but for its end. The memory that it may take [bytes] is looked at from outside: a limit
    on addresses, which the system would hold, forbids what engines only reserve.
    """

    def __init__(self, memory: float) -> None:
        self._memory = memory
        self._task: Task | None = None
        self._start()

    def _start(self) -> None:
        context = get_context("spawn")
        self._end, theirs = context.Pipe()
        self._output, output = context.Pipe(duplex=False)
        self._heard, self._is_fresh, self._hears = b"", True, True
        self._process = context.Process(target=_serve, args=(theirs, output), daemon=True)
        self._process.start()
        theirs.close()
        output.close()

    @property
    def is_idle(self) -> bool:
        """Whether it waits for a task."""
        return self._task is None

    @property
    def news(self) -> list[Connection]:
        """What `multiprocessing.connection.wait` may wait for."""
        return [self._end] * (self._task is not None) + [self._output] * self._hears

    def begin(self, task: Task) -> None:
        """Give it a task."""
        if not self._process.is_alive():  # what a task has left behind may end it later
            self._restart()
        self._task, self._began, self._heard, self._token = task, time.monotonic(), b"", secrets.token_bytes(16)
        try:
            self._end.send((self._token, task.work, task.arguments))
        except OSError:
            self._restart()
            self._end.send((self._token, task.work, task.arguments))

    def look(self) -> Ended | None:
        """Return what became of the task, or None if it goes on."""
        self._listen()
        task = self._task
        if task is None:
            return None
        seconds = time.monotonic() - self._began
        if self._end.poll():
            try:
                is_done, answer = _opened(self._end.recv_bytes(LONGEST), self._token)
            except Exception:  # the end of the pipe, or what is no message of ours
                return self._died(task, seconds)
            self._task, self._is_fresh = None, False
            if is_done:
                return Ended(task, seconds, answer)
            return Ended(task, seconds, how=RAISED, why=plain(answer))
        if not self._process.is_alive():
            return self._died(task, seconds)
        if seconds > task.limit:
            return self._ended(task, seconds, TOO_LONG, f"it was not done after {task.limit:g} s")
        taken = self._resident()
        if taken > self._memory:
            if not self._is_fresh:
                self._again(task)
                return None
            most = f"{self._memory / 2**30:.1f} GiB"
            return self._ended(task, seconds, TOO_LARGE, f"it took {taken / 2**30:.1f} GiB of memory, more than {most}")
        return None

    def _died(self, task: Task, seconds: float) -> Ended | None:
        if not self._is_fresh:
            self._again(task)
            return None
        for _ in range(100):  # its pipe closes a little earlier than it is gone; join(1.0) trusts another pipe of its
            if not self._process.is_alive():
                break
            time.sleep(0.01)
        return self._ended(task, seconds, DIED, f"the process crashed ({_how_ended(self._process.exitcode)})")

    def _again(self, task: Task) -> None:
        """Begin a task once more in a new process: those before it may have left what it would be blamed for."""
        self._restart()
        self.begin(task)

    def _ended(self, task: Task, seconds: float, how: str, why: str) -> Ended:
        self._kill()
        for _ in range(KEPT):  # what is left in the pipe
            if not self._listen():
                break
        words = last_words(self._heard)
        self._restart()
        self._task = None
        return Ended(task, seconds, how=how, why=why, last_words=words)

    def _listen(self) -> bool:
        """Take what it has written, and keep the end of it; return whether there was something."""
        if not self._hears or not self._output.poll():
            return False
        with contextlib.suppress(OSError):
            chunk = os.read(self._output.fileno(), CHUNK)
            self._heard = (self._heard + chunk)[-KEPT:]
            if chunk:
                return True
        self._hears = False
        return False

    def _resident(self) -> int:
        """Return the memory [bytes] that the process holds."""
        with contextlib.suppress(psutil.Error):
            return int(psutil.Process(self._process.pid).memory_info().rss)
        return 0

    def _restart(self) -> None:
        self.stop()
        self._start()

    def _kill(self) -> None:
        """End the process and what it has started, whatever they do."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            if self._process.pid:
                os.killpg(self._process.pid, signal.SIGKILL)
        self._process.kill()
        self._process.join()

    def stop(self) -> None:
        """End the process, and forget its task."""
        self._kill()
        self._end.close()
        self._output.close()


def memory_each(processes: int, memory: float | None = None) -> float:
    """Return the memory [bytes] that each of some processes may hold that share `memory`, or the machine's."""
    return max(LEAST_MEMORY, SHARE_OF_MEMORY * (memory or psutil.virtual_memory().total) / processes)


def last_words(output: bytes) -> str:
    """Return the end of what a process has written; of Python's own words on a crash, the beginning."""
    text = output.decode(errors="replace").strip()
    crash = text.rfind("Fatal Python error")
    return plain(text[-SHOWN:] if crash < 0 else text[crash:][:SHOWN])


def _how_ended(code: int | None) -> str:
    """Say how a process ended by its exit code, or None if it is still there."""
    if code is None:
        return "it closed its pipe"
    names = {one.value: one.name for one in signal.Signals}
    return f"exit code {code}" if code >= 0 else names.get(-code, f"signal {-code}")


class _Answer(pickle.Unpickler):
    """What a process has sent: values of Python's, NumPy's and ours, and nothing that does anything."""

    def find_class(self, module: str, name: str) -> Any:
        """Return a class that an answer may be made of; raises UnpicklingError."""
        if module.split(".")[0] in ("validation", "numpy", "pathlib", "collections") and "." not in name:
            return super().find_class(module, name)
        raise pickle.UnpicklingError(f"an answer holds a {module}.{name}")


def _opened(message: bytes, token: bytes) -> tuple[bool, Any]:
    """Return (is_done, answer) of a message; raises ValueError for one that nobody has asked for."""
    if not message.startswith(token):
        raise ValueError("it does not begin as an answer does")
    is_done, answer = _Answer(io.BytesIO(message[len(token) :])).load()
    return bool(is_done), answer


_is_spoilt = [False]  # what this process has done last is not to be seen by another task


def leave_after_answer() -> None:
    """Let this process end when it has answered: a new one does the next task."""
    _is_spoilt[0] = True


def _serve(end: Connection, output: Connection) -> None:
    """Do what is asked for, until nobody asks any more; Ctrl-C is for who asks."""
    os.setsid()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform == "linux":  # elsewhere it ends with its task
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    faulthandler.enable(file=output.fileno())
    home = os.getcwd()
    while True:
        try:
            token, work, arguments = end.recv()
        except EOFError:
            return
        os.chdir(home)
        for name, stream in (("stdout", 1), ("stderr", 2)):
            os.dup2(output.fileno(), stream)
            setattr(sys, name, open(stream, "w", encoding="utf-8", errors="backslashreplace", closefd=False))  # noqa: SIM115
        try:
            with warnings.catch_warnings():
                answer = True, work(*arguments)
        except BaseException as error:
            answer = False, f"raised {type(error).__name__}: {plain(error)}"
        with contextlib.suppress(Exception):
            sys.stdout.flush()
        end.send_bytes(token + pickle.dumps(answer))
        if _is_spoilt[0]:
            return
