"""Does a liquid refuse what it cannot be, and say what it is?"""

import pickle

import numpy as np
import pytest

import softbody
from softbody import Camera, ParameterError, World


def a_pool(**said):
    """Return a world with a liquid and a box that is half under it."""
    world = World()
    world.add_liquid(**said)
    world.add_box((1.0, 1.0, 1.0), 500.0)
    return world


def test_where_there_is_none_it_says_so_and_nothing_is_submerged():
    world = World()
    box, ball = world.add_box((1.0, 1.0, 1.0), 1.0), world.add_soft_body(softbody.icosphere(1), 1.0, 100.0, 1.0)
    assert not world.liquid.is_there
    assert repr(world.liquid) == "<no liquid>"
    for body in (box, ball):
        assert body.submerged_volume == 0.0
        assert not body.buoyancy().any()
    with pytest.raises(ParameterError, match="no liquid; call add_liquid first"):
        world.liquid.density = 2.0
    with pytest.raises(ParameterError, match="no liquid"):
        world.liquid.velocity = (0.0, 0.0, 0.0)


def test_it_is_told_and_goes_along_in_pickles():
    world = a_pool(density=900.0, surface_height=0.25, drag=3.0, velocity=(1.0, 0.0, 0.0))
    assert "liquid up to 0.25 m" in repr(world)
    again = pickle.loads(pickle.dumps(world))
    assert repr(again.liquid) == "<liquid of 900 kg/m³ up to 0.25 m: drag 3 N s/m³>" == repr(world.liquid)
    assert again.boxes[0].submerged_volume == pytest.approx(0.75)
    with pytest.raises(ValueError, match="read-only"):
        again.liquid.velocity[0] = 2.0


@pytest.mark.parametrize("gravity", [(0.1, 0.0, -9.81), (0.0, 0.0, 0.0), (0.0, 0.0, 9.81)])
def test_it_is_level(gravity):
    with pytest.raises(ParameterError, match="a liquid, whose surface is level"):
        World(gravity).add_liquid()
    world = a_pool()
    before = world.state_hash()
    with pytest.raises(ParameterError, match="let gravity point down"):
        world.gravity = gravity
    world.gravity[:] = gravity
    for ask in (lambda: world.step(1e-3), world.stable_time_step, lambda: world.run(0.1)):
        with pytest.raises(ParameterError, match="let gravity point down"):
            ask()
    assert world.state_hash() == before


def test_a_step_that_is_too_long_for_it_is_refused_and_names_it():
    world = a_pool(drag=1e5)
    with pytest.raises(ParameterError, match=r"liquids allow .* heavier, or their drag less"):
        world.step(0.01)
    world.liquid.drag = 10.0
    world.step(0.01)
    world.liquid.density = 1e300
    world.liquid.drag = 1e300
    with pytest.raises(ParameterError, match="a liquid is too dense"):
        world.stable_time_step()


def test_what_is_fixed_static_or_kinematic_is_not_moved_by_it():
    world = World()
    world.add_liquid(velocity=(1.0, 1.0, 0.0), drag=50.0)
    still, lift = world.add_box((1.0, 1.0, 1.0), None), world.add_box((1.0, 1.0, 1.0), None, (9.0, 0.0, 0.0))
    lift.velocity = (0.0, 0.0, 0.5)
    ball = world.add_soft_body(softbody.icosphere(1, 0.5), 100.0, 1e4, 1e4, (5.0, 0.0, 0.0), fixed=(0, 3))
    pinned = ball.positions[[0, 3]].copy()
    world.run(0.5)
    assert not still.velocity.any()
    assert (ball.positions[[0, 3]] == pinned).all()
    assert lift.position == pytest.approx([9.0, 0.0, 0.25])


def test_its_surface_is_seen_in_pictures():
    camera = Camera((3.0, -3.0, 2.0), (0.0, 0.0, 0.0))
    under, above = (a_pool(surface_height=z).picture(camera=camera, size=(64, 48)).astype(int) for z in (0.0, -9.0))
    assert np.median((under[:, :, 2] - under[:, :, 0])[-10:] - (above[:, :, 2] - above[:, :, 0])[-10:]) > 10
