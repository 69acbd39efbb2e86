"""Does an impulse part two bodies by the law of restitution, and conserve what it must?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from softbody.collision.impulse import (
    apply_impulse,
    inverse_effective_mass,
    inverse_effective_mass_at,
    resolve_contact,
    velocity_of_point,
)
from softbody.model.arrays import NOBODY, RigidBodies
from softbody.model.material import Material

REST = (1.0, 0.0, 0.0, 0.0)


def bodies(seed, static=None):
    """Two bodies of random mass, inertia, orientation and motion; one of them may be static."""
    random = np.random.default_rng(seed)
    orientation = random.normal(size=(2, 4))
    pair = RigidBodies(
        inverse_mass=random.uniform(0.1, 10.0, 2),
        inverse_inertia=random.uniform(0.1, 10.0, (2, 3)),
        position=random.uniform(-1.0, 1.0, (2, 3)),
        orientation=orientation / np.linalg.norm(orientation, axis=1, keepdims=True),
        velocity=random.normal(size=(2, 3)),
        angular_velocity=random.normal(size=(2, 3)),
    )
    if static is not None:
        for array in (pair.inverse_mass, pair.inverse_inertia, pair.velocity, pair.angular_velocity):
            array[static] = 0.0
    return pair


def contact(seed):
    """A random point and unit normal."""
    random = np.random.default_rng(seed + 10**6)
    normal = random.normal(size=3)
    return tuple(random.uniform(-1.0, 1.0, 3).tolist()), tuple((normal / np.linalg.norm(normal)).tolist())


def spin(pair, i):
    """I ω of body i in the world frame, with NumPy."""
    w, x, y, z = pair.orientation[i]
    R = Rotation.from_quat([x, y, z, w]).as_matrix()
    return R @ np.diag(1.0 / pair.inverse_inertia[i]) @ R.T @ pair.angular_velocity[i]


def movers(pair):
    return [i for i in range(2) if pair.inverse_mass[i] > 0.0]


def linear_momentum(pair):
    return sum(pair.velocity[i] / pair.inverse_mass[i] for i in movers(pair))


def angular_momentum(pair):
    return sum(
        np.cross(pair.position[i], pair.velocity[i] / pair.inverse_mass[i]) + spin(pair, i) for i in movers(pair)
    )


def energy(pair):
    return sum(
        0.5 * pair.velocity[i] @ pair.velocity[i] / pair.inverse_mass[i]
        + 0.5 * pair.angular_velocity[i] @ spin(pair, i)
        for i in movers(pair)
    )


def relative_velocity(pair, point, a=0, b=1):
    return np.array(velocity_of_point(pair, a, point)) - velocity_of_point(pair, b, point)


def approaching(pair, point, normal):
    """The normal turned, if need be, so that body 0 and body 1 approach along it."""
    return normal if relative_velocity(pair, point) @ normal < 0.0 else tuple(-c for c in normal)


seeds = st.integers(0, 10**5)
restitutions = st.floats(0.0, 1.0)
frictions = st.floats(0.0, 2.0)
statics = st.sampled_from([None, 0, 1])


@given(seeds)
def test_the_inverse_effective_mass_is_the_3_by_3_formula(seed):
    pair = bodies(seed)
    point, normal = contact(seed)
    r, n = np.array(point) - pair.position[0], np.array(normal)
    w, x, y, z = pair.orientation[0]
    R = Rotation.from_quat([x, y, z, w]).as_matrix()
    cross = np.array([[0.0, -r[2], r[1]], [r[2], 0.0, -r[0]], [-r[1], r[0], 0.0]])
    inverse = R @ np.diag(pair.inverse_inertia[0]) @ R.T
    K = pair.inverse_mass[0] * np.eye(3) - cross @ inverse @ cross
    assert inverse_effective_mass_at(pair, 0, point, normal) == pytest.approx(n @ K @ n, rel=1e-12)


def test_an_impulse_through_the_centre_meets_the_mass_only():
    assert inverse_effective_mass((0.0, 0.0, 2.0), (0.0, 0.0, 1.0), 0.5, (1.0, 2.0, 3.0), REST) == 0.5


def test_an_impulse_at_the_end_of_an_arm_also_turns_the_body():
    """r = (2,0,0), n = z: r × n = −2 y, so I⁻¹ 4 about y: 0.5 + 4·2."""
    assert inverse_effective_mass((2.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5, (1.0, 2.0, 3.0), REST) == 8.5


def test_a_point_moves_with_v_plus_omega_cross_r():
    pair = bodies(0)
    pair.velocity[0] = (1.0, 2.0, 3.0)
    pair.angular_velocity[0] = (0.0, 0.0, 2.0)
    point = tuple((pair.position[0] + [1.0, 0.0, 0.0]).tolist())
    assert velocity_of_point(pair, 0, point) == pytest.approx((1.0, 4.0, 3.0), rel=1e-14)


def test_nobody_rests_cannot_be_moved_and_feels_nothing():
    pair = bodies(0)
    before = [array.copy() for array in pair]
    apply_impulse(pair, NOBODY, (0.0, 0.0, 0.0), (1.0, 2.0, 3.0))
    assert all((a == b).all() for a, b in zip(pair, before))
    assert velocity_of_point(pair, NOBODY, (0.0, 0.0, 0.0)) == (0.0, 0.0, 0.0)
    assert inverse_effective_mass_at(pair, NOBODY, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)) == 0.0


def test_two_equal_bodies_that_meet_head_on_exchange_their_velocities():
    pair = bodies(0)
    pair.inverse_mass[:] = 1.0
    pair.position[:] = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]
    pair.velocity[:] = [[-3.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
    pair.angular_velocity[:] = 0.0
    assert resolve_contact(pair, (0, 1), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), Material(1.0, 0.0)) == pytest.approx(4.0)
    assert pair.velocity == pytest.approx(np.array([[1.0, 0.0, 0.0], [-3.0, 0.0, 0.0]]))


@given(seeds, restitutions, statics)
def test_the_normal_velocity_is_reversed_times_the_restitution(seed, e, static):
    pair = bodies(seed, static)
    point, normal = contact(seed)
    normal = approaching(pair, point, normal)
    before = relative_velocity(pair, point) @ normal
    resolve_contact(pair, (0, 1), point, normal, Material(e, 0.0))
    assert relative_velocity(pair, point) @ normal == pytest.approx(-e * before, abs=1e-12 * abs(before) + 1e-13)


@given(seeds, restitutions, frictions)
def test_linear_and_angular_momentum_are_conserved(seed, e, friction):
    pair = bodies(seed)
    point, normal = contact(seed)
    normal = approaching(pair, point, normal)
    before = linear_momentum(pair), angular_momentum(pair)
    assert resolve_contact(pair, (0, 1), point, normal, Material(e, friction)) > 0.0
    assert linear_momentum(pair) == pytest.approx(before[0], abs=1e-12)
    assert angular_momentum(pair) == pytest.approx(before[1], abs=1e-12)


@given(seeds, restitutions, frictions, statics)
def test_the_energy_never_grows(seed, e, friction, static):
    pair = bodies(seed, static)
    point, normal = contact(seed)
    before = energy(pair)
    resolve_contact(pair, (0, 1), point, approaching(pair, point, normal), Material(e, friction))
    assert energy(pair) <= before * (1.0 + 1e-12)


@given(seeds)
def test_a_lossless_bounce_keeps_the_energy(seed):
    pair = bodies(seed)
    point, normal = contact(seed)
    before = energy(pair)
    resolve_contact(pair, (0, 1), point, approaching(pair, point, normal), Material(1.0, 0.0))
    assert energy(pair) == pytest.approx(before, rel=1e-12)


@given(seeds, restitutions, frictions, statics)
def test_friction_slows_the_slide_and_never_reverses_it_nor_exceeds_coulombs_cone(seed, e, friction, static):
    smooth, rough = bodies(seed, static), bodies(seed, static)
    point, normal = contact(seed)
    normal = approaching(smooth, point, normal)
    n = np.array(normal)
    j = resolve_contact(smooth, (0, 1), point, normal, Material(e, 0.0))
    assert resolve_contact(rough, (0, 1), point, normal, Material(e, friction)) == j
    free, held = relative_velocity(smooth, point), relative_velocity(rough, point)
    slide = free - (free @ n) * n
    tangent = slide / np.linalg.norm(slide)
    assert held @ tangent >= -1e-12
    assert held @ tangent <= free @ tangent + 1e-12
    mover = movers(rough)[0]
    pull = (rough.velocity[mover] - smooth.velocity[mover]) / rough.inverse_mass[mover]
    assert np.linalg.norm(pull) <= friction * j * (1.0 + 1e-9) + 1e-12
    assert energy(rough) <= energy(smooth) * (1.0 + 1e-12)


def test_enough_friction_stops_a_slide_and_little_takes_mu_j():
    """A point mass of 2 kg that comes down at 1 m/s and slides at 3 m/s: j = 2 N s takes up to μ 1 m/s off."""
    for friction, left in ((0.5, 2.5), (2.0, 1.0), (5.0, 0.0)):
        pair = bodies(0)
        pair.inverse_mass[0], pair.inverse_inertia[0] = 0.5, 0.0
        pair.velocity[0], pair.angular_velocity[0] = (3.0, 0.0, -1.0), 0.0
        point = tuple(pair.position[0].tolist())
        assert resolve_contact(pair, (0, NOBODY), point, (0.0, 0.0, 1.0), Material(0.0, friction)) == 2.0
        assert pair.velocity[0] == pytest.approx([left, 0.0, 0.0], abs=1e-15)


@given(seeds, restitutions, frictions)
def test_bodies_that_part_already_are_left_alone(seed, e, friction):
    pair = bodies(seed)
    point, normal = contact(seed)
    parting = tuple(-c for c in approaching(pair, point, normal))
    before = [array.copy() for array in pair]
    assert resolve_contact(pair, (0, 1), point, parting, Material(e, friction)) == 0.0
    assert all((a == b).all() for a, b in zip(pair, before))


def test_two_bodies_that_cannot_move_are_left_alone():
    pair = bodies(3, static=0)
    for array in (pair.inverse_mass, pair.inverse_inertia):
        array[1] = 0.0
    point, normal = contact(3)
    assert resolve_contact(pair, (0, 1), point, approaching(pair, point, normal), Material(1.0, 1.0)) == 0.0
    assert np.isfinite(pair.velocity).all()


@given(seeds, restitutions, frictions)
def test_a_static_body_and_nobody_are_the_same_wall(seed, e, friction):
    wall, ground = bodies(seed, static=1), bodies(seed, static=1)
    point, normal = contact(seed)
    normal = approaching(wall, point, normal)
    assert resolve_contact(wall, (0, 1), point, normal, Material(e, friction)) == resolve_contact(
        ground, (0, NOBODY), point, normal, Material(e, friction)
    )
    assert wall.velocity.tolist() == ground.velocity.tolist()
    assert not wall.velocity[1].any()


@given(seeds, restitutions, frictions)
def test_naming_the_bodies_the_other_way_round_changes_nothing(seed, e, friction):
    one, other = bodies(seed), bodies(seed)
    point, normal = contact(seed)
    normal = approaching(one, point, normal)
    resolve_contact(one, (0, 1), point, normal, Material(e, friction))
    resolve_contact(other, (1, 0), point, tuple(-c for c in normal), Material(e, friction))
    assert one.velocity == pytest.approx(other.velocity, abs=1e-12)
    assert one.angular_velocity == pytest.approx(other.angular_velocity, abs=1e-12)
