"""Soft bodies at rest: pressed between the ground and a plate, or under a box that has fallen on them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import softbody
from references import printed
from softbody import Box, SoftBody, World
from softbody.collision.boxes import manifold
from softbody.collision.soft import edge_mesh, soft_contacts, soft_response, soft_solver
from softbody.dynamics import particle_ground, pressure
from validation.answers import Answers
from validation.cases import edge_lengths, rotated, rotation_matrix
from validation.check import Comparison, Misprint, Run, check
from validation.checks.soft.cases import CONTACTS
from validation.fault import Fault

FAMILY = "soft bodies at rest"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

GRAVITY = 9.81  # [m/s²]
STEP = 0.8  # of the stable time step


class Pressed(NamedTuple):
    """A soft sphere at rest on the ground, under a static plate or free above; what the judge makes of it."""

    weight: float  # [N]
    force: np.ndarray  # (n, 3) [N] of springs, gas and weight, by the judge: contacts must undo it
    area: np.ndarray  # (t,) [m²] of the triangles, seen from above
    triangles: np.ndarray
    pressure: float  # [Pa], from the judge's volume
    sides: dict[str, np.ndarray]  # (n,) of bool: which particles touch the "ground", and which the "plate"


def _press(rng: np.random.Generator, subdivisions: int, mass: float, plate: float | None) -> Pressed:
    """Return a smooth sphere of diameter 1 m that has come to rest below a plate at height `plate` [m], if any."""
    from references import scipy, trimesh

    world = World(gravity=(0.0, 0.0, -GRAVITY), integrator="symplectic_euler")
    world.add_ground(friction=0.0)
    mesh = rotated(softbody.icosphere(subdivisions, 0.5), rng)
    body = world.add_soft_body(mesh, mass, 200.0, 60.0, (0.0, 0.0, 0.5), friction=0.0, drag=5.0)
    if plate is not None:
        world.add_box((4.0, 4.0, 2.0), None, (0.0, 0.0, plate + 1.0), friction=0.0)
    world.run(24.0, STEP * world.stable_time_step())
    x = body.positions.copy()
    a, b, c = (x[body.triangles[:, k]] for k in range(3))
    lengths = edge_lengths(mesh.vertices, mesh.edges)
    force = scipy.forces(x, mesh.edges, lengths, np.full(len(mesh.edges), 200.0), mesh.triangles, 60.0)
    force[:, 2] -= mass / len(x) * GRAVITY
    sides = {"ground": x[:, 2] <= 1e-9}
    if plate is not None:
        sides["plate"] = x[:, 2] >= plate - 1e-9
    area = 0.5 * np.abs(np.cross(b - a, c - a)[:, 2])
    return Pressed(mass * GRAVITY, force, area, mesh.triangles, 60.0 / trimesh.volume(x, mesh.triangles), sides)


@check(
    section="4.2, 5.1",
    piece="softbody.dynamics.particle_ground.resolve_ground, softbody.collision.soft.soft_response",
    reference="balance of forces; springs and gas by the judge's own formulas at the positions of the core",
    engines=("scipy", "trimesh"),
    unit="of the weight",
    tolerance=2e-3,
    because="particles at the rim still settle after 24 s with drag, by micrometres; most cases are below 1e-6",
    faults=(
        Fault(
            "ground that throws particles up by a millimetre",
            particle_ground.land,
            "position_[2, i_] = height_ → position_[2, i_] = height_ + 0.001",
        ),
    ),
)
def reactions_carry_the_weight(run: Run) -> Comparison:
    """Contacts push a soft sphere at rest up by its weight alone.

    And only where it touches.
    """
    rng, answers = run.fresh_rng(), Answers()
    for k in range(run.count(1, 2, 8)):
        fine = 4 if run.level == "full" and k == 0 else 3
        for mass, plate in ((4.0, None), (1.0, 0.8)):
            pressed = _press(rng, fine, mass, plate)
            force, touching = pressed.force, np.logical_or.reduce(list(pressed.sides.values()))
            total = np.linalg.norm(-force[touching].sum(axis=0) - [0.0, 0.0, pressed.weight])
            loose, sideways = np.abs(force[~touching]).max(), np.abs(force[:, :2]).max()
            signs = zip(pressed.sides.values(), (1.0, -1.0))
            pulled = np.max([(sign * force[mask, 2]).max(initial=0.0) for mask, sign in signs])
            kinds = "reaction less weight", "force on a free particle", "force sideways", "pull of a contact"
            answers.extend(np.array([total, loose, sideways, pulled]) / pressed.weight, np.zeros(4), kind=kinds)
    return answers.comparison()


@check(
    section="4.3",
    piece="softbody.World.run, softbody.collision.soft.soft_solver.solve_island",
    reference="at rest nothing moves",
    kind="bound",
    unit="metres, the farthest that a particle goes in ten seconds; the lower box is 0.8 wide",
    tolerance=2e-6,
    because="2e-7 at worst of thirty, in steps of 6 ms; 2e-2 where edges that lie across each other took turns to bear",
    faults=(
        Fault(
            "impulses that are never taken back",
            soft_solver._answer,
            "max(0.0, before_ + lack_) → max(before_, before_ + lack_)",
        ),
        Fault("edges on the knife's edge", edge_mesh.edge_across_edge, "max(x_, y_) > SLACK → max(x_, y_) > 0.0"),
    ),
)
def soft_boxes_rest(run: Run) -> Comparison:
    """Soft boxes that lie along each other come to rest.

    They have friction and drag, and are watched from 10 to 20 s.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(6, 12, 60)):
        answers.add(_wandered(*_stack(rng, rigid_between=False), until=10.0), 0.0)
    return answers.comparison()


