"""Claims that entries of saved worlds and trajectories are believed only where possible, or refused by name."""

from __future__ import annotations

import json
import re
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import softbody
from softbody import SnapshotError, Trajectory, TrajectoryError, TrajectoryWriter, World
from softbody.storage import snapshot, snapshot_entries
from softbody.trajectory import bodies, entries, manifest
from validation.answers import Answers
from validation.cases import random_orientations
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

Arrays = dict[str, np.ndarray]
Place = tuple[int, ...]

LEAST, NAN, INF, LARGEST = 5e-324, float("nan"), float("inf"), 1e50
TOO_LARGE = 1.01 * LARGEST
ABOVE_ONE = float(np.nextafter(1.0, 2.0))
OFF = (0.99e-6, -0.99e-6, 1.01e-6, -1.01e-6)  # relative, of lengths of quaternions: up to 1e-6 may be


class Limits(NamedTuple):
    """Which numbers an entry may hold, up to its limits, and which not, from just beyond them."""

    taken: tuple[float, ...]
    refused: tuple[float, ...]


REAL = Limits((0.0, -LARGEST, LARGEST), (NAN, INF, -INF, TOO_LARGE, -TOO_LARGE))
HEIGHT = Limits((0.0, -LARGEST, LARGEST, -INF), (NAN, INF, TOO_LARGE, -TOO_LARGE))  # −∞ says that there is no ground
NOT_NEGATIVE = Limits((0.0, LEAST, LARGEST), (-LEAST, -1.0, NAN, INF, TOO_LARGE))
POSITIVE = Limits((1.0 / LARGEST, 1.0, LARGEST), (0.0, -1.0, 0.99 / LARGEST, NAN, INF, TOO_LARGE))
UP_TO_ONE = Limits((0.0, 1.0), (-LEAST, ABOVE_ONE, NAN, INF))
NO_LIMIT = Limits((0.0, 1.0, INF), (-LEAST, NAN, -INF))


TAKEN = "model.soft_boxes_volume"


TEARS = Limits(  # below −1 a spring waits
    (0.0, ABOVE_ONE, -ABOVE_ONE, LARGEST, -LARGEST), (LEAST, 0.5, 1.0, -1.0, -LEAST, NAN, INF, -INF, TOO_LARGE)
)


def only(limits: Limits) -> Limits:
    """Return limits of which only what is refused is tried: what is taken depends on other entries."""
    return Limits((), limits.refused)


# What softbody/model/arrays.py and World's arguments say of each entry that holds real numbers.
_BY_LIMITS: dict[Limits, str] = {
    REAL: "controls.gravity controls.particle_force controls.box_force controls.box_torque state.particle_position"
    " state.particle_velocity state.box_position state.box_velocity state.box_angular_velocity joints.joint_place"
    " cache.point cache.impulse model.soft_self_contact"
    " model.liquid_surface_height model.liquid_velocity",
    HEIGHT: "model.ground_height",
    TEARS: "model.edge_tear_at",
    NOT_NEGATIVE: "model.edge_stiffness model.soft_damping model.soft_drag"
    " model.soft_sound_speed model.soft_liquid_drag model.soft_leak"
    " model.soft_friction model.box_friction model.ground_friction model.liquid_density model.liquid_drag"
    " controls.soft_gas state.box_time_left joints.joint_stiffness joints.joint_damping joints.joint_rest_length"
    " rest.time time",
    POSITIVE: "model.edge_rest_length model.soft_thickness model.soft_edge_length model.soft_mesh_volume",
    UP_TO_ONE: "model.soft_deflated_below model.soft_restitution model.box_restitution model.ground_restitution",
    NO_LIMIT: "settings.speed_ceiling settings.angular_speed_ceiling settings.angular_speed_floor settings.sleep_speed"
    " settings.sleep_after",
    only(
        NOT_NEGATIVE
    ): "model.particle_inverse_mass model.soft_liquid_density model.box_inverse_mass model.box_inverse_inertia",
    only(POSITIVE): "model.particle_free_inverse_mass model.box_size",
    only(UP_TO_ONE): "joints.joint_weights",
    only(REAL): "state.box_orientation joints.weight",
}
NUMBERS = {name: limits for limits, names in _BY_LIMITS.items() for name in names.split()}
# The same of those that hold one whole number. (Others are tried as what they say together.)
COUNTS = Limits((1, 10_000_000), (0, -1, 10_000_001))
WHOLE: dict[str, Limits] = {
    "format": Limits((), (-1, 0, 1, 14, 2**62)),
    "model.soft_count": Limits((), (-1, 1, 3)),
    "model.box_count": Limits((), (-1, 3, 5)),
    "settings.integrator": Limits((0, 1, 2), (-1, 3, 2**62)),
    "settings.substeps": COUNTS,
    "settings.iterations": COUNTS,
    "steps": Limits((0, 2**62), (-1, 2**62 + 1)),
}
# By the letter of a kind of numbers, or of words: others.
OTHER_KINDS = {"f": ("i8", "U1", "?", "c16"), "i": ("f8", "U1", "?", "c16"), "b": ("i8", "U1", "f8"), "U": ("i8", "f8")}


