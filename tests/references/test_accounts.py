"""Are the judge's sums right? Bodies whose energy and momenta are known by heart."""

import numpy as np

from references import accounts

DOWN = np.array([0.0, 0.0, -10.0])


def test_a_stone_that_flies_has_its_three():
    stone = accounts.of_particles(np.array([2.0]), np.array([[0.0, 1.0, 3.0]]), np.array([[4.0, 0.0, 0.0]]), DOWN)
    assert stone.energy == 16.0 + 60.0
    assert list(stone.momentum) == [8.0, 0.0, 0.0]
    assert list(stone.angular_momentum) == [0.0, 24.0, -8.0]


def test_a_force_gives_less_energy_where_it_has_pushed():
    stone = accounts.of_particles(np.array([1.0]), np.array([[3.0, 0.0, 0.0]]), np.zeros((1, 3)), 0.0 * DOWN, 2.0)
    assert stone.energy == -6.0


def test_a_box_that_lies_on_its_side_spins_about_the_axis_that_is_up():
    # A quarter turn about x brings the box's y, the long side, up.
    turn = np.array([[np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0]])
    size, mass, spin = np.array([[1.0, 2.0, 3.0]]), np.array([12.0]), np.array([[0.0, 0.0, 2.0]])
    box = accounts.of_boxes(size, mass, np.zeros((1, 3)), turn, np.zeros((1, 3)), spin, DOWN)
    assert np.isclose(box.energy, 0.5 * (1.0 + 9.0) * 4.0)
    assert np.allclose(box.angular_momentum, [0.0, 0.0, 20.0])


def test_no_boxes_have_nothing():
    none = accounts.of_boxes(
        *(np.zeros((0, k)) for k in (3,)), np.zeros(0), *(np.zeros((0, k)) for k in (3, 4, 3, 3)), DOWN
    )
    assert none.energy == 0.0
    assert not none.momentum.any()
