"""Reader of trajectories: each chunk is read when a frame of it is asked for."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from softbody.bodies.store import HasStore
from softbody.compiler.interrupts import assign_together
from softbody.errors import ParameterError
from softbody.model.shapes import Cast, Pose, shapes_of
from softbody.model.validation import check_whole, shown
from softbody.storage.atomic_file import path_of
from softbody.storage.npz import MOST_BYTES
from softbody.storage.snapshot_entries import Snapshot
from softbody.trajectory.bodies import Bodies, digest_of, read_cast
from softbody.trajectory.entries import read_chunk
from softbody.trajectory.manifest import read_manifest


class Frame(NamedTuple):
    """A moment of a trajectory: copies, which are yours. Velocities are None where they were not kept."""

    time: float  # [s]
    positions: np.ndarray  # (n, 3) [m] of the particles of all soft bodies
    box_positions: np.ndarray  # (m, 3) [m] of the centres of boxes
    box_orientations: np.ndarray  # (m, 4) unit quaternions (w, x, y, z), box frame to world
    velocities: np.ndarray | None  # (n, 3) [m/s]
    box_velocities: np.ndarray | None  # (m, 3) [m/s]
    box_angular_velocities: np.ndarray | None  # (m, 3) [rad/s], world frame
    bodies: Bodies  # which there are


class Trajectory:
    """What a TrajectoryWriter kept: `trajectory[k]` is the Frame k, `trajectory.times` are those of all [s].

    `Trajectory.open(path)` opens one, also while it is being written: it has the frames that were there then.

    Bodies may come and go, or change their meshes: `trajectory[k].bodies` are those of frame k. Of a trajectory whose
    bodies never change, `trajectory.soft_count`, `.triangles(body)` and so on say the same; of another they raise
    ParameterError. `segments` says which frames have the same bodies.
    """

    def __init__(self, path: str | os.PathLike[str], most_bytes: int = MOST_BYTES) -> None:
        self._most_bytes = check_whole(most_bytes, "most_bytes", 1)
        self.path = path_of(path).absolute()  # chunks are read later, wherever the program is then
        self._manifest = read_manifest(self.path)
        self._cast = 0, read_cast(self.path, self._manifest.segments[0], self._most_bytes)  # the last that was read
        self.times = np.array(self._manifest.times, np.float64)
        self.times.flags.writeable = False
        ends = np.cumsum([0, *(len(chunk.times) for chunk in self._manifest.chunks)])
        self._ends = ends  # (c + 1,) first frame of each chunk
        self._chunk: tuple[int, Snapshot] | None = None  # the last one that was read
        self._stops = np.cumsum([segment.frames for segment in self._manifest.segments])  # (s,) after each segment

    @classmethod
    def open(cls, path: str | os.PathLike[str], most_bytes: int = MOST_BYTES) -> Trajectory:
        """Return the trajectory in a folder, which need not be trusted: chunks are checked when they are read.

        Raises TrajectoryError for a folder that holds none, for damage of any kind, another version, and files that
        are, or unpack to, more than `most_bytes` each (1 GiB), before it takes that memory.
        """
        return cls(path, most_bytes)

    def __repr__(self) -> str:
        """Say what was kept."""
        until = f" until {self.times[-1]:.6g} s" if len(self) else ""
        changes = len(self._stops) - 1
        return (
            f"<Trajectory: {len(self)} frames{until}; {f'bodies change {changes} times' if changes else self._all()}>"
        )

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.times)

    def __iter__(self) -> Iterator[Frame]:
        """Yield each frame."""
        return (self[k] for k in range(len(self)))

    def __getitem__(self, k: int) -> Frame:
        """Return frame k, from the end if k < 0; raises IndexError, and TrajectoryError where its files are damaged."""
        k = self._number(k)
        cast = self._cast_of(self._segment_of(k))
        at = int(np.searchsorted(self._ends, k, side="right")) - 1
        if self._chunk is None or self._chunk[0] != at:
            file, times = self._manifest.chunks[at]
            kept, velocities = np.array(times), self._manifest.velocities
            self._chunk = at, read_chunk(self.path / file, kept, cast.shapes, velocities, self._most_bytes)
        rows = {name: array[k - self._ends[at]].copy() for name, array in self._chunk[1].items()}
        return Frame(
            float(self.times[k]),
            rows["particle_position"],
            rows["box_position"],
            rows["box_orientation"],
            rows.get("particle_velocity"),
            rows.get("box_velocity"),
            rows.get("box_angular_velocity"),
            Bodies(cast),
        )

    def _number(self, k: int) -> int:
        try:
            number = operator.index(k)
        except TypeError as error:
            raise ParameterError(
                f"frame {shown(k)} is no whole number; give one, as of range(len(trajectory))"
            ) from error
        if not -len(self) <= number < len(self):
            raise IndexError(f"frame {number} is not in this trajectory: there are {len(self)}")
        return number % len(self)

    def _segment_of(self, k: int) -> int:
        """Return in which segment frame k is."""
        return int(np.searchsorted(self._stops, k, side="right"))

    def _cast_of(self, number: int) -> Cast:
        """Return the bodies of a segment."""
        if self._cast[0] != number:
            self._cast = number, read_cast(self.path, self._manifest.segments[number], self._most_bytes)
        return self._cast[1]

    @property
    def segments(self) -> tuple[range, ...]:
        """Frames that have the same bodies, one after the other: a single range where bodies never change."""
        return tuple(map(range, [0, *self._stops[:-1].tolist()], self._stops.tolist()))

    def _all(self) -> Bodies:
        """Return the bodies of all frames."""
        if len(self._stops) > 1:
            raise ParameterError(f"its bodies change at frame {self._stops[0]}: ask a frame, trajectory[k].bodies")
        return Bodies(self._cast_of(0))

    @property
    def soft_count(self) -> int:
        """Soft bodies."""
        return self._all().soft_count

    @property
    def box_count(self) -> int:
        """Boxes."""
        return self._all().box_count

    @property
    def soft_names(self) -> tuple[str | None, ...]:
        """What soft bodies were called when the trajectory was begun, None for no name."""
        return self._all().soft_names

    @property
    def box_names(self) -> tuple[str | None, ...]:
        """What boxes were called when the trajectory was begun, None for no name."""
        return self._all().box_names

    @property
    def box_sizes(self) -> np.ndarray:
        """Full extents (m, 3) of boxes [m]."""
        return self._all().box_sizes

    def particles(self, body: int) -> slice:
        """Return the rows of a soft body's particles in `positions` and `velocities` of a frame."""
        return self._all().particles(body)

    def triangles(self, body: int) -> np.ndarray:
        """Return the triangles (t, 3) of a soft body, as rows of its own particles."""
        return self._all().triangles(body)

    def put_into(self, world: HasStore, k: int) -> None:
        """Put the bodies of a world where they were in frame k, to be seen, pictured or measured.

        The world must have the bodies of that frame; its time becomes the frame's, and so do velocities, if they were
        kept: else they are zero. (To go on from a moment to the same bits, take `World.save`.)
        """
        k = self._number(k)
        frame, sha256 = self[k], self._manifest.segments[self._segment_of(k)].sha256
        store = world.store
        with store.exclusive():
            if digest_of(shapes_of(store.model)) != sha256:
                raise ParameterError(
                    f"{world!r} has other bodies than frame {k}, which has {frame.bodies}; give a world of those"
                )
            state = store.state
            assign_together(
                (state.particle_position, frame.positions),
                (state.box_position, frame.box_positions),
                (state.box_orientation, frame.box_orientations),
                (state.particle_velocity, 0.0 if frame.velocities is None else frame.velocities),
                (state.box_velocity, 0.0 if frame.box_velocities is None else frame.box_velocities),
                (
                    state.box_angular_velocity,
                    0.0 if frame.box_angular_velocities is None else frame.box_angular_velocities,
                ),
                (store.clock.time, frame.time),
            )

    def export(self, path: str | os.PathLike[str], kind: str | None = None, *, every: int = 1) -> None:
        """Write all frames, or `every` so many, for other programs; needs trimesh: softbody[files], or softbody[usd].

        `trajectory.export("fall.glb")`, or "fall.usdc": one file, in which bodies move; a GLB has 1000 frames at most.
        In a USD, frames that come a whole number a second, each to a millionth of a frame, have whole numbers as times.
        Bodies that come and go are shown in their frames only: by a scale of 0 in a GLB, by their visibility in a USD.
        One whose mesh changes is another from then on, called "ball from frame 12".
        `trajectory.export("meshes", "ply")`: a new folder of files 000000.ply, … of that kind, "ply", "obj", "glb",
        "usda" or "usdc", one a frame; see `World.export`. Raises OutputError, and MissingPackageError.
        """
        from softbody.export import export_film, export_sequence

        numbers = range(0, len(self), check_whole(every, "every", 1))
        segment_of = [self._segment_of(k) for k in numbers]
        if kind is None:
            casts = {number: self._cast_of(number) for number in dict.fromkeys(segment_of)}
            of_frames = [casts[number] for number in segment_of]
            export_film(path, of_frames, self.times[list(numbers)], map(self._pose, numbers))
        else:
            for k, number in zip(numbers, segment_of):
                if self._cast_of(number).is_empty:
                    raise ParameterError(
                        f"frame {k} has no bodies to export; leave it out, with every=…, or export one film, as a .usdc"
                    )
            moments = ((self._cast_of(number), self._pose(k)) for k, number in zip(numbers, segment_of))
            export_sequence(path, kind, moments)

    def _pose(self, k: int) -> Pose:
        frame = self[k]
        return Pose(frame.positions, frame.box_positions, frame.box_orientations)
