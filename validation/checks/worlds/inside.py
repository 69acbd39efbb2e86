"""Claims that boxes inside soft bodies are held by the skin, and borne up and dragged by a liquid."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

import softbody
from references import igl, trimesh
from softbody import Box, SimulationError, SoftBody, World
from softbody.bodies import builder
from softbody.bodies.rigid_box import Box as BoxHandle
from softbody.collision.soft import soft_box, soft_contacts
from softbody.dynamics import acting, boxes_inside, filling, integrators, pressure
from softbody.scenes import boxes_in_bags
from validation.answers import Answers
from validation.cases import MESH_KINDS, corners_of, dented_sphere, random_mesh, random_orientations, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.worlds.cases import WEIGHTLESS
from validation.fault import Fault

FAMILY = "boxes inside bodies"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

check_inside = partial(check, section="7")


def with_boxes(rng: np.random.Generator, kind: str, gas: float = 1.0) -> tuple[World, SoftBody, list[Box], float]:
    """Return a world of any gravity, a body of about a metre full of a liquid, boxes inside, and the skin's mass [kg].

    The body has no springs. Its `gas` is that times ρ g d V, with d its extent.
    """
    mesh = random_mesh(kind, rng)
    mesh = mesh.scaled(1.0 / float(np.ptp(mesh.vertices, axis=0).max())).moved(rng.normal(size=3))
    world, skin, density = World(gravity=rng.normal(0.0, 5.0, 3)), rng.uniform(1.0, 100.0), rng.uniform(500.0, 2000.0)
    weight = density * mesh.volume * float(np.linalg.norm(world.gravity))
    body = world.add_soft_body(mesh, skin, 0.0, gas * weight, liquid_density=density)
    boxes = list[Box]()
    for place in rng.uniform(mesh.vertices.min(axis=0), mesh.vertices.max(axis=0), (400, 3)):
        size, turn = rng.uniform(0.02, 0.12, 3), random_orientations(rng, 1)[0]
        mass = size.prod() * 10.0 ** rng.uniform(2.0, 4.0)
        free = all(np.linalg.norm(place - box.position) > 0.25 for box in boxes)
        if free and len(boxes) < 3:
            try:
                boxes.append(world.add_box(size, mass, place, turn, inside=body))
            except softbody.ParameterError:  # it does not fit there
                continue
    return world, body, boxes, skin


@check_inside(
    piece="softbody.World.add_box, softbody.Box.inside, softbody.Box.buoyancy, softbody.World.energies",
    reference="Archimedes: weights at their centres, and what boxes displace, with volume and centre by trimesh",
    engines=("trimesh",),
    unit="of the whole body's share",
    tolerance=2e-14,
    because="rounding on both sides: 3.3e-15 at worst of two seeds",
    faults=(
        Fault(
            "boxes that the liquid does not bear", boxes_inside.add_forces_inside, "scale(-d_ * v_, g_) → scale(0.0, g)"
        ),
        Fault(
            "pressure of a liquid in the boxes, too",
            filling._around_boxes,
            "model_.soft_boxes_volume[body_] == 0.0 → True",
        ),
        Fault(
            "liquid that stays where a box comes",
            builder.with_hosts,
            "with_liquid_mass(m_, b_, liquid_mass(before, body)) → model",
        ),
        Fault("a liquid that fills the boxes", filling.liquid_mass, "m_[b_] - model_.soft_boxes_volume[b_] → m_[b_]"),
        Fault(
            "a box that tells of no liquid", BoxHandle._in_liquid, "volume_of_box(m_, r_) if mass_ > 0.0 else 0.0 → 0.0"
        ),
    ),
)
def borne_up_by_what_they_displace(run: Run) -> Comparison:
    """A liquid bears boxes up by what they displace.

    In one step from rest, under gravity in any direction, boxes of a tenth to ten times the liquid's density get the
    momentum of their weight less that of the liquid in their place, and all together that of all weights, at their
    centres. Masses, energies, buoyancy and submerged volumes tell that, too.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 6, 40)):
        for kind in MESH_KINDS:
            world, body, boxes, skin = with_boxes(rng, kind)
            if not boxes:
                continue
            h, g, size = 1e-4, world.gravity.copy(), float(np.linalg.norm(world.gravity))
            whole, points, density = trimesh.volume(body.positions, body.triangles), body.positions, body.liquid_density
            volumes, places = np.array([box.size.prod() for box in boxes]), np.array([box.position for box in boxes])
            masses = np.array([box.mass for box in boxes])
            room = whole - volumes.sum()
            liquid = density * room
            centre = (whole * trimesh.centroid(points, body.triangles) - volumes @ places) / room
            moments = skin * points.mean(axis=0) + liquid * centre + masses @ places
            told = [body.mass, -world.energies().gravity / size]
            expected = [skin + liquid, float(g @ moments) / size]
            for box, volume in zip(boxes, volumes):
                told += [box.submerged_volume * density, *box.buoyancy() / size]
                expected += [volume * density, *(-density * volume * g / size)]
            world.step(h, allow_unstable=True)
            momentum, spin = world.linear_momentum() / h, world.angular_momentum() / h
            total = skin + liquid + masses.sum()
            told += [*momentum / size, *spin / size]
            expected += [*total * g / size, *np.cross(moments, g) / size]
            answers.extend(told, expected, total, kind)
            for box, volume, mass in zip(boxes, volumes, masses):
                answers.extend(box.velocity / h * mass, (mass - density * volume) * g, size * total, f"{kind}, a box")
    return answers.comparison()


