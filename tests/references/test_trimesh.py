import numpy as np
import pytest
import trimesh as engine
from numpy.testing import assert_allclose

from references import analytic, exact, trimesh


@pytest.mark.parametrize("name", ["tetrahedron", "octahedron", "icosahedron"])
def test_the_volume_of_a_regular_solid_is_its_closed_form(name, cases):
    assert trimesh.volume(*cases.solid(name, 0.7)) == pytest.approx(analytic.regular_solid_volume(name, 0.7), rel=1e-14)


def test_volume_and_inertia_of_a_faceted_torus_are_their_closed_forms(cases):
    mesh = cases.torus(1.0, 0.4, 24, 12)
    assert trimesh.volume(*mesh) == pytest.approx(analytic.faceted_torus_volume(1.0, 0.4, 24, 12), rel=1e-13)
    want = np.diag(analytic.faceted_torus_inertia(1.0, 0.4, 24, 12, 3.0))
    assert_allclose(trimesh.inertia(*mesh, 3.0), want, atol=1e-12)


def test_a_cube_measures_what_a_cube_measures(cases):
    vertices, triangles = cases.cube()
    vertices = vertices * [1.0, 2.0, 3.0]
    assert trimesh.volume(vertices, triangles) == pytest.approx(6.0, rel=1e-14)
    assert trimesh.area(vertices, triangles) == pytest.approx(22.0, rel=1e-14)
    assert_allclose(trimesh.centroid(vertices, triangles), [0.5, 1.0, 1.5], rtol=1e-14)
    assert_allclose(trimesh.inertia(vertices, triangles, 12.0), np.diag([13.0, 10.0, 5.0]), atol=1e-12)


def test_balls_and_rings_have_their_euler_characteristics(cases):
    vertices, triangles = cases.solid("octahedron", 1.0)
    assert trimesh.topology(vertices, triangles) == (True, True, 2)
    assert trimesh.topology(*cases.torus(1.0, 0.4, 12, 8)) == (True, True, 0)
    assert trimesh.topology(vertices, triangles[1:])[0] is False
    triangles[0] = triangles[0, ::-1]
    assert trimesh.topology(vertices, triangles)[1] is False


def test_the_centroid_is_that_of_the_solid_not_of_its_surface_or_vertices():
    corner = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0.5)], float)
    triangles = np.array([(0, 2, 1), (0, 1, 4), (4, 1, 3), (0, 4, 2), (4, 3, 2), (1, 2, 3)])
    assert_allclose(trimesh.centroid(corner, triangles), [0.25, 0.25, 0.25], rtol=1e-14)


def test_a_tiny_mesh_is_not_merged_away(cases):
    vertices, triangles = cases.torus(1.0, 0.4, 12, 8)
    tiny = trimesh.volume(1e-9 * vertices, triangles)
    assert tiny == pytest.approx(1e-27 * trimesh.volume(vertices, triangles), rel=1e-12, abs=0.0)


def test_a_mesh_far_away_measures_the_same(cases):
    vertices, triangles = cases.torus(1.0, 0.4, 12, 8)
    away = np.array([1e6, -2e6, 3e6])
    far = vertices + away
    here = far - away  # what is left of the vertices after rounding
    assert trimesh.volume(far, triangles) == pytest.approx(trimesh.volume(here, triangles), rel=1e-12)
    assert_allclose(trimesh.inertia(far, triangles, 1.0), trimesh.inertia(here, triangles, 1.0), atol=1e-12)
    assert_allclose(trimesh.centroid(far, triangles), away, atol=1e-8)


def test_a_mesh_inside_out_has_a_negative_volume(cases):
    vertices, triangles = cases.cube()
    assert trimesh.volume(vertices, triangles[:, ::-1]) == pytest.approx(-1.0, rel=1e-14)


def test_the_mesh_is_measured_as_given_unused_and_doubled_vertices_included(cases):
    vertices, triangles = cases.cube()
    soup = vertices[triangles].reshape(-1, 3)
    assert trimesh.volume(soup, np.arange(36).reshape(-1, 3)) == pytest.approx(1.0, rel=1e-14)
    assert trimesh.centroid(np.concatenate([vertices, [(9, 9, 9)]]), triangles) == pytest.approx([0.5] * 3, rel=1e-13)


