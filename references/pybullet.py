"""One impact of two boxes by Bullet (pybullet 3.2.7, double precision).

The boxes are created at the contact pose, given their velocities, and stepped once. Played normally (defaults, 1/240 s)
the same impacts differ by a quarter of their speed.

An overlap of depth 0 mostly gives no contact: ask for 1e-12 m or more. The *depth* of an edge across an edge is not to
be trusted, nor is it used by the impact: the box–box code, which is ODE's, adds 1e-5 to every cosine, and so overstates
that depth by some 3e-5 m (7e-4 m at worst of 2000) at sizes near 1 m. A corner's depth is exact.
"""

from __future__ import annotations

import ctypes
import os
import sys
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

PACKAGES = {"pybullet": "pybullet"}  # import name, and the name to install it by
KIND = "third-party engine"  # of judge
SETTINGS = {  # what was chosen against the defaults, and why
    "time step 1e-13 s": (
        "Bullet always adds the gyroscopic torque, an error of |ω|² × step; at 1e-16 s it answers NaN"
    ),
    "gravity 0": "it would act within the step",
    "contactERP, erp, contactSlop 0": (
        "they push bodies apart at a speed of depth / step, which here would be 1e10 m/s"
    ),
    "restitutionVelocityThreshold 0": "below 0.2 m/s Bullet drops the restitution",
    "solverResidualThreshold 0, numSolverIterations 2000": (
        "the default stops the solver at a squared residual of 1e-7"
    ),
    "useSplitImpulse 0, numSubSteps 0, globalCFM 0, enableConeFriction 0": "nothing but the one plain solve",
    "deterministicOverlappingPairs 1": "the same bits twice",
    "linearDamping, angularDamping 0 (0.04), friction of all kinds 0 (0.5 lateral)": (
        "a free impact loses nothing to them"
    ),
    "restitution e on a and 1 on b": "Bullet multiplies them, and its default is 0",
    "collisionMargin 0": "no effect was seen on these contacts",
    "maxJointVelocity 1e9": "the default clamps to ±100",
    "bodies are created anew for every trial": "one that is moved keeps its old world inertia until it steps",
}


def _import_silently() -> None:
    """Import pybullet while output and errors go to the null device: it greets with a line, on either by version.

    C prints the line, and keeps a buffer of its own, which is flushed before the descriptors are given back.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    null = os.open(os.devnull, os.O_WRONLY)
    saved = {stream: os.dup(stream) for stream in (1, 2)}
    try:
        for stream in saved:
            os.dup2(null, stream)
        import pybullet  # noqa: F401

        ctypes.CDLL(None).fflush(None)
    finally:
        for stream, copy in saved.items():
            os.dup2(copy, stream)
            os.close(copy)
        os.close(null)


_import_silently()

import pybullet  # noqa: E402

STEP = 1e-13  # [s]
ITERATIONS = 2000


class Manifold(NamedTuple):
    """All contacts of one trial, k of them, in Bullet's order (at most 4 survive of a face–face overlap)."""

    point_a: np.ndarray  # (k, 3) [m] on the surface of a
    point_b: np.ndarray  # (k, 3) [m] on the surface of b
    normal: np.ndarray  # (k, 3) unit, from b to a
    depth: np.ndarray  # (k,) [m], positive where the boxes overlap
    impulse: np.ndarray  # (k,) [N s] along the normal


@dataclass(frozen=True, eq=False)
class Impacts:
    """What Bullet made of m trials. A trial without exactly one contact has NaN for point, normal and depth."""

    count: np.ndarray  # (m,) contacts of each trial
    point: np.ndarray  # (m, 3) [m] half-way between the two surfaces
    normal: np.ndarray  # (m, 3) unit, from b to a
    depth: np.ndarray  # (m,) [m]
    velocity_a: np.ndarray  # (m, 3) [m/s] after the impact, as are the next three
    angular_velocity_a: np.ndarray  # (m, 3) [rad/s], world frame
    velocity_b: np.ndarray  # (m, 3) [m/s]
    angular_velocity_b: np.ndarray  # (m, 3) [rad/s], world frame
    manifolds: list[Manifold]  # all contacts of each trial


