"""Looks whether a soft body goes through itself, and says so once: at some steps, as nothing keeps most from it.

Of those that are to hold themselves it looks where somebody has put particles, and whether they have parted.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.bodies.names import MOST_LISTED, Names
from softbody.errors import SelfIntersectionWarning, warn_user
from softbody.geometry.bvh import BVH, Search, build_bvh, refit_bvh, search_space
from softbody.geometry.self_intersections import find_pairs
from softbody.geometry.unfolded import find_unfolded, is_star_shaped
from softbody.mesh.weld import first_at_place
from softbody.model.arrays import Model, is_open
from softbody.stepping.checks import title_of

EARLY = (128, 512)  # steps after which it is looked at, besides each of
PARTED = 32  # steps after each of which those that wait are looked at
EVERY = 2048  # a look takes some 50 steps of a body that is not seen whole from its middle, and a fifth of one if it is


class Skin(NamedTuple):
    """What it takes to look at one soft body."""

    tree: BVH
    search: Search
    memory: np.ndarray  # (2, n, 3)
    unfolded: np.ndarray  # (n,)
    place: np.ndarray  # (n,)
    found: np.ndarray  # (1, 3)


class Skins:
    """The surfaces of all soft bodies."""

    def __init__(self, model: Model) -> None:
        starts, triangles = model.soft_particle_start, model.soft_triangle_start
        self._model = model
        self._triangles = [
            model.triangle_particles[triangles[body] : triangles[body + 1]] - starts[body]
            for body in range(model.soft_count)
        ]
        self._skins: dict[int, Skin] = {}
        whole = (
            body for body in range(model.soft_count) if not is_open(model, body)
        )  # what has torn may fold as it likes
        self._clean: dict[int, int | None] = dict.fromkeys(whole)  # who was not told of → since when

    def look(self, positions: np.ndarray, steps: int, names: Names) -> None:
        """Warn of the bodies that go through themselves at `positions` (n, 3), after `steps`: of each once."""
        found = []
        for body in list(self._clean):
            count, pair = self._meeting(body, positions[self._rows(body)])
            if count:
                found.append((title_of(self._model, body, names), count, pair, self._clean.pop(body)))
            else:
                self._clean[body] = steps
        if found:
            (name, count, (one, other), whole), *others = found
            since = "" if whole is None or whole > steps else f" (and none after step {whole})"
            listed = [f"{each} ({number} pairs)" for each, number, *_ in others[:MOST_LISTED]]
            more = [f"{len(others) - MOST_LISTED} more"] if len(others) > MOST_LISTED else []
            warn_user(
                f"{name} goes through itself: {count} pairs of its triangles meet after step {steps}{since}, such as "
                f"{one} and {other}{'; so do ' if others else ''}{', '.join(listed + more)}. Nothing keeps a surface "
                "from itself unless it is told to: set self_contact = True while it does not meet itself, fill it with "
                "more gas, make it stiffer, or press less",
                SelfIntersectionWarning,
            )

    def hold(self, distance: np.ndarray, positions: np.ndarray, steps: int, names: Names) -> np.ndarray:
        """Return `distance` (b,) of bodies that are to hold themselves, < 0 of those that meet themselves: with a word.

        `positions` (n, 3) are those that step `steps` + 1 begins with. Who waits goes on to wait.
        """
        distance = distance.copy()
        for body in np.flatnonzero(distance > 0.0).tolist():
            count, pair = self._meeting(body, positions[self._rows(body)], may_share=False)
            if count:
                distance[body] = -distance[body]
                self._clean.pop(body, None)
                warn_user(
                    f"{title_of(self._model, body, names)} meets itself before step {steps + 1}: {count} pairs of its "
                    f"triangles, such as {pair[0]} and {pair[1]}. It does not hold itself until they have parted: give "
                    "it the gas for that, or a shape that does not meet itself",
                    SelfIntersectionWarning,
                )
        return distance

    def parted(self, distance: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """Return `distance` (b,), above 0 of those that have waited and do not meet themselves any more."""
        distance = distance.copy()
        for body in np.flatnonzero(distance < 0.0).tolist():
            if not self._meeting(body, positions[self._rows(body)], may_share=False)[0]:
                distance[body] = -distance[body]
        return distance

    def _rows(self, body: int) -> slice:
        return slice(*self._model.soft_particle_start[body : body + 2])

    def _meeting(self, body: int, vertices: np.ndarray, may_share: bool = True) -> tuple[int, np.ndarray]:
        """Return how many pairs of triangles of a body meet, and one of them; they `may_share` places of vertices."""
        triangles = self._triangles[body]
        if is_star_shaped(vertices, triangles):
            return 0, np.empty(0)
        skin = self._skins.get(body)
        if skin is None:
            tree, n = build_bvh(vertices, triangles), len(vertices)
            room = np.empty((2, n, 3)), np.empty(n, bool), np.arange(n), np.empty((1, 3), np.int64)
            skin = self._skins[body] = Skin(tree, search_space(tree), *room)
        refit_bvh(skin.tree, vertices)
        find_unfolded(vertices, triangles, skin.memory, skin.unfolded)
        count = find_pairs(skin.tree, vertices, skin.place, skin.unfolded, skin.search, skin.found)
        if count and may_share:  # perhaps only where two of its surfaces have vertices at the same place
            count = find_pairs(skin.tree, vertices, first_at_place(vertices), skin.unfolded, skin.search, skin.found)
        return count, np.sort(skin.found[0, :2])


def next_look(steps: int, anybody_waits: bool = False) -> int:
    """Return the first step after `steps` after which bodies are looked at."""
    if anybody_waits:
        return (steps // PARTED + 1) * PARTED
    return next((each for each in EARLY if each > steps), (steps // EVERY + 1) * EVERY)


def is_look(step: int) -> bool:
    """Tell whether all bodies are looked at after a step."""
    return step in EARLY or step % EVERY == 0
