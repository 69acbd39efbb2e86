"""Whatever happens while a world is saved, kept, filmed or exported, its file is whole: the one before, or the new one.

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

from softbody import OutputError, Recorder, SnapshotError, Trajectory, TrajectoryError, TrajectoryWriter, World

TRIES = 10  # saves an attempt
GOAL = 10_000

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
    for _ in range(TRIES):
        world = _world(int(rng.integers(1, 9)))
        before = _number(path)
        _kill(lambda world=world: world.save(path), float(rng.uniform(0.0, 0.01)))
        if _number(path) not in (before, int(world.controls.gravity[2])):
            return "there is another world"
    return None if all(name.endswith(".part") for name in _left(path)) else f"left: {_left(path)}"


def _kill(work: Callable[[], object], seconds: float) -> None:
    """Do something again and again in a process, and kill that after so long [s]."""

    def go() -> None:
        while True:
            work()

    child = _in_child(go)
    time.sleep(seconds)
    os.kill(child, signal.SIGKILL)
    _ended(child)


def no_room(path: Path, rng: Rng) -> str | None:
    """The disk takes only so many bytes of a file."""
    before, world = path.read_bytes(), _world(4)
    world.save(path.with_name("other"))
    size = path.with_name("other").stat().st_size
    path.with_name("other").unlink()
    for _ in range(TRIES):
        wrong = _refused(lambda: world.save(path), int(rng.integers(0, size)))
        if wrong or path.read_bytes() != before:
            return wrong or "the file before is gone"
    return f"left: {_left(path)}" if _left(path) else None


def _refused(work: Callable[[], object], room: int) -> str | None:
    """Do something where the disk takes only so many bytes of a file; it must end in an OSError."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, hard))
    try:
        work()
        return "no error where there was no room"
    except OSError:
        return None
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def interrupted(path: Path, rng: Rng) -> str | None:
    """An interrupt comes while a world is saved."""
    for _ in range(TRIES):
        world, before = _world(int(rng.integers(1, 9))), _number(path)
        _interrupt(lambda world=world: world.save(path), float(rng.uniform(1e-5, 5e-3)))
        if _number(path) not in (before, int(world.controls.gravity[2])):
            return "there is another world"
    return None


def _interrupt(work: Callable[[], object], seconds: float) -> None:
    """Do something again and again until an interrupt comes, after so long [s]."""
    old = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, seconds)
        end = time.monotonic() + seconds + 1.0  # Python loses what is raised where nothing can be, as in a destructor
        while time.monotonic() < end:
            work()
    except KeyboardInterrupt:
        pass
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, old)


def a_link(path: Path, rng: Rng) -> str | None:
    """The name is a link to something precious."""
    for k in range(TRIES):
        precious = path.with_name("precious")
        path.replace(precious)
        before = precious.read_bytes()
        path.symlink_to(precious)
        _world(1 + k).save(path)
        if precious.read_bytes() != before or _number(path) != 1 + k:
            return "it was written through the link"
    return None


def two_writers_of_a_trajectory(path: Path, rng: Rng) -> str | None:
    """Both keep frames in one folder, and one reads: one writer has it, and the other is told."""
    folder = path.with_name("kept")

    def keep(one: int) -> None:
        world = _world(5)  # of the same bodies, and something else
        world.state.box_velocity[:] = one
        try:
            with TrajectoryWriter(world, folder, resume=True) as kept:
                for _ in range(TRIES):
                    world.time += 1.0
                    kept.frame()
                    kept.flush()
        except (TrajectoryError, OutputError):
            return

    writers = [_in_child(lambda one=one: keep(one)) for one in range(2)]
    wrong = None
    for _ in range(TRIES):
        wrong = wrong or _flaw_of(folder)
    codes = [_ended(child) for child in writers]
    if any(codes):
        return f"a writer ended with {codes}"
    frames = [int(frame.box_velocities[0, 0]) for frame in Trajectory.open(folder)]
    if len(set(frames)) != 1 or len(frames) < TRIES:
        return f"{len(frames)} frames, of writers {set(frames)}"
    return wrong or _flaw_of(folder)


