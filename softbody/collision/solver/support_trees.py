"""Direct solver for piles of boxes: impulses that hold all that stands on something, found at once.

Sweeps pass weight on from contact to contact. A pile of n boxes bends like a beam, and its slowest bend takes of the
order of n⁴ sweeps; what they leave feeds itself from step to step, and the pile never rests. Here every box hangs on
the one that carries most of it, so that piles are trees, and the equations of a tree are solved exactly, from the tips
to the root and back (Featherstone 1983; Baraff 1996, Linear-time dynamics using Lagrange multipliers). Which contacts
hold is guessed from the last step, and corrected: what would pull leaves, what would be entered joins, what would hold
more than its friction slides (an active-set method). The sweeps then start from what was found.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from softbody.collision.contact import Contacts
from softbody.collision.solver.cholesky import factor, solve_lower, solve_upper
from softbody.collision.solver.solver_row import (
    ANGULAR_A,
    ANGULAR_B,
    MASS,
    NORMAL,
    NORMAL_IMPULSE,
    SECOND,
    TANGENT,
    TANGENT_MASS,
    TARGET,
    apply_impulse,
    load_pair,
    load_three,
    speed_along,
)
from softbody.collision.solver.sweep_order import SweepOrder
from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.quaternion import load_quaternion, rotate_diagonal
from softbody.linalg.vec import Vec, add, cross, load, scale, sub
from softbody.model.arrays import NOBODY, RigidBodies
from softbody.model.material import within_friction_cone

# A contact yields by this part of what it would take for nothing: with 1 the equations were a step of Jacobi's method,
# with 0 they had no unique solution wherever more contacts hold a box than it needs. The slowest bend of fifty boxes is
# about so much softer than a contact; what is missing of it, the next round finds (iterative refinement).
YIELD = 1e-6

# How often the contacts that hold are corrected in a step: at rest once. (With half as often, towers of forty boxes of
# mixed sizes that land fall; with twice as often they stand no better.)
ROUNDS = 8

# The part of the speeds that matter to which held contacts are solved. What YIELD leaves of an impact, a millionth, is
# more than enough to set a tower of fifty boxes swinging.
FINE = 1e-2

# A tree is left to the sweeps if in two rounds on end more than this part of its contacts changed what they do, as in
# heaps that tumble: they seldom are solved, and cost all rounds. (The piles of the claims stand the same without it.)
HOPELESS = 0.25

# A contact is taken to slide from so many times `enough` on: as fast as gravity makes a body in a step. What holds
# creeps, too, a little, while it is solved for.
SLIDING = 1e4

# What a contact does: nothing, keep its distance, or its place; along so many directions it is held.
OPEN, SLIDES, HOLDS = 0, 1, 3


class Forest(NamedTuple):
    """By which pair each box stands, and on what: a tree for each box that stands on a body that cannot move."""

    pairs: np.ndarray  # (p, 2) first contact of each pair, and the one after its last; the pairs from below
    standing: np.ndarray  # (p,) the body that stands by this pair, or NOBODY
    carrier: np.ndarray  # (p,) what it stands on: a body, or NOBODY for the ground
    root: np.ndarray  # (m + 1,) the lowest body of the tree of each body, or NOBODY


class Trial(NamedTuple):
    """Impulses that may become those of the contacts."""

    does: np.ndarray  # (c,) OPEN, SLIDES or HOLDS
    impulse: np.ndarray  # (c, 3) [N s] along the normal and both tangents
    motion: np.ndarray  # (m + 1, 6) v [m/s] and ω [rad/s] with these impulses
    unsolved: np.ndarray  # (m + 1,) of bool: which trees are not solved, by their roots
    size: np.ndarray  # (m + 1,) how many contacts each tree has
    amiss: np.ndarray  # (m + 1,) and how many of them changed what they do in the last round


class Equations(NamedTuple):
    """(M + Jᵀ D J) dv = Jᵀ D r, of the masses M, the Jacobian J of what holds, its stiffness D and lack r of speed.

    Blocks of the velocity and angular velocity of each body, about its centre.
    """

    inertia: np.ndarray  # (m, 6, 6) M and what stands on the body, lower triangles; then the Cholesky factors L
    stiffness: np.ndarray  # (m, 6, 6) K = Jᵀ D J of the contacts by which the body stands; then W = L⁻¹ K
    pull: np.ndarray  # (m, 6) [N s, N m s] Jᵀ D r of them
    unknown: np.ndarray  # (m, 6) [N s, N m s] the right side; then dv [m/s, rad/s]


@jit
def solve_trees(contacts: Contacts, bodies: RigidBodies, order: SweepOrder, motion: np.ndarray, enough: float) -> None:
    """Correct the impulses of contacts, and `motion` (m + 1, 6), so that all that stands is held.

    Speeds of `enough` [m/s] are the least that matter. Of the correction of each tree as much is taken as its contacts
    ask for: where nothing slides, as much as takes away most energy. It never adds any.
    """
    forest = plant(contacts, bodies, order)
    trial = _begin(contacts, forest, motion, enough)
    shape = (bodies.inverse_mass.shape[0], 6, 6)
    equations = Equations(np.empty(shape), np.empty(shape), np.empty(shape[:2]), np.empty(shape[:2]))
    for _ in range(ROUNDS):
        if not trial.unsolved.any():
            break
        assemble(contacts, bodies, forest, trial, equations)
        eliminate(bodies, forest, trial, equations)
        _correct(contacts, forest, trial, equations, enough)
    _take(contacts, forest, trial, motion, SLIDING * enough)


@jit
def plant(contacts: Contacts, bodies: RigidBodies, order: SweepOrder) -> Forest:
    """Return the forest: every box hangs on the pair below it that pushed it most in the last step."""
    count, number, level = bodies.inverse_mass.shape[0], order.pairs.shape[0], order.level
    best, most = np.full(count, NOBODY), np.full(count, -1.0)
    standing, carrier = np.full(number, NOBODY), np.full(number, NOBODY)
    root = np.full(count + 1, NOBODY)
    for pair in range(number):
        k = order.pairs[pair, 0]
        a, b = contacts.box[k, 0], contacts.box[k, 1]
        if level[a] != level[b]:
            upper = a if level[a] > level[b] else b
            total = _push(contacts, order.pairs[pair, 0], order.pairs[pair, 1])
            if total > most[upper]:
                most[upper], best[upper] = total, pair
    # From below: a body is in a tree if what carries it is, or cannot move.
    for pair in range(number):
        k = order.pairs[pair, 0]
        a, b = contacts.box[k, 0], contacts.box[k, 1]
        upper, lower = (a, b) if level[a] > level[b] else (b, a)
        if upper != NOBODY and best[upper] == pair and (level[lower] == 0 or root[lower] != NOBODY):
            standing[pair], carrier[pair] = upper, lower
            root[upper] = upper if level[lower] == 0 else root[lower]
    return Forest(order.pairs, standing, carrier, root)


@jit_lean
def _push(contacts: Contacts, first: int, end: int) -> float:
    """Return the sum of the normal impulses [N s] of a pair's contacts."""
    total = 0.0
    for k in range(first, end):
        total += contacts.row[k, NORMAL_IMPULSE]
    return total


