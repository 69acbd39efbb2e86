"""Claims that contact makes no energy: bodies of unlike meshes that collide in a World as it comes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import softbody
from softbody import World
from validation import accounts
from validation.answers import Answers
from validation.cases import random_orientations, rotated
from validation.check import Comparison, Run, check
from validation.checks.soft.cases import FASTER, RESPONSE, STRUCK_WHERE_IT_IS, weightless

FAMILY = "soft bodies that collide"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

MESHES = (
    softbody.tetrahedron(0.6),
    softbody.octahedron(0.5),
    softbody.box((0.7, 0.7, 0.7)),
    softbody.icosphere(1, 0.5),
    softbody.icosphere(2, 0.5),
    softbody.icosphere(3, 0.5),
    softbody.torus(0.5, 0.2),
)
STIFFNESS, GAS = 300.0, 20.0  # [N/m], [J]
SECONDS, LOOK = 1.2, 2e-3  # they have met and parted; from look to look

# Integrators, and parts of the stable step, at which the integrator alone keeps the energy of bodies that vibrate; and
# ω h at the stable step: ω is the highest frequency.
LIMITS = {"rk4_velocity": 2.785, "rk4": 2.785, "symplectic_euler": 2.0}
STEPS = (("rk4_velocity", 0.1), ("rk4_velocity", 0.8), ("rk4", 0.1), ("rk4", 0.8), ("symplectic_euler", 0.05))


class Collision(NamedTuple):
    """Two soft bodies that fly at each other at 2 m/s, aside of each other, without weight."""

    world: World
    kinetic: float  # [J]
    step: float  # [s]


def collision(rng: np.random.Generator, integrator: str, part: float, friction: float) -> Collision:
    """Return two of MESHES, turned anyhow, of unlike masses and any restitution."""
    world = weightless(integrator=integrator)
    masses, restitution = np.exp(rng.uniform(-1.0, 1.0, 2)), rng.random(2)
    places = ((-1.0, 0.0, 0.0), (1.0, *rng.uniform(-0.3, 0.3, 2)))
    for mass, place, e in zip(masses, places, restitution):
        mesh = rotated(MESHES[rng.integers(len(MESHES))], rng)
        world.add_soft_body(mesh, mass, STIFFNESS, GAS, place, friction=friction, restitution=e, damping=0.0)
    world.equilibrium()
    for body, speed in zip(world.soft_bodies, (1.0, -1.0)):
        body.velocities[:] = (speed, 0.0, 0.0)
    return Collision(world, float(0.5 * masses.sum()), part * world.stable_time_step())


@check(
    section="4.3",
    piece=RESPONSE,
    reference="invariant; springs and gas by SciPy's judge",
    engines=("scipy",),
    unit="most energy gained, of (ω h)² times the kinetic",
    kind="invariant",
    least=5,
    tolerance=0.05,
    because="springs answer what a bounce up to h ago has moved when the step ends: of order (ω h)² of the struck"
    " particles' share, half of all at most: 0.016 in some hundred pairs, of few particles and a restitution of"
    " almost 1; 1e-12 where the bounce loses more",
    faults=(FASTER,),
)
def unlike_bodies_add_no_energy(run: Run) -> Comparison:
    """Unlike soft bodies that collide add no energy above second order.

    They are coarse or fine, touch by edges and all, with friction or without, of any restitution, by any integrator.
    They never have more energy than at the start, but for at most (ω h)² / 20 of the kinetic energy. There ω is the
    highest frequency.
    """
    rng, answers = run.fresh_rng(), Answers()
    for k in range(run.count(5, 20, 250)):
        integrator, part = STEPS[k % len(STEPS)]
        case = collision(rng, integrator, part, 0.3 * (k % 2))
        behind = 0.5 * case.step if integrator == "symplectic_euler" else 0.0
        start, most = accounts.energy(case.world, behind), 0.0
        while case.world.time < SECONDS:
            case.world.step(case.step, max(1, int(LOOK / case.step)))
            most = np.maximum(most, accounts.energy(case.world, behind) - start)
        gained = most / case.kinetic / (LIMITS[integrator] * part) ** 2
        answers.add(gained, 0.0, kind=f"{integrator}, {part} of the stable step")
    return answers.comparison()


def crowd(rng: np.random.Generator) -> World:
    """Return 2 to 5 soft bodies and up to 3 boxes that fly at each other, without weight: all of them unlike."""
    world = weightless(integrator="symplectic_euler", gyroscopic=True)
    soft, boxes = int(rng.integers(2, 6)), int(rng.integers(0, 4))
    places = apart(rng, soft + boxes)
    for place in places[:soft]:
        mesh, mass = rotated(MESHES[rng.integers(len(MESHES))], rng), float(np.exp(rng.uniform(-1.0, 1.0)))
        e, friction = rng.random(), rng.uniform(0.0, 0.6)
        world.add_soft_body(mesh, mass, STIFFNESS, GAS, place, restitution=e, friction=friction, damping=0.0)
    world.equilibrium()
    for body, place in zip(world.soft_bodies, places, strict=False):
        body.velocities[:] = -0.8 * place + 0.2 * rng.normal(size=3)
    for place in places[soft:]:
        size, mass = rng.uniform(0.3, 0.8, 3), float(np.exp(rng.uniform(-1.0, 1.0)))
        turn, e, friction = random_orientations(rng, 1)[0], rng.random(), rng.uniform(0.0, 0.6)
        spin = rng.normal(size=3)
        world.add_box(size, mass, place, turn, -0.8 * place, spin, restitution=e, friction=friction)
    return world


def apart(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return places (count, 3) [m] that are 1.5 m apart and more, in a cube of 5 m."""
    places: list[np.ndarray] = []
    while len(places) < count:
        place = rng.uniform(-2.5, 2.5, 3)
        if all(np.linalg.norm(place - other) > 1.5 for other in places):
            places.append(place)
    return np.array(places)


