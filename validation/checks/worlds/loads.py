"""Soft bodies under load: inflated in containers, below weights, around rods; what holds them stays outside."""

from __future__ import annotations

import contextlib
import re
import warnings
from collections.abc import Iterator

import numpy as np

import softbody
from references import pybullet_world, winding
from softbody import Box, Mesh, OverloadWarning, SimulationError, SoftBody, World
from softbody.bodies.contact_points import ContactPoints
from softbody.collision import pressed
from softbody.collision.soft import soft_box, soft_contacts, soft_response, soft_soft, soft_solver, split_steps
from softbody.dynamics import pressure
from validation import accounts
from validation.answers import Answers
from validation.cases import edge_lengths, random_orientations, rotated, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.worlds.cases import NEVER_ACT, WEIGHTLESS
from validation.fault import Fault

FAMILY = "under load"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

SIDE = 0.5  # [m] of a container
PACE = 0.5  # [m/s] of jaws
TOLD = re.compile(r"box (\d) .* pressed (\S+) m into .* (\d+)% of the thinner one's")  # in an OverloadWarning
MESHES = {
    "box": softbody.box((0.4, 0.4, 0.4), 4),
    "ball": softbody.icosphere(2, 0.22),
    "fine ball": softbody.icosphere(3, 0.22),
}
SHAPES = (
    softbody.icosphere(1),
    softbody.icosphere(2),
    softbody.box((1.8, 1.8, 1.2), 4),
    softbody.torus(0.7, 0.3, 16, 8),
)
FIT_ANYHOW = (  # each way up
    softbody.box((0.25, 0.25, 0.25), 4),
    softbody.torus(0.16, 0.06, 20, 10),
    softbody.icosphere(1, 0.22),
    MESHES["ball"],
    MESHES["fine ball"],
)


def container(wall: float, friction: float) -> tuple[World, list[Box]]:
    """Return a weightless world of six walls, so thick [m], around a cube of SIDE."""
    world, walls = World(WEIGHTLESS), []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            size, place = np.full(3, SIDE + 2.0 * wall), np.zeros(3)
            size[axis], place[axis] = wall, 0.5 * sign * (SIDE + wall)
            walls.append(world.add_box(size, None, place, friction=friction))
    return world, walls


def inflate(world: World, mesh: Mesh, gas: float, friction: float) -> SoftBody:
    """Fill a body with gas [J] within 1.5 s, and let it come to rest; at the steps that the world chooses."""
    body = world.add_soft_body(mesh, 0.5, 100.0, 0.05 * gas, friction=friction)
    for part in np.linspace(0.1, 1.0, 15):
        body.gas = part * gas
        world.run(0.1)
    world.run(1.0)
    return body


@check(
    section="beyond the paper",
    piece="softbody.World.run",
    reference="a bound: a thousandth of an edge, the room that sweeps of contacts leave where walls meet",
    kind="bound",
    unit="of an edge",
    tolerance=1e-3,
    because="where three walls meet, what sweeps leave is taken back as fast as it comes: 6.5e-5 at worst at full",
    faults=(
        NEVER_ACT,
        Fault("steps that no load parts", split_steps.closes_too_far, "closed_ > CLOSED * shortest_ → closed < -1e300"),
    ),
)
def inflated_in_a_container(run: Run) -> Comparison:
    """Whatever is inflated in a box of walls stays in it.

    A box and two balls, with 100 to 4 000 J of gas, between walls of 2 to 50 mm, rough or smooth: how far the particle
    that is farthest out is in a wall once it is at rest. No OverloadWarning comes.
    """
    rng, answers = run.fresh_rng(), Answers()
    cases = [(name, gas) for gas in (4_000.0, 400.0, 100.0) for name in MESHES][: run.count(6, 9, 9)]
    for case, (name, gas) in enumerate(cases * run.count(1, 1, 5)):
        friction, wall = rng.choice([0.0, 0.5]), 0.002 * 25.0 ** rng.random()
        if case == 0:
            friction, wall = 0.0, 0.002
        world, _ = container(wall, friction)
        mesh = MESHES[name]
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("ignore")
            warnings.simplefilter("always", OverloadWarning)
            body = inflate(world, mesh, gas, friction)
        answers.add(len(told), 0, kind="told")
        edge = edge_lengths(mesh.vertices, mesh.edges).mean()
        depth = np.max([0.0, np.abs(body.positions).max() - 0.5 * SIDE])
        answers.add(depth / edge, 0.0, kind=f"{name}, {gas:g} J")
    return answers.comparison()


def _walls_around(kind: str, rng: np.random.Generator) -> np.ndarray:
    """Return the unit normals (f, 3) of walls around the origin, outward."""
    both = np.vstack([np.eye(3), -np.eye(3)])
    if kind == "wedge":
        half = rng.uniform(0.3, 0.7)  # [rad]
        roof = [(s * np.cos(half), 0.0, np.sin(half)) for s in (-1.0, 1.0)]
        return np.array([*roof, (0.0, 0.0, -1.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0)])
    if kind == "tube":
        angle = np.pi / 3.0 * np.arange(6)
        return np.vstack([np.c_[np.cos(angle), np.sin(angle), 0.0 * angle], both[[2, 5]]])
    if kind == "turned box":
        return both @ rotation_matrix(random_orientations(rng, 1)[0]).T
    slanted = both + rng.normal(0.0, 0.25, (6, 3))
    return slanted / np.linalg.norm(slanted, axis=1)[:, None]


