"""Claims about boxes that are set in motion within a step: what they go into then, and how fast they go on."""

from __future__ import annotations

from typing import Any

import numpy as np

from softbody import World
from softbody.collision.boxes import box_contacts, manifold
from softbody.collision.solver import sequential_impulses, warm_start
from validation.answers import Answers
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "boxes that pass"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

SIDE = 0.2  # [m] of the cubes
NO_KNOCK_ON = Fault(
    "nobody looked at again whom a contact has struck",
    box_contacts.find_knock_ons,
    "change_ > grazing_depth(x_, y_, slop_) → False",
)


@check(
    section="4.4, 4.5",
    piece="softbody.collision.boxes.box_contacts.find_knock_ons, softbody.World.step",
    reference="which side of a wall a box is on",
    kind="closed form",
    faults=(
        NO_KNOCK_ON,
        Fault(
            "what closes left out", manifold.closes, "dot(way_, normal_) < x_ → dot(way, normal) > manifold.depth[k]"
        ),
        Fault(
            "only boxes that are struck themselves looked at",
            box_contacts._find_more,
            "not (of[a_] or of[b_]) or x_ → not (of[a] and of[b]) or x_",
        ),
    ),
)
def struck_before_a_wall(run: Run) -> Comparison:
    """A box that is struck stays before the wall behind it.

    The wall is 2 mm to 2 cm thick, and 0.1 mm to 1 cm behind it; what strikes it comes at 1 to 30 m/s, with a tenth to
    ten times its mass. It is struck in its middle or aside, stands straight or askew, or two of them stand in a row.
    Steps are of 1/30 to 1/480 s, with gravity and a ground or without.
    """
    rng, answers = run.fresh_rng(), Answers()
    for k in range(run.count(160, 800, 8_000)):
        kind = ("in its middle", "aside", "askew", "in a row")[k % 4]
        gap, restitution = 10.0 ** rng.uniform(-4.0, -2.0), rng.choice([0.0, rng.uniform(0.0, 0.9)])
        rubs: Any = {"restitution": restitution, "friction": 0.3}
        world = World(gravity=(0.0, 0.0, -9.81 if k % 8 < 4 else 0.0))
        if k % 8 < 4:
            world.add_ground(**rubs)
        thick, speed, step = (
            10.0 ** rng.uniform(-2.7, -1.7),
            10.0 ** rng.uniform(0.0, 1.5),
            1.0 / rng.choice([30, 120, 480]),
        )
        world.add_box((thick, 4.0, 4.0), None, (0.5 * thick, 0.0, 0.0), **rubs)
        angle = rng.uniform(-0.2, 0.2) if kind == "askew" else 0.0
        half = 0.5 * SIDE * (np.cos(angle) + abs(np.sin(angle)))
        turned = np.cos(0.5 * angle), 0.0, 0.0, np.sin(0.5 * angle)
        place, boxes = -gap - half, []
        for _ in range(2 if kind == "in a row" else 1):
            mass = 10.0 ** rng.uniform(-0.5, 0.5)
            boxes.append(world.add_box((SIDE,) * 3, mass, (place, 0.0, 0.5 * SIDE), turned, **rubs))
            place -= SIDE + gap
        aside = rng.uniform(-0.5, 0.5) * SIDE if kind == "aside" else 0.0
        where = place - half - 0.5 * SIDE, aside, 0.5 * SIDE
        striker = world.add_box((SIDE,) * 3, 10.0 ** rng.uniform(-0.5, 0.5), where, velocity=(speed, 0.0, 0.0), **rubs)
        world.step(step, int(np.ceil(1.0 / (speed * step))) + 20)
        answers.add([float(any(box.position[0] > 0.0 for box in (*boxes, striker)))], [0.0], kind=kind)
    return answers.comparison()


@check(
    section="4.4",
    piece="softbody.collision.solver.warm_start.start_from_cache, softbody.World.step",
    reference="closed form: the pusher's speed",
    unit="of the bound",
    kind="bound",
    tolerance=1.0,
    because="bounds: 10 % of the speed, and 1 % on average, for sweeps end before rows are solved; at the end 1e-3 of"
    " it, for speeds that the solver counts as rest: 0.45 at worst of ten seeds",
    faults=(
        Fault(
            "an impact's impulses given once more",
            warm_start.start_from_cache,
            "thrown_ or parting_ > x_ → False",
        ),
        Fault(
            "pushers that give way to less than there was before",
            sequential_impulses._give_way,
            "max(0.0, row[NORMAL_IMPULSE, lane] - begun[place]) → row[NORMAL_IMPULSE, lane] - begun[place]",
        ),
    ),
)
def rows_that_are_pushed(run: Run) -> Comparison:
    """A row that a pusher strikes goes no faster than it.

    Two to four boxes stand on a smooth plate, 0.1 to 5 mm apart, of masses up to ten times each other's. The pusher
    comes at 0.5 to 1.5 m/s. After half a second none goes slower.
    """
    rng, answers, faster = run.fresh_rng(), Answers(), []
    smooth: Any = {"friction": 0.0, "restitution": 0.0}
    for k in range(run.count(30, 120, 1_000)):
        speed, gap, number = rng.uniform(0.5, 1.5), 10.0 ** rng.uniform(-4.0, -2.3), 2 + k % 3
        world = World(gravity=(0.0, 0.0, -9.81))
        world.add_box((200.0, 200.0, 2.0), None, (0.0, 0.0, -1.0), **smooth)
        world.add_box((0.5, 1.0, 0.3), None, (-0.251, 0.0, 0.16), velocity=(speed, 0.0, 0.0), **smooth)
        for place in range(number):
            mass, x = 10.0 ** rng.uniform(-0.5, 0.5), 0.25 + (0.5 + gap) * place
            world.add_box((0.5, 0.6, 0.3), mass, (x, 0.0, 0.15), **smooth)
        fastest = 0.0
        for _ in range(120):
            world.step(1.0 / 240.0)
            fastest = np.maximum(fastest, np.max(world.state.box_velocity[2:, 0]))
        behind = np.maximum(0.0, speed - np.min(world.state.box_velocity[2:, 0]))
        faster.append(fastest / speed - 1.0)
        answers.add([(fastest / speed - 1.0) / 0.1, behind / speed / 1e-3], [0.0, 0.0], kind=f"{number} boxes")
    answers.add([np.mean(faster) / 0.01, 0.0], [0.0, 0.0], kind="on average")
    return answers.comparison()
