"""Claims that the shapes that a World starts from are the solids that they are called."""

from __future__ import annotations

import numpy as np

import softbody
from softbody import Mesh
from softbody.mesh import mesh
from validation.answers import Answers
from validation.cases import edge_lengths
from validation.check import Comparison, Run, check
from validation.checks.geometry.cases import corners_side_by_side, random_meshes
from validation.fault import Fault

FAMILY = "meshes that users make"

SOLIDS = {"tetrahedron": (4, 4), "octahedron": (6, 8), "icosahedron": (12, 20)}  # corners and faces

EDGES = {"tetrahedron": (8.0 / 3.0) ** 0.5, "octahedron": 2.0**0.5, "icosahedron": 1.0 / np.sin(0.4 * np.pi)}  # of R


def _euler(shape: Mesh) -> int:
    """Return V − E + F, from raw arrays: 2 for a sphere, 0 for a torus."""
    sides = np.sort(shape.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    return len(np.unique(shape.triangles)) - len(np.unique(sides, axis=0)) + len(shape.triangles)


def _told(shape: Mesh) -> list[float]:
    """Return volume and area, by trimesh, centroid and Euler characteristic of a mesh."""
    from references import trimesh

    arrays = shape.vertices, shape.triangles
    return [trimesh.volume(*arrays), trimesh.area(*arrays), *trimesh.centroid(*arrays), float(_euler(shape))]


@check(
    section="2",
    piece="softbody.tetrahedron, softbody.octahedron, softbody.icosahedron",
    reference="closed forms of the Platonic solids (Coxeter 1973); measured by trimesh, from raw arrays",
    engines=("trimesh",),
    kind="closed form",
    unit="of each quantity's size",
    tolerance=2e-14,
    because="rounding of some dozen terms: 6e-15",
    faults=(
        Fault("a golden ratio of five digits", mesh.icosahedron, "(1.0 + sqrt(5.0)) / 2.0 → 1.61803"),
        Fault(
            "corners at a diameter",
            mesh._regular,
            "radius_ * directions / np.linalg.norm(directions, axis=1, keepdims=True)"
            " → 0.5 * radius_ * directions / np.linalg.norm(directions, axis=1, keepdims=True)",
        ),
        Fault(
            "corners that are not brought to the radius",
            mesh._regular,
            "radius_ * directions / np.linalg.norm(directions, axis=1, keepdims=True) → radius_ * directions",
        ),
        Fault("an octahedron that is pulled in length", mesh.octahedron, "(0, 0, 1) → (0, 0.01, 1)"),
        Fault("a tetrahedron with one corner aside", mesh.tetrahedron, "(1, 1, 1) → (1, 1, 1.01)"),
    ),
)
def regular_solids(run: Run) -> Comparison:
    """The tetrahedron, octahedron and icosahedron are the regular solids.

    As many corners and faces, all corners at the radius, all edges as long, volume, area, centre and Euler
    characteristic, facing outwards.
    """
    from references import analytic

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(10, 50, 500)):
        for name, (corners, faces) in SOLIDS.items():
            radius = 10.0 ** rng.uniform(-3.0, 3.0)
            shape = getattr(softbody, name)(radius)
            volume, area, *centre, characteristic = _told(shape)
            edge, reach = radius * EDGES[name], np.linalg.norm(shape.vertices, axis=1)
            side = edge_lengths(shape.vertices, shape.edges)
            answers.add(
                [volume / radius**3, area / radius**2, *(np.array(centre) / radius), characteristic]
                + [side.min() / edge, side.max() / edge, reach.min() / radius, reach.max() / radius]
                + [len(shape.vertices), len(shape.triangles)],
                [analytic.regular_solid_volume(name, 1.0), 0.25 * 3.0**0.5 * faces * (edge / radius) ** 2]
                + [0.0, 0.0, 0.0, 2.0, 1.0, 1.0, 1.0, 1.0, corners, faces],
                kind=name,
            )
    return answers.comparison()


