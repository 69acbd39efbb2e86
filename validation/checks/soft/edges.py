"""Claims about edges of soft bodies in boxes and across each other: depth, and way out."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from softbody import Mesh, World
from softbody.collision.boxes.sat_boxes import PlacedBox
from softbody.collision.contact import Listing, new_contacts
from softbody.collision.soft import edge_box, edge_mesh, soft_soft
from softbody.collision.soft.edge_box import edge_in_box
from softbody.collision.soft.edge_mesh import Ridge, bits_across, edge_across_edge
from softbody.collision.soft.soft_response import line_meets_triangle
from softbody.geometry.segments import put_segment
from softbody.model.arrays import Particles
from validation.answers import Answers
from validation.cases import ROOF, ROOF_FACES, edge_lengths, random_orientations
from validation.check import Comparison, Run, check
from validation.checks.soft.cases import weightless
from validation.fault import Fault

FAMILY = "soft bodies that collide"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process
check_edges = partial(check, section="beyond the paper")

CORNERS = np.stack(np.meshgrid(*[(-0.5, 0.5)] * 3), axis=-1).reshape(-1, 3)
EDGES = np.unique(np.sort(ROOF_FACES[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0)
LEVEL = np.arcsin(0.1)  # the angle by which a face may be on the wrong side
BENT = 0.02  # sine by which a ridge may be bent inwards and be one
ASIDE = 0.1  # of its depth, by which what crosses may be beside what is inside
LEADS_OUT = 0.1  # sine by which an edge leads out at least from an end that is inside
RIDGE = np.array([2, 5, 1, 3])  # its ends, and the third corners to its left and right
SPIKE_FACES = np.array([(0, 2, 1), (0, 3, 2), (0, 1, 3), (1, 2, 3)])  # the tip is 0
SPIKE_EDGES = np.array([(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)])


@check_edges(
    piece="softbody.collision.soft.edge_box.edge_in_box",
    reference="the nearest facet of their Minkowski difference, by Qhull; the surface of the box",
    kind="third-party library",
    engines=("scipy",),
    unit="of the size, of a unit vector",
    tolerance=2e-13,
    because="Qhull's normals of facets with corners that lie close: 7.1e-15 at worst of three seeds at full",
    faults=(
        Fault("one axis twice", edge_box._reach, "half[1] * abs(axis[1]) → half[1] * abs(axis[0])"),
        Fault("the nearer side of the box", edge_box._crossing, "normal[2] > 0.0 → normal[2] < 0.0"),
        Fault("lengths that are squares", edge_box._crossing, "dot(across, across) → norm(across)"),
        Fault("the face that is farther off", edge_in_box, "(up > down) → (up < down)"),
    ),
)
def edges_in_a_box(run: Run) -> Comparison:
    """An edge leaves a box by the Minkowski difference's nearest facet.

    Told are the depth, the shortest way out, and where the two touch when it has gone that way. If that was beyond the
    box, told is where it comes in. Edges go through sides, faces and the middle, and aside.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(150, 1_500, 15_000)):
        size, place, q = rng.uniform(0.2, 3.0, 3), rng.normal(0.0, 3.0, 3), random_orientations(rng, 1)[0]
        turn = Rotation.from_quat(q, scalar_first=True)
        through, way = rng.uniform(-0.5, 0.5, 3) * size, rng.normal(size=3) * size
        ends = np.array([through - rng.random() * way, through + rng.random() * way]) + rng.normal(0.0, 0.1, 3) * size
        hull = ConvexHull((CORNERS * size - ends[:, None]).reshape(-1, 3), qhull_options="Qt")
        ways = hull.equations[np.unique(hull.equations.round(7), axis=0, return_index=True)[1]]
        depths, unit = np.sort(-ways[:, 3]), size.max() + np.abs(place).max()
        if abs(depths[0]) < 1e-9 or depths[1] - depths[0] < 1e-9:
            continue  # they just touch; or two ways out are as short
        p, end = turn.apply(ends) + place
        edge, box = (tuple(p), tuple(end)), PlacedBox(tuple(size), tuple(place), tuple(q))
        depth, normal, where = edge_in_box(edge, box, edge, box)
        if depths[0] < 0.0 or depth <= 0.0:  # apart, or so it is said
            ours, theirs = (np.maximum(each, 0.0) / unit for each in (depth, depths[0]))
            answers.add([ours, 0.0, 0.0, 0.0, 0.0], [theirs, 0.0, 0.0, 0.0, 0.0], kind="apart")
            continue
        out, off = ways[np.argmin(-ways[:, 3]), :3], []
        # Where they touch once it has gone; or, if that was beyond the box, where it comes in.
        for gone in (depth, 0.0):
            beyond = np.abs(turn.inv().apply(p + where * (end - p) + gone * np.array(normal) - place)) - 0.5 * size
            off.append(np.abs(beyond).min() + np.maximum(beyond, 0.0).sum())
        kind = "through a face" if np.abs(out).max() > 1.0 - 1e-9 else "across a side"
        ours, theirs = [depth / unit, *normal, np.min(off) / unit], [depths[0] / unit, *turn.apply(out), 0.0]
        answers.add(ours, theirs, kind=kind)
    return answers.comparison()


