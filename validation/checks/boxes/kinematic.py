"""Boxes without mass that move by their velocities: belts, lifts, turntables, paddles, and what they push."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from softbody import Mesh, World, icosphere
from softbody.bodies import rigid_box
from softbody.collision import impulse
from softbody.collision.boxes import box_contacts
from softbody.collision.soft import soft_box, soft_response
from softbody.collision.solver import solver_row
from softbody.dynamics import rigid_boxes
from softbody.linalg import quaternion
from validation.answers import Answers
from validation.cases import random_orientations
from validation.check import Comparison, Run, check
from validation.checks.boxes.cases import about, any_turn, rotation, wxyz
from validation.fault import Fault

FAMILY = "boxes moved by script"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

STEP = 1.0 / 480.0  # [s]
G = 9.81  # [m/s²]

STAYS = Fault("a kinematic box that stays", rigid_boxes.advance_boxes, "is_free_ or is_moving(v_, spin_) → is_free")
FORESEEN = Fault(
    "no motion of kinematic boxes foreseen",
    box_contacts._set_flight,
    "scale(h_, load(state.box_velocity, box_))"
    " → scale(h if model.box_inverse_mass[box] > 0.0 else 0.0, load(state.box_velocity, box))",
)
FALLS = Fault("a kinematic box that falls", rigid_boxes.accelerate_boxes, "inverse_mass_ > 0.0 → inverse_mass >= 0.0")
RESTS = Fault(
    "a kinematic box that boxes take for one at rest",
    solver_row.load_motion,
    "bodies.velocity[i_, c_] → bodies.velocity[i, c] * (bodies.inverse_mass[i] > 0.0)",
)
NO_SPIN = Fault(
    "a kinematic box whose turning is not felt",
    solver_row.load_motion,
    "bodies.angular_velocity[i_, c_] → bodies.angular_velocity[i, c] * (bodies.inverse_mass[i] > 0.0)",
)


@check(
    section="5.4",
    piece="softbody.World.add_box, softbody.Box.velocity",
    reference="closed forms: Coulomb's law, circular motion, Newton's law",
    kind="closed form",
    unit="of the belt's speed, the radius, the weight",
    tolerance=1e-6,
    because="where sweeps stop: 9.7e-8 at worst of ten seeds at standard, three at full, sliding; what is held, 6e-11",
    faults=(
        STAYS,
        FALLS,
        RESTS,
        NO_SPIN,
        Fault(
            "a lift a hundredth too slow",
            rigid_box.Box.move_to,
            "self._go(velocity_, t_, s_) → self._go(0.99 * velocity, spin, seconds)",
        ),
    ),
)
def rides(run: Run) -> Comparison:
    """Boxes ride kinematic belts, turntables and lifts as closed forms say.

    A box on a belt gains μ g t until it is as fast as the belt. One on a turntable rides in a circle, and one on a lift
    weighs m (g + a). Boxes have 50 g to 20 kg.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(3, 10, 100)):
        size, mass = rng.uniform(0.3, 0.6, 3), float(np.exp(rng.uniform(-3.0, 3.0)))
        for ride in (_belt, _turntable, _lift):
            ride(rng, size, mass, answers)
    return answers.comparison()


def _carried(size: np.ndarray) -> float:
    """Return a part of gravity by which a box that stands may be sped up without tipping over, whichever way."""
    return float(0.9 * size[:2].min() / size[2])


def _belt(rng: np.random.Generator, size: np.ndarray, mass: float, answers: Answers) -> None:
    world, angle = World(), rng.uniform(0.0, 2.0 * np.pi)
    friction = rng.uniform(0.1, np.minimum(0.8, _carried(size)))
    way, speed = np.array([np.cos(angle), np.sin(angle), 0.0]), rng.uniform(1.0, 3.0)
    belt = world.add_box((40.0, 40.0, 0.2), None, (0.0, 0.0, -0.1), velocity=speed * way, friction=friction)
    box = world.add_box(size, mass, (0.0, 0.0, 0.5 * size[2]), friction=friction)
    seconds = rng.uniform(0.3, 0.9) * speed / (friction * G)
    world.run(seconds, STEP)
    answers.add(box.velocity @ way, friction * G * seconds, speed, kind="belt, sliding")
    world.run(2.0 * speed / (friction * G) - seconds, STEP)
    answers.add(float(np.linalg.norm(box.velocity - speed * way)), 0.0, speed, kind="belt, carried")
    answers.add(belt.position @ way, speed * world.time, speed, kind="belt itself")