@jit
def _begin(contacts: Contacts, forest: Forest, motion: np.ndarray, enough: float) -> Trial:
    """Return what may hold; a tree where something does is not solved.

    What pushed in the last step, and of a pair that did not push yet all that would come nearer. What bounces is left
    to the sweeps: their impact is exact.
    """
    row = contacts.row
    trial = Trial(
        np.zeros(contacts.number[1], np.int64),
        np.empty((contacts.number[1], 3)),
        motion.copy(),
        np.zeros(motion.shape[0], np.bool_),
        np.zeros(motion.shape[0], np.int64),
        np.zeros(motion.shape[0], np.int64),
    )
    for pair in range(forest.pairs.shape[0]):
        body = forest.standing[pair]
        if body == NOBODY:
            continue
        trial.size[forest.root[body]] += forest.pairs[pair, 1] - forest.pairs[pair, 0]
        is_new = _push(contacts, forest.pairs[pair, 0], forest.pairs[pair, 1]) == 0.0
        for k in range(forest.pairs[pair, 0], forest.pairs[pair, 1]):
            for d in range(3):
                trial.impulse[k, d] = row[k, NORMAL_IMPULSE + d]
            pushes = row[k, NORMAL_IMPULSE] > 0.0 or (
                is_new and _velocity_deficit(contacts, k, NORMAL, motion) >= -enough
            )
            if pushes and row[k, TARGET] <= enough:
                trial.does[k] = HOLDS if contacts.friction[k] > 0.0 else SLIDES
                trial.unsolved[forest.root[body]] = True
    return trial


