"""Claims that bodies full of a liquid weigh, press and sag as they must."""

from __future__ import annotations

from typing import Any

import numpy as np

import softbody
from references import bag, trimesh
from softbody import SoftBody, World
from softbody.bodies import builder
from softbody.dynamics import acting, equilibrium, filling, ring_pressure
from softbody.dynamics import energy as energies
from softbody.scenes import water_bags
from validation.answers import Answers
from validation.cases import MESH_KINDS, edge_lengths, random_mesh
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "bodies full of a liquid"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

SECTION = "7"


def a_bag(rng: np.random.Generator, kind: str, gas: float = 1.0) -> tuple[World, SoftBody, float, float]:
    """Return a world of any gravity, a body of about a metre in it, full of a liquid, and both masses [kg].

    The body has no springs. Its `gas` is that times ρ g d V, with d its extent.
    """
    mesh = random_mesh(kind, rng)
    mesh = mesh.scaled(1.0 / float(np.ptp(mesh.vertices, axis=0).max())).moved(rng.normal(size=3))
    world = World(gravity=rng.normal(0.0, 5.0, 3))
    skin, density = rng.uniform(1.0, 100.0), rng.uniform(500.0, 2000.0)
    weight = density * mesh.volume * float(np.linalg.norm(world.gravity))
    body = world.add_soft_body(mesh, skin, 0.0, gas * weight, liquid_density=density)
    return world, body, skin, density * mesh.volume


