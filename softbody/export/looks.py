"""Titles and colours of bodies in exported files, as in pictures."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.model.colours import STATIC, Colour, colour_of
from softbody.model.shapes import Labels

GAMMA = 2.2  # files have shares of light, pictures what a screen is told


class Look(NamedTuple):
    """Of one body."""

    title: str  # no other's
    colour: Colour  # red, green and blue as shares of light


class Looks(NamedTuple):
    """Of all bodies, in order of their numbers."""

    soft: list[Look]
    boxes: list[Look]


def looks_of(labels: Labels) -> Looks:
    """Return how bodies look: by their names, or `soft_body_0`, `box_0` and so on, where none has that as its name."""
    taken = {*labels.soft, *labels.box}

    def look(name: str, number: str, colour: Colour) -> Look:
        title = name or number
        while not name and title in taken:
            title += "_"
        return Look(title, tuple((np.array(colour) ** GAMMA).tolist()))

    soft = [look(name, f"soft_body_{k}", colour_of(k)) for k, name in enumerate(labels.soft)]
    colours = [STATIC if is_held else colour_of(len(soft) + k) for k, is_held in enumerate(labels.held)]
    boxes = [look(name, f"box_{k}", colour) for k, (name, colour) in enumerate(zip(labels.box, colours))]
    return Looks(soft, boxes)
