"""What a league leaves behind: league.json, from which its page is made, and which others' results are merged into."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path

from validation.league.cells import STATES, Cell
from validation.record import read_document, write_whole

SCHEMA = "softbody-league/1"
NAME = "league.json"


@dataclass
class EngineRow:
    """An engine, as its adapter says."""

    name: str
    title: str  # the first line of its adapter
    version: str | None
    precision: str
    settings: list[list[str]]  # what was chosen, and why
    cannot: dict[str, str]  # question → why it has no answer
    is_host: bool = False  # it is this project's own
    of: str = ""  # the run that its cells are from, if it is another's


@dataclass
class Drawn:
    """A body, at the start, as a task's picture shows it; of a large box, the part that is near the others."""

    vertices: list[list[float]]  # (n, 3) [m]
    faces: list[list[int]]  # each counter-clockwise from outside
    velocity: list[float]  # (3,) [m/s]


@dataclass
class TaskRow:
    """A task, as its claim says."""

    id: str
    family: str
    claim: str
    detail: str
    question: str
    reference: str
    kind: str
    because: str
    unit: str
    tolerance: float
    roundings: int
    matters: float
    cost_of: str
    bodies: list[Drawn] = field(default_factory=list)  # that are asked about first


@dataclass
class League:
    """A whole run."""

    level: str
    seed: int
    started: str
    seconds: float
    revision: str | None
    machine: dict[str, str]
    suite: str  # a digest of the tasks: cells of other tasks are not put beside these
    engines: list[EngineRow]
    tasks: list[TaskRow]
    cells: list[Cell]
    left: int = 0  # cells that an interrupt has left out
    schema: str = SCHEMA


def write(league: League, path: Path) -> None:
    """Write a league to a file, whole or not at all; raises OSError."""
    write_whole(path, json.dumps(asdict(league), ensure_ascii=False, indent=0) + "\n")


def read_league(path: Path) -> League:
    """Read a league; raises ValueError, naming the file and what is wrong with it, and OSError."""
    league = read_document(path, League, (SCHEMA,), "run `make league` again")
    engines, tasks = {one.name for one in league.engines}, {one.id for one in league.tasks}
    for cell in league.cells:
        if cell.engine not in engines or cell.task not in tasks or cell.state not in STATES:
            raise ValueError(f"{path} is damaged: a cell of {cell.engine} at {cell.task} is of nobody that it names")
    return league


def merged(league: League, other: League, name: str) -> League:
    """Return a league with the engines of another beside its own; raises ValueError if its tasks differ.

    Costs of another machine, or another run, are not compared: they are left out.
    """
    if (other.suite, other.level, other.seed) != (league.suite, league.level, league.seed):
        raise ValueError(f"{name} is of other tasks, another level or seed: run it with this revision of the suite")
    taken = {one.name for one in league.engines}
    names = {one.name: one.name if one.name not in taken else f"{one.name} ({name})" for one in other.engines}
    rows = [
        EngineRow(**{**asdict(one), "name": names[one.name], "is_host": False, "of": name}) for one in other.engines
    ]
    cells = [Cell(**{**asdict(one), "engine": names[one.engine], "costs": []}) for one in other.cells]
    return League(**{**vars(league), "engines": [*league.engines, *rows], "cells": [*league.cells, *cells]})
