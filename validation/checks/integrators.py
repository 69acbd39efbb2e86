"""The three integrators, on motions of real soft bodies that have an answer in one variable."""

from __future__ import annotations

import numpy as np

import softbody
from softbody import Mesh, World
from softbody.dynamics.integrators import INTEGRATORS
from validation.cases import lumpy_sphere
from validation.check import Comparison, Misprint, Run, check

FAMILY = "integrators"
PIECE = "softbody.dynamics.integrators"

STIFFNESS = 40.0


def breathing(integrator: str, mesh: Mesh, gas: float, scale: float) -> tuple[World, float, float]:
    """Return a regular solid, let go at `scale` times its rest size, with its K = k Σ l0² and M = Σ m |x|².

    By symmetry it only swells and shrinks: M λ'' = −K (λ − 1) + 3nRT/λ, a harmonic oscillator without gas.
    """
    world = World(gravity=(0.0, 0.0, 0.0), integrator=integrator)
    body = world.add_soft_body(mesh, mass=1.0, stiffness=STIFFNESS, gas=gas)
    moment = (mesh.vertices**2).sum() / len(mesh.vertices)
    body.positions[:] = scale * mesh.vertices
    return world, STIFFNESS * (world.model.rest_length**2).sum(), moment


def scale_of(world: World, mesh: Mesh) -> float:
    """Return λ: the shape's projection on the rest shape."""
    return float((world.state.position * mesh.vertices).sum() / (mesh.vertices**2).sum())


def rate_of(world: World, mesh: Mesh) -> float:
    """Return dλ/dt [1/s]."""
    return float((world.state.velocity * mesh.vertices).sum() / (mesh.vertices**2).sum())


@check(
    family=FAMILY,
    claim="On a harmonic oscillator each integrator multiplies the state by its own closed-form matrix, each step.",
    section="5.1",
    piece=PIECE,
    reference="amplification matrices in ωh, derived by hand",
    unit="of the amplitude",
    tolerance=2e-13,
    because="100 steps of rounding at 1e-16, on an amplitude of a tenth of the size",
    detects="a wrong weight or stage: damping, order and stability of all three follow from these matrices",
)
def amplification(run: Run) -> Comparison:
    from references import analytic

    rng = run.rng
    measured, expected, kinds = [], [], []
    for integrator in INTEGRATORS:
        for z in rng.uniform(0.02, 1.8, run.count(5, 30, 300)):
            mesh = softbody.octahedron()
            world, stiffness, moment = breathing(integrator, mesh, gas=0.0, scale=1.1)
            frequency = np.sqrt(stiffness / moment)
            matrix = analytic.amplification_matrix(integrator, z)
            state = np.array([0.1, 0.0])
            for _ in range(5):
                world.step(z / frequency, 20)
                state = np.linalg.matrix_power(matrix, 20) @ state
                measured.append([scale_of(world, mesh) - 1.0, rate_of(world, mesh) / frequency])
                expected.append(state)
                kinds.append(integrator)
    return Comparison(np.array(measured), np.array(expected), 0.1, kinds)


@check(
    family=FAMILY,
    claim="The paper's scheme loses the part 1 − √det of the amplitude a step, close to (ωh)²/4; the others do not.",
    section="5.1",
    piece=PIECE,
    reference="closed form: √det of the amplification matrix",
    unit="relative amplitude a step",
    tolerance=2e-14,
    because="the decay over 10 to 500 steps, measured on a rounded trajectory",
    detects="a scheme that damps otherwise than it should, by 2e-14 a step",
)
def damping(run: Run) -> Comparison:
    from references import analytic

    measured, expected, kinds = [], [], []
    for integrator in INTEGRATORS:
        for z in np.linspace(0.02, 1.0, run.count(5, 20, 100)):
            mesh = softbody.octahedron()
            area = []
            for start, kick in ((1.1, 0.0), (1.0, 0.1)):
                world, stiffness, moment = breathing(integrator, mesh, gas=0.0, scale=start)
                frequency = np.sqrt(stiffness / moment)
                world.state.velocity[:] = kick * frequency * mesh.vertices
                # So few steps that the amplitude, which may fall by z²/4 a step, stays well above rounding.
                steps = int(np.clip(10.0 / z**2, 10, 500))
                world.step(z / frequency, steps)
                area.append([scale_of(world, mesh) - 1.0, rate_of(world, mesh) / frequency])
            # The area that two trajectories span in phase space shrinks by det a step.
            measured.append((np.linalg.det(area) / 0.01) ** (0.5 / steps))
            expected.append(np.sqrt(np.linalg.det(analytic.amplification_matrix(integrator, z))))
            kinds.append(integrator)
    return Comparison(measured, expected, groups=kinds)


