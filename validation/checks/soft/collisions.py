"""Soft bodies that collide, with each other and with a box: what they keep, and the rigid bodies that they tend to."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import product
from typing import Any

import numpy as np

import softbody
from references import analytic, printed
from softbody import Mesh, World
from softbody.collision.contact import Touch, add_contact, box_side, new_contacts, soft_side
from softbody.collision.soft import edge_mesh, soft_contacts, soft_response, soft_solver
from softbody.collision.soft.soft_response import Bodies, resolve_contacts, response_memory
from softbody.geometry import bvh_rays
from softbody.geometry.box import box_inertia
from softbody.model import material
from softbody.model.arrays import Particles, RigidBodies
from softbody.model.material import Material
from softbody.model.surface_point import SurfacePoint
from validation import accounts
from validation.answers import Answers
from validation.cases import ROOF, ROOF_FACES, random_orientations, rotated, rotation_matrix
from validation.check import Comparison, Misprint, Run, check
from validation.checks.soft.cases import CONTACTS, ONE_SIDED, RESPONSE, weightless
from validation.fault import Fault

FAMILY = "soft bodies that collide"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

HALF_AN_IMPULSE = Fault(
    "a box that feels half of the impulse of a soft body",
    soft_solver.give,
    "_push_box(s_, m_, b_, scale(x_, more_), y_) → _push_box(s_, m_, b_, scale(0.5 * x_, more_), y_)",
)

RADIUS = 0.5  # [m] of the spheres at their rest lengths
GAS = 0.15  # [m²] nRT over stiffness: a sphere of any stiffness is blown up by the same 4 %
SMOOTH: dict[str, Any] = {"friction": 0.0, "damping": 0.0}
BOX = (0.6, 1.0, 0.8)  # [m]
STIFFER = 16.0  # times, from one row of a ladder to the next; the depth of a dent falls with √k, to a quarter


def _sphere(rng: np.random.Generator, subdivisions: int) -> Mesh:
    return rotated(softbody.icosphere(subdivisions, RADIUS), rng)


def _two_spheres(
    meshes: tuple[Mesh, Mesh],
    stiffness: float,
    aside: float = 0.6,
    masses: tuple[float, float] = (1.0, 1.0),
    restitution: float = 0.0,
    integrator: str = "rk4",
) -> World:
    """Return spheres at rest in themselves, nearly touching, that fly at each other with equal and opposite momenta.

    They close in along x at 2 m/s, their centres `aside` [m] apart in y; no friction, no weight.
    """
    world = weightless(integrator=integrator)
    half = 0.5 * np.sqrt(1.1**2 - aside**2)  # blown up, their radii are 0.52 m
    for mesh, mass, side in zip(meshes, masses, (-1.0, 1.0)):
        place = (side * half, side * 0.5 * aside, 0.0)
        world.add_soft_body(mesh, mass, stiffness, GAS * stiffness, place, restitution=restitution, **SMOOTH)
    world.equilibrium()
    for body, other, side in zip(world.soft_bodies, reversed(masses), (-1.0, 1.0)):
        body.velocities[:] = (-side * 2.0 * other / sum(masses), 0.0, 0.0)
    return world


def _sphere_and_box(
    mesh: Mesh, stiffness: float, strike: tuple[float, float], restitution: float = 0.0, integrator: str = "rk4"
) -> World:
    """Return a sphere of 1 kg that flies along x at 2 m/s at a box of 1.5 kg, to strike its face at `strike` (y, z)."""
    world = weightless(integrator=integrator, gyroscopic=True)
    place = (-0.84, *strike)
    body = world.add_soft_body(mesh, 1.0, stiffness, GAS * stiffness, place, restitution=restitution, **SMOOTH)
    world.add_box(BOX, 1.5, restitution=restitution, friction=0.0)
    world.equilibrium()
    body.velocities[:] = (2.0, 0.0, 0.0)
    return world


def _collide(world: World) -> World:
    """Run until the bodies have parted, in steps of 0.8 of the longest stable one."""
    # Contact lasts about π √(m/k), and here k counts about tenfold, for the whole dent.
    world.run(0.05 + 5.0 / np.sqrt(world.model.edge_stiffness[0]), 0.8 * world.stable_time_step())
    return world


def _mean_velocities(world: World) -> np.ndarray:
    """Return (b, 3): the velocity [m/s] of each soft body's centre."""
    return np.array([body.velocities.mean(axis=0) for body in world.soft_bodies])


