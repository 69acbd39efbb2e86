"""Do other readers find the bodies in a file that were in the world: positions, triangles, poses, and how they move?"""

import json
import os
import struct
import sys

import numpy as np
import pytest

import softbody
from softbody import MissingPackageError, OutputError, ParameterError, Trajectory, TrajectoryWriter, World
from softbody.model.colours import STATIC, colour_of

trimesh = pytest.importorskip("trimesh")

SINGLE = 2.0**-24  # relative rounding of a float of four bytes


@pytest.fixture
def world():
    """Two soft bodies and two boxes, turned, away from the origin."""
    world = World()
    world.add_ground()
    rng = np.random.default_rng(3)
    world.add_soft_body(softbody.icosphere(1, 0.5), 1.0, 100.0, 10.0, (10.0, 0.0, 2.0))
    world.add_soft_body(softbody.torus(0.5, 0.2, 7, 5), 1.0, 100.0, 10.0, (5.0, -3.0, 2.0))
    for size, mass in (((1.0, 2.0, 3.0), 1.0), ((0.5, 0.25, 1.0), None)):
        turn = rng.normal(size=4)
        world.add_box(size, mass, rng.normal(size=3), turn / np.linalg.norm(turn))
    moved(world, 0)
    return world


def moved(world, k):
    """Put everything a little aside, at the time of frame k."""
    rng = np.random.default_rng(k)
    for name in ("particle_position", "box_position", "box_orientation"):
        array = getattr(world.state, name)
        array += 0.01 * rng.normal(size=array.shape)
    world.state.box_orientation[:] /= np.linalg.norm(world.state.box_orientation, axis=1, keepdims=True)
    world.time = k / 32.0


def corners(box):
    """The corners (8, 3) of a box, by Rodrigues' formula."""
    w, v = box.orientation[0], box.orientation[1:]
    cross = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    turn = np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross
    signs = np.array([[i, j, k] for i in (-0.5, 0.5) for j in (-0.5, 0.5) for k in (-0.5, 0.5)])
    return signs * box.size @ turn.T + box.position


def check_all(world, vertices, triangles, tolerance):
    """See that an array of vertices and one of triangles are all bodies, one after the other."""
    first = row = 0
    for body in world.soft_bodies:
        n, t = len(body.positions), len(body.triangles)
        np.testing.assert_allclose(vertices[first : first + n], body.positions, rtol=tolerance, atol=tolerance)
        np.testing.assert_array_equal(triangles[row : row + t], body.triangles + first)
        first, row = first + n, row + t
    for box in world.boxes:
        check_box(box, vertices[first : first + 8], triangles[row : row + 12] - first, 20.0 * tolerance + 1e-14)
        first, row = first + 8, row + 12
    assert (first, row) == (len(vertices), len(triangles))


def check_box(box, vertices, triangles, tolerance):
    assert (vertices.shape, triangles.shape) == ((8, 3), (12, 3))
    apart = np.linalg.norm(vertices[:, None] - corners(box)[None], axis=2)
    assert (np.sort(apart.argmin(axis=1)) == np.arange(8)).all()
    assert apart.min(axis=1).max() < tolerance
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0  # outward, closed
    assert volume == pytest.approx(box.size.prod(), rel=1e-5)


def test_ply_and_obj_are_what_trimesh_reads(world, tmp_path):
    for kind, tolerance in (("ply", SINGLE), ("obj", 1e-17)):
        world.export(tmp_path / f"all.{kind}")
        mesh = trimesh.load_mesh(tmp_path / f"all.{kind}", process=False, maintain_order=True)
        check_all(world, np.array(mesh.vertices), np.array(mesh.faces), tolerance)


def test_ply_and_obj_are_what_libigl_reads(world, tmp_path):
    igl = pytest.importorskip("igl")
    for kind, tolerance in (("ply", SINGLE), ("obj", 1e-15)):
        world.export(tmp_path / f"all.{kind}")
        vertices, triangles = igl.read_triangle_mesh(str(tmp_path / f"all.{kind}"))
        check_all(world, vertices, triangles, tolerance)


