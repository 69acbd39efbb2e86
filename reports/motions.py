"""What moved, as the page has it: read from a run's arrays, checked, and packed so that eight scenes fit in a page."""

from __future__ import annotations

import base64
import json
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from reports.reading import CannotRead

LARGEST = 2**26  # bytes of all arrays of a file
MOST_CODE = 20_000  # characters
MOST_FRAMES, MOST_VERTICES = 2_000, 65_536
KINDS = {
    "code": "U",
    "smooth": "b",
    "clear": "b",
    "places": "u",
    "vertices": "i",
    "faces": "i",
    "triangles": "u",
    "along": "i",
}
SHAPES = {  # of each array: f frames, b things, n vertices, t triangles
    "code": "", "view": "", "ground": "", "part": "", "low": "3", "time": "f", "energy": "f", "depth": "f",
    "camera": "f23", "places": "fn3", "vertices": "b", "faces": "b", "smooth": "b", "clear": "b", "colours": "b23",
    "along": "n", "triangles": "t3",
}  # fmt: skip


@dataclass
class Curve:
    """A measured number over time, drawn 100 wide and 100 high."""

    name: str
    unit: str
    points: str  # of an SVG polyline
    least: float
    greatest: float


@dataclass
class Motion:
    """What the page shows of a scene that moved."""

    packed: str  # JSON, for player.js
    code: str
    seconds: float
    curves: list[Curve]


def read_motion(file: Path, folder: Path, entry: str) -> Motion:
    """Return what moved in a scene; raises CannotRead, naming the entry of the record, for what is damaged."""
    if not file.resolve().is_relative_to(folder.resolve()):
        raise CannotRead(f"{entry}: {file} leads out of the report's folder; a page shows what lies inside")
    try:
        arrays = _arrays(file)
        _check(arrays)
    except (ValueError, KeyError, OSError, EOFError, MemoryError, zlib.error, zipfile.BadZipFile) as error:
        raise CannotRead(f"{entry}: {file} is no motion of a scene ({error}); film it again") from error
    time, energy = arrays["time"] - arrays["time"][0], arrays["energy"] - arrays["energy"].min()
    curves = [curve("energy above its least", "J", time, energy)]
    curves.append(curve("deepest overlap", "mm", time, 1e3 * arrays["depth"]))
    return Motion(json.dumps(_packed(arrays, time, curves)), str(arrays["code"]), float(time[-1]), curves)


def curve(name: str, unit: str, time: np.ndarray, values: np.ndarray) -> Curve:
    """Return the curve of `values` (f,) from 0, or the least of them, up to the greatest."""
    least, greatest = min(0.0, float(values.min())), float(values.max())
    y = 98.0 - 96.0 * (values - least) / ((greatest - least) or 1.0)
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(100.0 * time / time[-1], y))
    return Curve(name, unit, points, least, greatest)


def _arrays(file: Path) -> dict[str, np.ndarray]:
    """Return the arrays of a file; raises ValueError and others for one that is none."""
    with zipfile.ZipFile(file) as container:
        if sum(one.file_size for one in container.infolist()) > LARGEST:
            raise ValueError(f"more than {LARGEST} bytes")
    with np.load(file, allow_pickle=False) as data:
        arrays = {name: data[name] for name in SHAPES if name != "clear" or name in data}
    return {"clear": np.zeros_like(arrays["smooth"]), **arrays}  # older ones do not have it


def _check(arrays: dict[str, np.ndarray]) -> None:
    """Raise ValueError for arrays that do not belong together."""
    sizes = {"2": 2, "3": 3}
    for name, dimensions in SHAPES.items():
        array = arrays[name]
        if array.ndim != len(dimensions) or array.dtype.kind != KINDS.get(name, "f"):
            raise ValueError(f"{name} is {array.dtype} {array.shape}")
        for letter, size in zip(dimensions, array.shape):
            if sizes.setdefault(letter, size) != size:
                raise ValueError(f"{name} is {array.shape}, and should have {sizes[letter]} for {size}")
        if array.dtype.kind == "f" and name != "ground" and not (np.abs(array) < 1e9).all():
            raise ValueError(f"{name} is not finite, or larger than 1e9")
    vertices, faces = arrays["vertices"], arrays["faces"]
    if (
        not 2 <= sizes["f"] <= MOST_FRAMES
        or not 1 <= sizes["n"] <= MOST_VERTICES
        or not (np.diff(arrays["time"]) > 0).all()
    ):
        raise ValueError(f"{sizes['f']} frames of {sizes['n']} vertices, or times that do not grow")
    if min(vertices.min(), faces.min()) < 1 or vertices.sum() != sizes["n"] or faces.sum() != sizes["t"]:
        raise ValueError("vertices and faces do not add up to what is there")
    if (arrays["triangles"] >= np.repeat(vertices, faces)[:, None]).any():
        raise ValueError("a triangle is of vertices that its thing has not")
    if arrays["places"].max() >= 2**13 or len(str(arrays["code"])) > MOST_CODE:
        raise ValueError("places or code are too large")


def _packed(arrays: dict[str, np.ndarray], time: np.ndarray, curves: list[Curve]) -> dict[str, Any]:
    ground = float(arrays["ground"])
    return {
        "time": time.tolist(),
        "measured": {one.name: values for one, values in zip(curves, _rounded(arrays))},
        "camera": arrays["camera"].round(4).tolist(),
        "view": float(arrays["view"]),
        "ground": ground if np.isfinite(ground) else None,
        "low": arrays["low"].tolist(),
        "part": float(arrays["part"]),
        "vertices": arrays["vertices"].tolist(),
        "faces": arrays["faces"].tolist(),
        "smooth": arrays["smooth"].tolist(),
        "clear": arrays["clear"].tolist(),
        "colours": arrays["colours"].round(3).tolist(),
        "along": _deflated(arrays["along"].astype(np.int8).tobytes()),
        "triangles": _deflated(arrays["triangles"].astype("<u2").tobytes()),
        "places": _deflated(coded(arrays["places"])),
    }


def _rounded(arrays: dict[str, np.ndarray]) -> list[list[float]]:
    energy, depth = arrays["energy"] - arrays["energy"].min(), 1e3 * arrays["depth"]
    return [[float(f"{value:.4g}") for value in values] for values in (energy, depth)]


def coded(places: np.ndarray) -> bytes:
    """Return whole numbers below 2¹³ (f, n, 3) by how each departs from going straight on: low bytes, then high ones.

    Of each frame first x of all, then y, then z. An even code is a departure of half of it, an odd one of less than 0.
    """
    whole = places.astype(np.int32).transpose(0, 2, 1)
    straight = np.zeros_like(whole)
    straight[1] = whole[0]
    straight[2:] = 2 * whole[1:-1] - whole[:-2]
    off = whole - straight
    codes = ((off << 1) ^ (off >> 31)).astype("<u2").reshape(-1)
    return (codes & 255).astype(np.uint8).tobytes() + (codes >> 8).astype(np.uint8).tobytes()


def _deflated(data: bytes) -> str:
    return base64.b64encode(zlib.compress(data, 9)).decode()
