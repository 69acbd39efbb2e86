"""Claims that a scene file's run into a folder is kept whole, and resumed to the same bits."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from itertools import product
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from softbody import OutputError, Recorder, SceneError, SnapshotError, Trajectory, TrajectoryError, World
from softbody.cli import run_folder
from softbody.cli.run_folder import _advance, _film, _prepared, _world_of, run_scene
from softbody.scenes import from_file
from validation.answers import Answers
from validation.check import Comparison, Run, check
from validation.checks.contract.exports import asked
from validation.checks.contract.kept_files import extend_evenly, row_of
from validation.fault import Fault

FAMILY = "what is kept and exported"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

FALL = 9.81  # [m/s²]


class _EndError(Exception):
    """What ends a run before its time."""


class _Told:
    """What is told of the frames of a run, which take so long [s] each, and ends it after one of them."""

    def __init__(self, each: float = 0.0, end: int | None = None) -> None:
        self.now, self.frames, self.done = 100.0, 0, -1
        self._each, self._end = each, end

    @contextmanager
    def __call__(self, total: int, done: int) -> Iterator[Callable[[int], None]]:
        """Yield what is told of frames, of which some were `done` before."""
        self.done = done
        yield self._tell

    def clock(self) -> float:
        """Return the time [s]: a clock that is set."""
        return self.now

    def _tell(self, frames: int) -> None:
        self.frames = frames
        self.now += self._each
        if frames == self._end:
            raise _EndError


def ended_after(path: Path, out: Path, ends: list[int], each: float = 0.0) -> list[int]:
    """Run a scene file into a folder, ended after some frames, of `each` [s], and gone on with; return from where."""
    begun = []
    for k, end in enumerate([*ends, None]):
        told = _Told(each, end)
        with suppress(_EndError), mock.patch.object(run_folder, "monotonic", told.clock):
            run_scene(path, out, k > 0, told)
        begun.append(told.done)
    return begun


def flying(rng: np.random.Generator, how: str, film: str = "") -> tuple[str, np.ndarray, np.ndarray]:
    """Return a scene file of a ball that flies, run as it says, and where and how fast the ball begins."""
    start, speed = 3.0 * rng.normal(size=3), rng.normal(size=3)
    text = f"""
[world]
gravity = [0.0, 0.0, {-FALL}]
integrator = "rk4"

[[soft_body]]
shape = {{ name = "octahedron", radius = 0.3 }}
mass = 1.0
stiffness = 10.0
gas = 0.0
position = {start.tolist()}
velocity = {speed.tolist()}

