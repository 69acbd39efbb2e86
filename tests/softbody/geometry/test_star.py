"""How far may the vertices of a mesh move while it is seen whole from high above?"""

import numpy as np
import pytest

import softbody
from softbody.geometry.star import room_of_mesh
from softbody.geometry.unfolded import is_star_shaped

pytestmark = pytest.mark.interpreted


def some_star(seed: int) -> tuple[np.random.Generator, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    ball = softbody.icosphere(2)
    vertices = ball.vertices * rng.uniform(0.3, 1.0, 3) * rng.uniform(0.9, 1.1, (len(ball.vertices), 1))
    return rng, vertices, ball.triangles


@pytest.mark.parametrize("seed", range(20))
def test_within_its_room_a_star_stays_one_with_its_height(seed):
    rng, vertices, triangles = some_star(seed)
    room = room_of_mesh(vertices, triangles, 0.05)
    assert room > 0.0
    way = rng.normal(size=vertices.shape)
    way *= 0.999 * room / np.linalg.norm(way, axis=1, keepdims=True)
    moved = vertices + way - way.mean(axis=0)  # the mean's own motion is beside it
    moved = vertices + (moved - vertices) * min(1.0, 0.999 * room / np.linalg.norm(moved - vertices, axis=1).max())
    assert is_star_shaped(moved, triangles)
    assert room_of_mesh(moved, triangles, 0.99 * 0.05) > 0.0


@pytest.mark.parametrize("seed", range(20))
def test_the_room_is_that_of_each_triangle_by_itself(seed):
    _, vertices, triangles = some_star(seed)
    a, b, c = (vertices[triangles[:, k]] - vertices.mean(axis=0) for k in range(3))
    normal = np.cross(b - a, c - a)
    twice_area = np.linalg.norm(normal, axis=1)
    altitude = twice_area / np.linalg.norm([b - a, c - b, a - c], axis=2).max(axis=0)
    height = (a * normal).sum(axis=1) / twice_area
    far = np.sqrt(np.maximum(0.0, np.square([a, b, c]).sum(axis=2).max(axis=0) - height**2))
    least = np.minimum((height - 0.05) / (1.0 + 6.0 * far / altitude), altitude / 3.0).min()
    assert room_of_mesh(vertices, triangles, 0.05) == pytest.approx(least, rel=1e-12)


def test_what_is_lower_hidden_inside_out_flat_or_no_number_has_no_room():
    ball = softbody.icosphere(2)
    ring = softbody.torus(1.0, 0.4, 12, 8)
    assert room_of_mesh(ring.vertices, ring.triangles, 0.0) <= 0.0
    for scale in (0.1, -1.0, 0.0, np.nan):
        assert not room_of_mesh(ball.vertices * [1.0, 1.0, scale], ball.triangles, 0.2) > 0.0


@pytest.mark.parametrize("first", range(9))
def test_a_star_that_is_wrapped_twice_around_its_middle_has_no_room(first):
    ball = softbody.icosphere(1)
    twice = np.concatenate([ball.triangles, ball.triangles])
    assert room_of_mesh(ball.vertices, np.roll(twice, first, axis=0), 0.1) <= 0.0
    assert room_of_mesh(ball.vertices, ball.triangles, 0.1) > 0.0
