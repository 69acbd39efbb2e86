"""Claims about soft bodies that hold themselves."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

import softbody
from softbody import Mesh, SoftBody, World
from softbody.collision.soft import guard, near_features, self_rows, skin, soft_response
from softbody.dynamics import watch
from softbody.geometry import star
from softbody.stepping import watched
from validation.answers import Answers
from validation.cases import MESH_KINDS, random_mesh
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "soft bodies"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

FRAMES = 30
# A fold in which impulses that were at odds with each other once made 319 times the energy. And how much of it there
# may be at most: steps of springs by themselves gain and lose some.
AT_ODDS, MOST_RISE = 115, 1.05


class Scene(NamedTuple):
    """A world in which bodies fold, some `seconds` in steps of `h` [s]; `drive` acts before each, at a time [s]."""

    world: World
    seconds: float
    h: float
    drive: Callable[[float], None] = lambda time: None


def weak_ball(fine: int) -> Scene:
    """A ball that collapses under its own weight."""
    world = World()
    world.add_ground()
    world.add_soft_body(softbody.icosphere(1 + fine, 0.5), 1.0, 8.0, 0.3, (0.0, 0.0, 0.55), self_contact=True)
    return Scene(world, 1.2, 1e-3)


def flat_bag(fine: int) -> Scene:
    """A bag without gas falls flat, on to the ground and on to itself."""
    world = World()
    world.add_ground()
    world.add_soft_body(bag(8 * fine, 0.1), 0.5, 100.0, 0.0, (0.0, 0.0, 0.2), self_contact=True)
    return Scene(world, 0.8, 1e-3)


def ring_under_plate(fine: int) -> Scene:
    """A limp ring is pressed flat by a plate that moves as told."""
    world = World()
    world.add_ground()
    ring = softbody.torus(0.6, 0.22, 14 * fine, 8 * fine)
    world.add_soft_body(ring, 1.0, 60.0, 0.2, (0.0, 0.0, 0.24), self_contact=True)
    plate = world.add_box((2.0, 2.0, 0.1), None, (0.0, 0.0, 0.6), velocity=(0.0, 0.0, -0.5))

    def drive(time: float) -> None:
        if time > 0.8:
            plate.velocity = (0.0, 0.0, 0.0)

    return Scene(world, 1.1, 1e-3, drive)


def closing_jaws(fine: int) -> Scene:
    """A flat body is folded by two jaws that close."""
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(bag(8 * fine, 0.16), 0.5, 60.0, 0.02, self_contact=True)
    body.positions += np.multiply.outer(np.cos(np.pi * body.positions[:, 0]), [0.0, 0.0, 0.02])
    jaws = [
        world.add_box((0.1, 1.4, 1.0), None, (0.62 * side, 0.0, 0.0), velocity=(-0.5 * side, 0.0, 0.0))
        for side in (-1.0, 1.0)
    ]

    def drive(time: float) -> None:
        if time > 0.95:
            for jaw in jaws:
                jaw.velocity = (0.0, 0.0, 0.0)

    return Scene(world, 1.2, 1e-3, drive)


def long_tube(fine: int) -> Scene:
    """A long tube is bent until it meets itself: its ends are led around each other."""
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(tube(3.0, 0.12, 6 * fine, 24 * fine), 1.0, 300.0, 0.6, self_contact=True)
    ends = np.flatnonzero(np.abs(body.positions[:, 0]) > 1.4)
    side = np.sign(body.positions[ends, 0])

    def drive(time: float) -> None:
        cosine, sine = np.cos(3.0 * time), np.sin(3.0 * time)
        speeds = -1.8 * side * abs(cosine), sine * side, np.full(len(ends), 0.6 * cosine)
        body.velocities[ends] = np.stack(speeds, axis=1)

    return Scene(world, 1.5, 5e-4, drive)


def knot(fine: int) -> Scene:
    """A thin ring in the shape of a trefoil is pulled tight at three places."""
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(trefoil(0.06, 6, 32 * fine), 1.0, 200.0, 0.05, self_contact=True)
    way = body.positions / np.linalg.norm(body.positions[:, :2], axis=1, keepdims=True)
    far = np.linalg.norm(body.positions[:, :2], axis=1) > 1.25
    body.external_force = np.where(far[:, None], 0.6 * way * [1.0, 1.0, 0.0], 0.0)
    return Scene(world, 0.8, 5e-4)


def towel(fine: int) -> Scene:
    """A flat bag falls over a rod, and its halves come to hang beside each other."""
    world = World()
    world.add_ground(height=-1.0)
    world.add_soft_body(bag(8 * fine, 0.08), 0.4, 60.0, 0.0, (0.0, 0.0, 0.2), self_contact=True)
    world.add_box((0.06, 1.4, 0.06), None, (0.03, 0.0, 0.0))
    return Scene(world, 0.9, 1e-3)


def limp_balls(fine: int) -> Scene:
    """Limp balls fall into a tray, on to each other."""
    world, across = World(), 0.9
    world.add_ground()
    for side in (-1.0, 1.0):
        world.add_box((0.1, 2.0, 1.2), None, (side * across / 2.0, 0.0, 0.6))
        world.add_box((2.0, 0.1, 1.2), None, (0.0, side * across / 2.0, 0.6))
    rng = np.random.default_rng(fine)
    for k in range(4 * fine):
        place = (*rng.uniform(-0.15, 0.15, 2), 0.3 + 0.45 * k)
        world.add_soft_body(softbody.icosphere(2, 0.2), 0.2, 6.0, 0.05, place, self_contact=True)
    return Scene(world, 0.9, 1e-3)


def crushed_ball(fine: int) -> Scene:
    """A ball with a tenth of the gas that it needs is crushed by a heavy box."""
    world = World()
    world.add_ground()
    world.add_soft_body(softbody.icosphere(1 + fine, 0.4), 0.5, 30.0, 0.2, (0.0, 0.0, 0.42), self_contact=True)
    world.add_box((1.2, 1.2, 0.3), 4.0, (0.0, 0.0, 1.1))
    return Scene(world, 1.0, 1e-3)


def twisted_tube(fine: int) -> Scene:
    """A tube is wrung: its ends turn against each other."""
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(tube(1.6, 0.2, 7 * fine, 16 * fine), 1.0, 200.0, 0.1, self_contact=True)
    ends = np.flatnonzero(np.abs(body.positions[:, 0]) > 0.74)
    side = np.sign(body.positions[ends, 0])

    def drive(time: float) -> None:
        turn = np.zeros((len(ends), 3))
        turn[:, 0] = 6.0 * side
        arm = body.positions[ends] * [0.0, 1.0, 1.0]
        body.velocities[ends] = np.cross(turn, arm) - np.multiply.outer(0.4 * side, [1.0, 0.0, 0.0])

    return Scene(world, 1.0, 5e-4, drive)


def from_the_gallery(fine: int) -> Scene:
    """The scene `limp`: a ball, a ring under a plate that falls, a pillow over a rod."""
    return Scene(softbody.scenes.limp.build(), 0.4 + 0.4 * fine, 1e-3)


SCENES = (
    weak_ball,
    flat_bag,
    ring_under_plate,
    closing_jaws,
    long_tube,
    knot,
    towel,
    limp_balls,
    crushed_ball,
    twisted_tube,
    from_the_gallery,
)


def bag(across: int, thickness: float) -> Mesh:
    """Return two square sheets of 1 m that are joined at their rims, up to a `thickness` [m] apart."""
    number: dict[tuple[int, int, int], int] = {}
    vertices, triangles = list[tuple[float, float, float]](), list[tuple[int, ...]]()
    for side in (1, -1):
        at = np.zeros((across + 1, across + 1), np.int64)
        for i, j in np.ndindex(at.shape):
            is_rim = i in (0, across) or j in (0, across)
            key = (i, j, 0 if is_rim else side)
            if key not in number:
                number[key] = len(vertices)
                x, y = i / across, j / across
                height = 0.5 * thickness * (1.0 - (2.0 * x - 1.0) ** 4) * (1.0 - (2.0 * y - 1.0) ** 4)
                vertices.append((x - 0.5, y - 0.5, side * height))
            at[i, j] = number[key]
        for i, j in np.ndindex(across, across):
            a, b, c, d = map(int, (at[i, j], at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]))
            # The diagonal by which no corner of the bag is a triangle with two edges on the rim.
            halves = [(a, b, c), (a, c, d)] if (i < across // 2) == (j < across // 2) else [(a, b, d), (b, c, d)]
            triangles += halves if side > 0 else [half[::-1] for half in halves]
    return Mesh(np.array(vertices), np.array(triangles))


def tube(length: float, radius: float, around: int, along: int) -> Mesh:
    """Return a closed tube along x."""
    line = np.stack([np.linspace(-0.5 * length, 0.5 * length, along + 1), *np.zeros((2, along + 1))], axis=1)
    side, up = np.tile([0.0, 1.0, 0.0], (along + 1, 1)), np.tile([0.0, 0.0, 1.0], (along + 1, 1))
    return _around(line, side, up, radius, around, is_ring=False)


def trefoil(radius: float, around: int, along: int) -> Mesh:
    """Return a tube around a trefoil knot."""
    t = 2.0 * np.pi * np.arange(along) / along
    x, y = np.sin(t) + 2.0 * np.sin(2.0 * t), np.cos(t) - 2.0 * np.cos(2.0 * t)
    line = 0.5 * np.stack([x, y, -np.sin(3.0 * t)], axis=1)
    ways = np.roll(line, -1, axis=0) - np.roll(line, 1, axis=0)
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    side = np.cross(ways, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    return _around(line, side, np.cross(side, ways), radius, around, is_ring=True)


def _around(line: np.ndarray, side: np.ndarray, up: np.ndarray, radius: float, around: int, is_ring: bool) -> Mesh:
    """Return the surface at a `radius` [m] around a line (n, 3), across which `side` and `up` are."""
    angle = 2.0 * np.pi * np.arange(around) / around
    rows = line[:, None] + radius * (np.cos(angle)[:, None] * side[:, None] + np.sin(angle)[:, None] * up[:, None])
    vertices, triangles, count = [*rows.reshape(-1, 3)], [], len(line)
    for q in range(count if is_ring else count - 1):
        for c in range(around):
            a, b = q * around + c, q * around + (c + 1) % around
            d, e = (a + around) % (count * around), (b + around) % (count * around)
            triangles += [(a, d, b), (b, d, e)] if (q + c) % 2 else [(a, d, e), (a, e, b)]
    if not is_ring:
        vertices += [line[0], line[-1]]
        for c in range(around):
            last = (count - 1) * around
            triangles += [(len(vertices) - 2, c, (c + 1) % around)]
            triangles += [(len(vertices) - 1, last + (c + 1) % around, last + c)]
    points, rows = np.array(vertices), np.array(triangles)
    a, b, c = points[rows].transpose(1, 0, 2)
    return Mesh(points, rows if (a * np.cross(b, c)).sum() > 0.0 else rows[:, ::-1])


@check(
    section="7",
    piece="softbody.World.step",
    reference="libigl's remesh_self_intersections, with CGAL's exact predicates, frame by frame",
    engines=("igl",),
    unit="bodies that meet themselves",
    faults=(
        Fault("nobody holds itself", skin.find_self_contacts, "skin.distance[body] > 0.0 → skin.distance[body] > 1e9"),
        Fault("contacts are not listed", self_rows.add_self_contacts, "add_contact(a_, b_, c_, d_, e_) → pass"),
        Fault("ways do not count", skin._note_ways, "norm(z_) → 0.0"),
        Fault("features are listed once", skin._list_anew, "is_any, most, skin.listed[i] = True, z_, NEW → pass"),
    ),
)
def nothing_goes_through_itself(run: Run) -> Comparison:
    """Limp bodies that hold themselves never meet themselves.

    Eleven scenes, with default settings: a ball that collapses, a flat bag, a ring under a plate, closing jaws, a tube
    that is bent and one that is wrung, a knot pulled tight, a towel over a rod, limp balls in a tray, a ball under a
    box; and `limp`. Thirty frames of each.
    """
    from references import igl

    answers = Answers()
    for build in SCENES:
        scene = build(run.count(1, 1, 2))
        bodies, steps = scene.world.soft_bodies, round(scene.seconds / scene.h)
        for frame in range(FRAMES):
            while scene.world.steps < (frame + 1) * steps // FRAMES:
                scene.drive(scene.world.time)
                scene.world.step(scene.h)
            crossed = sum(len(igl.self_intersections(body.positions, body.triangles)) > 0 for body in bodies)
            answers.add(crossed, 0, kind=(build.__doc__ or "").rstrip("."))
    return answers.comparison()


@check(
    section="7",
    piece="softbody.World.step",
    reference="libigl's remesh_self_intersections, with CGAL's exact predicates, step by step; sums of particles",
    engines=("igl",),
    unit="wrong, or relative change",
    tolerance=1e-9,
    because="sums of some hundred terms; angular momentum counts a millionth, as friction acts at two places that are "
    "as far apart as the sides are when a step begins",
    faults=(
        Fault("motion is not cut", guard.cut_motion, "not never_meet(a_, b_, c_, d_, e_, f_) → False"),
        Fault("what is cut is lost", guard.give_back, "accumulate(velocity, i, z_) → pass"),
        Fault("impulses at odds act in full", soft_response._add_no_energy, "bounces or is_own → bounces"),
        Fault("a last step that is not looked at", watched.stays_whole, "is_seen_whole(a_, b_, c_, d_, e_) → True"),
    ),
)
def folds_at_speed(run: Run) -> Comparison:
    """Sides that are thrown at each other do not cross.

    Balls and rings, without weight, whose caps fly at each other at 1 to 300 m/s while all turns, in each of thirty
    steps; rings whose halves would be past each other after one step; momenta stay, and no energy comes in.
    """
    from references import igl

    rng, answers = run.fresh_rng(), Answers()
    for fold in range(run.count(6, 40, 1_000)):
        world, body = _thrown(rng if fold else np.random.default_rng(AT_ODDS))
        energy = most = _energy(world)
        speed = np.linalg.norm(body.velocities, axis=1).max()
        h = min(0.5 * world.stable_time_step(), 0.02 / speed)
        mass, momentum, moment = body.mass * speed, world.linear_momentum(), world.angular_momentum()
        kind = f"up to {10.0 ** np.ceil(np.log10(speed)):.0f} m/s"
        for _ in range(30):
            world.step(h)
            most = float(np.maximum(most, _energy(world)))  # which keeps a NaN
            answers.add(len(igl.self_intersections(body.positions, body.triangles)) > 0, 0.0, kind=f"{kind}: whole")
        answers.add(float(not most <= MOST_RISE * energy), 0.0, kind=f"{kind}: energy")
        answers.add(np.abs(world.linear_momentum() - momentum).max() / mass, 0.0, kind=f"{kind}: momentum")
        change = np.abs(world.angular_momentum() - moment).max() / mass
        answers.add(change, 0.0, scale=1e6, kind=f"{kind}: angular momentum")
        body = _thrown_across(rng)
        crossed = len(igl.self_intersections(body.positions, body.triangles)) > 0
        answers.add(crossed, 0.0, kind="past each other in one step")
    return answers.comparison()


def _energy(world: World) -> float:
    """Return all energies [J] of a world."""
    return float(sum(world.energies()))


def _thrown_across(rng: np.random.Generator) -> SoftBody:
    """Return a limp ring after a step in which its halves would go through each other, from where nothing is near."""
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(softbody.torus(0.5, 0.2, 20, 10), 1.0, 1e-3, 0.0, damping=0.0, self_contact=True)
    x = body.positions[:, 0]
    inwards = -np.sign(x) * np.minimum(np.abs(x) / 0.3, 1.0)
    body.velocities = np.outer(inwards, rng.uniform(0.32, 0.4) * np.array([1.0, 0.0, 0.0]))
    world.step(1.0, allow_unstable=True)
    return body


def _thrown(rng: np.random.Generator) -> tuple[World, SoftBody]:
    """Return a world of one body that turns, and whose caps fly at each other."""
    world = World(gravity=(0.0, 0.0, 0.0))
    mesh = softbody.icosphere(2, 0.5) if rng.random() < 0.5 else softbody.torus(0.5, 0.2, 20, 10)
    stiffness, gas = 10.0 ** rng.uniform(1.0, 2.5), 10.0 ** rng.uniform(-1.0, 1.0)
    body = world.add_soft_body(mesh, 1.0, stiffness, gas, self_contact=True)
    x, speed = body.positions, 10.0 ** rng.uniform(0.0, 2.5)
    way = rng.normal(size=3)
    along = x @ (way / np.linalg.norm(way))
    aside = np.linalg.norm(x - np.multiply.outer(along, way / np.linalg.norm(way)), axis=1)
    towards = np.where(aside < rng.uniform(0.2, 0.6), -np.sign(along), 0.0)
    turning = np.cross(rng.normal(size=3), x)
    body.velocities = speed * np.multiply.outer(towards, way / np.linalg.norm(way)) + turning
    return world, body


@check(
    section="7",
    piece="softbody.collision.soft.near_features",
    reference="the IPC Toolkit: vertices and triangles, edges and edges, and their distances",
    engines=("ipctk",),
    unit="wrong, or part of the size",
    tolerance=1e-12,
    because="near parallel edges lose half the digits of a double",
    faults=(
        Fault("edges are left out", near_features._add_pairs, "e < 0 → True"),
        Fault("particles are left out", near_features._add_pairs, "surface.touching[v] != one → True"),
        Fault("far too soon", near_features._are_far, "other_high + margin → other_high"),
        Fault("the least gap is that of particles", near_features._least_gap_of_two, "e < 0 or f < 0 → True"),
        Fault("the least gap is that of edges", near_features._least_gap_of_two, "surface.touching[v] == one → False"),
    ),
)
def near_features_are_found(run: Run) -> Comparison:
    """All features nearer than a margin are found, with their distance.

    Meshes of all kinds, as they are and folded by a random shake of up to some edges.
    """
    from references import ipctk

    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(30, 200, 10_000)):
        mesh = random_mesh(MESH_KINDS[trial % len(MESH_KINDS)], rng)
        size = np.ptp(mesh.vertices, axis=0).max()
        vertices = mesh.vertices + size * 10.0 ** rng.uniform(-3.0, -1.0) * rng.normal(size=mesh.vertices.shape)
        margin = size * 10.0 ** rng.uniform(-3.0, -1.0)
        ours, gaps, least = listed(mesh, vertices, margin)
        judged, distances = ipctk.near_features(vertices, mesh.edges, mesh.triangles, margin)
        same = np.array_equal(ours, judged)
        answers.add(float(not same), 0.0, kind="which")
        if same and len(gaps):
            answers.add(np.abs(gaps - distances).max() / size, 0.0, kind="how far")
        answers.add((least - min(distances, default=margin)) / size, 0.0, kind="the least")
    return answers.comparison()


def listed(mesh: Mesh, vertices: np.ndarray, margin: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Return (pairs (p, 3), gaps (p,) [m], least gap [m]) of a mesh whose vertices are elsewhere, in order."""
    world = World()
    world.add_soft_body(mesh, 1.0, 1.0, 0.0)
    world.state.particle_position[:] = vertices
    surfaces = skin.build_surfaces(world.model, world.state.particle_position)
    count, _ = skin.near_features_of(world.model, world.state, surfaces, margin, np.empty(0, np.int64))
    pairs = np.empty(count, np.int64)
    skin.near_features_of(world.model, world.state, surfaces, margin, pairs)
    pairs = np.sort(pairs)
    found, gaps = [], []
    for pair in pairs.tolist():
        kind, (a, b) = near_features.kind_of(pair), near_features.features_of(pair)
        corners = [a, *mesh.triangles[b]] if kind == near_features.TRIANGLE else [*mesh.edges[a], *mesh.edges[b]]
        found.append((kind, a, b))
        gaps.append(near_features.gap_of(kind, *map(tuple, vertices[corners].tolist())))
    least = skin.least_gap_of_body(world.model, world.state, surfaces, 0, margin)
    return np.array(found, np.int64).reshape(-1, 3), np.array(gaps), least


