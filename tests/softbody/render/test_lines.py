"""Lines are as thin everywhere in a picture, closed to the eye on all sides, and seen where they are."""

from __future__ import annotations

import numpy as np
import pytest

import softbody
from softbody import Camera, ParameterError, World
from softbody.render.drawing import Drawing, framed
from softbody.render.lines import KNOT, WIDTH, lines
from softbody.render.rasteriser import render

CAMERA = Camera((0.0, -4.0, 0.0), (0.0, 0.0, 0.0))
SKY = render([], CAMERA, None, (80, 60))


def drawn(*ends, size=(80, 60), camera=CAMERA):
    """Return which pixels (h, w) of bool lines between ends change."""
    picture = render(lines(np.array(ends, float).reshape(-1, 2, 3), camera), camera, None, size)
    return (picture != render([], camera, None, size)).any(axis=2)


def test_no_line_is_no_thing():
    assert lines(np.empty((0, 2, 3)), CAMERA) == []


def test_a_line_is_where_it_is_and_as_thin_near_as_far():
    seen = drawn(((-0.6, -1.5, 0.0), (1.2, 6.0, 0.0)), size=(800, 600))
    rows, columns = np.nonzero(seen)
    np.testing.assert_allclose(rows.mean(), 299.5, atol=1.0)
    thick = seen.sum(axis=0)[columns.min() + 20 : columns.max() - 20]
    assert np.ptp(thick) <= 1
    assert thick.mean() == pytest.approx(600 * WIDTH, abs=1.5)
    assert seen.sum(axis=0).max() == pytest.approx(KNOT * 600 * WIDTH, abs=2.5)


def test_a_line_without_length_is_a_knot():
    rows, columns = np.nonzero(drawn(((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), size=(800, 600)))
    assert (np.ptp(rows), np.ptp(columns)) == pytest.approx((KNOT * 3.0, KNOT * 3.0), abs=3.0)


def test_what_is_behind_the_eye_is_cut_off():
    assert lines(np.array([[[0.0, -5.0, 0.0], [1.0, -6.0, 0.0]]]), CAMERA) == []
    seen = drawn(((0.0, -9.0, 0.5), (0.0, 0.0, -0.1)))
    assert seen.any()
    (thing,) = lines(np.array([[[0.0, -9.0, 0.5], [0.0, 0.0, -0.1]]]), CAMERA)
    assert thing.vertices[:, 1].min() > -4.01


def test_surfaces_of_lines_face_outwards():
    (thing,) = lines(np.array([[[0.0, 0.0, 0.0], [0.3, 0.2, 1.0]], [[0.5, 0.0, 0.0], [0.5, 0.0, 0.0]]]), CAMERA)
    tube = thing.vertices[thing.triangles[:12]]
    normals = np.cross(tube[:, 1] - tube[:, 0], tube[:, 2] - tube[:, 0])
    axis = np.array([0.3, 0.2, 1.0]) / np.linalg.norm([0.3, 0.2, 1.0])
    middle = tube.mean(axis=1)
    assert ((middle - (middle @ axis)[:, None] * axis) * normals).sum(axis=1).min() > 0.0


@pytest.fixture
def joined():
    """A world of a ball on a cord."""
    world = World()
    ball = world.add_soft_body(softbody.icosphere(1, 0.3), 1.0, 100.0, 1.0, name="ball")
    world.add_joint((ball, (0.0, 0.0, 0.3)), (0.0, 0.0, 2.0), 10.0)
    return world


def test_joints_are_in_pictures_unless_they_are_not_wanted(joined):
    camera = Camera((0.0, -6.0, 1.0), (0.0, 0.0, 1.0))
    with_joints = joined.picture(camera=camera, size=(160, 120))
    without = joined.picture(camera=camera, size=(160, 120), show_joints=False)
    rows, columns = np.nonzero((with_joints != without).any(axis=2))
    assert np.ptp(rows) > 40
    assert np.ptp(columns) < 6
    joined.remove(joined.joints[0])
    np.testing.assert_array_equal(joined.picture(camera=camera, size=(160, 120)), without)
    with pytest.raises(ParameterError, match="show_joints is 'no'"):
        joined.picture(show_joints="no")


def test_the_camera_frames_joints_too(joined):
    drawing = Drawing(joined)
    camera = framed(joined, drawing.things(), drawing.joint_ends(), 4.0 / 3.0)
    right, up, far = camera.axes() @ (drawing.joint_ends().reshape(-1, 3) - camera.eye).T
    half = np.tan(0.5 * np.radians(camera.view))
    assert (np.abs(up) < half * far).all()
    assert (np.abs(right) < half * far * 4.0 / 3.0).all()
    assert np.abs(up).max() > 0.8 * half * far.min()


def test_a_joint_that_ends_nowhere_is_named(joined):
    joined.joints[0].target[:] = np.nan
    with pytest.raises(ParameterError, match="joint 0 has an end that is not finite"):
        joined.picture()