def test_an_obj_names_each_body(world, tmp_path):
    world.export(tmp_path / "all.OBJ")
    named = [line for line in (tmp_path / "all.OBJ").read_text().splitlines() if line.startswith("o ")]
    assert named == ["o soft_body_0", "o soft_body_1", "o box_0", "o box_1"]


def test_a_glb_has_a_node_for_each_body_with_y_up(world, tmp_path):
    world.export(tmp_path / "all.glb")
    scene = trimesh.load_scene(tmp_path / "all.glb", process=False)
    bodies = {f"soft_body_{i}": body for i, body in enumerate(world.soft_bodies)}
    bodies |= {f"box_{i}": box for i, box in enumerate(world.boxes)}
    assert set(scene.geometry) == set(bodies)
    for name, body in bodies.items():
        matrix, geometry = scene.graph[name]
        mesh = scene.geometry[geometry]
        x, y, z = (np.array(mesh.vertices) @ matrix[:3, :3].T + matrix[:3, 3]).T
        vertices, triangles = np.stack([x, -z, y], axis=1), np.array(mesh.faces)
        if name.startswith("box"):
            check_box(body, vertices, triangles, 1e-6)
        else:
            np.testing.assert_allclose(vertices, body.positions, rtol=SINGLE, atol=1e-12)
            np.testing.assert_array_equal(triangles, body.triangles)


@pytest.fixture
def kept(world, tmp_path):
    """A trajectory of five frames."""
    with TrajectoryWriter(world, tmp_path / "t") as writer:
        for k in range(5):
            moved(world, k)
            writer.frame()
    return Trajectory.open(tmp_path / "t")


@pytest.mark.parametrize("kind", ["ply", "obj", "glb", "usda", "usdc"])
def test_a_sequence_has_a_file_for_each_frame(world, kept, tmp_path, kind):
    if kind.startswith("usd"):
        pytest.importorskip("pxr")
    kept.export(tmp_path / "meshes", kind)
    assert sorted(os.listdir(tmp_path / "meshes")) == [f"{k:06d}.{kind}" for k in range(5)]
    for k in range(5):
        kept.put_into(world, k)
        world.export(tmp_path / f"one.{kind}")
        assert (tmp_path / "meshes" / f"{k:06d}.{kind}").read_bytes() == (tmp_path / f"one.{kind}").read_bytes()
    kept.export(tmp_path / "few", kind, every=3)
    assert (tmp_path / "few" / f"{1:06d}.{kind}").read_bytes() == (tmp_path / "meshes" / f"{3:06d}.{kind}").read_bytes()


class Film:
    """What glTF 2.0 says that a file shows at a time, read without anything of ours."""

    def __init__(self, path):
        raw = path.read_bytes()
        magic, version, length, size, kind = struct.unpack_from("<4sIII4s", raw)
        assert (magic, version, length, kind) == (b"glTF", 2, len(raw), b"JSON")
        self.tree, self.data = json.loads(raw[20 : 20 + size]), raw[28 + size :]
        (self.motion,) = self.tree["animations"]

    def array(self, number):
        accessor = self.tree["accessors"][number]
        view = self.tree["bufferViews"][accessor["bufferView"]]
        kind = {5125: "<u4", 5126: "<f4"}[accessor["componentType"]]
        columns = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        found = np.frombuffer(self.data, kind, accessor["count"] * columns, start).reshape(-1, columns).astype(float)
        for name, extreme in (("min", found.min(axis=0)), ("max", found.max(axis=0))):
            np.testing.assert_allclose(accessor.get(name, extreme), extreme, rtol=1e-6)
        return found

    def shown(self, name, k):
        """Return a node's own vertices, translation and rotation at the time of frame k, and that time."""
        number = next(i for i, node in enumerate(self.tree["nodes"]) if node["name"] == name)
        node, time = self.tree["nodes"][number], None
        mesh = self.tree["meshes"][node["mesh"]]
        (part,) = mesh["primitives"]
        values = {"weights": None, "translation": node.get("translation"), "rotation": node.get("rotation")}
        for channel in self.motion["channels"]:
            if channel["target"]["node"] == number:
                sampler = self.motion["samplers"][channel["sampler"]]
                assert sampler["interpolation"] == "LINEAR"
                times, rows = self.array(sampler["input"])[:, 0], self.array(sampler["output"])
                values[channel["target"]["path"]] = rows.reshape(len(times), -1)[k]
                time = times[k]
        vertices = self.array(part["attributes"]["POSITION"])
        for weight, target in zip(values["weights"] if values["weights"] is not None else (), part.get("targets", ())):
            vertices = vertices + weight * self.array(target["POSITION"])
        return vertices, values["translation"], values["rotation"], time


