"""Gas against springs: the equilibrium that the core's own motion comes to, and the force it feels on the way."""

from __future__ import annotations

import numpy as np

import softbody
from softbody import Mesh, World
from softbody.dynamics import pressure, springs
from softbody.dynamics.soft import soft_accelerations
from validation.cases import lumpy_sphere, random_mesh
from validation.check import Comparison, Run, check

FAMILY = "pressure and volume"

# The paper's integrator damps a mode of frequency ω by the factor 1 − (ωh)²/4 a step: just below the stable step
# it is a good solver for a shape at rest.
REST_STEP = 0.9  # of the stable time step
REST_FORCE = 5e-15  # of k × size: the largest force that is left when the shape counts as at rest
REST_ROUNDS = 100  # of 500 steps, at most


def at_rest(mesh: Mesh, stiffness: float, gas: float) -> World:
    """Return a world in which a soft body without weight has come to rest, by the core's own steps."""
    world = World(gravity=(0.0, 0.0, 0.0))
    body = world.add_soft_body(mesh, mass=1.0, stiffness=stiffness, gas=gas)
    limit = REST_FORCE * stiffness * np.ptp(mesh.vertices, axis=0).max()
    acceleration = np.empty_like(body.positions)
    for _ in range(REST_ROUNDS):
        world.step(REST_STEP * world.stable_time_step(), 500)
        soft_accelerations(world.model, world.state.position, acceleration)
        if np.abs(acceleration).max() / world.model.inverse_mass[0] < limit:
            return world
    raise RuntimeError(f"not at rest after {REST_ROUNDS * 500} steps (k = {stiffness:g} N/m, nRT = {gas:g} J)")


@check(
    family=FAMILY,
    claim="A sphere or a torus that has come to rest fulfils the virial identity Σ k (l − l0) l = 3 nRT.",
    section="2.1, 2.3",
    piece="softbody.dynamics.soft.soft_accelerations",
    reference="the identity itself: it holds at every equilibrium of every closed mesh, without a fitted constant",
    tolerance=1e-11,
    because="the forces left at rest, 5e-15 k × size on each particle, do that much virtual work",
    detects="a pressure, volume or spring force off by 1e-11; a force that is no gradient",
)
def virial_identity(run: Run) -> Comparison:
    rng = run.rng
    measured, expected, kinds = [], [], []
    for _ in range(run.count(3, 12, 100)):
        stiffness, gas = rng.uniform(50.0, 200.0), rng.uniform(20.0, 100.0)
        for kind, mesh in (("sphere", softbody.icosphere(2)), ("torus", softbody.torus(1.0, 0.4, 24, 12))):
            world = at_rest(mesh, stiffness, gas)
            model, position = world.model, world.state.position
            measured.append(springs.spring_virial(position, model.edges, model.rest_length, model.stiffness))
            expected.append(3.0 * gas)
            kinds.append(kind)
    return Comparison(measured, expected, expected, kinds)


@check(
    family=FAMILY,
    claim="A tetrahedron, octahedron or icosahedron comes to rest at the scale λ with λ² − λ = 3nRT/(k Σ l0²).",
    section="2.1, 2.3",
    piece="softbody.dynamics.soft.soft_accelerations",
    reference="closed form: symmetry leaves one unknown",
    tolerance=1e-13,
    because="rounding, and forces of 5e-15 k × size left at rest",
    detects="a relative error of 1e-13 in stiffness, rest length, volume or pressure",
)
def equilibrium_scale(run: Run) -> Comparison:
    from references import analytic

    rng = run.rng
    measured, expected, kinds = [], [], []
    for _ in range(run.count(5, 30, 300)):
        stiffness, radius = rng.uniform(10.0, 1000.0), rng.uniform(0.3, 2.0)
        for kind, make in (
            ("tetrahedron", softbody.tetrahedron),
            ("octahedron", softbody.octahedron),
            ("icosahedron", softbody.icosahedron),
        ):
            mesh = make(radius)
            i, j = mesh.edges.T
            rest_squared = ((mesh.vertices[i] - mesh.vertices[j]) ** 2).sum()
            # Gas from "hardly stretched" to "nearly twice the size".
            gas = stiffness * rest_squared / 3.0 * 10.0 ** rng.uniform(-3.0, 0.3)
            world = at_rest(mesh, stiffness, gas)
            distance = np.linalg.norm(world.state.position - world.state.position.mean(axis=0), axis=1)
            measured.append(distance.mean() / radius)
            expected.append(analytic.equilibrium_scale(gas, stiffness * rest_squared))
            kinds.append(kind)
    return Comparison(measured, expected, expected, kinds)


@check(
    family=FAMILY,
    claim="At rest the gas obeys P V = nRT, with the volume that trimesh measures.",
    section="2.3, 10.6",
    piece="softbody.dynamics.pressure.gas_pressure",
    reference="ideal gas law; volume by trimesh",
    engines=("trimesh",),
    tolerance=2e-14,
    because="both volumes round some 300 terms",
    detects="a relative error of 2e-14 in P or V",
)
def ideal_gas_law(run: Run) -> Comparison:
    from references import trimesh

    rng = run.rng
    measured, expected = [], []
    for _ in range(run.count(5, 30, 300)):
        mesh = random_mesh(str(rng.choice(["sphere", "torus", "lumpy sphere"])), rng)
        world = World(gravity=(0.0, 0.0, 0.0))
        gas = 10.0 ** rng.uniform(-3.0, 6.0)
        body = world.add_soft_body(mesh, mass=1.0, stiffness=100.0, gas=gas)
        measured.append(body.pressure * trimesh.volume(body.positions, mesh.triangles))
        expected.append(gas)
    return Comparison(measured, expected, expected)


