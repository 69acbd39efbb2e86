"""Does a face normal part two meshes, as by projecting all vertices on all normals?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import softbody
from softbody.collision.soft.sat_meshes import faces_part

pytestmark = pytest.mark.interpreted

MESHES = [
    softbody.icosphere(1, 0.5),
    softbody.torus(0.6, 0.2, 9, 6),
    softbody.tetrahedron(0.7),
    softbody.box((1, 0.4, 0.2), 2),
]


def part_by_all_normals(a, b):
    """Project every vertex of both meshes on every normal of either."""
    for points, triangles in (a, b):
        i, j, k = (points[triangles[:, c]] for c in range(3))
        normals = np.cross(j - i, k - i)
        along_a, along_b = a[0] @ normals.T, b[0] @ normals.T
        if ((along_a.max(0) < along_b.min(0)) | (along_b.max(0) < along_a.min(0))).any():
            return True
    return False


@given(st.sampled_from(MESHES), st.sampled_from(MESHES), st.integers(0, 2**32 - 1))
def test_meshes_are_parted_if_any_normal_parts_them(one, other, seed):
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    a = one.vertices, one.triangles
    b = other.vertices @ turn.T + rng.uniform(-1.2, 1.2, 3), other.triangles
    assert faces_part(*a, *b) == faces_part(*b, *a) == part_by_all_normals(a, b)


def test_meshes_that_touch_to_the_last_bit_are_not_parted():
    one, other = softbody.box((1.0, 1.0, 1.0)), softbody.box((0.5, 0.5, 0.5))
    beside = other.vertices + [0.75, 0.1, 0.2]
    assert not faces_part(one.vertices, one.triangles, beside, other.triangles)
    assert faces_part(one.vertices, one.triangles, beside + [1e-15, 0.0, 0.0], other.triangles)


@pytest.mark.parametrize("height", [0.0, 1.0])
def test_a_ball_in_the_hole_of_a_torus_is_parted_only_above_it(height):
    ring, ball = softbody.torus(1.0, 0.3), softbody.icosphere(1, 0.2)
    above = ball.vertices + [0.0, 0.0, height]
    assert faces_part(ring.vertices, ring.triangles, above, ball.triangles) == (height > 0.0)
