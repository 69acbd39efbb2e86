"""A damaged record is refused by name, or makes a page of its own folder: no traceback, no hang, no foreign tags."""

from __future__ import annotations

import base64
import copy
import json
import random
import tempfile
import time
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from click.testing import CliRunner

from reports.__main__ import main
from tests.fuzz.bytes import cut, flipped, spliced, written_over
from tests.reports.conftest import make_report
from tests.reports.parsed import Parsed
from validation.journal import NAME, SCHEMA, CannotRunHereError, Journal
from validation.record import Case, OpenErratum, Picture, PlantedFault, Sensitivity, finite, write_report

TRIES = 25  # records an attempt
GOAL = 10_000

PATIENCE = 30.0  # [s] of the processor, for one page
SECRET = b"not of this folder"
IMAGES = {"film.webp": b"RIFF film", "film.png": b"\x89PNG film"}
PATHS = (
    "../secret.png", "pictures/../../secret.png", "..\\secret.png", "pictures/link.png", "/etc/passwd", "C:\\x.png",
    "{folder}/../secret.png", "file://{folder}/../secret.png", "pictures", "pictures/film.svg", "pictures/none.png", "",
)  # fmt: skip
TEXTS = (
    "<script>alert(1)</script>", "</style><script>", '"><img src=x onerror=alert(1)>', "' onload=x", "{{ 7*7 }}",
    "javascript:alert(1)", "]]>", "&amp;&#0;", "\u0000\u001b[2J", "\ud800", "\u202e", "a" * 10_000, "a" * 200_000, "x",
    ", " * 3_000, "4." * 2_000, "1e5 " * 1_000, "E" + "9" * 10_000, "2026-13-99", "holds", "fails", "not run", "", "—",
    "disagreements",
)  # fmt: skip
NUMBERS = (
    None, True, -1, 0, 1, 7, 10**18, 2**63, 10**30, -(10**400), 1e300, 1e308, -1e308, 5e-324, 1e-300, 1e17, 0.5,
)  # fmt: skip
OTHERS = ([], {}, [None], [[[]]], [1e308, -1e308], [0.0] * 1_000, {"0": 1e300}, {"schema": "x"}, {"": {}}, ["x"] * 3)
DEPTHS = (10, 200, 400, 900, 5_000, 100_000)


@cache
def record() -> dict[str, Any]:
    """Return a record with one of everything, as JSON holds it."""
    report = make_report()
    report.claims = [one for one in report.claims if one.erratum or one.arbitrations or one.id.endswith(("_13", "_10"))]
    report.claims = [*report.claims[:3], *(one for one in report.claims[3:] if one.arbitrations)]
    report.timings = [one for one in report.timings if one.table == "A step" and one.size > 20_000]
    report.claims[0].worst = Case(3, 1e-15, 1.0, [1.0, True], [1.0, False], "torus", {"p": [1.0, [2.0]]}, 2)
    for claim in report.claims:
        claim.faults = ["a sign", "a factor"]
    ids = [claim.id for claim in report.claims]
    report.sensitivity = Sensitivity(
        [PlantedFault("a sign", "softbody.linalg.vec.dot", ids, "caught")], None, 110, 97, 10
    )
    report.open_errata = [OpenErratum("E4", "divides", "does not", "both are the same")]
    report.unnamed = ["softbody.World.run"]
    report.pictures = [Picture("film", "A film.", "pictures/film.webp", "pictures/film.png")]
    data: dict[str, Any] = finite(asdict(report))
    return data


