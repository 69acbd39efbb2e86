"""A surface tears: what hangs together at no side is in two, and nothing else changes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from softbody import MeshError, box, icosphere, octahedron, tetrahedron, torus
from softbody.mesh.mesh import unique_edges
from softbody.mesh.tearing import check_torn_surface, most_loaded, torn

MESHES = {
    "ball": icosphere(2),
    "torus": torus(1.0, 0.4, 12, 8),
    "box": box((1.0, 1.2, 0.8), 3),
    "octahedron": octahedron(1.0),
    "tetrahedron": tetrahedron(1.0),
}


def once(mesh, edge, pull=None):
    """Return what one edge, by its ends, makes of a mesh."""
    row = np.flatnonzero((mesh.edges == np.sort(edge)).all(axis=1))
    pull = np.zeros(len(mesh.vertices)) if pull is None else pull
    return torn(mesh.vertices, mesh.triangles, mesh.edges, row, pull)


def test_a_vertex_splits_across_the_edge_that_tears_it():
    mesh = icosphere(2)
    i, j = mesh.edges[200].tolist()
    pull = np.zeros(len(mesh.vertices))
    pull[i] = 1.0
    triangles, origin = once(mesh, (i, j), pull)
    assert origin.tolist() == [*range(len(mesh.vertices)), i]
    assert np.array_equal(origin[triangles], mesh.triangles)
    parts = [set(triangles[(triangles == v).any(axis=1)].ravel().tolist()) for v in (i, len(origin) - 1)]
    with_j = next(part for part in parts if j in part)
    other = next(part for part in parts if j not in part)
    along = mesh.vertices[j] - mesh.vertices[i]
    reach = [max(along @ (mesh.vertices[origin[v]] - mesh.vertices[i]) for v in part) for part in (with_j, other)]
    assert reach[0] > reach[1]
    assert len(with_j & other) == 2  # the ends of the slit


def test_equal_ends_split_both():
    mesh = icosphere(2)
    triangles, origin = once(mesh, mesh.edges[200])
    assert sorted(origin[len(mesh.vertices) :].tolist()) == mesh.edges[200].tolist()
    check_torn_surface(triangles, len(origin))


def test_a_tear_runs_on_from_its_end():
    mesh = icosphere(2)
    pull = np.zeros(len(mesh.vertices))
    i, j = mesh.edges[200].tolist()
    pull[i] = 1.0
    triangles, origin = once(mesh, (i, j), pull)
    points, edges = mesh.vertices[origin], unique_edges(triangles)
    sides = np.concatenate([np.stack([triangles[:, c], triangles[:, (c + 1) % 3]], axis=1) for c in range(3)])
    back = {(b, a) for a, b in sides.tolist()}
    tip = next(a for a, b in sides.tolist() if (a, b) not in back and a not in (i, len(origin) - 1))
    across = np.flatnonzero((edges == tip).any(axis=1))
    row = next(e for e in across if not ({i, len(origin) - 1} & set(edges[e].tolist())))
    other = int(edges[row].sum()) - tip
    loads = np.zeros(len(origin))
    loads[other] = 9.0  # however much it is pulled elsewhere
    after, again = torn(points, triangles, edges, np.array([row]), loads)
    assert set(again[len(origin) :].tolist()) == {tip}
    check_torn_surface(after, len(again))


def test_the_most_loaded_tear_first_and_equals_together():
    edges = np.array([[0, 1], [1, 2], [2, 3], [3, 4], [4, 5]])
    assert most_loaded(np.array([1.5, 1.2, 1.1, 1.3, 0.9]), edges, 6).tolist() == [0, 3]
    assert most_loaded(np.array([1.5, 1.5, 1.1, 1.0, 0.9]), edges, 6).tolist() == [0, 1]
    assert most_loaded(np.array([1.0, 0.5, 0.5, 0.5, 1.0]), edges, 6).tolist() == []


@settings(max_examples=60, deadline=None)
@given(
    kind=st.sampled_from(list(MESHES)),
    seed=st.integers(0, 2**31),
    rounds=st.integers(1, 8),
    share=st.floats(0.0, 0.3),
)
def test_what_is_torn_has_simple_borders(kind, seed, rounds, share):
    mesh, rng = MESHES[kind], np.random.default_rng(seed)
    points, triangles, count = mesh.vertices, mesh.triangles, len(mesh.vertices)
    faces = np.sort(points[triangles].reshape(len(triangles), -1), axis=1)
    for _ in range(rounds):
        edges = unique_edges(triangles)
        rows = np.flatnonzero(rng.random(len(edges)) < share)
        triangles, origin = torn(points, triangles, edges, rows, rng.random(len(points)))
        points = points[origin]
        check_torn_surface(triangles, len(points))
        assert len(points) >= count
        count = len(points)
    assert np.array_equal(np.sort(points[triangles].reshape(len(triangles), -1), axis=1), faces)


def test_triangles_alone_do_not_tear():
    mesh = octahedron()
    triangles, origin = torn(mesh.vertices, mesh.triangles, mesh.edges, np.arange(12), np.zeros(6))
    assert len(origin) == 24  # all equal: it falls apart
    again, same = torn(mesh.vertices[origin], triangles, unique_edges(triangles), np.arange(24), np.zeros(24))
    assert np.array_equal(again, triangles)
    assert len(same) == 24


@pytest.mark.parametrize(
    ("triangles", "says"),
    [
        ([[0, 1, 2], [0, 1, 3]], "the same way"),
        ([[0, 1, 2], [0, 3, 4]], "hang together there alone"),
        ([[0, 1, 2]], "belongs to no triangle"),
    ],
)
def test_what_is_no_torn_surface_is_named(triangles, says):
    with pytest.raises(MeshError, match=says):
        check_torn_surface(np.array(triangles), 4 if says != "hang together there alone" else 5)
