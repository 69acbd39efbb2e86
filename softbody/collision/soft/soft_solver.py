"""Solver of soft contacts: what all of an island give together, so that no side parts too slowly and none pulls.

Impulses change velocities, shifts change positions; both are found by the same sweeps. A contact pushes along its
normal, never pulls, and may take back what it has given when others do its work. Friction stays within μ times the
whole push. That is a projection, so what rests stays at rest.

In one sweep each contact is solved as if it were alone, with a part of the mass of what it shares: of a particle in
proportion to the contacts' weights on it, of a box in equal parts (mass splitting: Tonge, Benevolenski and Voroshilov
2012). No sweep overshoots then, and nothing depends on the order of contacts, up to the rounding of sums. Sweeps run up
(Nesterov 1983), and start anew where that leads the wrong way (O'Donoghue and Candès 2015).
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from softbody.collision.contact import Listing, surface_point
from softbody.collision.solver.held_boxes import motion_by
from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.vec import Vec, accumulate, add, cross, dot, load, norm, scale, store, sub
from softbody.model.arrays import NOBODY
from softbody.model.surface_point import SurfacePoint, add_at, value_at

MOST_SWEEPS = 100

# Of a particle: not on the ground; on it, where contacts can but press it down; on it, and a contact, or its friction,
# may lift it.
FREE, HELD, LIFTED = 0, 1, 2


class Moved(NamedTuple):
    """What contacts move: velocities by impulses [N s], or positions by shifts [kg m]."""

    particle: np.ndarray  # (n, 3)
    box: np.ndarray  # (m, 3)
    turn: np.ndarray  # (m, 3) angular velocities; 0 where positions move, by which no box turns
    lift: np.ndarray  # (n,) what all contacts give particles on the ground, up: of that it takes what presses them down
    turns: bool


class Sharing(NamedTuple):
    """What all contacts move together, and how much of it gives way to each."""

    inverse_mass: np.ndarray  # (n,) of particles [1/kg]
    box_inverse_mass: np.ndarray  # (m,) [1/kg]
    box_mobility: np.ndarray  # (m, 6, 6) and `box_stands` (m,): see `box_mobilities`
    box_stands: np.ndarray
    ground: np.ndarray  # (n,) FREE, HELD or LIFTED: what of the particles does not give way to what presses it down
    particle_sum: np.ndarray  # (n,) of the weights of contacts on each particle; 0, and left so
    box_sum: np.ndarray  # (m,) of contacts on each box; 0, and left so


class Problem(NamedTuple):
    """What each contact is to reach, and what it gives for that: a row for each."""

    goal: np.ndarray  # (c,) speed [m/s], or height [m], along the normal that side a has above b at least
    most: np.ndarray  # (c,) that it gives along the normal
    lean: np.ndarray  # (c, 3) what it gives across for each unit along the normal
    friction: np.ndarray  # (c,) μ
    close: np.ndarray  # (c,) what it may lack after some sweeps
    enough: np.ndarray  # (c,) what it may lack in the end
    mobility: np.ndarray  # (c,) [1/kg] along the normal
    slip: np.ndarray  # (c,) [1/kg] across it
    aside: np.ndarray  # (c, 3) [1/kg] across, by what is given along the normal
    place: np.ndarray  # (c, 3) on b, where the sides are seen from each other
    acts_at: np.ndarray  # (c, 3) on b, where what follows acts
    acting: np.ndarray  # (c, 3) what of all that is given acts there; the rest acts at the place
    given: np.ndarray  # (c, 3) to side a
    tried: np.ndarray  # (c, 3) of which the motion is known
    next: np.ndarray  # (c, 3)


@jit
def new_problem(count: int) -> Problem:
    """Return a problem of `count` contacts that give nothing yet, whatever it takes, without lean and friction."""
    return Problem(
        np.empty(count),
        np.full(count, np.inf),
        np.zeros((count, 3)),
        np.zeros(count),
        np.empty(count),
        np.empty(count),
        np.empty(count),
        np.empty(count),
        np.empty((count, 3)),
        np.empty((count, 3)),
        np.empty((count, 3)),
        np.zeros((count, 3)),
        np.zeros((count, 3)),
        np.zeros((count, 3)),
        np.empty((count, 3)),
    )


@jit_lean
def find_mobilities(contacts: Listing, sharing: Sharing, impulses: Problem, shifts: Problem, rows: np.ndarray) -> None:
    """Find how easily each contact of an island moves its sides, with its part of all that they share."""
    for k in rows:
        _count(contacts, k, sharing, impulses, 1.0)
    for k in rows:
        box, up = contacts.box[k, 1], contacts.normal[k, 2]
        soft, held = _split(sharing, surface_point(contacts, k, 0), up)
        if box == NOBODY:
            more, more_held = _split(sharing, _acting(contacts, k, load(impulses.place, k)), -up)
            soft, held = soft + more, held + more_held
        impulses.mobility[k] = shifts.mobility[k] = soft - held * up * up
        impulses.slip[k] = soft
        store(impulses.aside, k, (0.0, 0.0, 0.0))
        if box != NOBODY and sharing.box_inverse_mass[box] > 0.0:
            _add_box(contacts, k, sharing, impulses, shifts)
        # What the ground holds moves level only: along the normal also by what is given across that, and the other way.
        both = held * abs(up) * sqrt(max(0.0, 1.0 - up * up))
        if both > 0.0:
            shifts.mobility[k] += impulses.friction[k] * both
            ratio = sqrt(impulses.mobility[k] / impulses.slip[k])
            impulses.mobility[k] += both * ratio
            impulses.slip[k] += both / ratio
    for k in rows:
        _count(contacts, k, sharing, impulses, 0.0)


@jit_lean
def _add_box(contacts: Listing, k: int, sharing: Sharing, impulses: Problem, shifts: Problem) -> None:
    """Add how easily contact `k` moves its box, which is not fixed."""
    normal, box, place, part = (
        load(contacts.normal, k),
        contacts.box[k, 1],
        load(impulses.place, k),
        sharing.box_sum[contacts.box[k, 1]],
    )
    one = _across(normal)
    other = cross(normal, one)
    by_normal = _box_change(sharing, box, place, normal)
    by_one, by_other = _box_change(sharing, box, place, one), _box_change(sharing, box, place, other)
    rise = dot(by_normal, normal)
    half, middle = 0.5 * (dot(by_one, one) - dot(by_other, other)), 0.5 * (dot(by_one, one) + dot(by_other, other))
    skew = dot(by_one, other)
    impulses.mobility[k] += part * rise
    impulses.slip[k] += part * (middle + sqrt(half * half + skew * skew))
    store(impulses.aside, k, scale(part, sub(by_normal, scale(rise, normal))))
    if not sharing.box_stands[box]:
        shifts.mobility[k] += part * sharing.box_inverse_mass[box]


@jit_lean
def _across(normal: Vec) -> Vec:
    """Return a unit vector across a unit normal."""
    across = (normal[1], -normal[0], 0.0) if abs(normal[2]) < 0.9 else (0.0, normal[2], -normal[1])
    return scale(1.0 / norm(across), across)


@jit_lean
def _box_change(sharing: Sharing, box: int, place: Vec, impulse: Vec) -> Vec:
    """Return the velocity [m/s] that an impulse [N s] gives the point of a box at a `place` [m] from its centre."""
    v, w = motion_by(sharing.box_mobility[box], impulse, cross(place, impulse))
    return add(v, cross(w, place))


@jit_lean
def _count(contacts: Listing, k: int, sharing: Sharing, problem: Problem, times: float) -> None:
    """Add contact `k` to the sums of what it shares; or, 0 `times`, make them zero."""
    box = contacts.box[k, 1]
    for c in range(3):
        i, w = contacts.particles[k, 0, c], abs(contacts.weights[k, 0, c])
        sharing.particle_sum[i] = times * (sharing.particle_sum[i] + w)
        if box == NOBODY:
            i, w = contacts.particles[k, 1, c], abs(problem.place[k, c])
            sharing.particle_sum[i] = times * (sharing.particle_sum[i] + w)
    if box != NOBODY and sharing.box_inverse_mass[box] > 0.0:
        sharing.box_sum[box] = times * (sharing.box_sum[box] + 1.0)


@jit_lean
def _split(sharing: Sharing, point: SurfacePoint, up: float) -> tuple[float, float]:
    """Return Σ w²/m [1/kg] of a point that has the part |w| / (sum of weights) of the mass of each of its particles.

    And what of that is of particles which the ground holds, as an impulse whose vertical part is `up` presses them.
    """
    result = held = 0.0
    for c in range(3):
        i, w = point.particles[c], point.weights[c]
        part = abs(w) * sharing.particle_sum[i] * sharing.inverse_mass[i]
        result += part
        if sharing.ground[i] == HELD and w * up < 0.0:
            held += part
    return result, held


@jit_lean
def _acting(contacts: Listing, k: int, place: Vec) -> SurfacePoint:
    """Return the point of a soft body that side b of contact `k` is, at a place."""
    return SurfacePoint(surface_point(contacts, k, 1).particles, place)


@jit_lean
def seen(contacts: Listing, k: int, moved: Moved, place: Vec) -> Vec:
    """Return the velocity [m/s], or the way [m], of side a of contact `k`, seen from a place on b."""
    a, box = value_at(moved.particle, surface_point(contacts, k, 0)), contacts.box[k, 1]
    if box == NOBODY:
        return sub(a, value_at(moved.particle, _acting(contacts, k, place)))
    return sub(a, add(load(moved.box, box), cross(load(moved.turn, box), place)))


@jit_lean
def give(contacts: Listing, k: int, sharing: Sharing, moved: Moved, place: Vec, given: Vec, before: Vec) -> None:
    """Move both sides of contact `k` by what is given to a at a place on b, instead of what was given `before`."""
    box, more = contacts.box[k, 1], sub(given, before)
    _give_soft(sharing, moved, surface_point(contacts, k, 0), given, before)
    if box == NOBODY:
        _give_soft(sharing, moved, _acting(contacts, k, place), scale(-1.0, given), scale(-1.0, before))
    elif sharing.box_inverse_mass[box] > 0.0:
        _push_box(sharing, moved, box, scale(-1.0, more), cross(more, place))


@jit_lean
def _push_box(sharing: Sharing, moved: Moved, box: int, impulse: Vec, moment: Vec) -> None:
    """Move a box that is not fixed by an impulse [N s] and a moment about its centre; or shift it [kg m] if it is free.

    What a box stands on rubs it in the same time as friction moves it, so that it ends where it was.
    """
    if moved.turns:
        v, w = motion_by(sharing.box_mobility[box], impulse, moment)
        accumulate(moved.box, box, v)
        accumulate(moved.turn, box, w)
    elif not sharing.box_stands[box]:
        accumulate(moved.box, box, scale(sharing.box_inverse_mass[box], impulse))


@jit_lean
def _give_soft(sharing: Sharing, moved: Moved, point: SurfacePoint, given: Vec, before: Vec) -> None:
    """Move a point of a soft body; what all contacts together press a particle on to the ground with, that takes.

    What none can lift, the ground holds in any case, so that it moves level only in all sweeps.
    """
    (i, j, k), ground, more = point.particles, sharing.ground, sub(given, before)
    if ground[i] == ground[j] == ground[k] == FREE:
        add_at(moved.particle, sharing.inverse_mass, point, more)
        return
    for c in range(3):
        i, part = point.particles[c], scale(point.weights[c], more)
        if ground[i] != FREE:
            lift = moved.lift[i]
            moved.lift[i] = lift + part[2]
            rise = max(0.0, lift + part[2]) - max(0.0, lift) if ground[i] == LIFTED else 0.0
            part = (part[0], part[1], rise)
        accumulate(moved.particle, i, scale(sharing.inverse_mass[i], part))


@jit_lean
def solve_island(
    contacts: Listing, sharing: Sharing, moved: Moved, problem: Problem, rows: np.ndarray, first_sweeps: int
) -> bool:
    """Find what the contacts of an island give, from what they give already, and move both sides by that.

    The `first_sweeps`, of which at least one is made, are for `close`, before `enough` is enough. Returns whether
    anything has changed.
    """
    run_up = 1.0
    for sweep in range(MOST_SWEEPS):
        is_last, turn = True, 0.0
        limit = problem.close if sweep < first_sweeps else problem.enough
        for k in rows:
            tried = load(problem.tried, k)
            answer = _answer(contacts, k, seen(contacts, k, moved, load(problem.place, k)), problem)
            step = sub(answer, tried)
            is_last = is_last and problem.mobility[k] * norm(step) <= limit[k]
            turn -= problem.mobility[k] * dot(step, sub(answer, load(problem.given, k)))
            store(problem.next, k, answer)
        if is_last and sweep == first_sweeps == 0:
            return False
        longer = 0.5 + sqrt(0.25 + run_up * run_up)
        on = (run_up - 1.0) / longer
        run_up = longer
        if turn > 0.0 or is_last or sweep == MOST_SWEEPS - 1:
            run_up, on = 1.0, 0.0
        for k in rows:
            answer, before = load(problem.next, k), load(problem.tried, k)
            tried = add(answer, scale(on, sub(answer, load(problem.given, k))))
            store(problem.given, k, answer)
            if tried != before:
                give(contacts, k, sharing, moved, load(problem.place, k), tried, before)
                store(problem.tried, k, tried)
        if is_last:
            break
    return True


@jit_lean
def act_at(contacts: Listing, k: int, sharing: Sharing, moved: Moved, problem: Problem, place: Vec) -> None:
    """Let all that contact `k` gives react at a place on b, which is not the one where its sides are seen."""
    box, given, acting = contacts.box[k, 1], load(problem.given, k), load(problem.acting, k)
    at, seen_at = load(problem.acts_at, k), load(problem.place, k)
    if box == NOBODY:
        none, back, before = (0.0, 0.0, 0.0), scale(-1.0, given), scale(-1.0, acting)
        _give_soft(sharing, moved, _acting(contacts, k, at), none, before)
        _give_soft(sharing, moved, _acting(contacts, k, seen_at), before, back)
        _give_soft(sharing, moved, _acting(contacts, k, place), back, none)
    elif moved.turns and sharing.box_inverse_mass[box] > 0.0:
        moment = sub(cross(sub(at, seen_at), acting), cross(sub(place, seen_at), given))
        _push_box(sharing, moved, box, (0.0, 0.0, 0.0), moment)
    store(problem.acts_at, k, place)
    store(problem.acting, k, given)


@jit_lean
def _answer(contacts: Listing, k: int, u: Vec, problem: Problem) -> Vec:
    """Return what contact `k` gives if it were alone, with its part of what it shares, and its sides move by `u`."""
    if not problem.mobility[k] > 0.0:
        return (0.0, 0.0, 0.0)
    normal, tried = load(contacts.normal, k), load(problem.tried, k)
    speed, before = dot(u, normal), dot(tried, normal)
    push = min(problem.most[k], max(0.0, before + (problem.goal[k] - speed) / problem.mobility[k]))
    answer = scale(push, add(normal, load(problem.lean, k)))
    if not problem.friction[k] > 0.0:
        return answer
    slide = add(sub(u, scale(speed, normal)), scale(push - before, load(problem.aside, k)))
    across = sub(sub(tried, scale(before, normal)), scale(1.0 / problem.slip[k], slide))
    limit, length = problem.friction[k] * push, norm(across)
    if length > limit:
        across = scale(limit / length, across)
    return add(answer, across)
