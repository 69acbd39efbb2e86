"""The only maker of Models, Controls, States and VertexRings: empty ones, one more body, one body alone.

What an array of a kind looks like, and which numbers a user may give each body, is said in softbody/model/arrays.py,
where the field is; here is how rows are checked, added and taken apart, for all fields alike.
"""

from __future__ import annotations

from math import sqrt
from typing import Any, NamedTuple, TypeVar, get_type_hints

import numpy as np
from numpy.typing import ArrayLike

from softbody.collision.soft.skin import skin_distance
from softbody.dynamics.filling import liquid_mass
from softbody.dynamics.joint_forces import no_joints
from softbody.dynamics.rigid_boxes import RESOLVED
from softbody.dynamics.vertex_rings import build_rings, in_precision, no_rings, with_springs
from softbody.errors import ParameterError
from softbody.geometry.box import box_inertia
from softbody.geometry.edges import lengths_of
from softbody.geometry.polyhedron import surface_area
from softbody.mesh.mesh import LARGEST, SMALLEST, Mesh
from softbody.model.arrays import (
    ENTRY,
    NEXT,
    NOBODY,
    STIFFNESS,
    Controls,
    Joints,
    Model,
    Rows,
    State,
    VertexRings,
    mass_of,
)
from softbody.model.validation import (
    check_range,
    fixed_particles_of,
    rest_length_of,
    stiffness_of,
    tear_at_of,
    unit_quaternion,
    vector,
)

Part = TypeVar("Part", Model, Controls, State, Joints)

# By default a spring is damped by so much of what is critical for two particles on it. Nothing else calms a body that
# an integrator without loss moves: undamped, a sphere on a torus has particles of 0.5 m/s after 20 s, and with this of
# 0.01 m/s after 8 s, as by the paper's integrator. Steps are some 1.3 times as short for it.
DAMPING_RATIO = 0.1


class Parts(NamedTuple):
    """All arrays of a world."""

    model: Model
    controls: Controls
    state: State
    rings: VertexRings
    joints: Joints


def empty_parts(gravity: np.ndarray, real: type[np.floating[Any]]) -> Parts:
    """Return the parts of a world of no bodies, under `gravity` (3,) [m/s²], its springs in the precision `real`."""
    return Parts(
        _empty(Model)._replace(ground_height=-np.inf, liquid_velocity=np.zeros(3)),
        _empty(Controls)._replace(gravity=gravity),
        _empty(State),
        in_precision(no_rings(), real),
        no_joints(),
    )


def _empty(kind: type[Part]) -> Part:
    """Return a Model, Controls or State of no bodies: arrays of no rows, and numbers that are 0."""
    values: dict[str, Any] = {}
    for name, hint in get_type_hints(kind, include_extras=True).items():
        if hint in (int, float):
            values[name] = hint(0)
            continue
        note = getattr(hint, "__metadata__", (None,))[0]
        rows: Rows = note if isinstance(note, Rows) else Rows()
        shape = (1 if name.endswith("_start") else 0, *([rows.columns] if rows.columns else []))
        values[name] = np.zeros(shape, np.int64 if rows.whole else np.float64)
    return kind(**values)


def default_damping(stiffness: np.ndarray, mass: float) -> float:
    """Return the damping [N s/m] of springs (e,) [N/m] between particles of `mass` [kg]: DAMPING_RATIO of critical.

    That is 2 √(k μ) for two particles on a spring, whose reduced mass μ is half of one; k is the mean stiffness.
    """
    with np.errstate(over="ignore"):
        mean = min((stiffness / len(stiffness)).sum(), stiffness.max())  # where their sum is too large for a double
    return DAMPING_RATIO * 2.0 * sqrt(mean) * sqrt(0.5 * mass)


