"""Claims that bodies do what was set, where it was set, and when."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from softbody import Body, Box, ParameterError, SoftBody, World, icosphere, torus
from softbody.bodies import adding, joint, soft_body
from softbody.bodies import body as bodies
from softbody.bodies.inventory import Inventory
from softbody.bodies.store import Store
from softbody.model import arrays
from softbody.storage import npz
from softbody.storage import restore as restoring
from validation.cases import edge_lengths, random_mesh
from validation.check import Comparison, Run, check
from validation.checks.contract.trajectories import Flight
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

PART = 0.01  # of the stable step, for rk4 to be as near to the truth as SciPy


MESHES = icosphere(1, 1.0), torus(0.8, 0.3, 10, 6)


class Swinging:
    """A soft body that is set anew on its way, and what SciPy makes of it."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self.mesh = MESHES[rng.integers(len(MESHES))]
        self.lengths = edge_lengths(self.mesh.vertices, self.mesh.edges)
        self.gravity, self.gas, self.stiffness = np.zeros(3), 0.0, np.full(len(self.lengths), 100.0)
        self.force, self.mass = np.zeros_like(self.mesh.vertices), 1.0
        self.position, self.velocity = self.mesh.vertices.copy(), np.zeros_like(self.mesh.vertices)

    def change(self) -> None:
        """Choose other numbers, and another motion."""
        rng, count = self.rng, len(self.mesh.vertices)
        self.gravity, self.gas = rng.normal(0.0, 3.0, 3), rng.uniform(0.0, 30.0)
        self.stiffness = rng.uniform(50.0, 150.0, len(self.lengths))
        self.force = 0.3 * rng.normal(size=(count, 3)) / count
        self.velocity = self.velocity + 0.1 * rng.normal(size=(count, 3))
        self.position = self.position + 0.01 * self.lengths.min() * rng.normal(size=(count, 3))

    def advance(self, seconds: float) -> None:
        """Move on, by SciPy."""
        from references import scipy

        mass = self.mass / len(self.position)
        springs = self.mesh.edges, self.lengths, self.stiffness
        push = self.force + mass * self.gravity
        what = self.position, self.velocity, *springs, self.mesh.triangles, self.gas, mass, seconds, push
        self.position, self.velocity = scipy.motion(*what, rtol=1e-11)

    @property
    def told(self) -> np.ndarray:
        """Position and velocity (n, 6)."""
        return np.hstack([self.position, self.velocity])


def now(body: SoftBody) -> np.ndarray:
    """Return position and velocity (n, 6) of a body of a World."""
    return np.hstack([body.positions, body.velocities])


REFERENCE = "SciPy's DOP853 on springs, gas, weight and forces by its own formulas, from change to change"
EXACT = "rk4 at a hundredth of the stable step: 4e-8 at worst of four seeds"


@check(
    section="2, 5.1",
    piece="softbody.SoftBody, softbody.World.gravity, softbody.bodies.store.Store.replace",
    reference=REFERENCE,
    engines=("scipy",),
    unit="m and m/s, of a body of some 1 m",
    tolerance=4e-7,
    because=EXACT,
    faults=(
        Fault(
            "a model that is not replaced",
            Store.replace,
            "self.contents.parts._replace(**parts)"
            " → self.contents.parts._replace(**{k: v for k, v in parts.items() if k != 'model' or "
            "len(parts) == 1})",
        ),
        Fault(
            "controls that are replaced by what they were",
            Store.replace,
            "self.contents.parts._replace(**parts)"
            " → self.contents.parts._replace(**{k: v for k, v in parts.items() if k != 'controls' or "
            "len(parts) == 1})",
        ),
        Fault(
            "gravity set on a copy",
            Inventory,
            'self.store.controls.gravity[:] = vector(value, "gravity")'
            ' → self.store.controls.gravity.copy()[:] = vector(value, "gravity")',
        ),
        Fault(
            "gas set on a copy",
            soft_body.SoftBody,
            "self.store.controls.soft_gas[r_] = v_ → self.store.controls.soft_gas.copy()[r_] = v_",
        ),
    ),
)
def set_on_the_way(run: Run) -> Comparison:
    """Gravity, gas, springs, forces, positions and velocities that are set on the way act from then on: by the handle
    of a body, and all at once by `store.replace`."""
    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for way in ("by handles", "by replace") * run.count(2, 6, 60):
        truth, world = Swinging(rng), World(gravity=(0.0, 0.0, 0.0), integrator="rk4")
        body = world.add_soft_body(truth.mesh, 1.0, 100.0, 0.0, damping=0.0)
        for _ in range(3):
            truth.change()
            if way == "by handles":
                world.gravity, body.gas, body.external_force = truth.gravity, truth.gas, truth.force
                body.positions, body.velocities = truth.position, truth.velocity
                body.set_springs(truth.stiffness, truth.lengths)
            else:
                truth.mass = rng.uniform(0.5, 2.0)
                fresh = World(gravity=truth.gravity, integrator="rk4")
                other = fresh.add_soft_body(truth.mesh, truth.mass, truth.stiffness, truth.gas, damping=0.0)
                other.external_force = truth.force
                other.positions, other.velocities = truth.position, truth.velocity
                world.store.replace(
                    model=fresh.model, controls=fresh.controls, state=fresh.state, rings=fresh.store.rings
                )
            steps = int(np.ceil(0.1 / (PART * world.stable_time_step())))
            world.step(0.1 / steps, steps)
            truth.advance(0.1)
            measured.append(now(body))
            expected.append(truth.told)
            kinds += [way] * len(truth.told)
    return Comparison(np.concatenate(measured), np.concatenate(expected), groups=kinds)


