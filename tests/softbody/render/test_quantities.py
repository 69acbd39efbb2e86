"""Numbers of vertices, by hand."""

from __future__ import annotations

import numpy as np

import softbody
from softbody.render.quantities import pressure, speed, strain


def body():
    world = softbody.World()
    world.add_soft_body(softbody.icosahedron(), 1.0, 100.0, 1.0)
    return world.add_soft_body(softbody.octahedron(), 1.0, 100.0, 3.0, (5.0, 0.0, 0.0))


def test_a_body_as_it_was_added_has_no_strain():
    np.testing.assert_allclose(strain(body()), 0.0, atol=1e-15)


def test_a_body_twice_as_large_has_a_strain_of_one_and_an_eighth_of_the_pressure():
    large = body()
    before = large.pressure
    large.positions[:] = large.centre + 2.0 * (large.positions - large.centre)
    np.testing.assert_allclose(strain(large), 1.0)
    np.testing.assert_allclose(pressure(large), before / 8.0)


def test_the_strain_of_a_vertex_is_the_mean_of_its_springs():
    """The tip of an octahedron is pulled out: its four springs are stretched, and one of the four of each neighbour."""
    pulled = body()
    tip = int(pulled.positions[:, 2].argmax())
    pulled.positions[tip, 2] += 1.0
    each = np.sqrt(5.0) / np.sqrt(2.0) - 1.0
    values = strain(pulled)
    np.testing.assert_allclose(values[tip], each)
    assert np.isclose(values, each / 4).sum() == 4
    assert np.isclose(values, 0.0).sum() == 1


def test_speed_is_the_length_of_the_velocity():
    moving = body()
    moving.velocities[:] = (3.0, 0.0, 4.0)
    np.testing.assert_allclose(speed(moving), 5.0)
