"""Is what all points move in common taken off, and is its stretch never told too large?"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from softbody.geometry.affine_fit import LEAST_STRETCH, fit_affine, solved
from softbody.linalg.quaternion import rotation_matrix


@pytest.fixture
def points():
    return np.random.default_rng(3).normal(size=(40, 3))


def turn(degrees, axis):
    half = 0.5 * np.radians(degrees)
    q = np.append(np.cos(half), np.sin(half) * np.array(axis) / np.linalg.norm(axis))
    return rotation_matrix(q)


def test_solves_three_equations():
    rows = ((2.0, 1.0, 0.0), (0.0, 3.0, 1.0), (1.0, 0.0, 4.0))
    assert_allclose(np.array(rows) @ solved(rows, (1.0, 2.0, 3.0)), [1.0, 2.0, 3.0], atol=1e-15)


def test_a_rigid_motion_is_common_and_stretches_nothing(points):
    after, carried = points @ turn(3.0, [1.0, 2.0, 3.0]).T + [5.0, 0.0, 0.0], np.empty_like(points)
    stretch = fit_affine(points, after, carried)
    assert stretch == pytest.approx(1.0, abs=1e-3)
    way = after - points - [5.0, 0.0, 0.0]
    assert np.linalg.norm(carried - after, axis=1).max() < 0.01 * np.linalg.norm(way, axis=1).max()


@pytest.mark.parametrize("seed", range(10))
def test_no_distance_shrinks_by_more_than_the_stretch(points, seed):
    rng = np.random.default_rng(seed)
    after, carried = points @ (np.eye(3) + 0.2 * rng.normal(size=(3, 3))).T, np.empty_like(points)
    stretch = fit_affine(points, after, carried)
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    carried_apart = np.linalg.norm(carried[:, None] - carried[None], axis=2)
    far = apart > 0.0
    assert stretch <= (carried_apart[far] / apart[far]).min() + 1e-12


def test_what_is_pressed_flat_is_not_common(points):
    after, carried = points * [1.0, 1.0, 0.5 * LEAST_STRETCH], np.empty_like(points)
    assert fit_affine(points, after, carried) == 1.0
    assert_allclose(carried - carried.mean(axis=0), points - points.mean(axis=0), atol=1e-14)