@jit_lean
def _velocity_deficit(contacts: Contacts, k: int, direction: int, motion: np.ndarray) -> float:
    """Return the speed [m/s] that a contact lacks along one direction."""
    speed = speed_along(contacts.row, k, direction, load_pair(motion, contacts.box[k, 0], contacts.box[k, 1]))
    return contacts.row[k, TARGET] - speed if direction == NORMAL else -speed


@jit_lean
def _stiffness(row: np.ndarray, k: int, direction: int) -> float:
    """Return the impulse [kg] along one direction for each m/s that is lacking."""
    return row[k, MASS if direction == NORMAL else TANGENT_MASS] / YIELD


@jit_lean
def _is_unsolved(forest: Forest, trial: Trial, pair: int) -> bool:
    """Tell whether a pair is one by which a body of an unsolved tree stands."""
    body = forest.standing[pair]
    return body != NOBODY and trial.unsolved[forest.root[body]]


@jit
def assemble(contacts: Contacts, bodies: RigidBodies, forest: Forest, trial: Trial, equations: Equations) -> None:
    """Set up the equations of the unsolved trees."""
    for pair in range(forest.pairs.shape[0]):
        if _is_unsolved(forest, trial, pair):
            i = forest.standing[pair]
            _put_mass(bodies, i, equations)
            for k in range(forest.pairs[pair, 0], forest.pairs[pair, 1]):
                for d in range(trial.does[k]):
                    impulse = _stiffness(contacts.row, k, d) * _velocity_deficit(contacts, k, d, trial.motion)
                    _add_contact(contacts, (k, d), i, impulse, equations)


@jit_lean
def _put_mass(bodies: RigidBodies, i: int, equations: Equations) -> None:
    """Start a body's equations from its mass and R I Rᵀ, and nothing that acts."""
    q, inverse = load_quaternion(bodies.orientation, i), load(bodies.inverse_inertia, i)
    inertia = (1.0 / inverse[0], 1.0 / inverse[1], 1.0 / inverse[2])
    for r in range(6):
        equations.unknown[i, r] = equations.pull[i, r] = 0.0
        for c in range(6):
            equations.inertia[i, r, c] = equations.stiffness[i, r, c] = 0.0
    for k in range(3):
        column = rotate_diagonal(q, inertia, (1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0))
        equations.inertia[i, k, k] = 1.0 / bodies.inverse_mass[i]
        for c in range(3):
            equations.inertia[i, 3 + c, 3 + k] = column[c]


@jit_lean
def _add_contact(contacts: Contacts, held: tuple[int, int], i: int, impulse: float, equations: Equations) -> None:
    """Add Jᵀ D J and Jᵀ times the `impulse` D r of contact k along direction d, `held` = (k, d), by which i stands."""
    row, k, d = contacts.row, held[0], 3 * held[1]
    stiffness = _stiffness(row, k, held[1])
    if contacts.box[k, 0] == i:
        force, torque = load_three(row, k, d), load_three(row, k, ANGULAR_A + d)
    else:
        force, torque = scale(-1.0, load_three(row, k, d)), scale(-1.0, load_three(row, k, ANGULAR_B + d))
    jacobian = (force[0], force[1], force[2], torque[0], torque[1], torque[2])
    for r in range(6):
        equations.pull[i, r] += impulse * jacobian[r]
        for c in range(r + 1):
            equations.stiffness[i, r, c] += stiffness * jacobian[r] * jacobian[c]