def with_soft_body(
    parts: Parts,
    mesh: Mesh,
    amounts: tuple[float, float | None, float | None],
    springs: tuple[ArrayLike, ArrayLike | None, ArrayLike | None],
    motion: tuple[ArrayLike, ArrayLike],
    fixed: ArrayLike,
    properties: dict[str, Any],
) -> Parts:
    """Return the parts with one more soft body, as `World.add_soft_body` is told it; raises ParameterError.

    `amounts`: mass, gas and pressure; `springs`: stiffness, rest length and tear_at; `motion`: position and velocity;
    `properties` by field, with a damping of None for `default_damping`.
    """
    if not isinstance(mesh, Mesh):
        raise ParameterError(f"mesh is a {type(mesh).__name__}; make a softbody.Mesh(vertices, triangles)")
    mass, gas = check_range(amounts[0], "mass", "kg", above=0.0), gas_of(mesh.volume, *amounts[1:])
    model, controls, state, rings, joints = parts
    edges, count, first = mesh.edges, len(mesh.vertices), len(state.particle_position)
    stiffness = stiffness_of(springs[0], len(edges))
    points = np.ascontiguousarray(mesh.vertices + vector(motion[0], "position"))
    lengths = lengths_of(points, edges)
    edge = int(np.argmin(lengths))
    if not lengths[edge] > np.spacing(np.abs(points).max()):
        raise ParameterError(
            f"position is {motion[0]!r}: so far away that edge {edge} is lost in rounding; come closer"
        )
    rest_length = lengths if springs[1] is None else rest_length_of(springs[1], len(edges))
    velocity, still = np.tile(vector(motion[1], "velocity"), (count, 1)), fixed_particles_of(fixed, count)
    mass += properties["soft_liquid_density"] * mesh.volume
    inverse_mass = np.full(count, inverse_of(mass, count))
    free_inverse_mass = inverse_mass.copy()
    velocity[still], inverse_mass[still] = 0.0, 0.0
    if properties["soft_damping"] is None:
        properties = properties | {"soft_damping": default_damping(stiffness, mass / count)}
    distance, properties = properties["soft_self_contact"], properties | {"soft_self_contact": 0.0}
    own_rings = build_rings(count, edges, mesh.triangles, rest_length, stiffness)
    longer = Parts(
        _appended(
            model,
            particle_free_inverse_mass=free_inverse_mass,
            particle_inverse_mass=inverse_mass,
            edge_particles=edges + first,
            edge_rest_length=rest_length,
            edge_stiffness=stiffness,
            edge_tear_at=tear_at_of(0.0 if springs[2] is None else springs[2], len(edges)),
            triangle_particles=mesh.triangles + first,
            soft_particle_start=first + count,
            soft_edge_start=len(model.edge_particles) + len(edges),
            soft_triangle_start=len(model.triangle_particles) + len(mesh.triangles),
            soft_thickness=2.0 * mesh.volume / surface_area(mesh.vertices, mesh.triangles),
            soft_edge_length=lengths.mean(),
            soft_mesh_volume=mesh.volume,
            soft_boxes_volume=0.0,
            **properties,
        )._replace(soft_count=model.soft_count + 1),
        _appended(
            controls,
            soft_gas=gas,
            particle_force=np.zeros((count if len(controls.particle_force) else 0, 3)),
        ),
        _appended(state, particle_position=points, particle_velocity=velocity),
        _with_rings(rings, in_precision(own_rings, rings.rest_tension.dtype.type), first, len(model.edge_particles)),
        joints,
    )
    longer.model.soft_self_contact[-1] = distance_of_skin(longer, model.soft_count, distance)
    return longer


def gas_of(volume: float, gas: float | None, pressure: float | None) -> float:
    """Return the gas [J] of a body of `volume` [m³], of which one of `gas` [J] and `pressure` [Pa] is given, not None.

    Raises ParameterError otherwise, and for numbers out of range.
    """
    if gas is not None and pressure is None:
        return check_range(gas, "gas", "J", least=0.0)
    if pressure is not None and gas is None:
        most = np.finfo(float).max / max(volume, 1.0)  # more is no number of joules
        return check_range(pressure, "pressure", "Pa", least=0.0, most=most) * volume
    raise ParameterError("give either gas [J] or pressure [Pa], one of the two; gas=0 for an empty body")


def inverse_of(mass: float, count: int) -> float:
    """Return the inverse mass [1/kg] of each of so many particles of a body; raises ParameterError if it is none."""
    with np.errstate(over="ignore"):
        inverse = np.float64(count) / mass
    _check_inverse(inverse, f"mass is {mass} kg, for {count} particles")
    return float(inverse)


def distance_of_skin(parts: Parts, body: int, given: float | None) -> float:
    """Return the distance [m] that a soft body is to keep from itself: as `given`, or the most that it can, as it is.

    Raises ParameterError if it cannot keep what is given.
    """
    if given == 0.0:
        return 0.0
    alone = soft_body_alone(parts, body)
    most = skin_distance(alone.model, alone.state)
    if given is not None and given > most:
        raise ParameterError(f"self_contact is {given} m; give True, or at most {most:.3g} m for this mesh")
    return most if given is None else given


