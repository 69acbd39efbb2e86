"""What the claims are tried on: random poses, boxes and meshes, from a generator that the check owns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

import softbody
from softbody import Mesh, World
from softbody.collision.boxes.sat_boxes import PlacedBox, PlacedBoxes, box_box_separation

# A roof of eight triangles, of 0.5 m height and 2 m length, whose ridge goes from corner 2 to corner 5.
ROOF = np.array([[-1, -0.3, 0], [-1, 0.3, 0], [-1, 0, 0.5], [1, -0.3, 0], [1, 0.3, 0], [1, 0, 0.5]], float)
ROOF_FACES = np.array([[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]])


def random_orientations(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return `count` unit quaternions, uniform over all rotations: (count, 4)."""
    q = rng.standard_normal((count, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def rotation_matrix(q: np.ndarray) -> np.ndarray:
    """Return the matrix (3, 3) of a unit quaternion (w, x, y, z)."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def edge_lengths(positions: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the lengths (e,) of `edges` (e, 2) between `positions` (n, 3)."""
    return np.linalg.norm(positions[edges[:, 1]] - positions[edges[:, 0]], axis=1)


def corners_of(size: np.ndarray) -> np.ndarray:
    """Return the corners (8, 3) [m] of a box about the origin."""
    signs = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    return signs * size


# Of the corners of `corners_of`, which are numbered 4 x + 2 y + z; outward counter-clockwise.
BOX_TRIANGLES = np.array(
    [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4)]
    + [(1, 5, 7), (1, 7, 3)]
)


def depths_of_boxes(world: World, unit: float = 1.0) -> tuple[float, float]:
    """Return how deep boxes of a World are at most inside each other, by FCL, and below its ground, in units [m].

    FCL's contacts are up to 1.05 times as deep as boxes are. It counts in these units: it knows no tiny boxes.
    """
    from references import fcl

    size, place, turn = world.model.box_size / unit, world.state.box_position / unit, world.state.box_orientation
    corners = [x + corners_of(each) @ rotation_matrix(q).T for each, x, q in zip(size, place, turn)]
    below = world.model.ground_height / unit - min(float(rows[:, 2].min()) for rows in corners)
    i, j = np.triu_indices(len(size), 1)
    reach = 0.5 * np.linalg.norm(size, axis=1)
    near = np.linalg.norm(place[i] - place[j], axis=1) < reach[i] + reach[j]
    i, j = i[near], j[near]
    # (Of boxes that just touch, FCL's signed distance ends the process now and then; its contacts do not.)
    depth, _ = fcl.box_contacts(size[i], place[i], turn[i], size[j], place[j], turn[j])
    return float(depth.max(initial=0.0)), float(np.maximum(0.0, below))


def rotated(mesh: Mesh, rng: np.random.Generator) -> Mesh:
    """Return the mesh in a random orientation about the origin."""
    matrix = rotation_matrix(random_orientations(rng, 1)[0])
    return Mesh(mesh.vertices @ matrix.T, mesh.triangles)


def dented_sphere(subdivisions: int = 3, depth: float = 0.7) -> Mesh:
    """Return a unit sphere with a deep dent in its top: not convex, and the +z ray leaves it and comes back."""
    ball = softbody.icosphere(subdivisions)
    angle = np.arccos(np.clip(ball.vertices[:, 2], -1.0, 1.0))
    radius = 1.0 - depth * np.exp(-((angle / 0.5) ** 2))
    return Mesh(ball.vertices * radius[:, None], ball.triangles)


def lumpy_sphere(rng: np.random.Generator, subdivisions: int = 3, height: float = 0.3) -> Mesh:
    """Return a random closed mesh: a sphere with smooth random lumps, its vertices at no special places."""
    ball = softbody.icosphere(subdivisions)
    waves = rng.normal(size=(6, 3)) * 2.0
    phases = rng.uniform(0.0, 2.0 * np.pi, 6)
    lumps = np.sin(ball.vertices @ waves.T + phases).sum(axis=1) / np.sqrt(6.0)
    return Mesh(ball.vertices * (1.0 + height * np.tanh(lumps))[:, None], ball.triangles)


def knotted_tube(rng: np.random.Generator, around: int = 96, across: int = 8, radius: float = 0.25) -> Mesh:
    """Return a tube along a trefoil knot, in a random orientation: a ray meets it many times."""
    t = 2.0 * np.pi * np.arange(around) / around
    line = np.stack([np.sin(t) + 2.0 * np.sin(2.0 * t), np.cos(t) - 2.0 * np.cos(2.0 * t), -np.sin(3.0 * t)], axis=1)
    along = np.roll(line, -1, axis=0) - np.roll(line, 1, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = np.cross(along, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, along)
    grid = softbody.torus(1.0, 0.4, around, across).triangles
    angle = 2.0 * np.pi * np.arange(across) / across
    ring = np.cos(angle)[None, :, None] * side[:, None] + np.sin(angle)[None, :, None] * up[:, None]
    vertices = (line[:, None] + radius * ring).reshape(-1, 3) / 3.0
    return rotated(Mesh(vertices, grid), rng)


def scanned_sphere(rng: np.random.Generator, subdivisions: int = 3, noise: float = 0.02) -> Mesh:
    """Return a lumpy sphere whose vertices are noisy and on a grid of millimetres, as those of a scan are."""
    mesh = lumpy_sphere(rng, subdivisions)
    return Mesh(np.round(mesh.vertices + noise * rng.normal(size=mesh.vertices.shape), 3), mesh.triangles)


def uneven_sphere(rng: np.random.Generator) -> Mesh:
    """Return a random closed mesh whose vertices have 3 to some 20 neighbours, as those of scans and cuts have."""
    from scipy.spatial import ConvexHull

    around = int(rng.integers(12, 16))
    angle = 2.0 * np.pi * (np.arange(around) + rng.uniform(-0.2, 0.2, around)) / around
    ring = np.stack([0.4 * np.cos(angle), 0.4 * np.sin(angle), np.full(around, 0.9)], axis=1)
    others = rng.normal(size=(int(rng.integers(30, 250)), 3))
    others = others[others[:, 2] < 0.8 * np.linalg.norm(others, axis=1)]
    points = np.concatenate([[[0.0, 0.0, 1.0]], ring, others])
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    faces = ConvexHull(points).simplices
    normals = np.cross(points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])
    inward = (normals * points[faces[:, 0]]).sum(axis=1) < 0.0
    faces[inward] = faces[inward, ::-1]
    # A vertex in the middle of every third triangle: it has three neighbours, and each of these has one more.
    split = rng.random(len(faces)) < 0.3
    middles = len(points) + np.arange(split.sum())
    fans = [np.stack([faces[split, k], faces[split, (k + 1) % 3], middles], axis=1) for k in range(3)]
    points = np.concatenate([points, points[faces[split]].mean(axis=1) * 1.02])
    return Mesh(rng.uniform(0.3, 2.0) * points * rng.uniform(0.7, 1.3, 3), np.concatenate([faces[~split], *fans]))


def random_mesh(kind: str, rng: np.random.Generator) -> Mesh:
    """Return a mesh of one of MESH_KINDS, of random proportions and orientation, about the origin."""
    if kind == "sphere":
        mesh = softbody.icosphere(3, radius=rng.uniform(0.2, 3.0))
    elif kind == "torus":
        mesh = softbody.torus(1.0, rng.uniform(0.2, 0.8), int(rng.integers(12, 48)), int(rng.integers(6, 24)))
    elif kind == "box":
        mesh = softbody.box(rng.uniform(0.3, 2.0, 3), int(rng.integers(1, 5)))
    elif kind == "dented sphere":
        mesh = dented_sphere(3, rng.uniform(0.3, 0.8))
    elif kind == "uneven sphere":
        mesh = uneven_sphere(rng)
    else:
        mesh = lumpy_sphere(rng)
    return rotated(mesh, rng)


MESH_KINDS = ("sphere", "torus", "box", "dented sphere", "lumpy sphere", "uneven sphere")


def points_around(mesh: Mesh, count: int, rng: np.random.Generator) -> np.ndarray:
    """Return points (count, 3), uniform in the mesh's bounding box grown by a tenth."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    margin = 0.1 * (high - low)
    return rng.uniform(low - margin, high + margin, (count, 3))


def stacked_points(mesh: Mesh, rng: np.random.Generator, copies: int = 8) -> np.ndarray:
    """Return copies of the mesh's own vertices, shifted along z: every vertical ray goes through a vertex."""
    height = np.ptp(mesh.vertices[:, 2])
    shifts = rng.uniform(-0.9, 0.9, copies) * height
    return np.concatenate([mesh.vertices + np.array([0.0, 0.0, shift]) for shift in shifts])


def edge_points(mesh: Mesh, rng: np.random.Generator, count: int) -> np.ndarray:
    """Return points (count, 3) exactly above or below middles of edges, as far as rounding allows."""
    edges = mesh.edges[rng.integers(0, len(mesh.edges), count)]
    middles = 0.5 * (mesh.vertices[edges[:, 0]] + mesh.vertices[edges[:, 1]])
    middles[:, 2] += rng.uniform(-1.0, 1.0, count) * np.ptp(mesh.vertices[:, 2])
    return middles


def transformed(
    mesh: Mesh, points: np.ndarray, rng: np.random.Generator
) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return vertices, triangles and points moved together, or renumbered, so that answers about them stay."""
    matrix = rotation_matrix(random_orientations(rng, 1)[0])
    offset = 1e6 * rng.uniform(-1.0, 1.0, 3)
    number = rng.permutation(len(mesh.vertices))
    shuffled = np.empty_like(mesh.vertices)
    shuffled[number] = mesh.vertices
    turned = [np.roll(number[t], turn) for t, turn in zip(mesh.triangles, rng.integers(0, 3, len(mesh.triangles)))]
    renumbered = np.array(turned)[rng.permutation(len(turned))]
    return {
        "turned": (mesh.vertices @ matrix.T, mesh.triangles, points @ matrix.T),
        "moved 1 000 km": (mesh.vertices + offset, mesh.triangles, points + offset),
        "scaled by 1e6": (1e6 * mesh.vertices, mesh.triangles, 1e6 * points),
        "scaled by 1e-6": (1e-6 * mesh.vertices, mesh.triangles, 1e-6 * points),
        "renumbered": (shuffled, renumbered, points),
    }


def joined(parts: Sequence[Mapping[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Return inputs of cases, part after part, as one: name → rows."""
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


class BoxPairs(NamedTuple):
    """Pairs of boxes, row by row: sizes and positions (m, 3) [m], orientations (m, 4), of a and of b."""

    size_a: np.ndarray
    position_a: np.ndarray
    orientation_a: np.ndarray
    size_b: np.ndarray
    position_b: np.ndarray
    orientation_b: np.ndarray

    def select(self, rows: np.ndarray) -> BoxPairs:
        """Return the pairs of some rows."""
        return BoxPairs(*(array[rows] for array in self))

    def swapped(self) -> BoxPairs:
        """Return the same pairs with a and b exchanged."""
        return BoxPairs(*self[3:], *self[:3])

    @property
    def a(self) -> PlacedBoxes:
        """The first box of each pair, as the core wants them."""
        return PlacedBoxes(*self[:3])

    @property
    def b(self) -> PlacedBoxes:
        """The second box of each pair."""
        return PlacedBoxes(*self[3:])

    @property
    def extent(self) -> np.ndarray:
        """The longest side of each pair (m,) [m]."""
        return np.maximum(self.size_a.max(axis=1), self.size_b.max(axis=1))


def random_box_pairs(rng: np.random.Generator, count: int, low: float = 0.4, high: float = 2.0) -> BoxPairs:
    """Return pairs of boxes in random poses, with sides of `low` to `high` [m]; some 60 % of them overlap."""
    size_a, size_b = rng.uniform(low, high, (2, count, 3))
    orientation_a, orientation_b = random_orientations(rng, count), random_orientations(rng, count)
    position_a = rng.uniform(-1.0, 1.0, (count, 3))
    # Centres 0 to 1.2 of the sum of the half-diagonals apart.
    reach = 0.5 * (np.linalg.norm(size_a, axis=1) + np.linalg.norm(size_b, axis=1))
    direction = rng.standard_normal((count, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    position_b = position_a + (rng.uniform(0.0, 1.2, count) * reach)[:, None] * direction
    return BoxPairs(size_a, position_a, orientation_a, size_b, position_b, orientation_b)


def box_separations(pairs: BoxPairs, paper_axes: bool = False) -> list[tuple[float, np.ndarray, int]]:
    """Return what the core's separating-axis test says of each pair: separation [m], normal, axis."""
    answers = []
    for row in zip(*pairs):
        parts = [tuple(part) for part in row]
        separation, normal, axis = box_box_separation(PlacedBox(*parts[:3]), PlacedBox(*parts[3:]), paper_axes)
        answers.append((separation, np.array(normal), axis))
    return answers


def gap_along(pairs: BoxPairs, normals: np.ndarray) -> np.ndarray:
    """Return how far apart (m,) [m] the corners of each pair are along a normal from b to a; below 0: they overlap."""
    gaps = []
    for size_a, position_a, q_a, size_b, position_b, q_b, normal in zip(*pairs, normals):
        of_a = (position_a + corners_of(size_a) @ rotation_matrix(q_a).T) @ normal
        of_b = (position_b + corners_of(size_b) @ rotation_matrix(q_b).T) @ normal
        gaps.append(of_a.min() - of_b.max())
    return np.array(gaps)


FOLLOWS = {"SoftBody": {"velocity", "angular_velocity", "pressure"}}  # from velocities, places and gas


def independent(kind: type) -> set[str]:
    """Return those that a user may assign which no other assignment changes."""
    return settable(kind) - FOLLOWS.get(kind.__name__, set())


def settable(kind: type) -> set[str]:
    """Return the attributes of a kind of handle, or of a world, that a user may assign."""
    told = {name: getattr(kind, name) for name in dir(kind) if not name.startswith("_")}
    slots = {name for each in kind.__mro__ for name in getattr(each, "__slots__", ())}
    return {
        name
        for name, each in told.items()
        if hasattr(type(each), "__set__") and getattr(each, "fset", True) and name not in slots
    }
