"""Single precision, whose error is its own claim, and threads, which must change nothing."""

from __future__ import annotations

import numpy as np

import softbody
from softbody import World
from softbody.dynamics.integrators import RK4_VELOCITY
from softbody.dynamics.motion import ring_accelerations, scratch_for
from softbody.step import run_soft_bodies
from validation.cases import MESH_KINDS, lumpy_sphere, random_mesh
from validation.check import DISAGREEMENTS, Comparison, Run, check
from validation.checks.integrators import breathing, scale_of

FAMILY = "precision and threads"


@check(
    family=FAMILY,
    claim="In single precision the force on every particle is off by some ten roundings of its neighbours' places.",
    section="2, 5.1",
    piece="softbody.dynamics.ring_forces",
    reference="gradient of ½ Σ k (l − l0)² − nRT ln V, by SciPy's side in double precision",
    engines=("scipy",),
    unit="of stiffness × size",
    tolerance=5e-7,
    because="positions are rounded to 6e-8 of the size, and a particle has up to 12 springs",
    detects="a part of the force that is computed in less than single precision",
)
def single_force(run: Run) -> Comparison:
    from references import scipy

    rng = run.rng
    measured, expected, scales, kinds = [], [], [], []
    for n in range(run.count(2, 6, 40)):
        for kind in MESH_KINDS:
            mesh = random_mesh(kind, rng)
            stiffness = rng.uniform(10.0, 100.0, len(mesh.edges)) if n % 2 else 40.0
            world = World(gravity=(0.0, 0.0, 0.0), precision="single")
            body = world.add_soft_body(mesh, mass=len(mesh.vertices), stiffness=stiffness, gas=20.0)
            body.positions[:] *= rng.uniform(0.9, 1.3, 3)
            model, state = world.model, world.state
            force = np.empty_like(state.position)
            scratch = scratch_for(model, world.rings)
            ring_accelerations(model, world.rings, state.position, state.velocity, force, scratch)
            judged = scipy.forces(state.position, model.edges, model.rest_length, model.stiffness, mesh.triangles, 20.0)
            measured.append(force)
            expected.append(judged)
            scales.append(np.full(len(force), model.stiffness.max() * np.abs(state.position).max()))
            kinds += [kind] * len(force)
    return Comparison(np.concatenate(measured), np.concatenate(expected), np.concatenate(scales), kinds)


@check(
    family=FAMILY,
    claim="In single precision a gas-filled regular solid breathes as its scalar equation of motion says.",
    section="2, 5.1",
    piece="softbody.dynamics.integrators.rk4_stage",
    reference="SciPy DOP853 at 1e-13",
    engines=("scipy",),
    unit="of the scale",
    tolerance=5e-6,
    because="some 2 000 steps, each rounded at 6e-8, as a random walk that the motion amplifies",
    detects="a step that is computed in less than single precision",
)
def single_motion(run: Run) -> Comparison:
    from references import scipy

    rng = run.rng
    measured, expected, kinds = [], [], []
    for _ in range(run.count(2, 10, 60)):
        for name in ("tetrahedron", "octahedron", "icosahedron"):
            mesh = getattr(softbody, name)()
            gas, start = rng.uniform(1.0, 40.0), rng.uniform(0.9, 1.3)
            world, stiffness, moment = breathing("rk4", mesh, gas, start, precision="single")
            seconds = rng.uniform(1.0, 10.0) * np.sqrt(moment / stiffness)
            steps = int(np.ceil(seconds * np.sqrt(stiffness / moment) / 5e-3))
            world.step(seconds / steps, steps)
            measured.append(scale_of(world, mesh))
            expected.append(scipy.scale_motion(np.array([seconds]), start, 0.0, moment, stiffness, gas)[0][0])
            kinds.append(name)
    return Comparison(measured, expected, groups=kinds)


@check(
    family=FAMILY,
    claim="Any number of threads gives the same bits: many small bodies, a large one among them.",
    section="5.1",
    piece="softbody.dynamics.motion.move_on_threads",
    reference="the same run on one thread",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="shares write to places of their own, and sums go block by block in one order",
    detects="one bit; a share that is left out; two threads that meet in one place",
)
def threads_leave_every_bit(run: Run) -> Comparison:
    same, kinds = [], []
    for precision in ("double", "single")[: run.count(1, 1, 2)]:  # each is compiled for threads anew
        states = []
        for threads in (1, 2, 3):  # shares of the work, whatever the machine has to do them on
            rng = run.rng
            world = World(gravity=(0.0, 0.0, 0.0), precision=precision)
            for k in range(9):
                mesh = lumpy_sphere(rng, 5 if k == 4 else 2)
                world.add_soft_body(mesh, 1.0, 100.0, 20.0, (4.0 * k, 0.0, 0.0), damping=1e-4)
            scratch, h = scratch_for(world.model, world.rings, threads), 0.5 * world.stable_time_step()
            parts = world.model, world.rings, world.state, scratch, h, run.count(20, 50, 500), RK4_VELOCITY, 1
            run_soft_bodies(*parts, None if threads == 1 else threads)
            states.append(np.concatenate([world.state.position, world.state.velocity]))
        for other in states[1:]:
            same.append((states[0].view(np.uint64) == other.view(np.uint64)).all(axis=1))
            kinds += [precision] * len(other)
    agree = np.concatenate(same)
    return Comparison(agree, np.ones(len(agree), bool), groups=kinds)
