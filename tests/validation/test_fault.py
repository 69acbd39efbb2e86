"""A planted fault changes what its pattern finds, wherever that stands, and says so where it finds nothing."""

from __future__ import annotations

import ast
import importlib
import inspect
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import softbody
from softbody.geometry import sphere
from softbody.geometry.box import box_inertia
from validation import faults
from validation.check import all_checks, check
from validation.fault import Fault, damaged, plant, plant_switched, switched
from validation.faults import CAUGHT, ESCAPED, NOT_RUN, Outcome, line_of, planted_faults, try_fault
from validation.record import FAILS, HOLDS

FAULTS = planted_faults()
HERE = __name__


def area(width: float, height: float) -> float:  # what the tests damage; never called
    half = width * height / 2.0
    if half > 0.0:
        print(half)
    return half + width * height


def damage(find: str, put: str, nth: int = 0, where: Callable[..., Any] | str = area) -> str:
    """The body of `area` with a fault in it."""
    source = inspect.getsource(inspect.getmodule(area))  # type: ignore[arg-type]
    tree = ast.parse(damaged(Fault("a fault", where, find, put, nth), source))
    function = next(node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == "area")
    return ast.unparse(function.body)  # type: ignore[arg-type]


def test_a_name_that_ends_in_an_underscore_stands_for_anything() -> None:
    assert "half = width * height / 3.0" in damage("area_ / 2.0", "area_ / 3.0")


def test_the_same_name_stands_for_the_same_thing() -> None:
    with pytest.raises(ValueError, match="plant the fault elsewhere"):
        damage("side_ * side_", "1.0")


def test_other_names_stand_for_themselves() -> None:
    assert "height * width / 2.0" in damage("width * height", "height * width")
    with pytest.raises(ValueError, match="plant the fault elsewhere"):
        damage("length * height", "1.0")


def test_the_number_of_a_match_may_be_given() -> None:
    assert "return half + 7.0" in damage("width * height", "7.0", nth=1)


def test_statements_are_replaced_by_statements_or_left_out() -> None:
    assert "half = 1.0\nhalf += 1.0" in damage("half = x_", "half = 1.0\nhalf += 1.0")
    assert "print" not in damage("print(x_)", "")
    assert damage("if x_ > 0.0:\n    print(y_)\nreturn z_", "return y_").endswith("\nreturn half")


def test_a_fault_that_changes_nothing_is_refused() -> None:
    with pytest.raises(ValueError, match="'a fault' changes nothing"):
        damage("a_ * b_", "width * height")


def test_a_constant_is_named_in_words() -> None:
    fault = Fault("a smaller sphere", "softbody.geometry.sphere.ROUNDING", "1.0 + x_", "1.0 - x_")
    assert "ROUNDING = 1.0 - 2.0 ** (-50)" in damaged(fault, inspect.getsource(sphere))


def test_a_place_that_is_not_there_is_named() -> None:
    with pytest.raises(ValueError, match=r"there is no softbody\.geometry\.sphere\.NOTHING"):
        damaged(Fault("a fault", "softbody.geometry.sphere.NOTHING", "x_", "1.0"), inspect.getsource(sphere))


def test_a_kernel_is_damaged_in_a_copy_of_its_file(tmp_path: Path) -> None:
    file = copy_of_box_inertia(tmp_path)
    plant(Fault("a heavier box", box_inertia, "mass_ / 12.0", "mass_ / 11.0"), tmp_path)
    assert "scale(mass / 11.0, " in file.read_text(encoding="utf-8")


def copy_of_box_inertia(core: Path) -> Path:
    file = core / "geometry" / "box.py"
    file.parent.mkdir(parents=True)
    file.write_text(inspect.getsource(importlib.import_module("softbody.geometry.box")), encoding="utf-8")
    return file


def test_many_faults_are_asleep_in_one_copy_until_one_is_woken(tmp_path: Path) -> None:
    shutil.copytree(Path(softbody.__file__).parent, tmp_path / "softbody")
    heavier = Fault("a heavier box", box_inertia, "mass_ / 12.0", "mass_ / 6.0")
    lighter = Fault("a lighter box", box_inertia, "mass_ / 12.0", "mass_ / 24.0")
    plant_switched({3: heavier, 4: lighter}, tmp_path / "softbody")
    script = "from softbody.geometry.box import box_inertia; print(box_inertia((1.0, 1.0, 1.0), 6.0)[0])"
    for awake, inertia in (("-1", "1.0"), ("3", "2.0"), ("4", "0.5")):
        for interpreted in ("0", "1"):
            environment = {**os.environ, "SOFTBODY_FAULT": awake, "NUMBA_DISABLE_JIT": interpreted}
            command = [sys.executable, "-c", script]
            done = subprocess.run(command, cwd=tmp_path, env=environment | {"PYTHONPATH": ""}, capture_output=True)
            assert done.stdout.decode().strip() == inertia, done.stderr.decode()