@check(
    section="7",
    piece="softbody.geometry.star.room_of_star",
    reference="the IPC Toolkit: the least distance of two features without a common vertex",
    engines=("ipctk",),
    unit="disagreements",
    faults=(Fault("room to the altitude", star.room_of_star, "min(least_lane(room), a_) → 3.0 * altitude"),),
)
def what_is_seen_from_high_has_nothing_near(run: Run) -> Comparison:
    """What is seen whole from high above has nothing near itself.

    Meshes of all kinds, shaken and flattened, whose mean is far above all triangles: neither as they are, nor when each
    vertex has moved as far as it may.
    """
    from references import ipctk

    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(60, 400, 20_000)):
        mesh = random_mesh(MESH_KINDS[trial % len(MESH_KINDS)], rng)
        shake = rng.normal(size=mesh.vertices.shape) * 10.0 ** rng.uniform(-4.0, -2.0)
        vertices = (mesh.vertices + shake) * 10.0 ** rng.uniform(-2.0, 0.0, 3)
        size = np.ptp(vertices, axis=0).max()
        corners = vertices[mesh.triangles]
        distance = min(skin.OF_SIZE * size, skin.OF_LOWEST * skin.lowest_altitude(corners))
        room = star.room_of_mesh(vertices, mesh.triangles, skin.HEIGHTS * distance)
        if not room > 0.0:
            continue
        way = rng.normal(size=vertices.shape)
        way *= room * rng.uniform(0.9, 1.0) / np.linalg.norm(way, axis=1, keepdims=True)
        for kind, now in ("as it is", vertices), ("moved", vertices + way):
            near, _ = ipctk.near_features(now, mesh.edges, mesh.triangles, distance)
            answers.add(len(near), 0, kind=kind)
    return answers.comparison()


