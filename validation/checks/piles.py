"""Piles of boxes, each a little twisted on the one below it: do they come to rest?"""

from __future__ import annotations

import numpy as np

from softbody import World
from softbody.collision import sequential_impulses, support_trees
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "boxes in motion"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

NO_TREES = Fault(
    "piles left to the sweeps alone",
    sequential_impulses.solve_velocities,
    "solve_trees(contacts_, bodies_, order_, motion_, enough_)",
    "0",
)
FRAMES = {"1/240 s": 1.0 / 240.0, "1/60 s": 1.0 / 60.0}


def boxes_of_pile(count: int, gap: float, mixed: bool, rng: np.random.Generator) -> list[tuple[np.ndarray, ...]]:
    """Return size [m], place [m] and orientation of each box, `gap` [m] above the one below it."""
    boxes: list[tuple[np.ndarray, ...]] = []
    height = 0.0
    for i in range(count):
        size = rng.uniform(0.7, 1.2, 3) if mixed else np.ones(3)
        half = 0.15 * np.sin(5.0 * i)
        place = np.array([0.0, 0.0, height + 0.5 * size[2]])
        boxes.append((size, place, np.array([np.cos(half), 0.0, 0.0, np.sin(half)])))
        height += size[2] + gap
    return boxes


def piled(boxes: list[tuple[np.ndarray, ...]], friction: float) -> World:
    """Return a world of our defaults with these boxes on the ground."""
    world = World()
    world.add_ground(friction=friction)
    for size, place, orientation in boxes:
        world.add_box(size, float(np.prod(size)), place, orientation, friction=friction)
    return world


@check(
    family=FAMILY,
    claim="Piles of 5 to 20 twisted boxes, placed or dropped by 0.1 m each, equal or of mixed sizes, with friction of "
    "0.2 to 1, are at rest after 8 s, at 240 and at 60 steps a second, and stay where they are for 2 s.",
    section="4.4",
    piece="softbody.collision.support_trees.solve_trees",
    reference="bounds",
    unit="of the bound",
    tolerance=1.0,
    because="bounds: 1e-4 m/s after 8 s (solved up to 1e-4 g h in each step, which is 4e-6 to 2e-5 m/s), "
    "and 0.01 mm in the 2 s after (depths beyond g h² fade by a fifth a step)",
    detects="a pile that shakes, creeps, or feeds itself from step to step",
    faults=(
        NO_TREES,
        Fault(
            "equations that forget where a body's weight bears on what carries it",
            support_trees._add_moved,
            "add((pull_[3], pull_[4], pull_[5]), cross(arm_, x_))",
            "(pull_[3], pull_[4], pull_[5])",
        ),
    ),
)
def rest_of_piles(run: Run) -> Comparison:
    rng = run.fresh_rng()
    cases = [(10, 0.1, 0.5, False), (20, 0.0, 0.2, False), (20, 0.1, 1.0, False)]
    cases += [(5, 0.0, 1.0, False), (6, 0.1, 0.2, False), (10, 0.1, 0.5, True), (20, 0.1, 0.2, True)]
    measured, kinds, worst = [], [], 0.0
    for count, gap, friction, mixed in cases[: run.count(2, 7, 7)]:
        for name, h in FRAMES.items():
            world = piled(boxes_of_pile(count, gap, mixed, rng), friction)
            world.run(8.0, h)
            speed, places = np.abs(world.state.box_velocity).max(), world.state.box_position.copy()
            world.run(2.0, h)
            creep = np.abs(world.state.box_position - places).max()
            measured += [speed / 1e-4, creep / 1e-5]
            kinds += [f"speed, {name}", f"creep, {name}"]
            worst = max(worst, speed)
    return Comparison(measured, np.zeros(len(measured)), groups=kinds, notes=[f"fastest after 8 s: {worst:.1e} m/s"])


