"""Many boxes under gravity, step by step, and distances of two, by Bullet (pybullet 3.2.7)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from references.pybullet import pybullet

PACKAGES = {"pybullet": "pybullet"}  # import name, and the name to install it by
KIND = "third-party engine"  # of judge
SETTINGS = {  # what was chosen against the defaults, and why
    "no damping": "boxes would stop by themselves",
    "the solver runs all its iterations (residual 1e-7)": (
        "unless a `residual` is given: what is left differs from step to step else"
    ),
    "restitution and friction of the pair on one body, 1 on the other": "Bullet multiplies them",
    "no restitution threshold, no sleeping": "slow impacts and slow boxes are asked about as well",
    "useMaximalCoordinates": "plain rigid bodies; also the faster path",
    "the ground is a big static box": "Bullet's plane gives one contact a step only",
}

GROUND = 0  # Bullet's number of the first body


class BulletWorld:
    """Boxes on a static ground whose top is z = 0, in Bullet."""

    def __init__(
        self,
        step: float,
        iterations: int,
        restitution: float = 0.0,
        friction: float = 0.5,
        gravity: float = 9.81,
        residual: float = 0.0,
    ) -> None:
        self.client = pybullet.connect(pybullet.DIRECT)
        self.friction = friction
        self.restitution = restitution
        self.boxes: list[int] = []
        pybullet.setGravity(0.0, 0.0, -gravity, physicsClientId=self.client)
        pybullet.setPhysicsEngineParameter(
            numSolverIterations=iterations,
            solverResidualThreshold=residual,
            restitutionVelocityThreshold=0.0,
            deterministicOverlappingPairs=1,
            physicsClientId=self.client,
        )
        pybullet.setTimeStep(step, physicsClientId=self.client)

    def add_ground(self, half_width: float = 200.0) -> None:
        """Add the ground."""
        self._add((2 * half_width, 2 * half_width, 2.0), 0.0, (0.0, 0.0, -1.0), (1.0, 0.0, 0.0, 0.0), 1.0, 1.0)

    def add_box(
        self,
        size: ArrayLike,
        mass: float,
        position: ArrayLike,
        orientation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        spin: ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        """Add a box of full extent `size` (3,) [m]; a mass of 0 holds it."""
        # √μ and √e on every box, so that two boxes have the product μ, e.
        box = self._add(size, mass, position, orientation, self.restitution**0.5, self.friction**0.5)
        pybullet.resetBaseVelocity(box, velocity, spin, physicsClientId=self.client)
        self.boxes.append(box)

    def _add(
        self,
        size: ArrayLike,
        mass: float,
        position: ArrayLike,
        orientation: ArrayLike,
        restitution: float,
        friction: float,
    ) -> int:
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=0.5 * np.asarray(size, float), physicsClientId=self.client
        )
        body = pybullet.createMultiBody(
            mass, shape, -1, position, np.roll(orientation, -1), useMaximalCoordinates=1, physicsClientId=self.client
        )
        pybullet.changeDynamics(
            body,
            -1,
            linearDamping=0.0,
            angularDamping=0.0,
            restitution=restitution,
            lateralFriction=friction,
            activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING,
            physicsClientId=self.client,
        )
        return body

    def step(self, steps: int = 1) -> None:
        """Advance by `steps` steps."""
        for _ in range(steps):
            pybullet.stepSimulation(self.client)

    def positions(self) -> np.ndarray:
        """Return the centres (m, 3) [m]."""
        return np.array([pybullet.getBasePositionAndOrientation(box, self.client)[0] for box in self.boxes])

    def velocities(self) -> np.ndarray:
        """Return v and ω (m, 6)."""
        return np.array([np.concatenate(pybullet.getBaseVelocity(box, self.client)) for box in self.boxes])

    def deepest(self) -> tuple[float, float]:
        """Return how deep [m] boxes are inside each other, and in the ground, at the worst contact of the last step."""
        inside = below = 0.0
        for contact in pybullet.getContactPoints(physicsClientId=self.client):
            if GROUND in contact[1:3]:
                below = max(below, -contact[8])
            else:
                inside = max(inside, -contact[8])
        return inside, below

    def loads(self) -> np.ndarray:
        """Return the force (m + 1, m + 1) [N], along the normal, of box i, or the ground (0), on box j, last step."""
        force = np.zeros((len(self.boxes) + 1,) * 2)
        number = {GROUND: 0} | {box: k + 1 for k, box in enumerate(self.boxes)}
        for contact in pybullet.getContactPoints(physicsClientId=self.client):
            a, b = number[contact[1]], number[contact[2]]
            force[a, b] += contact[9]
            force[b, a] += contact[9]
        return force

    def remove(self, box: int) -> None:
        """Take a box away, by its number now; those after it are one number lower then."""
        pybullet.removeBody(self.boxes.pop(box), physicsClientId=self.client)

    def save(self) -> int:
        """Remember where everything is; return what `restore` takes."""
        return int(pybullet.saveState(physicsClientId=self.client))

    def restore(self, saved: int) -> None:
        """Put everything back to where it was then."""
        pybullet.restoreState(saved, physicsClientId=self.client)

    def close(self) -> None:
        """Disconnect."""
        pybullet.disconnect(self.client)


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
    """Return v and ω (m, 6) of m smooth boxes without weight after so many steps; arguments of references.rapier's.

    Bullet's boxes touch when they overlap at the end of a step, and not before.
    """
    arrays = [np.asarray(x, float) for x in (size, mass, position, orientation, velocity, spin)]
    world = BulletWorld(step, 50, restitution, friction=0.0, gravity=0.0)
    try:
        for box_size, kilogram, *motion in zip(*arrays):
            world.add_box(box_size, 0.0 if np.isinf(kilogram) else kilogram, *motion)
        world.step(steps)
        return world.velocities()
    finally:
        world.close()


def closest(
    size_a: ArrayLike,
    position_a: ArrayLike,
    orientation_a: ArrayLike,
    size_b: ArrayLike,
    position_b: ArrayLike,
    orientation_b: ArrayLike,
) -> tuple[np.ndarray, np.ndarray]:
    """Return (distance (m,) [m], normal (m, 3) from b to a) of m overlapping pairs, by Bullet's getClosestPoints.

    A negative distance is the least depth; margins are set to 0 (the default adds 5e-4 m). Arrays as in references.fcl.
    """
    arrays = [np.asarray(x, float) for x in (size_a, position_a, orientation_a, size_b, position_b, orientation_b)]
    distance, normal = np.full(len(arrays[0]), np.nan), np.full((len(arrays[0]), 3), np.nan)
    client = pybullet.connect(pybullet.DIRECT)
    try:
        for i, row in enumerate(zip(*arrays)):
            if i % 100 == 0:
                pybullet.resetSimulation(physicsClientId=client)
            ids = []
            for size, position, orientation in (row[:3], row[3:]):
                shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=0.5 * size, physicsClientId=client)
                body = pybullet.createMultiBody(
                    0.0, shape, -1, position, np.roll(orientation, -1), physicsClientId=client
                )
                pybullet.changeDynamics(body, -1, collisionMargin=0.0, physicsClientId=client)
                ids.append(body)
            found = pybullet.getClosestPoints(*ids, 0.0, physicsClientId=client)
            if found:
                deepest = min(found, key=lambda c: c[8])
                distance[i], normal[i] = deepest[8], deepest[7]
            for body in ids:
                pybullet.removeBody(body, physicsClientId=client)
    finally:
        pybullet.disconnect(client)
    return distance, normal
