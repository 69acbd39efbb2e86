"""Impacts of two boxes by kind of contact: where they touch, and the velocities after."""

from __future__ import annotations

from typing import Any

import numpy as np

from softbody import World
from softbody.collision import edge_edge
from softbody.collision.boxes import manifold, sat_boxes
from softbody.collision.contact import new_contacts
from softbody.collision.impulse import resolve_contact
from softbody.collision.solver import sequential_impulses
from softbody.collision.solver.sequential_impulses import solve_velocities
from softbody.collision.solver.solver_row import prepare_contacts
from softbody.geometry.box import box_inertia
from softbody.model import material
from softbody.model.arrays import RigidBodies
from softbody.model.material import Material
from validation.answers import Answers
from validation.arbitration import US, arbitrate
from validation.cases import (
    BoxPairs,
    box_separations,
    gap_along,
    random_box_pairs,
    random_orientations,
    rotation_matrix,
)
from validation.check import Comparison, Run, check
from validation.checks.boxes.cases import about, turned
from validation.checks.boxes.impulse import (
    OVERLAP,
    RESTITUTION,
    Impacts,
    bullet_velocities,
    contact_points,
    core_velocities,
    motion_of,
    random_impacts,
    speeds,
)
from validation.fault import Fault

FAMILY = "contact manifolds"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

RESTITUTION_OF_MANY = Fault(
    "restitution of many contacts off by 1e-8",
    material.speed_after,
    "restitution_ * approach_ → 1.00000001 * restitution_ * approach_",
)
SOLVER = "softbody.collision.solver.sequential_impulses.solve_velocities"
BOX_ON_BOX = "softbody.collision.boxes.manifold.box_box_manifold"
FAMILIES = ("vertex on face", "edge on edge", "edge on face", "face on face")
MASSES = ("equal masses", "1000:1", "1:1000", "on a static box")
SWEEPS = 20_000  # enough for 1e-11 of the speed at eight contacts and masses of 1000:1
MANY_SWEEPS = 2_000_000  # for the few impacts, 1 in 10 000, where contacts a hundredth of the size apart share the push
EXACT, BULLETS = 1e-11, 5e-12  # of the speed: how far sweeps may end from the exact solution, and from Bullet
STOPS = "Bullet stops a contact that closes by the bounce of another"
SAME_POINT = 1e-8  # [m] a contact of another feature is much farther off
SAME_NORMAL = 1e-4  # two axes of one pair are seldom nearer to each other
INSTANT = 1e-13  # [s]: as long as Bullet's one step, in which nothing moves


def family_pairs(rng: np.random.Generator, family: str, count: int) -> BoxPairs:
    """Return boxes that overlap by OVERLAP, a on b, with a vertex, edge or face of a on a face of b, or edges crossed.

    Built with b upright, then both turned at random. An edge or a face may hang over.
    """
    size_a, size_b = rng.uniform(0.4, 2.0, (2, count, 3))
    q_a, q_b = np.empty((count, 4)), random_orientations(rng, count)
    x_a, x_b = np.zeros((count, 3)), rng.uniform(-1.0, 1.0, (count, 3))
    for i in range(count):
        spin = about(2, rng.uniform(0.0, 2.0 * np.pi))
        if family == "face on face":
            local = spin
        elif family == "edge on face":
            local = turned(spin, about(1, rng.uniform(0.2, 1.3)))
        else:
            local = turned(spin, turned(about(1, rng.uniform(0.3, 1.2)), about(0, rng.uniform(0.3, 1.2))))
        corners = (np.indices((2, 2, 2)).reshape(3, 8).T - 0.5) * size_a[i] @ rotation_matrix(local).T
        low = -corners[:, 2].min()
        touching = corners[np.isclose(corners[:, 2], -low, atol=1e-12)].mean(axis=0)
        place = rng.uniform(-0.4, 0.4, 2) * size_b[i, :2] - touching[:2]
        centre = np.array([*place, 0.5 * size_b[i, 2] + low - OVERLAP])
        q_a[i] = turned(q_b[i], local)
        x_a[i] = x_b[i] + rotation_matrix(q_b[i]) @ centre
    q_a /= np.linalg.norm(q_a, axis=1, keepdims=True)
    return BoxPairs(size_a, x_a, q_a, size_b, x_b, q_b)


