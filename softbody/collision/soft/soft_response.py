"""Response to the contacts of soft bodies and boxes, all at once: none is first, and none comes too late.

Contacts are found at the end of a step, and happened within it: an impulse acts as far back as its contact began, and
positions change by what it has led to since. A correction of positions alone would do work on springs and gas.

First all impulses are found, then how long ago each acted: as shifts of positions, of which an impulse allows as much
as a whole step would bring. Both are solved by `soft_solver`, island by island. Momentum is kept and no energy is
added. A particle on the ground does not give way to what presses it down: the ground takes that at once, so that the
load goes through.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import prange

from softbody.collision.contact import Contacts, Listing, rows_of, surface_point
from softbody.collision.impulse import velocity_of_point
from softbody.collision.islands import Islands, find_islands
from softbody.collision.pressed import PRESSED, Pressed, never_pressed, note_pressed
from softbody.collision.soft.soft_solver import (
    FREE,
    HELD,
    LIFTED,
    Moved,
    Problem,
    Sharing,
    act_at,
    find_mobilities,
    give,
    new_problem,
    seen,
    solve_island,
)
from softbody.collision.solver.held_boxes import add_push, box_mobilities, keep_what_is_held
from softbody.compiler.jit import jit, jit_lean, jit_threaded
from softbody.geometry.triangle import area_vector
from softbody.linalg.vec import Vec, accumulate, add, cross, dot, load, norm, scale, store, sub
from softbody.model.arrays import NOBODY, Controls, Model, Particles, RigidBodies, State
from softbody.model.material import combined, material_of_ground, material_of_soft
from softbody.model.surface_point import SurfacePoint, at_particle, inverse_mass_at, value_at

# Cosine between an impulse and the normal of a triangle below which it is all but along the triangle.
ALONG_SURFACE = 0.05

# Two sides that overlap by more than they have closed in the step part within some steps, but at no more than a part of
# the speed that the load gives them in one: it could not lift what lies on them by more than the load has pressed it.
PARTING_STEPS, OF_LOAD = 4.0, 0.5

# Without a load, as bodies that start in each other, they part in so many times √(m / (k + nRT / d²)) of a body of mass
# m, springs k, gas nRT and thickness d: a tenth of a metre adds no more energy than a fall of some millimetres.
PARTING_TIMES = 8.0

# The vertical part of a normal from which what is on the ground lies below a box, and not beside it.
STEEP = 0.5

MANY = 100  # contacts from which threads share their islands: they meet once a step, which takes some microseconds

# The part of the most that a body's contacts lack at first that a contact may lack in the end, and after some sweeps;
# the part of an edge to a step that is not worth more than those; and how often impulses, and when they act, are found
# in answer to each other.
ENOUGH, CLOSE, FINE, FIRST_SWEEPS, ROUNDS = 1.0 / 256.0, 1.0 / 4096.0, 1e-4, 3, 4

# The part of an edge, and of the thickness of the thinner side, by which sides may be out of the place that contacts
# were to bring them to, after the sweeps; and the part of that where they are as deep already: it must not add up.
OUT_OF_PLACE, OUT_OF_SIDE, LEAST_ROOM = 1.0 / 64.0, 1.0 / 16.0, 1.0 / 64.0

# Mean edges by which a soft body counts as thick at most where another is in it: skins that are deeper in each other
# than half an edge fold about each other, however thick the bodies are.
SKIN = 2.0


class Bodies(NamedTuple):
    """What the contacts of soft bodies act on."""

    particles: Particles
    boxes: RigidBodies


class Response(NamedTuple):
    """What the response to contacts knows of particles and soft bodies, and remembers within a step."""

    weight_sum: np.ndarray  # (n,) zero, and left so
    owner: np.ndarray  # (n,) NOBODY, and left so
    body: np.ndarray  # (n,) soft body of each particle
    parting_time: np.ndarray  # (b,) [s] see PARTING_TIMES
    load: np.ndarray  # (b,) [m/s] the most that a contact of each body lacks when the step's first sweep begins
    edge_length: np.ndarray  # (b,) [m] mean
    ground: np.ndarray  # (n,) see `Sharing`; FREE, and left so
    lift: np.ndarray  # (2, n) see `Moved`, of impulses [N s] and shifts [kg m]; 0, and left so
    thickness: np.ndarray  # (b + m,) [m] of soft bodies, then of boxes
    pressed: Pressed


def response_memory(start: np.ndarray, boxes: int) -> Response:
    """Return memory for soft bodies whose particles begin at `start` (b + 1,), and some boxes."""
    count, bodies = int(start[-1]), len(start) - 1
    of, owner = np.repeat(np.arange(bodies), np.diff(start)), np.full(count, NOBODY)
    ground, lift = np.full(count, FREE, np.int8), np.zeros((2, count))
    times, load, edges = np.full(bodies, np.inf), np.zeros(bodies), np.zeros(bodies)
    thickness, pressed = np.full(bodies + boxes, np.inf), never_pressed()
    return Response(np.zeros(count), owner, of, times, load, edges, ground, lift, thickness, pressed)


class SubstepContact(NamedTuple):
    """How each contact of soft bodies went on within the step."""

    left: np.ndarray  # (c,) [m] by how much the sides are inside each other where they are to be brought
    acted: np.ndarray  # (c,) bool
    bounces: np.ndarray  # (c,) bool
    is_own: np.ndarray  # (c,) bool: of a body with itself
    room: np.ndarray  # (c,) [m] by how much a may end below where a box was to bring it
    time_since: np.ndarray  # (c,) [s] before the end of the step at which they touched, as far as each alone tells


@jit_lean
def note_on_ground(contacts: Contacts, model: Model, state: State, response: Response) -> None:
    """Note which particles of contacts of soft bodies the ground holds, and which of them a contact may lift."""
    for k in range(contacts.number[1], contacts.number[0]):
        for side in range(2):
            up = contacts.normal[k, 2] if side == 0 else -contacts.normal[k, 2]
            rubs_up = contacts.friction[k] * sqrt(max(0.0, 1.0 - up * up))
            for c in range(3):
                i = contacts.particles[k, side, c]
                if i != NOBODY and state.particle_position[i, 2] <= model.ground_height:
                    lifts = contacts.weights[k, side, c] * up + abs(contacts.weights[k, side, c]) * rubs_up > 0.0
                    response.ground[i] = LIFTED if lifts else max(response.ground[i], HELD)


@jit_lean
def press_on_ground(contacts: Contacts, model: Model, state: State, impulse: np.ndarray, response: Response) -> None:
    """Let the ground give particles what contacts have pressed them on to it with, and rub them by it.

    It is added to `impulse` (n, 3) [N s].
    """
    for k in range(contacts.number[1], contacts.number[0]):
        for side in range(2):
            for c in range(3):
                i = contacts.particles[k, side, c]
                if i == NOBODY or response.ground[i] == FREE:
                    continue
                pressed, inverse_mass = max(0.0, -response.lift[0, i]), model.particle_inverse_mass[i]
                response.ground[i], response.lift[0, i], response.lift[1, i] = FREE, 0.0, 0.0
                v = load(state.particle_velocity, i)
                slide = sqrt(v[0] * v[0] + v[1] * v[1])
                if slide > 0.0 and inverse_mass > 0.0:
                    material = combined(material_of_soft(model, response.body[i]), material_of_ground(model))
                    lost = min(slide, material.friction * pressed * inverse_mass) / slide
                    change = (-lost * v[0], -lost * v[1], 0.0)
                    accumulate(state.particle_velocity, i, change)
                    accumulate(impulse, i, scale(1.0 / inverse_mass, change))
                accumulate(impulse, i, (0.0, 0.0, pressed))


def parting_times(model: Model, controls: Controls) -> np.ndarray:
    """Return in what time (b,) [s] soft bodies part from what they start in; inf where nothing holds them in shape."""
    times = np.full(model.soft_count, np.inf)
    for body in range(model.soft_count):
        particles = model.particle_inverse_mass[slice(*model.soft_particle_start[body : body + 2])]
        springs = model.edge_stiffness[slice(*model.soft_edge_start[body : body + 2])]
        holds = springs.mean() + controls.soft_gas[body] / model.soft_thickness[body] ** 2
        lightness = particles.max() / len(particles)  # of the whole body [1/kg]
        if holds * lightness > 0.0:
            times[body] = PARTING_TIMES / sqrt(holds * lightness)
    return times


@jit
def resolve_contacts(
    contacts: Contacts,
    bodies: Bodies,
    start: Bodies,
    response: Response,
    h: float,
    threads: int | None = None,
    with_boxes: bool | None = True,
) -> np.ndarray:
    """Resolve the contacts of soft bodies that a step of `h` [s] from `start` has led to; §4.2, §4.3.

    Positions and velocities of particles and boxes are changed. Returns (m, 6): the pushes on boxes that stand on
    something, which that is to hold; see `pass_down`. `threads` and `with_boxes`: see `Surfaces`.
    """
    boxes, count = bodies.boxes.inverse_mass.shape[0], contacts.number[0] - contacts.number[1]
    if count == 0:
        return np.zeros((boxes, 6))
    rows = rows_of(contacts, contacts.number, contacts.number[1], contacts.number[0])
    substep = SubstepContact(
        np.empty(count),
        np.zeros(count, np.bool_),
        np.zeros(count, np.bool_),
        np.zeros(count, np.bool_),
        np.zeros(count),
        np.zeros(count),
    )
    impulses, shifts = new_problem(count), new_problem(count)
    look_back(rows, bodies, start, response, substep, impulses, shifts, h)
    _find_enough(rows, response, substep, impulses, shifts, h)
    mobility, stands = _mobility(contacts, rows, bodies, impulses, response, with_boxes)
    shared = mobility, stands, response.ground, response.weight_sum, np.zeros(boxes)
    islands, still = find_islands(rows, bodies.boxes.inverse_mass, response.owner), np.zeros((boxes, 3))
    if threads is None or count < MANY:
        sharing = Sharing(bodies.particles.inverse_mass, bodies.boxes.inverse_mass, *shared)
        for island in range(islands.start.shape[0] - 1):
            _solve(rows, islands, island, bodies, sharing, substep, impulses, shifts, still, response.lift, h)
    else:
        _solve_on_threads(
            rows,
            islands,
            bodies.particles,
            bodies.boxes,
            shared,
            substep,
            impulses,
            shifts,
            still,
            response.lift,
            h,
            threads,
        )
    push = np.zeros((boxes, 6))
    _note_impulses(rows, impulses, push)
    keep_what_is_held(bodies.boxes, mobility, stands, push)
    _note_left(rows, bodies, response, substep, shifts, h)
    return push


@jit_threaded
def _solve_on_threads(
    contacts: Listing,
    islands: Islands,
    particles: Particles,
    boxes: RigidBodies,
    shared: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray],
    substep: SubstepContact,
    impulses: Problem,
    shifts: Problem,
    still: np.ndarray,
    lift: np.ndarray,
    h: float,
    threads: int,
) -> None:
    """Let each thread solve a share of the islands, of about as many contacts."""
    count, number = contacts.depth.shape[0], islands.start.shape[0] - 1
    for share in prange(threads):
        sharing = Sharing(particles.inverse_mass, boxes.inverse_mass, *shared)
        for island in range(number):
            if islands.start[island] * threads // count == share:
                bodies = Bodies(particles, boxes)
                _solve(contacts, islands, island, bodies, sharing, substep, impulses, shifts, still, lift, h)


@jit_lean
def _solve(
    contacts: Listing,
    islands: Islands,
    island: int,
    bodies: Bodies,
    sharing: Sharing,
    substep: SubstepContact,
    impulses: Problem,
    shifts: Problem,
    still: np.ndarray,
    lift: np.ndarray,
    h: float,
) -> None:
    """Find the impulses of one island, and when they act, and let them act.

    The speeds of the sides are seen where they touched; the impulses act on the line through both sides when they act,
    so that they have no moment. (The paper bounces from the masses alone.)
    """
    rows = islands.contact[islands.start[island] : islands.start[island + 1]]
    particles, boxes = bodies
    velocities = Moved(particles.velocity, boxes.velocity, boxes.angular_velocity, lift[0], True)
    positions = Moved(particles.position, boxes.position, still, lift[1], False)
    find_mobilities(contacts, sharing, impulses, shifts, rows)
    _start_anew(contacts, sharing, velocities, positions, substep, impulses, shifts, rows)
    _act_in_line(contacts, bodies, sharing, velocities, positions, impulses, shifts, rows, h)
    for attempt in range(ROUNDS):
        first_sweeps = FIRST_SWEEPS if attempt == 0 else 0
        faster = solve_island(contacts, sharing, velocities, impulses, rows, first_sweeps)
        _allow_shifts(contacts, sharing, impulses, shifts, rows, h)
        further = solve_island(contacts, sharing, positions, shifts, rows, min(2, first_sweeps))
        if _leave_walls(contacts, bodies, sharing, substep, shifts, rows):
            further = solve_island(contacts, sharing, positions, shifts, rows, 0)
        if not (faster or further or attempt == 0):
            break
        _act_in_line(contacts, bodies, sharing, velocities, positions, impulses, shifts, rows, h)
    _add_no_energy(contacts, sharing, substep, velocities, positions, impulses, shifts, rows)


@jit_lean
def _start_anew(
    contacts: Listing,
    sharing: Sharing,
    velocities: Moved,
    positions: Moved,
    substep: SubstepContact,
    impulses: Problem,
    shifts: Problem,
    rows: np.ndarray,
) -> None:
    """Begin with the impulses of the last step, as far as they push, and friction allows."""
    none = (0.0, 0.0, 0.0)
    for k in rows:
        normal, impulse = load(contacts.normal, k), load(contacts.impulse, k)
        push = max(0.0, dot(impulse, normal))
        if not push > 0.0:
            continue
        across = sub(impulse, scale(push, normal))
        limit, length = impulses.friction[k] * push, norm(across)
        impulse = add(scale(push, normal), scale(min(1.0, limit / length) if length > 0.0 else 0.0, across))
        shift = scale(substep.time_since[k], impulse)
        give(contacts, k, sharing, velocities, load(impulses.place, k), impulse, none)
        give(contacts, k, sharing, positions, load(shifts.place, k), shift, none)
        store(impulses.given, k, impulse)
        store(impulses.tried, k, impulse)
        store(shifts.given, k, shift)
        store(shifts.tried, k, shift)


@jit_lean
def _allow_shifts(
    contacts: Listing, sharing: Sharing, impulses: Problem, shifts: Problem, rows: np.ndarray, h: float
) -> None:
    """Let each contact shift its sides along its impulse, by what that brings in a step of `h` [s] at most."""
    for k in rows:
        impulse, normal = load(impulses.given, k), load(contacts.normal, k)
        push = dot(impulse, normal)
        shifts.most[k] = h * push
        if push > 0.0:
            store(shifts.lean, k, sub(scale(1.0 / push, impulse), normal))


@jit_lean
def _leave_walls(
    contacts: Listing,
    bodies: Bodies,
    sharing: Sharing,
    substep: SubstepContact,
    shifts: Problem,
    rows: np.ndarray,
) -> bool:
    """Let fixed boxes shift what is far from where they were to bring it as far as it takes; tell whether any has to.

    Impulses of two walls, as in the acute angle between them, part a particle fast enough from both, and may leave it
    in one. What this does to springs and gas, the way in had done to them. (What moves would have to take an angular
    momentum, and gives way itself.)
    """
    any_is = False
    for k in rows:
        box = contacts.box[k, 1]
        is_wall = box != NOBODY and sharing.box_inverse_mass[box] == 0.0 and substep.acted[k]
        if is_wall and shifts.goal[k] - height(contacts, k, bodies) > substep.room[k]:
            shifts.most[k], any_is = np.inf, True
    return any_is


@jit_lean
def _act_in_line(
    contacts: Listing,
    bodies: Bodies,
    sharing: Sharing,
    velocities: Moved,
    positions: Moved,
    impulses: Problem,
    shifts: Problem,
    rows: np.ndarray,
    h: float,
) -> None:
    """Let each impulse, and its shift, act on the line through both sides, as they were when it acted."""
    for k in rows:
        impulse, shift, normal = load(impulses.given, k), load(shifts.given, k), load(contacts.normal, k)
        push, place = dot(impulse, normal), load(impulses.acts_at, k)
        if push > 0.0:
            place = _place_on_b(contacts, k, bodies, impulse, min(h, max(0.0, dot(shift, normal)) / push))
        store(impulses.next, k, place)
    for k in rows:
        place = load(impulses.next, k)
        act_at(contacts, k, sharing, velocities, impulses, place)
        if contacts.box[k, 1] == NOBODY:
            act_at(contacts, k, sharing, positions, shifts, place)


@jit_lean
def _add_no_energy(
    contacts: Listing,
    sharing: Sharing,
    substep: SubstepContact,
    velocities: Moved,
    positions: Moved,
    impulses: Problem,
    shifts: Problem,
    rows: np.ndarray,
) -> None:
    """Let impulses that would add energy, as several at once or with friction may, act by the part that adds none.

    That is, where some are of bounces, or of a body with itself: those may be at odds with each other, where a skin
    folds fast. What sides are to part by does not count there.
    """
    bounces, is_own = False, False
    for k in rows:
        bounces, is_own = bounces or substep.bounces[k], is_own or substep.is_own[k]
    if not (bounces or is_own):
        return
    none = (0.0, 0.0, 0.0)
    after, before = 0.0, 0.0
    if is_own:
        for k in rows:
            after -= max(0.0, impulses.goal[k]) * dot(load(impulses.given, k), load(contacts.normal, k))
    for k in rows:
        after += dot(load(impulses.given, k), seen(contacts, k, velocities, load(impulses.acts_at, k)))
    for k in rows:
        give(contacts, k, sharing, velocities, load(impulses.acts_at, k), none, load(impulses.given, k))
    for k in rows:
        before += dot(load(impulses.given, k), seen(contacts, k, velocities, load(impulses.acts_at, k)))
    part = 1.0
    if after + before > 0.0 and after > before:
        part = max(0.0, -2.0 * before / (after - before))
    for k in rows:
        impulse, shift, place = load(impulses.given, k), load(shifts.given, k), load(impulses.acts_at, k)
        give(contacts, k, sharing, velocities, place, scale(part, impulse), none)
        store(impulses.given, k, scale(part, impulse))
        if part < 1.0:
            give(contacts, k, sharing, positions, place, scale(part, shift), shift)


@jit_lean
def _note_impulses(contacts: Listing, impulses: Problem, push: np.ndarray) -> None:
    """Note the impulses of contacts, and how they push each box: (m, 6)."""
    for k in range(contacts.depth.shape[0]):
        impulse, box, place = load(impulses.given, k), contacts.box[k, 1], load(impulses.acts_at, k)
        store(contacts.impulse, k, impulse)
        if box != NOBODY:
            add_push(push, box, place, scale(-1.0, impulse))


@jit_lean
def _note_left(
    contacts: Listing, bodies: Bodies, response: Response, substep: SubstepContact, shifts: Problem, h: float
) -> None:
    """Note how deep a step of `h` [s] has left the sides of contacts in each other: of those that are deep."""
    count = contacts.depth.shape[0]
    for k in range(count):
        force = norm(load(contacts.impulse, k)) / h
        if substep.acted[k] or force > 0.0:
            thickness = _thickness(contacts, k, response)
            if contacts.depth[k] > 0.5 * PRESSED * thickness:
                depth = substep.left[k] + shifts.goal[k] - height(contacts, k, bodies)
                note_pressed(response.pressed, contacts, k, depth, thickness, force)


@jit_lean
def _thickness(contacts: Listing, k: int, response: Response) -> float:
    """Return the thickness [m] of the box of contact `k`, or of the thinner of two soft bodies: two edges at most."""
    box, of = contacts.box[k, 1], response.body
    if box != NOBODY:
        return response.thickness[response.edge_length.shape[0] + box]
    a, b = of[contacts.particles[k, 0, 0]], of[contacts.particles[k, 1, 0]]
    return min(response.thickness[a], response.thickness[b], SKIN * _edge_length(contacts, k, response))


@jit_lean
def _room(contacts: Listing, k: int, response: Response, substep: SubstepContact) -> float:
    """Return how far [m] contact `k` may end from the height that it is to come to: less if it is deep already."""
    edge, thickness = _edge_length(contacts, k, response), _thickness(contacts, k, response)
    room = min(OUT_OF_PLACE * edge, OUT_OF_SIDE * thickness)
    return max(room - substep.left[k], LEAST_ROOM * room)


@jit_lean
def _edge_length(contacts: Listing, k: int, response: Response) -> float:
    """Return the mean length of an edge [m] of the soft body of contact `k`; the shorter one of two."""
    edge = np.inf
    for side in range(2):
        if contacts.particles[k, side, 0] != NOBODY:
            edge = min(edge, response.edge_length[response.body[contacts.particles[k, side, 0]]])
    return edge


@jit_lean
def _find_enough(
    contacts: Listing, response: Response, substep: SubstepContact, impulses: Problem, shifts: Problem, h: float
) -> None:
    """Find how much each contact may lack in the end of a step of `h` [s]."""
    for k in range(contacts.depth.shape[0]):
        most = 0.0
        for side in range(2):
            if contacts.particles[k, side, 0] != NOBODY:
                most = max(most, response.load[response.body[contacts.particles[k, side, 0]]])
        enough = max(ENOUGH * most, FINE * _edge_length(contacts, k, response) / h)
        if contacts.box[k, 1] != NOBODY:
            substep.room[k] = _room(contacts, k, response, substep)
            enough = min(enough, substep.room[k] / h)
        impulses.enough[k], shifts.enough[k] = enough, h * enough
        impulses.close[k], shifts.close[k] = CLOSE * most, 4.0 * h * CLOSE * most


@jit
def _mobility(
    contacts: Contacts, rows: Listing, bodies: Bodies, impulses: Problem, response: Response, with_boxes: bool | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return what `box_mobilities` returns for the push with which contacts begin."""
    if with_boxes is None:
        return np.zeros((0, 6, 6)), np.zeros(0, np.bool_)
    return box_mobilities(contacts, bodies.boxes, _first_push(rows, bodies, impulses, response))


