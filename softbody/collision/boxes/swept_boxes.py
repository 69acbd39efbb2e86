"""Swept test of two moving boxes: whether they meet within the step, when, and along which axis.

The separating-axis test of moving boxes (Ericson 2005, §5.5.8). Boxes that are apart touch no sooner than along the
axis on which their projections come to overlap last; if one stays open to the end of the step, they pass each other.
The motion is that of free flight, gravity included. Rotation is covered by a margin, until conservative advancement
(Mirtich 1996, §2.3) has shown that boxes which turn do not come near.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from softbody.collision.boxes.sat_boxes import (
    AFTER,
    FACE_PREFERENCE,
    BoxFrames,
    Limits,
    PlacedBox,
    PlacedBoxes,
    SatMemory,
    axes_are_one,
    box_box_separation,
    placed_box,
    rounding_of,
)
from softbody.collision.edge_edge import PARALLEL_SINE
from softbody.compiler.jit import jit_lean
from softbody.linalg.quaternion import from_rotation_vector, normalize_quaternion, product
from softbody.linalg.vec import Vec, add, cross, dot, norm, scale, sub

GRAZE = 2.0  # slops of overlap up to which boxes only graze each other, as boxes at rest do
SLIDE = 0.01  # of the slop: a way in a step that is none of the solver's noise
NEAR = 0.01  # of that: boxes that turn are taken to meet if they come as near within the step


class Sweep(NamedTuple):
    """How a moves within a step, seen from b, if nothing stops it."""

    travel: Vec  # [m] by its velocity and by what pulls, as if nothing held it
    pull: Vec  # [m] what of it comes from what pulls
    spin_a: Vec  # [rad] about its centre, in the world
    spin_b: Vec  # [rad]
    turn: float  # [m] that any point may come besides, by turning
    share: float  # a's part of the sum of both inverse masses: the lighter box keeps its points where they are


class Meeting(NamedTuple):
    """Where and when boxes come to touch."""

    axis: int  # as of `box_box_separation`, or NEVER
    separation: float  # [m] along it, now
    when: float  # 0 … 1 of the step


STILL = (0.0, 0.0, 0.0)
NO_SWEEP = Sweep(STILL, STILL, STILL, STILL, 0.0, 0.0)

NEVER = -1
NO_MEETING = Meeting(NEVER, 0.0, 0.0)


@jit_lean
def grazing_depth(size: np.ndarray, pair: tuple[int, int], slop: float) -> float:
    """Return the overlap [m] up to which two boxes only graze each other."""
    return GRAZE * slop + 1e3 * rounding_of(size, pair[0], pair[1])


@jit_lean
def rests_on_face(boxes: BoxFrames, pair: tuple[int, int], axis: int, least: float, memory: SatMemory) -> bool:
    """Tell whether boxes that touch along face `axis` overlap by more than `least` [m] along all other faces.

    But those that are all but parallel to it. Then they rest on each other, and no other axis can come first.
    """
    for k in range(6):
        alike = 0.0
        if axis < 3 <= k:
            alike = memory.cosine[axis, k - 3]
        elif k < 3 <= axis:
            alike = memory.cosine[k, axis - 3]
        distance, reach, _, _ = _projection(boxes.size, pair, k, memory)
        if k != axis and abs(alike) < 0.99 and abs(distance) - reach > -least:
            return False
    return True


@jit_lean
def meeting_of(boxes: BoxFrames, pair: tuple[int, int], sweep: Sweep, limits: Limits, memory: SatMemory) -> Meeting:
    """Return where and when two boxes meet, which `least_overlap` has found apart, or grazing; its normal in `memory`.

    An overlap of less than `grazing_depth` counts as none. Boxes that graze along an axis on which they all but keep
    their distance, as one that slides on another does, touch along it before any other; if on two, as one that slides
    on to the next of flush tiles, along that on which their velocities move them less. A contact that would act, but
    that they would fly past if nothing held them, is none.
    """
    a, b = pair
    project_travel(boxes, pair, sweep.travel, memory)
    rounding, graze = rounding_of(boxes.size, a, b), grazing_depth(boxes.size, pair, limits.slop)
    touching = limits.slop + rounding
    latest, before, best, acts = -np.inf, 0.0, NO_MEETING, False
    for k in range(6 if limits.paper_axes else 15):
        distance, reach, way, sine = _projection(boxes.size, pair, k, memory)
        if sine < PARALLEL_SINE:
            continue
        separation, closing = abs(distance) - reach, -way if distance >= 0.0 else way
        if separation > touching and separation > sweep.turn + rounding + max(0.0, closing):
            return NO_MEETING  # open to the end of the step
        if separation <= -graze:
            continue
        # When the projections come to overlap.
        slowest = graze if separation <= touching else 1e-9 * separation
        entry = separation / closing if closing > slowest else np.inf
        # The latest axis is taken, faces of a before those of b before edges where they tie.
        preference = 0.0
        if 0 <= best.axis < 6 <= k:
            preference = rounding / sine + FACE_PREFERENCE * abs(separation)
        elif 0 <= best.axis < 3 <= k:
            preference = rounding
        if preference > 0.0 and best.separation <= touching:
            preference += limits.slop
        if 0 <= best.axis < 6 <= k and axes_are_one(best.axis, k, sine, memory):
            preference = np.inf
        if entry == latest:
            better = separation > best.separation + preference
            if entry == np.inf and abs(separation - best.separation) > rounding:
                own, others = _slide(boxes, pair, sweep, k, memory), _slide(boxes, pair, sweep, best.axis, memory)
                if abs(own - others) > SLIDE * limits.slop + rounding:
                    better = own < others
        elif entry < np.inf and latest < np.inf:
            better = (entry - latest) * closing > preference
        else:
            better = entry > latest
        # What it comes after is when the boxes' outlines, seen along it, begin to overlap.
        earlier = latest if better else entry
        if 0.0 < earlier <= 1.0:
            before = max(before, earlier)
        if better:
            latest, best, acts = entry, Meeting(k, separation, 0.0), separation < sweep.turn + closing
    if best.axis == NEVER or (acts and _fly_past(boxes, pair, sweep, limits.paper_axes, memory)):
        return NO_MEETING
    write_normal(boxes, pair, best.axis, memory)
    when = latest if latest <= 1.0 and best.separation > touching else before
    return Meeting(best.axis, best.separation, when)


@jit_lean
def _slide(boxes: BoxFrames, pair: tuple[int, int], sweep: Sweep, k: int, memory: SatMemory) -> float:
    """Return how far [m] velocities alone move two boxes along axis `k`, seen from each other, within the step."""
    project_travel(boxes, pair, sub(sweep.travel, sweep.pull), memory)
    _, _, way, _ = _projection(boxes.size, pair, k, memory)
    project_travel(boxes, pair, sweep.travel, memory)
    return abs(way)


@jit_lean
def _fly_past(boxes: BoxFrames, pair: tuple[int, int], sweep: Sweep, paper_axes: bool, memory: SatMemory) -> bool:
    """Tell whether boxes that nothing holds are apart all through the step: at no time do they overlap on every axis.

    Their travel must be in `memory`.
    """
    near = sweep.turn + rounding_of(boxes.size, pair[0], pair[1])
    enter, leave = 0.0, 1.0
    for k in range(6 if paper_axes else 15):
        distance, reach, way, sine = _projection(boxes.size, pair, k, memory)
        if sine < PARALLEL_SINE:
            continue
        reach += near
        if way == 0.0:
            if abs(distance) > reach:
                return True
            continue
        ahead = distance if way > 0.0 else -distance
        enter, leave = max(enter, (-reach - ahead) / abs(way)), min(leave, (reach - ahead) / abs(way))
    return enter > leave


ADVANCES = 1000  # after so many, boxes are as good as touching


@jit_lean
def come_near(
    boxes: BoxFrames, pair: tuple[int, int], sweep: Sweep, near: float, apart: float, memory: SatMemory
) -> bool:
    """Tell whether boxes that travel and turn come as near as `near` [m] within the step, or all but.

    Now they are `apart` [m] along the normal in `memory`. Along the axis that parts them most they cannot close faster
    than the travel along it, and than their corners turn towards it: for as long as the gap lasts then, they are apart,
    and the next axis is asked. However they turn, they stay within spheres about them, which only the travel closes.
    """
    placed = PlacedBoxes(boxes.size, boxes.position, boxes.orientation)
    a, b = placed_box(placed, pair[0]), placed_box(placed, pair[1])
    turning = 0.5 * (norm(a.size) * norm(sweep.spin_a) + norm(b.size) * norm(sweep.spin_b))
    near += max(0.0, sweep.turn - turning)
    radii, way = 0.5 * (norm(a.size) + norm(b.size)), norm(sweep.travel)
    when, gap, normal = 0.0, apart, (memory.normal[0], memory.normal[1], memory.normal[2])
    for _ in range(ADVANCES):
        turning = _turning_along(a.size, sweep.spin_a, normal) + _turning_along(b.size, sweep.spin_b, normal)
        closing = max(0.0, -dot(sweep.travel, normal)) + turning
        if gap <= near:
            return True
        if gap - near > closing * (1.0 - when):
            return False
        when += (gap - 0.9 * near) / closing
        outside = norm(sub(add(a.position, scale(when, sweep.travel)), b.position)) - radii - near
        if outside > way * (1.0 - when):
            return False
        if outside > 0.0:
            when += outside / way
        gap, normal, _ = box_box_separation(
            _later(a, scale(when, sweep.travel), scale(when, sweep.spin_a)), _later(b, STILL, scale(when, sweep.spin_b))
        )
    return True


@jit_lean
def _turning_along(size: Vec, spin: Vec, normal: Vec) -> float:
    """Return how far [m] at most a corner of a box moves along a unit vector by turning."""
    return 0.5 * norm(size) * norm(cross(spin, normal))


@jit_lean
def _later(box: PlacedBox, travel: Vec, spin: Vec) -> PlacedBox:
    """Return a box after it has moved and turned."""
    turned = normalize_quaternion(product(from_rotation_vector(spin), box.orientation))
    return PlacedBox(box.size, add(box.position, travel), turned)


@jit_lean
def project_travel(boxes: BoxFrames, pair: tuple[int, int], travel: Vec, memory: SatMemory) -> None:
    """Write `travel`, seen from both boxes' frames, beside the way from b to a."""
    for frame in range(2):
        box = pair[0] if frame == 0 else pair[1]
        for k in range(3):
            axis = boxes.axes[box, k, 0], boxes.axes[box, k, 1], boxes.axes[box, k, 2]
            memory.travel[frame, k] = dot(travel, axis)


