"""Volume, area, centroid and inertia of closed meshes, against closed forms and trimesh."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

import softbody
from softbody.geometry import box, polyhedron, tetrahedron, triangle
from softbody.geometry import box as core_box
from validation.cases import MESH_KINDS, random_mesh, rotated
from validation.check import Comparison, Misprint, Run, check
from validation.fault import Fault

FAMILY = "volume, centroid, inertia"

VOLUME = Fault(
    "volume off by 1e-12", polyhedron.signed_volume, "six_volumes_ / 6.0 → six_volumes_ / 6.0 * (1.0 + 1e-12)"
)


def _flat(matrix: object) -> np.ndarray:
    return np.asarray(matrix, float).ravel()


@check(
    section="2.3",
    piece="softbody.geometry.polyhedron.signed_volume",
    reference="closed forms",
    kind="closed form",
    tolerance=2e-14,
    because="rounding: about 2e-16 for each of up to 2 304 triangles, added in sequence, as a random walk",
    faults=(VOLUME,),
)
def closed_forms(run: Run) -> Comparison:
    """The volume of the regular solids, of boxes and of faceted tori is that of their closed forms."""
    from references import analytic

    rng = run.fresh_rng()
    measured, expected, kinds, parameters = [], [], [], []
    for _ in range(run.count(10, 40, 400)):
        radius, minor, size = rng.uniform(0.1, 5.0), rng.uniform(0.1, 0.9), rng.uniform(0.1, 3.0, 3)
        around, across = (int(n) for n in rng.integers(3, 48, 2))
        for kind, mesh, volume in (
            ("tetrahedron", softbody.tetrahedron(radius), analytic.regular_solid_volume("tetrahedron", radius)),
            ("octahedron", softbody.octahedron(radius), analytic.regular_solid_volume("octahedron", radius)),
            ("icosahedron", softbody.icosahedron(radius), analytic.regular_solid_volume("icosahedron", radius)),
            ("box", softbody.box(size, 3), analytic.box_volume(size)),
            (
                "torus",
                softbody.torus(1.0, minor, around, across),
                analytic.faceted_torus_volume(1.0, minor, around, across),
            ),
        ):
            turned = rotated(mesh, rng)
            measured.append(polyhedron.signed_volume(turned.vertices, turned.triangles))
            expected.append(volume)
            kinds.append(kind)
            parameters.append([radius, *size, minor, around, across])
    inputs = {"radius, size, small radius, around, across": parameters}
    return Comparison(measured, expected, expected, kinds, inputs=inputs)


def _against_trimesh(run: Run, measure: object, judge: object, scale: object) -> Comparison:
    """Compare a measure of random meshes; `scale` makes its error relative."""
    rng = run.fresh_rng()
    measured, expected, scales, kinds, sizes = [], [], [], [], []
    for _ in range(run.count(4, 20, 200)):
        for kind in MESH_KINDS:
            mesh = random_mesh(kind, rng)
            measured.append(_flat(measure(mesh.vertices, mesh.triangles)))  # type: ignore[operator]
            expected.append(_flat(judge(mesh.vertices, mesh.triangles)))  # type: ignore[operator]
            scales.append(scale(expected[-1], mesh))  # type: ignore[operator]
            kinds.append(kind)
            sizes.append([len(mesh.vertices), *mesh.vertices.mean(axis=0), *np.ptp(mesh.vertices, axis=0)])
    inputs = {"vertices, their mean [m], their extent [m]": sizes}
    return Comparison(np.array(measured), np.array(expected), np.array(scales), kinds, inputs=inputs)


@check(
    section="2.3",
    piece="softbody.geometry.polyhedron.signed_volume",
    reference="trimesh",
    engines=("trimesh",),
    tolerance=2e-14,
    because="both sides round: some 1 300 triangles at 2e-16 each, and cancellation in the concave ones",
    faults=(VOLUME,),
)
def volume_of_meshes(run: Run) -> Comparison:
    """The volume of random closed meshes, convex or not, is trimesh's."""
    from references import trimesh

    return _against_trimesh(run, polyhedron.signed_volume, trimesh.volume, lambda value, mesh: abs(value[0]))


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

    return _against_trimesh(run, polyhedron.surface_area, trimesh.area, lambda value, mesh: value[0])


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

    size = lambda value, mesh: np.ptp(mesh.vertices, axis=0).max()  # noqa: E731
    return _against_trimesh(run, polyhedron.centroid, trimesh.centroid, size)


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

    measure = lambda vertices, triangles: polyhedron.inertia_tensor(vertices, triangles, 3.0)  # noqa: E731
    judge = lambda vertices, triangles: trimesh.inertia(vertices, triangles, 3.0)  # noqa: E731
    return _against_trimesh(run, measure, judge, lambda value, mesh: np.linalg.norm(value))


