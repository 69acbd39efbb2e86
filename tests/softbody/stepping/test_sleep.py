"""Do bodies fall asleep when they have been slow for long, and does what ought to wake them do so?"""

import numpy as np
import pytest

import softbody
from softbody import World

pytestmark = pytest.mark.interpreted

STEP = 1.0 / 240.0


@pytest.fixture
def floor():
    """A world of a box that lies on the ground, and one that lies far away from it, both asleep."""
    world = World(sleep_speed=0.02, sleep_after=0.1)
    world.add_ground()
    for x in (0.0, 10.0):
        world.add_box((1.0, 1.0, 1.0), 2.0, (x, 0.0, 0.5))
    world.run(0.5, STEP)
    assert all(box.is_asleep for box in world.boxes)
    return world


def test_nobody_sleeps_unless_told():
    world = World()
    world.add_ground()
    box = world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 0.0, 0.5))
    world.run(2.0, STEP)
    assert not box.is_asleep


def test_who_sleeps_does_not_move_and_is_told_its_contacts(floor):
    before = floor.state_hash()
    floor.run(1.0, STEP)
    assert floor.state_hash() == before
    assert floor.contact_points().pairs() == {(0, -1), (1, -1)}
    assert floor.contact_points().force_on(floor.boxes[0]) == pytest.approx((0.0, 0.0, 2.0 * 9.81), abs=1e-6)


def test_two_boxes_that_float_apart_sleep_each_by_itself(floor):
    floor.boxes[0].velocity = (0.0, 0.0, 1.0)
    floor.step(STEP)
    assert [box.is_asleep for box in floor.boxes] == [False, True]
    assert floor.boxes[0].velocity[2] == pytest.approx(1.0 - 9.81 * STEP)


CHANGES = {
    "velocity": lambda world, box: box.velocity.__setitem__(2, 0.5),
    "angular velocity": lambda world, box: box.angular_velocity.__setitem__(2, 0.5),
    "position": lambda world, box: box.position.__setitem__(2, 3.0),
    "orientation": lambda world, box: setattr(box, "orientation", (np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0)),
    "force": lambda world, box: box.apply_force((50.0, 0.0, 0.0)),
    "torque": lambda world, box: box.apply_torque((0.0, 0.0, 50.0)),
    "wake": lambda world, box: box.wake(),
}


@pytest.mark.parametrize("change", CHANGES)
def test_what_changes_of_a_box_wakes_that_one(floor, change):
    CHANGES[change](floor, floor.boxes[0])
    floor.step(STEP)
    assert [box.is_asleep for box in floor.boxes] == [False, True]


ALL = {
    "gravity": lambda world: setattr(world, "gravity", (0.0, 0.0, 9.81)),
    "friction": lambda world: setattr(world.boxes[1], "friction", 0.1),
    "ground": lambda world: setattr(world.ground, "height", -0.1),
    "another body": lambda world: world.add_box((1.0, 1.0, 1.0), 1.0, (0.0, 90.0, 0.5)),
    "one body less": lambda world: world.remove(world.boxes[1]),
}


@pytest.mark.parametrize("change", ALL)
def test_what_acts_on_all_wakes_all(floor, change):
    ALL[change](floor)
    floor.step(STEP)
    assert not any(box.is_asleep for box in floor.boxes)


def test_a_floor_that_is_taken_away_wakes_what_lay_on_it():
    world = World(sleep_speed=0.02, sleep_after=0.1)
    floor = world.add_box((4.0, 4.0, 1.0), None, (0.0, 0.0, -0.5))
    box = world.add_box((1.0, 1.0, 1.0), 2.0, (0.0, 0.0, 0.5))
    world.run(0.5, STEP)
    assert box.is_asleep
    floor.position = (0.0, 0.0, -9.0)
    world.run(0.1, 1e-3)
    assert box.position[2] == pytest.approx(0.5 - 0.5 * 9.81 * 0.1**2, abs=1e-3)


