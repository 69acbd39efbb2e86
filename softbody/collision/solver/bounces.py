"""Bounces that follow from each other within a step: a box strikes with a corner, turns by that, and strikes with more.

Struck together, a corner that the first impulse drives down would only be stopped, and its energy lost. So impacts
follow each other, as in Newton's law: all that closes bounces, then all that closes by that, until nothing does. What
comes of it are the speeds at which the contacts are to part, and impulses to start from.

A contact parts with e times the speed at which it closed *before* the step's gravity and forces: so what rests does not
hop, and a ball of e = 1 keeps its energy to the last bit.
"""

from __future__ import annotations

import numpy as np

from softbody.collision.contact import Contacts
from softbody.collision.solver.solver_row import (
    APPROACH,
    MASS,
    NORMAL,
    NORMAL_IMPULSE,
    POSITION_IMPULSE,
    TARGET,
    apply_impulse,
    load_pair,
    speed_along,
)
from softbody.compiler.jit import jit, jit_lean
from softbody.model.material import speed_after

# Impacts up to SLOW times what is worth a sweep make no others: that is four times the speed that gravity gives in a
# step. A box that is held gives about so much to what lies on it.
SLOW = 4e4
MOST_TURNS = 32  # impacts one after the other in a step; e < 1 ends them sooner
LEAST_SWEEPS = 1000  # over what bounces at once, that may be made where a step has fewer
CLOSE = 1e-12  # the part of the fastest bounce that is not worth another sweep


@jit
def set_targets(contacts: Contacts, motion: np.ndarray, h: float, enough: float, iterations: int) -> None:
    """Set the speed at which each contact is to part; `motion` (m + 1, 6) is before all impulses.

    A contact that closes within `h` [s] bounces, as do those that close by that. A gap that stays open may close, but
    no further. Speeds below `enough` [m/s] count as none, and do not make others bounce up to SLOW times that. Up to
    `iterations` sweeps, or LEAST_SWEEPS, find what bounces at once gives.
    """
    row, number = contacts.row, contacts.number[1]
    for k in range(number):
        row[k, TARGET] = -_gap(contacts, k, enough * h) / h
        row[k, NORMAL_IMPULSE] = 0.0
    given, struck = np.zeros(motion.shape), np.empty(number, np.int64)
    count, fastest = _strike(contacts, motion, given, struck, h, enough, 0.0)
    turns, slow = 0, SLOW * enough
    while count and fastest > slow and turns < MOST_TURNS:
        _bounce_together(contacts, struck[:count], motion, given, fastest, max(LEAST_SWEEPS, iterations))
        count, fastest = _strike(contacts, motion, given, struck, h, enough, slow)
        turns += 1
    if turns > 1:
        for k in range(number):
            if contacts.restitution[k] > 0.0:
                row[k, TARGET] = -_gap(contacts, k, enough * h) / h
                if row[k, NORMAL_IMPULSE] > 0.0:
                    parting = _parting_speed(contacts, k, motion) + _parting_speed(contacts, k, given)
                    row[k, TARGET] = max(row[k, TARGET], parting)


@jit_lean
def _gap(contacts: Contacts, k: int, rounding: float) -> float:
    """Return the gap [m] of a contact, 0 if it is no more than `rounding` [m].

    The gaps of a face differ by rounding, and some of its points would hold what others do not, more than a box needs.
    """
    return -contacts.depth[k] if -contacts.depth[k] > rounding else 0.0


@jit_lean
def _approach(contacts: Contacts, k: int, given: np.ndarray) -> float:
    """Return the speed [m/s] at which the bodies of a contact close, but for the step's gravity and forces.

    `given` (m + 1, 6) are the velocities that impulses have given.
    """
    return contacts.row[k, APPROACH] - _parting_speed(contacts, k, given)


@jit_lean
def _parting_speed(contacts: Contacts, k: int, motion: np.ndarray) -> float:
    return speed_along(contacts.row, k, NORMAL, load_pair(motion, contacts.box[k, 0], contacts.box[k, 1]))


@jit
def _strike(
    contacts: Contacts, motion: np.ndarray, given: np.ndarray, struck: np.ndarray, h: float, enough: float, least: float
) -> tuple[int, float]:
    """List in `struck` what closes within the step, faster than `least` [m/s], and set how fast it is to part.

    Returns how many these are, and the fastest speed of parting [m/s]. Velocities are the sum of `motion` and `given`.
    """
    count, fastest = 0, 0.0
    for k in range(contacts.number[1]):
        if contacts.restitution[k] > 0.0:
            approach = _approach(contacts, k, given)
            closing = -(_parting_speed(contacts, k, motion) + _parting_speed(contacts, k, given))
            if approach > least and closing * h > _gap(contacts, k, enough * h):
                contacts.row[k, TARGET] = speed_after(approach, contacts.restitution[k])
                fastest = max(fastest, contacts.row[k, TARGET])
                struck[count] = k
                count += 1
    return count, fastest


@jit
def _bounce_together(
    contacts: Contacts, struck: np.ndarray, motion: np.ndarray, given: np.ndarray, fastest: float, sweeps: int
) -> None:
    """Let all contacts of a list part at their TARGET, the `fastest` [m/s], by impulses that only push.

    What they give in so many `sweeps` is added to `given` (m + 1, 6).
    """
    row = contacts.row
    for place in range(struck.shape[0]):
        row[struck[place], POSITION_IMPULSE] = 0.0
    for _ in range(sweeps):
        most = 0.0
        for place in range(struck.shape[0]):
            k = struck[place]
            before = row[k, POSITION_IMPULSE]
            lack = row[k, TARGET] - _parting_speed(contacts, k, motion) - _parting_speed(contacts, k, given)
            row[k, POSITION_IMPULSE] = max(0.0, before + row[k, MASS] * lack)
            change = row[k, POSITION_IMPULSE] - before
            row[k, NORMAL_IMPULSE] += change
            most = max(most, abs(change) / row[k, MASS])
            if change != 0.0:
                apply_impulse(row, k, NORMAL, change, given, (contacts.box[k, 0], contacts.box[k, 1]))
        if most <= CLOSE * fastest:
            return
