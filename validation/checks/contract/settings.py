"""Claims that each thing that can be set, alone and with others, does what it says, and nothing else."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import softbody
from references import steppers
from references.free_boxes import FreeBox, Spring
from softbody import Box, Ground, Joint, SoftBody, World
from softbody.bodies.body import set_row
from softbody.bodies.joint import JointNumber
from softbody.bodies.sleep_tracker import SleepTracker
from softbody.bodies.surroundings import Surroundings
from softbody.stepping import sleep
from validation.answers import Answers
from validation.cases import edge_lengths, independent, random_orientations, rotation_matrix, settable, uneven_sphere
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

STEP, STEPS = 5e-4, 8
SPRINGS = {"stiffness", "rest_length", "tear_at"}  # that `set_springs` sets
TURNS = 3  # in which a thing is set: so that one of two bodies is set twice
SOFT, BOXES = 2, 3  # bodies; the last box has no mass, the others have a joint each
MODES = ("in motion", "at rest", "asleep")
SOMEWHERE = np.array([1.0, 2.0, 3.0])  # on a box, so that its turn shows


class Scene:
    """Bodies far from each other in a world, and what they are by hand."""

    def __init__(self, rng: np.random.Generator, mode: str) -> None:
        self.rng = rng
        self.world = World((0.0, 0.0, 0.0), sleep_speed=1e-6, sleep_after=0.001 if mode == "asleep" else 1e9)
        self.world.add_ground(-1000.0)
        self.gravity, self.integrator, self.substeps = np.zeros(3), "symplectic_euler", 1
        self.soft: list[steppers.SoftBody] = []
        self.motion: list[tuple[np.ndarray, np.ndarray]] = []  # positions and velocities of each soft body
        self.boxes: list[FreeBox] = []
        for k in range(SOFT):
            self._add_soft_body(self._place(k))
        for k in range(BOXES):
            self._add_box(self._place(SOFT + k), is_free=k < BOXES - 1)
        if mode == "in motion":
            for body in self.world.soft_bodies:
                set_velocities(self, body)
            for box in self.world.boxes:
                set_velocity(self, box)
                set_angular_velocity(self, box)
        self.advance()

    def _place(self, k: int) -> np.ndarray:
        return np.array([30.0 * k, 0.0, 0.0]) + self.rng.normal(size=3)

    def _add_soft_body(self, place: np.ndarray) -> None:
        mesh, rng = uneven_sphere(self.rng), self.rng
        mesh, mass, pins = mesh.scaled(0.5), rng.uniform(0.5, 2.0), [0, 5]
        lengths, free = edge_lengths(mesh.vertices, mesh.edges), np.ones(len(mesh.vertices), bool)
        free[pins] = False
        stiffness, damping = rng.uniform(20.0, 60.0), rng.uniform(0.0, 0.02)
        self.world.add_soft_body(mesh, mass, stiffness, 0.0, place, damping=damping, fixed=pins)
        body = steppers.SoftBody(
            mesh.edges, lengths, np.full(len(lengths), stiffness), mesh.triangles, 0.0, mass / len(free),
            self.gravity, np.zeros((len(free), 3)), damping, 0.0, free,
        )  # fmt: skip
        self.soft.append(body)
        self.motion.append((mesh.vertices + place, np.zeros((len(free), 3))))

    def _add_box(self, place: np.ndarray, is_free: bool) -> None:
        rng, turn = self.rng, random_orientations(self.rng, 1)[0]
        size, mass = rng.uniform(0.2, 0.6, 3), rng.uniform(0.5, 2.0) if is_free else None
        box, free = self.world.add_box(size, mass, place, turn), FreeBox(size, mass, place, rotation_matrix(turn))
        if is_free:
            length, stiffness = rng.uniform(0.5, 1.0), rng.uniform(20.0, 60.0)
            free.spring = Spring(place + length * self.direction(), stiffness, 0.1, length)
            self.world.add_joint((box, place), free.spring.target, stiffness, 0.1, length)
        self.boxes.append(free)

    def direction(self) -> np.ndarray:
        """Return a unit vector (3,)."""
        way = self.rng.normal(size=3)
        return way / np.linalg.norm(way)

    def smooth(self, x: np.ndarray) -> np.ndarray:
        """Return vectors (n, 3) at points (n, 3) that fold nothing: one for all, and a stretch by some tenths."""
        return self.rng.normal(0.0, 0.3, 3) + (x - x.mean(axis=0)) @ self.rng.normal(0.0, 0.3, (3, 3))

    def advance(self) -> None:
        """Make STEPS steps, in the world and by hand."""
        self.world.step(STEP, STEPS)
        for k, body in enumerate(self.soft):
            now = body._replace(gravity=self.gravity)
            part = STEP / self.substeps, STEPS * self.substeps
            self.motion[k] = steppers.motion(now, *self.motion[k], *part, self.integrator)
        for free in self.boxes:
            for _ in range(STEPS):
                free.advance(STEP, self.gravity)

    def rows(self) -> tuple[np.ndarray, np.ndarray]:
        """Return where all are and how they move, (n, 6): in the world, and by hand."""
        found = [np.hstack([body.positions, body.velocities]) for body in self.world.soft_bodies]
        judged = [np.hstack(motion) for motion in self.motion]
        for box, free in zip(self.world.boxes, self.boxes):
            ends = np.array(box.position), rotation_matrix(box.orientation) @ SOMEWHERE
            found.append(np.hstack([ends, [box.velocity, box.angular_velocity]]))
            judged.append(np.hstack([[free.place, free.turn @ SOMEWHERE], [free.velocity, free.spin]]))
        return np.concatenate(found), np.concatenate(judged)

    def told(self) -> dict[str, Any]:
        """Return all that may be set, as the world tells it: an entry for each attribute of each handle."""
        things: list[Any] = [self.world, self.world.ground]
        things += [*self.world.soft_bodies, *self.world.boxes, *self.world.joints]
        told: dict[str, Any] = {}
        for thing in things:
            names = independent(type(thing)) | (SPRINGS if isinstance(thing, SoftBody) else set())
            told |= {entry(thing, name): np.copy(getattr(thing, name)) for name in names}
        return told


def entry(thing: Any, name: str) -> str:
    """Return what an attribute of a thing is called among all that is told."""
    return f"{type(thing).__name__} {getattr(thing, 'index', '')}: {name}"


Set = dict[str, Any]  # what must be told from then on, by `entry`


def _one_of(scene: Scene, things: tuple[Any, ...]) -> Any:
    return things[scene.rng.integers(len(things))]


def _soft(scene: Scene) -> int:
    return int(scene.rng.integers(SOFT))


def _of_soft(name: str, low: float, high: float) -> Callable[[Scene], Set]:
    """Return what sets a number of a soft body."""

    def act(scene: Scene) -> Set:
        k, value = _soft(scene), scene.rng.uniform(low, high)
        body = scene.world.soft_bodies[k]
        setattr(body, name, value)
        if name in steppers.SoftBody._fields:
            scene.soft[k] = scene.soft[k]._replace(**{name: value})  # type: ignore[arg-type]
        return {entry(body, name): value}

    return act


def _springs(name: str, low: float, high: float) -> Callable[[Scene], Set]:
    """Return what sets a number of every spring of a soft body."""

    def act(scene: Scene) -> Set:
        k = _soft(scene)
        body, now = scene.world.soft_bodies[k], getattr(scene.soft[k], name)
        values = now * scene.rng.uniform(low, high, len(now))
        body.set_springs(**{name: values})
        scene.soft[k] = scene.soft[k]._replace(**{name: values})
        return {entry(body, name): values}

    return act


def _tear_at(scene: Scene) -> Set:
    body = scene.world.soft_bodies[_soft(scene)]
    values = scene.rng.uniform(9.0, 99.0, len(body.edges))  # what tears is judged apart
    body.set_springs(tear_at=values)
    return {entry(body, "tear_at"): values}


def _positions(scene: Scene) -> Set:
    k = _soft(scene)
    body, (x, v) = scene.world.soft_bodies[k], scene.motion[k]
    x = x + 0.1 * scene.smooth(x)
    body.positions, scene.motion[k] = x, (x, v)
    return {entry(body, "positions"): x}


def set_velocities(scene: Scene, body: SoftBody) -> Set:
    """Set the velocities of a soft body's particles."""
    k = body.index
    x, free = scene.motion[k][0], scene.soft[k].free
    asked = scene.smooth(x)
    body.velocities, v = asked, np.where(free[:, None], asked, 0.0)
    scene.motion[k] = x, v
    return {entry(body, "velocities"): v}


