"""The commands, on a repository whose core is one function: what they say, and how they end."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from click.testing import CliRunner

from benchmarks import cli, cores, instructions
from benchmarks.calibration import Calibration
from benchmarks.history import History, Record
from benchmarks.machine import machine_here

ROOT = Path(__file__).parents[2]

BENCHMARKS = """
import softbody
from benchmarks.suite import Benchmark, Row

@Benchmark(Row("t", "bodies", "call"), usual=True)
def bench_work(race):
    race(softbody.work, 1, size=1)

@Benchmark(Row("t", "bodies", "call"), sizes={"quick": [2], "standard": [2, 3]}, usual=[3])
def bench_new(race, size):
    race(softbody.new, 1, size=size)
"""
WORK = "def work():\n    return sum(k * k for k in range({count})){more}\n"
NEW = "def new():\n    return 1\n"
CORES = {  # revision → the core
    "first": WORK.format(count=20_000, more=""),
    "commented": "# the same\n" + WORK.format(count=20_000, more="") + NEW,
    "slower": WORK.format(count=20_000, more=" + 0 * sum(k * k for k in range(6_000))") + NEW,
    "other": WORK.format(count=20_000, more=" + 1") + NEW,
    "broken": "def work(:\n",
}


@pytest.fixture(scope="module")
def repository(tmp_path_factory):
    """Return a repository with a tag for every core."""
    root = tmp_path_factory.mktemp("repository")
    for folder in ("softbody", "benchmarks/suite"):
        (root / folder).mkdir(parents=True)
    for file in (
        "__init__.py",
        "conftest.py",
        "machine.py",
        "older.py",
        "race.py",
        "serving.py",
        "goals.py",
        "running.py",
        "suite/__init__.py",
    ):
        shutil.copy(ROOT / "benchmarks" / file, root / "benchmarks" / file)
    (root / "benchmarks" / "suite" / "bench_tiny.py").write_text(BENCHMARKS)
    (root / "softbody" / "compiler").mkdir()
    (root / "softbody" / "compiler" / "core_digest.py").write_text("CORE_DIGEST, FLAGS = '', ()\n")
    (root / "pyproject.toml").write_text((ROOT / "pyproject.toml").read_text())
    who = {"GIT_AUTHOR_NAME": "x", "GIT_AUTHOR_EMAIL": "x", "GIT_COMMITTER_NAME": "x", "GIT_COMMITTER_EMAIL": "x"}

    def git(*arguments):
        subprocess.run(["git", "-C", str(root), *arguments], check=True, capture_output=True, env=os.environ | who)

    git("init", "--quiet")
    for revision, core in CORES.items():
        (root / "softbody" / "__init__.py").write_text(core)
        git("add", ".")
        git("commit", "--quiet", "-m", revision)
        git("tag", revision)
    git("rm", "-r", "--quiet", "softbody")
    git("commit", "--quiet", "-m", "empty")
    git("tag", "empty")
    git("checkout", "--quiet", "first")
    return root


@pytest.fixture
def bench(repository, tmp_path, monkeypatch):
    """Return a function that runs a command on the repository."""
    monkeypatch.setattr(cli, "ROOT", repository)
    monkeypatch.setattr(cli, "STORE", tmp_path)
    monkeypatch.setenv("COLUMNS", "140")

    def bench(*arguments):
        return CliRunner().invoke(cli.main, [*arguments, "--history", str(tmp_path / "history.sqlite")])

    return bench


def test_a_slower_revision_is_found_and_one_without_the_benchmark_said(bench):
    done = bench("compare", "first", "slower", "-k", "bench", "--budget", "60s", "--fail-slower", "5%")
    assert done.exit_code == 1, done.output
    row = next(line for line in done.output.splitlines() if "│" in line)
    assert "bench_tiny.py::bench_w" in row
    assert "slower" in row
    assert "bench_new[2]: not compared, first cannot run it: AttributeError" in done.output


@pytest.mark.skipif(not shutil.which("valgrind") or not shutil.which("cc"), reason="no valgrind, or no compiler")
def test_instructions_are_a_witness_without_noise(bench):
    compare = ("--budget", "1s", "--instructions", "-k", "work")
    more = bench("compare", "commented", "slower", *compare).output
    found = re.search(r"× (\d\.\d{4}) ", more)
    assert found, more
    assert 1.2 < float(found[1]) < 1.4  # 6 000 additions more than 20 000
    assert "× 1.0000 " in bench("compare", "first", "commented", *compare).output


@pytest.mark.parametrize("missing", ["valgrind", "compiler"])
def test_where_instructions_cannot_be_counted_it_is_said_why(bench, monkeypatch, missing):
    there = shutil.which("git") if missing == "compiler" else None
    monkeypatch.setattr(instructions.shutil, "which", lambda name: there if name == "valgrind" else None)
    monkeypatch.setattr(instructions.platform, "machine", lambda: "x86_64")
    done = bench("compare", "first", "commented", "-k", "work", "--budget", "1s", "--instructions")
    assert done.exit_code == 0, done.output
    assert f"instructions are not counted: there is no {missing.replace('comp', 'C comp')}" in done.output


def test_an_interrupted_count_leaves_the_verdicts(bench, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(instructions, "count", interrupted)
    done = bench("compare", "first", "commented", "-k", "work", "--budget", "1s", "--instructions")
    assert done.exit_code == 0
    assert "instructions are not counted: interrupted" in done.output
    assert "no difference shown" in done.output


def test_a_gate_says_how_much_it_sees_here(bench, tmp_path):
    series = {"0": {"bench": [[0.0] * 4] * 15}, "3": {"bench": [[0.03] * 4] * 15}}
    found = Calibration("2030-01-01T00:00:00", "abc", 1.5, 60.0, series)
    record = Record("calibration", found.started, machine_here(), found.document())
    History(tmp_path / "history.sqlite").add([record])
    gate = ("compare", "commented", "first", "-k", "work", "--budget", "1s", "--fail-slower", "2%")
    assert "--fail-slower 2% stops, by that calibration, 0.0 % of benchmarks as fast as before" in bench(*gate).output
    assert "--fail-slower" not in bench(*gate[:-2]).output


def test_other_answers_fail(bench):
    done = bench("compare", "commented", "other", "-k", "work", "--budget", "1s")
    assert done.exit_code == 1, done.output
    assert "answers differ by 3.8e-13" in done.output


def test_the_working_tree_is_a_side_and_what_is_not_committed_is_named(bench, repository):
    core = repository / "softbody" / "__init__.py"
    kept = core.read_text()
    core.write_text(CORES["commented"])
    try:
        done = bench("compare", "first", ".", "-k", "work", "--budget", "1s")
    finally:
        core.write_text(kept)
    assert done.exit_code == 0, done.output
    assert "with changes that are not committed" in done.output


def test_without_a_pattern_the_usual_ones_of_the_level_are_compared(bench):
    compare = ("compare", "first", "commented", "--budget", "1s")
    assert "bench_new" not in bench(*compare).output
    output = bench(*compare, "--level", "standard").output
    assert "bench_new[3]: not compared, first cannot run it" in output
    assert "bench_new[2]" not in output


def test_old_cores_are_removed_and_that_is_said(bench, tmp_path, monkeypatch):
    for number in range(4):
        (tmp_path / "cores" / f"{number:016x}").mkdir(parents=True)
    monkeypatch.setattr(cores, "KEPT", 3)
    done = bench("compare", "first", "commented", "-k", "no such benchmark")
    assert "removed 3 of the cores" in done.output
    assert "the newest 3 are kept" in done.output
    assert len(list((tmp_path / "cores").iterdir())) == 3


def test_a_side_that_does_not_start_is_named_with_the_reason(bench):
    done = bench("compare", "first", "broken", "-k", "work", "--budget", "1s")
    assert done.exit_code == 1
    assert "broken cannot run it: SyntaxError" in done.output


def test_a_plan_that_cannot_begin_is_an_error(bench):
    done = bench("compare", "first", "commented", "-k", "no such benchmark")
    assert done.exit_code == 2
    assert "no benchmark at level quick matches 'no such benchmark'" in done.output


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("compare", "nowhere", "."), "there is no revision 'nowhere' here"),
        (("compare", "--", "-x", "."), "there is no revision '-x' here"),
        (("compare", "empty", "."), "empty has no softbody/"),
        (("compare", ".", ".", "--budget", "5"), "'5' is no duration; write 90s, 5m or 1h"),
        (("compare", ".", ".", "--fail-slower", "much"), "'much' is no share; write 3% or 0.03"),
        (("compare", "."), "Missing argument 'B'"),
    ],
)
def test_wrong_usage_names_the_culprit_and_ends_with_2(bench, arguments, said):
    done = CliRunner().invoke(cli.main, list(arguments))
    assert (done.exit_code, said in done.output) == (2, True), done.output


def test_history_shows_what_was_imported_and_names_other_machines(bench, make_document, tmp_path):
    file = tmp_path / "runs.jsonl"
    file.write_text("".join(json.dumps(make_document(f"2030-01-0{day}")) + "\n" for day in range(1, 4)))
    assert "3 new" in bench("import", str(file)).output
    assert "0 new" in bench("import", str(file)).output
    here = bench("history")
    assert here.exit_code == 1
    machine = here.output.split("machines there: ")[1].strip()
    shown = bench("history", "x[42]", "--machine", machine, "--plot", str(tmp_path / "trends.svg"))
    assert "bench_x.py::bench_x[42]: 0.500 × a peer" in shown.output
    assert (tmp_path / "trends.svg").exists()
    written = bench("history", "--machine", machine, "--json", str(tmp_path / "trends.json"))
    assert written.exit_code == 0, written.output
    assert len(json.loads((tmp_path / "trends.json").read_text())["trends"][0]["values"]) == 3
    published = bench("publish", str(tmp_path / "site"), "--machine", machine)
    assert published.output.strip() == str(tmp_path / "site" / "trends.html")
    assert "Too few runs to see a step: " in (tmp_path / "site" / "trends.html").read_text()
    assert "1 of them" in bench("export", str(tmp_path / "newest.json")).output


@pytest.mark.parametrize("arguments", [("history",), ("goals",), ("publish", "site")])
def test_an_empty_history_names_the_cure(bench, arguments, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = bench(*arguments)
    assert done.exit_code == 1
    assert "`python -m benchmarks run` measures something" in done.output
    assert not (tmp_path / "site").exists()
