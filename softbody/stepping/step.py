"""One time step of a whole world, read top to bottom, and a run of many."""

from __future__ import annotations

from math import inf, isfinite
from typing import NamedTuple

import numpy as np

from softbody.collision.boxes.box_contacts import find_box_contacts
from softbody.collision.boxes.manifold import Manifold
from softbody.collision.contact import Contacts
from softbody.collision.paper.paper_response import resolve_in_turn
from softbody.collision.pressed import NOW, Pressed, goes_through, keep_first, note_boxes
from softbody.collision.soft.skin import Skin, find_self_contacts, forget, keep_whole
from softbody.collision.soft.soft_contacts import find_soft_contacts
from softbody.collision.soft.soft_response import (
    Bodies,
    note_on_ground,
    press_on_ground,
    resolve_contacts,
)
from softbody.collision.soft.soft_warm_start import keep_impulses, start_from_last_step
from softbody.collision.soft.split_steps import MOST_PARTS, closes_too_far, subdivision
from softbody.collision.soft.surface import Surfaces
from softbody.collision.solver.warm_start import cache_impulses, copied_cache, copy_cache
from softbody.compiler.jit import jit, jit_inlined, jit_lean
from softbody.dynamics.acting import Acting, all_that_acts
from softbody.dynamics.particle_ground import material_on_ground, resolve_ground
from softbody.dynamics.rigid_boxes import diverged_box, limit_boxes, limit_speeds, slow_boxes, stop_boxes
from softbody.dynamics.soft_bodies import BARE, COLLAPSED, DIVERGED, Motion, move_in_place, move_soft_bodies
from softbody.linalg.vec import load, sub
from softbody.model.arrays import (
    NOBODY,
    Clock,
    Controls,
    Joints,
    Model,
    State,
    boxes_of,
    copied,
    copy_state,
    particles_of,
    soft_bodies_of,
)
from softbody.model.settings import Settings
from softbody.model.sleep_state import SleepState
from softbody.stepping.finite_check import begins_finite, checksum
from softbody.stepping.move_boxes import hold_boxes, move_boxes, move_boxes_singly
from softbody.stepping.sleep import begin_step, let_sleep, mark_sleepers, note_rest, wake_changed
from softbody.stepping.tears import Tearing, leak_and_look
from softbody.stepping.watched import give_room, note_places, stays_whole, take_room

# Faults beside DIVERGED and COLLAPSED, of runs that begin or end before a step is taken.
NO_ROOM = 3  # there are more contacts than rows for them
UNSEEN = 4  # something is not finite, or particles are not where the last run has left them: to be looked at first
ABORTED = 5  # an interrupt ended the step before it was done
PRESSED_THROUGH = 7  # two bodies would be pressed half through each other: which is in `work.pressed`
NO_ROOM_FOR_PAIRS = 8  # there are more near features than there is room for in `work.skin`
TOO_FAR = 6  # a load has pressed something so far into something else that the step is to be taken in more parts


class Work(NamedTuple):
    """What a step needs besides what it is a function of: structures that follow the bodies, and memory.

    Where there are no boxes, or no soft bodies, what is theirs is None, and nothing of it is compiled.
    """

    motion: Motion | None
    surfaces: Surfaces | None
    skin: Skin | None  # None: no soft body holds itself
    manifold: Manifold | None
    start: State  # of the step
    grounded: np.ndarray | None  # (m,) of bool: which boxes touch the ground
    ground_impulse: np.ndarray  # (n, 3) [N s] of the ground on each particle in the last step
    joints: Joints | None
    acting: Acting | None  # memory for what acts in a step with joints or liquids; None: there are none
    rest: SleepState | None  # None: nobody may sleep
    stop: np.ndarray  # (1,) what is not 0 ends a run early; somebody else may write it
    pressed: Pressed
    tearing: Tearing


class Order(NamedTuple):
    """What a run of kernels is to do: the part of a user's call that is left."""

    h: float  # [s] of a step
    steps: int
    begun_steps: int  # what the clock showed when the call began
    begun_time: float  # [s]
    is_seen: bool  # what the run begins with was looked at, and is good
    abort_mid_step: bool  # a run that is to stop may do so in the midst of a step


