"""Equilibria of soft bodies, and the breathing of symmetric ones, by SciPy.

Energy, gradient and Hessian of springs and gas are written here once more, in numpy.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import scipy.integrate
import scipy.linalg
import scipy.optimize
import scipy.sparse
import scipy.sparse.csgraph
import scipy.spatial

PACKAGES = {"scipy": "scipy"}  # import name, and the name to install it by
SETTINGS = {  # what was chosen against the defaults, and why
    "L-BFGS-B runs until it finds no better point, and Newton's method finishes": (
        "its ftol 2e-9 and gtol 1e-5 stop far too early for a judge"
    ),
    "DOP853 with rtol 1e-13 (1e-3)": "a judge is to be more precise than the judged",
    "every requested time is the end of a step": (
        "SciPy's interpolation between steps is of lower order than the steps"
    ),
}

RTOL = 1e-13  # of DOP853; SciPy allows no less than 2.2e-14
ATOL = 1e-15  # of DOP853, on λ near 1
NEWTON_STEPS = 5  # two are enough


class Equilibrium(NamedTuple):
    """Where a soft body rests, and how nearly."""

    positions: np.ndarray  # (n, 3) [m]
    residual: float  # largest net force on a vertex over the largest stiffness × length of a spring


def pressure_gradient(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return ∂V/∂x (n, 3) [m²] of a closed mesh, so that the gas at pressure P pushes with P ∂V/∂x.

    `vertices` (n, 3) [m], `triangles` (t, 3). From V = Σ a·(b×c)/6 by the product rule, about the mean vertex: b×c/6
    to a, and round. Triangle by triangle this differs from a third of the area vector; only the sums agree.
    """
    x = vertices - np.mean(vertices, axis=0)
    a, b, c = (x[triangles[:, k]] for k in range(3))
    gradient = np.zeros_like(x)
    for k, sixths in enumerate((np.cross(b, c), np.cross(c, a), np.cross(a, b))):
        np.add.at(gradient, triangles[:, k], sixths / 6.0)
    return gradient


def equilibrium(
    vertices: np.ndarray,
    edges: np.ndarray,
    rest_length: np.ndarray,
    stiffness: np.ndarray,
    triangles: np.ndarray,
    gas: float,
) -> Equilibrium:
    """Return the minimum of U = ½ Σ k (l − l0)² − nRT ln V that is downhill from `vertices` (n, 3) [m].

    `edges` (e, 2), `rest_length` (e,) [m], `stiffness` (e,) [N/m] or a number, `triangles` (t, 3), `gas` nRT [J]. No
    load, no contact: the answer is free up to a rigid motion, and is given as near to `vertices` as one can bring it.
    """
    body = _Body(edges, np.asarray(rest_length, float), np.asarray(stiffness, float), triangles, gas)
    middle = np.mean(vertices, axis=0)
    start = np.asarray(vertices, float) - middle  # far from the origin, volumes lose their digits
    x = _least(body.energy_and_gradient, start).reshape(-1, 3)
    for _ in range(NEWTON_STEPS):
        moved = x - body.newton_step(x)
        if not body.residual(moved) < body.residual(x):
            break
        x = moved
    x = x - x.mean(axis=0)
    turn, _ = scipy.spatial.transform.Rotation.align_vectors(start, x)
    return Equilibrium(turn.apply(x) + middle, body.residual(x))


def hanging(
    vertices: np.ndarray,
    edges: np.ndarray,
    rest_length: np.ndarray,
    stiffness: np.ndarray,
    triangles: np.ndarray,
    gas: float,
    load: np.ndarray,
    fixed: np.ndarray,
) -> Equilibrium:
    """Return the minimum of U − Σ load·x, with some vertices `fixed` (f,) in place; other arguments as of equilibrium.

    `load` (n, 3) [N]. At least three vertices that are not in line must be fixed, so that nothing can turn.
    """
    body = _Body(edges, np.asarray(rest_length, float), np.asarray(stiffness, float), triangles, gas)
    free = np.setdiff1d(np.arange(len(vertices)), fixed)
    rows = (3 * free[:, None] + np.arange(3)).ravel()
    whole = np.array(vertices, float)

    def put(flat: np.ndarray) -> np.ndarray:
        whole[free] = flat.reshape(-1, 3)
        return whole

    def energy_and_gradient(flat: np.ndarray) -> tuple[float, np.ndarray]:
        x = put(flat)
        stored, gradient = body.energy_and_gradient(x.ravel())
        return stored - float((load * x).sum()), gradient[rows] - load[free].ravel()

    flat = _least(energy_and_gradient, whole[free])
    for _ in range(NEWTON_STEPS):
        x = put(flat)
        left = body.gradient(x).ravel()[rows] - load[free].ravel()
        flat = flat - scipy.linalg.solve(body.hessian(x)[np.ix_(rows, rows)], left, assume_a="sym")
    x = put(flat).copy()
    left = (body.gradient(x) - load)[free]
    return Equilibrium(x, float(np.abs(left).max() / np.max(body.stiffness * _lengths(x, edges))))