def test_a_glb_moves_as_the_trajectory_does(world, kept, tmp_path):
    kept.export(tmp_path / "film.glb")
    film = Film(tmp_path / "film.glb")
    for k in range(5):
        kept.put_into(world, k)
        for i, body in enumerate(world.soft_bodies):
            vertices, _, _, time = film.shown(f"soft_body_{i}", k)
            np.testing.assert_allclose(vertices, body.positions, rtol=4.0 * SINGLE, atol=1e-7)
            assert time == kept.times[k]
        for i, box in enumerate(world.boxes):
            _, place, turn, time = film.shown(f"box_{i}", k)
            np.testing.assert_allclose(place, box.position, rtol=2.0 * SINGLE)
            assert abs(np.dot(np.roll(turn, 1), box.orientation)) == pytest.approx(1.0, abs=1e-6)
            assert time == kept.times[k]
    trimesh.load_scene(tmp_path / "film.glb")  # who shows no motion shows the first frame
    kept.export(tmp_path / "few.glb", every=2)
    assert len(Film(tmp_path / "few.glb").motion["samplers"]) == len(film.motion["samplers"])


def test_turns_take_the_short_way(tmp_path):
    world = World()
    box = world.add_box((1.0, 1.0, 1.0), 1.0)
    with TrajectoryWriter(world, tmp_path / "t") as kept:
        for k, sign in enumerate((1.0, -1.0, -1.0, 1.0)):
            box.orientation = sign * np.array([np.cos(0.1 * k), np.sin(0.1 * k), 0.0, 0.0])
            world.time = k
            kept.frame()
    Trajectory.open(tmp_path / "t").export(tmp_path / "t.glb")
    film = Film(tmp_path / "t.glb")
    turns = np.array([film.shown("box_0", k)[2] for k in range(4)])
    assert (np.sum(turns[1:] * turns[:-1], axis=1) > 0.99).all()


def test_one_frame_and_none(world, tmp_path):
    with TrajectoryWriter(world, tmp_path / "t") as writer:
        with pytest.raises(ParameterError, match="there are no frames to export"):
            Trajectory.open(tmp_path / "t").export(tmp_path / "t.glb")
        writer.frame()
    Trajectory.open(tmp_path / "t").export(tmp_path / "t.glb")
    world.export(tmp_path / "one.glb")
    assert (tmp_path / "t.glb").read_bytes() == (tmp_path / "one.glb").read_bytes()


def test_too_many_frames_for_a_film_are_told(world, tmp_path, monkeypatch):
    monkeypatch.setattr("softbody.export.animation.MOST_FRAMES", 2)
    with TrajectoryWriter(world, tmp_path / "t") as writer:
        for k in range(5):
            world.time = float(k)
            writer.frame()
    kept = Trajectory.open(tmp_path / "t")
    with pytest.raises(ParameterError, match=r"5 frames are too many.*take fewer, with every=3"):
        kept.export(tmp_path / "t.glb")
    kept.export(tmp_path / "t.glb", every=3)