@jit_inlined
def step(
    model: Model,
    controls: Controls,
    state: State,
    work: Work,
    contacts: Contacts,
    settings: Settings,
    h: float,
    abort_mid_step: bool,
    may_part: bool,
) -> tuple[Contacts, int, int]:
    """Advance a world by `h` [s]; return (contacts, fault, body), boxes numbered after soft bodies.

    The contacts are those of this step, in longer arrays if there was no room for all. On a fault (DIVERGED, COLLAPSED,
    TOO_FAR, NO_ROOM_FOR_PAIRS or ABORTED, else 0) the step must be undone, to `work.start`. It is ABORTED, with the
    contacts as they were, only if `abort_mid_step` is true and `work.stop` is not 0 while soft bodies move; TOO_FAR
    only if it `may_part`.
    """
    begin_step(model, state, work.start, work.ground_impulse, work.rest)
    slow_boxes(model, state, work.grounded, h)
    controls = all_that_acts(model, controls, state, work.motion, work.joints, work.acting, settings, h)
    bodies = soft_bodies_of(model, controls, state)
    done, fault, body = move_in_place(bodies, work.motion, settings, h, abort_mid_step)
    if fault or done == 0:
        return contacts, fault or ABORTED, body
    contacts.number[0] = contacts.number[1] = 0
    if not settings.single_contact:
        contacts = find_box_contacts(model, controls, state, work.manifold, contacts, settings, h)
    if settings.single_contact:
        move_boxes_singly(model, controls, state, work.grounded, settings, h)
    else:
        contacts = move_boxes(model, controls, state, work.grounded, work.manifold, contacts, settings, h)
    limit_boxes(model, state, settings, work.grounded)
    diverged = -1 if work.grounded is None else diverged_box(model, state, h)
    if diverged >= 0:
        return contacts, DIVERGED, model.soft_count + diverged
    if not settings.single_soft_contact:  # first: what contacts press on the ground, that holds
        resolve_ground(model, state, work.ground_impulse, work.rest, True)
    before = state if settings.single_soft_contact else work.start
    contacts = find_soft_contacts(model, state, before, work.surfaces, work.rest, settings, contacts)
    contacts, has_room = find_self_contacts(model, state, work.start, work.surfaces, work.skin, work.rest, contacts)
    if not has_room:
        return contacts, NO_ROOM_FOR_PAIRS, -1
    if may_part and closes_too_far(model, state, work.start, contacts, h):
        return contacts, TOO_FAR, -1
    if not settings.single_soft_contact:
        start_from_last_step(contacts, work.surfaces)
    if not settings.single_contact:
        cache_impulses(contacts)  # not sooner: had there been no room, the step might have to be undone
    push = resolve_soft_contacts(model, state, work.start, work.surfaces, contacts, settings, h)
    if not settings.single_soft_contact:
        keep_impulses(contacts, work.surfaces)
    hold_boxes(model, controls, state, work.grounded, contacts, push, settings, h)
    if work.grounded is not None:
        limit_speeds(model, state, settings)  # once more: soft bodies have pushed boxes since
    press_through(model, state, work.surfaces, contacts, work.ground_impulse)
    resolve_ground(model, state, work.ground_impulse, work.rest, settings.single_soft_contact)
    keep_whole(model, state, work.start, work.surfaces, work.skin, work.rest, h)
    diverged = _diverged_by_contacts(model, state, work, contacts, h)
    if diverged >= 0:
        contacts.cache.number[0] = contacts.cache.soft[0] = 0
        return contacts, DIVERGED, diverged
    stop_boxes(state, work.grounded)
    return contacts, 0, -1


@jit
def press_through(
    model: Model, state: State, surfaces: Surfaces | None, contacts: Contacts, impulse: np.ndarray
) -> None:
    """Let the ground bear what contacts have pressed particles on to it with; it is added to `impulse` (n, 3) [N s]."""
    if surfaces is not None:
        press_on_ground(contacts, model, state, impulse, surfaces.response)


@jit_lean
def _diverged_by_contacts(model: Model, state: State, work: Work, contacts: Contacts, h: float) -> int:
    """Return a body that the contacts of soft bodies have thrown out of all bounds, or −1."""
    first, end = contacts.number[1], contacts.number[0]
    thrown = _soft_body_out_of_bounds(model, state, work.start, work.motion, contacts, h)
    if thrown >= 0:
        return thrown
    diverged = diverged_box(model, state, h) if end > first else -1
    return -1 if diverged < 0 else model.soft_count + diverged


