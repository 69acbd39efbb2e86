"""Gas against springs: the equilibrium that the core's own motion comes to, and the force it feels on the way."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import ArrayLike

import softbody
from references import analytic
from softbody import Mesh, SimulationError, SoftBody, World
from softbody.dynamics import integrators, one_ring_forces, pressure, reference_forces
from softbody.dynamics.reference_forces import add_pressure_forces, spring_virial
from softbody.geometry.polyhedron import signed_volume
from softbody.stepping import shape_at_rest as resting
from validation.answers import Answers
from validation.cases import dented_sphere, edge_lengths, lumpy_sphere, random_mesh
from validation.check import Comparison, Run, check
from validation.checks.soft.cases import (
    PRESSURE,
    SOLIDS,
    WRONG_AXES,
    regular_solids,
    springs_of,
    squared_edges,
    weightless,
)
from validation.checks.soft.soft import accelerations
from validation.fault import Fault

FAMILY = "pressure and volume"

check_forces = partial(check, piece="softbody.dynamics.one_ring_forces")


def at_rest(mesh: Mesh, stiffness: ArrayLike, gas: float) -> SoftBody:
    """Return a body without weight, for which the core has found where it comes to rest."""
    body = weightless().add_soft_body(mesh, mass=1.0, stiffness=stiffness, gas=gas)
    body.world.equilibrium(5e-15)  # of k × size: the largest force that is left
    return body


def _mean_distance(body: SoftBody) -> float:
    """Return the mean distance [m] of a body's particles from its centre."""
    return float(np.linalg.norm(body.positions - body.positions.mean(axis=0), axis=1).mean())


@check_forces(
    section="2.1, 2.3",
    reference="the identity itself: it holds at every equilibrium of every closed mesh, without a fitted constant",
    kind="closed form",
    least=4,
    tolerance=2e-12,
    because="the forces left at rest, 5e-15 k × size on each particle, do that much virtual work",
    faults=(PRESSURE,),
)
def virial_identity(run: Run) -> Comparison:
    """Closed meshes at rest fulfil the virial identity.

    Σ k (l − l0) l = 3 nRT, of spheres, tori, dented and random meshes.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 4, 30)):
        stiffness, gas = rng.uniform(50.0, 200.0), rng.uniform(20.0, 100.0)
        for kind, mesh in (
            ("sphere", softbody.icosphere(2)),
            ("torus", softbody.torus(1.0, 0.4, 24, 12)),
            ("dented sphere", dented_sphere(2)),
            ("random mesh", lumpy_sphere(rng, 2)),
        ):
            body = at_rest(mesh, stiffness, gas)
            answers.add(spring_virial(body.positions, *springs_of(body.world)), 3.0 * gas, 3.0 * gas, kind)
    return answers.comparison()


@check_forces(
    section="2.1, 2.3",
    reference="closed form: symmetry leaves one unknown",
    kind="closed form",
    tolerance=1e-14,
    because="rounding, and forces of 5e-15 k × size left at rest",
    faults=(PRESSURE,),
)
def equilibrium_scale(run: Run) -> Comparison:
    """A regular solid rests at scale λ: λ² − λ = 3nRT/Σkl0²."""
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(5, 30, 300)):
        stiffness, radius = rng.uniform(10.0, 1000.0), rng.uniform(0.3, 2.0)
        for kind, make in SOLIDS.items():
            mesh = make(radius)
            total = stiffness * squared_edges(mesh)
            gas = total / 3.0 * 10.0 ** rng.uniform(-3.0, 0.3)  # from "hardly stretched" to "nearly twice the size"
            scale = analytic.equilibrium_scale(gas, total)
            answers.add(_mean_distance(at_rest(mesh, stiffness, gas)) / radius, scale, float(scale), kind)
    return answers.comparison()


@check(
    section="2.3, 10.6",
    piece="softbody.dynamics.pressure.gas_pressure",
    reference="ideal gas law; volume by trimesh",
    engines=("trimesh",),
    least=5,
    tolerance=2e-14,
    because="both volumes round some 300 terms",
    faults=(
        PRESSURE,
        Fault("volume off by 1e-12", signed_volume, "six_volumes_ / 6.0 → six_volumes_ / 6.0 * (1.0 + 1e-12)"),
    ),
)
def ideal_gas_law(run: Run) -> Comparison:
    """Pressure as told, times trimesh's volume, is nRT, over nine decades."""
    from references import trimesh

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(5, 30, 300)):
        mesh = random_mesh(str(rng.choice(["sphere", "torus", "lumpy sphere"])), rng)
        gas = 10.0 ** rng.uniform(-3.0, 6.0)
        body = weightless().add_soft_body(mesh, mass=1.0, stiffness=100.0, gas=gas)
        answers.add(body.pressure * trimesh.volume(body.positions, mesh.triangles), gas, gas)
    return answers.comparison()


