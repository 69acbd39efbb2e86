"""Springs that are damped as by default: by how much, and what becomes of a swing, in worlds as users make them."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import softbody
from references import analytic
from softbody import Mesh, World
from softbody.bodies import adding, builder
from softbody.dynamics import integrators, one_ring_forces
from softbody.model import settings
from softbody.scenes import from_file, sphere_on_torus
from validation.answers import Answers
from validation.cases import MESH_KINDS, edge_lengths, random_mesh
from validation.check import Comparison, Run, check
from validation.checks.soft.cases import SOLIDS, weightless
from validation.fault import Fault

FAMILY = "integrators"

WHOLE_MASS = Fault(
    "critical for particles that each weigh as much as the body",
    builder.with_soft_body,
    "default_damping(stiffness, mass / count) → default_damping(stiffness, mass)",
)
ON_A_WALL = Fault("critical for one particle on a wall", builder.default_damping, "sqrt(0.5 * mass) → sqrt(mass)")
FIRST_SPRING = Fault(
    "critical for the first spring, and not for the mean one",
    builder.default_damping,
    "sqrt(mean) → sqrt(stiffness[0])",
)
NONE = Fault(
    "springs that are not damped, whatever the integrator",
    adding.add_soft_body,
    "damping is None and store.settings.integrator == RK4_VELOCITY → damping is None",
)
TWICE = Fault(
    "springs that are damped where the integrator damps by itself",
    adding.add_soft_body,
    "damping is None and store.settings.integrator == RK4_VELOCITY → False",
)
PAPERS = Fault(
    "worlds that move by the paper's integrator",
    settings.settings_of,
    "Settings(**values) → Settings(**{**values, 'integrator': RK4_VELOCITY})",
)
HALVED = Fault(
    "damping halved in motion", one_ring_forces._tension, "springs.damping * parting → 0.5 * springs.damping * parting"
)
BY_THE_STEP = Fault(
    "damping in proportion to the step",
    integrators._advance_body,
    "bodies.damping[body] → 1e3 * h * bodies.damping[body]",
)

SCENE = """
[world]
integrator = "{integrator}"
[[soft_body]]
shape = {{ name = "icosphere", subdivisions = 1 }}
mass = {mass!r}
stiffness = {stiffness!r}
gas = 1.0
"""


def _from_scene(integrator: str, mass: float, stiffness: float) -> float:
    """Return the damping [N s/m] of a sphere of 42 particles whose scene file says none."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.toml"
        path.write_text(SCENE.format(integrator=integrator, mass=mass, stiffness=stiffness))
        return from_file(path).soft_bodies[0].damping


@check(
    section="2.1, 5.1",
    piece="softbody.World.add_soft_body, softbody.SoftBody.damping",
    reference="closed form: the damping at which both eigenvalues of two particles on a spring are one",
    unit="relative; of N s/m where there is none",
    kind="closed form",
    tolerance=1e-14,
    because="a mean of up to some thousand springs, in another order",
    faults=(WHOLE_MASS, ON_A_WALL, FIRST_SPRING, NONE, TWICE),
)
def a_tenth_of_critical(run: Run) -> Comparison:
    """Springs are by default damped by a tenth of what is critical.

    Critical for two particles on the mean spring: of any mesh, mass and stiffness, alike or each its own, pinned or
    not, from Python and from files. Where the paper's integrator moves them they are not damped. What is said is had.
    """
    rng, answers = run.fresh_rng(), Answers()

    def note(kind: str, damping: float, truth: float) -> None:
        answers.add(damping, truth, truth or 1.0, kind)

    for kind in MESH_KINDS * run.count(1, 6, 60):
        mesh, mass = random_mesh(kind, rng), 10.0 ** rng.uniform(-3.0, 3.0)
        alike, count = 10.0 ** rng.uniform(-2.0, 6.0), len(mesh.vertices)
        each = alike * rng.uniform(0.0, 2.0, len(mesh.edges))
        pins, said = rng.choice(count, 3, replace=False), rng.uniform(0.0, 10.0)
        for stiffness in (alike, each):
            truth = 0.1 * float(analytic.critical_damping(np.mean(stiffness), mass / count))
            body = mesh, mass, stiffness, 1.0
            note("default", World().add_soft_body(*body).damping, truth)
            note("rk4", World(integrator="rk4").add_soft_body(*body, fixed=pins).damping, truth)
            note("said", World().add_soft_body(*body, damping=said).damping, said)
            for paper in (World.paper(), World(integrator="rk4_velocity")):
                note("the paper's", paper.add_soft_body(*body).damping, 0.0)
                note("said", paper.add_soft_body(*body, damping=said).damping, said)
        note("no springs", World().add_soft_body(mesh, mass, 0.0, 1.0).damping, 0.0)
        truth = 0.1 * float(analytic.critical_damping(alike, mass / 42))
        note("file", _from_scene("symplectic_euler", mass, alike), truth)
        note("file, the paper's", _from_scene("rk4_velocity", mass, alike), 0.0)
    return answers.comparison()


