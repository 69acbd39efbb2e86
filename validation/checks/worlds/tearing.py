"""Claims that soft bodies tear where they are beyond their limits, that nothing is lost by it, and that gas leaks."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import softbody
from softbody import Mesh, SoftBody, World
from softbody.bodies import soft_rows, tearing
from softbody.collision.soft import soft_contacts
from softbody.dynamics import one_ring_forces, pressure, vertex_rings, watch
from softbody.geometry import borders
from softbody.mesh import tearing as fans
from softbody.stepping import checks, runner, tears
from validation.answers import Answers
from validation.cases import edge_lengths, random_mesh, rotated
from validation.check import Comparison, Run, check
from validation.checks.worlds.cases import NEVER_ACT, WEIGHTLESS
from validation.checks.worlds.cutting import beside, pulls_at, refusal, told, whole
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
    stiffness, place = rng.uniform(50.0, 200.0, count), rng.uniform(6.0, 9.0, 3)
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


def still(world: World, steps: int = 1) -> str:
    """Take a step or more in which nothing moves; return what is raised, by a damaged core, or nothing."""
    try:
        world.step(STILL, steps)
    except Exception as error:  # of a damaged core
        return type(error).__name__
    return ""


def loads(body: SoftBody) -> np.ndarray:
    """Return the load (e,) of springs, 1 at their limit; 0 of those at whose ends no other triangles are."""
    about = np.bincount(body.triangles.ravel(), minlength=len(body.positions))
    sides = body.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    _, which, times = np.unique(
        np.sort(np.concatenate([body.edges, sides]), axis=1), axis=0, return_inverse=True, return_counts=True
    )
    at = times[which.ravel()[: len(body.edges)]] - 1
    may_part = (about[body.edges] > at[:, None]).any(axis=1)
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
        Fault(
            "pieces that are turned",
            tearing._pieces,
            "number[triangles[x_]] → number[triangles[x_]][:, ::-1]",
        ),
        Fault("pieces that are lost", tearing._pieces, "np.unique(part).tolist() → np.unique(part).tolist()[:1]"),
        Fault("parts that stay one body", tearing._pieces, "joined(len(origin), a_) → np.zeros(len(origin), np.int64)"),
        Fault("springs in the way that cannot part", tearing._torn, "np.where(parts, load, 0.0) → load"),
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
    for case in range(run.count(40, 120, 1200)):
        body = stretched(rng, case if case < 12 else 3 + case % 2)
        world, most = body.world, surface_of(body)[1]
        for _ in range(4 if case < 12 else 6):
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
    tolerance=2e-14,
    because="rounding of sums over some hundred particles: 3e-15 at worst of ten seeds",
    faults=(
        Fault("copies of all the mass", tearing._masses, "a_ / b_ * before[origin] → before[origin]"),
        Fault("mass by halves", tearing._masses, "np.repeat(stiffness, 2) → np.repeat(0.0 * stiffness + 1.0, 2)"),
        Fault("a slit with all its stiffness on both sides", tearing._springs, "share * x_ → x_"),
        Fault("slower pieces", tearing._pieces, "before.velocity[old] → 0.9 * before.velocity[old]"),
        Fault("gas in each piece", tearing._pieces, "volume / room if room > 0.0 else 0.0 → 1.0"),
        Fault("gas where there are no vessels", tearing._room, "volume if holds_gas(a_, b_, c_) else 0.0 → volume"),
        Fault("forces on all copies", tearing._pieces, "force[origin] * a_ → force[origin]"),
        Fault(
            "springs that are longer",
            tearing._springs,
            "own.model['edge_rest_length'][row] → 1.000001 * own.model['edge_rest_length'][row]",
        ),
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
        Fault("a spring that is not seen", fans.may_part, "a_ | b_ → a_ & b_"),
        Fault("a body alone that never tears", watch.room_of_springs, "least_lane(least) < 0.0 → False"),
        Fault("a body in company that never tears", tears.leak_and_look, "least < 0.0 → False"),
    ),
)
def tears_beyond_its_limit(run: Run) -> Comparison:
    """A body tears where a spring is beyond its limit.

    Bodies of every kind, alone or in company, whole or torn already, are drawn out until the spring that is nearest to
    its limit is 1e-9 of it below, or above: so they tear or do not, in the first of three
    steps and at an end of that spring.
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
            seen, start = len(world.events), world.time
            error = still(world, 3)
            events = world.events[seen:]
            at_it = all((np.abs(each.places[:, None] - ends).sum(axis=2) < 1e-9).any() for each in events[:1])
            at_once = all(0.5 * STILL < each.time - start < 1.5 * STILL for each in events[:1])
            company = "alone" if len(world.soft_bodies) < 2 else "in company"
            kind = f"{company}, {'torn' if turn else 'whole'}, {'above' if side > 0.0 else 'below'}"
            answers.add([bool(events) == (side > 0.0), at_it and at_once and not error], [True, True], kind=kind)
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
            "limits that are longer",
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
    tolerance=3e-15,
    because="rounding of centres and masses of bodies of 1: 3.3e-16 at worst of ten seeds",
    faults=(
        Fault("the first of two ends", fans._ends_that_split, "pull[v] >= a_ → v == ends[0]"),
        Fault("a split by numbers", fans._across, "way > a_ → (way > a_) & (ahead > back)"),
        Fault("ties by rounding", fans.most_loaded, "(1.0 - TIED) * a_ → (1.0 + 1e-15 * edges[:, 0]) * a_"),
        Fault(
            "equal masses of all copies",
            tearing._masses,
            "a_ / b_ * c_ → a_ / b_ * c_ * (1.0 + 1e-6 * np.arange(len(origin)))",
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
    none, where there is more pull, or at both of equal ones. Triangles there stay together that are on the
    spring's side, and so do others.
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
        for vertex in (v for v in ends if pull[v] >= (1.0 - 1e-9) * pull[ends].max()):
            other = a + b - vertex
            along = points[other] - points[vertex]
            way = {t: float((points[triangles[t]].sum(axis=0) - 3.0 * points[vertex]) @ along) for t in about[vertex]}
            near = {t for t, ahead in way.items() if ahead > 0.0 or other in triangles[t]}
            if len(near) == len(way):
                near = {t for t in near if other in triangles[t]}
            parted |= {
                side
                for side, at in sides.items()
                if vertex in side and len(at) == 2 and (at[0] in near) != (at[1] in near)
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
        Fault("all springs beyond tear", fans.most_loaded, "load[beyond] >= a_ → load[beyond] > 0.0"),
        Fault("a pull of all springs", tearing._torn, "np.maximum(length - rest, 0.0) → length"),
    ),
)
def tears_where_it_says(run: Run) -> Comparison:
    """A body tears at its weakest places.

    Bodies of every kind that are bent, all springs drawn otherwise: one that is 1e-6 beyond its limit while others are
    below, or many that are beyond; and then once more what has torn. As many particles are at
    each place as the rules say.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(30, 90, 900)):
        mesh, world = rotated(SKINS[case % len(SKINS)](rng), rng), World(WEIGHTLESS)
        points = mesh.vertices * rng.uniform(0.8, 1.2, 3) + rng.normal(0.0, 0.02, mesh.vertices.shape)
        mesh = Mesh(points, mesh.triangles)
        length = edge_lengths(mesh.vertices, mesh.edges)
        stiffness, drawn = rng.uniform(50.0, 200.0, len(length)), rng.uniform(0.8, 1.6, len(length))
        world.add_soft_body(mesh, 1.0, stiffness, 0.0, rest_length=length / drawn, name="it")
        kinds = ("one spring", "one spring") if case % 2 else ("many", "many")
        for turn, kind in enumerate(kinds):
            body = world["it"]
            assert isinstance(body, SoftBody)
            count = len(body.edges)
            stretch = edge_lengths(body.positions, body.edges) / body.rest_length
            if kind == "many":
                limit = rng.uniform(1.1, 1.4, count)
            else:
                limit = np.maximum(1.01, stretch * (1.0 + 1e-6))
                weak = int(rng.choice(np.flatnonzero(stretch > 1.01)))
                limit[weak] = stretch[weak] * (1.0 - 1e-6)
            body.set_springs(tear_at=limit)
            for each in pieces_of(world)[1:]:
                each.set_springs(tear_at=0.0)
            before, expected = body.positions.copy(), copies_after(body)
            earlier = len(world.events)
            error = still(world)
            seen = {
                place.tobytes(): 0 for place in before
            }  # what has torn before lies at the same places: count what was this body
            bodies = next((each.bodies for each in world.events[earlier:] if each.bodies[0] == body), (body,))
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


HOLED = (0, 1, 2)  # of SKINS: fine enough that a hole is small


def vessel(rng: np.random.Generator, case: int) -> SoftBody | None:
    """Return what has torn at a few springs and holds gas, alone in a weightless world; None of a damaged core."""
    for _ in range(30):
        body = stretched(rng, HOLED[case % len(HOLED)], tear_at=0.0)
        world, count = body.world, int(rng.integers(1, 4))
        limit = np.zeros(len(body.edges))
        some = rng.choice(len(limit), count, replace=False)
        stretch = edge_lengths(body.positions, body.edges) / body.rest_length
        limit[some] = np.where(stretch[some] > 1.02, 0.99 * stretch[some], 0.0)
        body.set_springs(tear_at=limit)
        if still(world):
            return None
        for each in pieces_of(world)[1:]:
            world.remove(each)
        body.set_springs(tear_at=0.0)
        for _ in range(4):  # so that holes open
            draw(rng, body, 1.0)
        body.gas = rng.uniform(5.0, 20.0)
        if body.is_torn and room_of(body)[0] > 0.0:
            return body
    return None


@check_tear(
    reference="dn/dt = −C A n / V, of skins that are closed by fans, their volume and area by trimesh",
    engines=("trimesh",),
    kind="closed form",
    unit="of the gas",
    tolerance=1e-15,
    because="a step leaks little, so that rounding of volumes counts little: 1.7e-16 at worst of ten seeds",
    faults=(
        Fault("one hole of several", tears._leak, "open_area += x_ → open_area = x_"),
        Fault("a leak by one step of Euler", tears._leak, "exp(x_) → 1.0 + x_"),
        Fault("skins that hold gas however wide they are", borders.holds_gas, "open_area < x_ → True"),
        Fault(
            "fans about a corner", borders.hole, "scale(1.0 / (end - first), middle) → _place(points, border[first])"
        ),
        Fault("a leak of the volume without fans", pressure.soft_volume, "volume += x_ → volume += 0.0 * x_"),
        Fault("a leak that all bodies have", tears._leak, "model.soft_leak[body] → 200.0"),
    ),
)
def gas_leaks(run: Run) -> Comparison:
    """Gas leaks out of a torn body by its holes.

    Bodies that have torn at some springs, and shake, step by step, by leaks of all speeds and of none; what is torn so
    wide that its holes are half of its area, or that has no room, has no gas at once.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(12, 40, 400)):
        body = vessel(rng, case)
        if body is None:
            answers.add(0.0, 1.0, kind="whole")
            continue
        body.leak = 0.0 if case % 4 == 3 else rng.uniform(10.0, 500.0)
        for _ in range(8):
            gas, h = body.gas, rng.uniform(1e-4, 3e-4)
            try:
                body.world.step(h, allow_unstable=True)
            except Exception as error:  # of a damaged core
                answers.add(0.0, 1.0, kind=type(error).__name__)
                break
            room, areas = room_of(body)
            rate = body.leak * np.linalg.norm(areas, axis=1).sum() * h / room if room > 0.0 else np.inf
            answers.add(body.gas, gas * np.exp(-rate), gas, "tight" if body.leak == 0.0 else "leaks")
    for case in range(run.count(12, 40, 400)):
        body = stretched(rng, case)
        if still(body.world) or not body.is_torn:
            continue
        for each in pieces_of(body.world):
            each.set_springs(tear_at=0.0)
            each.gas, each.leak = 5.0, 0.0
            room = room_of(each)[0]
            still(each.world)
            answers.add(each.gas, 5.0 if room > 0.0 else 0.0, 5.0, "a vessel" if room > 0.0 else "wide")
    return answers.comparison()


