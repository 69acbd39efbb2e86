"""What a contact is, for every kind of pair, and the list of all contacts of a step.

The list counts itself. There is one way to add to it, and one rule where it has no room: what is found is counted all
the same, and whoever fills it asks, makes room for twice as many, and finds once more what did not fit.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit, jit_inlined, jit_lean
from softbody.linalg.vec import Vec, load, store
from softbody.model.arrays import NOBODY
from softbody.model.material import Material
from softbody.model.surface_point import WHOLE, SurfacePoint

SOLVER_ROW = 57  # numbers that the solver of boxes keeps for each contact
LEAST_ROOM = 64


class Side(NamedTuple):
    """One side of a contact: a box, a point of a soft body's surface, or, if it is neither, the ground."""

    box: int  # or NOBODY
    point: SurfacePoint  # its particles are NOBODY if the side is no soft body


class Touch(NamedTuple):
    """Where and how two sides touch."""

    point: Vec  # [m] half-way between the surfaces
    normal: Vec  # unit, from b to a
    depth: float  # [m]; negative for a gap that may close within the step
    feature: int  # what touches what, within a pair of boxes: the same number, the same corner or crossing of edges


GROUND = Side(NOBODY, SurfacePoint((NOBODY, NOBODY, NOBODY), WHOLE))


@jit_lean
def box_side(box: int) -> Side:
    """Return a side that is a box."""
    return Side(box, SurfacePoint((NOBODY, NOBODY, NOBODY), WHOLE))


@jit_lean
def soft_side(point: SurfacePoint) -> Side:
    """Return a side that is a point of a soft body's surface."""
    return Side(NOBODY, point)


class ImpulseCache(NamedTuple):
    """The contacts of the last step, and their impulses, for solvers to start from; in the order of Contacts."""

    number: np.ndarray  # (1,) of them
    soft: np.ndarray  # (1,) how many of them, the last ones, are of soft bodies
    box: np.ndarray  # (c, 2)
    feature: np.ndarray  # (c,)
    point: np.ndarray  # (c, 3) [m]
    impulse: np.ndarray  # (c, 3) [N s] on a, friction included


class Contacts(NamedTuple):
    """The contacts of one step, a row each: first those of boxes, or boxes and the ground, by (a, b); then others.

    Side 0 is a, side 1 is b. Only the first rows are set.
    """

    number: np.ndarray  # (2,) of all contacts found, more perhaps than there are rows; of those of boxes alone
    box: np.ndarray  # (c, 2) on each side, or NOBODY
    particles: np.ndarray  # (c, 2, 3) of the soft body on each side, or NOBODY
    weights: np.ndarray  # (c, 2, 3) barycentric, of the particles; of no meaning where they are NOBODY
    point: np.ndarray  # (c, 3) [m] half-way between the surfaces
    normal: np.ndarray  # (c, 3) unit, from b to a
    depth: np.ndarray  # (c,) [m]; negative for a gap that may close within the step
    feature: np.ndarray  # (c,) what touches what, within a pair of boxes; or of all soft bodies
    restitution: np.ndarray  # (c,) combined
    friction: np.ndarray  # (c,) combined
    impulse: np.ndarray  # (c, 3) [N s] on a in this step, friction included
    row: np.ndarray  # (c, SOLVER_ROW) of solver_row
    cache: ImpulseCache


class Listing(NamedTuple):
    """Some rows of Contacts, for one thread to list what it finds; with the same names."""

    number: np.ndarray  # (1,) of contacts found, more perhaps than there are rows
    box: np.ndarray
    particles: np.ndarray
    weights: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    depth: np.ndarray
    feature: np.ndarray
    restitution: np.ndarray
    friction: np.ndarray
    impulse: np.ndarray


@jit_inlined
def rows_of(contacts: Contacts | Listing, number: np.ndarray, first: int, end: int) -> Listing:
    """Return rows from `first` to `end`, whose `number` (1,) found is counted there."""
    return Listing(
        number,
        contacts.box[first:end],
        contacts.particles[first:end],
        contacts.weights[first:end],
        contacts.point[first:end],
        contacts.normal[first:end],
        contacts.depth[first:end],
        contacts.feature[first:end],
        contacts.restitution[first:end],
        contacts.friction[first:end],
        contacts.impulse[first:end],
    )


@jit_lean
def move_row(contacts: Contacts, k: int, other: Contacts, to: int) -> None:
    """Copy contact `k` to a row of others."""
    for c in range(2):
        other.box[to, c] = contacts.box[k, c]
        for d in range(3):
            other.particles[to, c, d] = contacts.particles[k, c, d]
            other.weights[to, c, d] = contacts.weights[k, c, d]
    store(other.point, to, load(contacts.point, k))
    store(other.normal, to, load(contacts.normal, k))
    other.depth[to], other.feature[to] = contacts.depth[k], contacts.feature[k]
    other.restitution[to], other.friction[to] = contacts.restitution[k], contacts.friction[k]
    store(other.impulse, to, load(contacts.impulse, k))


def new_contacts(capacity: int) -> Contacts:
    """Return no contacts, and nothing in their cache, with room for `capacity`."""
    cache = ImpulseCache(
        np.zeros(1, np.int64),
        np.zeros(1, np.int64),
        np.empty((capacity, 2), np.int64),
        np.empty(capacity, np.int64),
        np.empty((capacity, 3)),
        np.empty((capacity, 3)),
    )
    return Contacts(
        np.zeros(2, np.int64),
        np.empty((capacity, 2), np.int64),
        np.empty((capacity, 2, 3), np.int64),
        np.empty((capacity, 2, 3)),
        np.empty((capacity, 3)),
        np.empty((capacity, 3)),
        np.empty(capacity),
        np.empty(capacity, np.int64),
        np.empty(capacity),
        np.empty(capacity),
        np.empty((capacity, 3)),
        np.empty((capacity, SOLVER_ROW)),
        cache,
    )


