"""The command line says what it can do, does it, and names what is wrong."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import urllib.request

import pytest

import softbody
from softbody import __main__ as command


def said(capsys, *arguments):
    """Return the exit code and what was printed, to both."""
    try:
        code = command.main(arguments)
    except SystemExit as ended:
        code = ended.code
    printed = capsys.readouterr()
    return code, printed.out + printed.err


def test_help_lists_commands_and_scenes(capsys):
    code, text = said(capsys, "--help")
    assert code == 0
    for word in ("warmup", "view", "record", "run", "export", *softbody.scenes.__all__):
        assert word in text
    assert "Soft balls fall into an open tray." in text


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "required: COMMAND"),
        (("watch",), "invalid choice: 'watch'"),
        (("view",), "required: SCENE"),
        (("view", "teapot"), "invalid choice: 'teapot'"),
        (("view", "tray", "--port", "high"), "invalid int value: 'high'"),
        (("view", "teapot.toml"), "teapot.toml cannot be read: No such file or directory"),
        (("run", "tray.toml"), "required: --out"),
        (("run", "tray.toml", "--out", "nowhere"), "tray.toml cannot be read"),
        (("record", "tray", "film.gif"), "film.gif is of no kind of film"),
        (("record", "tray", "end.png", "--seconds", "0"), "seconds is 0.0; give a finite number > 0 [s]"),
        (("record", "tray", "film.webp", "--colour", "speed"), "a film by speed needs a colour_range"),
        (("view", "tray", "--port", "70000"), "port is 70000; give a whole number from 0 to 65535"),
    ],
)
def test_wrong_usage_says_what_is_wrong(capsys, arguments, message):
    code, text = said(capsys, *arguments)
    assert code == 2
    assert message in text


def test_the_version_is_that_of_the_package(capsys):
    assert said(capsys, "--version") == (0, f"softbody {softbody.__version__}\n")


def test_warmup_says_that_it_is_done(capsys, monkeypatch):
    done = []
    monkeypatch.setattr(command, "warm_up", lambda: done.append(True))
    code, text = said(capsys, "warmup")
    assert (code, done) == (0, [True])
    assert text.startswith("machine code is ready (")


def test_a_scene_is_viewed_by_the_settings_that_were_asked_for(capsys, monkeypatch):
    seen = []
    monkeypatch.setattr(softbody.World, "view", lambda world, port, **more: seen.append((world, port, more)))
    asked = "--paper", "--integrator", "rk4", "--substeps", "3"
    assert said(capsys, "view", "box_stack", *asked, "--port", "0", "--no-browser")[0] == 0
    world, port, more = seen[0]
    assert (port, more) == (0, {"host": "127.0.0.1", "open_browser": False})
    assert world.model.box_count == 8
    assert world.store.settings.frictionless
    assert world.integrator == "rk4"
    assert world.substeps == 3
    assert said(capsys, "view", "box_stack", "--substeps", "0")[0] == command.WRONG_USAGE


def test_a_scene_is_recorded_as_a_picture_and_as_a_film(capsys, tmp_path):
    image = pytest.importorskip("PIL.Image")
    size = ("--size", "64", "48")
    for name, frames, more in (("end.png", 1, ()), ("film.webp", 3, ("--substeps", "2"))):
        code, text = said(capsys, "record", "ball_drop", str(tmp_path / name), "--seconds", "0.1", *size, *more)
        assert (code, text) == (0, f"{tmp_path / name}: ball_drop until 0.1 s\n")
        found = image.open(tmp_path / name)
        assert (found.size, getattr(found, "n_frames", 1)) == ((64, 48), frames)


BOX = "[[box]]\nsize = [1, 1, 1]\nmass = 1\n"


@pytest.fixture
def scene_file(tmp_path):
    """A scene file of a box that falls for half a second."""
    if sys.version_info < (3, 11):
        pytest.importorskip("tomli")
    (tmp_path / "box.toml").write_text(BOX + "[run]\nseconds = 0.5\nframes_per_second = 20\n")
    return str(tmp_path / "box.toml")


def test_a_scene_file_is_viewed_and_recorded(capsys, tmp_path, monkeypatch, scene_file):
    seen = []
    monkeypatch.setattr(softbody.World, "view", lambda world, port, **more: seen.append(world))
    for more, integrator in ((), "symplectic_euler"), (("--integrator", "rk4"), "rk4"):
        assert said(capsys, "view", scene_file, *more) == (0, "")
        assert (seen[-1].model.box_count, seen[-1].integrator) == (1, integrator)
    assert said(capsys, "view", scene_file, "--paper")[0] == 0
    assert seen[-1].store.settings.frictionless
    code, text = said(capsys, "record", scene_file, str(tmp_path / "end.png"), "--seconds", "0.1", "--size", "64", "48")
    assert (code, text) == (0, f"{tmp_path / 'end.png'}: {scene_file} until 0.1 s\n")


def test_a_scene_file_is_run_and_gone_on_with(capsys, tmp_path, monkeypatch, scene_file):
    out = str(tmp_path / "run")
    made = f"{out}: 11 frames until 0.5 s in trajectory/, world.npz, scene.toml\n"
    assert said(capsys, "run", scene_file, "--out", out) == (0, made)
    code, text = said(capsys, "run", scene_file, "--out", out)
    assert (code, text) == (
        4,
        f"softbody: {out} holds a run; --resume goes on with it, or give the name of a new folder\n",
    )
    assert said(capsys, "run", scene_file, "--out", out, "--resume") == (0, made)


def test_a_run_and_a_saved_world_are_exported(capsys, tmp_path, scene_file):
    pytest.importorskip("trimesh")
    run, film, meshes, now = (str(tmp_path / name) for name in ("run", "film.glb", "meshes", "now.obj"))
    assert said(capsys, "run", scene_file, "--out", run)[0] == 0
    assert said(capsys, "export", run, film) == (0, f"{film}: 11 frames of {run}\n")
    kept = f"{run}/trajectory"
    assert said(capsys, "export", kept, meshes, "--each", "ply", "--every", "5") == (
        0,
        f"{meshes}: 3 frames of {kept}\n",
    )
    assert said(capsys, "export", f"{run}/world.npz", now) == (0, f"{now}: {run}/world.npz\n")
    assert sorted(os.listdir(meshes)) == ["000000.ply", "000001.ply", "000002.ply"]
    for arguments, message in (
        ((str(tmp_path), film), "holds no trajectory"),
        ((f"{run}/nothing", film), "holds no trajectory"),
        ((scene_file, now), "is no NPZ file of a world"),
        ((run, now), "cannot hold what moves"),
        ((f"{run}/world.npz", film, "--each", "ply"), "is one moment; leave out --each"),
        ((run, film, "--every", "0"), "every is 0"),
    ):
        code, text = said(capsys, "export", *arguments)
        assert (code, message in text) == (2, True), text


def test_ctrl_c_ends_a_run_that_can_be_gone_on_with(capsys, tmp_path, monkeypatch, scene_file):
    steps = []

    def interrupted(world, *_):
        steps.append(world.time)
        if len(steps) == 3:
            raise KeyboardInterrupt
        return real(world, *_)

    real = softbody.World.step_frame
    out = str(tmp_path / "run")
    monkeypatch.setattr(softbody.World, "step_frame", interrupted)
    code, text = said(capsys, "run", scene_file, "--out", out)
    assert (code, text) == (130, f"softbody: interrupted; {out} has what was done, and --resume goes on\n")
    assert len(softbody.Trajectory.open(tmp_path / "run" / "trajectory")) == 3
    assert said(capsys, "run", scene_file, "--out", out, "--resume")[0] == 0


@pytest.mark.parametrize("name", ["end.png", "film.webp"])
def test_what_is_in_the_way_of_a_record_is_said_before_the_work(capsys, tmp_path, monkeypatch, name):
    monkeypatch.setattr(softbody.World, "step", lambda *_, **__: pytest.fail("it worked"))
    code, text = said(capsys, "record", "ball_drop", str(tmp_path / "missing" / name))
    assert code == 4
    assert "there is no folder" in text


def test_a_library_that_is_missing_is_named_with_its_cure(capsys, monkeypatch):
    for name in [each for each in sys.modules if each.partition(".")[0] == "viser"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "viser", None)
    code, text = said(capsys, "view", "ball_drop")
    assert code == 4
    assert "softbody: a live view needs viser: pip install softbody[view]" in text


def test_a_port_that_is_taken_is_said(capsys):
    pytest.importorskip("viser")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        code, text = said(capsys, "view", "ball_drop", "--port", str(taken.getsockname()[1]))
    assert code == 4
    assert "give another port" in text


@pytest.mark.skipif(os.name != "posix", reason="Ctrl-C is sent as a signal")
def test_a_view_says_its_address_and_ends_by_ctrl_c():
    pytest.importorskip("viser")
    line = [sys.executable, "-m", "softbody", "view", "ball_drop", "--port", "0"]
    without = {name: value for name, value in os.environ.items() if "DISPLAY" not in name}
    with subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=without) as running:
        for text in running.stdout:
            if " shows the world, until Ctrl-C" in text:
                break
        assert urllib.request.urlopen(text.split()[0]).status == 200
        running.send_signal(signal.SIGINT)
        rest, wrong = running.communicate(timeout=120)
    assert running.returncode == 0, wrong
    assert "closed" in rest
