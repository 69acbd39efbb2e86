"""Manifest of a trajectory: its segments, with their bodies, chunks and times, checked when it is read.

A trajectory whose bodies never changed has format 1, of which the segment's entries stand by themselves.
"""

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
from softbody.version import __version__

NAME = "trajectory.json"
BODIES = "bodies.npz"  # of those that were there first
FORMAT = 2
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


class Segment(NamedTuple):
    """Frames, one after the other, of the same bodies."""

    file: str  # of bodies
    sha256: str  # of what that holds
    labels: Labels | None = None  # what they were called when it was begun; trajectories of old do not say
    chunks: tuple[Chunk, ...] = ()

    @property
    def frames(self) -> int:
        """How many it has."""
        return sum(len(chunk.times) for chunk in self.chunks)


class Manifest(NamedTuple):
    """What a trajectory is made of."""

    velocities: bool  # whether they are kept, too
    segments: tuple[Segment, ...]  # one at least; of several, each has frames

    @property
    def chunks(self) -> tuple[Chunk, ...]:
        """Those of all segments."""
        return tuple(chunk for segment in self.segments for chunk in segment.chunks)

    @property
    def times(self) -> tuple[float, ...]:
        """Time of each frame [s]."""
        return tuple(time for chunk in self.chunks for time in chunk.times)

    @property
    def files(self) -> set[str]:
        """Names of all files but the manifest's own."""
        return {segment.file for segment in self.segments} | {chunk.file for chunk in self.chunks}

    def next_file(self) -> str:
        """Return a name for a chunk that none of these has."""
        return f"{max((_number(chunk.file) for chunk in self.chunks), default=-1) + 1:06d}.npz"

    def next_bodies(self) -> str:
        """Return a name for a file of bodies that none of these has."""
        return f"bodies-{max(_number(segment.file) for segment in self.segments) + 1:06d}.npz"

    def and_segment(self, segment: Segment) -> Manifest:
        """Return this one with another segment; the first one goes, if it is left without frames."""
        return self._replace(segments=(*(each for each in self.segments if each.chunks), segment))

    def and_chunk(self, chunk: Chunk) -> Manifest:
        """Return this one with another chunk in its last segment."""
        *before, last = self.segments
        return self._replace(segments=(*before, last._replace(chunks=(*last.chunks, chunk))))


def write_manifest(folder: Path, manifest: Manifest) -> None:
    """Let the folder hold this trajectory from now on; raises OSError as the disk does."""
    segments = [_told(segment) for segment in manifest.segments]
    is_plain = len(segments) == 1 and manifest.segments[0].file == BODIES
    text = {
        "format": 1 if is_plain else FORMAT,
        "softbody": __version__,
        "units": UNITS,
        "velocities": manifest.velocities,
        **(segments[0] if is_plain else {"segments": segments}),
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


def _number(file: str) -> int:
    """Return the number in a name of a file, 0 if it has none."""
    return int("".join(filter(str.isdigit, file)) or 0)


def _told(segment: Segment) -> dict[str, Any]:
    return {
        "bodies": {"file": segment.file, "sha256": segment.sha256},
        **({"labels": segment.labels._asdict()} if segment.labels else {}),
        "chunks": [{"file": name, "frames": len(times), "times": times} for name, times in segment.chunks],
    }


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
    _need(type(number) is int and number >= 1, f"format must be 1 or {FORMAT}")
    velocities = found.get("velocities")
    _need(isinstance(velocities, bool), "velocities must be true or false")
    segments = (_segment(found, ""),) if number == 1 else _segments(found.get("segments"))
    manifest = Manifest(bool(velocities), segments)
    _need(len(manifest.files) == len(segments) + len(manifest.chunks), "chunks must have a file each, and bodies, too")
    _need(all(a <= b for a, b in pairwise(manifest.times)), "times of chunks must not go back")
    return manifest


def _segments(found: Any) -> tuple[Segment, ...]:
    """Return those of a trajectory of format 2."""
    _need(isinstance(found, list) and found, "segments must be a list of one at least")
    segments = []
    for k, each in enumerate(found):
        where = f"segments[{k}]"
        _need(isinstance(each, dict), f"{where} must be an object")
        bodies = each.get("bodies")
        file = bodies.get("file") if isinstance(bodies, dict) else None
        is_ours = isinstance(file, str) and re.fullmatch(r"bodies(-[0-9]{6,18})?\.npz", file)
        _need(is_ours, f"{where}.bodies.file must be such as {BODIES} or bodies-000001.npz")
        segments.append(_segment(each, f"{where}.", str(file)))
        _need(segments[-1].chunks or len(found) == 1, f"{where}.chunks must have one at least")
    return tuple(segments)


def _segment(found: dict[str, Any], where: str, file: str = BODIES) -> Segment:
    """Return a segment, whose entries `where` leads to in messages."""
    bodies = found.get("bodies")
    sha = bodies.get("sha256") if isinstance(bodies, dict) else None
    is_one = isinstance(sha, str) and re.fullmatch("[0-9a-f]{64}", sha)
    _need(is_one, f"{where}bodies.sha256 must be one, in hexadecimal")
    listed = found.get("chunks")
    _need(isinstance(listed, list), f"{where}chunks must be a list")
    chunks = tuple(_chunk(each, f"{where}chunks[{k}]") for k, each in enumerate(listed or ()))
    return Segment(file, str(sha), _labels(found.get("labels"), f"{where}labels"), chunks)


def _labels(found: Any, name: str) -> Labels | None:
    """Return what bodies are called; raises TrajectoryError for names that no world would give."""
    if found is None:
        return None
    _need(isinstance(found, dict) and set(found) == set(Labels._fields), f"{name} must have soft, box and held")
    soft, boxes, held = (found[field] for field in Labels._fields)
    _need(all(isinstance(each, list) for each in (soft, boxes, held)), f"{name} must be lists")
    _need(all(isinstance(each, bool) for each in held), f"{name}.held must be true or false for each box")
    try:
        names_of({"soft": soft, "box": boxes}, name)
    except ParameterError as error:
        raise TrajectoryError(f"{error}") from error
    return Labels(*(tuple(each) for each in (soft, boxes, held)))


def _chunk(found: Any, name: str) -> Chunk:
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
