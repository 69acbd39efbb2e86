"""Longest time step that soft bodies can take before the integrator diverges."""

from __future__ import annotations

from math import sqrt

import numpy as np

from softbody.compiler.jit import jit
from softbody.dynamics.pressure import gas_pressure, room_in
from softbody.linalg.vec import add, cross, dot, load, norm, scale, sub
from softbody.model.arrays import Controls, Model, is_open, mass_of


@jit
def highest_frequency(model: Model, controls: Controls, position: np.ndarray, body: int) -> float:
    """Return an upper bound of the highest angular frequency ω [rad/s] of one soft body at `position`.

    ω² is the largest eigenvalue of M⁻¹ ∂²U/∂x². Bounded term by term: the springs by the graph Laplacian's
    bound, max over edges of the sum of Σk/m at both ends (Anderson and Morley 1985; a compressed spring only
    lowers it); the gas by its rank-one part nRT/V² Σ|∂V/∂x|²/m plus P times the row sums of ∂²V/∂x².
    """
    edge_range = range(model.soft_edge_start[body], model.soft_edge_start[body + 1])
    first = model.soft_particle_start[body]
    count = model.soft_particle_start[body + 1] - first
    stiffness = np.zeros(count)
    bend = np.zeros(count)
    gradient = np.zeros((count, 3))
    for e in edge_range:
        for end in range(2):
            stiffness[model.edge_particles[e, end] - first] += model.edge_stiffness[e]
    for t in range(model.soft_triangle_start[body], model.soft_triangle_start[body + 1]):
        a = load(position, model.triangle_particles[t, 0])
        b = load(position, model.triangle_particles[t, 1])
        c = load(position, model.triangle_particles[t, 2])
        six_gradients = cross(sub(b, a), sub(c, a))
        # ∂²V/∂p∂q is [r − m]×/6 from this triangle, about the middle m of the edge that it shares: a median's length.
        medians = (
            norm(sub(a, scale(0.5, add(b, c)))),
            norm(sub(b, scale(0.5, add(c, a)))),
            norm(sub(c, scale(0.5, add(a, b)))),
        )
        for corner in range(3):
            i = model.triangle_particles[t, corner]
            bend[i - first] += (medians[(corner + 1) % 3] + medians[(corner + 2) % 3]) / 6.0
            for d in range(3):
                gradient[i - first, d] += six_gradients[d] / 6.0
    volume = room_in(model, position, body)
    pressure = gas_pressure(controls.soft_gas[body], volume)
    springs = 0.0
    for e in edge_range:
        i = model.edge_particles[e, 0]
        j = model.edge_particles[e, 1]
        both = (
            stiffness[i - first] * model.particle_inverse_mass[i]
            + stiffness[j - first] * model.particle_inverse_mass[j]
        )
        springs = max(springs, both)
    rank_one = 0.0
    rows = 0.0
    for i in range(count):
        g = load(gradient, i)
        rank_one += dot(g, g) * model.particle_inverse_mass[first + i]
        rows = max(rows, bend[i] * model.particle_inverse_mass[first + i])
    if is_open(model, body) and pressure == 0.0:  # of no volume at all, perhaps
        return sqrt(springs)
    return sqrt(springs + abs(pressure) * (rank_one / abs(volume) + rows))


@jit
def highest_damping(model: Model, body: int) -> float:
    """Return an upper bound of the fastest rate γ [1/s] at which damping and drag of a soft body act: v' = −γ v.

    By the graph Laplacian's bound again, with the damping of the springs in place of their stiffness.
    """
    if model.soft_damping[body] == 0.0:
        return model.soft_drag[body]
    first = model.soft_particle_start[body]
    neighbours = np.zeros(model.soft_particle_start[body + 1] - first)
    edge_range = range(model.soft_edge_start[body], model.soft_edge_start[body + 1])
    for e in edge_range:
        for end in range(2):
            neighbours[model.edge_particles[e, end] - first] += 1.0
    springs = 0.0
    for e in edge_range:
        i = model.edge_particles[e, 0]
        j = model.edge_particles[e, 1]
        both = (
            neighbours[i - first] * model.particle_inverse_mass[i]
            + neighbours[j - first] * model.particle_inverse_mass[j]
        )
        springs = max(springs, both)
    return model.soft_damping[body] * springs + model.soft_drag[body]


@jit
def longest_stable_step(frequency: float, damping: float, limit: float) -> float:
    """Return h [s] with (ω h / limit)² + γ h / 2 = 1: stable for every ω ≤ `frequency` and γ ≤ `damping` [1/s].

    `limit` is that of the integrator without damping. Exact for symplectic Euler, where (ω h)² + 2 γ h ≤ 4; for the
    two others it lies within their regions of stability, which the tests scan.
    """
    a = (frequency / limit) ** 2
    b = 0.25 * damping
    if a == 0.0 and b == 0.0:
        return np.inf
    return 1.0 / (b + sqrt(b * b + a))


@jit
def shortest_stable_step(model: Model, controls: Controls, position: np.ndarray, limit: float) -> tuple[float, int]:
    """Return (h [s], −1): stable for every soft body at `position`; or (h, body) of the first for which none is > 0."""
    shortest = np.inf
    for body in range(model.soft_count):
        frequency = highest_frequency(model, controls, position, body)
        step = longest_stable_step(frequency, highest_damping(model, body), limit)
        if not step > 0.0:
            return step, body
        shortest = min(shortest, step)
    return shortest, -1


GROWTH = 1e3  # times its own size, at rest, to which no body grows that is computed well
LARGEST = 1e50  # [m] so that squares of squares of lengths are finite


def most_extents(model: Model, controls: Controls) -> np.ndarray:
    """Return the length [m], along an axis, beyond which each soft body can only have diverged: (b,).

    GROWTH times what springs, gas and gravity make of it. The size of the springs is √(Σ l0²), some times the extent of
    a mesh as it was made. A gas blows it up by the λ of a regular solid, λ² − λ = 3 nRT / Σ k l0²; a body that hangs on
    one spring is as much longer as that gives.
    """
    extents = np.empty(model.soft_count)
    fall = float(np.sqrt(np.square(controls.gravity).sum()))
    for body in range(model.soft_count):
        edges = slice(model.soft_edge_start[body], model.soft_edge_start[body + 1])
        stiffness, square = model.edge_stiffness[edges], np.square(model.edge_rest_length[edges])
        mass = mass_of(model.particle_free_inverse_mass[slice(*model.soft_particle_start[body : body + 2])])
        with np.errstate(all="ignore"):
            swelling = 0.5 + np.sqrt(0.25 + 3.0 * controls.soft_gas[body] / (stiffness * square).sum())
            hanging = fall * mass / stiffness.min()
            extents[body] = GROWTH * (np.sqrt(square.sum()) * swelling + hanging)
    return np.fmin(extents, LARGEST)
