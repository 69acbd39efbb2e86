"""Is a mesh that is seen whole from its middle one that does not meet itself?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import softbody
from references import igl
from softbody.geometry.unfolded import find_unfolded, is_star_shaped

pytestmark = pytest.mark.interpreted

BALL = softbody.icosphere(1)


def unfolded(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    found = np.empty(len(vertices), bool)
    find_unfolded(vertices, triangles, np.empty((2, *vertices.shape)), found)
    return found


@given(st.integers(0, 2**32 - 1), st.floats(0.0, 1.0), st.sampled_from([1.0, 1e-3, 1e-12, 1e6]))
def test_neither_says_yes_of_what_meets_itself(seed, shake, unit):
    rng = np.random.default_rng(seed)
    vertices = unit * (BALL.vertices + shake * rng.normal(size=BALL.vertices.shape))
    pairs = igl.self_intersections(vertices, BALL.triangles)
    assert not (is_star_shaped(vertices, BALL.triangles) and len(pairs))
    clear = unfolded(vertices, BALL.triangles)
    assert not any(clear[np.intersect1d(*BALL.triangles[pair])].any() for pair in pairs)


@pytest.mark.parametrize("unit", [1.0, 1e-9, 1e9])
@pytest.mark.parametrize("flat", [1.0, 1e-3])
def test_a_convex_mesh_is_seen_whole_in_any_unit(unit, flat):
    vertices = unit * BALL.vertices * [1.0, 1.0, flat] + unit * np.array([3.0, 4.0, 5.0])
    assert is_star_shaped(vertices, BALL.triangles)
    assert unfolded(vertices, BALL.triangles).all()


def test_a_ring_is_not_seen_whole_though_it_is_sound():
    ring = softbody.torus(1.0, 0.3, 12, 8)
    assert not is_star_shaped(ring.vertices, ring.triangles)
    assert unfolded(ring.vertices, ring.triangles).all()


def test_what_is_inside_out_flat_or_no_number_is_not_seen_whole():
    assert not is_star_shaped(-BALL.vertices, BALL.triangles)
    for scale in (0.0, np.nan):
        broken = BALL.vertices * [1.0, 1.0, scale]
        assert not is_star_shaped(broken, BALL.triangles)
    assert not unfolded(broken, BALL.triangles).any()
