"""Bounces of a soft body off smooth ground, from event to event, by SciPy.

Between events DOP853 integrates springs, gas and weight, and keeps particles that the ground holds at its height. An
event is a particle that comes down to the ground, and loses the speed at which it does, or one that is held and is
drawn upwards, and is let go. Nothing here depends on a step.
"""

from __future__ import annotations

import numpy as np
import scipy.integrate

from references import scipy as soft_bodies

PACKAGES = {"scipy": "scipy"}  # import name, and the name to install it by

RTOL, ATOL = 1e-9, 1e-12  # of DOP853
MOST_EVENTS = 10_000
CLEAR = 1e-13  # [m] above the ground, where a particle begins that is let go: from 0, its next event would be this one


def bounce(
    vertices: np.ndarray,
    velocity: np.ndarray,
    springs: tuple[np.ndarray, np.ndarray, np.ndarray],
    triangles: np.ndarray,
    gas: float,
    particle_mass: float,
    gravity: float,
    seconds: float,
    damping: float = 0.0,
) -> tuple[np.ndarray, int]:
    """Return where the vertices (n, 3) [m] are after `seconds`, and the number of events; the ground is z ≤ 0.

    `springs` (edges (e, 2), rest length (e,) [m], stiffness (e,) [N/m]), `triangles` (t, 3), `gas` nRT [J], `gravity`
    [m/s²] downwards, `damping` [N s/m] of each spring. No friction, no bounce of a particle by itself. Raises
    RuntimeError after MOST_EVENTS.
    """
    x, v = np.array(vertices, float), np.array(velocity, float)
    held = np.zeros(len(x), bool)
    now = 0.0

    def acceleration(x: np.ndarray, v: np.ndarray) -> np.ndarray:
        force = soft_bodies.forces(x, *springs, triangles, gas) + soft_bodies.dampers(x, v, springs[0], damping)
        a = force / particle_mass
        a[:, 2] -= gravity
        return a

    def derivative(_: float, y: np.ndarray) -> np.ndarray:
        x, v = y.reshape(2, -1, 3)
        a = acceleration(x, v)
        a[held, 2] = 0.0
        return np.concatenate([v.ravel(), a.ravel()])

    def lowest(_: float, y: np.ndarray) -> float:
        return float(y.reshape(2, -1, 3)[0, ~held, 2].min(initial=1.0))

    def drawn(_: float, y: np.ndarray) -> float:
        return float(acceleration(*y.reshape(2, -1, 3))[held, 2].max(initial=-1.0))

    lowest.terminal = drawn.terminal = True  # type: ignore[attr-defined]
    lowest.direction, drawn.direction = -1.0, 1.0  # type: ignore[attr-defined]
    for events in range(MOST_EVENTS):
        begin = np.concatenate([x.ravel(), v.ravel()])
        run = scipy.integrate.solve_ivp(
            derivative, (now, seconds), begin, "DOP853", events=(lowest, drawn), rtol=RTOL, atol=ATOL
        )
        now = run.t[-1]
        x, v = run.y[:, -1].reshape(2, -1, 3).copy()
        if run.status == 0:
            return x, events
        if run.t_events[0].size:
            particle = np.flatnonzero(~held)[np.argmin(x[~held, 2])]
            x[particle, 2] = v[particle, 2] = 0.0
            held[particle] = acceleration(x, v)[particle, 2] < 0.0
        else:
            particle = np.flatnonzero(held)[np.argmax(acceleration(x, v)[held, 2])]
            held[particle] = False
        if not held[particle]:
            x[particle, 2] = CLEAR
    raise RuntimeError(f"{MOST_EVENTS} events before {seconds} s")
