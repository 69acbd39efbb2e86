"""Which impulses hold all that stands on something, found at once?

Sweeps pass weight on from contact to contact. A pile of n boxes bends like a beam, and its slowest bend takes of the
order of n⁴ sweeps; what they leave feeds itself from step to step, and the pile never rests. Here every box hangs on the
one that carries most of it, so that piles are trees, and the equations of a tree are solved exactly: eliminated from the
tips to the root, they fill no block that was empty (Baraff 1996, Linear-time dynamics using Lagrange multipliers).
Which contacts hold is guessed from the last step, and corrected: who would pull leaves, who would hold more than its
friction lets go (a primal active-set method). The sweeps then start from what was found.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from softbody.collision.contact import NOBODY, Contacts
from softbody.collision.law import within_friction_cone
from softbody.collision.solver_row import (
    ANGULAR_A,
    ANGULAR_B,
    APPROACH,
    MASS,
    NORMAL,
    NORMAL_IMPULSE,
    SECOND,
    TANGENT,
    TANGENT_MASS,
    TARGET,
    apply_impulse,
    load_pair,
    speed_along,
)
from softbody.collision.sweep_order import SweepOrder
from softbody.jit import jit, jit_lean
from softbody.quaternion import load_quaternion, rotate_diagonal
from softbody.state import RigidBodies
from softbody.vec import load

# A contact yields by this part of what it would take for nothing: with 1 the equations were a step of Jacobi's method,
# with 0 they had no unique solution wherever more contacts hold a box than it needs.
YIELD = 1e-8

# How often the contacts that hold are corrected in a step. (Piles at rest: once or twice; where boxes land, up to six.)
ROUNDS = 8

# In changes of speed that are not worth another sweep. A pair that met faster than the first stands on nothing yet:
# what holds there was no guide. Trees whose contacts lack less than the second are solved already.
LANDING, SOLVED = 1e5, 1e-3

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


class Equations(NamedTuple):
    """(M + Jᵀ D J) dv = Jᵀ D r by blocks: the masses M, the held contacts' Jacobian J, stiffness D and lack r of speed."""

    diagonal: np.ndarray  # (m, 6, 6), its lower triangles; then their Cholesky factors L
    link: np.ndarray  # (m, 6, 6) between each body and what carries it; then (L Lᵀ)⁻¹ link
    unknown: np.ndarray  # (m, 6) Jᵀ D r; then dv [m/s, rad/s]
    jacobian: np.ndarray  # (2, 6) of one direction of one contact: of the body that stands, and of what carries it


@jit
def solve_trees(contacts: Contacts, bodies: RigidBodies, order: SweepOrder, motion: np.ndarray, enough: float) -> None:
    """Correct the impulses of contacts, and `motion` (m + 1, 6), so that all that stands is held.

    Speeds of `enough` [m/s] are the least that matter. Of the correction of each tree as much is taken as takes away
    most energy: it never adds any.
    """
    count = bodies.inverse_mass.shape[0]
    forest = _plant(contacts, bodies, order, LANDING * enough)
    trial = _begin(contacts, forest, motion, SOLVED * enough)
    equations = Equations(np.empty((count, 6, 6)), np.empty((count, 6, 6)), np.empty((count, 6)), np.empty((2, 6)))
    for _ in range(ROUNDS):
        if not trial.unsolved.any():
            break
        _assemble(contacts, bodies, forest, trial, equations)
        _eliminate(bodies, forest, trial, equations)
        _correct(contacts, forest, trial, equations)
    _take(contacts, forest, trial, motion)


@jit
def _plant(contacts: Contacts, bodies: RigidBodies, order: SweepOrder, landing: float) -> Forest:
    """Return the forest: every box hangs on the pair below it that pushed it most in the last step."""
    count, number, level = bodies.inverse_mass.shape[0], order.pairs.shape[0], order.level
    best, most = np.full(count, NOBODY), np.zeros(count)
    standing, carrier = np.full(number, NOBODY), np.full(number, NOBODY)
    root = np.full(count + 1, NOBODY)
    for pair in range(number):
        k = order.pairs[pair, 0]
        a, b = contacts.box[k, 0], contacts.box[k, 1]
        if level[a] != level[b]:
            upper = a if level[a] > level[b] else b
            total = _push(contacts, order.pairs[pair, 0], order.pairs[pair, 1], landing)
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
def _push(contacts: Contacts, first: int, end: int, landing: float) -> float:
    """Return the sum of the normal impulses [N s] of a pair's contacts; 0 if any of them met faster than `landing`."""
    total = 0.0
    for k in range(first, end):
        if contacts.row[k, NORMAL_IMPULSE] > 0.0:
            if abs(contacts.row[k, APPROACH]) > landing:
                return 0.0
            total += contacts.row[k, NORMAL_IMPULSE]
    return total


