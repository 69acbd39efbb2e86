"""The way out of a body where several would do: at corners and edges that triangles share, and behind faces."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

import softbody
from references import trimesh
from softbody import Mesh
from softbody.collision.soft import edge_mesh, point_mesh
from softbody.collision.soft.edge_mesh import Ridge, edge_across_edge
from softbody.collision.soft.point_mesh import way_out
from softbody.collision.soft.soft_box import find_contacts_in_box
from softbody.collision.soft.surface import Surface, build_surfaces, surface_of
from softbody.geometry import box
from softbody.model.surface_point import value_at
from validation.answers import Answers
from validation.cases import BOX_TRIANGLES, corners_of, random_orientations, rotated, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.boxes.manifold import turned
from validation.checks.soft.cases import weightless
from validation.fault import Fault

FAMILY = "soft bodies that collide"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process


def _dented(rng: np.random.Generator) -> Mesh:
    """Return a ball of which vertex 0 is pushed in, all numbered anyhow."""
    ball = rotated(softbody.icosphere(int(rng.integers(0, 2))), rng)
    count = len(ball.vertices)
    vertices, order = ball.vertices * rng.uniform(0.9, 1.1, (count, 1)), rng.permutation(count)
    vertices[order[0]] *= rng.uniform(0.1, 0.4)
    triangles = np.argsort(order)[rng.permutation(ball.triangles)]
    return Mesh(vertices[order], np.array([np.roll(each, rng.integers(3)) for each in triangles]))


def _surface(mesh: Mesh) -> Surface:
    world = softbody.World()
    world.add_soft_body(mesh, 1.0, 1.0, 0.0)
    found = build_surfaces(world.model, world.state.particle_position)
    return surface_of(world.model, world.state, found.shapes, found.scratch, 0, 0)


@check(
    section="4.3",
    piece="softbody.collision.soft.point_mesh.way_out",
    reference="all triangles that share the point, tried by NumPy",
    kind="exhaustive search",
    unit="of the size; 1 for another triangle",
    tolerance=4e-15,
    because="rounding: 1.6e-16 at worst of ten seeds",
    faults=(
        Fault("a fan about another corner", point_mesh._facing, "weights_[1] != 0.0 → weights[1] == 0.0", nth=1),
        Fault("the triangle that faces the way least", point_mesh._facing_more, "x_ > y_ → x_ < y_"),
        Fault("the next side", point_mesh._facing, "(m_ + 1) % 3 → (m + 2) % 3"),
    ),
)
def reentrant_places(run: Run) -> Comparison:
    """The way out leads to the closest reentrant corner or edge.

    From a point inside. Of all triangles that share the place, the one that faces the way most takes the reaction. It
    does so whichever was found and however they are numbered.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(12, 60, 600)):
        mesh = _dented(rng)
        vertices, triangles, surface = mesh.vertices, mesh.triangles, _surface(mesh)
        corners = vertices[triangles]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        facing = across / np.linalg.norm(across, axis=1, keepdims=True)
        fan = np.flatnonzero((triangles == 0).any(axis=1))
        others = np.setdiff1d(triangles[fan], 0)
        for other in (0, *others[:2]):
            shared, share = fan[(triangles[fan] == other).any(axis=1)], 0.0
            if other == 0:  # below the corner, and before none of its edges
                inward = -vertices[0] + 0.1 * rng.normal(size=3)
                if ((vertices[others] - vertices[0]) @ inward >= 0.0).any():
                    continue
            else:  # below the edge, and before neither of its triangles
                share = rng.uniform(0.2, 0.8)
                inward = -rng.uniform(0.2, 1.0, 2) @ facing[shared]
            place = (1.0 - share) * vertices[0] + share * vertices[other]
            depth = rng.uniform(1e-3, 3e-2)
            p = place + depth * inward / np.linalg.norm(inward)
            best = shared[np.argmax(facing[shared] @ ((place - p) / depth))]
            for triangle in shared:
                named = triangles[triangle]
                weights = np.where(named == 0, 1.0 - share, np.where(named == other, share, 0.0))
                found = way_out(tuple(p), surface, int(triangle), tuple(weights))
                is_best = list(found.end.particles) == triangles[best].tolist()
                way, end = depth * np.array(found.normal), value_at(vertices, found.end)
                kind = "an edge" if other else "a corner"
                answers.add([found.depth, *way, *end, float(is_best)], [depth, *(place - p), *place, 1.0], kind=kind)
    return answers.comparison()