def test_points_are_inside_where_integers_say_so(cases, rng):
    mesh = cases.torus(1.0, 0.4, 16, 8)
    points = rng.uniform(-1.5, 1.5, (400, 3))
    inside = exact.points_in_mesh(points, *mesh) > 0
    assert 20 < inside.sum() < 200
    assert np.array_equal(trimesh.points_in_mesh(points, *mesh), inside)


def test_points_in_a_mesh_far_away_are_found(cases):
    vertices, triangles = cases.cube()
    assert trimesh.points_in_mesh([(100.5, 0.5, 0.5), (0.5, 0.5, 0.5)], vertices + [100, 0, 0], triangles).tolist() == [
        True,
        False,
    ]


def test_points_are_judged_rightly_down_to_the_margin(cases):
    vertices, triangles = cases.torus(1.0, 0.4, 16, 8)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    n = np.cross(b - a, c - a)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    middle = 0.3 * a + 0.3 * b + 0.4 * c
    assert not trimesh.points_in_mesh(middle + trimesh.MARGIN * n, vertices, triangles).any()
    assert trimesh.points_in_mesh(middle - trimesh.MARGIN * n, vertices, triangles).all()


def test_the_ray_engine_is_not_embree():
    assert trimesh.RayMeshIntersector.__module__ == "trimesh.ray.ray_triangle"


STL = """solid tetrahedron
facet normal 0 0 -1
outer loop
vertex 0 0 0
vertex 0 1 0
vertex 1 0 0
endloop
endfacet
facet normal 0 -1 0
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 0 1
endloop
endfacet
facet normal -1 0 0
outer loop
vertex 0 0 0
vertex 0 0 1
vertex 0 1 0
endloop
endfacet
facet normal 1 1 1
outer loop
vertex 1 0 0
vertex 0 1 0
vertex 0 0 1
endloop
endfacet
endsolid tetrahedron
"""


def test_an_stl_file_becomes_a_mesh_with_each_vertex_once(tmp_path):
    (tmp_path / "t.stl").write_text(STL)
    vertices, triangles = trimesh.load_mesh(tmp_path / "t.stl")
    assert vertices.tolist() == [[0, 0, 0], [0, 1, 0], [1, 0, 0], [0, 0, 1]]  # as they first appear
    assert triangles.tolist() == [[0, 1, 2], [0, 2, 3], [0, 3, 1], [2, 1, 3]]


def test_an_obj_file_with_normals_along_a_seam_is_merged(tmp_path):
    lines = ["v 0 0 0", "v 0 1 0", "v 1 0 0", "v 0 0 1", "vn 0 0 -1", "vn 0 -1 0", "vn -1 0 0", "vn 1 1 1"]
    faces = ["f 1//1 2//1 3//1", "f 1//2 3//2 4//2", "f 1//3 4//3 2//3", "f 3//4 2//4 4//4"]
    (tmp_path / "t.obj").write_text("\n".join(lines + faces) + "\n")
    vertices, triangles = trimesh.load_mesh(tmp_path / "t.obj")
    assert len(vertices) == 4
    assert trimesh.volume(vertices, triangles) == pytest.approx(1 / 6, rel=1e-14)


@pytest.mark.parametrize("extension", ["stl", "obj", "ply", "glb"])
def test_a_mesh_survives_the_file(extension, cases, tmp_path):
    vertices, triangles = cases.torus(1.0, 0.4, 12, 8)
    path = tmp_path / f"torus.{extension}"
    engine.Trimesh(vertices, triangles, process=False).export(path)
    got_vertices, got_triangles = trimesh.load_mesh(path)
    assert got_vertices.shape == vertices.shape
    assert_allclose(got_vertices[got_triangles], vertices[triangles], atol=2e-7)  # STL, PLY and GLB hold float32


