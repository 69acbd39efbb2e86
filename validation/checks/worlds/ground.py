"""Claims that the ground is where it was put, and as rough and as hard."""

from __future__ import annotations

import numpy as np

from softbody import ParameterError, World
from softbody.bodies import adding, ground
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
    """On a ground of any height, restitution and friction, which another call had made otherwise, a flat box comes to
    rest at half its thickness above it, slides for v²/2μg, and jumps e² as high as it fell."""
    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for _ in range(run.count(4, 20, 200)):
        height, restitution, friction = rng.uniform(-3.0, 3.0), rng.uniform(0.3, 0.8), rng.uniform(0.2, 0.9)
        size = rng.uniform((0.5, 0.5, 0.1), (1.0, 1.0, 0.3))
        top = height + 0.5 * size[2]

        resting, sliding, jumping = World(), World(), World()
        for world, numbers in (
            (resting, {"friction": friction}),
            (sliding, {"friction": friction}),
            (jumping, {"restitution": restitution, "friction": friction}),
        ):
            world.add_ground(height + 0.3, restitution=0.9, friction=0.05)
            world.add_ground(height, **numbers)
        box = resting.add_box(size, 1.0, (0.0, 0.0, top + 0.02))
        resting.step(STEP, 1_000)
        measured.append(box.position[2] - top)
        expected.append(0.0)
        kinds.append("at rest, m")

        speed = rng.uniform(1.0, 2.0)
        box = sliding.add_box(size, 1.0, (0.0, 0.0, top), velocity=(speed, 0.0, 0.0), friction=friction)
        way = 0.5 * speed**2 / (friction * FALL)
        sliding.run(2.0 * speed / (friction * FALL), STEP)
        measured.append(box.position[0] / way)
        expected.append(1.0)
        kinds.append("slides, of the way")

        drop = rng.uniform(0.5, 1.0)
        box = jumping.add_box(size, 1.0, (0.0, 0.0, top + drop))  # it jumps by the ground's restitution alone
        fallen = np.sqrt(2.0 * drop / FALL)
        jumping.run(fallen * (1.0 + restitution), STEP)  # to the highest place after it
        measured.append((box.position[2] - top) / drop)
        expected.append(restitution**2)
        kinds.append("jumps, of its fall")
    return Comparison(measured, expected, groups=kinds)


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
    """A ground that is not there is refused by name, and one that is there, at any height, is not: of worlds new, and
    restored from each other."""
    rng = run.fresh_rng()
    told, judged, kinds = [], [], []
    for _ in range(run.count(10, 40, 400)):
        bare, grounded = World(), World()
        grounded.add_ground(rng.uniform(-5.0, 5.0))
        for world, has in ((bare, False), (grounded, True)):
            for ask in ("check_there", "height", "friction"):
                told.append(not _refuses(world, ask))
                judged.append(has)
                kinds.append(f"{'a' if has else 'no'} ground: {ask}")
        kept = bare.snapshot(), grounded.snapshot()
        bare.restore(kept[1])
        grounded.restore(kept[0])
        told += [not _refuses(bare, "check_there"), not _refuses(grounded, "check_there")]
        judged += [True, False]
        kinds += ["restored"] * 2
    return Comparison(np.array(told), np.array(judged), groups=kinds)


def _refuses(world: World, ask: str) -> bool:
    """Tell whether the handle of a world's ground says that there is none."""
    try:
        found = getattr(world.ground, ask)
        if callable(found):
            found()
    except ParameterError as error:
        return "no ground" in str(error)
    return False
