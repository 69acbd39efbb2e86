"""What was tried on this core is told, and what was tried on another one is not."""

import json

import pytest

from softbody.core_digest import core_digest
from validation.sensitivity import sensitivity

FAULT = {"name": "a sign", "place": "softbody.vec.dot", "claims": ["a.b"], "verdict": "caught"}


@pytest.fixture
def left(tmp_path):
    def write(core):
        (tmp_path / "faults.json").write_text(json.dumps({"core": core, "faults": [FAULT]}))
        (tmp_path / "mutants.json").write_text(json.dumps({"core": core, "mutants": 9, "killed": 7, "equivalent": 1}))
        return sensitivity(tmp_path)

    return write


def test_faults_and_mutants_of_this_core_are_told(left):
    found = left(core_digest())
    assert [fault.name for fault in found.faults] == ["a sign"]
    assert (found.mutants, found.killed, found.equivalent) == (9, 7, 1)
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
