"""Boxes that are pinched: by two or more things that cannot move, so that contacts may ask for what cannot be."""

from __future__ import annotations

import numpy as np

from softbody.collision.contact import Contacts
from softbody.collision.solver.solver_row import INVERSE_A, INVERSE_B
from softbody.compiler.jit import jit, jit_lean
from softbody.model.arrays import NOBODY

NOTHING, MANY = -2, -3  # hold a box; what cannot move holds itself, and the ground is NOBODY


@jit
def holds_pinched(contacts: Contacts, bodies: int, column: int) -> np.ndarray:
    """Return the contacts between something that cannot move and a box that it pinches, with something else.

    Both press on it, or on what presses on it: the impulse in a `column` of the contacts' rows is not 0.
    """
    holder, changed = np.full(bodies, NOTHING), True
    while changed:
        changed = False
        for k in range(contacts.number[1]):
            if contacts.row[k, column] > 0.0:
                a, b = contacts.box[k, 0], contacts.box[k, 1]
                of_a = holder[a] if contacts.row[k, INVERSE_A] > 0.0 else a
                of_b = holder[b] if contacts.row[k, INVERSE_B] > 0.0 else b
                both = of_b if of_a == NOTHING else of_a if of_b == NOTHING or of_a == of_b else MANY
                for side in range(2):
                    box = contacts.box[k, side]
                    if _moves(contacts, k, side) and holder[box] != both:
                        holder[box], changed = both, True
    found, count = np.empty(contacts.number[1], np.int64), 0
    for k in range(contacts.number[1]):
        for side in range(2):
            is_held = _moves(contacts, k, side) and not _moves(contacts, k, 1 - side)
            if is_held and holder[contacts.box[k, side]] == MANY:
                found[count] = k
                count += 1
    return found[:count]


@jit_lean
def _moves(contacts: Contacts, k: int, side: int) -> bool:
    """Tell whether a side of contact `k` is a box that can move."""
    return bool(contacts.box[k, side] != NOBODY and contacts.row[k, INVERSE_A if side == 0 else INVERSE_B] > 0.0)
