"""Boxes over many steps: they turn, bounce, slide, topple, stand and pile up."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from softbody import World
from softbody.collision.boxes import box_contacts, manifold
from softbody.collision.solver import bounces, sequential_impulses, warm_start
from softbody.dynamics import rigid_boxes
from softbody.geometry.box import box_corners
from softbody.model import material
from validation import accounts
from validation.answers import Answers
from validation.cases import depths_of_boxes, random_orientations, rotation_matrix
from validation.check import Comparison, Misprint, Run, check
from validation.checks.boxes.cases import about
from validation.fault import Fault

FAMILY = "boxes in motion"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

FIRST_ORDER_TORQUE = Fault(
    "a gyroscopic torque of first order",
    rigid_boxes.advance_boxes,
    "range(MIDPOINTS) → range(0)",
)
FRICTION = Fault(
    "friction off by 1 %",
    sequential_impulses._sweep,
    "load_lanes(row_[FRICTION], 0) * normal_ → 1.01 * load_lanes(row_[FRICTION], 0) * normal_",
)
G = 9.81  # [m/s²]
ADVANCE = "softbody.dynamics.rigid_boxes.advance_boxes"
MOVE = "softbody.stepping.move_boxes.move_boxes"
SOLVER = "softbody.collision.solver.sequential_impulses.solve_velocities"


def tumbled(size: np.ndarray, q: np.ndarray, spin: np.ndarray) -> np.ndarray:
    """Return the rotation matrix (9,) of a free box of the core after 2 s, with its gyroscopic torque.

    It is extrapolated from steps of 1 ms and ½ ms as for an order of 2.
    """
    turns = []
    for h in (1e-3, 5e-4):
        world = World(gravity=(0.0, 0.0, 0.0), gyroscopic=True)
        box = world.add_box(size, 1.0, orientation=q, angular_velocity=spin)
        world.step(h, round(2.0 / h))
        turns.append(rotation_matrix(box.orientation).ravel())
    return (4.0 * turns[1] - turns[0]) / 3.0


def spins(run: Run) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return sizes [m], orientations and angular velocities [rad/s] of boxes with three different inertias."""
    rng = run.fresh_rng()
    turns = random_orientations(rng, run.count(4, 20, 100))
    return [(np.array([1.0, 0.6, 0.3]) * rng.uniform(0.8, 1.2, 3), q, 2.0 * rng.normal(size=3)) for q in turns]


tumbling = partial(check, section="5.2", piece=ADVANCE, unit="of the rotation matrix", least=4)


@tumbling(
    reference="SciPy DOP853 on Euler's equations, extrapolating our steps h and h/2 as for an order of 2",
    engines=("scipy",),
    tolerance=1e-9,
    because="after 2 s what is beyond the order h²: h⁴ for a rule symmetric in time; h = 0.5 ms, |ω| ≤ 8 rad/s",
    faults=(FIRST_ORDER_TORQUE,),
    erratum=Misprint("E19", "no gyroscopic term: ω stays", "ω × I ω: I ω stays"),
)
def free_rotation(run: Run) -> Comparison:
    """A free asymmetric box tumbles by gyroscopic torque as Euler's equations say."""
    from references import printed, rotation

    answers, wrong = Answers(), []
    for size, q, spin in spins(run):
        answers.add(tumbled(size, q, spin), rotation.free_rotation(size, q, spin, 2.0)[0].ravel())
        wrong.append(printed.turn_without_gyroscopic_torque(q, spin, 2.0)[0].ravel())
    return answers.comparison(printed=np.array(wrong))


@tumbling(
    reference="MuJoCo, RK4, steps of 1 ms",
    engines=("mujoco",),
    tolerance=2e-9,
    because="as by Euler's equations; MuJoCo's own steps of order 4 leave some 1e-10",
    faults=(FIRST_ORDER_TORQUE,),
)
def free_rotation_by_mujoco(run: Run) -> Comparison:
    """A free asymmetric box tumbles as MuJoCo's RK4 makes it tumble."""
    from references import mujoco

    answers = Answers()
    for size, q, spin in spins(run):
        answers.add(tumbled(size, q, spin), mujoco.free_rotation(size, 1.0, q, spin, 2.0, 1e-3).ravel())
    return answers.comparison()


