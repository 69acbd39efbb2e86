"""Claims that what worlds, bodies, messages and progress say is true, and what is read-only is so."""

from __future__ import annotations

import io
import re
import tempfile
from collections.abc import Callable, Iterator
from contextlib import redirect_stderr
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

import softbody
from softbody import ParameterError, Trajectory, TrajectoryWriter, World
from softbody.bodies import names, rigid_box, soft_body
from softbody.cli import progress
from softbody.geometry import MeshQuery, query
from softbody.trajectory import reader
from validation.answers import Answers
from validation.cases import random_mesh, random_orientations
from validation.check import Comparison, Run, check
from validation.checks.contract.cases import error_of, rigid, soft
from validation.checks.contract.exports import asked
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]\d+)?")
MOST_NUMBERS = 9  # that anything says of itself


def told(thing: object) -> tuple[str, list[float]]:
    """Return the words and the numbers that something says of itself, nothing where it cannot."""
    text: str = asked(partial(repr, thing), "")
    return NUMBER.sub("#", text), [float(number) for number in NUMBER.findall(text)]


def _volume(mesh: softbody.Mesh) -> float:
    return float(np.linalg.det(mesh.vertices[mesh.triangles]).sum()) / 6.0


def of_things(rng: np.random.Generator, folder: Path) -> Iterator[tuple[object, str, list[float]]]:
    """Yield things, and the words and numbers that they must say: from what they were made of, by NumPy."""
    world = World(gravity=(0.0, 0.0, 0.0))
    mesh, mass, size, place = random_mesh("torus", rng), rng.uniform(0.5, 20.0), rng.uniform(0.1, 3.0, 3), np.zeros(3)
    yield mesh, "<Mesh: # vertices, # triangles, # m³>", [len(mesh.vertices), len(mesh.triangles), _volume(mesh)]
    start = 30.0 * rng.normal(size=3)
    centre = mesh.vertices.mean(axis=0) + start
    yield world, "<World: # soft bodies of # particles, # boxes; # steps, # s>", [0, 0, 0, 0, 0]
    body = world.add_soft_body(mesh, mass, 100.0, 0.0, start)
    gone, another = (world.add_soft_body(softbody.octahedron(), mass, 1.0, 0.0, k) for k in ((99, 0, 0), (199, 0, 0)))
    world.remove(gone)
    yield gone, "<soft body that is gone>", []
    yield body, "<soft body #: # particles, # kg, at (#, #, #) m>", [0, len(mesh.vertices), mass, *centre]
    another.name = "top"
    yield another, "<soft body # 'top': # particles, # kg, at (#, #, #) m>", [1, 6, mass, 199, 0, 0]
    turn = random_orientations(rng, 1)[0]
    boxes = [world.add_box(size, each, place + 500.0 * k, turn) for k, each in enumerate((mass, None, mass), 1)]
    kinematic = world.add_box(size, None, place - 500.0, velocity=(0.0, 0.0, 0.1), name="lift")
    world.remove(boxes[2])
    yield boxes[0], "<box #: (#, #, #) m, # kg, at (#, #, #) m>", [0, *size, mass, 500, 500, 500]
    yield boxes[1], "<box #: (#, #, #) m, static, at (#, #, #) m>", [1, *size, 1000, 1000, 1000]
    yield boxes[2], "<box that is gone>", []
    yield kinematic, "<box # 'lift': (#, #, #) m, kinematic, at (#, #, #) m>", [2, *size, -500, -500, -500]
    stiffness, end = rng.uniform(1.0, 1e4), rng.normal(size=3)
    joint = world.add_joint((boxes[0], place + 500.0), place + 500.0 + end, stiffness)
    yield joint, "<joint #: # m, # N/m>", [0, float(np.linalg.norm(end)), stiffness]
    world.remove(joint)
    yield joint, "<joint that is gone>", []
    with TrajectoryWriter(world, folder) as kept:
        empty = Trajectory.open(folder)
        for _ in range(3):
            kept.frame()
            world.time += 0.25
    bodies = [2.0, len(mesh.vertices) + 6.0, 3.0]
    words = "soft bodies of # particles, # boxes>"
    yield empty, f"<Trajectory: # frames; # {words}", [0, *bodies]
    yield Trajectory.open(folder), f"<Trajectory: # frames until # s; # {words}", [3, 0.5, *bodies]
    yield Trajectory.open(folder)[2].bodies, f"<# {words}", bodies
    with TrajectoryWriter(world, folder / "changed") as kept:
        kept.frame()
        lamp = world.add_box(size, None, place - 900.0)
        kept.frame()
        world.remove(lamp)
        kept.frame()
    yield Trajectory.open(folder / "changed"), "<Trajectory: # frames until # s; bodies change # times>", [3, 0.75, 2]
    yield world.ground, "<no ground>", []
    height, restitution, friction = rng.uniform(-3000.0, -2000.0), rng.random(), rng.random()
    ground = world.add_ground(height, restitution=restitution, friction=friction)
    yield ground, "<ground at # m: restitution #, friction #>", [height, restitution, friction]
    world.step(1e-3, 7)
    numbers = [*bodies, height, 7, world.time]
    yield world, "<World: # soft bodies of # particles, # boxes, ground at # m; # steps, # s>", numbers


