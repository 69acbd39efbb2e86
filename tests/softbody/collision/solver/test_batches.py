"""Are eight pairs of boxes solved side by side as if one after the other, to the last bit?"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from softbody import World
from softbody.collision.solver import sequential_impulses
from softbody.collision.solver.batches import FRICTION, batches_of, take_impulses
from softbody.collision.solver.solver_row import (
    COUPLING,
    INVERSE_A,
    INVERSE_B,
    MASS,
    NORMAL,
    NORMAL_IMPULSE,
    SECOND,
    SECOND_COUPLING,
    SECOND_IMPULSE,
    TANGENT,
    TANGENT_IMPULSE,
    TANGENT_MASS,
    TARGET,
    TURN_A,
    TURN_B,
    load_motion,
    load_pair,
    load_three,
    speed_along,
)
from softbody.collision.solver.sweep_order import sweep_order
from softbody.compiler.simd import LANES
from softbody.linalg.vec import add, scale, sub
from softbody.model.arrays import NOBODY, boxes_of
from softbody.model.material import within_friction_cone


def heap(seed, count=24):
    """Boxes of many sizes, masses and materials, thrown at each other, a static one and the ground."""
    rng = np.random.default_rng(seed)
    world = World()
    world.add_ground(friction=0.4)
    world.add_box((2.0, 2.0, 0.4), None, (0.0, 0.0, 0.2))
    for i in range(count):
        q = rng.normal(size=4)
        place = (rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0), 0.5 + 0.12 * i)
        size, mass = rng.uniform(0.3, 1.0, 3), 10.0 ** rng.uniform(-1.0, 1.0)
        world.add_box(size, mass, place, q / np.linalg.norm(q), friction=rng.uniform(0.0, 1.0))
    return world


def solved(seed, steps=40):
    """Return the contacts, pairs and motions of a heap, as its last step has left them, and not solved to the end."""
    world = heap(seed)
    world.step(1.0 / 240.0, steps)
    bodies = boxes_of(world.model, world.state)
    motion = load_motion(bodies) + np.random.default_rng(seed).normal(0.0, 0.1, (len(bodies.inverse_mass) + 1, 6))
    motion[-1] = 0.0
    motion[:-1][bodies.inverse_mass == 0.0] = 0.0
    return world.store.contacts, sweep_order(world.store.contacts, bodies).pairs, motion


def combined(row, k, column, impulse):
    """Return the sum of what an impulse along three directions does, from `column` on."""
    normal, first, second = (load_three(row, k, column + 3 * d) for d in range(3))
    return add(scale(impulse[0], normal), add(scale(impulse[1], first), scale(impulse[2], second)))


def sweep_singly(contacts, pairs, down, motion):
    """Do what a sweep does, contact by contact: the plain form."""
    row, most = contacts.row, 0.0
    for start, end in reversed(pairs.tolist()) if down else pairs.tolist():
        a, b = contacts.box[start]
        v_a, w_a, v_b, w_b = load_pair(motion, a, b)
        for k in range(end - 1, start - 1, -1) if down else range(start, end):
            pair = v_a, w_a, v_b, w_b
            before, before_1, before_2 = (float(x) for x in load_three(row, k, NORMAL_IMPULSE))
            normal = max(0.0, before + row[k, MASS] * (row[k, TARGET] - speed_along(row, k, NORMAL, pair)))
            change = normal - before
            slide_1 = speed_along(row, k, TANGENT, pair) + change * row[k, COUPLING]
            slide_2 = speed_along(row, k, SECOND, pair) + change * row[k, SECOND_COUPLING]
            first, second = within_friction_cone(
                before_1 - row[k, TANGENT_MASS] * slide_1,
                before_2 - row[k, TANGENT_MASS] * slide_2,
                contacts.friction[k] * normal,
            )
            s, t = first - before_1, second - before_2
            row[k, NORMAL_IMPULSE], row[k, TANGENT_IMPULSE], row[k, SECOND_IMPULSE] = normal, first, second
            most = max(most, abs(change) / row[k, MASS], (abs(s) + abs(t)) / row[k, TANGENT_MASS])
            along, turn_a, turn_b = (combined(row, k, column, (change, s, t)) for column in (0, TURN_A, TURN_B))
            v_a, v_b = add(v_a, scale(row[k, INVERSE_A], along)), sub(v_b, scale(row[k, INVERSE_B], along))
            w_a, w_b = add(w_a, turn_a), sub(w_b, turn_b)
        motion[a] = (*v_a, *w_a)
        if b != NOBODY:
            motion[b] = (*v_b, *w_b)
    return most


@pytest.mark.parametrize("seed", range(4))
def test_sweeps_in_lanes_are_those_of_one_contact_after_the_other_to_the_last_bit(seed):
    contacts, pairs, motion = solved(seed)
    assert len(pairs) > 2 * LANES
    rows, motions = contacts.row.copy(), motion.copy()
    for down in (True, False, True, True, False):
        batches = batches_of(contacts, pairs, len(motion) - 1)
        changed = sequential_impulses._sweep(batches, down, motion.reshape(-1))
        take_impulses(contacts, batches)
        plain = contacts._replace(row=rows)
        assert sweep_singly(plain, pairs, down, motions) == changed
        assert motion.tobytes() == motions.tobytes()
        count = contacts.number[1]
        assert contacts.row[:count].tobytes() == rows[:count].tobytes()


@settings(max_examples=20)
@given(st.integers(0, 10**6), st.integers(1, 60))
def test_batches_hold_each_contact_once_and_keep_the_order_of_every_body(seed, steps):
    contacts, pairs, motion = solved(seed, steps)
    batches = batches_of(contacts, pairs, len(motion) - 1)
    count = contacts.number[1]
    slot, lane = np.divmod(batches.place[:count], LANES)
    assert len(set(batches.place[:count].tolist())) == count
    batch = np.searchsorted(batches.start, slot, "right") - 1
    np.testing.assert_array_equal(batches.row[slot, :57, lane], contacts.row[:count, :57])
    np.testing.assert_array_equal(batches.row[slot, FRICTION, lane], contacts.friction[:count])
    last = np.full(len(motion), -1)
    for start, end in pairs:
        assert len(set(batch[start:end])) == 1 == len(set(lane[start:end]))
        assert (np.diff(slot[start:end]) == 1).all()
        for side, share in ((0, INVERSE_A), (1, INVERSE_B)):
            body = contacts.box[start, side]
            assert batches.body[batch[start], side, lane[start]] == 6 * (body if body >= 0 else len(motion) - 1)
            assert batches.share[batch[start], side, lane[start]] == contacts.row[start, share]
            if contacts.row[start, share] > 0.0:
                assert last[body] < batch[start]
                last[body] = batch[start]


def test_boxes_that_do_not_touch_fill_batches():
    world = World()
    world.add_ground()
    for i in range(20):
        world.add_box((1.0, 1.0, 1.0), 1.0, (2.0 * i, 0.0, 0.5))
    world.step(1e-3)
    bodies = boxes_of(world.model, world.state)
    batches = batches_of(world.store.contacts, sweep_order(world.store.contacts, bodies).pairs, 20)
    assert np.diff(batches.start).tolist() == [4, 4, 4]
