"""Cost of one time step, per particle: one body as it grows, and many. Double, on one thread, unless said."""

from __future__ import annotations

import functools
from math import inf
from typing import Any

import numba
import numpy as np

import softbody
from benchmarks import peers
from benchmarks.cpp_peers import plain_stepping, ring_stepping
from benchmarks.goals import Goal, Growth
from benchmarks.mujoco_peer import mujoco_stepping
from benchmarks.newton_peer import newton, newton_stepping
from benchmarks.race import Peer
from benchmarks.suite import Benchmark, Row
from benchmarks.taichi_peer import taichi, taichi_stepping
from benchmarks.warp_peer import warp, warp_stepping
from benchmarks.worlds import putting_back
from softbody.dynamics.soft_bodies import LARGE, motion_of
from softbody.stepping.step import run_alone

PAGE = "quick", 1  # the level from which on the page has it, and where: its head tells of the step
SPHERES = (1, 2, 3, 4, 5, 6)  # subdivisions: 42, 162, 642, 2 562, 10 242, 40 962 particles
MILLION = 0  # in place of subdivisions: a torus of 1 000 000 particles
THREADS: int = numba.config.NUMBA_NUM_THREADS  # type: ignore[attr-defined]

DEFAULT = "symplectic_euler, damped (the default)"
SINGLE = "rk4_velocity, single precision"
PLAIN, BY_HAND = "plain C++ -O3 -march=native", "C++ with vectors by hand"

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
    for name, made in ((PLAIN, plain_stepping), (BY_HAND, ring_stepping)):
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


IN_CACHE, MIDDLE, BEYOND = (0, 10_242), (10_243, 163_842), (163_843, inf)  # particles


@Benchmark(
    Row("A time step of one soft body", "particles", "particle and step", "rk4_velocity"),
    sizes={"quick": SPHERES, "standard": (*SPHERES, 7), "full": (*SPHERES, 7, MILLION)},  # 7: 163 842 particles
    usual=(1, 3, 5),
    goals=(
        Goal(PLAIN, 1 / 0.30, IN_CACHE),
        Goal(PLAIN, 1 / 0.45, MIDDLE),
        Goal(PLAIN, 1 / 0.75, BEYOND),
        Goal(BY_HAND, 1 / 1.2, IN_CACHE),
        Goal(BY_HAND, 1 / 1.6, (10_243, inf)),
        Goal(PLAIN, 1 / 0.25, IN_CACHE, SINGLE),
        Goal(PLAIN, 1 / 0.40, (10_243, inf), SINGLE),
        Goal("SciPy sparse", 20.0),
        Goal("NumPy bincount", 40.0),
        Goal("NumPy add.at", 70.0),
        Goal("pybullet *", 25.0),
        Goal("rk4_velocity", 1.8, (10_242, inf), "rk4_velocity, 2 threads"),
        Growth(1.10, (162, inf)),
    ),
)
def bench_step(race, level: str, subdivisions: int) -> None:
    """Whole runs of steps inside one compiled call: the paper's integrator, and everyone beside it."""
    mesh = sphere(subdivisions)
    world = world_of(mesh, 1)
    ours, units = stepping(world)
    variants: dict[str, dict[str, Any]] = {
        "rk4": {"integrator": "rk4"},
        "symplectic_euler (one force evaluation a step, not four)": {"integrator": "symplectic_euler"},
        DEFAULT: {"integrator": "symplectic_euler", "damping": None},
    }
    if level != "quick":  # each is compiled anew
        variants[SINGLE] = {"precision": "single"}
        if THREADS > 1 and len(mesh.vertices) >= LARGE:
            variants[f"rk4_velocity, {THREADS} threads"] = {"threads": THREADS}
    h = 1e-3 * world.stable_time_step()
    race(
        ours,
        units,
        size=len(mesh.vertices),
        peers=lambda: {
            **{name: stepping(world_of(mesh, 1, **options)) for name, options in variants.items()},
            **peers_of(mesh, h),
        },
        own=list(variants),
        restore=putting_back(world),
        answer=lambda: world.state,
    )


@Benchmark(
    Row("A time step of many soft bodies of 162 particles", "bodies", "particle and step", "rk4_velocity"),
    sizes={"quick": (1, 10, 100, 1_000), "full": (1, 10, 100, 1_000, 10_000)},
    usual=(100,),
)
def bench_many_bodies(race, level: str, bodies: int) -> None:
    """Bodies of 162 particles side by side, and one body of 10 242 for comparison."""
    world = world_of(sphere(2), bodies)
    ours, units = stepping(world)
    rivals = {
        "one body of 10 242 particles": stepping(world_of(sphere(5), 1)),
        DEFAULT: stepping(world_of(sphere(2), bodies, "symplectic_euler", None)),
    }
    if THREADS > 1 and bodies > 1 and level != "quick":
        rivals[f"rk4_velocity, {THREADS} threads"] = stepping(world_of(sphere(2), bodies, threads=THREADS))
    back = putting_back(world)
    race(ours, units, size=bodies, peers=rivals, own=list(rivals), restore=back, answer=lambda: world.state)