@check(
    section="7",
    piece="softbody.World.step",
    reference="the same world without self-contact; with another body; on two threads; restored in mid-fold",
    kind="the core in another form",
    unit="bits that differ",
    faults=(
        Fault("lists are not in order", skin._list_anew, "sort_pairs(a_, b_, c_) → pass"),
        Fault("whoever is watched may go anywhere", watch.stays_in_room, "return False → return True"),
        Fault("nobody looks before", watched.give_room, "return is_whole → return True"),
    ),
)
def nothing_shows_but_contacts(run: Run) -> Comparison:
    """Self-contact changes no bit of a body that does not touch itself.

    And none depends on threads, on a snapshot in mid-fold, on whether steps are asked for one by one, or on whether
    there is another body far away: a ball and a ring that fall, and limp balls that fold.
    """
    answers = Answers()
    for mesh, gas in (softbody.icosphere(2, 0.4), 60.0), (softbody.torus(0.4, 0.15, 18, 10), 60.0):
        ends = [_fallen(mesh, gas, holds, run.count(200, 600, 3_000)) for holds in (True, False)]
        same = (ends[0] == ends[1]).all(axis=1)
        answers.extend(same, np.ones(len(same), bool), kind="without contact")
    before, after = 500, run.count(200, 400, 1_500)
    one = _limp_pair(1)
    one.step(1e-3, before)
    kept = one.snapshot()
    one.step(1e-3, after)
    two, three = World(), _limp_pair(1)
    two.restore(kept)
    two.step(1e-3, after)
    for _ in range(before + after):
        three.step(1e-3)
    others = [("restored", two), ("one by one", three)]
    if run.count(0, 1, 1):  # what moves bodies on threads is compiled for half a minute
        others.append(("threads", _limp_pair(2)))
        others[-1][1].step(1e-3, before + after)
    pairs = [(kind, one, other) for kind, other in others]
    # A body alone is moved by many steps at once, while it is watched, until it may touch itself.
    alone, beside = _limp(softbody.icosphere(2, 0.4), False), _limp(softbody.icosphere(2, 0.4), True)
    for steps in 1, 200, 7, run.count(292, 492, 1_000):
        alone.step(1e-3, steps)
        beside.step(1e-3, steps)
    for kind, first, second in [*pairs, ("beside another", alone, beside)]:
        position, other = first.state.particle_position, second.state.particle_position
        same = (position == other[: len(position)]).all(axis=1)
        answers.extend(same, np.ones(len(same), bool), kind=kind)
    return answers.comparison()


