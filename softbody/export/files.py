"""Export of a moment, or a sequence of them, to files that other programs read."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from softbody.compiler.interrupts import later
from softbody.errors import OutputError, ParameterError
from softbody.export import usd
from softbody.export.animation import film_bytes
from softbody.export.looks import Looks
from softbody.export.meshes import as_scene, check_pose, in_world, trimesh
from softbody.model.shapes import Pose, Shapes
from softbody.model.validation import shown
from softbody.storage.atomic_file import path_of, whole_file

HEADER = "softbody: metres, z is up"


@later()
def _ply(shapes: Shapes, looks: Looks, pose: Pose) -> bytes:
    mesh = trimesh().util.concatenate(in_world(shapes, pose))
    return mesh.export(file_type="ply", vertex_normal=False, include_attributes=False)


@later()
def _obj(shapes: Shapes, looks: Looks, pose: Pose) -> bytes:
    scene = trimesh().Scene()
    for mesh, look in zip(in_world(shapes, pose), [*looks.soft, *looks.boxes]):
        scene.add_geometry(mesh, geom_name=look.title)
    text = trimesh().exchange.obj.export_obj(scene, include_normals=False, digits=17, header=HEADER)
    return text.encode()


@later()
def _glb(shapes: Shapes, looks: Looks, pose: Pose) -> bytes:
    return as_scene(shapes, looks, pose).export(file_type="glb", include_normals=False)


def _usd(kind: str, shapes: Shapes, looks: Looks, pose: Pose) -> bytes:
    return usd.stage_bytes(kind, shapes, looks, np.zeros(1), [pose])


KINDS: dict[str, Callable[[Shapes, Looks, Pose], bytes]] = {"ply": _ply, "obj": _obj, "glb": _glb}
KINDS |= {kind: partial(_usd, kind) for kind in usd.KINDS}
FILMS: dict[str, Callable[[Shapes, Looks, np.ndarray, Iterable[Pose]], bytes]] = {"glb": film_bytes}
FILMS |= {kind: partial(usd.stage_bytes, kind) for kind in usd.KINDS}
ENDINGS = ".ply, .obj, .glb or .usdc"


def export_moment(path: str | os.PathLike[str], shapes: Shapes, looks: Looks, pose: Pose) -> None:
    """Do what `World.export` says."""
    place = path_of(path)
    kind = place.suffix.removeprefix(".").lower()
    if kind not in KINDS:
        raise ParameterError(f"{place} is of no kind of mesh file; give a name that ends in {ENDINGS}")
    check_pose(shapes, pose)
    _write(place, KINDS[kind](shapes, looks, pose))


def export_sequence(
    path: str | os.PathLike[str], kind: str, shapes: Shapes, looks: Looks, poses: Iterable[Pose]
) -> None:
    """Write each pose to a file of its own, in a new folder: 000000.ply, …"""
    folder = path_of(path)
    if not isinstance(kind, str) or kind not in KINDS:
        raise ParameterError(f"kind is {shown(kind)}; choose one of {', '.join(KINDS)}")
    usd.pxr("Usd") if kind in usd.KINDS else trimesh()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        is_empty = not os.listdir(folder)
    except OSError as error:
        raise _refused(folder, error) from error
    if not is_empty:
        raise OutputError(f"{folder} is not empty; give the name of a new folder")
    for k, pose in enumerate(poses):
        check_pose(shapes, pose)
        _write(folder / f"{k:06d}.{kind}", KINDS[kind](shapes, looks, pose))


def export_film(
    path: str | os.PathLike[str], shapes: Shapes, looks: Looks, times: np.ndarray, poses: Iterable[Pose]
) -> None:
    """Write all poses, at `times` (f,) [s], to one file in which bodies move."""
    place = path_of(path)
    kind = place.suffix.removeprefix(".").lower()
    if kind not in FILMS:
        raise ParameterError(
            f"{place} cannot hold what moves; give a name that ends in .glb or .usdc, or a folder and a kind: "
            f"export(folder, 'ply')"
        )
    if not len(times):
        raise ParameterError("there are no frames to export; keep some first")
    _write(place, FILMS[kind](shapes, looks, times, poses))


def _write(path: Path, content: Any) -> None:
    try:
        with whole_file(path) as file:
            file.write(content)
    except OSError as error:
        raise _refused(path, error) from error


def _refused(path: Path, error: OSError) -> OutputError:
    return OutputError(f"{path} cannot be written: {error.strerror or error}; give another name, or make room")
