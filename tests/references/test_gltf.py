"""Is glTF read as its specification says? A file of two frames, written here by hand."""

import json
import struct

import numpy as np
import pytest
from numpy.testing import assert_allclose

from references import gltf

HALF = 2.0**-0.5


def written(path, interpolation="LINEAR", scale=(1, 1, 1)):
    """A triangle that moves by a morph target, below a node that shifts it and turns by 90° about y, in a second."""
    arrays = [
        np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], "<f4"),
        np.array([0, 1, 2], "<u2"),
        np.array([(0, 0, 2), (0, 0, 0), (0, 0, 0)], "<f4"),
        np.array([0.0, 1.0], "<f4"),
        np.array([0.0, 1.0], "<f4"),
        np.array([(0, 0, 0, 1), (0, HALF, 0, HALF)], "<f4"),
    ]
    kinds = [("VEC3", 5126), ("SCALAR", 5123), ("VEC3", 5126), ("SCALAR", 5126), ("SCALAR", 5126), ("VEC4", 5126)]
    data, views, accessors = b"", [], []
    for k, (array, (kind, number)) in enumerate(zip(arrays, kinds)):
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
        accessors.append({"bufferView": k, "componentType": number, "count": len(array), "type": kind})
        data += array.tobytes() + b"\0" * (-array.nbytes % 4)
    part = {"attributes": {"POSITION": 0}, "indices": 1, "targets": [{"POSITION": 2}]}
    channels = [
        {"sampler": 0, "target": {"node": 1, "path": "weights"}},
        {"sampler": 1, "target": {"node": 0, "path": "rotation"}},
    ]
    tree = {
        "scenes": [{"nodes": [0]}],
        "nodes": [{"translation": [5, 0, 0], "children": [1]}, {"name": "leaf", "mesh": 0, "scale": scale}],
        "meshes": [{"primitives": [part], "weights": [0.0]}],
        "animations": [
            {
                "samplers": [{"input": 3, "output": 4, "interpolation": interpolation}, {"input": 3, "output": 5}],
                "channels": channels,
            }
        ],
        "accessors": accessors,
        "bufferViews": views,
    }
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)


def test_shapes_weights_and_turns_at_a_time(tmp_path):
    written(tmp_path / "a.glb")
    film = gltf.Film(tmp_path / "a.glb")
    vertices, triangles = film.shown(0.0)["leaf"]
    assert_allclose(vertices, [(5, 0, 0), (6, 0, 0), (5, 0, 1)], atol=1e-7)  # y up there is z up here
    assert triangles.tolist() == [[0, 1, 2]]
    half, _ = film.shown(0.5)["leaf"]  # by 45° about what is up; the first corner half-way to its target
    assert_allclose(half, [(5 + HALF, -HALF, 0), (5 + HALF, HALF, 0), (5, 0, 1)], atol=1e-6)
    end, _ = film.shown(7.0)["leaf"]
    assert_allclose(end, [(7, 0, 0), (5, 1, 0), (5, 0, 1)], atol=1e-6)


def test_steps_hold_until_the_next(tmp_path):
    written(tmp_path / "a.glb", "STEP")
    film = gltf.Film(tmp_path / "a.glb")
    for time, height in ((0.0, 0.0), (0.999, 0.0), (1.0, 2.0), (7.0, 2.0)):
        places = film.shown(time)["leaf"][0] - (5.0, 0.0, 0.0)
        assert_allclose(np.linalg.norm(places[0]), height, atol=1e-6)


def test_what_has_no_size_is_not_shown(tmp_path):
    for scale, names in (((0, 0, 0), set()), ((1, 1, 0), {"leaf"})):
        written(tmp_path / "a.glb", scale=scale)
        assert set(gltf.Film(tmp_path / "a.glb").shown()) == names


def test_what_is_not_read_is_said(tmp_path):
    written(tmp_path / "a.glb", "CUBICSPLINE")
    with pytest.raises(ValueError, match="CUBICSPLINE"):
        gltf.Film(tmp_path / "a.glb").shown(0.5)
    (tmp_path / "b.glb").write_bytes(b"glTF" + bytes(20))
    with pytest.raises(ValueError, match="no binary glTF"):
        gltf.Film(tmp_path / "b.glb")
