"""A soft body is cut by a plane: each piece gets its share of springs, mass, motion, gas and what is inside.

A spring that is cut becomes two, of the same tension and together of the same energy. Springs that are new, along the
cut and in the caps, are at rest as they are. So energy is kept, but for that of motion: mass is shared by area, and a
little of it moves, such that the centre of mass stays. Particles that are new move with those around them, and the
whole such that both momenta stay.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from softbody.bodies.body import Body
from softbody.bodies.sharing import Particles, with_centre, with_momenta
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
from softbody.dynamics.filling import liquid_mass
from softbody.dynamics.liquid_forces import corners_of
from softbody.errors import MeshError, ParameterError
from softbody.geometry import points_in_mesh
from softbody.geometry.edges import lengths_of
from softbody.geometry.polyhedron import signed_volume
from softbody.mesh.mesh import unique_edges
from softbody.mesh.section import NOT, Cut, Plane, cut_surface, pieces_of
from softbody.model.arrays import Model
from softbody.model.validation import check_range, vector


class Piece(NamedTuple):
    """One body of those that a body fell into."""

    vertices: np.ndarray  # (n,) of the Cut
    triangles: np.ndarray  # (t, 3) of them
    rows: np.ndarray  # (t,) triangles of the Cut
    volume: float  # [m³]
    boxes: np.ndarray  # inside it
    room: float  # [m³] for gas and liquid, beside boxes


def cut_body(body: Body, point: ArrayLike, normal: ArrayLike, radius: float) -> list[int]:
    """Do what `SoftBody.cut` says; return the numbers of the pieces."""
    plane, store = _plane(point, normal, radius), body.store
    with store.exclusive():
        row, parts, rows = body.row(), store.parts, taken_out(store.parts)
        check_may_change(body)
        try:
            size = float(parts.model.soft_edge_length[row])
            points, triangles = rows[row].state["particle_position"], rows[row].model["triangle_particles"]
            cut = cut_surface(points, triangles, plane, size)
        except MeshError as error:
            raise ParameterError(f"{body!r} cannot be cut there: {error}") from error
        if cut is None:
            raise ParameterError(f"the plane misses {body!r}; give a point in it, and a radius that reaches around it")
        pieces = _pieces(store, body, cut, plane.normal)
        first, *others = _rows_of_pieces(parts.model, row, rows[row], cut, pieces)
        numbers = [row, *range(len(rows), len(rows) + len(others))]
        hosts = parts.model.box_host.copy()
        for number, piece in zip(numbers, pieces):
            hosts[piece.boxes] = number
        after = with_soft_bodies(parts, [*rows[:row], first, *rows[row + 1 :], *others], hosts)
        after = moved_joints(parts, after, np.arange(len(rows)))
        after = holding_themselves(with_ends_on(parts, after, [row], numbers), numbers)
        names = store.names
        for number in numbers[1:]:
            names = names.renamed(("soft", number), names.free_after(body.name))
        replace_all(store, after, names)
        return numbers


def _plane(point: ArrayLike, normal: ArrayLike, radius: float) -> Plane:
    direction = vector(normal, "normal")
    length = float(np.linalg.norm(direction))
    if not 0.0 < length < np.inf:
        raise ParameterError(f"normal is {direction}; give a direction, of a length above 0")
    if radius != np.inf:
        radius = check_range(radius, "radius", "m", above=0.0)
    return Plane(vector(point, "point"), direction / length, radius)


def _pieces(store: Store, body: Body, cut: Cut, normal: np.ndarray) -> list[Piece]:
    """Return the pieces, the largest first; of equal ones that where the plane's `normal` points."""
    model, row, pieces = store.model, body.row(), []
    boxes = np.flatnonzero(model.box_host == row)
    corners = {int(box): corners_of(model, store.state, int(box)) for box in boxes}
    for rows in pieces_of(cut):
        vertices, numbers = np.unique(cut.triangles[rows], return_inverse=True)
        points, triangles = cut.points[vertices], numbers.reshape(-1, 3)
        inside = [box for box, each in corners.items() if points_in_mesh(each, points, triangles).all()]
        volume = signed_volume(points, triangles)
        room = volume - float(model.box_size[inside].prod(axis=1).sum())
        if not room > 0.0:
            raise ParameterError(f"a piece of {body!r} has no volume; it is turned inside out, or pressed flat, there")
        pieces.append(Piece(vertices, triangles, rows, volume, np.array(inside, np.int64), room))
    lost = set(corners) - {box for piece in pieces for box in piece.boxes.tolist()}
    if lost:
        raise ParameterError(f"the plane goes through {store.names.title(('box', min(lost)))}, inside {body!r}")
    whole = sum(piece.volume for piece in pieces)
    return sorted(
        pieces, key=lambda piece: (-round(piece.volume / whole, 9), -(cut.points[piece.vertices] @ normal).mean())
    )


def _rows_of_pieces(model: Model, row: int, own: SoftRows, cut: Cut, pieces: list[Piece]) -> list[SoftRows]:
    """Return the rows of each piece of a soft body, number `row` of a Model."""
    full = float(own.model["soft_mesh_volume"][0] - own.model["soft_boxes_volume"][0])
    room, mass = sum(piece.room for piece in pieces), np.empty(len(cut.points))
    for piece, each in zip(pieces, _masses(own, cut, pieces, liquid_mass(model, row))):
        mass[piece.vertices] = each
    velocity, fixed = _velocities(own, cut, mass), _is_fixed(own, cut)
    force = _forces(own, cut, mass) if len(own.controls["particle_force"]) else np.zeros((0, 3))
    made = []
    for piece in pieces:
        which, share = piece.vertices, piece.room / room
        particles = Particles(mass[which], cut.points[which], velocity[which], fixed[which])
        springs = _springs(own, cut, which, piece.triangles)
        rows = remade(own, particles, force[which] if len(force) else force, piece.triangles, springs)
        rows.model["soft_mesh_volume"] = np.array([piece.volume - piece.room + share * full])
        rows.controls["soft_gas"] = share * own.controls["soft_gas"]
        made.append(rows)
    return made


