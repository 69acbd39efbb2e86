"""Closed forms: volumes, inertia, equilibria, one impact, and one step of each integrator.

numpy only; nothing here is iterated or fitted. Each function names where its formula comes from.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike


class Velocities(NamedTuple):
    """The velocities of both bodies of m impacts, after the impact."""

    velocity_a: np.ndarray  # (m, 3) [m/s]
    angular_velocity_a: np.ndarray  # (m, 3) [rad/s], world frame
    velocity_b: np.ndarray  # (m, 3) [m/s]
    angular_velocity_b: np.ndarray  # (m, 3) [rad/s], world frame


def box_volume(size: ArrayLike) -> np.ndarray:
    """Return the volume [m³] of boxes of full extents `size` (..., 3) [m]."""
    return np.prod(np.asarray(size, float), axis=-1)


def box_inertia(size: ArrayLike, mass: ArrayLike) -> np.ndarray:
    """Return the diagonal (..., 3) [kg m²] m/12 (y²+z², x²+z², x²+y²) of boxes of `size` (..., 3), `mass` (...)."""
    x, y, z = np.moveaxis(np.asarray(size, float) ** 2, -1, 0)
    return np.asarray(mass, float)[..., None] / 12.0 * np.stack([y + z, x + z, x + y], axis=-1)


def regular_solid_volume(name: str, radius: float) -> float:
    """Return the volume [m³] of a "tetrahedron", "octahedron" or "icosahedron" of circumradius `radius` [m].

    With edge s: s³/(6√2), s = √(8/3) R; √2 s³/3, s = √2 R; 5 (3+√5) s³/12, s = R / sin(2π/5) (Coxeter 1973).
    """
    unit_volume = {
        "tetrahedron": 8.0 * np.sqrt(3.0) / 27.0,
        "octahedron": 4.0 / 3.0,
        "icosahedron": 2.0 / 3.0 * np.sqrt(10.0 + 2.0 * np.sqrt(5.0)),
    }
    return float(unit_volume[name] * radius**3)


def faceted_torus_volume(R: float, r: float, nu: int, nv: int) -> float:
    """Return the volume [m³] of a torus of `nu` straight segments whose cross-section is a regular `nv`-gon.

    Corner (i, j) at ((R + r cos 2πj/nv) (cos, sin) 2πi/nu, r sin 2πj/nv). Between two neighbouring half-planes
    the solid is a wedge |t| ≤ s tan(π/nu), s = ρ cos(π/nu): V = nu sin(2π/nu) ∫∫ ρ dρ dz, and ∫∫ ρ = R × area.
    """
    area = 0.5 * nv * r**2 * np.sin(2.0 * np.pi / nv)
    return float(nu * np.sin(2.0 * np.pi / nu) * R * area)


def faceted_torus_area(R: float, r: float, nu: int, nv: int) -> float:
    """Return the area [m²] of the surface of `faceted_torus_volume`.

    Between corners j and j + 1 it has `nu` trapezoids, of parallel sides 2 ρ sin(π/nu), the distance between which is
    that of (ρ cos(π/nu), z) at their ends.
    """
    v = 2.0 * np.pi * np.arange(nv + 1) / nv
    rho, z, half = R + r * np.cos(v), r * np.sin(v), np.pi / nu
    apart = np.hypot(np.diff(rho) * np.cos(half), np.diff(z))
    return float(nu * np.sin(half) * ((rho[1:] + rho[:-1]) * apart).sum())


def faceted_torus_inertia(R: float, r: float, nu: int, nv: int, mass: float) -> np.ndarray:
    """Return the diagonal (3,) [kg m²] about the centre of the homogeneous solid of `faceted_torus_volume`.

    In the same wedge ∫ (s² + t²) dt = 2 s³ tan (1 + tan²/3), so that Izz/m = (cos² + sin²/3)(π/nu) ⟨ρ³⟩/R with
    ⟨ρ³⟩/R = R² + 3 q, where q = ⟨z²⟩ = r² (2 + cos 2π/nv)/12 is the second moment of the polygon; then
    Ixx = Iyy = Izz/2 + m q. `nv` ≥ 4: the third moment of a triangle does not vanish. `nu` ≥ 3.
    """
    if nv < 4 or nu < 3:
        raise ValueError(f"segments are {nu} × {nv}; the closed form holds from 3 × 4 on")
    q = r**2 * (2.0 + np.cos(2.0 * np.pi / nv)) / 12.0
    half = np.pi / nu
    izz = mass * (np.cos(half) ** 2 + np.sin(half) ** 2 / 3.0) * (R**2 + 3.0 * q)
    ixx = 0.5 * izz + mass * q
    return np.array([ixx, ixx, izz])


def equilibrium_scale(gas: ArrayLike, stiffness_rest_squared: ArrayLike) -> np.ndarray:
    """Return λ, the size at rest of a triangulated regular solid over that at its rest lengths.

    The positive root of λ² − λ = 3nRT/(k Σ l0²), with `gas` nRT [J] and `stiffness_rest_squared` k Σ l0² [J].
    """
    return 0.5 + np.sqrt(0.25 + 3.0 * np.asarray(gas, float) / np.asarray(stiffness_rest_squared, float))


def rotation_matrix(orientation: ArrayLike) -> np.ndarray:
    """Return the matrices (..., 3, 3), body to world, of quaternions (..., 4) (w, x, y, z), normalised here."""
    q = np.asarray(orientation, float)
    w, x, y, z = np.moveaxis(q / np.linalg.norm(q, axis=-1, keepdims=True), -1, 0)
    rows = [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def box_impact(
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
    point: ArrayLike,
    normal: ArrayLike,
    restitution: ArrayLike,
) -> Velocities:
    """Return the velocities after m frictionless impacts of two boxes at one point each.

    Sizes (m, 3) full extents [m], masses (m,) [kg] or np.inf for a static box, positions (m, 3) [m], orientations
    (m, 4), velocities (m, 3) [m/s] and [rad/s], `point` (m, 3) [m], unit `normal` (m, 3) from b to a, `restitution`
    (m,) or a number. Newton's law u'·n = −e u·n for the points that touch (Baraff 1989); no impulse if they part.
    """
    v_a, w_a, v_b, w_b = (
        np.asarray(v, float) for v in (velocity_a, angular_velocity_a, velocity_b, angular_velocity_b)
    )
    m_a, m_b = np.asarray(mass_a, float)[..., None], np.asarray(mass_b, float)[..., None]
    n = np.asarray(normal, float)
    r_a, r_b = np.asarray(point, float) - position_a, np.asarray(point, float) - position_b
    twist_a = _turn(size_a, orientation_a, np.cross(r_a, n)) / m_a
    twist_b = _turn(size_b, orientation_b, np.cross(r_b, n)) / m_b
    speed = _dot(v_a + np.cross(w_a, r_a) - v_b - np.cross(w_b, r_b), n)
    give = 1.0 / m_a + 1.0 / m_b + _dot(np.cross(twist_a, r_a) + np.cross(twist_b, r_b), n)
    wanted = -(1.0 + np.asarray(restitution, float)[..., None]) * speed
    j = np.divide(wanted, give, out=np.zeros(np.shape(wanted + give)), where=(speed < 0.0) & (give > 0.0))
    return Velocities(v_a + j * n / m_a, w_a + j * twist_a, v_b - j * n / m_b, w_b - j * twist_b)


def passing_overlap(
    size_a: ArrayLike,
    orientation_a: ArrayLike,
    size_b: ArrayLike,
    orientation_b: ArrayLike,
    offset: ArrayLike,
    direction: ArrayLike,
) -> np.ndarray:
    """Return by how much (n,) [m] two boxes overlap, seen along the direction in which a moves past b without turning.

    Sizes (n, 3) [m], orientations (n, 4) unit quaternions, `offset` (n, 3) [m] from b to a, at any time, `direction`
    (n, 3). They meet if it is positive; if negative, they pass with at least as much air. Seen so, a box is a polygon
    whose sides are its projected edges, and convex polygons are apart if they are across one of their sides.
    """
    direction, offset = np.asarray(direction, float), np.asarray(offset, float)
    frames = rotation_matrix(orientation_a), rotation_matrix(orientation_b)
    edges = np.concatenate([np.swapaxes(frame, 1, 2) for frame in frames], axis=1)
    across = np.cross(direction[:, None, :], edges)
    length = np.linalg.norm(across, axis=2)
    normals = across / np.where(length > 0.0, length, 1.0)[:, :, None]
    reach = np.zeros(length.shape)
    for size, frame in zip((size_a, size_b), frames, strict=True):
        reach += 0.5 * np.einsum(
            "nk,nsk->ns", np.asarray(size, float), np.abs(np.einsum("nsc,nck->nsk", normals, frame))
        )
    overlap = reach - np.abs(np.einsum("nsc,nc->ns", normals, offset))
    # An edge along the direction is seen as a point, and no side.
    speed = np.linalg.norm(direction, axis=1, keepdims=True)
    return np.asarray(np.min(np.where(length > 1e-9 * speed, overlap, np.inf), axis=1))


def _turn(size: ArrayLike, orientation: ArrayLike, torque: np.ndarray) -> np.ndarray:
    """Return ω [rad/s] (m, 3) that the angular impulse `torque` (m, 3) gives a box of mass 1: solve (R I Rᵀ) ω = τ."""
    R = rotation_matrix(orientation)
    inertia = R @ (box_inertia(size, 1.0)[..., None] * np.swapaxes(R, -1, -2))
    return np.linalg.solve(inertia, torque[..., None])[..., 0]


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.sum(a * b, axis=-1, keepdims=True)


def amplification_matrix(integrator: str, z: ArrayLike) -> np.ndarray:
    """Return the matrix (..., 2, 2) of one step h on x'' = −ω² x, acting on (x, v/ω), with `z` (...) = ω h.

    Derived by hand. "rk4_velocity": the stages are x1 = (1 − z²/4) x + z/2 y, x2 = (1 − z²/4 + z⁴/16) x +
    (z/2 − z³/8) y and x3 = (1 − z² + z⁴/4 − z⁶/16) x + (z − z³/2 + z⁵/8) y; then y' = y − z/6 (x + 2 x1 + 2 x2 + x3)
    = −p x + q y and x' = x + z y'. Its determinant is q = 1 − z²/2 + …: it loses z²/4 of the amplitude a step; p = 0
    at z = 2, where it stops being stable. "rk4" is the Taylor series of a rotation by z, cut after z⁴.
    "symplectic_euler" is y' = y − z x, x' = x + z y', of determinant 1.
    """
    z = np.asarray(z, float)
    if integrator == "rk4_velocity":
        p = z - z**3 / 3.0 + z**5 / 16.0 - z**7 / 96.0
        q = 1.0 - z**2 / 2.0 + z**4 / 8.0 - z**6 / 48.0
        entries = 1.0 - z * p, z * q, -p, q
    elif integrator == "rk4":
        cosine, sine = 1.0 - z**2 / 2.0 + z**4 / 24.0, z - z**3 / 6.0
        entries = cosine, sine, -sine, cosine
    elif integrator == "symplectic_euler":
        entries = 1.0 - z**2, z, -z, np.ones_like(z)
    else:
        raise ValueError(f"integrator {integrator!r} has no closed form here")
    return np.stack(entries, axis=-1).reshape(*z.shape, 2, 2)


def spectral_radius(matrix: np.ndarray) -> np.ndarray:
    """Return the largest |eigenvalue| (...) of matrices (..., k, k): above 1, the repeated step is unstable."""
    return np.max(np.abs(np.linalg.eigvals(matrix)), axis=-1)


def leading_error(integrator: str, t: ArrayLike) -> np.ndarray:
    """Return lim (x_h(t) − cos t)/h^p (...) for x'' = −x from x = 1 at rest, where p is the order of the integrator.

    From the modified equation y' = (J + h^p B) y, with J the rotation: the error is ∫ e^(J(t−s)) B e^(Js) y0 ds. The
    matrices of `amplification_matrix` have B = −diag(1, 0)/2, −J/120 and diag(−1, 1)/2.
    """
    t = np.asarray(t, float)
    closed_forms = {
        "rk4_velocity": -(t * np.cos(t) + np.sin(t)) / 4.0,
        "rk4": t * np.sin(t) / 120.0,
        "symplectic_euler": -np.sin(t) / 2.0,
    }
    return closed_forms[integrator]


def breathing_frequency(gas: ArrayLike, stiffness_rest_squared: ArrayLike, inertia: ArrayLike) -> np.ndarray:
    """Return ω [rad/s] of small symmetric oscillations of a triangulated regular solid about its rest.

    ω² = E''(λ*)/M with E = K (λ − 1)²/2 − 3nRT ln λ: `gas` nRT [J], K = k Σ l0² [J], `inertia` M = Σ m |x|² [kg m²].
    """
    scale = equilibrium_scale(gas, stiffness_rest_squared)
    return np.sqrt((np.asarray(stiffness_rest_squared) + 3.0 * np.asarray(gas) / scale**2) / np.asarray(inertia))


def critical_damping(stiffness: ArrayLike, mass: ArrayLike) -> np.ndarray:
    """Return the damping [N s/m] at which two particles of `mass` [kg] on a spring [N/m] just do not swing.

    Of their distance d, with the reduced mass μ = m/2: μ d'' + c d' + k d = 0, whose roots meet at c = 2 √(k μ).
    """
    return 2.0 * np.sqrt(np.asarray(stiffness, float) * 0.5 * np.asarray(mass, float))


def damped_oscillation(t: ArrayLike, frequency: ArrayLike, rate: ArrayLike) -> np.ndarray:
    """Return x(t) (...) of x'' = −ω² x − γ x' from x = 1 at rest, for γ = `rate` < 2 ω [1/s]."""
    t, half = np.asarray(t, float), 0.5 * np.asarray(rate, float)
    w = np.sqrt(np.asarray(frequency, float) ** 2 - half**2)
    return np.exp(-half * t) * (np.cos(w * t) + half / w * np.sin(w * t))


