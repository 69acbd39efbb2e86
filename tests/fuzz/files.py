"""A snapshot in which anything is changed is refused by the name of an entry, or steps on as any world does.

Every kind of change meets every entry, in a world of some kind; it comes as arrays, in a file, or as a pickle's state.
Refused, it leaves the world that was to take it as it was. Taken, neither steps, nor what is asked of the world, end
otherwise than with finite numbers or an error of the core's own.
"""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from softbody import SnapshotError, World
from softbody.storage.snapshot_entries import Snapshot
from tests.fuzz._worlds import lived, snapshots

GOAL = 20_000

Rng = np.random.Generator

NUMBERS = (
    0.0, -1.0, 1.0, 2.0, 0.5, -0.0, 1e-3, 1e3, 1e9, -1e9, 1e18, -1e18, 1e30, 1e49, -1e49, 1e60, 1e154, 1e300, -1e300,
    1e-30, 1e-49, 1e-60, 1e-160, 1e-300, 5e-324, -5e-324, np.nan, np.inf, -np.inf,
)  # fmt: skip
WHOLES = (0, -1, 1, 2, 3, 7, 255, 10**4, 10**6, 10**9, -(10**9), 2**31, 2**32, 2**53, 2**62, 2**63 - 1, -(2**63))
KIND_NAMES = ("f4", "i4", "u8", "?", "c16", "O", "U3", ">f8", ">i8", "f2", "M8[s]", "i1,f8")


class Hostile:
    """What is no array, and says so rudely."""

    def __array__(self, *arguments: Any, **more: Any) -> np.ndarray:
        raise RuntimeError("I am no array")


def _set(array: np.ndarray, place: int, rng: Rng) -> None:
    """Change one number."""
    flat = array.reshape(-1)
    if array.dtype.kind == "f":
        flat[place] = rng.choice(NUMBERS)
    elif array.dtype.kind == "i":
        flat[place] = WHOLES[rng.integers(len(WHOLES))]
    elif array.dtype.kind == "b":
        flat[place] = not flat[place]
    else:
        flat[place] = rng.choice(["single", "double", "half", ""])


def one_number(array: np.ndarray, rng: Rng) -> Any:
    """Change one number to something special."""
    if array.size:
        _set(array, int(rng.integers(array.size)), rng)
    return array


def nearby(array: np.ndarray, rng: Rng) -> Any:
    """Change one number to one beside it, or that stands elsewhere."""
    if array.size and array.dtype.kind in "fi":
        flat, place = array.reshape(-1), int(rng.integers(array.size))
        with np.errstate(all="ignore"):
            ways = flat[place] + 1, flat[place] - 1, -flat[place], 2 * flat[place], flat[rng.integers(array.size)]
        flat[place] = ways[rng.integers(len(ways))]
    return array


def several(array: np.ndarray, rng: Rng) -> Any:
    """Change a handful of numbers."""
    for _ in range(rng.integers(2, 6)):
        one_number(array, rng)
    return array


def a_row(array: np.ndarray, rng: Rng) -> Any:
    """Change a whole row, or all of them, to the same number."""
    if array.ndim and array.size and array.dtype.kind in "fi":
        rows = slice(None) if rng.random() < 0.3 else int(rng.integers(len(array)))
        array[rows] = rng.choice(NUMBERS) if array.dtype.kind == "f" else WHOLES[rng.integers(len(WHOLES))]
    return array


def scaled(array: np.ndarray, rng: Rng) -> Any:
    """Scale all numbers."""
    if array.dtype.kind == "f":
        with np.errstate(all="ignore"):
            return np.asarray(array * 10.0 ** rng.integers(-60, 60))
    return array


def bits(array: np.ndarray, rng: Rng) -> Any:
    """Flip a bit."""
    raw = bytearray(array.tobytes())
    if raw and array.dtype.kind in "fi":
        raw[rng.integers(len(raw))] ^= 1 << int(rng.integers(8))
        return np.frombuffer(bytes(raw), array.dtype).reshape(array.shape)
    return array


def shuffled(array: np.ndarray, rng: Rng) -> Any:
    """Put rows in another order."""
    return rng.permutation(array) if array.ndim else array


def mixed(array: np.ndarray, rng: Rng) -> Any:
    """Put all numbers in another order."""
    return rng.permutation(array.reshape(-1)).reshape(array.shape)


def other_kind(array: np.ndarray, rng: Rng) -> Any:
    """Hold numbers of another kind."""
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return array.astype(KIND_NAMES[rng.integers(len(KIND_NAMES))])
        except (TypeError, ValueError):
            return array.astype(object)


