"""Number of parts into which a step is split so that no body jumps through another.

A contact is found where a particle, a corner or an edge is inside a body at the end of a step, and it is parted through
the nearest side. So on its way in nothing may go past the middle in one go.
"""

from __future__ import annotations

from math import ceil, sqrt

import numpy as np

from softbody.collision.broad_phase import near_pairs
from softbody.compiler.jit import jit, jit_lean
from softbody.geometry.sphere import bounding_spheres
from softbody.linalg.vec import add, dot, load, norm, scale, store, sub
from softbody.model.arrays import Model, State
from softbody.model.sleep_state import SleepState, sleeps

SHARE = 0.25  # of the thinner body's thickness, which two bodies may move against each other in one part
MOST_PARTS = 1_000


@jit
def spheres_of_bodies(model: Model, state: State) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return centre (b + m, 3) [m], radius (b + m,) [m] and whether it is soft of each soft body and then each box."""
    soft, boxes = model.soft_count, model.box_count
    centre = np.empty((soft + boxes, 3))
    radius = np.empty(soft + boxes)
    is_soft = np.zeros(soft + boxes, np.bool_)
    bounding_spheres(state.particle_position, model.soft_particle_start, centre, radius[:soft])
    is_soft[:soft] = True
    spheres_of_boxes(model, state, centre, radius)
    return centre, radius, is_soft


@jit_lean
def spheres_of_boxes(model: Model, state: State, centre: np.ndarray, radius: np.ndarray) -> None:
    """Write the spheres of the boxes into `centre` (b + m, 3) [m] and `radius` (b + m,) [m], after the soft bodies."""
    soft = model.soft_count
    for box in range(model.box_count):
        store(centre, soft + box, load(state.box_position, box))
        radius[soft + box] = 0.5 * norm(load(model.box_size, box))


@jit
def subdivision(model: Model, state: State, rest: SleepState | None, h: float) -> int:
    """Return the least number of equal parts of a step of `h` [s], at most MOST_PARTS, in which nothing is jumped over.

    In one part no soft body and what is near it may move against each other by more than a SHARE of the thickness of
    the thinner. Boxes among themselves have contacts that look ahead, and count not; who sleeps does not move.
    """
    soft, boxes = model.soft_count, model.box_count
    velocity = np.zeros((soft + boxes, 3))
    spread = np.zeros(soft + boxes)  # of the velocities of a body's points about that of its centre
    thickness = np.empty(soft + boxes)
    fastest, thinnest = 0.0, np.inf
    for body in range(soft):
        thickness[body] = model.soft_thickness[body]
        if sleeps(rest, body):
            continue
        first, end = model.soft_particle_start[body], model.soft_particle_start[body + 1]
        mean = (0.0, 0.0, 0.0)
        for i in range(first, end):
            mean = add(mean, load(state.particle_velocity, i))
        mean = scale(1.0 / (end - first), mean)
        square = 0.0
        for i in range(first, end):
            apart = sub(load(state.particle_velocity, i), mean)
            square = max(square, dot(apart, apart))
        store(velocity, body, mean)
        spread[body] = sqrt(square)
    for box in range(boxes):
        size = load(model.box_size, box)
        store(velocity, soft + box, load(state.box_velocity, box))
        spread[soft + box] = 0.5 * norm(size) * norm(load(state.box_angular_velocity, box))
        thickness[soft + box] = min(size[0], size[1], size[2])
    for body in range(soft + boxes):
        fastest = max(fastest, norm(load(velocity, body)) + spread[body])
        thinnest = min(thinnest, thickness[body])
    if not 2.0 * h * fastest > SHARE * thinnest:
        return 1
    centre, radius, is_soft = spheres_of_bodies(model, state)
    for body in range(soft + boxes):
        radius[body] += h * (norm(load(velocity, body)) + spread[body])
    pairs = near_pairs(centre, radius, is_soft)
    parts = 1.0
    for k in range(pairs.shape[0]):
        a, b = pairs[k, 0], pairs[k, 1]
        closing = norm(sub(load(velocity, a), load(velocity, b))) + spread[a] + spread[b]
        parts = max(parts, h * closing / (SHARE * min(thickness[a], thickness[b])))
    return int(ceil(min(parts, MOST_PARTS)))
