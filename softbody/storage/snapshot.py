"""What a world is at one instant, as named arrays; and which world, if any, such arrays describe.

Whoever reads arrays from elsewhere believes nothing: they are copied, then every entry is checked, then taken. What
follows from others, as vertex rings do, is no part of a snapshot.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any, NamedTuple, get_type_hints

import numpy as np

from softbody.bodies.builder import boxes_volumes, hanging_hosts
from softbody.bodies.names import Names, names_of
from softbody.collision.contact import ImpulseCache
from softbody.dynamics.filling import liquid_mass
from softbody.dynamics.joint_forces import no_joints, weights_of
from softbody.errors import MeshError, ParameterError, SnapshotError
from softbody.mesh.mesh import check_surface, unique_edges
from softbody.mesh.tearing import check_torn_surface
from softbody.model.arrays import (
    NOBODY,
    Controls,
    Joints,
    Model,
    Property,
    Rows,
    State,
    has_border,
    is_open,
    mass_of,
)
from softbody.model.properties import check_self_contact, known_properties
from softbody.model.settings import PRECISIONS, Settings, check_name, check_settings
from softbody.model.sleep_state import Rested, not_rested
from softbody.model.validation import QUATERNION_TOLERANCE
from softbody.storage.snapshot_entries import Entries, Snapshot

# Of snapshots and files. Format 1 has no number, and holds the vertex rings, too; before 3 there are no joints,
# before 4 no times left, before 5 no names, before 6 nobody sleeps, before 7 soft contacts remember nothing, before 8
# nobody holds itself, before 9 there is no liquid, before 10 none in a body and nothing hangs in one, before 11 what
# hangs in a body takes no place there, before 12 all particles of a body have the same mass, before 13 none tears. A
# property of bodies may begin a new one.
SETTINGS_SINCE = {"sleep_speed": 6, "sleep_after": 6, "self_contact": 8}  # formats; worlds before did as by default
LIQUID_SINCE = 9
SUSPENDED_SINCE = 10
INSIDE_SINCE = 11
MASSES_SINCE = 12
TEARING_SINCE = 13
FORMAT = max(MASSES_SINCE, *SETTINGS_SINCE.values(), *(note.since for note in known_properties().values()))

GROUND = {  # limits of each of its numbers
    "ground_height": Rows(),
    "ground_restitution": Rows(least=0.0, most=1.0),
    "ground_friction": Rows(least=0.0),
}
NO_GROUND = -np.inf  # its height, if there is none
LIQUID = {  # likewise
    "liquid_density": Rows(least=0.0),  # 0: there is none
    "liquid_surface_height": Rows(),
    "liquid_drag": Rows(least=0.0),
}

SAME = 1e-9  # how far, relatively, an inverse inertia may be from that of the box's size and mass: rounding is 1e-15


class Snapped(NamedTuple):
    """What a snapshot says of a world."""

    model: Model
    controls: Controls
    state: State
    joints: Joints
    names: Names
    rest: Rested
    cache: ImpulseCache
    settings: Settings
    precision: str
    steps: int
    time: float


def snapshot_of(snapped: Snapped) -> Snapshot:
    """Return named arrays that share no memory with a world."""
    parts: dict[str, np.ndarray] = {"format": np.array(FORMAT)}
    for name, value in snapped._asdict().items():
        if isinstance(value, Names):
            words = value.words(_counts_of(snapped.model, snapped.joints))
            parts |= {f"{name}.{kind}": array for kind, array in words.items()}
        else:
            parts |= dict(named_arrays(name, value)) if hasattr(value, "_asdict") else {name: np.array(value)}
    return parts


def _counts_of(model: Model, joints: Joints) -> dict[str, int]:
    """Return how many there are of each kind that may have names."""
    counts = {"soft": model.soft_count, "box": model.box_count, "joint": len(joints.joint_box)}
    return counts | {"suspension": len(joints.suspension_box)}


def named_arrays(name: str, part: Any) -> Iterator[tuple[str, np.ndarray]]:
    """Yield "name.field" and a copy of each field of a named tuple."""
    for field, value in part._asdict().items():
        yield f"{name}.{field}", np.array(value)


def digest(arrays: Iterator[tuple[str, np.ndarray]]) -> str:
    """Return a SHA-256 of names and bits, in hexadecimal."""
    result = hashlib.sha256()
    for name, array in arrays:
        result.update(f"{name} {array.dtype.str} {array.shape}".encode())
        result.update(array.tobytes())
    return result.hexdigest()


def checked(snapshot: Snapshot) -> Snapped:
    """Return what a snapshot says, in memory of its own; raises SnapshotError, which names the entry at fault."""
    try:
        return _checked(Entries(snapshot))
    except (ParameterError, MeshError) as error:
        raise error if isinstance(error, SnapshotError) else SnapshotError(str(error)) from error


def _checked(entries: Entries) -> Snapped:
    number = _format(entries)
    model, counts = _model(entries, number)
    if number < 4:
        entries.put("state.box_time_left", np.zeros(model.box_count))
    _check_surfaces(model)
    model = _with_boxes_volumes(_with_masses(model, number), number)
    _check_masses(model)
    controls, state = _controls(entries, counts), _part(entries, "state", State, counts)
    _check_orientations(state.box_orientation)
    joints = _joints(entries, model, number)
    names = _names(entries, _counts_of(model, joints), number)
    rested = _rested(entries, model, number)
    impulses = _impulses(entries, model.box_count, number)
    settings = _settings(entries, number)
    for distance in np.abs(model.soft_self_contact):
        check_self_contact(settings, distance)
    precision = entries.word("precision")
    check_name(precision, "precision", tuple(PRECISIONS))
    steps, time = entries.whole("steps"), entries.real("time", Rows(least=0.0))
    entries.none_left()
    return Snapped(model, controls, state, joints, names, rested, impulses, settings, precision, steps, time)


def _format(entries: Entries) -> int:
    """Take what only tells the format, or is no part of it any more; return its number."""
    if "format" not in entries.names() and "rings.particle" in entries.names():
        entries.leave_out("rings.")
        return 1
    number = entries.whole("format")
    if not 2 <= number <= FORMAT:
        raise SnapshotError(
            f"format is {number}, and this softbody reads formats up to {FORMAT}: take the softbody that wrote it"
        )
    return number


def _model(entries: Entries, number: int) -> tuple[Model, dict[str, int]]:
    """Take a Model of a format; return it, and how many rows there are of what fields are named by."""
    counts = {
        "soft": entries.whole("model.soft_count"),
        "box": entries.whole("model.box_count"),
        "gravity": 3,
        "liquid": 3,
    }
    known: dict[str, Any] = {"soft_count": counts["soft"], "box_count": counts["box"]}
    for kind in ("particle", "edge", "triangle"):
        name = f"model.soft_{kind}_start"
        start = entries.rows(name, (counts["soft"] + 1,), Rows(whole=True, least=0))
        if start[0] != 0 or not (start[1:] > start[:-1]).all():
            raise SnapshotError(f"{name} is {start}; it must begin with 0 and grow with every body")
        known[f"soft_{kind}_start"], counts[kind] = start, int(start[-1])
    for field, limits in GROUND.items():
        known[field] = entries.real(f"model.{field}", limits, NO_GROUND if field == "ground_height" else None)
    for field, limits in LIQUID.items():
        if number < LIQUID_SINCE:
            entries.put(f"model.{field}", np.array(0.0))
        known[field] = entries.real(f"model.{field}", limits)
    if number < LIQUID_SINCE:
        entries.put("model.liquid_velocity", np.zeros(3))
    if number < SUSPENDED_SINCE:
        entries.put("model.box_host", np.full(counts["box"], NOBODY))
    if number < INSIDE_SINCE:
        entries.put("model.soft_boxes_volume", np.zeros(counts["soft"]))
    if number < MASSES_SINCE:
        entries.put("model.particle_free_inverse_mass", np.ones(counts["particle"]))
    if number < TEARING_SINCE:
        entries.put("model.edge_tear_at", np.zeros(counts["edge"]))
    for field, note in known_properties().items():
        if number < note.since:
            entries.put(f"model.{field}", np.full(counts[field.split("_")[0]], note.default))
    return _part(entries, "model", Model, counts, known), counts


def _controls(entries: Entries, counts: dict[str, int]) -> Controls:
    """Take Controls; there are forces on all particles, or on none."""
    particles = counts["particle"] if entries.length("controls.particle_force") else 0
    return _part(entries, "controls", Controls, counts | {"particle": particles})


def _part(entries: Entries, name: str, kind: Any, counts: dict[str, int], known: dict[str, Any] | None = None) -> Any:
    """Take a Model, Controls or State, but for the fields that are `known`."""
    values = dict(known or {})
    for field, rows in _rows_of(kind).items():
        if field not in values:
            count = counts[field.split("_")[0]]
            values[field] = entries.rows(f"{name}.{field}", (count, *([rows.columns] if rows.columns else [])), rows)
    return kind(**values)


@cache
def _rows_of(kind: Any) -> dict[str, Rows]:
    """Return what the rows of each array of a Model, Controls or State are; see softbody/model/arrays.py."""
    found = {}
    for field, hint in get_type_hints(kind, include_extras=True).items():
        note = getattr(hint, "__metadata__", (None,))[0]
        if hint not in (int, float):
            limits = Rows(least=note.least, most=note.most) if isinstance(note, Property) else Rows()
            found[field] = note if isinstance(note, Rows) else limits
    return found


def _check_surfaces(model: Model) -> None:
    """Raise SnapshotError unless the triangles of each soft body are a surface of its particles and edges.

    It is closed, or has simple borders where it has torn.
    """
    known = dict[bytes, np.ndarray]()
    for body in range(model.soft_count):
        first, end = model.soft_particle_start[body : body + 2]
        triangles = model.triangle_particles[slice(*model.soft_triangle_start[body : body + 2])] - first
        edges = model.edge_particles[slice(*model.soft_edge_start[body : body + 2])] - first
        key = np.int64(end - first).tobytes() + triangles.tobytes()
        if key not in known:
            try:
                check = check_torn_surface if has_border(len(edges), len(triangles)) else check_surface
                check(triangles, int(end - first))
            except MeshError as error:
                raise SnapshotError(
                    f"model.triangle_particles of soft body {body}, from {first} on: {error}"
                ) from error
            known[key] = unique_edges(triangles)
        if not np.array_equal(edges, known[key]):
            raise SnapshotError(
                f"model.edge_particles of soft body {body} are not the edges of its triangles, each once, in order"
            )


def _with_boxes_volumes(model: Model, number: int) -> Model:
    """Return a model of a format with the volume of boxes inside each soft body; raises SnapshotError for a wrong one.

    Before they were kept, a box that hung in a body took no place in it.
    """
    if not (model.box_host < model.soft_count).all():
        raise SnapshotError(f"model.box_host is {model.box_host}; it must be soft bodies, from 0 on, or −1")
    volumes = boxes_volumes(model, model.box_host)
    if number >= INSIDE_SINCE and not (np.abs(model.soft_boxes_volume - volumes) <= SAME * volumes).all():
        raise SnapshotError(f"model.soft_boxes_volume is {model.soft_boxes_volume}; by model.box_host it is {volumes}")
    if not (volumes < model.soft_mesh_volume).all():
        raise SnapshotError(f"model.box_host leaves soft body {np.argmin(volumes < model.soft_mesh_volume)} no room")
    return model if number >= INSIDE_SINCE else model._replace(soft_boxes_volume=volumes)


def _with_masses(model: Model, number: int) -> Model:
    """Return a model of a format with the masses of particles; raises SnapshotError for wrong ones.

    Before they were kept, all particles of a soft body had the same.
    """
    inverse = model.particle_inverse_mass
    greatest = np.maximum.reduceat(np.append(inverse, 0.0), model.soft_particle_start)[:-1]
    may_move = (greatest > 0.0) | np.array([is_open(model, body) for body in range(model.soft_count)], bool)
    if not may_move.all():
        body = int(np.argmin(may_move))
        raise SnapshotError(f"model.particle_inverse_mass of soft body {body} is 0 everywhere: leave one particle free")
    if number < MASSES_SINCE:
        return model._replace(particle_free_inverse_mass=np.repeat(greatest, np.diff(model.soft_particle_start)))
    good = (inverse == 0.0) | (inverse == model.particle_free_inverse_mass)
    if not good.all():
        i = int(np.argmin(good))
        raise SnapshotError(
            f"model.particle_inverse_mass[{i}] is {inverse[i]}; it must be 0, or as model.particle_free_inverse_mass, "
            f"{model.particle_free_inverse_mass[i]}"
        )
    return model


def _check_masses(model: Model) -> None:
    """Raise SnapshotError unless soft bodies are as heavy as the liquid in them, and boxes turn as boxes do."""
    for body in range(model.soft_count):
        rows = slice(*model.soft_particle_start[body : body + 2])
        liquid, mass = liquid_mass(model, body), mass_of(model.particle_free_inverse_mass[rows])
        if not liquid <= mass * (1.0 + SAME):
            raise SnapshotError(
                f"model.soft_liquid_density[{body}] is {model.soft_liquid_density[body]} kg/m³: {liquid} kg of it "
                f"in a body of {mass} kg; make that more"
            )
    square = model.box_size**2
    inverse = 12.0 * model.box_inverse_mass[:, None] / (np.roll(square, 1, axis=1) + np.roll(square, 2, axis=1))
    good = (np.abs(model.box_inverse_inertia - inverse) <= SAME * inverse).all(axis=1)
    if not good.all():
        box = int(np.argmin(good))
        raise SnapshotError(
            f"model.box_inverse_inertia[{box}] is {model.box_inverse_inertia[box]}; of a homogeneous box of its size "
            f"and mass it is {inverse[box]}"
        )


def _joints(entries: Entries, model: Model, number: int) -> Joints:
    """Take joints, if there are entries for them, and what hangs in bodies.

    Each end of a joint is on a box, in one soft body, or in the world.
    """
    count = entries.length("joints.joint_box")
    if not count and not any(name.startswith("joints.") for name in entries.names()):
        return no_joints()
    if number < SUSPENDED_SINCE:
        entries.put("joints.joint_inside", np.full((count, 4), NOBODY))
        for field in ("suspension_particles", "suspension_box", "suspension_start", "weight"):
            entries.put(f"joints.{field}", getattr(no_joints(), field))
    hung = entries.length("joints.suspension_box")
    known = {"suspension_box": entries.rows("joints.suspension_box", (hung,), Rows(whole=True, least=-1))}
    start = known["suspension_start"] = entries.rows("joints.suspension_start", (hung + 1,), Rows(whole=True, least=0))
    if start[0] != 0 or not (start[1:] > start[:-1]).all():
        raise SnapshotError(f"joints.suspension_start is {start}; it must begin with 0 and grow with every suspension")
    counts = {"joint": count, "suspension": hung, "weight": int(start[-1])}
    joints: Joints = _part(entries, "joints", Joints, counts, known)
    points = _check_suspensions(model, joints)
    box = joints.joint_box
    particles, weights = joints.joint_particles.reshape(count, 2, 3), joints.joint_weights.reshape(count, 2, 3)
    inside = joints.joint_inside.reshape(count, 2, 2)
    on_box, on_soft, is_inside = box >= 0, (particles >= 0).all(axis=2), (inside >= 0).all(axis=2)
    body = np.searchsorted(model.soft_particle_start, particles, side="right")
    good = (
        (box < model.box_count)
        & (on_soft | (particles < 0).all(axis=2))
        & (is_inside | (inside < 0).all(axis=2))
        & (inside[:, :, 0] < len(points))
        & (inside[:, :, 1] < np.append(points, 0)[np.minimum(inside[:, :, 0], len(points))])
        & (on_box.astype(int) + on_soft + is_inside <= 1)
        & ~(on_soft & ((particles >= model.soft_particle_start[-1]) | (body != body[:, :, :1])).any(axis=2))
        & (np.abs(weights.sum(axis=2) - on_soft) <= SAME)
    )
    if not good.all():
        joint, end = (int(i) for i in np.argwhere(~good)[0])
        raise SnapshotError(
            "joints.joint_box, joint_particles, joint_weights and joint_inside say nothing that can be of "
            f"end {end} of joint {joint}"
        )
    holds = (on_box | on_soft | is_inside).any(axis=1)
    if not holds.all():
        raise SnapshotError(
            "joint_box, joint_particles and joint_inside of joints have "
            f"both ends of joint {np.argmin(holds)} in the world; omit it"
        )
    return joints


def _check_suspensions(model: Model, joints: Joints) -> np.ndarray:
    """Return how many points (s,) each suspension has; raises SnapshotError unless a soft body carries each of them."""
    first, end = joints.suspension_particles.T
    body = np.searchsorted(model.soft_particle_start, first, side="right") - 1
    starts = np.append(model.soft_particle_start, -1)
    is_body = (first == starts[body]) & (end == starts[np.minimum(body + 1, len(starts) - 1)])
    if not is_body.all():
        k = int(np.argmin(is_body))
        raise SnapshotError(f"joints.suspension_particles[{k}] is {first[k]}, {end[k]}, the particles of no soft body")
    sizes, particles = np.diff(joints.suspension_start), end - first
    whole = sizes % particles == 0
    if not whole.all():
        raise SnapshotError(f"joints.suspension_start leaves suspension {np.argmin(whole)} no whole number of points")
    for k in range(len(sizes)):
        each = weights_of(joints, k)
        if not (np.abs(each.sum(axis=1) - 1.0) <= SAME * np.abs(each).sum(axis=1)).all():
            raise SnapshotError(f"joints.weight of a point of suspension {k} does not sum to 1")
    box = joints.suspension_box[joints.suspension_box != NOBODY]
    if not ((box < model.box_count).all() and len(set(box.tolist())) == len(box)):
        raise SnapshotError(f"joints.suspension_box is {joints.suspension_box}; it must be boxes, each once, or −1")
    hanging = hanging_hosts(model, joints)
    if not np.array_equal(np.where(hanging == NOBODY, model.box_host, hanging), model.box_host):
        raise SnapshotError(f"model.box_host is {model.box_host}; by joints.suspension_box it is other")
    return np.asarray(sizes // particles)


def _names(entries: Entries, counts: dict[str, int], number: int) -> Names:
    """Take the names of all bodies and joints, "" for none; before format 5 there are none."""
    if number < 5:
        return Names()
    if number < SUSPENDED_SINCE:
        entries.put("names.suspension", np.zeros(0, np.str_))
    return names_of({kind: entries.words(f"names.{kind}", count) for kind, count in counts.items()}, "names")


def _check_orientations(orientation: np.ndarray) -> None:
    length = np.linalg.norm(orientation, axis=1)
    good = np.abs(length - 1.0) <= QUATERNION_TOLERANCE
    if not good.all():
        box = int(np.argmin(good))
        raise SnapshotError(f"state.box_orientation[{box}] has length {length[box]:.6g}; it must be 1")


def _impulses(entries: Entries, boxes: int, format_number: int) -> ImpulseCache:
    """Take what solvers remember of the last step; before format 7 of boxes only."""
    if format_number < 7:
        entries.put("cache.soft", np.zeros(1, np.int64))
    number = entries.rows("cache.number", (1,), Rows(whole=True, least=0))
    count = int(number[0])
    soft = entries.rows("cache.soft", (1,), Rows(whole=True, least=0, most=count))
    of_boxes = count - int(soft[0])
    box = entries.rows("cache.box", (count, 2), Rows(2, whole=True, least=NOBODY))
    a, b = box[:of_boxes].T
    # By (a, b), where b is a box before a, or the ground.
    rising = (np.diff(a) > 0) | ((np.diff(a) == 0) & (np.diff(b) >= 0))
    if not ((b < a) & (a < boxes)).all() or not rising.all():
        raise SnapshotError("cache.box is no list of pairs of boxes (a, b) with b < a, in order")
    a, b = box[of_boxes:].T
    if not ((a == NOBODY) & (b < boxes)).all():
        raise SnapshotError("cache.box is no list of what soft bodies touch, of none or one box each, as b")
    return ImpulseCache(
        number,
        soft,
        box,
        entries.rows("cache.feature", (count,), Rows(whole=True)),
        entries.rows("cache.point", (count, 3), Rows(3)),
        entries.rows("cache.impulse", (count, 3), Rows(3)),
    )


def _rested(entries: Entries, model: Model, number: int) -> Rested:
    """Take for how long bodies have been at rest; before format 6 nobody has."""
    if number < 6:
        return not_rested(model)
    count = (model.soft_count + model.box_count,)
    return Rested(
        entries.rows("rest.time", count, Rows(least=0.0)),
        entries.rows("rest.asleep", count, Rows(whole=True, least=0, most=1)),
    )


def _settings(entries: Entries, number: int) -> Settings:
    take: dict[type, Callable[[str], Any]] = {int: entries.whole, bool: entries.truth, float: entries.any_real}
    values = {}
    for field, default in Settings()._asdict().items():
        if number < SETTINGS_SINCE.get(field, 0):
            entries.put(f"settings.{field}", np.array(default))
        values[field] = take[type(default)](f"settings.{field}")
    settings = Settings(**values)
    check_settings(settings, "settings")
    return settings
