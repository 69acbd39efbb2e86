"""What soft bodies and boxes of a World have in common: handles, that know their world and where they are in it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar, overload

import numpy as np

from softbody.bodies.energies import energies_of_one
from softbody.bodies.names import GONE, Who
from softbody.bodies.store import HasStore, Store
from softbody.bodies.strict_names import StrictNames
from softbody.dynamics.energy import Energies
from softbody.errors import ParameterError
from softbody.geometry.submerged import submerged_part
from softbody.model.properties import checked_property, known_properties
from softbody.model.validation import check_whole


class InWorld(StrictNames):
    """A handle of something in a World."""

    __slots__ = ("_store", "_world")

    def __init__(self, world: HasStore) -> None:
        self._world = world
        self._store = world.store

    @property
    def world(self) -> Any:
        """The World that it is in."""
        return self._world

    @property
    def store(self) -> Store:
        """All that is in its world."""
        return self._store


class Body(InWorld, ABC):
    """A body in a World: its arrays are views of the world's, good until the next body is added or removed.

    It follows its body when others are removed. In a world that was restored it is the body of its number, and
    ParameterError is raised wherever there is none.
    """

    __slots__ = ("__weakref__", "_index")

    kind: ClassVar[str] = "body"

    def __init__(self, world: HasStore, index: int) -> None:
        check_whole(index, "index", 0)
        super().__init__(world)
        self._index = int(index)
        self.row()
        self._store.follow(self)

    @property
    def index(self) -> int:
        """Its number among the bodies of its kind; −1 when it was removed."""
        return self._index

    @property
    def name(self) -> str | None:
        """Its name, which no other body or joint of its world has, None for none; may be assigned."""
        return self.store.names.name(self.who())

    @name.setter
    def name(self, value: str | None) -> None:
        with self.store.exclusive():
            self.store.names = self.store.names.renamed(self.who(), value)

    def who(self) -> Who:
        """Return its kind, in a word, and its number; raises ParameterError if it is not in the world."""
        return self.kind.split()[0], self.row()

    def _title(self) -> str:
        """Return what `repr` calls it: its kind, number and name."""
        return self.store.names.title(self.who()) if self.is_there else f"{self.kind} {self.index}"

    @abstractmethod
    def _count(self) -> int:
        """Return how many bodies of this kind there are."""

    def row(self) -> int:
        """Return the body's row in the arrays of its kind; raises ParameterError if it is not in the world."""
        if self.index == GONE:
            raise ParameterError(f"this {self.kind} was removed from its world; take a handle of one that is there")
        if not self.index < self._count():
            raise ParameterError(
                f"{self.kind} {self.index} is not in this world: there are {self._count()}; take one that is"
            )
        return self.index

    @property
    def is_there(self) -> bool:
        """Whether the body is in its world still."""
        return 0 <= self.index < self._count()

    def __eq__(self, other: object) -> bool:
        """Tell whether both are handles of the same body."""
        if type(other) is not type(self):
            return NotImplemented
        return other.store is self.store and other.index == self.index  # type: ignore[attr-defined]

    def __hash__(self) -> int:
        """Return a hash that stays when other bodies are removed."""
        return hash((type(self), id(self.store)))

    def __reduce__(self) -> tuple[type, tuple[Any, int]]:
        """Pickle, and copy, with the world."""
        return type(self), (self.world, self.row())


class SleepyBody(Body):
    """A body that may fall asleep, soft or a box, in a world that has a `sleep_speed`."""

    __slots__ = ()

    def number(self) -> int:
        """Return its number over both kinds: boxes come after soft bodies."""
        return self.row() + (self.store.model.soft_count if self.kind == "box" else 0)

    @property
    def is_asleep(self) -> bool:
        """Whether it slept in the last step: nothing was done for it, as it and all that it touches are at rest."""
        return bool(self.store.contents.sleep.rest.asleep[self.number()])

    def energies(self) -> Energies:
        """Return its energy [J] by kind, as `World.energies` does for all; springs of joints are not in it."""
        return energies_of_one(self.store, self.who())

    @property
    def submerged_volume(self) -> float:
        """Volume [m³] of it that is in a liquid: the world's, or that of the soft body that it is inside."""
        return self._in_liquid()[1]

    def buoyancy(self) -> np.ndarray:
        """Return the force (3,) [N] of the liquid's pressure on it, as it is now: ρ g V upwards."""
        density, volume = self._in_liquid()
        return -density * self.store.controls.gravity * volume + 0.0

    def _in_liquid(self) -> tuple[float, float]:
        """Return the density [kg/m³] of the liquid around it, 0 for none, and the volume of it in that [m³]."""
        model = self.store.model
        if not model.liquid_density > 0.0:
            return 0.0, 0.0
        return model.liquid_density, submerged_part(*self._surface(), model.liquid_surface_height).volume

    @abstractmethod
    def _surface(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the points (n, 3) [m] and triangles (t, 3) of its surface."""

    def wake(self) -> None:
        """Let it not be at rest: it wakes in the next step, with all that it touches, if it sleeps."""
        with self.store.exclusive():
            self.store.contents.sleep.rest.time[self.number()] = 0.0


class BodyProperty:
    """A number of a body's own in the Model, as an attribute of its handle: checked when it is set.

    The field of the Model that is called so after the kind of body declares it.
    """

    field = ""

    def __set_name__(self, kind: type[Body], name: str) -> None:
        """Learn which field it is, and what it says of itself."""
        self.field = f"{kind.kind.split()[0]}_{name}"
        self.__doc__ = known_properties()[self.field].doc

    @overload
    def __get__(self, body: None, kind: type) -> BodyProperty: ...
    @overload
    def __get__(self, body: Body, kind: type) -> float: ...
    def __get__(self, body: Body | None, kind: type) -> BodyProperty | float:
        """Return the number of a body."""
        return self if body is None else float(getattr(body.store.model, self.field)[body.row()])

    def __set__(self, body: Body, value: float) -> None:
        """Set it, from the next step on; raises ParameterError if it is out of its range."""
        value = checked_property(self.field, value)
        with body.store.exclusive():
            set_row(body, self.field, value)


def set_row(body: Body, field: str, value: Any, rows: slice | None = None) -> None:
    """Put `value` into the body's row, or into `rows`, of an array of the Model: in a new Model.

    It must be the caller's turn: a Model of other bodies, which another thread has put there meanwhile, would be lost.
    """
    store, at = body.store, body.row() if rows is None else rows
    array = getattr(store.model, field).copy()
    array[at] = value
    store.replace(model=store.model._replace(**{field: array}))
