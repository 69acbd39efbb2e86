"""Sleep: bodies that have been slow for long are left alone, until something comes near or is changed."""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from softbody import Box, Mesh, SoftBody, World, box, icosphere, octahedron
from softbody.bodies import body as handles
from softbody.bodies import contact_points as points
from softbody.bodies import sleep_tracker
from softbody.dynamics import soft_bodies
from softbody.stepping import memory, rested, runner, sleep, step
from softbody.storage import snapshot
from validation.answers import Answers
from validation.cases import random_orientations, rotated, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.worlds.cases import WEIGHTLESS, by_turns
from validation.fault import Fault

FAMILY = "sleep"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

check_sleep = partial(check, section="beyond the paper")

AS_HEAVY = Fault(
    "as heavy as when it slept",
    sleep.let_sleep,
    "0.0 if a_ else rest.box_inverse_mass[b_]"
    " → 0.0 if a_ or model.box_inverse_mass[b_] == 0.0 else rest.box_inverse_mass[b_]",
)


def with_company(world: World) -> World:
    """Add a soft body, a static box and a joint that pulls nothing, high up; return the world.

    So the worlds of all these claims are of one kind, and kernels compile once for them.
    """
    far = world.add_soft_body(octahedron(0.3), 1.0, 100.0, 0.0, (0.0, 0.0, 900.0), fixed=range(5))
    world.add_box((1.0, 1.0, 1.0), None, (0.0, 99.0, 900.0))
    world.add_joint((far, 0), (0.0, 0.0, 900.0), 0.0)
    return world


