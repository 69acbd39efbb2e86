"""Joints: damped springs between points of bodies, and between bodies and places in the world."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from softbody import Box, Joint, SimulationError, SoftBody, World, icosphere, octahedron
from softbody.bodies import adding, builder, joint
from softbody.dynamics import acting, joint_forces
from softbody.storage import snapshot
from validation.answers import Answers
from validation.cases import edge_lengths, random_orientations, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.worlds.cases import WEIGHTLESS, by_turns, same_bits
from validation.fault import Fault

FAMILY = "joints"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

check_joints = partial(check, section="5.1")

INTEGRATORS = ("rk4_velocity", "rk4", "symplectic_euler")


@check_joints(
    piece="softbody.World.add_joint",
    reference="SciPy's DOP853 on Newton's and Euler's equations, by their own force law",
    engines=("scipy",),
    unit="of the way; hundredths of it for the paper's integrator",
    tolerance=1e-5,
    because="steps of 1/40 of the stable one and half of it, extrapolated to none (Richardson): 8e-7 at worst, and 5e-5"
    " where the paper's integrator fades what swings",
    faults=(
        Fault("ends where they will be later", acting.all_that_acts, "0.5 * h * p_ → 1e-3"),
        Fault("the force on one end only", joint_forces.add_joint_forces, "scale(-1.0, force_) → scale(-0.0, force)"),
        Fault(
            "a pull that is half as stiff again",
            joint_forces._force,
            "scale(-stiffness_, away_) → scale(-1.5 * stiffness, away)",
        ),
        Fault(
            "a length at rest a hundredth off",
            joint_forces._force,
            "stiffness_ * (rest_ - length_) → stiffness * (1.01 * rest - length)",
        ),
        Fault("no damping along the joint", joint_forces._force, "damping_ * dot(closing_, along_) → 0.0"),
        Fault("no damping of what is pulled", joint_forces._force, "scale(damping_, closing_) → scale(0.0, closing)"),
        Fault(
            "a force at the box's centre",
            joint_forces._act,
            "cross(_arm(state_, joints_, k_, end_), force_) → scale(0.0, force)",
        ),
        Fault(
            "an arm that does not turn with the box",
            joint_forces._arm,
            "rotate(load_quaternion(q_, b_), _place(j_, k_, e_)) → _place(joints, k, end)",
        ),
        Fault(
            "the first corner of a triangle takes all",
            joint_forces._act,
            "scale(point_.weights[c_], force_) → scale(1.0 if c == 0 else 0.0, force)",
        ),
        Fault(
            "a place on a box taken in the world's frame",
            joint._end,
            "rotation_matrix(body_.orientation).T @ away_ → away",
        ),
    ),
)
def chains_by_scipy(run: Run) -> Comparison:
    """Chains of cubes and spring bodies swing as SciPy has it.

    Two of each hang between places of the world, joined at corners, particles and points of triangles, with and without
    a length at rest: 0.4 s, with each integrator.
    """
    from references.joined import Cube, Joined, Net, motion

    rng, answers, solid = run.fresh_rng(), Answers(), octahedron(0.3)
    for case in range(run.count(2, 4, 40)):
        gravity = np.array([0.0, 0.0, -9.81]) if case % 2 else rng.normal(size=3)
        turns, spins = random_orientations(rng, 2), rng.normal(0.0, 2.0, (2, 3))
        edges, masses = rng.uniform(0.2, 0.4, 2), rng.uniform(0.5, 3.0, 2)
        stiffness = rng.uniform(2000.0, 5000.0, 2)
        places, speeds = np.array([(0.0, 0.0, -1.0), (0.0, 1.0, -2.2)]), rng.normal(size=(2, 3))
        # By turns far apart, so that nothing touches: cube, body, cube, body.
        flat, corner = np.zeros(6), solid.triangles[5]
        flat[corner] = weights = rng.dirichlet(np.ones(3))
        numbers = [
            (rng.uniform(20.0, 60.0), rng.uniform(0.5, 3.0), rest)
            for rest in (0.0, rng.uniform(0.6, 0.9), rng.uniform(1.8, 2.3), rng.uniform(2.7, 3.3), 0.0)
        ]
        arms = rng.uniform(-0.1, 0.1, (3, 3))
        cubes = [
            Cube(edges[k], masses[k], np.array([2.0 * k, 0.0, 0.0]), rotation_matrix(turns[k]), speeds[k], spins[k])
            for k in range(2)
        ]
        springs = solid.edges, edge_lengths(solid.vertices, solid.edges)
        nets = [Net(1.0 / 6, solid.vertices + places[k], np.zeros((6, 3)), *springs, stiffness[k]) for k in range(2)]
        ends = [
            (("cube", 0, arms[0]), ("place", (0.0, 0.0, 1.0))),
            (("cube", 0, arms[1]), ("net", 0, np.eye(6)[2])),
            (("net", 0, flat), ("cube", 1, arms[2])),
            (("net", 1, flat), ("cube", 1, -arms[2])),
            (("place", places[1] + 0.2), ("net", 1, np.eye(6)[4])),
        ]
        where, _ = motion(cubes, nets, [Joined(*pair, *number) for pair, number in zip(ends, numbers)], gravity, 0.4)
        begin = np.concatenate([[c.position for c in cubes], *[net.position for net in nets]])
        farthest = np.linalg.norm(where - begin, axis=1).max()
        for integrator in INTEGRATORS:
            found = []
            for finer in (1, 2):
                world = World(gravity, integrator=integrator)
                boxes = [
                    world.add_box(np.full(3, c.edge), c.mass, c.position, turns[k], c.velocity, c.angular_velocity)
                    for k, c in enumerate(cubes)
                ]
                bodies = [
                    world.add_soft_body(solid, 1.0, net.stiffness, 0.0, place, damping=0.0)
                    for net, place in zip(nets, places)
                ]
                pairs: list[Any] = [
                    (_on_box(boxes[0], arms[0]), (0.0, 0.0, 1.0)),
                    (_on_box(boxes[0], arms[1]), (bodies[0], 2)),
                    (_on_face(bodies[0], corner, weights), _on_box(boxes[1], arms[2])),
                    (_on_face(bodies[1], corner, weights), _on_box(boxes[1], -arms[2])),
                    (places[1] + 0.2, (bodies[1], 4)),
                ]
                for (a, b), number in zip(pairs, numbers):
                    world.add_joint(a, b, *number)
                steps = finer * int(np.ceil(40 * 0.4 / world.stable_time_step()))
                world.step(0.4 / steps, steps)
                found.append(np.concatenate([world.state.box_position, world.state.particle_position]))
            coarse = 100.0 if integrator == "rk4_velocity" else 1.0  # it fades what swings, by z²/4 a step
            answers.extend(2.0 * found[1] - found[0], where, coarse * farthest, integrator)
    return answers.comparison()


def _on_box(box: Box, arm: np.ndarray) -> tuple[Box, np.ndarray]:
    """Return an end at `arm` (3,) [m] in the frame of a box, as a user says it."""
    return box, box.position + rotation_matrix(box.orientation) @ arm


def _on_face(body: SoftBody, corners: np.ndarray, weights: np.ndarray) -> tuple[SoftBody, np.ndarray]:
    """Return an end in a triangle, as a user says it."""
    return body, weights @ body.positions[corners]


@check_joints(
    piece="softbody.World.add_joint, softbody.World.stable_time_step",
    reference="closed form: Hooke's law, the load shared by parallel joints",
    kind="closed form",
    unit="of the stretch",
    tolerance=1e-8,
    because="what is left of the swinging after as long: 4e-10 at worst",
    faults=(
        Fault(
            "stiffness off by a thousandth",
            joint_forces._force,
            "scale(-stiffness_, away_) → scale(-1.001 * stiffness, away)",
        ),
        Fault("a step of any length for joints", joint_forces.joint_rates, "np.sqrt(most[0]) → 0.2 * np.sqrt(most[0])"),
    ),
)
def hanging_by_hooke(run: Run) -> Comparison:
    """What hangs on a joint stretches it by m g / k.

    A box of any weight does, and a soft ball at a particle, at a point of a triangle and at three of them; in steps of
    0.9 of the stable one.
    """
    rng, answers, ball = run.fresh_rng(), Answers(), icosphere(1, 0.3)
    for _ in range(run.count(2, 5, 50)):
        stiffness, mass = 10.0 ** rng.uniform(2.0, 4.0), float(np.exp(rng.uniform(-2.0, 2.0)))
        world = World()
        box = world.add_box(rng.uniform(0.1, 0.5, 3), mass)
        critical = 2.0 * np.sqrt(stiffness * mass)
        hang = world.add_joint((box, box.position), (0.0, 0.0, 0.1), stiffness, 0.1 * critical)
        answers.add(_pull(world, 300.0 * np.sqrt(mass / stiffness), [hang]) / (mass * 9.81), 1.0, kind="box")
        triangle = [(0.05, 0.02 + 0.1 * k, 0.3) for k in range(3)]
        ends: dict[str, list[Any]] = {"particle": [0], "triangle": triangle[:1], "three": triangle}
        for kind, places in ends.items():
            world = World(integrator="rk4")
            soft = world.add_soft_body(ball, 0.5, 300.0, 20.0, damping=0.5, drag=3.0)
            joints = [world.add_joint((soft, place), (0.0, 0.0, 0.8), stiffness, 1.0) for place in places]
            for each in joints:
                each.target = each.ends[0]
            answers.add(_pull(world, 12.0, joints) / (0.5 * 9.81), 1.0, kind=kind)
    return answers.comparison()


def _pull(world: World, seconds: float, joints: list[Joint]) -> float:
    """Return with which force [N] joints hold up, by their ends, what has come to rest in `seconds`; 0: it diverged."""
    try:
        world.run(seconds, 0.9 * world.stable_time_step())
    except SimulationError:
        return 0.0
    return float(sum(each.stiffness * (each.ends[1] - each.ends[0])[2] for each in joints))


@check_joints(
    piece="softbody.World.remove, softbody.World.load, softbody.Joint",
    reference="a world that was made with what is left, by the same version",
    kind="the core in another form",
    because="the same bits",
    faults=(
        Fault(
            "joints that stay on a row of boxes",
            builder.without,
            "joints.joint_box - (joints.joint_box > body) → joints.joint_box",
        ),
        Fault(
            "joints that stay on rows of particles",
            builder.without,
            "joints.joint_particles - count * (joints.joint_particles > first) → joints.joint_particles",
        ),
        Fault(
            "joints lost with any box",
            builder.joints_that_stay,
            "~(joints.joint_box == body).any(axis=1) → (joints.joint_box != joints.joint_box).any(axis=1)",
        ),
        Fault("a handle that follows another joint", adding.remove, "int(stay[of][:number].sum()) → number"),
        Fault(
            "joints that are not read again",
            snapshot._checked,
            "Snapped(m_, c_, s_, j_, n_, r_, i_, k_, p_, d_, t_)"
            " → Snapped(m_, c_, s_, no_joints(), n_, r_, i_, k_, p_, d_, t_)",
        ),
        Fault("stiffness that is only read again", joint.JointNumber.__set__, "joint.store.replace(joints=j_) → None"),
        Fault("the other end moved", joint.Joint._place_of_target, "b_[r_, 3 * end_ : 3 * end_ + 3] → b_[r_, 0:3]"),
    ),
)
def joints_of_what_is_left(run: Run) -> Comparison:
    """Joints go with their bodies and stay with others'.

    Bodies and joints were removed from a world, it was saved and loaded, or its joints were set later: it has the bits
    of one that was made so.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(2, 6, 40)):
        stiffness, targets = rng.uniform(20.0, 100.0, 5), rng.normal(size=(2, 3))
        one, other = (_what_is_left(stiffness, targets, later).state for later in (False, True))
        for name in ("particle_position", "particle_velocity", "box_position", "box_velocity", "box_orientation"):
            same = same_bits(getattr(one, name), getattr(other, name))
            answers.extend(same, np.ones(len(same), bool))
    return answers.comparison()


