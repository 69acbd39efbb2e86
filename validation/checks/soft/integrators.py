"""The three integrators, on motions of real soft bodies that have an answer in one variable."""

from __future__ import annotations

import numpy as np

import softbody
from softbody import Mesh, World
from softbody.dynamics import integrators, one_ring_forces, pressure, stability, vertex_rings
from softbody.model.settings import INTEGRATORS
from validation import accounts
from validation.cases import lumpy_sphere
from validation.check import Comparison, Misprint, Run, check
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

STIFFNESS = 40.0


def breathing(
    integrator: str, mesh: Mesh, gas: float, scale: float, precision: str = "double"
) -> tuple[World, float, float]:
    """Return a regular solid, let go at `scale` times its rest size, with its K = k Σ l0² and M = Σ m |x|².

    By symmetry it only swells and shrinks: M λ'' = −K (λ − 1) + 3nRT/λ, a harmonic oscillator without gas.
    """
    world = World(gravity=(0.0, 0.0, 0.0), integrator=integrator, precision=precision)
    body = world.add_soft_body(mesh, mass=1.0, stiffness=STIFFNESS, gas=gas, damping=0.0)
    moment = (mesh.vertices**2).sum() / len(mesh.vertices)
    body.positions[:] = scale * mesh.vertices
    return world, STIFFNESS * (world.model.edge_rest_length**2).sum(), moment


def scale_of(world: World, mesh: Mesh) -> float:
    """Return λ: the shape's projection on the rest shape."""
    return float((world.state.particle_position * mesh.vertices).sum() / (mesh.vertices**2).sum())


def rate_of(world: World, mesh: Mesh) -> float:
    """Return dλ/dt [1/s]."""
    return float((world.state.particle_velocity * mesh.vertices).sum() / (mesh.vertices**2).sum())


@check(
    section="5.1",
    piece=PIECE,
    reference="amplification matrices in ωh, derived by hand",
    unit="of the amplitude",
    kind="closed form",
    tolerance=2e-13,
    because="100 steps of rounding at 1e-16, on an amplitude of a tenth of the size",
    faults=(WRONG_WEIGHT,),
)
def amplification(run: Run) -> Comparison:
    """On a harmonic oscillator each integrator multiplies the state by its own closed-form matrix, each step."""
    from references import analytic

    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for integrator in INTEGRATORS:
        for z in rng.uniform(0.02, 1.8, run.count(5, 30, 300)):
            mesh = softbody.octahedron()
            world, stiffness, moment = breathing(integrator, mesh, gas=0.0, scale=1.1)
            frequency = np.sqrt(stiffness / moment)
            matrix = analytic.amplification_matrix(integrator, z)
            state = np.array([0.1, 0.0])
            for _ in range(5):
                world.step(z / frequency, 20, allow_unstable=True)
                state = np.linalg.matrix_power(matrix, 20) @ state
                measured.append([scale_of(world, mesh) - 1.0, rate_of(world, mesh) / frequency])
                expected.append(state)
                kinds.append(integrator)
    return Comparison(np.array(measured), np.array(expected), 0.1, kinds)


@check(
    section="5.1",
    piece=PIECE,
    reference="closed form: √det of the amplification matrix",
    unit="relative amplitude a step",
    kind="closed form",
    tolerance=1e-14,
    because="the decay over 10 to 500 steps, measured on a rounded trajectory",
    faults=(WRONG_WEIGHT,),
)
def damping(run: Run) -> Comparison:
    """The paper's scheme loses the part 1 − √det of the amplitude a step, close to (ωh)²/4; the others do not."""
    from references import analytic

    measured, expected, kinds = [], [], []
    for integrator in INTEGRATORS:
        for z in np.linspace(0.02, 1.0, run.count(5, 20, 100)):
            mesh = softbody.octahedron()
            area = []
            for start, kick in ((1.1, 0.0), (1.0, 0.1)):
                world, stiffness, moment = breathing(integrator, mesh, gas=0.0, scale=start)
                frequency = np.sqrt(stiffness / moment)
                world.state.particle_velocity[:] = kick * frequency * mesh.vertices
                # So few steps that the amplitude, which may fall by z²/4 a step, stays well above rounding.
                steps = int(np.clip(10.0 / z**2, 10, 500))
                world.step(z / frequency, steps, allow_unstable=True)
                area.append([scale_of(world, mesh) - 1.0, rate_of(world, mesh) / frequency])
            # The area that two trajectories span in phase space shrinks by det a step.
            measured.append((np.linalg.det(area) / 0.01) ** (0.5 / steps))
            expected.append(np.sqrt(np.linalg.det(analytic.amplification_matrix(integrator, z))))
            kinds.append(integrator)
    return Comparison(measured, expected, groups=kinds)