@check_tear(
    reference="−P A h, of skins that are closed by fans, their volume by trimesh, holes' areas by NumPy",
    engines=("trimesh",),
    kind="closed form",
    unit="of the impulse",
    tolerance=3e-12,
    because="pressure on all triangles cancels, but for small holes: 5.8e-13 at worst of ten seeds",
    faults=(
        Fault("no volume in fans", one_ring_forces.volume_of_holes, "volume_of_fan(a_, b_, c_) → 0.0"),
        Fault("fans in one direction", borders.hole, "cross(here, before) → cross(before, here)"),
        Fault(
            "rings that close across a hole",
            vertex_rings.one_rings,
            "ring[x_] = after[x_] = before[i] → ring[x_] = before[i]; after[x_] = ring[start[i]]",
        ),
        Fault("gas that presses less", pressure.gas_pressure, "gas / volume → 0.999999 * gas / volume"),
    ),
)
def gas_drives_it_away(run: Run) -> Comparison:
    """Gas that flows out drives a body the other way.

    Bodies that have torn at some springs, free and weightless, at rest as they are: the momentum that each gains in a
    step is that of the pressure on what was there, before it moved.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(12, 40, 400)):
        body = vessel(rng, case)
        if body is None:
            answers.add([0.0] * 3, [1.0] * 3, kind="whole")
            continue
        for _ in range(4):
            body.velocities, h = np.zeros(body.positions.shape), rng.uniform(1e-4, 3e-4)
            draw(rng, body, 1.0)
            body.set_springs(rest_length=edge_lengths(body.positions, body.edges))
            room, areas = room_of(body)
            if room <= 0.0:
                break
            expected = -h * body.gas / room * areas.sum(axis=0)
            try:
                body.world.step(h, allow_unstable=True)
            except Exception as error:  # of a damaged core
                answers.add([0.0] * 3, [1.0] * 3, kind=type(error).__name__)
                break
            gained, kind = body.masses @ body.velocities, f"{len(areas)} holes"
            answers.add(gained, expected, h * body.pressure * float(np.linalg.norm(areas, axis=1).sum()), kind)
    return answers.comparison()


STEPS = 5000  # in the time in which gas fades by e


@check_tear(
    reference="n0 R T (1 − exp(−C A t / V)) / C M: volume of skins closed by fans by trimesh, holes' areas by NumPy",
    engines=("trimesh",),
    kind="closed form",
    unit="of the speed that one hole gives",
    tolerance=1.1e-4,
    because="a step presses by the gas before it leaks: that is h C A / 2 V = 1e-4 too much",
    faults=(
        Fault("gas that presses a thousandth less", pressure.gas_pressure, "gas / volume → 0.999 * gas / volume"),
        Fault("a leak that all bodies have", tears._leak, "model.soft_leak[body] → 200.0"),
        Fault("gas that leaks faster", tears._leak, "exp(x_) → exp(1.001 * x_)"),
        Fault("one hole of several", tears._leak, "open_area += x_ → open_area = x_"),
        Fault("fans in one direction", borders.hole, "cross(here, before) → cross(before, here)"),
    ),
)
def flies_as_a_rocket(run: Run) -> Comparison:
    """A torn free body flies as a rocket does.

    Bodies that have torn at some springs, at rest, weightless, with so little gas that none deforms: their velocity
    after half to three times the time in which gas fades by e. The mass of gas is none, so that the body's stays.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(9, 24, 200)):
        body = vessel(rng, case)
        if body is None:
            answers.add([0.0] * 3, [1.0] * 3, kind="whole")
            continue
        body.velocities = np.zeros(body.positions.shape)
        body.set_springs(stiffness=1e-5, rest_length=edge_lengths(body.positions, body.edges))
        body.gas, body.leak = 1e-9, rng.uniform(100.0, 400.0)
        room, areas = room_of(body)
        area, mass = float(np.linalg.norm(areas, axis=1).sum()), float(body.masses.sum())
        fading, times = room / (body.leak * area), rng.uniform(0.5, 3.0)
        speed = body.gas * (1.0 - np.exp(-times)) / (body.leak * mass)
        try:
            body.world.run(times * fading, time_step=fading / STEPS)
        except Exception as error:  # of a damaged core
            answers.add([0.0] * 3, [1.0] * 3, kind=type(error).__name__)
            continue
        velocity, kind = body.masses @ body.velocities / mass, "one hole" if len(areas) == 1 else "holes"
        answers.add(velocity, -speed * areas.sum(axis=0) / area, speed, kind, case=case)
    return answers.comparison()