def _facing(normal: np.ndarray) -> np.ndarray:
    """Return a quaternion that turns z into a unit `normal`."""
    x, y, z = normal
    q = np.array([1.0 + z, -y, x, 0.0]) if z > -0.999 else np.array([0.0, 1.0, 0.0, 0.0])
    return q / np.linalg.norm(q)


@check(
    section="beyond the paper",
    piece="softbody.World.run",
    reference="a bound: the part of an edge by which a body may come nearer in one go",
    kind="bound",
    unit="of an edge",
    tolerance=0.25,
    because="what comes nearer by a quarter of an edge is taken in more parts; 0.09 at worst of 72 containers",
    least=4,
    faults=(NEVER_ACT,),
)
def inflated_in_any_container(run: Run) -> Comparison:
    """Whatever is inflated within slanted walls never leaves them.

    Wedges, tubes of six sides, turned boxes and six walls that lean at random, 3 to 80 mm thick, rough or smooth. A
    ring, balls and a box, with 50 to 4 000 J of gas: how far the particle that is farthest out ever was behind a wall.
    """
    rng, answers = run.fresh_rng(), Answers()
    kinds = "wedge", "tube", "turned box", "leaning walls"
    for case in range(run.count(8, 16, 80)):
        kind, mesh = kinds[case % 4], FIT_ANYHOW[rng.integers(len(FIT_ANYHOW))]
        normals, friction, wall = _walls_around(kind, rng), rng.choice([0.0, 0.5]), 0.003 * 27.0 ** rng.random()
        world, gas, worst = World(WEIGHTLESS), 50.0 * 80.0 ** rng.random(), 0.0
        for normal in normals:
            place = (0.5 * SIDE + 0.5 * wall) * normal
            world.add_box((2.0, 2.0, wall), None, place, _facing(normal), friction=friction)
        body = world.add_soft_body(mesh, 0.5, 100.0, 1.0, friction=friction)
        for part in np.linspace(0.05, 1.0, 20):
            body.gas = part * gas
            world.run(0.1)
            worst = np.max([worst, (body.positions @ normals.T).max() - 0.5 * SIDE])
        answers.add(worst / edge_lengths(mesh.vertices, mesh.edges).mean(), 0.0, kind=kind)
    return answers.comparison()


@check(
    section="2.3",
    piece="softbody.World.run, softbody.World.contact_points",
    reference="the virial: of a body at rest, 3 P V = Σ F·x of its springs and of what holds it",
    kind="closed form",
    tolerance=2e-4,
    because="particles are some micrometres in walls that are 250 mm away: 7.9e-5 at worst at full",
    least=3,
    faults=(Fault("a gas of 2 % more", pressure.gas_pressure, "gas_ / volume_ → 1.02 * gas_ / volume_"),),
)
def walls_bear_the_gas(run: Run) -> Comparison:
    """What smooth walls bear is the pressure of the gas within.

    Bodies of 100 to 400 J of gas, at rest in a container; normal forces of contacts, at the walls.
    """
    answers = Answers()
    for name in MESHES:
        for gas in (100.0, 200.0, 400.0)[: run.count(1, 2, 3)]:
            world, _ = container(0.05, 0.0)
            body = inflate(world, MESHES[name], gas, 0.0)
            x, (i, j) = body.positions, body.edges.T
            along = x[j] - x[i]
            length = np.linalg.norm(along, axis=1)
            springs = (body.stiffness * (length - body.rest_length) * length).sum()
            points = world.contact_points()
            held = (np.abs((points.impulse * points.normal).sum(axis=1)) * 0.5 * SIDE).sum() / points.time_step
            answers.add((springs + held) / (3.0 * gas), 1.0, kind=name)
    return answers.comparison()