def _turntable(rng: np.random.Generator, size: np.ndarray, mass: float, answers: Answers) -> None:
    world, radius = World(), rng.uniform(1.0, 2.0)
    friction = rng.uniform(0.4, np.minimum(1.0, _carried(size) / 0.6))
    spin = rng.choice([-1.0, 1.0]) * np.sqrt(rng.uniform(0.1, 0.6) * friction * G / radius)
    world.add_box((9.0, 9.0, 0.2), None, (0.0, 0.0, -0.1), angular_velocity=(0.0, 0.0, spin), friction=friction)
    motion = (0.0, radius * spin, 0.0), (0.0, 0.0, spin)
    box = world.add_box(size, mass, (radius, 0.0, 0.5 * size[2]), (1, 0, 0, 0), *motion, friction=friction)
    steps = 120
    world.step(STEP, steps)
    # In a step it goes straight on, as fast as the table is where it is: along a tangent, outwards.
    angle, away = steps * np.arctan(spin * STEP), radius * (1.0 + (spin * STEP) ** 2) ** (0.5 * steps)
    answers.extend(box.position[:2], away * np.array([np.cos(angle), np.sin(angle)]), radius, kind="turntable")
    answers.add(box.angular_velocity[2], spin, abs(spin), kind="turntable, spin")


def _lift(rng: np.random.Generator, size: np.ndarray, mass: float, answers: Answers) -> None:
    world, rate, start = World(), rng.uniform(-5.0, 10.0), rng.uniform(0.0, 3.0)
    lift = world.add_box((2.0, 2.0, 0.2), None, (0.0, 0.0, -0.1))
    box = world.add_box(size, mass, (0.0, 0.0, 0.5 * size[2]), velocity=(0.0, 0.0, start))
    for k in range(1, 61):
        t = k * STEP
        lift.move_to((0.0, 0.0, start * t + 0.5 * rate * t * t - 0.1), seconds=STEP)
        world.step(STEP)
    force = world.contact_points().force_on(box)[2]
    answers.add(float(force) / mass, G + rate, G, kind="lift, weight")
    height = start * t + 0.5 * rate * t * t + 0.5 * size[2]
    answers.add(box.position[2], height, 1.0, kind="lift, height")