@jit
def eliminate(bodies: RigidBodies, forest: Forest, trial: Trial, equations: Equations) -> None:
    """Solve the equations of the unsolved trees: from the tips to the roots, and back.

    Every body passes on to its carrier what is left of its pull, and how stiffly it holds on: that of the contacts
    and of the body, with all it carries, one after the other (Featherstone 1983, articulated bodies).
    """
    stiffness, unknown = equations.stiffness, equations.unknown
    number = forest.pairs.shape[0]
    passed, pull = np.empty((6, 6)), np.empty(6)
    for pair in range(number - 1, -1, -1):
        if not _is_unsolved(forest, trial, pair):
            continue
        i, carrier = forest.standing[pair], forest.carrier[pair]
        for r in range(6):
            unknown[i, r] += equations.pull[i, r]
            for c in range(r + 1):
                equations.inertia[i, r, c] += stiffness[i, r, c]
                stiffness[i, c, r] = stiffness[i, r, c]
        factor(equations.inertia[i])
        solve_lower(equations.inertia[i], unknown[i])
        if _moves(bodies, carrier):
            _pass_on(equations, i, passed, pull)
            arm = sub(load(bodies.position, i), load(bodies.position, carrier))
            _add_moved(passed, pull, arm, equations, carrier)
    for pair in range(number):
        if _is_unsolved(forest, trial, pair):
            i, carrier = forest.standing[pair], forest.carrier[pair]
            if _moves(bodies, carrier):
                arm = sub(load(bodies.position, i), load(bodies.position, carrier))
                spin = load_three(unknown, carrier, 3)
                speed = add(load_three(unknown, carrier, 0), cross(spin, arm))
                moved = (speed[0], speed[1], speed[2], spin[0], spin[1], spin[2])
                for c in range(6):
                    for r in range(6):
                        unknown[i, r] += stiffness[i, c, r] * moved[c]
            solve_upper(equations.inertia[i], unknown[i])


@jit_lean
def _moves(bodies: RigidBodies, carrier: int) -> bool:
    """Tell whether a carrier, which may be NOBODY, can move."""
    return carrier != NOBODY and bodies.inverse_mass[carrier] > 0.0


@jit_lean
def _pass_on(equations: Equations, i: int, passed: np.ndarray, pull: np.ndarray) -> None:
    """Set `passed` (6, 6) and `pull` (6,) to what body `i` passes on of the stiffness K of its contacts: K − Wᵀ W.

    Replaces K by W = L⁻¹ K, a row for each column.
    """
    k, y = equations.stiffness[i], equations.unknown[i]
    for r in range(6):
        for c in range(r + 1):
            passed[r, c] = k[r, c]
    for r in range(6):
        solve_lower(equations.inertia[i], k[r])
    for r in range(6):
        pull[r] = equations.pull[i, r]
        for j in range(6):
            pull[r] -= k[r, j] * y[j]
        for c in range(r + 1):
            for j in range(6):
                passed[r, c] -= k[r, j] * k[c, j]
            passed[c, r] = passed[r, c]