new_contacts_in_kernel = jit(new_contacts)  # Python has the plain function, for which nothing is compiled


@jit_lean
def first_of_pair(contacts: Contacts, at: int, end: int, a: int, b: int) -> int:
    """Return the first contact from `at` on, and before `end`, that is not of a pair of bodies before (a, b)."""
    while at < end and (contacts.box[at, 0] < a or (contacts.box[at, 0] == a and contacts.box[at, 1] < b)):
        at += 1
    return at


@jit_lean
def sort_in(contacts: Contacts, first: int, spare: Contacts) -> None:
    """Put the contacts of boxes from `first` on where they belong among those before, by (a, b); `spare` has a row."""
    for k in range(first, contacts.number[0]):
        move_row(contacts, k, spare, 0)
        a, b, to = spare.box[0, 0], spare.box[0, 1], k
        while to > 0 and (
            contacts.box[to - 1, 0] > a or (contacts.box[to - 1, 0] == a and contacts.box[to - 1, 1] > b)
        ):
            move_row(contacts, to - 1, contacts, to)
            to -= 1
        move_row(spare, 0, contacts, to)


@jit_lean
def add_contact(contacts: Contacts | Listing, a: Side, b: Side, touch: Touch, material: Material) -> None:
    """Add a contact; if there is no room for it, it is counted only."""
    k = contacts.number[0]
    contacts.number[0] += 1
    if k >= contacts.depth.shape[0]:
        return
    _write_side(contacts.box, contacts.particles, contacts.weights, (k, 0), a)
    _write_side(contacts.box, contacts.particles, contacts.weights, (k, 1), b)
    store(contacts.point, k, touch.point)
    store(contacts.normal, k, touch.normal)
    contacts.depth[k], contacts.feature[k] = touch.depth, touch.feature
    contacts.restitution[k], contacts.friction[k] = material.restitution, material.friction
    store(contacts.impulse, k, (0.0, 0.0, 0.0))


@jit_lean
def _write_side(box: np.ndarray, particles: np.ndarray, weights: np.ndarray, at: tuple[int, int], side: Side) -> None:
    k, which = at
    box[k, which] = side.box
    for c in range(3):
        particles[k, which, c] = side.point.particles[c]
        weights[k, which, c] = side.point.weights[c]


@jit_lean
def surface_point(contacts: Contacts | Listing, k: int, side: int) -> SurfacePoint:
    """Return the point of a soft body's surface that is one side of contact `k`."""
    particles, weights = contacts.particles, contacts.weights
    return SurfacePoint(
        (particles[k, side, 0], particles[k, side, 1], particles[k, side, 2]),
        (weights[k, side, 0], weights[k, side, 1], weights[k, side, 2]),
    )


@jit_lean
def fit(contacts: Contacts) -> bool:
    """Tell whether there was room for all contacts that were found."""
    return bool(contacts.number[0] <= contacts.depth.shape[0])


def remembered(contacts: Contacts) -> ImpulseCache:
    """Return what the cache holds, without the room for more."""
    number, soft, *arrays = contacts.cache
    return ImpulseCache(number, soft, *(rows[: int(number[0])] for rows in arrays))


def remembering(cache: ImpulseCache, least_room: int) -> Contacts:
    """Return no contacts, with as much in their cache as `remembered` gave, and with room for `least_room` at least."""
    contacts = new_contacts(max(least_room, len(cache.box)))
    for rows, kept in zip(contacts.cache, cache, strict=True):
        rows[: len(kept)] = kept
    return contacts


def without_soft(cache: ImpulseCache) -> ImpulseCache:
    """Return what `remembered` gave, without the contacts of soft bodies."""
    boxes = cache.number - cache.soft
    return ImpulseCache(boxes, np.zeros_like(cache.soft), *(rows[: int(boxes[0])] for rows in cache[2:]))


def without_box(cache: ImpulseCache, box: int) -> ImpulseCache:
    """Return what `remembered` gave of boxes, without the contacts of one: those after it are one number lower."""
    cache = without_soft(cache)
    kept = (cache.box != box).all(axis=1)
    left = ImpulseCache(np.array([kept.sum()]), cache.soft, *(rows[kept] for rows in cache[2:]))
    return left._replace(box=left.box - (left.box > box))


@jit
def with_room(contacts: Contacts, kept: int) -> Contacts:
    """Return the first `kept` contacts and the cache, with room for twice as many contacts as were found."""
    longer = new_contacts_in_kernel(max(LEAST_ROOM, 2 * contacts.number[0]))
    longer.number[0], longer.number[1] = kept, contacts.number[1]
    for k in range(kept):
        move_row(contacts, k, longer, k)
        for c in range(SOLVER_ROW):
            longer.row[k, c] = contacts.row[k, c]
    longer.cache.number[0], longer.cache.soft[0] = contacts.cache.number[0], contacts.cache.soft[0]
    for k in range(contacts.cache.number[0]):
        longer.cache.box[k, 0], longer.cache.box[k, 1] = contacts.cache.box[k, 0], contacts.cache.box[k, 1]
        longer.cache.feature[k] = contacts.cache.feature[k]
        store(longer.cache.point, k, load(contacts.cache.point, k))
        store(longer.cache.impulse, k, load(contacts.cache.impulse, k))
    return longer