@check(
    section="9",
    piece="softbody.World.snapshot, softbody.World.restore, softbody.World.save, softbody.World.load",
    reference=REFERENCE,
    engines=("scipy",),
    unit="m and m/s, of a body of some 1 m",
    tolerance=4e-7,
    because=EXACT,
    faults=(
        Fault(
            "files in single precision",
            npz.write,
            "np.savez(file, **snapshot)"
            " → np.savez(file, **{k: np.float64(np.float32(v)) if v.dtype.kind == 'f' else v for k, v in "
            "snapshot.items()})",
        ),
        Fault(
            "settings that are not restored, as SciPy sees it",
            restoring.restore,
            '(store, "settings", settings) → (store, "settings", store.settings)',
        ),
    ),
)
def goes_on_from_a_file(run: Run) -> Comparison:
    """A world that was saved in the midst of its motion, or kept as a snapshot, goes on as SciPy does, from the file
    and restored, under the gravity, gas, springs and forces that it had."""
    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for _ in range(run.count(2, 6, 60)):
        truth = Swinging(rng)
        truth.change()
        world = World(gravity=truth.gravity, integrator="rk4")
        body = world.add_soft_body(truth.mesh, 1.0, truth.stiffness, truth.gas, damping=0.0)
        body.external_force, body.positions, body.velocities = truth.force, truth.position, truth.velocity
        steps = int(np.ceil(0.1 / (PART * world.stable_time_step())))
        world.step(0.1 / steps, steps)
        with tempfile.TemporaryDirectory() as folder:
            world.save(Path(folder) / "world.npz")
            loaded = World.load(Path(folder) / "world.npz")
        restored = World()
        restored.restore(world.snapshot())
        truth.advance(0.2)
        for kind, other in (("loaded", loaded), ("restored", restored)):
            other.step(0.1 / steps, steps)
            measured.append(now(other.soft_bodies[0]))
            expected.append(truth.told)
            kinds += [kind] * len(truth.told)
    return Comparison(np.concatenate(measured), np.concatenate(expected), groups=kinds)


@check(
    section="4.4, 5.2",
    piece="softbody.Box, softbody.Joint",
    reference="closed form of a step, by NumPy: v' = v + h F/m, x' = x + h v', of a damped spring along an axis",
    kind="closed form",
    unit="m and m/s",
    tolerance=3e-14,
    because="rounding over some hundred steps: 1.8e-15 at worst of ten seeds, 3.6e-15 of 200 worlds",
    faults=(
        Fault(
            "a stiffness that is only read again, on the way",
            joint.JointNumber.__set__,
            "joint.store.replace(joints=j_) → None",
        ),
        Fault("the first joint's number", joint.JointNumber.__set__, "joint.row() → 0"),
    ),
)
def boxes_and_joints_on_the_way(run: Run) -> Comparison:
    """Velocities, places and forces of a box that are set on the way act from then on, and so do stiffness, damping,
    length and target of a joint that pulls it."""
    rng = run.fresh_rng()
    measured, expected = [], []
    for _ in range(run.count(6, 20, 200)):
        world, h = World(gravity=(0.0, 0.0, 0.0)), 1e-3
        masses, places = rng.uniform(0.5, 2.0, 2), np.array([[0.0, 0.0, 0.0], [0.0, 5.0, 0.0]])
        boxes = [world.add_box((0.2, 0.2, 0.2), m, place) for m, place in zip(masses, places)]
        joints = [world.add_joint((box, box.position), box.position + (1.0, 0.0, 0.0), 10.0) for box in boxes]
        x, v = np.zeros(2), np.zeros(2)
        for _ in range(4):
            stiffness, damping = rng.uniform(5.0, 50.0, 2), rng.uniform(0.0, 1.0, 2)
            length, target, force = rng.uniform(0.1, 0.5, 2), rng.uniform(2.0, 3.0, 2), rng.normal(size=2)
            x, v = x + 0.05 * rng.normal(size=2), v + 0.1 * rng.normal(size=2)
            for k, (box, one) in enumerate(zip(boxes, joints)):
                box.position, box.velocity = places[k] + (x[k], 0.0, 0.0), (v[k], 0.0, 0.0)
                box.clear_forces()
                box.apply_force((force[k], 0.0, 0.0))
                one.stiffness, one.damping, one.rest_length = stiffness[k], damping[k], length[k]
                one.target = places[k] + (target[k], 0.0, 0.0)
            world.step(h, 30)
            for _ in range(30):
                v = v + h * (stiffness * (target - x - length) - damping * v + force) / masses
                x = x + h * v
            measured += [np.append(box.position - place, box.velocity) for box, place in zip(boxes, places)]
            expected += [[x[k], 0.0, 0.0, v[k], 0.0, 0.0] for k in range(2)]
    return Comparison(np.array(measured), np.array(expected))


