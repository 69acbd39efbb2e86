"""What a validation run leaves behind: the record in report.json, version 1 of its schema.

`Report` is the document; its fields, and those of the classes it holds, are the schema. Numbers that JSON cannot
hold (NaN, infinity) are written as null. Reports are built from this file alone, so an old record can be shown
again without running anything.
"""

from __future__ import annotations

import json
import math
import os
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

SCHEMA = "softbody-report/1"

HOLDS = "holds"
FAILS = "fails"
NOT_RUN = "not run"
BROKEN = "engine broken"  # an engine that is installed gave no answer, or nonsense: no fault of the core

# Who judges: an engine or a library that somebody else wrote, or what needs none.
ENGINE, LIBRARY = "third-party engine", "third-party library"
KINDS = {
    ENGINE: "another simulator, or collision library, answers the same question",
    LIBRARY: "mathematics of SciPy, libigl or trimesh, on formulas written apart from the core",
    "closed form": "a formula, evaluated by NumPy apart from the core",
    "exact arithmetic": "rational numbers: no rounding at all",
    "exhaustive search": "every possible answer tried, apart from the core",
    "specification": "what the documentation promises, in so many words",
    "invariant": "what must not change, whatever the answer is",
    "bound": "what must not be exceeded",
    "the core in another form": "two ways of the core itself must agree: nobody from outside is asked",
}


@dataclass
class Distribution:
    """How the errors of a claim are distributed: enough to plot them beside the tolerance."""

    quantiles: dict[str, float]  # "0", "0.5", "0.9", "0.99", "1" → error
    zeros: int  # errors that are exactly 0, which have no logarithm
    log10_edges: list[float]  # edges of the histogram's bins, in log10 of the error
    counts: list[int]  # errors in each bin; len(log10_edges) − 1 of them


@dataclass
class Group:
    """The errors of one kind of case within a claim, such as one mesh or one integrator."""

    label: str
    n: int
    median: float | None
    p99: float | None
    max: float | None


@dataclass
class Erratum:
    """What a formula as printed in the paper would have done on the same cases."""

    id: str  # "E1" …
    prints: str  # the formula as printed
    right: str  # the right one
    printed_value: float | None = None  # largest error of the printed form, in the claim's unit
    printed_median: float | None = None
    printed_wrong: float | None = None  # share of the cases in which the printed form exceeds the claim's tolerance


@dataclass
class ClaimRecord:
    """One claim and what became of it."""

    id: str
    family: str
    claim: str  # one sentence
    section: str  # of the paper
    piece: str  # of the core, dotted
    reference: str  # who judged, in words
    engines: list[str]  # packages the judgement needs
    unit: str  # of value and tolerance, such as "relative", "m/s", "disagreements"
    value: float | None  # the largest error; null if not run
    tolerance: float
    because: str  # why that tolerance
    detects: str  # the smallest fault that turns the claim red
    n: int  # comparisons made
    seed: int
    verdict: str  # HOLDS, FAILS, NOT_RUN or BROKEN
    why: str | None  # if it does not hold, in words
    seconds: float
    errors: Distribution | None = None
    groups: list[Group] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)  # what the judge saw, such as cases that it had to skip
    erratum: Erratum | None = None
    kind: str = ""  # of judge, such as "third-party engine"; "" in records that do not know


@dataclass
class TrendStep:
    """A change of level in a trend."""

    at: int  # number of the first run after it
    ratio: float  # of the new level to the old one
    started: str  # of that run, ISO 8601
    before: str  # revision of the run before it
    revision: str  # of that run


@dataclass
class Trend:
    """How a timing of ours has changed from run to run, as the benchmarks' history has it."""

    file: str
    name: str  # of the benchmark
    row: dict[str, Any]  # table, name, size, of, per: those of `Timing`
    peer: str | None  # whose time in the same run is 1; None: there is none, and values are ns
    started: list[str]  # ISO 8601, one a run, oldest first
    values: list[float]
    steps: list[TrendStep]

    @property
    def unit(self) -> str:
        """Of the values."""
        return f"× {self.peer}" if self.peer else f"ns per {self.row['per']}"


def read_trend(data: dict[str, Any]) -> Trend:
    """Return a trend from what JSON has of it."""
    return Trend(**data | {"steps": [TrendStep(**step) for step in data["steps"]]})


