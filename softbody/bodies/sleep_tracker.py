"""The sleepers of a World, from when bodies were last added or removed."""

from __future__ import annotations

import numpy as np

from softbody.model.arrays import Model
from softbody.model.sleep_state import Rested, SleepState


class SleepTracker:
    """Which bodies sleep, and the Model that steps read where some may."""

    def __init__(self, model: Model, joints: int, rested: Rested) -> None:
        """Begin with bodies that have `rested`; `joints` is their number."""
        masses, bodies = model.box_inverse_mass, len(rested.time)
        self.rest = SleepState(
            rested.time.copy(),
            rested.asleep > 0,
            np.zeros(bodies, bool),
            np.zeros(bodies + joints + 1, np.int64),
            masses.copy(),
            np.zeros((bodies, 3)),
            np.zeros(bodies),
            np.zeros((bodies, 3)),
            np.zeros((bodies, 3)),
        )
        self._model, self._read = model, model._replace(box_inverse_mass=masses.copy())

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
