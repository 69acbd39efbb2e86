"""Claims that bodies do what was set, where it was set, and when."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from softbody import Body, Box, Joint, ParameterError, SoftBody, World, icosphere, torus
from softbody.bodies import adding, builder, contact_points, energies
from softbody.bodies.inventory import Inventory
from softbody.bodies.store import Store
from softbody.model.arrays import copied
from softbody.stepping.frames import step_frame_contacts
from softbody.storage import npz
from softbody.storage.restore import restore
from validation.answers import Answers
from validation.cases import edge_lengths, random_mesh, random_orientations, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.contract.cases import error_of
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

    def world(self) -> World:
        """Return a world of the body as it is now."""
        world = World(gravity=self.gravity, integrator="rk4")
        body = world.add_soft_body(self.mesh, self.mass, self.stiffness, self.gas, damping=0.0)
        body.external_force, body.positions, body.velocities = self.force, self.position, self.velocity
        return world

    @property
    def told(self) -> np.ndarray:
        """Position and velocity (n, 6)."""
        return np.hstack([self.position, self.velocity])


def now(body: SoftBody) -> np.ndarray:
    """Return position and velocity (n, 6) of a body of a World."""
    return np.hstack([body.positions, body.velocities])


def tenth_of_a_second(world: World) -> tuple[float, int]:
    """Return how long a step [s] is, and how many there are."""
    steps = int(np.ceil(0.1 / (PART * world.stable_time_step())))
    return 0.1 / steps, steps


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
            " → self.contents.parts._replace(**{k: v for k, v in parts.items() if k != 'model' or len(parts) == 1})",
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
            "self.store.controls.gravity[:] = gravity → self.store.controls.gravity.copy()[:] = gravity",
        ),
        Fault(
            "gas set on a copy",
            SoftBody,
            "self.store.controls.soft_gas[r_] = v_ → self.store.controls.soft_gas.copy()[r_] = v_",
        ),
    ),
)
def set_on_the_way(run: Run) -> Comparison:
    """What is set on the way acts from then on.

    Gravity, gas, springs, forces, positions and velocities: by a body's handle, and all at once by `store.replace`.
    """
    rng, answers = run.fresh_rng(), Answers()
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
                fresh = truth.world()
                parts = {"model": fresh.model, "controls": fresh.controls, "state": fresh.state}
                world.store.replace(**parts, rings=fresh.store.rings)
            world.step(*tenth_of_a_second(world))
            truth.advance(0.1)
            answers.extend(now(body), truth.told, kind=way)
    return answers.comparison()


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
            restore,
            '(store, "settings", settings) → (store, "settings", store.settings)',
        ),
    ),
)
def goes_on_from_a_file(run: Run) -> Comparison:
    """A world goes on from a file or snapshot as SciPy does."""
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(2, 6, 60)):
        truth = Swinging(rng)
        truth.change()
        world = truth.world()
        steps = tenth_of_a_second(world)
        world.step(*steps)
        with tempfile.TemporaryDirectory() as folder:
            world.save(Path(folder) / "world.npz")
            loaded = World.load(Path(folder) / "world.npz")
        restored = World()
        restored.restore(world.snapshot())
        truth.advance(0.2)
        for kind, other in (("loaded", loaded), ("restored", restored)):
            other.step(*steps)
            answers.extend(now(other.soft_bodies[0]), truth.told, kind=kind)
    return answers.comparison()


@check(
    section="9",
    piece="softbody.State.copy",
    reference="closed form: the parabola, and its sum over semi-implicit steps for boxes",
    kind="closed form",
    unit="of the way and the speed, each at least 1",
    tolerance=5e-14,
    because="rounding over some hundred steps: 4.3e-15 at worst of ten seeds, 5.5e-15 of 100 worlds",
    faults=(
        Fault("places of boxes that both have", copied, "state.box_position.copy() → state.box_position"),
        Fault(
            "velocities of particles that both have", copied, "state.particle_velocity.copy() → state.particle_velocity"
        ),
    ),
)
def copies_stay(run: Run) -> Comparison:
    """A copied state stays as it was while the world goes on."""
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(4, 12, 100)):
        flight = Flight(rng)
        world, step = flight.world, 0.5 * flight.world.stable_time_step()
        kept = []
        for _ in range(5):
            world.step(step, int(rng.integers(1, 20)))
            kept.append((world.steps, world.state.copy()))
        for steps, state in [*kept, (world.steps, world.state)]:
            parts = [slice(*world.model.soft_particle_start[body.index :][:2]) for body in world.soft_bodies]
            middles = [*(state.particle_position[part].mean(axis=0) for part in parts), *state.box_position]
            speeds = [*(state.particle_velocity[part].mean(axis=0) for part in parts), *state.box_velocity]
            truth, kind = flight.at(step, steps)[:, 1:], "the world" if state is world.state else "a copy"
            answers.extend(np.hstack([middles, speeds]), truth, 1.0 + np.linalg.norm(truth, axis=1), kind)
    return answers.comparison()


@check(
    section="9",
    piece="softbody.bodies.store.Store.follow, softbody.World.remove",
    reference="lists of Python's, from which the same are deleted",
    kind="specification",
    because="whole numbers, and masses that were given",
    faults=(
        Fault(
            "a mass of what is fixed",
            SoftBody,
            "mass_of(m_) → len(self.positions) / self.store.model.particle_inverse_mass[self._rows()].mean()",
        ),
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
    """A handle stays that of its body, whatever is added or removed.

    Its number is the body's place among its kind, its mass the body's, also where particles are fixed. It is where the
    body was put; and of one that is gone it says so.
    """
    rng, answers = run.fresh_rng(), Answers()
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
                mass, place = float(turn + 1), 5.0 * rng.normal(size=3)
                if kind == "box":
                    made: Body = world.add_box((0.1, 0.1, 0.1), mass, place)
                else:
                    made = world.add_soft_body(ball, mass, 10.0, 1.0, place, fixed=range(turn % 3))
                handles.append((made, mass))
                there.append(mass)
                places[mass] = place
            else:
                gone = int(rng.integers(len(there)))
                there.pop(gone)
                try:
                    world.remove((world.boxes if kind == "box" else world.soft_bodies)[gone])
                except Exception:
                    break  # that the lists are of another length is seen below
            if turn % 3 == 0 and there:  # another handle of a body that has one
                number = int(rng.integers(len(there)))
                handles.append(((Box if kind == "box" else SoftBody)(world, number), there[number]))
        for handle, mass in handles:
            alive = lists[handle.kind]
            number = alive.index(mass) if mass in alive else -1
            answers.extend([handle.index == number, handle.is_there == (number >= 0)], [True, True])
            if number >= 0 and handle.is_there:
                is_at = _is_at(handle, places[mass], len(ball.vertices))
                answers.extend([abs(_mass(handle) / mass - 1.0) < 1e-12, is_at], [True, True])
    return answers.comparison()


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


WHOLE_KINDS: tuple[Any, ...] = (SoftBody, Box, Joint)
NOT_THERE = "{} {} is not in this world: there are {}; take one that is"


@check(
    section="beyond the paper",
    piece="softbody.Body",
    reference="the documentation; counts of the bodies that were added",
    kind="specification",
    faults=(
        Fault("one beyond the last", Body.row, "self.index < self._count() → self.index <= self._count()"),
        Fault("any number", Body.row, "not self.index < self._count() → False"),
    ),
)
def numbers_of_no_body(run: Run) -> Comparison:
    """A handle of a number that no body has is refused.

    By its kind, its number and how many there are: of the next number and of any beyond, where it is made. So it is
    where it is asked in a world of fewer bodies than before. That of a number that a body has is the body's.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(6, 20, 200)):
        counts = rng.permutation([1, 2, 3]).tolist()
        larger, smaller = (_world_of(*(count + more for count in counts)) for more in (1, 0))
        for kind, count in zip(WHOLE_KINDS, counts):
            last = kind(larger, count)
            answers.add(last.index == count and last.is_there, True, kind=f"{kind.kind}: the last")
            for beyond in (1, 2, int(rng.integers(3, 1_000))):
                refusal = error_of(ParameterError, kind, larger, count + beyond)
                is_so = str(refusal) == NOT_THERE.format(kind.kind, count + beyond, count + 1)
                answers.add(is_so, True, kind=f"{kind.kind}: {min(beyond, 3)} beyond the last")
        handles = [kind(larger, count) for kind, count in zip(WHOLE_KINDS, counts)]
        larger.restore(smaller.snapshot())
        for handle, count in zip(handles, counts):
            refusal = error_of(ParameterError, getattr, handle, "name")
            is_so = str(refusal) == NOT_THERE.format(handle.kind, count, count)
            answers.add(is_so, True, kind=f"{handle.kind}: in a world of one fewer")
    return answers.comparison()


