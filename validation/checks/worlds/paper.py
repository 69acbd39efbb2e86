"""Claims about the paper's own rules, as `World.paper()` has them, end to end."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

import softbody
from softbody import Mesh, OverlapWarning, World
from softbody.bodies import adding
from softbody.collision import impulse
from softbody.collision.boxes import box_ground, single_contact
from softbody.collision.boxes.sat_boxes import PlacedBox
from softbody.collision.paper import paper_response
from softbody.collision.soft import sat_meshes, soft_contacts
from softbody.dynamics import rigid_boxes
from softbody.model import material
from softbody.stepping import move_boxes, step
from validation.cases import corners_of, dented_sphere, random_box_pairs, random_orientations, rotated, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.boxes.impulse import OVERLAP, Impacts, mass_ratio, random_impacts
from validation.checks.boxes.manifold import turned
from validation.fault import Fault

if TYPE_CHECKING:
    from references.paper_contact import Block, Skin

FAMILY = "the paper's own rules"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

STEP = 1e-3  # [s]
GRAVITY = 9.81  # [m/s²]
DEEP = 1e-2  # [m] a contact that is less deep has a way out that rounding turns by as much more
CEILING = 10.0  # [m/s] and [rad/s], of World.paper()
FLOOR = 0.2  # [rad/s], of World.paper()
CLEARLY = 1e-3  # [m] by which one axis parts boxes more than any other


def _cut(rows: np.ndarray) -> np.ndarray:
    """Return vectors (m, 3) cut to the length CEILING."""
    return rows * np.minimum(1.0, CEILING / np.maximum(np.linalg.norm(rows, axis=1), 1e-300))[:, None]


def _fly_and_strike(impacts: Impacts, i: int, axes: str) -> np.ndarray:
    """Return velocities (12,) and positions (6,) [m] of two boxes that a step brings to the pose of an impact."""
    from scipy.spatial.transform import Rotation

    world = World.paper(gravity=(0.0, 0.0, 0.0), axes=axes)
    p = impacts.pairs
    boxes = []
    for k, pose in enumerate([(p.size_a, p.position_a, p.orientation_a), (p.size_b, p.position_b, p.orientation_b)]):
        size, position, orientation = (rows[i] for rows in pose)
        mass = (impacts.mass_a, impacts.mass_b)[k][i]
        v, w = impacts.velocity[k, i], impacts.angular_velocity[k, i]
        turn = (Rotation.from_rotvec(-STEP * w) * Rotation.from_quat(orientation[[1, 2, 3, 0]])).as_quat()[[3, 0, 1, 2]]
        bounce = impacts.restitution[i] if k == i % 2 else 0.0  # the livelier one decides
        heavy = None if np.isinf(mass) else mass
        boxes.append(world.add_box(size, heavy, position - STEP * v, turn, v, w, restitution=bounce, friction=0.5))
    world.step(STEP)
    velocities = [np.concatenate([box.velocity, box.angular_velocity]) for box in boxes]
    return np.concatenate([*velocities, *(box.position for box in boxes)])


@check(
    section="4.1, 4.4, 6",
    piece="softbody.stepping.move_boxes.move_boxes_singly",
    reference="Bullet: the velocities after; closed form: the way back, by inverse mass along Bullet's normal",
    engines=("pybullet", "scipy"),
    unit="of the speed; of the size",
    tolerance=2e-12,
    because="Bullet's own rounding, larger for light boxes struck by heavy ones: 2.3e-13 at worst of ten seeds, 2.9e-13"
    " at full",
    faults=(
        Fault("restitution off by 1e-9", material.normal_impulse, "1.0 + restitution_ → 1.000000001 + restitution_"),
        Fault(
            "one box alone moved back",
            move_boxes.correct_pair,
            "scale(-boxes.inverse_mass[b], shift) → scale(0.0, shift)",
        ),
    ),
)
def boxes_bounce(run: Run) -> Comparison:
    """In World.paper() two boxes that fly and spin until they meet, at a corner, or across edges with all axes, bounce
    as Bullet makes them, cut to the paper's ceilings, and are parted as their masses demand."""
    from references import printed, pybullet

    impacts = random_impacts(run.fresh_rng(), run.count(60, 400, 4_000))
    # No faster than the paper's ceilings before they meet.
    impacts.velocity[:] = _cut(impacts.velocity.reshape(-1, 3)).reshape(impacts.velocity.shape)
    impacts.angular_velocity[:] = _cut(impacts.angular_velocity.reshape(-1, 3)).reshape(impacts.velocity.shape)
    judged = pybullet.one_impact(*impacts.bodies(), restitution=impacts.restitution)
    # Where two axes part boxes almost equally, Bullet may take the other: it adds 1e-5 to cosines, and prefers faces.
    depths = np.sort(-printed.box_separations_by_axis(*impacts.pairs), axis=1)
    single = (judged.count == 1) & (depths[:, 1] > CLEARLY)
    impacts, p, normal = impacts.select(single), impacts.select(single).pairs, judged.normal[single]
    judged_velocities = judged.velocity_a, judged.angular_velocity_a, judged.velocity_b, judged.angular_velocity_b
    after = np.concatenate([_cut(rows[single]) for rows in judged_velocities], axis=1)
    light = 1.0 / np.stack([impacts.mass_a, impacts.mass_b], axis=1)
    share = OVERLAP * light / light.sum(axis=1, keepdims=True)
    expected = [after, p.position_a + share[:, :1] * normal, p.position_b - share[:, 1:] * normal]
    axes = ["complete" if kind.startswith("edge") else "paper" for kind in impacts.kinds]
    measured = [_fly_and_strike(impacts, i, axes[i]) for i in range(len(axes))]
    speed = np.linalg.norm([*impacts.velocity, *impacts.angular_velocity], axis=2).max(axis=0) * mass_ratio(impacts)
    scale = np.concatenate([np.repeat(speed[:, None], 12, axis=1), np.repeat(p.extent[:, None], 6, axis=1)], axis=1)
    notes = [f"{int((~single).sum())} of {len(single)} impacts at several points, or of two axes within 1 mm, left out"]
    return Comparison(measured / scale, np.concatenate(expected, axis=1) / scale, groups=impacts.kinds, notes=notes)