def _edge_through_a_box(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a box's size (3,) [m] and how it is turned, and the ends (2, 3) [m] of an edge through it that it sees."""
    size, box_turn = rng.uniform(0.2, 3.0, 3), random_orientations(rng, 1)[0]
    through, way = rng.uniform(-0.5, 0.5, 3) * size, rng.normal(size=3) * size
    return size, box_turn, np.array([through - rng.random() * way, through + rng.random() * way])


@check_edges(
    piece="softbody.collision.soft.edge_box.edge_in_box",
    reference="the facets of their Minkowski difference once it has gone back, by Qhull: the farthest is 0 away",
    kind="third-party library",
    engines=("scipy",),
    unit="of the size",
    tolerance=1e-14,
    because="rounding: 9.2e-16 at worst at full",
    faults=(
        Fault("sides of a box without an end", edge_in_box, "abs(along_side) <= half[k - 3] → True"),
        Fault("edges without an end", edge_in_box, "0.0 <= where <= 1.0 and x_ → x_"),
        Fault(
            "what is beside a face is behind it",
            edge_box._way_out_by_face,
            "half[k] - (dot(a, normal) + place * rise) → half[k] - min(dot(a, normal), dot(a, normal) + rise)",
        ),
    ),
)
def edges_go_back_to_a_box(run: Run) -> Comparison:
    """An edge that goes back the way it came touches the box.

    However it has moved and turned in a step, it is neither in the box then, nor away from it.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(150, 1_500, 15_000)):
        size, box_turn, ends = _edge_through_a_box(rng)
        turn = Rotation.from_quat(box_turn, scalar_first=True)
        before = ends + rng.normal(0.0, 0.3, 3) * size + rng.normal(0.0, 0.05, (2, 3)) * size
        box = PlacedBox(tuple(size), (0.0, 0.0, 0.0), tuple(box_turn))
        (p, q), (old_p, old_q) = (map(tuple, turn.apply(each)) for each in (ends, before))
        depth, normal, _ = edge_in_box((p, q), box, (old_p, old_q), box)
        out = turn.inv().apply(normal)
        gone, kind = ends + depth * out, "through a face" if np.abs(out).max() > 1.0 - 1e-9 else "across a side"
        hull = ConvexHull((CORNERS * size - gone[:, None]).reshape(-1, 3), qhull_options="Qt")
        answers.add(hull.equations[:, 3].max() / size.max(), 0.0, kind=kind)
    return answers.comparison()


@check_edges(
    piece="softbody.collision.soft.edge_box.edge_in_box",
    reference="the facet by which a straight way leads into their Minkowski difference, by Qhull",
    kind="third-party library",
    engines=("scipy",),
    unit="of a unit vector",
    tolerance=1e-13,
    because="rounding of turns and of Qhull's facets: 1.1e-15 at worst at full",
    faults=(
        Fault(
            "edges leave a box by the shortest way",
            edge_in_box,
            "gap / (gap + overlap) if gap > 0.0 else gap → -overlap",
        ),
    ),
)
def edges_leave_as_they_came(run: Run) -> Comparison:
    """An edge that came in by a face leaves by that.

    It has moved without turning, from beyond the box.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(150, 1_500, 15_000)):
        size, box_turn, ends = _edge_through_a_box(rng)
        turn = Rotation.from_quat(box_turn, scalar_first=True)
        came_from = rng.normal(size=3) * size
        hull = ConvexHull((CORNERS * size - ends[:, None]).reshape(-1, 3), qhull_options="Qt")
        ways = hull.equations[np.unique(hull.equations.round(7), axis=0, return_index=True)[1]]
        gap, overlap = ways[:, :3] @ came_from + ways[:, 3], -ways[:, 3]
        met = np.where(gap > 0.0, gap / (gap + overlap), -1.0)
        first, last = np.sort(met)[-2:]
        if last < 0.0 or last - first < 1e-6:
            continue  # it was in the box before; or came in where two facets meet
        out = ways[np.argmax(met), :3]
        if np.abs(out).max() < 1.0 - 1e-9:
            continue  # across a side, which it may have left since along the edge
        box = PlacedBox(tuple(size), (0.0, 0.0, 0.0), tuple(box_turn))
        (p, q), (old_p, old_q) = (map(tuple, turn.apply(each)) for each in (ends, ends + came_from))
        answers.add(turn.inv().apply(edge_in_box((p, q), box, (old_p, old_q), box)[1]), out)
    return answers.comparison()