def _world_of(soft: int, boxes: int, joints: int) -> World:
    """Return a world of so many of each kind."""
    world = World()
    for k in range(soft):
        world.add_soft_body(icosphere(0, 0.4), 1.0, 10.0, 1.0, (k, 0.0, 0.0))
    for k in range(boxes):
        world.add_box((1.0, 1.0, 1.0), 1.0, (k, 3.0, 0.0))
    for _ in range(joints):
        world.add_joint((world.boxes[0], (0.0, 3.0, 0.5)), (0.0, 9.0, 0.0), stiffness=1.0)
    return world


@check(
    section="2.3",
    piece="softbody.World.add_soft_body, softbody.SoftBody.pressure",
    reference="SciPy's DOP853 on springs and gas = pressure × volume, a sum of determinants by NumPy",
    engines=("scipy",),
    unit="m and m/s, of a body of some 1 m; pressures, of one",
    tolerance=4e-7,
    because=EXACT,
    faults=(
        Fault(
            "a pressure that is taken for joules",
            builder.gas_of,
            "check_range(pressure, 'pressure', p_, least=0.0, most=most) * volume"
            " → check_range(pressure, 'pressure', p_, least=0.0, most=most)",
        ),
        Fault(
            "a pressure in the volume of the mesh for good",
            SoftBody,
            "(c_ - least) * room → (c_ - least) * float(self.store.model.soft_mesh_volume[self.row()])",
        ),
    ),
)
def pressure_set_on_the_way(run: Run) -> Comparison:
    """A pressure is a gas in the volume of now.

    Given where a body is added, and set on the way when it is larger or smaller: how it moves on, and what it reads.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(3, 8, 60)):
        truth, world = Swinging(rng), World(gravity=(0.0, 0.0, 0.0), integrator="rk4")
        body: SoftBody | None = None
        for size in (1.0, *rng.uniform(0.9, 1.2, 2)):
            pressure = float(rng.uniform(1.0, 10.0))
            truth.position = truth.position * size
            truth.gas = pressure * np.linalg.det(truth.position[truth.mesh.triangles]).sum() / 6.0
            if body is None:
                body = world.add_soft_body(truth.mesh, 1.0, truth.stiffness, pressure=pressure, damping=0.0)
            else:
                body.positions, body.velocities = truth.position, truth.velocity
                body.pressure = pressure
            answers.extend(np.full((1, 6), body.pressure / pressure), np.ones((1, 6)), kind="pressure as it reads")
            step, steps = tenth_of_a_second(world)
            world.step(step, steps)
            truth.advance(step * steps)
            answers.extend(now(body), truth.told, kind="motion")
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.SoftBody.apply_impulse, softbody.SoftBody.velocity",
    reference="J and x × J, beside Σ m v and Σ x × m v by NumPy before and after",
    kind="closed form",
    unit="relative",
    tolerance=1e-11,
    because="rounding of sums over some 100 particles, some 1 m from the origin",
    faults=(
        Fault("blows about the origin", SoftBody._as_if_rigid, "vector(point, p_) - self.centre → vector(point, p_)"),
        Fault("blows that only turn", SoftBody._as_if_rigid, "change + np.cross(t_, a_) → np.cross(t_, a_)"),
        Fault("a velocity on top of the old one", SoftBody, "vector(value, v_) - self.velocity → vector(value, v_)"),
    ),
)
def impulses_give_their_momentum(run: Run) -> Comparison:
    """An impulse on a soft body gives its momentum.

    Both momenta change by J and x × J, wherever it strikes a body in motion; a velocity that is set is the centre's.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(20, 60, 600)):
        mesh, mass = MESHES[rng.integers(len(MESHES))], rng.uniform(0.5, 2.0)
        body = World().add_soft_body(mesh, mass, 100.0, 1.0, rng.normal(size=3))
        body.velocities = rng.normal(size=body.positions.shape)
        each, place, struck = mass / len(body.positions), body.positions.copy(), rng.normal(size=3)
        for point in (None, rng.normal(size=3)):
            before, impulse = body.velocities.copy(), rng.normal(size=3)
            body.apply_impulse(impulse, point)
            gained = each * (body.velocities - before)
            at = place.mean(axis=0) if point is None else point
            found = np.append(gained.sum(axis=0), np.cross(place, gained).sum(axis=0))
            answers.extend(found[None], np.append(impulse, np.cross(at, impulse))[None], kind="momenta")
        body.velocity = struck
        found = np.append(body.velocities.mean(axis=0), body.velocity)
        answers.extend(found[None], np.tile(struck, 2)[None], kind="velocity that is set")
    return answers.comparison()