TELL_ROWS = "joints.joint_box", "joints.suspension_box"  # by which others are counted


class Trial(NamedTuple):
    """Something saved of which something is altered, and what must come of it."""

    what: str
    named: str | None  # what the refusal must name; None: it must be taken
    changes: Mapping[str, Any] | bytes  # entries that are others; or what the file holds
    gone: tuple[str, ...] = ()  # entries that are left out

    def of(self, saved: Mapping[str, Any]) -> dict[str, Any]:
        """Return all entries, altered."""
        assert not isinstance(self.changes, bytes)
        return {name: value for name, value in {**saved, **self.changes}.items() if name not in self.gone}


def altered(what: str, name: str, array: Any, named: str | None) -> Trial:
    """Return the trial of one entry that is another."""
    return Trial(f"{what}: {name}", named, {name: array})


def missing(name: str) -> Trial:
    """Return the trial of an array that is left out."""
    return Trial(f"missing: {name}", f"{name!r} is missing", {}, (name,))


def put(array: np.ndarray, place: Any, value: Any) -> np.ndarray:
    """Return a copy with something else at a place."""
    changed = array.copy()
    changed[place] = value
    return changed


def put_in(rows: list[Any], number: int, value: Any) -> list[Any]:
    """Return a list with something else at a place."""
    return [*rows[:number], value, *rows[number + 1 :]]


def at_limits(
    array: np.ndarray, limits: Limits, rng: np.random.Generator
) -> Iterator[tuple[float, Place, np.ndarray, bool]]:
    """Yield numbers at and beyond limits, a random place, the array with the number there, and whether it is taken."""
    for value in (*limits.taken, *limits.refused):
        place = tuple(int(rng.integers(n)) for n in array.shape)
        yield value, place, put(array, place, value), value in limits.taken


def at(place: Place) -> str:
    """Return a place in an array as messages have it."""
    return f"[{', '.join(map(str, place))}]"


def of_turns(name: str, turns: np.ndarray, off: Iterable[float], said: str = "") -> Iterator[Trial]:
    """Yield trials of quaternions whose lengths are off by so much, relatively."""
    for place in np.ndindex(turns.shape[:-1]):
        for by in off:
            turned = put(turns, place, (1.0 + by) * turns[place] / np.linalg.norm(turns[place]))
            named = None if abs(by) < 1e-6 else f"{name}{at(place)}{said}"
            yield Trial("a turn of another length", named, {name: turned})


