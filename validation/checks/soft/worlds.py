"""Soft bodies that meet each other, boxes and the ground: the impulses, and the paper's scenes."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import softbody
from softbody import SoftBody, World
from softbody.collision.contact import Touch, add_contact, box_side, new_contacts, soft_side
from softbody.collision.soft import soft_response, soft_soft, soft_solver
from softbody.collision.soft.soft_response import Bodies, resolve_contacts, response_memory
from softbody.model import material as law
from softbody.model import surface_point
from softbody.model.arrays import Particles, RigidBodies
from softbody.model.material import Material
from softbody.model.surface_point import SurfacePoint, at_particle
from softbody.scenes import boxes_on_torus, rolling_torus, tray
from validation import accounts
from validation.answers import Answers
from validation.cases import random_orientations, rotation_matrix
from validation.check import Comparison, Misprint, Run, check
from validation.checks.soft.cases import ALL_OF_THE_MASS, CONTACTS, ONE_SIDED, weightless
from validation.fault import Fault

FAMILY = "soft contacts and scenes"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

NO_FRICTION = Fault("no friction on the ground", law.sliding_kept, "material_.friction → 0.0 * material_.friction")

STEP = 0.8  # of the stable time step
CONTACT_STEP = 0.01  # [s]
KINDS = [(kind, count) for kind in ("soft–soft", "soft–rigid") for count in (1, 3)]


class Contacts:
    """A triangle of particles, and three more particles, or a spinning box, that touch it at `count` points: random.

    The particles share the triangle's, and so does the box: contacts that act at the same time. `apart` [m]: how far
    they have gone through each other in a step.
    """

    def __init__(self, rng: np.random.Generator, kind: str, count: int, apart: float = 0.0) -> None:
        position, self.velocity = rng.normal(size=(6, 3)), rng.normal(size=(6, 3))
        self.position, self.mass = position, 10.0 ** rng.uniform(-1.0, 1.0, 6)
        face = np.cross(position[1] - position[0], position[2] - position[0])
        self.box_mass, size = 10.0 ** rng.uniform(-1.0, 1.0), rng.uniform(0.3, 2.0, 3)
        x, y, z = size**2
        self.inertia = self.box_mass / 12.0 * np.array([y + z, x + z, x + y])
        inverse = np.array([1.0 / self.box_mass]), 1.0 / self.inertia[None]
        place, turn = rng.normal(size=(1, 3)), random_orientations(rng, 1)
        self.box = RigidBodies(*inverse, place, turn, rng.normal(size=(1, 3)), rng.normal(size=(1, 3)))
        self.contacts = new_contacts(count)
        for k in range(count):
            weights, normal = rng.dirichlet((1.0, 1.0, 1.0)), face / np.linalg.norm(face) + 0.15 * rng.normal(size=3)
            normal /= np.linalg.norm(normal)
            material = Material(float(rng.random()), float(rng.choice([0.0, 0.3, 1.0])))
            a, at = soft_side(SurfacePoint((0, 1, 2), tuple(weights))), weights @ position[:3]
            b = box_side(0)
            if kind == "soft–soft":
                position[3 + k] = at = at - apart * normal
                a, b = soft_side(at_particle(3 + k)), a
            add_contact(self.contacts, a, b, Touch(tuple(at + 0.5 * apart * normal), tuple(normal), apart, 0), material)

    def part(self) -> None:
        """Let the core part them, after a step in which all have moved as they move now."""
        inverse, start = 1.0 / self.mass, self.position - CONTACT_STEP * self.velocity
        before = Particles(inverse, start, self.velocity.copy()), RigidBodies(*(rows.copy() for rows in self.box))
        now = Bodies(Particles(inverse, self.position, self.velocity), self.box)
        resolve_contacts(
            self.contacts,
            now,
            Bodies(*before),
            response_memory(np.array([0, 6]), len(self.box.inverse_mass)),
            CONTACT_STEP,
        )

    def momenta(self) -> np.ndarray:
        """Return (6,): total momentum, and total angular momentum about the origin."""
        v, w, x = self.box.velocity[0], self.box.angular_velocity[0], self.box.position[0]
        linear = self.mass @ self.velocity + self.box_mass * v
        spin = self.world_inertia() @ w
        angular = self.mass @ np.cross(self.position, self.velocity) + self.box_mass * np.cross(x, v) + spin
        return np.concatenate([linear, angular])

    def energy(self) -> float:
        """Return the kinetic energy [J]."""
        v, w = self.box.velocity[0], self.box.angular_velocity[0]
        soft = 0.5 * self.mass @ (self.velocity**2).sum(axis=1)
        return soft + 0.5 * self.box_mass * v @ v + 0.5 * w @ self.world_inertia() @ w

    def world_inertia(self) -> np.ndarray:
        """Return R I Rᵀ."""
        matrix = rotation_matrix(self.box.orientation[0])
        return matrix @ np.diag(self.inertia) @ matrix.T


@check(
    section="4.2, 4.3",
    piece="softbody.collision.soft.soft_solver.solve_island",
    reference="invariant",
    unit="of the momenta",
    kind="invariant",
    tolerance=2e-14,
    because="rounding of some dozens of products",
    faults=(
        Fault(
            "a point of a surface pushed as if its weights were squared",
            surface_point.add_at,
            "weights_[0] * inverse_mass_[i_] → weights_[0] * weights_[0] * inverse_mass_[i_]",
        ),
        Fault(
            "reactions where the surface's point was, though it has been moved aside",
            soft_response._place_on_b,
            "line_meets_triangle(contacts_, k_, particles_, direction_, ago_)"
            " → surface_point(contacts_, k_, 1).weights",
        ),
    ),
)
def impulses_keep_momenta(run: Run) -> Comparison:
    """Impulses of soft contacts keep momentum and angular momentum.

    Between soft bodies, or of one and a box, with friction, alone or at once. So does a contact that has overlapped and
    is brought back.
    """
    rng, answers = run.fresh_rng(), Answers()
    for kind, count in KINDS * run.count(150, 1_000, 10_000):
        for apart in (0.0, 0.5 * CONTACT_STEP)[: 2 if count == 1 else 1]:
            contacts = Contacts(rng, kind, count, apart)
            before = contacts.momenta()
            contacts.part()
            scale = 1.0 + np.linalg.norm(before[None], axis=1)
            label = f"{kind}, {count} at once" + (", overlapping" if apart else "")
            answers.add(contacts.momenta(), before, scale[0], label)
    return answers.comparison()


@check(
    section="4.2, 4.3",
    piece="softbody.collision.soft.soft_solver.solve_island",
    reference="invariant",
    unit="energy gained, relative",
    kind="invariant",
    tolerance=4e-15,
    because="gains only, and rounding of two sums of some thirty terms: none gained; a real gain is of the energy's"
    " order",
    faults=(
        Fault(
            "a box hit by a soft body gives way as if it could not turn",
            soft_solver._add_box,
            "dot(by_normal_, normal_) → sharing.box_inverse_mass[box]",
        ),
        ALL_OF_THE_MASS,
    ),
)
def impulses_add_no_energy(run: Run) -> Comparison:
    """Impulses of soft contacts add no kinetic energy.

    Between soft bodies, or of one and a box, one or several at once.
    """
    rng, answers = run.fresh_rng(), Answers()
    for kind, count in KINDS * run.count(300, 2_000, 20_000):
        contacts = Contacts(rng, kind, count)
        before = contacts.energy()
        contacts.part()
        answers.add(np.maximum(0.0, contacts.energy() / before - 1.0), 0.0, kind=f"{kind}, {count} at once")
    return answers.comparison()


@check(
    section="4.3",
    piece=CONTACTS,
    reference="invariant",
    unit="of Σ m |v|",
    kind="invariant",
    least=1,
    tolerance=2e-14,
    because="thousands of steps of rounding over 324 particles",
    faults=(ONE_SIDED,),
)
def colliding_spheres_keep_momentum(run: Run) -> Comparison:
    """Two soft spheres that collide off-centre, without weight, keep their momentum."""
    rng, answers, notes = run.fresh_rng(), Answers(), []
    for _ in range(run.count(1, 3, 20)):
        world, ball, aside = weightless(), softbody.icosphere(2, 0.5), rng.uniform(-0.4, 0.4, 2)
        a = world.add_soft_body(ball, 1.0, 400.0, 60.0, (0.0, 0.0, 0.0), (2.0, 0.0, 0.0))
        b = world.add_soft_body(ball, 2.0, 400.0, 60.0, (1.2, *aside), (-2.0, 0.0, 0.0))
        before = accounts.momentum(world)
        _settle(world, 0.5)
        answers.add(accounts.momentum(world), before, 6.0)
        closing = (b.velocities.mean(axis=0) - a.velocities.mean(axis=0))[0]
        notes.append(f"closing speed −4 m/s before, {closing:.2f} m/s after")
        if closing < -3.9:
            raise RuntimeError("the spheres did not collide")
    return answers.comparison(notes=notes)


def _settle(world: World, seconds: float) -> World:
    world.run(seconds, STEP * world.stable_time_step())
    return world


def _spin(body: SoftBody) -> tuple[float, float]:
    """Return ω R / v of a body that rolls along x with its axis along y, and sliding of its touching particles / v."""
    x, v = body.positions - body.positions.mean(axis=0), body.velocities - body.velocities.mean(axis=0)
    speed = body.velocities[:, 0].mean()
    omega = np.cross(x, v)[:, 1].sum() / (x[:, 0] ** 2 + x[:, 2] ** 2).sum()
    touching = body.positions[:, 2] <= 0.0
    slide = np.linalg.norm(body.velocities[touching, :2], axis=1).mean() if touching.any() else np.nan
    return omega * 1.4 / speed, slide / speed


def _roll(friction: float, seconds: float) -> np.ndarray:
    """Return (n, 2): what _spin says every 20 ms of the second half of the rolling scene."""
    world = rolling_torus.build()
    world.store.replace(model=world.model._replace(ground_friction=friction))
    step = STEP * world.stable_time_step()
    world.run(0.5 * seconds, step)
    samples = []
    for _ in range(int(0.5 * seconds / 0.02)):
        world.run(0.02, step)
        samples.append(_spin(SoftBody(world, 0)))
    return np.array(samples)


@check(
    section="9",
    piece="softbody.scenes.rolling_torus",
    reference="closed form: a closed surface rolls like a belt, whose length counts and not its loaded height",
    unit="of 1, means over a tenth of the time",
    kind="closed form",
    tolerance=0.05,
    because="the shape breathes by some 10 % on the way; the gas stretches the belt by a few percent",
    faults=(NO_FRICTION,),
    erratum=Misprint("E21", "no friction anywhere", "Coulomb friction"),
)
def torus_rolls(run: Run) -> Comparison:
    """Scene 2's torus rolls on its unloaded outer radius: ωR = v.

    It is on end, and pushed by half its weight.
    """
    seconds = run.count(4, 8, 12)
    rolling, sliding = (
        [part.mean() for part in np.array_split(_roll(friction, float(seconds))[:, 0].copy(), 10)]
        for friction in (0.8, 0.0)
    )
    turns = 0.5 * 0.5 * 9.81 * seconds**2 / 2.0 / (2.0 * np.pi * 1.4)
    return Comparison(rolling, np.ones(10), printed=sliding, notes=[f"about {turns:.0f} turns in {seconds} s"])


@check(
    section="9",
    piece="softbody.dynamics.particle_ground.resolve_ground",
    reference="rolling without sliding",
    unit="of the speed",
    kind="closed form",
    least=1,
    tolerance=0.02,
    because="particles that just arrive still move; the mean over time is compared",
    faults=(NO_FRICTION,),
)
def rolling_torus_sticks(run: Run) -> Comparison:
    """Scene 2's rolling torus slides at under 2 % of its speed."""
    slides = _roll(0.8, float(run.count(4, 8, 12)))[:, 1].copy()
    return Comparison([np.nanmean(slides)], [0.0])


