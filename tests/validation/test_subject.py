"""Another engine is judged as the core is, by the same cases and tolerances; a wrong answer turns each claim red."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from validation import subject
from validation.check import Run
from validation.judge import judge
from validation.record import FAILS, HOLDS, NOT_RUN
from validation.subject import Motion, SoftMotion, SoftScene, checks_of, find_check, subjects

ROOT = Path(__file__).parents[2]


def validate(*options: str) -> subprocess.CompletedProcess[str]:
    """Run `python -m validation`, without the compiler: it is the others who are judged."""
    variables = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_DISABLE_JIT": "1", "COLUMNS": "200"}
    command = [sys.executable, "-m", "validation", "--level", "quick", *options]
    return subprocess.run(command, env=variables, cwd=ROOT, capture_output=True, text=True, timeout=300)


def test_an_engine_has_its_own_record_page_and_exit_code(tmp_path: Path) -> None:
    pytest.importorskip("rapier3d")
    claims = ["boxes.slide", "boxes.fly", "gas.rest"]
    done = validate("--subject", "rapier3d", *(f"-k{name}" for name in claims), "--out", str(tmp_path))
    assert done.returncode == 1, done.stderr
    report = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    assert report["subject"]["name"] == "rapier3d"
    fate = {claim["id"].partition(":")[2]: claim for claim in report["claims"]}
    assert {name: fate[name]["verdict"] for name in claims} == dict(zip(claims, ("holds", "fails", "not run")))
    assert 1e-8 < fate["boxes.fly"]["value"] < 1e-3, "single precision"
    assert "no gas" in fate["gas.rest"]["why"]
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert f"rapier3d {report['subject']['version']}: 3 of " in page, "a run of some claims says so first"
    assert "1 of 3 claims FAILS" in page
    assert "not softbody" in page
    assert "one thread" in page, "settings are on the page"
    assert 'id="errata"' not in page


def test_the_same_cases_are_asked_of_everybody() -> None:
    checks = {name: set(one.partition(":")[2] for one in checks_of(name)) for name in subjects()}
    assert len({frozenset(ids) for ids in checks.values()}) == 1
    seen = []
    name = "inside.anywhere"
    claim = subject.CLAIMS[name]

    def ask(points: np.ndarray, *_: np.ndarray) -> np.ndarray:
        seen.append(points)
        return np.zeros(len(points), bool)

    for who in ("softbody", "igl"):
        run = Run("quick", 1, f"{who}:{name}")
        claim.compare(replace(run, check_id=claim.check.id), ask)
    half = len(seen) // 2
    assert all(np.array_equal(a, b) for a, b in zip(seen[:half], seen[half:]))


@pytest.mark.parametrize("who", sorted(subjects()))
def test_a_subject_answers_what_it_can_and_says_of_the_rest_why_not(who: str) -> None:
    first = {"move_boxes": "boxes.fly", "boxes_overlap": "overlap.at_random", "gas_volume": "gas.rest"}
    first |= {"gas_period": "gas.breathe", "points_in_mesh": "inside.anywhere", "move_soft": "soft.fall"}
    adapter = subjects()[who]
    for question, claim in first.items():
        assert (question in adapter.functions) != (question in adapter.cannot)
        check = find_check(f"{who}:{claim}")
        if not check.hindrance:
            record = judge(check, Run("quick", 2, check.id))
            if record.verdict == NOT_RUN:
                pytest.skip(str(record.why))
            assert record.verdict in (HOLDS, FAILS), record.why
            assert record.value is not None
            assert record.value < 0.1, "as good as single precision at least"


def frozen(answer: Callable) -> Callable:
    """Return an engine that leaves everything where it is."""

    def ask(*arguments):
        scene, _, steps, every = arguments
        frames = steps // every
        boxes = scene.boxes if isinstance(scene, SoftScene) else scene
        still = Motion(*(np.array([getattr(boxes, name)] * frames) for name in Motion._fields))
        if boxes is scene:
            return still
        places = tuple(np.array([body.vertices] * frames) for body in scene.bodies)
        return SoftMotion(places, tuple(np.array([rows] * frames) for rows in scene.velocity), still)

    return ask


def ghostly(answer: Callable) -> Callable:
    """Return an engine whose bodies go on as they began, through each other."""

    def ask(*arguments):
        _, step, _, every = arguments
        said = frozen(answer)(*arguments)
        if isinstance(said, Motion):
            return said
        times = step * every * np.arange(1, len(said.position[0]) + 1)[:, None, None]
        return said._replace(position=tuple(x + times * v for x, v in zip(said.position, said.velocity)))

    return ask


def exaggerating(answer: Callable) -> Callable:
    """Return an engine whose bodies do a fiftieth more, whose numbers are a thousandth too large, and who lies once."""

    def ask(*arguments):
        said = answer(*arguments)
        if isinstance(said, SoftMotion):
            more = (tuple(1.02 * rows for rows in side) for side in said[:2])
            return SoftMotion(*more, said.boxes._replace(velocity=1.02 * said.boxes.velocity))
        if isinstance(said, Motion):
            return said._replace(position=1.02 * said.position, velocity=1.02 * said.velocity, spin=1.02 * said.spin)
        return np.append(~said[:1], said[1:]) if isinstance(said, np.ndarray) else 1.001 * said

    return ask


FAIR = {"inside": "igl", "overlap": "fcl"}  # by the claim's file; else the core
FAIR_TO = {  # by the claim: where the core fails, and why
    "machines.outrun": "dartpy",  # sweeps along a row on the ground do not end, and it is then taken for pinched
    "edges.rock": "pybullet",  # the core takes an impact that it foresees in two steps: it keeps 0.2 % less of the spin
}


@pytest.mark.parametrize("name", sorted(one.partition(":")[2] for one in checks_of("softbody")))
def test_each_claim_holds_for_a_good_engine_and_sees_a_bad_one(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    who = FAIR_TO.get(name) or FAIR.get(name.partition(".")[0], "softbody")
    check = find_check(f"{who}:{name}")
    if check.hindrance:
        pytest.skip(check.hindrance[1])
    run = Run("quick", 3, check.id)
    record = judge(check, run)
    assert record.verdict == HOLDS, record.why
    claim = subject.CLAIMS[name]
    module = __import__(f"validation.subjects.{who}", fromlist=["x"])
    answer = getattr(module, claim.question)
    verdicts = []
    for damage in (exaggerating, frozen, ghostly)[: 3 if claim.question.startswith("move") else 1]:
        monkeypatch.setattr(module, claim.question, damage(answer))
        verdicts.append(judge(check, run).verdict)
    assert FAILS in verdicts


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--subject", "rapier"], "did you mean rapier3d?"),
        (["--subject", "nobody at all"], "Subjects are"),
        (["--subject", "igl", "--timings"], "of the core"),
        (["replay", "igl:inside.anywere"], "did you mean igl:inside.anywhere"),
    ],
)
def test_wrong_usage_is_said_before_anything_runs(options: list[str], said: str) -> None:
    done = validate(*options)
    assert done.returncode == 2
    assert said in done.stderr


def test_an_engine_that_is_missing_is_named_with_its_cure(tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(
        "from importlib.machinery import PathFinder\n"
        "find = PathFinder.find_spec\n"
        "PathFinder.find_spec = classmethod(lambda c, name, *rest: None if name == 'fcl' else find(name, *rest))\n"
    )
    variables = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)])}
    command = [sys.executable, "-m", "validation", "--subject", "fcl", "--out", str(tmp_path / "out")]
    done = subprocess.run(command, env=variables, cwd=ROOT, capture_output=True, text=True, timeout=100)
    assert done.returncode == 3
    assert "fcl (install python-fcl)" in done.stderr
    assert not (tmp_path / "out").exists()
