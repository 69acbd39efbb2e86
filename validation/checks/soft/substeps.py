"""Claims that soft bodies that step in parts, with contacts as one, move as in one part."""

from __future__ import annotations

import numpy as np

from softbody import World, icosphere
from softbody.dynamics import integrators, soft_bodies
from softbody.stepping import step
from validation.answers import Answers
from validation.cases import edge_lengths, rotated
from validation.check import Comparison, Run, check
from validation.checks.soft.bounce import balls, ends
from validation.checks.soft.cases import STRUCK_WHERE_IT_IS, weightless
from validation.checks.soft.energy import crowd, drift_and_gain
from validation.fault import Fault

FAMILY = "soft bodies that collide"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

PARTS = (2, 3, 4)  # in which soft bodies take a step
ODD = (3, 5, 7)  # parts that do not divide the stretches, of a power of two, in which many steps are made
G = 9.81  # [m/s²]


@check(
    section="4.2, 4.3",
    piece="softbody.World.substeps, softbody.collision.soft.soft_response",
    reference="invariants; springs and gas by SciPy's judge, boxes by their inertia, in NumPy",
    engines=("scipy",),
    unit="of the bounds, which are parts of the angular momenta and of the kinetic energy",
    kind="invariant",
    tolerance=1.0,
    because="what later sweeps add, and springs answer at the step's end: 0.37 of the bounds in 90 worlds, 0.01 in"
    " most",
    faults=(STRUCK_WHERE_IT_IS,),
)
def crowds_in_parts_keep_what_they_must(run: Run) -> Comparison:
    """Crowds that step in parts keep energy and angular momentum.

    Unlike soft bodies and boxes fly at each other. Soft bodies take each step in 2, 3 or 4 parts, and contacts act
    once. There is no more energy than at the start, but for terms of second order in the step. They are at most
    (ω h)² / 5000 of the momenta and (ω h)² / 20 of the energy, with ω the highest frequency.
    """
    rng, answers = run.fresh_rng(), Answers()
    for k in range(run.count(3, 6, 60)):
        world = crowd(rng)
        world.substeps = parts = PARTS[k % len(PARTS)]
        of_stable = (0.05, 0.3)[k % 2]
        drift, gain = drift_and_gain(world, of_stable * world.stable_time_step())
        square = (2.0 * of_stable * parts) ** 2  # (ω h)², of the whole step
        answers.add(5000.0 * drift / square, 0.0, kind=f"angular momentum, {parts} parts")
        answers.add(20.0 * gain / square, 0.0, kind=f"energy, {parts} parts")
    return answers.comparison()


@check(
    section="2, 4.2, 5.1",
    piece="softbody.World.substeps, softbody.dynamics.soft_bodies.move_in_place, softbody.dynamics.particle_ground",
    reference="SciPy's DOP853 between events: particles touch the ground, and leave it",
    engines=("scipy",),
    unit="of the radius",
    tolerance=4e-4,
    because="contact acts at the ends of steps, and symplectic Euler is of order 1: 2.1e-4 at worst of ten seeds",
    faults=(
        Fault("parts as of one fewer", soft_bodies._batch, "h / substeps → h / max(1, substeps - 1)"),
        Fault("parts a hundredth too short", soft_bodies._batch, "h / substeps → 0.99 * h / substeps"),
    ),
)
def balls_bounce_in_parts_as_between_events(run: Run) -> Comparison:
    """A soft ball that steps in parts bounces as between events.

    On the ground, or on a box that stands, it ends where it does from event to event. It takes each step in 2, 3 or 4
    parts, and contacts act once, as steps are made shorter: parts are as short as in 128 of 0.8 of a stable step. How
    far they are off in whole ones is noted.
    """
    found, off = balls(run.seed, run.count(3, 3, 12), 0.1), dict.fromkeys(PARTS, 0.0)
    cases = [(ball, parts) for k, ball in enumerate(found) for parts in PARTS[k % 3 :] + PARTS[: k % 3]]
    fine = ends(128, [(ball, _world(k, parts), None) for k, (ball, parts) in enumerate(cases)])
    for k, (ball, parts) in enumerate(cases):
        whole = ends(1, [(ball, _world(k, parts), None)])
        far = float(np.linalg.norm(whole.measured - whole.expected, axis=1).max()) / ball.radius
        off[parts] = float(np.maximum(off[parts], far))
    fine.notes += [f"in whole steps of {parts} parts {each:.2g} of the radius" for parts, each in off.items()]
    return fine


def _world(k: int, parts: int) -> World:
    """Return a world in which a ball falls on a box, or on the ground."""
    world = World(substeps=parts)
    if k % 2:
        world.add_box((20.0, 20.0, 2.0), None, (0.0, 0.0, -1.0), friction=0.0)
    return world


