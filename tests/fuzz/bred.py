"""Files of meshes, scenes, trajectories, worlds, bred to reach ever more lines, end in the core's own error or in use.

Guided by coverage: each attempt begins with good files of one kind, changes their bytes, and breeds from whatever
reaches a line, of the core or of what it reads with, that none before has reached.
"""

from __future__ import annotations

import logging
import sys
import tempfile
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import numpy as np

import softbody
from softbody import Mesh, MeshError, SceneError, SnapshotError, Trajectory, TrajectoryError, World
from tests.fuzz import kept
from tests.fuzz._worlds import snapshots
from tests.fuzz.bytes import cut, entries, flipped, packed, spliced, written_over

TRIES = 40  # files an attempt
GOAL = 20_000
WATCHED = "/softbody/", "/trimesh/", "/zipfile", "/tomllib/", "/json/", "/numpy/lib/"

Rng = np.random.Generator
Read = Callable[[Path], object]
WORDS = (
    b"0", b"-1", b"1", b"3", b"4", b"99999999999", b"-2147483649", b"1e999", b"nan", b"1e-320", b"vertex", b"face",
    b"element", b"property", b"list", b"uchar", b"float", b"int", b"double", b"end_header", b"facet", b"endsolid",
    b"f 1//1 2 3", b"v 0 0 0", b"OFF", b"[", b"]", b"{", b"}", b'"', b"=", b"\n", b"\xff", b"\x00" * 8,
)  # fmt: skip


def attempt(seed: int) -> str | None:
    """Breed files of the kind whose turn it is."""
    rng, name = np.random.default_rng(seed), list(KINDS)[seed % len(KINDS)]
    good, read, refusal = KINDS[name]
    logging.getLogger("trimesh").setLevel(logging.CRITICAL)  # it tells of every damaged file
    pool, seen = list(good()), set[tuple[CodeType, int]]()
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        path = Path(folder) / name
        for k in range(TRIES):
            raw = pool[k] if k < len(pool) == len(good()) else _changed(pool[rng.integers(len(pool))], rng)
            path.write_bytes(raw)
            known = len(seen)
            wrong = _read(read, path, refusal, seen)
            if wrong:
                return f"{name}, file {k}: {wrong}; {raw[:200]!r}"
            if len(seen) > known and k >= len(good()):
                pool.append(raw)
    return None


def _changed(raw: bytes, rng: Rng) -> bytes:
    """Change bytes, or put words in, once or some times."""
    for _ in range(1 + int(rng.integers(3))):
        ways = flipped, written_over, cut, spliced, _worded, _worded, _worded
        raw = ways[rng.integers(len(ways))](raw, rng) or b"\x00"
    return raw


def _worded(raw: bytes, rng: Rng) -> bytes:
    """Put a word in the place of another, or of some bytes, most often near the beginning."""
    place = int(len(raw) * rng.random() ** 2)
    end = next((k for k in range(place, min(len(raw), place + 20)) if raw[k : k + 1] in b" \n,]"), place + 4)
    return raw[:place] + WORDS[rng.integers(len(WORDS))] + raw[end:]


def _read(read: Read, path: Path, refusal: type[Exception], seen: set[tuple[CodeType, int]]) -> str | None:
    """Read a file, and note which lines that reaches; return what is wrong with how it ended."""

    def each(frame: FrameType, event: str, _: Any) -> Any:
        seen.add((frame.f_code, frame.f_lineno))
        return each

    def watch(frame: FrameType, event: str, argument: Any) -> Any:
        return each(frame, event, argument) if any(part in frame.f_code.co_filename for part in WATCHED) else None

    before = sys.gettrace()
    sys.settrace(watch)
    try:
        read(path)
    except refusal as error:
        return None if path.name in str(error) else f"the error does not name the file: {error}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    finally:
        sys.settrace(before)
    return None


def _mesh(path: Path) -> None:
    """Read a mesh, merged or not, and let a body of it move."""
    try:
        mesh = Mesh.from_file(path)
    except MeshError:
        mesh = Mesh.from_file(path, merge=True)
    if len(mesh.vertices) > 500:
        return
    mesh.check()
    world = World()
    try:
        world.add_soft_body(mesh, 1.0, 100.0, 10.0)
        world.step(0.5 * min(world.stable_time_step(), 1e-3), 2)
    except (softbody.ParameterError, softbody.SimulationError):
        return


@cache
def _meshes(kind: str) -> tuple[bytes, ...]:
    """Return files of a ball and of a tetrahedron, as trimesh writes them: as text and not, where there are both."""
    import trimesh

    ways: dict[str, tuple[dict[str, Any], ...]] = {"ply": ({}, {"encoding": "ascii"}), "stl": ({}, {})}
    found = []
    for mesh in (softbody.tetrahedron(), softbody.octahedron()):
        one = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
        for k, way in enumerate(ways.get(kind, ({},))):
            raw = one.export(file_type="stl_ascii" if kind == "stl" and k else kind, **way)
            found.append(raw.encode() if isinstance(raw, str) else raw)
    return tuple(found)


def _of_kind(kind: str) -> tuple[Callable[[], tuple[bytes, ...]], Read, type[Exception]]:
    return lambda: _meshes(kind), _mesh, MeshError


def _trajectory(path: Path) -> None:
    """Read a trajectory of which a file is this one; it has the files of one whose bodies come and go."""
    folder, name = path.parent / "kept", path.name
    folder.mkdir(exist_ok=True)
    for each, raw in kept._files(changes=b'"segments"' in path.read_bytes()).items():
        (folder / each).write_bytes(raw)
    (folder / name).write_bytes(path.read_bytes())
    for frame in Trajectory.open(folder, most_bytes=2**20):
        assert all(np.isfinite(rows).all() for rows in frame[:-1])


@cache
def _worlds() -> tuple[bytes, ...]:
    """Return the arrays of worlds, one after the other: so that what changes is no sum of an archive."""
    return tuple(_joined(entries(kind)) for kind in range(len(snapshots())))


MARK = b"\n--entry--"


def _joined(parts: dict[str, bytes]) -> bytes:
    return b"".join(MARK + name.encode() + b"\n" + raw for name, raw in parts.items())


def _world(path: Path) -> None:
    """Pack arrays into an archive, with the right sums, and load it."""
    parts = []
    for part in path.read_bytes().split(MARK)[1:]:
        name, _, raw = part.partition(b"\n")
        parts.append((name.decode(errors="replace"), raw))
    path.write_bytes(packed(parts, np.random.default_rng(0)))
    world = World.load(path, 2**22)
    world.step(1e-4, 2, allow_unstable=True)


def _settled(path: Path) -> None:
    """Load a world, and step it if it is one."""
    try:
        _world(path)
    except (softbody.SimulationError, softbody.ParameterError) as error:
        if isinstance(error, SnapshotError):
            raise


KINDS: dict[str, tuple[Callable[[], tuple[bytes, ...]], Read, type[Exception]]] = {
    "a.ply": _of_kind("ply"),
    "a.stl": _of_kind("stl"),
    "a.obj": _of_kind("obj"),
    "a.off": _of_kind("off"),
    "a.glb": _of_kind("glb"),
    "scene.toml": (lambda: (kept.SCENE,), softbody.scenes.from_file, SceneError),
    "trajectory.json": (
        lambda: tuple(kept._files(changes)["trajectory.json"] for changes in (False, True)),
        _trajectory,
        TrajectoryError,
    ),
    "world.npz": (_worlds, _settled, SnapshotError),
}
