"""A process that runs benchmarks with the core of one side, a round at a time."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from multiprocessing import Pipe
from pathlib import Path
from types import MappingProxyType
from typing import Any

from benchmarks.serving import PIPE
from benchmarks.sides import Side

SUITE = "benchmarks/suite"  # in the repository


class WorkerError(Exception):
    """A worker that died, or cannot start: the message is the last that it said."""


class Worker:
    """The process, `under` another program if need be, with more `settings` in its environment.

    It has some `files` of the suite, or all, and ends with the `with` block.
    """

    def __init__(
        self,
        side: Side,
        root: Path,
        level: str,
        files: Sequence[str] = ("",),
        under: Sequence[str] = (),
        settings: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        self.side = side
        self.pipe, theirs = Pipe()
        self.said = tempfile.TemporaryFile("w+")  # noqa: SIM115  # closed at the exit
        options = (
            "-q -p benchmarks.serving -p no:xdist -p no:cacheprovider -o pythonpath= --continue-on-collection-errors"
        )
        command = [*under, sys.executable, "-m", "pytest", *options.split(), f"--rootdir={root}", f"--level={level}"]
        command += [str(root / SUITE / file) for file in files]
        # The side's folder first, which has a `softbody` and nothing else; all the rest from the working tree.
        paths = os.pathsep.join([str(side.folder), str(root)])
        environment = {**os.environ, "PYTHONPATH": paths, PIPE: str(theirs.fileno()), "PYTHONHASHSEED": "0"}
        environment |= settings
        self.process = subprocess.Popen(
            command,
            cwd=side.folder,
            env=environment,
            pass_fds=[theirs.fileno()],
            stdin=subprocess.DEVNULL,
            stdout=self.said,
            stderr=subprocess.STDOUT,
            start_new_session=True,  # Ctrl-C is for the process that tells it what to do
        )
        theirs.close()

    def __enter__(self) -> Worker:
        return self

    def __exit__(self, *_: object) -> None:
        self.pipe.close()
        self.process.kill()
        self.process.wait()
        self.said.close()

    def tell(self, message: Any) -> None:
        """Send a message; a worker that is not there any more is noticed when it is heard."""
        with suppress(OSError):
            self.pipe.send(message)

    def hear(self) -> Any:
        """Wait for a message; raises WorkerError if none can come."""
        try:
            return self.pipe.recv()
        except (EOFError, OSError) as error:
            self.process.wait()
            self.said.seek(0)
            lines = [line.removeprefix("INTERNALERROR> ").strip() for line in self.said if line.strip()]
            last = next((line for line in reversed(lines) if "Error" in line), lines[-1] if lines else "it ended")
            raise WorkerError(f"{self.side.name} cannot run it: {last}") from error
