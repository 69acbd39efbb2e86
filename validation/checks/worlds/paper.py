"""Claims about the paper's own rules, as `World.paper()` has them, end to end."""

from __future__ import annotations

import warnings
from functools import partial
from typing import TYPE_CHECKING, Any

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
from validation.answers import Answers
from validation.cases import corners_of, dented_sphere, random_box_pairs, random_orientations, rotated, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.boxes.impulse import OVERLAP, Impacts, mass_ratio, random_impacts
from validation.checks.boxes.manifold import turned
from validation.checks.worlds.cases import WEIGHTLESS, by_turns, motion_of
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
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
COS, SIN = np.cos(np.pi / 8), np.sin(np.pi / 8)  # of quaternions that turn by an eighth

Rows = tuple[np.ndarray, np.ndarray]  # the core's, and the judge's

check_by_formula = partial(check, kind="closed form")

HELD = "contacts_.box[k_, 1] == NOBODY and contacts_.impulse[k_, 2] > 0.0"  # in move_boxes
BY_AXES = "box_box_separation(a, b, paper_axes)"  # in single_contact
RESTITUTION = Fault(
    "restitution off by 1e-9", material.normal_impulse, "1.0 + restitution_ → 1.000000001 + restitution_"
)


def _weightless(**settings: Any) -> World:
    """Return a world of the paper without gravity."""
    return World.paper(gravity=WEIGHTLESS, **settings)


def _rubbing() -> World:
    """Return one with friction, and without limits to speeds."""
    return _weightless(frictionless=False, speed_ceiling=np.inf, angular_speed_ceiling=np.inf, angular_speed_floor=0.0)


def _cut(rows: np.ndarray) -> np.ndarray:
    """Return vectors (..., 3) cut to the length CEILING."""
    return rows * np.minimum(1.0, CEILING / np.maximum(np.linalg.norm(rows, axis=-1), 1e-300))[..., None]


def _fly_and_strike(impacts: Impacts, i: int, axes: str) -> np.ndarray:
    """Return velocities (12,) and positions (6,) [m] of two boxes that a step brings to the pose of an impact."""
    from scipy.spatial.transform import Rotation

    world, boxes = _weightless(axes=axes), []
    for k, pose in enumerate((impacts.pairs[:3], impacts.pairs[3:])):
        size, position, orientation = (rows[i] for rows in pose)
        mass = (impacts.mass_a, impacts.mass_b)[k][i]
        v, w = impacts.velocity[k, i], impacts.angular_velocity[k, i]
        turn = (Rotation.from_rotvec(-STEP * w) * Rotation.from_quat(orientation[[1, 2, 3, 0]])).as_quat()[[3, 0, 1, 2]]
        bounce = impacts.restitution[i] if k == i % 2 else 0.0  # the livelier one decides
        heavy = None if np.isinf(mass) else mass
        boxes.append(world.add_box(size, heavy, position - STEP * v, turn, v, w, restitution=bounce, friction=0.5))
    world.step(STEP)
    return np.concatenate([*(motion_of(box) for box in boxes), *(box.position for box in boxes)])


