"""Writer of trajectories: a world kept frame by frame, so that it is there whatever ends it."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

import numpy as np

from softbody.errors import OutputError, ParameterError, SnapshotError, TrajectoryError
from softbody.model.shapes import Shapes, shapes_of
from softbody.model.validation import check_range, check_yes_or_no
from softbody.stepping.frames import frames, frames_by_steps
from softbody.stepping.runner import Steppable
from softbody.stepping.time_steps import check_own_steps
from softbody.storage.atomic_file import alone_in, path_of, whole_file
from softbody.storage.npz import MOST_BYTES
from softbody.storage.snapshot import digest, named_arrays
from softbody.storage.snapshot_entries import Entries, Snapshot
from softbody.trajectory.entries import BODIES, checked_frames, frame_of, read_chunk, read_shapes
from softbody.trajectory.manifest import NAME, Chunk, Manifest, read_manifest, write_manifest

CHUNK_FRAMES, CHUNK_BYTES = 128, 2**23  # that a chunk has at most: what a kill may cost


class _Held(NamedTuple):
    """What a writer holds: replaced as one, so that no interrupt comes between."""

    disk: Manifest  # that is on the disk
    base: Manifest  # those of its frames that stay
    pending: list[tuple[float, Snapshot]]  # times [s] and frames after them, which are not on the disk


class TrajectoryWriter:
    """A trajectory of a world, that grows by a frame at a time, in the folder `path`: `Trajectory.open(path)` reads it.

    `with TrajectoryWriter(world, "fall") as kept: kept.run(seconds=2.0)`, or `kept.frame()` wherever one is to be kept.
    `frames_per_second` is how often `run` keeps one. Positions of particles, positions and orientations of boxes, and
    all `velocities`, if not told otherwise, are kept to the last bit.

    `resume=True` goes on with the trajectory that is there: it must be of the same bodies, and frames that are later
    than the world is now are left out. Without it, a folder that holds anything is refused.

    Frames are written in chunks, of 128 frames or 8 MiB; `flush` writes what there is, and so does the end of the
    block, whatever ends it. The folder can be read meanwhile. A process that is killed loses what was not written.
    Whatever cannot work is said at once: OutputError, ParameterError, TrajectoryError.
    """

    def __init__(
        self,
        world: Steppable,
        path: str | os.PathLike[str],
        frames_per_second: float = 60.0,
        *,
        velocities: bool = True,
        resume: bool = False,
    ) -> None:
        self._rate = check_range(frames_per_second, "frames_per_second", "1/s", above=0.0)
        self._velocities, resume = check_yes_or_no(velocities, "velocities"), check_yes_or_no(resume, "resume")
        self._folder = path_of(path).absolute()  # wherever the program goes meanwhile
        self._runner, self._shapes = world.runner, shapes_of(world.store.model)
        if not self._shapes.soft_count + self._shapes.box_count:
            raise ParameterError("the world has no bodies, and none can be added to a trajectory; add them first")
        bodies = _digest(self._shapes)
        try:
            if resume and os.path.lexists(self._folder / NAME):
                self._held = self._found(bodies)
            else:
                self._held = self._new(Manifest(bodies, self._velocities, world.store.labels()))
        except OSError as error:
            raise _refused(self._folder, error, 0) from error
        self._begun = self._held.base.times[0] if self._held.base.chunks else world.store.time
        self._tried: Manifest | None = None  # what was last begun to be written
        self._is_open = True

    def __enter__(self) -> TrajectoryWriter:
        """Return the writer."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Write what there is, whatever has happened."""
        self.close()

    @property
    def frames(self) -> int:
        """Frames that were kept, with those that were there before and stay."""
        return sum(len(chunk.times) for chunk in self._held.base.chunks) + len(self._held.pending)

    def frame(self) -> None:
        """Keep the world as it is now.

        Raises ParameterError, and keeps what there is, where bodies were added or removed, something is not finite, or
        the world is earlier than its last frame; OutputError where the disk is full.
        """
        if not self._is_open:
            raise ParameterError(f"{self._folder} is closed; open it with another TrajectoryWriter and resume=True")
        with self._runner.store.exclusive():
            time, frame = self._runner.store.time, self._checked()
        last = self.last_time
        if time < last:
            raise ParameterError(
                f"the world is at {time:.6g} s, before the last frame, at {last:.6g} s; keep it in a new folder, or "
                "resume=True to leave out what is later"
            )
        pending = self._held.pending
        pending.append((time, frame))
        size = sum(array.nbytes for array in frame.values())
        if len(pending) >= min(CHUNK_FRAMES, max(1, CHUNK_BYTES // size)):
            self.flush()

    def run(
        self,
        seconds: float,
        time_step: float | None = None,
        *,
        substeps: int | None = None,
        allow_unstable: bool = False,
    ) -> None:
        """Advance the world as `World.run` does, and keep a frame whenever it is time for one; the first at once.

        Without a `time_step` the world chooses it from frame to frame. With one, frame k is that of the step nearest
        to k / frames_per_second since the first. Raises ParameterError for a time step that is longer than a frame.
        """
        seconds = check_range(seconds, "seconds", "s", least=0.0)
        check_own_steps(time_step, substeps, allow_unstable)
        if time_step is not None:
            check_range(time_step, "time_step", "s", above=0.0, most=1.0 / self._rate)
        is_first = not self.frames
        if is_first:
            self._begun = self._runner.store.time
        if is_first or (time_step is None and self._runner.store.time > self.last_time):
            self.frame()
        if time_step is None:
            for _ in frames(self._runner, seconds, self._rate):
                self.frame()
            return
        taken = self.frames, self._begun
        for _ in frames_by_steps(self._runner, seconds, time_step, self._rate, taken, substeps, allow_unstable):
            self.frame()

    def flush(self) -> None:
        """Write what was kept to the disk.

        Raises OutputError, as the disk does: it can be called again when there is room; TrajectoryError where somebody
        else has changed the folder.
        """
        try:
            with alone_in(self._folder):
                self._flush()
        except OSError as error:
            if isinstance(error, OutputError):
                raise
            raise _refused(self._folder, error, len(self._held.disk.times)) from error

    def close(self) -> None:
        """Write what was kept to the disk, and end. A second call does nothing."""
        if self._is_open:
            self.flush()
            self._is_open = False

    @property
    def last_time(self) -> float:
        """Time of the last frame [s], −inf if there is none."""
        if self._held.pending:
            return self._held.pending[-1][0]
        return self._held.base.chunks[-1].times[-1] if self._held.base.chunks else -np.inf

    def _checked(self) -> Snapshot:
        """Return what is kept of the world as it is; raises ParameterError."""
        shapes = shapes_of(self._runner.store.model)
        if any(now is not before for now, before in zip(shapes, self._shapes)):
            _check_same(
                shapes, self._shapes, ParameterError, "bodies were added or removed; keep the world from now on"
            )
            self._shapes = shapes
        now = {name: array[None] for name, array in frame_of(self._runner.store.state, self._velocities).items()}
        try:
            frame = checked_frames(Entries(now, "a frame"), 1, shapes, self._velocities)
        except SnapshotError as error:
            raise ParameterError(f"the frame at {self._runner.store.time:.6g} s cannot be kept: {error}") from error
        return {name: array[0] for name, array in frame.items()}

    def _new(self, manifest: Manifest) -> _Held:
        """Begin a trajectory: in this way it shows at once whether the disk can be written to."""
        self._folder.mkdir(parents=True, exist_ok=True)
        with alone_in(self._folder):
            if os.path.lexists(self._folder / NAME):
                raise OutputError(
                    f"{self._folder} holds a trajectory; resume=True goes on with it, or give the name of a new folder"
                )
            if any(not name.startswith(".") and name != BODIES for name in os.listdir(self._folder)):
                raise OutputError(f"{self._folder} holds other things than a trajectory; give the name of a new folder")
            with whole_file(self._folder / BODIES) as file:
                np.savez(file, **self._shapes._asdict())
            write_manifest(self._folder, manifest)
        return _Held(manifest, manifest, [])

    def _found(self, bodies: str) -> _Held:
        """Go on with the trajectory that is there."""
        disk = read_manifest(self._folder)
        if disk.bodies != bodies:
            there = f"{self._folder} is of other bodies; resume it with those, or keep this world"
            _check_same(
                shapes_of(self._runner.store.model), read_shapes(self._folder, MOST_BYTES), TrajectoryError, there
            )
            raise TrajectoryError(f"{there} in a new folder")
        if disk.velocities != self._velocities:
            raise TrajectoryError(
                f"{self._folder} was begun with velocities={disk.velocities}; resume it with the same"
            )
        now, pending = self._runner.store.time, list[tuple[float, Snapshot]]()
        stays = [chunk for chunk in disk.chunks if chunk.times[-1] <= now]
        if len(stays) < len(disk.chunks):
            cut = disk.chunks[len(stays)]
            count = int(np.searchsorted(cut.times, now, side="right"))
            if count:
                path, times = self._folder / cut.file, np.array(cut.times)
                frames = read_chunk(path, times, self._shapes, self._velocities, MOST_BYTES)
                pending = [(cut.times[k], {name: rows[k] for name, rows in frames.items()}) for k in range(count)]
        return _Held(disk, disk._replace(chunks=tuple(stays)), pending)

    def _flush(self) -> None:
        disk, base, pending = self._held
        chunk = Chunk(disk.next_file(), tuple(time for time, _ in pending))
        wanted = base._replace(chunks=(*base.chunks, chunk)) if pending else base
        if wanted == disk:
            return
        found = read_manifest(self._folder)
        if found != disk:
            if found != self._tried:
                raise TrajectoryError(
                    f"{self._folder} was changed by somebody else since it was opened here; one writer has a folder"
                )
            # An interrupt came when it had been written.
            there = len(found.times) - len(base.times)
            self._held = _Held(found, found, pending[there:])
            self._flush()
            return
        self._tried = wanted
        if pending:
            frames = {name: np.stack([frame[name] for _, frame in pending]) for name in pending[0][1]}
            with whole_file(self._folder / chunk.file) as file:
                np.savez(file, time=np.array(chunk.times), **frames)  # type: ignore[arg-type]
        write_manifest(self._folder, wanted)
        self._held = _Held(wanted, wanted, [])
        for left_out in set(disk.chunks) - set(wanted.chunks):
            with suppress(OSError):
                (self._folder / left_out.file).unlink()


def _digest(shapes: Shapes) -> str:
    return digest(named_arrays("bodies", shapes))


def _check_same(now: Shapes, before: Shapes, kind: type[ParameterError], cure: str) -> None:
    """Raise an error of a `kind` for bodies that are not those of the trajectory."""
    for what, a, b in (
        ("soft bodies", now.soft_count, before.soft_count),
        ("boxes", now.box_count, before.box_count),
        ("particles", now.particle_count, before.particle_count),
    ):
        if a != b:
            raise kind(f"the world has {a} {what}, and its trajectory {b}: {cure} in a new folder")
    if any(not np.array_equal(a, b) for a, b in zip(now, before)):
        raise kind(f"the world's bodies are of other meshes or sizes than its trajectory's: {cure} in a new folder")


def _refused(folder: Path, error: OSError, frames: int) -> OutputError:
    """Return the error that says what the disk said, and what is kept."""
    if isinstance(error, OutputError):
        return error
    kept = f"; its first {frames} frames are there" if frames else ""
    return OutputError(f"{folder} cannot be written: {error.strerror or error}{kept}")
