"""Rapier's boxes (single precision)."""

from __future__ import annotations

import numpy as np
import rapier3d

from validation.effort import iterations
from validation.subject import Boxes, Motion, moving

PACKAGES = {"rapier3d": "rapier3d"}  # import name, and the name to install it by
SETTINGS = {  # what was chosen against the defaults, and why
    "no sleep": "a box that sleeps does not say whether it rests",
    "gyroscopic forces on": "a body that turns freely is asked whether it keeps its angular momentum",
    "continuous detection (ccd_enabled) on": "fast boxes are asked whether they go through each other",
    "all else as it comes": (
        "predictions, softness, iterations, the Coulomb model and recycling were changed, one by one: over all claims"
        " nothing served it better"
    ),
    "one thread": "worlds of some ten boxes gain nothing from more",
}
PRECISION = "single"
CANNOT = {  # question → why it has no answer
    "boxes_overlap": "its adapter does not ask it so far",
    "gas_volume": "its soft bodies keep their volume, and have no gas",
    "gas_period": "its soft bodies keep their volume, and have no gas",
    "points_in_mesh": "its meshes are surfaces, and have no inside",
    "move_soft": "its soft bodies keep their volume, and have no gas",
}


def move_boxes(boxes: Boxes, step: float, steps: int, every: int) -> Motion:
    """Let boxes move."""
    world = rapier3d.PhysicsWorld(gravity=(0.0, 0.0, -boxes.gravity))
    world.set_num_threads(1)
    world.integration_parameters.dt = step
    world.integration_parameters.num_solver_iterations = iterations(4)
    handles = [_add(world, boxes, box) for box in boxes.rows()]

    def now() -> tuple[np.ndarray, ...]:
        bodies = [world.rigid_bodies[handle] for handle in handles]
        turns = [body.rotation for body in bodies]
        return (
            np.array([list(body.translation) for body in bodies]),
            np.array([(turn.w, turn.i, turn.j, turn.k) for turn in turns]),
            np.array([list(body.linvel) for body in bodies]),
            np.array([list(body.angvel) for body in bodies]),
        )

    def advance(count: int) -> None:
        for _ in range(count):
            world.step()

    return moving(now, advance, steps, every)


def _add(world: rapier3d.PhysicsWorld, boxes: Boxes, box: tuple[np.ndarray, ...]) -> rapier3d.RigidBodyHandle:
    size, mass, position, orientation, velocity, spin = box
    held, moves = np.isinf(mass), bool(np.any(velocity) or np.any(spin))
    kind = rapier3d.RigidBody.dynamic
    if held:
        kind = rapier3d.RigidBody.kinematic_velocity_based if moves else rapier3d.RigidBody.fixed
    body = kind().linvel(velocity).angvel(spin) if moves else kind()
    if not held:
        body = body.gyroscopic_forces(True).ccd_enabled(True)
    shape = rapier3d.Collider.cuboid(*(0.5 * size)).restitution(boxes.restitution).friction(boxes.friction)
    pose = rapier3d.Isometry3(position, rapier3d.Rotation3(*orientation))
    return world.add_body(body.position(pose).can_sleep(False), [shape if held else shape.mass(float(mass))])
