"""The three integrators, on motions of real soft bodies that have an answer in one variable."""

from __future__ import annotations

from functools import partial
from itertools import product

import numpy as np

import softbody
from references import analytic, printed
from softbody import Mesh, SoftBody
from softbody.dynamics import integrators, one_ring_forces, stability, vertex_rings
from softbody.model.settings import INTEGRATORS
from validation import accounts
from validation.answers import Answers
from validation.cases import lumpy_sphere
from validation.check import Comparison, Misprint, Run, check
from validation.checks.soft.cases import PRESSURE, regular_solids, springs_of, weightless
from validation.fault import Fault

FAMILY = "integrators"

WRONG_WEIGHT = Fault(
    "a wrong weight in the paper's integrator",
    integrators.rk4_velocity_stage,
    "load_lanes(sums_, i_) + (a_ + a_) → load_lanes(sums_, i_) + 1.999999999 * a_",
)
WEIGHT_BY_A_THOUSANDTH = Fault(
    "a weight in the paper's integrator off by a thousandth",
    integrators.rk4_velocity_stage,
    "load_lanes(sums_, i_) + (a_ + a_) → load_lanes(sums_, i_) + 2.001 * a_",
)
LAST_VELOCITY = Fault(
    "rk4 moves with the last velocity instead of the mean",
    integrators.rk4_stage,
    "sixth_ * load_lanes(shift_, i_) → 1.5 * sixth_ * load_lanes(shift_, i_)",
)
PIECE = "softbody.dynamics.integrators"
check_scheme = partial(check, section="5.1", piece=PIECE)

ORDERS = {"rk4_velocity": 1, "rk4": 4, "symplectic_euler": 1}
LIMITS = {"rk4_velocity": 2.0, "rk4": 2.0 * np.sqrt(2.0), "symplectic_euler": 2.0}  # of ωh


class Breathing:
    """A regular solid, let go at `scale` times its rest size, or kicked: by symmetry it only swells and shrinks.

    M λ'' = −K (λ − 1) + 3nRT/λ, with K = k Σ l0² and M = Σ m |x|²: a harmonic oscillator without gas.
    """

    def __init__(
        self, integrator: str, mesh: Mesh, gas: float, scale: float, kick: float = 0.0, precision: str = "double"
    ) -> None:
        self.mesh, self.world = mesh, weightless(integrator=integrator, precision=precision)
        self.body = self.world.add_soft_body(mesh, mass=1.0, stiffness=40.0, gas=gas, damping=0.0)
        self.stiffness = 40.0 * (self.world.model.edge_rest_length**2).sum()  # K
        self.moment = (mesh.vertices**2).sum() / len(mesh.vertices)  # M
        self.frequency = np.sqrt(self.stiffness / self.moment)
        self.body.positions[:] = scale * mesh.vertices
        self.body.velocities[:] = kick * self.frequency * mesh.vertices

    @property
    def scale(self) -> float:
        """λ: the shape's projection on the rest shape."""
        return float((self.body.positions * self.mesh.vertices).sum() / (self.mesh.vertices**2).sum())

    def after(self, phase: float, steps: int = 1) -> np.ndarray:
        """Return (λ − 1, λ'/ω) after so many steps of `phase` (ωh)."""
        self.world.step(phase / self.frequency, steps, allow_unstable=True)
        rate = float((self.body.velocities * self.mesh.vertices).sum() / (self.mesh.vertices**2).sum())
        return np.array([self.scale - 1.0, rate / self.frequency])


