"""What claims of this room are tried on: worlds of one body, a world of everything, and the error of a call."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

import softbody
from softbody import World

BALL = softbody.icosphere(1, 0.5)

Kind = TypeVar("Kind", bound=Exception)


def error_of(kind: type[Kind], call: Callable[..., object], *given: Any, **named: Any) -> Kind | None:
    """Return the error of a kind that a call ends with, or None where it does what it is asked."""
    try:
        call(*given, **named)
    except kind as error:
        return error
    return None


def soft(**changes: Any) -> World:
    """Return a world with a soft body that is told something else than usual."""
    world = World()
    usual: dict[str, Any] = {"mesh": BALL, "mass": 1.0, "stiffness": 100.0, "gas": 10.0}
    world.add_soft_body(**usual | changes)
    return world


def rigid(**changes: Any) -> World:
    """Return a world with a box that is told something else than usual."""
    world = World()
    usual: dict[str, Any] = {"size": (1.0, 1.0, 1.0), "mass": 1.0}
    world.add_box(**usual | changes)
    return world


def rich_world(rng: np.random.Generator, precision: str = "double") -> World:
    """Return a world with everything that a user can set, some of it not as by default, in motion and in contact."""
    world = World((0.3, 0.0, -9.0), precision=precision, integrator="symplectic_euler", iterations=25, gyroscopic=True)
    world.add_ground(-0.1, restitution=0.2, friction=0.4)
    unusual: dict[str, Any] = {"damping": 0.1, "drag": 0.05, "restitution": 0.1, "deflated_below": 0.1}
    for k, shape in enumerate((softbody.icosphere(1, 0.4), softbody.torus(0.3, 0.12, 9, 7))):
        stiffness, place = rng.uniform(80.0, 120.0, len(shape.edges)), (0.1 * k, 0.0, 0.5 + 0.85 * k)
        unusual |= {"friction": 0.3 + 0.2 * k, "fixed": (3,) if k else ()}
        body = world.add_soft_body(shape, 1.0 + k, stiffness, 20.0, place, (0.5, 0.0, 0.0), **unusual)
        body.external_force = rng.normal(0.0, 0.05, body.positions.shape)
    for k in range(3):
        box = world.add_box((0.5, 0.4, 0.3), 2.0, (1.2, 0.0, 0.1 + 0.31 * k), friction=0.6, restitution=0.1)
        box.apply_force((0.1, 0.2, 0.0), box.position + (0.0, 0.1, 0.1))
    world.soft_bodies[0].gas = 22.0
    return world