def with_box(
    parts: Parts,
    size: ArrayLike,
    mass: float | None,
    pose: tuple[ArrayLike, ArrayLike],
    motion: tuple[ArrayLike, ArrayLike],
    properties: dict[str, Any],
) -> Parts:
    """Return the parts with one more box, as `World.add_box` is told it; raises ParameterError.

    `pose`: position and orientation; `motion`: velocity and angular velocity; `properties` by field.
    """
    model, controls, state, rings, joints = parts
    extent = vector(size, "size")
    if not ((extent >= SMALLEST) & (extent <= LARGEST)).all():
        raise ParameterError(f"size is {extent}; give three positive lengths, from {SMALLEST:g} to {LARGEST:g} m")
    place = vector(pose[0], "position")
    if not np.abs(place).sum() <= RESOLVED * extent.min():
        raise ParameterError(
            f"position is {place}: so far away that a size of {extent} is lost in rounding; come closer"
        )
    inverse_mass, inverse_inertia = 0.0, np.zeros(3)
    if mass is not None:
        mass = check_range(mass, "mass", "kg", above=0.0)
        with np.errstate(all="ignore"):
            inertia = np.array(box_inertia(tuple(extent), mass))
            inverse_mass, inverse_inertia = float(1.0 / np.float64(mass)), 1.0 / inertia
        _check_inverse(np.append(inverse_inertia, inverse_mass), f"mass is {mass} kg, and size {extent} m")
    velocity, angular_velocity = vector(motion[0], "velocity"), vector(motion[1], "angular_velocity")
    return Parts(
        _appended(
            model,
            box_size=extent,
            box_inverse_mass=inverse_mass,
            box_inverse_inertia=inverse_inertia,
            box_host=NOBODY,
            **properties,
        )._replace(box_count=model.box_count + 1),
        _appended(controls, box_force=np.zeros(3), box_torque=np.zeros(3)),
        _appended(
            state,
            box_position=place,
            box_orientation=unit_quaternion(pose[1]),
            box_velocity=velocity,
            box_angular_velocity=angular_velocity,
            box_time_left=0.0,
        ),
        rings,
        joints,
    )


def _check_inverse(inverse: np.ndarray | np.float64, given: str) -> None:
    """Raise ParameterError unless masses and moments of inertia have a finite `inverse` above 0."""
    if not (np.isfinite(inverse) & (inverse > 0.0)).all():
        raise ParameterError(f"{given}: too light or too heavy to compute with; take numbers nearer to 1")


def _with_rings(rings: VertexRings, more: VertexRings, rows: int, edges: int) -> VertexRings:
    """Return `rings`, of bodies with so many particles, `rows`, and `edges` in all, followed by `more`."""
    block = more.block.copy()
    block[:, ENTRY] += len(rings.neighbour)
    for column, entries in (NEXT, rings.next_neighbour), (STIFFNESS, rings.stiffness):
        block[block[:, column] >= 0, column] += len(entries)
    return VertexRings(
        particle=appended(rings.particle, more.particle + np.uint32(rows)),
        number=appended(rings.number, more.number + np.uint32(3 * rows)),
        start=appended(rings.start, more.start[1:] + len(rings.particle)),
        block=appended(rings.block, block),
        block_start=appended(rings.block_start, more.block_start[1:] + len(rings.block)),
        edge=appended(rings.edge, more.edge + np.uint32(edges)),
        neighbour=appended(rings.neighbour, more.neighbour),
        rest_tension=appended(rings.rest_tension, more.rest_tension),
        next_neighbour=appended(rings.next_neighbour, more.next_neighbour),
        stiffness=appended(rings.stiffness, more.stiffness),
        common_stiffness=appended(rings.common_stiffness, more.common_stiffness),
        border=appended(rings.border, more.border),
        hole=appended(rings.hole, more.hole + len(rings.border)),
        hole_start=appended(rings.hole_start, more.hole_start[1:] + len(rings.hole)),
    )


def rings_of(model: Model, real: type[np.floating[Any]]) -> VertexRings:
    """Return the vertex rings of all soft bodies, built anew, with springs in the precision `real`.

    Bodies of the same triangles share the work.
    """
    rings, known = in_precision(no_rings(), real), dict[bytes, VertexRings]()
    for body in range(model.soft_count):
        rows = _rows_of_body(model, body)
        first, first_edge = rows["particle"].start, rows["edge"].start
        edges, triangles = (
            model.edge_particles[rows["edge"]] - first,
            model.triangle_particles[rows["triangle"]] - first,
        )
        key = triangles.tobytes()
        if key not in known:
            none = np.zeros(len(edges))
            known[key] = in_precision(build_rings(rows["particle"].stop - first, edges, triangles, none, none), real)
        rings = _with_rings(rings, known[key], first, first_edge)
    if not model.soft_count:
        return rings
    return with_springs(rings, model.edge_rest_length, model.edge_stiffness, model.soft_edge_start)


