"""Single precision, whose error is its own claim, and threads, which must change nothing."""

from __future__ import annotations

import numpy as np

from softbody import World
from softbody.dynamics import soft_bodies, vertex_rings
from softbody.dynamics.soft_bodies import motion_of
from softbody.step import run_alone
from validation.cases import lumpy_sphere
from validation.check import DISAGREEMENTS, Comparison, Run, check
from validation.checks.integrators import breathe
from validation.checks.soft import forces
from validation.fault import Fault

FAMILY = "precision and threads"

HALF_PRECISION = Fault(
    "springs rounded to half precision on the way",
    vertex_rings.in_precision,
    "rings_.rest_pull.astype(real_, copy=False)",
    "rings_.rest_pull.astype(np.float16).astype(real_)",
)


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
    faults=(HALF_PRECISION,),
)
def single_force(run: Run) -> Comparison:
    measured, expected, kinds, worlds = forces(run, "single")
    units = [world.model.edge_stiffness.max() * np.abs(world.state.particle_position).max() for world in worlds]
    scales = [np.full(len(judged), unit) for judged, unit in zip(expected, units)]
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
    faults=(HALF_PRECISION,),
)
def single_motion(run: Run) -> Comparison:
    return breathe(run, "single", 5e-3)


@check(
    family=FAMILY,
    claim="Any number of threads gives the same bits: many small bodies, a large one among them.",
    section="5.1",
    piece="softbody.dynamics.soft_bodies.move_on_threads",
    reference="the same run on one thread",
    unit=DISAGREEMENTS,
    tolerance=0.0,
    because="shares write to places of their own, and sums go block by block in one order",
    detects="one bit; a share that is left out; two threads that meet in one place",
    faults=(
        Fault(
            "a thread that moves the bodies of another",
            soft_bodies.move_on_threads,
            "first_ * threads_ // last_ == thread_",
            "first_ * threads_ // last_ == thread_ + 1",
        ),
    ),
)
def threads_leave_every_bit(run: Run) -> Comparison:
    same, kinds = [], []
    for precision in ("double", "single")[: run.count(1, 1, 2)]:  # each is compiled for threads anew
        states = []
        for threads in (1, 2, 3):  # shares of the work, whatever the machine has to do them on
            rng = run.fresh_rng()
            world = World(gravity=(0.0, 0.0, 0.0), precision=precision)
            for k in range(9):
                mesh = lumpy_sphere(rng, 5 if k == 4 else 2)
                world.add_soft_body(mesh, 1.0, 100.0, 20.0, (4.0 * k, 0.0, 0.0), damping=1e-4)
            motion = motion_of(world.model.soft_particle_start, world.rings, threads)
            parts = world.model, world.controls, world.state, motion, world.settings
            run_alone(*parts, 0.5 * world.stable_time_step(), run.count(20, 50, 500))
            states.append(np.concatenate([world.state.particle_position, world.state.particle_velocity]))
        for other in states[1:]:
            same.append((states[0].view(np.uint64) == other.view(np.uint64)).all(axis=1))
            kinds += [precision] * len(other)
    agree = np.concatenate(same)
    return Comparison(agree, np.ones(len(agree), bool), groups=kinds)
