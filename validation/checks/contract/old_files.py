"""Claims that files of past versions still say what the softbody of then said of them."""

from __future__ import annotations

import io
import json
import pickle
import shutil
import tempfile
from collections.abc import Callable
from contextlib import redirect_stdout
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from softbody import Trajectory, World, scenes
from softbody.__main__ import main as softbody_command
from softbody.scenes import scene_file
from softbody.storage import snapshot
from softbody.trajectory import bodies, manifest
from validation.answers import Answers
from validation.check import Comparison, Run, check
from validation.fault import Fault
from validation.golden.make import EXPECTED, FILES, told_of_trajectory, told_of_world

FAMILY = "what is kept and exported"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

# What a world is told to have that was saved before there was such a thing: entries, by the beginning of their names.
NONE_THEN: dict[str, Any] = {
    "names.": "",
    "rest.": 0,
    "settings.sleep_speed": 0.0,
    "settings.sleep_after": 0.5,
    "settings.self_contact": False,
    "cache.soft": 0,
    "model.soft_self_contact": 0.0,
    "model.liquid_": 0.0,
    "model.soft_liquid_density": 0.0,
    "model.soft_sound_speed": 0.0,
    "model.soft_liquid_drag": 0.0,
    "model.soft_leak": 200.0,
    "model.edge_tear_at": 0.0,
    "model.soft_boxes_volume": 0.0,
    "model.box_host": -1,
    "joints.joint_inside": -1,
    "joints.suspension_start": 0,
}

READERS: dict[str, Callable[[Path], World]] = {
    "world.npz": World.load,
    "paper.pickle": lambda path: pickle.loads(path.read_bytes()),
    "scene.toml": scenes.from_file,
}


def expected_of(ending: str) -> dict[str, dict[str, Any]]:
    """Return what was said of the golden files whose names have an ending, by name."""
    told: dict[str, dict[str, Any]] = json.loads(EXPECTED.read_text(encoding="utf-8"))
    return {name: said for name, said in told.items() if name.endswith(ending)}


def asked(question: Callable[..., dict[str, Any]], *about: Any) -> dict[str, Any]:
    """Return an answer as JSON has it; none where whatever is wrong with a file stops it."""
    try:
        answer: dict[str, Any] = json.loads(json.dumps(question(*about)))
        return answer
    except Exception:
        return {}


def comparison(right: dict[str, dict[str, bool]]) -> Comparison:
    """Return what was right of each file, and a note of what was not."""
    answers = Answers()
    for name, each in right.items():
        answers.extend(list(each.values()), [True] * len(each), kind=name)
    wrong = [f"{name}: {what}" for name, each in right.items() for what, good in each.items() if not good]
    return answers.comparison(notes=wrong[:10])


def equal_masses(world: World) -> np.ndarray:
    """Return the inverse mass (n,) [1/kg] of each particle, of bodies whose particles all have that of a free one."""
    inverse, starts = world.model.particle_inverse_mass, world.model.soft_particle_start
    parts = [inverse[first:end] for first, end in pairwise(starts)]
    return np.concatenate([np.full(len(part), part.max()) for part in parts] or [np.zeros(0)])


def told_by(read: Callable[[Path], World], path: Path) -> dict[str, Any]:
    """Return what is told of the world of a file."""
    return told_of_world(read(path))


def compared(told: dict[str, Any], said: dict[str, Any]) -> dict[str, bool]:
    """Tell of each thing that was said whether it is told today, of entries one by one."""
    entries = told.get("entries", {})
    same = {name: entries.get(name) == value for name, value in said.get("entries", {}).items()}
    rest = [name for name in said if name not in ("entries", "revision")]
    return same | {name: name in told and told[name] == said[name] for name in rest}


def said_since(read: Callable[[Path], World], path: Path, said: dict[str, Any]) -> dict[str, bool]:
    """Tell whether the world of a file has nothing of what the softbody of then did not know."""
    world = read(path)
    told = told_of_world(world) | {"joints": world.joints}
    right = {name: name in said or not any(told[name]) for name in ("joints", "time_left", "names", "asleep")}
    for name, array in world.snapshot().items():
        if name not in said["entries"] and not name.startswith(("format", "state.")):
            none = next((value for start, value in NONE_THEN.items() if name.startswith(start)), None)
            none = equal_masses(world) if name == "model.particle_free_inverse_mass" else none
            right[name] = bool((array == none).all()) if none is not None else not array.size
    return right


