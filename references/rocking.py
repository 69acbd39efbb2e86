"""A rigid block that rocks from edge to edge on the ground, as G. W. Housner (1963) has it, by SciPy.

"The behavior of inverted pendulum structures during earthquakes", Bulletin of the Seismological Society of America 53.
"""

from __future__ import annotations

from math import atan2, hypot, sin

import numpy as np
import scipy.integrate


def rocking_block(
    width: float, height: float, lean: float, swings: int, late: float = 0.0, gravity: float = 9.81
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far [rad] a block leans at the end of each swing, and when [s]; it starts at rest, at a `lean`.

    It turns about one edge, and then about the other, without sliding. The impact between them is at the new edge
    alone, so that the angular momentum about that edge is kept: ω falls to 1 − 3/2 sin² α of what it was, with tan α
    the width by the height. If its weight pulls about the new edge too soon by `late` [s], it loses what that does,
    about this edge and about the old one. DOP853 with rtol 1e-11 and atol 1e-13.
    """
    slender, pull = atan2(width, height), 1.5 * gravity / hypot(width, height)
    kept = 1.0 - 1.5 * sin(slender) ** 2
    peaks, times, now = [], [], 0.0

    def turn(start: tuple[float, float], until: int) -> np.ndarray:
        """Turn about an edge until the angle (0) or the angular velocity (1) has fallen to 0."""
        nonlocal now
        solved = scipy.integrate.solve_ivp(
            lambda _, y: [y[1], -pull * sin(slender - y[0])],
            (0.0, 100.0),
            start,
            method="DOP853",
            events=_FallsToZero(until),
            rtol=1e-11,
            atol=1e-13,
        )
        now += solved.t[-1]
        return solved.y[:, -1]

    for _ in range(swings):
        speed = -kept * turn((lean, 0.0), 0)[1] - 2.0 * late * pull * sin(slender)
        lean = turn((0.0, speed), 1)[0]
        peaks.append(lean)
        times.append(now)
    return np.array(peaks), np.array(times)


class _FallsToZero:
    """An event: a component of what is solved for has fallen to 0."""

    terminal, direction = True, -1.0

    def __init__(self, component: int) -> None:
        self.component = component

    def __call__(self, _: float, y: np.ndarray) -> float:
        return float(y[self.component])