@jit
def _first_push(contacts: Listing, bodies: Bodies, impulses: Problem, response: Response) -> np.ndarray:
    """Return (m, 6): the push on each box if all stood still, impulse [N s] and moment about the centre [N m s].

    None on a box with a skin between it and the ground: it stands on that, which lifts it from its other supports.
    """
    push = np.zeros((bodies.boxes.inverse_mass.shape[0], 6))
    boxes = bodies.boxes
    velocities = Moved(bodies.particles.velocity, boxes.velocity, boxes.angular_velocity, response.lift[0], True)
    for k in range(contacts.depth.shape[0]):
        box, a = contacts.box[k, 1], surface_point(contacts, k, 0)
        if box != NOBODY:
            place, normal = load(impulses.place, k), load(contacts.normal, k)
            lack = impulses.goal[k] - dot(seen(contacts, k, velocities, place), normal)
            soft = inverse_mass_at(bodies.particles.inverse_mass, a)
            if lack > 0.0 and soft > 0.0:
                add_push(push, box, place, scale(-lack / soft, normal))
    for k in range(contacts.depth.shape[0]):
        if contacts.box[k, 1] != NOBODY and _lies_below(contacts, k, response):
            push[contacts.box[k, 1]] = 0.0
    return push


@jit_lean
def _lies_below(contacts: Listing, k: int, response: Response) -> bool:
    """Tell whether side a of contact `k` is on the ground, on to which side b presses it: for the most part."""
    on_ground = 0.0
    for c in range(3):
        if response.ground[contacts.particles[k, 0, c]] == HELD:
            on_ground += contacts.weights[k, 0, c]
    return contacts.normal[k, 2] < -STEEP and on_ground > 0.5


