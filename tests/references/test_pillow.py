"""Is Pillow asked rightly: are the pixels and times those of files that it wrote itself?"""

import numpy as np
import pytest

from references import pillow

image = pytest.importorskip("PIL.Image")


def test_a_picture_has_its_pixels(tmp_path, rng):
    pixels = rng.integers(0, 256, (5, 7, 3), np.uint8)
    image.fromarray(pixels).save(tmp_path / "a.png")
    assert np.array_equal(pillow.picture(tmp_path / "a.png"), pixels)


def test_a_film_has_its_frames_and_how_long_each_stays(tmp_path):
    shades = (0, 100, 200)
    first, *others = [image.fromarray(np.full((8, 8, 3), shade, np.uint8)) for shade in shades]
    first.save(
        tmp_path / "a.webp", save_all=True, append_images=others, duration=[40, 50, 700], loop=0, lossless=True
    )  # fmt: skip
    film = pillow.film(tmp_path / "a.webp")
    assert film.frames.mean(axis=(1, 2, 3)).tolist() == list(shades)
    assert film.milliseconds.tolist() == [40, 50, 700]
    assert film.loops == 0
