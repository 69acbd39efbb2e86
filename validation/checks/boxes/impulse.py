"""One impact of two boxes at one point: the velocities after."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from softbody.collision import impulse
from softbody.geometry import box
from softbody.geometry.box import box_inertia
from softbody.linalg import quaternion
from softbody.model import material as law
from softbody.model.arrays import RigidBodies
from softbody.model.material import Material
from validation.answers import Answers
from validation.arbitration import US, arbitrate
from validation.cases import BoxPairs, box_separations, random_box_pairs, rotation_matrix
from validation.check import Comparison, Misprint, Run, check
from validation.fault import Fault

FAMILY = "box–box impulse"

RESTITUTION = Fault("restitution off by 1e-9", law.normal_impulse, "1.0 + restitution_ → 1.000000001 + restitution_")
PIECE = "softbody.collision.impulse.resolve_contact"

OVERLAP = 1e-6  # [m] of the pose at the impact: Bullet sees no contact at exactly 0


@dataclass
class Impacts:
    """Two boxes about to collide, m times: shapes, poses, velocities, restitution and the kind of contact."""

    pairs: BoxPairs
    mass_a: np.ndarray  # (m,) [kg], inf for a static box; and so for b
    mass_b: np.ndarray
    velocity: np.ndarray  # (2, m, 3) [m/s]
    angular_velocity: np.ndarray  # (2, m, 3) [rad/s]
    restitution: np.ndarray  # (m,)
    kinds: np.ndarray  # (m,) of str

    def select(self, rows: np.ndarray) -> Impacts:
        """Return the impacts of some rows."""
        return Impacts(
            self.pairs.select(rows),
            self.mass_a[rows],
            self.mass_b[rows],
            self.velocity[:, rows],
            self.angular_velocity[:, rows],
            self.restitution[rows],
            self.kinds[rows],
        )

    def inputs(self, point: np.ndarray, normal: np.ndarray) -> dict[str, np.ndarray]:
        """Return what each impact is, by name, with the contact (m, 3) that is asked about."""
        said = {**self.pairs._asdict(), "restitution": self.restitution, "point": point, "normal": normal}
        for side, mass, v, w in zip("ab", (self.mass_a, self.mass_b), self.velocity, self.angular_velocity):
            said |= {f"mass_{side}": mass, f"velocity_{side}": v, f"angular_velocity_{side}": w}
        return said

    def bodies(self) -> tuple[Any, Any, Any, Any, Any, Any, Any, Any, Any, Any, Any, Any]:
        """Return size, mass, position, orientation, velocity and angular velocity of a, then of b."""
        p, v, w = self.pairs, self.velocity, self.angular_velocity
        a = p.size_a, self.mass_a, p.position_a, p.orientation_a, v[0], w[0]
        return *a, p.size_b, self.mass_b, p.position_b, p.orientation_b, v[1], w[1]

    def sides(self, i: int) -> Iterator[tuple[np.ndarray, float, np.ndarray, np.ndarray]]:
        """Yield size, mass, position and orientation of a in impact i, then of b."""
        for side in (self.bodies()[:4], self.bodies()[6:10]):
            size, mass, position, orientation = (rows[i] for rows in side)
            yield size, mass, position, orientation

    def rigid_bodies(self, i: int) -> RigidBodies:
        """Return the two boxes of impact i as the core sees them."""
        size, mass, position, orientation = zip(*self.sides(i))
        inertia = [np.array(box_inertia(tuple(s), m)) for s, m in zip(size, mass)]
        inverse = [np.zeros(3) if np.isinf(m) else 1.0 / each for each, m in zip(inertia, mass)]
        motion = self.velocity[:, i].copy(), self.angular_velocity[:, i].copy()
        return RigidBodies(1.0 / np.array(mass), np.array(inverse), np.array(position), np.array(orientation), *motion)

    def motion(self) -> np.ndarray:
        """Return the velocities before, (v_a, ω_a, v_b, ω_b) in rows of 12."""
        return np.concatenate(self.bodies()[4:6] + self.bodies()[10:], axis=1)

    def speeds(self) -> np.ndarray:
        """Return the size (m,) of all velocities before the impacts together: errors are relative to it."""
        return np.linalg.norm(np.concatenate([*self.velocity, *self.angular_velocity], axis=1), axis=1)


def random_impacts(rng: np.random.Generator, count: int) -> Impacts:
    """Return boxes that touch at a corner or across two edges, and fly at each other while they spin.

    Masses from 1:1 to 1 000:1, one in five of the b's static; e is 0, ½, 1 or anything between.
    """
    pairs = random_box_pairs(rng, count)
    kinds = np.empty(count, dtype="<U40")
    velocity, angular_velocity = rng.normal(size=(2, count, 3)), 2.0 * rng.normal(size=(2, count, 3))
    static = rng.random(count) < 0.2
    velocity[1, static] = angular_velocity[1, static] = 0.0
    for i, (separation, normal, axis) in enumerate(box_separations(pairs)):
        pairs.position_b[i] += (separation + OVERLAP) * normal
        velocity[0, i] -= rng.uniform(0.5, 5.0) * normal
        kinds[i] = ("edge on edge" if axis >= 6 else "corner on face") + (", b static" if static[i] else "")
    mass = 10.0 ** rng.uniform(-1.5, 1.5, (2, count))
    mass[1, static] = np.inf
    restitution = np.where(rng.random(count) < 0.5, rng.choice([0.0, 0.5, 1.0], count), rng.random(count))
    return Impacts(pairs, mass[0], mass[1], velocity, angular_velocity, restitution, kinds)


def core_impact(
    impacts: Impacts, i: int, point: np.ndarray, normal: np.ndarray, friction: float = 0.0
) -> tuple[np.ndarray, float]:
    """Return the core's velocities after impact i, (v_a, ω_a, v_b, ω_b) in a row of 12, and the impulse."""
    bodies, material = impacts.rigid_bodies(i), Material(float(impacts.restitution[i]), friction)
    j = impulse.resolve_contact(bodies, (0, 1), tuple(point), tuple(normal), material)
    return motion_of(bodies), j


