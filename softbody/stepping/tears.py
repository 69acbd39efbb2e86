"""What a step sees of bodies that may tear: springs beyond their limit, and gas that leaks out of holes."""

from __future__ import annotations

from math import exp
from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.compiler.simd import LANES, least_lane, load_lanes
from softbody.dynamics.pressure import room_in
from softbody.dynamics.watch import Limits, no_limits, places_of
from softbody.geometry.borders import holds_gas, hole, holes_of
from softbody.geometry.edges import triangles_at
from softbody.geometry.polyhedron import surface_area
from softbody.linalg.vec import dot, load, norm, sub
from softbody.linalg.vec_lanes import gather_vec
from softbody.mesh.tearing import may_part
from softbody.model.arrays import Controls, Model, State, VertexRings, is_open

SPENT = 1e-9  # of what springs at their rest length would hold: less gas than that is none


class Tearing(NamedTuple):
    """The springs that may tear, in whole lanes, and the holes of all open skins."""

    first: np.ndarray  # (k,) uint32: thrice the number of the particle at one end
    second: np.ndarray  # (k,) and at the other
    limit: np.ndarray  # (k,) [m²] square of the length beyond which it tears; inf while it waits
    edge: np.ndarray  # (k,) row in Model
    waiting: np.ndarray  # (1,) how many wait until they are within their limit again
    is_torn: np.ndarray  # (1,) of bool: something has torn in the last step
    border: np.ndarray  # (c,) particles along holes, hole by hole
    holes: np.ndarray  # (h, 2) rows of each in `border`
    hole_start: np.ndarray  # (b + 1,) of each body in `holes`
    least_gas: np.ndarray  # (b,) nRT [J] below which there is none
    limits: Limits  # the same springs, of a body that is alone and has not torn


def tearing_of(model: Model, rings: VertexRings) -> Tearing:
    """Return what may tear of a model with these rings, and its holes."""
    limited = model.edge_tear_at != 0.0
    edges = np.empty(0, np.int64)
    if limited.any():
        meets = triangles_at(model.triangle_particles, model.edge_particles, len(model.particle_inverse_mass))
        edges = np.flatnonzero(limited & may_part(model.triangle_particles, model.edge_particles, meets))
    padded = np.append(edges, np.repeat(edges[-1:], -len(edges) % LANES))
    limit = np.square(model.edge_tear_at * model.edge_rest_length)[padded]
    limit[model.edge_tear_at[padded] < 0.0] = np.inf
    ends = (3 * model.edge_particles[padded]).astype(np.uint32)
    border, holes, start, placed = [np.empty(0, np.int64)], [np.empty((0, 2), np.int64)], [0], 0
    for body in range(model.soft_count):
        first, end = model.soft_particle_start[body : body + 2]
        start.append(start[-1])
        if is_open(model, body):
            triangles = model.triangle_particles[slice(*model.soft_triangle_start[body : body + 2])] - first
            own, rows = holes_of(int(end - first), triangles)
            holes.append(rows + placed)
            border.append(own + first)
            start[-1] += len(rows)
            placed += len(own)
    energy = np.add.reduceat(
        np.append(model.edge_stiffness * np.square(model.edge_rest_length), 0.0), model.soft_edge_start
    )[:-1]
    limits = no_limits()
    if model.soft_count == 1 and len(edges) and not len(holes[-1]):
        of_rows = places_of(rings)[model.edge_particles[padded]].astype(np.uint32)
        limits = limits._replace(
            first=np.ascontiguousarray(of_rows[:, 0]),
            second=np.ascontiguousarray(of_rows[:, 1]),
            square=limit,
            per_length=0.25 / np.sqrt(limit),
        )
    return Tearing(
        np.ascontiguousarray(ends[:, 0]),
        np.ascontiguousarray(ends[:, 1]),
        limit,
        edges,
        np.array([np.count_nonzero(model.edge_tear_at[edges] < 0.0)]),
        limits.is_torn,
        np.concatenate(border),
        np.concatenate(holes),
        np.array(start, np.int64),
        SPENT * energy,
        limits,
    )


@jit
def leak_and_look(model: Model, controls: Controls, state: State, tearing: Tearing, h: float) -> bool:
    """Let gas out of holes for `h` [s], and return whether some spring is beyond its limit, which is noted.

    Through a hole of area A [m²] in a volume V [m³] leaks dn/dt = −C A n / V, by the speed C [m/s] that is the body's
    `leak`. A spring that waits counts again once it is within its limit.
    """
    for body in range(tearing.hole_start.shape[0] - 1):
        if tearing.hole_start[body + 1] > tearing.hole_start[body] and controls.soft_gas[body] > 0.0:
            _leak(model, controls, state, tearing, body, h)
    if tearing.waiting[0] > 0:
        _let_count_again(model, state, tearing)
    position, least = state.particle_position.reshape(-1), 0.0
    for i in range(0, tearing.limit.shape[0], LANES):
        along = sub(gather_vec(position, tearing.second, i), gather_vec(position, tearing.first, i))
        least = min(least, least_lane(load_lanes(tearing.limit, i) - dot(along, along)))
    tearing.is_torn[0] = least < 0.0
    return bool(tearing.is_torn[0])


@jit_lean
def _leak(model: Model, controls: Controls, state: State, tearing: Tearing, body: int, h: float) -> None:
    points, open_area, gas = state.particle_position, 0.0, controls.soft_gas[body]
    for k in range(tearing.hole_start[body], tearing.hole_start[body + 1]):
        open_area += norm(hole(points, tearing.border, (tearing.holes[k, 0], tearing.holes[k, 1]))[1])
    volume = room_in(model, points, body)
    triangles = model.triangle_particles[model.soft_triangle_start[body] : model.soft_triangle_start[body + 1]]
    if holds_gas(volume, open_area, surface_area(points, triangles)):
        gas *= exp(-model.soft_leak[body] * open_area * h / volume)
    else:
        gas = 0.0
    controls.soft_gas[body] = gas if gas > tearing.least_gas[body] else 0.0


@jit_lean
def _let_count_again(model: Model, state: State, tearing: Tearing) -> None:
    for k in range(tearing.edge.shape[0]):
        e = tearing.edge[k]
        if model.edge_tear_at[e] < 0.0:
            a, b = model.edge_particles[e, 0], model.edge_particles[e, 1]
            along, longest = (
                sub(load(state.particle_position, b), load(state.particle_position, a)),
                (model.edge_tear_at[e] * model.edge_rest_length[e]),
            )
            if dot(along, along) <= longest * longest:
                model.edge_tear_at[e] = -model.edge_tear_at[e]
                tearing.limit[k] = longest * longest
                tearing.waiting[0] -= 1
