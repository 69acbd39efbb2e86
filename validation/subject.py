"""Subjects judged in the core's place: a file of validation/subjects/ or of a plug-in each, and its claims.

An adapter is a file with functions of the names of QUESTIONS, with arguments and answers as of `Subject`; those
that it has not are said in CANNOT, with the reason. Claims (validation/subject_claims/) are written once, against
these questions: the cases, the expected values and the tolerances are the same for every subject, the core included.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cache, partial
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from validation import foreign, plug_ins
from validation.check import Check, Comparison, Run, all_checks, sentences_of
from validation.declared import Declared, all_in
from validation.effort import spending
from validation.engines import DECLARED
from validation.record import NOT_RUN

MARK = ":"  # between a subject and its claim: rapier3d:boxes.fly


class Boxes(NamedTuple):
    """Boxes in one world, at the start; a box of infinite mass moves as its velocities say, whatever it meets."""

    size: np.ndarray  # (m, 3) full extents [m]
    mass: np.ndarray  # (m,) [kg]
    position: np.ndarray  # (m, 3) [m]
    orientation: np.ndarray  # (m, 4) unit quaternions (w, x, y, z)
    velocity: np.ndarray  # (m, 3) [m/s]
    spin: np.ndarray  # (m, 3) [rad/s] in the world's frame
    gravity: float = 0.0  # [m/s²], downwards
    friction: float = 0.0  # of every pair
    restitution: float = 0.0  # of every pair

    def rows(self) -> Iterator[tuple[np.ndarray, ...]]:
        """Return size, mass, position, orientation, velocity and spin of each box."""
        return zip(*self[:6])


NO_BOXES = Boxes(*(np.zeros(shape) for shape in ((0, 3), 0, (0, 3), (0, 4), (0, 3), (0, 3))))  # type: ignore[arg-type]


class Motion(NamedTuple):
    """Where boxes were, f times on their way; fields of shape (f, m, 3) or (f, m, 4), as in `Boxes`."""

    position: np.ndarray
    orientation: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray


class GasBody(NamedTuple):
    """A closed shell with a particle at every vertex, a spring on every edge, no pull in them, and an ideal gas."""

    vertices: np.ndarray  # (n, 3) [m]
    edges: np.ndarray  # (e, 2)
    triangles: np.ndarray  # (t, 3)
    stiffness: float  # [N/m]
    gas: float  # nRT [J]
    mass: float  # [kg], the same part of it at every vertex
    frequency: float  # [rad/s] of its breathing, to choose steps by


class SoftScene(NamedTuple):
    """Bodies with gas, at the start where their vertices are, among boxes; they begin with no pull in their springs."""

    bodies: tuple[GasBody, ...]
    velocity: tuple[np.ndarray, ...]  # (n, 3) of each body [m/s]
    boxes: Boxes  # which may be none; with gravity, friction and restitution of every pair
    drag: float = 0.0  # [1/s]: dv/dt = −drag v for all particles

    def rows(self) -> Iterator[tuple[GasBody, np.ndarray]]:
        """Return each body, and the velocities of its vertices."""
        return zip(self.bodies, self.velocity)


class SoftMotion(NamedTuple):
    """Where soft bodies and boxes were, f times on their way."""

    position: tuple[np.ndarray, ...]  # (f, n, 3) of each body
    velocity: tuple[np.ndarray, ...]
    boxes: Motion


class Subject(Protocol):
    """What an adapter may answer."""

    def move_boxes(self, boxes: Boxes, step: float, steps: int, every: int) -> Motion:
        """Return where boxes are after each `every` of so many steps of `step` [s]."""

    def boxes_overlap(self, *pairs: np.ndarray) -> np.ndarray:
        """Tell for sizes, positions and orientations of a and of b, (m, …) each, whether they overlap: (m,) of bool."""

    def gas_volume(self, body: GasBody) -> float:
        """Return the volume [m³] at which springs hold the gas."""

    def gas_period(self, body: GasBody, swing: float) -> float:
        """Return the time [s] of one breath about the shape at rest, begun with the speeds `swing` ω (x − centre)."""

    def move_soft(self, scene: SoftScene, step: float, steps: int, every: int) -> SoftMotion:
        """Return where soft bodies and boxes are after each `every` of so many steps of `step` [s]."""

    def points_in_mesh(self, points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
        """Tell for each of `points` (m, 3) [m] whether it is inside a closed mesh: (m,) of bool."""


QUESTIONS = tuple(name for name in vars(Subject) if not name.startswith("_"))


class UnknownSubjectError(ValueError):
    """There is no subject of that name."""


@dataclass(frozen=True)
class SubjectClaim:
    """A claim about anybody who answers `question`."""

    check: Check
    question: str
    compare: Callable[[Run, Callable], Comparison]
    roundings: int  # in a row, at worst, that stand between the question and its answer; 0: answers are yes or no


CLAIMS: dict[str, SubjectClaim] = {}


def asks(
    question: str, roundings: int = 0, **declared: object
) -> Callable[[Callable[[Run, Callable], Comparison]], Callable]:
    """Declare a claim for subjects: a function of a run and of the subject's function; other words as of `check`."""

    def register(compare: Callable[[Run, Callable], Comparison]) -> Callable:
        name = f"{compare.__module__.rpartition('.')[2]}.{compare.__name__}"
        claim, detail = sentences_of(compare)
        said = {"claim": claim, "detail": detail, "family": compare.__globals__["FAMILY"]}
        words = {"section": "", "engines": (), "piece": "", "unit": "relative", **said, **declared}
        CLAIMS[name] = SubjectClaim(Check(id=name, compare=None, **words), question, compare, roundings)  # type: ignore[arg-type]
        return compare

    return register