@check(
    family=FAMILY,
    claim="Observed orders: 1 for the paper's scheme, 4 for classical Runge–Kutta, 1 for symplectic Euler.",
    section="5.1",
    piece=PIECE,
    reference="SciPy DOP853 on the scalar equation of a breathing, gas-filled solid",
    engines=("scipy",),
    unit="order",
    tolerance=0.005,
    because="terms of the next order in h, at the steps used (ωh from 0.02 to 0.001)",
    detects="an order that differs by 0.005; the paper calls its scheme fourth order (E9)",
)
def observed_order(run: Run) -> Comparison:
    from references import scipy

    measured, expected, kinds = [], [], []
    finest = run.count(7, 8, 9)
    for name in ("tetrahedron", "octahedron", "icosahedron"):
        mesh = getattr(softbody, name)()
        for integrator, order in (("rk4_velocity", 1.0), ("rk4", 4.0), ("symplectic_euler", 1.0)):
            errors = []
            levels = (finest - 1, finest) if order < 2.0 else (3, 4)
            for level in levels:
                world, stiffness, moment = breathing(integrator, mesh, gas=20.0, scale=1.05)
                seconds = 1.5 * np.sqrt(moment / stiffness)
                steps = 10 * 2**level
                world.step(seconds / steps, steps)
                truth, _ = scipy.scale_motion(np.array([seconds]), 1.05, 0.0, moment, stiffness, 20.0)
                errors.append(abs(scale_of(world, mesh) - truth[0]))
            measured.append(np.log2(errors[0] / errors[1]))
            expected.append(order)
            kinds.append(integrator)
    return Comparison(measured, expected, groups=kinds)


@check(
    family=FAMILY,
    claim="A gas-filled tetrahedron, octahedron or icosahedron breathes as its one scalar equation of motion says.",
    section="2, 5.1",
    piece="softbody.dynamics.soft.soft_accelerations",
    reference="SciPy DOP853 at 1e-13",
    engines=("scipy",),
    unit="of the scale",
    tolerance=5e-12,
    because="rk4 at ωh = 2e-3 errs by 1e-12; DOP853 by 1e-13",
    detects="an error of 5e-12 in the motion over up to one and a half periods",
)
def breathing_motion(run: Run) -> Comparison:
    from references import scipy

    rng = run.rng
    measured, expected, kinds = [], [], []
    for _ in range(run.count(2, 10, 60)):
        for name in ("tetrahedron", "octahedron", "icosahedron"):
            mesh = getattr(softbody, name)()
            gas, start = rng.uniform(1.0, 40.0), rng.uniform(0.9, 1.3)
            world, stiffness, moment = breathing("rk4", mesh, gas, start)
            seconds = rng.uniform(1.0, 10.0) * np.sqrt(moment / stiffness)
            steps = int(np.ceil(seconds * np.sqrt(stiffness / moment) / 2e-3))
            world.step(seconds / steps, steps)
            measured.append(scale_of(world, mesh))
            expected.append(scipy.scale_motion(np.array([seconds]), start, 0.0, moment, stiffness, gas)[0][0])
            kinds.append(name)
    return Comparison(measured, expected, groups=kinds)


