"""Claims about jaws: what they hold, and that they may close too far."""

from __future__ import annotations

import numpy as np

import softbody
from softbody import World
from softbody.collision.soft import soft_solver
from softbody.collision.solver import sequential_impulses
from validation.answers import Answers
from validation.cases import rotated
from validation.check import Comparison, Run, check
from validation.checks.worlds.cases import WEIGHTLESS, by_turns
from validation.fault import Fault

FAMILY = "under load"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

G = 9.81  # [m/s²]
SIDE = 0.085  # [m] of what is gripped


@check(
    section="beyond the paper",
    piece="softbody.collision.solver.sequential_impulses.solve_velocities",
    reference="symmetry: between two equal jaws a box stays where it is, and goes where they go",
    kind="invariant",
    unit="of how much too far the jaws close",
    tolerance=0.08,
    because="what sweeps leave: 0.059 at worst of 440 grips; 0.12 and more if impulses do not give way, and 1.7 if"
    " shifts do not either",
    faults=(
        Fault(
            "impulses of jaws that do not give way",
            sequential_impulses._sweep_all,
            "is_stuck and changed > enough → False",
        ),
        Fault(
            "shifts of jaws that do not give way", sequential_impulses.solve_positions, "pressing_.shape[0] > 0 → False"
        ),
    ),
)
def jaws_close_too_far(run: Run) -> Comparison:
    """A box that jaws close on too far stays between them.

    Jaws of 20 mm close on a box of 85 mm by 0.5 to 8 mm too far, in 0.1 to 2 s, at 60 to 1000 steps a second. The box
    has 1 g to 1 t. It is not pressed aside, and is lifted by 0.2 m.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(8, 40, 200)):
        over, mass = rng.uniform(5e-4, 8e-3), 10.0 ** rng.uniform(-3.0, 3.0)
        side, step, seconds = rng.uniform(0.03, 0.08), 10.0 ** rng.uniform(-3.0, -1.8), 10.0 ** rng.uniform(-1.0, 0.3)
        world = World()
        world.add_ground()
        box = world.add_box((SIDE,) * 3, mass, (0.0, 0.0, 0.5 * SIDE), friction=1.0)
        jaws = [world.add_box((0.02, side, side), None, (x, 0.0, 0.05), friction=1.0) for x in (-0.1, 0.1)]
        closed = 0.5 * (SIDE - over) + 0.01
        for jaw, x in zip(jaws, (-closed, closed)):
            jaw.move_to((x, 0.0, 0.05), seconds=seconds)
        world.run(seconds + 0.5, step)
        aside = np.abs(box.position[:2]).max()
        for jaw, x in zip(jaws, (-closed, closed)):
            jaw.move_to((x, 0.0, 0.25), seconds=1.0)
        start = box.position[2]
        world.run(1.5, step)
        answers.extend([aside, box.position[2] - start], [0.0, 0.2], over, ["aside", "lifted"])
    return answers.comparison()


@check(
    section="4.2, 4.4",
    piece="softbody.collision.soft.soft_response.resolve_contacts",
    reference="statics: 2 μ N against m g",
    kind="closed form",
    because="a yes-or-no answer, 5 % or more from balance",
    faults=(
        Fault(
            "half the friction of soft bodies",
            soft_solver._answer,
            "problem.friction[k] * push_ → 0.5 * problem.friction[k] * push_",
        ),
        Fault(
            "half the friction of boxes",
            sequential_impulses._sweep,
            "load_lanes(row_[FRICTION], 0) * normal_ → 0.5 * load_lanes(row_[FRICTION], 0) * normal_",
        ),
    ),
)
def grips_hold(run: Run) -> Comparison:
    """A grip holds exactly if its friction bears the weight.

    A soft ball or cube is between jaws that press it by 5 to 25 % of its size; gravity comes in the course of a second.
    A rigid cube is between a wall and a block that is pressed on it. The friction is 0.5 to 0.95 or 1.05 to 2 times
    what it takes. So they fall by 1 mm and more, or stay.
    """
    rng, answers = run.fresh_rng(), Answers()
    for k, kind in enumerate(by_turns(run.count(6, 36, 200), "a rigid cube", "a soft ball", "a soft cube")):
        holds = bool(k // 3 % 2)
        part = rng.uniform(1.05, 2.0) if holds else rng.uniform(0.5, 0.95)
        fallen = rigid_grip(rng, part) if kind == "a rigid cube" else soft_grip(rng, part, kind == "a soft ball")
        answers.add(fallen < 1e-3, holds, kind=f"{kind} that {'stays' if holds else 'falls'}")
    return answers.comparison()


def rigid_grip(rng: np.random.Generator, part: float) -> float:
    """Return how far [m] a box falls in 0.3 s that friction bears by a part of its weight."""
    world, mass, rub = World(), 10.0 ** rng.uniform(-2.0, 1.0), rng.uniform(0.2, 1.0)
    world.add_box((0.1, 0.3, 0.3), None, (-0.05 - 0.5 * SIDE, 0.0, 0.0), friction=rub)
    world.add_box((0.3, 0.3, 0.1), None, (0.5 * SIDE + 0.2, 0.0, -0.15), friction=0.0)  # the block slides on it
    block = world.add_box((0.1, 0.2, 0.2), mass, (0.5 * SIDE + 0.05, 0.0, 0.0), friction=rub)
    block.apply_force((-0.5 * part * mass * G / rub, 0.0, 0.0))
    cube = world.add_box((SIDE,) * 3, mass, friction=rub)
    world.run(0.3, 1.0 / 240.0)
    return float(-cube.position[2])


def soft_grip(rng: np.random.Generator, part: float, is_ball: bool) -> float:
    """Return how far [m] a soft body falls between jaws whose friction bears a part of its weight."""
    mesh = rotated(softbody.icosphere(2, 0.5 * SIDE), rng) if is_ball else softbody.box((SIDE,) * 3, 3)
    world, mass = World(gravity=WEIGHTLESS), rng.uniform(0.1, 0.4)
    body = world.add_soft_body(mesh, mass, rng.uniform(2e3, 4e3), rng.uniform(0.5, 2.0), friction=0.0, drag=5.0)
    world.equilibrium()
    half, closed = body.positions[:, 0].max(), 1.0 - rng.uniform(0.05, 0.25)
    jaws = [world.add_box((0.1, 0.3, 0.3), None, (x * (half + 0.051), 0.0, 0.0), friction=0.0) for x in (-1.0, 1.0)]
    for jaw, x in zip(jaws, (-1.0, 1.0)):
        jaw.move_to((x * (closed * half + 0.05), 0.0, 0.0), seconds=0.5)
    world.run(2.5)
    points = world.contact_points()
    pressed = sum(abs(points.force_on(jaw)[0]) for jaw in jaws)
    for one in (body, *jaws):
        one.friction = part * mass * G / pressed
    start = body.centre[2]
    for k in range(20):
        world.gravity = (0.0, 0.0, -G * (k + 1) / 20.0)
        world.run(0.05)
    world.run(0.3)
    return float(start - body.centre[2])
