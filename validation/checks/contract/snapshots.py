"""Claims that entries of saved worlds and trajectories are believed only where possible, or refused by name."""

from __future__ import annotations

import json
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import softbody
from softbody import SnapshotError, Trajectory, TrajectoryError, TrajectoryWriter, World
from softbody.storage import snapshot, snapshot_entries
from softbody.trajectory import entries, manifest
from validation.cases import random_orientations
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

Arrays = dict[str, np.ndarray]

LEAST, NAN, INF, LARGEST = 5e-324, float("nan"), float("inf"), 1e50
TOO_LARGE = 1.01 * LARGEST
ABOVE_ONE = float(np.nextafter(1.0, 2.0))


class Limits(NamedTuple):
    """Which numbers an entry may hold, up to its limits, and which not, from just beyond them."""

    taken: tuple[float, ...]
    refused: tuple[float, ...]


REAL = Limits((0.0, -LARGEST, LARGEST), (NAN, INF, -INF, TOO_LARGE, -TOO_LARGE))
NOT_NEGATIVE = Limits((0.0, LEAST, LARGEST), (-LEAST, -1.0, NAN, INF, TOO_LARGE))
POSITIVE = Limits((1.0 / LARGEST, 1.0, LARGEST), (0.0, -1.0, 0.99 / LARGEST, NAN, INF, TOO_LARGE))
UP_TO_ONE = Limits((0.0, 1.0), (-LEAST, ABOVE_ONE, NAN, INF))
NO_LIMIT = Limits((0.0, 1.0, INF), (-LEAST, NAN, -INF))


def only(limits: Limits) -> Limits:
    """Return limits of which only what is refused is tried: what is taken depends on other entries."""
    return Limits((), limits.refused)


# What softbody/model/arrays.py and World's arguments say of each entry that holds real numbers.
NUMBERS: dict[str, Limits] = {
    "model.particle_inverse_mass": NOT_NEGATIVE,
    "model.edge_rest_length": POSITIVE,
    "model.edge_stiffness": NOT_NEGATIVE,
    "model.soft_thickness": POSITIVE,
    "model.soft_edge_length": POSITIVE,
    "model.soft_mesh_volume": POSITIVE,
    "model.soft_deflated_below": UP_TO_ONE,
    "model.soft_damping": NOT_NEGATIVE,
    "model.soft_drag": NOT_NEGATIVE,
    "model.soft_restitution": UP_TO_ONE,
    "model.soft_friction": NOT_NEGATIVE,
    "model.box_size": only(POSITIVE),
    "model.box_inverse_mass": only(NOT_NEGATIVE),
    "model.box_inverse_inertia": only(NOT_NEGATIVE),
    "model.box_restitution": UP_TO_ONE,
    "model.box_friction": NOT_NEGATIVE,
    "model.ground_height": Limits((0.0, -LARGEST, LARGEST, -INF), (NAN, INF, TOO_LARGE, -TOO_LARGE)),
    "model.ground_restitution": UP_TO_ONE,
    "model.ground_friction": NOT_NEGATIVE,
    "controls.gravity": REAL,
    "controls.soft_gas": NOT_NEGATIVE,
    "controls.particle_force": REAL,
    "controls.box_force": REAL,
    "controls.box_torque": REAL,
    "state.particle_position": REAL,
    "state.particle_velocity": REAL,
    "state.box_position": REAL,
    "state.box_orientation": only(REAL),
    "state.box_velocity": REAL,
    "state.box_angular_velocity": REAL,
    "state.box_time_left": NOT_NEGATIVE,
    "joints.joint_weights": only(UP_TO_ONE),
    "joints.joint_place": REAL,
    "joints.joint_stiffness": NOT_NEGATIVE,
    "joints.joint_damping": NOT_NEGATIVE,
    "joints.joint_rest_length": NOT_NEGATIVE,
    "cache.point": REAL,
    "cache.impulse": REAL,
    "settings.speed_ceiling": NO_LIMIT,
    "settings.angular_speed_ceiling": NO_LIMIT,
    "settings.angular_speed_floor": NO_LIMIT,
    "settings.sleep_speed": NO_LIMIT,
    "settings.sleep_after": NO_LIMIT,
    "rest.time": NOT_NEGATIVE,
    "time": NOT_NEGATIVE,
}
# The same of those that hold one whole number. (Others are tried as what they say together.)
WHOLE: dict[str, tuple[tuple[int, ...], tuple[int, ...]]] = {
    "format": ((), (-1, 0, 1, 7, 2**62)),
    "model.soft_count": ((), (-1, 1, 3)),
    "model.box_count": ((), (-1, 3, 5)),
    "settings.integrator": ((0, 1, 2), (-1, 3, 2**62)),
    "settings.substeps": ((1, 10_000_000), (0, -1, 10_000_001)),
    "settings.iterations": ((1, 10_000_000), (0, -1, 10_000_001)),
    "steps": ((0, 2**62), (-1, 2**62 + 1)),
}


