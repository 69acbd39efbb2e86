"""Boxes that fly past each other, or into each other, by Rapier (rapier3d 0.36, single precision).

Kept: `ccd_enabled` off (the caller's steps are so short that nothing is jumped over, and where boxes are decides, not
another algorithm), contact skin 0, gravity 0, damping 0. A free box keeps I ω, and so ω only about an axis of its own.

All is float32: a place 100 m from the origin is known to 4e-6 m, and what a step adds to it is rounded alike each time,
so that a box drifts by as much a step. A coordinate that does not move does not drift: let boxes fly along x where the
air between them matters.
"""

from __future__ import annotations

import numpy as np
import rapier3d
from numpy.typing import ArrayLike

PACKAGES = {"rapier3d": "rapier3d"}  # import name, and the name to install it by
KIND = "third-party engine"  # of judge
SETTINGS = {  # what was chosen against the defaults, and why
    "contact_recycling off": (
        "Rapier keeps the contacts of a pair, and their normals, until it has moved by 5 cm; of boxes that pass "
        "with 1 mm to 1 cm of air, 2 mm a step, it strikes three of ten so"
    ),
    "normalized_prediction_distance 0 (2 cm)": (
        "a contact that is made before boxes touch acts along the normal of that moment, and strikes some that "
        "would pass; without it boxes touch when they overlap at the beginning of a step"
    ),
    "no sleep": "a box that waits for the other to come would fall asleep, and one that sleeps is not asked",
    "one thread": "worlds of some hundred boxes gain nothing from more",
}


def velocities_after(
    size: ArrayLike,
    mass: ArrayLike,
    position: ArrayLike,
    orientation: ArrayLike,
    velocity: ArrayLike,
    spin: ArrayLike,
    step: float,
    steps: int,
    restitution: float = 0.0,
) -> np.ndarray:
    """Return v and ω (m, 6) of m smooth boxes without weight after so many steps of `step` [s] in one world.

    Full sizes (m, 3) [m], masses (m,) [kg], infinite for one that is held, or that keeps its velocities; places,
    velocities and spins (m, 3), orientations (m, 4) unit quaternions.
    """
    world = rapier3d.PhysicsWorld()
    world.set_num_threads(1)
    world.integration_parameters.dt = step
    world.integration_parameters.contact_recycling = False
    world.integration_parameters.normalized_prediction_distance = 0.0
    arrays = [np.ascontiguousarray(x, float) for x in (size, mass, position, orientation, velocity, spin)]
    handles = [_add(world, box, restitution) for box in zip(*arrays)]
    for _ in range(steps):
        world.step()
    boxes = [world.rigid_bodies[handle] for handle in handles]
    return np.array([[*box.linvel, *box.angvel] for box in boxes])


def _add(world: rapier3d.PhysicsWorld, box: tuple[np.ndarray, ...], restitution: float) -> rapier3d.RigidBodyHandle:
    size, mass, position, orientation, velocity, spin = box
    held = np.isinf(mass)
    moves = bool(np.any(velocity) or np.any(spin))
    kind = rapier3d.RigidBody.dynamic
    if held:
        kind = rapier3d.RigidBody.kinematic_velocity_based if moves else rapier3d.RigidBody.fixed
    body = kind().linvel(velocity).angvel(spin) if moves else kind()
    pose = rapier3d.Isometry3(position, rapier3d.Rotation3(*orientation))
    shape = rapier3d.Collider.cuboid(*(0.5 * size)).restitution(restitution).friction(0.0)
    return world.add_body(body.position(pose).can_sleep(False), [shape if held else shape.mass(float(mass))])
