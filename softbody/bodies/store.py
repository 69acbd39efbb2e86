"""What a World, its handles, its files and its pictures share: all that is in it, and whose turn it is."""

from __future__ import annotations

import threading
from collections import deque
from typing import Any, Protocol
from weakref import WeakValueDictionary

import numpy as np

from softbody.bodies.builder import Parts
from softbody.bodies.names import Names
from softbody.bodies.sleep_tracker import SleepTracker
from softbody.collision.contact import Contacts, remembered, remembering
from softbody.errors import BusyError
from softbody.model.arrays import Clock, Controls, Joints, Model, State, VertexRings
from softbody.model.settings import Settings
from softbody.model.shapes import Labels
from softbody.model.sleep_state import Rested, not_rested

MOST_EVENTS = 10_000  # that a world remembers
FIRST_ROOM = 256  # contacts; there is more as soon as it is needed


class Contents:
    """The bodies of a world and what they are called: replaced as one, so that no interrupt comes between."""

    def __init__(self, parts: Parts, names: Names, rested: Rested | None = None, is_fresh: bool = True) -> None:
        """Take bodies that have `rested` for so long, or that are new; `is_fresh`: some were added since a step."""
        rested = not_rested(parts.model) if rested is None else rested
        self.parts = parts
        self.names = names
        self.sleep = SleepTracker(parts.model, len(parts.joints.joint_box), rested)
        self.is_fresh = is_fresh
        self.ground_impulse = np.zeros_like(parts.state.particle_position)  # (n, 3) [N s] in the last step


class Store:
    """The model, controls, state, names and settings of a world, its contacts, and how far it is."""

    def __init__(self, contents: Contents, contacts: Contacts, settings: Settings, precision: str) -> None:
        self.contents = contents
        self.contacts = contacts
        self.settings = settings
        self.precision = precision  # "double" or "single"
        self.clock = new_clock()
        self.owed = 0.0  # [s] that `step_frame` was asked for and that were too short for a step of one's own
        self.time_step = 0.0  # [s] of the last step, 0 before there is one
        self.events: deque[Any] = deque(maxlen=MOST_EVENTS)  # what bodies tore, were cut or joined; see Event
        self.handles: WeakValueDictionary[int, Any] = WeakValueDictionary()
        self._turn = threading.Lock()  # of who steps, or changes what there is

    @property
    def store(self) -> Store:
        """Itself: handles are made for a World, or for what is in one."""
        return self

    @property
    def parts(self) -> Parts:
        """All arrays."""
        return self.contents.parts

    @property
    def names(self) -> Names:
        """Who is called what; may be replaced."""
        return self.contents.names

    @names.setter
    def names(self, value: Names) -> None:
        self.contents.names = value

    @property
    def model(self) -> Model:
        """What the bodies are."""
        return self.contents.parts.model

    @property
    def controls(self) -> Controls:
        """What acts on the bodies."""
        return self.contents.parts.controls

    @property
    def state(self) -> State:
        """Where the bodies are."""
        return self.contents.parts.state

    @property
    def rings(self) -> VertexRings:
        """The soft bodies, in the order in which kernels read them."""
        return self.contents.parts.rings

    @property
    def joints(self) -> Joints:
        """The joints."""
        return self.contents.parts.joints

    @property
    def steps(self) -> int:
        """Steps done since the world was made."""
        return int(self.clock.steps[0])

    @property
    def time(self) -> float:
        """Time since the world was made [s]."""
        return float(self.clock.time[0])

    @property
    def may_sleep(self) -> bool:
        """Whether bodies may fall asleep."""
        return self.settings.sleep_speed > 0.0

    def replace(self, **parts: Any) -> None:
        """Replace some of `model`, `controls`, `state`, `rings` and `joints`, for the same bodies, as one."""
        self.contents.parts = self.contents.parts._replace(**parts)

    def exclusive(self) -> threading.Lock:
        """Return what to hold while something is done with the world; raises BusyError while it is being stepped."""
        if self._turn.locked():
            raise BusyError(
                "this world is being stepped, by another thread or by what called this; wait until it is done, or give "
                "each thread a world of its own"
            )
        return self._turn

    def follow(self, handle: Any) -> None:
        """Keep the index of a handle right for as long as there is the handle."""
        self.handles[id(handle)] = handle

    def held(self) -> list[Any]:
        """Return all handles that somebody holds, of what is there."""
        every = (reference() for reference in self.handles.valuerefs())  # another thread may make some meanwhile
        return [each for each in every if each is not None and each.is_there]

    def labels(self) -> Labels:
        """Return what bodies are called now, and which boxes cannot move."""
        model = self.model
        words = self.names.words({"soft": model.soft_count, "box": model.box_count})
        soft, boxes = (tuple(words[kind].tolist()) for kind in ("soft", "box"))
        return Labels(soft, boxes, tuple((model.box_inverse_mass == 0.0).tolist()))

    def awake_copy(self) -> Store:
        """Return a store of the same bodies, all of them awake, that shares no memory with this one but the rings."""
        model, controls, state, rings, joints = self.parts
        parts = Parts(_copied(model), _copied(controls), _copied(state), rings, _copied(joints))
        contacts = remembering(remembered(self.contacts), FIRST_ROOM)
        return Store(Contents(parts, self.names, is_fresh=False), contacts, self.settings, self.precision)


class HasStore(Protocol):
    """A World, as its handles and pictures see it."""

    @property
    def store(self) -> Store:
        """All that is in it."""


def new_clock(steps: int = 0, time: float = 0.0) -> Clock:
    """Return the clock of a world that has done so many steps, and is at such a time [s]."""
    return Clock(np.array([steps], np.int64), np.array([time]), np.zeros(1, np.int64), np.zeros(1))


def _copied(part: Any) -> Any:
    """Return a named tuple of arrays that shares no memory with this one."""
    return type(part)(*(np.array(value) if isinstance(value, np.ndarray) else value for value in part))
