"""Loads that no contact may hold: whatever is on the wrong side of something was told before."""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

import softbody
from references import igl, pybullet_world
from softbody import Box, OverlapWarning, OverloadWarning, SimulationError, SoftBody, World
from softbody.collision import pressed
from softbody.collision.soft import behind_walls, soft_response
from validation.answers import Answers
from validation.cases import edge_lengths, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.worlds.cases import NEVER_ACT, WEIGHTLESS
from validation.checks.worlds.loads import SIDE, container, in_box
from validation.fault import Fault

FAMILY = "beyond limits"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

KINDS = "weight", "plate", "jaws", "walls", "stack", "shot"
LOOKS = 20  # at each world, from its begin to its end
WRONG = 0.3  # of the thinner one's thickness: contacts that do not hold are told from a quarter on


@check(
    section="beyond the paper",
    piece="softbody.World.run",
    reference="a bound: a sixteenth of a wall's thickness, what contacts may leave",
    kind="bound",
    unit="of a wall's thickness",
    tolerance=0.0626,
    because="contacts are swept until they leave less; 0.0625 at most of 20 balls",
    least=4,
    faults=(
        Fault("walls each for itself", behind_walls._add_if_behind, "behind > LEAST * depth → behind > 1e300 * depth"),
    ),
)
def thin_walls_keep_coarse_balls(run: Run) -> Comparison:
    """Thin walls keep a ball of twelve particles.

    It is blown up to 30 kJ between smooth walls of 0.5 to 2 mm, past which a particle flies in one step: how far one is
    in a wall, forty times.
    """
    rng, answers = run.fresh_rng(), Answers()
    left_before = [(0.0005, 0.1), (0.001, 0.1), (0.0015, 0.1), (0.002, 0.1)]  # walls that each kept for themselves
    drawn = [(0.0005 * 4.0 ** rng.random(), 0.05 * 4.0 ** rng.random()) for _ in range(run.count(2, 20, 200))]
    for wall, mass in left_before + drawn:
        worst = 0.0
        world, _ = container(wall, 0.0)
        ball = world.add_soft_body(softbody.icosahedron(0.2), mass, 300.0, 10.0, friction=0.0)
        for gas in np.geomspace(10.0, 30_000.0, 41)[1:]:
            ball.gas = gas
            world.run(0.05)
            worst = np.max([worst, np.abs(ball.positions).max() - 0.5 * SIDE])
        answers.add(worst / wall, 0.0, kind="ball")
    return answers.comparison()


class Case(NamedTuple):
    """A world whose load grows, and who is in it."""

    world: World
    seconds: float
    act: Callable[[float], None] | None = None  # given the part of the time that is over


def _soft(world: World, rng: np.random.Generator, size: float, bottom: float, x: float = 0.0) -> SoftBody:
    """Add a body that stands its own weight, from barely to a hundred times."""
    mesh = (
        softbody.icosphere(1, 0.5 * size),
        softbody.icosphere(2, 0.5 * size),
        softbody.box((size, size, size), 3),
        softbody.box((size, 0.6 * size, 0.4 * size), 2),
        softbody.icosahedron(0.5 * size),
    )[rng.integers(5)]
    mass, firm = 10.0 ** rng.uniform(-1.0, 1.0), 10.0 ** rng.uniform(0.5, 2.5)
    place = x, 0.0, bottom - mesh.vertices[:, 2].min()
    weight = mass * 9.81
    return world.add_soft_body(
        mesh, mass, 2.0 * firm * weight / size, 3.0 * firm * weight * size, place, friction=rng.choice([0.0, 0.5])
    )