def between_plates(
    vertices: np.ndarray,
    edges: np.ndarray,
    rest_length: np.ndarray,
    stiffness: np.ndarray,
    triangles: np.ndarray,
    gas: float,
    weight: float,
    height: float,
) -> tuple[np.ndarray, float]:
    """Return the minimum of U + Σ w z with all vertices at 0 ≤ z ≤ `height` [m], w a vertex's part of the `weight` [N].

    Positions (n, 3) [m], and with what force [N] the upper plate is pressed; other arguments as of equilibrium. Plates
    are smooth: the body may slide and turn, of which nothing is left in either.
    """
    body, count = (
        _Body(edges, np.asarray(rest_length, float), np.asarray(stiffness, float), triangles, gas),
        len(vertices),
    )

    def energy_and_gradient(flat: np.ndarray) -> tuple[float, np.ndarray]:
        stored, gradient = body.energy_and_gradient(flat)
        pull = np.zeros((count, 3))
        pull[:, 2] = weight / count
        return stored + float((pull.ravel() * flat).sum()), gradient + pull.ravel()

    start, bounds = np.array(vertices, float), [(None, None), (None, None), (0.0, height)] * count
    start[:, 2] = np.clip(start[:, 2], 0.0, height)
    flat = _least(energy_and_gradient, start, bounds)
    x, gradient = flat.reshape(-1, 3), energy_and_gradient(flat)[1].reshape(-1, 3)
    return x, -float(gradient[x[:, 2] == height, 2].sum())


def _least(
    energy_and_gradient: Callable[[np.ndarray], tuple[float, np.ndarray]],
    start: np.ndarray,
    bounds: Sequence[tuple[float | None, float | None]] | None = None,
) -> np.ndarray:
    """Return where L-BFGS-B finds no less energy any more, flat, downhill from `start`; see SETTINGS."""
    return scipy.optimize.minimize(
        energy_and_gradient,
        start.ravel(),
        jac=True,
        method="L-BFGS-B",
        bounds=bounds,
        options={"ftol": 0.0, "gtol": 0.0, "maxiter": 20_000, "maxfun": 40_000, "maxcor": 30},
    ).x


def forces(
    vertices: np.ndarray,
    edges: np.ndarray,
    rest_length: np.ndarray,
    stiffness: np.ndarray,
    triangles: np.ndarray,
    gas: float,
) -> np.ndarray:
    """Return −∂U/∂x (n, 3) [N]; arguments as of equilibrium."""
    return -_Body(edges, rest_length, stiffness, triangles, gas).gradient(vertices)


def dampers(x: np.ndarray, v: np.ndarray, edges: np.ndarray, damping: float) -> np.ndarray:
    """Return the forces (n, 3) [N] of dampers along `edges` (e, 2), each of `damping` [N s/m]."""
    i, j = edges.T
    along = (x[j] - x[i]) / np.linalg.norm(x[j] - x[i], axis=1, keepdims=True)
    pull = damping * ((v[j] - v[i]) * along).sum(axis=1, keepdims=True) * along
    force = np.zeros_like(x)
    np.add.at(force, i, pull)
    np.add.at(force, j, -pull)
    return force


def energy(
    vertices: np.ndarray,
    edges: np.ndarray,
    rest_length: np.ndarray,
    stiffness: np.ndarray,
    triangles: np.ndarray,
    gas: float,
) -> float:
    """Return U [J] of springs and gas, of the gas up to a constant; arguments as of equilibrium."""
    flat = np.asarray(vertices, float).ravel()
    return float(_Body(edges, rest_length, stiffness, triangles, gas).energy_and_gradient(flat)[0])


