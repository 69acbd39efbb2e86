import numpy as np
import pytest
from numpy.testing import assert_allclose

from references import analytic, exact, printed, winding

UPRIGHT = (1.0, 0.0, 0.0, 0.0)


def boxes(size_a, position_a, size_b, position_b, orientation_b=UPRIGHT):
    return [np.array([x], float) for x in (size_a, position_a, UPRIGHT, size_b, position_b, orientation_b)]


def approaching(cases, rng, m=300):
    """Impacts at a point off the line of centres, all of which approach, and the right answer."""
    case, n = cases.impacts(rng, m, "corner")
    point = case[2] + rng.normal(size=(m, 3))
    right = analytic.box_impact(*case, point, n, 0.5)
    hit = np.any(right.velocity_a != case[4], axis=1) | np.any(right.velocity_b != case[10], axis=1)
    case = [x[hit] for x in case]
    return (*case, point[hit], n[hit], 0.5), analytic.box_impact(*case, point[hit], n[hit], 0.5)


def test_with_no_error_switched_on_the_impact_is_the_right_one(cases, rng):
    case, right = approaching(cases, rng)
    for got, want in zip(printed._impact(*case), right):
        assert_allclose(got, want, atol=1e-12)


def test_e1_only_the_second_body_goes_the_wrong_way(cases, rng):
    case, right = approaching(cases, rng)
    got = printed.impact_both_plus(*case)
    assert_allclose(got.velocity_a, right.velocity_a, atol=1e-12)
    v_b, w_b = case[10], case[11]
    assert_allclose(got.velocity_b - v_b, v_b - right.velocity_b, atol=1e-12)
    assert_allclose(got.angular_velocity_b - w_b, w_b - right.angular_velocity_b, atol=1e-12)


@pytest.mark.parametrize(
    "impact", [printed.impact_without_spin, printed.impact_inertia_last, printed.impact_with_body_inertia]
)
def test_e2_e3_e17_break_newtons_law(impact, cases, rng):
    case, right = approaching(cases, rng)
    got = impact(*case)
    _, _, x_a, _, v_a, w_a, _, _, x_b, _, v_b, w_b, point, n, e = case

    def speed(v_a, w_a, v_b, w_b):
        return np.sum((v_a + np.cross(w_a, point - x_a) - v_b - np.cross(w_b, point - x_b)) * n, axis=1)

    approach = speed(v_a, w_a, v_b, w_b)
    assert_allclose(speed(*right), -e * approach, atol=1e-12)
    if impact is not printed.impact_with_body_inertia:  # which obeys it, with the wrong share of spin
        assert np.mean(np.abs(speed(*got) + e * approach) > 1e-3) > 0.9
    assert np.mean(np.abs(got.velocity_a - right.velocity_a).max(axis=1) + np.isinf(case[1]) > 1e-6) > 0.9


def test_e2_is_right_without_spin_and_e17_for_a_box_that_has_not_turned(cases, rng):
    case, _ = approaching(cases, rng)
    case = list(case)
    case[5], case[11] = np.zeros_like(case[5]), np.zeros_like(case[11])
    for got, want in zip(printed.impact_without_spin(*case), analytic.box_impact(*case)):
        assert_allclose(got, want, atol=1e-12)
    case[3] = case[9] = np.tile(UPRIGHT, (len(case[0]), 1))
    for got, want in zip(printed.impact_with_body_inertia(*case), analytic.box_impact(*case)):
        assert_allclose(got, want, atol=1e-12)


def test_e3_by_hand():
    # mass 6, sides 1, I = 1, r = (½, 0, −½), n = z: (r × n) × r · n = 0.25 either way; sides 1, 1, 3 tell them apart
    still = np.zeros((1, 3))
    floor = [[9, 9, 1.0]], [np.inf], [[0, 0, -1.0]], [UPRIGHT], still, still, [[0.5, 0, -0.5]], [[0, 0, 1.0]], 0.0
    cube = printed.impact_inertia_last([[1, 1, 1]], [6.0], still, [UPRIGHT], [[0, 0, -1.0]], still, *floor)
    assert_allclose(cube.velocity_a, [[0, 0, -0.6]], atol=1e-15)
    tall = printed.impact_inertia_last([[1, 1, 3]], [6.0], still, [UPRIGHT], [[0, 0, -1.0]], still, *floor)
    # I = (5, 5, 1): I⁻¹((r×n)×r)·n = 0.25/1 instead of 0.25/5
    assert_allclose(tall.velocity_a, [[0, 0, -0.6]], atol=1e-15)