def _case(kind: str, rng: np.random.Generator) -> Case:
    """Return a world of one kind, from what contacts hold to far beyond."""
    if kind == "walls":
        world, _ = container(0.001 * 50.0 ** rng.random(), rng.choice([0.0, 0.5]))
        body = _soft(world, rng, 0.4, -0.2)
        begin, most = body.gas, body.gas * 10.0 ** rng.uniform(0.0, 2.5)

        def inflate(part: float) -> None:
            body.gas = begin * (most / begin) ** min(1.0, 1.5 * part)

        return Case(world, 1.0, inflate)
    if kind == "shot":
        world, speed = World(WEIGHTLESS), 10.0 ** rng.uniform(0.0, 1.7)
        _soft(world, rng, 0.5, -0.25)
        shape = [(0.05, 0.05, 0.5), (0.3, 0.3, 0.3), (0.02, 0.5, 0.5)][rng.integers(3)]
        start = rng.uniform(-0.1, 0.1), 0.0, 0.35 + 0.5 * shape[2]
        world.add_box(shape, 10.0 ** rng.uniform(-1.0, 1.5), start, velocity=(0.0, 0.0, -speed))
        return Case(world, 1.0 / speed)
    world = World()
    world.add_ground()
    if kind == "stack":
        top = 0.01
        for _ in range(rng.integers(2, 5)):
            if rng.random() < 0.6:
                top = 0.01 + float(_soft(world, rng, 0.4, top, rng.uniform(-0.03, 0.03)).positions[:, 2].max())
            else:
                world.add_box((0.4, 0.4, 0.1), 10.0 ** rng.uniform(-0.5, 2.0), (0.0, 0.0, top + 0.05))
                top += 0.11
        return Case(world, 2.0)
    if kind == "jaws":
        side, thick = 0.085, rng.choice([0.02, 0.005])
        if rng.random() < 0.5:
            world.add_box((side, side, side), 0.2, (0.0, 0.0, 0.5 * side))
            width = side
        else:
            width = float(np.ptp(_soft(world, rng, side, 0.002).positions[:, 0]))
        closed = 0.5 * (width * (1.0 - 0.5 * rng.random()) + thick)
        for sign in (-1.0, 1.0):
            aside = rng.uniform(-0.02, 0.02)
            open_at = sign * (0.5 * width + thick), aside, 0.05
            jaw = world.add_box((thick, 0.06, 0.06), None, open_at, friction=1.0)
            jaw.move_to((sign * closed, aside, 0.05), seconds=rng.uniform(0.1, 0.6))
        return Case(world, 1.0)
    body = _soft(world, rng, 0.5, 0.01)
    size = np.array([(2.0, 2.0, 0.2), (0.1, 0.1, 1.0), (0.3, 0.3, 0.3), (1.0, 1.0, 0.02)][rng.integers(4)])
    place = np.array([rng.uniform(-0.1, 0.1), 0.0, body.positions[:, 2].max() + 0.02 + 0.5 * size[2]])
    if kind == "weight":
        world.add_box(size, body.mass * 10.0 ** rng.uniform(0.0, 3.0), place + (0.0, 0.0, 0.3 * rng.random()))
        return Case(world, 1.5)
    press = world.add_box(size, None, place)
    press.move_to((*place[:2], rng.uniform(-0.02, 0.3) + 0.5 * size[2]), seconds=rng.uniform(0.2, 1.0))
    return Case(world, 1.2)


def _thickness(of: SoftBody | Box) -> float:
    return float((of.size if isinstance(of, Box) else np.ptp(of.positions, axis=0)).min())


def _depth_in_soft(points: np.ndarray, body: SoftBody) -> float:
    """Return how deep [m] the deepest of points (m, 3) is in a soft body: inside, and behind the closest surface.

    Where a skin has folded through itself, the two tell different things, and no contact is to blame.
    """
    low, high = body.positions.min(axis=0), body.positions.max(axis=0)
    points = points[((points > low) & (points < high)).all(axis=1)]
    for is_inside in (igl.points_in_mesh, igl.points_in_mesh_by_distance):
        points = points[is_inside(points, body.positions, body.triangles)] if len(points) else points
    return float(igl.closest_points(points, body.positions, body.triangles)[0].max()) if len(points) else 0.0


def _depths(world: World) -> Iterator[tuple[float, float]]:
    """Yield how deep [m] bodies are in each other and in the ground, and the thickness [m] of the thinner one."""
    for body in world.soft_bodies:
        yield float(world.model.ground_height - body.positions[:, 2].min()), _thickness(body)
        for neighbour in world.soft_bodies:
            if neighbour is not body:
                yield _depth_in_soft(body.positions, neighbour), min(_thickness(body), _thickness(neighbour))
        for box in world.boxes:
            seen = (body.positions - box.position) @ rotation_matrix(box.orientation)
            yield float((0.5 * box.size - np.abs(seen)).min(axis=1).max()), _thickness(box)
            yield _depth_in_soft(in_box(box), body), _thickness(body)
    for one, other in itertools.combinations(world.boxes, 2):
        if one.mass or other.mass:
            poses = [np.asarray(row)[None] for box in (one, other) for row in (box.size, box.position, box.orientation)]
            yield -float(pybullet_world.closest(*poses)[0][0]), min(_thickness(one), _thickness(other))