@check(
    section="4.4",
    piece="softbody.collision.boxes.single_contact.paper_contact",
    reference="the paper's formula as printed: one impulse half-way between the centres",
    unit="of the speed that one step of weight gives",
    kind="closed form",
    tolerance=2e-14,
    because="rounding",
    faults=(
        Fault(
            "a contact on the surfaces", single_contact.paper_contact, "point_ if touching == 1 else middle_ → point_"
        ),
    ),
)
def stacks_are_turned(run: Run) -> Comparison:
    """In World.paper() a box that lies on another, off-centre, is turned by it: its one contact is half-way between the
    two boxes, as printed."""
    from references import printed

    rng = run.fresh_rng()
    measured, expected = [], []
    for _ in range(run.count(20, 100, 1_000)):
        lower, upper = np.append(rng.uniform(1.5, 3.0, 2), 0.5), rng.uniform(0.4, 1.0, 3)
        mass, aside = float(rng.uniform(0.5, 5.0)), rng.uniform(-0.4, 0.4, 2)
        height, fall = 0.5 * (lower[2] + upper[2]), GRAVITY * STEP
        world = World.paper(gravity=(0.0, 0.0, -GRAVITY))
        world.add_box(lower, None)
        box = world.add_box(upper, mass, (*aside, height))
        world.step(STEP)
        place = *aside, height - fall * STEP
        turned = printed.support_half_way(upper, mass, place, (0.0, 0.0, -fall), (0.0, 0.0, 0.0))
        measured.append(np.concatenate([box.velocity, box.angular_velocity]) / fall)
        expected.append(np.concatenate(turned) / fall)
    return Comparison(measured, expected)


def _convex_mesh(rng: np.random.Generator) -> Mesh:
    """Return a convex mesh, about half a metre in radius, in a random orientation."""
    meshes = (
        softbody.icosphere(int(rng.integers(1, 3)), 0.5),
        softbody.tetrahedron(0.6),
        softbody.octahedron(0.6),
        softbody.box(rng.uniform(0.5, 1.0, 3), int(rng.integers(1, 4))),
    )
    return rotated(meshes[rng.integers(len(meshes))], rng)


def _overlapping(
    points: np.ndarray, other_points: np.ndarray, rng: np.random.Generator, way: np.ndarray | None = None
) -> np.ndarray:
    """Return how far to move the other points (3,) [m], so that both overlap by 1 to 20 cm along a way, or any."""
    way = rng.normal(size=3) if way is None else way
    way = way / np.linalg.norm(way)
    return ((points @ way).max() - (other_points @ way).min() - rng.uniform(0.01, 0.2)) * way


@check(
    section="4.2, 4.3",
    piece="softbody.collision.paper.paper_response",
    reference="the paper's rules in plain NumPy; libigl: what is inside what, and which triangle is closest",
    engines=("igl",),
    unit="of the speed; of the size",
    tolerance=1e-12,
    because="rounding, over some hundred contacts in turn, and of igl's closest points, 1e-15 over the depth: 1e-13 at"
    " worst of fourteen seeds; what is less deep than a centimetre knows its way out to as much less",
    faults=(
        Fault(
            "all of the depth to side a", paper_response._part, "0.5 if a_ and b_ else 1.0 → 1.0 if a_moves else 0.5"
        ),
        Fault(
            "one corner of a triangle moved",
            paper_response._move,
            "particles_.inverse_mass[i] > 0.0 and not same_ → c == 0",
        ),
        Fault("contacts all at once", step.resolve_soft_contacts, "settings.single_soft_contact → False"),
        Fault("ceilings only before soft contacts", step.step, "limit_speeds(model, state, settings) → 0.0"),
        Fault("restitution off by 1e-9", material.normal_impulse, "1.0 + restitution_ → 1.000000001 + restitution_"),
    ),
)
def soft_contacts_in_turn(run: Run) -> Comparison:
    """In World.paper() soft bodies that meet each other or a box, free or fixed, move on as the paper's rules make
    them: one contact after the other, half of the depth to each side, one impulse of restitution e each; and no box
    leaves them faster than its ceilings."""
    from references.paper_contact import collide

    rng = run.fresh_rng()
    measured, expected, scales, kinds, contacts = [], [], [], [], 0
    for trial in range(run.count(24, 120, 1_000)):
        world = World.paper(gravity=(0.0, 0.0, 0.0))
        e, mass, mesh = rng.random(2), np.exp(rng.uniform(-2.0, 2.0, 2)), _convex_mesh(rng)
        kind = ("soft–soft", "soft–box", "soft–box, fixed")[trial % 3]
        is_thrown = trial % 6 == 1  # the box, beyond its ceilings
        pace, heavier = (30.0, 30.0) if is_thrown else (3.0, 1.0)
        velocity = pace * rng.normal(size=3)
        skin = _fly(world, mesh, heavier * mass[0], np.zeros(3), velocity, e[0])
        if kind == "soft–soft":
            other = _convex_mesh(rng)
            place = _overlapping(mesh.vertices, other.vertices, rng)
            partner = _fly(world, other, mass[1], place, 3.0 * rng.normal(size=3), e[1])
            depths = collide(skin, partner, float(e.max()))
            judged = [skin.velocity, partner.velocity, skin.position, partner.position]
        else:
            weight, way = mass[1] if kind == "soft–box" else None, velocity if is_thrown else None
            block = _fly_box(world, mesh, weight, e[1], rng, way)
            depths = collide(skin, block, float(e.max()))
            cut = _cut(np.array([block.velocity, block.angular_velocity]))
            judged = [skin.velocity, cut, skin.position, block.position[None]]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", OverlapWarning)
            world.step(STEP)
        state = world.state
        spun = state.box_velocity, state.box_angular_velocity
        rows = state.particle_velocity, *spun, state.particle_position, state.box_position
        measured.append(np.concatenate(rows))
        expected.append(np.concatenate(judged))
        kinds += [kind] * len(measured[-1])
        scales += [pace * max(1.0, DEEP / min(depths, default=DEEP))] * len(measured[-1])
        contacts += len(depths)
    return Comparison(
        np.concatenate(measured),
        np.concatenate(expected),
        np.array(scales),
        kinds,
        notes=[f"{contacts} contacts of {trial + 1} pairs"],
    )


