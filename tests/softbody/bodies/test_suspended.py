"""Tests of what hangs in a soft body: what is refused, what is said, and what goes with whom."""

import copy
import pickle

import numpy as np
import pytest

import softbody
from softbody import ParameterError, World


@pytest.fixture
def world():
    made = World()
    made.add_soft_body(softbody.icosphere(1, 0.5), 1.0, 300.0, 30.0, (0.0, 0.0, 1.0), name="ball")
    made.add_box((0.2, 0.2, 0.2), 1.0, (0.0, 0.0, 1.0), name="marble")
    return made


@pytest.mark.parametrize(
    ("what", "told", "message"),
    [
        ([(0.0, 0.0, 1.0), (0.0, 0.0, 2.0)], {}, r"point 1 of what, at \[0. 0. 2.\] m, is not inside <soft body 0"),
        ([(0.0, 0.0)], {}, r"what has shape \(1, 2\); give a box of this world, or points"),
        (np.zeros((0, 3)), {}, r"what has shape \(0, 3\)"),
        ([(0.0, 0.0, np.nan)], {}, "point 0 of what is .*; give finite numbers"),
        ("marble", {}, "what is 'marble'; give a box of this world, or points"),
        ([(0.0, 0.0, 1.0)], {"weights": "mean"}, "weights is 'mean'; choose from mean-value, tetrahedron"),
        ([(0.0, 0.0, 1.0)], {"stiffness": 1.0}, "stiffness and damping are for a box"),
        ([(0.0, 0.0, 1.0)], {"name": "ball"}, "name is 'ball', which soft body 0 has"),
    ],
)
def test_what_cannot_hang_is_refused_with_its_cure(world, what, told, message):
    with pytest.raises(ParameterError, match=message):
        world.suspend(what, world["ball"], **told)
    assert world.suspended == ()


def test_a_box_that_does_not_fit_is_refused(world):
    ball, box = world["ball"], world["marble"]
    box.position = (0.0, 0.0, 1.4)
    with pytest.raises(ParameterError, match=r"corner \d of <box 0 'marble'.*, at .* is not inside .*: move it in"):
        world.suspend(box, ball)
    ring = world.add_soft_body(softbody.torus(0.5, 0.1, 24, 12), 1.0, 300.0, 1.0, (5.0, 0.0, 0.0))
    beam = world.add_box((1.0, 0.05, 0.05), 1.0, (5.0, 0.0, 0.0))  # from side to side, through the hole
    with pytest.raises(ParameterError, match=r"triangle \d+ of <soft body 1.* passes through <box 1"):
        world.suspend(beam, ring)
    for one, other, message in (
        (World().add_box((0.1, 0.1, 0.1), 1.0), ball, "a box of another world"),
        (box, World().add_soft_body(softbody.octahedron(1.0), 1.0, 1.0, 0.0), "no soft body of this world"),
        (box, beam, "no soft body of this world"),
    ):
        with pytest.raises(ParameterError, match=message):
            world.suspend(one, other)
    box.position = ball.centre
    world.suspend(box, ball)
    with pytest.raises(ParameterError, match=r"hangs in <soft body 0 'ball'.* already; remove that suspension first"):
        world.suspend(box, ball)


def test_nothing_that_can_move_needs_a_stiffness():
    world = World()
    body = world.add_soft_body(softbody.octahedron(1.0), 1.0, 1.0, 1.0, fixed=(1, 2, 3, 4, 5))
    box = world.add_box((0.1, 0.1, 0.1), None, (-0.4, 0.0, 0.0))
    world.suspend(box, body)  # one particle can
    assert len(world.joints) == 8


def test_what_hangs_goes_with_its_body_and_what_stays_is_found(world):
    ball, box = world["ball"], world["marble"]
    hung, points = world.suspend(box, ball, name="hung"), world.suspend(ball.centre, ball)
    assert (len(hung), hung.box, hung.body, points.box) == (8, box, ball, None)
    assert repr(hung) == "<suspension 0 'hung': 8 points in soft body 0>"
    tie = world.add_joint((points, 0), (0.0, 0.0, 3.0), 1.0)
    with pytest.raises(ParameterError, match="point of a is 8"):
        world.add_joint((hung, 8), (0.0, 0.0, 3.0), 1.0)
    world.remove(box)
    assert [hung.is_there, points.is_there, tie.is_there] == [False, True, True]
    assert repr(hung) == "<suspension that is gone>"
    assert len(world.joints) == 1
    world.remove(ball)
    assert world.joints == world.suspended == ()
    world.step(1e-3)


@pytest.mark.compiled
def test_a_box_that_is_let_go_stays_inside(world):
    ball, box = world["ball"], world["marble"]
    hung = world.suspend(box, ball)
    world.run(0.05)
    assert world.contact_points().pairs() == set()
    world.remove(hung)
    assert (world.joints, box.inside) == ((), ball)


@pytest.mark.compiled
def test_what_hangs_is_saved_and_copied_and_goes_on_to_the_same_bits(world, tmp_path):
    world.suspend(world["marble"], world["ball"], name="hung")
    world.run(0.05, 1e-3)
    world.save(tmp_path / "world.npz")
    for each in (World.load(tmp_path / "world.npz"), copy.deepcopy(world), pickle.loads(pickle.dumps(world))):
        assert each["hung"].box == each["marble"]
        each.run(0.05, 1e-3)
        copied = copy.deepcopy(world)
        copied.run(0.05, 1e-3)
        assert each.state_hash() == copied.state_hash()