@jit_lean
def look_back(
    contacts: Listing,
    bodies: Bodies,
    start: Bodies,
    response: Response,
    substep: SubstepContact,
    impulses: Problem,
    shifts: Problem,
    h: float,
) -> None:
    """Find how fast the sides of each contact came, how fast they are to part, and how far a is to come above b.

    As far as they overlap, but no farther than they have closed in this step: so contact does no work on springs and
    gas. What they overlap besides, they lose within some steps, but more slowly than the load presses them together.
    They bounce by e times the speed at which they come, as far as they did so when the step began: not by what springs,
    gas and weight have added since, or what lies pressed against something would hop on it.
    """
    response.load[:] = 0.0
    lift = response.lift[0]
    velocities = Moved(bodies.particles.velocity, bodies.boxes.velocity, bodies.boxes.angular_velocity, lift, True)
    came = Moved(start.particles.velocity, start.boxes.velocity, start.boxes.angular_velocity, lift, True)
    for k in range(contacts.depth.shape[0]):
        normal = load(contacts.normal, k)
        place, place_before = _place_now(contacts, k, bodies), _place_now(contacts, k, start)
        store(shifts.place, k, place)
        store(shifts.acts_at, k, place)
        approach = max(0.0, -dot(seen(contacts, k, came, place_before), normal))
        closed = max(0.0, -dot(_way(contacts, k, bodies, start, h), normal))
        speed = dot(seen(contacts, k, velocities, place), normal)
        left, slow = max(0.0, contacts.depth[k] - closed), 0.0
        for side in range(2):
            if contacts.particles[k, side, 0] != NOBODY:
                body = response.body[contacts.particles[k, side, 0]]
                response.load[body] = max(response.load[body], -speed)
                slow = max(slow, left / response.parting_time[body])
        i, j = contacts.particles[k, 0, 0], contacts.particles[k, 1, 0]
        substep.is_own[k] = i != NOBODY and j != NOBODY and response.body[i] == response.body[j]
        parting = max(slow, min(left / (PARTING_STEPS * h), -OF_LOAD * speed))
        way = min(contacts.depth[k], closed + h * parting)
        if contacts.depth[k] < 0.0:  # a gap, which other contacts may close, but no further
            parting, way = min(0.0, speed + contacts.depth[k] / h), contacts.depth[k]
        shifts.goal[k], substep.left[k] = height(contacts, k, bodies) + way, contacts.depth[k] - way
        impulses.goal[k] = parting
        substep.acted[k] = speed < parting
        if substep.acted[k]:
            bounce = contacts.restitution[k] * min(-speed, approach)
            substep.bounces[k], impulses.goal[k] = bounce > parting, max(parting, bounce)
            lack = impulses.goal[k] - speed
            substep.time_since[k] = min(h, way / lack)
            place = _place_on_b(contacts, k, bodies, normal, substep.time_since[k])
        impulses.friction[k] = contacts.friction[k]
        store(impulses.place, k, place)
        store(impulses.acts_at, k, place)


