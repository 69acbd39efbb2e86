"""Single precision, whose error is its own claim, and threads, which must change nothing."""

from __future__ import annotations

from contextlib import suppress
from itertools import pairwise
from typing import Any

import numpy as np

from softbody import World, icosphere
from softbody.collision.boxes.manifold import new_manifold
from softbody.collision.contact import new_contacts
from softbody.collision.pressed import never_pressed
from softbody.collision.soft import soft_contacts, soft_response
from softbody.collision.soft.surface import build_surfaces
from softbody.compiler.threads import Team
from softbody.dynamics import integrators, soft_bodies, vertex_rings
from softbody.dynamics.soft_bodies import motion_of
from softbody.mesh import mesh
from softbody.stepping.runner import Runner
from softbody.stepping.step import Order, Work, run_alone
from softbody.stepping.step import run as run_together
from softbody.stepping.tears import tearing_of
from validation.answers import Answers
from validation.cases import edge_lengths, lumpy_sphere
from validation.check import Comparison, Run, check
from validation.checks.soft.integrators import breathe
from validation.checks.soft.soft import forces
from validation.checks.worlds.cases import WEIGHTLESS, same_bits
from validation.fault import Fault

FAMILY = "precision and threads"

HALF_PRECISION = Fault(
    "springs rounded to half precision on the way",
    vertex_rings.in_precision,
    "rings_.rest_tension.astype(real_, copy=False) → rings_.rest_tension.astype(np.float16).astype(real_)",
)


@check(
    section="2, 5.1",
    piece="softbody.dynamics.one_ring_forces",
    reference="gradient of ½ Σ k (l − l0)² − nRT ln V, by SciPy's side in double precision",
    engines=("scipy",),
    unit="of stiffness × size",
    tolerance=5e-7,
    because="positions are rounded to 6e-8 of the size, and a particle has up to 12 springs",
    faults=(HALF_PRECISION,),
)
def single_force(run: Run) -> Comparison:
    """Single-precision forces are off by some ten roundings.

    Those are of the places of each particle's neighbours.
    """
    measured, expected, kinds, worlds = forces(run, "single")
    units = [world.model.edge_stiffness.max() * np.abs(world.state.particle_position).max() for world in worlds]
    scales = [np.full(len(judged), unit) for judged, unit in zip(expected, units)]
    return Comparison(np.concatenate(measured), np.concatenate(expected), np.concatenate(scales), kinds)


@check(
    section="2, 5.1",
    piece="softbody.dynamics.integrators.rk4_stage",
    reference="SciPy DOP853 at 1e-13",
    engines=("scipy",),
    unit="of the scale",
    tolerance=5e-6,
    because="some 2 000 steps, each rounded at 6e-8, as a random walk that the motion amplifies",
    faults=(HALF_PRECISION,),
)
def single_motion(run: Run) -> Comparison:
    """A regular solid breathes right in single precision.

    It is filled with gas, and breathes as its scalar equation of motion says.
    """
    return breathe(run, "single", 5e-3)


@check(
    section="5.1",
    piece="softbody.dynamics.soft_bodies.move_on_threads",
    reference="the same run on one thread",
    kind="the core in another form",
    because="shares write to places of their own, and sums go block by block in one order",
    faults=(
        Fault(
            "a thread that moves the bodies of another",
            soft_bodies.move_on_threads,
            "first_ * threads_ // last_ == thread_ → first_ * threads_ // last_ == thread_ + 1",
        ),
        Fault(
            "shares that reach into the next one",
            integrators._advance_body,
            "rings.block[cut[share + 1] - 1, END] → rings.block[cut[-1] - 1, END]",
        ),
    ),
)
def threads_leave_every_bit(run: Run) -> Comparison:
    """Any number of threads moves soft bodies to the same bits.

    There are many small bodies, two large ones among them, moved by the default scheme and by rk4, whose stages add up.
    """
    answers = Answers()
    # Each precision is compiled for threads anew.
    cases = (("double", "rk4"), ("double", "symplectic_euler"), ("single", "rk4"))[: run.count(2, 2, 3)]
    for precision, scheme in cases:
        states = []
        for threads in (1, 2, 3):  # shares of the work, whatever the machine has to do them on
            rng = run.fresh_rng()
            world = World(gravity=WEIGHTLESS, precision=precision, integrator=scheme)
            for k in range(9):
                mesh = lumpy_sphere(rng, 5 if k in (4, 5) else 2)
                world.add_soft_body(mesh, 1.0, 100.0, 20.0, (4.0 * k, 0.0, 0.0), damping=1e-4)
            _run_alone(world, threads, 0.5 * world.stable_time_step(), run.count(20, 50, 500))
            states.append(np.concatenate([world.state.particle_position, world.state.particle_velocity]))
        for other in states[1:]:
            answers.extend(same_bits(states[0], other), np.ones(len(other), bool), kind=f"{precision}, {scheme}")
    return answers.comparison()


