"""One time step of a whole world, read top to bottom, and a run of many."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.collision.box_contacts import find_box_contacts
from softbody.collision.contact import Contacts
from softbody.collision.manifold import Manifold
from softbody.collision.paper_response import resolve_in_turn
from softbody.collision.soft_contacts import find_soft_contacts
from softbody.collision.soft_response import Bodies, resolve_contacts
from softbody.collision.substeps import subdivision
from softbody.collision.surface import Surfaces
from softbody.dynamics.rigid_boxes import limit_boxes
from softbody.dynamics.soft_bodies import BARE, Motion, move_soft_bodies
from softbody.jit import jit, jit_inlined
from softbody.landing import material_on_ground, resolve_ground
from softbody.move_boxes import hold_boxes, move_boxes, move_boxes_singly
from softbody.settings import Settings
from softbody.state import Controls, Model, State, boxes_of, copied, particles_of, soft_bodies_of
from softbody.vec import load, store


class Work(NamedTuple):
    """What a step needs besides what it is a function of: structures that follow the bodies, and memory.

    Where there are no boxes, or no soft bodies, what is theirs is None, and nothing of it is compiled.
    """

    motion: Motion | None
    surfaces: Surfaces | None
    manifold: Manifold | None
    start: State  # of the step
    grounded: np.ndarray | None  # (m,) of bool: which boxes touch the ground


@jit_inlined
def step(
    model: Model,
    controls: Controls,
    state: State,
    work: Work,
    contacts: Contacts,
    settings: Settings,
    h: float,
) -> tuple[Contacts, int, int]:
    """Advance a world by `h` [s]; return (contacts, fault, soft body).

    The contacts are those of this step, in longer arrays if there was no room for all. On a fault (DIVERGED or
    COLLAPSED, else 0) no soft body has moved, and the step must be undone.
    """
    contacts.number[0] = contacts.number[1] = 0
    if not settings.single_contact:
        contacts = find_box_contacts(model, controls, state, work.manifold, contacts, settings, h)
    copy_state(state, work.start)
    _, fault, body = move_soft_bodies(soft_bodies_of(model, controls, state), work.motion, settings, h, 1)
    if fault:
        return contacts, fault, body
    if settings.single_contact:
        move_boxes_singly(model, controls, state, work.grounded, settings, h)
    else:
        move_boxes(model, controls, state, work.grounded, contacts, settings, h)
    limit_boxes(model, state, settings, work.grounded)
    contacts = find_soft_contacts(model, state, work.surfaces, settings, contacts)
    push = resolve_soft_contacts(model, state, work.start, work.surfaces, contacts, settings, h)
    hold_boxes(model, controls, state, work.grounded, contacts, push, settings, h)
    resolve_ground(model, state)
    return contacts, 0, -1


@jit
def resolve_soft_contacts(
    model: Model,
    state: State,
    start: State,
    surfaces: Surfaces | None,
    contacts: Contacts,
    settings: Settings,
    h: float,
) -> np.ndarray | None:
    """Resolve the contacts of soft bodies that a step of `h` [s] has led to, together or in turn.

    Returns (m, 6), (0, 6) or None: the pushes on boxes that what they stand on is to hold, see `resolve_contacts`.
    """
    if surfaces is None:
        return None
    now = Bodies(particles_of(model, state), boxes_of(model, state))
    if settings.single_soft_contact:
        resolve_in_turn(contacts, now)
        return np.empty((0, 6))
    before = Bodies(particles_of(model, start), boxes_of(model, start))
    return resolve_contacts(contacts, now, before, surfaces.weight_sum, h, surfaces.threads, surfaces.with_boxes)


@jit
def run(
    model: Model,
    controls: Controls,
    state: State,
    work: Work,
    contacts: Contacts,
    settings: Settings,
    h: float,
    steps: int,
) -> tuple[Contacts, int, int, int]:
    """Advance any world by `steps` steps of `h` [s]; return (contacts, steps done, fault, soft body).

    Where bodies would jump through each other a step is taken in equal parts. On a fault the state is that of the last
    good step.
    """
    for done in range(steps):
        parts = subdivision(model, state, h) if settings.split_steps and model.soft_count > 0 else 1
        start = copied(state) if parts > 1 else state
        for _ in range(parts):
            contacts, fault, body = step(model, controls, state, work, contacts, settings, h / parts)
            if fault:
                copy_state(start, state)
                return contacts, done, fault, body
    return contacts, steps, 0, -1


@jit
def run_alone(
    model: Model, controls: Controls, state: State, motion: Motion, settings: Settings, h: float, steps: int
) -> tuple[int, int, int]:
    """Advance a world of one soft body, and perhaps the ground, by `steps` steps of `h` [s].

    Returns (steps done, fault, soft body), like `run`, with the same result, but is compiled in a third of the time.
    """
    bodies, material = soft_bodies_of(model, controls, state), BARE
    if model.soft_count == 1:
        material = material_on_ground(model, 0)
    return move_soft_bodies(bodies, motion, settings, h, steps, model.ground_height, material)


@jit
def copy_state(start: State, state: State) -> None:
    """Overwrite the arrays of `state` with those of `start`."""
    for i in range(state.particle_position.shape[0]):
        store(state.particle_position, i, load(start.particle_position, i))
        store(state.particle_velocity, i, load(start.particle_velocity, i))
    for i in range(state.box_position.shape[0]):
        store(state.box_position, i, load(start.box_position, i))
        store(state.box_velocity, i, load(start.box_velocity, i))
        store(state.box_angular_velocity, i, load(start.box_angular_velocity, i))
        for c in range(4):
            state.box_orientation[i, c] = start.box_orientation[i, c]