@check(
    section=SECTION,
    piece="softbody.World.add_soft_body, softbody.SoftBody.mass, softbody.World.energies",
    reference="the weight of skin and liquid, at the centres of particles and of the volume, by trimesh",
    engines=("trimesh",),
    unit="of the whole body's share",
    tolerance=2e-14,
    because="rounding on both sides: 4.0e-15 at worst of three seeds",
    faults=(
        Fault("weight twice", filling.add_filling_forces, "scale(-mass_ / n_, g_) → scale(0.0, g)"),
        Fault(
            "pressure by the middle of the particles",
            filling._middle,
            "0.25 * sums_ / six_ → 0.26 * sums / six",
        ),
        Fault("a skin without its liquid", builder.with_soft_body, "mass += d_ * v_ → mass += 0.0"),
        Fault("energy of particles alone", energies.potential_energies, "gravity += weight_ → gravity += 0.0"),
        Fault("energy that begins at the first particle", filling.filling_energies, "m_ + dot(g_, l_) → m_"),
    ),
)
def weighs_at_its_centre(run: Run) -> Comparison:
    """A liquid weighs at the centre of its volume.

    In one step from rest a body without springs gets the momentum of the weight of skin and liquid, and the spin of a
    liquid whose weight is at the centre of the volume, under gravity in any direction. Mass and energy tell that, too.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 6, 40)):
        for kind in MESH_KINDS:
            world, body, skin, liquid = a_bag(rng, kind)
            h, g, size = 1e-4, world.gravity.copy(), float(np.linalg.norm(world.gravity))
            centre, middle = trimesh.centroid(body.positions, body.triangles), body.centre
            told = [body.mass, -world.energies().gravity / size]
            expected = [skin + liquid, float(skin * g @ middle + liquid * g @ centre) / size]
            world.step(h, allow_unstable=True)
            momentum, spin = world.linear_momentum() / h, world.angular_momentum() / h
            found = [*told, *momentum / size, *(spin - np.cross(middle, momentum)) / size]
            turn = np.cross(centre - middle, liquid * g)
            answers.add(found, [*expected, *(skin + liquid) * g / size, *turn / size], skin + liquid, kind)
    return answers.comparison()


@check(
    section=SECTION,
    piece="softbody.World.add_soft_body, softbody.World.energies, softbody.SoftBody.pressure",
    reference="differences of the energies of weight, gas and liquid, with volume and centre by trimesh",
    engines=("trimesh",),
    unit="of the liquid's weight by the way",
    tolerance=5e-8,
    because="differences over 1e-5 of the size, of numbers that are rounded to 1e-16: 1.2e-8 at worst of three seeds",
    faults=(
        Fault(
            "pressure in a bag by thirds",
            ring_pressure.pressed,
            "scale(g_, s_) → scale(4.0 / 3.0 * growth, slope)",
        ),
        Fault("a density that stays", filling.add_filling_forces, "mass_ / room_ → 1.01 * mass / room"),
        Fault("a liquid that gives way", filling.liquid_pressure, "lost_ > 0.0 → False"),
        Fault("a liquid that pulls", filling.liquid_pressure, "lost_ > 0.0 → True"),
        Fault("twice as hard to press", filling.square_of_sound, "c_ * c_ → 2.0 * c * c"),
        Fault("as hard in any gravity", filling.square_of_sound, "norm(gravity_) → 9.81"),
        Fault(
            "pressure of the gas alone",
            SoftBody,
            "gas_pressure(g_, v_) + liquid_ → gas_pressure(g_, v_)",
        ),
        Fault(
            "energy without its logarithm",
            filling.filling_energies,
            "part_ - 1.0 - log(part_) → part - 1.0",
        ),
        Fault("pressure that falls with depth", filling._press, "1.0 / 24.0 → -1.0 / 24.0"),
    ),
)
def sinks_downhill(run: Run) -> Comparison:
    """A liquid presses as its weight's energy says.

    The work that its pressure and the gas do when particles go some way in any direction is what the energy falls by:
    −m g·c of its weight, −nRT ln V of the gas, and m c² (V / V0 − 1 − ln V / V0) of the liquid where it has less room
    than at first. The body is drawn out or pressed together first. Pressure and energy tell the same.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(1, 3, 20)):
        for kind in MESH_KINDS:
            world, body, skin, liquid = a_bag(rng, kind)
            h, g, size = 1e-4, world.gravity.copy(), float(np.linalg.norm(world.gravity))
            middle, room, gas, triangles = body.centre, liquid / body.liquid_density, body.gas, body.triangles
            sound = 100.0 * size * room ** (1.0 / 3.0)
            if rng.random() < 0.5:
                body.sound_speed = rng.uniform(10.0, 50.0)
                sound = body.sound_speed**2
            body.positions = points = middle + (body.positions - middle) * rng.uniform(0.8, 1.15, 3)
            kept = liquid, room, sound, gas, triangles

            def stored(x: np.ndarray, kept: Any = kept, g: np.ndarray = g) -> tuple[float, float]:
                liquid, room, sound, gas, triangles = kept
                part = trimesh.volume(x, triangles) / room
                pressed = liquid * sound * (part - 1.0 - np.log(part)) if part < 1.0 else 0.0
                return float(liquid * g @ trimesh.centroid(x, triangles) + gas * np.log(part)), pressed

            volume = trimesh.volume(points, triangles)
            pressure = gas / volume + (sound * liquid * (1.0 / volume - 1.0 / room) if volume < room else 0.0)
            answers.add(body.pressure, pressure, pressure, f"{kind}, pressure")
            answers.add(world.energies().liquid, stored(points)[1], liquid * sound, f"{kind}, energy")
            world.step(h, allow_unstable=True)
            force = (body.velocities / h) * body.mass / len(points) - skin * g / len(points)
            for _ in range(3):
                way, small = rng.normal(size=points.shape), 1e-5
                (a, b), (c, d) = stored(points - small * way), stored(points + small * way)
                given = (c - a + b - d) / (2.0 * small)
                answers.add(float((force * way).sum()), given, liquid * (size + sound), kind)
    return answers.comparison()


