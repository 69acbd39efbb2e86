"""Does a damaged record end with 2 and the name of the entry, never with a traceback, a hang or a file from outside?"""

from __future__ import annotations

import copy
import json
import random
import signal
from dataclasses import asdict

import pytest
from click.testing import CliRunner

from reports.__main__ import main
from validation.record import Case, Picture, finite

RECORDS = 120  # 10 000 were tried by hand
PATIENCE = 30  # [s] of the processor, for one page
STRANGE = [
    None, True, -1, 0, 1, 7, 10**18, 10**30, -(10**400), 1e308, -1e308, 5e-324, 1e-300, 1e17, "", "x",
    "\u0000\u001b[2J",
    "\ud800", "../../etc/passwd", "/etc/passwd", "C:\\x.png", "a" * 10_000, "<script>", "2026-13-99", "holds", "fails",
    "not run", [], {}, [None], [[[]]], [1e308, -1e308], [0.0] * 1_000, {"0": 1e300}, {"schema": "x"}, "disagreements",
]  # fmt: skip


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


def places(data, path=()):
    """Yield the path of every entry."""
    yield path
    for key, value in data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ():
        yield from places(value, (*path, key))


def damaged(record: dict, number: int) -> str:
    """Return the text of a record with one to three entries changed, left out or doubled, or cut, or of other bytes."""
    chance = random.Random(number)
    data = copy.deepcopy(record)
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        *way, last = chance.choice([path for path in places(data) if path])
        holder = data
        for key in way:
            holder = holder[key]
        kind = chance.random()
        if kind < 0.15:
            del holder[last]
        elif kind < 0.25 and isinstance(holder, list):
            holder.extend(copy.deepcopy(holder[last]) for _ in range(3))
        elif kind < 0.35 and isinstance(holder[last], (int, float)) and not isinstance(holder[last], bool):
            holder[last] *= chance.choice((-1, 1e9, -1e9, 1e-9, 1e200))
        else:
            holder[last] = copy.deepcopy(chance.choice(STRANGE))
    text = json.dumps(data, indent=1)
    if chance.random() < 0.1:
        place = chance.randrange(len(text))
        text = chance.choice((text[:place], text[:place] + chance.choice('x"{]0,\x00') + text[place + 1 :]))
    return text


def made(folder, text: str):
    """Make the page of a record, in so much time at most, and return what the command did."""

    def hangs(*_):
        raise AssertionError("the page was not made in time")

    before = signal.signal(signal.SIGPROF, hangs)
    signal.setitimer(signal.ITIMER_PROF, PATIENCE)
    (folder / "report.json").write_text(text, encoding="utf-8", errors="surrogatepass")
    done = CliRunner().invoke(main, [str(folder)])
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    signal.signal(signal.SIGPROF, before)
    return done


def look(folder, done, number: object) -> None:
    """See that a page was made, or that the file was refused by name."""
    assert done.exception is None or isinstance(done.exception, SystemExit), (number, done.exc_info)
    assert done.exit_code in (0, 2), (number, done.output)
    assert done.exit_code == 0 or "report.json" in done.output or "pictures[" in done.output, (number, done.output)


def test_whatever_is_damaged_is_refused_or_shown(record, tmp_path):
    assert made(tmp_path, json.dumps(record)).exit_code == 0
    codes = []
    for number in range(RECORDS):
        done = made(tmp_path, damaged(record, number))
        look(tmp_path, done, number)
        codes.append(done.exit_code)
    assert 0.2 * RECORDS < codes.count(2) < RECORDS


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        (("claims", 0, "errors", "log10_edges", 0), -1e300, "claims[0].errors: log10_edges go from -1e+300"),
        (("claims", 0, "n"), "many", "claims[0].n is 'many'"),
        (("claims", 0, "n"), -1, "claims[0]: n = -1"),
        (("claims", 0, "errors", "counts"), [1], "claims[0].errors: counts has 1 bins"),
        (("claims", 1, "tolerance"), None, "claims[1].tolerance is null"),
        (("timings", 0, "nanoseconds"), -5.0, "timings[0]"),
        (("seconds",), 1e301, "seconds is 1e+301"),
        (("environment",), [], "environment is a list"),
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


def test_what_is_named_as_an_image_and_is_none_is_refused(record, tmp_path):
    (tmp_path / "pictures" / "film.png").write_bytes(b"root:x:0:0")
    assert "is no image of its kind" in made(tmp_path, json.dumps(record)).output


def test_a_file_that_is_too_large_is_not_read(record, tmp_path, monkeypatch):
    monkeypatch.setattr("validation.record.LARGEST_FILE", 1_000)
    done = made(tmp_path, json.dumps(record))
    assert done.exit_code == 2
    assert "more than 1000" in done.output
