"""Claims about the triangle of a mesh closest to a point, and the closest of its points."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import numpy as np

import softbody
from softbody import Mesh
from softbody.geometry import bvh, closest_on_mesh, closest_triangles, triangle
from softbody.geometry.closest_point import Closest, no_answers
from validation.answers import Answers
from validation.cases import points_around, transformed
from validation.check import Comparison, Run, check
from validation.checks.geometry.cases import longest_side, points_on_faces, special_points, varied_meshes
from validation.fault import Fault

FAMILY = "closest triangle"

EDGE_LEFT_OUT = Fault(
    "the edge ca of a triangle left out",
    triangle.squared_distances_to_triangles,
    "square = _along_edges(pc, ca) → square = best",
)
PIECE = "softbody.geometry.bvh.closest_all_in_bvh"
ONE = "softbody.geometry.triangle.closest_point_on_triangle"
MANY = "softbody.geometry.triangle.closest_points_on_triangles"


def _points_near_and_far(mesh: Mesh, rng: np.random.Generator, count: int) -> np.ndarray:
    """Return points around a mesh, far away from it, next to it and on it."""
    special = special_points(mesh, rng, count // 6)
    near, far = points_around(mesh, count, rng), 20.0 * points_around(mesh, count // 4, rng)
    return np.concatenate([near, far, *special.values()])


def _size(mesh: Mesh, points: np.ndarray) -> np.ndarray:
    """Return the length (m,) [m] that the rounding of each answer is a part of: the point's distance and the mesh."""
    return np.linalg.norm(points, axis=1) + longest_side(mesh.vertices)


def _on_varied_meshes(
    run: Run,
    counts: tuple[int, int, int],
    ask: Callable[[np.ndarray, Mesh], tuple[np.ndarray, np.ndarray]],
    subdivisions: int = 3,
) -> Comparison:
    """Ask for what the core and what a judge says of points near and far from meshes of every kind."""
    rng, answers = run.fresh_rng(), Answers()
    for kind, mesh in varied_meshes(rng, subdivisions).items():
        points = _points_near_and_far(mesh, rng, run.count(*counts))
        answers.extend(*ask(points, mesh), _size(mesh, points), kind, point=points)
    return answers.comparison()


def _all_bits(answers: Closest) -> np.ndarray:
    """Return the answers as one array of integers, bit by bit."""
    columns = [answers.triangle[:, None], answers.weights, answers.point, answers.distance[:, None]]
    return np.concatenate([np.ascontiguousarray(column).view(np.int64) for column in columns], axis=1)


