"""Pictures show what is there: the near before the far, the lit before the dark, shadows on the ground."""

from __future__ import annotations

import numpy as np
import pytest

import softbody
from softbody import Camera
from softbody.render import Thing
from softbody.render.drawing import striped
from softbody.render.rasteriser import SKY
from softbody.render.rasteriser import render as render_in_size

LEVEL = Camera(eye=(0.0, -6.0, 0.0), target=(0.0, 0.0, 0.0))
BALL = softbody.icosphere(2)
RED, BLUE = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def render(things, camera, ground=0.0):
    return render_in_size(things, camera, ground, (64, 48))


def thing(mesh, colour, smooth=True):
    return Thing(mesh.vertices, mesh.triangles, colour, smooth)


def test_nothing_is_sky():
    picture = render([], LEVEL, ground=None)
    assert picture.shape == (48, 64, 3)
    assert picture.dtype == np.uint8
    assert (picture == np.round(255 * SKY)).all()


def test_a_ball_in_the_middle_is_round_and_lit_from_above():
    picture = render([thing(BALL, RED)], LEVEL, ground=None).astype(int)
    red = picture[..., 0] > picture[..., 2] + 20
    rows, columns = np.nonzero(red)
    assert abs(rows.mean() - 23.5) < 0.5
    assert abs(columns.mean() - 31.5) < 0.5
    assert abs(np.ptp(rows) - np.ptp(columns)) <= 1
    # Angular radius asin(1/6) at a focal length of 24/tan(17.5°) pixels.
    assert abs(0.5 * (np.ptp(rows) + 1) - 24.0 / np.tan(np.radians(17.5)) * np.tan(np.arcsin(1 / 6))) < 1.0
    assert picture[18, 31].sum() > picture[30, 31].sum()


def test_the_nearer_one_hides_the_farther_whatever_their_order():
    near, far = thing(BALL.moved((0.0, -2.0, 0.0)), BLUE), thing(BALL, RED)
    one, other = render([near, far], LEVEL, ground=None), render([far, near], LEVEL, ground=None)
    np.testing.assert_array_equal(one, other)
    assert one[23, 31, 2] > one[23, 31, 0]


def test_one_looks_into_a_thing_that_is_clear():
    inside, skin = thing(BALL.scaled(0.5), BLUE), thing(BALL, RED)
    closed = render([inside, skin], LEVEL, ground=None).astype(int)
    skin.is_clear = True
    one, other = (render(both, LEVEL, ground=None) for both in ([inside, skin], [skin, inside]))
    np.testing.assert_array_equal(one, other)
    assert closed[23, 31, 0] > closed[23, 31, 2]
    assert one[23, 31, 2] > one[23, 31, 0]  # the ball inside
    assert one[23, 38, 0] > one[23, 38, 2]  # the far side of the skin, beside it
    assert ((one != 255 * SKY.round()).any(axis=2) == (closed != 255 * SKY.round()).any(axis=2)).all()


def test_what_is_behind_the_camera_is_not_drawn():
    np.testing.assert_array_equal(
        render([thing(BALL.moved((0.0, -12.0, 0.0)), RED)], LEVEL, ground=None), render([], LEVEL, ground=None)
    )


def test_a_thing_above_the_ground_casts_a_shadow():
    camera = Camera(eye=(0.0, -8.0, 8.0), target=(0.0, 0.0, 0.0))
    bare = render([], camera).astype(int).sum(axis=2)
    shaded = render([thing(BALL.moved((0.0, 0.0, 3.0)), RED)], camera)
    grey = np.ptp(shaded.astype(int), axis=2) < 20
    assert (grey & (shaded.astype(int).sum(axis=2) < bare - 100)).sum() > 20


def test_a_faceted_box_shows_flat_faces():
    camera = Camera(eye=(3.0, -4.0, 2.5), target=(0.0, 0.0, 0.0))
    colours = {
        tuple(c)
        for c in render([thing(softbody.box(), RED, smooth=False)], camera, None)[22:26, 30:34, :2].reshape(-1, 2)
    }
    assert len(colours) <= 4


def test_the_same_scene_gives_the_same_bytes():
    scene = [thing(softbody.torus(), RED), thing(BALL.moved((0.0, 0.0, 1.0)), BLUE)]
    assert render(scene, LEVEL).tobytes() == render(scene, LEVEL).tobytes()


DOWN = Camera(eye=(0.0, -4.0, 8.0), target=(0.0, 0.0, 0.0))
PLATE = softbody.box((6.0, 6.0, 1.0))
GREEN = (0.2, 0.6, 0.2)