def saved_world(rng: np.random.Generator) -> Arrays:
    """Return what is saved of two soft bodies, boxes that stand on each other, a light and a static one, and joints.

    Points hang in both bodies. Some of all have names, and the solver remembers contacts.
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
    hung = world.suspend(solid.centre + 0.1 * rng.uniform(-1.0, 1.0, (3, 3)), solid, name="marbles")
    world.suspend(other.centre, other)
    world.add_joint((hung, 1), (2.0, 0.0, 3.0), 1e-3)
    return world.snapshot()


def of_entry(name: str, array: np.ndarray, rng: np.random.Generator) -> Iterator[Trial]:
    """Yield trials of an entry by itself: gone, of another kind or shape, and with numbers at and beyond limits."""
    yield missing(name)
    yield altered("no array", name, None, name)
    yield altered("an axis more", name, array[None], name)
    yield altered("of the other byte order", name, array.astype(array.dtype.newbyteorder()), None)
    for kind in OTHER_KINDS[array.dtype.kind]:
        zeros = np.zeros(array.shape, np.dtype(kind))
        yield altered(f"{zeros.dtype}", name, zeros, f"{name} holds {zeros.dtype}")
    if array.ndim:
        yield altered("a row less", name, array[:-1], "joints." if name in TELL_ROWS else name)
        yield altered("Fortran's order", name, np.asfortranarray(array), None)
        if array.dtype.kind in "fi":
            half = array.astype(np.float32 if array.dtype.kind == "f" else np.int32)
            yield altered(f"{half.dtype}", name, half, f"{name} holds {half.dtype}")
    if name in NUMBERS:
        for value, _, changed, is_taken in at_limits(array, NUMBERS[name], rng):
            yield altered(f"{value}", name, changed, None if is_taken else name)
    if name in WHOLE:
        of_many = "model." if name.endswith("_count") else name
        for number, _, changed, is_taken in at_limits(array, WHOLE[name], rng):
            yield altered(f"{number}", name, changed, None if is_taken else of_many)


def together(saved: Arrays, rng: np.random.Generator) -> Iterator[Trial]:
    """Yield trials of what entries say together: masses, turns, joints, surfaces, contacts and names."""
    yield Trial("an entry more", "'model.colour' is no entry", {"model.colour": np.zeros(3)})
    yield Trial("precision: single", None, {"precision": np.array("single")})
    yield Trial("precision: half", "precision is 'half'", {"precision": np.array("half")})
    yield from of_masses(saved, rng)
    yield from of_turns("state.box_orientation", saved["state.box_orientation"], (*OFF, 1.0, -1.0))
    yield from of_joints(saved)
    yield from of_suspensions(saved)
    yield from of_surfaces(saved, rng)
    yield from of_contacts(saved)
    for value, named in ((1, None), (0, None), (2, "rest.asleep[1] is 2"), (-1, "rest.asleep[1] is -1")):
        yield Trial("asleep", named, {"rest.asleep": put(saved["rest.asleep"], 1, value)})
    yield from of_names(saved)


def of_masses(saved: Arrays, rng: np.random.Generator) -> Iterator[Trial]:
    """Yield trials of masses: of each body something is free, and a box turns as one of its size and mass does."""
    name = "model.particle_inverse_mass"
    inverse, free = saved[name], saved["model.particle_free_inverse_mass"]
    starts = saved["model.soft_particle_start"]
    for body in range(len(starts) - 1):
        rows = np.arange(starts[body], starts[body + 1])
        held, one = put(inverse, rows, 0.0), int(rng.choice(rows))
        yield Trial("one particle is free", None, {name: put(held, one, free[one])})
        yield Trial("no particle is free", f"{name} of soft body {body}", {name: held})
        for off in (np.nextafter(free[one], 0.0), np.nextafter(free[one], np.inf), 2.0 * free[one]):
            yield Trial("a mass that is off", f"{name}[{one}]", {name: put(held, one, off)})
    name = "model.box_inverse_inertia"
    inverse = saved[name]
    for box, axis in np.ndindex(inverse.shape):
        exact, culprit = inverse[box, axis], f"{name}[{box}]"
        near = [(exact * (1.0 + by), None if abs(by) < 1e-9 else culprit) for by in (0.9e-9, -0.9e-9, 1.1e-9, -1.1e-9)]
        for number, named in near if exact else [(1e-30, culprit)]:
            yield Trial("an inertia that is off", named, {name: put(inverse, (box, axis), number)})


def of_joints(saved: Arrays) -> Iterator[Trial]:
    """Yield trials of what each end of each joint may be on: a box, three particles of one body, or nothing."""
    starts, boxes = saved["model.soft_particle_start"], len(saved["model.box_size"])
    n, last = int(starts[-1]), boxes - 1
    nothing, three, across = (-1, -1, -1), (0, 1, 2), (starts[1] - 1, starts[1] - 1, starts[1])
    none, whole = (0.0, 0.0, 0.0), (0.2, 0.3, 0.5)
    outside, hung = (-1, -1), len(saved["joints.suspension_box"])
    right = [  # box, particles, weights, and a point that hangs
        *((box, nothing, none, outside) for box in (-1, 0, last)),
        *((-1, particles, whole, outside) for particles in (three, (n - 3, n - 2, n - 1))),
        *((-1, three, weights, outside) for weights in ((1.0, 0.0, 0.0), (0.2, 0.3, 0.5 + 0.9e-9))),
        *((-1, nothing, none, point) for point in ((0, 0), (0, 2), (1, 0))),
    ]
    wrong_particles = ((0, -1, 2), (-1, -1, 2), (n - 2, n - 1, n), (n, n, n), across, across[::-1])
    wrong = [
        *((-1, three, weights, outside) for weights in ((0.2, 0.3, 0.5 + 1.1e-9), (0.2, 0.3, 0.5 - 1.1e-9), none)),
        *((box, nothing, whole, outside) for box in (-1, 0)),
        *((box, three, whole, outside) for box in (0, boxes)),
        *((-1, particles, whole, outside) for particles in wrong_particles),
        (boxes, nothing, none, outside),
        (-1, (0, -1, 2), none, outside),
        *((-1, nothing, none, point) for point in ((0, 3), (1, 1), (hung, 0), (0, -1), (-1, 0))),
        (0, nothing, none, (0, 0)),
        (-1, three, whole, (0, 0)),
    ]
    names = [f"joints.joint_{field}" for field in ("box", "particles", "weights", "inside")]
    for joint, end in np.ndindex(saved["joints.joint_box"].shape):
        places = (joint, end), *[(joint, slice(3 * end, 3 * end + 3))] * 2, (joint, slice(2 * end, 2 * end + 2))
        for each in (*right, *wrong):
            changes = {name: put(saved[name], place, value) for name, place, value in zip(names, places, each)}
            named = None if each in right else f"of end {end} of joint {joint}"
            if each in right and all((changes[name][joint] < 0).all() for name in (*names[:2], names[3])):
                named = f"both ends of joint {joint}"
            yield Trial("an end of a joint", named, changes)
        for name, place in ((names[0], (joint, end)), (names[1], (joint, 3 * end))):
            yield Trial("a number below −1", f"{name}[", {name: put(saved[name], place, -2)})
    all_of_them = tuple(name for name in saved if name.startswith("joints."))
    no_names = {f"names.{kind}": np.array([], "U1") for kind in ("joint", "suspension")}
    yield Trial("no joints", None, no_names, all_of_them)


def of_suspensions(saved: Arrays) -> Iterator[Trial]:
    """Yield trials of points that hang: in which soft body, by what weights, and for which box."""
    name, starts = "joints.suspension_particles", saved["model.soft_particle_start"].tolist()
    rows = saved[name]
    for one, other in ((starts[0], starts[2]), (starts[0] + 1, starts[1]), (starts[2], starts[2]), (starts[1], 0)):
        yield Trial("the particles of no body", f"{name}[1] is", {name: put(rows, 1, (one, other))})
    name, begins = "joints.suspension_start", saved["joints.suspension_start"]
    for wrong in (put(begins, 0, 1), put(begins, 1, 0), put(begins, 1, begins[2])):
        yield Trial("where suspensions begin", f"{name} is", {name: wrong})
    yield Trial("no whole number of points", f"{name} leaves", {name: put(begins, 1, begins[1] + 1)})
    name, weights = "joints.weight", saved["joints.weight"]
    least = np.abs(weights[: starts[1]]).sum()
    for by, named in ((0.9e-9, None), (1.1e-9, f"{name} of"), (-1.1e-9, f"{name} of"), (1.0, f"{name} of")):
        yield Trial("a sum that is off", named, {name: put(weights, 0, weights[0] + by * least)})
    of_box, hosts, taken = (saved[f"{name}"] for name in ("joints.suspension_box", "model.box_host", TAKEN))
    volume = saved["model.box_size"][2].prod()
    inside = {"model.box_host": put(hosts, 2, 1), TAKEN: put(taken, 1, volume)}
    hangs = {"joints.suspension_box": put(of_box, 1, 2)}
    yield Trial("a box that is inside", None, inside)
    yield Trial("a box that hangs", None, inside | hangs)
    yield Trial("a box that hangs outside", "model.box_host is", hangs)
    yield Trial(
        "another body", "model.box_host is", hangs | {"model.box_host": put(hosts, 2, 0), TAKEN: put(taken, 0, volume)}
    )
    for host in (-2, 2, 9):
        yield Trial("in no body", "model.box_host", {"model.box_host": put(hosts, 2, host)})
    for by, named in ((0.9e-9, None), (1.1e-9, f"{TAKEN} is"), (-1.1e-9, f"{TAKEN} is"), (-1.0, f"{TAKEN} is")):
        yield Trial("a volume that is off", named, inside | {TAKEN: put(taken, 1, (1.0 + by) * volume)})
    large = {"model.box_host": np.ones_like(hosts)}
    boxes = np.array([0.0, saved["model.box_size"].prod(axis=1).sum()])
    yield Trial("no room", "model.box_host leaves soft body 1", large | {TAKEN: boxes})
    for wrong in (np.full(2, 2), put(of_box, 0, len(hosts)), put(of_box, 0, -2)):
        yield Trial("a box twice, or none", "joints.suspension_box", {"joints.suspension_box": wrong})


def of_surfaces(saved: Arrays, rng: np.random.Generator) -> Iterator[Trial]:
    """Yield trials of surfaces that are none, or none with these edges."""
    for kind in ("particle", "edge", "triangle"):
        name = f"model.soft_{kind}_start"
        for begin in ([1, *saved[name][1:]], [0, 0, saved[name][2]], [0, saved[name][2], saved[name][2]]):
            yield Trial("where bodies begin", f"{name} is", {name: np.array(begin)})
        yield Trial("where bodies begin", f"{name}[1]", {name: put(saved[name], 1, -1)})
    of_triangles, of_edges = "model.triangle_particles", "model.edge_particles"
    triangles, edges = saved[of_triangles], saved[of_edges]
    ends, last = saved["model.soft_triangle_start"], saved["model.soft_particle_start"]
    for body in range(len(ends) - 1):
        row, first = int(rng.integers(ends[body], ends[body + 1])), int(last[body])
        for wrong in (
            triangles[row, ::-1],
            np.repeat(triangles[row, 0], 3),
            put(triangles[row], 1, first - 1),
            put(triangles[row], 2, last[body + 1]),
            np.roll(triangles, 1 if row else -1, axis=0)[row],
        ):
            yield Trial("no surface", f"{of_triangles} of soft body {body}", {of_triangles: put(triangles, row, wrong)})
        turned = put(triangles, row, np.roll(triangles[row], 1))
        yield Trial("a triangle that begins elsewhere", None, {of_triangles: turned})
        rows = slice(*saved["model.soft_edge_start"][body : body + 2])
        for own in (np.roll(edges[rows], 1, axis=0), edges[rows][:, ::-1], put(edges[rows], 1, edges[rows][0])):
            yield Trial("other edges", f"{of_edges} of soft body {body}", {of_edges: put(edges, rows, own)})


def of_contacts(saved: Arrays) -> Iterator[Trial]:
    """Yield trials of what solvers remember: pairs (a, b) of boxes, or a box and the ground, −1, in order; then others.

    Those are of soft bodies, −1, with each other, or with a box as b.
    """
    boxes = len(saved["model.box_size"])
    right: list[list[tuple[int, int]]] = [[], [(0, -1)], [(0, -1), (1, 0)], [(1, 0), (1, 0)]]
    right.append([(1, -1), (1, 0), (2, -1), (2, 0), (2, 1), (boxes - 1, -1)])
    wrong = [[(1, 0), (0, -1)], [(1, 0), (1, -1)], [(2, 1), (2, 0), (3, 0)], [(0, -1), (2, 1), (1, 0)], [(0, 0)]]
    wrong += [[(0, 1)], [(boxes, 0)], [(-1, -1)], [(0, -1), (boxes, -1)]]
    soft_right: list[list[tuple[int, int]]] = [[(-1, -1), (-1, boxes - 1), (-1, 0)], [(-1, -1)] * 3]
    soft_wrong = [[(-1, boxes)], [(0, -1), (-1, -1)], [(-1, 0), (1, 0)]]
    trials = [(pairs, len(pairs), pairs in right) for pairs in (*right, *wrong)]
    trials += [(pairs, 0, pairs in soft_right) for pairs in (*soft_right, *soft_wrong)]
    trials.append(([(0, -1), (1, 0), *soft_right[0]], 2, True))
    for pairs, of_boxes, is_right in trials:
        n = len(pairs)
        changes = {
            "cache.number": np.array([n]),
            "cache.soft": np.array([n - of_boxes]),
            "cache.box": np.array(pairs, np.int64).reshape(n, 2),
            "cache.feature": np.arange(n) - 2**62,
            "cache.point": np.zeros((n, 3)),
            "cache.impulse": np.ones((n, 3)),
        }
        yield Trial("contacts of the last step", None if is_right else "cache.box is no list", changes)
    yield Trial("below the ground", "cache.box[0, 1] is -2", {"cache.box": put(saved["cache.box"], (0, 1), -2)})
    yield Trial("fewer than no contacts", "cache.number[0] is -1", {"cache.number": np.array([-1])})
    n = len(saved["cache.box"])
    yield Trial("more of soft bodies than there are", "cache.soft[0] is", {"cache.soft": np.array([n + 1])})


def of_names(saved: Arrays) -> Iterator[Trial]:
    """Yield trials of names: 1 to 100 printable characters, no space first or last, and each one's own."""
    right, wrong = ("a", "two words", "ß漢", "x" * 100), ("x" * 101, " a", "a ", "a\n", "\u202e")
    for kind in ("soft", "box", "joint", "suspension"):
        name = f"names.{kind}"
        count = len(saved[name])
        for word in (*right, *wrong):
            named = None if word in right else f"{name}[{count - 1}]"
            yield Trial("a name", named, {name: np.array([""] * (count - 1) + [word])})
        if kind == "soft":
            yield Trial("a name of two", "names.soft[1]", {"names.soft": np.array(["b", "b"])})
        else:
            twice = {name: np.array(["solid", *[""] * (count - 1)]), "names.soft": np.array(["", "solid"])}
            yield Trial("a name of two", f"{name}[0]", twice)
        for order in "<>":
            no_letter = np.array([0x110000] * count, f"{order}u4").view(f"{order}U1")
            yield Trial("no letter", f"{name} holds 0x110000", {name: no_letter})
            yield Trial("no letter", "precision holds 0x110000", {"precision": no_letter[0:1].reshape(())})