def test_the_bodies_of_a_scene_keep_their_places(tmp_path, cases):
    cube = engine.Trimesh(*cases.cube(), process=False)
    scene = engine.Scene()
    scene.add_geometry(cube)
    scene.add_geometry(cube, transform=engine.transformations.translation_matrix([5, 0, 0]))
    scene.export(tmp_path / "two.glb")
    vertices, triangles = trimesh.load_mesh(tmp_path / "two.glb")
    assert len(vertices) == 16
    assert trimesh.volume(vertices, triangles) == pytest.approx(2.0, rel=1e-6)
    assert_allclose(trimesh.centroid(vertices, triangles), [3.0, 0.5, 0.5], rtol=1e-6)


def test_embree_finds_points_beyond_its_margin(cases, rng):
    vertices, triangles = cases.torus(1.0, 0.4, 16, 10)
    points = rng.uniform(-1.5, 1.5, (300, 3)) * [1.0, 1.0, 0.4]
    inside = exact.points_in_mesh(points, vertices, triangles) > 0
    assert np.array_equal(trimesh.points_in_mesh_by_embree(points, vertices, triangles), inside)


def test_the_closest_points_of_a_cube_are_on_its_faces(cases):
    vertices, triangles = cases.cube()
    distance, _, point = trimesh.closest_points(np.array([[0.5, 0.4, 0.75], [2.0, 2.0, 1.0]]), vertices, triangles)
    assert_allclose(distance, [0.25, 2**0.5], rtol=1e-12)
    assert_allclose(point, [[0.5, 0.4, 1.0], [1.0, 1.0, 1.0]], atol=1e-12)


def test_answers_about_points_in_doubt_are_the_same_every_time(cases):
    vertices, triangles = cases.torus(1.0, 0.4, 16, 8)
    points = np.concatenate([vertices, vertices + [0.0, 0.0, 0.3], 0.5 * (vertices + np.roll(vertices, 1, axis=0))])
    first = trimesh.points_in_mesh(points, vertices, triangles)
    for _ in range(5):
        assert (trimesh.points_in_mesh(points, vertices, triangles) == first).all()


def test_a_mesh_is_scaled_before_it_is_moved(cases):
    vertices, triangles = cases.cube()
    moved, volume, centroid = trimesh.scaled_and_moved(vertices, triangles, 2.0, np.array([1.0, 0.0, 0.0]))
    assert_allclose(moved, 2.0 * vertices + [1.0, 0.0, 0.0])
    assert volume == pytest.approx(8.0)
    assert_allclose(centroid, [2.0, 1.0, 1.0])


def test_an_icosphere_is_on_its_sphere_and_nearly_fills_it():
    vertices, triangles = trimesh.icosphere(4, 2.0)
    assert len(vertices) == 10 * 4**4 + 2
    assert_allclose(np.linalg.norm(vertices, axis=1), 2.0, rtol=1e-13)
    assert 0.99 < trimesh.volume(vertices, triangles) / (4.0 / 3.0 * np.pi * 8.0) < 1.0


def test_the_first_surface_that_a_ray_meets(cases):
    vertices, triangles = cases.cube()
    near, far = (0.3 * vertices, triangles), (3.0 * vertices + [1.0, 5.0, 0.0], triangles)
    rays = np.array([(0.1, 1.0, 0.1), (0.25, 1.0, 0.05), (0.5, 1.0, 0.2), (0.0, -1.0, 0.0)])
    assert trimesh.first_met(np.array([0.0, -1.0, 0.0]), rays, [far, near]).tolist() == [1, 1, 0, -1]


def test_a_corner_an_edge_or_the_face_is_closest():
    corners = np.broadcast_to([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)], (3, 3, 3))
    points = np.array([(-1.0, -1.0, 1.0), (0.5, -1.0, 0.0), (0.2, 0.2, 3.0)])
    assert_allclose(trimesh.closest_on_triangles(points, corners), [(0, 0, 0), (0.5, 0, 0), (0.2, 0.2, 0)], atol=1e-15)


def test_loose_triangles_are_merged_again(cases):
    whole, loose, (vertices, triangles) = trimesh.cut_apart_and_merged(*cases.cube())
    assert (len(whole.vertices), len(loose.vertices), len(vertices)) == (8, 36, 8)
    assert trimesh.volume(vertices, triangles) == pytest.approx(1.0)
