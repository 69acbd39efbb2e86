"""Is Manifold asked rightly: what of solids is below a level, against closed forms?"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from references import manifold3d


@pytest.mark.parametrize("place", [0.0, 1000.0])
@pytest.mark.parametrize("part", [0.25, 0.5, 1.0])
def test_a_box_is_cut_as_its_closed_forms_say(cases, part, place):
    vertices, triangles = cases.cube()
    size = np.array([2.0, 3.0, 4.0])
    found = manifold3d.below(vertices * size + place, triangles, place + 4.0 * part)
    assert_allclose(found.volume, 24.0 * part, rtol=1e-13)
    assert_allclose(found.moment / found.volume - place, [1.0, 1.5, 2.0 * part], rtol=1e-13, atol=1e-15 * place)
    if part < 1.0:  # a face in the plane is the lid, or not
        assert_allclose(found.area, 6.0 + 10.0 * 4.0 * part, rtol=1e-13)


def test_a_plane_through_vertices_halves_what_is_symmetric(cases):
    vertices, triangles = cases.solid("octahedron", 1.0)
    found = manifold3d.below(vertices, triangles, 0.0)
    assert_allclose(found.volume, 2.0 / 3.0, rtol=1e-14)
    assert_allclose(found.moment / found.volume, [0.0, 0.0, -0.25], atol=1e-15)
    assert_allclose(found.area, 2.0 * 3.0**0.5, rtol=1e-14)


@pytest.mark.parametrize(("level", "volume"), [(-1.0, 0.0), (2.0, 1.0)])
def test_what_is_above_has_nothing_and_what_is_below_all(cases, level, volume):
    found = manifold3d.below(*cases.cube(), level)
    assert_allclose([found.volume, *found.moment, found.area], np.array([1.0, 0.5, 0.5, 0.5, 6.0]) * volume, atol=1e-15)


def test_a_mesh_with_a_hole_is_refused(cases):
    vertices, triangles = cases.cube()
    with pytest.raises(ValueError, match="NotManifold"):
        manifold3d.below(vertices, triangles[1:], 0.5)


@pytest.mark.parametrize("place", [0.0, 1000.0])
def test_a_box_is_cut_in_two_by_any_plane(cases, place):
    vertices, triangles = cases.cube()
    ahead, behind = manifold3d.halves(vertices * [4.0, 2.0, 2.0] + place, triangles, np.full(3, place + 1.0), [3, 0, 0])
    assert [len(ahead), len(behind), ahead[0].euler] == [1, 1, 2]
    assert_allclose([ahead[0].volume, behind[0].volume], [12.0, 4.0], rtol=1e-13)
    assert_allclose(
        np.array([ahead[0].centre, behind[0].centre]) - place, [[2.5, 1.0, 1.0], [0.5, 1.0, 1.0]], rtol=1e-12
    )


def test_a_ring_falls_into_rings_or_strings(cases):
    ring = cases.torus(1.0, 0.4, 24, 12)
    for normal, euler, count in (([0.0, 0.0, 1.0], 0, 1), ([1.0, 0.0, 0.0], 2, 1)):
        for side in manifold3d.halves(*ring, np.full(3, 0.01), np.array(normal)):
            assert [solid.euler for solid in side] == [euler] * count