@check_scheme(
    reference="amplification matrices in ωh, derived by hand",
    unit="of the amplitude",
    kind="closed form",
    tolerance=2e-13,
    because="100 steps of rounding at 1e-16, on an amplitude of a tenth of the size",
    faults=(WRONG_WEIGHT,),
)
def amplification(run: Run) -> Comparison:
    """Each step multiplies a harmonic oscillator's state by the integrator's closed-form matrix."""
    rng, answers = run.fresh_rng(), Answers()
    for integrator in INTEGRATORS:
        for z in rng.uniform(0.02, 1.8, run.count(5, 30, 300)):
            solid, state = Breathing(integrator, softbody.octahedron(), 0.0, 1.1), np.array([0.1, 0.0])
            for _ in range(5):
                state = np.linalg.matrix_power(analytic.amplification_matrix(integrator, z), 20) @ state
                answers.add(solid.after(z, 20), state, 0.1, integrator)
    return answers.comparison()


@check_scheme(
    reference="closed form: √det of the amplification matrix",
    unit="relative amplitude a step",
    kind="closed form",
    tolerance=1e-14,
    because="the decay over 10 to 500 steps, measured on a rounded trajectory",
    faults=(WRONG_WEIGHT,),
)
def damping(run: Run) -> Comparison:
    """The paper's scheme loses 1 − √det of the amplitude a step.

    That is close to (ωh)²/4; the others do not.
    """
    answers = Answers()
    for integrator, z in product(INTEGRATORS, np.linspace(0.02, 1.0, run.count(5, 20, 100))):
        # So few steps that the amplitude, which may fall by z²/4 a step, stays well above rounding.
        steps = int(np.clip(10.0 / z**2, 10, 500))
        area = [
            Breathing(integrator, softbody.octahedron(), 0.0, scale, kick).after(z, steps)
            for scale, kick in ((1.1, 0.0), (1.0, 0.1))
        ]
        # The area that two trajectories span in phase space shrinks by det a step.
        left = (np.linalg.det(area) / 0.01) ** (0.5 / steps)
        answers.add(left, np.sqrt(np.linalg.det(analytic.amplification_matrix(integrator, z))), kind=integrator)
    return answers.comparison()


@check_scheme(
    reference="SciPy DOP853 on the scalar equation of a breathing, gas-filled solid",
    engines=("scipy",),
    unit="order",
    tolerance=0.005,
    because="terms of the next order in h, at the steps used (ωh from 0.02 to 0.001)",
    faults=(LAST_VELOCITY,),
    erratum=Misprint("E9", "the scheme is called a fourth-order Runge–Kutta", "its order is 1"),
)
def observed_order(run: Run) -> Comparison:
    """Integrators have orders 1 (paper's), 4 (classical Runge–Kutta) and 1 (symplectic Euler)."""
    from references import scipy

    answers, finest = Answers(), run.count(7, 8, 9)
    for (_, mesh), (integrator, order) in product(regular_solids(), ORDERS.items()):
        errors = []
        for level in (3, 4) if order == 4 else (finest - 1, finest):
            solid = Breathing(integrator, mesh, 20.0, 1.05)
            seconds, steps = 1.5 * np.sqrt(solid.moment / solid.stiffness), 10 * 2**level
            solid.world.step(seconds / steps, steps)
            truth, _ = scipy.scale_motion(np.array([seconds]), 1.05, 0.0, solid.moment, solid.stiffness, 20.0)
            errors.append(abs(solid.scale - truth[0]))
        answers.add(np.log2(errors[0] / errors[1]), order, kind=integrator)
    return answers.comparison(printed=[4.0, 4.0, 1.0] * 3)


@check_scheme(
    reference="closed forms −(t cos t + sin t)/4, t sin t/120 and −sin(t)/2 on x'' = −x",
    unit="of 1",
    kind="closed form",
    tolerance=1e-4,
    because="terms of two more orders in h, after one extrapolation, from ωh = 0.05 and 0.025 on",
    faults=(WEIGHT_BY_A_THOUSANDTH,),
)
def error_constant(run: Run) -> Comparison:
    """Each integrator's error over h^order tends to its modified equation's constant."""
    answers, mesh = Answers(), softbody.octahedron()
    times = run.fresh_rng().uniform(0.5, 6.0, run.count(2, 8, 40))
    for t, (integrator, order) in product(times, ORDERS.items()):
        constants = []
        least = int(np.ceil(t / (0.05 if order == 4 else 0.001)))
        for steps in (least, 2 * least):
            solid = Breathing(integrator, mesh, 0.0, 1.1)
            solid.world.step(t / solid.frequency / steps, steps)
            constants.append((10.0 * (solid.scale - 1.0) - np.cos(t)) / (t / steps) ** order)
        # The first neglected term is one order higher, for the rotation of rk4 too.
        answers.add(2.0 * constants[1] - constants[0], analytic.leading_error(integrator, t), kind=integrator)
    return answers.comparison()


