"""Are the shapes what they say, and does Mesh refuse everything that is not a closed solid?"""

import copy
import pickle
from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import softbody
from softbody import Mesh, MeshError, ParameterError

SOLID = softbody.tetrahedron()
V, T = SOLID.vertices, SOLID.triangles

SHAPES = {
    "tetrahedron": (softbody.tetrahedron(), 4, 4),
    "octahedron": (softbody.octahedron(), 6, 8),
    "icosahedron": (softbody.icosahedron(), 12, 20),
    "icosphere 0": (softbody.icosphere(0), 12, 20),
    "icosphere 1": (softbody.icosphere(1), 42, 80),
    "icosphere 3": (softbody.icosphere(3), 642, 1280),
    "torus": (softbody.torus(1.0, 0.4, 12, 7), 84, 168),
    "smallest torus": (softbody.torus(1.0, 0.4, 3, 3), 9, 18),
    "box": (softbody.box((1.0, 2.0, 3.0)), 8, 12),
    "box of 3 segments": (softbody.box((1.0, 2.0, 3.0), 3), 56, 108),
}
shapes = pytest.mark.parametrize(("mesh", "vertices", "triangles"), SHAPES.values(), ids=SHAPES.keys())


@shapes
def test_a_shape_has_its_known_number_of_vertices_triangles_and_edges(mesh, vertices, triangles):
    assert mesh.vertices.shape == (vertices, 3)
    assert mesh.triangles.shape == (triangles, 3)
    assert mesh.edges.shape == (3 * triangles // 2, 2)


@shapes
def test_a_shape_is_closed_and_oriented(mesh, vertices, triangles):
    directed = [(int(t[k]), int(t[(k + 1) % 3])) for t in mesh.triangles for k in range(3)]
    assert len(set(directed)) == len(directed)
    assert {(j, i) for i, j in directed} == set(directed)
    assert mesh.volume > 0.0


@shapes
def test_a_shape_is_centred_on_the_origin(mesh, vertices, triangles):
    assert mesh.vertices.mean(axis=0) == pytest.approx(np.zeros(3), abs=1e-14)


@shapes
def test_arrays_are_contiguous_float64_and_int64(mesh, vertices, triangles):
    assert (mesh.vertices.dtype, mesh.triangles.dtype) == (np.float64, np.int64)
    assert mesh.vertices.flags.c_contiguous
    assert mesh.triangles.flags.c_contiguous


@pytest.mark.parametrize("segments", [1, 4])
def test_a_box_reaches_half_its_size_each_way(segments):
    points = softbody.box((1.0, 2.0, 3.0), segments).vertices
    assert points.min(axis=0).tolist() == [-0.5, -1.0, -1.5]
    assert points.max(axis=0).tolist() == [0.5, 1.0, 1.5]


def test_every_vertex_of_an_icosphere_lies_on_the_sphere():
    radii = np.linalg.norm(softbody.icosphere(3, 2.0).vertices, axis=1)
    assert radii == pytest.approx(np.full(642, 2.0), rel=1e-15)


def test_each_subdivision_quarters_what_an_icosphere_lacks_of_the_sphere():
    lack = [4 / 3 * pi - softbody.icosphere(s).volume for s in (2, 3, 4)]
    assert lack[0] / lack[1] == pytest.approx(4.0, rel=0.05)
    assert lack[1] / lack[2] == pytest.approx(4.0, rel=0.02)


def test_every_vertex_of_a_torus_is_a_minor_radius_from_the_ring():
    points = softbody.torus(2.0, 0.5, 9, 5).vertices
    ring = np.hypot(points[:, 0], points[:, 1]) - 2.0
    assert np.hypot(ring, points[:, 2]) == pytest.approx(np.full(45, 0.5), rel=1e-14)


def test_edges_are_sorted_and_unique():
    assert SOLID.edges.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]