[run]
{how}
{film}"""
    return text, start, speed


def written(folder: str, text: str) -> Path:
    """Write a scene file into a folder, and return where it is."""
    path = Path(folder) / "scene.toml"
    path.write_text(text)
    return path


def rows_in(out: Path) -> np.ndarray:
    """Return the `row_of` each frame in the folder of a run, and of the world that was saved last."""
    rows = []
    for frame in Trajectory.open(out / "trajectory"):
        assert frame.velocities is not None
        rows.append(row_of(frame.time, frame.positions, frame.velocities))
    world = World.load(out / "world.npz")
    return np.array([*rows, row_of(world.time, world.soft_bodies[0].positions, world.soft_bodies[0].velocities)])


@check(
    section="beyond the paper",
    piece="softbody.cli.run_folder.run_scene",
    reference="closed form: the parabola at the times that the file asks for",
    kind="closed form",
    unit="of the way and the speed, each at least 1",
    tolerance=4e-14,
    because="rounding over some hundred steps: 1.6e-15 at worst of seven seeds",
    faults=(
        Fault("frames of one's own steps at the end", run_folder._Schedule.advance, "min(steps, r_) → steps"),
        Fault("a last frame that is as long as others", run_folder._Schedule.advance, "even or k < last → True"),
        Fault("a world that is not saved at the end", _advance, "done < schedule.frames → False"),
        Fault("a run that begins again in the midst", _advance, "kept.frames - 1 → 0"),
        Fault(
            "a last frame that is forgotten",
            _advance,
            "range(done + 1, schedule.frames + 1) → range(done + 1, schedule.frames)",
        ),
    ),
)
def balls_are_run(run: Run) -> Comparison:
    """A scene file's ball is kept where its parabola has it.

    The ball flies. Run into a folder, its scene file leaves a frame there each 1/f s, the last one at the end. It
    leaves the world as it is then, too. It is run in steps of the world's choice, or at the ones of one's own nearest
    to those times. It is run at once, or ended after some frames and gone on with.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial, is_own in product(range(run.count(2, 6, 60)), (False, True)):
        is_even = (trial + is_own) % 2 == 0
        rate, count = rng.uniform(20.0, 60.0), int(rng.integers(6, 12))
        seconds = (count - (0.0 if is_even else rng.uniform(0.1, 0.9))) / rate
        how, times = f"seconds = {seconds!r}\nframes_per_second = {rate!r}", np.arange(count + 1) / rate
        times[-1] = seconds
        if is_own:
            between = np.full(count + 1, 0.5)
            while np.any(np.abs(between - 0.5) < 0.01):  # a frame half-way between two steps may be either's
                longest = 1.0 / rate / rng.uniform(2.5, 6.0)
                steps = int(np.ceil(seconds / longest))
                between = times / (seconds / steps) % 1.0
            due = np.minimum(np.round(times / (seconds / steps)), steps)
            how, times = f"{how}\ntime_step = {longest!r}", due * (seconds / steps)
        text, start, speed = flying(rng, how)
        fall = np.outer(0.5 * times**2, (0.0, 0.0, FALL))
        judged = np.column_stack([times, start + np.outer(times, speed) - fall, np.tile(speed, (count + 1, 1))])
        judged[:, 6] -= FALL * times
        judged = np.vstack([judged, judged[-1]])
        # Frames that take long are saved, each of them; others only at the end.
        for each, ends in ((0.0, []), *((t, [int(rng.integers(1, 3)), count - 2]) for t in (0.0, 20.0))):
            with tempfile.TemporaryDirectory() as folder:
                path, out = written(folder, text), Path(folder) / "out"
                asked(ended_after, None, path, out, ends, each)
                rows = asked(rows_in, np.zeros((0, 7)), out)
            steps_of = "steps of one's own" if is_own else "the world's steps"
            again = ("gone on with, saved" if each else "gone on with") if ends else "at once"
            # What cannot be run or read is a frame that is missing.
            extend_evenly(answers, rows, judged, f"{steps_of}, {again}", is_relative=True)
    return answers.comparison()


def bits_in(out: Path) -> list[bytes]:
    """Return the bits of all that a run has kept: each frame, the last world, the scene file, the film."""
    kept = Trajectory.open(out / "trajectory")
    frames = [b"".join(np.asarray(each).tobytes() for each in frame[:-1]) for frame in kept]  # (all but its bodies)
    return [*frames, *((out / name).read_bytes() for name in ("world.npz", "scene.toml", "film.webp"))]


def filmed(path: Path, out: Path, rate: float, count: int, look: dict[str, Any]) -> bytes:
    """Return a film of so many frames, each the kept one that is nearest to its time, as a Recorder makes it."""
    kept, world, film = Trajectory.open(out / "trajectory"), from_file(path), path.with_name("again.webp")
    kept.put_into(world, 0)
    with Recorder(world, film, rate, **look) as shown:
        for j in range(count):
            kept.put_into(world, int(np.argmin(np.abs(kept.times - j / rate))))
            shown.frame()
    return film.read_bytes()


