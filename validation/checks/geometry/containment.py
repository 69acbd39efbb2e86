"""Claims about points in meshes, tetrahedra and triangles."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import softbody
from softbody import Mesh
from softbody.geometry import bvh, parity_grid, penetration, polyhedron, tetrahedron, triangle
from softbody.geometry.query import MeshQuery, closest_on_mesh, points_in_mesh
from softbody.linalg.vec import load
from validation.answers import Answers
from validation.arbitration import US, arbitrate
from validation.cases import (
    BOX_TRIANGLES,
    dented_sphere,
    edge_points,
    lumpy_sphere,
    points_around,
    rotated,
    stacked_points,
    transformed,
)
from validation.check import Comparison, Misprint, Run, check
from validation.checks.geometry.cases import points_on_faces, special_points, unit_normals, varied_meshes
from validation.engines import missing
from validation.fault import Fault

FAMILY = "containment"

STEEP_TRIANGLES = Fault(
    "a ray that misses steep triangles",
    polyhedron.ray_hits_triangle_filtered,
    "if p_[2] < min(a_[2], b_[2], c_[2]):\n    return 1"
    " → if abs(cross(sub(b_, a_), sub(c_, a_))[2]) < 1e-3:\n    return 0\n"
    "if p_[2] < min(a_[2], b_[2], c_[2]):\n    return 1",
)
COUNTED_AGAIN = Fault(
    "a grid that counts the triangles above a known level again",
    parity_grid.points_in_parity_grid,
    "_wanted(x_, y_, level_, known_ - 1) → _wanted(x_, y_, level_, LEVELS - 1)",
)
NEAR_MISSES = Fault(
    "points within 1e-9 m below a triangle not under it",
    polyhedron.ray_hits_triangle_filtered,
    "orient3d_filtered(a_, b_, c_, p_) → orient3d_filtered(a_, b_, c_, (p_[0], p_[1], p_[2] + 1e-9))",
)
CONCAVE = "softbody.geometry.polyhedron.points_in_polyhedron"
GRID = "softbody.geometry.parity_grid.points_in_parity_grid"

Judge = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]


def _by(
    judge: Judge,
    meshes: dict[str, Mesh],
    points_for: Callable[[Mesh], np.ndarray],
    core: Judge = polyhedron.points_in_polyhedron,
    printed: Judge | None = None,
) -> Comparison:
    """Ask the core, a judge, and the paper's printed form if there is one, about points for each mesh."""
    answers, misprinted = Answers(), []
    for kind, mesh in meshes.items():
        points = points_for(mesh)
        asked = points, mesh.vertices, mesh.triangles
        answers.extend(core(*asked), judge(*asked), kind=kind, point=points)
        if printed:
            misprinted.append(printed(*asked))
    return answers.comparison(printed=np.concatenate(misprinted) if printed else None)


def _by_random_points(
    run: Run, counts: tuple[int, int, int], judge: Judge, margin: float, printed: Judge | None = None
) -> Comparison:
    """Ask about random points that are farther from a torus and three spheres than a judge's margin [m]."""
    rng = run.fresh_rng()
    meshes = {
        "torus": rotated(softbody.torus(1.0, 0.4, 36, 18), rng),
        "sphere": rotated(softbody.icosphere(3), rng),
        "dented sphere": rotated(dented_sphere(3), rng),
        "lumpy sphere": rotated(lumpy_sphere(rng, 3, 0.4), rng),
    }

    def points_for(mesh: Mesh) -> np.ndarray:
        return _far_from_surface(points_around(mesh, run.count(*counts), rng), mesh, margin)

    return _by(judge, meshes, points_for, printed=printed)


def _far_from_surface(points: np.ndarray, mesh: Mesh, band: float) -> np.ndarray:
    """Return those points that are more than `band` [m] in front of or behind every triangle's plane or box."""
    corners = mesh.vertices[mesh.triangles]
    normals = unit_normals(corners)
    offsets = (normals * corners[:, 0]).sum(axis=1)
    low, high = corners.min(axis=1) - band, corners.max(axis=1) + band
    near = np.zeros(len(points), bool)
    for start in range(0, len(points), 1000):
        part = points[start : start + 1000]
        close = np.abs(part @ normals.T - offsets) <= band
        boxed = ((part[:, None] >= low) & (part[:, None] <= high)).all(axis=2)
        near[start : start + 1000] = (close & boxed).any(axis=1)
    return points[~near]