@check(
    section="2.3, 10.6",
    piece="softbody.dynamics.pressure.gas_pressure",
    reference="ideal gas law; volumes in closed form",
    kind="closed form",
    tolerance=1e-14,
    because="volumes of at most 20 triangles",
    faults=(PRESSURE,),
)
def gas_laws(run: Run) -> Comparison:
    """Boyle's law holds over twelve decades of nRT and six of V.

    P V = nRT, in which T is, of regular solids.
    """
    rng, answers = run.fresh_rng(), Answers()
    for name, mesh in regular_solids():
        body = weightless().add_soft_body(mesh, mass=1.0, stiffness=100.0, gas=1.0)
        for _ in range(run.count(20, 200, 2000)):
            radius, body.gas = 10.0 ** rng.uniform(-1.0, 1.0), 10.0 ** rng.uniform(-6.0, 6.0)
            body.positions[:] = radius * mesh.vertices
            answers.add(body.pressure * analytic.regular_solid_volume(name, radius), body.gas, body.gas, name)
    return answers.comparison()


@check_forces(
    section="2",
    reference="closed forms of the two ends, to the second order",
    kind="closed form",
    tolerance=2e-12,
    because="the next terms: q² ≤ 1e-12, and 1/(8q) of the size; rounding",
    faults=(
        Fault("gas that is always there", pressure.gas_pressure, "gas_ / volume_ → (gas_ + 1e-9) / volume_"),
        Fault(
            "springs that are stiffer by 1e-9",
            one_ring_forces._tension,
            "k_ - pull_ / square_root(square_) → k_ * (1.0 + 1e-9) - pull_ / square_root(square_)",
        ),
    ),
)
def limits(run: Run) -> Comparison:
    """Regular solids swell as closed forms of little and much gas say.

    Without gas they rest in the shape of their springs. With little, q = 3nRT/(kΣl0²) ≤ 1e-6, they are 1 + q as
    large. With very much, q ≥ 1e12, they swell as ½ + √q.
    """
    answers = Answers()
    cases = [("no gas", 0.0, 1.0)]
    cases += [("little gas", q, 1.0 + q) for q in 10.0 ** np.linspace(-9.0, -6.0, run.count(2, 5, 20))]
    cases += [("much gas", q, 0.5 + np.sqrt(q)) for q in 10.0 ** np.linspace(12.0, 15.0, run.count(2, 5, 20))]
    for _, mesh in regular_solids():
        rest_squared = (edge_lengths(mesh.vertices, mesh.edges) ** 2).sum()
        for kind, q, scale in cases:
            answers.add(_mean_distance(at_rest(mesh, 1.0, q * rest_squared / 3.0)) / scale, 1.0, kind=kind)
    return answers.comparison()


