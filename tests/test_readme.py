"""The README is short, and with the pages it leads to it is true: programs run, commands and files exist."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import softbody

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
DOCS = "\n".join(page.read_text(encoding="utf-8") for page in sorted((ROOT / "docs").glob("*.md")))


def test_it_is_short_and_so_are_its_sentences() -> None:
    assert len(README.encode()) <= 8_000
    prose = re.sub(r"```.*?```|<!--.*?<!-- end -->|^[#|!].*?$|\]\([^)]*\)", "", README, flags=re.DOTALL | re.MULTILINE)
    lengths = [len(sentence.split()) for sentence in re.split(r"[.:;](?:\s|$)", prose) if sentence.split()]
    assert np.mean(lengths) <= 17.0
    assert np.percentile(lengths, 90) <= 28.0


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


def test_what_is_kept_is_read_and_exported(tmp_path, monkeypatch) -> None:
    pytest.importorskip("trimesh")
    pytest.importorskip("pxr")
    world = softbody.World()
    world.add_soft_body(softbody.octahedron(), 1.0, 100.0, 10.0)
    (code,) = (
        block
        for block in re.findall(r"```python\n(.*?)```", DOCS, re.DOTALL)
        if "TrajectoryWriter" in block and "usdc" in block
    )
    monkeypatch.chdir(tmp_path)
    exec(code, {"softbody": softbody, "world": world})
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "fall", "fall.glb", "fall.usdc", "meshes", "now.obj"
    ]  # fmt: skip


def test_the_scene_file_is_one(tmp_path) -> None:
    if sys.version_info < (3, 11):
        pytest.importorskip("tomli")
    text, *_ = re.findall(r"```toml\n(.*?)```", (ROOT / "docs" / "keeping.md").read_text(encoding="utf-8"), re.DOTALL)
    (tmp_path / "scene.toml").write_text(text)
    world = softbody.scenes.from_file(tmp_path / "scene.toml")
    assert repr(world) == "<World: 1 soft bodies of 642 particles, 0 boxes, ground at 0 m; 0 steps, 0 s>"


def test_every_option_that_the_readme_names_is_an_option() -> None:
    help_text = ""
    for command in [], ["replay"]:
        asked = [sys.executable, "-m", "validation", *command, "--help"]
        help_text += subprocess.run(asked, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    options = set(re.findall(r"\[(-[-\w]+)", (ROOT / "docs" / "judging.md").read_text(encoding="utf-8"))) | {"--level"}
    assert options >= {"--level", "--seed", "-k", "--out", "--list", "--require", "--require-all"}
    assert all(option in help_text for option in options)


def test_every_file_that_the_readme_names_exists() -> None:
    for path in re.findall(r"`([\w.]+/[\w./]*\w)`", README + (ROOT / "docs" / "rooms.md").read_text(encoding="utf-8")):
        assert path.startswith("build/") or (ROOT / path).exists(), path


def test_every_make_target_that_the_readme_names_exists() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"`make ([\w-]+)|^make ([\w-]+)", README + DOCS, re.MULTILINE))
    assert targets
    for target in ("".join(pair) for pair in targets):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target
