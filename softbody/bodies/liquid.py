"""The liquid of a World: a handle, for what of it may be set between steps."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from softbody.bodies.surroundings import Number, Surroundings
from softbody.errors import ParameterError
from softbody.model.validation import vector


class Liquid(Surroundings):
    """The liquid of a World: it fills all below a level surface, if `World.add_liquid` was called."""

    __slots__ = ()

    kind = "liquid"

    density = Number("Mass by volume [kg/m³]; water has 1000.", "kg/m³", above=0.0)
    surface_height = Number("Height z [m] below which there is liquid.", "m")
    drag = Number("Force against the liquid's speed, by speed and wet area [N s/m³].", "N s/m³", least=0.0)

    @property
    def velocity(self) -> np.ndarray:
        """Velocity (3,) [m/s] with which it flows, read-only: drag carries bodies along; may be assigned."""
        self.check_there()
        view = self.store.model.liquid_velocity.view()
        view.flags.writeable = False
        return view

    @velocity.setter
    def velocity(self, value: ArrayLike) -> None:
        self.set_field("velocity", vector(value, "velocity"))

    @property
    def is_there(self) -> bool:
        """Whether there is a liquid."""
        return self.store.model.liquid_density > 0.0

    def __repr__(self) -> str:
        """Say how dense it is, and how high."""
        if not self.is_there:
            return "<no liquid>"
        return f"<liquid of {self.density:.4g} kg/m³ up to {self.surface_height:.4g} m: drag {self.drag:.4g} N s/m³>"


def check_level(gravity: np.ndarray) -> None:
    """Raise ParameterError unless gravity (3,) [m/s²] points straight down: a liquid is level."""
    if not (gravity[0] == 0.0 and gravity[1] == 0.0 and gravity[2] < 0.0):
        raise ParameterError(
            f"gravity is {gravity}, and there is a liquid, whose surface is level: let gravity point down, (0, 0, −g)"
        )
