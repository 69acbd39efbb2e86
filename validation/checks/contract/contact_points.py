"""Claims about what a World says of its contacts: who touches whom, and how hard."""

from __future__ import annotations

import warnings
from itertools import combinations

import numpy as np

from softbody import Box, ContactPoints, Mesh, SoftBody, World, icosphere
from softbody.bodies import contact_points
from softbody.bodies.adding import remove
from softbody.bodies.contact_points import _numbers
from softbody.collision.contact import box_side, soft_side, without_box
from softbody.collision.soft import soft_response
from softbody.collision.solver import batches
from softbody.dynamics import particle_ground
from softbody.scenes import box_pile, boxes_on_torus, sphere_on_torus, tray
from softbody.stepping import step
from validation.answers import Answers
from validation.cases import BOX_TRIANGLES, corners_of, random_orientations, rotation_matrix
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

STEP = 1.0 / 240.0  # [s] of what stands still
HELD = 0.3  # [m] side of a load on a beam

Solid = tuple[np.ndarray, np.ndarray]  # vertices (n, 3) [m] and triangles


@check(
    section="5.2",
    piece="softbody.World.contact_points, softbody.ContactPoints.of, softbody.ContactPoints.force_on",
    reference="pybullet (500 iterations), the impulses of its contacts; the lever says the same",
    engines=("pybullet",),
    unit="of the weight",
    tolerance=1e-4,
    because="a step's solution at 30 sweeps: 3.3e-5 at worst of ten seeds; Bullet is 4e-7 from the lever",
    faults=(
        Fault(
            "impulses in place of forces",
            ContactPoints.force_on,
            "impulse / self.time_step if self.time_step > 0.0 else impulse → impulse",
        ),
        Fault(
            "the force on the other one",
            ContactPoints.force_on,
            "self.impulse[self.a == n_].sum(axis=0) - self.impulse[self.b == n_].sum(axis=0)"
            " → self.impulse[self.b == n_].sum(axis=0) - self.impulse[self.a == n_].sum(axis=0)",
        ),
        Fault(
            "contacts with anybody",
            ContactPoints.of,
            "((self.a == one) & (self.b == two)) | ((self.a == two) & (self.b == one)) → rows",
        ),
        Fault("boxes numbered as if there were no soft bodies", _numbers, "model.soft_count + box → box"),
    ),
)
def loads_of_a_beam(run: Run) -> Comparison:
    """A loaded beam presses on its supports as hard as in Bullet.

    It lies on two edges; the load is anywhere on it, and presses as hard, too. After a second by default settings.
    """
    from references.pybullet_world import BulletWorld

    rng, answers = run.fresh_rng(), Answers()
    upright, leaning = (1.0, 0.0, 0.0, 0.0), (np.cos(np.pi / 8.0), 0.0, np.sin(np.pi / 8.0), 0.0)  # an edge up
    for _ in range(run.count(6, 20, 200)):
        side, span, thick = rng.uniform(0.3, 1.0), rng.uniform(0.8, 1.5), rng.uniform(0.1, 0.3)
        masses, along = 10.0 ** rng.uniform(-0.5, 1.0, 2), rng.uniform(-0.9, 0.9) * span
        top = side * np.sqrt(0.5)
        world, theirs = World(), BulletWorld(STEP, 500)
        # Far away, and there for its number only.
        world.add_soft_body(icosphere(1, 0.5), 1.0, 100.0, 10.0, (0.0, 50.0, 0.0), fixed=range(5))
        for size, mass, place, turn in (
            ((side, 0.4, side), None, (-span, 0.0, 0.0), leaning),
            ((side, 0.4, side), None, (span, 0.0, 0.0), leaning),
            ((2.0 * span + 0.6, 0.5, thick), masses[0], (0.0, 0.0, top + 0.5 * thick), upright),
            ((HELD,) * 3, masses[1], (along, 0.0, top + thick + 0.5 * HELD), upright),
        ):
            world.add_box(size, mass, place, turn)
            theirs.add_box(size, mass or 0.0, place, turn)
        left, right, beam, load = world.boxes
        steps = round(1.0 / STEP)
        world.step(STEP, steps)
        theirs.step(steps)
        points, loads = world.contact_points(), theirs.loads()
        theirs.close()
        told = [points.of(beam, one).force_on(beam)[2] for one in (left, right)]
        told += [points.force_on(load)[2], -points.force_on(left)[2]]
        answers.add(told, [loads[1, 3], loads[2, 3], loads[3, 4], loads[1, 3]], 9.81 * masses.sum())
    return answers.comparison()