def test_e5_misjudges_a_tenth_of_the_points_around_a_turned_torus(cases, rng):
    vertices, triangles = cases.torus(1.0, 0.4, 24, 12)
    turned = vertices @ analytic.rotation_matrix([0.9, 0.2, -0.3, 0.4]).T
    points = rng.uniform(-1.5, 1.5, (2000, 3))
    wrong = printed.parity_by_z_difference(points, turned, triangles) != winding.points_in_mesh(
        points, turned, triangles
    )
    assert 0.06 < wrong.mean() < 0.15


def test_e5_is_right_between_a_level_floor_and_ceiling_but_not_below_them(cases):
    # the faces have n_z = ±1 and a_z is the height of the whole face; the floor's n_z = −1 turns its t round
    got = printed.parity_by_z_difference([(0.3, 0.6, 0.5), (0.3, 0.6, 2.0), (0.3, 0.6, -1.0)], *cases.cube())
    assert got.tolist() == [True, False, True]


def test_e6_is_right_about_the_centre_of_a_convex_body_and_grows_with_the_distance(cases):
    vertices, triangles = cases.solid("icosahedron", 1.0)
    volume = analytic.regular_solid_volume("icosahedron", 1.0)
    assert printed.volume_signed_twice(vertices, triangles) == pytest.approx(volume, rel=1e-14)
    assert printed.volume_signed_twice(vertices + 5.0, triangles) > 5 * volume


def test_e6_gives_the_torus_of_the_errata_4_097_for_3_113(cases):
    mesh = cases.torus(1.0, 0.4, 48, 24)
    assert analytic.faceted_torus_volume(1.0, 0.4, 48, 24) == pytest.approx(3.1134, abs=1e-4)
    assert printed.volume_signed_twice(*mesh) == pytest.approx(4.0973, abs=1e-4)


def test_e7_swaps_two_axes():
    assert_allclose(printed.box_inertia_other_order((1.0, 2.0, 3.0), 12.0), [10.0, 13.0, 5.0], rtol=1e-15)


def test_e8_doubles_the_speed_of_free_motion_every_step():
    x, v = printed.mean_of_velocities(np.zeros_like, np.zeros(3), np.array([1.0, 2.0, 3.0]), 0.1)
    assert_allclose(v, [2.0, 4.0, 6.0], rtol=1e-15)
    assert_allclose(x, [0.2, 0.4, 0.6], rtol=1e-15)


def test_e8_has_the_stages_of_the_scheme():
    h, x, v = 0.3, 0.7, -0.2
    v1 = v - x * h / 2
    v2 = v - (x + v1 * h / 2) * h / 2
    v3 = v - (x + v2 * h / 2) * h
    _, got = printed.mean_of_velocities(lambda x: -x, x, v, h)
    assert got == pytest.approx(v + (v + 2 * v1 + 2 * v2 + v3) / 6, rel=1e-15)


def test_e10_moves_by_the_acceleration():
    x, v = printed.moved_by_acceleration([1.0], [2.0], [3.0], 0.5)
    assert (x[0], v[0]) == (2.5, 3.5)


def test_e11_never_misses_but_often_cries_wolf(cases, rng):
    pairs = cases.box_pairs(rng, 3000)
    overlap = exact.boxes_overlap(*pairs) > 0
    seen = printed.boxes_overlap_by_faces(*pairs)
    assert np.all(seen[overlap])
    assert 0.01 < np.mean(~overlap[seen]) < 0.12
    faces = exact.box_separations(*pairs)[:, :6].max(axis=1)
    assert_allclose(printed.box_separation_by_faces(*pairs), faces, atol=1e-13)


def test_e12_misses_the_interval_that_contains_the_other():
    assert printed.intervals_overlap_one_way(0.0, 1.0, 0.5, 2.0)
    assert printed.intervals_overlap_one_way(0.4, 0.6, 0.0, 1.0)
    assert not printed.intervals_overlap_one_way(0.0, 1.0, 0.4, 0.6)
    assert not printed.intervals_overlap_one_way(0.0, 1.0, 2.0, 3.0)
    small_in_large = boxes((1, 1, 1), (0, 0, 0), (4, 4, 4), (0.5, 0, 0))
    large_on_small = boxes((4, 4, 4), (0, 0, 0), (1, 1, 1), (0.5, 0, 0))
    assert printed.boxes_overlap_one_way(*small_in_large).tolist() == [True]
    assert printed.boxes_overlap_one_way(*large_on_small).tolist() == [False]


def test_e12_has_no_false_hit_and_misses_some(cases, rng):
    pairs = cases.box_pairs(rng, 2000)
    overlap = exact.boxes_overlap(*pairs) > 0
    seen = printed.boxes_overlap_one_way(*pairs)
    assert not np.any(seen & ~overlap)
    assert np.mean(~seen[overlap]) > 0.2


