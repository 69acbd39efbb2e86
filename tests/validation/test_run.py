"""A run is never lost: claims are on disk as they end, a run that was cut short goes on, and what cut it is said.

Runs that are killed: `tests/fuzz/killed.py`.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from validation.check import all_checks
from validation.journal import NAME, CannotRunHereError, Journal
from validation.judge import blank_record
from validation.record import read_report

ROOT = Path(__file__).parents[2]

CLAIMS = """
import time
from validation.check import Comparison, check
from validation.fault import Fault

words = dict.fromkeys(("section", "piece", "reference", "because"), "some")
fault = Fault("a fault", "softbody.world.PRECISIONS", "x_ → None")

def declare(number):
    def compare(run):
        time.sleep({seconds})
        answers = run.fresh_rng().random(1_000)
        return Comparison(answers, answers + 1e-12 * run.fresh_rng().normal(size=1_000), inputs={{"answer": answers}})
    compare.__name__, compare.__doc__ = f"one_{{number}}", "One of many."
    check(family=f"family {{number % 3}}", tolerance=1e-9, kind="invariant", faults=(fault,),
          **words)(compare)

for number in range({count}):
    declare(number)
"""


def make_place(folder: Path, count: int = 9, seconds: float = 0.0) -> Path:
    """Make a folder with claims of our own, which take so long; return it.

    Byte code comes along: the copies are as old as the files themselves.
    """
    shutil.copytree(ROOT / "validation", folder / "validation", ignore=shutil.ignore_patterns("checks", "*.pyc.*"))
    checks = folder / "validation" / "checks"
    checks.mkdir()
    (checks / "__init__.py").touch()
    (checks / "many.py").write_text(CLAIMS.format(count=count, seconds=seconds))
    return folder


@pytest.fixture
def place(tmp_path):
    """Return a function that makes such a folder."""
    return partial(make_place, tmp_path)


def command(*options: str, before: str = "") -> list[str]:
    """Return the command of a run without timings; `before` is Python that is run first."""
    code = f"{before}\nfrom validation.cli import main; main()"
    return [sys.executable, "-c", code, "--level", "quick", "--no-timings", *options]


def variables() -> dict[str, str]:
    """Return an environment without the compiler: these claims have nothing to compile, and start sooner without."""
    return {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_DISABLE_JIT": "1"}


def run(folder: Path, *options: str, before: str = "") -> subprocess.CompletedProcess[str]:
    """Run the validation in a folder."""
    return subprocess.run(
        command(*options, before=before), cwd=folder, env=variables(), capture_output=True, text=True, timeout=300
    )


def results(folder: Path) -> list[dict]:
    """Return all of a report's claims but how long they took."""
    claims = json.loads((folder / "report.json").read_text())["claims"]
    return [{**claim, "seconds": 0.0} for claim in claims]


def lines(path: Path) -> list[dict]:
    """Return the whole lines of a journal but the first; each must be JSON."""
    return [json.loads(line) for line in path.read_bytes().split(b"\n")[:-1]][1:]


def test_results_are_the_same_for_any_number_of_workers(place):
    folder = place()
    for workers in ("1", "3"):
        assert run(folder, "--workers", workers, "--out", workers).returncode == 0
    assert results(folder / "1") == results(folder / "3")


@pytest.fixture(scope="module")
def cut_once(tmp_path_factory):
    """A folder with a run that was cut short by Ctrl-C after a few claims, and what it said; not to be changed."""
    folder = make_place(tmp_path_factory.mktemp("cut"), seconds=0.4)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    running = subprocess.Popen(
        command("--out", "out", "--workers", "2"), cwd=folder, env=variables(), stderr=subprocess.PIPE, text=True,
        stdout=subprocess.PIPE,
    )  # fmt: skip
    signal.signal(signal.SIGINT, before)
    assert running.stderr is not None
    for _ in range(2):
        running.stderr.readline()
    running.send_signal(signal.SIGINT)
    _, err = running.communicate(timeout=100)
    assert running.returncode == 130, err
    return folder, err


@pytest.fixture
def cut(cut_once, tmp_path):
    """A copy of that folder."""
    return shutil.copytree(cut_once[0], tmp_path / "copy")


