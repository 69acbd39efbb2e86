"""Export of a moment, or a sequence of them, to files that other programs read."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from softbody.compiler.interrupts import later
from softbody.errors import OutputError, ParameterError
from softbody.export import usd
from softbody.export.animation import film_bytes
from softbody.export.looks import looks_of
from softbody.export.meshes import check_pose, in_world, trimesh
from softbody.model.shapes import Cast, Pose
from softbody.model.validation import shown
from softbody.storage.atomic_file import path_of, whole_file

HEADER = "softbody: metres, z is up"


@later()
def _ply(cast: Cast, pose: Pose) -> bytes:
    mesh = trimesh().util.concatenate(in_world(cast.shapes, pose))
    return mesh.export(file_type="ply", vertex_normal=False, include_attributes=False)


@later()
def _obj(cast: Cast, pose: Pose) -> bytes:
    scene, looks = trimesh().Scene(), looks_of(cast.labels)
    for mesh, look in zip(in_world(cast.shapes, pose), [*looks.soft, *looks.boxes]):
        scene.add_geometry(mesh, geom_name=look.title)
    text = trimesh().exchange.obj.export_obj(scene, include_normals=False, digits=17, header=HEADER)
    return text.encode()


def _still(film: Film, cast: Cast, pose: Pose) -> bytes:
    """Return a film of a single frame."""
    return film(np.zeros(1), [cast], [pose])


Film = Callable[[np.ndarray, Sequence[Cast], Iterable[Pose]], bytes]
FILMS: dict[str, Film] = {"glb": film_bytes, **{kind: partial(usd.stage_bytes, kind) for kind in usd.KINDS}}
KINDS: dict[str, Callable[[Cast, Pose], bytes]] = {"ply": _ply, "obj": _obj}
KINDS |= {kind: partial(_still, film) for kind, film in FILMS.items()}
ENDINGS = ".ply, .obj, .glb or .usdc"


def export_moment(path: str | os.PathLike[str], cast: Cast, pose: Pose) -> None:
    """Do what `World.export` says."""
    place = path_of(path)
    kind = place.suffix.removeprefix(".").lower()
    if kind not in KINDS:
        raise ParameterError(f"{place} is of no kind of mesh file; give a name that ends in {ENDINGS}")
    _write(place, _moment(kind, cast, pose))


def export_sequence(path: str | os.PathLike[str], kind: str, moments: Iterable[tuple[Cast, Pose]]) -> None:
    """Write each moment to a file of its own, in a new folder: 000000.ply, …"""
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
    for k, (cast, pose) in enumerate(moments):
        _write(folder / f"{k:06d}.{kind}", _moment(kind, cast, pose))


def export_film(path: str | os.PathLike[str], casts: Sequence[Cast], times: np.ndarray, poses: Iterable[Pose]) -> None:
    """Write all poses, at `times` (f,) [s], to one file in which bodies move, come and go.

    `casts`: the bodies of each; frames whose bodies are the same have the same object.
    """
    place = path_of(path)
    kind = place.suffix.removeprefix(".").lower()
    if kind not in FILMS:
        raise ParameterError(
            f"{place} cannot hold what moves; give a name that ends in .glb or .usdc, or a folder and a kind: "
            f"export(folder, 'ply')"
        )
    if not len(times):
        raise ParameterError("there are no frames to export; keep some first")
    _write(place, FILMS[kind](times, casts, poses))


def _moment(kind: str, cast: Cast, pose: Pose) -> bytes:
    if cast.is_empty:
        raise ParameterError("there are no bodies to export; add one first")
    check_pose(pose)
    return KINDS[kind](cast, pose)


def _write(path: Path, content: Any) -> None:
    try:
        with whole_file(path) as file:
            file.write(content)
    except OSError as error:
        raise _refused(path, error) from error


def _refused(path: Path, error: OSError) -> OutputError:
    return OutputError(f"{path} cannot be written: {error.strerror or error}; give another name, or make room")
