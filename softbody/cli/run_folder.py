"""Runs a scene file into a folder, from which the run can be resumed, whatever ends it.

The folder has the scene file, the trajectory, the world as it was at one of its frames, and perhaps a film. The
trajectory is never behind the world: so what is gone on with has the bits of a run that nothing has ended.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from softbody.errors import OutputError, SceneError, SnapshotError, TrajectoryError
from softbody.scenes.scene_file import Film, Run, SceneFile, read_scene
from softbody.stepping.time_steps import whole_steps
from softbody.storage.atomic_file import path_of, whole_file
from softbody.trajectory import Trajectory, TrajectoryWriter
from softbody.trajectory.manifest import NAME, read_manifest
from softbody.world import World

if TYPE_CHECKING:
    from softbody.render import Recorder

SCENE, WORLD, TRAJECTORY = "scene.toml", "world.npz", "trajectory"
PAUSE = 10.0  # [s] of the clock, at least, between two times that the world is saved: what a kill may cost
PART = 0.1  # of the time, at most, goes into that

Reporter = Callable[[int, int], AbstractContextManager[Callable[[int], None]]]


class _Schedule(NamedTuple):
    """How a run goes from frame to frame: the same way, wherever it begins."""

    run: Run

    @property
    def frames(self) -> int:
        """Frames after the first."""
        return whole_steps(self.run.seconds, 1.0 / self.run.frames_per_second)[0]

    def advance(self, world: World, k: int) -> None:
        """Go on from frame k − 1 to frame k."""
        seconds, frame, last = self.run.seconds, 1.0 / self.run.frames_per_second, self.frames
        if self.run.time_step is None:
            even = whole_steps(seconds, frame)[1] == frame
            world.step_frame(frame if even or k < last else seconds - (last - 1) * frame)
            return
        steps, h = whole_steps(seconds, self.run.time_step)
        due = steps if k == last else min(steps, round(k * frame / h))
        world.step(h, due - world.steps)


def run_scene(path: str | os.PathLike[str], out: str | os.PathLike[str], resume: bool, reporter: Reporter) -> str:
    """Run a scene file into the folder `out`, and return what is there then, in words.

    With `resume`, go on with the run that is there. Raises SceneError, OutputError, MissingPackageError before any
    work; TrajectoryError and SnapshotError for a run that is damaged.
    """
    scene, folder = read_scene(path), path_of(out)
    if scene.run is None:
        raise SceneError(f"{os.fspath(path)}: there is no [run] with seconds = …, to say how long; add it")
    try:
        is_begun = _prepared(folder, scene, resume)
        if scene.film is not None:
            _recorder(scene.world, folder, scene.film).close()  # whatever is in its way is said now
        world = _world_of(folder, scene) if is_begun else scene.world
        if not is_begun:
            with whole_file(folder / SCENE) as file:
                file.write(scene.content)
        _advance(world, folder, scene.run, reporter)
        made = [f"{TRAJECTORY}/", WORLD, SCENE]
        if scene.film is not None:
            made.append(scene.film.file)
            if not (folder / scene.film.file).exists():
                _film(world, folder, scene.film)
    except OSError as error:
        if isinstance(error, OutputError):
            raise
        raise OutputError(f"{folder} cannot be written: {error.strerror or error}; --resume goes on") from error
    kept = Trajectory.open(folder / TRAJECTORY)
    return f"{folder}: {len(kept)} frames until {kept.times[-1]:.6g} s in {', '.join(made)}"


def _prepared(folder: Path, scene: SceneFile, resume: bool) -> bool:
    """Make the folder; tell whether there is a run to go on with, and raise an error for what is in the way."""
    if os.path.lexists(folder) and not folder.is_dir():
        raise OutputError(f"{folder} is no folder; give the name of a new one")
    folder.mkdir(parents=True, exist_ok=True)
    there = [name for name in os.listdir(folder) if not name.startswith(".")]
    if not there:
        return False
    if not (folder / SCENE).is_file():
        raise OutputError(f"{folder} holds other things than a run; give the name of a new folder")
    if not resume:
        raise OutputError(f"{folder} holds a run; --resume goes on with it, or give the name of a new folder")
    if (folder / SCENE).read_bytes() != scene.content:
        raise SceneError(
            f"the scene file is not the one that {folder} was begun with, {folder / SCENE}: resume with that, or run "
            "this one into a new folder"
        )
    return True


def _world_of(folder: Path, scene: SceneFile) -> World:
    """Return the world as it was saved last; as it began, if it was not."""
    if not (folder / WORLD).exists():
        return scene.world
    world = World.load(folder / WORLD)
    if (world.model.soft_count, world.model.box_count) != (scene.world.model.soft_count, scene.world.model.box_count):
        raise SnapshotError(f"{folder / WORLD} has other bodies than {SCENE}; run it into a new folder")
    world.threads = scene.world.threads
    return world


def _advance(world: World, folder: Path, run: Run, reporter: Reporter) -> None:
    """Go on to the last frame, and save the world then, and now and then before."""
    schedule, is_new = _Schedule(run), not (folder / WORLD).exists()
    _check_has_frame(folder, world.time, is_new)
    with TrajectoryWriter(world, folder / TRAJECTORY, velocities=run.velocities, resume=True) as kept:
        if not kept.frames:
            kept.frame()
        if is_new:
            _save(world, folder, kept)
        done = kept.frames - 1
        with reporter(schedule.frames, done) as tell:
            due = monotonic() + PAUSE
            for k in range(done + 1, schedule.frames + 1):
                schedule.advance(world, k)
                kept.frame()
                tell(k)
                if monotonic() >= due:
                    begun = monotonic()
                    _save(world, folder, kept)
                    due = monotonic() + max(PAUSE, (monotonic() - begun) / PART)
        if done < schedule.frames:
            _save(world, folder, kept)


def _check_has_frame(folder: Path, time: float, is_new: bool) -> None:
    """See that the trajectory, if it is begun, has a frame at `time` [s]: before a writer leaves out what is later."""
    path = folder / TRAJECTORY
    times = [each for each in read_manifest(path).times if each <= time] if os.path.lexists(path / NAME) else []
    if time not in times and (times or not is_new):
        raise TrajectoryError(
            f"{path} has no frame at {time:.6g} s, where {WORLD} is: they are not of one run; run the scene into a new "
            "folder"
        )


def _save(world: World, folder: Path, kept: TrajectoryWriter) -> None:
    """Keep the world where its last frame is: frames first, so that they are never behind."""
    kept.flush()
    world.save(folder / WORLD)


def _recorder(world: World, folder: Path, film: Film) -> Recorder:
    from softbody.render import Recorder

    return Recorder(
        world,
        folder / film.file,
        film.frames_per_second,
        size=film.size,
        colour=film.colour,
        colour_range=film.colour_range,
        show_joints=film.show_joints,
    )


def _film(world: World, folder: Path, film: Film) -> None:
    """Make a film of the whole trajectory: each of its frames is the one that was kept nearest to its time."""
    kept = Trajectory.open(folder / TRAJECTORY)
    count = int((kept.times[-1] - kept.times[0]) * film.frames_per_second + 1e-9) + 1
    kept.put_into(world, 0)
    with _recorder(world, folder, film) as shown:
        for j in range(count):
            kept.put_into(world, int(np.abs(kept.times - j / film.frames_per_second).argmin()))
            shown.frame()
