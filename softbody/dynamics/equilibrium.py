"""Where does a soft body come to rest? By relaxation that is faster than waiting."""

from __future__ import annotations

from math import sqrt

import numpy as np

from softbody.dynamics.soft_bodies import Motion, ring_accelerations
from softbody.jit import jit
from softbody.state import SoftBodies

# Bitzek, Koskinen, Gähler, Moseler and Gumbsch 2006 ("FIRE"), with the parameters of their paper.
PATIENCE = 5
FASTER, SLOWER = 1.1, 0.5
MIXING, MIXING_FADES = 0.1, 0.99


@jit
def relax(bodies: SoftBodies, motion: Motion, longest: float, steps: int) -> float:
    """Move soft bodies downhill in energy by `steps` steps of at most `longest` [s]; their velocities are zero.

    They glide like bodies in motion, their velocity mixed with the direction of the force, and stop whenever they
    would climb. Returns the largest acceleration [m/s²] that is left, of any component of any particle.
    """
    position = bodies.position
    velocity = np.zeros_like(position)
    acceleration = np.empty_like(position)
    h, mixing, downhill = longest, MIXING, 0
    ring_accelerations(bodies, motion, acceleration)
    for _ in range(steps):
        power = along = speed = 0.0
        for i in range(position.shape[0]):
            for c in range(3):
                power += acceleration[i, c] * velocity[i, c]
                along += acceleration[i, c] * acceleration[i, c]
                speed += velocity[i, c] * velocity[i, c]
        if along == 0.0:
            break
        # Downhill: faster and faster, with less mixing. Uphill: stop, and start again with shorter steps.
        keep, turn = 1.0 - mixing, mixing * sqrt(speed / along)
        if power <= 0.0:
            keep, turn = 0.0, 0.0
            h, mixing, downhill = h * SLOWER, MIXING, 0
        else:
            downhill += 1
            if downhill > PATIENCE:
                h, mixing = min(h * FASTER, longest), mixing * MIXING_FADES
        for i in range(position.shape[0]):
            for c in range(3):
                velocity[i, c] = keep * velocity[i, c] + (turn + h) * acceleration[i, c]
                position[i, c] += h * velocity[i, c]
        ring_accelerations(bodies, motion, acceleration)
    return np.abs(acceleration).max()
