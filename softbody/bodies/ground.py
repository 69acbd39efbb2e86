"""The ground of a World: a handle, for what of it may be set between steps."""

from __future__ import annotations

from typing import Any

from softbody.bodies.body import InWorld
from softbody.errors import ParameterError
from softbody.model.validation import check_range


class GroundNumber:
    """A number of the ground, as an attribute of its handle: checked when it is set."""

    def __init__(self, name: str, doc: str, unit: str = "", **limits: float) -> None:
        self._name, self._unit, self._limits = name, unit, limits
        self.__doc__ = doc

    def checked(self, value: float) -> float:
        """Return the number; raises ParameterError if it is out of its range."""
        return check_range(value, self._name, self._unit, **self._limits)

    def __get__(self, ground: Ground | None, kind: type) -> Any:
        """Return the number [float]; raises ParameterError where there is no ground."""
        if ground is None:
            return self
        ground.check_there()
        return float(getattr(ground.store.model, f"ground_{self._name}"))

    def __set__(self, ground: Ground, value: float) -> None:
        """Set it, from the next step on; raises ParameterError if it is out of its range, or there is no ground."""
        value, store = self.checked(value), ground.store
        with store.exclusive():
            ground.check_there()
            changed: dict[str, Any] = {f"ground_{self._name}": value}
            store.replace(model=store.model._replace(**changed))


class Ground(InWorld):
    """The ground of a World: everything below a height is solid, if `World.add_ground` was called."""

    __slots__ = ()

    height = GroundNumber("height", "Height z [m] below which all is solid.", "m")
    restitution = GroundNumber("restitution", "Restitution in contacts, 0 … 1.", least=0.0, most=1.0)
    friction = GroundNumber("friction", "Coulomb coefficient of friction in contacts, ≥ 0.", least=0.0)

    @property
    def is_there(self) -> bool:
        """Whether there is a ground."""
        return self.store.model.ground_height > -float("inf")

    def check_there(self) -> None:
        """Raise ParameterError where there is no ground."""
        if not self.is_there:
            raise ParameterError("this world has no ground; call add_ground first")

    def __repr__(self) -> str:
        """Say how high it is, and what meets on it."""
        if not self.is_there:
            return "<no ground>"
        return f"<ground at {self.height:.4g} m: restitution {self.restitution:.4g}, friction {self.friction:.4g}>"