def right_about(trial: Trial, saved: Arrays, world: World) -> bool:
    """Tell whether a world takes a trial, with every entry as it is there, or refuses it by the name that it must."""
    arrays = trial.of(saved)
    try:
        world.restore(arrays)
    except SnapshotError as error:
        return trial.named is not None and trial.named in str(error)
    except Exception:
        return False
    told = world.snapshot()
    kept = [name for name in arrays if name != "format" and not name.startswith("rings.")]
    return trial.named is None and all(np.array_equal(told[name], arrays[name]) for name in kept)


@check(
    section="9",
    piece="softbody.World.restore, softbody.World.load",
    reference="what is said of each entry where it is declared, tried one by one",
    kind="specification",
    faults=(
        Fault("joints on boxes that are not there", snapshot._joints, "box < model.box_count → box <= model.box_count"),
        Fault("joints that hold nothing", snapshot._joints, "holds.all() → True"),
        Fault("weights of any sum", snapshot._joints, "np.abs(weights.sum(axis=2) - on_soft) <= SAME → True"),
        Fault("hosts as they come", snapshot._check_suspensions, "np.array_equal(m_, h_) → True"),
        Fault("points that are not there", snapshot._joints, "np.append(points, 0)[n_] → 10"),
        Fault("inertia as it comes", snapshot._check_masses, "good.all() → True", nth=0),
        Fault("masses as they come", snapshot._with_masses, "good.all() → True"),
        Fault("limits that are left out", snapshot_entries._check, "array <= rows.most → True"),
        Fault("settings as they come", snapshot._settings, "check_settings(s_, n_) → "),
        Fault("contacts in any order", snapshot._impulses, "np.diff(b) >= 0 → True"),
        Fault("letters that are none", snapshot_entries.Entries.words, "_check_letters(n_, a_) → "),
    ),
)
def entries_of_saved_worlds(run: Run) -> Comparison:
    """Saved worlds take an altered entry, or refuse it by its name.

    Each entry is altered, to and beyond the limits of what it may be, by itself and with those that it must go with:
    numbers, kinds, shapes, masses, turns, ends of joints, what hangs, surfaces, contacts, settings and names. What is
    taken is taken as it is.
    """
    rng, answers, world = run.fresh_rng(), Answers(), World()
    for _ in range(run.count(1, 5, 50)):
        saved = saved_world(rng)
        trials = [trial for name, array in saved.items() for trial in of_entry(name, array, rng)]
        for trial in (*trials, *together(saved, rng)):
            answers.add(right_about(trial, saved, world), True, kind=trial.what.rpartition(": ")[2])
    return answers.comparison()


