"""Instruction counts of calls by Valgrind: a second witness of a slow-down, and one without noise.

Its limits: it knows no AVX-512, so that for it both cores are compiled for a processor that has none; and instructions
are not time: a call that waits for memory takes no more of them.
"""

from __future__ import annotations

import platform
import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.serving import COUNT, COUNTER, cores_here
from benchmarks.worker import Worker

if TYPE_CHECKING:
    from benchmarks.compare import Plan, Result, Said

SOURCE = Path(__file__).with_name("count_instructions.c")
# The newest processor of which Valgrind knows all instructions. Numba keeps the machine code for it apart.
PROCESSOR = {"NUMBA_CPU_NAME": "haswell", "NUMBA_CPU_FEATURES": "+avx,+avx2,+bmi,+bmi2,+fma,+popcnt,+sse4.2"}


class CannotCountError(Exception):
    """The machine has no counter of instructions: why."""


def count(plan: Plan, results: dict[str, Result], said: Said) -> None:
    """Add to each result the instructions of a call with either core; raises CannotCountError, or WorkerError."""
    names = [result.name for result in results.values() if not result.why]
    with tempfile.TemporaryDirectory() as made:
        counter = compiled_counter(Path(made))
        counts = []
        for side in plan.sides:
            folder = Path(tempfile.mkdtemp(dir=made))
            settings = PROCESSOR | {COUNTER: str(counter)}
            valgrind = ["valgrind", "--tool=callgrind", "--instr-atstart=no", f"--callgrind-out-file={folder}/counts"]
            files = sorted({name.split("::")[0] for name in names})
            # Without Valgrind first, which would compile as slowly as it does everything.
            for under in ([], valgrind):
                with Worker(side, plan.root, plan.level, files, under, settings) as worker:
                    worker.hear()
                    counted = {}
                    for name in names:
                        said(f"{name}: instructions of {side.name}")
                        counted[name] = _of_one(worker, name, folder if under else None)
            counts.append(counted)
    for name in names:
        a, b = (counted[name] for counted in counts)
        results[name].instructions = (a, b) if a and b else None


def compiled_counter(folder: Path) -> Path:
    """Return the library that tells Valgrind what to count; raises CannotCountError."""
    if platform.machine() != "x86_64":
        raise CannotCountError(f"this was never tried on {platform.machine()}")
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if not shutil.which("valgrind") or not compiler:
        raise CannotCountError(f"there is no {'C compiler' if shutil.which('valgrind') else 'valgrind'}; install one")
    library = folder / "counter.so"
    command = [compiler, "-O1", "-shared", "-fPIC", "-o", str(library), str(SOURCE)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise CannotCountError(f"{SOURCE.name} cannot be compiled: {done.stderr.strip().splitlines()[0]}")
    return library


def _of_one(worker: Worker, name: str, folder: Path | None) -> int | None:
    """Open a benchmark; return its instructions, or None where it takes several threads, or there is no folder."""
    worker.tell((name, min(cores_here()), 0))
    ready = worker.hear()
    if "why" in ready:
        return None
    found = None
    if folder and ready["threads"] == 1:
        worker.tell(COUNT)
        worker.hear()
        newest = max(folder.glob("counts.*"), key=lambda path: int(path.suffix[1:]))
        totals = re.search(r"^totals: (\d+)", newest.read_text(), re.MULTILINE)
        found = int(totals[1]) if totals else None
    worker.tell(None)
    worker.hear(), worker.hear()
    return found
