"""The page of the league says what is in its record, whatever that holds, and puts others' results beside."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from reports.__main__ import main
from reports.league import page
from tests.reports.parsed import Parsed
from validation.league.cells import ANSWERED, CANNOT, Cell
from validation.league.drawing import FACES
from validation.league.record import NAME, Drawn, EngineRow, League, TaskRow, merged, read_league, write
from validation.record import FAILS, NOT_RUN

EVIL = "<script>alert(1)</script>\"' onload=x {{ 7*7 }}"
CUBE = [[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)]


def task(name: str, unit: str = "of the way", boxes: bool = True) -> TaskRow:
    below = [[x, y, z - 1.0] for x, y, z in CUBE]
    drawn = [Drawn(CUBE, FACES, [1.0, 0.0, 0.0]), Drawn(below, FACES, [0.0] * 3)]
    return TaskRow(
        id=name,
        family="boxes in motion",
        claim="A box goes its way.",
        detail=EVIL,
        question="move_boxes",
        reference="closed form",
        kind="closed form",
        because="rounding 1e-16",
        unit=unit,
        tolerance=1e-5,
        roundings=1000,
        matters=1e-3,
        cost_of="second of the world",
        bodies=drawn if boxes else [],
    )


def engine(name: str, **other: object) -> EngineRow:
    return EngineRow(
        name, f"Engine {EVIL}", "1.0", "double", [["it", "a setting", EVIL]], {"gas_volume": EVIL}, **other
    )  # type: ignore[arg-type]


def cell(task: str, engine: str, state: str = ANSWERED, error: float | None = 1e-4, **other: object) -> Cell:
    costs = [1e-3, 2e-3, 4e-3] if error is not None else []
    why = EVIL if error is None else None
    return Cell(
        task, engine, **{"steps": 1.0, "iterations": 1.0, **other}, state=state, error=error, n=60, costs=costs, why=why
    )  # type: ignore[arg-type]


@pytest.fixture
def league() -> League:
    cells = [
        cell("boxes.go", "bullet", error=2e-6),
        cell("boxes.go", "bullet", error=2e-7, steps=4.0),
        cell("boxes.go", "jolt", error=5e-5),
        cell("boxes.go", "old", state=NOT_RUN, error=None),
        cell("boxes.go", "softbody", error=0.0),
        cell("boxes.hit", "bullet", error=0.05),
        cell("boxes.hit", "jolt", state=FAILS, error=None),
        cell("boxes.hit", "old", state=CANNOT, error=None),
        cell("boxes.hit", "softbody", error=0.0),
    ]
    engines = [engine("bullet"), engine("jolt"), engine("old"), engine("softbody", is_host=True)]
    engines[1].precision = "single"
    tasks = [task("boxes.go"), task("boxes.hit", "disagreements", boxes=False)]
    return League(
        "quick", 1, "2026-12-01T00:00:00+00:00", 61.0, "abc", {"processor": EVIL}, "suite", engines, tasks, cells
    )


def test_the_page_is_well_formed_complete_and_fetches_nothing(league):
    text = page(league)
    parsed = Parsed(text)
    assert parsed.broken == []
    assert parsed.stack == []
    ids = parsed.all("id")
    assert len(ids) == len(set(ids))
    assert {link[1:] for link in parsed.all("href") if link.startswith("#")} <= set(ids)
    assert not re.search(r"https?://|url\((?!#|data:)|<script", text)
    assert page(league) == text
    assert "3 engines at 2 tasks" in parsed.text


def test_a_cell_is_a_multiple_of_what_matters_and_its_band_is_more_than_colour(league):
    text = page(league)
    cells = dict(re.findall(r'<td class="num cell \w+"><a href="#([\w-]+)"[^>]*>([^<]*)</a>', text))
    assert cells["boxes-go-bullet"] == "<\u202f0.01\u202f✓".replace("<", "&lt;")
    assert cells["boxes-go-softbody"] == "0\u202f✓"
    assert cells["boxes-go-jolt"] == "0.05\u202f✓", "within what a thousand roundings in single precision make"
    assert cells["boxes-go-old"] == "?"
    assert cells["boxes-hit-bullet"] == "3\u00a0of\u00a060"
    assert cells["boxes-hit-jolt"] == "✕"
    assert cells["boxes-hit-old"] == "–"
    bands = dict(re.findall(r'<td class="num cell (\w+)"><a href="#(boxes-hit-[\w]+)"', text))
    assert bands == {
        "far": "boxes-hit-bullet",
        "broken": "boxes-hit-jolt",
        "cannot": "boxes-hit-old",
        "good": "boxes-hit-softbody",
    }


def test_a_league_that_was_interrupted_says_so(league):
    text = Parsed(page(dataclasses.replace(league, left=7))).text
    assert "interrupted" in text
    assert "7 cells were not played" in text
    assert "interrupted" not in Parsed(page(league)).text


def test_the_host_is_marked_and_the_best_effort_is_named(league):
    text = Parsed(page(league)).text
    assert "4 × the steps" in text
    assert "host" in text
    assert "validation replay softbody:boxes.go" in text


def test_results_of_others_stand_beside_without_their_seconds(league, tmp_path):
    write(league, tmp_path / "here" / NAME)
    write(league, tmp_path / "farm" / NAME)
    done = CliRunner().invoke(main, ["league", str(tmp_path / "here"), "--beside", str(tmp_path / "farm" / NAME)])
    assert done.exit_code == 0, done.output
    text = (tmp_path / "here" / "index.html").read_text(encoding="utf-8")
    assert "bullet (farm)" in text
    assert text.count('<br><span class="unit">host</span>') == 1
    assert read_league(tmp_path / "here" / NAME) == league, "the record stays as it was"
    both = merged(league, league, "farm")
    assert not any(one.costs for one in both.cells if one.engine.endswith("(farm)"))


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        ({"suite": "another"}, "is of other tasks"),
        ({"seed": 2}, "another level or seed"),
        ({"schema": "softbody-league/9"}, "has schema"),
        ({"cells": [cell("boxes.go", "nobody")]}, "nobody"),
        ({"cells": [cell("boxes.go", "bullet", state="fine")]}, "damaged"),
    ],
)
def test_a_record_that_cannot_stand_beside_is_refused_by_name(league, tmp_path: Path, damage, said):
    write(league, tmp_path / "here" / NAME)
    write(dataclasses.replace(league, **damage), tmp_path / "farm" / NAME)
    done = CliRunner().invoke(main, ["league", str(tmp_path / "here"), "--beside", str(tmp_path / "farm" / NAME)])
    assert done.exit_code == 2
    assert said in done.output
    assert not (tmp_path / "here" / "index.html").exists()


def test_there_must_be_a_record(tmp_path):
    done = CliRunner().invoke(main, ["league", str(tmp_path)])
    assert done.exit_code == 2
    assert "python -m validation.league" in done.output
