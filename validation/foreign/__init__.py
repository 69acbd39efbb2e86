"""Engines in a process, and an environment, of their own: another Python, Node, or any program that speaks as follows.

A question is 8 bytes, the length of what follows as a double; that many bytes of JSON, {"ask": its name, "numbers":
{name: number}, "shapes": {name: [n, …]}}; then the arrays, in that order, as doubles, the lowest byte first. An answer
is {"shapes": …, "seconds": of the processor, that the steps took} or {"error": "why"}, and its arrays, in the same way.
The program reads standard input and writes standard output until the input ends.
"""

from __future__ import annotations

import json
import os
import shutil
import struct
import subprocess
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import IO, Any

import numpy as np

from validation.check import NotHereError
from validation.effort import spent

HERE = Path(__file__).parent
ENVIRONMENTS = Path(os.environ.get("SOFTBODY_ENGINES", HERE.parents[1] / "build" / "engines"))
LONGEST = 1 << 26  # bytes of a header


class ForeignError(Exception):
    """An engine in a process of its own has raised, ended or answered what is no answer."""


class Engine:
    """A program that answers questions."""

    def __init__(self, command: list[str]) -> None:
        self._command = command
        self._start()

    def _start(self) -> None:
        self._process = subprocess.Popen(self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def stop(self) -> None:
        """End it."""
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe:
                with suppress(OSError):
                    pipe.close()

    def ask(self, question: str, numbers: dict[str, float], **arrays: Any) -> dict[str, np.ndarray]:
        """Return the arrays of an answer; raises ForeignError, with the reason."""
        if self._process.poll() is not None:  # what it was asked before has ended it
            self._start()
        rows = {name: np.ascontiguousarray(array, "<f8") for name, array in arrays.items()}
        shapes = {name: row.shape for name, row in rows.items()}
        head = json.dumps({"ask": question, "numbers": numbers, "shapes": shapes}).encode()
        assert self._process.stdin
        assert self._process.stdout
        try:
            self._process.stdin.write(
                b"".join([struct.pack("<d", len(head)), head, *(r.tobytes() for r in rows.values())])
            )
            self._process.stdin.flush()
            (length,) = struct.unpack("<d", _taken(self._process.stdout, 8))
            if not 0 < length < LONGEST:
                raise ValueError(f"it begins with {length}, which is no length")
            said = json.loads(_taken(self._process.stdout, int(length)))
            if "error" in said:
                raise ForeignError(str(said["error"]))
            answer = {name: _array(self._process.stdout, shape) for name, shape in said["shapes"].items()}
        except (OSError, EOFError, ValueError, KeyError, TypeError) as error:
            self.stop()
            raise ForeignError(f"it gave no answer ({type(error).__name__}: {error})") from None
        spent(float(said["seconds"]))
        return answer


def _taken(stream: IO[bytes], count: int) -> bytes:
    taken = stream.read(count)
    if len(taken) < count:
        raise EOFError("it has ended")
    return taken


def _array(stream: IO[bytes], shape: list[int]) -> np.ndarray:
    count = int(np.prod(shape))
    return np.frombuffer(_taken(stream, 8 * count), "<f8").reshape(shape).astype(float)


def stop() -> None:
    """End the programs that were started."""
    engine.cache_clear()
    while _STARTED:
        _STARTED.pop().stop()


_STARTED: list[Engine] = []


@cache
def engine(name: str) -> Engine:
    """Return an engine of this folder, run by Node or a Python of its own; raises NotHereError if that is missing."""
    home, environment = HERE / name, ENVIRONMENTS / name
    by_node = (home / "engine.mjs").is_file()
    if by_node and not shutil.which("node"):
        raise NotHereError("Node is not installed: it is Debian's package nodejs")
    if not (environment / ("node_modules" if by_node else "bin")).is_dir():
        raise NotHereError(f"its environment is not made: `python -m validation.foreign {name}` makes it")
    command = ["node", "engine.mjs"] if by_node else [str(environment / "bin" / "python"), "engine.py"]
    command[1] = str(home / command[1])
    _STARTED.append(Engine([*command, str(environment)]))
    return _STARTED[-1]