@check(
    section="9",
    piece="softbody.State.copy",
    reference="closed form: the parabola, and its sum over semi-implicit steps for boxes",
    kind="closed form",
    unit="of the way and the speed, each at least 1",
    tolerance=5e-14,
    because="rounding over some hundred steps: 4.3e-15 at worst of ten seeds, 5.5e-15 of 100 worlds",
    faults=(
        Fault("places of boxes that both have", arrays.copied, "state.box_position.copy() → state.box_position"),
        Fault(
            "velocities of particles that both have",
            arrays.copied,
            "state.particle_velocity.copy() → state.particle_velocity",
        ),
    ),
)
def copies_stay(run: Run) -> Comparison:
    """A state that was copied stays as it was while the world goes on: bodies that flew are where the parabola has
    them, then and now."""
    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for _ in range(run.count(4, 12, 100)):
        flight = Flight(rng)
        world, step = flight.world, 0.5 * flight.world.stable_time_step()
        kept = []
        for _ in range(5):
            world.step(step, int(rng.integers(1, 20)))
            kept.append((world.steps, world.state.copy()))
        for steps, copied in [*kept, (world.steps, world.state)]:
            rows = [body.index for body in world.soft_bodies]
            parts = [slice(*world.model.soft_particle_start[k : k + 2]) for k in rows]
            middles = [*(copied.particle_position[part].mean(axis=0) for part in parts), *copied.box_position]
            speeds = [*(copied.particle_velocity[part].mean(axis=0) for part in parts), *copied.box_velocity]
            measured.append(np.hstack([middles, speeds]))
            expected.append(flight.at(step, steps)[:, 1:])
            kinds += ["the world" if copied is world.state else "a copy"] * 4
    scale = 1.0 + np.linalg.norm(np.concatenate(expected), axis=1)
    return Comparison(np.concatenate(measured), np.concatenate(expected), scale, kinds)


@check(
    section="9",
    piece="softbody.bodies.store.Store.follow, softbody.World.remove",
    reference="lists of Python's, from which the same are deleted",
    kind="specification",
    because="whole numbers, and masses that were given",
    faults=(
        Fault("a mass of what is fixed", soft_body.SoftBody, "i_[self._rows()].max() → i_[self._rows()].mean()"),
        Fault("handles that are not followed", Store.follow, "self.handles[id(handle)] = handle → pass"),
        Fault(
            "one handle a number",
            Store.follow,
            "self.handles[id(handle)] = handle → self.handles[handle.index] = handle",
        ),
        Fault(
            "handles that stay at their numbers, whatever is removed",
            adding.remove,
            "number - 1 if number > row else GONE → number if number > row else GONE",
        ),
    ),
)
def handles_follow_their_bodies(run: Run) -> Comparison:
    """While bodies are added and removed, anyhow, every handle that was kept stays that of its body: its number is the
    body's place among its kind, its mass the body's, also where particles are fixed, and it where the body was put; and
    of one that is gone it says so."""
    rng = run.fresh_rng()
    told, judged = [], []
    ball = random_mesh("box", rng)
    ball = ball.moved(-ball.vertices.mean(axis=0))
    for _ in range(run.count(2, 8, 60)):
        world = World()
        lists: dict[str, list[float]] = {"box": [], "soft body": []}
        handles: list[tuple[Body, float]] = []
        places: dict[float, np.ndarray] = {}  # by mass
        for turn in range(40):
            kind = str(rng.choice(["box", "soft body"]))
            there = lists[kind]
            if rng.random() < 0.6 or not there:
                mass = float(turn + 1)
                place = places[mass] = 5.0 * rng.normal(size=3)
                made: Body = (
                    world.add_box((0.1, 0.1, 0.1), mass, place)
                    if kind == "box"
                    else world.add_soft_body(ball, mass, 10.0, 1.0, place, fixed=range(turn % 3))
                )
                handles.append((made, mass))
                there.append(mass)
            else:
                gone = int(rng.integers(len(there)))
                there.pop(gone)
                try:
                    world.remove((world.boxes if kind == "box" else world.soft_bodies)[gone])
                except Exception:
                    break  # that the lists are of another length is seen below
            if turn % 3 == 0:  # another handle of a body that has one
                number = int(rng.integers(len(there))) if there else -1
                if number >= 0:
                    again = (Box if kind == "box" else SoftBody)(world, number)
                    handles.append((again, there[number]))
        for handle, mass in handles:
            alive = lists[handle.kind]
            number = alive.index(mass) if mass in alive else -1
            told += [handle.index == number, handle.is_there == (number >= 0)]
            judged += [True, True]
            if number >= 0 and handle.is_there:
                told.append(abs(_mass(handle) / mass - 1.0) < 1e-12)
                told.append(_is_at(handle, places[mass], len(ball.vertices)))
                judged += [True, True]
    return Comparison(np.array(told), np.array(judged))


