"""A film has the frames that were taken, whatever ends it, and says at once what cannot work."""

from __future__ import annotations

import errno
import os
import sys

import numpy as np
import pytest

import softbody
from softbody import Camera, MissingPackageError, OutputError, ParameterError, Recorder
from softbody.render import films

SMALL = (64, 48)


@pytest.fixture
def world():
    """A ball that falls."""
    world = softbody.World()
    world.add_ground()
    world.add_soft_body(softbody.icosphere(1), 1.0, 100.0, 10.0, (0.0, 0.0, 2.0), damping=0.0)
    return world


def frames_of(path):
    """Return the frames (h, w, 3) of a film, and how long each stays [ms], as Pillow reads them."""
    image = pytest.importorskip("PIL.Image").open(path)
    frames, times = [], []
    for k in range(image.n_frames):
        image.seek(k)
        frames.append(np.asarray(image.convert("RGB")).astype(int))
        times.append(image.info["duration"])
    return frames, times


def test_a_picture_is_returned_and_written(world, tmp_path):
    pixels = world.picture(tmp_path / "a.png", size=SMALL)
    assert pixels.shape == (48, 64, 3)
    np.testing.assert_array_equal(np.asarray(pytest.importorskip("PIL.Image").open(tmp_path / "a.png")), pixels)
    assert os.listdir(tmp_path) == ["a.png"]


def test_the_same_world_has_the_same_picture_in_every_colour(world):
    for colour in ("stripes", "plain", "pressure", "strain", "speed"):
        one, other = (world.picture(size=SMALL, colour=colour) for _ in range(2))
        assert one.tobytes() == other.tobytes()


def test_a_picture_shows_an_empty_world_and_one_without_ground():
    assert softbody.World().picture(size=SMALL).shape == (48, 64, 3)


def test_a_film_has_a_frame_for_each_that_was_taken(world, tmp_path):
    path, pictures = tmp_path / "film.webp", []
    with Recorder(world, path, 30.0, size=SMALL, camera=Camera((0.0, -6.0, 1.0), (0.0, 0.0, 1.0)), quality=95) as film:
        for _ in range(4):
            film.frame()
            pictures.append(world.picture(size=SMALL, camera=Camera((0.0, -6.0, 1.0), (0.0, 0.0, 1.0))))
            softbody.SoftBody(world, 0).positions[:, 2] -= 0.3
    frames, times = frames_of(path)
    assert times == [33, 34, 33, 33]  # a thirtieth of a second, without drift
    for frame, picture in zip(frames, pictures, strict=True):
        assert np.abs(frame - picture).mean() < 4.0
    assert os.listdir(tmp_path) == ["film.webp"]


def test_frames_that_are_alike_stay(world, tmp_path):
    with Recorder(world, tmp_path / "film.webp", 10.0, size=SMALL, last_frame=1.5) as film:
        for _ in range(3):
            film.frame()
    frames, times = frames_of(tmp_path / "film.webp")
    assert sum(times) == 100 + 100 + 1600
    assert all(np.abs(frame - frames[0]).max() <= 8 for frame in frames)


def test_a_run_takes_a_frame_whenever_it_is_time(world, tmp_path):
    """A step of 7 ms does not divide 1/20 s: frames come at steps 0, 7, 14, 21, 29, 36."""
    path, at = tmp_path / "frames", []
    film = Recorder(world, path, 20.0, size=SMALL, camera=lambda w: at.append(w.steps) or Camera((0, -6, 1), (0, 0, 1)))
    with film:
        film.run(0.1, 0.007)
        film.run(0.154, 0.007)
    assert at == [0, 7, 14, 21, 29, 36]
    assert world.steps == 36
    assert sorted(os.listdir(path)) == [f"{k:06d}.png" for k in range(6)]


def test_a_film_of_the_same_world_has_the_same_bytes(world, tmp_path):
    start = world.snapshot()
    for name in ("a.webp", "b.webp"):
        world.restore(start)
        with Recorder(world, tmp_path / name, size=SMALL) as film:
            film.run(0.2, 5e-3)
    assert (tmp_path / "a.webp").read_bytes() == (tmp_path / "b.webp").read_bytes()


def test_what_was_recorded_until_an_interrupt_is_a_film(world, tmp_path):
    film = Recorder(world, tmp_path / "film.webp", size=SMALL)
    film.run(0.2, 5e-3)
    film.__exit__(KeyboardInterrupt, KeyboardInterrupt(), None)
    assert len(frames_of(tmp_path / "film.webp")[0]) == film.frames == 5


