"""What a writer of a trajectory holds, and what it goes on with."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from softbody.errors import TrajectoryError
from softbody.model.shapes import Cast, Shapes
from softbody.storage.npz import MOST_BYTES
from softbody.storage.snapshot_entries import Snapshot
from softbody.trajectory.bodies import digest_of
from softbody.trajectory.entries import read_chunk, read_shapes
from softbody.trajectory.manifest import Chunk, Manifest, Segment, read_manifest


class Held(NamedTuple):
    """What a writer holds: replaced as one, so that no interrupt comes between."""

    disk: Manifest  # that is on the disk
    base: Manifest  # those of its frames that stay
    cast: Cast  # bodies of the last frame, or of the first that will be
    pending: list[tuple[float, Snapshot]]  # times [s] and frames after them, which are not on the disk
    is_new: bool = False  # whether these begin a segment

    @property
    def frames(self) -> int:
        """Frames that stay or are new."""
        return sum(segment.frames for segment in self.base.segments) + len(self.pending)

    @property
    def last_time(self) -> float:
        """Time of the last frame [s], −inf if there is none."""
        if self.pending:
            return self.pending[-1][0]
        last = self.base.segments[-1].chunks
        return last[-1].times[-1] if last else -np.inf

    def wanted(self) -> Manifest:
        """Return what is to be on the disk; names of files that are new are none of those there."""
        if not self.pending:
            return self.base
        wanted = self.base
        if self.is_new:
            wanted = wanted.and_segment(Segment(self.disk.next_bodies(), digest_of(self.cast.shapes), self.cast.labels))
        return wanted.and_chunk(Chunk(self.disk.next_file(), tuple(time for time, _ in self.pending)))


def found(folder: Path, cast: Cast, velocities: bool, now: float) -> Held:
    """Go on with the trajectory that is there, at the time `now` [s], with the bodies that it had then."""
    disk = read_manifest(folder)
    if disk.velocities != velocities:
        raise TrajectoryError(f"{folder} was begun with velocities={disk.velocities}; resume it with the same")
    base, cut, count = _until(disk, _staying(folder, disk, cast.shapes, now))
    pending = list[tuple[float, Snapshot]]()
    if cut and count:
        frames = read_chunk(folder / cut.file, np.array(cut.times), cast.shapes, velocities, MOST_BYTES)
        pending = [(cut.times[k], {name: rows[k] for name, rows in frames.items()}) for k in range(count)]
    return Held(disk, base, cast, pending)


def _staying(folder: Path, disk: Manifest, shapes: Shapes, now: float) -> int:
    """Return how many frames stay: those up to now, and of those right now, up to the last of the world's bodies.

    Raises TrajectoryError where the world has other bodies than it had then.
    """
    times, bodies = disk.times, digest_of(shapes)
    count = int(np.searchsorted(times, now, side="right"))
    firsts = np.cumsum([0, *(segment.frames for segment in disk.segments[:-1])]).tolist()
    for segment, first in reversed(list(zip(disk.segments, firsts))):
        if first and first >= count:  # all of it is later
            continue
        if segment.sha256 == bodies:
            break
        if not first or times[first] < now:
            raise _of_others(folder, segment, shapes)
        count = first
    return count


def _until(disk: Manifest, count: int) -> tuple[Manifest, Chunk | None, int]:
    """Return so many frames, as far as they are whole chunks; the chunk that is cut, and how many stay of it."""
    segments, cut = list[Segment](), None
    for segment in disk.segments:
        if cut or (segments and not count):
            break
        whole = list[Chunk]()
        for chunk in segment.chunks:
            if len(chunk.times) > count:
                cut = chunk
                break
            whole.append(chunk)
            count -= len(chunk.times)
        segments.append(segment._replace(chunks=tuple(whole)))
    return disk._replace(segments=tuple(segments)), cut, count


def _of_others(folder: Path, segment: Segment, now: Shapes) -> TrajectoryError:
    """Return the error that says in what a world's bodies are not those of its trajectory."""
    cure = f"{folder} is of other bodies; resume it with those, or keep this world in a new folder"
    before = read_shapes(folder / segment.file, MOST_BYTES)
    for what, a, b in (
        ("soft bodies", now.soft_count, before.soft_count),
        ("boxes", now.box_count, before.box_count),
        ("particles", now.particle_count, before.particle_count),
    ):
        if a != b:
            return TrajectoryError(f"the world has {a} {what}, and its trajectory had {b} then: {cure}")
    return TrajectoryError(f"the world's bodies are of other meshes or sizes than its trajectory's then: {cure}")