def _mass(body: Body) -> float:
    """Return what a body says it weighs, NaN if it cannot say it."""
    try:
        return float(body.mass)  # type: ignore[attr-defined]
    except ZeroDivisionError:
        return float("nan")


def _is_at(body: Body, place: np.ndarray, particles: int) -> bool:
    """Tell whether a body is where it was put: all its particles about there."""
    if isinstance(body, Box):
        return bool((body.position == place).all())
    assert isinstance(body, SoftBody)
    return len(body.positions) == particles and float(np.abs(body.positions.mean(axis=0) - place).max()) < 1e-12


WHOLE_KINDS: tuple[Any, ...] = (SoftBody, Box, joint.Joint)


@check(
    section="beyond the paper",
    piece="softbody.Body",
    reference="the documentation; counts of the bodies that were added",
    kind="specification",
    faults=(
        Fault("one beyond the last", bodies.Body.row, "self.index < self._count() → self.index <= self._count()"),
        Fault("any number", bodies.Body.row, "not self.index < self._count() → False"),
    ),
)
def numbers_of_no_body(run: Run) -> Comparison:
    """A handle of a number that a world has a body of is that body's; of the next number, and of any beyond, it is
    refused by its kind, its number and how many there are: where it is made, and where it is asked after the world has
    become one of fewer bodies."""
    rng = run.fresh_rng()
    right, kinds = [], []
    for _ in range(run.count(6, 20, 200)):
        counts = rng.permutation([1, 2, 3])
        worlds = []
        for more in (1, 0):
            world = World()
            for k in range(counts[0] + more):
                world.add_soft_body(icosphere(0, 0.4), 1.0, 10.0, 1.0, (k, 0.0, 0.0))
            boxes = [world.add_box((1.0, 1.0, 1.0), 1.0, (k, 3.0, 0.0)) for k in range(counts[1] + more)]
            for _ in range(counts[2] + more):
                world.add_joint((boxes[0], (0.0, 3.0, 0.5)), (0.0, 9.0, 0.0), stiffness=1.0)
            worlds.append(world)
        larger, smaller = worlds
        for kind, count in zip(WHOLE_KINDS, counts.tolist()):
            last = kind(larger, count)
            said = f"{kind.kind} {{}} is not in this world: there are {{}}; take one that is"
            right.append(last.index == count and last.is_there)
            kinds.append(f"{kind.kind}: the last")
            for beyond in (1, 2, int(rng.integers(3, 1_000))):
                right.append(_refusal(partial(kind, larger, count + beyond)) == said.format(count + beyond, count + 1))
                kinds.append(f"{kind.kind}: {min(beyond, 3)} beyond the last")
        handles = [kind(larger, count) for kind, count in zip(WHOLE_KINDS, counts.tolist())]
        larger.restore(smaller.snapshot())
        for handle, count in zip(handles, counts.tolist()):
            told = _refusal(partial(getattr, handle, "name"))
            right.append(told == f"{handle.kind} {count} is not in this world: there are {count}; take one that is")
            kinds.append(f"{handle.kind}: in a world of one fewer")
    return Comparison(np.array(right), np.ones(len(right), bool), groups=kinds)


def _refusal(question: Callable[[], object]) -> str:
    """Return what a question is refused with, or nothing."""
    try:
        question()
    except ParameterError as error:
        return str(error)
    return ""