@check(
    section="4.1, 4.4, 6",
    piece="softbody.stepping.move_boxes.move_boxes_singly",
    reference="Bullet: the velocities after; closed form: the way back, by inverse mass along Bullet's normal",
    engines=("pybullet", "scipy"),
    unit="of the speed; of the size",
    tolerance=2e-12,
    because="Bullet's own rounding, more of light boxes struck by heavy ones: 2.3e-13 of ten seeds, 2.9e-13 at full",
    faults=(
        RESTITUTION,
        Fault(
            "one box alone moved back",
            move_boxes.correct_pair,
            "scale(-boxes.inverse_mass[b], shift) → scale(0.0, shift)",
        ),
    ),
)
def boxes_bounce(run: Run) -> Comparison:
    """Boxes that fly and spin bounce in World.paper() as Bullet makes them.

    They meet at a corner, or across edges with all axes. Velocities are cut to the paper's ceilings; the boxes are
    parted as their masses demand.
    """
    from references import printed, pybullet

    impacts = random_impacts(run.fresh_rng(), run.count(60, 400, 4_000))
    for rows in (impacts.velocity, impacts.angular_velocity):
        rows[:] = _cut(rows)  # no faster than the paper's ceilings before they meet
    judged = pybullet.one_impact(*impacts.bodies(), restitution=impacts.restitution)
    # Where two axes part boxes almost equally, Bullet may take the other: it adds 1e-5 to cosines, and prefers faces.
    depths = np.sort(-printed.box_separations_by_axis(*impacts.pairs), axis=1)
    single = (judged.count == 1) & (depths[:, 1] > CLEARLY)
    impacts, normal = impacts.select(single), judged.normal[single]
    p, kinds = impacts.pairs, impacts.kinds
    judged_velocities = judged.velocity_a, judged.angular_velocity_a, judged.velocity_b, judged.angular_velocity_b
    light = 1.0 / np.stack([impacts.mass_a, impacts.mass_b], axis=1)
    share = OVERLAP * light / light.sum(axis=1, keepdims=True)
    parted = p.position_a + share[:, :1] * normal, p.position_b - share[:, 1:] * normal
    expected = np.concatenate([*(_cut(rows[single]) for rows in judged_velocities), *parted], axis=1)
    axes = ["complete" if kind.startswith("edge") else "paper" for kind in kinds]
    measured = [_fly_and_strike(impacts, i, axes[i]) for i in range(len(axes))]
    speed = np.linalg.norm([*impacts.velocity, *impacts.angular_velocity], axis=2).max(axis=0) * mass_ratio(impacts)
    scale = np.repeat(np.stack([speed, p.extent], axis=1), (12, 6), axis=1)
    notes = [f"{int((~single).sum())} of {len(single)} impacts at several points, or of two axes within 1 mm, left out"]
    return Comparison(measured / scale, expected / scale, groups=kinds, notes=notes)


@check_by_formula(
    section="4.4",
    piece="softbody.collision.boxes.single_contact.paper_contact",
    reference="the paper's formula as printed: one impulse half-way between the centres",
    unit="of the speed that one step of weight gives",
    tolerance=2e-14,
    because="rounding",
    faults=(
        Fault(
            "a contact on the surfaces", single_contact.paper_contact, "point_ if touching == 1 else middle_ → point_"
        ),
    ),
)
def stacks_are_turned(run: Run) -> Comparison:
    """A box that lies on another off-centre is turned, as printed.

    In World.paper() the one contact of two boxes is half-way between them.
    """
    from references import printed

    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(20, 100, 1_000)):
        lower, upper = np.append(rng.uniform(1.5, 3.0, 2), 0.5), rng.uniform(0.4, 1.0, 3)
        mass, aside = float(rng.uniform(0.5, 5.0)), rng.uniform(-0.4, 0.4, 2)
        height, fall = 0.5 * (lower[2] + upper[2]), GRAVITY * STEP
        world = World.paper(gravity=(0.0, 0.0, -GRAVITY))
        world.add_box(lower, None)
        box = world.add_box(upper, mass, (*aside, height))
        world.step(STEP)
        place = *aside, height - fall * STEP
        judged = printed.support_half_way(upper, mass, place, (0.0, 0.0, -fall), (0.0, 0.0, 0.0))
        answers.add(motion_of(box) / fall, np.concatenate(judged) / fall)
    return answers.comparison()


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
        RESTITUTION,
    ),
)
def soft_contacts_in_turn(run: Run) -> Comparison:
    """Soft bodies in World.paper() meet bodies as the paper's rules say.

    They meet each other or a box, free or fixed: one contact after the other, half of the depth to each side, one
    impulse of restitution e each. No box leaves them faster than its ceilings.
    """
    from references.paper_contact import collide

    rng, answers, contacts, pairs = run.fresh_rng(), Answers(), 0, run.count(24, 120, 1_000)
    for trial, kind in enumerate(by_turns(pairs, "soft–soft", "soft–box", "soft–box, fixed")):
        world = _weightless()
        e, mass, mesh = rng.random(2), np.exp(rng.uniform(-2.0, 2.0, 2)), _convex_mesh(rng)
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
        rows = np.concatenate([state.particle_velocity, *spun, state.particle_position, state.box_position])
        answers.extend(rows, np.concatenate(judged), pace * max(1.0, DEEP / min(depths, default=DEEP)), kind)
        contacts += len(depths)
    return answers.comparison(notes=[f"{contacts} contacts of {pairs} pairs"])