@check(
    section="5.2",
    piece=ADVANCE,
    reference="invariants",
    kind="invariant",
    tolerance=1e-11,
    because="rounding of a thousand steps, 1e-15 each, always the same way at worst",
    faults=(
        Fault(
            "angular velocity from the orientation half-way",
            rigid_boxes.advance_boxes,
            "store(rows_, i_, rotate_diagonal(q_, inverse_, momentum_))"
            " → store(rows_, i_, rotate_diagonal(turned(q_, scale(-0.5 * h, spin)), inverse_, momentum_))",
        ),
    ),
)
def free_rotation_keeps(run: Run) -> Comparison:
    """A free box keeps its angular momentum by the gyroscopic torque.

    Without that torque it keeps its angular velocity.
    """
    answers = Answers()
    for size, q, spin in spins(run):
        for gyroscopic in (False, True):
            world = World(gravity=(0.0, 0.0, 0.0), gyroscopic=gyroscopic)
            box = world.add_box(size, 1.0, orientation=q, angular_velocity=spin)
            start = accounts.angular_momentum(world) if gyroscopic else spin
            world.step(1e-2, 1000)
            end = accounts.angular_momentum(world) if gyroscopic else box.angular_velocity
            kind, first = "angular momentum" if gyroscopic else "angular velocity", np.linalg.norm(start)
            answers.add(end / first, start / first, kind=kind)
    return answers.comparison()


def tumbler(q: np.ndarray) -> World:
    """Return a box of e = 1 and no friction above the ground, turned by `q`, that turns."""
    world = World(gyroscopic=True)
    world.add_ground(restitution=1.0, friction=0.0)
    spin = (1.0, 2.0, 3.0)
    world.add_box((0.4, 0.3, 0.2), 1.0, (0.0, 0.0, 1.2), q, restitution=1.0, friction=0.0, angular_velocity=spin)
    return world


def crowd(rng: np.random.Generator) -> World:
    """Return eight boxes of e = 1 and no friction that fly about in a closed room, without gravity."""
    world = World(gravity=(0.0, 0.0, 0.0), gyroscopic=True)
    for axis in range(3):
        for side in (-2.0, 2.0):
            unit = np.eye(3)[axis]
            world.add_box(5.0 - 4.0 * unit, None, side * unit, restitution=1.0, friction=0.0)
    for corner, q in zip(np.ndindex(2, 2, 2), random_orientations(rng, 8), strict=True):
        place, size = 1.4 * (np.array(corner) - 0.5), rng.uniform(0.2, 0.6, 3)
        box = world.add_box(size, rng.uniform(0.5, 2.0), place, q, restitution=1.0, friction=0.0)
        box.velocity, box.angular_velocity = 2.0 * rng.normal(size=3), 3.0 * rng.normal(size=3)
    return world


def energy_in_mid_step(world: World, h: float) -> float:
    """Return the energy [J] with the velocities half a step of `h` [s] later: those of now are half a step behind."""
    half = 0.5 * h * world.gravity
    gained = (box.mass * half @ (box.velocity + 0.5 * half) for box in world.boxes if box.mass)
    return world.energy() + float(sum(gained))


@check(
    section="4.4, 5.2",
    piece=SOLVER,
    reference="the energy at the start",
    kind="invariant",
    unit="of the energy",
    tolerance=1e-3,
    because="a midpoint rule of order 2 turns them at up to 30 rad/s, 1e-4 in 20 s; sweeps end before they are exact",
    faults=(
        Fault("corners that a bounce drives down only stop", bounces.set_targets, "turns < MOST_TURNS → turns < 1"),
        Fault(
            "impulses of bounces forgotten",
            warm_start.start_from_cache,
            "max(bounces[k], component(row, k, NORMAL, p)) → max(0.0, component(row, k, NORMAL, p))",
        ),
    ),
)
def lively_boxes(run: Run) -> Comparison:
    """Lively boxes keep their energy on the ground and in a crowd."""
    answers, h = Answers(), 1.0 / 240.0
    seconds, count = run.count(20, 60, 60), run.count(3, 6, 12)
    rng = run.fresh_rng()
    worlds = {"tumbles on the ground": [tumbler(q) for q in random_orientations(rng, count)]}
    worlds["a crowd in a room"] = [crowd(rng) for _ in range(count)]
    for kind, some in worlds.items():
        for world in some:
            start = energy_in_mid_step(world, h)
            for _ in range(seconds):
                world.run(1.0, h)
                answers.add(energy_in_mid_step(world, h) / start, 1.0, kind=kind)
    return answers.comparison()


