"""Claims about the advice and warnings of a World: the step that helps after divergence, and heavy loads."""

from __future__ import annotations

import re
import warnings
from itertools import product
from typing import Any

import numpy as np

import softbody
from softbody import Box, InflationWarning, MassRatioWarning, Mesh, ParameterError, SimulationError, World
from softbody.dynamics.rigid_boxes import diverged_box
from softbody.errors import SoftbodyError
from softbody.stepping import checks, inflation, step
from softbody.stepping.checks import check_box_motion
from softbody.stepping.inflation import Balloon, Inflation
from validation.answers import Answers
from validation.cases import edge_lengths, random_orientations, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.contract.cases import error_of
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

WHAT = "position", "velocity", "angular_velocity", "orientation"  # of a box may be astray
FARTHEST, MOST_TURN, UNIT = 2.0**46, 1e6, 1e-6  # times the least size; [rad] a step; of a turn's squared length


@check(
    section="beyond the paper",
    piece="softbody.SimulationError",
    reference="those rules, along each axis, by NumPy",
    kind="specification",
    unit="relative",
    tolerance=1e-13,
    because="rounding of speeds that differ by a thirtieth: 1.1e-14 at worst of ten seeds",
    faults=(
        Fault("particles that cross their whole body", checks.helpful_step, "0.5 * extent / s_ → 1.0 * extent / s_"),
        Fault("speeds as seen from the world", checks.helpful_step, "velocity - velocity.mean(axis=0) → velocity"),
        Fault("boxes that fall as without loads", checks.helpful_step, "controls.box_force → 0.0"),
        Fault("the slowest axis of boxes", checks.helpful_step, "np.abs(rows).max(axis=1) → np.abs(rows).min(axis=1)"),
        Fault("turns that are left out", checks.helpful_step, "1.0 / spin → size / speed"),
    ),
)
def steps_that_help(run: Run) -> Comparison:
    """The step advised after a collapse is the longest that helps.

    No particle crosses half of its body, as seen from the body's mean motion. No box goes farther than its least size,
    or turns by over a radian, by its speed or by what pushes and twists it. Several bodies, all unlike.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(40, 200, 2_000)):
        gravity = 10.0 ** rng.uniform(-2.0, 3.0) * rng.normal(size=3)
        world = World(gravity=gravity)
        limits: dict[str, float] = {}
        ball = softbody.icosahedron()
        world.add_soft_body(ball, 1.0, 1e-9, 1e-9, (0.0, -50.0, 0.0), damping=0.0, deflated_below=1.0)
        world.soft_bodies[0].positions = 0.99 * ball.vertices - (0.0, 50.0, 0.0)  # it has collapsed after any step
        for k in range(int(rng.integers(1, 4))):
            mesh = softbody.icosahedron(rng.uniform(0.3, 2.0)).scaled(rng.uniform(0.5, 2.0))
            body = world.add_soft_body(mesh, 1.0, 1e-9, 1e-9, (20.0 * k, 0.0, 0.0), damping=0.0)
            pace = 10.0 ** rng.uniform(-1.0, 2.0)
            drift, scatter = 30.0 * pace * rng.normal(size=3), pace * rng.normal(size=(12, 3))
            body.velocities = scatter + drift
            crossing = np.ptp(body.positions, axis=0).max() / np.abs(scatter - scatter.mean(axis=0)).max()
            limits[f"speed of soft body {k}"] = 0.5 * float(crossing)
        for k in range(int(rng.integers(0, 4))):
            size, mass = rng.uniform(0.2, 2.0, 3), 10.0 ** rng.uniform(-1.0, 1.0)
            speed, spin = (10.0 ** rng.uniform(0.0, 3.0) * rng.normal(size=3) for _ in range(2))
            box = world.add_box(size, mass, (20.0 * k, 50.0, 0.0), velocity=speed, angular_velocity=spin)
            force, torque = (10.0 ** rng.uniform(0.0, 5.0) * rng.normal(size=3) for _ in range(2))
            box.apply_force(force)
            box.apply_torque(torque)
            inertia = mass / 12.0 * ((size**2).sum() - size**2)
            limits[f"speed of box {k}"] = size.min() / np.abs(speed).max()
            limits[f"spin of box {k}"] = 1.0 / np.abs(spin).max()
            limits[f"push on box {k}"] = float(np.sqrt(size.min() / np.abs(gravity + force / mass).max()))
            limits[f"twist of box {k}"] = float(np.sqrt(inertia.min() / np.abs(torque).max()))
        error = error_of(SimulationError, world.step, 1e-9)
        told = error.stable_time_step if error and error.step == 0 else np.inf
        least = min(limits, key=lambda what: limits[what])
        answers.add(told / limits[least], 1.0, kind=least.rstrip("0123456789 "))
    return answers.comparison()


@check(
    section="beyond the paper",
    piece="softbody.World.step",
    reference="the documented limits, along the axes of the world, by NumPy; a twin that was not stepped",
    kind="specification",
    faults=(
        Fault(
            "a step that was not taken counts",
            step.run,
            "fault, body = DIVERGED, n_ → fault, body, done = DIVERGED, n_, 1",
        ),
        Fault("the first box alone", diverged_box, "range(n_) → range(1)"),
        Fault(
            "turns in a second",
            diverged_box,
            "h * abs(state.box_angular_velocity[i, c]) → abs(state.box_angular_velocity[i, c])",
        ),
        Fault(
            "limits by the thickest side",
            diverged_box,
            "min(size[0], size[1], size[2]) → max(size[0], size[1], size[2])",
        ),
        Fault("orientations of any length", check_box_motion, "u_ > UNIT → False"),
    ),
)
def boxes_that_are_astray(run: Run) -> Comparison:
    """A box that is astray before a step is refused by name.

    So far away or so fast that its thinnest side is lost in rounding, to turn by a million radians, or of no
    orientation. The error says what is wrong, and nothing has happened; a tenth as far, or as fast, the step is taken.
    """
    rng, answers = run.fresh_rng(), Answers()
    for trial in range(run.count(48, 240, 2_400)):
        what, count = WHAT[trial % 4], int(rng.integers(1, 4))
        times, h = (1.5, 0.1)[trial // 4 % 2], 10.0 ** rng.uniform(-4.0, -1.0)
        world, number = World(gravity=(0.0, 0.0, 0.0)), int(rng.integers(count))
        for k in range(count):
            size = 10.0 ** rng.uniform(-2.0, 2.0) * rng.uniform(0.3, 1.0, 3)
            world.add_box(size, 1.0, (0.0, 0.0, 1e3 * k))
        box, way = world.boxes[number], rng.normal(size=3)
        way /= np.abs(way).sum()
        if trial // 8 % 2:  # not the first step
            world.step(h)
        lead_astray(box, what, times, h, way, rng)
        before = world.state.copy(), world.steps, world.time
        error = error_of(SoftbodyError, world.step, h)
        if times < 1.0:
            is_so = error is None and world.steps == before[1] + 1
        else:
            same = all(one.tobytes() == other.tobytes() for one, other in zip(before[0], world.state))
            is_named = isinstance(error, ParameterError) and str(error).startswith(f"{what} of box {number} is ")
            is_so = is_named and same and (world.steps, world.time) == before[1:]
        answers.add(is_so, True, kind=f"{what}, {'too much' if times > 1.0 else 'not too much'}")
    return answers.comparison()


def lead_astray(box: Box, what: str, times: float, h: float, way: np.ndarray, rng: np.random.Generator) -> None:
    """Set one thing of a box to so many times its limit in a step of h."""
    if what == "position":
        box.position = times * FARTHEST * box.size.min() * way
    elif what == "velocity":
        box.velocity = times * FARTHEST * box.size.min() / h * way
    elif what == "angular_velocity":
        box.angular_velocity = times * MOST_TURN / h * way
    else:
        box.world.state.box_orientation[box.index] *= np.sqrt(1.0 + times * UNIT * rng.choice([-1.0, 1.0]))


# Which bodies lie on each other, the lower one first, and how many times its own mass a box carries.
PAIRS = {("box", "box"): 1e6, ("box", "soft"): 1e4, ("soft", "box"): np.inf}


@check(
    section="beyond the paper",
    piece="softbody.MassRatioWarning",
    reference="the documentation, and which of the two is above, by NumPy",
    kind="specification",
    faults=(
        Fault("boxes that carry as little of boxes", checks.warn_of_mass_ratios, "upper < soft → upper >= 0"),
        Fault("what leans on a box", checks.warn_of_mass_ratios, "np.abs(steepness) > 0.5 → True"),
        Fault("gravity of any strength", checks.warn_of_mass_ratios, "max(n_, TINY) → 1.0"),
        Fault("what hangs below", checks.warn_of_mass_ratios, "steepness > 0.0 → steepness < 0.0"),
    ),
)
def loads_that_are_too_heavy(run: Run) -> Comparison:
    """A box that carries too much is named by a warning.

    More than 10 000 times its mass of a soft body, or a million times of a box: by what, and how many times, it says.
    Of two that touch, one is above the other by over half of the way, whichever way gravity pulls; else none is.
    """
    rng, answers = run.fresh_rng(), Answers()
    ratios = (0.9e4, 1.1e4, 0.9e6, 1.1e6)
    for (lower, upper), ratio, _ in product(PAIRS, ratios, range(run.count(8, 30, 300))):
        turn = random_orientations(rng, 1)[0]
        across, _, up = rotation_matrix(turn).T
        lean = np.deg2rad(rng.choice([0.0, 20.0, 55.0, 65.0, 90.0, 115.0, 125.0, 180.0]))
        strength = 10.0 ** rng.uniform(-3.0, 1.0)
        world = World(gravity=-strength * (np.cos(lean) * up + np.sin(lean) * across))
        made: dict[str, Any] = {}
        sides = [("lower", lower, -0.5 + 1e-4, 1.0 / ratio), ("upper", upper, 0.5 - 1e-4, 1.0)]
        for side, kind, away, mass in sides if rng.random() < 0.5 else sides[::-1]:
            if kind == "box":
                made[side] = world.add_box((1.0, 1.0, 1.0), mass, away * up, turn)
            else:
                corners = softbody.octahedron(0.5)
                turned = Mesh(corners.vertices @ rotation_matrix(turn).T, corners.triangles)
                made[side] = world.add_soft_body(turned, mass, 100.0 * mass, 0.0, away * up)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            world.step(1e-6)
        texts = [str(each.message) for each in caught if each.category is MassRatioWarning]
        names = {side: f"{body.kind} {body.index}" for side, body in made.items()}
        is_heavy = np.cos(lean) > 0.5 and ratio > PAIRS[lower, upper]
        begins = f"{names['lower']} carries {names['upper']}, {ratio:.3g} times its own mass"
        is_so = len(texts) == 1 and texts[0].startswith(begins) if is_heavy else not texts
        answers.add(is_so, True, kind=f"{upper} on {lower}, {ratio:g} times as heavy")
    return answers.comparison()


SOLIDS = softbody.tetrahedron, softbody.octahedron, softbody.icosahedron  # that keep their shape as they grow
NUMBERS = re.compile(
    r"by (?P<strain>\d+)%, to (?P<volume>\S+) times .* are (?P<pressure>\S+) Pa\. For 30% give it a gas of "
    r"(?P<gas>\S+) J, which is (?P<less>\S+) Pa now, or (?P<firmer>\S+) times the stiffness"
)


@check(
    section="2.3",
    piece="softbody.InflationWarning",
    reference="P = Pₒ + n k (s − 1) l² / 3 V s², of a regular polyhedron of n edges, s times as large",
    kind="closed form",
    faults=(
        Fault("half as much again", Inflation, "balloon.size(MOST) → balloon.size(1.5 * MOST)"),
        Fault("a skin that grows by its edges", Balloon._of_springs, "3.0 * self.volume * size**2 → 3.0 * self.volume"),
        Fault("vacuum outside", inflation._balloon, "max(0.0, depth) → 0.0"),
        Fault("a warning at each change", Inflation, "self._told.add(body) → pass"),
        Fault("one look", Inflation, "self._known[1] == gas → True"),
        Fault("the strain half-way", Balloon.strain, "return high → return 0.5 * high"),
        Fault("as stiff as the gas is more", Balloon.firmer, "self._of_springs(size) → self.held(size)"),
    ),
)
def gas_that_stretches_far_is_told(run: Run) -> Comparison:
    """Gas that will stretch a body by 30 % is told.

    Polyhedra of a centimetre to a metre, in vacuum or deep in a liquid, are given gas or a pressure at once, or on the
    way. Those it stretches by over 30 % are told before the first step with it, once: by how much, to which volume, and
    which gas or stiffness would do. With these a hundredth within, nothing is said; a hundredth beyond, it is.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(60, 200, 2000)):
        mesh = SOLIDS[rng.integers(len(SOLIDS))](10.0 ** rng.uniform(-2.0, 0.0))
        springs, volume = len(mesh.edges) * np.square(edge_lengths(mesh.vertices, mesh.edges)).mean(), mesh.volume
        stiffness = 10.0 ** rng.uniform(0.0, 4.0)
        strain = rng.choice([0.05, 0.29, 0.31, 0.6, 2.0]) * rng.uniform(0.97, 1.03)
        outside = 9810.0 * rng.uniform(0.5, 20.0) if rng.random() < 0.4 else 0.0
        gas = _balanced(strain, stiffness * springs, volume, outside)
        ways = "gas", "pressure", "gas later", "pressure later"
        way = ways[rng.integers(len(ways))]
        world = World()
        if outside:
            world.add_liquid(1000.0, outside / 9810.0)
        at_once = {"gas": {"gas": gas}, "pressure": {"pressure": gas / volume}}.get(way, {"gas": 0.0})
        body = world.add_soft_body(mesh, 1.0, stiffness, name="part", **at_once)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            world.step(1e-9)
            if way == "gas later":
                body.gas = gas
            elif way == "pressure later":
                body.pressure = gas / volume
            world.step(1e-9)
            texts = _inflations(caught)
            body.gas = 1.01 * gas
            world.step(1e-9)
            again = _inflations(caught)
        goes = strain > 0.3
        answers.add(len(texts) == goes, True, kind=f"whether it is told, {way}")
        if not goes or len(texts) != 1:
            continue
        answers.add(len(again) == 1, True, kind="once")
        found = NUMBERS.search(texts[0])
        said = {key: float(value) for key, value in found.groupdict().items()} if found else {}
        right = {"strain": 100.0 * strain, "volume": (1.0 + strain) ** 3, "pressure": gas / volume}
        right["gas"] = _balanced(0.3, stiffness * springs, volume, outside)
        right["less"] = right["gas"] / volume
        held = gas / (volume * 1.3**3) - outside
        right["firmer"] = held * 3.0 * volume * 1.3**2 / (0.3 * stiffness * springs)
        rounding = {"strain": 0.5 + 0.1 * strain, **{key: 0.006 * right[key] for key in right if key != "strain"}}
        for key, value in right.items():
            is_so = key in said and abs(said[key] - value) <= rounding[key]
            answers.add(is_so, True, kind=f"what it says: {key}")
        answers.add("soft body 0 'part'" in texts[0], True, kind="who")
    return answers.comparison()


