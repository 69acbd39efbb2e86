"""What is published is what was stored; other files, and what cannot be made anew, stay as they are."""

from __future__ import annotations

import json
import subprocess

import click
import pytest

from benchmarks import publish
from benchmarks.calibration import Calibration
from benchmarks.history import run_record
from benchmarks.publish import document_of
from benchmarks.trends import trends_of
from reports.trends_document import read_trends

RUNS = 8


@pytest.fixture
def document(make_document):
    """Return the document of runs whose second half is slower."""
    days = [f"2030-01-0{day}T10:00:00" for day in range(1, RUNS + 1)]
    rounds = [(1e-3,) * 3 if k < RUNS // 2 else (1.2e-3,) * 3 for k in range(RUNS)]
    records = [run_record(make_document(day, ours, (2e-3,) * 3)) for day, ours in zip(days, rounds)]
    calibration = Calibration("2029-12-31", "abc", 1.5, 60.0, {"0": {"bench": [[0.0] * 4] * 5}})
    return document_of(records, trends_of(records), calibration)


def test_the_document_has_what_reports_read(document, tmp_path):
    (tmp_path / "trends.json").write_text(json.dumps(document))
    read = read_trends(tmp_path / "trends.json")
    assert read.machine == document["machine"]
    assert read.machine["processor"] == "Some CPU"
    assert (len(read.runs), read.runs[0].revision) == (RUNS, "0123456789ab")
    assert [(rate.comparisons, rate.found) for rate in read.calibration.rates] == [(60, 0)]
    (trend,) = read.trends
    assert (trend.file, trend.name, trend.row["size"], trend.unit) == ("bench_x.py", "bench_x[42]", 42, "× a peer")
    assert trend.values == pytest.approx([0.5] * 4 + [0.6] * 4)
    assert [(step.at, round(step.ratio, 9)) for step in trend.steps] == [(4, 1.2)]


def test_what_else_is_in_the_folder_stays(document, tmp_path):
    (tmp_path / "index.html").write_text("mine")
    (tmp_path / "trends.html").write_text("an old page")
    publish.publish(document, tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["index.html", "trends.html", "trends.json"]
    assert (tmp_path / "index.html").read_text() == "mine"
    page = (tmp_path / "trends.html").read_text()
    assert "1 of 1 benchmark became slower" in page


def test_a_page_that_cannot_be_made_is_an_error_and_the_old_one_stays(document, tmp_path, monkeypatch):
    (tmp_path / "trends.html").write_text("an old page")
    failed = subprocess.CompletedProcess([], 1, "", "Traceback\nModuleNotFoundError: No module named 'jinja2'\n")
    monkeypatch.setattr(publish.subprocess, "run", lambda *_, **__: failed)
    with pytest.raises(click.ClickException, match=r"trends\.html could not be made: .*jinja2"):
        publish.publish(document, tmp_path)
    assert (tmp_path / "trends.html").read_text() == "an old page"


def test_a_folder_that_cannot_be_is_named(document, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(click.ClickException, match="file/folder cannot be made"):
        publish.publish(document, tmp_path / "file" / "folder")
