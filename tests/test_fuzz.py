"""Does the frame of `make fuzz` see what breaks, and does every campaign survive a few seeds?"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.fuzz._process import Attempt, Process
from tests.fuzz._rounds import Campaign, campaigns_in, play

ROOT = Path(__file__).parents[1]

FEW = {"killed": 1, "divergence": 2}  # attempts, of campaigns that start many programs or make many worlds
# What they try is not how kernels are compiled, and compiling theirs takes longer than these attempts. Those on a line
# begin with the same worlds, and share a process.
INTERPRETED = (("bytes", "files", "bred"), ("divergence",), ("calls",), ("kept",), ("records",), ("saving",))
CAMPAIGNS = {campaign.name: campaign for campaign in campaigns_in("tests.fuzz")}
COMPILED = tuple((name,) for name in CAMPAIGNS if name not in sum(INTERPRETED, ()))

# Campaigns that break their promises, each in a way of its own.
BAD = {
    "aborts": "import os, sys\ndef attempt(seed):\n    if seed == 1: sys.stderr.write('last words\\n'); os.abort()",
    "hangs": "import time\ndef attempt(seed):\n    if seed == 1: time.sleep(1000)",
    "raises": "def attempt(seed):\n    return [][seed] if seed == 1 else None",
    "leaves": "import os\ndef attempt(seed):\n    if seed == 1: os._exit(3)",
    "says": "def attempt(seed):\n    return 'water is wet' if seed == 1 else None",
    "holds": "def attempt(seed):\n    pass",
}


@pytest.fixture
def bad(tmp_path, monkeypatch):
    """The name of a package of bad campaigns."""
    package = tmp_path / "bad_campaigns"
    package.mkdir()
    for name, source in BAD.items():
        (package / f"{name}.py").write_text(f'"""Promise of {name}."""\n{source}\n')
    (package / "_no_campaign.py").write_text("raise RuntimeError")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")]))
    return package.name


def test_a_crash_a_hang_an_exit_and_an_untyped_error_count_as_bad_with_their_seed(bad, monkeypatch):
    monkeypatch.setattr("tests.fuzz._process.FIRST", 1.0)
    campaigns = campaigns_in(bad)
    assert [campaign.name for campaign in campaigns] == sorted(BAD)
    play(campaigns, attempts=3, jobs=2, limit=2.0)
    assert {campaign.name: campaign.attempts for campaign in campaigns} == dict.fromkeys(BAD, 3)
    broken = {one.name: [(bad.attempt.seed, bad.broken) for bad in one.examples] for one in campaigns}
    assert broken.pop("holds") == []
    assert {seed for found in broken.values() for seed, _ in found} == {1}
    assert [len(found) for found in broken.values()] == [1] * 5
    assert broken["aborts"][0][1].startswith("crash: SIGABRT\nlast words")
    assert broken["hangs"][0][1].startswith("no end after 2 s")
    assert broken["leaves"][0][1].startswith("exit with 3")
    assert broken["raises"][0][1].startswith("IndexError: list index out of range (line 3 of")
    assert broken["says"][0][1] == "water is wet"


def test_an_attempt_that_takes_too_long_is_made_again_with_more_time(tmp_path, monkeypatch):
    (tmp_path / "compiles.py").write_text(
        "import pathlib, time\n"
        f"kept = pathlib.Path({str(tmp_path / 'kept')!r})\n"
        "def attempt(seed):\n"
        "    if seed == 1:\n"
        "        time.sleep(0 if kept.exists() else kept.write_text('x') + 1000)\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    campaign = Campaign("compiles", "", 0)
    play([campaign], attempts=3, limit=2.0)
    assert (campaign.attempts, campaign.bad, campaign.slow) == (3, 0, 1)


def _is_over(state):
    try:
        return state.read_text().split()[2] == "Z"
    except OSError:  # gone, perhaps between two looks
        return True


def _soon(what, seconds=10.0):
    """Tell whether it comes to be: what was killed runs on until the machine has time for it."""
    end = time.monotonic() + seconds
    while not (done := what()) and time.monotonic() < end:
        time.sleep(0.05)
    return done


def test_what_an_attempt_started_ends_with_it(tmp_path, monkeypatch):
    (tmp_path / "starts.py").write_text(
        "import subprocess, pathlib, os\n"
        "def attempt(seed):\n"
        "    child = subprocess.Popen(['sleep', '1000'])\n"
        f"    pathlib.Path({str(tmp_path / 'pid')!r}).write_text(str(child.pid))\n"
        "    os.abort()\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    process = Process(limit=10.0)
    try:
        process.make(Attempt("starts", 0))
        while (outcome := process.outcome()) is None:
            time.sleep(0.05)
        assert outcome.broken.startswith("crash")
        state = Path(f"/proc/{(tmp_path / 'pid').read_text()}/stat")
        assert _soon(lambda: _is_over(state))
    finally:
        process.end()


def run(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "tests.fuzz", *arguments], cwd=ROOT, capture_output=True, text=True, timeout=120
    )


def test_the_command_names_what_breaks_writes_totals_and_exits_with_1(bad, tmp_path):
    out = tmp_path / "totals.json"
    done = run("--package", bad, "--campaign", "says", "--campaign", "holds", "--attempts", "4", "--out", str(out))
    assert done.returncode == 1, done.stderr
    assert "✗ says: 1 bad of 4. Promise of says." in done.stdout
    assert "✓ holds: 0 bad of 4. Promise of holds." in done.stdout
    says = json.loads(out.read_text())["campaigns"]["says"]
    assert (says["attempts"], says["bad"], says["examples"][0]["seed"]) == (4, 1, 1)
    again = says["examples"][0]["again"].split()[3:]
    assert again == ["--package", bad, "--campaign", "says", "--seed", "1"]
    done = run(*again)
    assert (done.returncode, "1 bad of 1" in done.stdout) == (1, True)
    assert run("--package", bad, "--campaign", "says", "--seed", "2").returncode == 0


def test_an_interrupted_command_keeps_what_is_done(bad, tmp_path):
    out = tmp_path / "totals.json"
    command = [sys.executable, "-m", "tests.fuzz", "--package", bad, "--campaign", "holds", "--minutes", "5"]
    process = subprocess.Popen([*command, "--out", str(out)], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    time.sleep(6.0)
    process.send_signal(signal.SIGINT)
    said, _ = process.communicate(timeout=30)
    assert "interrupted" in said
    assert process.returncode == 0
    assert json.loads(out.read_text())["campaigns"]["holds"]["attempts"] > 0


def test_wrong_usage_is_refused_before_anything_is_tried(tmp_path):
    assert "no campaign 'none'" in run("--campaign", "none").stderr
    assert "no folder" in run("--out", str(tmp_path / "none" / "x.json")).stderr


@pytest.mark.parametrize("names", [*INTERPRETED, *COMPILED], ids="-".join)
def test_every_campaign_survives_a_few_seeds(names, monkeypatch):
    if names in INTERPRETED:
        monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")  # for the process of the attempts
    campaigns = [CAMPAIGNS[name] for name in names]
    attempts = FEW.get(names[0], 6)
    play(campaigns, attempts=attempts)
    assert [campaign.attempts for campaign in campaigns] == [attempts] * len(names)
    assert not any(campaign.examples for campaign in campaigns)
