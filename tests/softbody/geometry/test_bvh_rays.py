"""Do rays through a tree find where a segment goes in and out, and what is inside?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import softbody
from softbody.geometry.bvh import build_bvh, search_space
from softbody.geometry.bvh_rays import point_in_bvh, segment_hits

CUBE = softbody.box((2.0, 2.0, 2.0))
TREE = build_bvh(CUBE.vertices, CUBE.triangles)
SEARCH = search_space(TREE)

numbers = st.floats(-2.0, 2.0).map(lambda x: round(x, 3) + 0.0003)
points = st.tuples(numbers, numbers, numbers)


@given(points, points)
def test_hits_are_where_a_segment_goes_in_and_out(p, q):
    enter, one, leave, other = segment_hits(p, q, TREE, CUBE.vertices, SEARCH)
    t = np.linspace(0.0, 1.0, 2001)[1:-1, None]
    inside = (np.abs((1.0 - t) * np.array(p) + t * np.array(q)) < 1.0).all(axis=1)
    sides = inside.astype(int) + 0
    changes = int(np.abs(np.diff(sides)).sum())
    assert changes <= (one >= 0) + (other >= 0)
    assert enter <= leave
    for place, triangle in ((enter, one), (leave, other)):
        if triangle >= 0:
            x = (1.0 - place) * np.array(p) + place * np.array(q)
            assert np.abs(x).max() == pytest.approx(1.0, abs=1e-9)


@given(points)
def test_points_in_a_tree_are_those_in_the_mesh(p):
    assert point_in_bvh(p, TREE, CUBE.vertices, SEARCH) == (np.abs(p) < 1.0).all()