@jit
def _begin(contacts: Contacts, forest: Forest, motion: np.ndarray, solved: float) -> Trial:
    """Return what holds so far, and which trees lack more than `solved` [m/s] somewhere."""
    row = contacts.row
    trial = Trial(
        np.zeros(contacts.number[1], np.int64),
        np.empty((contacts.number[1], 3)),
        motion.copy(),
        np.zeros(motion.shape[0], np.bool_),
    )
    for pair in range(forest.pairs.shape[0]):
        body = forest.standing[pair]
        if body == NOBODY:
            continue
        for k in range(forest.pairs[pair, 0], forest.pairs[pair, 1]):
            for d in range(3):
                trial.impulse[k, d] = row[k, NORMAL_IMPULSE + d]
            if row[k, NORMAL_IMPULSE] > 0.0:
                trial.does[k] = HOLDS if contacts.friction[k] > 0.0 else SLIDES
                for d in range(trial.does[k]):
                    if abs(_lack(contacts, k, d, motion)) > solved:
                        trial.unsolved[forest.root[body]] = True
    return trial


@jit_lean
def _lack(contacts: Contacts, k: int, direction: int, motion: np.ndarray) -> float:
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
def _assemble(contacts: Contacts, bodies: RigidBodies, forest: Forest, trial: Trial, equations: Equations) -> None:
    """Set up the equations of the unsolved trees."""
    for pair in range(forest.pairs.shape[0]):
        if _is_unsolved(forest, trial, pair):
            _put_mass(bodies, forest.standing[pair], equations)
    for pair in range(forest.pairs.shape[0]):
        if _is_unsolved(forest, trial, pair):
            bears = forest.carrier[pair] != NOBODY and bodies.inverse_mass[forest.carrier[pair]] > 0.0
            for k in range(forest.pairs[pair, 0], forest.pairs[pair, 1]):
                for d in range(trial.does[k]):
                    lack = _lack(contacts, k, d, trial.motion)
                    _load_jacobian(contacts, k, d, forest.standing[pair], equations.jacobian)
                    _add_contact(forest, pair, bears, (_stiffness(contacts.row, k, d), lack), equations)


@jit_lean
def _put_mass(bodies: RigidBodies, i: int, equations: Equations) -> None:
    """Set a body's block of the diagonal to its mass and R I Rᵀ, and the rest of its equations to 0."""
    q, inverse = load_quaternion(bodies.orientation, i), load(bodies.inverse_inertia, i)
    inertia = (1.0 / inverse[0], 1.0 / inverse[1], 1.0 / inverse[2])
    for r in range(6):
        equations.unknown[i, r] = 0.0
        for c in range(6):
            equations.diagonal[i, r, c] = equations.link[i, r, c] = 0.0
    for k in range(3):
        column = rotate_diagonal(q, inertia, (1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0))
        equations.diagonal[i, k, k] = 1.0 / bodies.inverse_mass[i]
        for c in range(3):
            equations.diagonal[i, 3 + c, 3 + k] = column[c]


@jit_lean
def _load_jacobian(contacts: Contacts, k: int, direction: int, body: int, jacobian: np.ndarray) -> None:
    """Put the Jacobian of one direction of a contact into `jacobian` (2, 6): of `body`, and of what carries it."""
    row, d = contacts.row, 3 * direction
    a = 0 if contacts.box[k, 0] == body else 1
    for c in range(3):
        jacobian[a, c], jacobian[1 - a, c] = row[k, d + c], -row[k, d + c]
        jacobian[a, 3 + c], jacobian[1 - a, 3 + c] = row[k, ANGULAR_A + d + c], -row[k, ANGULAR_B + d + c]


@jit_lean
def _add_contact(forest: Forest, pair: int, bears: bool, spring: tuple[float, float], equations: Equations) -> None:
    """Add Jᵀ D J and Jᵀ D r of one direction of a contact; `spring` is (D, r), `bears` if what carries can move."""
    i, carrier, jacobian = forest.standing[pair], forest.carrier[pair], equations.jacobian
    stiffness, lack = spring
    for r in range(6):
        s = stiffness * jacobian[0, r]
        equations.unknown[i, r] += s * lack
        for c in range(r + 1):
            equations.diagonal[i, r, c] += s * jacobian[0, c]
        if bears:
            for c in range(6):
                equations.link[i, r, c] += s * jacobian[1, c]
    if bears:
        for r in range(6):
            s = stiffness * jacobian[1, r]
            equations.unknown[carrier, r] += s * lack
            for c in range(r + 1):
                equations.diagonal[carrier, r, c] += s * jacobian[1, c]


