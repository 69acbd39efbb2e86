"""What a claim is: a sentence, a judge, a tolerance with its reason, and the comparison that could refute it."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import random
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from math import inf
from typing import Any

import numpy as np

from validation import plug_ins
from validation.engines import ENGINES, PACKAGES, missing
from validation.fault import Fault
from validation.record import BROKEN, ENGINE, KINDS, LIBRARY, NOT_RUN, OTHERS, ROOMS, Arbitration

CLAIMS = "validation.checks"  # where they are declared
LEVELS = ("quick", "standard", "full")

DISAGREEMENTS = "disagreements"

LEAST = 6  # cases that a claim compares, if it does not say that there are fewer


class NotHereError(Exception):
    """What a claim is about cannot be on this machine; the message says why."""


@dataclass
class Comparison:
    """What the core answered and what the judge answered, case by case.

    `measured` and `expected` are (n,) or (n, k); the error of a case is the length of the difference of its
    rows, divided by `scale` (a number or (n,), from 1e-18 to 1e12). Yes-or-no answers are compared as such; others are
    doubles or whole numbers. Cases with the same answers, inputs and kind count once, if these are doubles. `groups`
    (n,) names the kind of each case. `printed` holds what the paper's printed form answers, for an erratum: finite.
    No two of them may share memory: what is compared with itself agrees. `inputs` (name → (n, …)) say what each case
    asks, as far as that is a few numbers: those of the worst case are kept, and `replay` shows those of any.
    `arbitrations` say who was right where answers differ (`validation.arbitration`): they judge nothing.
    """

    measured: Any
    expected: Any
    scale: Any = 1.0
    groups: Any = None
    printed: Any = None
    notes: list[str] = field(default_factory=list)
    inputs: Mapping[str, Any] = field(default_factory=dict)
    arbitrations: list[Arbitration] = field(default_factory=list)


@dataclass(frozen=True)
class Run:
    """How a check is run: its level, and a random generator of its own."""

    level: str
    seed: int
    check_id: str

    def fresh_rng(self) -> np.random.Generator:
        """A fresh generator: the same numbers at every call, others for every check."""
        return np.random.default_rng([self.seed, zlib.crc32(self.check_id.encode())])

    def seed_engines(self) -> None:
        """Seed the generators that are shared by all: some engines, such as trimesh 4.4, draw from them."""
        number = zlib.crc32(f"{self.seed} {self.check_id}".encode())
        np.random.seed(number)
        random.seed(number)

    def count(self, quick: int, standard: int, full: int) -> int:
        """Return the number of cases for this run's level."""
        return {"quick": quick, "standard": standard, "full": full}[self.level]


@dataclass(frozen=True)
class Misprint:
    """A formula of the paper that is wrong as printed, and the right one."""

    id: str
    prints: str
    right: str


@dataclass(frozen=True)
class Check:
    """A claim about one piece of the core, declared as data; `compare` never asserts."""

    id: str
    family: str
    claim: str  # one sentence
    section: str
    piece: str
    reference: str
    engines: tuple[str, ...]
    unit: str
    tolerance: float
    because: str
    compare: Callable[[Run], Comparison]
    detail: str = ""  # what else is claimed, and of which cases
    room: str = OTHERS  # one of ROOMS' or OTHERS
    erratum: Misprint | None = None
    faults: tuple[Fault, ...] = ()  # that turn it red
    least: int = 1  # cases that it must compare
    kind: str = "closed form"  # of judge: one of KINDS
    never: tuple[str, str] | None = None  # the verdict of what cannot be run, wherever it is, and why

    @property
    def hindrance(self) -> tuple[str, str] | None:
        """The verdict without a run, and why: it can never be run, or not where its engines are missing."""
        absent = missing(self.engines)
        return self.never or ((NOT_RUN, f"{', '.join(absent)} is not installed") if absent else None)

    @property
    def lane(self) -> str:
        """Claims of one lane share a process, in which kernels are compiled once: LANE of its file, or its family."""
        return str(getattr(self.compare, "__globals__", {}).get("LANE", self.family))


CHECKS: dict[str, Check] = {}