def test_what_cannot_be_exported_is_said(world, kept, tmp_path):
    (tmp_path / "folder.ply").mkdir()
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine").write_text("mine")
    for path, kind, message in (
        (tmp_path / "a.stl", ParameterError, r"give a name that ends in \.ply, \.obj, \.glb or \.usdc"),
        (tmp_path / "missing" / "a.ply", OutputError, "No such file or directory"),
        (tmp_path / "folder.ply", OutputError, "Is a directory"),
        (3, ParameterError, "give the name of a file"),
    ):
        with pytest.raises(kind, match=message):
            world.export(path)
    for arguments, kind, message in (
        ((tmp_path / "a.ply",), ParameterError, r"cannot hold what moves; give a name that ends in \.glb"),
        ((tmp_path / "new", "stl"), ParameterError, "kind is 'stl'; choose one of ply, obj, glb, usd, usda, usdc"),
        ((tmp_path / "full", "ply"), OutputError, "full is not empty"),
        ((tmp_path / "full" / "mine", "ply"), OutputError, "File exists"),
    ):
        with pytest.raises(kind, match=message):
            kept.export(*arguments)
    with pytest.raises(ParameterError, match="every is 0"):
        kept.export(tmp_path / "new", "ply", every=0)
    with pytest.raises(ParameterError, match="there are no bodies to export"):
        World().export(tmp_path / "a.ply")
    world.state.particle_position[3, 1] = np.nan
    with pytest.raises(ParameterError, match=r"particle_position\[3\] is .*nan"):
        world.export(tmp_path / "a.ply")
    assert sorted(os.listdir(tmp_path)) == ["folder.ply", "full", "t"]


def test_without_trimesh_the_extra_is_named(world, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "trimesh", None)
    for kind in ("ply", "obj", "glb"):
        with pytest.raises(MissingPackageError, match=r"needs trimesh: pip install softbody\[files\]"):
            world.export(tmp_path / f"a.{kind}")


def test_without_openusd_the_extra_is_named(world, kept, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pxr.Usd", None)
    monkeypatch.setitem(sys.modules, "pxr.UsdGeom", None)
    for work in (
        lambda: world.export(tmp_path / "a.usdc"),
        lambda: kept.export(tmp_path / "film.usda"),
        lambda: kept.export(tmp_path / "folder", "usd"),
    ):
        with pytest.raises(MissingPackageError, match=r"needs OpenUSD \(usd-core\): pip install softbody\[usd\]"):
            work()
    assert os.listdir(tmp_path) == ["t"]


@pytest.fixture
def stage():
    """A function that opens a file by OpenUSD."""
    return pytest.importorskip("pxr.Usd").Stage.Open


def body_at(stage, path, code):
    """What OpenUSD itself makes of a mesh: vertices in the world, and triangles."""
    from pxr import UsdGeom

    mesh = UsdGeom.Mesh(stage.GetPrimAtPath(path))
    matrix = np.array(UsdGeom.XformCache(code).GetLocalToWorldTransform(mesh.GetPrim()))  # of rows
    points = np.array(mesh.GetPointsAttr().Get(code), float)
    low, high = np.array(mesh.GetExtentAttr().Get(code))
    np.testing.assert_array_equal([low, high], [points.min(axis=0), points.max(axis=0)])
    return points @ matrix[:3, :3] + matrix[3, :3], np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)


@pytest.mark.parametrize("kind", ["usd", "usda", "usdc"])
def test_openusd_shows_what_the_trajectory_has(world, kept, stage, tmp_path, kind):
    kept.export(tmp_path / f"film.{kind}")
    film = stage(str(tmp_path / f"film.{kind}"))
    assert (film.GetTimeCodesPerSecond(), film.GetStartTimeCode(), film.GetEndTimeCode()) == (32.0, 0.0, 4.0)
    for k in range(5):
        kept.put_into(world, k)
        for i, body in enumerate(world.soft_bodies):
            vertices, triangles = body_at(film, f"/World/soft_body_{i}", k)
            np.testing.assert_allclose(vertices, body.positions, rtol=SINGLE, atol=1e-12)
            np.testing.assert_array_equal(triangles, body.triangles)
        for i, box in enumerate(world.boxes):
            check_box(box, *body_at(film, f"/World/box_{i}", k), 1e-6)