@check(
    section="beyond the paper",
    piece="softbody.World, softbody.SoftBody, softbody.Box, softbody.Joint, softbody.Ground, softbody.Trajectory,"
    " softbody.Mesh",
    reference="what they were made of, by NumPy",
    kind="specification",
    unit="relative; 1 for other words",
    tolerance=2e-3,
    because="four digits: up to 5e-4 of a number",
    faults=(
        Fault("what is gone is there", soft_body.SoftBody.__repr__, "not self.is_there → self.is_there"),
        Fault("a mesh said to be of twice its volume", softbody.Mesh.__repr__, "self.volume → 2.0 * self.volume"),
        Fault("boxes said to be of half their size", rigid_box.Box.__repr__, "self.size → 0.5 * self.size"),
        Fault("the time of the first frame", reader.Trajectory.__repr__, "self.times[-1] → self.times[0]"),
        Fault("how long it lasts, of no frames", reader.Trajectory.__repr__, "len(self) → not len(self)"),
    ),
)
def what_things_say(run: Run) -> Comparison:
    """What things say of themselves is so, to four digits.

    Worlds, bodies, joints, the ground, trajectories and bodies of frames: how many, large and heavy, where and how
    stiff they are, and if they are there at all. Also of what has a name, or has moved up when another was removed.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(2, 10, 100)):
        with tempfile.TemporaryDirectory() as folder:
            for thing, words, numbers in of_things(rng, Path(folder) / "kept"):
                said, of = told(thing)
                unsaid = [0.0] * (MOST_NUMBERS - len(numbers))
                rule = np.array([1.0, *numbers, *unsaid])
                scale = np.where(rule == 0.0, 1.0, np.abs(rule))
                of = of if len(of) == len(numbers) else [np.inf] * len(numbers)
                answers.add(np.array([said == words, *of, *unsaid]) / scale, rule / scale, kind=words)
    return answers.comparison()


GIVING: dict[str, Callable[[Any], object]] = {  # a name, each in a world of its own
    "add_soft_body(name=…)": lambda name: soft(name=name),
    "add_box(name=…)": lambda name: rigid(name=name),
    "soft_body.name = …": lambda name: setattr(soft().soft_bodies[0], "name", name),
    "box.name = …": lambda name: setattr(rigid().boxes[0], "name", name),
}
NAMED = ("a", "two words", "ß漢", "x" * 100, "12", "'")
NO_NAMES = ("", "x" * 101, " a", "a ", "a\n", "a\tb", "\x7f", "\u202e", 7, True, b"a")


@check(
    section="beyond the paper",
    piece="softbody.SoftBody.name, softbody.Box.name, softbody.World.__getitem__",
    reference="the documentation; the names that were given, counted",
    kind="specification",
    faults=(
        Fault("names of any length", names.checked_name, "0 < len(value) <= MOST → 0 < len(value)"),
        Fault("spaces around", names.checked_name, "value == value.strip() → True"),
        Fault("one too many", names.names_listed, "len(names) - MOST_LISTED → len(names) - MOST_LISTED + 1"),
        Fault("one that is not said", names.names_listed, "len(names) > MOST_LISTED → len(names) > MOST_LISTED + 1"),
    ),
)
def names_and_who_has_them(run: Run) -> Comparison:
    """A name is any text of 1 to 100 printable characters.

    Without spaces around it, for a soft body or a box; others are refused by an error that says so. Who asks for one
    that nobody has is told those that there are, each once, all or how many more. The one spelt nearly so is told, too.
    """
    rng, answers = run.fresh_rng(), Answers()
    for (what, give), value in product(GIVING.items(), (*NAMED, *NO_NAMES)):
        error = error_of(ParameterError, give, value)
        is_so = error is None if value in NAMED else "1 to 100 characters" in str(error)
        answers.add(is_so, True, kind=what)
    for count in (0, 1, 2, *range(18, 24), *rng.integers(25, 60, run.count(1, 10, 100))):
        world, given = World(), [f"body {k}" for k in rng.permutation(100)[:count]]
        for k, name in enumerate(given):
            world.add_box((1.0, 1.0, 1.0), None, (3.0 * k, 0.0, 0.0), name=name)
        meant = str(rng.choice(given)) if count else "body"
        text = str(error_of(ParameterError, world.__getitem__, meant + "x")).partition("in this world; ")[2]
        listed, more = re.findall(r"'(body \d+)'", text.partition("there are ")[2]), re.findall(r"and (\d+) more", text)
        are_all = listed == given[: len(listed)] and len(listed) + sum(map(int, more)) == count
        is_meant = len(listed) <= 20 and (not count or f"did you mean {meant!r}" in text)
        answers.extend([are_all, is_meant], [True] * 2, kind=["names that there are", "the name that is meant"])
    return answers.comparison()


def read_only(rng: np.random.Generator, folder: Path) -> Iterator[tuple[str, Callable[[], np.ndarray]]]:
    """Yield what is documented as read-only, and what asks for it."""
    mesh = random_mesh("sphere", rng)
    asking, world = MeshQuery(mesh), World()
    body = world.add_soft_body(mesh, 1.0, 100.0, 10.0)
    with TrajectoryWriter(world, folder) as kept:
        kept.frame()
    opened = Trajectory.open(folder)
    yield "Mesh.vertices", lambda: mesh.vertices
    yield "Mesh.triangles", lambda: mesh.triangles
    yield "MeshQuery.vertices", lambda: asking.vertices
    yield "MeshQuery.triangles", lambda: asking.triangles
    yield "SoftBody.stiffness", lambda: body.stiffness
    yield "SoftBody.rest_length", lambda: body.rest_length
    yield "Trajectory.times", lambda: opened.times


@check(
    section="beyond the paper",
    piece="softbody.Mesh, softbody.geometry.MeshQuery, softbody.SoftBody.stiffness, softbody.SoftBody.rest_length,"
    " softbody.Trajectory",
    reference="NumPy's ValueError; copies that were taken before",
    kind="specification",
    faults=(
        Fault("arrays of a MeshQuery as they are", query._read_only, "view.flags.writeable = False → "),
        Fault("springs as they are", soft_body._read_only, "view.flags.writeable = False → "),
        Fault("times as they are", reader.Trajectory.__init__, "self.times.flags.writeable = False → "),
    ),
)
def what_is_read_only(run: Run) -> Comparison:
    """What is read-only refuses to be written to, and stays as before.

    Vertices and triangles of a Mesh or a MeshQuery, stiffness and rest lengths of a soft body, times of a trajectory.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 5, 50)):
        with tempfile.TemporaryDirectory() as folder:
            for what, ask in read_only(rng, Path(folder) / "kept"):
                before = ask().copy()
                is_refused = "read-only" in str(error_of(ValueError, ask().__setitem__, 0, 7))
                answers.add(is_refused and ask().tobytes() == before.tobytes(), True, kind=what)
    return answers.comparison()