# By the letter of a kind of numbers, or of words: others.
OTHER_KINDS = {"f": ("i8", "U1", "?", "c16"), "i": ("f8", "U1", "?", "c16"), "b": ("i8", "U1", "f8"), "U": ("i8", "f8")}


class Trial(NamedTuple):
    """A saved world of which something was altered, and what must come of it."""

    what: str
    arrays: dict[str, Any]
    named: str | None  # what the refusal must name; None: it must be taken


def saved_world(rng: np.random.Generator) -> Arrays:
    """Return what is saved of two soft bodies, boxes that stand on each other, a light and a static one, and joints.

    Some of them have names, and the solver remembers contacts.
    """
    world = World(gravity=(0.0, 0.0, -9.0))
    world.add_ground()
    solid = world.add_soft_body(softbody.octahedron(0.4), 1.0, 100.0, 10.0, (3.0, 0.0, 2.0), name="solid")
    other = world.add_soft_body(softbody.icosahedron(0.4), 2.0, 80.0, 10.0, (6.0, 0.0, 2.0), fixed=(2,))
    size, turn = (0.5, 0.4, 0.3), random_orientations(rng, 1)[0]
    world.add_box(size, 2.0, (0.0, 0.0, 0.1495))
    lid = world.add_box(size, 1.0, (0.0, 0.0, 0.449), name="lid")
    light = world.add_box(size, 1e-4, (-3.0, 0.0, 3.0), turn)
    world.add_box(size, None, (-6.0, 0.0, 3.0), turn)
    other.external_force = 0.01 * rng.normal(size=other.positions.shape)
    world.step(1e-3, 3)
    world.add_joint((lid, lid.position + (0.1, 0.0, 0.1)), (0.0, 0.0, 1.0), 1e-3, name="string")
    world.add_joint((solid, 1), (light, light.position), 1e-3)
    world.add_joint((solid, solid.positions[[0, 2, 4]].mean(axis=0)), (other, 4), 1e-3)
    return world.snapshot()


def put(array: np.ndarray, place: Any, value: Any) -> np.ndarray:
    """Return a copy with something else at a place."""
    changed = array.copy()
    changed[place] = value
    return changed


def entry_by_entry(saved: Arrays, rng: np.random.Generator) -> Iterator[Trial]:
    """Yield trials of each entry by itself: gone, of another kind or shape, and with numbers at and beyond limits."""
    for name, array in saved.items():

        def trial(what: str, changed: Any, named: str | None, name: str = name) -> Trial:
            return Trial(f"{what}: {name}", saved | {name: changed}, named)

        yield Trial(f"missing: {name}", {key: saved[key] for key in saved if key != name}, f"{name!r} is missing")
        yield trial("no array", None, name)
        yield trial("an axis more", array[None], name)
        yield trial("of the other byte order", array.astype(array.dtype.newbyteorder()), None)
        for kind in OTHER_KINDS[array.dtype.kind]:
            zeros = np.zeros(array.shape, np.dtype(kind))
            yield trial(f"{zeros.dtype}", zeros, f"{name} holds {zeros.dtype}")
        if array.ndim:
            yield trial("a row less", array[:-1], "joints." if name == "joints.joint_box" else name)
            yield trial("Fortran's order", np.asfortranarray(array), None)
            if array.dtype.kind in "fi":
                half = array.astype(np.float32 if array.dtype.kind == "f" else np.int32)
                yield trial(f"{half.dtype}", half, f"{name} holds {half.dtype}")
        if name in NUMBERS:
            for value in (*NUMBERS[name].taken, *NUMBERS[name].refused):
                place = tuple(int(rng.integers(n)) for n in array.shape)
                is_taken = value in NUMBERS[name].taken
                yield trial(f"{value}", put(array, place, value), None if is_taken else name)
        if name in WHOLE:
            of_many = "model." if name.endswith("_count") else name
            for number in WHOLE[name][0]:
                yield trial(f"{number}", np.array(number), None)
            for number in WHOLE[name][1]:
                yield trial(f"{number}", np.array(number), of_many)


