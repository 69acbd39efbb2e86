import subprocess
import sys

import numpy as np
import pytest
from numpy.testing import assert_allclose

from references import analytic, exact, pybullet

UPRIGHT = (1.0, 0.0, 0.0, 0.0)


def worst(got, want):
    pairs = zip((got.velocity_a, got.angular_velocity_a, got.velocity_b, got.angular_velocity_b), want)
    return np.max([np.abs(g - w).max(axis=1) for g, w in pairs], axis=0)


@pytest.mark.parametrize("maximal_coordinates", [False, True])
@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("kind", ["corner", "edge"])
def test_bullet_and_the_closed_form_agree_on_one_contact(kind, restitution, maximal_coordinates, cases, rng):
    case, _ = cases.impacts(rng, 400, kind)
    got = pybullet.one_impact(*case, restitution, maximal_coordinates)
    one = got.count == 1
    assert one.sum() > 390
    want = analytic.box_impact(*(x[one] for x in case), got.point[one], got.normal[one], restitution)
    error = worst(got, [np.full((400, 3), np.nan)] * 4)
    error[one] = np.max(
        [
            np.abs(g[one] - w).max(axis=1)
            for g, w in zip((got.velocity_a, got.angular_velocity_a, got.velocity_b, got.angular_velocity_b), want)
        ],
        axis=0,
    )
    assert error[one].max() < 1e-11
    moved = np.abs(got.velocity_a - case[4]).max(axis=1) + np.abs(got.velocity_b - case[10]).max(axis=1) > 0
    assert 100 < moved.sum() < 300  # the others part already


def test_the_contact_of_a_corner_is_where_it_was_put(cases, rng):
    case, normal = cases.impacts(rng, 200, "corner")
    got = pybullet.one_impact(*case, 0.5)
    size_a, _, x_a, q_a, _, _, size_b, _, x_b, q_b, _, _ = case
    one = got.count == 1
    assert_allclose(got.normal[one], normal[one], atol=1e-13)
    assert_allclose(got.depth[one], -exact.box_separation(size_a, x_a, q_a, size_b, x_b, q_b)[one], atol=1e-13)
    contact = got.manifolds[0]
    assert_allclose(contact.point_b - contact.point_a, contact.depth[:, None] * contact.normal, atol=1e-14)


def test_quaternions_begin_with_w_and_sizes_are_full_extents():
    half = 0.5**0.5
    rod = [[3.0, 1.0, 1.0]], [1.0], [[0.0, 0.0, 0.0]], [[half, 0, 0, half]], [[0.0, 0, 0]], [[0.0, 0, 0]]
    for y, contacts in ((2.0 - 1e-6, True), (1.9, True), (2.1, False)):
        cube = [[1.0, 1.0, 1.0]], [1.0], [[0.0, y, 0.0]], [UPRIGHT], [[0.0, 0, 0]], [[0.0, 0, 0]]
        assert (pybullet.one_impact(*rod, *cube, 0.0).count[0] > 0) == contacts


def test_boxes_that_do_not_meet_fly_on():
    a = [[1.0, 1.0, 1.0]], [1.0], [[0.0, 0.0, 0.0]], [UPRIGHT], [[1.0, 2.0, 3.0]], [[0.1, 0.2, 0.3]]
    b = [[1.0, 1.0, 1.0]], [2.0], [[5.0, 0.0, 0.0]], [UPRIGHT], [[-4.0, 0.0, 0.0]], [[0.0, 0.0, 7.0]]
    got = pybullet.one_impact(*a, *b, 1.0)
    assert got.count.tolist() == [0]
    assert np.isnan(got.point).all()
    assert np.isnan(got.normal).all()
    assert np.isnan(got.depth).all()
    assert_allclose(worst(got, [np.array(x) for x in (a[4], a[5], b[4], b[5])]), 0.0, atol=1e-12)
    assert got.manifolds[0].point_a.shape == (0, 3)


def test_a_face_that_lands_flat_bounces_without_spin_on_four_points():
    mass_a, mass_b, e = 2.0, 3.0, 0.5
    a = [[1.0, 1.0, 1.0]], [mass_a], [[0.0, 0.0, 1.0 - 1e-6]], [UPRIGHT], [[0.0, 0.0, -1.0]], [[0.0, 0.0, 0.0]]
    b = [[1.0, 1.0, 1.0]], [mass_b], [[0.0, 0.0, 0.0]], [UPRIGHT], [[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0]]
    got = pybullet.one_impact(*a, *b, e)
    impulse = (1 + e) / (1 / mass_a + 1 / mass_b)
    assert got.count.tolist() == [4]
    assert np.isnan(got.point).all()
    assert_allclose(got.velocity_a, [[0, 0, -1 + impulse / mass_a]], atol=1e-13)
    assert_allclose(got.velocity_b, [[0, 0, -impulse / mass_b]], atol=1e-13)
    assert_allclose(got.angular_velocity_a, [[0, 0, 0]], atol=1e-13)
    manifold = got.manifolds[0]
    assert_allclose(manifold.impulse.sum(), impulse, rtol=1e-11)
    assert_allclose(manifold.normal, [[0, 0, 1]] * 4, atol=1e-15)
    assert_allclose(manifold.depth, 1e-6, rtol=1e-9)
    assert_allclose(np.abs(manifold.point_b), [[0.5, 0.5, 0.5]] * 4, atol=1e-12)


def test_a_static_box_stays_and_slow_impacts_bounce_too():
    a = [[1.0, 1.0, 1.0]], [2.0], [[0.0, 0.0, 1.0 - 1e-6]], [UPRIGHT], [[0.0, 0.0, -1e-3]], [[0.0, 0.0, 0.0]]
    b = [[4.0, 4.0, 1.0]], [np.inf], [[0.0, 0.0, 0.0]], [UPRIGHT], [[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0]]
    got = pybullet.one_impact(*a, *b, 0.5)
    assert_allclose(got.velocity_a, [[0, 0, 0.5e-3]], rtol=0, atol=1e-13)
    assert np.array_equal(got.velocity_b, [[0, 0, 0]])


def test_fast_boxes_are_not_clamped():
    a = [[1.0, 1.0, 1.0]], [2.0], [[0.0, 0.0, 1.0 - 1e-6]], [UPRIGHT], [[150.0, 0.0, -400.0]], [[0.0, 0.0, 0.0]]
    b = [[4.0, 4.0, 1.0]], [np.inf], [[0.0, 0.0, 0.0]], [UPRIGHT], [[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0]]
    assert_allclose(pybullet.one_impact(*a, *b, 0.5).velocity_a, [[150, 0, 200]], rtol=1e-12)


def test_nothing_is_left_from_one_trial_to_the_next(cases, rng):
    case, _ = cases.impacts(rng, 10, "corner")
    e = np.linspace(0, 1, 10)
    together = pybullet.one_impact(*case, e)
    for i in range(10):
        alone = pybullet.one_impact(*(x[i : i + 1] for x in case), e[i])
        assert np.array_equal(alone.velocity_a[0], together.velocity_a[i])
        assert np.array_equal(alone.angular_velocity_b[0], together.angular_velocity_b[i])


def test_importing_it_prints_nothing_and_gives_the_streams_back():
    code = "import sys, references.pybullet; print('out'); print('err', file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert (done.stdout, done.stderr) == ("out\n", "err\n")