def _rows_of_body(model: Model, body: int) -> dict[str, slice]:
    """Return the rows of a soft body, by what has a row."""
    return {
        "particle": slice(*model.soft_particle_start[body : body + 2]),
        "edge": slice(*model.soft_edge_start[body : body + 2]),
        "triangle": slice(*model.soft_triangle_start[body : body + 2]),
        "soft": slice(body, body + 1),
        "box": slice(0, 0),
    }


def soft_body_alone(parts: Parts, body: int) -> Parts:
    """Return the parts of one soft body alone, in double precision; without boxes, joints, ground and liquid."""
    model, controls, state, _, _ = with_hosts(parts, np.full(parts.model.box_count, NOBODY))
    rows = _rows_of_body(model, body)
    model, controls, state = _rows_of(model, rows), _rows_of(controls, rows), _rows_of(state, rows)
    particles, first = len(model.particle_inverse_mass), rows["particle"].start
    model = model._replace(
        soft_count=1,
        box_count=0,
        edge_particles=model.edge_particles - first,
        triangle_particles=model.triangle_particles - first,
        soft_particle_start=np.array([0, particles]),
        soft_edge_start=np.array([0, len(model.edge_particles)]),
        soft_triangle_start=np.array([0, len(model.triangle_particles)]),
        ground_height=-np.inf,
        liquid_density=0.0,
    )
    springs = model.edge_rest_length, model.edge_stiffness
    rings = build_rings(particles, model.edge_particles, model.triangle_particles, *springs)
    return Parts(model, controls, state, rings, no_joints())


def without(parts: Parts, kind: str, body: int) -> Parts:
    """Return the parts without one of a `kind`, as of `who`: those after it are one number lower.

    What is joined to a body, or hangs in it, goes with it; `joints_that_stay` and `suspensions_that_stay` tell what.
    Boxes inside a soft body stay.
    """
    joints = _joints_at(parts, joints_that_stay(parts, kind, body), suspensions_that_stay(parts, kind, body))
    if kind in ("joint", "suspension"):
        return parts._replace(joints=joints)
    hosts = parts.model.box_host.copy()
    hosts[body if kind == "box" else hosts == body] = NOBODY
    model, controls, state, rings, _ = with_hosts(parts, hosts)
    rows = {"box": slice(body, body + 1)} if kind == "box" else _rows_of_body(model, body)
    model, controls, state = _without_rows(model, rows), _without_rows(controls, rows), _without_rows(state, rows)
    if kind == "box":
        joints = joints._replace(
            joint_box=joints.joint_box - (joints.joint_box > body),
            suspension_box=joints.suspension_box - (joints.suspension_box > body),
        )
        return Parts(model._replace(box_count=model.box_count - 1), controls, state, rings, joints)
    first, count = rows["particle"].start, rows["particle"].stop - rows["particle"].start
    joints = joints._replace(
        joint_particles=joints.joint_particles - count * (joints.joint_particles > first),
        suspension_particles=joints.suspension_particles - count * (joints.suspension_particles > first),
    )
    model = model._replace(
        soft_count=model.soft_count - 1,
        edge_particles=model.edge_particles - count * (model.edge_particles > first),
        triangle_particles=model.triangle_particles - count * (model.triangle_particles > first),
        soft_particle_start=_without_part(model.soft_particle_start, body),
        soft_edge_start=_without_part(model.soft_edge_start, body),
        soft_triangle_start=_without_part(model.soft_triangle_start, body),
        box_host=model.box_host - (model.box_host > body),
    )
    return Parts(model, controls, state, rings_of(model, rings.rest_tension.dtype.type), joints)


def joints_that_stay(parts: Parts, kind: str, body: int) -> np.ndarray:
    """Return which joints (j,) of bool there still are without one of a `kind`, as of `who`."""
    joints, stay = parts.joints, np.append(suspensions_that_stay(parts, kind, body), True)  # with none, −1
    held = stay[joints.joint_inside[:, ::2]].all(axis=1)
    if kind == "joint":
        return np.arange(len(joints.joint_box)) != body
    if kind == "box":
        return ~(joints.joint_box == body).any(axis=1) & held
    if kind == "suspension":
        return np.asarray(held)
    first, end = parts.model.soft_particle_start[body : body + 2]
    return ~((joints.joint_particles >= first) & (joints.joint_particles < end)).any(axis=1) & held


