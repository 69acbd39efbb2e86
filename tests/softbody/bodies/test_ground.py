"""Is the ground what was last said of it, and is nonsense refused?"""

import numpy as np
import pytest

import softbody
from softbody import Ground, ParameterError, World

pytestmark = pytest.mark.interpreted


def test_the_ground_says_what_it_is_and_may_be_set_number_by_number():
    world = World()
    ground = world.add_ground(-1.0, restitution=0.25)
    assert isinstance(ground, Ground)
    assert ground.world is world
    assert repr(ground) == "<ground at -1 m: restitution 0.25, friction 0.5>"
    world.ground.friction = 0.75
    world.ground.height = -2
    ground.restitution = 1
    assert (ground.height, ground.restitution, ground.friction) == (-2.0, 1.0, 0.75)
    assert (world.model.ground_height, world.model.ground_friction) == (-2.0, 0.75)


def test_a_world_without_ground_says_so():
    world = World()
    assert not world.ground.is_there
    assert repr(world.ground) == "<no ground>"
    with pytest.raises(ParameterError, match="this world has no ground; call add_ground first"):
        world.ground.height = 1.0
    with pytest.raises(ParameterError, match="no ground"):
        print(world.ground.friction)
    world.add_ground()
    assert world.ground.is_there


@pytest.mark.parametrize(
    ("name", "value"),
    [("height", np.inf), ("height", -np.inf), ("restitution", 1.5), ("restitution", -0.1), ("friction", -1.0)]
    + [(name, value) for name in ("height", "restitution", "friction") for value in (np.nan, "x", None)],
)
def test_nonsense_is_refused_where_it_is_set_and_where_it_is_added(name, value):
    world = World()
    with pytest.raises(ParameterError, match=f"{name} is"):
        world.add_ground(**{name: value})
    assert not world.ground.is_there
    ground = world.add_ground(0.5)
    with pytest.raises(ParameterError, match=f"{name} is"):
        setattr(ground, name, value)
    assert repr(ground) == "<ground at 0.5 m: restitution 0, friction 0.5>"


def test_a_name_that_was_mistyped_is_an_error():
    with pytest.raises(AttributeError, match="did you mean 'friction'"):
        World().add_ground().frictoin = 1.0


def test_a_ground_that_is_lowered_lets_fall_what_lay_on_it():
    world = World()
    world.add_ground()
    ball = world.add_soft_body(softbody.octahedron(0.5), 1.0, 200.0, 10.0, (0.0, 0.0, 0.5), damping=0.5)
    world.run(0.2, 2e-3)
    assert ball.positions[:, 2].min() >= 0.0
    world.ground.height = -1.0
    world.run(0.3, 2e-3)
    assert -1.0 <= ball.positions[:, 2].min() < -0.3
