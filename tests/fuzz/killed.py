"""A validation killed at any moment leaves whole files, loses one finished claim a worker at most, and goes on."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree
from functools import cache
from pathlib import Path

import numpy as np

from validation.journal import NAME
from validation.record import read_report

GOAL = 500
TRIES = 3  # kills of one run, and of what goes on with it

ROOT = Path(__file__).parents[2]
CLAIMS = 12
PATIENCE = 60.0  # [s] for a run that takes a few, and for processes that have nobody left to answer to
ENVIRONMENT = {"PYTHONPATH": str(ROOT), "NUMBA_DISABLE_JIT": "1"}  # its claims compile nothing, and start sooner so
ENDED = "ended"  # a line of it a claim that has ended: what a run has kept of them is told from it

# Claims that compile nothing. A seventh of them fails: verdicts are kept as well as numbers.
SOURCE = """
import os, time
from validation.check import Comparison, check
from validation.fault import Fault

words = dict.fromkeys(("section", "piece", "reference", "because"), "some")
fault = Fault("a fault", "softbody.world.PRECISIONS", "x_ → None")

def declare(number):
    def compare(run):
        time.sleep(0.03)
        answers = run.fresh_rng().random(1_000)
        errors = (1e-3 if number == 3 else 1e-12) * run.fresh_rng().normal(size=1_000)
        file = os.open("{ended}", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        os.write(file, b"many.one_%d\\n" % number)
        os.close(file)
        return Comparison(answers, answers + errors, inputs={{"answer": answers}})
    compare.__name__, compare.__doc__ = f"one_{{number}}", "One of many."
    check(family=f"family {{number % 3}}", tolerance=1e-9, kind="invariant", faults=(fault,),
          **words)(compare)

for number in range({claims}):
    declare(number)
"""


@cache
def _place() -> Path:
    """Return a folder in which `python -m validation` is ours, with those claims; it goes with this process."""
    folder = tempfile.TemporaryDirectory()
    _kept.append(folder)
    place = Path(folder.name)
    shutil.copytree(ROOT / "validation", place / "validation", ignore=shutil.ignore_patterns("checks", "*.pyc.*"))
    checks = place / "validation" / "checks"
    checks.mkdir()
    (checks / "__init__.py").touch()
    (checks / "many.py").write_text(SOURCE.format(ended=ENDED, claims=CLAIMS))
    return place


_kept: list[tempfile.TemporaryDirectory[str]] = []


class _Run:
    """A run of the validation in a process group of its own."""

    def __init__(self, out: Path, resume: bool, workers: int) -> None:
        out.mkdir(exist_ok=True)
        options = ["--level", "quick", "--no-timings", "--workers", str(workers), "--out", str(out)]
        command = [sys.executable, "-m", "validation", *options, *(["--resume"] if resume else [])]
        self._said = out / "said"
        with self._said.open("wb") as said:
            self.process = subprocess.Popen(
                command, cwd=_place(), env=os.environ | ENVIRONMENT, stdout=said, stderr=said,
                start_new_session=True,
            )  # fmt: skip

    def said(self) -> str:
        """What it has said so far."""
        return self._said.read_text(errors="replace")

    def wait_for(self, lines: int, seconds: float) -> None:
        """Wait until it has said so many lines, or has ended, and so long after that."""
        end = time.monotonic() + PATIENCE
        while self.process.poll() is None and self.said().count("\n") < lines and time.monotonic() < end:
            time.sleep(0.002)
        end = time.monotonic() + seconds
        while self.process.poll() is None and time.monotonic() < end:
            time.sleep(0.002)

    def kill(self, all_of_it: bool) -> bool:
        """Kill it, with its workers or alone; tell whether it was still running."""
        if self.process.poll() is not None:
            return False
        if all_of_it:
            os.killpg(self.process.pid, signal.SIGKILL)
        else:
            self.process.kill()
        return self.process.wait() == -signal.SIGKILL

    def is_gone(self) -> bool:
        """Tell whether its workers end, too; end them if they do not."""
        end = time.monotonic() + PATIENCE
        try:
            while time.monotonic() < end:
                os.killpg(self.process.pid, 0)
                time.sleep(0.01)
            os.killpg(self.process.pid, signal.SIGKILL)
        except ProcessLookupError:
            return True
        return False


@cache
def _whole() -> tuple[float, int, list[object]]:
    """Return how long a run takes that nobody kills [s], how it ends, and with which claims."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        begun = time.monotonic()
        code = _Run(out, False, 1).process.wait(PATIENCE)
        return time.monotonic() - begun, code, _claims(out)


def _claims(out: Path) -> list[object]:
    """Return the claims of a report but how long they took."""
    return [{**claim, "seconds": 0.0} for claim in json.loads((out / "report.json").read_text())["claims"]]


def attempt(seed: int) -> str | None:
    """Kill a run and those that go on with it; look at each file; then go on to the end."""
    rng = np.random.default_rng(seed)
    seconds, code, claims = _whole()
    workers, ended = int(rng.integers(1, 3)), _place() / ENDED
    with tempfile.TemporaryDirectory() as folder:
        out, kills, kept = Path(folder) / "out", 0, None
        while kills < TRIES:
            ended.unlink(missing_ok=True)
            run = _Run(out, kept is not None, workers)
            if rng.random() < 0.5:
                run.wait_for(0, seconds * rng.random())
            else:  # while claims end, which is a short while
                run.wait_for(int(rng.integers(1, CLAIMS + 4)), 0.1 * rng.random())
            was_killed = run.kill(all_of_it=rng.random() < 0.5)
            if not was_killed and run.process.returncode != code:
                return f"ended with {run.process.returncode}: {run.said()}"
            if not run.is_gone():
                return "its workers live on"
            wrong, now = _torn(out), _kept_in(out)
            if wrong:
                return wrong
            kills += was_killed
            if not was_killed:
                shutil.rmtree(out)
                kept = None
                continue
            if now is None and kept and not (out / "report.json").exists():
                return f"{len(kept)} claims are gone"
            finished = ended.read_text().split() if ended.exists() else []
            told = set(re.findall(r"^[✓✗] ([\w.]+):", run.said(), re.MULTILINE))
            lost = set(finished) - set(now or ())
            if now is not None and ((told & set(finished)) - set(now) or len(lost) > workers):
                return f"finished and not kept: {sorted(lost)}; told: {sorted(told)}"
            if not set(kept or ()) <= set(now or kept or ()):
                return f"{sorted(set(kept or ()) - set(now or ()))} were kept, and are not"
            kept = now
        run = _Run(out, kept is not None, workers)
        if run.process.wait(PATIENCE) != code:
            return f"ended with {run.process.returncode}: {run.said()}"
        if kept is not None and kept and f"{len(kept)} of {CLAIMS} claims have been judged before" not in run.said():
            return f"{len(kept)} claims were kept: {run.said()}"
        return None if _claims(out) == claims else "the claims differ from those of a run that nobody killed"


def _kept_in(out: Path) -> list[str] | None:
    """Return the claims of the journal, or None if there is none to go on with."""
    lines = (out / NAME).read_bytes().split(b"\n")[:-1] if (out / NAME).exists() else []
    return [json.loads(line)["id"] for line in lines[1:]] if lines else None


def _torn(out: Path) -> str | None:
    """Return which file of a folder is not whole."""
    for name, read in {
        "report.json": read_report,
        "junit.xml": xml.etree.ElementTree.parse,
        "badge.svg": xml.etree.ElementTree.parse,
        "index.html": lambda path: path.read_text(encoding="utf-8").rindex("</html>"),
        NAME: lambda path: [json.loads(line) for line in path.read_bytes().split(b"\n")[:-1]],
    }.items():
        try:
            if (out / name).exists():
                read(out / name)
        except (ValueError, SyntaxError) as error:
            return f"{name} is torn: {error}"
    return None
