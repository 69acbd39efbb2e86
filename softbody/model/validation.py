"""Checks of what a user gave: numbers in range, vectors, rotations; errors name the argument and the cure.

Whatever comes is taken as a double, or as an exact whole number, before anything is asked of it or done with it: so a
number of another precision, or of a size that none has, is what it says, or is refused.
"""

from __future__ import annotations

from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from softbody.errors import ParameterError


def shown(value: object) -> str:
    """Return a value as messages show it: short, whatever it is."""
    try:
        text = repr(value)
    except Exception:  # a whole number of more digits than Python writes, or an object that cannot say what it is
        return f"{type(value).__name__} that cannot be shown"
    return text if len(text) <= MOST_SHOWN else f"{text[:MOST_SHOWN]} …"


MOST_SHOWN = 200  # characters


def doubles(value: ArrayLike) -> np.ndarray:
    """Return numbers as a new array of doubles; raises TypeError, ValueError or OverflowError for what are none."""
    array = np.asarray(value)
    if array.dtype.kind not in "biufO":  # complex numbers would lose a part, and text is not asked what it means
        raise TypeError(f"{array.dtype} is not a type of real numbers")
    with np.errstate(over="ignore"):
        return np.array(array, dtype=np.float64)


NO_NUMBERS = TypeError, ValueError, OverflowError  # what `doubles` raises


def vector(value: ArrayLike, name: str) -> np.ndarray:
    """Return three finite numbers as an array (3,)."""
    try:
        array = doubles(value)
    except NO_NUMBERS as error:
        raise ParameterError(f"{name} is {shown(value)}; give three numbers") from error
    if array.shape != (3,) or not np.isfinite(array).all():
        raise ParameterError(f"{name} is {shown(value)}; give three finite numbers")
    return array


# How far from unit length a quaternion may be and still be taken for a rounded unit quaternion.
QUATERNION_TOLERANCE = 1e-6


def unit_quaternion(value: ArrayLike) -> np.ndarray:
    """Return an orientation (w, x, y, z) as an array (4,), of unit length to the last bit."""
    try:
        array = doubles(value)
    except NO_NUMBERS as error:
        raise ParameterError(f"orientation is {shown(value)}; give four numbers (w, x, y, z)") from error
    if array.shape != (4,) or not np.isfinite(array).all():
        raise ParameterError(f"orientation is {shown(value)}; give four finite numbers (w, x, y, z)")
    with np.errstate(over="ignore"):
        length = float(np.linalg.norm(array))
    if not abs(length - 1.0) <= QUATERNION_TOLERANCE:
        raise ParameterError(f"orientation {shown(value)} has length {length:.6g}; divide it by that to make it 1")
    return array / length


def stiffness_of(stiffness: ArrayLike, count: int) -> np.ndarray:
    """Return the stiffness ≥ 0 [N/m] of each of `count` springs, given one number or one for each."""
    try:
        array = doubles(stiffness)
    except NO_NUMBERS as error:
        raise ParameterError(f"stiffness is {shown(stiffness)}; give one number or one for each edge [N/m]") from error
    if array.shape not in ((), (count,)):
        raise ParameterError(f"stiffness has shape {array.shape}; give one number or one for each of the {count} edges")
    array = np.broadcast_to(array, count)
    bad = ~(np.isfinite(array) & (array >= 0.0))
    if bad.any():
        edge = int(np.argmax(bad))
        raise ParameterError(f"stiffness of edge {edge} is {array[edge]}; give a finite number ≥ 0 [N/m]")
    return array


def rest_length_of(rest_length: ArrayLike, count: int) -> np.ndarray:
    """Return the rest length > 0 [m] of each of `count` springs, given one number or one for each."""
    try:
        array = np.broadcast_to(doubles(rest_length), count).copy()
    except NO_NUMBERS as error:
        raise ParameterError(
            f"rest_length does not fit; give one number or one for each of the {count} edges [m]"
        ) from error
    bad = ~(np.isfinite(array) & (array > 0.0))
    if bad.any():
        edge = int(np.argmax(bad))
        raise ParameterError(f"rest_length of edge {edge} is {array[edge]}; give a finite length > 0 [m]")
    return array


