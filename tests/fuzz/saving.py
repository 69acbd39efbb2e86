"""Whatever happens while a world is saved, its file is whole: the one before, or the new one.

Two processes write and one reads; a writer is killed; the disk has no room; an interrupt comes; a link is in the way.
"""

from __future__ import annotations

import os
import resource
import signal
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from softbody import SnapshotError, World

Rng = np.random.Generator


def _world(number: int) -> World:
    """Return one of many worlds, of different sizes, that can be told apart."""
    world = World(gravity=(0.0, 0.0, float(number)))
    for k in range(1 + 40 * (number % 5)):
        world.add_box((1.0, 1.0, 1.0), 1.0, (2.0 * k, 0.0, 0.0))
    return world


def _number(path: Path) -> int:
    """Return which world a file holds."""
    return int(World.load(path).controls.gravity[2])


def _left(path: Path) -> list[str]:
    """Return what else is in the folder of a file."""
    return [found.name for found in path.parent.iterdir() if found != path]


def _in_child(work: Callable[[], object]) -> int:
    """Do something in a process of its own; return its number."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            work()
            code = 0
        finally:
            os._exit(code)
    return child


def _ended(child: int) -> int:
    """Wait for a process; return how it ended."""
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def two_writers_and_a_reader(path: Path, rng: Rng) -> str | None:
    """All at once."""
    worlds = _world(1), _world(2)

    def write(one: int) -> None:
        for _ in range(5):
            worlds[one].save(path)

    writers = [_in_child(lambda one=one: write(one)) for one in range(2)]
    wrong = None
    try:
        for _ in range(10):
            if _number(path) not in (0, 1, 2):
                wrong = "a reader saw another world"
    except SnapshotError as error:
        wrong = f"a reader saw a file that is not whole: {error}"
    codes = [_ended(child) for child in writers]
    if any(codes):
        return f"a writer ended with {codes}"
    return wrong or (f"left: {_left(path)}" if _left(path) else None)


def killed(path: Path, rng: Rng) -> str | None:
    """A process is killed while it saves."""
    world = _world(int(rng.integers(1, 9)))

    def write() -> None:
        while True:
            world.save(path)

    child = _in_child(write)
    time.sleep(float(rng.uniform(0.0, 0.01)))
    os.kill(child, signal.SIGKILL)
    _ended(child)
    if _number(path) not in (0, int(world.controls.gravity[2])):
        return "there is another world"
    if not all(name.endswith(".part") for name in _left(path)):
        return f"left: {_left(path)}"
    return None


def no_room(path: Path, rng: Rng) -> str | None:
    """The disk takes only so many bytes of a file."""
    before, world = path.read_bytes(), _world(4)
    world.save(path.with_name("other"))
    size = path.with_name("other").stat().st_size
    path.with_name("other").unlink()
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(rng.integers(0, size)), hard))
    try:
        world.save(path)
        return "no error where there was no room"
    except OSError:
        pass
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    if path.read_bytes() != before:
        return "the file before is gone"
    return f"left: {_left(path)}" if _left(path) else None


def interrupted(path: Path, rng: Rng) -> str | None:
    """An interrupt comes while a world is saved."""
    world = _world(int(rng.integers(1, 9)))
    old = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, float(rng.uniform(1e-5, 5e-3)))
        for _ in range(100):
            world.save(path)
    except KeyboardInterrupt:
        pass
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, old)
    return None if _number(path) in (0, int(world.controls.gravity[2])) else "there is another world"


def a_link(path: Path, rng: Rng) -> str | None:
    """The name is a link to something precious."""
    precious = path.with_name("precious")
    path.replace(precious)
    before = precious.read_bytes()
    path.symlink_to(precious)
    _world(1).save(path)
    return None if precious.read_bytes() == before and _number(path) == 1 else "it was written through the link"


WAYS: tuple[Callable[[Path, Rng], str | None], ...] = two_writers_and_a_reader, killed, no_room, interrupted, a_link


def attempt(seed: int) -> str | None:
    """Save in the way whose turn it is, where another world has been saved before."""
    rng, way = np.random.default_rng(seed), WAYS[seed % len(WAYS)]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "world.npz"
        _world(0).save(path)
        wrong = way(path, rng)
    return f"{way.__name__}: {wrong}" if wrong else None
