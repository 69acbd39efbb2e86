"""Claims that what hangs in a soft body is carried by it, and pulls back at it."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

import softbody
from softbody import Box, Mesh, SimulationError, SoftBody, Suspended, World
from softbody.bodies import adding, builder, inventory, suspended
from softbody.collision.soft import soft_contacts
from softbody.dynamics import joint_forces
from validation.answers import Answers
from validation.cases import corners_of, random_mesh, random_orientations, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.worlds.cases import WEIGHTLESS
from validation.fault import Fault

FAMILY = "what hangs in a body"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

check_suspended = partial(check, section="7")

KINDS = ("sphere", "torus", "box", "dented sphere", "lumpy sphere")


def metre(kind: str, rng: np.random.Generator) -> Mesh:
    """Return a mesh of a kind, a metre long, about the origin."""
    mesh = random_mesh(kind, rng)
    mesh = mesh.scaled(1.0 / float(np.ptp(mesh.vertices, axis=0).max()))
    return mesh.moved(-mesh.vertices.mean(axis=0))


def points_inside(mesh: Mesh, count: int, rng: np.random.Generator) -> np.ndarray:
    """Return points (count, 3) that are in a mesh."""
    from references import igl

    points = rng.uniform(mesh.vertices.min(axis=0), mesh.vertices.max(axis=0), (400 * count, 3))
    return points[igl.points_in_mesh(points, mesh.vertices, mesh.triangles)][:count]


@check_suspended(
    piece="softbody.World.suspend, softbody.Suspended",
    reference="the affine map itself, of points and of velocities; 1",
    kind="closed form",
    engines=("igl",),
    unit="of how far away it is",
    tolerance=1e-13,
    because="rounding: 1.4e-14 at worst of three seeds",
    faults=(
        Fault(
            "particles of another body",
            joint_forces.carried,
            "rows[slice(*p_)] → rows[: weights_of(joints, suspension).shape[1]]",
        ),
        Fault(
            "points in another order",
            joint_forces.carried,
            "weights_of(joints, suspension) @ r_ → weights_of(joints, suspension)[::-1] @ r_",
        ),
        Fault("weights that sum to more", suspended.weights_in, "return found → return 1.001 * found"),
    ),
)
def carried_by_affine_maps(run: Run) -> Comparison:
    """Points that hang in a body go with affine maps exactly.

    Their velocities do, too, and weights sum to 1: of mean values and tetrahedra, in bodies of every kind of mesh.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 4, 40)):
        world, hung = World(), list[tuple[str, Suspended, np.ndarray]]()
        for k, kind in enumerate(KINDS):
            mesh = metre(kind, rng)
            body = world.add_soft_body(mesh, 1.0, 100.0, 1.0, (3.0 * k, 0.0, 0.0))
            for weights in ("mean-value", "tetrahedron"):
                points = points_inside(mesh, 3, rng) + (3.0 * k, 0.0, 0.0)
                hung.append((kind, world.suspend(points, body, weights=weights), points))
        matrix, shift = rng.normal(size=(3, 3)), rng.normal(size=3)
        for body in world.soft_bodies:
            body.velocities = body.positions @ matrix - shift
            body.positions = body.positions @ matrix.T + shift
        for kind, points_there, points in hung:
            far = np.abs(points).max()
            answers.extend(points_there.positions / far, (points @ matrix.T + shift) / far, kind=kind)
            answers.extend(points_there.velocities / far, (points @ matrix - shift) / far, kind=kind)
            total = points_there.weights.sum(axis=1)
            answers.extend(np.outer(total, np.ones(3)), np.ones((len(points), 3)), kind="sums")
    return answers.comparison()


def hang(
    rng: np.random.Generator, world: World, body: SoftBody, where: np.ndarray, mass: float | None, **more: Any
) -> tuple[Box, Suspended]:
    """Hang a cube, turned anyhow, in a body; return both handles."""
    edge = rng.uniform(0.08, 0.16)
    box = world.add_box((edge, edge, edge), mass, where, random_orientations(rng, 1)[0])
    return box, world.suspend(box, body, **more)


