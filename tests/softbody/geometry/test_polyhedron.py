"""Are the measures of a mesh invariant as they must be, and is a point in it also where rays meet its edges?"""

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import softbody
from softbody.geometry.polyhedron import (
    centroid,
    inertia_tensor,
    point_in_convex,
    point_in_polyhedron,
    points_in_polyhedron,
    signed_volume,
    surface_area,
)

BALL = softbody.icosphere(2)
TORUS = softbody.torus(1.0, 0.4, 12, 8)
BRICK = softbody.box((1.0, 2.0, 3.0))
# A box with one corner pushed in: no symmetry, not convex.
DENT = softbody.Mesh(
    np.where(np.arange(8)[:, None] == 7, BRICK.vertices * 0.2, BRICK.vertices) + [0.3, -0.2, 0.1], BRICK.triangles
)

meshes = st.sampled_from([BALL, TORUS, DENT])
rotations = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(lambda r: Rotation.from_rotvec(r).as_matrix())
offsets = st.tuples(*[st.floats(-5.0, 5.0)] * 3).map(np.array)


def measures(vertices, triangles):
    v = np.ascontiguousarray(vertices)
    return (
        signed_volume(v, triangles),
        surface_area(v, triangles),
        np.array(centroid(v, triangles)),
        inertia_tensor(v, triangles, 3.0),
    )


@given(meshes, rotations, offsets)
def test_rotation_and_translation_move_the_centroid_turn_the_inertia_and_leave_the_rest(mesh, R, offset):
    volume, area, middle, inertia = measures(mesh.vertices, mesh.triangles)
    moved = measures(mesh.vertices @ R.T + offset, mesh.triangles)
    assert moved[0] == pytest.approx(volume, rel=1e-12)
    assert moved[1] == pytest.approx(area, rel=1e-12)
    assert moved[2] == pytest.approx(R @ middle + offset, abs=1e-12)
    assert moved[3] == pytest.approx(R @ inertia @ R.T, abs=1e-11)


@given(meshes, st.floats(1e-3, 1e3))
def test_scaling_by_s_scales_volume_area_centroid_and_inertia_by_s3_s2_s_s2(mesh, s):
    volume, area, middle, inertia = measures(mesh.vertices, mesh.triangles)
    scaled = measures(s * mesh.vertices, mesh.triangles)
    assert scaled[0] == pytest.approx(s**3 * volume, rel=1e-12)
    assert scaled[1] == pytest.approx(s**2 * area, rel=1e-12)
    assert scaled[2] == pytest.approx(s * middle, abs=1e-12 * s)
    assert scaled[3] == pytest.approx(s**2 * inertia, abs=1e-12 * s**2)


def test_turning_every_triangle_over_flips_the_sign_of_the_volume():
    reverse = np.ascontiguousarray(DENT.triangles[:, ::-1])
    assert signed_volume(DENT.vertices, reverse) == pytest.approx(-DENT.volume, rel=1e-14)


def test_a_fine_sphere_measures_like_a_sphere():
    ball = softbody.icosphere(4)
    volume, area, middle, inertia = measures(ball.vertices, ball.triangles)
    assert volume == pytest.approx(4 / 3 * pi, rel=3e-3)
    assert area == pytest.approx(4 * pi, rel=3e-3)
    assert middle == pytest.approx(np.zeros(3), abs=1e-14)
    assert inertia == pytest.approx(0.4 * 3.0 * np.eye(3), abs=5e-3)


