"""The paper's formulas as printed, one function an erratum: each is wrong, and says how.

Not judges: the validation report puts them beside the right form to show that an erratum matters, and by how much.
The number E1 … E22 is that of the list of errata. Everything else in a formula is right, so that one error shows alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from references.analytic import Velocities, box_inertia, rotation_matrix

ENTRIES = 20_000  # point–triangle pairs at a time: 0.16 MB an array, which the processor's cache holds
SAME_SIZE = 1e-9  # relative; determinants that differ by less are "of the same size", E14
PARALLEL = 1e-8  # sine; edges nearer to parallel give no axis of their own, E12


def impact_both_plus(*case: Any, **named: Any) -> Velocities:
    """E1: both bodies gain +j n. Right: b gains −j n. Arguments of `analytic.box_impact`, as of all impacts here."""
    return _impact(*case, **named, sign_b=1.0)


def impact_without_spin(*case: Any, **named: Any) -> Velocities:
    """E2: the relative velocity is that of the centres of mass. Right: of the points that touch, v + ω × r."""
    return _impact(*case, **named, spin_counts=False)


def impact_inertia_last(*case: Any, **named: Any) -> Velocities:
    """E3: "n·I⁻¹·(r×n)×r" read as n · I⁻¹((r×n)×r). Right: n · [(I⁻¹(r×n)) × r]."""
    return _impact(*case, **named, inertia_last=True)


def impact_with_body_inertia(*case: Any, **named: Any) -> Velocities:
    """E17: the diagonal of the body frame used in the world, whatever the orientation. Right: R I⁻¹ Rᵀ."""
    return _impact(*case, **named, turned=False)


def _impact(
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
    *,
    sign_b: float = -1.0,
    spin_counts: bool = True,
    inertia_last: bool = False,
    turned: bool = True,
) -> Velocities:
    v_a, w_a, v_b, w_b, n = (
        np.asarray(x, float) for x in (velocity_a, angular_velocity_a, velocity_b, angular_velocity_b, normal)
    )
    inverse_a = 1.0 / np.asarray(mass_a, float)[..., None]
    inverse_b = 1.0 / np.asarray(mass_b, float)[..., None]
    r_a, r_b = np.asarray(point, float) - position_a, np.asarray(point, float) - position_b
    I_a = _inverse_inertia(size_a, orientation_a, turned) * inverse_a[..., None]
    I_b = _inverse_inertia(size_b, orientation_b, turned) * inverse_b[..., None]
    u = v_a - v_b
    if spin_counts:
        u = u + np.cross(w_a, r_a) - np.cross(w_b, r_b)
    speed = _dot(u, n)
    if inertia_last:
        bends = _apply(I_a, np.cross(np.cross(r_a, n), r_a)) + _apply(I_b, np.cross(np.cross(r_b, n), r_b))
    else:
        bends = np.cross(_apply(I_a, np.cross(r_a, n)), r_a) + np.cross(_apply(I_b, np.cross(r_b, n)), r_b)
    give = inverse_a + inverse_b + _dot(bends, n)
    wanted = -(1.0 + np.asarray(restitution, float)[..., None]) * speed
    j = np.divide(wanted, give, out=np.zeros(np.shape(wanted + give)), where=(speed < 0.0) & (give > 0.0)) * n
    return Velocities(
        v_a + j * inverse_a,
        w_a + _apply(I_a, np.cross(r_a, j)),
        v_b + sign_b * j * inverse_b,
        w_b + sign_b * _apply(I_b, np.cross(r_b, j)),
    )


def _inverse_inertia(size: ArrayLike, orientation: ArrayLike, turned: bool) -> np.ndarray:
    """Return I⁻¹ (m, 3, 3) [1/(kg m²)] of boxes of mass 1."""
    R = rotation_matrix(orientation)
    if not turned:
        R = np.broadcast_to(np.eye(3), R.shape)
    return R @ (np.swapaxes(R, -1, -2) / box_inertia(size, 1.0)[..., None])


def parity_by_z_difference(points: ArrayLike, vertices: ArrayLike, triangles: ArrayLike) -> np.ndarray:
    """E5: the +z ray meets a plane at t = (a_z − p_z)/n_z. Right: t = ((a − p)·n)/n_z.

    Tells for `points` (m, 3) [m] whether each is in the closed mesh `vertices` (n, 3) [m], `triangles` (t, 3): (m,) of
    bool. n is the unit normal, and the hit p + t ẑ is put to the paper's test of a point in a triangle, which is E16's.
    """
    parity = []
    for p, a, b, c, n in _pairs(points, vertices, triangles):
        t = _divide(a[..., 2] - p[..., 2], n[..., 2])
        hit = p + t[..., None] * np.array([0.0, 0.0, 1.0])
        parity.append(np.count_nonzero((t > 0.0) & point_in_triangle(hit, a, b, c), axis=1) % 2 == 1)
    return np.concatenate([np.empty(0, bool), *parity])


def parity_counting_every_hit(points: ArrayLike, vertices: ArrayLike, triangles: ArrayLike) -> np.ndarray:
    """E20: a hit on an edge or a vertex counts for every triangle there. Right: once. Arguments as above, t right."""
    parity = []
    for p, a, b, c, n in _pairs(points, vertices, triangles):
        t = _divide(np.sum((a - p) * n, axis=-1), n[..., 2])
        turns = [_turn_seen_from_above(x - p, y - p) for x, y in ((a, b), (b, c), (c, a))]
        above = (np.minimum.reduce(turns) >= 0.0) | (np.maximum.reduce(turns) <= 0.0)
        parity.append(np.count_nonzero((t > 0.0) & above, axis=1) % 2 == 1)
    return np.concatenate([np.empty(0, bool), *parity])


def _pairs(points: ArrayLike, vertices: ArrayLike, triangles: ArrayLike) -> Iterator[tuple[np.ndarray, ...]]:
    """Yield points (k, 1, 3) and, for all triangles, their corners and unit normals (1, t, 3), chunk by chunk."""
    points, corners = np.asarray(points, float), np.asarray(vertices, float)[np.asarray(triangles)]
    a, b, c = (corners[None, :, k] for k in range(3))
    n = np.cross(b - a, c - a)
    n = n / np.linalg.norm(n, axis=-1, keepdims=True)
    chunk = max(1, ENTRIES // len(corners))
    for start in range(0, len(points), chunk):
        yield points[start : start + chunk, None], a, b, c, n


def _divide(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a/b, and −1 (behind the ray's start) where b is 0: the ray does not cross that plane."""
    return np.divide(a, b, out=np.full(np.broadcast_shapes(a.shape, b.shape), -1.0), where=b != 0.0)


