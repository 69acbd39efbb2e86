"""Number of parts into which a step is split so that no body jumps through another.

A contact is found where a particle, a corner or an edge is inside a body at the end of a step, and it is parted through
the nearest side. So on its way in nothing may go past the middle in one go. Contacts of boxes look ahead, and how far
gravity moves these in a step is their unit of length: it has to be short beside the boxes.
"""

from __future__ import annotations

from math import ceil, inf, sqrt

import numpy as np

from softbody.collision.boxes.box_contacts import penetration_slop
from softbody.collision.broad_phase import near_pairs
from softbody.collision.contact import Contacts, surface_point
from softbody.compiler.jit import jit, jit_lean
from softbody.geometry.sphere import bounding_spheres
from softbody.linalg.vec import add, cross, dot, load, norm, scale, store, sub
from softbody.model.arrays import NOBODY, Controls, Model, State
from softbody.model.sleep_state import SleepState, sleeps
from softbody.model.surface_point import value_at

SHARE = 0.25  # of the thinner body's thickness, which two bodies may move against each other in one part
FALL = 0.0625  # of a box's thickness, by which gravity may move it: boxes at rest may be as deep in each other
MOST_PARTS = 1_000

# The part of a mean edge, or of a box's thickness, by which the sides of a contact may come nearer in one part; and of
# an edge, where a particle is in a box, which knows the face that it came through.
CLOSED, CLOSED_IN_BOX = 0.25, 0.5


@jit
def spheres_of_bodies(model: Model, state: State) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return centre (b + m, 3) [m], radius (b + m,) [m] and whether it is soft of each soft body and then each box."""
    soft, boxes = model.soft_count, model.box_count
    centre = np.empty((soft + boxes, 3))
    radius = np.empty(soft + boxes)
    is_soft = np.zeros(soft + boxes, np.bool_)
    bounding_spheres(state.particle_position, model.soft_particle_start, centre, radius[:soft])
    is_soft[:soft] = True
    spheres_of_boxes(model, state, centre, radius)
    return centre, radius, is_soft


@jit_lean
def spheres_of_boxes(model: Model, state: State, centre: np.ndarray, radius: np.ndarray) -> None:
    """Write the spheres of the boxes into `centre` (b + m, 3) [m] and `radius` (b + m,) [m], after the soft bodies."""
    soft = model.soft_count
    for box in range(model.box_count):
        store(centre, soft + box, load(state.box_position, box))
        radius[soft + box] = 0.5 * norm(load(model.box_size, box))


@jit_lean
def closes_too_far(model: Model, state: State, start: State, contacts: Contacts, h: float) -> bool:
    """Tell whether the sides of a soft body's contact have come nearer by more than CLOSED in a step from `start`.

    A load does that: springs and gas that press a body against something, of which `subdivision` knows nothing.
    """
    now, before, shortest = state.particle_position, start.particle_position, inf
    for body in range(model.soft_count):
        shortest = min(shortest, model.soft_edge_length[body])
    for box in range(model.box_count):
        for c in range(3):
            shortest = min(shortest, model.box_size[box, c])
    for k in range(contacts.number[1], contacts.number[0]):
        box, a = contacts.box[k, 1], surface_point(contacts, k, 0)
        way = sub(value_at(now, a), value_at(before, a))
        if box != NOBODY:
            place = sub(value_at(now, a), load(state.box_position, box))
            of_box = add(load(state.box_velocity, box), cross(load(state.box_angular_velocity, box), place))
            way = sub(way, scale(h, of_box))
        else:
            b = surface_point(contacts, k, 1)
            way = sub(way, sub(value_at(now, b), value_at(before, b)))
        closed = -dot(way, load(contacts.normal, k))
        if closed > CLOSED * shortest and closed > _most_closed(model, contacts, k):
            return True
    return False


@jit_lean
def _most_closed(model: Model, contacts: Contacts, k: int) -> float:
    """Return by how much [m] the sides of a contact may come nearer in one part of a step."""
    box, edge = contacts.box[k, 1], inf
    for side in range(2):
        if contacts.particles[k, side, 0] != NOBODY:
            edge = min(edge, model.soft_edge_length[body_of(model, contacts.particles[k, side, 0])])
    if box == NOBODY:
        return CLOSED * edge
    if contacts.particles[k, 0, 0] == contacts.particles[k, 0, 1] == contacts.particles[k, 0, 2]:
        return CLOSED_IN_BOX * edge
    return CLOSED * min(edge, model.box_size[box, 0], model.box_size[box, 1], model.box_size[box, 2])


@jit_lean
def body_of(model: Model, particle: int) -> int:
    """Return the soft body that a particle is of."""
    low, high = 0, model.soft_count
    while high - low > 1:
        middle = (low + high) // 2
        if model.soft_particle_start[middle] <= particle:
            low = middle
        else:
            high = middle
    return low


@jit
def subdivision(model: Model, controls: Controls, state: State, rest: SleepState | None, h: float) -> int:
    """Return the least number of equal parts of a step of `h` [s], at most MOST_PARTS, in which nothing is jumped over.

    In one part gravity moves no box by more than a FALL of the thickness of the thinnest. No soft body and what is near
    it move against each other by more than a SHARE of the thickness of the thinner. Who sleeps does not move.
    """
    parts = max(_parts_of_fall(model, controls, h), _parts_of_motion(model, state, rest, h))
    return int(ceil(min(parts, MOST_PARTS)))


@jit_lean
def _parts_of_fall(model: Model, controls: Controls, h: float) -> float:
    """Return in how many parts of a step gravity moves boxes by a FALL of the thinnest one's thickness each."""
    thinnest, any_moves = inf, False
    for box in range(model.box_count):
        size = load(model.box_size, box)
        thinnest = min(thinnest, size[0], size[1], size[2])
        any_moves = any_moves or model.box_inverse_mass[box] > 0.0
    return sqrt(penetration_slop(controls, h) / (FALL * thinnest)) if any_moves else 1.0


