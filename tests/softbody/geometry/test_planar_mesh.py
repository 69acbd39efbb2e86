"""Is a planar region filled by its border's edges and good triangles, whatever the border and its numbering?"""

from fractions import Fraction
from itertools import combinations, permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from softbody.errors import MeshError, ParameterError
from softbody.geometry.planar_mesh import planar_mesh

TRIANGLE = np.array([(0.0, 0.0), (1.0, 0.0), (0.3, 0.8)])


def loop(points):
    """A border of one loop, in the order of its points."""
    numbers = np.arange(len(points))
    return points, np.stack([numbers, np.roll(numbers, -1)], axis=1)


def join(*borders):
    starts = np.cumsum([0, *(len(points) for points, _ in borders)])
    edges = [edges + start for (_, edges), start in zip(borders, starts)]
    return np.concatenate([points for points, _ in borders]), np.concatenate(edges)


def hole(border):
    return border[0], border[1][:, ::-1]


def moved(border, turn=0.0, scale=1.0, shift=(0.0, 0.0)):
    c, s = np.cos(turn), np.sin(turn)
    return scale * border[0] @ np.array([(c, s), (-s, c)]) + np.array(shift), border[1]


def star(radii):
    """A loop around the origin."""
    angle = 2.0 * np.pi * np.arange(len(radii)) / len(radii)
    return loop(np.asarray(radii)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1))


def circle(count, radius=1.0):
    return star(np.full(count, radius))


def path(corners, spacing=1.0):
    """A loop along straight runs of points, about `spacing` apart."""
    sides = zip(corners, corners[1:] + corners[:1])
    return loop(np.concatenate([run(np.array(a), np.array(b), spacing) for a, b in sides if a != b]))


def run(a, b, spacing):
    count = max(1, round(np.linalg.norm(b - a) / spacing))
    return a + np.arange(count)[:, None] / count * (b - a)


def box(columns, rows):
    """A loop of points 1 apart."""
    return path([(0.0, 0.0), (float(columns), 0.0), (float(columns), float(rows)), (0.0, float(rows))])


def renumbered(border, seed):
    points, edges = border
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(points))
    place = np.empty(len(points), np.int64)
    place[order] = np.arange(len(points))
    return points[order], rng.permutation(place[edges])


def exact_area(points, corners):
    """Twice the area of a triangle."""
    (ax, ay), (bx, by), (cx, cy) = (map(Fraction, points[i]) for i in corners)
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)


def area_within(points, edges):
    (px, py), (qx, qy) = points[edges[:, 0]].T, points[edges[:, 1]].T
    return 0.5 * np.sum(px * qy - qx * py)


def angles(points, triangles):
    """The angles (t, 3) [°] at the corners of triangles."""
    found = []
    for k in range(3):
        a, b, c = (points[triangles[:, (k + m) % 3]] for m in range(3))
        u, v = b - a, c - a
        turn = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
        found.append(np.degrees(np.arctan2(turn, np.sum(u * v, axis=1))))
    return np.stack(found, axis=1)


def lengths(points, triangles):
    return np.linalg.norm(points[triangles] - points[np.roll(triangles, -1, axis=1)], axis=2)


def meshed(border, spacing):
    """All points and the triangles of a region, after a look at everything that always holds of them."""
    points, edges = border
    inner, triangles = planar_mesh(points, edges, spacing)
    everything = np.concatenate([points, inner])
    assert all(exact_area(everything, corners) > 0 for corners in triangles.tolist())
    check_edges(edges, triangles)
    check_loops_and_parts(len(everything), edges, triangles)
    check_delaunay(everything, edges, triangles)
    (ax, ay), (bx, by), (cx, cy) = (everything[triangles[:, k]].T for k in range(3))
    area = 0.5 * np.sum((bx - ax) * (cy - ay) - (by - ay) * (cx - ax))
    middle = points.mean(axis=0)
    assert area == pytest.approx(area_within(points - middle, edges), rel=1e-13)
    return everything, triangles


def half_edges(triangles):
    return [(t[k], t[(k + 1) % 3]) for t in triangles.tolist() for k in range(3)]


def check_edges(edges, triangles):
    """The border's edges are of one triangle, in their direction, all others of two, in opposite directions."""
    halves = half_edges(triangles)
    known = set(halves)
    assert len(known) == len(halves)
    alone = {(a, b) for a, b in halves if (b, a) not in known}
    assert alone == {(a, b) for a, b in edges.tolist()}
    assert len({tuple(sorted(corners)) for corners in triangles.tolist()}) == len(triangles)