@check(
    section="5.1",
    piece=PIECE,
    reference="SciPy DOP853 on the scalar equation of a breathing, gas-filled solid",
    engines=("scipy",),
    unit="order",
    tolerance=0.005,
    because="terms of the next order in h, at the steps used (ωh from 0.02 to 0.001)",
    faults=(LAST_VELOCITY,),
    erratum=Misprint("E9", "the scheme is called a fourth-order Runge–Kutta", "its order is 1"),
)
def observed_order(run: Run) -> Comparison:
    """Observed orders: 1 for the paper's scheme, 4 for classical Runge–Kutta, 1 for symplectic Euler."""
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
    called = [1.0 if kind == "symplectic_euler" else 4.0 for kind in kinds]
    return Comparison(measured, expected, groups=kinds, printed=called)


@check(
    section="5.1",
    piece=PIECE,
    reference="closed forms −(t cos t + sin t)/4, t sin t/120 and −sin(t)/2 on x'' = −x",
    unit="of 1",
    kind="closed form",
    tolerance=1e-4,
    because="terms of two more orders in h, after one extrapolation, from ωh = 0.05 and 0.025 on",
    faults=(WEIGHT_BY_A_THOUSANDTH,),
)
def error_constant(run: Run) -> Comparison:
    """The error of each integrator, divided by h to its order, tends to the constant of its modified equation."""
    from references import analytic

    measured, expected, kinds = [], [], []
    mesh = softbody.octahedron()
    for t in run.fresh_rng().uniform(0.5, 6.0, run.count(2, 8, 40)):
        for integrator, order in (("rk4_velocity", 1), ("rk4", 4), ("symplectic_euler", 1)):
            constants = []
            least = int(np.ceil(t / (0.05 if order == 4 else 0.001)))
            for steps in (least, 2 * least):
                world, stiffness, moment = breathing(integrator, mesh, gas=0.0, scale=1.1)
                world.step(t / np.sqrt(stiffness / moment) / steps, steps)
                error = 10.0 * (scale_of(world, mesh) - 1.0) - np.cos(t)
                constants.append(error / (t / steps) ** order)
            # The first neglected term is one order higher, for the rotation of rk4 too.
            measured.append(2.0 * constants[1] - constants[0])
            expected.append(analytic.leading_error(integrator, t))
            kinds.append(integrator)
    return Comparison(measured, expected, groups=kinds)


@check(
    section="5.1",
    piece=PIECE,
    reference="closed form: where an eigenvalue of the amplification matrix leaves the unit circle",
    unit="ωh",
    kind="closed form",
    least=3,
    tolerance=1e-7,
    because="the growth that tells unstable from stable is measured to 1e-12 a step",
    faults=(WEIGHT_BY_A_THOUSANDTH,),
)
def stability_limit(run: Run) -> Comparison:
    """The integrators are stable up to ωh = 2, 2√2 and 2, and not beyond."""
    measured, expected, kinds = [], [], []
    for name in ("tetrahedron", "octahedron", "icosahedron")[: run.count(1, 2, 3)]:
        mesh = getattr(softbody, name)()
        for integrator, limit in (("rk4_velocity", 2.0), ("rk4", 2.0 * np.sqrt(2.0)), ("symplectic_euler", 2.0)):
            low, high = 1.5, 3.2
            while high - low > 1e-8:
                z = 0.5 * (low + high)
                grows = np.abs(np.linalg.eigvals(_step_matrix(integrator, mesh, z))).max() > 1.0 + 1e-9
                low, high = (low, z) if grows else (z, high)
            measured.append(low)
            expected.append(limit)
            kinds.append(integrator)
    return Comparison(measured, expected, groups=kinds)


