"""A plane cuts a surface: what is left is closed, in the right place, and of the right shape."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from softbody import box, icosphere, tetrahedron, torus
from softbody.errors import MeshError
from softbody.geometry.polyhedron import signed_volume
from softbody.geometry.self_intersections import self_intersections
from softbody.mesh.mesh import check_surface, unique_edges
from softbody.mesh.section import BENDS, NEAREST, NOT, Plane, cut_surface, pieces_of

MESHES = {
    "ball": icosphere(2),
    "torus": torus(1.0, 0.4, 24, 12),
    "box": box((1.0, 1.2, 0.8), 4),
    "tetrahedron": tetrahedron(1.0),
}


def unit(direction):
    return np.asarray(direction, float) / np.linalg.norm(direction)


def plane(point, normal, radius=np.inf):
    return Plane(np.asarray(point, float), unit(normal), radius)


def check_pieces(cut, pieces):
    for rows in pieces:
        used, numbers = np.unique(cut.triangles[rows], return_inverse=True)
        check_surface(numbers.reshape(-1, 3), len(used))


@settings(max_examples=40, deadline=None)
@given(
    name=st.sampled_from(sorted(MESHES)),
    point=st.tuples(*[st.floats(-0.3, 0.3)] * 3),
    normal=st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda n: np.linalg.norm(n) > 0.1),
)
def test_pieces_are_closed_and_make_up_the_whole(name, point, normal):
    mesh = MESHES[name]
    cut = cut_surface(mesh.vertices, mesh.triangles, plane(point, normal), 0.2)
    if cut is None:
        return
    pieces = pieces_of(cut)
    check_pieces(cut, pieces)
    assert len(pieces) >= 2
    volumes = [signed_volume(cut.points, cut.triangles[rows]) for rows in pieces]
    assert min(volumes) > 0.0
    assert sum(volumes) == pytest.approx(mesh.volume, rel=1e-12)
    # Every old triangle is there, whole or in parts of its plane; caps are there twice, turned.
    assert (np.unique(cut.origin) == np.arange(NOT, len(mesh.triangles))).all()
    caps = np.sort(cut.points[cut.triangles[cut.origin == NOT]].sum(axis=1).round(9), axis=0)
    assert caps[::2] == pytest.approx(caps[1::2], abs=1e-8)


@settings(max_examples=30, deadline=None)
@given(name=st.sampled_from(sorted(MESHES)), seed=st.integers(0, 2**32 - 1))
def test_no_spring_is_shorter_than_a_part_of_its_edge(name, seed):
    mesh, rng = MESHES[name], np.random.default_rng(seed)
    cut = cut_surface(mesh.vertices, mesh.triangles, plane(0.2 * rng.normal(size=3), rng.normal(size=3)), 0.2)
    if cut is None:
        return
    between = cut.ends[:, 0] != cut.ends[:, 1]
    least = BENDS[-1]
    assert (cut.way[between] >= least).all()
    assert (cut.way[between] <= 1.0 - least).all()
    edges = unique_edges(cut.triangles)
    assert (np.linalg.norm(cut.points[edges[:, 0]] - cut.points[edges[:, 1]], axis=1) > 0.0).all()


def test_caps_do_not_go_through_the_surface():
    mesh, rng = box((1.0, 1.2, 0.8), 3), np.random.default_rng(0)
    points, shortest = mesh.vertices @ np.array([[1.0, 0.5, 0.0], [0.0, 1.0, 0.7], [0.0, 0.0, 1.0]]), []
    for _ in range(62):
        normal = unit(rng.normal(size=3))
        at = plane(normal * rng.uniform(*np.quantile(points @ normal, (0.1, 0.9))), normal)
        cut = cut_surface(points, mesh.triangles, at, 0.2)
        way = cut.way[cut.ends[:, 0] != cut.ends[:, 1]]
        shortest.append(np.minimum(way, 1.0 - way).min(initial=0.5))
        for rows in pieces_of(cut):
            used, numbers = np.unique(cut.triangles[rows], return_inverse=True)
            meets, coincide = self_intersections(cut.points[used], numbers.reshape(-1, 3), np.arange(len(used)))
            assert len(meets) + len(coincide) == 0
    assert 1 <= (np.array(shortest) < NEAREST).sum() <= 5  # those that are bent less


def test_a_cut_is_flat_where_no_vertex_is_near():
    mesh = MESHES["ball"]
    point, normal = np.array([0.0, 0.0, 0.11]), unit((0.02, 0.01, 1.0))
    cut = cut_surface(mesh.vertices, mesh.triangles, plane(point, normal), 0.2)
    off = np.abs((cut.points[cut.on_cut] - point) @ normal)
    edge = np.linalg.norm(np.diff(mesh.vertices[mesh.triangles[0, :2]], axis=0))
    assert off.max() < 1.2 * NEAREST * edge
    inside = cut.ends[:, 0] == NOT
    assert np.abs((cut.points[inside] - point) @ normal).max() < 1e-12


def test_a_plane_through_vertices_cuts_along_edges():
    mesh = MESHES["box"]  # of four squares a side: the middle goes through vertices
    cut = cut_surface(mesh.vertices, mesh.triangles, plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), 0.25)
    assert (cut.ends[:, 0] == cut.ends[:, 1])[cut.ends[:, 0] != NOT].sum() == len(mesh.vertices) + 16
    upper, lower = (signed_volume(cut.points, cut.triangles[rows]) for rows in pieces_of(cut))
    assert upper == pytest.approx(0.48, rel=1e-14)
    assert lower == pytest.approx(0.48, rel=1e-14)


def test_a_plane_beside_a_body_cuts_nothing():
    mesh = MESHES["ball"]
    assert cut_surface(mesh.vertices, mesh.triangles, plane((0.0, 0.0, 1.1), (0.0, 0.0, 1.0)), 0.2) is None


def test_a_ring_that_is_cut_on_one_side_stays_in_one_piece():
    mesh = MESHES["torus"]
    cut = cut_surface(mesh.vertices, mesh.triangles, plane((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), 0.6), 0.2)
    (rows,) = pieces_of(cut)
    check_pieces(cut, [rows])
    used = np.unique(cut.triangles)
    # A torus has an Euler characteristic of 0, and what is cut open and closed by two caps one of 2.
    assert len(used) - len(unique_edges(cut.triangles)) + len(cut.triangles) == 2
    assert signed_volume(cut.points, cut.triangles) == pytest.approx(mesh.volume, rel=1e-12)


def test_a_radius_that_ends_in_the_section_is_refused():
    mesh = MESHES["torus"]
    with pytest.raises(MeshError, match=r"radius is 0\.4 m, and the section at hand reaches to"):
        cut_surface(mesh.vertices, mesh.triangles, plane((1.1, 0.0, 0.0), (0.0, 1.0, 0.0), 0.4), 0.2)


def test_a_cavity_stays_with_what_is_around_it():
    outer, inner = icosphere(2), icosphere(1, 0.2)
    points = np.concatenate([outer.vertices, inner.vertices + (0.6, 0.0, 0.0)])
    triangles = np.concatenate([outer.triangles, inner.triangles[:, ::-1] + len(outer.vertices)])
    cut = cut_surface(points, triangles, plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), 0.3)
    pieces = pieces_of(cut)
    volumes = sorted(signed_volume(cut.points, cut.triangles[rows]) for rows in pieces)
    assert volumes == pytest.approx([outer.volume / 2 - inner.volume, outer.volume / 2], rel=0.02)
    through = cut_surface(points, triangles, plane((0.6, 0.0, 0.0), (0.0, 1.0, 0.0)), 0.3)
    assert [len(np.unique(part)) for part in [through.triangles]] == [len(through.points)]
    assert len(pieces_of(through)) == 2
