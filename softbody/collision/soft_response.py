"""What happens to soft bodies and boxes that touch? All contacts at once: none is first, and none comes too late.

Where several contacts share a particle or a box, each has a part of its mass: of a particle in proportion to the
contacts' weights on it, of a box in equal parts (mass splitting: Tonge, Benevolenski and Voroshilov 2012). Each contact
is then solved as if it were alone, by the paper's formulas, and the parts of a body are put together again: its motion
is their mean. So what holds for one contact holds for all: momentum is kept and no energy is added. Nothing depends on
the order of contacts, up to the rounding of sums, and mirrored bodies move as mirror images.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.collision.impulse import apply_impulse, point_mobility, point_velocity
from softbody.collision.patch import Corners, patch_point, push_patch
from softbody.geometry.triangle import area_vector
from softbody.jit import jit, jit_lean
from softbody.quaternion import load_quaternion, rotate_diagonal
from softbody.state import RigidBodies
from softbody.vec import Vec, accumulate, add, cross, dot, load, norm, scale, store, sub

NO_BOX = -1

# Cosine between an impulse and the normal of a skin below which it is all but along the skin: left to `move_apart`.
ALONG_SKIN = 0.05

SAME_PLACE = 1e-12  # of a triangle's size: closer than this, two points coincide


class SoftContacts(NamedTuple):
    """Where a point of a skin touches another skin or a box, in the order found; only the first rows are set."""

    first: np.ndarray  # (c, 3) particles of the point: of a triangle, an edge (i, j, j) or a particle (i, i, i)
    first_weights: np.ndarray  # (c, 3) barycentric
    second: np.ndarray  # (c, 3) corners of the triangle of the other skin; of no meaning for a box
    second_weights: np.ndarray  # (c, 3)
    box: np.ndarray  # (c,) or NO_BOX
    normal: np.ndarray  # (c, 3) unit, from the second to the first
    depth: np.ndarray  # (c,) [m]
    restitution: np.ndarray  # (c,) combined
    friction: np.ndarray  # (c,) combined
    speed: np.ndarray  # (c, 3) [m/s] of the first point seen from the second, before the impulses


@jit
def room_for_soft_contacts(capacity: int) -> SoftContacts:
    """Return arrays for so many contacts."""
    return SoftContacts(
        np.empty((capacity, 3), np.int64),
        np.empty((capacity, 3)),
        np.empty((capacity, 3), np.int64),
        np.empty((capacity, 3)),
        np.empty(capacity, np.int64),
        np.empty((capacity, 3)),
        np.empty(capacity),
        np.empty(capacity),
        np.empty(capacity),
        np.empty((capacity, 3)),
    )


@jit
def with_room(contacts: SoftContacts, count: int, capacity: int) -> SoftContacts:
    """Return a copy of the first `count` contacts, with room for `capacity`."""
    longer = room_for_soft_contacts(capacity)
    for k in range(count):
        first, second = _corners(contacts.first, k), _corners(contacts.second, k)
        weights, others = load(contacts.first_weights, k), load(contacts.second_weights, k)
        box, normal, depth = contacts.box[k], load(contacts.normal, k), contacts.depth[k]
        restitution, friction = contacts.restitution[k], contacts.friction[k]
        write_contact(longer, k, first, weights, second, others, box, normal, depth, restitution, friction)
    return longer


@jit_lean
def write_contact(
    contacts: SoftContacts,
    k: int,
    first: Corners,
    first_weights: Vec,
    second: Corners,
    second_weights: Vec,
    box: int,
    normal: Vec,
    depth: float,
    restitution: float,
    friction: float,
) -> None:
    """Write contact `k`, if there is room for it."""
    if k >= contacts.depth.shape[0]:
        return
    for c in range(3):
        contacts.first[k, c], contacts.second[k, c] = first[c], second[c]
    store(contacts.first_weights, k, first_weights)
    store(contacts.second_weights, k, second_weights)
    contacts.box[k] = box
    store(contacts.normal, k, normal)
    contacts.depth[k] = depth
    contacts.restitution[k], contacts.friction[k] = restitution, friction


@jit
def part_contacts(
    contacts: SoftContacts,
    count: int,
    inverse_mass: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
    bodies: RigidBodies,
    crowd: np.ndarray,
) -> None:
    """Move what overlaps apart, and then turn what approaches back; paper §4.2, §4.3.

    `inverse_mass` (n,) [1/kg] of the particles; their `position` and `velocity` (n, 3) [m], [m/s], and those of the
    boxes, are changed. `crowd` (n,) is zero, and left so.
    """
    box_crowd = np.zeros(bodies.inverse_mass.shape[0])
    move_apart(contacts, count, inverse_mass, position, bodies, crowd, box_crowd)
    box_crowd[:] = 0.0
    turn_back(contacts, count, inverse_mass, position, velocity, bodies, crowd, box_crowd)


@jit_lean
def move_apart(
    contacts: SoftContacts,
    count: int,
    inverse_mass: np.ndarray,
    position: np.ndarray,
    bodies: RigidBodies,
    crowd: np.ndarray,
    box_crowd: np.ndarray,
) -> None:
    """Move both sides of each contact apart along its normal, by its depth, in proportion to how easily they move.

    (The paper: half each, for equal masses.) Boxes move without turning.
    """
    for k in range(count):
        _add_to_crowd(contacts, k, crowd, box_crowd)
    for k in range(count):
        box, normal = contacts.box[k], load(contacts.normal, k)
        give = _mobility(inverse_mass, crowd, contacts.first, contacts.first_weights, k)
        if box == NO_BOX:
            give += _mobility(inverse_mass, crowd, contacts.second, contacts.second_weights, k)
        else:
            give += bodies.inverse_mass[box] * box_crowd[box]
        if give > 0.0:
            shift = scale(contacts.depth[k] / give, normal)
            push_patch(position, inverse_mass, _corners(contacts.first, k), load(contacts.first_weights, k), shift)
            back = scale(-1.0, shift)
            if box == NO_BOX:
                weights = load(contacts.second_weights, k)
                push_patch(position, inverse_mass, _corners(contacts.second, k), weights, back)
            else:
                accumulate(bodies.position, box, scale(bodies.inverse_mass[box], back))
    for k in range(count):
        _leave_crowd(contacts, k, crowd)


@jit_lean
def turn_back(
    contacts: SoftContacts,
    count: int,
    inverse_mass: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
    bodies: RigidBodies,
    crowd: np.ndarray,
    box_crowd: np.ndarray,
) -> None:
    """Where the two sides of a contact approach, let them part with e times that speed, and take off their sliding.

    One impulse along the normal, j = (1 + e) approach / mobility, and Coulomb friction of at most μ j against the
    sliding. A patch gives way by Σ w²/m, a box by 1/M + n · [(I⁻¹ (r × n)) × r] (the paper bounces from the masses
    alone).
    """
    for k in range(count):
        box = contacts.box[k]
        point = patch_point(position, _corners(contacts.first, k), load(contacts.first_weights, k))
        speed = patch_point(velocity, _corners(contacts.first, k), load(contacts.first_weights, k))
        if box == NO_BOX:
            other = patch_point(velocity, _corners(contacts.second, k), load(contacts.second_weights, k))
        else:
            other = point_velocity(bodies, box, point)
        store(contacts.speed, k, sub(speed, other))
        if dot(sub(speed, other), load(contacts.normal, k)) < 0.0:
            _add_to_crowd(contacts, k, crowd, box_crowd)
    for k in range(count):
        box, normal, u = contacts.box[k], load(contacts.normal, k), load(contacts.speed, k)
        approach = -dot(u, normal)
        if not approach > 0.0:
            continue
        first, weights = _corners(contacts.first, k), load(contacts.first_weights, k)
        point = patch_point(position, first, weights)
        soft = _mobility(inverse_mass, crowd, contacts.first, contacts.first_weights, k)
        if box == NO_BOX:
            soft += _mobility(inverse_mass, crowd, contacts.second, contacts.second_weights, k)
        give = soft
        if box != NO_BOX:
            give += box_crowd[box] * point_mobility(bodies, box, point, normal)
        if not give > 0.0:
            continue
        j = (1.0 + contacts.restitution[k]) * approach / give
        impulse = scale(j, normal)
        if contacts.friction[k] > 0.0:
            if box != NO_BOX:  # its push turns a box, and so may move its point along the skin
                u = add(u, scale(box_crowd[box], _gain(bodies, box, point, impulse)))
            slide = sub(u, scale(dot(u, normal), normal))
            sliding = norm(slide)
            if sliding > 0.0:
                along, give = scale(1.0 / sliding, slide), soft
                if box != NO_BOX:
                    give += box_crowd[box] * point_mobility(bodies, box, point, along)
                impulse = sub(impulse, scale(min(contacts.friction[k] * j, sliding / give), along))
        back = scale(-1.0, impulse)
        if box == NO_BOX:
            second = _corners(contacts.second, k)
            meets, met = _met_weights(position, point, impulse, second, load(contacts.second_weights, k))
            if not meets:
                continue
            push_patch(velocity, inverse_mass, second, met, back)
        else:
            apply_impulse(bodies, box, point, back)
        push_patch(velocity, inverse_mass, first, weights, impulse)
    for k in range(count):
        _leave_crowd(contacts, k, crowd)


@jit_lean
def _corners(corners: np.ndarray, k: int) -> Corners:
    return corners[k, 0], corners[k, 1], corners[k, 2]


@jit_lean
def _add_to_crowd(contacts: SoftContacts, k: int, crowd: np.ndarray, box_crowd: np.ndarray) -> None:
    """Add the weights of a contact to those that its particles have in all, and 1 to its box's number of contacts."""
    for c in range(3):
        crowd[contacts.first[k, c]] += contacts.first_weights[k, c]
    if contacts.box[k] == NO_BOX:
        for c in range(3):
            crowd[contacts.second[k, c]] += contacts.second_weights[k, c]
    else:
        box_crowd[contacts.box[k]] += 1.0