@check(
    section="4.3",
    piece="softbody.World.run, softbody.collision.soft.soft_soft.find_soft_soft_contacts",
    reference="at rest nothing moves",
    kind="bound",
    unit="of the stacks",
    tolerance=0.13,
    least=1,
    because="5 of 80 at full rock for good, by 0.2 to 3 mm, and 2 of 24 at standard",
    faults=(Fault("ridges that are none as soon as they are flat", edge_mesh._is_reentrant, "FLAT * x_ * y_ → 0.0"),),
)
def askew_soft_boxes_rest(run: Run) -> Comparison:
    """Most soft boxes that lie askew on each other come to rest.

    The upper one is turned anyhow, has 0.5 to 2 kg and few triangles or many. They have friction and drag. Told is the
    part of stacks that move by more than a tenth of a millimetre from 20 to 30 s.
    """
    rng, answers, lower, moved = run.fresh_rng(), Answers(), softbody.box((0.8, 0.8, 0.6), 2), []
    for _ in range(run.count(8, 24, 80)):
        world, rub, (x, y) = World(), float(rng.uniform(0.3, 0.7)), rng.uniform(-0.04, 0.04, 2)
        world.add_ground(friction=rub)
        box, gas = softbody.box((0.6, 0.6, 0.6), int(rng.integers(1, 4))), float(rng.choice([10.0, 20.0]))
        angle, mass = rng.uniform(0.0, 0.25 * np.pi), float(rng.uniform(0.5, 2.0))
        turn = rotation_matrix(np.array([np.cos(angle), 0.0, 0.0, np.sin(angle)]))
        upper = softbody.Mesh(box.vertices @ turn.T, box.triangles)
        bodies = [
            world.add_soft_body(mesh, weight, 200.0, gas, place, friction=rub, drag=2.0)
            for mesh, weight, place in ((lower, 1.0, (0.0, 0.0, 0.31)), (upper, mass, (x, y, 0.95)))
        ]
        moved.append(_wandered(world, bodies, until=20.0))
    answers.add(np.mean(np.array(moved) > 1e-4), 0.0)
    return answers.comparison()