def _fixed(scene: Scene) -> Set:
    k = _soft(scene)
    body, (x, v), free = scene.world.soft_bodies[k], scene.motion[k], np.ones(len(scene.soft[k].free), bool)
    pins = np.sort(scene.rng.choice(len(free), 3, replace=False))
    free[pins] = False
    told = np.where(free[:, None], body.velocities, 0.0)
    body.fixed, scene.soft[k] = pins, scene.soft[k]._replace(free=free)
    scene.motion[k] = x, np.where(free[:, None], v, 0.0)
    return {entry(body, "fixed"): pins, entry(body, "velocities"): told}


def _external_force(scene: Scene) -> Set:
    k = _soft(scene)
    body, force = scene.world.soft_bodies[k], 2.0 * scene.soft[k].particle_mass * scene.smooth(scene.motion[k][0])
    body.external_force, scene.soft[k] = force, scene.soft[k]._replace(force=force)
    return {entry(body, "external_force"): force}


def _pressure(scene: Scene) -> Set:
    k = _soft(scene)
    body, pressure = scene.world.soft_bodies[k], scene.rng.uniform(1.0, 10.0)
    gas = pressure * np.linalg.det(body.positions[body.triangles]).sum() / 6.0
    body.pressure, scene.soft[k] = pressure, scene.soft[k]._replace(gas=gas)
    return {entry(body, "gas"): gas}


