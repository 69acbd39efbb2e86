"""Claims about particles of one soft body inside another: which, under which triangle, and how fast found."""

from __future__ import annotations

from time import thread_time

import numpy as np

import softbody
from softbody import Mesh
from softbody.geometry import (
    BVH,
    Penetrations,
    bounding_sphere,
    build_bvh,
    bvh_boxes,
    bvh_rays,
    find_penetrations,
    find_penetrations_exhaustively,
    penetration,
    points_of,
    refit_bvh,
    room_for_penetrations,
    search_space,
)
from validation.cases import random_mesh, rotated
from validation.check import Comparison, Run, check
from validation.checks.geometry.containment import varied_meshes
from validation.fault import Fault

FAMILY = "soft–soft narrow phase"
PIECE = "softbody.geometry.penetration.find_penetrations"


def rebuild_and_find(points: np.ndarray, vertices: np.ndarray, tree: BVH, found: Penetrations) -> int:
    """Fit the structures to where the bodies are, and find which points are inside; return how many."""
    refit_bvh(tree, vertices)
    return find_penetrations(points_of(points), points_of(vertices), tree, search_space(tree), found)


def rows(points: np.ndarray, mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Return what the structures and what trying everything find: bits (m, 6), −1 where a point is not inside."""
    found = []
    tree = build_bvh(mesh.vertices, mesh.triangles)
    for exhaustively in (False, True):
        room = room_for_penetrations(len(points))
        if exhaustively:
            count = find_penetrations_exhaustively(points, mesh.vertices, mesh.triangles, room)
        else:
            count = rebuild_and_find(points, mesh.vertices, tree, room)
        bits = np.full((len(points), 6), -1, np.int64)
        numbers = np.column_stack([room.weights[:count], room.depth[:count]]).view(np.int64)
        bits[room.point[:count]] = np.column_stack([np.arange(count), room.triangle[:count], numbers])
        found.append(bits)
    return found[0], found[1]


@check(
    section="4.3, 6",
    piece=PIECE,
    reference="every particle against every triangle",
    kind="the core in another form",
    because="both ask the same questions of the triangles that matter",
    faults=(
        Fault(
            "depths too large by one part in 1e15",
            penetration._find_closest,
            "_write(found_, row_, i_, nearest_)"
            " → _write(found_, row_, i_, (nearest_[0], nearest_[1], nearest_[2] * 1.000000000000001))",
        ),
        Fault(
            "a plane between two bodies that cuts into one",
            penetration.find_outcodes,
            "reach_ += ROUNDING * norm(axis_) * size_ → reach_ -= 0.05 * norm(axis_)",
        ),
        Fault(
            "the last child of each node of a tree forgotten",
            bvh_boxes._children_in,
            "return bits_ & x_ & y_ → return bits_ & x_ & y_ & 127",
        ),
        Fault(
            "rays that go down, seen as if up",
            bvh_rays._turned,
            "heading_.sign * rows_[i_, heading_.z] → rows_[i_, heading_.z]",
        ),
    ),
)
def accelerated_is_exhaustive(run: Run) -> Comparison:
    """The accelerated narrow phase of two bodies finds the particles, triangles, weights and depths, to the bit."""
    rng = run.fresh_rng()
    measured, kinds = [], []
    for kind, mesh in varied_meshes(rng).items():
        for _ in range(run.count(2, 6, 60)):
            other = random_mesh("lumpy sphere", rng).vertices + rng.uniform(-1.2, 1.2, 3)
            stacked = mesh.vertices + np.array([0.0, 0.0, rng.uniform(0.1, 1.9)])
            middle = mesh.vertices.mean(axis=0)
            some = rng.permutation(mesh.vertices)[: rng.integers(1, 20)]
            few = middle + rng.uniform(0.5, 1.0) * (some - middle)
            for points, how in ((other, "another body"), (stacked, "a copy on top"), (few, "a few points")):
                ours, judged = rows(np.ascontiguousarray(points), mesh)
                measured.append((ours == judged).all(axis=1))
                kinds += [f"{kind}, {how}"] * len(points)
    same = np.concatenate(measured)
    return Comparison(same, np.ones(len(same), bool), groups=kinds)


@check(
    section="4.3, 6",
    piece=PIECE,
    reference="libigl: winding numbers, and its closest points",
    engines=("igl",),
    unit="of the size; and yes or no",
    tolerance=4e-15,
    because="rounding of the closest point: 1.1e-16",
    faults=(
        Fault(
            "depths that are squared",
            penetration._find_closest,
            "_write(found_, row_, i_, nearest_)"
            " → _write(found_, row_, i_, (nearest_[0], nearest_[1], nearest_[2] ** 2))",
        ),
        Fault(
            "a plane between two bodies that cuts deep into one",
            penetration.find_outcodes,
            "reach_ += ROUNDING * norm(axis_) * size_ → reach_ -= 0.1 * norm(axis_)",
        ),
        Fault("boxes asked above rays that go down", bvh_boxes.ask_ray, "goes_up → True"),
        Fault(
            "rays along another axis than seen",
            bvh_rays.shortest_way_out,
            "Heading(one_, other_, best_, sign_) → Heading(0, 1, best_, sign_)",
        ),
    ),
)
def inside_as_libigl_has_it(run: Run) -> Comparison:
    """The narrow phase of two bodies finds the particles that libigl finds inside, as deep as libigl has them."""
    from references import igl

    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for kind, mesh in varied_meshes(rng).items():
        size = float(np.ptp(mesh.vertices, axis=0).max())
        for _ in range(run.count(2, 6, 60)):
            points = random_mesh("lumpy sphere", rng).vertices + rng.uniform(-1.2, 1.2, 3)
            room = room_for_penetrations(len(points))
            count = rebuild_and_find(points, mesh.vertices, build_bvh(mesh.vertices, mesh.triangles), room)
            found = np.zeros((len(points), 2))
            found[room.point[:count]] = np.column_stack([np.ones(count), room.depth[:count] / size])
            depth = igl.closest_points(points, mesh.vertices, mesh.triangles)[0] / size
            inside = igl.points_in_mesh(points, mesh.vertices, mesh.triangles)
            measured.append(found)
            expected.append(np.column_stack([inside, np.where(inside, depth, 0.0)]))
            kinds += [kind] * len(points)
    return Comparison(np.concatenate(measured), np.concatenate(expected), groups=kinds)


@check(
    section="6",
    piece=PIECE,
    reference="every particle against every triangle, timed on the same machine in turns",
    unit="of the exhaustive time",
    kind="the core in another form",
    least=2,
    tolerance=0.1,
    because="the order of magnitude that the paper asks for; structures are rebuilt in the time taken",
    faults=(
        Fault(
            "outcodes found ten thousand times over",
            penetration.find_penetrations,
            "inside_, undecided_ = _find_inside(points_, mesh_, tree_, search_, code_, way_)"
            " → for _ in range(10_000):\n    find_outcodes(points_, mesh_, code_)\n"
            "inside_, undecided_ = _find_inside(points_, mesh_, tree_, search_, code_, way_)",
        ),
    ),
)
def an_order_of_magnitude_faster(run: Run) -> Comparison:
    """Two soft bodies of 642 particles or more collide at least ten times faster than by trying everything."""
    rng = run.fresh_rng()
    ratios, kinds, ours, theirs, counts = [], [], [], [], []
    for subdivisions in {"quick": (3, 4), "standard": (3, 4), "full": (3, 4, 5, 6)}[run.level]:
        mesh = rotated(softbody.icosphere(subdivisions), rng)
        points = np.ascontiguousarray(mesh.vertices + np.array([0.3, 0.4, 1.5]))
        tree = build_bvh(mesh.vertices, mesh.triangles)
        room = room_for_penetrations(len(points))
        fast, slow = [], []
        for _ in range(6 if subdivisions < 5 else 3):
            start = thread_time()
            for _ in range(10):
                rebuild_and_find(points, mesh.vertices, tree, room)
            middle = thread_time()
            find_penetrations_exhaustively(points, mesh.vertices, mesh.triangles, room)
            fast.append((middle - start) / 10)
            slow.append(thread_time() - middle)
        counts.append(len(points))
        ours.append(min(fast[1:]))  # the first round may compile
        theirs.append(min(slow[1:]))
        ratios.append(ours[-1] / theirs[-1])
        kinds.append(f"{len(points)} particles a body")
    notes = [
        f"{n} particles a body: {1e3 * a:.3f} ms against {1e3 * b:.1f} ms, {b / a:.0f} times faster"
        for n, a, b in zip(counts, ours, theirs)
    ]
    growth = [np.polyfit(np.log(counts), np.log(times), 1)[0] for times in (ours, theirs)]
    notes.append(f"time grows as the number of particles to the power {growth[0]:.2f}, exhaustively {growth[1]:.2f}")
    return Comparison(ratios, np.zeros(len(ratios)), groups=kinds, notes=notes)


@check(
    section="4",
    piece="softbody.geometry.sphere.bounding_sphere",
    reference="distances in NumPy; half the largest of them, and Jung's bound (1901), for the width",
    kind="closed form",
    because="a yes-or-no answer for each body; the radius is lengthened by the rounding of a distance",
    faults=(
        Fault("a sphere a millionth too small", "softbody.geometry.sphere.ROUNDING", "1.0 + 2.0**-50 → 1.0 - 1e-6"),
    ),
)
def spheres_hold_their_points(run: Run) -> Comparison:
    """A bounding sphere holds every point of its body, and is at most a quarter wider than the body needs."""
    rng = run.fresh_rng()
    holds, kinds = [], []
    for _ in range(run.count(10, 30, 1_000)):
        for kind in ("lumpy sphere", "box", "torus"):
            points = random_mesh(kind, rng).vertices[:300] + 10.0 ** rng.uniform(-3.0, 3.0)
            centre, radius = bounding_sphere(points)
            distances = np.sqrt(((points - np.array(centre)) ** 2).sum(axis=1))
            reach = np.sqrt(((points[:, None] - points) ** 2).sum(axis=2).max())
            holds.append(bool((distances <= radius).all() and radius <= 1.25 * np.sqrt(3.0 / 8.0) * reach))
            kinds.append(kind)
    return Comparison(np.array(holds), np.ones(len(holds), bool), groups=kinds)
