"""The scenes that are not the paper's: balls dropped, boxes in a stack and in a heap, a tray of balls."""

from __future__ import annotations

import numpy as np

from softbody import SoftBody, World, icosphere
from softbody.collision.boxes import box_contacts, manifold
from softbody.collision.soft import soft_contacts
from softbody.dynamics import pressure
from softbody.scenes import ball_drop, box_pile, box_stack, tray
from validation import accounts
from validation.answers import Answers
from validation.cases import depths_of_boxes, edge_lengths, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.worlds.scenes import deepest
from validation.fault import Fault

FAMILY = "scenes over time"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

BALL = "world_.add_soft_body(ball_, mass=1.0, stiffness=s_, gas=g_, position=p_)"  # in ball_drop
APART = "separation_ > limits_.margin"  # in swept_manifold
HEAP_STEP = 1.0 / 240.0  # [s]


@check(
    section="2, 5.1",
    piece="softbody.scenes.ball_drop",
    reference="SciPy's DOP853 on springs and gas by its own formula, and the parabola; half-way to the ground",
    engines=("scipy",),
    unit="of the radius",
    tolerance=3e-9,
    because="rk4 at 1/32 of the stable step: 1.4e-10 at worst of ten seeds; the parabola is exact for it",
    faults=(
        Fault(
            "balls of the same springs",
            ball_drop.build,
            f"{BALL} → world_.add_soft_body(ball_, mass=1.0, stiffness=stiffnesses[0], gas=g_, position=p_)",
        ),
        Fault("the height from the centre", ball_drop.build, "0.5 + height → height"),
        Fault("gas that stays as springs grow", ball_drop.build, "0.15 * stiffness → 15.0"),
        Fault(
            "balls that weigh a hundredth less",
            ball_drop.build,
            f"{BALL} → world_.add_soft_body(ball_, mass=0.99, stiffness=s_, gas=g_, position=p_)",
        ),
    ),
)
def balls_drop(run: Run) -> Comparison:
    """Dropped balls of the scene fall and swell as SciPy's.

    They have 42 particles each, and fall from any height, each by its own springs and a tenth of their critical
    damping. They are side by side and alike in shape.
    """
    from references import scipy

    rng, answers, ball = run.fresh_rng(), Answers(), icosphere(1, 0.5)
    springs, mass = (ball.edges, edge_lengths(ball.vertices, ball.edges)), 1.0 / len(ball.vertices)
    for _ in range(run.count(2, 4, 20)):
        stiffnesses, height = 10.0 ** rng.uniform(2.0, 3.2, 3), rng.uniform(0.5, 2.0)
        world = ball_drop.build(list(stiffnesses), height, 1, World(integrator="rk4"))
        seconds = float(np.sqrt(height / 9.81))
        steps = int(np.ceil(32.0 * seconds / world.stable_time_step()))
        world.step(seconds / steps, steps)
        for k, (stiffness, kind) in enumerate(zip(stiffnesses, ("left", "middle", "right"))):
            what = *springs, np.full(len(ball.edges), stiffness), ball.triangles, 0.15 * stiffness, mass, seconds
            damping = 0.1 * np.sqrt(2.0 * stiffness * mass)
            shape, _ = scipy.motion(ball.vertices, np.zeros_like(ball.vertices), *what, rtol=1e-10, damping=damping)
            judged = shape + (1.4 * (k - 1), 0.0, 0.5 + 0.5 * height)
            answers.extend(SoftBody(world, k).positions / 0.5, judged / 0.5, kind=kind)
    return answers.comparison()


@check(
    section="4.4",
    piece="softbody.scenes.box_stack",
    reference="heights added up; depths by FCL",
    engines=("fcl",),
    unit="m off its height, aside and inside; rad of lean; m/s",
    tolerance=1.5e-8,
    because="landing leaves 6.1e-10 of 3 and 8 boxes at 60 steps a second, 3.5e-9 of 15",
    faults=(
        Fault("plates that lie lengthwise all", box_stack.build, "k % 2 == 0 → k % 2 < 2"),
        Fault("a stack with its second box aside", box_stack.build, "k % 3 == 0 → k % 3 != 0"),
        Fault(
            "boxes that touch only when 2 mm inside each other", manifold.swept_manifold, f"{APART} → {APART} - 0.002"
        ),
        Fault("knock-ons by a slop left out", box_contacts._find_pair, "WORTH * limits.slop → limits.slop"),
    ),
)
def boxes_stack(run: Run) -> Comparison:
    """Stacked boxes of the scene stand where thicknesses add up.

    There are 3 to 15, dropped on each other, at 240 and 60 steps a second. They stand flat, at rest and where they were
    put.
    """
    answers = Answers()
    for boxes in (3, 8, 15):
        for rate in (240, 60):
            world, number = box_stack.build(boxes), np.arange(boxes)
            start = world.state.box_position.copy()
            world.run(4.0, 1.0 / rate)
            state = world.state
            heights = 0.15 + 0.3 * number
            aside = np.where(number % 3 == 0, 0.04, -0.02)[:, None] * (1.0, -1.0)
            wide = np.where(number % 2 == 0, 1.2, 0.8)
            along = np.array([np.abs(rotation_matrix(q)[:, 2] - (0.0, 0.0, 1.0)).max() for q in state.box_orientation])
            rows = {
                "height": np.abs(state.box_position[:, 2] - heights).max(),
                "aside": np.abs(state.box_position[:, :2] - aside).max(),
                "lean": along.max(),
                "speed": np.abs(np.hstack([state.box_velocity, state.box_angular_velocity])).max(),
                "inside": max(depths_of_boxes(world)),
                "width": np.abs(world.model.box_size[:, 0] - wide).max(),
                "start": np.abs(start[:, 2] - (heights + 0.05 * (1 + number))).max(),
            }
            kinds = [f"{kind}, {rate} a second" for kind in rows]
            answers.extend(list(rows.values()), np.zeros(len(rows)), kind=kinds)
    return answers.comparison()