@check(
    section="4.4, 5.2",
    piece=MOVE,
    reference="closed form e²ⁿ h",
    unit="of the first height",
    kind="closed form",
    tolerance=2e-3,
    because="an impact is seen up to a step early, v h = 1e-3 m above the ground, v = 4.4 m/s, h = 1/4 ms",
    faults=(
        Fault(
            "restitution of many contacts off by 0.2 %",
            material.speed_after,
            "restitution_ * approach_ → 1.002 * restitution_ * approach_",
        ),
    ),
)
def bounce_heights(run: Run) -> Comparison:
    """A box dropped flat bounces to e², e⁴, … of its height."""
    answers = Answers()
    for e in (0.5, 0.8, 1.0):
        for size in ((1.0, 1.0, 1.0), (1.0, 0.6, 0.4))[: run.count(1, 2, 2)]:
            world = World()
            world.add_ground(restitution=e)
            box = world.add_box(size, 1.0, (0.0, 0.0, 1.0 + 0.5 * size[2]))
            tops: list[float] = []
            top, falling = 0.0, True
            while len(tops) < 3:
                world.step(2.5e-4)
                if box.velocity[2] > 0.0:
                    top, falling = np.maximum(top, box.position[2] - 0.5 * size[2]), False
                elif not falling:
                    tops.append(top)
                    top, falling = 0.0, True
            answers.extend(tops, [e ** (2 * n) for n in (1, 2, 3)], kind=f"e = {e}")
    return answers.comparison()


@check(
    section="beyond the paper",
    piece=SOLVER,
    reference="closed form",
    unit="of the way",
    kind="closed form",
    least=4,
    tolerance=5e-3,
    because="Euler's steps: the way differs by v h / 2 of v²/2μg, which is μ g h / v",
    faults=(FRICTION,),
)
def sliding_distance(run: Run) -> Comparison:
    """A box that slides stops after v²/2μg."""
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(4, 20, 200)):
        friction, speed, angle = rng.uniform(0.2, 0.8), rng.uniform(1.0, 3.0), rng.uniform(0.0, 2.0 * np.pi)
        world = World()
        world.add_ground(friction=friction)
        # Low and wide, so that friction cannot lift its rear.
        size = np.array([1.0, 1.0, 0.2]) * rng.uniform(0.7, 1.3, 3)
        v = speed * np.array([np.cos(angle), np.sin(angle), 0.0])
        box = world.add_box(size, rng.uniform(0.1, 10.0), (0.0, 0.0, 0.5 * size[2]), velocity=v, friction=friction)
        world.run(1.2 * speed / (friction * G), 5e-4)
        way = speed**2 / (2.0 * friction * G)
        answers.add(np.linalg.norm(box.position[:2]), way, way)
    return answers.comparison()


@check(
    section="beyond the paper",
    piece=SOLVER,
    reference="closed form",
    unit="of g t²/2",
    kind="closed form",
    tolerance=2e-3,
    because="Euler's steps: t² becomes t (t + h), h/t = 1e-3; θ is 1 % or more off the threshold",
    faults=(FRICTION,),
)
def incline(run: Run) -> Comparison:
    """A box on an incline holds exactly if tan θ < μ.

    Else it slides down by g (sin θ − μ cos θ) t²/2.
    """
    rng, answers = run.fresh_rng(), Answers()
    for i in range(run.count(6, 20, 200)):
        friction = rng.uniform(0.2, 0.8)
        part = 1.0 + rng.uniform(0.01, 0.3) * (1.0 if i % 2 else -1.0)
        slope = np.arctan(part * friction)
        world, tilt, up = World(), about(1, slope), np.array([np.sin(slope), 0.0, np.cos(slope)])
        world.add_box((50.0, 50.0, 1.0), None, orientation=tilt, friction=friction)
        box = world.add_box((1.0, 1.0, 0.2), 1.0, 0.6 * up, tilt, friction=friction)
        world.step(1e-3, 1000)
        expected = np.maximum(0.0, np.sin(slope) - friction * np.cos(slope))
        answers.add(np.linalg.norm(box.position - 0.6 * up) / (0.5 * G), expected, kind="slides" if i % 2 else "holds")
    return answers.comparison()