def _what_is_left(stiffness: np.ndarray, targets: np.ndarray, later: bool) -> World:
    """Return a world after 0.2 s: made as it is, or with bodies and joints that were taken out, and set later."""
    world = World()
    extra: list[Box | SoftBody | Joint] = []
    if later:
        extra.append(world.add_box((0.2, 0.2, 0.2), 1.0, (5.0, 0.0, 0.0)))
        extra.append(world.add_soft_body(octahedron(0.2), 1.0, 3000.0, 0.0, (5.0, 1.0, 0.0)))
    # Of each kind there is one more behind those that are joined: who goes on to a wrong row finds a body there.
    boxes = [world.add_box((0.3, 0.3, 0.3), 1.0, (0.0, 0.0, 2.0 * k)) for k in range(3)]
    softs = [world.add_soft_body(octahedron(0.3), 1.0, 3000.0, 0.0, (0.0, 1.5, 2.0 * k)) for k in range(3)]
    if later:
        world.add_joint((world.boxes[0], (5.0, 0.0, 0.1)), (boxes[0], (0.0, 0.0, 0.0)), 30.0)
    numbers, places = (np.ones(5), np.zeros((2, 3))) if later else (stiffness, targets)
    joints = [world.add_joint((boxes[0], (0.1, 0.1, 0.0)), places[0], numbers[0], 0.2)]
    if later:
        extra.insert(0, world.add_joint((softs[0], 0), (0.0, 0.0, 4.0), 30.0))
        world.add_joint((world.soft_bodies[0], 3), (0.0, 0.0, 3.0), 30.0)
    joints.append(world.add_joint((softs[0], 1), (boxes[0], (0.0, 0.1, 0.0)), numbers[1], 0.2, 0.5))
    joints.append(world.add_joint(places[1], (softs[0], 4), numbers[2], 0.1))
    joints.append(world.add_joint((boxes[1], (0.0, 0.0, 2.0)), (softs[1], 2), numbers[3], 0.1, 1.0))
    joints.append(world.add_joint((boxes[1], (0.0, 0.0, 2.1)), (1.0, 0.0, 3.0), numbers[4]))
    if later:
        for each in extra:
            world.remove(each)
        for each, value in zip(joints, stiffness):
            if each.is_there:
                each.stiffness = value
        for each, target in zip((joints[0], joints[2]), targets):
            if each.is_there:
                each.target = target
        again = World()
        again.restore(world.snapshot())
        world = again
    world.step(1e-3, 200)
    return world


