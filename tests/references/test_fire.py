"""Is the judge's FIRE the algorithm? The first steps by hand, and where it ends."""

import numpy as np

from references import fire, scipy

TETRAHEDRON = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
EDGES = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])
SPRINGS = EDGES, np.full(6, 8.0**0.5), np.full(6, 10.0)
LOOSE = EDGES, np.full(6, 8.0**0.5), np.zeros(6)
FREE = np.ones(4, bool)


def test_what_falls_first_waits_and_then_goes_by_symplectic_euler():
    gravity = np.array([0.0, 0.0, -10.0])
    x, v, step = fire.relaxed(TETRAHEDRON, 0.1, 2, *LOOSE, TRIANGLES, 0.0, 1.0, gravity, FREE)
    # At rest there is no power: the step is halved. Then force and velocity are parallel: mixing changes nothing.
    assert step == 0.05
    assert np.allclose(v, [0.0, 0.0, -1.0])
    assert np.allclose(x - TETRAHEDRON, [0.0, 0.0, -0.05 * (0.5 + 1.0)])


def test_steps_grow_after_five_and_no_farther_than_the_longest():
    gravity = np.array([0.0, 0.0, -10.0])
    steps = [fire.relaxed(TETRAHEDRON, 0.1, n, *LOOSE, TRIANGLES, 0.0, 1.0, gravity, FREE)[2] for n in range(1, 20)]
    assert np.allclose(steps[:6], 0.05)
    assert np.allclose(steps[6:13], 0.05 * 1.1 ** np.arange(1, 8))
    assert np.allclose(steps[14:], 0.1)


def test_what_is_pinned_stays_and_the_end_is_the_equilibrium():
    free = np.array([True, True, True, False])
    gas = 3.0
    x, v, _ = fire.relaxed(1.2 * TETRAHEDRON, 0.1, 400, *SPRINGS, TRIANGLES, gas, 1.0, np.zeros(3), free)
    assert np.array_equal(x[3], 1.2 * TETRAHEDRON[3])
    assert np.abs(scipy.forces(x, *SPRINGS, TRIANGLES, gas)[:3]).max() < 1e-9
    assert np.abs(v).max() < 1e-6
