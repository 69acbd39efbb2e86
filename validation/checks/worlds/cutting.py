"""Claims that soft bodies that are cut by a plane fall into its halves, and that nothing is lost by it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np

import softbody
from softbody import Mesh, ParameterError, SoftBody, World
from softbody.bodies import cutting, sharing, soft_rows
from softbody.mesh import section
from validation.answers import Answers
from validation.cases import MESH_KINDS, random_mesh, random_orientations, rotated
from validation.check import Comparison, Run, check
from validation.checks.worlds.cases import WEIGHTLESS
from validation.fault import Fault

FAMILY = "bodies that are cut and joined"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

PART = 0.2  # of an edge: a vertex that is nearer to the plane is cut itself, so it is documented

check_cut = partial(check, section="beyond the paper", piece="softbody.SoftBody.cut")


class Half(NamedTuple):
    """A plane."""

    point: np.ndarray  # (3,) [m]
    normal: np.ndarray  # (3,) of any length

    def heights(self, points: np.ndarray) -> np.ndarray:
        """Return how far in front of it points (n, 3) are: (n,) [m]."""
        return np.asarray((points - self.point) @ (self.normal / np.linalg.norm(self.normal)))


def running(rng: np.random.Generator, mesh: Mesh, seconds: float = 0.1, **options: Any) -> SoftBody:
    """Return a body of 1 m that has been thrown, spinning, and bent by its gas, for some time by default settings."""
    world = World()
    mesh = mesh.scaled(1.0 / float(np.ptp(mesh.vertices, axis=0).max()))
    options = {"velocity": rng.normal(size=3), **options}
    body = world.add_soft_body(
        mesh, rng.uniform(0.5, 2.0), rng.uniform(100.0, 400.0), rng.uniform(2.0, 10.0), **options
    )
    body.positions = body.positions * rng.uniform(0.9, 1.1, 3)
    body.velocities = body.velocities + np.cross(rng.normal(0.0, 2.0, 3), body.positions - body.centre)
    world.run(seconds)
    return body


def solid(kind: str, rng: np.random.Generator) -> Mesh:
    """Return a mesh of a kind, coarse enough to be cut between its vertices."""
    if kind == "ball":
        return rotated(softbody.icosphere(int(rng.integers(1, 3))), rng)
    if kind == "box":
        return rotated(softbody.box(rng.uniform(0.8, 1.6, 3), int(rng.integers(2, 5))), rng)
    return rotated(
        softbody.torus(1.0, rng.uniform(0.3, 0.5), 2 * int(rng.integers(5, 10)), int(rng.integers(5, 9))), rng
    )


def between_vertices(rng: np.random.Generator, body: SoftBody) -> Half | None:
    """Return a plane that no vertex is near, such that it cuts many edges, if there is one among some thousand."""
    points, ends = body.positions.copy(), body.edges
    middle, number = points.mean(axis=0), 3000
    edges = ends[rng.integers(len(ends), size=number)]
    along = points[edges[:, 1]] - points[edges[:, 0]]
    along[::3] = points[edges[::3, 0]] - middle  # caps around a vertex
    along = along / np.linalg.norm(along, axis=1, keepdims=True) + rng.normal(0.0, 0.05, along.shape)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    part = rng.uniform(0.3, 0.7, (number, 1))
    places = part * points[edges[:, 0]] + (1.0 - part) * points[edges[:, 1]]
    heights = points @ along.T - np.einsum("ij,ij->i", places, along)
    a, b = heights[ends[:, 0]], heights[ends[:, 1]]
    is_cut = a * b < 0.0
    share = np.minimum(np.abs(a), np.abs(b)) / (np.abs(a) + np.abs(b))
    cuts = np.where((share > PART + 1e-6) | ~is_cut, is_cut, -len(ends)).sum(axis=0)
    best = int(np.argmax(cuts))
    return Half(places[best], along[best]) if cuts[best] > 2 else None


def sides_of(pieces: tuple[SoftBody, ...], plane: Half) -> list[list[SoftBody]]:
    """Return the pieces in front of a plane, and behind it, the largest first."""
    ahead = [piece for piece in pieces if plane.heights(piece.positions).sum() > 0.0]
    behind = [piece for piece in pieces if piece not in ahead]
    return [sorted(side, key=lambda piece: -piece.volume) for side in (ahead, behind)]


@check_cut(
    reference="volume and centroid of each piece by Manifold, and of each side by CGAL's exact arithmetic",
    engines=("manifold3d", "igl", "trimesh"),
    unit="of the size",
    tolerance=1e-14,
    because="rounding on all sides: 1.3e-15 at worst of three seeds",
    faults=(
        Fault("a cut at an edge's middle", section._nodes, "from_first_ / whole_ → 0.5 + 0.0 * whole_"),
        Fault("vertices cut that are farther", section.sides_of, "s_ < NEAREST → s_ < 1.5 * NEAREST"),
        Fault(
            "new vertices off the edge's line",
            section._between,
            "a_ + way_ * (b_ - a_) → a_ + way_ * (1.001 * b_ - a_)",
        ),
        Fault(
            "caps beside the plane",
            section.cut_surface,
            "plane_.point + i_ @ axes_ → 1.001 * plane_.point + i_ @ axes_",
        ),
        Fault("a side that is one piece", section.pieces_of, "part == label → (part == label) | (part == part.max())"),
    ),
)
def halves_are_those_of_others(run: Run) -> Comparison:
    """A plane between vertices cuts a body in its halves.

    Balls, blocks and rings that were thrown, spin, and are bent by their gas, and pieces of them: how many pieces are
    on each side, their volume and centroid; of each side together, too.
    """
    from references import igl, manifold3d, trimesh

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(3, 20, 200)):
        for kind in ("ball", "box", "ring"):
            body = running(rng, solid(kind, rng))
            for turn in range(2):
                plane = between_vertices(rng, body)
                if plane is None:
                    continue
                points, triangles = body.positions.copy(), body.triangles.copy()
                judged = manifold3d.halves(points, triangles, *plane)
                try:
                    pieces = body.cut(*plane)
                except ParameterError:  # of a damaged core
                    pieces = ()
                for side, solids, sign in zip(sides_of(pieces, plane), judged, (-1.0, 1.0)):
                    told = [[piece.volume, *trimesh.centroid(piece.positions, piece.triangles)] for piece in side]
                    expected = [[each.volume, *each.centre] for each in solids]
                    most = max(len(told), len(expected))
                    rows = [
                        np.concatenate([each, np.zeros((most - len(each), 4))]) if each else np.zeros((most, 4))
                        for each in (told, expected)
                    ]
                    answers.extend(*rows, 1.0, f"{kind}, a piece of it" if turn else kind)
                    cut, faces, _ = igl.behind(points, triangles, plane.point, sign * plane.normal)
                    whole, volumes = (
                        np.array([trimesh.volume(cut, faces), *trimesh.centroid(cut, faces)]),
                        [row[0] for row in told],
                    )
                    centre = np.average([row[1:] for row in told], axis=0, weights=volumes) if told else np.zeros(3)
                    answers.add([np.sum(volumes), *centre], whole, 1.0, f"{kind}, a whole side")
    return answers.comparison()


def cut_vertices(pieces: tuple[SoftBody, ...], plane: Half) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return the heights (n,) [m] of vertices that pieces share, and of each piece's others."""
    points = np.concatenate([piece.positions for piece in pieces])
    _, which, count = np.unique(points, axis=0, return_inverse=True, return_counts=True)
    shared, heights = count[which.ravel()] > 1, plane.heights(points)
    starts = np.cumsum([0, *(len(piece.positions) for piece in pieces)])
    return heights[shared], [heights[a:b][~shared[a:b]] for a, b in zip(starts, starts[1:])]


