"""Claims that each option of a world, and of its steps, does what it says with all others as by default."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import softbody
from references import analytic, steppers
from softbody import ParameterError, World
from softbody.bodies import adding
from softbody.model import settings
from softbody.stepping import frames, runner
from validation.answers import Answers
from validation.cases import edge_lengths, random_mesh, random_orientations, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.contract.cases import error_of
from validation.checks.worlds.cases import WEIGHTLESS
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

STEP = 1e-3
Told = Iterator[tuple[bool, bool]]  # what is found to be so, and what is so
CUBE = (1.0, 1.0, 1.0)
NONE: dict[str, Any] = {}  # options: all as by default


def _near(a: Any, b: Any, by: float = 1e-11) -> bool:
    return float(np.abs(np.subtract(a, b)).max()) <= by


def _gravity(rng: np.random.Generator) -> Told:
    for g in (rng.normal(0.0, 5.0, 3), None):
        world = World() if g is None else World(gravity=g)
        box = world.add_box(CUBE, 1.0)
        world.step(STEP, 50)
        fall = ((0.0, 0.0, -9.81) if g is None else g) * np.full(3, 50 * STEP * 51 * STEP / 2.0)
        yield _near(box.position, fall), True


class Swing:
    """A ball that swings, and where it is by each scheme of steps."""

    def __init__(self, rng: np.random.Generator, **options: Any) -> None:
        mesh, count = random_mesh("uneven sphere", rng), 20
        self.world = World(WEIGHTLESS, **options)
        self.ball = self.world.add_soft_body(mesh, 1.0, 10.0, 3.0, damping=0.01)
        self.ball.velocities = 0.1 * rng.normal(size=mesh.vertices.shape)
        lengths, still = edge_lengths(mesh.vertices, mesh.edges), np.zeros_like(mesh.vertices)
        self.body = steppers.SoftBody(
            mesh.edges, lengths, np.full(len(lengths), 10.0), mesh.triangles, 3.0, 1.0 / len(still), np.zeros(3),
            still, 0.01, 0.0, np.ones(len(still), bool),
        )  # fmt: skip
        self.start, self.count = (mesh.vertices, self.ball.velocities.copy()), count

    def is_by(self, scheme: str, substeps: int, by: float = 1e-11) -> bool:
        """Tell whether the ball is where a scheme has it."""
        part = STEP / substeps, self.count * substeps
        return _near(self.ball.positions, steppers.motion(self.body, *self.start, *part, scheme)[0], by)


def _integrator(rng: np.random.Generator) -> Told:
    for name in (*steppers.SCHEMES, None):
        swing = Swing(rng) if name is None else Swing(rng, integrator=name)
        swing.world.step(STEP, swing.count)
        yield from ((swing.is_by(each, 1), each == (name or "symplectic_euler")) for each in steppers.SCHEMES)


def _substeps(rng: np.random.Generator) -> Told:
    for given in ({"substeps": 3}, NONE):
        swing = Swing(rng, **given)
        swing.world.step(STEP, swing.count)
        yield from ((swing.is_by("symplectic_euler", n), n == (3 if given else 1)) for n in (1, 3))


def _of_a_call(call: Callable[[World, int], object]) -> Callable[[np.random.Generator], Told]:
    """Return what asks for the sub-steps that a call is told, which hold for it alone."""

    def ask(rng: np.random.Generator) -> Told:
        for given in (1, 3):
            swing = Swing(rng, substeps=2)
            call(swing.world, given)
            yield from ((swing.is_by("symplectic_euler", n), n == given) for n in (1, 2, 3))
            yield swing.world.substeps == 2, True

    return ask


def _precision(rng: np.random.Generator) -> Told:
    for given in ({"precision": "single"}, NONE):
        swing = Swing(rng, **given)
        swing.world.step(STEP, swing.count)
        is_rounded = bool((np.float32(swing.ball.positions) == swing.ball.positions).all())
        yield is_rounded, bool(given)
        yield swing.is_by("symplectic_euler", 1), not given
        yield swing.is_by("symplectic_euler", 1, 1e-5), True


def _threads(rng: np.random.Generator) -> Told:
    for threads in (1, 2):
        swing = Swing(rng, threads=threads)
        swing.world.step(STEP, swing.count)
        yield swing.is_by("symplectic_euler", 1), True
        yield swing.world.threads == threads, True


def _axes(rng: np.random.Generator) -> Told:
    """Ask whether edges that pass each other, a hundredth apart, are taken for a hit."""
    half = np.sqrt(0.5)
    for given in ({"axes": "paper"}, {"axes": "complete"}, NONE):
        world = World(WEIGHTLESS, **given)
        for axis, height in ((0, 0.0), (1, 2.0 * half + rng.uniform(0.005, 0.02))):
            turn = np.append(np.cos(np.pi / 8), np.sin(np.pi / 8) * np.eye(3)[axis])
            world.add_box(CUBE, 1.0, (0.0, 0.0, height), turn)
        world.step(STEP)
        yield len(world.contact_points()) > 0, given.get("axes") == "paper"


def _contact(rng: np.random.Generator) -> Told:
    """Ask whether a box that has come down upright stays so, on all its corners, or is turned by one impulse."""
    for given in ({"contact": "single"}, {"contact": "manifold"}, NONE):
        world = World(**given)
        world.add_box((2.0, 2.0, 1.0), None)
        box = world.add_box(CUBE, 1.0, (*rng.uniform(0.1, 0.3, 2), 1.0 - 1e-6))
        world.step(STEP)
        yield _near(box.angular_velocity, 0.0, 1e-9), given.get("contact") != "single"


def _iterations(rng: np.random.Generator) -> Told:
    """Ask whether a beam on two posts, with a load on one side, stays at rest."""
    for sweeps in (1, 3000):
        world = World(iterations=sweeps)
        world.add_ground()
        cube = (0.5, 0.5, 0.5)
        boxes = [world.add_box(cube, 1.0, (x, 0.0, 0.25)) for x in (-1.0, 1.0)]
        boxes += [world.add_box((4.0, 0.3, 0.2), 2.0, (0.0, 0.0, 0.6))]
        boxes += [world.add_box(cube, rng.uniform(2.0, 4.0), (rng.uniform(0.4, 0.6), 0.0, 0.95))]
        world.step(STEP)
        yield all(_near(box.velocity, 0.0, 5e-5) for box in boxes), sweeps > 1


def _soft_contact(rng: np.random.Generator) -> Told:
    """Ask whether who meets goes as far as its velocity says, or is parted at the end of the step besides."""
    for given in ({"soft_contact": "single"}, {"soft_contact": "together"}, NONE):
        world, ball = World(WEIGHTLESS, **given), softbody.icosphere(1, 0.5)
        balls = [world.add_soft_body(ball, 1.0, 50.0, 5.0, (0.0, 0.0, 0.98 * k)) for k in (0, 1)]
        balls[1].velocities = (0.0, 0.0, -rng.uniform(0.5, 1.0))
        before = balls[0].positions.copy()
        world.step(STEP)
        is_free = _near(balls[0].positions, before + STEP * balls[0].velocities, 1e-4)
        yield is_free, given.get("soft_contact") != "single"


def _pairs(rng: np.random.Generator) -> Told:
    place, hashes = rng.uniform(-0.2, 0.2, 2), set()
    for given in ({"pairs": "exhaustive"}, {"pairs": "grid"}, NONE):
        world = World(**given)
        world.add_ground()
        for k in range(3):
            world.add_soft_body(softbody.icosphere(1, 0.5), 1.0, 100.0, 20.0, (*place * k, 0.5 + 0.98 * k))
        world.step(STEP, 30)
        yield len(world.contact_points()) > 0, True
        hashes.add(world.state_hash())
    yield len(hashes) == 1, True


def _edge_contacts(rng: np.random.Generator) -> Told:
    """Ask whether a bar that falls across another lies on it, where both have corners at their ends alone."""
    for given in ({"edge_contacts": False}, {"edge_contacts": True}, NONE):
        world = World(WEIGHTLESS, **given)
        bars = [world.add_soft_body(softbody.box(size, 1), 1.0, 500.0, 2.0, (0.0, 0.0, 0.3 * k))
                for k, size in enumerate(((2.0, 0.2, 0.2), (0.2, 2.0, 0.2)))]  # fmt: skip
        bars[1].velocities = (0.0, 0.0, -rng.uniform(1.0, 1.5))
        world.run(0.5, STEP)
        yield bool(bars[1].centre[2] > bars[0].centre[2]), given.get("edge_contacts", True)


def _split_steps(rng: np.random.Generator) -> Told:
    """Ask how long the last part of a step is, in which gravity moves a box by some sixteenths of its thickness."""
    for given in ({"split_steps": False}, {"split_steps": True}, NONE):
        world, thickness = World(**given), rng.uniform(5e-4, 2e-3)
        world.add_ground()
        world.add_box((1.0, 1.0, thickness), 1.0, (0.0, 0.0, 0.5 * thickness))
        world.step(10.0 * STEP)
        parts = np.ceil(10.0 * STEP * np.sqrt(16.0 * 9.81 / thickness)) if given.get("split_steps", True) else 1.0
        yield _near(world.contact_points().time_step, 10.0 * STEP / parts), True


def _gyroscopic(rng: np.random.Generator) -> Told:
    for given in ({"gyroscopic": True}, {"gyroscopic": False}, NONE):
        world, size, spin = (
            World(WEIGHTLESS, **given),
            rng.uniform((0.2, 0.5, 1.0), (0.4, 0.8, 1.5)),
            rng.normal(size=3),
        )
        box = world.add_box(size, 1.0, orientation=random_orientations(rng, 1)[0], angular_velocity=spin)

        def momentum(box: softbody.Box = box, size: np.ndarray = size) -> np.ndarray:
            turn = rotation_matrix(box.orientation)
            return turn @ (analytic.box_inertia(size, 1.0) * (turn.T @ box.angular_velocity))

        start = momentum()
        world.step(STEP, 300)
        is_kept = _near(momentum(), start, 5e-3 * float(np.linalg.norm(start)))
        yield is_kept, bool(given.get("gyroscopic"))
        yield _near(box.angular_velocity, spin), not given.get("gyroscopic")


def _ceiling(option: str) -> Callable[[np.random.Generator], Told]:
    def ask(rng: np.random.Generator) -> Told:
        what = "velocity" if option == "speed_ceiling" else "angular_velocity"
        for most in (rng.uniform(1.0, 3.0), None):
            given: dict[str, Any] = {} if most is None else {option: most}
            world, way = World(WEIGHTLESS, **given), 9.0 * rng.normal(size=3)
            way *= max(1.0, 4.0 / float(np.linalg.norm(way)))
            box = world.add_box(CUBE, 1.0, velocity=way, angular_velocity=way)
            world.step(STEP, 3)
            for each in ("velocity", "angular_velocity"):
                slow = way if most is None or each != what else way * most / np.linalg.norm(way)
                yield _near(getattr(box, each), slow), True

    return ask


def _angular_speed_floor(rng: np.random.Generator) -> Told:
    for least in (0.2, None):
        given: dict[str, Any] = {} if least is None else {"angular_speed_floor": least}
        world = World(**given)
        world.add_ground(friction=0.0)
        spin = (0.0, 0.0, rng.uniform(0.05, 0.15))
        boxes = [world.add_box(CUBE, 1.0, (0.0, 9.0 * k, 0.5 + 9.0 * k), angular_velocity=spin) for k in (0, 1)]
        world.step(STEP, 20)
        yield bool(boxes[0].angular_velocity[2] == 0.0), least is not None
        yield _near(boxes[0].orientation, (1.0, 0.0, 0.0, 0.0)), least is not None
        yield _near(boxes[1].angular_velocity, spin), True  # in the air


def _frictionless(rng: np.random.Generator) -> Told:
    for given in ({"frictionless": True}, NONE):
        world, speed = World(**given), rng.uniform(1.0, 2.0)
        ground = world.add_ground()
        box = world.add_box(CUBE, 1.0, (0.0, 0.0, 0.5), velocity=(speed, 0.0, 0.0))
        ball = world.add_soft_body(softbody.octahedron(0.2), 1.0, 10.0, 0.0, (0.0, 0.0, 9.0))
        world.step(STEP, 50)
        slower = 0.0 if given else 0.5 * 9.81 * 50 * STEP
        yield _near(box.velocity[0], speed - slower, 1e-6), True
        yield [box.friction, ball.friction, ground.friction] == [0.0 if given else 0.5] * 3, True


def _self_contact(rng: np.random.Generator) -> Told:
    for given in ({"self_contact": True}, NONE):
        ball = World(**given).add_soft_body(softbody.icosphere(2, rng.uniform(0.5, 1.0)), 1.0, 10.0, 1.0)
        yield ball.self_contact > 0.0, bool(given)


def _sleep(**given: Any) -> Callable[[np.random.Generator], Told]:
    def ask(rng: np.random.Generator) -> Told:
        world, after = World(WEIGHTLESS, **given), given.get("sleep_after", 0.5)
        box = world.add_box(CUBE, 1.0, velocity=(rng.uniform(0.0, 0.01), 0.0, 0.0))
        fast = world.add_box(CUBE, 1.0, (0.0, 9.0, 0.0), velocity=(0.03, 0.0, 0.0))
        may = "sleep_speed" in given
        for until, is_so in ((0.9 * after, False), (1.1 * after, may)):
            world.run(until - world.time, STEP)
            yield box.is_asleep, is_so
            yield fast.is_asleep, False

    return ask


def _allow_unstable(rng: np.random.Generator) -> Told:
    for call in (lambda world, h, **given: world.step(h, **given), lambda world, h, **given: world.run(h, h, **given)):
        for given in ({"allow_unstable": True}, {"allow_unstable": False}, NONE):
            swing = Swing(rng)
            too_long = 1.01 * swing.world.stable_time_step()
            refusal = error_of(ParameterError, call, swing.world, too_long, **given)
            yield refusal is not None, not given.get("allow_unstable")


OPTIONS: dict[str, Callable[[np.random.Generator], Told]] = {
    "gravity": _gravity,
    "precision": _precision,
    "threads": _threads,
    "integrator": _integrator,
    "substeps": _substeps,
    "axes": _axes,
    "contact": _contact,
    "iterations": _iterations,
    "soft_contact": _soft_contact,
    "pairs": _pairs,
    "edge_contacts": _edge_contacts,
    "split_steps": _split_steps,
    "gyroscopic": _gyroscopic,
    "speed_ceiling": _ceiling("speed_ceiling"),
    "angular_speed_ceiling": _ceiling("angular_speed_ceiling"),
    "angular_speed_floor": _angular_speed_floor,
    "frictionless": _frictionless,
    "self_contact": _self_contact,
    "sleep_speed": _sleep(sleep_speed=0.02),
    "sleep_after": _sleep(sleep_after=0.1),
    "sleep_speed, sleep_after": _sleep(sleep_speed=0.02, sleep_after=0.2),
    "step, substeps": _of_a_call(lambda world, parts: world.step(STEP, 20, substeps=parts)),
    "run, substeps": _of_a_call(lambda world, parts: world.run(20 * STEP, STEP, substeps=parts)),
    "step and run, allow_unstable": _allow_unstable,
}


@check(
    section="5, 6",
    piece="softbody.World, softbody.World.step, softbody.World.run",
    reference="the documentation; NumPy's own steps, closed forms of falls, slides and turns",
    engines=("scipy",),
    because="yes or no",
    faults=(
        Fault(
            "spins that are never gyroscopic",
            World.__init__,
            "{'edge_contacts': a_, 'split_steps': b_, 'gyroscopic': c_} → {'edge_contacts': a_, 'split_steps': b_}",
        ),
        Fault(
            "edges that always hold",
            World.__init__,
            "{'edge_contacts': a_, 'split_steps': b_, 'gyroscopic': c_} → {'split_steps': b_, 'gyroscopic': c_}",
        ),
        Fault(
            "each ceiling for the other",
            World.__init__,
            "{'speed_ceiling': a_, 'angular_speed_ceiling': b_} → {'speed_ceiling': b_, 'angular_speed_ceiling': a_}",
        ),
        Fault("doubles whatever is asked for", World.__init__, "PRECISIONS[precision] → np.float64"),
        Fault(
            "steps that are always in parts",
            settings.settings_of,
            "check_yes_or_no(value, name) → check_yes_or_no(value, name) or name == 'split_steps'",
        ),
        Fault("one sweep, and one part of a step", settings.settings_of, "check_whole(value, name, 1) → 1"),
        Fault("no limit to anything", settings.settings_of, "inf if unlimited else c_ → inf"),
        Fault(
            "skins that wait to be told one by one",
            adding.add_soft_body,
            "store.settings.self_contact → False",
        ),
        Fault(
            "friction that is as by default",
            adding._properties,
            "properties | (n_ if store.settings.frictionless else {}) → properties",
        ),
        Fault(
            "sub-steps of a call on top of the world's",
            runner.Runner.step,
            "settings._replace(substeps=n_) → settings._replace(substeps=n_ * settings.substeps)",
        ),
        Fault(
            "forces of contacts by the whole of a step in parts",
            runner.Runner.contact_points,
            "float(store.clock.part[0]) → float(store.time_step)",
        ),
        Fault(
            "sub-steps of a run that are forgotten",
            frames.run,
            "runner.step(h, steps, substeps, allow_unstable) → runner.step(h, steps, None, allow_unstable)",
        ),
        Fault(
            "runs that allow what is unstable",
            frames.run,
            "runner.step(h, steps, substeps, allow_unstable) → runner.step(h, steps, substeps, True)",
        ),
    ),
)
def each_option_does_what_it_says(run: Run) -> Comparison:
    """Each option of a world does by itself what it says.

    Every argument of a World, and of its steps, alone with all others as by default, and its default: where bodies are
    and how they move, what they touch, and who sleeps, beside what it says. An argument without a case is seen.
    """
    rng, answers = run.fresh_rng(), Answers()
    known = {name for name in OPTIONS if " " not in name}
    answers.add(known == inspect.signature(World).parameters.keys(), True, kind="all options there are")
    for _ in range(run.count(2, 5, 30)):
        for name, ask in OPTIONS.items():
            for found, judged in ask(rng):
                answers.add(found, judged, kind=name)
    return answers.comparison()
