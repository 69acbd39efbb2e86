"""What guards cost a step, and listening for interrupts a run: beside bare kernels, in turns, with equal answers.

`python -m benchmarks guards`. Two worlds begin alike and take the same steps; one is stepped by `World.step`, which
checks its arguments, the stable step and that all is finite, and listens where that is worth it; the other by kernels
alone, and in each round they change places. Their states must be the same to the bit. What kernels themselves look at,
every 32 steps of a soft body, is on both sides.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import process_time
from typing import NamedTuple

import numpy as np

import softbody
from softbody import World
from softbody.compiler.interrupts import NEVER_SET, InterruptFlag, listening
from softbody.stepping.runner import WORTH_LISTENING, Call

ROUND = 0.01  # [s] of the processor's time that a side steps in a round, about: others who use it too are not counted
MOST_STEPS = 20_000
LONG = 100  # steps that a run has at least


def ball(subdivisions: int) -> World:
    """Return a soft ball that falls on the ground."""
    world = World()
    world.add_ground()
    world.add_soft_body(softbody.icosphere(subdivisions, 0.5), 1.0, 200.0, 30.0, (0.0, 0.0, 0.6))
    return world


def joined() -> World:
    """Return two balls and a box that hang on each other."""
    world = World()
    one, other = (world.add_soft_body(softbody.icosphere(3, 0.5), 1.0, 200.0, 30.0, (2.0 * k, 0, 0)) for k in range(2))
    box = world.add_box((0.3, 0.3, 0.3), 1.0, (1.0, 0.0, 0.0))
    for a, b in (((one, 0), (box, box.position)), ((other, 0), (box, box.position)), ((one, 5), (0.0, 0.0, 2.0))):
        world.add_joint(a, b, 50.0, 0.1, 0.5)
    return world


WORLDS: dict[str, Callable[[], World]] = {
    "a ball of 42 particles": lambda: ball(1),
    "a ball of 642 particles": lambda: ball(3),
    "a ball of 10 242 particles": lambda: ball(5),
    "a pile of 10 boxes": lambda: softbody.scenes.box_pile.build(10),
    "a pile of 100 boxes": lambda: softbody.scenes.box_pile.build(100),
    "a tray of 10 balls": lambda: softbody.scenes.tray.build(10),
    "two balls and a box on joints": joined,
}


class Cost(NamedTuple):
    """What one thing costs more than another."""

    world: str
    what: str
    steps: int  # a call
    seconds: float  # [s] of the bare side, a step
    more: float  # part of that, median of all rounds
    quartiles: tuple[float, float]

    def __str__(self) -> str:
        """Say it in a line."""
        low, high = (100.0 * each for each in self.quartiles)
        each = f"{1e6 * self.seconds:.3g} µs a step, {self.steps} a call"
        return f"{self.world}, {self.what}: {100.0 * self.more:+.2f} % ({low:+.2f} … {high:+.2f}) of {each}"


Side = Callable[[World, float, int], None]


def guarded(world: World, h: float, steps: int) -> None:
    """Step as users do."""
    world.step(h, steps)


def deaf(world: World, h: float, steps: int) -> None:
    """Step by the kernels alone, which keep the clock, and do not listen."""
    _advance(world, h, steps, NEVER_SET)


def hearing(world: World, h: float, steps: int) -> None:
    """Step by the kernels alone, and listen."""
    with listening() as flag:
        _advance(world, h, steps, flag)


def _advance(world: World, h: float, steps: int, flag: InterruptFlag) -> None:
    call = Call(h, world.store.settings, (world.steps, world.time), flag)
    world.runner.advance(call, world.steps + steps, is_seen=True)


def costs(rounds: int = 100, names: str = "") -> Iterator[Cost]:
    """Yield what each costs, in worlds whose name contains `names`."""
    for name, build in WORLDS.items():
        if names not in name:
            continue
        h = _step_of(build())
        many = _steps_in(build, h, ROUND)
        yield cost(name, "nothing, which tells the noise", build, (deaf, deaf), (max(many, LONG), 1), rounds)
        yield cost(name, "guards in a run", build, (deaf, guarded), (max(many, LONG), 1), rounds)
        yield cost(name, "guards of steps one by one", build, (deaf, guarded), (1, max(2, min(many, 300))), rounds)
        listened = max(1, WORTH_LISTENING // _work_of(build()))
        calls = max(1, many // listened)
        yield cost(name, "listening, in the shortest run worth it", build, (deaf, hearing), (listened, calls), rounds)


def cost(
    name: str, what: str, build: Callable[[], World], sides: tuple[Side, Side], counts: tuple[int, int], rounds: int
) -> Cost:
    """Return what the second of two `sides` costs more than the first; `counts`: steps a call, and calls a round."""
    steps, calls = counts
    worlds = [build(), build()]
    h = _step_of(worlds[0])
    for world in worlds:
        world.step(h, 3)
    seconds = np.zeros((rounds + 1, 2))
    for k in range(rounds + 1):
        for side in (0, 1) if k % 2 else (1, 0):
            world, move = worlds[(side + k // 2) % 2], sides[side]
            begun = process_time()
            for _ in range(calls):
                move(world, h, steps)
            seconds[k, side] = process_time() - begun
        if worlds[0].state_hash() != worlds[1].state_hash():
            raise AssertionError(f"{name}, {what}: the answers are not the same")
    ratio = seconds[1:, 1] / seconds[1:, 0] - 1.0  # the first round warms up
    low, middle, high = np.percentile(ratio, (25, 50, 75))
    each = float(np.median(seconds[1:, 0])) / (steps * calls)
    return Cost(name, what, steps, each, float(middle), (float(low), float(high)))


def _step_of(world: World) -> float:
    """Return a step [s] so short that a world stays as it is."""
    return 1e-2 * min(world.stable_time_step(), 1e-2)


def _steps_in(build: Callable[[], World], h: float, seconds: float) -> int:
    """Return how many steps a world takes in so long [s]."""
    world = build()
    world.step(h, 2)
    steps = 1
    while True:
        begun = process_time()
        world.step(h, steps)
        spent = process_time() - begun
        if spent > 0.3 * seconds or steps >= MOST_STEPS:
            return max(1, min(MOST_STEPS, int(steps * seconds / spent)))
        steps *= 2


def _work_of(world: World) -> int:
    return len(world.state.particle_position) + 10 * world.model.box_count