@cache
def subjects() -> dict[str, Declared]:
    """Return all subjects by their names."""
    own = all_in(Path(__file__).with_name("subjects"))
    return {one.name: one for one in [*own, *plug_ins.subjects()]}


def the_subject(name: str) -> Declared:
    """Return what the adapter of a subject says; raises UnknownSubjectError, with the nearest names."""
    known = subjects()
    if name not in known:
        near = get_close_matches(name, known, 1)
        broken = [why for point, why in plug_ins.BROKEN.items() if point.endswith(f".{name}")]
        cure = f": {broken[0]}" if broken else f"; did you mean {near[0]}?" if near else "."
        raise UnknownSubjectError(f"no subject is called {name!r}{cure} Subjects are {', '.join(known)}")
    return known[name]


def checks_of(name: str) -> dict[str, Check]:
    """Return the claims about a subject, by their ids; raises UnknownSubjectError."""
    subject = the_subject(name)
    package = importlib.import_module("validation.subject_claims")
    for module in sorted(info.name for info in pkgutil.iter_modules(package.__path__)):
        importlib.import_module(f"{package.__name__}.{module}")
    return {f"{name}{MARK}{claim}": _check(subject, one) for claim, one in CLAIMS.items()}


def find_check(check_id: str) -> Check:
    """Return the check of an id, about the core or about a subject; raises KeyError."""
    subject, mark, _ = check_id.partition(MARK)
    return (checks_of(subject) if mark else all_checks())[check_id]


def settings_of(subject: Declared | None) -> list[tuple[str, str, str]]:
    """Return (engine, setting, why) of what was chosen for a subject, or for all judges if there is none."""
    used = [one for one in DECLARED if subject is None or one.name in subject.leans_on]
    used += [subject] if subject else []
    return [(one.name, setting, why) for one in used for setting, why in one.settings.items()]


def _check(subject: Declared, claim: SubjectClaim) -> Check:
    answers = claim.question in subject.functions
    why = subject.cannot.get(claim.question, f"its adapter has no {claim.question}")
    compare = partial(_compare, subject, claim)
    compare.__wrapped__ = claim.compare  # type: ignore[attr-defined]  # for `explain`
    return replace(
        claim.check,
        id=f"{subject.name}{MARK}{claim.check.id}",
        piece=f"{claim.question} of {subject.name}",
        engines=tuple(subject.packages),
        compare=compare,
        never=None if answers else (NOT_RUN, why),
    )


def _compare(subject: Declared, claim: SubjectClaim, run: Run) -> Comparison:
    """Run a claim on the cases that are the same for every subject."""
    answer = getattr(importlib.import_module(point_of(subject)), claim.question)
    try:
        return claim.compare(replace(run, check_id=claim.check.id), answer)
    finally:
        foreign.stop()


def point_of(subject: Declared) -> str:
    """Return the module of an adapter."""
    return subject.module or f"validation.subjects.{subject.name}"


def moving(now: Callable[[], tuple[np.ndarray, ...]], advance: Callable[[int], None], steps: int, every: int) -> Motion:
    """Return a motion, from what tells position, orientation, velocity and spin now, and what takes so many steps."""
    return Motion(*_frames(now, advance, steps, every))


def moving_soft(
    now: Callable[[], tuple[np.ndarray, ...]], advance: Callable[[int], None], steps: int, every: int
) -> SoftMotion:
    """Return a motion, as above, from what tells position and velocity of each soft body first, then of boxes."""
    *soft, position, orientation, velocity, spin = _frames(now, advance, steps, every)
    return SoftMotion(tuple(soft[::2]), tuple(soft[1::2]), Motion(position, orientation, velocity, spin))


def _frames(
    now: Callable[[], tuple[np.ndarray, ...]], advance: Callable[[int], None], steps: int, every: int
) -> list[np.ndarray]:
    frames = []
    with spending():
        for _ in range(steps // every):
            advance(every)
            frames.append([np.array(rows, float) for rows in now()])
    return [np.stack(rows) for rows in zip(*frames)]


def swells_again(advance: Callable[[], float], samples: int) -> float:
    """Return after how many steps, of some `samples` a period, a volume above its mean swells through 0 again.

    `advance` takes a step and returns the volume less its mean. NaN if it does not within two periods.
    """
    above = [0.0]
    while len(above) < samples // 2 or not above[-2] < 0.0 <= above[-1]:
        if len(above) > 2 * samples:
            return np.nan
        above.append(advance())
    return len(above) - 1 - above[-1] / (above[-1] - above[-2])
