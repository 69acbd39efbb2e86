"""Settings by which bodies move and collide: what a user chooses by name, and what kernels read."""

from __future__ import annotations

from math import inf, isnan
from typing import Any, NamedTuple, TypedDict

import numpy as np

from softbody.errors import ParameterError
from softbody.model.validation import check_range, check_whole, check_yes_or_no, shown

RK4_VELOCITY, RK4, SYMPLECTIC_EULER = 0, 1, 2
INTEGRATORS = {"rk4_velocity": RK4_VELOCITY, "rk4": RK4, "symplectic_euler": SYMPLECTIC_EULER}
PRECISIONS: dict[str, type[np.floating[Any]]] = {"double": np.float64, "single": np.float32}

MOST_ITERATIONS = 10_000_000  # sweeps, or sub-steps; a step must end


class Settings(NamedTuple):
    """What kernels read; a ceiling of inf and a floor of 0 do nothing."""

    integrator: int = SYMPLECTIC_EULER
    substeps: int = 1  # equal parts in which soft bodies take a step, which contacts take as one
    paper_axes: bool = False  # of the separating-axis test of boxes: face normals only
    single_contact: bool = False  # of boxes: the paper's one impulse a pair, instead of manifolds solved together
    single_soft_contact: bool = False  # of soft bodies: one after the other, as in the paper, instead of all together
    exhaustive_pairs: bool = False  # try all pairs, and soft ones by face normals, as in the paper, instead of a grid
    iterations: int = 30  # sweeps of the contact solver, a step
    edge_contacts: bool = True  # of soft bodies, and not only contacts of vertices, as in the paper
    split_steps: bool = True  # where bodies would jump through each other, or boxes are small
    gyroscopic: bool = False  # a free box keeps I ω instead of ω
    speed_ceiling: float = inf  # [m/s] of boxes; paper §6
    angular_speed_ceiling: float = inf  # [rad/s] of boxes; paper §6
    angular_speed_floor: float = 0.0  # [rad/s] below which a box on the ground stops turning and snaps to 90°; paper §6
    frictionless: bool = False  # whatever is added has friction 0, as everything in the paper
    self_contact: bool = False  # soft bodies that are added keep a distance from themselves, unless told otherwise
    sleep_speed: float = 0.0  # [m/s] at which bodies are slow enough to fall asleep; 0: none ever does
    sleep_after: float = 0.5  # [s] for which they must have been so slow


class Choices(TypedDict, total=False):
    """The settings as a user says them: arguments of a World."""

    integrator: str
    substeps: int
    axes: str
    contact: str
    soft_contact: str
    pairs: str
    iterations: int
    edge_contacts: bool
    split_steps: bool
    gyroscopic: bool
    speed_ceiling: float
    angular_speed_ceiling: float
    angular_speed_floor: float
    frictionless: bool
    self_contact: bool
    sleep_speed: float
    sleep_after: float


# The choices that are words: which field of Settings each is about, and what the words mean there.
WORDS: dict[str, tuple[str, dict[str, Any]]] = {
    "integrator": ("integrator", INTEGRATORS),
    "axes": ("paper_axes", {"complete": False, "paper": True}),
    "contact": ("single_contact", {"manifold": False, "single": True}),
    "soft_contact": ("single_soft_contact", {"together": False, "single": True}),
    "pairs": ("exhaustive_pairs", {"grid": False, "exhaustive": True}),
}

# What the paper chose. It gives no numbers for its limits (§6). These: in a frame of 1/60 s a box goes no farther than
# 1/6 m, a third of a small box, and turns by no more than 10°; and one that would take a second for 10° lies still.
PAPER: Choices = {
    "integrator": "rk4_velocity",
    "axes": "paper",
    "contact": "single",
    "soft_contact": "single",
    "pairs": "exhaustive",
    "edge_contacts": False,
    "split_steps": False,
    "frictionless": True,
    "speed_ceiling": 10.0,
    "angular_speed_ceiling": 10.0,
    "angular_speed_floor": 0.2,
}


def settings_of(choices: Choices) -> Settings:
    """Return the settings that somebody chose, the others as by default; raises ParameterError."""
    values: dict[str, Any] = {}
    for name, value in choices.items():
        if name not in Choices.__annotations__:
            raise ParameterError(f"a World has no {name!r}; choose from {', '.join(Choices.__annotations__)}")
        if name in WORDS:
            field, words = WORDS[name]
            check_name(value, name, tuple(words))
            values[field] = words[value]  # type: ignore[index]
            continue
        kind = type(Settings._field_defaults[name])
        if kind is int:
            values[name] = check_whole(value, name, 1)  # type: ignore[arg-type]
            check_range(value, name, most=MOST_ITERATIONS)  # type: ignore[arg-type]
        elif kind is bool:
            values[name] = check_yes_or_no(value, name)
        else:
            unlimited = isinstance(value, (float, np.floating)) and value == inf
            values[name] = inf if unlimited else check_range(value, name, least=0.0)  # type: ignore[arg-type]
    settings = Settings(**values)
    check_holds_itself(settings, settings.self_contact)
    return settings


def check_settings(settings: Settings, name: str) -> None:
    """Raise ParameterError unless `settings`, called `name`, are what `settings_of` might have returned."""
    if settings.integrator not in INTEGRATORS.values():
        known = ", ".join(f"{number} ({word})" for word, number in INTEGRATORS.items())
        raise ParameterError(f"{name}.integrator is {settings.integrator}; there are {known}")
    for field in ("substeps", "iterations"):
        check_range(getattr(settings, field), f"{name}.{field}", least=1, most=MOST_ITERATIONS)
    for field, value in settings._asdict().items():
        if isinstance(value, float) and (isnan(value) or value < 0.0):
            raise ParameterError(f"{name}.{field} is {value}; give a number ≥ 0, or inf")
    check_holds_itself(settings, settings.self_contact)


def check_holds_itself(settings: Settings, holds_itself: bool) -> None:
    """Raise ParameterError for a soft body that `holds_itself`, where contacts are resolved as in the paper."""
    if holds_itself and settings.single_soft_contact:
        raise ParameterError('self_contact needs a world whose soft_contact is "together"; the paper has none')


def check_name(value: object, name: str, choices: tuple[str, ...]) -> None:
    """Raise ParameterError unless `value` is one of the `choices`."""
    if not isinstance(value, str) or value not in choices:
        raise ParameterError(f"{name} is {shown(value)}; choose one of {', '.join(choices)}")


def with_integrator(settings: Settings, name: str) -> Settings:
    """Return the settings with another integrator; raises ParameterError."""
    check_name(name, "integrator", tuple(INTEGRATORS))
    return settings._replace(integrator=INTEGRATORS[name])


def integrator_name(settings: Settings) -> str:
    """Return the name of the integrator."""
    return next(name for name, number in INTEGRATORS.items() if number == settings.integrator)