def _masses(own: SoftRows, cut: Cut, pieces: list[Piece], liquid: float) -> list[np.ndarray]:
    """Return the masses [kg] of each piece's particles: their centre, and their sum, are those of before.

    A piece has its share of the skin by area, as its triangles are, and of the `liquid` [kg] by room.
    """
    (before, position, _, _), triangles = particles_of(own), own.model["triangle_particles"]
    area = _areas(position, triangles)
    around = np.bincount(triangles.ravel(), np.repeat(area, 3))
    density = (before / np.maximum(around, np.finfo(float).tiny))[triangles].sum(axis=1)
    of_triangle = _areas(cut.points, cut.triangles) * np.where(cut.origin == NOT, 0.0, density[cut.origin])
    skin = np.array([of_triangle[piece.rows].sum() for piece in pieces])
    filling = np.array([piece.room for piece in pieces])
    shares = skin / skin.sum() * (before.sum() - liquid) + filling / filling.sum() * liquid
    likely = _carried(before[:, None], cut, np.full((len(cut.points), 1), before.mean()))[:, 0]
    masses = [likely[piece.vertices] * (share / likely[piece.vertices].sum()) for piece, share in zip(pieces, shares)]
    return with_centre(particles_of(own), masses, [cut.points[piece.vertices] for piece in pieces])


def _velocities(own: SoftRows, cut: Cut, mass: np.ndarray) -> np.ndarray:
    """Return the velocities (n, 3) [m/s] of all vertices of the Cut: within caps those of an affine motion."""
    points, border, within = cut.points, cut.on_cut, cut.ends[:, 0] == NOT
    velocity = _carried(own.state["particle_velocity"], cut, np.zeros((len(points), 3)))
    affine = np.append(points - points[border][0], np.ones((len(points), 1)), axis=1)
    velocity[within] = affine[within] @ np.linalg.lstsq(affine[border], velocity[border], rcond=None)[0]
    return with_momenta(particles_of(own), Particles(mass, points, velocity, _is_fixed(own, cut)))


def _forces(own: SoftRows, cut: Cut, mass: np.ndarray) -> np.ndarray:
    """Return the forces (n, 3) [N] on all vertices of the Cut: those on a particle that is cut are shared by mass."""
    force, old = own.controls["particle_force"], cut.ends[:, 0]
    stays = (cut.ends[:, 1] == old) & (old != NOT)
    shared = np.where(stays, mass, 0.0) / np.bincount(old[stays], mass[stays], len(force))[old]
    return np.asarray(shared[:, None] * force[old])


def _springs(own: SoftRows, cut: Cut, which: np.ndarray, triangles: np.ndarray) -> Springs:
    """Return the springs of `triangles` (t, 3), between vertices (n,) of the Cut, `which`."""
    own_edges, number, old = unique_edges(triangles), len(own.state["particle_position"]), own.model["edge_particles"]
    edges, length = which[own_edges], lengths_of(cut.points[which], own_edges)
    ends = cut.ends[edges].reshape(-1, 4)
    low, high = ends.min(axis=1), ends.max(axis=1)
    keys, key = old[:, 0] * number + old[:, 1], low * number + high
    at = np.minimum(np.searchsorted(keys, key), len(keys) - 1)
    is_part = (low != NOT) & (keys[at] == key) & ((ends == low[:, None]) | (ends == high[:, None])).all(axis=1)
    first, last = cut.ends[edges[:, 0]], cut.ends[edges[:, 1]]
    places = [
        np.where(each[:, 0] == each[:, 1], each[:, 0] == high, cut.way[edges[:, k]])
        for k, each in enumerate((first, last))
    ]
    part = np.where(is_part, np.abs(places[0] - places[1]), 1.0)
    on_both_sides = (part == 1.0) & cut.on_cut[edges].all(axis=1)
    stiffness = own.model["edge_stiffness"][at] / part * np.where(on_both_sides, 0.5, 1.0)
    return Springs(
        own_edges,
        np.where(is_part, own.model["edge_rest_length"][at] * part, length),
        np.where(is_part, stiffness, own.model["edge_stiffness"].mean()),
        np.where(is_part, own.model["edge_tear_at"][at], own.model["edge_tear_at"].min()),
    )


def _is_fixed(own: SoftRows, cut: Cut) -> np.ndarray:
    """Tell which vertices (n,) of the Cut stay in place: those between two that do."""
    fixed = (own.model["particle_inverse_mass"][cut.ends] == 0.0).all(axis=1)
    return np.asarray(fixed & (cut.ends[:, 0] != NOT))


def _carried(values: np.ndarray, cut: Cut, else_: np.ndarray) -> np.ndarray:
    """Return `values` (n, k) of before at the vertices of the Cut, and `else_` within caps."""
    a, b = values[cut.ends[:, 0]], values[cut.ends[:, 1]]
    return np.where(cut.ends[:, :1] == NOT, else_, a + cut.way[:, None] * (b - a))


def _areas(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))
