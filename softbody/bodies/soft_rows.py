"""Soft bodies of a world, one by one: their rows taken out of its arrays, and others put in their place."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from softbody.bodies.body import Body
from softbody.bodies.builder import Parts, boxes_volumes, distance_of_skin, rings_of
from softbody.bodies.names import Names
from softbody.bodies.sharing import Particles
from softbody.bodies.store import FIRST_ROOM, Contents, Store
from softbody.collision.contact import remembered, remembering, without_soft
from softbody.compiler.interrupts import set_together
from softbody.errors import ParameterError
from softbody.geometry import closest_on_mesh
from softbody.geometry.edges import lengths_of
from softbody.geometry.polyhedron import signed_volume, surface_area
from softbody.model.arrays import NOBODY, has_border, is_open

NUMBERS = "edge_particles", "triangle_particles"  # fields that hold numbers of particles


class SoftRows(NamedTuple):
    """The rows of one soft body, by field of a Model, Controls and a State; its particles are numbered from 0."""

    model: dict[str, np.ndarray]
    controls: dict[str, np.ndarray]
    state: dict[str, np.ndarray]


class Springs(NamedTuple):
    """The springs of one soft body, on all edges of its triangles in order."""

    edges: np.ndarray  # (e, 2)
    rest_length: np.ndarray  # (e,) [m]
    stiffness: np.ndarray  # (e,) [N/m]
    tear_at: np.ndarray  # (e,) see Model


def taken_out(parts: Parts) -> list[SoftRows]:
    """Return the rows of each soft body; they share the world's memory."""
    model = parts.model
    starts = {kind: getattr(model, f"soft_{kind}_start").tolist() for kind in ("particle", "edge", "triangle")}
    bodies = []
    for body in range(model.soft_count):
        rows = {kind: slice(start[body], start[body + 1]) for kind, start in starts.items()}
        rows["soft"] = slice(body, body + 1)
        model_rows, *others = ({name: array[rows[kind]] for kind, name, array in _fields(part)} for part in parts[:3])
        for name in NUMBERS:
            model_rows[name] = model_rows[name] - rows["particle"].start
        bodies.append(SoftRows(model_rows, *others))
    return bodies


def with_soft_bodies(parts: Parts, bodies: list[SoftRows], hosts: np.ndarray) -> Parts:
    """Return the parts with these soft bodies in place of those that there are; joints stay as they are.

    `hosts` (m,): the number among them of the one that each box is inside, or −1.
    """
    model, controls, state = (_filled(part, [rows[k] for rows in bodies]) for k, part in enumerate(parts[:3]))
    first_fields = {"particle": "particle_inverse_mass", "edge": "edge_stiffness", "triangle": "triangle_particles"}
    counts = {
        kind: np.array([len(rows.model[name]) for rows in bodies], np.int64) for kind, name in first_fields.items()
    }
    start = {kind: np.append(0, np.cumsum(count)) for kind, count in counts.items()}
    model = model._replace(
        soft_count=len(bodies),
        soft_particle_start=start["particle"],
        soft_edge_start=start["edge"],
        soft_triangle_start=start["triangle"],
        edge_particles=model.edge_particles + np.repeat(start["particle"][:-1], counts["edge"])[:, None],
        triangle_particles=model.triangle_particles + np.repeat(start["particle"][:-1], counts["triangle"])[:, None],
        box_host=hosts,
    )
    model = model._replace(soft_boxes_volume=boxes_volumes(model, hosts))
    return Parts(model, controls, state, rings_of(model, parts.rings.rest_tension.dtype.type), parts.joints)


def particles_of(rows: SoftRows) -> Particles:
    """Return the particles of a soft body."""
    mass, fixed = 1.0 / rows.model["particle_free_inverse_mass"], rows.model["particle_inverse_mass"] == 0.0
    return Particles(mass, rows.state["particle_position"], rows.state["particle_velocity"], fixed)


def remade(
    like: SoftRows, particles: Particles, force: np.ndarray, triangles: np.ndarray, springs: Springs
) -> SoftRows:
    """Return the rows of a body `like` another, of other particles, `force` (n, 3) [N] on them, and triangles (t, 3).

    An open surface stays as thick as it was.
    """
    points, (edges, rest_length, stiffness, tear_at) = particles.position, springs
    length = lengths_of(points, edges)
    thickness = like.model["soft_thickness"]
    if not has_border(len(edges), len(triangles)):
        thickness = np.array([2.0 * signed_volume(points, triangles) / surface_area(points, triangles)])
    known = {
        "particle_free_inverse_mass": 1.0 / particles.mass,
        "particle_inverse_mass": np.where(particles.fixed, 0.0, 1.0 / particles.mass),
        "edge_particles": edges,
        "edge_rest_length": rest_length,
        "edge_stiffness": stiffness,
        "edge_tear_at": tear_at,
        "triangle_particles": triangles,
        "soft_thickness": thickness,
        "soft_edge_length": np.array([length.mean()]),
    }
    state = {"particle_position": points, "particle_velocity": particles.velocity}
    return SoftRows(like.model | known, like.controls | {"particle_force": force}, state)