def _turning(arms: np.ndarray, moment: np.ndarray) -> np.ndarray:
    """Return the velocities (n, 3) of unit masses on a rigid body, with `arms` (n, 3), of this angular momentum."""
    inertia = sum((arm @ arm * np.eye(3) - np.outer(arm, arm) for arm in arms), np.zeros((3, 3)))
    return np.cross(np.linalg.inv(inertia) @ moment, arms)


def _moved(scene: Scene, act: Callable[[SoftBody, np.ndarray], np.ndarray]) -> Set:
    """Let `act` do something to a soft body, by arms (n, 3) from its centre, and return what velocities gain by it."""
    k = _soft(scene)
    body, (x, v), free = scene.world.soft_bodies[k], scene.motion[k], scene.soft[k].free[:, None]
    before = np.copy(body.velocities)
    more = np.where(free, act(body, body.positions - body.positions.mean(axis=0)), 0.0)
    scene.motion[k] = x, v + more
    return {entry(body, "velocities"): before + more}


def _velocity(scene: Scene) -> Set:
    def act(body: SoftBody, arms: np.ndarray) -> np.ndarray:
        asked, before = scene.rng.normal(size=3), body.velocities.mean(axis=0)
        body.velocity = asked
        return np.broadcast_to(asked - before, arms.shape)

    return _moved(scene, act)


def _spin(scene: Scene) -> Set:
    def act(body: SoftBody, arms: np.ndarray) -> np.ndarray:
        asked, before = scene.rng.normal(size=3), np.copy(body.velocities)
        body.angular_velocity = asked
        return np.cross(asked, arms) - _turning(arms, np.cross(arms, before).sum(axis=0))

    return _moved(scene, act)


def _impulse(scene: Scene) -> Set:
    def act(body: SoftBody, arms: np.ndarray) -> np.ndarray:
        blow, arm = scene.rng.normal(size=3), 0.1 * scene.rng.normal(size=3)
        mass = scene.soft[body.index].particle_mass
        body.apply_impulse(blow, body.positions.mean(axis=0) + arm)
        return (blow / len(arms) + _turning(arms, np.cross(arm, blow))) / mass

    return _moved(scene, act)


def _pushed(scene: Scene, act: Callable[[SoftBody, np.ndarray], np.ndarray]) -> Set:
    """Let `act` do something to a soft body, by arms (n, 3) from its centre, and return what its forces gain by it."""
    k = _soft(scene)
    body = scene.world.soft_bodies[k]
    force = scene.soft[k].force + act(body, body.positions - body.positions.mean(axis=0))
    scene.soft[k] = scene.soft[k]._replace(force=force)
    return {entry(body, "external_force"): force}


def _soft_force(scene: Scene) -> Set:
    def act(body: SoftBody, arms: np.ndarray) -> np.ndarray:
        force, arm = scene.rng.normal(size=3), 0.1 * scene.rng.normal(size=3)
        body.apply_force(force, body.positions.mean(axis=0) + arm)
        return force / len(arms) + _turning(arms, np.cross(arm, force))

    return _pushed(scene, act)


