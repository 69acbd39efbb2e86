"""What a validation run leaves behind: the record in report.json, version 2 of its schema.

`Report` is the document; its fields, and those of the classes it holds, are the schema. Numbers that JSON cannot
hold (NaN, infinity) are written as null. Reports are built from this file alone, so an old record can be shown
again without running anything: version 1, which has no worst cases, is read, too.
"""

from __future__ import annotations

import json
import math
import os
from dataclasses import asdict, dataclass, field
from itertools import pairwise
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any, TypeVar

from validation.from_json import from_json as from_json

SCHEMA = "softbody-report/2"
READABLE = ("softbody-report/1", SCHEMA)
LARGEST_FILE = 64 * 2**20  # bytes; a run of all claims leaves some hundred kilobytes
SHORTEST, LONGEST = 1e-12, 1e18  # nanoseconds, and ratios of them
LOGS = 400.0  # no double has a larger absolute log10
IMAGES = (".png", ".webp")
ARRAYS = (".npz",)

Document = TypeVar("Document")

HOLDS = "holds"
FAILS = "fails"
NOT_RUN = "not run"
BROKEN = "engine broken"  # an engine that is installed gave no answer, or nonsense: no fault of the core

MET, MISSED, UNMEASURED = "met", "missed", "not measured"  # verdicts on a goal, as the benchmarks give them

# Who judges: an engine or a library that somebody else wrote, or what needs none.
ENGINE, LIBRARY = "third-party engine", "third-party library"
KINDS = {
    ENGINE: "another simulator, or collision library, answers the same question",
    LIBRARY: "SciPy, libigl, trimesh or Pillow, on formulas written apart from the core, or on files that it wrote",
    "closed form": "a formula, evaluated by NumPy apart from the core",
    "exact arithmetic": "rational numbers: no rounding at all",
    "exhaustive search": "every possible answer tried, apart from the core",
    "specification": "what the documentation promises, in so many words",
    "invariant": "what must not change, whatever the answer is",
    "bound": "what must not be exceeded",
    "the core in another form": "two ways of the core itself must agree: nobody from outside is asked",
}
ROOMS = {  # of claims: folder → what they are about
    "geometry": "Meshes and geometry",
    "boxes": "Rigid boxes",
    "soft": "Soft bodies",
    "worlds": "Whole worlds",
    "contract": "What users set, files and pictures",
}
OTHERS = ""  # the room of claims that are in none: of plug-ins, of other engines, of older records
OUTSIDE = (ENGINE, LIBRARY, "closed form", "exact arithmetic")  # kinds of judge that answer apart from the core


@dataclass
class Distribution:
    """How the errors of a claim are distributed: enough to plot them beside the tolerance."""

    quantiles: dict[str, float]  # "0", "0.5", "0.9", "0.99", "1" → error
    zeros: int  # errors that are exactly 0, which have no logarithm
    log10_edges: list[float]  # edges of the histogram's bins, in log10 of the error
    counts: list[int]  # errors in each bin; len(log10_edges) − 1 of them

    def __post_init__(self) -> None:
        """Raise ValueError for a histogram that cannot be drawn."""
        edges, counts = self.log10_edges, self.counts
        if any(abs(edge) > LOGS for edge in edges):
            raise ValueError(f"log10_edges go from {min(edges)} to {max(edges)}: no error has such a logarithm")
        if any(right <= left for left, right in pairwise(edges)):
            raise ValueError("log10_edges do not rise from each to the next")
        if len(counts) != max(0, len(edges) - 1):
            raise ValueError(f"counts has {len(counts)} bins, and log10_edges has {len(edges)} edges")
        if min([self.zeros, *counts]) < 0:
            raise ValueError("zeros and counts hold a number below 0")


@dataclass
class Group:
    """The errors of one kind of case within a claim, such as one mesh or one integrator."""

    label: str
    n: int
    median: float | None
    p99: float | None
    max: float | None


@dataclass
class Case:
    """One comparison: what it was about, and what both sides answered."""

    number: int  # from 0
    error: float | None  # in the claim's unit
    scale: float | None  # that the difference of the answers is divided by
    measured: list[Any]  # the core's answer: numbers, or yes-or-no
    expected: list[Any]  # the judge's
    group: str | None = None  # the kind of case
    inputs: dict[str, Any] = field(default_factory=dict)  # what was asked, as far as the claim says it
    length: int = 0  # of an answer, of which `measured` and `expected` hold the first numbers


@dataclass
class Standing:
    """How somebody, the core included, stood before an arbiter."""

    who: str
    n: int  # answers
    wrong: int  # of them
    worst: float | None  # the largest error
    case: Case | None = None  # in which it was made, if one is wrong; `expected` is the truth

    def __post_init__(self) -> None:
        """Raise ValueError for more wrong answers than answers."""
        if not 0 <= self.wrong <= self.n:
            raise ValueError(f"{self.wrong} of {self.n} answers are wrong: it cannot be")