def drift_and_gain(world: World, step: float) -> tuple[float, float]:
    """Return how much of all angular momentum is lost in 2 s, and of the kinetic energy gained at most."""
    before, start, most = accounts.of_each(world), accounts.energy(world), 0.0
    moments, kinetic = np.array([one.angular_momentum for one in before]), sum(one.kinetic for one in before)
    while world.time < 2.0:
        world.run(0.01, step)
        most = np.maximum(most, accounts.energy(world) - start)
    drift = np.linalg.norm(accounts.angular_momentum(world) - moments.sum(axis=0))
    return float(drift / np.linalg.norm(moments, axis=1).sum()), float(most / kinetic)


@check(
    section="4.2, 4.3",
    piece=RESPONSE,
    reference="invariants; springs and gas by SciPy's judge, boxes by their inertia, in NumPy",
    engines=("scipy",),
    unit="of the angular momenta; of a thousandth of the kinetic energy",
    kind="invariant",
    tolerance=2e-5,
    because="later sweeps add moment of second order: 1e-9 in most worlds, 7e-6 at worst of 18; energy in 2 s: 6e-11",
    faults=(STRUCK_WHERE_IT_IS, FASTER),
)
def crowds_keep_what_they_must(run: Run) -> Comparison:
    """Crowds of unlike bodies gain no energy and keep angular momentum.

    Worlds of 2 to 5 soft bodies and up to 3 boxes that spin fly at each other, with any restitution and friction. They
    never have more energy than at the start.
    """
    rng, answers = run.fresh_rng(), Answers()
    for k in range(run.count(3, 6, 60)):
        world = crowd(rng)
        drift, gain = drift_and_gain(world, (0.05, 0.3)[k % 2] * world.stable_time_step())
        answers.add(drift, 0.0, kind="angular momentum")
        answers.add(gain / 1e-3, 0.0, kind="energy")
    return answers.comparison()
