"""Contacts of the last step as a user reads them: bodies, points, normals, depths and impulses."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from softbody.bodies.body import Body
from softbody.bodies.names import Names
from softbody.collision.contact import Contacts
from softbody.model.arrays import NOBODY, Model

GROUND = -1


@dataclass(frozen=True, eq=False)
class ContactPoints:
    """The contacts of a World in its last step, a row each; all arrays are copies.

    Of a step that was taken in parts, see `split_steps` of `World`, they are those of its last part.

    Those of `World.step_frame_contacts` are of all steps of a frame, one after the other.

    Bodies go by numbers: soft bodies first, as they were added, then boxes; −1 is the ground, which is always b. What
    neither overlaps nor has given an impulse is not listed. They are of the world as it was: ask for new ones
    after a body was removed.
    """

    a: np.ndarray  # (c,) number of one body
    b: np.ndarray  # (c,) of the other, or −1
    point: np.ndarray  # (c, 3) [m] half-way between the surfaces
    normal: np.ndarray  # (c, 3) unit, from b to a
    depth: np.ndarray  # (c,) [m] before the step's response
    impulse: np.ndarray  # (c, 3) [N s] on a in the step, friction included; −impulse on b
    restitution: np.ndarray  # (c,) of the pair
    friction: np.ndarray  # (c,) Coulomb coefficient of the pair
    first_box: int  # number of the first box: how many soft bodies there are
    time_step: float  # [s] of the step, or of its last part, or of all steps of a frame
    names: Names  # of the bodies, then

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.a)

    def of(self, body: Body, other: Body | None = None) -> ContactPoints:
        """Return those that a body has, with an `other` one, or with any; a body may touch itself."""
        rows = self._has(body)
        if other is not None:
            one, two = self._number(body), self._number(other)
            rows = ((self.a == one) & (self.b == two)) | ((self.a == two) & (self.b == one))
        arrays = {name: value[rows] for name, value in vars(self).items() if isinstance(value, np.ndarray)}
        return replace(self, **arrays)  # type: ignore[arg-type]

    def and_of(self, bodies: np.ndarray, others: ContactPoints) -> ContactPoints:
        """Return these, and those of `others` that one of some `bodies` has, of which (b + m,) of bool tells."""
        rows = np.append(bodies, False)[[others.a, others.b]].any(axis=0)  # the last one is the ground
        arrays = {
            name: np.append(value, getattr(others, name)[rows], axis=0)
            for name, value in vars(self).items()
            if isinstance(value, np.ndarray)
        }
        return replace(self, **arrays)

    def force_on(self, body: Body) -> np.ndarray:
        """Return the total force (3,) [N] of all contacts on a body, as a mean over the step, or the frame."""
        number = self._number(body)
        impulse = self.impulse[self.a == number].sum(axis=0) - self.impulse[self.b == number].sum(axis=0)
        return impulse / self.time_step if self.time_step > 0.0 else impulse

    def pairs(self) -> set[tuple[int, int]]:
        """Return the pairs of numbers that touch, the smaller one first but for the ground, which is last."""
        ordered = (
            np.where(self.b == GROUND, self.a, np.minimum(self.a, self.b)),
            np.where(self.b == GROUND, self.b, np.maximum(self.a, self.b)),
        )
        return set(zip(ordered[0].tolist(), ordered[1].tolist(), strict=True))

    def named_pairs(self) -> set[tuple[str, str]]:
        """Return the pairs that touch by name, in the order of `pairs`: "lid", "box 3" if it has none, "the ground"."""
        return {(self._called(a), self._called(b)) for a, b in self.pairs()}

    def _called(self, number: int) -> str:
        if number == GROUND:
            return "the ground"
        who = ("soft", number) if number < self.first_box else ("box", number - self.first_box)
        return self.names.name(who) or self.names.title(who)

    def _has(self, body: Body) -> np.ndarray:
        number = self._number(body)
        return (self.a == number) | (self.b == number)

    def _number(self, body: Body) -> int:
        return body.row() + (self.first_box if body.kind == "box" else 0)


def of_all_steps(found: list[ContactPoints], time_step: float) -> ContactPoints:
    """Return the contacts of some steps of `time_step` [s] each, as of one that lasted as long as all of them.

    What a step's last part gave counts for the whole step. Where a body has torn, boxes have the numbers of the end.
    """
    weights, first_box = [time_step / each.time_step for each in found], found[-1].first_box
    arrays = {
        name: np.concatenate([getattr(each, name) for each in found])
        for name, value in vars(found[0]).items()
        if isinstance(value, np.ndarray)
    }
    arrays["impulse"] *= np.repeat(weights, [len(each) for each in found])[:, None]
    for side in "ab":
        numbers = [getattr(each, side) for each in found]
        shifts = [np.where(of >= each.first_box, first_box - each.first_box, 0) for of, each in zip(numbers, found)]
        arrays[side] = np.concatenate(numbers) + np.concatenate(shifts)
    return replace(found[-1], **arrays, time_step=time_step * len(found))  # type: ignore[arg-type]


def contact_points(
    model: Model, position: np.ndarray, contacts: Contacts, ground_impulse: np.ndarray, time_step: float, names: Names
) -> ContactPoints:
    """Return the contacts of a step of `time_step` [s], and those of particles, at `position`, with the ground.

    `ground_impulse` (n, 3) [N s] on each particle: where there is none, none touches.
    """
    found = slice(0, int(contacts.number[0]))
    rows = np.flatnonzero((contacts.depth[found] > 0.0) | contacts.impulse[found].any(axis=1))
    sides = _numbers(model, contacts, rows)
    landed = np.flatnonzero(ground_impulse.any(axis=1))
    soft = np.searchsorted(model.soft_particle_start, landed, side="right") - 1
    up = np.tile((0.0, 0.0, 1.0), (len(landed), 1))
    return ContactPoints(
        np.append(sides[:, 0], soft),
        np.append(sides[:, 1], np.full(len(landed), GROUND)),
        np.append(contacts.point[rows], position[landed], axis=0),
        np.append(contacts.normal[rows], up, axis=0),
        np.append(contacts.depth[rows], np.zeros(len(landed))),
        np.append(contacts.impulse[rows], ground_impulse[landed], axis=0),
        np.append(contacts.restitution[rows], np.maximum(model.soft_restitution[soft], model.ground_restitution)),
        np.append(contacts.friction[rows], np.sqrt(model.soft_friction[soft] * model.ground_friction)),
        model.soft_count,
        time_step,
        names,
    )


def _numbers(model: Model, contacts: Contacts, rows: np.ndarray) -> np.ndarray:
    """Return the number of the body on each side (c, 2) of some contacts."""
    box, particle = contacts.box[rows], contacts.particles[rows, :, 0]
    soft = np.searchsorted(model.soft_particle_start, particle, side="right") - 1
    return np.where(box != NOBODY, model.soft_count + box, np.where(particle != NOBODY, soft, GROUND))