@check(
    family=FAMILY,
    claim="Fifty twisted boxes on top of each other (quick: twenty) stand as they were placed for 4 s (full: 40 s).",
    section="4.4",
    piece="softbody.collision.support_trees.solve_trees",
    reference="bounds",
    unit="m, m/s",
    tolerance=1e-3,
    because="1 mm aside for a pile of 50 m, and 1 mm/s: what an eye would see",
    detects="a tall pile that bends, and falls",
    faults=(NO_TREES,),
)
def tall_pile(run: Run) -> Comparison:
    count = run.count(20, 50, 50)
    world = piled(boxes_of_pile(count, 0.0, False, run.fresh_rng()), 0.5)
    world.run(run.count(4, 4, 40), 1.0 / 240.0)
    aside, speed = np.abs(world.state.box_position[:, :2]).max(), np.abs(world.state.box_velocity).max()
    return Comparison([aside, speed], [0.0, 0.0], groups=["aside", "speed"])


@check(
    family=FAMILY,
    claim="After 10 s piles of 10 and 20 twisted boxes, placed, move a hundred times less than Bullet's, and lie a "
    "hundred times less aside.",
    section="4.4",
    piece="softbody.collision.support_trees.solve_trees",
    reference="pybullet's pile of the same boxes, with as many iterations as our sweeps at most",
    engines=("pybullet",),
    unit="of Bullet's",
    tolerance=0.01,
    because="Bullet's speeds are 1e-5 to 1e-2 m/s, its piles 1 mm to 6 cm aside; ours are solved in every step",
    detects="a pile that is left to sweeps, as Bullet's is",
    faults=(NO_TREES,),
)
def rest_beside_bullet(run: Run) -> Comparison:
    from references.pybullet_world import BulletWorld

    measured, kinds, notes = [], [], []
    h = 1.0 / 240.0
    for count in (10, 20)[2 - run.count(1, 2, 2) :]:
        boxes = boxes_of_pile(count, 0.0, False, run.fresh_rng())
        world, bullet = piled(boxes, 0.5), BulletWorld(h, World().settings.iterations, friction=0.5)
        bullet.add_ground()
        for size, place, orientation in boxes:
            bullet.add_box(size, float(np.prod(size)), place, orientation)
        world.run(10.0, h)
        bullet.step(round(10.0 / h))
        ours = np.abs(world.state.box_velocity).max(), np.abs(world.state.box_position[:, :2]).max()
        theirs = np.abs(bullet.velocities()[:, :3]).max(), np.abs(bullet.positions()[:, :2]).max()
        bullet.close()
        measured += [ours[0] / theirs[0], ours[1] / theirs[1]]
        kinds += ["speed", "aside"]
        notes.append(
            f"{count} boxes after 10 s: {ours[0]:.1e} m/s, {ours[1]:.1e} m aside; "
            f"Bullet's {theirs[0]:.1e} m/s, {theirs[1]:.1e} m"
        )
    return Comparison(measured, np.zeros(len(measured)), groups=kinds, notes=notes)


@check(
    family=FAMILY,
    claim="One box and three on an incline of 0.1 or 0.3 rad with μ = 0.5 do not creep within 10 s.",
    section="beyond the paper",
    piece="softbody.collision.support_trees.solve_trees",
    reference="they stay",
    unit="m",
    tolerance=1e-6,
    because="10 s with a speed that is not worth another sweep, 4e-6 m/s, would be 4e-5 m; solved, it is a thousandth",
    detects="friction that is too small, or fades from step to step",
    faults=(
        Fault(
            "half the friction",
            sequential_impulses._sweep,
            "contacts_.friction[k_] * normal_",
            "0.5 * contacts_.friction[k_] * normal_",
        ),
    ),
)
def incline_of_piles(run: Run) -> Comparison:
    measured = []
    for count in (1, 3)[: run.count(1, 2, 2)]:
        for slope in (0.1, 0.3):
            tilt, up = (
                (np.cos(0.5 * slope), 0.0, np.sin(0.5 * slope), 0.0),
                np.array([np.sin(slope), 0.0, np.cos(slope)]),
            )
            world = World()
            world.add_box((50.0, 50.0, 1.0), None, orientation=tilt, friction=0.5)
            for i in range(count):
                world.add_box((1.0, 1.0, 0.4), 1.0, (0.7 + 0.4 * i) * up, tilt, friction=0.5)
            world.run(1.0, 1.0 / 240.0)
            places = world.state.box_position.copy()
            world.run(10.0, 1.0 / 240.0)
            measured.append(np.linalg.norm(world.state.box_position - places, axis=1).max())
    return Comparison(measured, np.zeros(len(measured)))
