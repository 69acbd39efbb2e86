"""What is set between steps, and how time is cut into them."""

from __future__ import annotations

from typing import Any

import numpy as np

from softbody import ParameterError, SoftBody, World, icosphere
from softbody.bodies.body import set_row
from softbody.stepping import finite_check, frames, runner
from softbody.stepping.checks import StableStep
from softbody.stepping.time_steps import whole_steps, whole_steps_owed
from softbody.storage.restore import restore
from validation.answers import Answers
from validation.check import Comparison, Run, check
from validation.checks.contract.cases import error_of
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

NUMBERS = {
    "damping": 0.5,
    "drag": 2.0,
    "restitution": 1.0,
    "friction": 1.5,
    "liquid_density": 3.0,
    "sound_speed": 20.0,
    "liquid_drag": 50.0,
    "leak": 400.0,
}  # of soft bodies, and up to where


@check(
    section="2, 5.4",
    piece="softbody.SoftBody, softbody.Box, softbody.World.gravity",
    reference="a world whose bodies were added with those numbers, by the same version",
    kind="the core in another form",
    because="the same bits",
    faults=(
        Fault(
            "the first body's number set", set_row, "body.row() if rows is None else rows → 0 if rows is None else rows"
        ),
        Fault("a number that is only read again", set_row, "store.replace(model=m_) → None"),
        Fault(
            "particles that stay pinned",
            SoftBody._pin,
            "model.particle_free_inverse_mass[rows].copy() → 0.0 * self.masses",
        ),
        Fault("velocities of what is pinned", SoftBody._pin, "self.velocities[still] = 0.0 → "),
    ),
)
def set_as_if_made_so(run: Run) -> Comparison:
    """A world set before its first step is as if made so.

    Gravity, gas, damping, drag, restitution, friction, liquid, pins, springs, positions and velocities. Bodies that
    meet have the bits of a world that was made with them.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(4, 12, 60)):
        ball, gravity = icosphere(1, 0.5), rng.normal(0.0, 5.0, 3)
        later, made = World(), World(gravity=gravity)
        for world in (later, made):
            world.add_ground(-0.2, restitution=0.5)
        for k in range(3):
            numbers: dict[str, Any] = {name: float(most * rng.random()) for name, most in NUMBERS.items()}
            place, speed = np.array([0.7 * k, 0.0, 0.7 * k]), rng.normal(size=3)
            stiffness, gas = rng.uniform(50.0, 300.0), rng.uniform(5.0, 30.0)
            pins = rng.choice(len(ball.vertices), int(rng.integers(0, 3)), replace=False)
            tear_at = rng.choice([0.0, rng.uniform(1.2, 2.0)])
            numbers["liquid_density"] *= tear_at == 0.0  # what tears holds none
            made.add_soft_body(ball, 1.0, stiffness, gas, place, speed, tear_at=tear_at, fixed=pins, **numbers)
            body = later.add_soft_body(ball, 1.0, 100.0, 1.0, place, fixed=rng.choice(len(ball.vertices), 2, False))
            box: dict[str, Any] = {name: numbers[name] for name in ("restitution", "friction")}
            made.add_box((0.4, 0.3, 0.2), 1.0, place + (0.0, 0.75, 0.0), velocity=speed, **box)
            other = later.add_box((0.4, 0.3, 0.2), 1.0)
            for one, values in ((body, numbers), (other, box)):
                for name, value in values.items():
                    setattr(one, name, value)
            body.fixed = ()
            body.velocities = speed
            body.fixed, body.gas = pins, gas
            body.set_springs(stiffness, tear_at=tear_at)
            other.position, other.velocity = place + (0.0, 0.75, 0.0), speed
        later.gravity = gravity
        step = 0.3 * made.stable_time_step()
        for world in (later, made):
            world.step(step, 100)
        agree = (_bits(later) == _bits(made)).all(axis=1)
        answers.extend(agree, np.ones(len(agree), bool))
    return answers.comparison()


def _bits(world: World) -> np.ndarray:
    """Return the bits of the motion of all particles and boxes, a row each."""
    state = world.state
    soft = np.hstack([state.particle_position, state.particle_velocity])
    boxes = np.hstack([state.box_position, state.box_velocity])
    return np.concatenate([soft, boxes]).view(np.uint64)


@check(
    section="5.1",
    piece="softbody.World.run, softbody.World.step_frame, softbody.World.frames",
    reference="closed form: a box that falls for as long, by semi-implicit steps: v = g t, z = g t (t + h) / 2",
    kind="closed form",
    unit="of the way",
    tolerance=3e-13,
    because="rounding of sums over up to 4 000 steps: 1.2e-14 at worst of four seeds",
    faults=(
        Fault("a stretch rounded to steps", whole_steps, "count = ceil(seconds / time_step) → return count, time_step"),
        Fault("a remainder that is lost", whole_steps_owed, "owed += seconds → owed = seconds"),
        Fault("a remainder that is not paid", whole_steps_owed, "owed - count * time_step → owed"),
        Fault("time that is owed by who was restored", restore, '(store, "owed", 0.0) → (store, "owed", store.owed)'),
        Fault("frames all as long", frames.frames, "seconds - (count - 1) * frame → frame"),
    ),
)
def time_is_kept(run: Run) -> Comparison:
    """Time is kept, however it is cut.

    `run` and frames of any length end when they were asked to, in steps no longer than allowed. Frames of a step of
    one's own leave less than a step, and are whole steps, as many as were asked for.
    """
    rng, answers = run.fresh_rng(), Answers()
    for _ in range(run.count(10, 40, 400)):
        h = rng.uniform(2e-3, 4e-3)
        frames = rng.uniform(0.0, 0.1, int(rng.integers(5, 40)))
        seconds = float(frames.sum())
        for kind in ("run", "frames", "frames of steps"):
            world = World()
            box = world.add_box((0.1, 0.1, 0.1), 1.0)
            ticks = 0.0  # Σ of steps squared: what semi-implicit Euler falls farther
            for frame in [seconds] if kind == "run" else frames:
                before, at = world.steps, world.time
                if kind == "run":
                    world.run(frame, h)
                elif kind == "frames":
                    for _ in world.frames(frame, per_second=rng.uniform(20.0, 200.0)):
                        ticks += (world.time - at) ** 2 / max(1, world.steps - before)
                        before, at = world.steps, world.time
                else:
                    world.step_frame(frame, h)
                ticks += (world.time - at) ** 2 / max(1, world.steps - before)
            fallen = seconds - seconds % h if kind == "frames of steps" else seconds
            rule = [fallen, -9.81 * fallen, -0.5 * 9.81 * (fallen**2 + ticks)]
            answers.add([world.time, box.velocity[2], box.position[2]], rule, 9.81 * seconds**2, kind)
        for is_restored in (False, True):  # what a frame owes is owed by the world that made it
            world = World()
            world.step_frame(0.6 * h, h)
            if is_restored:
                world.restore(world.snapshot())
            answers.add([world.step_frame(0.6 * h, h), world.steps, 0.0], [not is_restored] * 2 + [0.0], kind="owed")
        world, whole = World(), rng.integers(0, 20, 30)
        world.add_box((0.1, 0.1, 0.1), 1.0)
        for steps, end in zip(whole, whole.cumsum()):
            told = [world.step_frame(steps * h, h), world.steps, 0.0]
            answers.add(told, [steps, end, 0.0], kind="frames of whole steps")
    return answers.comparison()


@check(
    section="5.1",
    piece="softbody.World.step",
    reference="the same steps by one call, by the same version",
    kind="the core in another form",
    because="the same bits, or others",
    faults=(
        Fault(
            "a stable step that is estimated before each call",
            runner.Runner.step,
            "allow_unstable or self._stable_step.allows(h, model, controls, settings, joints, begun[0])"
            " → allow_unstable",
        ),
        Fault("an estimate for ten steps", StableStep.allows, "self._made_at + STABLE_FOR → self._made_at + 10"),
        Fault("nothing that is finite", finite_check.is_finite, "not abs(x_) < np.inf → abs(x_) < np.inf"),
        Fault("an estimate of another model", StableStep.allows, "self._model is model → self._model is not model"),
    ),
)
def calls_of_any_length(run: Run) -> Comparison:
    """Steps asked for at once or one by one are the same.

    A hundred of them, also some at a time, to the bit, and none is refused: also where a body is pressed together
    meanwhile. Then the stable step becomes shorter than those that it makes, which is looked at anew after a hundred.
    """
    rng, answers = run.fresh_rng(), Answers()
    while len(answers) < 3 * run.count(2, 6, 40):
        worlds = []
        speed, gas, sides = rng.uniform(2.0, 6.0), rng.uniform(100.0, 300.0), int(rng.integers(1, 3))
        for _ in range(4):
            world = World(gravity=(0.0, 0.0, 0.0))
            body = world.add_soft_body(icosphere(sides, 0.5), 1.0, 10.0, gas, damping=0.0)
            world.equilibrium()
            body.velocities = -speed * body.positions / 0.5
            worlds.append(world)
        h = 0.97 * worlds[0].stable_time_step()
        worlds[0].step(h)  # so that the estimate is made, and shortest when it is trusted
        shortest = h
        for _ in range(99):
            worlds[0].step(h, allow_unstable=True)
            shortest = np.minimum(shortest, worlds[0].stable_time_step())
        if shortest > 0.9 * h:
            continue  # it was not pressed together enough
        cuts = {"at once": [100], "one by one": [1] * 100, "some at a time": rng.integers(2, 20, 100).tolist()}
        for world, (kind, lengths) in zip(worlds[1:], cuts.items()):
            ends = np.minimum(np.cumsum(lengths), 100)  # the last calls may have none left
            parts = np.diff(ends, prepend=0).tolist()
            is_refused = any([error_of(ParameterError, world.step, h, steps) for steps in parts if steps])
            answers.add(not is_refused and (_bits(world) == _bits(worlds[0])).all(), True, kind=kind)
    return answers.comparison()