@check_scheme(
    reference="closed form: where an eigenvalue of the amplification matrix leaves the unit circle",
    unit="ωh",
    kind="closed form",
    least=3,
    tolerance=1e-7,
    because="the growth that tells unstable from stable is measured to 1e-12 a step",
    faults=(WEIGHT_BY_A_THOUSANDTH,),
)
def stability_limit(run: Run) -> Comparison:
    """Integrators are stable just up to ωh = 2, 2√2 and 2."""
    answers = Answers()
    for (_, mesh), (integrator, limit) in product(regular_solids()[: run.count(1, 2, 3)], LIMITS.items()):
        low, high = 1.5, 3.2
        while high - low > 1e-8:
            z = 0.5 * (low + high)
            columns = [
                Breathing(integrator, mesh, 0.0, 1.0 + stretch, kick).after(z) / 0.1
                for stretch, kick in ((0.1, 0.0), (0.0, 0.1))
            ]
            grows = np.abs(np.linalg.eigvals(np.array(columns).T)).max() > 1.0 + 1e-9
            low, high = (low, z) if grows else (z, high)
        answers.add(low, limit, kind=integrator)
    return answers.comparison()


@check(
    section="5.1",
    piece="softbody.dynamics.stability",
    reference="eigenvalues of the Hessian, by SciPy's side on its own formula",
    engines=("scipy",),
    unit="wrong answers",
    least=4,
    tolerance=0.0,
    because="yes or no; the estimate is an upper bound of the frequency",
    faults=(
        Fault(
            "springs and gas a tenth of what they are in the stable step",
            stability.highest_frequency,
            "springs_ + abs(pressure_) * gas_ → 0.1 * springs_ + 0.1 * abs(pressure_) * gas_",
        ),
    ),
)
def stable_step(run: Run) -> Comparison:
    """The stable step told is never longer than the highest frequency allows."""
    from references import scipy

    rng, answers, ratios = run.fresh_rng(), Answers(), []
    for _ in range(run.count(4, 12, 60)):
        mesh = lumpy_sphere(rng, 1)
        stiffness = 10.0 ** rng.uniform(0.0, 3.0) * rng.uniform(0.5, 2.0, len(mesh.edges))
        gas = 10.0 ** rng.uniform(-1.0, 3.0)
        world = softbody.World(integrator="symplectic_euler")
        body = world.add_soft_body(mesh, mass=2.0, stiffness=stiffness, gas=gas, damping=0.0)
        body.positions[:] *= rng.uniform(0.95, 1.3)
        highest = scipy.highest_frequency(body.positions, *springs_of(world), mesh.triangles, gas, 2.0 / 42)
        ratios.append(world.stable_time_step() / (2.0 / highest))
        answers.add(ratios[-1] <= 1.0 + 1e-9, True)
    note = f"the step told is {min(ratios):.2f} to {max(ratios):.2f} of the longest that is stable"
    return answers.comparison(notes=[note])