@check_inside(
    piece="softbody.World.add_box, softbody.World.energies, softbody.SoftBody.pressure",
    reference="differences of the energies of weight, gas and liquid, with volume and centre by trimesh",
    engines=("trimesh",),
    unit="of the liquid's weight by the way",
    tolerance=2e-8,
    because="differences over 1e-5 of the size, of numbers that are rounded to 1e-16: 2.3e-9 at worst of two seeds",
    faults=(
        Fault("gas in the boxes", integrators.advance_body, "volume_ - bodies_.boxes_volume[body_] → volume"),
        Fault("a pressure that is told without boxes", pressure.room_in, "v_ - model_.soft_boxes_volume[body_] → v_"),
        Fault("centres of boxes at that of the body", filling._around_boxes, "moment_ / room_ → whole[1]"),
        Fault(
            "a liquid with its room as it was",
            filling.liquid_pressure,
            "m_[b_] - model_.soft_boxes_volume[b_] → m_[b_]",
        ),
    ),
)
def sinks_downhill_with_boxes(run: Run) -> Comparison:
    """Gas and liquid press around boxes as their energy says.

    The work that they do when particles and boxes go some way in any direction is what the energy falls by: −m g·c of
    the liquid around boxes, −nRT ln V and m c² (V / V0 − 1 − ln V / V0) of the room that boxes leave. The body is drawn
    out or pressed together first. Pressure and energy tell the same.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 3, 20)):
        for kind in MESH_KINDS:
            world, body, boxes, skin = with_boxes(rng, kind, rng.uniform(0.5, 2.0))
            if not boxes:
                continue
            h, g, size = 1e-4, world.gravity.copy(), float(np.linalg.norm(world.gravity))
            volumes = np.array([box.size.prod() for box in boxes])
            first = trimesh.volume(body.positions, body.triangles)
            taken, liquid = volumes.sum(), body.liquid_density * (first - volumes.sum())
            sound, middle, gas, triangles = 100.0 * size * first ** (1.0 / 3.0), body.centre, body.gas, body.triangles
            drawn = rng.uniform(0.85, 1.1, 3)
            body.positions = points = middle + (body.positions - middle) * drawn
            places = np.array([middle + (box.position - middle) * drawn for box in boxes])
            for box, place in zip(boxes, places):
                box.position = place

            kept = first - taken, taken, volumes, liquid, sound, gas, triangles

            def stored(x: np.ndarray, y: np.ndarray, kept: Any = kept, g: np.ndarray = g) -> tuple[float, float]:
                room, taken, volumes, liquid, sound, gas, triangles = kept
                whole = trimesh.volume(x, triangles)
                part, centre = (whole - taken) / room, whole * trimesh.centroid(x, triangles) - volumes @ y
                pressed = liquid * sound * (part - 1.0 - np.log(part)) if part < 1.0 else 0.0
                return float(liquid * g @ centre / (whole - taken) + gas * np.log(part)), pressed

            room, least = trimesh.volume(points, triangles) - taken, first - taken
            told = gas / room + (sound * liquid * (1.0 / room - 1.0 / least) if room < least else 0.0)
            answers.add(body.pressure, told, told, f"{kind}, pressure")
            answers.add(world.energies().liquid, stored(points, places)[1], liquid * sound, f"{kind}, energy")
            answers.add(world.energies().gas, -gas * np.log(room / least), gas, f"{kind}, energy of the gas")
            world.step(h, allow_unstable=True)
            if world.contact_points().pairs():  # a box is in the way of what was drawn
                continue
            force = (body.velocities / h) * body.mass / len(points) - skin * g / len(points)
            pushed = np.array([(box.velocity / h - g) * box.mass for box in boxes])
            for _ in range(3):
                way, off, small = rng.normal(size=points.shape), rng.normal(size=places.shape), 1e-5
                (a, b), (c, d) = (stored(points + by * way, places + by * off) for by in (-small, small))
                given = (c - a + b - d) / (2.0 * small)
                answers.add(float((force * way).sum() + (pushed * off).sum()), given, liquid * (size + sound), kind)
    return answers.comparison()


@check_inside(
    piece="softbody.SoftBody.liquid_drag, softbody.World.add_box",
    reference="closed form: v = (m − ρ V) g / (k A) · (1 − exp(−t k A / m)), in a tank of which all is fixed but one",
    kind="closed form",
    unit="of the terminal speed",
    tolerance=8e-4,
    because="steps of a thousandth of the time in which drag acts, half of that of the speed: 1.7e-4 of two seeds",
    faults=(
        Fault("drag by half of the surface", boxes_inside._drag, "0.5 * d_[b_] → 0.25 * d_[b_]"),
        Fault("no drag", boxes_inside.add_forces_inside, "_drag(m_, s_, b_, a_) → "),
        Fault("a hundredth less to bear up", filling.volume_of_box, "s_ * t_ * u_ → 0.99 * s_ * t_ * u_"),
    ),
)
def terminal_speeds(run: Run) -> Comparison:
    """Boxes in a tank rise or sink as their drag says.

    Lighter than the liquid or heavier, of any size and any way up: the speed at two moments.
    """
    rng, answers = run.fresh_rng(), Answers()
    mesh = softbody.box((2.0, 2.0, 6.0), 2)
    for case in range(run.count(6, 24, 120)):
        ratio = (0.2, 4.0)[case % 2] * rng.uniform(0.8, 1.25)
        density, size = rng.uniform(500.0, 2000.0), rng.uniform(0.1, 0.3, 3)
        world, drag, area = World(), 10.0 ** rng.uniform(3.0, 4.0), 2.0 * float(size @ np.roll(size, 1))
        fixed = np.arange(1, len(mesh.vertices))
        body = world.add_soft_body(mesh, 1e9, 0.0, 0.0, fixed=fixed, liquid_density=density, liquid_drag=drag)
        body.external_force = (0.0, 0.0, 9.81 * 1e9 / len(mesh.vertices))  # the one hardly moves: it is heavy, and held
        mass, turn = ratio * density * float(size.prod()), random_orientations(rng, 1)[0]
        box = world.add_box(size, mass, (0.1, -0.2, 0.3), turn, inside=body)
        fall, time, found = 9.81 * (density * size.prod() - mass) / (drag * area), mass / (drag * area), list[float]()
        for _ in range(2):
            world.step(1e-3 * time, 1500, allow_unstable=True)
            found.append(float(box.velocity[2]))
        expected = fall * (1.0 - np.exp(-np.array([1.5, 3.0])))
        answers.extend(found, expected, abs(fall), "light" if ratio < 1.0 else "heavy")
    return answers.comparison()


@check_inside(
    piece="softbody.World.add_box, softbody.Box.buoyancy",
    reference="a box as heavy as the liquid in its place stays; a hundredth lighter or heavier: (m − ρ V) g / (k A)",
    kind="closed form",
    unit="m; of a speed, of 1e9 times that",
    tolerance=5e-11,
    because="what a bag at rest still moves, 1.6e-11 at worst of three seeds; it gives way by 1.3 % of a box's speed",
    faults=(
        Fault(
            "borne up by the liquid of the beginning",
            boxes_inside.add_forces_inside,
            "mass_ / d_ → model.soft_liquid_density[body]",
        ),
        Fault(
            "buoyancy by the liquid of the beginning",
            BoxHandle._in_liquid,
            "mass_ / room_ → model.soft_liquid_density[host]",
        ),
    ),
)
def neutral_boxes_hang(run: Run) -> Comparison:
    """A box as dense as a bag's liquid hangs in it.

    A bag that hangs presses its liquid together by its weight. A box that weighs what it tells as its buoyancy, in the
    bag at rest, stays where it is for 20 s; of a hundredth less or more it goes up or down, as fast as its drag says.
    """
    rng, answers, mesh = run.fresh_rng(), Answers(), softbody.icosphere(1, 0.5)
    pins = np.argsort(mesh.vertices[:, 2])[-6:]
    for _ in range(run.count(2, 4, 20)):
        density, size, turn = rng.uniform(300.0, 1000.0), rng.uniform(0.1, 0.2, 3), random_orientations(rng, 1)[0]
        place, stiffness = rng.uniform(-0.05, 0.05, 3), rng.uniform(5e3, 1e4)
        mass, shape = density * float(size.prod()), mesh.vertices

        def hanging(mass: float, shape: np.ndarray, drawn: Any = (density, stiffness, size, place, turn)) -> SoftBody:
            world, (density, stiffness, size, place, turn) = World(), drawn
            springs: dict[str, Any] = {"fixed": pins, "drag": 5.0, "liquid_density": density, "liquid_drag": 1e3}
            body = world.add_soft_body(mesh, 3.0, stiffness, 1e3, **springs)
            body.positions = shape
            world.add_box(size, mass, body.centre + place, turn, inside=body, name="box")
            return body

        for _ in range(6):
            body = hanging(mass, shape)
            body.world.run(5.0)
            shape, mass = body.positions.copy(), float(body.world["box"].buoyancy()[2]) / 9.81
        for kind, part in {"as dense": 1.0, "lighter": 0.99, "heavier": 1.01}.items():
            body = hanging(part * mass, shape)
            box = body.world["box"]
            start = box.position.copy()
            body.world.run(20.0 if part == 1.0 else 0.5)
            if part == 1.0:
                answers.add(float(np.linalg.norm(box.position - start)), 0.0, 1.0, kind)
            else:
                area = 2.0 * float(size @ np.roll(size, 1))
                speed = (1.0 - part) * mass * 9.81 / (1e3 * area)
                answers.add(float(box.velocity[2]), speed, 1e9 * abs(speed), kind)
    return answers.comparison()


@check_inside(
    piece="softbody.SoftBody.liquid_drag, softbody.World.add_box",
    reference="conservation of both momenta",
    kind="invariant",
    unit="of all momenta",
    tolerance=1e-14,
    because="rounding, over 20 steps: 4.6e-16 at worst of two seeds",
    faults=(
        Fault("drag that nobody bears", boxes_inside._drag, "sub(push, force) → push"),
        Fault("drag that turns nobody", boxes_inside._drag, "solved(inertia_, torque_) → (0.0, 0.0, 0.0)"),
    ),
)
def both_momenta_kept(run: Run) -> Comparison:
    """A liquid and what is loose in it keep both momenta.

    Full bodies without weight, which spin, with cubes that fly in them: after 20 steps, before anything touches.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(6, 12, 60)):
        mesh = (softbody.icosphere(2, 0.5), softbody.box((1.0, 0.8, 0.7), 4))[case % 2]
        kind = ("ball", "block")[case % 2]
        world = World(gravity=WEIGHTLESS)
        full: dict[str, Any] = {"liquid_density": 10.0, "sound_speed": 10.0}
        body = world.add_soft_body(mesh, 1.0, rng.uniform(500.0, 2000.0), 50.0, rng.normal(size=3), **full)
        body.liquid_drag = 10.0 ** rng.uniform(-1.0, 1.0)
        body.velocities = rng.normal(size=3) + np.cross(rng.normal(0.0, 2.0, 3), body.positions - body.centre)
        for x in (-0.18, 0.18):
            edge, turn = rng.uniform(0.08, 0.16), random_orientations(rng, 1)[0]
            motion = rng.normal(0.0, 1.0, 3), rng.normal(0.0, 5.0, 3)
            world.add_box(
                (edge, edge, edge), rng.uniform(0.1, 1.0), body.centre + (x, 0, 0), turn, *motion, inside=body
            )
        before = np.concatenate([world.linear_momentum(), world.angular_momentum()])
        world.step(1e-3, 20)
        after = np.concatenate([world.linear_momentum(), world.angular_momentum()])
        most = sum(float(np.linalg.norm(each)) for each in (before[:3], before[3:]))
        answers.add(after, before, most, kind)
    return answers.comparison()