@check_sleep(
    piece="softbody.World",
    reference="v = v₀ − μ g t, and v = v₀ exp(−d t)",
    kind="closed form",
    unit="of a step",
    tolerance=2.5,
    because="the first step that ends slow, and the first one asleep: two steps",
    faults=(
        Fault("a clock that counts steps", sleep.note_rest, "rest.time[body_] + h_ → rest.time[body] + 1e-3"),
        Fault(
            "a clock that is not set back",
            sleep.note_rest,
            "rest.time[b_] + h if is_slow else 0.0 → rest.time[b_] + h if is_slow else rest.time[b_]",
        ),
        Fault(
            "a speed that is not squared",
            sleep.note_rest,
            "settings.sleep_speed * settings.sleep_speed → settings.sleep_speed",
        ),
        Fault(
            "a time that is a hundredth too long",
            sleep.let_sleep,
            "rest.time[b_] >= settings.sleep_after → rest.time[b_] >= 1.01 * settings.sleep_after",
        ),
        Fault(
            "the sum of a soft body's squares, not their mean",
            sleep._square_of_speed,
            "square / (end_ - first_) → square / (end - first - 1)",
        ),
    ),
)
def after_it_is_slow(run: Run) -> Comparison:
    """Bodies fall asleep `sleep_after` after they became slow.

    Boxes slide over the ground, and drag slows soft balls. They sleep that long after the moment at which they have
    become as slow as `sleep_speed`; others too when they have stopped since.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(2, 6, 40)):
        h = rng.uniform(0.6e-3, 1e-3)
        speed, after = rng.uniform(0.2, 0.4), rng.uniform(0.3, 0.6)
        world = World((0.0, 0.0, -rng.uniform(3.0, 10.0)), sleep_speed=speed, sleep_after=after)
        ground_friction, friction = rng.uniform(0.1, 0.5, 2)
        world.add_ground(friction=ground_friction)
        at, size = float(rng.uniform(0.6, 1.0)), (1.0, 1.2, 0.1)
        for k, v in enumerate((0.0, at)):
            slow, mass = v * np.array([np.cos(at), np.sin(at), 0.0]), rng.uniform(0.5, 5.0)
            world.add_box(size, mass, (9.0 * k, 0.0, 0.05), velocity=slow, friction=friction)
        kicked = world.add_box(size, 1.0, (0.0, 9.0, 0.05), friction=friction)
        brake = np.sqrt(ground_friction * friction) * -world.gravity[2]
        kick = int(0.5 * after / h)
        with_company(world).step(h, kick)
        kicked.velocity = (0.0, at, 0.0)
        slides = (at - speed) / brake + after
        found = _when_asleep(world, world.boxes[:3], h, slides + (kick + 20) * h)
        kinds = "a box at rest", "a box that slides", "a box that is kicked"
        answers.extend(found / h, [after / h, slides / h, slides / h + kick], kind=kinds)
        world = World(WEIGHTLESS, sleep_speed=speed, sleep_after=after)
        drags, at = rng.uniform(2.0, 4.0, 2), float(rng.uniform(1.0, 2.0))
        for k, drag in enumerate(drags):
            begin, place = random_velocity(rng, at), (99.0 * k, 0.0, 0.0)
            world.add_soft_body(icosphere(k, 0.3), rng.uniform(1.0, 3.0), 100.0, 0.0, place, begin, drag=drag)
        moments = np.log(at / speed) / drags
        balls = with_company(world).soft_bodies[:2]
        found = _when_asleep(world, balls, h, float(moments.max()) + after + 20 * h)
        answers.extend(found / h, (moments + after) / h, kind="a soft ball")
    return answers.comparison()


def random_velocity(rng: np.random.Generator, speed: float) -> np.ndarray:
    """Return a velocity (3,) [m/s] of a random direction."""
    v = rng.normal(size=3)
    return speed / np.linalg.norm(v) * v


def _when_asleep(world: World, bodies: Sequence[SoftBody | Box], h: float, seconds: float) -> np.ndarray:
    """Return when each body is first found asleep [s], at the begin of that step; 1e9 if it never is."""
    found = np.full(len(bodies), 1e9)
    while world.time < seconds:
        world.step(h)
        for k, body in enumerate(bodies):
            if body.is_asleep and found[k] == 1e9:
                found[k] = world.time - h
    return found


@check_sleep(
    piece="softbody.World",
    reference="trimesh's inertia of boxes: ½ m v² + ½ ω·I ω; NumPy's mean of squares",
    engines=("trimesh",),
    because="yes or no, 1 % from where it changes; in two steps a thousandth of it is lost at most",
    faults=(
        Fault("no spin", sleep._square_of_speed, "square + dot(v_, v_) → dot(v, v)"),
        Fault("no motion of the centre", sleep._square_of_speed, "square + dot(v_, v_) → square + 0.0 * dot(v, v)"),
        Fault("another side", sleep._square_of_speed, "size[(axis_ + 2) % 3] → size[axis]"),
        Fault(
            "spin about the world's axes",
            sleep._square_of_speed,
            "rotate_inverse(load_quaternion(state_.box_orientation, box_), spin_) → (spin[0], spin[1], spin[2])",
        ),
        Fault("an eleventh of the squares", sleep._square_of_speed, "x_ / 12.0 → x_ / 11.0"),
        Fault(
            "a speed that is too high",
            sleep.note_rest,
            "settings.sleep_speed * settings.sleep_speed → 1.03 * settings.sleep_speed * settings.sleep_speed",
        ),
    ),
)
def by_all_its_mass(run: Run) -> Comparison:
    """Sleep goes by the root mean square speed of a body's mass.

    Boxes move and turn, and each particle of a soft body has a speed of its own. They fall asleep where `sleep_speed`
    is 1 % more than that, and not where it is 1 % less.
    """
    from references.trimesh import inertia

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(10, 40, 400)):
        size, mass, q = rng.uniform(0.2, 2.0, 3), rng.uniform(0.1, 10.0), random_orientations(rng, 1)[0]
        cube, turn = box(size), rotation_matrix(q)
        of = turn @ inertia(cube.vertices, cube.triangles, mass) @ turn.T
        v, spin = rng.normal(0.0, 0.01, 3), rng.normal(0.0, 0.02, 3)
        rms = float(np.sqrt(v @ v + spin @ of @ spin / mass))
        ball = icosphere(1, rng.uniform(0.2, 0.5))
        speeds = rng.normal(0.0, 0.02, ball.vertices.shape) * rng.uniform(0.2, 2.0, (len(ball.vertices), 1))
        rms_of_ball = float(np.sqrt((speeds**2).sum(axis=1).mean()))
        for factor in (0.99, 1.01):
            world = World(WEIGHTLESS, sleep_speed=factor * rms, sleep_after=1e-9)
            world.add_box(size, mass, rng.normal(size=3), q, v, spin)
            with_company(world).step(1e-4, 2)
            answers.add(world.boxes[0].is_asleep, factor > 1.0, kind="boxes")
            world = World(WEIGHTLESS, sleep_speed=factor * rms_of_ball, sleep_after=1e-9)
            body = world.add_soft_body(ball, mass, 1e-3, 0.0, damping=0.0)
            body.velocities[:] = speeds
            with_company(world).step(1e-7, 2)
            answers.add(body.is_asleep, factor > 1.0, kind="soft bodies")
    return answers.comparison()


@check_sleep(
    piece="softbody.Box.wake, softbody.SoftBody.is_asleep",
    reference="SciPy's connected components",
    engines=("scipy",),
    because="yes or no; gaps are below 0.3 % of the sizes, or above 10 %",
    faults=(
        Fault(
            "neighbours only",
            sleep._wake_islands,
            "woken_ |= _wake_together(rest_, takes_part_, a_, b_) → _wake_together(rest, takes_part, a, b)",
        ),
        Fault("no joints", sleep._wake_islands, "a_ != NOBODY and b_ != NOBODY → a_ == NOBODY and b_ != NOBODY"),
        Fault("what stands passes it on", sleep._wake_together, "not (takes_part[a_] and takes_part[b_]) → False"),
        Fault("no gap", sleep._wake_islands, "GAP * rest.radius[b_] → -GAP * rest.radius[b_]"),
        Fault("bounds that always meet", sleep._bounds_meet, "return False → return True"),
        Fault("a box's number among boxes", handles.SleepyBody.number, "self.kind == 'box' → self.kind == 'joint'"),
        Fault("a call that wakes nobody", handles.SleepyBody.wake, "x_[self.number()] = 0.0 → x_[self.number()] = 1.0"),
        Fault(
            "the first end of a joint twice",
            sleep._wake_islands,
            "_body_at_end(model_, joints_, k_, 1) → _body_at_end(model, joints, k, 0)",
        ),
        Fault(
            "the body after the one that is joined",
            sleep._body_at_end,
            "model_.soft_particle_start[body_ + 1] <= particle_ → model.soft_particle_start[body] <= particle",
        ),
    ),
)
def islands_by_scipy(run: Run) -> Comparison:
    """Only the island of what is disturbed wakes, as SciPy finds it.

    Boxes and soft bodies are all asleep, some side by side, some apart, some joined, some around what stands. One is
    pushed, told to wake, or at the end of a joint that is changed. Just those are awake afterwards that SciPy finds
    connected to it, by bounds that touch or by joints.
    """
    from references.scipy import connected

    rng, answers = run.fresh_rng(), Answers()
    for kind in by_turns(run.count(8, 30, 200), "pushed", "woken", "of a joint that is changed"):
        world, links = _archipelago(rng)
        bodies: list[Any] = [*world.soft_bodies, *world.boxes]
        world.run(0.02, 1e-3)
        free = [k for k, body in enumerate(bodies) if body.mass is not None]
        one = int(rng.choice(free))
        if kind == "of a joint that is changed":
            joint = world.joints[int(rng.integers(len(world.joints)))]
            joint.stiffness = 1e-6
            one = links[joint.index][0]
        elif kind == "pushed":
            _push(bodies[one])
        else:
            bodies[one].wake()
        world.step(1e-3)
        together = connected(len(bodies), [pair for pair in (*_near(world), *links) if set(pair) <= set(free)])
        woken = [not bodies[k].is_asleep for k in free]
        answers.extend(woken, [together[k] == together[one] for k in free], kind=kind)
    return answers.comparison()


def _push(body: SoftBody | Box) -> None:
    """Give a body a little speed."""
    if isinstance(body, Box):
        body.velocity = (0.0, 1e-3, 1e-3)
    else:
        body.velocities[:, 1:] = 1e-3


def _archipelago(rng: np.random.Generator) -> tuple[World, list[tuple[int, int]]]:
    """Return a weightless world of bodies that nearly touch, and others; and the bodies of each of its joints.

    A body is 0.1 % of its size from another, in one of six directions, or 10 % and more.
    """
    while True:
        world = World(WEIGHTLESS, sleep_speed=1e-4, sleep_after=0.005)
        soft, count = int(rng.integers(2, 6)), int(rng.integers(7, 12))
        half = rng.uniform(0.2, 0.5, (count, 3))
        half[:soft] = half[:soft, :1]
        place = np.zeros((count, 3))
        order = rng.permutation(count)
        for n, k in enumerate(order[1:], 1):
            other, axis, side = order[rng.integers(n)], int(rng.integers(3)), rng.choice((-1.0, 1.0))
            gap = rng.choice((0.001, 0.001, 0.3)) * (half[k] + half[other])[axis]
            place[k] = place[other]
            place[k, axis] += side * ((half[k] + half[other])[axis] + gap)
        apart = np.abs(place[:, None] - place[None]) - half[:, None] - half[None]
        gaps = apart.max(axis=2) / (half[:, None] + half[None]).min(axis=2)
        gaps[np.diag_indices(count)] = 1.0
        radius = np.where(np.arange(count) < soft, half[:, 0], np.linalg.norm(half, axis=1))
        between = np.linalg.norm(place[:, None] - place[None], axis=2) - radius[:, None] - radius[None]
        if not ((gaps > 1e-4) & ((gaps < 0.004) & (between < 1e-3) | (gaps > 0.1))).all():
            continue
        for k in range(soft):
            world.add_soft_body(octahedron(half[k, 0]), 1.0, 100.0, 0.0, place[k])
        for k in range(soft, count):
            static = k > soft and rng.random() < 0.25
            world.add_box(2.0 * half[k], None if static else rng.uniform(0.5, 2.0), place[k])
        bodies: list[Any] = [*world.soft_bodies, *world.boxes]
        links = []
        for _ in range(2):
            a, b = (int(k) for k in rng.choice(count, 2, replace=False))
            if bodies[a].mass is not None and bodies[b].mass is not None:
                right, left = place[a] + [half[a, 0], 0, 0], place[b] - [half[b, 0], 0, 0]
                world.add_joint((bodies[a], right), (bodies[b], left), 0.0)
                links.append((a, b))
        if links:
            return world, links


def _near(world: World) -> list[tuple[int, int]]:
    """Return the pairs of bodies whose bounding boxes, by NumPy, are less than half a hundredth of a metre apart."""
    corners = [np.array([x.min(axis=0), x.max(axis=0)]) for x in (body.positions for body in world.soft_bodies)]
    corners += [box.position + 0.5 * np.outer((-1.0, 1.0), box.size) for box in world.boxes]
    count = len(corners)
    return [
        (i, k)
        for i in range(count)
        for k in range(i)
        if np.maximum(corners[i][0] - corners[k][1], corners[k][0] - corners[i][1]).max() < 0.005
    ]


@check_sleep(
    piece="softbody.World",
    reference="v t, ½ a t (t + h), and the swing of such steps, cos ((n + ½) θ) / cos (θ / 2), sin (θ / 2) = ω h / 2",
    kind="closed form",
    unit="of the way",
    tolerance=1e-12,
    because="rounding: 4e-14 at three seeds",
    faults=(
        Fault("a force is not looked at", sleep._mark_of_box, "checksum(controls_.box_force[box_]) → 0"),
        Fault("a torque is not looked at", sleep._mark_of_box, "checksum(controls_.box_torque[box_]) → 0"),
        Fault("a velocity is not looked at", sleep._mark_of_box, "checksum(state_.box_velocity[box_]) → 0"),
        Fault("a spin is not looked at", sleep._mark_of_box, "checksum(state_.box_angular_velocity[box_]) → 0"),
        Fault("a place is not looked at", sleep._mark_of_pose, "checksum(state_.box_position[box_]) → 0"),
        Fault("velocities of a soft body", sleep._mark_of_soft, "checksum(state_.particle_velocity[a_:b_]) → 0"),
        Fault("positions of a soft body", sleep._mark_of_soft, "checksum(state_.particle_position[a_:b_]) → 0"),
        Fault("forces on a soft body", sleep._mark_of_soft, "norm(load(force_, i_)) != 0.0 → False"),
        Fault("gravity is not looked at", sleep.mark_sleepers, "checksum(controls_.gravity) → 0"),
        Fault("a joint's place", sleep._mark_of_joint, "checksum(joints_.joint_place[k_]) → 0"),
        Fault("a joint's stiffness", sleep._mark_of_joint, "checksum(joints_.joint_stiffness[k_:l_]) → 0"),
        Fault("a joint's length", sleep._mark_of_joint, "checksum(joints_.joint_rest_length[k_:l_]) → 0"),
        Fault("what stands may move at once", sleep.wake_changed, "wakes_all |= x_ → wakes_all |= False"),
        AS_HEAVY,
    ),
)
def changes_by_newton(run: Run) -> Comparison:
    """Whatever is changed of a sleeper moves it as Newton says.

    So it is from the next step on. Velocity, spin, force, torque or gravity are changed, or a joint's place, length and
    stiffness. Or a floor goes, or moves away at once, or a body is put up in the air. Mass and inertia are its own.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 4, 30)):
        for kind in ("velocity", "spin", "force", "torque", "gravity", "place", "stiffness", "length", "floor", "lift"):
            for soft in (False,) if kind in ("spin", "torque") else (False, True):
                found, judged = _after_change(rng, kind, soft)
                answers.add(found, judged, float(np.linalg.norm(judged)), kind)
    return answers.comparison()


