"""A camera has z up, and the one that is chosen for a scene has all of it in the picture."""

from __future__ import annotations

import numpy as np
import pytest

from softbody import Camera, ParameterError
from softbody.render.camera import framing


def test_a_level_camera_has_x_to_the_right_and_z_up():
    np.testing.assert_allclose(Camera((0.0, -2.0, 0.0), (0.0, 0.0, 0.0)).axes(), [[1, 0, 0], [0, 0, 1], [0, 1, 0]])


@pytest.mark.parametrize("height", [-3.0, 3.0])
def test_a_camera_that_looks_straight_down_or_up_has_axes(height):
    axes = Camera((0.0, 0.0, height), (0.0, 0.0, 0.0)).axes()
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(axes[1], [0.0, 1.0, 0.0], atol=1e-15)


@pytest.mark.parametrize("shape", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_every_point_of_a_scene_is_in_the_picture_and_one_is_near_its_edge(shape, scale):
    points = scale * (np.random.default_rng(1).normal(size=(100, 3)) * [3.0, 1.0, 2.0] + [5.0, 6.0, 7.0])
    camera = framing(points, shape)
    right, up, far = camera.axes() @ (points - camera.eye).T
    half = np.tan(0.5 * np.radians(camera.view))
    across, along = np.abs(right) / far / half / shape, np.abs(up) / far / half
    assert (far > 0.0).all()
    assert 0.85 < max(across.max(), along.max()) < 1.0


@pytest.mark.parametrize("points", [np.empty((0, 3)), np.array([[1.0, 2.0, 3.0]])])
def test_nothing_and_a_single_point_have_a_camera_too(points):
    assert np.isfinite(framing(points, 1.0).axes()).all()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), "something to look at"),
        (((0.0, np.nan, 0.0), (0.0, 0.0, 0.0)), "eye is"),
        (((0.0, 0.0, 1.0), (0.0, 0.0)), "target is"),
        (((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), 0.0), "view is"),
        (((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), 180.0), "view is"),
    ],
)
def test_a_camera_with_nowhere_to_look_is_refused(given, message):
    with pytest.raises(ParameterError, match=message):
        Camera(*given)