@dataclass
class Timing:
    """One row of a timing table: ours, or a peer that ran in turns with ours in the same process."""

    table: str  # what was timed, such as "A time step of one soft body"
    name: str  # who: the first name of a table is ours
    size: int  # how large the case was, in …
    of: str  # … these, such as "particles"
    per: str  # what the time is per, such as "particle and step"
    nanoseconds: float  # median of the rounds
    low: float  # lower quartile
    high: float  # upper quartile
    rounds: int
    ratio: float | None = None  # of a peer: its time over ours, median of the rounds' ratios
    low_ratio: float | None = None  # lower quartile
    high_ratio: float | None = None  # upper quartile
    error: float | None = None  # how far from the truth it ended, relative, where precision is the point
    own: bool = False  # a peer that is the core, too: no yardstick for it
    trend: Trend | None = None  # of ours, from the history of benchmarks that were run before


@dataclass
class Figure:
    """One number that is no claim and no race, such as how long a start takes."""

    name: str
    value: float
    unit: str


@dataclass
class Picture:
    """A scene that was run and filmed; paths are relative to the report."""

    name: str
    caption: str
    animation: str
    still: str


@dataclass
class Behaviour:
    """What was seen of a scene that was run by one set of rules."""

    scene: str
    rules: str  # the first of a scene's are the defaults
    seconds: float  # that it ran, in its own time
    penetration: float | None  # deepest of anything in anything, of the size of the largest soft body
    energy_gain: float | None  # largest rise above an earlier value, of what the weights do by falling to the ground
    slip: float | None  # mean speed at which touching particles slide, of the body's; None where nothing rolls
    cost: float  # time of a step, of that by the defaults
    real_time: float  # simulated seconds a second
    tunnelled: float | None = None  # share of fast balls that went through a plate; None where nothing is shot


@dataclass
class Report:
    """A whole validation run."""

    level: str
    seed: int
    created: str  # ISO 8601, UTC
    seconds: float
    softbody_version: str
    revision: str | None  # git commit, with "+" if the working tree differs
    environment: dict[str, str]
    engines: dict[str, str | None]  # package → version, or null where it is missing
    claims: list[ClaimRecord]
    timings: list[Timing] = field(default_factory=list)
    timings_why: str | None = None  # why there are no timings, if there are none
    trends_why: str | None = None  # why timings have no trends, if none has one
    pictures: list[Picture] = field(default_factory=list)
    figures: list[Figure] = field(default_factory=list)
    behaviours: list[Behaviour] = field(default_factory=list)
    schema: str = SCHEMA


def write_report(report: Report, path: Path) -> None:
    """Write `report` as JSON, whole or not at all."""
    write_whole(path, json.dumps(_finite(asdict(report)), indent=1, ensure_ascii=False) + "\n")


def read_report(path: Path) -> Report:
    """Read a report; raises ValueError, naming the file, if it is not one of this schema."""
    data = read_document(path, SCHEMA, "run the validation again")
    data["claims"] = [_claim(claim) for claim in data["claims"]]
    data["timings"] = [_timing(timing) for timing in data["timings"]]
    data["figures"] = [Figure(**figure) for figure in data.get("figures", [])]
    data["pictures"] = [Picture(**picture) for picture in data.get("pictures", [])]
    data["behaviours"] = [Behaviour(**behaviour) for behaviour in data.get("behaviours", [])]
    return Report(**data)


def read_document(path: Path, schema: str, cure: str) -> dict[str, Any]:
    """Read JSON of a schema; raises ValueError with the file, what it is, and the cure."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{path} is not JSON ({error}); {cure}") from error
    if not isinstance(data, dict) or data.get("schema") != schema:
        found = data.get("schema") if isinstance(data, dict) else type(data).__name__
        raise ValueError(f"{path} has schema {found!r}, not {schema!r}; {cure}")
    return data


def write_whole(path: Path, text: str) -> None:
    """Write a text file by way of a temporary one, so that a reader never sees half of it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    with temporary.open("w", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    temporary.replace(path)


def _timing(data: dict[str, Any]) -> Timing:
    trend = data.get("trend")
    return Timing(**data | {"trend": trend and read_trend(trend)})


def _claim(data: dict[str, Any]) -> ClaimRecord:
    known = {f.name for f in fields(ClaimRecord)}
    data = {key: value for key, value in data.items() if key in known}
    data["errors"] = Distribution(**data["errors"]) if data["errors"] else None
    data["groups"] = [Group(**group) for group in data["groups"]]
    data["erratum"] = Erratum(**data["erratum"]) if data["erratum"] else None
    return ClaimRecord(**data)


def _finite(value: Any) -> Any:
    """Replace numbers that JSON cannot hold by None, all the way down."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return value