def check_loops_and_parts(count, edges, triangles):
    """Every point is of a triangle, and Euler's characteristic is that of so many parts with so many loops."""
    assert set(triangles.ravel().tolist()) == set(range(count))
    loops = pieces(len(edges), edges)
    parts = pieces(count, np.array(half_edges(triangles)))
    edge_count = (3 * len(triangles) + len(edges)) // 2
    assert count - edge_count + len(triangles) == 2 * parts - loops


def pieces(count, pairs):
    """How many pieces so many points are, joined by pairs."""
    return connected_components(coo_array((np.ones(len(pairs)), pairs.T), (count, count)), directed=False)[0]


def check_delaunay(points, edges, triangles):
    """Opposite to each edge that is not of the border are two angles that are no more than 180° together."""
    opposite = dict(zip(half_edges(triangles), np.roll(angles(points, triangles), 1, axis=1).ravel()))
    border = {(a, b) for a, b in edges.tolist()}
    assert all(angle + opposite[b, a] < 180.0 + 1e-6 for (a, b), angle in opposite.items() if (a, b) not in border)


radii = st.lists(st.floats(0.5, 1.5), min_size=3, max_size=30)
seeds = st.integers(0, 2**32 - 1)


@given(radii, st.floats(0.1, 1.0), st.floats(0.0, 7.0))
def test_a_star_is_filled(radii, spacing, turn):
    meshed(moved(star(radii), turn), spacing)


@given(radii, st.lists(st.floats(0.05, 0.2), min_size=3, max_size=12), st.floats(0.1, 1.0))
def test_a_star_with_a_hole_and_an_island_in_it_is_filled(radii, small, spacing):
    meshed(join(star(radii), hole(star(small)), moved(star(small), scale=0.25)), spacing)


@given(st.lists(st.integers(1, 6), min_size=2, max_size=6), st.floats(0.3, 2.0), st.floats(0.0, 7.0))
def test_stairs_of_straight_runs_are_filled_however_they_are_turned(steps, spacing, turn):
    """Where they are turned, rounding bends the runs to either side."""
    heights = np.repeat(steps, 2).astype(float)
    across = np.repeat(np.arange(len(steps) + 1.0), 2)[1:-1]
    stairs = path([*zip(across[::-1].tolist(), heights[::-1].tolist()), (0.0, 0.0), (float(len(steps)), 0.0)], 0.5)
    meshed(moved(stairs, turn), spacing)


@given(st.integers(3, 60), st.integers(0, 3), seeds)
def test_points_on_a_few_lines_a_rounding_off_are_filled(count, steps, seed):
    """Comb-like loops of points whose coordinates are nearly or just those of a grid."""
    rng = np.random.default_rng(seed)
    low, high = np.zeros(count), rng.integers(1, 3, count).astype(float)
    x = np.arange(float(count))
    points = np.concatenate([np.stack([x, low], axis=1), np.stack([x, high], axis=1)[::-1]])
    points += 1e-16 * rng.integers(-steps, steps + 1, points.shape)
    meshed(loop(points), 0.8)


