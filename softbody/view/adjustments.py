"""What may be changed while a world is watched, and what does that do to it?"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from softbody.bodies import SoftBody
from softbody.settings import INTEGRATORS, check_name

if TYPE_CHECKING:
    from softbody.world import World


class Slider(NamedTuple):
    """A number that may be changed between steps."""

    label: str
    least: float
    most: float
    step: float
    change: Callable[[World, World, float], None]  # (world, as it began, value)


def scale_stiffness(world: World, start: World, exponent: float) -> None:
    """Make all springs 2^exponent times as stiff as they were at the start."""
    model = start.model
    for i in range(model.soft_count):
        edges = slice(*model.soft_edge_start[i : i + 2])
        SoftBody(world, i).set_springs(stiffness=model.edge_stiffness[edges] * 2.0**exponent)


def scale_gas(world: World, start: World, exponent: float) -> None:
    """Let all bodies have 2^exponent times the gas of the start."""
    for i in range(start.model.soft_count):
        SoftBody(world, i).gas = float(start.controls.soft_gas[i]) * 2.0**exponent


def set_gravity(world: World, start: World, size: float) -> None:
    """Let gravity be `size` [m/s²], the way it was at the start, or down where there was none."""
    was = start.controls.gravity
    length = float(np.linalg.norm(was))
    down = was / length if length > 0.0 else np.array([0.0, 0.0, -1.0])
    world.controls = world.controls._replace(gravity=size * down)


def set_friction(world: World, start: World, value: float) -> None:
    """Let everything have the same coefficient of friction."""
    _set_everywhere(world, "friction", value)


def set_restitution(world: World, start: World, value: float) -> None:
    """Let everything have the same coefficient of restitution."""
    _set_everywhere(world, "restitution", value)


def _set_everywhere(world: World, what: str, value: float) -> None:
    values: dict[str, Any] = {f"{kind}_{what}": np.full(count, value) for kind, count in _counts(world).items()}
    values[f"ground_{what}"] = value
    world.model = world.model._replace(**values)


def _counts(world: World) -> dict[str, int]:
    return {"soft": world.model.soft_count, "box": world.model.box_count}


SLIDERS = {
    "stiffness": Slider("springs, × 2^", -3.0, 3.0, 0.25, scale_stiffness),
    "gas": Slider("gas, × 2^", -3.0, 3.0, 0.25, scale_gas),
    "gravity": Slider("gravity [m/s²]", 0.0, 20.0, 0.01, set_gravity),
    "friction": Slider("friction", 0.0, 1.5, 0.05, set_friction),
    "restitution": Slider("restitution", 0.0, 1.0, 0.05, set_restitution),
}


def shown_at_start(world: World) -> dict[str, float]:
    """Return what each slider shows before anybody has moved it: of what differs from body to body, the mean."""
    model, counts = world.model, sum(_counts(world).values())
    frictions = np.concatenate([model.soft_friction, model.box_friction])
    restitutions = np.concatenate([model.soft_restitution, model.box_restitution])
    return {
        "stiffness": 0.0,
        "gas": 0.0,
        "gravity": float(np.linalg.norm(world.controls.gravity)),
        "friction": float(frictions.mean()) if counts else 0.0,
        "restitution": float(restitutions.mean()) if counts else 0.0,
    }


class Adjustments:
    """What somebody has changed in a world that is watched; it can be done again after a restart."""

    def __init__(self, world: World, start: World) -> None:
        self._world = world
        self._start = start
        self._changed: dict[str, float] = {}
        self._integrator = world.integrator

    def set_slider(self, name: str, value: float) -> None:
        """Change what a slider of SLIDERS stands for, between its least and its most."""
        check_name(name, "slider", tuple(SLIDERS))
        slider = SLIDERS[name]
        self._changed[name] = min(max(float(value), slider.least), slider.most)
        slider.change(self._world, self._start, self._changed[name])

    def set_integrator(self, name: str) -> None:
        """Move soft bodies by another integrator."""
        check_name(name, "integrator", tuple(INTEGRATORS))
        self._integrator = name
        self._world.integrator = name

    def repeat(self) -> None:
        """Do all once more, in a world that is as at the start."""
        self._world.integrator = self._integrator
        for name, value in self._changed.items():
            SLIDERS[name].change(self._world, self._start, value)