def _soft_torque(scene: Scene) -> Set:
    def act(body: SoftBody, arms: np.ndarray) -> np.ndarray:
        torque = 0.1 * scene.rng.normal(size=3)
        body.apply_torque(torque)
        return _turning(arms, torque)

    return _pushed(scene, act)


def _no_soft_forces(scene: Scene) -> Set:
    def act(body: SoftBody, arms: np.ndarray) -> np.ndarray:
        body.clear_forces()
        return -scene.soft[body.index].force

    return _pushed(scene, act)


def _self_contact(scene: Scene) -> Set:
    body = scene.world.soft_bodies[_soft(scene)]
    body.self_contact = 1e-9
    return {entry(body, "self_contact"): 1e-9}


def _liquid_density(scene: Scene) -> Set:
    body, density = scene.world.soft_bodies[_soft(scene)], 1e-15 * scene.rng.random()  # its weight is judged apart
    body.liquid_density = density
    return {entry(body, "liquid_density"): density}


def _name(kind: str) -> Callable[[Scene], Set]:
    def act(scene: Scene) -> Set:
        thing, name = _one_of(scene, getattr(scene.world, kind)), f"{kind} of {scene.rng.integers(10**9)}"
        thing.name = name
        return {entry(thing, "name"): name}

    return act


def _box(scene: Scene) -> tuple[Box, FreeBox]:
    k = int(scene.rng.integers(BOXES - 1))
    return scene.world.boxes[k], scene.boxes[k]


def _material(name: str) -> Callable[[Scene], Set]:
    def act(scene: Scene) -> Set:
        box, value = _one_of(scene, scene.world.boxes), scene.rng.random()
        setattr(box, name, value)
        return {entry(box, name): value}

    return act


def _place(scene: Scene) -> Set:
    box, free = _box(scene)
    free.place = free.place + 0.1 * scene.rng.normal(size=3)
    box.position = free.place
    return {entry(box, "position"): free.place}


def _turn(scene: Scene) -> Set:
    (box, free), turn = _box(scene), random_orientations(scene.rng, 1)[0]
    box.orientation, free.turn = turn, rotation_matrix(turn)
    return {entry(box, "orientation"): turn}


def set_velocity(scene: Scene, box: Box) -> Set:
    """Set the velocity of a box."""
    free = scene.boxes[box.index]
    free.velocity, free.time_left = scene.rng.normal(size=3), np.inf
    box.velocity = free.velocity
    return {entry(box, "velocity"): free.velocity}


def set_angular_velocity(scene: Scene, box: Box) -> Set:
    """Set the angular velocity of a box."""
    free = scene.boxes[box.index]
    free.spin, free.time_left = scene.rng.normal(size=3), np.inf
    box.angular_velocity = free.spin
    return {entry(box, "angular_velocity"): free.spin}


def _blow(scene: Scene) -> Set:
    (box, free), blow, arm = _box(scene), scene.rng.normal(size=3), 0.1 * scene.rng.normal(size=3)
    box.apply_impulse(blow, box.position + arm)
    assert free.mass is not None
    squares = free.size**2
    inertia = free.turn @ np.diag((squares.sum() - squares) / 12.0 * free.mass) @ free.turn.T
    free.velocity = free.velocity + blow / free.mass
    free.spin = free.spin + np.linalg.solve(inertia, np.cross(arm, blow))
    return {entry(box, "velocity"): free.velocity, entry(box, "angular_velocity"): free.spin}


def _force(scene: Scene) -> Set:
    (box, free), force, arm = _box(scene), scene.rng.normal(size=3), 0.1 * scene.rng.normal(size=3)
    box.apply_force(force, box.position + arm)
    free.force, free.torque = free.force + force, free.torque + np.cross(arm, force)
    return {}


def _torque(scene: Scene) -> Set:
    (box, free), torque = _box(scene), 0.1 * scene.rng.normal(size=3)
    box.apply_torque(torque)
    free.torque = free.torque + torque
    return {}


def _no_forces(scene: Scene) -> Set:
    box, free = _box(scene)
    box.clear_forces()
    free.force, free.torque = np.zeros(3), np.zeros(3)
    return {}