def particle_impact(
    size: ArrayLike,
    mass: ArrayLike,
    position: ArrayLike,
    orientation: ArrayLike,
    velocity: ArrayLike,
    angular_velocity: ArrayLike,
    particle_mass: ArrayLike,
    point: ArrayLike,
    particle_velocity: ArrayLike,
    normal: ArrayLike,
    restitution: ArrayLike,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return v and ω of m boxes and v of the particles that strike them at `point` (m, 3) [m], all (m, 3).

    `normal` (m, 3) unit, from the box to the particle. Effective mass 1/m_p + 1/M + n·[(I⁻¹(r×n))×r]; no friction.
    """
    v, w, u, n = (np.asarray(x, float) for x in (velocity, angular_velocity, particle_velocity, normal))
    box, particle = np.asarray(mass, float)[..., None], np.asarray(particle_mass, float)[..., None]
    arm = np.asarray(point, float) - position
    twist = _turn(size, orientation, np.cross(arm, n)) / box
    speed = _dot(u - v - np.cross(w, arm), n)
    give = 1.0 / box + 1.0 / particle + _dot(np.cross(twist, arm), n)
    j = np.where(speed < 0.0, -(1.0 + np.asarray(restitution, float)[..., None]) * speed, 0.0) / give
    return v - j * n / box, w - j * twist, u + j * n / particle
