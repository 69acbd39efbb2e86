"""Is coal asked rightly: boxes and convex meshes against integers, and depths against closed forms?"""

import numpy as np
import pytest

from references import coal, exact


def test_coal_and_integers_agree_on_boxes_beyond_the_margin(cases, rng):
    boxes = cases.box_pairs(rng, 1000)
    clear = np.abs(exact.box_separation(*boxes)) > coal.MARGIN
    overlap = exact.boxes_overlap(*boxes) > 0
    assert 300 < overlap.sum() < 700
    assert np.array_equal(coal.boxes_overlap(*boxes)[clear], overlap[clear])


@pytest.mark.parametrize(
    ("gap", "overlap"), [(-0.5, True), (-2 * coal.MARGIN, True), (2 * coal.MARGIN, False), (1.0, False)]
)
def test_cubes_overlap_down_to_the_margin(cases, gap, overlap):
    vertices, triangles = cases.cube()
    moved = vertices + [1.0 + gap, 0.2, 0.1]
    assert coal.convex_overlap(vertices, triangles, moved, triangles) is overlap


@pytest.mark.parametrize("gap", [-0.25, 0.5])
def test_the_distance_of_cubes_is_their_gap_and_minus_their_depth(cases, gap):
    vertices, triangles = cases.cube()
    moved = vertices + [0.2, 0.1, 1.0 + gap]
    assert coal.convex_distance(vertices, triangles, moved, triangles) == pytest.approx(gap, abs=1e-9)
