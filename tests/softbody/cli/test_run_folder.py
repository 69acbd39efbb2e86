"""Is a run that was ended by anything, and gone on with, the run that nothing has ended, to the last bit?"""

import os
import signal
import subprocess
import sys
from contextlib import contextmanager

import numpy as np
import pytest

from softbody import OutputError, SceneError, SnapshotError, Trajectory, TrajectoryError, World
from softbody.cli import run_folder
from softbody.cli.run_folder import run_scene

if sys.version_info < (3, 11):
    pytest.importorskip("tomli")

SCENE = """
[ground]

[[soft_body]]
shape = { name = "octahedron", radius = 0.3 }
mass = 1.0
stiffness = 200.0
gas = 5.0
position = [0.1, 0.0, 0.9]

[[box]]
size = [1.0, 1.0, 0.5]
mass = 2.0
position = [0.0, 0.0, 0.3]
orientation = { axis = [1.0, 0.0, 0.0], degrees = 5.0 }

[run]
seconds = 0.51
frames_per_second = 20.0
"""
FRAMES = 12  # of 1/20 s and a shorter one, and the first


@contextmanager
def silent(total, done):
    yield lambda frames: None


def ending(at, error=KeyboardInterrupt):
    """Return what is told of frames, and ends the run at one of them."""

    @contextmanager
    def reporter(total, done):
        def tell(frames):
            if frames == at:
                raise error

        yield tell

    return reporter


@pytest.fixture
def scene(tmp_path):
    def written(text=SCENE, name="scene.toml"):
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return written


def check_same(one, other):
    """See that two folders have the same world and the same frames."""
    assert World.load(one / "world.npz").state_hash() == World.load(other / "world.npz").state_hash()
    assert (one / "world.npz").read_bytes() == (other / "world.npz").read_bytes()
    a, b = Trajectory.open(one / "trajectory"), Trajectory.open(other / "trajectory")
    for frame, twin in zip(a, b, strict=True):
        for array, same in zip(frame[:-1], twin[:-1], strict=True):
            np.testing.assert_array_equal(array, same)


@pytest.mark.parametrize("how", ["", "time_step = 0.003\n"])
@pytest.mark.parametrize("pause", [0.0, 1e9])
def test_a_run_that_was_interrupted_goes_on_to_the_same_bits(scene, tmp_path, monkeypatch, how, pause):
    """The world was saved at every frame, or only at the first: frames after it are then made anew."""
    path, whole, parts = scene(SCENE + how), tmp_path / "whole", tmp_path / "parts"
    told = run_scene(path, whole, False, silent)
    assert told == f"{whole}: {FRAMES} frames until 0.51 s in trajectory/, world.npz, scene.toml"
    monkeypatch.setattr(run_folder, "PAUSE", pause)
    monkeypatch.setattr(run_folder, "PART", 1e9)
    for at in (1, 4, 9):
        with pytest.raises(KeyboardInterrupt):
            run_scene(path, parts, at > 1, ending(at))
        kept = Trajectory.open(parts / "trajectory")
        assert len(kept) == at + 1
        assert World.load(parts / "world.npz").time == kept.times[at - 1 if pause == 0.0 else 0]
    assert run_scene(path, parts, True, silent) == told.replace("whole", "parts")
    check_same(whole, parts)
    assert (parts / "scene.toml").read_bytes() == path.read_bytes()
    before = (parts / "world.npz").stat().st_mtime_ns
    run_scene(path, parts, True, ending(0))  # what is done stays as it is
    assert (parts / "world.npz").stat().st_mtime_ns == before


KILLED = """
import os, signal, sys
from contextlib import contextmanager
from softbody.cli.run_folder import run_scene

@contextmanager
def killed(total, done):
    yield lambda frames: frames == 5 and os.kill(os.getpid(), signal.SIGKILL)

run_scene(sys.argv[1], sys.argv[2], False, killed)
"""


@pytest.mark.skipif(os.name != "posix", reason="a process is killed by a signal")
def test_a_run_that_was_killed_goes_on_to_the_same_bits(scene, tmp_path):
    path, whole, parts = scene(), tmp_path / "whole", tmp_path / "parts"
    run_scene(path, whole, False, silent)
    done = subprocess.run([sys.executable, "-c", KILLED, str(path), str(parts)], check=False)
    assert done.returncode == -signal.SIGKILL
    run_scene(path, parts, True, silent)
    check_same(whole, parts)


