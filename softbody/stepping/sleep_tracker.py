"""The sleepers of a World, from when bodies were last added or removed: what its steps know and remember of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softbody.bodies.builder import Parts
from softbody.model.arrays import Joints, Model
from softbody.model.sleep_state import Rest
from softbody.stepping.sleep import Rested, mark_sleepers, wake_changed

if TYPE_CHECKING:
    from softbody.bodies.contact_points import ContactPoints


class Sleepers:
    """Which bodies sleep, and the Model that steps read where some may."""

    def __init__(self, parts: Parts, rested: Rested) -> None:
        """`parts` are as those who sleep were left."""
        model, count = parts.model, len(rested.time) + len(parts.joints.joint_box) + 1
        masses = model.box_inverse_mass
        bodies = len(rested.time)
        self.rest = Rest(
            rested.time.copy(),
            rested.asleep > 0,
            np.zeros(bodies, bool),
            np.zeros(count, np.int64),
            masses.copy(),
            np.zeros((bodies, 3)),
            np.zeros(bodies),
            np.zeros((bodies, 3)),
            np.zeros((bodies, 3)),
        )
        self._model, self._read = model, model._replace(box_inverse_mass=masses.copy())
        self.contacts_if_awake: tuple[bytes, ContactPoints] | None = None  # see `key`
        if self.rest.time.any():
            mark_sleepers(model, parts.controls, parts.state, _if_any(parts.joints), self.rest)

    def model_of(self, model: Model) -> Model:
        """Return the Model that steps read for this one; if it is another one than before, nobody is at rest."""
        if model is not self._model:
            masses = model.box_inverse_mass
            self.rest.time[:] = 0.0
            self.rest.box_inverse_mass[:] = masses
            self._model, self._read = model, model._replace(box_inverse_mass=masses.copy())
        return self._read

    def key(self, time_step: float) -> bytes:
        """Return what contacts of those who sleep depend on, if they were awake for a step of `time_step` [s]."""
        return self.rest.asleep.tobytes() + self.rest.mark.tobytes() + np.float64(time_step).tobytes()

    def rested(self, parts: Parts) -> Rested:
        """Return what the coming steps depend on, with `parts` as they are now."""
        self.model_of(parts.model)
        if self.rest.time.any():
            wake_changed(parts.model, parts.controls, parts.state, _if_any(parts.joints), self.rest)
        return Rested(self.rest.time, self.rest.asleep.astype(np.int64))


def _if_any(joints: Joints) -> Joints | None:
    return joints if len(joints.joint_box) else None