def test_moving_and_scaling_leave_the_mesh_itself_alone():
    moved, larger = SOLID.moved((1.0, 2.0, 3.0)), SOLID.scaled(2.0)
    assert moved.vertices == pytest.approx(V + [1.0, 2.0, 3.0])
    assert larger.volume == pytest.approx(8.0 * SOLID.volume, rel=1e-14)
    assert SOLID.volume == pytest.approx(8 * sqrt(3) / 27, rel=1e-14)


def test_a_mesh_keeps_its_own_copy_of_the_arrays():
    vertices, triangles = V.copy(), T.copy()
    mesh = Mesh(vertices, triangles)
    vertices[:], triangles[:] = np.nan, 10**9
    assert mesh.volume == SOLID.volume


@pytest.mark.parametrize(
    ("vertices", "triangles"),
    [
        (V.tolist(), T.tolist()),
        (V.astype(np.float32), T.astype(np.uint8)),
        (np.asfortranarray(V), np.asfortranarray(T)),
        (V, T.astype(float)),
        (V.astype(object), T.astype(object)),
        (np.repeat(V, 2, axis=0)[::2], T),
    ],
    ids=["lists", "small types", "Fortran order", "whole floats", "objects", "strided"],
)
def test_any_array_of_numbers_will_do(vertices, triangles):
    assert Mesh(vertices, triangles).volume == pytest.approx(SOLID.volume, rel=1e-6)


def test_two_separate_solids_and_a_hollow_one_are_meshes():
    def both(a, b, flip):
        faces = b.triangles[:, ::-1] if flip else b.triangles
        return Mesh(np.vstack([a.vertices, b.vertices]), np.vstack([a.triangles, faces + len(a.vertices)]))

    assert both(SOLID, SOLID.moved((9.0, 0.0, 0.0)), flip=False).volume == pytest.approx(2 * SOLID.volume)
    assert both(SOLID.scaled(3.0), SOLID, flip=True).volume == pytest.approx(26 * SOLID.volume)


def changed(array, row, value):
    array = array.copy() if isinstance(value, list) else array.astype(np.result_type(array, value))
    array[row] = value
    return array


FLAT = V * [1.0, 1.0, 0.0]
FIN = (np.vstack([V, [[3.0, 0.0, 0.0]]]), np.vstack([T, [[0, 1, 4]]]))


def on_one_line():
    """A box with the middle of an edge added to it: the triangle of those three points has no area."""
    solid = softbody.box()
    i, j, k = (int(c) for c in solid.triangles[0])
    points = np.vstack([solid.vertices, [(solid.vertices[i] + solid.vertices[j]) / 2]])
    return points, np.vstack([solid.triangles[1:], [[i, j, 8], [i, 8, k], [8, j, k]][1:], [[i, j, 8]]])


