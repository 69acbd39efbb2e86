"""Claims about particles of one soft body inside another: which, under which triangle, and how fast found."""

from __future__ import annotations

from time import thread_time

import numpy as np

import softbody
from softbody import Mesh
from softbody.geometry import BVH, Penetrations, bounding_sphere, bvh, bvh_boxes, bvh_rays, penetration
from softbody.geometry.penetration import find_penetrations_exhaustively, points_of, room_for_penetrations
from validation.answers import Answers
from validation.cases import random_mesh, rotated
from validation.check import Comparison, Run, check
from validation.checks.geometry.cases import longest_side, random_meshes, varied_meshes
from validation.fault import Fault

FAMILY = "soft–soft narrow phase"
PIECE = "softbody.geometry.penetration.find_penetrations"


def _rebuild_and_find(points: np.ndarray, vertices: np.ndarray, tree: BVH, found: Penetrations) -> int:
    """Fit the structures to where the bodies are, and find which points are inside; return how many."""
    bvh.refit_bvh(tree, vertices)
    return penetration.find_penetrations(points_of(points), points_of(vertices), tree, bvh.search_space(tree), found)


def _rows(points: np.ndarray, mesh: Mesh, exhaustively: bool) -> np.ndarray:
    """Return what the structures, or trying everything, find: bits (m, 6), −1 where a point is not inside."""
    room = room_for_penetrations(len(points))
    if exhaustively:
        count = find_penetrations_exhaustively(points, mesh.vertices, mesh.triangles, room)
    else:
        count = _rebuild_and_find(points, mesh.vertices, bvh.build_bvh(mesh.vertices, mesh.triangles), room)
    bits = np.full((len(points), 6), -1, np.int64)
    numbers = np.column_stack([room.weights[:count], room.depth[:count]]).view(np.int64)
    bits[room.point[:count]] = np.column_stack([np.arange(count), room.triangle[:count], numbers])
    return bits


def _another_body(rng: np.random.Generator) -> np.ndarray:
    """Return the vertices of a lumpy sphere somewhere about the origin."""
    return random_mesh("lumpy sphere", rng).vertices + rng.uniform(-1.2, 1.2, 3)


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
    """The accelerated narrow phase of two bodies has the exhaustive one's bits.

    It finds the same particles, triangles, weights and depths.
    """
    rng, answers = run.fresh_rng(), Answers()
    for kind, mesh in varied_meshes(rng).items():
        for _ in range(run.count(2, 6, 60)):
            other = _another_body(rng)
            stacked = mesh.vertices + np.array([0.0, 0.0, rng.uniform(0.1, 1.9)])
            middle = mesh.vertices.mean(axis=0)
            some = rng.permutation(mesh.vertices)[: rng.integers(1, 20)]
            few = middle + rng.uniform(0.5, 1.0) * (some - middle)
            for asked, how in ((other, "another body"), (stacked, "a copy on top"), (few, "a few points")):
                points = np.ascontiguousarray(asked)
                same = (_rows(points, mesh, False) == _rows(points, mesh, True)).all(axis=1)
                answers.extend(same, np.ones(len(points), bool), kind=f"{kind}, {how}")
    return answers.comparison()


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
    """The narrow phase of two bodies finds libigl's inside particles and depths."""
    from references import igl

    rng, answers = run.fresh_rng(), Answers()
    for kind, mesh in varied_meshes(rng).items():
        size, tree = longest_side(mesh.vertices), bvh.build_bvh(mesh.vertices, mesh.triangles)
        for _ in range(run.count(2, 6, 60)):
            points = _another_body(rng)
            room = room_for_penetrations(len(points))
            count = _rebuild_and_find(points, mesh.vertices, tree, room)
            found = np.zeros((len(points), 2))
            found[room.point[:count]] = np.column_stack([np.ones(count), room.depth[:count] / size])
            depth = igl.closest_points(points, mesh.vertices, mesh.triangles)[0] / size
            inside = igl.points_in_mesh(points, mesh.vertices, mesh.triangles)
            answers.extend(found, np.column_stack([inside, np.where(inside, depth, 0.0)]), kind=kind)
    return answers.comparison()


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
            penetration.find_inside,
            "inside_, undecided_ = _find_inside(points_, mesh_, tree_, search_, code_, way_)"
            " → for _ in range(10_000):\n    find_outcodes(points_, mesh_, code_)\n"
            "inside_, undecided_ = _find_inside(points_, mesh_, tree_, search_, code_, way_)",
        ),
    ),
)
def an_order_of_magnitude_faster(run: Run) -> Comparison:
    """Two soft bodies collide ten times faster than by trying everything.

    At least so, bodies of 642 particles or more.
    """
    rng, answers = run.fresh_rng(), Answers()
    counts, ours, theirs = [], [], []
    for subdivisions in {"quick": (3, 4), "standard": (3, 4), "full": (3, 4, 5, 6)}[run.level]:
        mesh = rotated(softbody.icosphere(subdivisions), rng)
        points = np.ascontiguousarray(mesh.vertices + np.array([0.3, 0.4, 1.5]))
        tree = bvh.build_bvh(mesh.vertices, mesh.triangles)
        room = room_for_penetrations(len(points))
        fast, slow = [], []
        for _ in range(6 if subdivisions < 5 else 3):
            start = thread_time()
            for _ in range(10):
                _rebuild_and_find(points, mesh.vertices, tree, room)
            middle = thread_time()
            find_penetrations_exhaustively(points, mesh.vertices, mesh.triangles, room)
            fast.append((middle - start) / 10)
            slow.append(thread_time() - middle)
        counts.append(len(points))
        ours.append(min(fast[1:]))  # the first round may compile
        theirs.append(min(slow[1:]))
        answers.add(ours[-1] / theirs[-1], 0.0, kind=f"{len(points)} particles a body")
    notes = [
        f"{n} particles a body: {1e3 * a:.3f} ms against {1e3 * b:.1f} ms, {b / a:.0f} times faster"
        for n, a, b in zip(counts, ours, theirs)
    ]
    growth = [np.polyfit(np.log(counts), np.log(times), 1)[0] for times in (ours, theirs)]
    notes.append(f"time grows as the number of particles to the power {growth[0]:.2f}, exhaustively {growth[1]:.2f}")
    return answers.comparison(notes=notes)


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
    """A bounding sphere holds its points, at most a quarter too wide."""
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(10, 30, 1_000)):
        for kind, mesh in random_meshes(1, rng, ("lumpy sphere", "box", "torus")):
            points = mesh.vertices[:300] + 10.0 ** rng.uniform(-3.0, 3.0)
            centre, radius = bounding_sphere(points)
            distances = np.sqrt(((points - np.array(centre)) ** 2).sum(axis=1))
            reach = np.sqrt(((points[:, None] - points) ** 2).sum(axis=2).max())
            holds = bool((distances <= radius).all() and radius <= 1.25 * np.sqrt(3.0 / 8.0) * reach)
            answers.add(holds, True, kind=kind)
    return answers.comparison()
