"""Equilibrium of soft bodies, by relaxation (FIRE) that is faster than waiting."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit
from softbody.dynamics.filling import add_filling_forces
from softbody.dynamics.liquid_forces import Moving
from softbody.dynamics.ring_pressure import RingWork, memory_for_rings
from softbody.dynamics.soft_bodies import Motion, ring_accelerations
from softbody.linalg.vec import accumulate, load, scale
from softbody.model.arrays import Model, SoftBodies

# Bitzek, Koskinen, Gähler, Moseler and Gumbsch 2006 ("FIRE"), with the parameters of their paper.
PATIENCE = 5
FASTER, SLOWER = 1.1, 0.5
MIXING, MIXING_FADES = 0.1, 0.99


class Glide(NamedTuple):
    """How bodies glide that are being relaxed: what goes on where a run was stopped."""

    velocity: np.ndarray  # (n, 3) [m/s]
    step_size: np.ndarray  # (3,) length of the next step [s], part of the mixing, steps downhill so far


def glide_from_rest(position: np.ndarray, longest: float) -> Glide:
    """Return how bodies at `position` (n, 3) [m] begin to glide, with steps of `longest` [s]."""
    return Glide(np.zeros_like(position), np.array([longest, MIXING, 0.0]))


@jit
def relax(
    model: Model, bodies: SoftBodies, motion: Motion, longest: float, steps: int, glide: Glide
) -> tuple[float, int]:
    """Move the soft bodies of a model downhill in energy by `steps` steps of at most `longest` [s].

    They glide like bodies in motion, their velocity mixed with the direction of the force, and stop whenever they
    would climb. Returns the largest acceleration [m/s²] that is left, of any component of any particle, and how many
    steps are left: where `motion.memory.stop` is not 0, only the next one is made.
    """
    position, velocity = bodies.position, glide.velocity
    acceleration, force = np.empty_like(position), np.empty_like(position)
    rows = memory_for_rings(motion.rings)
    h, mixing, downhill = glide.step_size[0], glide.step_size[1], glide.step_size[2]
    left = 0
    _accelerate(model, bodies, motion, rows, force, acceleration)
    for done in range(1, steps + 1):
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
        _accelerate(model, bodies, motion, rows, force, acceleration)
        if motion.memory.stop[0] != 0:
            left = steps - done
            break
    glide.step_size[0], glide.step_size[1], glide.step_size[2] = h, mixing, downhill
    return np.abs(acceleration).max(), left


@jit
def _accelerate(
    model: Model,
    bodies: SoftBodies,
    motion: Motion,
    rows: np.ndarray,
    force: np.ndarray,
    acceleration: np.ndarray,
) -> None:
    """Overwrite `acceleration` (n, 3) [m/s²] with that of all particles; `rows` (see RingWork), `force` are scratch."""
    ring_accelerations(bodies, motion, acceleration)
    force[:] = 0.0
    work, moving = RingWork(motion.rings, rows), Moving(bodies.position, bodies.velocity, 0.0)
    add_filling_forces(model, bodies.gravity, work, moving, np.empty((0, 3)), force)
    for i in range(force.shape[0]):
        accumulate(acceleration, i, scale(bodies.inverse_mass[i], load(force, i)))