G: np.ndarray = np.array([0.0, 0.0, -9.81])  # [m/s²]


@check(
    section="5.5",
    piece="softbody.World.step_frame_contacts, softbody.ContactPoints",
    reference="Newton's second law: m Δv − m g T over the frame, by NumPy; names as they were given",
    kind="closed form",
    unit="of the weight, over the frame",
    tolerance=5e-12,
    because="rounding of speeds, which a frame of a fall changes by 0.2 m/s: 2.4e-13 at worst of seven seeds",
    faults=(
        Fault("the last step alone", contact_points.of_all_steps, "time_step * len(found) → time_step"),
        Fault(
            "a frame whose steps are not counted",
            step_frame_contacts,
            "found.append(runner.contact_points()) → found[:] = [runner.contact_points()]",
        ),
        Fault(
            "names of boxes for soft bodies", contact_points.ContactPoints._called, "number < self.first_box → False"
        ),
    ),
)
def forces_over_a_frame(run: Run) -> Comparison:
    """Forces over a frame are what changes momentum.

    Balls and boxes fall on each other and on the ground. In each frame the mean force of all contacts on each body, and
    its weight, give the change of its momentum. Pairs are told by the names that bodies have. Balls are so firm that no
    step is taken in parts, of which the last alone is told.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(3, 10, 60)):
        world, bodies = World(), list[SoftBody | Box]()
        world.add_ground(friction=rng.uniform(0.2, 0.8))
        for k in range(rng.integers(2, 5)):
            place = (*rng.normal(0.0, 0.1, 2), 0.3 + 0.45 * k)
            if rng.random() < 0.5:
                ball = icosphere(1, 0.2)
                bodies.append(world.add_soft_body(ball, rng.uniform(0.5, 2.0), 3e3, 60.0, place, name=f"ball {k}"))
            else:
                bodies.append(world.add_box(rng.uniform(0.2, 0.4, 3), rng.uniform(0.5, 2.0), place, name=f"box {k}"))
        called = {**{("soft body", each.index): each.name for each in world.soft_bodies}}
        called |= {("box", each.index): each.name for each in world.boxes}
        for _ in range(40):
            before, seconds = [np.copy(body.velocity) for body in bodies], rng.uniform(0.005, 0.02)
            touched = world.step_frame_contacts(seconds)
            for body, velocity in zip(bodies, before):
                mass = float(body.mass or 0.0)
                needed = mass * (body.velocity - velocity) / seconds - mass * G
                answers.extend(touched.force_on(body)[None], needed[None], mass * 9.81, kind=body.kind)
            first, count = len(world.soft_bodies), len(bodies)
            labels = [called["soft body", k] if k < first else called["box", k - first] for k in range(count)]
            pairs = {(labels[a], labels[b] if b >= 0 else "the ground") for a, b in touched.pairs()}
            answers.add([float(len(pairs ^ touched.named_pairs())), 0.0, 0.0], np.zeros(3), kind="names")
    return answers.comparison()


@check(
    section="2, 5",
    piece="softbody.SoftBody.energies, softbody.Box.energies",
    reference="½ m v², ½ ω·Iω, ½ k (l − l₀)², −nRT ln V/V₀, −m g·x and −f·x by NumPy; all of the world's, of liquid",
    kind="closed form",
    unit="of the largest of them",
    tolerance=5e-14,
    because="rounding of sums over some 100 springs: 3.3e-15 at worst of four seeds",
    faults=(
        Fault(
            "gas of another body",
            energies._with_soft_bodies,
            "controls.soft_gas[which] → np.roll(controls.soft_gas, 1)[which]",
        ),
        Fault(
            "particles of all",
            energies._with_soft_bodies,
            "inverse_mass[particles] = m_ → inverse_mass[:] = model.particle_inverse_mass",
        ),
        Fault("boxes besides a soft body", energies._only_soft_body, "np.zeros_like(m_) → model.box_inverse_mass"),
        Fault("all boxes", energies._only_box, "model._replace(box_inverse_mass=inverse_mass) → model"),
    ),
)
def energies_of_each_body(run: Run) -> Comparison:
    """Each body has its part of the world's energies.

    Some soft bodies and boxes, with springs, gas, forces and spin, some of them in a liquid: each has its own energies
    by kind, and all of them together have the world's.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(20, 60, 600)):
        world, g = World(), np.array([0.0, 0.0, -rng.uniform(1.0, 10.0)])
        world.gravity = g
        if is_wet := rng.random() < 0.5:
            world.add_liquid(1000.0 * rng.random() + 1.0, rng.normal())
        total = np.zeros(6)
        for _ in range(rng.integers(1, 4)):
            mesh, gas, mass = MESHES[rng.integers(len(MESHES))], rng.uniform(0.5, 9.0), rng.uniform(0.5, 2.0)
            soft = world.add_soft_body(mesh, mass, 100.0, gas, rng.normal(size=3))
            soft.positions = rng.normal(size=3) + mesh.vertices @ (np.eye(3) + 0.1 * rng.normal(size=(3, 3)))
            soft.velocities = rng.normal(size=mesh.vertices.shape)
            soft.external_force = rng.normal(size=mesh.vertices.shape)
        for _ in range(rng.integers(1, 3)):
            size, mass = rng.uniform(0.2, 0.6, 3), rng.uniform(0.5, 2.0)
            turn = random_orientations(rng, 1)[0]
            world.add_box(size, mass, rng.normal(size=3), turn, rng.normal(size=3), rng.normal(size=3))
        world.add_box((1.0, 1.0, 1.0), None, (0.0, 0.0, -9.0))
        for body in world.soft_bodies:
            x, v, each = body.positions, body.velocities, body.mass / len(body.positions)
            mesh = MESHES[0] if len(x) == len(MESHES[0].vertices) else MESHES[1]
            lengths, now = edge_lengths(mesh.vertices, mesh.edges), edge_lengths(x, mesh.edges)
            volumes = [np.linalg.det(y[mesh.triangles]).sum() / 6.0 for y in (x, mesh.vertices)]
            right = np.array([
                0.5 * each * np.square(v).sum(), 50.0 * np.square(now - lengths).sum(),
                -body.gas * np.log(volumes[0] / volumes[1]), -each * (x @ g).sum(), -(body.external_force * x).sum(),
            ])  # fmt: skip
            found = np.array(body.energies())
            answers.extend(found[None, :5], right[None], np.abs(right).max(), kind="soft body")
            total += found
        for box in world.boxes:
            mass, sides, spin = (
                box.mass or 0.0,
                np.square(box.size),
                box.angular_velocity @ rotation_matrix(box.orientation),
            )
            inertia = mass * (sides.sum() - sides) / 12.0
            kinetic = 0.5 * mass * box.velocity @ box.velocity + 0.5 * inertia @ spin**2
            right = np.array([kinetic, 0.0, 0.0, -mass * box.position @ g, 0.0])
            found = np.array(box.energies())
            answers.extend(found[None, :5], right[None], max(1.0, np.abs(right).max()), kind="box")
            total += found
        whole = np.array(world.energies())
        answers.extend(total[None, :5], whole[None, :5], np.abs(whole).max(), kind="all of them")
        answers.extend(
            np.full((1, 5), total[5]), np.full((1, 5), whole[5]), np.abs(whole).max(), kind=f"liquid, {is_wet}"
        )
    return answers.comparison()