def _flaw_of(folder: Path) -> str | None:
    """Return what is wrong with the trajectory in a folder, if there is one."""
    for is_last in (False, True):
        try:
            return None if all(np.isfinite(frame.time) for frame in Trajectory.open(folder)) else "a time is not finite"
        except TrajectoryError as error:
            if "holds no trajectory" in str(error):
                return None
            # (Who has begun anew meanwhile has removed what was read.)
            if is_last or "is missing" not in str(error):
                return f"a trajectory that is not whole: {error}"
    return None


def a_trajectory(path: Path, rng: Rng) -> str | None:
    """A trajectory is kept, and its writer is killed, or interrupted, or has no room; it can be gone on with."""
    folder, world = path.with_name("kept"), _world(int(rng.integers(1, 9)))
    count, is_changing = len(world.boxes), bool(rng.integers(2))

    def keep() -> None:
        with TrajectoryWriter(world, folder, resume=True) as kept:
            world.time += 1.0
            kept.frame()
            if is_changing:
                world.time += 1.0
                lamp = world.add_box((1.0, 1.0, 1.0), None, (0.0, 0.0, 99.0))
                kept.frame()
                world.time += 1.0
                world.remove(lamp)
                kept.frame()

    for _ in range(TRIES):
        keep()
        there = len(Trajectory.open(folder))
        way = int(rng.integers(3))
        if way == 0:
            _kill(keep, float(rng.uniform(0.0, 0.02)))
        elif way == 1:
            _interrupt(keep, float(rng.uniform(1e-5, 0.02)))
        elif wrong := _refused(keep, int(rng.integers(0, min(one.stat().st_size for one in folder.glob("0*.npz"))))):
            return wrong
        if wrong := _flaw_of(folder):
            return wrong
        if len(Trajectory.open(folder)) < there:
            return "frames were lost"
        for left in world.boxes[count:]:
            world.remove(left)
        world.time = max(frame.time for frame in Trajectory.open(folder) if frame.bodies.box_count == count)
    return None


def a_film(path: Path, rng: Rng) -> str | None:
    """A film is made, and interrupted, or has no room: it is a film, or what was there before."""
    from PIL import Image

    film, world = path.with_name("film.webp"), _world(1)
    with Recorder(world, film, size=(32, 24)) as first:
        first.frame()

    def make() -> None:
        with Recorder(world, film, size=(32, 24)) as shown:
            for _ in range(20):
                world.time += 1.0
                world.state.box_position[:, 2] += 0.01
                shown.frame()

    for _ in range(TRIES):
        if rng.integers(2):
            _interrupt(make, float(rng.uniform(1e-5, 0.2)))
        else:
            _refused(make, int(2 ** rng.uniform(0.0, 18.0)))
        with Image.open(film) as opened:
            if opened.size != (32, 24) or not 1 <= opened.n_frames <= 21:
                return f"a film of {opened.n_frames} frames"
            for k in range(opened.n_frames):
                opened.seek(k)
                opened.load()
    return None


def an_export(path: Path, rng: Rng) -> str | None:
    """Bodies are exported, which is interrupted, or has no room: what was there before stays, or it is the new file."""
    world = _world(3)
    place = path.with_name(str(rng.choice(["a.obj", "a.ply", "a.glb"])))
    world.export(place)
    one = place.read_bytes()
    world.state.box_position[0, 0] = 1.0
    world.export(place)
    other = place.read_bytes()
    for _ in range(TRIES):
        if rng.integers(2):
            _interrupt(lambda: world.export(place), float(rng.uniform(1e-5, 0.05)))
        elif wrong := _refused(lambda: world.export(place), int(rng.integers(0, len(one) - 1))):
            return wrong
        if place.read_bytes() not in (one, other):
            return "neither the file before nor the new one"
    return f"left: {left}" if (left := [name for name in _left(path) if name != place.name]) else None


WAYS: tuple[Callable[[Path, Rng], str | None], ...] = (
    two_writers_and_a_reader, killed, no_room, interrupted, a_link, two_writers_of_a_trajectory, a_trajectory, a_film,
    an_export,
)  # fmt: skip


def attempt(seed: int) -> str | None:
    """Save in the way whose turn it is, where another world has been saved before."""
    rng, way = np.random.default_rng(seed), WAYS[seed % len(WAYS)]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "world.npz"
        _world(0).save(path)
        wrong = way(path, rng)
    return f"{way.__name__}: {wrong}" if wrong else None