@jit
def _parts_of_motion(model: Model, state: State, rest: SleepState | None, h: float) -> float:
    """Return in how many parts of a step no soft body moves too far against what is near it."""
    soft, boxes = model.soft_count, model.box_count
    if soft == 0:
        return 1.0
    velocity = np.zeros((soft + boxes, 3))
    spread = np.zeros(soft + boxes)  # of the velocities of a body's points about that of its centre
    thickness = np.empty(soft + boxes)
    fastest, thinnest = 0.0, np.inf
    for body in range(soft):
        thickness[body] = model.soft_thickness[body]
        if sleeps(rest, body):
            continue
        first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
        mean = (0.0, 0.0, 0.0)
        for i in range(first, end):
            mean = add(mean, load(state.particle_velocity, i))
        mean = scale(1.0 / (end - first), mean)
        square = 0.0
        for i in range(first, end):
            apart = sub(load(state.particle_velocity, i), mean)
            square = max(square, dot(apart, apart))
        store(velocity, body, mean)
        spread[body] = sqrt(square)
    for box in range(boxes):
        size = load(model.box_size, box)
        store(velocity, soft + box, load(state.box_velocity, box))
        spread[soft + box] = 0.5 * norm(size) * norm(load(state.box_angular_velocity, box))
        thickness[soft + box] = min(size[0], size[1], size[2])
    for body in range(soft + boxes):
        fastest = max(fastest, norm(load(velocity, body)) + spread[body])
        thinnest = min(thinnest, thickness[body])
    if not 2.0 * h * fastest > SHARE * thinnest:
        return 1.0
    centre, radius, is_soft = spheres_of_bodies(model, state)
    for body in range(soft + boxes):
        radius[body] += h * (norm(load(velocity, body)) + spread[body])
    pairs = near_pairs(centre, radius, is_soft)
    parts = 1.0
    for k in range(pairs.shape[0]):
        a, b = pairs[k, 0], pairs[k, 1]
        closing = norm(sub(load(velocity, a), load(velocity, b))) + spread[a] + spread[b]
        parts = max(parts, h * closing / (SHARE * min(thickness[a], thickness[b])))
    return parts