@check_edges(
    piece="softbody.collision.soft.edge_mesh.edge_across_edge",
    reference="nearest points of two lines by least squares, sides by determinants, in NumPy",
    kind="closed form",
    unit="of lengths of 1, of a unit vector; 0 or 1",
    tolerance=2e-12,
    because="rounding, of lines at 6° and more, a hundredth apart at least: 1.2e-13 at worst of ten seeds at standard",
    faults=(
        Fault("ways up alone", bits_across, "up | down → up"),
        Fault("no slack", bits_across, "bits_at_most(rise_left, slack_left) → bits_at_most(rise_left, 0.0)"),
        Fault("half as deep", bits_across, "bits_at_most(depth, deepest) → bits_at_most(2.0 * depth, deepest)"),
        Fault("no deeper, the other way round", bits_across, "bits_at_most(-deepest, depth) → 0"),
        Fault(
            "own sides that rise both",
            edge_across_edge,
            "min(x_, y_) < -SLACK → max(x_, y_) < -SLACK",
        ),
        Fault("reentrant ridges of its own", edge_across_edge, "_is_reentrant(along, own_left, own_right) → False"),
        Fault("level ridges from either side", edge_across_edge, "facing_left + facing_right <= 0.0 → False"),
        Fault("own ridges from either side", edge_across_edge, "own_facing[0] + own_facing[1] >= 0.0 → False"),
        Fault("ridges that are none as soon as they are flat", edge_mesh._is_reentrant, "FLAT * x_ * y_ → 0.0"),
        Fault(
            "faces not by their angle",
            edge_mesh._facing,
            "dot(normal, face_left) * norm(face_right) → dot(normal, face_left) * norm(face_left)",
        ),
    ),
)
def ridges_across(run: Run) -> Comparison:
    """Edges of two bodies cross as their lines' nearest points say.

    Which of eight edges cross another body's, how deep, along which way, where, and which of its triangles faces it
    more. Some ridges part. Others miss by an end, by a side that rises, by being reentrant, or by 0.1 per cent of the
    greatest depth asked for.
    """
    rng, answers, asked = run.fresh_rng(), Answers(), []
    for _ in range(run.count(150, 600, 10_000)):
        other, eight = ridges(rng)
        nearest = [crossing_of(one, other) for one in eight]
        depths = np.array([each[0] for each in nearest])
        deepest = float(rng.choice([*depths[depths > 0.0], 1.0]) * rng.choice([0.999, 1.001, 3.0]))
        segments = np.empty((9, 8))
        for lane, one in enumerate(eight.tolist()):
            put_segment(segments, lane, tuple(one[0]), tuple(one[1]))
        bits = bits_across(segments, ridge_of(other), deepest)
        for lane, (one, truth) in enumerate(zip(eight, nearest)):
            row = np.zeros(7)
            if bits >> lane & 1:
                depth, normal, *rest = edge_across_edge(ridge_of(one), ridge_of(other), deepest)
                row = np.array([depth, *normal, *rest]) if depth > 0.0 else row
            answers.add(row, truth if truth[0] <= deepest else np.zeros(7))
            asked.append(np.concatenate([one.ravel(), other.ravel(), [deepest]]))
    return answers.comparison(inputs={"ridges, deepest": np.array(asked)})


