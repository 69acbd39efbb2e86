"""One box in each engine: it falls as bodies fall, and rests where it must."""

import numpy as np
import pytest

from references.piles import ENGINES

STEP = 1.0 / 240.0
SIZE = np.array([0.7, 0.8, 0.9])
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


@pytest.mark.parametrize("engine", ENGINES)
def test_a_box_falls_freely(engine: str) -> None:
    start = np.array([0.1, 0.2, 9.0])
    places, velocities = ENGINES[engine]([(SIZE, start, UPRIGHT)], 0.5, STEP, 48)
    np.testing.assert_allclose(velocities[0], [0.0, 0.0, -9.81 * 0.2], atol=1e-5)
    # Symplectic Euler's fall is longer by g t h / 2; Rapier takes each step in four parts.
    np.testing.assert_allclose(places[0], start - [0.0, 0.0, 0.5 * 9.81 * 0.2 * (0.2 + STEP)], atol=6e-3)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_box_comes_to_rest_on_the_ground(engine: str) -> None:
    places, velocities = ENGINES[engine]([(SIZE, np.array([0.0, 0.0, 0.6]), UPRIGHT)], 0.5, STEP, 960)
    np.testing.assert_allclose(places[0], [0.0, 0.0, 0.45], atol=2e-3)
    assert np.abs(velocities).max() < 1e-3
