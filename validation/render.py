"""What does a scene look like? A small rasteriser: no display, no graphics library, the same picture every time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from softbody.jit import jit, jit_lean

SUPERSAMPLING = 2  # each pixel is the mean of 2 × 2 samples
TEXELS = 512  # of the shadow map, each way: about as fine as the pixels of a scene that fills the picture
BIAS = 0.01  # [m] that a caster must be above what it shades: what touches is 0 apart, up to rounding

LIGHT = np.array([-0.55, -0.45, 1.0]) / np.linalg.norm([-0.55, -0.45, 1.0])  # where the light comes from
SLANT = LIGHT[:2] / LIGHT[2]  # how far a ray of it goes sideways [m] for each metre of height
SKY = np.array([0.93, 0.95, 0.98])
GROUND = np.array([[0.82, 0.84, 0.86], [0.74, 0.76, 0.79]])  # the two colours of its squares
AMBIENT, FROM_ABOVE = 0.36, 0.3  # light from all around, and how much more of it comes from above than from the side
DIFFUSE, SHINE = 0.65, 0.25
DOUBLINGS = 5  # of the highlight's exponent, from 1: 32, at a fifth of the cost of a power
SHADOW = 0.62  # of the ground's brightness
PALE = 0.62  # of white in the colour of stripes


@dataclass
class Thing:
    """One mesh to draw: `vertices` (n, 3) [m], `triangles` (t, 3), `colour` (3,) 0 … 1, smooth or faceted.

    `stripes` (n,): between the vertices it is linear, and where it is positive the surface is paler.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    colour: tuple[float, float, float]
    smooth: bool = True
    stripes: np.ndarray | None = None


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


class Film(NamedTuple):
    """What a picture is taken on: samples, and the camera that they belong to."""

    colour: np.ndarray  # (rows, columns, 3)
    distance: np.ndarray  # (rows, columns) along the view of what is seen [m]
    eye: np.ndarray  # (3,) [m]
    axes: np.ndarray  # (3, 3)
    focus: float  # focal length [samples]


class Shadow(NamedTuple):
    """How high the light is held up: a ray of light belongs to the texel in which it passes z = 0."""

    highest: np.ndarray  # (TEXELS, TEXELS) height of the highest underside that the ray meets [m], −inf for none
    low: np.ndarray  # (2,) corner of the map [m]
    step: float  # side of a texel [m]


class Faces(NamedTuple):
    """A thing as it is drawn."""

    vertices: np.ndarray  # (n, 3) [m]
    normals: np.ndarray  # (n, 3) unit vectors
    stripes: np.ndarray  # (n,)
    triangles: np.ndarray  # (t, 3)
    colours: np.ndarray  # (2, 3) beside the stripes, and of them


def render(things: list[Thing], camera: Camera, ground: float | None = 0.0) -> np.ndarray:
    """Return a picture (height, width, 3) of uint8; `ground` [m] is the height of a chequered floor, None for none."""
    height, width = SUPERSAMPLING * camera.height, SUPERSAMPLING * camera.width
    focus = 0.5 * height / np.tan(0.5 * np.radians(camera.view))
    colour, distance = np.empty((height, width, 3)), np.full((height, width), np.inf)
    film = Film(colour, distance, np.array(camera.eye, float), camera.axes(), float(focus))
    shadow = _shadow_of(things)
    for thing in things:
        faces = _faces_of(thing)
        _draw_faces(film, faces, _seen(film, faces.vertices), shadow)
    _draw_rest(film, -np.inf if ground is None else float(ground), shadow)
    return _shrunk(colour)


def _faces_of(thing: Thing) -> Faces:
    """Return vertices with normals and triangles of a thing; faceted things get corners of their own."""
    corners = thing.vertices[thing.triangles]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    stripes = np.full(len(thing.vertices), -1.0) if thing.stripes is None else thing.stripes
    if not thing.smooth:
        normals = np.repeat(areas, 3, axis=0)
        vertices, triangles = corners.reshape(-1, 3), np.arange(3 * len(areas)).reshape(-1, 3)
        stripes = stripes[thing.triangles].ravel()
    else:
        vertices, triangles = np.ascontiguousarray(thing.vertices), np.ascontiguousarray(thing.triangles)
        normals = np.zeros_like(vertices)
        for k in range(3):
            np.add.at(normals, triangles[:, k], areas)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    colour = np.array(thing.colour, float)
    colours = np.array([colour, (1.0 - PALE) * colour + PALE])
    return Faces(vertices, normals / np.where(length > 0.0, length, 1.0), stripes, triangles, colours)