@check(
    section="2.3, 4.2",
    piece="softbody.World.run, softbody.World.contact_points",
    reference="SciPy's minimum of ½ Σ k (l − l0)² − nRT ln V + Σ m g z between the ground and the plate",
    kind="third-party library",
    engines=("scipy",),
    tolerance=1e-5,
    because="SciPy ends where energies differ by their rounding, in the square of a place: 1.7e-6 at worst at full",
    faults=(
        Fault("a gas of 0.1‰ more", pressure.gas_pressure, "gas_ / volume_ → 1.0001 * gas_ / volume_"),
        Fault(
            "forces 0.1‰ too large",
            ContactPoints.force_on,
            "impulse / self.time_step → 1.0001 * impulse / self.time_step",
        ),
    ),
)
def bears_a_plate_in_the_shape_of_least_energy(run: Run) -> Comparison:
    """Under a plate a body has SciPy's shape and force.

    Balls, a box and a ring, pressed by a smooth plate to nine to three tenths of their height, at rest on smooth
    ground: the force on the plate, and how high each particle is, of the plate's height. SciPy starts from where they
    rest, moved by a thousandth of that at random.
    """
    from references import scipy

    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(6, 12, 60)):
        shape = (*SHAPES, MESHES["fine ball"])[case % 5]
        size = np.ptp(shape.vertices[:, 2])
        gas, stiffness, part, world = rng.uniform(30.0, 90.0), rng.uniform(200.0, 600.0), rng.uniform(0.3, 0.9), World()
        uneven = shape.vertices + rng.normal(0.0, 0.01 * size, shape.vertices.shape)  # what is even may stand on end
        mesh = Mesh(0.7 / size * uneven, shape.triangles)
        world.add_ground(friction=0.0)
        body = world.add_soft_body(mesh, 1.0, stiffness, gas, (0.0, 0.0, 0.4), friction=0.0, drag=3.0)
        plate = world.add_box((3.0, 3.0, 0.5), None, (0.0, 0.0, 1.25), friction=0.0)
        plate.velocity = 0.0, 0.0, 0.5 * (0.7 * part - 1.0)  # in two seconds, to that part of its height
        world.run(2.0)
        plate.velocity = np.zeros(3)
        for _ in range(20):
            world.run(2.0)
            if np.abs(body.velocities).max() < 1e-7:
                break
        height, force = plate.position[2] - 0.25, world.contact_points().force_on(plate)[2]
        start = body.positions + rng.normal(0.0, 1e-3 * height, body.positions.shape)
        springs = body.edges, body.rest_length, body.stiffness, body.triangles
        expected, expected_force = scipy.between_plates(start, *springs, gas, 9.81, height)
        kind = f"{len(mesh.vertices)} particles"
        answers.add(force / expected_force, 1.0, kind=f"{kind}, force")
        answers.extend(body.positions[:, 2] / height, expected[:, 2] / height, kind=f"{kind}, heights")
    return answers.comparison()


def inside(body: SoftBody, points: np.ndarray) -> np.ndarray:
    """Tell which points (m, 3) [m] are inside a soft body, by winding numbers."""
    return winding.points_in_mesh(points, body.positions, body.triangles)


def in_box(solid: Box, margin: float = 0.02) -> np.ndarray:
    """Return points (m, 3) [m] in a box, near its sides and within."""
    steps = np.linspace(-0.5 + margin, 0.5 - margin, 7)
    grid = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3) * solid.size
    return solid.position + grid @ rotation_matrix(solid.orientation).T


def _rods(run: Run) -> Iterator[tuple[str, SoftBody, Box]]:
    """Yield balls into which a rod was pressed, and balls on which a plate has come down; each with what presses it."""
    for side, lowest in ((0.06, 0.3), (0.03, 0.3), (0.06, 0.03))[: run.count(2, 3, 3)]:
        world = World()
        world.add_ground(friction=0.0)
        ball = world.add_soft_body(softbody.icosphere(3, 0.25), 0.2, 60.0, 8.0, (0.0, 0.0, 0.25), friction=0.0)
        rod = world.add_box((side, side, 0.4), None, (0.0, 0.0, 0.72), velocity=(0.0, 0.0, -0.58), friction=0.0)
        while rod.position[2] - 0.2 > lowest:
            world.run(0.02)
        yield f"rod of {1e3 * side:.0f} mm", ball, rod
    for mass in (10.0, 60.0, 100.0)[: run.count(2, 3, 3)]:
        world = World()
        world.add_ground()
        ball = world.add_soft_body(softbody.icosphere(2, 0.4), 1.0, 400.0, 60.0, (0.0, 0.0, 0.4))
        plate = world.add_box((3.0, 3.0, 0.5), mass, (0.0, 0.0, 1.06))
        for _ in range(20):
            world.run(0.1)
            yield f"plate of {mass:g} kg", ball, plate


@check(
    section="beyond the paper",
    piece="softbody.World.run",
    reference="winding numbers of the body around 343 points in what presses it",
    kind="closed form",
    because="yes or no; the points are a fiftieth of its sides within the rod or plate",
    faults=(NEVER_ACT,),
)
def what_presses_stays_outside(run: Run) -> Comparison:
    """Rods and plates that press a soft ball stay outside of it.

    Rods of 30 and 60 mm are pushed into a ball of 0.5 m until it is 0.3 or 0.03 m high below them. Plates of 10 to 100
    times a ball's mass fall on it from a hand above.
    """
    answers = Answers()
    for kind, ball, solid in _rods(run):
        points = in_box(solid)
        answers.extend(inside(ball, points), np.zeros(len(points), bool), kind=kind)
    return answers.comparison()