@check(
    section="4.6",
    piece=CONCAVE,
    reference="trimesh with rtree",
    engines=("trimesh", "rtree"),
    because="trimesh is right beyond 1e-5 m of the surface, and points nearer are passed over",
    faults=(STEEP_TRIANGLES,),
    erratum=Misprint("E5", "t = (a_z − p_z)/n_z", "t = ((a − p)·n)/n_z"),
)
def random_points_by_trimesh(run: Run) -> Comparison:
    """Random points are inside a mesh exactly when trimesh says so.

    Of a torus, a sphere, a dented and a lumpy sphere.
    """
    from references import printed, trimesh

    counts = (300, 2_000, 20_000)
    return _by_random_points(run, counts, trimesh.points_in_mesh, trimesh.MARGIN, printed.parity_by_z_difference)


@check(
    section="4.6",
    piece=CONCAVE,
    reference="generalised winding number (van Oosterom and Strackee 1983)",
    kind="closed form",
    because="the winding number is sure beyond 1e-12 m of the surface; nearer ones are left out",
    faults=(STEEP_TRIANGLES,),
)
def random_points_by_winding_number(run: Run) -> Comparison:
    """Random points are inside exactly when the surface winds around them once."""
    from references import winding

    return _by_random_points(run, (1_000, 5_000, 100_000), winding.points_in_mesh, winding.MARGIN)


@check(
    section="4.6",
    piece=CONCAVE,
    reference="generalised winding number",
    kind="closed form",
    because="points within 1e-9 m of the surface are passed over",
    faults=(
        Fault(
            "a ray that counts a vertex on its path for both edges",
            polyhedron.ray_hits_triangle_filtered,
            "a_[1] <= p_[1] → a_[1] < p_[1]",
        ),
    ),
    erratum=Misprint("E20", "every triangle that the ray meets counts", "shared edges and vertices count once"),
)
def stacked_copies(run: Run) -> Comparison:
    """Points exactly above or below vertices and edges are judged right.

    So it is in the paper's own stack of equal bodies.
    """
    from references import printed, winding

    rng = run.fresh_rng()
    # Not turned: their vertices lie above each other, as those of the paper's bodies do.
    meshes = {
        "torus": softbody.torus(1.0, 0.4, 24, 12),
        "sphere": softbody.icosphere(2),
        "dented sphere": dented_sphere(2),
        "box": softbody.box((1.0, 1.0, 1.0), 4),
    }

    def points_for(mesh: Mesh) -> np.ndarray:
        copies = stacked_points(mesh, rng, run.count(2, 8, 40))
        middles = edge_points(mesh, rng, run.count(200, 1_000, 10_000))
        return _far_from_surface(np.concatenate([copies, middles]), mesh, 1e-9)

    return _by(winding.points_in_mesh, meshes, points_for, printed=printed.parity_counting_every_hit)


@check(
    section="4.6",
    piece=CONCAVE,
    reference="exact rational arithmetic",
    kind="exact arithmetic",
    because="rounding moves a face by 1e-15",
    faults=(
        Fault(
            "a tolerance of 1e-12 m³ in the ray",
            polyhedron.ray_hits_triangle_filtered,
            "(side_ > 0.0) == up_ and side_ != 0.0 → (side_ > 0.0) == up_ and abs(side_) > 1e-12",
        ),
    ),
)
def points_near_the_surface(run: Run) -> Comparison:
    """Points hardly off a surface lie where exact arithmetic says they do.

    They are 1e-3 to 1e-12 of the size off it, on either side.
    """
    from references import exact

    rng, count = run.fresh_rng(), run.count(200, 500, 5_000)
    meshes = {"torus": rotated(softbody.torus(1.0, 0.4, 16, 8), rng), "dented sphere": rotated(dented_sphere(1), rng)}

    def points_for(mesh: Mesh) -> np.ndarray:
        feet, corners = points_on_faces(mesh.vertices, mesh.triangles, rng, count)
        offsets = rng.choice([-1.0, 1.0], count) * 10.0 ** rng.uniform(-12.0, -3.0, count)
        return feet + offsets[:, None] * unit_normals(corners)

    return _by(lambda *asked: exact.points_in_mesh(*asked) > 0, meshes, points_for)


def _by_grid(points: np.ndarray, grid: parity_grid.ParityGrid, vertices: np.ndarray) -> np.ndarray:
    """Tell which points are inside, all at once."""
    inside = np.empty(len(points), bool)
    parity_grid.points_in_parity_grid(points, grid, vertices, inside, (0, len(points)))
    return inside