LINE = re.compile(r"frame (\d+) of (\d+), (\d+):(\d\d):(\d\d) left")


@check(
    section="beyond the paper",
    piece="softbody.cli.progress.reporter",
    reference="closed form: frames that are left × seconds a frame; a clock that is set",
    kind="closed form",
    unit="frames, seconds",
    tolerance=0.51,
    because="whole seconds: half of one",
    faults=(
        Fault("all of the frames are left", progress._Lines.__call__, "self._total - frames → self._total"),
        Fault("frames that were there before", progress._Lines.__call__, "a_ / (frames - self._done) → a_ / frames"),
        Fault("minutes of any number", progress._Lines.__call__, "left // 60 % 60 → left // 60"),
        Fault("lines at every frame", progress._Lines.__call__, "self._next = now + PAUSE → "),
    ),
)
def time_that_is_left(run: Run) -> Comparison:
    """Without a terminal, a line every five seconds says what is left.

    At the first frame from then on: which frame of how many it is, and how long the rest will take. Each is to take as
    long as those since the run was begun, or gone on with.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(6, 30, 300)):
        each, total = (0.125, 0.5, 8.0)[trial % 3], int(rng.integers(200, 100_000))
        done = int(rng.integers(0, total - 150))
        clock, stream = [1000.0], io.StringIO()
        with (
            redirect_stderr(stream),
            mock.patch.object(progress, "monotonic", lambda now=clock: now[0]),
            progress.reporter(total, done) as tell,
        ):
            for k in range(done + 1, done + 121):
                clock[0] += each
                tell(k)
        lines = [[float(number) for number in found] for found in LINE.findall(stream.getvalue())]
        apart = max(1, int(np.ceil(5.0 / each)))  # frames from line to line
        judged = [[float(done + k), total, (total - done - k) * each] for k in range(apart, 121, apart)]
        rows = [[frame, of, 3600.0 * hours + 60.0 * minutes + left] for frame, of, hours, minutes, left in lines]
        is_clock = all(minutes < 60.0 and left < 60.0 for *_, minutes, left in lines)
        told = [[len(rows), is_clock, 0.0], *(rows + [[0.0] * 3] * len(judged))[: len(judged)]]
        answers.extend(told, [[len(judged), 1.0, 0.0], *judged], kind=f"{each} s a frame")
    return answers.comparison()
