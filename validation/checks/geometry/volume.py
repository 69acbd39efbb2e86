"""Volume, area, centroid and inertia of closed meshes, against closed forms and trimesh."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np

import softbody
from softbody import Mesh
from softbody.geometry import box, polyhedron, tetrahedron, triangle
from validation.answers import Answers
from validation.cases import random_mesh, rotated
from validation.check import Comparison, Misprint, Run, check
from validation.checks.geometry.cases import longest_side, random_meshes
from validation.fault import Fault

FAMILY = "volume, centroid, inertia"

PIECE = "softbody.geometry.polyhedron.signed_volume"
VOLUME = Fault(
    "volume off by 1e-12", polyhedron.signed_volume, "six_volumes_ / 6.0 → six_volumes_ / 6.0 * (1.0 + 1e-12)"
)


@check(
    section="2.3",
    piece=PIECE,
    reference="closed forms",
    kind="closed form",
    tolerance=2e-14,
    because="rounding: about 2e-16 for each of up to 2 304 triangles, added in sequence, as a random walk",
    faults=(VOLUME,),
)
def closed_forms(run: Run) -> Comparison:
    """Regular solids, boxes and faceted tori have the volumes of closed forms."""
    from references import analytic

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(10, 40, 400)):
        radius, minor, size = rng.uniform(0.1, 5.0), rng.uniform(0.1, 0.9), rng.uniform(0.1, 3.0, 3)
        around, across = (int(n) for n in rng.integers(3, 48, 2))
        ring = 1.0, minor, around, across
        shapes: dict[str, tuple[Mesh, Any]] = {
            kind: (getattr(softbody, kind)(radius), analytic.regular_solid_volume(kind, radius))
            for kind in ("tetrahedron", "octahedron", "icosahedron")
        }
        shapes["box"] = softbody.box(size, 3), analytic.box_volume(size)
        shapes["torus"] = softbody.torus(*ring), analytic.faceted_torus_volume(*ring)
        asked = {"radius, size, small radius, around, across": [radius, *size, minor, around, across]}
        for kind, (mesh, volume) in shapes.items():
            turned = rotated(mesh, rng)
            answers.add(polyhedron.signed_volume(turned.vertices, turned.triangles), volume, volume, kind, **asked)
    return answers.comparison()


def _by_trimesh(
    run: Run,
    measure: Callable[[np.ndarray, np.ndarray], Any],
    judge: Callable[[np.ndarray, np.ndarray], Any],
    is_length: bool = False,
) -> Comparison:
    """Ask for a measure of random meshes, relative to itself or, if it is a length, to the size of the mesh."""
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(4, 20, 200)):
        for kind, mesh in random_meshes(1, rng):
            expected = np.ravel(judge(mesh.vertices, mesh.triangles))
            scale = longest_side(mesh.vertices) if is_length else float(np.linalg.norm(expected))
            size = [len(mesh.vertices), *mesh.vertices.mean(axis=0), *np.ptp(mesh.vertices, axis=0)]
            inputs = {"vertices, their mean [m], their extent [m]": size}
            answers.add(np.ravel(measure(mesh.vertices, mesh.triangles)), expected, scale, kind, **inputs)
    return answers.comparison()


@check(
    section="2.3",
    piece=PIECE,
    reference="trimesh",
    engines=("trimesh",),
    tolerance=2e-14,
    because="both sides round: some 1 300 triangles at 2e-16 each, and cancellation in the concave ones",
    faults=(VOLUME,),
)
def volume_of_meshes(run: Run) -> Comparison:
    """The volume of random closed meshes, convex or not, is trimesh's."""
    from references import trimesh

    return _by_trimesh(run, polyhedron.signed_volume, trimesh.volume)


@check(
    section="2.2",
    piece="softbody.geometry.polyhedron.surface_area",
    reference="trimesh",
    engines=("trimesh",),
    tolerance=5e-14,
    because="a sum of some 1 300 positive terms, rounded on both sides",
    faults=(
        Fault(
            "area off by 1e-12",
            triangle.triangle_area,
            "norm(area_vector(a_, b_, c_)) → norm(area_vector(a_, b_, c_)) * (1.0 + 1e-12)",
        ),
    ),
)
def area_of_meshes(run: Run) -> Comparison:
    """The area of random closed meshes is trimesh's."""
    from references import trimesh

    return _by_trimesh(run, polyhedron.surface_area, trimesh.area)


@check(
    section="2.3",
    piece="softbody.geometry.polyhedron.centroid",
    reference="trimesh",
    engines=("trimesh",),
    unit="of the mesh's size",
    tolerance=2e-14,
    because="rounding of some 1 300 terms of the mesh's size on both sides",
    faults=(Fault("centroid off by 1e-10", polyhedron.centroid, "0.25 / six_volumes_ → 0.2500000001 / six_volumes_"),),
)
def centroid_of_meshes(run: Run) -> Comparison:
    """The centroid of random closed meshes is trimesh's."""
    from references import trimesh

    return _by_trimesh(run, polyhedron.centroid, trimesh.centroid, is_length=True)


@check(
    section="3",
    piece="softbody.geometry.polyhedron.inertia_tensor",
    reference="trimesh",
    engines=("trimesh",),
    tolerance=1e-13,
    because="trimesh shifts to the centroid after the sum and so loses a digit; both round some 1 300 terms",
    faults=(
        Fault(
            "inertia off by 1e-9",
            polyhedron.inertia_tensor,
            "mass_ / (20.0 * six_volumes_) → mass_ / (20.00000001 * six_volumes_)",
        ),
    ),
)
def inertia_of_meshes(run: Run) -> Comparison:
    """The inertia of random closed meshes about their centroid is trimesh's."""
    from references import trimesh

    return _by_trimesh(run, partial(polyhedron.inertia_tensor, mass=3.0), partial(trimesh.inertia, mass=3.0))