@check(
    section="4.2, 4.3",
    piece="softbody.World.run, softbody.collision.soft.soft_solver.solve_island",
    reference="at rest nothing moves",
    kind="bound",
    unit="metres, the farthest that a particle goes in ten seconds; the lower box is 0.8 wide",
    tolerance=8e-3,
    because="it trembles at 1 cm/s: 5.0e-3 at worst of thirty; 3.4e-2 before impulses were taken back",
    faults=(
        Fault("a box that feels all impulses in its middle", soft_solver.give, "cross(more, place) → scale(0.0, more)"),
    ),
)
def boxes_between_soft_ones_stay(run: Run) -> Comparison:
    """A rigid box that lies between two soft ones stays there.

    They have friction and drag, and are watched from 20 to 30 s.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(6, 12, 60)):
        answers.add(_wandered(*_stack(rng, rigid_between=True), until=20.0), 0.0)
    return answers.comparison()


def _stack(rng: np.random.Generator, rigid_between: bool) -> tuple[World, list[SoftBody]]:
    """Return a soft box on another one, a few centimetres off its middle; between them lies a rigid one, or none."""
    rub, aside, world = float(rng.uniform(0.3, 0.7)), rng.uniform(-0.04, 0.04, (2, 2)), World()
    world.add_ground(friction=rub)
    places = [((0.8, 0.8, 0.6), (0.0, 0.0, 0.31)), ((0.6, 0.6, 0.6), (*aside[0], 1.04 if rigid_between else 0.95))]
    bodies = [
        world.add_soft_body(softbody.box(size, 2), 1.0, 200.0, 10.0, place, friction=rub, drag=2.0)
        for size, place in places
    ]
    if rigid_between:
        world.add_box((0.7, 0.7, 0.1), rng.uniform(0.5, 1.5), (*aside[1], 0.67), friction=rub)
    return world, bodies


def _wandered(world: World, bodies: list[SoftBody], until: float) -> float:
    """Return how far [m] a particle moves in the ten seconds after `until` [s], at most."""
    world.run(until)
    before = [body.positions.copy() for body in bodies]
    world.run(10.0)
    return max(float(np.linalg.norm(body.positions - x, axis=1).max()) for body, x in zip(bodies, before, strict=True))


@check(
    section="2.2, 4.2",
    piece="softbody.dynamics.pressure, softbody.dynamics.particle_ground.resolve_ground",
    reference="balance of a membrane that leaves the ground without pull: P A of the triangles that touch with three"
    " corners, and with one, enclose the weight",
    engines=("scipy", "trimesh"),
    unit="outside of the enclosure, of the weight",
    least=1,
    tolerance=0.016,
    because="only what is outside counts, and a surface of facets leaves the rim at an angle, and pulls: by up to 1.6"
    " % of a load at 642 particles; the weight is 10 % inside and more",
    faults=(Fault("a gas of half the pressure", pressure.gas_pressure, "gas_ / volume_ → 0.5 * gas_ / volume_"),),
)
def pressure_carries_the_load(run: Run) -> Comparison:
    """Pressure times contact area is a soft sphere's weight on the ground."""
    rng, answers, notes = run.fresh_rng(), Answers(), []
    for mass in (4.0, 2.0, 3.0)[: run.count(1, 3, 3)] * run.count(1, 1, 6):
        pressed = _press(rng, 3, mass, None)
        corners = pressed.sides["ground"][pressed.triangles].sum(axis=1)
        least, most = (pressed.pressure * pressed.area[corners >= k].sum() for k in (3, 1))
        outside = np.max([0.0, least - pressed.weight, pressed.weight - most])
        answers.add(outside / pressed.weight, 0.0, kind=f"{mass} kg")
        notes.append(f"weight {pressed.weight:.1f} N, P A between {least:.1f} and {most:.1f} N")
    return answers.comparison(notes=notes[:3])


