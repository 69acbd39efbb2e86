"""Does the separating-axis test of convex meshes find overlap, depth and normal, as the test of boxes does?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

import softbody
from softbody import MeshError
from softbody.collision.boxes.sat_boxes import PlacedBox, box_box_separation
from softbody.collision.sat_convex import Convex, convex, convex_pairs_separation, convex_separation, placed
from tests.softbody.placed_boxes import REST, quaternions

CUBE = softbody.box((1.0, 1.0, 1.0))

places = st.tuples(*[st.floats(-1.5, 1.5)] * 3)
sizes = st.tuples(*[st.floats(0.2, 2.0)] * 3)


def shape(mesh):
    return convex(mesh.vertices, mesh.triangles)


def hull(seed, count=8):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    found = ConvexHull(points)
    triangles = found.simplices.copy()
    for t, (i, j, k) in enumerate(triangles):
        if np.cross(points[j] - points[i], points[k] - points[i]) @ found.equations[t, :3] < 0.0:
            triangles[t] = i, k, j
    return convex(points, triangles)


def at(body, position, orientation=REST):
    return placed(body, tuple(map(float, position)), orientation)


@given(sizes, sizes, places, quaternions, quaternions, st.booleans())
def test_boxes_as_meshes_are_parted_as_boxes_are(size_a, size_b, place, turn_a, turn_b, paper):
    a, b = (shape(softbody.box(size)) for size in (size_a, size_b))
    found = convex_separation(at(a, (0, 0, 0), turn_a), at(b, place, turn_b), paper)
    expected = box_box_separation(PlacedBox(size_a, (0.0, 0.0, 0.0), turn_a), PlacedBox(size_b, place, turn_b), paper)
    assert found[0] == pytest.approx(expected[0], rel=3e-9, abs=1e-12)


def test_a_box_has_three_normals_and_three_edges():
    cube = shape(CUBE)
    assert len(cube.normals) == 3
    assert len(cube.edges) == 3  # the diagonals of its faces are none
    assert len(cube.vertices) == 8


@given(st.integers(0, 200), st.integers(0, 200), places, quaternions)
def test_moving_a_by_the_depth_along_the_normal_just_parts_them(seed_a, seed_b, place, turn):
    a, b = hull(seed_a), at(hull(seed_b), place, turn)
    separation, normal, _ = convex_separation(at(a, (0, 0, 0)), b)
    assert np.linalg.norm(normal) == pytest.approx(1.0, rel=1e-14)
    if separation < 0.0:
        parted = at(a, np.multiply(-separation * (1 + 1e-12), normal))
        assert convex_separation(parted, b)[0] == pytest.approx(0.0, abs=1e-11)
        assert convex_separation(at(a, np.multiply(-0.99 * separation, normal)), b)[0] < 0.0


@given(st.integers(0, 200), st.integers(0, 200), places)
def test_the_papers_axes_never_miss_a_hit_and_order_does_not_matter(seed_a, seed_b, place):
    a, b = at(hull(seed_a), (0, 0, 0)), at(hull(seed_b), place)
    complete = convex_separation(a, b)[0]
    assert convex_separation(a, b, True)[0] <= complete
    assert convex_separation(b, a)[0] == pytest.approx(complete, abs=1e-13)


def test_the_normal_points_from_b_to_a():
    cube = shape(CUBE)
    for x in (0.9, -0.9):
        separation, normal, _ = convex_separation(at(cube, (x, 0.2, 0.1)), at(cube, (0, 0, 0)))
        assert separation == pytest.approx(-0.1, abs=1e-15)
        assert normal == (np.sign(x), 0.0, 0.0)


def test_two_that_just_touch_have_a_separation_of_zero():
    cube = shape(CUBE)
    assert convex_separation(at(cube, (1.0, 0.25, 0.5)), at(cube, (0, 0, 0)))[0] == 0.0
    assert convex_separation(at(cube, (1.0, 1.0, 1.0)), at(cube, (0, 0, 0)))[0] == 0.0


def test_far_from_the_origin_nothing_is_lost():
    ball = shape(softbody.octahedron())
    near = convex_separation(at(ball, (1.5, 0.25, 0.125)), at(ball, (0, 0, 0)))
    far = convex_separation(at(ball, (1e6 + 1.5, 0.25, 0.125)), at(ball, (1e6, 0, 0)))
    assert far[0] == pytest.approx(near[0], abs=1e-15)


def test_many_poses_at_once_are_each_as_alone():
    rng = np.random.default_rng(0)
    a, b = hull(1), hull(2)
    p, q = rng.normal(size=(5, 3)), rng.normal(size=(5, 3))
    u, v = (x / np.linalg.norm(x, axis=1, keepdims=True) for x in rng.normal(size=(2, 5, 4)))
    separations, normals = convex_pairs_separation(a, p, u, b, q, v)
    for i in range(5):
        one = convex_separation(placed(a, tuple(p[i]), tuple(u[i])), placed(b, tuple(q[i]), tuple(v[i])))
        assert (separations[i], tuple(normals[i])) == one[:2]


def test_triangles_without_area_and_unused_vertices_are_passed_over():
    vertices = np.vstack([CUBE.vertices, [[9.0, 9.0, 9.0]]])
    found = convex(vertices, np.vstack([CUBE.triangles, [[0, 0, 1]]]))
    assert isinstance(found, Convex)
    assert len(found.normals) == 3
    assert len(found.vertices) == 8


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        (softbody.torus(), "stands .* m out over triangle .* not convex"),
        (np.ascontiguousarray(CUBE.triangles[:, ::-1]), "inside out"),
        (CUBE.triangles * 0, "no triangle has an area"),
    ],
)
def test_a_mesh_that_is_not_convex_is_refused(mesh, message):
    vertices, triangles = (mesh.vertices, mesh.triangles) if hasattr(mesh, "vertices") else (CUBE.vertices, mesh)
    with pytest.raises(MeshError, match=message):
        convex(vertices, triangles)
