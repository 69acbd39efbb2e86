"""Soft bodies part from each other and from boxes without making momentum or energy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from softbody.collision.contact import Touch, add_contact, box_side, new_contacts, soft_side
from softbody.collision.law import Material
from softbody.collision.soft_response import resolve_contacts
from softbody.collision.surface_point import WHOLE, SurfacePoint, at_particle
from softbody.geometry.box import box_inertia
from softbody.state import Particles, RigidBodies

seeds = st.integers(0, 10**6)
fractions = st.sampled_from([0.0, 0.3, 0.5, 1.0])


def surface(seed):
    """Return a random generator, and four particles: a triangle and a fourth that has gone through it."""
    random = np.random.default_rng(seed)
    position, velocity = random.normal(size=(4, 3)), random.normal(size=(4, 3))
    return random, position, velocity, random.uniform(0.1, 10.0, 4)


def momenta(inverse_mass, position, velocity):
    mass = 1.0 / inverse_mass
    return mass @ velocity, mass @ np.cross(position, velocity)


def kinetic(inverse_mass, velocity):
    return 0.5 * (velocity**2).sum(axis=1) @ (1.0 / inverse_mass)


def unit(vector):
    return tuple((vector / np.linalg.norm(vector)).tolist())


DEAD = Material(0.0, 0.0)
NO_BODIES = RigidBodies(*(np.zeros((0, *shape)) for shape in ((), (3,), (3,), (4,), (3,), (3,))))


def touch(normal, depth):
    """Nothing asks where it is: that is taken from the two sides."""
    return Touch((np.nan, np.nan, np.nan), normal, depth, 0)


def add_particle(contacts, weights, normal, depth, material):
    """Let particle 3 touch the triangle of the first three."""
    triangle = SurfacePoint((0, 1, 2), weights)
    add_contact(contacts, soft_side(at_particle(3)), soft_side(triangle), touch(normal, depth), material)


def part_particle(weights, normal, depth, material, particles):
    """Part particle 3 from the triangle of the first three."""
    contacts = new_contacts(1)
    add_particle(contacts, weights, normal, depth, material)
    resolve_contacts(contacts, particles, NO_BODIES, np.zeros(4))


def part_box(point, normal, depth, material, particles, box):
    """Part a point of the surface from the only box."""
    contacts = new_contacts(1)
    add_contact(contacts, soft_side(point), box_side(0), touch(normal, depth), material)
    resolve_contacts(contacts, particles, box, np.zeros(4))


def touching(position, weights, normal, depth):
    """Put particle 3 `depth` behind the point of the triangle with those weights."""
    position[3] = weights @ position[:3] - depth * np.array(normal)


@given(seeds, fractions, st.sampled_from([0.0, 0.4, 10.0]))
def test_a_particle_and_a_patch_part_and_keep_both_momenta(seed, restitution, friction):
    random, position, velocity, inverse_mass = surface(seed)
    weights, normal, depth = random.dirichlet((1.0, 1.0, 1.0)), unit(random.normal(size=3)), 0.1
    touching(position, weights, normal, depth)
    before = momenta(inverse_mass, position, velocity)[0]
    energy = kinetic(inverse_mass, velocity)
    approach = (weights @ velocity[:3] - velocity[3]) @ normal
    start = velocity.copy()
    material = Material(restitution, friction)
    part_particle(tuple(weights), normal, depth, material, Particles(inverse_mass, position, velocity))
    np.testing.assert_allclose(position[3], weights @ position[:3], atol=1e-12)
    np.testing.assert_allclose(momenta(inverse_mass, position, velocity)[0], before, atol=1e-12)
    # The bodies coincide now: the impulses have no moment about each other.
    spin = momenta(inverse_mass, position, velocity)[1] - momenta(inverse_mass, position, start)[1]
    np.testing.assert_allclose(spin, 0.0, atol=1e-12)
    assert kinetic(inverse_mass, velocity) <= energy * (1.0 + 1e-14)
    parting = (velocity[3] - weights @ velocity[:3]) @ normal
    if approach > 0.0:
        assert parting == pytest.approx(restitution * approach, abs=1e-12)
    else:
        np.testing.assert_array_equal(velocity, start)


def test_equal_masses_move_half_the_depth_each():
    position = np.array([[0.0, 0.0, 0.0]] * 3 + [[0.0, 0.0, -0.2]])
    particles = Particles(np.ones(4), position, np.zeros((4, 3)))
    part_particle((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.2, DEAD, particles)
    np.testing.assert_allclose(position[[0, 3], 2], [-0.1, -0.1])


def test_fixed_particles_do_not_move():
    position, velocity = np.zeros((4, 3)), np.zeros((4, 3))
    velocity[3, 2] = -1.0
    part_particle(WHOLE, (0.0, 0.0, 1.0), 0.2, DEAD, Particles(np.zeros(4), position, velocity))
    assert not position.any()
    assert velocity[3, 2] == -1.0


@given(seeds, fractions, st.sampled_from([0.0, 0.4, 10.0]), st.booleans())
def test_a_patch_and_a_box_part_and_keep_both_momenta(seed, restitution, friction, static):
    random, position, velocity, inverse_mass = surface(seed)
    weights, normal = random.dirichlet((1.0, 1.0, 1.0)), unit(random.normal(size=3))
    size, mass = random.uniform(0.5, 2.0, 3), random.uniform(0.1, 10.0)
    inertia = np.array(box_inertia(tuple(size), mass))
    box = RigidBodies(
        np.array([0.0 if static else 1.0 / mass]),
        np.zeros((1, 3)) if static else 1.0 / inertia[None],
        random.normal(size=(1, 3)),
        np.array([[1.0, 0.0, 0.0, 0.0]]),
        np.zeros((1, 3)) if static else random.normal(size=(1, 3)),
        np.zeros((1, 3)) if static else random.normal(size=(1, 3)),
    )

    def totals():
        linear, angular = momenta(inverse_mass, position, velocity)
        v, w = box.velocity[0], box.angular_velocity[0]
        return linear + mass * v, angular + mass * np.cross(box.position[0], v) + inertia * w

    def energy():
        v, w = box.velocity[0], box.angular_velocity[0]
        return kinetic(inverse_mass, velocity) + 0.5 * mass * v @ v + 0.5 * w @ (inertia * w)

    def parting():
        point = weights @ position[:3]
        there = box.velocity[0] + np.cross(box.angular_velocity[0], point - box.position[0])
        return (weights @ velocity[:3] - there) @ normal

    # Without depth nothing moves, so that momenta before and after are about the same places.
    before, start, approach = totals(), energy(), -parting()
    particles = Particles(inverse_mass, position, velocity)
    point = SurfacePoint((0, 1, 2), tuple(weights))
    part_box(point, normal, 0.0, Material(restitution, friction), particles, box)
    if not static:
        np.testing.assert_allclose(totals()[0], before[0], atol=1e-11)
        np.testing.assert_allclose(totals()[1], before[1], atol=1e-11)
    assert energy() <= start * (1.0 + 1e-13)
    if approach > 0.0 and friction == 0.0:
        assert parting() == pytest.approx(restitution * approach, abs=1e-11)


def test_a_box_and_a_patch_move_apart_by_their_inverse_masses():
    position = np.zeros((4, 3))
    box = RigidBodies(
        np.array([1.0]), np.ones((1, 3)), np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]]), np.zeros((1, 3)),
        np.zeros((1, 3)),
    )  # fmt: skip
    particles = Particles(np.full(4, 3.0), position, np.zeros((4, 3)))
    part_box(at_particle(2), (0.0, 0.0, 1.0), 0.4, DEAD, particles, box)
    assert position[2, 2] == pytest.approx(0.3)
    assert box.position[0, 2] == pytest.approx(-0.1)


def test_contacts_of_one_particle_are_as_good_as_one():
    """Three equal contacts at once do what one alone does: each has a third of the particle and of the surface."""
    for count in (1, 3):
        position, velocity = np.zeros((4, 3)), np.zeros((4, 3))
        position[:3, :2] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
        position[3], velocity[3] = (0.25, 0.25, -0.2), (0.1, 0.0, -1.0)
        contacts = new_contacts(count)
        for _ in range(count):
            add_particle(contacts, (0.5, 0.25, 0.25), (0.0, 0.0, 1.0), 0.2, Material(0.5, 0.3))
        resolve_contacts(contacts, Particles(np.ones(4), position, velocity), NO_BODIES, np.zeros(4))
        if count == 1:
            alone = position, velocity
    np.testing.assert_allclose(position, alone[0], atol=1e-15)
    np.testing.assert_allclose(velocity, alone[1], atol=1e-15)


def test_the_order_of_contacts_does_not_matter():
    random = np.random.default_rng(5)
    ends = []
    rows = [(random.dirichlet((1, 1, 1)), unit(random.normal(size=3))) for _ in range(4)]
    for order in (range(4), reversed(range(4))):
        _, position, velocity, inverse_mass = surface(3)
        contacts = new_contacts(4)
        for row in order:
            weights, normal = rows[row]
            add_particle(contacts, tuple(weights), normal, 0.1, Material(0.5, 0.3))
        resolve_contacts(contacts, Particles(inverse_mass, position, velocity), NO_BODIES, np.zeros(4))
        ends.append((position, velocity))
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-12)