@check_inside(
    piece="softbody.SoftBody.liquid_drag, softbody.World.energies",
    reference="closed form: force k A u against a speed of u through the liquid, and a power k A u²",
    kind="closed form",
    unit="of the force, and of the power",
    tolerance=1e-4,
    because="changes in a step of a millionth of a second, to the first order: 3.1e-5 at worst of two seeds",
    faults=(
        Fault("a flow that does not turn", boxes_inside._drag, "add(flow_, c_) → flow"),
        Fault("a flow of the first particle", boxes_inside._motion_of, "mean_of(velocities_) → load(velocities, 0)"),
        Fault("drag by half of the surface", boxes_inside._drag, "0.5 * d_[b_] → 0.25 * d_[b_]"),
    ),
)
def dragged_against_the_flow(run: Run) -> Comparison:
    """Drag is against the liquid's own motion.

    In a body that moves and turns, a box that goes along is not dragged; one that is faster by some speed loses
    momentum, and all together energy, as that says.
    """
    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(6, 12, 60)):
        mesh = (softbody.icosphere(2, 0.5), softbody.box((1.0, 0.8, 0.7), 4))[case % 2]
        world, drag, h, edge = World(gravity=WEIGHTLESS), 10.0 ** rng.uniform(-1.0, 1.0), 1e-6, 0.2
        body = world.add_soft_body(mesh, 1.0, 0.0, 0.0, liquid_density=10.0, liquid_drag=drag)
        spin, flow, past = rng.normal(size=3), rng.normal(size=3), (case % 3 > 0) * rng.normal(size=3)
        body.velocities = flow + np.cross(spin, body.positions - body.centre)
        place, turn = (0.1, 0.0, 0.0), random_orientations(rng, 1)[0]
        moves = flow + np.cross(spin, place - body.centre) + past
        box = world.add_box((edge, edge, edge), 0.1, place, turn, moves, spin, inside=body)
        energy, force = world.energies().kinetic, -drag * 6.0 * edge**2 * past
        world.step(h, allow_unstable=True)
        told = [*(box.velocity - moves) * 0.1 / h, (world.energies().kinetic - energy) / h]
        kind = f"{('ball', 'block')[case % 2]}, {'faster' if past.any() else 'carried along'}"
        answers.add(told, [*force, float(force @ past)], drag * 6.0 * edge**2, kind)
    return answers.comparison()


