"""Claims about boxes that strike face against face in one long step, from aside or while they leave."""

from __future__ import annotations

import numpy as np

from softbody import World
from softbody.collision.boxes import box_contacts, manifold, swept_boxes
from validation.answers import Answers
from validation.check import Comparison, Run, check
from validation.checks.boxes.cases import any_turn, any_yaw, other_axes, renamed, wxyz
from validation.fault import Fault

FAMILY = "boxes that pass"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

STEP = 1.0 / 60.0  # [s]
LONG = 8.0  # [m] side of the plate: the box is over it for three steps


@check(
    section="4.4, 4.5",
    piece="softbody.collision.boxes.manifold.swept_manifold, softbody.collision.boxes.swept_boxes.meeting_of",
    reference="closed form: what holds all of a face up pushes through its middle",
    engines=("scipy",),
    kind="closed form",
    unit="of the speed",
    tolerance=3e-14,
    because="rounding of a rotation and of a solution for four corners: 2e-15 at worst of ten seeds",
    faults=(
        Fault(
            "points where the heavier box has them now",
            manifold._clip_faces,
            "1.0 - sweep.share if faces.towards_reference > 0.0 else sweep.share"
            " → sweep.share if faces.towards_reference > 0.0 else 1.0 - sweep.share",
        ),
        Fault(
            "a way along one side for that along the other",
            manifold._clip_faces,
            "polygon_[at_, k_, 1] - behind_ * shift_[1] → polygon_[at_, k_, 1] - behind_ * shift_[0]",
        ),
        Fault(
            "faces clipped where they are at the end of the step",
            swept_boxes.meeting_of,
            "-np.inf, 0.0, NO_MEETING, False → -np.inf, 1.0, NO_MEETING, False",
        ),
    ),
)
def strikes_from_aside(run: Run) -> Comparison:
    """A smooth box that strikes a plate flat gets no spin.

    It parts from it at e times its speed and slides on at its own. It comes over the rim within the step, and is over
    the plate when they meet; or it was over it when they touched, and is past the rim at the end. The plate stands
    still, or flies evenly; no gravity.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(60, 300, 3_000)):
        kind = ("comes over the rim", "leaves over the rim")[trial % 2]
        size, thick, e, speed = rng.uniform(0.3, 0.8, 3), rng.uniform(0.2, 1.0), rng.random(), rng.uniform(1.0, 4.0)
        reach, angle = 0.5 * np.hypot(*size[:2]), rng.uniform(-0.5, 0.5)
        along, aside = np.array([np.cos(angle), np.sin(angle), 0.0]), rng.uniform(-1.0, 1.0)
        if kind == "comes over the rim":
            when = rng.uniform(0.6, 0.9) * STEP  # they meet, and all of the box is over the plate
            way = rng.uniform(0.5, 1.5) * reach / when * along
            start = np.array([1.01 * reach - 0.5 * LONG, aside, 0.0]) - when * way + (0.0, 0.0, speed * when)
        else:
            way = rng.uniform(1.5, 2.5) * reach / STEP * along
            start = np.array([0.5 * LONG - 1.01 * reach, aside, 0.0])
        turn, yaw = any_turn(rng), any_yaw(rng)
        place, velocity = start + (0.0, 0.0, 0.5 * (thick + size[2])), way - (0.0, 0.0, speed)
        frame = rng.normal(size=3) * 3.0 * (trial // 2 % 2)
        own, lie = renamed(np.array([LONG, LONG, thick]), turn, other_axes(rng))
        plate = own, None, np.zeros(3), lie, frame
        box = size, 1.0, turn.apply(place), wxyz(turn * yaw), frame + turn.apply(velocity)
        world = World(gravity=(0.0, 0.0, 0.0))
        for each in (plate, box) if trial // 4 % 2 else (box, plate):
            world.add_box(*each, friction=0.0, restitution=e * (trial // 8 % 2))
        struck = world.boxes[trial // 4 % 2]
        world.step(STEP, 3)
        scale = speed + np.linalg.norm(way) + np.linalg.norm(frame)
        after = way + (0.0, 0.0, e * (trial // 8 % 2) * speed)
        measured = np.hstack([struck.velocity, struck.angular_velocity * reach]) / scale
        answers.add(measured, np.hstack([frame + turn.apply(after), np.zeros(3)]) / scale, kind=kind)
    return answers.comparison()


@check(
    section="4.4, 4.5",
    piece="softbody.collision.boxes.swept_boxes.meeting_of",
    reference="closed form: half of both thicknesses apart",
    kind="closed form",
    unit="of the way in a step",
    tolerance=5e-7,
    because="sweeps end where one corrects less than 1e-4 g h, and it comes flat: 2.3e-8 at worst of ten seeds",
    faults=(
        Fault(
            "a sine that is rounded to 1e-8",
            swept_boxes._projection,
            "sqrt(cosine[i1, j] * cosine[i1, j] + cosine[i2, j] * cosine[i2, j])"
            " → sqrt(max(0.0, 1.0 - cosine[i, j] * cosine[i, j]))",
        ),
    ),
)
def flat_however_turned(run: Run) -> Comparison:
    """A box that comes down flat lies on the other one.

    It comes down on a fixed one, with weight, both turned anyhow in the world and about their common normal. It is on
    it after two steps, and no deeper.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(150, 600, 6_000)):
        turn, yaw = any_turn(rng), any_yaw(rng)
        up, speed, sizes = turn.apply((0.0, 0.0, 1.0)), rng.uniform(1.0, 5.0), rng.uniform(0.5, 1.0, (2, 3))
        world, thick = World(gravity=-9.81 * up), 0.5 * sizes[:, 2].sum()
        world.add_box(sizes[0], None, (0.0, 0.0, 0.0), wxyz(turn))
        height = thick + rng.uniform(0.0, 0.9) * speed * STEP
        box = world.add_box(sizes[1], 1.0, height * up, wxyz(turn * yaw), -speed * up)
        world.step(STEP, 2)
        answers.add((box.position @ up - thick) / (speed * STEP), 0.0)
    return answers.comparison()