def _gains(kind: str, seed: int, restitution: float, integrator: str) -> tuple[float, float]:
    """Return by how much a collision raises the energy and changes the angular momentum, relative to these."""
    rng = np.random.default_rng(seed)
    if kind == "soft–soft":
        world = _two_spheres((_sphere(rng, 2), _sphere(rng, 2)), 400.0, 0.6, (1.0, 1.0), restitution, integrator)
        kinetic = 1.0
    else:
        world = _sphere_and_box(_sphere(rng, 2), 400.0, (0.25, 0.15), restitution, integrator)
        kinetic = 2.0
    energy, spin = accounts.energy(world), accounts.angular_momentum(world)
    _collide(world)
    turned = np.linalg.norm(accounts.angular_momentum(world) - spin) / np.linalg.norm(spin)
    return (accounts.energy(world) - energy) / kinetic, float(turned)


def _gained(run: Run, which: int, integrators: tuple[str, ...], next_too: int = 0) -> Comparison:
    """Compare one of the gains of collisions with none, of every kind and by each of the integrators.

    Each seed has the next restitution, and each integrator too, by so many.
    """
    seeds, answers = run.fresh_rng().integers(2**32, size=run.count(2, 10, 40)), Answers()
    for (n, seed), kind, (k, integrator) in product(enumerate(seeds), KINDS, enumerate(integrators)):
        gains = _gains(kind, int(seed), 0.5 * ((n + next_too * k) % 3), integrator)
        answers.add(np.maximum(0.0, gains[which]), 0.0, kind=f"{kind}, {integrator}")
    return answers.comparison()


KINDS = ("soft–soft", "soft–rigid")


@check(
    section="4.2, 4.3",
    piece=RESPONSE,
    reference="invariant",
    unit="energy gained, of the kinetic",
    kind="invariant",
    tolerance=1e-13,
    because="gains only, and rounding of some hundred terms: what closed in a step is undone; 180 collisions lost 2 %"
    " at least",
    faults=(
        Fault(
            "soft bodies that bounce off each other faster than they came",
            soft_response.look_back,
            "contacts_.restitution[k_] → (contacts_.restitution[k_] + 1.2)",
        ),
    ),
)
def collisions_add_no_energy(run: Run) -> Comparison:
    """A collision off-centre adds no energy.

    Of two soft spheres or of one with a box, of restitution 0, ½ or 1.
    """
    return _gained(run, 0, ("rk4_velocity", "rk4", "symplectic_euler"), 1)


@check(
    section="4.2, 4.3",
    piece=RESPONSE,
    reference="invariant",
    unit="of the angular momentum",
    kind="invariant",
    tolerance=1e-4,
    because="impulses act where both sides were when they touched; what later sweeps add is of second order: 8e-6",
    faults=(
        ONE_SIDED,
        Fault(
            "impulses where the surface is now, not where it was when they acted",
            soft_response._place_on_b,
            "line_meets_triangle(c_, k_, p_, direction_, ago_) → line_meets_triangle(c_, k_, p_, direction_, 0.0)",
        ),
    ),
)
def collisions_keep_angular_momentum(run: Run) -> Comparison:
    """A soft sphere's collision off-centre, with sphere or box, keeps angular momentum."""
    return _gained(run, 1, ("rk4", "symplectic_euler"))


@check(
    section="4.3",
    piece=CONTACTS,
    reference="closed form: in the centre's frame both velocities turn round; restitution 0 is that of a particle only",
    unit="of the closing speed",
    kind="closed form",
    least=2,
    tolerance=0.03,
    because="a hit takes a particle's share; the surface rings: 2.04 % of ten seeds at 642 particles, 20 % at 42",
    faults=(
        Fault(
            "contacts that never act", soft_solver._answer, "problem_.mobility[k_] > 0.0 → problem.mobility[k] > 1e300"
        ),
    ),
)
def head_on_spheres_bounce(run: Run) -> Comparison:
    """Soft spheres, stiffer and finer, meet head-on and part like elastic balls."""
    rng, answers, notes = run.fresh_rng(), Answers(), []
    for masses in ((1.0, 1.0), (1.0, 3.0)):
        world = _two_spheres((_sphere(rng, 3), _sphere(rng, 3)), 6_400.0, 0.0, masses)
        before = _mean_velocities(world)[:, 0]
        after = _mean_velocities(_collide(world))[:, 0]
        answers.add(after, -before, 2.0, "masses {:.0f} : {:.0f}".format(*masses))
    for subdivisions, stiffness in ((1, 6_400.0), (2, 6_400.0), (3, 100.0), (3, 6_400.0)):
        world = _two_spheres((_sphere(rng, subdivisions), _sphere(rng, subdivisions)), stiffness, 0.0)
        speed = np.ptp(_mean_velocities(_collide(world))[:, 0]) / 2.0
        notes.append(f"{10 * 4**subdivisions + 2} particles, k = {stiffness:.0f} N/m: {speed:.3f} of the closing speed")
    return answers.comparison(notes=notes)