def together(saved: Arrays, rng: np.random.Generator) -> Iterator[Trial]:
    """Yield trials of what entries say together: masses, turns, joints, surfaces, contacts and names."""

    def trial(what: str, named: str | None, **changes: Any) -> Trial:
        return Trial(what, saved | {name.replace("__", "."): array for name, array in changes.items()}, named)

    yield trial("an entry more", "'model.colour' is no entry", model__colour=np.zeros(3))
    yield trial("precision: single", None, precision=np.array("single"))
    yield trial("precision: half", "precision is 'half'", precision=np.array("half"))

    # Masses: of each body something is free, and a box turns as one of its size and mass does.
    masses, starts = saved["model.particle_inverse_mass"], saved["model.soft_particle_start"]
    for body in range(len(starts) - 1):
        rows = np.arange(starts[body], starts[body + 1])
        free = put(put(masses, rows, 0.0), rng.choice(rows), 1.0)
        yield trial("one particle is free", None, model__particle_inverse_mass=free)
        held = f"model.particle_inverse_mass of soft body {body}"
        yield trial("no particle is free", held, model__particle_inverse_mass=put(masses, rows, 0.0))
    inverse = saved["model.box_inverse_inertia"]
    for box, axis in np.ndindex(inverse.shape):
        culprit = f"model.box_inverse_inertia[{box}]"
        exact = inverse[box, axis]
        offs = [(by, None if abs(by) < 1e-9 else culprit) for by in (0.9e-9, -0.9e-9, 1.1e-9, -1.1e-9)]
        for number, named in [(exact * (1.0 + by), named) for by, named in offs] if exact else [(1e-30, culprit)]:
            changed = put(inverse, (box, axis), number)
            yield trial("an inertia that is off", named, model__box_inverse_inertia=changed)
    turns = saved["state.box_orientation"]
    for box in range(len(turns)):
        for by in (0.99e-6, -0.99e-6, 1.01e-6, -1.01e-6, 1.0, -1.0):
            named = None if abs(by) < 1e-6 else f"state.box_orientation[{box}]"
            turned = put(turns, box, (1.0 + by) * turns[box] / np.linalg.norm(turns[box]))
            yield trial("a turn of another length", named, state__box_orientation=turned)
    yield from of_joints(saved)
    yield from of_surfaces(saved, rng)
    yield from of_contacts(saved)
    yield from of_rest(saved)
    yield from of_names(saved)


def of_joints(saved: Arrays) -> Iterator[Trial]:
    """Yield trials of what each end of each joint may be on: a box, three particles of one body, or nothing."""
    starts, boxes = saved["model.soft_particle_start"], len(saved["model.box_size"])
    count = int(starts[-1])
    nothing, whole, none = (-1, -1, -1), (0.2, 0.3, 0.5), (0.0, 0.0, 0.0)
    across = (starts[1] - 1, starts[1] - 1, starts[1])
    ends = [  # box, particles, weights, and whether an end may be that
        (-1, nothing, none, True),
        (0, nothing, none, True),
        (boxes - 1, nothing, none, True),
        (-1, (0, 1, 2), whole, True),
        (-1, (count - 3, count - 2, count - 1), whole, True),
        (-1, (0, 1, 2), (1.0, 0.0, 0.0), True),
        (-1, (0, 1, 2), (0.2, 0.3, 0.5 + 0.9e-9), True),
        (-1, (0, 1, 2), (0.2, 0.3, 0.5 + 1.1e-9), False),
        (-1, (0, 1, 2), (0.2, 0.3, 0.5 - 1.1e-9), False),
        (-1, (0, 1, 2), none, False),
        (-1, nothing, whole, False),
        (0, nothing, whole, False),
        (boxes, nothing, none, False),
        (boxes, (0, 1, 2), whole, False),
        (0, (0, 1, 2), whole, False),
        (-1, (0, -1, 2), whole, False),
        (-1, (-1, -1, 2), whole, False),
        (-1, (0, -1, 2), none, False),
        (-1, (count - 2, count - 1, count), whole, False),
        (-1, (count, count, count), whole, False),
        (-1, across, whole, False),
        (-1, across[::-1], whole, False),
    ]
    for joint, end in np.ndindex(saved["joints.joint_box"].shape):
        three = slice(3 * end, 3 * end + 3)
        for box, particles, weights, is_right in ends:
            changes = {
                "joints.joint_box": put(saved["joints.joint_box"], (joint, end), box),
                "joints.joint_particles": put(saved["joints.joint_particles"], (joint, three), particles),
                "joints.joint_weights": put(saved["joints.joint_weights"], (joint, three), weights),
            }
            named = None if is_right else f"of end {end} of joint {joint}"
            if (
                is_right
                and (changes["joints.joint_box"][joint] < 0).all()
                and (changes["joints.joint_particles"][joint] < 0).all()
            ):
                named = f"both ends of joint {joint}"
            yield Trial("an end of a joint", saved | changes, named)
        for name, least in (("joint_box", -2), ("joint_particles", -2)):
            array = saved[f"joints.{name}"]
            place = (joint, end if name == "joint_box" else 3 * end)
            yield Trial("a number below −1", saved | {f"joints.{name}": put(array, place, least)}, f"joints.{name}[")
    without = {name: array for name, array in saved.items() if not name.startswith("joints.")}
    yield Trial("no joints", without | {"names.joint": np.array([], "U1")}, None)


