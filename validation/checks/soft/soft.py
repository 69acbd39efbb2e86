"""Soft bodies as a whole: the fast force, what it must not depend on, and the options that peers have."""

from __future__ import annotations

import numpy as np

import softbody
from references import analytic
from softbody import Mesh, World
from softbody.dynamics import integrators, one_ring_forces, reference_forces
from softbody.dynamics.soft_bodies import motion_of, ring_accelerations
from softbody.model.arrays import soft_bodies_of
from validation.answers import Answers
from validation.cases import MESH_KINDS, edge_lengths, lumpy_sphere, random_mesh, random_orientations, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.soft.cases import WRONG_AXES, regular_solids, springs_of, squared_edges, weightless
from validation.fault import Fault

FAMILY = "soft bodies"

NEIGHBOUR_LEFT_OUT = Fault(
    "the last neighbour of every ring is left out",
    one_ring_forces.ring_sums,
    "range(1, rings_.block[block_, DEGREE]) → range(1, rings_.block[block_, DEGREE] - 1)",
)
PIECE = "softbody.dynamics.one_ring_forces"


@check(
    section="2, 5.1",
    piece=PIECE,
    reference="gradient of ½ Σ k (l − l0)² − nRT ln V, by SciPy's side edge by edge and triangle by triangle",
    engines=("scipy",),
    unit="of the largest force",
    tolerance=5e-14,
    because="up to 24 edges a particle, rounded on both sides, that cancel near l0: 2.4e-14 at worst of two at"
    " standard",
    faults=(
        WRONG_AXES,
        NEIGHBOUR_LEFT_OUT,
    ),
)
def force_is_slope_of_energy(run: Run) -> Comparison:
    """Forces are the energy's downhill slope on any mesh, of unlike springs."""
    measured, expected, kinds, _ = forces(run, "double")
    scales = [np.full(len(judged), np.linalg.norm(judged, axis=1).max()) for judged in expected]
    return Comparison(np.concatenate(measured), np.concatenate(expected), np.concatenate(scales), kinds)


