"""Is seen, before a step, that something is not finite, or that somebody has moved particles?"""

import numpy as np
import pytest

from softbody import ParameterError, World, icosphere
from softbody.stepping.finite_check import begins_finite, checksum, is_finite

pytestmark = pytest.mark.interpreted

NUMBERS = np.random.default_rng(0).normal(size=(37, 3))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_one_number_that_is_not_finite_is_seen_wherever_it_is(value):
    assert is_finite(NUMBERS)
    assert is_finite(np.empty((0, 4)))
    assert is_finite(np.full((2, 3), np.finfo(float).max))
    for place in np.ndindex(NUMBERS.shape):
        rows = NUMBERS.copy()
        rows[place] = value
        assert not is_finite(rows)


def test_every_array_that_a_step_begins_with_is_looked_at(filled):
    controls = filled.controls._replace(particle_force=np.zeros_like(filled.state.particle_position))
    assert begins_finite(controls, filled.state)
    for name, rows in filled.state._asdict().items():
        spoiled = filled.state._replace(**{name: np.full_like(rows, np.nan)})
        # (A time left that is no number is none: the box goes on.)
        assert begins_finite(controls, spoiled) == (name == "box_time_left"), name
    for name in ("particle_force", "box_force", "box_torque"):
        spoiled = controls._replace(**{name: np.full_like(getattr(controls, name), np.inf)})
        assert not begins_finite(spoiled, filled.state), name


def test_a_fingerprint_is_that_of_these_rows_in_this_order():
    assert checksum(NUMBERS) == checksum(NUMBERS.copy())
    assert checksum(NUMBERS) != checksum(NUMBERS[::-1].copy())
    for place in np.ndindex(NUMBERS.shape):
        rows = NUMBERS.copy()
        rows[place] = np.nextafter(rows[place], np.inf)
        assert checksum(rows) != checksum(NUMBERS)


@pytest.mark.parametrize("bodies", [1, 2])
def test_between_steps_what_is_moved_is_estimated_anew_and_what_is_not_finite_refused(bodies):
    world = World()
    balls = [world.add_soft_body(icosphere(1, 0.5), 1.0, 100.0, 30.0, (3.0 * k, 0.0, 0.0)) for k in range(bodies)]
    h = 0.9 * world.stable_time_step()
    world.step(h, 2)
    kept = balls[-1].positions.copy()
    balls[-1].positions[:] = balls[-1].centre + 0.05 * (kept - balls[-1].centre)  # its gas is 8 000 times as dense
    with pytest.raises(ParameterError, match="a stable time step here is"):
        world.step(h)
    balls[-1].positions[:] = kept
    balls[-1].velocities[3, 1] = np.nan
    for allow in (False, True):
        with pytest.raises(ParameterError, match=f"velocity of particle 3 of soft body {bodies - 1} is not finite"):
            world.step(h, allow_unstable=allow)
    balls[-1].velocities[3, 1] = 0.0
    world.step(h)
    assert world.steps == 3