def test_an_interrupt_in_the_midst_of_a_frame_costs_that_frame(world, tmp_path, monkeypatch):
    film = Recorder(world, tmp_path / "film.webp", size=SMALL)
    film.run(0.1, 5e-3)
    written = films.WebpFilm._add

    def interrupted(self, chunk):
        self._file.write(chunk[: len(chunk) // 2])
        raise KeyboardInterrupt

    monkeypatch.setattr(films.WebpFilm, "_add", interrupted)
    with pytest.raises(KeyboardInterrupt), film:
        film.run(0.1, 5e-3)
    monkeypatch.setattr(films.WebpFilm, "_add", written)
    assert len(frames_of(tmp_path / "film.webp")[0]) == 3


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no file that is always full")
def test_a_disk_that_becomes_full_leaves_the_frames_until_then(world, tmp_path, monkeypatch):
    film = Recorder(world, tmp_path / "film.webp", size=SMALL)
    film.run(0.1, 5e-3)

    def full(file, data):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr("softbody.render.webp._write", full)
        patch.setattr(films.WebpFilm, "end", lambda self, ms: patch.undo() or films.WebpFilm.end(self, ms))
        with pytest.raises(OutputError, match="No space left on device; its first 3 frames are there"):
            film.frame()
    assert len(frames_of(tmp_path / "film.webp")[0]) == 3
    with pytest.raises(ParameterError, match="is ended; make another"):
        film.frame()


def test_a_film_without_frames_is_none_and_what_was_there_stays(world, tmp_path):
    path = tmp_path / "film.webp"
    path.write_bytes(b"another")
    Recorder(world, path).close()
    assert path.read_bytes() == b"another"
    assert os.listdir(tmp_path) == ["film.webp"]


def test_a_body_that_flies_away_ends_the_film_with_its_error(world, tmp_path):
    film = Recorder(world, tmp_path / "film.webp", size=SMALL)
    film.run(0.1, 5e-3)
    with pytest.raises(softbody.SimulationError), film:
        film.run(10.0, 0.05, allow_unstable=True)
    assert len(frames_of(tmp_path / "film.webp")[0]) >= 3


def test_pictures_of_another_film_are_not_mixed_with_new_ones(world, tmp_path):
    with Recorder(world, tmp_path / "frames", size=SMALL) as film:
        film.frame()
    with pytest.raises(OutputError, match="has the pictures of another film; give a new folder"):
        Recorder(world, tmp_path / "frames")


@pytest.mark.parametrize("name", ["film.webp", "a.png"])
@pytest.mark.parametrize("wrong", ["folder", "missing", "file"])
def test_what_is_in_the_way_is_said_before_any_work(world, tmp_path, name, wrong):
    path = tmp_path / name
    if wrong == "folder":
        path.mkdir()
    else:
        path = tmp_path / "sub" / name
        if wrong == "file":
            (tmp_path / "sub").write_text("no folder")
    message = {"folder": "is a folder; give the name of a file"}.get(wrong, "there is no folder .*sub; make it first")
    with pytest.raises(OutputError, match=message):
        world.picture(path) if name == "a.png" else Recorder(world, path)


@pytest.mark.parametrize("make", [Recorder, softbody.World.picture])
def test_a_full_disk_is_said_before_any_work(world, tmp_path, monkeypatch, make):
    def full(descriptor):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(films.os, "fsync", full)
    name = tmp_path / ("film.webp" if make is Recorder else "a.png")
    with pytest.raises(OutputError, match=f"{name.name} cannot be written: No space left on device"):
        make(world, name)
    assert not os.listdir(tmp_path)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (("film.gif",), "film.gif is of no kind of film; give a name that ends in .webp, .mp4"),
        (("film.webp", 0.0), "frames_per_second is 0"),
        (("",), "path is ''; give the name of a file"),
        ((3,), "path is 3; give the name of a file"),
    ],
)
def test_what_cannot_be_a_film_is_refused(world, tmp_path, monkeypatch, given, message):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ParameterError, match=message):
        Recorder(world, *given)
    assert not os.listdir(tmp_path)


def test_a_quantity_needs_a_range_for_a_film(world, tmp_path):
    with pytest.raises(ParameterError, match="a film by strain needs a colour_range"):
        Recorder(world, tmp_path / "film.webp", colour="strain")


def test_a_time_step_longer_than_a_frame_is_refused(world, tmp_path):
    with (
        Recorder(world, tmp_path / "film.webp", 20.0) as film,
        pytest.raises(ParameterError, match=r"time_step is 0\.06"),
    ):
        film.run(1.0, 0.06)


def test_a_picture_of_another_kind_is_refused(world, tmp_path):
    with pytest.raises(ParameterError, match=r"give one that ends in \.png"):
        world.picture(tmp_path / "a.jpg")


@pytest.mark.parametrize(("name", "module", "extra"), [("a.webp", "PIL", "record"), ("a.mp4", "imageio_ffmpeg", "mp4")])
def test_a_library_that_is_missing_is_named_with_its_cure(world, tmp_path, monkeypatch, name, module, extra):
    for found in [each for each in sys.modules if each.partition(".")[0] == module]:
        monkeypatch.delitem(sys.modules, found)
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(MissingPackageError, match=rf"pip install softbody\[{extra}\]"):
        Recorder(world, tmp_path / name)
    assert not os.listdir(tmp_path)


def test_an_mp4_film_has_the_frames_that_were_taken(world, tmp_path):
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    with Recorder(world, tmp_path / "film.mp4", 20.0, size=SMALL, last_frame=0.5) as film:
        film.run(0.2, 5e-3)
    assert os.listdir(tmp_path) == ["film.mp4"]
    count, seconds = ffmpeg.count_frames_and_secs(str(tmp_path / "film.mp4"))
    assert count == 5 + 10
    assert abs(seconds - 0.75) < 0.06


def test_the_last_frame_can_be_kept_as_a_picture(world, tmp_path):
    with Recorder(world, tmp_path / "frames", size=SMALL) as film:
        with pytest.raises(ParameterError, match="no frame was taken yet"):
            film.still(tmp_path / "still.png")
        film.run(0.1, 5e-3)
        film.still(tmp_path / "still.png")
    assert (tmp_path / "still.png").read_bytes() == (tmp_path / "frames" / "000002.png").read_bytes()


def test_a_run_without_a_time_step_takes_every_frame_on_time(world, tmp_path):
    at = []
    film = Recorder(
        world, tmp_path / "f", 20.0, size=SMALL, camera=lambda w: at.append(w.time) or Camera((0, -6, 1), (0, 0, 1))
    )
    with film:
        film.run(0.1)
        film.run(0.1)
    np.testing.assert_allclose(at, [0.0, 0.05, 0.1, 0.15, 0.2], atol=1e-12)
