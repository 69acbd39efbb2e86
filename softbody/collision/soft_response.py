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

from softbody.collision.contact import NOBODY, Contacts, surface_point
from softbody.collision.impulse import (
    apply_impulse,
    inverse_effective_mass_at,
    velocity_change_at,
    velocity_of_point,
)
from softbody.collision.law import friction_impulse, normal_impulse
from softbody.collision.surface_point import SurfacePoint, add_at, value_at
from softbody.geometry.triangle import area_vector
from softbody.jit import jit, jit_lean
from softbody.state import Particles, RigidBodies
from softbody.vec import Vec, accumulate, add, cross, dot, load, norm, scale, store, sub

# Cosine between an impulse and the normal of a surface below which it is all but along the surface: left to
# `correct_positions`.
ALONG_SURFACE = 0.05

SAME_PLACE = 1e-12  # of a triangle's size: closer than this, two points coincide


class WeightSums(NamedTuple):
    """The sum of the weights of all contacts that act: each has its own weight's part of the mass (mass splitting)."""

    particle: np.ndarray  # (n,)
    box: np.ndarray  # (m,) where each contact has weight 1


@jit
def resolve_contacts(contacts: Contacts, particles: Particles, boxes: RigidBodies, weight_sum: np.ndarray) -> None:
    """Resolve the contacts of soft bodies: correct positions that overlap, then velocities that approach; §4.2, §4.3.

    Positions and velocities of particles and boxes are changed. `weight_sum` (n,) is zero, and left so.
    """
    first = contacts.number[1]
    if contacts.number[0] == first:
        return
    correct_positions(contacts, particles, boxes, WeightSums(weight_sum, np.zeros(boxes.inverse_mass.shape[0])))
    correct_velocities(
        contacts,
        particles,
        boxes,
        WeightSums(weight_sum, np.zeros(boxes.inverse_mass.shape[0])),
        np.empty((contacts.number[0], 3)),
    )


@jit_lean
def correct_positions(contacts: Contacts, particles: Particles, boxes: RigidBodies, sums: WeightSums) -> None:
    """Move both sides of each contact apart along its normal, by its depth, in proportion to how easily they move.

    (The paper: half each, for equal masses.) Boxes move without turning.
    """
    soft = range(contacts.number[1], contacts.number[0])
    for k in soft:
        _add_weights(contacts, k, sums)
    for k in soft:
        # How far each side gives way: the sum of both inverse masses is that of a kilogramme of shift.
        box, normal = contacts.box[k, 1], load(contacts.normal, k)
        a, b = surface_point(contacts, k, 0), surface_point(contacts, k, 1)
        inverse_mass = _split_inverse_mass(particles.inverse_mass, sums.particle, a)
        if box == NOBODY:
            inverse_mass += _split_inverse_mass(particles.inverse_mass, sums.particle, b)
        else:
            inverse_mass += boxes.inverse_mass[box] * sums.box[box]
        if inverse_mass > 0.0:
            shift = scale(contacts.depth[k] / inverse_mass, normal)
            back = scale(-1.0, shift)
            add_at(particles.position, particles.inverse_mass, a, shift)
            if box == NOBODY:
                add_at(particles.position, particles.inverse_mass, b, back)
            else:
                accumulate(boxes.position, box, scale(boxes.inverse_mass[box], back))
    for k in soft:
        _clear_weights(contacts, k, sums.particle)


@jit_lean
def correct_velocities(
    contacts: Contacts, particles: Particles, boxes: RigidBodies, sums: WeightSums, velocity: np.ndarray
) -> None:
    """Where the two sides of a contact approach, let them part with e times that speed, and take off their sliding.

    One impulse along the normal and friction against the sliding, by the law of contact. A point on a surface gives way
    by Σ w²/m, a box by 1/M + n · [(I⁻¹ (r × n)) × r] (the paper bounces from the masses alone). `velocity` is scratch.
    """
    soft = range(contacts.number[1], contacts.number[0])
    # Velocities of all contacts before any impulse; those that approach act.
    for k in soft:
        a = surface_point(contacts, k, 0)
        u = sub(value_at(particles.velocity, a), _velocity_of_second(contacts, k, particles, boxes))
        store(velocity, k, u)
        if dot(u, load(contacts.normal, k)) < 0.0:
            _add_weights(contacts, k, sums)
    for k in soft:
        approach = -dot(load(velocity, k), load(contacts.normal, k))
        if not approach > 0.0:
            continue
        a, box = surface_point(contacts, k, 0), contacts.box[k, 1]
        point = value_at(particles.position, a)
        acts, impulse = _impulse(contacts, k, particles, boxes, sums, load(velocity, k))
        if not acts:
            continue
        back = scale(-1.0, impulse)
        # The same impulse on both sides, at one point, so that angular momentum is kept.
        if box == NOBODY:
            meets, b = _line_meets_triangle(particles.position, point, impulse, surface_point(contacts, k, 1))
            if not meets:
                continue
            add_at(particles.velocity, particles.inverse_mass, b, back)
        else:
            apply_impulse(boxes, box, point, back)
        add_at(particles.velocity, particles.inverse_mass, a, impulse)
        store(contacts.impulse, k, impulse)
    for k in soft:
        _clear_weights(contacts, k, sums.particle)


