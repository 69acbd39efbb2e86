"""What a Mesh finds doubtful in itself, and how far points are from it."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

import numpy as np

from softbody import Mesh, MeshError
from softbody.geometry import MeshQuery, build_bvh, query, search_space, self_intersections, triangle_list
from softbody.mesh import mesh
from validation.answers import Answers
from validation.cases import MESH_KINDS, edge_lengths, points_around, random_mesh, rotated
from validation.check import Comparison, Run, check
from validation.checks.geometry.cases import longest_side, random_meshes
from validation.fault import Fault

FAMILY = "what users set and ask"


@check(
    section="beyond the paper",
    piece="softbody.Mesh.check",
    reference="libigl's remesh_self_intersections, with CGAL's exact predicates",
    engines=("igl",),
    faults=(
        Fault(
            "edges of one triangle only",
            self_intersections._meet,
            "segment_meets_triangle(a[i], a[j], b) or segment_meets_triangle(b[i], b[j], a)"
            " → segment_meets_triangle(a[i], a[j], b)",
        ),
        Fault(
            "pairs that share a corner, by another edge",
            self_intersections._how_they_lie,
            "segment_meets_triangle(a[1], a[2], b) → segment_meets_triangle(a[0], a[2], b)",
        ),
        Fault("two of three edges", self_intersections._meet, "range(3) → range(2)"),
    ),
)
def intersections_of_the_surface_with_itself(run: Run) -> Comparison:
    """`Mesh.check` finds all pairs of triangles that go through each other.

    And no others, on meshes of all kinds whose vertices have been moved about.
    """
    from references import igl

    rng, answers = run.fresh_rng(), Answers()
    for kind, smooth in random_meshes(run.count(1, 3, 20), rng):
        mesh = _crumpled(smooth, rng)
        told = [finding.where for finding in mesh.check() if finding.kind == "self-intersections"]
        found = _pairs(np.concatenate([*told, np.empty((0, 2), int)]))
        expected = _pairs(igl.self_intersections(mesh.vertices, mesh.triangles))
        for pair in sorted(found | expected | _pairs(rng.integers(0, len(mesh.triangles), (100, 2)))):
            answers.add(pair in found, pair in expected, kind=kind)
    comparison = answers.comparison()
    comparison.notes = [f"{comparison.expected.sum()} pairs do"]
    return comparison


@check(
    section="beyond the paper",
    piece="softbody.geometry.self_intersections.self_intersections",
    reference="libigl with CGAL's exact predicates; of two over one edge, whole numbers: are they folded?",
    engines=("igl",),
    kind="exact arithmetic",
    because="both are exact; flat triangles are judged with their neighbours over an edge only",
    faults=(
        Fault(
            "folded only if the triangle is large",
            self_intersections._are_folded,
            "own_ > 0.0 and others_ > 0.0 → own_ > 1.0 and others_ > 0.0",
        ),
        Fault(
            "folded onto a flat neighbour",
            self_intersections._are_folded,
            "own_ > 0.0 and others_ > 0.0 → own_ > 0.0 and others_ >= 0.0",
        ),
        Fault("what touches an edge goes by", self_intersections._have_one_sign, "u >= 0.0 → u > 0.0"),
        Fault("a pair before the first", self_intersections.find_pairs, "count = 0 → count = 1"),
    ),
)
def triangles_of_whole_numbers(run: Run) -> Comparison:
    """Pairs of triangles are found that meet beyond what they share.

    That have a point in common besides what their common corners span; and those of one place. In whole numbers: many
    touch, lie in one plane, share corners or are flat.
    """
    from references import igl

    rng, answers = run.fresh_rng(), Answers()
    for turn in range(run.count(30, 150, 2_000)):
        whole = np.unique(rng.integers(0, rng.integers(1, 5, 3), (int(rng.integers(5, 30)), 3)), axis=0)
        faces = rng.integers(0, len(whole), (int(rng.integers(2, 40)), 3))
        faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
        a, b, c = whole[faces].transpose(1, 0, 2)
        is_flat = (np.cross(b - a, c - a) == 0).all(axis=1)
        if turn % 2 == 0:  # without flat ones all is known
            faces, is_flat = faces[is_flat == 0], is_flat[is_flat == 0]
        solid = np.flatnonzero(is_flat == 0)
        if len(solid) < 2:
            continue
        points, place = 2.0 ** rng.integers(-6, 7) * whole, np.arange(len(whole))
        meeting, coincident = self_intersections.self_intersections(points, faces, place)
        found, same = _pairs(meeting), _pairs(coincident)
        meet = {(int(solid[t]), int(solid[u])) for t, u in _pairs(igl.self_intersections(points, faces[solid]))}
        pairs = 0
        for t, u in combinations(range(len(faces)), 2):
            shared = set(faces[t].tolist()) & set(faces[u].tolist())
            if len(shared) < 2 and (is_flat[t] or is_flat[u]):
                continue
            truth = _is_folded(whole, faces[t], faces[u]) if len(shared) == 2 else (t, u) in meet
            kind = f"{len(shared)} corners in common"
            answers.add((t, u) in found, truth and len(shared) < 3, kind=kind)
            answers.add((t, u) in same, len(shared) == 3, kind=kind)
            pairs += truth or len(shared) == 3
        if not is_flat.any():
            tree, room = build_bvh(points, faces), np.empty((1, 3), np.int64)
            nowhere = np.zeros(len(points), bool)
            count = self_intersections.find_pairs(tree, points, place, nowhere, search_space(tree), room)
            answers.add(count == pairs, True, kind="how many")
    return answers.comparison()


def _is_folded(points: np.ndarray, one: np.ndarray, two: np.ndarray) -> bool:
    """Tell whether two triangles with two corners in common, in whole numbers, lie on each other."""
    i, j = (corner for corner in one.tolist() if corner in two)
    across = [points[next(k for k in face.tolist() if k not in (i, j))] - points[i] for face in (one, two)]
    n, m = (np.cross(points[j] - points[i], way) for way in across)
    return not np.cross(n, m).any() and int(n @ m) > 0


def _pairs(rows: np.ndarray) -> set[tuple[int, int]]:
    """Return pairs (p, 2) of numbers, the smaller one first."""
    return {(int(low), int(high)) for low, high in np.sort(rows, axis=1)}


def _crumpled(mesh: Mesh, rng: np.random.Generator) -> Mesh:
    """Return a mesh with its vertices moved by up to two edges each way: it goes through itself in places."""
    length = edge_lengths(mesh.vertices, mesh.edges).mean()
    for _ in range(20):
        far = rng.uniform(0.3, 2.0) * length * rng.uniform(-1.0, 1.0, mesh.vertices.shape)
        try:
            return Mesh(mesh.vertices + far * (rng.random((len(far), 1)) < 0.3), mesh.triangles)
        except MeshError:
            continue
    return mesh


@check(
    section="4.6",
    piece="softbody.geometry.MeshQuery.signed_distance",
    reference="libigl: its closest points, and the sign of its winding number",
    engines=("igl",),
    unit="of the size",
    tolerance=1.5e-15,
    because="rounding of the closest point: 1.4e-16 at worst of ten seeds, 1.8e-16 at full",
    faults=(
        Fault(
            "distances without a sign",
            query.MeshQuery.signed_distance,
            "np.where(inside, -distance, distance) → distance",
        ),
        Fault(
            "distances the other way round",
            query.MeshQuery.signed_distance,
            "np.where(inside, -distance, distance) → np.where(inside, distance, -distance)",
        ),
    ),
)
def signed_distances(run: Run) -> Comparison:
    """The signed distances of points from a mesh are libigl's.

    Of points near and far, inside and outside of meshes of all kinds, before and after they have moved.
    """
    from references import igl

    rng, answers = run.fresh_rng(), Answers()
    for kind, before in random_meshes(1, rng):
        asked = MeshQuery(before)
        for now in (before, rotated(before, rng)):
            asked.move(now.vertices)
            points = points_around(now, run.count(50, 300, 3_000), rng)
            distance, *_ = igl.closest_points(points, now.vertices, now.triangles)
            inside = igl.points_in_mesh(points, now.vertices, now.triangles)
            expected = np.where(inside, -distance, distance)
            answers.extend(asked.signed_distance(points), expected, longest_side(now.vertices), kind)
    return answers.comparison()


TOO_LARGE = 2.0**53  # from here on not every whole number is a real one
MOST_ROWS = 1_431_655_765  # triangles, or vertices: (2³² − 1) / 3


@check(
    section="beyond the paper",
    piece="softbody.Mesh",
    reference="what is documented of both, number by number",
    kind="specification",
    faults=(
        Fault("gaps from 3⁵³ on", mesh.checked_arrays, "np.abs(faces) < 2**53 → np.abs(faces) < 3**53"),
        Fault("indices of one sign", mesh.checked_arrays, "np.abs(faces) < 2**53 → faces < 2**53"),
        Fault("one triangle too few", triangle_list.checked_triangles, "a_ > MOST → a_ >= MOST"),
        Fault("vertices alone", triangle_list.checked_triangles, "max(len(points), len(faces)) → len(points)"),
    ),
)
def indices_that_are_none(run: Run) -> Comparison:
    """Triangles in real numbers are refused by their first wrong index.

    Parts of numbers, numbers from 2⁵³ on, among which there are gaps, and vertices that there are none of. Whatever
    makes a tree refuses what is no whole number, and vertices or triangles by the thousand million.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(4, 20, 200)):
        sphere = random_mesh(str(rng.choice(MESH_KINDS)), rng)
        count = len(sphere.vertices)
        part, large = ": not whole numbers; give vertex indices", " has an index too large; give integers"
        none = f", but vertices run from 0 to {count - 1}; repair its indices"
        for value, named in (
            *((0.5, part), (count - 0.5, part)),
            *((float(count), none), (-1.0, none), (TOO_LARGE - 1.0, none), (1.0 - TOO_LARGE, none)),
            *((TOO_LARGE, large), (-TOO_LARGE, large), (10.0 ** rng.uniform(16.0, 300.0), large)),
        ):
            triangles = sphere.triangles.astype(np.float64)
            place = int(rng.integers(len(triangles))), int(rng.integers(3))
            triangles[place] = np.floor(value) if value > 1e16 else value
            said = _refusal(Mesh, sphere.vertices, triangles)
            kind = f"an index of {value:.5g}" if value < 1e16 else "an index beyond 2⁵³"
            answers.add(said.startswith(f"triangle {place[0]} ") and said.endswith(named), True, kind=kind)
    few, many = np.zeros((1, 3)), "the mesh has more than 1431655765 vertices or triangles; split it"
    for more in ((1, 0), (0, 1), (1, 1), (0, 0)):
        rows = [np.broadcast_to(few, (MOST_ROWS + beyond, 3)) for beyond in more]
        for given in (rows, [rows[0], few], [few, rows[1]]):
            is_many = max(len(each) for each in given) > MOST_ROWS
            expected = many if is_many else "triangles are float64; give vertex indices, as integers"
            kind = "more rows than a tree has room for" if is_many else "as many rows as a tree has room for"
            answers.add(_refusal(build_bvh, *given) == expected, True, kind=kind)
    return answers.comparison()


def _refusal(make: Callable[..., object], *given: np.ndarray) -> str:
    """Return what is said by whoever refuses to make something of arrays; nothing if it is made."""
    try:
        make(*given)
    except MeshError as error:
        return str(error)
    return ""