def _after_change(rng: np.random.Generator, kind: str, soft: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return how far (3,) one body comes, in metres or radians, that slept before something was changed; and by Newton.

    Others, of other kinds, sleep on far away.
    """
    h, steps, g = 1e-3, 150, rng.uniform(1.0, 9.0)
    t, mass = h * steps, rng.uniform(0.5, 4.0)
    falls = kind in ("floor", "lift")
    world = World((0.0, 0.0, -g) if falls else WEIGHTLESS, sleep_speed=0.03, sleep_after=0.05)
    size = rng.uniform(0.3, 0.8, 3)
    floor = world.add_box((3.0, 3.0, 1.0), None, (0.0, 0.0, -0.5 - (0.0 if falls else 9.0)))
    world.add_box((0.3, 0.4, 0.5), 1.0, (30.0, 0.0, 0.25 - (0.0 if falls else 4.0)))
    world.add_box((3.0, 3.0, 1.0), None, (30.0, 0.0, -0.5))
    body: Any
    if soft:
        # A tetrahedron that lies on a face, as stiff as can be for such a step.
        body = world.add_soft_body(_solid(size[0]), mass, 2000.0 * mass, 0.0, damping=0.5 * mass)
    else:
        body = world.add_box(size, mass, (0.0, 0.0, 0.5 * size[2]))
    with_company(world)
    k = mass * rng.uniform(20.0, 60.0)
    joints, ends = [], body.positions if soft else [_middle(body)]
    for end in ends if kind in ("place", "stiffness", "length") else ():
        at = end if kind == "place" else end + (0.0, 0.0, 0.7)
        stiffness, rest = 0.0 if kind == "stiffness" else k / len(ends), 0.7 if kind == "length" else 0.0
        joints.append(world.add_joint((body, end), at, stiffness, rest_length=rest))
    world.run(0.8 if falls and soft else 0.2, h)
    if not body.is_asleep:
        return np.full(3, 1e9), np.ones(3)
    way, other = random_velocity(rng, rng.uniform(1.0, 3.0)), random_velocity(rng, 1.0)
    angle = 2.0 * np.arcsin(0.5 * h * np.sqrt(k / mass))  # a step, of x' = x + h v', v' = v − h k x / m
    swing = 1.0 - np.cos(angle * (steps + 0.5)) / np.cos(0.5 * angle)
    judged = np.array([0.0, 0.0, -0.5 * g * t * (t + h)])  # of what falls
    if kind == "velocity":
        judged = way * t
        if soft:
            body.velocities[:] += way
        else:
            body.velocity = way
    elif kind == "spin":
        body.angular_velocity, judged = way, way * t
    elif kind == "force":
        judged = way * 0.5 * t * (t + h)
        if soft:
            body.external_force = mass * way / len(body.positions)
        else:
            body.apply_force(mass * way)
    elif kind == "torque":
        axis = int(rng.integers(3))
        inertia = mass * ((size**2).sum() - size[axis] ** 2) / 12.0
        body.apply_torque(np.eye(3)[axis] * inertia * 4.0)
        judged = np.eye(3)[axis] * 2.0 * t * (t + h)
    elif kind == "gravity":
        world.gravity, judged = way, way * 0.5 * t * (t + h)
    elif kind == "floor":
        floor.position = (0.0, 0.0, -9.0)
    elif kind == "lift":
        (body.positions if soft else body.position)[..., 2] += 2.0
    for joint in joints:
        if kind == "place":
            joint.target, judged = joint.target + other, other * swing
        elif kind == "stiffness":
            joint.stiffness, judged = k / len(joints), np.array([0.0, 0.0, 0.7]) * swing
        else:
            joint.rest_length, judged = 0.5, np.array([0.0, 0.0, 0.2]) * swing
    return _way(world, h, steps, body, kind in ("spin", "torque")), judged


def _solid(edge: float) -> Mesh:
    """Return a regular tetrahedron that stands on z = 0."""
    angle = 2.0 * np.pi / 3.0 * np.arange(3)
    foot = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(3)]) * edge / np.sqrt(3.0)
    faces = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    return Mesh(np.vstack([foot, (0.0, 0.0, edge * np.sqrt(2.0 / 3.0))]), faces)


def _middle(body: SoftBody | Box) -> np.ndarray:
    return body.position.copy() if isinstance(body, Box) else body.positions.mean(axis=0)


def _way(world: World, h: float, steps: int, body: Any, is_turn: bool) -> np.ndarray:
    """Return how far (3,) a body moves, or turns, in some steps, which are done in calls of unlike lengths."""
    from references.rotation import rotation_vector

    begin, turn = _middle(body), rotation_matrix(body.orientation) if is_turn else np.eye(3)
    for count in (1, steps // 3, steps - 1 - steps // 3):
        world.step(h, count)
    return rotation_vector(rotation_matrix(body.orientation) @ turn.T) if is_turn else _middle(body) - begin


@check_sleep(
    piece="softbody.World",
    reference="a world in which nobody may sleep; conservation of momentum",
    kind="the core in another form",
    unit="of the momentum; metres",
    tolerance=1e-8,
    because="what floats is at rest but for rounding, 1e-14 m/s, which sleep takes; collisions, each of which makes"
    " that larger, leave 9e-11 at ten seeds",
    faults=(
        Fault("nobody looks ahead", sleep._wake_islands, "h_ * _fastest(m_, s_, b_, r_) → -GAP * radius[body]"),
        Fault("those who move count not", sleep._wake_islands, "not _stands(m_, s_, r_, b_) → rest.asleep[body]"),
        Fault("nothing is stopped", sleep._stands, "not is_moving(a_, b_) → True"),
        AS_HEAVY,
    ),
)
def as_if_awake(run: Run) -> Comparison:
    """What hits or passes sleepers does so as if they were awake.

    Boxes and soft bodies sleep; others hit them, or pass closely. All are at the same places 0.4 s later as in a world
    where nobody may, on one thread and on two. Momentum is what it was, by NumPy.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(4, 12, 80)):
        seed, ends = int(rng.integers(2**31)), []
        for speed, threads in ((0.0, 1), (1e-3, 1), (1e-3, 2)):
            draws = np.random.default_rng(seed)
            world = _traffic(draws, speed, threads) if case % 2 else _bowling(draws, speed)
            slept, before = 0, _momentum(world)
            for _ in range(40):
                world.step(1e-3, 10) if case % 2 else world.step(1.0 / 120.0)
                slept += sum(body.is_asleep for body in (*world.soft_bodies, *world.boxes))
            ends.append(np.concatenate([world.state.particle_position, world.state.box_position]))
            answers.add(np.full(3, float((slept > 30) == (speed > 0.0))), np.ones(3), kind="asleep")
            if case % 2:
                answers.add(_momentum(world), before, float(np.linalg.norm(before)), "momentum")
        for end, kind in zip(ends[1:], ("one thread", "two threads"), strict=True):
            answers.extend(end, ends[0].copy(), kind=kind)
    return answers.comparison()