@check_forces(
    section="2",
    reference="SciPy minimiser, on one of each family",
    engines=("scipy",),
    unit="of V/V0",
    least=4,
    tolerance=2e-14,
    because="as for the shape at rest: 1.1e-15 at worst of ten seeds and of all ratios at full",
    faults=(PRESSURE,),
)
def scaling(run: Run) -> Comparison:
    """Tori at rest grow with nRT/(kΣl0²) alone, whatever their size and stiffness."""
    from references import scipy

    rng, answers = run.fresh_rng(), Answers()
    mesh = softbody.torus(1.0, 0.4, 12, 6)
    lengths = edge_lengths(mesh.vertices, mesh.edges)
    for decade in np.linspace(-3.0, -1.0, run.count(2, 4, 12)):
        gas = (lengths**2).sum() / 3.0 * 10.0**decade
        judged = scipy.equilibrium(mesh.vertices, mesh.edges, lengths, np.ones(len(lengths)), mesh.triangles, gas)
        volume = Mesh(judged.positions, mesh.triangles).volume / mesh.volume
        for _ in range(2):
            size, stiffness = 10.0 ** rng.uniform(-2.0, 2.0), 10.0 ** rng.uniform(-1.0, 4.0)
            body = at_rest(mesh.scaled(size), stiffness, gas * stiffness * size**2)
            found = Mesh(body.positions, mesh.triangles).volume / (mesh.volume * size**3)
            answers.add(found, volume, volume)
    return answers.comparison()


@check_forces(
    section="2, 5.1",
    reference="SciPy minimiser of ½ Σ k (l − l0)² − nRT ln V, on its own energy and gradient",
    engines=("scipy",),
    unit="of l0",
    tolerance=2e-14,
    because="forces of 5e-15 k × size are left by both solvers: 1.8e-15 of a length at worst of ten seeds",
    faults=(
        Fault(
            "spring force over the rest length",
            one_ring_forces._tension,
            "k_ - pull_ / square_root(square_) → 1.001 * (k_ - pull_ / square_root(square_))",
        ),
        PRESSURE,
    ),
)
def shape_at_rest(run: Run) -> Comparison:
    """A body rests in the shape of least energy that SciPy finds."""
    from references import scipy

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 3, 20)):
        for kind, mesh in (("sphere", softbody.icosphere(2)), ("torus", softbody.torus(1.0, 0.4, 16, 8))):
            body = at_rest(mesh, rng.uniform(50.0, 200.0), rng.uniform(20.0, 100.0))
            edges, lengths, stiffness = springs_of(body.world)
            judged = scipy.equilibrium(mesh.vertices, edges, lengths, stiffness, mesh.triangles, body.gas)
            # The shape may have turned or drifted as a whole: compare the lengths of the springs.
            ours, theirs = (edge_lengths(shape, edges) for shape in (body.positions, judged.positions))
            answers.extend(ours, theirs, lengths, kind)
    return answers.comparison()