@jit
def _eliminate(bodies: RigidBodies, forest: Forest, trial: Trial, equations: Equations) -> None:
    """Solve the equations of the unsolved trees: from the tips to the roots, and back."""
    diagonal, link, unknown = equations.diagonal, equations.link, equations.unknown
    number = forest.pairs.shape[0]
    right = np.empty((6, 6))
    for pair in range(number - 1, -1, -1):
        if not _is_unsolved(forest, trial, pair):
            continue
        i, carrier = forest.standing[pair], forest.carrier[pair]
        _factor(diagonal[i])
        _solve_factored(diagonal[i], unknown[i])
        if carrier == NOBODY or bodies.inverse_mass[carrier] == 0.0:
            continue
        # What the body asks of its carrier: linkᵀ times its own solution.
        for c in range(6):
            for r in range(6):
                right[c, r] = link[i, r, c]
            for r in range(6):
                unknown[carrier, c] -= right[c, r] * unknown[i, r]
        for c in range(6):
            column = link[i, :, c]
            _solve_factored(diagonal[i], column)
            for r in range(c, 6):
                for k in range(6):
                    diagonal[carrier, r, c] -= right[r, k] * column[k]
    for pair in range(number):
        if _is_unsolved(forest, trial, pair):
            i, carrier = forest.standing[pair], forest.carrier[pair]
            if carrier != NOBODY and bodies.inverse_mass[carrier] > 0.0:
                for r in range(6):
                    for c in range(6):
                        unknown[i, r] -= link[i, r, c] * unknown[carrier, c]


@jit_lean
def _factor(block: np.ndarray) -> None:
    """Replace the lower triangle of a symmetric positive definite `block` (6, 6) by its Cholesky factor."""
    for r in range(6):
        for c in range(r + 1):
            s = block[r, c]
            for k in range(c):
                s -= block[r, k] * block[c, k]
            block[r, c] = np.sqrt(s) if r == c else s / block[c, c]


@jit_lean
def _solve_factored(factor: np.ndarray, x: np.ndarray) -> None:
    """Replace `x` (6,) by the solution y of L Lᵀ y = x, with L the lower triangle of `factor` (6, 6)."""
    for r in range(6):
        for k in range(r):
            x[r] -= factor[r, k] * x[k]
        x[r] /= factor[r, r]
    for r in range(5, -1, -1):
        for k in range(r + 1, 6):
            x[r] -= factor[k, r] * x[k]
        x[r] /= factor[r, r]


@jit
def _correct(contacts: Contacts, forest: Forest, trial: Trial, equations: Equations) -> None:
    """Correct the impulses by what was solved for, within their bounds. A tree where one met its bound stays unsolved."""
    wanted, left = trial.motion.copy(), np.zeros(trial.unsolved.shape[0], np.bool_)
    for pair in range(forest.pairs.shape[0]):
        if _is_unsolved(forest, trial, pair):
            for c in range(6):
                wanted[forest.standing[pair], c] += equations.unknown[forest.standing[pair], c]
    for pair in range(forest.pairs.shape[0]):
        if _is_unsolved(forest, trial, pair):
            for k in range(forest.pairs[pair, 0], forest.pairs[pair, 1]):
                if trial.does[k] != OPEN and _correct_contact(contacts, k, wanted, trial):
                    left[forest.root[forest.standing[pair]]] = True
    for i in range(left.shape[0]):
        trial.unsolved[i] = left[i]


@jit_lean
def _correct_contact(contacts: Contacts, k: int, wanted: np.ndarray, trial: Trial) -> bool:
    """Correct the impulse of contact `k` for motions `wanted` (m + 1, 6); tell whether it met a bound, and leaves."""
    row, pair = contacts.row, (contacts.box[k, 0], contacts.box[k, 1])
    normal, first, second = trial.impulse[k, 0], trial.impulse[k, 1], trial.impulse[k, 2]
    normal += _stiffness(row, k, NORMAL) * _lack(contacts, k, NORMAL, wanted)
    if trial.does[k] == HOLDS:
        first += _stiffness(row, k, TANGENT) * _lack(contacts, k, TANGENT, wanted)
        second += _stiffness(row, k, SECOND) * _lack(contacts, k, SECOND, wanted)
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


@jit
def _take(contacts: Contacts, forest: Forest, trial: Trial, motion: np.ndarray) -> None:
    """Move each tree's impulses and motions towards those of the trial, as far as its energy falls.

    Along that way the energy ½ v·M v − Σ λ·target is a parabola; the impulses allowed at each contact are convex.
    """
    row = contacts.row
    fall, curvature = np.zeros(motion.shape[0]), np.zeros(motion.shape[0])
    for pair in range(forest.pairs.shape[0]):
        if forest.standing[pair] != NOBODY:
            root = forest.root[forest.standing[pair]]
            for k in range(forest.pairs[pair, 0], forest.pairs[pair, 1]):
                for d in range(3):
                    change = trial.impulse[k, d] - row[k, NORMAL_IMPULSE + d]
                    before = _lack(contacts, k, d, motion)
                    fall[root] += change * before
                    curvature[root] += change * (before - _lack(contacts, k, d, trial.motion))
    part = np.zeros(motion.shape[0])
    for i in range(motion.shape[0]):
        if fall[i] > 0.0:
            part[i] = min(1.0, fall[i] / curvature[i])
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
