"""A planted fault changes what its pattern finds, wherever that stands, and says so where it finds nothing."""

from __future__ import annotations

import ast
import importlib
import inspect
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from softbody.geometry import sphere
from softbody.geometry.box import box_inertia
from validation import faults
from validation.check import all_checks, check
from validation.fault import Fault, damaged, plant
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


def test_a_kernel_is_damaged_in_a_copy_of_its_file(tmp_path) -> None:
    file = tmp_path / "softbody" / "geometry" / "box.py"
    file.parent.mkdir(parents=True)
    file.write_text(inspect.getsource(importlib.import_module("softbody.geometry.box")), encoding="utf-8")
    plant(Fault("a heavier box", box_inertia, "mass_ / 12.0", "mass_ / 11.0"), tmp_path)
    assert "scale(mass / 11.0, " in file.read_text(encoding="utf-8")


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
        check(**NO_CLAIM, faults=())(lambda run: None)  # type: ignore[arg-type, return-value]


def test_an_engine_that_no_reference_declares_is_refused() -> None:
    fault = Fault("a fault", area, "width_", "height")
    with pytest.raises(ValueError, match="leans on 'crystal_ball', which no file of references/ declares"):
        check(**NO_CLAIM, faults=(fault,), engines=("crystal_ball",))(lambda run: None)  # type: ignore[arg-type, return-value]


def test_a_fault_that_one_of_its_claims_does_not_see_has_escaped() -> None:
    fault = Fault("a fault", area, "width_", "height")
    assert Outcome(fault, ("a", "b")).verdict == CAUGHT
    assert Outcome(fault, ("a", "b"), blind=("b",)).verdict == ESCAPED
    assert Outcome(fault, ("a", "b"), why="fcl is not installed").verdict == NOT_RUN


def test_a_claim_that_does_not_hold_on_the_sound_core_catches_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(faults, "missing", lambda engines: [])
    monkeypatch.setattr(faults, "all_checks", lambda: {"a": SimpleNamespace(engines=())})
    monkeypatch.setattr(faults, "verdicts_with", lambda fault, claims: {"a": FAILS})
    fault = Fault("a fault", area, "width_", "height")
    assert try_fault(fault, ("a",), {"a": HOLDS}).verdict == CAUGHT
    blind = try_fault(fault, ("a",), {"a": FAILS})
    assert blind.verdict == ESCAPED
    assert "a does not hold without it" in line_of(blind, {"a": FAILS})


def test_a_fault_that_leaves_no_verdict_has_escaped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(faults, "missing", lambda engines: [])
    monkeypatch.setattr(faults, "all_checks", lambda: {"a": SimpleNamespace(engines=())})
    monkeypatch.setattr(faults, "verdicts_with", lambda fault, claims: {})
    assert try_fault(Fault("a fault", area, "width_", "height"), ("a",), {"a": HOLDS}).verdict == ESCAPED