@check(
    section="2, 5.1",
    piece="softbody.World.equilibrium",
    reference="SciPy minimiser of springs, gas and work, and Newton's method, on its own energy, gradient and Hessian",
    engines=("scipy",),
    unit="of the size, and m/s",
    tolerance=5e-12,
    because="forces of 1e-14 k × size are left, in modes of 1e-2 k: 2.3e-13 at worst of ten seeds, 7e-13 of more"
    " bodies",
    faults=(
        Fault("no weight at all", resting.shape_at_rest, "controls.gravity if is_held else np.zeros(3) → np.zeros(3)"),
        Fault(
            "bodies that are left as they were, but for the first",
            resting.equilibrium,
            "positions[slice(*store.model.soft_particle_start[b_:b_ + 2])] = shape"
            " → positions[: len(shape)] = shape if body == 0 else positions[: len(shape)]",
        ),
        Fault(
            "bodies that go on moving",
            resting.equilibrium,
            "assign_together((store.state.particle_position, positions), (store.state.particle_velocity, 0.0))"
            " → assign_together((store.state.particle_position, positions))",
        ),
        Fault(
            "a shape that is nearly at rest",
            resting.shape_at_rest,
            "tolerance * model.edge_stiffness.max() → 1e6 * tolerance * model.edge_stiffness.max()",
        ),
    ),
)
def hanging_and_floating(run: Run) -> Comparison:
    """`World.equilibrium` moves bodies to SciPy's shapes of least energy, and stops them.

    Of any springs: some hang on fixed particles, under their weight and forces; some float, without weight.
    """
    from references import scipy

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(2, 6, 40)):
        gravity = rng.normal(0.0, 5.0, 3)
        world, judged = World(gravity=gravity), {}
        for kind, mesh in (("hangs", softbody.icosphere(1, 0.5)), ("floats", softbody.torus(0.6, 0.25, 12, 6))):
            count, mass, gas = len(mesh.vertices), rng.uniform(0.2, 1.0), rng.uniform(5.0, 30.0)
            lengths = edge_lengths(mesh.vertices, mesh.edges) * rng.uniform(0.95, 1.05, len(mesh.edges))
            stiffness = rng.uniform(100.0, 300.0, len(mesh.edges))
            springs = mesh.edges, lengths, stiffness, mesh.triangles, gas
            pins = rng.choice(count, 4, replace=False) if kind == "hangs" else np.empty(0, int)
            body = world.add_soft_body(mesh, mass, stiffness, gas, rest_length=lengths, fixed=pins)
            body.velocities[np.setdiff1d(np.arange(count), pins)] = rng.normal(size=3)
            if kind == "hangs":
                body.external_force = force = rng.normal(size=(count, 3)) / count
                load = force + mass / count * gravity
                judged[kind] = scipy.hanging(mesh.vertices, *springs, load, pins).positions
            else:
                judged[kind] = scipy.equilibrium(mesh.vertices, *springs).positions
        world.equilibrium(1e-14)
        for body, (kind, shape) in zip(world.soft_bodies, judged.items()):
            ours, theirs = body.positions.ravel(), shape.ravel()
            if kind == "floats":  # it may have turned, or drifted
                ours, theirs = edge_lengths(body.positions, body.edges), edge_lengths(shape, body.edges)
            answers.extend(np.append(ours, np.abs(body.velocities).max()), np.append(theirs, 0.0), kind=kind)
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.World.equilibrium",
    reference="statics: nothing holds a particle but that it is fixed",
    kind="specification",
    faults=(
        Fault("forces that must act everywhere", resting._is_pulled, "force[is_free].any() → force[is_free].all()"),
        Fault("forces on what is fixed", resting._is_pulled, "force[is_free].any() → force.any()"),
        Fault(
            "the weight of what floats",
            resting.shape_at_rest,
            "controls.gravity if h_ else np.zeros(3) → controls.gravity",
        ),
    ),
)
def at_rest_without_springs(run: Run) -> Comparison:
    """A body without springs and gas rests unless it is pulled.

    A force pulls that acts on one of its particles that can move, or its weight while others are fixed. Then
    `World.equilibrium` says that it is not at rest. Nothing moves.
    """
    rng, mesh, answers = run.fresh_rng(), softbody.octahedron(0.5), Answers()
    for trial in range(run.count(36, 180, 1_800)):
        weight, pinned, push = rng.random() < 0.5, int(rng.integers(0, 6)), ("nowhere", "one", "fixed")[trial % 3]
        world, pins = World(gravity=(0.0, 0.0, -9.81 * weight)), rng.choice(6, pinned, replace=False)
        body = world.add_soft_body(mesh, 1.0, 0.0, 0.0, fixed=pins)
        body.positions = mesh.vertices * rng.uniform(0.5, 2.0, 3)
        free, force = np.setdiff1d(np.arange(6), pins), np.zeros((6, 3))
        pushed = pins if push == "fixed" else free
        if push != "nowhere" and len(pushed):
            force[rng.choice(pushed), rng.integers(3)] = rng.normal()
            body.external_force = force
        is_pulled, before = bool(force[free].any() or (weight and pinned > 0)), body.positions.copy()
        try:
            world.equilibrium()
            said = False
        except SimulationError:
            said = True
        stays, kind = (
            body.positions.tobytes() == before.tobytes(),
            f"pushed: {push}, {'held' if pinned else 'floating'}",
        )
        answers.extend([said == is_pulled, stays], [True, True], kind=kind)
    return answers.comparison()