def of_surfaces(saved: Arrays, rng: np.random.Generator) -> Iterator[Trial]:
    """Yield trials of surfaces that are none, or none with these edges."""
    for kind in ("particle", "edge", "triangle"):
        name = f"model.soft_{kind}_start"
        for begin in ([1, *saved[name][1:]], [0, 0, saved[name][2]], [0, saved[name][2], saved[name][2]]):
            yield Trial("where bodies begin", saved | {name: np.array(begin)}, f"{name} is")
        yield Trial("where bodies begin", saved | {name: put(saved[name], 1, -1)}, f"{name}[1]")
    triangles, edges = saved["model.triangle_particles"], saved["model.edge_particles"]
    ends, last = saved["model.soft_triangle_start"], saved["model.soft_particle_start"]
    for body in range(len(ends) - 1):
        row, first = int(rng.integers(ends[body], ends[body + 1])), int(last[body])
        named = f"model.triangle_particles of soft body {body}"
        for wrong in (
            triangles[row, ::-1],
            np.repeat(triangles[row, 0], 3),
            put(triangles[row], 1, first - 1),
            put(triangles[row], 2, last[body + 1]),
            np.roll(triangles, 1 if row else -1, axis=0)[row],
        ):
            changed = put(triangles, row, wrong)
            yield Trial("no surface", saved | {"model.triangle_particles": changed}, named)
        turned = put(triangles, row, np.roll(triangles[row], 1))
        yield Trial("a triangle that begins elsewhere", saved | {"model.triangle_particles": turned}, None)
        rows = slice(*saved["model.soft_edge_start"][body : body + 2])
        named = f"model.edge_particles of soft body {body}"
        for own in (np.roll(edges[rows], 1, axis=0), edges[rows][:, ::-1], put(edges[rows], 1, edges[rows][0])):
            yield Trial("other edges", saved | {"model.edge_particles": put(edges, rows, own)}, named)


def of_contacts(saved: Arrays) -> Iterator[Trial]:
    """Yield trials of what the solver remembers: pairs (a, b) of boxes, or a box and the ground, −1, in order."""
    boxes = len(saved["model.box_size"])
    lists: list[tuple[list[tuple[int, int]], bool]] = [
        ([], True),
        ([(0, -1)], True),
        ([(0, -1), (1, 0)], True),
        ([(1, 0), (1, 0)], True),
        ([(1, -1), (1, 0), (2, -1), (2, 0), (2, 1), (boxes - 1, -1)], True),
        ([(1, 0), (0, -1)], False),
        ([(1, 0), (1, -1)], False),
        ([(2, 1), (2, 0), (3, 0)], False),
        ([(0, -1), (2, 1), (1, 0)], False),
        ([(0, 0)], False),
        ([(0, 1)], False),
        ([(boxes, 0)], False),
        ([(-1, -1)], False),
        ([(0, -1), (boxes, -1)], False),
    ]
    for pairs, is_right in lists:
        n = len(pairs)
        yield Trial(
            "contacts of the last step",
            saved
            | {
                "cache.number": np.array([n]),
                "cache.box": np.array(pairs, np.int64).reshape(n, 2),
                "cache.feature": np.arange(n) - 2**62,
                "cache.point": np.zeros((n, 3)),
                "cache.impulse": np.ones((n, 3)),
            },
            None if is_right else "cache.box is no list",
        )
    yield Trial("below the ground", saved | {"cache.box": put(saved["cache.box"], (0, 1), -2)}, "cache.box[0, 1] is -2")
    yield Trial("fewer than no contacts", saved | {"cache.number": np.array([-1])}, "cache.number[0] is -1")


