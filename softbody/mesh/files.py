"""Vertices and triangles from mesh files, read by trimesh where that is installed."""

from __future__ import annotations

import os
import stat
from typing import Any

from numpy.typing import ArrayLike

from softbody.compiler.interrupts import later
from softbody.errors import MeshError, MissingPackageError


def read_triangles(path: str | os.PathLike[str]) -> tuple[ArrayLike, ArrayLike]:
    """Return vertices (n, 3) and triangles (t, 3) of an STL, OBJ, PLY, OFF or another file, as they stand there.

    The bodies of a scene are put into one, each in its place. Raises MissingPackageError without trimesh, MeshError
    for what it cannot read, OSError if there is nothing to read.
    """
    try:
        with later():
            import trimesh
    except ImportError as error:
        raise MissingPackageError(
            "reading mesh files takes trimesh: pip install trimesh (with softbody, its extra: softbody[files])"
        ) from error
    mode = os.stat(path).st_mode
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):  # nobody may ever write to a pipe, and a device may have no end
        raise MeshError("it is no file; save it as one")
    with open(path, "rb"):  # a file that is not there is no damaged one
        pass
    try:
        with later():
            mesh = trimesh.load_mesh(path, process=False)
    except Exception as error:  # whatever a reader of some twenty formats raises
        raise MeshError(
            f"cannot be read as a mesh ({type(error).__name__}: {error}); save it anew, as PLY or STL"
        ) from error
    return triangles_of(mesh)


def triangles_of(mesh: Any) -> tuple[ArrayLike, ArrayLike]:
    """Return `vertices` and `faces` of a trimesh.Trimesh, or of anything that has both; raises MeshError."""
    try:
        return mesh.vertices, mesh.faces
    except AttributeError as error:
        raise MeshError(f"a {type(mesh).__name__} has no vertices and faces; give one mesh of triangles") from error
