"""Does a film of bodies that come and go show each in its frames only, under a title of its own?"""

import json
import os

import numpy as np
import pytest

import softbody
from softbody import ParameterError, Trajectory, TrajectoryWriter, World

trimesh = pytest.importorskip("trimesh")

pytestmark = pytest.mark.interpreted

# What is seen at each of six frames; "ball" has another mesh from the fourth on.
SEEN = [
    {"ball", "box_0"},
    {"ball", "box_0", "box_1"},
    {"ball", "box_0", "box_1"},
    {"ball from frame 3", "box_0 from frame 3"},
    set(),
    {"ball from frame 5"},
]


@pytest.fixture
def kept(tmp_path):
    """A trajectory, of 32 frames a second: a ball and boxes, of which one goes, then all; then another ball comes."""
    world = World()
    ball = world.add_soft_body(softbody.octahedron(), 1.0, 100.0, 10.0, (0.0, 0.0, 2.0), name="ball")
    first = world.add_box((1.0, 1.0, 1.0), 1.0, (9.0, 0.0, 2.0))
    with TrajectoryWriter(world, tmp_path / "t") as writer:
        for k in range(6):
            if k == 1:
                second = world.add_box((1.0, 2.0, 1.0), 1.0, (19.0, 0.0, 2.0))
            elif k == 3:
                world.remove(ball)
                world.remove(first)
                ball = world.add_soft_body(softbody.tetrahedron(), 1.0, 100.0, 10.0, (0.0, 0.0, 2.0), name="ball")
            elif k == 4:
                world.remove(ball)
                world.remove(second)
            elif k == 5:
                world.add_soft_body(softbody.tetrahedron(), 1.0, 100.0, 10.0, (0.0, 0.0, 2.0), name="ball")
            world.state.particle_position[:, 0] += 0.1 * k
            world.state.box_position[:, 0] += 0.1 * k
            world.time = k / 32.0
            writer.frame()
    return Trajectory.open(tmp_path / "t")


def titles_at(tree, data, k):
    """Return the names of nodes that have a mesh, and no scale of 0 at the time of a frame."""

    def rows(number):
        accessor = tree["accessors"][number]
        start = tree["bufferViews"][accessor["bufferView"]].get("byteOffset", 0)
        columns = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
        return np.frombuffer(data, "<f4", accessor["count"] * columns, start).reshape(-1, columns)

    shown = {node["name"] for node in tree["nodes"] if "mesh" in node and np.any(node.get("scale", 1.0))}
    for channel in tree["animations"][0]["channels"]:
        if channel["target"]["path"] == "scale":
            sampler, title = (
                tree["animations"][0]["samplers"][channel["sampler"]],
                tree["nodes"][channel["target"]["node"]]["name"],
            )
            assert sampler["interpolation"] == "STEP"
            times, scales = rows(sampler["input"])[:, 0], rows(sampler["output"])
            assert (np.diff(times) > 0.0).all()
            is_there = scales[max(0, np.searchsorted(times, k / 32.0, side="right") - 1)].any()
            shown = shown | {title} if is_there else shown - {title}
    return shown


def test_a_glb_shows_bodies_in_their_frames_only(kept, tmp_path):
    kept.export(tmp_path / "film.glb")
    raw = (tmp_path / "film.glb").read_bytes()
    size = int.from_bytes(raw[12:16], "little")
    tree, data = json.loads(raw[20 : 20 + size]), raw[28 + size :]
    for k, titles in enumerate(SEEN):
        assert titles_at(tree, data, k) == titles
    scene = trimesh.load_scene(tmp_path / "film.glb")  # who shows no motion shows the first frame
    assert {name for name in scene.graph.nodes_geometry if np.linalg.det(scene.graph[name][0]) > 0.0} == SEEN[0]
    for mesh in tree["meshes"]:
        assert len(mesh.get("weights", ())) == len(mesh["primitives"][0].get("targets", ()))


def test_openusd_shows_bodies_in_their_frames_only(kept, tmp_path):
    usd, geometry = pytest.importorskip("pxr.Usd"), pytest.importorskip("pxr.UsdGeom")
    kept.export(tmp_path / "film.usdc")
    stage = usd.Stage.Open(str(tmp_path / "film.usdc"))
    for k, titles in enumerate(SEEN):
        for code in (k, k + 0.9):
            prims = [geometry.Mesh(prim) for prim in stage.GetDefaultPrim().GetChildren()]
            shown = [prim for prim in prims if prim.ComputeVisibility(code) == "inherited"]
            assert {prim.GetPrim().GetDisplayName() for prim in shown} == titles
    ball = geometry.Mesh(stage.GetPrimAtPath("/World/ball"))
    np.testing.assert_allclose(np.array(ball.GetPointsAttr().Get(2)), kept[2].positions, atol=1e-6)


def test_few_frames_have_the_bodies_of_these(kept, tmp_path):
    kept.export(tmp_path / "film.glb", every=4)
    raw = (tmp_path / "film.glb").read_bytes()
    size = int.from_bytes(raw[12:16], "little")
    tree, data = json.loads(raw[20 : 20 + size]), raw[28 + size :]
    assert [titles_at(tree, data, k) for k in (0, 4)] == [{"ball", "box_0"}, set()]


def test_a_sequence_has_each_frames_own_bodies(kept, tmp_path):
    kept.export(tmp_path / "ply", "ply", every=5)
    assert sorted(os.listdir(tmp_path / "ply")) == ["000000.ply", "000001.ply"]
    for k, (frame, count) in enumerate(((0, 6 + 8), (5, 4))):
        mesh = trimesh.load_mesh(tmp_path / "ply" / f"{k:06d}.ply", process=False)
        assert len(mesh.vertices) == count
        np.testing.assert_allclose(mesh.vertices[: len(kept[frame].positions)], kept[frame].positions, atol=1e-6)
    with pytest.raises(ParameterError, match=r"frame 4 has no bodies to export; leave it out, .*or export one film"):
        kept.export(tmp_path / "all", "ply")
    assert not (tmp_path / "all").exists()


def test_a_film_of_nobody_is_refused(tmp_path):
    with TrajectoryWriter(World(), tmp_path / "t") as writer:
        writer.frame()
    for name in ("film.glb", "film.usda"):
        with pytest.raises(ParameterError, match="there are no bodies to export"):
            Trajectory.open(tmp_path / "t").export(tmp_path / name)


def test_a_named_body_is_one_though_its_number_changes(tmp_path):
    world = World()
    gone = world.add_soft_body(softbody.tetrahedron(), 1.0, 100.0, 10.0, name="gone")
    world.add_soft_body(softbody.octahedron(), 1.0, 100.0, 10.0, (5.0, 0.0, 0.0), name="stays")
    with TrajectoryWriter(world, tmp_path / "t") as writer:
        for k in range(4):
            if k == 2:
                world.remove(gone)
            world.time = float(k)
            writer.frame()
    Trajectory.open(tmp_path / "t").export(tmp_path / "film.glb")
    assert set(trimesh.load_scene(tmp_path / "film.glb").geometry) == {"gone", "stays"}