@jit_lean
def _leave_crowd(contacts: SoftContacts, k: int, crowd: np.ndarray) -> None:
    """Make what `_add_to_crowd` has added to particles zero."""
    for c in range(3):
        crowd[contacts.first[k, c]] = 0.0
        if contacts.box[k] == NO_BOX:
            crowd[contacts.second[k, c]] = 0.0


@jit_lean
def _mobility(inverse_mass: np.ndarray, crowd: np.ndarray, corners: np.ndarray, weights: np.ndarray, k: int) -> float:
    """Return Σ w²/m [1/kg] of a patch that has the part w / crowd of the mass of each of its particles."""
    result = 0.0
    for c in range(3):
        i = corners[k, c]
        result += weights[k, c] * crowd[i] * inverse_mass[i]
    return result


@jit_lean
def _gain(bodies: RigidBodies, box: int, point: Vec, impulse: Vec) -> Vec:
    """Return the velocity [m/s] that an impulse [N s] gives the point of a box that it acts on."""
    arm = sub(point, load(bodies.position, box))
    orientation, inverse_inertia = load_quaternion(bodies.orientation, box), load(bodies.inverse_inertia, box)
    spin = rotate_diagonal(orientation, inverse_inertia, cross(arm, impulse))
    return add(scale(bodies.inverse_mass[box], impulse), cross(spin, arm))


@jit_lean
def _met_weights(position: np.ndarray, point: Vec, impulse: Vec, corners: Corners, weights: Vec) -> tuple[bool, Vec]:
    """Return whether the line of an impulse at `point` [m] meets the plane of a triangle, and with which weights.

    There the reaction has no moment about the impulse. Where the two points of a contact coincide these are its
    `weights`. An impulse all but along the plane, seen from a point that is not in it, does not meet it.
    """
    a, b, c = load(position, corners[0]), load(position, corners[1]), load(position, corners[2])
    up = area_vector(a, b, c)
    square, rise = dot(up, up), dot(impulse, up)
    gap = sub(patch_point(position, corners, weights), point)
    if not abs(rise) > ALONG_SKIN * np.sqrt(square) * norm(impulse):
        return dot(gap, gap) <= SAME_PLACE * SAME_PLACE * np.sqrt(square), weights
    aside = sub(scale(dot(gap, up) / rise, impulse), gap)  # from the contact's point, in the plane
    second = 0.5 * dot(cross(sub(a, c), aside), up) / square
    third = 0.5 * dot(cross(sub(b, a), aside), up) / square
    return True, (weights[0] - second - third, weights[1] + second, weights[2] + third)
