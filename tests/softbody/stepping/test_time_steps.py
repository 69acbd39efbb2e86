"""Does a stretch of time end where it was asked to, in steps no longer than allowed?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import softbody
from softbody import ParameterError
from softbody.stepping.time_steps import whole_steps, whole_steps_owed


@pytest.fixture
def falling():
    """A world of one small box that falls."""
    world = softbody.World()
    world.add_box((0.1, 0.1, 0.1), 1.0)
    return world


@pytest.mark.parametrize(
    ("seconds", "time_step", "count", "length"),
    [
        (1.0, 0.25, 4, 0.25),
        (0.0, 0.1, 0, 0.1),
        (30.0, 1e-3, 30_000, 1e-3),
        (1.0, 0.4, 3, 1.0 / 3.0),
        (4e-4, 1e-3, 1, 4e-4),
    ],
)
def test_a_step_that_goes_into_the_time_stays_as_it_is_and_others_shrink(seconds, time_step, count, length):
    assert whole_steps(seconds, time_step) == (count, length)


@given(st.floats(1e-6, 1e6), st.floats(1e-6, 1e3))
def test_steps_are_never_longer_than_asked_for_and_make_up_the_time(seconds, time_step):
    count, length = whole_steps(seconds, time_step)
    assert length <= time_step
    assert count * length == pytest.approx(seconds, rel=1e-11)


def test_sixty_frames_of_a_sixtieth_make_a_second(falling):
    for _ in range(60):
        falling.run(1.0 / 60.0, 1e-3)
    assert falling.time == pytest.approx(1.0, abs=1e-12)


@given(st.lists(st.floats(0.0, 0.1), min_size=1, max_size=50))
def test_a_remainder_loses_no_time(frames):
    owed, steps = 0.0, 0
    for seconds in frames:
        more, owed = whole_steps_owed(owed, seconds, 0.01)
        steps += more
    assert steps * 0.01 + owed == pytest.approx(sum(frames), abs=1e-12)
    assert 0.0 <= owed < 0.01 * (1.0 + 1e-9)


def test_frames_of_any_length_give_the_bits_of_their_steps(falling):
    other = softbody.World()
    other.add_box((0.1, 0.1, 0.1), 1.0)
    for seconds in np.random.default_rng(0).uniform(0.0, 0.05, 40):
        falling.step_frame(seconds, 1.0 / 240.0)
    other.step(1.0 / 240.0, falling.steps)
    assert falling.steps > 100
    assert falling.state_hash() == other.state_hash()


def test_a_world_chooses_stable_steps_that_end_with_the_frame():
    world = softbody.World()
    world.add_soft_body(softbody.icosphere(1), mass=1.0, stiffness=1e4, gas=10.0)
    stable = world.stable_time_step()
    steps = world.step_frame(0.1)
    assert 0.1 / steps <= 0.8 * stable < 0.1 / (steps - 1)
    assert world.time == pytest.approx(0.1, abs=1e-15)
    assert world.step_frame(0.0) == 0


def test_boxes_are_stepped_240_times_a_second_or_more(falling):
    assert falling.step_frame() == 4
    assert falling.step_frame(1e-3) == 1


def test_frames_end_with_a_shorter_one(falling):
    assert list(falling.frames(0.25, per_second=10.0)) == [0, 1, 2]
    assert falling.time == pytest.approx(0.25, abs=1e-14)
    falling.run(0.75)
    assert falling.time == pytest.approx(1.0, abs=1e-13)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda world: world.step_frame(-1.0), "seconds"),
        (lambda world: world.step_frame(1.0, 0.0), "time_step"),
        (lambda world: world.step_frame(1e300, 1e-300), "seconds / time_step"),
        (lambda world: list(world.frames(1.0, per_second=0.0)), "per_second"),
        (lambda world: world.run(np.nan), "seconds"),
    ],
)
def test_times_that_make_no_sense_are_refused(falling, call, name):
    with pytest.raises(ParameterError, match=f"^{name} is"):
        call(falling)
    assert falling.steps == 0