@check(
    section="4.2",
    piece="softbody.World.run, softbody.collision.soft.soft_box.find_corner_contacts",
    reference="winding numbers of the body around 343 points in the rod",
    kind="closed form",
    unit="of the points",
    tolerance=0.03,
    because="a rod's edge may show through a triangle in passing: 0.0146 at worst of 60 at full",
    least=2,
    faults=(
        Fault(
            "corners leave by the skin behind",
            soft_box.find_corner_contacts,
            "max(along[0], along[1], along[2]) > ALONG_OWN → False",
        ),
    ),
)
def rods_stand_on_what_they_crush(run: Run) -> Comparison:
    """A rod that falls on a soft ball stays outside of it.

    Rods of 0.11 to 0.15 m, a metre long, of 20 to 240 times a ball's mass press its skin on to the ground, stand on it,
    and topple. How much of one is in the ball at most, of thirty looks in 1.5 s.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(6, 12, 60)):
        subdivisions, side, world = 2 + case % 2, rng.uniform(0.11, 0.15), World()
        world.add_ground()
        mesh = softbody.icosphere(subdivisions, 0.25)
        ball = world.add_soft_body(mesh, 1.0, 250.0, rng.uniform(20.0, 90.0), (0.0, 0.0, 0.25), friction=0.5)
        place = (*rng.uniform(-0.1, 0.1, 2), 1.16)
        rod = world.add_box((side, side, 1.0), 20.0 * 12.0 ** rng.random(), place)
        most = 0.0
        for _ in range(30):
            world.run(0.05)
            most = np.max([most, inside(ball, in_box(rod)).mean()])
        answers.add(most, 0.0, kind=("ball", "fine ball")[case % 2])
    return answers.comparison()


@check(
    section="4.2, 4.4",
    piece="softbody.World.run, softbody.collision.soft.soft_response.resolve_contacts",
    reference="the speed of a free fall from where it starts to the ground",
    kind="bound",
    because="yes or no: what gas and springs add is less than what the ball takes, at most 3.92 of 4.32 m/s",
    least=2,
    faults=(
        Fault(
            "corners hold what lies on a skin",
            soft_response._first_push,
            "_lies_below(contacts, k, response) → False",
        ),
    ),
)
def slabs_lie_on_what_they_crush(run: Run) -> Comparison:
    """A slab that crushes a soft ball is not thrown off it.

    Slabs of 5 cm, 30 to 500 times as heavy as the ball, fall on it askew. They press its skin on to the ground and lie
    on that and on their corners: how fast one is, forty times in two seconds, or until an error ends it.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(8, 20, 100)):
        world = World()
        world.add_ground()
        ball = softbody.icosphere(1 + case % 2, 0.25)
        world.add_soft_body(ball, 1.0, 200.0, rng.uniform(10.0, 60.0), (0.0, 0.0, 0.26), friction=0.5)
        askew = rng.normal(0.0, 0.15, 4) + (1.0, 0.0, 0.0, 0.0)
        place, size = (*rng.uniform(-0.15, 0.15, 2), 0.95), (*rng.uniform(0.1, 0.3, 2), 0.05)
        slab = world.add_box(size, 30.0 * 17.0 ** rng.random(), place, askew / np.linalg.norm(askew))
        fastest = 0.0
        with contextlib.suppress(SimulationError):  # more than half of the slab is in the ball: said, and no further
            for _ in range(40):
                world.run(0.05)
                fastest = np.max([fastest, np.linalg.norm(slab.velocity)])
        answers.add(fastest > np.sqrt(2.0 * 9.81 * place[2]), False, kind=("coarse ball", "ball")[case % 2])
    return answers.comparison()


def _column(rng: np.random.Generator) -> tuple[World, float]:
    """Return a world of two to five bodies above each other, one of them soft, and its weight times its height [J]."""
    world, top, weight = World(), 0.0, 0.0
    world.add_ground(friction=rng.uniform(0.0, 0.8))
    are_soft = rng.random(rng.integers(2, 6)) < 0.5
    are_soft[rng.integers(len(are_soft))] = True
    for is_soft in are_soft:
        aside, friction = rng.uniform(-0.15, 0.15, 2), rng.uniform(0.0, 0.8)
        turn = random_orientations(rng, 1)[0]
        if is_soft:
            mass, radius, shape = 0.3 * 10.0 ** rng.random(), rng.uniform(0.15, 0.35), SHAPES[rng.integers(len(SHAPES))]
            mesh = Mesh(radius * shape.vertices @ rotation_matrix(turn).T, shape.triangles)
            reach, gas = 1.05 * radius * np.linalg.norm(shape.vertices, axis=1).max(), rng.uniform(80.0, 480.0) * radius
            place = (*aside, top + reach)
            world.add_soft_body(mesh, mass, rng.uniform(100.0, 500.0), mass * gas, place, friction=friction)
        else:
            mass, size = 0.3 * 1_000.0 ** rng.random(), rng.uniform(0.05, 0.5, 3)
            reach = 0.5 * np.linalg.norm(size) + 0.01
            upright = rng.random() < 0.5
            place = (*aside, top + reach)
            world.add_box(size, mass, place, (1.0, 0.0, 0.0, 0.0) if upright else turn, friction=friction)
        top, weight = top + 2.0 * reach + rng.choice([0.0, 0.3]), weight + 9.81 * mass
    return world, top * weight


