"""Bodies with more gas than their springs hold without stretching far: told before the first step with so much.

A body grows evenly, s times as large, until its springs balance the gas: Σ k (s l − l0) l = 3 (P(s) − P_outside) V s².
That is its equilibrium where symmetry keeps the shape, as in regular polyhedra, and an estimate elsewhere.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.bodies.names import Names
from softbody.bodies.tearing import has_torn
from softbody.dynamics.pressure import gas_pressure, soft_volume
from softbody.errors import InflationWarning, warn_user
from softbody.geometry.edges import lengths_of
from softbody.model.arrays import Controls, Model

MOST = 0.3  # strain of springs, as a mean that is weighted by stiffness × length, up to which nothing is said
LARGEST = 1e6  # strain that is told


class Balloon(NamedTuple):
    """A soft body as it would be at other sizes: all functions take how many times as large it is."""

    stretched: np.float64  # Σ k l² [J]
    at_rest: np.float64  # Σ k l0 l [J]
    gas: np.float64  # [J]
    volume: np.float64  # [m³]
    boxes: np.float64  # [m³] of boxes inside
    outside: np.float64  # [Pa] of the liquid around its middle

    def size(self, strain: float) -> float:
        """Return how many times as large it is when its springs have this mean strain."""
        return (1.0 + strain) * self.at_rest / self.stretched

    def room(self, size: float) -> float:
        """Return the room [m³] for gas."""
        return self.volume * size**3 - self.boxes

    def held(self, size: float) -> float:
        """Return the pressure [Pa] that springs, and what is around, hold."""
        return self._of_springs(size) + self.outside

    def firmer(self, size: float) -> float:
        """Return how many times the stiffness would hold its gas."""
        return (gas_pressure(self.gas, self.room(size)) - self.outside) / self._of_springs(size)

    def _of_springs(self, size: float) -> float:
        return (size * self.stretched - self.at_rest) / (3.0 * self.volume * size**2)

    def goes_beyond(self, size: float) -> bool:
        """Tell whether its gas stretches it to more than this size."""
        return bool(self.gas > self.held(size) * self.room(size))

    def strain(self) -> float:
        """Return the mean strain of its springs when they balance the gas, to a thousandth."""
        low, high = MOST, 2.0 * MOST
        while high < LARGEST and self.goes_beyond(self.size(high)):
            low, high = high, 2.0 * high
        while high - low > 1e-3 * high:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.goes_beyond(self.size(middle)) else (low, middle)
        return high


class Inflation:
    """Tells which bodies are going to be stretched far by their gas: each once."""

    def __init__(self) -> None:
        self._known: tuple[Model | None, bytes] = None, b""
        self._told = set[int]()

    def look(self, model: Model, controls: Controls, position: np.ndarray, names: Names) -> None:
        """Warn of bodies that their gas will stretch by more than MOST, and has not yet, if gas or model is new.

        Not of those that have torn, or are full of liquid.
        """
        gas = controls.soft_gas.tobytes()
        if self._known[0] is model and self._known[1] == gas:
            return
        if self._known[0] is None or self._known[0].soft_count != model.soft_count:
            self._told.clear()
        self._known = model, gas
        may = (controls.soft_gas > 0.0) & (model.soft_liquid_density == 0.0) & ~has_torn(model)
        for body in set(np.flatnonzero(may).tolist()) - self._told:
            with np.errstate(all="ignore"):
                balloon = _balloon(model, controls, position, body)
                most = balloon.size(MOST)
                goes = most > 1.0 and balloon.goes_beyond(most)
            if goes:
                self._told.add(body)
                _warn(balloon, most, names.title(("soft", body)))


def _balloon(model: Model, controls: Controls, position: np.ndarray, body: int) -> Balloon:
    """Return a soft body as it is now."""
    edges = slice(*model.soft_edge_start[body : body + 2])
    rows = slice(*model.soft_particle_start[body : body + 2])
    lengths = lengths_of(position, model.edge_particles[edges])
    pulls = model.edge_stiffness[edges] * lengths
    depth = model.liquid_surface_height - position[rows, 2].mean()
    return Balloon(
        pulls @ lengths,
        pulls @ model.edge_rest_length[edges],
        controls.soft_gas[body],
        np.float64(soft_volume(model, position, body)),
        model.soft_boxes_volume[body],
        model.liquid_density * np.linalg.norm(controls.gravity) * max(0.0, depth),
    )


def _warn(balloon: Balloon, most: float, title: str) -> None:
    """Warn of a body that is going to be stretched to more than a size."""
    strain, room = balloon.strain(), balloon.room(1.0)
    held = balloon.held(most) * balloon.room(most)
    warn_user(
        f"the gas of {title} will stretch its springs by {strain:.0%}, to {balloon.size(strain) ** 3:.3g} times the "
        f"volume: {balloon.gas:.3g} J in {room:.3g} m³ are {balloon.gas / room:.3g} Pa. "
        f"For {MOST:.0%} give it a gas of {held:.3g} J, which is {held / room:.3g} Pa now, or "
        f"{balloon.firmer(most):.3g} times the stiffness",
        InflationWarning,
    )
