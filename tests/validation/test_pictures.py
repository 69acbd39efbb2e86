"""Films for the report: a still and a loop of each scene, and a camera that can follow."""

from __future__ import annotations

import numpy as np

import softbody
from softbody import Camera
from validation.pictures import FILM, LAST_FRAME, SCENES, SIZE, Scene, following, make_picture


def test_a_scene_leaves_its_last_frame_and_a_loop(tmp_path):
    from PIL import Image

    build, camera = softbody.scenes.ball_drop.build, Camera((0.0, -6.0, 1.0), (0.0, 0.0, 1.0))
    picture = make_picture(Scene("drop", "Balls.", build, camera, seconds=0.2), tmp_path / "pictures")
    assert (picture.name, picture.animation) == ("drop", "pictures/drop.webp")
    assert (picture.still, picture.motion) == ("pictures/drop.png", "pictures/drop.npz")
    loop, still = (Image.open(tmp_path / place) for place in (picture.animation, picture.still))
    assert (loop.n_frames, loop.size, still.size) == (3, SIZE, SIZE)
    loop.seek(2)
    assert np.abs(np.asarray(loop.convert("RGB")).astype(int) - np.asarray(still)).mean() < 4.0
    assert loop.info["duration"] == 1000 // FILM + 1000 * LAST_FRAME


def test_a_camera_that_follows_goes_along_x_with_the_first_body():
    world = softbody.World()
    world.add_soft_body(softbody.icosahedron(), 1.0, 10.0, 1.0, (3.0, 2.0, 1.0))
    camera = following(Camera((0.0, -6.0, 1.0), (0.0, 0.0, 1.0)), world)
    np.testing.assert_allclose((camera.eye, camera.target), [(3.0, -6.0, 1.0), (3.0, 0.0, 1.0)])


def test_every_film_has_its_own_name():
    assert len({scene.name for scene in SCENES}) == len(SCENES)