def motion_of(bodies: RigidBodies) -> np.ndarray:
    """Return the velocities of two boxes, (v_a, ω_a, v_b, ω_b) in a row of 12."""
    return np.hstack([bodies.velocity, bodies.angular_velocity]).ravel()


def core_velocities(impacts: Impacts, point: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return (m, 12): the core's velocities after each impact."""
    return np.array([core_impact(impacts, i, point[i], normal[i])[0] for i in range(len(point))])


def bullet_velocities(judged: Any) -> np.ndarray:
    """Return (m, 12): what Bullet's boxes do after the impacts."""
    a, b = (judged.velocity_a, judged.angular_velocity_a), (judged.velocity_b, judged.angular_velocity_b)
    return np.concatenate([*a, *b], axis=1)


def contact_points(impacts: Impacts, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return a point near both boxes and a unit normal from b to a, for each impact: any will do for algebra."""
    p = impacts.pairs
    normal = p.position_a - p.position_b + 0.3 * rng.normal(size=p.position_a.shape)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    middle = 0.5 * (p.position_a + p.position_b)
    return middle + 0.3 * rng.normal(size=middle.shape), normal


def speeds(impacts: Impacts) -> np.ndarray:
    """Return the scale (m,) of the velocities in each impact: errors are relative to it."""
    return impacts.speeds() * mass_ratio(impacts)


def mass_ratio(impacts: Impacts) -> np.ndarray:
    """Return how much faster the lighter body can fly off than the heavier one came: (m,), at least 1."""
    ratio = impacts.mass_a / np.where(np.isinf(impacts.mass_b), impacts.mass_a, impacts.mass_b)
    return np.maximum(1.0, np.maximum(ratio, 1.0 / ratio))


@check(
    section="4.4",
    piece=PIECE,
    reference="pybullet, one step of 1e-12 s at the contact pose, at the contact that it reports",
    engines=("pybullet",),
    unit="of the speed",
    tolerance=2e-12,
    because="Bullet's own residual at such a contact: 2.3e-13 at worst of ten seeds, 2.6e-13 at standard",
    faults=(
        RESTITUTION,
        Fault(
            "inertia of a box with two axes exchanged",
            box.box_inertia,
            "(y2 + z2, x2 + z2, x2 + y2) → (x2 + z2, y2 + z2, x2 + y2)",
        ),
    ),
)
def one_impact_by_bullet(run: Run) -> Comparison:
    """Boxes move and spin after one impact as Bullet makes them.

    Impacts are at a corner or across edges.
    """
    from references import analytic, pybullet

    impacts = random_impacts(run.fresh_rng(), run.count(400, 4_000, 40_000))
    judged = pybullet.one_impact(*impacts.bodies(), restitution=impacts.restitution)
    single = judged.count == 1
    impacts, contact = impacts.select(single), (judged.point[single], judged.normal[single])
    measured, inputs, scale = core_velocities(impacts, *contact), impacts.inputs(*contact), speeds(impacts)
    truth = np.concatenate(analytic.box_impact(*impacts.bodies(), *contact, impacts.restitution), axis=1)
    found = {US: measured, "pybullet": bullet_velocities(judged)[single]}
    return Comparison(
        measured,
        found["pybullet"],
        scale,
        impacts.kinds,
        notes=[f"{int((~single).sum())} of {len(single)} trials had no or several contacts: passed over here"],
        inputs=inputs,
        arbitrations=[arbitrate("closed form", truth, found, tolerance=1e-11, scale=scale, inputs=inputs)],
    )


def _by_closed_form(run: Run, printed_name: str, only_spin: bool = False, slender: bool = False) -> Comparison:
    """Compare random impacts; of boxes that spin and do not fly, or whose sides are 1 : 3 : 10 in any order."""
    from references import analytic, printed

    rng = run.fresh_rng()
    impacts = random_impacts(rng, run.count(500, 5_000, 50_000))
    if only_spin:
        impacts.velocity[:] = 0.0
    if slender:
        for size in impacts.pairs.size_a, impacts.pairs.size_b:
            size[:] = rng.permuted(np.tile([0.2, 0.6, 2.0], (len(size), 1)), axis=1)
    point, normal = contact_points(impacts, rng)
    arguments = (*impacts.bodies(), point, normal, impacts.restitution)
    return Comparison(
        core_velocities(impacts, point, normal),
        np.concatenate(analytic.box_impact(*arguments), axis=1),
        speeds(impacts),
        impacts.kinds,
        printed=np.concatenate(getattr(printed, printed_name)(*arguments), axis=1),
        inputs=impacts.inputs(point, normal),
    )


by_closed_form = partial(
    check,
    section="4.4",
    reference="closed form",
    unit="of the speed",
    kind="closed form",
    because="rounding, with inertias and masses up to 1 000:1",
)


@by_closed_form(
    piece=PIECE,
    reference="closed form with world-frame inertia matrices",
    tolerance=4e-14,
    faults=(RESTITUTION,),
    erratum=Misprint("E1", "v1' = v1 + j n/m1 and ω1' with +", "minus for the second body"),
)
def one_impact_by_closed_form(run: Run) -> Comparison:
    """Velocities after an impact at any contact are the closed form's."""
    return _by_closed_form(run, "impact_both_plus")


@by_closed_form(
    piece="softbody.collision.impulse.velocity_of_point",
    tolerance=2e-14,
    faults=(
        Fault(
            "points that touch without their spin",
            impulse.velocity_of_point,
            "add(velocity_, cross(spin_, arm_)) → velocity_",
        ),
    ),
    erratum=Misprint("E2", "relative velocity from the linear velocities only", "v + ω × r of both"),
)
def spinning_boxes(run: Run) -> Comparison:
    """Boxes spinning in place meet with their points' velocity, not their centres'."""
    return _by_closed_form(run, "impact_without_spin", only_spin=True)


@by_closed_form(
    piece="softbody.collision.impulse.inverse_effective_mass",
    tolerance=4e-14,
    faults=(
        Fault(
            "another order in the denominator",
            impulse.inverse_effective_mass,
            "dot(direction_, cross(spin_, arm_)) → dot(direction_, cross(arm_, spin_))",
        ),
    ),
    erratum=Misprint("E3", "n·I⁻¹·(r×n)×r, which can be read as n·I⁻¹((r×n)×r)", "n·[(I⁻¹(r×n))×r]"),
)
def denominator(run: Run) -> Comparison:
    """The denominator's angular part takes the arm's cross product last.

    It is n · [(I⁻¹ (r × n)) × r]: boxes of sides 1 : 3 : 10 spin and do not fly.
    """
    return _by_closed_form(run, "impact_inertia_last", only_spin=True, slender=True)


@by_closed_form(
    section="3, 4.4",
    piece="softbody.linalg.quaternion.rotate_diagonal",
    tolerance=6e-14,
    faults=(
        Fault(
            "an inertia that does not turn with the body",
            quaternion.rotate_diagonal,
            "rotate(q_, multiply(diagonal_, rotate_inverse(q_, a_))) → multiply(diagonal_, a_)",
        ),
    ),
    erratum=Misprint("E17", "one angle and a constant diagonal I", "R I⁻¹ Rᵀ"),
)
def turned_inertia(run: Run) -> Comparison:
    """The inertia of a box turns with it.

    Boxes of sides 1 : 3 : 10, turned anyhow, fly and spin.
    """
    return _by_closed_form(run, "impact_with_body_inertia", slender=True)


@check(
    section="4.4",
    piece=PIECE,
    reference="invariant",
    unit="of the momentum",
    kind="invariant",
    tolerance=1e-15,
    because="rounding of a dozen products: 8e-17 at worst of ten seeds, 1.2e-16 of all impacts at full",
    faults=(
        Fault(
            "the second body feels 1e-9 less",
            impulse.resolve_contact,
            "scale(-j_, normal_) → scale(-j_ * (1.0 - 1e-9), normal_)",
        ),
    ),
)
def impact_conserves_momentum(run: Run) -> Comparison:
    """An impact changes neither the total momentum nor total angular momentum."""
    rng = run.fresh_rng()
    impacts = random_impacts(rng, run.count(500, 5_000, 50_000))
    impacts = impacts.select(np.isfinite(impacts.mass_b))
    contact = contact_points(impacts, rng)
    answers = Answers()
    for i, (after, before) in enumerate(zip(core_velocities(impacts, *contact), impacts.motion())):
        size = _size_of_momenta(impacts, i, after) + _size_of_momenta(impacts, i, before)
        answers.add(_momenta(impacts, i, after), _momenta(impacts, i, before), size, impacts.kinds[i])
    return answers.comparison(inputs=impacts.inputs(*contact))


def _inertia(size: np.ndarray, mass: float, orientation: np.ndarray) -> np.ndarray:
    x, y, z = size**2
    matrix = rotation_matrix(orientation)
    return matrix @ np.diag(mass / 12.0 * np.array([y + z, x + z, x + y])) @ matrix.T


def _momenta(impacts: Impacts, i: int, velocities: np.ndarray) -> np.ndarray:
    """Return (6,): total momentum and angular momentum about the origin."""
    boxes = list(zip(impacts.sides(i), velocities.reshape(2, 2, 3)))
    linear = sum(mass * v for (_, mass, _, _), (v, _) in boxes)
    about_origin = sum(mass * np.cross(place, v) for (_, mass, place, _), (v, _) in boxes)
    angular = sum((_inertia(size, mass, q) @ w for (size, mass, _, q), (_, w) in boxes), start=about_origin)
    return np.concatenate([linear, angular])


def _size_of_momenta(impacts: Impacts, i: int, velocities: np.ndarray) -> float:
    """Return Σ m |v| + Σ m |size| |ω|: what the momenta would be if nothing cancelled."""
    boxes = zip(impacts.sides(i), np.linalg.norm(velocities.reshape(2, 2, 3), axis=2))
    return sum(mass * (np.linalg.norm(place) + 1.0) * (v + w) for (_, mass, place, _), (v, w) in boxes)


def _energy(impacts: Impacts, i: int, velocities: np.ndarray) -> float:
    energy = 0.0
    for (size, mass, _, q), (v, w) in zip(impacts.sides(i), velocities.reshape(2, 2, 3)):
        if np.isfinite(mass):
            energy += 0.5 * mass * v @ v
            energy += 0.5 * w @ _inertia(size, mass, q) @ w
    return energy


@check(
    section="4.4",
    piece=PIECE,
    reference="invariants: u'·n = −e u·n, and ΔE = ½ j (u·n + u'·n)",
    kind="invariant",
    tolerance=5e-14,
    because="rounding; with a mass ratio of 1 000 the heavy body's energy loses three digits",
    faults=(RESTITUTION,),
)
def restitution_and_energy(run: Run) -> Comparison:
    """Points that touch part with e times their speed of approach.

    The energy lost is what that demands.
    """
    rng = run.fresh_rng()
    impacts = random_impacts(rng, run.count(500, 5_000, 50_000))
    point, normal = contact_points(impacts, rng)
    answers, rows = Answers(), []
    for i, before in enumerate(impacts.motion()):
        after, j = core_impact(impacts, i, point[i], normal[i])
        arm_a, arm_b = (point[i] - place for _, _, place, _ in impacts.sides(i))
        approach, parting = (
            (v[0] + np.cross(v[1], arm_a) - v[2] - np.cross(v[3], arm_b)) @ normal[i]
            for v in (before.reshape(4, 3), after.reshape(4, 3))
        )
        if approach >= 0.0:
            continue
        energy = _energy(impacts, i, before)
        answers.add(parting, -impacts.restitution[i] * approach, np.abs(before).max(), "parting speed")
        answers.add(_energy(impacts, i, after) - energy, 0.5 * j * (approach + parting), energy, "energy lost")
        rows += [i, i]
    return answers.comparison(inputs=impacts.select(np.array(rows)).inputs(point[rows], normal[rows]))


@check(
    section="4.4",
    piece="softbody.collision.impulse.apply_friction",
    reference="closed form: Coulomb's law along the sliding that the normal impulse leaves, with 3 × 3 matrices",
    unit="of the speed",
    kind="closed form",
    tolerance=6e-14,
    because="rounding, with inertias and masses up to 1 000:1: 2.4e-15 at worst of ten seeds, 1e-14 of 50 000 impacts",
    faults=(
        Fault(
            "friction between boxes half as strong",
            impulse.resolve_contact,
            "material_.friction * j_ → 0.5 * material_.friction * j_",
        ),
        Fault(
            "friction pushes both boxes the same way",
            impulse.apply_friction,
            "scale(-impulse_, tangent_) → scale(impulse_, tangent_)",
        ),
        Fault("friction never stops what slides slowly", law.friction_impulse, "min(limit_, stopping_) → limit_"),
        Fault(
            "friction against the inertia of one box alone",
            impulse.apply_friction,
            "mass_of_a_ + mass_of_b_ → mass_of_a_",
        ),
    ),
)
def one_impact_with_friction(run: Run) -> Comparison:
    """An impact with friction stops the points' sliding, or slows it.

    What slows it is an impulse of μ times the normal one, μ from 0 to 2. The velocities after are those of the closed
    form.
    """
    rng = run.fresh_rng()
    impacts = random_impacts(rng, run.count(500, 5_000, 50_000))
    point, normal = contact_points(impacts, rng)
    friction = np.where(rng.random(len(point)) < 0.1, 0.0, rng.uniform(0.0, 2.0, len(point)))
    answers, scale = Answers(), speeds(impacts)
    for i in range(len(point)):
        after, stopped = _rubbing_impact(impacts, i, point[i], normal[i], friction[i])
        ours, _ = core_impact(impacts, i, point[i], normal[i], float(friction[i]))
        kind = f"{'stopped' if stopped else 'slides on'}{', b static' if np.isinf(impacts.mass_b[i]) else ''}"
        answers.add(ours, after, scale[i], kind)
    return answers.comparison()


def _rubbing_impact(
    impacts: Impacts, i: int, point: np.ndarray, normal: np.ndarray, friction: float
) -> tuple[np.ndarray, bool]:
    """Return the velocities after impact i with friction, in a row of 12, and whether the points stop sliding.

    With J the 3 × 12 matrix of the points' relative velocity, and M⁻¹ that of the inverse masses, an impulse p changes
    velocities by M⁻¹ Jᵀ p, and the relative velocity by K p, K = J M⁻¹ Jᵀ.
    """
    inverse = np.zeros((12, 12))
    for k, (size, mass, _, q) in enumerate(impacts.sides(i)):
        if np.isfinite(mass):
            inverse[6 * k : 6 * k + 3, 6 * k : 6 * k + 3] = np.eye(3) / mass
            inverse[6 * k + 3 : 6 * k + 6, 6 * k + 3 : 6 * k + 6] = np.linalg.inv(_inertia(size, mass, q))
    arm_a, arm_b = (point - place for _, _, place, _ in impacts.sides(i))
    jacobian = np.hstack([np.eye(3), -_cross_matrix(arm_a), -np.eye(3), _cross_matrix(arm_b)])
    answer = jacobian @ inverse @ jacobian.T  # K
    motion = motion_of(impacts.rigid_bodies(i))
    approach = -normal @ jacobian @ motion
    if approach <= 0.0:
        return motion, False
    j = (1.0 + impacts.restitution[i]) * approach / (normal @ answer @ normal)
    motion = motion + inverse @ jacobian.T @ (j * normal)
    sliding = jacobian @ motion
    sliding = sliding - (sliding @ normal) * normal
    speed = np.linalg.norm(sliding)
    tangent = sliding / speed
    stopping = speed / (tangent @ answer @ tangent)
    motion = motion - inverse @ jacobian.T @ (min(friction * j, stopping) * tangent)
    return motion, bool(friction * j >= stopping)


def _cross_matrix(r: np.ndarray) -> np.ndarray:
    """Return the matrix (3, 3) that makes r × v of v."""
    x, y, z = r
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
