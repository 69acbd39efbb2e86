import json

import pytest

from validation.golden import __main__ as golden
from validation.golden.cases import Case, cases
from validation.golden.make import EXPECTED, FILES


def test_every_world_has_hashes():
    assert set(json.loads(golden.HASHES.read_text())["worlds"]) == set(cases())


def test_every_file_of_old_is_told_of():
    told = {FILES / name for name in json.loads(EXPECTED.read_text())}
    kept = [path for path in FILES.rglob("*") if path.is_file() and path != EXPECTED]
    assert all(told & {path, *path.parents} for path in kept)


@pytest.mark.parametrize(
    ("now", "line"),
    [
        ({"ball": {"steps": 3, "energies": {"gas": "0x1p+0"}}}, None),
        ({"ball": {"steps": 3, "energies": {"gas": "0x1p+1"}}}, "ball: energies: gas is 0x1p+1, and was 0x1p+0"),
        ({"ball": {"steps": 3, "energies": {}}}, "ball: energies: gas is None, and was 0x1p+0"),
    ],
)
def test_what_differs_is_named(now, line):
    before = {"ball": {"steps": 3, "energies": {"gas": "0x1p+0"}}}
    assert golden.differences(now, before, {"ball": Case(lambda: None)}) == ([line] if line else [])


def test_worlds_that_come_and_go_are_named():
    wrong = golden.differences({"new": {}}, {"gone": {}, "of more threads": {}}, {"new": None, "of more threads": None})
    assert wrong == ["new: is new; --write keeps it", "gone: is no case any more"]