def _fly(world: World, mesh: Mesh, mass: float, place: np.ndarray, velocity: np.ndarray, restitution: float) -> Skin:
    """Throw a soft body without springs and gas, whose particles fly straight on; return where a step takes it."""
    from references.paper_contact import Skin

    world.add_soft_body(mesh, mass, 0.0, 0.0, place, velocity, restitution=restitution)
    count = len(mesh.vertices)
    arrived = mesh.vertices + place + STEP * velocity
    return Skin(arrived, np.tile(velocity, (count, 1)), np.full(count, mass / count), mesh.triangles)


def _fly_box(
    world: World, mesh: Mesh, mass: float | None, restitution: float, rng: np.random.Generator, way: np.ndarray | None
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
        Fault("all axes tried", single_contact._contact, f"{BY_AXES} → box_box_separation(a, b, False)"),
        Fault("faces only", single_contact._contact, f"{BY_AXES} → box_box_separation(a, b, True)"),
    ),
)
def axes_are_those_chosen(run: Run) -> Comparison:
    """Boxes move apart just where none of the chosen axes parts them.

    In World.paper() those are the paper's six, the normals of faces, and bounding spheres must meet, too; with
    contact="single" alone boxes move apart if, and only if, they overlap for FCL.
    """
    from references import fcl, printed

    pairs = random_box_pairs(run.fresh_rng(), run.count(300, 1_000, 10_000))
    # Where edges part two boxes and no face does, their spheres may be apart: one pair of a thousand.
    apart = np.linalg.norm(pairs.position_a - pairs.position_b, axis=1)
    reach = 0.5 * (np.linalg.norm(pairs.size_a, axis=1) + np.linalg.norm(pairs.size_b, axis=1))
    by_faces = printed.boxes_overlap_by_faces(*pairs) & (apart <= reach)
    with_all_axes = partial(World, contact="single", gravity=WEIGHTLESS)
    answers = Answers()
    answers.extend([_move_apart(_weightless(), row) for row in zip(*pairs)], by_faces, kind="the paper's axes")
    answers.extend(
        [_move_apart(with_all_axes(), row) for row in zip(*pairs)], fcl.boxes_overlap(*pairs), kind="all axes"
    )
    return answers.comparison()


def _move_apart(world: World, pair: tuple[np.ndarray, ...]) -> bool:
    """Tell whether a step moves two boxes at rest: the size, position and orientation of a, then of b."""
    boxes = [world.add_box(pair[k], 1.0, pair[k + 1], pair[k + 2]) for k in (0, 3)]
    world.step(STEP)
    return any((box.position != pair[3 * k + 1]).any() for k, box in enumerate(boxes))