@check(
    section="4.2",
    piece="softbody.World.add_box, softbody.Box.velocity",
    reference="closed form: impact on an infinite mass",
    kind="closed form",
    unit="of the speed at which they meet",
    tolerance=2e-14,
    because="rounding: 1.6e-15 at worst of 500 hits at full",
    faults=(
        RESTS,
        STAYS,
        FORESEEN,
    ),
)
def paddles(run: Run) -> Comparison:
    """A flying paddle keeps its speed and sends a box off.

    Face against face the box leaves at V + e (V − v). Boxes have 50 g to 20 kg, speeds are 1 to 100 m/s. In steps of
    1/240 s a plate may be through a thin box.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(10, 50, 500)):
        size = np.append(10.0 ** rng.uniform(-1.7, -0.2), rng.uniform(0.3, 0.6, 2))
        mass, e, speed = float(np.exp(rng.uniform(-3.0, 3.0))), float(rng.random()), 10.0 ** rng.uniform(0.0, 2.0)
        own, gap = rng.uniform(-10.0, 0.9 * speed), rng.uniform(0.01, 0.5)
        # A plate hits a box face to face: in the plane of their centres, so that it does not turn.
        world, place = World(gravity=(0.0, 0.0, 0.0)), (0.025 + gap + 0.5 * size[0], 0.0, 0.0)
        plate = world.add_box((0.05, 1.0, 1.0), None, velocity=(speed, 0.0, 0.0), restitution=e)
        box = world.add_box(size, mass, place, velocity=(own, 0.0, 0.0), restitution=e * rng.random())
        world.run(gap / (speed - own) + 0.05, 1.0 / 240.0)
        answers.add(box.velocity[0], speed + e * (speed - own), speed - own, "paddle")
        answers.add(plate.velocity[0], speed, speed, "paddle itself")
    return answers.comparison()


@check(
    section="5.4",
    piece="softbody.World.add_box",
    reference="the same world with everything at rest (Galileo)",
    kind="the core in another form",
    unit="m, and m/s, relative to the floor; 0.1 mm of what does not tumble",
    tolerance=5e-6,
    because="rounding, made larger by the tumbling box's impacts: 3.2e-7 at worst of ten seeds and of 40 worlds; the"
    " ball is off by 9.4e-13, the box that lands flat by 1.2e-10",
    faults=(
        RESTS,
        Fault(
            "a floor that soft bodies take for one at rest",
            impulse.velocity_of_point,
            "load(bodies.velocity, body)"
            " → scale(1.0 if bodies.inverse_mass[body] > 0.0 else 0.0, load(bodies.velocity, body))",
        ),
        Fault(
            "a way of soft bodies that forgets the box's",
            soft_response._way,
            "sub(way_, scale(h, velocity_of_point(bodies.boxes, contacts.box[k, 1], place_))) → way",
        ),
    ),
)
def moving_floor(run: Run) -> Comparison:
    """All moves on an evenly moving floor as on one at rest.

    Boxes that land on it and on each other, and a soft ball, are seen from it, each with the floor's velocity added. It
    is fast or slow; over 0.5 s.
    """
    rng, answers = run.fresh_rng(), Answers()
    ball = icosphere(1, 0.3)
    kinds = ["ball"] * len(ball.vertices) + ["box that tumbles", "box that lands flat"]
    scale = [1.0 if kind == "box that tumbles" else 1e-4 for kind in kinds]
    for case in range(run.count(2, 8, 40)):
        sizes, masses = rng.uniform(0.2, 0.5, (2, 3)), np.exp(rng.uniform(-1.0, 1.0, 2))
        turn, bounce = random_orientations(rng, 1)[0], rng.random(3) * (case % 2)
        floor_velocity = 10.0 ** rng.uniform(-1.0, 1.0) * rng.normal(size=3)
        seen = []
        for u in (floor_velocity, np.zeros(3)):
            world = World()
            floor = world.add_box((6.0, 6.0, 1.0), None, (0.0, 0.0, -0.5), velocity=u)
            world.add_box(sizes[0], masses[0], (0.0, 0.0, 0.7), turn, u, restitution=bounce[0])
            world.add_box(sizes[1], masses[1], (1.5, 0.0, 0.05 + 0.5 * sizes[1, 2]), velocity=u, restitution=bounce[1])
            world.add_soft_body(ball, 1.0, 150.0, 20.0, (-1.5, 0.0, 0.4), u, restitution=bounce[2], damping=0.3)
            world.run(0.5, 1.0 / 960.0)
            state, own = world.state, floor.position + (0.0, 0.0, 0.5)
            place = np.concatenate([state.particle_position, state.box_position[1:]]) - own
            seen.append(np.hstack([place, np.concatenate([state.particle_velocity, state.box_velocity[1:]]) - u]))
        answers.extend(seen[0], seen[1], scale, kinds)
    return answers.comparison()


@check(
    section="4.2, 5.4",
    piece="softbody.World.add_box",
    reference="Rapier, velocity-based kinematic bodies",
    engines=("rapier3d",),
    unit="of the speed at the point of impact",
    tolerance=5e-3,
    because="Rapier is in single precision, and meets where boxes overlap at a step's beginning: 5e-4 at worst",
    faults=(RESTS, NO_SPIN, STAYS),
)
def plates_by_rapier(run: Run) -> Comparison:
    """A kinematic plate that flies and turns hits as Rapier's does.

    Compared is what each box has of speed and spin after one impact at a corner, an edge or a face, without friction.
    """
    from references import rapier

    rng, answers, rest = run.fresh_rng(), Answers(), np.zeros(3)
    for _ in range(run.count(6, 15, 150)):
        # A plate in the plane y, z that comes along x, and turns; a box before it, in any orientation.
        size, mass = rng.uniform(0.2, 0.6, 3), float(np.exp(rng.uniform(-2.0, 2.0)))
        place = np.array([1.0, *rng.uniform(-0.8, 0.8, 2)])
        orientation = random_orientations(rng, 1)[0]
        speed, spin = rng.uniform(1.0, 3.0), rng.uniform(-0.8, 0.8, 3)
        e = float(rng.random())
        plate = (0.2, 3.0, 3.0), np.inf, rest, (1.0, 0.0, 0.0, 0.0), (speed, 0.0, 0.0), spin
        struck = size, mass, place, orientation, rest, rest
        world = World(gravity=(0.0, 0.0, 0.0))
        world.add_box(plate[0], None, *plate[2:], restitution=e, friction=0.0)
        box = world.add_box(*struck, restitution=e, friction=0.0)
        step, steps = 2e-4, 0
        while not box.velocity.any() and steps < 10_000:
            world.step(step)
            steps += 1
        sizes, masses, places, orientations, *motion = (np.array(column) for column in zip(plate, struck))
        boxes = sizes, masses, places, orientations, motion[0], motion[1]
        judged = rapier.velocities_after(*boxes, step, steps + 3, restitution=e)
        half = 0.5 * size.min()
        ours, theirs = np.append(box.velocity, box.angular_velocity * half), judged[1] * np.repeat((1.0, half), 3)
        answers.add(ours, theirs, float(speed + np.linalg.norm(spin)))
    return answers.comparison()


@check(
    section="5.2",
    piece="softbody.Box.move_to, softbody.linalg.quaternion.rotation_between",
    reference="SciPy's Slerp; straight lines",
    engines=("scipy",),
    unit="m; components of a rotation matrix",
    tolerance=1e-13,
    because="rounding of a hundred turns: 6e-15 at worst",
    faults=(
        STAYS,
        Fault("a box that goes up only while it goes aside", rigid_boxes.is_moving, "v[2] != 0.0 → v[2] == 0.0"),
        Fault("a turn the long way", quaternion.rotation_between, "cosine_ >= 0.0 → cosine < 0.0"),
        Fault(
            "half the turn", quaternion.rotation_between, "2.0 * atan2(sine_, abs(cosine_)) → atan2(sine, abs(cosine))"
        ),
        Fault(
            "a turn in the box's own frame",
            quaternion.rotation_between,
            "np.cross(end[1:], q[1:]) → np.cross(q[1:], end[1:])",
        ),
        Fault("a way in one second", rigid_box.Box.move_to, "way_ / seconds → way"),
        Fault("a box that goes on", rigid_boxes.slow_boxes, "state_.box_time_left[i_] = ARRIVED → pass"),
        Fault(
            "a last step that is too long",
            rigid_boxes.slow_boxes,
            "scale(left_ / h_, load(state_.box_velocity, i_)) → load(state.box_velocity, i)",
        ),
    ),
)
def poses_on_time(run: Run) -> Comparison:
    """`move_to` leads a box evenly from pose to pose, on time.

    Its way is SciPy's, also along or about one axis only, and it stays there.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(14, 42, 420)):
        ends, places = random_orientations(rng, 2), rng.normal(size=(2, 3))
        if trial % 7 < 6:  # it goes along one axis only, or turns about one
            way, turn = np.split(np.eye(6)[trial % 7] * rng.uniform(-3.0, 3.0), 2)
            places[1] = places[0] + way
            ends[1] = wxyz(Rotation.from_rotvec(turn) * rotation(ends[0])) if turn.any() else ends[0]
        seconds, steps = rng.uniform(0.1, 10.0), int(rng.integers(1, 50))
        world = World()
        box = world.add_box(rng.uniform(0.1, 1.0, 3), None, places[0], ends[0])
        box.move_to(places[1], ends[1], seconds=seconds)
        turns = Slerp([0.0, 1.0], rotation(ends))
        step = seconds / (2 * steps)
        late = step * rng.uniform(0.3, 1.7)  # it arrives within such a step, and stays
        for part, h, count in ((0.5, step, steps), (1.0, late, 4 * steps)):
            world.step(h, count)
            answers.add(box.position.copy(), places[0] + part * (places[1] - places[0]), kind=f"place at {part:g}")
            found, wanted = rotation(box.orientation).as_matrix(), turns([part]).as_matrix()[0]
            answers.extend(found, wanted, kind=f"turn at {part:g}")
    return answers.comparison()


