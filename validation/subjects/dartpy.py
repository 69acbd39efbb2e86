"""DART's boxes (double precision)."""

from __future__ import annotations

import dartpy
import numpy as np

from references.analytic import rotation_matrix
from validation.effort import iterations
from validation.subject import Boxes, Motion, moving

PACKAGES = {"dartpy": "dartpy"}  # import name, and the name to install it by
SETTINGS = {  # what was chosen against the defaults, and why
    "solver NsgsFrictionSolver with the law Coulomb, tolerance 1e-7 (Dantzig)": (
        "the cone itself: boxes that slide or are carried are a quarter wrong by Dantzig's pyramid. A stack of ten"
        " stands by Dantzig, and not by this"
    ),
    "sleep off": "boxes slower than 0.01 m/s would stop",
    "FCL's box–box contacts": "DART's own detector gives a pressure that is not the same at all corners",
    "split impulses": "depths that are undone add no speed",
    "restitution √e on every body": "DART multiplies those of a pair; of friction it takes the smaller",
    "a held box that moves is driven (actuator VELOCITY)": "so its speed is felt in contacts",
}
CANNOT = {  # question → why it has no answer
    "boxes_overlap": "it asks FCL, which is a subject itself",
    "gas_volume": "its soft bodies have no gas",
    "gas_period": "its soft bodies have no gas",
    "points_in_mesh": "its meshes are surfaces, and have no inside",
    "move_soft": "its soft bodies have no gas",
}


def move_boxes(boxes: Boxes, step: float, steps: int, every: int) -> Motion:
    """Let boxes move."""
    world = dartpy.simulation.World()
    world.setGravity([0.0, 0.0, -boxes.gravity])
    world.setTimeStep(step)
    sleep = world.getDeactivationOptions()
    sleep.mEnabled = False
    world.setDeactivationOptions(sleep)
    options = dartpy.constraint.NsgsFrictionSolver.Options()
    options.law = dartpy.constraint.NsgsFrictionSolver.Law.Coulomb
    options.tolerance = 1e-7
    options.maxSweeps = iterations(options.maxSweeps)
    solver = world.getConstraintSolver()
    solver.setBoxedLcpSolver(dartpy.constraint.NsgsFrictionSolver(options))
    solver.setCollisionDetector(dartpy.collision.FCLCollisionDetector())
    solver.setSplitImpulseEnabled(True)
    bodies = [_add(world, boxes, k, box) for k, box in enumerate(boxes.rows())]

    def now() -> tuple[np.ndarray, ...]:
        poses = [body.getWorldTransform() for body in bodies]
        return (
            np.array([pose.translation() for pose in poses]),
            np.array([pose.quaternion().wxyz() for pose in poses]),
            np.array([body.getLinearVelocity() for body in bodies]),
            np.array([body.getAngularVelocity() for body in bodies]),
        )

    def advance(count: int) -> None:
        for _ in range(count):
            world.step(False)  # commands of driven boxes go on

    return moving(now, advance, steps, every)


def _add(world: dartpy.simulation.World, boxes: Boxes, number: int, box: tuple) -> dartpy.dynamics.BodyNode:
    size, mass, position, orientation, velocity, spin = box
    held, moves = bool(np.isinf(mass)), bool(np.any(velocity) or np.any(spin))
    skeleton, pose, turn = dartpy.dynamics.Skeleton(f"box {number}"), np.eye(4), rotation_matrix(orientation)
    pose[:3, :3], pose[:3, 3] = turn, position
    if held and not moves:
        joint, body = skeleton.createWeldJointAndBodyNodePair()
        joint.setTransformFromParentBodyNode(pose)
    else:
        joint, body = skeleton.createFreeJointAndBodyNodePair()
        inertia, kilogram = dartpy.dynamics.Inertia(), 1.0 if held else float(mass)
        inertia.setMass(kilogram)
        inertia.setMoment(np.diag(kilogram / 12.0 * (size @ size - size**2)))
        body.setInertia(inertia)
        way = np.concatenate([turn.T @ spin, turn.T @ velocity])
        joint.setRelativeTransform(pose)
        joint.setRelativeSpatialVelocity(way)
        if held:
            joint.setActuatorType(dartpy.dynamics.ActuatorType.VELOCITY)
            joint.setCommands(joint.getVelocities())  # in the frame of the world, unlike `way`
    node = body.createShapeNode(dartpy.dynamics.BoxShape(size))
    node.createCollisionAspect()
    material = node.createDynamicsAspect()
    material.setFrictionCoeff(boxes.friction)
    material.setRestitutionCoeff(boxes.restitution**0.5)
    world.addSkeleton(skeleton)
    return body
