"""Constraint solver for contacts of boxes: impulses that together part, hold and let slide.

Sequential impulses (Catto 2005): contact by contact, up and down, each impulse is corrected to what its
contact asks for, given all the others; the sums are kept within their bounds, not the corrections. This is a projected
Gauss–Seidel method on the velocities, and converges to the solution of the complementarity problem. Depths are undone
by a second, like solve for positions (pseudo-velocities), which no velocity ever feels.
"""

from __future__ import annotations

from math import inf

import numpy as np

from softbody.collision.contact import Contacts
from softbody.collision.solver.batches import FRICTION, Batches, batches_of, take_impulses
from softbody.collision.solver.bounces import set_targets
from softbody.collision.solver.held_boxes import pass_down
from softbody.collision.solver.pinched import holds_pinched
from softbody.collision.solver.solver_row import (
    ANGULAR_A,
    ANGULAR_B,
    COUPLING,
    INVERSE_A,
    INVERSE_B,
    MASS,
    NORMAL,
    NORMAL_IMPULSE,
    POSITION_IMPULSE,
    SECOND,
    SECOND_COUPLING,
    SECOND_IMPULSE,
    TANGENT,
    TANGENT_IMPULSE,
    TANGENT_MASS,
    TARGET,
    TURN_A,
    TURN_B,
    apply_impulse,
    component,
    load_motion,
    load_pair,
    load_three,
    speed_along,
    store_motion,
)
from softbody.collision.solver.support_trees import solve_trees
from softbody.collision.solver.sweep_order import sweep_order
from softbody.collision.solver.warm_start import start_from_cache
from softbody.compiler.jit import jit, jit_lean
from softbody.compiler.simd import LANES, Lanes, least_lane, load_lanes, spread, store_lanes, where_less
from softbody.linalg.vec import Vec, add, dot, load, scale, store, sub
from softbody.linalg.vec_lanes import VecLanes, gather_vec, scatter_vec
from softbody.model.arrays import NOBODY, RigidBodies
from softbody.model.material import within_friction_cones

# The part of a depth that one step undoes. All at once would let a pile that is not solved to the end jump.
BAUMGARTE = 0.2

# Sweeps go on, up to so many times `iterations` MORE, while two of them leave no more than FAST of what they correct:
# the corners of a face that strikes another are soon right to the last bit, and a heap of boxes that tumble never is.
MORE, FAST = 3, 0.75

# The part of the depth that is allowed below which a correction of a displacement is not worth another sweep.
CLOSE = 1e-3

# Sweeps that change as much as those before, but for this part, do not converge. If something moves by script, it may
# press what cannot give way; its contacts then give way by this part of what their impulses change a free body by.
STUCK, GIVING_WAY = 0.9, 0.25


@jit
def solve_velocities(contacts: Contacts, bodies: RigidBodies, h: float, iterations: int, enough: float) -> None:
    """Change the velocities so that at every contact the bodies part, rest or slide as they must.

    The speeds at which they part are those of `set_targets`. Friction is bounded by μ times the normal impulse, in
    every direction alike. Ends after a sweep that changed no speed at a contact by more than `enough` [m/s]; or after
    `iterations` sweeps, unless they converge FAST.
    """
    set_targets(contacts, load_motion(bodies), h, enough, iterations)
    part_at_targets(contacts, bodies, iterations, enough)


@jit
def part_at_targets(contacts: Contacts, bodies: RigidBodies, iterations: int, enough: float) -> None:
    """Do what `solve_velocities` does, once the speeds at which contacts part are set."""
    motion = load_motion(bodies)
    start_from_cache(contacts, bodies, motion, enough)
    order = sweep_order(contacts, bodies)
    solve_trees(contacts, bodies, order, motion, enough)
    _sweep_all(contacts, order.pairs, iterations, enough, motion)
    _finish(contacts, bodies, motion)