@check(
    section="5.2, 5.3, 5.4",
    piece="softbody.World.contact_points",
    reference="momenta before and after, summed by NumPy from raw arrays",
    kind="invariant",
    unit="of a step's weight, the body's momenta and all impulses on it; of a hundredth of that but for the pile",
    tolerance=3e-12,
    because="rounding of impulses, of the sum of their sizes: 8e-15 at worst where they are solved for one by one."
    " Those of a pile are solved for at once, and on the way are up to 1e4 times as large as at the end: 1.2e-14 at"
    " worst of four seeds, 2.1e-12 at standard",
    faults=(
        Fault("two pairs of one box solved side by side", batches._schedule, "least_[a] = t_ + 1 → least_[a] = t_"),
        Fault(
            "a pair solved side by side with others of its second box",
            batches._schedule,
            "max(full_, least_[a], least_[b]) → max(full_, least_[a])",
        ),
        Fault(
            "the impulses of the pair in the next lane",
            batches.take_impulses,
            "batches_.place[k_] % LANES → (batches_.place[k_] + 1) % LANES",
        ),
        Fault(
            "what the ground gives without friction",
            particle_ground.resolve_ground,
            "scale(1.0 / model.particle_inverse_mass[i], change)"
            " → (0.0, 0.0, change[2] / model.particle_inverse_mass[i])",
        ),
        Fault(
            "what the ground gave in the step before",
            step.run_alone_by_clock,
            "resolve_ground(model, state, ground_impulse, None, True)"
            " → resolve_ground(model, state, ground_impulse.copy(), None, True)",
        ),
        Fault(
            "contacts that only pull left out",
            contact_points.contact_points,
            "(contacts.depth[found] > 0.0) | contacts.impulse[found].any(axis=1) → contacts.depth[found] > 0.0",
        ),
        Fault(
            "particles of the first body on the ground",
            contact_points.contact_points,
            'np.searchsorted(model.soft_particle_start, landed, side="right") - 1 → np.zeros(len(landed), np.int64)',
        ),
    ),
)
def forces_change_momenta(run: Run) -> Comparison:
    """Told forces of contacts, and weights, are the changes of momenta.

    They are so for each body in every step, in one part or as many as four. The sphere on the torus, boxes on a torus,
    balls in a tray, a pile, and one ball that bounces on the ground.
    """
    rng, answers = run.fresh_rng(), Answers()
    alone = World()
    alone.add_ground(friction=0.7)
    alone.add_soft_body(icosphere(1, 0.5), 1.3, 200.0, 20.0, (0.0, 0.0, 0.6), (1.0, 0.5, -2.0))
    worlds = {
        "one ball": alone,
        "sphere on torus": sphere_on_torus.build(2),
        "boxes on torus": boxes_on_torus.build(),
        "tray": tray.build(run.count(4, 8, 30)),
        "pile": box_pile.build(run.count(10, 20, 40)),
    }
    seconds = 0.5 * run.count(2, 3, 8)
    for kind, world in worlds.items():
        # Only a pile's impulses are solved for at once, and are larger on the way than at the end.
        scale = 1.0 if kind == "pile" else 0.01
        world.substeps = int(rng.integers(1, 5))
        h = min(STEP, 0.8 * world.stable_time_step())
        while world.time < seconds:
            world.step(h, int(rng.integers(1, 20)))
            _add_a_step(world, h, scale, kind, answers)
    return answers.comparison()


def _add_a_step(world: World, h: float, scale: float, kind: str, answers: Answers) -> None:
    """Step a world, and add how its contacts and weights have changed each body's momentum, as told and as it is."""
    before = _momenta(world)
    world.step(h)
    points, after = world.contact_points(), _momenta(world)
    bodies: list[SoftBody | Box] = [*world.soft_bodies, *world.boxes]
    for row, body in enumerate(bodies):
        if body.mass is None:
            continue
        weight = body.mass * world.gravity
        pushes = np.linalg.norm(points.of(body).impulse, axis=1).sum()
        size = h * np.linalg.norm(weight) + np.linalg.norm(before[row]) + np.linalg.norm(after[row]) + pushes
        told = (points.force_on(body) + weight) * h / size
        answers.add(told, (after[row] - before[row]) / size, scale, kind)