def test_ctrl_c_keeps_what_is_done_and_names_what_was_running(cut_once, cut):
    folder, err = cut, cut_once[1]
    claims = read_report(folder / "out" / "report.json").claims
    running = [claim.id for claim in claims if claim.why == "interrupted while it ran"]
    assert 1 <= len(running) <= 2
    assert f"Interrupted in the claims, at {', '.join(sorted(running))}" in err
    assert "--resume" in err
    assert sum(claim.verdict == "holds" for claim in claims) >= 2
    assert {claim.why for claim in claims} == {None, "interrupted while it ran", "interrupted before it began"}
    assert (folder / "out" / "index.html").exists()
    assert (folder / "out" / "junit.xml").exists()
    done = run(folder, "--out", "out", "--resume")
    assert done.returncode == 0, done.stderr
    assert all(claim.verdict == "holds" for claim in read_report(folder / "out" / "report.json").claims)


@pytest.mark.parametrize(
    ("change", "options", "why"),
    [
        ("level", ["--level", "standard"], "of level quick"),
        ("seed", ["--seed", "5"], "of seed 20080101"),
        ("claims", [], "of other claims or references"),
        ("core", [], "of another core"),
        ("engines", [], "judged by other versions of numpy"),
        ("journal", [], "is no journal of a run"),
        ("line", [], "line 2, is damaged"),
        ("nothing", [], "no run was cut short there"),
    ],
)
def test_a_run_of_other_things_is_not_resumed_and_the_reason_is_said(cut, change, options, why):
    folder = cut
    journal = folder / "out" / NAME
    text = journal.read_text()
    head, rest = text.split("\n", 1)
    first = json.loads(head)
    if change == "claims":
        (folder / "validation" / "checks" / "more.py").touch()
    elif change == "core":
        first["core"] = "0" * 64
    elif change == "engines":
        first["engines"]["numpy"] = "0.1"
    elif change == "line":
        rest = '{"id": 1}\n' + rest
    journal.write_text("x\n" if change == "journal" else json.dumps(first) + "\n" + rest)
    if change == "nothing":
        journal.unlink()
    before = journal.read_text() if journal.exists() else None
    done = run(folder, "--out", "out", "--resume", *options)
    assert done.returncode == 2
    assert why in " ".join(done.stderr.split())
    assert (journal.read_text() if journal.exists() else None) == before


def test_a_run_is_gone_on_with_by_more_draws(cut):
    folder = cut
    done = run(folder, "--out", "out", "--resume", "--draws", "2", "--workers", "2")
    assert done.returncode == 0, done.stderr
    assert "of 18 claims, by seeds of their own, have been judged before" in done.stderr
    assert all(claim.draws == 2 and claim.n == 2_000 for claim in read_report(folder / "out" / "report.json").claims)


def test_a_new_run_keeps_what_an_unfinished_one_has_left(cut):
    folder = cut
    left = (folder / "out" / NAME).read_bytes()
    done = run(folder, "--out", "out", "-k", "one_1")
    assert "they are kept in out/claims.before.jsonl" in done.stderr
    assert (folder / "out" / "claims.before.jsonl").read_bytes() == left


def test_a_line_that_was_cut_off_is_not_taken_and_not_left(tmp_path):
    head = {"schema": "softbody-claims/1", "level": "quick", "seed": 1, "core": "a", "claims": "b", "engines": {}}
    one, two = (blank_record(check, 1) for check in list(all_checks().values())[:2])
    with Journal(tmp_path, head, False, print) as journal:
        journal.add(one)
    path = tmp_path / NAME
    path.write_bytes(path.read_bytes() + b'{"id": "half a li')
    with Journal(tmp_path, head, True, print) as journal:
        assert list(journal.records) == [(one.id, 1)]
        journal.add(two)
    assert [line["id"] for line in lines(path)] == [one.id, two.id]


def test_two_runs_at_once_in_one_folder_are_refused(tmp_path):
    head = {"schema": "softbody-claims/1", "level": "quick", "seed": 1, "core": "a", "claims": "b", "engines": {}}
    with Journal(tmp_path, head, False, print), pytest.raises(CannotRunHereError, match="another run is writing"):
        Journal(tmp_path, head, False, print)


