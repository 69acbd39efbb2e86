"""Boxes that stand on something do not give way to what presses on them; others do."""

import numpy as np
import pytest

import softbody
from softbody import World
from softbody.collision.solver.held_boxes import box_mobilities
from softbody.model.arrays import boxes_of

DOWN, UP, ASIDE = (0.0, 0.0, -1.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)


def looseness(world, push, arm=(0.0, 0.0, 0.0), box=0):
    """Return the work of a push at `arm` from a box's centre, by that on the box alone."""
    rows, bodies = np.zeros((world.model.box_count, 6)), boxes_of(world.model, world.state)
    alone, _ = box_mobilities(world.store.contacts, bodies, rows)
    rows[box] = *push, *np.cross(arm, push)
    held, _ = box_mobilities(world.store.contacts, bodies, rows)
    return rows[box] @ held[box] @ rows[box] / (rows[box] @ alone[box] @ rows[box])


def standing(*masses):
    """Return a world in which flat boxes of 1 x 1 x 0.4 m stand on each other on the ground, at rest."""
    world = World()
    world.add_ground()
    for k, mass in enumerate(masses):
        world.add_box((1.0, 1.0, 0.4), mass, (0.0, 0.0, 0.2 + 0.4 * k))
    world.run(0.1, 1.0 / 240.0)
    return world


@pytest.mark.parametrize("arm", [(0.0, 0.0, 0.2), (0.3, -0.2, 0.2), (-0.45, 0.45, 0.2)])
def test_the_ground_holds_what_presses_down_between_the_corners(arm):
    assert looseness(standing(2.0), DOWN, arm) < 1e-9


def test_a_push_up_or_aside_moves_the_box_as_if_alone():
    for push in (UP, ASIDE):
        assert looseness(standing(2.0), push) == pytest.approx(1.0, abs=1e-9)


def test_a_push_beyond_the_edge_tips_the_box():
    """About its edge: the work of a push on a plank that turns about an edge, by that on a free one."""
    arm, mass = 0.8, 2.0
    about_centre = mass / 12.0 * (1.0 + 0.16)
    about_edge = about_centre + mass * (0.5**2 + 0.2**2)
    tipping = (arm - 0.5) ** 2 / about_edge
    alone = 1.0 / mass + arm**2 / about_centre
    assert tipping / alone < looseness(standing(mass), DOWN, (arm, 0.0, 0.2)) < 1.0


def test_a_stack_holds_its_top():
    assert looseness(standing(1.0, 2.0, 3.0), DOWN, (0.1, 0.2, 0.2), box=2) < 1e-9


def test_what_does_not_stand_is_loose():
    world = World(gravity=(0.0, 0.0, 0.0))
    world.add_box((1.0, 1.0, 0.4), 1.0)
    world.add_box((1.0, 1.0, 0.4), 1.0, (0.0, 0.0, 0.4), velocity=(0.0, 0.0, -1.0))
    world.step(1e-3)
    assert looseness(world, DOWN, box=1) == 1.0


def test_supports_hold_what_a_push_does_not_open():
    """A plank's end that is pressed: it turns about the edge under it, with which it keeps touch."""
    world, rows = standing(2.0), np.zeros((1, 6))
    rows[0] = *DOWN, *np.cross((0.8, 0.0, 0.2), DOWN)
    (mobility,), (stands,) = box_mobilities(world.store.contacts, boxes_of(world.model, world.state), rows)
    assert stands
    np.testing.assert_allclose(mobility, mobility.T, atol=1e-12)
    motions = np.linalg.eigvalsh(mobility)
    assert (motions > -1e-12).all()
    assert np.sum(motions > 1e-9) == 4  # two ways to slide, one to turn about the edge, one about the upright
    push = np.random.default_rng(1).normal(size=6)
    motion = mobility @ push
    for corner in ((0.5, 0.5, -0.2), (0.5, -0.5, -0.2)):
        assert (motion[:3] + np.cross(motion[3:], corner))[2] == pytest.approx(0.0, abs=1e-3 * np.abs(motion).max())


@pytest.mark.parametrize("mass", [1.0, 1e-2, 1e-6])
def test_a_soft_ball_rests_on_a_light_box(mass):
    world = World()
    world.add_ground()
    box = world.add_box((0.6, 0.6, 0.3), mass, (0.0, 0.0, 0.15))
    ball = world.add_soft_body(softbody.icosphere(2, 0.5), 1.0, 300.0, 20.0, (0.0, 0.0, 0.85), drag=0.5)
    world.equilibrium()
    world.run(1.5, 0.5 * world.stable_time_step())
    assert box.position[2] == pytest.approx(0.15, abs=1e-3)
    assert ball.positions[:, 2].min() == pytest.approx(0.3, abs=3e-3)


def test_a_light_box_in_the_air_is_pushed_away():
    world = World(gravity=(0.0, 0.0, 0.0))
    box = world.add_box((0.6, 0.6, 0.3), 1e-2)
    ball = world.add_soft_body(softbody.icosphere(2, 0.5), 1.0, 300.0, 20.0, (0.0, 0.0, 0.7), friction=0.0)
    world.equilibrium()
    ball.velocities[:, 2] = -1.0
    world.run(1.0, 0.5 * world.stable_time_step())
    assert box.velocity[2] < -1.0
    assert world.linear_momentum() == pytest.approx((0.0, 0.0, -1.0), abs=1e-12)


def test_what_stays_above_a_gap_is_held_by_nothing():
    world = World()
    world.add_ground()
    for height in (0.05, 0.53):  # the lower box lands in this step, and the upper one stays 3 cm above it
        world.add_box((1.0, 1.0, 0.4), 1.0, (0.0, 0.0, height + 0.2), velocity=(0.0, 0.0, -6.0))
    world.step(1.0 / 60.0)
    assert looseness(world, DOWN, box=1) == 1.0