@check(
    section="2",
    piece=PIECE,
    reference="closed form",
    kind="closed form",
    tolerance=3e-9,
    because="the amplitude of 1e-5 shifts it by 1e-10, rounding by 1e-11: 3.2e-10 at worst of ten seeds and at full",
    faults=(
        Fault(
            "rest lengths off by 1e-5",
            vertex_rings.with_springs,
            "(stiffness_ * rest_length_)[edge_] → (stiffness_ * (1.0 + 1e-5) * rest_length_)[edge_]",
        ),
    ),
)
def breathing_frequency(run: Run) -> Comparison:
    """A regular solid full of gas, nudged from rest, breathes at √(E''(λ*)/M)."""
    rng, answers = run.fresh_rng(), Answers()
    for name, mesh in regular_solids(run.count(2, 10, 60)):
        gas, paths = rng.uniform(1.0, 60.0), []
        for nudge in (1e-5, -1e-5):  # the mean of both: what is even in the amplitude cancels
            solid, path = Breathing("rk4", mesh, gas, 1.0), [nudge]
            rest = float(analytic.equilibrium_scale(gas, solid.stiffness))
            truth = float(analytic.breathing_frequency(gas, solid.stiffness, solid.moment))
            solid.body.positions[:] = (rest + nudge) * mesh.vertices
            for _ in range(2):  # by a sixth of a period each: x0 + x2 = 2 x1 cos(ω t)
                solid.world.step(np.pi / 3.0 / truth / 400, 400)
                path.append(solid.scale - rest)
            paths.append(path)
        x0, x1, x2 = np.subtract(paths[0], paths[1])
        answers.add(np.arccos((x0 + x2) / (2.0 * x1)) / (np.pi / 3.0 / truth), truth, truth, name)
    return answers.comparison()


@check_scheme(
    reference="theory: 1 and 1 for the paper's scheme; 5 and at least 4 for rk4, whose error of order 4 is reversible",
    unit="order",
    kind="closed form",
    least=4,
    tolerance=0.1,
    because="terms of the next order in h",
    faults=(LAST_VELOCITY,),
)
def drift(run: Run) -> Comparison:
    """Bodies lose energy and angular momentum by the scheme's order.

    Gas-filled bodies that shake and spin, together, by the paper's scheme and by rk4.
    """
    answers = Answers()
    # Of several bodies together: of a single one the leading term may happen to be small.
    shakes = run.fresh_rng().normal(0.0, 0.05, (run.count(3, 6, 20), 2, 12, 3))
    for integrator, orders in (("rk4_velocity", (1.0, 1.0)), ("rk4", (5.0, 4.0))):
        drifts = []
        for steps in (200, 400) if integrator == "rk4" else (10_000, 20_000):
            lost = np.zeros(2)
            for shake in shakes:
                world = weightless(integrator=integrator)
                body = world.add_soft_body(softbody.icosahedron(), mass=2.0, stiffness=30.0, gas=2.0, damping=0.0)
                body.positions[:] += shake[0]
                body.velocities[:] = np.cross([0.5, 1.0, 2.0], body.positions) + shake[1]
                energy, spin = accounts.energy(world), accounts.angular_momentum(world)
                world.step(2.0 / steps, steps)
                turned = float(np.linalg.norm(accounts.angular_momentum(world) - spin))
                lost += (abs(accounts.energy(world) - energy), turned)
            drifts.append(lost)
        energy_order, momentum_order = np.log2(drifts[0] / drifts[1])
        answers.add(energy_order, orders[0], kind=f"energy, {integrator}")
        answers.add(np.minimum(momentum_order, orders[1] + 0.05), orders[1], kind=f"angular momentum, {integrator}")
    return answers.comparison()


def _lumpy(rng: np.random.Generator, integrator: str) -> SoftBody:
    """Return an undamped body of 2 kg without weight: a lumpy sphere, full of gas."""
    mesh = lumpy_sphere(rng, 2)
    return weightless(integrator=integrator).add_soft_body(mesh, mass=2.0, stiffness=100.0, gas=50.0, damping=0.0)