@jit_lean
def _projection(
    size: np.ndarray, pair: tuple[int, int], k: int, memory: SatMemory
) -> tuple[float, float, float, float]:
    """Return what is seen along axis `k`: way from b to a, both half extents together, travel [m], and the edges' sine.

    The sine is 1 for a face, and 0 for edges that are parallel.
    """
    a, b = pair
    cosine, apart, travel = memory.cosine, memory.apart, memory.travel
    sine = 1.0
    if k < 3:
        distance, way, reach = apart[0, k], travel[0, k], size[a, k]
        for j in range(3):
            reach += size[b, j] * abs(cosine[k, j])
    elif k < 6:
        distance, way, reach = apart[1, k - 3], travel[1, k - 3], size[b, k - 3]
        for i in range(3):
            reach += size[a, i] * abs(cosine[i, k - 3])
    else:
        i, j = (k - 6) // 3, (k - 6) % 3
        i1, i2, j1, j2 = AFTER[i], AFTER[i + 1], AFTER[j], AFTER[j + 1]
        sine = sqrt(cosine[i1, j] * cosine[i1, j] + cosine[i2, j] * cosine[i2, j])
        if sine < PARALLEL_SINE:
            return 0.0, 0.0, 0.0, 0.0
        distance = (apart[0, i2] * cosine[i1, j] - apart[0, i1] * cosine[i2, j]) / sine
        way = (travel[0, i2] * cosine[i1, j] - travel[0, i1] * cosine[i2, j]) / sine
        reach = (
            size[a, i1] * abs(cosine[i2, j])
            + size[a, i2] * abs(cosine[i1, j])
            + size[b, j1] * abs(cosine[i, j2])
            + size[b, j2] * abs(cosine[i, j1])
        ) / sine
    return distance, 0.5 * reach, way, sine


