"""Coulomb friction of boxes on static ground and each other, step by step, by DART (dartpy 6.20.0).

What cannot be switched off from Python: the diagonal of the problem is 1 + 1e-5 times itself (CFM), so that impulses
are 1e-5 too small, and bodies that touch sink by less than 1e-6 m/s; a bounce needs 0.1 m/s. Contacts are found where
boxes overlap, and not ahead: a box that is to stand from the first step on is placed 1e-9 m or so inside what it stands
on. DART's step is Euler–Cromer, with the gyroscopic torque. The friction of a pair is the smaller of both; restitution
is 0.
"""

from __future__ import annotations

import dartpy
import numpy as np
from numpy.typing import ArrayLike

from references.analytic import rotation_matrix

PACKAGES = {"dartpy": "dartpy"}  # import name, and the name to install it by
KIND = "third-party engine"  # of judge
SETTINGS = {  # what was chosen against the defaults, and why
    "solver NsgsFrictionSolver with the law Coulomb (Dantzig)": (
        "the cone itself: the pyramid of Dantzig's boxed LCP has its axes along x and y of the world, and lets a "
        "box that slides between them have up to √2 of the friction"
    ),
    "tolerance 1e-7 (1e-5), 100 sweeps": (
        "a box that slides or spins then follows the closed forms to 5e-7 of its speed; more is not to be had where "
        "four corners share one weight"
    ),
    "sleep off": "boxes slower than 0.01 m/s would stop",
    "FCL's box–box contacts, by primitives": (
        "its meshes give each point several times, and DART's own detector a pressure that is not the same at all "
        "corners"
    ),
    "split impulses": "so that depths, a hundredth of which is undone a step at no more than 1 mm/s, add no speed",
}

GROUND = (200.0, 200.0, 2.0)  # [m]


class DartWorld:
    """Boxes on a static ground whose top is z = 0, in DART."""

    def __init__(self, step: float, gravity: float = 9.81) -> None:
        self.world = dartpy.simulation.World()
        self.world.setGravity([0.0, 0.0, -gravity])
        self.world.setTimeStep(step)
        sleep = self.world.getDeactivationOptions()
        sleep.mEnabled = False
        self.world.setDeactivationOptions(sleep)
        options = dartpy.constraint.NsgsFrictionSolver.Options()
        options.law = dartpy.constraint.NsgsFrictionSolver.Law.Coulomb
        options.tolerance = 1e-7
        solver = self.world.getConstraintSolver()
        solver.setBoxedLcpSolver(dartpy.constraint.NsgsFrictionSolver(options))
        solver.setCollisionDetector(dartpy.collision.FCLCollisionDetector())
        solver.setSplitImpulseEnabled(True)
        self.boxes: list[dartpy.dynamics.BodyNode] = []

    def add_ground(self, friction: float) -> None:
        """Add the ground."""
        skeleton, pose = dartpy.dynamics.Skeleton("ground"), np.eye(4)
        pose[2, 3] = -0.5 * GROUND[2]
        joint, body = skeleton.createWeldJointAndBodyNodePair()
        joint.setTransformFromParentBodyNode(pose)
        _add_shape(body, GROUND, friction)
        self.world.addSkeleton(skeleton)

    def add_box(
        self,
        size: ArrayLike,
        mass: float,
        position: ArrayLike,
        orientation: ArrayLike,
        velocity: ArrayLike,
        angular_velocity: ArrayLike,
        friction: float,
    ) -> None:
        """Add a box of full extent `size` (3,) [m]; `angular_velocity` (3,) [rad/s] in the world frame."""
        skeleton = dartpy.dynamics.Skeleton(f"box {len(self.boxes)}")
        joint, body = skeleton.createFreeJointAndBodyNodePair()
        extent, pose, turn = np.asarray(size, float), np.eye(4), rotation_matrix(np.asarray(orientation, float))
        inertia = dartpy.dynamics.Inertia()
        inertia.setMass(mass)
        inertia.setMoment(np.diag(mass / 12.0 * (extent @ extent - extent**2)))
        body.setInertia(inertia)
        pose[:3, :3], pose[:3, 3] = turn, position
        joint.setRelativeTransform(pose)
        joint.setRelativeSpatialVelocity(np.concatenate([turn.T @ angular_velocity, turn.T @ velocity]))
        _add_shape(body, extent, friction)
        self.world.addSkeleton(skeleton)
        self.boxes.append(body)

    def step(self, steps: int = 1) -> None:
        """Advance by `steps` steps."""
        for _ in range(steps):
            self.world.step(True)

    def positions(self) -> np.ndarray:
        """Return the centres (m, 3) [m]."""
        return np.array([body.getWorldTransform().translation() for body in self.boxes])

    def rotations(self) -> np.ndarray:
        """Return the rotation matrices (m, 3, 3)."""
        return np.array([body.getWorldTransform().rotation() for body in self.boxes])

    def velocities(self) -> np.ndarray:
        """Return v and ω (m, 6)."""
        return np.array([np.concatenate([body.getLinearVelocity(), body.getAngularVelocity()]) for body in self.boxes])


def _add_shape(body: dartpy.dynamics.BodyNode, size: ArrayLike, friction: float) -> None:
    """Let a body be a box that touches others with this friction, and does not bounce."""
    node = body.createShapeNode(dartpy.dynamics.BoxShape(np.asarray(size, float)))
    node.createCollisionAspect()
    material = node.createDynamicsAspect()
    material.setFrictionCoeff(friction)
    material.setRestitutionCoeff(0.0)