DEFECTS = {
    "hole": (V, T[1:], r"edge 0–1 is met by 1 triangle"),
    "single triangle": (V[:3], [[0, 1, 2]], r"edge 0–1 is met by 1 triangle"),
    "triangle twice": (V, np.vstack([T, T[:1]]), r"edge 0–1 is met by 3 triangle"),
    "fin on an edge": (*FIN, r"edge 0–1 is met by 3 triangle"),
    "mesh twice over": (V, np.vstack([T, T]), r"edge 0–1 is met by 4 triangle"),
    "one triangle flipped": (V, np.vstack([T[:3], T[3:, ::-1]]), r"edge 1–2 run along it the same way; flip one"),
    "inside out": (V, T[:, ::-1], r"inside out.*reverse every triangle"),
    "mirrored": (V * [-1.0, 1.0, 1.0], T, r"inside out.*reverse every triangle"),
    "repeated index": (V, changed(T, 2, [0, 2, 2]), r"triangle 2 is \[0 2 2\]: it repeats a vertex"),
    "index out of range": (V, changed(T, 3, [1, 3, 4]), r"triangle 3 is \[1 3 4\], but vertices run from 0 to 3"),
    "negative index": (V, changed(T, 1, [0, 3, -1]), r"triangle 1 is .*-1\], but vertices run from 0 to 3"),
    "huge index": (V, changed(T, 1, [0, 3, 2**62]), r"triangle 1 is .*, but vertices run from 0 to 3"),
    "huge unsigned index": (V, changed(T.astype(np.uint64), 1, [0, 3, 2**64 - 1]), r"triangle 1 is .* from 0 to 3"),
    "index beyond int64": (V, T.astype(object) * 10**30, r"triangle 0 has an index too large"),
    "huge float index": (V, T * 1e300, r"triangle 0 has an index too large"),
    "half index": (V, changed(T, 1, 0.5), r"triangle 1 is \[0.5 0.5 0.5\]: not whole numbers"),
    "NaN index": (V, changed(T, 2, np.nan), r"triangle 2 is \[nan nan nan\]: not whole numbers"),
    "infinite index": (V, changed(T, 2, np.inf), r"triangle 2 "),
    "NaN coordinate": (changed(V, 3, np.nan), T, r"vertex 3 is at \[nan nan nan\]: not finite"),
    "infinite coordinate": (changed(V, 1, np.inf), T, r"vertex 1 is at \[inf inf inf\]: not finite"),
    "coordinate that overflows float64": (V * np.longdouble("1e400"), T, r"vertex 0 is at .*inf.*: not finite"),
    "no coordinates": ([[None] * 3] * 4, T, r"vertex 0 is at \[nan nan nan\]: not finite"),
    "unused vertex": (np.vstack([V, [[9.0, 9.0, 9.0]]]), T, r"vertex 4 belongs to no triangle; remove it"),
    "no vertices": (np.empty((0, 3)), T, r"vertices are empty"),
    "no triangles": (V, np.empty((0, 3), int), r"triangles are empty"),
    "empty lists": ([], [], r"vertices have shape \(0,\)"),
    "vertices in a plane": (V[:, :2], T, r"vertices have shape \(4, 2\)"),
    "quads": (V, np.array([[0, 1, 2, 3]]), r"triangles have shape \(1, 4\)"),
    "one dimension": (V.ravel(), T, r"vertices have shape \(12,\)"),
    "three dimensions": (V, T[None], r"triangles have shape \(1, 4, 3\)"),
    "nothing": (None, None, r"vertices have shape \(\)"),
    "a number": (V, 3, r"triangles have shape \(\)"),
    "words": ([["a", "b", "c"]] * 4, T, r"vertices are not numbers"),
    "numbers as strings": (V.astype(str), T, r"vertices are not numbers"),
    "indices as strings": (V, T.astype(str), r"triangles are not numbers"),
    "ragged vertices": ([[0, 0, 0], [1, 0]], T, r"vertices are not numbers in rows of three"),
    "ragged triangles": (V, [[0, 1, 2], [1, 0]], r"triangles are not numbers in rows of three"),
    "complex": (V + 1j, T, r"vertices are not numbers"),
    "booleans": (V, T > 1, r"triangles are not numbers"),
    "objects": ([[object()] * 3] * 4, T, r"vertices are not numbers"),
    "dictionary": ({0: 1}, T, r"vertices are not numbers"),
    "dates": (V.astype("datetime64[s]"), T, r"vertices are not numbers"),
    "arrays swapped": (T, V, r"triangle 0 is .*: not whole numbers"),
    "vertices at one place": (changed(V, 2, V[1].tolist()), T, r"edge 1–2 has no length.*merge them"),
    "all vertices at one place": (np.ones((4, 3)), T, r"edge 0–1 has no length.*merge them"),
    "triangle on a line": (*on_one_line(), r"triangle 13 \(\[.*\]\) has no area"),
    "flat": (FLAT, T, r"encloses no volume: it is flat"),
    "two sides of one triangle": (V[:3], [[0, 1, 2], [2, 1, 0]], r"encloses no volume: it is flat"),
    "coordinates near overflow": (V * 1e308, T, r"vertex 1 is .* too far to compute a volume; scale the mesh down"),
    "one vertex far away": (changed(V, 2, 1e300), T, r"vertex 2 is 1e\+300 m away"),
    "volume that overflows": (V * 1e110, T, r"vertex 1 is .* too far to compute a volume"),
    "volume that underflows": (V * 1e-110, T, r"too small to compute a volume; scale it up"),
}