# No file may have more bytes than that, as if the disk were full then. Byte code is not written: Python before 3.14
# keeps what fits of it, and fails to import that.
FULL = """
import os, resource, sys
sys.dont_write_bytecode, os.environ["PYTHONDONTWRITEBYTECODE"] = True, "1"
resource.setrlimit(resource.RLIMIT_FSIZE, (12_000, 12_000))
"""


def test_a_disk_that_is_full_ends_with_4_and_keeps_what_was_done(place):
    folder = place(count=9)
    done = run(folder, "--out", "out", before=FULL)
    kept = len(lines(folder / "out" / NAME))
    assert 1 <= kept < 9
    assert done.returncode == 4, done.stderr
    assert "File too large" in done.stderr
    assert f"{kept} claims are kept" in done.stderr
    assert "--resume" in done.stderr
    done = run(folder, "--out", "out", "--resume")
    assert done.returncode == 0, done.stderr
    assert f"{kept} of 9 claims have been judged before" in done.stderr


@pytest.mark.parametrize("what", ["a file in the way", "a folder in place of the page", "no permission"])
def test_a_folder_that_cannot_be_written_ends_with_4_before_any_work(place, what):
    folder = place(count=3)
    out, before = folder / "out", ""
    if what == "a file in the way":
        (folder / "file").touch()
        out = folder / "file" / "out"
    elif what == "a folder in place of the page":
        (out / "index.html").mkdir(parents=True)
    else:  # root may write anywhere
        before = (
            "from pathlib import Path\n"
            "def refuse(*_): raise PermissionError(13, 'Permission denied')\n"
            "Path.write_bytes = refuse"
        )
    done = run(folder, "--out", str(out), before=before)
    assert done.returncode == 4, done.stderr
    assert "choose another" in done.stderr
    assert "✓" not in done.stderr


# In place of timings and scenes, which take minutes.
PARTS = """
import math, os, signal, sys, types, validation.run as run, validation.startup as startup, validation.timings as timings
scenes = {{"one": 1}}
sys.modules["validation.pictures"] = types.SimpleNamespace(SCENES=[], make_picture=math.sqrt)
sys.modules["validation.behaviour"] = types.SimpleNamespace(SCENES=scenes, SHOTS="shots", behaviours_of=math.sqrt)
startup.measure_startup = lambda level: []
timings.measure_timings = lambda level: {timings}
def cut(lanes, jobs, started):
    started("one")
    os.kill(os.getpid(), signal.SIGINT)
    yield
{more}
"""


@pytest.mark.parametrize(
    ("timings", "more", "part"),
    [
        ("os.kill(os.getpid(), signal.SIGINT)", "", "the timings"),
        ("([], [], 'none here')", "run.run_tasks = cut", "the films, at one"),
    ],
)
def test_ctrl_c_in_timings_and_films_keeps_all_verdicts(place, timings, more, part):
    folder = place(count=3)
    done = run(folder, "--out", "out", "--timings", before=PARTS.format(timings=timings, more=more))
    assert done.returncode == 130, done.stderr
    assert f"Interrupted in {part}" in done.stderr
    assert [claim["verdict"] for claim in results(folder / "out")] == ["holds"] * 3
    assert (folder / "out" / "index.html").exists()
    assert len(lines(folder / "out" / NAME)) == 3  # so that --resume makes the rest


def test_what_fails_beside_the_claims_costs_no_verdict(place):
    folder = place(count=3)
    done = run(folder, "--out", "out", "--timings", before=PARTS.format(timings="1 / 0", more=""))
    assert done.returncode == 0, done.stderr
    assert "rules: shots is left out: raised TypeError" in done.stderr
    report = read_report(folder / "out" / "report.json")
    assert report.timings_why == "ZeroDivisionError: division by zero"


def test_quiet_says_the_sum_and_no_more(place):
    done = run(place(count=3), "--out", "out", "--quiet")
    assert done.stderr == ""
    assert done.stdout.splitlines()[0].startswith("3 holds, 0 fails, 0 not run")
