"""A file of any bytes is refused with the core's own error, in the memory that was allowed, or is a world like any."""

from __future__ import annotations

import io
import tempfile
import tracemalloc
import warnings
import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

from softbody import SnapshotError, World
from tests.fuzz._worlds import lived, snapshots

GOAL = 20_000

Rng = np.random.Generator

MOST_BYTES = 2**20  # that World.load is allowed
ROOM = 4 * MOST_BYTES  # what it may take in all: the file, its arrays, their copies, and Python's own


@cache
def saved(kind: int, compressed: bool) -> bytes:
    """Return the bytes of a file of a world."""
    file = io.BytesIO()
    (np.savez_compressed if compressed else np.savez)(file, **snapshots()[kind])  # type: ignore[arg-type]
    return file.getvalue()


@cache
def entries(kind: int) -> dict[str, bytes]:
    """Return the bytes of each array of a world, as they stand in a file."""
    with zipfile.ZipFile(io.BytesIO(saved(kind, False))) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def packed(parts: list[tuple[str, bytes]], rng: Rng) -> bytes:
    """Return an archive of entries, with the right sums."""
    file, ways = io.BytesIO(), [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA]
    way = ways[rng.choice(4, p=(0.6, 0.3, 0.05, 0.05))]
    with warnings.catch_warnings(), zipfile.ZipFile(file, "w", way) as archive:
        warnings.simplefilter("ignore")  # of names that are there twice
        for name, raw in parts:
            if name.partition("\0")[0]:  # an empty name is more than zipfile writes
                archive.writestr(name, raw)
    return file.getvalue()


def _place(raw: bytes, rng: Rng) -> int:
    """Return a place: often near the end, where an archive says what it holds."""
    near = rng.random() < 0.4
    return int(rng.integers(max(0, len(raw) - 5000) if near else 0, len(raw)))


def flipped(raw: bytes, rng: Rng) -> bytes:
    """Flip some bits."""
    changed = bytearray(raw)
    for _ in range(rng.integers(1, 9)):
        changed[_place(raw, rng)] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def written_over(raw: bytes, rng: Rng) -> bytes:
    """Write over a stretch."""
    place, size = _place(raw, rng), int(2 ** rng.uniform(0, 8))
    filling = (b"\x00" * size, b"\xff" * size, rng.bytes(size))[rng.integers(3)]
    return raw[:place] + filling + raw[place + size :]


def cut(raw: bytes, rng: Rng) -> bytes:
    """Cut off the end, or the beginning."""
    place = _place(raw, rng)
    return raw[:place] if rng.random() < 0.8 else raw[place:]


def spliced(raw: bytes, rng: Rng) -> bytes:
    """Take a stretch out, put one in, or put one elsewhere."""
    a, b, c = sorted(_place(raw, rng) for _ in range(3))
    ways = raw[:a] + raw[b:], raw[:b] + raw[a:], raw[:a] + raw[b:c] + raw[a:b] + raw[c:], raw + raw[a:]
    return ways[rng.integers(len(ways))]


def no_archive(raw: bytes, rng: Rng) -> bytes:
    """Be something else altogether."""
    ways = b"", rng.bytes(100), b"PK\x05\x06" + b"\x00" * 18, b"PK", raw[:4] * 100, b"\x93NUMPY" + rng.bytes(200), b"{}"
    return ways[rng.integers(len(ways))]


def entry_damaged(raw: bytes, rng: Rng) -> bytes:
    """Damage the bytes of an array, with the right sum."""
    parts = dict(entries(int(rng.integers(len(snapshots())))))
    name = str(rng.choice(list(parts)))
    head = parts[name][:128] if rng.random() < 0.5 else parts[name]
    ways: tuple[Callable[[bytes, Rng], bytes], ...] = flipped, written_over, cut, spliced
    changed = ways[rng.integers(len(ways))](head, rng)
    return packed(list((parts | {name: changed + parts[name][len(head) :]}).items()), rng)