def awake(faults: list[Fault], number: int, width: float) -> Any:
    """What `area` returns for (width, 2), and prints, with faults in it, one of them awake."""
    source = inspect.getsource(inspect.getmodule(area))  # type: ignore[arg-type]
    tree = ast.parse(switched(dict(enumerate(faults)), source))
    function = next(node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == "area")
    printed: list[float] = []
    scope: dict[str, Any] = {"is_planted": lambda fault: fault == number, "print": printed.append}
    exec(compile(ast.fix_missing_locations(ast.Module([function], [])), "area", "exec"), scope)
    return scope["area"](width, 2.0), printed


def test_faults_may_be_inside_each_other() -> None:
    faults = [
        Fault("a factor", area, "width_ * height_ / 2.0", "width_ * height_ / 4.0"),
        Fault("inside it", area, "width * height", "width + height"),
        Fault("the whole row", area, "half = x_\nif y_:\n    print(z_)", "half = 7.0"),
        Fault("a statement of it", area, "if y_:\n    print(z_)", ""),
    ]
    assert awake(faults, -1, 3.0) == (9.0, [3.0])
    assert awake(faults, 0, 3.0) == (7.5, [1.5])
    assert awake(faults, 1, 3.0) == (8.5, [2.5])
    assert awake(faults, 2, 3.0) == (13.0, [])
    assert awake(faults, 3, 3.0) == (9.0, [])


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_every_planted_fault_changes_the_core_as_it_is(fault: Fault) -> None:
    sound = inspect.getsource(importlib.import_module(fault.place[0]))
    broken = damaged(fault, sound)
    assert broken != ast.unparse(ast.parse(sound)) + "\n"
    compile(broken, fault.place[0], "exec")


def test_faults_have_names_of_their_own() -> None:
    assert len({fault.name for fault in FAULTS}) == len(FAULTS)
    assert {claim for claims in FAULTS.values() for claim in claims} == set(all_checks())


NO_CLAIM = {
    "family": "tests",
    "claim": "One is one.",
    "section": "1",
    "piece": "softbody",
    "reference": "nobody",
    "tolerance": 0.0,
    "because": "it is",
    "detects": "nothing",
}


def test_a_claim_without_a_fault_is_refused() -> None:
    with pytest.raises(ValueError, match="a claim that cannot fail says nothing"):
        check(**NO_CLAIM, kind="invariant", faults=())(lambda run: None)  # type: ignore[arg-type, return-value]


def test_an_engine_that_no_reference_declares_is_refused() -> None:
    fault = Fault("a fault", area, "width_", "height")
    with pytest.raises(ValueError, match="leans on 'crystal_ball', which no file of references/ declares"):
        check(**NO_CLAIM, faults=(fault,), engines=("crystal_ball",))(lambda run: None)  # type: ignore[arg-type, return-value]


def test_a_fault_that_one_of_its_claims_does_not_see_has_escaped() -> None:
    fault = Fault("a fault", area, "width_", "height")
    assert Outcome(fault, ("a", "b")).verdict == CAUGHT
    assert Outcome(fault, ("a", "b"), blind=("b",)).verdict == ESCAPED
    assert Outcome(fault, ("a", "b"), why="fcl is not installed").verdict == NOT_RUN


class Answers:
    """A bench on which every claim gets the verdict that is asked for."""

    def __init__(self, verdicts: dict[str, str]) -> None:
        self._verdicts = verdicts

    def verdicts(self, claims: tuple[str, ...], fault: Fault) -> dict[str, str]:
        return self._verdicts


@pytest.fixture
def claim_a(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(faults, "all_checks", lambda: {"a": SimpleNamespace(engines=())})


@pytest.mark.usefixtures("claim_a")
def test_a_claim_that_does_not_hold_on_the_sound_core_catches_nothing() -> None:
    fault, bench = Fault("a fault", area, "width_", "height"), Answers({"a": FAILS})
    assert try_fault(fault, ("a",), bench, {"a": HOLDS}).verdict == CAUGHT  # type: ignore[arg-type]
    blind = try_fault(fault, ("a",), bench, {"a": FAILS})  # type: ignore[arg-type]
    assert blind.verdict == ESCAPED
    assert "a does not hold without it" in line_of(blind, {"a": FAILS})


@pytest.mark.usefixtures("claim_a")
def test_a_fault_that_leaves_no_verdict_has_escaped() -> None:
    fault = Fault("a fault", area, "width_", "height")
    assert try_fault(fault, ("a",), Answers({}), {"a": HOLDS}).verdict == ESCAPED  # type: ignore[arg-type]