def _same_bits(worlds: list[World], **more: Any) -> Comparison:
    """Compare all bits of the state of two worlds."""
    first, second = (np.concatenate([array.ravel() for array in world.state]).view(np.uint64) for world in worlds)
    return Comparison(first == second, np.ones(len(first), bool), **more)


@check(
    section="9",
    piece="softbody.stepping.step.run",
    reference="the same scene, built and run again",
    kind="the core in another form",
    because="every sum and every contact has its order",
    faults=(
        Fault(
            "a scene that starts at the clock's mercy",
            boxes_on_torus.build,
            "(0.0, 0.0, 0.45) → (0.0, 0.0, 0.45 + __import__('time').time_ns() % 1000 * 1e-9)",
        ),
    ),
)
def same_bits_twice(run: Run) -> Comparison:
    """A scene that is run twice gives the same bits."""
    return _same_bits([_settle(boxes_on_torus.build(), 0.5) for _ in range(2)])


@check(
    section="4.3",
    piece="softbody.World.save, softbody.World.load",
    reference="the same world, not interrupted",
    kind="the core in another form",
    because="nothing that a step depends on comes from what was before, but for what is saved",
    faults=(
        Fault(
            "contacts listed in an order that comes from where bodies were when their trees were made",
            soft_soft._add_crossings,
            "sort_listed(search_, count_) → pass",
        ),
    ),
)
def loaded_world_goes_on_to_the_same_bits(run: Run) -> Comparison:
    """A world saved and loaded goes on to the same bits.

    Ten soft balls fall into a tray, are saved after 0.6 s, and go on for 0.4 s.
    """
    worlds = [tray.build(10)]
    step = 0.9 * worlds[0].stable_time_step()
    worlds[0].run(0.6, step)
    with tempfile.TemporaryDirectory() as folder:
        worlds[0].save(Path(folder) / "world.npz")
        worlds.append(World.load(Path(folder) / "world.npz"))
    for world in worlds:
        world.run(0.4, step)
    return _same_bits(worlds, notes=[f"{worlds[0].store.contacts.number[0]} contacts at the end"])
