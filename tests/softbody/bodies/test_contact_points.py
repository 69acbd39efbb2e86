"""Does a world tell what touches what, and how hard?"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import softbody
from softbody import World
from softbody.bodies.contact_points import of_all_steps

pytestmark = pytest.mark.interpreted

WEIGHT = 9.81


def test_a_box_at_rest_is_carried_by_its_weight():
    world = World()
    world.add_ground()
    lower = world.add_box((1.0, 1.0, 0.2), 2.0, (0.0, 0.0, 0.1), friction=0.25)
    upper = world.add_box((0.5, 0.5, 0.5), 3.0, (0.0, 0.0, 0.45))
    world.run(1.0, 1.0 / 240.0)
    points = world.contact_points()
    assert points.pairs() == {(0, -1), (0, 1)}
    assert points.force_on(upper) == pytest.approx([0.0, 0.0, 3.0 * WEIGHT], abs=1e-6)
    assert points.force_on(lower) == pytest.approx([0.0, 0.0, 2.0 * WEIGHT], abs=1e-6)
    assert len(points.of(upper)) == len(points.of(upper, lower)) == len(points) - len(points.of(lower)) + 4
    assert points.friction.tolist() == pytest.approx([np.sqrt(0.125)] * len(points))
    assert (points.normal[points.b == -1] == (0.0, 0.0, 1.0)).all()


def test_soft_bodies_are_numbered_before_boxes():
    world = World()
    floor = world.add_box((2.0, 2.0, 0.2), None)
    ball = world.add_soft_body(softbody.icosphere(1, 0.3), 1.0, 500.0, 10.0, (0.0, 0.0, 0.41), (0.0, 0.0, -1.0))
    world.run(0.03, 1e-3)
    points = world.contact_points()
    assert points.pairs() == {(0, 1)}
    assert points.force_on(ball)[2] > 0.0
    assert points.force_on(floor) == pytest.approx(-points.force_on(ball))
    assert points.time_step == 1e-3


@pytest.mark.parametrize("others", [0, 1])
@pytest.mark.parametrize("steps", [1, 7])
def test_forces_of_the_ground_and_weight_are_the_change_of_momentum(steps, others):
    """By itself a ball is moved by another kernel than beside others."""
    world = World()
    world.add_ground(friction=0.8)
    ball = world.add_soft_body(softbody.icosphere(1, 0.5), 2.0, 300.0, 20.0, (0.0, 0.0, 0.49), (1.0, 0.0, -1.0))
    for k in range(others):
        world.add_box((0.1, 0.1, 0.1), 1.0, (5.0 + k, 0.0, 5.0))
    h = 1e-3
    world.step(h, steps)
    before = 2.0 * ball.velocity
    world.step(h)
    force = world.contact_points().force_on(ball)
    assert force[2] > 1.0
    assert (2.0 * ball.velocity - before) / h == pytest.approx(force - (0.0, 0.0, 2.0 * WEIGHT), rel=1e-9)


def test_a_body_that_is_gone_is_not_taken_for_the_ground():
    world = World()
    world.add_ground()
    ball = world.add_soft_body(softbody.octahedron(), 1.0, 10.0, 1.0)
    world.step(1e-3)
    points = world.contact_points()
    world.remove(ball)
    with pytest.raises(softbody.ParameterError, match="was removed from its world"):
        points.force_on(ball)


def test_what_began_and_what_ended():
    world = World()
    world.add_ground()
    world.add_box((0.2, 0.2, 0.2), 1.0, (0.0, 0.0, 0.3))
    seen = [world.contact_points().pairs()]
    for _ in world.frames(0.5):
        seen.append(world.contact_points().pairs())
    began = [now - before for before, now in pairwise(seen)]
    ended = [before - now for before, now in pairwise(seen)]
    assert [pairs for pairs in began if pairs] == [{(0, -1)}]
    assert not any(ended)


def test_nothing_touches_in_a_world_that_has_not_been_stepped_or_is_empty():
    assert len(World().contact_points()) == 0
    world = World()
    world.add_ground()
    world.add_soft_body(softbody.octahedron(), 1.0, 10.0, 1.0)
    assert len(world.contact_points()) == 0


def test_after_a_fault_there_are_no_contacts_left_over():
    world = World()
    world.add_ground()
    ball = world.add_soft_body(softbody.octahedron(), 1.0, 10.0, 1.0, velocity=(0.0, 0.0, -1.0))
    world.step(1e-3)
    assert len(world.contact_points()) == 5
    ball.velocities[0] = 1e200
    with pytest.raises(softbody.SimulationError):
        world.step(1e-3)
    assert len(world.contact_points()) == 0


def test_boxes_of_a_frame_have_the_numbers_of_its_end():
    world = World()
    world.add_ground()
    world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, 0.5))
    world.step(1e-3)
    before = world.contact_points()
    after = replace(before, a=before.a + 2, first_box=2)  # two soft bodies have come between
    assert len(before) > 0
    assert set(of_all_steps([before, after], 1e-3).a.tolist()) == {2}