def _balanced(strain: float, springs: float, volume: float, outside: float) -> float:
    """Return the gas [J] of a body whose springs, Σ k l² = `springs` [J] as it was made, have a strain."""
    size = 1.0 + strain
    pressure = outside + springs * strain / (3.0 * volume * size**2)
    return float(pressure * volume * size**3)


def _inflations(caught: list[warnings.WarningMessage]) -> list[str]:
    return [str(each.message) for each in caught if each.category is InflationWarning]


@check(
    section="beyond the paper",
    piece="softbody.World.step",
    reference="those rules, by NumPy; the box that was asked about, among others; a copy of its state",
    kind="specification",
    because="yes or no, a hundredth from each limit; or at it, and a rounding beyond, in powers of two",
    faults=(
        Fault("boxes however fast", check_box_motion, "not a_ + h * b_ <= RESOLVED * size.min() → False"),
        Fault("boxes however far away", check_box_motion, "not np.abs(position).sum() <= r_ → False"),
        Fault("spins however fast", check_box_motion, "not h * s_ <= MOST_TURN → False"),
        Fault("boxes turned by no unit quaternion", check_box_motion, "abs(a_ - 1.0) > UNIT → False"),
        Fault("advice to take as long a step", check_box_motion, "MOST_TURN / spin / 2.0 → MOST_TURN / spin * 2.0"),
        Fault("the longest side", diverged_box, "min(size[0], size[1], size[2]) → max(size[0], size[1], size[2])"),
        Fault("boxes that are just there", diverged_box, "far <= RESOLVED * n_ → far < RESOLVED * n_"),
    ),
)
def boxes_too_fast_to_compute(run: Run) -> Comparison:
    """A box beyond what can be computed is refused by its number.

    Its place, or where a step takes it to, is farther than 2**46 times its least size, summed over the axes; or it
    turns by over a million radians in the step; or its turn is no unit quaternion. The error says which, and all is as
    it was. Just below these, or just there, also after one more step, it is taken; so are the steps that are advised.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(2, 10, 100)):
        for what, factor in product(WHAT, (0.99, 1.01)):
            world, h = World(gravity=(0.0, 0.0, 0.0)), 10.0 ** rng.uniform(-4.0, 0.0)
            for k, size in enumerate(rng.uniform(0.2, 2.0, (3, 3))):
                world.add_box(size, 1.0, (0.0, 10.0 * k, 0.0))
            box, way, times = world.boxes[int(rng.integers(0, 3))], rng.normal(size=3), factor
            way = way / np.abs(way).sum()
            if what == "velocity":
                near = rng.uniform(0.0, 0.9)
                lead_astray(box, "position", near, h, way, rng)
                times = (factor - near) / (1.0 if factor > 1.0 else 2.0)  # to which one more step must be possible
            lead_astray(box, what, times, h, way, rng)
            is_so = _is_paced(world, h, factor > 1.0, f"{what} of box {box.index} is")
            answers.add(is_so, True, kind=f"{what}, {factor} of the limit")
        for what, is_beyond in product(("position", "velocity"), (False, True)):
            world, h = World(gravity=(0.0, 0.0, 0.0)), 2.0 ** rng.integers(-12, 1)
            size = rng.integers(1, 64, 3) / 32.0
            box, way = world.add_box(size, 1.0), rng.permutation([0.5, 0.25, 0.25]) * rng.choice([-1.0, 1.0], 3)
            farthest = FARTHEST * size.min()
            if is_beyond:
                way = rng.permutation([1.0, 0.0, 0.0])
            if what == "position":
                box.position = (np.nextafter(farthest, np.inf) if is_beyond else farthest) * way
            else:  # there at the end of the second step, or, a rounding beyond, of this one
                box.position = 0.5 * farthest * way
                box.velocity = (np.nextafter(0.5, 1.0) + 2.0**-53 if is_beyond else 0.25) * farthest / h * way
            is_so = _is_paced(world, h, is_beyond, f"{what} of box 0 is")
            answers.add(is_so, True, kind=f"{what}, {'a rounding beyond' if is_beyond else 'at'} the limit")
    return answers.comparison()


def _is_paced(world: World, h: float, is_fast: bool, named: str) -> bool:
    """Tell whether a step is refused by what it must be, and taken where it must be, or in the step that is advised."""
    before = world.state_hash()
    error = error_of(SoftbodyError, world.step, h)
    if error is None or not isinstance(error, ParameterError):
        return error is None and not is_fast
    if not (is_fast and named in str(error) and world.state_hash() == before and world.steps == 0):
        return False
    advised = re.search(r"(?:such as|up to) ([-+.e0-9]+) s", str(error))
    return advised is None or _is_paced(world, float(advised[1]), False, named)