@check(
    section="4.2",
    piece="softbody.World.substeps, softbody.stepping.step.resolve_soft_contacts",
    reference="the plate's place by its speed; by how much the lowest vertex is below its top, in NumPy",
    unit="of the plate's way in a step",
    kind="closed form",
    tolerance=0.25,
    because="particles side by side are parted together, but for what a sweep more would do: 0.108 at worst of 120, 6"
    " and more where contacts know a part of the way; 1e-12 in one part",
    faults=(
        Fault(
            "contacts that act as in a part of the step",
            step.resolve_soft_contacts,
            "resolve_contacts(a_, b_, c_, d_, h_, e_, f_)"
            " → resolve_contacts(a_, b_, c_, d_, h_ / settings.substeps, e_, f_)",
        ),
    ),
)
def plate_pushes_a_ball_on(run: Run) -> Comparison:
    """A plate that moves by script pushes a soft ball on.

    The ball takes each step in 2, 3 or 4 parts. At the end of no step is any of it more than a quarter of the plate's
    way in that step inside.
    """
    rng, answers = run.fresh_rng(), Answers()
    for k in range(run.count(6, 12, 60)):
        world = weightless(substeps=PARTS[k % len(PARTS)])
        ball = world.add_soft_body(icosphere(2, 0.5), 1.0, rng.uniform(200.0, 800.0), 30.0, (0.0, 0.0, 0.52))
        world.equilibrium()
        below, speed = ball.positions[:, 2].min() - rng.uniform(0.01, 0.1), rng.uniform(1.0, 3.0)
        world.add_box((3.0, 3.0, 1.0), None, (0.0, 0.0, below - 0.5), velocity=(0.0, 0.0, speed))
        h, deep = 0.8 * world.stable_time_step(), 0.0
        while world.time < 0.4:
            world.step(h)
            deep = np.maximum(deep, below + speed * world.time - ball.positions[:, 2].min())
        answers.add(deep / (speed * h), 0.0, kind=f"{world.substeps} parts")
    return answers.comparison()


@check(
    section="2, 5.1",
    piece="softbody.World.substeps, softbody.dynamics.integrators.advance_body",
    reference="symplectic Euler, and Newton's and Coulomb's laws for particles after whole steps, in NumPy",
    engines=("scipy",),
    unit="of the radius, and of the fastest velocity",
    tolerance=1e-12,
    because="rounding over 200 parts of steps, and a strike makes that larger: 5.9e-14 at worst of ten seeds",
    faults=(
        Fault(
            "a ground that acts in the midst of steps",
            integrators._advance_body,
            "(batch.begin + step + 1) % batch.landing → (step + 1) % batch.landing",
        ),
    ),
)
def ground_acts_after_whole_steps(run: Run) -> Comparison:
    """The ground acts after whole steps of any number of parts.

    Balls that bounce and rub on ground at any height take each step in 3, 5 or 7 parts. All of 200 parts and more are
    made in one call.
    """
    from references import steppers

    rng, answers = run.fresh_rng(), Answers()
    for k in range(run.count(6, 12, 60)):
        parts, radius, height = ODD[k % len(ODD)], rng.uniform(0.2, 0.4), rng.uniform(-1.0, 1.0)
        bounce, rub = rng.uniform(0.3, 0.9), rng.uniform(0.1, 0.8)
        mesh, world = rotated(icosphere(1, radius), rng), World(substeps=parts)
        world.add_ground(height, restitution=bounce, friction=rub)
        mass, stiffness, gas = rng.uniform(0.5, 2.0), rng.uniform(100.0, 300.0), rng.uniform(10.0, 20.0)
        place = 0.0, 0.0, height - mesh.vertices[:, 2].min() + 0.02
        start = rng.uniform(1.0, 2.0), 0.0, -rng.uniform(1.0, 2.0)
        ball = world.add_soft_body(mesh, mass, stiffness, gas, place, start, friction=rub)
        x, v, count = ball.positions.copy(), ball.velocities.copy(), len(mesh.vertices)
        h, steps = 0.3 * world.stable_time_step(), -(-200 // parts)
        world.step(h, steps)
        judged = steppers.SoftBody(
            mesh.edges,
            edge_lengths(mesh.vertices, mesh.edges),
            np.full(len(mesh.edges), stiffness),
            mesh.triangles,
            gas,
            mass / count,
            np.array([0.0, 0.0, -G]),
            np.zeros((count, 3)),
            0.1 * np.sqrt(2.0 * stiffness * mass / count),
            0.0,
            np.ones(count, bool),
        )
        for _ in range(steps):
            x, v = steppers.motion(judged, x, v, h / parts, parts, "symplectic_euler")
            _land(x, v, height, bounce, rub)
        fastest = np.abs(v).max()
        answers.extend(ball.positions / radius, x / radius, kind=f"{parts} parts")
        answers.extend(ball.velocities / fastest, v / fastest, kind=f"{parts} parts")
    return answers.comparison()


def _land(x: np.ndarray, v: np.ndarray, height: float, bounce: float, rub: float) -> None:
    """Put particles (n, 3) that are below the ground on it; those that go down bounce, and lose μ (1 + e) v_z."""
    below = x[:, 2] < height
    x[below, 2] = height
    strikes = below & (v[:, 2] < 0.0)
    down, slide = -v[strikes, 2], np.hypot(v[strikes, 0], v[strikes, 1])
    v[strikes, :2] *= np.maximum(0.0, 1.0 - rub * (1.0 + bounce) * down / slide)[:, None]
    v[strikes, 2] = bounce * down
