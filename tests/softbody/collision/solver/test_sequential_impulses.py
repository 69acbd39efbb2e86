"""Do contacts solved together hold what rests, part what meets, and never push what they should not?"""

from math import cos, radians, sin, tan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from softbody import World
from softbody.model.arrays import NOBODY

G = 9.81


def about_y(degrees):
    return cos(radians(degrees) / 2), 0.0, sin(radians(degrees) / 2), 0.0


def stack(count, **options):
    world = World(**options)
    world.add_ground()
    return world, [world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, 0.5 + i)) for i in range(count)]


def test_ten_boxes_stand_for_twenty_seconds():
    world, boxes = stack(10)
    world.step(1 / 240, 4800)
    heights = [box.position[2] for box in boxes]
    # Each of ten contacts is allowed g h² of depth.
    assert heights == pytest.approx(np.arange(10) + 0.5, abs=10 * G / 240**2)
    assert np.abs(world.state.box_position[:, :2]).max() < 0.01
    assert np.abs(world.state.box_velocity).max() < 1e-2


def test_the_impulses_under_a_stack_carry_its_weight():
    world, _ = stack(3)
    world.step(1e-3, 2000)
    count = world.store.contacts.number[0]
    below = world.store.contacts.box[:count, 1]
    for box, weight in ((NOBODY, 3 * G), (0, 2 * G), (1, G)):
        assert world.store.contacts.impulse[:count][below == box].sum(axis=0) == pytest.approx(
            [0.0, 0.0, weight * 1e-3], abs=1e-9
        )


def test_a_box_on_an_incline_holds_if_and_only_if_the_slope_is_below_the_friction():
    for degrees, holds in ((26.0, True), (27.2, False)):  # tan = 0.488 and 0.514
        world = World()
        q = about_y(degrees)
        up = np.array([sin(radians(degrees)), 0.0, cos(radians(degrees))])
        world.add_box((20.0, 20.0, 1.0), None, orientation=q, friction=0.5)
        box = world.add_box((1.0, 1.0, 0.5), 2.0, 0.75 * up, q, friction=0.5)
        world.step(1e-3, 2000)
        slid = np.linalg.norm(box.position - 0.75 * up)
        if holds:
            assert slid < 1e-6
        else:
            slope = radians(degrees)
            assert slid == pytest.approx(0.5 * G * (sin(slope) - 0.5 * cos(slope)) * 4.0, rel=5e-3)
        assert tan(radians(degrees)) < 0.5 or not holds


def test_a_box_that_slides_stops_after_v2_over_2_mu_g():
    world = World()
    world.add_ground(friction=0.5)
    box = world.add_box((1.0, 1.0, 0.2), 1.0, (0.0, 0.0, 0.1), velocity=(1.2, 1.6, 0.0), friction=0.5)
    world.step(1e-3, 1000)
    assert np.linalg.norm(box.position[:2]) == pytest.approx(4.0 / (2 * 0.5 * G), rel=1e-2)
    assert np.abs(box.velocity).max() < 1e-12


@pytest.mark.parametrize("ground", ["ground", "static box"])
def test_a_lively_box_bounces_for_ever_to_the_same_height(ground):
    world = World()
    if ground == "ground":
        world.add_ground(restitution=1.0)
    else:
        world.add_box((9.0, 9.0, 1.0), None, (0.0, 0.0, -0.5), restitution=1.0)
    box = world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, 1.5))
    tops, last = [], 0.0
    for _ in range(9000):
        world.step(1e-3)
        if box.velocity[2] <= 0.0 < last:
            tops.append(box.position[2] - 0.5)
        last = box.velocity[2]
    assert len(tops) == 9
    # The highest of all steps is lower than the top between them by g h² at most; nine bounces lose 3e-7.
    assert tops == pytest.approx([1.0] * 9, abs=G * 1e-6 + 5e-7)


def test_a_fast_box_does_not_pass_through_a_thin_plate():
    world = World(gravity=(0.0, 0.0, 0.0))
    world.add_box((10.0, 10.0, 0.05), None)
    box = world.add_box((0.2, 0.2, 0.2), 1.0, (0.0, 0.0, 2.0), velocity=(0.0, 0.0, -100.0))
    world.step(1e-2, 10)
    assert box.position[2] >= 0.125 - 1e-9
    assert box.velocity[2] >= -1e-9


@pytest.mark.parametrize("offset", [(0.0, 0.0, 0.0), (0.01, 0.02, 0.03), (0.3, 0.0, 0.0)])
def test_boxes_that_start_deep_inside_each_other_part_without_gaining_speed(offset):
    world = World(gravity=(0.0, 0.0, 0.0))
    world.add_box((1.0, 1.0, 1.0), 1.0)
    world.add_box((1.0, 1.0, 1.0), 3.0, offset, (cos(0.1), sin(0.1), 0.0, 0.0))
    world.add_box((1.0, 1.0, 1.0), 0.1, (0.2, 0.2, 0.2))
    world.step(1e-2, 500)
    assert np.abs(world.state.box_velocity).max() == 0.0
    assert np.abs(world.state.box_angular_velocity).max() == 0.0
    contacts = world.store.contacts
    assert (contacts.depth[: contacts.number[0]] < 1e-3).all()


seeds = st.integers(0, 10**6)


def tangle(seed, e=0.0, friction=0.5, **options):
    """Some cubes (which keep their energy of rotation) in flight close to each other, far from the ground."""
    random = np.random.default_rng(seed)
    world = World(gravity=(0.0, 0.0, 0.0), **options)
    for _ in range(6):
        q = random.normal(size=4)
        world.add_box(
            [random.uniform(0.5, 1.0)] * 3, random.uniform(0.5, 2.0), random.uniform(-0.8, 0.8, 3),
            q / np.linalg.norm(q), random.normal(size=3), random.normal(size=3), restitution=e, friction=friction,
        )  # fmt: skip
    return world


@given(seeds, st.floats(0.0, 2.0))
def test_without_restitution_no_step_adds_energy_of_motion(seed, friction):
    world = tangle(seed, friction=friction, iterations=100)
    energy = world.energy()
    for _ in range(20):
        world.step(1e-3)
        # Friction is bounded by normal impulses that still change a little in the last sweep.
        assert world.energy() <= energy * (1.0 + 1e-6)
        energy = world.energy()


@given(seeds, st.floats(0.0, 1.0))
def test_impulses_conserve_momentum(seed, e):
    world = tangle(seed, e)
    before = world.linear_momentum()
    world.step(1e-3, 20)
    assert world.linear_momentum() == pytest.approx(before, abs=1e-13)


@given(seeds)
def test_contacts_only_push_and_friction_stays_in_its_cone(seed):
    world = tangle(seed, friction=0.3)
    world.step(1e-3, 5)
    count = world.store.contacts.number[0]
    normal, impulse = world.store.contacts.normal[:count], world.store.contacts.impulse[:count]
    push = np.sum(normal * impulse, axis=1)
    assert (push >= -1e-15).all()
    assert (np.linalg.norm(impulse - push[:, None] * normal, axis=1) <= 0.3 * push + 1e-12).all()


def test_one_run_of_many_steps_is_many_runs_of_one():
    first, second = tangle(1), tangle(1)
    first.step(1e-3, 40)
    for _ in range(40):
        second.step(1e-3)
    assert all((a == b).all() for a, b in zip(first.state, second.state))


def test_all_pairs_and_the_grid_give_the_same_bits():
    first, second = tangle(2), tangle(2, pairs="exhaustive")
    first.step(1e-3, 40)
    second.step(1e-3, 40)
    assert all((a == b).all() for a, b in zip(first.state, second.state))
