"""Is what a user gave a number in its range, a vector, a rotation? If not: which argument it is, and the cure."""

from __future__ import annotations

from math import isfinite

import numpy as np
from numpy.typing import ArrayLike

from softbody.errors import ParameterError


def vector(value: ArrayLike, name: str) -> np.ndarray:
    """Return three finite numbers as an array (3,)."""
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ParameterError(f"{name} is {value!r}; give three numbers") from error
    if array.shape != (3,) or not np.isfinite(array).all():
        raise ParameterError(f"{name} is {value!r}; give three finite numbers")
    return array


# How far from unit length a quaternion may be and still be taken for a rounded unit quaternion.
QUATERNION_TOLERANCE = 1e-6


def unit_quaternion(value: ArrayLike) -> np.ndarray:
    """Return an orientation (w, x, y, z) as an array (4,), of unit length to the last bit."""
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ParameterError(f"orientation is {value!r}; give four numbers (w, x, y, z)") from error
    if array.shape != (4,) or not np.isfinite(array).all():
        raise ParameterError(f"orientation is {value!r}; give four finite numbers (w, x, y, z)")
    length = float(np.linalg.norm(array))
    if not abs(length - 1.0) <= QUATERNION_TOLERANCE:
        raise ParameterError(f"orientation {value!r} has length {length:.6g}; divide it by that to make it 1")
    return array / length


def stiffness_of(stiffness: ArrayLike, count: int) -> np.ndarray:
    """Return the stiffness ≥ 0 [N/m] of each of `count` springs, given one number or one for each."""
    try:
        array = np.asarray(stiffness, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ParameterError(f"stiffness is {stiffness!r}; give one number or one for each edge [N/m]") from error
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
        array = np.broadcast_to(np.asarray(rest_length, dtype=np.float64), count).copy()
    except (TypeError, ValueError) as error:
        raise ParameterError(
            f"rest_length does not fit; give one number or one for each of the {count} edges [m]"
        ) from error
    bad = ~(np.isfinite(array) & (array > 0.0))
    if bad.any():
        edge = int(np.argmax(bad))
        raise ParameterError(f"rest_length of edge {edge} is {array[edge]}; give a finite length > 0 [m]")
    return array


def fixed_particles_of(fixed: ArrayLike, count: int) -> np.ndarray:
    """Return the indices of fixed vertices, each once, in order; of `count` at least one is free."""
    try:
        array = np.asarray(fixed)
        if array.size == 0:
            return np.empty(0, np.int64)
        if array.dtype.kind not in "iu" or array.ndim != 1:
            raise TypeError(f"{array.dtype} of shape {array.shape} are no indices")
    except (TypeError, ValueError) as error:
        raise ParameterError(f"fixed is {fixed!r}; give the indices of vertices") from error
    bad = (array < 0) | (array >= count)
    if bad.any():
        raise ParameterError(f"fixed vertex {array[np.argmax(bad)]} does not exist: there are 0 … {count - 1}")
    indices = np.unique(array)
    if len(indices) == count:
        raise ParameterError("every vertex is fixed, so that nothing can move; leave one free")
    return indices


def check_whole(value: int, name: str, least: int) -> None:
    """Raise ParameterError unless `value` is a whole number ≥ least."""
    if not isinstance(value, (int, np.integer)) or not least <= value < 2**63:
        raise ParameterError(f"{name} is {value!r}; give a whole number ≥ {least}")


def check_range(
    value: float,
    name: str,
    unit: str = "",
    above: float = -np.inf,
    least: float = -np.inf,
    most: float = np.inf,
) -> None:
    """Raise ParameterError unless `value` is a finite number > above, ≥ least and ≤ most."""
    try:
        good = isfinite(value) and value > above and least <= value <= most
    except (TypeError, OverflowError) as error:
        raise ParameterError(f"{name} is {value!r}; give a number") from error
    if not good:
        limits = [
            f"> {above:g}" if above > -np.inf else "",
            f"≥ {least:g}" if least > -np.inf else "",
            f"≤ {most:g}" if most < np.inf else "",
        ]
        bounds = " and ".join(limit for limit in limits if limit)
        raise ParameterError(
            " ".join(f"{name} is {value}; give a finite number {bounds}".split()) + (f" [{unit}]" if unit else "")
        )
