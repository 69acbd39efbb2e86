"""Friction and restitution as a user of a World sees them: boxes by DART and closed forms, soft bodies by closed forms.

All worlds are those of the default settings. The friction of a pair is the geometric mean of both sides', and both are
given unlike numbers, so that the rule shows.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

import softbody
from softbody import SoftBody, World
from softbody.collision import ground, law, sequential_impulses, soft_response
from softbody.geometry.box import box_corners
from validation.cases import random_orientations, rotated, rotation_matrix
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "friction"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

STATE = "position, rotation matrix and velocities"

G = 9.81
STEP = 1e-3  # [s] of boxes
DEEP = 1e-9  # [m] by which boxes start inside what they stand on: DART sees contacts only where something overlaps


def limit_off(share: float) -> Fault:
    """Return the fault that the friction of boxes is bounded by `share` of what it must be."""
    return Fault(
        f"friction of boxes {share} of what it is",
        sequential_impulses._sweep,
        "contacts_.friction[k_] * normal_",
        f"{share} * contacts_.friction[k_] * normal_",
    )


PYRAMID = Fault(
    "a friction pyramid in place of the cone",
    law.within_friction_cone,
    "first * first + second * second",
    "max(first * first, second * second)",
)
DEAF_BELOW = Fault(
    "friction that what lies below feels half of",
    sequential_impulses._sweep,
    "sub(v_b, scale(share_b, along))",
    "sub(v_b, scale(0.5 * share_b, along))",
)
LARGER = Fault("the larger friction of two", law.combined, "sqrt(a_.friction * b_.friction)", "max(a.friction, b.friction)")  # fmt: skip  # noqa: E501
SMALLER = Fault("the smaller friction of two", law.combined, "sqrt(a_.friction * b_.friction)", "min(a.friction, b.friction)")  # fmt: skip  # noqa: E501
NO_BOUNCE = Fault("no restitution on the ground", ground.bounce_particle, "speed_after(down_, e_)", "0.0")
GROUND_WITHOUT_MATERIAL = Fault(
    "soft bodies on a ground that counts as they do",
    ground.resolve_ground,
    "material_of_ground(model_)",
    "material_of_soft(model_, body_)",
)
HALF_ON_GROUND = Fault(
    "half the friction of soft bodies on the ground", law.sliding_kept, "material_.friction", "0.5 * material_.friction"
)
HALF_OF_SOFT = Fault(
    "half the friction of soft bodies in contact", law.friction_impulse, "min(limit, s_)", "min(0.5 * limit, s_)"
)


class Start(NamedTuple):
    """How a box starts, and its friction coefficient."""

    size: np.ndarray
    mass: float
    position: np.ndarray
    orientation: np.ndarray
    velocity: np.ndarray
    angular_velocity: np.ndarray
    friction: float


def yawed(angle: float) -> np.ndarray:
    """Return the orientation of a box turned by `angle` [rad] about the vertical."""
    return np.array([np.cos(0.5 * angle), 0.0, 0.0, np.sin(0.5 * angle)])


def some_direction(rng: np.random.Generator) -> np.ndarray:
    """Return a horizontal unit vector."""
    angle = rng.uniform(0.0, 2.0 * np.pi)
    return np.array([np.cos(angle), np.sin(angle), 0.0])


def flat_boxes(kind: str, rng: np.random.Generator) -> list[Start]:
    """Return one flat box on the ground, or two on each other, that slide along one line or spin about one axis.

    Then what each of four corners carries is not told by statics alone, but friction does not depend on it.
    """
    starts: list[Start] = []
    way, place, height = some_direction(rng), rng.uniform(-2.0, 2.0, 3), 0.0
    drift = rng.uniform(-1.0, 1.0) * way
    for widths, heights, masses in (((1.5, 2.0), (0.2, 0.4), (0.5, 3.0)), ((0.3, 0.6), (0.1, 0.3), (0.2, 2.0))):
        size = np.array([*rng.uniform(*widths, 2), rng.uniform(*heights)])
        if "spin" in kind:
            velocity, spin = np.zeros(3), np.array([0.0, 0.0, rng.uniform(-6.0, 6.0)])
        else:
            drift += rng.uniform(-1.0, 1.0) * way
            velocity, spin = drift, np.zeros(3)
        place = np.array([place[0], place[1], height + 0.5 * size[2] - DEEP])
        starts.append(
            Start(size, rng.uniform(*masses), place, yawed(rng.uniform(0.0, 6.0)), velocity, spin, rng.uniform(0.1, 1.0))
        )
        height += size[2] - DEEP
    return starts[: 2 if "two" in kind else 1]


def leaning_box(kind: str, rng: np.random.Generator) -> list[Start]:
    """Return a cube on one corner, moving anyhow; or any box on one edge, moving across it, on the ground or a box.

    (Without the gyroscopic torque, which DART has, and our default, like the paper, has not, others would differ.)
    """
    mass, friction, way = rng.uniform(0.5, 3.0), rng.uniform(0.2, 1.0), some_direction(rng)
    below: list[Start] = []
    if kind == "cube on a corner":
        size, lowest = np.full(3, rng.uniform(0.4, 1.0)), np.zeros(2)
        while lowest[1] - lowest[0] < 0.35 * size[0]:  # so that no other corner comes down
            q = random_orientations(rng, 1)[0]
            lowest = np.sort(box_corners(size, (0.0, 0.0, 0.0), q)[:, 2])
        velocity, spin = rng.uniform(-1.0, 1.0, 3), rng.uniform(-1.5, 1.5, 3)
    else:
        size, lean = rng.uniform(0.4, 1.0, 3), 0.5 * rng.uniform(0.4, 1.1)
        turn, tilt = yawed(np.arctan2(way[1], way[0])), np.array([np.cos(lean), 0.0, np.sin(lean), 0.0])
        q = np.array([turn[0] * tilt[0], -turn[3] * tilt[2], turn[0] * tilt[2], turn[3] * tilt[0]])
        velocity, spin = rng.uniform(-1.0, 1.0) * way, rng.uniform(-1.0, 1.0) * np.array([-way[1], way[0], 0.0])
        if kind == "box on an edge, on a box":
            plate = np.array([2.0, 2.0, 0.2])
            place = np.array([0.0, 0.0, 0.1 - DEEP])
            below.append(Start(plate, rng.uniform(1.0, 3.0), place, turn, rng.uniform(-1.0, 1.0) * way, np.zeros(3), 0.3))
    corners = box_corners(size, (0.0, 0.0, 0.0), q)
    lowest_corner = corners[np.argmin(corners[:, 2])]
    velocity[2] = -np.cross(spin, lowest_corner)[2]  # it neither leaves the ground nor strikes it
    place = np.array([0.0, 0.0, -lowest_corner[2] - DEEP + (0.2 - DEEP if below else 0.0)])
    return [*below, Start(size, mass, place, q, velocity, spin, friction)]


def in_both_engines(starts: list[Start], ground_friction: float, steps: int, h: float) -> tuple[np.ndarray, np.ndarray]:
    """Return (m, 18): positions, rotation matrices and velocities of boxes after some steps, by ours and by DART.

    In a pile of one or two: DART takes the smaller friction of two, so the pair above bounds that below from above.
    """
    from references.dartpy import DartWorld

    world, dart = World(), DartWorld(h)
    world.add_ground(friction=ground_friction)
    for start in starts:
        world.add_box(*start[:-1], friction=start.friction)
    pairs = [ground_friction, *(start.friction for start in starts)]
    friction = [np.sqrt(a * b) for a, b in zip(pairs, pairs[1:])]
    dart.add_ground(friction[0])
    for start, below, above in zip(starts, friction, [*friction[1:], 0.0]):
        dart.add_box(*start[:-1], friction=max(below, above))
    world.step(h, steps)
    dart.step(steps)
    turned = [rotation_matrix(q).ravel() for q in world.state.box_orientation]
    ours = np.hstack([world.state.box_position, turned, world.state.box_velocity, world.state.box_angular_velocity])
    theirs = np.hstack([dart.positions(), dart.rotations().reshape(-1, 9), dart.velocities()])
    return ours, theirs


def compared(
    kinds: tuple[str, ...], starts: Callable[[str, np.random.Generator], list[Start]], run: Run, h: float, seconds: float
) -> Comparison:
    """Compare where boxes are, how they are turned and how fast they move, by ours and by DART."""
    rng = run.fresh_rng()
    ours, theirs, groups = [], [], []
    for _ in range(run.count(6, 24, 100) // len(kinds)):
        for kind in kinds:
            a, b = in_both_engines(starts(kind, rng), rng.uniform(0.1, 0.8), round(seconds / h), h)
            ours += list(a)
            theirs += list(b)
            groups += [kind] * len(a)
    return Comparison(np.array(ours), np.array(theirs), groups=groups)


@check(
    family=FAMILY,
    claim="A flat box, turned anyhow, slides or spins on the ground as DART makes it.",
    section="beyond the paper",
    piece="softbody.collision.sequential_impulses.solve_velocities",
    reference=f"DART, Gauss–Seidel on Coulomb's cone: {STATE} after 0.2 s",
    engines=("dartpy",),
    unit="m, m/s, rad/s",
    tolerance=2e-6,
    because="TODO",
    detects="a pyramid in place of the cone; a wrong mean of the coefficients",
    faults=(limit_off(0.999), PYRAMID, LARGER, SMALLER),
)
def flat_box_as_in_dart(run: Run) -> Comparison:
    return compared(("slides", "spins"), flat_boxes, run, STEP, 0.2)


@check(
    family=FAMILY,
    claim="Two flat boxes on each other, both free, slide along one line, or spin about one axis, as DART makes them.",
    section="beyond the paper",
    piece="softbody.collision.sequential_impulses.solve_velocities",
    reference=f"DART, as above: {STATE} after 0.2 s",
    engines=("dartpy",),
    unit="m, m/s, rad/s",
    tolerance=3e-3,
    because="TODO",
    detects="the wrong pair's coefficient; a lower box that does not feel what slides on it",
    faults=(limit_off(0.98), LARGER, DEAF_BELOW),
)
def two_flat_boxes_as_in_dart(run: Run) -> Comparison:
    return compared(("two slide", "two spin"), flat_boxes, run, STEP, 0.2)


@check(
    family=FAMILY,
    claim="Cubes on a corner, and boxes on an edge, on the ground or on a box that slides itself, tip, slide and turn"
    " over as DART makes them.",
    section="beyond the paper",
    piece="softbody.collision.sequential_impulses.solve_velocities",
    reference="DART, as above: position and rotation after 0.15 s",
    engines=("dartpy",),
    unit="m, rotation matrix",
    tolerance=2e-4,
    because="TODO",
    detects="friction that turns no box, or not as its arm says; the wrong direction of friction at a corner",
    faults=(
        limit_off(0.97),
        PYRAMID,
        Fault(
            "friction that does not turn boxes",
            sequential_impulses._sweep,
            "w_a = add(w_a, add(x_, y_))",
            "w_a = add(w_a, scale(0.5, add(x_, y_)))",
        ),
    ),
)
def leaning_boxes_as_in_dart(run: Run) -> Comparison:
    kinds = ("cube on a corner", "box on an edge", "box on an edge, on a box")
    found = compared(kinds, leaning_box, run, 0.2 * STEP, 0.15)
    return Comparison(found.measured[:, :12], found.expected[:, :12], groups=found.groups)


@check(
    family=FAMILY,
    claim="A box that spins on its face stops after the angle ω²/2α, α = 6 μ g / diagonal, and stays.",
    section="beyond the paper",
    piece="softbody.collision.sequential_impulses.solve_velocities",
    reference="closed form: its four corners carry the weight, at half the diagonal from the axis",
    unit="of the angle",
    tolerance=2e-3,
    because="TODO",
    detects="friction at a corner that does not oppose its own sliding",
    faults=(limit_off(0.99), PYRAMID),
)
def spinning_box_stops(run: Run) -> Comparison:
    rng = run.fresh_rng()
    measured, expected = [], []
    for _ in range(run.count(6, 30, 200)):
        size, rub, spin = rng.uniform([0.4, 0.4, 0.1], [1.2, 1.2, 0.3]), rng.uniform(0.1, 0.9, 2), rng.uniform(4.0, 8.0)
        slowing = 6.0 * np.sqrt(rub[0] * rub[1]) * G / np.hypot(size[0], size[1])
        world = World()
        world.add_ground(friction=rub[0])
        box = world.add_box(
            size, rng.uniform(0.5, 3.0), (0.0, 0.0, 0.5 * size[2]), yawed(rng.uniform(0.0, 6.0)),
            angular_velocity=(0.0, 0.0, spin), friction=rub[1],
        )  # fmt: skip
        turned = 0.0
        for _ in range(20):
            before = rotation_matrix(box.orientation)[:2, 0]
            world.run(1.05 * spin / slowing / 20.0, STEP / 4.0)
            after = rotation_matrix(box.orientation)[:2, 0]
            turned += float(np.arctan2(before[0] * after[1] - before[1] * after[0], before @ after))
        angle = 0.5 * spin**2 / slowing
        measured.append([turned / angle, box.angular_velocity[2] / spin])
        expected.append([1.0, 0.0])
    return Comparison(measured, expected)


@check(
    family=FAMILY,
    claim="A box that is pulled ever harder stays until the pull is μ m g, and then gains speed by what exceeds that.",
    section="10.13",
    piece="softbody.collision.sequential_impulses.solve_velocities",
    reference="closed form: the sum over steps of what the pull exceeds μ m g by",
    unit="of the speed at the end",
    tolerance=1e-6,
    because="TODO",
    detects="friction that gives way too early or too late, or keeps pushing; forces that friction does not feel",
    faults=(limit_off(0.999), LARGER, SMALLER),
)
def pulled_box_breaks_loose(run: Run) -> Comparison:
    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for _ in range(run.count(6, 30, 200)):
        size, rub, mass = rng.uniform([0.6, 0.6, 0.1], [1.2, 1.2, 0.3]), rng.uniform(0.1, 0.9, 2), rng.uniform(0.5, 5.0)
        way, steps = some_direction(rng), 400
        world = World()
        world.add_ground(friction=rub[0])
        box = world.add_box(size, mass, (0.0, 0.0, 0.5 * size[2]), yawed(rng.uniform(0.0, 6.0)), friction=rub[1])
        holds = np.sqrt(rub[0] * rub[1]) * mass * G
        more = holds / (rng.uniform(0.4, 0.6) * steps)
        pulls = more * np.arange(1, steps + 1)
        final = np.maximum(0.0, pulls - holds).sum() * STEP / mass
        stuck = int((pulls < holds).sum())
        for step in range(steps):
            box.apply_force(more * way)
            world.step(STEP)
            if step + 1 in (stuck, steps):
                measured.append(box.velocity / final)
                expected.append(way if step + 1 == steps else np.zeros(3))
                kinds.append("slides" if step + 1 == steps else "holds")
    return Comparison(np.array(measured), np.array(expected), groups=kinds)


@check(
    family=FAMILY,
    claim="Of two boxes on each other the lower is pulled: they go together as long as their friction can, else each"
    " by what is left for it.",
    section="10.13",
    piece="softbody.collision.sequential_impulses.solve_velocities",
    reference="closed form: Newton's law with Coulomb's bound at both faces",
    unit="of the speed",
    tolerance=1e-4,
    because="TODO",
    detects="the wrong pair's coefficient; a lower box that does not feel its load's friction",
    faults=(
        limit_off(0.99),
        LARGER,
        DEAF_BELOW,
    ),
)
def pulled_from_under(run: Run) -> Comparison:
    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for trial in range(run.count(6, 30, 200)):
        lower, upper = np.exp(rng.uniform(np.log(0.5), np.log(4.0), 2))
        rub, way, slips = rng.uniform(0.2, 0.9, 3), some_direction(rng), trial % 2
        under, between = np.sqrt(rub[0] * rub[1]), np.sqrt(rub[1] * rub[2])
        # Together they can gain as much as friction gives the upper one.
        limit = between * G * (lower + upper)
        spare = limit * (rng.uniform(1.05, 1.5) if slips else rng.uniform(0.5, 0.95))
        world = World()
        world.add_ground(friction=rub[0])
        first = world.add_box((2.0, 1.6, 0.2), lower, (0.0, 0.0, 0.1), yawed(rng.uniform(0.0, 6.0)), friction=rub[1])
        second = world.add_box((0.7, 0.9, 0.2), upper, (0.0, 0.0, 0.3), yawed(rng.uniform(0.0, 6.0)), friction=rub[2])
        first.apply_force((spare + under * G * (lower + upper)) * way)
        world.run(0.2, STEP)
        gains = [(spare - between * upper * G) / lower, between * G] if slips else [spare / (lower + upper)] * 2
        measured += [first.velocity / (0.2 * gains[0]), second.velocity / (0.2 * gains[1])]
        expected += [way, way]
        kinds += ["upper slips" if slips else "together"] * 2
    return Comparison(np.array(measured), np.array(expected), groups=kinds)


def loose_mesh(rng: np.random.Generator) -> softbody.Mesh:
    """Return a sphere of 162 particles, turned anyhow."""
    return rotated(softbody.icosphere(2, rng.uniform(0.2, 0.5)), rng)


def after_bounce(velocity: np.ndarray, normal: np.ndarray, friction: float, restitution: float) -> np.ndarray:
    """Return the velocities (n, 3) of points after they strike what is fixed and has this normal: Newton and Coulomb.

    v_n' = −e v_n; the sliding loses μ (1 + e) |v_n|, and at most all.
    """
    closing = -velocity @ normal
    slide = velocity + closing[:, None] * normal
    speed = np.linalg.norm(slide, axis=1)
    kept = np.maximum(0.0, 1.0 - friction * (1.0 + restitution) * closing / speed)
    struck = closing > 0.0
    after = restitution * closing[:, None] * normal + kept[:, None] * slide
    return np.where(struck[:, None], after, velocity)


@check(
    family=FAMILY,
    claim="Particles of a soft body that come below the ground in a step, each at its own velocity, leave it by Newton's"
    " restitution and Coulomb's friction, and lie on it.",
    section="4.3",
    piece="softbody.collision.ground.resolve_ground",
    reference="closed form for a particle",
    unit="m, m/s",
    tolerance=1e-11,
    because="TODO",
    detects="a ground without restitution or with less friction; coefficients of one side only",
    faults=(NO_BOUNCE, HALF_ON_GROUND, GROUND_WITHOUT_MATERIAL, LARGER, SMALLER),
)
def particles_strike_the_ground(run: Run) -> Comparison:
    rng = run.fresh_rng()
    measured, expected, kinds = [], [], []
    for _ in range(run.count(6, 30, 200)):
        rub, bounce, height = rng.uniform(0.1, 1.0, 2), rng.uniform(0.0, 1.0, 2), rng.uniform(-1.0, 1.0)
        world, mesh = World(), loose_mesh(rng)
        world.add_ground(height, bounce[0], rub[0])
        # Springs that do nothing within a step, so that all particles are on their own.
        body = world.add_soft_body(
            mesh, 1.0, 1e-9, 0.0, (0.0, 0.0, height - 0.8 * mesh.vertices[:, 2].min()), restitution=bounce[1], friction=rub[1]
        )
        body.velocities[:] = rng.normal(size=mesh.vertices.shape)
        start, came = body.positions.copy(), body.velocities + [0.0, 0.0, -G * STEP]
        world.step(STEP)
        below = start[:, 2] + 0.5 * STEP * (came + body.velocities)[:, 2] < height - 0.01
        left = after_bounce(came, np.array([0.0, 0.0, 1.0]), np.sqrt(rub[0] * rub[1]), bounce.max())
        measured += list(np.hstack([body.velocities, body.positions[:, 2:]])[below])
        expected += list(np.hstack([left, np.full((len(left), 1), height)])[below])
        kinds += ["goes down" if down else "goes up" for down in came[below, 2] < 0.0]
    return Comparison(np.array(measured), np.array(expected), groups=kinds)


@check(
    family=FAMILY,
    claim="A soft body's particles that its springs hardly hold bounce on along the ground like stones: e² of the height"
    " each time, and μ (1 + e) times the speed of each fall off the sliding.",
    section="4.3",
    piece="softbody.collision.ground.resolve_ground",
    reference="closed form of the flights between bounces",
    unit="of the height of the fall, and of the speed",
    tolerance=5e-3,
    because="TODO",
    detects="a restitution that is not e, or friction of one bounce that is not μ (1 + e)",
    faults=(NO_BOUNCE, HALF_ON_GROUND, LARGER),
)
def particles_bounce_along(run: Run) -> Comparison:
    rng = run.fresh_rng()
    measured, expected = [], []
    h = 0.1 * STEP
    for _ in range(run.count(6, 20, 100)):
        rub, bounce, fall = rng.uniform(0.02, 0.3, 2), rng.uniform(0.3, 0.9), rng.uniform(0.1, 0.4)
        way, speed, mesh = some_direction(rng), rng.uniform(3.0, 6.0), softbody.box((0.5, 0.5, 1.0), 1)
        top = np.flatnonzero(mesh.vertices[:, 2] > 0.0)
        world = World()
        world.add_ground(restitution=bounce, friction=rub[0])
        body = world.add_soft_body(mesh, 1.0, 1e-9, 0.0, (0.0, 0.0, 0.5 + fall), fixed=top, friction=rub[1])
        low = mesh.vertices[:, 2] < 0.0
        body.velocities[low] = speed * way
        strikes = np.sqrt(2.0 * G * fall)  # [m/s] at the first bounce; by e at each further one
        time, apex, lost = strikes / G, fall, 0.0
        for turn in range(3):
            lost += np.sqrt(rub[0] * rub[1]) * (1.0 + bounce) * strikes * bounce**turn
            rising = bounce ** (turn + 1) * strikes / G
            time, apex = time + rising, 0.5 * G * rising**2
            world.run(time - world.time, h)
            measured.append(np.array([body.positions[low, 2].mean() / fall, *(body.velocities[low].mean(axis=0)[:2] / speed)]))
            expected.append(np.array([apex / fall, *((1.0 - lost / speed) * way[:2])]))
            time += rising
    return Comparison(np.array(measured), np.array(expected))
