"""Claims that what may be moved in the viewer changes what it says, from how the world began."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from softbody import SoftBody, World, icosphere
from softbody.view import adjustments
from softbody.view.adjustments import SLIDERS
from softbody.view.session import Session
from validation.answers import Answers
from validation.cases import independent
from validation.check import Comparison, Run, check
from validation.checks.contract.cases import error_of
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

Told = dict[str, Any]
SPRINGS = {"stiffness", "rest_length", "tear_at"}  # that are told, and that `set_springs` sets


def told(world: World) -> Told:
    """Return all that may be set, as a world tells it, but for where bodies are."""
    rows: Told = {"gravity": world.gravity.copy(), "substeps": world.substeps, "integrator": world.integrator}
    rows |= {f"ground: {name}": getattr(world.ground, name) for name in independent(type(world.ground))}
    for thing in (*world.soft_bodies, *world.boxes):
        names = independent(type(thing)) - {"positions", "velocities", "position", "orientation", "velocity"}
        names = names - {"angular_velocity"} | (SPRINGS if isinstance(thing, SoftBody) else set())
        rows |= {f"{thing.kind} {thing.index}: {name}": np.copy(getattr(thing, name)) for name in names}
    return rows


def _times(name: str) -> Callable[[Told, float], Told]:
    """Return what makes a number of all soft bodies 2^value times as large."""
    return lambda was, value: {key: was[key] * 2.0**value for key in was if key.endswith(f": {name}")}


def _all(name: str) -> Callable[[Told, float], Told]:
    """Return what gives a number to all that have one of that name."""
    return lambda was, value: {key: value for key in was if key.endswith(f": {name}")}


CHANGES: dict[str, Callable[[Told, float], Told]] = {  # what a slider says that it changes
    "stiffness": _times("stiffness"),
    "gas": _times("gas"),
    "gravity": lambda was, value: {"gravity": was["gravity"] * value / np.linalg.norm(was["gravity"])},
    "friction": _all("friction"),
    "restitution": _all("restitution"),
    "self_contact": lambda was, value: {},  # by the mesh: whether there is any is asked apart
    "density": _times("liquid_density"),
    "substeps": lambda was, value: {"substeps": round(value)},
}


def scene(rng: np.random.Generator) -> World:
    """Return a world of bodies that are each of their own, with gravity that is aslant."""
    world = World(rng.normal(0.0, 5.0, 3))
    world.add_ground(-50.0, rng.random(), rng.random())
    for k in range(2):
        ball = icosphere(1, rng.uniform(0.3, 0.5))
        numbers: dict[str, Any] = {"restitution": rng.random(), "friction": rng.random(), "drag": rng.random()}
        numbers["liquid_density"] = 2.0 * k
        stiffness = rng.uniform(5e3, 1e4, len(ball.edges))  # so that a step depends on it
        world.add_soft_body(ball, 1.0, stiffness, rng.uniform(5.0, 9.0), (5.0 * k, 0.0, 0.0), **numbers)
        world.add_box((0.5, 0.4, 0.3), 1.0, (5.0 * k, 5.0, 0.0), friction=rng.random(), restitution=rng.random())
    return world


@check(
    section="beyond the paper",
    piece="softbody.World.view",
    reference="the documentation; what was told before, changed as the slider says",
    kind="specification",
    because="yes or no; numbers to 1e-12",
    faults=(
        Fault(
            "gravity that is turned straight down",
            adjustments.set_gravity,
            "was / length if length > 0.0 else np.array([0.0, 0.0, -1.0]) → np.array([0.0, 0.0, -1.0])",
        ),
        Fault("springs stiffer each time", adjustments.scale_stiffness, "was.stiffness → body.stiffness"),
        Fault("gas that grows each time", adjustments.scale_gas, "was.gas → body.gas"),
        Fault(
            "ice under all",
            adjustments.set_friction,
            "world.store.model._replace(ground_friction=value) → world.store.model",
        ),
        Fault("boxes that bounce as before", adjustments.set_restitution, "_all(world) → soft_bodies_of(world)"),
        Fault("sliders beyond their ends", adjustments.Adjustments.set_slider, "min(max(f_, l_), m_) → float(value)"),
        Fault("a restart that forgets", Session.restart, "self.adjustments.repeat() → "),
        Fault("a time step of before", Session.set_integrator, "self._time_step = None → "),
        Fault("a time step of before the slider", Session.set_slider, "self._time_step = None → "),
    ),
)
def sliders_change_what_they_say(run: Run) -> Comparison:
    """Each slider of the viewer changes what it says.

    From how the world began, whatever else was moved before, between its ends; and nothing else. The next step is one
    that is stable then. A restart is of the world as it began, with all that was changed.
    """
    rng, answers = run.fresh_rng(), Answers()
    answers.add([CHANGES.keys() == SLIDERS.keys(), True], [True, True], kind="all sliders there are")
    for _ in range(run.count(2, 8, 60)):
        world = scene(rng)
        begun, session = world.state_hash(), Session(world)
        was = now = told(world)
        session.step_once()
        for name in rng.permutation(np.repeat(list(CHANGES), 2)).tolist():
            slider = SLIDERS[name]
            width = slider.most - slider.least
            value = float(rng.uniform(slider.least - 0.3 * width, slider.most + 0.3 * width))
            value = float(round(rng.random())) if name == "self_contact" else value
            answers.add([error_of(Exception, session.set_slider, name, value) is None, True], [True, True], kind=name)
            now = now | CHANGES[name](was, min(max(value, slider.least), slider.most))
            _compare(answers, world, now, f"slider {name}")
            if name == "self_contact":
                answers.add([body.self_contact > 0.0 for body in world.soft_bodies], [value > 0.0] * 2, kind="skins")
            _step(answers, session, f"slider {name}")
        for integrator in ("rk4", "symplectic_euler"):
            session.set_integrator(integrator)
            now = now | {"integrator": integrator}
            _step(answers, session, integrator)
        error = error_of(Exception, session.restart)
        _compare(answers, world, now, "restart")
        answers.add([error is None, world.state_hash() == begun], [True, True], kind="restart")
    return answers.comparison()


def _compare(answers: Answers, world: World, judged: Told, kind: str) -> None:
    """Compare all that is told, but for whether skins hold."""
    found = told(world)
    wrong = [key for key in judged if not key.endswith("self_contact") and not _same(found[key], judged[key])]
    answers.add([found.keys() == judged.keys(), not wrong], [True, True], kind=kind)


def _same(a: Any, b: Any) -> bool:
    if np.asarray(b).dtype.kind in "fi":
        return bool(np.allclose(a, b, rtol=1e-12, atol=1e-12))
    return bool(np.array_equal(a, b))


def _step(answers: Answers, session: Session, kind: str) -> None:
    """Make a step, which is to be stable as all is now, and nearly as long as that allows."""
    longest = session.world.runner.stable_time_step()
    answers.add([error_of(Exception, session.step_once) is None, True], [True, True], kind=f"{kind}, a step")
    step = session.world.store.time_step
    answers.add([step <= longest, step >= min(0.7 * longest, 1.0 / 240.0)], [True, True], kind=f"{kind}, a step")
