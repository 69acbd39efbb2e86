"""Do the scenes run, come out as they should, and take a world with rules of its own?"""

from __future__ import annotations

import numpy as np
import pytest

from softbody import ParameterError, SoftBody, World, scenes

STEP = 0.8  # of the stable time step
BOX_STEP = 1.0 / 240.0  # [s] where there is no soft body


def run(world: World, seconds: float) -> World:
    world.run(seconds, min(BOX_STEP, STEP * world.stable_time_step()))
    return world


def deepest_corner(world: World) -> float:
    """Return how far the lowest corner of any box is below the ground [m]."""
    from softbody.geometry.box import box_corner

    rows = zip(world.model.box_size, world.state.box_position, world.state.box_orientation)
    corners = [box_corner(tuple(s), tuple(x), tuple(q), k) for s, x, q in rows for k in range(8)]
    return -min(corner[2] for corner in corners)


@pytest.mark.parametrize("name", scenes.__all__)
def test_every_scene_fills_the_world_that_it_is_given(name):
    world = World.paper()
    assert getattr(scenes, name).build(world=world) is world
    assert len(world.controls.soft_gas) + len(world.model.box_size) > 0
    frictions = world.model.soft_friction, world.model.box_friction, [world.model.ground_friction]
    assert not np.concatenate(frictions).any()


def test_a_stack_of_boxes_stands():
    world = run(scenes.box_stack.build(6), 3.0)
    heights = world.state.box_position[:, 2]
    assert heights == pytest.approx(0.15 + 0.3 * np.arange(6), abs=2e-3)
    assert np.abs(world.state.box_velocity).max() < 1e-3


def test_a_heap_of_boxes_comes_to_rest_on_the_ground():
    world = run(scenes.box_pile.build(27), 6.0)
    assert deepest_corner(world) < 5e-3
    assert np.linalg.norm(world.state.box_velocity, axis=1).max() < 0.05
    assert world.state.box_position[:, 2].max() > 0.6  # some lie on others


def test_a_stiffer_ball_is_squeezed_less_by_its_fall():
    world = scenes.ball_drop.build((100.0, 1600.0), height=0.5, subdivisions=2)
    least = np.full(2, np.inf)
    for _ in range(50):
        run(world, 0.02)
        least = np.minimum(least, [np.ptp(SoftBody(world, i).positions[:, 2]) for i in range(2)])
    assert 0.2 < least[0] < 0.9 * least[1] < 1.0


@pytest.mark.parametrize(("bodies", "seconds"), [(1, 3.0), (10, 3.0)])
def test_balls_stay_in_their_tray(bodies, seconds):
    world = run(scenes.tray.build(bodies), seconds)
    inside = world.state.box_position[world.state.box_position[:, 0].argmax(), 0] - 0.5 * scenes.tray.WALL
    assert np.abs(world.state.particle_position[:, :2]).max() < inside + 1e-3
    assert world.state.particle_position[:, 2].min() >= 0.0


@pytest.mark.parametrize(
    ("name", "arguments", "culprit"),
    [
        ("tray", {"bodies": 2.5}, "bodies is 2.5"),
        ("tray", {"bodies": 0}, "bodies is 0"),
        ("box_pile", {"boxes": "many"}, "boxes is 'many'"),
        ("box_stack", {"boxes": -1}, "boxes is -1"),
        ("box_stack", {"gap": np.nan}, "gap is nan"),
        ("torus_stack", {"bodies": 0}, "bodies is 0"),
        ("boxes_on_torus", {"boxes": -1}, "boxes is -1"),
        ("ball_drop", {"height": -1.0}, "height is -1.0"),
        ("rolling_torus", {"tilt": np.inf}, "tilt is inf"),
    ],
)
def test_a_scene_names_the_argument_that_it_cannot_use_and_leaves_the_world_alone(name, arguments, culprit):
    world = World()
    with pytest.raises(ParameterError, match=culprit):
        getattr(scenes, name).build(**arguments, world=world)
    assert world.model.ground_height == -np.inf