@given(st.integers(3, 40), st.floats(0.05, 0.9), seeds)
def test_numbers_of_the_border_do_not_matter(count, inner_radius, seed):
    rng = np.random.default_rng(seed)
    border = join(star(rng.uniform(1.0, 1.5, count)), hole(circle(max(3, count // 3), inner_radius * 0.8)))
    points, triangles = meshed(border, 0.3)
    others, other_triangles = meshed(renumbered(border, seed), 0.3)
    apart = np.linalg.norm(points[:, None] - others, axis=2)
    assert apart.shape[0] == apart.shape[1]
    assert apart.min(axis=0).max() < 1e-12
    assert len(triangles) == len(other_triangles)


@given(st.integers(1, 12), st.integers(1, 12), st.floats(0.0, 7.0), seeds)
def test_a_box_is_the_same_however_it_is_numbered_though_a_square_has_no_axis(columns, rows, turn, seed):
    border = moved(box(columns, rows), turn)
    points, _ = meshed(border, 1.0)
    others, _ = meshed(renumbered(border, seed), 1.0)
    apart = np.linalg.norm(points[:, None] - others, axis=2)
    assert apart.shape[0] == apart.shape[1]
    assert apart.min(axis=0).max() < 1e-12


def test_the_lattice_turns_with_a_region_that_is_longer_than_wide():
    points, _ = meshed(box(9, 4), 1.0)
    turned, _ = meshed(moved(box(9, 4), 0.7, shift=(3.0, 5.0)), 1.0)
    assert turned == pytest.approx(moved((points, None), 0.7, shift=(3.0, 5.0))[0], abs=1e-12)


GOOD = {
    "circle": circle(60),
    "circle far away": moved(circle(40), shift=(1e5, -3e5)),
    "square": moved(box(14, 14), 0.3),
    "box": box(20, 7),
    "annulus": join(circle(60), hole(circle(24, 0.4))),
    "island in a hole": join(circle(72, 1.2), hole(circle(44, 0.75)), circle(20, 0.35)),
    "box with a square hole": join(box(16, 12), hole(moved(box(4, 4), shift=(6.0, 4.0)))),
    "angle": path([(0.0, 0.0), (12.0, 0.0), (12.0, 5.0), (5.0, 5.0), (5.0, 12.0), (0.0, 12.0)]),
}


@pytest.mark.parametrize("border", GOOD.values(), ids=GOOD.keys())
def test_triangles_are_good_where_the_border_is_as_dense_as_they(border):
    sides = border[0][border[1]]
    spacing = np.linalg.norm(sides[:, 0] - sides[:, 1], axis=1).mean()
    points, triangles = meshed(border, spacing)
    assert angles(points, triangles).min() > 24.0
    assert lengths(points, triangles).min() > 0.6 * spacing
    assert lengths(points, triangles).max() < 1.8 * spacing
    area = area_within(border[0] - border[0].mean(axis=0), border[1])
    dense = area / (0.5 * np.sqrt(3.0) * spacing**2)  # points of an endless lattice on so much area
    near_border = len(border[0]) * 0.618 / (0.5 * np.sqrt(3.0))
    assert len(points) - len(border[0]) == pytest.approx(dense - near_border, rel=0.15)


def test_what_is_too_thin_for_inner_points_has_none():
    for border in (loop(TRIANGLE), box(8, 1), moved(box(1, 1), 0.5)):
        points, triangles = meshed(border, 1.0)
        assert len(points) == len(border[0])
        assert len(triangles) == len(points) - 2
    assert planar_mesh(*loop(TRIANGLE), 1.0)[0].shape == (0, 2)


def test_long_edges_are_kept_beside_dense_ones():
    """Across a comb's back there are as many edges to flip as it has teeth."""
    teeth = [(float(x), 0.02 if x % 2 else 1e-9) for x in range(30, -1, -1)]
    meshed(loop(np.array([(0.0, 0.0), (30.0, 0.0), *teeth])), 0.7)
    teeth = [(float(x), 0.02 if x % 2 else 3.0) for x in range(30, -1, -1)]
    meshed(loop(np.array([(-0.5, 0.0), (30.5, 0.0), *teeth])), 0.7)


@given(st.lists(st.floats(0.1, 0.6), min_size=5, max_size=30), st.floats(0.2, 1.0))
def test_a_band_along_a_spiral_is_filled(steps, spacing):
    """Its turns are so near to each other, and its points so far apart, that most edges have to be forced."""
    angle = np.cumsum(steps)
    way = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    outer, inner = (1.9 + 0.3 * angle)[:, None] * way, (1.0 + 0.3 * angle)[:, None] * way
    meshed(loop(np.concatenate([outer, inner[::-1]])), spacing)


grid = st.tuples(st.integers(0, 4), st.integers(0, 3))


@given(st.lists(grid, min_size=3, max_size=9, unique=True), st.floats(0.3, 3.0))
def test_any_loop_on_a_grid_is_filled_unless_it_meets_itself_or_is_a_hole(places, spacing):
    border = loop(np.array(places, float))
    if not meets_itself(*border) and area_within(*border) > 0.0:
        meshed(border, spacing)
    else:
        with pytest.raises(MeshError, match="meets" if meets_itself(*border) else "has the region not on its left"):
            planar_mesh(*border, spacing)


@given(st.lists(grid, min_size=6, max_size=12, unique=True), st.integers(3, 9))
def test_two_loops_on_a_grid_that_meet_are_refused(places, split):
    border = join(loop(np.array(places[:split], float)), loop(np.array(places[split:], float).reshape(-1, 2)))
    if len(places) >= split + 3 and meets_itself(*border):
        with pytest.raises(MeshError, match="meets"):
            planar_mesh(*border, 0.7)


def meets_itself(points, edges):
    """Whether two edges have more in common than an end of both: exact on a grid."""
    pairs = combinations(edges.tolist(), 2)
    return any(meet_apart(points, *one, *other) for one, other in pairs if not set(one) & set(other)) or any(
        fold(points, *one, *other) for one, other in permutations(edges.tolist(), 2) if one[1] == other[0]
    )


def meet_apart(points, a, b, c, d):
    """Whether edges without a common end meet."""
    at_c, at_d, at_a, at_b = (np.sign(exact_area(points, t)) for t in ((a, b, c), (a, b, d), (c, d, a), (c, d, b)))
    if at_c == at_d == 0:
        low, high = (
            np.stack([pick(points[[a, b]], axis=0), pick(points[[c, d]], axis=0)]) for pick in (np.min, np.max)
        )
        return bool((low.max(axis=0) <= high.min(axis=0)).all())
    return at_c != at_d and at_a != at_b


def fold(points, a, b, _, c):
    """Whether an edge runs back along the one that it follows."""
    return exact_area(points, (a, b, c)) == 0 and (points[a] - points[b]) @ (points[c] - points[b]) > 0.0


@pytest.mark.parametrize("scale", [1e-20, 1e-6, 1e6, 1e20])
def test_units_do_not_matter(scale):
    points, triangles = meshed(moved(box(8, 5), 0.4), 1.0)
    scaled, same_triangles = meshed(moved(box(8, 5), 0.4, scale), scale)
    assert scaled == pytest.approx(scale * points, abs=1e-12 * scale)
    assert len(triangles) == len(same_triangles)


def test_the_same_bits_come_each_time():
    border = join(circle(30), hole(circle(12, 0.4)))
    for one, other in zip(planar_mesh(*border, 0.2), planar_mesh(*border, 0.2)):
        assert one.tobytes() == other.tobytes()


SQUARE = box(2, 2)
BAD = {
    "two loops cross": (join(SQUARE, moved(SQUARE, shift=(1.5, 0.6))), r"the border's edge from point \d+ at .* meets"),
    "a hole crosses the outside": (join(box(4, 4), hole(moved(SQUARE, shift=(2.5, 0.6)))), "meets the border's edge"),
    "a loop crosses itself": (loop(np.array([(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)])), "point 3 .* meets"),
    "a corner on an edge": (
        join(loop(TRIANGLE), loop(np.array([(0.5, 0.0), (0.0, -1.0), (1.0, -1.0)]))),
        r"edge from point 0 at .* to point 1 at .* meets point 3 at \[0.5 0. \] m",
    ),
    "a corner on a corner": (
        join(loop(TRIANGLE), moved(loop(TRIANGLE), shift=(1.0, 0.0))),
        r"points 1 and 3 are both at \[1. 0.\] m; let loops keep apart",
    ),
    "all on a line": (loop(np.array([(0.0, 0.0), (1.0, 1.0), (2.0, 2.0)])), "edge from point 2 .* meets point 1 at"),
    "two points": (join(loop(TRIANGLE), loop(np.array([(4.0, 0.0), (5.0, 0.0)]))), "meets the border's edge from"),
    "all at a point": (loop(np.zeros((4, 2))), "points 0 and 1 are both at"),
    "a hole without a region": (hole(SQUARE), "has the region not on its left"),
    "a hole that turns like the outside": (join(box(4, 4), moved(SQUARE, shift=(1.0, 1.0))), "or on both sides"),
    "a region in a hole without one": (
        join(SQUARE, hole(moved(box(4, 4), shift=(-1.0, -1.0)))),
        "has the region not on its left, or",
    ),
    "an open path": ((TRIANGLE, np.array([(0, 1), (1, 2), (2, 1)])), "no border edge ends at point 0"),
    "a point alone": ((TRIANGLE, np.array([(0, 1), (1, 0), (0, 2)])), "no border edge starts at point 2"),
    "a loop of one point": ((TRIANGLE, np.array([(0, 1), (1, 0), (2, 2)])), "edge runs from point 2 to itself"),
    "not a number": ((TRIANGLE * [[1.0], [np.nan], [1.0]], loop(TRIANGLE)[1]), "border point 1 is at .* not finite"),
    "two points only": (loop(TRIANGLE[:2]), r"shape \(2, 2\)"),
    "in space": ((np.zeros((3, 3)), loop(TRIANGLE)[1]), r"shape \(3, 3\)"),
}


@pytest.mark.parametrize(("border", "message"), BAD.values(), ids=BAD.keys())
def test_a_border_that_is_none_is_refused_by_name(border, message):
    with pytest.raises(MeshError, match=message):
        planar_mesh(*border, 0.5)


@pytest.mark.parametrize("spacing", [0.0, -1.0, np.nan, np.inf, 1e-13])
def test_a_spacing_that_is_none_is_refused(spacing):
    with pytest.raises(ParameterError, match=r"the spacing is .* m; give a positive one"):
        planar_mesh(*loop(TRIANGLE), spacing)


def test_thousands_of_points_are_filled_whatever_their_order():
    rng = np.random.default_rng(5)
    border = join(circle(600), hole(circle(300, 0.5)))
    points, _ = meshed(renumbered(border, 1), 0.02)
    assert len(points) > 5000
    rough = star(rng.uniform(1.0, 1.5, 1500))
    meshed(renumbered(rough, 2), 0.05)
