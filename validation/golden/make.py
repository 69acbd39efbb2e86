"""Maker of the golden files: those of each format by the softbody of then, with what it says.

`python -m validation.golden.make FORMAT --checkout FOLDER` writes `files/FORMAT/`, and what is said of it into
`files/expected.json`. FOLDER is a checkout of the revision in REVISIONS; by default it is this one. The code there runs
in a process of its own, and without compiling: what it writes is kept, and not how fast it came about.

    git worktree add --detach ../old ba809c3
    python -m validation.golden.make 1 --checkout ../old

This file runs beside any softbody since format 1: it imports nothing else of ours, and asks what there is. Never make
the files of a format by a later revision than that: they would say nothing of the old one any more.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import pickle
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import softbody
from softbody import World, scenes

# By format: the last commit of then that changed softbody/. Of the format of now any will do.
REVISIONS = {
    1: "ba809c3",
    2: "f7c4405",
    3: "62c844f",
    4: "07b775b",
    5: "94d7194",
    6: "c9e2deb",
    7: "b6c9f55",
    8: "771a0eb",
    9: "f258795",
    10: "9bb549a",
}
FILES = Path(__file__).parent / "files"
EXPECTED = FILES / "expected.json"

FOLDERS = (
    2,
    5,
    6,
    7,
)  # formats of which a trajectory and a run are kept; they began with 2, and differ little in 3 and 4

H = 1e-3  # [s] of a step
STEPS = 40
NOT_TOLD = ("format", "rings.", "state.")  # entries that tell the format, follow from others, or are told besides

SCENE = """[world]
integrator = "rk4"
gravity = [0.0, 0.0, -9.0]

[ground]
height = -0.25
friction = 0.7

[[soft_body]]
shape = { name = "tetrahedron", radius = 0.3 }
mass = 0.5
stiffness = 90.0
gas = 2.0
damping = 0.1
drag = 0.2
position = [0.0, 0.1, 1.0]
velocity = [0.3, 0.0, -0.5]

[[box]]
size = [0.5, 0.4, 0.3]
mass = 2.0
position = [2.0, 0.0, 0.5]

[[box]]
size = [1.0, 1.0, 0.2]
static = true
position = [0.0, 0.0, 0.1]

[run]
seconds = 0.05
frames_per_second = 40.0
time_step = 1e-3
"""
SCENE_SINCE_5 = """
[[soft_body]]
name = "gem"
shape = { name = "octahedron", radius = 0.2 }
mass = 0.3
stiffness = 70.0
gas = 1.0
damping = 0.1
position = [-2.0, 0.0, 2.0]

