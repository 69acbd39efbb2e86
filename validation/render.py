"""What does a scene look like? A small rasteriser: no display, no graphics library, the same picture every time."""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np

SUPERSAMPLING = 2  # each pixel is the mean of 2 × 2 samples
SHADOW_TEXELS = 384  # of the ground's shadow map, each way

LIGHT = np.array([-0.55, -0.45, 1.0]) / np.linalg.norm([-0.55, -0.45, 1.0])  # where the light comes from
SKY = np.array([0.93, 0.95, 0.98])
GROUND = np.array([[0.82, 0.84, 0.86], [0.74, 0.76, 0.79]])  # the two colours of its squares
AMBIENT, DIFFUSE, SHINE, SHININESS = 0.35, 0.65, 0.25, 30.0
SHADOW = 0.62  # of the ground's brightness


@dataclass
class Thing:
    """One mesh to draw: `vertices` (n, 3) [m], `triangles` (t, 3), `colour` (3,) 0 … 1, smooth or faceted."""

    vertices: np.ndarray
    triangles: np.ndarray
    colour: tuple[float, float, float]
    smooth: bool = True


@dataclass
class Camera:
    """Where the picture is taken from: `eye` and `target` [m], vertical field of view [degrees], size in pixels."""

    eye: tuple[float, float, float]
    target: tuple[float, float, float]
    view: float = 35.0
    width: int = 480
    height: int = 360

    def axes(self) -> np.ndarray:
        """Return right, up and forward unit vectors as rows (3, 3)."""
        forward = np.subtract(self.target, self.eye)
        forward = forward / np.linalg.norm(forward)
        right = np.cross(forward, (0.0, 0.0, 1.0))
        right /= np.linalg.norm(right)
        return np.array([right, np.cross(right, forward), forward])


def render(things: list[Thing], camera: Camera, ground: float | None = 0.0) -> np.ndarray:
    """Return a picture (height, width, 3) of uint8; `ground` [m] is the height of a chequered floor, None for none."""
    width, height = SUPERSAMPLING * camera.width, SUPERSAMPLING * camera.height
    focus = 0.5 * height / np.tan(0.5 * np.radians(camera.view))
    eye, axes = np.array(camera.eye, float), camera.axes()
    colour = np.empty((height, width, 3))
    colour[:] = SKY
    distance = np.full((height, width), np.inf)
    if ground is not None:
        shadow, low, step = _shadow_map(things, ground)
        _draw_ground(colour, distance, eye, axes, focus, float(ground), shadow, low, step, GROUND, SKY, SHADOW)
    for thing in things:
        vertices, normals, triangles = _shaded_vertices(thing)
        arguments = (np.array(thing.colour, float), LIGHT, np.array([AMBIENT, DIFFUSE, SHINE, SHININESS]))
        _draw_triangles(colour, distance, eye, axes, focus, vertices, normals, triangles, *arguments)
    samples = colour.reshape(camera.height, SUPERSAMPLING, camera.width, SUPERSAMPLING, 3).mean(axis=(1, 3))
    return np.round(255.0 * np.clip(samples, 0.0, 1.0)).astype(np.uint8)


def _shaded_vertices(thing: Thing) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return vertices, their unit normals and triangles; faceted things get corners of their own."""
    corners = thing.vertices[thing.triangles]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    if not thing.smooth:
        normals = np.repeat(faces, 3, axis=0)
        vertices, triangles = corners.reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)
    else:
        vertices, triangles = np.ascontiguousarray(thing.vertices), np.ascontiguousarray(thing.triangles)
        normals = np.zeros_like(vertices)
        for k in range(3):
            np.add.at(normals, triangles[:, k], faces)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return vertices, normals / np.where(length > 0.0, length, 1.0), triangles


def _shadow_map(things: list[Thing], ground: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Return which squares of the ground are in shadow, the map's low corner [m] and the side of a square [m]."""
    cast = [t.vertices[:, :2] - (t.vertices[:, 2:] - ground) / LIGHT[2] * LIGHT[:2] for t in things]
    shadow = np.zeros((SHADOW_TEXELS, SHADOW_TEXELS), np.bool_)
    if not cast:
        return shadow, np.zeros(2), 1.0
    every = np.concatenate(cast)
    low = every.min(axis=0)
    step = float((every.max(axis=0) - low).max()) / (SHADOW_TEXELS - 2) + 1e-9
    for flat, thing in zip(cast, things):
        _fill_shadow(shadow, (flat - low) / step, np.ascontiguousarray(thing.triangles))
    return shadow, low, step


