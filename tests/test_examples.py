"""Every example runs as its reader would run it, is short, and leaves what it says."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import trimesh

import softbody

EXAMPLES = Path(__file__).parents[1] / "examples"
LINES, OF_AN_ENVIRONMENT = 25, 40  # at most: an example is read at one look

# What each prints at least, and writes.
EXPECTED = {
    "blade": ("block.1: 0.88 kg", ["blade.webp"]),
    "bowling": ("of 10 boxes were moved", ["bowling.webp"]),
    "burst": ("J of gas left", ["burst.webp"]),
    "container": ("N of 59 N, the walls the rest", ["container.png"]),
    "drops": ("one drop with 12 J of gas", ["drops.webp"]),
    "environment": ("mm from the mark after", []),
    "film": ("1 soft bodies of 512 particles, 4 boxes", ["rolling.webp"]),
    "gripper": ("the ball hangs at 0.6", ["gripper.webp"]),
    "inflate_ring": ("the two differ by", ["inflated.png", "inflating.png"]),
    "keep_and_export": ("46 frames until 1.5 s; 1 soft bodies of 512 particles, 1 boxes", ["fall.glb", "last.ply"]),
    "many_worlds": ("6400 N/m: 0.", []),
    "own_kernel": ("of 100000 pairs overlap", []),
    "points_in_mesh": ("frame 2:", ["distance.png"]),
    "pull_pin_inflate": ("touch, with", ["inflated.png"]),
    "resting": ("the ground carries", ["resting.png"]),
    "rip": ("pieces", ["rip.webp"]),
    "squeeze_part": ("the plate presses with", ["squeezed.png", "force.png"]),
    "two_balls": ("", ["two_balls.png"]),
}


# What running each scene file says, and leaves besides the trajectory.
SCENES = {
    "ball_on_box": ("31 frames until 1 s", []),
    "hanging_lamp": ("21 frames until 1 s", ["lamp.webp"]),
    "hanging_ring": ("11 frames until 0.5 s", ["ring.webp"]),
}


def test_every_example_is_tried():
    assert {path.stem for path in EXAMPLES.glob("*.py")} == set(EXPECTED)
    assert {path.stem for path in EXAMPLES.glob("*.toml")} == set(SCENES)


@pytest.mark.parametrize("name", sorted(SCENES))
def test_a_scene_file_runs_as_its_reader_would_run_it(name, tmp_path):
    line = [sys.executable, "-m", "softbody", "run", str(EXAMPLES / f"{name}.toml"), "--out", str(tmp_path / "run")]
    done = subprocess.run(line, cwd=EXAMPLES.parent, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stderr
    said, written = SCENES[name]
    assert said in done.stdout
    assert len(softbody.Trajectory.open(tmp_path / "run" / "trajectory")) > 10
    assert softbody.World.load(tmp_path / "run" / "world.npz").steps > 0
    for file in written:
        assert (tmp_path / "run" / file).stat().st_size > 1_000


@pytest.mark.parametrize("name", sorted(EXPECTED))
def test_an_example_runs_and_leaves_what_it_says(name, tmp_path):
    ring = softbody.torus(0.1, 0.04, 24, 12)
    trimesh.Trimesh(ring.vertices, ring.triangles).export(tmp_path / "part.stl")
    source = EXAMPLES / f"{name}.py"
    assert len(source.read_text(encoding="utf-8").splitlines()) <= (
        OF_AN_ENVIRONMENT if name == "environment" else LINES
    )
    done = subprocess.run(
        [sys.executable, str(source), "part.stl"], cwd=tmp_path, capture_output=True, text=True, timeout=900
    )
    assert done.returncode == 0, done.stderr
    said, written = EXPECTED[name]
    assert said in done.stdout
    for file in written:
        assert (tmp_path / file).stat().st_size > 1_000
