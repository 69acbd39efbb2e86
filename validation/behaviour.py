"""What do the paper's own rules make of its scenes, beside the defaults? Runs each scene by both and measures."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import perf_counter

import numpy as np

from softbody import SoftBody, World
from softbody.quaternion import rotate
from softbody.scenes import boxes_on_torus, rolling_torus, sphere_on_torus, torus_stack
from validation.engines import missing
from validation.record import Behaviour

SECONDS = 4.0  # of each scene
LOOK = 0.05  # [s] between two looks
STEP = 0.8  # of the stable time step

DEFAULTS, PAPER = "the defaults", "the paper's own"
RULES: dict[str, Callable[[], World]] = {DEFAULTS: World, PAPER: World.paper}
SCENES = {
    "1 sphere on torus": sphere_on_torus.build,
    "2 rolling torus": rolling_torus.build,
    "3 boxes on torus": boxes_on_torus.build,
    "4 stack of tori": torus_stack.build,
}


def behaviours_of(scene: str, seconds: float = SECONDS) -> list[Behaviour]:
    """Run a scene by each of the RULES, in turns, and return what was seen."""
    films = {rules: Film(SCENES[scene](world=world())) for rules, world in RULES.items()}
    for film in films.values():
        film.look(film.step)  # compiles, and is not timed
        film.seconds = 0.0
    for _ in range(round(seconds / LOOK)):
        for film in films.values():
            film.look(LOOK)
    cost = {rules: film.seconds / film.steps for rules, film in films.items()}
    return [
        Behaviour(scene, rules, *film.seen(), cost[rules] / cost[DEFAULTS], film.rolls()) for rules, film in films.items()
    ]


class Film:
    """A world that is run and looked at now and then."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.step = STEP * world.stable_time_step()
        self.start = world.state.position.copy()
        self.size = max(np.ptp(SoftBody(world, i).positions, axis=0).max() for i in range(len(world.model.gas)))
        self.weight = (1.0 / world.model.inverse_mass).sum() + (1.0 / world.model.box_inverse_mass).sum()
        self.seconds, self.steps = 0.0, 0
        self.depth, self.gain = 0.0, 0.0
        self.least = self.energy()
        self.scale = self.energy() - self.springs()

    def look(self, seconds: float) -> None:
        """Run for a while, on the clock, then measure."""
        steps = max(1, round(seconds / self.step))
        begin = perf_counter()
        self.world.step(seconds / steps, steps)
        self.seconds += perf_counter() - begin
        self.steps += steps
        energy = self.energy()
        self.gain = max(self.gain, energy - self.least)
        self.least = min(self.least, energy)
        self.depth = max(self.depth, *deepest(self.world))
