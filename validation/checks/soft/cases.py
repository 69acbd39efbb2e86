"""What claims about soft bodies share: regular solids, and worlds without weight."""

from __future__ import annotations

from typing import Any

import numpy as np

import softbody
from softbody import Mesh, World
from softbody.dynamics import pressure
from validation.fault import Fault

SOLIDS = {"tetrahedron": softbody.tetrahedron, "octahedron": softbody.octahedron, "icosahedron": softbody.icosahedron}
RESPONSE = "softbody.collision.soft.soft_response"
CONTACTS = f"softbody.collision.soft.soft_contacts, {RESPONSE}"

PRESSURE = Fault("pressure off by 1e-9", pressure.gas_pressure, "gas_ / volume_ → gas_ / volume_ * (1.0 + 1e-9)")


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
