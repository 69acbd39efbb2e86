"""The paper's rules for a soft body that meets another, or a box: §4.2 and §4.3 in plain NumPy.

What is inside what, and which triangle is closest, are libigl's answers. All that follows is the paper's: each point
that is inside and the face closest to it move apart by half the depth each, then one impulse along the way out turns
the speed at which they come into e times that; and the next point finds what the one before has left. Points are taken
in the order of their numbers: those of the second body that are in the first, then those of the first in the second; of
a body and a box first particles in the box, then corners in the body.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from references.analytic import box_inertia, rotation_matrix
from references.igl import closest_points, points_in_mesh


@dataclass
class Skin:
    """A soft body: particles and the triangles between them."""

    position: np.ndarray  # (n, 3) [m]
    velocity: np.ndarray  # (n, 3) [m/s]
    mass: np.ndarray  # (n,) [kg]
    triangles: np.ndarray  # (t, 3)


@dataclass
class Block:
    """A box; a static one has the mass np.inf."""

    size: np.ndarray  # (3,) [m]
    mass: float  # [kg]
    position: np.ndarray  # (3,) [m]
    orientation: np.ndarray  # (4,)
    velocity: np.ndarray  # (3,) [m/s]
    angular_velocity: np.ndarray  # (3,) [rad/s]


@dataclass
class Point:
    """A point of a skin: particles, and their weights, which sum to 1."""

    skin: Skin
    rows: np.ndarray
    weights: np.ndarray

    def place(self) -> np.ndarray:
        """Return where it is [m]."""
        return self.weights @ self.skin.position[self.rows]

    def velocity(self, place: np.ndarray) -> np.ndarray:
        """Return how fast it is [m/s]."""
        return self.weights @ self.skin.velocity[self.rows]

    def yielding(self, place: np.ndarray, direction: np.ndarray) -> float:
        """Return its inverse effective mass [1/kg]."""
        return float((self.weights**2 / self.skin.mass[self.rows]).sum())

    def move(self, shift: np.ndarray) -> None:
        """Move it, all its particles alike, by `shift` [m]."""
        self.skin.position[self.rows] += shift

    def push(self, place: np.ndarray, impulse: np.ndarray) -> None:
        """Share an impulse [N s] among its particles."""
        self.skin.velocity[self.rows] += np.outer(self.weights / self.skin.mass[self.rows], impulse)


@dataclass
class OnBlock:
    """A box, as one side of a contact."""

    block: Block

    def place(self) -> np.ndarray:
        """Return where its centre is [m]."""
        return self.block.position

    def velocity(self, place: np.ndarray) -> np.ndarray:
        """Return how fast [m/s] it is at a place."""
        return self.block.velocity + np.cross(self.block.angular_velocity, place - self.block.position)

    def yielding(self, place: np.ndarray, direction: np.ndarray) -> float:
        """Return its inverse effective mass [1/kg] at a place, along a unit vector."""
        if np.isinf(self.block.mass):
            return 0.0
        arm = place - self.block.position
        return float(1.0 / self.block.mass + direction @ np.cross(self._spin(np.cross(arm, direction)), arm))

    def move(self, shift: np.ndarray) -> None:
        """Move it by `shift` [m]."""
        self.block.position = self.block.position + shift

    def push(self, place: np.ndarray, impulse: np.ndarray) -> None:
        """Apply an impulse [N s] at a place."""
        if np.isfinite(self.block.mass):
            self.block.velocity = self.block.velocity + impulse / self.block.mass
            moment = np.cross(place - self.block.position, impulse)
            self.block.angular_velocity = self.block.angular_velocity + self._spin(moment)

    def _spin(self, moment: np.ndarray) -> np.ndarray:
        turn = rotation_matrix(self.block.orientation)
        return turn @ ((turn.T @ moment) / box_inertia(self.block.size, self.block.mass))


@dataclass
class Meeting:
    """What was found: two sides, and how far a is to come above b along the normal."""

    a: Point
    b: Point | OnBlock
    normal: np.ndarray  # (3,) unit, from b to a
    goal: float  # [m]

    def depth(self) -> float:
        """Return how far a is below that now [m]."""
        return self.goal - float(self.normal @ (self.a.place() - self.b.place()))


def collide(one: Skin, other: Skin | Block, restitution: float) -> list[float]:
    """Change positions and velocities as the paper's contacts do; return how deep each was when it was found [m]."""
    if isinstance(other, Skin):
        meetings = _particles_inside(other, one) + _particles_inside(one, other)
    else:
        meetings = _particles_in_box(one, other) + _corners_inside(other, one)
    depths = [meeting.depth() for meeting in meetings]
    for meeting in meetings:
        _resolve(meeting, restitution)
    return depths