ORIENTATIONS = 6  # of the meshes, over which a case is averaged: one vertex touches first, half an edge aside or not


def _limit(measure: Callable[[float], np.ndarray]) -> tuple[np.ndarray, str]:
    """Return what `measure` of the stiffness tends to as that grows, and in words how far its last value is off.

    The depth of a dent, and with it the error, falls to 1/√STIFFER from one row of the ladder to the next.
    """
    ladder = 1_600.0, 1_600.0 * STIFFER
    rows = [np.mean([measure(stiffness) for _ in range(ORIENTATIONS)], axis=0) for stiffness in ladder]
    limit = rows[1] + (rows[1] - rows[0]) / (np.sqrt(STIFFER) - 1.0)
    rest = float(np.linalg.norm(limit - rows[1]))
    return limit, f"at k = {ladder[1]:.0f} N/m still {rest / 2.0:.3f} from the limit"


@check(
    section="4.3",
    piece=CONTACTS,
    reference="closed form: hard smooth spheres exchange their velocities along the line of centres",
    unit="of the closing speed",
    kind="closed form",
    least=1,
    tolerance=0.06,
    because="the surface keeps 1 % ringing; facets of 642 particles turn the normal by 1/20, most if they graze",
    faults=(Fault("smooth soft bodies that rub", material.combined, "sqrt(a_.friction * b_.friction) → 0.5"),),
)
def off_centre_spheres_deflect(run: Run) -> Comparison:
    """Soft spheres that meet off-centre deflect like hard ones, as they stiffen."""
    rng, answers, notes = run.fresh_rng(), Answers(), []

    def world_of(aside: float, stiffness: float) -> World:
        return _two_spheres((_sphere(rng, 3), _sphere(rng, 3)), stiffness, aside)

    def deflected(aside: float, stiffness: float) -> np.ndarray:
        return _mean_velocities(_collide(world_of(aside, stiffness))).ravel()

    for aside in (0.6, 0.3, 0.8)[: run.count(1, 2, 3)]:
        limit, note = _limit(partial(deflected, aside))
        start = world_of(aside, 1_600.0)
        ball = start.soft_bodies[0].positions
        radius = np.linalg.norm(ball - ball.mean(axis=0), axis=1).mean()
        sine = aside / (2.0 * radius)
        line = np.array([np.sqrt(1.0 - sine**2), sine, 0.0])
        a, b = _mean_velocities(start)
        exchanged = ((b - a) @ line) * line
        answers.add(limit, np.concatenate([a + exchanged, b - exchanged]), 2.0, f"{aside} m aside")
        notes.append(f"{aside} m aside: {note}")
    return answers.comparison(notes=notes)


@check(
    section="4.2",
    piece=CONTACTS,
    reference="closed form: a smooth ball meets the box as a particle of its mass would, with restitution 1",
    unit="of the speeds before",
    kind="closed form",
    least=1,
    tolerance=0.08,
    because="the surface keeps 1 % ringing; the vertex that touches first is up to 0.04 m aside, 0.01 m on average",
    faults=(HALF_AN_IMPULSE,),
)
def stiff_sphere_strikes_box(run: Run) -> Comparison:
    """A stiffening soft sphere strikes a box like a rigid smooth one.

    Off-centre, so that the box flies and spins.
    """
    rng, answers, notes = run.fresh_rng(), Answers(), []

    def struck(strike: tuple[float, float], stiffness: float) -> np.ndarray:
        world = _collide(_sphere_and_box(_sphere(rng, 3), stiffness, strike))
        box = world.state.box_velocity[0], world.state.box_angular_velocity[0]
        return np.concatenate([*box, *_mean_velocities(world)])

    for _ in range(run.count(1, 3, 12)):
        strike = tuple(rng.uniform(-0.25, 0.25, 2))
        limit, note = _limit(partial(struck, strike))
        here, still = np.array([[-0.3, *strike]]), np.zeros((1, 3))
        box = np.array([BOX]), np.array([1.5]), still, np.array([[1.0, 0.0, 0.0, 0.0]]), still, still
        ball = np.array([1.0]), here, np.array([[2.0, 0.0, 0.0]]), np.array([[-1.0, 0.0, 0.0]]), np.array([1.0])
        answers.add(limit, np.concatenate(analytic.particle_impact(*box, *ball), axis=1)[0], 2.0)
        notes.append(note)
    return answers.comparison(notes=notes[:3])


