"""Claims that bodies float, sink, tilt and bob in a liquid as they must."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

import softbody
from references import floating
from softbody import Box, Liquid, SoftBody, World
from softbody.bodies import adding
from softbody.bodies.body import SleepyBody
from softbody.bodies.surroundings import Surroundings
from softbody.dynamics import acting, liquid_forces
from softbody.dynamics import energy as energies
from softbody.geometry import submerged
from softbody.scenes import pool
from softbody.storage import snapshot
from validation.answers import Answers
from validation.cases import MESH_KINDS, random_mesh, random_orientations, rotation_matrix, settable
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "bodies in a liquid"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

G = 9.81  # [m/s²]
SECTION = "7"


def a_liquid(rng: np.random.Generator, world: World, drag: float = 0.0) -> dict[str, Any]:
    """Add a liquid of some density to a world, its surface at some height; return what was said of it."""
    said: dict[str, Any] = {"density": rng.uniform(500.0, 2000.0), "surface_height": rng.uniform(-2.0, 2.0)}
    said |= {"drag": drag, "velocity": rng.normal(size=3)}
    world.add_liquid(**said)
    return said


@check(
    section=SECTION,
    piece="softbody.World.add_liquid, softbody.SoftBody.buoyancy, softbody.Box.buoyancy, "
    "softbody.SoftBody.submerged_volume, softbody.Box.submerged_volume",
    reference="Archimedes, with the surface as CGAL cuts it, by libigl",
    engines=("igl",),
    unit="of the whole body's share",
    tolerance=5e-14,
    because="rounding on both sides: 1.4e-14 at worst of four seeds",
    faults=(
        Fault(
            "pressure that pulls",
            liquid_forces.press,
            "scale(medium_.push * l_, n_) → scale(-medium.push * wet.load[c], normal)",
        ),
        Fault(
            "a liquid that stands still",
            liquid_forces.press,
            "sub(medium_.flow, v_) → sub((0.0, 0.0, 0.0), medium.flow)",
        ),
        Fault("drag by the whole area", liquid_forces.press, "resistance_ * wet_.share[c_] → resistance / 3.0"),
        Fault(
            "boxes that are pushed at their centres",
            liquid_forces.add_liquid_forces,
            "accumulate(acting_.box_torque, box_, c_) → ",
        ),
        Fault("a surface at zero", SleepyBody._in_liquid, "submerged_part(*s_, h_) → submerged_part(*s_, 0.0)"),
        Fault("corners that do not turn", liquid_forces.corners_of, "load_quaternion(q_, b_) → (1.0, 0.0, 0.0, 0.0)"),
    ),
)
def pushed_by_what_they_displace(run: Run) -> Comparison:
    """A liquid pushes bodies by what they displace.

    In one step from where they are at rest in it, soft bodies of every kind of mesh, without springs and gas, and boxes
    any way up get the momentum and the spin of buoyancy at the centre of what is wet, and of drag at the centre of the
    wet area. What they tell of themselves is that, too.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 6, 40)):
        for kind in [*MESH_KINDS, *["box"] * 3]:
            world, h, drag = World(), 1e-4, rng.uniform(50.0, 500.0)
            liquid = a_liquid(rng, world, drag)
            body, surface = something(rng, world, kind, liquid["surface_height"])
            wet, weight = floating.wet(*surface, liquid["surface_height"]), liquid["density"] * G
            lift, pull = np.array([0.0, 0.0, weight * wet.volume]), drag * wet.area * liquid["velocity"]
            centre = body.position if kind == "box" else body.centre
            torque = np.cross(wet.centre - centre, lift) + np.cross(wet.area_centre - centre, pull)
            told = [body.submerged_volume, *body.buoyancy() / weight]
            world.step(h, allow_unstable=True)
            momentum, spin = world.linear_momentum(), world.angular_momentum()
            force, turn = momentum / h + [0.0, 0.0, body.mass * G], (spin - np.cross(centre, momentum)) / h
            if kind == "box":  # by how it lay when the step began
                turn = body.mass * floating.gyration(body.size, surface[0]) @ body.angular_velocity / h
            found = [*told, *force / weight, *turn / weight]
            answers.add(found, [wet.volume, *lift / weight, *(lift + pull) / weight, *torque / weight], 1.0, kind)
    return answers.comparison()