def winding_number(p, vertices, triangles):
    """Solid angle of the mesh as seen from p over 4π: 1 inside, 0 outside (Van Oosterom and Strackee 1983)."""
    a, b, c = (vertices[triangles[:, k]] - p for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    determinant = np.einsum("ij,ij->i", a, np.cross(b, c))
    divisor = (
        la * lb * lc
        + np.einsum("ij,ij->i", a, b) * lc
        + np.einsum("ij,ij->i", b, c) * la
        + np.einsum("ij,ij->i", c, a) * lb
    )
    return np.arctan2(determinant, divisor).sum() / (2.0 * pi)


def wound(points, vertices, triangles):
    return np.array([winding_number(p, vertices, triangles) > 0.5 for p in points])


@given(meshes, rotations, st.integers(0, 1000))
def test_random_points_are_inside_where_the_winding_number_is_one(mesh, R, seed):
    vertices = np.ascontiguousarray(mesh.vertices @ R.T)
    points = np.random.default_rng(seed).uniform(-1.6, 1.6, (30, 3))
    inside = points_in_polyhedron(points, vertices, mesh.triangles)
    assert inside.tolist() == wound(points, vertices, mesh.triangles).tolist()


def clear_of_surface(points, mesh):
    """Points whose neighbours to all sides are all inside or all outside: those of the surface itself are neither."""
    nudges = 1e-6 * np.array([[0, 0, 0], [1, 2, 3], [-1, -2, -3], [2, -3, 1], [-2, 3, -1], [-3, 1, -2], [3, -1, 2]])
    answers = np.array([wound(points + nudge, mesh.vertices, mesh.triangles) for nudge in nudges])
    return points[(answers == answers[0]).all(axis=0)]


@pytest.mark.parametrize("mesh", [BALL, TORUS, DENT], ids=["ball", "torus", "dent"])
@pytest.mark.parametrize("shift", [-0.3, -0.1, -1e-3, 1e-3, 0.1, 0.3])
def test_a_ray_through_a_vertex_is_counted_right(mesh, shift):
    points = clear_of_surface(mesh.vertices + [0.0, 0.0, shift], mesh)
    assert len(points) > len(mesh.vertices) / 3
    inside = points_in_polyhedron(points, mesh.vertices, mesh.triangles)
    assert inside.tolist() == wound(points, mesh.vertices, mesh.triangles).tolist()


@pytest.mark.parametrize("mesh", [BALL, TORUS, DENT], ids=["ball", "torus", "dent"])
@pytest.mark.parametrize("shift", [-0.2, 0.2])
def test_a_ray_through_the_middle_of_an_edge_is_counted_right(mesh, shift):
    points = clear_of_surface(mesh.vertices[mesh.edges].mean(axis=1) + [0.0, 0.0, shift], mesh)
    assert len(points) > len(mesh.edges) / 3
    inside = points_in_polyhedron(points, mesh.vertices, mesh.triangles)
    assert inside.tolist() == wound(points, mesh.vertices, mesh.triangles).tolist()


@pytest.mark.parametrize("segments", [1, 2, 4])
def test_a_grid_of_points_under_the_edges_and_diagonals_of_a_box_is_judged_right(segments):
    cube = softbody.box((2.0, 2.0, 2.0), segments)
    line = np.linspace(-1.5, 1.5, 13)  # steps of a quarter: the faces at ±1, edges and diagonals are met exactly
    points = np.stack(np.meshgrid(line, line, line), axis=-1).reshape(-1, 3)
    reach = np.abs(points).max(axis=1)
    points, reach = points[reach != 1.0], reach[reach != 1.0]
    inside = points_in_polyhedron(points, cube.vertices, cube.triangles)
    assert inside.tolist() == (reach < 1.0).tolist()


def test_every_point_next_to_the_wall_of_a_stacked_copy_is_judged_right():
    """The paper's stack of identical bodies: each vertex of one exactly above a vertex of the other."""
    upper = clear_of_surface(BALL.vertices + [0.0, 0.0, 1.5], BALL)
    inside = points_in_polyhedron(upper, BALL.vertices, BALL.triangles)
    assert inside.any()
    assert inside.tolist() == wound(upper, BALL.vertices, BALL.triangles).tolist()


def test_the_hole_of_a_torus_is_outside():
    assert not point_in_polyhedron((0.0, 0.0, 0.0), TORUS.vertices, TORUS.triangles)
    assert not point_in_polyhedron((0.0, 0.0, -2.0), TORUS.vertices, TORUS.triangles)
    assert point_in_polyhedron((1.0, 0.0, 0.0), TORUS.vertices, TORUS.triangles)
    assert not point_in_polyhedron((1.0, 0.0, -0.5), TORUS.vertices, TORUS.triangles)


def test_a_point_of_the_surface_gets_the_same_answer_every_time():
    for p in BRICK.vertices.tolist() + [[0.5, 0.0, 0.0], [0.0, 0.0, 1.5], [0.0, -1.0, 0.0]]:
        answers = {point_in_polyhedron(tuple(p), BRICK.vertices, BRICK.triangles) for _ in range(3)}
        assert len(answers) == 1


@pytest.mark.parametrize(
    ("p", "inside", "axis", "side", "depth"),
    [
        ((0.4, 0.0, 0.0), True, 0, 0.5, 0.1),
        ((-0.45, 0.2, 0.3), True, 0, -0.5, 0.05),
        ((0.1, 0.9, 0.2), True, 1, 1.0, 0.1),
        ((0.1, 0.2, -1.3), True, 2, -1.5, 0.2),
        ((0.5, 0.3, 0.2), True, 0, 0.5, 0.0),
        ((0.75, 0.0, 0.0), False, 0, 0.5, -0.25),
        ((0.6, 3.0, 0.0), False, 1, 1.0, -2.0),
    ],
)
def test_point_in_convex_names_the_closest_face_of_a_box_and_the_depth_behind_it(p, inside, axis, side, depth):
    found, face, behind = point_in_convex(p, BRICK.vertices, BRICK.triangles)
    assert found is inside
    assert BRICK.vertices[BRICK.triangles[face], axis].tolist() == [side] * 3
    assert behind == pytest.approx(depth, abs=1e-15)


@given(rotations, st.integers(0, 1000))
def test_in_a_convex_mesh_both_tests_agree(R, seed):
    vertices = np.ascontiguousarray(BALL.vertices @ R.T)
    for p in np.random.default_rng(seed).uniform(-1.1, 1.1, (20, 3)):
        point = tuple(p.tolist())
        assert point_in_convex(point, vertices, BALL.triangles)[0] == point_in_polyhedron(
            point, vertices, BALL.triangles
        )


def test_a_triangle_without_area_is_no_face_of_a_convex_mesh():
    triangles = np.vstack([[[0, 0, 1]], BRICK.triangles])
    inside, face, depth = point_in_convex((0.4, 0.0, 0.0), BRICK.vertices, triangles)
    assert (inside, face > 0, depth) == (True, True, pytest.approx(0.1))
    assert point_in_convex((0.0, 0.0, 0.0), BRICK.vertices, triangles[:1])[:2] == (False, -1)
