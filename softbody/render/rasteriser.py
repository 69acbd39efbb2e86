"""Small rasteriser of scenes: no display, no graphics library, the same picture every time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from softbody.compiler.jit import jit, jit_lean
from softbody.render.camera import Camera
from softbody.render.coverage import faces_up, span, weights_at
from softbody.render.shadow import LIGHT, light_at, shadow_of

SUPERSAMPLING = 2  # each pixel is the mean of 2 × 2 samples

SKY = np.array([0.93, 0.95, 0.98])
GROUND = np.array([[0.82, 0.84, 0.86], [0.74, 0.76, 0.79]])  # the two colours of its squares
AMBIENT, FROM_ABOVE = 0.36, 0.3  # light from all around, and how much more of it comes from above than from the side
DIFFUSE, SHINE = 0.65, 0.25
DOUBLINGS = 5  # of the highlight's exponent, from 1: 32, at a fifth of the cost of a power
SHADOW = 0.62  # of the ground's brightness
CLEAR = 0.2  # how much of its own colour covers what is behind the near side of a thing that is clear
LIQUID, MURK = np.array([0.36, 0.6, 0.78]), 0.45  # its colour, and how much of that covers what is below it
HAZE = 40.0  # squares of the ground away it has the colour of the sky


@dataclass
class Thing:
    """One mesh to draw: `vertices` (n, 3) [m], `triangles` (t, 3), smooth or faceted.

    `colours` (3,), or (k, 3) of which `along` (n,) chooses: from 0, the first, to 1, the last, linear between the
    vertices. Colours are red, green and blue, 0 … 1.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    colours: ArrayLike
    smooth: bool = True
    along: np.ndarray | None = None
    casts_shadow: bool = True
    is_clear: bool = False  # one looks into it


class Film(NamedTuple):
    """What a picture is taken on: samples, and the camera that they belong to."""

    colour: np.ndarray  # (rows, columns, 3)
    distance: np.ndarray  # (rows, columns) along the view of what is seen [m]
    eye: np.ndarray  # (3,) [m]
    axes: np.ndarray  # (3, 3)
    focus: float  # focal length [samples]
    square: float  # side of those of the ground [m]


class Faces(NamedTuple):
    """A thing as it is drawn."""

    vertices: np.ndarray  # (n, 3) [m]
    normals: np.ndarray  # (n, 3) unit vectors
    along: np.ndarray  # (n,) 0 … 1: which of the colours
    triangles: np.ndarray  # (t, 3)
    colours: np.ndarray  # (k, 3)


def render(
    things: Sequence[Thing],
    camera: Camera,
    ground: float | None = 0.0,
    size: tuple[int, int] = (480, 360),
    liquid: float | None = None,
) -> np.ndarray:
    """Return a picture (height, width, 3) of uint8, of `size` (width, height) [pixels].

    `ground` [m] is the height of a chequered floor, None for none: its squares have sides of 1 m, or a power of ten of
    that where the camera is nearer to its target than 2 m, or farther than 20 m.
    `liquid` [m] is the height of a surface through which the rest is seen, None for none.
    """
    height, width = SUPERSAMPLING * size[1], SUPERSAMPLING * size[0]
    focus = 0.5 * height / np.tan(0.5 * np.radians(camera.view))
    colour, distance = np.empty((height, width, 3)), np.full((height, width), np.inf)
    square = side_of_squares(camera)
    film = Film(colour, distance, np.array(camera.eye, float), camera.axes(), float(focus), square)
    shadow = shadow_of([(thing.vertices, thing.triangles) for thing in things if thing.casts_shadow], square)
    for thing in things:
        faces = _inside_out(_faces_of(thing)) if thing.is_clear else _faces_of(thing)
        _draw_faces(film, faces, _seen(film, faces.vertices), shadow, 1.0)
    _draw_rest(film, -np.inf if ground is None else float(ground), shadow)
    for thing in things:
        if thing.is_clear:
            faces = _faces_of(thing)
            _draw_faces(film, faces, _seen(film, faces.vertices), shadow, CLEAR)
    if liquid is not None:
        _draw_surface(film, float(liquid), -np.inf if ground is None else float(ground))
    return _shrunk(colour)


def side_of_squares(camera: Camera) -> float:
    """Return the side [m] of the ground's squares: the power of ten that is 2 to 20 times in the camera's distance."""
    away = float(np.linalg.norm(np.subtract(camera.eye, camera.target)))
    return float(10.0 ** np.floor(np.log10(away / 2.0)))


