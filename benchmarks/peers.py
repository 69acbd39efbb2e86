"""The same step as others would write it: in NumPy, with a SciPy matrix, and another engine's soft body."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from softbody import Mesh, icosphere, torus

STIFFNESS, GAS, MASS, GRAVITY = 200.0, 30.0, 1.0, -9.81

Forces = Callable[[np.ndarray], np.ndarray]


def numpy_forces(mesh: Mesh, add: Callable[[np.ndarray, np.ndarray, np.ndarray], None]) -> Forces:
    """Return springs and gas on all vertices, with `add` to scatter rows: add(force, indices, rows)."""
    i, j = mesh.edges.T
    a, b, c = mesh.triangles.T
    rest = np.linalg.norm(mesh.vertices[j] - mesh.vertices[i], axis=1)

    def forces(x: np.ndarray) -> np.ndarray:
        force = np.zeros_like(x)
        d = x[j] - x[i]
        length = np.sqrt((d * d).sum(axis=1))
        pull = (STIFFNESS * (length - rest) / length)[:, None] * d
        add(force, i, pull)
        add(force, j, -pull)
        xa, xb, xc = x[a], x[b], x[c]
        volume = (xa * np.cross(xb, xc)).sum() / 6.0
        push = GAS / volume / 6.0 * np.cross(xb - xa, xc - xa)
        for corner in (a, b, c):
            add(force, corner, push)
        return force

    return forces


def add_at(force: np.ndarray, indices: np.ndarray, rows: np.ndarray) -> None:
    """Scatter with np.add.at."""
    np.add.at(force, indices, rows)


def add_bincount(force: np.ndarray, indices: np.ndarray, rows: np.ndarray) -> None:
    """Scatter with np.bincount, component by component."""
    for k in range(3):
        force[:, k] += np.bincount(indices, rows[:, k], len(force))


def sparse_forces(mesh: Mesh) -> Forces:
    """Return springs and gas with SciPy's sparse incidence matrices in place of scattering."""
    import scipy.sparse

    i, j = mesh.edges.T
    n, e, t = len(mesh.vertices), len(i), len(mesh.triangles)
    one, rows = np.ones(e), np.arange(e)
    edges = scipy.sparse.csr_matrix(
        (np.concatenate([one, -one]), (np.concatenate([rows, rows]), np.concatenate([j, i]))), (e, n)
    )
    onto = (-edges.T).tocsr()
    corners = scipy.sparse.csr_matrix((np.ones(3 * t), (mesh.triangles.ravel(), np.repeat(np.arange(t), 3))), (n, t))
    a, b, c = mesh.triangles.T
    rest = np.linalg.norm(mesh.vertices[j] - mesh.vertices[i], axis=1)

    def cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        # np.cross spends most of its time on moving axes about.
        return np.stack(
            [
                u[:, 1] * v[:, 2] - u[:, 2] * v[:, 1],
                u[:, 2] * v[:, 0] - u[:, 0] * v[:, 2],
                u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0],
            ],
            axis=1,
        )

    def forces(x: np.ndarray) -> np.ndarray:
        d = edges @ x
        length = np.sqrt(np.einsum("ek,ek->e", d, d))
        xa, xb, xc = x[a], x[b], x[c]
        turn = cross(xb - xa, xc - xa)
        volume = np.einsum("tk,tk->", xa, turn) / 6.0
        return onto @ ((STIFFNESS * (length - rest) / length)[:, None] * d) + GAS / volume / 6.0 * (corners @ turn)

    return forces


def stepping(mesh: Mesh, forces: Forces, h: float, steps: int) -> Callable[[], None]:
    """Return a call that steps the mesh `steps` times by `h` [s] with the paper's integrator."""
    x, v = mesh.vertices.copy(), np.zeros_like(mesh.vertices)
    inverse_mass, g = len(x) / MASS, np.array([0.0, 0.0, GRAVITY])

    def call() -> None:
        nonlocal x, v
        for _ in range(steps):
            a0 = forces(x) * inverse_mass + g
            a1 = forces(x + 0.5 * h * (v + 0.5 * h * a0)) * inverse_mass + g
            a2 = forces(x + 0.5 * h * (v + 0.5 * h * a1)) * inverse_mass + g
            a3 = forces(x + h * (v + h * a2)) * inverse_mass + g
            v = v + h / 6.0 * (a0 + 2.0 * a1 + 2.0 * a2 + a3)
            x = x + h * v

    return call


def pybullet_stepping(mesh: Mesh, h: float, steps: int) -> Callable[[], None]:
    """Return a call that steps pybullet's mass–spring body on the same mesh: no gas, one force a step, float64."""
    client = _pybullet_world(h)
    _pybullet_body(client, mesh, MASS, STIFFNESS)
    return _pybullet_steps(client, steps)


def pybullet_sphere_on_torus(h: float, steps: int) -> Callable[[], None]:
    """Return a call that steps scene 1 in pybullet: the same meshes, masses, springs and places, but no gas."""
    import pybullet

    client = _pybullet_world(h)
    ground = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=(20.0, 20.0, 1.0), physicsClientId=client)
    pybullet.createMultiBody(0.0, ground, basePosition=(0.0, 0.0, -1.0), physicsClientId=client)
    contacts = {"useFaceContact": 1, "collisionMargin": 0.005}
    _pybullet_body(client, torus(1.0, 0.4, 36, 18), 2.0, 400.0, basePosition=(0.0, 0.0, 0.45), **contacts)
    _pybullet_body(client, icosphere(3, 0.9), 1.0, 300.0, basePosition=(0.0, 0.0, 1.7), **contacts)
    return _pybullet_steps(client, steps)


def _pybullet_world(h: float) -> int:
    """Return a client of pybullet whose world has soft bodies."""
    import pybullet

    client: int = pybullet.connect(pybullet.DIRECT)
    pybullet.resetSimulation(pybullet.RESET_USE_DEFORMABLE_WORLD, physicsClientId=client)
    pybullet.setGravity(0.0, 0.0, GRAVITY, physicsClientId=client)
    pybullet.setTimeStep(h, physicsClientId=client)
    return client


def _pybullet_body(client: int, mesh: Mesh, mass: float, stiffness: float, **options: Any) -> None:
    """Add a mass–spring body to pybullet's world."""
    import pybullet

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mesh.obj"
        lines = [f"v {x} {y} {z}\n" for x, y, z in mesh.vertices]
        lines += [f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in mesh.triangles]
        path.write_text("".join(lines))
        pybullet.loadSoftBody(
            str(path),
            mass=mass,
            useMassSpring=1,
            useBendingSprings=0,
            springElasticStiffness=stiffness,
            springDampingStiffness=0.0,
            useSelfCollision=0,
            physicsClientId=client,
            **options,
        )


def _pybullet_steps(client: int, steps: int) -> Callable[[], None]:
    import pybullet

    def call() -> None:
        for _ in range(steps):
            pybullet.stepSimulation(physicsClientId=client)

    return call