@check(
    family=FAMILY,
    claim="The shape that a body comes to rest in is the one of least energy that SciPy finds.",
    section="2, 5.1",
    piece="softbody.dynamics.soft.soft_accelerations",
    reference="SciPy minimiser of ½ Σ k (l − l0)² − nRT ln V, on its own energy and gradient",
    engines=("scipy",),
    unit="of l0",
    tolerance=1e-11,
    because="a soft mode (10⁻³ k) turns the forces left by both solvers, 5e-15 k × size, into 5e-12 of a length",
    detects="any force of the core that is not the gradient of that energy, by 1e-11",
)
def shape_at_rest(run: Run) -> Comparison:
    from references import scipy

    rng = run.rng
    measured, expected, scales, kinds = [], [], [], []
    for _ in range(run.count(1, 3, 20)):
        for kind, mesh in (("sphere", softbody.icosphere(2)), ("torus", softbody.torus(1.0, 0.4, 16, 8))):
            stiffness, gas = rng.uniform(50.0, 200.0), rng.uniform(20.0, 100.0)
            world = at_rest(mesh, stiffness, gas)
            model = world.model
            judged = scipy.equilibrium(
                mesh.vertices, model.edges, model.rest_length, model.stiffness, mesh.triangles, gas
            )
            # The shape may have turned or drifted as a whole: compare the lengths of the springs.
            measured.append(_lengths(world.state.position, model.edges))
            expected.append(_lengths(judged.positions, model.edges))
            scales.append(model.rest_length)
            kinds += [kind] * len(model.edges)
    return Comparison(np.concatenate(measured), np.concatenate(expected), np.concatenate(scales), kinds)


def _lengths(position: np.ndarray, edges: np.ndarray) -> np.ndarray:
    return np.linalg.norm(position[edges[:, 1]] - position[edges[:, 0]], axis=1)


def _pressure_force(mesh: Mesh, pascal: float) -> np.ndarray:
    force = np.zeros_like(mesh.vertices)
    pressure.add_pressure_forces(mesh.vertices, mesh.triangles, pascal, force)
    return force


@check(
    family=FAMILY,
    claim="The pressure force on a particle is exactly P ∂V/∂x: the gas does the work P dV.",
    section="2.2, 10.11",
    piece="softbody.dynamics.pressure.add_pressure_forces",
    reference="gradient of the volume, by SciPy's side on its own formula",
    engines=("scipy",),
    unit="of the largest force",
    tolerance=5e-15,
    because="six triangles a particle, a few roundings of 1e-16 each on both sides",
    detects="a share other than a third, a missing factor ½, a wrong turn of the normal",
)
def force_is_gradient_of_volume(run: Run) -> Comparison:
    from references import scipy

    rng = run.rng
    measured, expected, scales = [], [], []
    for _ in range(run.count(3, 10, 100)):
        mesh, pascal = lumpy_sphere(rng), 10.0 ** rng.uniform(-2.0, 5.0)
        measured.append(_pressure_force(mesh, pascal))
        expected.append(pascal * scipy.pressure_gradient(mesh.vertices, mesh.triangles))
        scales.append(np.full(len(mesh.vertices), np.linalg.norm(expected[-1], axis=1).max()))
    return Comparison(np.concatenate(measured), np.concatenate(expected), np.concatenate(scales))


@check(
    family=FAMILY,
    claim="Springs and gas exert no net force and no net torque on the body that they belong to.",
    section="2",
    piece="softbody.dynamics.soft.soft_accelerations",
    reference="invariant: action equals reaction",
    unit="of Σ |force| × size",
    tolerance=1e-15,
    because="forces of some 642 particles cancel, with a rounding of 1e-16 each",
    detects="a spring or triangle that pushes one of its ends only",
)
def no_net_force_or_torque(run: Run) -> Comparison:
    rng = run.rng
    nets, kinds = [], []
    for _ in range(run.count(3, 20, 200)):
        mesh = lumpy_sphere(rng)
        world = World(gravity=(0.0, 0.0, 0.0))
        body = world.add_soft_body(mesh, mass=1.0, stiffness=100.0, gas=50.0)
        body.positions[:] *= rng.uniform(0.9, 1.1, body.positions.shape)
        acceleration = np.empty_like(body.positions)
        soft_accelerations(world.model, world.state.position, acceleration)
        total = np.linalg.norm(acceleration, axis=1).sum() * np.ptp(body.positions, axis=0).max()
        nets.append(acceleration.sum(axis=0) / total)
        nets.append(np.cross(body.positions, acceleration).sum(axis=0) / total)
        kinds += ["force", "torque"]
    return Comparison(np.array(nets), np.zeros((len(nets), 3)), groups=kinds)