def crossed_edges(rng: np.random.Generator, count: int) -> BoxPairs:
    """Return boxes that overlap by OVERLAP where an edge of one crosses an edge of the other."""
    pairs = random_box_pairs(rng, 6 * count)
    for i, (separation, normal, _) in enumerate(box_separations(pairs)):
        pairs.position_b[i] += (separation + OVERLAP) * normal
    # Some now miss each other along another axis, or touch at a corner.
    after = box_separations(pairs)
    rows = [i for i, (separation, _, axis) in enumerate(after) if axis >= 6 and separation < -0.9 * OVERLAP]
    assert len(rows) >= count, "draw more pairs"
    return pairs.select(np.array(rows[:count]))


def family_impacts(rng: np.random.Generator, count: int) -> Impacts:
    """Return `count` impacts of each family, spinning, of equal masses, 1000:1 or on a static box; e is 0, ½ or 1."""
    parts = [
        crossed_edges(rng, count) if family == "edge on edge" else family_pairs(rng, family, count)
        for family in FAMILIES
    ]
    pairs = BoxPairs(*(np.concatenate(arrays) for arrays in zip(*parts)))
    total = len(pairs.size_a)
    masses = np.arange(total) % 4
    mass = np.ones((2, total)) * 10.0 ** rng.uniform(-1.0, 1.0, total)
    mass[0, masses == 1] *= 1000.0
    mass[1, masses == 2] *= 1000.0
    mass[1, masses == 3] = np.inf
    velocity, spin = rng.normal(size=(2, total, 3)), rng.normal(size=(2, total, 3))
    velocity[1, masses == 3] = spin[1, masses == 3] = 0.0
    for i, (_, normal, _) in enumerate(box_separations(pairs)):
        velocity[0, i] -= rng.uniform(0.5, 4.0) * normal
    names = np.concatenate([[family] * len(part.size_a) for family, part in zip(FAMILIES, parts)])
    kinds = np.array([f"{name}, {MASSES[k]}" for name, k in zip(names, masses)])
    return Impacts(pairs, mass[0], mass[1], velocity, spin, np.array([0.0, 0.5, 1.0])[np.arange(total) // 4 % 3], kinds)


def families(impacts: Impacts) -> np.ndarray:
    """Return the family of each impact: where they touch."""
    return np.array([kind.split(",")[0] for kind in impacts.kinds])


def exact_velocities(impacts: Impacts, i: int, point: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, int]:
    """Return the velocities (12,) after impact i at given contacts, by the exact solution; and in how many turns."""
    from references import multicontact

    return multicontact.manifold_impact(row_of(impacts, i), point, normal, float(impacts.restitution[i]))


def row_of(impacts: Impacts, i: int) -> tuple[Any, ...]:
    """Return the bodies of one impact, as arrays of one row."""
    return tuple(array[i : i + 1] for array in impacts.bodies())


def solved_at(impacts: Impacts, i: int, point: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the core's velocities (12,) after impact i at given contacts, and its impulses (k,) along the normals."""
    bodies, contacts, count = impacts.rigid_bodies(i), new_contacts(len(point)), len(point)
    contacts.number[:] = count
    contacts.box[:] = (0, 1)
    contacts.point[:], contacts.normal[:] = point, normal
    contacts.depth[:], contacts.restitution[:], contacts.friction[:] = 0.0, impacts.restitution[i], 0.0
    contacts.impulse[:] = 0.0
    prepare_contacts(contacts, bodies)
    solve_velocities(contacts, bodies, INSTANT, SWEEPS, 0.0)
    return motion_of(bodies), np.sum(contacts.impulse * contacts.normal, axis=1)


def _bullets(run: Run) -> tuple[Impacts, Any, np.ndarray]:
    """Return impacts, what Bullet makes of them, and those in which it finds contacts."""
    from references import pybullet

    impacts = family_impacts(run.fresh_rng(), run.count(60, 400, 10_000))
    judged = pybullet.one_impact(*impacts.bodies(), restitution=impacts.restitution)
    return impacts, judged, np.flatnonzero(judged.count > 0)


@check(
    section="4.4",
    piece=SOLVER,
    reference="pybullet, one step of 1e-13 s at the contact pose, its own manifold",
    engines=("pybullet",),
    unit="of the speed",
    tolerance=1e-11,
    because="both iterate; Bullet's 2 000 iterations left up to 2e-13 in 1 600 trials, and 1e-11 once elsewhere",
    faults=(RESTITUTION_OF_MANY,),
)
def impacts_by_bullet(run: Run) -> Comparison:
    """Boxes move and spin after impacts at Bullet's contacts as in Bullet."""
    impacts, judged, rows = _bullets(run)
    count = len(rows)
    rows = np.array([i for i in rows if _turns(impacts, i, judged.manifolds[i]) == 1])
    measured = [solved_at(impacts, i, _middle(judged.manifolds[i]), judged.manifolds[i].normal)[0] for i in rows]
    part = impacts.select(rows)
    notes = [f"{count - len(rows)} of {count} passed over: {STOPS}"]
    return Comparison(np.array(measured), bullet_velocities(judged)[rows], part.speeds(), part.kinds, notes=notes)


def _turns(impacts: Impacts, i: int, contacts: Any) -> int:
    """Return in how many turns an impact at Bullet's contacts is over, by the exact solution."""
    return exact_velocities(impacts, i, _middle(contacts), contacts.normal)[1]


def _middle(contacts: Any) -> np.ndarray:
    return 0.5 * (contacts.point_a + contacts.point_b)


@check(
    section="4.4, 4.5",
    piece="softbody.stepping.move_boxes.move_boxes",
    reference="exact complementarity solve at the core's own points, by trying all sets of contacts",
    unit="of the speed",
    kind="exhaustive search",
    tolerance=EXACT,
    because="what 20 000 sweeps leave of eight contacts and masses of 1 000:1, or a hundred times as many where that is"
    " more: 6.1e-13 at worst of ten seeds, 9.3e-13 at standard",
    faults=(RESTITUTION_OF_MANY,),
)
def impacts_by_exact_solve(run: Run) -> Comparison:
    """Velocities after impacts are exact at contacts that the core finds."""
    impacts = family_impacts(run.fresh_rng(), run.count(60, 300, 10_000))
    answers, slow, again = Answers(), 0, 0
    for i, scale in enumerate(impacts.speeds()):
        after, *contacts = end_to_end(impacts, i)
        exact, turns = exact_velocities(impacts, i, *contacts)
        again += turns > 1
        if np.abs(after - exact).max() > EXACT * scale:
            slow += 1
            after, *_ = end_to_end(impacts, i, MANY_SWEEPS)
        answers.add(after, exact, scale, impacts.kinds[i])
    return answers.comparison(
        notes=[
            f"{slow} of {len(answers)} impacts were given more than {SWEEPS} sweeps",
            f"in {again} impacts a contact closed by the bounce of another, and bounced itself",
        ]
    )


def end_to_end(impacts: Impacts, i: int, sweeps: int = SWEEPS) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the velocities (12,) of two boxes after one very short step, and the points and normals (k, 3) met."""
    world = World(gravity=(0.0, 0.0, 0.0), iterations=sweeps)
    e = float(impacts.restitution[i])
    for k, (size, mass, place, q) in enumerate(impacts.sides(i)):
        flight = impacts.velocity[k, i], impacts.angular_velocity[k, i]
        world.add_box(size, None if np.isinf(mass) else mass, place, q, *flight, restitution=e, friction=0.0)
    world.step(INSTANT)
    motion, contacts = np.hstack([world.state.box_velocity, world.state.box_angular_velocity]), world.store.contacts
    count = contacts.number[0]
    from_second = np.where(contacts.box[:count, :1] == 0, 1.0, -1.0)
    return motion.ravel(), contacts.point[:count], from_second * contacts.normal[:count]


@check(
    section="4.4, 4.5",
    piece="softbody.stepping.move_boxes.move_boxes",
    reference="pybullet, one step of 1e-13 s at the contact pose",
    engines=("pybullet",),
    unit="of the speed",
    tolerance=BULLETS,
    because="at the same points, seen along the normal, both leave 2.4e-13 at worst of ten seeds, 6.3e-13 at standard",
    faults=(RESTITUTION_OF_MANY,),
)
def end_to_end_by_bullet(run: Run) -> Comparison:
    """The core alone, from axes to velocities, makes Bullet's impacts."""
    impacts, judged, _ = _bullets(run)
    count, normal, point, _ = manifold.box_pairs_manifolds(impacts.pairs.a, impacts.pairs.b)
    velocities, scale = bullet_velocities(judged), impacts.speeds()
    answers, unsettled, again = Answers(), 0, 0
    for i in np.flatnonzero(count == judged.count).tolist():
        # The same contacts on both sides: else the question differs, and the claims above answer for each.
        theirs = _middle(judged.manifolds[i])
        # Along the normal, where it does not matter, Bullet's points on edges are 1e-5 m off.
        gaps = np.linalg.norm(np.cross(point[i, : count[i], None] - theirs[None], normal[i]), axis=2)
        if not np.maximum(gaps.min(axis=0).max(), gaps.min(axis=1).max()) < SAME_POINT:
            continue
        if _turns(impacts, i, judged.manifolds[i]) > 1:
            again += 1
            continue
        expected = velocities[i]
        after, *contacts = end_to_end(impacts, i)
        if np.abs(after - expected).max() > BULLETS * scale[i]:
            # Who has not iterated long enough? The exact solution says.
            after, *_ = end_to_end(impacts, i, MANY_SWEEPS)
            exact, _ = exact_velocities(impacts, i, *contacts)
            if np.abs(expected - exact).max() > BULLETS * scale[i]:
                unsettled += 1
                expected = exact
        answers.add(after, expected, scale[i], impacts.kinds[i])
    return answers.comparison(
        notes=[
            f"{len(count) - len(answers)} of {len(count)} trials passed over: Bullet keeps four of up to eight points, "
            "adds some of its own, or takes another axis (its edge axes carry a factor of 1.05)",
            f"of these {again}, as {STOPS}",
            f"{unsettled} times Bullet had not settled after 2 000 iterations: the exact solution took its place",
        ]
    )


@check(
    section="4.4",
    piece=SOLVER,
    reference="invariants",
    unit="of the momentum or energy",
    kind="invariant",
    tolerance=5e-12,
    because="rounding in up to 20 000 sweeps over masses of 1 000:1, 1.6e-12 at worst; "
    "with Newton's restitution at several points energy may even rise",
    faults=(
        Fault(
            "the second body's velocity feels 1e-9 less",
            sequential_impulses._sweep,
            "sub(v_b, scale(share_b, along)) → sub(v_b, scale((1.0 - 1e-9) * share_b, along))",
        ),
    ),
)
def conservation(run: Run) -> Comparison:
    """An impact at several points keeps the momenta.

    Its energy changes by ½ Σ λ (u_n + u_n').
    """
    from references import multicontact

    impacts = family_impacts(run.fresh_rng(), run.count(60, 400, 10_000))
    count, normal, point, _ = manifold.box_pairs_manifolds(impacts.pairs.a, impacts.pairs.b)
    answers, motion = Answers(), impacts.motion()
    for i, (k, family) in enumerate(zip(count, families(impacts))):
        bodies, normals = row_of(impacts, i), np.tile(normal[i], (k, 1))
        after, push = solved_at(impacts, i, point[i, :k], normals)
        change, work, energy = multicontact.energy_change(bodies, point[i, :k], normals, push, after)
        answers.add([change, 0, 0, 0, 0, 0], [work, 0, 0, 0, 0, 0], energy, f"energy, {family}")
        if np.isfinite(impacts.mass_b[i]):
            ours, theirs = (multicontact.momenta(bodies, each) for each in (after, motion[i]))
            scale = max(impacts.mass_a[i], impacts.mass_b[i]) * np.abs(motion[i]).max() * 2.0
            answers.add(ours, theirs, scale, f"momenta, {family}")
    return answers.comparison()


@check(
    section="4.5",
    piece="softbody.collision.boxes.sat_boxes.least_overlap",
    reference="pybullet getClosestPoints with margins 0",
    engines=("pybullet",),
    unit="of the size, and of a unit vector",
    tolerance=1e-12,
    because="rounding of both; where two axes tie within 1e-9 of the depth, either normal is right, if the corners of"
    " both boxes say so, or a face within 1e-3 rad of the edges' axis, and is passed over",
    faults=(
        Fault(
            "an edge axis that is not quite a unit vector",
            sat_boxes._best_edge_pair,
            "1.0 / sine_ if t_ >= 0.0 else other_ → (1.0 + 1e-9) / sine_ if t_ >= 0.0 else other_",
        ),
        Fault(
            "normals of faces that all point one way", sat_boxes.least_overlap, "1.0 if apart_ >= 0.0 else -1.0 → 1.0"
        ),
    ),
)
def depth_and_normal_by_bullet(run: Run) -> Comparison:
    """The depth of overlapping boxes, and the way out, are Bullet's."""
    from references import exact, pybullet_world

    pairs = random_box_pairs(run.fresh_rng(), run.count(300, 3_000, 30_000))
    count, normal, _, _ = manifold.box_pairs_manifolds(pairs.a, pairs.b)
    depth = np.array([-separation for separation, _, _ in box_separations(pairs)])
    rows = np.flatnonzero(count > 0)
    pairs, normal, depth = pairs.select(rows), normal[rows], depth[rows]
    distance, theirs = pybullet_world.closest(*pairs)
    truth, said = -depth, {US: -depth, "pybullet": distance.copy()}
    # A tie is one only if the core's own normal undoes the overlap by as little, or is a face's, which the core prefers
    # to edges whose axis is within 1e-3 rad of it: the points of faces are what meets there.
    apart, least = np.linalg.norm(normal - theirs, axis=1), 1e-9 * pairs.extent
    honest = (apart < 1.001e-3) | (np.abs(gap_along(pairs, normal) + depth) < least)
    tie = (apart > 1e-9) & honest & (np.abs(distance + depth) < least)
    # Where the depths differ, or Bullet finds none (NaN), exact arithmetic says who errs, and judges in Bullet's stead.
    wrong = np.flatnonzero(~(np.abs(distance + depth) < least))
    if len(wrong):
        exactly = exact.box_separation(*pairs.select(wrong))
        truth[wrong] = exactly
        errs = ~(np.abs(distance[wrong] - exactly) < least[wrong])
        wrong, exactly = wrong[errs], exactly[errs]
        distance[wrong], theirs[wrong] = exactly, np.where(honest[wrong, None], normal[wrong], np.nan)
    measured = np.column_stack([depth / pairs.extent, normal])[~tie]
    expected = np.column_stack([-distance / pairs.extent, theirs])[~tie]
    kinds = np.array(["edge on edge" if axis >= 6 else "face" for _, _, axis in box_separations(pairs)])[~tie]
    notes = [
        f"{int(tie.sum())} ties of two axes passed over",
        f"{len(wrong)} times exact arithmetic says that Bullet errs: its depth is used there, and no normal judged",
    ]
    by, inputs = "exact arithmetic where they differ", pairs._asdict()
    found = arbitrate(by, truth, said, tolerance=1e-9, scale=pairs.extent, inputs=inputs)
    return Comparison(measured, expected, 1.0, kinds, notes=notes, arbitrations=[found])


@check(
    section="4.4",
    piece=BOX_ON_BOX,
    reference="geometry: the point ± half the depth lies on the boundary of a and of b",
    unit="of the size",
    kind="closed form",
    tolerance=3e-14,
    because="rounding of the points, 1e-15 of the size, a thousand times",
    faults=(
        Fault(
            "points of a face a thousandth of the depth off the middle",
            manifold._clip_faces,
            "0.5 * above_ + height → 0.501 * above_ + height",
        ),
    ),
)
def points_on_surfaces(run: Run) -> Comparison:
    """Contact points lie half their depth from both surfaces, along the normal."""
    impacts, answers = family_impacts(run.fresh_rng(), run.count(100, 1_000, 10_000)), Answers()
    count, normal, point, depth = manifold.box_pairs_manifolds(impacts.pairs.a, impacts.pairs.b)
    extent, names = impacts.pairs.extent, families(impacts)
    for i, k in enumerate(count):
        for c in range(k):
            for sign, (size, _, position, q) in zip((-0.5, 0.5), impacts.sides(i)):
                at = point[i, c] + sign * depth[i, c] * normal[i]
                off = np.max(np.abs(rotation_matrix(q).T @ (at - position)) - 0.5 * size)
                answers.add(off, 0.0, extent[i], names[i])
    return answers.comparison()


@check(
    section="4.4",
    piece=BOX_ON_BOX,
    reference="pybullet's contact point in one step",
    engines=("pybullet",),
    unit="of the size",
    tolerance=1e-13,
    because="rounding; along the normal Bullet's edge contacts are 1e-5 m off, which is its own error",
    faults=(
        Fault(
            "the wrong way along the second edge",
            edge_edge.nearest_places,
            "along_b_ + s_ * cosine_ → along_b_ - s_ * cosine_",
        ),
    ),
)
def points_by_bullet(run: Run) -> Comparison:
    """A vertex on a face, and crossing edges, touch where Bullet says.

    Points are seen along the normal.
    """
    impacts, judged, _ = _bullets(run)
    count, ours, point, _ = manifold.box_pairs_manifolds(impacts.pairs.a, impacts.pairs.b)
    names = families(impacts)
    single = (count == 1) & (judged.count == 1) & ((names == FAMILIES[0]) | (names == FAMILIES[1]))
    other = single & (np.linalg.norm(ours - judged.normal, axis=1) > SAME_NORMAL)
    single &= ~other
    normal = judged.normal[single]
    apart = point[single, 0] - judged.point[single]
    apart -= np.sum(apart * normal, axis=1)[:, None] * normal
    notes = [f"{int(other.sum())} times Bullet takes another, slightly deeper axis, and so another point: passed over"]
    return Comparison(apart, np.zeros_like(apart), impacts.select(single).pairs.extent, names[single], notes=notes)


@check(
    section="4.4",
    piece="softbody.collision.impulse.resolve_contact",
    reference="MuJoCo: inertia, frames and Jacobian of its own; Newton's law on top",
    engines=("mujoco",),
    unit="of the speed",
    tolerance=3e-14,
    because="MuJoCo's matrix, solved with masses up to 1 000:1: 1.4e-15 at worst of ten seeds, 3.1e-15 of 10 000",
    faults=(RESTITUTION,),
)
def one_impact_by_mujoco(run: Run) -> Comparison:
    """Boxes move after an impact as MuJoCo's mass matrix and Jacobian say."""
    from references import mujoco

    rng = run.fresh_rng()
    impacts = random_impacts(rng, run.count(100, 1_000, 10_000))
    point, normal = contact_points(impacts, rng)
    return Comparison(
        core_velocities(impacts, point, normal),
        np.concatenate(mujoco.box_impact(*impacts.bodies(), point, normal, impacts.restitution), axis=1),
        speeds(impacts),
        impacts.kinds,
    )


@check(
    section="4.2, 10.13",
    piece="softbody.collision.impulse.resolve_contact",
    reference="closed form",
    unit="of the speed",
    kind="closed form",
    tolerance=2e-14,
    because="rounding, with masses up to 1 000:1",
    faults=(RESTITUTION,),
)
def particle_on_box(run: Run) -> Comparison:
    """A particle that strikes a box meets its mass and inertia.

    It turns the box by r × impulse.
    """
    from references import analytic

    rng = run.fresh_rng()
    count = run.count(500, 5_000, 50_000)
    size, x, v, w, u = rng.uniform(0.4, 2.0, (count, 3)), *rng.normal(size=(4, count, 3))
    q = random_orientations(rng, count)
    mass, particle = 10.0 ** rng.uniform(-1.5, 1.5, (2, count))
    normal = random_orientations(rng, count)[:, :3]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    point = x + rng.uniform(-0.7, 0.7, (count, 3)) * size
    e = rng.choice([0.0, 0.5, 1.0], count)
    arguments = (size, mass, x, q, v, w, particle, point, u, normal, e)
    measured = np.empty((count, 9))
    for i in range(count):
        bodies = RigidBodies(
            np.array([1.0 / particle[i], 1.0 / mass[i]]),
            np.array([np.zeros(3), 1.0 / np.array(box_inertia(tuple(size[i]), mass[i]))]),
            np.array([point[i], x[i]]),
            np.array([[1.0, 0.0, 0.0, 0.0], q[i]]),
            np.array([u[i], v[i]]),
            np.array([np.zeros(3), w[i]]),
        )
        resolve_contact(bodies, (0, 1), tuple(point[i]), tuple(normal[i]), Material(float(e[i]), 0.0))
        measured[i] = np.concatenate([bodies.velocity[1], bodies.angular_velocity[1], bodies.velocity[0]])
    ratio = np.maximum(mass / particle, particle / mass)
    return Comparison(
        measured,
        np.concatenate(analytic.particle_impact(*arguments), axis=1),
        ratio * np.linalg.norm(np.concatenate([v, w, u], axis=1), axis=1),
    )


@check(
    section="4.5",
    piece="softbody.collision.boxes.manifold.box_pairs_manifolds",
    reference="the shapes that are documented",
    kind="specification",
    unit="lengths of axes",
    tolerance=0.0,
    because="whole numbers",
    faults=(
        Fault("nine points", manifold.box_pairs_manifolds, "(pairs, MOST_POINTS, 3) → (pairs, MOST_POINTS + 1, 3)"),
        Fault("nine depths", manifold.box_pairs_manifolds, "(pairs, MOST_POINTS) → (pairs, MOST_POINTS + 1)"),
        Fault("normals of both boxes", manifold.box_pairs_manifolds, "(pairs, 3) → (2 * pairs, 3)"),
    ),
)
def shapes_of_the_answer(run: Run) -> Comparison:
    """Where boxes touch is answered in arrays of the documented shapes.

    For m pairs they are m counts, m normals, m rows of eight points and m of eight depths. There are any m, also none,
    of boxes that meet anyhow.
    """
    rng, answers = run.fresh_rng(), Answers()
    for m in [0, 1, *rng.integers(2, 200, run.count(6, 20, 100)).tolist()]:
        pairs = random_box_pairs(rng, 200).select(np.arange(m))
        arrays = manifold.box_pairs_manifolds(pairs.a, pairs.b)
        answers.add([length for array in arrays for length in array.shape], [m, m, 3, m, 8, 3, m, 8])
    return answers.comparison()


@check(
    section="4.5",
    piece=BOX_ON_BOX,
    reference="nearest points of two segments: the best of those within both and from each of the four ends, by NumPy",
    kind="closed form",
    unit="of the size",
    tolerance=1e-13,
    because="lines at 6° and more, whose nearest points are rounded ten times as much: 2.9e-15 at worst at quick",
    faults=(
        Fault("edges of b that are longer", manifold._edge_point, "0.5 * size[b, j] → 0.505 * size[b, j]"),
        Fault("edges of a that are longer", manifold._edge_point, "0.5 * size[a, i] → 0.505 * size[a, i]"),
        Fault(
            "the edge of b that is away from a",
            manifold._edge_point,
            "0.5 if towards >= 0.0 else -0.5 → -0.5 if towards >= 0.0 else 0.5",
        ),
        Fault("points on a", manifold._edge_point, "0.5 * (on_a + on_b) → on_a"),
    ),
)
def edges_that_are_nearest(run: Run) -> Comparison:
    """Edges that part boxes touch half-way between their nearest points.

    Boxes overlap, however deep, or are less than a margin apart, and part most along an edge of each. The edges are the
    two that reach farthest to the other box. They come nearest within both, or at the end of one.
    """
    rng, answers = run.fresh_rng(), Answers()
    m = run.count(4_000, 20_000, 200_000)
    size = rng.uniform(0.2, 1.0, (2, m, 3))
    place = np.stack([rng.uniform(0.2, 0.8, (m, 1)) * rng.normal(size=(m, 3)), np.zeros((m, 3))])
    turns = np.stack([random_orientations(rng, m), random_orientations(rng, m)])
    a, b = (sat_boxes.PlacedBoxes(size[k], place[k], turns[k]) for k in range(2))
    count, normal, point, _ = manifold.box_pairs_manifolds(a, b, 0.5)
    for row in np.flatnonzero(count == 1):
        axes = [rotation_matrix(turns[k, row]).T for k in range(2)]
        across = np.cross(axes[0][:, None], axes[1][None])
        sines = np.linalg.norm(across, axis=2)
        along = np.abs(across @ normal[row]) / np.maximum(sines, 1e-300)
        i, j = np.unravel_index(np.where(sines > 0.1, along, 0.0).argmax(), (3, 3))
        faces = np.abs(np.concatenate(axes) @ normal[row])
        if along[i, j] < 1.0 - 1e-12 or faces.max() > 1.0 - 1e-6 or np.abs(faces).min() > 1e-3:
            continue
        ends = []
        for k, (own, sign) in enumerate(((i, -1.0), (j, 1.0))):
            middle = place[k, row]
            for axis in np.delete(np.arange(3), own):
                side = sign * np.sign(axes[k][axis] @ normal[row])
                middle = middle + side * 0.5 * size[k, row, axis] * axes[k][axis]
            ends.append(middle + np.array([[-0.5], [0.5]]) * size[k, row, own] * axes[k][own])
        where, kind = nearest_of_segments(*ends)
        answers.add(point[row, 0], where, kind=kind)
    return answers.comparison()


def nearest_of_segments(one: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, str]:
    """Return the middle (3,) of the shortest way between two segments (2, 3), and where that is on them, in words."""
    u, v, apart = one[1] - one[0], other[1] - other[0], other[0] - one[0]
    s, t = np.linalg.lstsq(np.stack([u, -v], axis=1), apart, rcond=None)[0]
    if 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0:
        return 0.5 * (one[0] + s * u + other[0] + t * v), "within both"
    ways = []
    for end in (0.0, 1.0):
        p, q = one[0] + end * u, other[0] + end * v
        ways.append((p, other[0] + np.clip((p - other[0]) @ v / (v @ v), 0.0, 1.0) * v))
        ways.append((one[0] + np.clip((q - one[0]) @ u / (u @ u), 0.0, 1.0) * u, q))
    p, q = min(ways, key=lambda way: float(np.linalg.norm(way[0] - way[1])))
    return 0.5 * (p + q), "at an end"
