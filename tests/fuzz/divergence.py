"""A world of extreme numbers is refused, or found to diverge, or stays finite and bounded; what is left can be used."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

import softbody
from softbody import MeshError, ParameterError, SimulationError, SoftBody, World

GOAL = 1_000  # worlds that diverge: each attempt ends with one

MOST_WORLDS = 100  # of which none diverges: then it is enough
MESHES = [softbody.tetrahedron(), softbody.octahedron(), softbody.icosphere(1), softbody.box((1.0, 0.5, 2.0), 2)]
HUGE = 1e5  # times its size at rest, swollen by its gas, to which no body may have grown
FAR = 2.0**50  # times its size, at which a box may be


def attempt(seed: int) -> str | None:
    """Make worlds, step them, and look what became of them, until one has diverged."""
    rng = np.random.default_rng(seed)
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        for _ in range(MOST_WORLDS):
            broken, has_diverged = _lived(rng)
            if broken or has_diverged:
                return broken
    return None


def _lived(rng: np.random.Generator) -> tuple[str | None, bool]:
    """Make a world and step it; return what is wrong with what came of it, and whether it has diverged."""
    try:
        world = _made(rng)
    except (MeshError, ParameterError):
        return None, False
    for _ in range(int(rng.integers(1, 4))):
        h = float(10.0 ** rng.uniform(-4.0, 0.5)) if rng.random() < 0.8 else float(10.0 ** rng.uniform(-300.0, 300.0))
        broken, has_diverged = _stepped(world, h, int(rng.integers(1, 100)), bool(rng.random() < 0.9))
        if broken or has_diverged:
            return broken, has_diverged
    return _refuses_what_is_stable(world), False


def _refuses_what_is_stable(world: World) -> str | None:
    """Take nine tenths of the step that is called stable; return what is wrong if it is refused as too long."""
    try:
        h = 0.9 * min(world.stable_time_step(), 1e-3)
        world.step(h)
    except SimulationError:
        return None
    except ParameterError as error:
        if "a stable time step here" in str(error) or "joints allow" in str(error):
            return f"nine tenths of the stable step are refused: {error}"
    return None


def _made(rng: np.random.Generator) -> World:
    """Return a world of some bodies, of which most numbers are usual ones and some are not."""
    extreme = rng.choice([0.0, 0.1, 0.4])

    def number(usual: float) -> float:
        if rng.random() >= extreme:
            return usual * float(10.0 ** rng.uniform(-0.5, 0.5))
        return float(usual * 10.0 ** rng.choice([rng.uniform(-12.0, 12.0), rng.uniform(-320.0, 308.0)]))

    def vector(usual: float) -> np.ndarray:
        return np.array([number(usual) for _ in range(3)]) * rng.choice([-1.0, 1.0], 3)

    integrator = str(rng.choice(["rk4_velocity", "rk4", "symplectic_euler"]))
    world = World(np.array([0.0, 0.0, -number(10.0)]), integrator=integrator, gyroscopic=bool(rng.random() < 0.3))
    if rng.random() < 0.7:
        world.add_ground(restitution=float(rng.random()))
    for k in range(int(rng.integers(0, 3))):
        mesh = MESHES[int(rng.integers(len(MESHES)))].scaled(number(1.0))
        place, velocity = np.array([0.0, 0.0, number(1.0) + 1.5 * k]), vector(1.0)
        body = world.add_soft_body(
            mesh, number(1.0), number(100.0), number(10.0), place, velocity, damping=number(0.01), drag=number(0.1)
        )
        if rng.random() < 0.3:
            body.external_force = vector(1.0)
    for k in range(int(rng.integers(0, 4))):
        size, place = np.abs(vector(1.0)), np.array([number(0.5), number(0.5), number(1.0) + k])
        box = world.add_box(size, number(1.0), place, velocity=vector(1.0), angular_velocity=vector(1.0))
        if rng.random() < 0.3:
            box.apply_force(vector(1.0), box.position + vector(0.1))
        if rng.random() < 0.1 * extreme:
            box.orientation[:] = rng.choice([0.0, 1e160, 1e-160, 0.7])
        if rng.random() < 0.1 * extreme:
            box.angular_velocity[:] = number(1.0)
    if rng.random() < 0.3:
        moved = world.add_box(np.abs(vector(1.0)), None, vector(1.0), velocity=vector(1.0))
        moved.move_to(vector(1.0), seconds=number(1.0))
    bodies = [*world.soft_bodies, *world.boxes]
    for _ in range(int(rng.integers(0, 4)) if bodies and rng.random() < 0.5 else 0):
        ends: list[Any] = [
            (body, _place_on(body, rng, vector)) for body in rng.permutation(np.array(bodies, object))[:2]
        ]
        ends = [*ends, vector(1.0)][:2]
        joint = world.add_joint(ends[0], ends[1], number(100.0), number(0.1), rng.choice([0.0, number(1.0)]))
        if rng.random() < 0.2 * extreme:
            joint.stiffness = number(1e6)
    return world


def _place_on(body: Any, rng: np.random.Generator, vector: Callable[[float], np.ndarray]) -> Any:
    """Return where a joint holds a body."""
    if isinstance(body, SoftBody) and rng.random() < 0.5:
        return int(rng.integers(len(body.positions)))
    return body.positions[0] if isinstance(body, SoftBody) else body.position + vector(0.3)


def _stepped(world: World, h: float, steps: int, unstable: bool) -> tuple[str | None, bool]:
    """Step the world; return what is wrong with what came of it, and whether it has diverged."""
    before, done = world.state_hash(), world.steps
    good_before = _flaw(world) is None
    try:
        world.step(h, steps, allow_unstable=unstable)
    except ParameterError:
        is_as_before = (world.state_hash(), world.steps) == (before, done)
        return None if is_as_before else "a step was refused, and begun", False
    except SimulationError as error:
        if world.steps != error.step or not done <= error.step < done + steps:
            return f"an error in step {error.step}, after {world.steps} of {done} + {steps}", True
        if error.body not in str(error) or not np.isfinite(error.stable_time_step) or error.stable_time_step < 0.0:
            return f"a message that helps nobody: {error}; {error.stable_time_step}", True
        flaw = _flaw(world) if good_before else None
        if flaw:
            return f"the last good state has {flaw}; {error}", True
        return _recovers(world, error), True
    flaw = _flaw(world) if good_before else None
    return (f"silent: {flaw} after {world.steps - done} steps of {h:.3g} s" if flaw else None), False


def _recovers(world: World, error: SimulationError) -> str | None:
    """Take the step that the message names, or any; a typed error may come, and nothing else."""
    h = error.stable_time_step
    try:
        world.step(0.9 * h if h > 0.0 else 1e-3)
    except ParameterError as refused:
        return f"the step that helps is refused: {refused}" if h > 0.0 and "stable" in str(refused) else None
    except SimulationError as again:
        # Nothing but a shorter step was asked for: it must help.
        if "stable time step here" in str(error) and "stable time step here" in str(again):
            return f"the step that is to help does not: {error} Then: {again}"
    flaw = _flaw(world)
    return f"{flaw} after the step that helps" if flaw else None


def _flaw(world: World) -> str | None:
    """Return what is not finite or not bounded in a world."""
    model, state = world.model, world.state
    for name, rows in state._asdict().items():
        if not np.isfinite(rows).all():
            return f"{name} that is not finite"
    for k in range(model.soft_count):
        rows, edges = (slice(*start[k : k + 2]) for start in (model.soft_particle_start, model.soft_edge_start))
        length, stiffness = model.edge_rest_length[edges], model.edge_stiffness[edges]
        swollen = 1.0 + np.sqrt(3.0 * world.controls.soft_gas[k] / (stiffness * length**2).sum())
        hanging = np.linalg.norm(world.controls.gravity) / model.particle_inverse_mass[rows].max() / stiffness.min()
        most = HUGE * (np.sqrt((length**2).sum()) * swollen + (rows.stop - rows.start) * hanging)
        extent = np.ptp(state.particle_position[rows], axis=0).max()
        if not extent <= most:
            return f"a soft body {extent:.3g} m across"
    for k in range(model.box_count):
        if not np.abs(state.box_position[k]).max() <= FAR * model.box_size[k].min():
            return f"a box at {state.box_position[k]}"
        if not abs(np.linalg.norm(state.box_orientation[k]) - 1.0) < 1e-5:
            return f"a box of orientation {state.box_orientation[k]}"
    return None
