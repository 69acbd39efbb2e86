"""Bodies as a stage of OpenUSD: each a mesh whose points, or place and turn, have a value a frame.

Between two frames OpenUSD goes straight from point to point and from place to place, and by the shortest turn.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Sequence
from itertools import compress
from pathlib import Path
from typing import Any

import numpy as np

from softbody.export.film import Actor, actors_of
from softbody.export.looks import Look
from softbody.export.meshes import box_mesh, check_pose, soft_mesh
from softbody.extras import library
from softbody.model.shapes import Cast, Pose, Shapes

KINDS = ("usd", "usda", "usdc")  # binary or text as OpenUSD chooses; text; binary
ROOT = "/World"
EVEN = 1e-6  # of a frame: how even frames are that are counted


def pxr(name: str) -> Any:
    """Return a module of OpenUSD; raises MissingPackageError."""
    return library(f"pxr.{name}", "OpenUSD (usd-core)", "usd", "writing USD files")


def stage_bytes(kind: str, times: np.ndarray, casts: Sequence[Cast], poses: Iterable[Pose]) -> bytes:
    """Return a file of `poses` at `times` (f,) [s]: a still for one, else one that moves; time 0 is the first's."""
    geometry, stage = pxr("UsdGeom"), pxr("Usd").Stage.CreateInMemory()
    geometry.SetStageUpAxis(stage, geometry.Tokens.z)
    geometry.SetStageMetersPerUnit(stage, 1.0)
    stage.SetDefaultPrim(geometry.Xform.Define(stage, ROOT).GetPrim())
    codes: list[Any] = [pxr("Usd").TimeCode.Default()]
    if len(times) > 1:
        codes = _time_codes(stage, times - times[0])
    is_shown = [k == 0 or code != codes[k - 1] for k, code in enumerate(codes)]  # of frames at the same time the first
    codes, casts = list(compress(codes, is_shown)), list(compress(casts, is_shown))
    drawn, paths = list[tuple[Actor, Any, Any]](), set[str]()
    for actor in actors_of(casts):
        mesh, moved = _drawn(stage, paths, actor, casts[actor.start].shapes)
        drawn.append((actor, mesh, moved))
        for frame, is_there in actor.changes(len(codes)).items():
            mesh.GetVisibilityAttr().Set("inherited" if is_there else "invisible", codes[frame])
    for k, (code, cast, pose) in enumerate(zip(codes, casts, compress(poses, is_shown))):
        check_pose(pose)
        for actor, mesh, moved in drawn:
            body = actor.number(k)
            if body is None:
                continue
            if actor.is_soft:
                _put(mesh, soft_mesh(cast.shapes, pose, body)[0], code)
            else:
                _place(moved, pose, body, code)
    with tempfile.TemporaryDirectory() as folder:  # OpenUSD writes to names of files only
        place = Path(folder) / f"stage.{kind}"
        stage.GetRootLayer().Export(str(place))
        return place.read_bytes()


def _time_codes(stage: Any, seconds: np.ndarray) -> list[float]:
    """Return the time code of each frame: its number where frames are even, so that programs count them as frames."""
    rate = (len(seconds) - 1) / float(seconds[-1] or 1.0)
    whole = float(round(rate)) or 1.0
    if np.abs(seconds * whole - np.round(seconds * whole)).max() < EVEN:
        rate, codes = whole, np.round(seconds * whole)
    else:
        codes = seconds * rate
    stage.SetTimeCodesPerSecond(rate)
    stage.SetFramesPerSecond(rate)
    stage.SetStartTimeCode(float(codes[0]))
    stage.SetEndTimeCode(float(codes[-1]))
    return [float(code) for code in codes]


def _mesh(stage: Any, paths: set[str], look: Look, triangles: np.ndarray) -> Any:
    """Add a mesh without points, under a name that OpenUSD takes, and shown by its title."""
    geometry, arrays = pxr("UsdGeom"), pxr("Vt")
    path = f"{ROOT}/{pxr('Tf').MakeValidIdentifier(look.title)}"
    while path in paths:
        path += "_"
    paths.add(path)
    mesh = geometry.Mesh.Define(stage, path)
    mesh.GetPrim().SetDisplayName(look.title)
    mesh.CreateSubdivisionSchemeAttr(geometry.Tokens.none)
    mesh.CreateFaceVertexCountsAttr(arrays.IntArray([3] * len(triangles)))
    mesh.CreateFaceVertexIndicesAttr(arrays.IntArray.FromNumpy(np.ascontiguousarray(triangles.ravel(), np.int32)))
    mesh.CreateDisplayColorAttr(arrays.Vec3fArray([pxr("Gf").Vec3f(*look.colour)]))
    return mesh


def _drawn(stage: Any, paths: set[str], actor: Actor, shapes: Shapes) -> tuple[Any, Any]:
    """Add a body of these in its first frame; return its mesh, and of a box what moves and what turns it."""
    geometry, body = pxr("UsdGeom"), actor.numbers[0]
    if actor.is_soft:
        return _mesh(stage, paths, actor.look, shapes.triangles(body)), None
    vertices, triangles = box_mesh(shapes, body)
    mesh = _mesh(stage, paths, actor.look, triangles)
    _put(mesh, vertices, pxr("Usd").TimeCode.Default())
    exact = geometry.XformOp.PrecisionDouble
    return mesh, (mesh.AddTranslateOp(exact), mesh.AddOrientOp(exact))


def _place(moved: Any, pose: Pose, body: int, code: Any) -> None:
    """Let a box be somewhere at a time."""
    move, turn = moved
    move.Set(pxr("Gf").Vec3d(*pose.box_position[body].tolist()), code)
    w, x, y, z = pose.box_orientation[body].tolist()
    turn.Set(pxr("Gf").Quatd(w, x, y, z), code)


def _put(mesh: Any, vertices: np.ndarray, code: Any) -> None:
    """Let a mesh have vertices (n, 3) at a time, and say how far they go."""
    arrays, points = pxr("Vt"), np.ascontiguousarray(vertices, np.float32)
    ends = np.stack([points.min(axis=0), points.max(axis=0)])
    mesh.GetPointsAttr().Set(arrays.Vec3fArray.FromNumpy(points), code)
    mesh.GetExtentAttr().Set(arrays.Vec3fArray.FromNumpy(ends), code)
