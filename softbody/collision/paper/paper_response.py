"""The paper's response to contacts of soft bodies and boxes, one after the other; §4.2, §4.3.

The two sides part by half of their overlap each, whatever they weigh, then one impulse makes them bounce: a contact
that comes later finds what those before have left. So the order shows, mirrored bodies do not stay mirror images, and
moving a light particle as far as a heavy box shifts the centre of mass. `soft_response` does without all that.
"""

from __future__ import annotations

from softbody.collision.contact import Contacts, surface_point
from softbody.collision.impulse import apply_impulse, inverse_effective_mass_at, velocity_of_point
from softbody.collision.soft.soft_response import Bodies, height
from softbody.compiler.jit import jit_lean
from softbody.linalg.vec import Vec, accumulate, add, dot, load, norm, scale, store, sub
from softbody.model.arrays import NOBODY, Particles
from softbody.model.material import friction_impulse, normal_impulse
from softbody.model.surface_point import SurfacePoint, add_at, inverse_mass_at, value_at


@jit_lean
def resolve_in_turn(contacts: Contacts, bodies: Bodies) -> None:
    """Resolve the contacts of soft bodies as they are listed: change positions and velocities; §4.2, §4.3.

    They were all found before the first is resolved, but each is as deep as those before have left it.
    """
    first, count = contacts.number[1], contacts.number[0]
    for k in range(first, count):
        contacts.depth[k] += height(contacts, k, bodies)  # how high a is to come above b
    for k in range(first, count):
        contacts.depth[k] -= height(contacts, k, bodies)
        if contacts.depth[k] > 0.0:
            _part(contacts, k, bodies)
            _bounce(contacts, k, bodies)


@jit_lean
def _part(contacts: Contacts, k: int, bodies: Bodies) -> None:
    """Move both sides of contact `k` by half of its depth, or one by all if the other is fixed."""
    (particles, boxes), box = bodies, contacts.box[k, 1]
    a, b = surface_point(contacts, k, 0), surface_point(contacts, k, 1)
    a_moves = inverse_mass_at(particles.inverse_mass, a) > 0.0
    b_moves = boxes.inverse_mass[box] > 0.0 if box != NOBODY else inverse_mass_at(particles.inverse_mass, b) > 0.0
    share = 0.5 if a_moves and b_moves else 1.0
    shift = scale(share * contacts.depth[k], load(contacts.normal, k))
    if a_moves:
        _move(particles, a, shift)
    if b_moves and box != NOBODY:
        accumulate(boxes.position, box, scale(-1.0, shift))
    elif b_moves:
        _move(particles, b, scale(-1.0, shift))


@jit_lean
def _move(particles: Particles, point: SurfacePoint, shift: Vec) -> None:
    """Move a particle, or all corners of a triangle that are free, by `shift` [m]."""
    for c in range(3):
        i = point.particles[c]
        if particles.inverse_mass[i] > 0.0 and not (c > 0 and i == point.particles[c - 1]):
            accumulate(particles.position, i, shift)


@jit_lean
def _bounce(contacts: Contacts, k: int, bodies: Bodies) -> None:
    """Part the velocities of both sides of contact `k` by one impulse, if they approach; then friction."""
    normal = load(contacts.normal, k)
    approach = -dot(_relative_velocity(contacts, k, bodies), normal)
    inverse_mass = _inverse_mass(contacts, k, bodies, normal)
    if not (approach > 0.0 and inverse_mass > 0.0):
        return
    j = normal_impulse(approach, inverse_mass, contacts.restitution[k])
    _apply(contacts, k, bodies, scale(j, normal))
    u = _relative_velocity(contacts, k, bodies)
    slide = sub(u, scale(dot(u, normal), normal))
    sliding = norm(slide)
    if contacts.friction[k] > 0.0 and sliding > 0.0:
        along = scale(1.0 / sliding, slide)
        limit = contacts.friction[k] * j
        rubbed = friction_impulse(sliding, _inverse_mass(contacts, k, bodies, along), limit)
        _apply(contacts, k, bodies, scale(-rubbed, along))


@jit_lean
def _place(contacts: Contacts, k: int, bodies: Bodies) -> Vec:
    """Return where side a of a contact is [m]."""
    return value_at(bodies.particles.position, surface_point(contacts, k, 0))


@jit_lean
def _relative_velocity(contacts: Contacts, k: int, bodies: Bodies) -> Vec:
    """Return the velocity [m/s] of side a of a contact, seen from b."""
    velocity, box = value_at(bodies.particles.velocity, surface_point(contacts, k, 0)), contacts.box[k, 1]
    if box == NOBODY:
        return sub(velocity, value_at(bodies.particles.velocity, surface_point(contacts, k, 1)))
    return sub(velocity, velocity_of_point(bodies.boxes, box, _place(contacts, k, bodies)))


@jit_lean
def _inverse_mass(contacts: Contacts, k: int, bodies: Bodies, direction: Vec) -> float:
    """Return the inverse effective mass [1/kg] of both sides of a contact along a unit `direction`."""
    inverse_mass, box = bodies.particles.inverse_mass, contacts.box[k, 1]
    of_a = inverse_mass_at(inverse_mass, surface_point(contacts, k, 0))
    if box == NOBODY:
        return of_a + inverse_mass_at(inverse_mass, surface_point(contacts, k, 1))
    return of_a + inverse_effective_mass_at(bodies.boxes, box, _place(contacts, k, bodies), direction)


@jit_lean
def _apply(contacts: Contacts, k: int, bodies: Bodies, impulse: Vec) -> None:
    """Apply an `impulse` [N s] to side a of a contact, and its opposite to b."""
    (particles, boxes), box, back = bodies, contacts.box[k, 1], scale(-1.0, impulse)
    add_at(particles.velocity, particles.inverse_mass, surface_point(contacts, k, 0), impulse)
    if box == NOBODY:
        add_at(particles.velocity, particles.inverse_mass, surface_point(contacts, k, 1), back)
    else:
        apply_impulse(boxes, box, _place(contacts, k, bodies), back)
    store(contacts.impulse, k, add(load(contacts.impulse, k), impulse))
