"""Claims that soft bodies that are cut by a plane fall into its halves, and that nothing is lost by it."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

import softbody
from softbody import Mesh, ParameterError, SimulationError, SnapshotError, SoftBody, World
from softbody.bodies import cutting, sharing, soft_rows
from softbody.mesh import section
from validation.answers import Answers
from validation.cases import MESH_KINDS, random_mesh, random_orientations, rotated
from validation.check import Comparison, Run, check
from validation.checks.worlds.cases import NEVER_ACT, WEIGHTLESS
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


def is_whole(body: SoftBody) -> bool:
    """Tell whether a body goes through itself nowhere; one that does may be refused."""
    from references import igl

    return not len(igl.self_intersections(body.positions, body.triangles))


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
        Fault("vertices cut that are farther", section.sides_of, "s_ < nearest → s_ < 1.5 * nearest"),
        Fault(
            "new vertices off the edge's line",
            section._between,
            "a_ + way_ * (b_ - a_) → a_ + way_ * (1.001 * b_ - a_)",
        ),
        Fault(
            "caps beside the plane",
            section._bent,
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
                    ours, theirs = np.zeros((2, most, 4))
                    ours[: len(told)], theirs[: len(expected)] = (
                        np.reshape(told, (-1, 4)),
                        np.reshape(expected, (-1, 4)),
                    )
                    answers.extend(ours, theirs, 1.0, f"{kind}, a piece of it" if turn else kind)
                    cut, faces, _ = igl.behind(points, triangles, plane.point, sign * plane.normal)
                    judge, volumes = (
                        np.array([trimesh.volume(cut, faces), *trimesh.centroid(cut, faces)]),
                        [row[0] for row in told],
                    )
                    centre = np.average([row[1:] for row in told], axis=0, weights=volumes) if told else np.zeros(3)
                    answers.add([np.sum(volumes), *centre], judge, 1.0, f"{kind}, a whole side")
    return answers.comparison()


def cut_vertices(pieces: tuple[SoftBody, ...], plane: Half) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return the heights (n,) [m] of vertices that pieces share, and of each piece's others."""
    points = np.concatenate([piece.positions for piece in pieces])
    _, which, count = np.unique(points, axis=0, return_inverse=True, return_counts=True)
    shared, heights = count[which.ravel()] > 1, plane.heights(points)
    starts = np.cumsum([0, *(len(piece.positions) for piece in pieces)])
    return heights[shared], [heights[a:b][~shared[a:b]] for a, b in pairwise(starts)]


def anywhere(rng: np.random.Generator, points: np.ndarray) -> Half:
    """Return a plane through a body, not too near to its outermost points."""
    normal = random_orientations(rng, 1)[0, :3]
    normal /= np.linalg.norm(normal)
    heights = points @ normal
    level = rng.uniform(*np.quantile(heights, (0.1, 0.9)))
    return Half(level * normal, normal)