@check(
    section="9",
    piece="softbody.World.load, softbody.World.restore, softbody.scenes.from_file",
    reference="what the revisions of then wrote down of the same worlds, before they ended",
    kind="specification",
    because="the same bits",
    faults=(
        Fault("format 1 is no format", snapshot._format, "entries.leave_out('rings.') → "),
        Fault("format 1 needs a number", snapshot._format, "'format' not in entries.names() → False"),
        Fault("joints that formats 1 and 2 must have", snapshot._joints, "not count and not any(a_) → False"),
        Fault("times left that format 3 must have", snapshot._checked, "number < 4 → number < 3"),
        Fault("times left that there never were", snapshot._checked, "np.zeros(c_) → np.ones(c_)"),
        Fault("names that format 4 must have", snapshot._names, "number < 5 → number < 4"),
        Fault("rests that format 5 must have", snapshot._rested, "number < 6 → number < 5"),
        Fault("a property that format 7 must have", snapshot._model, "number < note.since → False"),
        Fault("soft contacts that format 6 must remember", snapshot._impulses, "number_ < 7 → number_ < 6"),
        Fault(
            "settings without a value for old files",
            snapshot._settings,
            "number < SETTINGS_SINCE.get(field, 0) → False",
        ),
        Fault("sleep in worlds that knew none", snapshot._settings, "np.array(default) → np.array(0.03)"),
        Fault("a setting of another name", snapshot._settings, "take[t_](f_) → take[t_](f_.replace('axes', 'tests'))"),
        Fault("a part of another name", snapshot._part, "f'{name}.{field}' → f'{kind.__name__}.{field}'"),
        Fault("pickles that forget", World.__setstate__, "self.restore(snapshot) → "),
        Fault("scenes by the defaults of today", scene_file._Reading._world, "{**t_, **choices} → dict(choices)"),
    ),
)
def worlds(run: Run) -> Comparison:
    """Old files of worlds are read as their own softbody had them.

    Softbody saved them in each of its formats, 1 to 8, or pickled them. They are as the revision that wrote them had
    them, to the bit: every entry, and what handles say. They have nothing that there was not yet. The same holds of a
    world that is built from a scene file of then.
    """
    right = dict[str, dict[str, bool]]()
    for ending, read in READERS.items():
        for name, said in expected_of(ending).items():
            right[name] = compared(asked(told_by, read, FILES / name), said)
            right[f"{name}, since then"] = asked(said_since, read, FILES / name, said) or {"readable": False}
    return comparison(right)


def gone_on_with(folder: Path) -> dict[str, Any]:
    """Return what is told of the trajectory of a run that has ended, after it was gone on with in a copy."""
    with tempfile.TemporaryDirectory() as elsewhere:
        copy = Path(elsewhere) / "run"
        shutil.copytree(folder, copy)
        with redirect_stdout(io.StringIO()):
            code = softbody_command(["run", str(copy / "scene.toml"), "--out", str(copy), "--resume"])
        return told_of_trajectory(copy / "trajectory") if code == 0 else {}


def last_frame_in_world(folder: Path) -> dict[str, Any]:
    """Return what the world of a run tells, moved away and put into the last frame of the run's trajectory."""
    world = World.load(folder / "world.npz")
    world.state.particle_position[:] += 1.0
    world.state.box_velocity[:] += 1.0
    Trajectory.open(folder / "trajectory").put_into(world, -1)
    return {"motion": told_of_world(world)["motion"]}


@check(
    section="beyond the paper",
    piece="softbody.Trajectory.open, softbody.Trajectory.put_into, softbody.TrajectoryWriter",
    reference="what the revisions of then wrote down of the same trajectories, before they ended",
    kind="specification",
    because="the same bits",
    faults=(
        Fault("labels that all must have", manifest._labels, "found is None → False"),
        Fault("the format of today only", manifest._manifest, "number >= 1 → number == FORMAT"),
        Fault("bodies that are hashed under another name", bodies.digest_of, "'bodies' → 'shapes'"),
        Fault("no names for those who have none", bodies.read_cast, "x_ or unlabelled(s_) → x_"),
        Fault("velocities that are not read", Trajectory.__getitem__, "rows.get('box_velocity') → None"),
        Fault("a run that never was", "softbody.cli.run_folder.WORLD", "'world.npz' → 'state.npz'"),
    ),
)
def trajectories_and_runs(run: Run) -> Comparison:
    """Old trajectories and runs are read as their own softbody had them.

    Softbody has kept them since there are such, beside formats 2, 5 and 6. They are as the revision that wrote them had
    them, to the bit: times, bodies, names, and each frame. A run of then can be gone on with, and its last frame is
    where its world is.
    """
    right = dict[str, dict[str, bool]]()
    for name, said in expected_of("trajectory").items():
        path, no_names = FILES / name, [None] * (len(said["particles"]) + len(said["box_sizes"]))
        said = {"names": no_names, **said}
        right[name] = compared(asked(told_of_trajectory, path), said)
        if path.parent.name == "run":
            right[f"{name}, gone on with"] = compared(asked(gone_on_with, path.parent), said)
            (of_world,) = expected_of(name.replace("trajectory", "world.npz")).values()
            put_back = {"motion": of_world["motion"]}
            right[f"{name}, put back"] = compared(asked(last_frame_in_world, path.parent), put_back)
    return comparison(right)
