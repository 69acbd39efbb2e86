"""What does a step cost? Runs the benchmarks of the step in a process of their own and reads what they wrote."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

from validation.record import Timing

BENCHMARK = Path("benchmarks") / "bench_step.py"


def measure_timings(level: str) -> tuple[list[Timing], str | None]:
    """Return the rows of the timing table, or none and the reason."""
    if not BENCHMARK.exists():
        return [], f"{BENCHMARK} is not in this folder: run from the root of the repository"
    with tempfile.TemporaryDirectory() as folder:
        written = Path(folder) / "benchmarks.json"
        command = [sys.executable, "-m", "pytest", str(BENCHMARK), "-q", "-p", "no:cacheprovider"]
        command += [f"--benchmark-json={written}", f"--level={level}"]
        print("timing the step …", file=sys.stderr, flush=True)
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode or not written.exists():
            return [], "the benchmarks failed: " + " ".join(done.stdout.strip().splitlines()[-3:])
        return [timing_of(row) for row in json.loads(written.read_text())["benchmarks"]], None


def timing_of(row: dict) -> Timing:
    """Return one row, from what pytest-benchmark wrote of one benchmark."""
    info, stats = row["extra_info"], row["stats"]
    each = 1e9 / (info["particles"] * info["steps"])
    return Timing(
        name=info["name"],
        particles=info["particles"],
        nanoseconds=stats["median"] * each,
        low=stats["q1"] * each,
        high=stats["q3"] * each,
        rounds=stats["rounds"],
    )
