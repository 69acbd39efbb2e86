"""Edges of soft bodies against surfaces: is what goes through found, and does the way out part them?"""

import numpy as np
import pytest

import softbody
from softbody import World
from softbody.collision.edge_mesh import edge_across_edge, edge_through_faces
from softbody.geometry.bvh import build_bvh, search_space
from softbody.geometry.bvh_rays import segment_hits

ROOF = softbody.box((2.0, 2.0, 2.0))
TREE = build_bvh(ROOF.vertices, ROOF.triangles)
SEARCH = search_space(TREE)


def hits_of(p, q):
    return segment_hits(p, q, TREE, ROOF.vertices, SEARCH)


def point_of(triangle, weights):
    return np.array(weights) @ ROOF.vertices[ROOF.triangles[triangle]]


def test_two_ridges_that_cross_are_parted_at_right_angles_to_both():
    p, q = (1.3, 0.1, 0.5), (0.5, 0.1, 1.3)
    depth, normal, place, triangle, weights = edge_across_edge(p, q, hits_of(p, q), ROOF.vertices, ROOF.triangles)
    assert depth == pytest.approx((2.0 - 1.8) / np.sqrt(2.0))
    assert normal == pytest.approx((np.sqrt(0.5), 0.0, np.sqrt(0.5)))
    assert place == pytest.approx(0.5)
    assert point_of(triangle, weights) == pytest.approx((1.0, 0.1, 1.0))


def test_an_edge_through_both_sides_is_parted_at_its_middle():
    p, q = (-1.5, 0.1, 0.9), (1.5, 0.1, 0.9)
    hits = hits_of(p, q)
    assert edge_across_edge(p, q, hits, ROOF.vertices, ROOF.triangles).triangle == -1
    depth, normal, place, triangle, weights = edge_through_faces(p, q, hits, TREE, ROOF.vertices, SEARCH)
    assert (depth, place) == (pytest.approx(0.1), pytest.approx(0.5))
    assert normal == pytest.approx((0.0, 0.0, 1.0))
    assert point_of(triangle, weights) == pytest.approx((0.0, 0.1, 1.0))


@pytest.mark.parametrize("edges", [True, False])
def test_two_crossed_ridges_hold_each_other_up(edges):
    """Two coarse wedges fall crosswise on each other: without edges no particle of one ever is in the other."""
    prism = np.array(
        [[-1.0, -0.3, 0.0], [-1.0, 0.3, 0.0], [-1.0, 0.0, 0.5], [1.0, -0.3, 0.0], [1.0, 0.3, 0.0], [1.0, 0.0, 0.5]]
    )
    faces = [[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]]
    upper = prism[:, [1, 0, 2]] * [1.0, 1.0, -1.0]  # upside down and across: a proper turn
    lower = softbody.Mesh(prism, faces)
    world = World(edge_contacts=edges)
    world.add_ground()
    world.add_soft_body(lower, 6.0, 2e4, 200.0)
    falling = world.add_soft_body(softbody.Mesh(upper + [0.0, 0.0, 1.1], faces), 0.6, 2e3, 20.0)
    height = falling.centre[2]
    world.run(0.45, 0.5 * world.stable_time_step())
    assert (falling.centre[2] > height - 0.25) == edges
