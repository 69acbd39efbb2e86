"""Which integrator gets how near to the true motion for how much time? A soft sphere that shakes for half a second."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np
import pytest

import softbody
from references import scipy
from softbody.settings import INTEGRATORS

STIFFNESS, GAS, SECONDS = 200.0, 30.0, 0.5
STEPS = (150, 300, 600, 1_200, 2_400, 4_800)


@functools.cache
def start() -> tuple[softbody.Mesh, np.ndarray, np.ndarray]:
    """Return a sphere of 162 particles of 1 kg in all, their velocities, and where they truly are in the end."""
    mesh = softbody.icosphere(2, radius=0.5)
    velocity = np.random.default_rng(0).normal(0.0, 0.3, mesh.vertices.shape)
    lengths = np.linalg.norm(mesh.vertices[mesh.edges[:, 1]] - mesh.vertices[mesh.edges[:, 0]], axis=1)
    springs = mesh.edges, lengths, np.full(len(lengths), STIFFNESS)
    end = scipy.motion(mesh.vertices, velocity, *springs, mesh.triangles, GAS, 1.0 / len(mesh.vertices), SECONDS)
    return mesh, velocity, end


def shaking(integrator: str, steps: int) -> tuple[Callable[[], np.ndarray], float]:
    """Return a call that takes the sphere through its time, and how far from the truth it ends [of its radius]."""
    mesh, velocity, end = start()
    world = softbody.World(gravity=(0.0, 0.0, 0.0), integrator=integrator)
    body = world.add_soft_body(mesh, 1.0, STIFFNESS, GAS)

    def call() -> np.ndarray:
        body.positions[:], body.velocities[:] = mesh.vertices, velocity
        world.step(SECONDS / steps, steps, allow_unstable=True)
        return body.positions

    call()
    return call, float(np.linalg.norm(body.positions - end, axis=1).max()) / 0.5


@pytest.mark.parametrize("steps", STEPS)
def bench_work_precision(race, steps: int) -> None:
    """The same time in more and more steps."""
    calls = {name: shaking(name, steps) for name in INTEGRATORS}
    particles = len(start()[0].vertices)
    (ours, _), *_ = calls.values()
    race(
        ours,
        particles * SECONDS,
        table="Work and precision of the integrators",
        name=next(iter(calls)),
        size=steps,
        of="steps",
        per="particle and simulated second",
        peers={name: (call, particles * SECONDS) for name, (call, _) in list(calls.items())[1:]},
        own=list(calls)[1:],
        errors={name: error for name, (_, error) in calls.items()},
    )