@check_suspended(
    piece="softbody.World.suspend",
    reference="closed form: Hooke's law and damping at the corners, shared by the weights",
    kind="closed form",
    unit="of the momentum given",
    tolerance=1e-11,
    because="rounding: 7.9e-13 at worst of three seeds, of velocities that change by some 1e-3 of what they are",
    faults=(
        Fault(
            "a reaction by half of the weights",
            joint_forces._act,
            "scale(joints_.weight[w_], force_) → scale(0.5 * joints.weight[weight], force)",
        ),
        Fault(
            "carried points that stand still",
            joint_forces._end,
            "_carried(state_.particle_velocity, j_, k_, e_) → (0.0, 0.0, 0.0)",
        ),
        Fault(
            "corners of half the box",
            suspended._hung,
            "0.5 * parts_.model.box_size[box_] → 0.25 * parts.model.box_size[box]",
        ),
    ),
)
def pulled_at_the_corners(run: Run) -> Comparison:
    """A box in a body pulls as springs at its corners do.

    One step from where it was moved and turned: what it gets, and each particle, of a body without springs and gas.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(6, 30, 300)):
        world, h = World(WEIGHTLESS), 1e-4
        body = world.add_soft_body(softbody.icosphere(1, 0.5), rng.uniform(0.5, 2.0), 0.0, 0.0, rng.normal(size=3))
        stiffness, damping = rng.uniform(50.0, 200.0), rng.uniform(0.5, 2.0)
        box, hung = hang(rng, world, body, body.centre, rng.uniform(0.5, 2.0), stiffness=stiffness, damping=damping)
        body.velocities = rng.normal(size=body.positions.shape)
        box.position += 0.02 * rng.normal(size=3)
        box.velocity, box.angular_velocity = rng.normal(size=(2, 3))
        arms = corners_of(box.size)[[0, 4, 2, 6, 1, 5, 3, 7]] @ rotation_matrix(box.orientation).T
        away = box.position + arms - hung.positions
        parting = box.velocity + np.cross(box.angular_velocity, arms) - hung.velocities
        force = -stiffness * away - damping * parting
        torque = np.cross(hung.positions - box.position, force).sum(axis=0)
        before = box.velocity.copy(), box.angular_velocity.copy(), body.velocities.copy()
        world.step(h, allow_unstable=True)
        size, mass = float(box.size[0]), float(box.mass or 0.0)
        scale = h * float(np.linalg.norm(force, axis=1).max())
        answers.add(mass * (box.velocity - before[0]), h * force.sum(axis=0), scale, "momentum of the box")
        answers.add(mass * size / 6.0 * (box.angular_velocity - before[1]), h * torque / size, scale, "its spin")
        got = body.mass / len(body.positions) * (body.velocities - before[2])
        answers.extend(got, -h * hung.weights.T @ force, scale, "particles")
    return answers.comparison()


@check_suspended(
    piece="softbody.World.suspend",
    reference="both momenta before",
    kind="invariant",
    unit="of the momentum of all that moves",
    tolerance=1e-14,
    because="rounding: 7.7e-16 at worst of three seeds",
    faults=(
        Fault("weights that sum to a hundredth more", suspended.weights_in, "return found → return 1.01 * found"),
        Fault(
            "damping that turns",
            joint_forces._act,
            "cross(sub(place_, load(p_, b_)), force_) → cross(_arm(state, joints, k, end), force)",
        ),
    ),
)
def momenta_kept(run: Run) -> Comparison:
    """What is shaken with what hangs in it keeps both momenta.

    Balls, each with two cubes of a tenth to ten times its mass, or one and a joint to a point that hangs in
    the next: 0.2 s, by default.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(6, 20, 200)):
        world = World(WEIGHTLESS)
        body = world.add_soft_body(softbody.icosphere(2, 0.5), 1.0, 300.0, 30.0, velocity=rng.normal(size=3))
        masses = 10.0 ** rng.uniform(-1.0, 1.0, 2)
        hang(rng, world, body, body.centre + (0.0, 0.0, 0.15), masses[0])
        if case % 2:
            hang(rng, world, body, body.centre - (0.0, 0.0, 0.15), masses[1])
        else:
            other = world.add_soft_body(softbody.icosphere(1, 0.5), 1.0, 300.0, 30.0, (3.0, 0.0, 0.0))
            points = [world.suspend(rng.uniform(-0.2, 0.2, (2, 3)) + each.centre, each) for each in (body, other)]
            world.add_joint((points[0], 1), (points[1], 0), 20.0, rest_length=3.0)
        for each in world.soft_bodies:
            each.velocities = each.velocities + rng.normal(size=each.positions.shape)
        before = np.concatenate([world.linear_momentum(), world.angular_momentum()])
        moving = sum(each.mass * np.linalg.norm(each.velocities, axis=1).mean() for each in world.soft_bodies)
        step = 0.9 * world.stable_time_step()
        world.step(step, int(0.2 / step))
        answers.add(np.concatenate([world.linear_momentum(), world.angular_momentum()]), before, float(moving))
    return answers.comparison()


