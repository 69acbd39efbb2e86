"""What does one time step cost, per particle, as the mesh grows? One thread, float64, no contact."""

from __future__ import annotations

import numpy as np
import pytest

import softbody
from softbody.dynamics.integrators import INTEGRATORS
from softbody.step import run

SUBDIVISIONS = (3, 4, 5, 6, 7)  # 642, 2 562, 10 242, 40 962, 163 842 particles

PARTICLE_STEPS = 300_000  # per round: a round takes about 30 ms, so that the call and the clock cost nothing
ROUNDS = {"quick": 7, "standard": 15, "full": 41}


def inflated_sphere(subdivisions: int) -> softbody.World:
    """Return a world with one sphere that its gas has begun to inflate."""
    world = softbody.World()
    mesh = softbody.icosphere(subdivisions, radius=0.5)
    world.add_soft_body(mesh, mass=1.0, stiffness=200.0, gas=30.0)
    return world


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("subdivisions", SUBDIVISIONS)
def bench_step(benchmark, request, subdivisions: int, integrator: str) -> None:
    """Time whole runs of steps inside one compiled call."""
    if integrator != "rk4_velocity" and subdivisions > 5:
        pytest.skip("the other integrators make the same force evaluations: three sizes show it")
    world = inflated_sphere(subdivisions)
    particles = len(world.state.position)
    steps = max(1, round(PARTICLE_STEPS / particles))
    # Far below the stable step, so that no round meets another geometry than the first.
    time_step = 1e-3 * world.stable_time_step()
    arguments = (world.model, world.state, time_step, steps, INTEGRATORS[integrator], False)
    run(*arguments)
    benchmark.extra_info.update(name=integrator, particles=particles, steps=steps)
    rounds = ROUNDS[request.config.getoption("--level")]
    done, fault, _ = benchmark.pedantic(run, args=arguments, rounds=rounds, warmup_rounds=1)
    assert (done, fault) == (steps, 0)
    assert np.isfinite(world.state.position).all()