def anywhere(rng: np.random.Generator, points: np.ndarray) -> Half:
    """Return a plane through a body, not too near to its outermost points."""
    normal = random_orientations(rng, 1)[0, :3]
    normal /= np.linalg.norm(normal)
    heights = points @ normal
    level = rng.uniform(*np.quantile(heights, (0.1, 0.9)))
    return Half(level * normal, normal)


@check_cut(
    reference="the plane itself; volumes by Manifold, of halves beside planes a fifth of the longest edge from it",
    engines=("manifold3d",),
    faults=(
        Fault("vertices cut that are far", section.sides_of, "s_ < NEAREST → s_ < 2.0 * NEAREST"),
        Fault("edges cut at their middle", section._nodes, "np.clip(a_, NEAREST, 1.0 - NEAREST) → 0.5 + 0.0 * a_"),
        Fault(
            "a cut beside the plane",
            section.cut_surface,
            "(points - plane.point) @ plane.normal → (points - plane.point) @ plane.normal - 0.4 * spacing",
        ),
    ),
)
def bent_by_a_fifth_of_an_edge(run: Run) -> Comparison:
    """A cut strays from its plane by a fifth of an edge.

    Bodies of every kind of mesh that were thrown, spin, and are bent by their gas, cut anywhere, and the largest piece
    once more. What pieces share is so near, all else of each on one side; volumes are between those of halves that are
    cut so much aside, and add up.
    """
    from references import manifold3d

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(3, 20, 200)):
        for kind in MESH_KINDS:
            body = running(rng, random_mesh(kind, rng), 0.02)
            for _ in range(2):
                points, edges, triangles, whole = body.positions.copy(), body.edges, body.triangles.copy(), body.volume
                plane = anywhere(rng, points)
                heights = plane.heights(points)
                crossed = edges[heights[edges[:, 0]] * heights[edges[:, 1]] <= 0.0]
                most = 1.000001 * PART * np.abs(np.diff(heights[crossed], axis=1)).max()
                way = most * plane.normal
                wide, narrow = (
                    [
                        sum(solid.volume for solid in side)
                        for side in manifold3d.halves(points, triangles, at, plane.normal)
                    ]
                    for at in (plane.point - way, plane.point + way)
                )
                try:
                    pieces = body.cut(*plane)
                except ParameterError as error:
                    answers.add([False] * 4, [True] * 4, kind=str(error))
                    break
                shared, others = cut_vertices(pieces, plane)
                is_near = (np.abs(shared) <= most).all()
                is_apart = all((each > 0.0).all() or (each < 0.0).all() for each in others)
                ahead, _ = sides_of(pieces, plane)
                volume, tiny = sum(piece.volume for piece in ahead), 1e-13 * whole
                is_between = narrow[0] - tiny <= volume <= wide[0] + tiny
                adds_up = abs(sum(piece.volume for piece in pieces) - whole) <= tiny
                answers.add([is_near, is_apart, is_between, adds_up], [True] * 4, kind=kind)
    return answers.comparison()


