"""Boxes without mass that move by their velocities: belts, lifts, turntables, paddles, and what they push."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody import World, icosphere
from softbody.bodies import rigid_box
from softbody.collision import impulse
from softbody.collision.boxes import box_contacts
from softbody.collision.soft import soft_response
from softbody.collision.solver import sequential_impulses, solver_row
from softbody.dynamics import rigid_boxes
from softbody.linalg import quaternion
from validation.cases import random_orientations
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "boxes moved by script"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

STEP = 1.0 / 480.0  # [s]
G = 9.81  # [m/s²]

STAYS = Fault("a kinematic box that stays", rigid_boxes.advance_boxes, "is_free_ or is_moving(v_, spin_) → is_free")
FORESEEN = Fault(
    "no motion of kinematic boxes foreseen",
    box_contacts.travel_in_step,
    "return add(scale(h, load(state.box_velocity, box)), _pull_in_step(model, controls, box, h))"
    " → return scale(1.0 if model.box_inverse_mass[box] > 0.0 else 0.0, add(scale(h, "
    "load(state.box_velocity, box)), _pull_in_step(model, controls, box, h)))",
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


class Rides(NamedTuple):
    """What was measured, and what closed forms say, with the scale and the kind of each row."""

    measured: list[float]
    expected: list[float]
    scale: list[float]
    kinds: list[str]

    def note(self, kind: str, measured: float, expected: float, scale: float) -> None:
        """Add a row."""
        for rows, value in zip(self, (measured, expected, scale, kind)):
            rows.append(value)  # type: ignore[attr-defined]

    def comparison(self) -> Comparison:
        """Return all of it, to be judged."""
        return Comparison(np.array(self.measured), np.array(self.expected), np.array(self.scale), self.kinds)


@check(
    section="5.4",
    piece="softbody.World.add_box, softbody.Box.velocity",
    reference="closed forms: Coulomb's law, circular motion, Newton's law",
    kind="closed form",
    unit="of the belt's speed, the radius, the weight",
    tolerance=1e-6,
    because="impulses at which sweeps stop: 9.7e-8 at worst of ten seeds at standard and three at full, sliding; what"
    " friction holds, 6e-11",
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
    """A box on a belt gains μ g t until it is as fast as the belt, one on a turntable rides in a circle, and one on a
    lift weighs m (g + a): boxes of 50 g to 20 kg, on kinematic ones."""
    rng, rides = run.fresh_rng(), Rides([], [], [], [])
    for _ in range(run.count(3, 10, 100)):
        size, mass = rng.uniform(0.3, 0.6, 3), float(np.exp(rng.uniform(-3.0, 3.0)))
        _belt(rng, size, mass, rides)
        _turntable(rng, size, mass, rides)
        _lift(rng, size, mass, rides)
    return rides.comparison()


def _carried(size: np.ndarray) -> float:
    """Return a part of gravity by which a box that stands may be sped up without tipping over, whichever way."""
    return float(0.9 * size[:2].min() / size[2])


def _belt(rng: np.random.Generator, size: np.ndarray, mass: float, rides: Rides) -> None:
    world, angle = World(), rng.uniform(0.0, 2.0 * np.pi)
    friction = rng.uniform(0.1, np.minimum(0.8, _carried(size)))
    way, speed = np.array([np.cos(angle), np.sin(angle), 0.0]), rng.uniform(1.0, 3.0)
    belt = world.add_box((40.0, 40.0, 0.2), None, (0.0, 0.0, -0.1), velocity=speed * way, friction=friction)
    box = world.add_box(size, mass, (0.0, 0.0, 0.5 * size[2]), friction=friction)
    seconds = rng.uniform(0.3, 0.9) * speed / (friction * G)
    world.run(seconds, STEP)
    rides.note("belt, sliding", float(box.velocity @ way), friction * G * seconds, speed)
    world.run(2.0 * speed / (friction * G) - seconds, STEP)
    rides.note("belt, carried", float(np.linalg.norm(box.velocity - speed * way)), 0.0, speed)
    rides.note("belt itself", float(belt.position @ way), speed * world.time, speed)


def _turntable(rng: np.random.Generator, size: np.ndarray, mass: float, rides: Rides) -> None:
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
    for k, expected in enumerate((np.cos(angle), np.sin(angle))):
        rides.note("turntable", float(box.position[k]), away * expected, radius)
    rides.note("turntable, spin", float(box.angular_velocity[2]), spin, abs(spin))


def _lift(rng: np.random.Generator, size: np.ndarray, mass: float, rides: Rides) -> None:
    world, rate, start = World(), rng.uniform(-5.0, 10.0), rng.uniform(0.0, 3.0)
    lift = world.add_box((2.0, 2.0, 0.2), None, (0.0, 0.0, -0.1))
    box = world.add_box(size, mass, (0.0, 0.0, 0.5 * size[2]), velocity=(0.0, 0.0, start))
    for k in range(1, 61):
        t = k * STEP
        lift.move_to((0.0, 0.0, start * t + 0.5 * rate * t * t - 0.1), seconds=STEP)
        world.step(STEP)
    force = world.contact_points().force_on(box)[2]
    rides.note("lift, weight", float(force) / mass, G + rate, G)
    height = start * t + 0.5 * rate * t * t + 0.5 * size[2]
    rides.note("lift, height", float(box.position[2]), height, 1.0)


@check(
    section="4.2",
    piece="softbody.World.add_box, softbody.Box.velocity",
    reference="closed form: impact on an infinite mass",
    kind="closed form",
    unit="of the speed at which they meet",
    tolerance=2e-12,
    because="four corners that say the same are solved at once, by impulses that are larger on the way than at the end:"
    " rounding is 2e-15 at worst of ten seeds, 3.7e-13 of 3 000 hits",
    faults=(
        RESTS,
        STAYS,
        FORESEEN,
        Fault(
            "sweeps that never go on, though they converge",
            sequential_impulses._sweep_all,
            "changed_ > FAST * before_ → True",
        ),
    ),
)
def paddles(run: Run) -> Comparison:
    """A paddle that flies and keeps its speed sends a box off, face against face, at V + e (V − v): boxes of 50 g to 20
    kg, speeds of 1 to 100 m/s in steps of 1/240 s, in which a plate may be through a thin box."""
    rng, rides = run.fresh_rng(), Rides([], [], [], [])
    for _ in range(run.count(10, 50, 500)):
        size = np.append(10.0 ** rng.uniform(-1.7, -0.2), rng.uniform(0.3, 0.6, 2))
        _paddle(rng, size, float(np.exp(rng.uniform(-3.0, 3.0))), rides)
    return rides.comparison()


def _paddle(rng: np.random.Generator, size: np.ndarray, mass: float, rides: Rides) -> None:
    """A plate hits a box face to face: in the plane of their centres, so that it does not turn."""
    world, e, speed = World(gravity=(0.0, 0.0, 0.0)), float(rng.random()), 10.0 ** rng.uniform(0.0, 2.0)
    own = rng.uniform(-10.0, 0.9 * speed)
    gap = rng.uniform(0.01, 0.5)
    plate = world.add_box((0.05, 1.0, 1.0), None, velocity=(speed, 0.0, 0.0), restitution=e)
    box = world.add_box(
        size, mass, (0.025 + gap + 0.5 * size[0], 0.0, 0.0), velocity=(own, 0.0, 0.0), restitution=e * rng.random()
    )
    world.run(gap / (speed - own) + 0.05, 1.0 / 240.0)
    rides.note("paddle", float(box.velocity[0]), speed + e * (speed - own), speed - own)
    rides.note("paddle itself", float(plate.velocity[0]), speed, speed)


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
    """Seen from a floor that moves evenly, fast or slowly, all is as on a floor at rest: boxes that land on it and on
    each other, and a soft ball, each with the floor's velocity added; over 0.5 s."""
    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    ball = icosphere(1, 0.3)
    for case in range(run.count(2, 8, 40)):
        sizes, masses = rng.uniform(0.2, 0.5, (2, 3)), np.exp(rng.uniform(-1.0, 1.0, 2))
        turn, bounce = random_orientations(rng, 1)[0], rng.random(3) * (case % 2)
        floor_velocity = 10.0 ** rng.uniform(-1.0, 1.0) * rng.normal(size=3)
        seen = []
        for u in (np.zeros(3), floor_velocity):
            world = World()
            floor = world.add_box((6.0, 6.0, 1.0), None, (0.0, 0.0, -0.5), velocity=u)
            world.add_box(sizes[0], masses[0], (0.0, 0.0, 0.7), turn, u, restitution=bounce[0])
            world.add_box(sizes[1], masses[1], (1.5, 0.0, 0.05 + 0.5 * sizes[1, 2]), velocity=u, restitution=bounce[1])
            world.add_soft_body(ball, 1.0, 150.0, 20.0, (-1.5, 0.0, 0.4), u, restitution=bounce[2], damping=0.3)
            world.run(0.5, 1.0 / 960.0)
            state = world.state
            own = floor.position + (0.0, 0.0, 0.5)
            seen.append((
                np.concatenate([state.particle_position, state.box_position[1:]]) - own,
                np.concatenate([state.particle_velocity, state.box_velocity[1:]]) - u,
            ))  # fmt: skip
        measured.append(np.hstack(seen[1]))
        expected.append(np.hstack(seen[0]))
        kinds += ["ball"] * len(ball.vertices) + ["box that tumbles", "box that lands flat"]
    scale = [1.0 if kind == "box that tumbles" else 1e-4 for kind in kinds]
    return Comparison(np.concatenate(measured), np.concatenate(expected), scale, kinds)


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
    """A kinematic plate that flies and turns hits boxes as Rapier's does: what each has of speed and spin after one
    impact at a corner, an edge or a face, without friction."""
    from references import rapier

    rng = run.fresh_rng()
    measured, expected, scales = [], [], []
    for _ in range(run.count(6, 15, 150)):
        # A plate in the plane y, z that comes along x, and turns; a box before it, in any orientation.
        plate, size, mass = np.array([0.2, 3.0, 3.0]), rng.uniform(0.2, 0.6, 3), float(np.exp(rng.uniform(-2.0, 2.0)))
        place = np.array([1.0, *rng.uniform(-0.8, 0.8, 2)])
        orientation = random_orientations(rng, 1)[0]
        speed, spin = rng.uniform(1.0, 3.0), rng.uniform(-0.8, 0.8, 3)
        e = float(rng.random())
        world = World(gravity=(0.0, 0.0, 0.0))
        sizes, masses = np.array([plate, size]), np.array([np.inf, mass])
        places, orientations = np.array([np.zeros(3), place]), np.array([(1.0, 0.0, 0.0, 0.0), orientation])
        velocities, spins = np.array([(speed, 0.0, 0.0), np.zeros(3)]), np.array([spin, np.zeros(3)])
        for k in range(2):
            given = None if k == 0 else mass, places[k], orientations[k], velocities[k], spins[k]
            world.add_box(sizes[k], *given, restitution=e, friction=0.0)
        step, steps = 2e-4, 0
        box = world.boxes[1]
        while not box.velocity.any() and steps < 10_000:
            world.step(step)
            steps += 1
        judged = rapier.velocities_after(
            sizes, masses, places, orientations, velocities, spins, step, steps + 3, restitution=e
        )
        measured.append(np.append(box.velocity, box.angular_velocity * 0.5 * size.min()))
        expected.append(np.append(judged[1, :3], judged[1, 3:] * 0.5 * size.min()))
        scales.append(speed + np.linalg.norm(spin))
    return Comparison(np.array(measured), np.array(expected), np.array(scales))


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
    """`move_to` leads a box evenly on SciPy's way from pose to pose, also along or about one axis only, is there on
    time, and stays."""
    from scipy.spatial.transform import Rotation, Slerp

    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for trial in range(run.count(14, 42, 420)):
        ends, places = random_orientations(rng, 2), rng.normal(size=(2, 3))
        if trial % 7 < 6:  # it goes along one axis only, or turns about one
            way, turn = np.split(np.eye(6)[trial % 7] * rng.uniform(-3.0, 3.0), 2)
            places[1] = places[0] + way
            one = Rotation.from_quat(np.roll(ends[0], -1))
            ends[1] = np.roll((Rotation.from_rotvec(turn) * one).as_quat(), 1) if turn.any() else ends[0]
        seconds, steps = rng.uniform(0.1, 10.0), int(rng.integers(1, 50))
        world = World()
        box = world.add_box(rng.uniform(0.1, 1.0, 3), None, places[0], ends[0])
        box.move_to(places[1], ends[1], seconds=seconds)
        way = Slerp([0.0, 1.0], Rotation.from_quat(np.roll(ends, -1, axis=1)))
        step = seconds / (2 * steps)
        late = step * rng.uniform(0.3, 1.7)  # it arrives within such a step, and stays
        for part, h, count in ((0.5, step, steps), (1.0, late, 4 * steps)):
            world.step(h, count)
            turned = Rotation.from_quat(np.roll(box.orientation, -1)).as_matrix()
            measured += [box.position.copy(), *turned]
            expected += [places[0] + part * (places[1] - places[0]), *way([part]).as_matrix()[0]]
            kinds += [f"place at {part:g}", *[f"turn at {part:g}"] * 3]
    return Comparison(np.array(measured), np.array(expected), groups=kinds)
