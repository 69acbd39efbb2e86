"""Do lanes of segments say what is said of one after the other, to the last bit, with what is no number among them?"""

import numpy as np

from softbody.collision.soft.edge_mesh import SLACK, Ridge, bits_across, edge_across_edge
from softbody.geometry.segments import LEAST, bits_not_beside, bits_not_past, end_of, put_segment, start_of
from softbody.linalg.vec import cross, dot, sub


def vec(rows):
    return tuple(float(x) for x in rows)


def cases():
    """Eight segments at a time, some through the origin, some along each other, some without a length or a number."""
    rng = np.random.default_rng(1)
    for _ in range(200):
        ends = rng.integers(-3, 4, (8, 2, 3)) * rng.choice([1.0, 0.1])
        ends[rng.integers(8), 1] = ends[rng.integers(8), 0]
        ends[rng.integers(8), rng.integers(2), rng.integers(3)] = rng.choice([np.nan, LEAST, 0.5])
        segments = np.empty((9, 8))
        for lane in range(8):
            put_segment(segments, lane, vec(ends[lane, 0]), vec(ends[lane, 1]))
        yield rng, segments, ends


def test_segments_are_where_they_were_put():
    for _, segments, ends in cases():
        for lane in range(8):
            assert np.array_equal([start_of(segments, lane), end_of(segments, lane)], ends[lane], equal_nan=True)


def test_a_segment_is_beside_a_plane_if_both_ends_are():
    for rng, segments, ends in cases():
        point, normal = vec(rng.integers(-2, 3, 3)), vec(rng.integers(-2, 3, 3))
        bits = bits_not_beside(segments, point, normal)
        for lane in range(8):
            before, beyond = (dot(sub(vec(end), point), normal) for end in ends[lane])
            beside = (before > 0.0 and beyond > 0.0) or (before < 0.0 and beyond < 0.0)
            assert bits >> lane & 1 == (not beside)


def test_a_line_is_past_a_triangle_that_has_sides_on_its_left_and_on_its_right():
    past = 0
    for rng, segments, ends in cases():
        corners = [vec(x) for x in rng.integers(-2, 3, (3, 3))]
        bits = bits_not_past(segments, *corners)
        for lane in range(8):
            (p, q), (a, b, c) = (np.array([vec(x) for x in ends[lane]]), np.array(corners) - ends[lane, 0])
            turns = [dot(vec(q - p), cross(vec(x), vec(y))) for x, y in ((b, c), (c, a), (a, b))]
            is_past = any(turn > 0.0 for turn in turns) and any(turn < 0.0 for turn in turns)
            past += is_past
            assert bits >> lane & 1 == (not is_past)
    assert past > 100


def test_no_edge_that_crosses_another_is_left_out_and_few_others_are_kept():
    found = kept = 0
    for rng, segments, ends in cases():
        for deepest in (0.3, 3.0, np.inf):
            start, end, left, right = (vec(x) for x in rng.normal(0.0, 1.0, (4, 3)))
            bits = bits_across(segments, Ridge(start, end, left, right), deepest)
            for lane in range(8):
                one = Ridge(vec(ends[lane, 0]), vec(ends[lane, 1]), vec(rng.normal(size=3)), vec(rng.normal(size=3)))
                crosses = edge_across_edge(one, Ridge(start, end, left, right), deepest).depth > 0.0
                found += crosses
                kept += bits >> lane & 1
                assert bits >> lane & 1 or not crosses
    assert found > 10
    assert kept < 20 * found  # the own sides of the eight are not asked for


def test_edges_are_across_where_the_common_perpendicular_meets_both():
    checked = 0
    for rng, segments, ends in cases():
        start, end, left, right = (vec(x) for x in rng.normal(0.0, 1.0, (4, 3)))
        bits = bits_across(segments, Ridge(start, end, left, right), np.inf)
        for lane in range(8):
            p, q = (np.array(x) for x in ends[lane])
            along, other = q - p, np.subtract(end, start)
            across = np.cross(along, other)
            square = across @ across
            places = [(start - p) @ np.cross(v, across) for v in (other, along)]
            height = (start - p) @ across
            corners = [np.subtract(corner, start) for corner in (left, right)]
            reach = [x - (x @ other) / (other @ other) * other for x in corners]  # from the edge, at right angles
            rises = [np.sign(height) * (across @ x) - SLACK * np.sqrt(square * (x @ x)) for x in reach]
            meets = square > 0.0 and all(0.0 <= place <= square for place in places)
            meets &= all(rise <= 0.0 for rise in rises)
            near = [x for place in places for x in (place, place - square)] + [*rises, height]
            if square > 0.0 and np.abs(near).min() > 1e-6:
                checked += meets
                assert bits >> lane & 1 == meets
    assert checked > 10