@check(
    section="2",
    piece="softbody.icosphere",
    reference="trimesh.creation.icosphere",
    engines=("trimesh",),
    unit="of the radius",
    tolerance=1e-13,
    because="rounding: trimesh puts corners at a radius by adding what lacks, to 1e-14 of it",
    faults=(
        Fault(
            "middles left on the edges",
            mesh.icosphere,
            "middles /= np.linalg.norm(middles, axis=1, keepdims=True) → middles /= 2.0",
        ),
        Fault("one subdivision too many", mesh.icosphere, "range(subdivisions) → range(subdivisions + 1)"),
        Fault("a sphere of half the radius", mesh.icosphere, "radius * points → 0.5 * radius * points"),
    ),
)
def icospheres(run: Run) -> Comparison:
    """An icosphere is trimesh's, corner by corner and triangle by triangle.

    Of any radius and number of subdivisions, however they are numbered.
    """
    from references import trimesh

    rng, answers = run.fresh_rng(), Answers()
    for subdivisions in range(run.count(5, 6, 8)):
        radius = 10.0 ** rng.uniform(-2.0, 2.0)
        ours, theirs = softbody.icosphere(subdivisions, radius), trimesh.icosphere(subdivisions, radius)
        found, judged = corners_side_by_side((ours.vertices, ours.triangles), theirs, radius)
        answers.extend(found, judged, kind=f"{subdivisions} subdivisions")
    return answers.comparison()


@check(
    section="2",
    piece="softbody.torus",
    reference="closed forms of the ring of straight segments; measured by trimesh, from raw arrays",
    engines=("trimesh",),
    kind="closed form",
    unit="of each quantity's size",
    tolerance=5e-14,
    because="rounding of sums over up to 8 000 triangles: 6e-15 at worst of ten seeds, 7e-15 of 1 000 tori",
    faults=(
        Fault(
            "a ring that does not quite close",
            mesh.torus,
            "2.0 * pi * np.arange(major_segments) / major_segments"
            " → 2.0 * pi * np.arange(major_segments) / (major_segments + 1e-6)",
        ),
        Fault(
            "a ring around its outer edge",
            mesh.torus,
            "major_radius + minor_radius * np.cos(across)"
            " → major_radius - minor_radius + minor_radius * (1.0 + np.cos(across)) * (1.0 + 1e-9)",
        ),
        Fault(
            "a ring that is flatter by 1e-6",
            mesh.torus,
            "minor_radius * np.sin(across) → (1.0 - 1e-6) * minor_radius * np.sin(across)",
        ),
    ),
)
def tori(run: Run) -> Comparison:
    """A torus is the faceted ring of its closed forms.

    Of any radii and segments: volume, area, principal moments of inertia, centre, a hole, and all corners on the torus.
    """
    from references import analytic, trimesh

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(20, 100, 1_000)):
        major = 10.0 ** rng.uniform(-2.0, 2.0)
        minor = major * rng.uniform(0.05, 0.95)
        around, across = int(rng.integers(3, 80)), int(rng.integers(4, 50))
        ring = major, minor, around, across
        shape = softbody.torus(*ring)
        volume, area, *centre, characteristic = _told(shape)
        inertia = trimesh.inertia(shape.vertices, shape.triangles, 1.0)
        off = np.hypot(np.linalg.norm(shape.vertices[:, :2], axis=1) - major, shape.vertices[:, 2]) / minor
        answers.add(
            [volume / analytic.faceted_torus_volume(*ring), area / analytic.faceted_torus_area(*ring)]
            + [*(np.array(centre) / major), *(np.diag(inertia) / analytic.faceted_torus_inertia(*ring, 1.0))]
            + [off.min(), off.max(), characteristic, len(shape.vertices), len(shape.triangles)],
            [1.0, 1.0, 0.0, 0.0, 0.0, *5 * [1.0], 0.0, around * across, 2.0 * around * across],
        )
    return answers.comparison()


