"""Bags full of a liquid, by its potential energy: skins of springs and gas are those of references.scipy."""

from __future__ import annotations

import numpy as np
import scipy.linalg
import scipy.optimize

from references import scipy as skins

SMALL = 1e-6  # [m] over which forces are differenced: Newton's method needs no more than some digits of them
ROUNDS = 4  # of it; the last ones change nothing


def centre(vertices: np.ndarray, triangles: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the volume [m³] within a closed mesh, and its centre (3,) [m], by tetrahedra about the mean vertex."""
    middle = vertices.mean(axis=0)
    a, b, c = (vertices[triangles[:, k]] - middle for k in range(3))
    six = np.einsum("ij,ij->i", a, np.cross(b, c))
    return float(six.sum() / 6.0), middle + six @ (a + b + c) / 4.0 / six.sum()


def weight_forces(vertices: np.ndarray, triangles: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return ∂(weight·centre)/∂x (n, 3) [N] of all `vertices` (n, 3) [m]; `weight` (3,) [N].

    The centre is S / V, with S = Σ (a·b×c) (a + b + c) / 24: both by the product rule.
    """
    x = vertices - vertices.mean(axis=0)
    volume, at = centre(x, triangles)
    corners = [x[triangles[:, k]] for k in range(3)]
    total = (sum(corners) @ weight)[:, None] / 24.0
    six = np.einsum("ij,ij->i", corners[0], np.cross(corners[1], corners[2]))[:, None]
    force = np.zeros_like(x)
    for k in range(3):
        turned = np.cross(corners[(k + 1) % 3], corners[(k + 2) % 3])
        along = (total - at @ weight / 6.0) * turned + six / 24.0 * weight
        np.add.at(force, triangles[:, k], along / volume)
    return force


def hanging(
    vertices: np.ndarray,
    springs: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray],
    gas: float,
    weights: tuple[np.ndarray, np.ndarray],
    sound: float,
    fixed: np.ndarray,
) -> np.ndarray:
    """Return where a bag rests (n, 3) [m], downhill from `vertices` (n, 3) [m], with some `fixed` (f,) in place.

    `springs`: edges, rest length [m], stiffness [N/m], triangles; `gas` nRT [J]; `weights` (3,) [N] of the skin, of
    which all vertices have the same, and of the liquid; `sound` is c² / g [m] of that, which has as much room as it
    needs in `vertices`. The minimum of springs, gas, both weights, and what it takes to press the liquid together.
    """
    triangles, (skin, liquid) = springs[3], weights
    room, modulus = centre(np.asarray(vertices, float), triangles)[0], sound * float(np.linalg.norm(liquid))
    free, whole = np.setdiff1d(np.arange(len(vertices)), fixed), np.array(vertices, float)

    def put(flat: np.ndarray) -> np.ndarray:
        whole[free] = flat.reshape(-1, 3)
        return whole

    def forces(flat: np.ndarray) -> np.ndarray:
        x = put(flat)
        on = skins.forces(x, *springs, gas) + skin / len(x) + weight_forces(x, triangles, liquid)
        lost = modulus * max(1.0 / centre(x, triangles)[0] - 1.0 / room, 0.0)
        on += lost * skins.pressure_gradient(x, triangles)
        return np.asarray(on[free].ravel())

    def energy(flat: np.ndarray) -> float:
        x = put(flat)
        volume, at = centre(x, triangles)
        if volume <= 0.0:
            return np.inf
        part = min(volume / room, 1.0)
        pressed = modulus * (part - 1.0 - float(np.log(part)))
        return skins.energy(x, *springs, gas) + pressed - float(skin @ x.mean(axis=0) + liquid @ at)

    options = {"ftol": 0.0, "gtol": 0.0, "maxiter": 20_000, "maxfun": 40_000, "maxcor": 30}
    found = scipy.optimize.minimize(
        energy, whole[free].ravel(), jac=lambda flat: -forces(flat), method="L-BFGS-B", options=options
    ).x
    for _ in range(ROUNDS):
        ways = SMALL * np.eye(len(found))
        hessian = np.array([forces(found - way) - forces(found + way) for way in ways]) / (2.0 * SMALL)
        found = found + scipy.linalg.solve(0.5 * (hessian + hessian.T), forces(found), assume_a="sym")
    return put(found).copy()