@numba.njit(cache=True)
def _fill_shadow(shadow, points, triangles):
    for t in range(triangles.shape[0]):
        a, b, c = points[triangles[t, 0]], points[triangles[t, 1]], points[triangles[t, 2]]
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if area == 0.0:
            continue
        for i in range(max(0, int(min(a[0], b[0], c[0]))), min(shadow.shape[0] - 1, int(max(a[0], b[0], c[0]))) + 1):
            for j in range(
                max(0, int(min(a[1], b[1], c[1]))), min(shadow.shape[1] - 1, int(max(a[1], b[1], c[1]))) + 1
            ):
                x, y = i + 0.5, j + 0.5
                u = ((b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x)) / area
                v = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / area
                if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
                    shadow[i, j] = True


@numba.njit(cache=True)
def _draw_ground(colour, distance, eye, axes, focus, height, shadow, low, step, squares, sky, dark):
    rows, columns = distance.shape
    for r in range(rows):
        for s in range(columns):
            x, y = (s + 0.5 - 0.5 * columns) / focus, (0.5 * rows - r - 0.5) / focus
            down = x * axes[0, 2] + y * axes[1, 2] + axes[2, 2]
            if down >= 0.0:
                continue
            far = (height - eye[2]) / down
            if far <= 0.0:
                continue
            px = eye[0] + far * (x * axes[0, 0] + y * axes[1, 0] + axes[2, 0])
            py = eye[1] + far * (x * axes[0, 1] + y * axes[1, 1] + axes[2, 1])
            square = (int(np.floor(px)) + int(np.floor(py))) & 1
            i, j = int(np.floor((px - low[0]) / step)), int(np.floor((py - low[1]) / step))
            light = 1.0
            if 0 <= i < shadow.shape[0] and 0 <= j < shadow.shape[1] and shadow[i, j]:
                light = dark
            haze = min(1.0, far / 40.0)
            for c in range(3):
                colour[r, s, c] = (1.0 - haze) * light * squares[square, c] + haze * sky[c]
            distance[r, s] = far


@numba.njit(cache=True)
def _draw_triangles(colour, distance, eye, axes, focus, vertices, normals, triangles, tint, light, surface):
    rows, columns = distance.shape
    seen = np.empty((vertices.shape[0], 3))  # column, row and distance along the view
    for i in range(vertices.shape[0]):
        d0, d1, d2 = vertices[i, 0] - eye[0], vertices[i, 1] - eye[1], vertices[i, 2] - eye[2]
        far = d0 * axes[2, 0] + d1 * axes[2, 1] + d2 * axes[2, 2]
        seen[i, 0] = 0.5 * columns + focus * (d0 * axes[0, 0] + d1 * axes[0, 1] + d2 * axes[0, 2]) / far
        seen[i, 1] = 0.5 * rows - focus * (d0 * axes[1, 0] + d1 * axes[1, 1] + d2 * axes[1, 2]) / far
        seen[i, 2] = far
    for t in range(triangles.shape[0]):
        i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        a, b, c = seen[i], seen[j], seen[k]
        if min(a[2], b[2], c[2]) <= 0.0:
            continue
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if area >= 0.0:  # seen from behind (rows run downwards)
            continue
        for r in range(max(0, int(min(a[1], b[1], c[1]))), min(rows - 1, int(max(a[1], b[1], c[1]))) + 1):
            for s in range(max(0, int(min(a[0], b[0], c[0]))), min(columns - 1, int(max(a[0], b[0], c[0]))) + 1):
                x, y = s + 0.5, r + 0.5
                u = ((b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x)) / area
                v = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / area
                w = 1.0 - u - v
                if u < 0.0 or v < 0.0 or w < 0.0:
                    continue
                far = 1.0 / (u / a[2] + v / b[2] + w / c[2])
                if far >= distance[r, s]:
                    continue
                distance[r, s] = far
                n0 = u * normals[i, 0] + v * normals[j, 0] + w * normals[k, 0]
                n1 = u * normals[i, 1] + v * normals[j, 1] + w * normals[k, 1]
                n2 = u * normals[i, 2] + v * normals[j, 2] + w * normals[k, 2]
                length = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
                facing = (n0 * light[0] + n1 * light[1] + n2 * light[2]) / length
                # Half-way vector of Blinn (1977), between the light and the eye.
                h0, h1, h2 = light[0] - axes[2, 0], light[1] - axes[2, 1], light[2] - axes[2, 2]
                half = np.sqrt(h0 * h0 + h1 * h1 + h2 * h2)
                mirror = max(0.0, (n0 * h0 + n1 * h1 + n2 * h2) / (length * half))
                bright = surface[0] + surface[1] * max(0.0, facing)
                gleam = surface[2] * mirror ** surface[3] if facing > 0.0 else 0.0
                for q in range(3):
                    colour[r, s, q] = bright * tint[q] + gleam
