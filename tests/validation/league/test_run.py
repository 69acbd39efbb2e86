"""A league is kept whatever its engines do: one that aborts, hangs, floods or answers NaN costs its own cells."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.validation.test_plug_ins import install

ROOT = Path(__file__).parents[3]
HEAD = '"""A toy."""\nimport numpy as np\nCANNOT = {"boxes_overlap": "it has none"}\n'
ASK = "\n\ndef points_in_mesh(points, vertices, triangles):\n    "
TOYS = {
    "sound": "from references import igl\n" + ASK + "return igl.points_in_mesh(points, vertices, triangles)",
    "liar": ASK + "return np.ones(len(points), bool)",
    "aborts": "import os\n" + ASK + "os.abort()",
    "hangs": "import time\n" + ASK + "time.sleep(1e6)",
    "floods": ASK + "print('x' * 10_000_000)\n    raise ValueError('y' * 1_000_000)",
    "nan": ASK + "return np.full(len(points), np.nan)",
    "old": "import acme_of_next_year\n" + ASK + "return None",
}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    points = "[softbody.subjects]\n" + "".join(f"toy_{name} = acme_toys.{name}\n" for name in TOYS)
    install(folder, "acme_toys", {name: HEAD + text for name, text in TOYS.items()}, points)
    return folder


def league(site: Path, *options: str) -> subprocess.CompletedProcess[str]:
    variables = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(site)]), "NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-m", "validation.league", "--level", "quick", *options]
    return subprocess.run(command, env=variables, cwd=ROOT, capture_output=True, text=True, timeout=300)


@pytest.fixture(scope="module")
def played(site: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("igl")
    out = tmp_path_factory.mktemp("league")
    chosen = [word for name in TOYS for word in ("--engine", f"toy_{name}")]
    done = league(site, "-k", "inside.anywhere", "-k", "overlap.at", *chosen, "--limit", "8", "--out", str(out))
    assert done.returncode == 0, done.stderr
    return out


def test_each_engine_has_its_own_fate(played: Path) -> None:
    record = json.loads((played / "league.json").read_text(encoding="utf-8"))
    fate = {(cell["engine"], cell["task"]): cell for cell in record["cells"]}
    states = {name: fate[f"toy_{name}", "inside.anywhere"]["state"] for name in TOYS}
    assert states == {
        "sound": "answered",
        "liar": "answered",
        "aborts": "fails",
        "hangs": "fails",
        "floods": "fails",
        "nan": "fails",
        "old": "not run",
    }
    assert fate["toy_sound", "inside.anywhere"]["error"] == 0.0
    assert 0.1 < fate["toy_liar", "inside.anywhere"]["error"] < 0.99
    assert "SIGABRT" in fate["toy_aborts", "inside.anywhere"]["why"]
    assert "after 8 s" in fate["toy_hangs", "inside.anywhere"]["why"]
    assert len(fate["toy_floods", "inside.anywhere"]["why"]) < 2_500
    assert fate["toy_sound", "overlap.at_random"]["why"] == "it has none"
    page = (played / "index.html").read_text(encoding="utf-8")
    assert "2 engines at 2 tasks" in page
    assert "SIGABRT" in page


def test_a_run_that_was_cut_short_goes_on(site: Path, played: Path) -> None:
    chosen = ["--engine", "toy_sound", "--engine", "toy_liar", "-k", "inside.anywhere", "--out", str(played)]
    journal = played / "league.jsonl"
    lines = journal.read_text(encoding="utf-8").splitlines()
    kept = [lines[0], *(line for line in lines[1:] if '"toy_liar"' in line)]
    journal.write_text("\n".join(kept) + '\n{"task": "inside.any', encoding="utf-8")
    done = league(site, *chosen, "--resume")
    assert done.returncode == 0, done.stderr
    record = json.loads((played / "league.json").read_text(encoding="utf-8"))
    assert {cell["engine"] for cell in record["cells"]} == {"toy_sound", "toy_liar"}
    assert json.loads(kept[1]) in record["cells"], "this one was not asked again: its seconds are the same"
    other = league(site, *chosen, "--resume", "--seed", "7")
    assert other.returncode == 2
    assert "is of another run" in other.stderr


def test_an_interrupt_leaves_a_page_of_what_is_done(site: Path, tmp_path: Path) -> None:
    variables = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(site)]), "NUMBA_DISABLE_JIT": "1"}
    chosen = ["--engine", "toy_sound", "--engine", "toy_hangs", "-k", "inside.anywhere", "--out", str(tmp_path)]
    command = [sys.executable, "-m", "validation.league", "--level", "quick", "--jobs", "2", *chosen]
    process = subprocess.Popen(command, env=variables, cwd=ROOT, stderr=subprocess.PIPE, text=True)
    journal = tmp_path / "league.jsonl"
    while process.poll() is None and (not journal.is_file() or '"state"' not in journal.read_text(encoding="utf-8")):
        time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=100)
    assert process.returncode == 130, said
    assert "--resume goes on" in said
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "1 cells were not played" in page
    assert json.loads((tmp_path / "league.json").read_text(encoding="utf-8"))["left"] == 1


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["-k", "no such task"], "no task's id contains"),
        (["--engine", "joltt"], "did you mean jolt?"),
        (["--limit", "0"], "--limit"),
        (["--out", "/proc/nowhere"], "/proc/nowhere"),
    ],
)
def test_wrong_usage_is_said_before_anything_runs(site: Path, options: list[str], said: str) -> None:
    done = league(site, "-k", "inside.anywhere", *options) if "-k" not in options else league(site, *options)
    assert done.returncode in (2, 4)
    assert said in done.stderr
    assert "Traceback" not in done.stderr
