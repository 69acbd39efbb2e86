"""What is drawn shows how bodies turn, by stripes and ribbons that belong to the material, or a quantity."""

from __future__ import annotations

import numpy as np
import pytest

import softbody
from softbody import ParameterError, World
from softbody.model.colours import STATIC
from softbody.render.drawing import STRIPES, Drawing, placed, stripes_of


@pytest.mark.parametrize("mesh", [softbody.icosphere(3), softbody.torus()])
def test_stripes_run_around_the_axis_across_which_a_body_is_thinnest(mesh):
    body = softbody.World().add_soft_body(mesh, 1.0, 100.0, 1.0, (3.0, 2.0, 1.0))
    stripes = stripes_of(body)
    ahead = mesh.vertices[:, 0] > 0.9 * mesh.vertices[:, 0].max()
    assert (stripes[ahead & (np.abs(mesh.vertices[:, 1]) < 0.1)] > 0.0).all()
    turn = np.pi / STRIPES  # from the middle of a stripe to that of the next of the other colour
    angle = np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0])
    away = np.hypot(*mesh.vertices[:, :2].T) > 0.1
    assert (stripes[(np.abs(angle - turn) < 0.3 * turn) & away] < 0.0).all()


@pytest.mark.parametrize("name", softbody.scenes.__all__)
def test_every_scene_is_drawn_with_what_can_move_striped(name):
    world = getattr(softbody.scenes, name).build()
    things = Drawing(world).things()
    assert len(things) == world.model.soft_count + world.model.box_count
    static = int((world.model.box_inverse_mass == 0.0).sum())
    assert sum(np.shape(thing.colours) == (3,) for thing in things) == static
    for thing in things:
        assert thing.along is None or (thing.along.min() < 0.5 < thing.along.max())


def test_stripes_stay_where_they_were_when_a_body_turns():
    world = softbody.scenes.ball_drop.build()
    drawing = Drawing(world)
    first = drawing.things()[0].along
    body = softbody.SoftBody(world, 0)
    body.positions[:] = body.positions[:, [1, 2, 0]]
    np.testing.assert_array_equal(drawing.things()[0].along, first)
    assert (Drawing(world).things()[0].along != first).any()


def test_a_quantity_goes_from_the_least_to_the_greatest_colour_and_no_further():
    world = softbody.scenes.ball_drop.build()
    for i in range(3):
        softbody.SoftBody(world, i).velocities[:, 0] = float(i)
    own = [thing.along for thing in Drawing(world, "speed").things()]
    np.testing.assert_allclose([each.mean() for each in own], [0.0, 0.5, 1.0])
    said = [thing.along for thing in Drawing(world, "speed", (0.0, 1.0)).things()]
    np.testing.assert_allclose([each.mean() for each in said], [0.0, 1.0, 1.0])


def test_a_quantity_that_is_everywhere_the_same_has_one_colour():
    things = Drawing(softbody.scenes.ball_drop.build(), "speed").things()
    assert all((thing.along == 0.0).all() for thing in things)


def test_boxes_have_no_quantity_and_are_grey():
    things = Drawing(softbody.scenes.boxes_on_torus.build(), "strain").things()
    assert [tuple(thing.colours) == STATIC for thing in things[1:]] == [True] * 3


def test_plain_has_one_colour_a_body():
    world = softbody.scenes.boxes_on_torus.build()
    assert all(thing.along is None for thing in Drawing(world, "plain").things())


def test_a_box_is_drawn_where_it_is():
    """A quarter turn about z takes x to y."""
    world = softbody.World()
    half = np.sqrt(0.5)
    box = world.add_box((1.0, 1.0, 1.0), 1.0, (1.0, 2.0, 3.0), (half, 0.0, 0.0, half))
    np.testing.assert_allclose(placed(np.array([[0.5, 0.0, 0.25]]), box), [[1.0, 2.5, 3.25]])


def test_what_is_nowhere_is_named():
    world = softbody.scenes.boxes_on_torus.build()
    world.state.box_position[1, 0] = np.nan
    with pytest.raises(ParameterError, match="box 1 has a position that is not finite"):
        world.picture()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"colour": "temperature"}, "colour is 'temperature'; choose one of stripes, plain, pressure, strain, speed"),
        ({"colour_map": "jet"}, "colour_map is 'jet'"),
        ({"colour": "speed", "colour_range": 3.0}, "colour_range is 3.0; give the least and the greatest"),
        ({"colour": "speed", "colour_range": (3.0, 3.0)}, "greatest of colour_range is 3.0"),
        ({"colour": "speed", "colour_range": (np.nan, 3.0)}, "least of colour_range is nan"),
        ({"size": 100}, "size is 100; give width and height"),
        ({"size": (0, 100)}, "width of size is 0"),
        ({"camera": "front"}, "camera is 'front'"),
    ],
)
def test_what_cannot_be_drawn_is_refused(given, message):
    with pytest.raises(ParameterError, match=message):
        softbody.scenes.ball_drop.build().picture(**given)


def test_bodies_with_boxes_inside_are_clear():
    world = World()
    bag = world.add_soft_body(softbody.icosphere(1), 1.0, 1.0, 1.0)
    world.add_soft_body(softbody.icosphere(1), 1.0, 1.0, 1.0, (3.0, 0.0, 0.0))
    world.add_box((0.1, 0.1, 0.1), 1.0, inside=bag)
    for colour in ("stripes", "plain", "speed"):
        assert [thing.is_clear for thing in Drawing(world, colour).things()] == [True, False, False]
