"""What the picture of a task shows: the bodies that its first question is about."""

from __future__ import annotations

from typing import Any

import numpy as np

from validation.cases import corners_of, rotation_matrix
from validation.league.record import Drawn
from validation.subject import Boxes, GasBody, SoftScene

# Faces of a box whose corners are numbered 4 x + 2 y + z, counter-clockwise from outside.
FACES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
DIGITS = 5


def drawn(question: tuple[Any, ...]) -> list[Drawn]:
    """Return the bodies of a question; none if it is about many pairs."""
    match question:
        case (Boxes() as boxes, *_):
            return _boxes(boxes, boxes.position[_free(boxes)], 0.5 * np.linalg.norm(boxes.size[_free(boxes)], axis=1))
        case (SoftScene() as scene, *_):
            soft = [_mesh(b.vertices, b.triangles, v.mean(axis=0)) for b, v in scene.rows()]
            boxes, places = scene.boxes, np.concatenate([body.vertices for body in scene.bodies])
            return soft + _boxes(boxes, places, np.zeros(len(places)))
        case (GasBody() as body, *_):
            return [_mesh(body.vertices, body.triangles, np.zeros(3))]
        case (points, vertices, triangles) if np.ndim(points) == 2:
            return [_mesh(vertices, triangles, np.zeros(3))]
    return []


def _free(boxes: Boxes) -> np.ndarray:
    free = np.isfinite(boxes.mass)
    return free if free.any() else np.ones(len(free), bool)


def _mesh(vertices: np.ndarray, triangles: np.ndarray, velocity: np.ndarray) -> Drawn:
    return Drawn(np.round(vertices, DIGITS).tolist(), triangles.tolist(), np.round(velocity, DIGITS).tolist())


def _boxes(boxes: Boxes, places: np.ndarray, radius: np.ndarray) -> list[Drawn]:
    """Return boxes, cut down to what is near some places with their radii."""
    middle = places.mean(axis=0)
    reach = 1.3 * float((np.linalg.norm(places - middle, axis=1) + radius).max())
    found = []
    for size, _, place, turn, velocity, _ in boxes.rows():
        matrix = rotation_matrix(turn)
        low, high = (np.clip(matrix.T @ (middle - place) + way * reach, -size / 2, size / 2) for way in (-1.0, 1.0))
        corners = (0.5 * (low + high) + corners_of(high - low)) @ matrix.T + place
        found.append(Drawn(np.round(corners, DIGITS).tolist(), FACES, np.round(velocity, DIGITS).tolist()))
    return found
