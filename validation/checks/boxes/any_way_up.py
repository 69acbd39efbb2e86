"""Claims that boxes move the same whichever way is down, and whatever their own axes are called."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from softbody import World
from softbody.collision.boxes import box_contacts, swept_boxes
from validation.answers import Answers
from validation.check import Comparison, Run, check
from validation.checks.boxes.cases import renamed
from validation.fault import Fault

FAMILY = "boxes that pass"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

G = 9.81  # [m/s²]
STEPS = 40


class Placed(NamedTuple):
    """A box as it starts, seen from a world in which down is −z."""

    size: np.ndarray  # [m]
    mass: float | None  # [kg]
    place: np.ndarray  # [m]
    turn: Rotation
    velocity: np.ndarray  # [m/s]
    friction: float


def _box(
    size: np.ndarray,
    mass: float | None,
    place: tuple[float, ...],
    yaw: float = 0.0,
    velocity: tuple[float, ...] = (0.0, 0.0, 0.0),
    friction: float = 0.5,
) -> Placed:
    return Placed(size, mass, np.array(place), Rotation.from_rotvec((0.0, 0.0, yaw)), np.array(velocity), friction)


def let_go(rng: np.random.Generator, h: float) -> list[Placed]:
    """Return a plate, and a box a part of g h² above it."""
    plate, size = rng.uniform(1.0, 2.0, 3), rng.uniform(0.2, 0.5, 3)
    return [
        _box(plate, None, (0.0, 0.0, -0.5 * plate[2])),
        _box(size, 1.0, (0.1, -0.1, 0.5 * size[2] + rng.uniform(0.2, 0.8) * G * h * h), rng.uniform(-3.0, 3.0)),
    ]


def over_tiles(rng: np.random.Generator, h: float) -> list[Placed]:
    """Return flush tiles, and a smooth box that slides over them."""
    tile, size, speed = rng.uniform((0.4, 0.4, 0.3), (0.8, 0.8, 0.5)), rng.uniform(0.2, 0.5, 3), rng.uniform(2.0, 5.0)
    tiles = [
        _box(tile, None, (i * tile[0], j * tile[1], -0.5 * tile[2]), 0.0, friction=0.0)
        for i in range(-1, 4)
        for j in range(-1, 2)
    ]
    place = 0.0, rng.uniform(-0.2, 0.2), 0.5 * size[2]
    return [*tiles, _box(size, 1.0, place, rng.uniform(-0.2, 0.2), (speed, 0.0, 0.0), 0.0)]


SCENES: dict[str, Callable[[np.random.Generator, float], list[Placed]]] = {
    "let go": let_go,
    "over flush tiles": over_tiles,
}


def _ends(boxes: list[Placed], down: Rotation, names: list[Rotation], h: float) -> np.ndarray:
    """Return where the boxes that move come to in a step and in STEPS [m], and their velocities: (m, 12), turned back.

    The world is turned by `down`, and the axes of each box are called otherwise: those of `names`, seen from it.
    """
    frame, told = np.round(down.as_matrix()), []
    world = World(gravity=frame @ (0.0, 0.0, -G), iterations=1000)
    for box, name in zip(boxes, names):
        size, turn = renamed(box.size, down * box.turn, name)
        world.add_box(size, box.mass, frame @ box.place, turn, frame @ box.velocity, friction=box.friction)
    for steps in (1, STEPS - 1):
        world.step(h, steps)
        moving = world.model.box_inverse_mass > 0.0
        told += [world.state.box_position[moving] @ frame, world.state.box_velocity[moving] @ frame]
    return np.hstack(told)


@check(
    section="4.5, 5.2",
    piece="softbody.collision.boxes.box_contacts.find_box_contacts, softbody.collision.boxes.swept_boxes.meeting_of",
    reference="the same world with z down and the axes of boxes as they were given",
    engines=("scipy",),
    kind="invariant",
    unit="m, m/s",
    tolerance=5e-5,
    because="sweeps end where one corrects less than 1e-4 g h, 1.6e-5 m/s at 60 steps a second, and what that leaves"
    " of a lean adds up: 8.7e-6 at worst of ten seeds, over tiles",
    faults=(
        Fault(
            "gravity that pulls along two axes only",
            box_contacts.free_flights,
            "controls.gravity[c_] + x_ → (controls.gravity[c] if c > 0 else 0.0) + x_",
        ),
        Fault(
            "the first face of the first box is not preferred",
            swept_boxes.meeting_of,
            "0 <= best_.axis < 3 <= k_ → 0 < best.axis < 3 <= k",
        ),
    ),
)
def boxes_move_alike(run: Run) -> Comparison:
    """Boxes move alike whichever way is down, whatever their axes' names.

    Down is any of x, y and z, and the axes of each box are called anyhow. Boxes come to the same places, at the same
    velocities. They are let go a little above a plate, or slide over flush tiles.
    """
    rng, answers, same, group = run.fresh_rng(), Answers(), Rotation.identity(), Rotation.create_group("O")
    for _ in range(run.count(3, 10, 100)):
        for kind, make in SCENES.items():
            h = float(rng.choice([1.0 / 60.0, 1.0 / 240.0]))
            boxes = make(rng, h)
            upright = _ends(boxes, same, [same] * len(boxes), h)
            for _ in range(3):
                down, names = group[int(rng.integers(24))], [group[int(n)] for n in rng.integers(24, size=len(boxes))]
                answers.extend(_ends(boxes, down, names, h), upright, kind=kind)
    return answers.comparison()
