"""Is Rapier asked rightly: does it leave free boxes alone, and strike others as momentum says, where they overlap?"""

import numpy as np
import pytest

from references import rapier

UPRIGHT = [1.0, 0.0, 0.0, 0.0]
STEP = 1e-3


def head_on(aside: float, restitution: float, mass: float = 1.0) -> np.ndarray:
    """Return the velocities (2, 6) after a unit cube at 1 m/s has come to another, so far aside [m]."""
    return rapier.velocities_after(
        np.ones((2, 3)), [1.0, mass], [[-1.5, aside, 0.0], [0.0, 0.0, 0.0]], [UPRIGHT] * 2,
        [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]], np.zeros((2, 3)), STEP, 3000, restitution,
    )  # fmt: skip


def test_a_free_box_flies_and_turns_as_it_did():
    spin = [0.0, 3.0, 0.0]  # about an axis of its own
    after = rapier.velocities_after(
        [[1.0, 0.5, 0.2]], [2.0], [[3.0, 4.0, 5.0]], [UPRIGHT], [[10.0, -1.0, 2.0]], [spin], STEP, 1000
    )
    assert after[0, :3] == pytest.approx([10.0, -1.0, 2.0], abs=1e-6)
    assert after[0, 3:] == pytest.approx(spin, abs=3e-3)  # single precision, a thousand times


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_equal_cubes_head_on_share_momentum_as_newton_says(restitution):
    after = head_on(0.0, restitution)
    assert after[:, 0] == pytest.approx([0.5 * (1.0 - restitution), 0.5 * (1.0 + restitution)], abs=0.05)
    assert after[:, 0].sum() == pytest.approx(1.0, abs=1e-5)


def test_a_held_box_stays_and_stops_the_other():
    after = head_on(0.0, 0.0, np.inf)
    assert after[1] == pytest.approx(np.zeros(6), abs=0.0)
    assert after[0, 0] == pytest.approx(0.0, abs=0.15)


@pytest.mark.parametrize(("aside", "struck"), [(0.999, True), (1.001, False), (-0.999, True), (-1.001, False)])
def test_cubes_that_pass_are_struck_down_to_a_millimetre_of_overlap(aside, struck):
    after = head_on(aside, 0.0)
    assert (np.abs(after - [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0], np.zeros(6)]).max() > 1e-4) == struck


@pytest.mark.parametrize(("overlap", "struck"), [(1e-3, True), (-1e-3, False)])
def test_edges_across_each_other_meet_down_to_a_millimetre(overlap, struck):
    half = np.pi / 8.0
    about_x, about_y = [np.cos(half), np.sin(half), 0.0, 0.0], [np.cos(half), 0.0, np.sin(half), 0.0]
    velocity = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    after = rapier.velocities_after(
        np.ones((2, 3)), [1.0, 1.0], [[-2.0, 0.1, np.sqrt(2.0) - overlap], [0.0, 0.0, 0.0]], [about_x, about_y],
        velocity, np.zeros((2, 3)), STEP, 4000,
    )  # fmt: skip
    assert (np.abs(after[:, :3] - velocity).max() > 1e-4) == struck


def test_boxes_that_pass_with_little_air_are_not_struck_by_contacts_of_before():
    rng = np.random.default_rng(3)
    aside = 1.0 + rng.uniform(1e-3, 1e-2, 50)
    place = 20.0 * np.arange(50.0)
    at = np.stack([np.full((50, 2), (-1.5, 0.0)), np.stack([aside, np.zeros(50)], axis=1), place[:, None] * [1, 1]], 2)
    velocity = np.tile([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]], (50, 1))
    after = rapier.velocities_after(
        np.ones((100, 3)), np.ones(100), at.reshape(100, 3), [UPRIGHT] * 100, velocity, np.zeros((100, 3)), 2e-3, 1500
    )
    assert np.array_equal(after[:, :3], velocity)


def test_a_box_that_is_held_and_moves_keeps_its_velocities_and_pushes():
    after = rapier.velocities_after(
        np.ones((2, 3)), [np.inf, 1.0], [[-1.2, 0.0, 0.0], [0.0, 0.0, 0.0]], [UPRIGHT] * 2,
        [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]], [[0.3, 0.0, 0.0], [0.0, 0.0, 0.0]], STEP, 400,
    )  # fmt: skip
    assert after[0] == pytest.approx([1.0, 0.0, 0.0, 0.3, 0.0, 0.0], abs=1e-6)
    assert after[1, 0] == pytest.approx(1.0, abs=0.15)