@check(
    section="2.3",
    piece=PIECE,
    reference="trimesh, on the same rounded vertices moved back exactly",
    engines=("trimesh",),
    tolerance=2e-14,
    because="the differences of far vertices are exact; the rest rounds as near the origin",
    faults=(
        Fault(
            "volume summed about the origin",
            polyhedron.signed_volume,
            "origin_ = load(vertices_, triangles_[0, 0]) → origin_ = (0.0, 0.0, 0.0)",
        ),
    ),
)
def volume_far_away(run: Run) -> Comparison:
    """A mesh moved up to a thousand kilometres away keeps its volume.

    Nothing is lost beyond the rounding of its vertices.
    """
    from references import trimesh

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(3, 10, 100)):
        for distance in (1e2, 1e3, 1e4, 1e5, 1e6):
            mesh = random_mesh("lumpy sphere", rng)
            offset = distance * rng.uniform(0.5, 1.0, 3) * rng.choice([-1.0, 1.0], 3)
            far = mesh.vertices + offset
            volume = trimesh.volume(far - offset, mesh.triangles)
            found = polyhedron.signed_volume(far, mesh.triangles)
            answers.add(found, volume, volume, f"{distance:.0e} m", **{"moved by [m]": offset})
    return answers.comparison()


@check(
    section="3, 10.8",
    piece="softbody.geometry.box.box_inertia",
    reference="closed form; trimesh",
    engines=("trimesh",),
    tolerance=1e-14,
    because="a few roundings against the closed form; twelve triangles against trimesh",
    faults=(
        Fault(
            "inertia of a box with two axes exchanged",
            box.box_inertia,
            "(y2 + z2, x2 + z2, x2 + y2) → (x2 + z2, y2 + z2, x2 + y2)",
        ),
    ),
    erratum=Misprint(
        "E7",
        "§3 and §10.8 list the diagonal in two orders; here Iyy first: (x²+z², y²+z², x²+y²)",
        "Ixx has y and z, Iyy x and z, Izz x and y",
    ),
)
def inertia_of_boxes(run: Run) -> Comparison:
    """A box has the inertia of its closed form and its mesh."""
    from references import analytic, printed, trimesh

    rng, answers, wrong = run.fresh_rng(), Answers(), []
    for _ in range(run.count(10, 100, 1000)):
        size, mass = rng.uniform(0.1, 3.0, 3), rng.uniform(0.1, 10.0)
        mesh, inputs = softbody.box(size), {"size [m], mass [kg]": [*size, mass]}
        for judge, answer in (
            ("closed form", analytic.box_inertia(size, mass)),
            ("trimesh", np.diag(trimesh.inertia(mesh.vertices, mesh.triangles, mass))),
        ):
            answers.add(box.box_inertia(tuple(size), mass), answer, 1.0, judge, **inputs)
            wrong.append(printed.box_inertia_other_order(size, mass))
    comparison = answers.comparison(printed=np.array(wrong))
    comparison.scale = np.linalg.norm(comparison.expected, axis=1)
    return comparison


@check(
    section="2.3, 10.4",
    piece=PIECE,
    reference="closed form of the faceted torus",
    kind="closed form",
    tolerance=2e-14,
    because="vertices up to 9 m from the origin are rounded to 1e-15 m before the volume is taken",
    faults=(VOLUME,),
    erratum=Misprint("E6", "signed determinant, then signed again by a·n", "the determinant's own sign, once"),
)
def volume_does_not_depend_on_the_origin(run: Run) -> Comparison:
    """The signed volume of a mesh does not depend on the origin."""
    from references import analytic, printed

    rng = run.fresh_rng()
    mesh = softbody.torus(1.0, 0.4, 48, 24)
    offsets = [np.zeros(3), np.full(3, 5.0), *rng.uniform(-5.0, 5.0, (run.count(5, 20, 200), 3))]
    moved = [mesh.vertices + offset for offset in offsets]
    exact = analytic.faceted_torus_volume(1.0, 0.4, 48, 24)
    return Comparison(
        [polyhedron.signed_volume(vertices, mesh.triangles) for vertices in moved],
        [exact] * len(moved),
        exact,
        printed=[printed.volume_signed_twice(vertices, mesh.triangles) for vertices in moved],
        inputs={"moved by [m]": offsets},
    )


@check(
    section="10.10",
    piece="softbody.geometry.tetrahedron.tetrahedron_volume",
    reference="whole numbers: corners with coordinates from −100 to 100",
    unit="m³",
    kind="exact arithmetic",
    tolerance=0.0,
    because="all products and sums are whole numbers, and one division is rounded as rational numbers are",
    faults=(
        Fault("the volume of a parallelepiped", tetrahedron.tetrahedron_volume, "six_ / 6.0 → six_ / 1.0"),
        Fault(
            "the volume of tetrahedra turned inside out",
            tetrahedron.tetrahedron_volume,
            "cross(c_, d_) → cross(d_, c_)",
        ),
    ),
)
def tetrahedra(run: Run) -> Comparison:
    """A tetrahedron's volume is a sixth of its edges' determinant, sign included."""
    corners = run.fresh_rng().integers(-100, 101, (run.count(300, 3_000, 30_000), 4, 3))
    measured = [tetrahedron.tetrahedron_volume(*map(tuple, each)) for each in corners.astype(float).tolist()]
    edges = (corners[:, 1:] - corners[:, :1]).astype(object)
    (a, b, c), (d, e, f), (g, h, i) = edges.transpose(1, 2, 0)
    six = a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g)  # Python's integers
    return Comparison(np.array(measured), np.array([float(Fraction(each, 6)) for each in six]))