@check_joints(
    piece="softbody.dynamics.acting.all_that_acts",
    reference="closed form: Hooke's law and damping at these places; the momentum of each body before and after",
    kind="closed form",
    unit="of the momentum given",
    tolerance=5e-14,
    because="rounding: 2.3e-15 at worst of ten seeds",
    faults=(
        Fault(
            "the time of one scheme taken for that of another",
            acting.all_that_acts,
            "settings_.integrator == RK4 → settings.integrator != RK4",
        ),
        Fault("ends where they are now", joint_forces._end, "scale(ahead_, v_) → scale(0.0, v)"),
        Fault("forces of the step before", acting.all_that_acts, "acting_.particle_force[:] = 0.0 → "),
        Fault("sub-steps that are not counted", acting.all_that_acts, "1.0 / settings_.substeps → 1.0"),
    ),
)
def ends_half_way(run: Run) -> Comparison:
    """Joints pull by where their ends are half-way through a step.

    In each step they give bodies, besides what forces do, h times that pull. Ends on soft bodies of
    the Runge–Kutta scheme are ahead by ½ h v. Of n sub-steps of the others it is ½ h (1 − 1/n) v; those on boxes are
    where they are.
    """
    rng, answers, mesh = run.fresh_rng(), Answers(), octahedron(0.3)
    corner = mesh.triangles[3]
    for case in range(run.count(6, 30, 300)):
        for integrator in INTEGRATORS:
            world, h, parts = World(WEIGHTLESS, integrator=integrator), 1e-3, int(rng.integers(1, 5))
            softs = [
                world.add_soft_body(mesh, rng.uniform(0.5, 2.0), 500.0, 1.0, (3.0 * k, 0.0, 0.0)) for k in range(2)
            ]
            box = world.add_box((0.2, 0.3, 0.4), 1.5, (0.0, 3.0, 0.0), velocity=rng.normal(size=3))
            for body in softs:
                body.velocities[:] = rng.normal(size=(1, 3)) + 0.3 * rng.normal(size=(6, 3))
                if case % 2:
                    body.external_force = rng.normal(size=(6, 3))
            outside = rng.normal(size=3)
            box.apply_force(outside)
            # Joints from end to end: particles, a point of a triangle, the middle of a box, a place in the world.
            weights, particle, place = rng.dirichlet(np.ones(3)), int(rng.integers(6)), rng.normal(size=3)
            on_face, middle = _on_face(softs[1], corner, weights), (box, box.position)
            ends: list[Any] = [(softs[0], particle), (softs[1], particle), on_face, middle, place]
            pairs = ((0, 1), (0, 2), (1, 3), (2, 3), (2, 4), (3, 4), (4, 0))
            numbers = [
                (rng.uniform(10.0, 100.0), rng.uniform(0.1, 1.0), float(rng.choice([0.0, rng.uniform(0.5, 2.0)])))
                for _ in pairs
            ]
            for (a, b), number in zip(pairs, numbers):
                world.add_joint(ends[a], ends[b], *number)
            ahead = 0.5 * h * (1.0 if integrator == "rk4" else 1.0 - 1.0 / parts)
            for _ in range(2):
                # Whose each end is, where it will be, and how fast it is.
                told = [(k, body.positions[particle], body.velocities[particle]) for k, body in enumerate(softs)]
                told.append((1, weights @ softs[1].positions[corner], weights @ softs[1].velocities[corner]))
                told = [(whose, where + ahead * v, v) for whose, where, v in told]
                told += [(2, box.position, box.velocity), (3, place, np.zeros(3))]
                given = np.zeros((4, 3))
                given[:3] = h * np.array([*(body.external_force.sum(axis=0) for body in softs), outside])
                for (a, b), (stiffness, damping, rest) in zip(pairs, numbers):
                    away, closing = told[a][1] - told[b][1], told[b][2] - told[a][2]
                    force = damping * closing - stiffness * away
                    if rest:
                        along = away / np.linalg.norm(away)
                        force = (force @ along + stiffness * rest) * along
                    given[told[a][0]] += h * force
                    given[told[b][0]] -= h * force
                before = _momenta(world)
                world.step(h, substeps=parts)
                answers.extend(_momenta(world) - before, given[:3], np.linalg.norm(given[:3]), integrator)
    return answers.comparison()


