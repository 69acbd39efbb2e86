"""A planted fault changes what its pattern finds, wherever that stands, and says so where it finds nothing."""

from __future__ import annotations

import ast
import builtins
import dis
import importlib
import inspect
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from types import CodeType, SimpleNamespace
from typing import Any

import pytest

from softbody.geometry import sphere
from softbody.geometry.box import box_inertia
from validation import fault_trials
from validation.bench import CRASHED, GREEN, HUNG, MEASURED, Seen
from validation.check import all_checks, check
from validation.damaged_core import copy_core
from validation.fault import Fault, damaged, plant, plant_switched, switched
from validation.fault_trials import CAUGHT, ESCAPED, NOT_RUN, Judges, Outcome, line_of, planted_faults, try_fault

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
    tree = ast.parse(damaged(Fault("a fault", where, f"{find} → {put}", nth), source))
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
    fault = Fault("a smaller sphere", "softbody.geometry.sphere.ROUNDING", "1.0 + x_ → 1.0 - x_")
    assert "ROUNDING = 1.0 - 2.0 ** (-50)" in damaged(fault, inspect.getsource(sphere))


def test_a_place_that_is_not_there_is_named() -> None:
    with pytest.raises(ValueError, match=r"there is no softbody\.geometry\.sphere\.NOTHING"):
        damaged(Fault("a fault", "softbody.geometry.sphere.NOTHING", "x_ → 1.0"), inspect.getsource(sphere))


def test_a_kernel_is_damaged_in_a_copy_of_its_file(tmp_path: Path) -> None:
    file = copy_of_box_inertia(tmp_path)
    plant(Fault("a heavier box", box_inertia, "mass_ / 12.0 → mass_ / 11.0"), tmp_path)
    assert "scale(mass / 11.0, " in file.read_text(encoding="utf-8")


def copy_of_box_inertia(core: Path) -> Path:
    file = core / "geometry" / "box.py"
    file.parent.mkdir(parents=True)
    file.write_text(inspect.getsource(importlib.import_module("softbody.geometry.box")), encoding="utf-8")
    return file


def test_many_faults_are_asleep_in_one_copy_until_one_is_woken(tmp_path: Path) -> None:
    heavier = Fault("a heavier box", box_inertia, "mass_ / 12.0 → mass_ / 6.0")
    lighter = Fault("a lighter box", box_inertia, "mass_ / 12.0 → mass_ / 24.0")
    plant_switched({3: heavier, 4: lighter}, copy_core(tmp_path))
    script = """
from softbody.geometry.box import box_inertia
from softbody.switch import AWAKE

for AWAKE.value in (-1, 3, 4):
    print(box_inertia((1.0, 1.0, 1.0), 6.0)[0])
"""
    for interpreted in ("0", "1"):
        environment = {**os.environ, "NUMBA_DISABLE_JIT": interpreted, "PYTHONPATH": ""}
        done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, env=environment, capture_output=True)
        assert done.stdout.decode().split() == ["1.0", "2.0", "0.5"], done.stderr.decode()


def awake(faults: list[Fault], number: int, width: float) -> Any:
    """What `area` returns for (width, 2), and prints, with faults in it, one of them awake."""
    source = inspect.getsource(inspect.getmodule(area))  # type: ignore[arg-type]
    tree = ast.parse(switched(dict(enumerate(faults)), source))
    function = next(node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == "area")
    printed: list[float] = []
    scope: dict[str, Any] = {"is_awake": lambda fault: fault == number, "print": printed.append}
    exec(compile(ast.fix_missing_locations(ast.Module([function], [])), "area", "exec"), scope)
    return scope["area"](width, 2.0), printed


