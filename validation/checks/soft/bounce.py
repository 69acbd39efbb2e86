"""A soft ball bounces off the ground: in a World, step by step, and from event to event by SciPy."""

from __future__ import annotations

import functools
import itertools
from typing import NamedTuple

import numpy as np

from softbody import Mesh, World, icosphere
from softbody.dynamics import integrators, one_ring_forces, particle_ground, pressure
from validation.answers import Answers
from validation.cases import edge_lengths, random_orientations, rotation_matrix
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "soft bodies"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

GRAVITY, SECONDS = 9.81, 0.3

check_bounce = functools.partial(
    check,
    section="2, 5.1, 9",
    piece="softbody.stepping.step.run_alone, softbody.dynamics.particle_ground",
    reference="SciPy's DOP853 between events: particles touch the ground, and leave it",
)


class Ball(NamedTuple):
    """A ball that turns, comes down on the ground and leaves it again, and where it truly ends."""

    mesh: Mesh
    radius: float  # [m]
    mass: float  # [kg]
    stiffness: np.ndarray  # (e,) [N/m]
    gas: float  # [J]
    velocity: np.ndarray  # (n, 3) [m/s]
    damping: float  # [N s/m]
    end: np.ndarray  # (n, 3) [m]


@functools.cache
def balls(seed: int, count: int, share: float) -> tuple[Ball, ...]:
    """Return balls of different sizes, masses and springs, no two springs of one alike.

    They are damped by a `share` of what is critical for two particles on the mean spring.
    """
    from references import ground

    rng, found = np.random.default_rng(seed), []
    for _ in range(count):
        radius, mass = rng.uniform(0.3, 0.8), 10.0 ** rng.uniform(-0.5, 0.5)
        sphere = icosphere(1, radius=radius)
        turned = sphere.vertices @ rotation_matrix(random_orientations(rng, 1)[0]).T
        mesh = Mesh(turned + (0.0, 0.0, 1.05 * radius), sphere.triangles)
        stiffness = mass * 10.0 ** rng.uniform(2.7, 4.0) * rng.uniform(0.7, 1.4, len(mesh.edges))
        gas, spin = mass * rng.uniform(5.0, 40.0), rng.normal(0.0, 2.0, 3)
        velocity = np.cross(spin, turned) + (0.5, 0.0, -rng.uniform(1.0, 4.0))
        springs, particle_mass = (mesh.edges, edge_lengths(mesh.vertices, mesh.edges), stiffness), mass / len(turned)
        damping = share * float(np.sqrt(2.0 * stiffness.mean() * particle_mass))
        what = mesh.vertices, velocity, springs, mesh.triangles, gas, particle_mass
        end, events = ground.bounce(*what, GRAVITY, SECONDS, damping)
        if events == 0:
            raise ValueError("a ball that does not reach the ground is no case")
        found.append(Ball(mesh, radius, mass, stiffness, gas, velocity, damping, end))
    return tuple(found)


def ends(parts: int, cases: list[tuple[Ball, World, float | None]]) -> Comparison:
    """Return where balls end, by steps of 0.8 of the stable one over `parts`, beside where they truly do.

    Cases are a ball, the world that it is added to, and with which damping [N s/m]. What it falls on is the ground, if
    the world has no box of its own.
    """
    answers = Answers()
    for ball, world, damping in cases:
        if not world.boxes:
            world.add_ground(friction=0.0)
        body = world.add_soft_body(ball.mesh, ball.mass, ball.stiffness, ball.gas, friction=0.0, damping=damping)
        body.velocities[:] = ball.velocity
        steps = parts * int(np.ceil(SECONDS / (0.8 * world.stable_time_step())))
        world.step(SECONDS / steps, steps, allow_unstable=True)
        answers.extend(body.positions, ball.end, ball.radius, world.integrator)
    return answers.comparison()


@check_bounce(
    engines=("scipy",),
    unit="of the radius",
    tolerance=6e-4,
    because="contact acts at the ends of steps, and symplectic Euler is of order 1: 2e-4 at worst of ten seeds",
    faults=(
        Fault(
            "ground that soft bodies stand two millimetres above",
            particle_ground.land,
            "position_[2, i_] = height_ → position_[2, i_] = height_ + 0.002",
        ),
        Fault(
            "particles that bounce with a tenth of their speed",
            particle_ground.bounce_particle,
            "speed_after(down_, e_) → 0.1 * down_",
        ),
        Fault(
            "particles that lose a hundredth of their slide on smooth ground",
            particle_ground.bounce_particle,
            "sliding_kept(slide_, down_, material_) → 0.99",
        ),
        Fault("gravity 1 % too weak", integrators.acceleration, "rows_.gravity[c_] → 0.99 * rows_.gravity[c_]"),
    ),
)
def balls_bounce_as_between_events(run: Run) -> Comparison:
    """A soft ball that turns and bounces ends as between events.

    It falls, undamped, of 0.3 to 3 kg, no two springs alike, by rk4 and symplectic Euler. Steps are 64 parts of 0.8 of
    the stable step.
    """
    cases = itertools.product(balls(run.seed, run.count(2, 4, 16), 0.0), ("rk4", "symplectic_euler"))
    return ends(64, [(ball, World(integrator=integrator), 0.0) for ball, integrator in cases])


@check_bounce(
    engines=("scipy",),
    unit="of the radius",
    tolerance=6e-4,
    because="as of undamped ones: 1.8e-4 at worst of ten seeds",
    faults=(
        Fault(
            "damping a tenth too weak",
            one_ring_forces._tension,
            "springs.damping * parting → 0.9 * springs.damping * parting",
        ),
        Fault("a pressure of half the gas", pressure.gas_pressure, "gas_ / volume_ → 0.5 * gas_ / volume_"),
        Fault("gravity off by a fifth", integrators.acceleration, "rows_.gravity[c_] → 0.8 * rows_.gravity[c_]"),
    ),
)
def default_balls_bounce_so_too(run: Run) -> Comparison:
    """Balls in default Worlds end where damped ones do between events.

    Integrator and damping are the defaults, and the step is made shorter: here 64 parts of 0.8 of the stable step. How
    far they are off in whole ones is noted.
    """
    cases = balls(run.seed, run.count(2, 4, 16), 0.1)
    found, whole = (ends(parts, [(ball, World(), None) for ball in cases]) for parts in (64, 1))
    off = np.linalg.norm(whole.measured - whole.expected, axis=1) / whole.scale
    found.notes.append(f"in whole steps {off.max():.2g} of the radius")
    return found
