"""A badge says the verdict in a line; a browser makes a PDF, or it is said that there is none."""

import shutil
import subprocess
import sys
from xml.etree import ElementTree

import pytest

from reports import pdf
from reports.badge import COLOURS, badge
from reports.page import page
from validation.record import HOLDS, Subject

SVG = "{http://www.w3.org/2000/svg}"


def texts(svg):
    return [one.text for one in ElementTree.fromstring(svg).iter(f"{SVG}text")]


def test_the_badge_says_who_was_judged_and_how_many_claims_hold(report):
    assert texts(badge(report)) == ["softbody claims", "✗ 35 of 40 hold, 2 fail"]
    report.claims = [claim for claim in report.claims if claim.verdict == HOLDS]
    report.subject = Subject("rapier3d", None)
    count = len(report.claims)
    assert texts(badge(report)) == ["rapier3d claims", f"✓ {count} of {count} hold"]


def test_the_badge_of_a_selection_is_not_green(report):
    report.claims = [claim for claim in report.claims if claim.verdict == HOLDS]
    assert COLOURS[HOLDS] in badge(report)
    report.patterns, count = ["volume"], len(report.claims)
    assert texts(badge(report))[1] == f"– {count} of {count} selected hold"
    assert COLOURS[HOLDS] not in badge(report)


def test_the_badge_is_svg_whatever_a_subject_is_called(report):
    report.subject = Subject("<script>&\"'", None)
    assert texts(badge(report))[0] == "<script>&\"' claims"
    report.claims = []
    assert "0 of 0 hold" in texts(badge(report))[1]


def run(folder, **environment):
    command = [sys.executable, "-m", "reports", "pdf", str(folder)]
    return subprocess.run(command, capture_output=True, text=True, timeout=200, **environment)


def test_without_a_page_or_a_browser_it_is_said(tmp_path, monkeypatch):
    done = run(tmp_path)
    assert done.returncode == 2
    assert "index.html does not exist" in done.stderr
    (tmp_path / "index.html").write_text("<p>x</p>")
    monkeypatch.setenv("PATH", str(tmp_path))
    done = run(tmp_path)
    assert done.returncode == 3
    assert "not run: no browser" in done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="a browser of two lines of shell")
def test_a_browser_that_prints_nothing_costs_no_pdf_that_was_there(tmp_path, monkeypatch):
    (tmp_path / "index.html").write_text("<p>x</p>")
    (tmp_path / "report.pdf").write_bytes(b"before")
    fake = tmp_path / "chromium"
    fake.write_text("#!/bin/sh\necho no display >&2\nexit 1\n")
    fake.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    done = run(tmp_path)
    assert done.returncode == 4
    assert "printed no PDF (no display)" in done.stderr
    assert (tmp_path / "report.pdf").read_bytes() == b"before"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["chromium", "index.html", "report.pdf"]


@pytest.mark.skipif(not any(map(shutil.which, pdf.BROWSERS)), reason="not run: no browser")
def test_a_browser_prints_the_page(tmp_path, report):
    (tmp_path / "index.html").write_text(page(report), encoding="utf-8")
    done = run(tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "report.pdf").read_bytes().startswith(b"%PDF")
