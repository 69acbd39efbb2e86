"""Closed triangle meshes: shapes to start from, and the check that every mesh passes before it is used."""

from __future__ import annotations

import os
from dataclasses import dataclass
from math import pi, sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from softbody.errors import MeshError, ParameterError
from softbody.geometry.edges import edges_of_sides
from softbody.geometry.polyhedron import signed_volume
from softbody.mesh.diagnostics import Finding, findings
from softbody.mesh.files import read_triangles, triangles_of
from softbody.mesh.shells import enclosing, shells_of, volume_of_rounding
from softbody.mesh.weld import first_at_place, merged
from softbody.model.validation import NO_NUMBERS, check_range, check_whole, check_yes_or_no, doubles, shown, vector


@dataclass(frozen=True, eq=False)
class Mesh:
    """A closed triangle mesh, checked: `vertices` (n, 3) [m], `triangles` (t, 3), outward counter-clockwise.

    Raises MeshError, naming the element and the cure, unless every number is finite, every index is in range,
    every vertex is used, every edge is met by two triangles that run along it in opposite directions, no edge
    or triangle is degenerate, the enclosed volume is positive, and what is inside out is a cavity. `check` finds what
    is only doubtful. Both arrays are copies, and read-only: what was
    checked stays so (a library that insists on writable arrays takes `mesh.vertices.copy()`).
    """

    vertices: np.ndarray
    triangles: np.ndarray

    def __post_init__(self) -> None:
        """Copy, convert and check both arrays."""
        vertices, triangles = checked_arrays(self.vertices, self.triangles)
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "triangles", triangles)

    def __repr__(self) -> str:
        """Say how large it is."""
        return f"<Mesh: {len(self.vertices)} vertices, {len(self.triangles)} triangles, {self.volume:.4g} m³>"

    def __reduce__(self) -> tuple[type[Mesh], tuple[np.ndarray, np.ndarray]]:
        """Pickle, and copy, as what it is made from: a copy is checked and read-only, too."""
        return type(self), (self.vertices, self.triangles)

    @property
    def edges(self) -> np.ndarray:
        """Every edge once, (e, 2), smaller index first, sorted."""
        return unique_edges(self.triangles)

    @property
    def volume(self) -> float:
        """Enclosed volume [m³]."""
        return signed_volume(self.vertices, self.triangles)

    @classmethod
    def from_soup(cls, vertices: ArrayLike, triangles: ArrayLike | None = None, tolerance: float = 0.0) -> Mesh:
        """Return a mesh of triangles that do not share their vertices: those at the same place are merged.

        `vertices` (n, 3) [m] and `triangles` (t, 3), or corners alone, (t, 3, 3) or (3 t, 3). With a `tolerance` [m],
        vertices that are at most that far apart are merged, too, and so are chains of them; the first keeps its place.
        Triangles that are left with fewer than three corners are left out, and vertices that none uses. Raises
        MeshError, as for any mesh.
        """
        return cls(*merged(vertices, triangles, check_range(tolerance, "tolerance", "m", least=0.0)))

    @classmethod
    def from_trimesh(cls, mesh: Any, *, merge: bool = False, tolerance: float = 0.0) -> Mesh:
        """Return the mesh of a trimesh.Trimesh, or of anything with `vertices` and `faces`; see `from_soup`."""
        return cls._from_arrays(*triangles_of(mesh), merge, tolerance)

    @classmethod
    def from_file(cls, path: str | os.PathLike[str], *, merge: bool = False, tolerance: float = 0.0) -> Mesh:
        """Return the mesh of an STL, OBJ, PLY, OFF or another file that trimesh reads, in the file's units and axes.

        In an STL no triangles share a vertex, elsewhere they often do not: `merge=True` merges them, as `from_soup`
        does. Raises MeshError for a file that is no closed mesh, MissingPackageError where trimesh is not installed,
        and OSError if there is no file.
        """
        try:
            return cls._from_arrays(*read_triangles(path), merge, tolerance)
        except MeshError as error:
            raise MeshError(f"{os.fspath(path)}: {error}") from error

    @classmethod
    def _from_arrays(cls, vertices: Any, triangles: Any, merge: bool, tolerance: float) -> Mesh:
        tolerance = check_range(tolerance, "tolerance", "m", least=0.0)
        merge = check_yes_or_no(merge, "merge") or tolerance > 0.0
        return cls.from_soup(vertices, triangles, tolerance) if merge else cls(vertices, triangles)

    def check(self) -> list[Finding]:
        """Return what is doubtful in the mesh, each with what and where it is and how to cure it; see Finding.

        What takes long to find, or is often meant: triangles that go through each other or coincide, shells that are
        several, nested or flat, vertices that join or touch parts, very thin triangles, very unequal edges. Some 5 µs
        a triangle, after 7 s of compiling for the first time.
        """
        keys, edge_of = np.unique(_edge_keys(self.triangles, len(self.vertices)), return_inverse=True)
        edges = _edges_of(keys, len(self.vertices))
        return findings(self.vertices.copy(), self.triangles.copy(), edges, edge_of.ravel())

    def moved(self, offset: ArrayLike) -> Mesh:
        """Return a copy moved by `offset` (3,) [m]."""
        return Mesh(self.vertices + vector(offset, "offset"), self.triangles)

    def scaled(self, factor: float) -> Mesh:
        """Return a copy scaled about the origin by `factor` > 0."""
        factor = check_range(factor, "factor", above=0.0)
        return Mesh(self.vertices * factor, self.triangles)


