"""Reader of trajectories: each chunk is read when a frame of it is asked for."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from softbody.bodies.store import HasStore
from softbody.compiler.interrupts import assign_together
from softbody.errors import ParameterError, TrajectoryError
from softbody.model.shapes import Pose, shapes_of, unlabelled
from softbody.model.validation import check_whole, shown
from softbody.storage.atomic_file import path_of
from softbody.storage.npz import MOST_BYTES
from softbody.storage.snapshot import digest, named_arrays
from softbody.storage.snapshot_entries import Snapshot
from softbody.trajectory.entries import BODIES, read_chunk, read_shapes
from softbody.trajectory.manifest import NAME, read_manifest


class Frame(NamedTuple):
    """A moment of a trajectory: copies, which are yours. Velocities are None where they were not kept."""

    time: float  # [s]
    positions: np.ndarray  # (n, 3) [m] of the particles of all soft bodies
    box_positions: np.ndarray  # (m, 3) [m] of the centres of boxes
    box_orientations: np.ndarray  # (m, 4) unit quaternions (w, x, y, z), box frame to world
    velocities: np.ndarray | None = None  # (n, 3) [m/s]
    box_velocities: np.ndarray | None = None  # (m, 3) [m/s]
    box_angular_velocities: np.ndarray | None = None  # (m, 3) [rad/s], world frame


class Trajectory:
    """What a TrajectoryWriter kept: `trajectory[k]` is the Frame k, `trajectory.times` are those of all [s].

    `Trajectory.open(path)` opens one, also while it is being written: it has the frames that were there then.
    """

    def __init__(self, path: str | os.PathLike[str], most_bytes: int = MOST_BYTES) -> None:
        self._most_bytes = check_whole(most_bytes, "most_bytes", 1)
        self.path = path_of(path).absolute()  # chunks are read later, wherever the program is then
        self._manifest = read_manifest(self.path)
        self._shapes = read_shapes(self.path, self._most_bytes)
        if digest(named_arrays("bodies", self._shapes)) != self._manifest.bodies:
            raise TrajectoryError(
                f"{self.path / BODIES} is of other bodies than {NAME} says; copy the whole folder, or keep the "
                "trajectory anew"
            )
        self._labels = self._manifest.labels or unlabelled(self._shapes)
        if [len(each) for each in self._labels] != [len(each) for each in unlabelled(self._shapes)]:
            raise TrajectoryError(
                f"{self.path / NAME} has labels of other numbers of bodies than there are in {BODIES}; copy the whole "
                "folder, or keep the trajectory anew"
            )
        self.times = np.array(self._manifest.times, np.float64)
        self.times.flags.writeable = False
        ends = np.cumsum([0, *(len(chunk.times) for chunk in self._manifest.chunks)])
        self._ends = ends  # (c + 1,) first frame of each chunk
        self._chunk: tuple[int, Snapshot] | None = None  # the last one that was read

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
        particles = self._shapes.particle_count
        return (
            f"<Trajectory: {len(self)} frames{until}; {self.soft_count} soft bodies of {particles} particles, "
            f"{self.box_count} boxes>"
        )

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.times)

    def __iter__(self) -> Iterator[Frame]:
        """Yield each frame."""
        return (self[k] for k in range(len(self)))

    def __getitem__(self, k: int) -> Frame:
        """Return frame k, from the end if k < 0; raises IndexError, and TrajectoryError where its chunk is damaged."""
        k = self._number(k)
        at = int(np.searchsorted(self._ends, k, side="right")) - 1
        if self._chunk is None or self._chunk[0] != at:
            file, times = self._manifest.chunks[at]
            kept, velocities = np.array(times), self._manifest.velocities
            self._chunk = at, read_chunk(self.path / file, kept, self._shapes, velocities, self._most_bytes)
        rows = {name: array[k - self._ends[at]].copy() for name, array in self._chunk[1].items()}
        return Frame(
            float(self.times[k]),
            rows["particle_position"],
            rows["box_position"],
            rows["box_orientation"],
            rows.get("particle_velocity"),
            rows.get("box_velocity"),
            rows.get("box_angular_velocity"),
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

    @property
    def soft_count(self) -> int:
        """Soft bodies, as they were added to the world."""
        return self._shapes.soft_count

    @property
    def box_count(self) -> int:
        """Boxes, as they were added to the world."""
        return self._shapes.box_count

    @property
    def soft_names(self) -> tuple[str | None, ...]:
        """What soft bodies were called when the trajectory was begun, None for no name."""
        return tuple(name or None for name in self._labels.soft)

    @property
    def box_names(self) -> tuple[str | None, ...]:
        """What boxes were called when the trajectory was begun, None for no name."""
        return tuple(name or None for name in self._labels.box)

    @property
    def box_sizes(self) -> np.ndarray:
        """Full extents (m, 3) of boxes [m]."""
        return self._shapes.box_size.copy()

    def particles(self, body: int) -> slice:
        """Return the rows of a soft body's particles in `positions` and `velocities` of a frame."""
        return self._shapes.particles(check_whole(body, "body", 0, self.soft_count - 1))

    def triangles(self, body: int) -> np.ndarray:
        """Return the triangles (t, 3) of a soft body, as rows of its own particles."""
        return self._shapes.triangles(check_whole(body, "body", 0, self.soft_count - 1))

    def put_into(self, world: HasStore, k: int) -> None:
        """Put the bodies of a world where they were in frame k, to be seen, pictured or measured.

        The world must have the same bodies; its time becomes the frame's, and so do velocities, if they were kept: else
        they are zero. (To go on from a moment to the same bits, take `World.save`.)
        """
        frame = self[k]
        store = world.store
        with store.exclusive():
            if digest(named_arrays("bodies", shapes_of(store.model))) != self._manifest.bodies:
                raise ParameterError(f"{world!r} has other bodies than {self!r}; give a world of the same")
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
        `trajectory.export("meshes", "ply")`: a new folder of files 000000.ply, … of that kind, "ply", "obj", "glb",
        "usda" or "usdc", one a frame; see `World.export`. Raises OutputError, and MissingPackageError.
        """
        from softbody.export import export_film, export_sequence, looks_of

        numbers = range(0, len(self), check_whole(every, "every", 1))
        frames = (self[k] for k in numbers)
        poses = (Pose(frame.positions, frame.box_positions, frame.box_orientations) for frame in frames)
        looks = looks_of(self._labels)
        if kind is None:
            export_film(path, self._shapes, looks, self.times[list(numbers)], poses)
        else:
            export_sequence(path, kind, self._shapes, looks, poses)