def motion(
    vertices: np.ndarray,
    velocity: np.ndarray,
    edges: np.ndarray,
    rest_length: np.ndarray,
    stiffness: np.ndarray,
    triangles: np.ndarray,
    gas: float,
    particle_mass: float,
    seconds: float,
    force: np.ndarray | float = 0.0,
    rtol: float = RTOL,
    damping: float = 0.0,
) -> tuple[np.ndarray, np.ndarray]:
    """Return where the vertices (n, 3) [m] are after `seconds`, and how fast [m/s], by DOP853; see equilibrium.

    `force` (n, 3) [N] acts on them besides springs, which have a `damping` [N s/m], and gas; there is no weight.
    """
    body = _Body(edges, rest_length, stiffness, triangles, gas)

    def derivative(_: float, y: np.ndarray) -> np.ndarray:
        x, v = y.reshape(2, -1, 3)
        total = force - body.gradient(x)
        if damping > 0.0:
            total = total + dampers(x, v, edges, damping)
        return np.concatenate([v.ravel(), total.ravel() / particle_mass])

    begin = np.concatenate([vertices.ravel(), velocity.ravel()])
    run = scipy.integrate.solve_ivp(derivative, (0.0, seconds), begin, method="DOP853", rtol=rtol, atol=ATOL)
    x, v = run.y[:, -1].reshape(2, -1, 3)
    return x, v


def highest_frequency(
    vertices: np.ndarray,
    edges: np.ndarray,
    rest_length: np.ndarray,
    stiffness: np.ndarray,
    triangles: np.ndarray,
    gas: float,
    particle_mass: float,
) -> float:
    """Return the highest angular frequency [rad/s] of small motions about `vertices`: √ of H's eigenvalue over m."""
    hessian = _Body(edges, rest_length, stiffness, triangles, gas).hessian(np.asarray(vertices, float))
    return float(np.sqrt(scipy.linalg.eigvalsh(hessian)[-1] / particle_mass))


class _Body(NamedTuple):
    edges: np.ndarray
    rest_length: np.ndarray
    stiffness: np.ndarray
    triangles: np.ndarray
    gas: float

    def energy_and_gradient(self, flat: np.ndarray) -> tuple[float, np.ndarray]:
        x = flat.reshape(-1, 3)
        volume = _volume(x, self.triangles)
        if volume <= 0.0:
            return np.inf, np.zeros_like(flat)  # a line search that turned the body inside out steps back
        stretch = _lengths(x, self.edges) - self.rest_length
        energy = 0.5 * np.sum(self.stiffness * stretch**2) - self.gas * np.log(volume)
        return energy, self.gradient(x).ravel()

    def residual(self, x: np.ndarray) -> float:
        return float(np.abs(self.gradient(x)).max() / np.max(self.stiffness * _lengths(x, self.edges)))

    def gradient(self, x: np.ndarray) -> np.ndarray:
        """Return ∂U/∂x (n, 3) [N]."""
        d = x[self.edges[:, 1]] - x[self.edges[:, 0]]
        length = np.linalg.norm(d, axis=1)
        springs = (self.stiffness * (length - self.rest_length) / length)[:, None] * d
        gradient = -self.gas / _volume(x, self.triangles) * pressure_gradient(x, self.triangles)
        np.add.at(gradient, self.edges[:, 1], springs)
        np.add.at(gradient, self.edges[:, 0], -springs)
        return gradient

    def newton_step(self, x: np.ndarray) -> np.ndarray:
        """Return H⁻¹ ∂U/∂x (n, 3) [m] without any rigid motion, of which neither H nor the gradient knows."""
        n = len(x)
        hessian = self.hessian(x)
        rigid = np.concatenate([np.tile(np.eye(3), (n, 1, 1)), _cross_matrix(x - x.mean(axis=0))], axis=2)
        rigid, _ = np.linalg.qr(rigid.reshape(3 * n, 6))
        hessian += np.abs(hessian).max() * (rigid @ rigid.T)
        return scipy.linalg.solve(hessian, self.gradient(x).ravel(), assume_a="sym").reshape(n, 3)

    def hessian(self, x: np.ndarray) -> np.ndarray:
        """Return ∂²U/∂x² (3n, 3n) [N/m]."""
        blocks = np.zeros((len(x), len(x), 3, 3))
        spring = self._spring_blocks(x)
        for i, j in ((0, 1), (1, 0)):
            np.add.at(blocks, (self.edges[:, i], self.edges[:, i]), spring)
            np.add.at(blocks, (self.edges[:, i], self.edges[:, j]), -spring)
        volume, about_mean = _volume(x, self.triangles), x - x.mean(axis=0)
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            # a·(b×c) = −a·(c×b): ∂²V/∂a∂b is the matrix of −c× over 6
            mixed = self.gas / volume / 6.0 * _cross_matrix(about_mean[self.triangles[:, k]])
            np.add.at(blocks, (self.triangles[:, i], self.triangles[:, j]), mixed)
            np.add.at(blocks, (self.triangles[:, j], self.triangles[:, i]), np.swapaxes(mixed, 1, 2))
        growth = pressure_gradient(x, self.triangles).ravel()
        flat = blocks.transpose(0, 2, 1, 3).reshape(x.size, x.size)
        return flat + self.gas / volume**2 * np.outer(growth, growth)

    def _spring_blocks(self, x: np.ndarray) -> np.ndarray:
        """Return k (1 − l0/l (1 − d dᵀ/l²)) (e, 3, 3) [N/m] of each spring."""
        d = x[self.edges[:, 1]] - x[self.edges[:, 0]]
        length = np.linalg.norm(d, axis=1)
        slack = (self.rest_length / length)[:, None, None]
        along = d[:, :, None] * d[:, None, :] / (length**2)[:, None, None]
        return np.broadcast_to(self.stiffness, len(d))[:, None, None] * (np.eye(3) - slack * (np.eye(3) - along))