@check_suspended(
    piece="softbody.World.suspend, softbody.World.stable_time_step",
    reference="closed form: frequencies of two that swing together, and the stable step with the box loose in it",
    kind="closed form",
    tolerance=1e-14,
    because="rounding: 2.2e-16 at worst",
    faults=(
        Fault("firm for a step of 1 ms", suspended._stable_step, "return s_ * l_ → return 1e-3"),
        Fault(
            "parts of a step that are not counted",
            suspended._stable_step,
            "settings_.substeps * s_ → longest_stable_step(frequency, damping, STABILITY_LIMIT[settings.integrator])",
        ),
        Fault(
            "damping of half of what is critical",
            suspended.with_box_hung,
            "2.0 * sqrt(stiffness_) / one_ → sqrt(stiffness) / one",
        ),
    ),
)
def as_firm_as_the_step_allows(run: Run) -> Comparison:
    """A box in a body makes stable steps √2 times shorter.

    Whatever its mass and size, and the body's springs and gas, with each integrator; in two parts, √5 / 2 times.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(9, 60, 600)):
        integrator = ("symplectic_euler", "rk4", "rk4_velocity")[case % 3]
        world = World(integrator=integrator, substeps=1 + case % 2)
        mesh = softbody.icosphere(2, 0.5) if case % 4 else softbody.torus(0.5, 0.2, 24, 12)
        body = world.add_soft_body(mesh, 10.0 ** rng.uniform(-1.0, 1.0), 10.0 ** rng.uniform(4.0, 6.0), 100.0)
        place = body.centre if case % 4 else body.centre + (0.5, 0.0, 0.0)
        edge, turn = rng.uniform(0.08, 0.16), random_orientations(rng, 1)[0]
        box = world.add_box((edge, edge, edge), 10.0 ** rng.uniform(-2.0, 2.0), place, turn, inside=body)
        alone = world.stable_time_step()
        world.suspend(box, body)
        both = alone / np.hypot(1.0, 1.0 / world.substeps)  # joints act once a step
        answers.add(world.stable_time_step() / both, 1.0, kind=integrator, stable=both)
    return answers.comparison()


@check_suspended(
    piece="softbody.World.suspend, softbody.World.stable_time_step",
    reference="the highest frequency by NumPy's eigenvalues, of what joints make of a box and the particles",
    kind="bound",
    faults=(
        Fault(
            "half of the weights", joint_forces.joint_rates, "rate[k] * share * share.sum() → 0.05 * rate[k] * share"
        ),
        Fault(
            "mobility of the box left out", joint_forces.joint_rates, "_times(rate[on_box], mobility) → 0.0 * mobility"
        ),
    ),
)
def steps_short_enough(run: Run) -> Comparison:
    """A step that is stable is short enough for what hangs.

    Of a body without springs and gas, of every kind of mesh, and undamped joints: at most half of the longest stable
    one, ω h = 2, and at least an eighth.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(2, 10, 100)):
        for kind in KINDS:
            world, mesh = World(), metre(kind, rng)
            body = world.add_soft_body(mesh, 10.0 ** rng.uniform(-1.0, 1.0), 0.0, 0.0)
            (place,), stiffness, mass = (
                points_inside(mesh, 1, rng),
                rng.uniform(1.0, 1000.0),
                10.0 ** rng.uniform(-1.0, 1.0),
            )
            edge = 0.01
            box = world.add_box((edge, edge, edge), mass, place, random_orientations(rng, 1)[0])
            try:
                hung = world.suspend(box, body, stiffness=stiffness, damping=0.0)
            except softbody.ParameterError:  # too near to the surface
                continue
            arms = corners_of(box.size) @ rotation_matrix(box.orientation).T
            weights = hung.weights[[0, 4, 2, 6, 1, 5, 3, 7]]
            turning = (
                6.0
                / (mass * edge**2)
                * (np.eye(3) * (arms @ arms.T)[:, :, None, None] - arms[None, :, :, None] * arms[:, None, None, :])
            )
            mobility = (
                turning
                + np.eye(3) * (1.0 / mass + len(body.positions) / body.mass * (weights @ weights.T))[:, :, None, None]
            )
            frequency = np.sqrt(stiffness * np.linalg.eigvalsh(mobility.transpose(0, 2, 1, 3).reshape(24, 24))[-1])
            answers.add(0.25 <= world.stable_time_step() * frequency <= 1.0, True, kind=kind)
    return answers.comparison()


