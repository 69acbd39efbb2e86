"""Where does a soft body come to rest? By relaxation that is faster than waiting."""

from __future__ import annotations

from math import sqrt

import numpy as np

from softbody.dynamics.motion import Scratch, ring_accelerations
from softbody.jit import jit
from softbody.state import Model, Rings

# Bitzek, Koskinen, Gähler, Moseler and Gumbsch 2006 ("FIRE"), with the parameters of the paper.
PATIENCE = 5
FASTER, SLOWER = 1.1, 0.5
STEERING, STEERING_FADES = 0.1, 0.99


@jit
def relax(model: Model, rings: Rings, position: np.ndarray, longest: float, steps: int, scratch: Scratch) -> float:
    """Move all soft bodies downhill in energy by `steps` steps of at most `longest` [s], `position` (n, 3) [m].

    They glide like bodies in motion, their velocity steered towards the force, and stop whenever they would climb.
    Returns the largest acceleration [m/s²] that is left, of any component of any particle.
    """
    velocity = np.zeros_like(position)
    acceleration = np.empty_like(position)
    still = np.zeros_like(position)
    h, steering, downhill = longest, STEERING, 0
    ring_accelerations(model, rings, position, still, acceleration, scratch)
    for _ in range(steps):
        power = along = speed = 0.0
        for i in range(position.shape[0]):
            for c in range(3):
                power += acceleration[i, c] * velocity[i, c]
                along += acceleration[i, c] * acceleration[i, c]
                speed += velocity[i, c] * velocity[i, c]
        if along == 0.0:
            break
        keep, turn = 1.0 - steering, steering * sqrt(speed / along)
        if power <= 0.0:
            keep, turn = 0.0, 0.0
            h, steering, downhill = h * SLOWER, STEERING, 0
        else:
            downhill += 1
            if downhill > PATIENCE:
                h, steering = min(h * FASTER, longest), steering * STEERING_FADES
        for i in range(position.shape[0]):
            for c in range(3):
                velocity[i, c] = keep * velocity[i, c] + (turn + h) * acceleration[i, c]
                position[i, c] += h * velocity[i, c]
        ring_accelerations(model, rings, position, still, acceleration, scratch)
    return np.abs(acceleration).max()