def _one_by_one(points: np.ndarray, grid: parity_grid.ParityGrid, vertices: np.ndarray) -> np.ndarray:
    """Tell which points are inside, each by itself."""
    return np.array([parity_grid.point_in_parity_grid(load(points, i), grid, vertices) for i in range(len(points))])


@check(
    section="4.6, 6",
    piece=GRID,
    reference="softbody.geometry.polyhedron.points_in_polyhedron, judged by the claims above",
    kind="the core in another form",
    because="on the surface too; both ask the same exact question of each triangle",
    faults=(
        COUNTED_AGAIN,
        Fault(
            "one point, as if the next known level were outside",
            parity_grid.point_in_parity_grid,
            "odd_ ^ (side_ != _NONE) → odd_",
        ),
        Fault(
            "one point, by the side of the lowest level",
            parity_grid.point_in_parity_grid,
            "grid.inside[k] >> np.uint64(level) → grid.inside[k] >> _NONE",
        ),
    ),
)
def grid_is_exhaustive(run: Run) -> Comparison:
    """A grid rebuilt for every step answers as the exhaustive test.

    On every point and mesh tried, of many points and of one.
    """
    rng = run.fresh_rng()
    answers = Answers()
    for kind, mesh in varied_meshes(rng).items():
        vertices = mesh.vertices
        grid = parity_grid.build_parity_grid(vertices, mesh.triangles)
        for _ in range(3):
            vertices = np.ascontiguousarray(vertices * rng.uniform(0.7, 1.4, 3) + rng.normal(size=3))
            parity_grid.rebuild_parity_grid(grid, vertices)
            moved = Mesh(vertices, mesh.triangles)
            special = special_points(moved, rng, run.count(100, 500, 20_000))
            many = np.concatenate([points_around(moved, run.count(500, 3_000, 100_000), rng), *special.values()])
            single = many[rng.choice(len(many), 60, replace=False)]
            for points, ask in ((many, _by_grid), (single, _one_by_one)):
                exhaustively = polyhedron.points_in_polyhedron(points, vertices, mesh.triangles)
                answers.extend(ask(points, grid, vertices), exhaustively, kind=kind, point=points)
    return answers.comparison()


@check(
    section="4.6",
    piece=GRID,
    reference="libigl, exact winding number",
    engines=("igl",),
    because="points within 1e-12 of the surface, where libigl may be wrong, are left out",
    faults=(COUNTED_AGAIN,),
)
def random_points_by_igl(run: Run) -> Comparison:
    """Random points are inside where libigl's winding number is one.

    Around a sphere, a torus, a dent, a knot and a scan.
    """
    from references import igl

    rng = run.fresh_rng()

    def points_for(mesh: Mesh) -> np.ndarray:
        points = points_around(mesh, run.count(1_000, 10_000, 220_000), rng)
        return points[igl.closest_points(points, mesh.vertices, mesh.triangles)[0] > igl.MARGIN]

    return _by(igl.points_in_mesh, varied_meshes(rng), points_for, points_in_mesh)


@check(
    section="4.6",
    piece=GRID,
    reference="exact integer arithmetic wherever an engine disagrees; libigl and trimesh elsewhere",
    engines=("igl", "trimesh", "rtree"),
    kind="exact arithmetic",
    because="points exactly on the surface are left out, for either answer is right",
    faults=(NEAR_MISSES,),
)
def special_points_by_exact_arithmetic(run: Run) -> Comparison:
    """No point near vertices, edges and faces of a mesh is misjudged.

    Points above and below them, 1e-3 to 1e-15 m off them, and in stacked copies.
    """
    from references import exact, igl, trimesh

    rng = run.fresh_rng()
    judges: dict[str, Judge] = {
        "trimesh with rtree": trimesh.points_in_mesh,
        "libigl winding number": igl.points_in_mesh,
        "libigl signed distance": igl.points_in_mesh_by_distance,
        "libigl fast winding number": igl.points_in_mesh_fast,
    }
    if not missing(("embreex",)):
        judges["trimesh with embree"] = trimesh.points_in_mesh_by_embree
    answers = Answers()
    said: dict[str, list[np.ndarray]] = {name: [] for name in judges}
    straight = {"stacked spheres": softbody.icosphere(1), "stacked tori": softbody.torus(1.0, 0.4, 16, 8)}
    for kind, mesh in (straight | varied_meshes(rng, 2)).items():
        points = special_points(mesh, rng, run.count(15, 120, 4_000))
        if kind in straight:
            points = {"copies shifted along z": stacked_points(mesh, rng, run.count(1, 4, 40))}
        for place, rows in points.items():
            asked = mesh.vertices, mesh.triangles
            ours = points_in_mesh(rows, *asked)
            theirs = {name: judge(rows, *asked) for name, judge in judges.items()}
            doubtful = (np.array([*theirs.values()]) != ours).any(axis=0)
            truth = ours.astype(int) * 2 - 1
            if doubtful.any():
                truth[doubtful] = exact.points_in_mesh(rows[doubtful], *asked)
            off = truth != 0
            for name, answer in theirs.items():
                said[name].append(answer[off])
            answers.extend(ours[off], truth[off] > 0, kind=place, mesh=[kind] * int(off.sum()), point=rows[off])
    comparison = answers.comparison()
    found = {US: comparison.measured} | {name: np.concatenate(answer) for name, answer in said.items()}
    by = "exact arithmetic where they differ"
    comparison.arbitrations = [
        arbitrate(by, comparison.expected, found, groups=comparison.groups, inputs=comparison.inputs)
    ]
    return comparison