def test_a_run_that_was_ended_before_it_saved_anything_begins_anew(scene, tmp_path):
    path, whole, parts = scene(), tmp_path / "whole", tmp_path / "parts"
    run_scene(path, whole, False, silent)
    parts.mkdir()
    (parts / "scene.toml").write_bytes(path.read_bytes())
    run_scene(path, parts, True, silent)
    check_same(whole, parts)
    (parts / "world.npz").unlink()
    run_scene(path, parts, True, silent)
    check_same(whole, parts)
    run_scene(path, tmp_path / "new", True, silent)
    check_same(whole, tmp_path / "new")


def test_what_is_in_the_way_is_said_before_any_work(scene, tmp_path, monkeypatch):
    path, other = scene(), scene(SCENE + "# mine\n", "other.toml")
    run_scene(path, tmp_path / "run", False, silent)
    monkeypatch.setattr(World, "step", lambda *_, **__: pytest.fail("it worked"))
    (tmp_path / "file").write_text("mine")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.tex").write_text("mine")
    for scene_file, name, resume, kind, message in (
        (path, "run", False, OutputError, "holds a run; --resume goes on with it"),
        (path, "file", False, OutputError, "file is no folder"),
        (path, "full", False, OutputError, "full holds other things than a run"),
        (path, "full", True, OutputError, "full holds other things than a run"),
        (other, "run", True, SceneError, "is not the one that .*run was begun with"),
        (scene(SCENE.partition("[run]")[0], "b.toml"), "new", False, SceneError, r"there is no \[run\] with seconds"),
        (scene("[run]", "c.toml"), "new", False, SceneError, r"c\.toml:1: run: seconds is missing"),
    ):
        with pytest.raises(kind, match=message):
            run_scene(scene_file, tmp_path / name, resume, silent)
    assert not (tmp_path / "new").exists()
    assert (tmp_path / "file").read_text() == "mine"


def test_a_run_that_is_damaged_is_told(scene, tmp_path):
    path, run = scene(), tmp_path / "run"
    with pytest.raises(KeyboardInterrupt):
        run_scene(path, run, False, ending(3))
    good = (run / "world.npz").read_bytes()
    (run / "world.npz").write_bytes(good[:100])
    with pytest.raises(SnapshotError, match=r"world\.npz is no NPZ file"):
        run_scene(path, run, True, silent)
    world = World()
    world.add_box((1.0, 1.0, 1.0), 1.0)
    world.save(run / "world.npz")
    with pytest.raises(SnapshotError, match=r"world\.npz has other bodies than scene\.toml"):
        run_scene(path, run, True, silent)
    (run / "world.npz").write_bytes(good)
    world = World.load(run / "world.npz")
    world.time = 0.01
    world.save(run / "world.npz")
    with pytest.raises(TrajectoryError, match=r"no frame at 0\.01 s, where world\.npz is"):
        run_scene(path, run, True, silent)


def test_a_film_of_the_whole_run_is_made_at_its_end(scene, tmp_path):
    images = pytest.importorskip("PIL.Image")
    text = SCENE + "\n[film]\nsize = [64, 48]\nframes_per_second = 10\ncolour = 'speed'\ncolour_range = [0, 3]\n"
    path = scene(text)
    with pytest.raises(KeyboardInterrupt):
        run_scene(path, tmp_path / "run", False, ending(4))
    assert not (tmp_path / "run" / "film.webp").exists()
    assert run_scene(path, tmp_path / "run", True, silent).endswith("scene.toml, film.webp")
    film = images.open(tmp_path / "run" / "film.webp")
    assert (film.size, film.n_frames) == ((64, 48), 6)


def test_a_film_that_cannot_be_made_is_said_before_any_work(scene, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "PIL.Image", None)
    monkeypatch.setattr(World, "step", lambda *_, **__: pytest.fail("it worked"))
    with pytest.raises(ImportError, match=r"softbody\[record\]"):
        run_scene(scene(SCENE + "[film]\n"), tmp_path / "run", False, silent)
