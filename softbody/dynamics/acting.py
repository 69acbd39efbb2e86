"""What acts on bodies in a step besides springs, gas and gravity: forces of users, of joints, and of liquids.

Joints and liquids are forces that are constant within the step, from where bodies are in the part of it at which the
whole is symplectic (Hairer, Lubich and Wanner 2003): now, for what moves by x' = x + h v', as boxes do; half-way, by
the velocity now, for what moves by x' = x + h v + ½ h² a. So they keep energy for a small step; and what hangs at rest
hangs as far as k x = m g says, whatever the step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit
from softbody.dynamics.boxes_inside import add_forces_inside
from softbody.dynamics.filling import add_filling_forces
from softbody.dynamics.joint_forces import add_joint_forces
from softbody.dynamics.liquid_forces import Moving, add_liquid_forces
from softbody.dynamics.ring_pressure import RingWork, memory_for_rings
from softbody.dynamics.soft_bodies import Motion
from softbody.model.arrays import Controls, Joints, Model, State, VertexRings
from softbody.model.settings import RK4, Settings


class Acting(NamedTuple):
    """Memory for what acts in a step."""

    controls: Controls
    rows: np.ndarray  # for one soft body at a time, see RingWork


@jit
def all_that_acts(
    model: Model,
    controls: Controls,
    state: State,
    motion: Motion | None,
    joints: Joints | None,
    memory: Acting | None,
    settings: Settings,
    h: float,
) -> Controls:
    """Return what acts in a step of `h` [s]: the controls, with forces of joints and liquids, in `memory`.

    `joints` and `memory` are None where there are none of both, `motion` where there are no soft bodies.
    """
    if joints is None or memory is None:
        return controls
    acting = memory.controls
    acting.particle_force[:] = 0.0
    if controls.particle_force.shape[0] > 0:
        acting.particle_force[:] = controls.particle_force
    acting.box_force[:] = controls.box_force
    acting.box_torque[:] = controls.box_torque
    # x' = x + h v + β h² a: of n sub-steps of x' = x + h v', β is (1 + 1/n) / 2. The part is 1 − β.
    ahead = 0.5 * h * (1.0 if settings.integrator == RK4 else 1.0 - 1.0 / settings.substeps)
    add_joint_forces(state, joints, ahead, acting)
    if model.liquid_density > 0.0:
        add_liquid_forces(model, controls.gravity, state, ahead, acting)
    if motion is not None:
        work = RingWork(motion.rings, memory.rows)
        moving = Moving(state.particle_position, state.particle_velocity, ahead)
        add_filling_forces(model, controls.gravity, work, moving, state.box_position, acting.particle_force)
        add_forces_inside(model, controls.gravity, state, ahead, acting)
    return Controls(controls.gravity, controls.soft_gas, acting.particle_force, acting.box_force, acting.box_torque)


def memory_for_forces(state: State, controls: Controls, rings: VertexRings) -> Acting:
    """Return memory for what `all_that_acts` returns."""
    forces = Controls(
        controls.gravity,
        controls.soft_gas,
        np.zeros_like(state.particle_position),
        np.zeros_like(controls.box_force),
        np.zeros_like(controls.box_torque),
    )
    return Acting(forces, memory_for_rings(rings))
