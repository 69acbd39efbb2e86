"""Bodies of a trajectory's frames, and the files that say which these are."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from softbody.errors import TrajectoryError
from softbody.model.shapes import Cast, Shapes, unlabelled
from softbody.model.validation import check_whole
from softbody.storage.snapshot import digest, named_arrays
from softbody.trajectory.entries import read_shapes
from softbody.trajectory.manifest import NAME, Segment


class Bodies:
    """Which bodies a frame has: how many, of what meshes and sizes, and what they are called."""

    def __init__(self, cast: Cast) -> None:
        self._shapes, self._labels = cast

    def __repr__(self) -> str:
        """Say how many there are."""
        return f"<{self}>"

    def __str__(self) -> str:
        return f"{self.soft_count} soft bodies of {self._shapes.particle_count} particles, {self.box_count} boxes"

    @property
    def soft_count(self) -> int:
        """Soft bodies."""
        return self._shapes.soft_count

    @property
    def box_count(self) -> int:
        """Boxes."""
        return self._shapes.box_count

    @property
    def soft_names(self) -> tuple[str | None, ...]:
        """What soft bodies were called when the first frame of these bodies was kept, None for no name."""
        return tuple(name or None for name in self._labels.soft)

    @property
    def box_names(self) -> tuple[str | None, ...]:
        """What boxes were called when the first frame of these bodies was kept, None for no name."""
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


def digest_of(shapes: Shapes) -> str:
    """Return what tells bodies from others in a manifest."""
    return digest(named_arrays("bodies", shapes))


def read_cast(folder: Path, segment: Segment, most_bytes: int) -> Cast:
    """Return the bodies of a segment; raises TrajectoryError."""
    shapes = read_shapes(folder / segment.file, most_bytes)
    if digest_of(shapes) != segment.sha256:
        raise TrajectoryError(
            f"{folder / segment.file} is of other bodies than {NAME} says; copy the whole folder, or keep the "
            "trajectory anew"
        )
    labels = segment.labels or unlabelled(shapes)
    if [len(each) for each in labels] != [len(each) for each in unlabelled(shapes)]:
        raise TrajectoryError(
            f"{folder / NAME} has labels of other numbers of bodies than there are in {segment.file}; copy the whole "
            "folder, or keep the trajectory anew"
        )
    return Cast(shapes, labels)
