import numpy as np
from numpy.testing import assert_allclose

from references import exact, fcl

UPRIGHT = (1.0, 0.0, 0.0, 0.0)


def pair(size_a, position_a, orientation_a, size_b, position_b, orientation_b):
    return [np.array([x], float) for x in (size_a, position_a, orientation_a, size_b, position_b, orientation_b)]


def test_fcl_and_integers_agree_on_every_pair(cases, rng):
    boxes = cases.box_pairs(rng, 2000)
    overlap = exact.boxes_overlap(*boxes) > 0
    assert 600 < overlap.sum() < 1400
    assert np.array_equal(fcl.boxes_overlap(*boxes), overlap)


def test_fcl_and_integers_agree_down_to_the_margin(cases, rng):
    size_a, x_a, q_a, size_b, x_b, q_b = cases.box_pairs(rng, 150)
    gap = fcl.box_distance(size_a, x_a, q_a, size_b, x_b, q_b)
    apart = gap > 0.05
    # Move b along the line of centres until the exact separation is a few margins, by bisection.
    near, far = np.zeros(150), np.ones(150)
    for _ in range(60):
        middle = 0.5 * (near + far)
        separation = exact.box_separation(size_a, x_a, q_a, size_b, x_a + middle[:, None] * (x_b - x_a), q_b)
        near, far = np.where(separation < 5e-12, middle, near), np.where(separation < 5e-12, far, middle)
    for t, answer in ((far, False), (near - 1e-10, True)):
        assert np.all(fcl.boxes_overlap(size_a, x_a, q_a, size_b, x_a + t[:, None] * (x_b - x_a), q_b)[apart] == answer)


def test_a_box_inside_a_box_overlaps_it():
    assert fcl.boxes_overlap(*pair((4, 4, 4), (0, 0, 0), UPRIGHT, (1, 1, 1), (0.5, 0, 0), (0.6, 0.8, 0, 0))).all()


def test_sizes_are_full_extents_and_quaternions_begin_with_w():
    quarter = (0.5**0.5, 0, 0, 0.5**0.5)  # about z: the rod along x of length 3 then points along y
    rod, cube = (3, 1, 1), (1, 1, 1)
    assert_allclose(fcl.box_distance(*pair(rod, (0, 0, 0), quarter, cube, (0, 2.25, 0), UPRIGHT)), 0.25, atol=1e-14)
    assert_allclose(fcl.box_distance(*pair(rod, (0, 0, 0), UPRIGHT, cube, (0, 2.25, 0), UPRIGHT)), 1.25, atol=1e-14)


def test_the_distance_of_boxes_that_overlap_is_minus_the_exact_depth(cases, rng):
    boxes = cases.box_pairs(rng, 1000)
    separation = exact.box_separation(*boxes)
    distance = fcl.box_distance(*boxes)
    overlap = separation < 0
    assert_allclose(distance[overlap], separation[overlap], atol=1e-13)
    assert np.all(distance[~overlap] > separation[~overlap] - 1e-13)


def test_the_distance_between_two_corners_is_euclidean():
    boxes = pair((1, 1, 1), (0, 0, 0), UPRIGHT, (1, 1, 1), (2, 2, 2), UPRIGHT)
    assert_allclose(fcl.box_distance(*boxes), 3**0.5, rtol=1e-12)
    assert_allclose(exact.box_separation(*boxes), 1.0, rtol=0)


def test_no_pairs_give_no_answers():
    none = [np.empty((0, k)) for k in (3, 3, 4, 3, 3, 4)]
    assert fcl.boxes_overlap(*none).shape == (0,)
    assert fcl.box_distance(*none).shape == (0,)


def test_the_contact_of_two_boxes_is_as_deep_as_they_overlap_and_points_from_a_to_b():
    boxes = pair((1, 1, 1), (0, 0, 0), UPRIGHT, (1, 1, 1), (0.2, 0.1, 0.75), UPRIGHT)
    depth, normal = fcl.box_contacts(*boxes)
    assert_allclose(depth, [0.25], rtol=1e-14)
    assert_allclose(normal, [[0, 0, 1]], atol=1e-15)


def test_boxes_that_are_apart_have_no_contact():
    depth, normal = fcl.box_contacts(*pair((1, 1, 1), (0, 0, 0), UPRIGHT, (1, 1, 1), (0, 0, 3), UPRIGHT))
    assert depth.tolist() == [0.0]
    assert normal.tolist() == [[0.0, 0.0, 0.0]]


def test_convex_meshes_overlap_where_integers_say_so(cases, rng):
    vertices, triangles = cases.cube()
    answers = []
    for offset in rng.uniform(-1.5, 1.5, (200, 3)):
        moved = vertices + offset
        found = fcl.convex_overlap(vertices, triangles, moved, triangles)
        assert found == (exact.convex_overlap(vertices, triangles, moved, triangles) > 0)
        answers.append(found)
    assert 30 < sum(answers) < 170


def test_a_corner_of_a_surface_is_as_deep_in_a_box_as_the_box_must_shrink(cases):
    vertices, triangles = cases.cube()  # its corner at (1, 1, 1) is 0.05, 0.1 and 0.2 from the box's faces
    size, place = np.array([1.0, 0.8, 0.6]), np.array([1.0, 1.0, 1.0]) + [0.45, 0.3, 0.1]
    step = 0.3 / 2**fcl.BISECTIONS
    assert_allclose(fcl.depth_in_box(size, place, UPRIGHT, vertices, triangles), 0.05, atol=step)
    assert fcl.depth_in_box(size, place + [0.06, 0.0, 0.0], UPRIGHT, vertices, triangles) == 0.0


def test_an_edge_that_goes_through_a_box_is_seen_where_no_corner_is(cases):
    vertices, triangles = cases.cube()  # its edge along z at x = y = 1 goes through the edge along x of a rod
    rod, place = np.array([4.0, 0.2, 0.2]), np.array([0.5, 1.05, 0.5])
    assert_allclose(fcl.depth_in_box(rod, place, UPRIGHT, vertices, triangles), 0.05, atol=0.1 / 2**fcl.BISECTIONS)


def test_a_box_in_a_surface_meets_nothing_of_it(cases):
    assert fcl.depth_in_box(np.full(3, 0.5), np.full(3, 0.5), UPRIGHT, *cases.cube()) == 0.0
    through = fcl.depth_in_box(np.full(3, 0.5), np.array([0.5, 0.5, 1.0]), UPRIGHT, *cases.cube())
    assert_allclose(through, 0.25)
