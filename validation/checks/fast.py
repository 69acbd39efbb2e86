"""Fast bodies: nothing jumps through anything, at the step that the world is content with."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import softbody
from softbody import World
from softbody.collision import substeps
from validation.cases import random_orientations, rotation_matrix
from validation.check import DISAGREEMENTS, Comparison, Run, check
from validation.fault import Fault

FAMILY = "fast bodies"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

STEP = 0.8  # of the stable time step
FLIGHT = 0.06  # [s] of each shot
TARGETS = ("a fixed plate", "a plate that can move", "another ball")


def shoot(target: str, rng: np.random.Generator, make: Callable[..., World] = World) -> bool:
    """Shoot a soft ball of 0.2 m at 20 to 100 m/s, from anywhere on one side; tell whether it has stayed on that side.

    The plates are 4 × 4 × 0.1 m, in any orientation. `make` makes the world.
    """
    turn = random_orientations(rng, 1)[0]
    axes = rotation_matrix(turn)
    course = rng.normal(size=3)
    course[2] = -abs(course[2]) - 0.5
    course /= np.linalg.norm(course)
    aim = np.array([*rng.uniform(-0.5, 0.5, 2), 0.0]) if target != "another ball" else rng.uniform(-0.02, 0.02, 3)
    start, speed = aim - rng.uniform(0.6, 1.2) / abs(course[2]) * course, rng.uniform(20.0, 100.0)
    ball = softbody.icosphere(1, 0.2)
    world = make(gravity=(0.0, 0.0, 0.0))
    shot = world.add_soft_body(ball, 0.2, 200.0, 200.0, axes @ start, speed * axes @ course)
    if target == "another ball":
        other = world.add_soft_body(ball, 0.2, 200.0, 200.0)
    else:
        plate = world.add_box((4.0, 4.0, 0.1), None if target == "a fixed plate" else 50.0, orientation=turn)
    world.run(FLIGHT, STEP * world.stable_time_step())
    if target == "another ball":
        return bool((shot.centre - other.centre) @ axes @ course < 0.0)
    seen = (shot.positions - plate.position) @ rotation_matrix(plate.orientation)
    return bool((seen[:, 2] > 0.0).all() or np.abs(seen.mean(axis=0)[:2]).max() > 1.8)  # or it has slid off the plate


@check(
    family=FAMILY,
    claim="No soft ball shot at up to 100 m/s goes through a plate of 0.1 m, fixed or free, or through another ball.",
    section="6",
    piece="softbody.collision.substeps.subdivision",
    reference="invariant: what was in front stays in front",
    unit=DISAGREEMENTS,
    kind="invariant",
    tolerance=0.0,
    because="one passage is one too many",
    detects="a step that takes a ball through a plate: without splitting, a third of the shots",
    faults=(Fault("a step that is never split", substeps.subdivision, "int(ceil(parts_))", "1"),),
)
def nothing_passes_through(run: Run) -> Comparison:
    rng = run.fresh_rng()
    held, kinds = [], []
    for _ in range(run.count(40, 200, 3_334)):
        for target in TARGETS:
            held.append(shoot(target, rng))
            kinds.append(target)
    return Comparison(np.array(held), np.ones(len(held), bool), groups=kinds)
