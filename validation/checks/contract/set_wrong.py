"""Claims that what is set wrongly on the way is refused before the next step, whoever it is about."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from softbody import ParameterError, World, icosphere
from softbody.stepping import checks
from validation.answers import Answers
from validation.check import Comparison, Run, check
from validation.checks.contract.cases import error_of
from validation.checks.worlds.cases import WEIGHTLESS
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

STEP = 1e-3
ARRAYS = {  # that users may write into, by what they are on
    "soft body": ("positions", "velocities", "external_force"),
    "box": ("position", "orientation", "velocity", "angular_velocity"),
    "joint": ("target",),
}


def filled(rng: np.random.Generator) -> World:
    """Return a world of some bodies and joints, far from each other, that has made some steps."""
    world = World(WEIGHTLESS)
    for k in range(3):
        ball = icosphere(int(rng.integers(2)), 0.5)
        body = world.add_soft_body(ball, 1.0, 100.0, 10.0, (9.0 * k, 0.0, 0.0))
        body.external_force = 0.01 * rng.normal(size=ball.vertices.shape)
        box = world.add_box((0.5, 0.4, 0.3), 1.0, (9.0 * k, 9.0, 0.0))
        world.add_joint((box, box.position), box.position + [0.0, 1.0, 0.0], 1.0)
    world.step(STEP, int(rng.integers(1, 5)))
    return world


@check(
    section="beyond the paper",
    piece="softbody.World.step, softbody.errors",
    reference="the documentation; where the claim has written what",
    kind="specification",
    faults=(
        Fault("particles counted over all bodies", checks.check_finite, "row - first[body] → row"),
        Fault(
            "the body before",
            checks.check_finite,
            "x_.searchsorted(first, row, side='right') → x_.searchsorted(first, row, side='left')",
        ),
        Fault("sums that hide two infinities", checks.check_finite, "not isfinite(s_) → s_ != s_"),
    ),
)
def what_is_no_number_is_named(run: Run) -> Comparison:
    """What is written into a world and is no number is named.

    NaN or an infinity in any array of any body or joint, anywhere in it: the next step, or run, does not happen, and
    the error names array, body and particle. Set to what it was, the world goes on as if nothing had been.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(3, 10, 80)):
        for kind, names in ARRAYS.items():
            for name in names:
                world = filled(rng)
                things: dict[str, Any] = {"soft body": world.soft_bodies, "box": world.boxes, "joint": world.joints}
                thing = things[kind][rng.integers(3)]
                array = getattr(thing, name)
                at = tuple(int(rng.integers(n)) for n in array.shape)
                before, was, steps = world.state_hash(), float(array[at]), world.steps
                array[at] = rng.choice([np.nan, np.inf, -np.inf])
                call: Callable[..., object] = (world.step, world.run)[rng.integers(2)]
                text = str(error_of(ParameterError, call, STEP))
                who = (
                    f" of particle {at[0]} of {kind} {thing.index} "
                    if array.ndim == 2
                    else f" of {kind} {thing.index} "
                )
                array[at] = was
                is_so = text.startswith(name.removesuffix("s")) or text.startswith(name.replace("ies", "y"))
                answers.add([who in text, is_so], [True, True], kind=f"{kind}: {name}")
                is_kept = world.steps == steps and world.state_hash() == before
                world.step(STEP)
                answers.add([is_kept, world.steps == steps + 1], [True, True], kind=f"{kind}: {name}, set right")
    return answers.comparison()


def _stiffer(world: World, by: float) -> None:
    body = world.soft_bodies[1]
    body.set_springs(stiffness=by * body.stiffness)


def _set(what: str, name: str, number: int = 1) -> Callable[[World, float], None]:
    """Return what makes a number of a body or joint so many times as large."""

    def act(world: World, by: float) -> None:
        thing = getattr(world, what)[number]
        setattr(thing, name, by * getattr(thing, name))

    return act


SHORTER: dict[str, Callable[[World, float], None]] = {  # what can make the longest stable step shorter, or longer
    "gas": _set("soft_bodies", "gas"),
    "springs": _stiffer,
    "damping": _set("soft_bodies", "damping", 2),
    "drag": lambda world, by: setattr(world.soft_bodies[1], "drag", 40.0 * by),
    "a joint's stiffness": _set("joints", "stiffness"),
    "a joint's damping": lambda world, by: setattr(world.joints[2], "damping", 2.0 * by),
    "a body's size": lambda world, by: _shrink(world, by),
    "a liquid": lambda world, by: _flood(world, by),
    "substeps": lambda world, by: setattr(world, "substeps", 1 if by > 1.0 else 400),
    "integrator": lambda world, by: setattr(world, "integrator", "symplectic_euler" if by > 1.0 else "rk4_velocity"),
}


def _shrink(world: World, by: float) -> None:
    body = world.soft_bodies[1]
    body.positions = body.centre + (body.positions - body.centre) * by**-0.3


def _flood(world: World, by: float) -> None:
    world.gravity = (0.0, 0.0, -9.81)
    world.add_liquid(100.0 * by, 100.0, drag=100.0 * by)


@check(
    section="5.1",
    piece="softbody.World.step, softbody.World.stable_time_step",
    reference="a world that is restored from a snapshot, and has trusted no estimate, by the same version",
    kind="the core in another form",
    because="yes or no",
    faults=(
        Fault("gas that is not looked at", checks.StableStep.allows, "self._acting == _acting(m_, c_) → True"),
        Fault("a model that is not looked at", checks.StableStep.allows, "self._model is model → True"),
        Fault("joints that are not looked at", checks.StableStep.allows, "self._joints is joints → True"),
        Fault(
            "an integrator that is not looked at",
            checks.StableStep.allows,
            "self._integrator == settings.integrator → True",
        ),
    ),
)
def steps_that_have_become_too_long(run: Run) -> Comparison:
    """A step is refused once something set makes it too long.

    Of what a stable step depends on, each is set on the way, a little or much, up or down, after steps that were
    allowed. The next step, from far too short to far too long, is refused if and only if a world that was made just now
    refuses it.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(2, 8, 60)):
        for what, change in SHORTER.items():
            for by in (100.0, 0.01):
                world, fresh = filled(rng), World()
                world.integrator = "rk4"
                world.step(0.9 * world.stable_time_step(), 3)
                before = world.stable_time_step()
                change(world, by * rng.uniform(0.5, 1.5))
                fresh.restore(world.snapshot())
                longest = fresh.stable_time_step()
                for step in (0.99 * before, 0.99 * longest, 1.01 * longest, np.sqrt(before * longest)):
                    state = world.snapshot()
                    is_refused = error_of(ParameterError, world.step, step) is not None
                    answers.add(is_refused, bool(step > longest), kind=what)
                    world.restore(state)
    return answers.comparison()