@check(
    section="2.3",
    piece="softbody.geometry.polyhedron.signed_volume",
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
    """Moved up to 1 000 km away, a mesh keeps its volume: nothing is lost beyond the rounding of its vertices."""
    from references import trimesh

    rng = run.fresh_rng()
    measured, expected, offsets, moves = [], [], [], []
    for _ in range(run.count(3, 10, 100)):
        for distance in (1e2, 1e3, 1e4, 1e5, 1e6):
            mesh = random_mesh("lumpy sphere", rng)
            offset = distance * rng.uniform(0.5, 1.0, 3) * rng.choice([-1.0, 1.0], 3)
            far = mesh.vertices + offset
            measured.append(polyhedron.signed_volume(far, mesh.triangles))
            expected.append(trimesh.volume(far - offset, mesh.triangles))
            offsets.append(f"{distance:.0e} m")
            moves.append(offset)
    return Comparison(measured, expected, expected, offsets, inputs={"moved by [m]": moves})


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
    """The inertia of a box is the closed form, and that of its mesh."""
    from references import analytic, printed, trimesh

    rng = run.fresh_rng()
    measured, expected, wrong, judges, boxes = [], [], [], [], []
    for _ in range(run.count(10, 100, 1000)):
        size, mass = rng.uniform(0.1, 3.0, 3), rng.uniform(0.1, 10.0)
        mesh = softbody.box(size)
        core = np.array(core_box.box_inertia(tuple(size), mass))
        for judge, answer in (
            ("closed form", analytic.box_inertia(size, mass)),
            ("trimesh", np.diag(trimesh.inertia(mesh.vertices, mesh.triangles, mass))),
        ):
            measured.append(core)
            expected.append(answer)
            wrong.append(printed.box_inertia_other_order(size, mass))
            judges.append(judge)
            boxes.append([*size, mass])
    scale = np.linalg.norm(expected, axis=1)
    inputs = {"size [m], mass [kg]": boxes}
    return Comparison(np.array(measured), np.array(expected), scale, judges, np.array(wrong), inputs=inputs)


@check(
    section="2.3, 10.4",
    piece="softbody.geometry.polyhedron.signed_volume",
    reference="closed form of the faceted torus",
    kind="closed form",
    tolerance=2e-14,
    because="vertices up to 9 m from the origin are rounded to 1e-15 m before the volume is taken",
    faults=(VOLUME,),
    erratum=Misprint("E6", "signed determinant, then signed again by a·n", "the determinant's own sign, once"),
)
def volume_does_not_depend_on_the_origin(run: Run) -> Comparison:
    """The signed volume of a mesh is the same wherever the origin is."""
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
    """The volume of a tetrahedron is a sixth of the determinant of its edges, with the sign of how it is turned."""
    corners = run.fresh_rng().integers(-100, 101, (run.count(300, 3_000, 30_000), 4, 3))
    measured = [
        tetrahedron.tetrahedron_volume(*(tuple(corner) for corner in each)) for each in corners.astype(float).tolist()
    ]
    edges = (corners[:, 1:] - corners[:, :1]).astype(object)
    (a, b, c), (d, e, f), (g, h, i) = edges.transpose(1, 2, 0)
    six = a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g)  # Python's integers
    return Comparison(measured, [float(Fraction(each, 6)) for each in six])
