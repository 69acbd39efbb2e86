"""Contacts that do not hold: the one that is left deepest after a step, to be told, or for the step to be undone."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.collision.contact import Contacts, Listing
from softbody.compiler.jit import jit_lean
from softbody.linalg.vec import load, norm
from softbody.model.arrays import NOBODY, Model

# How deep sides are left inside each other, as a part of the thickness of the thinner, from which that is told, and
# from which the step is undone: contacts might push out by the wrong side then.
PRESSED, GONE_THROUGH = 0.25, 0.5

FIRST, NOW = 0, 1  # rows of Pressed


class Pressed(NamedTuple):
    """The deepest contact of the first step, since it was cleared, that left one PRESSED; and that of the last step."""

    part: np.ndarray  # (2,) of the thinner side's thickness; 0: there is none, and inf before any step
    depth: np.ndarray  # (2,) [m]
    force: np.ndarray  # (2,) [N] of the contact
    point: np.ndarray  # (2, 3) [m]
    sides: np.ndarray  # (2, 2, 2) box and particle, or NOBODY, on both sides
    step: np.ndarray  # (1,) how many steps were done then


def never_pressed() -> Pressed:
    """Return memory for a world in which nothing was pressed yet."""
    part, depth, force = np.zeros((3, 2))
    part[NOW] = np.inf
    return Pressed(part, depth, force, np.zeros((2, 3)), np.zeros((2, 2, 2), np.int64), np.zeros(1, np.int64))


@jit_lean
def note_pressed(
    pressed: Pressed, contacts: Contacts | Listing, k: int, depth: float, thickness: float, h: float
) -> None:
    """Note contact `k` if it is the deepest, with sides left `depth` [m] inside each other by a step of `h` [s]."""
    if depth > pressed.part[NOW] * thickness:
        pressed.part[NOW], pressed.depth[NOW] = depth / thickness, depth
        pressed.force[NOW] = norm(load(contacts.impulse, k)) / h
        for c in range(3):
            pressed.point[NOW, c] = contacts.point[k, c]
        for side in range(2):
            pressed.sides[NOW, side, 0] = contacts.box[k, side]
            pressed.sides[NOW, side, 1] = contacts.particles[k, side, 0]


@jit_lean
def note_boxes(pressed: Pressed, model: Model, contacts: Contacts, h: float) -> None:
    """Note boxes that were pressed into each other or the ground when a step of `h` [s] ended."""
    for k in range(contacts.number[1]):
        thickness = np.inf
        for side in range(2):
            box = contacts.box[k, side]
            if box != NOBODY:
                thickness = min(thickness, model.box_size[box, 0], model.box_size[box, 1], model.box_size[box, 2])
        note_pressed(pressed, contacts, k, contacts.depth[k], thickness, h)


@jit_lean
def keep_first(pressed: Pressed, steps: int) -> None:
    """Keep what the last of so many `steps` has left PRESSED, unless an earlier one was kept."""
    if pressed.part[NOW] > PRESSED and pressed.part[FIRST] == 0.0:
        pressed.part[FIRST], pressed.depth[FIRST] = pressed.part[NOW], pressed.depth[NOW]
        pressed.force[FIRST], pressed.step[0] = pressed.force[NOW], steps
        for c in range(3):
            pressed.point[FIRST, c] = pressed.point[NOW, c]
        for side in range(2):
            for c in range(2):
                pressed.sides[FIRST, side, c] = pressed.sides[NOW, side, c]
