"""The command does what its exit codes say, and a crash or a missing engine is a row of the report."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from validation.record import read_report

ROOT = Path(__file__).parents[2]


def validate(*options: str, folder: Path = ROOT, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run `python -m validation` in a folder."""
    variables = {**os.environ, "PYTHONPATH": str(ROOT), **environment}
    command = [sys.executable, "-m", "validation", "--level", "quick", *options]
    return subprocess.run(command, cwd=folder, env=variables, capture_output=True, text=True, timeout=300)


@pytest.fixture
def without_fcl(tmp_path: Path) -> dict[str, str]:
    """Return an environment in which FCL seems not to be installed, in every process."""
    (tmp_path / "sitecustomize.py").write_text(
        "from importlib.machinery import PathFinder\n"
        "find = PathFinder.find_spec\n"
        "PathFinder.find_spec = classmethod(\n"
        "    lambda cls, name, *rest: None if name == 'fcl' else find(name, *rest)\n"
        ")\n"
    )
    return {"PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)])}


def test_claims_that_hold_end_with_0_and_leave_page_record_and_junit(tmp_path: Path) -> None:
    done = validate("-k", "rigid.", "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    assert "2 holds, 0 fails, 0 not run" in done.stdout
    assert {path.name for path in tmp_path.iterdir()} == {"index.html", "report.json", "junit.xml"}
    assert str(tmp_path / "index.html") in done.stdout
    assert [claim.verdict for claim in read_report(tmp_path / "report.json").claims] == ["holds", "holds"]


def test_the_same_seed_gives_the_same_numbers_and_another_seed_others(tmp_path: Path) -> None:
    def values(seed: int) -> list[float]:
        validate("-k", "rigid.", "--seed", str(seed), "--out", str(tmp_path))
        return [claim.value for claim in read_report(tmp_path / "report.json").claims]

    first = values(1)
    assert values(1) == first
    assert values(2) != first


@pytest.mark.parametrize(
    ("options", "culprit"),
    [
        (["-k", "no such claim"], "no such claim"),
        (["--level", "silly"], "silly"),
        (["--seed", "-1"], "-1"),
        (["--jobs", "0"], "0"),
        (["--require", "fortune teller"], "fortune teller"),
        (["-k", "rigid.", "--out", "/dev/null/report"], "/dev/null/report"),
        (["--nonsense"], "--nonsense"),
    ],
)
def test_wrong_usage_ends_with_2_and_names_the_culprit(options: list[str], culprit: str) -> None:
    done = validate(*options)
    assert done.returncode == 2
    assert culprit in done.stderr


def test_a_missing_engine_is_not_run_and_the_others_go_on(tmp_path: Path, without_fcl: dict[str, str]) -> None:
    out = tmp_path / "out"
    done = validate("-k", "sat.depth", "-k", "rigid.thrown_box", "--out", str(out), **without_fcl)
    assert done.returncode == 0
    verdicts = {claim.id: (claim.verdict, claim.why) for claim in read_report(out / "report.json").claims}
    assert verdicts == {"sat.depth": ("not run", "fcl is not installed"), "rigid.thrown_box": ("holds", None)}


@pytest.mark.parametrize("demand", [["--require-all"], ["--require", "fcl"]])
def test_a_demanded_engine_that_is_missing_ends_with_3(
    demand: list[str], tmp_path: Path, without_fcl: dict[str, str]
) -> None:
    done = validate("-k", "sat.depth", *demand, "--out", str(tmp_path / "out"), **without_fcl)
    assert done.returncode == 3
    assert "fcl" in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_crash_or_a_wait_fails_its_claim_and_no_other(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "validation", tmp_path / "validation", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "validation" / "checks" / "aaa.py").write_text(
        "import os\n"
        "from validation.check import Comparison, check\n"
        "from validation.fault import Fault\n"
        "words = dict.fromkeys(('family', 'section', 'piece', 'reference', 'because', 'detects'), 'crash')\n"
        "words |= {'least': 1, 'kind': 'invariant'}\n"
        "words['faults'] = (Fault('a fault', 'softbody.world.PRECISIONS', 'x_', 'None'),)\n"
        "@check(claim='This one dies.', tolerance=0.0, **words)\n"
        "def dies(run):\n"
        "    os.abort()\n"
        "@check(claim='This one lives.', tolerance=0.0, **words)\n"
        "def lives(run):\n"
        "    return Comparison([1.0], [1.0])\n"
        "@check(claim='This one hangs.', tolerance=0.0, **words)\n"
        "def waits(run):\n"
        "    import time\n"
        "    time.sleep(1e6)\n"
    )
    runner = tmp_path / "validation" / "runner.py"
    runner.write_text(re.sub(r'"quick": [\d.]+', '"quick": 20.0', runner.read_text()))
    done = validate("-k", "aaa.", "--jobs", "1", "--level", "quick", "--out", "out", folder=tmp_path)
    assert done.returncode == 1
    claims = json.loads((tmp_path / "out" / "report.json").read_text())["claims"]
    assert [(claim["id"], claim["verdict"], claim["why"]) for claim in claims] == [
        ("aaa.dies", "fails", "the process crashed"),
        ("aaa.lives", "holds", None),
        ("aaa.waits", "fails", "it was not done after 20 s"),
    ]


def test_ctrl_c_keeps_what_is_done(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "validation", "--no-timings", "--jobs", "1", "--out", str(tmp_path)]
    # (What is started in the background of a script hears no SIGINT, nor does what it starts.)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    running = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True, start_new_session=True)
    signal.signal(signal.SIGINT, before)
    assert running.stderr is not None
    for line in running.stderr:
        if line.startswith("✓"):
            break
    os.killpg(running.pid, signal.SIGINT)
    # While a world is compiled, some minutes on a busy machine, no signal is heard.
    running.communicate(timeout=480)
    assert running.returncode == 130
    claims = read_report(tmp_path / "report.json").claims
    whys = {claim.why for claim in claims if claim.verdict == "not run"}
    assert whys == {"interrupted"}
    assert any(claim.verdict == "holds" for claim in claims)
    assert (tmp_path / "index.html").exists()


def test_list_names_every_claim_and_runs_none() -> None:
    done = validate("--list")
    assert done.returncode == 0
    assert "pressure.virial_identity" in done.stdout
    assert len(done.stdout.splitlines()) >= 40


def test_help_does_not_wait_for_numba() -> None:
    code = "import sys, validation.cli; sys.exit('numba' in sys.modules or 'matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT).returncode == 0
