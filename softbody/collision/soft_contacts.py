"""Where do soft bodies touch each other and the boxes, and how are they parted? Paper §4.2, §4.3.

Body by body and pair by pair, in a fixed order; within a pair, particle by particle. Each contact parts what is there
when its turn comes, so that later ones meet the bodies as the earlier ones left them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from softbody.collision.box_soft import part_patch_and_box, point_in_box
from softbody.collision.broad_phase import near_pairs, near_pairs_exhaustive
from softbody.collision.edge_box import edge_in_box
from softbody.collision.fast import spheres_of_bodies
from softbody.collision.material import combined_friction, combined_restitution
from softbody.collision.patch import WHOLE, Corners, patch_point
from softbody.collision.soft_soft import part_particle_and_patch
from softbody.geometry.box import box_corner
from softbody.geometry.parity_grid import COLUMNS_PER_TRIANGLE, ParityGrid, build_parity_grid
from softbody.geometry.penetration import Penetrations, find_penetrations, room_for_penetrations
from softbody.geometry.triangle import area_vector
from softbody.geometry.triangle_tree import TriangleTree, build_triangle_tree
from softbody.jit import jit, jit_lean
from softbody.quaternion import load_quaternion
from softbody.state import Model, RigidBodies, Rules, State
from softbody.vec import Vec, dot, load, norm, normalize, scale, store, sub


class Skin(NamedTuple):
    """What it takes to find what is inside one soft body: filled anew each time that it is asked."""

    grid: ParityGrid
    tree: TriangleTree


class Skins(NamedTuple):
    """The skins of all soft bodies, in arrays that hold one body's rows after another's."""

    grids: ParityGrid
    trees: TriangleTree
    grid_start: np.ndarray  # (b + 1, fields of a ParityGrid) first row of each body in each of its arrays
    tree_start: np.ndarray  # (b + 1, fields of a TriangleTree)
    deepest: np.ndarray  # (1,) [m] of all contacts that were parted since it was last set to 0
    deepest_pair: np.ndarray  # (2,) the bodies of that contact, boxes numbered after soft bodies


def build_skins(model: Model, position: np.ndarray) -> Skins:
    """Return the skins of all soft bodies of a model whose particles are at `position` (n, 3) [m]."""
    tetrahedron = np.eye(4, 3), np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    meshes = [tetrahedron]  # of which no row is kept: it tells what arrays look like where there are no bodies
    for body in range(len(model.gas)):
        first, end = model.particle_start[body : body + 2]
        faces = slice(*model.triangle_start[body : body + 2])
        meshes.append((position[first:end], model.triangles[faces] - first))
    grids, grid_start = _join([build_parity_grid(*mesh) for mesh in meshes])
    trees, tree_start = _join([build_triangle_tree(*mesh) for mesh in meshes])
    return Skins(ParityGrid(*grids), TriangleTree(*trees), grid_start, tree_start, np.zeros(1), np.zeros(2, np.int64))


def _join(parts: list[Any]) -> tuple[list[Any], np.ndarray]:
    """Return each field's arrays in one, those of the first part left out, and where each other part's rows start."""
    joined = [
        np.concatenate([rows[0][:0], *rows[1:]]) if isinstance(rows[0], np.ndarray) else rows[0]
        for rows in zip(*parts, strict=True)
    ]
    lengths = [[len(rows) if isinstance(rows, np.ndarray) else 0 for rows in part] for part in parts]
    lengths[0] = [0] * len(joined)
    return joined, np.cumsum(lengths, axis=0)


@jit
def skin_of(skins: Skins, body: int) -> Skin:
    """Return the skin of one body, which shares its memory with all."""
    grids, first, end = skins.grids, skins.grid_start[body], skins.grid_start[body + 1]
    grid = ParityGrid(
        grids.triangles[first[0] : end[0]],
        True,
        max(1.0, COLUMNS_PER_TRIANGLE * (end[0] - first[0])),
        grids.frame[first[3] : end[3]],
        grids.shape[first[4] : end[4]],
        grids.start[first[5] : end[5]],
        grids.entries[first[6] : end[6]],
        grids.marked[first[7] : end[7]],
        grids.inside[first[8] : end[8]],
        grids.outside[first[9] : end[9]],
        grids.unsorted_column[first[10] : end[10]],
        grids.unsorted_entry[first[11] : end[11]],
        grids.lattice[first[12] : end[12]],
    )
    trees, first, end = skins.trees, skins.tree_start[body], skins.tree_start[body + 1]
    tree = TriangleTree(
        trees.triangles[first[0] : end[0]],
        trees.order[first[1] : end[1]],
        trees.corners[first[2] : end[2]],
        trees.level_start[first[3] : end[3]],
        trees.level_count[first[4] : end[4]],
        trees.boxes[first[5] : end[5]],
        trees.frame[first[6] : end[6]],
    )
    return Skin(grid, tree)


@jit
def collide_soft_bodies(model: Model, state: State, bodies: RigidBodies, skins: Skins, rules: Rules) -> None:
    """Part all soft bodies from each other and from the boxes; velocities and positions are changed.

    Which are near is judged once, by where they are before any is parted.
    """
    soft = model.gas.shape[0]
    centre, radius, is_soft = spheres_of_bodies(model, state)  # boxes part from each other elsewhere
    most = 0
    for body in range(soft):
        most = max(most, model.particle_start[body + 1] - model.particle_start[body])
    found = room_for_penetrations(max(8, most))
    if rules.exhaustive_pairs:
        pairs = near_pairs_exhaustive(centre, radius, is_soft)
    else:
        pairs = near_pairs(centre, radius, is_soft)
    for k in range(pairs.shape[0]):
        a, b = min(pairs[k, 0], pairs[k, 1]), max(pairs[k, 0], pairs[k, 1])
        deepest = 0.0
        if b < soft:
            deepest = _part_soft_bodies(model, state, a, b, skin_of(skins, b), found)
            deepest = max(deepest, _part_soft_bodies(model, state, b, a, skin_of(skins, a), found))
        elif _sphere_may_meet_box(model, state, load(centre, a), radius[a], b - soft):
            deepest = _part_particles_from_box(model, state, bodies, a, b - soft)
            if rules.edge_contacts:
                deepest = max(deepest, _part_edges_from_box(model, state, bodies, a, b - soft))
            corners = _part_corners_from_skin(model, state, bodies, a, b - soft, skin_of(skins, a), found)
            deepest = max(deepest, corners)
        if deepest > skins.deepest[0]:
            skins.deepest[0] = deepest
            skins.deepest_pair[0], skins.deepest_pair[1] = a, b


@jit_lean
def _sphere_may_meet_box(model: Model, state: State, centre: Vec, radius: float, box: int) -> bool:
    """Tell whether no face of a box parts it from a sphere."""
    orientation = load_quaternion(state.box_orientation, box)
    depth, _ = point_in_box(centre, load(model.box_size, box), load(state.box_position, box), orientation)
    return depth >= -radius


@jit
def _part_soft_bodies(model: Model, state: State, a: int, b: int, skin: Skin, found: Penetrations) -> float:
    """Part the particles of a that are inside b from the nearest triangle of b's `skin`; return the depth [m]."""
    first_a, first_b = model.particle_start[a], model.particle_start[b]
    points = state.position[first_a : model.particle_start[a + 1]]
    vertices = state.position[first_b : model.particle_start[b + 1]]
    count = find_penetrations(points, vertices, skin.grid, skin.tree, found)
    if count == 0:
        return 0.0
    restitution = combined_restitution(model.soft_restitution[a], model.soft_restitution[b])
    friction = combined_friction(model.soft_friction[a], model.soft_friction[b])
    arrays = model.inverse_mass, state.position, state.velocity
    return _part_found_particles(first_a, first_b, count, skin.tree.triangles, found, restitution, friction, *arrays)


