"""Do steps give the same bits however they are taken, and are they split where they must be?"""

import pytest

import softbody
from softbody import World
from softbody.model.settings import INTEGRATORS
from tests.same_bits import same_bits

BALL = softbody.icosphere(1)
SOLID = softbody.octahedron()

integrators = pytest.mark.parametrize("integrator", INTEGRATORS)


def everything(integrator="rk4_velocity", axes="complete"):
    """A ball with gas that falls on the ground beside two boxes that collide."""
    world = World(integrator=integrator, axes=axes)
    world.add_ground(restitution=0.3)
    world.add_soft_body(BALL, 1.0, 200.0, 5.0, position=(5.0, 0.0, 1.2), velocity=(0.5, 0.0, -1.0))
    world.add_box((1.0, 1.0, 1.0), 2.0, (0.0, 0.0, 1.0), velocity=(1.0, 0.1, 0.0), angular_velocity=(0.1, 0.2, 0.3))
    world.add_box((1.0, 2.0, 1.0), 3.0, (1.4, 0.2, 1.1), velocity=(-1.0, 0.0, 0.0), restitution=0.5)
    return world


def test_two_worlds_stepped_alike_are_alike_to_the_bit():
    one, other = everything(), everything()
    for world in (one, other):
        world.step(1e-3, 500)
    assert same_bits(one.state, other.state)
    assert not same_bits(one.state, everything().state)


@integrators
def test_many_steps_at_once_are_as_many_single_steps_to_the_bit(integrator):
    at_once, singly = everything(integrator), everything(integrator)
    at_once.step(1e-3, 300)
    for _ in range(300):
        singly.step(1e-3)
    assert same_bits(at_once.state, singly.state)
    assert at_once.steps == singly.steps == 300
    assert at_once.time == pytest.approx(singly.time, rel=1e-12)


def test_running_for_some_seconds_is_stepping_that_often():
    one, other = World(), World()
    for world in (one, other):
        world.add_soft_body(SOLID, 1.0, 10.0, 1.0)
    one.run(0.1, 1e-3)
    other.step(1e-3, 100)
    assert one.steps == 100
    assert same_bits(one.state, other.state)


def test_no_steps_change_nothing():
    world = World()
    world.add_soft_body(SOLID, 1.0, 10.0, 1.0)
    before = world.state.copy()
    world.step(1e-3, 0)
    assert same_bits(world.state, before)


def test_an_empty_world_can_be_stepped():
    world = World()
    world.step(1e-3, 5)
    assert (world.steps, world.time) == (5, 0.005)


def test_the_first_step_is_like_any_other():
    def thrown():
        world = World()
        for x in (0.0, 1.2):
            world.add_soft_body(softbody.icosphere(1, 0.5), 1.0, 100.0, 20.0, (x, 0.0, 0.0), (-x, 0.0, 0.0))
        return world

    whole, parts = thrown(), thrown()
    whole.step(2e-3, 300)
    for steps in (0, 1, 299):
        parts.step(2e-3, steps)
    assert whole.state_hash() == parts.state_hash()
    assert whole.steps == 300


def test_all_pairs_of_soft_bodies_give_the_bits_of_the_grid():
    hashes = []
    for pairs in ("grid", "exhaustive"):
        world = World(pairs=pairs)
        world.add_ground()
        for k in range(3):
            world.add_soft_body(SOLID, 1.0, 200.0, 5.0, (0.1 * k, 0.0, 1.0 + 1.5 * k))
        world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.2, 6.0))
        world.step(2e-3, 600)
        hashes.append(world.state_hash())
    assert hashes[0] == hashes[1]


def test_a_fast_ball_goes_through_no_plate_also_where_steps_are_not_split():
    for split in (True, False):
        world = World(gravity=(0.0, 0.0, 0.0), split_steps=split)
        world.add_box((4.0, 4.0, 0.1), None)
        ball = world.add_soft_body(softbody.icosphere(1, 0.2), 0.2, 200.0, 200.0, (0.0, 0.0, 0.9), (0.0, 0.0, -100.0))
        world.run(0.02, 0.5 * world.stable_time_step())
        assert (ball.positions[:, 2] > 0.0).all()
