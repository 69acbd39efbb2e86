"""Do lanes of segments say what is said of one after the other, to the last bit, with what is no number among them?"""

import numpy as np

from softbody.collision.edge_mesh import Ridge, bits_across, edge_across_edge
from softbody.geometry.segments import LEAST, bits_not_beside, end_of, put_segment, start_of
from softbody.vec import dot, sub


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


def test_edges_are_across_where_the_common_perpendicular_meets_both():
    found = 0
    for rng, segments, ends in cases():
        start, end, left, right = (vec(x) for x in rng.normal(0.0, 1.0, (4, 3)))
        bits = bits_across(segments, Ridge(start, end, left, right))
        for lane in range(8):
            p, q = (np.array(x) for x in ends[lane])
            along, other = q - p, np.subtract(end, start)
            across = np.cross(along, other)
            square = across @ across
            places = [(start - p) @ np.cross(v, across) for v in (other, along)]
            meets = square > 0.0 and all(0.0 <= place <= square for place in places)
            margin = min([abs(x) for place in places for x in (place, place - square)]) if square > 0.0 else 1.0
            if margin > 1e-12:
                assert bits >> lane & 1 == meets
            one = Ridge(vec(p), vec(q), vec(rng.normal(size=3)), vec(rng.normal(size=3)))
            if edge_across_edge(one, Ridge(start, end, left, right), np.inf).depth > 0.0:
                found += 1
                assert bits >> lane & 1
    assert found > 10
