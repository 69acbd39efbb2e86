"""Claims that soft bodies tear where they are beyond their limits, that nothing is lost by it, and that gas leaks."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

import softbody
from softbody import Mesh, SoftBody, World
from softbody.bodies import tearing
from softbody.dynamics import pressure, watch
from softbody.mesh import tearing as fans
from softbody.stepping import tears
from validation.answers import Answers
from validation.cases import edge_lengths, random_mesh, rotated
from validation.check import Comparison, Run, check
from validation.checks.worlds.cases import WEIGHTLESS
from validation.checks.worlds.cutting import beside, pulls_at, told, whole
from validation.fault import Fault

FAMILY = "bodies that tear"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

STILL = 1e-20  # [s], a step in which nothing moves
WIDE = 0.5  # of its own area: a skin with larger holes holds no gas, so it is documented

check_tear = partial(check, section="beyond the paper", piece="softbody.World.add_soft_body")

SKINS: tuple[Callable[[np.random.Generator], Mesh], ...] = (
    lambda rng: softbody.icosphere(int(rng.integers(1, 3))),
    lambda rng: softbody.torus(1.0, rng.uniform(0.3, 0.5), 2 * int(rng.integers(4, 9)), int(rng.integers(4, 9))),
    lambda rng: softbody.box(rng.uniform(0.5, 1.5, 3), int(rng.integers(1, 4))),
    lambda rng: softbody.tetrahedron(),
    lambda rng: softbody.octahedron(),
    lambda rng: random_mesh("box", rng),
)


def stretched(rng: np.random.Generator, case: int, gas: float = 0.0, **options: Any) -> SoftBody:
    """Return a body "it" that is drawn out anyhow, with unequal springs, alone or beside another, weightless."""
    mesh, world = rotated(SKINS[case % len(SKINS)](rng), rng), World(WEIGHTLESS)
    if case // len(SKINS) % 2:
        world.add_soft_body(softbody.icosphere(1, 0.1), 1.0, 100.0, 1.0, (99.0, 0.0, 0.0))
    count = len(mesh.edges)
    options = {"tear_at": rng.uniform(1.05, 1.3, count), **options}
    stiffness, place = rng.uniform(50.0, 200.0, count), rng.uniform(1.0, 5.0, 3)
    body = world.add_soft_body(mesh, rng.uniform(0.5, 2.0), stiffness, gas, place, name="it", **options)
    draw(rng, body, rng.uniform(0.8, 1.4, 3))
    body.velocities = rng.normal(size=body.positions.shape)
    return body


def draw(rng: np.random.Generator, body: SoftBody, by: Any) -> None:
    """Draw a body out about its centre, and move each particle by a twentieth of a spring."""
    centre, noise = body.centre, rng.normal(0.0, 0.05 * float(body.rest_length.mean()), body.positions.shape)
    body.positions = centre + (body.positions - centre) * by + noise


def pieces_of(world: World) -> tuple[SoftBody, ...]:
    """Return what was once the body "it"."""
    return tuple(body for body in world.soft_bodies if (body.name or "").startswith("it"))


def still(world: World) -> str:
    """Take a step in which nothing moves; return what is raised, by a damaged core, or nothing."""
    try:
        world.step(STILL)
    except Exception as error:  # of a damaged core
        return type(error).__name__
    return ""


def loads(body: SoftBody) -> np.ndarray:
    """Return the load (e,) of springs, 1 at their limit; 0 of those at whose ends no other triangles are."""
    about = np.bincount(body.triangles.ravel(), minlength=len(body.positions))
    sides = np.sort(body.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    at = [int((sides == edge).all(axis=1).sum()) for edge in body.edges]
    may_part = (about[body.edges] > np.array(at)[:, None]).any(axis=1)
    limit = np.where(body.tear_at > 0.0, body.tear_at, np.inf) * body.rest_length
    return np.where(may_part, edge_lengths(body.positions, body.edges) / limit, 0.0)


def border_of(triangles: np.ndarray) -> np.ndarray:
    """Return the sides (k, 2) that only one triangle has, as it runs along them."""
    sides = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    there = {*map(tuple, sides.tolist())}
    return np.array([side for side in sides.tolist() if (side[1], side[0]) not in there], int).reshape(-1, 2)


def loops_of(triangles: np.ndarray) -> list[np.ndarray]:
    """Return the borders of a surface, each as its sides (k, 2), one after the other."""
    after, loops = dict(border_of(triangles).tolist()), list[np.ndarray]()
    while after:
        here, loop = next(iter(after)), []
        while here in after:
            loop.append((here, after[here]))
            here = after.pop(here)
        loops.append(np.array(loop))
    return loops


def capped(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a surface closed by fans about the mean of each hole's corners, and the holes' area vectors (h, 3)."""
    areas = list[np.ndarray]()
    for loop in loops_of(triangles):
        middle = points[loop[:, 0]].mean(axis=0)
        areas.append(0.5 * np.cross(points[loop[:, 1]] - middle, points[loop[:, 0]] - middle).sum(axis=0))
        fan = np.column_stack([loop[:, ::-1], np.full(len(loop), len(points))])
        points, triangles = np.append(points, middle[None], axis=0), np.append(triangles, fan, axis=0)
    return points, triangles, np.reshape(areas, (-1, 3))