def tear_at_of(tear_at: ArrayLike, count: int) -> np.ndarray:
    """Return the stretch at which each of `count` springs tears, > 1 or 0, given one number or one for each."""
    try:
        array = np.broadcast_to(doubles(tear_at), count).copy()
    except NO_NUMBERS as error:
        raise ParameterError(f"tear_at does not fit; give one number or one for each of the {count} edges") from error
    bad = ~((np.isfinite(array) & (array > 1.0)) | (array == 0.0))
    if bad.any():
        edge = int(np.argmax(bad))
        raise ParameterError(f"tear_at of edge {edge} is {array[edge]}; give length / rest length > 1, or 0 for never")
    return array


def fixed_particles_of(fixed: ArrayLike, count: int) -> np.ndarray:
    """Return the indices of fixed vertices, each once, in order; of `count` at least one is free."""
    try:
        array = np.asarray(fixed)
        if array.size == 0:
            return np.empty(0, np.int64)
        if array.dtype.kind not in "iu" or array.ndim != 1:
            raise TypeError(f"{array.dtype} of shape {array.shape} are no indices")
    except NO_NUMBERS as error:
        raise ParameterError(f"fixed is {shown(fixed)}; give the indices of vertices") from error
    bad = (array < 0) | (array >= count)
    if bad.any():
        raise ParameterError(f"fixed vertex {array[np.argmax(bad)]} does not exist: there are 0 … {count - 1}")
    indices = np.unique(array)
    if len(indices) == count:
        raise ParameterError("every vertex is fixed, so that nothing can move; leave one free")
    return indices


def check_whole(value: int, name: str, least: int, most: int = 2**63 - 1) -> int:
    """Return `value` as an int; raises ParameterError unless it is a whole number ≥ least and ≤ most."""
    # (NumPy counts spans of time among its integers.)
    is_whole = isinstance(value, (int, np.integer)) and not isinstance(value, np.timedelta64)
    if not is_whole or not least <= int(value) <= most:
        limits = f"from {least} to {most}" if most < 2**63 - 1 else f"≥ {least}"
        raise ParameterError(f"{name} is {shown(value)}; give a whole number {limits}")
    return int(value)


def check_yes_or_no(value: object, name: str) -> bool:
    """Return `value` as a bool; raises ParameterError unless it is True or False."""
    if not isinstance(value, (bool, np.bool_)):
        raise ParameterError(f"{name} is {shown(value)}; give True or False")
    return bool(value)


def check_range(
    value: float,
    name: str,
    unit: str = "",
    above: float = -np.inf,
    least: float = -np.inf,
    most: float = np.inf,
) -> float:
    """Return `value` as a double; raises ParameterError unless it is a finite number > above, ≥ least and ≤ most."""
    try:
        value = _double(value)
    except NO_NUMBERS as error:
        raise ParameterError(f"{name} is {shown(value)}; give a number") from error
    if not (isfinite(value) and value > above and least <= value <= most):
        limits = [
            f"> {above:g}" if above > -np.inf else "",
            f"≥ {least:g}" if least > -np.inf else "",
            f"≤ {most:g}" if most < np.inf else "",
        ]
        bounds = " and ".join(limit for limit in limits if limit)
        raise ParameterError(
            " ".join(f"{name} is {value}; give a finite number {bounds}".split()) + (f" [{unit}]" if unit else "")
        )
    return value


NEVER_NUMBERS = str, bytes, bytearray, complex, np.complexfloating, np.timedelta64, np.datetime64


def _double(value: Any) -> float:
    """Return one number as a double."""
    if type(value) is float:
        return value
    if isinstance(value, NEVER_NUMBERS) or np.ndim(value) != 0:
        raise TypeError(f"a {type(value).__name__} is no number")
    return float(value)
