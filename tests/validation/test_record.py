"""A record can be written, read back and trusted."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from validation.check import all_checks
from validation.judge import blank_record
from validation.record import (
    Behaviour,
    Case,
    Distribution,
    Erratum,
    Group,
    Report,
    Timing,
    Trend,
    TrendStep,
    read_report,
    write_report,
    write_whole,
)


def make_report() -> Report:
    claim = blank_record(next(iter(all_checks().values())), seed=3)
    claim.value, claim.n, claim.verdict = 1e-15, 2, "holds"
    claim.errors = Distribution({"0": 0.0, "1": 1e-15}, 1, [-16.0, -15.0], [1])
    claim.groups = [Group("kind", 2, 0.0, 1e-15, 1e-15)]
    claim.erratum = Erratum("E1", "wrong", "right", 1.0, 0.5, 1.0)
    claim.worst = Case(1, 1e-15, 2.0, [1.0, True], [1.0, False], "kind", {"point": [0.0, 1.0], "name": "torus"}, 2)
    row = {"table": "A step", "name": "rk4", "size": 642, "of": "particles", "per": "particle and step"}
    trend = Trend("bench_x.py", "bench_x", row, None, ["a", "b"], [1.0, 2.0], [TrendStep(1, 2.0, "b", "old", "new")])
    return Report(
        "quick", 3, "2026-01-01T00:00:00+00:00", 1.5, "0.1.0", None, {"Python": "3"}, {"fcl": None}, [claim],
        [Timing("A step", "rk4", 642, "particles", "particle and step", 100.0, 99.0, 101.0, 7, trend=trend)],
        behaviours=[Behaviour("2", "defaults", 3.0, 0.0, 0.0, None, 1.0, 12.0)],
    )  # fmt: skip


def test_what_is_written_is_read_back(tmp_path: Path) -> None:
    report = make_report()
    write_report(report, tmp_path / "new" / "report.json")
    assert read_report(tmp_path / "new" / "report.json") == report


def test_a_record_of_version_1_is_read(tmp_path: Path) -> None:
    write_report(make_report(), tmp_path / "report.json")
    data = json.loads((tmp_path / "report.json").read_text())
    data["schema"] = "softbody-report/1"
    del data["patterns"], data["figures"], data["claims"][0]["worst"], data["claims"][0]["kind"]
    (tmp_path / "report.json").write_text(json.dumps(data))
    report = read_report(tmp_path / "report.json")
    assert report.claims[0].worst is None
    assert report.patterns == []
    assert report.claims[0].errors == make_report().claims[0].errors


def test_a_newer_record_is_refused(tmp_path: Path) -> None:
    report = make_report()
    report.schema = "softbody-report/3"
    write_report(report, tmp_path / "report.json")
    with pytest.raises(ValueError, match="softbody-report/3"):
        read_report(tmp_path / "report.json")


def test_numbers_that_json_lacks_become_null(tmp_path: Path) -> None:
    report = make_report()
    report.claims[0].value = math.nan
    report.claims[0].groups[0].max = math.inf
    write_report(report, tmp_path / "report.json")
    text = (tmp_path / "report.json").read_text()
    assert "NaN" not in text
    assert "Infinity" not in text
    assert read_report(tmp_path / "report.json").claims[0].value is None


@pytest.mark.parametrize("text", ["", "{", "[]", '{"schema": "other/1"}'])
def test_another_file_is_refused_by_name(text: str, tmp_path: Path) -> None:
    path = tmp_path / "report.json"
    path.write_text(text)
    with pytest.raises(ValueError, match=r"report\.json"):
        read_report(path)


def test_a_file_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_text("old")
    with pytest.raises(UnicodeEncodeError):
        write_whole(path, "new \ud800")
    assert path.read_text() == "old"


def test_the_documented_fields_of_a_claim_are_there(tmp_path: Path) -> None:
    write_report(make_report(), tmp_path / "report.json")
    data = json.loads((tmp_path / "report.json").read_text())
    wanted = {"id", "claim", "section", "piece", "reference", "value", "tolerance", "because", "n", "seed", "verdict"}
    assert wanted <= set(data["claims"][0])
    assert {"environment", "engines", "timings", "schema"} <= set(data)