def of_rest(saved: Arrays) -> Iterator[Trial]:
    """Yield trials of who sleeps: 1 or 0."""
    for value, named in ((1, None), (0, None), (2, "rest.asleep[1] is 2"), (-1, "rest.asleep[1] is -1")):
        yield Trial("asleep", saved | {"rest.asleep": put(saved["rest.asleep"], 1, value)}, named)


def of_names(saved: Arrays) -> Iterator[Trial]:
    """Yield trials of names: 1 to 100 printable characters, no space first or last, and each one's own."""
    for kind in ("soft", "box", "joint"):
        name = f"names.{kind}"
        count = len(saved[name])
        for word, is_right in {
            "a": True,
            "two words": True,
            "ß漢": True,
            "x" * 100: True,
            "x" * 101: False,
            " a": False,
            "a ": False,
            "a\n": False,
            "\u202e": False,
        }.items():
            words = np.array([""] * (count - 1) + [word])
            yield Trial("a name", saved | {name: words}, None if is_right else f"{name}[{count - 1}]")
        given = np.array(["solid", *[""] * (count - 1)])
        taken = {"names.soft": np.array(["", "solid"])} if kind != "soft" else {"names.soft": np.array(["b", "b"])}
        culprit = "names.soft[1]" if kind == "soft" else f"{name}[0]"
        yield Trial("a name of two", saved | ({name: given} if kind != "soft" else {}) | taken, culprit)
        for order in "<>":
            no_letter = np.array([0x110000] * count, f"{order}u4").view(f"{order}U1")
            yield Trial("no letter", saved | {name: no_letter}, f"{name} holds 0x110000")
            yield Trial("no letter", saved | {"precision": no_letter[0:1].reshape(())}, "precision holds 0x110000")


def right_about(trial: Trial, world: World) -> bool:
    """Tell whether a world takes a trial, with every entry as it is there, or refuses it by the name that it must."""
    try:
        world.restore(trial.arrays)
    except SnapshotError as error:
        return trial.named is not None and trial.named in str(error)
    except Exception:
        return False
    told = world.snapshot()
    kept = [name for name in trial.arrays if name != "format" and not name.startswith("rings.")]
    return trial.named is None and all(_same(told[name], trial.arrays[name]) for name in kept)


def _same(one: np.ndarray, other: np.ndarray) -> bool:
    return one.shape == other.shape and bool((one == other).all())


@check(
    section="9",
    piece="softbody.World.restore, softbody.World.load",
    reference="what is said of each entry where it is declared, tried one by one",
    kind="specification",
    faults=(
        Fault("joints on boxes that are not there", snapshot._joints, "box < model.box_count → box <= model.box_count"),
        Fault("joints that hold nothing", snapshot._joints, "holds.all() → True"),
        Fault("weights of any sum", snapshot._joints, "np.abs(weights.sum(axis=2) - on_soft) <= SAME → True"),
        Fault("inertia as it comes", snapshot._check_masses, "good.all() → True", nth=0),
        Fault("limits that are left out", snapshot_entries._check, "array <= rows.most → True"),
        Fault("settings as they come", snapshot._settings, "check_settings(s_, n_) → "),
        Fault("contacts in any order", snapshot._impulses, "np.diff(b) >= 0 → True"),
        Fault("letters that are none", snapshot_entries.Entries.words, "_check_letters(n_, a_) → "),
    ),
)
def entries_of_saved_worlds(run: Run) -> Comparison:
    """Each entry of a saved world that is altered, to and beyond the limits of what it may be, by itself and with those
    that it must go with, is taken as it is, or refused by its name: numbers, kinds, shapes, masses, turns, ends of
    joints, surfaces, contacts, settings and names."""
    rng = run.fresh_rng()
    right, kinds = [], []
    world = World()
    for _ in range(run.count(1, 5, 50)):
        saved = saved_world(rng)
        for trial in (*entry_by_entry(saved, rng), *together(saved, rng)):
            right.append(right_about(trial, world))
            kinds.append(trial.what.rpartition(": ")[2])
    return Comparison(np.array(right), np.ones(len(right), bool), groups=kinds)