def something(
    rng: np.random.Generator, world: World, kind: str, level: float
) -> tuple[Any, tuple[np.ndarray, np.ndarray]]:
    """Add a body of about a metre near a level to a world, at rest; return it and its surface.

    A box, or a soft body without springs and gas of a `kind` of mesh.
    """
    place, mass = np.array([*rng.normal(size=2), level + rng.uniform(-0.4, 0.4)]), rng.uniform(100.0, 900.0)
    if kind == "box":
        size, turn = rng.uniform(0.4, 1.5, 3), random_orientations(rng, 1)[0]
        return world.add_box(size, mass, place, turn), floating.box_mesh(size, place, rotation_matrix(turn))
    mesh = random_mesh(kind, rng)
    mesh = mesh.scaled(1.0 / float(np.ptp(mesh.vertices, axis=0).max()))
    mesh = mesh.moved(place - mesh.vertices.mean(axis=0))
    return world.add_soft_body(mesh, mass, 0.0, 0.0), (mesh.vertices, mesh.triangles)


@check(
    section=SECTION,
    piece="softbody.World.add_liquid, softbody.World.energies",
    reference="differences of the energy ρ g ∫ depth dV of what CGAL cuts off, by libigl",
    engines=("igl",),
    unit="of what pressure on the whole surface would give",
    tolerance=1e-8,
    because="differences over 1e-5 of the size, of numbers that are rounded to 1e-16: 1.7e-9 at worst of three seeds",
    faults=(
        Fault(
            "all pressure on the first corner",
            liquid_forces.press,
            "accumulate(f_, c_, on_) → accumulate(force, i, on)",
        ),
        Fault(
            "pressure by thirds", liquid_forces.press, "wet_.load[c_] → (wet.load[0] + wet.load[1] + wet.load[2]) / 3.0"
        ),
        Fault("energy of the displaced at the surface", submerged.submerged_part, "0.5 * down_ * wet_.square → 0.0"),
        Fault("boxes that have no energy", liquid_forces.liquid_energy, "can_be_wet(m_, b_) → False"),
        Fault(
            "a total without liquid", energies.potential_energy, "gravity_ + external_ + liquid_ → gravity + external"
        ),
    ),
)
def pushed_downhill(run: Run) -> Comparison:
    """A liquid's forces are what its energy says.

    The work that they do when particles, one by one, go some way in any direction is what the energy falls by. The
    energy that a world tells is that.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 3, 20)):
        for kind in (*MESH_KINDS, "box"):
            world, h = World(), 1e-4
            liquid = a_liquid(rng, world)
            body, (points, triangles) = something(rng, world, kind, liquid["surface_height"])
            weight = liquid["density"] * G

            depth = partial(floating.depth, triangles=triangles, level=liquid["surface_height"])
            told = world.energies().liquid, world.energy() - world.energies().gravity
            answers.extend(np.array(told) / weight, [depth(points)] * 2, 1.0, f"{kind}, told")
            if kind == "box":
                continue
            world.step(h, allow_unstable=True)
            force = (body.velocities / h + [0.0, 0.0, G]) * body.mass / len(points)
            for _ in range(3):
                way, small = rng.normal(size=points.shape), 1e-5
                falls = (depth(points - small * way) - depth(points + small * way)) / (2.0 * small)
                answers.add((force * way).sum() / weight, falls, 1.0, kind)
    return answers.comparison()


@check(
    section=SECTION,
    piece="softbody.World.suspend, softbody.World.add_liquid",
    reference="Archimedes, of the soft body alone, with the surface as CGAL cuts it, by libigl",
    engines=("igl",),
    unit="of the whole body's share",
    tolerance=5e-14,
    because="rounding on both sides",
    faults=(
        Fault("a box that is wet in a body", liquid_forces.can_be_wet, "model_.box_host[box_] == NOBODY → True"),
        Fault("a box that says that it is wet", Box, "host == NOBODY → True"),
    ),
)
def dry_in_a_body(run: Run) -> Comparison:
    """A box that hangs in a body displaces nothing.

    Balls in a liquid, each with a box in it: in a step both together get the momentum of what the ball displaces. The
    box tells that it displaces nothing, and energy has the ball's share alone.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(8, 30, 200)):
        world, h = World(), 1e-4
        liquid = a_liquid(rng, world)
        body, surface = something(rng, world, "sphere", liquid["surface_height"])
        box = world.add_box(rng.uniform(0.1, 0.3, 3), rng.uniform(1.0, 50.0), body.centre)
        world.suspend(box, body, stiffness=1e3, damping=0.0)
        wet, weight = floating.wet(*surface, liquid["surface_height"]), liquid["density"] * G
        told = [box.submerged_volume, *box.buoyancy(), world.energies().liquid / weight]
        world.step(h, allow_unstable=True)
        force = world.linear_momentum() / h + [0.0, 0.0, (body.mass + float(box.mass or 0.0)) * G]
        judged = [0.0, 0.0, 0.0, 0.0, floating.depth(*surface, liquid["surface_height"])]
        answers.add([*told, *force / weight], [*judged, 0.0, 0.0, wet.volume], 1.0, kind="ball")
    return answers.comparison()