@check_by_formula(
    section="6",
    piece="softbody.dynamics.rigid_boxes.limit_speeds",
    reference="closed form: v · min(1, 10/|v|), after every step",
    unit="of the ceiling",
    tolerance=2e-15,
    because="rounding of a square root, a quotient and a product in each of five steps: 4e-16 at worst of 2 000 boxes",
    faults=(
        Fault("no ceiling on speeds", rigid_boxes.limit_speeds, "norm(v) > settings.speed_ceiling → False"),
        Fault("no ceiling on spins", rigid_boxes.limit_speeds, "norm(w) > settings.angular_speed_ceiling → False"),
    ),
)
def ceilings_hold(run: Run) -> Comparison:
    """No box in World.paper() exceeds 10 m/s or 10 rad/s.

    What is faster keeps its direction, what is slower all of its velocity; a falling box goes on at 10 m/s.
    """
    rng, answers, count = run.fresh_rng(), Answers(), run.count(20, 200, 2_000)
    velocity, spin = rng.normal(size=(count, 3)) * 8.0, rng.normal(size=(count, 3)) * 8.0
    world = World.paper()
    for i in range(count):
        world.add_box(rng.uniform(0.1, 1.0, 3), 1.0, (30.0 * i, 0.0, 0.0), UPRIGHT, velocity[i], spin[i])
    for _ in range(5):
        world.step(0.1)
        velocity = _cut(velocity + [0.0, 0.0, -0.1 * GRAVITY])
        answers.extend(world.state.box_velocity.copy(), velocity, CEILING)
        answers.extend(world.state.box_angular_velocity.copy(), _cut(spin), CEILING)
    return answers.comparison()


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
    """Slow boxes on the ground of World.paper() snap to right angles.

    A box that touches the ground and turns more slowly than 0.2 rad/s stops, at the nearest of the 24 right-angled
    orientations. One that is in the air, or turns faster, turns on.
    """
    from scipy.spatial.transform import Rotation

    rng, answers, group = run.fresh_rng(), Answers(), Rotation.create_group("O")
    kinds = "slow, on the ground", "slow, in the air", "fast, on the ground"
    for kind in by_turns(run.count(60, 300, 3_000), *kinds):
        spin = rng.normal(size=3)
        spin *= (rng.uniform(0.3, 2.0) if kind.startswith("fast") else rng.uniform(0.0, 0.15)) / np.linalg.norm(spin)
        turn = Rotation.from_quat(random_orientations(rng, 1)[0])
        lowest = np.abs(turn.as_matrix()[2]).sum() * 0.5
        # The ground holds nothing here: it is slippery, and no weight presses the box on it.
        world = _weightless()
        world.add_ground()
        height = lowest + (1.0 if kind.endswith("air") else -1e-3)
        velocity = (0.0, 0.0, 5.0) if kind.endswith("ground") else (0.0, 0.0, 0.0)  # it parts, and is not struck
        place, q = (0.0, 0.0, height - STEP * velocity[2]), turn.as_quat()[[3, 0, 1, 2]]
        box = world.add_box((1.0, 1.0, 1.0), 1.0, place, q, velocity, spin)
        world.step(STEP)
        now, aim, left = (
            Rotation.from_quat(box.orientation[[1, 2, 3, 0]]),
            Rotation.from_rotvec(STEP * spin) * turn,
            spin,
        )
        if kind == "slow, on the ground":
            aim, left = group[int(np.argmin((group * aim.inv()).magnitude()))], np.zeros(3)
        off = (now * aim.inv()).magnitude(), np.linalg.norm(box.angular_velocity - left) / FLOOR
        answers.add(off, np.zeros(2), kind=kind)
    return answers.comparison()


