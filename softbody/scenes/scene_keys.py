"""Keys that the tables of a scene file may have, and what each must be."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, hypot, inf, radians, sin
from pathlib import Path
from typing import Any

import numpy as np

from softbody.bodies.names import checked_name
from softbody.errors import ParameterError
from softbody.model.properties import checked_property, known_properties
from softbody.model.settings import PRECISIONS, WORDS, Choices, Settings, check_name, settings_of
from softbody.model.validation import (
    NO_NUMBERS,
    check_range,
    check_whole,
    check_yes_or_no,
    doubles,
    shown,
    tear_at_of,
    unit_quaternion,
    vector,
)

Check = Callable[[Any, str], Any]  # of a value and what it is called: returns it, or raises ParameterError


def _number(unit: str = "", **limits: float) -> Check:
    return lambda value, name: check_range(_no_truth(value, name), name, unit, **limits)


def _whole(least: int) -> Check:
    return lambda value, name: check_whole(_no_truth(value, name), name, least)


def _one_of(*choices: str) -> Check:
    def check(value: Any, name: str) -> str:
        check_name(value, name, choices)
        return value

    return check


def _no_truth(value: Any, name: str) -> Any:
    """Return a number, or a list of some, in which nothing is true or false: to Python these are numbers."""
    for each in value if isinstance(value, list) else [value]:
        if isinstance(each, bool):
            raise ParameterError(f"{name} is {str(value).lower()}; give a number")
    return value


def _vector(value: Any, name: str) -> np.ndarray:
    return vector(_no_truth(value, name), name)


def _points(value: Any, name: str) -> np.ndarray:
    if not isinstance(value, list) or not value:
        raise ParameterError(f"{name} is {shown(value)}; give a list of places, [[x, y, z], …]")
    return np.array([_vector(each, f"each of {name}") for each in value])


def _of_edges(value: Any, name: str) -> np.ndarray:
    """Return one number, or a list of one for each edge."""
    try:
        return doubles(_no_truth(value, name))
    except NO_NUMBERS as error:
        raise ParameterError(f"{name} is {shown(value)}; give one number, or a list of one for each edge") from error


def _springs(unit: str) -> Check:
    def check(value: Any, name: str) -> Any:
        numbers = _of_edges(value, name)
        for each in numbers.ravel():
            check_range(each, name, unit, least=0.0)
        return numbers

    return check


def _tear_at(value: Any, name: str) -> np.ndarray:
    numbers = _of_edges(value, name)
    tear_at_of(numbers.ravel(), numbers.size)
    return numbers


def _extent(value: Any, name: str) -> np.ndarray:
    extent = _vector(value, name)
    if not (extent > 0.0).all():
        raise ParameterError(f"{name} is {shown(value)}; give three positive lengths [m]")
    return extent


def _orientation(value: Any, name: str) -> np.ndarray:
    """Return a unit quaternion, given as one, or as an axis and an angle."""
    if not isinstance(value, dict):
        return unit_quaternion(_no_truth(value, name))
    if value.keys() != {"axis", "degrees"}:
        raise ParameterError(f"{name} is {shown(value)}; give [w, x, y, z], or {{ axis = [x, y, z], degrees = … }}")
    axis = _vector(value["axis"], f"axis of {name}")
    half = 0.5 * radians(_number()(value["degrees"], f"degrees of {name}"))
    length = hypot(*axis)
    if not 0.0 < length < inf:
        raise ParameterError(f"axis of {name} is {shown(value['axis'])}; give one with a direction")
    return np.append(cos(half), sin(half) * axis / length)


def _indices(value: Any, name: str) -> list[int]:
    if not isinstance(value, list):
        raise ParameterError(f"{name} is {shown(value)}; give a list of the indices of vertices")
    return [check_whole(_no_truth(each, name), f"each of {name}", 0) for each in value]


def _setting(value: Any, name: str) -> Any:
    if name not in WORDS and not isinstance(Settings._field_defaults[name], bool):
        _no_truth(value, name)
    settings_of({name: value})  # type: ignore[misc]
    return value


def _whose(value: Any, name: str) -> int | str:
    """Return the name of a body, or its number."""
    return value if isinstance(value, str) else _whole(0)(value, name)


def _anything(value: Any, name: str) -> Any:
    """Return what is looked at elsewhere: a table of its own."""
    return value


def _pair(check: Check) -> Check:
    def both(value: Any, name: str) -> tuple[Any, Any]:
        if not isinstance(value, list) or len(value) != 2:
            raise ParameterError(f"{name} is {shown(value)}; give a list of two numbers")
        return check(value[0], f"first of {name}"), check(value[1], f"second of {name}")

    return both


def _range(value: Any, name: str) -> tuple[float, float]:
    least, most = _pair(_number())(value, name)
    return least, check_range(most, f"greatest of {name}", above=least)


def _text(value: Any, name: str) -> str:
    if not isinstance(value, str) or not value or "\0" in value:
        raise ParameterError(f"{name} is {shown(value)}; give the name of a file")
    return value


def _film_name(value: Any, name: str) -> str:
    """Return a name in the folder of the run, and of a kind of film."""
    text = _text(value, name)
    if Path(text).name != text or Path(text).suffix not in (".webp", ".mp4"):
        raise ParameterError(f"{name} is {shown(value)}; give a name without folders, that ends in .webp or .mp4")
    return text


def _properties(kind: str) -> dict[str, Check]:
    def check_of(field: str) -> Check:
        if known_properties()[field].is_chosen:
            return lambda value, name: value if isinstance(value, bool) else checked_property(field, value)
        return lambda value, name: checked_property(field, _no_truth(value, name))

    fields = [field for field in known_properties() if field.startswith(f"{kind}_")]
    return {field.removeprefix(f"{kind}_"): check_of(field) for field in fields}


LENGTH = _number("m", above=0.0)
RATE = _number("1/s", above=0.0, most=1000.0)

WORLD: dict[str, Check] = {
    "gravity": _vector,
    "precision": _one_of(*PRECISIONS),
    "threads": _whole(1),
    "paper": check_yes_or_no,
    **dict.fromkeys(Choices.__annotations__, _setting),
}
GROUND: dict[str, Check] = {
    "height": _number("m"),
    "restitution": _number(least=0.0, most=1.0),
    "friction": _number(least=0.0),
}
LIQUID: dict[str, Check] = {
    "density": _number("kg/m³", above=0.0),
    "surface_height": _number("m"),
    "drag": _number("N s/m³", least=0.0),
    "velocity": _vector,
}
SHAPES: dict[str, dict[str, Check]] = {
    "icosphere": {"subdivisions": _whole(0), "radius": LENGTH},
    "torus": {
        "major_radius": LENGTH,
        "minor_radius": LENGTH,
        "major_segments": _whole(3),
        "minor_segments": _whole(3),
    },
    "box": {"size": _extent, "segments": _whole(1)},
    "tetrahedron": {"radius": LENGTH},
    "octahedron": {"radius": LENGTH},
    "icosahedron": {"radius": LENGTH},
}
MESH_FILE: dict[str, Check] = {
    "file": _text,
    "merge": check_yes_or_no,
    "tolerance": _number("m", least=0.0),
    "scale": _number(above=0.0),
}
SOFT_BODY: dict[str, Check] = {
    "name": checked_name,
    "shape": _anything,
    "mass": _number("kg", above=0.0),
    "stiffness": _springs("N/m"),
    "gas": _number("J", least=0.0),
    "pressure": _number("Pa", least=0.0),
    "position": _vector,
    "orientation": _orientation,
    "velocity": _vector,
    "rest_length": _springs("m"),
    "tear_at": _tear_at,
    "fixed": _indices,
    "fixed_above": _number("m"),
    "fixed_below": _number("m"),
    **_properties("soft"),
}
BOX: dict[str, Check] = {
    "name": checked_name,
    "size": _extent,
    "mass": _number("kg", above=0.0),
    "static": check_yes_or_no,
    "kinematic": check_yes_or_no,
    "position": _vector,
    "orientation": _orientation,
    "velocity": _vector,
    "angular_velocity": _vector,
    "inside": _whose,
    **_properties("box"),
}
SUSPENSION: dict[str, Check] = {
    "name": checked_name,
    "soft_body": _whose,
    "box": _whose,
    "points": _points,
    "stiffness": _number("N/m", least=0.0),
    "damping": _number("N s/m", least=0.0),
    "weights": _one_of("mean-value", "tetrahedron"),
}
JOINT: dict[str, Check] = {
    "name": checked_name,
    "a": _anything,
    "b": _anything,
    "stiffness": _number("N/m", least=0.0),
    "damping": _number("N s/m", least=0.0),
    "rest_length": _number("m", least=0.0),
}
END: dict[str, Check] = {  # of a joint, where it is on a body
    "soft_body": _whose,
    "box": _whose,
    "suspension": _whose,
    "at": _vector,
    "particle": _whole(0),
    "point": _whole(0),
}
PLACES = {"soft_body": ("at", "particle"), "box": ("at",), "suspension": ("point",)}  # of an end on each
RUN: dict[str, Check] = {
    "seconds": _number("s", above=0.0),
    "frames_per_second": RATE,
    "time_step": _number("s", above=0.0),
    "velocities": check_yes_or_no,
}
FILM: dict[str, Check] = {
    "file": _film_name,
    "frames_per_second": RATE,
    "colour": _one_of("stripes", "plain", "pressure", "strain", "speed"),
    "colour_range": _range,
    "size": _pair(_whole(1)),
    "show_joints": check_yes_or_no,
}