@jit_lean
def _add_moved(passed: np.ndarray, pull: np.ndarray, arm: Vec, equations: Equations, carrier: int) -> None:
    """Add a stiffness (6, 6) and a pull (6,) about a body's centre to what carries it, by `arm` [m] away."""
    for c in range(6):
        torque = cross(arm, (passed[0, c], passed[1, c], passed[2, c]))
        passed[3, c], passed[4, c], passed[5, c] = (
            passed[3, c] + torque[0],
            passed[4, c] + torque[1],
            passed[5, c] + torque[2],
        )
    for r in range(6):
        torque = cross(arm, (passed[r, 0], passed[r, 1], passed[r, 2]))
        moved = add((passed[r, 3], passed[r, 4], passed[r, 5]), torque)
        row = (passed[r, 0], passed[r, 1], passed[r, 2], moved[0], moved[1], moved[2])
        for c in range(r + 1):
            equations.inertia[carrier, r, c] += row[c]
    torque = add((pull[3], pull[4], pull[5]), cross(arm, (pull[0], pull[1], pull[2])))
    for c in range(3):
        equations.unknown[carrier, c] -= pull[c]
        equations.unknown[carrier, 3 + c] -= torque[c]


@jit
def _correct(contacts: Contacts, forest: Forest, trial: Trial, equations: Equations, enough: float) -> None:
    """Correct the impulses by what was solved for, within their bounds.

    A tree is not solved where a contact met its bound, or joins, or what is held still lacks speed; some are given up.
    """
    wanted, left = trial.motion.copy(), np.zeros(trial.unsolved.shape[0], np.bool_)
    amiss = np.zeros(trial.unsolved.shape[0], np.int64)
    for pair in range(forest.pairs.shape[0]):
        if _is_unsolved(forest, trial, pair):
            for c in range(6):
                wanted[forest.standing[pair], c] += equations.unknown[forest.standing[pair], c]
    for pair in range(forest.pairs.shape[0]):
        if _is_unsolved(forest, trial, pair):
            for k in range(forest.pairs[pair, 0], forest.pairs[pair, 1]):
                if trial.does[k] == OPEN:
                    changed = _close_contact(contacts, k, wanted, trial, enough)
                else:
                    changed = _correct_contact(contacts, k, wanted, trial)
                if changed:
                    left[forest.root[forest.standing[pair]]] = True
                    amiss[forest.root[forest.standing[pair]]] += 1
    for pair in range(forest.pairs.shape[0]):
        if _is_unsolved(forest, trial, pair):
            for k in range(forest.pairs[pair, 0], forest.pairs[pair, 1]):
                for d in range(trial.does[k]):
                    if abs(_velocity_deficit(contacts, k, d, trial.motion)) > FINE * enough:
                        left[forest.root[forest.standing[pair]]] = True
    for i in range(left.shape[0]):
        trial.unsolved[i] = left[i] and min(amiss[i], trial.amiss[i]) <= HOPELESS * trial.size[i]
        trial.amiss[i] = amiss[i]


@jit_lean
def _close_contact(contacts: Contacts, k: int, wanted: np.ndarray, trial: Trial, enough: float) -> bool:
    """Let contact `k` hold if motions `wanted` (m + 1, 6) enter it, and it does not bounce; tell whether it does."""
    enters = contacts.row[k, TARGET] <= enough and _velocity_deficit(contacts, k, NORMAL, wanted) > enough
    if enters:
        trial.does[k] = HOLDS if contacts.friction[k] > 0.0 else SLIDES
    return enters


@jit_lean
def _correct_contact(contacts: Contacts, k: int, wanted: np.ndarray, trial: Trial) -> bool:
    """Correct the impulse of contact `k` for motions `wanted` (m + 1, 6); tell whether it met a bound, and leaves."""
    row, pair = contacts.row, (contacts.box[k, 0], contacts.box[k, 1])
    normal, first, second = trial.impulse[k, 0], trial.impulse[k, 1], trial.impulse[k, 2]
    normal += _stiffness(row, k, NORMAL) * _velocity_deficit(contacts, k, NORMAL, wanted)
    if trial.does[k] == HOLDS:
        first += _stiffness(row, k, TANGENT) * _velocity_deficit(contacts, k, TANGENT, wanted)
        second += _stiffness(row, k, SECOND) * _velocity_deficit(contacts, k, SECOND, wanted)
    pulls = normal < 0.0
    normal = max(0.0, normal)
    s, t = within_friction_cone(first, second, contacts.friction[k] * normal)
    slips = trial.does[k] == HOLDS and (s != first or t != second)
    if pulls:
        trial.does[k] = OPEN
    elif slips:
        trial.does[k] = SLIDES
    apply_impulse(row, k, NORMAL, normal - trial.impulse[k, 0], trial.motion, pair)
    apply_impulse(row, k, TANGENT, s - trial.impulse[k, 1], trial.motion, pair)
    apply_impulse(row, k, SECOND, t - trial.impulse[k, 2], trial.motion, pair)
    trial.impulse[k, 0], trial.impulse[k, 1], trial.impulse[k, 2] = normal, s, t
    return pulls or slips


