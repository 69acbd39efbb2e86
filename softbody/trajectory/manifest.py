"""Manifest of a trajectory: its chunks, bodies and times, checked when it is read."""

from __future__ import annotations

import json
import re
from itertools import pairwise
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

from softbody.bodies.names import names_of
from softbody.errors import ParameterError, TrajectoryError
from softbody.model.shapes import Labels
from softbody.storage.atomic_file import whole_file
from softbody.trajectory.entries import BODIES
from softbody.version import __version__

NAME = "trajectory.json"
FORMAT = 1
MOST_BYTES = 2**26  # that a manifest may have: some three million frames

UNITS = {
    "length": "m",
    "time": "s",
    "velocity": "m/s",
    "angular velocity": "rad/s, world frame",
    "orientation": "unit quaternion (w, x, y, z), box frame to world",
    "axes": "right-handed, z is up",
}


class Chunk(NamedTuple):
    """Frames that are in one file."""

    file: str
    times: tuple[float, ...]  # [s]


class Manifest(NamedTuple):
    """What a trajectory is made of."""

    bodies: str  # SHA-256 of what `bodies.npz` holds
    velocities: bool  # whether they are kept, too
    labels: Labels | None = None  # what they were called when it was begun; trajectories of old do not say
    chunks: tuple[Chunk, ...] = ()

    @property
    def times(self) -> tuple[float, ...]:
        """Time of each frame [s]."""
        return tuple(time for chunk in self.chunks for time in chunk.times)

    def next_file(self) -> str:
        """Return a name for a chunk that none of these has."""
        return f"{max((int(chunk.file.split('.')[0]) for chunk in self.chunks), default=-1) + 1:06d}.npz"


def write_manifest(folder: Path, manifest: Manifest) -> None:
    """Let the folder hold this trajectory from now on; raises OSError as the disk does."""
    text = {
        "format": FORMAT,
        "softbody": __version__,
        "units": UNITS,
        "bodies": {"file": BODIES, "sha256": manifest.bodies},
        "velocities": manifest.velocities,
        **({"labels": manifest.labels._asdict()} if manifest.labels else {}),
        "chunks": [{"file": name, "frames": len(times), "times": times} for name, times in manifest.chunks],
    }
    with whole_file(folder / NAME) as file:
        file.write(json.dumps(text, indent=1).encode())


def read_manifest(folder: Path) -> Manifest:
    """Return what a folder says it holds; raises TrajectoryError, which names the entry and the cure."""
    path = folder / NAME
    try:
        if path.exists() and not path.is_file():  # nor opened: nobody may ever write to a pipe
            raise TrajectoryError("it is no file")
        with path.open("rb") as file:
            raw = file.read(MOST_BYTES + 1)
        if len(raw) > MOST_BYTES:
            raise TrajectoryError(f"it has more than {MOST_BYTES} bytes: it is no manifest")
        return _manifest(_parsed(raw))
    except (FileNotFoundError, NotADirectoryError) as error:
        raise TrajectoryError(f"{folder} holds no trajectory: there is no {NAME}; give the folder of one") from error
    except OSError as error:
        raise TrajectoryError(f"{path} cannot be read: {error.strerror or error}") from error
    except TrajectoryError as error:
        raise TrajectoryError(f"{path}: {error}; copy the folder anew, or keep the trajectory anew") from error


def _parsed(raw: bytes) -> dict[str, Any]:
    try:
        found = json.loads(raw)
    except (ValueError, RecursionError) as error:  # no JSON, no UTF-8, a number or a nesting out of all bounds
        raise TrajectoryError("it is no JSON, or a damaged one") from error
    if not isinstance(found, dict):
        raise TrajectoryError("it is no manifest of a trajectory")
    return found


def _manifest(found: dict[str, Any]) -> Manifest:
    number = found.get("format")
    if type(number) is int and number > FORMAT:
        raise TrajectoryError(f"format is {number}, and this softbody reads formats up to {FORMAT}: take a newer one")
    _need(number == FORMAT, f"format must be {FORMAT}")
    bodies = found.get("bodies")
    sha = bodies.get("sha256") if isinstance(bodies, dict) else None
    _need(isinstance(sha, str) and re.fullmatch("[0-9a-f]{64}", sha), "bodies.sha256 must be one, in hexadecimal")
    velocities = found.get("velocities")
    _need(isinstance(velocities, bool), "velocities must be true or false")
    listed = found.get("chunks")
    _need(isinstance(listed, list), "chunks must be a list")
    chunks = tuple(_chunk(each, k) for k, each in enumerate(listed or ()))
    _need(len({chunk.file for chunk in chunks}) == len(chunks), "chunks must have a file each")
    manifest = Manifest(str(sha), bool(velocities), _labels(found.get("labels")), chunks)
    _need(all(a <= b for a, b in pairwise(manifest.times)), "times of chunks must not go back")
    return manifest


def _labels(found: Any) -> Labels | None:
    """Return what bodies are called; raises TrajectoryError for names that no world would give."""
    if found is None:
        return None
    _need(isinstance(found, dict) and set(found) == set(Labels._fields), "labels must have soft, box and held")
    soft, boxes, held = (found[name] for name in Labels._fields)
    _need(all(isinstance(each, list) for each in (soft, boxes, held)), "labels must be lists")
    _need(all(isinstance(each, bool) for each in held), "labels.held must be true or false for each box")
    try:
        names_of({"soft": soft, "box": boxes}, "labels")
    except ParameterError as error:
        raise TrajectoryError(f"{error}") from error
    return Labels(*(tuple(each) for each in (soft, boxes, held)))


def _chunk(found: Any, k: int) -> Chunk:
    name = f"chunks[{k}]"
    _need(isinstance(found, dict), f"{name} must be an object")
    file, times = found.get("file"), found.get("times")
    # A name of ours, so that no file is read that lies elsewhere.
    _need(isinstance(file, str) and re.fullmatch(r"[0-9]{6,18}\.npz", file), f"{name}.file must be such as 000000.npz")
    numbers = isinstance(times, list) and all(type(time) is float and isfinite(time) and time >= 0.0 for time in times)
    _need(numbers and times, f"{name}.times must be times of frames [s], finite and ≥ 0.0")
    _need(found.get("frames") == len(times), f"{name}.frames must be the number of its times, {len(times)}")
    return Chunk(file, tuple(times))


def _need(ok: object, message: str) -> None:
    if not ok:
        raise TrajectoryError(message)
