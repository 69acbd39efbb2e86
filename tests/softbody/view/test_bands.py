"""Bands are the mesh, cut where the quantity says."""

from __future__ import annotations

import numpy as np

import softbody
from softbody.view.bands import LEVELS, bands_of

BALL = softbody.icosphere(3)


def test_all_bands_together_are_the_mesh():
    parts = bands_of(BALL.vertices, BALL.triangles, BALL.vertices[:, 2], -1.0, 1.0)
    assert len(parts) == LEVELS
    corners = np.concatenate([vertices[triangles] for vertices, triangles in parts])
    assert sorted(map(tuple, corners.reshape(-1, 9))) == sorted(
        map(tuple, BALL.vertices[BALL.triangles].reshape(-1, 9))
    )


def test_a_band_lies_where_its_part_of_the_range_is():
    for k, (vertices, triangles) in enumerate(bands_of(BALL.vertices, BALL.triangles, BALL.vertices[:, 2], -1.0, 1.0)):
        means = vertices[triangles].mean(axis=1)[:, 2]
        assert (means >= -1.0 + 2.0 * k / LEVELS - 1e-12).all()
        assert (means <= -1.0 + 2.0 * (k + 1) / LEVELS + 1e-12).all()
        assert len(np.unique(triangles)) == len(vertices)


def test_what_is_everywhere_the_same_is_one_band():
    parts = bands_of(BALL.vertices, BALL.triangles, np.full(len(BALL.vertices), 3.0), 3.0, 3.0)
    assert [len(triangles) for _, triangles in parts] == [len(BALL.triangles)] + [0] * (LEVELS - 1)