def _step_matrix(integrator: str, mesh: Mesh, z: float) -> np.ndarray:
    """Return the matrix (2, 2) by which one step with ωh = z maps (λ − 1, λ'/ω), by two steps of the core."""
    columns = []
    for stretch, kick in ((0.1, 0.0), (0.0, 0.1)):
        world, stiffness, moment = breathing(integrator, mesh, gas=0.0, scale=1.0 + stretch)
        frequency = np.sqrt(stiffness / moment)
        world.state.particle_velocity[:] = kick * frequency * mesh.vertices
        world.step(z / frequency, allow_unstable=True)
        columns.append([(scale_of(world, mesh) - 1.0) / 0.1, rate_of(world, mesh) / frequency / 0.1])
    return np.array(columns).T


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
    """The stable time step that the core tells is never longer than the highest frequency of the body allows."""
    from references import scipy

    rng = run.fresh_rng()
    measured, ratios = [], []
    for _ in range(run.count(4, 12, 60)):
        mesh = lumpy_sphere(rng, 1)
        stiffness = 10.0 ** rng.uniform(0.0, 3.0) * rng.uniform(0.5, 2.0, len(mesh.edges))
        gas = 10.0 ** rng.uniform(-1.0, 3.0)
        world = World(integrator="symplectic_euler")
        body = world.add_soft_body(mesh, mass=2.0, stiffness=stiffness, gas=gas, damping=0.0)
        body.positions[:] *= rng.uniform(0.95, 1.3)
        model = world.model
        highest = scipy.highest_frequency(
            body.positions, model.edge_particles, model.edge_rest_length, model.edge_stiffness, mesh.triangles, gas,
            2.0 / 42,
        )  # fmt: skip
        ratios.append(world.stable_time_step() / (2.0 / highest))
        measured.append(ratios[-1] <= 1.0 + 1e-9)
    note = f"the step told is {min(ratios):.2f} to {max(ratios):.2f} of the longest that is stable"
    return Comparison(np.array(measured), np.ones(len(measured), bool), notes=[note])


@check(
    section="2",
    piece=PIECE,
    reference="closed form",
    kind="closed form",
    tolerance=3e-9,
    because="the amplitude of 1e-5 shifts the frequency by its square, 1e-10, and rounding to 1e-16 by 1e-11: 3.2e-10"
    " at worst of ten seeds and at full",
    faults=(
        Fault(
            "rest lengths off by 1e-5",
            vertex_rings.with_springs,
            "(stiffness_ * rest_length_)[edge_] → (stiffness_ * (1.0 + 1e-5) * rest_length_)[edge_]",
        ),
    ),
)
def breathing_frequency(run: Run) -> Comparison:
    """A regular solid full of gas, nudged from rest, breathes at the frequency √(E''(λ*)/M)."""
    from references import analytic

    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for _ in range(run.count(2, 10, 60)):
        for name in ("tetrahedron", "octahedron", "icosahedron"):
            mesh, gas = getattr(softbody, name)(), rng.uniform(1.0, 60.0)
            deviations: list[list[float]] = []
            for nudge in (1e-5, -1e-5):  # the mean of both: what is even in the amplitude cancels
                world, stiffness, moment = breathing("rk4", mesh, gas, 1.0)
                rest = float(analytic.equilibrium_scale(gas, stiffness))
                truth = float(analytic.breathing_frequency(gas, stiffness, moment))
                world.state.particle_position[:] = (rest + nudge) * mesh.vertices
                path = [nudge]
                for _ in range(2):  # by a sixth of a period each: x0 + x2 = 2 x1 cos(ω t)
                    world.step(np.pi / 3.0 / truth / 400, 400)
                    path.append(scale_of(world, mesh) - rest)
                deviations.append(path)
            x0, x1, x2 = np.subtract(deviations[0], deviations[1])
            cosine = (x0 + x2) / (2.0 * x1)
            measured.append(np.arccos(cosine) / (np.pi / 3.0 / truth))
            expected.append(truth)
            kinds.append(name)
    return Comparison(measured, expected, expected, kinds)