@check_scheme(
    reference="invariant",
    unit="of the energy put in",
    kind="invariant",
    least=2,
    tolerance=0.02,
    because="symplectic Euler's energy swings by ωh of itself, about a mean that stays",
    faults=(
        Fault(
            "symplectic Euler moves with the old velocity",
            integrators.symplectic_euler_stage,
            "load_lanes(rows_.start[c_], i_) + lead_ * u_"
            " → load_lanes(rows_.start[c_], i_) + lead_ * load_lanes(rows_.start[3 + c_], i_)",
        ),
    ),
)
def energy_gain(run: Run) -> Comparison:
    """No body gains energy at its default step.

    With the paper's scheme none does at any time; with symplectic Euler none drifts.
    """
    rng, answers = run.fresh_rng(), Answers()
    for integrator, _ in product(("rk4_velocity", "symplectic_euler"), range(run.count(1, 3, 10))):
        body = _lumpy(rng, integrator)
        world = body.world
        world.equilibrium(1e-8)
        bottom = accounts.energy(world)
        body.velocities[:] = rng.normal(0.0, 0.1, body.velocities.shape)
        energies = [accounts.energy(world) - bottom]
        for _ in range(40):
            world.step(0.5 * world.stable_time_step(), 50)
            energies.append(accounts.energy(world) - bottom)
        late, early = np.mean(energies[21:]), np.mean(energies[1:21])
        gain = np.diff(energies).max() if integrator == "rk4_velocity" else late - early
        answers.add(np.maximum(gain, 0.0) / energies[0], 0.0, kind=integrator)
    return answers.comparison()


@check(
    section="2, 5.1",
    piece="softbody.dynamics.reference_forces.plain_accelerations",
    reference="SciPy DOP853 at 1e-13",
    engines=("scipy",),
    unit="of the scale",
    tolerance=5e-12,
    because="rk4 at ωh = 2e-3 errs by 1e-12; DOP853 by 1e-13",
    faults=(PRESSURE,),
)
def breathing_motion(run: Run) -> Comparison:
    """Gas-filled regular solids breathe as their one scalar equation of motion says."""
    return breathe(run, "double", 2e-3)


def breathe(run: Run, precision: str, phase: float) -> Comparison:
    """Compare λ of regular solids after up to one and a half periods, in steps of `phase` (ω h), with SciPy's."""
    from references import scipy

    rng, answers = run.fresh_rng(), Answers()
    for name, mesh in regular_solids(run.count(2, 10, 60)):
        gas, start = rng.uniform(1.0, 40.0), rng.uniform(0.9, 1.3)
        solid = Breathing("rk4", mesh, gas, start, precision=precision)
        seconds = rng.uniform(1.0, 10.0) * np.sqrt(solid.moment / solid.stiffness)
        steps = int(np.ceil(seconds * solid.frequency / phase))
        solid.world.step(seconds / steps, steps)
        truth, _ = scipy.scale_motion(np.array([seconds]), start, 0.0, solid.moment, solid.stiffness, gas)
        answers.add(solid.scale, truth[0], kind=name)
    return answers.comparison()


@check_scheme(
    reference="invariant",
    unit="of Σ m |v|, of Σ m |x| |v|",
    kind="invariant",
    least=4,
    tolerance=1e-14,
    because="rounding at 1e-16 in each step, as a random walk over 162 particles; |x| counts the way flown",
    faults=(
        Fault(
            "springs that pull one end more than the other",
            one_ring_forces.ring_sums,
            "scale(_tension(rings_, springs_, block_, e_, start_, moving_), start_)"
            " → scale(1.001 * _tension(rings_, springs_, block_, e_, start_, moving_), start_)",
        ),
    ),
)
def momentum(run: Run) -> Comparison:
    """All integrators keep shaking, spinning bodies' momentum; symplectic Euler angular momentum too."""
    rng, answers = run.fresh_rng(), Answers()
    for integrator, _ in product(INTEGRATORS, range(run.count(1, 4, 20))):
        body = _lumpy(rng, integrator)
        world, start = body.world, body.positions.copy()
        spin = np.cross(rng.normal(size=3), start)
        body.velocities[:] = spin + rng.normal(size=3) + 0.1 * rng.normal(size=start.shape)
        scale = (np.linalg.norm(body.velocities, axis=1) / world.model.particle_inverse_mass).sum()
        before = world.linear_momentum(), world.angular_momentum()
        world.step(0.5 * world.stable_time_step(), run.count(2000, 2000, 100_000))
        size, way = np.ptp(start, axis=0).max(), float(np.linalg.norm(body.centre))
        answers.add(world.linear_momentum(), before[0], scale * size, f"momentum, {integrator}")
        if integrator == "symplectic_euler":
            kind = f"angular momentum, {integrator}"
            answers.add(world.angular_momentum(), before[1], scale * (size + way), kind)
    return answers.comparison()


