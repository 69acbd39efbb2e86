"""Are the contacts of boxes found, however many there are?"""

import numpy as np
import pytest

from softbody import World
from softbody.collision.boxes.box_contacts import find_box_contacts
from softbody.collision.boxes.manifold import new_manifold
from softbody.collision.contact import new_contacts

pytestmark = pytest.mark.interpreted


def test_contacts_beyond_the_capacity_are_counted_and_found_again_when_there_is_room():
    world = World()
    world.add_ground()
    for i in range(3):
        world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, 0.5 + i))
    few = new_contacts(5)
    what = world.model, world.controls, world.state, new_manifold()
    more = find_box_contacts(*what, few, world.store.settings, 1e-3)
    assert few.number.tolist() == more.number.tolist() == [12, 12]
    assert more.depth.shape[0] >= 12
    assert (more.box[:5] == few.box).all()
    again = find_box_contacts(*what, more, world.store.settings, 1e-3)
    assert again.depth.shape == more.depth.shape
    assert (again.box[:12] == more.box[:12]).all()


STEP = 1.0 / 60.0


def falling(heights, speed=6.0, ground=True, restitution=0.0):
    """Return a world of unit cubes that fall at `speed` [m/s], their lower faces at `heights` [m]."""
    world = World()
    if ground:
        world.add_ground()
    for k, height in enumerate(heights):
        turned = (np.cos(0.1 * k), 0.0, 0.0, np.sin(0.1 * k))
        place = (0.0, 0.0, height + 0.5)
        world.add_box((1.0, 1.0, 1.0), 1.0, place, turned, (0.0, 0.0, -speed), restitution=restitution)
    return world


def deepest(world):
    """Return how deep [m] any two neighbours of a column are inside each other, or the lowest in the ground."""
    heights = world.state.box_position[:, 2]
    return max(0.5 - heights[0], (1.0 - np.diff(heights)).max())


def test_boxes_that_fall_alike_stop_each_other_as_the_lowest_is_stopped():
    world = falling([0.02, 1.05, 2.06, 3.07, 4.15])
    for _ in range(10):
        world.step(STEP)
        assert deepest(world) < 9.81 * STEP**2


def test_boxes_that_fall_alike_and_meet_nothing_fly_as_if_alone():
    together = falling([9.0, 10.03], ground=False)
    alone = falling([9.0], ground=False)
    together.step(STEP, 5)
    alone.step(STEP, 5)
    np.testing.assert_array_equal(together.state.box_position[0], alone.state.box_position[0])
    np.testing.assert_array_equal(together.state.box_velocity[1], together.state.box_velocity[0])


def test_what_bounces_strikes_what_comes_after_it_within_the_step():
    world = falling([0.02, 1.08], restitution=1.0)
    world.step(STEP)
    np.testing.assert_allclose(world.state.box_velocity[:, 2], 6.0, rtol=1e-9)
    world.step(STEP)
    assert deepest(world) < 1e-9
