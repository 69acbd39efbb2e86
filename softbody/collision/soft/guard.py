"""What keeps a surface from going through itself in any case: motion that might lead there is cut.

The last of a step, and all but never needed, as contacts hold. Whether a pair of features may meet on its way is told
by conservative advancement (Li et al. 2021): time goes on by no more than the features need to meet at the speed of the
fastest. What is cut is the motion beside that which a body's points have in common; both momenta are given back to it.
"""

from __future__ import annotations

import numpy as np

from softbody.collision.soft.near_features import gap_of, kind_of, members, most_of
from softbody.collision.soft.self_rows import own_way
from softbody.collision.soft.surface import Surface
from softbody.compiler.jit import jit, jit_lean
from softbody.geometry.affine_fit import inertia_of, mean_of, solved
from softbody.linalg.vec import Vec, accumulate, add, cross, load, norm, scale, store, sub

# The part of a gap that is left in any case, and the part of the skin's distance, if that is more of a small gap.
LEFT, OF_DISTANCE, MOST_LEFT = 0.1, 0.05, 0.7
ONE_GO, AT_MOST = 0.95, 30  # of what time may go on by; how often


@jit_lean
def least_left(gap: float, distance: float) -> float:
    """Return how much [m] of a gap must be left."""
    return max(LEFT * gap, min(OF_DISTANCE * distance, MOST_LEFT * gap))


@jit_lean
def never_meet(surface: Surface, pair: int, gap: float, distance: float, x: np.ndarray, y: np.ndarray) -> bool:
    """Tell whether the features of a pair keep apart on straight ways from x to y (n, 3) [m]; "no" may be wrong."""
    kind, four, left = kind_of(pair), members(surface, pair), least_left(gap, distance)
    most, mean = own_way(kind, four, x, y)
    if most < gap - left:
        return True
    i, j, k, m = four
    time, now = 0.0, gap
    for _ in range(AT_MOST):
        time += ONE_GO * (now - (1.0 - LEFT) * left) / most
        if time >= 1.0:
            return True
        p, q = _on_way(x, y, mean, i, time), _on_way(x, y, mean, j, time)
        r, s = _on_way(x, y, mean, k, time), _on_way(x, y, mean, m, time)
        now = gap_of(kind, p, q, r, s)
        if now < left:
            return False
    return False


@jit_lean
def _on_way(x: np.ndarray, y: np.ndarray, mean: Vec, i: int, time: float) -> Vec:
    return add(load(x, i), scale(time, sub(sub(load(y, i), load(x, i)), mean)))


@jit
def cut_motion(
    surface: Surface,
    pairs: np.ndarray,
    gaps: np.ndarray,
    distance: float,
    moved: tuple[np.ndarray, np.ndarray, np.ndarray, float],
    steps: np.ndarray,
    velocity: np.ndarray,
    h: float,
) -> int:
    """Cut the motion of vertices that might come through the surface, and their velocities; return how many.

    `moved`: vertices before and after the step, which change, where what they have in common carries them, and its
    stretch; `steps` (n,) [m]: how far from there they end, at least. All `pairs` (p,) are there, with their `gaps`
    (p,) [m], that were nearer than a `distance` [m] or may meet; of a gap < 0 it may not, and of one of 0 it does.
    """
    before, after, carried, stretch = moved
    n, count = before.shape[0], 0
    room, is_cut, is_new = np.full(n, distance), np.zeros(n, np.bool_), np.zeros(n, np.bool_)
    is_first = True
    while True:
        any_new = False
        for k in range(pairs.shape[0]):
            if not gaps[k] > 0.0:
                continue
            i, j, m, p = members(surface, pairs[k])
            if is_first:
                for v in (i, j, m, p):
                    room[v] = min(room[v], gaps[k])
            elif not 0 < is_cut[i] + is_cut[j] + is_cut[m] + is_cut[p] < 4:
                continue
            if (1.0 - LEFT) * gaps[k] > most_of(pairs[k], steps, (i, j, m, p)):
                continue
            if not never_meet(surface, pairs[k], gaps[k], distance, before, after):
                for v in (i, j, m, p):
                    if not is_cut[v]:
                        is_new[v], any_new = True, True
        if not any_new:
            return count
        is_first = False
        for v in range(n):
            if is_new[v]:
                is_new[v], is_cut[v] = False, True
                count += 1
                place = load(carried, v)
                way = sub(load(after, v), place)
                far, most = norm(way), 0.5 * (stretch * room[v] - least_left(room[v], distance))
                if far > most:
                    new = add(place, scale(max(0.0, most) / far, way))
                    accumulate(velocity, v, scale(1.0 / h, sub(new, load(after, v))))
                    store(after, v, new)


@jit
def give_back(
    inverse_mass: np.ndarray, position: np.ndarray, velocity: np.ndarray, place: np.ndarray, speed: np.ndarray
) -> None:
    """Give a body the momenta that it had at places (n, 3) [m] and speeds (n, 3) [m/s]; all particles weigh alike."""
    n = position.shape[0]
    middle, lost, moment = mean_of(position), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for i in range(n):
        if inverse_mass[i] == 0.0:  # what holds it has taken them
            return
        r, v, u = sub(load(position, i), middle), load(velocity, i), load(speed, i)
        lost, was = add(lost, sub(u, v)), cross(sub(load(place, i), middle), u)
        moment = add(moment, sub(was, cross(r, v)))
    turn = solved(inertia_of(position, middle), moment)
    for i in range(n):
        r = sub(load(position, i), middle)
        accumulate(velocity, i, add(scale(1.0 / n, lost), cross(turn, r)))