@jit_lean
def _part_found_particles(
    first_a: int,
    first_b: int,
    count: int,
    triangles: np.ndarray,
    found: Penetrations,
    restitution: float,
    friction: float,
    inverse_mass: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
) -> float:
    """Part the first `count` particles of `found` from the `triangles` closest to them; return the depth [m]."""
    deepest = 0.0
    for row in range(count):
        corners = _corners(triangles, found.triangle[row], first_b)
        weights = load(found.weights, row)
        particle = first_a + found.point[row]
        depth, normal = _way_out(load(position, particle), position, corners, weights)
        deepest = max(deepest, depth)
        if depth > 0.0:
            arrays = inverse_mass, position, velocity
            part_particle_and_patch(particle, corners, weights, normal, depth, restitution, friction, *arrays)
    return deepest


@jit_lean
def _part_particles_from_box(model: Model, state: State, bodies: RigidBodies, body: int, box: int) -> float:
    """Part the particles of a soft body that are inside a box from its closest face; return the depth [m]."""
    deepest = 0.0
    size = load(model.box_size, box)
    orientation = load_quaternion(state.box_orientation, box)
    reach = 0.5 * norm(size)
    restitution = combined_restitution(model.soft_restitution[body], model.box_restitution[box])
    friction = combined_friction(model.soft_friction[body], model.box_friction[box])
    for i in range(model.particle_start[body], model.particle_start[body + 1]):
        p, position = load(state.position, i), load(state.box_position, box)
        if abs(p[0] - position[0]) < reach and abs(p[1] - position[1]) < reach and abs(p[2] - position[2]) < reach:
            depth, normal = point_in_box(p, size, position, orientation)
            deepest = max(deepest, depth)
            if depth > 0.0:
                part_patch_and_box(
                    (i, i, i),
                    WHOLE,
                    box,
                    normal,
                    depth,
                    restitution,
                    friction,
                    model.inverse_mass,
                    state.position,
                    state.velocity,
                    bodies,
                )

    return deepest


