"""Contacts that do not hold: the one that is left deepest after a step, to be told, or for the step to be undone."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.collision.contact import Contacts, Listing
from softbody.compiler.jit import jit_lean
from softbody.linalg.quaternion import load_quaternion, rotate, rotate_inverse
from softbody.linalg.vec import Vec, add, dot, load, norm, sub
from softbody.model.arrays import NOBODY, Model, State

# How deep sides are left inside each other, as a part of the thickness of the thinner, from which that is told, and
# from which the step is undone: contacts might push out by the wrong side then.
PRESSED, GONE_THROUGH = 0.25, 0.5
LASTING = 4  # steps that somebody is PRESSED before one is undone: who hits something fast is parted sooner

FIRST, NOW = 0, 1  # rows of Pressed


class Pressed(NamedTuple):
    """The deepest contact of the first step, since it was cleared, that left one PRESSED; and that of the last step."""

    part: np.ndarray  # (2,) of the thinner side's thickness; 0: there is none, and inf before any step
    depth: np.ndarray  # (2,) [m]
    force: np.ndarray  # (2,) [N] of the contact; of two boxes, of all their contacts
    point: np.ndarray  # (2, 3) [m]
    sides: np.ndarray  # (2, 2, 2) box and particle, or NOBODY, on both sides
    step: np.ndarray  # (1,) how many steps were done then
    lasting: np.ndarray  # (1,) how many of the last steps have left somebody PRESSED


def never_pressed() -> Pressed:
    """Return memory for a world in which nothing was pressed yet."""
    part, depth, force = np.zeros((3, 2))
    part[NOW] = np.inf
    step, lasting = np.zeros((2, 1), np.int64)
    return Pressed(part, depth, force, np.zeros((2, 3)), np.zeros((2, 2, 2), np.int64), step, lasting)


@jit_lean
def note_pressed(
    pressed: Pressed, contacts: Contacts | Listing, k: int, depth: float, thickness: float, force: float
) -> None:
    """Note contact `k`, of some `force` [N], if it is the deepest, with sides left `depth` [m] inside each other."""
    if depth > pressed.part[NOW] * thickness:
        pressed.part[NOW], pressed.depth[NOW], pressed.force[NOW] = depth / thickness, depth, force
        for c in range(3):
            pressed.point[NOW, c] = contacts.point[k, c]
        for side in range(2):
            pressed.sides[NOW, side, 0] = contacts.box[k, side]
            pressed.sides[NOW, side, 1] = contacts.particles[k, side, 0]


@jit_lean
def note_boxes(pressed: Pressed, model: Model, start: State, state: State, contacts: Contacts, h: float) -> None:
    """Note boxes that are pressed into each other or the ground as a step of `h` [s] from `start` ends.

    It has moved them since their contacts were found.
    """
    for k in range(contacts.number[1]):
        thickness, depth = np.inf, contacts.depth[k]
        for side in range(2):
            box = contacts.box[k, side]
            if box != NOBODY:
                thickness = min(thickness, model.box_size[box, 0], model.box_size[box, 1], model.box_size[box, 2])
        if not depth > 0.5 * PRESSED * thickness:
            continue
        point, normal = load(contacts.point, k), load(contacts.normal, k)
        for side in range(2):
            box = contacts.box[k, side]
            if box != NOBODY:
                way = dot(sub(_moved(point, box, start, state), point), normal)
                depth += way if side == 1 else -way
        if depth > pressed.part[NOW] * thickness:
            note_pressed(pressed, contacts, k, depth, thickness, _force_of_pair(contacts, k) / h)


@jit_lean
def _moved(point: Vec, box: int, start: State, state: State) -> Vec:
    """Return where a point of a box [m] has gone since `start`."""
    arm = rotate_inverse(load_quaternion(start.box_orientation, box), sub(point, load(start.box_position, box)))
    return add(load(state.box_position, box), rotate(load_quaternion(state.box_orientation, box), arm))


@jit_lean
def _force_of_pair(contacts: Contacts, k: int) -> float:
    """Return the sum [N s] of the impulses of all contacts of the boxes of contact `k`: the deepest may have none."""
    total = 0.0
    for j in range(contacts.number[1]):
        if contacts.box[j, 0] == contacts.box[k, 0] and contacts.box[j, 1] == contacts.box[k, 1]:
            total += norm(load(contacts.impulse, j))
    return total


@jit_lean
def goes_through(pressed: Pressed, before: float) -> bool:
    """Tell whether a step has pressed bodies past GONE_THROUGH, from a part `before`; who is past it goes on."""
    lasts = pressed.lasting[0] >= LASTING and pressed.force[NOW] > 0.0
    return bool(lasts and before <= GONE_THROUGH < pressed.part[NOW])


@jit_lean
def keep_first(pressed: Pressed, steps: int) -> None:
    """Keep what the last of so many `steps` has left PRESSED, unless an earlier one was kept."""
    is_pressed = PRESSED < pressed.part[NOW] < np.inf and pressed.force[NOW] > 0.0
    pressed.lasting[0] = pressed.lasting[0] + 1 if is_pressed else 0
    if is_pressed and pressed.part[FIRST] == 0.0:
        pressed.part[FIRST], pressed.depth[FIRST] = pressed.part[NOW], pressed.depth[NOW]
        pressed.force[FIRST], pressed.step[0] = pressed.force[NOW], steps
        for c in range(3):
            pressed.point[FIRST, c] = pressed.point[NOW, c]
        for side in range(2):
            for c in range(2):
                pressed.sides[FIRST, side, c] = pressed.sides[NOW, side, c]
