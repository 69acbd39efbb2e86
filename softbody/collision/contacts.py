"""Where do boxes touch each other and the ground, and which of these contacts were there a step ago?"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.collision.broad_phase import near_pairs, near_pairs_exhaustive
from softbody.collision.impulse import NOBODY
from softbody.collision.manifold import Scratch, box_axes, box_box_manifold
from softbody.collision.material import combined_friction, combined_restitution
from softbody.geometry.box import box_corner
from softbody.jit import jit, jit_lean
from softbody.quaternion import load_quaternion
from softbody.state import Model, Rules, State
from softbody.vec import load, norm

ROW = 56  # numbers that the solver keeps for each contact


class Contacts(NamedTuple):
    """The contacts of one step, sorted by (a, b), with room for fewer, perhaps, than their `number`.

    Then the rows beyond are missing, and the step must be tried again with longer arrays: `grown`. The fields `old_…`
    hold what the last step left, for the solver to start from.
    """

    number: np.ndarray  # (2,) of contacts found in this step, and in the one before
    body: np.ndarray  # (c, 2) a and b; b is NOBODY for the ground
    feature: np.ndarray  # (c,) what touches what, within a pair
    point: np.ndarray  # (c, 3) [m] half-way between the surfaces
    normal: np.ndarray  # (c, 3) unit, from b to a
    depth: np.ndarray  # (c,) [m]; negative for a gap that may close within the step
    restitution: np.ndarray  # (c,) combined
    friction: np.ndarray  # (c,) combined
    impulse: np.ndarray  # (c, 3) [N s] on a, friction included, in this step
    row: np.ndarray  # (c, ROW) the solver's
    old_body: np.ndarray  # (c, 2)
    old_feature: np.ndarray  # (c,)
    old_point: np.ndarray  # (c, 3) [m]
    old_impulse: np.ndarray  # (c, 3) [N s]


def new_contacts(capacity: int) -> Contacts:
    """Return no contacts, with room for `capacity`."""
    return Contacts(
        np.zeros(2, np.int64),
        np.empty((capacity, 2), np.int64),
        np.empty(capacity, np.int64),
        np.empty((capacity, 3)),
        np.empty((capacity, 3)),
        np.empty(capacity),
        np.empty(capacity),
        np.empty(capacity),
        np.empty((capacity, 3)),
        np.empty((capacity, ROW)),
        np.empty((capacity, 2), np.int64),
        np.empty(capacity, np.int64),
        np.empty((capacity, 3)),
        np.empty((capacity, 3)),
    )


def grown(contacts: Contacts) -> Contacts:
    """Return contacts with room for half as many again as were found, and the same memory of the last step."""
    longer = new_contacts(max(64, 3 * int(contacts.number[0]) // 2))
    kept = int(contacts.number[1])
    longer.number[1] = kept
    longer.old_body[:kept] = contacts.old_body[:kept]
    longer.old_feature[:kept] = contacts.old_feature[:kept]
    longer.old_point[:kept] = contacts.old_point[:kept]
    longer.old_impulse[:kept] = contacts.old_impulse[:kept]
    return longer


@jit_lean
def fall_in_step(model: Model, h: float) -> float:
    """Return how far [m] gravity moves a body within a step of `h` [s]: lengths below it are the solver's noise."""
    return h * h * norm((model.gravity[0], model.gravity[1], model.gravity[2]))


@jit_lean
def reach_in_step(model: Model, state: State, box: int, h: float) -> float:
    """Return how far [m] any point of a box may come within a step of `h` [s]: by its motion, and what acts on it."""
    if model.box_inverse_mass[box] == 0.0:
        return 0.0
    pull = 0.0
    for c in range(3):
        pull += (model.gravity[c] + model.box_inverse_mass[box] * model.box_force[box, c]) ** 2
    w = load(model.box_inverse_inertia, box)
    twist = max(w[0], w[1], w[2]) * norm(load(model.box_torque, box))
    radius = 0.5 * norm(load(model.box_size, box))
    spin = norm(load(state.box_angular_velocity, box))
    return h * (norm(load(state.box_velocity, box)) + h * np.sqrt(pull) + radius * (spin + h * twist))


@jit
def pairs_of_boxes(model: Model, state: State, reach: np.ndarray, exhaustive: bool) -> np.ndarray:
    """Return the pairs (p, 2) of boxes whose bounding spheres, grown by `reach` (m,) [m], meet; paper §4."""
    boxes = model.box_size.shape[0]
    radius = np.empty(boxes)
    movable = np.empty(boxes, np.bool_)
    for i in range(boxes):
        radius[i] = 0.5 * norm(load(model.box_size, i)) + reach[i]
        movable[i] = model.box_inverse_mass[i] > 0.0
    if exhaustive:
        return near_pairs_exhaustive(state.box_position, radius, movable)
    return near_pairs(state.box_position, radius, movable)


