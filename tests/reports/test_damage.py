"""Does a damaged record end with 2 and the name of the entry? Any damage at all: `tests/fuzz/records.py`."""

from __future__ import annotations

import json
from dataclasses import asdict

import pytest
from click.testing import CliRunner

from reports.__main__ import main
from validation.record import Case, Picture, finite


@pytest.fixture
def record(report, claim_of, tmp_path):
    """A small record with one of everything, as JSON holds it."""
    report.claims = [claim for claim in report.claims if claim.erratum or claim.id.endswith(("_13", "_10"))][:4]
    report.claims[0].worst = Case(3, 1e-15, 1.0, [1.0, True], [1.0, False], "torus", {"p": [1.0, [2.0]]}, 2)
    report.pictures = [Picture("film", "A film.", "pictures/film.webp", "pictures/film.png")]
    (tmp_path / "pictures").mkdir()
    (tmp_path / "pictures" / "film.webp").write_bytes(b"RIFF film")
    (tmp_path / "pictures" / "film.png").write_bytes(b"\x89PNG film")
    return finite(asdict(report))


def nested(depth: int) -> list:
    """Return a list in a list in a list."""
    return [nested(depth - 1)] if depth else []


def made(folder, text: str):
    """Make the page of a record, and return what the command did."""
    (folder / "report.json").write_text(text, encoding="utf-8")
    return CliRunner().invoke(main, [str(folder)])


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        (("claims", 0, "errors", "log10_edges", 0), -1e300, "claims[0].errors: log10_edges go from -1e+300"),
        (("claims", 0, "n"), "many", "claims[0].n is 'many'"),
        (("claims", 0, "n"), -1, "claims[0]: n = -1"),
        (("claims", 0, "errors", "counts"), [1], "claims[0].errors: counts has 1 bins"),
        (("claims", 1, "tolerance"), None, "claims[1].tolerance is null"),
        (("timings", 0, "nanoseconds"), -5.0, "timings[0]"),
        (("goals", 0, "wanted"), 0.0, "goals[0]"),
        (("goals", 0, "measured"), None, "goals[0]"),
        (("goals", 0, "measured"), 1e30, "goals[0]"),
        (("seconds",), 1e301, "seconds is 1e+301"),
        (("environment",), [], "environment is a list"),
        (("claims", 0, "worst", "inputs", "p"), nested(100), "claims[0].worst.inputs.p[0]"),
        (("pictures", 0, "still"), "../secret.png", "pictures[0]: '../secret.png'"),
        (("pictures", 0, "still"), "/etc/passwd", "pictures[0]: '/etc/passwd'"),
        (("pictures", 0, "animation"), "pictures/film.svg", "pictures[0]: 'pictures/film.svg'"),
    ],
)
def test_the_entry_at_fault_is_named(record, tmp_path, place, value, words):
    holder = record
    for key in place[:-1]:
        holder = holder[key]
    holder[place[-1]] = value
    done = made(tmp_path, json.dumps(record))
    assert done.exit_code == 2, done.output
    assert words in done.output
    assert not (tmp_path / "index.html").exists()


def test_pictures_come_from_the_report_s_own_folder(record, tmp_path):
    secret = tmp_path / "secret.png"
    secret.write_bytes(b"\x89PNG secret")
    out = tmp_path / "out"
    (out / "pictures").mkdir(parents=True)
    (out / "pictures" / "film.webp").write_bytes(b"RIFF film")
    (out / "pictures" / "film.png").symlink_to(secret)
    done = made(out, json.dumps(record))
    assert done.exit_code == 2
    assert "pictures[0]" in done.output
    assert "leads out of the report's folder" in done.output
    assert not (out / "badge.svg").exists(), "the badge would be of another record than the page"


def test_what_is_named_as_an_image_and_is_none_is_refused(record, tmp_path):
    (tmp_path / "pictures" / "film.png").write_bytes(b"root:x:0:0")
    assert "is no image of its kind" in made(tmp_path, json.dumps(record)).output


def test_a_file_that_is_too_large_is_not_read(record, tmp_path, monkeypatch):
    monkeypatch.setattr("validation.record.LARGEST_FILE", 1_000)
    done = made(tmp_path, json.dumps(record))
    assert done.exit_code == 2
    assert "more than 1000" in done.output