BOUND = re.compile(r"(>|≥|≤) (\S+?)(?=,| |$)")
SIZES = re.compile(r"(?:up to|between (\S+) and) (\S+)$")


def fits(value: float, said: str) -> bool:
    """Tell whether a number is what a message says that it must be."""
    bounds = {">": np.greater, "≥": np.greater_equal, "≤": np.less_equal}
    if value == 0.0 and said.startswith("0, or "):
        return True
    value = abs(value) if " of a size " in said else value
    said = said.removeprefix("0, or ")
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
        Fault("no size that it must be beyond", snapshot_entries._limits, "rows.beyond > -np.inf → False"),
        Fault("above for at least", snapshot_entries._limits, "rows.least > -np.inf → rows.above > -np.inf"),
    ),
)
def refusals_say_what_is_taken(run: Run) -> Comparison:
    """A refusal of a number says which numbers are taken.

    That is what it says that the number of a saved world must be. Whatever numbers the entry takes are of that kind
    and within those limits, and whatever it refuses is not.
    """
    rng, answers, world = run.fresh_rng(), Answers(), World()
    saved = saved_world(rng)
    for name, whole in saved.items():
        if name not in NUMBERS or not whole.size or name.startswith(("settings.", "cache.")):
            continue
        taken = [value for value in NUMBERS[name].taken if np.isfinite(value)]
        for value, _, array, _ in at_limits(whole, only(NUMBERS[name]), rng):
            try:
                world.restore(saved | {name: array})
                said = ""
            except SnapshotError as error:
                said = str(error).partition("; it must be ")[2]
            is_right = bool(said) and not fits(value, said) and all(fits(other, said) for other in taken)
            answers.add(is_right, True, kind=name)
    return answers.comparison()