class Oscillator:
    """A regular solid of random mass and springs, full of gas: by symmetry it only swells and shrinks."""

    def __init__(self, mesh: Mesh, rng: np.random.Generator) -> None:
        self.mesh, self.mass, self.spring = mesh, 10.0 ** rng.uniform(-1.0, 1.0), 10.0 ** rng.uniform(1.0, 4.0)
        squares, particle_mass = (edge_lengths(mesh.vertices, mesh.edges) ** 2).sum(), self.mass / len(mesh.vertices)
        stiffness, inertia = self.spring * squares, particle_mass * (mesh.vertices**2).sum()
        self.gas = stiffness * rng.uniform(0.005, 0.1)
        self.rest = float(analytic.equilibrium_scale(self.gas, stiffness))
        self.free = float(analytic.breathing_frequency(self.gas, stiffness, inertia))  # [rad/s] without damping
        damping = 0.1 * float(analytic.critical_damping(self.spring, particle_mass))
        self.fading = 0.5 * damping * squares / inertia  # [1/s]

    def rates(self, steps: int, parts: int, **choice: Any) -> tuple[float, float]:
        """Return angular frequency and rate of fading [1/s] of a breath in a World, of default or chosen settings.

        It takes `steps` times `parts` a radian. A damped oscillation that is looked at every T has
        x'' = 2 e^(−δT) cos(ωT) x' − e^(−2δT) x from look to look.
        """
        span, paths = 1.0 / self.free, []
        for nudge in (1e-5, -1e-5):  # half of the difference: what is even in the amplitude cancels
            body = weightless(**choice).add_soft_body(self.mesh, self.mass, self.spring, self.gas)
            body.positions = (self.rest + nudge) * self.mesh.vertices
            path = []
            for _ in range(4):
                path.append((body.positions * self.mesh.vertices).sum() / (self.mesh.vertices**2).sum())
                body.world.step(span / (steps * parts), steps * parts)
            paths.append(path)
        x = np.array(paths[0]) - paths[1]
        trace, determinant = np.linalg.solve([[x[1], -x[0]], [x[2], -x[1]]], x[2:])
        return float(np.arccos(0.5 * trace / np.sqrt(determinant)) / span), float(-0.5 * np.log(determinant) / span)


def oscillators(rng: np.random.Generator, times: int) -> Iterator[tuple[str, Oscillator]]:
    """Yield one of each kind of solid, of any size, so many times."""
    for name, make in [*SOLIDS.items()] * times:
        yield name, Oscillator(make(rng.uniform(0.2, 2.0)), rng)


@check(
    section="2, 5.1",
    piece="softbody.World.step",
    reference="closed form of the damped oscillator that symmetry leaves",
    unit="of ω, of δ",
    kind="closed form",
    tolerance=2e-6,
    because="steps of ωh = 2.5e-3 and half of that, extrapolated, leave their square: 1.7e-7 at worst of ten seeds",
    faults=(HALVED, ON_A_WALL, WHOLE_MASS, NONE, PAPERS),
)
def solids_breathe_and_fade(run: Run) -> Comparison:
    """Gas-filled regular solids breathe at √(ω² − δ²) and fade at δ.

    By default, of any size, mass and springs, nudged from rest, as the step is made shorter: δ = c Σ l0²/2M, with c a
    tenth of critical.
    """
    answers = Answers()
    for name, oscillator in oscillators(run.fresh_rng(), run.count(1, 5, 40)):
        coarse, fine = (np.array(oscillator.rates(400, parts)) for parts in (1, 2))
        truth = [float(np.sqrt(oscillator.free**2 - oscillator.fading**2)), oscillator.fading]
        answers.extend(2.0 * fine - coarse, truth, truth, [f"{name}, frequency", f"{name}, fading"])
    return answers.comparison()


