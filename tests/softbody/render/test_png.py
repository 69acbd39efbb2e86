"""A PNG file holds the picture, bit for bit: read by Pillow."""

from __future__ import annotations

import io

import numpy as np
import pytest

from softbody.render.png import png_of


@pytest.mark.parametrize("shape", [(1, 1), (2, 5), (48, 64)])
def test_pillow_reads_the_picture_that_was_written(shape):
    image = pytest.importorskip("PIL.Image")
    picture = np.random.default_rng(0).integers(0, 256, (*shape, 3)).astype(np.uint8)
    found = image.open(io.BytesIO(png_of(picture)))
    assert (found.format, found.mode) == ("PNG", "RGB")
    np.testing.assert_array_equal(np.asarray(found), picture)