def _fly(world: World, mesh: Mesh, mass: float, place: np.ndarray, velocity: np.ndarray, restitution: float) -> Skin:
    """Throw a soft body without springs and gas, whose particles fly straight on; return where a step takes it."""
    from references.paper_contact import Skin

    world.add_soft_body(mesh, mass, 0.0, 0.0, place, velocity, restitution=restitution)
    count = len(mesh.vertices)
    arrived = mesh.vertices + place + STEP * velocity
    return Skin(arrived, np.tile(velocity, (count, 1)), np.full(count, mass / count), mesh.triangles)


def _fly_box(
    world: World,
    mesh: Mesh,
    mass: float | None,
    restitution: float,
    rng: np.random.Generator,
    way: np.ndarray | None = None,
) -> Block:
    """Throw a box that overlaps a mesh, or hold it if it has no mass; return where a step takes it."""
    from references.paper_contact import Block

    size, turn = rng.uniform(0.3, 1.0, 3), random_orientations(rng, 1)[0]
    place = _overlapping(mesh.vertices, corners_of(size) @ rotation_matrix(turn).T, rng, way)
    velocity = np.zeros(3) if mass is None else _cut(3.0 * rng.normal(size=(1, 3)))[0]
    world.add_box(size, mass, place, turn, velocity, restitution=restitution)
    return Block(size, mass or np.inf, place + STEP * velocity, turn, velocity, np.zeros(3))


@check(
    section="4.5",
    piece="softbody.collision.boxes.single_contact.paper_contact",
    reference="six axes as printed, in NumPy; FCL for all axes",
    engines=("fcl",),
    because="random poses are never within rounding of a touch",
    faults=(
        Fault(
            "all axes tried",
            single_contact._contact,
            "box_box_separation(a, b, paper_axes) → box_box_separation(a, b, False)",
        ),
        Fault(
            "faces only",
            single_contact._contact,
            "box_box_separation(a, b, paper_axes) → box_box_separation(a, b, True)",
        ),
    ),
)
def axes_are_those_chosen(run: Run) -> Comparison:
    """In World.paper() boxes move apart if, and only if, their bounding spheres meet and no face normal parts them, as
    the paper's six axes have it; with contact="single" alone if, and only if, they overlap for FCL."""
    from references import fcl, printed

    pairs = random_box_pairs(run.fresh_rng(), run.count(300, 1_000, 10_000))
    by_fcl = fcl.boxes_overlap(*pairs)
    # Where edges part two boxes and no face does, their spheres may be apart: one pair of a thousand.
    apart = np.linalg.norm(pairs.position_a - pairs.position_b, axis=1)
    reach = 0.5 * (np.linalg.norm(pairs.size_a, axis=1) + np.linalg.norm(pairs.size_b, axis=1))
    by_faces = printed.boxes_overlap_by_faces(*pairs) & (apart <= reach)
    measured = []
    for make in (World.paper, lambda **settings: World(contact="single", **settings)):
        for row in zip(*pairs):
            world = make(gravity=(0.0, 0.0, 0.0))
            boxes = [world.add_box(row[k], 1.0, row[k + 1], row[k + 2]) for k in (0, 3)]
            world.step(STEP)
            measured.append(any((box.position != row[3 * k + 1]).any() for k, box in enumerate(boxes)))
    kinds = ["the paper's axes"] * len(by_faces) + ["all axes"] * len(by_fcl)
    return Comparison(np.array(measured), np.concatenate([by_faces, by_fcl]), groups=kinds)


@check(
    section="6",
    piece="softbody.dynamics.rigid_boxes.limit_speeds",
    reference="closed form: v · min(1, 10/|v|), after every step",
    unit="of the ceiling",
    kind="closed form",
    tolerance=2e-15,
    because="rounding of a square root, a quotient and a product in each of five steps: 4e-16 at worst of 2 000 boxes",
    faults=(
        Fault("no ceiling on speeds", rigid_boxes.limit_speeds, "norm(v) > settings.speed_ceiling → False"),
        Fault("no ceiling on spins", rigid_boxes.limit_speeds, "norm(w) > settings.angular_speed_ceiling → False"),
    ),
)
def ceilings_hold(run: Run) -> Comparison:
    """In World.paper() no box flies faster than 10 m/s or spins faster than 10 rad/s: what is faster keeps its
    direction, what is slower all of its velocity, and a falling box goes on at 10 m/s."""
    rng = run.fresh_rng()
    count = run.count(20, 200, 2_000)
    velocity, spin = rng.normal(size=(count, 3)) * 8.0, rng.normal(size=(count, 3)) * 8.0
    world = World.paper()
    for i in range(count):
        world.add_box(rng.uniform(0.1, 1.0, 3), 1.0, (30.0 * i, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), velocity[i], spin[i])
    measured, expected = [], []
    for _ in range(5):
        world.step(0.1)
        velocity = _cut(velocity + [0.0, 0.0, -0.1 * GRAVITY])
        measured += [*world.state.box_velocity.copy(), *world.state.box_angular_velocity.copy()]
        expected += [*velocity, *_cut(spin)]
    return Comparison(measured, expected, CEILING)


