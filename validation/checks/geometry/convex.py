"""The separating-axis test on pairs of convex meshes: tetrahedra, hulls, spheres of triangles."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

import softbody
from softbody.collision import sat_convex
from validation.answers import Answers
from validation.cases import random_orientations, rotation_matrix
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "separating axes"

FACES_ONLY = Fault(
    "convex meshes by their faces only", sat_convex.convex_separation, "0 if paper_axes_ else edges_ → 0"
)
PIECE = "softbody.collision.sat_convex.convex_separation"

Solid = tuple[np.ndarray, np.ndarray]  # vertices, triangles


def _hull(points: np.ndarray) -> Solid:
    """Return the convex hull of `points` (n, 3), its triangles outwards."""
    from scipy.spatial import ConvexHull

    found = ConvexHull(points)
    corners = points[found.simplices]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inwards = (normals * found.equations[:, :3]).sum(axis=1) < 0.0
    triangles = np.where(inwards[:, None], found.simplices[:, [0, 2, 1]], found.simplices)
    used, number = np.unique(triangles, return_inverse=True)
    return points[used], number.reshape(-1, 3)


def _solid(kind: str, rng: np.random.Generator) -> Solid:
    """Return a random convex solid of one of KINDS about the origin, about 1 m in radius, turned at random."""
    if kind == "tetrahedra":
        return _hull(rng.normal(size=(4, 3)))
    if kind == "hulls of 12 points":
        return _hull(rng.normal(size=(12, 3)))
    mesh = softbody.icosphere(1) if kind == "icospheres" else softbody.box(rng.uniform(0.5, 2.0, 3))
    return mesh.vertices @ rotation_matrix(random_orientations(rng, 1)[0]).T, mesh.triangles


KINDS = ("tetrahedra", "hulls of 12 points", "boxes", "icospheres")


def _pairs_of(kind: str, rng: np.random.Generator, count: int) -> Iterator[tuple[Solid, Solid]]:
    """Yield pairs of solids of one kind, about half of which overlap."""
    for _ in range(count):
        a, (vertices_b, triangles_b) = _solid(kind, rng), _solid(kind, rng)
        direction = rng.normal(size=3)
        offset = rng.uniform(0.0, 2.4) * direction / np.linalg.norm(direction)
        yield a, (vertices_b + offset, triangles_b)


def _separation(a: Solid, b: Solid, paper_axes: bool = False) -> tuple[float, np.ndarray]:
    """Return the core's separation [m] and normal."""
    found, normal, _ = sat_convex.convex_separation(sat_convex.convex(*a), sat_convex.convex(*b), paper_axes)
    return found, np.array(normal)


def _by(run: Run, judge: Callable[..., bool], margin: float) -> Comparison:
    """Ask yes or no about every kind, beyond the judge's margin; and count the false hits of face normals alone."""
    answers, notes = Answers(), []
    for kind in KINDS:
        false_hits = hits = 0
        for a, b in _pairs_of(kind, run.fresh_rng(), run.count(25, 150, 5_000)):
            found, _ = _separation(a, b)
            if abs(found) > margin:
                truth = bool(judge(*a, *b))
                answers.add(found <= 0.0, truth, kind=kind)
                paper = _separation(a, b, True)[0] <= 0.0
                hits += paper
                false_hits += paper and not truth
        notes.append(f"{kind}: {100.0 * false_hits / max(1, hits):.1f} % of the hits of face normals alone are false")
    return answers.comparison(notes=notes)


@check(
    section="4.5",
    piece=PIECE,
    reference="FCL with libccd",
    engines=("fcl", "scipy"),
    because="libccd stops within 1e-6 m, and pairs nearer than 1e-5 m are passed over",
    faults=(FACES_ONLY,),
)
def meshes_by_fcl(run: Run) -> Comparison:
    """Random tetrahedra, hulls, boxes and icospheres overlap exactly when FCL says so."""
    from references import fcl

    return _by(run, fcl.convex_overlap, 1e-5)


@check(
    section="4.5",
    piece=PIECE,
    reference="coal",
    engines=("coal", "scipy"),
    because="coal is right beyond 1e-6 m, and nearer pairs are passed over",
    faults=(FACES_ONLY,),
)
def meshes_by_coal(run: Run) -> Comparison:
    """Random tetrahedra, hulls, boxes and icospheres overlap exactly when coal says so."""
    from references import coal

    return _by(run, coal.convex_overlap, coal.MARGIN)


