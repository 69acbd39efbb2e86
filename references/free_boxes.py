"""Boxes that fly free, or are pulled by a spring, step by step, by hand: semi-implicit, as most engines move them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

PACKAGES = {"scipy": "scipy"}  # import name, and the name to install it by


def _none() -> np.ndarray:
    return np.zeros(3)


@dataclass
class Spring:
    """A damped spring from the centre of a box to a place; of no length at rest it damps all motion."""

    target: np.ndarray  # (3,) [m]
    stiffness: float  # [N/m]
    damping: float  # [N s/m]
    rest_length: float  # [m]

    def force(self, place: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """Return what pulls at the centre (3,) [N]."""
        way = self.target - place
        if self.rest_length == 0.0:
            return self.stiffness * way - self.damping * velocity
        length = float(np.linalg.norm(way))
        along = way / length
        pull: np.ndarray = (self.stiffness * (length - self.rest_length) - self.damping * (along @ velocity)) * along
        return pull


@dataclass
class FreeBox:
    """A box, whose angular velocity is kept where no torque acts; of mass None it moves as it is told."""

    size: np.ndarray  # (3,) [m]
    mass: float | None  # [kg]
    place: np.ndarray  # (3,) [m] of its centre
    turn: np.ndarray  # (3, 3), whose columns are its axes
    spring: Spring | None = None
    velocity: np.ndarray = field(default_factory=_none)  # [m/s]
    spin: np.ndarray = field(default_factory=_none)  # [rad/s]
    force: np.ndarray = field(default_factory=_none)  # [N] at the centre
    torque: np.ndarray = field(default_factory=_none)  # [N m]
    time_left: float = np.inf  # [s] until it stops

    def advance(self, h: float, gravity: np.ndarray) -> None:
        """Make a step of `h` [s]."""
        from scipy.spatial.transform import Rotation

        if self.mass is not None:
            pull = self.force if self.spring is None else self.force + self.spring.force(self.place, self.velocity)
            self.velocity = self.velocity + h * (gravity + pull / self.mass)
            squares = self.size**2
            inertia = self.mass / 12.0 * (squares.sum() - squares)
            self.spin = self.spin + h * self.turn @ ((self.turn.T @ self.torque) / inertia)
        part = min(h, self.time_left)
        self.place = self.place + part * self.velocity
        self.turn = Rotation.from_rotvec(part * self.spin).as_matrix() @ self.turn
        self.time_left -= part
        if self.time_left <= 0.0:
            self.velocity, self.spin = _none(), _none()
