"""Boxes that move meet where and when they come to touch, and pass what they do not touch."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from softbody import World
from softbody.collision.boxes.manifold import new_manifold, swept_manifold
from softbody.collision.boxes.sat_boxes import Limits, PlacedBoxes, frames_of, least_overlap
from softbody.collision.boxes.swept_boxes import STILL, Sweep, come_near
from softbody.geometry.box import box_corners

UPRIGHT = (1.0, 0.0, 0.0, 0.0)
EIGHTH = (np.cos(np.pi / 8), 0.0, 0.0, np.sin(np.pi / 8))  # of a turn about z


def manifold_of(positions, travel, *, sizes=((1, 1, 1), (1, 1, 1)), orientations=(UPRIGHT, UPRIGHT), share=1.0):
    """Points (n, 3), depths and normal of a, which travels, against b."""
    boxes = frames_of(PlacedBoxes(*(np.array(rows, float) for rows in (sizes, positions, orientations))))
    manifold = new_manifold()
    sweep, limits = (
        Sweep(tuple(map(float, travel)), STILL, STILL, STILL, 0.0, share),
        Limits(float(np.linalg.norm(travel)), 0.0, False),
    )
    n = swept_manifold(boxes, (0, 1), sweep, limits, manifold)
    return manifold.point[:n], manifold.depth[:n], manifold.sat.normal


def test_a_box_that_comes_straight_on_meets_a_whole_face():
    point, depth, normal = manifold_of([(-2.0, 0.0, 0.0), (0.0, 0.0, 0.0)], (3.0, 0.0, 0.0))
    assert_allclose(normal, (-1.0, 0.0, 0.0))
    assert_allclose(depth, np.full(4, -1.0))
    assert_allclose(np.abs(point[:, 1:]), np.full((4, 2), 0.5))


def test_a_box_that_comes_askew_meets_what_will_be_opposite_then():
    # It moves 1 m towards b and 0.5 m up until they touch: then its lower half is above b's middle.
    point, depth, normal = manifold_of([(-2.0, 0.0, 0.0), (0.0, 0.0, 0.0)], (1.5, 0.0, 0.75))
    assert_allclose(normal, (-1.0, 0.0, 0.0))
    assert_allclose(depth, np.full(4, -1.0))
    # The points are where the box that moves has them now: its lower half.
    assert_allclose(sorted(point[:, 2]), [-0.5, -0.5, 0.0, 0.0], atol=1e-15)


def test_the_heavier_box_comes_to_the_points_of_the_lighter():
    point, _, _ = manifold_of([(-2.0, 0.0, 0.0), (0.0, 0.0, 0.0)], (1.5, 0.0, 0.75), share=0.0)
    assert_allclose(sorted(point[:, 2]), [0.0, 0.0, 0.5, 0.5], atol=1e-15)


@pytest.mark.parametrize(
    ("position", "travel"),
    [
        ((-2.0, 0.0, 1.001), (5.0, 0.0, 0.0)),  # over it
        ((-2.0, 0.0, 0.9), (5.0, 0.0, 1.0)),  # up, and over it
        ((-2.0, 0.0, 3.2), (5.0, 0.0, -1.0)),  # down behind it
        ((-2.0, 0.0, 0.0), (0.9, 0.0, 0.0)),  # not as far
        ((-2.0, 0.0, 0.0), (-5.0, 0.0, 0.0)),  # away
    ],
)
def test_boxes_that_pass_have_no_contact(position, travel):
    assert len(manifold_of([position, (0.0, 0.0, 0.0)], travel)[0]) == 0


def test_boxes_that_meet_and_part_within_a_step_touch():
    # A corner of b stands 0.207 m out of the plane that a's face moves in; a passes over it.
    at = np.sqrt(0.5) - 0.01
    point, _, _ = manifold_of([(-1.0, at + 0.5, 0.0), (0.0, 0.0, 0.0)], (4.0, 0.0, 0.0), orientations=(UPRIGHT, EIGHTH))
    assert len(point) > 0


@given(st.integers(0, 2**32 - 1))
def test_it_does_not_matter_which_box_is_called_a(seed):
    rng = np.random.default_rng(seed)
    sizes, positions, q = rng.uniform(0.3, 1.5, (2, 3)), rng.uniform(-2.0, 2.0, (2, 3)), rng.normal(size=(2, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    travel = 2.0 * rng.normal(size=3)
    one = manifold_of(positions, travel, sizes=sizes, orientations=q, share=0.3)
    other = manifold_of(positions[::-1], -travel, sizes=sizes[::-1], orientations=q[::-1], share=0.7)
    assert len(one[0]) == len(other[0])
    if len(one[0]):
        assert_allclose(one[2], -other[2], atol=1e-12)
        assert_allclose(np.sort(one[1]), np.sort(other[1]), atol=1e-9)


def test_a_box_with_five_centimetres_of_air_flies_on():
    world = World(gravity=(0.0, 0.0, 0.0))
    world.add_box((1.0, 1.0, 1.0), None)
    box = world.add_box((0.2, 0.2, 0.2), 1.0, (-1.15, 0.0, 0.65), velocity=(10.0, 0.0, 0.0))
    world.run(1.0, 1.0 / 60.0)
    assert tuple(box.velocity) == (10.0, 0.0, 0.0)
    assert not np.any(box.angular_velocity)


@pytest.mark.parametrize("gap", [0.02, 1e-3])
def test_a_box_falls_past_a_ledge(gap):
    for start in np.linspace(1.0, 3.0, 21):
        world = World()
        world.add_box((1.0, 1.0, 1.0), None)
        box = world.add_box((0.4, 0.4, 0.4), 1.0, (0.7 + gap, 0.0, start))
        world.run(1.0, 1.0 / 60.0)
        assert box.velocity[0] == 0.0
        assert_allclose(box.velocity[2], -9.81, rtol=1e-12)


def test_boxes_that_fall_together_pass_with_a_millimetre_of_air():
    # In a step of 1/30 s gravity moves a box by 11 mm; it moves both. Askew, so that no axis of the boxes parts them.
    size, q = np.array([0.6, 0.4, 0.3]), np.array([0.8, 0.0, 0.36, 0.48])
    for start in np.linspace(-3.0, -2.9, 11):
        world = World()
        world.add_box((1.0, 1.0, 1.0), 1.0)
        reach = np.abs(box_corners(tuple(size), (0.0, 0.0, 0.0), tuple(q))[:, 2]).max()
        box = world.add_box(size, 1.0, (start, 0.1, 0.501 + reach), q, velocity=(3.0, 0.0, 0.0))
        world.run(2.0, 1.0 / 30.0)
        assert_allclose(box.velocity, (3.0, 0.0, -19.62), rtol=1e-12)
        assert not np.any(box.angular_velocity)


def test_a_box_that_spins_beside_another_flies_on():
    # Its corners reach 0.71 m, and there is 0.72 m from its middle to b; without its spin it would go 0.17 m a step.
    for spin in (1.0, 10.0, 40.0):
        world = World(gravity=(0.0, 0.0, 0.0))
        world.add_box((1.0, 1.0, 1.0), None)
        box = world.add_box(
            (1.0, 1.0, 0.1), 1.0, (-3.0, 0.0, 1.22), velocity=(10.0, 0, 0), angular_velocity=(spin, 0, 0)
        )
        world.run(1.0, 1.0 / 60.0)
        assert tuple(box.velocity) == (10.0, 0.0, 0.0)
        assert tuple(box.angular_velocity) == (spin, 0.0, 0.0)


@pytest.mark.parametrize("yaw", np.linspace(0.1, 3.0, 8))
def test_a_box_that_slides_askew_over_flush_tiles_goes_straight_on(yaw):
    world = World()
    for x in range(-2, 4):
        for y in (-1, 0, 1):
            world.add_box((0.83, 0.57, 0.5), None, (0.83 * x, 0.57 * y, -0.25), friction=0.0)
    turned = np.cos(0.5 * yaw), 0.0, 0.0, np.sin(0.5 * yaw)
    box = world.add_box((0.77, 0.2, 0.34), 1.0, (0.0, 0.09, 0.17), turned, velocity=(1.57, 0.0, 0.0), friction=0.0)
    world.step(1 / 60, 60)
    assert_allclose(box.velocity, (1.57, 0.0, 0.0), atol=1e-5)
    assert_allclose(box.position[2], 0.17, atol=1e-5)


def test_a_box_that_slides_on_to_the_next_of_heavy_tiles_does_not_feel_its_side():
    world = World()
    world.add_ground(friction=0.9)
    for x in range(-2, 4):
        for y in (-1, 0, 1):
            world.add_box((0.83, 0.57, 0.5), 500.0, (0.83 * x, 0.57 * y, 0.25), friction=0.0)
    yaw = np.linspace(0.02, 3.1, 24)[13]  # its side comes to the next row as slowly as a box falls in a step
    turned = np.cos(0.5 * yaw), 0.0, 0.0, np.sin(0.5 * yaw)
    box = world.add_box((0.77, 0.2, 0.34), 1.0, (0.0, 0.09, 0.67), turned, velocity=(1.57, 0.0, 0.0), friction=0.0)
    world.step(1 / 60, 60)
    assert_allclose(box.velocity, (1.57, 0.0, 0.0), atol=1e-3)


@given(st.integers(0, 10**6))
def test_boxes_far_apart_never_come_near_however_fast_they_spin(seed):
    rng = np.random.default_rng(seed)
    place = np.array([[0.0, 0.0, 0.0], [6.0, 0.0, 8.0]])
    boxes = frames_of(PlacedBoxes(rng.uniform(0.2, 2.0, (2, 3)), place, np.array([UPRIGHT, UPRIGHT])))
    spin, memory = tuple(1e6 * rng.normal(size=3)), new_manifold().sat
    apart, _ = least_overlap(boxes, 0, 1, Limits(10.0, 0.0, False), memory)
    assert not come_near(boxes, (0, 1), Sweep(STILL, STILL, spin, spin, 1.0, 0.5), 1e-6, apart, memory)