def test_faults_may_be_inside_each_other() -> None:
    faults = [
        Fault("a factor", area, "width_ * height_ / 2.0 → width_ * height_ / 4.0"),
        Fault("inside it", area, "width * height → width + height"),
        Fault("the whole row", area, "half = x_\nif y_:\n    print(z_) → half = 7.0"),
        Fault("a statement of it", area, "if y_:\n    print(z_) → "),
    ]
    assert awake(faults, -1, 3.0) == (9.0, [3.0])
    assert awake(faults, 0, 3.0) == (7.5, [1.5])
    assert awake(faults, 1, 3.0) == (8.5, [2.5])
    assert awake(faults, 2, 3.0) == (13.0, [])
    assert awake(faults, 3, 3.0) == (9.0, [])


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_every_planted_fault_changes_the_core_as_it_is(fault: Fault) -> None:
    module = importlib.import_module(fault.place[0])
    sound = inspect.getsource(module)
    broken = damaged(fault, sound)
    assert broken != ast.unparse(ast.parse(sound)) + "\n"
    known = {*vars(module), *vars(builtins)}
    assert not set(globals_of(compile(broken, fault.place[0], "exec"))) - known


def globals_of(code: CodeType) -> Iterator[str]:
    """The names that the functions of a module take from it; of what it does not know one compiles no kernel."""
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from (str(each.argval) for each in dis.get_instructions(inner) if each.opname == "LOAD_GLOBAL")
            yield from globals_of(inner)


def test_faults_have_names_of_their_own() -> None:
    assert len({fault.name for fault in FAULTS}) == len(FAULTS)
    assert {claim for claims in FAULTS.values() for claim in claims} == set(all_checks())


def one_is_one(run):
    """One is one."""


NO_CLAIM = {
    "family": "tests",
    "section": "1",
    "piece": "softbody",
    "reference": "nobody",
    "tolerance": 0.0,
    "because": "it is",
}


def test_a_claim_without_a_fault_is_refused() -> None:
    with pytest.raises(ValueError, match="a claim that cannot fail says nothing"):
        check(**NO_CLAIM, kind="invariant", faults=())(one_is_one)  # type: ignore[arg-type, return-value]


def test_an_engine_that_no_reference_declares_is_refused() -> None:
    fault = Fault("a fault", area, "width_ → height")
    with pytest.raises(ValueError, match="leans on 'crystal_ball', which no file of references/ declares"):
        check(**NO_CLAIM, faults=(fault,), engines=("crystal_ball",))(one_is_one)  # type: ignore[arg-type, return-value]


def test_a_fault_that_one_of_its_claims_does_not_see_has_escaped() -> None:
    fault = Fault("a fault", area, "width_ → height")
    assert Outcome(fault, ("a", "b")).verdict == CAUGHT
    assert Outcome(fault, ("a", "b"), blind={"b": "not seen by b"}).verdict == ESCAPED
    assert Outcome(fault, ("a", "b"), why="fcl is not installed").verdict == NOT_RUN


class Answers:
    """Judges by which every claim shows what is asked for."""

    def __init__(self, shows: Seen) -> None:
        self._shows = shows

    def awake(self, fault: Fault, claim: str) -> Seen:
        return self._shows


@pytest.mark.parametrize(
    ("sound", "awake", "verdict", "says"),
    [
        (GREEN, MEASURED, CAUGHT, ""),
        (GREEN, GREEN, ESCAPED, "not seen by a"),
        (GREEN, CRASHED, ESCAPED, "a crashed, and has seen nothing: so it is"),
        (GREEN, HUNG, ESCAPED, "a hung, and has seen nothing: so it is"),
        (MEASURED, MEASURED, ESCAPED, "a does not hold without it: so it is"),
    ],
)
def test_a_fault_is_caught_by_what_a_claim_measures_that_holds_without_it(
    monkeypatch: pytest.MonkeyPatch, sound: str, awake: str, verdict: str, says: str
) -> None:
    monkeypatch.setattr(fault_trials, "all_checks", lambda: {"a": SimpleNamespace(engines=())})
    judges: Any = Answers(Seen(awake, "so it is"))
    outcome = try_fault(Fault("a fault", area, "width_ → height"), ("a",), judges, {"a": Seen(sound, "so it is")})
    assert outcome.verdict == verdict
    assert says in line_of(outcome)


def test_a_fault_is_awake_in_one_process_alone(tmp_path: Path) -> None:
    claim = "volume.inertia_of_boxes"
    fault = next(each for each, claims in FAULTS.items() if claim in claims)
    with closing(Judges([fault], tmp_path, jobs=2)) as judges:
        assert judges.asleep(claim).what == GREEN
        assert judges.awake(fault, claim).what == MEASURED
        assert judges.asleep(claim).what == GREEN