@check(
    section="4.3",
    piece="softbody.collision.soft.point_mesh.way_out_before",
    reference="the closest point of all triangles that face the particle's skin, each by trimesh",
    kind="third-party library",
    engines=("trimesh",),
    unit="of the size",
    tolerance=1e-14,
    because="rounding: 6e-16 at worst at full",
    faults=(
        Fault("ways out by any triangle", point_mesh.way_out_before, "dot(_normal(surface, t), own) < 0.0 → True"),
        Fault("ways out of any length", point_mesh.way_out_before, "farthest * farthest → np.inf"),
        Fault("skins of one triangle", point_mesh.vertex_normal, "other != first → False"),
    ),
)
def ways_out_before_a_skin(run: Run) -> Comparison:
    """A particle leaves by the nearest triangle that faces its skin.

    Its skin's normal is the sum of its triangles' area vectors, of dented balls. Where that triangle is too far away
    there is none.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(12, 60, 600)):
        mesh, own_mesh = _dented(rng), _dented(rng)
        vertices, triangles, surface = mesh.vertices, mesh.triangles, _surface(mesh)
        corners = vertices[triangles]
        facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        own_surface, skins = _surface(own_mesh), np.zeros(own_mesh.vertices.shape)
        a, b, c = np.moveaxis(own_mesh.vertices[own_mesh.triangles], 1, 0)
        for k in range(3):
            np.add.at(skins, own_mesh.triangles[:, k], 0.5 * np.cross(b - a, c - a))
        for vertex, skin in enumerate(skins):
            own = point_mesh.vertex_normal(own_surface, vertex)
            p, farthest = 0.5 * rng.random() * corners[rng.integers(len(corners))].mean(axis=0), rng.uniform(0.1, 1.0)
            before = np.flatnonzero(facing @ skin < 0.0)
            ends = trimesh.closest_on_triangles(np.tile(p, (len(before), 1)), corners[before])
            end = ends[np.argmin(np.linalg.norm(ends - p, axis=1))]
            shared = trimesh.closest_on_triangles(np.tile(end, (len(corners), 1)), corners)
            shared = np.linalg.norm(shared - end, axis=1) < 1e-12
            goes = np.linalg.norm(end - p) <= farthest and (facing[shared] @ (end - p) > 0.0).any()
            depth, normal, _ = point_mesh.way_out_before(tuple(p), own, surface, farthest)
            truth = end - p if goes else np.zeros(3)
            answers.add(depth * np.array(normal), truth, kind="a way" if goes else "none")
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.geometry.box.way_back",
    reference="the face that the way meets first, or that was closest before it, by trimesh",
    kind="third-party library",
    engines=("trimesh",),
    unit="of the size, of a unit vector",
    tolerance=1e-14,
    because="rounding: 0 at worst of 50 000 ways, about the origin",
    faults=(
        Fault(
            "the way out of a box is to the face that is closest now",
            box.way_back,
            "_closest_face(before_, half_) → _closest_face(now, half_)",
        ),
        Fault("the last face on the way", box._face_of_entry, "first > enters → first < enters or enters == -np.inf"),
        Fault("ways that lead away", box._face_of_entry, "0.0 <= enters < leaves → enters < leaves"),
    ),
)
def points_go_back_to_a_box(run: Run) -> Comparison:
    """A point leaves a box by the face it came through.

    However deep it is, right through, or out again by another side. What was inside before leaves by the face that was
    closest then.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(40, 200, 1_000)):
        half, count = rng.uniform(0.1, 1.5, 3), 50
        before, now = (rng.uniform(-1.5, 1.5, (count, 3)) * half for _ in range(2))
        was_in: np.ndarray = np.all(np.abs(before) < half, axis=1)
        corners = corners_of(2.0 * half)
        met, part = trimesh.first_triangles(before, now - before, corners, BOX_TRIANGLES)
        _, closest, _ = trimesh.closest_points(before, corners, BOX_TRIANGLES)
        triangle = np.where(was_in, closest, np.where(part <= 1.0, met, -1))
        a, b, c = np.moveaxis(corners[BOX_TRIANGLES[triangle]], 1, 0)
        out = np.cross(b - a, c - a)
        out /= np.linalg.norm(out, axis=1)[:, None]
        depth = np.where(triangle < 0, 0.0, np.maximum(0.0, np.einsum("ij,ij->i", a - now, out)))
        doubtful = was_in & (np.sort(half - np.abs(before), axis=1)[:, :2] @ [-1.0, 1.0] < 1e-4)  # two as close
        for row in np.flatnonzero(~doubtful):
            found, normal = box.way_back(tuple(before[row]), tuple(now[row]), tuple(half))
            kind = "was inside" if was_in[row] else "came in" if depth[row] > 0.0 else "passed by"
            normals = (normal, out[row] if depth[row] > 0.0 else np.zeros(3))
            answers.add([found / half.max(), *normals[0]], [depth[row] / half.max(), *normals[1]], kind=kind)
    return answers.comparison()


