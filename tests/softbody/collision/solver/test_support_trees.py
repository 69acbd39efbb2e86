"""Are the impulses that hold all that stands found at once, and is nothing held that must not be?"""

from math import cos, radians, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from softbody import World
from softbody.collision.solver.bounces import set_targets
from softbody.collision.solver.solver_row import NORMAL_IMPULSE, TARGET, load_motion, prepare_contacts
from softbody.collision.solver.support_trees import solve_trees
from softbody.collision.solver.sweep_order import sweep_order
from softbody.collision.solver.warm_start import start_from_cache, warm_start
from softbody.dynamics.rigid_boxes import accelerate_boxes
from softbody.model.arrays import boxes_of

G, H = 9.81, 1.0 / 240.0


def pile(count, drop=0.0, friction=0.5, order=None):
    """Boxes, each a little twisted on the one below it; `order` in which they are added."""
    world = World()
    world.add_ground(friction=friction)
    for i in range(count) if order is None else order:
        half = 0.15 * sin(5.0 * i)
        place = (0.0, 0.0, 0.5 + i * (1.0 + drop))
        world.add_box((1.0, 1.0, 1.0), 1.0, place, (cos(half), 0.0, 0.0, sin(half)), friction=friction)
    return world


def before_the_sweeps(world):
    """Prepare the contacts of the world's last step once more, up to what the sweeps would start from."""
    boxes, contacts = boxes_of(world.model, world.state), world.store.contacts
    prepare_contacts(contacts, boxes)
    warm_start(contacts)
    accelerate_boxes(world.model, world.controls, world.state, H)
    motion = load_motion(boxes)
    set_targets(contacts, motion, H, 1e-6, 1)
    start_from_cache(contacts, boxes, motion, 1e-6)
    return boxes, contacts, motion


def test_a_standing_pile_is_solved_before_any_sweep():
    world = pile(12)
    world.step(H, 240)
    # What the cache lacks: all is pushed aside, by less than friction holds.
    world.controls.box_force[:, 0] = 0.02
    boxes, contacts, motion = before_the_sweeps(world)
    before = np.abs(motion).max()
    solve_trees(contacts, boxes, sweep_order(contacts, boxes), motion, 1e-6)
    # (A contact yields by 1e-6; the slowest bend of twelve boxes is some thousand times softer than one contact.)
    assert np.abs(motion).max() < 0.05 * before
    below = contacts.box[: contacts.number[1], 1] < 0
    assert contacts.row[: contacts.number[1], NORMAL_IMPULSE][below].sum() == pytest.approx(12 * G * H, rel=1e-5)


@settings(max_examples=30)
@given(st.integers(0, 10**6))
def test_no_correction_adds_energy(seed):
    random = np.random.default_rng(seed)
    world = pile(5, friction=0.3)
    world.step(H, 30)
    world.state.box_velocity[:] += random.normal(scale=0.3, size=(5, 3))
    world.state.box_angular_velocity[:] += random.normal(scale=0.3, size=(5, 3))
    boxes, contacts, motion = before_the_sweeps(world)

    def energy():
        rows = contacts.row[: contacts.number[1]]
        kinetic = 0.5 * (motion[:-1, :3] ** 2).sum() + (motion[:-1, 3:] ** 2).sum() / 12.0
        return kinetic - (rows[:, NORMAL_IMPULSE] * rows[:, TARGET]).sum()

    start = energy()
    solve_trees(contacts, boxes, sweep_order(contacts, boxes), motion, 1e-6)
    assert energy() <= start + 1e-12


@pytest.mark.parametrize("drop", [0.0, 0.1])
def test_a_twisted_pile_comes_to_rest(drop):
    world = pile(8, drop)
    world.run(4.0, H)
    places = world.state.box_position.copy()
    assert np.abs(world.state.box_velocity).max() < 1e-6
    world.run(2.0, H)
    assert np.abs(world.state.box_position - places).max() < 1e-6
    assert np.abs(places[:, :2]).max() < 0.02


def test_a_pile_rests_in_whatever_order_its_boxes_were_added():
    world = pile(8, 0.0, 0.5, np.random.default_rng(1).permutation(8).tolist())
    world.run(3.0, H)
    assert np.abs(world.state.box_velocity).max() < 1e-6


@pytest.mark.parametrize("boxes", [1, 4])
def test_boxes_on_an_incline_below_the_friction_do_not_creep(boxes):
    slope = radians(15.0)
    tilt, up = (cos(0.5 * slope), 0.0, sin(0.5 * slope), 0.0), np.array([sin(slope), 0.0, cos(slope)])
    world = World()
    world.add_box((50.0, 50.0, 1.0), None, orientation=tilt, friction=0.5)
    for i in range(boxes):
        world.add_box((1.0, 1.0, 0.4), 1.0, (0.7 + 0.4 * i) * up, tilt, friction=0.5)
    world.run(1.0, H)
    places = world.state.box_position.copy()
    world.run(10.0, H)
    assert np.abs(world.state.box_position - places).max() < 1e-7


def test_what_slides_is_not_held():
    world = pile(2, friction=0.2)
    world.step(H, 60)
    world.state.box_velocity[:, 0] = 2.0
    world.run(3.0, H)
    # Both slide on together by v²/2μg, and not a step less.
    assert world.state.box_position[:, 0] == pytest.approx([4.0 / (2.0 * 0.2 * G)] * 2, rel=1e-2)
