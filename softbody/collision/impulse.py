"""Impulse that parts two rigid bodies at a contact, with restitution and friction, and what it changes."""

from __future__ import annotations

from softbody.compiler.jit import jit_lean
from softbody.linalg.quaternion import Quaternion, load_quaternion, rotate_diagonal
from softbody.linalg.vec import Vec, accumulate, add, cross, dot, load, norm, scale, sub
from softbody.model.arrays import NOBODY, RigidBodies
from softbody.model.material import Material, friction_impulse, normal_impulse

Pair = tuple[int, int]  # a and b; either may be NOBODY


@jit_lean
def inverse_effective_mass(
    arm: Vec, direction: Vec, inverse_mass: float, inverse_inertia: Vec, orientation: Quaternion
) -> float:
    """Return the speed [m/s per N s] that an impulse along unit `direction` gives its own point; paper §4.4.

    1/m + n · [(I⁻¹ (r × n)) × r], with r the `arm` [m] from the centre of mass and `inverse_inertia` the
    diagonal [1/(kg m²)] in the body's frame.
    """
    spin = rotate_diagonal(orientation, inverse_inertia, cross(arm, direction))
    return inverse_mass + dot(direction, cross(spin, arm))


@jit_lean
def velocity_of_point(bodies: RigidBodies, body: int, point: Vec) -> Vec:
    """Return v + ω × r [m/s] of the body at `point` [m]; paper §4.4 (which omits ω × r). NOBODY rests."""
    if body == NOBODY:
        return 0.0, 0.0, 0.0
    arm = sub(point, load(bodies.position, body))
    return add(load(bodies.velocity, body), cross(load(bodies.angular_velocity, body), arm))


@jit_lean
def relative_velocity(bodies: RigidBodies, pair: Pair, point: Vec) -> Vec:
    """Return the velocity [m/s] of a's point at `point` [m], seen from b's."""
    return sub(velocity_of_point(bodies, pair[0], point), velocity_of_point(bodies, pair[1], point))


@jit_lean
def inverse_effective_mass_at(bodies: RigidBodies, body: int, point: Vec, direction: Vec) -> float:
    """Return the inverse effective mass [1/kg] of a body at `point` [m] along unit `direction`; NOBODY has none."""
    if body == NOBODY:
        return 0.0
    return inverse_effective_mass(
        sub(point, load(bodies.position, body)),
        direction,
        bodies.inverse_mass[body],
        load(bodies.inverse_inertia, body),
        load_quaternion(bodies.orientation, body),
    )


@jit_lean
def velocity_change_at(bodies: RigidBodies, body: int, point: Vec, impulse: Vec) -> Vec:
    """Return the velocity [m/s] that an `impulse` [N s] gives the point of a body, at `point` [m], that it acts on."""
    arm = sub(point, load(bodies.position, body))
    orientation, inverse_inertia = load_quaternion(bodies.orientation, body), load(bodies.inverse_inertia, body)
    spin = rotate_diagonal(orientation, inverse_inertia, cross(arm, impulse))
    return add(scale(bodies.inverse_mass[body], impulse), cross(spin, arm))


@jit_lean
def apply_impulse(bodies: RigidBodies, body: int, point: Vec, impulse: Vec) -> None:
    """Change v and ω of one body by an `impulse` [N s] at `point` [m]; NOBODY feels nothing."""
    if body == NOBODY:
        return
    moment = cross(sub(point, load(bodies.position, body)), impulse)
    orientation = load_quaternion(bodies.orientation, body)
    spin = rotate_diagonal(orientation, load(bodies.inverse_inertia, body), moment)
    accumulate(bodies.velocity, body, scale(bodies.inverse_mass[body], impulse))
    accumulate(bodies.angular_velocity, body, spin)


@jit_lean
def resolve_contact(bodies: RigidBodies, pair: Pair, point: Vec, normal: Vec, material: Material) -> float:
    """Part two bodies that approach at one point and return the normal impulse j [N s]; paper §4.4.

    j = −(1 + e) u·n / (inverse effective mass of a + that of b), with `normal` n the unit vector from b to a and u the
    velocity of a's point seen from b's: a gains +j n and b gains −j n (the paper prints + for both). Then Coulomb
    friction, beyond the paper: an impulse of at most μ j against the sliding, never past rest. Nothing happens if the
    bodies part already, or if neither can move.
    """
    a, b = pair
    approach = -dot(relative_velocity(bodies, pair, point), normal)
    inverse_mass = inverse_effective_mass_at(bodies, a, point, normal) + inverse_effective_mass_at(
        bodies, b, point, normal
    )
    if approach <= 0.0 or inverse_mass == 0.0:
        return 0.0
    j = normal_impulse(approach, inverse_mass, material.restitution)
    apply_impulse(bodies, a, point, scale(j, normal))
    apply_impulse(bodies, b, point, scale(-j, normal))
    if material.friction > 0.0:
        apply_friction(bodies, pair, point, normal, material.friction * j)
    return j


@jit_lean
def apply_friction(bodies: RigidBodies, pair: Pair, point: Vec, normal: Vec, limit: float) -> None:
    """Slow the sliding of a on b by an impulse of at most `limit` [N s]."""
    a, b = pair
    u = relative_velocity(bodies, pair, point)
    slide = sub(u, scale(dot(u, normal), normal))
    speed = norm(slide)
    if speed == 0.0:
        return
    tangent = scale(1.0 / speed, slide)
    inverse_mass = inverse_effective_mass_at(bodies, a, point, tangent) + inverse_effective_mass_at(
        bodies, b, point, tangent
    )
    impulse = friction_impulse(speed, inverse_mass, limit)
    apply_impulse(bodies, a, point, scale(-impulse, tangent))
    apply_impulse(bodies, b, point, scale(impulse, tangent))
