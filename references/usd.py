"""View of an OpenUSD stage at a time: its text is read by hand, as the specification has it.

Only what is asked of the core is read: meshes of triangles under one root, whose points, place and turn have a value,
or one at each of some time codes, between which points and places go straight (§ on interpolation) and turns by the
shortest arc; what is invisible is not shown, until a time code at which it is. What is not text is printed as text by
OpenUSD's own reader (usd-core).
"""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

PACKAGES = {"pxr": "usd-core"}  # import name, and the name to install it by

MESH = re.compile(r'def Mesh "(?P<name>[^"]*)" \((?P<head>.*?)\n    \)\n    \{(?P<body>.*?)\n    \}', re.DOTALL)
TITLE = re.compile(r"displayName = (?P<text>\".*\"|'.*')")


class Stage:
    """A file: what it shows, by the titles of its meshes, in metres with z up."""

    def __init__(self, path: str | Path) -> None:
        raw = Path(path).read_bytes()
        text = raw.decode() if raw.startswith(b"#usda 1.0") else _printed(path)
        head = text.partition("def ")[0]
        if 'upAxis = "Z"' not in head:
            raise ValueError(f"{path} has not z up")
        self._metre = float(_of("metersPerUnit", head) or 0.01)
        self._rate = float(_of("timeCodesPerSecond", head) or 24.0)
        self._meshes = {}
        for found in MESH.finditer(text):
            title = TITLE.search(found["head"])
            self._meshes[ast.literal_eval(title["text"]) if title else found["name"]] = found["body"]

    def shown(self, time: float = 0.0) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Return vertices (n, 3) [m] and triangles (t, 3) of each mesh, at a time [s]."""
        code = time * self._rate
        return {title: self._mesh(body, code) for title, body in self._meshes.items() if _is_visible(body, code)}

    def colours(self) -> dict[str, np.ndarray]:
        """Return the colour (3,) of each mesh, as shares of light."""
        return {title: _rows(_of("primvars:displayColor", body))[0] for title, body in self._meshes.items()}

    def _mesh(self, body: str, code: float) -> tuple[np.ndarray, np.ndarray]:
        counts = set(ast.literal_eval(_of("faceVertexCounts", body)))
        if counts != {3}:
            raise ValueError(f"faces have {counts} corners, and only triangles are read here")
        triangles = np.array(ast.literal_eval(_of("faceVertexIndices", body)), np.int64).reshape(-1, 3)
        vertices = _at(body, "points", code)
        order = ast.literal_eval(_of("xformOpOrder", body) or "[]")
        for step in reversed(order):  # the last is applied first
            value = _at(body, step, code)
            if step == "xformOp:orient":
                vertices = vertices @ Rotation.from_quat(np.roll(value, -1)).as_matrix().T
            elif step == "xformOp:translate":
                vertices = vertices + value
            else:
                raise ValueError(f"{step} is not read here")
        return self._metre * vertices, triangles


def _is_visible(body: str, code: float) -> bool:
    """Tell whether a mesh is shown at a time code: words hold until the next one."""
    samples = ast.literal_eval(_of("visibility.timeSamples", body) or "{}")
    said = [word for at, word in samples.items() if at <= code] or list(samples.values())[:1]
    return "invisible" not in said[-1:]


def _at(body: str, name: str, code: float) -> np.ndarray:
    """Return the value of an attribute at a time code."""
    still = _of(name, body)
    if still:
        return _rows(still)
    samples = ast.literal_eval(_of(f"{name}.timeSamples", body))
    codes, values = np.array(list(samples)), [np.array(value) for value in samples.values()]
    now = float(np.clip(code, codes[0], codes[-1]))
    if name == "xformOp:orient" and len(codes) > 1:
        turns = Rotation.from_quat(np.roll(values, -1, axis=1))
        return np.roll(Slerp(codes, turns)(now).as_quat(), 1)
    after = min(int(np.searchsorted(codes, now)), len(codes) - 1)
    before = max(after - 1, 0)
    part = (now - codes[before]) / (codes[after] - codes[before]) if after > before else 0.0
    return np.asarray((1.0 - part) * values[before] + part * values[after])


def _of(name: str, text: str) -> str:
    """Return what is written of an attribute, or nothing."""
    values = r"\{.*?\n\s*\}|\[.*?\](?=\n|$)|\(.*?\)(?=\s)|\S+"
    found = re.search(rf"(?:^|[\s(]){re.escape(name)} = ({values})", text, re.DOTALL)
    return found[1] if found else ""


def _rows(text: str) -> np.ndarray:
    return np.array(ast.literal_eval(text), float)


def _printed(path: str | Path) -> str:
    """Return a binary file as text."""
    from pxr import Sdf

    layer: Any = Sdf.Layer.OpenAsAnonymous(str(path))
    if layer is None:
        raise ValueError(f"{path} is no file of OpenUSD")
    return str(layer.ExportToString())