def is_sound(body: SoftBody) -> list[float]:
    """Return whether a body is closed, turned outward, of one shell, nowhere pinched; its pairs that meet, and χ."""
    from references import igl, trimesh

    points, triangles = body.positions, body.triangles
    closed, turned, euler = trimesh.topology(points, triangles)
    outward, pinched = trimesh.volume(points, triangles) > 0.0, igl.is_pinched(triangles).any()
    shells, meet = len(np.unique(igl.shells(triangles))), len(igl.self_intersections(points, triangles))
    return [closed, turned, outward, shells, not pinched, meet, euler]


SOUND = [1.0, 1.0, 1.0, 1.0, 1.0, 0.0]


def standing(mesh: Mesh) -> SoftBody:
    """Return a body at rest."""
    return World(WEIGHTLESS).add_soft_body(mesh, 1.0, 100.0, 1.0)


def eulers(body: SoftBody, plane: Half) -> list[int]:
    """Return χ of the pieces that a plane leaves, those ahead first; none where planes nearby leave others."""
    from references import manifold3d

    points, triangles, heights = body.positions.copy(), body.triangles.copy(), plane.heights(body.positions)[body.edges]
    most = PART * np.abs(np.diff(heights[heights.prod(axis=1) <= 0.0], axis=1)).max()
    found = []
    for part in (-1.0, -0.5, 0.0, 0.5, 1.0):
        sides = manifold3d.halves(points, triangles, plane.point + part * most * plane.normal, plane.normal)
        found.append([sorted(solid.euler for solid in side) for side in sides])
    return [euler for side in found[0] for euler in side] if found == found[:1] * 5 else []


