"""Fast bodies: nothing jumps through anything, at the step that the world is content with."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import softbody
from softbody import World
from softbody.collision.soft import split_steps
from validation.answers import Answers
from validation.cases import random_orientations, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.worlds.cases import NEVER_ACT, WEIGHTLESS, by_turns
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
    world = make(gravity=WEIGHTLESS)
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
    section="6",
    piece="softbody.collision.soft.split_steps.subdivision",
    reference="invariant: what was in front stays in front",
    kind="invariant",
    because="one passage is one too many",
    faults=(NEVER_ACT,),
)
def nothing_passes_through(run: Run) -> Comparison:
    """No soft ball shot at up to 100 m/s passes through anything.

    The targets are a plate of 0.1 m, fixed or free, and another ball.
    """
    rng, answers = run.fresh_rng(), Answers()
    for target in by_turns(3 * run.count(40, 200, 3_334), *TARGETS):
        answers.add(shoot(target, rng), True, kind=target)
    return answers.comparison()


@check(
    section="6",
    piece="softbody.collision.soft.split_steps.subdivision",
    reference="the rule, pair by pair, in NumPy; thickness: 2 V/A of a box, a ball or a plate",
    kind="closed form",
    unit="parts",
    tolerance=0.0,
    because="whole numbers",
    faults=(
        Fault("means that point back", split_steps._parts_of_motion, "add(mean_, x_) → sub(mean, x_)"),
        Fault("points that spread about nothing", split_steps._parts_of_motion, "sub(x_, mean_) → add(x_, mean)"),
        Fault("pairs that are near now alone", split_steps._parts_of_motion, "h_ * (x_ + spread_[b_]) → 0.0 * x_"),
        Fault("half of what spins", split_steps._parts_of_motion, "0.5 * norm(size_) → 0.25 * norm(size)"),
        Fault("boxes that fall as far as they are thick", split_steps._parts_of_fall, "FALL * thinnest_ → thinnest"),
    ),
)
def parts_of_a_step(run: Run) -> Comparison:
    """A step is cut into as few parts as the rule wants.

    Parts are equal. In one nothing that is near moves against a soft body by more than a quarter of the thinner one's
    thickness, and gravity moves no box by more than a sixteenth of the thinnest one's. Soft bodies and boxes fly, swell
    and spin anyhow.
    """
    rng, answers = run.fresh_rng(), Answers()
    while len(answers) < run.count(50, 250, 2_500):
        pull = 10.0 ** rng.uniform(0.0, 4.0) if rng.random() < 0.3 else 0.0  # [m/s²]
        world = World(gravity=(0.0, 0.0, -pull))
        h, pace = 10.0 ** rng.uniform(-3.0, -1.0), 10.0 ** rng.uniform(-0.5, 2.0)
        rows: list[tuple[np.ndarray, float, np.ndarray, float, float, bool]] = []
        thinnest = np.inf
        for _ in range(rng.integers(2, 5)):
            velocity = pace * rng.normal(size=3)
            # As far apart as they may come in a step, or much less or more.
            place = 10.0 ** rng.uniform(-0.5, 1.0) * rng.normal(size=3) * max(0.3, h * pace)
            if rng.random() < 0.6:
                size = rng.uniform(0.1, 0.5, 3)
                mesh = (softbody.icosphere(1, size[0]), softbody.box(size))[rng.integers(2)]
                swelling = pace * rng.normal(size=mesh.vertices.shape) * rng.uniform(0.0, 0.5)
                body = world.add_soft_body(mesh, 1.0, 100.0, 0.0, place)
                body.velocities[:] = flying = velocity + swelling
                corners = mesh.vertices[mesh.triangles]
                normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
                area, volume = 0.5 * np.linalg.norm(normals, axis=1).sum(), np.linalg.det(corners).sum() / 6.0
                mean = flying.mean(axis=0)
                spread = np.linalg.norm(flying - mean, axis=1).max()
                reach = np.linalg.norm(mesh.vertices, axis=1).max()
                rows.append((place, float(reach), mean, float(spread), float(2.0 * volume / area), True))
            else:
                size, spin = rng.uniform(0.05, 1.0, 3), pace * rng.normal(size=3)
                world.add_box(size, 1.0, place, velocity=velocity, angular_velocity=spin)
                reach, thinnest = 0.5 * np.linalg.norm(size), min(thinnest, size.min())
                rows.append((place, float(reach), velocity, float(reach * np.linalg.norm(spin)), size.min(), False))
        parts, is_clear = np.maximum(1.0, h * np.sqrt(pull / (0.0625 * thinnest))), True
        for k, one in enumerate(rows):
            for other in rows[:k]:
                # (A sphere around a soft body may be larger than the least one by a fifth.)
                apart, reach = np.linalg.norm(one[0] - other[0]), one[1] + other[1]
                come = h * (np.linalg.norm(one[2]) + one[3] + np.linalg.norm(other[2]) + other[3])
                closing = np.linalg.norm(one[2] - other[2]) + one[3] + other[3]
                if (one[5] or other[5]) and apart < 1.6 * reach + come:
                    parts = np.maximum(parts, h * closing / (0.25 * min(one[4], other[4])))
                    is_clear &= bool(apart < come + 0.4 * reach)
        if is_clear and (parts > 1.0 or rng.random() < 0.3):
            found = split_steps.subdivision(world.model, world.store.controls, world.state, None, h)
            judged = np.ceil(np.minimum(parts, 1_000.0))
            answers.add(found, judged, kind="one part" if judged == 1 else "several" if judged < 1_000 else "most")
    return answers.comparison()