@check(
    section="4.3",
    piece=CONTACTS,
    reference="symmetry, of every particle, after 0.065 s, with a box between after 0.3 s",
    unit="of the size",
    kind="invariant",
    tolerance=3e-14,
    because="sums are rounded, which grows up to twentyfold every 5 ms where a tip or a side meets its own image, to"
    " 1e-3 at last: so 65 ms, 15 ms after they have met: 1e-15 at worst of ten seeds, 1.4e-14 of 540 pairs",
    faults=(
        Fault(
            "pairs of soft bodies looked at from one side",
            soft_contacts._find_contacts_of,
            "probe_ = surface_of(m_, s_, shapes_, scratch_, thread_, other_)"
            " → if other_ < body:\n    continue\n"
            "probe_ = surface_of(m_, s_, shapes_, scratch_, thread_, other_)",
        ),
    ),
)
def symmetric_pairs_stay_symmetric(run: Run) -> Comparison:
    """Two equal bodies that meet symmetrically stay symmetric.

    One is the other turned by half a turn, or mirrored, with a box between or without.
    """
    rng, answers = run.fresh_rng(), Answers()
    shapes = {"spheres": softbody.icosphere(2, RADIUS), "tori": softbody.torus(0.36, 0.14, 20, 10)}
    for what, mesh in [*shapes.items()] * run.count(2, 6, 30):
        one = rotated(mesh, rng)
        for how, seconds in (("half a turn", 0.065), ("mirrored", 0.065), ("mirrored, a box", 0.3)):
            mirror = how != "half a turn"
            signs = (-1.0, 1.0 if mirror else -1.0, 1.0)
            other = Mesh(one.vertices * signs, one.triangles[:, ::-1] if mirror else one.triangles)
            world = _two_spheres((one, other), 400.0, 0.0 if mirror else 0.6)
            if how == "mirrored, a box":
                for body, side in zip(world.soft_bodies, (-1.0, 1.0)):
                    body.positions[:] += (0.3 * side, 0.0, 0.0)
                world.add_box((0.3, 0.5, 0.6), 0.7)
            world.run(seconds, 0.4 * world.stable_time_step())
            a, b = (body.positions for body in world.soft_bodies)
            answers.add(np.abs(a - b * signs).max(), 0.0, 2.0 * RADIUS, f"{what}, {how}")
    return answers.comparison()


@check(
    section="6",
    piece="softbody.collision.soft.edge_mesh",
    reference="closed form: how far the line of one ridge is below that of the other where they cross, seen from above",
    unit="of the height of a roof",
    kind="closed form",
    least=4,
    tolerance=1e-3,
    because="each step ends with the two ridges parted to rounding; a step of the fall is 2e-3, a missed ridge 1",
    faults=(
        Fault(
            "segments that no triangle stops",
            bvh_rays._place_in_triangle,
            "_is_positive(before_, n_) == _is_positive(beyond_, n_) → before_ < np.inf",
        ),
        Fault(
            "edges whose nearest point is before the other's start",
            edge_mesh.bits_across,
            "bits_at_most(0.0, other_place_) → bits_at_most(other_place_, 0.0)",
        ),
    ),
)
def crossed_ridges_hold(run: Run) -> Comparison:
    """Roofs of eight triangles, fallen ridge across ridge, hold by their ridges."""
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(4, 20, 100)):
        angle, aside, drop = rng.uniform(0.3, 0.7) * np.pi, rng.uniform(-0.2, 0.2, 2), rng.uniform(0.05, 0.3)
        c, s = np.cos(angle), np.sin(angle)
        upside_down = ROOF @ np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]])
        world = World()
        world.add_ground()
        lower = world.add_soft_body(Mesh(ROOF, ROOF_FACES), 6.0, 2e4, 200.0)
        start = (*aside, 1.0 + drop)
        upper = world.add_soft_body(Mesh(upside_down, ROOF_FACES), 0.6, 2e3, 20.0, start, friction=0.0)
        step, deepest = 0.5 * world.stable_time_step(), 0.0
        for _ in range(20):
            world.run(0.02, step)
            (p, q), (u, v) = lower.positions[[2, 5]], upper.positions[[2, 5]]
            t = np.linalg.solve(np.column_stack([(q - p)[:2], (u - v)[:2]]), (u - p)[:2])
            if ((t > 0.05) & (t < 0.95)).all():  # later it may have slid off
                deepest = np.maximum(deepest, (p + t[0] * (q - p))[2] - (u + t[1] * (v - u))[2])
        answers.add(deepest / 0.5, 0.0)
    return answers.comparison()