@check(
    section="4.2, 4.3, 4.4",
    piece="softbody.World.run, softbody.collision.soft.soft_response.resolve_contacts",
    reference="invariant: kinetic, spring, gas and gravity energy by NumPy",
    kind="invariant",
    unit="risen above the least so far, of weight × height",
    tolerance=1e-3,
    because="overlap that is taken back lifts what lies on it: 4.7e-4 at worst of 900",
    least=4,
    faults=(
        Fault(
            "a box does not feel what lies on it",
            soft_solver.give,
            "_push_box(s_, m_, b_, scale(-1.0, more), cross(more, p_)) → pass",
        ),
    ),
)
def columns_gain_no_energy(run: Run) -> Comparison:
    """Whatever falls on what, no energy comes from it.

    Columns of two to five bodies: balls, rings, soft and rigid boxes, of 0.3 to 300 kg, turned anyhow, a bit aside of
    each other. Of forty looks in two seconds, or until an error ends it.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(12, 40, 300)):
        world, unit = _column(rng)
        least, risen = accounts.energy(world), 0.0
        with contextlib.suppress(SimulationError):  # one body is crushed by what is on it: said, and no further
            for _ in range(40):
                world.run(0.05)
                energy = accounts.energy(world)
                risen = np.max([risen, energy - least])
                least = np.min([least, energy])
        answers.add(risen / unit, 0.0, kind=f"{len(world.soft_bodies)} soft, {len(world.boxes)} rigid")
    return answers.comparison()


@check(
    section="4.3",
    piece="softbody.World.run, softbody.collision.soft.soft_soft.find_soft_soft_contacts",
    reference="the volume of a ball alone, scaled by s: k Σ L² s (s − 1) = 3 nRT",
    kind="closed form",
    unit="of the volume",
    tolerance=0.12,
    because="they lie on each other and swing: 0.089 at worst at full; of bodies that lock 0.2 to 0.8 is missing",
    least=2,
    faults=(
        Fault("rims lock", soft_soft._add_particles, "ALONG_OWN * norm(own) → 2.0 * norm(own)"),
        Fault(
            "rims of unlike meshes lock",
            soft_contacts._find_contacts_of,
            "SHALLOW * x_ → SHALLOW * x_ if has_edges else 0.0",
        ),
    ),
)
def crushed_bodies_part_again(run: Run) -> Comparison:
    """Soft bodies that a falling plate has crushed come apart again.

    Two balls of 1 kg lie on each other, a plate of 12 to 28 kg on both. It crushes them to a quarter of their volume.
    Two seconds after it was taken away each has its own volume back. Both meshes are coarse, or fine, or one is.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(4, 8, 24)):
        fine, gas, world = ((2, 2), (3, 2), (3, 3), (2, 3))[case % 4], rng.uniform(50.0, 80.0), World()
        world.add_ground()
        balls = [softbody.icosphere(subdivisions, 0.4) for subdivisions in fine]
        pair = [world.add_soft_body(ball, 1.0, 400.0, gas, (0.0, 0.0, z)) for ball, z in zip(balls, (0.4, 1.2))]
        plate = world.add_box((3.0, 3.0, 0.5), gas * rng.uniform(0.25, 0.35), (0.0, 0.0, 1.87))
        world.run(2.0)
        world.remove(plate)
        world.run(2.0)
        for ball, body in zip(balls, pair):
            springs = 400.0 * (edge_lengths(ball.vertices, ball.edges) ** 2).sum()
            scale = 0.5 + np.sqrt(0.25 + 3.0 * gas / springs)
            answers.add(body.volume / (scale**3 * ball.volume), 1.0, kind=f"{fine}")
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.World.run, softbody.collision.soft.edge_box.edge_in_box",
    reference="winding numbers of the body around 343 points in the slab; no OverloadWarning",
    kind="closed form",
    unit="of the points",
    tolerance=0.03,
    because="a corner that a skin is pulled over may show in it by a 64th of an edge: 0.0088 at worst of 60 at full",
    faults=(
        Fault(
            "edges leave with ends that leave aside",
            soft_box.find_contacts_in_box,
            "_face_of(rotate_inverse(orientation, normal)) → outcode[j] if place == 1.0 else outcode[i]",
        ),
    ),
)
def slabs_stay_below_what_lies_on_them(run: Run) -> Comparison:
    """A slab stays outside of what is pressed over it.

    A ball falls on a slab that lies on the ground, 5 to 50 mm thick and turned anyhow, and a plate of 2 to 15 kg on the
    ball. Its edges are 13 cm long: it hangs over the slab's rim and corners, and lies on the ground beside.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(20, 30, 60)):
        height, turn = 0.005 * 10.0 ** rng.random(), rng.uniform(0.0, np.pi)
        place, world = (*rng.uniform(-0.2, 0.2, 2), 0.5 * height), World()
        world.add_ground()
        upright = np.array([np.cos(0.5 * turn), 0.0, 0.0, np.sin(0.5 * turn)])
        slab = world.add_box((*rng.uniform(0.1, 0.5, 2), height), None, place, upright)
        gas, mass = rng.uniform(30.0, 80.0), rng.uniform(2.0, 15.0)
        ball = world.add_soft_body(softbody.icosphere(2, 0.4), 1.0, 400.0, gas, (0.0, 0.0, 0.401 + height), drag=3.0)
        world.add_box((3.0, 3.0, 0.5), mass, (0.0, 0.0, 1.06 + height))
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("ignore")
            warnings.simplefilter("always", OverloadWarning)
            for _ in range(3):
                world.run(1.0)
                answers.add(inside(ball, in_box(slab)).mean(), 0.0, kind="slab")
        answers.add(len(told), 0, kind="told")
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.World.run",
    reference="Newton's second law over 400 steps: contacts bear the weight, and what the momentum has gained",
    kind="closed form",
    unit="of the weight",
    tolerance=1e-11,
    because="rounding of sums over 400 steps, with drag as at the begin of each: 1.9e-14 at worst at full",
    least=2,
    faults=(
        Fault(
            "forces 1 % too large", ContactPoints.force_on, "impulse / self.time_step → 1.01 * impulse / self.time_step"
        ),
    ),
)
def load_goes_through(run: Run) -> Comparison:
    """A soft body and the ground bear what lies on it.

    Plates of 5 to 40 kg that swing on a ball of 1 kg: forces on the plate and on the ball, by contacts.
    """
    answers = Answers()
    for mass in (20.0, 5.0, 40.0)[: run.count(1, 3, 3)]:
        world = World()
        world.add_ground()
        ball = world.add_soft_body(softbody.icosphere(2, 0.4), 1.0, 400.0, 60.0, (0.0, 0.0, 0.4), drag=3.0)
        plate = world.add_box((3.0, 3.0, 0.5), mass, (0.0, 0.0, 1.06))
        world.run(1.5)
        step, weights = 0.5 * world.stable_time_step(), np.array([mass, 1.0]) * -world.gravity[2]
        borne, begun = np.zeros(2), np.array([mass * plate.velocity[2], ball.velocity[2]])
        for _ in range(400):
            drag = 3.0 * ball.velocity[2]
            world.step(step)
            points = world.contact_points()
            borne += step * np.array([points.force_on(plate)[2], points.force_on(ball)[2] - drag])
        gained = np.array([mass * plate.velocity[2], ball.velocity[2]]) - begun
        answers.extend((borne - gained) / (400 * step * weights), np.ones(2), kind=["plate", "ball"])
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.World.step",
    reference="similarity: with time in other units, all that has time in it scaled, bodies are at the same places",
    kind="invariant",
    unit="of the size",
    tolerance=1e-9,
    because="rounding, which grows in contacts: 6e-12 at most",
    least=2,
    faults=(Fault("overlap that is lost in seconds", soft_response.parting_times, "PARTING_TIMES / sqrt(x_) → 0.5"),),
)
def units_of_time(run: Run) -> Comparison:
    """A world moves the same in milliseconds, seconds and hours.

    Two soft bodies fall on a floor and on each other, within 1.2 s; gravity, stiffness, gas, damping, speeds and steps
    are scaled alike.
    """
    answers = Answers()
    found = {unit: _fallen(unit) for unit in (1.0, 1e3, 1.0 / 3_600.0)[: run.count(3, 3, 3)]}
    for unit, places in found.items():
        if unit != 1.0:
            answers.extend(places, found[1.0].copy(), kind=f"1 s is {unit:.3g} units")
    return answers.comparison()


def _fallen(unit: float) -> np.ndarray:
    """Return where the particles of two bodies are after a fall, with a second of so many units of time: (n, 3) [m]."""
    world = World(gravity=(0.0, 0.0, -9.81 / unit**2))
    world.add_box((6.0, 6.0, 1.0), None, (0.0, 0.0, -0.5))
    ball, ring = softbody.icosphere(2, 0.5), softbody.torus(0.5, 0.2, 16, 8)
    a = world.add_soft_body(
        ball, 1.0, 300.0 / unit**2, 20.0 / unit**2, (0.0, 0.0, 0.6), (0.3 / unit, 0.1 / unit, -1.0 / unit),
        restitution=0.3, damping=0.1 / unit,
    )  # fmt: skip
    b = world.add_soft_body(
        ring, 0.7, 250.0 / unit**2, 8.0 / unit**2, (0.25, 0.15, 1.2), (0.0, 0.0, -1.0 / unit),
        restitution=0.1, friction=0.4, damping=0.02 / unit,
    )  # fmt: skip
    world.step(1e-3 * unit, 1_200)
    return np.concatenate([a.positions, b.positions])


@check(
    section="beyond the paper",
    piece="softbody.World.step, softbody.OverloadWarning, softbody.SimulationError",
    reference="how deep the jaws are in the box, by Bullet; a quarter and half of a jaw's thickness",
    kind="third-party library",
    engines=("pybullet",),
    because="yes or no; a step closes jaws by a twentieth of their thickness",
    least=12,
    faults=(
        Fault("boxes that are never looked at", pressed.note_boxes, "range(contacts.number[1]) → range(0)"),
        Fault("no step is undone", pressed.goes_through, "pressed.lasting[0] >= LASTING → False"),
        Fault("a first that is not kept", pressed.keep_first, "PRESSED < pressed.part[NOW] < np.inf → False"),
    ),
)
def closed_jaws_are_told(run: Run) -> Comparison:
    """Jaws that close on a rigid box stop in time.

    An OverloadWarning comes with the first step that leaves a jaw a quarter of its thickness in the box, and with none
    before; a SimulationError comes before any is in by half. Boxes of 0.05 to 0.3 m, jaws a tenth as thick or more.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(4, 20, 200)):
        side, h = rng.uniform(0.05, 0.3), 1.0 / 240.0
        thick = side * rng.uniform(0.1, 0.5)
        world, size = World(WEIGHTLESS), np.array([thick, 1.5 * side, 1.5 * side])
        held = world.add_box((side, side, side), 1.0)
        jaws = [world.add_box(size, None, (s * 0.5 * (side + thick), 0.0, 0.0)) for s in (-1.0, 1.0)]
        for jaw, s in zip(jaws, (-1.0, 1.0), strict=True):
            jaw.velocity = (-s * 0.05 * thick / h, 0.0, 0.0)
        told: list[bool] = []
        was_told, deepest, ended = [], [], False
        for _ in range(40):
            with warnings.catch_warnings(record=True) as came:
                warnings.simplefilter("always")
                try:
                    world.step(h)
                except SimulationError:
                    ended = True
                    break
            depth = max(_depth_by_bullet(jaw, held) for jaw in jaws) / thick
            told.append(any(issubclass(one.category, OverloadWarning) for one in came) or (bool(told) and told[-1]))
            was_told.append(depth > 0.25)
            deepest.append(depth)
        answers.extend(
            [told == was_told, ended, max(deepest) > 0.5], [True, True, False], kind=["told", "ends", "deep"]
        )
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.OverloadWarning, softbody.collision.soft.soft_response",
    reference="the depth told, by the thickness of the jaw that is named; how deep vertices are in it, in NumPy",
    kind="specification",
    unit="of the jaw's thickness",
    tolerance=0.008,
    because="the part is told in whole percents, and the depth in three digits: 5.1e-3 at worst of ten seeds",
    faults=(
        Fault(
            "the thickness of a soft body with a box's number",
            soft_response._thickness,
            "response.edge_length.shape[0] + box_ → box",
        ),
    ),
)
def pinched_skins_are_told(run: Run) -> Comparison:
    """Jaws that pinch a soft ball are told by their thickness.

    Two jaws, one 1.5 to 3 times as thick as the other, close on a ball and on each other. An OverloadWarning tells a
    depth, and what part it is of the thickness of the jaw that it names: a quarter or more. No vertex is deeper in.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(4, 20, 200)):
        radius, thin = 0.2, rng.uniform(0.01, 0.04)
        thick = np.array([thin, thin * rng.uniform(1.5, 3.0)])[:: 1 - 2 * (trial % 2)]
        world, sides = World(WEIGHTLESS), np.array([-1.0, 1.0])
        ball = world.add_soft_body(rotated(softbody.icosphere(2, radius), rng), 1.0, 200.0, 20.0)
        jaws = [world.add_box((t, 0.15, 0.15), None, (s * (radius + 0.5 * t), 0.0, 0.0)) for s, t in zip(sides, thick)]
        h, gap, told = 0.5 * world.stable_time_step(), 2.0 * radius, None
        while told is None and gap > -thin:
            pace = PACE if gap > 2.0 * PACE * h else 0.01 * thin / h  # [m/s]
            for jaw, s in zip(jaws, sides):
                jaw.velocity = -s * pace, 0.0, 0.0
            with warnings.catch_warnings(record=True) as came:
                warnings.simplefilter("always")
                try:
                    world.step(h)
                except SimulationError:
                    break
            gap = jaws[1].position[0] - jaws[0].position[0] - 0.5 * thick.sum()
            words = [str(one.message) for one in came if issubclass(one.category, OverloadWarning)]
            told = TOLD.search(words[0]) if words else None
        number, depth, part = (int(told[1]), float(told[2]), 0.01 * float(told[3])) if told else (0, 0.0, 0.0)
        deepest = (0.5 * jaws[number].size - np.abs(ball.positions - jaws[number].position)).min(axis=1).max()
        answers.add(part, np.maximum(0.25, depth / thick[number]), kind="told")
        answers.add(np.maximum(0.0, deepest - depth) / thick[number], 0.0, kind="deeper")
    return answers.comparison()


def _depth_by_bullet(one: Box, other: Box) -> float:
    """Return how deep [m] two boxes are in each other."""
    poses = [np.asarray(row)[None] for box in (one, other) for row in (box.size, box.position, box.orientation)]
    distance, _ = pybullet_world.closest(*poses)
    return -float(distance[0])


def _linking_number(a: np.ndarray, b: np.ndarray) -> float:
    """Return how often a closed line of points a (m, 3) goes round b (n, 3): Gauss's integral, over chords."""
    turns = 0.0
    for p, q in zip(a, np.roll(a, -1, axis=0), strict=True):
        r, s = b - p, b - q
        corners = [r, s, np.roll(s, -1, axis=0), np.roll(r, -1, axis=0)]
        for one, two, three in ((0, 1, 2), (0, 2, 3)):  # solid angles of the two triangles of a quadrangle
            x, y, z = (corners[k] / np.linalg.norm(corners[k], axis=1)[:, None] for k in (one, two, three))
            volume = np.einsum("ij,ij->i", x, np.cross(y, z))
            turns += 2.0 * np.arctan2(volume, 1.0 + (x * y + y * z + z * x).sum(axis=1)).sum()
    return turns / (4.0 * np.pi)