@check(
    section="5.2",
    piece=MOVE,
    reference="closed form: the edge is under the centre at tan θ = width / height",
    kind="closed form",
    because="a yes-or-no answer, 1 % or more of the angle off the threshold",
    faults=(Fault("a corner that the ground does not see", box_contacts._add_ground_contacts, "range(8) → range(7)"),),
)
def toppling(run: Run) -> Comparison:
    """A leaning tower topples exactly if its centre is beyond its edge."""
    rng, answers = run.fresh_rng(), Answers()
    for i in range(run.count(6, 30, 200)):
        width, height = rng.uniform(0.4, 1.0), rng.uniform(0.8, 1.5)
        balance = np.arctan(width / height)
        q = about(1, balance * (1.0 + rng.uniform(0.01, 0.2) * (1.0 if i % 2 else -1.0)))
        world = World()
        world.add_ground(friction=1.0)
        low = box_corners((width, 0.7, height), (0.0, 0.0, 0.0), tuple(q))[:, 2].min()
        box = world.add_box((width, 0.7, height), 1.0, (0.0, 0.0, -low), q, friction=1.0)
        world.run(3.0, 2e-3)
        answers.add(bool(abs(rotation_matrix(box.orientation)[2, 2]) < 0.5), bool(i % 2))
    return answers.comparison()


@check(
    section="4.4",
    piece=SOLVER,
    reference="bounds; pybullet's stack is in the note",
    engines=("pybullet",),
    unit="of the bound",
    kind="bound",
    least=3,
    tolerance=1.0,
    because="bounds of rounding, for boxes that are put where they stay: sinking 8.5e-12 m, two roundings of 9e-16 in"
    " each of 4 800 steps (1.4e-12 seen); drift 1e-13 m (1.1e-14 seen); speed at rest 1e-15 of what ten weights give"
    " in a step, 4e-16 m/s (2.3e-17 seen)",
    faults=(
        Fault(
            "boxes that touch at two points only",
            manifold._clip_faces,
            "above_ <= limits_.margin and kept_ < MOST_POINTS → above_ <= limits_.margin and kept_ < 2",
        ),
    ),
)
def stack(run: Run) -> Comparison:
    """Ten stacked boxes hardly sink, drift or move in 20 s."""
    h, seconds = 1.0 / 240.0, 20.0
    world, bullet = beside_bullet(h, [(np.ones(3), 1.0, (0.0, 0.0, 0.5 + i)) for i in range(10)])
    world.run(seconds, h)
    bullet.step(round(seconds / h))
    ours = _rest(world.state.box_position, np.hstack([world.state.box_velocity, world.state.box_angular_velocity]))
    theirs = _rest(bullet.positions(), bullet.velocities())
    bullet.close()
    # Each step rounds heights of up to 9.5 m twice; the lowest contacts give ten weights a step, rounded a few times.
    bounds = np.array([2.0 * round(seconds / h) * 2.0**-50, 1e-13, 1e-15 * 10.0 * G * h])
    told = "after 20 s: sunk {:.1e} m, drifted {:.1e} m, still moving at {:.1e} m/s; ".format(*ours)
    told += "Bullet's stack {:.1e} m, {:.1e} m, {:.1e} m/s".format(*theirs)
    return Comparison(ours, np.zeros(3), bounds, ["sinking", "drift", "speed"], notes=[told])


def beside_bullet(h: float, boxes: list[tuple[Any, ...]], gyroscopic: bool = False) -> tuple[World, Any]:
    """Return a world with these boxes (size, mass, place and so on) on its ground, and Bullet's, of as many sweeps."""
    from references.pybullet_world import BulletWorld

    world = World(gyroscopic=gyroscopic)
    bullet = BulletWorld(h, world.store.settings.iterations)
    for each in (world, bullet):
        each.add_ground()
        for box in boxes:
            each.add_box(*box)
    return world, bullet