@check(
    section=SECTION,
    piece="softbody.World.add_soft_body, softbody.SoftBody.pressure",
    reference="closed form: P0 + ρ g d at the depth d below the middle, on a small piece of a wall",
    kind="closed form",
    unit="of the pressure",
    tolerance=2e-14,
    because="rounding of a velocity that one step gives: 4.3e-15 at worst of three seeds",
    faults=(
        Fault("depth from the top", filling._middle_of_rows, "0.25 * s_ / w_ → 0.0"),
        Fault("pressure of one height", filling._press, "pressed(w_, i_, p_, d_) → pressed(work, i, base, 0.0)"),
    ),
)
def presses_by_its_depth(run: Run) -> Comparison:
    """Pressure in a tank grows with depth as ρ g says.

    Every particle of a tank is fixed but one, somewhere on a wall: the force on it is the pressure at its height on a
    third of the triangles around it. What the tank tells as its pressure is that half-way down.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(12, 60, 600)):
        size, density, g, h = rng.uniform(0.5, 2.0, 3), rng.uniform(500.0, 2000.0), rng.uniform(1.0, 20.0), 1e-5
        mesh = softbody.box(size, 4)
        onside = np.isclose(np.abs(mesh.vertices), 0.5 * size).sum(axis=1) == 1
        one = int(rng.choice(np.flatnonzero(onside)))
        fixed = np.setdiff1d(np.arange(len(mesh.vertices)), [one])
        around = mesh.vertices[mesh.triangles[(mesh.triangles == one).any(axis=1)]]
        normal = np.sign(mesh.vertices[one]) * np.isclose(np.abs(mesh.vertices[one]), 0.5 * size)
        area = 0.5 * np.linalg.norm(np.cross(around[:, 1] - around[:, 0], around[:, 2] - around[:, 0]), axis=1)
        # ∫ φ z dA of each triangle: a twelfth of its area, by the heights of its corners and once more of the one.
        heights = around[:, :, 2].sum(axis=1) + mesh.vertices[one, 2]
        world, skin, gas = World(gravity=(0.0, 0.0, -g)), 20.0, rng.uniform(1e3, 1e5)
        liquid: dict[str, Any] = {"liquid_density": density, "sound_speed": 1.0}  # which hides no rounding
        body = world.add_soft_body(mesh, skin, 0.0, gas, (3.0, 1.0, -2.0), fixed=fixed, **liquid)
        pressure = gas / size.prod()
        push = float((pressure * area / 3.0 - density * g * area * heights / 12.0).sum()) * normal
        push[2] -= g * skin / len(mesh.vertices)
        told = body.pressure / pressure
        world.step(h, allow_unstable=True)
        found = body.velocities[one] / h * body.mass / len(mesh.vertices)
        most = (pressure + density * g * size[2]) * float(area.sum())
        answers.add([told, *found / most], [1.0, *push / most], kind="tank")
    return answers.comparison()


@check(
    section=SECTION,
    piece="softbody.World.add_soft_body, softbody.World.equilibrium",
    reference="SciPy's minimum of the energies of springs, gas, skin and liquid",
    kind="third-party library",
    engines=("scipy",),
    unit="m",
    tolerance=1e-12,
    because="rounding, and what is left of the swing after 30 s: 1.0e-13 at worst of three seeds",
    faults=(
        Fault(
            "a bag that is relaxed dry",
            equilibrium._accelerate,
            "add_filling_forces(model_, g_, w_, m_, b_, force_) → ",
        ),
        Fault("a bag that is dry when it runs", acting.all_that_acts, "add_filling_forces(m_, g_, w_, x_, b_, f_) → "),
        Fault("a liquid of 0.01% more", filling.liquid_mass, "d_[b_] * v_ → 1.0001 * d_[b_] * v_"),
    ),
)
def hangs_in_the_shape_of_least_energy(run: Run) -> Comparison:
    """A bag hangs in SciPy's shape of least energy.

    Balls without gas, and rings with some, full of a liquid, which hang on some of their particles: at rest after a
    long run with drag, and by World.equilibrium.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(4, 8, 40)):
        mesh = (softbody.icosphere(1, 0.5), softbody.torus(0.5, 0.2, 10, 5))[trial % 2]
        world, skin, density = World(), rng.uniform(1.0, 5.0), rng.uniform(200.0, 1000.0)
        stiffness = rng.uniform(1e4, 3e4, len(mesh.edges))
        gas, pins = rng.uniform(3e3, 6e3) * mesh.volume, np.argsort(mesh.vertices[:, 2])[-6:]
        gas, sound = (gas, rng.uniform(20.0, 40.0)) if trial % 2 else (0.0, 0.0)
        filled: dict[str, Any] = {"liquid_density": density, "sound_speed": sound, "drag": 3.0}
        drawn = 0.9 * edge_lengths(mesh.vertices, mesh.edges)  # taut: what is slack has many shapes
        body = world.add_soft_body(mesh, skin, stiffness, gas, rest_length=drawn, fixed=pins, **filled)
        square = sound**2 or 981.0 * mesh.volume ** (1.0 / 3.0)
        damping = 0.1 * np.sqrt(2.0 * stiffness.mean() * (skin + density * mesh.volume) / len(mesh.vertices))
        answers.add([body.damping / damping, 0.0, 0.0], [1.0, 0.0, 0.0], kind="damping")
        springs = mesh.edges, body.rest_length.copy(), stiffness, mesh.triangles
        weights = skin * world.gravity, density * mesh.volume * world.gravity
        expected = bag.hanging(mesh.vertices, springs, gas, weights, square / 9.81, pins)
        kind = ("ball", "ring")[trial % 2]
        world.run(30.0)
        answers.extend(body.positions.copy(), expected, kind=f"{kind}, run")
        body.positions = mesh.vertices
        world.equilibrium(1e-13)
        answers.extend(body.positions.copy(), expected, kind=f"{kind}, relaxed")
    return answers.comparison()