@jit_lean
def _velocity_of_second(contacts: Contacts, k: int, particles: Particles, boxes: RigidBodies) -> Vec:
    """Return the velocity [m/s] of side b of a contact, where side a is."""
    box = contacts.box[k, 1]
    if box == NOBODY:
        return value_at(particles.velocity, surface_point(contacts, k, 1))
    return velocity_of_point(boxes, box, value_at(particles.position, surface_point(contacts, k, 0)))


@jit_lean
def _impulse(
    contacts: Contacts, k: int, particles: Particles, boxes: RigidBodies, sums: WeightSums, u: Vec
) -> tuple[bool, Vec]:
    """Return the impulse [N s] on side a of contact `k`, whose sides meet with velocity `u` [m/s]; if one can move."""
    box, normal, a = contacts.box[k, 1], load(contacts.normal, k), surface_point(contacts, k, 0)
    point = value_at(particles.position, a)
    # The normal impulse, by the inverse effective mass of both sides.
    soft = _split_inverse_mass(particles.inverse_mass, sums.particle, a)
    if box == NOBODY:
        soft += _split_inverse_mass(particles.inverse_mass, sums.particle, surface_point(contacts, k, 1))
    inverse_mass = soft
    if box != NOBODY:
        inverse_mass += sums.box[box] * inverse_effective_mass_at(boxes, box, point, normal)
    if not inverse_mass > 0.0:
        return False, (0.0, 0.0, 0.0)
    j = normal_impulse(-dot(u, normal), inverse_mass, contacts.restitution[k])
    impulse = scale(j, normal)
    if not contacts.friction[k] > 0.0:
        return True, impulse
    # Friction against the sliding that the normal impulse leaves: it may turn a box, and so move its point aside.
    if box != NOBODY:
        u = add(u, scale(sums.box[box], velocity_change_at(boxes, box, point, impulse)))
    slide = sub(u, scale(dot(u, normal), normal))
    sliding = norm(slide)
    if not sliding > 0.0:
        return True, impulse
    along, inverse_mass = scale(1.0 / sliding, slide), soft
    if box != NOBODY:
        inverse_mass += sums.box[box] * inverse_effective_mass_at(boxes, box, point, along)
    return True, sub(impulse, scale(friction_impulse(sliding, inverse_mass, contacts.friction[k] * j), along))


@jit_lean
def _add_weights(contacts: Contacts, k: int, sums: WeightSums) -> None:
    """Add the weights of a contact to the sums of its particles, and 1 to that of its box."""
    particles, weights, box = contacts.particles, contacts.weights, contacts.box[k, 1]
    for c in range(3):
        sums.particle[particles[k, 0, c]] += weights[k, 0, c]
    if box == NOBODY:
        for c in range(3):
            sums.particle[particles[k, 1, c]] += weights[k, 1, c]
    else:
        sums.box[box] += 1.0


@jit_lean
def _clear_weights(contacts: Contacts, k: int, weight_sum: np.ndarray) -> None:
    """Make what `_add_weights` has added to particles zero."""
    particles, box = contacts.particles, contacts.box[k, 1]
    for c in range(3):
        weight_sum[particles[k, 0, c]] = 0.0
        if box == NOBODY:
            weight_sum[particles[k, 1, c]] = 0.0


@jit_lean
def _split_inverse_mass(inverse_mass: np.ndarray, weight_sum: np.ndarray, point: SurfacePoint) -> float:
    """Return Σ w²/m [1/kg] of a point that has the part w / (sum of weights) of the mass of each of its particles."""
    result = 0.0
    for c in range(3):
        i = point.particles[c]
        result += point.weights[c] * weight_sum[i] * inverse_mass[i]
    return result


@jit_lean
def _line_meets_triangle(
    position: np.ndarray, point: Vec, impulse: Vec, second: SurfacePoint
) -> tuple[bool, SurfacePoint]:
    """Return whether the line of an impulse at `point` [m] meets the plane of a triangle, and the point where it does.

    There the reaction has no moment about the impulse. Where the two points of a contact coincide this is the `second`
    one. An impulse all but along the plane, seen from a point that is not in it, does not meet it.
    """
    i, j, k = second.particles
    weights = second.weights
    a, b, c = load(position, i), load(position, j), load(position, k)
    up = area_vector(a, b, c)
    square, rise = dot(up, up), dot(impulse, up)
    gap = sub(value_at(position, second), point)
    if not abs(rise) > ALONG_SURFACE * np.sqrt(square) * norm(impulse):
        return dot(gap, gap) <= SAME_PLACE * SAME_PLACE * np.sqrt(square), second
    aside = sub(scale(dot(gap, up) / rise, impulse), gap)  # from the contact's point, in the plane
    u = 0.5 * dot(cross(sub(a, c), aside), up) / square
    v = 0.5 * dot(cross(sub(b, a), aside), up) / square
    return True, SurfacePoint(second.particles, (weights[0] - u - v, weights[1] + u, weights[2] + v))