@pytest.mark.parametrize(("vertices", "triangles", "message"), DEFECTS.values(), ids=DEFECTS.keys())
@pytest.mark.filterwarnings("error")
def test_a_defective_mesh_is_refused_by_name(vertices, triangles, message):
    with pytest.raises(MeshError, match=message):
        Mesh(vertices, triangles)


@given(st.lists(st.lists(st.integers(-1, 5), min_size=3, max_size=3), max_size=8))
def test_any_list_of_triples_is_either_a_closed_solid_or_a_mesh_error(triangles):
    vertices = softbody.octahedron().vertices
    try:
        mesh = Mesh(vertices, triangles)
    except MeshError:
        return
    assert mesh.volume > 0.0


@given(st.permutations(range(8)), st.lists(st.integers(0, 2), min_size=8, max_size=8))
def test_the_order_of_triangles_and_of_their_first_vertex_does_not_matter(order, turns):
    solid = softbody.octahedron()
    faces = np.array([np.roll(solid.triangles[t], turn) for t, turn in zip(order, turns)])
    assert Mesh(solid.vertices, faces).volume == pytest.approx(4 / 3, rel=1e-14)


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: softbody.tetrahedron(0.0), "radius"),
        (lambda: softbody.octahedron(-1.0), "radius"),
        (lambda: softbody.icosahedron(np.nan), "radius"),
        (lambda: softbody.icosphere(2, np.inf), "radius"),
        (lambda: softbody.icosphere(2, "1"), "radius"),
        (lambda: softbody.icosphere(-1), "subdivisions"),
        (lambda: softbody.icosphere(11), "subdivisions"),
        (lambda: softbody.icosphere(2.5), "subdivisions"),
        (lambda: softbody.torus(1.0, 0.0), "minor_radius"),
        (lambda: softbody.torus(1.0, 1.0), "major_radius"),
        (lambda: softbody.torus(np.inf, 0.4), "major_radius"),
        (lambda: softbody.torus(np.nan, 0.4), "major_radius"),
        (lambda: softbody.torus(major_segments=2), "major_segments"),
        (lambda: softbody.torus(minor_segments=2), "minor_segments"),
        (lambda: softbody.torus(minor_segments=3.5), "minor_segments"),
        (lambda: softbody.box((1.0, 1.0)), "size"),
        (lambda: softbody.box((1.0, 1.0, -1.0)), "size"),
        (lambda: softbody.box((1.0, 1.0, np.nan)), "size"),
        (lambda: softbody.box("large"), "size"),
        (lambda: softbody.box(segments=0), "segments"),
        (lambda: softbody.box(segments=1.5), "segments"),
    ],
)
def test_a_shape_refuses_a_parameter_by_name(make, name):
    with pytest.raises(ParameterError, match=name):
        make()


def test_a_mesh_error_is_a_value_error_and_a_softbody_error():
    assert issubclass(MeshError, ValueError)
    assert issubclass(MeshError, softbody.SoftbodyError)


def test_what_was_checked_cannot_be_changed():
    vertices, triangles = V.copy(), T.copy()
    mesh = Mesh(vertices, triangles)
    triangles[0, 0], vertices[0] = 10**9, np.nan
    for one in (mesh, pickle.loads(pickle.dumps(mesh)), copy.deepcopy(mesh), copy.copy(mesh)):
        assert (one.vertices == V).all()
        assert (one.triangles == T).all()
        for array in (one.vertices, one.triangles):
            with pytest.raises(ValueError, match="read-only"):
                array[0, 0] = -1


def test_a_mesh_that_was_changed_by_force_is_checked_again_when_it_is_copied():
    mesh = softbody.tetrahedron()
    mesh.triangles.flags.writeable = True
    mesh.triangles[0, 0] = 10**9
    with pytest.raises(MeshError, match="triangle 0"):
        copy.deepcopy(mesh)