def weak_spots(rng: np.random.Generator, mesh: Mesh) -> np.ndarray:
    """Return limits (e,) of springs: a tenth of them tear, which lie at random."""
    count = len(mesh.edges)
    return np.where(rng.uniform(size=count) < 0.1, rng.uniform(1.1, 1.3, count), 0.0)


def bursting(seed: int, **options: Any) -> tuple[World, float]:
    """Return a world in which a ball bursts over the ground, and a step [s]."""
    rng = np.random.default_rng(seed)
    mesh, world = rotated(softbody.icosphere(2), rng), World(**options)
    world.add_ground(float(mesh.vertices[:, 2].min()) - 0.1)
    gas, limit = rng.uniform(500.0, 1000.0), weak_spots(rng, mesh)
    world.add_soft_body(mesh, 1.0, 300.0, gas, velocity=rng.normal(size=3), tear_at=limit, name="it")
    return world, 0.3 * world.stable_time_step()


def bits_of(world: World) -> bytes:
    """Return where all particles are, how fast and heavy, and what gas is in each piece."""
    return told(world.soft_bodies).tobytes()


@check_tear(
    reference="the same world with another far away, with two threads, step by step, or from a snapshot or file",
    kind="the core in another form",
    faults=(
        Fault(
            "alone it tears a step later",
            watch.room_of_springs,
            "load_lanes(watch.square, i) → load_lanes(watch.square, i) + 1e-2",
        ),
        Fault("looks that come too late", watch.room_of_springs, "(1.0 - DRIFT_ROUNDING) * x_ → 30.0 * x_"),
        Fault(
            "limits in company",
            tears.leak_and_look,
            "load_lanes(tearing.limit, i) → load_lanes(tearing.limit, i) + 1e-2",
        ),
        Fault(
            "springs that wait no more",
            "softbody.storage.snapshot._model",
            "if number < TEARING_SINCE: a_ → "
            "entries._left['model.edge_tear_at'] = np.abs(entries._left['model.edge_tear_at'])",
        ),
    ),
)
def tears_to_the_same_bits(run: Run) -> Comparison:
    """A body that bursts does so to the same bits.

    Balls with weak springs over the ground: alone, beside a box that is far away, with two threads, in many steps
    at once or one
    by one, and from a snapshot or a file of the midst of it.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(2, 8, 60)):
        seed, half = int(rng.integers(2**31)), 60
        made: dict[str, tuple[bytes, list[int]]] = {}
        try:
            for kind in ("alone", "in company", "two threads", "one by one", "restored", "loaded"):
                world, h = bursting(seed, threads=2 if kind == "two threads" else 1)
                if kind == "in company":
                    world.add_box((1.0, 1.0, 1.0), None, (500.0, 0.0, 0.0))
                if kind == "one by one":
                    for _ in range(2 * half):
                        world.step(h)
                elif kind in ("restored", "loaded"):
                    world.step(h, half)
                    times, other = [event.time for event in world.events], World()
                    if kind == "restored":
                        other.restore(world.snapshot())
                    else:
                        with TemporaryDirectory() as folder:
                            world.save(Path(folder) / "torn.npz")
                            other = World.load(Path(folder) / "torn.npz")
                    other.step(h, half)
                    made[kind] = (
                        bits_of(other),
                        [round(time / h) for time in times + [each.time for each in other.events]],
                    )
                    continue
                else:
                    world.step(h, 2 * half)
                made[kind] = bits_of(world), [round(event.time / h) for event in world.events]
        except Exception as error:  # of a damaged core
            answers.add([False, False, False], [True, True, True], kind=type(error).__name__)
            continue
        for kind, (bits, steps) in made.items():
            same = made["alone"]
            answers.add([bits == same[0], steps == same[1], len(steps) > 1], [True] * 3, kind=kind, case=case)
    return answers.comparison()


@check_tear(
    reference="the documentation; what the claim has asked for",
    kind="specification",
    faults=(
        Fault("limits of any size", "softbody.model.validation.tear_at_of", "array > 1.0 → array > 0.0"),
        Fault(
            "limits that are no numbers", "softbody.model.validation.tear_at_of", "np.isfinite(array) → ~(array <= 1.0)"
        ),
        Fault(
            "what holds itself",
            checks.check_may_tear,
            "model.soft_self_contact != 0.0 → model.soft_self_contact > 1e300",
        ),
        Fault(
            "what is full of liquid",
            checks.check_may_tear,
            "model.soft_liquid_density > 0.0 → model.soft_liquid_density > 1e300",
        ),
        Fault("a box inside", checks.check_may_tear, "hosts[a_] = True → pass"),
        Fault("what hangs", checks.check_may_tear, "hangs = a_ → hangs = hosts"),
        Fault("a liquid around it", checks.check_may_tear, "model.liquid_density > 0.0 → model.liquid_density > 1e300"),
        Fault("torn bodies that are cut", soft_rows.check_may_change, "is_open(model, row) → False"),
    ),
)
def refused_by_name(run: Run) -> Comparison:
    """What cannot tear is refused, and nothing changes.

    Limits that are none, for a new body or one that is there; bodies that may tear and hold themselves, a liquid, a box
    or what hangs, or are in a liquid, once a step is to be taken; a torn body that is to be cut or joined.
    """
    rng, answers = run.fresh_rng(), Answers()

    def same(before: dict[str, Any], world: World) -> bool:
        after = world.snapshot()
        return set(before) == set(after) and all(
            np.asarray(before[name]).tobytes() == np.asarray(after[name]).tobytes() for name in before
        )

    for _ in range(run.count(1, 3, 20)):
        mesh, limit = rotated(softbody.icosphere(1), rng), rng.uniform(1.1, 2.0)
        count, edge = len(mesh.edges), int(rng.integers(len(mesh.edges)))
        one_bad = np.full(count, limit)
        one_bad[edge] = rng.uniform(0.1, 1.0)
        wrong: dict[str, Any] = {
            "1": 1.0,
            "below 1": rng.uniform(0.1, 1.0),
            "negative": -limit,
            "no number": np.nan,
            "infinite": np.inf,
            "words": "soon",
            "too few": [limit] * (count - 1),
            "one of them": one_bad,
        }
        for kind, given in wrong.items():
            world = World()
            body = world.add_soft_body(mesh, 1.0, 100.0, 1.0, tear_at=limit, name="it")
            before = world.snapshot()
            errors = (
                refusal(world.add_soft_body, mesh, 1.0, 100.0, 1.0, tear_at=given),
                refusal(body.set_springs, tear_at=given),
            )
            words = f"edge {edge} is" if kind == "one of them" else "tear_at"
            named = all("tear_at" in error and words in error for error in errors)
            answers.add([named, same(before, world)], [True, True], kind=kind)
        causes = {
            "holds itself": "self_contact",
            "full of liquid": "liquid_density",
            "a box inside": "a box is inside it",
            "what hangs": "something hangs in it",
            "in a liquid": "a liquid around it",
            "none": "",
        }
        for kind, words in causes.items():
            world = World()
            options: dict[str, Any] = {"self_contact": True} if kind == "holds itself" else {}
            options |= {"liquid_density": 1.0} if kind == "full of liquid" else {}
            body = world.add_soft_body(mesh, 1.0, 100.0, 1.0, tear_at=limit, name="it", **options)
            if kind == "a box inside":
                world.add_box((0.2, 0.2, 0.2), 0.1, inside=body)
            if kind == "what hangs":
                world.suspend([(0.1, 0.0, -0.4)], body)
            if kind == "in a liquid":
                world.add_liquid(1.0, -5.0)
            before = world.snapshot()
            error = refusal(world.step, 1e-4)
            named = words in error and "'it'" in error if words else not error
            answers.add([named, same(before, world) == bool(words)], [True, True], kind=kind)
        torn = vessel(rng, int(rng.integers(3)))
        if torn is None:
            answers.add([False, False], [True, True], kind="whole")
            continue
        world, centre = torn.world, torn.centre
        other = world.add_soft_body(mesh, 1.0, 100.0, 1.0, centre + (5.0, 0.0, 0.0))
        before = world.snapshot()
        for kind, error in (
            ("cut", refusal(torn.cut, centre, (0.0, 0.3, 1.0))),
            ("joined", refusal(world.join, torn, other, centre)),
            ("joined to", refusal(world.join, other, torn, centre)),
        ):
            answers.add(["has torn" in error, same(before, world)], [True, True], kind=kind)
    return answers.comparison()


@check_tear(
    reference="what the claim counts before and after, by places",
    kind="specification",
    faults=(
        Fault("places of others", tearing._places, "np.bincount(skin.origin) > 1 → np.bincount(skin.origin) > 0"),
        Fault("events of the step before", runner.Runner._tear, "store.time → store.time - 1e-3"),
        Fault("the lightest first", tearing._pieces, "-round(a_, 9) → round(a_, 9)"),
        Fault("pieces that have no names", tearing.tear_bodies, "names.free_after(x_) → None"),
        Fault("bodies of other numbers", tearing.tear_bodies, "soft_count + len(more) → soft_count"),
    ),
)
def events_tell(run: Run) -> Comparison:
    """Events tell each tear.

    Bodies of every kind, drawn out for some rounds, in company: of each body that has torn one event, at the time of
    the step; its places are those where there are more particles now; its bodies are its pieces, with the body first
    and no other heavier, and called after it.
    """
    rng, answers = run.fresh_rng(), Answers()

    def counts(bodies: tuple[SoftBody, ...]) -> dict[bytes, int]:
        found: dict[bytes, int] = defaultdict(int)
        for each in bodies:
            for place in each.positions:
                found[place.tobytes()] += 1
        return found

    for case in range(run.count(12, 40, 400)):
        world = stretched(rng, case).world
        for _ in range(3):
            seen, bodies = len(world.events), pieces_of(world)
            before = {each: counts((each,)) for each in bodies}
            facet = {each: facets((each,)) for each in bodies}
            names = {each.name for each in world.soft_bodies}
            error, h = "", rng.uniform(1.0, 2.0) * STILL
            try:
                world.step(h)
            except Exception as damaged:  # of a damaged core
                error = type(damaged).__name__
            events = world.events[seen:]
            torn = [each for each in bodies if facets((each,)) != facet[each] or counts((each,)) != before[each]]
            answers.add([not error, [event.bodies[0] for event in events] == torn], [True, True], kind="one for each")
            for event in events:
                first, *others = event.bodies
                now, was = counts(event.bodies), before.get(first, {})
                more = {place for place, number in now.items() if number > was.get(place, 0)}
                answers.add(
                    [{place.tobytes() for place in event.places} == more, len(event.places) >= len(more)],
                    [True, True],
                    kind="places",
                )
                answers.add([event.kind == "tear", event.time == world.time], [True, True], kind="kind and time")
                whole_of = sorted(facets(event.bodies)) == facet.get(first)
                heaviest = all(each.masses.sum() <= (1.0 + 1e-8) * first.masses.sum() for each in others)
                answers.add([whole_of, heaviest], [True, True], kind="bodies")
                called = [each.name or "" for each in others]
                after = all(name.rpartition(".")[0] == first.name and name not in names for name in called)
                answers.add([after, len({*called}) == len(called)], [True, True], kind="names")
            if error:
                break
            for each in pieces_of(world):
                each.set_springs(tear_at=rng.uniform(1.05, 1.6, len(each.edges)))
    return answers.comparison()


@check_tear(
    reference="heights of particles, and how deep they are in the box, by NumPy, frame by frame",
    kind="bound",
    unit="m, of bodies of 1 m",
    tolerance=1e-3,
    because="contacts give way a little in each step: 1.6e-4 at worst of three seeds",
    faults=(
        NEVER_ACT,
        Fault(
            "pieces without the box",
            soft_contacts._find_contacts_with_box,
            "with_boxes is None → is_open(model, pair[0])",
        ),
    ),
)
def pieces_lie_on_what_is_there(run: Run) -> Comparison:
    """Pieces of what has burst lie on ground and boxes.

    Balls and rings with weak springs, that burst over the ground or over a box on it, by default settings, for half a
    second:
    how deep a particle is below the ground, or in the box, at most.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(6, 16, 120)):
        mesh = rotated(SKINS[case % 2](rng), rng)
        mesh = mesh.scaled(1.0 / float(np.ptp(mesh.vertices, axis=0).max()))
        world, top = World(), 0.0 if case % 3 == 0 else 0.4
        world.add_ground()
        if top:
            world.add_box((0.8, 0.8, top), None, (0.0, 0.0, 0.5 * top))
        place = (0.0, 0.0, top + 0.02 * rng.uniform() - float(mesh.vertices[:, 2].min()))
        gas, limit = rng.uniform(100.0, 300.0), weak_spots(rng, mesh)
        world.add_soft_body(mesh, 1.0, 300.0, gas, place, tear_at=limit, name="it")
        deepest, kind = np.zeros(2), "on a box" if top else "on the ground"
        try:
            for _ in range(30):
                world.run(1.0 / 60.0)
                points = np.concatenate([each.positions for each in world.soft_bodies])
                inside = (np.array([0.4, 0.4, 0.5 * top]) - np.abs(points - (0.0, 0.0, 0.5 * top))).min(axis=1)
                deepest = np.maximum(deepest, [-points[:, 2].min(), inside.max() if top else 0.0])
        except Exception as error:  # of a damaged core
            deepest, kind = np.ones(2), type(error).__name__
        answers.add([*deepest, float(not world.events)], [0.0, 0.0, 0.0], kind=kind, case=case)
    return answers.comparison()