@jit
def hold_pushed_boxes(
    contacts: Contacts, bodies: RigidBodies, push: np.ndarray, iterations: int, enough: float
) -> None:
    """Let the contacts that `solve_velocities` has solved hold boxes that were pushed since: `push` (m, 6)."""
    motion = load_motion(bodies)
    pass_down(contacts, bodies, push, motion)
    _sweep_all(contacts, sweep_order(contacts, bodies).pairs, iterations, enough, motion)
    _finish(contacts, bodies, motion)


@jit
def _finish(contacts: Contacts, bodies: RigidBodies, motion: np.ndarray) -> None:
    """Write the impulses to the contacts, and the motion to the bodies."""
    for k in range(contacts.number[1]):
        store(contacts.impulse, k, _impulse(contacts.row, k))
    store_motion(bodies, motion)


@jit
def _sweep_all(contacts: Contacts, pairs: np.ndarray, iterations: int, enough: float, motion: np.ndarray) -> None:
    """Sweep up and down by turns until no speed at a contact changes by more than `enough` [m/s].

    Or until `iterations` are done, and those that follow no longer converge FAST.
    """
    batches, motions = batches_of(contacts, pairs, motion.shape[0] - 1), motion.reshape(-1)
    before, is_stuck = inf, False
    for left in range((1 + MORE) * iterations, 0, -1):
        # The last one goes down, and leaves what is amiss at the top, where it moves least.
        down = left % 2 == 1
        changed = _sweep(batches, down, motions)
        if changed <= enough:
            break
        if down:
            is_stuck = changed > STUCK * before
            if left <= MORE * iterations + 1 and changed > FAST * before:
                break
            before = changed
    take_impulses(contacts, batches)
    if is_stuck and changed > enough:
        pressing = holds_pinched(contacts, motion.shape[0] - 1, NORMAL_IMPULSE)
        if pressing.shape[0] > 0:
            _give_way(contacts, batches, pressing, iterations, enough, motion)
            take_impulses(contacts, batches)