@check(
    section="beyond the paper",
    piece="softbody.World.run, softbody.SimulationError",
    reference="the linking number of the rings' middle lines: Gauss's integral over chords",
    kind="closed form",
    because="whole numbers, of lines that are apart",
    least=2,
    faults=(Fault("soft contacts that are never looked at", soft_response._note_left, "range(count) → range(0)"),),
)
def rings_stay_linked(run: Run) -> Comparison:
    """Linked rings never part without a warning.

    Two rings of 0.5 to 20 kg, of which one holds the other: what is pinched until its skin meets itself is told.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(3, 6, 30)):
        world, mass, pressure = World(), 0.5 * 40.0 ** rng.random(), 100.0 * 10.0 ** rng.random()
        bodies = _chain(world, 2, 0.62, mass, pressure, 2.0 * pressure, 0.0)
        with contextlib.suppress(SimulationError, OverloadWarning), warnings.catch_warnings():
            warnings.simplefilter("error", OverloadWarning)
            world.run(1.5)
        lines = [body.positions.reshape(24, 10, 3).mean(axis=1) for body in bodies]
        answers.add(abs(round(_linking_number(*lines))), 1, kind="linked")
    return answers.comparison()


def _chain(
    world: World, count: int, apart: float, mass: float, pressure: float, stiffness: float, drag: float
) -> list[SoftBody]:
    """Hang linked rings below each other, so far `apart` [m], each turned across the last; the top of one is fixed."""
    ring = softbody.torus(0.5, 0.12, 24, 10)
    upright = ring.vertices[:, [0, 2, 1]] * (1.0, -1.0, 1.0)
    across = upright[:, [1, 0, 2]] * (-1.0, 1.0, 1.0)
    bodies = []
    for k in range(count):
        mesh, place = Mesh(across if k % 2 else upright, ring.triangles), (0.0, 0.0, -apart * k)
        bodies.append(world.add_soft_body(mesh, mass, stiffness, ring.volume * pressure, place, drag=drag))
    top = bodies[0].positions[:, 2]
    bodies[0].fixed = np.flatnonzero(top > top.max() - 0.05)
    return bodies


@check(
    section="beyond the paper",
    piece="softbody.World.run, softbody.ContactPoints.force_on",
    reference="statics: each link bears the weight of all rings below it",
    kind="closed form",
    unit="of that weight",
    tolerance=2e-4,
    because="what is left of a chain's sway, as a mean over 400 steps: 5.5e-5 at worst at standard",
    faults=(
        Fault(
            "half of what contacts give is told",
            soft_response._note_impulses,
            "store(contacts.impulse, k, x_) → store(contacts.impulse, k, scale(0.5, impulse))",
        ),
        Fault(
            "reactions that are a tenth too small",
            soft_solver.give,
            "_give_soft(sharing, moved, x_, scale(-1.0, given), scale(-1.0, before))"
            " → _give_soft(sharing, moved, _acting(contacts, k, place), scale(-0.9, given), scale(-0.9, before))",
        ),
    ),
)
def chains_bear_what_hangs_on_them(run: Run) -> Comparison:
    """Each link of a chain bears the weight below it.

    Chains of three to ten soft rings, of 0.2 to 1 kg each, hang from the fixed top of the first one.
    """
    rng, answers = run.fresh_rng(), Answers()
    for count in ((3, 5), (3, 5, 7), (3, 4, 5, 6, 7, 8, 9, 10))[("quick", "standard", "full").index(run.level)]:
        world, mass = World(), 0.2 * 5.0 ** rng.random()
        rings = _chain(world, count, 0.7, mass, 1_000.0, 300.0, 2.0)
        world.run(8.0 + 2.0 * count)
        h, means = 0.9 * world.stable_time_step(), np.zeros(count)
        for _ in range(400):
            world.step(h)
            points = world.contact_points()
            means += [points.force_on(ring)[2] / 400.0 for ring in rings]
        weight = mass * 9.81
        for k in range(1, count):
            answers.add(means[k:].sum() / ((count - k) * weight), 1.0, kind="link")
    return answers.comparison()
