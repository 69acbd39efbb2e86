"""Is the camera a pinhole: are axes, rays and discs those that can be told without it?"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from references import pinhole


def test_axes_of_a_camera_that_looks_along_y_or_down():
    assert_allclose(pinhole.axes((0, 0, 0), (0, 2, 0)), [(1, 0, 0), (0, 0, 1), (0, 1, 0)], atol=1e-15)
    assert_allclose(pinhole.axes((1, 1, 5), (1, 1, 0)), [(1, 0, 0), (0, 1, 0), (0, 0, -1)], atol=1e-15)


def test_axes_are_a_right_handed_frame_with_up_above(rng):
    for eye, target in rng.normal(size=(50, 2, 3)):
        right, up, forward = pinhole.axes(eye, target)
        assert_allclose(np.cross(right, up), -forward, atol=1e-14)
        assert_allclose(forward, (target - eye) / np.linalg.norm(target - eye), atol=1e-14)
        assert up[2] > 0.0
        assert right[2] == pytest.approx(0.0, abs=1e-15)


def test_the_upmost_ray_is_at_half_of_the_view():
    rays = pinhole.rays((0, 0, 0), (0, 1, 0), 60.0, (1, 200)).reshape(200, 3)
    slope = rays[:, 2] / rays[:, 1]
    assert slope[0] + 0.5 * (slope[0] - slope[1]) == pytest.approx(np.tan(np.pi / 6))
    assert slope[0] == pytest.approx(-slope[-1])


def test_a_disc_covers_the_rays_that_meet_the_sphere(rng):
    size, view = (400, 300), 50.0
    eye, target, centre, radius = (0.0, -5.0, 1.0), (0.3, 0.0, 1.2), np.array([1.0, 0.5, 0.4]), 0.8
    rays = pinhole.rays(eye, target, view, size)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    to = centre - eye
    meets = (np.linalg.norm(np.cross(rays, to), axis=1) < radius).reshape(size[::-1])
    rows, columns = np.nonzero(meets)
    disc = pinhole.disc(eye, target, view, size, centre, radius)
    assert_allclose([columns.mean() + 0.5, rows.mean() + 0.5], disc.middle, atol=0.05)
    assert meets.sum() == pytest.approx(disc.area, rel=2e-3)
    farthest = np.hypot(columns + 0.5 - disc.middle[0], rows + 0.5 - disc.middle[1]).max()
    assert farthest == pytest.approx(disc.reach, abs=1.5)
    with pytest.raises(ValueError, match="too near, or looks elsewhere"):
        pinhole.disc(eye, target, view, size, np.array(eye) - (0.0, 3.0, 0.0), radius)
