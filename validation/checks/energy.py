"""Does contact make energy? Bodies of unlike meshes that collide in a World as it comes, looked at all the way."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import softbody
from softbody import SoftBody, World
from softbody.collision import soft_response
from validation.cases import rotated
from validation.check import Comparison, Run, check
from validation.fault import Fault

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

# Integrators, and parts of the stable step, at which the integrator alone keeps the energy of bodies that vibrate.
STEPS = (("rk4_velocity", 0.1), ("rk4_velocity", 0.8), ("rk4", 0.1), ("rk4", 0.8), ("symplectic_euler", 0.05))


class Collision(NamedTuple):
    """Two soft bodies that fly at each other at 2 m/s, aside of each other, without weight."""

    world: World
    bodies: tuple[SoftBody, SoftBody]
    masses: np.ndarray  # (2,) [kg]
    step: float  # [s]


def collision(rng: np.random.Generator, integrator: str, part: float, friction: float) -> Collision:
    """Return two of MESHES, turned anyhow, of unlike masses and any restitution."""
    world = World(gravity=(0.0, 0.0, 0.0), integrator=integrator)
    masses, restitution = np.exp(rng.uniform(-1.0, 1.0, 2)), rng.random(2)
    a, b = (
        world.add_soft_body(
            rotated(MESHES[rng.integers(len(MESHES))], rng), masses[k], STIFFNESS, GAS, position,
            friction=friction, restitution=restitution[k],
        )
        for k, position in enumerate(((-1.0, 0.0, 0.0), (1.0, *rng.uniform(-0.3, 0.3, 2))))
    )  # fmt: skip
    world.equilibrium()
    a.velocities[:], b.velocities[:] = (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)
    return Collision(world, (a, b), masses, part * world.stable_time_step())


def soft_energy(body: SoftBody, mass: float, gas: float) -> float:
    """Return the kinetic energy of a soft body, and that of its springs and gas by the judge [J]."""
    from references import scipy

    model, k = body.world.model, body.index
    first, edges = model.soft_particle_start[k], slice(*model.soft_edge_start[k : k + 2])
    return 0.5 * mass * float((body.velocities**2).sum(axis=1).mean()) + scipy.energy(
        body.positions, model.edge_particles[edges] - first, model.edge_rest_length[edges],
        model.edge_stiffness[edges], body.triangles, gas,
    )  # fmt: skip


def _total(case: Collision) -> float:
    return sum(soft_energy(body, mass, GAS) for body, mass in zip(case.bodies, case.masses, strict=True))


@check(
    family=FAMILY,
    claim="Unlike soft bodies that collide, coarse ones and fine ones, edges and all, with friction and without, of any"
    " restitution, never have more energy than at the start, at any step and by any integrator.",
    section="4.3",
    piece="softbody.collision.soft_response",
    reference="invariant; springs and gas by SciPy's judge",
    engines=("scipy",),
    unit="most energy gained, of the kinetic",
    tolerance=2e-3,
    because="RK4 at 0.8 of the stable step can gain 1.6e-3 as bodies ring, and symplectic Euler sways by as much at a"
    " twentieth; else 1e-12",
    detects="a bounce by more than e; parts of a mass that add up to more than all of it",
    faults=(
        Fault(
            "sides that part faster than they came",
            soft_response._lack,
            "contacts_.restitution[k_]",
            "(contacts_.restitution[k_] + 1.2)",
        ),
        Fault(
            "contacts that each have all of a particle's mass",
            soft_response._split_inverse_mass,
            "weight_ * sum_[i_] * inverse_mass_[i_]",
            "weight_ * weight_ * inverse_mass_[i_]",
        ),
    ),
)
def unlike_bodies_add_no_energy(run: Run) -> Comparison:
    rng = run.fresh_rng()
    gained, kinds = [], []
    for k in range(run.count(5, 20, 250)):
        integrator, part = STEPS[k % len(STEPS)]
        case = collision(rng, integrator, part, 0.3 * (k % 2))
        start, most = _total(case), 0.0
        while case.world.time < SECONDS:
            case.world.step(case.step, max(1, int(LOOK / case.step)))
            most = max(most, _total(case) - start)
        gained.append(most / (0.5 * case.masses.sum()))
        kinds.append(f"{integrator}, {part} of the stable step")
    return Comparison(gained, np.zeros(len(gained)), groups=kinds)
