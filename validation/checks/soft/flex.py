"""Another engine's soft body, step by step: MuJoCo's flex, which has our springs and two of our integrators."""

from __future__ import annotations

from itertools import product

import numpy as np

from softbody import World
from softbody.dynamics import pressure
from validation.answers import Answers
from validation.cases import MESH_KINDS, edge_lengths, random_mesh
from validation.check import Comparison, Run, check
from validation.fault import Fault

STEPS = 100
GRAVITY = -9.81  # [m/s²]


@check(
    family="soft bodies",
    section="2, 5.1",
    piece="softbody.stepping.step.run_alone",
    reference="MuJoCo's flex of lines, Euler and RK4; P ∂V/∂x, which it lacks, as a force of the user, by numpy",
    engines=("mujoco",),
    unit="of the size and the way",
    tolerance=3e-14,
    because="100 steps of rounding at 1e-16 of positions: 1e-14 at worst of 200 bodies",
    faults=(Fault("pressure off by 1e-11", pressure.gas_pressure, "gas_ / volume_ → gas_ / volume_ * (1.0 + 1e-11)"),),
)
def motion(run: Run) -> Comparison:
    """Damped, gas-filled soft bodies move as MuJoCo makes them, by two integrators."""
    from references import mujoco_flex

    rng, answers = run.fresh_rng(), Answers()
    for kind, integrator in [*product(MESH_KINDS, mujoco_flex.INTEGRATORS)] * run.count(1, 3, 20):
        mesh = random_mesh(kind, rng)
        edges, mass = mesh.edges, 10.0 ** rng.uniform(-1.0, 1.0)
        stiffness, gas = rng.uniform(20.0, 200.0), rng.uniform(1.0, 100.0)
        shortest = edge_lengths(mesh.vertices, edges).min()
        # A tenth of the critical damping of one particle on one spring.
        damping = 0.1 * 2.0 * np.sqrt(stiffness * mass / len(mesh.vertices))
        world = World(gravity=(0.0, 0.0, GRAVITY), integrator=integrator)
        body = world.add_soft_body(mesh, mass, stiffness, gas, damping=damping)
        step = 0.3 * world.stable_time_step()
        velocity = 0.03 * shortest / step * rng.normal(size=mesh.vertices.shape)
        body.velocities[:] = velocity
        world.step(step, STEPS)
        what = mesh.vertices, edges, mesh.triangles, velocity, stiffness, damping, gas, mass
        judged = mujoco_flex.motion(*what, GRAVITY, step, STEPS, integrator)
        way, size = np.abs(judged - mesh.vertices).max(), np.ptp(mesh.vertices, axis=0).max()
        answers.extend(body.positions, judged, size + way, f"{kind}, {integrator}")
    return answers.comparison()