def test_a_body_casts_a_shadow_on_another():
    plate, ball = thing(PLATE, GREEN, smooth=False), thing(BALL.moved((-0.5, -0.5, 4.0)), RED)
    lit = render([plate], DOWN, None).astype(int)
    shaded = render([plate, ball], DOWN, None).astype(int)
    green = (shaded[..., 1] > shaded[..., 0] + 20) & (lit[..., 1] > lit[..., 0] + 20)
    darker = green & (shaded[..., 1] < 0.7 * lit[..., 1])
    # The light comes from (−0.55, −0.45, 1): 3.5 m under the ball its shadow is 1.9 and 1.6 m further on.
    rows, columns = np.nonzero(darker)
    assert len(rows) > 40
    spot = 31.5 + 24.0 / np.tan(np.radians(17.5)) * 1.4 / 9.0  # 1.4 m to the right, at a distance of 9 m
    assert abs(columns.mean() - spot) < 2.0
    assert (rows < 24).mean() > 0.8  # 1.1 m behind the middle


def test_a_lit_side_is_not_shaded_by_itself():
    top = render([thing(PLATE, GREEN, smooth=False)], DOWN, None)[20:30, 20:44].reshape(-1, 3)
    assert np.ptp(top[:, 2].astype(int)) < 5
    bright = render([thing(BALL, GREEN)], DOWN, None).astype(int)[..., 0].max()
    assert bright > 255 * (0.2 + 0.2)  # the highlight is there, too


def test_what_lies_on_the_ground_is_not_lit_from_below_it():
    lying, floating = (
        render([thing(softbody.box().moved((0.0, 0.0, z)), RED, smooth=False)], DOWN) for z in (0.5, 3.0)
    )
    dark = [(np.ptp(p.astype(int), axis=2) < 20) & (p.sum(axis=2) < 550) for p in (lying, floating)]
    assert dark[0].any()
    assert dark[1].any()
    assert abs(dark[0].sum() - dark[1].sum()) < dark[1].sum()


def test_stripes_are_paler_and_have_a_sharp_edge():
    ball = Thing(BALL.vertices, BALL.triangles, striped(RED), along=0.5 + BALL.vertices[:, 0])
    picture = render([ball], LEVEL, ground=None).astype(int)[24]
    blue = picture[:, 2]
    assert (blue[33:38] > 60).all()
    assert (blue[26:31] < 30).all()


def test_stripes_are_straight_on_a_tilted_face():
    """A stripe is linear in space: seen aslant, half of a side lies in the farther, smaller half of its picture."""
    plate = softbody.box((6.0, 6.0, 0.01))
    banded = Thing(plate.vertices, plate.triangles, striped(RED), smooth=False, along=0.5 + plate.vertices[:, 1])
    camera = Camera(eye=(0.0, -5.0, 3.0), target=(0.0, 0.0, 0.0))
    column = render([banded], camera, None).astype(int)[:, 32]
    pale = np.nonzero(column[:, 2] > 120)[0]
    assert pale.max() in (22, 23)  # y = 0 is in the middle


def test_colours_between_the_first_and_the_last_follow_what_is_linear():
    """A plate seen from above, dark on the left and bright on the right, in 256 steps."""
    plate = softbody.box((4.0, 4.0, 0.01))
    shades = np.repeat(np.linspace(0.0, 1.0, 256)[:, None], 3, axis=1)
    along = (plate.vertices[:, 0] + 2.0) / 4.0
    picture = render([Thing(plate.vertices, plate.triangles, shades, smooth=False, along=along)], DOWN, None)
    row = picture[24, 18:46, 0].astype(int)
    assert (np.diff(row) > 0).all()
    assert np.ptp(np.diff(row)) <= 2


@pytest.mark.parametrize("scale", [0.01, 1.0, 100.0])
def test_a_scene_of_any_size_has_the_same_picture(scale):
    def picture(scale):
        ball = BALL.scaled(scale).moved((0.0, 0.0, 2.0 * scale))
        return render([thing(ball, RED)], Camera((0.0, -8.0 * scale, 5.0 * scale), (0.0, 0.0, scale))).astype(int)

    assert (np.abs(picture(scale) - picture(1.0)).max(axis=2) > 8).mean() < 0.01


def test_a_thing_that_reaches_to_just_before_the_eye_is_drawn():
    near = softbody.box((1.0, 1.0, 1.0)).moved((0.0, -6.0 + 0.5 + 1e-14, 0.0))
    assert render([thing(near, RED, smooth=False)], LEVEL, None).shape == (48, 64, 3)