@jit_lean
def height(contacts: Contacts | Listing, k: int, bodies: Bodies) -> float:
    """Return how far side a is above b along the normal [m]; of a box, above its centre."""
    a, box = value_at(bodies.particles.position, surface_point(contacts, k, 0)), contacts.box[k, 1]
    if box != NOBODY:
        return dot(sub(a, load(bodies.boxes.position, box)), load(contacts.normal, k))
    b = value_at(bodies.particles.position, surface_point(contacts, k, 1))
    return dot(sub(a, b), load(contacts.normal, k))


@jit_lean
def _way(contacts: Listing, k: int, bodies: Bodies, start: Bodies, h: float) -> Vec:
    """Return how far [m] side a of a contact has moved in a step of `h` [s], seen from b."""
    a, b = surface_point(contacts, k, 0), surface_point(contacts, k, 1)
    place = value_at(bodies.particles.position, a)
    way = sub(place, value_at(start.particles.position, a))
    if contacts.box[k, 1] != NOBODY:
        return sub(way, scale(h, velocity_of_point(bodies.boxes, contacts.box[k, 1], place)))
    return sub(way, sub(value_at(bodies.particles.position, b), value_at(start.particles.position, b)))


@jit_lean
def _place(particles: Particles, point: SurfacePoint, time_since: float) -> Vec:
    """Return where a point of a surface was `time_since` [s] ago, by its velocity now [m]: no impulse changes it."""
    return sub(value_at(particles.position, point), scale(time_since, value_at(particles.velocity, point)))


