"""Boxes inside soft bodies: what is refused, what is told, what masses become."""

import copy
import pickle

import numpy as np
import pytest

import softbody
from softbody import OverloadWarning, ParameterError, World


@pytest.fixture
def world():
    """Return a world of a bag, a ball of gas, and a box in the bag."""
    world = World()
    bag = world.add_soft_body(softbody.icosphere(2, 0.5), 2.0, 5e3, 1e3, name="bag", liquid_density=1000.0)
    world.add_soft_body(softbody.icosphere(2, 0.5), 2.0, 5e3, 1e3, (2.0, 0.0, 0.0), name="ball")
    world.add_box((0.1, 0.2, 0.1), 1.0, inside=bag, name="box")
    return world


def test_a_box_takes_the_place_of_liquid(world):
    bag, box, whole = world["bag"], world["box"], softbody.icosphere(2, 0.5).volume
    assert box.inside == bag
    assert bag.mass == pytest.approx(2.0 + 1000.0 * (whole - 0.002), rel=1e-14)
    assert bag.liquid_density == 1000.0
    assert bag.volume == pytest.approx(whole, rel=1e-14)
    assert bag.pressure == pytest.approx(1e3 / (whole - 0.002), rel=1e-12)
    np.testing.assert_allclose(box.buoyancy(), (0.0, 0.0, 9.81 * 2.0), rtol=1e-12)
    assert box.submerged_volume == pytest.approx(0.002, rel=1e-14)
    bag.liquid_density = 0.0
    assert bag.mass == pytest.approx(2.0, rel=1e-12)
    assert (box.submerged_volume, box.buoyancy().tolist()) == (0.0, [0.0, 0.0, 0.0])
    bag.liquid_density = 500.0
    box.inside = None
    assert bag.mass == pytest.approx(2.0 + 500.0 * whole, rel=1e-12)


def test_a_box_goes_from_one_body_to_another(world):
    bag, ball, box = world["bag"], world["ball"], world["box"]
    box.position = ball.centre
    box.inside = ball
    assert (box.inside, world.model.soft_boxes_volume[0]) == (ball, 0.0)
    world.remove(bag)
    assert (box.inside, ball.index, world.model.box_host.tolist()) == (ball, 0, [0])
    world.remove(ball)
    assert (box.inside, world.model.soft_boxes_volume.tolist()) == (None, [])


def test_what_does_not_fit_is_refused_with_a_cure(world):
    bag = world["bag"]
    for place, size, why in (
        (
            (0.46, 0.0, 0.0),
            0.1,
            r"corner \d of box 1, at .* is not inside .*'bag'.*: move it in, or take a larger body",
        ),
        ((5.0, 0.0, 0.0), 0.1, "is not inside"),
    ):
        with pytest.raises(ParameterError, match=why):
            world.add_box((size, size, size), 1.0, place, inside=bag)
    for wrong in ("bag", 0, world["box"], World().add_soft_body(softbody.octahedron(1.0), 1.0, 1.0, 1.0)):
        with pytest.raises(ParameterError, match=r"inside is .*, which is no soft body of this world; give a handle"):
            world.add_box((0.1, 0.1, 0.1), 1.0, inside=wrong)
        with pytest.raises(ParameterError, match=r"no soft body of this world"):
            world["box"].inside = wrong
    assert (len(world.boxes), world["box"].inside) == (1, bag)
    ring = world.add_soft_body(softbody.torus(0.5, 0.2, 24, 12), 1.0, 1.0, 1.0, (0.0, 4.0, 0.0))
    with pytest.raises(ParameterError, match=r"triangle .* passes through box 1: move the box, or take a smaller one"):
        world.add_box((1.2, 0.02, 0.02), 1.0, (0.0, 4.0, 0.0), inside=ring)


def test_a_box_that_leaves_no_room_is_refused():
    world = World()
    body = world.add_soft_body(softbody.box((1.0, 1.0, 1.0), 2), 1.0, 1.0, 1.0)
    body.positions = 2.0 * body.positions
    with pytest.raises(ParameterError, match=r"boxes inside soft body 0 have 3.38 m³, and its mesh has no more"):
        world.add_box((1.5, 1.5, 1.5), 1.0, inside=body)


def test_what_hangs_is_inside_and_stays_where_it_is_let_go(world):
    bag, box = world["bag"], world["box"]
    hung = world.suspend(box, bag)
    for wrong in (None, bag, world["ball"]):
        with pytest.raises(ParameterError, match=r"box 0 'box'.* hangs in .*'bag'.*; remove that suspension first"):
            box.inside = wrong
    world.remove(hung)
    assert box.inside == bag
    with pytest.raises(ParameterError, match=r"box 0 'box'.* is inside .*'bag'.*; let its inside be None first"):
        world.suspend(box, world["ball"])


@pytest.mark.compiled
def test_a_box_that_is_outside_is_told_once(world):
    box = world["box"]
    world.step(1e-4)
    box.position = (0.0, 0.0, 3.0)
    with pytest.warns(OverloadWarning, match=r"box 0 'box', at .* is outside of soft body 0 'bag', which it is to be"):
        world.step(1e-4)
    world.step(1e-4)


@pytest.mark.compiled
def test_who_is_inside_is_saved_and_copied_and_goes_on_to_the_same_bits(world, tmp_path):
    world["bag"].liquid_drag = 100.0
    world.run(0.05, 5e-4)
    world.save(tmp_path / "world.npz")
    others = [World.load(tmp_path / "world.npz"), copy.deepcopy(world), pickle.loads(pickle.dumps(world))]
    world.run(0.05, 5e-4)
    for each in others:
        assert each["box"].inside == each["bag"]
        each.run(0.05, 5e-4)
        assert each.state_hash() == world.state_hash()


@pytest.mark.parametrize(
    ("entry", "value", "why"),
    [
        ("model.box_host", np.array([2]), r"model.box_host is \[2\]; it must be soft bodies, from 0 on, or −1"),
        ("model.box_host", np.array([1]), "model.soft_boxes_volume is .*; by model.box_host it is"),
        ("model.soft_boxes_volume", np.zeros(2), "model.soft_boxes_volume is .*; by model.box_host it is"),
    ],
)
def test_a_snapshot_that_contradicts_itself_is_refused(world, entry, value, why):
    with pytest.raises(softbody.SnapshotError, match=why):
        World().restore(world.snapshot() | {entry: value})
