"""An interrupt at any moment is heard within 0.2 s, and leaves a whole world: of the steps that its clock shows."""

from __future__ import annotations

import signal
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from types import FrameType

import numpy as np

import softbody
from softbody import World
from tests.same_bits import same_bits

GOAL = 1_000

SOON = 0.2  # [s] of the processor's time
BALLS = [softbody.icosphere(k, 0.5) for k in range(5)]
_durations: dict[tuple[object, ...], float] = {}


class HeardError(Exception):
    """What the handler raises in place of a KeyboardInterrupt."""


def attempt(seed: int) -> str | None:
    """Interrupt a step, a run, an adding of bodies, a search for an equilibrium, a restore; look what is left."""
    rng = np.random.default_rng(seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        kind = rng.choice(["step", "run", "add", "equilibrium", "restore"], p=[0.35, 0.25, 0.15, 0.1, 0.15])
        tries = {"step": _step, "run": _step, "add": _add, "equilibrium": _equilibrium, "restore": _restore}
        return tries[kind](rng, str(kind))


def _step(rng: np.random.Generator, kind: str) -> str | None:
    """Interrupt steps; compare the world with one that has made as many, to the bit, then and some steps later."""
    scene, integrator = int(rng.integers(7)), str(rng.choice(["rk4_velocity", "symplectic_euler"]))
    substeps = int(rng.choice([1, 1, 3]))
    world, h, steps = made(scene, integrator)
    h *= substeps

    def go() -> None:
        if kind == "run":
            world.run(steps * h, h, substeps=substeps)
        else:
            world.step(h, steps, substeps=substeps)

    seconds = _seconds((scene, integrator, substeps), lambda: _in_one_go(scene, integrator, h, steps, substeps))
    late = _interrupted(rng, go, seconds)
    if late:
        return late
    other, *_ = made(scene, integrator)
    if not 0 <= world.steps <= steps:
        return f"{world.steps} of {steps} steps"
    if world.steps:
        other.step(h, world.steps, substeps=substeps)
    for then in ("", " and three more"):
        if world.time != other.time:
            return f"{world.steps} steps{then} are {world.time!r} s, not {other.time!r}"
        different = [name for name, rows in world.snapshot().items() if not same_bits(rows, other.snapshot()[name])]
        if different:
            return f"after {world.steps} of {steps} steps{then} {', '.join(different)} differ"
        world.step(h, 3, substeps=substeps)
        other.step(h, 3, substeps=substeps)
    return None


def _add(rng: np.random.Generator, _: str) -> str | None:
    """Interrupt the adding of bodies; the world must be one with some of them, and go on as such a one."""
    order = rng.integers(0, 7, 6).tolist()

    def add(world: World, number: int) -> None:
        for k, body in enumerate(order[:number]):
            if body < 4:
                world.add_soft_body(BALLS[body], 1.0, 100.0, 10.0, (3.0 * k, 0.0, 1.0))
            elif body < 6 or k == 0:
                world.add_box((1.0, 1.0, 1.0), 1.0, (3.0 * k, 0.0, 1.0))
            else:
                held = [*world.soft_bodies, *world.boxes][-1]
                world.add_joint((held, (3.0 * k, 0.0, 2.0)), (3.0 * k, 0.0, 3.0), 20.0)

    world = World()
    world.add_ground()
    late = _interrupted(rng, lambda: add(world, len(order)), 0.03)
    if late:
        return late
    other, number = World(), world.model.soft_count + world.model.box_count + len(world.joints)
    other.add_ground()
    add(other, number)
    for then in ("", " and three steps"):
        mine, its = world.snapshot(), other.snapshot()
        if any(not same_bits(mine[name], its[name]) for name in its):
            return f"{number} of {len(order)} bodies{then} are not those of a world that was not interrupted"
        world.step(1e-4, 3)
        other.step(1e-4, 3)
    return None


def _equilibrium(rng: np.random.Generator, _: str) -> str | None:
    """Interrupt the search for shapes at rest: all bodies are as they were, or all are at rest."""
    level = int(rng.integers(1, 5))

    def build() -> World:
        world = World()
        for k in range(2):
            world.add_soft_body(BALLS[level], 1.0, 100.0, 10.0, (3.0 * k, 0.0, 1.0), (1.0, 0.0, 0.0), fixed=[k])
        return world

    def search(world: World) -> None:
        with suppress(softbody.SimulationError):  # not at rest in as many steps
            world.equilibrium(1e-9, steps=2_000)

    world, whole = build(), build()
    seconds = _seconds(("equilibrium", level), lambda: search(build()))
    late = _interrupted(rng, lambda: search(world), seconds)
    if late:
        return late
    before = build().state_hash()
    if world.state_hash() != before:
        search(whole)
        if world.state_hash() != whole.state_hash():
            return "some bodies are at rest, and others are not"
    return None


def _restore(rng: np.random.Generator, _: str) -> str | None:
    """Interrupt a world that becomes now one, now another: it is one of the two, and goes on as that one."""
    wholes = [made(int(scene), "rk4_velocity")[:2] for scene in rng.choice([0, 1, 3, 4, 5, 6], 2, replace=False)]
    for whole, h in wholes:
        whole.step(h, int(rng.integers(1, 5)))
    snapshots = [whole.snapshot() for whole, _ in wholes]
    world = World()
    world.restore(snapshots[0])

    def go() -> None:
        for k in range(1, 10):
            world.restore(snapshots[k % 2])

    late = _interrupted(rng, go, 0.02)
    if late:
        return late
    is_like = [
        k for k in range(2) if all(same_bits(world.snapshot()[name], rows) for name, rows in snapshots[k].items())
    ]
    if len(is_like) != 1:
        return "the world is neither what it was nor what it was to become"
    whole, h = wholes[is_like[0]]
    for each in (world, whole):
        each.step(h, 3)
    after = whole.snapshot()
    different = [name for name, rows in world.snapshot().items() if not same_bits(rows, after[name])]
    return f"three steps later {', '.join(different)} differ" if different else None


def made(scene: int, integrator: str) -> tuple[World, float, int]:
    """Return a world, a step [s], and so many of them that an interrupt can come in the midst."""
    world = World(integrator=integrator)
    world.add_ground()
    if scene in (0, 1, 2):
        world.add_soft_body(BALLS[scene + 2], 1.0, 200.0, 30.0, (0.0, 0.0, 0.6))
    elif scene == 3:
        for k in range(3):
            world.add_soft_body(BALLS[2], 1.0, 200.0, 30.0, (0.1 * k, 0.0, 0.6 + 0.99 * k))
    elif scene == 4:
        for k in range(5):
            world.add_box((1.0, 0.9, 0.5), 1.0, (0.05 * k, 0.0, 0.25 + 0.51 * k), angular_velocity=(0.0, 0.1, 0.3))
    elif scene == 5:
        world.add_box((1.0, 1.0, 0.5), 1.0, (0.0, 0.0, 0.25))
        world.add_box((0.5, 0.5, 0.5), 1.0, (0.1, 0.0, 0.76))
        world.add_soft_body(BALLS[2], 1.0, 200.0, 30.0, (0.0, 0.0, 1.55))
    else:
        lift = world.add_box((2.0, 2.0, 0.2), None, (0.0, 0.0, 0.1))
        lift.move_to((0.0, 0.0, 1.0), seconds=1.0)
        box = world.add_box((0.5, 0.5, 0.5), 1.0, (0.0, 0.0, 2.0))
        ball = world.add_soft_body(BALLS[2], 1.0, 200.0, 30.0, (0.0, 0.0, 0.8))
        world.add_joint((ball, 0), (box, box.position), 20.0, 0.1, 0.5)
        world.add_joint((box, box.position), (0.0, 0.0, 2.5), 20.0)
    return world, 0.3 * min(world.stable_time_step(), 0.01), (4_000, 1_000, 100, 200, 1_000, 200, 200)[scene]


def _in_one_go(scene: int, integrator: str, h: float, steps: int, substeps: int) -> None:
    made(scene, integrator)[0].step(h, steps, substeps=substeps)


def _seconds(what: tuple[object, ...], call: Callable[[], None]) -> float:
    """Return how long a call takes [s] of the processor's time, once everything is compiled."""
    if what not in _durations:
        call()
        begun = time.process_time()
        call()
        _durations[what] = time.process_time() - begun
    return _durations[what]


def _interrupted(rng: np.random.Generator, call: Callable[[], None], seconds: float) -> str | None:
    """Call, and interrupt at some moment of its `seconds` [s]; return a sentence if that is heard late."""
    counts_work = bool(rng.integers(2))  # the processor's time, in ticks of some milliseconds, or the clock's
    timer, number = (signal.ITIMER_PROF, signal.SIGPROF) if counts_work else (signal.ITIMER_REAL, signal.SIGALRM)
    error = (KeyboardInterrupt, HeardError)[int(rng.integers(2))]
    delay = max(1e-5, float(rng.uniform(0.0, 1.1 * seconds)))
    heard: list[float] = []

    def handle(_: int, frame: FrameType | None) -> None:
        heard.append(time.process_time())
        raise error

    before, begun = signal.signal(number, handle), time.process_time()
    try:
        signal.setitimer(timer, delay)
        call()
        signal.setitimer(timer, 0.0)
    except error:
        pass
    finally:
        signal.setitimer(timer, 0.0)
        signal.signal(number, before)
    if counts_work and heard and heard[0] - begun - delay > SOON:
        return f"heard after {heard[0] - begun - delay:.3f} s"
    return None
