"""Writer of WebP films that grow by a frame at a time: RFC 9649; Pillow compresses each frame.

Of every frame only the rectangle that has changed is kept; and that which changed in the frame before, once more, for
what moves leaves traces of its compression around it. Whatever is written is a film as soon as it is ended: a full
disk or an interrupt costs the frame that it comes in.
"""

from __future__ import annotations

import io
import struct
from typing import Any

import numpy as np

METHOD = 4  # of 0 (fast) … 6 (small)
ANIMATED, OPAQUE = 0x02, 0x02  # flags of the file, and of a frame that covers what was there
DURATION = 8 + 12  # bytes from the beginning of a frame to how long it stays


class WebpFilm:
    """A film of frames (h, w, 3) of uint8, written to an unbuffered `file` that can seek; it loops."""

    def __init__(self, file: io.FileIO, size: tuple[int, int], quality: int, images: Any) -> None:
        self._file = file
        self._quality = quality
        self._images = images  # Pillow's module Image
        self._before: np.ndarray | None = None
        self._stale: tuple[int, int, int, int] | None = None  # what changed in the frame before
        self._last = 0  # where the last frame begins
        self._end = 0  # of what is whole
        canvas = struct.pack("<B3x", ANIMATED) + _three(size[0] - 1) + _three(size[1] - 1)
        self._add(b"RIFF\0\0\0\0WEBP" + _chunk(b"VP8X", canvas) + _chunk(b"ANIM", struct.pack("<IH", 0, 0)))

    def add(self, picture: np.ndarray, milliseconds: int) -> None:
        """Add a frame that stays for so long."""
        changed = _changed(self._before, picture)
        left, top, right, bottom = changed if self._stale is None else _around(changed, self._stale)
        part = picture[top:bottom, left:right]
        place = _three(left // 2) + _three(top // 2) + _three(right - left - 1) + _three(bottom - top - 1)
        start = self._end
        frame = place + _three(milliseconds) + struct.pack("<B", OPAQUE) + self._compressed(part)
        self._add(_chunk(b"ANMF", frame))
        self._stale = changed if self._before is not None else None
        self._before, self._last = picture, start

    def end(self, milliseconds: int) -> None:
        """Make a file of the frames so far, the last of which stays for so long."""
        self._file.truncate(self._end)
        self._file.seek(4)
        _write(self._file, struct.pack("<I", self._end - 8))
        self._file.seek(self._last + DURATION)
        _write(self._file, _three(milliseconds))

    def _compressed(self, part: np.ndarray) -> bytes:
        """Return the chunk of a picture's own file that holds the picture."""
        buffer = io.BytesIO()
        self._images.fromarray(np.ascontiguousarray(part)).save(buffer, "WEBP", quality=self._quality, method=METHOD)
        raw = buffer.getvalue()
        return raw[raw.index(b"VP8 ", 12) :]

    def _add(self, chunk: bytes) -> None:
        self._file.seek(self._end)
        _write(self._file, chunk)
        self._end += len(chunk)


def _changed(before: np.ndarray | None, now: np.ndarray) -> tuple[int, int, int, int]:
    """Return left, top, right and bottom of what has changed; the first two are even, as the format has it."""
    height, width = now.shape[:2]
    if before is None:
        return 0, 0, width, height
    differs = (before != now).any(axis=2)
    rows, columns = np.flatnonzero(differs.any(axis=1)), np.flatnonzero(differs.any(axis=0))
    if not len(rows):
        return width // 4 * 2, height // 4 * 2, width // 4 * 2 + 1, height // 4 * 2 + 1
    return int(columns[0]) // 2 * 2, int(rows[0]) // 2 * 2, int(columns[-1]) + 1, int(rows[-1]) + 1


def _around(one: tuple[int, int, int, int], other: tuple[int, int, int, int]) -> tuple[int, int, int, int]:
    """Return the rectangle around two."""
    return min(one[0], other[0]), min(one[1], other[1]), max(one[2], other[2]), max(one[3], other[3])


def _three(number: int) -> bytes:
    return struct.pack("<I", number)[:3]


def _chunk(kind: bytes, data: bytes) -> bytes:
    return kind + struct.pack("<I", len(data)) + data + b"\0" * (len(data) % 2)


def _write(file: io.FileIO, data: bytes) -> None:
    """Write all: an unbuffered file may take less at once, and one with a buffer would keep what the disk refused."""
    left = memoryview(data)
    while left:
        left = left[file.write(left) :]
