"""A world that is watched keeps up with the clock, or falls behind without a debt; changes come between steps."""

from __future__ import annotations

import numpy as np
import pytest

import softbody
from softbody import ParameterError
from softbody.view.frame import contact_points, frame_of
from softbody.view.session import Session


class Clock:
    """A clock that advances by so much whenever somebody looks at it."""

    def __init__(self, by=0.0):
        self.now, self.by = 0.0, by

    def __call__(self):
        self.now += self.by
        return self.now


@pytest.fixture
def world():
    world = softbody.World()
    world.add_ground()
    world.add_soft_body(softbody.icosphere(1, 0.5), 1.0, 100.0, 10.0, (0.0, 0.0, 0.7))
    return world


def test_the_world_goes_with_the_clock(world):
    session = Session(world, Clock())
    for _ in range(100):
        session.tick(0.01)
    assert world.time == pytest.approx(1.0, abs=0.01)
    assert session.real_time_factor == pytest.approx(1.0, abs=0.05)
    session.speed = 0.5
    for _ in range(100):
        session.tick(0.01)
    assert world.time == pytest.approx(1.5, abs=0.01)
    assert session.real_time_factor == pytest.approx(0.5, abs=0.05)


def test_a_slow_machine_falls_behind_and_makes_nothing_up(world):
    """Every look at the clock takes 10 ms, so that a turn ends after one call, whatever was owed."""
    session = Session(world, Clock(0.01))
    for _ in range(50):
        session.tick(0.005)
    behind = world.time
    assert behind < 0.25
    session._clock = Clock()
    session._cost = 0.0
    session.tick(0.0)
    assert world.time - behind <= 2.0 * session._step_length()


def test_a_session_of_the_same_turns_has_the_same_bits(world):
    start, hashes = world.snapshot(), []
    for _ in range(2):
        world.restore(start)
        session = Session(world, Clock())
        session.ask(lambda session=session: session.grab("soft", 0, np.array([0.0, 0.0, 1.2])))
        for _ in range(20):
            session.tick(0.01)
        hashes.append(world.state_hash())
    assert hashes[0] == hashes[1]


def test_pause_stops_it_step_takes_one_and_restart_begins_again(world):
    session = Session(world, Clock())
    begun = world.state_hash()
    session.tick(0.05)
    session.ask(lambda: session.play(False))
    session.tick(0.05)
    steps = world.steps
    session.tick(0.05)
    assert world.steps == steps > 0
    assert session.status == "paused"
    session.ask(session.step_once)
    session.tick(0.05)
    assert world.steps == steps + 1
    session.ask(session.restart)
    session.ask(lambda: session.play(False))
    session.tick(0.05)
    assert (world.steps, world.state_hash()) == (0, begun)
    assert session.frame.time == 0.0


def test_nothing_new_is_no_new_frame(world):
    session = Session(world, Clock())
    session.ask(lambda: session.play(False))
    session.tick(0.01)
    frame = session.frame
    session.tick(0.01)
    assert session.frame is frame


def test_a_restart_keeps_what_was_changed(world):
    session = Session(world, Clock())
    session.ask(lambda: session.set_slider("gravity", 1.0))
    session.ask(lambda: session.set_integrator("symplectic_euler"))
    session.tick(0.01)
    session.ask(session.restart)
    session.tick(0.01)
    assert world.controls.gravity[2] == -1.0
    assert world.integrator == "symplectic_euler"


def test_stiffer_springs_get_shorter_steps_before_they_diverge(world):
    session = Session(world, Clock())
    session.tick(0.01)
    before = session._step_length()
    session.ask(lambda: session.set_slider("stiffness", 3.0))
    session.tick(0.01)
    assert session._step_length() < before
    assert session.status == ""


def test_a_world_that_diverges_is_paused_and_says_why(world):
    session = Session(world, Clock())
    session.tick(0.01)
    world.state.particle_velocity[0] = 1e160
    session.tick(0.05)
    assert not session.is_playing
    assert session.status.startswith("stopped: ")
    session.ask(session.restart)
    session.tick(0.05)
    assert session.is_playing
    assert world.time > 0.0


def test_what_cannot_be_is_said_and_changes_nothing(world):
    session = Session(world, Clock())
    session.ask(lambda: session.set_integrator("euler"))
    session.ask(lambda: session.play(False))
    with pytest.raises(ParameterError):
        session.show("temperature")
    session.tick(0.0)
    assert world.integrator == softbody.World().integrator


def test_a_pull_moves_a_body_and_shows_its_spring(world):
    session = Session(world, Clock())
    session.ask(lambda: session.grab("soft", 0, np.array([0.0, 0.0, 1.2])))
    session.ask(lambda: setattr(session.grip, "target", np.array([0.0, 0.0, 3.0])))
    for _ in range(100):
        session.tick(0.01)
    assert softbody.SoftBody(world, 0).centre[2] > 2.0
    assert session.frame.pull.shape == (2, 3)
    session.ask(session.grip.let_go)
    session.tick(0.01)
    assert session.frame.pull is None


def test_a_frame_shares_no_memory_with_the_world(world):
    frame = frame_of(world, "strain")
    softbody.SoftBody(world, 0).positions[:] = 0.0
    assert frame.soft[0].max() > 1.0
    assert frame.soft[0].dtype == np.float32
    assert [len(each) for each in frame.values] == [42]


def test_a_frame_has_the_ends_of_joints(world):
    assert frame_of(world).joints.shape == (0, 2, 3)
    joint = world.add_joint((world.soft_bodies[0], 0), (0.0, 0.0, 2.0), 1.0)
    joints = frame_of(world).joints
    np.testing.assert_allclose(joints, [joint.ends], atol=1e-6)
    assert joints.dtype == np.float32


def test_contacts_are_those_of_bodies_and_of_particles_on_the_ground(world):
    assert contact_points(world).shape == (0, 3)
    world.run(1.0, 5e-3)
    points = contact_points(world)
    assert len(points) >= 1
    np.testing.assert_allclose(points[:, 2], 0.0, atol=1e-9)


def test_a_world_without_bodies_is_watched_too():
    session = Session(softbody.World(), Clock())
    session.tick(0.1)
    assert session.frame.soft == []