@check(
    section="6",
    piece="softbody.dynamics.rigid_boxes.nearest_right_angles",
    reference="SciPy: the nearest element of the octahedral group; closed form: ω t",
    engines=("scipy",),
    unit="rad; of the floor",
    tolerance=3e-15,
    because="rounding of products of quaternions: 3.7e-16 at worst of 6 000 boxes",
    faults=(
        Fault("boxes that snap in the air", rigid_boxes.limit_boxes, "grounded[i] and snaps_ → snaps_"),
        Fault(
            "corners of the group forgotten",
            rigid_boxes.nearest_right_angles,
            "0.5 * (sizes[0] + sizes[1] + sizes[2] + sizes[3]) → 0.0",
        ),
    ),
)
def slow_boxes_snap(run: Run) -> Comparison:
    """In World.paper() a box that touches the ground and turns more slowly than 0.2 rad/s stops and snaps to the
    nearest of the 24 right-angled orientations; one that is in the air, or turns faster, turns on."""
    from scipy.spatial.transform import Rotation

    rng = run.fresh_rng()
    group = Rotation.create_group("O")
    off, kinds = [], []
    for trial in range(run.count(60, 300, 3_000)):
        kind = ("slow, on the ground", "slow, in the air", "fast, on the ground")[trial % 3]
        spin = rng.normal(size=3)
        spin *= (rng.uniform(0.3, 2.0) if kind.startswith("fast") else rng.uniform(0.0, 0.15)) / np.linalg.norm(spin)
        turn = Rotation.from_quat(random_orientations(rng, 1)[0])
        lowest = np.abs(turn.as_matrix()[2]).sum() * 0.5
        # The ground holds nothing here: it is slippery, and no weight presses the box on it.
        world = World.paper(gravity=(0.0, 0.0, 0.0))
        world.add_ground()
        height = lowest + (1.0 if kind.endswith("air") else -1e-3)
        velocity = (0.0, 0.0, 5.0) if kind.endswith("ground") else (0.0, 0.0, 0.0)  # it parts, and is not struck
        box = world.add_box(
            (1.0, 1.0, 1.0), 1.0, (0.0, 0.0, height - STEP * velocity[2]), turn.as_quat()[[3, 0, 1, 2]], velocity, spin
        )
        world.step(STEP)
        now = Rotation.from_quat(box.orientation[[1, 2, 3, 0]])
        flown = Rotation.from_rotvec(STEP * spin) * turn
        if kind == "slow, on the ground":
            nearest = group[int(np.argmin((group * flown.inv()).magnitude()))]
            off.append([(now * nearest.inv()).magnitude(), np.linalg.norm(box.angular_velocity) / FLOOR])
        else:
            off.append([(now * flown.inv()).magnitude(), np.linalg.norm(box.angular_velocity - spin) / FLOOR])
        kinds.append(kind)
    return Comparison(off, np.zeros((len(off), 2)), groups=kinds)


@check(
    section="3, 4",
    piece="softbody.World.paper",
    reference="closed form: v(t) = v(0)",
    unit="of the speed",
    kind="closed form",
    tolerance=2e-14,
    because="rounding over some hundred steps: 3.2e-15 at worst of ten seeds and of 100 worlds",
    faults=(
        Fault(
            "friction all the same",
            adding._properties,
            "properties | (none_ if store.settings.frictionless else {}) → properties",
        ),
    ),
)
def nothing_rubs(run: Run) -> Comparison:
    """In World.paper() nothing rubs, whatever friction it was given: a box on the ground and soft bodies on the ground
    and on a box slide on at their speeds for half a second."""
    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for _ in range(run.count(4, 20, 100)):
        world, (mu, e) = World.paper(), rng.random(2)
        world.add_ground(friction=0.5 + mu)
        speeds = rng.uniform(-3.0, 3.0, (3, 2))
        size = rng.uniform(0.3, 1.0, 3)
        world.add_box(size, 1.0, (0.0, 0.0, 0.5 * size[2]), velocity=(*speeds[0], 0.0), friction=0.9)
        world.add_box((4.0, 4.0, 0.3), None, (9.0, 0.0, 0.15), friction=0.9)
        mesh = rotated(softbody.icosphere(2, 0.5), rng)
        balls = [
            world.add_soft_body(mesh, 1.0, 300.0, 20.0, place, (*speed, 0.0), friction=0.9, restitution=e)
            for place, speed in (((-9.0, 0.0, 0.6), speeds[1]), ((9.0, 0.0, 0.9), speeds[2]))
        ]
        world.run(0.5, 0.5 * world.stable_time_step())
        measured += [world.state.box_velocity[0, :2].copy(), *(ball.velocities.mean(axis=0)[:2] for ball in balls)]
        expected += [*speeds]
        kinds += ["box on the ground", "soft body on the ground", "soft body on a box"]
    return Comparison(measured, expected, 1.0, kinds)


