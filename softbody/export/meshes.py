"""Which meshes are bodies, for another program? Soft bodies as they are, boxes of twelve triangles, all by name."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from softbody.errors import ParameterError
from softbody.extras import library
from softbody.mesh import Mesh, box
from softbody.quaternion import rotation_matrix
from softbody.shapes import Pose, Shapes

# glTF has y up: x stays, z becomes y.
Y_UP = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


def trimesh() -> Any:
    """Return what writes files; raises MissingPackageError."""
    return library("trimesh", "trimesh", "files", "writing mesh files")


def check_pose(shapes: Shapes, pose: Pose) -> None:
    """Raise ParameterError unless there is something to write, and it is somewhere."""
    if not shapes.soft_count + shapes.box_count:
        raise ParameterError("there are no bodies to export; add one first")
    for name, rows in pose._asdict().items():
        if not np.isfinite(rows).all():
            row = int(np.argmin(np.isfinite(rows).all(axis=1)))
            raise ParameterError(f"{name}[{row}] is {rows[row]}, which no file can hold; set it to numbers")


def soft_mesh(shapes: Shapes, pose: Pose, body: int) -> Any:
    """Return a soft body as a trimesh.Trimesh, in the world's frame."""
    vertices = pose.particle_position[shapes.particles(body)]
    return _mesh(f"soft_body_{body}", vertices, shapes.triangles(body))


def box_mesh(shapes: Shapes, body: int) -> Any:
    """Return a box as a trimesh.Trimesh, in its own frame."""
    return _mesh(f"box_{body}", _cube().vertices * shapes.box_size[body], _cube().triangles)


def box_matrix(pose: Pose, body: int) -> np.ndarray:
    """Return the pose of a box as a matrix (4, 4), of its own frame to the world's."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation_matrix(pose.box_orientation[body])
    matrix[:3, 3] = pose.box_position[body]
    return matrix


def in_world(shapes: Shapes, pose: Pose) -> list[Any]:
    """Return all bodies in the world's frame, soft bodies first."""
    meshes = [soft_mesh(shapes, pose, body) for body in range(shapes.soft_count)]
    boxes = [box_mesh(shapes, body) for body in range(shapes.box_count)]
    return meshes + [mesh.apply_transform(box_matrix(pose, body)) for body, mesh in enumerate(boxes)]


def as_scene(shapes: Shapes, pose: Pose) -> Any:
    """Return a trimesh.Scene with a node for each body, under one that puts y up."""
    scene = trimesh().Scene()
    scene.graph.update(frame_to="z_up", frame_from=scene.graph.base_frame, matrix=Y_UP)
    soft = [(soft_mesh(shapes, pose, body), np.eye(4)) for body in range(shapes.soft_count)]
    boxes = [(box_mesh(shapes, body), box_matrix(pose, body)) for body in range(shapes.box_count)]
    for mesh, matrix in soft + boxes:
        name = mesh.metadata["name"]
        scene.add_geometry(mesh, node_name=name, geom_name=name, parent_node_name="z_up", transform=matrix)
    return scene


def _mesh(name: str, vertices: np.ndarray, triangles: np.ndarray) -> Any:
    return trimesh().Trimesh(vertices, triangles, process=False, metadata={"name": name})


@cache
def _cube() -> Mesh:
    return box()