def one_impact(
    size_a: ArrayLike,
    mass_a: ArrayLike,
    position_a: ArrayLike,
    orientation_a: ArrayLike,
    velocity_a: ArrayLike,
    angular_velocity_a: ArrayLike,
    size_b: ArrayLike,
    mass_b: ArrayLike,
    position_b: ArrayLike,
    orientation_b: ArrayLike,
    velocity_b: ArrayLike,
    angular_velocity_b: ArrayLike,
    restitution: ArrayLike,
    maximal_coordinates: bool = False,
) -> Impacts:
    """Return what Bullet makes of m impacts, each of two boxes that overlap a little (1e-9 … 1e-3 m).

    Sizes (m, 3) full extents [m], masses (m,) [kg] or np.inf for a static box, positions (m, 3) [m], orientations
    (m, 4) unit quaternions (w, x, y, z), velocities (m, 3) [m/s] and [rad/s] before the impact, `restitution` (m,) or
    a number. `maximal_coordinates` takes Bullet's plain rigid bodies instead of its articulated ones.
    """
    a = [np.asarray(x, float) for x in (size_a, mass_a, position_a, orientation_a, velocity_a, angular_velocity_a)]
    b = [np.asarray(x, float) for x in (size_b, mass_b, position_b, orientation_b, velocity_b, angular_velocity_b)]
    m = len(a[0])
    e = np.broadcast_to(np.asarray(restitution, float), (m,))
    single = np.full((m, 7), np.nan)
    after = np.empty((m, 12))
    manifolds = []
    client = pybullet.connect(pybullet.DIRECT)
    try:
        for i in range(m):
            _empty_world(client)
            body_a = _add_box(client, [x[i] for x in a], e[i], maximal_coordinates)
            body_b = _add_box(client, [x[i] for x in b], 1.0, maximal_coordinates)
            pybullet.stepSimulation(client)
            manifold = _contacts(client, body_a, body_b)
            if len(manifold.depth) == 1:
                middle = 0.5 * (manifold.point_a[0] + manifold.point_b[0])
                single[i] = [*middle, *manifold.normal[0], manifold.depth[0]]
            manifolds.append(manifold)
            after[i] = np.concatenate(
                [*pybullet.getBaseVelocity(body_a, client), *pybullet.getBaseVelocity(body_b, client)]
            )
    finally:
        pybullet.disconnect(client)
    count = np.array([len(manifold.depth) for manifold in manifolds], dtype=np.int64)
    v_a, w_a, v_b, w_b = np.split(after, 4, axis=1)
    return Impacts(count, single[:, :3], single[:, 3:6], single[:, 6], v_a, w_a, v_b, w_b, manifolds)


def _empty_world(client: int) -> None:
    pybullet.resetSimulation(physicsClientId=client)
    pybullet.setGravity(0.0, 0.0, 0.0, physicsClientId=client)
    pybullet.setPhysicsEngineParameter(
        numSolverIterations=ITERATIONS,
        solverResidualThreshold=0.0,
        contactERP=0.0,
        erp=0.0,
        globalCFM=0.0,
        contactSlop=0.0,
        restitutionVelocityThreshold=0.0,
        useSplitImpulse=0,
        numSubSteps=0,
        enableConeFriction=0,
        deterministicOverlappingPairs=1,
        physicsClientId=client,
    )
    pybullet.setTimeStep(STEP, physicsClientId=client)


def _add_box(client: int, box: list[np.ndarray], restitution: float, maximal_coordinates: bool) -> int:
    size, mass, position, orientation, velocity, angular_velocity = box
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=0.5 * size, physicsClientId=client)
    body = pybullet.createMultiBody(
        baseMass=mass if np.isfinite(mass) else 0.0,
        baseCollisionShapeIndex=shape,
        basePosition=position,
        baseOrientation=np.roll(orientation, -1),  # Bullet writes (x, y, z, w)
        useMaximalCoordinates=int(maximal_coordinates),
        physicsClientId=client,
    )
    pybullet.changeDynamics(
        body,
        -1,
        linearDamping=0.0,
        angularDamping=0.0,
        lateralFriction=0.0,
        rollingFriction=0.0,
        spinningFriction=0.0,
        restitution=restitution,
        collisionMargin=0.0,
        maxJointVelocity=1e9,
        physicsClientId=client,
    )
    pybullet.resetBaseVelocity(body, velocity, angular_velocity, physicsClientId=client)
    return body


def _contacts(client: int, body_a: int, body_b: int) -> Manifold:
    contacts = pybullet.getContactPoints(body_a, body_b, physicsClientId=client)
    rows = [(c[5], c[6], c[7], -c[8], c[9] * STEP) for c in contacts]
    if any(c[1] != body_a for c in contacts):
        raise RuntimeError("Bullet swapped the bodies of a contact; normals would point from a to b")
    columns = zip(*rows) if rows else [[]] * 5
    shapes = [(-1, 3)] * 3 + [(-1,)] * 2
    return Manifold(*(np.array(list(column), float).reshape(shape) for column, shape in zip(columns, shapes)))