@check(
    section="4.2, 4.4",
    piece="softbody.collision.boxes.box_ground.bounce_box, softbody.collision.paper.paper_response",
    reference="closed forms: Newton's restitution and Coulomb's friction at one point, with its inverse effective mass",
    engines=("scipy",),
    kind="closed form",
    unit="of the speed",
    tolerance=5e-14,
    because="rounding of products of some ten factors: 2.5e-15 at worst of ten seeds",
    faults=(
        Fault("impulses of the ground that are not summed", box_ground.bounce_box, "impulse[k_] += change_ → pass"),
        Fault(
            "friction of slippery ones alone",
            paper_response._bounce,
            "contacts.friction[k] > 0.0 → 1.0 > contacts.friction[k] > 0.0",
        ),
        Fault("a ground that moves", impulse.velocity_of_point, "return 0.0, 0.0, 0.0 → return 0.0, 1.0, 0.0"),
    ),
)
def friction_is_coulombs(run: Run) -> Comparison:
    """In World.paper(frictionless=False) friction is Coulomb's: a box that strikes the ground with a corner, and
    particles that strike a fixed box, straight or aslant, lose as much of their sliding as the impulse times μ takes
    away, all of it at most."""
    from scipy.spatial.transform import Rotation

    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for trial in range(run.count(40, 200, 2_000)):
        e, rough, speed = rng.random(2) * (trial % 3 > 0), rng.uniform(0.1, 2.0, 2), rng.uniform(0.5, 3.0)
        mu, bounce, h = float(np.sqrt(rough.prod())), float(e.max()), STEP
        slide = np.zeros(2) if trial % 4 == 3 else rng.normal(size=2) * rng.choice([0.1, 2.0])
        velocity = np.array([*slide, -speed])
        world = World.paper(
            frictionless=False, gravity=(0.0, 0.0, 0.0), speed_ceiling=np.inf, angular_speed_ceiling=np.inf,
            angular_speed_floor=0.0,
        )  # fmt: skip
        if trial % 2:
            # A heap of particles over a fixed box, of which one comes in.
            mesh, mass = softbody.tetrahedron(rng.uniform(0.5, 1.0)), 1.0
            lowest = int(mesh.vertices[:, 2].argmin())
            tilt = Rotation.align_vectors([(0.0, 0.0, -1.0)], [mesh.vertices[lowest]])[0]
            mesh = Mesh(mesh.vertices @ tilt.as_matrix().T, mesh.triangles)
            height = -mesh.vertices[lowest, 2] + 0.5 * speed * h
            world.add_box((4.0, 4.0, 1.0), None, (0.0, 0.0, -0.5), restitution=e[0], friction=rough[0])
            body = world.add_soft_body(
                mesh, mass, 0.0, 0.0, (0.0, 0.0, height), velocity, restitution=e[1], friction=rough[1]
            )
            world.step(h)
            kept = np.maximum(0.0, 1.0 - mu * (1.0 + bounce) * speed / np.maximum(np.linalg.norm(slide), 1e-300))
            after = np.tile(velocity, (4, 1))
            after[lowest] = [*(kept * slide), bounce * speed]
            measured += [*(body.velocities / np.linalg.norm(velocity))]
            expected += [*(after / np.linalg.norm(velocity))]
            kinds += ["particles on a fixed box"] * 4
            continue
        world.add_ground(restitution=e[0], friction=rough[0])
        size, mass, turn = rng.uniform(0.3, 1.0, 3), np.exp(rng.uniform(-2.0, 2.0)), Rotation.random(random_state=rng)
        arms = turn.apply(corners_of(size))
        arm = arms[arms[:, 2].argmin()]
        if np.sort(arms[:, 2])[1] - arm[2] < 2.0 * speed * h:
            continue  # another corner comes in, too
        box = world.add_box(
            size, mass, (0.0, 0.0, -arm[2] + 0.5 * speed * h), turn.as_quat(scalar_first=True), velocity,
            restitution=e[1], friction=rough[1],
        )  # fmt: skip
        world.step(h)
        square = size**2
        inverse = turn.as_matrix() @ np.diag(12.0 / (mass * (square.sum() - square))) @ turn.as_matrix().T
        cross = np.cross(arm, np.eye(3))  # rows: r × x, r × y, r × z
        yields = np.eye(3) / mass + cross @ inverse @ cross.T  # velocity of the corner per impulse
        push = np.array([0.0, 0.0, (1.0 + bounce) * speed / yields[2, 2]])
        sliding = (velocity + yields @ push)[:2]
        along = np.array([*sliding, 0.0]) / np.linalg.norm(sliding)
        rubbed = np.minimum(mu * push[2], np.linalg.norm(sliding) / (along @ yields @ along))
        total = push - rubbed * along
        measured.append(np.hstack([box.velocity, box.angular_velocity]) / np.linalg.norm(velocity))
        expected.append(np.hstack([velocity + total / mass, inverse @ np.cross(arm, total)]) / np.linalg.norm(velocity))
        kinds.append("corner on the ground")
    width = np.array([np.pad(row, (0, 6 - len(row))) for row in measured])
    return Comparison(width, np.array([np.pad(row, (0, 6 - len(row))) for row in expected]), groups=kinds)


@check(
    section="4.4",
    piece="softbody.collision.boxes.box_ground.bounce_box",
    reference="sixteen rounds of impulses over the corners below, in the core's order, then friction, in NumPy",
    kind="specification",
    unit="of the speed",
    tolerance=1e-12,
    because="rounding of two hundred impulses",
    faults=(
        Fault("corners at the ground, too", box_ground.bounce_box, "corner[2] < height → corner[2] <= height"),
        Fault("all corners", box_ground.bounce_box, "corner[2] < height → corner[2] < height + 100.0"),
        Fault("eight rounds", box_ground.bounce_box, "BOX_ROUNDS → BOX_ROUNDS // 8"),
    ),
)
def corners_below_the_ground(run: Run) -> Comparison:
    """In World.paper(frictionless=False) the ground stops the corners of a box that are below it, and no others: a box
    that comes down upright, aslant and sliding, until its upper corners are exactly at the ground, or a little above or
    below, is stopped and rubbed at the lower four, or at all eight."""
    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for trial in range(run.count(30, 120, 1_200)):
        sunk = ("exactly", "less", "more")[trial % 3]
        e, rough = rng.random(2) * (trial % 2), rng.uniform(0.1, 1.0, 2)
        world = World.paper(
            frictionless=False, gravity=(0.0, 0.0, 0.0), speed_ceiling=np.inf, angular_speed_ceiling=np.inf,
            angular_speed_floor=0.0,
        )  # fmt: skip
        world.add_ground(restitution=e[0], friction=rough[0])
        size, mass = rng.integers(8, 33, 3) / 32.0, 2.0 ** rng.integers(-2, 3)
        h, slide, speed = 2.0**-10, rng.normal(size=2), rng.integers(8, 65) / 16.0
        off = {"exactly": 0.0, "less": 2.0**-12, "more": -(2.0**-12)}[sunk]
        velocity = np.array([*slide, -speed])
        place = np.array([0.0, 0.0, -0.5 * size[2] + off + speed * h])
        box = world.add_box(size, mass, place, velocity=velocity, restitution=e[1], friction=rough[1])
        world.step(h)
        measured.append(np.hstack([box.velocity, box.angular_velocity]) / speed)
        expected.append(
            np.hstack(stopped(size, mass, velocity, off, float(e.max()), float(np.sqrt(rough.prod())))) / speed
        )
        kinds.append(f"sunk by {sunk} {'than ' if off else ''}its height")
    return Comparison(np.array(measured), np.array(expected), groups=kinds)