@jit_lean
def _soft_body_out_of_bounds(
    model: Model, state: State, start: State, motion: Motion | None, contacts: Contacts, h: float
) -> int:
    """Return a soft body of which contacts have thrown a particle out of all bounds, or −1.

    Out of numbers, or in this step of `h` [s], or by its speed, farther than the body may be long: in the next one the
    body is that long.
    """
    if motion is None:
        return -1
    first, end = contacts.number[1], contacts.number[0]
    longest = motion.memory.most_extent
    shortest = inf
    for body in range(longest.shape[0]):
        shortest = min(shortest, longest[body])
    for k in range(first, end):
        for side in range(2):
            for c in range(3):
                i = contacts.particles[k, side, c]
                if i != NOBODY:
                    x, v = load(state.particle_position, i), load(state.particle_velocity, i)
                    way = sub(x, load(start.particle_position, i))
                    fast = h * max(abs(v[0]), abs(v[1]), abs(v[2]))
                    far = max(fast, abs(way[0]), abs(way[1]), abs(way[2]))
                    is_finite = isfinite(x[0] + x[1] + x[2] + v[0] + v[1] + v[2])
                    if not (is_finite and far <= shortest):
                        body = 0
                        while model.soft_particle_start[body + 1] <= i:
                            body += 1
                        if not (is_finite and far <= longest[body]):
                            return body
    return -1


@jit
def resolve_soft_contacts(
    model: Model,
    state: State,
    start: State,
    surfaces: Surfaces | None,
    contacts: Contacts,
    settings: Settings,
    h: float,
) -> np.ndarray | None:
    """Resolve the contacts of soft bodies that a step of `h` [s] has led to, together or in turn.

    Returns (m, 6), (0, 6) or None: the pushes on boxes that what they stand on is to hold, see `resolve_contacts`.
    """
    if surfaces is None:
        return None
    now = Bodies(particles_of(model, state), boxes_of(model, state))
    if settings.single_soft_contact:
        resolve_in_turn(contacts, now)
        return np.empty((0, 6))
    before = Bodies(particles_of(model, start), boxes_of(model, start))
    note_on_ground(contacts, model, state, surfaces.response)
    return resolve_contacts(contacts, now, before, surfaces.response, h, surfaces.threads, surfaces.with_boxes)


@jit
def run(
    model: Model,
    controls: Controls,
    state: State,
    work: Work,
    contacts: Contacts,
    settings: Settings,
    clock: Clock,
    order: Order,
) -> tuple[int, int]:
    """Advance any world by the steps of an order, and its clock; return (fault, body).

    Where bodies would jump through each other, or boxes are small, a step is taken in equal parts. On a fault the state
    is that of the last good step. Unless what it begins with `is_seen` to be good, no step is taken where it may not
    be: the fault is UNSEEN. Where there is no room for all contacts it is NO_ROOM, and "body" is how many rows there
    must be. Where `work.stop` is not 0, the run ends after the step, or with `abort_mid_step` in its midst; and so it
    does after a step in which something has torn.

    The time is counted from when the call began, so that it is the same to the last bit, however many runs it takes.
    All that changes is written to the arrays that are given: what a kernel returns is lost where a signal is handled
    before Python has kept it.
    """
    h, abort_mid_step = order.h, order.abort_mid_step
    if not (order.is_seen or _looks_as_left(controls, state, clock)):
        return UNSEEN, -1
    wake_changed(model, controls, state, work.joints, work.rest)
    done, fault, body = 0, 0, -1
    diverged = -1 if work.grounded is None else diverged_box(model, state, h)
    if diverged >= 0:
        fault, body = DIVERGED, model.soft_count + diverged
    # What a step in parts goes back to. (Names that are bound in every step would be counted in every step.)
    start, cache = work.start, contacts.cache
    room = contacts.depth.shape[0]
    while fault == 0 and done < order.steps:
        # In how many parts is the step taken? In none, where everybody sleeps.
        parts = 1
        if let_sleep(model, state, work.joints, work.rest, settings, h):
            parts = 0
        elif settings.split_steps:
            parts = subdivision(model, controls, state, work.rest, h)
        begun, part, may_part = False, 0, settings.split_steps and not settings.single_soft_contact
        while part < parts:
            if parts > 1 and not begun:
                start, cache, begun = copied(state), copied_cache(contacts.cache), True
            may_abort = abort_mid_step and part == 0  # later the contacts are not as they were
            deepest, work.pressed.part[NOW] = work.pressed.part[NOW], 0.0
            found, fault, body = step(
                model, controls, state, work, contacts, settings, h / parts, may_abort, may_part and parts < MOST_PARTS
            )
            part += 1
            if fault == COLLAPSED and work.skin is not None and may_part and parts < MOST_PARTS:
                fault = TOO_FAR  # in shorter parts, what holds a surface from itself may act before nothing is left
            if fault == 0:
                note_boxes(work.pressed, model, work.start, state, found, h / parts)
                fault = PRESSED_THROUGH if goes_through(work.pressed, deepest) else 0
            if found.depth.shape[0] > room:
                fault, body = NO_ROOM, found.depth.shape[0]
            elif fault == TOO_FAR:  # once more from the start, in twice as many parts
                copy_state(start if begun else work.start, state)
                if begun:
                    copy_cache(cache, contacts.cache)
                    forget(work.skin)
                parts, part, fault = 2 * parts, 0, 0
                work.pressed.part[NOW] = deepest
            if fault:
                work.pressed.part[NOW] = deepest
                break
        # A step that cannot be finished has not happened.
        if fault:
            copy_state(start if begun else work.start, state)
            forget(work.skin)
            if begun:
                copy_cache(cache, contacts.cache)
            if fault != ABORTED:
                contacts.number[0] = contacts.number[1] = 0
            break
        clock.part[0] = h / parts if parts > 0 else h
        note_rest(model, state, work.rest, settings, h)
        done += 1
        keep_first(work.pressed, clock.steps[0] + done)
        if leak_and_look(model, controls, state, work.tearing, h) or work.stop[0] != 0:
            break
    mark_sleepers(model, controls, state, work.joints, work.rest)
    _advance_clock(clock, order, done, state)
    return (0, -1) if fault == ABORTED else (fault, body)