@check(
    section="4.2, 5.4",
    piece="softbody.World.contact_points, softbody.collision.soft.soft_response.press_on_ground",
    reference="momenta before and after, summed by NumPy from raw arrays",
    kind="invariant",
    unit="of a step's weight, the body's momenta and all impulses on it",
    tolerance=1e-14,
    because="rounding of impulses, of the sum of their sizes: 5.1e-16 at worst of ten seeds",
    faults=(
        Fault(
            "a ground that does not tell what is pressed on to it",
            soft_response.press_on_ground,
            "accumulate(impulse_, i_, (0.0, 0.0, pressed_)) → ",
        ),
        Fault(
            "a ground that does not tell how it rubs what is pressed on to it",
            soft_response.press_on_ground,
            "accumulate(impulse_, i_, scale(1.0 / inverse_mass_, change_)) → ",
        ),
    ),
)
def ground_bears_pressed_tips(run: Run) -> Comparison:
    """Told forces bear what presses a soft tip on the ground.

    A box falls on a tip of a soft tetrahedron that lies on the ground, and slides over it with the box. Told forces of
    contacts, and weights, are the changes of momenta in every step.
    """
    rng, answers = run.fresh_rng(), Answers()
    corners = np.array([[0.0, 0.0, 0.0], [0.6, 0.35, 0.0], [0.6, -0.35, 0.0], [0.5, 0.0, 0.5]])
    mesh = Mesh(corners, np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))
    for _ in range(run.count(3, 12, 100)):
        world, rub = World(), rng.uniform(0.1, 0.6, 2)
        world.add_ground(friction=rub[0])
        motion = rng.uniform(1.0, 2.0), rng.uniform(-1.0, 1.0), 0.0
        world.add_soft_body(mesh, rng.uniform(0.5, 2.0), 2000.0, 1.0, (0.0, 0.0, 0.0), motion, friction=rub[1])
        world.add_box((0.2, 0.2, 0.2), 10.0 ** rng.uniform(-0.5, 1.0), (-0.05, 0.0, 0.105), velocity=motion)
        h = min(STEP, 0.5 * world.stable_time_step())
        for _ in range(40):
            _add_a_step(world, h, 1.0, "tip", answers)
    return answers.comparison()


def _momenta(world: World) -> np.ndarray:
    """Return the momentum (bodies, 3) [kg m/s] of each soft body, and of each box that can move."""
    model, state = world.model, world.state
    rows = [slice(*model.soft_particle_start[k : k + 2]) for k in range(model.soft_count)]
    soft = [(state.particle_velocity[part] / model.particle_inverse_mass[part, None]).sum(axis=0) for part in rows]
    masses = [1.0 / inverse if inverse > 0.0 else 0.0 for inverse in model.box_inverse_mass]
    return np.array([*soft, *(m * v for m, v in zip(masses, state.box_velocity))])