def unique_edges(triangles: np.ndarray) -> np.ndarray:
    """Return every edge of `triangles` (t, 3) once: (e, 2), smaller index first, sorted."""
    count = int(triangles.max(initial=0)) + 1
    keys = np.sort(_edge_keys(triangles, count))
    return _edges_of(keys[np.append(True, np.diff(keys) > 0)[: len(keys)]], count)


def _edge_keys(triangles: np.ndarray, count: int) -> np.ndarray:
    """Return one number (3 t,) for each edge of each triangle, in the order of edges; there are `count` vertices."""
    a, b, c = triangles.T
    start, end = np.concatenate([a, b, c]), np.concatenate([b, c, a])
    return np.minimum(start, end) * count + np.maximum(start, end)


def _edges_of(keys: np.ndarray, count: int) -> np.ndarray:
    """Return the edges (e, 2) of which `_edge_keys` gave the keys (e,)."""
    return np.stack(np.divmod(keys, count), axis=1)


def checked_arrays(vertices: ArrayLike, triangles: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Return copies as contiguous float64 (n, 3) and int64 (t, 3) arrays, read-only; see Mesh for the errors."""
    with np.errstate(over="ignore"):  # a longdouble that becomes inf is refused below
        points: np.ndarray = _as_rows(vertices, "vertices").astype(np.float64, order="C")
    faces: np.ndarray = _as_rows(triangles, "triangles").copy()
    if faces.dtype.kind not in "iu":
        _require(
            (faces == np.floor(faces)).all(axis=1),
            "triangle {0} is {1}: not whole numbers; give vertex indices",
            faces,
        )
        _require((np.abs(faces) < 2**53).all(axis=1), "triangle {0} has an index too large; give integers")
    _require(
        np.isfinite(points).all(axis=1),
        "vertex {0} is at {1}: not finite; remove it or repair its coordinates",
        points,
    )
    check_indices(faces, len(points))
    faces = faces.astype(np.int64, order="C")
    try:
        edge_of = _check_closed(faces, len(points))
    except MeshError as error:
        raise _with_cure(error, points) from None
    # Nobody may change them, and let a triangle point past the vertices.
    points.flags.writeable = faces.flags.writeable = False
    _check_shape(points, faces)
    _check_shells(points, faces, edge_of)
    return points, faces


def _with_cure(error: MeshError, points: np.ndarray) -> MeshError:
    """Return the error of a mesh that is not closed, with what helps if vertices lie at the same place."""
    double = np.count_nonzero(first_at_place(points) != np.arange(len(points)))
    if not double:
        return error
    return MeshError(
        f"{double} of {len(points)} vertices are at the place of another one: merge vertices, by Mesh.from_soup("
        f"vertices, triangles) or Mesh.from_file(path, merge=True); else {error}"
    )


def check_surface(triangles: np.ndarray, count: int) -> None:
    """Raise MeshError unless `triangles` (t, 3) int64 of `count` vertices are closed and oriented; see Mesh."""
    check_indices(triangles, count)
    _check_closed(triangles, count)


def _as_rows(rows: ArrayLike, name: str) -> np.ndarray:
    try:
        array = np.asarray(rows)
        if array.dtype.kind == "O":
            array = array.astype(np.float64)
        if array.dtype.kind not in "iuf":
            raise TypeError(f"{array.dtype} is not a type of real numbers")
    except NO_NUMBERS as error:
        raise MeshError(f"{name} are not numbers in rows of three; give an (n, 3) array") from error
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError(f"{name} have shape {array.shape}; give an (n, 3) array")
    if len(array) == 0:
        raise MeshError(f"{name} are empty; a closed mesh has at least 4 vertices and 4 triangles")
    return array


def _require(ok: np.ndarray, message: str, *columns: np.ndarray) -> None:
    """Raise `message`, filled with the first row that is not `ok` and the columns' values there."""
    if not ok.all():
        first = int(np.argmin(ok))
        raise MeshError(message.format(first, *(column[first] for column in columns)))


def check_indices(faces: np.ndarray, count: int) -> None:
    """Raise MeshError unless `faces` (t, 3) are of three of `count` vertices each, and use them all."""
    _require(
        (np.isfinite(faces) & (faces >= 0) & (faces < count)).all(axis=1),
        "triangle {0} is {1}, but vertices run from 0 to " + str(count - 1) + "; repair its indices",
        faces,
    )
    a, b, c = faces.T
    _require(
        (a != b) & (b != c) & (c != a),
        "triangle {0} is {1}: it repeats a vertex; remove the triangle",
        faces,
    )
    used = np.zeros(count, bool)
    used[faces.astype(np.int64).ravel()] = True
    _require(used, "vertex {0} belongs to no triangle; remove it")


def _check_closed(faces: np.ndarray, count: int) -> np.ndarray:
    """Raise MeshError unless each edge has two triangles; return the edge (3 t,) of each half-edge."""
    keys, edge_of, meetings = np.unique(_edge_keys(faces, count), return_inverse=True, return_counts=True)
    edges = _edges_of(keys, count)
    _require(
        meetings == 2,
        "edge {1[0]}–{1[1]} is met by {2} triangle(s), not 2; close the hole or take the extra triangles away",
        edges,
        meetings,
    )
    is_forward = np.concatenate([faces[:, k] < faces[:, (k + 1) % 3] for k in range(3)])
    forward = np.bincount(edge_of.ravel()[is_forward], minlength=len(edges))
    _require(
        forward == 1,
        "both triangles at edge {1[0]}–{1[1]} run along it the same way; flip one, so that all triangles turn "
        "counter-clockwise seen from outside",
        edges,
    )
    return edge_of.ravel()


MOST_VERTICES = 20_000_000  # that a shape is made with: some ten gigabytes of memory on the way


def _check_number(vertices: int, cure: str) -> None:
    """Raise ParameterError for a shape of more vertices than are made."""
    if vertices > MOST_VERTICES:
        raise ParameterError(
            f"{vertices} vertices are more than the {MOST_VERTICES} that a shape may have; ask for {cure}"
        )


# Extents [m] between which areas squared, and volumes squared, are neither 0 nor inf in float64 (1e±308).
SMALLEST, LARGEST = 1e-50, 1e50


def _check_shape(points: np.ndarray, faces: np.ndarray) -> None:
    edges = unique_edges(faces)
    with np.errstate(over="ignore"):
        reach = np.abs(points - points[0]).max(axis=1)
    _require(
        reach < LARGEST,
        "vertex {0} is {1:.3g} m away from vertex 0: too far to compute a volume; scale the mesh down",
        reach,
    )
    _require(
        (points[edges[:, 0]] != points[edges[:, 1]]).any(axis=1),
        "edge {1[0]}–{1[1]} has no length: both vertices are at the same place; merge them",
        edges,
    )
    size = float(np.max(np.ptp(points, axis=0)))
    if size < SMALLEST:
        raise MeshError(f"the mesh is only {size:.3g} m across: too small to compute a volume; scale it up")
    a, b, c = (points[faces[:, k]] for k in range(3))
    _require(
        np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0.0,
        "triangle {0} ({1}) has no area; move one of its vertices or remove it",
        faces,
    )
    volume = signed_volume(points, faces)
    if abs(volume) <= volume_of_rounding(points, faces):
        raise MeshError("the mesh encloses no volume: it is flat; give it a thickness")
    if not volume > 0.0:
        raise MeshError(f"the mesh is inside out (volume {volume:.6g} m³): reverse every triangle, triangles[:, ::-1]")


def _check_shells(points: np.ndarray, faces: np.ndarray, edge_of: np.ndarray) -> None:
    """Raise MeshError for a shell that is inside out and bounds no cavity: its gas would press inwards."""
    found = shells_of(points, faces, edge_of)
    inwards = np.flatnonzero(found.volume < -volume_of_rounding(points, faces))
    if not len(inwards):
        return
    outside = inwards[enclosing(points, faces, found, inwards) % 2 == 0]
    if len(outside):
        rows = np.flatnonzero(found.of == outside[0])
        raise MeshError(
            f"the shell of triangle {rows[0]}, {len(rows)} triangles, is inside out (volume "
            f"{found.volume[outside[0]]:.6g} m³), and bounds no cavity of another shell: reverse its triangles"
        )


def tetrahedron(radius: float = 1.0) -> Mesh:
    """Return a regular tetrahedron about the origin with its corners at `radius` [m]."""
    corners = [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]
    return _regular(corners, [(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)], radius)


def octahedron(radius: float = 1.0) -> Mesh:
    """Return a regular octahedron about the origin with its corners at `radius` [m]."""
    corners = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    upper = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4)]
    lower = [(2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    return _regular(corners, upper + lower, radius)


def icosahedron(radius: float = 1.0) -> Mesh:
    """Return a regular icosahedron about the origin with its corners at `radius` [m]."""
    g = (1.0 + sqrt(5.0)) / 2.0
    corners = [
        (-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0),
        (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g),
        (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1),
    ]  # fmt: skip
    faces = [
        (0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11),
        (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
        (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9),
        (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1),
    ]  # fmt: skip
    return _regular(corners, faces, radius)


def _regular(corners: ArrayLike, faces: ArrayLike, radius: float) -> Mesh:
    radius = check_range(radius, "radius", "m", above=0.0)
    directions = np.asarray(corners, float)
    return Mesh(radius * directions / np.linalg.norm(directions, axis=1, keepdims=True), np.asarray(faces))


def icosphere(subdivisions: int = 3, radius: float = 1.0) -> Mesh:
    """Return a sphere of 10·4ˢ + 2 vertices: an icosahedron whose triangles are split in four `subdivisions` times.

    `radius` [m]; every vertex lies on the sphere. Subdivisions 3, 4, 5, 6, 7 have 642, 2 562, 10 242, 40 962
    and 163 842 vertices.
    """
    subdivisions = check_whole(subdivisions, "subdivisions", 0, 10)
    radius = check_range(radius, "radius", "m", above=0.0)
    solid = icosahedron()
    points, faces = solid.vertices, solid.triangles
    for _ in range(subdivisions):
        edges = unique_edges(faces)
        middles = points[edges[:, 0]] + points[edges[:, 1]]
        middles /= np.linalg.norm(middles, axis=1, keepdims=True)
        a, b, c = faces.T
        ab, bc, ca = len(points) + edges_of_sides(faces, edges, len(points)).T
        faces = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1).reshape(-1, 3)
        points = np.concatenate([points, middles])
    return Mesh(radius * points, faces)


def torus(
    major_radius: float = 1.0, minor_radius: float = 0.4, major_segments: int = 48, minor_segments: int = 24
) -> Mesh:
    """Return a torus about the z axis with `major_segments` × `minor_segments` vertices; radii in metres."""
    minor_radius = check_range(minor_radius, "minor_radius", "m", above=0.0)
    major_radius = check_range(major_radius, "major_radius", "m", above=0.0)
    if not major_radius > minor_radius:
        raise ParameterError(
            f"major_radius {major_radius} must exceed minor_radius {minor_radius}, or the torus meets itself"
        )
    major_segments = check_whole(major_segments, "major_segments", 3)
    minor_segments = check_whole(minor_segments, "minor_segments", 3)
    _check_number(major_segments * minor_segments, "fewer segments")
    u = 2.0 * pi * np.arange(major_segments) / major_segments
    v = 2.0 * pi * np.arange(minor_segments) / minor_segments
    around, across = np.meshgrid(u, v, indexing="ij")
    distance = major_radius + minor_radius * np.cos(across)
    points = np.stack(
        [distance * np.cos(around), distance * np.sin(around), minor_radius * np.sin(across)], axis=-1
    ).reshape(-1, 3)
    index = np.arange(major_segments * minor_segments).reshape(major_segments, minor_segments)
    ahead = np.roll(index, -1, axis=0)
    a, b, c, d = (q.ravel() for q in (index, ahead, np.roll(ahead, -1, axis=1), np.roll(index, -1, axis=1)))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return Mesh(points, faces)


def box(size: ArrayLike = (1.0, 1.0, 1.0), segments: int = 1) -> Mesh:
    """Return a box about the origin of full extent `size` (3,) [m], each side `segments` × `segments` squares."""
    try:
        extent = doubles(size)
    except NO_NUMBERS as error:
        raise ParameterError(f"size is {shown(size)}; give three positive lengths [m]") from error
    if extent.shape != (3,) or not (np.isfinite(extent) & (extent > 0.0)).all():
        raise ParameterError(f"size is {shown(size)}; give three positive lengths [m]")
    segments = check_whole(segments, "segments", 1)
    _check_number(6 * segments**2 + 2, "fewer segments")
    corners: list[np.ndarray] = []
    faces: list[np.ndarray] = []
    line = np.arange(segments + 1)
    for axis in range(3):
        right, up = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, segments):
            grid = np.zeros((segments + 1, segments + 1, 3), np.int64)
            grid[..., axis] = side
            grid[..., right], grid[..., up] = np.meshgrid(line, line, indexing="ij")
            index = len(corners) * (segments + 1) ** 2 + np.arange((segments + 1) ** 2).reshape(
                segments + 1, segments + 1
            )
            a, b, c, d = (q.ravel() for q in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
            quads = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
            corners.append(grid.reshape(-1, 3))
            faces.append(quads if side else quads[:, ::-1])
    lattice, index_of = np.unique(np.concatenate(corners), axis=0, return_inverse=True)
    return Mesh(extent * (lattice / segments - 0.5), index_of.ravel()[np.concatenate(faces)])
