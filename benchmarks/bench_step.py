"""Cost of one time step, per particle: one body as it grows, and many. Double, on one thread, unless said."""

from __future__ import annotations

import functools
from typing import Any

import numba
import numpy as np
import pytest

import softbody
from benchmarks import peers
from benchmarks.cpp_peers import plain_stepping, ring_stepping
from benchmarks.mujoco_peer import mujoco_stepping
from benchmarks.newton_peer import newton, newton_stepping
from benchmarks.race import Peer
from benchmarks.taichi_peer import taichi, taichi_stepping
from benchmarks.warp_peer import warp, warp_stepping
from benchmarks.worlds import putting_back
from softbody.dynamics.soft_bodies import LARGE, motion_of
from softbody.stepping.step import run_alone

SUBDIVISIONS = (1, 2, 3, 4, 5, 6, 7)  # 42, 162, 642, 2 562, 10 242, 40 962, 163 842 particles
MILLION = 0  # in place of subdivisions: a torus of 1 000 000 particles
BODIES = (1, 10, 100, 1_000, 10_000)
THREADS: int = numba.config.NUMBA_NUM_THREADS  # type: ignore[attr-defined]

DEFAULT = "symplectic_euler, damped (the default)"

PARTICLE_STEPS = 200_000  # per round: a round takes about 12 ms, so that the call and the clock cost nothing
LEAST_STEPS = 10  # a call of fewer is dominated by reading and writing the state


@functools.cache
def sphere(subdivisions: int) -> softbody.Mesh:
    """Return the sphere of half a metre that every competitor steps, or the torus of a MILLION."""
    return softbody.icosphere(subdivisions, radius=0.5) if subdivisions else softbody.torus(0.4, 0.15, 1_250, 800)


def steps_for(particles: int, share: float = 1.0) -> int:
    """Return how many steps a round has; `share` of the usual for competitors that are slower."""
    return max(LEAST_STEPS if share == 1.0 else 1, round(share * PARTICLE_STEPS / particles))


def world_of(
    mesh: softbody.Mesh, bodies: int, integrator: str = "rk4_velocity", damping: float | None = 0.0, **options: Any
) -> softbody.World:
    """Return a world of equal bodies in a row, which their gas has begun to inflate: the paper's step, unless told."""
    world = softbody.World(integrator=integrator, **options)
    for k in range(bodies):
        place = (1.5 * k, 0.0, 0.0)
        world.add_soft_body(mesh, peers.MASS, peers.STIFFNESS, peers.GAS, position=place, damping=damping)
    return world


def stepping(world: softbody.World) -> Peer:
    """Return a call that steps a world whose bodies do not meet, and its particles × steps."""
    particles = len(world.state.particle_position)
    steps = steps_for(particles)
    # Far below the stable step, so that no round meets another geometry than the first.
    time_step = 1e-3 * world.stable_time_step()
    motion = motion_of(world.model.soft_particle_start, world.store.rings, world.threads)
    arguments = world.model, world.controls, world.state, motion, world.store.settings, time_step, steps

    def call() -> None:
        done, _, _ = run_alone(*arguments)
        assert done == steps
        assert np.isfinite(world.state.particle_position[0, 0])

    return call, particles * steps