@check(
    section="beyond the paper",
    piece="softbody.World.run, softbody.OverloadWarning, softbody.SimulationError",
    reference="how deep bodies are in each other, by igl and Bullet",
    kind="third-party library",
    engines=("igl", "pybullet"),
    because="yes or no; bodies may bulge, and be thinner than they were, by a fifth",
    least=6,
    faults=(
        NEVER_ACT,
        Fault("a first that is not kept", pressed.keep_first, "PRESSED < pressed.part[NOW] < np.inf → False"),
    ),
)
def nothing_gives_way_in_silence(run: Run) -> Comparison:
    """Whatever presses what, nobody is on the wrong side without a word.

    Weights to a thousand times a body's mass, plates that close, jaws that close too far, gas in thin walls, stacks and
    shots, at random, of bodies that start apart: seen twenty times, nobody is three tenths of the thinner one's
    thickness inside another before the first warning.
    """
    rng, answers = run.fresh_rng(), Answers()
    for number in range(run.count(12, 60, 1_000)):
        kind = KINDS[number % len(KINDS)]
        case, silent = _case(kind, rng), False
        with warnings.catch_warnings(record=True) as came:
            warnings.simplefilter("always")
            for look in range(LOOKS):
                if case.act:
                    case.act(look / LOOKS)
                try:
                    case.world.run(case.seconds / LOOKS)
                except SimulationError:
                    break
                told = any(issubclass(one.category, softbody.OverloadWarning) for one in came)
                silent |= not told and any(depth > WRONG * thick for depth, thick in _depths(case.world))
        starts_apart = not any(issubclass(one.category, OverlapWarning) for one in came)
        if starts_apart:
            answers.add(silent, False, kind=kind)
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.World.run, softbody.OverloadWarning, softbody.SimulationError",
    reference="how deep particles are in each other's body, by igl",
    kind="third-party library",
    engines=("igl",),
    unit="of an edge",
    tolerance=0.6,
    because="half an edge is told where a contact is; the nearest point of a skin may be a tenth of an edge further",
    faults=(
        Fault(
            "skins as thick as bodies",
            soft_response._thickness,
            "SKIN * _edge_length(contacts, k, response) → np.inf",
        ),
    ),
)
def crushed_skins_are_told(run: Run) -> Comparison:
    """Soft bodies that are crushed into each other were told.

    Two bodies under a plate of 13 to 95 times their mass: balls, coarse or fine, cubes and rings. Seen sixty times in
    three seconds, how deep particles are in the other body, twice in a row, before the first warning; in mean edges of
    the finer mesh.
    """
    rng, answers = run.fresh_rng(), Answers()
    meshes = {
        "fine ball": softbody.icosphere(3, 0.4),
        "ball": softbody.icosphere(2, 0.4),
        "ring": softbody.torus(0.4, 0.2, 20, 10),
        "cube": softbody.box((0.7, 0.7, 0.7), 4),
    }
    for case in range(run.count(8, 16, 80)):
        names = (("fine ball", "ball")[case % 2], list(meshes)[case // 2 % 4])
        world, pair, top = World(), [], 0.01
        world.add_ground()
        gas = rng.uniform(20.0, 60.0)
        for name in names:
            mesh = meshes[name]
            place = (*rng.uniform(-0.1, 0.1, 2), top - mesh.vertices[:, 2].min())
            pair.append(world.add_soft_body(mesh, 1.0, 400.0, gas, place))
            top = 0.01 + float(pair[-1].positions[:, 2].max())
        world.add_box((3.0, 3.0, 0.5), gas * 10.0 ** rng.uniform(-0.2, 0.2), (0.0, 0.0, top + 0.3))
        edge = min(edge_lengths(body.positions, body.edges).mean() for body in pair)
        silent = before = 0.0
        with warnings.catch_warnings(record=True) as came:
            warnings.simplefilter("ignore")
            warnings.simplefilter("always", OverloadWarning)
            for _ in range(60):
                try:
                    world.run(0.05)
                except SimulationError:
                    break
                if came:
                    break
                a, b = pair
                depth = np.max([_depth_in_soft(a.positions, b), _depth_in_soft(b.positions, a)]) / edge
                silent, before = np.max([silent, np.min([depth, before])]), depth
        answers.add(silent, 0.0, kind=" below ".join(names))
    return answers.comparison()