@check(
    section="4.2, 4.3, 4.4",
    piece="softbody.ContactPoints.pairs, softbody.ContactPoints.of",
    reference="FCL on convex meshes; pairs of which it says another thing where both are 3 % larger are left out",
    engines=("fcl",),
    faults=(
        Fault(
            "the ground first",
            ContactPoints.pairs,
            "np.where(self.b == GROUND, self.a, np.minimum(self.a, self.b)) → np.minimum(self.a, self.b)",
        ),
        Fault(
            "pairs as they were found",
            ContactPoints.pairs,
            "np.where(self.b == GROUND, self.b, np.maximum(self.a, self.b)) → self.b",
        ),
        Fault(
            "contacts in which the body is a",
            ContactPoints._has,
            "(self.a == number) | (self.b == number) → self.a == number",
        ),
        Fault("boxes that count from 0", ContactPoints._number, 'self.first_box if body.kind == "box" else 0 → 0'),
    ),
)
def who_touches_whom(run: Run) -> Comparison:
    """Those bodies touch that FCL finds inside each other.

    Boxes, soft bodies and the ground, anyhow: by `pairs`, and by whether `of` has any for the two.
    """
    rng, answers = run.fresh_rng(), Answers()
    ball = icosphere(2, 0.5)
    for _ in range(run.count(3, 12, 100)):
        world = World((0.0, 0.0, 0.0))
        world.add_ground()
        places = iter(rng.uniform((0.0, 0.0, 0.2), (3.0, 2.0, 1.6), (9, 3)))
        for _ in range(4):
            world.add_soft_body(ball, 1.0, 100.0, 10.0, next(places), (0.0, 0.0, -0.01))
        for place, turn in zip(places, random_orientations(rng, 5)):
            world.add_box(rng.uniform(0.3, 1.0, 3), 1.0, place, turn)
        bodies: list[SoftBody | Box] = [*world.soft_bodies, *world.boxes]
        hulls = [_hull(body) for body in bodies]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # they are deep inside each other
            world.step(1e-4)
        points = world.contact_points()
        pairs = points.pairs()
        for i, j in combinations(range(9), 2):
            meet = _meets(hulls[i], hulls[j])
            # (Boxes that start deep inside each other are pushed apart before soft bodies are asked what they touch.)
            if meet is not None and meet == _meets(_hull(bodies[i]), _hull(bodies[j])):
                kind = f"{bodies[i].kind} and {bodies[j].kind}{'' if meet else ', apart'}"
                answers.add((i, j) in pairs, meet, kind=kind)
                answers.add(len(points.of(bodies[j], bodies[i])) > 0, meet, kind=kind)
        for i, (vertices, _) in enumerate(hulls):
            if abs(low := float(vertices[:, 2].min())) > 1e-3:
                kind = f"{bodies[i].kind} and the ground{'' if low < 0.0 else ', apart'}"
                answers.add((i, -1) in pairs, low < 0.0, kind=kind)
    return answers.comparison()


def _hull(body: SoftBody | Box) -> Solid:
    """Return a body as it is now."""
    if isinstance(body, SoftBody):
        return body.positions.copy(), body.triangles
    return corners_of(body.size) @ rotation_matrix(body.orientation).T + body.position, BOX_TRIANGLES


def _meets(one: Solid, other: Solid) -> bool | None:
    """Tell whether two convex meshes overlap, by FCL; None if it depends on 3 % of their size."""
    from references import fcl

    said = []
    for factor in (0.97, 1.03):
        grown = [(v.mean(axis=0) + factor * (v - v.mean(axis=0)), t) for v, t in (one, other)]
        said.append(fcl.convex_overlap(*grown[0], *grown[1]))
    return said[0] if said[0] == said[1] else None


@check(
    section="5.2",
    piece="softbody.World.remove",
    reference="pybullet, with the same boxes, one of each pile removed after it has come to rest",
    engines=("pybullet",),
    unit="m",
    tolerance=3e-5,
    because="Bullet's piles have not quite stopped sinking: 1.1e-5 at worst of thirteen runs",
    faults=(
        Fault("the next box removed", remove, "without(p_, k_, row) → without(p_, k_, row - 1)"),
        Fault(
            "handles that stay at their numbers",
            remove,
            "number - 1 if number > row else GONE → number if number > row else GONE",
        ),
    ),
)
def what_stood_on_it_falls(run: Run) -> Comparison:
    """What stood on a removed box falls as in Bullet, others stay."""
    from references.pybullet_world import BulletWorld

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(6, 20, 100)):
        world, theirs = World(), BulletWorld(STEP, 100)
        world.add_ground()
        theirs.add_ground()
        piles: list[list[Box]] = []
        for k in range(3):
            top, boxes = 0.0, []
            for _ in range(3):
                size = rng.uniform(0.3, 0.8, 3)
                place, mass = (3.0 * k, 0.0, top + 0.5 * size[2]), rng.uniform(1.0, 3.0)
                boxes.append(world.add_box(size, mass, place))
                theirs.add_box(size, mass, place)
                top += size[2]
            piles.append(boxes)
        world.step(STEP, 60)
        theirs.step(60)
        # One pile stays, one loses its middle, one its foot.
        for pile, which in zip(rng.permutation(3), (None, 1, 0)):
            if which is not None:
                gone = piles[pile].pop(which)
                theirs.remove(gone.index)
                world.remove(gone)
        left = [box for pile in piles for box in pile]
        before = _places(left), theirs.positions()
        world.step(STEP, 20)
        theirs.step(20)
        answers.extend(_places(left) - before[0], theirs.positions() - before[1])
        theirs.close()
    return answers.comparison()


