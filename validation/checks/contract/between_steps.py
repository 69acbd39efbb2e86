"""What is set between steps, and how time is cut into them."""

from __future__ import annotations

from typing import Any

import numpy as np

from softbody import ParameterError, World, icosphere
from softbody.bodies import body as bodies
from softbody.bodies import soft_body
from softbody.stepping import checks, finite_check, frames, runner, time_steps
from validation.check import Comparison, Run, check
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

NUMBERS = {"damping": 0.5, "drag": 2.0, "restitution": 1.0, "friction": 1.5}  # of soft bodies, and up to where


@check(
    section="2, 5.4",
    piece="softbody.SoftBody, softbody.Box, softbody.World.gravity",
    reference="a world whose bodies were added with those numbers, by the same version",
    kind="the core in another form",
    because="the same bits",
    faults=(
        Fault(
            "the first body's number set",
            bodies.set_row,
            "body.row() if rows is None else rows → 0 if rows is None else rows",
        ),
        Fault("a number that is only read again", bodies.set_row, "store.replace(model=m_) → None"),
        Fault(
            "particles that stay pinned",
            soft_body.SoftBody._pin,
            "self.store.model.particle_inverse_mass[rows].max() → self.store.model.particle_inverse_mass[rows].min()",
        ),
        Fault("velocities of what is pinned", soft_body.SoftBody._pin, "self.velocities[still] = 0.0 → "),
    ),
)
def set_as_if_made_so(run: Run) -> Comparison:
    """Gravity, gas, damping, drag, restitution, friction, pins, springs, positions and velocities that are set before
    the first step, on bodies that meet, give the bits of a world that was made with them."""
    rng = run.fresh_rng()
    later, made = [], []
    for _ in range(run.count(4, 12, 60)):
        ball, count = icosphere(1, 0.5), 3
        gravity = rng.normal(0.0, 5.0, 3)
        worlds = World(), World(gravity=gravity)
        for world in worlds:
            world.add_ground(-0.2, restitution=0.5)
        for k in range(count):
            numbers: dict[str, Any] = {name: float(most * rng.random()) for name, most in NUMBERS.items()}
            place, speed = np.array([0.7 * k, 0.0, 0.7 * k]), rng.normal(size=3)
            stiffness, gas = rng.uniform(50.0, 300.0), rng.uniform(5.0, 30.0)
            pins = rng.choice(len(ball.vertices), int(rng.integers(0, 3)), replace=False)
            worlds[1].add_soft_body(ball, 1.0, stiffness, gas, place, speed, fixed=pins, **numbers)
            body = worlds[0].add_soft_body(ball, 1.0, 100.0, 1.0, place, fixed=rng.choice(len(ball.vertices), 2, False))
            box: dict[str, Any] = {name: numbers[name] for name in ("restitution", "friction")}
            worlds[1].add_box((0.4, 0.3, 0.2), 1.0, place + (0.0, 0.75, 0.0), velocity=speed, **box)
            other = worlds[0].add_box((0.4, 0.3, 0.2), 1.0)
            for name, value in numbers.items():
                setattr(body, name, value)
            for name, value in box.items():
                setattr(other, name, value)
            body.fixed = ()
            body.velocities = speed
            body.fixed, body.gas = pins, gas
            body.set_springs(stiffness)
            other.position, other.velocity = place + (0.0, 0.75, 0.0), speed
        worlds[0].gravity = gravity
        step = 0.3 * worlds[1].stable_time_step()
        for world in worlds:
            world.step(step, 100)
        later.append(_bits(worlds[0]))
        made.append(_bits(worlds[1]))
    agree = np.concatenate([(one == other).all(axis=1) for one, other in zip(later, made)])
    return Comparison(agree, np.ones(len(agree), bool))


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
        Fault(
            "a stretch rounded to steps",
            time_steps.whole_steps,
            "count = ceil(seconds / time_step) → return count, time_step",
        ),
        Fault("a remainder that is lost", time_steps.whole_steps_owed, "owed += seconds → owed = seconds"),
        Fault("a remainder that is not paid", time_steps.whole_steps_owed, "owed - count * time_step → owed"),
        Fault("frames all as long", frames.frames, "seconds - (count - 1) * frame → frame"),
    ),
)
def time_is_kept(run: Run) -> Comparison:
    """However time is cut, it is kept: `run` and frames of any length end when they were asked to, in steps no longer
    than allowed; frames of a step of one's own leave less than a step, and are whole steps, as many as were asked for.
    """
    rng = run.fresh_rng()
    measured, expected, scales, kinds = [], [], [], []
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
            measured.append([world.time, box.velocity[2], box.position[2]])
            expected.append([fallen, -9.81 * fallen, -0.5 * 9.81 * (fallen**2 + ticks)])
            scales.append(9.81 * seconds**2)
            kinds.append(kind)
        world, whole = World(), rng.integers(0, 20, 30)
        world.add_box((0.1, 0.1, 0.1), 1.0)
        measured += [[world.step_frame(steps * h, h), world.steps, 0.0] for steps in whole]
        expected += [[steps, end, 0.0] for steps, end in zip(whole, whole.cumsum())]
        scales += [1.0] * len(whole)
        kinds += ["frames of whole steps"] * len(whole)
    return Comparison(np.array(measured), np.array(expected), np.array(scales), kinds)


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
        Fault("an estimate for ten steps", checks.StableStep.allows, "self._made_at + STABLE_FOR → self._made_at + 10"),
        Fault("nothing that is finite", finite_check.is_finite, "not abs(x_) < np.inf → abs(x_) < np.inf"),
        Fault(
            "an estimate of another model", checks.StableStep.allows, "self._model is model → self._model is not model"
        ),
    ),
)
def calls_of_any_length(run: Run) -> Comparison:
    """A hundred steps asked for at once, one by one, or some at a time are the same to the bit, and none is refused:
    also where a body is pressed together meanwhile, so that the step that is stable becomes shorter than those that it
    makes, which is looked at anew after a hundred."""
    rng, kinds = run.fresh_rng(), []
    same: list[bool] = []
    while len(same) < 3 * run.count(2, 6, 40):
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
        cuts: list[list[int]] = [[100], [1] * 100, rng.integers(2, 20, 100).tolist()]
        for world, lengths in zip(worlds[1:], cuts):
            left, refused = 100, False
            for length in lengths:
                if left == 0:
                    break
                try:
                    world.step(h, min(length, left))
                except ParameterError:
                    refused = True
                left -= min(length, left)
            same.append(not refused and (_bits(world) == _bits(worlds[0])).all())
            kinds.append(
                "at once" if len(lengths) == 1 else "one by one" if len(set(lengths)) == 1 else "some at a time"
            )
    return Comparison(np.array(same), np.ones(len(same), bool), groups=kinds)
