"""A run of steps: from the call of a user to the kernels, and what is said where they stop."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from typing import NamedTuple, Protocol

import numba
import numpy as np

from softbody.bodies.contact_points import ContactPoints, contact_points
from softbody.bodies.liquid import check_level
from softbody.bodies.soft_body import Event, SoftBody
from softbody.bodies.store import HasStore, Store
from softbody.bodies.tearing import tear_bodies
from softbody.collision.contact import remembered, remembering
from softbody.collision.pressed import FIRST, NOW
from softbody.compiler.interrupts import NEVER_SET, InterruptFlag, listening
from softbody.compiler.threads import team_of
from softbody.errors import ParameterError
from softbody.model.arrays import NOBODY
from softbody.model.settings import Settings
from softbody.model.validation import check_range, check_whole, check_yes_or_no, shown
from softbody.stepping.checks import (
    StableStep,
    check_box_motion,
    check_finite,
    fault_of,
    helpful_step,
    longest_step_of_forces,
    may_lie_flat,
    pairs_inside,
    pressed_through,
    sides_of,
    stable_time_step,
    warn_of_mass_ratios,
    warn_of_overlap,
    warn_of_pressed,
    warn_of_what_is_out,
)
from softbody.stepping.inflation import Inflation
from softbody.stepping.memory import Memory
from softbody.stepping.skins import is_look, next_look
from softbody.stepping.step import NO_ROOM, NO_ROOM_FOR_PAIRS, PRESSED_THROUGH, UNSEEN, Order, run, run_alone_by_clock

FEW_STEPS = 32  # that a body which may touch itself is moved like one that does, before it is looked at again
WORTH_LISTENING = 50_000  # particles moved by a sub-step in a call, from which it may take so long that one waits


class Call(NamedTuple):
    """A call of a user: steps of `h` [s] by some settings, at which step and time [s] it began, and who stops it."""

    h: float
    settings: Settings
    begun: tuple[int, float]
    flag: InterruptFlag


class Runner:
    """Advances what is in a store."""

    def __init__(self, store: Store, threads: int = 1) -> None:
        self.store = store
        self._stable_step, self._inflation = StableStep(), Inflation()
        self._awake: tuple[object, bytes, ContactPoints] | None = None  # contacts of sleepers, see `contact_points`
        self.threads = threads

    @property
    def threads(self) -> int:
        """Threads that move soft bodies and find their contacts; may be changed."""
        return self._threads

    @threads.setter
    def threads(self, value: int) -> None:
        value = check_whole(value, "threads", 1)
        most = numba.config.NUMBA_NUM_THREADS  # type: ignore[attr-defined]
        if value > most:
            raise ParameterError(
                f"threads is {shown(value)}, and there are {most} here; give a number from 1 to {most}"
            )
        with self.store.exclusive():
            self._threads, self._memory = value, Memory(self.store, value)

    @property
    def memory(self) -> Memory:
        """What steps work with: made anew where there are other bodies."""
        if self._memory.contents is not self.store.contents:
            self._memory = Memory(self.store, self._threads)
        return self._memory

    def step(self, time_step: float, steps: int = 1, substeps: int | None = None, allow_unstable: bool = False) -> None:
        """Do what `World.step` says."""
        h = check_range(time_step, "time_step", "s", above=0.0)
        steps = check_whole(steps, "steps", 0)
        store, settings = self.store, self.store.settings
        if substeps is not None:
            settings = settings._replace(substeps=check_whole(substeps, "substeps", 1))
        if steps * settings.substeps > 2**62:
            raise ParameterError(f"steps × substeps is {steps * settings.substeps}; give fewer, up to 2**62")
        allow_unstable = check_yes_or_no(allow_unstable, "allow_unstable")
        with store.exclusive(), self._listening(steps * settings.substeps) as flag:
            self._check_level()
            model, controls, state, _, joints = store.parts
            begun, is_first = (store.steps, store.time), steps > 0 and store.contents.is_fresh
            call = Call(h, settings, begun, flag)
            # Where all is as the last call has left it, the kernels look at what they begin with.
            fault, body = UNSEEN, -1
            is_known = allow_unstable or self._stable_step.allows(h, model, controls, settings, joints, begun[0])
            if is_known and steps > 0 and not is_first:
                fault, body = self.advance(call, begun[0] + steps, is_seen=False)
            # Elsewhere it is looked at here, with an error that names the culprit.
            if fault == UNSEEN:
                check_finite(model, controls, state, joints)
                self._hold_skins()
                if not allow_unstable:
                    self._stable_step.check(h, model, controls, state, settings, joints, begun[0])
                self._inflation.look(model, controls, state.particle_position, store.names)
                fault, body = self._first_step(call) if is_first else (0, -1)
                if not fault:
                    fault, body = self.advance(call, begun[0] + steps, is_seen=True)
            store.time_step = h
            model, controls, state, _, joints = store.parts  # others, where something has torn
            if fault:
                store.contents.ground_impulse[:] = 0.0
                check_finite(model, controls, state, joints)  # a target that was written over
                if body >= model.soft_count and store.steps == begun[0]:
                    check_box_motion(model, state, h, body - model.soft_count)
                if fault == PRESSED_THROUGH:
                    raise pressed_through(self.memory.pressed, model, store.steps, store.names)
                advice = helpful_step(model, controls, state, settings, joints, body)
                raise fault_of(fault, body, model, h / settings.substeps, advice, store.steps, store.names)
            self._warn_of_pressed()
            if (model.box_host != NOBODY).any():
                warn_of_what_is_out(model, state, self.memory.said_out, store.names)
            if model.box_count and self.memory.may_carry_too_much(model):
                warn_of_mass_ratios(model, controls, store.contacts, store.names)

    def _listening(self, parts: int) -> AbstractContextManager[InterruptFlag]:
        """Return what yields a flag for a call of so many sub-steps: signals set it where that may take long."""
        work = parts * (len(self.store.state.particle_position) + 10 * self.store.model.box_count)
        return nullcontext(NEVER_SET) if self._threads == 1 and work < WORTH_LISTENING else listening()

    def _first_step(self, call: Call) -> tuple[int, int]:
        """Do the first step after bodies were added, and warn of those that overlap; return (fault, body)."""
        surfaces = None if self._is_alone() else self.memory.surfaces()
        if surfaces is not None:
            surfaces.deepest[0] = 0.0
        stopped = self.advance(call, call.begun[0] + 1, is_seen=True)
        self.store.contents.is_fresh = False
        self.memory.started_inside |= pairs_inside(self.store.model, self.store.contacts)
        self.memory.pressed.part[FIRST] = 0.0
        if surfaces is not None:
            warn_of_overlap(self.store.model, surfaces, self.store.names)
        return stopped

    def _warn_of_pressed(self) -> None:
        """Warn of bodies that a step has left deep inside each other: of each pair once, and of none that start so."""
        memory, model = self.memory, self.store.model
        if memory.pressed.part[FIRST] > 0.0:
            pair = sides_of(model, memory.pressed.sides[FIRST])
            if pair not in memory.told | memory.started_inside:
                warn_of_pressed(memory.pressed, pair, model, self.store.names)
            memory.told.add(pair)
            memory.pressed.part[FIRST] = 0.0

    def advance(self, call: Call, end: int, is_seen: bool) -> tuple[int, int]:
        """Run kernels until the clock shows `end` steps; return (fault, body), see `step.run`.

        A run of kernels is over when the flag is set: in the midst of a step, once. Then one is always done, so that
        the world goes on however often it is set. With threads it is all of them, or one, as is faster just now.
        """
        store, memory, team = self.store, self.memory, self.memory.team
        contacts, flag, abort_mid_step, is_alone = store.contacts, call.flag, True, self._is_alone()
        with team_of(self._threads):
            while (left := end - store.steps) > 0:
                model, controls, state, *_ = store.parts
                waits, skin = bool((model.soft_self_contact < 0.0).any()), memory.skin()
                tearing = memory.tearing()
                tearing.is_torn[0] = False
                if store.may_sleep:
                    model = store.contents.sleep.model_of(model)
                if skin is not None or not self._is_alone():
                    model = may_lie_flat(model, controls)
                before, look = store.steps, next_look(store.steps, waits)
                left = min(left, look - before)
                if self._threads > 1:
                    numba.set_num_threads(team.now)
                    left = team.turn(left)
                flag.clear()
                if is_alone:
                    order = Order(call.h, left, *call.begun, is_seen, abort_mid_step)
                    surfaces = memory.surfaces() if skin is not None else None
                    how = (
                        surfaces,
                        skin,
                        call.settings,
                        store.clock,
                        order,
                        store.contents.ground_impulse,
                        *memory.acting(),
                        tearing,
                    )
                    fault, body = run_alone_by_clock(model, controls, state, memory.motion(flag), *how)
                    if skin is not None and store.steps > before:
                        self._forget_contacts()
                else:
                    left = min(left, FEW_STEPS) if self._is_alone() else left
                    order = Order(call.h, left, *call.begun, is_seen, abort_mid_step)
                    work = memory.work(flag)
                    fault, body = run(model, controls, state, work, contacts, call.settings, store.clock, order)
                if fault == NO_ROOM:
                    contacts = store.contacts = remembering(remembered(contacts), body)
                elif fault == NO_ROOM_FOR_PAIRS:
                    memory.make_room_for_pairs()
                elif fault == PRESSED_THROUGH and sides_of(model, memory.pressed.sides[NOW]) in memory.started_inside:
                    memory.pressed.lasting[0] = 0  # the step that was undone is taken, whole or in parts
                elif fault:
                    return fault, body
                elif tearing.is_torn[0]:
                    self._tear()
                    memory, contacts = self.memory, store.contacts
                if self._threads > 1:
                    team.note(store.steps - before)
                if store.steps == look and model.soft_count:
                    self._look_at_skins(look)
                # A body that may touch itself now is not moved as one that does not, for some steps.
                is_alone = self._is_alone() and not (is_alone and store.steps == before)
                is_seen, abort_mid_step = True, abort_mid_step and store.steps > before
        return 0, -1

    def _tear(self) -> None:
        """Let bodies tear whose springs are beyond their limits."""
        store, before = self.store, self._memory
        tears = tear_bodies(store)
        if tears:
            store.contents.is_fresh = False
            self.memory.remember(before)
            for tear in tears:
                bodies = tuple(SoftBody(store, number) for number in tear.bodies)
                store.events.append(Event("tear", store.time, tear.places, bodies))

    def _forget_contacts(self) -> None:
        """Forget the contacts of the step before one that had none."""
        contacts, pressed = self.store.contacts, self.memory.pressed
        contacts.number[:], contacts.cache.number[:], contacts.cache.soft[:] = 0, 0, 0
        pressed.part[NOW], pressed.lasting[0] = 0.0, 0

    def _hold_skins(self) -> None:
        """Forget where particles were, and let bodies that meet themselves not hold themselves yet, with a warning."""
        store, memory, model = self.store, self.memory, self.store.model
        memory.forget_skin()
        if (model.soft_self_contact > 0.0).any():
            self._let_hold(
                memory.skins().hold(model.soft_self_contact, store.state.particle_position, store.steps, store.names)
            )

    def _let_hold(self, distance: np.ndarray) -> None:
        """Let bodies hold themselves at a distance (b,) [m], or wait; a model that does not change stays the same."""
        store = self.store
        if (distance != store.model.soft_self_contact).any():
            store.replace(model=store.model._replace(soft_self_contact=distance))

    def _look_at_skins(self, step: int) -> None:
        """Warn of bodies that go through themselves after a step, and let those that have parted hold themselves."""
        store, skins, model = self.store, self.memory.skins(), self.store.model
        if (model.soft_self_contact < 0.0).any():
            self._let_hold(skins.parted(model.soft_self_contact, store.state.particle_position))
            self.memory.forget_skin()
        if is_look(step):
            skins.look(store.state.particle_position, step, store.names)

    def _check_level(self) -> None:
        """Raise ParameterError where gravity is not as a liquid needs it."""
        if self.store.model.liquid_density > 0.0:
            check_level(self.store.controls.gravity)

    def _is_alone(self) -> bool:
        """Tell whether there is one soft body at most, perhaps the ground and liquids, and nobody who may sleep."""
        store, model = self.store, self.store.model
        is_only = model.box_count == 0 and model.soft_count <= 1
        return is_only and not (len(store.joints.joint_box) or store.may_sleep or len(self.memory.tearing().holes))

    def stable_time_step(self) -> float:
        """Do what `World.stable_time_step` says."""
        store = self.store
        check_finite(store.model, store.controls, store.state, store.joints)
        self._check_level()
        of_forces = longest_step_of_forces(store.model, store.controls, store.state, store.joints)
        stable = stable_time_step(store.model, store.controls, store.state, store.settings, of_forces)
        return min(store.settings.substeps * stable, of_forces)

    def contact_points(self) -> ContactPoints:
        """Do what `World.contact_points` says."""
        store = self.store
        given, asleep = store.contents.ground_impulse, store.contents.sleep.rest.asleep
        part = float(store.clock.part[0])
        found = contact_points(store.model, store.state.particle_position, store.contacts, given, part, store.names)
        if not (store.may_sleep and asleep.any() and store.time_step > 0.0):  # 0: no step since it was restored
            return found
        return found.and_of(asleep, self._contacts_if_awake())

    def _contacts_if_awake(self) -> ContactPoints:
        """Return the contacts of the next step if nobody slept in it."""
        store, sleep = self.store, self.store.contents.sleep
        key = sleep.key(store.time_step)
        if self._awake is None or self._awake[0] is not sleep or self._awake[1] != key:
            twin = Runner(store.awake_copy(), self._threads)
            twin.step(store.time_step, allow_unstable=True)
            self._awake = sleep, key, twin.contact_points()
        return self._awake[2]


class Steppable(HasStore, Protocol):
    """A World, as what films, keeps and shows it sees it."""

    @property
    def runner(self) -> Runner:
        """What advances it."""