@jit
def run_alone(
    model: Model,
    controls: Controls,
    state: State,
    motion: Motion,
    settings: Settings,
    h: float,
    steps: int,
    abort_mid_step: bool = False,
) -> tuple[int, int, int]:
    """Advance a world of one soft body, and perhaps the ground, by `steps` steps of `h` [s].

    Returns (steps done, fault, soft body), like `run`, with the same result, but is compiled in a third of the time.
    """
    bodies, material = soft_bodies_of(model, controls, state), BARE
    if model.soft_count == 1:
        material = material_on_ground(model, 0)
    return move_soft_bodies(bodies, motion, settings, h, steps, model.ground_height, material, abort_mid_step)


@jit
def run_alone_by_clock(
    model: Model,
    controls: Controls,
    state: State,
    motion: Motion,
    surfaces: Surfaces | None,
    skin: Skin | None,
    settings: Settings,
    clock: Clock,
    order: Order,
    ground_impulse: np.ndarray,
    joints: Joints | None,
    acting: Acting | None,
    tearing: Tearing,
) -> tuple[int, int]:
    """Advance a world of one soft body like `run_alone`, and its clock, like `run`; return (fault, body).

    The last step is taken by itself, so that it is known what the ground gave: `ground_impulse` (n, 3) [N s]; and each
    is where there is memory for liquids, that are `acting` anew in each. With a `skin` the run ends, without a fault,
    before a step in which the body may touch itself, or has a fault. It ends after one in which something has torn.
    """
    h, steps, abort_mid_step = order.h, order.steps, order.abort_mid_step
    if not (order.is_seen or _looks_as_left(controls, state, clock)):
        return UNSEEN, -1
    done, fault, body = 0, 0, -1
    while done < steps and fault == 0 and give_room(model, state, surfaces, skin, motion.watch):
        left = max(1, steps - 1 - done) if acting is None else 1
        acts = all_that_acts(model, controls, state, motion, joints, acting, settings, h)
        if done < steps - 1:
            made, fault, body = run_alone(model, acts, state, motion, settings, h, left, abort_mid_step)
        else:
            bodies = soft_bodies_of(model, acts, state)
            motion.watch.room[:] = inf  # what it does then counts where the ground has acted
            note_places(skin, state)
            made, fault, body = move_soft_bodies(bodies, motion, settings, h, 1, -inf, BARE, abort_mid_step)
            if made == 1:
                resolve_ground(model, state, ground_impulse, None, True)
                made = 1 if stays_whole(model, state, surfaces, skin) else 0
                if made == 1:
                    leak_and_look(model, controls, state, tearing, h)
        take_room(skin, motion.watch, made, made < left)
        done += made
        if made == 0 or tearing.is_torn[0] or motion.memory.stop[0] != 0:
            break
    clock.part[0] = h
    _advance_clock(clock, order, done, state)
    return (0, -1) if skin is not None else (fault, body)


@jit_lean
def _looks_as_left(controls: Controls, state: State, clock: Clock) -> bool:
    """Tell whether all is finite, and the particles are where the last run has left them."""
    return clock.shape[0] == checksum(state.particle_position) and begins_finite(controls, state)


@jit_lean
def _advance_clock(clock: Clock, order: Order, done: int, state: State) -> None:
    """Count the steps of an order that are done, and note where they have led to."""
    clock.shape[0] = checksum(state.particle_position)
    clock.steps[0] += done
    clock.time[0] = order.begun_time + (clock.steps[0] - order.begun_steps) * order.h