@check(
    section="4.5",
    piece=PIECE,
    reference="coal distance with signed result",
    engines=("coal", "scipy"),
    unit="of the size",
    tolerance=1e-14,
    because="1.3e-15 at worst of ten seeds; coal's EPA ends on a face of the difference of the meshes, not near it",
    faults=(FACES_ONLY,),
)
def depth_of_meshes(run: Run) -> Comparison:
    """The depth of overlapping convex meshes is the least that coal finds."""
    from references import coal

    answers = Answers()
    for kind in KINDS:
        for a, b in _pairs_of(kind, run.fresh_rng(), run.count(20, 100, 3_000)):
            found, _ = _separation(a, b)
            if found < -1e-3:
                answers.add(found, coal.convex_distance(*a, *b), kind=kind)
    return answers.comparison()


@check(
    section="4.5",
    piece=PIECE,
    reference="exact rational arithmetic on the same floating-point inputs",
    engines=("scipy",),
    kind="exact arithmetic",
    because="pairs within the core's rounding, 2e-14 m for directions that are themselves rounded, are passed over",
    faults=(
        Fault(
            "convex meshes grown by 1e-12",
            sat_convex.convex_separation,
            "best = low_b - high_a → best = low_b - high_a - 1e-12",
        ),
    ),
)
def near_touching_meshes(run: Run) -> Comparison:
    """Convex meshes that hardly miss or touch are told apart rightly.

    They miss or touch by 1e-3 to 1e-13 of their size.
    """
    from references import exact

    rng, answers, passed = run.fresh_rng(), Answers(), 0
    for kind in ("tetrahedra", "boxes"):
        for a, (vertices_b, triangles_b) in list(_pairs_of(kind, rng, run.count(40, 150, 5_000))):
            apart, normal = _separation(a, (vertices_b, triangles_b))
            gap = rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-13.0, -3.0)
            b = vertices_b + (apart - gap) * normal, triangles_b
            found, _ = _separation(a, b)
            if abs(found) > 2e-14:
                answers.add(found <= 0.0, exact.convex_overlap(*a, *b) >= 0, kind=kind)
            else:
                passed += 1
    return answers.comparison(notes=[f"{passed} pairs passed over"])


PARALLEL = 4e-15  # the sine of an angle from which on directions are two, as `Convex` says


@check(
    section="4.5",
    piece="softbody.collision.sat_convex.convex",
    reference="a roof of two faces through one edge, as steep as that: six sides more, no two of them parallel",
    kind="closed form",
    unit="normals",
    tolerance=0.0,
    because="whole numbers; sines of 1e-15 beside an edge at the origin are exact to 1e-16 of themselves",
    faults=(
        Fault(
            "an angle a hundredth wider", sat_convex._distinct, "sines < SAME_DIRECTION → sines < 1.01 * SAME_DIRECTION"
        ),
        Fault("parallel faces that are kept", sat_convex._distinct, "(s_ < d_).any() → False"),
        Fault("a tenth of the angle", sat_convex._distinct, "sines < SAME_DIRECTION → sines < 0.1 * SAME_DIRECTION"),
    ),
)
def parallel_faces(run: Run) -> Comparison:
    """Faces of a convex mesh have one normal if they are parallel.

    They count as parallel if the sine of their angle is below 4e-15. Of two faces at 0.5, 0.997, 1.003 and 2 times
    that, whichever way they face.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(32, 100, 1_000)):
        factor = (0.5, 0.997, 1.003, 2.0)[trial % 4]
        outline = np.array([(-1.4, 0.0), (1.3, 0.0), (1.0, 1.0), (-1.0, 1.1), (0.9, -1.0), (-0.8, -1.0)])
        outline[2:] *= rng.uniform(0.9, 1.1, (4, 1))
        rise = np.append(factor * PARALLEL * np.maximum(0.0, -outline[:, 1]), 1.0)
        vertices = np.column_stack([np.append(outline, [rng.uniform(-0.2, 0.2, 2)], axis=0), rise])
        ring = (0, 3, 2, 1, 4, 5)  # of the roof, which hangs down; its apex is vertex 6
        roof = [(0, 3, 2), (0, 2, 1), (0, 1, 4), (0, 4, 5)]
        triangles = np.array(roof + [(ring[k], ring[k - 1], 6) for k in range(6)])
        turn, sign = rng.permutation(3), rng.choice([-1.0, 1.0], 3)
        if np.linalg.det(np.eye(3)[turn]) * sign.prod() < 0.0:
            triangles = triangles[:, ::-1]
        shape = sat_convex.convex(2.0 ** rng.integers(-3, 4) * sign * vertices[:, turn], triangles)
        answers.add(len(shape.normals), 7 if factor < 1.0 else 8, kind=f"{factor} of the limit")
    return answers.comparison()