def test_uneven_frames_and_frames_at_the_same_time_are_at_their_times(world, stage, tmp_path):
    times = 1.0, 1.25, 1.25, 1.3, 2.0
    places = []
    with TrajectoryWriter(world, tmp_path / "t") as writer:
        for k, time in enumerate(times):
            moved(world, k)
            world.time = time
            places.append(world.boxes[0].position.copy())
            writer.frame()
    Trajectory.open(tmp_path / "t").export(tmp_path / "t.usda")
    film = stage(str(tmp_path / "t.usda"))
    rate = film.GetTimeCodesPerSecond()
    for k in (0, 1, 3, 4):
        vertices, _ = body_at(film, "/World/box_0", (times[k] - times[0]) * rate)
        np.testing.assert_allclose(vertices.mean(axis=0), places[k], rtol=1e-6)


TITLES = ("my ball é", "soft_body_1", "soft_body_0", "box_1")


def test_bodies_are_called_by_their_names_and_no_two_the_same(world, stage, tmp_path):
    world.soft_bodies[0].name, world.boxes[0].name = "my ball é", "soft_body_0"
    world.export(tmp_path / "a.glb")
    assert set(trimesh.load_scene(tmp_path / "a.glb").geometry) == set(TITLES)
    world.soft_bodies[0].name, world.soft_bodies[1].name = None, "my_ball__"
    world.export(tmp_path / "a.obj")
    named = [line[2:] for line in (tmp_path / "a.obj").read_text().splitlines() if line.startswith("o ")]
    assert named == ["soft_body_0_", "my_ball__", "soft_body_0", "box_1"]
    world.soft_bodies[0].name, world.soft_bodies[1].name = "my ball é", "my_ball__é"
    world.export(tmp_path / "a.usdc")
    opened = stage(str(tmp_path / "a.usdc"))
    titles = [prim.GetDisplayName() for prim in opened.GetDefaultPrim().GetChildren()]
    assert titles == ["my ball é", "my_ball__é", "soft_body_0", "box_1"]


@pytest.mark.parametrize("names", [("a!", "a__2", "a?", "a_"), ("a_", "a__", "a!", "a?"), ("1", "_1", "!", "_")])
def test_names_that_are_one_to_openusd_stay_apart(world, stage, tmp_path, names):
    for body, name in zip((*world.soft_bodies, *world.boxes), names):
        body.name = name
    world.export(tmp_path / "a.usda")
    opened = stage(str(tmp_path / "a.usda"))
    assert tuple(prim.GetDisplayName() for prim in opened.GetDefaultPrim().GetChildren()) == names


def test_a_trajectory_has_the_names_of_its_bodies(world, tmp_path):
    world.soft_bodies[0].name, world.boxes[0].name = "my ball é", "soft_body_0"
    with TrajectoryWriter(world, tmp_path / "t") as writer:
        for k in range(2):
            moved(world, k)
            writer.frame()
    world.soft_bodies[0].name = None
    kept = Trajectory.open(tmp_path / "t")
    assert (kept.soft_names, kept.box_names) == (("my ball é", None), ("soft_body_0", None))
    kept.export(tmp_path / "t.glb")
    film = Film(tmp_path / "t.glb")
    for title in TITLES:
        film.shown(title, 0)


def test_colours_are_those_of_pictures(world, tmp_path):
    world.export(tmp_path / "a.glb")
    scene = trimesh.load_scene(tmp_path / "a.glb")
    for number, title in enumerate(("soft_body_0", "soft_body_1", "box_0", "box_1")):
        told = STATIC if title == "box_1" else colour_of(number)
        red_green_blue = scene.geometry[title].visual.material.baseColorFactor[:3] / 255.0
        np.testing.assert_allclose(red_green_blue ** (1.0 / 2.2), told, atol=0.01)
