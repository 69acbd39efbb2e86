"""What was tried on this core is told, and what was tried on another one is not."""

import json

import pytest

from softbody.compiler.core_digest import core_digest
from validation.mutation.explained import Reason
from validation.mutation.results import HUNG, KILLED, Ledger, write_summary
from validation.mutation.sites import Mutant
from validation.sensitivity import sensitivity

FAULT = {
    "name": "a sign",
    "place": "softbody.linalg.vec.dot",
    "claims": ["a.b"],
    "verdict": "caught",
    "off": {"a.b": 3.0},
}


@pytest.fixture
def left(tmp_path):
    def write(core):
        (tmp_path / "faults.json").write_text(json.dumps({"core": core, "faults": [FAULT]}))
        ledger = Ledger(tmp_path / "mutants.jsonl", "an earlier core", 1, resume=False)
        fates = [ledger.fate_of(Mutant("law.py", f"f{k}", "sign", "-x", "x", 12)) for k in range(4)]
        fates[0].verdict, fates[0].level = KILLED, "quick"
        fates[1].verdict, fates[1].level = HUNG, "standard"
        for fate in fates:
            ledger.note(fate)
        explained = {fates[2].mutant.key: Reason("why", within=False)}
        write_summary(fates, explained, {"core": core}, tmp_path / "mutants.json")
        return sensitivity(tmp_path)

    return write


def test_faults_and_mutants_of_this_core_are_told(left):
    found = left(core_digest())
    assert [(fault.name, fault.off) for fault in found.faults] == [("a sign", {"a.b": 3.0})]
    assert (found.mutants, found.killed, found.crashed, found.hung) == (4, 1, 0, 1)
    assert (found.equivalent, found.within) == (1, 0)
    assert (found.seen_at, found.earlier) == ({"quick": 1, "standard": 1}, 4)
    assert found.survivors == ["softbody/law.py:12 f3: -x -> x"]
    assert found.faults_why is None


def test_those_of_another_core_are_not(left):
    found = left("another")
    assert not found.faults
    assert not found.mutants
    assert "make faults again" in found.faults_why
    assert "make mutants again" in found.mutants_why


def test_nothing_tried_and_what_is_damaged_is_said(tmp_path):
    (tmp_path / "mutants.json").write_text("{")
    found = sensitivity(tmp_path)
    assert found.faults_why == "not tried: make faults"
    assert "mutants.json cannot be read" in found.mutants_why