BOUND = re.compile(r"(>|≥|≤) (\S+?)(?=,| |$)")
SIZES = re.compile(r"(?:up to|between (\S+) and) (\S+)$")


def fits(value: float, said: str) -> bool:
    """Tell whether a number is what a message says that it must be."""
    bounds = {">": np.greater, "≥": np.greater_equal, "≤": np.less_equal}
    is_within = all(bounds[sign](value, float(limit)) for sign, limit in BOUND.findall(said))
    sizes = SIZES.search(said)
    if said.startswith("a whole number"):
        return bool(is_within and float(value).is_integer())
    if not said.startswith("a finite number") or sizes is None:
        return False
    least, most = float(sizes[1] or 0.0), float(sizes[2])
    return bool(is_within and np.isfinite(value) and least * (1.0 - 1e-12) <= abs(value) <= most)  # six digits are said


@check(
    section="9",
    piece="softbody.World.restore",
    reference="what is said of each entry where it is declared; the limits that the message names, read as numbers",
    kind="specification",
    faults=(
        Fault("a limit that is not said", snapshot_entries._limits, "rows.most < np.inf → False"),
        Fault("no smallest size", snapshot_entries._limits, "rows.above >= 0.0 → False"),
        Fault("above for at least", snapshot_entries._limits, "rows.least > -np.inf → rows.above > -np.inf"),
    ),
)
def refusals_say_what_is_taken(run: Run) -> Comparison:
    """What a refusal of a number in a saved world says that it must be is so: whatever numbers the entry takes are of
    that kind and within those limits, and whatever it refuses is not."""
    rng = run.fresh_rng()
    right, kinds = [], []
    world, saved = World(), saved_world(rng)
    for name, limits in NUMBERS.items():
        for value in limits.refused:
            array = np.array(saved[name])
            if not array.size or name.startswith(("settings.", "cache.")):
                continue
            place = tuple(int(rng.integers(n)) for n in array.shape)
            array[place] = value
            try:
                world.restore(saved | {name: array})
                said = ""
            except SnapshotError as error:
                said = str(error).partition("; it must be ")[2]
            taken = [other for other in limits.taken if np.isfinite(other)]  # −∞ says that there is no ground
            right.append(bool(said) and not fits(value, said) and all(fits(other, said) for other in taken))
            kinds.append(name)
    return Comparison(np.array(right), np.ones(len(right), bool), groups=kinds)


def flight(rng: np.random.Generator, folder: Path) -> World:
    """Keep two chunks of two frames of a world of two soft bodies and two boxes; return the world."""
    world = World()
    for k, mesh in enumerate((softbody.tetrahedron(0.4), softbody.octahedron(0.4))):
        world.add_soft_body(mesh, 1.0, 100.0, 10.0, (3.0 * k, 0.0, 0.0), rng.normal(size=3))
    for k, turn in enumerate(random_orientations(rng, 2)):
        world.add_box((0.5, 0.4, 0.3), 1.0, (0.0, 3.0 + 3.0 * k, 0.0), turn, rng.normal(size=3), name="ab"[k])
    with TrajectoryWriter(world, folder) as kept:
        for k in range(4):
            world.time = 0.25 * k
            kept.frame()
            if k % 2:
                kept.flush()
    return world


class Damage(NamedTuple):
    """A file of a trajectory that was altered, and what must come of it."""

    what: str
    file: str
    raw: dict[str, Any] | bytes  # arrays, or what the file holds
    named: str | None  # what the refusal must name; None: it must be taken


PLACES = ("particle_position", "particle_velocity", "box_position", "box_velocity", "box_angular_velocity")