def _lengths(x: np.ndarray, edges: np.ndarray) -> np.ndarray:
    return np.linalg.norm(x[edges[:, 1]] - x[edges[:, 0]], axis=1)


def _volume(x: np.ndarray, triangles: np.ndarray) -> float:
    """Return the volume [m³], about the mean vertex: about the origin, D away, rounding is 1e-16 D³, of any volume."""
    about_mean = x - x.mean(axis=0)
    a, b, c = (about_mean[triangles[:, k]] for k in range(3))
    return float(np.einsum("tk,tk->", a, np.cross(b, c)) / 6.0)


def _cross_matrix(v: np.ndarray) -> np.ndarray:
    """Return the matrices (m, 3, 3) of w ↦ v × w."""
    x, y, z = v.T
    o = np.zeros_like(x)
    return np.array([[o, -z, y], [z, o, -x], [-y, x, o]]).transpose(2, 0, 1)


def places_joined(points: np.ndarray, reach: float) -> np.ndarray:
    """Return for each of `points` (n, 3) the lowest number of those that leaps of at most `reach` lead to: (n,)."""
    near = scipy.spatial.cKDTree(points).query_pairs(reach, output_type="ndarray")
    table = scipy.sparse.coo_array((np.ones(len(near)), (near[:, 0], near[:, 1])), shape=(len(points),) * 2)
    _, group = scipy.sparse.csgraph.connected_components(table, directed=False)
    first = np.full(group.max() + 1, len(points))
    np.minimum.at(first, group, np.arange(len(points)))
    return first[group]


def nearest_rows(rows: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return the row of `others` (m, k) that is nearest to each of `rows` (n, k)."""
    return np.asarray(others[scipy.spatial.cKDTree(others).query(rows)[1]])


def scale_motion(
    time: np.ndarray,
    scale0: float,
    rate0: float,
    inertia: float,
    stiffness_rest_squared: float,
    gas: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return λ (n,) and λ' (n,) [1/s] at `time` (n,) [s], rising from 0: M λ'' = −K (λ − 1) + 3nRT/λ.

    The symmetric motion of a triangulated regular solid: `inertia` M = Σ m |x|² [kg m²] at λ = 1,
    `stiffness_rest_squared` K = k Σ l0² [J], `gas` nRT [J], from λ = `scale0` and λ' = `rate0` [1/s] at time 0.
    """

    def derivative(_: float, y: np.ndarray) -> list[float]:
        return [y[1], (-stiffness_rest_squared * (y[0] - 1.0) + 3.0 * gas / y[0]) / inertia]

    state, now, states = np.array([scale0, rate0], float), 0.0, []
    for end in np.asarray(time, float):
        if end > now:
            run = scipy.integrate.solve_ivp(derivative, (now, end), state, method="DOP853", rtol=RTOL, atol=ATOL)
            state, now = run.y[:, -1], end
        states.append(state)
    scale, rate = np.array(states).reshape(-1, 2).T
    return scale, rate


def connected(count: int, pairs: Sequence[tuple[int, int]]) -> np.ndarray:
    """Return which component (count,) each of so many nodes is in, if the nodes of each pair are connected."""
    i, j = np.array(pairs, int).reshape(-1, 2).T
    graph = scipy.sparse.coo_matrix((np.ones(len(i)), (i, j)), shape=(count, count))
    return np.asarray(scipy.sparse.csgraph.connected_components(graph, directed=False)[1])
