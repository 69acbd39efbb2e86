"""Film of bodies that come and go: who is in it, and from which frame to which."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from softbody.errors import ParameterError
from softbody.export.looks import Look, looks_of
from softbody.export.meshes import Shown, box_shown, soft_shown
from softbody.model.shapes import Cast, Pose

Body = tuple[bool, int]  # whether it is soft, and its number


@dataclass
class Actor:
    """A body, in all frames from its first to its last: it has the same mesh in them, perhaps another number."""

    look: Look  # its title is no other's
    is_soft: bool
    start: int  # first frame
    numbers: list[int] = field(default_factory=list)  # in each frame from then on

    @property
    def stop(self) -> int:
        """Frame after its last."""
        return self.start + len(self.numbers)

    def number(self, frame: int) -> int | None:
        """Return its number in a frame, None if it is not there."""
        return self.numbers[frame - self.start] if self.start <= frame < self.stop else None

    def shown(self, cast: Cast, pose: Pose, frame: int) -> Shown:
        """Return how it looks in a frame in which it is."""
        of_its_kind = soft_shown if self.is_soft else box_shown
        return of_its_kind(self.look, cast.shapes, pose, self.numbers[frame - self.start])

    def changes(self, frames: int) -> dict[int, bool]:
        """Return from which of all frames on it is there or not; nothing, if it always is."""
        if len(self.numbers) == frames:
            return {}
        after = {self.stop: False} if self.stop < frames else {}
        return {0: self.start == 0, self.start: True} | after


def actors_of(casts: Sequence[Cast]) -> list[Actor]:
    """Return who is in a film whose frames have these bodies, each frame of a segment the same object.

    A body that is in two segments in a row is one actor, if it can be told: by its name and its mesh. What has no name
    is told by its number, if all bodies of its kind that were there before still are, and have the same meshes.
    """
    actors, titles, before = list[Actor](), set[str](), dict[Body, Actor]()
    for k, cast in enumerate(casts):
        if k == 0 or cast is not casts[k - 1]:
            there = _same_bodies(casts[k - 1], cast) if k else {}
            now = {body: before[there[body]] for body in there}
            for body, look in _looks(cast).items():
                if body not in now:
                    title = _untaken(look.title, k, titles)
                    now[body] = Actor(look._replace(title=title), body[0], k)
                    titles.add(title)
                    actors.append(now[body])
            before = now
        for (_, number), actor in before.items():
            actor.numbers.append(number)
    if not actors:
        raise ParameterError("there are no bodies to export; add one first")
    return actors


def _looks(cast: Cast) -> dict[Body, Look]:
    looks = looks_of(cast.labels)
    return {
        (is_soft, k): look
        for is_soft, each in ((True, looks.soft), (False, looks.boxes))
        for k, look in enumerate(each)
    }


def _untaken(title: str, frame: int, titles: set[str]) -> str:
    """Return a title that no other has."""
    if title in titles:
        title = f"{title} from frame {frame}"
    while title in titles:
        title += "_"
    return title


def _same_bodies(before: Cast, now: Cast) -> dict[Body, Body]:
    """Return which bodies are which of before, as far as can be told."""
    found = dict[Body, Body]()
    for is_soft, names, names_then in (
        (True, now.labels.soft, before.labels.soft),
        (False, now.labels.box, before.labels.box),
    ):
        then = {name: k for k, name in enumerate(names_then) if name}
        numbers_stay = len(names) >= len(names_then) and all(
            names[k] == name and _is_same_mesh(before, k, now, k, is_soft) for k, name in enumerate(names_then)
        )
        for k, name in enumerate(names):
            other = then.get(name) if name else k if numbers_stay and k < len(names_then) else None
            if other is not None and _is_same_mesh(before, other, now, k, is_soft):
                found[is_soft, k] = is_soft, other
    return found


def _is_same_mesh(one: Cast, i: int, other: Cast, j: int, is_soft: bool) -> bool:
    a, b = one.shapes, other.shapes
    if not is_soft:
        return np.array_equal(a.box_size[i], b.box_size[j])
    rows, others = a.particles(i), b.particles(j)
    is_as_large = rows.stop - rows.start == others.stop - others.start
    return is_as_large and np.array_equal(a.triangles(i), b.triangles(j))