@check(
    section=SECTION,
    piece="softbody.World.add_liquid",
    reference="Archimedes: what floats displaces its mass; the displaced as CGAL cuts it, by libigl",
    engines=("igl",),
    unit="of the displaced volume",
    tolerance=1e-7,
    because="what is left of bobbing after 12 s: 2.6e-9 at worst of four seeds",
    faults=(
        Fault(
            "gravity twice",
            liquid_forces.medium_of,
            "0.5 * model_.liquid_density * gravity_[2] → model_.liquid_density * gravity[2]",
        ),
        Fault("a liquid that does nothing", acting.all_that_acts, "model_.liquid_density > 0.0 → False"),
    ),
)
def floats_at_its_mass(run: Run) -> Comparison:
    """What floats displaces its own mass.

    Boxes, balls and rings, dropped on a liquid that damps them, all in one world, on its default settings.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(2, 4, 30)):
        world = World()
        density, level = rng.uniform(800.0, 2000.0), rng.uniform(-1.0, 1.0)
        world.add_liquid(density, level, drag=0.6 * density)
        for k, kind in enumerate(("box", "box", "ball", "ring")):
            part, place = rng.uniform(0.2, 0.7), (5.0 * k, 0.0, level + 0.5)
            if kind == "box":
                size, tilt = rng.uniform(0.3, 0.5) * np.array([2.0, 2.5, 1.0]), rng.uniform(-0.15, 0.15, 2)
                turn = np.array([1.0, *tilt, 0.0]) / np.linalg.norm([1.0, *tilt])
                world.add_box(size, part * density * size.prod(), place, turn)
            else:
                mesh = softbody.icosphere(2, 0.5) if kind == "ball" else softbody.torus(0.6, 0.25, 16, 10)
                gas = 3e4 * mesh.volume
                world.add_soft_body(mesh, part * density * mesh.volume, 3e4, gas, place)
        world.run(12.0)
        for box in world.boxes:
            surface = floating.box_mesh(box.size, box.position, rotation_matrix(box.orientation))
            answers.add(floating.wet(*surface, level).volume * density / float(box.mass or 0.0), 1.0, 1.0, "box")
        for soft in world.soft_bodies:
            wet = floating.wet(soft.positions, soft.triangles, level)
            answers.add(wet.volume * density / soft.mass, 1.0, 1.0, "soft body")
    return answers.comparison()


@check(
    section=SECTION,
    piece="softbody.World.add_liquid",
    reference="Bouguer's metacentre: upright if and only if (B / H)² > 6 s (1 − s)",
    kind="closed form",
    because="yes or no",
    faults=(
        Fault(
            "a tilt that nothing rights",
            liquid_forces.add_liquid_forces,
            "cross(sub(c_, m_), f_) → scale(0.0, load(force, k))",
        ),
        Fault(
            "pressure at the middle of each cut",
            submerged._cut_off,
            "(4.0 - t_ - u_, t_, u_) → (4.0 / 3.0, 4.0 / 3.0, 4.0 / 3.0)",
        ),
    ),
)
def upright_as_its_metacentre_says(run: Run) -> Comparison:
    """An upright box stays so exactly if its metacentre is above.

    Planks a hundredth wider than that, and less wide, let go with a tilt of a thousandth: in ten seconds of a second
    for each root of their height some come back, the others tip.
    """
    rng, answers = run.fresh_rng(), Answers()
    count = run.count(20, 100, 400)
    world = World()
    world.add_liquid(1000.0, 0.0)
    wide = []
    for k in range(count):
        height, part, is_wide = rng.uniform(0.5, 1.5), rng.uniform(0.2, 0.8), bool(k % 2)
        width = height * np.sqrt(6.0 * part * (1.0 - part) * (1.01 if is_wide else 0.99))
        size, tilt = np.array([width, 3.0, height]), 1e-3
        turn = (np.cos(0.5 * tilt), 0.0, np.sin(0.5 * tilt), 0.0)
        world.add_box(size, 1000.0 * part * size.prod(), (10.0 * k, 0.0, height * (0.5 - part)), turn)
        wide.append(is_wide)
    most = np.zeros(count)
    for _ in range(60):
        world.run(0.25)
        most = np.maximum(most, [2.0 * abs(box.orientation[2]) for box in world.boxes])
    answers.extend(most < 2e-3, wide, kind=["wide" if each else "narrow" for each in wide])
    return answers.comparison()


@check(
    section=SECTION,
    piece="softbody.World.add_liquid",
    reference="closed forms: ω² = ρ g A / m of heave and m g GM / I of roll, by the scheme's own recurrence",
    kind="closed form",
    unit="of the amplitude",
    tolerance=2e-7,
    because="heave is linear, to rounding; a roll of 1e-4 rad is so to its square: 3.6e-8 at worst of four seeds",
    faults=(
        Fault(
            "pressure that leads",
            acting.all_that_acts,
            "add_liquid_forces(m_, g_, s_, ahead_, a_) →"
            " add_liquid_forces(model, controls.gravity, state, ahead, acting); acting.box_force[:] *= 1.001",
        ),
        Fault("boxes a thousandth deeper", liquid_forces.add_liquid_forces, "force[:] = 0.0 → force[:] = 0.001"),
    ),
)
def bobs_and_rolls_in_time(run: Run) -> Comparison:
    """A box bobs and rolls at the frequencies of closed forms."""
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(6, 40, 400)):
        part, height, h, steps = rng.uniform(0.3, 0.7), rng.uniform(0.5, 1.0), 1e-3, 1500
        width, length = height * rng.uniform(1.6, 2.5), rng.uniform(3.0, 4.0)
        density, small = rng.uniform(500.0, 2000.0), 1e-4
        mass = density * part * width * length * height
        rest = height * (0.5 - part)
        for kind in ("heave", "roll"):
            world = World()
            world.add_liquid(density, 0.0)
            turn = (np.cos(0.5 * small), 0.0, np.sin(0.5 * small), 0.0) if kind == "roll" else (1.0, 0.0, 0.0, 0.0)
            lift = 0.1 * height * min(part, 1.0 - part) if kind == "heave" else 0.0
            box = world.add_box((width, length, height), mass, (0.0, 0.0, rest + lift), turn)
            square = density * G * width * length / mass
            if kind == "roll":
                gm = floating.metacentric_height(width, height, part)
                square = G * gm * 12.0 / (width**2 + height**2)
            found = []
            for _ in range(15):
                world.step(h, steps // 15)
                found.append(box.position[2] - rest if kind == "heave" else 2.0 * box.orientation[2])
            start = lift or small
            judged = floating.oscillation(start, square, h, steps)[steps // 15 :: steps // 15]
            answers.add(np.array(found) / start, judged / start, 1.0, kind)
    return answers.comparison()


@check(
    section=SECTION,
    piece="softbody.World.add_liquid, softbody.SoftBody.buoyancy, softbody.Box.buoyancy, "
    "softbody.SoftBody.submerged_volume, softbody.Box.submerged_volume",
    reference="hydrostatics by Capytaine: volume, centre of buoyancy, and the stiffness that waterplane and GM are in",
    engines=("capytaine",),
    unit="of the size; at rest, of 3e-6 of it",
    tolerance=2e-8,
    because="differences over 1e-5 of the size: 5.2e-9 at worst of four seeds, where what is smaller is passed; at "
    "rest rounding: 2e-14",
    faults=(
        Fault(
            "pressure at the middle of each cut",
            submerged._cut_off,
            "(4.0 - t_ - u_, t_, u_) → (4.0 / 3.0, 4.0 / 3.0, 4.0 / 3.0)",
        ),
        Fault(
            "a hundredth less to right it",
            liquid_forces.add_liquid_forces,
            "cross(sub(c_, m_), f_) → scale(0.99, cross(sub(c_, m_), f_))",
        ),
        Fault("a surface at zero", SleepyBody._in_liquid, "submerged_part(*s_, h_) → submerged_part(*s_, 0.0)"),
        Fault(
            "all pressure on the first corner",
            liquid_forces.press,
            "accumulate(f_, c_, on_) → accumulate(force, i, on)",
        ),
    ),
)
def stiff_as_hydrostatics_say(run: Run) -> Comparison:
    """What floats is as stiff as its hydrostatics say.

    Soft bodies of every kind of mesh and boxes any way up: volume, force and torque where they are, and the force and
    torque that heave, roll, pitch and yaw, of a hundred-thousandth about the centre of mass, are met with.
    """
    from references import capytaine

    rng, answers, small = run.fresh_rng(), Answers(), 1e-5
    for _ in range(run.count(1, 4, 30)):
        for kind in [*MESH_KINDS, *["box"] * 3]:
            world = World()
            liquid = a_liquid(rng, world)
            body, (points, triangles) = something(rng, world, kind, liquid["surface_height"])
            level, weight = liquid["surface_height"], liquid["density"] * G
            middle = body.position.copy() if kind == "box" else body.centre.copy()
            judged = capytaine.hydrostatics(points, triangles, middle, level)
            arm = judged.volume * (judged.centre - middle)
            push = partial(
                _push, world, body, body.orientation.copy() if kind == "box" else None, points - middle, middle
            )
            told = [body.submerged_volume, *body.buoyancy() / weight], push(0.0, np.zeros(3)) / weight
            expected = [judged.volume, 0.0, 0.0, judged.volume], [judged.volume, arm[1], -arm[0], 0.0]
            answers.extend(told, expected, 3e-6, f"{kind}, at rest")
            for k, motion in enumerate(("heave", "roll", "pitch", "yaw")):
                heave, *turn = small * np.eye(4)[k]
                less = push(-heave, -np.array(turn)) - push(heave, np.array(turn))
                answers.add(less / (2.0 * small * weight), judged.stiffness[:, k], 1.0, f"{kind}, {motion}")
    return answers.comparison()


def _push(
    world: World,
    body: Any,
    orientation: np.ndarray | None,
    arms: np.ndarray,
    middle: np.ndarray,
    heave: float,
    turn: np.ndarray,
) -> np.ndarray:
    """Return a liquid's force along z [N] and torque (3,) [N m] on a body at rest, moved from where `arms` are.

    About `middle` (3,) [m], by how far one step moves it; it turns about an axis of the world by as much as `turn` is
    long. Boxes have an `orientation`.
    """
    h, place, half = 1e-4, middle + [0.0, 0.0, heave], 0.5 * turn
    part = np.array([np.cos(np.linalg.norm(half)), *np.sinc(np.linalg.norm(half) / np.pi) * half])
    corners = arms @ rotation_matrix(part).T
    if orientation is None:
        body.positions, body.velocities = place + corners, np.zeros_like(arms)
    else:
        w, v = orientation[0], orientation[1:]
        body.orientation = [part[0] * w - part[1:] @ v, *(part[0] * v + w * part[1:] + np.cross(part[1:], v))]
        body.position, body.velocity, body.angular_velocity = place, np.zeros(3), np.zeros(3)
    world.step(h, allow_unstable=True)
    momentum, spin = world.linear_momentum(), world.angular_momentum()
    torque = (spin - np.cross(place, momentum)) / h
    if orientation is not None:  # by how it lay when the step began
        torque = body.mass * floating.gyration(body.size, corners) @ body.angular_velocity / h
    return np.array([momentum[2] / h + body.mass * G, *torque])


@check(
    section=SECTION,
    piece="softbody.World.add_liquid",
    reference="ω² = ρ g A / m of heave and m g GM / I of roll with A and GM by Capytaine; the scheme's own recurrence",
    engines=("capytaine",),
    unit="of the amplitude",
    tolerance=1e-8,
    because="half differences of what moves by 1e-5 leave its square, and rounding: 2.1e-9 at worst of four seeds",
    faults=(
        Fault(
            "pressure that leads",
            acting.all_that_acts,
            "add_liquid_forces(m_, g_, s_, ahead_, a_) →"
            " add_liquid_forces(model, controls.gravity, state, ahead, acting); acting.box_force[:] *= 1.001",
        ),
        Fault(
            "a hundredth less to right it",
            liquid_forces.add_liquid_forces,
            "cross(sub(c_, m_), f_) → scale(0.99, cross(sub(c_, m_), f_))",
        ),
    ),
)
def beams_bob_and_roll_as_hydrostatics_say(run: Run) -> Comparison:
    """Beams bob and roll as their hydrostatics say.

    Square beams that float on an edge, of three to seven tenths of the liquid's density, and planks that float flat.
    """
    from references import capytaine

    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(6, 40, 400)):
        kind, part, h, steps = ("on an edge", "flat")[case % 2], rng.uniform(0.32, 0.68), 1e-3, 1500
        height, density, small = rng.uniform(0.5, 1.0), rng.uniform(500.0, 2000.0), 1e-5
        width = height * (rng.uniform(1.6, 2.5) if case % 2 else 1.0)
        size, lies = np.array([width, rng.uniform(3.0, 4.0), height]), 0.0 if case % 2 else 0.25 * np.pi
        mass, wet = density * part * float(size.prod()), np.sqrt(min(part, 1.0 - part))
        # On an edge a triangle is wet, as deep as it is half as wide, or one is dry.
        deep = height * (np.sqrt(0.5) - wet) * (1.0 if part < 0.5 else -1.0)
        middle = np.array([0.0, 0.0, height * (0.5 - part) if case % 2 else deep])
        turn = np.array([np.cos(0.5 * lies), 0.0, np.sin(0.5 * lies), 0.0])
        judged = capytaine.hydrostatics(*floating.box_mesh(size, middle, rotation_matrix(turn)), middle, 0.0)
        for motion in ("heave", "roll"):
            world, boxes, found = World(), list[Box](), list[float]()
            world.add_liquid(density, 0.0)
            square = density * G * judged.waterplane / mass
            if motion == "roll":
                square = G * judged.metacentric_heights[1] * 12.0 / (width**2 + height**2)
            for sign in (1.0, -1.0):  # half of their difference: what is of even order falls out
                start = np.array([5.0 * sign, 0.0, sign * small * height * (motion == "heave")])
                half = 0.5 * (lies + sign * small * (motion == "roll"))
                boxes.append(world.add_box(size, mass, middle + start, (np.cos(half), 0.0, np.sin(half), 0.0)))
            for _ in range(15):
                world.step(h, steps // 15)
                angles = [2.0 * np.arctan2(box.orientation[2], box.orientation[0]) for box in boxes]
                places = [float(box.position[2]) / height for box in boxes]
                one, other = places if motion == "heave" else angles
                found.append(0.5 * (one - other))
            expected = floating.oscillation(1.0, square, h, steps)[steps // 15 :: steps // 15]
            answers.add(np.array(found) / small, expected, 1.0, f"{kind}, {motion}")
    return answers.comparison()


@check(
    section=SECTION,
    piece="softbody.World.add_liquid",
    reference="closed form: v' = v + h (g' − γ (v − u)), of what is all under the liquid",
    kind="closed form",
    unit="of the fastest",
    tolerance=1e-13,
    because="rounding over 400 steps: 1.1e-14 at worst of three seeds",
    faults=(
        Fault("half of the drag", liquid_forces.medium_of, "0.5 * model_.liquid_drag → 0.25 * model.liquid_drag"),
        Fault("drag of boxes that stand still", liquid_forces.velocities_of, "add(v_, t_) → t_"),
    ),
)
def carried_and_slowed(run: Run) -> Comparison:
    """What is under a liquid that flows is carried along."""
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(6, 40, 400)):
        world, h = World(), 1e-3
        liquid = a_liquid(rng, world, drag=rng.uniform(50.0, 500.0))
        size, part = rng.uniform(0.5, 1.0, 3), rng.uniform(0.9, 1.1)
        mass, v = part * liquid["density"] * size.prod(), rng.normal(size=3)
        place = (0.0, 0.0, liquid["surface_height"] - 20.0)
        box = world.add_box(size, mass, place, random_orientations(rng, 1)[0], v)
        fade = liquid["drag"] * 2.0 * (size * np.roll(size, 1)).sum() / mass
        for _ in range(4):
            world.step(h, 100)
            for _ in range(100):
                v = v + h * (np.array([0.0, 0.0, G * (1.0 / part - 1.0)]) - fade * (v - liquid["velocity"]))
            answers.add(box.velocity.copy(), v, 1.0 + float(np.linalg.norm(v)), "box")
    return answers.comparison()


@check(
    section=SECTION,
    piece="softbody.World.add_liquid",
    reference="the energy, over the first second and over the last",
    kind="invariant",
    unit="of the energy of its bobbing",
    tolerance=3e-3,
    because="what a mean over a second of some swings has: 1.7e-3 at worst of three seeds",
    faults=(
        Fault(
            "bodies where they are, in steps of parts",
            acting.all_that_acts,
            "0.5 * h_ * p_ → 0.0 * h",
        ),
        Fault("bodies where they were", acting.all_that_acts, "0.5 * h_ * p_ → -0.5 * h"),
    ),
)
def bobs_for_ever(run: Run) -> Comparison:
    """Without drag the energy of bobbing stays.

    Of a box, and of a soft ball, by every integrator and in sub-steps, over eight seconds.
    """
    rng, answers = run.fresh_rng(), Answers()
    ball = softbody.icosphere(1, 0.5)
    for _ in range(run.count(1, 3, 20)):
        for integrator, substeps in (("symplectic_euler", 1), ("symplectic_euler", 5), ("rk4", 1), ("rk4", 3)):
            for kind in ("box", "ball"):
                world, part, fall = (
                    World(integrator=integrator, substeps=substeps),
                    rng.uniform(0.3, 0.6),
                    (0.0, 0.0, -0.3),
                )
                world.add_liquid(1000.0, 0.0)
                if kind == "box":
                    body: Any = world.add_box(
                        (1.0, 1.5, 0.5), 750.0 * part, (0.0, 0.0, 0.25 - 0.5 * part), velocity=fall
                    )
                else:
                    mass, place = part * 1000.0 * ball.volume, (0.0, 0.0, 0.5 - part)
                    body = world.add_soft_body(ball, mass, 1e5, 0.0, place, fall, damping=0.0)
                h, means = min(0.2 * world.stable_time_step(), 2e-3), []
                for wait in (0.0, 6.0):
                    world.step(h, round(wait / h))
                    energies = []
                    for _ in range(100):
                        world.step(h, round(0.01 / h))
                        energies.append(world.energy())
                    means.append(np.mean(energies))
                bobbing = 0.5 * body.mass * 0.3**2
                answers.add(means[1], means[0], bobbing, f"{kind}, {integrator}, {substeps}")
    return answers.comparison()


def _again(name: str) -> Callable[[World, Any], None]:
    """Return what sets one number of the liquid by calling add_liquid once more."""

    def add(world: World, value: Any) -> None:
        liquid = world.liquid
        said = {key: getattr(liquid, key) for key in ("density", "surface_height", "drag", "velocity")}
        world.add_liquid(**(said | {name: value}))

    return add


@check(
    section=SECTION,
    piece="softbody.Liquid",
    reference="closed form: h (ρ g V + c A (u − v)) / m − h g, of a box that is half under it",
    kind="closed form",
    unit="of what a step gives",
    tolerance=5e-13,
    because="rounding, of a difference of velocities by a step: 7.8e-14 at worst of three seeds",
    faults=(
        Fault(
            "all four of the liquid",
            Surroundings.set_field,
            "f'{self.kind}_{name}' → f'{self.kind}_{name}'.replace('density', 'drag')",
        ),
        Fault("a liquid without its drag", adding.add_liquid, "Liquid.drag.checked(drag_) → 0.0"),
        Fault("a flow that is read only", Liquid, "self.set_field('velocity', v_) → vector(value, 'velocity')"),
    ),
)
def what_is_set_acts(run: Run) -> Comparison:
    """What is set of a liquid acts from the next step on.

    Its density, surface, drag and velocity, each by itself and by add_liquid once more: on what moves, and on what is
    asleep in it, which wakes. It is told, and the other three as they were.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(2, 10, 60)):
        for name, new in NEW.items():
            for way in ("set", "added again"):
                for mode in ("moving", "asleep"):
                    world = World(sleep_speed=1e-3, sleep_after=0.01)
                    now: dict[str, Any] = {"density": 1000.0, "surface_height": 0.5, "drag": 100.0}
                    now["velocity"] = np.zeros(3)
                    world.add_liquid(**now)
                    size, h = rng.uniform(0.5, 1.0, 3), 1e-3
                    v = np.zeros(3) if mode == "asleep" else rng.normal(size=3)
                    box = world.add_box(size, 500.0 * size.prod(), (0.0, 0.0, 0.5), velocity=v)
                    world.step(h, 30 if mode == "asleep" else 0)
                    is_ready = box.is_asleep == (mode == "asleep") and settable(Liquid) == NEW.keys()
                    now[name] = new(rng)
                    _SET[way](name)(world, now[name])
                    told = [np.allclose(getattr(world.liquid, key), value) for key, value in now.items()]
                    world.step(h)
                    under = now["surface_height"] - 0.5 + 0.5 * size[2]
                    area = size[0] * size[1] + 2.0 * under * (size[0] + size[1])
                    lift = np.array([0.0, 0.0, now["density"] * G * size[0] * size[1] * under])
                    given = h * ((lift + now["drag"] * area * (now["velocity"] - v)) / box.mass - [0.0, 0.0, G])
                    found = (box.velocity - v) / h if is_ready and all(told) else np.full(3, np.inf)
                    answers.add(found, given / h, 1.0 + float(np.linalg.norm(given)) / h, f"{name}, {way}, {mode}")
    return answers.comparison()