def header_crafted(raw: bytes, rng: Rng) -> bytes:
    """Say something else of an array than what it is, with the right sum."""
    parts = dict(entries(int(rng.integers(len(snapshots())))))
    name = str(rng.choice(list(parts)))
    kinds = "'<f8'", "'>f8'", "'|O'", "'<U9999999'", "'|V8'", "[('a', '<f8')]", "'<i8'", "8", "'nonsense'", "None"
    shapes = (
        "()",
        "(3,)",
        "(10**9,)",
        "(1000000000000,)",
        "(-1,)",
        "(0, 9999999999999)",
        "(2, 3)",
        "'a'",
        "3",
        "((((1,),),),)",
    )
    kind, shape = str(rng.choice(kinds)), str(rng.choice(shapes))
    header = f"{{'descr': {kind}, 'fortran_order': {rng.choice(['True', 'False', '2'])}, 'shape': {shape}, }}\n"
    deep = "-" * 60_000 + "1", "(" * 900, "[" * 20_000 + "]" * 20_000, "{}", "", "\x00", "ä"
    text = (header if rng.random() < 0.8 else str(rng.choice(deep))).encode()[:65_535]
    version = ((1, 0), (2, 0), (3, 0), (9, 9))[rng.choice(4, p=(0.7, 0.1, 0.1, 0.1))]
    length = len(text).to_bytes(2 if version == (1, 0) else 4, "little")
    body = parts[name][128:] if rng.random() < 0.5 else b"\x00" * int(rng.integers(10**5))
    crafted = b"\x93NUMPY" + bytes(version) + length + text + body
    return packed(list((parts | {name: crafted}).items()), rng)


def archive_crafted(raw: bytes, rng: Rng) -> bytes:
    """Be an archive of arrays that no world has, or has twice, or that are larger than allowed."""
    parts = list(entries(int(rng.integers(len(snapshots())))).items())
    name, data = parts[rng.integers(len(parts))]
    large = b"\x93NUMPY\x01\x00" + (118).to_bytes(2, "little")
    large += f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({10**6},), }}".encode().ljust(117) + b"\n"
    ways: tuple[Callable[[], list[tuple[str, bytes]]], ...] = (
        lambda: [*parts, (name, data)],
        lambda: [*parts, ("../" * 5 + name, data)],
        lambda: [*parts, (name.upper(), data)],
        lambda: [*parts, ("a/b", data)],
        lambda: [(one, raw) for one, raw in parts if one != name],
        lambda: [(one.removesuffix(".npy"), raw) for one, raw in parts],
        lambda: [*parts, *((f"{k}.npy", data) for k in range(2000))],
        lambda: [(one, raw if one != name else large + b"\x00" * 8 * 10**6) for one, raw in parts],
        lambda: [*parts, ("x.npy", large + b"\x00" * 8 * 10**6)],
    )
    return packed(ways[rng.integers(len(ways))](), rng)


def directory_crafted(raw: bytes, rng: Rng) -> bytes:
    """Say something else of an entry than what it is: sizes, flags, way of packing, offset, sum."""
    changed, marks = (
        bytearray(raw),
        {b"PK\x03\x04": (6, 8, 14, 18, 22, 26, 28), b"PK\x01\x02": (8, 10, 16, 20, 24, 28, 30, 42)},
    )
    mark = list(marks)[rng.integers(2)]
    places = [k for k in range(len(raw)) if raw.startswith(mark, k)]
    for place in places if rng.random() < 0.1 else [places[rng.integers(len(places))]]:
        field = place + int(rng.choice(marks[mark]))
        value = int(rng.choice([0, 1, 8, 9, 12, 14, 99, 0xFFFF, 0xFFFFFFFF, 2**31, 100, 10**6]))
        size = 4 if value > 0xFFFF or rng.random() < 0.5 else 2
        changed[field : field + size] = value.to_bytes(size, "little")
    return bytes(changed)


def deflated_damaged(raw: bytes, rng: Rng) -> bytes:
    """Damage what is compressed."""
    return flipped(saved(int(rng.integers(len(snapshots()))), True), rng)


WAYS: tuple[Callable[[bytes, Rng], bytes], ...] = (
    flipped, written_over, cut, spliced, no_archive, entry_damaged, entry_damaged, header_crafted, header_crafted,
    archive_crafted, directory_crafted, deflated_damaged,
)  # fmt: skip


def attempt(seed: int) -> str | None:
    """Read a file that was damaged in the way that is its turn."""
    rng = np.random.default_rng(seed)
    way = WAYS[seed % len(WAYS)]
    raw = way(saved(int(rng.integers(len(snapshots()))), False), rng)
    world, most = None, 0
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "world.npz"
        path.write_bytes(raw)
        tracemalloc.start()
        try:
            world = World.load(path, MOST_BYTES)
        except SnapshotError as error:
            if str(path) not in str(error):
                return f"{way.__name__}: refused, and the file is not named: {error}"
        finally:
            most = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
    if most > ROOM:
        return f"{way.__name__}: {most} bytes were taken, for a file of {len(raw)} and {MOST_BYTES} allowed"
    wrong = world and lived(world, rng)
    return f"{way.__name__}: {wrong}" if wrong else None
