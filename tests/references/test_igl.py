"""Is libigl asked rightly: inside or outside against integers, and distances against closed forms?"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from references import exact, igl


@pytest.mark.parametrize("judge", [igl.points_in_mesh, igl.points_in_mesh_by_distance, igl.points_in_mesh_fast])
def test_points_are_inside_where_integers_say_so(cases, rng, judge):
    vertices, triangles = cases.torus(1.0, 0.4, 16, 10)
    points = rng.uniform(-1.5, 1.5, (300, 3)) * [1.0, 1.0, 0.4]
    inside = exact.points_in_mesh(points, vertices, triangles) > 0
    assert 20 < inside.sum() < 280
    assert np.array_equal(judge(points, vertices, triangles), inside)


@pytest.mark.parametrize("judge", [igl.points_in_mesh, igl.points_in_mesh_by_distance])
def test_points_are_judged_rightly_down_to_the_margin(cases, judge):
    vertices, triangles = cases.cube()
    points = np.array([[0.3, 0.4, 5 * igl.MARGIN], [0.3, 0.4, -5 * igl.MARGIN]])
    assert judge(points, vertices, triangles).tolist() == [True, False]


def test_distances_triangles_and_points_are_those_of_a_cube(cases):
    vertices, triangles = cases.cube()
    points = np.array([[0.5, 0.25, 0.9], [2.0, 2.0, 1.0], [-3.0, 0.5, 0.25]])
    distance, triangle, point = igl.closest_points(points, vertices, triangles)
    assert_allclose(distance, [0.1, 2**0.5, 3.0], rtol=1e-14)
    assert_allclose(point, [[0.5, 0.25, 1.0], [1.0, 1.0, 1.0], [0.0, 0.5, 0.25]], atol=1e-15)
    assert (vertices[triangles[triangle[0]]][:, 2] == 1.0).all()


@pytest.mark.parametrize(
    ("kind", "as_text"), [("stl", True), ("stl", False), ("ply", False), ("obj", True), ("off", True)]
)
def test_files_of_trimesh_are_read_as_they_were_written(cases, tmp_path, kind, as_text):
    from references import trimesh

    vertices, triangles = cases.cube()
    trimesh.write_mesh(tmp_path / f"a.{kind}", 0.25 * vertices, triangles, as_text)
    found, faces = igl.read_mesh(tmp_path / f"a.{kind}")
    assert np.array_equal(found[faces], 0.25 * vertices[triangles])