@check(
    section="4.4, 4.5, 10.13",
    piece="softbody.Box.apply_force, softbody.collision.boxes.box_contacts.free_flights",
    reference="closed form: half of both thicknesses apart, and Newton's second law for both together",
    kind="closed form",
    unit="of the way that the force alone would bring in a step",
    tolerance=2e-12,
    because="rounding of a solution for four corners, beside a way of 3 cm: 2e-13 at worst of ten seeds",
    faults=(
        Fault(
            "no forces on boxes foreseen",
            box_contacts.free_flights,
            "controls.gravity[c_] + inverse_mass_ * controls.box_force[i_, c_] → controls.gravity[c]",
        ),
    ),
)
def stops_where_it_is_pushed(run: Run) -> Comparison:
    """A box that a force pushes at something stops at that.

    Without gravity, 100 to 3 160 N for each kilogram push a box that is at rest, flat, at another one, a plate, or the
    ground. In a step it would go farther than the gap. After two it is there and no deeper. A free one goes on with it.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(60, 300, 3_000)):
        kind = ("plate", "box", "ground")[trial % 3]
        turn, yaw, sizes = any_turn(rng), any_yaw(rng), rng.uniform(0.3, 0.6, (2, 3))
        masses, push = np.exp(rng.uniform(-1.0, 1.0, 2)), 10.0 ** rng.uniform(2.0, 3.5)  # [m/s²] on the box alone
        world, way, thick = World(gravity=(0.0, 0.0, 0.0)), push * STEP**2, 0.5 * sizes[:, 2].sum()
        if kind == "ground":
            turn = yaw
            world.add_ground(0.5 * sizes[0, 2])
        else:
            other = world.add_box(sizes[0], masses[0] if kind == "box" else None, (0.0, 0.0, 0.0), wxyz(turn))
        up, gap = turn.apply((0.0, 0.0, 1.0)), rng.uniform(0.0, 0.9) * way
        box = world.add_box(sizes[1], masses[1], (thick + gap) * up, wxyz(turn * yaw))
        box.apply_force(-push * masses[1] * up)
        world.step(STEP, 2)
        speed, below = 0.0, np.zeros(3)
        if kind == "box":
            speed, below = 2.0 * STEP * push * masses[1] / masses.sum(), other.position
        off = np.append((box.velocity + speed * up) * STEP, (box.position - below) @ up - thick)
        answers.add(off / way, np.zeros(4), kind=kind)
    return answers.comparison()
