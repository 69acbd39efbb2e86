"""Boxes inside a soft body of a World: whether they fit, and the parts in which they are there."""

from __future__ import annotations

import numpy as np

from softbody.bodies.builder import Parts, with_box_inside
from softbody.bodies.soft_body import SoftBody
from softbody.bodies.store import Store
from softbody.dynamics.liquid_forces import BOX_TRIANGLES, corners_of
from softbody.errors import ParameterError
from softbody.geometry import points_in_mesh
from softbody.geometry.self_intersections import self_intersections
from softbody.mesh.weld import first_at_place
from softbody.model.arrays import NOBODY
from softbody.model.validation import shown


def check_host(store: Store, body: SoftBody, name: str) -> None:
    """Raise ParameterError unless a soft body is in a store; `name` is what a user calls it."""
    if not isinstance(body, SoftBody) or body.store is not store:
        raise ParameterError(f"{name} is {shown(body)}, which is no soft body of this world; give a handle of one")


def check_fits(body: SoftBody, box: str, corners: np.ndarray) -> None:
    """Raise ParameterError unless a box is inside a soft body; `box` in words, with `corners` (8, 3) [m]."""
    inside = points_in_mesh(corners, body.positions, body.triangles)
    if not inside.all():
        k = int(np.argmin(inside))
        raise ParameterError(
            f"corner {k} of {box}, at {corners[k]} m, is not inside {body!r}: move it in, or take a larger body"
        )
    vertices = np.concatenate([corners, body.positions])
    triangles = np.concatenate([BOX_TRIANGLES, body.triangles + 8])
    meets, _ = self_intersections(vertices, triangles, first_at_place(vertices))
    through = (meets < len(BOX_TRIANGLES)).sum(axis=1) == 1
    if through.any():
        triangle = int(meets[through].max(axis=1)[0]) - len(BOX_TRIANGLES)
        raise ParameterError(
            f"triangle {triangle} of {body!r} passes through {box}: move the box, or take a smaller one"
        )


def with_box_put(store: Store, parts: Parts, box: int, body: SoftBody | None) -> Parts:
    """Return `parts` of a store where a box is inside one of its soft bodies, or in none; raises ParameterError."""
    if body is None:
        return with_box_inside(parts, box, NOBODY)
    check_host(store, body, "inside")
    check_fits(body, f"box {box}", corners_of(parts.model, parts.state, box))
    return with_box_inside(parts, box, body.row())
