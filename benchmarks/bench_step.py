"""What does one time step cost, per particle, as the mesh grows? One thread, float64, no contact."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import softbody
from softbody.dynamics.integrators import INTEGRATORS
from softbody.step import run

SUBDIVISIONS = (3, 4, 5, 6, 7)  # 642, 2 562, 10 242, 40 962, 163 842 particles

PARTICLE_STEPS = 200_000  # per round: a round takes about 20 ms, so that the call and the clock cost nothing


def stepping(integrator: str, subdivisions: int) -> tuple[Callable[[], None], int]:
    """Return a call that steps a sphere, which its gas has begun to inflate, and its particles × steps."""
    world = softbody.World(integrator=integrator)
    mesh = softbody.icosphere(subdivisions, radius=0.5)
    world.add_soft_body(mesh, mass=1.0, stiffness=200.0, gas=30.0)
    particles = len(world.state.position)
    steps = max(1, round(PARTICLE_STEPS / particles))
    # Far below the stable step, so that no round meets another geometry than the first.
    time_step = 1e-3 * world.stable_time_step()

    def call() -> None:
        done, _, _ = run(
            world.model, world.state, time_step, steps, INTEGRATORS[integrator], world.rules, world.contacts
        )
        assert done == steps
        assert np.isfinite(world.state.position[0, 0])

    return call, particles * steps


@pytest.mark.parametrize("subdivisions", SUBDIVISIONS)
def bench_step(race, subdivisions: int) -> None:
    """Whole runs of steps inside one compiled call: the paper's integrator, and the two others beside it."""
    ours, units = stepping("rk4_velocity", subdivisions)
    race(
        ours,
        units,
        table="A time step of one soft body",
        name="rk4_velocity",
        size=10 * 4**subdivisions + 2,
        of="particles",
        per="particle and step",
        peers={name: stepping(name, subdivisions) for name in ("rk4", "symplectic_euler")},
    )
