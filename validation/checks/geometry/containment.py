"""Claims about points in meshes, tetrahedra and triangles."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import softbody
from softbody import Mesh
from softbody.geometry import (
    MeshQuery,
    build_bvh,
    bvh,
    closest_on_mesh,
    find_penetrations,
    parity_grid,
    points_in_mesh,
    points_of,
    polyhedron,
    room_for_penetrations,
    search_space,
    tetrahedron,
    triangle,
)
from softbody.linalg.vec import load
from validation.arbitration import US, arbitrate
from validation.cases import (
    BOX_TRIANGLES,
    dented_sphere,
    edge_points,
    knotted_tube,
    lumpy_sphere,
    points_around,
    rotated,
    scanned_sphere,
    stacked_points,
    transformed,
)
from validation.check import Comparison, Misprint, Run, check
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


def meshes(rng: np.random.Generator) -> dict[str, Mesh]:
    """Return the meshes that points are tried against, in random orientations."""
    return {
        "torus": rotated(softbody.torus(1.0, 0.4, 36, 18), rng),
        "sphere": rotated(softbody.icosphere(3), rng),
        "dented sphere": rotated(dented_sphere(3), rng),
        "lumpy sphere": rotated(lumpy_sphere(rng, 3, 0.4), rng),
    }


def ask_all(shapes: dict[str, Mesh], points: dict[str, np.ndarray], judge: object) -> Comparison:
    """Compare the core's answers with a judge's, mesh by mesh."""
    measured, expected, kinds = [], [], []
    inputs = {"point": np.concatenate([points[kind] for kind in shapes])}
    for kind, mesh in shapes.items():
        measured.append(polyhedron.points_in_polyhedron(points[kind], mesh.vertices, mesh.triangles))
        expected.append(judge(points[kind], mesh.vertices, mesh.triangles))  # type: ignore[operator]
        kinds += [kind] * len(points[kind])
    return Comparison(np.concatenate(measured), np.concatenate(expected), groups=kinds, inputs=inputs)


@check(
    section="4.6",
    piece=CONCAVE,
    reference="trimesh with rtree",
    engines=("trimesh", "rtree"),
    because="a yes-or-no answer; trimesh is right beyond 1e-5 m of the surface, and points nearer are passed over",
    faults=(STEEP_TRIANGLES,),
    erratum=Misprint("E5", "t = (a_z − p_z)/n_z", "t = ((a − p)·n)/n_z"),
)
def random_points_by_trimesh(run: Run) -> Comparison:
    """Random points are inside a torus, sphere, dented or lumpy sphere exactly when trimesh says so."""
    from references import printed, trimesh

    rng = run.fresh_rng()
    shapes = meshes(rng)
    points = {
        kind: far_from_surface(points_around(mesh, run.count(300, 2_000, 20_000), rng), mesh, trimesh.MARGIN)
        for kind, mesh in shapes.items()
    }
    comparison = ask_all(shapes, points, trimesh.points_in_mesh)
    comparison.printed = np.concatenate(
        [printed.parity_by_z_difference(points[k], m.vertices, m.triangles) for k, m in shapes.items()]
    )
    return comparison


def far_from_surface(points: np.ndarray, mesh: Mesh, band: float) -> np.ndarray:
    """Return those points that are more than `band` [m] in front of or behind every triangle's plane or box."""
    corners = mesh.vertices[mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
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
    reference="generalised winding number (van Oosterom and Strackee 1983)",
    kind="closed form",
    because="a yes-or-no answer; the winding number is sure beyond 1e-12 m of the surface; nearer ones are left out",
    faults=(STEEP_TRIANGLES,),
)
def random_points_by_winding_number(run: Run) -> Comparison:
    """Random points are inside exactly when the surface winds around them once."""
    from references import winding

    rng = run.fresh_rng()
    shapes = meshes(rng)
    points = {
        kind: far_from_surface(points_around(mesh, run.count(1_000, 5_000, 100_000), rng), mesh, winding.MARGIN)
        for kind, mesh in shapes.items()
    }
    return ask_all(shapes, points, winding.points_in_mesh)