def peers_of(mesh: softbody.Mesh, h: float) -> dict[str, Peer]:
    """Return everyone who does the paper's step on the same mesh, and who does something like it."""
    n = len(mesh.vertices)
    steps, few = steps_for(n), steps_for(n, 0.02)
    rivals: dict[str, Peer] = {}
    for name, made in (("plain C++ -O3 -march=native", plain_stepping), ("C++ with vectors by hand", ring_stepping)):
        call = made(mesh, h, steps)
        if call is not None:
            rivals[name] = call, n * steps
    rivals["SciPy sparse"] = peers.stepping(mesh, peers.sparse_forces(mesh), h, few), n * few
    if n <= 10_242:  # beyond, a step takes them half a second
        for name, add in (("NumPy bincount", peers.add_bincount), ("NumPy add.at", peers.add_at)):
            rivals[name] = peers.stepping(mesh, peers.numpy_forces(mesh, add), h, few), n * few
    if taichi:
        rivals["Taichi, all steps in one kernel"] = taichi_stepping(mesh, h, steps), n * steps
    if warp:
        rivals["Warp, a kernel for every loop"] = warp_stepping(mesh, h, few, "float64"), n * few
        rivals["Warp, a kernel for every loop, float32"] = warp_stepping(mesh, h, few, "float32"), n * few
    if newton and n <= 40_962:  # beyond, it takes half a minute to make
        rivals["Newton (springs only, one force a step), float32"] = newton_stepping(mesh, h, few), n * few
    if 42 < n <= 2_562:  # beyond, they take seconds, to step or to make
        rivals["MuJoCo flex (springs only, one force a step)"] = mujoco_stepping(mesh, h, few), n * few
        rivals["pybullet (springs only, one force a step)"] = peers.pybullet_stepping(mesh, h, few), n * few
    return rivals


def level(request: pytest.FixtureRequest) -> str:
    """Return the level at which the benchmarks run."""
    return str(request.config.getoption("--level"))


@pytest.mark.parametrize("subdivisions", [*SUBDIVISIONS, MILLION])
def bench_step(race, request: pytest.FixtureRequest, subdivisions: int) -> None:
    """Whole runs of steps inside one compiled call: the paper's integrator, and everyone beside it."""
    if subdivisions == MILLION and level(request) != "full":
        pytest.skip("a million particles are for level full")
    if subdivisions == SUBDIVISIONS[-1] and level(request) == "quick":
        pytest.skip("163 842 particles are for higher levels")
    mesh = sphere(subdivisions)
    world = world_of(mesh, 1)
    ours, units = stepping(world)
    variants: dict[str, dict[str, Any]] = {
        "rk4": {"integrator": "rk4"},
        "symplectic_euler (one force evaluation a step, not four)": {"integrator": "symplectic_euler"},
        DEFAULT: {"integrator": "symplectic_euler", "damping": None},
    }
    if level(request) != "quick":  # each is compiled anew
        variants["rk4_velocity, single precision"] = {"precision": "single"}
        if THREADS > 1 and len(mesh.vertices) >= LARGE:
            variants[f"rk4_velocity, {THREADS} threads"] = {"threads": THREADS}
    h = 1e-3 * world.stable_time_step()
    race(
        ours,
        units,
        table="A time step of one soft body",
        name="rk4_velocity",
        size=len(mesh.vertices),
        of="particles",
        per="particle and step",
        peers=lambda: {
            **{name: stepping(world_of(mesh, 1, **options)) for name, options in variants.items()},
            **peers_of(mesh, h),
        },
        own=list(variants),
        restore=putting_back(world),
        answer=lambda: world.state,
    )


@pytest.mark.parametrize("bodies", BODIES)
def bench_many_bodies(race, request: pytest.FixtureRequest, bodies: int) -> None:
    """Bodies of 162 particles side by side, and one body of 10 242 for comparison."""
    if bodies == 10_000 and level(request) != "full":
        pytest.skip("10 000 bodies are for level full")
    world = world_of(sphere(2), bodies)
    ours, units = stepping(world)
    rivals = {
        "one body of 10 242 particles": stepping(world_of(sphere(5), 1)),
        DEFAULT: stepping(world_of(sphere(2), bodies, "symplectic_euler", None)),
    }
    if THREADS > 1 and bodies > 1 and level(request) != "quick":
        rivals[f"rk4_velocity, {THREADS} threads"] = stepping(world_of(sphere(2), bodies, threads=THREADS))
    race(
        ours,
        units,
        table="A time step of many soft bodies of 162 particles",
        name="rk4_velocity",
        size=bodies,
        of="bodies",
        per="particle and step",
        peers=rivals,
        own=list(rivals),
        restore=putting_back(world),
        answer=lambda: world.state,
    )