@check_inside(
    piece="softbody.World.add_box, softbody.Box.inside",
    reference="the exact winding number and distances, by libigl; how deep a skin is in the box, by FCL and by "
    "arithmetic in its frame",
    engines=("fcl", "igl"),
    unit="of an edge of the mesh",
    tolerance=0.2,
    because="how deep a contact is at the end of a step in which it is struck: 0.08 at worst of 64 cases. It is not "
    "so in all draws: of 128 others one had a corner 0.26 outside, with a warning, and one ended by a told error",
    faults=(
        Fault(
            "a skin that lets boxes out",
            soft_contacts._find_contacts_with_box,
            "find_corners_outside(s_, b_, m_, t_, l_) → ",
        ),
        Fault(
            "a skin that pushes boxes out",
            soft_contacts._find_contacts_with_box,
            "model_.box_host[box_] == body_ → False",
        ),
        Fault("corners that are drawn further out", soft_box.find_corners_outside, "scale(-1.0, back_) → back"),
        Fault(
            "a box that particles go into",
            soft_contacts._find_contacts_with_box,
            "find_contacts_in_box(a_, b_, c_, d_, e_, f_, g_, h_) → ",
        ),
    ),
)
def thrown_and_kept(run: Run) -> Comparison:
    """Boxes that are loose in a shaken body stay in it.

    Balls, blocks, rings and dented balls, full of gas alone or of a liquid too, with three small boxes or a larger one,
    of a tenth to twice the skin's mass each, fall on the ground and are shaken: at 40 moments of 2 s no corner is
    outside by more than some part of an edge, and no particle as deep in a box. Nor is any part of the skin, wherever
    that does not go through itself: nobody has asked it not to, and what is wrung has edges that go through boxes.
    """
    from references import fcl

    rng, answers = run.fresh_rng(), Answers()
    for case in range(run.count(8, 64, 320)):
        world = World()
        world.add_ground()
        name = ("ball", "block", "ring", "dented")[case % 4]
        ring, dented = softbody.torus(0.6, 0.25, 24, 12), dented_sphere(2, 0.6).scaled(0.6)
        mesh = (softbody.icosphere(2, 0.5), softbody.box((1.0, 0.8, 0.7), 4), ring, dented)[case % 4]
        gas, springs = rng.uniform(300.0, 1500.0) * mesh.volume, rng.uniform(300.0, 1500.0)
        density = 20.0 * (case // 4 % 2)
        body = world.add_soft_body(
            mesh, 2.0, springs, gas, (0.0, 0.0, 1.0), rng.normal(0.0, 2.0, 3), liquid_density=density
        )
        boxes = list[Box]()
        is_large = name == "dented" or case // 8 % 2 == 0
        for k in range(1 if is_large else 3):
            turn, edge = random_orientations(rng, 1)[0], rng.uniform(0.08, 0.14, 3) + 0.1 * is_large
            angle = 2.0 * np.pi * k / 3.0
            away = {"ring": 0.6, "dented": 0.02}.get(name, 0.2)
            place = away * np.array([np.cos(angle), np.sin(angle), 0.0]) + (0.0, 0.0, 1.0)
            rises = (0.0, 0.0, 3.0 * (name == "dented"))  # towards the tip of the dent
            boxes.append(world.add_box(edge, 2.0 * 10.0 ** rng.uniform(-1.0, 0.3), place, turn, rises, inside=body))
        length, worst = float(np.linalg.norm(np.diff(body.positions[body.edges], axis=1), axis=2).mean()), 0.0
        pierced = 0.0
        for frame in range(40):
            if frame % 10 == 0:
                body.velocities = body.velocities + rng.normal(0.0, 2.0, 3)
            try:
                world.step_frame(0.05)
            except SimulationError:
                worst = pierced = float(length)
                break
            skin = body.positions, body.triangles
            for box in boxes:
                turn = rotation_matrix(box.orientation)
                corners = box.position + corners_of(box.size) @ turn.T
                out = ~igl.points_in_mesh(corners, *skin)
                far = igl.closest_points(corners, *skin)[0] * out
                deep = (0.5 * box.size - np.abs((body.positions - box.position) @ turn)).min(axis=1)
                worst = float(np.max([worst, far.max(), deep.max()]))
                depth = fcl.depth_in_box(box.size, box.position, box.orientation, *skin)
                if depth > pierced and not len(igl.self_intersections(*skin)):
                    pierced = depth
        kind = f"{name}, {'full' if density else 'gas'}"
        deepest = np.array([worst, pierced]) / length
        answers.extend(deepest, np.zeros(2), kind=[f"{kind}, by points", f"{kind}, by FCL"])
    return answers.comparison()


@check_inside(
    piece="softbody.World.add_box, softbody.World.contact_points",
    reference="Newton's second law: the ground carries all, and the skin what the liquid does not bear",
    kind="closed form",
    unit="of the weight",
    tolerance=1e-3,
    because="drag on what still trembles after 20 s, in the mean of half a second: 3.5e-4",
    faults=(
        Fault("boxes borne by half", boxes_inside.add_forces_inside, "scale(-d_ * v_, g_) → scale(-0.5 * d_ * v_, g_)"),
        Fault("nothing inside", acting.all_that_acts, "add_forces_inside(m_, g_, s_, a_, b_) → "),
    ),
)
def the_skin_carries_the_rest(run: Run) -> Comparison:
    """What lies in a body is carried by its skin.

    Of a box in a bag on the ground, light or heavy, or in a ball of gas, the skin bears what the liquid does not, up or
    down; the ground bears skin, liquid and box.
    """
    answers = Answers()
    for density in (0.0, 1000.0):
        for mass in (0.3, 4.0):
            world = World()
            world.add_ground()
            ball, size = softbody.icosphere(2, 0.4), np.array([0.15, 0.12, 0.1])
            springs: dict[str, Any] = {"liquid_density": density, "liquid_drag": 30.0, "drag": 2.0}
            body = world.add_soft_body(ball, 3.0, 6e3, 6e3 * ball.volume, (0.0, 0.0, 0.45), **springs)
            box = world.add_box(size, mass, (0.02, 0.01, 0.45), inside=body, name="box")
            world.run(20.0)
            carried, before = np.zeros(2), np.array([mass * box.velocity[2], body.mass * body.velocity[2]])
            for _ in range(1000):
                world.step(5e-4)
                touching = world.contact_points()
                box_bears, skin_bears = (float(touching.force_on(each)[2]) for each in (box, body))
                carried += np.array([box_bears, box_bears + skin_bears]) / 1000.0
            gained = np.array([mass * box.velocity[2], body.mass * body.velocity[2]]) - before
            carried -= np.array([gained[0], gained.sum()]) / 0.5
            room = trimesh.volume(body.positions, body.triangles) - size.prod()
            liquid = density * (ball.volume - size.prod())
            borne = 9.81 * (mass - liquid / room * size.prod())
            total = 9.81 * (3.0 + liquid + mass)
            told = [carried[0] / abs(borne), carried[1] / total]
            answers.extend(told, [np.sign(borne), 1.0], 1.0, f"{density:.0f} kg/m³, {mass} kg")
    return answers.comparison()


@check_inside(
    piece="softbody.Box.inside, softbody.World.remove",
    reference="a world that was made with what is left, by the same version",
    kind="the core in another form",
    unit="m",
    tolerance=1e-13,
    because="masses that were shared anew are rounded anew: 1.8e-15 at worst of three seeds",
    faults=(
        Fault("hosts of before", builder.without, "model_.box_host - (model_.box_host > body_) → model.box_host"),
        Fault(
            "a box that stays inside what is gone",
            builder.without,
            "hosts[body if kind == 'box' else hosts == body] = NOBODY → pass",
        ),
        Fault("an inside that is set for nothing", builder.with_box_inside, "hosts[box] = body → pass"),
    ),
)
def put_in_and_taken_out(run: Run) -> Comparison:
    """A box may be put into a body, and taken out.

    As by add_box: put in later by its attribute, after it was in another, or with a body before it removed; out of it:
    as if never in, or when the body is gone. After 0.3 s all are where they are in a world that was made so.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 4, 20)):
        size, mass, gas = rng.uniform(0.05, 0.15, 3), rng.uniform(0.5, 5.0), rng.uniform(50.0, 500.0)
        springs = rng.uniform(1e3, 3e3)

        def filled(balls: int, gas: float = gas, springs: float = springs) -> World:
            world = World()
            world.add_ground(-0.6)
            for k in range(balls):
                world.add_soft_body(
                    softbody.icosphere(1, 0.5), 2.0, springs, gas, (2.0 * k, 0, 0), liquid_density=100.0
                )
            return world

        def boxed(world: World, where: int, inside: int | None, size: Any = size, mass: float = mass) -> Box:
            host = None if inside is None else world.soft_bodies[inside]
            return world.add_box(size, mass, (2.0 * where, 0.0, 0.0), (0.8, 0.6, 0.0, 0.0), inside=host)

        added, later, moved, gone, fewer = *(filled(2) for _ in range(4)), filled(3)
        out, alone = filled(1), filled(1)
        boxed(added, 1, 1)
        boxed(later, 1, None).inside = later.soft_bodies[1]
        box = boxed(moved, 0, 0)
        box.position = (2.0, 0.0, 0.0)
        box.inside = moved.soft_bodies[1]
        boxed(fewer, 2, 2)
        fewer.remove(fewer.soft_bodies[0])
        box = boxed(out, 0, 0)
        box.inside = None
        box.position = (0.0, 3.0, 0.0)
        boxed(gone, 0, 0)
        gone.remove(gone.soft_bodies[0])
        for world in (added, later, moved, fewer, out, gone):
            world.step(1e-3, 300)
        boxed(alone, 0, None)
        alone.soft_bodies[0].positions += (2.0, 0.0, 0.0)
        alone.step(1e-3, 300)
        apart = filled(1)
        apart.add_box(size, mass, (0.0, 3.0, 0.0), (0.8, 0.6, 0.0, 0.0))
        apart.step(1e-3, 300)
        here, there = added.boxes[0].position, added.soft_bodies[1].centre
        for kind, one in {"later": later, "moved": moved}.items():
            answers.extend([one.boxes[0].position, one.soft_bodies[1].centre], [here, there], 1.0, kind)
        shift = np.array([2.0, 0.0, 0.0])
        found = [fewer.boxes[0].position - shift, fewer.soft_bodies[1].centre - shift]
        answers.extend(found, [here, there], 1.0, "fewer")
        for kind, one, other in (("out", out, apart), ("gone", gone, alone)):
            found, made = ([each.boxes[0].position, each.soft_bodies[0].centre] for each in (one, other))
            free = one.boxes[0].inside is None
            answers.extend([*found, 3 * [free]], [*made, 3 * [True]], 1.0, kind)
    return answers.comparison()


@check_inside(
    piece="softbody.scenes.boxes_in_bags",
    reference="statics: skins bear what a liquid does not, and the ground all, with volumes by trimesh",
    engines=("trimesh",),
    unit="of the weight",
    tolerance=2e-3,
    because="what is left of motion after 16 s: 8.8e-4",
    faults=(
        Fault("boxes of one density", boxes_in_bags.build, "density_ * EDGE ** 3 → 500.0 * EDGE ** 3"),
        Fault("a jelly without its marble", boxes_in_bags.build, "world_.suspend(a_, b_) → "),
    ),
)
def boxes_in_bags_rise_hang_and_sink(run: Run) -> Comparison:
    """Boxes in bags rise, hang or sink by their density.

    The light one is pressed down by the skin above it, the dense one is held up by that below it, and no skin touches
    the one between, which is as dense as the water in a bag at rest. The marble hangs in the middle of the jelly.
    """
    answers, world = Answers(), boxes_in_bags.build()
    world.run(16.0)
    touching, volume = world.contact_points(), boxes_in_bags.EDGE**3
    whole = softbody.icosphere(2, boxes_in_bags.RADIUS).volume
    masses = [*(volume * density for density in boxes_in_bags.DENSITIES), boxes_in_bags.SKIN]
    for body, box, mass, side in zip(world.soft_bodies, world.boxes, masses, (-1.0, 0.0, 1.0, 0.0)):
        liquid = body.liquid_density * (whole - volume)
        density = liquid / (trimesh.volume(body.positions, body.triangles) - volume)
        weight, kind = 9.81 * mass, str(box.name)
        borne = weight - 9.81 * density * volume
        told = float(touching.force_on(box)[2]) / weight
        if kind == "marble":
            off = float(np.linalg.norm(box.position - body.centre)) / boxes_in_bags.EDGE
            answers.extend([told, off], [0.0, 0.0], 1.0, kind)
        else:
            below = float(np.sign(body.centre[2] - box.position[2]))
            expected = [borne / weight, side] if side else [0.0, 0.0]
            answers.extend([told, below if side else 0.0], expected, 1.0, kind)
        ground = told * weight + float(touching.force_on(body)[2])
        total = 9.81 * (boxes_in_bags.SKIN + liquid) + weight
        answers.add(ground / total, 1.0, 1.0, kind)
    return answers.comparison()
