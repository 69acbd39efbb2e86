"""Bullet's boxes, by way of pybullet (double precision)."""

from __future__ import annotations

import numpy as np

from references.pybullet import pybullet
from references.pybullet_world import closest
from validation.effort import iterations
from validation.subject import Boxes, Motion, moving

PACKAGES = {"pybullet": "pybullet"}  # import name, and the name to install it by
SETTINGS = {  # what was chosen against the defaults, and why
    "no damping, no sleeping": "boxes would stop by themselves",
    "no restitution threshold": "slow impacts are asked about as well",
    "restitution √e and friction √μ on every body": "Bullet multiplies those of a pair",
    "continuous detection, by spheres as large as half the smallest extent": (
        "fast boxes are asked whether they go through each other: twice as many do without"
    ),
    "useMaximalCoordinates": "plain rigid bodies: half the claims are about nothing else",
    "the solver runs all its iterations (residual 1e-7)": "what is left differs from step to step else",
    "a held box that moves weighs 1e9 kg, and is carried": "bodies of mass 0 have no speed in contacts",
    "all else as it comes": (
        "contactERP 0 makes bounces right to 3e-4, and lets a stack sink through the ground; split impulses, 200"
        " iterations, a nearer contactBreakingThreshold and friction without the cone serve no claim better"
    ),
    "margins 0 where it is asked whether boxes overlap": "the default adds 5e-4 m",
}
CANNOT = {  # question → why it has no answer
    "gas_volume": "from Python its soft bodies are given no gas; those of `panda3d` are",
    "gas_period": "from Python its soft bodies are given no gas; those of `panda3d` are",
    "points_in_mesh": "its meshes are surfaces, and have no inside",
    "move_soft": "from Python its soft bodies are given no gas",
}

HEAVY = 1e9  # [kg]


def move_boxes(boxes: Boxes, step: float, steps: int, every: int) -> Motion:
    """Let boxes move."""
    client = pybullet.connect(pybullet.DIRECT)
    try:
        pybullet.setGravity(0.0, 0.0, -boxes.gravity, physicsClientId=client)
        pybullet.setPhysicsEngineParameter(
            solverResidualThreshold=0.0,
            numSolverIterations=iterations(50),
            restitutionVelocityThreshold=0.0,
            deterministicOverlappingPairs=1,
            physicsClientId=client,
        )
        pybullet.setTimeStep(step, physicsClientId=client)
        bodies = [_add(client, boxes, box) for box in boxes.rows()]
        carried = [body for body, mass in zip(bodies, boxes.mass) if np.isinf(mass) and _mass(client, body)]

        def now() -> tuple[np.ndarray, ...]:
            poses = [pybullet.getBasePositionAndOrientation(body, client) for body in bodies]
            speeds = [pybullet.getBaseVelocity(body, client) for body in bodies]
            position, turn = (np.array(rows) for rows in zip(*poses))
            velocity, spin = (np.array(rows) for rows in zip(*speeds))
            return position, np.roll(turn, 1, axis=1), velocity, spin

        def advance(count: int) -> None:
            for _ in range(count):
                for body in carried:
                    where, _ = pybullet.getBasePositionAndOrientation(body, client)
                    lift = 0.0, 0.0, HEAVY * boxes.gravity
                    pybullet.applyExternalForce(body, -1, lift, where, pybullet.WORLD_FRAME, physicsClientId=client)
                pybullet.stepSimulation(client)

        return moving(now, advance, steps, every)
    finally:
        pybullet.disconnect(client)


def boxes_overlap(*pairs: np.ndarray) -> np.ndarray:
    """Tell whether boxes overlap: whether Bullet finds points that are 0 or less apart."""
    distance, _ = closest(*pairs)
    return ~np.isnan(distance)


def _add(client: int, boxes: Boxes, box: tuple[np.ndarray, ...]) -> int:
    size, mass, position, orientation, velocity, spin = box
    held, moves = bool(np.isinf(mass)), bool(np.any(velocity) or np.any(spin))
    kilogram = float(mass) if not held else HEAVY if moves else 0.0
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=0.5 * size, physicsClientId=client)
    turn = np.roll(orientation, -1)
    body: int = pybullet.createMultiBody(
        kilogram, shape, -1, position, turn, useMaximalCoordinates=1, physicsClientId=client
    )
    pybullet.changeDynamics(
        body,
        -1,
        linearDamping=0.0,
        angularDamping=0.0,
        restitution=boxes.restitution**0.5,
        lateralFriction=boxes.friction**0.5,
        ccdSweptSphereRadius=0.0 if held else 0.5 * size.min(),
        activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING,
        physicsClientId=client,
    )
    pybullet.resetBaseVelocity(body, velocity, spin, physicsClientId=client)
    return body


def _mass(client: int, body: int) -> float:
    return float(pybullet.getDynamicsInfo(body, -1, client)[0])