def _turn_seen_from_above(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def point_in_triangle(point: ArrayLike, t0: ArrayLike, t1: ArrayLike, t2: ArrayLike) -> np.ndarray:
    """E16: outside if and only if u·v < 0 or u·w < 0, with u = b×c, v = c×a, w = a×b and a = t0 − p, … (..., 3) [m].

    Right: u, v and w all along u + v + w, which is not zero. In the plane of the triangle the two differ only where
    u = 0: on the whole line through t1 and t2, and everywhere if t1 = t2.
    """
    p = np.asarray(point, float)
    a, b, c = np.asarray(t0, float) - p, np.asarray(t1, float) - p, np.asarray(t2, float) - p
    u, v, w = np.cross(b, c), np.cross(c, a), np.cross(a, b)
    return ~((np.sum(u * v, axis=-1) < 0.0) | (np.sum(u * w, axis=-1) < 0.0))


def volume_signed_twice(vertices: ArrayLike, triangles: ArrayLike) -> float:
    """E6: Σ a·(b×c)/6, each term signed again by a·n [m³]. Right: signed once. As a·n is that determinant: Σ |…|/6."""
    a, b, c = np.moveaxis(np.asarray(vertices, float)[np.asarray(triangles)], 1, 0)
    n = np.cross(b - a, c - a)
    return float(np.sum(np.sum(a * np.cross(b, c), axis=1) * np.sign(np.sum(a * n, axis=1))) / 6.0)


def box_inertia_other_order(size: ArrayLike, mass: ArrayLike) -> np.ndarray:
    """E7: the diagonal (..., 3) [kg m²] as m/12 (x²+z², y²+z², x²+y²). Right: (y²+z², x²+z², x²+y²)."""
    return box_inertia(size, mass)[..., [1, 0, 2]]


def mean_of_velocities(
    acceleration: Callable[[np.ndarray], np.ndarray], position: ArrayLike, velocity: ArrayLike, h: float
) -> tuple[np.ndarray, np.ndarray]:
    """E8: v' = v + (v0 + 2 v1 + 2 v2 + v3)/6 after a step `h` [s]: free motion doubles its speed every step.

    Right: the mean of the increments a_i h. `acceleration` maps positions [m] to [m/s²]. Returns (x', v').
    """
    x0, v0 = np.asarray(position, float), np.asarray(velocity, float)
    v1 = v0 + acceleration(x0) * h / 2.0
    v2 = v0 + acceleration(x0 + v1 * h / 2.0) * h / 2.0
    v3 = v0 + acceleration(x0 + v2 * h / 2.0) * h
    v = v0 + (v0 + 2.0 * v1 + 2.0 * v2 + v3) / 6.0
    return x0 + h * v, v


def moved_by_acceleration(
    position: ArrayLike, velocity: ArrayLike, acceleration: ArrayLike, h: float
) -> tuple[np.ndarray, np.ndarray]:
    """E10: v' = v + a h, then x' = x + a h, of the wrong dimension. Right: x' = x + v' h. Returns (x', v')."""
    a = np.asarray(acceleration, float)
    return np.asarray(position, float) + a * h, np.asarray(velocity, float) + a * h


def boxes_overlap_by_faces(*boxes: ArrayLike) -> np.ndarray:
    """E11: only the six face normals are tried: (m,) of bool. Right: all fifteen axes. Arguments as below."""
    return box_separation_by_faces(*boxes) <= 0.0


def box_separation_by_faces(*boxes: ArrayLike) -> np.ndarray:
    """E11: the largest separation (m,) [m] along the six face normals. Right: of all fifteen axes.

    `boxes`: size (m, 3) full extents [m], position (m, 3) [m] and orientation (m, 4) of a, then those of b.
    """
    _, low_a, high_a, low_b, high_b = _intervals(*boxes)
    return np.max(np.maximum(low_a - high_b, low_b - high_a)[:, :6], axis=1)


def box_separations_by_axis(*boxes: ArrayLike) -> np.ndarray:
    """Return the separation (m, 15) [m] along each axis, and not only the largest; −∞ for edges that are parallel."""
    axes, low_a, high_a, low_b, high_b = _intervals(*boxes)
    length = np.linalg.norm(axes, axis=-1)
    gap = np.maximum(low_a - high_b, low_b - high_a)
    return np.where(length < PARALLEL, -np.inf, gap / np.maximum(length, PARALLEL))


def boxes_overlap_one_way(*boxes: ArrayLike) -> np.ndarray:
    """E12: tell whether on each of the fifteen axes an end of a lies between the ends of b: (m,); arguments as above.

    Right: whether the intervals overlap, either way round; so a large a around a small b is missed.
    """
    axes, *intervals = _intervals(*boxes)
    parallel = np.linalg.norm(axes, axis=-1) < PARALLEL
    return np.all(intervals_overlap_one_way(*intervals) | parallel, axis=1)


def intervals_overlap_one_way(low_a: ArrayLike, high_a: ArrayLike, low_b: ArrayLike, high_b: ArrayLike) -> np.ndarray:
    """E12: "a point of one between two points of the other": an end of a between the ends of b. All (...) [m]."""
    low_a, high_a = np.asarray(low_a), np.asarray(high_a)
    return ((low_b <= low_a) & (low_a <= high_b)) | ((low_b <= high_a) & (high_a <= high_b))


def _intervals(
    size_a: ArrayLike,
    position_a: ArrayLike,
    orientation_a: ArrayLike,
    size_b: ArrayLike,
    position_b: ArrayLike,
    orientation_b: ArrayLike,
) -> tuple[np.ndarray, ...]:
    """Return the axes (m, 15, 3), faces of a, of b, then edges, and the ends (m, 15) of the shadows of a and of b."""
    x_a, x_b = np.swapaxes(rotation_matrix(orientation_a), 1, 2), np.swapaxes(rotation_matrix(orientation_b), 1, 2)
    edges = np.cross(x_a[:, :, None], x_b[:, None]).reshape(-1, 9, 3)
    axes = np.concatenate([x_a, x_b, edges], axis=1)
    ends = []
    for size, position, x in ((size_a, position_a, x_a), (size_b, position_b, x_b)):
        middle = _apply(axes, np.asarray(position, float))
        reach = 0.5 * _apply(np.abs(axes @ np.swapaxes(x, 1, 2)), np.asarray(size, float))
        ends += [middle - reach, middle + reach]
    return axes, *ends


def points_in_tetrahedron_same_size(
    points: ArrayLike, a: ArrayLike, b: ArrayLike, c: ArrayLike, d: ArrayLike
) -> np.ndarray:
    """E14: inside if the five determinants are of the same *size*: (m,) of bool. Right: of the same sign.

    `points` (m, 3) [m] and corners (3,) or (m, 3) [m]. Four that sum to the fifth can never all equal it in size, as an
    even number of ±1 is no odd one: every point is outside.
    """
    p = np.asarray(points, float)
    corners = [np.broadcast_to(np.asarray(corner, float), p.shape) for corner in (a, b, c, d)]
    replaced = [[p if i == k else corner for i, corner in enumerate(corners)] for k in range(4)]
    sizes = np.abs([np.linalg.det(np.stack([y - x[0] for y in x[1:]], axis=-2)) for x in (corners, *replaced)])
    return np.ptp(sizes, axis=0) <= SAME_SIZE * sizes.max(axis=0)


def _apply(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    return (matrix @ vector[..., None])[..., 0]


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.sum(a * b, axis=-1, keepdims=True)


def particle_impact_by_masses(
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
    """E13: the bounce of a particle off a box from the masses alone, and L = r × v without a mass.

    Right: the effective mass holds the box's inertia, and the box gains the angular momentum r × impulse. Returns v and
    ω of the box and v of the particle; `normal` (m, 3) points from the box to the particle; arrays as above.
    """
    v, w, u, n = (np.asarray(x, float) for x in (velocity, angular_velocity, particle_velocity, normal))
    box, particle = np.asarray(mass, float)[..., None], np.asarray(particle_mass, float)[..., None]
    arm = np.asarray(point, float) - position
    speed = _dot(u - v - np.cross(w, arm), n)
    j = np.where(speed < 0.0, -(1.0 + np.asarray(restitution, float)[..., None]) * speed, 0.0)
    j = j / (1.0 / box + 1.0 / particle) * n
    inverse = _inverse_inertia(size, orientation, True) / box[..., None]
    return v - j / box, w + _apply(inverse, np.cross(arm, -j / box)), u + j / particle


def support_half_way(
    size: ArrayLike, mass: float, position: ArrayLike, velocity: ArrayLike, other: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """E18: one contact, half-way between the bodies. Right: contacts on the surfaces, wherever they touch.

    A box that does not turn comes down on a static one whose centre is `other` (3,) [m], and one impulse along z stops
    it, with restitution 0. Returns its velocity (3,) and angular velocity (3,): it turns if it lies off-centre.
    """
    above, still = np.asarray(position, float)[None], np.zeros((1, 3))
    upright, below = np.array([[1.0, 0.0, 0.0, 0.0]]), np.asarray(other, float)[None]
    box = np.asarray(size, float)[None], np.array([mass]), above, upright, np.asarray(velocity, float)[None], still
    ground = np.ones((1, 3)), np.array([np.inf]), below, upright, still, still
    after = _impact(*box, *ground, 0.5 * (above + below), np.array([[0.0, 0.0, 1.0]]), np.zeros(1))
    return after.velocity_a[0], after.angular_velocity_a[0]


def turn_without_gyroscopic_torque(
    orientation: ArrayLike, angular_velocity: ArrayLike, seconds: float
) -> tuple[np.ndarray, np.ndarray]:
    """E19: a free box keeps ω. Right: it keeps I ω. Returns the rotation matrix (3, 3) and ω (3,) after `seconds`."""
    w = np.asarray(angular_velocity, float)
    angle = np.linalg.norm(w) * seconds
    x, y, z = w / np.linalg.norm(w)
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn = np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * k @ k
    return turn @ rotation_matrix(orientation), w
