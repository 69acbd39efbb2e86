"""Do triangles hang together as shells and fans as one counts them by hand, and as libigl does?"""

import numpy as np
import pytest

import softbody
from softbody.geometry.connected import fans, half_edges, joined, shells

# Two tetrahedra that share vertex 0.
TIPS = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3), (0, 5, 4), (0, 4, 6), (4, 5, 6), (5, 0, 6)])


def edges_of(triangles):
    """Return the half-edges of each edge."""
    a, b, c = triangles.T
    ends = np.sort(np.stack([np.concatenate([a, b, c]), np.concatenate([b, c, a])], axis=1), axis=1)
    return half_edges(np.unique(ends, axis=0, return_inverse=True)[1].ravel())


def test_pairs_join_chains_under_their_lowest_number():
    pairs = np.array([(5, 3), (6, 1), (3, 4), (7, 7)])
    assert joined(8, pairs).tolist() == [0, 1, 2, 3, 3, 3, 1, 7]
    assert joined(3, np.empty((0, 2), np.int64)).tolist() == [0, 1, 2]


def test_half_edges_are_told_by_corner_and_triangle():
    triangles = softbody.tetrahedron().triangles
    for one, other in edges_of(triangles):
        k, t = divmod(int(one), 4)
        m, u = divmod(int(other), 4)
        assert (triangles[t, k], triangles[t, (k + 1) % 3]) == (triangles[u, (m + 1) % 3], triangles[u, m])


def test_what_shares_a_vertex_only_is_two_shells_and_two_fans():
    edges = edges_of(TIPS)
    assert shells(edges).tolist() == [0] * 4 + [1] * 4
    assert fans(TIPS, edges).tolist() == [2] + [1] * 6


def test_shells_and_fans_are_those_of_libigl():
    igl = pytest.importorskip("references.igl")
    torus, rng = softbody.torus(1.0, 0.4, 7, 5), np.random.default_rng(0)
    triangles = np.concatenate([torus.triangles, TIPS + 35, softbody.box().triangles + 42])
    triangles = rng.permutation(50)[triangles][rng.permutation(len(triangles))]
    edges = edges_of(triangles)
    ours, theirs = shells(edges), igl.shells(triangles)
    assert len(np.unique(np.stack([ours, theirs], axis=1), axis=0)) == len(np.unique(theirs)) == ours.max() + 1 == 4
    assert ((fans(triangles, edges) > 1) == igl.is_pinched(triangles)).all()