@check_cut(
    reference="the plane itself; volumes by Manifold, of halves beside planes a fifth of the longest edge from it",
    engines=("manifold3d", "igl"),
    faults=(
        Fault("vertices cut that are far", section.sides_of, "s_ < nearest → s_ < 2.0 * nearest"),
        Fault("edges cut at their middle", section._nodes, "np.clip(a_, nearest, 1.0 - nearest) → 0.5 + 0.0 * a_"),
        Fault(
            "a cut beside the plane",
            section._bent,
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
    for _ in range(run.count(3, 10, 200)):
        for kind in MESH_KINDS:
            body = running(rng, random_mesh(kind, rng), 0.02)
            for _ in range(2):
                if not is_whole(body):
                    break
                points, edges, triangles, first = body.positions.copy(), body.edges, body.triangles.copy(), body.volume
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
                volume, tiny = sum(piece.volume for piece in ahead), 1e-13 * first
                is_between = narrow[0] - tiny <= volume <= wide[0] + tiny
                adds_up = abs(sum(piece.volume for piece in pieces) - first) <= tiny
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
        Fault("lids through the skin", section._caps_go_through, "(cut_.origin[m_] == NOT).any() → False"),
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

    def cut(body: SoftBody, plane: Half, expected: list[int], kind: str, **options: float) -> SoftBody | None:
        try:
            pieces = body.cut(*plane, **options)
        except Exception as error:  # of a damaged core
            answers.add(False, True, kind=f"{kind}: {error}")
            return None
        told = [is_sound(piece) for piece in pieces]
        found, sound = sorted(row[-1] for row in told), [row[:-1] == SOUND for row in told]
        answers.add(found == sorted(expected) if expected else bool(found), True, kind=f"{kind}, χ")
        answers.extend(sound, [True] * len(sound), kind=kind)
        return pieces[0] if all(sound) else None

    for _ in range(run.count(3, 10, 480)):
        for kind in MESH_KINDS:
            mesh = random_mesh(kind, rng)
            body: SoftBody | None = standing(Mesh(mesh.vertices * rng.uniform(0.5, 2.0, 3), mesh.triangles))
            for turn in range(3):
                if body:
                    plane = anywhere(rng, body.positions)
                    body = cut(body, plane, eulers(body, plane), f"{kind}, a piece of it" if turn else kind)
        ring = softbody.torus(1.0, 0.3, int(rng.integers(12, 36)), int(rng.integers(6, 14)))
        lean, angle = rng.normal(0.0, 0.05, 3), rng.uniform(0.0, 2.0 * np.pi)
        along = np.array([np.cos(angle), np.sin(angle), 0.0])
        cut(standing(ring), Half(0.1 * lean, along + lean), [2, 2], "ring, across")
        cut(standing(ring), Half(0.1 * lean, (0.0, 0.0, 1.0) + lean), [0, 0], "ring, flat")
        open_at = Half(along + lean, np.cross(along, (0.0, 0.0, 1.0)) + lean)
        cut(standing(ring), open_at, [2], "ring, open", radius=rng.uniform(0.6, 1.2))
    return answers.comparison()


def refusal(call: Callable[..., object], *given: Any, **named: Any) -> str:
    """Return what a call is refused with; of a damaged core, the name of another error."""
    try:
        call(*given, **named)
    except ParameterError as error:
        return str(error)
    except Exception as error:  # of a damaged core
        return type(error).__name__
    return ""


class Whole(NamedTuple):
    """What some bodies have together, by NumPy's sums over their particles and springs."""

    mass: float  # [kg]
    moment: np.ndarray  # (3,) [kg m]
    momentum: np.ndarray  # (3,) [kg m/s]
    spin: np.ndarray  # (3,) [kg m²/s] about the origin
    spring: float  # [J]
    gas: float  # nRT [J]
    force: np.ndarray  # (3,) [N] external
    torque: np.ndarray  # (3,) [N m]

    def rows(self) -> dict[str, np.ndarray]:
        """Return three numbers of each kind."""
        return {
            "mass, springs' energy, gas": np.array([self.mass, self.spring, self.gas]),
            "centre of mass": self.moment,
            "momentum": self.momentum,
            "angular momentum": self.spin,
            "external force": self.force,
            "its torque": self.torque,
        }


def whole(bodies: tuple[SoftBody, ...]) -> Whole:
    """Return what bodies have together."""
    found = np.zeros(18)
    for body in bodies:
        points, velocity, mass = body.positions, body.velocities, body.masses[:, None]
        length = np.linalg.norm(points[body.edges[:, 1]] - points[body.edges[:, 0]], axis=1)
        spring = 0.5 * float(body.stiffness @ (length - body.rest_length) ** 2)
        force = body.external_force
        sums = (mass * points, mass * velocity, mass * np.cross(points, velocity), force, np.cross(points, force))
        found += [mass.sum(), spring, body.gas, *np.concatenate([each.sum(axis=0) for each in sums])]
    moment, momentum, spin, pull, torque = found[3:].reshape(5, 3)
    return Whole(float(found[0]), moment, momentum, spin, float(found[1]), float(found[2]), pull, torque)


def full(rng: np.random.Generator, kind: str, case: int) -> SoftBody:
    """Return a body that runs, with a liquid, fixed particles, a box inside, joints and unequal springs, or without."""
    mesh = random_mesh(kind, rng)
    options: dict[str, Any] = {}
    if case % 2:
        options |= {"liquid_density": rng.uniform(0.5, 2.0), "sound_speed": rng.uniform(3.0, 6.0)}
    if case % 3 == 1:
        options |= {"fixed": rng.choice(len(mesh.vertices), 6, replace=False)}
    body = running(rng, mesh, 0.02, **options)
    world, count = body.world, len(body.edges)
    if case % 3 != 1:
        body.velocities = body.velocities + rng.normal(0.0, 0.3, body.positions.shape)
    body.set_springs(body.stiffness * rng.uniform(0.5, 2.0, count), body.rest_length * rng.uniform(0.8, 1.2, count))
    body.external_force = rng.normal(size=body.positions.shape)
    world.add_soft_body(softbody.icosphere(1, 0.1), 1.0, 100.0, 1.0, (9.0, 0.0, 0.0), name="other")
    for _ in range(3):
        place = body.centre + rng.normal(size=3)
        world.add_joint((body, place), (world["other"], place), rng.uniform(1.0, 5.0))
    if case % 4 > 1:
        size = rng.uniform(0.02, 0.05, 3)
        for place in rng.uniform(body.positions.min(axis=0), body.positions.max(axis=0), (40, 3)):
            if len(world.boxes) < 3:
                try:
                    world.add_box(size, 0.1, place, random_orientations(rng, 1)[0], inside=body)
                except ParameterError:  # it does not fit there
                    continue
    return body


def goes_through(plane: Half, box: softbody.Box, reach: float) -> bool:
    """Tell whether a box is so near to a plane."""
    return bool(abs(plane.heights(box.position)) < np.linalg.norm(box.size) + reach)


@check_cut(
    reference="the same before the cut: sums over particles and springs by NumPy, places of boxes by libigl",
    engines=("igl",),
    kind="invariant",
    unit="of the largest of the three, or 1",
    tolerance=1e-13,
    because="rounding of sums over some thousand particles: 2.7e-14 at worst, of 36 bodies",
    faults=(
        Fault("mass by area alone", sharing.with_centre, "np.abs(left).max() <= m_ → True"),
        Fault("momenta of what was interpolated", cutting._velocities, "with_momenta(a_, b_) → velocity"),
        Fault("a spin that is lost", sharing.with_momenta, "np.cross(spin, arm) → 0.0 * arm"),
        Fault("gas by half", cutting._rows_of_pieces, "piece.room / room → 1.0 / len(pieces)"),
        Fault(
            "springs on both sides of all their stiffness", cutting._springs, "np.where(on_both_sides, 0.5, 1.0) → 1.0"
        ),
        Fault("parts of springs as stiff as whole ones", cutting._springs, "a_ / part * b_ → a_ * b_"),
        Fault(
            "joints on the particles of before", cutting.cut_body, "with_ends_on(parts, after, [row], numbers) → after"
        ),
        Fault(
            "forces on both sides",
            cutting._forces,
            "shared[:, None] * force[old] → np.where(stays, 1.0, 0.0)[:, None] * force[old]",
        ),
    ),
)
def nothing_is_lost(run: Run) -> Comparison:
    """A body that is cut loses nothing.

    Of bodies of every kind of mesh that run, spin and shake, with springs that are all unequal, a liquid or none, boxes
    inside, particles that are fixed, joints to another, and forces: mass and its centre, both momenta, energy of
    springs and gas, nRT, pressure in each piece, forces and torques, where joints are, and boxes in which piece.
    """
    from references import igl

    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(12, 36, 600)):
        body = full(rng, MESH_KINDS[case % len(MESH_KINDS)], case)
        world, plane = body.world, anywhere(rng, body.positions)
        while any(goes_through(plane, box, 0.1) for box in world.boxes):
            world.remove(next(box for box in world.boxes if goes_through(plane, box, 0.1)))
        if not is_whole(body):
            continue
        before, pressure = whole((body,)), body.pressure
        ends, energies, fixed = (
            [joint.ends.copy() for joint in world.joints],
            world.energies(),
            body.positions[body.fixed],
        )
        try:
            pieces = body.cut(*plane)
        except ParameterError as error:
            answers.add([0.0] * 3, [1.0] * 3, kind=str(error))
            continue
        after = whole(pieces)
        for what, row in before.rows().items():
            answers.add(after.rows()[what], row, float(np.abs(row).max(initial=1.0)), what)
        for joint, place in zip(world.joints, ends):
            answers.extend(joint.ends, place, 10.0, "joints")
        for piece in pieces:
            answers.add([piece.pressure, 0.0, 0.0], [pressure, 0.0, 0.0], pressure, "pressure")
        now = world.energies()
        told = [now.spring + now.gas, now.liquid, now.external]
        scale = energies.spring + np.abs(energies.gas) + before.gas
        answers.add(told, [energies.spring + energies.gas, energies.liquid, energies.external], scale, "energies")
        held = np.concatenate([piece.positions[piece.fixed] for piece in pieces])
        answers.add([len({*map(tuple, held)} ^ {*map(tuple, fixed)}), 0.0, 0.0], [0.0] * 3, kind="fixed")
        for box in world.boxes:
            within = [
                bool(igl.points_in_mesh(box.position[None], each.positions, each.triangles)[0]) for each in pieces
            ]
            answers.add([within.index(True), 0.0, 0.0], [pieces.index(box.inside), 0.0, 0.0], kind="boxes inside")
    return answers.comparison()


def pulls_at(bodies: tuple[SoftBody, ...], places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the force (n, 3) [N] of springs at each of `places` (n, 3) [m], and elsewhere (k, 3), on all there."""
    points, forces = list[np.ndarray](), list[np.ndarray]()
    for body in bodies:
        a, b = body.positions[body.edges.T]
        length = np.linalg.norm(b - a, axis=1)
        pull = (body.stiffness * (length - body.rest_length) / length)[:, None] * (b - a)
        force = np.zeros(body.positions.shape)
        np.add.at(force, body.edges[:, 0], pull)
        np.add.at(force, body.edges[:, 1], -pull)
        points, forces = [*points, body.positions], [*forces, force]
    every, at = np.unique(np.concatenate([places, *points]), axis=0, return_inverse=True)
    total = np.zeros(every.shape)
    np.add.at(total, at.ravel()[len(places) :], np.concatenate(forces))
    return total[at.ravel()[: len(places)]], total[np.setdiff1d(np.arange(len(every)), at.ravel()[: len(places)])]


@check_cut(
    reference="Hooke's law at the same places before, and no force where there was no particle, by NumPy",
    engines=("igl",),
    kind="invariant",
    unit="of stiffness times length of a spring",
    tolerance=1e-12,
    because="rounding of forces: 1e-14 at worst of three seeds",
    faults=(
        Fault("parts of springs at rest", cutting._springs, "own_.model['edge_rest_length'][at] * part → length"),
        Fault(
            "parts of springs of all their rest length",
            cutting._springs,
            "own_.model['edge_rest_length'][at] * part → own_.model['edge_rest_length'][at]",
        ),
        Fault(
            "springs on both sides of all their stiffness", cutting._springs, "np.where(on_both_sides, 0.5, 1.0) → 1.0"
        ),
        Fault(
            "lids that are drawn",
            cutting._springs,
            "np.where(is_part, a_ * part, length) → np.where(is_part, a_ * part, 0.99 * length)",
        ),
        Fault("springs of another edge", cutting._springs, "low * number + high → high * number + low"),
    ),
)
def springs_pull_as_before(run: Run) -> Comparison:
    """Springs pull a cut body's particles as before.

    Of running bodies with springs that are all unequal, cut anywhere and once more: what pulls at each place where a
    particle was, at both of it if it was cut, and nothing at new ones, all at the same place together.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(2, 10, 100)):
        for kind in MESH_KINDS:
            body = running(rng, random_mesh(kind, rng), 0.02)
            body.set_springs(body.stiffness * rng.uniform(0.5, 2.0, len(body.edges)))
            for _ in range(2):
                if not is_whole(body):
                    break
                points = body.positions.copy()
                before, _ = pulls_at((body,), points)
                scale = float(body.stiffness.mean() * body.rest_length.mean())
                try:
                    pieces = body.cut(*anywhere(rng, points))
                except ParameterError as error:
                    answers.add([0.0] * 3, [1.0] * 3, kind=str(error))
                    break
                here, new = pulls_at(pieces, points)
                answers.extend(here, before, scale, kind)
                answers.extend(new, np.zeros(new.shape), scale, f"{kind}, new")
    return answers.comparison()


def told(bodies: tuple[SoftBody, ...]) -> np.ndarray:
    """Return places, velocities, mass and gas of all particles (n, 8)."""
    rows = [
        np.column_stack([each.positions, each.velocities, each.masses, np.full(len(each.masses), each.gas)])
        for each in bodies
    ]
    return np.concatenate(rows)


def beside(rows: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return of `others` (m, k) that which is nearest to each of `rows` (n, k), or zeros if there are not as many."""
    from references import scipy

    return scipy.nearest_rows(rows, others) if len(rows) == len(others) else np.zeros(rows.shape)


@check_cut(
    reference="mirror images; the same bodies, with vertices and triangles numbered otherwise",
    kind="invariant",
    engines=("scipy",),
    unit="m, m/s, kg, J, at bodies of one of each",
    tolerance=2e-11,
    because="rounding, that grows by 0.05 s of motion: 1.6e-12 at worst of three seeds",
    faults=(
        Fault("velocities of the first end", cutting._carried, "a_ + w_ * (b_ - a_) → a_"),
        Fault("places by numbers", section._nodes, "np.clip(a_, b_, c_) → np.clip(a_, b_, c_) + 1e-9 * cut[:, 0]"),
        Fault(
            "masses by numbers",
            sharing._leaning,
            "np.exp(e_) → np.exp(arm @ lean + 1e-9 * np.arange(len(mass)))",
        ),
        Fault(
            "lids stiffer by their numbers",
            cutting._springs,
            "np.where(is_part, stiffness, a_) → np.where(is_part, stiffness, a_ * (1.0 + 1e-3 * edges[:, 0]))",
        ),
        Fault(
            "the first vertex ahead",
            section.sides_of,
            "side = np.where(heights >= 0.0, 1, -1) → side = np.where(np.append(np.inf, heights[1:]) >= 0.0, 1, -1)",
        ),
    ),
)
def symmetric(run: Run) -> Comparison:
    """What is symmetric falls into mirror images.

    Balls, drawn out, that move as symmetrically, are cut where they are mirrored: after 0.05 s, too. Bodies of every
    kind of mesh, cut anywhere, are the same however they are numbered: at once, and after 0.02 s. Halves are
    parted first: where they touch, the order of contacts counts.
    """
    rng, answers = run.fresh_rng(), Answers()

    def parted(world: World, plane: Half) -> None:
        for each in world.soft_bodies:
            each.positions = each.positions + np.sign(plane.heights(each.positions).sum()) * plane.normal

    for case in range(run.count(3, 12, 100)):
        axis, drawn = case % 3, rng.uniform(0.7, 1.4, 3)
        world = World(WEIGHTLESS)
        mesh = softbody.icosphere(1 + case % 2)
        body = world.add_soft_body(mesh, 1.0, 100.0, 1.0)
        body.positions = body.positions * drawn
        body.velocities = body.positions * rng.normal(size=3)
        turn, mirror = np.eye(3), np.ones(8)
        mirror[[axis, 3 + axis]] = -1.0
        try:
            body.cut((0.0, 0.0, 0.0), turn[axis])
        except ParameterError as error:
            answers.add([0.0] * 8, [1.0] * 8, kind=str(error))
            continue
        for when in ("mirrored", "mirrored, later"):
            if len(world.soft_bodies) == 2:
                one, other = (told((each,)) for each in world.soft_bodies)
                answers.extend(one, beside(one, other * mirror), 1.0, when)
            else:
                answers.add([0.0] * 8, [1.0] * 8, kind=when)
            parted(world, Half(np.zeros(3), turn[axis]))
            world.run(0.05)
    for _ in range(run.count(1, 4, 40)):
        for kind in MESH_KINDS:
            mesh = random_mesh(kind, rng)
            mesh = mesh.scaled(1.0 / float(np.ptp(mesh.vertices, axis=0).max()))
            number, order = rng.permutation(len(mesh.vertices)), rng.permutation(len(mesh.triangles))
            shuffled = np.empty(mesh.vertices.shape)
            shuffled[number] = mesh.vertices
            spin, plane, sets = rng.normal(size=3), anywhere(rng, mesh.vertices), list[list[np.ndarray]]()
            for each in (mesh, Mesh(shuffled, np.roll(number[mesh.triangles[order]], 1, axis=1))):
                world = World(WEIGHTLESS)
                body = world.add_soft_body(each, 1.0, 100.0, 1.0)
                body.velocities = np.cross(spin, body.positions)
                try:
                    body.cut(*plane)
                except ParameterError:
                    continue
                sets.append([told(world.soft_bodies)])
                parted(world, plane)
                world.step(2e-4, 100, allow_unstable=True)
                sets[-1].append(told(world.soft_bodies))
            if len(sets) < 2:
                answers.add([0.0] * 8, [1.0] * 8, kind="refused")
                continue
            for when, one, other in zip(("renumbered", "renumbered, later"), *sets):
                answers.extend(one, beside(one, other), 1.0, when)
    return answers.comparison()


def depth_between(pieces: tuple[SoftBody, ...]) -> float:
    """Return how deep a particle of one piece is in another, at most [m]."""
    from references import igl

    deepest = 0.0
    for one in pieces:
        for other in pieces:
            within = igl.points_in_mesh(one.positions, other.positions, other.triangles)
            if one != other and within.any():
                depth, *_ = igl.closest_points(one.positions[within], other.positions, other.triangles)
                deepest = float(np.maximum(deepest, depth.max()))
    return deepest


@check_cut(
    reference="the exact winding number and distances by libigl, frame by frame; self-intersections by CGAL",
    engines=("igl",),
    unit="m, of bodies of 1 m",
    tolerance=6e-3,
    because="lids lie on each other, and give way in each step: 1.7e-3 at worst of three seeds; an edge is 0.15",
    faults=(
        NEVER_ACT,
        Fault("lids below turned inward", section._put_together, "ids[-1][cap] → ids[-1][cap[:, ::-1]]"),
        Fault("no thickness", soft_rows.remade, "2.0 * v_ / a_ → 0.0 * length.mean()"),
    ),
)
def halves_stay_apart(run: Run) -> Comparison:
    """Halves of a body on the ground stay out of each other.

    Balls and blocks are cut level or upright, and go on for a second by default settings, pressed together by their
    gas: how deep particles of one are in another at most, and whether one is warned of that does not meet itself.
    """
    from references import igl

    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(8, 24, 200)):
        world = World()
        world.add_ground()
        mesh = softbody.icosphere(2, 0.5) if case % 2 else softbody.box((1.0, 0.8, 0.7), 4)
        body = world.add_soft_body(mesh, 1.0, rng.uniform(100.0, 400.0), rng.uniform(5.0, 60.0), (0.0, 0.0, 0.55))
        world.run(0.3)
        way = np.array([1.0, 0.0, 0.0] if case % 4 < 2 else [0.0, 0.0, 1.0]) + rng.normal(0.0, 0.1, 3)
        kind, deepest, warned, meets = ("upright", "level")[case % 4 // 2], 0.0, 0, 0
        try:
            pieces = body.cut(body.centre + rng.uniform(-0.1, 0.1, 3), way)
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                for _ in range(30):
                    world.run(1.0 / 30.0)
                    deepest = float(np.maximum(deepest, depth_between(pieces)))
                    meets += sum(len(igl.self_intersections(each.positions, each.triangles)) for each in pieces)
            warned = len(caught) if not meets else 0
        except (ParameterError, SimulationError):  # of a damaged core
            deepest = 1.0
        answers.add([deepest, float(warned)], [0.0, 0.0], kind=kind)
    return answers.comparison()


@check_cut(
    reference="the same world, that was not interrupted, or has another number of threads",
    kind="the core in another form",
    faults=(
        Fault(
            "boxes that are not there",
            soft_rows.with_soft_bodies,
            "boxes_volumes(model, hosts) → 1e-3 + boxes_volumes(model, hosts)",
        ),
        Fault(
            "springs that go on twice as stiff",
            soft_rows.with_soft_bodies,
            "rings_of(model, t_) → rings_of(model._replace(edge_stiffness=2.0 * model.edge_stiffness), t_)",
        ),
        Fault(
            "masses of another piece",
            soft_rows.remade,
            "np.where(particles.fixed, 0.0, 1.0 / particles.mass) → np.where(particles.fixed, 0.0, 1.0 / length.sum())",
        ),
    ),
)
def goes_on_to_the_same_bits(run: Run) -> Comparison:
    """A world with a cut body goes on to the same bits.

    After a snapshot right after the cut was restored in another world, and a file of it loaded; with one thread and
    two. One of before the cut is the whole body again, as if it had not been cut.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(3, 8, 60)):
        mesh, threads = random_mesh(MESH_KINDS[case % len(MESH_KINDS)], rng), [1, 2]
        seed, hashes = int(rng.integers(2**31)), list[str]()
        for count in threads:
            drawn, world = np.random.default_rng(seed), World(threads=count)
            world.add_ground(-1.0)
            size = float(np.ptp(mesh.vertices, axis=0).max())
            spin = drawn.normal(size=3)
            body = world.add_soft_body(mesh.scaled(1.0 / size), 1.0, 100.0, 5.0, velocity=spin, name="it")
            other = world.add_soft_body(softbody.icosphere(1, 0.2), 0.5, 50.0, 1.0, (0.0, 0.0, 1.2))
            world.add_joint((body, (0.0, 0.0, 0.5)), (other, other.centre), 5.0)
            world.run(0.05)
            earlier, alone, again, loaded, undone = world.snapshot(), *(World(threads=count) for _ in range(4))
            alone.restore(earlier)
            try:
                body.cut(*anywhere(drawn, body.positions))
                again.restore(world.snapshot())
                with TemporaryDirectory() as folder:
                    world.save(Path(folder) / "cut.npz")
                    loaded = World.load(Path(folder) / "cut.npz")
                undone.restore(world.snapshot())
                undone.restore(earlier)
                for each in (world, again, loaded, undone, alone):
                    each.step(2e-4, 200, allow_unstable=True)
            except (ParameterError, SnapshotError, SimulationError) as error:  # of a damaged core
                answers.add(False, True, kind=str(error))
                continue
            hashes.append(world.state_hash())
            answers.add(again.state_hash() == hashes[-1], True, kind="restored")
            answers.add(loaded.state_hash() == hashes[-1], True, kind="loaded")
            answers.add(undone.state_hash() == alone.state_hash(), True, kind="undone")
        answers.add(len({*hashes}) == 1, True, kind="threads")
    return answers.comparison()


@check_cut(
    reference="the documentation; what the claim has asked for",
    kind="specification",
    faults=(
        Fault("a plane beside the body", cutting.cut_body, "cut is None → False"),
        Fault("a direction of no length", cutting._plane, "0.0 < length < np.inf → True"),
        Fault("a radius of any sign", cutting._plane, "radius != np.inf → False"),
        Fault("parts that go on", section._within, "(some[part] & ~every[part]).any() → False"),
        Fault("boxes that are cut", cutting._pieces, "if lost: raise ParameterError(a_) → pass"),
        Fault("what hangs is forgotten", soft_rows.check_may_change, "hangs.any() → False"),
    ),
)
def refused_by_name(run: Run) -> Comparison:
    """A cut that cannot be is refused, and changes nothing.

    A plane that misses or is none, a radius that ends in the section, a box in the way, what hangs in the body,
    particles that are not finite: the error names the argument or body; the world is as it was.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 4, 40)):
        lean = tuple(rng.uniform(-0.05, 0.05, 3))
        up, middle = (0.1, 0.2, 1.0), (0.0, 0.0, 0.03)
        wrong: list[tuple[str, str, dict[str, Any]]] = [
            ("misses", "plane misses <soft body 0 'it'", {"point": (3.0, 3.0, 3.0)}),
            ("misses by a radius", "plane misses <soft body 0 'it'", {"radius": 0.1}),
            ("no direction", "normal", {"normal": (0.0, 0.0, 0.0)}),
            ("no number", "normal", {"normal": (np.nan, 0.0, 1.0)}),
            ("infinite", "normal", {"normal": (np.inf, 0.0, 1.0)}),
            ("too long", "normal", {"normal": (1e200, 1e200, 1.0)}),
            ("nowhere", "point", {"point": (0.0, np.nan, 0.0)}),
            ("of two", "point", {"point": (0.0, 1.0)}),
            ("words", "point", {"point": "here"}),
            ("negative", "radius", {"radius": -1.0}),
            ("zero", "radius", {"radius": 0.0}),
            ("no number of metres", "radius", {"radius": np.nan}),
            ("none", "radius", {"radius": None}),
            ("ends in the section", "radius is 0.9 m", {"point": (0.3, 0.0, 0.03), "radius": 0.9}),
            ("a box in the way", "box 0 'lid'", {"box": (0.0, 0.0, 0.03)}),
            ("hangs", "suspension 0 'eye'", {"hangs": True}),
            ("not finite", "soft body 0 'it'", {"nan": True}),
        ]
        for kind, words, given in wrong:
            world = World()
            body = world.add_soft_body(softbody.icosphere(2), 1.0, 100.0, 1.0, name="it")
            world.add_soft_body(softbody.icosphere(1), 1.0, 100.0, 1.0, (5.0, 0.0, 0.0), name="other")
            box, hangs, spoilt = given.pop("box", None), given.pop("hangs", False), given.pop("nan", False)
            if box:
                world.add_box((0.2, 0.2, 0.2), 0.1, np.add(box, lean), inside=body, name="lid")
            if hangs:
                world.suspend([(0.1, 0.0, -0.4)], body, name="eye")
            if spoilt:
                body.positions[int(rng.integers(len(body.positions))), 1] = np.nan
            before = world.snapshot()
            arguments: dict[str, Any] = {"point": middle, "normal": np.add(up, lean), **given}
            error = refusal(body.cut, **arguments)
            after = world.snapshot()
            kept = set(before) == set(after) and all(
                np.asarray(before[name]).tobytes() == np.asarray(after[name]).tobytes() for name in before
            )
            answers.add([words in error, kept, world["it"] == body], [True] * 3, kind=kind)
    return answers.comparison()