@check(
    section="4.3",
    piece=PIECE,
    reference="libigl",
    engines=("igl",),
    unit="of the size",
    tolerance=4e-15,
    because="a dozen roundings on both sides: 3.5e-16 at worst of ten seeds, 4.3e-16 at full",
    faults=(EDGE_LEFT_OUT,),
)
def distance_by_igl(run: Run) -> Comparison:
    """The distance to the closest triangle is libigl's."""
    from references import igl

    same: list[np.ndarray] = []

    def ask(points: np.ndarray, mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
        ours = closest_on_mesh(points, mesh.vertices, mesh.triangles)
        distance, closest, _ = igl.closest_points(points, mesh.vertices, mesh.triangles)
        same.append(ours.triangle == closest)
        return ours.distance, distance

    comparison = _on_varied_meshes(run, (1_000, 6_000, 100_000), ask)
    share = 100.0 * np.concatenate(same).mean()
    comparison.notes = [f"the same triangle in {share:.1f} %; elsewhere several are equally close"]
    return comparison


@check(
    section="4.3",
    piece=PIECE,
    reference="trimesh.proximity",
    engines=("trimesh", "rtree"),
    unit="of the size",
    tolerance=2e-5,
    because="trimesh takes any triangle whose distance is within 1e-5 or so of the least; closer ones count twentyfold",
    faults=(EDGE_LEFT_OUT,),
)
def distance_by_trimesh(run: Run) -> Comparison:
    """No point of a mesh that trimesh finds is closer.

    It finds the same point but for its tolerance.
    """
    from references import trimesh

    farther: list[np.ndarray] = []

    def ask(points: np.ndarray, mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
        ours = closest_on_mesh(points, mesh.vertices, mesh.triangles).distance
        distance, _, _ = trimesh.closest_points(points, mesh.vertices, mesh.triangles)
        farther.append(distance > ours + 1e-9)
        return ours + 20.0 * np.maximum(ours - distance, 0.0), distance

    comparison = _on_varied_meshes(run, (200, 1_000, 20_000), ask, subdivisions=2)
    worse = np.concatenate(farther)
    comparison.notes = [
        f"trimesh's point is farther than the core's by more than 1e-9 m in {worse.sum()} of {len(worse)} cases"
    ]
    return comparison


@check(
    section="4.3, 6",
    piece=PIECE,
    reference="softbody.geometry.closest_point.closest_triangles",
    kind="the core in another form",
    because="both compute the same distances, and take the lowest number of those that are equal",
    faults=(
        Fault(
            "the edge ca of a triangle left out, one at a time",
            triangle.squared_distance_to_triangle,
            "_, square = _along_edge(pc, ca) → square = np.inf",
        ),
        Fault(
            "a foot off the face is kept, of eight",
            triangle._feet_on_faces,
            "where_less(0.0, least, dot(foot, foot), inf) → where_less(-0.1, least, dot(foot, foot), inf)",
        ),
        Fault("the nearest child only", bvh._search, "count += 1 → "),
        Fault(
            "of equally close triangles the one met first",
            bvh._search,
            "square_[s_] < best_ or (square_[s_] == best_ and t_ < closest_) → square_[s_] < best_",
        ),
        Fault(
            "a guess that is taken for the answer",
            bvh._search,
            "limit_ = _in_reach(best_ * to_half_sizes)"
            " → limit = _in_reach(best * to_half_sizes if closest < 0 else 0.3 * best * to_half_sizes)",
        ),
    ),
)
def tree_is_exhaustive(run: Run) -> Comparison:
    """The tree refitted for every step gives the bits of exhaustive search.

    Triangle, weights, point and distance; also of meshes stretched or flattened up to a thousandfold, far away.
    """
    rng, answers = run.fresh_rng(), Answers()
    for kind, mesh in varied_meshes(rng).items():
        vertices = mesh.vertices
        tree = bvh.build_bvh(vertices, mesh.triangles)
        for stretch, far in ((0.15, 0.0), (0.15, 0.0), (1.5, 3.0), (1.5, 3.0)):  # powers of ten
            place = rng.normal(size=3) * 10.0 ** rng.uniform(0.0, far)
            vertices = np.ascontiguousarray(mesh.vertices * 10.0 ** rng.uniform(-stretch, stretch, 3) + place)
            bvh.refit_bvh(tree, vertices)
            points = _points_near_and_far(Mesh(vertices, mesh.triangles), rng, run.count(150, 1_000, 25_000))
            nowhere = points[:12].copy()
            nowhere[np.arange(12), np.arange(12) % 3] = np.repeat([np.nan, np.inf, -np.inf, 1e200], 3)
            points = rng.permutation(np.concatenate([points, nowhere]))
            found = no_answers(len(points))
            bvh.closest_all_in_bvh(points, tree, vertices, found, (0, len(points)))
            same = _all_bits(found) == _all_bits(closest_triangles(points, vertices, mesh.triangles))
            answers.extend(same.all(axis=1), np.ones(len(points), bool), kind=kind, point=points)
    return answers.comparison()


@check(
    section="4.3",
    piece=ONE,
    reference="invariants, evaluated in NumPy",
    unit="of the size",
    kind="invariant",
    tolerance=4e-15,
    because="a dozen roundings of lengths up to the size and the distance",
    faults=(
        Fault(
            "two weights of a face exchanged",
            triangle.closest_weights_on_triangle,
            "weights = (u_, v_, w_) → weights = (u_, w_, v_)",
            nth=3,
        ),
    ),
)
def weights_make_the_point(run: Run) -> Comparison:
    """The weights of a closest point make it of the triangle's corners.

    They are not negative and sum to one; the point is at the distance given.
    """

    def ask(points: np.ndarray, mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
        ours = closest_on_mesh(points, mesh.vertices, mesh.triangles)
        feet = (ours.weights[:, :, None] * mesh.vertices[mesh.triangles[ours.triangle]]).sum(axis=1)
        distance, negative = np.linalg.norm(feet - points, axis=1), np.minimum(ours.weights.min(axis=1), 0.0)
        measured = np.column_stack([feet, distance, ours.weights.sum(axis=1), negative])
        return measured, np.column_stack([ours.point, ours.distance, np.ones(len(points)), np.zeros(len(points))])

    return _on_varied_meshes(run, (300, 3_000, 50_000), ask)


@check(
    section="4.3",
    piece=f"{ONE}, {MANY}",
    reference="trimesh.triangles.closest_point",
    engines=("trimesh",),
    unit="of the size × thinness, the longest side squared over twice the area",
    tolerance=1e-14,
    because="trimesh divides by areas, so roundings grow by thinness, ≤ 1 200: 7.5e-16 of 2 000, 1.6e-15 of 200 000",
    faults=(
        Fault(
            "the foot on a face, in any triangle at large",
            triangle.closest_weights_on_triangle,
            "_foot_on_face(pa_, pb_, pc_, ab_, ca_) → (1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0)",
        ),
        Fault(
            "closest points of many triangles of the first of them",
            triangle.closest_points_on_triangles,
            "load(corners[q], 0) → load(corners[0], 0)",
        ),
        Fault(
            "an edge of a triangle of which the nearer end is taken",
            triangle.closest_weights_on_triangle,
            "(0.0, 1.0 - t_, t_) → (0.0, 1.0 - round(t_), round(t_) * 1.0)",
        ),
    ),
)
def one_triangle_by_trimesh(run: Run) -> Comparison:
    """The closest points of single triangles are those that trimesh finds.

    Of triangles at large, and points near and far.
    """
    from references import trimesh

    rng, count = run.fresh_rng(), run.count(2_000, 20_000, 200_000)
    corners, points = rng.normal(size=(count, 3, 3)), 1.5 * rng.normal(size=(count, 3))
    found, _ = triangle.closest_points_on_triangles(points, corners)
    single = [triangle.closest_point_on_triangle(*map(tuple, (p, *c)))[0] for p, c in zip(points[:200], corners)]
    judged = trimesh.closest_on_triangles(points, corners)
    sides = corners - np.roll(corners, 1, axis=1)
    thinness = (sides**2).sum(axis=2).max(axis=1) / np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    answers = Answers()
    answers.extend(found, judged, thinness, "many at once")
    answers.extend(single, judged[:200], thinness[:200], "one")
    return answers.comparison()


@check(
    section="4.3",
    piece=PIECE,
    reference="invariant: the distances before",
    unit="of the size",
    kind="invariant",
    tolerance=3e-10,
    because="coordinates near 1 000 km are rounded to 1e-10 m; the other groups are at 1e-15",
    faults=(
        Fault("boxes in metres, without a middle", bvh.in_half_sizes, "scale(per_metre, away_) → scale(1.0, away_)"),
    ),
)
def distance_is_invariant(run: Run) -> Comparison:
    """Distances from a mesh stay however it and the points move together.

    They are turned, moved 1 000 km or renumbered; scaled by 1e±6 they scale.
    """
    rng, answers = run.fresh_rng(), Answers()
    factors = {"scaled by 1e6": 1e6, "scaled by 1e-6": 1e-6}
    for mesh in varied_meshes(rng).values():
        points = _points_near_and_far(mesh, rng, run.count(200, 1_500, 30_000))
        before = closest_on_mesh(points, mesh.vertices, mesh.triangles).distance
        for kind, (vertices, triangles, moved) in transformed(mesh, points, rng).items():
            after = closest_on_mesh(moved, vertices, triangles).distance / factors.get(kind, 1.0)
            answers.extend(after, before, _size(mesh, points), kind, point=moved)
    return answers.comparison()


@check(
    section="4.3",
    piece=MANY,
    reference="Python's fractions: the edges one by one",
    unit="of a weight; and of a length",
    kind="exact arithmetic",
    tolerance=0.0,
    because="nothing is rounded: squares of lengths are powers of two",
    faults=(
        Fault(
            "of two edges just as close the second",
            triangle.closest_weights_on_triangle,
            "if square_ < best_:\n    best_ = square_\n    weights_ = (0.0, 1.0 - t_, t_)"
            " → if square_ <= best_:\n    best_ = square_\n    weights_ = (0.0, 1.0 - t_, t_)",
        ),
        Fault(
            "of two edges just as close the last",
            triangle.closest_weights_on_triangle,
            "if square_ < best_:\n    best_ = square_\n    weights_ = (t_, 0.0, 1.0 - t_)"
            " → if square_ <= best_:\n    best_ = square_\n    weights_ = (t_, 0.0, 1.0 - t_)",
        ),
    ),
)
def first_of_equal_edges(run: Run) -> Comparison:
    """The first closest edge of a triangle without area has the point.

    Of ab, bc and ca; or of a triangle that is a point, all of it is at the first corner. In whole numbers, of edges of
    4 and 8.
    """
    rng, count = run.fresh_rng(), run.count(500, 5_000, 50_000)
    axis, places = rng.integers(3, size=count), 4 * rng.integers(0, 3, (count, 3))
    corners, points = np.tile(rng.integers(-3, 4, (count, 1, 3)), (1, 3, 1)), rng.integers(-4, 13, (count, 3))
    corners[np.arange(count), :, axis] += places
    found, weights = triangle.closest_points_on_triangles(points.astype(float), corners.astype(float))
    expected = np.array([_first_edge(point, corner) for point, corner in zip(points, corners)])
    return Comparison(np.column_stack([weights, found]), expected, inputs={"point": points, "corners": corners})


def _first_edge(point: np.ndarray, corners: np.ndarray) -> list[float]:
    """Return the weights of the closest point on the edges ab, bc, ca, of equal ones the first, and the point."""
    best: tuple[Fraction, list[Fraction], list[Fraction]] | None = None
    p, rows = point.tolist(), corners.tolist()
    for k in range(3):
        a, b = rows[k], rows[(k + 1) % 3]
        square = sum((v - u) ** 2 for u, v in zip(a, b))
        along = sum((x - u) * (v - u) for x, u, v in zip(p, a, b))
        t = Fraction(min(max(along, 0), square), square) if square else Fraction(0)
        foot = [u + t * (v - u) for u, v in zip(a, b)]
        away = sum(((x - y) ** 2 for x, y in zip(p, foot)), Fraction(0))
        if best is None or away < best[0]:
            weights = [Fraction(0)] * 3
            weights[k] += 1 - t
            weights[(k + 1) % 3] += t
            best = away, weights, foot
    assert best is not None
    return [float(each) for each in (*best[1], *best[2])]


@check(
    section="4.3",
    piece=MANY,
    reference="the conditions of the closest point of a convex set: (p − x) · (c − x) ≤ 0 for every corner c",
    unit="of the size",
    kind="bound",
    tolerance=4e-15,
    because="rounding of some dozen terms",
    faults=(
        Fault(
            "weights of the closest point of an edge the wrong way round",
            triangle.closest_weights_on_triangle,
            "(t_, 0.0, 1.0 - t_) → (1.0 - t_, 0.0, t_)",
        ),
        Fault(
            "the face of a triangle is never closest",
            triangle.closest_weights_on_triangle,
            "_foot_on_face(pa_, pb_, pc_, ab_, ca_) → (1.0, 0.0, 0.0, inf)",
        ),
        Fault(
            "a point from its weights without one of its edges",
            triangle.weighted_point,
            "add(scale(u_, sub(a_, b_)), scale(w_, sub(c_, b_))) → scale(u_, sub(a_, b_))",
        ),
        Fault(
            "closest points of many triangles a row late",
            triangle.closest_points_on_triangles,
            "store(closest_, q_, point_) → store(closest_, max(q_ - 1, 0), point_)",
        ),
    ),
)
def one_triangle(run: Run) -> Comparison:
    """The closest point of a single triangle has no corner beyond it.

    Seen from the point asked about. Its weights make it, none is negative, and they sum to 1. Of triangles at large,
    thin ones and flat ones.
    """
    rng, count = run.fresh_rng(), run.count(1_000, 10_000, 100_000)
    corners, points = rng.normal(size=(count, 3, 3)), 1.5 * rng.normal(size=(count, 3))
    kinds = np.resize(["at large", "thin", "flat"], count)
    middle = corners[:, 0] + rng.uniform(-0.5, 1.5, (count, 1)) * (corners[:, 1] - corners[:, 0])
    off = np.select([kinds == "thin", kinds == "flat"], [1e-9, 0.0], 1.0)[:, None]
    corners[:, 2] = np.where(off == 1.0, corners[:, 2], middle + off * corners[:, 2])
    found, weights = triangle.closest_points_on_triangles(points, corners)
    reach = np.linalg.norm(points, axis=1) + np.abs(corners).max(axis=(1, 2))
    beyond = ((points - found)[:, None] * (corners - found[:, None])).sum(axis=2)
    measured = [
        np.maximum(beyond.max(axis=1), 0.0) / reach**2,
        np.linalg.norm(found - (weights[:, :, None] * corners).sum(axis=1), axis=1) / reach,
        np.minimum(weights.min(axis=1), 0.0),
        weights.sum(axis=1),
    ]
    return Comparison(np.column_stack(measured), np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)), groups=kinds)


@check(
    section="4.3, 6",
    piece=PIECE,
    reference="libigl",
    engines=("igl",),
    unit="of the distance between the parts",
    tolerance=1e-14,
    because="a dozen roundings on both sides, of places 2e7 m away",
    faults=(
        Fault("units that leave the first side out", bvh.refit_bvh, "high_[0] - low_[0] → 0.0"),
        Fault("units by another corner", bvh.refit_bvh, "high_[0] - low_[0] → high[0] - low[1]"),
        Fault(
            "boxes that are not grown",
            bvh._fit_leaves,
            "in_single((high_ - m_) * per_) + GROWTH → in_single((high - middle[axis]) * per_metre)",
        ),
    ),
)
def parts_far_apart(run: Run) -> Comparison:
    """The tree finds libigl's distances from parts ten thousand kilometres apart.

    Meshes have two parts, along any axis and on either side of the origin; points are close to the surface.
    """
    from references import igl

    rng, answers = run.fresh_rng(), Answers()
    for axis, side in ((axis, side) for axis in range(3) for side in (-1.0, 1.0)):
        kind = f"along {'xyz'[axis]}, {'below' if side < 0.0 else 'above'}"
        for mesh in varied_meshes(rng).values():
            way = np.eye(3)[axis] * side
            vertices = np.concatenate([mesh.vertices + 1e7 * way, mesh.vertices + 2e7 * way])
            triangles = np.concatenate([mesh.triangles, mesh.triangles + len(mesh.vertices)])
            points, _ = points_on_faces(vertices, triangles, rng, run.count(150, 600, 5_000))
            points += 10.0 ** rng.uniform(-4.0, -1.0, (len(points), 1)) * rng.normal(size=points.shape)
            found = closest_on_mesh(points, vertices, triangles).distance
            answers.extend(found, igl.closest_points(points, vertices, triangles)[0], 1e7, kind, point=points)
    return answers.comparison()


@check(
    section="4.3, 6",
    piece="softbody.geometry.bvh.search_space",
    reference="numbers laid down beside that room, and looked at again",
    kind="invariant",
    unit="numbers that have changed",
    tolerance=0.0,
    because="none may",
    faults=(
        Fault("a level too few", bvh.search_space, "tree.level_count.shape[0] + 1 → tree.level_count.shape[0] - 1"),
        Fault("a place for each level", bvh.search_space, "WIDTH * (n_ + 1) → n_ + 1"),
    ),
)
def room_for_searches(run: Run) -> Comparison:
    """A search for the closest triangle writes only into its room.

    That which `search_space` makes for it, in trees of 1 to 5 000 triangles. For points near and far, and in the middle
    of spheres, where all are as close.
    """
    rng, answers = run.fresh_rng(), Answers()
    meshes = [*varied_meshes(rng, 2).values(), *(softbody.icosphere(level) for level in range(1 + run.count(3, 4, 5)))]
    soups = [
        (mesh.vertices, mesh.triangles[rng.permutation(len(mesh.triangles))[:count]])
        for mesh in meshes
        for count in (1, 4, 8, 9, 65, 600)
    ]
    for vertices, triangles in soups + [(mesh.vertices, mesh.triangles) for mesh in meshes]:
        vertices = vertices.copy()  # searches want those that may be written
        tree = bvh.build_bvh(vertices, triangles)
        wider, search = [], []
        for array in bvh.search_space(tree):
            guarded = np.full((len(array) + 64, *array.shape[1:]), 77, array.dtype)
            wider.append(guarded[len(array) :])
            search.append(guarded[: len(array)])
        middle = vertices.mean(axis=0)
        for point in [middle, *(middle + 10.0 ** rng.uniform(-1.0, 2.0, (20, 1)) * rng.normal(size=(20, 3)))]:
            bvh.closest_in_bvh(tuple(point.tolist()), tree, vertices, bvh.Search(*search))
        changed = sum(int((each != 77).sum()) for each in wider)
        answers.add(changed, 0, kind="one leaf" if len(triangles) <= 8 else "more leaves")
    return answers.comparison()