def _limp(mesh: Mesh, has_neighbour: bool) -> World:
    """Return a limp body above the ground, alone or far from another."""
    world = World()
    world.add_ground()
    world.add_soft_body(mesh, 1.0, 20.0, 0.05, (0.0, 0.0, 0.5), self_contact=True)
    if has_neighbour:
        world.add_soft_body(softbody.icosphere(1, 0.4), 1.0, 400.0, 60.0, (100.0, 0.0, 0.5))
    return world


def _fallen(mesh: Mesh, gas: float, holds_itself: bool, steps: int) -> np.ndarray:
    """Return where the particles of a body with much gas are, after a fall to the ground."""
    world = World()
    world.add_ground()
    world.add_soft_body(mesh, 1.0, 400.0, gas, (0.0, 0.0, 0.6), (1.0, 0.0, 0.0), self_contact=holds_itself)
    world.step(0.5 * world.stable_time_step(), steps)
    return world.state.particle_position


def _limp_pair(threads: int) -> World:
    """Return two limp balls, one above the other."""
    world = World(threads=threads)
    world.add_ground()
    for k in range(2):
        world.add_soft_body(softbody.icosphere(2, 0.4), 1.0, 20.0, 0.3, (0.0, 0.0, 0.5 + 0.85 * k), self_contact=True)
    return world