def other_shape(array: np.ndarray, rng: Rng) -> Any:
    """Have another shape."""
    ways: list[Callable[[], np.ndarray]] = [
        lambda: array.reshape(-1),
        lambda: array.T,
        lambda: array[None],
        lambda: array[..., None],
        lambda: array.reshape(-1)[:0],
        lambda: np.concatenate([array, array]) if array.ndim else np.stack([array, array]),
        lambda: array[:0] if array.ndim else array,
        lambda: np.zeros((0, 3)),
    ]
    return ways[rng.integers(len(ways))]()


def longer(array: np.ndarray, rng: Rng) -> Any:
    """Have a row more, the first once again."""
    return np.concatenate([array, array[:1]]) if array.ndim else array


def shorter(array: np.ndarray, rng: Rng) -> Any:
    """Have some rows less."""
    return array[: -int(rng.integers(1, 4))] if array.ndim else array


def by_columns(array: np.ndarray, rng: Rng) -> Any:
    """Lie in memory by columns, or in steps, or be read-only: the same numbers, which must be taken."""
    way = rng.integers(3)
    if way == 0 and array.ndim:
        return np.repeat(array, 2, axis=0)[::2]
    if way == 1:
        array.flags.writeable = False
        return array
    return np.asfortranarray(array) if array.ndim == 2 else array


def no_array(array: np.ndarray, rng: Rng) -> Any:
    """Be something else, that may do for an array, or not."""
    things = None, "text", b"bytes", [[1, 2], [3]], {}, 10**400, Hostile(), 1j, array.tolist(), np.ma.array(array)
    return things[rng.integers(len(things))]


ONE: tuple[Callable[[np.ndarray, Rng], Any], ...] = (
    one_number, one_number, one_number, one_number, nearby, nearby, several, a_row, scaled, bits, shuffled, mixed,
    other_kind, other_shape, longer, shorter, by_columns, no_array,
)  # fmt: skip


def _damage(arrays: dict[str, Any], name: str, way: int, rng: Rng) -> str:
    """Change an entry in one way of those in `ONE`, or the whole in one of five more; say how."""
    if way < len(ONE):
        arrays[name] = ONE[way](arrays[name], rng)
        return f"{name}: {ONE[way].__name__}"
    other = str(rng.choice(list(arrays)))
    way -= len(ONE)
    if way == 0:
        del arrays[name]
        return f"{name}: dropped"
    if way == 1:
        alike = [one for one in arrays if arrays[one].shape == arrays[name].shape and one != name]
        other = str(rng.choice(alike)) if alike else other
        arrays[name], arrays[other] = arrays[other], arrays[name]
        return f"{name}: swapped with {other}"
    if way == 2:
        stranger = snapshots()[rng.integers(len(snapshots()))]
        if name in stranger:
            arrays[name] = stranger[name].copy()
        return f"{name}: taken from another world"
    if way == 3:
        arrays[str(rng.choice([f"{name} ", "", "rings.particle", name.upper()]))] = arrays[name]
        return f"{name}: there under another name, too"
    arrays[name], arrays[other] = one_number(arrays[name], rng), several(arrays[other], rng)
    return f"{name}: a number, and several of {other}"


WAYS = len(ONE) + 5


def attempt(seed: int) -> str | None:
    """Change one entry, in the way that is its turn, and take the snapshot into a world."""
    rng = np.random.default_rng(seed)
    good = snapshots()[rng.integers(len(snapshots()))]
    arrays: dict[str, Any] = {name: array.copy() for name, array in good.items()}
    name = list(arrays)[seed % len(arrays)]
    how = _damage(arrays, name, seed // len(arrays) % WAYS, rng)
    world = World((0.0, 0.0, -1.0), integrator="rk4")
    world.add_box((1.0, 1.0, 1.0), 1.0)
    before = _bits(world)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            world = _taken(world, arrays, rng)
        except SnapshotError as error:
            if not any(known in str(error) for known in good) and "no entry" not in str(error):
                return f"{how}: refused, and no entry is named: {error}"
            return None if _bits(world) == before else f"{how}: refused, and the world has changed"
        wrong = lived(world, rng)
    return f"{how}: {wrong}" if wrong else None


def _bits(world: World) -> tuple[object, ...]:
    return tuple((name, array.tobytes()) for name, array in world.snapshot().items())


def _taken(world: World, arrays: Snapshot, rng: Rng) -> World:
    """Return a world of a snapshot, taken in one of three ways."""
    way = rng.integers(4)
    if way == 0:
        another = World.__new__(World)
        another.__setstate__(arrays)
        return another
    if way == 1 and all(isinstance(one, np.ndarray) and not one.dtype.hasobject for one in arrays.values()):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "world.npz"
            (np.savez if rng.random() < 0.5 else np.savez_compressed)(path, **arrays)  # type: ignore[arg-type]
            return World.load(path)
    world.restore(arrays)
    return world