@jit_lean
def _part_edges_from_box(model: Model, state: State, bodies: RigidBodies, body: int, box: int) -> float:
    """Part the edges of a soft body that go through a box by the shortest way; return the depth [m]."""
    deepest = 0.0
    size = load(model.box_size, box)
    orientation = load_quaternion(state.box_orientation, box)
    reach = 0.5 * norm(size)
    restitution = combined_restitution(model.soft_restitution[body], model.box_restitution[box])
    friction = combined_friction(model.soft_friction[body], model.box_friction[box])
    arrays = model.inverse_mass, state.position, state.velocity
    for e in range(model.edge_start[body], model.edge_start[body + 1]):
        i, j = model.edges[e, 0], model.edges[e, 1]
        p, q, position = load(state.position, i), load(state.position, j), load(state.box_position, box)
        near = True
        for axis in range(3):
            low, high = min(p[axis], q[axis]), max(p[axis], q[axis])
            near &= (low < position[axis] + reach) & (high > position[axis] - reach)
        if near:
            depth, normal, place = edge_in_box(p, q, size, position, orientation)
            deepest = max(deepest, depth)
            if depth > 0.0:
                weights = (1.0 - place, place, 0.0)
                part_patch_and_box((i, j, j), weights, box, normal, depth, restitution, friction, *arrays, bodies)
    return deepest


@jit
def _part_corners_from_skin(
    model: Model, state: State, bodies: RigidBodies, body: int, box: int, skin: Skin, found: Penetrations
) -> float:
    """Part the corners of a box inside a soft body from the nearest triangle of its `skin`; return the depth [m]."""
    first = model.particle_start[body]
    vertices = state.position[first : model.particle_start[body + 1]]
    size = load(model.box_size, box)
    orientation = load_quaternion(state.box_orientation, box)
    points = np.empty((8, 3))
    for k in range(8):
        store(points, k, box_corner(size, load(state.box_position, box), orientation, k))
    count = find_penetrations(points, vertices, skin.grid, skin.tree, found)
    restitution = combined_restitution(model.soft_restitution[body], model.box_restitution[box])
    friction = combined_friction(model.soft_friction[body], model.box_friction[box])
    arrays = model.inverse_mass, state.position, state.velocity
    return _part_found_corners(
        first, box, size, count, skin.tree.triangles, found, restitution, friction, *arrays, bodies
    )


@jit_lean
def _part_found_corners(
    first: int,
    box: int,
    size: Vec,
    count: int,
    triangles: np.ndarray,
    found: Penetrations,
    restitution: float,
    friction: float,
    inverse_mass: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
    bodies: RigidBodies,
) -> float:
    """Part the first `count` corners of `found` from the `triangles` closest to them; return the depth [m]."""
    deepest = 0.0
    orientation = load_quaternion(bodies.orientation, box)
    for row in range(count):
        corners = _corners(triangles, found.triangle[row], first)
        weights = load(found.weights, row)
        corner = box_corner(size, load(bodies.position, box), orientation, found.point[row])
        depth, normal = _way_out(corner, position, corners, weights)
        deepest = max(deepest, depth)
        if depth > 0.0:
            arrays = inverse_mass, position, velocity
            out = scale(-1.0, normal)
            part_patch_and_box(corners, weights, box, out, depth, restitution, friction, *arrays, bodies)
    return deepest


@jit_lean
def _corners(triangles: np.ndarray, t: int, first: int) -> Corners:
    """Return the particles of triangle `t`, numbered over all bodies; the body's own start at `first`."""
    return first + triangles[t, 0], first + triangles[t, 1], first + triangles[t, 2]


@jit_lean
def _way_out(p: Vec, position: np.ndarray, corners: Corners, weights: Vec) -> tuple[float, Vec]:
    """Return (depth [m], unit normal): from `p` to the point of the patch where it now is, or depth 0 if it is out.

    The way to the closest point is along the triangle's normal, but where that point is on a reentrant edge.
    """
    way = sub(patch_point(position, corners, weights), p)
    depth = norm(way)
    face = area_vector(load(position, corners[0]), load(position, corners[1]), load(position, corners[2]))
    if depth == 0.0 or dot(way, face) <= 0.0:
        return 0.0, normalize(face)
    return depth, scale(1.0 / depth, way)