def _inside(scene: Scene) -> Set:
    """Say that a box is in no soft body, as it is."""
    box = _one_of(scene, scene.world.boxes)
    box.inside = None
    return {entry(box, "inside"): None}


def _move_to(scene: Scene) -> Set:
    box, free, rng = scene.world.boxes[-1], scene.boxes[-1], scene.rng
    seconds, way, axis, angle = 1.4 * STEP * STEPS, rng.normal(size=3), scene.direction(), rng.uniform(0.1, 3.0)
    turn = _product(np.append(np.cos(0.5 * angle), np.sin(0.5 * angle) * axis), box.orientation)
    box.move_to(free.place + way, turn, seconds=seconds)
    free.velocity, free.spin, free.time_left = way / seconds, angle / seconds * axis, seconds
    return {entry(box, "velocity"): free.velocity, entry(box, "angular_velocity"): free.spin}


def _product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return the quaternion that turns as `q` does, and then as `p`."""
    real = p[0] * q[0] - p[1:] @ q[1:]
    return np.append(real, p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))


def _of_joint(name: str, low: float, high: float) -> Callable[[Scene], Set]:
    """Return what sets a number of a joint."""

    def act(scene: Scene) -> Set:
        joint, value = _one_of(scene, scene.world.joints), scene.rng.uniform(low, high)
        setattr(joint, name, value)
        setattr(scene.boxes[joint.index].spring, name, value)
        return {entry(joint, name): value}

    return act


def _target(scene: Scene) -> Set:
    joint = _one_of(scene, scene.world.joints)
    spring = scene.boxes[joint.index].spring
    assert spring is not None
    spring.target = spring.target + 0.1 * scene.rng.normal(size=3)
    joint.target = spring.target
    return {entry(joint, "target"): spring.target}


def _ground(name: str, low: float, high: float) -> Callable[[Scene], Set]:
    def act(scene: Scene) -> Set:
        value = scene.rng.uniform(low, high)
        setattr(scene.world.ground, name, value)
        return {entry(scene.world.ground, name): value}

    return act


def _world(name: str, choose: Callable[[np.random.Generator], Any]) -> Callable[[Scene], Set]:
    def act(scene: Scene) -> Set:
        value = choose(scene.rng)
        setattr(scene.world, name, value)
        if hasattr(scene, name):
            setattr(scene, name, value)
        return {entry(scene.world, name): value}

    return act


SETTINGS: dict[str, Callable[[Scene], Set]] = {
    "World.gravity": _world("gravity", lambda rng: rng.normal(0.0, 3.0, 3)),
    "World.integrator": _world("integrator", lambda rng: str(rng.choice(["rk4", "rk4_velocity"]))),
    "World.substeps": _world("substeps", lambda rng: int(rng.integers(2, 5))),
    "World.threads": _world("threads", lambda rng: 2),
    "World.time": _world("time", lambda rng: rng.uniform(0.0, 1e3)),
    "Ground.height": _ground("height", -900.0, -500.0),
    "Ground.friction": _ground("friction", 0.0, 1.0),
    "Ground.restitution": _ground("restitution", 0.0, 1.0),
    "SoftBody.gas": _of_soft("gas", 0.1, 1.0),
    "SoftBody.pressure": _pressure,
    "SoftBody.damping": _of_soft("damping", 0.02, 0.05),
    "SoftBody.drag": _of_soft("drag", 1.0, 5.0),
    "SoftBody.friction": _of_soft("friction", 0.0, 1.0),
    "SoftBody.restitution": _of_soft("restitution", 0.0, 1.0),
    "SoftBody.deflated_below": _of_soft("deflated_below", 0.0, 0.1),
    "SoftBody.self_contact": _self_contact,
    "SoftBody.liquid_density": _liquid_density,
    "SoftBody.sound_speed": _of_soft("sound_speed", 0.0, 9.0),
    "SoftBody.liquid_drag": _of_soft("liquid_drag", 0.0, 9.0),
    "SoftBody.leak": _of_soft("leak", 0.0, 999.0),
    "SoftBody.fixed": _fixed,
    "SoftBody.positions": _positions,
    "SoftBody.velocities": lambda scene: set_velocities(scene, scene.world.soft_bodies[_soft(scene)]),
    "SoftBody.velocity": _velocity,
    "SoftBody.angular_velocity": _spin,
    "SoftBody.apply_impulse": _impulse,
    "SoftBody.external_force": _external_force,
    "SoftBody.apply_force": _soft_force,
    "SoftBody.apply_torque": _soft_torque,
    "SoftBody.clear_forces": _no_soft_forces,
    "SoftBody.name": _name("soft_bodies"),
    "SoftBody.set_springs, stiffness": _springs("stiffness", 0.5, 2.0),
    "SoftBody.set_springs, rest_length": _springs("rest_length", 0.9, 1.1),
    "SoftBody.set_springs, tear_at": _tear_at,
    "Box.friction": _material("friction"),
    "Box.restitution": _material("restitution"),
    "Box.name": _name("boxes"),
    "Box.position": _place,
    "Box.orientation": _turn,
    "Box.velocity": lambda scene: set_velocity(scene, _one_of(scene, scene.world.boxes)),
    "Box.angular_velocity": lambda scene: set_angular_velocity(scene, _one_of(scene, scene.world.boxes)),
    "Box.inside": _inside,
    "Box.move_to": _move_to,
    "Box.velocity, on its way": lambda scene: _move_to(scene) | set_velocity(scene, scene.world.boxes[-1]),
    "Box.apply_impulse": _blow,
    "Box.apply_force": _force,
    "Box.apply_torque": _torque,
    "Box.clear_forces": _no_forces,
    "Joint.stiffness": _of_joint("stiffness", 20.0, 60.0),
    "Joint.damping": _of_joint("damping", 0.0, 2.0),
    "Joint.rest_length": _of_joint("rest_length", 0.2, 0.4),
    "Joint.target": _target,
    "Joint.name": _name("joints"),
}


NOT_BOTH = "SoftBody.liquid_density", "SoftBody.set_springs, tear_at"
METHODS = {"set_springs", "move_to", "apply_impulse", "apply_force", "apply_torque", "clear_forces"}


def _all_there_is() -> set[str]:
    """Return all that may be set, by what Python tells of the classes."""
    there = {f"{kind.__name__}.{name}" for kind in (World, Ground, SoftBody, Box, Joint) for name in settable(kind)}
    return there | {f"{kind.__name__}.{name}" for kind in (SoftBody, Box) for name in METHODS if hasattr(kind, name)}


@check(
    section="2, 5",
    piece="softbody.World, softbody.SoftBody, softbody.Box, softbody.Joint, softbody.Ground",
    reference="NumPy's springs, gas and steps by its own formulas, SciPy's turns; what was set, in a dict",
    engines=("scipy",),
    unit="m, m/s and rad/s; 1 for each thing that is told wrongly",
    tolerance=2e-10,
    because="rounding, which grows in what is stretched and let go: 2.3e-11 at standard; 8e-11 of eight seeds and"
    " stretches of 2.5 times as many steps of the same length",
    faults=(
        Fault(
            "a number of the body before",
            set_row,
            "body.row() if rows is None else rows → body.row() - 1 if rows is None else rows",
        ),
        Fault(
            "gas of the first body",
            SoftBody,
            "self.store.controls.soft_gas[self.row()] = v_ → self.store.controls.soft_gas[0] = v_",
        ),
        Fault(
            "forces that are pushed to the first body",
            SoftBody,
            "self.store.controls.particle_force[self._rows()] = force"
            " → self.store.controls.particle_force[: len(force)] = force",
        ),
        Fault(
            "springs of another body",
            SoftBody,
            "stiffnesses[edges] = s_ → stiffnesses[: count] = stiffness_of(stiffness, count)",
        ),
        Fault("forces that are as before, once there are some", SoftBody, "not len(controls.particle_force) → True"),
        Fault(
            "rest lengths that the rings do not know",
            SoftBody,
            "with_springs(rings, lengths, s_, m_) → with_springs(rings, model.edge_rest_length, s_, m_)",
        ),
        Fault(
            "stiffness that the rings do not know",
            SoftBody,
            "with_springs(rings, lengths, stiffnesses, m_) → with_springs(rings, lengths, model.edge_stiffness, m_)",
        ),
        Fault(
            "pins besides those that there were",
            SoftBody._pin,
            "model.particle_free_inverse_mass[rows].copy() → model.particle_inverse_mass[rows].copy()",
        ),
        Fault("velocities of the pinned", SoftBody, "velocity[self.fixed] = 0.0 → "),
        Fault("a way that is not turned", Box.move_to, "turn = rotation_between(o_, u_) → pass"),
        Fault(
            "a way from the origin",
            Box.move_to,
            "vector(position, 'position') - self.position → vector(position, 'position')",
        ),
        Fault("a box that does not stop", Box.move_to, "self._go(velocity, spin, seconds) → self._go(velocity, spin)"),
        Fault(
            "a velocity that ends no way",
            Box._go,
            "(state.box_time_left[a_:b_], seconds)"
            " → (state.box_time_left[row : row + 1], max(seconds, state.box_time_left[row]))",
        ),
        Fault(
            "forces in place of those that there were", Box.apply_force, "controls.box_force[row] + newtons → newtons"
        ),
        Fault(
            "a force whose arm is from the origin",
            Box.apply_force,
            "vector(point, 'point') - self.position → vector(point, 'point')",
        ),
        Fault(
            "a soft body's forces in place of those before", SoftBody.apply_force, "self.external_force + each → each"
        ),
        Fault(
            "torques on a soft body in place of those before", SoftBody.apply_torque, "self.external_force + e_ → each"
        ),
        Fault("forces on a soft body that stay", SoftBody.clear_forces, "self.external_force = f_ → pass"),
        Fault(
            "a spin on top of the old one", SoftBody, "vector(value, v_) - self.angular_velocity → vector(value, v_)"
        ),
        Fault("an inertia of equal axes", SoftBody._turn, "(arms.T * self.masses) @ arms → 0.0"),
        Fault("a blow to a box that only pushes", Box.apply_impulse, "turn = axes @ t_ → pass"),
        Fault("a blow that turns about the box's axes", Box.apply_impulse, "rotation_matrix(o_) → np.eye(3)"),
        Fault(
            "a torque in place of those that there were",
            Box.apply_torque,
            "self.store.controls.box_torque[self.row()] += t_ → self.store.controls.box_torque[self.row()] = t_",
        ),
        Fault(
            "torques that stay when forces are cleared",
            Box.clear_forces,
            "(controls.box_torque[row], 0.0) → (controls.box_torque[row], controls.box_torque[row].copy())",
        ),
        Fault(
            "a stiffness that is only read again, on the way",
            JointNumber.__set__,
            "joint.store.replace(joints=j_) → None",
        ),
        Fault(
            "a number of another joint",
            JointNumber.__set__,
            "array[joint.row()] = value → array[joint.row() - 1] = value",
        ),
        Fault("all three of the ground", Surroundings.set_field, "f'{self.kind}_{name}' → 'ground_friction'"),
        Fault(
            "an integrator that is for the next bodies",
            World,
            "self.store.settings = with_integrator(s_, v_) → with_integrator(s_, v_)",
        ),
        Fault(
            "sub-steps besides other choices",
            World,
            "self.store.settings._replace(substeps=s_) → settings_of({'substeps': value})",
        ),
        Fault("bodies that sleep on under other springs", SleepTracker.model_of, "self.rest.time[:] = 0.0 → "),
        Fault("bodies that sleep on with other gas", sleep._mark_of_soft, "checksum(controls_.soft_gas[a_:b_]) → 0"),
    ),
)
def each_setting_does_what_it_says(run: Run) -> Comparison:
    """Each thing that can be set does what it says.

    Every attribute that may be assigned and every method that pushes, of the world, the ground, soft bodies, boxes and
    joints: set alone and after all others, while bodies move, rest or sleep. It is told from then on, and nothing else
    is told otherwise; and all bodies go on as they do by hand.
    """
    rng, answers = run.fresh_rng(), Answers()
    known = {what.partition(",")[0] for what in SETTINGS}
    _add_wrong(answers, sorted(known ^ _all_there_is()), "all that may be set")
    for _ in range(run.count(1, 3, 12)):
        for what in SETTINGS:
            for mode in MODES:
                scene = Scene(rng, mode)
                for _ in range(TURNS):
                    _set(scene, what, answers, f"{what}, {mode}")
        for mode in MODES:
            scene, never = Scene(rng, mode), ("SoftBody.self_contact", NOT_BOTH[rng.integers(2)])
            for what in rng.permutation([what for what in SETTINGS if what not in never]).tolist():
                _set(scene, what, answers, f"{what}, {mode}, with others")
    return answers.comparison()


def _set(scene: Scene, what: str, answers: Answers, kind: str) -> None:
    """Set something, see what is told then, and how all go on."""
    expected = scene.told()
    expected |= SETTINGS[what](scene)
    told = scene.told()
    _add_wrong(answers, [name for name in expected if not _is_same(told[name], expected[name])], kind)
    scene.advance()
    answers.extend(*scene.rows(), kind=kind)


def _is_same(a: Any, b: Any) -> bool:
    """Tell whether what is told is what was set, but for rounding."""
    if np.asarray(b).dtype.kind != "f":
        return bool(np.array_equal(a, b))
    return np.shape(a) == np.shape(b) and bool(np.allclose(a, b, rtol=1e-12, atol=1e-12))


def _add_wrong(answers: Answers, names: list[str], kind: str) -> None:
    """Add how many things are told wrongly: there should be none."""
    answers.add([float(len(names)), *np.zeros(5)], np.zeros(6), kind=kind)


PUSH: np.ndarray = np.array([0.0, 0.0, 1.5])  # [m/s]
LOOSE: dict[str, Callable[[World, Any, float], object]] = {  # what lets go of what lies on a slope
    "its friction": lambda world, body, friction: setattr(body, "friction", friction**2 / 0.8),
    "the ground's friction": lambda world, body, friction: setattr(world.ground, "friction", friction**2 / 0.8),
    "the ground's height": lambda world, body, friction: setattr(world.ground, "height", -1.0),
    "another ground": lambda world, body, friction: world.add_ground(-1.0),
    "a lift": lambda world, body, friction: setattr(body, "position", body.position + [0.0, 0.0, 0.5]),
    "a push": lambda world, body, friction: setattr(body, "velocity", PUSH),
}


@check(
    section="5.2, 5.4",
    piece="softbody.World, softbody.SoftBody, softbody.Box, softbody.Ground",
    reference="closed form: a t (t + h) / 2, of a fall along gravity, or down a slope with g (sin α − μ cos α)",
    kind="closed form",
    unit="of the way of a fall",
    tolerance=1e-6,
    because="sweeps end where impulses change little: 1.4e-7 at worst of ten seeds",
    faults=(
        Fault("a ground that stays as it is", Surroundings.set_field, "store.replace(model=m_) → None"),
        Fault(
            "pins that are drawn in one's sleep",
            SleepTracker.model_of,
            "model is not self._model → model.soft_count != self._model.soft_count",
        ),
    ),
)
def what_sleeps_is_let_go(run: Run) -> Comparison:
    """What sleeps on a slope goes when it is let go.

    A box lies asleep on rough ground, in gravity that is aslant, and a soft box hangs asleep on its pins. The box's
    friction or the ground's is set, or its height, or the box is lifted or pushed up, and the pins are drawn: from the
    next step on they slide or fly.
    """
    rng, answers = run.fresh_rng(), Answers()
    h, steps = 5e-4, 100
    t = h * steps
    for what, let_go in [*LOOSE.items()] * run.count(2, 8, 40):
        slope, friction = rng.uniform(0.2, 0.4), rng.uniform(0.0, 0.15)
        gravity = 9.81 * np.array([np.sin(slope), 0.0, -np.cos(slope)])
        world = World(gravity, sleep_speed=0.2, sleep_after=0.05)
        world.add_ground(friction=0.8)
        size, hanging = rng.uniform(0.3, 0.6, 3), {"position": (0.0, 9.0, 5.0), "fixed": range(8)}
        box = world.add_box(size, 1.0, (0.0, 0.0, 0.5 * size[2]), friction=0.8)
        hung = world.add_soft_body(softbody.box(size, 2), 1.0, 400.0, 5.0, damping=1.0, **hanging)  # type: ignore[arg-type]
        world.run(2.0, h)
        is_asleep = box.is_asleep and hung.is_asleep
        hung.fixed = ()
        let_go(world, box, friction)
        start = np.array([box.position, hung.centre])
        world.step(h, steps)
        fall = gravity * t * (t + h) / 2.0
        slide = [fall[0] + friction * fall[2], 0.0, 0.0]
        judged = slide if "friction" in what else fall + PUSH * t if what == "a push" else fall
        found = np.array([box.position, hung.centre]) - start if is_asleep else np.full((2, 3), np.inf)
        answers.extend(found, [judged, fall], float(np.linalg.norm(fall)), kind=what)
    return answers.comparison()