def keep_flight(rng: np.random.Generator, folder: Path, is_changing: bool = False) -> None:
    """Keep two chunks of two frames of a world of two soft bodies and two boxes; of one more, if bodies change."""
    world = World()
    for k, mesh in enumerate((softbody.tetrahedron(0.4), softbody.octahedron(0.4))):
        world.add_soft_body(mesh, 1.0, 100.0, 10.0, (3.0 * k, 0.0, 0.0), rng.normal(size=3))
    for k, turn in enumerate(random_orientations(rng, 2)):
        world.add_box((0.5, 0.4, 0.3), 1.0, (0.0, 3.0 + 3.0 * k, 0.0), turn, rng.normal(size=3), name="ab"[k])
    with TrajectoryWriter(world, folder) as kept:
        for k in range(4):
            world.time = 0.25 * k
            if is_changing and k == 2:
                world.add_box((0.5, 0.4, 0.3), None, (0.0, 50.0, 0.0))
            kept.frame()
            if k % 2:
                kept.flush()


UNLIMITED = ("particle_position", "particle_velocity", "box_position", "box_velocity", "box_angular_velocity")
ENTRY_MORE = Trial("an entry more", "'colour' is no entry", {"colour": np.zeros(3)})


def of_chunk(arrays: Arrays, rng: np.random.Generator) -> Iterator[Trial]:
    """Yield trials of the frames of a chunk."""
    for name, array in arrays.items():
        yield missing(name)
        yield altered("float32", name, array.astype(np.float32), f"{name} holds float32")
        yield altered("whole numbers", name, array.astype(np.int64), f"{name} holds int64")
        yield altered("a frame less", name, array[:-1], f"{name} has shape")
        yield altered("a row less", name, array[:, :-1] if array.ndim > 1 else array[:0], f"{name} has shape")
        yield altered("a number less", name, array[..., :-1], f"{name} has shape")
        for value, place, changed, is_taken in at_limits(array, REAL if name in UNLIMITED else only(REAL), rng):
            yield altered(f"{value}", name, changed, None if is_taken else f"{name}{at(place)}")
    yield ENTRY_MORE
    yield Trial("another time", "time is not what trajectory.json says", {"time": arrays["time"] + 1e-9})
    yield from of_turns("box_orientation", arrays["box_orientation"], (*OFF, -1.0), " has length")


