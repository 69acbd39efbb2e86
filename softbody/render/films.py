"""Kinds of films (WebP, MP4, a folder of PNG pictures), and whether one can be written somewhere."""

from __future__ import annotations

import io
import os
import secrets
from abc import ABC, abstractmethod
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import cast

import numpy as np

from softbody.errors import OutputError, ParameterError
from softbody.extras import library
from softbody.render.png import png_of
from softbody.render.webp import WebpFilm
from softbody.storage.atomic_file import path_of, whole_file

PROBE = 1 << 18  # bytes for which there must be room on the disk before the first frame is made


class Film(ABC):
    """What frames are added to."""

    @abstractmethod
    def add(self, picture: np.ndarray, milliseconds: int) -> None:
        """Add a frame (h, w, 3) of uint8 that stays for so long; raises OSError as the disk does."""

    @abstractmethod
    def end(self, milliseconds: int) -> None:
        """Make what was added a film, whose last frame stays for so long."""

    def drop(self) -> None:  # noqa: B027
        """Leave nothing: there are no frames."""


class PngFolder(Film):
    """A folder of pictures 000000.png, 000001.png, …"""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._count = 0
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.glob("[0-9]" * 6 + ".png")):
            raise OutputError(f"{folder} has the pictures of another film; give a new folder")
        _probe(folder / f"{0:06d}.png")

    def add(self, picture: np.ndarray, milliseconds: int) -> None:
        """Write the next picture."""
        save_picture(self._folder / f"{self._count:06d}.png", picture)
        self._count += 1

    def end(self, milliseconds: int) -> None:
        """Do nothing: every picture is a file of its own."""


class WebpFile(Film):
    """A WebP file that loops."""

    def __init__(self, path: Path, size: tuple[int, int], quality: int) -> None:
        images = library("PIL.Image", "Pillow", "record", "a WebP film")
        _probe(path)
        with ExitStack() as stack:
            self._file = stack.enter_context(whole_file(path))
            self._film = WebpFilm(cast(io.FileIO, self._file.raw), size, quality, images)
            self._stack = stack.pop_all()

    def add(self, picture: np.ndarray, milliseconds: int) -> None:
        """Append a frame."""
        self._film.add(picture, milliseconds)

    def end(self, milliseconds: int) -> None:
        """Put the file in its place."""
        self._film.end(milliseconds)
        self._stack.close()

    def drop(self) -> None:
        """Leave what stood in its place."""
        self._stack.__exit__(EOFError, EOFError(), None)


class Mp4File(Film):
    """An MP4 file (H.264) by the ffmpeg that imageio-ffmpeg brings."""

    def __init__(self, path: Path, size: tuple[int, int], frames_per_second: float, quality: int) -> None:
        ffmpeg = library("imageio_ffmpeg", "imageio-ffmpeg", "mp4", "an MP4 film")
        if size[0] % 2 or size[1] % 2:
            raise ParameterError(f"size is {size}; an MP4 film needs even numbers of pixels")
        _probe(path)
        self._path, self._part = path, path.with_name(f".{secrets.token_hex(8)}.part")
        self._frame_time = 1000.0 / frames_per_second
        self._picture: np.ndarray | None = None
        self._writer = ffmpeg.write_frames(
            str(self._part), size, fps=frames_per_second, quality=quality / 10.0, macro_block_size=2,
            output_params=["-f", "mp4"], ffmpeg_log_level="error",
        )  # fmt: skip
        self._writer.send(None)

    def add(self, picture: np.ndarray, milliseconds: int) -> None:
        """Hand a frame to ffmpeg."""
        self._picture = picture
        self._writer.send(np.ascontiguousarray(picture))

    def end(self, milliseconds: int) -> None:
        """Repeat the last frame until its time is up, and put the file in its place."""
        for _ in range(round(milliseconds / self._frame_time) - 1):
            self._writer.send(np.ascontiguousarray(self._picture))
        self._writer.close()
        self._part.replace(self._path)

    def drop(self) -> None:
        """Leave what stood in its place."""
        self._writer.close()
        self._part.unlink(missing_ok=True)


def film_at(
    path: str | os.PathLike[str], size: tuple[int, int], frames_per_second: float, quality: int
) -> tuple[Path, Film]:
    """Return an empty film, of the kind that the end of `path` says, and its path.

    Raises OutputError where none can be written, ParameterError for another kind, MissingPackageError.
    """
    place = path_of(path)
    try:
        if place.suffix == "":
            return place, PngFolder(place)
        if place.suffix == ".webp":
            return place, WebpFile(place, size, quality)
        if place.suffix == ".mp4":
            return place, Mp4File(place, size, frames_per_second, quality)
    except OSError as error:
        raise refused(place, error) from error
    raise ParameterError(
        f"{place} is of no kind of film; give a name that ends in .webp, .mp4, or a folder for pictures"
    )


def picture_path(path: str | os.PathLike[str]) -> Path:
    """Return where a PNG picture will be written; raises ParameterError or OutputError if it cannot be."""
    place = path_of(path)
    if place.suffix != ".png":
        raise ParameterError(f"{place} is no name for a picture; give one that ends in .png")
    try:
        _probe(place)
    except OSError as error:
        raise refused(place, error) from error
    return place


def save_picture(path: Path, picture: np.ndarray) -> None:
    """Write a picture (h, w, 3) of uint8 to a PNG file, whole or not at all; raises OutputError."""
    try:
        with whole_file(path) as file:
            file.write(png_of(picture))
    except OSError as error:
        raise refused(path, error) from error


def refused(path: Path, error: OSError, recorded: str = "") -> OutputError:
    """Return the error that says what the disk said of a picture or film at `path`, and what was recorded."""
    if isinstance(error, OutputError):
        return error
    return OutputError(f"{path} cannot be written: {error.strerror or error}{recorded}")


def _probe(path: Path) -> None:
    """Raise OSError unless there is a folder to write to, with some room, and no folder where the file shall be."""
    if path.is_dir():
        raise OutputError(f"{path} is a folder; give the name of a file")
    if not path.parent.is_dir():
        raise OutputError(f"{path} cannot be written: there is no folder {path.parent}; make it first")
    with suppress(_HadRoomError), whole_file(path) as file:
        file.write(b"\0" * PROBE)
        file.flush()
        os.fsync(file.fileno())
        raise _HadRoomError  # so that what stands at the path stays


class _HadRoomError(Exception):
    """What ends a probe that went well."""