def _shadow_of(things: list[Thing]) -> Shadow:
    """Return the shadow that all things cast together, on the ground and on each other."""
    highest = np.full((TEXELS, TEXELS), -np.inf)
    passing = [thing.vertices[:, :2] - thing.vertices[:, 2:] * SLANT for thing in things]
    if not passing:
        return Shadow(highest, np.zeros(2), 1.0)
    every = np.concatenate(passing)
    low = every.min(axis=0)
    step = float((every.max(axis=0) - low).max()) / (TEXELS - 2) + 1e-9  # a picture of one point has a step, too
    for thing, flat in zip(things, passing):
        _hold_up(highest, (flat - low) / step, thing.vertices[:, 2], np.ascontiguousarray(thing.triangles))
    return Shadow(highest, low, step)


@jit_lean
def _weights(a, b, c, x, y):
    """Return the barycentric weights of (x, y) in a triangle that has an area."""
    area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    u = ((b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x)) / area
    v = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / area
    return u, v, 1.0 - u - v


@jit_lean
def _span(a, b, c, axis, count):
    """Return the range of the `count` rows or columns that a triangle may cover."""
    first, last = int(min(a[axis], b[axis], c[axis])), int(max(a[axis], b[axis], c[axis]))
    return range(max(0, first), min(count - 1, last) + 1)