def of_chunk(arrays: Arrays, file: str, rng: np.random.Generator) -> Iterator[Damage]:
    """Yield what may be wrong with the frames of a chunk."""
    for name, array in arrays.items():

        def damage(what: str, changed: np.ndarray, named: str | None, name: str = name) -> Damage:
            return Damage(f"{what}: {name}", file, arrays | {name: changed}, named)

        yield Damage(
            f"missing: {name}", file, {key: arrays[key] for key in arrays if key != name}, f"{name!r} is missing"
        )
        yield damage("float32", array.astype(np.float32), f"{name} holds float32")
        yield damage("whole numbers", array.astype(np.int64), f"{name} holds int64")
        yield damage("a frame less", array[:-1], f"{name} has shape")
        yield damage("a row less", array[:, :-1] if array.ndim > 1 else array[:0], f"{name} has shape")
        yield damage("a number less", array[..., :-1], f"{name} has shape")
        for value in (*REAL.taken, *REAL.refused):
            if name in PLACES or value in REAL.refused:
                place = tuple(int(rng.integers(n)) for n in array.shape)
                named = None if value in REAL.taken else f"{name}[{', '.join(map(str, place))}]"
                yield damage(f"{value}", put(array, place, value), named)
    yield Damage("an entry more", file, arrays | {"colour": np.zeros(3)}, "'colour' is no entry")
    yield Damage(
        "another time", file, arrays | {"time": arrays["time"] + 1e-9}, "time is not what trajectory.json says"
    )
    turns = arrays["box_orientation"]
    for frame, box in np.ndindex(turns.shape[:2]):
        for by in (0.99e-6, -0.99e-6, 1.01e-6, -1.01e-6, -1.0):
            changed = put(turns, (frame, box), (1.0 + by) * turns[frame, box] / np.linalg.norm(turns[frame, box]))
            named = None if abs(by) < 1e-6 else f"box_orientation[{frame}, {box}] has length"
            yield Damage("a turn of another length", file, arrays | {"box_orientation": changed}, named)


def of_bodies(arrays: Arrays, rng: np.random.Generator) -> Iterator[Damage]:
    """Yield what may be wrong with the bodies, of which the manifest has a hash besides."""
    file = "bodies.npz"
    for name, array in arrays.items():
        yield Damage(
            f"missing: {name}", file, {key: arrays[key] for key in arrays if key != name}, f"{name!r} is missing"
        )
        half = np.float32 if array.dtype.kind == "f" else np.int32
        yield Damage(f"of another kind: {name}", file, arrays | {name: array.astype(half)}, f"{name} holds")
        yield Damage(f"an axis more: {name}", file, arrays | {name: array[None]}, f"{name} has shape")
        place = tuple(int(rng.integers(n)) for n in array.shape)
        yield Damage(f"below all limits: {name}", file, arrays | {name: put(array, place, -1)}, name)
    other = put(arrays["box_size"], (1, 1), np.nextafter(0.4, 1.0))
    yield Damage("other bodies", file, arrays | {"box_size": other}, "of other bodies than trajectory.json says")
    yield Damage("an entry more", file, arrays | {"colour": np.zeros(3)}, "'colour' is no entry")


def of_manifest(raw: bytes, rng: np.random.Generator) -> Iterator[Damage]:
    """Yield what may be wrong with a manifest, or not."""
    found, file = json.loads(raw), "trajectory.json"
    labels, chunks = found["labels"], found["chunks"]
    number = int(rng.integers(len(chunks)))
    each = chunks[number]
    times = each["times"]

    def told(what: str, named: str | None, **changes: Any) -> Damage:
        return Damage(what, file, json.dumps(found | changes).encode(), named)

    def chunk(what: str, named: str, **changes: Any) -> Damage:
        return told(what, f"chunks[{number}]{named}", chunks=put_in(chunks, number, each | changes))

    for name in ("format", "bodies", "velocities", "chunks"):
        lacking = {key: value for key, value in found.items() if key != name}
        yield Damage(f"missing: {name}", file, json.dumps(lacking).encode(), f"{name}")
    wrong_ones: dict[str, tuple[Any, ...]] = {
        "format": (0, 2, "1", None),
        "bodies": (3, None, [], {"sha256": 3}, {"sha256": found["bodies"]["sha256"][1:]}),
        "velocities": (1, 0, "yes", None, []),
        "chunks": (3, None, {}, "none"),
    }
    for name, others in wrong_ones.items():
        for other in others:
            yield told(f"{name}: {other!r}", f"{name}", **{name: other})
    yield told("no labels", None, labels=None)
    odd: Any
    for odd in (
        3,
        [[], [], []],
        labels | {"more": []},
        {key: labels[key] for key in ("soft", "box")},
        labels | {"held": (0, 1)},
        labels | {"held": "no"},
        labels | {"box": ["a", "a"]},
        labels | {"soft": [1, ""]},
        labels | {"soft": [" a", ""]},
        labels | {"box": ["a"]},
        labels | {"held": [False] * 3},
    ):
        yield told(f"labels: {odd!r}", "labels", labels=odd)
    yield told("other labels", None, labels={"soft": ["c", ""], "box": ["", "d"], "held": [True, False]})
    for name in ("file", "times", "frames"):
        lacking = {key: value for key, value in each.items() if key != name}
        yield told(f"a chunk without {name}", f"chunks[{number}].{name}", chunks=put_in(chunks, number, lacking))
    yield told("a chunk that is none", f"chunks[{number}] must be", chunks=put_in(chunks, number, 3))
    for wrong in ("../1.npz", "1.npz", "0000000000000000000.npz", "000000.npy", 0):
        yield chunk(f"file: {wrong!r}", ".file", file=wrong)
    for odd in (3, [0, 0.25], [0.0, NAN], [INF, INF], [-LEAST, 0.0], [], [True, False], ["0.0", "0.25"]):
        yield chunk(f"times: {odd!r}", ".times", times=odd, frames=len(odd) if isinstance(odd, list) else 2)
    yield chunk("a frame more", ".frames", frames=len(times) + 1)
    yield told("one file twice", "chunks must have a file each", chunks=[chunks[0], chunks[0]])
    yield told("times that go back", "times of chunks must not go back", chunks=chunks[::-1])
    yield told("the first chunk only", None, chunks=chunks[:1])
    yield told("no chunks", None, chunks=[])
    for what, text in {"no JSON": b"{", "no UTF-8": b'{"a": "\xff"}', "a list": b"[]"}.items():
        yield Damage(what, file, text, "trajectory.json")
    most = 2**26
    yield Damage("a byte too many", file, raw + b" " * (most + 1 - len(raw)), f"more than {most} bytes")