@check_suspended(
    piece="softbody.World.suspend",
    reference="the exact winding number, by libigl; whether the box meets a triangle of the skin, by FCL",
    engines=("fcl", "igl"),
    faults=(
        Fault(
            "a skin that pushes out what hangs",
            soft_contacts._find_contacts_with_box,
            "model_.box_host[b_] == a_ → False",
        ),
    ),
)
def shaken_and_inside(run: Run) -> Comparison:
    """What hangs in a shaken body stays in it.

    Balls and blocks with a cube of a tenth to twice their mass are thrown on the ground, at some 5 m/s, and shaken
    thrice: all corners are inside, and nothing of the skin is in the cube, at 30 moments of 2 s.
    """
    from references import fcl, igl

    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(6, 200, 1000)):
        world = World()
        world.add_ground()
        mesh = softbody.icosphere(2, 0.5) if case % 2 else softbody.box((1.0, 0.8, 0.7), 4)
        spring, gas = rng.uniform(200.0, 500.0), rng.uniform(40.0, 80.0)
        body = world.add_soft_body(mesh, 1.0, spring, gas, (0.0, 0.0, 1.0), rng.normal(0.0, 3.0, 3))
        body.velocities = body.velocities + np.cross(rng.normal(0.0, 6.0, 3), body.positions - body.centre)
        box, _ = hang(rng, world, body, body.centre + rng.uniform(-0.1, 0.1, 3), 10.0 ** rng.uniform(-1.0, 0.3))
        arms, inside, free = corners_of(box.size), True, True
        for frame in range(30):
            if frame % 10 == 0:
                body.velocities = body.velocities + rng.normal(0.0, 3.0, 3)
            try:
                world.step_frame(1.0 / 15.0)
            except SimulationError:
                inside = free = False
                break
            corners = box.position + arms @ rotation_matrix(box.orientation).T
            skin, pose = (body.positions, body.triangles), (box.size, box.position, box.orientation)
            inside = inside and bool(igl.points_in_mesh(corners, *skin).all())
            free = free and fcl.depth_in_box(*pose, *skin) == 0.0
        kind = "ball" if case % 2 else "block"
        answers.extend([inside, free], [True, True], kind=[f"{kind}, by libigl", f"{kind}, by FCL"])
    return answers.comparison()