def _places(boxes: list[Box]) -> np.ndarray:
    """Return the centres (m, 3) [m] of boxes, by their handles; zeros of one that says it is gone."""
    return np.array([box.position.copy() if box.is_there else np.zeros(3) for box in boxes])


@check(
    section="9",
    piece="softbody.World.remove, softbody.collision.contact.without_box",
    reference="the same piles alone",
    kind="the core in another form",
    unit="m, m/s",
    tolerance=0.0,
    because="boxes that touch nothing change nothing",
    faults=(
        Fault(
            "impulses of the boxes after the one that is removed forgotten",
            without_box,
            "left.box - (left.box > box) → left.box",
        ),
        Fault("all that is remembered forgotten", without_box, "(cache.box != box).all(axis=1) → cache.box[:, 0] < -1"),
    ),
)
def piles_go_on_without_others(run: Run) -> Comparison:
    """Piles go on to the same bits as without boxes beside them.

    Those are removed, of any number, at any time; what the solver remembers stays that of the same boxes.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(6, 20, 200)):
        # Too few sweeps to do without what is remembered.
        crowded, *_ = worlds = World(iterations=4), World(iterations=4)
        beside: list[Box] = []
        for world in worlds:
            world.add_ground()
        for k in range(3):
            top = 0.0
            for _ in range(3):
                if rng.random() < 0.7:
                    mass = None if rng.random() < 0.5 else 1.0
                    beside.append(crowded.add_box((0.3, 0.3, 0.3), mass, (2.0 * len(beside), 50.0, 500.0)))
                size, mass = rng.uniform(0.3, 0.8, 3), rng.uniform(0.5, 3.0)
                place = (*rng.uniform(-0.1, 0.1, 2) + (3.0 * k, 0.0), top + 0.5 * size[2])
                for world in worlds:
                    world.add_box(size, mass, place)
                top += size[2]
        for box in [beside[k] for k in rng.permutation(len(beside))]:
            steps = int(rng.integers(5, 30))
            for world in worlds:
                world.step(STEP, steps)
            crowded.remove(box)
        for world in worlds:
            world.step(STEP, 5)
        states = [world.state for world in worlds]
        answers.extend(*(np.hstack([x.box_position, x.box_velocity, x.box_angular_velocity]) for x in states))
    return answers.comparison()


@check(
    section="4",
    piece="softbody.collision.contact.box_side",
    reference="the bodies' numbers, as they were added",
    kind="specification",
    faults=(
        Fault("a particle of a box", box_side, "(NOBODY, NOBODY, NOBODY) → (NOBODY, NOBODY, NOBODY + 1)"),
        Fault("another of it", box_side, "(NOBODY, NOBODY, NOBODY) → (NOBODY + 1, NOBODY, NOBODY)"),
        Fault("a box of a soft body", soft_side, "Side(NOBODY, point) → Side(NOBODY + 1, point)"),
    ),
)
def sides_of_contacts(run: Run) -> Comparison:
    """A side of a contact is a box, particles or the ground.

    What it is not is told by -1, in all places: boxes on boxes and on the ground, soft bodies on boxes and each other.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(6, 20, 200)):
        world = World()
        world.add_ground()
        sizes = rng.uniform(0.4, 0.6, (3, 3))
        heights = np.cumsum(sizes[:, 2]) - 1e-3
        for size, height in zip(sizes, heights):
            world.add_box(size, 1.0, (0.0, 0.0, height - 0.5 * size[2]))
        for k in range(2):
            world.add_soft_body(icosphere(1, 0.3), 0.1, 30.0, 3.0, (0.0, 0.0, heights[2] + 0.27 + 0.55 * k))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            world.step(1e-3, 3)
        contacts, count = world.store.contacts, len(world.state.particle_position)
        for row, side in np.ndindex(contacts.number[0], 2):
            box, particles = contacts.box[row, side], contacts.particles[row, side]
            is_soft = box == -1 and (particles >= 0).all() and (particles < count).all()
            is_other = -1 <= box < 3 and (particles == -1).all() and (box >= 0 or side == 1)
            kind = "a box" if box >= 0 else "a soft body" if particles[0] >= 0 else "the ground"
            answers.add(is_soft or is_other, True, kind=kind)
    return answers.comparison()
