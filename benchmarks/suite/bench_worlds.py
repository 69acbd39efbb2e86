"""Cost of whole scenes, and of each stage of a step. One thread, float64, at the stable step.

How a step is split: a stage alone is done many times over, at the same instant each time, to which the state is put
back: motion (springs, gas, integrator); then, where the bodies are after it, the broad phase (bounding spheres, pairs);
the same and the narrow phase, which lists all contacts of soft bodies; the same with the response. What is left of a
step is the ground and the contacts of boxes. Everything has landed by that instant, but not all lies still: the torus
of scene 2 rolls, the stack swings, and balls of the tray bounce at 1 to 2 m/s.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from math import inf

import numba
import numpy as np

from benchmarks import peers
from benchmarks.goals import CLOCK, Goal, Growth
from benchmarks.race import Peer
from benchmarks.suite import Benchmark, Row
from benchmarks.worlds import putting_back
from softbody import World
from softbody.collision.broad_phase import near_pairs
from softbody.collision.contact import Contacts, new_contacts
from softbody.collision.soft.soft_contacts import find_soft_contacts
from softbody.collision.soft.soft_response import Bodies, resolve_contacts
from softbody.collision.soft.split_steps import spheres_of_bodies
from softbody.collision.soft.surface import Surfaces, build_surfaces
from softbody.compiler.jit import jit
from softbody.dynamics.soft_bodies import motion_of, move_soft_bodies
from softbody.model.arrays import Model, State, boxes_of, copy_state, particles_of, soft_bodies_of
from softbody.model.settings import Settings
from softbody.scenes import boxes_on_torus, rolling_torus, sphere_on_torus, torus_stack, tray
from softbody.storage.snapshot import Snapshot

SCENES: dict[str, Callable[[], World]] = {
    "Scene 1: sphere on torus": sphere_on_torus.build,
    "Scene 2: rolling torus": rolling_torus.build,
    "Scene 3: boxes on torus": boxes_on_torus.build,
    "Scene 4: stack of tori": torus_stack.build,
    "100 balls in a tray": lambda: tray.build(100),
}

PAGE = "standard", 3  # the level from which on the page has it, and where
LANDING = 2.0  # [s] before the clock starts: by then everything has landed; balls of the tray still bounce
SLACK = 0.95  # of the stable step, which shrinks a little as bodies stretch
BODY_STEPS = 1_000  # of a round
STAGES = (
    "of which motion",
    "of which broad phase",
    "of which broad and narrow phase",
    "of which all contacts of soft bodies, with response",
)
TRAY = "A time step of soft balls of 162 particles in a tray"
TWO_THREADS = "the same on two threads"
IN_PARTS = {parts: f"the same, substeps={parts}" for parts in (2, 4)}
ASLEEP = "the same when all sleep"
FEWEST_SHARED = 10  # bodies, so that threads have something to share
UNTIL_KNOWN = 8  # calls, after which a world knows if two threads are faster than one, as after the first half second


@functools.cache
def landing(build: Callable[..., World], *arguments: int) -> tuple[Snapshot, float]:
    """Return what a world is when it has run for LANDING, and the step that it takes; it is run once a process."""
    world = build(*arguments)
    step = SLACK * world.stable_time_step()
    world.run(LANDING, step)
    return world.snapshot(), step


def landed(build: Callable[..., World], *arguments: int) -> tuple[World, float]:
    """Return a new world that is where it is after LANDING, and the step that it takes."""
    snapshot, step = landing(build, *arguments)
    world = build(*arguments)
    world.restore(snapshot)
    return world, step


SOME_STEP = 1e-3  # [s], on which no time depends


@jit
def find_near(model: Model, state: State) -> np.ndarray:
    """Do the broad phase of soft bodies, as `find_soft_contacts` does."""
    return near_pairs(*spheres_of_bodies(model, state))


@jit
def broad_phases(model: Model, state: State, times: int) -> int:
    """Do the broad phase many times."""
    found = 0
    for _ in range(times):
        found += len(find_near(model, state))
    return found


@jit
def narrow_phases(
    model: Model, state: State, surfaces: Surfaces, settings: Settings, contacts: Contacts, times: int
) -> Contacts:
    """Do the broad and the narrow phase many times; return the contacts."""
    for _ in range(times):
        contacts.number[:] = 0
        contacts = find_soft_contacts(model, state, state, surfaces, None, settings, contacts)
    return contacts


@jit
def contact_phases(
    model: Model, start: State, state: State, surfaces: Surfaces, settings: Settings, contacts: Contacts, times: int
) -> None:
    """Find and resolve the contacts of soft bodies many times, from the same start."""
    for _ in range(times):
        copy_state(start, state)
        contacts = narrow_phases(model, state, surfaces, settings, contacts, 1)
        now = Bodies(particles_of(model, state), boxes_of(model, state))
        before = Bodies(particles_of(model, start), boxes_of(model, start))
        resolve_contacts(contacts, now, before, surfaces.response, SOME_STEP)


def stages_of(world: World, step: float, steps: int, units: float) -> dict[str, Peer]:
    """Return calls that each do one stage of `steps` steps of a world as it is now."""
    model, start, kept, now = world.model, *(world.state.copy() for _ in range(3))
    motion = motion_of(model.soft_particle_start, world.store.rings, world.threads)

    def move(state: State, steps: int) -> None:
        move_soft_bodies(soft_bodies_of(model, world.controls, state), motion, world.store.settings, step, steps)

    def motions() -> None:
        copy_state(start, now)
        move(now, steps)

    stages: dict[str, Peer] = {STAGES[0]: (motions, units)}
    if model.soft_count + model.box_count > 1:
        move(kept, 1)
        contacts = new_contacts(len(world.store.contacts.depth))
        finding = build_surfaces(model, kept.particle_position), world.store.settings, contacts, steps
        stages[STAGES[1]] = (lambda: broad_phases(model, kept, steps), units)
        stages[STAGES[2]] = (lambda: narrow_phases(model, kept, *finding), units)
        stages[STAGES[3]] = (lambda: contact_phases(model, kept, now, *finding), units)
    return stages


def in_parts(scene: str, parts: int, step: float, steps: int) -> Peer:
    """Return a call that goes on with a scene in steps as many times as long, of as many parts, and its seconds."""
    world, _ = landed(SCENES[scene])
    world.substeps, count = parts, max(1, steps // parts)
    back = putting_back(world)

    def call() -> None:
        back()
        world.step(parts * step, count, allow_unstable=True)

    return call, count * parts * step


@Benchmark(
    Row("Scene *", "particles", "simulated second", own=(*IN_PARTS.values(), *STAGES)),
    sizes={"quick": tuple(SCENES)},
    usual=("Scene 4: stack of tori",),
    goals=[Goal(CLOCK, 8.0, table=f"Scene {number}*") for number in (1, 2, 3, 4)],
)
def bench_scene(race, scene: str) -> None:
    """A second of a scene: beside it, its stages; and for the first, pybullet's deformables on the same meshes."""
    world, step = landed(SCENES[scene])
    steps = max(5, BODY_STEPS // (10 * world.model.soft_count))
    seconds = steps * step

    def rivals() -> dict[str, Peer]:
        stages = {name: in_parts(scene, parts, step, steps) for parts, name in IN_PARTS.items()}
        stages |= stages_of(world, step, steps, seconds)
        if scene.startswith("Scene 1"):
            name = "pybullet's deformables (same meshes, springs without gas, one force a step, no friction)"
            stages[name] = peers.pybullet_sphere_on_torus(step, steps), seconds
        return stages

    race(
        lambda: world.step(step, steps, allow_unstable=True),
        seconds,
        table=scene,
        size=len(world.state.particle_position),
        peers=rivals,
        clock=1.0,
        restore=putting_back(world),
        answer=lambda: world.state,
    )


@Benchmark(
    Row(TRAY, "bodies", "body and step", own=(TWO_THREADS, ASLEEP, *STAGES)),
    sizes={"quick": (1, 10), "standard": (1, 10, 100), "full": (1, 10, 100, 1_000)},
    goals=(
        Goal(CLOCK, 1.3, (100, 100)),
        Goal(CLOCK, 2.0, (100, 100), TWO_THREADS),
        Goal("softbody", 1.6, (10, inf), TWO_THREADS),
        Growth(1.12),
    ),
)
def bench_tray(race, bodies: int) -> None:
    """A step of balls of 162 particles in a tray: the cost of one must not grow with their number."""
    world, step = landed(tray.build, bodies)
    steps = max(2, BODY_STEPS // bodies)

    # Whatever its speed, each falls asleep.
    asleep = tray.build(bodies, world=World(sleep_speed=inf, sleep_after=1e-9))
    asleep.step(step, 3, allow_unstable=True)
    assert all(ball.is_asleep for ball in asleep.soft_bodies)

    def rivals() -> dict[str, Peer]:
        sleepers = {ASLEEP: (lambda: asleep.step(step, steps, allow_unstable=True), bodies * steps)}
        if numba.config.NUMBA_NUM_THREADS < 2 or bodies < FEWEST_SHARED:  # type: ignore[attr-defined]
            return {**sleepers, **stages_of(world, step, steps, bodies * steps)}
        shared, _ = landed(tray.build, bodies)
        shared.threads = 2
        back = putting_back(shared)

        def on_two_threads() -> None:
            back()
            shared.step(step, steps, allow_unstable=True)

        for _ in range(UNTIL_KNOWN):
            on_two_threads()
        both = {TWO_THREADS: (on_two_threads, bodies * steps), **sleepers}
        return {**both, **stages_of(world, step, steps, bodies * steps)}

    race(
        lambda: world.step(step, steps, allow_unstable=True),
        bodies * steps,
        size=bodies,
        peers=rivals,
        clock=step / bodies,
        restore=putting_back(world),
        answer=lambda: world.state,
    )