@check_suspended(
    piece="softbody.World.remove, softbody.World.suspended, softbody.World.restore, softbody.World.add_joint",
    reference="a world that was made with what is left, by the same version",
    kind="the core in another form",
    because="the same bits",
    faults=(
        Fault(
            "suspensions on rows of particles",
            builder.without,
            "joints.suspension_particles - count * (joints.suspension_particles > first) → joints.suspension_particles",
        ),
        Fault(
            "suspensions on a row of boxes",
            builder.without,
            "joints.suspension_box - (joints.suspension_box > body) → joints.suspension_box",
        ),
        Fault(
            "points of another suspension", builder._joints_at, "np.cumsum(suspended) - 1 → np.arange(len(suspended))"
        ),
        Fault(
            "weights of what is gone",
            builder._joints_at,
            "np.repeat(suspended_, counts_) → np.arange(len(joints.weight)) < counts[suspended].sum()",
        ),
        Fault("what hangs is not inside", builder.with_box_inside, "hosts[box] = body → pass"),
        Fault("a handle that follows another", adding.remove, "int(stay[of][:number].sum()) → number"),
        Fault(
            "joints that outlive what hung",
            builder.joints_that_stay,
            "~((joints.joint_particles >= first) & (joints.joint_particles < end)).any(axis=1) & held"
            " → ~((joints.joint_particles >= first) & (joints.joint_particles < end)).any(axis=1)",
        ),
        Fault(
            "a name of another",
            inventory.Inventory.__getitem__,
            "kinds.get(kind, Suspended)(self, index) → kinds.get(kind, Suspended)(self, 0)",
        ),
    ),
)
def what_is_left(run: Run) -> Comparison:
    """What hangs goes with its body and stays with others'.

    Bodies, boxes and suspensions were removed from a world, and it was saved and restored: it has the bits of one that
    was made so, and names find what they did.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(4, 12, 60)):
        seed = int(rng.integers(2**31))
        try:
            one, other = (_left(np.random.default_rng(seed), case % 4, later) for later in (False, True))
        except Exception:  # of a damaged core
            answers.add(False, True, kind="is made")
            continue
        for name in one:
            same = bool(np.array_equal(one[name], other[name]))
            answers.add(same, True, kind=name)
    return answers.comparison()


def _left(rng: np.random.Generator, goes: int, later: bool) -> dict[str, np.ndarray]:
    """Return what is told of a world after 0.05 s: made as it is, or with things that were taken out again."""
    world, extra = World(), list[Any]()
    world.add_ground(-3.0)
    ball = softbody.icosphere(1, 0.5)

    def hung(k: int, name: str | None) -> tuple[SoftBody, Box, Suspended, Suspended]:
        body = world.add_soft_body(ball, 1.0, 200.0, 20.0, (3.0 * k, 0.0, 0.0), (0.0, 0.1 * k, 0.0))
        points = world.suspend([body.centre, body.centre + 0.1], body)
        box = world.add_box((0.2, 0.2, 0.2), 0.5, body.centre)
        return body, box, points, world.suspend(box, body, name=name)

    if later:
        gone = hung(-1, "gone")
        world.add_joint((gone[2], 0), (-3.0, 0.0, 3.0), 1.0)
        extra += [gone[goes]]
        if goes:
            extra += [world.soft_bodies[0], *([] if goes == 1 else world.boxes)]
    sets = [hung(k, f"n° {k}") for k in range(2)]
    points = [each[2] for each in sets]
    if later:
        more = world.suspend([sets[0][0].centre - 0.1] * 3, sets[0][0])
        world.add_joint((more, 2), (points[1], 1), 5.0)
        extra.append(more)
    world.add_joint((points[0], 1), (points[1], 0), rng.uniform(1.0, 5.0), 0.1)
    world.add_joint((points[1], 1), rng.normal(size=3), rng.uniform(1.0, 5.0))
    if later:
        for each in extra:
            if each.is_there:
                world.remove(each)
        for box in world.boxes:
            if box not in (sets[0][1], sets[1][1]):
                world.remove(box)
        again = World()
        again.restore(world.snapshot())
        answers = [again[f"n° {k}"].index for k in range(2)]
        world.step(1e-3, 50)
        again.step(1e-3, 50)
        told = np.array([again.state_hash() == world.state_hash()])
    else:
        answers = [each[3].index for each in sets]
        world.step(1e-3, 50)
        told = np.array([True])
    state = world.state
    return {
        "numbers": np.array([*answers, len(world.suspended), len(world.joints), len(world.boxes)]),
        "handles": np.array([each[3].index for each in sets]),
        "restored": told,
        "hosts": world.model.box_host,
        "points": np.concatenate([each.positions for each in world.suspended]),
        "particles": state.particle_position,
        "boxes": state.box_position,
    }
