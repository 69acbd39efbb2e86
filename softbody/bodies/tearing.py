"""Soft bodies tear where springs are beyond their limits: what a tear makes of a body, and of what falls off."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.bodies.sharing import Particles
from softbody.bodies.soft_rows import (
    SoftRows,
    Springs,
    moved_joints,
    particles_of,
    remade,
    replace_all,
    taken_out,
    with_ends_on,
    with_soft_bodies,
)
from softbody.bodies.store import Store
from softbody.geometry.borders import fans_of_holes, holds_gas
from softbody.geometry.connected import joined
from softbody.geometry.edges import lengths_of, rows_of_edges, triangles_at
from softbody.geometry.polyhedron import signed_volume, surface_area
from softbody.mesh.mesh import unique_edges
from softbody.mesh.tearing import may_part, most_loaded, torn
from softbody.model.arrays import Model


class Tear(NamedTuple):
    """What has become of one body in a step."""

    places: np.ndarray  # (k, 3) [m] where its surface has parted
    bodies: list[int]  # the numbers of its pieces, the largest first, which is the body still


class _Skin(NamedTuple):
    """A surface that has torn."""

    triangles: np.ndarray  # (t, 3)
    origin: np.ndarray  # (m,) vertex of before that each is
    springs: Springs


def may_tear(model: Model) -> np.ndarray:
    """Tell which soft bodies (b,) may tear, or have torn."""
    limited = np.append(model.edge_tear_at != 0.0, False)
    return np.asarray(np.logical_or.reduceat(limited, model.soft_edge_start)[:-1] | has_torn(model))


def has_torn(model: Model) -> np.ndarray:
    """Tell which soft bodies (b,) have torn, all at once; see `is_open`."""
    return np.asarray(2 * np.diff(model.soft_edge_start) > 3 * np.diff(model.soft_triangle_start))


def tear_bodies(store: Store) -> list[Tear]:
    """Let all bodies tear whose springs are beyond their limits; return what has torn."""
    parts, names = store.parts, store.names
    rows, more, tears = taken_out(parts), list[SoftRows](), list[Tear]()
    was, soft_count = list[int](), parts.model.soft_count
    for body in range(soft_count):
        skin = _torn(rows[body])
        if skin is None:
            continue
        places, (first, *others) = _places(rows[body], skin), _pieces(rows[body], skin)
        number = soft_count + len(more)
        rows[body], more = first, more + others
        tears.append(Tear(places, [body, *range(number, number + len(others))]))
        was.append(body)
    if not tears:
        return []
    after = with_soft_bodies(parts, rows + more, parts.model.box_host)
    after = moved_joints(parts, after, np.arange(soft_count))
    for body, tear in zip(was, tears):
        after = with_ends_on(parts, after, [body], tear.bodies)
        for number in tear.bodies[1:]:
            names = names.renamed(("soft", number), names.free_after(names.name(("soft", body))))
    replace_all(store, after, names)
    return tears


def _torn(own: SoftRows) -> _Skin | None:
    """Return how the surface of a body tears, or None."""
    model, points = own.model, own.state["particle_position"]
    edges, triangles, rest = model["edge_particles"], model["triangle_particles"], model["edge_rest_length"]
    length = lengths_of(points, edges)
    limit = model["edge_tear_at"] * rest
    load = np.where(limit > 0.0, length / np.where(limit > 0.0, limit, 1.0), 0.0)
    if not (load > 1.0).any():
        return None
    meets = triangles_at(triangles, edges, len(points))
    parts = may_part(triangles, edges, meets)
    tearing = most_loaded(np.where(parts, load, 0.0), edges, len(points))
    if not len(tearing):
        return None
    tension = model["edge_stiffness"] * np.maximum(length - rest, 0.0)
    pull = np.bincount(edges.ravel(), np.repeat(tension, 2), len(points))
    after, origin = torn(points, triangles, edges, tearing, pull)
    if len(origin) == len(points):
        return None
    return _Skin(after, origin, _springs(own, after, origin, load, meets))


def _springs(own: SoftRows, triangles: np.ndarray, origin: np.ndarray, load: np.ndarray, meets: np.ndarray) -> Springs:
    """Return the springs of a torn surface, see _Skin: those of before, as stiff as they have triangles of them still.

    Of each spring of before, `load` (e,) is 1 at its limit, and of how many triangles it is a side it `meets` (e,):
    half of its stiffness lies in each of two. Near to where the surface has parted, those that are beyond their limit
    wait until they have given way.
    """
    edges = unique_edges(triangles)
    ends = origin[edges]
    row = rows_of_edges(own.model["edge_particles"], len(own.state["particle_position"]), ends[:, 0], ends[:, 1])
    share = triangles_at(triangles, edges, len(origin)) / meets[row]
    limit, has_split = own.model["edge_tear_at"][row], np.bincount(origin) > 1
    waits = (load[row] > 1.0) & (has_split[ends[:, 0]] | has_split[ends[:, 1]])
    return Springs(
        edges,
        own.model["edge_rest_length"][row],
        share * own.model["edge_stiffness"][row],
        np.where(waits, -np.abs(limit), limit),
    )


def _pieces(own: SoftRows, skin: _Skin) -> list[SoftRows]:
    """Return the rows of all pieces, the heaviest first."""
    before, (triangles, origin, springs) = particles_of(own), skin
    points = before.position[origin]
    mass = _masses(before.mass, skin)
    force = own.controls["particle_force"]
    force = force[origin] * (mass / before.mass[origin])[:, None] if len(force) else force
    part = joined(len(origin), springs.edges)
    found = []
    for label in np.unique(part).tolist():
        of_it = part == label
        which, number, its = np.flatnonzero(of_it), np.cumsum(of_it) - 1, of_it[springs.edges[:, 0]]
        numbers, own_springs = number[triangles[of_it[triangles[:, 0]]]], Springs(*(each[its] for each in springs))
        own_springs = own_springs._replace(edges=number[own_springs.edges])
        found.append((which, numbers, _room(points[which], numbers), float(mass[which].sum()), own_springs))
    whole, most, room = sum(each[3] for each in found), max(each[3] for each in found), sum(each[2] for each in found)
    found.sort(key=lambda each: (-round(each[3] / most, 9), *points[each[0]].mean(axis=0).tolist()))
    made = []
    for which, numbers, volume, weight, own_springs in found:
        old = origin[which]
        particles = Particles(mass[which], points[which], before.velocity[old], before.fixed[old])
        rows = remade(own, particles, force[which] if len(force) else force, numbers, own_springs)
        rows.model["soft_mesh_volume"] = own.model["soft_mesh_volume"] * (weight / whole)
        rows.controls["soft_gas"] = own.controls["soft_gas"] * (volume / room if room > 0.0 else 0.0)
        made.append(rows)
    return made


def _room(points: np.ndarray, triangles: np.ndarray) -> float:
    """Return the volume [m³] for gas in an open surface, 0 where it holds none."""
    more, open_area = fans_of_holes(points, triangles)
    volume = signed_volume(points, triangles) + more
    return volume if holds_gas(volume, open_area, surface_area(points, triangles)) else 0.0


def _masses(before: np.ndarray, skin: _Skin) -> np.ndarray:
    """Return the masses (m,) [kg] of all vertices: those that a vertex of before became share its mass.

    They do so by the stiffness of the springs that they have, so that none swings faster than before.
    """
    origin, stiffness = skin.origin, skin.springs.stiffness + np.finfo(float).tiny
    around = np.bincount(skin.springs.edges.ravel(), np.repeat(stiffness, 2), len(origin))
    return np.asarray(around / np.bincount(origin, around)[origin] * before[origin])


def _places(own: SoftRows, skin: _Skin) -> np.ndarray:
    """Return where [m] the vertices are that have split."""
    has_split = np.flatnonzero(np.bincount(skin.origin) > 1)
    return own.state["particle_position"][has_split]