def _box_on_torus(segments: int, speed: float = 0.0, mass: float = 1.0) -> tuple[World, SoftBody, Box]:
    """Return a wide box of `mass` [kg] half a metre above a soft torus that lies on the ground."""
    world = World(gravity=(0.0, 0.0, -GRAVITY), integrator="symplectic_euler")
    world.add_ground()
    ring = softbody.torus(1.0, 0.4, segments, segments // 2)
    torus = world.add_soft_body(ring, 2.0, 400.0, 150.0, (0.0, 0.0, 0.41), drag=3.0)
    box = world.add_box((2.6, 2.6, 0.2), mass, (0.0, 0.0, 1.45), velocity=(0.0, 0.0, -speed))
    return world, torus, box


def _rest_height(segments: int, part: float, seconds: float) -> float:
    """Return the height [m] of the box at rest, over the last tenth of a fall and rest of `seconds`."""
    world, _, box = _box_on_torus(segments)
    step = part * world.stable_time_step()
    world.run(0.9 * seconds, step)
    heights = []
    for _ in range(10):
        world.run(0.01 * seconds, step)
        heights.append(box.position[2])
    return float(np.mean(heights))


@check(
    section="4.2, 9",
    piece=CONTACTS,
    reference="refinement: the step from 0.8 of the stable one to a quarter of that; twice as many segments",
    unit="of the height",
    kind="the core in another form",
    least=2,
    tolerance=0.01,
    because="a coarse torus has corners where a fine one is round: 9 % from 12 to 24 segments, 0.4 % from 24 to 48",
    faults=(
        Fault(
            "ways that bodies have come too far, and that are not undone",
            soft_response.look_back,
            "height(contacts_, k_, bodies_) + way_ → height(contacts_, k_, bodies_)",
        ),
    ),
)
def rest_height_converges(run: Run) -> Comparison:
    """A box's height on a soft torus converges with step and mesh.

    The box falls on it and comes to rest. The height does not depend on the step, and less and less on the mesh.
    """
    seconds = float(run.count(6, 12, 20))
    base, coarse = _rest_height(24, 0.8, seconds), _rest_height(12, 0.8, seconds)
    tried = [("step / 2", 24, 0.4), ("48 segments", 48, 0.8), ("step / 4", 24, 0.2), ("72 segments", 72, 0.8)]
    answers, notes = Answers(), [f"12 segments: {coarse:.4f} m", f"24 segments: {base:.4f} m"]
    for name, segments, part in tried[: run.count(2, 3, 4)]:
        height = _rest_height(segments, part, seconds)
        answers.add(height, base, base, name)
        notes.append(f"{name}: {height:.4f} m")
    return answers.comparison(notes=notes)


@check(
    section="4.2, 6",
    piece=CONTACTS,
    reference="invariant: the box above the torus's centre, and no particle of it above the box",
    kind="invariant",
    because="yes or no, at every hundredth of a second",
    faults=(
        Fault(
            "soft bodies and boxes that do not meet",
            soft_contacts.near_bodies,
            "_sphere_may_meet_box(model_, state_, sphere_, box_) → False",
        ),
    ),
)
def box_never_goes_through(run: Run) -> Comparison:
    """A box dropped or thrown on a soft torus never goes through."""
    answers = Answers()
    for speed in (0.0, 2.0, 5.0, 10.0)[: run.count(2, 4, 4)]:
        for mass in (0.3, 1.0, 3.0):
            world, torus, box = _box_on_torus(24, speed, mass)
            step = STEP * world.stable_time_step()
            for _ in range(run.count(100, 200, 1_000)):
                world.run(0.01, step)
                height = box.position[2]
                is_above = height > torus.centre[2] and torus.positions[:, 2].max() < height + 0.1
                answers.add(is_above, True, kind=f"{mass} kg at {speed} m/s")
    return answers.comparison()


@check(
    section="4.4, 4.5",
    piece="softbody.collision.boxes.manifold.box_box_manifold",
    reference="statics: what holds it up passes below its centre; the velocities after one step are zero",
    unit="of the speed that one step of weight gives",
    kind="closed form",
    tolerance=8e-6,
    because="sweeps end where one corrects less than 1e-4 of that speed: 7.1e-7 at worst of ten seeds, 9.2e-7 of 1 000",
    faults=(
        Fault(
            "boxes that touch at one point only",
            manifold._clip_faces,
            "above_ <= limits_.margin and kept_ < MOST_POINTS → above_ <= limits_.margin and kept_ < 1",
        ),
    ),
    erratum=Misprint("E18", "one contact half-way between the bodies", "contacts on the surfaces that touch"),
)
def stacked_boxes_stay(run: Run) -> Comparison:
    """A box off-centre on another is held on their surfaces, and stays."""
    rng, answers, turned = run.fresh_rng(), Answers(), []
    step = 1e-3
    for _ in range(run.count(20, 100, 1_000)):
        lower, upper = np.append(rng.uniform(1.5, 3.0, 2), 0.5), rng.uniform(0.4, 1.0, 3)
        mass, aside = float(rng.uniform(0.5, 5.0)), rng.uniform(-0.4, 0.4, 2)
        place = (*aside, 0.5 * (lower[2] + upper[2]))
        world = World(gravity=(0.0, 0.0, -GRAVITY))
        world.add_box(lower, None)
        box = world.add_box(upper, mass, place)
        world.step(step)
        answers.add(np.concatenate([box.velocity, box.angular_velocity]) / (GRAVITY * step), np.zeros(6))
        fall = 0.0, 0.0, -GRAVITY * step
        printed_turn = printed.support_half_way(upper, mass, place, fall, (0.0, 0.0, 0.0))
        turned.append(np.concatenate(printed_turn) / (GRAVITY * step))
    return answers.comparison(printed=np.array(turned))
