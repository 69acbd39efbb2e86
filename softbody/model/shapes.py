"""Shapes and poses of bodies, for whoever keeps or draws them: triangles of particles, and boxes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.model.arrays import Model, State


class Shapes(NamedTuple):
    """What stays of bodies while they move; the fields are those of a Model."""

    soft_particle_start: np.ndarray  # (b + 1,)
    soft_triangle_start: np.ndarray  # (b + 1,)
    triangle_particles: np.ndarray  # (t, 3)
    box_size: np.ndarray  # (m, 3) full extent [m]

    @property
    def soft_count(self) -> int:
        """Soft bodies, b."""
        return len(self.soft_particle_start) - 1

    @property
    def box_count(self) -> int:
        """Boxes, m."""
        return len(self.box_size)

    @property
    def particle_count(self) -> int:
        """Particles of all soft bodies, n."""
        return int(self.soft_particle_start[-1])

    def particles(self, body: int) -> slice:
        """Return the rows of a soft body's particles."""
        return slice(*self.soft_particle_start[body : body + 2].tolist())

    def triangles(self, body: int) -> np.ndarray:
        """Return a soft body's triangles (t, 3), as rows of its own particles."""
        rows = slice(*self.soft_triangle_start[body : body + 2].tolist())
        return self.triangle_particles[rows] - self.soft_particle_start[body]


class Labels(NamedTuple):
    """What bodies are called, "" for no name, and which boxes cannot move."""

    soft: tuple[str, ...]
    box: tuple[str, ...]
    held: tuple[bool, ...]  # of boxes


class Cast(NamedTuple):
    """Bodies, but where they are."""

    shapes: Shapes
    labels: Labels

    @property
    def is_empty(self) -> bool:
        """Whether there are none."""
        return not self.shapes.soft_count + self.shapes.box_count

    def is_same(self, other: Cast) -> bool:
        """Tell whether these are as many bodies, of the same meshes, sizes and labels."""
        return self.labels == other.labels and all(np.array_equal(a, b) for a, b in zip(self.shapes, other.shapes))


class Pose(NamedTuple):
    """Where bodies are; the fields are those of a State."""

    particle_position: np.ndarray  # (n, 3) [m]
    box_position: np.ndarray  # (m, 3) [m]
    box_orientation: np.ndarray  # (m, 4) unit quaternion (w, x, y, z), box frame to world


def shapes_of(model: Model) -> Shapes:
    """Return the shapes of a world's bodies, which share its memory."""
    return Shapes(model.soft_particle_start, model.soft_triangle_start, model.triangle_particles, model.box_size)


def unlabelled(shapes: Shapes) -> Labels:
    """Return the labels of bodies of which nothing is known."""
    return Labels(("",) * shapes.soft_count, ("",) * shapes.box_count, (False,) * shapes.box_count)


def pose_of(state: State) -> Pose:
    """Return where a world's bodies are; it shares memory with the world."""
    return Pose(state.particle_position, state.box_position, state.box_orientation)