def _run_alone(world: World, threads: int, step: float, steps: int) -> None:
    """Step soft bodies that meet nothing on so many threads."""
    motion = motion_of(world.model.soft_particle_start, world.store.rings, threads)
    run_alone(world.model, world.controls, world.state, motion, world.store.settings, step, steps)


@check(
    section="5.1",
    piece="softbody.dynamics.soft_bodies.move_on_threads",
    reference="SciPy's DOP853 on springs and gas by its own formula",
    engines=("scipy",),
    unit="of the size",
    tolerance=1e-11,
    because="rk4 at a fiftieth of the stable step: 6e-13",
    faults=(
        Fault(
            "the last thread's bodies left where they are",
            soft_bodies.move_on_threads,
            "first_ * threads_ // last_ == thread_ → first_ * threads_ // last_ == thread_ and thread_ < threads_ - 1",
        ),
    ),
)
def threads_by_scipy(run: Run) -> Comparison:
    """Soft bodies moved by two and three threads swell as SciPy's.

    Many are small, and one is larger.
    """
    from references import scipy

    answers = Answers()
    for threads in (2, 3):
        rng = run.fresh_rng()
        world = World(gravity=WEIGHTLESS, integrator="rk4")
        for k in range(10):  # fewer particles are not shared out among threads
            mesh = lumpy_sphere(rng, 3 if k == 3 else 2)
            world.add_soft_body(mesh, 1.0, 100.0, 20.0, (4.0 * k, 0.0, 0.0), damping=0.0)
        starts = [body.positions.copy() for body in world.soft_bodies]
        step, steps = 0.02 * world.stable_time_step(), run.count(100, 300, 2_000)
        _run_alone(world, threads, step, steps)
        for body, start in zip(world.soft_bodies, starts):
            springs = body.edges, edge_lengths(start, body.edges), np.full(len(body.edges), 100.0)
            what = *springs, body.triangles, 20.0, 1.0 / len(start), steps * step
            judged, _ = scipy.motion(start, np.zeros_like(start), *what, rtol=1e-12)
            answers.extend(body.positions.copy(), judged, kind=f"{threads} threads")
    return answers.comparison()