@check(
    section="2, 5.1",
    piece="softbody.World.run",
    reference="SciPy minimiser of ½ Σ k (l − l0)² − nRT ln V, on its own energy and gradient",
    engines=("scipy",),
    unit="of l0, of the pressure, of the volume",
    tolerance=1e-14,
    because="rounding; what has not faded is less: 9e-16 at worst of five seeds",
    faults=(
        PRESSURE,
        Fault(
            "springs shorter by 1e-8",
            one_ring_forces._tension,
            "k_ - pull_ / square_root(square_) → k_ - pull_ * (1.0 - 1e-8) / square_root(square_)",
        ),
        Fault(
            "the gas pushes 1e-8 harder in motion",
            integrators._advance_body,
            "real(push / 6.0) → real(push / 5.99999994)",
        ),
    ),
)
def run_to_rest(run: Run) -> Comparison:
    """A damped, dragged body that runs comes to SciPy's shape at rest.

    In a World as it comes: to the shape of least energy, at that pressure, and in that volume.
    """
    from references import scipy

    rng, answers = run.fresh_rng(), Answers()
    shapes = {
        "sphere": softbody.icosphere(1),
        "torus": softbody.torus(1.0, 0.4, 10, 6),
        "box": softbody.box((1.0, 0.7, 1.3), 2),
    }
    for kind, mesh in [*shapes.items()] * run.count(1, 2, 10):
        gas, mass = rng.uniform(5.0, 30.0), rng.uniform(0.5, 2.0)
        stiffness = 100.0 * rng.uniform(0.8, 1.2, len(mesh.edges))
        body = weightless().add_soft_body(mesh, mass, stiffness, gas, damping=0.1, drag=2.0)
        body.world.run(40.0, 0.5 * body.world.stable_time_step())
        lengths = edge_lengths(mesh.vertices, mesh.edges)
        judged = scipy.equilibrium(mesh.vertices, mesh.edges, lengths, stiffness, mesh.triangles, gas)
        volume = Mesh(judged.positions, mesh.triangles).volume
        ours, theirs = (edge_lengths(shape, mesh.edges) / lengths for shape in (body.positions, judged.positions))
        gas_told = [body.pressure * volume / gas, body.volume / volume]
        answers.extend(np.append(ours, gas_told), np.append(theirs, [1.0, 1.0]), kind=kind)
    return answers.comparison()


@check(
    section="2.2, 10.11",
    piece="softbody.dynamics.reference_forces.add_pressure_forces",
    reference="gradient of the volume, by SciPy's side on its own formula",
    engines=("scipy",),
    unit="of the largest force",
    tolerance=5e-15,
    because="six triangles a particle, a few roundings of 1e-16 each on both sides",
    faults=(
        Fault(
            "pressure force of a triangle off by 1e-9",
            reference_forces.add_pressure_forces,
            "pressure_ / 3.0 → pressure_ / 3.0 * (1.0 + 1e-9)",
        ),
    ),
)
def force_is_gradient_of_volume(run: Run) -> Comparison:
    """The pressure force is exactly P ∂V/∂x: work is P dV."""
    from references import scipy

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(3, 10, 100)):
        mesh, pascal = lumpy_sphere(rng), 10.0 ** rng.uniform(-2.0, 5.0)
        force = np.zeros_like(mesh.vertices)
        add_pressure_forces(mesh.vertices, mesh.triangles, pascal, force)
        truth = pascal * scipy.pressure_gradient(mesh.vertices, mesh.triangles)
        answers.extend(force, truth, np.linalg.norm(truth, axis=1).max())
    return answers.comparison()


@check_forces(
    section="2",
    reference="invariant: action equals reaction",
    unit="of Σ |force| × size",
    kind="invariant",
    tolerance=3e-16,
    because="some 642 forces cancel, rounded by 1e-16 each: 2.1e-17 of their sum at worst of ten seeds, 3e-17 at full",
    faults=(WRONG_AXES,),
)
def no_net_force_or_torque(run: Run) -> Comparison:
    """Springs and gas exert no net force or torque on their body."""
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(3, 20, 200)):
        body = weightless().add_soft_body(lumpy_sphere(rng), mass=1.0, stiffness=100.0, gas=50.0)
        body.positions[:] *= rng.uniform(0.9, 1.1, body.positions.shape)
        acceleration = accelerations(body.world)
        total = np.linalg.norm(acceleration, axis=1).sum() * np.ptp(body.positions, axis=0).max()
        answers.add(acceleration.sum(axis=0) / total, np.zeros(3), kind="force")
        answers.add(np.cross(body.positions, acceleration).sum(axis=0) / total, np.zeros(3), kind="torque")
    return answers.comparison()