def room_of(body: SoftBody) -> tuple[float, np.ndarray]:
    """Return the volume [m³] that a skin encloses with caps, 0 if it holds no gas, and its holes' areas (h, 3)."""
    from references import trimesh

    points, triangles, areas = capped(body.positions, body.triangles)
    volume = trimesh.volume(points, triangles)
    is_wide = np.linalg.norm(areas, axis=1).sum() >= WIDE * trimesh.area(body.positions, body.triangles)
    return (0.0 if is_wide or volume <= 0.0 else volume), areas


SURFACE = (
    "each side is run along once each way",
    "no side has three triangles",
    "borders are simple loops",
    "one fan at each vertex",
    "in one piece",
    "turned one way",
    "χ",
    "handles",
)


def surface_of(body: SoftBody) -> tuple[list[bool], int]:
    """Tell of a piece what is in SURFACE, and how many handles it has once its holes are closed."""
    from references import igl, scipy, trimesh

    triangles, count = body.triangles.copy(), len(body.positions)
    directed = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    sides, times = np.unique(np.sort(directed, axis=1), axis=0, return_counts=True)
    rim = sides[times == 1]
    at_rim = np.bincount(rim.ravel(), minlength=count)
    _, turned, _ = trimesh.topology(body.positions, triangles)
    own = len(body.positions) - len(body.edges) + len(triangles)
    euler = len(np.unique(triangles)) - len(sides) + len(triangles)
    among = scipy.connected(count, rim.tolist()) if len(rim) else np.arange(count)
    holes = len(np.unique(among[np.unique(rim)]))
    handles, odd = divmod(2 - euler - holes, 2)
    return [
        len(np.unique(directed, axis=0)) == len(directed),
        bool((times < 3).all()),
        bool(np.isin(at_rim, (0, 2)).all()),
        not igl.is_pinched(triangles).any(),
        len(np.unique(igl.shells(triangles))) == 1,
        bool(turned),
        own == euler,
        not odd and handles >= 0,
    ], handles


def facets(bodies: tuple[SoftBody, ...]) -> list[bytes]:
    """Return the places of the corners of all triangles, in no order."""
    return sorted(corners.tobytes() for each in bodies for corners in each.positions[each.triangles])


