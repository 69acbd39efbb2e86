"""Every claim says which piece of the core it is about and who judges it, and declares what can be kept."""

from __future__ import annotations

import ast
import math
from pathlib import Path
from pkgutil import resolve_name

import pytest

from validation import checks
from validation.check import CHECKS, Comparison, all_checks, check
from validation.fault import Fault
from validation.record import ENGINE, KINDS, LIBRARY


def test_the_pieces_of_all_claims_are_there() -> None:
    gone = []
    for one in all_checks().values():
        for piece in one.piece.split(", "):
            try:
                resolve_name(piece)
            except (ImportError, AttributeError):
                gone.append((one.id, piece))
    assert not gone


FAULT = Fault("a fault", "softbody.world.PRECISIONS", "x_ → None")
WORDS = dict.fromkeys(("family", "section", "piece", "reference", "because"), "some")


def declared(**changes):
    """Declare a claim, and forget it; return what was declared."""
    compare = check(**{**WORDS, "tolerance": 0.0, "kind": "invariant", "faults": (FAULT,), **changes})

    def some_claim(run):
        """Nothing is as
        it seems.

        Of all that is tried.
        """
        return Comparison([], [])

    compare(some_claim)
    return CHECKS.pop(f"{__name__}.some_claim")


def test_a_docstring_is_the_claim_and_what_else_is_said_of_it():
    claim = declared()
    assert (claim.claim, claim.detail) == ("Nothing is as it seems.", "Of all that is tried.")
    with pytest.raises(ValueError, match="claims nothing"):
        check(**WORDS, tolerance=0.0, kind="invariant", faults=(FAULT,))(lambda run: Comparison([], []))
    with pytest.raises(ValueError, match="no family"):
        declared(family=None)


def test_a_claim_is_one_short_sentence():
    claims = [claim.claim for claim in all_checks().values()]
    assert [claim for claim in claims if len(claim.split()) > 12 or not claim.endswith(".")] == []
    assert len({*claims}) == len(claims)


@pytest.mark.parametrize("tolerance", [-1.0, math.inf, math.nan])
def test_a_tolerance_that_refuses_nothing_is_refused(tolerance):
    with pytest.raises(ValueError, match="tolerance"):
        declared(tolerance=tolerance)


def test_a_claim_compares_at_least_one_case_and_names_a_fault():
    with pytest.raises(ValueError, match="compares one at least"):
        declared(least=0)
    with pytest.raises(ValueError, match="no fault"):
        declared(faults=())


def test_each_claim_says_what_kind_of_judge_it_has():
    assert declared(kind=None, engines=("pybullet", "scipy")).kind == ENGINE
    assert declared(kind=None, engines=("scipy",)).kind == LIBRARY
    assert declared(engines=("scipy",)).kind == "invariant"
    for kind in (None, "somebody"):
        with pytest.raises(ValueError, match="kind of judge"):
            declared(kind=kind)
    assert {one.kind for one in all_checks().values()} <= set(KINDS)


def test_no_claim_loses_a_nan_in_a_maximum():
    # Python's own max(0.0, nan) is 0.0, and max(most, nan) is most.
    lost = []
    for path in Path(checks.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            pair = node.value if isinstance(node, ast.Assign) else node
            if not (isinstance(pair, ast.Call) and ast.unparse(pair.func) in ("max", "min")):
                continue
            given = [ast.unparse(argument) for argument in pair.args]
            itself = isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) in given
            if itself or "0.0" in given:
                lost.append(f"{path.name}:{node.lineno}")
    assert not lost