@check(
    section=SECTION,
    piece="softbody.World.add_soft_body",
    reference="the energy, over the first second and over the last",
    kind="invariant",
    unit="of the energy of its fall",
    tolerance=2e-3,
    because="what a mean over a second of some swings has: 4.4e-4 at worst of three seeds",
    faults=(
        Fault(
            "a liquid where it was",
            acting.all_that_acts,
            "Moving(p_, v_, ahead_) → Moving(state.particle_position, state.particle_velocity, -2.0 * h)",
        ),
    ),
)
def swings_for_ever(run: Run) -> Comparison:
    """A bag that nothing damps keeps its energy.

    It hangs on some particles and is let go: by every integrator and in sub-steps, over eight seconds.
    """
    rng, answers = run.fresh_rng(), Answers()
    mesh = softbody.icosphere(1, 0.5)
    for _ in range(run.count(2, 4, 20)):
        for integrator, substeps in (("symplectic_euler", 1), ("symplectic_euler", 5), ("rk4", 1), ("rk4", 3)):
            world, density = World(integrator=integrator, substeps=substeps), rng.uniform(300.0, 1000.0)
            pins = np.argsort(mesh.vertices[:, 2])[-5:]
            body = world.add_soft_body(
                mesh, 5.0, 2e4, 5e3 * mesh.volume, fixed=pins, liquid_density=density, damping=0.0
            )
            h, means = min(0.2 * world.stable_time_step(), 2e-3), []
            start, heights = world.energy(), [float(body.centre[2])]
            for wait in (0.0, 6.0):
                world.step(h, round(wait / h), allow_unstable=True)
                told = []
                for _ in range(100):
                    world.step(h, round(0.01 / h), allow_unstable=True)
                    told.append(world.energy() - start)
                    heights.append(float(body.centre[2]))
                means.append(np.mean(told))
            fall = body.mass * 9.81 * (heights[0] - float(np.min(heights)))
            answers.add(means[1], means[0], fall, f"{integrator}, {substeps}")
    return answers.comparison()


@check(
    section=SECTION,
    piece="softbody.scenes.water_bags",
    reference="statics: the ground carries skin and liquid of what lies; what hangs and lies is as its density says",
    kind="closed form",
    unit="of the weight",
    tolerance=2e-5,
    because="what is left of motion after 20 s: 2.3e-6",
    faults=(
        Fault("dry bags", water_bags.build, "full = f_ → full = {'drag': 2.0, 'liquid_density': 0.0}"),
        Fault("bags of lead", water_bags.build, "full = f_ → full = {'drag': 2.0, 'liquid_density': 5.0 * density}"),
    ),
)
def water_bags_lie_and_hang(run: Run) -> Comparison:
    """Water bags sag the more the denser they are.

    The ground carries the weight of each that lies, and none of each that hangs. Who is fuller of weight is flatter.
    """
    answers = Answers()
    world = water_bags.build()
    world.run(20.0)
    touching, skin = world.contact_points(), water_bags.SKIN
    for hangs in (False, True):
        bodies = [body for body in world.soft_bodies if (len(body.fixed) > 0) == hangs]
        heights = []
        for body, density in zip(bodies, water_bags.DENSITIES):
            weight = 9.81 * (skin + density * softbody.icosphere(2, water_bags.RADIUS).volume)
            carried = float(touching.force_on(body)[2]) / weight
            answers.add(carried, 0.0 if hangs else 1.0, 1.0, str(body.name))
            heights.append(float(np.ptp(body.positions[:, 2])))
        order = np.argsort(heights if not hangs else heights[::-1])
        answers.extend(order.astype(float), np.arange(4.0)[::-1], 1.0, "hang" if hangs else "lie")
    return answers.comparison()
