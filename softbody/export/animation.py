"""Animation in GLB files: boxes by the poses of their nodes, soft bodies by morph targets, what is there by scales.

A soft body is its mesh in its first frame, and a morph target for each later one: what its vertices are then farther
on. At a frame's time the weight of its target is 1, all others 0; between frames, viewers go straight from one to the
next. This is what glTF 2.0 (§3.7.2.2, §3.11) has for shapes that change. A body that is not there has a scale of 0
(§3.5.2), in steps.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import compress
from typing import Any

import numpy as np

from softbody.compiler.interrupts import later
from softbody.errors import ParameterError
from softbody.export.film import Actor, actors_of
from softbody.export.meshes import as_scene, check_pose
from softbody.model.shapes import Cast, Pose

MOST_FRAMES = 1000  # the table of weights has as many squared
FLOAT = 5126  # glTF's number for a float of four bytes
TYPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}  # by columns


def film_bytes(times: np.ndarray, casts: Sequence[Cast], poses: Iterable[Pose]) -> bytes:
    """Return a GLB file of `poses` at `times` (f,) [s], one at least; of frames at the same time the first is shown."""
    seconds = (times - times[0]).astype(np.float32)
    is_shown = np.append(True, np.diff(seconds) > 0.0)
    if is_shown.sum() > MOST_FRAMES:
        every = -(-int(is_shown.sum()) // MOST_FRAMES)
        raise ParameterError(
            f"{is_shown.sum()} frames are too many for one GLB file, which may have {MOST_FRAMES}: take fewer, with "
            f"every={every}, or a .usdc file, or files one by one: export(folder, 'glb')"
        )
    casts, kept = list(compress(casts, is_shown)), list(compress(poses, is_shown))
    for pose in kept:
        check_pose(pose)
    actors = actors_of(casts)
    moving = _Moving(actors, seconds[is_shown], casts, kept)
    with later():
        scene = as_scene(actor.shown(casts[actor.start], kept[actor.start], actor.start) for actor in actors)
        added = moving.add_to if len(kept) > 1 else None
        return scene.export(file_type="glb", include_normals=False, buffer_postprocessor=added)


class _Moving:
    """What makes the tree of a GLB file move; `add_to` is called by trimesh, before it writes."""

    def __init__(self, actors: list[Actor], seconds: np.ndarray, casts: list[Cast], poses: list[Pose]) -> None:
        self._actors, self._seconds, self._casts, self._poses = actors, seconds, casts, poses

    def add_to(self, buffers: Any, tree: dict[str, Any]) -> None:
        """Add morph targets, and one animation, to a tree in which each body has a node of its title."""
        self._buffers, self._tree, self._accessors = buffers, tree, tree["accessors"]
        self._animation: dict[str, Any] = {"name": "motion", "samplers": [], "channels": []}
        self._times, self._weights = dict[tuple[int, int], int](), dict[int, int]()
        nodes = {node["name"]: k for k, node in enumerate(tree["nodes"])}
        for actor in self._actors:
            node = nodes[actor.look.title]
            if actor.is_soft:
                self._shape(node, actor)
            else:
                self._place(node, actor)
            self._show(node, actor)
        if self._animation["channels"]:
            tree["animations"] = [self._animation]

    def _shape(self, node: int, actor: Actor) -> None:
        """Give a soft body its shapes."""
        frames = len(actor.numbers)
        if frames == 1:
            return
        if frames not in self._weights:
            table = np.eye(frames, frames - 1, -1)
            self._weights[frames] = self._accessor(f"weights of {frames}", table.reshape(-1, 1))
        mesh = self._tree["meshes"][self._tree["nodes"][node]["mesh"]]
        mesh["primitives"][0]["targets"] = [{"POSITION": each} for each in self._targets(actor)]
        mesh["weights"] = [0.0] * (frames - 1)
        self._channel(node, "weights", self._times_of(actor), self._weights[frames])

    def _targets(self, actor: Actor) -> list[int]:
        """Return the accessors of how far a soft body's vertices are from its first frame, in each later one."""
        frames = range(actor.start, actor.stop)
        rows = [self._casts[k].shapes.particles(number) for k, number in zip(frames, actor.numbers)]
        points = [self._poses[k].particle_position[each] for k, each in zip(frames, rows)]
        first = points[0].astype(np.float32)
        return [
            self._accessor(f"{actor.look.title} at {k}", now - first, bounds=True)
            for k, now in zip(frames[1:], points[1:])
        ]

    def _place(self, node: int, actor: Actor) -> None:
        """Give a box its places and turns."""
        poses = list(zip(self._poses[actor.start :], actor.numbers))
        places = np.array([pose.box_position[body] for pose, body in poses])
        turns = _nearest_signs(np.array([pose.box_orientation[body] for pose, body in poses]))[:, [1, 2, 3, 0]]
        entry = self._tree["nodes"][node]
        entry.pop("matrix", None)  # what is animated must not have one
        entry |= {"translation": places[0].tolist(), "rotation": turns[0].tolist()}
        for path, rows in (("translation", places), ("rotation", turns)):
            if (rows != rows[0]).any():
                self._channel(node, path, self._times_of(actor), self._accessor(f"{path} of {actor.look.title}", rows))

    def _show(self, node: int, actor: Actor) -> None:
        """Let a body be seen in its frames only."""
        changes = actor.changes(len(self._poses))
        if not changes:
            return
        scales = np.repeat([[float(is_there)] for is_there in changes.values()], 3, axis=1)
        entry, title = self._tree["nodes"][node], actor.look.title
        entry.pop("matrix", None)  # of a soft body, which has no pose
        entry["scale"] = scales[0].tolist()
        times = self._accessor(f"changes of {title}", self._seconds[list(changes), None], bounds=True)
        self._channel(node, "scale", times, self._accessor(f"scales of {title}", scales), "STEP")

    def _times_of(self, actor: Actor) -> int:
        """Return the accessor of the times of a body's frames."""
        frames = actor.start, actor.stop
        if frames not in self._times:
            name = "times {} to {}".format(*frames)
            self._times[frames] = self._accessor(name, self._seconds[slice(*frames), None], bounds=True)
        return self._times[frames]

    def _channel(self, node: int, path: str, times: int, values: int, interpolation: str = "LINEAR") -> None:
        sampler = {"input": times, "output": values, "interpolation": interpolation}
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