@check_by_formula(
    section="3, 4",
    piece="softbody.World.paper",
    reference="closed form: v(t) = v(0)",
    unit="of the speed",
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
    """Nothing rubs in World.paper(), whatever friction it was given.

    A box on the ground and soft bodies on the ground and on a box slide on at their speeds for half a second.
    """
    rng, answers = run.fresh_rng(), Answers()
    kinds = "box on the ground", "soft body on the ground", "soft body on a box"
    for _ in range(run.count(4, 20, 100)):
        world, (mu, e) = World.paper(), rng.random(2)
        world.add_ground(friction=0.5 + mu)
        speeds = rng.uniform(-3.0, 3.0, (3, 2))
        size = rng.uniform(0.3, 1.0, 3)
        box = world.add_box(size, 1.0, (0.0, 0.0, 0.5 * size[2]), velocity=(*speeds[0], 0.0), friction=0.9)
        world.add_box((4.0, 4.0, 0.3), None, (9.0, 0.0, 0.15), friction=0.9)
        mesh = rotated(softbody.icosphere(2, 0.5), rng)
        balls = [
            world.add_soft_body(mesh, 1.0, 300.0, 20.0, place, (*speed, 0.0), friction=0.9, restitution=e)
            for place, speed in zip(((-9.0, 0.0, 0.6), (9.0, 0.0, 0.9)), speeds[1:])
        ]
        world.run(0.5, 0.5 * world.stable_time_step())
        answers.extend([box.velocity[:2], *(ball.velocities.mean(axis=0)[:2] for ball in balls)], speeds, kind=kinds)
    return answers.comparison()


@check_by_formula(
    section="4.2, 4.4",
    piece="softbody.collision.boxes.box_ground.bounce_box, softbody.collision.paper.paper_response",
    reference="closed forms: Newton's restitution and Coulomb's friction at one point, with its inverse effective mass",
    engines=("scipy",),
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
    """Friction in World.paper(frictionless=False) is Coulomb's.

    A box strikes the ground with a corner, and particles strike a fixed box, straight or aslant. They lose as much of
    their sliding as the impulse times μ takes away, all of it at most.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(40, 200, 2_000)):
        e, rough, speed = rng.random(2) * (trial % 3 > 0), rng.uniform(0.1, 2.0, 2), rng.uniform(0.5, 3.0)
        slide = np.zeros(2) if trial % 4 == 3 else rng.normal(size=2) * rng.choice([0.1, 2.0])
        velocity = np.array([*slide, -speed])
        found, judged = (_strike_a_box if trial % 2 else _strike_the_ground)(rng, velocity, e, rough)
        kind, pace = "particles on a fixed box" if trial % 2 else "corner on the ground", np.linalg.norm(velocity)
        answers.extend(found / pace, judged / pace, kind=kind)
    return answers.comparison()


def _strike_a_box(rng: np.random.Generator, velocity: np.ndarray, e: np.ndarray, rough: np.ndarray) -> Rows:
    """Return velocities (4, 6), padded, of a heap of particles of which one has struck a fixed box; and the judge's."""
    from scipy.spatial.transform import Rotation

    slide, speed, mu, bounce = velocity[:2], -velocity[2], float(np.sqrt(rough.prod())), float(e.max())
    mesh, world = softbody.tetrahedron(rng.uniform(0.5, 1.0)), _rubbing()
    lowest = int(mesh.vertices[:, 2].argmin())
    tilt = Rotation.align_vectors([(0.0, 0.0, -1.0)], [mesh.vertices[lowest]])[0]
    mesh = Mesh(mesh.vertices @ tilt.as_matrix().T, mesh.triangles)
    place = 0.0, 0.0, -mesh.vertices[lowest, 2] + 0.5 * speed * STEP
    world.add_box((4.0, 4.0, 1.0), None, (0.0, 0.0, -0.5), restitution=e[0], friction=rough[0])
    body = world.add_soft_body(mesh, 1.0, 0.0, 0.0, place, velocity, restitution=e[1], friction=rough[1])
    world.step(STEP)
    kept = np.maximum(0.0, 1.0 - mu * (1.0 + bounce) * speed / np.maximum(np.linalg.norm(slide), 1e-300))
    after = np.tile(velocity, (4, 1))
    after[lowest] = [*(kept * slide), bounce * speed]
    return np.pad(body.velocities, ((0, 0), (0, 3))), np.pad(after, ((0, 0), (0, 3)))


def _strike_the_ground(rng: np.random.Generator, velocity: np.ndarray, e: np.ndarray, rough: np.ndarray) -> Rows:
    """Return v and ω (1, 6) of a box that has struck the ground with one corner, and the judge's; or none of either."""
    from scipy.spatial.transform import Rotation

    speed, mu, bounce, world = -velocity[2], float(np.sqrt(rough.prod())), float(e.max()), _rubbing()
    world.add_ground(restitution=e[0], friction=rough[0])
    size, mass, turn = rng.uniform(0.3, 1.0, 3), np.exp(rng.uniform(-2.0, 2.0)), Rotation.random(random_state=rng)
    arms = turn.apply(corners_of(size))
    arm = arms[arms[:, 2].argmin()]
    if np.sort(arms[:, 2])[1] - arm[2] < 2.0 * speed * STEP:
        return np.zeros((0, 6)), np.zeros((0, 6))  # another corner comes in, too
    place, q = (0.0, 0.0, -arm[2] + 0.5 * speed * STEP), turn.as_quat(scalar_first=True)
    box = world.add_box(size, mass, place, q, velocity, restitution=e[1], friction=rough[1])
    world.step(STEP)
    square = size**2
    inverse = turn.as_matrix() @ np.diag(12.0 / (mass * (square.sum() - square))) @ turn.as_matrix().T
    cross = np.cross(arm, np.eye(3))  # rows: r × x, r × y, r × z
    yields = np.eye(3) / mass + cross @ inverse @ cross.T  # velocity of the corner per impulse
    push = np.array([0.0, 0.0, (1.0 + bounce) * speed / yields[2, 2]])
    sliding = (velocity + yields @ push)[:2]
    along = np.array([*sliding, 0.0]) / np.linalg.norm(sliding)
    rubbed = np.minimum(mu * push[2], np.linalg.norm(sliding) / (along @ yields @ along))
    total = push - rubbed * along
    return motion_of(box)[None], np.hstack([velocity + total / mass, inverse @ np.cross(arm, total)])[None]


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
    """The ground stops corners of a box below it, and no others.

    So it is in World.paper(frictionless=False): a box comes down upright, aslant and sliding, until its upper corners
    are exactly at the ground, or a little above or below. It is stopped and rubbed at the lower four, or at all eight.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial, sunk in enumerate(by_turns(run.count(30, 120, 1_200), "exactly", "less", "more")):
        e, rough, world = rng.random(2) * (trial % 2), rng.uniform(0.1, 1.0, 2), _rubbing()
        world.add_ground(restitution=e[0], friction=rough[0])
        size, mass = rng.integers(8, 33, 3) / 32.0, 2.0 ** rng.integers(-2, 3)
        h, slide, speed = 2.0**-10, rng.normal(size=2), rng.integers(8, 65) / 16.0
        off = {"exactly": 0.0, "less": 2.0**-12, "more": -(2.0**-12)}[sunk]
        velocity = np.array([*slide, -speed])
        place = np.array([0.0, 0.0, -0.5 * size[2] + off + speed * h])
        box = world.add_box(size, mass, place, velocity=velocity, restitution=e[1], friction=rough[1])
        world.step(h)
        judged = stopped(size, mass, velocity, off, float(e.max()), float(np.sqrt(rough.prod())))
        kind = f"sunk by {sunk} {'than ' if off else ''}its height"
        answers.add(motion_of(box) / speed, np.hstack(judged) / speed, kind=kind)
    return answers.comparison()


def stopped(size: np.ndarray, mass: float, velocity: np.ndarray, top: float, bounce: float, mu: float) -> Rows:
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


@check_by_formula(
    section="6",
    piece="softbody.stepping.move_boxes.move_boxes",
    reference="closed form: the yaw is 0, or what it was",
    unit="rad",
    tolerance=5e-15,
    because="rounding of an angle: 2.3e-16 at worst of ten seeds",
    faults=(
        Fault("what holds a box taken for the ground", move_boxes.move_boxes, f"{HELD} → contacts.impulse[k, 2] > 0.0"),
        Fault("ground that is near", move_boxes.move_boxes, f"{HELD} → contacts.box[k, 1] == NOBODY"),
    ),
)
def only_the_ground_makes_snap(run: Run) -> Comparison:
    """A box snaps to right angles only where the ground holds it.

    So it is where spins have a floor, and contacts are solved together. A box that another box holds, or that the
    ground will not reach in the step, does not snap.
    """
    rng, answers = run.fresh_rng(), Answers()
    for kind in by_turns(run.count(30, 150, 1_500), "on the ground", "on a plate", "over the ground"):
        world = World(gravity=WEIGHTLESS, angular_speed_floor=0.2)
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
        world.step(STEP, 1 if kind == "over the ground" else 2)
        w, x, y, z = box.orientation
        turned_by = 2.0 * np.arctan2(z, w) - (0.0 if kind == "on the ground" else yaw)
        answers.add(np.hypot(np.hypot(x, y), turned_by), 0.0, kind=kind)
    return answers.comparison()


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
    """Trying all pairs and all faces changes no bit of a world.

    That is, all pairs of bodies, and the normals of all their faces, as in the paper. Soft spheres, dented ones, tori
    and boxes fall on each other.
    """
    first = int(run.fresh_rng().integers(1 << 30))
    seeds = range(first, first + run.count(2, 8, 40))
    tried, found = (np.array([_heap(seed, pairs) for seed in seeds]) for pairs in ("exhaustive", "grid"))
    return Comparison(tried, found)


def _heap(seed: int, pairs: str) -> np.ndarray:
    """Return where five soft bodies and a box are that have fallen on each other for 0.8 s."""
    rng = np.random.default_rng(seed)
    world = World.paper(pairs=pairs)
    world.add_ground()
    for i in range(5):
        mesh = (softbody.icosphere(1, 0.5), softbody.torus(0.6, 0.2, 12, 8), dented_sphere(2, 0.6))[i % 3]
        place = (*rng.uniform(-0.3, 0.3, 2), 1.0 + 1.9 * i)
        world.add_soft_body(rotated(mesh, rng), 1.0, 300.0, 20.0, place, (0.0, 0.0, -3.0 * i))
    world.add_box(rng.uniform(0.3, 0.6, 3), 2.0, (0.0, 0.0, 10.5), velocity=(0.0, 0.0, -9.0))
    world.run(0.8, 2e-3)
    return np.concatenate([world.state.particle_position.ravel(), world.state.box_position.ravel()])


@check_by_formula(
    section="4.4, 6",
    piece="softbody.stepping.move_boxes.collide_boxes",
    reference="closed form: free flight; the law of restitution",
    unit="of the speed",
    tolerance=5e-15,
    because="multiples of powers of two, so that what touches does so exactly; of bounces, rounding: 2.5e-16 at worst",
    faults=(
        Fault("an impulse between boxes that touch", move_boxes.collide_boxes, "depth > 0.0 → depth >= 0.0"),
        Fault("hardly any overlap is none", move_boxes.collide_boxes, "depth > 0.0 → depth > 1e-8"),
    ),
)
def touching_is_not_overlap(run: Run) -> Comparison:
    """Boxes in World.paper() that only touch fly on.

    A step brings them to touch each other exactly, face to face. Those that it brings a billionth of a metre into each
    other bounce off.
    """
    rng, answers, step = run.fresh_rng(), Answers(), 2.0**-7
    for trial, kind in enumerate(by_turns(run.count(24, 120, 1_200), "touch", "overlap")):
        deeper, axis, world = trial % 2, np.eye(3)[trial // 2 % 3], _weightless()
        sizes, speed = 0.25 * rng.integers(2, 9, (2, 3)), 0.25 * rng.integers(1, 9, 2)
        mass, bounce = rng.uniform(0.5, 2.0, 2), rng.random()
        place = 0.25 * rng.integers(-8, 9, 3)
        apart = 0.5 * sizes.sum(axis=0) @ axis + step * speed.sum() - deeper * 2.0**-30
        world.add_box(sizes[0], mass[0], place, velocity=speed[0] * axis, restitution=bounce)
        world.add_box(sizes[1], mass[1], place + apart * axis, velocity=-speed[1] * axis, restitution=0.0)
        world.step(step)
        after = np.array([speed[0], -speed[1]])
        if deeper:
            after += (1.0 + bounce) * speed.sum() / (1.0 / mass).sum() / mass * (-1.0, 1.0)
        judged = (after[:, None] * axis).ravel()
        answers.add(world.state.box_velocity.ravel() / speed.sum(), judged / speed.sum(), kind=kind)
    return answers.comparison()


@check_by_formula(
    section="4.2, 4.3, 6",
    piece="softbody.model.settings.PAPER",
    reference="closed form: free flight",
    unit="of the speed",
    tolerance=0.0,
    because="nothing acts, so that velocities keep every bit",
    faults=(
        Fault("contacts of edges", soft_contacts.find_soft_contacts, "settings.edge_contacts → True"),
        Fault("steps that are split", step.run, "settings.split_steps → True"),
    ),
)
def unseen_by_the_paper(run: Run) -> Comparison:
    """World.paper() does not see what the paper does not look for.

    An edge of a soft body flies on across an edge of a box or of another soft body. So does a ball that leaps over a
    plate within a step.
    """
    rng, answers = run.fresh_rng(), Answers()
    kinds = "edge across a box's edge", "edge across an edge", "leap over a plate"
    for kind in by_turns(run.count(12, 60, 600), *kinds):
        world = _weightless()
        thin, long = rng.uniform(0.1, 0.3, 2), rng.uniform(1.0, 2.0, 2)
        speed = rng.uniform(0.1, 2.0)
        # A bar along x, standing on an edge, comes down on a bar along y that does, too.
        height = np.sqrt(0.5) * thin.sum() - rng.uniform(0.1, 0.5) * thin.min()
        across, lying = (thin[1], long[1], thin[1]), (COS, 0.0, SIN, 0.0)
        if kind == "leap over a plate":
            speed, height = rng.uniform(60.0, 100.0), 0.02 + thin[0]  # 0.6 m in the step, past 0.3 of bar and plate
            world.add_box((2.0, 2.0, 0.02), None)
        elif kind == "edge across an edge":
            world.add_soft_body(_bar(across, lying), 1.0, 0.0, 0.0)
        else:
            world.add_box(across, 1.0, (0.0, 0.0, 0.0), lying)
        bar = _bar((long[0], thin[0], thin[0]), (COS, SIN, 0.0, 0.0))
        body = world.add_soft_body(bar, 1.0, 0.0, 0.0, (0.0, 0.0, height), (0.0, 0.0, -speed))
        world.step(1e-2 if kind == "leap over a plate" else STEP)
        count = len(body.velocities)
        asked: dict[str, Any] = {
            "speed": np.full(count, speed),
            "height": np.full(count, height),
            "particle": np.arange(count),
        }
        answers.extend(body.velocities / speed, np.tile((0.0, 0.0, -1.0), (count, 1)), kind=kind, **asked)
    return answers.comparison()


def _bar(size: tuple[float, float, float], turn: tuple[float, float, float, float]) -> Mesh:
    """Return a box of a size [m], turned."""
    bar = softbody.box(size, 1)
    return Mesh(bar.vertices @ rotation_matrix(np.array(turn)).T, bar.triangles)


@check_by_formula(
    section="4.3, 4.5",
    piece="softbody.collision.soft.sat_meshes.faces_part",
    reference="projections of all points on all normals, by NumPy; FCL",
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
    """Faces' normals part two meshes just where projections say so.

    NumPy tries all of them, of convex meshes and dented ones. Of convex ones that one parts, FCL says that they are
    apart.
    """
    from references import fcl

    rng, answers = run.fresh_rng(), Answers()
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
            gap, meshes = _widest_gap(a, b), (a.vertices, a.triangles, b.vertices, b.triangles)
            if abs(gap) < 1e-9:
                continue
            told = bool(sat_meshes.faces_part(*meshes))
            answers.add(told, gap > 0.0, kind=kind)
            if is_convex and told:
                answers.add(False, fcl.convex_overlap(*meshes), kind=f"{kind}, parted")
    return answers.comparison()


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


@check_by_formula(
    section="4.4",
    piece="softbody.collision.boxes.single_contact.box_box_contact",
    reference="closed form: the lowest corner; the middle of a rectangle",
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
    """The one point where two boxes touch is half-way through their overlap.

    It is half as deep as they are, below the corner of either that is in a face of the other. Of two faces that lie on
    each other, along any axis, it is in the middle of what they have in common.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case, kind in enumerate(by_turns(run.count(60, 300, 3_000), "a corner in a face", "face on face")):
        (whole, own), shift = random_orientations(rng, 2), rng.normal(size=3)
        turn = rotation_matrix(whole)
        size_a, size_b = rng.uniform(0.5, 2.0, (2, 3))
        axis, side = case // 2 % 3, rng.choice([-1.0, 1.0])
        up, depth = side * np.eye(3)[axis], rng.uniform(0.01, 0.05)
        if kind == "face on face":  # that of b on that of a, off its middle
            place = rng.uniform(-0.45, 0.45, 3) * (size_a + size_b)
            place[axis] = side * (0.5 * (size_a[axis] + size_b[axis]) - depth)
            low, high = np.maximum(-0.5 * size_a, place - 0.5 * size_b), np.minimum(0.5 * size_a, place + 0.5 * size_b)
            if np.delete(high - low, axis).min() < 2.0 * depth:
                continue
            own, middle = UPRIGHT, 0.5 * (low + high)
        else:  # a corner of b is in that face of a, well inside
            corners = corners_of(size_b) @ rotation_matrix(own).T
            heights = np.sort(corners @ up)
            if heights[1] - heights[0] < 0.3:
                continue
            tip = rng.uniform(-0.2, 0.2, 3) * size_a
            tip[axis] = side * (0.5 * size_a[axis] - depth)
            place, middle = tip - corners[np.argmin(corners @ up)], tip + 0.5 * depth * up
        one = PlacedBox(tuple(size_a), tuple(shift), tuple(whole))
        other = PlacedBox(tuple(size_b), tuple(turn @ place + shift), tuple(turned(whole, own)))
        for pair, sign in (((one, other), -1.0), ((other, one), 1.0)):
            found = single_contact.box_box_contact(*pair)
            judged = [depth, *(turn @ middle + shift), *(sign * turn @ up)]
            answers.add([found[0], *found[1], *found[2]], judged, kind=kind)
    return answers.comparison()
