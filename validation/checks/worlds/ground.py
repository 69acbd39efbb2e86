"""Claims that the ground is where it was put, and as rough and as hard."""

from __future__ import annotations

import numpy as np

from softbody import ParameterError, World
from softbody.bodies import adding, ground
from validation.answers import Answers
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

SET = "store.model._replace(ground_height=height, ground_restitution=restitution, ground_friction=f_)"  # in add_ground
STEP = 1.0 / 2000.0  # [s]
FALL = 9.81  # [m/s²]


@check(
    section="4.4",
    piece="softbody.World.add_ground",
    reference="closed forms: Coulomb's friction, Newton's restitution",
    kind="closed form",
    unit="m, and of the way or the fall",
    tolerance=0.01,
    because="a step's fall, v h, of some decimetres: 0.5 %; at rest 1e-9 m",
    faults=(
        Fault(
            "a ground at zero",
            adding.add_ground,
            f"{SET} → "
            "store.model._replace(ground_height=0.0 * height, ground_restitution=restitution, ground_friction=f_)",
        ),
        Fault(
            "restitution for friction",
            adding.add_ground,
            "0.0 if store.settings.frictionless else friction → restitution",
        ),
        Fault(
            "friction for restitution",
            adding.add_ground,
            f"{SET} → store.model._replace(ground_height=height, ground_restitution=friction, ground_friction=f_)",
        ),
        Fault(
            "what was first said",
            adding.add_ground,
            f"{SET} → store.model._replace(ground_height=height, ground_friction=f_)",
        ),
    ),
)
def ground_is_as_told(run: Run) -> Comparison:
    """The ground is as high, hard and rough as told.

    Another call had made it otherwise. A flat box comes to rest at half its thickness above it, slides for v²/2μg, and
    jumps e² as high as it fell.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(4, 20, 200)):
        height, restitution, friction = rng.uniform(-3.0, 3.0), rng.uniform(0.3, 0.8), rng.uniform(0.2, 0.9)
        size = rng.uniform((0.5, 0.5, 0.1), (1.0, 1.0, 0.3))
        top = height + 0.5 * size[2]
        resting, sliding, jumping = (World() for _ in range(3))
        for world in (resting, sliding, jumping):
            world.add_ground(height + 0.3, restitution=0.9, friction=0.05)
            world.add_ground(height, restitution=restitution if world is jumping else 0.0, friction=friction)
        box = resting.add_box(size, 1.0, (0.0, 0.0, top + 0.02))
        resting.step(STEP, 1_000)
        answers.add(box.position[2] - top, 0.0, kind="at rest, m")

        speed = rng.uniform(1.0, 2.0)
        box = sliding.add_box(size, 1.0, (0.0, 0.0, top), velocity=(speed, 0.0, 0.0), friction=friction)
        sliding.run(2.0 * speed / (friction * FALL), STEP)
        answers.add(box.position[0] / (0.5 * speed**2 / (friction * FALL)), 1.0, kind="slides, of the way")

        drop = rng.uniform(0.5, 1.0)
        box = jumping.add_box(size, 1.0, (0.0, 0.0, top + drop))  # it jumps by the ground's restitution alone
        fallen = np.sqrt(2.0 * drop / FALL)
        jumping.run(fallen * (1.0 + restitution), STEP)  # to the highest place after it
        answers.add((box.position[2] - top) / drop, restitution**2, kind="jumps, of its fall")
    return answers.comparison()


@check(
    section="4.4",
    piece="softbody.Ground.check_there",
    reference="whether `add_ground` was called",
    kind="specification",
    faults=(
        Fault("a ground below zero is none", ground.Ground, '-float("inf") → 0.0'),
        Fault("a ground that is always there", ground.Ground.check_there, "not self.is_there → False"),
    ),
)
def grounds_are_there_or_not(run: Run) -> Comparison:
    """A ground that is not there is refused by name.

    One that is there, at any height, is not: of worlds new, and restored from each other.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(10, 40, 400)):
        bare, grounded = World(), World()
        grounded.add_ground(rng.uniform(-5.0, 5.0))
        for world, has in ((bare, False), (grounded, True)):
            for ask in ("check_there", "height", "friction"):
                answers.add(not _refuses(world, ask), has, kind=f"{'a' if has else 'no'} ground: {ask}")
        kept = bare.snapshot(), grounded.snapshot()
        bare.restore(kept[1])
        grounded.restore(kept[0])
        for world, has in ((bare, True), (grounded, False)):
            answers.add(not _refuses(world, "check_there"), has, kind="restored")
    return answers.comparison()


def _refuses(world: World, ask: str) -> bool:
    """Tell whether the handle of a world's ground says that there is none."""
    try:
        found = getattr(world.ground, ask)
        if callable(found):
            found()
    except ParameterError as error:
        return "no ground" in str(error)
    return False
