"""Is the IPC Toolkit asked rightly: which features are near, and how near, where both are known?"""

import numpy as np
from numpy.testing import assert_allclose

from references import ipctk


def two_tetrahedra(gap):
    """One above the other, apex to face, `gap` [m] apart."""
    lower = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.25, 0.25, 1.0]])
    upper = lower * [1.0, 1.0, -1.0] + [0.0, 0.0, 2.0 + gap]
    vertices = np.concatenate([lower, upper])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    triangles = np.concatenate([faces, faces[:, ::-1] + 4])
    edges = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])
    return vertices, np.concatenate([edges, edges + 4]), triangles


def test_apices_that_meet_are_near_each_others_faces():
    vertices, edges, triangles = two_tetrahedra(0.01)
    pairs, gaps = ipctk.near_features(vertices, edges, triangles, 0.02)
    assert_allclose(gaps, 0.01, atol=1e-14)
    assert {tuple(row) for row in pairs[pairs[:, 0] == 0].tolist()} == {(0, 3, t) for t in (5, 6, 7)} | {
        (0, 7, t) for t in (1, 2, 3)
    }
    assert (pairs[:, 0] == 1).sum() == 9


def test_nothing_is_near_beyond_the_margin_and_neighbours_never_are():
    vertices, edges, triangles = two_tetrahedra(0.01)
    assert len(ipctk.near_features(vertices, edges, triangles, 0.0099)[0]) == 0
    assert len(ipctk.near_features(vertices[:4], edges[:6], triangles[:4], 10.0)[0]) == 3 + 4  # opposite edges; apices
