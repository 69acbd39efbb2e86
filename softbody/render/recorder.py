"""Recorder of a world: films while it moves, and pictures as it is."""

from __future__ import annotations

import os
from collections.abc import Callable
from types import TracebackType
from typing import Any

import numpy as np

from softbody.bodies.store import HasStore
from softbody.errors import ParameterError
from softbody.model.validation import check_range, check_whole, shown
from softbody.render.camera import Camera
from softbody.render.drawing import Drawing, framed, ground_of, liquid_of
from softbody.render.films import film_at, picture_path, refused, save_picture
from softbody.render.lines import lines
from softbody.render.quantities import QUANTITIES
from softbody.render.rasteriser import render
from softbody.stepping.frames import frames, frames_by_steps
from softbody.stepping.runner import Steppable
from softbody.stepping.time_steps import check_own_steps

MOST_PIXELS = 8192  # of a picture, each way
SIZE = (640, 480)


def picture(
    world: HasStore,
    path: str | os.PathLike[str] | None,
    camera: Camera | None,
    size: tuple[int, int],
    drawing: Drawing,
) -> np.ndarray:
    """Do what `World.picture` says."""
    size, camera = _checked_size(size), _checked_camera(camera)
    place = None if path is None else picture_path(path)
    pixels = _pixels(world, drawing, camera, size)
    if place is not None:
        save_picture(place, pixels)
    return pixels


class Recorder:
    """A film of a world, frame by frame, to a looping .webp, an .mp4, or a folder of PNG pictures, as `path` says.

    `with Recorder(world, "film.webp") as film: film.run(seconds=2.0)`, or `film.frame()` wherever one
    is to be taken. `frames_per_second` is how fast the film is shown, and how often `run` takes a frame.

    `camera`: a Camera, a function of the world that returns one for each frame, or None for one that frames the scene
    as it is in the first frame. `size` (width, height) [pixels]. `colour`, `colour_range`, `colour_map` and
    `show_joints` as for `World.picture`; a quantity needs a range, so that its colours mean the same in every frame.
    `quality` 1 … 100.
    `last_frame` [s] is how long the last one stays before the film begins again.

    Whatever cannot work is said at once, by an OutputError, ParameterError or MissingPackageError. Where the block
    ends early, by an error or an interrupt, or the disk is full, the frames until then are a film. What stood at `path`
    stays until the film is whole. Same frames, same versions of the libraries: same bytes.
    """

    def __init__(
        self,
        world: Steppable,
        path: str | os.PathLike[str],
        frames_per_second: float = 20.0,
        *,
        camera: Camera | Callable[[Any], Camera] | None = None,
        size: tuple[int, int] = SIZE,
        colour: str = "stripes",
        colour_range: tuple[float, float] | None = None,
        colour_map: str = "viridis",
        show_joints: bool = True,
        quality: int = 75,
        last_frame: float = 0.0,
    ) -> None:
        rate = check_range(frames_per_second, "frames_per_second", "1/s", above=0.0, most=1000.0)
        quality = check_whole(quality, "quality", 1, 100)
        self._last_frame = check_range(last_frame, "last_frame", "s", least=0.0, most=1000.0)
        self._size = _checked_size(size)
        self._camera = camera if callable(camera) else _checked_camera(camera)
        self._drawing = Drawing(world, colour, colour_range, colour_map, show_joints)
        if colour in QUANTITIES and colour_range is None:
            raise ParameterError(f"a film by {colour} needs a colour_range; give the least and the greatest number")
        self._world, self._rate = world, rate
        self._begun = world.store.time
        self.frames = 0  # that were taken
        self._is_open = True
        self._pixels: np.ndarray | None = None  # of the last frame
        self._path, self._film = film_at(path, self._size, rate, quality)

    def __enter__(self) -> Recorder:
        """Return the recorder."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """End the film with the frames so far, whatever has happened."""
        self.close()

    def frame(self) -> None:
        """Take a frame of the world as it is; raises OutputError where the disk is full, and ends the film."""
        if not self._is_open:
            raise ParameterError(f"{self._path} is ended; make another Recorder")
        if self._camera is None:
            things, ends = self._drawing.things(), self._drawing.joint_ends()
            self._camera = framed(self._world, things, ends, self._size[0] / self._size[1])
        camera = self._camera if isinstance(self._camera, Camera) else _checked_camera(self._camera(self._world))
        pixels = _pixels(self._world, self._drawing, camera, self._size)
        try:
            self._film.add(pixels, self._milliseconds())
            self._pixels = pixels
        except OSError as error:
            self.close()
            recorded = f"; its first {self.frames} frames are there" if self.frames else ""
            raise refused(self._path, error, recorded) from error
        self.frames += 1

    def still(self, path: str | os.PathLike[str]) -> None:
        """Write the last frame to a PNG file, as the film has it before it is compressed."""
        if self._pixels is None:
            raise ParameterError("no frame was taken yet; call frame() or run() first")
        save_picture(picture_path(path), self._pixels)

    def run(
        self,
        seconds: float,
        time_step: float | None = None,
        *,
        substeps: int | None = None,
        allow_unstable: bool = False,
    ) -> None:
        """Advance the world as `World.run` does, and take a frame whenever it is time for one.

        Without a `time_step` the world chooses it from frame to frame. With one, frame k is that of the
        step nearest to k / frames_per_second since the first; the first is taken at once. Raises ParameterError for a
        time step that is longer than a frame stays.
        """
        seconds = check_range(seconds, "seconds", "s", least=0.0)
        check_own_steps(time_step, substeps, allow_unstable)
        if time_step is None:
            if self.frames == 0:
                self.frame()
            for _ in frames(self._world.runner, seconds, self._rate):
                self.frame()
            return
        if self.frames == 0:
            self._begun = self._world.store.time
            check_range(time_step, "time_step", "s", above=0.0, most=1.0 / self._rate)
            self.frame()
        runner, taken = self._world.runner, (self.frames, self._begun)
        for _ in frames_by_steps(runner, seconds, time_step, self._rate, taken, substeps, allow_unstable):
            self.frame()

    def close(self) -> None:
        """End the film; without frames there is none. A second call does nothing."""
        if not self._is_open:
            return
        self._is_open = False
        try:
            if self.frames:
                self._film.end(self._milliseconds(-1) + round(1000.0 * self._last_frame))
            else:
                self._film.drop()
        except OSError as error:
            raise refused(self._path, error) from error

    def _milliseconds(self, ahead: int = 0) -> int:
        """Return how long the next frame stays: whole milliseconds that never drift from the clock."""
        k = self.frames + ahead
        return round(1000.0 * (k + 1) / self._rate) - round(1000.0 * k / self._rate)


def _pixels(world: HasStore, drawing: Drawing, camera: Camera | None, size: tuple[int, int]) -> np.ndarray:
    things, ends = drawing.things(), drawing.joint_ends()
    camera = camera or framed(world, things, ends, size[0] / size[1])
    return render([*things, *lines(ends, camera)], camera, ground_of(world), size, liquid_of(world))


def _checked_size(size: tuple[int, int]) -> tuple[int, int]:
    try:
        width, height = size
    except (TypeError, ValueError) as error:
        raise ParameterError(f"size is {shown(size)}; give width and height [pixels]") from error
    return check_whole(width, "width of size", 1, MOST_PIXELS), check_whole(height, "height of size", 1, MOST_PIXELS)


def _checked_camera(camera: Camera | None) -> Camera | None:
    if not isinstance(camera, (Camera, type(None))):
        raise ParameterError(
            f"camera is {shown(camera)}; give a softbody.Camera, or none for one that frames the scene"
        )
    return camera