@jit
def _give_way(
    contacts: Contacts, batches: Batches, pressing: np.ndarray, iterations: int, enough: float, motion: np.ndarray
) -> None:
    """Sweep on, with contacts of what moves by script giving way to what their impulses have grown by in the step.

    Two jaws that close on a box leave it nowhere to go: each sweep hands it to the other jaw, with a larger impulse.
    """
    target, begun, count = np.empty(pressing.shape[0]), np.empty(pressing.shape[0]), 0
    for k in pressing:
        if _is_moved(contacts, k, 0, motion) or _is_moved(contacts, k, 1, motion):
            row, lane = batches.row[batches.place[k] // LANES], batches.place[k] % LANES
            begun[count] = max(0.0, component(contacts.row, k, NORMAL, load(contacts.impulse, k)))
            target[count] = row[TARGET, lane]
            row[MASS, lane] = contacts.row[k, MASS] / (1.0 + GIVING_WAY)
            pressing[count] = k
            count += 1
    for sweep in range(2 * iterations if count else 0):
        for place in range(count):
            k = pressing[place]
            row, lane = batches.row[batches.place[k] // LANES], batches.place[k] % LANES
            grown = max(0.0, row[NORMAL_IMPULSE, lane] - begun[place])
            row[TARGET, lane] = target[place] - GIVING_WAY / contacts.row[k, MASS] * grown
        if _sweep(batches, sweep % 2 == 1, motion.reshape(-1)) <= enough:
            break


@jit_lean
def _is_moved(contacts: Contacts, k: int, side: int, motion: np.ndarray) -> bool:
    """Tell whether a side of contact `k` has no mass, and moves."""
    body = contacts.box[k, side]
    if body == NOBODY or contacts.row[k, INVERSE_A if side == 0 else INVERSE_B] > 0.0:
        return False
    moves = False
    for c in range(motion.shape[1]):
        moves = moves or motion[body, c] != 0.0
    return moves


@jit_lean
def _sweep(batches: Batches, down: bool, motions: np.ndarray) -> float:
    """Correct the impulses of all contacts once; return the largest change of a speed at a contact [m/s].

    Batch by batch, or the other way round if `down`: forth and back, what the sweeps do is symmetric, and damps; always
    forth, it may swing. `motions` (6 m + 6,) are those of all bodies, one after the other. The velocities of pairs stay
    in the processor's registers from one contact to the next.
    """
    number = batches.start.shape[0] - 1
    most = spread(0.0)
    for place in range(number):
        t = number - 1 - place if down else place
        start, slots = batches.start[t], batches.start[t + 1] - batches.start[t]
        a, b = batches.body[t, 0], batches.body[t, 1]
        share_a, share_b = load_lanes(batches.share[t, 0], 0), load_lanes(batches.share[t, 1], 0)
        v_a, w_a = gather_vec(motions[0:], a), gather_vec(motions[3:], a)
        v_b, w_b = gather_vec(motions[0:], b), gather_vec(motions[3:], b)
        for turn in range(slots):
            row = batches.row[start + slots - 1 - turn if down else start + turn]
            # Along the normal: towards the target, and never pulling.
            pair = v_a, w_a, v_b, w_b
            mass, before = load_lanes(row[MASS], 0), load_lanes(row[NORMAL_IMPULSE], 0)
            normal = before + mass * (load_lanes(row[TARGET], 0) - _speed_in_lanes(row, NORMAL, pair))
            normal = where_less(0.0, normal, normal, 0.0)
            change = normal - before
            # Along the sliding that this leaves, by one number for both tangents: with the exact 2 × 2 solve, what the
            # bound leaves would not point against the sliding, and a box would slide on by a seventh too far.
            across = load_lanes(row[TANGENT_MASS], 0)
            slide_1 = _speed_in_lanes(row, TANGENT, pair) + change * load_lanes(row[COUPLING], 0)
            slide_2 = _speed_in_lanes(row, SECOND, pair) + change * load_lanes(row[SECOND_COUPLING], 0)
            before_1, before_2 = load_lanes(row[TANGENT_IMPULSE], 0), load_lanes(row[SECOND_IMPULSE], 0)
            first, second = within_friction_cones(
                before_1 - across * slide_1, before_2 - across * slide_2, load_lanes(row[FRICTION], 0) * normal
            )
            change_1, change_2 = first - before_1, second - before_2
            store_lanes(row[NORMAL_IMPULSE], 0, normal)
            store_lanes(row[TANGENT_IMPULSE], 0, first)
            store_lanes(row[SECOND_IMPULSE], 0, second)
            most = _larger(most, _size(change) / mass)
            most = _larger(most, (_size(change_1) + _size(change_2)) / across)
            impulse = change, change_1, change_2
            along = _combined_in_lanes(row, 0, impulse)
            v_a, v_b = add(v_a, scale(share_a, along)), sub(v_b, scale(share_b, along))
            w_a = add(w_a, _combined_in_lanes(row, TURN_A, impulse))
            w_b = sub(w_b, _combined_in_lanes(row, TURN_B, impulse))
        scatter_vec(motions[0:], a, v_a)
        scatter_vec(motions[3:], a, w_a)
        scatter_vec(motions[0:], b, v_b)
        scatter_vec(motions[3:], b, w_b)
    return -least_lane(0.0 - most)


@jit_lean
def _larger(a: Lanes, b: Lanes) -> Lanes:
    return where_less(a, b, b, a)


@jit_lean
def _size(a: Lanes) -> Lanes:
    return where_less(a, 0.0, 0.0 - a, a)


@jit_lean
def _three(row: np.ndarray, column: int) -> VecLanes:
    """Return three columns of a row (columns, 8), from `column` on."""
    return load_lanes(row[column], 0), load_lanes(row[column + 1], 0), load_lanes(row[column + 2], 0)


@jit_lean
def _speed_in_lanes(row: np.ndarray, direction: int, pair: tuple[VecLanes, VecLanes, VecLanes, VecLanes]) -> Lanes:
    """Return the speeds [m/s] along one direction, as `speed_along`."""
    v_a, w_a, v_b, w_b = pair
    d = 3 * direction
    turning = dot(_three(row, ANGULAR_A + d), w_a) - dot(_three(row, ANGULAR_B + d), w_b)
    return dot(_three(row, d), sub(v_a, v_b)) + turning


@jit_lean
def _combined_in_lanes(row: np.ndarray, column: int, impulse: VecLanes) -> VecLanes:
    """Return the sums of what `impulse` [N s] along the normal and both tangents does, from `column` on."""
    first, second = scale(impulse[1], _three(row, column + 3)), scale(impulse[2], _three(row, column + 6))
    return add(scale(impulse[0], _three(row, column)), add(first, second))


@jit_lean
def _impulse(row: np.ndarray, k: int) -> Vec:
    """Return the impulse [N s] on a of contact `k`, in the world."""
    normal, first, second = load_three(row, k, 0), load_three(row, k, 3), load_three(row, k, 6)
    size = load_three(row, k, NORMAL_IMPULSE)
    return add(scale(size[0], normal), add(scale(size[1], first), scale(size[2], second)))


@jit
def solve_positions(contacts: Contacts, bodies: RigidBodies, slop: float, iterations: int) -> np.ndarray:
    """Return (m + 1, 6) displacements [m] and turns [rad] that undo a BAUMGARTE part of each depth beyond `slop` [m].

    By pseudo-velocities that only push. Depths as small as the way that gravity moves a body in one step are what a
    solve that stops early leaves; undoing them too would lift a stack again and again, and feed it energy: ten boxes
    then never come to rest.
    """
    shift = np.zeros((bodies.inverse_mass.shape[0] + 1, 6))
    deep, row = np.empty(contacts.number[1], np.int64), contacts.row
    count = 0
    for k in range(contacts.number[1]):
        row[k, POSITION_IMPULSE] = 0.0
        if contacts.depth[k] > slop:
            deep[count] = k
            count += 1
    kept = np.ones(contacts.number[1] if count else 0)
    if count and _shift_all(contacts, deep[:count], kept, slop, iterations, shift):
        pressing = holds_pinched(contacts, bodies.inverse_mass.shape[0], POSITION_IMPULSE)
        if pressing.shape[0] > 0:
            shift[:] = row[:, POSITION_IMPULSE] = 0.0
            for k in pressing:
                kept[k] = 1.0 / (1.0 + GIVING_WAY)
            _shift_all(contacts, deep[:count], kept, slop, iterations, shift)
    return shift


@jit_lean
def _shift_all(
    contacts: Contacts, deep: np.ndarray, kept: np.ndarray, slop: float, iterations: int, shift: np.ndarray
) -> bool:
    """Sweep over the `deep` contacts, with the part of each impulse that is `kept`; tell whether they are stuck."""
    row, before, is_stuck = contacts.row, inf, False
    for _ in range(iterations):
        most = 0.0
        for k in deep:
            a, b = contacts.box[k, 0], contacts.box[k, 1]
            done = row[k, POSITION_IMPULSE]
            lack = BAUMGARTE * (contacts.depth[k] - slop) - speed_along(row, k, NORMAL, load_pair(shift, a, b))
            row[k, POSITION_IMPULSE] = max(0.0, kept[k] * (done + row[k, MASS] * lack))
            change = row[k, POSITION_IMPULSE] - done
            if change != 0.0:
                most = max(most, abs(change) / row[k, MASS])
                apply_impulse(row, k, NORMAL, change, shift, (a, b))
        if most <= CLOSE * slop:
            return False
        is_stuck, before = most > STUCK * before, most
    return is_stuck