@check_tear(
    reference="fans by libigl, orientation by trimesh, borders by SciPy's graphs, the same triangles before",
    engines=("igl", "trimesh", "scipy"),
    kind="third-party engine",
    faults=(
        Fault("fans that hang together at one side alone", fans._parted, "np.concatenate([a_, b_]) → a_"),
        Fault("parts that stay one body", tearing._pieces, "joined(len(origin), a_) → np.zeros(len(origin), np.int64)"),
        Fault("new vertices that are one", fans._parted, "count + np.arange(len(more)) → count + 0 * more"),
        Fault("skins that never tear", fans.most_loaded, "load > 1.0 → load > 1e300"),
    ),
)
def pieces_are_surfaces(run: Run) -> Comparison:
    """What tears, again and again, is in sound pieces.

    Bodies of every kind that are drawn out anyhow, with limits at random, for some rounds: each piece is one surface,
    with one fan of triangles at each vertex and borders that are simple loops; triangles are those of before, and all
    pieces have no more handles than the body had. Where a spring is beyond its limit, something tears.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(24, 60, 600)):
        body = stretched(rng, case)
        world, kind = body.world, "whole" if case % 2 else "drawn"
        most = surface_of(body)[1]
        for _ in range(5):
            before, pieces = facets(pieces_of(world)), pieces_of(world)
            beyond, seen = any((loads(each) > 1.0).any() for each in pieces), len(world.events)
            error = still(world)
            answers.add(error, "", kind="goes on") if error else None
            if error:
                break
            found = [surface_of(each) for each in pieces_of(world)]
            for row, _ in found:
                answers.extend(np.array(row), np.ones(len(SURFACE), bool), kind=SURFACE)
            answers.add(facets(pieces_of(world)) == before, True, kind="the same triangles")
            answers.add(sum(handles for _, handles in found) <= most, True, kind="handles in all")
            answers.add((len(world.events) > seen) == beyond, True, kind="tears if beyond its limits")
            for each in pieces_of(world):
                each.set_springs(tear_at=rng.uniform(1.05, 1.6, len(each.edges)))
                draw(rng, each, rng.uniform(1.0, 1.1, 3))
    return answers.comparison()


@check_tear(
    reference="the same before: sums over particles and springs by NumPy, areas and volumes by trimesh",
    engines=("trimesh",),
    kind="invariant",
    unit="of the largest of the three, or 1",
    tolerance=1e-13,
    because="rounding of sums over some hundred particles",
    faults=(
        Fault("copies of all the mass", tearing._masses, "a_ / b_ * before[origin] → before[origin]"),
        Fault("mass by halves", tearing._masses, "np.repeat(stiffness, 2) → np.repeat(0.0 * stiffness + 1.0, 2)"),
        Fault("springs on both sides of all their stiffness", tearing._stiffness, "a_ / at_before * b_ → b_"),
        Fault("slower pieces", tearing._pieces, "before.velocity[old] → 0.9 * before.velocity[old]"),
        Fault("gas in each piece", tearing._pieces, "volume / room if room > 0.0 else 0.0 → 1.0"),
        Fault("gas where there are no vessels", tearing._room, "volume if holds_gas(a_, b_, c_) else 0.0 → volume"),
        Fault("forces on all copies", tearing._pieces, "force[origin] * a_ → force[origin]"),
        Fault("springs at rest", tearing._springs, "own.model['edge_rest_length'][row] → length"),
    ),
)
def nothing_is_lost(run: Run) -> Comparison:
    """A body that tears loses nothing.

    Bodies of every kind, drawn out anyhow, that shake, with unequal springs, gas and forces: mass and its centre, both
    momenta, energy of springs and of motion, area, forces and torques, and what pulls at each place. What a particle
    became shares its mass by the stiffness about it. Gas is shared by the room in each piece, and gone where none is.
    """
    from references import trimesh

    rng, answers = run.fresh_rng(), Answers()

    def more(bodies: tuple[SoftBody, ...]) -> np.ndarray:
        motion = sum(0.5 * float(each.masses @ np.square(each.velocities).sum(axis=1)) for each in bodies)
        return np.array([motion, sum(trimesh.area(each.positions, each.triangles) for each in bodies), 0.0])

    for case in range(run.count(18, 60, 600)):
        body = stretched(rng, case, rng.uniform(1.0, 5.0))
        body.external_force = rng.normal(size=body.positions.shape)
        world, points, mass = body.world, body.positions.copy(), body.masses.copy()
        for turn in range(3):
            bodies = pieces_of(world)
            before, moving, seen = whole(bodies), more(bodies), len(world.events)
            gases = {each: each.gas for each in bodies}
            pulls, _ = pulls_at(bodies, points)
            if error := still(world):
                answers.add([0.0] * 3, [1.0] * 3, kind=error)
                break
            bodies = pieces_of(world)
            after, rows = whole(bodies), before.rows()
            rows["mass, springs' energy, gas"][2] = after.gas
            for what, row in rows.items():
                answers.add(after.rows()[what], row, float(np.abs(row).max(initial=1.0)), what)
            answers.add(more(bodies), moving, float(np.abs(moving).max(initial=1.0)), "motion, area")
            here, elsewhere = pulls_at(bodies, points)
            scale = 100.0 * float(bodies[0].rest_length.mean())
            answers.extend(here, pulls, scale, "pulls")
            answers.add([float(len(elsewhere)), 0.0, 0.0], [0.0] * 3, kind="pulls elsewhere")
            if not turn:
                stiff = [
                    np.bincount(each.edges.ravel(), np.repeat(each.stiffness, 2), len(each.masses)) for each in bodies
                ]
                there, weights = np.concatenate([each.positions for each in bodies]), np.concatenate(stiff)
                places, at = np.unique(np.concatenate([points, there]), axis=0, return_inverse=True)
                at, copy = at.ravel()[: len(points)], at.ravel()[len(points) :]
                whose = np.zeros(len(places))
                whose[at] = mass
                shares = whose[copy] * weights / np.bincount(copy, weights)[copy]
                masses = np.concatenate([each.masses for each in bodies])
                none = np.zeros((len(masses), 2))
                answers.extend(np.column_stack([masses, none]), np.column_stack([shares, none]), 1.0, "masses")
            for event in world.events[seen:]:
                rooms = np.array([room_of(each)[0] for each in event.bodies])
                share = rooms / rooms.sum() if rooms.sum() > 0.0 else rooms
                own = np.array([[each.gas, 0.0, 0.0] for each in event.bodies])
                if not turn:  # what has torn before leaks
                    told_gas = np.zeros(own.shape)
                    told_gas[:, 0] = share * gases[event.bodies[0]]
                    answers.extend(own, told_gas, 5.0, "gas")
            for each in bodies:
                each.set_springs(tear_at=rng.uniform(1.05, 1.6, len(each.edges)))
    return answers.comparison()


EDGE = 1e-9  # how near to a limit bodies are put


@check_tear(
    reference="lengths by NumPy beside the limits that were given",
    kind="specification",
    faults=(
        Fault(
            "limits seen a little later",
            tears.tearing_of,
            "np.square(model.edge_tear_at * a_) → np.square((1.0 + 1e-8) * model.edge_tear_at * a_)",
        ),
        Fault("limits that tear a little later", fans.most_loaded, "load > 1.0 → load > 1.0 + 1e-8"),
        Fault("a spring that is not seen", tears._may_part, "(a_ > b_).any(axis=1) → (a_ > b_).all(axis=1)"),
        Fault("a body alone that never tears", watch.is_beyond, "least_lane(least) < 0.0 → False"),
        Fault("a body in company that never tears", tears.leak_and_look, "least < 0.0 → False"),
    ),
)
def tears_beyond_its_limit(run: Run) -> Comparison:
    """A body tears where a spring is beyond its limit.

    Bodies of every kind, alone or in company, whole or torn already, are drawn out until the spring that is nearest to
    its limit is 1e-9 of it below, or above: so they tear or do not, and at an end of that spring.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(36, 120, 1200)):
        body = stretched(rng, case)
        world, turn = body.world, case // 12 % 2
        if turn:
            error = still(world)
            for each in pieces_of(world):
                each.set_springs(tear_at=0.0)
            if error or not body.is_torn or not (loads_at(rng, body) > 0.0).any():
                answers.add([not error, True], [True, True], kind=error or "too small")
                continue
        for side in (-EDGE, EDGE):
            load, centre = loads(body), body.centre
            body.positions = centre + (body.positions - centre) * ((1.0 + side) / load.max())
            ends = body.positions[body.edges[int(np.argmax(load))]].copy()
            seen = len(world.events)
            error = still(world)
            events = world.events[seen:]
            at_it = all((np.abs(each.places[:, None] - ends).sum(axis=2) < 1e-9).any() for each in events)
            company = "alone" if len(world.soft_bodies) < 2 else "in company"
            kind = f"{company}, {'torn' if turn else 'whole'}, {'above' if side > 0.0 else 'below'}"
            answers.add([len(events) == (side > 0.0), at_it and not error], [True, True], kind=kind)
    return answers.comparison()


