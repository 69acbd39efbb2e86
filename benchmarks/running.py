"""The suite, run by pytest-benchmark in a process of its own; its document says what was measured, on which machine."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import click
import numpy as np

Document = dict[str, Any]  # as pytest-benchmark writes it

ROOT = Path(__file__).parent.parent
FOLDER = Path(__file__).parent / "suite"
NOTHING_CHOSEN = 5  # pytest's exit code


def run_suite(level: str, pattern: str, files: tuple[str, ...], page: bool = False) -> tuple[Document, bool]:
    """Run benchmark files or all, or of them what the page has; return what was measured, and if Ctrl-C cut it short.

    Raises ClickException if a benchmark fails, with the end of what pytest said.
    """
    with tempfile.TemporaryDirectory() as folder:
        written = Path(folder) / "benchmarks.json"
        command = [sys.executable, "-m", "pytest", *(str(FOLDER / file) for file in files or ("",)), "-q"]
        command += ["-p", "no:cacheprovider", "-p", "no:xdist", f"--rootdir={ROOT}", "-c", str(ROOT / "pyproject.toml")]
        command += [f"--benchmark-json={written}", "--benchmark-columns=median,iqr,rounds", f"--level={level}"]
        command += (["-k", pattern] if pattern else []) + (["--page"] if page else [])
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as child:
            interrupted = False
            try:
                said, _ = child.communicate()
            except KeyboardInterrupt:  # the child hears it, too, and writes what it has
                interrupted = True
                said, _ = child.communicate()
        if child.returncode == NOTHING_CHOSEN:
            raise click.UsageError(f"no benchmark at level {level} matches {pattern!r}")
        if (child.returncode and not interrupted) or not written.exists():
            raise click.ClickException("the benchmarks failed: " + " ".join(said.strip().splitlines()[-3:]))
        document: Document = json.loads(written.read_text(encoding="utf-8"))
    return document, interrupted


def competitors(race: dict[str, Any]) -> dict[str, np.ndarray]:
    """Return seconds per unit of every competitor of one race, round by round, ours first."""
    info = race["extra_info"]
    ours = {info["name"]: np.array(race["stats"]["data"]) / info["units"]}
    return ours | {name: np.array(peer["seconds"]) / peer["units"] for name, peer in info["peers"].items()}
