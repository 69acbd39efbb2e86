"""Are meshes read from files, merged on request, and is what is wrong with a file told?"""

import os
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import softbody
from softbody import Mesh, MeshError, MissingPackageError, ParameterError

trimesh = pytest.importorskip("trimesh")

BALL = softbody.icosphere(1)


def exported(mesh=BALL):
    return trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)


@pytest.mark.parametrize("kind", ["ply", "off", "obj"])
def test_a_file_that_shares_vertices_is_the_mesh_that_was_written(tmp_path, kind):
    path = tmp_path / f"ball.{kind}"
    exported().export(path)
    mesh = Mesh.from_file(path)
    assert mesh.vertices == pytest.approx(BALL.vertices, abs=1e-7)
    assert (mesh.triangles == BALL.triangles).all()


def test_an_stl_is_told_that_its_vertices_are_not_merged_and_is_merged_on_request(tmp_path):
    path = tmp_path / "ball.stl"
    exported().export(path)
    with pytest.raises(MeshError, match=r"ball\.stl: .*merge vertices, by .*Mesh\.from_file\(path, merge=True\)"):
        Mesh.from_file(path)
    for mesh in (Mesh.from_file(path, merge=True), Mesh.from_file(str(path), tolerance=1e-6)):
        assert mesh.vertices.shape == BALL.vertices.shape
        assert mesh.volume == pytest.approx(BALL.volume, rel=1e-6)


def test_merged_files_are_those_of_the_reference(tmp_path):
    reference = pytest.importorskip("references.trimesh")
    path = tmp_path / "ball.stl"
    exported().export(path)
    mesh, (vertices, triangles) = Mesh.from_file(path, merge=True), reference.load_mesh(path)
    assert (mesh.vertices == vertices).all()
    assert (mesh.triangles == triangles).all()


def test_meshes_of_trimesh_are_taken():
    assert (Mesh.from_trimesh(exported()).vertices == BALL.vertices).all()
    loose = trimesh.Trimesh(**trimesh.triangles.to_kwargs(BALL.vertices[BALL.triangles]), process=False)
    with pytest.raises(MeshError, match="merge vertices"):
        Mesh.from_trimesh(loose)
    assert Mesh.from_trimesh(loose, merge=True).volume == pytest.approx(BALL.volume)


def test_what_is_no_file_of_a_mesh_is_refused_by_name(tmp_path):
    with pytest.raises(FileNotFoundError, match="none"):
        Mesh.from_file(tmp_path / "none.stl")
    for name in ("text.stl", "text.ply", "text.off", "text.obj", "text.xyzzy"):
        (tmp_path / name).write_text("this is no mesh")
        with pytest.raises(MeshError, match=name):
            Mesh.from_file(tmp_path / name)
    with pytest.raises(MeshError, match="a list has no vertices and faces"):
        Mesh.from_trimesh([])
    with pytest.raises(MeshError, match="triangles are not numbers"):
        Mesh.from_trimesh(SimpleNamespace(vertices=BALL.vertices, faces=[[0, 1, 2], [3]]))
    with pytest.raises(ParameterError, match="tolerance is '1'"):
        Mesh.from_trimesh(exported(), tolerance="1")
    with pytest.raises(ParameterError, match="merge is 1; give True or False"):
        Mesh.from_trimesh(exported(), merge=1)


def test_a_scene_is_one_mesh_with_each_part_in_its_place(tmp_path):
    scene = trimesh.Scene()
    for k in range(2):
        scene.add_geometry(exported(), transform=trimesh.transformations.translation_matrix([5.0 * k, 0.0, 0.0]))
    scene.export(tmp_path / "two.glb")
    mesh = Mesh.from_file(tmp_path / "two.glb")
    assert mesh.volume == pytest.approx(2 * BALL.volume, rel=1e-6)
    assert np.ptp(mesh.vertices[:, 0]) == pytest.approx(7.0, rel=0.1)


def test_without_trimesh_the_package_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(MissingPackageError, match=r"takes trimesh: pip install trimesh .*softbody\[files\]"):
        Mesh.from_file(tmp_path / "any.stl")
    assert issubclass(MissingPackageError, ImportError)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes that have names")
def test_a_pipe_in_the_place_of_a_file_is_refused_and_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "part.ply")
    with pytest.raises(MeshError, match=r"part\.ply: it is no file"):
        Mesh.from_file(tmp_path / "part.ply")