def loads_at(rng: np.random.Generator, body: SoftBody) -> np.ndarray:
    """Give a body other limits, and return the loads (e,) of its springs."""
    body.set_springs(tear_at=rng.uniform(1.05, 1.3, len(body.edges)))
    return loads(body)


@check_tear(
    reference="nRT = k Σ l0² (s² − s) / 3 for a regular solid that is stretched to s",
    kind="closed form",
    faults=(
        Fault("limits beyond their own", fans.most_loaded, "load > 1.0 → load > 1.0 + 1e-8"),
        Fault("gas that presses less", pressure.gas_pressure, "gas / volume → 0.999999 * gas / volume"),
        Fault(
            "springs that are longer",
            tearing._torn,
            "model['edge_tear_at'] * rest → model['edge_tear_at'] * rest * (1.0 + 1e-8)",
        ),
        Fault(
            "limits of other springs",
            tears.tearing_of,
            "np.square(a_)[padded] → np.square(np.sqrt(1.0 + 1e-8) * a_)[padded]",
        ),
    ),
)
def regular_solids_burst(run: Run) -> Comparison:
    """Regular solids burst at the gas of the closed form.

    Tetrahedra, octahedra and icosahedra in equilibrium with gas that stretches them to 1e-9 below their limit, or above
    it: for 100 steps they stay as they are, or tear in the first.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(6, 30, 300)):
        solid = (softbody.tetrahedron, softbody.octahedron, softbody.icosahedron)[case % 3]
        mesh = rotated(solid(rng.uniform(0.3, 2.0)), rng)
        stiffness, limit = rng.uniform(50.0, 500.0), rng.uniform(1.1, 2.0)
        room = float(np.square(edge_lengths(mesh.vertices, mesh.edges)).sum())
        for side in (-EDGE, EDGE):
            stretch = limit * (1.0 + side)
            world = World(WEIGHTLESS)
            gas = stiffness * room * (stretch**2 - stretch) / 3.0
            body = world.add_soft_body(mesh, 1.0, stiffness, gas, tear_at=limit)
            body.positions = stretch * body.positions
            try:
                world.step(0.2 * world.stable_time_step(), 1 if side > 0.0 else 100)
            except Exception as error:  # of a damaged core
                answers.add([False, True], [True, True], kind=type(error).__name__)
                continue
            kind = f"{solid.__name__}, {'above' if side > 0.0 else 'below'}"
            is_there = float(np.abs(body.positions[0] - stretch * mesh.vertices[0]).max()) < 1e-6 or side > 0.0
            answers.add([len(world.events) == (side > 0.0), is_there], [True, True], kind=kind)
    return answers.comparison()


def of_places(points: np.ndarray, edges: np.ndarray, wave: np.ndarray) -> np.ndarray:
    """Return numbers (e,) from −1 to 1 that depend on where the middles of edges are alone."""
    return np.asarray(np.sin(np.cumsum((points[edges[:, 0]] + points[edges[:, 1]]) * wave, axis=1)[:, 2]))


@check_tear(
    reference="mirror images; the same bodies, with vertices and triangles numbered otherwise",
    kind="invariant",
    engines=("scipy",),
    unit="m, m/s, kg, J, at bodies of one of each",
    tolerance=1e-11,
    because="rounding of waves that tell limits",
    faults=(
        Fault("the first of two ends", fans._ends_that_split, "pull[v] >= a_ → v == ends[0]"),
        Fault("a split by numbers", fans._across, "way > a_ → (way > a_) & (ahead > back)"),
        Fault("ties by rounding", fans.most_loaded, "(1.0 - TIED) * a_ → (1.0 + 1e-15 * edges[:, 0]) * a_"),
        Fault(
            "masses by numbers", tearing._masses, "a_ / b_ * c_ → a_ / b_ * c_ * (1.0 + 1e-6 * np.arange(len(origin)))"
        ),
    ),
)
def symmetric(run: Run) -> Comparison:
    """What is symmetric tears into mirror images.

    Bodies of every kind, drawn out some rounds: those that are mirrored tear so, and those that are numbered otherwise
    tear at the same places. Balls with limits that are as symmetric, so that many tie, are their own images.
    """
    rng, answers = run.fresh_rng(), Answers()

    def after(mesh: Mesh, wave: np.ndarray, mirror: np.ndarray, by: np.ndarray) -> list[np.ndarray]:
        """Return what is told of all pieces, round by round."""
        world, number = World(WEIGHTLESS), of_places(mesh.vertices * mirror, mesh.edges, wave)
        body = world.add_soft_body(mesh, 1.0, 100.0 + 20.0 * number, 1.0, tear_at=1.2 + 0.1 * number)
        body.positions = body.positions * by
        body.velocities = body.positions * (1.0, 2.0, 3.0)
        found = list[np.ndarray]()
        for _ in range(4):
            if still(world):
                return found
            found.append(told(world.soft_bodies) * np.concatenate([mirror, mirror, [1.0, 1.0]]))
            for each in world.soft_bodies:
                each.positions = each.positions * 1.05
        return found

    def compare(one: list[np.ndarray], other: list[np.ndarray], kind: str) -> None:
        if not one or len(one) != len(other):
            answers.add([0.0] * 8, [1.0] * 8, kind="no step")
        for first, second in zip(one, other):
            answers.extend(first, beside(first, second), 1.0, kind)

    ones, mirror = np.ones(3), np.array([-1.0, 1.0, 1.0])
    for case in range(run.count(12, 36, 300)):
        mesh = rotated(SKINS[case % len(SKINS)](rng), rng)
        mesh = Mesh(mesh.vertices + rng.normal(0.0, 0.02, mesh.vertices.shape), mesh.triangles)
        wave, by = rng.uniform(5.0, 50.0, 3), rng.uniform(0.9, 1.4, 3)
        number, order = rng.permutation(len(mesh.vertices)), rng.permutation(len(mesh.triangles))
        shuffled = np.empty(mesh.vertices.shape)
        shuffled[number] = mesh.vertices
        renumbered = Mesh(shuffled, np.roll(number[mesh.triangles[order]], 1, axis=1))
        mirrored = Mesh(mesh.vertices * mirror, mesh.triangles[:, ::-1])
        first = after(mesh, wave, ones, by)
        compare(first, after(renumbered, wave, ones, by), "renumbered")
        compare(first, after(mirrored, wave, mirror, by), "mirrored")
    for case in range(run.count(3, 9, 60)):
        world, mesh, axis = World(WEIGHTLESS), softbody.icosphere(1 + case % 2), np.ones(8)
        limit = 1.2 + 0.1 * np.cos(np.abs(mesh.vertices[mesh.edges].sum(axis=1)) @ rng.uniform(1.0, 4.0, 3))
        body = world.add_soft_body(mesh, 1.0, 100.0, 1.0, tear_at=limit)
        body.positions = body.positions * rng.uniform(1.0, 1.5, 3)
        axis[[case % 3, 3 + case % 3]] = -1.0
        if error := still(world):
            answers.add([0.0] * 8, [1.0] * 8, kind=error)
            continue
        rows = told(world.soft_bodies)
        answers.extend(rows, beside(rows, rows * axis), 1.0, "its own image")
    return answers.comparison()


def copies_after(body: SoftBody) -> np.ndarray:
    """Return how many particles (n,) each becomes by the rules that are documented, by SciPy's graphs.

    Springs beyond their limit tear that none at their ends exceeds, each at its end on the border; of two such, or
    none, where there is more pull. Triangles there stay together that are on the spring's side, and so do others.
    """
    from references import scipy

    points, triangles, load = body.positions, body.triangles.tolist(), loads(body)
    length = edge_lengths(points, body.edges)
    pull = np.zeros(len(points))
    np.add.at(pull, body.edges, (body.stiffness * np.maximum(length - body.rest_length, 0.0))[:, None])
    about, sides = defaultdict(list), defaultdict(list)
    for t, corners in enumerate(triangles):
        for k in range(3):
            about[corners[k]].append(t)
            sides[frozenset((corners[k], corners[k - 1]))].append(t)
    rim = {v for side, at in sides.items() if len(at) == 1 for v in side}
    parted = set()
    for e, (a, b) in enumerate(body.edges.tolist()):
        beside_it = np.isin(body.edges, (a, b)).any(axis=1)
        if load[e] <= 1.0 or (load[beside_it] > load[e]).any():
            continue
        ends = [v for v in (a, b) if len(about[v]) > len(sides[frozenset((a, b))])]
        if len(ends) == 2 and ((a in rim) != (b in rim)):
            ends = [v for v in ends if v in rim]
        vertex = ends[0] if len(ends) == 1 else ends[int(pull[ends[1]] > pull[ends[0]])]
        other = a + b - vertex
        along = points[other] - points[vertex]
        way = {t: float((points[triangles[t]].sum(axis=0) - 3.0 * points[vertex]) @ along) for t in about[vertex]}
        near = {t for t, ahead in way.items() if ahead > 0.0 or other in triangles[t]}
        if len(near) == len(way):
            near = {t for t in near if other in triangles[t]}
        parted |= {
            side for side, at in sides.items() if vertex in side and len(at) == 2 and (at[0] in near) != (at[1] in near)
        }
    links = [
        (3 * one + triangles[one].index(v), 3 * other + triangles[other].index(v))
        for side, at in sides.items()
        if len(at) == 2 and side not in parted
        for one, other in [at]
        for v in side
    ]
    part = scipy.connected(3 * len(triangles), links)
    corners = body.triangles.ravel()
    return np.array([len(np.unique(part[corners == v])) for v in range(len(points))])


@check_tear(
    reference="the documented rules, by loops over vertices and SciPy's graphs",
    engines=("scipy",),
    kind="specification",
    faults=(
        Fault("a fan that falls apart", fans._across, "np.intersect1d(near_edges, a_) → near_edges"),
        Fault("a spring that is torn off", fans._across, "of_edge | a_ → of_edge"),
        Fault("tears that begin anew", fans._ends_that_split, "[v for v in ends if on_border[v]] → ends"),
        Fault("tears where less pulls", fans._ends_that_split, "pull[v] >= a_ → pull[v] <= pull[ends].min()"),
        Fault("all springs beyond tear", fans.most_loaded, "(load > 1.0) & a_ → load > 1.0"),
        Fault("a pull of all springs", tearing._torn, "np.maximum(length - rest, 0.0) → length"),
    ),
)
def tears_where_it_says(run: Run) -> Comparison:
    """A body tears at its weakest places.

    Bodies of every kind that are bent, all springs as much stretched: limits that differ by 1e-6 or by much, and then
    once more where they have torn. As many particles are at each place as the rules say.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(30, 90, 900)):
        mesh, world, stretch = rotated(SKINS[case % len(SKINS)](rng), rng), World(WEIGHTLESS), 1.3
        points = mesh.vertices * rng.uniform(0.8, 1.2, 3) + rng.normal(0.0, 0.02, mesh.vertices.shape)
        mesh = Mesh(points, mesh.triangles)
        length = edge_lengths(mesh.vertices, mesh.edges)
        stiffness = rng.uniform(50.0, 200.0, len(length))
        world.add_soft_body(mesh, 1.0, stiffness, 0.0, rest_length=length / stretch, name="it")
        kinds = ("one spring", "one spring") if case % 2 else ("many", "many")
        for turn, kind in enumerate(kinds):
            body = world["it"]
            assert isinstance(body, SoftBody)
            count = len(body.edges)
            if kind == "many":
                limit = rng.uniform(1.1, 1.4, count)
            else:
                limit = np.full(count, stretch * (1.0 + 1e-6))
                limit[int(rng.integers(count))] = stretch * (1.0 - 1e-6)
            body.set_springs(tear_at=limit)
            for each in pieces_of(world)[1:]:
                each.set_springs(tear_at=0.0)
            before, expected = body.positions.copy(), copies_after(body)
            error = still(world)
            seen = {
                place.tobytes(): 0 for place in before
            }  # what has torn before lies at the same places: count what was this body
            bodies = world.events[-1].bodies if world.events and world.events[-1].bodies[0] == body else (body,)
            for each in bodies:
                for place in each.positions:
                    seen[place.tobytes()] = seen.get(place.tobytes(), 0) + 1
            twice = {place.tobytes(): 0 for place in before}
            for place, copies in zip(before, expected):
                twice[place.tobytes()] += int(copies)
            kind = f"{kind}, {'torn' if turn else 'whole'}"
            answers.add([seen == twice, not error], [True, True], kind=kind, number=case)
            if error:
                break
    return answers.comparison()