@check(
    section="5.1",
    piece=PIECE,
    reference="theory: 1 and 1 for the paper's scheme; 5 and at least 4 for rk4, whose error of order 4 is reversible",
    unit="order",
    kind="closed form",
    least=4,
    tolerance=0.1,
    because="terms of the next order in h",
    faults=(LAST_VELOCITY,),
)
def drift(run: Run) -> Comparison:
    """Gas-filled bodies that shake and spin lose energy and angular momentum, together, by the scheme's order."""
    rng = run.fresh_rng()
    measured: list[float] = []
    expected: list[float] = []
    kinds: list[str] = []
    # Of several bodies together: of a single one the leading term may happen to be small.
    shakes = rng.normal(0.0, 0.05, (run.count(3, 6, 20), 2, 12, 3))
    for integrator, orders in (("rk4_velocity", (1.0, 1.0)), ("rk4", (5.0, 4.0))):
        drifts = []
        for steps in (200, 400) if integrator == "rk4" else (10_000, 20_000):
            lost = np.zeros(2)
            for shake in shakes:
                world = World(gravity=(0.0, 0.0, 0.0), integrator=integrator)
                body = world.add_soft_body(softbody.icosahedron(), mass=2.0, stiffness=30.0, gas=2.0, damping=0.0)
                body.positions[:] += shake[0]
                body.velocities[:] = np.cross([0.5, 1.0, 2.0], body.positions) + shake[1]
                energy, momentum = accounts.energy(world), accounts.angular_momentum(world)
                world.step(2.0 / steps, steps)
                spin = float(np.linalg.norm(accounts.angular_momentum(world) - momentum))
                lost += (abs(accounts.energy(world) - energy), spin)
            drifts.append(lost)
        energy_order, momentum_order = np.log2(drifts[0] / drifts[1])
        measured += [energy_order, np.minimum(momentum_order, orders[1] + 0.05)]
        expected += orders
        kinds += [f"energy, {integrator}", f"angular momentum, {integrator}"]
    return Comparison(measured, expected, groups=kinds)


