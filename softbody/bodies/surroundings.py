"""What surrounds the bodies of a World: handles of what there is one of, with numbers that may be set between steps."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar

from softbody.bodies.body import InWorld
from softbody.errors import ParameterError
from softbody.model.validation import check_range


class Surroundings(InWorld):
    """The ground, or a liquid."""

    __slots__ = ()

    kind: ClassVar[str] = ""

    @property
    @abstractmethod
    def is_there(self) -> bool:
        """Whether there is one."""

    def check_there(self) -> None:
        """Raise ParameterError where there is none."""
        if not self.is_there:
            raise ParameterError(f"this world has no {self.kind}; call add_{self.kind} first")

    def set_field(self, name: str, value: Any) -> None:
        """Set what the Model says of it, from the next step on: in a new Model."""
        store = self.store
        with store.exclusive():
            self.check_there()
            store.replace(model=store.model._replace(**{f"{self.kind}_{name}": value}))


class Number:
    """A number of the surroundings, as an attribute of their handle: checked when it is set."""

    _name = ""

    def __init__(self, doc: str, unit: str = "", **limits: float) -> None:
        self._unit, self._limits = unit, limits
        self.__doc__ = doc

    def __set_name__(self, kind: type, name: str) -> None:
        """Learn what it is called."""
        self._name = name

    def checked(self, value: float) -> float:
        """Return the number; raises ParameterError if it is out of its range."""
        return check_range(value, self._name, self._unit, **self._limits)

    def __get__(self, thing: Surroundings | None, kind: type) -> Any:
        """Return the number [float]; raises ParameterError where there are no such surroundings."""
        if thing is None:
            return self
        thing.check_there()
        return float(getattr(thing.store.model, f"{thing.kind}_{self._name}"))

    def __set__(self, thing: Surroundings, value: float) -> None:
        """Set it, from the next step on; raises ParameterError if it is out of its range, or there is none."""
        thing.set_field(self._name, self.checked(value))