@check(
    family=FAMILY,
    claim="Momentum is conserved by all three; angular momentum by symplectic Euler, while a body shakes and spins.",
    section="5.1",
    piece=PIECE,
    reference="invariant",
    unit="of Σ m |v|, of Σ m |x| |v|",
    tolerance=2e-14,
    because="2 000 steps of rounding at 1e-16, as a random walk over 162 particles",
    detects="a stage that treats two particles differently; a force that is not central",
)
def momentum(run: Run) -> Comparison:
    rng = run.rng
    before, after, scales, kinds = [], [], [], []
    for integrator in INTEGRATORS:
        for _ in range(run.count(1, 4, 20)):
            mesh = lumpy_sphere(rng, 2)
            world = World(gravity=(0.0, 0.0, 0.0), integrator=integrator)
            body = world.add_soft_body(mesh, mass=2.0, stiffness=100.0, gas=50.0)
            spin = np.cross(rng.normal(size=3), mesh.vertices)
            body.velocities[:] = spin + rng.normal(size=3) + 0.1 * rng.normal(size=mesh.vertices.shape)
            momentum_scale = (np.linalg.norm(body.velocities, axis=1) / world.model.inverse_mass).sum()
            pairs = [("momentum", world.linear_momentum)]
            if integrator == "symplectic_euler":
                pairs.append(("angular momentum", world.angular_momentum))
            start = [measure() for _, measure in pairs]
            world.step(0.5 * world.stable_time_step(), 2000)
            for (what, measure), first in zip(pairs, start):
                before.append(first)
                after.append(measure())
                scales.append(momentum_scale * np.ptp(mesh.vertices, axis=0).max())
                kinds.append(f"{what}, {integrator}")
    return Comparison(np.array(after), np.array(before), np.array(scales), kinds)


def _fall(integrator: str, height: float, speed: float, h: float, steps: int, g: float) -> float:
    """Return the height after `steps` steps of free fall, by the closed form of each integrator."""
    t = steps * h
    exact = height + speed * t - 0.5 * g * t * t
    # The first-order schemes move with the velocity of the step's end: they fall g h t / 2 farther.
    return exact if integrator == "rk4" else exact - 0.5 * g * h * t


@check(
    family=FAMILY,
    claim="The centre of a thrown, shaking soft body falls exactly as each integrator's own closed form says.",
    section="5.1",
    piece=PIECE,
    reference="closed forms of free fall",
    unit="of the distance",
    tolerance=1e-14,
    because="1 000 steps of rounding on a mean of 162 particles",
    detects="gravity applied in the wrong stage, or twice",
)
def free_fall(run: Run) -> Comparison:
    rng = run.rng
    measured, expected, kinds = [], [], []
    steps, g = 1000, 9.81
    for integrator in INTEGRATORS:
        for _ in range(run.count(1, 5, 20)):
            world = World(gravity=(0.0, 0.0, -g), integrator=integrator)
            velocity = rng.normal(size=3)
            body = world.add_soft_body(lumpy_sphere(rng, 2), mass=1.0, stiffness=100.0, gas=20.0, velocity=velocity)
            height = body.centre[2]
            h = 0.5 * world.stable_time_step()
            world.step(h, steps)
            measured.append(body.centre[2])
            expected.append(_fall(integrator, height, velocity[2], h, steps, g))
            kinds.append(integrator)
    return Comparison(measured, expected, np.abs(expected), kinds)


@check(
    family=FAMILY,
    claim="A falling soft body gains the speed g t.",
    section="5.1",
    piece=PIECE,
    reference="closed form",
    unit="m/s",
    tolerance=1e-14,
    because="ten steps of rounding on a mean of 162 particles",
    detects="a velocity that is not advanced by h times an acceleration",
    erratum=Misprint(
        "E8",
        "v' = v + (v0 + 2 v1 + 2 v2 + v3)/6: the mean of the four velocities is added",
        "v' = v + h (a0 + 2 a1 + 2 a2 + a3)/6",
    ),
)
def speed_of_a_fall(run: Run) -> Comparison:
    from references import printed

    rng = run.rng
    measured, expected, misprinted, kinds = [], [], [], []
    steps, gravity = 10, np.array([0.0, 0.0, -9.81])
    for integrator in INTEGRATORS:
        for _ in range(run.count(2, 10, 50)):
            world = World(gravity=gravity, integrator=integrator)
            start = rng.normal(size=3)
            body = world.add_soft_body(lumpy_sphere(rng, 2), mass=1.0, stiffness=100.0, gas=20.0, velocity=start)
            h = 0.5 * world.stable_time_step()
            world.step(h, steps)
            measured.append(body.velocities.mean(axis=0))
            expected.append(start + gravity * h * steps)
            position, velocity = np.zeros(3), start
            for _ in range(steps):
                position, velocity = printed.mean_of_velocities(lambda x: gravity, position, velocity, h)
            misprinted.append(velocity)
            kinds.append(integrator)
    return Comparison(np.array(measured), np.array(expected), 1.0, kinds, np.array(misprinted))
