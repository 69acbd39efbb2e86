"""Borders of open surfaces: where they run, and what closes their holes."""

import numpy as np
import pytest

from softbody import box, icosphere, torus
from softbody.geometry.borders import border_of, fans_of_holes, holes_of
from softbody.geometry.polyhedron import signed_volume


def without(mesh, gone):
    """Return points and triangles of a mesh without some triangles, renumbered."""
    triangles = np.delete(mesh.triangles, gone, axis=0)
    used, rows = np.unique(triangles, return_inverse=True)
    return mesh.vertices[used].copy(), rows.reshape(-1, 3)


def directed(triangles):
    return {(a, b) for t in triangles.tolist() for a, b in zip(t, [*t[1:], t[0]])}


def test_a_closed_surface_has_no_border():
    mesh = torus()
    after, before = border_of(len(mesh.vertices), mesh.triangles.copy())
    assert (after == -1).all()
    assert (before == -1).all()


@pytest.mark.parametrize("far", [0.5, 0.0, -0.5])
def test_borders_run_along_sides_that_have_no_other(far):
    mesh = icosphere(2)
    middles = mesh.vertices[mesh.triangles].mean(axis=1)
    points, triangles = without(mesh, np.flatnonzero((middles[:, 2] > 0.8) | (middles[:, 2] < far - 0.9)))
    sides = directed(triangles)
    lonely = {(a, b) for a, b in sides if (b, a) not in sides}
    after, before = border_of(len(points), triangles)
    assert {(i, int(j)) for i, j in enumerate(after) if j >= 0} == lonely
    assert {(int(i), j) for j, i in enumerate(before) if i >= 0} == lonely
    border, rows = holes_of(len(points), triangles)
    assert sorted(border.tolist()) == sorted(a for a, _ in lonely)
    for first, end in rows:
        loop = border[first:end].tolist()
        assert set(zip(loop, [*loop[1:], loop[0]])) <= lonely


def test_a_box_without_a_side_is_as_large():
    mesh = box((1.0, 2.0, 3.0), 3)
    middles = mesh.vertices[mesh.triangles].mean(axis=1)
    points, triangles = without(mesh, np.flatnonzero(middles[:, 2] > 1.49))
    more, area = fans_of_holes(points, triangles)
    assert signed_volume(points, triangles) + more == pytest.approx(6.0, rel=1e-14)
    assert area == pytest.approx(2.0, rel=1e-14)


def test_two_holes_have_two_fans():
    mesh = box((1.0, 1.0, 4.0), 2)
    middles = mesh.vertices[mesh.triangles].mean(axis=1)
    points, triangles = without(mesh, np.flatnonzero(np.abs(middles[:, 2]) > 1.99))
    _, rows = holes_of(len(points), triangles)
    assert len(rows) == 2
    assert (np.diff(rows) == 8).all()
    more, area = fans_of_holes(points + 100.0, triangles)
    assert signed_volume(points + 100.0, triangles) + more == pytest.approx(4.0, rel=1e-12)
    assert area == pytest.approx(2.0, rel=1e-13)