@check(
    section="4.4",
    piece="softbody.scenes.box_pile",
    reference="Bullet's heap of the same boxes; depths of ours by FCL, energy by NumPy",
    engines=("pybullet", "fcl"),
    unit="of the bound",
    least=4,
    tolerance=1.0,
    because="bounds: twice Bullet's deepest inside each other, one extreme of thousands of impacts, and Bullet's below"
    " the ground; 1e-3 of the energy, by lifting boxes out of each other; 1e-6 m/s",
    faults=(
        Fault(
            "a heap without friction",
            box_pile.build,
            "world_.add_ground(friction=0.6) → world_.add_ground(friction=0.0)",
        ),
        Fault(
            "boxes that touch only when 0.1 m inside each other", manifold.swept_manifold, f"{APART} → {APART} - 0.1"
        ),
    ),
)
def boxes_heap(run: Run) -> Comparison:
    """Boxes of the heap are no deeper in each other than Bullet's.

    There are 20 (standard 40). From the fall to rest they are not deeper inside each other or the ground than in
    Bullet. None is lost, energy is never gained, and after 8 s all rest.
    """
    from references.pybullet_world import BulletWorld

    world, bullet = box_pile.build(run.count(20, 40, 80)), BulletWorld(HEAP_STEP, 50, friction=0.6)
    bullet.add_ground()
    placed = world.state.box_position, world.state.box_orientation
    for size, mass, place, turn in zip(world.model.box_size, 1.0 / world.model.box_inverse_mass, *placed):
        bullet.add_box(size, mass, place, turn)
    least = start = accounts.energy(world)
    inside = below = gained = 0.0
    deepest_of_bullet = np.zeros(2)
    for step in range(round(8.0 / HEAP_STEP)):
        world.step(HEAP_STEP)
        bullet.step()
        energy = accounts.energy(world)
        gained, least = np.maximum(gained, energy - least), np.minimum(least, energy)
        if step % 4 == 0:
            inside, below = np.maximum((inside, below), depths_of_boxes(world))
        deepest_of_bullet = np.maximum(deepest_of_bullet, bullet.deepest())
    bullet.close()
    speed = float(np.sqrt((world.state.box_velocity**2).sum(axis=1).mean()))
    lost = float((np.abs(world.state.box_position[:, :2]) > 8.0).any())
    bounds = 2.0 * deepest_of_bullet[0], deepest_of_bullet[1], 1e-3 * start, 1e-6, 0.5
    kinds = ["inside", "below the ground", "energy", "speed", "lost"]
    notes = [
        "at the worst {:.1f} mm inside each other, {:.1f} mm below the ground; Bullet's {:.1f} and {:.1f} mm".format(
            *1e3 * np.array([inside, below, *deepest_of_bullet])
        )
    ]
    return Comparison([inside, below, gained, speed, lost], np.zeros(5), np.array(bounds), kinds, notes=notes)


@check(
    section="4.2, 4.3",
    piece="softbody.scenes.tray",
    reference="depths by igl's signed distance (pseudonormals), boxes as meshes; energy by NumPy",
    engines=("igl",),
    unit="of the bound",
    tolerance=1.0,
    because="bounds: what presses balls together makes them approach by a h² a step, which the contact undoes; but a"
    " single place with an edge's end inside stays for some steps: looked at every 10 ms it is 1.4 % deep at 0.2, and"
    " of 30 balls 0.5 % on average. 1e-3 of the energy, by parting what has approached",
    faults=(
        Fault("walls too near by their thickness", tray.build, "sign * (inner + WALL) → sign * (inner - WALL)"),
        Fault("soft bodies that do not meet", soft_contacts.near_bodies, "boxes_meet(a_, b_) → False"),
        Fault("gas that pushes with a third", pressure.gas_pressure, "gas_ / volume_ → gas_ / volume_ / 3.0"),
    ),
)
def balls_in_a_tray(run: Run) -> Comparison:
    """Balls in the tray stay there, whole and apart.

    There are 6 (standard 12), for 1.5 s (standard 2 s). None is lost or flat, and energy is never gained. Inside
    another, a wall or the ground none is deeper than 8 % of its radius at 0.9 of the stable step. At 0.2 of it that is
    2 %; the deepest place at a time is half as deep on average.
    """
    count = run.count(6, 12, 30)
    inner = 0.5 * tray.SPACING * np.ceil(np.sqrt(count / 2.0))
    answers = Answers()
    for part, bound in (0.9, 0.04), (0.2, 0.01):
        world = tray.build(count)
        step, full = part * world.stable_time_step(), SoftBody(world, 0).volume
        least = start = accounts.energy(world)
        depths = []
        for _ in range(run.count(15, 20, 40)):
            world.run(0.1, step)
            energy, soft = accounts.energy(world), [SoftBody(world, k) for k in range(count)]
            depths.append(np.maximum(0.0, deepest(world)))
            rows = {
                "inside": depths[-1] / bound,
                "lost": float(max(np.abs(body.centre[:2]).max() for body in soft) > inner),
                "energy": np.maximum(0.0, energy - least) / (1e-3 * abs(start)),
                "flat": 0.5 * full / min(body.volume for body in soft),
            }
            least = np.minimum(least, energy)
            kinds = [f"{kind}, {part} of the stable step" for kind in rows]
            answers.extend(list(rows.values()), np.zeros(4), kind=kinds)
        answers.add(np.mean(depths) / (0.5 * bound), 0.0, kind=f"inside on average, {part} of the stable step")
    return answers.comparison()