@check(
    section="4.6",
    piece=CONCAVE,
    reference="generalised winding number",
    kind="closed form",
    because="a yes-or-no answer; points within 1e-9 m of the surface are passed over",
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
    """Points exactly above or below vertices and edges are judged right: the paper's own stack of equal bodies."""
    from references import printed, winding

    rng = run.fresh_rng()
    # Not turned: their vertices lie above each other, as those of the paper's bodies do.
    shapes = {
        "torus": softbody.torus(1.0, 0.4, 24, 12),
        "sphere": softbody.icosphere(2),
        "dented sphere": dented_sphere(2),
        "box": softbody.box((1.0, 1.0, 1.0), 4),
    }
    points = {}
    for kind, mesh in shapes.items():
        copies = stacked_points(mesh, rng, run.count(2, 8, 40))
        middles = edge_points(mesh, rng, run.count(200, 1_000, 10_000))
        points[kind] = far_from_surface(np.concatenate([copies, middles]), mesh, 1e-9)
    comparison = ask_all(shapes, points, winding.points_in_mesh)
    comparison.printed = np.concatenate(
        [printed.parity_counting_every_hit(points[k], m.vertices, m.triangles) for k, m in shapes.items()]
    )
    return comparison


@check(
    section="4.6",
    piece=CONCAVE,
    reference="exact rational arithmetic",
    kind="exact arithmetic",
    because="a yes-or-no answer; rounding moves a face by 1e-15",
    faults=(
        Fault(
            "a tolerance of 1e-12 m³ in the ray",
            polyhedron.ray_hits_triangle_filtered,
            "(side_ > 0.0) == up_ and side_ != 0.0 → (side_ > 0.0) == up_ and abs(side_) > 1e-12",
        ),
    ),
)
def points_near_the_surface(run: Run) -> Comparison:
    """Points 1e-3 to 1e-12 of the size off the surface are on the side that exact arithmetic says."""
    from references import exact

    rng = run.fresh_rng()
    shapes = {"torus": rotated(softbody.torus(1.0, 0.4, 16, 8), rng), "dented sphere": rotated(dented_sphere(1), rng)}
    points = {}
    for kind, mesh in shapes.items():
        count = run.count(200, 500, 5_000)
        corners = mesh.vertices[mesh.triangles[rng.integers(0, len(mesh.triangles), count)]]
        feet = (rng.dirichlet((1.0, 1.0, 1.0), count)[:, :, None] * corners).sum(axis=1)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        offsets = rng.choice([-1.0, 1.0], count) * 10.0 ** rng.uniform(-12.0, -3.0, count)
        points[kind] = feet + offsets[:, None] * normals
    return ask_all(shapes, points, lambda q, v, t: exact.points_in_mesh(q, v, t) > 0)


def varied_meshes(rng: np.random.Generator, subdivisions: int = 3) -> dict[str, Mesh]:
    """Return meshes of every kind that the structures are tried on, in random orientations."""
    fine = 2 ** (subdivisions - 2)
    return {
        "sphere": rotated(softbody.icosphere(subdivisions), rng),
        "torus": rotated(softbody.torus(1.0, 0.4, 18 * fine, 9 * fine), rng),
        "dented sphere": rotated(dented_sphere(subdivisions), rng),
        "knotted tube": knotted_tube(rng, 48 * fine, 4 * fine),
        "like a scan": rotated(scanned_sphere(rng, subdivisions), rng),
    }


def special_points(mesh: Mesh, rng: np.random.Generator, count: int) -> dict[str, np.ndarray]:
    """Return points where rays and rounding go wrong: above, below, on and just off vertices, edges and faces."""
    corners = mesh.vertices[mesh.triangles[rng.integers(0, len(mesh.triangles), count)]]
    on_vertices = corners[:, 0]
    on_edges = 0.5 * (corners[:, 0] + corners[:, 1])
    on_faces = (rng.dirichlet((1.0, 1.0, 1.0), count)[:, :, None] * corners).sum(axis=1)
    up = np.array([0.0, 0.0, 1.0]) * rng.uniform(-1.0, 1.0, (count, 1)) * np.ptp(mesh.vertices[:, 2])
    off = rng.normal(size=(count, 3))
    off *= 10.0 ** rng.uniform(-15.0, -3.0, (count, 1)) / np.linalg.norm(off, axis=1, keepdims=True)
    return {
        "above or below vertices": on_vertices + up,
        "above or below edges": on_edges + up,
        "on edges and faces": np.concatenate([on_edges[::2], on_faces[::2]]),
        "next to vertices": on_vertices + off,
        "next to edges": on_edges + off,
        "next to faces": on_faces + off,
    }


@check(
    section="4.6, 6",
    piece=GRID,
    reference="softbody.geometry.polyhedron.points_in_polyhedron, judged by the claims above",
    kind="the core in another form",
    because="a yes-or-no answer, on the surface too; both ask the same exact question of each triangle",
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
    """The grid that is rebuilt for every step answers as the exhaustive test, on every point and mesh tried, of many
    points and of one."""
    rng = run.fresh_rng()
    measured, expected, kinds, asked = [], [], [], []
    for kind, mesh in varied_meshes(rng).items():
        vertices = mesh.vertices
        grid = parity_grid.build_parity_grid(vertices, mesh.triangles)
        for _ in range(3):
            vertices = np.ascontiguousarray(vertices * rng.uniform(0.7, 1.4, 3) + rng.normal(size=3))
            parity_grid.rebuild_parity_grid(grid, vertices)
            moved = Mesh(vertices, mesh.triangles)
            special = special_points(moved, rng, run.count(100, 500, 20_000))
            points = np.concatenate([points_around(moved, run.count(500, 3_000, 100_000), rng), *special.values()])
            answers = np.empty(len(points), bool)
            parity_grid.points_in_parity_grid(points, grid, vertices, answers, (0, len(points)))
            single = rng.choice(len(points), 60, replace=False)
            alone = [parity_grid.point_in_parity_grid(load(points, i), grid, vertices) for i in single]
            measured += [answers, np.array(alone)]
            points = np.concatenate([points, points[single]])
            expected.append(polyhedron.points_in_polyhedron(points, vertices, mesh.triangles))
            kinds += [kind] * len(points)
            asked.append(points)
    inputs = {"point": np.concatenate(asked)}
    return Comparison(np.concatenate(measured), np.concatenate(expected), groups=kinds, inputs=inputs)


def accelerated(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return what the grid answers."""
    return points_in_mesh(points, vertices, triangles)


@check(
    section="4.6",
    piece=GRID,
    reference="libigl, exact winding number",
    engines=("igl",),
    because="a yes-or-no answer; points within 1e-12 of the surface, where libigl may be wrong, are left out",
    faults=(COUNTED_AGAIN,),
)
def random_points_by_igl(run: Run) -> Comparison:
    """Random points around a sphere, torus, dent, knot or scan are inside where libigl's winding number is one."""
    from references import igl

    rng = run.fresh_rng()
    measured, expected, kinds, asked = [], [], [], []
    for kind, mesh in varied_meshes(rng).items():
        points = points_around(mesh, run.count(1_000, 10_000, 220_000), rng)
        distance, _, _ = igl.closest_points(points, mesh.vertices, mesh.triangles)
        points = points[distance > igl.MARGIN]
        measured.append(accelerated(points, mesh.vertices, mesh.triangles))
        expected.append(igl.points_in_mesh(points, mesh.vertices, mesh.triangles))
        kinds += [kind] * len(points)
        asked.append(points)
    inputs = {"point": np.concatenate(asked)}
    return Comparison(np.concatenate(measured), np.concatenate(expected), groups=kinds, inputs=inputs)


@check(
    section="4.6",
    piece=GRID,
    reference="exact integer arithmetic wherever an engine disagrees; libigl and trimesh elsewhere",
    engines=("igl", "trimesh", "rtree"),
    kind="exact arithmetic",
    because="a yes-or-no answer; points exactly on the surface are left out, for either answer is right",
    faults=(NEAR_MISSES,),
)
def special_points_by_exact_arithmetic(run: Run) -> Comparison:
    """Above, below, 1e-3 to 1e-15 m off vertices, edges and faces, and in stacked copies: no point is misjudged."""
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
    said: dict[str, list[np.ndarray]] = {name: [] for name in judges}
    measured, expected, kinds, shapes, asked = [], [], [], [], []
    straight = {"stacked spheres": softbody.icosphere(1), "stacked tori": softbody.torus(1.0, 0.4, 16, 8)}
    for kind, mesh in (straight | varied_meshes(rng, 2)).items():
        points = special_points(mesh, rng, run.count(15, 120, 4_000))
        if kind in straight:
            points = {"copies shifted along z": stacked_points(mesh, rng, run.count(1, 4, 40))}
        for place, rows in points.items():
            ours = accelerated(rows, mesh.vertices, mesh.triangles)
            answers = {name: judge(rows, mesh.vertices, mesh.triangles) for name, judge in judges.items()}
            doubtful = np.zeros(len(rows), bool)
            for answer in answers.values():
                doubtful |= answer != ours
            truth = ours.astype(int) * 2 - 1
            if doubtful.any():
                truth[doubtful] = exact.points_in_mesh(rows[doubtful], mesh.vertices, mesh.triangles)
            off = truth != 0
            for name, answer in answers.items():
                said[name].append(answer[off])
            measured.append(ours[off])
            expected.append(truth[off] > 0)
            kinds += [place] * int(off.sum())
            shapes += [kind] * int(off.sum())
            asked.append(rows[off])
    inputs = {"mesh": shapes, "point": np.concatenate(asked)}
    comparison = Comparison(np.concatenate(measured), np.concatenate(expected), groups=kinds, inputs=inputs)
    found = {US: comparison.measured} | {name: np.concatenate(answer) for name, answer in said.items()}
    by = "exact arithmetic where they differ"
    comparison.arbitrations = [arbitrate(by, comparison.expected, found, groups=kinds, inputs=inputs)]
    return comparison


@check(
    section="4.6",
    piece=GRID,
    reference="invariant: the answers before",
    kind="invariant",
    because="a yes-or-no answer; random points within 1e-9 m of the surface are left out, for coordinates are rounded",
    faults=(NEAR_MISSES,),
)
def containment_is_invariant(run: Run) -> Comparison:
    """What is inside stays inside when mesh and points are turned, moved 1 000 km, scaled by 1e±6 or renumbered."""
    rng = run.fresh_rng()
    measured, expected, kinds, shapes, asked = [], [], [], [], []
    for shape, mesh in varied_meshes(rng).items():
        points = points_around(mesh, run.count(500, 3_000, 50_000), rng)
        distance = closest_on_mesh(points, mesh.vertices, mesh.triangles).distance
        points = points[distance > 1e-9]
        before = accelerated(points, mesh.vertices, mesh.triangles)
        for kind, (vertices, triangles, moved) in transformed(mesh, points, rng).items():
            measured.append(accelerated(moved, vertices, triangles))
            expected.append(before)
            kinds += [kind] * len(before)
            shapes += [shape] * len(before)
            asked.append(moved)
    inputs = {"mesh": shapes, "point": np.concatenate(asked)}
    return Comparison(np.concatenate(measured), np.concatenate(expected), groups=kinds, inputs=inputs)


def plates(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
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
    corner = np.stack(np.meshgrid(*3 * [[0, 1]], indexing="ij"), axis=-1).reshape(-1, 3)
    vertices = (low[:, None] + corner * size[:, None]).reshape(-1, 3)
    triangles = (8 * np.arange(len(size))[:, None, None] + BOX_TRIANGLES).reshape(-1, 3)
    triangles = np.vstack([rng.permutation(triangles), [[0, 1, 1]]])
    # Most points next to plates, and some of them below edges.
    points = vertices[rng.integers(0, len(vertices), (300, 3)), np.arange(3)] + 0.5 * rng.integers(-3, 4, (300, 3))
    within = ((points[:, None] >= low) & (points[:, None] <= low + size)).all(axis=2)
    strictly = ((points[:, None] > low) & (points[:, None] < low + size)).all(axis=2)
    off = (within == strictly).all(axis=1)
    skew = np.tril(rng.integers(-1, 2, (3, 3)), -1) + np.eye(3)
    skew = skew @ (np.triu(rng.integers(-1, 2, (3, 3)), 1) + np.eye(3)) if rng.random() < 0.5 else np.eye(3)
    return vertices @ skew, triangles, points[off] @ skew, strictly[off].sum(axis=1) % 2 == 1


def inside_by_tree(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Tell which points are inside as a World finds them."""
    tree, room = build_bvh(vertices, triangles), room_for_penetrations(len(points))
    count = find_penetrations(points_of(points), points_of(vertices), tree, search_space(tree), room)
    return np.isin(np.arange(len(points)), room.point[:count])


@check(
    section="4.6",
    piece=f"{GRID}, softbody.geometry.penetration.find_penetrations, {CONCAVE}",
    reference="whole numbers: how many boxes hold a point",
    kind="exact arithmetic",
    because="a yes-or-no answer, of numbers that nothing rounds",
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
    """Of many plates, rods and boxes across each other, in whole numbers and skewed, points are inside that an odd
    number of them holds: by the grid with few columns and many, of many points and of one, by the tree, and one by one;
    also with each axis stretched by up to 1e15 or shrunk, and so far away that half a unit is the last bit."""
    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for _ in range(run.count(60, 200, 2_000)):
        vertices, triangles, points, inside = plates(rng)
        factor, axis = 2.0 ** rng.integers(-50, 51, 3), np.eye(3)[rng.integers(0, 3)]
        for where, scale, offset in (
            ("here", 1.0, 0.0),
            ("stretched", factor, 0.0),
            ("far away", 1.0, (2.0**51 + 2.0**20) * axis),  # where the last bit is half a unit
        ):
            v, p = vertices * scale + offset, points * scale + offset
            columns = float(rng.choice([0.01, 0.25, 1.0, 4.0, 64.0]))
            measured += [
                MeshQuery(v, triangles, columns).contains(p),
                inside_by_tree(p, v, triangles),
                polyhedron.points_in_polyhedron(p, v, triangles),
            ]
            expected += 3 * [inside]
            kinds += [f"{where}, {how}" for how in ("grid", "tree", "one by one") for _ in p]
            grid = parity_grid.build_parity_grid(v, triangles, columns)
            measured.append(
                np.array([parity_grid.point_in_parity_grid(load(p, i), grid, v) for i in range(min(20, len(p)))])
            )
            expected.append(inside[:20])
            kinds += [f"{where}, grid, of one point"] * len(p[:20])
    return Comparison(np.concatenate(measured), np.concatenate(expected), groups=kinds)


@check(
    section="4.6",
    piece=GRID,
    reference="whole numbers: how many tops are above a point",
    kind="exact arithmetic",
    because="a yes-or-no answer, of numbers that nothing rounds",
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
    """Of boxes without floors, across each other and in whole numbers, points are inside that are below the tops of an
    odd number of them, also below all of them: by the grid with few columns and many, of many points and of one; points
    that are nowhere, or at no height, are not."""
    rng = run.fresh_rng()
    floor = (BOX_TRIANGLES % 2 == 0).all(axis=1)  # corners are numbered 4 x + 2 y + z
    measured, expected, kinds = [], [], []
    for _ in range(run.count(40, 150, 1_500)):
        extent = rng.integers(2, 20, 3)
        low = rng.integers(0, extent, (int(rng.integers(1, 12)), 3))
        size = rng.integers(1, extent + 1, low.shape)
        corner = np.stack(np.meshgrid(*3 * [[0, 1]], indexing="ij"), axis=-1).reshape(-1, 3)
        vertices = (low[:, None] + corner * size[:, None]).reshape(-1, 3).astype(float)
        triangles = (8 * np.arange(len(low))[:, None, None] + BOX_TRIANGLES[~floor]).reshape(-1, 3)
        points = vertices[rng.integers(0, len(vertices), (200, 3)), np.arange(3)] + 0.5 * rng.integers(-3, 4, (200, 3))
        points[:3, 2] = np.nan, -np.inf, np.inf
        points[3:30, 2] -= 40.0  # below all of them
        edge = (points[:, None, :2] == low[:, :2]) | (points[:, None, :2] == (low + size)[:, :2])
        points = points[~(edge.any(axis=(1, 2)) | (points[:, None, 2] == (low + size)[:, 2]).any(axis=1))]
        over = ((points[:, None, :2] > low[:, :2]) & (points[:, None, :2] < (low + size)[:, :2])).all(axis=2)
        above = (over & (points[:, None, 2] < (low + size)[:, 2])).sum(axis=1)
        inside = (above % 2 == 1) & np.isfinite(points[:, 2])
        grid = parity_grid.build_parity_grid(vertices, triangles, float(rng.choice([0.01, 0.25, 1.0, 4.0, 64.0])))
        answers = np.empty(len(points), bool)
        parity_grid.points_in_parity_grid(points, grid, vertices, answers, (0, len(points)))
        few = [parity_grid.point_in_parity_grid(load(points, i), grid, vertices) for i in range(min(40, len(points)))]
        measured += [answers, np.array(few)]
        expected += [inside, inside[:40]]
        kinds += ["many points"] * len(points) + ["one point"] * len(few)
    return Comparison(np.concatenate(measured), np.concatenate(expected), groups=kinds)


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
    """A grid has the columns that are asked for, also under wide triangles, and takes some 170 bytes a triangle."""
    rng = run.fresh_rng()
    measured, kinds = [], []
    for _ in range(run.count(8, 20, 100)):
        wide = softbody.box(rng.uniform(0.5, 2.0, 3))
        grid = parity_grid.build_parity_grid(wide.vertices, wide.triangles, 64.0)
        measured.append(float(grid.shape[0] * grid.shape[1]) / (64.0 * len(wide.triangles)))
        kinds.append("columns under wide triangles")
    ball = softbody.icosphere(5)
    grid = parity_grid.build_parity_grid(ball.vertices, ball.triangles)
    measured.append(float(grid.shape[0] * grid.shape[1]) / (0.25 * len(ball.triangles)))
    measured.append(sum(part.nbytes for part in grid if isinstance(part, np.ndarray)) / (170.0 * len(ball.triangles)))
    return Comparison(measured, np.ones(len(measured)), groups=[*kinds, "columns", "bytes a triangle"])


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
    """On convex meshes the test against face planes agrees with the winding number."""
    from references import winding

    rng = run.fresh_rng()
    measured, expected, kinds, asked = [], [], [], []
    for _ in range(run.count(2, 10, 100)):
        for kind, mesh in (
            ("sphere", softbody.icosphere(2)),
            ("box", softbody.box(rng.uniform(0.3, 2.0, 3), 2)),
            ("octahedron", softbody.octahedron()),
        ):
            turned = rotated(mesh, rng)
            points = points_around(turned, 200, rng)
            vertices, triangles = turned.vertices, turned.triangles
            measured += [polyhedron.point_in_convex(load(points, i), vertices, triangles)[0] for i in range(200)]
            expected.append(winding.points_in_mesh(points, vertices, triangles))
            kinds += [kind] * 200
            asked.append(points)
    inputs = {"point": np.concatenate(asked)}
    return Comparison(np.array(measured), np.concatenate(expected), groups=kinds, inputs=inputs)


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
    """A point's barycentric coordinates in a tetrahedron solve their linear system, and tell inside from outside."""
    from references import printed

    rng = run.fresh_rng()
    weights: list[list[float]] = []
    solved, points, tetrahedra, conditions = [], [], [], []
    while len(weights) < run.count(300, 3_000, 30_000):
        corners, point = rng.normal(size=(4, 3)), 0.5 * rng.normal(size=3)
        system = np.vstack([corners.T, np.ones(4)])
        condition = np.linalg.cond(system)
        if condition > 1e5:
            continue
        a, b, c, d = (tuple(corner) for corner in corners.tolist())
        p = tuple(point.tolist())
        inside = tetrahedron.point_in_tetrahedron(p, a, b, c, d)
        weights.append([*tetrahedron.barycentric_in_tetrahedron(p, a, b, c, d), float(inside)])
        answer = np.linalg.solve(system, [*point, 1.0])
        solved.append([*answer, float((answer >= 0.0).all())])
        points.append(point)
        tetrahedra.append(corners)
        conditions.append(condition)
    by_size = printed.points_in_tetrahedron_same_size(np.array(points), *np.array(tetrahedra).transpose(1, 0, 2))
    misprinted = np.column_stack([np.array(solved)[:, :4], by_size])
    scale = np.linalg.norm(np.array(solved)[:, :4], axis=1) * conditions
    inputs = {"point": points, "corners": tetrahedra}
    return Comparison(np.array(weights), np.array(solved), scale, printed=misprinted, inputs=inputs)


@check(
    section="4.8",
    piece="softbody.geometry.triangle.point_in_triangle",
    reference="the weights that the point was made from",
    kind="closed form",
    because="a yes-or-no answer; weights nearer to 0 than 1e-9 are left out, but for points exactly on an edge's line",
    faults=(
        Fault("flat triangles contain points", triangle.point_in_triangle, "dot(n_, n_) == 0.0 → dot(n_, n_) < 0.0"),
    ),
    erratum=Misprint(
        "E16",
        "outside iff u·v < 0 or u·w < 0",
        "u, v and w all turn the way of the triangle, which has an area",
    ),
)
def triangles(run: Run) -> Comparison:
    """A point of its plane is in a triangle exactly if no weight is negative; none is in a flat one."""
    from references import printed

    rng = run.fresh_rng()
    count = run.count(500, 5_000, 100_000)
    measured, expected, misprinted, kinds, points, all_corners = [], [], [], [], [], []
    for i in range(count):
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
        a, b, c = (tuple(corner) for corner in corners.tolist())
        measured.append(triangle.point_in_triangle(tuple(point.tolist()), a, b, c))
        expected.append(bool((weights >= 0.0).all()) and kind != "without area")
        misprinted.append(bool(printed.point_in_triangle(point, *corners)))
        kinds.append(kind)
        points.append(point)
        all_corners.append(corners)
    inputs = {"point": points, "corners": all_corners}
    return Comparison(np.array(measured), np.array(expected), groups=kinds, printed=np.array(misprinted), inputs=inputs)


@check(
    section="4.8, 10.10",
    piece="softbody.geometry.tetrahedron.point_in_tetrahedron",
    reference="whole numbers: no point is beyond a face or an edge, seen from the corner opposite to it",
    kind="exact arithmetic",
    because="a yes-or-no answer, of whole numbers",
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
    """Points on faces, edges and corners of tetrahedra, also as convex meshes, and triangles belong to them, and
    nothing to flat ones: whole coordinates from −2 to 2, one by one and all at once, points of triangles also off their
    plane."""
    whole = run.fresh_rng().integers(-2, 3, (run.count(1_000, 10_000, 100_000), 5, 3))
    corners, points = whole[:, :4], whole[:, 4]
    in_tetrahedron = np.array([_is_within(*each) for each in zip(points, corners)])
    in_triangle = np.array([_is_within(*each) for each in zip(points, corners[:, :3])])
    rows = [[tuple(row) for row in each] for each in whole.astype(float).tolist()]
    one_by_one = [tetrahedron.point_in_tetrahedron(p, a, b, c, d) for a, b, c, d, p in rows]
    at_once, _ = tetrahedron.points_in_tetrahedra(points.astype(float), corners.astype(float))
    flat_one_by_one = [triangle.point_in_triangle(p, a, b, c) for a, b, c, _, p in rows]
    flat_at_once = triangle.points_in_triangles(points.astype(float), corners[:, :3].astype(float))
    # As a mesh, with its faces turned outwards; as such a flat one has two sides, and is left out.
    a, b, c, d = corners.transpose(1, 0, 2)
    turn = ((b - a) * np.cross(c - a, d - a)).sum(axis=1)
    faces = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])
    solid = np.flatnonzero(turn)
    in_mesh = [
        polyhedron.point_in_convex(rows[i][4], corners[i].astype(float), faces if turn[i] > 0 else faces[:, ::-1])[0]
        for i in solid
    ]
    kinds = np.repeat(["tetrahedron", "tetrahedra at once", "triangle", "triangles at once"], len(rows))
    return Comparison(
        np.concatenate([one_by_one, at_once, flat_one_by_one, flat_at_once, in_mesh]),
        np.concatenate([in_tetrahedron, in_tetrahedron, in_triangle, in_triangle, in_tetrahedron[solid]]),
        groups=np.append(kinds, ["convex mesh"] * len(solid)),
    )


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