[[joint]]
name = "cord"
a = [2.0, 0.0, 2.0]
b = { box = 0, at = [2.0, 0.1, 0.65] }
stiffness = 50.0
damping = 0.5
rest_length = 1.0
"""


def rich_world(number: int) -> World:
    """Return a world of all that there was in a format: unlike bodies, forces, contacts, joints, names, sleepers."""
    choices: dict[str, Any] = {"sleep_speed": 0.05, "sleep_after": 0.01, "substeps": 2} if number >= 6 else {}

    unusual: dict[str, Any] = {"self_contact": True} if number >= 8 else {}

    def named(name: str) -> dict[str, Any]:
        return {"name": name} if number >= 5 else {}

    world = World(gravity=(0.1, 0.0, -9.0), integrator="rk4", iterations=20, gyroscopic=True, **choices)
    world.add_ground(0.0, 0.1, 0.6)
    mesh = softbody.icosahedron(0.4)
    ball = world.add_soft_body(
        mesh,
        1.2,
        80.0 + np.arange(len(mesh.edges)),
        6.0,
        (3.0, 0.0, 0.38),
        (0.4, 0.1, -1.0),
        restitution=0.2,
        friction=0.4,
        damping=0.15,
        drag=0.1,
        deflated_below=0.05,
        **named("ball"),
    )
    unusual |= {"fixed": (0, 3), "damping": 0.2, "friction": 0.9}
    ring = world.add_soft_body(softbody.torus(0.5, 0.2, 5, 4), 0.8, 150.0, 3.0, (6.0, 0.5, 2.0), **unusual)
    turn = np.array([0.9, 0.1, -0.3, 0.2]) / np.linalg.norm([0.9, 0.1, -0.3, 0.2])
    lower = world.add_box((0.6, 0.5, 0.3), 2.0, (0.0, 0.0, 0.1495), friction=0.8)
    world.add_box((0.5, 0.4, 0.2), 1.0, (0.02, 0.0, 0.399), restitution=0.3, **named("lid"))
    world.add_box((0.5, 0.4, 0.3), None, (-3.0, 0.0, 1.0), turn, **named("wall"))
    thrown = world.add_box((0.2, 0.3, 0.4), 0.5, (-5.0, 0.0, 3.0), turn, (1.0, 0.0, 2.0), (0.5, 3.0, -1.0))
    ring.external_force = 0.05 * np.sin(np.arange(60.0)).reshape(20, 3)
    thrown.apply_force((0.3, 0.0, 0.2), thrown.position + (0.05, 0.0, 0.1))
    lower.apply_torque((0.0, 0.0, 1e-3))
    if number >= 3:
        rail = world.add_box((0.3, 0.3, 0.3), None, (-8.0, 0.0, 1.0), **named("rail"))
        rail.move_to((-7.0, 0.5, 1.5), (0.6, 0.0, 0.8, 0.0), seconds=0.1)
        world.add_joint((thrown, thrown.position + (0.0, 0.1, 0.0)), (-5.0, 0.0, 5.0), 20.0, 0.3, 1.5, **named("cord"))
        world.add_joint((ring, 7), (ball, (3.2, 0.1, 0.7)), 2.0, 0.1)
    if number >= 6:  # the others that stand fall asleep, and what sleeps has no contacts
        world.add_box((0.3, 0.3, 0.3), 0.7, (10.0, 0.0, 0.1495), velocity=(0.5, 0.0, 0.0), friction=0.1)
    return world


def paper_world() -> World:
    """Return a world by the paper's rules, in single precision, of a ball without ground, boxes or gravity."""
    world = World.paper(gravity=(0.0, 0.0, 0.0), precision="single")
    world.add_soft_body(softbody.octahedron(0.3), 0.7, 60.0, 0.0, (1.0, 2.0, 3.0), (0.1, -0.2, 0.3), rest_length=0.4)
    return world


def sha(array: np.ndarray) -> str:
    """Return the first 48 bits of the SHA-256 of an array's kind, shape and bytes, in hexadecimal."""
    array = np.asarray(array)
    what = f"{array.dtype.str} {array.shape}".encode() + np.ascontiguousarray(array).tobytes()
    return hashlib.sha256(what).hexdigest()[:12]


def beginning(array: np.ndarray) -> list[float]:
    """Return the first three numbers of an array."""
    return [float(number) for number in np.asarray(array).ravel()[:3]]


def told_of_world(world: World) -> dict[str, Any]:
    """Return what a world says of itself, in numbers and hashes; of what it does not know there is no entry."""
    state, snapshot = world.state, world.snapshot()
    motion = {name: array for name, array in state._asdict().items() if name != "box_time_left"}
    told: dict[str, Any] = {
        "steps": world.steps,
        "time": world.time,
        "precision": world.precision,
        "integrator": world.integrator,
        "gas": world.controls.soft_gas.tolist(),
        "box_inverse_mass": world.model.box_inverse_mass.tolist(),
        "motion": {name: sha(array) for name, array in motion.items()},
        "begins": {name: beginning(array) for name, array in motion.items()},
        "entries": {name: sha(array) for name, array in snapshot.items() if not name.startswith(NOT_TOLD)},
    }
    if hasattr(world, "soft_bodies"):
        told["masses"] = [*(body.mass for body in world.soft_bodies), *(box.mass for box in world.boxes)]
    if hasattr(world, "joints"):
        told["joints"] = len(world.joints)
        told["kinematic"] = [box.is_kinematic for box in world.boxes]
    if hasattr(state, "box_time_left"):
        told["time_left"] = state.box_time_left.tolist()
        told["state_hash"] = world.state_hash()
    if hasattr(softbody.SoftBody, "name"):
        told["names"] = [body.name for body in (*world.soft_bodies, *world.boxes, *world.joints)]
    if hasattr(softbody.SoftBody, "is_asleep"):
        told["asleep"] = [body.is_asleep for body in (*world.soft_bodies, *world.boxes)]
    return told