@check(
    section="2, 5.1",
    piece="softbody.World.step",
    reference="SciPy's DOP853 on springs, dampers, gas and weight by its own formulas",
    engines=("scipy",),
    unit="of the way and the size",
    tolerance=2e-5,
    because="a 32nd and a 64th of the stable step, extrapolated: 1.3e-6 at worst of ten seeds",
    faults=(HALVED, FIRST_SPRING, NONE, PAPERS, BY_THE_STEP),
)
def any_body_moves_as_scipy_says(run: Run) -> Comparison:
    """A body kicked in a default World moves as damped springs do.

    Of any mesh, gas and springs, no two of one alike, as the step is made shorter.
    """
    from references import scipy

    rng, answers = run.fresh_rng(), Answers()
    shapes = {
        "sphere": softbody.icosphere(1, 0.5),
        "torus": softbody.torus(0.7, 0.3, 10, 6),
        "box": softbody.box((0.6, 0.8, 1.0), 2),
    }
    for kind, mesh in [*shapes.items()] * run.count(1, 3, 20):
        mass, stiffness = rng.uniform(0.5, 2.0), rng.uniform(50.0, 150.0, len(mesh.edges))
        gas, velocity = rng.uniform(1.0, 10.0), rng.normal(size=3) + 0.2 * rng.normal(size=mesh.vertices.shape)
        found = []
        for parts in (32, 64):
            body = World().add_soft_body(mesh, mass, stiffness, gas)
            body.velocities = velocity
            steps = parts * int(np.ceil(0.4 / body.world.stable_time_step()))
            body.world.step(0.4 / steps, steps)
            found.append(body.positions)
        particle_mass = mass / len(mesh.vertices)
        damping = 0.1 * float(analytic.critical_damping(stiffness.mean(), particle_mass))
        springs = mesh.edges, edge_lengths(mesh.vertices, mesh.edges), stiffness
        weight = np.array([0.0, 0.0, -9.81]) * mass / len(mesh.vertices)
        what = mesh.vertices, velocity, *springs, mesh.triangles, gas, particle_mass, 0.4, weight
        truth, _ = scipy.motion(*what, rtol=1e-10, damping=damping)
        answers.extend(2.0 * found[1] - found[0], truth, np.ptp(mesh.vertices, axis=0).max(), kind)
    return answers.comparison()


@check(
    section="5.1",
    piece="softbody.World.step",
    reference="closed forms: a step leaves 1 − 2 δ h of the square of an amplitude, the paper's 1 − (ωh)²/2",
    unit="relative",
    kind="closed form",
    tolerance=0.03,
    because="fading in steps is δ (1 + δ h), and δ h is up to 3 %: 0.02",
    faults=(PAPERS, BY_THE_STEP, NONE),
)
def fading_does_not_depend_on_the_step(run: Run) -> Comparison:
    """A breath fades at the same rate in long and short steps.

    By default, in steps of a fifth of a radian and of a quarter of that. By the paper's integrator, which damps by
    itself, it fades at four times the rate.
    """
    answers = Answers()
    for name, oscillator in oscillators(run.fresh_rng(), run.count(1, 4, 30)):
        for kind, choice, truth in (("default", {}, 1.0), ("rk4_velocity", {"integrator": "rk4_velocity"}, 4.0)):
            long, short = (oscillator.rates(5, parts, **choice)[1] for parts in (1, 4))
            answers.add(long / short, truth, truth, f"{name}, {kind}")
    return answers.comparison()


@check(
    section="5.1, 9",
    piece="softbody.scenes.sphere_on_torus",
    reference="invariant: what is damped and pushed by nothing stands still",
    unit="m/s, root mean square of all particles",
    kind="invariant",
    least=1,
    tolerance=0.02,
    because="0.003 m/s, and 0.015 of the finest sphere; undamped, 0.18, and 0.1 after 20 s",
    faults=(NONE,),
)
def scene_1_comes_to_rest(run: Run) -> Comparison:
    """Scene 1 comes to rest by what bodies have by default.

    8 s after it began, particles are at rest, not only the bodies' centres.
    """
    answers = Answers()
    for subdivisions in (3, 2, 4)[: run.count(1, 2, 3)]:
        world = sphere_on_torus.build(subdivisions)
        world.run(8.0)
        answers.add(np.sqrt((world.state.particle_velocity**2).sum(axis=1).mean()), 0.0)
    return answers.comparison()