def test_e14_finds_nothing_inside_any_tetrahedron(rng):
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], float)
    points = np.concatenate([corners, [(0.25, 0.25, 0.25), (0.1, 0.2, 0.3)], rng.uniform(-1, 2, (200, 3))])
    assert not printed.points_in_tetrahedron_same_size(points, *corners).any()


def test_e14_says_yes_only_where_all_five_determinants_vanish():
    flat = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)]
    assert printed.points_in_tetrahedron_same_size([(5, 5, 0)], *flat).tolist() == [True]


def test_e16_accepts_the_whole_line_through_the_second_and_third_corner():
    triangle = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    inside, outside, on_line = (0.25, 0.25, 0.0), (1.0, 1.0, 0.0), [(2.0, -1.0, 0.0), (-7.0, 8.0, 0.0)]
    assert printed.point_in_triangle([inside, outside, *on_line], *triangle).tolist() == [True, False, True, True]
    # other extensions are refused
    assert printed.point_in_triangle([(2.0, 0.0, 0.0), (0.0, -1.0, 0.0)], *triangle).tolist() == [False, False]


def test_e16_errs_nowhere_else_in_the_plane(rng):
    t0, t1, t2 = np.array([(0.2, 0.1, 0), (1.0, 0.3, 0), (0.4, 1.2, 0)])
    p = np.concatenate([rng.uniform(-1, 2, (3000, 2)), np.zeros((3000, 1))], axis=1)
    weights = np.linalg.solve(np.array([t0, t1, t2])[:, [0, 1]].T[:, 1:] - t0[:2, None], (p[:, :2] - t0[:2]).T).T
    inside = (weights.min(axis=1) >= 0) & (weights.sum(axis=1) <= 1)
    assert 100 < inside.sum() < 1000
    assert np.array_equal(printed.point_in_triangle(p, t0, t1, t2), inside)


def test_e16_lets_a_triangle_whose_second_and_third_corner_coincide_hold_everything(rng):
    t0, t1 = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)
    points = rng.uniform(-9, 9, (50, 3))
    assert printed.point_in_triangle(points, t0, t1, t1).all()
    assert not printed.point_in_triangle(points, t1, t1, t0).any()


def test_e20_is_right_at_random_points_and_wrong_above_and_below_vertices(cases, rng):
    vertices, triangles = cases.torus(1.0, 0.4, 24, 12)
    points = rng.uniform(-1.5, 1.5, (1000, 3))
    assert np.array_equal(
        printed.parity_counting_every_hit(points, vertices, triangles),
        winding.points_in_mesh(points, vertices, triangles),
    )
    shifted = vertices - [0, 0, 0.15]
    inside = winding.points_in_mesh(shifted, vertices, triangles)
    missed = ~printed.parity_counting_every_hit(shifted, vertices, triangles)[inside]
    assert inside.sum() > 50
    assert missed.mean() > 0.8


def test_e20_counts_an_edge_twice_and_an_apex_of_three_triangles_three_times():
    vertices = np.array([(1, 0, 0), (-1, 1, 0), (-1, -1, 0), (0, 0, 1)], float)
    triangles = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    points = [(0, 0, 0.25), (0.5, 0, 0.1), (-0.1, 0.05, 0.25)]  # below the apex, an edge, a face: all inside
    assert printed.parity_counting_every_hit(points, vertices, triangles).tolist() == [True, False, True]
    upside_down = vertices * [1, 1, -1], triangles[:, ::-1]
    points = [(0, 0, -2), (0.5, 0, -2), (-0.1, 0.05, -2)]  # two hits each, if edges and vertices count once
    assert printed.parity_counting_every_hit(points, *upside_down).tolist() == [False, True, False]


def test_e18_stops_a_box_in_the_middle_and_turns_one_that_lies_aside():
    middle = printed.support_half_way((1, 2, 3), 5.0, (0, 0, 2), (0, 0, -1), (0, 0, 0))
    assert_allclose(np.concatenate(middle), 0.0, atol=1e-15)
    # Half-way to a box 0.4 m aside is an arm of 0.2 m: a bar that turns about its end, ω = (m r v)/(I + m r²).
    velocity, spin = printed.support_half_way((1, 2, 3), 5.0, (0.4, 0, 2), (0, 0, -1), (0, 0, 0))
    inertia = 5.0 / 12.0 * (1 + 9)
    assert_allclose(spin, [0, 5.0 * 0.2 / (inertia + 5.0 * 0.2**2), 0])
    assert_allclose(velocity[2], -0.2 * spin[1])  # the point of contact rests


def test_no_points_give_no_answers(cases):
    assert printed.parity_by_z_difference(np.empty((0, 3)), *cases.cube()).shape == (0,)
    assert printed.parity_counting_every_hit(np.empty((0, 3)), *cases.cube()).shape == (0,)