def attempt(seed: int) -> str | None:
    """Damage some records; make the page of each, in a folder whose neighbour is a secret."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "report"
        (folder / "pictures").mkdir(parents=True)
        for name, raw in IMAGES.items():
            (folder / "pictures" / name).write_bytes(raw)
        (Path(place) / "secret.png").write_bytes(b"\x89PNG" + SECRET)
        (folder / "pictures" / "link.png").symlink_to(Path(place) / "secret.png")
        for number in range(seed * TRIES, (seed + 1) * TRIES):
            chance = random.Random(number)
            wrong = (_journal if chance.random() < 0.2 else _report)(folder, chance, number)
            if wrong:
                return f"record {number}: {wrong}"
    return None


def _report(folder: Path, chance: random.Random, number: int) -> str | None:
    """Damage a report."""
    (folder / "report.json").write_bytes(_damaged(record(), folder, chance, number))
    return _look(folder)


def _journal(folder: Path, chance: random.Random, number: int) -> str | None:
    """Damage the journal of a run; if a run could go on with it, its report makes a page."""
    head = {"schema": SCHEMA, "level": "quick", "seed": 1}
    lines = [head, *record()["claims"]]
    at = chance.randrange(len(lines))
    raw = [json.dumps(line).encode() for line in lines]
    raw[at] = _damaged(lines[at], folder, chance, number).replace(b"\n", b" " if chance.random() < 0.7 else b"\n")
    text = b"\n".join(raw) + b"\n" * (chance.random() < 0.8)
    (folder / NAME).write_bytes(text)
    try:
        with Journal(folder, head, resume=True, say=lambda said: None) as journal:
            claims = list(journal.records.values())
    except CannotRunHereError as error:
        if (folder / NAME).read_bytes() != text:
            return "the journal is refused, and was changed"
        return None if NAME in str(error) and "\n" not in str(error) else f"refused, and not named: {error}"
    sound = make_report(5)
    sound.claims = claims
    write_report(sound, folder / "report.json")
    return _look(folder)


def _look(folder: Path) -> str | None:
    """Make the page, and see that the record was shown as what it is, or refused by a line that names it."""
    page = folder / "index.html"
    before = {path: path.read_bytes() for path in (page, folder / "badge.svg") if path.exists()}
    begun = time.process_time()
    done = CliRunner().invoke(main, [str(folder)])
    seconds = time.process_time() - begun
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        return f"{type(done.exception).__name__}: {done.exception}"[:300]
    if seconds > PATIENCE:
        return f"{seconds:.0f} s of the processor"
    if done.exit_code == 2:
        if {path: path.read_bytes() for path in before} != before:
            return "it is refused, and the page before is another now"
        is_named = done.output.startswith("Error: ") and ("report.json" in done.output or "pictures[" in done.output)
        return None if is_named and done.output.count("\n") == 1 else f"refused, and not by one line: {done.output!r}"
    if done.exit_code:
        return f"exit code {done.exit_code}: {done.output}"
    text = page.read_text(encoding="utf-8")
    if any(base64.b64encode(b"\x89PNG" + SECRET)[k : k + 16].decode() in text for k in (0, 8)):
        return "a file from outside is in the page"
    return _foreign(Parsed(text), text)


def _foreign(parsed: Parsed, text: str) -> str | None:
    """Return what a page has that no page of ours has."""
    if parsed.broken or parsed.stack or text.count("<script") != 1:
        return "the tags of a text are tags of the page"
    if any(name.startswith("on") for _, attributes in parsed.tags for name in attributes):
        return "a text is a handler"
    links = parsed.all("href") + parsed.all("src") + parsed.all("srcset")
    strange = {one for one in links if not one.startswith(("#", "data:image/", "data:,"))} - {
        "report.json",
        "junit.xml",
    }
    return f"it links to {sorted(strange)}"[:300] if strange else None


def _damaged(sound: dict[str, Any], folder: Path, chance: random.Random, number: int) -> bytes:
    """Return a record with entries changed, left out, doubled, nested or renamed, or with bytes that are others."""
    if chance.random() < 0.25:
        raw = json.dumps(sound, indent=1).encode()
        way = chance.choice((flipped, written_over, cut, spliced))
        return way(raw, np.random.default_rng(number)) or b"\x00"
    data = copy.deepcopy(sound)
    places = [place for place in _places(data) if place]
    for _ in range(chance.choice((1, 1, 1, 2, 3, 8))):
        *way, last = chance.choice(places)
        try:
            holder: Any = data
            for key in way:
                holder = holder[key]
            _change(holder, last, folder, chance)
        except (LookupError, TypeError, OverflowError):  # it is gone since, or as large as can be
            continue
    text = json.dumps(data, indent=1)
    if chance.random() < 0.1:  # deeper than json writes
        deep, (left, right) = chance.choice(DEPTHS), chance.choice(("[]", ('{"a":', "}")))
        text = text.replace(
            chance.choice(("1.0", "1e-15", '"torus"', "null", "[]")), left * deep + "1" + right * deep, 1
        )
    return text.encode("utf-8", "surrogatepass")


def _change(holder: Any, last: Any, folder: Path, chance: random.Random) -> None:
    """Change one entry."""
    kind, value = chance.random(), holder[last]
    if kind < 0.12:
        del holder[last]
    elif kind < 0.2 and isinstance(holder, list):
        holder.extend(copy.deepcopy(value) for _ in range(chance.choice((1, 3, 200))))
    elif kind < 0.3 and isinstance(value, (int, float)) and not isinstance(value, bool):
        holder[last] = value * chance.choice((-1, 1e9, -1e9, 1e-9, 1e200))
    elif kind < 0.35 and isinstance(holder, dict):
        holder[chance.choice(TEXTS[:12])] = holder.pop(last)
    elif isinstance(value, str) and (last in ("animation", "still") or kind < 0.4):
        holder[last] = chance.choice(PATHS).format(folder=folder)
    elif isinstance(value, str) and kind < 0.8:  # what is of the right kind goes further
        holder[last] = chance.choice(TEXTS)
    elif isinstance(value, (int, float)) and kind < 0.8:
        holder[last] = chance.choice(NUMBERS)
    else:
        holder[last] = copy.deepcopy(chance.choice((*TEXTS, *NUMBERS, *OTHERS)))


def _places(data: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the path of every entry."""
    inner = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    return [path, *(place for key, value in inner for place in _places(value, (*path, key)))]