def put_in(rows: list[Any], number: int, value: Any) -> list[Any]:
    """Return a list with something else at a place."""
    return [value if k == number else row for k, row in enumerate(rows)]


def right_about_file(damage: Damage, folder: Path) -> bool:
    """Tell whether a trajectory with one file that was altered can be read, or is refused by the name that it must."""
    path = folder / damage.file
    before = path.read_bytes()
    if isinstance(damage.raw, bytes):
        path.write_bytes(damage.raw)
    else:
        np.savez(path, **damage.raw)  # type: ignore[arg-type]
    try:
        frames = [frame._asdict() for frame in Trajectory.open(folder)]
    except TrajectoryError as error:
        return damage.named is not None and damage.named in str(error) and damage.file in str(error)
    except Exception:
        return False
    finally:
        path.write_bytes(before)
    return damage.named is None and (not frames or set(frames[0]) == set(softbody.Frame._fields))


@check(
    section="beyond the paper",
    piece="softbody.Trajectory.open",
    reference="what is said of each entry where it is declared, tried one by one",
    kind="specification",
    faults=(
        Fault("entries that nobody asked for", entries.checked_frames, "entries.none_left() → "),
        Fault("turns of any length in a chunk", entries.checked_frames, "good.all() → True"),
        Fault("labels of anything besides", manifest._labels, "set(found) == set(Labels._fields) → True"),
        Fault("velocities, perhaps", manifest._manifest, "isinstance(velocities, bool) → True"),
        Fault("chunks of other times", entries.read_chunk, "np.array_equal(a_, b_) → True"),
        Fault("a manifest of any size", manifest.read_manifest, "len(raw) > MOST_BYTES → False"),
    ),
)
def entries_of_trajectories(run: Run) -> Comparison:
    """Each entry of a trajectory that is altered, in its chunks, its bodies and its manifest, to and beyond the limits
    of what it may be, is read as it is, or refused by its name and the file's: numbers, kinds, shapes, times, turns,
    labels, names of files, and sizes."""
    rng = run.fresh_rng()
    right, kinds = [], []
    for _ in range(run.count(1, 3, 20)):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "kept"
            flight(rng, folder)
            chunk = f"00000{rng.integers(2)}.npz"
            damages = [
                *of_chunk(dict(np.load(folder / chunk)), chunk, rng),
                *of_bodies(dict(np.load(folder / "bodies.npz")), rng),
                *of_manifest((folder / "trajectory.json").read_bytes(), rng),
            ]
            for damage in damages:
                right.append(right_about_file(damage, folder))
                kinds.append(f"{damage.file}, {damage.what}"[:80])
    return Comparison(np.array(right), np.ones(len(right), bool), groups=kinds)