def moved_joints(before: Parts, after: Parts, number: np.ndarray) -> Parts:
    """Return the parts `after`, with the joints of those `before`, whose soft bodies have another `number` (b,) now.

    Joints keep to the same particle of the body, which may be another particle there.
    """
    joints, old, new = after.joints, before.model.soft_particle_start, after.model.soft_particle_start
    shift = new[number] - old[:-1]

    def body_of(particle: np.ndarray) -> np.ndarray:
        return np.searchsorted(old, particle, side="right") - 1

    particles, hung = joints.joint_particles, body_of(joints.suspension_particles[:, 0])
    on_soft = particles != NOBODY
    moved = np.where(on_soft, particles + np.append(shift, 0)[body_of(particles)], NOBODY)
    spans = np.stack([new[number[hung]], new[number[hung] + 1]], axis=1)
    return after._replace(joints=joints._replace(joint_particles=moved, suspension_particles=spans))


def with_ends_on(before: Parts, after: Parts, was: list[int], now: list[int]) -> Parts:
    """Return the parts `after`, where joints to the bodies that there `was` are on those that there are `now`.

    Each end is where the surface is nearest to its place.
    """
    old, start = before.joints.joint_particles.reshape(-1, 3), before.model.soft_particle_start
    body = np.where(old[:, 0] == NOBODY, NOBODY, np.searchsorted(start, old[:, 0], side="right") - 1)
    moves = np.isin(body, was)
    if not moves.any():
        return after
    joints, spans = after.joints, after.model.soft_triangle_start
    particles, weights = joints.joint_particles.reshape(-1, 3).copy(), joints.joint_weights.reshape(-1, 3).copy()
    places = np.einsum("ij,ijk->ik", weights[moves], before.state.particle_position[old[moves]])
    triangles = np.concatenate([after.model.triangle_particles[spans[body] : spans[body + 1]] for body in now])
    found = closest_on_mesh(places, after.state.particle_position, triangles)
    particles[moves], weights[moves] = triangles[found.triangle], found.weights
    moved = joints._replace(joint_particles=particles.reshape(-1, 6), joint_weights=weights.reshape(-1, 6))
    return after._replace(joints=moved)


def holding_themselves(parts: Parts, bodies: list[int]) -> Parts:
    """Return the parts where `bodies` keep the distance from themselves that they have, or the most that they can."""
    distance = parts.model.soft_self_contact.copy()
    for body in bodies:
        if distance[body]:
            most = distance_of_skin(parts, body, None)
            distance[body] = np.copysign(min(abs(distance[body]), most), distance[body])
    return parts._replace(model=parts.model._replace(soft_self_contact=distance))


def check_may_change(body: Body) -> None:
    """Raise ParameterError where something hangs in a body that is to be changed, or it is not finite."""
    store, model, row = body.store, body.store.model, body.row()
    rows = slice(*model.soft_particle_start[row : row + 2])
    if not all(np.isfinite(array[rows]).all() for array in store.state[:2]):
        raise ParameterError(f"{body!r} has particles that are not finite; put them where they belong")
    if is_open(model, row):
        raise ParameterError(f"{body!r} has torn, and what has holes is neither cut nor joined")
    hangs = store.joints.suspension_particles[:, 0] == rows.start
    if hangs.any():
        title = store.names.title(("suspension", int(np.argmax(hangs))))
        raise ParameterError(f"{title} hangs in {body!r}, by all of its particles; remove it first")


def replace_all(store: Store, parts: Parts, names: Names, *handles: tuple[object, str, int]) -> None:
    """Let a store have these parts and names, all awake, and `handles` the attributes that are theirs, as one."""
    contacts = remembering(without_soft(remembered(store.contacts)), FIRST_ROOM)
    set_together((store, "contents", Contents(parts, names)), (store, "contacts", contacts), *handles)


def _filled(part: Any, bodies: list[dict[str, np.ndarray]]) -> Any:
    """Return a part with the rows of all `bodies`, one after the other."""
    return part._replace(
        **{name: np.concatenate([array[:0], *(rows[name] for rows in bodies)]) for _, name, array in _fields(part)}
    )


def _fields(part: Any) -> list[tuple[str, str, np.ndarray]]:
    """Return the kind, name and array of each field of a Model, Controls or State that soft bodies have rows in."""
    kinds = ((name.split("_")[0], name, value) for name, value in part._asdict().items())
    return [
        each
        for each in kinds
        if each[0] in ("particle", "edge", "triangle", "soft") and not each[1].endswith(("_start", "_count"))
    ]
