"""The README is true: its example runs and says what it says, and its commands exist."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import softbody

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_example_drops_a_ball_that_comes_to_rest_above_the_ground() -> None:
    example = subprocess.run(
        [sys.executable, "tests/readme_example.py", "README.md"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    done = subprocess.run([sys.executable, "-c", example], cwd=ROOT, capture_output=True, text=True, check=True)
    found = re.fullmatch(r"came to rest at z = ([\d.]+) m with a pressure of ([\d.]+) Pa\n", done.stdout)
    assert found, done.stdout
    height, pressure = float(found[1]), float(found[2])
    # Its lowest point is the ground: the centre of the sagging ball is somewhat lower than its radius, 0.5 m.
    assert 0.3 < height < 0.5
    # 30 J in slightly more than the rest volume of 0.51 m³.
    assert 45.0 < pressure < 60.0


def test_the_example_that_goes_through_frames_runs() -> None:
    first, second, *_ = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    code = first.replace("seconds=30.0", "seconds=0.1") + second.replace("seconds=5.0", "seconds=0.2")
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert "Energies(kinetic=" in done.stdout
    assert "<World: 1 soft bodies of 642 particles" in done.stdout


def test_what_is_kept_is_read_and_exported(tmp_path, monkeypatch) -> None:
    pytest.importorskip("trimesh")
    pytest.importorskip("pxr")
    world = softbody.World()
    world.add_soft_body(softbody.octahedron(), 1.0, 100.0, 10.0)
    (code,) = (block for block in re.findall(r"```python\n(.*?)```", README, re.DOTALL) if "TrajectoryWriter" in block)
    monkeypatch.chdir(tmp_path)
    exec(code, {"softbody": softbody, "world": world})
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "fall", "fall.glb", "fall.usdc", "meshes", "now.obj"
    ]  # fmt: skip


def test_the_scene_file_is_one(tmp_path) -> None:
    if sys.version_info < (3, 11):
        pytest.importorskip("tomli")
    (text,) = re.findall(r"```toml\n(.*?)```", README, re.DOTALL)
    (tmp_path / "scene.toml").write_text(text)
    world = softbody.scenes.from_file(tmp_path / "scene.toml")
    assert repr(world) == "<World: 1 soft bodies of 642 particles, 0 boxes, ground at 0 m; 0 steps, 0 s>"


def test_every_option_that_the_readme_names_is_an_option() -> None:
    help_text = ""
    for command in [], ["replay"]:
        asked = [sys.executable, "-m", "validation", *command, "--help"]
        help_text += subprocess.run(asked, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    options = set(re.findall(r"\[(-[-\w]+)", README)) | {"--level"}
    assert options >= {"--level", "--seed", "-k", "--out", "--list", "--require", "--require-all"}
    assert all(option in help_text for option in options)


def test_every_file_that_the_readme_names_exists() -> None:
    for path in re.findall(r"`([\w.]+/[\w./]*\w)`", README):
        assert path.startswith("build/") or (ROOT / path).exists(), path


def test_every_make_target_that_the_readme_names_exists() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"`make ([\w-]+)|^make ([\w-]+)", README, re.MULTILINE))
    assert targets
    for target in ("".join(pair) for pair in targets):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target
