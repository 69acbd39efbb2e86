"""Are copies copies, and views views?"""

import numpy as np

from softbody import World
from softbody.state import appended, boxes_of


def test_a_copy_of_a_state_shares_no_memory_with_it():
    world = World()
    world.add_box((1.0, 1.0, 1.0), 1.0, velocity=(1.0, 2.0, 3.0))
    copy = world.state.copy()
    world.state.box_velocity[:] = 0.0
    assert copy.box_velocity.tolist() == [[1.0, 2.0, 3.0]]


def test_the_boxes_of_a_world_are_views_of_it():
    world = World()
    world.add_box((1.0, 1.0, 1.0), 2.0, velocity=(1.0, 2.0, 3.0))
    bodies = boxes_of(world.model, world.state)
    bodies.velocity[0] = (4.0, 5.0, 6.0)
    assert world.state.box_velocity.tolist() == [[4.0, 5.0, 6.0]]
    assert bodies.inverse_mass.tolist() == [0.5]
    assert np.shares_memory(bodies.position, world.state.box_position)


def test_appending_keeps_what_was_there_and_copies_seldom():
    rows = np.empty((0, 3))
    kept, memories = [], set()
    for k in range(100):
        rows = appended(rows, np.full((2, 3), k))
        kept.append(rows)
        memories.add(rows.ctypes.data)
    assert rows.tolist() == np.repeat(np.arange(100.0), 2)[:, None].repeat(3, axis=1).tolist()
    assert kept[30].tolist() == rows[:62].tolist()
    assert rows.flags.c_contiguous
    assert len(memories) < 12
    assert appended(np.arange(3), 7).tolist() == [0, 1, 2, 7]