@jit_lean
def _drive(contacts: Contacts, k: int, direction: int, motion: np.ndarray, sliding: float) -> float:
    """Return the speed [m/s] by which a contact asks for more impulse along one direction.

    What it lacks; along the normal less μ times what it slides by, if that is `sliding` [m/s] or more (de Saxcé and
    Feng 1998). By the lack alone a higher load would be a gain wherever the friction that it allows takes energy, and
    what slides fast would be lifted off.
    """
    drive = _velocity_deficit(contacts, k, direction, motion)
    if direction == NORMAL and contacts.friction[k] > 0.0:
        first, second = _velocity_deficit(contacts, k, TANGENT, motion), _velocity_deficit(contacts, k, SECOND, motion)
        slide = sqrt(first * first + second * second)
        if slide >= sliding:
            drive -= contacts.friction[k] * slide
    return drive


@jit
def _take(contacts: Contacts, forest: Forest, trial: Trial, motion: np.ndarray, sliding: float) -> None:
    """Move each tree's impulses and motions towards those of the trial, as far as its contacts together ask for it.

    Coulomb's law: of all impulses allowed, which are convex, none is asked for more than those that act. Along the way
    to the trial the asking is taken to fall evenly, as it does without sliding, where it is the slope of the energy
    ½ v·M v − Σ λ·target. What slides at `sliding` [m/s] or more does. Nothing is taken that would add energy.
    """
    row, count = contacts.row, motion.shape[0]
    asked, left = np.zeros(count), np.zeros(count)  # at the start and at the end of the way, in all
    lack, lack_left = np.zeros(count), np.zeros(count)  # the same, of the energy alone
    for pair in range(forest.pairs.shape[0]):
        if forest.standing[pair] != NOBODY:
            root = forest.root[forest.standing[pair]]
            for k in range(forest.pairs[pair, 0], forest.pairs[pair, 1]):
                for d in range(3):
                    change = trial.impulse[k, d] - row[k, NORMAL_IMPULSE + d]
                    asked[root] += change * _drive(contacts, k, d, motion, sliding)
                    left[root] += change * _drive(contacts, k, d, trial.motion, sliding)
                    lack[root] += change * _velocity_deficit(contacts, k, d, motion)
                    lack_left[root] += change * _velocity_deficit(contacts, k, d, trial.motion)
    part = np.zeros(count)
    for i in range(count):
        if asked[i] > 0.0:
            # (All of it where the trial still asks to go on. By rounding too, where it is all but where they are.)
            part[i] = asked[i] / (asked[i] - left[i]) if left[i] < 0.0 else 1.0
        if lack[i] - 0.5 * part[i] * (lack[i] - lack_left[i]) < 0.0:
            part[i] = 0.0  # it would add energy
    for pair in range(forest.pairs.shape[0]):
        body = forest.standing[pair]
        if body != NOBODY:
            for k in range(forest.pairs[pair, 0], forest.pairs[pair, 1]):
                for d in range(3):
                    row[k, NORMAL_IMPULSE + d] += part[forest.root[body]] * (
                        trial.impulse[k, d] - row[k, NORMAL_IMPULSE + d]
                    )
            for c in range(6):
                motion[body, c] += part[forest.root[body]] * (trial.motion[body, c] - motion[body, c])
