"""Adjustments of a world while it is watched: sliders and the integrator, and what each changes."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from softbody.bodies.liquid import Liquid, check_level
from softbody.bodies.rigid_box import Box, boxes_of
from softbody.bodies.soft_body import SoftBody, soft_bodies_of
from softbody.bodies.store import HasStore
from softbody.model.settings import check_name, integrator_name, with_integrator


class Slider(NamedTuple):
    """A number that may be changed between steps."""

    label: str
    least: float
    most: float
    step: float
    change: Callable[[HasStore, HasStore, float], None]  # (world, as it began, value)


def scale_stiffness(world: HasStore, start: HasStore, exponent: float) -> None:
    """Make all springs 2^exponent times as stiff as they were at the start."""
    for body, was in zip(soft_bodies_of(world), soft_bodies_of(start)):
        body.set_springs(stiffness=was.stiffness * 2.0**exponent)


def scale_gas(world: HasStore, start: HasStore, exponent: float) -> None:
    """Let all bodies have 2^exponent times the gas of the start."""
    for body, was in zip(soft_bodies_of(world), soft_bodies_of(start)):
        body.gas = was.gas * 2.0**exponent


def set_gravity(world: HasStore, start: HasStore, size: float) -> None:
    """Let gravity be `size` [m/s²], the way it was at the start, or down where there was none."""
    was = start.store.controls.gravity
    length = float(np.linalg.norm(was))
    down = was / length if length > 0.0 else np.array([0.0, 0.0, -1.0])
    if Liquid(world).is_there:
        check_level(size * down)
    world.store.controls.gravity[:] = size * down


def set_friction(world: HasStore, start: HasStore, value: float) -> None:
    """Let everything have the same coefficient of friction."""
    for body in _all(world):
        body.friction = value
    world.store.replace(model=world.store.model._replace(ground_friction=value))


def set_restitution(world: HasStore, start: HasStore, value: float) -> None:
    """Let everything have the same coefficient of restitution."""
    for body in _all(world):
        body.restitution = value
    world.store.replace(model=world.store.model._replace(ground_restitution=value))


def set_self_contact(world: HasStore, start: HasStore, value: float) -> None:
    """Let all soft bodies hold themselves, or none; at the distance they had at the start, if they had one."""
    if world.store.settings.single_soft_contact:
        return  # the paper's contacts are those of different bodies
    for body, was in zip(soft_bodies_of(world), soft_bodies_of(start)):
        if body.tear_at.any() or body.is_torn:
            continue  # what may tear does not hold itself
        body.self_contact = (was.self_contact or True) if value > 0.0 else False


def scale_density(world: HasStore, start: HasStore, exponent: float) -> None:
    """Let all liquids, around bodies and in them, be 2^exponent times as dense as they were at the start."""
    for body, was in zip(soft_bodies_of(world), soft_bodies_of(start)):
        body.liquid_density = was.liquid_density * 2.0**exponent
    if Liquid(world).is_there:
        Liquid(world).density = Liquid(start).density * 2.0**exponent


def set_substeps(world: HasStore, start: HasStore, value: float) -> None:
    """Let contacts be found and resolved once for so many steps of springs and gas."""
    world.store.settings = world.store.settings._replace(substeps=round(value))


def _all(world: HasStore) -> list[SoftBody | Box]:
    return [*soft_bodies_of(world), *boxes_of(world)]


SLIDERS = {
    "stiffness": Slider("springs, × 2^", -3.0, 3.0, 0.25, scale_stiffness),
    "gas": Slider("gas, × 2^", -3.0, 3.0, 0.25, scale_gas),
    "gravity": Slider("gravity [m/s²]", 0.0, 20.0, 0.01, set_gravity),
    "friction": Slider("friction", 0.0, 1.5, 0.05, set_friction),
    "restitution": Slider("restitution", 0.0, 1.0, 0.05, set_restitution),
    "self_contact": Slider("bodies go through themselves: 0, or not: 1", 0.0, 1.0, 1.0, set_self_contact),
    "density": Slider("liquids, × 2^", -3.0, 3.0, 0.25, scale_density),
    "substeps": Slider("steps of springs to one of contacts", 1.0, 8.0, 1.0, set_substeps),
}


def shown_at_start(world: HasStore) -> dict[str, float]:
    """Return what each slider shows before anybody has moved it: of what differs from body to body, the mean."""
    bodies = _all(world)
    return {
        "stiffness": 0.0,
        "gas": 0.0,
        "gravity": float(np.linalg.norm(world.store.controls.gravity)),
        "friction": float(np.mean([body.friction for body in bodies])) if bodies else 0.0,
        "restitution": float(np.mean([body.restitution for body in bodies])) if bodies else 0.0,
        "self_contact": float(any(body.self_contact for body in soft_bodies_of(world))),
        "density": 0.0,
        "substeps": float(world.store.settings.substeps),
    }


class Adjustments:
    """What somebody has changed in a world that is watched; it can be done again after a restart."""

    def __init__(self, world: HasStore, start: HasStore) -> None:
        self._world = world
        self._start = start
        self._changed: dict[str, float] = {}
        self._integrator = integrator_name(world.store.settings)

    def set_slider(self, name: str, value: float) -> None:
        """Change what a slider of SLIDERS stands for, between its least and its most."""
        check_name(name, "slider", tuple(SLIDERS))
        slider = SLIDERS[name]
        value = min(max(float(value), slider.least), slider.most)
        slider.change(self._world, self._start, value)
        self._changed[name] = value  # what is refused is not repeated

    def set_integrator(self, name: str) -> None:
        """Move soft bodies by another integrator; their damping stays."""
        self._world.store.settings = with_integrator(self._world.store.settings, name)
        self._integrator = name

    def repeat(self) -> None:
        """Do all once more, in a world that is as at the start."""
        self.set_integrator(self._integrator)
        for name, value in self._changed.items():
            SLIDERS[name].change(self._world, self._start, value)