def test_a_floor_that_moves_takes_along_what_slept_on_it():
    world = World(sleep_speed=0.02, sleep_after=0.1)
    floor = world.add_box((4.0, 4.0, 1.0), None, (0.0, 0.0, -0.5))
    box = world.add_box((1.0, 1.0, 1.0), 2.0, (0.0, 0.0, 0.5))
    world.run(0.5, STEP)
    floor.move_to((0.3, 0.0, -0.5), seconds=1.0)
    world.run(0.9, STEP)
    assert not box.is_asleep
    world.run(0.6, STEP)
    assert box.is_asleep
    assert box.position[0] == pytest.approx(0.3, abs=2e-3)


@pytest.fixture
def balls():
    """A world without weight, of three soft balls in a row, a joint, and one far away; all asleep."""
    world = World(gravity=(0.0, 0.0, 0.0), sleep_speed=0.02, sleep_after=0.05)
    for x in (0.0, 0.602, 3.0, 20.0):
        world.add_soft_body(softbody.icosphere(1, 0.3), 1.0, 300.0, 0.0, (x, 0.0, 0.0), damping=0.0)
    one, other = world.soft_bodies[1:3]
    place = (other, tuple(other.positions[0]))
    world.add_joint((one, tuple(one.positions[0])), place, 0.0, 0.0)
    world.run(0.2, 2e-3)
    assert all(ball.is_asleep for ball in world.soft_bodies)
    return world


def test_what_is_near_or_joined_wakes_together(balls):
    balls.soft_bodies[0].velocities[:, 1] += 0.1
    balls.step(2e-3)
    assert [ball.is_asleep for ball in balls.soft_bodies] == [False, False, False, True]


SOFT = {
    "velocities": lambda world, ball: ball.velocities.__setitem__((3, 1), 0.5),
    "positions": lambda world, ball: ball.positions.__setitem__((3, 1), 0.01),
    "gas": lambda world, ball: setattr(ball, "gas", 1.0),
    "force": lambda world, ball: setattr(ball, "external_force", (0.0, 0.5, 0.0)),
}


@pytest.mark.parametrize("change", SOFT)
def test_what_changes_of_a_soft_body_wakes_that_one(balls, change):
    SOFT[change](balls, balls.soft_bodies[3])
    balls.step(2e-3)
    assert [ball.is_asleep for ball in balls.soft_bodies] == [True, True, True, False]


def test_a_joint_that_changes_wakes_its_bodies(balls):
    balls.joints[0].stiffness = 10.0
    balls.step(2e-3)
    assert [ball.is_asleep for ball in balls.soft_bodies] == [False, False, False, True]


def test_what_is_changed_before_a_snapshot_is_known_after_it(floor):
    floor.boxes[0].apply_force((50.0, 0.0, 0.0))
    twin = World()
    twin.restore(floor.snapshot())
    for world in (floor, twin):
        world.run(0.5, STEP)
    assert twin.state_hash() == floor.state_hash()
    assert twin.boxes[0].velocity[0] > 1.0


def test_a_world_that_was_just_restored_has_no_contacts_yet(floor):
    twin = World()
    twin.restore(floor.snapshot())
    assert all(box.is_asleep for box in twin.boxes)
    assert len(twin.contact_points()) == 0
    twin.step(STEP)
    assert twin.contact_points().pairs() == {(0, -1), (1, -1)}


def test_where_nobody_may_sleep_a_file_puts_nobody_to_sleep():
    world = World()
    world.add_box((1.0, 1.0, 1.0), 1.0, (5.0, 0.0, 0.0))
    world.add_soft_body(softbody.octahedron(0.3), 1.0, 300.0, 0.0)
    world.restore(world.snapshot() | {"rest.asleep": np.ones(2, np.int64), "rest.time": np.full(2, 9.0)})
    world.step(1e-3, 3)
    assert world.soft_bodies[0].velocities[0, 2] == pytest.approx(-9.81 * 3e-3)
    assert world.boxes[0].velocity[2] == pytest.approx(-9.81 * 3e-3)
    assert len(world.contact_points()) == 0


def test_older_snapshots_have_nobody_asleep(floor):
    snapshot = {name: rows for name, rows in floor.snapshot().items() if not name.startswith("rest.")}
    for name in ("settings.sleep_speed", "settings.sleep_after"):
        del snapshot[name]
    snapshot["format"] = np.array(5)
    world = World()
    world.restore(snapshot)
    assert world.store.settings.sleep_speed == 0.0
    assert not world.boxes[0].is_asleep