@check_joints(
    piece="softbody.dynamics.acting.all_that_acts",
    reference="free flight: the velocities before",
    kind="closed form",
    unit="m/s",
    least=4,
    tolerance=0.0,
    because="the same bits",
    faults=(
        Fault("a push along x", joint_forces._force, "return 0.0, 0.0, 0.0 → return 1.0, 0.0, 0.0"),
        Fault("a direction of 0/0", joint_forces._force, "length == 0.0 → length < 0.0"),
    ),
)
def ends_at_one_place(run: Run) -> Comparison:
    """A joint whose two ends are at one place pushes neither.

    It has a length at rest, and could push any way. A box or a particle that it ties to a place, or to each other, goes
    on as it was.
    """
    rng, answers, mesh = run.fresh_rng(), Answers(), octahedron(0.3)
    kinds = "box and place", "particle and place", "particle and box"
    for case, kind in enumerate(by_turns(run.count(12, 60, 600), *kinds)):
        world = World(WEIGHTLESS, integrator=INTEGRATORS[case // 3 % 3])
        place, particle = rng.integers(-100, 101, 3) / 32.0, int(rng.integers(6))
        velocity, spin = np.zeros(3), np.zeros(3)
        if kind == "box and place":  # it may move: the force is by where its end is now
            velocity, spin = rng.normal(size=(2, 3))
        ends: list[Any] = []
        if kind != "particle and place":
            box = world.add_box((1.0, 1.0, 1.0), 1.0, place, velocity=velocity, angular_velocity=spin)
            ends.append((box, place))
        if kind != "box and place":
            body = world.add_soft_body(mesh, 1.0, 0.0, 0.0, (0.0, 0.0, 0.0))
            body.positions = mesh.vertices + (place - mesh.vertices[particle])
            ends.append((body, particle))
            body.positions[particle] = place
            if kind == "particle and box":
                box.position = place + (0.0, 0.0, 3.0)  # so far away that they do not touch
                ends[0] = (box, place)
        if kind != "particle and box":
            ends.append(place)
        one, other = ends
        world.add_joint(one, other, rng.uniform(10.0, 100.0), rng.uniform(0.0, 1.0), rng.uniform(0.1, 1.0))
        before = _velocities(world)
        world.step(1e-3)
        answers.extend(_velocities(world), before, kind=kind)
    return answers.comparison()


def _velocities(world: World) -> np.ndarray:
    """Return the velocities [m/s] of all particles, then of all boxes."""
    return np.concatenate([world.state.particle_velocity, world.state.box_velocity])


def _momenta(world: World) -> np.ndarray:
    """Return the momentum (b + m, 3) [N s] of each body."""
    softs = [body.mass * body.velocities.mean(axis=0) for body in world.soft_bodies]
    return np.array([*softs, *(box.mass * box.velocity for box in world.boxes)])