@check_cut(
    reference="topology by trimesh, shells by libigl, self-intersections by CGAL, and χ of pieces by Manifold",
    engines=("trimesh", "igl", "manifold3d"),
    kind="third-party engine",
    faults=(
        Fault("lids turned inward", section._put_together, "ids[1][cap[:, ::-1]] → ids[1][cap]"),
        Fault("a lid for one side only", section._put_together, "ids[-1][cap] → ids[-1][cap[:0]]"),
        Fault("vertices that both sides keep", section._whole, "rows[below] = lower[of_vertex[rows[below]]] → pass"),
        Fault("a triangle left out", section._part, "[[a, b, d], [b, c, d]] → [[a, b, d], [b, d, c]]"),
        Fault("a cut that passes where it has been", section._passes, "((a == 0) & (b == 0)).any() → False"),
        Fault("a cut that ends at a vertex", section._passes, "int((a * b < 0).sum()) + len(cut) == 2 → True"),
        Fault("parts cut that are far", section._within, "plane.radius → np.inf", 0),
    ),
)
def pieces_are_closed(run: Run) -> Comparison:
    """What is cut off, again and again, is closed.

    Bodies of every kind of mesh, drawn out anyhow, and pieces of them; rings cut across, flat, and open within a
    radius. Each piece is closed, turned outward, of one shell, nowhere pinched, and goes through itself nowhere; its χ
    is that of others' halves, where planes nearby leave the same.
    """
    rng, answers = run.fresh_rng(), Answers()

    def add(pieces: tuple[SoftBody, ...], expected: list[int], kind: str) -> None:
        told = [is_sound(piece) for piece in pieces]
        found = sorted(row[-1] for row in told)
        answers.add(found == sorted(expected) if expected else bool(found), True, kind=f"{kind}, χ")
        for row in told:
            answers.add(row[:-1] == SOUND, True, kind=kind)

    def cut(body: SoftBody, plane: Half, expected: list[int], kind: str, **options: float) -> SoftBody | None:
        try:
            pieces = body.cut(*plane, **options)
        except ParameterError as error:
            answers.add(False, True, kind=f"{kind}: {error}")
            return None
        add(pieces, expected, kind)
        return pieces[0]

    for _ in range(run.count(3, 30, 600)):
        for kind in MESH_KINDS:
            mesh = random_mesh(kind, rng)
            body: SoftBody | None = standing(Mesh(mesh.vertices * rng.uniform(0.5, 2.0, 3), mesh.triangles))
            for turn in range(3):
                if body:
                    plane = anywhere(rng, body.positions)
                    body = cut(body, plane, eulers(body, plane), f"{kind}, a piece of it" if turn else kind)
        ring = softbody.torus(1.0, 0.3, int(rng.integers(12, 36)), int(rng.integers(6, 14)))
        lean, turn = rng.normal(0.0, 0.05, 3), rng.uniform(0.0, 2.0 * np.pi)
        along = np.array([np.cos(turn), np.sin(turn), 0.0])
        cut(standing(ring), Half(0.1 * lean, along + lean), [2, 2], "ring, across")
        cut(standing(ring), Half(0.1 * lean, (0.0, 0.0, 1.0) + lean), [0, 0], "ring, flat")
        open_at = Half(along + lean, np.cross(along, (0.0, 0.0, 1.0)) + lean)
        cut(standing(ring), open_at, [2], "ring, open", radius=rng.uniform(0.6, 1.2))
    return answers.comparison()
