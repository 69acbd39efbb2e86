"""What impulse parts two rigid bodies at a contact, and what does it do to them?"""

from __future__ import annotations

from softbody.jit import jit_lean
from softbody.quaternion import Quaternion, load_quaternion, rotate_diagonal
from softbody.state import RigidBodies
from softbody.vec import Vec, accumulate, add, cross, dot, load, norm, scale, sub

NOBODY = -1  # the ground, or anything else that no impulse moves


@jit_lean
def mobility(arm: Vec, direction: Vec, inverse_mass: float, inverse_inertia: Vec, orientation: Quaternion) -> float:
    """Return the speed [m/s per N s] that an impulse along unit `direction` gives its own point; paper §4.4.

    1/m + n · [(I⁻¹ (r × n)) × r], with r the `arm` [m] from the centre of mass and `inverse_inertia` the
    diagonal [1/(kg m²)] in the body's frame.
    """
    spin = rotate_diagonal(orientation, inverse_inertia, cross(arm, direction))
    return inverse_mass + dot(direction, cross(spin, arm))


@jit_lean
def point_velocity(bodies: RigidBodies, body: int, point: Vec) -> Vec:
    """Return v + ω × r [m/s] of the body at `point` [m]; paper §4.4 (which omits ω × r). NOBODY rests."""
    if body == NOBODY:
        return 0.0, 0.0, 0.0
    arm = sub(point, load(bodies.position, body))
    return add(load(bodies.velocity, body), cross(load(bodies.angular_velocity, body), arm))


@jit_lean
def point_mobility(bodies: RigidBodies, body: int, point: Vec, direction: Vec) -> float:
    """Return the `mobility` of a body at `point` [m] along unit `direction`; NOBODY has none."""
    if body == NOBODY:
        return 0.0
    return mobility(
        sub(point, load(bodies.position, body)),
        direction,
        bodies.inverse_mass[body],
        load(bodies.inverse_inertia, body),
        load_quaternion(bodies.orientation, body),
    )


@jit_lean
def apply_impulse(bodies: RigidBodies, body: int, point: Vec, impulse: Vec) -> None:
    """Change v and ω of one body by an `impulse` [N s] at `point` [m]; NOBODY feels nothing."""
    if body == NOBODY:
        return
    twist = cross(sub(point, load(bodies.position, body)), impulse)
    orientation = load_quaternion(bodies.orientation, body)
    spin = rotate_diagonal(orientation, load(bodies.inverse_inertia, body), twist)
    accumulate(bodies.velocity, body, scale(bodies.inverse_mass[body], impulse))
    accumulate(bodies.angular_velocity, body, spin)


@jit_lean
def resolve_contact(
    bodies: RigidBodies, a: int, b: int, point: Vec, normal: Vec, restitution: float, friction: float
) -> float:
    """Part two bodies that approach at one point and return the normal impulse j [N s]; paper §4.4.

    j = −(1 + e) u·n / (mobility of a + mobility of b), with `normal` n the unit vector from b to a and u the
    velocity of a's point seen from b's: a gains +j n and b gains −j n (the paper prints + for both). Then
    Coulomb `friction` μ, beyond the paper: an impulse of at most μ j against the sliding, never past rest.
    Nothing happens if the bodies part already, or if neither can move. `a` or `b` may be NOBODY.
    """
    u = sub(point_velocity(bodies, a, point), point_velocity(bodies, b, point))
    approach = dot(u, normal)
    give = point_mobility(bodies, a, point, normal) + point_mobility(bodies, b, point, normal)
    if approach >= 0.0 or give == 0.0:
        return 0.0
    j = -(1.0 + restitution) * approach / give
    apply_impulse(bodies, a, point, scale(j, normal))
    apply_impulse(bodies, b, point, scale(-j, normal))
    if friction > 0.0:
        apply_friction(bodies, a, b, point, normal, friction * j)
    return j


@jit_lean
def apply_friction(bodies: RigidBodies, a: int, b: int, point: Vec, normal: Vec, limit: float) -> None:
    """Slow the sliding of a on b by an impulse of at most `limit` [N s]."""
    u = sub(point_velocity(bodies, a, point), point_velocity(bodies, b, point))
    slide = sub(u, scale(dot(u, normal), normal))
    speed = norm(slide)
    if speed == 0.0:
        return
    tangent = scale(1.0 / speed, slide)
    give = point_mobility(bodies, a, point, tangent) + point_mobility(bodies, b, point, tangent)
    drag = min(limit, speed / give)
    apply_impulse(bodies, a, point, scale(-drag, tangent))
    apply_impulse(bodies, b, point, scale(drag, tangent))