@check(
    section="2",
    piece="softbody.box",
    reference="a lattice by NumPy, extents multiplied; measured by trimesh, from raw arrays",
    engines=("trimesh",),
    kind="closed form",
    unit="of each quantity's size",
    tolerance=7e-15,
    because="rounding of sums over some thousand triangles: 7e-16 at worst of ten seeds and of all boxes at full",
    faults=(
        Fault("a box from its corner", mesh.box, "lattice / segments - 0.5 → lattice / segments"),
        Fault(
            "a lattice that is finer on one side",
            mesh.box,
            "lattice / segments - 0.5 → (lattice / segments) ** 1.001 - 0.5",
        ),
        Fault(
            "extents the other way round",
            mesh.box,
            "extent * (lattice / segments - 0.5) → extent[::-1] * (lattice / segments - 0.5)",
        ),
    ),
)
def boxes(run: Run) -> Comparison:
    """A box has the corners of an even lattice on its surface.

    Each once, of any extents and segments; and the volume, area, centre and Euler characteristic of a box.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(20, 100, 1_000)):
        size, segments = 10.0 ** rng.uniform(-2.0, 2.0, 3), int(rng.integers(1, 12))
        shape = softbody.box(size, segments)
        volume, area, *centre, characteristic = _told(shape)
        lattice = np.stack(np.meshgrid(*[np.arange(segments + 1)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        places = lattice[((lattice == 0) | (lattice == segments)).any(axis=1)] / segments - 0.5
        found = np.unique(np.round(shape.vertices / size, 9), axis=0)
        apart = np.abs(found - np.round(places, 9)).max() if len(found) == len(places) else np.inf
        area /= 2.0 * (size * np.roll(size, 1)).sum()
        answers.add(
            [volume / size.prod(), area, *(centre / size), apart, characteristic, len(shape.vertices)],
            [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 2.0, 6 * segments**2 + 2],
        )
    return answers.comparison()


@check(
    section="2",
    piece="softbody.Mesh.moved, softbody.Mesh.scaled",
    reference="trimesh: apply_scale, apply_translation",
    engines=("trimesh",),
    unit="of the size, and of the way",
    tolerance=1e-13,
    because="rounding; a volume and a centroid far from the origin lose digits of the way",
    faults=(
        Fault(
            "moved the other way",
            mesh.Mesh.moved,
            'self.vertices + vector(offset, "offset") → self.vertices - vector(offset, "offset")',
        ),
        Fault(
            "moved along one axis by less",
            mesh.Mesh.moved,
            'vector(offset, "offset") → vector(offset, "offset") * (1.0, 1.0, 0.999)',
        ),
        Fault(
            "scaled about its middle",
            mesh.Mesh.scaled,
            "self.vertices * factor"
            " → (self.vertices - self.vertices.mean(axis=0)) * factor + self.vertices.mean(axis=0)",
        ),
    ),
)
def moved_and_scaled(run: Run) -> Comparison:
    """A mesh is moved and scaled as trimesh moves and scales it.

    To the same corners, volume and centroid; and the mesh that it was made from has not changed.
    """
    from references import trimesh

    rng, answers = run.fresh_rng(), Answers()
    for kind, random in random_meshes(run.count(3, 10, 100), rng):
        start = random.moved(rng.normal(size=3))
        before = start.vertices.copy()
        factor, offset = 10.0 ** rng.uniform(-2.0, 2.0), 10.0 ** rng.uniform(-1.0, 1.0) * rng.normal(size=3)
        ours = start.scaled(factor).moved(offset * factor)
        vertices, volume, centroid = trimesh.scaled_and_moved(before, start.triangles, factor, offset * factor)
        off = np.abs(ours.vertices - vertices).max() / factor
        kept = np.abs(start.vertices - before).max()
        mine = trimesh.centroid(ours.vertices, ours.triangles) / factor
        answers.add([off, kept, ours.volume / volume, *mine], [0.0, 0.0, 1.0, *(centroid / factor)], kind=kind)
    return answers.comparison()
