"""Goals of speed, as ratios to what ran beside the core, and how far it is from them.

Each goal is of a row of ours in a table that the benchmarks fill, and counts where it is worst of the sizes that it is
for. What was not measured, since it takes another level, another package or another processor, is said to be so.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase
from statistics import linear_regression
from typing import Any

import numpy as np

from benchmarks.running import Document, competitors

MET, MISSED, CLOSE, NOT_MEASURED = "met", "missed", "too close to call", "not measured"
CLOCK = "the clock"
ALL = (0.0, math.inf)


@dataclass(frozen=True)
class Goal:
    """How many times as fast as a peer, or as the clock, ours is to be, of `sizes` of a table.

    Names are patterns, as of files; table and name are those of the benchmark whose goal it is, unless said.
    """

    peer: str
    least: float
    sizes: tuple[float, float] = ALL
    name: str = ""
    table: str = ""


@dataclass(frozen=True)
class Growth:
    """The exponent with which the whole cost may grow, at most, from one size to another."""

    most: float
    sizes: tuple[float, float] = ALL
    name: str = ""
    table: str = ""


@dataclass(frozen=True)
class Outcome:
    """What a goal has come to."""

    table: str
    what: str  # whose goal, against whom, of which sizes
    wanted: float  # at least, of how many times as fast; at most, of exponents
    is_least: bool
    verdict: str
    measured: float | None = None  # median of the rounds, at the worst size
    low: float | None = None  # lower quartile
    high: float | None = None  # upper quartile
    where: str = ""  # the worst size, or those between which a growth was measured


Race = dict[str, Any]  # as pytest-benchmark writes it


def outcomes(document: Document, goals: Iterable[Goal | Growth]) -> Iterator[Outcome]:
    """Yield what each goal has come to in a run of the benchmarks."""
    races = [race for race in document["benchmarks"] if "table" in race["extra_info"]]
    for goal in goals:
        fitting = sorted((race for race in races if _is_of(race, goal)), key=lambda race: race["extra_info"]["size"])
        yield _of_growth(goal, fitting) if isinstance(goal, Growth) else _of_speed(goal, fitting)


def _is_of(race: Race, goal: Goal | Growth) -> bool:
    info, (least, most) = race["extra_info"], goal.sizes
    return fnmatchcase(info["table"], goal.table) and least <= info["size"] <= most


def _of_speed(goal: Goal, races: list[Race]) -> Outcome:
    """Return how far a goal is met at the size at which it is missed by most, or met by least."""
    found, names = [], (goal.name.rstrip(" *"), goal.peer.rstrip(" *"))
    for race in races:
        seconds = _seconds(race)
        pair = [next((name for name in seconds if fnmatchcase(name, one)), None) for one in (goal.name, goal.peer)]
        if pair[0] is not None and pair[1] is not None:
            names = pair[0], pair[1]
            low, median, high = np.quantile(seconds[names[1]] / seconds[names[0]], (0.25, 0.5, 0.75)).tolist()
            found.append((median, low, high, _size(race), str(race["extra_info"]["table"])))
    what = f"{names[0]} against {names[1]}{_sizes(goal, races)}"
    if not found:
        return Outcome(_table(goal, races), what, goal.least, True, NOT_MEASURED)
    median, low, high, where, table = min(found)
    return Outcome(table, what, goal.least, True, _verdict(median, low, high, goal.least), median, low, high, where)


def _of_growth(goal: Growth, races: list[Race]) -> Outcome:
    """Return the exponent of least squares; not measured of fewer than three sizes."""
    points: list[tuple[float, float]] = []
    for race in races:
        seconds, size = _seconds(race), race["extra_info"]["size"]
        if goal.name in seconds:
            points.append((math.log(size), math.log(size * float(np.median(seconds[goal.name])))))
    what = f"growth of {goal.name}{_sizes(goal, races)}"
    if len(points) < 3:
        return Outcome(_table(goal, races), what, goal.most, False, NOT_MEASURED)
    slope = linear_regression(*zip(*points)).slope
    verdict = MET if slope <= goal.most else MISSED
    where = f"{_size(races[0])} to {_size(races[-1])}"
    return Outcome(_table(goal, races), what, goal.most, False, verdict, slope, None, None, where)


def _seconds(race: Race) -> dict[str, np.ndarray]:
    """Return seconds per unit of every competitor, round by round; of the clock, too, where it moves."""
    clock = race["extra_info"].get("clock")
    seconds = competitors(race)
    return seconds if clock is None else seconds | {CLOCK: np.full(len(race["stats"]["data"]), float(clock))}


def _verdict(median: float, low: float, high: float, least: float) -> str:
    """Return MET or MISSED, or CLOSE where the goal lies between the quartiles."""
    if low < least <= high:
        return CLOSE
    return MET if median >= least else MISSED


def _table(goal: Goal | Growth, races: list[Race]) -> str:
    return str(races[0]["extra_info"]["table"]) if races else goal.table.rstrip("*: ")


def _size(race: Race) -> str:
    return f"{_count(race['extra_info']['size'])} {race['extra_info']['of']}"


def _sizes(goal: Goal | Growth, races: list[Race]) -> str:
    """Return for which sizes a goal is, in words."""
    least, most = goal.sizes
    of = f" {races[0]['extra_info']['of']}" if races else ""
    if goal.sizes == ALL:
        return ""
    if least == most:
        return f", {_count(least)}{of}"
    if not least:
        return f", to {_count(most)}{of}"
    return f", from {_count(least)}{of}" if most == math.inf else f", {_count(least)} to {_count(most)}{of}"


def _count(size: float) -> str:
    return f"{size:,.0f}".replace(",", " ")