@check(
    section="4.6",
    piece=GRID,
    reference="invariant: the answers before",
    kind="invariant",
    because="random points within 1e-9 m of the surface are left out, for coordinates are rounded",
    faults=(NEAR_MISSES,),
)
def containment_is_invariant(run: Run) -> Comparison:
    """What is inside stays inside however mesh and points move together.

    They are turned, moved 1 000 km, scaled by 1e±6 or renumbered.
    """
    rng = run.fresh_rng()
    answers = Answers()
    for shape, mesh in varied_meshes(rng).items():
        points = points_around(mesh, run.count(500, 3_000, 50_000), rng)
        points = points[closest_on_mesh(points, mesh.vertices, mesh.triangles).distance > 1e-9]
        before = points_in_mesh(points, mesh.vertices, mesh.triangles)
        for kind, (vertices, triangles, moved) in transformed(mesh, points, rng).items():
            after = points_in_mesh(moved, vertices, triangles)
            answers.extend(after, before, kind=kind, mesh=[shape] * len(before), point=moved)
    return answers.comparison()


def _boxes(low: np.ndarray, size: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices and triangles of boxes with `faces` each, from their least corners (b, 3) and sizes (b, 3)."""
    corner = np.indices((2, 2, 2)).reshape(3, 8).T  # numbered 4 x + 2 y + z
    vertices = (low[:, None] + corner * size[:, None]).reshape(-1, 3)
    return vertices, (8 * np.arange(len(low))[:, None, None] + faces).reshape(-1, 3)


def _points_beside(vertices: np.ndarray, rng: np.random.Generator, count: int) -> np.ndarray:
    """Return points (count, 3) half units away from the sides of boxes, or in their planes; many below edges."""
    return vertices[rng.integers(0, len(vertices), (count, 3)), np.arange(3)] + 0.5 * rng.integers(-3, 4, (count, 3))


def _plates(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return vertices (n, 3) and triangles (t, 3) of a mesh of many boxes, points (m, 3), and which are inside.

    Boxes and points have whole and half coordinates, skewed by whole numbers: nothing is rounded. The boxes, most of
    them plates and rods, lie in and across each other, or are a stack of plates, and what an odd number of them holds
    is inside. No point is on a surface. A flat triangle of two vertices, which changes nothing, makes the number of
    triangles odd.
    """
    extent = rng.integers(3, 48, 3)
    thin = rng.random((int(rng.integers(2, 24)), 3)) < 0.5
    size = np.where(thin, 1, 1 + rng.integers(0, extent, thin.shape))
    low = rng.integers(0, np.maximum(extent - size, 0) + 1)
    if rng.random() < 0.5:  # a stack, of half a unit to a level of the grid
        size[:] = extent[0], extent[1], 1
        low[:] = 0
        low[:, 2] = rng.permutation(31)[: len(low)]
        low[:2, 2] = 0, 30
    vertices, triangles = _boxes(low, size, BOX_TRIANGLES)
    triangles = np.vstack([rng.permutation(triangles), [[0, 1, 1]]])
    points = _points_beside(vertices, rng, 300)
    within = ((points[:, None] >= low) & (points[:, None] <= low + size)).all(axis=2).sum(axis=1)
    strictly = ((points[:, None] > low) & (points[:, None] < low + size)).all(axis=2).sum(axis=1)
    off = within == strictly
    skew = np.tril(rng.integers(-1, 2, (3, 3)), -1) + np.eye(3)
    skew = skew @ (np.triu(rng.integers(-1, 2, (3, 3)), 1) + np.eye(3)) if rng.random() < 0.5 else np.eye(3)
    return vertices @ skew, triangles, points[off] @ skew, strictly[off] % 2 == 1


def _inside_by_tree(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Tell which points are inside as a World finds them."""
    tree, room = bvh.build_bvh(vertices, triangles), penetration.room_for_penetrations(len(points))
    theirs = penetration.points_of(points), penetration.points_of(vertices)
    count = penetration.find_penetrations(*theirs, tree, bvh.search_space(tree), room)
    return np.isin(np.arange(len(points)), room.point[:count])


@check(
    section="4.6",
    piece=f"{GRID}, softbody.geometry.penetration.find_penetrations, {CONCAVE}",
    reference="whole numbers: how many boxes hold a point",
    kind="exact arithmetic",
    faults=(
        Fault("the side of the level above", parity_grid._bit_number, "bit > _ONE → bit >= _ONE"),
        Fault("the side of another level, by rounding", parity_grid._ask_block, "at_level != level → False"),
        Fault(
            "levels that begin at the least y",
            parity_grid._frame,
            "f[0], f[1], f[2], f[3], f[4], f[5], f[6], f[7], f[8], f[9], s[0], s[1]"
            " → f[0], f[1], f[1], f[3], f[4], f[5], f[6], f[7], f[8], f[9], s[0], s[1]",
        ),
        Fault(
            "boxes in units of the mesh's width, not its size",
            bvh.refit_bvh,
            "0.5 * max(high[0] - low[0], high[1] - low[1], high[2] - low[2]) → 0.5 * (high[0] - low[0])",
        ),
        Fault(
            "triangles counted that are missed",
            polyhedron.point_in_polyhedron,
            "if ray_hits_triangle(p_, a_, b_, c_):\n    inside_ = not inside_"
            " → if not ray_hits_triangle(p_, a_, b_, c_):\n    inside_ = not inside_",
        ),
    ),
)
def plates_of_whole_numbers(run: Run) -> Comparison:
    """Points are inside when an odd number of crossing boxes holds them.

    Many plates, rods and boxes across each other, in whole numbers and skewed. The grid with few columns and many is
    asked of many points and of one, then the tree, and the points one by one. Each axis is also stretched by up to
    1e15 or shrunk. Also all is so far away that half a unit is the last bit.
    """
    rng = run.fresh_rng()
    answers = Answers()
    for _ in range(run.count(60, 200, 2_000)):
        vertices, triangles, points, inside = _plates(rng)
        factor, axis = 2.0 ** rng.integers(-50, 51, 3), np.eye(3)[rng.integers(0, 3)]
        for where, scale, offset in (
            ("here", 1.0, 0.0),
            ("stretched", factor, 0.0),
            ("far away", 1.0, (2.0**51 + 2.0**20) * axis),  # where the last bit is half a unit
        ):
            v, p = vertices * scale + offset, points * scale + offset
            columns = float(rng.choice([0.01, 0.25, 1.0, 4.0, 64.0]))
            answers.extend(MeshQuery(v, triangles, columns).contains(p), inside, kind=f"{where}, grid")
            answers.extend(_inside_by_tree(p, v, triangles), inside, kind=f"{where}, tree")
            answers.extend(polyhedron.points_in_polyhedron(p, v, triangles), inside, kind=f"{where}, one by one")
            grid = parity_grid.build_parity_grid(v, triangles, columns)
            answers.extend(_one_by_one(p[:20], grid, v), inside[:20], kind=f"{where}, grid, of one point")
    return answers.comparison()


@check(
    section="4.6",
    piece=GRID,
    reference="whole numbers: how many tops are above a point",
    kind="exact arithmetic",
    faults=(
        Fault("nothing is below an open mesh", parity_grid._lay_out, "-np.inf → low[2]"),
        Fault(
            "open meshes with sides",
            parity_grid._find_sides,
            "~marked[k] & below_top if grid.closed else _NONE → ~marked[k] & below_top",
        ),
        Fault("points at no height", parity_grid._within, "p[2] > -np.inf → p[2] == p[2]"),
    ),
)
def boxes_without_floors(run: Run) -> Comparison:
    """Points are inside floorless boxes when below an odd number of tops.

    The boxes are in whole numbers and across each other; some points are below all of them. The grid with few columns
    and many is asked of many points and of one. Points that are nowhere, or at no height, are not inside.
    """
    rng = run.fresh_rng()
    floor = (BOX_TRIANGLES % 2 == 0).all(axis=1)  # corners are numbered 4 x + 2 y + z
    answers = Answers()
    for _ in range(run.count(40, 150, 1_500)):
        extent = rng.integers(2, 20, 3)
        low = rng.integers(0, extent, (int(rng.integers(1, 12)), 3))
        size = rng.integers(1, extent + 1, low.shape)
        vertices, triangles = _boxes(low.astype(float), size, BOX_TRIANGLES[~floor])
        points = _points_beside(vertices, rng, 200)
        points[:3, 2] = np.nan, -np.inf, np.inf
        points[3:30, 2] -= 40.0  # below all of them
        edge = (points[:, None, :2] == low[:, :2]) | (points[:, None, :2] == (low + size)[:, :2])
        points = points[~(edge.any(axis=(1, 2)) | (points[:, None, 2] == (low + size)[:, 2]).any(axis=1))]
        over = ((points[:, None, :2] > low[:, :2]) & (points[:, None, :2] < (low + size)[:, :2])).all(axis=2)
        above = (over & (points[:, None, 2] < (low + size)[:, 2])).sum(axis=1)
        inside = (above % 2 == 1) & np.isfinite(points[:, 2])
        grid = parity_grid.build_parity_grid(vertices, triangles, float(rng.choice([0.01, 0.25, 1.0, 4.0, 64.0])))
        answers.extend(_by_grid(points, grid, vertices), inside, kind="many points")
        answers.extend(_one_by_one(points[:40], grid, vertices), inside[:40], kind="one point")
    return answers.comparison()


@check(
    section="6",
    piece="softbody.geometry.parity_grid.build_parity_grid",
    reference="the columns asked for, and the documented size of a grid of many triangles",
    unit="of what is said",
    kind="specification",
    tolerance=0.1,
    because="columns along a side are whole: 2.6 % at worst of twenty seeds; of some 170 bytes it is 161, 5.3 % less",
    faults=(
        Fault(
            "wide triangles that never find room",
            parity_grid._list_triangles,
            "count_ + (last_x - first_x + 1) * (last_y - first_y + 1) > room_ → 4 * count_ + 4000 > room_",
        ),
        Fault(
            "room for twice the entries",
            parity_grid.build_parity_grid,
            "np.zeros(capacity, np.uint64) → np.zeros(2 * capacity, np.uint64)",
        ),
        Fault(
            "a fourth of the columns",
            parity_grid.build_parity_grid,
            "columns_per_triangle * count → 0.25 * columns_per_triangle * count",
        ),
    ),
)
def grid_is_as_large_as_is_said(run: Run) -> Comparison:
    """A grid has the columns asked for and the documented size.

    Also under wide triangles; it takes some 170 bytes a triangle.
    """
    rng = run.fresh_rng()
    answers = Answers()
    for _ in range(run.count(8, 20, 100)):
        wide = softbody.box(rng.uniform(0.5, 2.0, 3))
        grid = parity_grid.build_parity_grid(wide.vertices, wide.triangles, 64.0)
        columns = grid.shape[0] * grid.shape[1] / (64.0 * len(wide.triangles))
        answers.add(columns, 1.0, kind="columns under wide triangles")
    ball = softbody.icosphere(5)
    grid = parity_grid.build_parity_grid(ball.vertices, ball.triangles)
    answers.add(grid.shape[0] * grid.shape[1] / (0.25 * len(ball.triangles)), 1.0, kind="columns")
    size = sum(part.nbytes for part in grid if isinstance(part, np.ndarray))
    answers.add(size / (170.0 * len(ball.triangles)), 1.0, kind="bytes a triangle")
    return answers.comparison()


@check(
    section="4.7",
    piece="softbody.geometry.polyhedron.point_in_convex",
    reference="generalised winding number",
    kind="closed form",
    because="a yes-or-no answer on random points, none within 1e-9 of the surface",
    faults=(
        Fault(
            "a convex test that forgives a hundredth",
            polyhedron.point_in_convex,
            "face_ >= 0 and depth_ >= 0.0 → face_ >= 0 and depth_ >= -0.01",
        ),
    ),
)
def convex(run: Run) -> Comparison:
    """Face planes tell the inside of convex meshes as winding numbers do."""
    from references import winding

    rng = run.fresh_rng()
    answers = Answers()
    for _ in range(run.count(2, 10, 100)):
        for kind, mesh in (
            ("sphere", softbody.icosphere(2)),
            ("box", softbody.box(rng.uniform(0.3, 2.0, 3), 2)),
            ("octahedron", softbody.octahedron()),
        ):
            turned = rotated(mesh, rng)
            points = points_around(turned, 200, rng)
            faces = turned.vertices, turned.triangles
            ours = [polyhedron.point_in_convex(load(points, i), *faces)[0] for i in range(200)]
            answers.extend(ours, winding.points_in_mesh(points, *faces), kind=kind, point=points)
    return answers.comparison()


@check(
    section="10.10",
    piece="softbody.geometry.tetrahedron.barycentric_in_tetrahedron",
    reference="NumPy solution of the 4 × 4 system",
    unit="of the weights × the system's condition number",
    kind="closed form",
    tolerance=2e-15,
    because="both sides round by 1e-16, times the system's condition number, up to 1e5 here: 2.2e-16 of that at worst"
    " of ten seeds, 3.2e-16 of 30 000 points",
    faults=(
        Fault(
            "two corners of a tetrahedron exchanged",
            tetrahedron.barycentric_in_tetrahedron,
            "tetrahedron_volume(a_, b_, p, d_) → tetrahedron_volume(b_, a_, p, d_)",
        ),
    ),
    erratum=Misprint("E14", "five determinants of the same size", "five determinants of the same sign"),
)
def tetrahedra(run: Run) -> Comparison:
    """A point's barycentric coordinates in a tetrahedron solve their linear system.

    They also tell inside from outside.
    """
    from references import printed

    rng = run.fresh_rng()
    answers, conditions = Answers(), []
    while len(answers) < run.count(300, 3_000, 30_000):
        corners, point = rng.normal(size=(4, 3)), 0.5 * rng.normal(size=3)
        system = np.vstack([corners.T, np.ones(4)])
        condition = np.linalg.cond(system)
        if condition > 1e5:
            continue
        p, *abcd = (tuple(row) for row in [point.tolist(), *corners.tolist()])
        inside = tetrahedron.point_in_tetrahedron(p, *abcd)
        weights = np.linalg.solve(system, [*point, 1.0])
        answers.add(
            [*tetrahedron.barycentric_in_tetrahedron(p, *abcd), float(inside)],
            [*weights, float((weights >= 0.0).all())],
            point=point,
            corners=corners,
        )
        conditions.append(condition)
    comparison = answers.comparison()
    asked, solved = comparison.inputs, comparison.expected[:, :4]
    by_size = printed.points_in_tetrahedron_same_size(asked["point"], *asked["corners"].transpose(1, 0, 2))
    comparison.scale = np.linalg.norm(solved, axis=1) * conditions
    comparison.printed = np.column_stack([solved, by_size])
    return comparison


@check(
    section="4.8",
    piece="softbody.geometry.triangle.point_in_triangle",
    reference="the weights that the point was made from",
    kind="closed form",
    because="weights nearer to 0 than 1e-9 are left out, but for points exactly on an edge's line",
    faults=(
        Fault("flat triangles contain points", triangle.point_in_triangle, "dot(n_, n_) == 0.0 → dot(n_, n_) < 0.0"),
    ),
    erratum=Misprint(
        "E16", "outside iff u·v < 0 or u·w < 0", "u, v and w all turn the way of the triangle, which has an area"
    ),
)
def triangles(run: Run) -> Comparison:
    """A triangle contains the points of its plane without negative weights.

    None is in a flat one.
    """
    from references import printed

    rng = run.fresh_rng()
    answers, misprinted = Answers(), []
    for i in range(run.count(500, 5_000, 100_000)):
        corners = rng.normal(size=(3, 3))
        kind = ("inside or outside", "without area", "beyond the end of an edge")[i % 3]
        weights = rng.uniform(-0.7, 1.2, 2)
        weights = np.array([1.0 - weights.sum(), *weights])
        if kind == "without area":
            # On a grid of powers of two, so that the middle lies on the line exactly.
            corners = np.round(corners * 64.0) / 64.0
            corners[2] = 0.5 * (corners[0] + corners[1])
        elif kind == "beyond the end of an edge":
            corners = np.round(corners * 64.0) / 64.0
            weights = np.array([0.0, -1.0, 2.0])
        elif np.abs(weights).min() < 1e-9:
            continue
        point = weights @ corners
        found = triangle.point_in_triangle(*(tuple(row) for row in [point.tolist(), *corners.tolist()]))
        is_inside = bool((weights >= 0.0).all()) and kind != "without area"
        answers.add(found, is_inside, kind=kind, point=point, corners=corners)
        misprinted.append(bool(printed.point_in_triangle(point, *corners)))
    return answers.comparison(printed=np.array(misprinted))


@check(
    section="4.8, 10.10",
    piece="softbody.geometry.tetrahedron.point_in_tetrahedron",
    reference="whole numbers: no point is beyond a face or an edge, seen from the corner opposite to it",
    kind="exact arithmetic",
    faults=(
        Fault(
            "a tetrahedron without one of its faces",
            tetrahedron.point_in_tetrahedron,
            "sign_ * tetrahedron_volume(a, b, p, d) >= 0.0 → sign_ * tetrahedron_volume(a, b, p, d) > 0.0",
        ),
        Fault("flat tetrahedra contain points", tetrahedron.point_in_tetrahedron, "whole_ != 0.0 → whole_ == whole_"),
        Fault(
            "a triangle without one of its edges",
            triangle.point_in_triangle,
            "dot(cross(pa_, pb_), n_) >= 0.0 → dot(cross(pa_, pb_), n_) > 0.0",
        ),
        Fault(
            "of many tetrahedra each with its third corner twice",
            tetrahedron.points_in_tetrahedra,
            "load(corners_[q_], 3) → load(corners_[q_], 2)",
        ),
        Fault("a convex mesh without its surface", polyhedron.point_in_convex, "depth_ >= 0.0 → depth_ > 0.0"),
        Fault(
            "of many triangles each with its second corner twice",
            triangle.points_in_triangles,
            "load(corners_[q_], 2) → load(corners_[q_], 1)",
        ),
    ),
)
def borders_on_a_grid(run: Run) -> Comparison:
    """Points on the border of a tetrahedron or triangle belong to it.

    On its faces, edges and corners, also of a tetrahedron as a convex mesh; nothing belongs to a flat one. Coordinates
    are whole, from −2 to 2; asked one by one and all at once. Points are also off the plane of a triangle.
    """
    whole = run.fresh_rng().integers(-2, 3, (run.count(1_000, 10_000, 100_000), 5, 3))
    corners, points = whole[:, :4], whole[:, 4]
    in_tetrahedron = np.array([_is_within(*each) for each in zip(points, corners)])
    in_triangle = np.array([_is_within(*each) for each in zip(points, corners[:, :3])])
    rows = [[tuple(row) for row in each] for each in whole.astype(float).tolist()]
    real_points, real = points.astype(float), corners.astype(float)
    answers = Answers()
    one_by_one = [tetrahedron.point_in_tetrahedron(p, *abcd) for *abcd, p in rows]
    answers.extend(one_by_one, in_tetrahedron, kind="tetrahedron")
    at_once, _ = tetrahedron.points_in_tetrahedra(real_points, real)
    answers.extend(at_once, in_tetrahedron, kind="tetrahedra at once")
    one_by_one = [triangle.point_in_triangle(p, a, b, c) for a, b, c, _, p in rows]
    answers.extend(one_by_one, in_triangle, kind="triangle")
    answers.extend(triangle.points_in_triangles(real_points, real[:, :3]), in_triangle, kind="triangles at once")
    # As a mesh, with its faces turned outwards; as such a flat one has two sides, and is left out.
    a, b, c, d = corners.transpose(1, 0, 2)
    turn = ((b - a) * np.cross(c - a, d - a)).sum(axis=1)
    faces = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])
    solid = np.flatnonzero(turn)
    in_mesh = [
        polyhedron.point_in_convex(rows[i][4], real[i], faces if turn[i] > 0 else faces[:, ::-1])[0] for i in solid
    ]
    answers.extend(in_mesh, in_tetrahedron[solid], kind="convex mesh")
    return answers.comparison()


def _is_within(point: np.ndarray, corners: np.ndarray) -> bool:
    """Tell, in whole numbers, whether a point is beyond no face of a tetrahedron (4, 3), or edge of a triangle (3, 3).

    Beyond it is not on the side of the opposite corner. What is flat has nothing within.
    """
    for k, opposite in enumerate(corners):
        a, b, *c = np.delete(corners, k, axis=0)
        # Across the face, or across the edge in the triangle's plane.
        outward = np.cross(b - a, c[0] - a) if c else np.cross(np.cross(b - a, opposite - a), b - a)
        side = int(outward @ (opposite - a))
        if side == 0 or side * int(outward @ (point - a)) < 0:
            return False
    return True
