"""A world with one of everything."""

import pytest

import softbody
from softbody import World


@pytest.fixture
def filled():
    """A world with one of everything, which a test must leave as it is."""
    world = World()
    world.add_ground()
    world.add_soft_body(softbody.octahedron(), 1.0, 10.0, 1.0)
    world.add_box((1.0, 2.0, 3.0), 1.0)
    model, controls, state = world.model, world.controls, world.state
    before = world.snapshot()
    yield world
    assert world.model is model
    assert world.controls is controls
    assert world.state is state
    assert (world.steps, world.time) == (0, 0.0)
    after = world.snapshot()
    assert after.keys() == before.keys()
    assert all((after[name] == before[name]).all() for name in before)