def _thrown(rng: np.random.Generator, integrator: str) -> tuple[SoftBody, np.ndarray, float]:
    """Return a lumpy sphere that is thrown in any direction and falls, its velocity, and half of its stable step."""
    world, velocity = softbody.World(gravity=(0.0, 0.0, -9.81), integrator=integrator), rng.normal(size=3)
    body = world.add_soft_body(lumpy_sphere(rng, 2), 1.0, 100.0, 20.0, velocity=velocity, damping=0.0)
    return body, velocity, 0.5 * world.stable_time_step()


@check_scheme(
    reference="closed forms of free fall",
    unit="of the distance",
    kind="closed form",
    least=3,
    tolerance=1e-14,
    because="1 000 steps of rounding on a mean of 162 particles",
    faults=(
        Fault(
            "gravity off by 1e-9",
            integrators.acceleration,
            "where_less(zero_, mass_, gravity_, mass_) → where_less(zero_, mass_, gravity_ * (1.0 + 1e-9), mass_)",
        ),
    ),
)
def free_fall(run: Run) -> Comparison:
    """A thrown, spinning, shaking body's centre falls by each integrator's closed form."""
    rng, answers = run.fresh_rng(), Answers()
    steps, g = 1000, 9.81
    for integrator, _ in product(INTEGRATORS, range(run.count(1, 5, 20))):
        body, velocity, h = _thrown(rng, integrator)
        body.velocities[:] += np.cross(rng.normal(size=3), body.positions - body.centre)
        t, height = steps * h, body.centre[2]
        body.world.step(h, steps)
        end = height + velocity[2] * t - 0.5 * g * t * t
        # The first-order schemes move with the velocity of the step's end: they fall g h t / 2 farther.
        end = end if integrator == "rk4" else end - 0.5 * g * h * t
        answers.add(body.centre[2], end, np.abs(end), integrator)
    return answers.comparison()


@check_scheme(
    reference="closed form",
    unit="m/s",
    kind="closed form",
    tolerance=1e-14,
    because="ten steps of rounding on a mean of 162 particles",
    faults=(WRONG_WEIGHT,),
    erratum=Misprint(
        "E8",
        "v' = v + (v0 + 2 v1 + 2 v2 + v3)/6: the mean of the four velocities is added",
        "v' = v + h (a0 + 2 a1 + 2 a2 + a3)/6",
    ),
)
def speed_of_a_fall(run: Run) -> Comparison:
    """A falling soft body gains the speed g t."""
    rng, answers, misprinted = run.fresh_rng(), Answers(), []
    steps, gravity = 10, np.array([0.0, 0.0, -9.81])
    for integrator, _ in product(INTEGRATORS, range(run.count(2, 10, 50))):
        body, start, h = _thrown(rng, integrator)
        body.world.step(h, steps)
        answers.add(body.velocities.mean(axis=0), start + gravity * h * steps, kind=integrator)
        position, velocity = np.zeros(3), start
        for _ in range(steps):
            position, velocity = printed.mean_of_velocities(lambda x: gravity, position, velocity, h)
        misprinted.append(velocity)
    return answers.comparison(printed=misprinted)
