"""Lines among meshes, drawn as tubes that look equally thin everywhere, with a knot at each end."""

from __future__ import annotations

import numpy as np

from softbody.mesh.mesh import icosahedron
from softbody.render.camera import Camera
from softbody.render.rasteriser import Thing

WIDTH = 0.005  # of the picture's height
KNOT = 2.2  # diameter of a knot, in widths
SIDES = 6  # of a tube
NEAR = 1e-3  # of the way to the camera's target: what is nearer to the eye is cut off
COLOUR = (0.2, 0.2, 0.24)


def lines(ends: np.ndarray, camera: Camera) -> list[Thing]:
    """Return what shows lines between `ends` (j, 2, 3) [m] to a camera: one thing, or nothing where none is seen."""
    ends, depth = _before_the_eye(ends, camera)
    if not len(ends):
        return []
    radius = WIDTH * np.tan(0.5 * np.radians(camera.view)) * depth
    tubes, knots = _tubes(ends, radius), _knots(ends.reshape(-1, 3), KNOT * radius.ravel())
    vertices = np.concatenate([tubes[0], knots[0]])
    triangles = np.concatenate([tubes[1], knots[1] + len(tubes[0])])
    return [Thing(vertices, triangles, COLOUR, casts_shadow=False)]


def _before_the_eye(ends: np.ndarray, camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Return the parts of lines that are before the eye, (k, 2, 3) [m], and how far along the view, (k, 2) [m]."""
    near = NEAR * float(np.linalg.norm(np.subtract(camera.target, camera.eye)))
    depth = (ends - camera.eye) @ camera.axes()[2]
    seen = depth.max(axis=1) > near
    ends, depth = ends[seen], depth[seen]
    is_behind = depth < near
    part = np.where(is_behind, near - depth, 0.0) / np.where(is_behind, depth[:, ::-1] - depth, 1.0)
    return ends + part[:, :, None] * (ends[:, ::-1] - ends), np.maximum(depth, near)


def _tubes(ends: np.ndarray, radius: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 3) [m] and triangles (t, 3) of open tubes, of a `radius` (j, 2) [m] at each end."""
    along = ends[:, 1] - ends[:, 0]
    along[~along.any(axis=1)] = 0.0, 0.0, 1.0
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.cross(along, np.eye(3)[np.abs(along).argmin(axis=1)])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    angle = 2.0 * np.pi * np.arange(SIDES)[:, None] / SIDES
    ring = np.cos(angle) * across[:, None] + np.sin(angle) * np.cross(along, across)[:, None]
    vertices = ends[:, :, None] + radius[:, :, None, None] * ring[:, None]
    k = np.arange(SIDES)
    after = np.roll(k, -1)
    one = np.concatenate([np.stack([k, after, SIDES + after], 1), np.stack([k, SIDES + after, SIDES + k], 1)])
    return vertices.reshape(-1, 3), _repeated(one, len(ends), 2 * SIDES)


def _knots(places: np.ndarray, radius: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 3) [m] and triangles (t, 3) of balls at `places` (m, 3) [m], of a `radius` (m,) [m] each."""
    ball = icosahedron(1.0)
    vertices = places[:, None] + radius[:, None, None] * ball.vertices
    return vertices.reshape(-1, 3), _repeated(ball.triangles, len(places), len(ball.vertices))


def _repeated(triangles: np.ndarray, times: int, vertices: int) -> np.ndarray:
    """Return the triangles of a shape of so many vertices, once for each time that the vertices are there."""
    return (triangles + vertices * np.arange(times)[:, None, None]).reshape(-1, 3)
