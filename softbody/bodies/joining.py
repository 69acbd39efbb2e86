"""Two soft bodies become one: zipped by a tube between two triangles, or glued where they lie on each other.

The gas of both is in it, and the mass, with both momenta. Springs stay as they are; those of the tube are at rest.
Where two springs become one, it has the stiffness and the tension of both.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from softbody.bodies.names import Names
from softbody.bodies.sharing import Particles, with_centre, with_momenta
from softbody.bodies.soft_body import SoftBody
from softbody.bodies.soft_rows import (
    SoftRows,
    Springs,
    check_may_change,
    holding_themselves,
    moved_joints,
    particles_of,
    remade,
    replace_all,
    taken_out,
    with_ends_on,
    with_soft_bodies,
)
from softbody.bodies.store import Store
from softbody.errors import MeshError, ParameterError
from softbody.geometry import closest_on_mesh
from softbody.geometry.edges import lengths_of
from softbody.geometry.polyhedron import signed_volume
from softbody.geometry.self_intersections import self_intersections
from softbody.mesh.mesh import unique_edges
from softbody.mesh.union import glued, zipped
from softbody.mesh.weld import first_at_place
from softbody.model.validation import check_range, shown, vector

LONGEST = 3.0  # times their edges: the tube between two bodies
SAME_IN_BOTH = "soft_liquid_density", "soft_sound_speed", "soft_liquid_drag"


class Joined(NamedTuple):
    """The surface of two bodies that are one."""

    becomes: np.ndarray  # (n,) which of all particles, those of a first, each is now
    triangles: np.ndarray  # (t, 3) of them


def join_bodies(store: Store, a: SoftBody, b: SoftBody, where: ArrayLike | None, within: float | None) -> None:
    """Do what `World.join` says."""
    if (where is None) == (within is None):
        raise ParameterError("give a place where to join them, or within which distance particles become one")
    place = None if where is None else vector(where, "where")
    near = 0.0 if within is None else check_range(within, "within", "m", above=0.0)
    with store.exclusive():
        _check_two(store, a, b)
        parts, rows, first, second = store.parts, taken_out(store.parts), a.row(), b.row()
        both = _together(rows[first], rows[second])
        try:
            joined = _zipped(both, a, b, place) if place is not None else _glued(both, len(a.positions), near)
            made = _rows_of(both, joined)
        except MeshError as error:
            raise ParameterError(f"{a!r} and {b!r} cannot be joined: {error}") from error
        kept = [made if body == first else each for body, each in enumerate(rows) if body != second]
        number = np.arange(len(rows)) - (np.arange(len(rows)) > second)
        number[second] = now = int(number[first])
        hosts = np.append(number, -1)[parts.model.box_host]
        after = moved_joints(parts, with_soft_bodies(parts, kept, hosts), number)
        after = holding_themselves(with_ends_on(parts, after, [first, second], [now]), [now])
        handles = [(each, "_index", int(number[each.index])) for each in store.held() if each.kind == a.kind]
        replace_all(store, after, _names(store.names, number, first, second), *handles)


def _check_two(store: Store, a: SoftBody, b: SoftBody) -> None:
    """Raise ParameterError unless both are soft bodies of the world, two of them, that can be one."""
    for name, body in (("a", a), ("b", b)):
        if not isinstance(body, SoftBody) or body.store is not store:
            raise ParameterError(f"{name} is {shown(body)}, which is no soft body of this world; give a handle of one")
        check_may_change(body)
    if a.row() == b.row():
        raise ParameterError(f"a and b are both {a!r}; give two bodies")
    for field in SAME_IN_BOTH:
        one, other = (float(getattr(store.model, field)[body.row()]) for body in (a, b))
        if one != other:
            name = field.removeprefix("soft_")
            raise ParameterError(f"{name} of {a!r} is {one:g}, and that of {b!r} {other:g}; liquids do not mix")


def _together(a: SoftRows, b: SoftRows) -> SoftRows:
    """Return the rows of both bodies as if of one; what a body has one of is that of a."""
    count = len(a.state["particle_position"])
    merged = []
    for one, other in zip(a, b):
        rows = {
            name: array if name.startswith("soft_") else np.concatenate([array, other[name] + _shift(name, count)])
            for name, array in one.items()
        }
        merged.append(rows)
    both = SoftRows(*merged)
    volumes = both.model["soft_mesh_volume"] + b.model["soft_mesh_volume"]
    gas = both.controls["soft_gas"] + b.controls["soft_gas"]
    return both._replace(model=both.model | {"soft_mesh_volume": volumes}, controls=both.controls | {"soft_gas": gas})


def _shift(field: str, count: int) -> int:
    return count if field in ("edge_particles", "triangle_particles") else 0


def _zipped(both: SoftRows, a: SoftBody, b: SoftBody, place: np.ndarray) -> Joined:
    """Return both bodies with a tube between the triangles of each that are nearest to a `place` (3,) [m]."""
    points, triangles = both.state["particle_position"], both.model["triangle_particles"]
    of_a = int(closest_on_mesh(place[None], a.positions, a.triangles).triangle[0])
    of_b = int(closest_on_mesh(place[None], b.positions, b.triangles).triangle[0])
    rows = zipped(points, triangles, of_a, len(a.triangles) + of_b)
    tube = rows[-6:]
    longest = float(np.linalg.norm(points[tube] - points[np.roll(tube, 1, axis=1)], axis=2).max())
    edge = float(max(both.model["soft_edge_length"][0], b.store.model.soft_edge_length[b.row()]))
    if longest > LONGEST * edge:
        raise MeshError(f"a tube between them there is {longest:.3g} m long, and edges {edge:.3g} m; bring them nearer")
    meets, _ = self_intersections(points, rows, first_at_place(points))
    through = (meets >= len(rows) - 6).any(axis=1)
    if through.any():
        raise MeshError("a tube between them there goes through their skins; give another place")
    return Joined(np.arange(len(points)), rows)


def _glued(both: SoftRows, count: int, near: float) -> Joined:
    """Return both bodies, the first of `count` particles, where triangles that lie on each other are gone."""
    points, triangles = both.state["particle_position"], both.model["triangle_particles"]
    return Joined(*glued(points, triangles, count, near))


def _rows_of(both: SoftRows, joined: Joined) -> SoftRows:
    """Return the rows of the joined body."""
    used, numbers = np.unique(joined.triangles, return_inverse=True)
    triangles, now = numbers.reshape(-1, 3), np.searchsorted(used, joined.becomes)
    now[~np.isin(joined.becomes, used)] = -1  # gone
    force, stays = both.controls["particle_force"], now >= 0
    summed = np.zeros((len(used) if len(force) else 0, 3))
    if len(force):
        np.add.at(summed, now[stays], force[stays])
    particles = _particles(both, now, len(used))
    if not signed_volume(particles.position, triangles) > 0.0:
        raise MeshError("together they have no volume")
    return remade(both, particles, summed, triangles, _springs(both, now, particles.position, triangles))


def _particles(both: SoftRows, now: np.ndarray, count: int) -> Particles:
    """Return the particles of the joined body: those that are glued have the mass of both, at its centre.

    The mass of those that are gone, within what is glued, is shared by all.
    """
    before, stays = particles_of(both), now >= 0
    to, mass = now[stays], np.bincount(now[stays], before.mass[stays], count)
    fixed = np.bincount(to, before.fixed[stays], count) > 0.0
    weight = np.where(fixed[to] & ~before.fixed[stays], 0.0, before.mass[stays])  # what is fixed does not move
    position = _mean(before.position[stays], weight, to, count)
    velocity = np.where(fixed[:, None], 0.0, _mean(before.velocity[stays], weight, to, count))
    if not stays.all():
        mass = with_centre(before, [mass * (before.mass.sum() / mass.sum())], [position])[0]
    after = Particles(mass, position, velocity, fixed)
    return after if len(now) == count else after._replace(velocity=with_momenta(before, after))


def _springs(both: SoftRows, now: np.ndarray, points: np.ndarray, triangles: np.ndarray) -> Springs:
    """Return the springs of the joined body's `triangles` (t, 3) of `points` (n, 3) [m]."""
    edges, size = unique_edges(triangles), len(now) + 1
    length = lengths_of(points, edges)
    old = np.sort(now[both.model["edge_particles"]], axis=1)
    at = np.searchsorted(edges[:, 0] * size + edges[:, 1], old[:, 0] * size + old[:, 1])
    at = np.minimum(at, len(edges) - 1)
    there = (old >= 0).all(axis=1) & (edges[at] == old).all(axis=1)
    weight = both.model["edge_stiffness"][there]
    stiffness = np.bincount(at[there], weight, len(edges))
    is_new = np.bincount(at[there], minlength=len(edges)) == 0
    tear_at = np.zeros(len(edges))
    np.maximum.at(tear_at, at[there], both.model["edge_tear_at"][there])
    return Springs(
        edges,
        np.where(
            is_new, length, _mean(both.model["edge_rest_length"][there, None], weight, at[there], len(edges))[:, 0]
        ),
        np.where(is_new, both.model["edge_stiffness"].mean(), stiffness),
        tear_at,
    )


def _mean(values: np.ndarray, weight: np.ndarray, to: np.ndarray, count: int) -> np.ndarray:
    """Return the means (count, k) of `values` (n, k) by `weight` (n,), of those that come `to` each; of one, it."""
    one = np.zeros(count, np.int64)
    one[to] = np.arange(len(to))
    sums, base = np.zeros((count, values.shape[1])), values[one]
    np.add.at(sums, to, weight[:, None] * (values - base[to]))
    return np.asarray(base + sums / np.maximum(np.bincount(to, weight, count), np.finfo(float).tiny)[:, None])


def _names(names: Names, number: np.ndarray, first: int, second: int) -> Names:
    """Return the names where soft bodies have another `number` (b,): the joined one is called as a, or else as b."""
    name = names.name(("soft", first)) or names.name(("soft", second))
    for body in (first, second):
        names = names.renamed(("soft", body), None)
    moved = names.renumbered(lambda kind, index: int(number[index]) if kind == "soft" else index)
    return moved.renamed(("soft", int(number[first])), name)