def told_of_trajectory(folder: Path) -> dict[str, Any]:
    """Return what a trajectory says of itself."""
    kept = softbody.Trajectory.open(folder)
    told: dict[str, Any] = {
        "times": kept.times.tolist(),
        "box_sizes": kept.box_sizes.tolist(),
        "particles": [[kept.particles(k).start, kept.particles(k).stop] for k in range(kept.soft_count)],
        "triangles": [sha(kept.triangles(k)) for k in range(kept.soft_count)],
        "frames": [
            {
                name: sha(value)
                for name, value in frame._asdict().items()
                if name not in ("time", "bodies") and value is not None
            }
            for frame in kept
        ],
    }
    if hasattr(kept, "soft_names"):
        told["names"] = [*kept.soft_names, *kept.box_names]
    return told


def files_of(number: int, folder: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """Write the files of a format; yield the name of each, and what is said of it."""
    world = rich_world(number)
    if number in FOLDERS:
        with softbody.TrajectoryWriter(world, folder / "trajectory") as kept:
            for _ in range(2):
                world.step(H, STEPS // 2)
                kept.frame()
                kept.flush()
        yield "trajectory", told_of_trajectory(folder / "trajectory")
    else:
        world.step(H, STEPS)
    world.save(folder / "world.npz")
    yield "world.npz", told_of_world(world)
    world = paper_world()
    world.step(H, STEPS)
    (folder / "paper.pickle").write_bytes(pickle.dumps(world))
    yield "paper.pickle", told_of_world(world)
    if number in FOLDERS:
        with tempfile.TemporaryDirectory() as elsewhere:
            scene = Path(elsewhere) / "scene.toml"
            scene.write_text(SCENE + SCENE_SINCE_5 if number >= 5 else SCENE)
            command = [sys.executable, "-m", "softbody", "run", str(scene), "--out", str(folder / "run")]
            core = Path(softbody.__file__).parents[1]  # where `-m` looks first
            subprocess.run(command, check=True, cwd=core, stdout=subprocess.DEVNULL)
        yield "run/scene.toml", told_of_world(scenes.from_file(folder / "run" / "scene.toml"))
        yield "run/world.npz", told_of_world(World.load(folder / "run" / "world.npz"))
        yield "run/trajectory", told_of_trajectory(folder / "run" / "trajectory")


def _lines(said: dict[str, Any]) -> str:
    """Return JSON of a line for each entry."""
    return "{\n" + ",\n".join(f"  {json.dumps(name)}: {json.dumps(value)}" for name, value in said.items()) + "\n }"


def make(number: int, revision: str) -> None:
    """Write the files of a format by the softbody that is imported, and what it says of them."""
    folder = FILES / str(number)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    told = {f"{number}/{name}": {"revision": revision, **said} for name, said in files_of(number, folder)}
    with np.load(folder / "world.npz") as kept:
        found = int(kept["format"]) if "format" in kept else 1
    if found != number:
        raise SystemExit(f"this softbody writes format {found}, and not {number}")
    before = json.loads(EXPECTED.read_text()) if EXPECTED.exists() else {}
    others = {name: said for name, said in before.items() if not name.startswith(f"{number}/")}
    lines = (f" {json.dumps(name)}: {_lines(said)}" for name, said in sorted((others | told).items()))
    EXPECTED.write_text("{\n" + ",\n".join(lines) + "\n}\n")


def main() -> None:
    """Make the files of a format, by a checkout in a process of its own."""
    parser = argparse.ArgumentParser(prog="python -m validation.golden.make", description=main.__doc__)
    parser.add_argument("format", type=int, choices=REVISIONS)
    parser.add_argument("--checkout", type=Path, default=Path(__file__).parents[2], metavar="FOLDER")
    given = parser.parse_args()
    checkout = given.checkout.resolve()
    if Path(softbody.__file__).resolve().parents[1] != checkout or os.environ.get("NUMBA_DISABLE_JIT") != "1":
        environment = os.environ | {"PYTHONPATH": str(checkout), "NUMBA_DISABLE_JIT": "1"}
        raise SystemExit(subprocess.run([sys.executable, __file__, *sys.argv[1:]], env=environment).returncode)
    asked = ["git", "-C", str(checkout), "log", "-1", "--format=%h", "--abbrev=7", "--", "softbody"]
    revision = subprocess.run(asked, check=True, capture_output=True, text=True).stdout.strip()
    if given.format < max(REVISIONS) and revision != REVISIONS[given.format]:
        raise SystemExit(
            f"the softbody there is of {revision}; of format {given.format} take {REVISIONS[given.format]}"
        )
    make(given.format, revision)


if __name__ == "__main__":
    main()