@check(
    section="beyond the paper",
    piece="softbody.cli.run_folder.run_scene",
    reference="the same run at once; a `Recorder` that is given the frames one by one, as many as whole numbers say",
    engines=("PIL",),
    kind="specification",
    because="the same bits",
    faults=(
        Fault(
            "a film without its last frame",
            _film,
            "c_ * film.frames_per_second + 1e-9 → c_ * film.frames_per_second - 1e-9",
        ),
        Fault("film of frames before", _film, "np.abs(x_).argmin() → max(0, np.abs(x_).argmin() - 1)"),
        Fault("a run that goes on with the world as it began", _world_of, "World.load(folder / WORLD) → scene.world"),
    ),
)
def what_was_ended_goes_on(run: Run) -> Comparison:
    """A run that was ended goes on to the same bits.

    It has been ended twice, and gone on with from where it was saved last. Every frame, the last world and the film
    have the bits of a run that nothing has ended. The film is the one that a `Recorder` makes of the frames nearest to
    its times, the one at the very end among them. It is of more or fewer frames a second than were kept.
    """
    rng, answers = run.fresh_rng(), Answers()
    shown = {"size": (32, 24), "colour": "speed", "colour_range": (0.0, 5.0)}
    # Of frames that are kept 16 times a second: none is half-way between two.
    for _, per_second in product(range(run.count(1, 3, 30)), (8, 12, 24)):
        count = int(rng.integers(5, 12))
        film = f"[film]\nsize = [32, 24]\nframes_per_second = {per_second}\ncolour = 'speed'\ncolour_range = [0, 5]"
        text, *_ = flying(rng, f"seconds = {count / 16}\nframes_per_second = 16", film)
        with tempfile.TemporaryDirectory() as name:
            path, at_once, in_parts = written(name, text), Path(name) / "whole", Path(name) / "parts"
            ends = [2, int(rng.integers(3, count))]
            asked(ended_after, None, path, at_once, [])
            begun = asked(ended_after, None, path, in_parts, ends, 20.0)
            whole, parts = asked(bits_in, [b"whole"], at_once), asked(bits_in, [b"parts"], in_parts)
            made = asked(filmed, b"", path, at_once, per_second, count * per_second // 16 + 1, shown)
        answers.add(whole == parts and len(whole) == count + 4, True, kind="bits")
        answers.add(begun == [0, *(end - 1 for end in ends)], True, kind="from where")
        answers.add(made == whole[-1], True, kind=f"a film of {per_second} a second")
    return answers.comparison()


def in_the_way(path: Path, run: Path) -> Iterator[tuple[str, Path, Path, bool, type[Exception], str]]:
    """Yield what cannot be run: in words, scene file, folder, whether it is gone on with, the error, what it names.

    `run` is a run that was ended after some frames; copies of it are damaged.
    """
    folder, content = path.parent, path.read_text()

    def again(name: str) -> Path:
        return Path(shutil.copytree(run, folder / name))

    other, endless = folder / "other.toml", folder / "endless.toml"
    other.write_text(content + "# mine\n")
    endless.write_text(content.partition("[run]")[0])
    (folder / "file").write_text("mine")
    (folder / "full").mkdir()
    (folder / "full" / "thesis.tex").write_text("mine")
    yield "a run that is there", path, again("there"), False, OutputError, "--resume"
    yield "a file", path, folder / "file", False, OutputError, "is no folder"
    yield "a folder of other things", path, folder / "full", False, OutputError, "other things"
    yield "a folder of other things, gone on with", path, folder / "full", True, OutputError, "other things"
    yield "another scene file", other, again("another's"), True, SceneError, "is not the one"
    yield "no end", endless, folder / "new", False, SceneError, "[run]"
    in_its_place = again("in its place")
    (in_its_place / "film.webp").mkdir()
    yield "a folder in the film's place", path, in_its_place, True, OutputError, "film.webp"
    cut_off = again("cut off")
    (cut_off / "world.npz").write_bytes((run / "world.npz").read_bytes()[:100])
    yield "a world that is cut off", path, cut_off, True, SnapshotError, "world.npz"
    of_others, world = again("of others"), World()
    world.add_box((1.0, 1.0, 1.0), 1.0)
    world.save(of_others / "world.npz")
    yield "a world of other bodies", path, of_others, True, SnapshotError, "other bodies"
    later, world = again("later"), World.load(run / "world.npz")
    world.time = 0.01
    world.save(later / "world.npz")
    yield "a world of another moment", path, later, True, TrajectoryError, "no frame at 0.01 s"


@check(
    section="beyond the paper",
    piece="softbody.cli.run_folder.run_scene",
    reference="the documentation: which error, and what it names; the frames in the folder, counted before and after",
    engines=("PIL",),
    kind="specification",
    faults=(
        Fault("films that nobody tries before", run_scene, "_recorder(w_, f_, v_).close() → "),
        Fault("runs that are overwritten", _prepared, "not resume → False"),
        Fault("any scene file", _prepared, "(folder / SCENE).read_bytes() != scene.content → False"),
        Fault("worlds of any moment", run_folder._check_has_frame, "time not in times → False"),
        Fault(
            "frames that are left out before the run is refused",
            _advance,
            "_check_has_frame(folder, world.time, is_new)"
            " → TrajectoryWriter(world, folder / TRAJECTORY, velocities=run.velocities, resume=True).close()\n"
            "_check_has_frame(folder, world.time, is_new)",
        ),
    ),
)
def what_is_in_the_way(run: Run) -> Comparison:
    """What hinders a run is named before any work.

    That is what is in its way, or is not of the run that is gone on with. The error is of its kind, its text names it,
    and no frame is made.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 2, 20)):
        text, *_ = flying(rng, "seconds = 0.5\nframes_per_second = 16", "[film]\nsize = [32, 24]")
        with tempfile.TemporaryDirectory() as name:
            path, out = written(name, text), Path(name) / "run"
            with suppress(_EndError):
                run_scene(path, out, False, _Told(end=int(rng.integers(2, 5))))
            for what, scene, folder, is_resumed, kind, named in in_the_way(path, out):
                before = frames_in(folder)
                try:
                    run_scene(scene, folder, is_resumed, _Told())
                    is_refused = False
                except Exception as error:
                    is_refused = type(error) is kind and named in str(error)
                answers.add(is_refused and frames_in(folder) == before, True, kind=what)
    return answers.comparison()


def frames_in(folder: Path) -> int:
    """Return how many frames a run has kept in a folder, 0 if there is none."""
    return len(asked(Trajectory.open, [], folder / "trajectory"))


def saved_at(path: Path, each: float, cost: float) -> list[int]:
    """Return after which frames, of `each` [s], a scene file's world is saved, where that costs so much [s]."""
    told, saved, save = _Told(each), list[int](), World.save

    def slowly(world: World, path: Path) -> None:
        save(world, path)
        saved.append(told.frames)
        told.now += cost

    with mock.patch.object(run_folder, "monotonic", told.clock), mock.patch.object(World, "save", slowly):
        run_scene(path, path.with_name("out"), False, told)
    return saved


@check(
    section="beyond the paper",
    piece="softbody.cli.run_folder.run_scene",
    reference="that rule, over the same frames; a clock that is set, to which frames and saving add",
    kind="specification",
    unit="frames",
    tolerance=0.0,
    because="whole numbers",
    faults=(
        Fault("saving as often, however long it takes", _advance, "max(PAUSE, x_) → PAUSE"),
        Fault("a pause from when saving was begun", _advance, "monotonic() + max(PAUSE, x_) → begun + max(PAUSE, x_)"),
        Fault("no saving on the way", _advance, "monotonic() >= due → False"),
    ),
)
def how_often_worlds_are_saved(run: Run) -> Comparison:
    """A run saves its world every 10 s, if that is quick.

    While a scene file is run, its world is saved whenever 10 s have gone by since it last was. If ten times as long as
    that took is more, it is saved after that. Besides, it is saved at the beginning and at the end.
    """
    rng, answers, count = run.fresh_rng(), Answers(), 40
    for trial in range(run.count(6, 10, 100)):
        slow = trial % 2 == 1
        each, cost = rng.uniform(1.0, 4.0), rng.uniform(1.1, 3.0) if slow else rng.uniform(0.0, 0.9)
        text, *_ = flying(rng, f"seconds = {count / 64}\nframes_per_second = 64\ntime_step = {1 / 64}")
        with tempfile.TemporaryDirectory() as folder:
            saved = asked(saved_at, [], written(folder, text), each, cost)
        due, now, judged = 10.0, 0.0, [0]
        for k in range(1, count + 1):
            now += each
            if now >= due:
                judged.append(k)
                now += cost
                due = now + (10.0 * cost if cost > 1.0 else 10.0)
        judged.append(count)
        ours, theirs = ([len(ks), *(ks + [-1] * (count + 2))[: count + 2]] for ks in (saved, judged))
        answers.add(ours, theirs, kind="saving is slow" if slow else "saving is quick")
    return answers.comparison()