@jit
def half_shadows(size: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Return half the lengths (m, 3) [m] of the boxes' shadows on the world's axes; arrays as of `box_axes`."""
    extent = np.zeros((size.shape[0], 3))
    for i in range(size.shape[0]):
        for k in range(3):
            for c in range(3):
                extent[i, c] += 0.5 * size[i, k] * abs(axes[i, k, c])
    return extent


@jit_lean
def shadows_apart(position: np.ndarray, extent: np.ndarray, a: int, b: int, margin: float) -> bool:
    """Tell whether two boxes are more than `margin` [m] apart along one of the world's axes: three quick tests."""
    for c in range(3):  # noqa: SIM110 (Numba has no any() of a generator)
        if abs(position[a, c] - position[b, c]) > extent[a, c] + extent[b, c] + margin:
            return True
    return False


@jit
def find_contacts(model: Model, state: State, h: float, rules: Rules, contacts: Contacts, scratch: Scratch) -> None:
    """Fill in every point where boxes touch each other or the ground, or may do so within the next `h` [s].

    Looking one step ahead keeps a box that rests, its depth now a rounding above zero and now below, in contact; and
    turns back a fast one before it is inside.
    """
    boxes = model.box_size.shape[0]
    reach = np.empty(boxes)
    for i in range(boxes):
        reach[i] = reach_in_step(model, state, i, h)
    pairs = pairs_of_boxes(model, state, reach, rules.exhaustive_pairs)
    axes = box_axes(state.box_orientation)
    extent = half_shadows(model.box_size, axes)
    slack = fall_in_step(model, h)
    count = 0
    pair = 0
    for a in range(boxes):
        count = _ground_contacts(model, state, a, reach[a], contacts, count)
        while pair < pairs.shape[0] and pairs[pair, 0] == a:
            b = pairs[pair, 1]
            pair += 1
            # (The paper's axes see overlaps that these shadows would refute.)
            if not rules.paper_axes and shadows_apart(state.box_position, extent, a, b, reach[a] + reach[b]):
                continue
            found = box_box_manifold(
                model.box_size,
                state.box_position,
                state.box_orientation,
                axes,
                a,
                b,
                reach[a] + reach[b],
                slack,
                rules.paper_axes,
                scratch,
            )
            for k in range(found):
                if count < contacts.depth.shape[0]:
                    contacts.body[count, 0] = a
                    contacts.body[count, 1] = b
                    contacts.feature[count] = scratch.feature[k]
                    for c in range(3):
                        contacts.point[count, c] = scratch.point[k, c]
                        contacts.normal[count, c] = scratch.normal[c]
                    contacts.depth[count] = scratch.depth[k]
                    contacts.restitution[count] = combined_restitution(
                        model.box_restitution[a], model.box_restitution[b]
                    )
                    contacts.friction[count] = combined_friction(model.box_friction[a], model.box_friction[b])
                count += 1
    contacts.number[0] = count


@jit_lean
def _ground_contacts(model: Model, state: State, box: int, reach: float, contacts: Contacts, count: int) -> int:
    """Add the corners of a box that are, or may come, below the ground; return the new count."""
    top = model.ground_height + reach
    radius = 0.5 * norm(load(model.box_size, box))
    if model.box_inverse_mass[box] == 0.0 or state.box_position[box, 2] - radius > top:
        return count
    for k in range(8):
        corner = box_corner(
            load(model.box_size, box), load(state.box_position, box), load_quaternion(state.box_orientation, box), k
        )
        if corner[2] <= top:
            if count < contacts.depth.shape[0]:
                contacts.body[count, 0] = box
                contacts.body[count, 1] = NOBODY
                contacts.feature[count] = k
                depth = model.ground_height - corner[2]
                contacts.point[count, 0] = corner[0]
                contacts.point[count, 1] = corner[1]
                contacts.point[count, 2] = corner[2] + 0.5 * depth
                contacts.normal[count, 0] = 0.0
                contacts.normal[count, 1] = 0.0
                contacts.normal[count, 2] = 1.0
                contacts.depth[count] = depth
                contacts.restitution[count] = combined_restitution(model.box_restitution[box], model.ground_restitution)
                contacts.friction[count] = combined_friction(model.box_friction[box], model.ground_friction)
            count += 1
    return count


@jit_lean
def recall_impulses(contacts: Contacts) -> None:
    """Give each contact the impulse that it had a step ago, else none.

    It is known by its bodies and features. Where a feature is gone, its impulse goes to the contact of that pair that
    is nearest to it now: so boxes that slide over each other's edges keep what holds them.
    """
    for k in range(contacts.number[0]):
        for c in range(3):
            contacts.impulse[k, c] = 0.0
    first = 0
    for old in range(contacts.number[1]):
        a, b = contacts.old_body[old, 0], contacts.old_body[old, 1]
        while first < contacts.number[0] and (
            contacts.body[first, 0] < a or (contacts.body[first, 0] == a and contacts.body[first, 1] < b)
        ):
            first += 1
        heir = -1
        nearest = np.inf
        k = first
        while k < contacts.number[0] and contacts.body[k, 0] == a and contacts.body[k, 1] == b:
            distance = 0.0
            for c in range(3):
                distance += (contacts.point[k, c] - contacts.old_point[old, c]) ** 2
            if contacts.feature[k] == contacts.old_feature[old]:
                distance = -1.0
            if distance < nearest:
                nearest = distance
                heir = k
            k += 1
        if heir >= 0:
            for c in range(3):
                contacts.impulse[heir, c] += contacts.old_impulse[old, c]


@jit_lean
def remember_impulses(contacts: Contacts) -> None:
    """Keep what `recall_impulses` will ask for."""
    contacts.number[1] = contacts.number[0]
    for k in range(contacts.number[0]):
        contacts.old_body[k, 0] = contacts.body[k, 0]
        contacts.old_body[k, 1] = contacts.body[k, 1]
        contacts.old_feature[k] = contacts.feature[k]
        for c in range(3):
            contacts.old_point[k, c] = contacts.point[k, c]
            contacts.old_impulse[k, c] = contacts.impulse[k, c]