def stopped(
    size: np.ndarray, mass: float, velocity: np.ndarray, top: float, bounce: float, mu: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return v and ω of an upright box after it has met the ground, whose upper corners are `top` [m] above that."""
    v, w, impulses = velocity.copy(), np.zeros(3), np.zeros(8)
    inverse = 12.0 / (mass * ((size**2).sum() - size**2))
    arms = np.array([[x, y, z] for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)]) * size
    below = [k for k in range(8) if arms[k, 2] - 0.5 * size[2] + top < 0.0]

    def push(k: int, impulse: np.ndarray) -> None:
        nonlocal v, w
        v, w = v + impulse / mass, w + inverse * np.cross(arms[k], impulse)

    def give(k: int, way: np.ndarray) -> float:
        turn = np.cross(arms[k], way)
        return float(1.0 / mass + turn @ (inverse * turn))

    up = np.array([0.0, 0.0, 1.0])
    for _ in range(16):
        for k in below:
            lack = bounce * -velocity[2] - (v + np.cross(w, arms[k]))[2]
            change = np.maximum(-impulses[k], lack / give(k, up))
            impulses[k] += change
            push(k, change * up)
    for k in below:
        sliding = (v + np.cross(w, arms[k])) * (1.0, 1.0, 0.0)
        speed = np.linalg.norm(sliding)
        if impulses[k] > 0.0 and speed > 0.0:
            along = sliding / speed
            push(k, -np.minimum(mu * impulses[k], speed / give(k, along)) * along)
    return v, w


@check(
    section="6",
    piece="softbody.stepping.move_boxes.move_boxes",
    reference="closed form: the yaw is 0, or what it was",
    kind="closed form",
    unit="rad",
    tolerance=5e-15,
    because="rounding of an angle: 2.3e-16 at worst of ten seeds",
    faults=(
        Fault(
            "what holds a box taken for the ground",
            move_boxes.move_boxes,
            "contacts_.box[k_, 1] == NOBODY and contacts_.impulse[k_, 2] > 0.0 → contacts.impulse[k, 2] > 0.0",
        ),
        Fault(
            "ground that is near",
            move_boxes.move_boxes,
            "contacts_.box[k_, 1] == NOBODY and contacts_.impulse[k_, 2] > 0.0 → contacts.box[k, 1] == NOBODY",
        ),
    ),
)
def only_the_ground_makes_snap(run: Run) -> Comparison:
    """Where spins have a floor, and contacts are solved together, a box that the ground holds snaps to right angles;
    one that another box holds, or that the ground will not reach in the step, does not."""
    rng = run.fresh_rng()
    off, kinds = [], []
    for trial in range(run.count(30, 150, 1_500)):
        kind = ("on the ground", "on a plate", "over the ground")[trial % 3]
        world = World(gravity=(0.0, 0.0, 0.0), angular_speed_floor=0.2)
        world.add_ground()
        size, yaw, speed = rng.uniform(0.2, 1.0, 3), rng.uniform(0.05, 0.7), rng.uniform(0.5, 2.0)
        floor = 0.0
        if kind == "on a plate":
            floor = rng.uniform(0.1, 1.0)
            world.add_box((4.0, 4.0, floor), None, (0.0, 0.0, 0.5 * floor))
        # What flies level comes no lower, but is looked at: it might have come so far.
        velocity = (speed, 0.0, 0.0) if kind == "over the ground" else (0.0, 0.0, -speed)
        turn = np.cos(0.5 * yaw), 0.0, 0.0, np.sin(0.5 * yaw)
        height = floor + 0.5 * size[2] + rng.uniform(0.1, 0.9) * speed * STEP
        box = world.add_box(size, 1.0, (0.0, 0.0, height), turn, velocity)
        world.step(STEP, 2 if floor or kind == "on the ground" else 1)
        w, x, y, z = box.orientation
        off.append(np.hypot(np.hypot(x, y), 2.0 * np.arctan2(z, w) - (0.0 if kind == "on the ground" else yaw)))
        kinds.append(kind)
    return Comparison(off, np.zeros(len(off)), groups=kinds)


@check(
    section="4, 4.3, 4.5",
    piece="softbody.collision.soft.sat_meshes.faces_part",
    reference='the same world with pairs="grid"',
    unit="m",
    kind="the core in another form",
    least=2,
    tolerance=0.0,
    because="a test that only saves work changes nothing",
    faults=(
        Fault(
            "bodies parted by any face that all of the other lies before",
            sat_meshes._is_beyond,
            "farthest < nearest_ → True",
        ),
    ),
)
def early_outs_change_nothing(run: Run) -> Comparison:
    """Trying all pairs of bodies, and the normals of all their faces, as in the paper, changes no bit of a world: soft
    spheres, dented ones, tori and boxes that fall on each other."""
    measured: list[np.ndarray] = []
    expected: list[np.ndarray] = []
    for _ in range(run.count(2, 8, 40)):
        rng_seed = int(run.fresh_rng().integers(1 << 30)) + len(measured)
        for rows, pairs in ((measured, "exhaustive"), (expected, "grid")):
            rng = np.random.default_rng(rng_seed)
            world = World.paper(pairs=pairs)
            world.add_ground()
            for i in range(5):
                mesh = (softbody.icosphere(1, 0.5), softbody.torus(0.6, 0.2, 12, 8), dented_sphere(2, 0.6))[i % 3]
                place = (*rng.uniform(-0.3, 0.3, 2), 1.0 + 1.9 * i)
                world.add_soft_body(rotated(mesh, rng), 1.0, 300.0, 20.0, place, (0.0, 0.0, -3.0 * i))
            world.add_box(rng.uniform(0.3, 0.6, 3), 2.0, (0.0, 0.0, 10.5), velocity=(0.0, 0.0, -9.0))
            world.run(0.8, 2e-3)
            rows.append(np.concatenate([world.state.particle_position.ravel(), world.state.box_position.ravel()]))
    return Comparison(measured, expected)


@check(
    section="4.4, 6",
    piece="softbody.stepping.move_boxes.collide_boxes",
    reference="closed form: free flight; the law of restitution",
    unit="of the speed",
    kind="closed form",
    tolerance=5e-15,
    because="whole multiples of powers of two, so that what touches does so exactly; of what bounces, rounding: 2.5e-16"
    " at worst",
    faults=(
        Fault("an impulse between boxes that touch", move_boxes.collide_boxes, "depth > 0.0 → depth >= 0.0"),
        Fault("hardly any overlap is none", move_boxes.collide_boxes, "depth > 0.0 → depth > 1e-8"),
    ),
)
def touching_is_not_overlap(run: Run) -> Comparison:
    """In World.paper() boxes that a step brings to touch each other exactly, face to face, fly on; those that it brings
    a billionth of a metre into each other bounce off."""
    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for trial in range(run.count(24, 120, 1_200)):
        step, deeper, axis = 2.0**-7, trial % 2, np.eye(3)[trial // 2 % 3]
        world = World.paper(gravity=(0.0, 0.0, 0.0))
        sizes, speed = 0.25 * rng.integers(2, 9, (2, 3)), 0.25 * rng.integers(1, 9, 2)
        mass, bounce = rng.uniform(0.5, 2.0, 2), rng.random()
        place = 0.25 * rng.integers(-8, 9, 3)
        apart = 0.5 * sizes.sum(axis=0) @ axis + step * speed.sum() - deeper * 2.0**-30
        world.add_box(sizes[0], mass[0], place, velocity=speed[0] * axis, restitution=bounce)
        world.add_box(sizes[1], mass[1], place + apart * axis, velocity=-speed[1] * axis, restitution=0.0)
        world.step(step)
        after = np.array([speed[0], -speed[1]])
        if deeper:
            impulse = (1.0 + bounce) * speed.sum() / (1.0 / mass).sum()
            after += impulse / mass * (-1.0, 1.0)
        measured.append(world.state.box_velocity / speed.sum())
        expected.append(after[:, None] * axis / speed.sum())
        kinds.append("overlap" if deeper else "touch")
    return Comparison(np.array(measured).reshape(-1, 6), np.array(expected).reshape(-1, 6), groups=kinds)


@check(
    section="4.2, 4.3, 6",
    piece="softbody.model.settings.PAPER",
    reference="closed form: free flight",
    unit="of the speed",
    kind="closed form",
    tolerance=0.0,
    because="nothing acts, so that velocities keep every bit",
    faults=(
        Fault("contacts of edges", soft_contacts.find_soft_contacts, "settings.edge_contacts → True"),
        Fault("steps that are split", step.run, "settings.split_steps and model.soft_count > 0 → model.soft_count > 0"),
    ),
)
def unseen_by_the_paper(run: Run) -> Comparison:
    """What the paper does not look for, World.paper() does not see: an edge of a soft body across an edge of a box or
    of another soft body, and a ball that leaps over a plate within a step, fly on."""
    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for trial in range(run.count(12, 60, 600)):
        kind = ("edge across a box's edge", "edge across an edge", "leap over a plate")[trial % 3]
        world = World.paper(gravity=(0.0, 0.0, 0.0))
        thin, long = rng.uniform(0.1, 0.3, 2), rng.uniform(1.0, 2.0, 2)
        speed = rng.uniform(0.1, 2.0)
        # A bar along x, standing on an edge, comes down on a bar along y that does, too.
        bar = softbody.box((long[0], thin[0], thin[0]), 1)
        turn = rotation_matrix(np.array([np.cos(np.pi / 8), np.sin(np.pi / 8), 0.0, 0.0]))
        height = np.sqrt(0.5) * thin.sum() - rng.uniform(0.1, 0.5) * thin.min()
        if kind == "leap over a plate":
            speed, height = rng.uniform(60.0, 100.0), 0.02 + thin[0]  # 0.6 m in the step, past 0.3 of bar and plate
            world.add_box((2.0, 2.0, 0.02), None)
        elif kind == "edge across an edge":
            lower = softbody.box((thin[1], long[1], thin[1]), 1)
            other = rotation_matrix(np.array([np.cos(np.pi / 8), 0.0, np.sin(np.pi / 8), 0.0]))
            world.add_soft_body(Mesh(lower.vertices @ other.T, lower.triangles), 1.0, 0.0, 0.0)
        else:
            world.add_box(
                (thin[1], long[1], thin[1]), 1.0, (0.0, 0.0, 0.0), (np.cos(np.pi / 8), 0.0, np.sin(np.pi / 8), 0.0)
            )
        body = world.add_soft_body(
            Mesh(bar.vertices @ turn.T, bar.triangles), 1.0, 0.0, 0.0, (0.0, 0.0, height), (0.0, 0.0, -speed)
        )
        world.step(1e-2 if kind == "leap over a plate" else STEP)
        measured += [*body.velocities / speed]
        expected += [(0.0, 0.0, -1.0)] * len(body.velocities)
        kinds += [kind] * len(body.velocities)
    return Comparison(measured, expected, groups=kinds)


@check(
    section="4.3, 4.5",
    piece="softbody.collision.soft.sat_meshes.faces_part",
    reference="projections of all points on all normals, by NumPy; FCL",
    kind="closed form",
    engines=("fcl",),
    because="yes or no; pairs whose projections are within 1e-9 m of touching are left out",
    faults=(
        Fault(
            "normals of one of the two meshes only",
            sat_meshes.faces_part,
            "_own_faces_part(points, triangles, other_points) or other_"
            " → _own_faces_part(points, triangles, other_points)",
        ),
        Fault(
            "faces that all of the other lies before",
            sat_meshes._is_beyond,
            "farthest < nearest → farthest < nearest + 0.5 * abs(nearest)",
        ),
        Fault(
            "the first half of the faces",
            sat_meshes._own_faces_part,
            "range(triangles.shape[0]) → range(triangles.shape[0] // 2)",
        ),
    ),
)
def faces_part_by_projections(run: Run) -> Comparison:
    """Whether the normal of a face parts two meshes is what NumPy finds by trying all, of convex and dented ones; and
    of convex ones that one parts, FCL says that they are apart."""
    from references import fcl

    rng = run.fresh_rng()
    told, judged, kinds = [], [], []
    shapes = {
        "spheres": (softbody.icosphere(1, 0.5), True),
        "boxes": (softbody.box((1.0, 0.6, 0.4)), True),
        "dented spheres": (dented_sphere(1, 0.6), False),
    }
    for kind, (shape, is_convex) in shapes.items():
        for _ in range(run.count(60, 300, 3_000)):
            away = rng.normal(size=3)
            away *= rng.uniform(0.3, 1.6) / np.linalg.norm(away)
            a, b = rotated(shape, rng), rotated(shape, rng).moved(away)
            gap = _widest_gap(a, b)
            if abs(gap) < 1e-9:
                continue
            told.append(bool(sat_meshes.faces_part(a.vertices, a.triangles, b.vertices, b.triangles)))
            judged.append(gap > 0.0)
            kinds.append(kind)
            if is_convex and told[-1]:
                told.append(False)
                judged.append(fcl.convex_overlap(a.vertices, a.triangles, b.vertices, b.triangles))
                kinds.append(f"{kind}, parted")
    return Comparison(np.array(told), np.array(judged), groups=kinds)


def _widest_gap(a: Mesh, b: Mesh) -> float:
    """Return by how much [m] the best of all faces' normals parts two meshes; below 0: none does."""
    gaps = []
    for mesh in (a, b):
        corners = mesh.vertices[mesh.triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        one, other = a.vertices @ normals.T, b.vertices @ normals.T
        gaps += [one.min(axis=0) - other.max(axis=0), other.min(axis=0) - one.max(axis=0)]
    return float(np.concatenate(gaps).max())


@check(
    section="4.4",
    piece="softbody.collision.boxes.single_contact.box_box_contact",
    reference="closed form: the lowest corner; the middle of a rectangle",
    kind="closed form",
    unit="of the size",
    tolerance=5e-14,
    because="rounding: 1.9e-15 at worst of ten seeds",
    faults=(
        Fault(
            "a point that is not half-way below a corner of the first",
            single_contact._contact,
            "add(point_, scale(0.5 * depth_, normal_)) → add(point, scale(0.505 * depth, normal))",
        ),
        Fault(
            "faces wider by a hundredth on one side",
            single_contact._nearest_in_box,
            "max(local_[2], -0.5 * size_[2]) → max(local[2], -0.505 * size[2])",
        ),
        Fault("the middle of the wider face", single_contact._deepest_point, "add(arm_, aside_) → arm"),
    ),
)
def one_point(run: Run) -> Comparison:
    """The one point in which two boxes touch: half as deep as they are, below the corner of either that is in a face of
    the other; in the middle of what two faces that lie on each other, along any axis, have in common."""
    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for case in range(run.count(60, 300, 3_000)):
        (whole, own), shift = random_orientations(rng, 2), rng.normal(size=3)
        turn = rotation_matrix(whole)
        size_a, size_b = rng.uniform(0.5, 2.0, (2, 3))
        axis, side = case // 2 % 3, rng.choice([-1.0, 1.0])
        up, depth = side * np.eye(3)[axis], rng.uniform(0.01, 0.05)
        if case % 2:  # the face of b lies on that of a, off its middle
            place = rng.uniform(-0.45, 0.45, 3) * (size_a + size_b)
            place[axis] = side * (0.5 * (size_a[axis] + size_b[axis]) - depth)
            low, high = np.maximum(-0.5 * size_a, place - 0.5 * size_b), np.minimum(0.5 * size_a, place + 0.5 * size_b)
            wide = np.delete(high - low, axis)
            if wide.min() < 2.0 * depth:
                continue
            own, middle, kind = np.array([1.0, 0.0, 0.0, 0.0]), 0.5 * (low + high), "face on face"
        else:  # a corner of b is in that face of a, well inside
            corners = corners_of(size_b) @ rotation_matrix(own).T
            heights = np.sort(corners @ up)
            lowest = corners[np.argmin(corners @ up)]
            if heights[1] - heights[0] < 0.3:
                continue
            tip = rng.uniform(-0.2, 0.2, 3) * size_a
            tip[axis] = side * (0.5 * size_a[axis] - depth)
            place, middle, kind = tip - lowest, tip + 0.5 * depth * up, "a corner in a face"
        one = PlacedBox(tuple(size_a), tuple(shift), tuple(whole))
        other = PlacedBox(tuple(size_b), tuple(turn @ place + shift), tuple(turned(whole, own)))
        for pair, sign in (((one, other), -1.0), ((other, one), 1.0)):
            found = single_contact.box_box_contact(*pair)
            measured.append([found[0], *found[1], *found[2]])
            expected.append([depth, *(turn @ middle + shift), *(sign * turn @ up)])
            kinds.append(kind)
    return Comparison(np.array(measured), np.array(expected), groups=kinds)