def of_bodies(arrays: Arrays, rng: np.random.Generator) -> Iterator[Trial]:
    """Yield trials of the bodies, of which the manifest has a hash besides."""
    for name, array in arrays.items():
        yield missing(name)
        half = np.float32 if array.dtype.kind == "f" else np.int32
        yield altered("of another kind", name, array.astype(half), f"{name} holds")
        yield altered("an axis more", name, array[None], f"{name} has shape")
        place = tuple(int(rng.integers(n)) for n in array.shape)
        yield altered("below all limits", name, put(array, place, -1), name)
    other = put(arrays["box_size"], (1, 1), np.nextafter(0.4, 1.0))
    yield Trial("other bodies", "of other bodies than trajectory.json says", {"box_size": other})
    yield ENTRY_MORE


def of_manifest(found: dict[str, Any], rng: np.random.Generator) -> Iterator[Trial]:
    """Yield trials of a manifest."""
    labels, chunks = found["labels"], found["chunks"]
    number = int(rng.integers(len(chunks)))
    each, name_of_it = chunks[number], f"chunks[{number}]"

    def chunk(what: str, named: str, **changes: Any) -> Trial:
        return Trial(what, name_of_it + named, {"chunks": put_in(chunks, number, each | changes)})

    wrong_ones: dict[str, tuple[Any, ...]] = {
        "format": (0, 3, "1", None),
        "bodies": (3, None, [], {"sha256": 3}, {"sha256": found["bodies"]["sha256"][1:]}),
        "velocities": (1, 0, "yes", None, []),
        "chunks": (3, None, {}, "none"),
    }
    for name in wrong_ones:
        yield Trial(f"missing: {name}", name, {}, (name,))
    for name, wrong in wrong_ones.items():
        for odd in wrong:
            yield Trial(f"{name}: {odd!r}", name, {name: odd})
    yield Trial("no labels", None, {"labels": None})
    wrong_labels: list[Any] = [3, [[], [], []], labels | {"more": []}, {key: labels[key] for key in ("soft", "box")}]
    wrong_labels += [labels | {"held": held} for held in ((0, 1), "no")]
    wrong_labels += [labels | {"box": ["a", "a"]}, labels | {"soft": [1, ""]}, labels | {"soft": [" a", ""]}]
    wrong_labels += [labels | {"box": ["a"]}, labels | {"held": [False] * 3}]
    for odd in wrong_labels:
        yield Trial(f"labels: {odd!r}", "labels", {"labels": odd})
    others = {"soft": ["c", ""], "box": ["", "d"], "held": [True, False]}
    yield Trial("other labels", None, {"labels": others})
    for name in ("file", "times", "frames"):
        lacking = {key: value for key, value in each.items() if key != name}
        changes = {"chunks": put_in(chunks, number, lacking)}
        yield Trial(f"a chunk without {name}", f"{name_of_it}.{name}", changes)
    yield Trial("a chunk that is none", f"{name_of_it} must be", {"chunks": put_in(chunks, number, 3)})
    for file in ("../1.npz", "1.npz", "0000000000000000000.npz", "000000.npy", 0):
        yield chunk(f"file: {file!r}", ".file", file=file)
    for odd in (3, [0, 0.25], [0.0, NAN], [INF, INF], [-LEAST, 0.0], [], [True, False], ["0.0", "0.25"]):
        yield chunk(f"times: {odd!r}", ".times", times=odd, frames=len(odd) if isinstance(odd, list) else 2)
    yield chunk("a frame more", ".frames", frames=len(each["times"]) + 1)
    yield Trial("one file twice", "chunks must have a file each", {"chunks": [chunks[0], chunks[0]]})
    yield Trial("times that go back", "times of chunks must not go back", {"chunks": chunks[::-1]})
    yield Trial("the first chunk only", None, {"chunks": chunks[:1]})
    yield Trial("no chunks", None, {"chunks": []})
    for what, text in {"no JSON": b"{", "no UTF-8": b'{"a": "\xff"}', "a list": b"[]"}.items():
        yield Trial(what, "trajectory.json", text)
    most = 2**26
    yield Trial("a byte too many", f"more than {most} bytes", json.dumps(found).encode().ljust(most + 1))


