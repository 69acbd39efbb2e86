"""Session that moves a watched world, in a loop that keeps up with the clock or says it cannot."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from time import perf_counter

import numpy as np

from softbody.bodies.rigid_box import Box
from softbody.bodies.soft_body import SoftBody
from softbody.errors import ParameterError, SimulationError
from softbody.model.settings import check_name
from softbody.render.quantities import QUANTITIES
from softbody.stepping.runner import Steppable
from softbody.stepping.time_steps import BOX_STEP, OF_STABLE
from softbody.storage.restore import restore, snapshot_of_store
from softbody.view.adjustments import Adjustments
from softbody.view.frame import Frame, frame_of
from softbody.view.grip import Grip

LONGEST_CALL = 0.008  # [s] by the clock, about, that steps are taken at once: then what was asked for is done
PULL_FOR = 1.0 / 240.0  # [s] of the world's time that a pull stays as it is
SMOOTHING = 0.1  # of what is new, in the mean of the real-time factor
HISTORY = 600  # instants of which energies are kept
EVERY = 1.0 / 30.0  # [s] of the world's time between them


class Session:
    """A world that is watched.

    One thread calls `tick`; others `ask` for changes, which are made between steps, and read `frame` and `status`.
    """

    def __init__(self, world: Steppable, clock: Callable[[], float] = perf_counter) -> None:
        self.world = world
        self.adjustments = Adjustments(world, world.store.awake_copy())
        self.grip = Grip(world.store)
        self.is_playing = True
        self.speed = 1.0  # of the world's time to the clock's that is wanted
        self.real_time_factor = 0.0  # that is had
        self.status = "compiling: the first step takes up to a minute and a half"
        self.quantity: str | None = None
        self.history: deque[tuple[float, float, float]] = deque(maxlen=HISTORY)  # time, kinetic energy, all energy
        self._start = snapshot_of_store(world.store)
        self._clock = clock
        self._asked: deque[Callable[[], None]] = deque()
        self._time_step: float | None = None
        self._cost = 0.0  # [s] by the clock of a step
        self._owed = 0.0  # [s] less than a step, left from the turn before
        self.frame = self._frame()

    def ask(self, change: Callable[[], None]) -> None:
        """Let `change` be called between steps, by the thread that takes them."""
        self._asked.append(change)

    def tick(self, elapsed: float) -> None:
        """Do what was asked, and go on by `elapsed` [s] by the clock, for no longer than that takes."""
        is_news = self.is_playing or bool(self._asked)
        while self._asked:
            self._do(self._asked.popleft())
        if self.is_playing:
            self._go_on(elapsed)
        if is_news:
            self.frame = self._frame()

    def set_slider(self, name: str, value: float) -> None:
        """Change what a slider stands for."""
        self.adjustments.set_slider(name, value)
        self._time_step = None

    def set_integrator(self, name: str) -> None:
        """Take another integrator."""
        self.adjustments.set_integrator(name)
        self._time_step = None

    def show(self, quantity: str | None) -> None:
        """Let colours show a quantity, or none."""
        if quantity is not None:
            check_name(quantity, "quantity", tuple(QUANTITIES))
        self.quantity = quantity

    def play(self, yes: bool) -> None:
        """Go on, or pause."""
        self.is_playing, self.status = yes, "" if yes else "paused"

    def step_once(self) -> None:
        """Pause, and take one step."""
        self.is_playing = False
        self._step(1)

    def restart(self) -> None:
        """Begin again, with what was changed since."""
        self.grip.let_go()
        restore(self.world.store, self._start)
        self.adjustments.repeat()
        self.history.clear()
        self._time_step, self._owed = None, 0.0
        self.play(True)

    def grab(self, kind: str, index: int, point: np.ndarray) -> None:
        """Take hold of a "soft" body or a "box" at `point` (3,) [m]."""
        self.grip.grab(SoftBody(self.world, index) if kind == "soft" else Box(self.world, index), np.asarray(point))

    def _do(self, change: Callable[[], None]) -> None:
        try:
            change()
        except ParameterError as error:
            self.status = str(error)

    def _go_on(self, elapsed: float) -> None:
        """Take steps for the world's time that `elapsed` asks for, as long as that much time is left."""
        begun, before = self._clock(), self.world.store.time
        self._owed += elapsed * self.speed
        h = self._step_length()
        while self._owed >= h and self.is_playing:
            most = PULL_FOR / h if self.grip.is_holding else np.inf
            if self._cost > 0.0:
                most = min(most, LONGEST_CALL / self._cost)
            self._owed -= h * self._step(int(max(1, min(self._owed / h, most))))
            h = self._step_length()
            if self._clock() - begun >= elapsed:
                break
        self._owed = min(self._owed, h)  # what there was no time for is not made up
        took = max(self._clock() - begun, elapsed)
        if took > 0.0:
            self.real_time_factor += SMOOTHING * ((self.world.store.time - before) / took - self.real_time_factor)

    def _step(self, steps: int) -> int:
        """Take steps, and return how many; where the world diverges it is paused."""
        self.grip.pull()
        begun = self._clock()
        is_first = self.world.store.steps == 0
        try:
            self.world.runner.step(self._step_length(), steps)
        except ParameterError:  # it is stretched so far that stable steps are shorter now
            self._time_step = None
            self.world.runner.step(self._step_length(), steps, allow_unstable=True)
        except SimulationError as error:
            self.is_playing, self.status = False, f"stopped: {error}"
            return steps
        if not is_first:
            self._cost = (self._clock() - begun) / steps
        self.status = "" if self.is_playing else "paused"
        return steps

    def _step_length(self) -> float:
        """Return the time step [s]; it is sought anew when something was changed."""
        if self._time_step is None:
            self._time_step = min(BOX_STEP, OF_STABLE * self.world.runner.stable_time_step())
        return self._time_step

    def _frame(self) -> Frame:
        frame = frame_of(self.world, self.quantity, self.grip.line())
        if not self.history or frame.time >= self.history[-1][0] + EVERY:
            self.history.append((frame.time, frame.kinetic, frame.total))
        return frame
