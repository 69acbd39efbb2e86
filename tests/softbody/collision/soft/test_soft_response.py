"""Soft bodies part from each other and from boxes without making momentum or energy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from softbody.collision.contact import Touch, add_contact, box_side, new_contacts, soft_side
from softbody.collision.soft.soft_response import Bodies, resolve_contacts, response_memory
from softbody.geometry.box import box_inertia
from softbody.model.arrays import Particles, RigidBodies
from softbody.model.material import Material
from softbody.model.surface_point import WHOLE, SurfacePoint, at_particle

pytestmark = pytest.mark.interpreted

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


def resolve(contacts, particles, boxes, h=1.0):
    """Resolve contacts after a step of `h` [s] in which everything has moved as it moves now."""
    position, velocity = particles.position - h * particles.velocity, particles.velocity.copy()
    resting = RigidBodies(*(rows.copy() for rows in boxes))
    before = Bodies(Particles(particles.inverse_mass, position, velocity), resting)
    response = response_memory(np.array([0, 4]), len(boxes.inverse_mass))
    response.parting_time[:] = 0.5  # [s]
    resolve_contacts(contacts, Bodies(particles, boxes), before, response, h)


def part_particle(weights, normal, depth, material, particles, h=1.0):
    """Part particle 3 from the triangle of the first three."""
    contacts = new_contacts(1)
    add_particle(contacts, weights, normal, depth, material)
    resolve(contacts, particles, NO_BODIES, h)


def part_box(point, normal, depth, material, particles, box, h=1.0):
    """Part a point of the surface from the only box."""
    contacts = new_contacts(1)
    add_contact(contacts, soft_side(point), box_side(0), touch(normal, depth), material)
    resolve(contacts, particles, box, h)


def touching(position, weights, normal, depth):
    """Put particle 3 `depth` behind the point of the triangle with those weights."""
    position[3] = weights @ position[:3] - depth * np.array(normal)


@given(seeds, fractions, st.sampled_from([0.0, 0.4, 10.0]))
def test_a_particle_and_a_patch_part_and_keep_both_momenta(seed, restitution, friction):
    random, position, velocity, inverse_mass = surface(seed)
    weights, normal = random.dirichlet((1.0, 1.0, 1.0)), unit(random.normal(size=3))
    face = np.cross(position[1] - position[0], position[2] - position[0])
    assume(abs(face @ normal) > 0.2 * np.linalg.norm(face))  # not along the triangle
    approach, h = (weights @ velocity[:3] - velocity[3]) @ normal, 1e-8
    depth = random.uniform(0.0, 1.0) * max(approach * h, 0.0)  # no more than they have closed
    touching(position, weights, normal, depth)
    before, energy, start = momenta(inverse_mass, position, velocity), kinetic(inverse_mass, velocity), velocity.copy()
    material = Material(restitution, friction)
    part_particle(tuple(weights), normal, depth, material, Particles(inverse_mass, position, velocity), h)
    for after, once in zip(momenta(inverse_mass, position, velocity), before, strict=True):
        np.testing.assert_allclose(after, once, atol=1e-11)
    # In a step the place at which they touch moves by h times their sliding: with that the speed there changes.
    assert kinetic(inverse_mass, velocity) <= energy * (1.0 + 1e-14) + 10.0 * h
    parting = (velocity[3] - weights @ velocity[:3]) @ normal
    if approach > 0.0:
        assert (position[3] - weights @ position[:3]) @ normal == pytest.approx(0.0, abs=1e-5 * h)
        assert parting == pytest.approx(restitution * approach, abs=1e-5)
    else:
        np.testing.assert_array_equal(velocity, start)


def test_what_overlaps_at_rest_parts_slowly_by_half_of_the_speed_each():
    position, velocity = np.array([[0.0, 0.0, 0.0], [1, 0, 0], [0, 1, 0], [0.0, 0.0, -0.2]]), np.zeros((4, 3))
    part_particle((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.2, DEAD, Particles(np.ones(4), position, velocity), 0.1)
    np.testing.assert_allclose(velocity[[0, 3], 2], [-0.2, 0.2])
    np.testing.assert_allclose(position[[0, 3], 2], [-0.02, -0.18])


def test_what_was_pressed_together_does_not_bounce():
    """It did not close before springs and weight pressed it."""
    position, velocity = np.array([[0.0, 0.0, 0.0], [1, 0, 0], [0, 1, 0], [0.0, 0.0, -0.1]]), np.zeros((4, 3))
    velocity[3, 2] = -0.2
    particles, contacts = Particles(np.ones(4), position, velocity), new_contacts(1)
    add_particle(contacts, (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.1, Material(1.0, 0.0))
    before = particles._replace(position=position - 0.5 * velocity, velocity=np.zeros((4, 3)))
    resolve_contacts(
        contacts, Bodies(particles, NO_BODIES), Bodies(before, NO_BODIES), response_memory(np.array([0, 4]), 0), 1.0
    )
    np.testing.assert_allclose(velocity[[0, 3], 2], [-0.1, -0.1])
    np.testing.assert_allclose(position[[0, 3], 2], [-0.05, -0.05])


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
    part_box(point, normal, 0.0, Material(restitution, friction), particles, box, 1e-13)
    if not static:
        np.testing.assert_allclose(totals()[0], before[0], atol=1e-11)
        np.testing.assert_allclose(totals()[1], before[1], atol=1e-11)
    assert energy() <= start * (1.0 + 1e-13)
    if approach > 0.0 and friction == 0.0:
        assert parting() == pytest.approx(restitution * approach, abs=1e-11)


def test_a_box_and_a_patch_part_by_their_inverse_masses():
    position = np.zeros((4, 3))
    box = RigidBodies(
        np.array([1.0]), np.ones((1, 3)), np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]]), np.zeros((1, 3)),
        np.zeros((1, 3)),
    )  # fmt: skip
    particles = Particles(np.full(4, 3.0), position, np.tile([0.0, 0.0, -0.4], (4, 1)))
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
        resolve(contacts, Particles(np.ones(4), position, velocity), NO_BODIES)
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
        resolve(contacts, Particles(inverse_mass, position, velocity), NO_BODIES)
        ends.append((position, velocity))
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-12)