def _particles_inside(probe: Skin, solid: Skin) -> list[Meeting]:
    found = []
    for p, (triangle, weights, normal, depth) in _ways_out(probe.position, solid):
        a, b = Point(probe, np.array([p]), np.ones(1)), Point(solid, triangle, weights)
        found.append(Meeting(a, b, normal, depth + float(normal @ (a.place() - b.place()))))
    return found


def _corners_inside(block: Block, skin: Skin) -> list[Meeting]:
    corners = np.array(list(product((-0.5, 0.5), repeat=3)))[:, ::-1] * block.size  # the side along x changes first
    corners = block.position + corners @ rotation_matrix(block.orientation).T
    found = []
    for _, (triangle, weights, out, depth) in _ways_out(corners, skin):
        a, b = Point(skin, triangle, weights), OnBlock(block)
        found.append(Meeting(a, b, -out, depth - float(out @ (a.place() - b.place()))))
    return found


def _ways_out(points: np.ndarray, skin: Skin) -> list[tuple[int, tuple[np.ndarray, np.ndarray, np.ndarray, float]]]:
    """Return of each of `points` that is inside: its number; triangle, weights, unit vector out and depth [m]."""
    rows = np.flatnonzero(points_in_mesh(points, skin.position, skin.triangles))
    ways: list[tuple[int, tuple[np.ndarray, np.ndarray, np.ndarray, float]]] = []
    if not len(rows):
        return ways
    for row, depth, face, end in zip(rows, *closest_points(points[rows], skin.position, skin.triangles), strict=True):
        triangle = skin.triangles[face]
        arms = skin.position[triangle] - end
        parts = np.cross(np.roll(arms, -1, axis=0), np.roll(arms, -2, axis=0))  # opposite to each corner [2 m²]
        whole = parts.sum(axis=0)
        weights = parts @ whole / (whole @ whole)
        ways.append((int(row), (triangle, weights, (end - points[row]) / depth, float(depth))))
    return ways


def _particles_in_box(skin: Skin, block: Block) -> list[Meeting]:
    turn = rotation_matrix(block.orientation)
    local = (skin.position - block.position) @ turn
    behind = 0.5 * block.size - np.abs(local)  # each face pair
    found = []
    for p in np.flatnonzero((behind > 0.0).all(axis=1)):
        axis = int(behind[p].argmin())
        normal = turn[:, axis] * np.sign(local[p, axis])
        a, b = Point(skin, np.array([p]), np.ones(1)), OnBlock(block)
        found.append(Meeting(a, b, normal, float(behind[p, axis] + normal @ (a.place() - b.place()))))
    return found


def _resolve(meeting: Meeting, restitution: float) -> None:
    a, b, normal = meeting.a, meeting.b, meeting.normal
    depth = meeting.depth()
    if depth <= 0.0:
        return
    fixed = isinstance(b, OnBlock) and np.isinf(b.block.mass)
    a.move((1.0 if fixed else 0.5) * depth * normal)
    if not fixed:
        b.move(-0.5 * depth * normal)
    place = a.place()
    speed = float(normal @ (a.velocity(place) - b.velocity(place)))
    if speed < 0.0:
        j = -(1.0 + restitution) * speed / (a.yielding(place, normal) + b.yielding(place, normal))
        a.push(place, j * normal)
        b.push(place, -j * normal)