def suspensions_that_stay(parts: Parts, kind: str, body: int) -> np.ndarray:
    """Return which suspensions (s,) of bool there still are without one of a `kind`, as of `who`."""
    joints = parts.joints
    if kind == "suspension":
        return np.arange(len(joints.suspension_box)) != body
    if kind == "box":
        return joints.suspension_box != body
    if kind == "soft":
        return joints.suspension_particles[:, 0] != parts.model.soft_particle_start[body]
    return np.ones(len(joints.suspension_box), bool)


def _joints_at(parts: Parts, stay: np.ndarray, suspended: np.ndarray) -> Joints:
    """Return the joints that `stay` (j,), with the suspensions that do, `suspended` (s,)."""
    joints = parts.joints
    kept: dict[str, Any] = {name: array[stay] for name, array in joints._asdict().items() if name.startswith("joint_")}
    inside, number = kept["joint_inside"], np.append(np.cumsum(suspended) - 1, NOBODY)
    inside[:, ::2] = number[inside[:, ::2]]
    counts = np.diff(joints.suspension_start)
    return Joints(
        **kept,
        suspension_particles=joints.suspension_particles[suspended],
        suspension_box=joints.suspension_box[suspended],
        suspension_start=np.append(0, np.cumsum(counts[suspended])),
        weight=joints.weight[np.repeat(suspended, counts)],
    )


def with_hosts(parts: Parts, hosts: np.ndarray) -> Parts:
    """Return the parts where each box is inside its soft body of `hosts` (m,), or in none, −1.

    It takes the place of liquid, whose mass leaves that of the particles, or comes back. Raises ParameterError where it
    leaves no place.
    """
    before = parts.model
    model = before._replace(box_host=hosts, soft_boxes_volume=boxes_volumes(before, hosts))
    for body in np.flatnonzero(model.soft_boxes_volume != before.soft_boxes_volume).tolist():
        room = float(model.soft_mesh_volume[body] - model.soft_boxes_volume[body])
        if not room > 0.0:
            raise ParameterError(
                f"boxes inside soft body {body} have {model.soft_boxes_volume[body]:.3g} m³, and its mesh has no more "
                f"than {model.soft_mesh_volume[body]:.3g} m³; take smaller boxes, or a larger body"
            )
        if model.soft_liquid_density[body] > 0.0:
            model = with_liquid_mass(model, body, liquid_mass(before, body))
    return parts._replace(model=model)


def with_liquid_mass(model: Model, body: int, before: float) -> Model:
    """Return a Model in which a soft body has the mass of the liquid in it, in place of that of `before` [kg].

    Its particles share it in proportion to their masses. Raises ParameterError for what cannot be computed with.
    """
    free, inverse_mass = model.particle_free_inverse_mass.copy(), model.particle_inverse_mass.copy()
    rows = slice(*model.soft_particle_start[body : body + 2])
    mass, ratio = mass_of(free[rows]) - before + liquid_mass(model, body), free[rows] / free[rows.start]
    inverse_of(mass, len(ratio))
    free[rows] = ratio * ((1.0 / ratio).sum() / mass)
    inverse_mass[rows] = free[rows] * (inverse_mass[rows] > 0.0)
    return model._replace(particle_free_inverse_mass=free, particle_inverse_mass=inverse_mass)


def with_box_inside(parts: Parts, box: int, body: int) -> Parts:
    """Return the parts where a box is inside a soft body, or in none, −1; raises ParameterError as `with_hosts`."""
    hosts = parts.model.box_host.copy()
    hosts[box] = body
    return with_hosts(parts, hosts)


def boxes_volumes(model: Model, hosts: np.ndarray) -> np.ndarray:
    """Return the volume (b,) [m³] of all boxes inside each soft body, by `hosts` (m,)."""
    volumes, inside = np.zeros(model.soft_count), hosts != NOBODY
    np.add.at(volumes, hosts[inside], model.box_size[inside].prod(axis=1))
    return volumes


def hanging_hosts(model: Model, joints: Joints) -> np.ndarray:
    """Return the soft body (m,) in which each box hangs, or −1."""
    hosts, hangs = np.full(model.box_count, NOBODY), joints.suspension_box != NOBODY
    first = joints.suspension_particles[hangs, 0]
    hosts[joints.suspension_box[hangs]] = np.searchsorted(model.soft_particle_start, first, side="right") - 1
    return hosts