@check(
    section="2, 5.1",
    piece="softbody.dynamics.reference_forces.plain_accelerations",
    reference="gradient of ½ Σ k (l − l0)² − nRT ln V, by SciPy's side, and weight and forces by NumPy",
    engines=("scipy",),
    unit="of the largest acceleration",
    least=4,
    tolerance=3e-13,
    because="a volume some metres from the origin, and springs that cancel: 4.6e-14 at worst of ten seeds",
    faults=(
        Fault("no springs", reference_forces.plain_accelerations, "add_spring_forces(p_, e_, r_, s_, a_) → "),
        Fault(
            "weight on what is pinned",
            reference_forces.plain_accelerations,
            "controls.gravity[c] if model.particle_inverse_mass[i] > 0.0 else 0.0 → controls.gravity[c]",
        ),
        Fault(
            "forces looked up where there are none",
            reference_forces.plain_accelerations,
            "controls.particle_force.shape[0] > 0 → controls.particle_force.shape[0] >= 0",
        ),
    ),
)
def readable_form_is_slope_of_energy(run: Run) -> Comparison:
    """The readable form of accelerations is the energy's slope over the mass.

    Of several bodies with springs that differ, gas and weight, some of them pinned or pushed from outside, with what
    acts besides. It is compiled, and plain Python, which allows no index beside an array.
    """
    from references import scipy

    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(4, 12, 80)):
        world, parts = World(gravity=rng.normal(0.0, 5.0, 3)), []
        for kind in rng.choice(MESH_KINDS, 1 + trial // 2 % 2):
            mesh, mass, gas = random_mesh(kind, rng), rng.uniform(0.5, 2.0), rng.uniform(1.0, 50.0)
            count, stiffness = len(mesh.vertices), rng.uniform(10.0, 100.0, len(mesh.edges))
            pins = rng.choice(count, 2, replace=False)
            body = world.add_soft_body(mesh, mass, stiffness, gas, rng.normal(size=3), fixed=pins)
            body.positions[:] *= rng.uniform(0.9, 1.3, 3)
            lengths = edge_lengths(mesh.vertices, mesh.edges)
            force = scipy.forces(body.positions, mesh.edges, lengths, stiffness, mesh.triangles, gas)
            if trial % 2:
                body.external_force = push = rng.normal(size=(count, 3))
                force += push
            parts.append(force * count / mass + world.gravity)
            parts[-1][pins] = 0.0
        judged, kernel = np.concatenate(parts), reference_forces.plain_accelerations
        for how, form in (("compiled", kernel), ("plain Python", getattr(kernel, "py_func", kernel))):
            found = np.full(judged.shape, np.nan)
            try:
                form(world.model, world.controls, world.state.particle_position, found)
            except IndexError:
                found[:] = np.nan
            answers.extend(found, judged, np.abs(judged).max(), how)
    return answers.comparison()


def accelerations(world: World) -> np.ndarray:
    """Return (n, 3) [m/s²]: what the fast kernels make of the world as it is."""
    bodies = soft_bodies_of(world.model, world.controls, world.state)
    result = np.empty_like(bodies.position)
    ring_accelerations(bodies, motion_of(bodies.start, world.store.rings), result)
    return result


def forces(run: Run, precision: str) -> tuple[list[np.ndarray], list[np.ndarray], list[str], list[World]]:
    """Return the core's and SciPy's forces (n, 3) [N] on bodies of all kinds, their kinds, and their worlds."""
    from references import scipy

    rng = run.fresh_rng()
    measured, expected, kinds, worlds = [], [], [], []
    for n in range(run.count(2, 6, 40)):
        for kind in MESH_KINDS:
            mesh = random_mesh(kind, rng)
            stiffness = rng.uniform(10.0, 100.0, len(mesh.edges)) if n % 2 else 40.0
            worlds.append(weightless(precision=precision))
            body = worlds[-1].add_soft_body(mesh, mass=len(mesh.vertices), stiffness=stiffness, gas=20.0)
            body.positions[:] *= rng.uniform(0.9, 1.3, 3)
            measured.append(accelerations(worlds[-1]))  # of particles of 1 kg
            expected.append(scipy.forces(body.positions, *springs_of(worlds[-1]), mesh.triangles, 20.0))
            kinds += [kind] * len(mesh.vertices)
    return measured, expected, kinds, worlds


@check(
    section="2",
    piece=PIECE,
    reference="invariant: the lengths of its springs after 100 steps",
    unit="of size, or of the distance × 1e-16",
    kind="invariant",
    tolerance=5e-15,
    because="rounding: 8e-16 at worst of ten seeds; 1e6 m away a position itself is rounded to 1e-10 m",
    faults=(
        Fault(
            "gas that pushes harder along x by 1e-9",
            integrators.acceleration,
            "push_ * load_lanes(rows_.area[c_], i_)"
            " → push_ * (1.0 + (1e-9 if c_ == 0 else 0.0)) * load_lanes(rows_.area[c_], i_)",
        ),
    ),
)
def same_anywhere(run: Run) -> Comparison:
    """Bodies move the same far away, in any orientation and vertex order."""
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 4, 20)):
        mesh = lumpy_sphere(rng, 2)
        same = np.arange(len(mesh.vertices))
        turned = mesh.vertices @ rotation_matrix(random_orientations(rng, 1)[0]).T
        order = rng.permutation(len(same))
        place, far = np.argsort(order), mesh.vertices + np.array([1e6, -1e6, 1e6])
        judged = _lengths_after(mesh, mesh.vertices, same)
        answers.extend(_lengths_after(mesh, far, same), judged, 1e6, "1e6 m away")
        answers.extend(_lengths_after(mesh, turned, same), judged, 1.0, "turned")
        answers.extend(_lengths_after(mesh, mesh.vertices[order], place), judged, 1.0, "vertices in another order")
    return answers.comparison()


