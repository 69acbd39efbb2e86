"""Claims that piles of boxes, each a little twisted on the one below it, come to rest."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody import World
from softbody.collision.boxes import box_contacts
from softbody.collision.soft import split_steps
from softbody.collision.solver import sequential_impulses, support_trees
from validation.answers import Answers
from validation.cases import depths_of_boxes, random_orientations
from validation.check import Comparison, Run, check
from validation.checks.boxes.cases import about
from validation.fault import Fault

FAMILY = "boxes in motion"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

SOLVE_TREES = "softbody.collision.solver.support_trees.solve_trees"
NO_TREES = Fault(
    "piles left to the sweeps alone",
    sequential_impulses.part_at_targets,
    "solve_trees(contacts_, bodies_, order_, motion_, enough_) → 0",
)


class Pile(NamedTuple):
    """Boxes on top of each other, or above each other."""

    boxes: int
    gap: float  # [m] from box to box
    friction: float
    step: float  # [s]
    mixed: bool = False  # sizes, and places a little aside


PILES = [
    Pile(20, 0.1, 1.0, 1.0 / 60.0),
    Pile(50, 0.1, 0.3, 1.0 / 120.0),
    Pile(10, 0.1, 0.5, 1.0 / 60.0, mixed=True),
    Pile(6, 0.1, 0.2, 1.0 / 240.0),
    Pile(50, 0.1, 0.5, 1.0 / 240.0),
    Pile(20, 0.0, 0.2, 1.0 / 60.0),
    Pile(5, 0.0, 1.0, 1.0 / 240.0),
    Pile(30, 0.3, 0.5, 1.0 / 60.0),
    Pile(10, 1.0, 0.5, 1.0 / 30.0),
    Pile(30, 0.05, 0.2, 1.0 / 240.0, mixed=True),
    Pile(50, 0.0, 0.5, 1.0 / 60.0, mixed=True),
]


def boxes_of_pile(count: int, gap: float, mixed: bool, rng: np.random.Generator) -> list[tuple[np.ndarray, ...]]:
    """Return size [m], place [m] and orientation of each box, `gap` [m] above the one below it."""
    boxes: list[tuple[np.ndarray, ...]] = []
    height = 0.0
    for i in range(count):
        size = rng.uniform(0.7, 1.2, 3) if mixed else np.ones(3)
        aside = rng.uniform(-0.03, 0.03, 2) if mixed else np.zeros(2)
        place = np.array([*aside, height + 0.5 * size[2]])
        boxes.append((size, place, about(2, 0.3 * np.sin(5.0 * i))))
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
    section="4.4",
    piece=SOLVE_TREES,
    reference="bounds",
    unit="of the bound",
    kind="bound",
    tolerance=1.0,
    because="bounds: 8 nm aside, of piles of mixed sizes and a little aside 20 µm, for they settle: 2.5 nm and 5.6 µm"
    " at worst; after 8 s at rest to rounding, 1e-14 m/s, 4.3e-16 at worst, and 2 s of that",
    faults=(
        NO_TREES,
        Fault(
            "equations that forget where a body's weight bears on what carries it",
            support_trees._add_moved,
            "add((pull_[3], pull_[4], pull_[5]), cross(arm_, x_)) → (pull_[3], pull_[4], pull_[5])",
        ),
        Fault("what an impact leaves not solved for again", support_trees._correct, "abs(x_) > FINE * enough_ → False"),
        Fault("trees given up after one round", support_trees._correct, "left_[i_] and x_ <= y_ → False"),
        Fault("contacts that are entered do not join", support_trees._close_contact, "x_ and y_ > enough_ → False"),
        Fault(
            "boxes that fall not stopped by those below that are stopped",
            box_contacts.find_knock_ons,
            "change_ > grazing_depth(x_, y_, slop_) → False",
        ),
    ),
)
def rest_of_piles(run: Run) -> Comparison:
    """Piles of twisted boxes stand where they were put, at rest.

    They are 5 to 50 boxes, placed or dropped by 0.05 to 1 m each, with friction of 0.2 to 1. Boxes are equal or
    (dropped by 0.1 m at most) of mixed sizes and a little aside. So piles stand after 8 s, at 240 to 30 steps a second,
    and stay so for 2 s.
    """
    rng, answers, worst = run.fresh_rng(), Answers(), 0.0
    for pile in PILES[: run.count(3, len(PILES), len(PILES))]:
        world = piled(boxes_of_pile(pile.boxes, pile.gap, pile.mixed, rng), pile.friction)
        start = world.state.box_position.copy()
        world.run(8.0, pile.step)
        speed, places = np.abs(world.state.box_velocity).max(), world.state.box_position.copy()
        world.run(2.0, pile.step)
        aside, creep = (np.abs((world.state.box_position - then)[:, :2]).max() for then in (start, places))
        kinds = [f"{what}, {round(1.0 / pile.step)} steps a second" for what in ("aside", "speed", "creep")]
        answers.extend([aside / (2e-5 if pile.mixed else 8e-9), speed / 1e-14, creep / 2e-14], np.zeros(3), kind=kinds)
        worst = np.maximum(worst, speed)
    return answers.comparison(notes=[f"fastest after 8 s: {worst:.1e} m/s"])


@check(
    section="4.4",
    piece=SOLVE_TREES,
    reference="bounds",
    unit="m, m/s",
    kind="bound",
    tolerance=6e-9,
    because="rounding of places 50 m high, 7e-15, doubles at impacts: 2.8e-10 aside of twenty boxes, 6.3e-10 of fifty",
    faults=(NO_TREES,),
)
def tall_pile(run: Run) -> Comparison:
    """Fifty twisted boxes on top of each other stay upright.

    They are placed or dropped by 0.1 m each, and stand after 8 s (quick: twenty boxes; full: 40 s).
    """
    count, answers = run.count(20, 50, 50), Answers()
    for gap, friction, h in ((0.0, 0.5, 1.0 / 240.0), (0.1, 0.5, 1.0 / 240.0), (0.1, 1.0, 1.0 / 60.0)):
        world = piled(boxes_of_pile(count, gap, False, run.fresh_rng()), friction)
        world.run(run.count(8, 8, 40), h)
        answers.add(np.abs(world.state.box_position[:, :2]).max(), 0.0, kind="aside")
        answers.add(np.abs(world.state.box_velocity).max(), 0.0, kind="speed")
    return answers.comparison()


@check(
    section="4.4",
    piece=SOLVE_TREES,
    reference="the same piles in three engines, with their defaults",
    engines=("pybullet", "mujoco", "rapier3d"),
    unit="of the best; of 1 nm",
    least=4,
    tolerance=1.0,
    because="bounds: the best engine's speed, which ours is 2e-5 of, and 1 nm, for rounding of places 20 m high, 4e-15,"
    " grows to 0.28 nm from impact to impact",
    faults=(NO_TREES,),
)
def rest_beside_engines(run: Run) -> Comparison:
    """Piles of boxes lie as still as in the best engine.

    After 10 s, 10 to 50 twisted boxes, placed or dropped, are no faster than in the best of Bullet, MuJoCo and Rapier.
    They lie no farther aside than there by 1 nm.
    """
    from references.piles import ENGINES

    answers, notes = Answers(), []
    piles = [Pile(10, 0.0, 0.5, 1.0 / 240.0), Pile(20, 0.1, 0.5, 1.0 / 60.0), Pile(50, 0.1, 0.5, 1.0 / 240.0)]
    for pile in piles[: run.count(2, 3, 3)]:
        boxes, steps = boxes_of_pile(pile.boxes, pile.gap, pile.mixed, run.fresh_rng()), round(10.0 / pile.step)
        world = piled(boxes, pile.friction)
        world.step(pile.step, steps)
        ended = {"ours": (world.state.box_position, world.state.box_velocity)}
        ended |= {name: judge(boxes, pile.friction, pile.step, steps) for name, judge in ENGINES.items()}
        aside = {name: float(np.abs(places[:, :2]).max()) for name, (places, _) in ended.items()}
        speed = {name: float(np.abs(velocities).max()) for name, (_, velocities) in ended.items()}
        best_speed, best_aside = (min(rows[name] for name in ENGINES) for rows in (speed, aside))
        answers.add(np.maximum(speed["ours"] / best_speed, 0.0), 0.0, kind="speed")
        answers.add(np.maximum((aside["ours"] - best_aside) / 1e-9, 0.0), 0.0, kind="aside")
        told = ", ".join(f"{name} {speed[name]:.1e} m/s, {aside[name]:.1e} m aside" for name in ended)
        how = f"dropped by {pile.gap} m each, {round(1.0 / pile.step)} steps a second"
        notes.append(f"{pile.boxes} boxes, {how}: {told}")
    return answers.comparison(notes=notes)


@check(
    section="beyond the paper",
    piece=SOLVE_TREES,
    reference="they stay",
    unit="m",
    kind="bound",
    least=2,
    tolerance=5e-13,
    because="a bound: 2 400 steps round places of up to 2 m by 2.2e-16 each, and nothing else may move them; 1e-17 is"
    " seen. A speed that is not worth another sweep, 4e-6 m/s, would be 4e-5 m",
    faults=(
        Fault(
            "half the friction",
            sequential_impulses._sweep,
            "load_lanes(row_[FRICTION], 0) * normal_ → 0.5 * load_lanes(row_[FRICTION], 0) * normal_",
        ),
    ),
)
def incline_of_piles(run: Run) -> Comparison:
    """Boxes on an incline do not creep.

    One box and three stand at 0.1 or 0.3 rad with μ = 0.5, for 10 s.
    """
    answers = Answers()
    for count in (1, 3)[: run.count(1, 2, 2)]:
        for slope in (0.1, 0.3):
            world, tilt, up = World(), about(1, slope), np.array([np.sin(slope), 0.0, np.cos(slope)])
            world.add_box((50.0, 50.0, 1.0), None, orientation=tilt, friction=0.5)
            for i in range(count):
                world.add_box((1.0, 1.0, 0.4), 1.0, (0.7 + 0.4 * i) * up, tilt, friction=0.5)
            world.run(1.0, 1.0 / 240.0)
            places = world.state.box_position.copy()
            world.run(10.0, 1.0 / 240.0)
            answers.add(np.linalg.norm(world.state.box_position - places, axis=1).max(), 0.0)
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.collision.soft.split_steps.subdivision",
    reference="FCL's depth of boxes in each other; heights of corners",
    engines=("fcl",),
    unit="of the thickness of the thinnest",
    kind="bound",
    tolerance=0.0625,
    because="the rule: gravity moves boxes by no more in a part of a step, and they may be left so deep",
    faults=(
        Fault(
            "boxes that fall as far as they like", split_steps._parts_of_fall, "sqrt(x_) if any_moves_ else 1.0 → 1.0"
        ),
    ),
)
def small_boxes_lie_on_each_other(run: Run) -> Comparison:
    """Boxes of any size come to lie on each other.

    Five cubes of 10 µm to 1 m fall on the ground, in any orientation. Or they are 0.2 m large, and fall on a plate of
    10 µm to 10 mm. At 240 steps a second they rest after 2 s, hardly inside each other, below the ground or the plate.
    """
    rng, answers = run.fresh_rng(), Answers()
    for kind in ("small boxes", "a thin plate") * run.count(4, 20, 100):
        world, side, thin = World(), 0.2, 10.0 ** rng.uniform(-5.0, -2.0)
        if kind == "a thin plate":
            world.add_box((20.0, 20.0, thin), None, (0.0, 0.0, -0.5 * thin))
        else:
            side = thin = 10.0 ** rng.uniform(-5.0, 0.0)
            world.add_ground()
        for k, turn in enumerate(random_orientations(rng, 5)):
            place = side * np.array([*rng.uniform(-0.3, 0.3, 2), 1.0 + 1.8 * k])
            world.add_box((side,) * 3, 1000.0 * side**3, place, turn)
        world.run(2.0 + 2.0 * np.sqrt(side), 1.0 / 240.0)
        answers.add(max(depths_of_boxes(world, thin)), 0.0, kind=kind)
    return answers.comparison()
