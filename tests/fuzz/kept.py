"""A trajectory or a scene file of any bytes is refused with the core's own error, or is one like any."""

from __future__ import annotations

import io
import re
import tempfile
from functools import cache
from pathlib import Path

import numpy as np

import softbody
from softbody import SceneError, SoftbodyError, Trajectory, TrajectoryError, TrajectoryWriter, World
from tests.fuzz.bytes import cut, flipped, spliced, written_over
from tests.fuzz.files import a_row, bits, mixed, nearby, one_number, other_kind, several, shuffled

GOAL = 20_000

Rng = np.random.Generator

WAYS = (flipped, written_over, cut, spliced)
CHANGES = (one_number, nearby, several, a_row, bits, shuffled, mixed, other_kind)
TOKENS = (
    "-1", "0", "0.0", "2", "3.5", "1e999", "-1e300", "5e-324", "nan", "NaN", "inf", "Infinity", "9" * 400, "9" * 5000,
    "true", "null", '""', '"a"', '"../000000.npz"', '"icosphere"', "[]", "{}", "[[]]", "[", "]", "{", "}", ",", "=",
    "\n", "2000-01-01", "mass", "fixed_above = 0.1\n", "[run]", "[[box]]", "\0", "ä",
)  # fmt: skip
SCENE = b"""# A scene of everything.
[world]
gravity = [0.0, 0.0, -9.81]
integrator = "rk4"
[ground]
friction = 0.6
[[soft_body]]
shape = { name = "torus", major_radius = 0.5, minor_radius = 0.2, major_segments = 6, minor_segments = 5 }
mass = 1.0
stiffness = 200.0
gas = 30.0
position = [0.0, 0.0, 1.8]
orientation = { axis = [1.0, 0.0, 0.0], degrees = 30.0 }
fixed = [
  1,
  2,
]
[[soft_body]]
shape = { file = "part.ply" }
mass = 1.0
stiffness = [1.0, 2.0]
gas = 0.0
[[box]]
size = [1.0, 1.0, 0.5]
static = true
[run]
seconds = 1.0
time_step = 1e-3
[film]
colour = "strain"
colour_range = [0.0, 0.1]
"""


def _world() -> World:
    world = World()
    world.add_soft_body(softbody.octahedron(), 1.0, 100.0, 10.0)
    world.add_box((1.0, 2.0, 3.0), 1.0)
    return world


@cache
def _files(changes: bool = False) -> dict[str, bytes]:
    """Return the files of a trajectory of six frames in two chunks; with `changes` of bodies, in three segments."""
    with tempfile.TemporaryDirectory() as folder:
        world = _world()
        with TrajectoryWriter(world, Path(folder) / "t") as kept:
            for k in range(6):
                world.time = 0.25 * k
                if changes and k == 1:
                    world.add_box((1.0, 2.0, 3.0), 1.0, (9.0, 0.0, 0.0), name="other")
                if changes and k == 4:
                    world.remove(world.boxes[1])
                kept.frame()
                if k == 3:
                    kept.flush()
        return {path.name: path.read_bytes() for path in (Path(folder) / "t").iterdir()}


def _changed(raw: bytes, rng: Rng) -> bytes:
    for _ in range(rng.integers(1, 4)):
        raw = WAYS[rng.integers(len(WAYS))](raw, rng) or b"\x00"
    return raw


def _told_otherwise(raw: bytes, rng: Rng) -> bytes:
    """Write something else in the place of words, numbers and brackets of a text."""
    parts = re.split(r"([-\w.+]+|[^\s\w])", raw.decode())
    for _ in range(rng.integers(1, 4)):
        parts[2 * int(rng.integers(len(parts) // 2)) + 1] = str(rng.choice(TOKENS))
    return "".join(parts).encode()


def _with_others(raw: bytes, rng: Rng) -> bytes:
    """Change arrays of an archive, with the right sums."""
    with np.load(io.BytesIO(raw)) as archive:
        arrays = dict(archive)
    name = str(rng.choice(list(arrays)))
    arrays[name] = CHANGES[rng.integers(len(CHANGES))](arrays[name], rng)
    file = io.BytesIO()
    np.savez(file, **arrays)  # type: ignore[arg-type]
    return file.getvalue()


def attempt(seed: int) -> str | None:
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as folder:
        return (_scene if rng.random() < 0.5 else _trajectory)(Path(folder), rng)


def _scene(folder: Path, rng: Rng) -> str | None:
    path = folder / "scene.toml"
    path.write_bytes((_changed if rng.random() < 0.3 else _told_otherwise)(SCENE, rng))
    try:
        softbody.scenes.from_file(path)
    except SceneError as error:
        if any(not line.startswith(str(path)) for line in str(error).split(f"\n{path}")[:1]):
            return f"an error does not begin with the file: {error}"
    except SoftbodyError as error:
        return f"a {type(error).__name__} and no SceneError: {error}"
    return None


def _trajectory(folder: Path, rng: Rng) -> str | None:
    files = dict(_files(bool(rng.random() < 0.5)))
    name = sorted(files)[rng.integers(len(files))]
    crafted = _with_others if name.endswith(".npz") else _told_otherwise
    files[name] = (_changed if rng.random() < 0.3 else crafted)(files[name], rng)
    for each, raw in files.items():
        (folder / each).write_bytes(raw)
    try:
        for frame in Trajectory.open(folder, most_bytes=2**20):
            if not all(np.isfinite(rows).all() for rows in frame[:-1]):
                return "a frame is not finite"
    except TrajectoryError as error:
        if str(folder) not in str(error):
            return f"an error does not name the file: {error}"
    try:
        with TrajectoryWriter(_world(), folder, resume=True) as kept:
            kept.frame()
        if len(Trajectory.open(folder)) < 1:
            return "a frame was kept, and is not there"
    except TrajectoryError:
        pass
    return None