def check(
    *,
    section: str,
    piece: str,
    reference: str,
    faults: tuple[Fault, ...],
    because: str = "",
    tolerance: float | None = None,
    unit: str = "relative",
    engines: tuple[str, ...] = (),
    erratum: Misprint | None = None,
    least: int = LEAST,
    kind: str | None = None,
    family: str | None = None,
) -> Callable[[Callable[[Run], Comparison]], Callable[[Run], Comparison]]:
    """Declare a check: a function whose docstring is the claim, one sentence, and then what else there is to say.

    Its id is the file's and the function's name, such as `volume.closed_forms`; that of a plug-in has its package
    before it, such as `acme_hulls.claims.volumes`. Its room is the folder of its file, its family the FAMILY there.

    Without a tolerance it counts disagreements of yes and no, and allows none; a tolerance has a reason, `because`.
    `least`: how many cases it must compare at every level; where they are fewer than LEAST, it says so itself. `kind`
    of judge, one of KINDS: with engines and without one it is ENGINE or LIBRARY.

    Raises ValueError for a function without a docstring or a family, for an engine that no reference declares, for a
    tolerance without a reason or that is no finite number from 0 on, for a count of disagreements that has one, for
    fewer than one case, and for a check without a fault that it sees.
    """

    def register(compare: Callable[[Run], Comparison]) -> Callable[[Run], Comparison]:
        module, room = compare.__module__, ""
        if module.startswith(f"{CLAIMS}."):
            *_, room, module = module.split(".")
        name = f"{module}.{compare.__name__}"
        if name in CHECKS:
            raise ValueError(f"two checks are called {name}; rename one")
        claim, detail = sentences_of(compare)
        if not claim:
            raise ValueError(f"{name} claims nothing: its docstring is the claim; write one")
        kin = family or compare.__globals__.get("FAMILY")  # type: ignore[attr-defined]
        if not kin:
            raise ValueError(f"{name} has no family: give its file a FAMILY, or `family=` here")
        unknown = [engine for engine in engines if engine not in PACKAGES]
        if unknown:
            raise ValueError(
                f"{name} leans on {unknown[0]!r}, which no file of references/ declares, and no plug-in: say there "
                f'PACKAGES = {{"{unknown[0]}": "the name to install it by"}}'
            )
        judge = kind or _kind_of(engines)
        if judge not in KINDS:
            raise ValueError(f"{name} does not say what kind of judge it has; choose from {', '.join(KINDS)}")
        if tolerance is not None and not 0.0 <= tolerance < inf:
            raise ValueError(f"{name} has a tolerance of {tolerance}: it must be finite and not below 0")
        if tolerance is not None and not because:
            raise ValueError(f"{name} does not say why its tolerance is {tolerance}: say `because`")
        if tolerance is not None and unit == DISAGREEMENTS:
            raise ValueError(f"{name} counts disagreements, and allows {tolerance}: none is allowed; leave it out")
        if least < 1:
            raise ValueError(f"{name} may compare {least} cases: a claim compares one at least")
        if not faults:
            raise ValueError(f"{name} names no fault that turns it red: a claim that cannot fail says nothing")
        CHECKS[name] = Check(
            id=name,
            room=ROOMS.get(room, OTHERS),
            family=str(kin),
            claim=claim,
            detail=detail,
            section=section,
            piece=piece,
            reference=reference,
            engines=engines,
            unit=DISAGREEMENTS if tolerance is None else unit,
            tolerance=tolerance or 0.0,
            because=because or "yes or no",
            compare=compare,
            erratum=erratum,
            faults=faults,
            least=least,
            kind=judge,
        )
        return compare

    return register


def sentences_of(compare: Callable[..., Any]) -> tuple[str, str]:
    """Return the claim that a function's docstring makes, and what it says besides; each on one line."""
    claim, _, detail = (inspect.getdoc(compare) or "").partition("\n\n")
    return " ".join(claim.split()), " ".join(detail.split())


def _kind_of(engines: tuple[str, ...]) -> str | None:
    """Return the kind of judge that some engines are, or None if there is none."""
    if ENGINES.intersection(engines):
        return ENGINE
    return LIBRARY if engines else None


def all_checks() -> dict[str, Check]:
    """Return every check of `validation.checks`, in order of room and declaration, then those of plug-ins.

    A plug-in that is broken has a check of its own, which is never run and says why.
    """
    package = importlib.import_module(CLAIMS)
    for module in sorted(info.name for info in pkgutil.walk_packages(package.__path__, f"{CLAIMS}.")):
        importlib.import_module(module)
    _load_plug_ins()
    for name, why in plug_ins.BROKEN.items():
        CHECKS[name] = _broken(name, why)
    rooms = [*ROOMS.values(), OTHERS]
    return dict(sorted(CHECKS.items(), key=lambda item: rooms.index(item[1].room)))


@cache
def _load_plug_ins() -> None:
    """Import the claims of other packages, once a process."""
    plug_ins.load_claims(CHECKS)


def _broken(name: str, why: str) -> Check:
    """Return what stands for all claims of a plug-in that is broken."""

    def compare(run: Run) -> Comparison:
        raise RuntimeError(why)

    return Check(
        id=name,
        family="plug-ins",
        claim="A plug-in brings its engines and claims.",
        section="",
        piece="",
        reference="whoever installed it",
        engines=(),
        unit=DISAGREEMENTS,
        tolerance=0.0,
        because="",
        compare=compare,
        kind="specification",
        never=(BROKEN, why),
    )