@check(
    section="7",
    piece="softbody.World.step",
    reference="the distance that the body says it keeps, by the IPC Toolkit",
    engines=("ipctk",),
    unit="parts of the distance",
    tolerance=5e-3,
    because="sweeps end where contacts lack a 256th of what holds their body: some 5e-4 of the distance is seen",
    faults=(
        Fault(
            "less distance",
            self_rows.add_self_contacts,
            "distance - dot(apart, normal) → 0.3 * distance - dot(apart, normal)",
        ),
    ),
)
def layers_keep_their_distance(run: Run) -> Comparison:
    """Layers of a flat bag lie at the skin's distance.

    Without gas, on the ground; which bears its weight.
    """
    from references import ipctk

    answers = Answers()
    for across in (6, 8, 10, 12, 14, 16)[: run.count(3, 4, 6)]:
        world = World()
        world.add_ground()
        mesh = bag(across, 0.1)
        body = world.add_soft_body(mesh, 0.5, 100.0, 0.0, (0.0, 0.0, 0.08), self_contact=True)
        h = min(1e-3, 0.8 * world.stable_time_step())
        world.step(h, round(run.count(2, 3, 3) / h))
        _, gaps = ipctk.near_features(body.positions, mesh.edges, mesh.triangles, 1.5 * body.self_contact)
        answers.add(gaps.min() / body.self_contact, 1.0, kind="least distance")
        weight = world.contact_points().force_on(body)[2]
        answers.add(weight / (0.5 * 9.81), 1.0, kind="weight")
    return answers.comparison()