def of_segments(found: dict[str, Any], rng: np.random.Generator) -> Iterator[Trial]:
    """Yield trials of a manifest of two segments."""
    segments = found["segments"]
    number = int(rng.integers(2))
    each, name_of_it, other = segments[number], f"segments[{number}]", segments[1 - number]

    def segment(what: str, named: str | None, changes: Any) -> Trial:
        changed = each | changes if isinstance(changes, dict) else changes
        return Trial(what, named, {"segments": put_in(segments, number, changed)})

    yield Trial("missing: segments", "segments must be", {}, ("segments",))
    none_at_all: tuple[Any, ...] = (3, None, {}, [], "none")
    for odd in none_at_all:
        yield Trial(f"segments: {odd!r}", "segments must be", {"segments": odd})
    yield segment("a segment that is none", f"{name_of_it} must be", 3)
    bodies = each["bodies"]
    for file in ("bodies.npy", "../bodies.npz", "bodies-1.npz", "000001.npz", 0, None):
        yield segment(f"bodies: {file!r}", f"{name_of_it}.bodies.file", {"bodies": bodies | {"file": file}})
    for sha in (3, None, bodies["sha256"][1:]):
        yield segment(f"sha256: {sha!r}", f"{name_of_it}.bodies.sha256", {"bodies": bodies | {"sha256": sha}})
    sha = {"sha256": other["bodies"]["sha256"]}
    yield segment("bodies of another", "of other bodies than", {"bodies": bodies | sha})
    for odd in none_at_all[:3]:
        yield segment(f"chunks: {odd!r}", f"{name_of_it}.chunks must be", {"chunks": odd})
    yield segment("no frames", f"{name_of_it}.chunks must have", {"chunks": []})
    yield segment("a chunk that is none", f"{name_of_it}.chunks[0] must be", {"chunks": [3]})
    yield segment("chunks twice", "chunks must have a file each", {"chunks": [*each["chunks"], *other["chunks"]]})
    yield segment("bodies twice", "and bodies, too", {"bodies": other["bodies"]})
    yield segment("labels of another", "labels of other numbers", {"labels": other["labels"]})
    yield segment("labels that are none", f"{name_of_it}.labels must have", {"labels": 3})
    yield segment("no labels", None, {"labels": None})
    yield Trial("times that go back", "times of chunks must not go back", {"segments": segments[::-1]})
    yield Trial("the first segment only", None, {"segments": segments[:1]})
    yield Trial("as format 1", "bodies.sha256 must be", {"format": 1})


def right_about_file(trial: Trial, whole: dict[str, Any], path: Path) -> bool:
    """Tell whether a trajectory with one file that was altered can be read, or is refused by the name that it must."""
    before = path.read_bytes()
    if isinstance(trial.changes, bytes):
        path.write_bytes(trial.changes)
    elif path.suffix == ".json":
        path.write_text(json.dumps(trial.of(whole)))
    else:
        np.savez(path, **trial.of(whole))
    try:
        frames = [frame._asdict() for frame in Trajectory.open(path.parent)]
    except TrajectoryError as error:
        return trial.named is not None and trial.named in str(error) and path.name in str(error)
    except Exception:
        return False
    finally:
        path.write_bytes(before)
    return trial.named is None and (not frames or set(frames[0]) == set(softbody.Frame._fields))


Trials = Mapping[str, Callable[[dict[str, Any], np.random.Generator], Iterator[Trial]]]


def add_trials(answers: Answers, folder: Path, trials: Trials, rng: np.random.Generator) -> None:
    """Alter files of a trajectory, one entry after the other."""
    for file, trials_of in trials.items():
        is_json = file.endswith("json")
        whole = json.loads((folder / file).read_bytes()) if is_json else dict(np.load(folder / file))
        for trial in trials_of(whole, rng):
            answers.add(right_about_file(trial, whole, folder / file), True, kind=f"{file}, {trial.what}"[:80])


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
        Fault("segments without frames", manifest._segments, "segments[-1].chunks or len(found) == 1 → True"),
        Fault("bodies from anywhere", manifest._segments, "_need(is_ours, m_) → "),
        Fault("files of two segments", manifest._manifest, "len(manifest.files) == n_ → True"),
        Fault("bodies of any hash", bodies.read_cast, "digest_of(shapes) != segment.sha256 → False"),
    ),
)
def entries_of_trajectories(run: Run) -> Comparison:
    """Trajectories read an altered entry, or refuse it by its name.

    Entries of chunks, bodies and manifest are altered to and beyond the limits of what they may be: numbers, kinds,
    shapes, times, turns, labels, names of files, and sizes. What is read is read as it is, and the refusal names the
    file, too.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 3, 20)):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "kept"
            keep_flight(rng, folder)
            trials = {f"00000{rng.integers(2)}.npz": of_chunk, "bodies.npz": of_bodies, "trajectory.json": of_manifest}
            add_trials(answers, folder, trials, rng)
            keep_flight(rng, folder.with_name("changing"), is_changing=True)
            of_several = {"bodies-000001.npz": of_bodies, "trajectory.json": of_segments}
            add_trials(answers, folder.with_name("changing"), of_several, rng)
    return answers.comparison()