@jit_lean
def _place_now(contacts: Listing, k: int, bodies: Bodies) -> Vec:
    """Return the place on b that contact `k` has now: see `SubstepContact`."""
    if contacts.box[k, 1] == NOBODY:
        return surface_point(contacts, k, 1).weights
    position = value_at(bodies.particles.position, surface_point(contacts, k, 0))
    return sub(position, load(bodies.boxes.position, contacts.box[k, 1]))


@jit_lean
def _place_on_b(contacts: Listing, k: int, bodies: Bodies, direction: Vec, time_since: float) -> Vec:
    """Return where on b side a was `time_since` [s] ago, seen along a direction: an impulse there has no moment."""
    box = contacts.box[k, 1]
    if box == NOBODY:
        return line_meets_triangle(contacts, k, bodies.particles, direction, time_since)
    place = _place(bodies.particles, surface_point(contacts, k, 0), time_since)
    return sub(add(place, scale(time_since, load(bodies.boxes.velocity, box))), load(bodies.boxes.position, box))


@jit_lean
def line_meets_triangle(contacts: Listing, k: int, particles: Particles, direction: Vec, time_since: float) -> Vec:
    """Return the weights of where the line through side a meets b's triangle, as both were `time_since` [s] ago.

    There the reaction to an impulse along the line has no moment about it. b's own, if the line is all but along the
    plane, at a cosine of 0.05 to its normal or less, or there is none.
    """
    point, (corners, weights) = (
        _place(particles, surface_point(contacts, k, 0), time_since),
        surface_point(contacts, k, 1),
    )
    a, b = (
        _place(particles, at_particle(corners[0]), time_since),
        _place(particles, at_particle(corners[1]), time_since),
    )
    c = _place(particles, at_particle(corners[2]), time_since)
    up = area_vector(a, b, c)
    square, rise = dot(up, up), dot(direction, up)
    if not abs(rise) > ALONG_SURFACE * np.sqrt(square) * norm(direction):
        return weights
    here = add(scale(weights[0], a), add(scale(weights[1], b), scale(weights[2], c)))
    gap = sub(here, point)
    aside = sub(scale(dot(gap, up) / rise, direction), gap)  # from the contact's point, in the plane
    u = 0.5 * dot(cross(sub(a, c), aside), up) / square
    v = 0.5 * dot(cross(sub(b, a), aside), up) / square
    return weights[0] - u - v, weights[1] + u, weights[2] + v