def with_suspension(parts: Parts, body: int, box: int, weights: np.ndarray) -> Parts:
    """Return the parts where points of these `weights` (k, n) hang in a soft body; for the corners of a box, or −1."""
    joints = _appended(
        parts.joints,
        suspension_particles=parts.model.soft_particle_start[body : body + 2],
        suspension_box=box,
        suspension_start=len(parts.joints.weight) + weights.size,
        weight=weights.ravel(),
    )
    parts = parts._replace(joints=joints)
    return with_box_inside(parts, box, body) if box != NOBODY else parts


def with_joint(parts: Parts, ends: list[dict[str, ArrayLike]], numbers: dict[str, float]) -> Parts:
    """Return the parts with one more joint: `ends`, from `end_on_box` and the like, and `numbers`, by field."""
    a, b = ends
    rows = {f"joint_{name}": np.append(a[name], b[name]) for name in ("box", "particles", "weights", "inside", "place")}
    return parts._replace(joints=_appended(parts.joints, **rows, **numbers))


def end_in_world(place: ArrayLike) -> dict[str, ArrayLike]:
    """Return the end of a joint that is at a place (3,) [m] of the world."""
    nowhere: dict[str, ArrayLike] = {"box": NOBODY, "particles": [NOBODY] * 3, "weights": np.zeros(3)}
    return nowhere | {"inside": [NOBODY] * 2, "place": place}


def end_on_box(box: int, arm: ArrayLike) -> dict[str, ArrayLike]:
    """Return the end of a joint that is on a box, at `arm` (3,) [m] from its centre, in its own frame."""
    return end_in_world(arm) | {"box": box}


def end_on_soft(particles: ArrayLike, weights: ArrayLike) -> dict[str, ArrayLike]:
    """Return the end of a joint that is on the triangle of three `particles` (3,), at barycentric `weights` (3,)."""
    return end_in_world(np.zeros(3)) | {"particles": particles, "weights": weights}


def end_inside(suspension: int, point: int) -> dict[str, ArrayLike]:
    """Return the end of a joint that is at a `point` of a suspension, inside a soft body."""
    return end_in_world(np.zeros(3)) | {"inside": [suspension, point]}


def _without_rows(part: Part, rows: dict[str, slice]) -> Part:
    """Return a part without some rows of its arrays, by what has a row in them; others as they are."""
    kept: dict[str, Any] = {}
    for name, value in part._asdict().items():
        kind = name.split("_")[0]
        has_rows = isinstance(value, np.ndarray) and kind in rows and not name.endswith("_start") and len(value)
        kept[name] = np.delete(value, rows[kind], axis=0) if has_rows else value
    return type(part)(**kept)


def _without_part(start: np.ndarray, part: int) -> np.ndarray:
    """Return where parts begin and the last one ends (b,), without one of them; `start` (b + 1,)."""
    return np.append(start[: part + 1], start[part + 2 :] - (start[part + 1] - start[part]))


def _rows_of(part: Part, rows: dict[str, slice]) -> Part:
    """Return a part with only some rows of its arrays, by what has a row in them; others as they are."""
    kept: dict[str, Any] = {}
    for name, value in part._asdict().items():
        kind = name.split("_")[0]
        kept[name] = value[rows[kind]] if isinstance(value, np.ndarray) and kind in rows else value
    return type(part)(**kept)


def _appended(part: Part, **rows: ArrayLike) -> Part:
    """Return a part with more rows in some of its arrays."""
    longer: dict[str, Any] = {name: appended(getattr(part, name), more) for name, more in rows.items()}
    return part._replace(**longer)


def appended(array: np.ndarray, rows: ArrayLike) -> np.ndarray:
    """Return `array` followed by `rows`, in memory with room for more: adding n bodies costs O(n), not O(n²).

    The result may share memory with `array`, of which only the newest result may be appended to.
    """
    more = np.asarray(rows, array.dtype).reshape(-1, *array.shape[1:])
    old, new = len(array), len(array) + len(more)
    room = array.base
    if room is None or room.shape[1:] != array.shape[1:] or len(room) < new or room.dtype != array.dtype:
        room = np.empty((max(new, 2 * old), *array.shape[1:]), array.dtype)
        room[:old] = array
    room[old:new] = more
    return room[:new]