@check(
    section="5.1",
    piece=PIECE,
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
    """At its default step no body gains energy with the paper's scheme, and none drifts with symplectic Euler."""
    rng = run.fresh_rng()
    gains, kinds = [], []
    for integrator in ("rk4_velocity", "symplectic_euler"):
        for _ in range(run.count(1, 3, 10)):
            mesh = lumpy_sphere(rng, 2)
            world = World(gravity=(0.0, 0.0, 0.0), integrator=integrator)
            body = world.add_soft_body(mesh, mass=2.0, stiffness=100.0, gas=50.0, damping=0.0)
            world.equilibrium(1e-8)
            bottom = accounts.energy(world)
            body.velocities[:] = rng.normal(0.0, 0.1, body.velocities.shape)
            energies = [accounts.energy(world) - bottom]
            for _ in range(40):
                world.step(0.5 * world.stable_time_step(), 50)
                energies.append(accounts.energy(world) - bottom)
            late, early = np.mean(energies[21:]), np.mean(energies[1:21])
            gain = np.diff(energies).max() if integrator == "rk4_velocity" else late - early
            gains.append(np.maximum(gain, 0.0) / energies[0])
            kinds.append(integrator)
    return Comparison(gains, np.zeros(len(gains)), groups=kinds)


@check(
    section="2, 5.1",
    piece="softbody.dynamics.reference_forces.plain_accelerations",
    reference="SciPy DOP853 at 1e-13",
    engines=("scipy",),
    unit="of the scale",
    tolerance=5e-12,
    because="rk4 at ωh = 2e-3 errs by 1e-12; DOP853 by 1e-13",
    faults=(Fault("pressure off by 1e-9", pressure.gas_pressure, "gas_ / volume_ → gas_ / volume_ * (1.0 + 1e-9)"),),
)
def breathing_motion(run: Run) -> Comparison:
    """A gas-filled tetrahedron, octahedron or icosahedron breathes as its one scalar equation of motion says."""
    return breathe(run, "double", 2e-3)


def breathe(run: Run, precision: str, phase: float) -> Comparison:
    """Compare λ of regular solids after up to one and a half periods, in steps of `phase` (ω h), with SciPy's."""
    from references import scipy

    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for _ in range(run.count(2, 10, 60)):
        for name in ("tetrahedron", "octahedron", "icosahedron"):
            mesh = getattr(softbody, name)()
            gas, start = rng.uniform(1.0, 40.0), rng.uniform(0.9, 1.3)
            world, stiffness, moment = breathing("rk4", mesh, gas, start, precision)
            seconds = rng.uniform(1.0, 10.0) * np.sqrt(moment / stiffness)
            steps = int(np.ceil(seconds * np.sqrt(stiffness / moment) / phase))
            world.step(seconds / steps, steps)
            measured.append(scale_of(world, mesh))
            expected.append(scipy.scale_motion(np.array([seconds]), start, 0.0, moment, stiffness, gas)[0][0])
            kinds.append(name)
    return Comparison(measured, expected, groups=kinds)


@check(
    section="5.1",
    piece=PIECE,
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
    """Momentum is conserved by all three; angular momentum by symplectic Euler, while a body shakes and spins."""
    rng = run.fresh_rng()
    before, after, scales, kinds = [], [], [], []
    for integrator in INTEGRATORS:
        for _ in range(run.count(1, 4, 20)):
            mesh = lumpy_sphere(rng, 2)
            world = World(gravity=(0.0, 0.0, 0.0), integrator=integrator)
            body = world.add_soft_body(mesh, mass=2.0, stiffness=100.0, gas=50.0, damping=0.0)
            spin = np.cross(rng.normal(size=3), mesh.vertices)
            body.velocities[:] = spin + rng.normal(size=3) + 0.1 * rng.normal(size=mesh.vertices.shape)
            momentum_scale = (np.linalg.norm(body.velocities, axis=1) / world.model.particle_inverse_mass).sum()
            pairs = [("momentum", world.linear_momentum)]
            if integrator == "symplectic_euler":
                pairs.append(("angular momentum", world.angular_momentum))
            start = [measure() for _, measure in pairs]
            world.step(0.5 * world.stable_time_step(), run.count(2000, 2000, 100_000))
            size, way = np.ptp(mesh.vertices, axis=0).max(), float(np.linalg.norm(body.centre))
            for (what, measure), first in zip(pairs, start):
                before.append(first)
                after.append(measure())
                scales.append(momentum_scale * (size + way if what == "angular momentum" else size))
                kinds.append(f"{what}, {integrator}")
    return Comparison(np.array(after), np.array(before), np.array(scales), kinds)


def _fall(integrator: str, height: float, speed: float, h: float, steps: int, g: float) -> float:
    """Return the height after `steps` steps of free fall, by the closed form of each integrator."""
    t = steps * h
    exact = height + speed * t - 0.5 * g * t * t
    # The first-order schemes move with the velocity of the step's end: they fall g h t / 2 farther.
    return exact if integrator == "rk4" else exact - 0.5 * g * h * t


@check(
    section="5.1",
    piece=PIECE,
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
    """The centre of a thrown, spinning, shaking soft body falls by each integrator's own closed form."""
    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    steps, g = 1000, 9.81
    for integrator in INTEGRATORS:
        for _ in range(run.count(1, 5, 20)):
            world = World(gravity=(0.0, 0.0, -g), integrator=integrator)
            velocity = rng.normal(size=3)
            body = world.add_soft_body(lumpy_sphere(rng, 2), 1.0, 100.0, 20.0, velocity=velocity, damping=0.0)
            body.velocities[:] += np.cross(rng.normal(size=3), body.positions - body.centre)
            height = body.centre[2]
            h = 0.5 * world.stable_time_step()
            world.step(h, steps)
            measured.append(body.centre[2])
            expected.append(_fall(integrator, height, velocity[2], h, steps, g))
            kinds.append(integrator)
    return Comparison(measured, expected, np.abs(expected), kinds)


@check(
    section="5.1",
    piece=PIECE,
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
    from references import printed

    rng = run.fresh_rng()
    measured, expected, misprinted, kinds = [], [], [], []
    steps, gravity = 10, np.array([0.0, 0.0, -9.81])
    for integrator in INTEGRATORS:
        for _ in range(run.count(2, 10, 50)):
            world = World(gravity=gravity, integrator=integrator)
            start = rng.normal(size=3)
            body = world.add_soft_body(lumpy_sphere(rng, 2), 1.0, 100.0, 20.0, velocity=start, damping=0.0)
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