def _rest(position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Return how far a stack has sunk and drifted [m], and how fast it still moves [m/s]."""
    heights = 0.5 + np.arange(len(position))
    return np.array([np.abs(position[:, 2] - heights).max(), np.abs(position[:, :2]).max(), np.abs(velocity).max()])


@check(
    section="4.4",
    piece=MOVE,
    reference="pybullet's pile of the same boxes; depths of ours by FCL; bounds on energy and speed",
    engines=("pybullet", "fcl"),
    unit="of the bound",
    kind="bound",
    least=4,
    tolerance=1.0,
    because="bounds: Bullet's deepest of all steps below the ground (12 piles: 0.1 to 0.35 of it), twice its deepest "
    "inside each other (0.4 to 1.5: one extreme of thousands of impacts), 1e-3 of all energy gained in a step (by "
    "lifting boxes out of each other; no velocity feels that), 1 m/s root mean square at the end of 6 s",
    faults=(
        Fault(
            "boxes that touch only when 0.2 m inside each other",
            manifold.swept_manifold,
            "separation_ > limits_.margin → separation_ > limits_.margin - 0.2",
        ),
    ),
)
def pile(run: Run) -> Comparison:
    """Falling boxes pile up above ground, not inside each other, and rest."""
    rng = run.fresh_rng()
    count, h = run.count(30, 120, 1000), 1.0 / 240.0
    side = max(2, round((count / 3.0) ** (1.0 / 3.0)))
    boxes = []
    for i in range(count):
        x, y, z = i % side, i // side % side, i // side**2
        size = rng.uniform(0.5, 1.0, 3)
        place = np.array([1.8 * x, 1.8 * y, 1.0 + 1.8 * z]) + rng.uniform(-0.03, 0.03, 3)
        boxes.append((size, float(np.prod(size)), place, random_orientations(rng, 1)[0]))
    # Without its gyroscopic torque even a free box would not keep its energy.
    world, bullet = beside_bullet(h, boxes, gyroscopic=True)
    energy = start = accounts.energy(world)
    rise = below = inside = 0.0
    deepest = np.zeros(2)
    for step in range(round(6.0 / h)):
        world.step(h)
        now = accounts.energy(world)
        rise, energy = np.maximum(rise, now - energy), now
        if step % 8 == 0:
            inside, below = np.maximum((inside, below), depths_of_boxes(world))
        bullet.step()
        deepest = np.maximum(deepest, bullet.deepest())
    speed, theirs = (
        float(np.sqrt(np.mean(np.sum(v**2, axis=1)))) for v in (world.state.box_velocity, bullet.velocities()[:, :3])
    )
    ours_top, their_top = world.state.box_position[:, 2].max(), bullet.positions()[:, 2].max()
    bullet.close()
    return Comparison(
        [below, inside, rise, speed],
        np.zeros(4),
        np.array([deepest[1], 2.0 * deepest[0], 1e-3 * start, 1.0]),
        ["below the ground", "inside each other", "energy gained in a step", "speed at the end"],
        notes=[
            f"{count} boxes after 6 s: root mean square {speed:.2g} m/s, top at {ours_top:.2f} m; "
            f"Bullet's {theirs:.2g} m/s, {their_top:.2f} m",
            f"at the worst {inside:.3f} m inside each other, {below:.3f} m below the ground; "
            "Bullet's {:.3f} m and {:.3f} m".format(*deepest),
        ],
    )


@check(
    section="4.4",
    piece="softbody.collision.solver.sequential_impulses.solve_positions",
    reference="depths by FCL; the speed is 0",
    engines=("fcl",),
    unit="m/s gained, m inside",
    tolerance=2e-13,
    because="displacements are no velocities: the speed is exactly 0; depths decay by a fifth a step, to 1e-15",
    faults=(
        Fault(
            "a displacement that becomes a velocity",
            rigid_boxes.shift_boxes,
            "state_.box_position[i_, c_] += shift_[i_, c_]"
            " → state_.box_position[i_, c_] += shift_[i_, c_]\nstate_.box_velocity[i_, c_] += shift_[i_, c_]",
        ),
    ),
)
def deep_start(run: Run) -> Comparison:
    """Boxes that start inside each other part, and gain no speed."""
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(5, 30, 300)):
        world = World(gravity=(0.0, 0.0, 0.0))
        for _ in range(4):
            q = random_orientations(rng, 1)[0]
            world.add_box(rng.uniform(0.5, 1.0, 3), rng.uniform(0.1, 10.0), rng.uniform(-0.2, 0.2, 3), q)
        world.step(1e-2, 1_500)
        speed = np.maximum(np.abs(world.state.box_velocity).max(), np.abs(world.state.box_angular_velocity).max())
        answers.extend([speed, depths_of_boxes(world)[0]], np.zeros(2), kind=["speed", "depth left"])
    return answers.comparison()