def crowd(rng: np.random.Generator) -> World:
    """Return soft bodies of many sizes that press each other and boxes from the start."""
    world = World()
    world.add_ground()
    for k in range(11):
        mesh = lumpy_sphere(rng, (1, 2, 3, 4)[k % 4])
        place = 1.7 * (k % 3) + 0.1 * rng.random(), 1.7 * (k // 3 % 2) + 0.1 * rng.random(), 1.5 + 1.7 * (k // 6)
        world.add_soft_body(mesh, 1.0 + k, 150.0, 40.0, place, friction=0.1 * k)
        if k % 4 == 0:
            world.add_box((2.0, 2.0, 0.5 + 0.1 * k), 1.0 + k, (1.7 * (k % 3), 1.7 * (k // 3 % 2), 0.3))
    return world


@check(
    section="4.2, 4.3",
    piece="softbody.collision.soft.soft_contacts.find_on_threads",
    reference="the same run on one thread",
    kind="the core in another form",
    because="each thread lists what it finds apart, and lists are joined in the order of the bodies",
    faults=(
        Fault(
            "the last body of each thread's share left out",
            soft_contacts.find_share,
            "range(cut_[share_], cut_[share_ + 1]) → range(cut_[share_], cut_[share_ + 1] - 1)",
        ),
        Fault(
            "a contact lost where the list of a second thread is joined",
            soft_contacts.find_soft_contacts,
            "range(kept + share * room, end_) → range(kept + share * room + min(share, found[share]), end_)",
        ),
        Fault(
            "a thread that leaves out the last of its islands",
            soft_response._solve_on_threads,
            "range(number_) → range(number_ - 1)",
        ),
    ),
)
def threads_find_the_same_contacts(run: Run) -> Comparison:
    """One, two and three threads find contacts to the same bits.

    Eleven soft bodies of 42 to 2 562 particles and three boxes press each other, over ten steps or more.
    """
    ends, contacts = [], []
    for threads in (1, 2, 3):
        world = crowd(run.fresh_rng())
        model, state = world.model, world.state
        motion = motion_of(model.soft_particle_start, world.store.rings, threads)
        surfaces = build_surfaces(model, state.particle_position, threads)
        grounded, given = np.zeros(model.box_count, bool), np.zeros_like(state.particle_position)
        bell = np.zeros(1, np.uint8)
        work = Work(
            motion,
            surfaces,
            None,
            new_manifold(),
            state.copy(),
            grounded,
            given,
            None,
            None,
            None,
            bell,
            never_pressed(),
            tearing_of(model, world.store.rings),
        )
        step, steps = 0.5 * world.stable_time_step(), run.count(10, 20, 100)
        found, settings, clock = new_contacts(10_000), world.store.settings, world.store.clock
        order = Order(step, steps, 0, 0.0, True, False)
        run_together(model, world.controls, state, work, found, settings, clock, order)
        contacts.append(int(found.number[0]))
        ends.append(np.concatenate([state.particle_position, state.particle_velocity, state.box_velocity]))
    agree = np.concatenate([same_bits(ends[0], other) for other in ends[1:]])
    return Comparison(agree, np.ones(len(agree), bool), notes=[f"{contacts[0]} contacts at the end"])


@check(
    section="4.2, 4.3",
    piece="softbody.collision.soft.soft_contacts",
    reference="all pairs, in NumPy; sums of particles",
    kind="exhaustive search",
    because="bodies that are near by rounding, or by the sphere that is chosen, are not tried",
    faults=(
        Fault("one row too many", soft_contacts.near_bodies, "b_ < soft_ → b <= soft", nth=1),
        Fault(
            "boxes that have as many particles as soft bodies",
            soft_contacts.even_shares,
            "other_ < soft_ → not other < soft",
        ),
        Fault("bounds that are not asked", soft_contacts.near_bodies, "boxes_meet(a_, b_) → True"),
        Fault(
            "faces that are not asked", soft_contacts.near_bodies, "_sphere_may_meet_box(model_, state_, x_, b_) → True"
        ),
        Fault(
            "spheres of half the radius",
            soft_contacts.near_bodies,
            "radius_about(middle, points) → 0.5 * radius_about(middle, points)",
        ),
    ),
)
def near_bodies_and_shares(run: Run) -> Comparison:
    """Near bodies, and shares of threads, are as the rule has them.

    Bounding boxes and spheres say which soft bodies and boxes are near which. So it is, too, where Python runs the
    kernel and minds the ends of arrays. Each thread gets its share of the work, but for one body: by the particles that
    are asked and asked about.
    """
    rng, answers, left = run.fresh_rng(), Answers(), run.count(12, 60, 600)
    while left:
        world, threads = World(), int(rng.integers(2, 5))
        soft, boxes = int(rng.integers(2, 6)), int(rng.integers(1, 4))
        places, sizes = rng.uniform(-1.5, 1.5, (soft + boxes, 3)), rng.uniform(0.3, 0.8, soft + boxes)
        for i in range(soft):
            flat = mesh.box(2.0 * sizes[i] * rng.uniform(0.1, 1.0, 3))  # whose sphere is far larger than it
            one = (icosphere(int(rng.integers(0, 2)), sizes[i]), flat)[rng.integers(2)]
            world.add_soft_body(one, 1.0, 100.0, 0.0, places[i])
        for i in range(soft, soft + boxes):
            world.add_box(2.0 * sizes[i] * rng.uniform(0.5, 1.0, 3), 1.0, places[i])
        near = _near(world)
        if near is None:
            continue
        left -= 1
        model, state = world.model, world.state
        surfaces = build_surfaces(model, state.particle_position, threads)
        asked = model, state, surfaces.shapes, surfaces.scratch, None, False
        start, other = soft_contacts.near_bodies(*asked)
        for form, (first, found) in (("compiled", (start, other)), ("by Python", _by_python(*asked))):
            lists = [sorted(found[first[i] : first[i + 1]].tolist()) for i in range(soft)]
            answers.extend([one == judged for one, judged in zip(lists, near)], [True] * soft, kind=form)
        numbers = [*np.diff(model.soft_particle_start), *[8] * boxes]  # of a box its corners
        work = [(numbers[i] if near[i] else 0) + sum(numbers[k] for k in near[i]) for i in range(soft)]
        cut, total = soft_contacts.even_shares(model, start, other, threads)
        shares = [sum(work[a:b]) for a, b in pairwise(cut)]
        fair = max(shares) < sum(work) / threads + max(work, default=0) + 1e-9
        answers.add(bool(np.isclose(total, sum(work), rtol=1e-12)), True, kind="work")
        answers.add(bool(cut[0] == 0 and cut[-1] == soft and fair), True, kind="shares")
    return answers.comparison()


def _near(world: World) -> list[list[int]] | None:
    """Return which soft bodies, and boxes, numbered after them, are near each soft body; None where that is unclear."""
    soft = [body.positions for body in world.soft_bodies]
    near: list[list[int]] = [[] for _ in soft]
    radius = [np.linalg.norm(rows - rows.mean(axis=0), axis=1).max() for rows in soft]
    for i, rows in enumerate(soft):
        low, high = rows.min(axis=0), rows.max(axis=0)
        for k, others in enumerate(soft[:i]):
            apart = np.linalg.norm(rows.mean(axis=0) - others.mean(axis=0)) / (radius[i] + radius[k])
            if ((low <= others.max(axis=0)) & (others.min(axis=0) <= high)).all():
                if apart > 0.95:
                    return None  # spheres decide, and those of the core need not be the least
                near[i].append(k)
                near[k].append(i)
        for k, box in enumerate(world.boxes):
            middle = rows.mean(axis=0) - box.position
            gap = (np.abs(middle) - 0.5 * box.size).max() / radius[i]
            apart = np.linalg.norm(middle) / (radius[i] + 0.5 * np.linalg.norm(box.size))
            if 0.7 < gap < 1.5 or (gap <= 0.7 and apart > 0.95):
                return None
            if gap <= 0.7:
                near[i].append(len(soft) + k)
    return [sorted(each) for each in near]


def _by_python(*asked: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return what Python finds where the core has a kernel; nothing if it leaves an array."""
    kernel = soft_contacts.near_bodies
    try:
        found: tuple[np.ndarray, np.ndarray] = getattr(kernel, "py_func", kernel)(*asked)
    except IndexError:
        return np.zeros(100, np.int64), np.zeros(0, np.int64)
    return found


class _TooManyTurnsError(Exception):
    """What ends a run that comes to no end."""


class _Team(Team):
    """Threads that take turns by a clock of the judge's, and are sent away when they have had far too many."""

    def __init__(self, rng: np.random.Generator, most_turns: int) -> None:
        super().__init__(2, self._later)
        self.had: set[int] = set()  # how many threads have had turns
        self._rng, self._time, self._turns_left = rng, 0.0, most_turns

    def turn(self, steps: int) -> int:
        """Begin a turn."""
        self._turns_left -= 1
        if self._turns_left < 0:
            raise _TooManyTurnsError
        self.had.add(self.now)
        return super().turn(steps)

    def _later(self) -> float:
        self._time += self._rng.uniform(0.0, 0.05)
        return self._time


@check(
    section="5.1",
    piece="softbody.World.step",
    reference="closed form: z = −g h² n (n + 1)/2 over n semi-implicit steps",
    kind="closed form",
    unit="steps; of the way and the speed, each at least 1",
    tolerance=4e-13,
    because="rounding of times over some hundred steps: 3.3e-14 at worst of seven seeds",
    faults=(
        Fault("turns twice as long", Runner.advance, "team.turn(left) → 2 * team.turn(left)"),
        Fault("turns as long as the clock says", Team.turn, "min(steps, s_) → s_"),
        Fault("a call that ends with its first turn", Runner.advance, "team.note(n_) → return 0, -1"),
    ),
)
def turns_of_threads(run: Run) -> Comparison:
    """Turns of two threads and one add up to all steps.

    A world that may use two threads takes as many steps as it is asked for. Turns go by a clock, and are of however
    many steps; boxes fly as long and as far as they must.
    """
    rng, measured, expected = run.fresh_rng(), [], []
    for _ in range(run.count(4, 20, 200)):
        flown, h, done = World(threads=2), rng.uniform(1e-4, 1e-2), 0
        start, speed = 10.0 * rng.normal(size=3), rng.normal(size=3)
        box = flown.add_box((0.2, 0.3, 0.4), 1.0, start, velocity=speed)
        flown.runner.memory.team = team = _Team(rng, 1_000)
        for steps in (1, int(rng.integers(2, 17)), int(rng.integers(100, 400))):
            with suppress(_TooManyTurnsError):
                flown.step(h, steps)
            done += steps
            measured.append([flown.steps, flown.time / h, *box.position, *box.velocity])
            expected.append([done, done, *(start + speed * done * h), *speed])
            expected[-1][4] -= 9.81 * h * (0.5 * h * done * (done + 1))
            expected[-1][7] -= 9.81 * h * done
        measured.append([len(team.had), *[0.0] * 7])
        expected.append([2, *[0.0] * 7])
    scale = 1.0 + np.abs(expected)
    return Comparison(np.array(measured) / scale, np.array(expected) / scale)
