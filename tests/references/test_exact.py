import numpy as np
import pytest
from numpy.testing import assert_allclose

from references import exact

UPRIGHT = (1.0, 0.0, 0.0, 0.0)
CUBE = (1.0, 1.0, 1.0)
O = (0.0, 0.0, 0.0)  # noqa: E741


@pytest.mark.parametrize(("x", "answer"), [(1.0, 0), (np.nextafter(1.0, 0), 1), (np.nextafter(1.0, 2), -1)])
def test_one_bit_decides_between_overlap_touch_and_gap(x, answer):
    assert exact.boxes_overlap(CUBE, O, UPRIGHT, CUBE, (x, 0, 0), UPRIGHT) == answer
    assert exact.boxes_overlap(CUBE, (x, 0, 0), UPRIGHT, CUBE, O, UPRIGHT) == answer


@pytest.mark.parametrize("position", [(1, 1, 0), (1, 1, 1), (0.25, 1, -0.5)])
def test_boxes_that_share_an_edge_a_corner_or_part_of_a_face_touch(position):
    assert exact.boxes_overlap(CUBE, O, UPRIGHT, CUBE, position, UPRIGHT) == 0


def test_a_turned_box_touches_with_its_edge():
    # (2, 0, 0, 1) turns by the angle of cosine 3/5: a cube of side 5 then reaches ½ · 5 · 7/5 = 3.5 along x
    turned = (5.0, 5.0, 5.0), O, (2.0, 0.0, 0.0, 1.0)
    for x, answer in ((4.0, 0), (np.nextafter(4.0, 0), 1), (np.nextafter(4.0, 5), -1)):
        assert exact.boxes_overlap(*turned, CUBE, (x, 0, 0), UPRIGHT) == answer


def test_two_crossed_edges_touch_and_only_their_own_axis_says_so():
    # edge along z of a at y = 3.5, edge along x of b at y = 7 − 3.5
    boxes = (5.0,) * 3, O, (2.0, 0.0, 0.0, 1.0), (5.0,) * 3, (0.0, 7.0, 0.0), (2.0, 1.0, 0.0, 0.0)
    assert exact.boxes_overlap(*boxes) == 0
    separations = exact.box_separations(*boxes)
    edge_z_across_edge_x = 6 + 3 * 2 + 0
    assert separations[edge_z_across_edge_x] == 0.0
    assert np.all(np.delete(separations, edge_z_across_edge_x) < -0.1)


def test_a_quaternion_of_any_length_is_the_same_turn(cases, rng):
    size_a, x_a, q_a, size_b, x_b, q_b = cases.box_pairs(rng, 50)
    once = exact.box_separation(size_a, x_a, q_a, size_b, x_b, q_b)
    assert np.array_equal(once, exact.box_separation(size_a, x_a, 4.0 * q_a, size_b, x_b, -q_b))


def test_the_separation_agrees_with_floating_point_on_every_axis(cases, rng):
    size_a, x_a, q_a, size_b, x_b, q_b = cases.box_pairs(rng, 200)
    turn = lambda q, v: v + 2 * np.cross(q[1:], np.cross(q[1:], v) + q[0] * v)  # noqa: E731
    for i in range(200):
        a, b = ([turn(q[i], e) for e in np.eye(3)] for q in (q_a, q_b))
        corners = [
            x[i] + np.array([[sx, sy, sz] for sx in (-1, 1) for sy in (-1, 1) for sz in (-1, 1)]) * size[i] / 2 @ axes
            for x, size, axes in ((x_a, size_a, a), (x_b, size_b, b))
        ]
        want = []
        for axis in [*a, *b, *(np.cross(u, v) for u in a for v in b)]:
            shadow_a, shadow_b = (c @ (axis / np.linalg.norm(axis)) for c in corners)
            want.append(max(shadow_a.min() - shadow_b.max(), shadow_b.min() - shadow_a.max()))
        got = exact.box_separations(size_a[i], x_a[i], q_a[i], size_b[i], x_b[i], q_b[i])
        assert_allclose(got, want, atol=1e-12)
        assert exact.box_separation(size_a[i], x_a[i], q_a[i], size_b[i], x_b[i], q_b[i]) == got.max()


def test_parallel_edges_have_no_axis_and_a_far_tiny_gap_is_seen():
    boxes = CUBE, (1e6, 0, 0), UPRIGHT, CUBE, (1e6 + 1 + 2.0**-30, 0, 0), UPRIGHT
    assert exact.box_separation(*boxes) == 2.0**-30
    assert np.isnan(exact.box_separations(*boxes)[[6, 10, 14]]).all()


def test_the_sign_of_the_separation_is_the_overlap(cases, rng):
    boxes = cases.box_pairs(rng, 300)
    assert np.array_equal(np.sign(exact.box_separation(*boxes)), -exact.boxes_overlap(*boxes))


