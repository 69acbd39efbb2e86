"""Entries of a trajectory's NPZ files, and the checks of what was read."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from softbody.errors import SnapshotError, TrajectoryError
from softbody.model.arrays import Rows, State
from softbody.model.shapes import Shapes
from softbody.model.validation import QUATERNION_TOLERANCE
from softbody.storage.npz import Kind, read
from softbody.storage.snapshot_entries import Entries, Snapshot

FILES = Kind("a trajectory", "softbody.TrajectoryWriter", "Trajectory.open")

PLACES = {"particle_position": 3, "box_position": 3, "box_orientation": 4}  # fields of a State, with their columns
SPEEDS = {"particle_velocity": 3, "box_velocity": 3, "box_angular_velocity": 3}


def frame_of(state: State, velocities: bool) -> Snapshot:
    """Return copies of what is kept of a State."""
    return {name: getattr(state, name).copy() for name in (PLACES | SPEEDS if velocities else PLACES)}


def read_shapes(path: Path, most_bytes: int) -> Shapes:
    """Return the shapes of bodies that a file has; raises TrajectoryError."""
    try:
        entries = _entries(path, most_bytes)
        soft, boxes = entries.length("soft_particle_start") - 1, entries.length("box_size")
        starts = {}
        for name in ("soft_particle_start", "soft_triangle_start"):
            start = entries.rows(name, (max(soft, 0) + 1,), Rows(whole=True, least=0))
            if start[0] != 0 or not (start[1:] > start[:-1]).all():
                raise SnapshotError(f"{name} is {start}; it must begin with 0 and grow with every body")
            starts[name] = start
        triangles = entries.rows("triangle_particles", (int(starts["soft_triangle_start"][-1]), 3), Rows(3, whole=True))
        sizes = entries.rows("box_size", (boxes, 3), Rows(3, above=0.0))
        entries.none_left()
        shapes = Shapes(**starts, triangle_particles=triangles, box_size=sizes)
        for body in range(shapes.soft_count):
            own, count = shapes.triangles(body), shapes.particles(body).stop - shapes.particles(body).start
            if own.min() < 0 or own.max() >= count:
                raise SnapshotError(f"triangle_particles of soft body {body} go beyond its {count} particles")
        return shapes
    except (SnapshotError, OSError) as error:
        raise refused(path, error) from error


def read_chunk(path: Path, times: np.ndarray, shapes: Shapes, velocities: bool, most_bytes: int) -> Snapshot:
    """Return the frames at `times` (f,) [s] as arrays (f, rows, columns); raises TrajectoryError."""
    try:
        entries = _entries(path, most_bytes)
        if not np.array_equal(entries.rows("time", (len(times),), Rows(least=0.0)), times):
            raise SnapshotError("time is not what trajectory.json says: it is a chunk of another trajectory")
        return checked_frames(entries, len(times), shapes, velocities)
    except (SnapshotError, OSError) as error:
        raise refused(path, error) from error


def checked_frames(entries: Entries, count: int, shapes: Shapes, velocities: bool) -> Snapshot:
    """Take `count` frames of bodies, and nothing else; raises SnapshotError, which names the entry."""
    rows = {"particle": shapes.particle_count, "box": shapes.box_count}
    frames = {
        name: entries.rows(name, (count, rows[name.partition("_")[0]], columns), Rows(columns))
        for name, columns in (PLACES | SPEEDS if velocities else PLACES).items()
    }
    entries.none_left()
    length = np.linalg.norm(frames["box_orientation"], axis=2)
    good = np.abs(length - 1.0) <= QUATERNION_TOLERANCE
    if not good.all():
        k, box = np.unravel_index(int(np.argmin(good)), good.shape)
        raise SnapshotError(f"box_orientation[{k}, {box}] has length {length[k, box]:.6g}; it must be 1")
    return frames


def refused(path: Path, error: Exception) -> TrajectoryError:
    """Return the error that names a file of a trajectory that cannot be read."""
    if isinstance(error, FileNotFoundError):
        return TrajectoryError(f"{path} is missing; copy the whole folder, or keep the trajectory anew")
    told = f"{error}" if str(path) in str(error) else f"{path}: {error}"
    return TrajectoryError(f"{told}; copy the folder anew, or keep the trajectory anew")


def _entries(path: Path, most_bytes: int) -> Entries:
    return Entries(read(path, most_bytes, FILES), "a part of a trajectory")