@dataclass
class Arbitration:
    """Who was right, of several that were asked the same."""

    by: str  # what knows the truth, such as "exact arithmetic"
    disputed: int  # cases in which some were right, and some wrong
    tolerance: float  # beyond which an answer is wrong; 0 for yes-or-no
    standings: list[Standing]


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
class OpenErratum:
    """An erratum of the paper that this run has no numbers for."""

    id: str
    prints: str
    right: str
    why: str  # it has none


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
    n: int  # comparisons made
    seed: int  # that replays it: of several draws, the worst one's
    verdict: str  # HOLDS, FAILS, NOT_RUN or BROKEN
    why: str | None  # if it does not hold, in words
    seconds: float
    errors: Distribution | None = None
    groups: list[Group] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)  # what the judge saw, such as cases that it had to skip
    erratum: Erratum | None = None
    kind: str = ""  # of judge, such as "third-party engine"; "" in records that do not know
    worst: Case | None = None  # the case with the largest error, also of a claim that holds
    arbitrations: list[Arbitration] = field(default_factory=list)  # who was right, where answers differ
    faults: list[str] = field(default_factory=list)  # names of those that are planted to turn it red
    detail: str = ""  # what else is claimed, and of which cases
    room: str = OTHERS  # what claims like it are about, such as "Rigid boxes"
    draws: int = 1  # of its cases, with seeds of their own: what is said is the worst, or the sum (validation/draws.py)

    def __post_init__(self) -> None:
        """Raise ValueError for numbers that contradict each other."""
        if self.n < 0 or (self.tolerance is not None and self.tolerance < 0.0) or (self.value or 0.0) < 0.0:
            raise ValueError(f"n = {self.n}, value = {self.value}, tolerance = {self.tolerance}: none can be below 0")


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

    def __post_init__(self) -> None:
        """Raise ValueError for what cannot be drawn as runs with steps between them."""
        if not self.values or len(self.values) != len(self.started):
            raise ValueError(f"{len(self.values)} values of {len(self.started)} runs: give one a run")
        if not all(SHORTEST <= value <= LONGEST for value in self.values):
            raise ValueError(f"values from {min(self.values)} to {max(self.values)} are no times")
        places = [0, *(step.at for step in self.steps), len(self.values)]
        if any(after <= before for before, after in pairwise(places)):
            raise ValueError(f"steps at {places[1:-1]} of {len(self.values)} runs: each has runs before and after it")
        if not all(SHORTEST <= step.ratio <= LONGEST for step in self.steps):
            raise ValueError("the ratio of a step is no ratio of times")
        missing = {"table", "name", "size", "of", "per"} - {name for name, one in self.row.items() if one is not None}
        if missing:
            raise ValueError(f"row does not say its {', '.join(sorted(missing))}")

    @property
    def unit(self) -> str:
        """Of the values."""
        return f"× {self.peer}" if self.peer else f"ns per {self.row['per']}"


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

    def __post_init__(self) -> None:
        """Raise ValueError for numbers that are no times."""
        times = self.nanoseconds, self.low, self.high, self.ratio, self.low_ratio, self.high_ratio
        if not all(not one or SHORTEST <= one <= LONGEST for one in times):
            raise ValueError(f"{self.name}: {', '.join(str(one) for one in times)} are no times, and ratios of them")
        if self.size < 0 or self.rounds < 0 or (self.error or 0.0) < 0.0:
            raise ValueError(f"size {self.size}, rounds {self.rounds}, error {self.error}: none can be below 0")


@dataclass
class Goal:
    """How fast something is to be, and how far it is from that: a ratio to what ran beside it, at the worst size."""

    table: str  # of timings
    what: str  # whose goal, against whom, of which sizes
    wanted: float  # how many times as fast at least; or, of a cost that grows, the exponent at most
    is_least: bool
    verdict: str  # MET, MISSED, UNMEASURED, or that it is too close to call
    measured: float | None = None  # median of the rounds
    low: float | None = None  # lower quartile
    high: float | None = None  # upper quartile
    where: str = ""  # the worst size

    def __post_init__(self) -> None:
        """Raise ValueError for numbers that are no ratios, and for a goal that is nobody's."""
        if not self.wanted > 0.0 or any(one is not None and abs(one) > LONGEST for one in (self.measured, self.low)):
            raise ValueError(f"{self.what}: {self.measured} of {self.wanted} are no ratios")
        if (self.measured is None) != (self.verdict == UNMEASURED):
            raise ValueError(f"{self.what}: {self.verdict}, and measured is {self.measured}")


