"""The way out of a body: does it lead to the surface, and does the same triangle push back, whatever its number?"""

import numpy as np
import pytest

import softbody
from softbody.collision.soft.point_mesh import _across, way_out
from softbody.collision.soft.surface import Surface, _kind_of
from softbody.geometry import closest_triangle
from softbody.geometry.penetration import points_of
from softbody.model.surface_point import value_at

pytestmark = pytest.mark.interpreted


def surface_of(mesh):
    _, (triangles, _, _, _, _, ridges, wings, sides, touching) = _kind_of(mesh.vertices, mesh.triangles, mesh.edges)
    return Surface(0, ridges, wings, triangles, sides, touching, points_of(np.array(mesh.vertices)))


def way_from(p, mesh):
    triangle, weights, _ = closest_triangle(p, mesh.vertices, mesh.triangles)
    return way_out(p, surface_of(mesh), triangle, weights)


def renumbered(mesh, rng):
    order = rng.permutation(len(mesh.vertices))
    faces = np.argsort(order)[rng.permutation(mesh.triangles)]
    return softbody.Mesh(mesh.vertices[order], [np.roll(face, rng.integers(3)) for face in faces])


def dented(depth):
    """Return a cube whose upper face has a dent: five vertices, the middle one lower."""
    cube = softbody.box((2.0, 2.0, 2.0))
    top = [t for t in cube.triangles if (cube.vertices[t][:, 2] == 1.0).all()]
    corners = sorted({*top[0], *top[1]}, key=lambda v: np.arctan2(*cube.vertices[v][1::-1]))
    others = [t for t in cube.triangles if not (cube.vertices[t][:, 2] == 1.0).all()]
    fan = [[corners[k], corners[(k + 1) % 4], 8] for k in range(4)]
    return softbody.Mesh(np.vstack([cube.vertices, [[0.0, 0.0, 1.0 - depth]]]), [*others, *fan])


def test_neighbours_are_those_that_share_a_side():
    mesh = softbody.icosphere(1, 1.0)
    surface = surface_of(mesh)
    for t, corners in enumerate(mesh.triangles):
        for k in range(3):
            edge = surface.sides[t, k]
            other = _across(surface, t, k)
            assert other != t
            assert {corners[k], corners[(k + 1) % 3]} < set(mesh.triangles[other])
            if edge >= 0:
                assert surface.ridges[edge, :2].tolist() == [corners[k], corners[(k + 1) % 3]]
                assert surface.wings[edge].tolist() == [t, other]


def test_the_way_out_is_to_the_closest_point():
    mesh = softbody.torus(1.0, 0.4, 12, 8)
    rng = np.random.default_rng(1)
    for _ in range(50):
        angle, x, y = rng.uniform(-np.pi, np.pi), *rng.uniform(-0.2, 0.2, 2)
        p = ((1.0 + x) * np.cos(angle), (1.0 + x) * np.sin(angle), y)
        depth, normal, end = way_from(p, mesh)
        assert depth == pytest.approx(closest_triangle(p, mesh.vertices, mesh.triangles)[2])
        assert np.array(p) + depth * np.array(normal) == pytest.approx(np.array(value_at(mesh.vertices, end)))


def test_a_point_before_its_closest_triangle_has_no_way_out():
    assert way_from((0.0, 0.0, 1.5), softbody.box((2.0, 2.0, 2.0))).depth == 0.0


@pytest.mark.parametrize("p", [(0.03, 0.05, 0.3), (-0.04, -0.02, 0.2), (0.3, 0.05, 0.55)])
def test_the_triangle_that_faces_the_way_pushes_back_however_they_are_numbered(p):
    """From below a dent: to its lowest point, which four triangles share."""
    mesh, rng = dented(0.4), np.random.default_rng(2)
    way = way_from(p, mesh)
    assert way.depth > 0.0
    corners = {tuple(np.round(mesh.vertices[i], 9)) for i in way.end.particles}
    for _ in range(20):
        other = renumbered(mesh, rng)
        again = way_from(p, other)
        assert again.depth == pytest.approx(way.depth, rel=1e-12)
        assert {tuple(np.round(other.vertices[i], 9)) for i in again.end.particles} == corners