@check(
    section="4.2",
    piece="softbody.collision.soft.soft_box.find_contacts_in_box, softbody.collision.soft.soft_box.way_of_box",
    reference="closed form: where the corner's leading face meets a circle; impact on an infinite mass",
    engines=("scipy",),
    kind="closed form",
    unit="of the corner's speed, times the angle by which it turns in a step",
    tolerance=1.0,
    because="the face acts as it is at the step's end, turned by a part of that angle: the chord is shorter; 0.97 of it"
    " at worst of ten seeds, and 5 or more where nothing is struck",
    faults=(
        Fault(
            "corners that turn past what they have struck",
            soft_box.way_of_box,
            "norm(sub(now.position, before.position)) + x_ → norm(sub(now.position, before.position))",
        ),
    ),
)
def corners_strike_what_they_sweep_over(run: Run) -> Comparison:
    """A vertex that a turning box's corner sweeps over is struck.

    In one step it comes in by one face and is past the other at the end. It leaves as fast as the first face was there,
    at a right angle to it. What is farther out than the corner stays at rest. No friction; the vertex is loose.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(30, 120, 1_200)):
        side, spin, turned = rng.uniform(0.2, 0.6), rng.uniform(5.0, 20.0), rng.uniform(0.05, 0.12)
        corner, is_struck = np.sqrt(0.5) * side, trial % 3 < 2
        radius = corner * (1.0 - rng.uniform(0.02, 0.45) * turned if is_struck else 1.0 + rng.uniform(0.001, 0.02))
        # Before the corner points at the vertex by `before` its leading face is there, afterwards the other one.
        before = 0.25 * np.pi - np.arccos(np.minimum(1.0, 0.5 * side / radius)) if is_struck else 0.0
        start = -before - rng.uniform(0.02, 0.98) * (turned - 2.0 * before)
        frame = any_turn(rng)
        away = radius + rng.uniform(0.5, 1.0)
        points = np.array([[radius, 0.0, 0.0], [away, 0.0, 0.4], [away, 0.4, -0.2], [away, -0.4, -0.2]])
        mesh = Mesh(frame.apply(points), np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]))
        world, axis = World(gravity=(0.0, 0.0, 0.0)), frame.apply((0.0, 0.0, spin))
        tip = world.add_soft_body(mesh, 1.0, 1e-9, 0.0, fixed=(1, 2, 3), damping=0.0, friction=0.0)
        lies = wxyz(frame * rotation(about(2, start - 0.25 * np.pi)))
        world.add_box((side, side, side), None, angular_velocity=axis, orientation=lies, friction=0.0)
        world.step(turned / spin, allow_unstable=True)
        lean = 0.25 * np.pi - before  # of the leading face's normal, when it is at the vertex
        speed = spin * radius * np.sin(lean) if is_struck else 0.0
        left = frame.inv().apply(tip.velocities[0])
        judged = speed * np.array([np.cos(lean), np.sin(lean), 0.0])
        kind = "struck" if is_struck else "passed by"
        answers.add(left, judged, spin * corner * turned, kind=kind)
    return answers.comparison()
