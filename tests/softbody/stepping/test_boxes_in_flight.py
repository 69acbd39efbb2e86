"""Are boxes that fly at each other struck if they meet, left alone if they pass, and held for as long as they touch?"""

import numpy as np
import pytest

from softbody import World


def flight(size, position, orientation, velocity, spin, mass=1.0):
    """Return what `add_box` takes; the orientation is made a unit quaternion."""
    unit = np.divide(orientation, np.linalg.norm(orientation))
    return {
        "size": size, "mass": mass, "position": position, "orientation": unit, "velocity": velocity,
        "angular_velocity": spin,
    }  # fmt: skip


STRUCK = (  # 3.3 m in a step, and a turn of 0.05 rad: the axis that parts them most before is not the one they meet on
    1.0 / 30.0,
    flight(
        (0.23701, 1.0871, 0.38378), (10.39888, 1.69079, -0.0937), (0.01496, -0.6013, -0.52227, -0.60452),
        (-123.06471, -11.84429, 22.04035), (1.16795, 1.06626, -0.44111), 1.236,
    ),
    flight(
        (0.26649, 0.9494, 0.41864), (0.0, 0.0, 0.0), (-0.03195, -0.44968, -0.88601, -0.10843),
        (-24.48048, 4.21222, 17.20949), (0.0, 0.0, 0.0), 0.4496,
    ),
)  # fmt: skip
MISSED = (  # by 14 mm; corners that went straight, and did not turn, would have met
    1.0 / 240.0,
    flight(
        (0.22071, 0.18128, 0.21424), (0.0, -1.92169, -0.27791), (0.99441, 0.00593, -0.10188, -0.02693),
        (-2.75227, 76.28266, -48.8954), (-1.44214, 24.75739, 6.54485), 0.2373,
    ),
    flight(
        (0.81719, 1.83718, 0.17053), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), (-2.75227, -23.71734, -48.8954),
        (0.0, 0.0, 0.0), 3.904,
    ),
)  # fmt: skip


@pytest.mark.parametrize(("case", "meet"), [(STRUCK, True), (MISSED, False)])
def test_boxes_that_turn_and_fall_are_struck_if_they_meet(case, meet):
    step, *boxes = case
    world = World()
    for box in boxes:
        world.add_box(**box)
    before = world.boxes[0].velocity - world.boxes[1].velocity
    world.step(step, 10)
    change = np.abs(world.boxes[0].velocity - world.boxes[1].velocity - before).max()
    assert change > 1.0 if meet else change < 1e-12


def test_a_heavy_box_that_slides_on_another_never_loses_touch():
    """It slides by 3 mm a step, and leans by 1e-7 rad: alone, the two would fall past each other."""
    world = World()
    world.add_ground(friction=0.70169014)
    yaw = [np.array([np.cos(0.5 * a), 0.0, 0.0, np.sin(0.5 * a)]) for a in (3.4618290071295195, 1.1623912665462843)]
    world.add_box((2.0, 1.6, 0.2), 3.8799498461493607, (0.0, 0.0, 0.1), yaw[0], friction=0.8481618)
    world.add_box((0.7, 0.9, 0.2), 20.593477249393406, (0.0, 0.0, 0.3), yaw[1], friction=0.41935381)
    world.boxes[0].apply_force(np.array([0.02039393, 0.99979202, 0.0]) * 392.6)
    for _ in range(205):
        world.step(1e-3)
        between = (world.contact_points().b == 0) & (world.contact_points().a == 1)
        assert between.sum() >= 4