def test_a_cube_knows_inside_surface_and_outside(cases):
    mesh = cases.cube()
    inside = [(0.5, 0.5, 0.5), (1e-300, 0.5, 0.5), (np.nextafter(1, 0),) * 3]
    surface = [(0, 0.3, 0.7), (0.5, 0.5, 1), (0, 0, 0.5), (1, 1, 1), (0.25, 0.25, 0)]
    outside = [(0.5, 0.5, np.nextafter(1, 2)), (-5e-324, 0.5, 0.5), (0.5, 1.5, 1), (2, 0, 0), (-1, -1, -1)]
    answers = exact.points_in_mesh([*inside, *surface, *outside], *mesh)
    assert answers.tolist() == [1] * 3 + [0] * 5 + [-1] * 5
    assert exact.point_in_mesh(inside[0], *mesh) == 1


def test_vertices_shifted_along_z_are_no_trouble(cases):
    # each lies exactly below or above a vertex, where rays along z go wrong
    vertices, triangles = cases.torus(1.0, 0.5, 8, 6)
    shifted = vertices - [0, 0, 0.125]
    by_circle = []
    for x, y, z in shifted:
        across = np.angle(x + 1j * y) % (np.pi / 4) - np.pi / 8  # within its straight segment
        rho = np.hypot(x, y) * np.cos(across) / np.cos(np.pi / 8)
        corners = np.angle((rho - 1.0) + 1j * z) % (np.pi / 3) - np.pi / 6
        by_circle.append(np.hypot(rho - 1.0, z) * np.cos(corners) < 0.5 * np.cos(np.pi / 6))
    got = exact.points_in_mesh(shifted, vertices, triangles)
    assert 0 < np.count_nonzero(by_circle) < len(shifted)
    assert np.array_equal(got == 1, by_circle)
    assert np.all(exact.points_in_mesh(vertices, vertices, triangles) == 0)


def test_a_direction_that_meets_a_corner_or_an_edge_is_thrown_away(cases):
    # the first one drawn leads from inside the unit cube straight to a corner, or to the middle of an edge
    direction = np.random.default_rng(0).integers(-(2**20), 2**20, 3)
    corner = (direction > 0).astype(float)
    for k in range(3):
        edge = np.where(np.arange(3) == k, 0.5, corner)
        for target in (corner, edge):
            start = target - direction / 2.0**22
            assert exact.point_in_mesh(start, *cases.cube()) == 1
            assert exact.point_in_mesh(2 * target - start, *cases.cube()) == -1


def test_the_hole_of_a_torus_is_outside(cases):
    mesh = cases.torus(1.0, 0.4, 12, 8)
    assert exact.points_in_mesh([(0, 0, 0), (0.9, 0, 0), (0, -1.1, 0.1), (0, 0, 0.3)], *mesh).tolist() == [-1, 1, 1, -1]


def test_triangles_without_area_change_nothing_but_count_as_surface(cases):
    vertices, triangles = cases.cube()
    vertices = np.concatenate([vertices, [(0.5, 0.5, 1.5)]])
    # the needle 7 – 8 – 7 sticks out of the corner (1, 1, 1)
    needle = np.concatenate([triangles, [(7, 8, 7), (8, 7, 7)]])
    points = [(0.5, 0.5, 0.5), (0.75, 0.75, 1.25), (0.5, 0.5, 1.5), (0.75, 0.75, 1.5), (0.25, 0.25, 1.75)]
    assert exact.points_in_mesh(points, vertices, needle).tolist() == [1, 0, 0, -1, -1]


def test_the_turning_of_the_triangles_does_not_matter(cases, rng):
    vertices, triangles = cases.torus(1.0, 0.4, 7, 5)
    points = rng.uniform(-1.5, 1.5, (50, 3))
    assert np.array_equal(
        exact.points_in_mesh(points, vertices, triangles), exact.points_in_mesh(points, vertices, triangles[:, ::-1])
    )


@pytest.mark.parametrize(("gap", "sign"), [(-1e-15, 1), (0.0, 0), (2.5e-16, -1), (-0.5, 1), (2.0, -1)])
def test_convex_meshes_overlap_touch_or_are_apart_to_the_last_bit(cases, gap, sign):
    vertices, triangles = cases.cube()
    moved = vertices + [0.0, 0.0, 1.0]
    moved[:, 2] = np.where(moved[:, 2] == 1.0, 1.0 + gap, 3.0)
    assert exact.convex_overlap(vertices, triangles, moved, triangles) == sign
    assert exact.convex_overlap(moved, triangles, vertices, triangles) == sign


def test_convex_meshes_that_only_an_edge_axis_parts_are_apart(cases):
    """Two wedges of tetrahedra, edge across edge."""
    lower = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, -1.0], [0.0, 1.0, -1.0]])
    upper = np.array([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0]])
    triangles = np.array([[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]])
    for gap, sign in ((1e-9, -1), (0.0, 0), (-1e-9, 1)):
        assert exact.convex_overlap(lower, triangles, upper + [0.0, 0.0, gap], triangles) == sign
