"""Grip of the mouse on a body: a damped spring from what was grabbed to where the mouse is."""

from __future__ import annotations

from math import pi

import numpy as np

from softbody.bodies.rigid_box import Box
from softbody.bodies.soft_body import SoftBody
from softbody.bodies.store import Store

FREQUENCY = 1.5  # [1/s] at which the whole body would swing on the spring
DAMPING_RATIO = 0.7
MOST_PULL = 300.0  # [m/s²] that the pull may give the whole body: else the mouse would tear it
REACH = 0.5  # of a soft body's radius around the mouse, within which its particles are held


class Grip:
    """What holds on to a body, or to none. Forces that acted before come back when it lets go."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._body: SoftBody | Box | None = None
        self._rows = np.empty(0, np.int64)  # particles that are held
        self._arm = np.zeros(3)  # of a box, in its own frame [m]
        self._before: tuple[np.ndarray, np.ndarray] = np.zeros(3), np.zeros(3)
        self.target = np.zeros(3)  # [m]

    @property
    def is_holding(self) -> bool:
        """Whether a body is held."""
        return self._body is not None

    def grab(self, body: SoftBody | Box, point: np.ndarray) -> None:
        """Hold on to what is nearest to `point` (3,) [m]."""
        self.let_go()
        self.target = np.array(point, float)
        if isinstance(body, SoftBody):
            positions = body.positions
            radius = float(np.linalg.norm(positions - body.centre, axis=1).max())
            away = np.linalg.norm(positions - positions[np.linalg.norm(positions - point, axis=1).argmin()], axis=1)
            self._rows = np.flatnonzero(away <= REACH * radius)
            self._before = body.external_force.copy(), np.zeros(3)
        else:
            controls = self._store.controls
            self._arm = _turned(_conjugate(body.orientation), point - body.position)
            self._before = controls.box_force[body.index].copy(), controls.box_torque[body.index].copy()
        self._body = body

    def pull(self) -> None:
        """Let the spring act as it is stretched now; it stays so until it pulls again."""
        if isinstance(self._body, SoftBody):
            body, rows = self._body, self._rows
            if len(body.positions) != len(self._before[0]):
                self._slip()
                return
            force = self._force(body.positions[rows].mean(axis=0), body.velocities[rows].mean(axis=0), body.mass)
            forces = self._before[0].copy()
            forces[rows] += force / len(rows)
            body.external_force = forces
        elif self._body is not None:
            box = self._body
            if box.mass is None:
                return
            arm = _turned(box.orientation, self._arm)
            velocity = box.velocity + np.cross(box.angular_velocity, arm)
            force = self._force(box.position + arm, velocity, box.mass)
            self._act_on_box(box, self._before[0] + force, self._before[1] + np.cross(arm, force))

    def let_go(self) -> None:
        """Pull no more."""
        if isinstance(self._body, SoftBody) and len(self._body.positions) != len(self._before[0]):
            self._slip()
        elif isinstance(self._body, SoftBody):
            self._body.external_force = self._before[0]
        elif self._body is not None:
            self._act_on_box(self._body, *self._before)
        self._body = None

    def _slip(self) -> None:
        """Let go of a body that has torn in the hand: nothing acts on its pieces any more."""
        pieces = (each for event in self._store.events if self._body in event.bodies for each in event.bodies)
        for each in pieces:
            if each.is_there:
                each.external_force = np.zeros(3)
        self._body = None

    def line(self) -> np.ndarray | None:
        """Return the spring's two ends (2, 3) [m], or None where nothing is held."""
        if self._body is None:
            return None
        if isinstance(self._body, SoftBody):
            held = self._rows[self._rows < len(self._body.positions)]  # fewer, where it has torn just now
            return np.array([self._body.positions[held].mean(axis=0), self.target]) if len(held) else None
        return np.array([self._body.position + _turned(self._body.orientation, self._arm), self.target])

    def _force(self, point: np.ndarray, velocity: np.ndarray, mass: float) -> np.ndarray:
        """Return the spring's force (3,) [N] on a body of `mass` [kg]."""
        omega = 2.0 * pi * FREQUENCY
        force = mass * (omega**2 * (self.target - point) - 2.0 * DAMPING_RATIO * omega * velocity)
        return force * min(1.0, MOST_PULL * mass / max(float(np.linalg.norm(force)), 1e-300))

    def _act_on_box(self, box: Box, force: np.ndarray, torque: np.ndarray) -> None:
        box.clear_forces()
        box.apply_force(force)
        box.apply_torque(torque)


def _conjugate(q: np.ndarray) -> np.ndarray:
    return np.array([q[0], -q[1], -q[2], -q[3]])


def _turned(q: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Return a vector (3,) turned by a unit quaternion."""
    turn = 2.0 * np.cross(q[1:], vector)
    return np.asarray(vector + q[0] * turn + np.cross(q[1:], turn))
