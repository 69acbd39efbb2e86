"""Claims that what is kept of a world, frame by frame, is what the world did."""

from __future__ import annotations

import json
import os
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np

import softbody
from softbody import Bodies, ParameterError, Trajectory, TrajectoryError, TrajectoryWriter, World
from softbody.model.shapes import Cast
from softbody.scenes import tray
from softbody.storage import atomic_file
from softbody.trajectory import held, manifest
from validation.answers import Answers
from validation.cases import random_mesh, random_orientations
from validation.check import Comparison, Run, check
from validation.checks.contract.cases import error_of
from validation.checks.contract.crowds import Crowd, bits_of, what_in, where_in
from validation.checks.contract.exports import asked
from validation.checks.contract.kept_files import extend_evenly, row_of
from validation.checks.contract.pictures import LATE
from validation.fault import Fault

FAMILY = "what is kept and exported"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

FALL = 9.81  # [m/s²]

# What is kept: names in State and the files, and in a Frame.
NAMES = {
    "particle_position": "positions",
    "particle_velocity": "velocities",
    "box_position": "box_positions",
    "box_orientation": "box_orientations",
    "box_velocity": "box_velocities",
    "box_angular_velocity": "box_angular_velocities",
}


class Flight:
    """Bodies that fly without touching anything, and where they are after any steps, by formulas."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.world = World(integrator="rk4")
        self.meshes = [random_mesh(kind, rng) for kind in ("torus", "sphere")]
        self.starts, self.speeds = 30.0 * rng.normal(size=(4, 3)), rng.normal(size=(4, 3))
        for k, mesh in enumerate(self.meshes):
            self.meshes[k] = mesh = mesh.moved(-mesh.vertices.mean(axis=0))
            self.world.add_soft_body(mesh, 1.0, 1.0, 0.0, self.starts[k], self.speeds[k])
        for k, turn in enumerate(random_orientations(rng, 2), 2):
            self.world.add_box(rng.uniform(0.2, 1.0, 3), 1.0, self.starts[k], turn, self.speeds[k])

    def at(self, step: float, steps: int) -> np.ndarray:
        """Return time, place and velocity (4, 7) after so many steps: Runge and Kutta's are exact, boxes' are Euler's.

        Those add to the velocity first, v = −g n h, and z = −g h² n (n + 1)/2.
        """
        t = step * steps
        fallen = 0.5 * FALL * t * np.array([t, t, t + step, t + step])
        rows = np.hstack([np.full((4, 1), t), self.starts + self.speeds * t, self.speeds])
        rows[:, 3] -= fallen
        rows[:, 6] -= FALL * t
        return rows


def rows_of(frame: softbody.Frame, kept: Trajectory) -> np.ndarray:
    """Return the `row_of` each body (4, 7) in a frame."""
    assert frame.velocities is not None
    assert frame.box_velocities is not None
    soft = [(frame.positions[rows], frame.velocities[rows]) for rows in map(kept.particles, range(kept.soft_count))]
    boxes = zip(frame.box_positions[:, None], frame.box_velocities[:, None])
    return np.array([row_of(frame.time, *body) for body in (*soft, *boxes)])


def rows_now(world: World) -> np.ndarray:
    """Return the same of a world as it is."""
    soft = [(body.positions, body.velocities) for body in world.soft_bodies]
    boxes = [(box.position[None], box.velocity[None]) for box in world.boxes]
    return np.array([row_of(world.time, *body) for body in (*soft, *boxes)])


@check(
    section="beyond the paper",
    piece="softbody.TrajectoryWriter.run, softbody.TrajectoryWriter.frame, softbody.TrajectoryWriter.flush,"
    " softbody.TrajectoryWriter.close, softbody.Trajectory.open, softbody.Trajectory.put_into",
    reference="closed form: the parabola, and its sum over semi-implicit steps for boxes",
    kind="closed form",
    unit="of the way and the speed, each at least 1",
    tolerance=1e-13,
    because="rounding over some hundred steps: 1.1e-14 at worst of ten seeds",
    faults=(
        LATE,
        Fault(
            "the frame before",
            Trajectory.__getitem__,
            "array[k - self._ends[at]] → array[max(0, k - self._ends[at] - 1)]",
        ),
        Fault(
            "a world that is put there at its own time",
            Trajectory.put_into,
            "(store.clock.time, frame.time) → (store.clock.time, store.time)",
        ),
        Fault(
            "a world that is put there with its own speed",
            Trajectory.put_into,
            "0.0 if frame.velocities is None else frame.velocities → state.particle_velocity.copy()",
        ),
        Fault("a flush that waits", TrajectoryWriter.flush, "self._flush() → None"),
        Fault("a close that drops what was not written", TrajectoryWriter.close, "self.flush() → None"),
        Fault(
            "a frame at once wherever two runs meet",
            TrajectoryWriter.run,
            "is_first or (time_step is None and self._runner.store.time > self.last_time)"
            " → self._runner.store.time > self.last_time",
        ),
        Fault(
            "no first frame where the world chooses its steps",
            TrajectoryWriter.run,
            "is_first or (time_step is None and self._runner.store.time > self.last_time) → False",
        ),
    ),
)
def flights_are_kept(run: Run) -> Comparison:
    """Bodies that fly are kept where their parabola has them.

    They are kept when they were to be, at the steps nearest to multiples of the frame. One `run` keeps them, or two
    that meet between frames, or frame by frame, or a writer that goes on with what another one left. They are read
    while it is being written, after a `flush`, or closed. A world that is put into a frame is there, at that time.
    """
    rng, answers = run.fresh_rng(), Answers()
    ways = ("run", "frame by frame", "gone on with", "the world's steps")
    for _, way in product(range(run.count(3, 10, 100)), ways):
        flight = Flight(rng)
        world, rate, count = flight.world, rng.uniform(20.0, 100.0), int(rng.integers(6, 20))
        step = 1.0 / rate / rng.uniform(3.0, 9.0)
        due = [round(k / rate / step) for k in range(count + 1)]
        frames, put = list[np.ndarray](), dict[int, np.ndarray]()
        # What cannot be kept or read is a frame that is missing.
        with tempfile.TemporaryDirectory() as folder, suppress(softbody.SoftbodyError, LookupError):
            path = Path(folder) / "kept"
            kept = TrajectoryWriter(world, path, rate)
            if way == "frame by frame":
                for now in due:
                    world.step(step, now - world.steps)
                    kept.frame()
                kept.flush()  # read while it is open
            elif way == "the world's steps":
                kept.run(count / rate)
                kept.close()
                each = world.steps // count
                step, due = 1.0 / rate / each, [each * k for k in range(count + 1)]
            else:
                kept.run(0.5 * due[-1] * step, step)  # to between two frames
                if way == "gone on with":
                    kept.close()
                    kept = TrajectoryWriter(world, path, rate, resume=True)
                kept.run((due[-1] + 0.4 - world.steps) * step, step)
                kept.close()
            found = Trajectory.open(path)
            frames = [rows_of(frame, found) for frame in found]
            for k in rng.permutation(len(found))[:3]:
                found.put_into(world, int(k))
                put[int(k)] = rows_now(world)
            kept.close()
        judged = [flight.at(step, now) for now in due]
        judged += [np.zeros((4, 7))] * (len(frames) - len(judged))
        back = list(put.values()), [judged[k] for k in put]
        for kind, ours, theirs in ((way, frames, judged), (f"{way}: put back", *back)):
            extend_evenly(answers, np.reshape(ours, (-1, 7)), np.reshape(theirs, (-1, 7)), kind, is_relative=True)
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.Trajectory.particles, softbody.Trajectory.triangles",
    reference="the meshes, counted by NumPy",
    kind="closed form",
    because="whole numbers",
    faults=(
        Fault("the first body's particles", Bodies.particles, 'check_whole(body, "body", 0, self.soft_count - 1) → 0'),
        Fault(
            "triangles by numbers of all particles",
            Bodies.triangles,
            "self._shapes.triangles(b_) → self._shapes.triangles(b_) + self._shapes.particles(body).start",
        ),
        Fault(
            "rows up to the last particle but one",
            Bodies.particles,
            "self._shapes.particles(b_) → slice(self._shapes.particles(b_).start, self._shapes.particles(b_).stop - 1)",
        ),
    ),
)
def rows_of_bodies(run: Run) -> Comparison:
    """A trajectory's `particles` and `triangles` are its meshes' own.

    That holds of worlds of several bodies, all unlike.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(3, 10, 100)):
        world, first = World(), 0
        meshes = [random_mesh(kind, rng) for kind in rng.permutation(["torus", "sphere", "box"])]
        for mesh in meshes:
            world.add_soft_body(mesh, 1.0, 100.0, 10.0, 30.0 * rng.normal(size=3))
        with tempfile.TemporaryDirectory() as folder:
            with TrajectoryWriter(world, Path(folder) / "kept") as kept:
                kept.frame()
            found = Trajectory.open(Path(folder) / "kept")
            for k, mesh in enumerate(meshes):
                rows = found.particles(k)
                answers.add([rows.start, rows.stop, 0], [first, first + len(mesh.vertices), 0])
                answers.extend(found.triangles(k), mesh.triangles)
                first += len(mesh.vertices)
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.TrajectoryWriter, softbody.Trajectory, softbody.Bodies",
    reference="copies of the world's arrays, and lists of its bodies, taken beside",
    kind="specification",
    because="the same bits; yes or no",
    faults=(
        Fault("bodies that are as many are the same", TrajectoryWriter.frame, "cast.is_same(c_) → True"),
        Fault("names that stay those of who went", Cast.is_same, "self.labels == other.labels and a_ → a_"),
        Fault("sizes that stay those of who went", Cast.is_same, "np.array_equal(a, b) → a.shape == b.shape"),
        Fault("bodies that are the first ones for ever", Trajectory._cast_of, "self._cast[0] != number → False"),
        Fault("bodies of the segment before", Trajectory._segment_of, "'right' → 'left'"),
        Fault("files of bodies that are written over", manifest.Manifest.next_bodies, "m_ + 1 → m_"),
        Fault("a manifest of the last segment", manifest.Manifest.and_segment, "(*before_, segment) → (segment,)"),
        Fault("a change that nobody is told of", Trajectory._all, "len(self._stops) > 1 → False"),
        Fault("worlds of other bodies that are put there", Trajectory.put_into, "digest_of(s_) != sha256 → False"),
        Fault("frames that are later and stay", held.found, "_staying(f_, disk, s_, now) → len(disk.times)"),
        Fault("a resumed trajectory of its first segment", held._until, "cut or (segments and not count) → segments"),
        Fault("other bodies of then are taken", held._staying, "segment.sha256 == bodies → True"),
    ),
)
def bodies_come_and_go(run: Run) -> Comparison:
    """Frames are kept with their own bodies while bodies come and go.

    Between frames, soft bodies and boxes are added, removed, or replaced, by another one of the same name, too. One
    writer keeps them; or one that goes on with what another left, at the end or before it; or the first is killed, and
    leaves files half-written. Frames, names, meshes and sizes are compared bit by bit. A world is put into the frames
    of its bodies, and refused by others. What is asked of all frames is refused, and so is a world of other bodies.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _, way in product(range(run.count(3, 10, 100)), ("one writer", "gone on with", "from before", "killed")):
        with tempfile.TemporaryDirectory() as folder:
            path, crowd, beside = Path(folder) / "kept", Crowd(rng), list[list[bytes]]()
            # What cannot be kept is a frame that is missing.
            kept = TrajectoryWriter(crowd.world, path)
            keep_crowd(kept, crowd, rng, beside)
            asked(kept.flush, None)
            if way in ("from before", "killed"):
                early, count = crowd.saved(Path(folder) / "world.npz"), len(beside)
                crowd.advance()
                keep_crowd(kept, crowd, rng, beside)
                crowd = early
                if way == "killed":
                    half_written(path)
                    there = len(asked(Trajectory.open, [], path))
                    answers.add(there >= count, True, kind="what a kill leaves")
                del beside[count:]
            if way != "killed":
                asked(kept.close, None)
            stranger = Crowd(rng)
            stranger.add_box()
            stranger.world.time = crowd.world.time
            told = error_of(Exception, partial(TrajectoryWriter, stranger.world, path, resume=True))
            answers.add(isinstance(told, TrajectoryError), True, kind="a world of other bodies")
            if way != "one writer":
                with suppress(softbody.SoftbodyError):
                    kept = TrajectoryWriter(crowd.world, path, resume=True)
                    keep_crowd(kept, crowd, rng, beside)
                    asked(kept.close, None)
            add_frames(answers, path, crowd, beside, way)
    return answers.comparison()


def keep_crowd(kept: TrajectoryWriter, crowd: Crowd, rng: np.random.Generator, beside: list[list[bytes]]) -> None:
    """Keep some frames while bodies come and go, with two changes at least; tell beside what each must have."""
    changing = {*rng.choice(np.arange(1, 9), 3, replace=False).tolist()}
    for k in range(9):
        if k in changing:
            (crowd.swap if k == max(changing) else crowd.change)()
        if k not in changing or rng.random() < 0.5:  # else there are two frames at the same time
            crowd.advance()
        asked(kept.frame, None)  # what cannot be kept is a frame that is missing
        beside.append(bits_of([*crowd.where(), *crowd.what()]))


def half_written(path: Path) -> None:
    """Leave files there of which the manifest does not know yet, as who is killed does."""
    for name in (".0123456789abcdef.part", "000099.npz", "bodies-000099.npz"):
        (path / name).write_bytes(b"half")


def add_frames(answers: Answers, path: Path, crowd: Crowd, beside: list[list[bytes]], kind: str) -> None:
    """Add whether each frame is what was told beside, and whether the world at the end is put where it may be."""
    found = asked(Trajectory.open, [], path)
    answers.add(len(found), len(beside), kind=f"{kind}: frames")
    now = bits_of(crowd.what())
    for k, told in enumerate(beside[: len(found)]):
        frame = asked(found.__getitem__, None, k)
        is_same = frame is not None and bits_of([*where_in(frame), *what_in(frame.bodies)]) == told
        answers.add(is_same, True, kind=kind)
        is_refused = isinstance(error_of(Exception, partial(found.put_into, crowd.world, k)), ParameterError)
        has_same_bodies = told[8:] == now[1:]  # whatever they are called
        is_there = bits_of(crowd.where()) == told[:7]
        answers.add(is_refused, not has_same_bodies, kind=f"{kind}: put back")
        answers.add(is_there or is_refused, True, kind=f"{kind}: put back")
    is_refused = error_of(ParameterError, lambda: found.box_count) is not None if found else False
    answers.add(is_refused, any(told[7:] != beside[0][7:] for told in beside), kind=f"{kind}: of all frames")


@check(
    section="beyond the paper",
    piece="softbody.TrajectoryWriter.frame, softbody.Trajectory.open",
    reference="copies of the world's arrays, taken beside; NumPy and JSON read the files",
    kind="specification",
    because="the same bits",
    faults=(
        Fault(
            "frames that follow the world until they are written",
            TrajectoryWriter._checked,
            "{name: array[0] for name, array in frame.items()}"
            " → {name: getattr(self._runner.store.state, name) for name in frame}",
        ),
        Fault(
            "frames in single precision",
            TrajectoryWriter._flush,
            "np.stack([frame[name] for _, frame in held.pending])"
            " → np.stack([frame[name] for _, frame in held.pending]).astype(np.float32).astype(float)",
        ),
        Fault(
            "frames that share memory with their chunk",
            Trajectory.__getitem__,
            "array[k - self._ends[at]].copy() → array[k - self._ends[at]]",
        ),
        Fault(
            "the first chunk again",
            Trajectory.__getitem__,
            "self._manifest.chunks[at] → (self._manifest.chunks[0].file, self._manifest.chunks[0].times)",
        ),
    ),
)
def frames_have_every_bit(run: Run) -> Comparison:
    """Every bit of every frame is kept.

    Balls fall into a tray, over several chunks. The bits are in what `Trajectory` returns, and in the files that NumPy
    reads itself, in the order and with the times of the manifest.
    """
    answers = Answers()
    for chunk in (128, 5):
        world = tray.build(2)
        step, beside = 0.9 * world.stable_time_step(), []
        with tempfile.TemporaryDirectory() as folder:
            with TrajectoryWriter(world, folder) as kept:
                for _ in range(run.count(140, 300, 600)):
                    world.step(step)
                    beside.append((world.time, {name: getattr(world.state, name).copy() for name in NAMES}))
                    kept.frame()
                    if kept.frames % chunk == 0:
                        kept.flush()
            read, frames = Trajectory.open(folder), []
            for k in range(len(read)):
                read[k].positions[:] = np.nan  # what is written into a frame that was read is in no other
                frames.append(read[k])
            manifest = json.loads((Path(folder) / "trajectory.json").read_text())
            files = [dict(np.load(Path(folder) / each["file"])) for each in manifest["chunks"]]
        rows = {name: np.concatenate([file[name] for file in files]) for name in files[0]}
        for k, (time, arrays) in enumerate(beside):
            told = {name: getattr(frames[k], field) for name, field in NAMES.items()}
            is_same = frames[k].time == time and _same_bits(told, arrays)
            answers.add(is_same, True, kind=f"a Trajectory, {chunk} a chunk")
            is_same = rows["time"][k] == time and _same_bits({name: rows[name][k] for name in NAMES}, arrays)
            answers.add(is_same, True, kind=f"NumPy, {chunk} a chunk")
    return answers.comparison()


def _same_bits(some: dict[str, np.ndarray | None], others: dict[str, np.ndarray]) -> bool:
    """Tell whether all arrays are there, and have the bits of the others of their names."""
    return all(array is not None and array.tobytes() == others[name].tobytes() for name, array in some.items())


@check(
    section="beyond the paper",
    piece="softbody.TrajectoryWriter",
    reference="a lock of the system's (flock) on the folder, that is given back after a while",
    kind="specification",
    least=3,
    because="yes or no: was the lock given back before the writer was done?",
    faults=(
        Fault("locks that are none", atomic_file._locked, "fcntl.LOCK_EX | fcntl.LOCK_NB → fcntl.LOCK_UN"),
        Fault("a flush that does not ask", TrajectoryWriter.flush, "alone_in(f_) → alone_in(self._folder / 'nowhere')"),
    ),
)
def folders_are_locked(run: Run) -> Comparison:
    """Writers of a trajectory wait while its folder is locked.

    Somebody else has it locked while a trajectory is begun, written to, or ended.
    """
    world, answers = Flight(run.fresh_rng()).world, Answers()
    for _ in range(run.count(1, 2, 10)):
        with tempfile.TemporaryDirectory() as folder:
            with locked_for_a_while(folder) as given_back:
                kept = TrajectoryWriter(world, folder)
                answers.add(bool(given_back), True)
            for go_on in (kept.flush, kept.close):
                kept.frame()
                with locked_for_a_while(folder) as given_back:
                    go_on()
                    answers.add(bool(given_back), True)
    return answers.comparison()


@contextmanager
def locked_for_a_while(folder: str) -> Iterator[list[bool]]:
    """Lock a folder for a tenth of a second; yield what is no longer empty when the lock is given back."""
    import fcntl

    file, given_back = os.open(folder, os.O_RDONLY), list[bool]()
    fcntl.flock(file, fcntl.LOCK_EX)

    def give_back() -> None:
        given_back.append(True)
        fcntl.flock(file, fcntl.LOCK_UN)

    somebody = threading.Timer(0.1, give_back)
    somebody.start()
    try:
        yield given_back
    finally:
        somebody.join()
        os.close(file)
