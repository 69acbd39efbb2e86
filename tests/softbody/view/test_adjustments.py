"""What a slider says is what the world does from its next step on."""

from __future__ import annotations

import numpy as np
import pytest

import softbody
from softbody import ParameterError, World
from softbody.view.adjustments import SLIDERS, Adjustments, shown_at_start
from softbody.view.session import Session

pytestmark = pytest.mark.interpreted


@pytest.fixture
def both():
    """Two worlds that are alike: a body, a box and a ground."""
    worlds = []
    for _ in range(2):
        world = softbody.World((0.0, -3.0, -4.0))
        world.add_ground(friction=0.1)
        world.add_soft_body(softbody.octahedron(), 1.0, 10.0, 2.0, friction=0.2, restitution=0.4)
        world.add_box((1.0, 1.0, 1.0), 1.0, friction=0.4)
        worlds.append(world)
    return worlds


def test_springs_and_gas_are_so_many_times_what_they_were_however_often_they_are_changed(both):
    adjustments = Adjustments(*both)
    for exponent in (1.0, -1.0, 3.0):
        adjustments.set_slider("stiffness", exponent)
        adjustments.set_slider("gas", exponent)
    np.testing.assert_allclose(both[0].model.edge_stiffness, 80.0)
    assert softbody.SoftBody(both[0], 0).gas == 16.0


def test_gravity_keeps_its_direction_and_comes_back_from_none(both):
    adjustments = Adjustments(*both)
    adjustments.set_slider("gravity", 0.0)
    np.testing.assert_array_equal(both[0].controls.gravity, 0.0)
    adjustments.set_slider("gravity", 10.0)
    np.testing.assert_allclose(both[0].controls.gravity, (0.0, -6.0, -8.0))


def test_gravity_is_downward_where_there_was_none():
    worlds = softbody.World((0.0, 0.0, 0.0)), softbody.World((0.0, 0.0, 0.0))
    Adjustments(*worlds).set_slider("gravity", 2.0)
    np.testing.assert_allclose(worlds[0].controls.gravity, (0.0, 0.0, -2.0))


@pytest.mark.parametrize("name", ["friction", "restitution"])
def test_friction_and_restitution_are_the_same_for_everything(both, name):
    Adjustments(*both).set_slider(name, 0.75)
    model = both[0].model
    for kind in ("soft", "box", "ground"):
        np.testing.assert_array_equal(getattr(model, f"{kind}_{name}"), 0.75)


def test_steps_in_parts_are_as_many_as_the_slider_says_and_so_much_longer(both):
    before = both[0].stable_time_step()
    Adjustments(*both).set_slider("substeps", 4.0)
    assert both[0].substeps == 4
    assert both[0].stable_time_step() == pytest.approx(4.0 * before)


def test_a_slider_shows_what_is(both):
    both[0].substeps = 3
    shown = shown_at_start(both[0])
    as_set = {"stiffness": 0.0, "gas": 0.0, "gravity": 5.0, "friction": 0.3, "restitution": 0.2, "substeps": 3.0}
    assert shown == pytest.approx(as_set | {"self_contact": 0.0, "density": 0.0})
    assert shown.keys() == SLIDERS.keys()
    assert shown_at_start(softbody.World())["friction"] == 0.0


def test_what_was_changed_is_there_again_after_a_restart(both):
    world, start = both[0], both[0].snapshot()
    adjustments = Adjustments(*both)
    adjustments.set_slider("gas", 1.0)
    adjustments.set_slider("friction", 1.0)
    adjustments.set_integrator("symplectic_euler")
    world.restore(start)
    adjustments.repeat()
    assert world.integrator == "symplectic_euler"
    assert softbody.SoftBody(world, 0).gas == 4.0
    assert world.model.ground_friction == 1.0
    assert world.model.edge_stiffness[0] == 10.0


def test_a_value_beyond_its_slider_is_at_its_end(both):
    Adjustments(*both).set_slider("restitution", 7.0)
    assert both[0].model.ground_restitution == 1.0


def test_there_is_no_other_slider_and_no_other_integrator(both):
    with pytest.raises(ParameterError, match="slider is 'colour'; choose one of stiffness"):
        Adjustments(*both).set_slider("colour", 1.0)
    with pytest.raises(ParameterError, match="integrator is 'euler'"):
        Adjustments(*both).set_integrator("euler")


def test_bodies_hold_themselves_or_not_at_the_distance_they_began_with(both):
    adjustments = Adjustments(*both)
    body = both[0].soft_bodies[0]
    adjustments.set_slider("self_contact", 1.0)
    most = body.self_contact
    assert most > 0.0
    both[1].soft_bodies[0].self_contact = 0.5 * most
    adjustments.set_slider("self_contact", 1.0)
    assert body.self_contact == 0.5 * most
    adjustments.set_slider("self_contact", 0.0)
    assert body.self_contact == 0.0


def test_in_the_papers_world_bodies_go_on_to_go_through_themselves():
    worlds = [softbody.World(soft_contact="single") for _ in range(2)]
    for world in worlds:
        world.add_soft_body(softbody.octahedron(), 1.0, 10.0, 2.0)
    Adjustments(*worlds).set_slider("self_contact", 1.0)
    assert worlds[0].soft_bodies[0].self_contact == 0.0


def test_gravity_that_a_liquid_cannot_have_is_refused_and_not_repeated():
    world = World()
    world.add_liquid()
    world.add_box((1.0, 1.0, 1.0), 500.0)
    session = Session(world)
    with pytest.raises(ParameterError, match="let gravity point down"):
        session.set_slider("gravity", 0.0)
    session.restart()
    session.step_once()
    assert world.gravity.tolist() == [0.0, 0.0, -9.81]
