"""Is Capytaine asked rightly: the hydrostatics of boxes, of what is under water and of what is not, in closed form?"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from references import capytaine


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_a_box_floats_as_its_closed_forms_say(cases, unit):
    vertices, triangles = cases.cube()
    width, length, height, part = 2.0 * unit, 3.0 * unit, 1.2 * unit, 0.6
    place = np.array([5.0, -7.0, 11.0]) * unit
    middle, level = place + 0.5 * np.array([width, length, height]), place[2] + part * height
    found = capytaine.hydrostatics(vertices * [width, length, height] + place, triangles, middle, level)
    area, volume = width * length, width * length * part * height
    under = -0.5 * (1.0 - part) * height  # the centre of buoyancy, from that of mass
    roll, pitch = length**2 * area / 12.0 + volume * under, width**2 * area / 12.0 + volume * under
    assert_allclose([found.volume, found.waterplane], [volume, area], rtol=1e-13)
    assert_allclose(found.centre, middle + [0.0, 0.0, under], rtol=1e-13)
    assert_allclose(found.metacentric_heights, [roll / volume, pitch / volume], rtol=1e-12)
    powers = np.array([unit, unit**2, unit**2, unit**2])
    expected = np.diag([area, roll, pitch, 0.0]) / np.outer(powers, powers)
    assert_allclose(found.stiffness / np.outer(powers, powers), expected, rtol=1e-12, atol=1e-12)


def test_what_heaves_aside_of_its_centre_rolls_and_pitches(cases):
    vertices, triangles = cases.cube()  # it is lifted by one; the liquid pulls at its middle, (0.5, 0.5)
    found = capytaine.hydrostatics(vertices, triangles, np.array([0.3, 0.1, 0.5]), 0.25)
    assert_allclose(found.stiffness[:, 0], [1.0, 0.4, -0.2, 0.0], atol=1e-14)
    assert_allclose(found.stiffness[1:3, 3], [-0.25 * 0.2, -0.25 * 0.4], atol=1e-14)
    assert_allclose(found.stiffness[1, 2], -0.4 * 0.2, atol=1e-14)


def test_what_is_all_under_water_has_no_waterplane(cases):
    vertices, triangles = cases.solid("octahedron", 1.0)
    found = capytaine.hydrostatics(vertices, triangles, np.array([0.0, 0.0, -0.1]), 5.0)
    assert_allclose(found.volume, 4.0 / 3.0, rtol=1e-14)
    assert_allclose(found.waterplane, 0.0, atol=1e-15)
    assert_allclose(found.metacentric_heights, 0.1, rtol=1e-12)  # the centre of buoyancy above that of mass


def test_what_is_above_the_liquid_resists_nothing(cases):
    found = capytaine.hydrostatics(*cases.cube(), np.array([0.5, 0.5, 0.5]), -0.1)
    assert found.volume == found.waterplane == 0.0
    assert not found.stiffness.any()