def _point_strikes_box(rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """Let the core part a random point on a surface from a random spinning box.

    Returns the arguments of `analytic.particle_impact`, a row each, the point as the particle; then (9,): velocity and
    spin of the box and the velocity of the point.
    """
    position, velocity = rng.normal(size=(3, 3)), rng.normal(size=(3, 3))
    mass, weights = 10.0 ** rng.uniform(-1.0, 1.0, 3), rng.dirichlet((1.0, 1.0, 1.0))
    size, box_mass, q = rng.uniform(0.4, 2.0, 3), 10.0 ** rng.uniform(-1.0, 1.0), random_orientations(rng, 1)
    place, inertia = weights @ position, np.array([box_inertia(tuple(size), box_mass)])
    centre = place + rotation_matrix(q[0]) @ (rng.uniform(-0.5, 0.5, 3) * size)
    box = RigidBodies(np.array([1.0 / box_mass]), 1.0 / inertia, centre[None], q, *rng.normal(size=(2, 1, 3)))
    normal = random_orientations(rng, 1)[0, :3]
    normal /= np.linalg.norm(normal)
    e = rng.choice([0.0, 0.5, 1.0])
    start = box.position[0].copy(), q[0], box.velocity[0].copy(), box.angular_velocity[0].copy()
    point = 1.0 / (weights**2 @ (1.0 / mass)), place, weights @ velocity, normal, e
    contacts, side = new_contacts(1), soft_side(SurfacePoint((0, 1, 2), tuple(weights)))
    add_contact(contacts, side, box_side(0), Touch(tuple(place), tuple(normal), 0.0, 0), Material(float(e), 0.0))
    # In a step of no length at all, everything has come as it goes.
    bodies = Bodies(Particles(1.0 / mass, position, velocity), box)
    before = Bodies(Particles(1.0 / mass, position, velocity.copy()), RigidBodies(*(rows.copy() for rows in box)))
    resolve_contacts(contacts, bodies, before, response_memory(np.array([0, 3]), 1), 1e-300)
    after = np.concatenate([box.velocity[0], box.angular_velocity[0], weights @ velocity])
    return size, box_mass, *start, *point, after


@check(
    section="4.2",
    piece="softbody.collision.soft.soft_solver.solve_island",
    reference="closed form: the point is a particle of mass 1/(Σ w²/m)",
    unit="of the speeds",
    kind="closed form",
    tolerance=2e-14,
    because="rounding, with masses up to 100:1",
    faults=(HALF_AN_IMPULSE,),
    erratum=Misprint("E13", "L = r × v; bounce from masses alone", "r × impulse; effective mass with the inertia"),
)
def patch_strikes_box(run: Run) -> Comparison:
    """A surface's point that strikes a box gives way by Σ w²/m.

    The box gives way by its mass and inertia.
    """
    rng = run.fresh_rng()
    rows = [_point_strikes_box(rng) for _ in range(run.count(300, 2_000, 20_000))]
    *case, measured = (np.array(column) for column in zip(*rows))
    ratio = np.maximum(case[1] / case[6], case[6] / case[1])
    return Comparison(
        measured,
        np.concatenate(analytic.particle_impact(*case), axis=1),
        ratio * np.linalg.norm(np.concatenate([case[4], case[5], case[8]], axis=1), axis=1),
        printed=np.concatenate(printed.particle_impact_by_masses(*case), axis=1),
    )