NEW: dict[str, Callable[[np.random.Generator], Any]] = {
    "density": lambda rng: rng.uniform(500.0, 2000.0),
    "surface_height": lambda rng: 0.5 + rng.uniform(-0.2, 0.2),
    "drag": lambda rng: rng.uniform(10.0, 500.0),
    "velocity": lambda rng: rng.normal(size=3),
}
_SET: dict[str, Callable[[str], Callable[[World, Any], None]]] = {
    "set": lambda name: lambda world, value: setattr(world.liquid, name, value),
    "added again": _again,
}


@check(
    section=SECTION,
    piece="softbody.World.add_liquid",
    reference="the same world on another number of threads, restored from a snapshot, and filled the other way round",
    kind="invariant",
    unit="m",
    tolerance=1e-12,
    because="the same bits, but where bodies have other numbers: sums in another order",
    faults=(
        Fault(
            "a liquid that snapshots forget",
            snapshot._model,
            "entries.real(f'model.{field}', limits) → 0.0 * entries.real(f'model.{field}', limits)",
        ),
    ),
)
def the_same_again(run: Run) -> Comparison:
    """A world with a liquid goes the same way again.

    By two threads for one, restored in mid-run from a snapshot, and with its bodies, of which two are full of another
    liquid, one with a box inside, added in another order.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 4, 20)):
        parts = rng.uniform(0.3, 1.2, 6)

        def filled(order: Sequence[int], parts: np.ndarray = parts, threads: int = 1) -> tuple[World, dict[int, Any]]:
            world, bodies = World(threads=threads), dict[int, Any]()
            world.add_ground(-3.0)
            world.add_liquid(1000.0, 0.0, drag=100.0, velocity=(0.2, 0.0, 0.0))
            for k in order:
                place, mesh = (1.5 * (k % 3), 2.0 * (k % 2), 0.8), softbody.icosphere(2, 0.5)
                if k % 2:
                    bodies[k] = world.add_box((0.9, 0.8, 0.7), parts[k] * 504.0, place, (0.8, 0.6, 0.0, 0.0))
                else:
                    inside = 500.0 * parts[k] if k else 0.0
                    bodies[k] = world.add_soft_body(mesh, parts[k] * 200.0, 2e4, 1e4, place, liquid_density=inside)
            bodies[2].liquid_drag = 100.0
            bodies[7] = world.add_box((0.2, 0.15, 0.1), 8.0 * parts[0], bodies[2].centre, inside=bodies[2])
            return world, bodies

        def centres(bodies: dict[int, Any]) -> np.ndarray:
            return np.array([bodies[k].centre if k % 2 == 0 else bodies[k].position for k in (*range(6), 7)])

        (first, there), h = filled(range(6)), 1e-3
        first.step(h, 100)
        again = World()
        again.restore(first.snapshot())
        first.step(h, 400)
        again.step(h, 400)
        threaded, others = filled(range(6), threads=2)
        threaded.step(h, 500)
        turned, back = filled(range(5, -1, -1))
        turned.step(h, 500)
        expected = centres(there)
        answers.extend(centres(others), expected, 1.0, "threads")
        answers.extend(centres(back), expected.copy(), 1.0, "another order")
        same = [again.state_hash() == first.state_hash(), threaded.state_hash() == first.state_hash()]
        answers.extend(np.where(np.array(same)[:, None], 0.0, np.inf) * np.ones((2, 3)), np.zeros((2, 3)), 1.0, "bits")
    return answers.comparison()


@check(
    section=SECTION,
    piece="softbody.scenes.pool",
    reference="Archimedes, with the surface as CGAL cuts it, by libigl; statics of what lies on the ground",
    engines=("igl",),
    unit="of the weight",
    tolerance=5e-8,
    because="what is left of bobbing and rolling after 30 s: 2.3e-9",
    faults=(
        Fault("a pool of oil", pool.build, "world.add_liquid(1000.0, f_, drag=d_) → world.add_liquid(990.0, drag=d_)"),
        Fault("an empty pool", pool.build, "world.add_liquid(1000.0, f_, drag=d_) → "),
    ),
)
def a_pool_carries_what_is_light(run: Run) -> Comparison:
    """In the pool four densities float, and one sinks.

    Of each body, what the water carries, and what the ground does.
    """
    answers = Answers()
    world = pool.build()
    world.run(30.0)
    touching = world.contact_points()
    bodies: list[Box | SoftBody] = [*world.boxes, *world.soft_bodies]
    for body in bodies:
        density = float(str(body.name).split()[2])
        if isinstance(body, Box):
            surface = floating.box_mesh(body.size, body.position, rotation_matrix(body.orientation))
            weight = G * density * float(np.prod(pool.SIZE))
        else:
            surface, weight = (body.positions, body.triangles), G * density * softbody.icosphere(2, pool.RADIUS).volume
        carried = G * 1000.0 * floating.wet(*surface, 0.0).volume / weight
        ground = float(touching.force_on(body)[2]) / weight
        answers.add([carried + ground, float(ground == 0.0)], [1.0, float(density < 1000.0)], 1.0, str(body.name))
    return answers.comparison()
