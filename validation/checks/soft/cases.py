"""What claims about soft bodies share: regular solids, and worlds without weight."""

from __future__ import annotations

from typing import Any

import numpy as np

import softbody
from softbody import Mesh, World
from softbody.collision.soft import soft_response, soft_solver
from softbody.dynamics import pressure, soft_bodies
from validation.fault import Fault

SOLIDS = {"tetrahedron": softbody.tetrahedron, "octahedron": softbody.octahedron, "icosahedron": softbody.icosahedron}
RESPONSE = "softbody.collision.soft.soft_response"
CONTACTS = f"softbody.collision.soft.soft_contacts, {RESPONSE}"

PRESSURE = Fault("pressure off by 1e-9", pressure.gas_pressure, "gas_ / volume_ → gas_ / volume_ * (1.0 + 1e-9)")

WRONG_AXES = Fault(
    "the gas pushes along the wrong axes in the update",
    soft_bodies.ring_accelerations,
    "push_ * area_[c_, i_] → push_ * area_[c_ - 1, i_]",
)
ONE_SIDED = Fault(
    "the surface does not feel the particle",
    soft_solver.give,
    "_give_soft(s_, m_, _acting(c_, k_, p_), scale(-1.0, g_), b_)"
    " → _give_soft(s_, m_, _acting(c_, k_, p_), scale(0.0, g_), scale(0.0, g_))",
)
ALL_OF_THE_MASS = Fault(
    "contacts that each have all of a particle's mass",
    soft_solver._split,
    "weight_ * sum_[i_] * inverse_mass_[i_] → w * w * inverse_mass_[i_]",
)
FASTER = Fault(
    "sides that part faster than they came",
    soft_response.look_back,
    "contacts_.restitution[k_] → (contacts_.restitution[k_] + 1.2)",
)
STRUCK_WHERE_IT_IS = Fault(
    "a box struck where the particle is now, not where they met",
    soft_response._place_on_b,
    "_place(bodies_.particles, point_, ago_) → _place(bodies_.particles, point_, 0.0)",
)


def weightless(**options: Any) -> World:
    """Return a world without gravity."""
    return World(gravity=(0.0, 0.0, 0.0), **options)


def regular_solids(times: int = 1) -> list[tuple[str, Mesh]]:
    """Return the regular solids of radius 1 with their names, all of them so many times."""
    return [(name, make()) for name, make in SOLIDS.items()] * times


def squared_edges(mesh: Mesh) -> float:
    """Return Σ l0² [m²] over the edges."""
    i, j = mesh.edges.T
    return float(((mesh.vertices[i] - mesh.vertices[j]) ** 2).sum())


def springs_of(world: World) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the edges (e, 2), lengths at rest (e,) [m] and stiffnesses (e,) [N/m] of all springs of a world."""
    return world.model.edge_particles, world.model.edge_rest_length, world.model.edge_stiffness
