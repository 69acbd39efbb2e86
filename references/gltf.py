"""View of a glTF 2.0 file at a time, read by hand, as the specification (Khronos 2021) says.

Nodes stand in a tree (§3.5.2), each moved by its parent's; a mesh is its positions and, for each morph target, that
many times its weight (§3.7.2.2); animations move weights, places, turns and scales, linearly between frames or in
steps, and turns along the shortest arc (§3.11, Appendix C). What has a scale of 0 is not shown (§3.5.2). Only what is
asked of the core is read: the binary form, floats, triangles.
"""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

PACKAGES = {"scipy": "scipy"}  # import name, and the name to install it by

KINDS = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}  # §3.6.2.2
COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class Film:
    """A GLB file: what it shows, by the names of its nodes, in metres with z up."""

    def __init__(self, path: str | Path) -> None:
        raw = Path(path).read_bytes()
        magic, version, length, size, kind = struct.unpack_from("<4sIII4s", raw)
        if (magic, version, length, kind) != (b"glTF", 2, len(raw), b"JSON"):
            raise ValueError(f"{path} is no binary glTF 2.0")
        self._tree: dict[str, Any] = json.loads(raw[20 : 20 + size])
        self._data = raw[28 + size :]

    def shown(self, time: float = 0.0) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Return vertices (n, 3) [m] and triangles (t, 3) of each node that has a mesh, at a time [s]."""
        tree = self._tree
        moved: dict[int, dict[str, np.ndarray]] = {}
        for animation in tree.get("animations", []):
            for channel in animation["channels"]:
                sampler, target = animation["samplers"][channel["sampler"]], channel["target"]
                moved.setdefault(target["node"], {})[target["path"]] = self._value(sampler, target["path"], time)
        found: dict[str, tuple[np.ndarray, np.ndarray]] = {}
        for root in tree["scenes"][tree.get("scene", 0)]["nodes"]:
            self._walk(root, np.eye(4), moved, found)
        return found

    def colours(self) -> dict[str, np.ndarray]:
        """Return the colour (3,) of each node that has a mesh, as shares of light: white where none is said."""
        tree, found = self._tree, {}
        for node in tree["nodes"]:
            if "mesh" in node:
                (part,) = tree["meshes"][node["mesh"]]["primitives"]
                material = tree["materials"][part["material"]] if "material" in part else {}
                colour = material.get("pbrMetallicRoughness", {}).get("baseColorFactor", (1.0, 1.0, 1.0, 1.0))
                found[node["name"]] = np.array(colour[:3], float)
        return found

    def weights(self) -> list[tuple[int, int]]:
        """Return how many weights, and how many morph targets, each mesh has: as many (§3.7.2.2)."""
        found = []
        for mesh in self._tree["meshes"]:
            targets = [len(part.get("targets", ())) for part in mesh["primitives"]]
            found += [(len(mesh.get("weights", [0.0] * count)), count) for count in targets]
        return found

    def long_turns(self) -> int:
        """Return between how many frames turns go the long way, for viewers that do not look for the short one."""
        samplers = [
            animation["samplers"][channel["sampler"]]
            for animation in self._tree.get("animations", [])
            for channel in animation["channels"]
            if channel["target"]["path"] == "rotation"
        ]
        turns = [self._array(sampler["output"]) for sampler in samplers]
        return sum(int((np.sum(rows[1:] * rows[:-1], axis=1) < 0.0).sum()) for rows in turns)

    def _walk(
        self,
        number: int,
        above: np.ndarray,
        moved: dict[int, dict[str, np.ndarray]],
        found: dict[str, tuple[np.ndarray, np.ndarray]],
    ) -> None:
        """Add what a node and those below it show."""
        node = self._tree["nodes"][number] | moved.get(number, {})
        matrix = above @ _matrix(node)
        if not np.any(node.get("scale", 1.0)):
            return
        if "mesh" in node:
            mesh = self._tree["meshes"][node["mesh"]]
            (part,) = mesh["primitives"]
            vertices = self._array(part["attributes"]["POSITION"])
            weights = node.get("weights", mesh.get("weights", ()))
            for weight, target in zip(weights, part.get("targets", ())):
                if weight:
                    vertices = vertices + weight * self._array(target["POSITION"])
            x, y, z = (vertices @ matrix[:3, :3].T + matrix[:3, 3]).T
            triangles = self._array(part["indices"]).astype(np.int64).reshape(-1, 3)
            found[node["name"]] = np.stack([x, -z, y], axis=1), triangles  # y is up there
        for child in node.get("children", ()):
            self._walk(child, matrix, moved, found)

    def _value(self, sampler: dict[str, Any], path: str, time: float) -> np.ndarray:
        """Return what a sampler says at a time."""
        times = self._array(sampler["input"])[:, 0]
        rows = self._array(sampler["output"]).reshape(len(times), -1)
        now = np.clip(time, times[0], times[-1])
        if sampler.get("interpolation") == "STEP":
            return np.asarray(rows[np.searchsorted(times, now, side="right") - 1])
        if sampler.get("interpolation", "LINEAR") != "LINEAR":
            raise ValueError(f"the interpolation is {sampler['interpolation']}, which is not read here")
        if len(times) == 1:
            return np.asarray(rows[0])
        if path == "rotation":
            return np.asarray(Slerp(times, Rotation.from_quat(rows))(now).as_quat())
        return np.array([np.interp(now, times, column) for column in rows.T])

    def _array(self, number: int) -> np.ndarray:
        """Return the rows of an accessor (§3.6.2)."""
        accessor = self._tree["accessors"][number]
        view = self._tree["bufferViews"][accessor["bufferView"]]
        columns, kind = COLUMNS[accessor["type"]], KINDS[accessor["componentType"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        return np.frombuffer(self._data, kind, accessor["count"] * columns, start).reshape(-1, columns).astype(float)


def _matrix(node: dict[str, Any]) -> np.ndarray:
    """Return the matrix (4, 4) of a node, which has one, or a place and a turn (x, y, z, w)."""
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(node.get("rotation", (0.0, 0.0, 0.0, 1.0))).as_matrix()
    matrix[:3, :3] *= node.get("scale", (1.0, 1.0, 1.0))
    matrix[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return matrix
