"""Does the solver sweep from what cannot move up to the tops, however the boxes were numbered?"""

import numpy as np
import pytest

from softbody import World
from softbody.collision.solver.sweep_order import sweep_order
from softbody.model.arrays import boxes_of


def ordered(world):
    """Take a step; return the pairs of bodies in the order of the sweeps, and the level of each body."""
    world.step(1e-3)
    order = sweep_order(world.store.contacts, boxes_of(world.model, world.state))
    return world.store.contacts.box[order.pairs[:, 0]].tolist(), order.level.tolist()


@pytest.mark.parametrize("heights", [(0, 1, 2, 3), (3, 2, 1, 0), (2, 0, 3, 1)])
def test_the_pairs_of_a_pile_come_from_below(heights):
    world = World()
    world.add_ground()
    for height in heights:
        world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, 0.5 + height))
    pairs, level = ordered(world)
    assert level == [height + 1 for height in heights] + [0]
    tops = [max(heights[body] for body in pair if body >= 0) for pair in pairs]
    assert tops == [0, 1, 2, 3]


def test_a_static_box_is_as_low_as_the_ground_and_what_hangs_in_the_air_comes_last():
    world = World(gravity=(0.0, 0.0, 0.0))
    for x in (5.0, 6.0, 1.0, 0.0):
        world.add_box((1.0, 1.0, 1.0), None if x == 0.0 else 1.0, (x, 0.0, 0.0))
    pairs, level = ordered(world)
    assert [sorted(pair) for pair in pairs] == [[2, 3], [0, 1]]
    assert level == [5, 5, 1, 0, 0]


def test_each_pair_is_listed_once_with_all_its_contacts():
    world = World()
    world.add_ground()
    for k in range(6):
        world.add_box((1.0, 1.0, 1.0), 1.0, (0.6 * (k % 3), 0.0, 0.5 + k // 3))
    world.step(1e-3)
    order = sweep_order(world.store.contacts, boxes_of(world.model, world.state))
    contacts = np.concatenate([np.arange(first, end) for first, end in order.pairs])
    assert sorted(contacts.tolist()) == list(range(world.store.contacts.number[1]))
    for first, end in order.pairs:
        assert (world.store.contacts.box[first:end] == world.store.contacts.box[first]).all()


def test_no_contacts_no_pairs():
    world = World()
    world.add_box((1.0, 1.0, 1.0), 1.0)
    pairs, level = ordered(world)
    assert pairs == []
    assert level == [2, 0]