@jit_lean
def write_normal(boxes: BoxFrames, pair: tuple[int, int], axis: int, memory: SatMemory) -> None:
    """Write the unit vector along an axis, from b to a."""
    a, b = pair
    axes, normal = boxes.axes, memory.normal
    if axis < 6:
        box, k, frame = (a, axis, 0) if axis < 3 else (b, axis - 3, 1)
        sign = 1.0 if memory.apart[frame, k] >= 0.0 else -1.0
        for c in range(3):
            normal[c] = sign * axes[box, k, c]
        return
    i, j = (axis - 6) // 3, (axis - 6) % 3
    i1, i2 = AFTER[i], AFTER[i + 1]
    u = axes[a, i, 1] * axes[b, j, 2] - axes[a, i, 2] * axes[b, j, 1]
    v = axes[a, i, 2] * axes[b, j, 0] - axes[a, i, 0] * axes[b, j, 2]
    w = axes[a, i, 0] * axes[b, j, 1] - axes[a, i, 1] * axes[b, j, 0]
    distance = memory.apart[0, i2] * memory.cosine[i1, j] - memory.apart[0, i1] * memory.cosine[i2, j]
    length = sqrt(u * u + v * v + w * w)
    sign = 1.0 / length if distance >= 0.0 else -1.0 / length
    normal[0], normal[1], normal[2] = sign * u, sign * v, sign * w