def _faces_of(thing: Thing) -> Faces:
    """Return vertices with normals and triangles of a thing; faceted things get corners of their own."""
    corners = thing.vertices[thing.triangles]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    along = np.zeros(len(thing.vertices)) if thing.along is None else thing.along
    if not thing.smooth:
        normals = np.repeat(areas, 3, axis=0)
        vertices, triangles = corners.reshape(-1, 3), np.arange(3 * len(areas)).reshape(-1, 3)
        along = along[thing.triangles].ravel()
    else:
        vertices, triangles = np.ascontiguousarray(thing.vertices), np.ascontiguousarray(thing.triangles)
        normals = np.zeros_like(vertices)
        for k in range(3):
            np.add.at(normals, triangles[:, k], areas)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    colours = np.atleast_2d(np.asarray(thing.colours, float))
    return Faces(vertices, normals / np.where(length > 0.0, length, 1.0), along, triangles, colours)


def _inside_out(faces: Faces) -> Faces:
    """Return the far side of a thing, as it is seen from within."""
    return faces._replace(normals=-faces.normals, triangles=np.ascontiguousarray(faces.triangles[:, ::-1]))


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
            square = (int(np.floor(x / film.square)) + int(np.floor(y / film.square))) & 1
            haze = min(1.0, far / (HAZE * film.square))
            light = (1.0 - haze) * (SHADOW + (1.0 - SHADOW) * light_at(shadow, x, y, height))
            for q in range(3):
                film.colour[r, s, q] = light * GROUND[square, q] + haze * SKY[q]


@jit_lean
def _draw_surface(film, level, height):
    """Cover what is seen through the surface of a liquid; the ground is at a `height`."""
    rows, columns = film.distance.shape
    eye = film.eye
    for r in range(rows):
        for s in range(columns):
            along = _ray(film, r, s)
            far = (level - eye[2]) / along[2] if along[2] < 0.0 else np.inf
            there = min(film.distance[r, s], (height - eye[2]) / along[2] if along[2] < 0.0 else np.inf)
            if 0.0 < far < there:
                haze = min(1.0, far / (HAZE * film.square))
                for q in range(3):
                    tint = (1.0 - haze) * LIQUID[q] + haze * SKY[q]
                    film.colour[r, s, q] = (1.0 - MURK) * film.colour[r, s, q] + MURK * tint


def _seen(film: Film, vertices: np.ndarray) -> np.ndarray:
    """Return column, row and distance along the view (n, 3) of vertices."""
    rows, columns = film.distance.shape
    right, up, far = film.axes @ (vertices - film.eye).T
    scale = film.focus / far
    return np.stack([0.5 * columns + scale * right, 0.5 * rows - scale * up, far], axis=1)


@jit_lean
def _draw_faces(film, faces, seen, shadow, cover):
    """Draw the triangles that face the eye, where they are nearer than what is there.

    Of a `cover` below 1 they cover no more than that part of it, and are not there for what comes after.
    """
    rows, columns = film.distance.shape
    for t in range(faces.triangles.shape[0]):
        i, j, k = faces.triangles[t, 0], faces.triangles[t, 1], faces.triangles[t, 2]
        a, b, c = seen[i], seen[j], seen[k]
        if min(a[2], b[2], c[2]) <= 0.0 or faces_up(a, b, c):  # rows run downwards: seen from behind
            continue
        for r in span(a, b, c, 1, rows):
            for s in span(a, b, c, 0, columns):
                u, v, w = weights_at(a, b, c, s + 0.5, r + 0.5)
                if u < 0.0 or v < 0.0 or w < 0.0:
                    continue
                far = 1.0 / (u / a[2] + v / b[2] + w / c[2])
                if far >= film.distance[r, s]:
                    continue
                if cover == 1.0:
                    film.distance[r, s] = far
                weights = u * far / a[2], v * far / b[2], w * far / c[2]  # in space, not in the picture
                colour, bright, gleam = _surface(faces, (i, j, k), weights, film.axes[2], shadow)
                for q in range(3):
                    shade = bright * faces.colours[colour, q] + gleam
                    film.colour[r, s, q] = (
                        shade if cover == 1.0 else (1.0 - cover) * film.colour[r, s, q] + cover * shade
                    )


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
    along = weights[0] * faces.along[i] + weights[1] * faces.along[j] + weights[2] * faces.along[k]
    colour = int(len(faces.colours) * min(max(along, 0.0), 1.0 - 1e-9))
    n0, n1, n2 = _between(faces.normals, corners, weights)
    length = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    bright = AMBIENT * (1.0 + FROM_ABOVE * n2 / length)
    facing = (n0 * LIGHT[0] + n1 * LIGHT[1] + n2 * LIGHT[2]) / length
    if facing <= 0.0:
        return colour, bright, 0.0
    x, y, z = _between(faces.vertices, corners, weights)
    light = light_at(shadow, x, y, z)
    # Half-way vector of Blinn (1977), between the light and the eye.
    h0, h1, h2 = LIGHT[0] - view[0], LIGHT[1] - view[1], LIGHT[2] - view[2]
    mirror = max(0.0, (n0 * h0 + n1 * h1 + n2 * h2) / (length * np.sqrt(h0 * h0 + h1 * h1 + h2 * h2)))
    for _ in range(DOUBLINGS):
        mirror *= mirror
    return colour, bright + DIFFUSE * facing * light, SHINE * mirror * light


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