def _bowling(rng: np.random.Generator, sleep_speed: float) -> World:
    """Return a weightless world of boxes at rest, some that fly at them head-on, fast, and a plate that sweeps two."""
    world = World(WEIGHTLESS, sleep_speed=sleep_speed, sleep_after=0.03)
    for k in range(6):
        size = rng.uniform(0.3, 0.6, 3)
        world.add_box(size, rng.uniform(0.5, 3.0), (0.0, 2.0 * k, 0.0), restitution=rng.choice((0.0, 0.7)))
        if k < 4:
            v = rng.uniform(5.0, 20.0)
            at = (-v * rng.uniform(0.06, 0.2) - 0.6, 2.0 * k, 0.0)
            world.add_box(rng.uniform(0.3, 0.6, 3), rng.uniform(0.5, 3.0), at, velocity=(v, 0.0, 0.0))
    world.add_box((0.2, 3.0, 1.0), None, (-1.0, 9.0, 0.0), velocity=(rng.uniform(3.0, 6.0), 0.0, 0.0))
    return with_company(world)


def _traffic(rng: np.random.Generator, sleep_speed: float, threads: int) -> World:
    """Return a weightless world of a row of bodies at rest, and others that come at it or pass by."""
    world = World(WEIGHTLESS, sleep_speed=sleep_speed, sleep_after=0.02, threads=threads)
    for k in range(6):
        size = rng.uniform(0.2, 0.4, 3)
        at, turn = (0.0, 1.5 * k, 0.0), random_orientations(rng, 1)[0]
        if rng.random() < 0.5:
            world.add_box(2.0 * size, rng.uniform(0.5, 3.0), at, turn, restitution=rng.choice((0.0, 0.7)))
        else:
            ball = rotated(icosphere(1, size[0]), rng)
            world.add_soft_body(ball, rng.uniform(0.5, 3.0), 500.0, 0.0, at, damping=0.0)
    for k in (1, 2, 3, 4):
        v = np.array([rng.uniform(2.0, 6.0), 0.0, 0.0])
        at = (-v[0] * rng.uniform(0.05, 0.2) - 0.8, 1.5 * k + rng.uniform(0.0, 0.8), rng.uniform(0.0, 0.3))
        if rng.random() < 0.5:
            world.add_box(rng.uniform(0.2, 0.6, 3), rng.uniform(0.5, 3.0), at, (1.0, 0.0, 0.0, 0.0), v, (0.0, 3.0, 1.0))
        else:
            ball = rotated(icosphere(1, 0.25), rng)
            world.add_soft_body(ball, rng.uniform(0.5, 3.0), 500.0, 0.0, at, v, damping=0.0)
    return with_company(world)


