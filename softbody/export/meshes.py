"""Meshes of bodies for other programs, under their titles: soft bodies as they are, boxes of twelve triangles."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import Any

import numpy as np

from softbody.errors import ParameterError
from softbody.export.looks import Look
from softbody.extras import library
from softbody.linalg.quaternion import rotation_matrix
from softbody.mesh.mesh import Mesh, box
from softbody.model.shapes import Pose, Shapes

Corners = tuple[np.ndarray, np.ndarray]  # vertices (n, 3) [m] and triangles (t, 3)
Shown = tuple[Look, Corners, np.ndarray]  # a body in a frame of its own, and that frame (4, 4) in the world's

ROUGHNESS = 0.8  # of surfaces in files: 0 is a mirror, 1 chalk
# glTF has y up: x stays, z becomes y.
Y_UP = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


def trimesh() -> Any:
    """Return what writes files; raises MissingPackageError."""
    return library("trimesh", "trimesh", "files", "writing mesh files")


def check_pose(pose: Pose) -> None:
    """Raise ParameterError unless all bodies are somewhere."""
    for name, rows in pose._asdict().items():
        if not np.isfinite(rows).all():
            row = int(np.argmin(np.isfinite(rows).all(axis=1)))
            raise ParameterError(f"{name}[{row}] is {rows[row]}, which no file can hold; set it to numbers")


def soft_mesh(shapes: Shapes, pose: Pose, body: int) -> Corners:
    """Return a soft body, in the world's frame."""
    return pose.particle_position[shapes.particles(body)], shapes.triangles(body)


def box_mesh(shapes: Shapes, body: int) -> Corners:
    """Return a box, in its own frame."""
    return _cube().vertices * shapes.box_size[body], _cube().triangles


def box_matrix(pose: Pose, body: int) -> np.ndarray:
    """Return the pose of a box as a matrix (4, 4), of its own frame to the world's."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation_matrix(pose.box_orientation[body])
    matrix[:3, 3] = pose.box_position[body]
    return matrix


def in_world(shapes: Shapes, pose: Pose) -> list[Any]:
    """Return all bodies as meshes of trimesh in the world's frame, soft bodies first."""
    soft = [_mesh(*soft_mesh(shapes, pose, body)) for body in range(shapes.soft_count)]
    boxes = [_mesh(*box_mesh(shapes, body)) for body in range(shapes.box_count)]
    return soft + [mesh.apply_transform(box_matrix(pose, body)) for body, mesh in enumerate(boxes)]


def soft_shown(look: Look, shapes: Shapes, pose: Pose, body: int) -> Shown:
    """Return how a soft body looks."""
    return look, soft_mesh(shapes, pose, body), np.eye(4)


def box_shown(look: Look, shapes: Shapes, pose: Pose, body: int) -> Shown:
    """Return how a box looks."""
    return look, box_mesh(shapes, body), box_matrix(pose, body)


def as_scene(bodies: Iterable[Shown]) -> Any:
    """Return a trimesh.Scene with a node for each body, in its colour, under one that puts y up."""
    scene = trimesh().Scene()
    scene.graph.update(frame_to="z_up", frame_from=scene.graph.base_frame, matrix=Y_UP)
    for shown in bodies:
        _add(scene, *shown)
    return scene


def _add(scene: Any, look: Look, corners: Corners, matrix: np.ndarray) -> None:
    mesh, visual = _mesh(*corners), trimesh().visual
    material = visual.material.PBRMaterial(
        name=look.title, baseColorFactor=[*look.colour, 1.0], metallicFactor=0.0, roughnessFactor=ROUGHNESS
    )
    mesh.visual = visual.TextureVisuals(material=material)
    scene.add_geometry(mesh, node_name=look.title, geom_name=look.title, parent_node_name="z_up", transform=matrix)


def _mesh(vertices: np.ndarray, triangles: np.ndarray) -> Any:
    return trimesh().Trimesh(vertices, triangles, process=False)


@cache
def _cube() -> Mesh:
    return box()