@jit_lean
def _faces_up(a, b, c):
    """Tell whether a triangle on a plane runs counter-clockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) >= 0.0


@jit_lean
def _hold_up(highest, flat, heights, triangles):
    """Enter the undersides of a thing, whose vertices are at texels `flat` (n, 2) and `heights` (n,) [m].

    Undersides alone, so that no surface in the light is shaded by itself, on a map that is coarser than it.
    """
    for t in range(triangles.shape[0]):
        i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        a, b, c = flat[i], flat[j], flat[k]
        if _faces_up(a, b, c):
            continue
        for x in _span(a, b, c, 0, highest.shape[0]):
            for y in _span(a, b, c, 1, highest.shape[1]):
                u, v, w = _weights(a, b, c, x + 0.5, y + 0.5)
                if u >= 0.0 and v >= 0.0 and w >= 0.0:
                    height = u * heights[i] + v * heights[j] + w * heights[k]
                    highest[x, y] = max(highest[x, y], height)


@jit_lean
def _light_at(shadow, x, y, z):
    """Return which part of the light reaches a point [m]: of the four texels around it, by their nearness.

    That is percentage-closer filtering (Reeves, Salesin and Cook 1987).
    """
    across = (x - z * SLANT[0] - shadow.low[0]) / shadow.step - 0.5
    along = (y - z * SLANT[1] - shadow.low[1]) / shadow.step - 0.5
    if not (0.0 <= across < TEXELS - 1.0 and 0.0 <= along < TEXELS - 1.0):
        return 1.0
    i, j = int(across), int(along)
    p, q = across - i, along - j
    high = shadow.highest
    dark = (1.0 - p) * (1.0 - q) * (high[i, j] > z + BIAS) + p * (1.0 - q) * (high[i + 1, j] > z + BIAS)
    dark += (1.0 - p) * q * (high[i, j + 1] > z + BIAS) + p * q * (high[i + 1, j + 1] > z + BIAS)
    return 1.0 - dark


@jit_lean
def _ray(film, row, column):
    """Return the direction (3,) in which a sample looks, of length 1 along the view."""
    rows, columns = film.distance.shape
    x, y = (column + 0.5 - 0.5 * columns) / film.focus, (0.5 * rows - row - 0.5) / film.focus
    right, up, forward = film.axes[0], film.axes[1], film.axes[2]
    return (
        x * right[0] + y * up[0] + forward[0],
        x * right[1] + y * up[1] + forward[1],
        x * right[2] + y * up[2] + forward[2],
    )


@jit_lean
def _draw_rest(film, height, shadow):
    """Draw the ground and the sky where nothing is nearer."""
    rows, columns = film.distance.shape
    eye = film.eye
    for r in range(rows):
        for s in range(columns):
            if film.distance[r, s] < np.inf:
                continue
            along = _ray(film, r, s)
            far = (height - eye[2]) / along[2] if along[2] < 0.0 else np.inf
            if not 0.0 < far < np.inf:
                for q in range(3):
                    film.colour[r, s, q] = SKY[q]
                continue
            x, y = eye[0] + far * along[0], eye[1] + far * along[1]
            square = (int(np.floor(x)) + int(np.floor(y))) & 1
            haze = min(1.0, far / 40.0)
            light = (1.0 - haze) * (SHADOW + (1.0 - SHADOW) * _light_at(shadow, x, y, height))
            for q in range(3):
                film.colour[r, s, q] = light * GROUND[square, q] + haze * SKY[q]


def _seen(film: Film, vertices: np.ndarray) -> np.ndarray:
    """Return column, row and distance along the view (n, 3) of vertices."""
    rows, columns = film.distance.shape
    right, up, far = film.axes @ (vertices - film.eye).T
    scale = film.focus / far
    return np.stack([0.5 * columns + scale * right, 0.5 * rows - scale * up, far], axis=1)


@jit_lean
def _draw_faces(film, faces, seen, shadow):
    """Draw the triangles that face the eye, where they are nearer than what is there."""
    rows, columns = film.distance.shape
    for t in range(faces.triangles.shape[0]):
        i, j, k = faces.triangles[t, 0], faces.triangles[t, 1], faces.triangles[t, 2]
        a, b, c = seen[i], seen[j], seen[k]
        if min(a[2], b[2], c[2]) <= 0.0 or _faces_up(a, b, c):  # rows run downwards: seen from behind
            continue
        for r in _span(a, b, c, 1, rows):
            for s in _span(a, b, c, 0, columns):
                u, v, w = _weights(a, b, c, s + 0.5, r + 0.5)
                if u < 0.0 or v < 0.0 or w < 0.0:
                    continue
                far = 1.0 / (u / a[2] + v / b[2] + w / c[2])
                if far >= film.distance[r, s]:
                    continue
                film.distance[r, s] = far
                weights = u * far / a[2], v * far / b[2], w * far / c[2]  # in space, not in the picture
                stripe, bright, gleam = _surface(faces, (i, j, k), weights, film.axes[2], shadow)
                for q in range(3):
                    film.colour[r, s, q] = bright * faces.colours[stripe, q] + gleam


@jit_lean
def _between(rows, corners, weights):
    """Return the weighted mean (3,) of three rows."""
    i, j, k = corners
    u, v, w = weights
    return (
        u * rows[i, 0] + v * rows[j, 0] + w * rows[k, 0],
        u * rows[i, 1] + v * rows[j, 1] + w * rows[k, 1],
        u * rows[i, 2] + v * rows[j, 2] + w * rows[k, 2],
    )


@jit_lean
def _surface(faces, corners, weights, view, shadow):
    """Return which colour a point of a triangle has, how bright that is, and the highlight on it, seen along `view`."""
    i, j, k = corners
    stripe = weights[0] * faces.stripes[i] + weights[1] * faces.stripes[j] + weights[2] * faces.stripes[k] > 0.0
    n0, n1, n2 = _between(faces.normals, corners, weights)
    length = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    bright = AMBIENT * (1.0 + FROM_ABOVE * n2 / length)
    facing = (n0 * LIGHT[0] + n1 * LIGHT[1] + n2 * LIGHT[2]) / length
    if facing <= 0.0:
        return int(stripe), bright, 0.0
    x, y, z = _between(faces.vertices, corners, weights)
    light = _light_at(shadow, x, y, z)
    # Half-way vector of Blinn (1977), between the light and the eye.
    h0, h1, h2 = LIGHT[0] - view[0], LIGHT[1] - view[1], LIGHT[2] - view[2]
    mirror = max(0.0, (n0 * h0 + n1 * h1 + n2 * h2) / (length * np.sqrt(h0 * h0 + h1 * h1 + h2 * h2)))
    for _ in range(DOUBLINGS):
        mirror *= mirror
    return int(stripe), bright + DIFFUSE * facing * light, SHINE * mirror * light


@jit
def _shrunk(colour):
    """Return the picture of a film's samples (rows, columns, 3), from 0 to 1: pixels (height, width, 3) of uint8."""
    rows, columns = colour.shape[0] // SUPERSAMPLING, colour.shape[1] // SUPERSAMPLING
    pixels = np.empty((rows, columns, 3), np.uint8)
    for r in range(rows):
        for s in range(columns):
            for q in range(3):
                total = 0.0
                for i in range(SUPERSAMPLING * r, SUPERSAMPLING * (r + 1)):
                    for j in range(SUPERSAMPLING * s, SUPERSAMPLING * (s + 1)):
                        total += colour[i, j, q]
                pixels[r, s, q] = round(255.0 * min(max(total / SUPERSAMPLING**2, 0.0), 1.0))
    return pixels