@dataclass
class Figure:
    """One number that is no claim and no race, such as how long a start takes."""

    name: str
    value: float
    unit: str
    most: float | None = None  # a goal: no more than that


@dataclass
class Picture:
    """A scene that was run and filmed; paths are relative to the report."""

    name: str
    caption: str
    animation: str
    still: str
    motion: str | None = None  # what moved, as arrays: see validation/motion.py

    def __post_init__(self) -> None:
        """Raise ValueError for a path that leads out of the report's folder, or to no image."""
        for path in filter(None, (self.animation, self.still, self.motion)):
            parts = PurePosixPath(path.replace("\\", "/"))
            kinds = ARRAYS if path is self.motion else IMAGES
            if parts.is_absolute() or PureWindowsPath(path).drive or ".." in parts.parts or parts.suffix not in kinds:
                raise ValueError(f"{path!r} is no {' or '.join(kinds)} inside the report's folder")


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
class PlantedFault:
    """A fault that was planted in the core, and what became of it."""

    name: str
    place: str  # in the core, dotted
    claims: list[str]  # that were to see it
    verdict: str  # "caught", "escaped" or "not run"
    off: dict[str, float] = field(default_factory=dict)  # claim → its error, in tolerances, where it has one


@dataclass
class Sensitivity:
    """What planted faults and mutants of this core have shown that the claims see."""

    faults: list[PlantedFault] = field(default_factory=list)
    faults_why: str | None = None  # why there are none, if there are none
    mutants: int = 0
    killed: int = 0  # by what a claim measured
    crashed: int = 0  # made claims raise errors, and do nothing else
    hung: int = 0  # made a claim go on for ever
    equivalent: int = 0  # change nothing
    within: int = 0  # change what is within what is promised
    earlier: int = 0  # were tried on an earlier core, in functions that do the same in this one
    seen_at: dict[str, int] = field(default_factory=dict)  # level → mutants that it was the first to see
    survivors: list[str] = field(default_factory=list)  # what no claim has seen, and nobody explained: place and change
    mutants_why: str | None = None


@dataclass
class Subject:
    """An engine that was judged in the core's stead."""

    name: str
    version: str | None


@dataclass
class Setting:
    """How an engine was set, against its defaults, so that it could judge or be judged fairly."""

    engine: str
    setting: str
    why: str


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
    goals: list[Goal] = field(default_factory=list)  # of speed
    pictures: list[Picture] = field(default_factory=list)
    figures: list[Figure] = field(default_factory=list)
    behaviours: list[Behaviour] = field(default_factory=list)
    sensitivity: Sensitivity | None = None
    patterns: list[str] = field(default_factory=list)  # given by -k; all claims were judged if there are none
    registered: int | None = None  # claims that there are, chosen by -k or not; None: the record is older
    subject: Subject | None = None  # who was judged; None: the core
    settings: list[Setting] = field(default_factory=list)
    draws: int = 1  # of each claim's cases, by the seeds from `seed` on
    open_errata: list[OpenErratum] = field(default_factory=list)
    unnamed: list[str] = field(default_factory=list)  # public functions, dotted, that no claim names as its piece
    schema: str = SCHEMA


def write_report(report: Report, path: Path) -> None:
    """Write `report` as JSON, whole or not at all."""
    write_whole(path, json.dumps(finite(asdict(report)), indent=1, ensure_ascii=False) + "\n")


def read_report(path: Path) -> Report:
    """Read a report; raises ValueError, naming the file and the entry, if it is not one of a readable schema."""
    return read_document(path, Report, READABLE, "run the validation again")


def read_document(path: Path, kind: type[Document], schemas: tuple[str, ...], cure: str) -> Document:
    """Read JSON of some schemas; raises ValueError with the file, the entry at fault, and the cure."""
    size = path.stat().st_size
    if size > LARGEST_FILE:
        raise ValueError(f"{path} has {size} bytes, more than {LARGEST_FILE}; {cure}")
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} is not JSON ({error}); {cure}") from error
    if not isinstance(data, dict) or data.get("schema") not in schemas:
        found = data.get("schema") if isinstance(data, dict) else type(data).__name__
        raise ValueError(f"{path} has schema {found!r}, not {schemas[-1]!r}; {cure}")
    try:
        return from_json(kind, data)
    except ValueError as error:
        raise ValueError(f"{path} is damaged: {error}; {cure}") from error


def write_whole(path: Path, text: str) -> None:
    """Write a text file by way of a temporary one, so that a reader never sees half of it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    with temporary.open("w", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    temporary.replace(path)


def finite(value: Any) -> Any:
    """Replace numbers that JSON cannot hold by None, all the way down."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [finite(item) for item in value]
    return value
