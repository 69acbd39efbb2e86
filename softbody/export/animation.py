"""Animation in GLB files: boxes by the poses of their nodes, soft bodies by morph targets.

A soft body is its mesh in the first frame, and a morph target for each later one: what its vertices are then farther
on. At a frame's time the weight of its target is 1, all others 0; between frames, viewers go straight from one to the
next. This is what glTF 2.0 (§3.7.2.2, §3.11) has for shapes that change.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from softbody.compiler.interrupts import later
from softbody.errors import ParameterError
from softbody.export.looks import Looks
from softbody.export.meshes import as_scene, check_pose
from softbody.model.shapes import Pose, Shapes

MOST_FRAMES = 1000  # the table of weights has as many squared
FLOAT = 5126  # glTF's number for a float of four bytes
TYPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}  # by columns


def film_bytes(shapes: Shapes, looks: Looks, times: np.ndarray, poses: Iterable[Pose]) -> bytes:
    """Return a GLB file of `poses` at `times` (f,) [s]; of frames at the same time the first is shown."""
    seconds = (times - times[0]).astype(np.float32) if len(times) else np.zeros(0, np.float32)
    is_shown = np.append(True, np.diff(seconds) > 0.0)[: len(seconds)]
    if is_shown.sum() > MOST_FRAMES:
        every = -(-int(is_shown.sum()) // MOST_FRAMES)
        raise ParameterError(
            f"{is_shown.sum()} frames are too many for one GLB file, which may have {MOST_FRAMES}: take fewer, with "
            f"every={every}, or a .usdc file, or files one by one: export(folder, 'glb')"
        )
    kept = []
    for pose, is_one in zip(poses, is_shown):
        if is_one:
            check_pose(shapes, pose)
            kept.append(pose)
    moving = _Moving(shapes, looks, seconds[is_shown], kept)
    with later():
        scene = as_scene(shapes, looks, kept[0])
        added = moving.add_to if len(kept) > 1 else None
        return scene.export(file_type="glb", include_normals=False, buffer_postprocessor=added)


class _Moving:
    """What makes the tree of a GLB file move; `add_to` is called by trimesh, before it writes."""

    def __init__(self, shapes: Shapes, looks: Looks, seconds: np.ndarray, poses: list[Pose]) -> None:
        self._shapes, self._looks, self._seconds, self._poses = shapes, looks, seconds, poses

    def add_to(self, buffers: Any, tree: dict[str, Any]) -> None:
        """Add morph targets, and one animation, to a tree in which each body has a node of its title."""
        self._buffers, self._accessors = buffers, tree["accessors"]
        nodes = {node["name"]: k for k, node in enumerate(tree["nodes"])}
        self._animation: dict[str, Any] = {"name": "motion", "samplers": [], "channels": []}
        self._times = self._accessor("times", self._seconds[:, None], bounds=True)
        frames = len(self._poses)
        if self._shapes.soft_count:
            weights = self._accessor("weights", np.eye(frames, frames - 1, -1).reshape(-1, 1))
        for body, look in enumerate(self._looks.soft):
            node = nodes[look.title]
            mesh = tree["meshes"][tree["nodes"][node]["mesh"]]
            mesh["primitives"][0]["targets"] = [{"POSITION": each} for each in self._targets(body)]
            mesh["weights"] = [0.0] * (frames - 1)
            self._channel(node, "weights", weights)
        for body, look in enumerate(self._looks.boxes):
            node = nodes[look.title]
            places = np.array([pose.box_position[body] for pose in self._poses])
            turns = _nearest_signs(np.array([pose.box_orientation[body] for pose in self._poses]))[:, [1, 2, 3, 0]]
            tree["nodes"][node].pop("matrix", None)  # what is animated must not have one
            tree["nodes"][node] |= {"translation": places[0].tolist(), "rotation": turns[0].tolist()}
            if (places != places[0]).any():
                self._channel(node, "translation", self._accessor(f"places {body}", places))
            if (turns != turns[0]).any():
                self._channel(node, "rotation", self._accessor(f"turns {body}", turns))
        if self._animation["channels"]:
            tree["animations"] = [self._animation]

    def _targets(self, body: int) -> list[int]:
        """Return the accessors of how far a soft body's vertices are from the first frame, in each later one."""
        rows = self._shapes.particles(body)
        first = self._poses[0].particle_position[rows].astype(np.float32)
        return [
            self._accessor(f"soft body {body} at {k}", pose.particle_position[rows] - first, bounds=True)
            for k, pose in enumerate(self._poses[1:], 1)
        ]

    def _channel(self, node: int, path: str, values: int) -> None:
        sampler = {"input": self._times, "output": values, "interpolation": "LINEAR"}
        target = {"sampler": len(self._animation["samplers"]), "target": {"node": node, "path": path}}
        self._animation["samplers"].append(sampler)
        self._animation["channels"].append(target)

    def _accessor(self, name: str, rows: np.ndarray, bounds: bool = False) -> int:
        """Add an array (r, columns) to the file; return its number."""
        data = np.ascontiguousarray(rows, "<f4")
        self._buffers[name] = data.tobytes()
        entry: dict[str, Any] = {
            "bufferView": len(self._buffers) - 1,
            "componentType": FLOAT,
            "count": len(data),
            "type": TYPES[data.shape[1]],
        }
        if bounds:
            entry |= {"min": data.min(axis=0).tolist(), "max": data.max(axis=0).tolist()}
        self._accessors[name] = entry
        return len(self._accessors) - 1


def _nearest_signs(quaternions: np.ndarray) -> np.ndarray:
    """Return the same rotations (f, 4), each with the sign nearer to the one before: viewers take the short way."""
    turned = np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0.0
    signs = np.cumprod(np.append(1.0, np.where(turned, -1.0, 1.0)))
    return quaternions * signs[:, None]