def _lengths_after(mesh: Mesh, vertices: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return the lengths (e,) of the mesh's edges after 100 steps of a body that starts swollen at `vertices`.

    `place` tells where among these the mesh's own are.
    """
    body = weightless().add_soft_body(Mesh(vertices, place[mesh.triangles]), mass=1.0, stiffness=100.0, gas=30.0)
    body.world.step(1e-3, 100)
    return edge_lengths(body.positions[place], mesh.edges)


@check(
    section="2",
    piece=PIECE,
    reference="theory: second order in the edge length, by the ratio of successive differences (Richardson)",
    unit="order",
    kind="closed form",
    least=2,
    tolerance=0.1,
    because="terms of fourth order, on the coarsest meshes used; more than second order counts as 2.05",
    faults=(NEIGHBOUR_LEFT_OUT,),
)
def refinement(run: Run) -> Comparison:
    """Spheres' volume and resting radius converge as edge length squared, or faster."""
    volumes, radii = [], []
    for level in range(2, run.count(4, 5, 6) + 1):
        mesh = softbody.icosphere(level)
        body = weightless().add_soft_body(mesh, mass=1.0, stiffness=20.0, gas=50.0)
        body.world.equilibrium(1e-10)
        volumes.append(mesh.volume)
        radii.append(np.linalg.norm(body.positions - body.centre, axis=1).mean())
    answers, notes = Answers(), []
    for kind, values in (("volume of the mesh", volumes), ("radius at rest", radii)):
        steps = np.diff(values)
        orders = np.log2(np.abs(steps[:-1] / steps[1:]))
        answers.extend(np.minimum(orders, 2.0 + 0.05), np.full(len(orders), 2.0), kind=kind)  # the radius: 2.4
        limit = values[-1] + steps[-1] / 3.0
        notes.append(f"{kind}: {limit:.6g} in the limit, {abs(values[-1] / limit - 1.0):.1e} off at the finest mesh")
    return answers.comparison(notes=notes)


@check(
    section="2.1",
    piece=PIECE,
    reference="closed form: M λ'' = −k Σl0² (λ − 1) − c Σl0² λ'",
    unit="of the amplitude",
    kind="closed form",
    tolerance=2e-10,
    because="rk4 at ωh = 5e-3, for up to a period",
    faults=(
        Fault(
            "damping off by 1e-8",
            one_ring_forces._tension,
            "springs.damping * parting → 1.00000001 * springs.damping * parting",
        ),
    ),
)
def damped_springs(run: Run) -> Comparison:
    """A gasless regular solid of damped springs swings as a damped oscillator."""
    rng, answers = run.fresh_rng(), Answers()
    for name, mesh in regular_solids(run.count(2, 10, 60)):
        stiffness, share = rng.uniform(10.0, 100.0), rng.uniform(0.05, 0.9)
        squared, moment = squared_edges(mesh), (mesh.vertices**2).sum() / len(mesh.vertices)
        frequency = np.sqrt(stiffness * squared / moment)
        damping = share * frequency * moment / squared
        body = weightless(integrator="rk4").add_soft_body(mesh, 1.0, stiffness, 0.0, damping=damping)
        body.positions[:] *= 1.1
        seconds = rng.uniform(0.5, 6.0) / frequency
        body.world.step(seconds / 1200, 1200)
        swing = 10.0 * ((body.positions * mesh.vertices).sum() / (mesh.vertices**2).sum() - 1.0)
        answers.add(swing, analytic.damped_oscillation(seconds, frequency, damping * squared / moment), kind=name)
    return answers.comparison()


@check(
    section="5.1",
    piece=PIECE,
    reference="closed form v = v∞ + (v0 − v∞) e^(−γt), with v∞ = F/(m γ)",
    unit="m/s, m",
    kind="closed form",
    tolerance=3e-12,
    because="rk4 at γh = 2e-3 leaves (γh)⁴/120 γt e^(−γt), 5e-14 at most, of v0 − v∞, some 15 m/s: 6.2e-13 at worst",
    faults=(
        Fault("drag off by 1e-9", one_ring_forces.add_load, "load_.drag / mass_ → 1.000000001 * load_.drag / mass_"),
    ),
)
def drag_push_and_pins(run: Run) -> Comparison:
    """Drag and steady push bring centres to terminal velocity, and pins stay."""
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(2, 8, 40)):
        mesh, rate = lumpy_sphere(rng, 1), rng.uniform(0.5, 3.0)
        start, force = rng.normal(size=3), rng.normal(size=(42, 3))
        body = weightless(integrator="rk4").add_soft_body(mesh, 2.0, 50.0, 10.0, velocity=start, drag=rate)
        body.external_force = force
        seconds = rng.uniform(0.2, 2.0)
        steps = int(np.ceil(seconds * rate / 2e-3))
        body.world.step(seconds / steps, steps)
        final = force.sum(axis=0) / 2.0 / rate
        truth = final + (start - final) * np.exp(-rate * seconds)
        answers.add(body.velocities.mean(axis=0), truth, kind="drag and push")
        fixed = rng.choice(42, 5, replace=False)
        body = World().add_soft_body(mesh, 2.0, 50.0, 10.0, velocity=start, fixed=fixed)
        body.world.step(1e-3, 200)
        answers.extend(body.positions[fixed], mesh.vertices[fixed], kind="pins")
    return answers.comparison()
