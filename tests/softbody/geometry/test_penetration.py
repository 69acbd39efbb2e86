"""Does the narrow phase find the points of one body in another, and the triangles, as trying everything does?"""

import numpy as np
import pytest

import softbody
from softbody.geometry import (
    Penetrations,
    build_bvh,
    find_penetrations,
    find_penetrations_exhaustively,
    points_of,
    refit_bvh,
    room_for_penetrations,
    search_space,
)
from tests.softbody.geometry.shapes import BALL, TORUS, T, V, turned


def room(points, capacity):
    """Room for as many answers, and for the outcodes of all points."""
    rows = room_for_penetrations(len(points))
    return Penetrations(*(answers[:capacity] for answers in rows[:-1]), rows.outcode)


def find(points, vertices, tree, rows):
    """Fit the tree and ask it."""
    refit_bvh(tree, vertices)
    return find_penetrations(points_of(points), points_of(vertices), tree, search_space(tree), rows)


def both(points, vertices, triangles, capacity=None):
    """Rows found by the structures and by trying everything."""
    found = []
    tree = build_bvh(vertices, triangles)
    for ask in (
        lambda rows: find(points, vertices, tree, rows),
        lambda rows: find_penetrations_exhaustively(points, vertices, triangles, rows),
    ):
        rows = room(points, capacity)
        count = ask(rows)
        found.append((count, [a[: min(count, len(a))].tolist() for a in rows[:-1]]))
    return found


@pytest.mark.parametrize("shift", np.random.default_rng(0).uniform(-1.5, 1.5, (12, 3)).tolist())
@pytest.mark.parametrize("mesh", [BALL, TORUS], ids=["ball", "torus"])
def test_the_structures_find_what_trying_everything_finds(mesh, shift):
    accelerated, exhaustive = both(turned(TORUS.vertices) + shift, mesh.vertices, mesh.triangles)
    assert accelerated == exhaustive


@pytest.mark.parametrize("many", [1, 2, 3, 16, 17])
def test_a_few_points_are_found_as_many_are(many):
    points = np.random.default_rng(many).uniform(-0.6, 0.6, (many, 3))
    accelerated, exhaustive = both(points, BALL.vertices, BALL.triangles)
    assert accelerated == exhaustive
    assert 0 < accelerated[0] <= many


def test_points_on_the_middle_of_a_mesh_take_the_lowest_of_its_equal_triangles():
    cube = softbody.box((2.0, 2.0, 2.0))
    accelerated, exhaustive = both(np.array([[5.0, 0.0, 0.0], [0.0, 0.0, 0.0]]), cube.vertices, cube.triangles)
    assert accelerated == exhaustive
    assert accelerated[0] == 1


def test_a_stack_of_equal_bodies_is_judged_right():
    points = V + [0.0, 0.0, 1.5]
    (count, rows), exhaustive = both(points, V, T)
    assert (count, rows) == exhaustive
    assert count > 0
    assert rows[0] == [i for i, p in enumerate(points) if np.linalg.norm(p) < 0.99]


def test_a_point_in_a_cube_is_as_deep_as_its_next_face():
    cube = softbody.box((2.0, 2.0, 2.0))
    (count, (number, triangle, weights, depth)), _ = both(
        np.array([[5.0, 0.0, 0.0], [0.75, 0.2, 0.1]]), cube.vertices, cube.triangles
    )
    assert (count, number, depth) == (1, [1], [0.25])
    foot = weights[0] @ cube.vertices[cube.triangles[triangle[0]]]
    assert foot == pytest.approx([1.0, 0.2, 0.1], abs=1e-15)


def test_bodies_apart_or_nested_are_answered():
    assert both(V + 5.0, V, T)[0] == both(V + 5.0, V, T)[1]
    assert both(V + 5.0, V, T)[0][0] == 0
    assert both(0.3 * V, V, T)[0] == both(0.3 * V, V, T)[1]
    assert both(0.3 * V, V, T)[0][0] == len(V)


def test_more_points_than_there_is_room_for_are_counted():
    accelerated, exhaustive = both(0.3 * V, V, T, capacity=10)
    assert accelerated == exhaustive
    assert accelerated[0] == len(V)
    assert len(accelerated[1][0]) == 10


def test_points_or_vertices_that_are_not_finite_are_inside_nothing():
    spoiled = 0.3 * V
    spoiled[5] = np.nan
    for points, vertices in ((spoiled, V), (0.3 * V, np.where(np.arange(len(V))[:, None] == 3, np.nan, V))):
        rows = room_for_penetrations(len(V))
        assert find(points, vertices, build_bvh(V, T), rows) == 0