def ridge_of(corners: np.ndarray) -> Ridge:
    """Return a ridge of start, end, left and right corner (4, 3)."""
    return Ridge(*(tuple(corner) for corner in corners.tolist()))


def ridges(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return a ridge (4, 3), and eight (8, 4, 3) that hang down across it, most of them; about 1 long."""
    up, along, aside = Rotation.random(random_state=rng).as_matrix()
    place = rng.normal(size=3)

    def ridge(way: np.ndarray, to_left: np.ndarray, down: np.ndarray, middle: np.ndarray) -> np.ndarray:
        part, length = rng.uniform(-0.1, 1.1), rng.uniform(0.5, 2.0)
        start = middle - part * length * way
        kind = rng.choice(["sharp", "flat", "behind"], p=[0.6, 0.25, 0.15])
        level = rng.random(2) < (0.2 if kind == "sharp" else 1.0)  # all but
        rises = rng.random(2) < (1.0 if kind == "behind" else np.where(level, 0.5, 0.1))
        drop = np.where(rises, -1.0, 1.0) * np.where(level, 0.1, 1.0) * rng.uniform(0.05, 1.0, 2)
        side = -1.0 if kind == "behind" else 1.0 if kind == "flat" else rng.choice([1.0, 1.0, 1.0, -1.0])
        sides = side * rng.uniform(0.2, 1.0, 2) * [1.0, -1.0]
        corners = [start + s * to_left + rng.uniform(0.0, length) * way + d * down for s, d in zip(sides, drop)]
        if kind == "flat":  # bent by little, either way
            across, sine = unit_across(way, corners[0] - start), rng.uniform(-0.05, 0.05)
            bent = sine * np.cross(way, across) - np.sqrt(1.0 - sine * sine) * across
            corners[1] = start + rng.uniform(0.2, 1.0) * bent
        return np.array([start, start + length * way, *corners])

    other, eight = ridge(along, aside, -up, place), []
    for _ in range(8):
        turn = rng.uniform(0.1, np.pi - 0.1) * rng.choice([1.0, -1.0])
        way, to_left = np.cos(turn) * along + np.sin(turn) * aside, np.sin(turn) * along - np.cos(turn) * aside
        middle, deep = (
            place + rng.uniform(-0.3, 0.3) * along,
            rng.choice([1.0, 1.0, 1.0, -1.0]) * rng.uniform(0.01, 0.5),
        )
        eight.append(ridge(way, to_left, up, middle - deep * up))
    return other, np.array(eight)


def unit_across(way: np.ndarray, corner: np.ndarray) -> np.ndarray:
    """Return the unit vector (3,) from a line through the origin, at a right angle, towards a corner."""
    across = corner - (corner @ way) / (way @ way) * way
    return across / np.linalg.norm(across)


def normals(way: np.ndarray, left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return the unit normals (2, 3) of both faces of a ridge."""
    faces = np.array([np.cross(way, left), np.cross(right, way)])
    return faces / np.linalg.norm(faces, axis=1)[:, None]


def bend(way: np.ndarray, left: np.ndarray, right: np.ndarray) -> float:
    """Return the sine of the angle by which the right face of a ridge rises above the plane of its left one."""
    up = np.cross(way, left)
    return float(up @ unit_across(way, right) / np.linalg.norm(up))


def crossing_of(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return (7,) depth, way, place on both, and whether the left triangle faces it; 0 if two ridges do not cross."""
    (way, left, right), (other_way, other_left, other_right) = one[1:] - one[0], other[1:] - other[0]
    place, other_place = np.linalg.lstsq(np.stack([way, -other_way], axis=1), other[0] - one[0], rcond=None)[0]
    apart = other[0] + other_place * other_way - one[0] - place * way
    depth = np.linalg.norm(apart)
    normal = apart / depth
    if not (0.0 <= place <= 1.0 and 0.0 <= other_place <= 1.0):
        return np.zeros(7)
    own = [np.arcsin(unit_across(way, corner) @ normal) for corner in (left, right)]
    others = [np.arcsin(unit_across(other_way, corner) @ normal) for corner in (other_left, other_right)]
    if max(others) > LEVEL or min(own) < -LEVEL:
        return np.zeros(7)
    if max(bend(way, left, right), bend(other_way, other_left, other_right)) > BENT:
        return np.zeros(7)
    facing, own_facing = (
        normals(*each) @ normal for each in ((other_way, other_left, other_right), (way, left, right))
    )
    if facing.sum() <= 0.0 or own_facing.sum() >= 0.0:
        return np.zeros(7)
    return np.array([depth, *normal, place, other_place, facing[0] >= facing[1]])


@check_edges(
    piece="softbody.collision.soft.soft_soft.find_soft_soft_contacts",
    reference="nearest points of two lines by least squares, sides by determinants, in NumPy",
    kind="closed form",
    unit="m, of a unit vector; particles, contacts",
    tolerance=2e-12,
    because="rounding, of ridges that are a hundredth deep: 1.3e-13 at worst of twelve seeds at standard",
    faults=(
        Fault("the triangle that faces away", soft_soft._add_crossing, "2 if on_left else 3 → 3 if on_left else 2"),
        Fault(
            "places on the other from its end",
            soft_soft._add_crossing,
            "(1.0 - other_place, other_place, 0.0) → (other_place, 1.0 - other_place, 0.0)",
        ),
        Fault(
            "edges that are across outside",
            soft_soft._add_crossings,
            "crossing.depth > 0.0 and _goes_under(one, edges[lane], crossing, lane, memory) → crossing.depth > 0.0",
        ),
        Fault("edges that are just outside are let go", soft_soft._goes_under, "SLACK * x_ / y_ → 0.0"),
        Fault("a depth's way off", soft_soft.half_way, "0.5 * depth → depth"),
    ),
)
def ridges_in_a_world(run: Run) -> Comparison:
    """Two crooked roofs that overlap by ridges alone hold each ridge once.

    One is upside down across the other, in a World. A ridge is held as deep, that way and there as the nearest points
    of both lines are. It is held half-way between them, by the triangle that faces it more. It is not held at all where
    its place is not inside, and is not so a tenth of the depth beside it either.
    """
    rng, answers = run.fresh_rng(), Answers()
    while len(answers) < 2 * run.count(80, 200, 1_000):
        turn, up = rng.uniform(0.3, 0.7) * np.pi * rng.choice([-1.0, 1.0]), rng.uniform(0.01, 0.06)
        over = Rotation.from_rotvec([np.pi, 0.0, 0.0]) * Rotation.from_rotvec([0.0, 0.0, turn])
        aside = [np.outer(np.arange(6) % 3 == 2, [0.0, y, 0.0]) for y in rng.uniform(-0.3, 0.3, 2)]
        roofs = [ROOF + rng.uniform(-0.08, 0.08, (6, 3)) + each for each in aside]
        roofs[1] = over.apply(roofs[1]) + [0.0, 0.0, 1.0 - up]
        about = Rotation.random(random_state=rng)
        roofs = [about.apply(roof) for roof in roofs]
        nearest = [crossing_of(roofs[k][RIDGE], roofs[1 - k][RIDGE]) for k in range(2)]
        lengths = [edge_lengths(roof, EDGES).mean() for roof in roofs]
        # Of bodies of unlike coarseness only the finer one's edges are asked for, and of a ridge what is inside.
        if not all(0.01 < each[0] < 0.1 for each in nearest) or abs(np.log(lengths[0] / lengths[1])) > 0.1:
            continue
        ways = [roof[5] - roof[2] for roof in roofs]
        places = [roof[2] + near[4] * way for roof, near, way in zip(roofs, nearest, ways)]
        beside = [ASIDE * near[0] * way / np.linalg.norm(way) for near, way in zip(nearest, ways)]
        under = [[below(places[k] + s * beside[k], roofs[1 - k][RIDGE]) for s in (-1.0, 0.0, 1.0)] for k in range(2)]
        if np.abs(under).min() < 1e-6:
            continue
        world = stepped([Mesh(roof, ROOF_FACES) for roof in roofs])
        for k, (depth, *normal, place, other_place, on_left) in enumerate(nearest):
            own, other = 6 * k, 6 * (1 - k)
            third = other + RIDGE[2 if on_left else 3]
            row = [1.0, depth, *normal, *(places[k] + 0.5 * depth * np.array(normal)), place, other_place, third]
            truth = row if max(under[k]) > 0.0 else [0.0] * 11
            answers.add(held(world, (own + 2, own + 5), other), truth, roofs=np.concatenate(roofs).ravel())
    return answers.comparison()


def stepped(meshes: list[Mesh]) -> World:
    """Return a world of soft bodies that has made one short step."""
    world = weightless()
    for mesh in meshes:
        world.add_soft_body(mesh, 1.0, 10.0, 0.0)
    world.step(1e-4)
    return world


def below(point: np.ndarray, ridge: np.ndarray) -> float:
    """Return how far a point (3,) is below the nearer face of a ridge (4, 3), times the face's size [m³]."""
    way, left, right = ridge[1:] - ridge[0]
    return float((np.array([np.cross(way, left), np.cross(right, way)]) @ (ridge[0] - point)).min())


def held(world: World, edge: tuple[int, int], roof: int) -> np.ndarray:
    """Return (11,) how often an edge is held by the ridge of the roof that begins at a particle; the last time, how.

    That is the depth, the normal, the point, the places on edge and ridge, and the third particle of the triangle.
    """
    contacts, found = world.store.contacts, np.zeros(11)
    for row in range(contacts.number[0]):
        particles, weights = contacts.particles[row], contacts.weights[row]
        if sorted(set(particles[0])) == sorted(edge) and list(particles[1, :2]) == [roof + 2, roof + 5]:
            places = weights[0, particles[0] == edge[1]].sum(), weights[1, 1]
            how = contacts.depth[row], *contacts.normal[row], *contacts.point[row], *places, particles[1, 2]
            found = np.array([found[0] + 1.0, *how])
    return found


@check_edges(
    piece="softbody.collision.soft.soft_soft.find_soft_soft_contacts",
    reference="nearest points of two lines by least squares, sides by determinants, the slopes' normals, in NumPy",
    kind="specification",
    unit="m; contacts",
    tolerance=2e-12,
    because="rounding, of ridges that are a hundredth deep",
    faults=(
        Fault(
            "edges that lead out, too",
            soft_soft.find_soft_soft_contacts,
            "count = _drop_those_that_lead_out(one, count, memory) → ",
        ),
        Fault(
            "edges that lead in are dropped",
            soft_soft._drop_those_that_lead_out,
            "out <= x_ → out >= SLACK * norm(along)",
        ),
        Fault("all with an end inside are dropped", soft_soft._drop_those_that_lead_out, "out <= x_ → out == 0.0"),
        Fault("edges along a slope are dropped", soft_soft._drop_those_that_lead_out, "SLACK * norm(along) → 0.0"),
        Fault(
            "a way that is seen from the other end",
            soft_soft._drop_those_that_lead_out,
            "-dot(along, load(memory.way_out, j)) → dot(along, load(memory.way_out, j))",
        ),
    ),
)
def edges_that_lead_out(run: Run) -> Comparison:
    """Of a spike's edges a roof's ridge holds those that lead in.

    The spike is stuck into a crooked roof, its tip beside the ridge. An edge that leads out from the tip, towards the
    nearer slope's outside, is not held besides the tip. One that leads farther in, or out by less than 6°, and passes
    under the ridge, is, as deep as the nearest points of both lines are.
    """
    rng, answers = run.fresh_rng(), Answers()
    left = dict.fromkeys(("leads out", "leads in"), run.count(80, 300, 2_000) // 2)
    while any(left.values()):
        roof = ROOF * (1.0, 2.5, 1.0) + rng.uniform(-0.05, 0.05, (6, 3))  # so flat that what is below a ridge is inside
        # The tip is under a slope, near the ridge; the base is above, and turned anyhow.
        along = rng.uniform(0.3, 0.7)
        tip = (1.0 - along) * roof[2] + along * roof[5] + (0.0, rng.uniform(-0.15, 0.15), -rng.uniform(0.05, 0.25))
        about, high, wide = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.5, 1.2), rng.uniform(0.2, 1.0)
        corners = about + np.arange(3) * 2.0 * np.pi / 3.0
        base = tip + np.column_stack([wide * np.cos(corners), wide * np.sin(corners), np.full(3, high)])
        base += rng.uniform(-0.2, 0.2, (3, 3))
        spike = np.concatenate([[tip], base])
        spike = tip + (spike - tip) * edge_lengths(roof, EDGES).mean() / edge_lengths(spike, SPIKE_EDGES).mean()
        slopes = [(roof[5] - roof[2], roof[1] - roof[2]), (roof[3] - roof[2], roof[5] - roof[2])]
        normals = np.array([np.cross(a, b) / np.linalg.norm(np.cross(a, b)) for a, b in slopes])
        normals *= np.sign(normals[:, 2:])
        depths = normals @ (roof[2] - tip)
        if depths.min() < 0.01 or abs(np.diff(depths)[0]) < 0.01:
            continue
        out, crossing, all_clear = normals[depths.argmin()], [], True
        for k, (one, two) in enumerate(((3, 2), (1, 3), (2, 1)), 1):  # third corners left and right of tip → corner k
            way, near = spike[k] - spike[0], crossing_of(spike[[0, k, one, two]], roof[RIDGE])
            sine = way @ out / np.linalg.norm(way)
            all_clear &= bool(abs(sine - LEADS_OUT) > 1e-3)
            if near[0] > 0.0:
                crossing.append((k, near[0], "leads out" if sine > LEADS_OUT else "leads in"))
                inside = below(spike[0] + near[4] * way, roof[RIDGE]) > 1e-6
                all_clear &= bool(0.01 < near[0] < 0.2 and inside)
        if len(crossing) != 1 or not all_clear or not left[crossing[0][2]]:
            continue
        k, depth, kind = crossing[0]
        left[kind] -= 1
        about_all, spike_first = Rotation.random(random_state=rng), rng.random() < 0.5
        names = rng.permutation(4)  # the numbers of the spike's vertices
        turned_spike = np.empty((4, 3))
        turned_spike[names] = about_all.apply(spike)
        meshes = [Mesh(about_all.apply(roof), ROOF_FACES), Mesh(turned_spike, names[SPIKE_FACES])]
        world = stepped(meshes[::-1] if spike_first else meshes)
        first_spike, first_roof = (0, 4) if spike_first else (6, 0)
        row = held(world, (first_spike + names[0], first_spike + names[k]), first_roof)[:2]
        answers.add(row, [1.0, depth] if kind == "leads in" else [0.0, 0.0], kind=kind)
    return answers.comparison()


@check_edges(
    piece="softbody.collision.soft.soft_response.resolve_contacts",
    reference="three linear equations, by NumPy",
    kind="closed form",
    unit="weights of corners",
    tolerance=1e-10,
    because="lines along the plane: where they meet it is rounded twenty times as much, and more in thin triangles",
    faults=(
        Fault(
            "a cosine that is a hundredth larger",
            line_meets_triangle,
            "ALONG_SURFACE * np.sqrt(s_) → 1.01 * ALONG_SURFACE * np.sqrt(square)",
        ),
        Fault("any line", line_meets_triangle, "ALONG_SURFACE * np.sqrt(s_) → 0.0 * np.sqrt(square)"),
        Fault("weights that do not add up", line_meets_triangle, "w_[0] - u - v → weights[0] - u + v"),
        Fault(
            "a corner as it is now",
            line_meets_triangle,
            "_place(particles, at_particle(corners[2]), time_since) → _place(particles, at_particle(corners[2]), 0.0)",
        ),
    ),
)
def where_pushes_act(run: Run) -> Comparison:
    """A push on a triangle acts where its line meets the plane.

    Both are as they were when it happened. If the line is at a cosine of 0.05 to the normal or less, it acts where they
    touch. Lines are at 0.5, 0.997, 1.003 and 2 to 20 times that, triangles of any shape.
    """
    rng, answers = run.fresh_rng(), Answers()
    while len(answers) < run.count(80, 400, 4_000):
        times = (0.5, 0.997, 1.003, rng.uniform(2.0, 20.0))[len(answers) % 4]
        position, velocity, ago = rng.normal(size=(6, 3)), rng.normal(size=(6, 3)), rng.uniform(0.0, 0.1)
        then = position - ago * velocity
        a, b, c = then[3:]
        up = np.cross(b - a, c - a)
        if np.linalg.norm(up) < 0.3:
            continue
        normal, across = up / np.linalg.norm(up), np.cross(up, rng.normal(size=3))
        sine = 0.05 * times * rng.choice([-1.0, 1.0])
        direction = sine * normal + np.sqrt(1.0 - sine**2) * across / np.linalg.norm(across)
        direction *= 10.0 ** rng.uniform(-3.0, 3.0)
        own, others = rng.dirichlet((1.0, 1.0, 1.0), 2)
        contacts = new_contacts(1)
        contacts.number[0], contacts.box[0] = 1, -1
        contacts.particles[0], contacts.weights[0] = [(0, 1, 2), (3, 4, 5)], [own, others]
        particles = Particles(np.ones(6), position, velocity)
        rows = Listing(*(getattr(contacts, name) for name in Listing._fields))
        found = line_meets_triangle(rows, 0, particles, tuple(direction.tolist()), ago)
        # p + t d = a + v (b − a) + w (c − a)
        _, v, w = np.linalg.solve(np.column_stack([direction, a - b, a - c]), a - own @ then[:3])
        if times < 1.0:
            answers.add(found, others, kind="along the plane")
        else:
            answers.add(found, [1.0 - v - w, v, w], kind="through the plane")
    return answers.comparison()
