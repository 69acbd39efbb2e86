"""Writer of trajectories: a world kept frame by frame, so that it is there whatever ends it."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from types import TracebackType

import numpy as np

from softbody.errors import OutputError, ParameterError, SnapshotError, TrajectoryError
from softbody.model.shapes import Cast, shapes_of
from softbody.model.validation import check_range, check_yes_or_no
from softbody.stepping.frames import frames, frames_by_steps
from softbody.stepping.runner import Steppable
from softbody.stepping.time_steps import check_own_steps
from softbody.storage.atomic_file import alone_in, path_of, whole_file
from softbody.storage.snapshot_entries import Entries, Snapshot
from softbody.trajectory.bodies import digest_of
from softbody.trajectory.entries import checked_frames, frame_of
from softbody.trajectory.held import Held, found
from softbody.trajectory.manifest import BODIES, NAME, Manifest, Segment, read_manifest, write_manifest

CHUNK_FRAMES, CHUNK_BYTES = 128, 2**23  # that a chunk has at most: what a kill may cost


class TrajectoryWriter:
    """A trajectory of a world, that grows by a frame at a time, in the folder `path`: `Trajectory.open(path)` reads it.

    `with TrajectoryWriter(world, "fall") as kept: kept.run(seconds=2.0)`, or `kept.frame()` wherever one is to be kept.
    `frames_per_second` is how often `run` keeps one. Positions of particles, positions and orientations of boxes, and
    all `velocities`, if not told otherwise, are kept to the last bit.

    Bodies may be added, removed, or change their meshes: the next frame begins a new segment of the trajectory then.
    `Trajectory` tells of each frame which bodies it has.

    `resume=True` goes on with the trajectory that is there: frames that are later than the world is now are left out,
    and the last one that stays must be of the bodies that the world has now. Without it, a folder that holds anything
    is refused.

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
        self._runner, store = world.runner, world.store
        try:
            cast = Cast(shapes_of(store.model), store.labels())
            if resume and os.path.lexists(self._folder / NAME):
                self._held = found(self._folder, cast, self._velocities, store.time)
            else:
                self._held = self._new(cast)
        except OSError as error:
            raise _refused(self._folder, error, 0) from error
        self._begun = self._held.base.times[0] if self._held.base.chunks else store.time
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
        return self._held.frames

    def frame(self) -> None:
        """Keep the world as it is now.

        Where bodies were added or removed since the last frame, what there is is written, and a new segment begins.
        Raises ParameterError, and keeps what there is, where something is not finite, or the world is earlier than its
        last frame; OutputError where the disk is full.
        """
        if not self._is_open:
            raise ParameterError(f"{self._folder} is closed; open it with another TrajectoryWriter and resume=True")
        with self._runner.store.exclusive():
            time, cast, frame = self._runner.store.time, self._cast_now(), self._checked()
        last = self.last_time
        if time < last:
            raise ParameterError(
                f"the world is at {time:.6g} s, before the last frame, at {last:.6g} s; keep it in a new folder, or "
                "resume=True to leave out what is later"
            )
        if cast is not self._held.cast:
            is_other = not cast.is_same(self._held.cast)
            if is_other:
                self.flush()
            self._held = self._held._replace(cast=cast, is_new=self._held.is_new or is_other)
        self._held.pending.append((time, frame))
        size = sum(array.nbytes for array in frame.values())
        if len(self._held.pending) >= min(CHUNK_FRAMES, max(1, CHUNK_BYTES // max(1, size))):
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
        return self._held.last_time

    def _cast_now(self) -> Cast:
        """Return the bodies of the world as it is: those of the last frame, unless a world's arrays are others now."""
        store, before = self._runner.store, self._held.cast
        shapes = shapes_of(store.model)
        is_untouched = all(now is then for now, then in zip(shapes, before.shapes))
        return before if is_untouched else Cast(shapes, store.labels())

    def _checked(self) -> Snapshot:
        """Return what is kept of the world as it is; raises ParameterError."""
        shapes = shapes_of(self._runner.store.model)
        now = {name: array[None] for name, array in frame_of(self._runner.store.state, self._velocities).items()}
        try:
            frame = checked_frames(Entries(now, "a frame"), 1, shapes, self._velocities)
        except SnapshotError as error:
            raise ParameterError(f"the frame at {self._runner.store.time:.6g} s cannot be kept: {error}") from error
        return {name: array[0] for name, array in frame.items()}

    def _new(self, cast: Cast) -> Held:
        """Begin a trajectory: in this way it shows at once whether the disk can be written to."""
        manifest = Manifest(self._velocities, (Segment(BODIES, digest_of(cast.shapes), cast.labels),))
        self._folder.mkdir(parents=True, exist_ok=True)
        with alone_in(self._folder):
            if os.path.lexists(self._folder / NAME):
                raise OutputError(
                    f"{self._folder} holds a trajectory; resume=True goes on with it, or give the name of a new folder"
                )
            if any(not name.startswith(".") and name != BODIES for name in os.listdir(self._folder)):
                raise OutputError(f"{self._folder} holds other things than a trajectory; give the name of a new folder")
            self._write(BODIES, cast.shapes._asdict())
            write_manifest(self._folder, manifest)
        return Held(manifest, manifest, cast, [])

    def _flush(self) -> None:
        held, wanted = self._held, self._held.wanted()
        if wanted == held.disk:
            return
        there = read_manifest(self._folder)
        if there != held.disk:
            if there != self._tried:
                raise TrajectoryError(
                    f"{self._folder} was changed by somebody else since it was opened here; one writer has a folder"
                )
            # An interrupt came when it had been written.
            count = len(there.times) - len(held.base.times)
            self._held = Held(there, there, held.cast, held.pending[count:], held.is_new and not count)
            self._flush()
            return
        self._tried = wanted
        if held.pending:
            if held.is_new:
                self._write(wanted.segments[-1].file, held.cast.shapes._asdict())
            times = np.array([time for time, _ in held.pending])
            frames = {name: np.stack([frame[name] for _, frame in held.pending]) for name in held.pending[0][1]}
            self._write(wanted.chunks[-1].file, {"time": times, **frames})
        write_manifest(self._folder, wanted)
        self._held = Held(wanted, wanted, held.cast, [])
        for left_out in held.disk.files - wanted.files:
            with suppress(OSError):
                (self._folder / left_out).unlink()

    def _write(self, name: str, arrays: Snapshot) -> None:
        with whole_file(self._folder / name) as file:
            np.savez(file, **arrays)  # type: ignore[arg-type]


def _refused(folder: Path, error: OSError, frames: int) -> OutputError:
    """Return the error that says what the disk said, and what is kept."""
    if isinstance(error, OutputError):
        return error
    kept = f"; its first {frames} frames are there" if frames else ""
    return OutputError(f"{folder} cannot be written: {error.strerror or error}{kept}")
