"""Are the paper's rules in plain NumPy a fair judge? Contacts whose outcome is known by hand."""

import numpy as np
import pytest

from references.paper_contact import Block, Skin, collide

TETRAHEDRON = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
TRIANGLES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def skin(offset, velocity, mass=4.0):
    return Skin(TETRAHEDRON + offset, np.tile(np.asarray(velocity, float), (4, 1)), np.full(4, mass / 4), TRIANGLES)


def block(mass, position, velocity=(0.0, 0.0, 0.0)):
    return Block(
        np.ones(3), mass, np.asarray(position, float), np.array([1.0, 0.0, 0.0, 0.0]), np.array(velocity), np.zeros(3)
    )


def test_a_particle_goes_half_of_its_depth_and_bounces_off_a_free_box_by_the_reduced_mass():
    body, box = skin((-1.45, 0.05, 0.1), (2.0, 0.0, 0.0)), block(3.0, (0.0, 0.0, 0.0))  # its tip is in the box
    assert len(collide(body, box, 0.5)) == 1
    assert body.position[1] == pytest.approx((-0.475, 0.05, 0.1), abs=1e-15)
    assert box.position == pytest.approx((0.025, 0.0, 0.0), abs=1e-15)
    arm, out = body.position[1] - box.position, np.array([-1.0, 0.0, 0.0])
    spin = np.cross(arm, out) / 0.5  # the moment of inertia of a unit cube of 3 kg
    j = 1.5 * 2.0 / (1.0 + 1.0 / 3.0 + np.cross(spin, arm) @ out)
    assert body.velocity[1] == pytest.approx((2.0 - j, 0.0, 0.0), abs=1e-14)
    assert box.velocity == pytest.approx((j / 3.0, 0.0, 0.0), abs=1e-14)
    assert box.angular_velocity == pytest.approx(-j * spin, abs=1e-14)


def test_a_particle_goes_all_of_its_depth_off_a_fixed_box():
    body, box = skin((-1.45, 0.05, 0.1), (2.0, 1.0, 0.0)), block(np.inf, (0.0, 0.0, 0.0))
    collide(body, box, 1.0)
    assert body.position[1] == pytest.approx((-0.5, 0.05, 0.1), abs=1e-15)
    assert body.velocity[1] == pytest.approx((-2.0, 1.0, 0.0), abs=1e-14)


def test_the_second_corner_finds_what_the_first_has_left():
    """Four corners of a box in one face: the first moves all of the face, and of the box, by half of the depth."""
    body = Skin(10.0 * TETRAHEDRON, np.zeros((4, 3)), np.ones(4), TRIANGLES)
    box = block(1.0, (2.0, 2.0, -0.4), (0.0, 0.0, 1.0))
    assert len(collide(body, box, 0.0)) == 4
    # After the first corner the face is 0.1 above all four: the others move nothing more.
    assert box.position[2] == pytest.approx(-0.4 - 0.05, abs=1e-15)
    assert body.position[[0, 1, 2], 2] == pytest.approx(0.05, abs=1e-15)


def test_momentum_is_kept():
    body, other = skin((0.0, 0.0, 0.0), (1.0, 0.0, 0.5)), skin((0.1, 0.15, 0.6), (-1.0, 0.3, -2.0), 12.0)
    before = sum((s.mass[:, None] * s.velocity).sum(0) for s in (body, other))
    assert len(collide(body, other, 0.3)) > 0
    assert sum((s.mass[:, None] * s.velocity).sum(0) for s in (body, other)) == pytest.approx(before, abs=1e-14)


def test_bodies_apart_are_left_alone():
    body, box = skin((3.0, 0.0, 0.0), (1.0, 0.0, 0.0)), block(1.0, (0.0, 0.0, 0.0))
    assert collide(body, box, 1.0) == []
    assert (body.position == TETRAHEDRON + (3.0, 0.0, 0.0)).all()
