"""Response to the contacts of soft bodies and boxes, all at once: none is first, and none comes too late.

Contacts are found at the end of a step, and happened within it: an impulse acts as far back as its contact began, and
positions change by what it has led to since. A correction of positions alone would do work on springs and gas.

Where several contacts share a particle or a box, each has a part of its mass: of a particle in proportion to the
contacts' weights on it, of a box in equal parts (mass splitting: Tonge, Benevolenski and Voroshilov 2012). Each contact
is then solved as if it were alone, by the paper's formulas, and the parts of a body are put together again: its motion
is their mean. So what holds for one contact holds for all: momentum is kept and no energy is added. Nothing depends on
the order of contacts, up to the rounding of sums, and mirrored bodies move as mirror images. Sweeps go on until little
is left of what each body has to be held by. A particle on the ground does not give way to what presses it down: the
ground takes that at once, so that the load goes through.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import prange

from softbody.collision.contact import Contacts, Listing, rows_of, surface_point
from softbody.collision.impulse import (
    apply_impulse,
    inverse_effective_mass_at,
    velocity_change_at,
    velocity_of_point,
)
from softbody.collision.pressed import PRESSED, Pressed, never_pressed, note_pressed
from softbody.collision.solver.held_boxes import add_push, support_compliance
from softbody.compiler.jit import jit, jit_lean, jit_threaded
from softbody.geometry.triangle import area_vector
from softbody.linalg.vec import Vec, accumulate, add, cross, dot, load, norm, scale, store, sub
from softbody.model.arrays import NOBODY, Controls, Model, Particles, RigidBodies, State
from softbody.model.material import combined, friction_impulse, material_of_ground, material_of_soft
from softbody.model.surface_point import SurfacePoint, add_at, at_particle, inverse_mass_at, value_at

# Cosine between an impulse and the normal of a triangle below which it is all but along the triangle.
ALONG_SURFACE = 0.05

# Two sides that overlap by more than they have closed in the step part within some steps, but at no more than a part of
# the speed that the load gives them in one: it could not lift what lies on them by more than the load has pressed it.
PARTING_STEPS, OF_LOAD = 4.0, 0.5

# Without a load, as bodies that start in each other, they part in so many times √(m / (k + nRT / d²)) of a body of mass
# m, springs k, gas nRT and thickness d: a tenth of a metre adds no more energy than a fall of some millimetres.
PARTING_TIMES = 8.0

MANY = 100  # contacts from which threads share them: they meet eight times a step, which takes some microseconds each

# Sweeps over all contacts of a step: at least, and at most. Between them only contacts act that lack more than a part,
# ENOUGH, of the most that a body's contacts lack at first, and that would close by more than a part, FINE, of an edge.
SWEEPS, MOST_SWEEPS, ENOUGH, FINE = 4, 60, 1.0 / 256.0, 1e-3

# The part of an edge, and of the thickness of the thinner side, by which sides may be out of the place that contacts
# were to bring them to, after the sweeps; and the part of that where they are as deep already: it must not add up.
OUT_OF_PLACE, OUT_OF_SIDE, LEAST_ROOM = 1.0 / 64.0, 1.0 / 16.0, 1.0 / 64.0


class Bodies(NamedTuple):
    """What the contacts of soft bodies act on."""

    particles: Particles
    boxes: RigidBodies


class WeightSums(NamedTuple):
    """The sum of the weights of all contacts that have acted in the step: each has its own weight's part of the mass.

    (Mass splitting. A contact that is at rest again keeps its part: rounding must not decide on parts.)
    """

    particle: np.ndarray  # (n,)
    box: np.ndarray  # (m,) where each contact has weight 1


class Response(NamedTuple):
    """What the response to contacts knows of particles and soft bodies, and remembers within a step."""

    weight_sum: np.ndarray  # (n,) zero, and left so
    body: np.ndarray  # (n,) soft body of each particle
    parting_time: np.ndarray  # (b,) [s] see PARTING_TIMES
    load: np.ndarray  # (b,) [m/s] the most that a contact of each body lacks when the step's first sweep begins
    edge_length: np.ndarray  # (b,) [m] mean
    on_ground: np.ndarray  # (n,) bool: which particles of contacts the ground holds; False, and left so
    ground_impulse: np.ndarray  # (n,) [N s] that the ground gives them for what presses them down; 0, and left so
    thickness: np.ndarray  # (b + m,) [m] of soft bodies, then of boxes
    pressed: Pressed


def response_memory(start: np.ndarray, boxes: int) -> Response:
    """Return memory for soft bodies whose particles begin at `start` (b + 1,), and some boxes."""
    count, bodies = int(start[-1]), len(start) - 1
    of = np.repeat(np.arange(bodies), np.diff(start))
    on_ground = np.zeros(count, np.bool_)
    times, load, edges = np.full(bodies, np.inf), np.zeros(bodies), np.zeros(bodies)
    thickness, pressed = np.full(bodies + boxes, np.inf), never_pressed()
    return Response(np.zeros(count), of, times, load, edges, on_ground, np.zeros(count), thickness, pressed)


class SubstepContact(NamedTuple):
    """How each contact of soft bodies went on within the step."""

    velocity: np.ndarray  # (c, 3) of side a, seen from b [m/s]
    approach: np.ndarray  # (c,) speed at which the sides came nearer when the step began, or 0 [m/s]
    parting: np.ndarray  # (c,) speed at which they are to part at least, without a bounce [m/s]
    target_height: np.ndarray  # (c,) how far a is to be above b, along the normal [m]
    left: np.ndarray  # (c,) [m] by how much they are inside each other then
    acted: np.ndarray  # (c,) bool
    acts: np.ndarray  # (c,) bool: in this sweep
    enough: np.ndarray  # (c,) [m/s] that it may lack after the first sweeps
    time_since: np.ndarray  # (c,) [s] before the end of the step at which the next impulse acts
    place: np.ndarray  # (c, 3) on b: weights on a triangle's corners, or from a box's centre [m]; where they touched
    impulse: np.ndarray  # (c, 3) on a, the next one [N s]
    impulse_place: np.ndarray  # (c, 3) where on b it acts
    compliance: np.ndarray  # (m,) the part of a push that moves each box, and is not held by what it stands on
    held: np.ndarray  # (m, 6) impulse [N s] and moment [N m s] on each box that is


@jit_lean
def note_on_ground(contacts: Contacts, model: Model, state: State, response: Response) -> None:
    """Note which particles of contacts of soft bodies the ground holds."""
    for k in range(contacts.number[1], contacts.number[0]):
        for side in range(2):
            for c in range(3):
                i = contacts.particles[k, side, c]
                if i != NOBODY:
                    response.on_ground[i] = state.particle_position[i, 2] <= model.ground_height


@jit_lean
def press_on_ground(contacts: Contacts, model: Model, state: State, impulse: np.ndarray, response: Response) -> None:
    """Let the ground give particles what contacts have pressed them on to it with, and rub them by it.

    It is added to `impulse` (n, 3) [N s].
    """
    for k in range(contacts.number[1], contacts.number[0]):
        for side in range(2):
            for c in range(3):
                i = contacts.particles[k, side, c]
                if i == NOBODY or not response.on_ground[i]:
                    continue
                pressed, inverse_mass = response.ground_impulse[i], model.particle_inverse_mass[i]
                response.on_ground[i], response.ground_impulse[i] = False, 0.0
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
        np.empty((count, 3)),
        np.empty(count),
        np.empty(count),
        np.empty(count),
        np.empty(count),
        np.zeros(count, np.bool_),
        np.zeros(count, np.bool_),
        np.zeros(count),
        np.zeros(count),
        np.empty((count, 3)),
        np.empty((count, 3)),
        np.empty((count, 3)),
        np.ones(boxes),
        np.zeros((boxes, 6)),
    )
    look_back(rows, bodies, start, response, substep, h)
    _loosen_boxes(contacts, rows, bodies, substep, with_boxes)
    sums = WeightSums(response.weight_sum, np.zeros(boxes))
    for sweep in range(MOST_SWEEPS):
        if sweep == SWEEPS:
            _find_enough(rows, response, substep, h)
        if not exchange_impulses(rows, bodies, sums, response, substep, h, threads):
            break
    _put_right(rows, bodies, sums, response, substep)
    _note_left(rows, bodies, response, substep, h)
    return substep.held


@jit_lean
def _note_left(contacts: Listing, bodies: Bodies, response: Response, substep: SubstepContact, h: float) -> None:
    """Note how deep a step of `h` [s] has left the sides of contacts in each other: of those that are deep."""
    count = contacts.depth.shape[0]
    for k in range(count):
        if substep.acted[k]:
            thickness = _thickness(contacts, k, response)
            if contacts.depth[k] > 0.5 * PRESSED * thickness:
                depth = substep.left[k] + substep.target_height[k] - height(contacts, k, bodies)
                force = norm(load(contacts.impulse, k)) / h
                note_pressed(response.pressed, contacts, k, depth, thickness, force)


@jit_lean
def _thickness(contacts: Listing, k: int, response: Response) -> float:
    """Return the thickness [m] of the box of contact `k`, or of the thinner of two soft bodies."""
    box, of = contacts.box[k, 1], response.body
    if box != NOBODY:
        return response.thickness[response.edge_length.shape[0] + box]
    a, b = of[contacts.particles[k, 0, 0]], of[contacts.particles[k, 1, 0]]
    return min(response.thickness[a], response.thickness[b])


@jit_lean
def _put_right(
    contacts: Listing, bodies: Bodies, sums: WeightSums, response: Response, substep: SubstepContact
) -> None:
    """Move particles that are far below the height over a fixed box that contacts were to bring them to.

    Impulses of contacts that act at different times, as in the acute angle of two walls, part them fast enough, and may
    leave them there. What this does to springs and gas, the way in had done to them. (What moves would have to take an
    angular momentum, and gives way itself.)
    """
    mass = bodies.particles.inverse_mass
    for _ in range(MOST_SWEEPS):
        is_right = True
        for k in range(contacts.depth.shape[0]):
            box = contacts.box[k, 1]
            substep.acts[k] = substep.acted[k] and box != NOBODY and bodies.boxes.inverse_mass[box] == 0.0
            if substep.acts[k]:
                gap = substep.target_height[k] - height(contacts, k, bodies)
                substep.acts[k] = gap > _room(contacts, k, response, substep)
                store(substep.impulse, k, scale(gap, load(contacts.normal, k)))
            if substep.acts[k]:
                is_right = False
                _add_weights(contacts, k, sums, load(substep.place, k))
        if is_right:
            break
        for k in range(contacts.depth.shape[0]):
            if substep.acts[k]:
                a, up = surface_point(contacts, k, 0), contacts.normal[k, 2]
                inverse_mass = _split_inverse_mass(mass, sums.particle, response.on_ground, a, up)
                scaled = 1.0 / inverse_mass if inverse_mass > 0.0 else 0.0
                store(substep.impulse, k, scale(scaled, load(substep.impulse, k)))
        for k in range(contacts.depth.shape[0]):
            if substep.acts[k]:
                _move(bodies.particles, surface_point(contacts, k, 0), load(substep.impulse, k), response)
                _clear_weights(contacts, k, sums)


@jit_lean
def _room(contacts: Listing, k: int, response: Response, substep: SubstepContact) -> float:
    """Return how far [m] contact `k` may end from the height that it is to come to: less if it is deep already."""
    edge, thickness = _edge_length(contacts, k, response), _thickness(contacts, k, response)
    room = min(OUT_OF_PLACE * edge, OUT_OF_SIDE * thickness)
    return max(room - substep.left[k], LEAST_ROOM * room)


@jit_lean
def _move(particles: Particles, point: SurfacePoint, way: Vec, response: Response) -> None:
    """Move the particles of a point by `way` [kg m] over their masses; none into the ground."""
    for c in range(3):
        i, share = point.particles[c], scale(point.weights[c], way)
        if response.on_ground[i] and share[2] < 0.0:
            share = (share[0], share[1], 0.0)
        accumulate(particles.position, i, scale(particles.inverse_mass[i], share))


@jit_lean
def _edge_length(contacts: Listing, k: int, response: Response) -> float:
    """Return the mean length of an edge [m] of the soft body of contact `k`; the shorter one of two."""
    edge = np.inf
    for side in range(2):
        if contacts.particles[k, side, 0] != NOBODY:
            edge = min(edge, response.edge_length[response.body[contacts.particles[k, side, 0]]])
    return edge


@jit_lean
def _find_enough(contacts: Listing, response: Response, substep: SubstepContact, h: float) -> None:
    """Find how much each contact may lack in a step of `h` [s] once the first sweeps are made."""
    for k in range(contacts.depth.shape[0]):
        most = 0.0
        for side in range(2):
            if contacts.particles[k, side, 0] != NOBODY:
                most = max(most, response.load[response.body[contacts.particles[k, side, 0]]])
        enough = max(ENOUGH * most, FINE * _edge_length(contacts, k, response) / h)
        if contacts.box[k, 1] != NOBODY:  # (where soft bodies meet both give way, and more sweeps let them tremble)
            enough = min(enough, _room(contacts, k, response, substep) / h)
        substep.enough[k] = enough


@jit
def _loosen_boxes(
    contacts: Contacts, rows: Listing, bodies: Bodies, substep: SubstepContact, with_boxes: bool | None
) -> None:
    """Find which part of a push moves each box, and is not held by what it stands on."""
    if with_boxes is None:
        return
    compliance = support_compliance(contacts, bodies.boxes, _first_push(rows, bodies, substep))
    for box in range(compliance.shape[0]):
        substep.compliance[box] = compliance[box]


@jit
def _first_push(contacts: Listing, bodies: Bodies, substep: SubstepContact) -> np.ndarray:
    """Return (m, 6): the push on each box if all stood still, impulse [N s] and moment about the centre [N m s]."""
    push = np.zeros((substep.compliance.shape[0], 6))
    for k in range(contacts.depth.shape[0]):
        box, a = contacts.box[k, 1], surface_point(contacts, k, 0)
        if box != NOBODY:
            place = load(substep.place, k)
            lack = _velocity_deficit(contacts, k, substep, _relative_velocity(contacts, k, bodies, place))
            soft = inverse_mass_at(bodies.particles.inverse_mass, a)
            if lack > 0.0 and soft > 0.0:
                add_push(push, box, place, scale(-lack / soft, load(contacts.normal, k)))
    return push


@jit_lean
def look_back(
    contacts: Listing, bodies: Bodies, start: Bodies, response: Response, substep: SubstepContact, h: float
) -> None:
    """Find how fast the sides of each contact came, how fast they are to part, and how far a is to come above b.

    As far as they overlap, but no farther than they have closed in this step: so contact does no work on springs and
    gas. What they overlap besides, they lose within some steps, but more slowly than the load presses them together.
    """
    response.load[:] = 0.0
    for k in range(contacts.depth.shape[0]):
        normal = load(contacts.normal, k)
        place, place_before = _place_now(contacts, k, bodies), _place_now(contacts, k, start)
        substep.approach[k] = max(0.0, -dot(_relative_velocity(contacts, k, start, place_before), normal))
        closed = max(0.0, -dot(_way(contacts, k, bodies, start, h), normal))
        left, load_speed, slow = (
            max(0.0, contacts.depth[k] - closed),
            -dot(_relative_velocity(contacts, k, bodies, place), normal),
            0.0,
        )
        for side in range(2):
            if contacts.particles[k, side, 0] != NOBODY:
                body = response.body[contacts.particles[k, side, 0]]
                response.load[body] = max(response.load[body], load_speed)
                slow = max(slow, left / response.parting_time[body])
        substep.parting[k] = max(slow, min(left / (PARTING_STEPS * h), OF_LOAD * load_speed))
        way = min(contacts.depth[k], closed + h * substep.parting[k])
        substep.target_height[k], substep.left[k] = height(contacts, k, bodies) + way, contacts.depth[k] - way
        store(substep.place, k, place)


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


@jit
def exchange_impulses(
    contacts: Listing,
    bodies: Bodies,
    sums: WeightSums,
    response: Response,
    substep: SubstepContact,
    h: float,
    threads: int | None,
) -> bool:
    """Let the sides of contacts that do not part as fast as they must do so, and take off their sliding.

    One impulse along the normal and friction against the sliding, by the law of contact. A point on a surface gives way
    by Σ w²/m, a box by 1/M + n · [(I⁻¹ (r × n)) × r] (the paper bounces from the masses alone). It acts so long before
    the end of the step of `h` [s] that, with the velocities, the positions become what they must; a single one changes
    no angular momentum. (A box does not turn by that.) Returns if any contact acts.
    """
    count = contacts.depth.shape[0]
    if threads is None or count < MANY:
        active = _look(contacts, bodies, substep, h, (0, count))
    else:
        active = _look_on_threads(contacts, bodies.particles, bodies.boxes, substep, h, threads)
    for k in range(count):
        if substep.acted[k]:
            _add_weights(contacts, k, sums, load(substep.place, k))
    # All impulses before any acts.
    if threads is None or count < MANY:
        _find_impulses(contacts, bodies, sums, response.on_ground, substep, (0, count))
    else:
        on_ground = response.on_ground
        _find_impulses_on_threads(contacts, bodies.particles, bodies.boxes, sums, on_ground, substep, threads)
    for k in range(count):
        _apply_impulse(contacts, k, bodies, response, substep)
        _clear_weights(contacts, k, sums)
    return active


@jit_threaded
def _look_on_threads(
    contacts: Listing, particles: Particles, boxes: RigidBodies, substep: SubstepContact, h: float, threads: int
) -> bool:
    active = np.zeros(threads, np.bool_)
    for share in prange(threads):
        active[share] = _look(contacts, Bodies(particles, boxes), substep, h, _rows_of_share(contacts, share, threads))
    return bool(active.any())


@jit_threaded
def _find_impulses_on_threads(
    contacts: Listing,
    particles: Particles,
    boxes: RigidBodies,
    sums: WeightSums,
    on_ground: np.ndarray,
    substep: SubstepContact,
    threads: int,
) -> None:
    for share in prange(threads):
        rows = _rows_of_share(contacts, share, threads)
        _find_impulses(contacts, Bodies(particles, boxes), sums, on_ground, substep, rows)


@jit_lean
def _rows_of_share(contacts: Listing, share: int, threads: int) -> tuple[int, int]:
    count = contacts.depth.shape[0]
    return count * share // threads, count * (share + 1) // threads


@jit_lean
def _look(contacts: Listing, bodies: Bodies, substep: SubstepContact, h: float, rows: tuple[int, int]) -> bool:
    """Find when and where contacts act that part too slowly, and how fast they part there; return if any does."""
    active = False
    for k in range(rows[0], rows[1]):
        u = _relative_velocity(contacts, k, bodies, load(substep.place, k))
        lack = _velocity_deficit(contacts, k, substep, u)
        substep.acts[k] = lack > substep.enough[k]
        if substep.acts[k]:
            substep.time_since[k] = min(h, max(0.0, substep.target_height[k] - height(contacts, k, bodies)) / lack)
            if not substep.acted[k]:  # and stay: where rounding decides if they act once more, nothing may jump
                place = _place_on_b(contacts, k, bodies, load(contacts.normal, k), substep.time_since[k])
                u = _relative_velocity(contacts, k, bodies, place)
                store(substep.place, k, place)
            substep.acted[k] = active = True
        store(substep.velocity, k, u)
    return active


@jit_lean
def _find_impulses(
    contacts: Listing,
    bodies: Bodies,
    sums: WeightSums,
    on_ground: np.ndarray,
    substep: SubstepContact,
    rows: tuple[int, int],
) -> None:
    """Find the impulses of contacts that part too slowly, and where on b they act; none of the others."""
    for k in range(rows[0], rows[1]):
        store(substep.impulse, k, (0.0, 0.0, 0.0))
        if substep.acts[k]:
            impulse = _impulse(contacts, k, bodies, sums, on_ground, substep)
            store(substep.impulse, k, impulse)
            store(substep.impulse_place, k, _place_on_b(contacts, k, bodies, impulse, substep.time_since[k]))


@jit_lean
def _velocity_deficit(contacts: Listing, k: int, substep: SubstepContact, velocity: Vec) -> float:
    """Return the speed [m/s] that a velocity of side a, seen from b, lacks of that at which they are to part; or ≤ 0.

    That is e times the speed at which they come, as far as they did so when the step began: not of what springs, gas
    and weight have added since, or what lies pressed against something would hop on it.
    """
    speed = dot(velocity, load(contacts.normal, k))
    if not speed < substep.parting[k]:
        return 0.0
    return max(substep.parting[k], contacts.restitution[k] * min(-speed, substep.approach[k])) - speed


@jit_lean
def _apply_impulse(contacts: Listing, k: int, bodies: Bodies, response: Response, substep: SubstepContact) -> None:
    """Apply the impulse of contact `k` to both sides, and what it has led to since."""
    (particles, boxes), box, time_since = bodies, contacts.box[k, 1], substep.time_since[k]
    impulse, place = load(substep.impulse, k), load(substep.impulse_place, k)
    if impulse[0] == 0.0 and impulse[1] == 0.0 and impulse[2] == 0.0:
        return
    back = scale(-1.0, impulse)
    _push(particles, surface_point(contacts, k, 0), impulse, time_since, response)
    if box == NOBODY:
        _push(particles, SurfacePoint(surface_point(contacts, k, 1).particles, place), back, time_since, response)
    else:
        # What supports of the box will hold does not move it.
        normal = load(contacts.normal, k)
        held = scale((1.0 - substep.compliance[box]) * dot(back, normal), normal)
        add_push(substep.held, box, place, held)
        back = sub(back, held)
        apply_impulse(boxes, box, add(load(boxes.position, box), place), back)
        accumulate(boxes.position, box, scale(time_since * boxes.inverse_mass[box], back))
    store(contacts.impulse, k, add(load(contacts.impulse, k), impulse))


@jit_lean
def _push(particles: Particles, point: SurfacePoint, impulse: Vec, time_since: float, response: Response) -> None:
    """Change the velocities of a point by an impulse [N s] of `time_since` [s] ago, and what they have led to.

    What presses a particle on to the ground, the ground takes.
    """
    i, j, k = point.particles
    if not (response.on_ground[i] or response.on_ground[j] or response.on_ground[k]):
        add_at(particles.velocity, particles.inverse_mass, point, impulse)
        add_at(particles.position, particles.inverse_mass, point, scale(time_since, impulse))
        return
    for c in range(3):
        i, share = point.particles[c], scale(point.weights[c], impulse)
        if response.on_ground[i] and share[2] < 0.0:
            response.ground_impulse[i] -= share[2]
            share = (share[0], share[1], 0.0)
        accumulate(particles.velocity, i, scale(particles.inverse_mass[i], share))
        accumulate(particles.position, i, scale(time_since * particles.inverse_mass[i], share))


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
def _relative_velocity(contacts: Listing, k: int, bodies: Bodies, place: Vec) -> Vec:
    """Return the velocity [m/s] of side a of a contact, seen from a `place` on b: see `SubstepContact`."""
    velocity, box = value_at(bodies.particles.velocity, surface_point(contacts, k, 0)), contacts.box[k, 1]
    if box == NOBODY:
        b = SurfacePoint(surface_point(contacts, k, 1).particles, place)
        return sub(velocity, value_at(bodies.particles.velocity, b))
    return sub(velocity, velocity_of_point(bodies.boxes, box, add(load(bodies.boxes.position, box), place)))


@jit_lean
def _impulse(
    contacts: Listing, k: int, bodies: Bodies, sums: WeightSums, on_ground: np.ndarray, substep: SubstepContact
) -> Vec:
    """Return the impulse [N s] on side a of contact `k`, whose sides part too slowly; none if neither can move."""
    particles, boxes = bodies
    box, normal, place = contacts.box[k, 1], load(contacts.normal, k), load(substep.place, k)
    u = load(substep.velocity, k)
    # The normal impulse, by the inverse effective mass of both sides.
    a, up = surface_point(contacts, k, 0), normal[2]
    soft = _split_inverse_mass(particles.inverse_mass, sums.particle, on_ground, a, up)
    if box == NOBODY:
        b = SurfacePoint(surface_point(contacts, k, 1).particles, place)
        soft += _split_inverse_mass(particles.inverse_mass, sums.particle, on_ground, b, -up)
    else:
        place = add(load(boxes.position, box), place)
    inverse_mass = soft
    if box != NOBODY:
        inverse_mass += substep.compliance[box] * sums.box[box] * inverse_effective_mass_at(boxes, box, place, normal)
    if not inverse_mass > 0.0:
        return (0.0, 0.0, 0.0)
    j = _velocity_deficit(contacts, k, substep, u) / inverse_mass
    impulse = scale(j, normal)
    if not contacts.friction[k] > 0.0:
        return impulse
    # Friction against the sliding that the normal impulse leaves: it may turn a box, and so move its point aside.
    if box != NOBODY:
        u = add(u, scale(substep.compliance[box] * sums.box[box], velocity_change_at(boxes, box, place, impulse)))
    slide = sub(u, scale(dot(u, normal), normal))
    sliding = norm(slide)
    if not sliding > 0.0:
        return impulse
    along, inverse_mass = scale(1.0 / sliding, slide), soft
    if box != NOBODY:
        inverse_mass += sums.box[box] * inverse_effective_mass_at(boxes, box, place, along)
    return sub(impulse, scale(friction_impulse(sliding, inverse_mass, contacts.friction[k] * j), along))


@jit_lean
def _add_weights(contacts: Listing, k: int, sums: WeightSums, place: Vec) -> None:
    """Add the weights of a contact, at a `place` on b, to the sums of its particles, and 1 to that of its box."""
    particles, weights, box = contacts.particles, contacts.weights, contacts.box[k, 1]
    for c in range(3):
        sums.particle[particles[k, 0, c]] += weights[k, 0, c]
        if box == NOBODY:
            sums.particle[particles[k, 1, c]] += abs(place[c])
    if box != NOBODY:
        sums.box[box] += 1.0


@jit_lean
def _clear_weights(contacts: Listing, k: int, sums: WeightSums) -> None:
    """Make what `_add_weights` has added zero."""
    particles, box = contacts.particles, contacts.box[k, 1]
    for c in range(3):
        sums.particle[particles[k, 0, c]] = 0.0
        if box == NOBODY:
            sums.particle[particles[k, 1, c]] = 0.0
    if box != NOBODY:
        sums.box[box] = 0.0


@jit_lean
def _split_inverse_mass(
    inverse_mass: np.ndarray, weight_sum: np.ndarray, on_ground: np.ndarray, point: SurfacePoint, up: float
) -> float:
    """Return Σ w²/m [1/kg] of a point that has the part |w| / (sum of weights) of the mass of each of its particles.

    `up` is the vertical part of the unit impulse on it: what presses a particle on to the ground does not move it.
    """
    result = 0.0
    for c in range(3):
        i, w = point.particles[c], point.weights[c]
        part = abs(w) * weight_sum[i] * inverse_mass[i]
        result += part * (1.0 - up * up) if on_ground[i] and w * up < 0.0 else part
    return result


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