def _momentum(world: World) -> np.ndarray:
    """Return the momentum (3,) [kg m/s] of all bodies, by NumPy."""
    total = np.zeros(3)
    for body in world.soft_bodies:
        total += body.mass * body.velocities.mean(axis=0)
    for each in world.boxes:
        total += (each.mass or 0.0) * each.velocity
    return total


@check_sleep(
    piece="softbody.World.contact_points",
    reference="m g; what touched what, before they slept",
    kind="closed form",
    unit="of the weight; of 10 000 of them for soft bodies, of 10 for what stands under one",
    tolerance=1e-6,
    because="boxes to the solver's 30 sweeps; soft bodies to 1 %, as they sleep while they still swing by a thousandth"
    " of a metre a second, and by 20 times less what is 20 times as heavy under them",
    faults=(
        Fault("no contacts of sleepers", runner.Runner.contact_points, "asleep.any() → False"),
        Fault(
            "those of all, of which those awake have theirs twice",
            points.ContactPoints.and_of,
            "np.append(bodies, False)[[others.a, others.b]].any(axis=0) → np.ones(len(others), bool)",
        ),
        Fault("it falls in its sleep", sleep.let_sleep, "0.0 if a_ else b_ → b_"),
        Fault("it moves in its sleep", soft_bodies.move_body, "memory.asleep[body_] → False"),
    ),
)
def weights_are_carried(run: Run) -> Comparison:
    """What sleeps under its weight stays, and is carried still.

    Stacks of boxes, and soft bodies on boxes, have come to rest: no bit of them changes for a second, and no contact of
    theirs is lost. All that hold each body carry its weight still.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(2, 6, 40)):
        g = rng.uniform(5.0, 15.0)
        world = World((0.0, 0.0, -g), sleep_speed=1e-3, sleep_after=0.1)
        world.add_ground()
        heights = 0.0
        for _ in range(4):
            size = rng.uniform(0.4, 0.6, 3)
            world.add_box(size, rng.uniform(0.5, 1.0), (0.0, 0.0, heights + 0.5 * size[2]))
            heights += size[2]
        table = world.add_box((2.0, 2.0, 0.5), 20.0, (9.0, 0.0, 0.25))
        tent = world.add_soft_body(_solid(0.6), 1.0, 2000.0, 1.0, (9.1, 0.1, 0.51), damping=5.0, drag=2.0)
        mover = world.add_box((0.5, 0.5, 0.5), 1.0, (0.0, 30.0, 0.25), velocity=(3.0, 0.0, 0.0), friction=0.0)
        world.ground.friction = 1.0
        with_company(world).run(4.0, 1e-3)
        touched = world.contact_points().pairs()
        as_meant = tent.is_asleep and table.is_asleep and not mover.is_asleep
        still: list[Any] = [tent, *world.boxes[:5]]
        before = [_bits(body) for body in still]
        world.run(1.0, 1e-3)
        found = world.contact_points()
        for body, bits in zip(still, before, strict=True):
            rows = [*found.force_on(body), float(_bits(body) == bits), float(found.pairs() == touched)]
            share = 1e4 if body is tent else 10.0 if body == table else 1.0
            weight = body.mass * g
            answers.add(rows, [0.0, 0.0, weight, 1.0, 1.0], weight * share, "soft" if body is tent else "boxes")
        rows = [*found.force_on(mover), float(as_meant), len(found.of(mover)) / 4.0]
        answers.add(rows, [0.0, 0.0, g, 1.0, 1.0], g, "awake")
    return answers.comparison()


def _bits(body: Any) -> bytes:
    arrays = (body.positions, body.velocities) if isinstance(body, SoftBody) else (body.position, body.orientation)
    return b"".join(np.ascontiguousarray(each).tobytes() for each in arrays)


@check_sleep(
    piece="softbody.World.save, softbody.World.snapshot, softbody.World.threads",
    reference="a twin that nobody has touched",
    kind="the core in another form",
    because="the same bits",
    faults=(
        Fault("clocks begin anew", snapshot._rested, "Rested(a_, b_) → Rested(0.0 * a_, b_)"),
        Fault("nobody is known to have slept", sleep_tracker.SleepTracker, "rested_.asleep > 0 → rested.asleep > 1"),
        Fault("no marks of those who slept", rested.note_sleepers, "contents.sleep.rest.time.any() → False"),
        Fault("changes before a snapshot are forgotten", rested.rested, "rest.time.any() → False"),
        Fault("other threads wake all", memory.Memory, "rest.settled[:] = False → rest.time[:] = 0.0"),
        Fault("no marks after a call", step.run, "mark_sleepers(a_, b_, c_, d_, e_) → None"),
    ),
)
def goes_on_to_the_same_bits(run: Run) -> Comparison:
    """Worlds with sleepers go on to the same bits however kept.

    They are saved and loaded, pickled, restored from a snapshot, with other threads, or go on step by step. Some of
    their bodies sleep, fall asleep or wake. So it is, too, of worlds that were changed just before.
    """
    rng, answers = run.fresh_rng(), Answers()
    for way in by_turns(run.count(6, 18, 120), "load", "pickle", "restore", "threads", "steps", "changed"):
        seed, cut, whole = int(rng.integers(2**31)), int(rng.integers(60, 500)), 800
        one, other = (_town(np.random.default_rng(seed)) for _ in range(2))
        for world in (one, other):
            for count in [1] * cut if way == "steps" and world is other else [cut]:
                world.step(1.5e-3, count)
            if way == "changed":
                world.boxes[seed % 4].apply_force((0.0, 30.0, 0.0))
        other = _once_more(other, way)
        same = [_sleepers(one) == _sleepers(other)]
        for world in (one, other):
            world.step(1.5e-3, whole - cut)
        same += [one.state_hash() == other.state_hash(), _sleepers(one) == _sleepers(other)]
        answers.extend(same, [True] * 3, kind=way)
    return answers.comparison()


def _sleepers(world: World) -> list[bool]:
    return [body.is_asleep for body in world.boxes]


def _town(rng: np.random.Generator) -> World:
    """Return a world on the ground of which some sleep soon, others later, and some are woken again."""
    world = World(sleep_speed=0.05, sleep_after=0.15)
    world.add_ground(friction=0.3)
    for k in range(4):
        v = (rng.uniform(0.5, 2.0) * (k % 2), 0.0, 0.0)
        world.add_box(rng.uniform(0.4, 0.6, 3), rng.uniform(0.5, 2.0), (1.5 * k, 0.0, 0.3), velocity=v, friction=0.3)
    world.add_soft_body(icosphere(1, 0.3), 1.0, 300.0, 20.0, (0.0, 9.0, rng.uniform(0.3, 0.5)), damping=2.0, drag=3.0)
    return with_company(world)


def _once_more(world: World, way: str) -> World:
    """Return a world that has been kept in one of several ways."""
    if way == "pickle":
        return pickle.loads(pickle.dumps(world))
    if way == "load":
        with tempfile.TemporaryDirectory() as folder:
            world.save(Path(folder) / "kept.npz")
            return World.load(Path(folder) / "kept.npz")
    if way in ("restore", "changed"):
        twin = World()
        twin.restore(world.snapshot())
        return twin
    if way == "threads":
        world.threads = 2
    return world
