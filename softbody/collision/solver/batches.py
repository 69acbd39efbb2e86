"""Batches of pairs of boxes solved side by side, in lanes, as if one after the other.

Pairs without a body in common that can move do not know of each other: eight of them are a batch. A body's pairs stay
in their order, so the result is that of one pair at a time, to the last bit.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.collision.contact import SOLVER_ROW, Contacts
from softbody.collision.solver.solver_row import INVERSE_A, INVERSE_B, MASS, NORMAL_IMPULSE, TANGENT_MASS
from softbody.compiler.jit import jit, jit_lean
from softbody.compiler.simd import LANES

MOTION = 6  # numbers of a body: v and ω
FRICTION = SOLVER_ROW  # column of the coefficient, after those of `solver_row`
COLUMNS = SOLVER_ROW + 1


class Batches(NamedTuple):
    """Contacts by batches: a pair in each lane, and its contacts one after the other in the slots of the batch.

    Lanes and slots that are left over have nobody's bodies, and rows that do nothing.
    """

    start: np.ndarray  # (t + 1,) first slot of each batch
    body: np.ndarray  # (t, 2, 8) uint32: where a's motion, and b's, begins among those of all bodies
    share: np.ndarray  # (t, 2, 8) inverse masses [1/kg]
    row: np.ndarray  # (slots, COLUMNS, 8) as the solver keeps them, and FRICTION
    place: np.ndarray  # (c,) of each contact: 8 times its slot, and its lane


@jit
def batches_of(contacts: Contacts, pairs: np.ndarray, bodies: int) -> Batches:
    """Return the contacts in batches; `pairs` (p, 2), of as many `bodies`, in the order in which they are solved."""
    batch, lane, start = _schedule(contacts, pairs, bodies)
    number = start.shape[0] - 1
    body = np.full((number, 2, LANES), np.uint32(MOTION * bodies))
    share = np.zeros((number, 2, LANES))
    row = np.zeros((start[number], COLUMNS, LANES))
    row[:, MASS] = row[:, TANGENT_MASS] = 1.0
    place = np.empty(contacts.number[1], np.int64)
    for pair in range(pairs.shape[0]):
        first, t, s = pairs[pair, 0], batch[pair], lane[pair]
        for side in range(2):
            i = contacts.box[first, side]
            body[t, side, s] = MOTION * (i if i >= 0 else bodies)
            share[t, side, s] = contacts.row[first, INVERSE_A if side == 0 else INVERSE_B]
        for k in range(first, pairs[pair, 1]):
            slot = start[t] + k - first
            place[k] = LANES * slot + s
            for c in range(SOLVER_ROW):
                row[slot, c, s] = contacts.row[k, c]
            row[slot, FRICTION, s] = contacts.friction[k]
    return Batches(start, body, share, row, place)


@jit
def _schedule(contacts: Contacts, pairs: np.ndarray, bodies: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the batch (p,) and the lane (p,) of each pair, and the first slot (t + 1,) of each batch.

    Each pair is in the first batch with room after those of its bodies that can move.
    """
    number = pairs.shape[0]
    batch, lane = np.empty(number, np.int64), np.empty(number, np.int64)
    filled, slots = np.zeros(number + 1, np.int64), np.zeros(number + 1, np.int64)
    least = np.zeros(bodies + 1, np.int64)  # the first batch that may have a body
    used = full = 0  # batches; and as many of them, the first ones, have no room
    for pair in range(number):
        first, end = pairs[pair, 0], pairs[pair, 1]
        a, b = contacts.box[first, 0], contacts.box[first, 1]
        t = max(full, least[a], least[b])
        while filled[t] == LANES:
            t += 1
        batch[pair], lane[pair] = t, filled[t]
        filled[t] += 1
        slots[t] = max(slots[t], end - first)
        used = max(used, t + 1)
        while filled[full] == LANES:
            full += 1
        if contacts.row[first, INVERSE_A] > 0.0:
            least[a] = t + 1
        if contacts.row[first, INVERSE_B] > 0.0:
            least[b] = t + 1
    start = np.zeros(used + 1, np.int64)
    for t in range(used):
        start[t + 1] = start[t] + slots[t]
    return batch, lane, start


@jit_lean
def take_impulses(contacts: Contacts, batches: Batches) -> None:
    """Write the impulses of the batches to the solver's row of each contact."""
    for k in range(contacts.number[1]):
        slot, s = batches.place[k] // LANES, batches.place[k] % LANES
        for d in range(3):
            contacts.row[k, NORMAL_IMPULSE + d] = batches.row[slot, NORMAL_IMPULSE + d, s]
