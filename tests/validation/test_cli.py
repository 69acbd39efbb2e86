"""The command does what its exit codes say, and a crash or a missing engine is a row of the report."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from validation.record import read_report

ROOT = Path(__file__).parents[2]


def validate(*options: str, folder: Path = ROOT, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run `python -m validation` in a folder: without the compiler, for claims are few and small, unless told."""
    variables = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_DISABLE_JIT": "1", "COLUMNS": "140"}  # xdist says 80
    variables |= environment
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
    claims = "volume.tetrahedra", "volume.inertia_of_boxes"  # whose kernels are small
    done = validate(*(f"-k{name}" for name in claims), "--out", str(tmp_path), NUMBA_DISABLE_JIT="0")
    assert done.returncode == 0, done.stderr
    assert "2 holds, 0 fails, 0 not run" in done.stdout
    assert {path.name for path in tmp_path.iterdir()} == {"index.html", "badge.svg", "report.json", "junit.xml"}
    assert str(tmp_path / "index.html") in done.stdout
    assert [claim.verdict for claim in read_report(tmp_path / "report.json").claims] == ["holds", "holds"]


def test_the_same_seed_gives_the_same_numbers_and_another_seed_others(tmp_path: Path) -> None:
    def values(seed: int) -> list[float]:
        validate("-k", "rigid.thrown_box", "--seed", str(seed), "--out", str(tmp_path))
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
        (["replay", "rigid.thrown_bx"], "did you mean rigid.thrown_box"),
        (["replay", "rigid.thrown_box", "--case", "100000"], "there is no case 100000"),
        (["explain", "no such claim"], "no such claim"),
        (["--quiet", "explain", "rigid.thrown_box"], "takes no option 'quiet'"),
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


def test_list_names_every_claim_and_runs_none() -> None:
    done = validate("--list")
    assert done.returncode == 0
    assert "pressure.virial_identity" in done.stdout
    assert len(done.stdout.splitlines()) >= 40


def test_help_does_not_wait_for_numba() -> None:
    code = "import sys, validation.cli; sys.exit('numba' in sys.modules or 'matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT).returncode == 0


def test_the_exit_codes_are_in_the_help_and_in_the_docs() -> None:
    told = validate("--help").stdout
    page = (ROOT / "docs" / "judging.md").read_text(encoding="utf-8")
    for code in (0, 1, 2, 3, 4, 130):
        assert re.search(rf"^ +{code} +\w", told, re.M)
        assert re.search(rf"^\| {code} \|", page, re.M)


def test_replay_shows_inputs_both_answers_and_the_verdict_of_the_worst_case() -> None:
    done = validate("replay", "sat.depth")
    assert done.returncode == 0, done.stderr
    for word in ("(the worst)", "size_a", "orientation_b", "measured", "expected", "tolerance 1e-14", "holds"):
        assert word in done.stdout
    another = validate("replay", "sat.depth", "--case", "0", "--seed", "7")
    assert another.returncode == 0
    assert "case 0 of" in another.stdout


def test_replay_says_again_what_the_record_holds(tmp_path: Path) -> None:
    validate("-k", "impulse.one_impact_by_closed_form", "--out", str(tmp_path))
    (claim,) = read_report(tmp_path / "report.json").claims
    assert claim.worst is not None
    assert claim.worst.error == claim.value
    said = validate("replay", claim.id).stdout
    for number in (*claim.worst.measured, *claim.worst.inputs["point"], claim.worst.scale):
        assert f"{number:.17g}" in said.replace("\n", "")


def test_explain_says_all_that_is_declared() -> None:
    done = validate("explain", "sat.random_pairs")
    assert done.returncode == 0, done.stderr
    for word in ("FCL", "third-party engine", "outside FCL's own rounding band", "disagreements", "erratum E11",
                 "the last of fifteen axes left out", "6 if paper_axes_ else 14", "sat.py:"):  # fmt: skip
        assert word in done.stdout


def test_a_run_of_some_claims_leaves_the_full_report_alone(tmp_path: Path) -> None:
    full = tmp_path / "build" / "report"
    full.mkdir(parents=True)
    (full / "report.json").write_text("the full report")
    done = validate("-k", "rigid.thrown_box", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (full / "report.json").read_text() == "the full report"
    report = read_report(tmp_path / "build" / "report-k" / "report.json")
    assert report.patterns == ["rigid.thrown_box"]
    assert "validation -k rigid.thrown_box --seed" in (tmp_path / "build" / "report-k" / "index.html").read_text()
    commit = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout
    assert report.revision is None if not commit else commit.startswith((report.revision or "?").rstrip("+"))