def _ridges(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return (count, 2, 4, 3): two ridges each, of whole numbers, with edges at right angles to one axis.

    Their common perpendicular is along that axis, so that all that decides is without rounding.
    """
    ridges = rng.integers(-2, 3, (count, 2, 4, 3))
    ridges[:, :, 1, 2] = ridges[:, :, 0, 2]
    ridges[:, :, 2:, :2] *= rng.choice([1, 8], (count, 2, 2, 1))  # faces that are almost level
    return ridges


def _crossing(ridges: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return which ridges (n, 2, 4, 3) of whole numbers cross, (n, 6) how, and which just do: at an end, or level."""
    one, other = ridges[:, 0], ridges[:, 1]
    along, along_other = one[:, 1] - one[:, 0], other[:, 1] - other[:, 0]
    across, way = np.cross(along, along_other), other[:, 0] - one[:, 0]
    square = _dots(across, across)
    places = [_dots(way, np.cross(each, across)) for each in (along_other, along)]
    deep = _dots(way, across)
    sign = np.where(deep > 0, 1, -1)
    crosses, just = (square > 0) & (deep != 0), np.zeros(len(ridges), bool)
    for edge, each, out in ((along, one, -sign), (along_other, other, sign)):
        left, right = np.cross(edge, each[:, 2] - each[:, 0]), np.cross(each[:, 3] - each[:, 0], edge)
        sizes = _dots(left, left), _dots(right, right)
        # Bent inwards by a sine of a fiftieth at most, and facing the other one, by the sum of both unit normals.
        fold = _dots(left, each[:, 3] - each[:, 0])
        crosses &= (fold <= 0) | (2500 * fold**2 * _dots(edge, edge) <= sizes[0] * sizes[1])
        by_left, by_right = out * _dots(left, across), out * _dots(right, across)
        crosses &= np.sign(by_left) * by_left**2 * sizes[1] + np.sign(by_right) * by_right**2 * sizes[0] > 0
        for k in (2, 3):
            corner = each[:, k] - each[:, 0]
            rise, reach = out * _dots(corner, across), np.cross(edge, corner)
            # By a tenth of its length at most: sine² = rise² edge² / (square reach²), of whole numbers.
            beyond = 100 * rise**2 * _dots(edge, edge) - square * _dots(reach, reach)
            crosses &= (rise <= 0) | (beyond < 0)
            just |= (rise == 0) | ((rise > 0) & (beyond < 0))
    deep = sign * deep
    for place in places:
        crosses &= (place >= 0) & (place <= square)
        just |= (place == 0) | (place == square)
    root = np.sqrt(np.maximum(1, square))
    how = np.stack([deep / root, *(sign * across.T / root), *(place / root**2 for place in places)], axis=1)
    return crosses, np.where(crosses[:, None], how, 0.0), just


def _dots(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the scalar products (n,) of rows."""
    return (a * b).sum(axis=1)


def _described(ridges: np.ndarray) -> Iterator[tuple[float, ...]]:
    """Yield what the core finds of two ridges (2, 4, 3), for every way to say where each begins and which is first."""
    for swapped, *back in product((False, True), repeat=3):
        rows = [each[[1, 0, 3, 2]] if turn else each for each, turn in zip(ridges.astype(float), back)]
        pair = [Ridge(*(tuple(place) for place in each)) for each in (rows[::-1] if swapped else rows)]
        found = edge_across_edge(pair[0], pair[1], 1e3)
        if found.depth <= 0.0:
            yield (0.0,) * 7
            continue
        places = [found.place, found.other_place][:: -1 if swapped else 1]
        first, second = (1.0 - place if turn else place for place, turn in zip(places, back))
        yield 1.0, found.depth, *(np.array(found.normal) * (-1.0 if swapped else 1.0)), first, second


@check(
    section="beyond the paper",
    piece="softbody.collision.soft.edge_mesh.edge_across_edge",
    reference="the rule of arcs that cross on the Gauss map, with what is closed and what is open, in integers",
    kind="exact arithmetic",
    unit="m",
    tolerance=4e-15,
    because="one root and some products: 1.6e-16 at worst of ten seeds",
    faults=(
        Fault("ends that do not count", edge_mesh.edge_across_edge, "0.0 <= place_ <= square_ → 0.0 <= place < square"),
        Fault(
            "half the slack for its own faces",
            edge_mesh.edge_across_edge,
            "min(x_, y_) < -SLACK → min(x_, y_) < -0.5 * SLACK",
        ),
    ),
)
def ridges_that_just_cross(run: Run) -> Comparison:
    """Ridges of whole numbers cross where exact arithmetic says, however told.

    Many just meet at an end, or have a side that is all but level. They cross as deep and along the normal that they
    do, whichever is named first and from whichever end each is told.
    """
    rng, answers = run.fresh_rng(), Answers()
    for kind in ("at an end, or level", "well", "not"):
        left = run.count(40, 200, 2_000)
        while left > 0:
            ridges = _ridges(rng, 4_000)
            crosses, how, just = _crossing(ridges)
            rows = np.flatnonzero(~crosses if kind == "not" else crosses & (just == (kind != "well")))[:left]
            left -= len(rows)
            for row in rows:
                order = np.roll(np.arange(3), rng.integers(3))  # the axis may be any
                truth = [float(crosses[row]), how[row, 0], *how[row, 1:4][order], *how[row, 4:]]
                for found in _described(ridges[row][:, :, order]):
                    answers.add(found, truth, kind=kind)
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.collision.soft.soft_box.find_contacts_in_box",
    reference="closed form: j = (1 + e) v / Σ w²/m, and what it has led to since",
    kind="closed form",
    unit="of the speed, of the size",
    tolerance=1e-13,
    because="rounding: 5.4e-15 at worst of ten seeds",
    faults=(
        Fault(
            "edges that count as apart",
            find_contacts_in_box,
            "depth > 0.0 and not with_end → depth > 1.0 and not with_end",
        ),
        Fault("edges whose ends are held", find_contacts_in_box, "on_edge(i_, j_, place_) → on_edge(i_, j_, 0.5)"),
    ),
)
def edges_on_a_box(run: Run) -> Comparison:
    """One impulse puts a soft edge back on a box's edge.

    It comes down across it, no corner of either inside the other, and is back on it after the step. The impulse turns
    the speed there into e times it, shared by the lever along the soft edge, acting since they met.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(12, 60, 600)):
        turn = random_orientations(rng, 1)[0]
        axes, h, e = rotation_matrix(turn), 1e-3, float(rng.choice([0.0, rng.random()]))
        # Before all is turned: the upper edge of the box is along y, at 0; the lower edge of the body along x.
        share, depth, speed = rng.uniform(0.2, 0.8), rng.uniform(0.001, 0.01), rng.uniform(11.0, 20.0)
        low = np.array([(-share, 0.0, 0.0), (1.0 - share, 0.0, 0.0)])
        corners = np.concatenate([low, rng.uniform(-0.3, 0.3, (2, 3)) + [(0.0, 1.0, 1.0), (0.0, -1.0, 1.0)]])
        mesh = Mesh(corners @ axes.T, np.array([(0, 2, 1), (1, 3, 0), (2, 0, 3), (3, 1, 2)]))
        world, mass, side = weightless(), rng.uniform(0.5, 2.0), 0.4
        start, fall = (0.0, rng.uniform(-0.5, 0.5), h * speed - depth), np.array((*rng.normal(size=2), -speed))
        body = world.add_soft_body(mesh, mass, 0.0, 0.0, axes @ start, axes @ fall, friction=0.0, restitution=e)
        upright = np.array([np.cos(np.pi / 8), 0.0, np.sin(np.pi / 8), 0.0])
        middle = axes @ (0.0, 0.0, -side * np.sqrt(0.5))
        world.add_box((side, 4.0, side), None, middle, turned(turn, upright), friction=0.0)
        world.step(h)
        second = share - h * fall[0]
        weights = np.array([1.0 - second, second, 0.0, 0.0])
        impulse = (1.0 + e) * speed / (weights**2 / (0.25 * mass)).sum()
        change = np.outer(weights * impulse / (0.25 * mass), (0.0, 0.0, 1.0))
        ago = depth / ((1.0 + e) * speed)
        answers.extend(body.velocities @ axes / speed, (fall + change) / speed, kind="velocity")
        answers.extend(body.positions @ axes, corners + start + h * fall + ago * change, kind="place")
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.World.step, softbody.collision.soft.soft_box.find_contacts_in_box",
    reference="the box as two half-spaces, in NumPy",
    kind="bound",
    unit="of the edge, the deepest of both ends and of the middle",
    tolerance=0.02,
    because="a particle may end a 64th of an edge inside a wall: 0.012; 0.15 where ends alone are held",
    faults=(
        Fault(
            "edges with both ends inside that count as held",
            find_contacts_in_box,
            "outcode_[i_] & outcode_[j_] & ALL_FACES → outcode[i] & outcode[j]",
        ),
    ),
)
def edges_with_both_ends_inside(run: Run) -> Comparison:
    """An edge across a box's side leaves it with both ends inside.

    It starts so deep that each end is behind another face. All of it is out after three seconds.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(6, 20, 200)):
        turn = random_orientations(rng, 1)[0]
        axes, length = rotation_matrix(turn), rng.uniform(0.05, 0.2)
        # Before all is turned: the upper edge of the box is along y, at 0; the lower edge of the body along x.
        share, deep = rng.uniform(0.45, 0.55), length * rng.uniform(0.6, 0.65)
        low = np.array([(-share * length, 0.0, -deep), ((1.0 - share) * length, 0.0, -deep)])
        corners = np.concatenate([low, [(0.0, 1.0, 1.0), (0.0, -1.0, 1.0)]])
        mesh = Mesh(corners @ axes.T, np.array([(0, 2, 1), (1, 3, 0), (2, 0, 3), (3, 1, 2)]))
        world, side = weightless(), 0.4
        body = world.add_soft_body(mesh, 1.0, 100.0, 0.0, friction=0.0, drag=2.0)
        upright = np.array([np.cos(np.pi / 8), 0.0, np.sin(np.pi / 8), 0.0])
        middle_of_box = axes @ (0.0, 0.0, -side * np.sqrt(0.5))
        world.add_box((side, 4.0, side), None, middle_of_box, turned(turn, upright), friction=0.0)
        world.run(3.0)
        one, other = (body.positions @ axes)[:2]
        middle = one - one[0] / (other[0] - one[0]) * (other - one)
        inside = [-(abs(place[0]) + place[2]) * np.sqrt(0.5) for place in (one, other)]
        answers.extend(np.maximum(0.0, [*inside, -middle[2]]) / length, np.zeros(3), kind=("end", "end", "middle"))
    return answers.comparison()
