"""Forces of joints, damped springs between points of bodies, on the bodies in a step: see `acting`."""

from __future__ import annotations

import numpy as np

from softbody.compiler.jit import jit, jit_lean
from softbody.linalg.quaternion import load_quaternion, rotate, rotation_matrix
from softbody.linalg.vec import Vec, accumulate, add, cross, dot, load, norm, scale, sub
from softbody.model.arrays import NOBODY, Controls, Joints, Model, State
from softbody.model.surface_point import WHOLE, SurfacePoint, value_at


@jit
def add_joint_forces(state: State, joints: Joints, ahead: float, acting: Controls) -> None:
    """Add the forces of all joints to what acts on bodies; ends on soft bodies as they will be `ahead` [s]."""
    for k in range(joints.joint_stiffness.shape[0]):
        force = _force(state, joints, k, ahead)
        _act(state, joints, k, 0, force, ahead, acting)
        _act(state, joints, k, 1, scale(-1.0, force), ahead, acting)


@jit_lean
def _force(state: State, joints: Joints, k: int, ahead: float) -> Vec:
    """Return the force [N] of a joint on its first end; ends on soft bodies as they will be `ahead` [s].

    Of a length at rest it acts along the joint; of none, it pulls one end to the other, and damps all their motion.
    """
    (a, v_a), (b, v_b) = _end(state, joints, k, 0, ahead), _end(state, joints, k, 1, ahead)
    away, closing = sub(a, b), sub(v_b, v_a)
    stiffness, damping, rest = joints.joint_stiffness[k], joints.joint_damping[k], joints.joint_rest_length[k]
    if rest == 0.0:
        return add(scale(-stiffness, away), scale(damping, closing))
    length = norm(away)
    if length == 0.0:
        return 0.0, 0.0, 0.0  # it may push any way
    along = scale(1.0 / length, away)
    return scale(stiffness * (rest - length) + damping * dot(closing, along), along)


@jit_lean
def _end(state: State, joints: Joints, k: int, end: int, ahead: float) -> tuple[Vec, Vec]:
    """Return where an end is, on a soft body `ahead` [s] by its velocity [m], and that velocity now [m/s]."""
    box = joints.joint_box[k, end]
    if box != NOBODY:
        arm = _arm(state, joints, k, end)
        turning = cross(load(state.box_angular_velocity, box), arm)
        return add(load(state.box_position, box), arm), add(load(state.box_velocity, box), turning)
    if joints.joint_inside[k, 2 * end] != NOBODY:
        v = _carried(state.particle_velocity, joints, k, end)
        return add(_carried(state.particle_position, joints, k, end), scale(ahead, v)), v
    if joints.joint_particles[k, 3 * end] == NOBODY:
        return _place(joints, k, end), (0.0, 0.0, 0.0)
    point = _point(joints, k, end)
    v = value_at(state.particle_velocity, point)
    return add(value_at(state.particle_position, point), scale(ahead, v)), v


@jit_lean
def _carried(rows: np.ndarray, joints: Joints, k: int, end: int) -> Vec:
    """Return Σ w x of `rows` (n, 3) for an end that is inside a soft body."""
    particle, last, weight = _carriers(joints, k, end)
    total = (0.0, 0.0, 0.0)
    while particle < last:
        total = add(total, scale(joints.weight[weight], load(rows, particle)))
        particle, weight = particle + 1, weight + 1
    return total


@jit_lean
def _carriers(joints: Joints, k: int, end: int) -> tuple[int, int, int]:
    """Return which particles carry an end inside a soft body, from the first up to an end, and the first weight."""
    suspension, point = joints.joint_inside[k, 2 * end], joints.joint_inside[k, 2 * end + 1]
    first, last = joints.suspension_particles[suspension, 0], joints.suspension_particles[suspension, 1]
    return first, last, joints.suspension_start[suspension] + point * (last - first)


@jit_lean
def _arm(state: State, joints: Joints, k: int, end: int) -> Vec:
    """Return the way [m] from the centre of a box to the end that is on it."""
    return rotate(load_quaternion(state.box_orientation, joints.joint_box[k, end]), _place(joints, k, end))


@jit_lean
def _place(joints: Joints, k: int, end: int) -> Vec:
    return joints.joint_place[k, 3 * end], joints.joint_place[k, 3 * end + 1], joints.joint_place[k, 3 * end + 2]


@jit_lean
def _point(joints: Joints, k: int, end: int) -> SurfacePoint:
    first, weights = joints.joint_particles, joints.joint_weights
    c = 3 * end
    if first[k, c] == first[k, c + 1]:
        return SurfacePoint((first[k, c], first[k, c], first[k, c]), WHOLE)
    return SurfacePoint(
        (first[k, c], first[k, c + 1], first[k, c + 2]), (weights[k, c], weights[k, c + 1], weights[k, c + 2])
    )


@jit_lean
def _act(state: State, joints: Joints, k: int, end: int, force: Vec, ahead: float, acting: Controls) -> None:
    """Add the force [N] on an end to what acts on its body, if it is on one.

    A box that hangs in a soft body is pushed where that pushes back: damping, which need not act along the joint, turns
    neither then.
    """
    box = joints.joint_box[k, end]
    if box != NOBODY:
        accumulate(acting.box_force, box, force)
        if joints.joint_inside[k, 2 - 2 * end] != NOBODY:
            place, _ = _end(state, joints, k, 1 - end, ahead)
            accumulate(acting.box_torque, box, cross(sub(place, load(state.box_position, box)), force))
        else:
            accumulate(acting.box_torque, box, cross(_arm(state, joints, k, end), force))
    elif joints.joint_inside[k, 2 * end] != NOBODY:
        particle, last, weight = _carriers(joints, k, end)
        while particle < last:
            accumulate(acting.particle_force, particle, scale(joints.weight[weight], force))
            particle, weight = particle + 1, weight + 1
    elif joints.joint_particles[k, 3 * end] != NOBODY:
        point = _point(joints, k, end)
        for c in range(3):
            accumulate(acting.particle_force, point.particles[c], scale(point.weights[c], force))


def no_joints() -> Joints:
    """Return no joints, and nothing that hangs in a body."""
    none, number = np.zeros(0), np.zeros(0, np.int64)
    pairs, fours, sixes = (np.zeros((0, columns), np.int64) for columns in (2, 4, 6))
    joints = pairs, sixes, np.zeros((0, 6)), fours, np.zeros((0, 6)), none, none, none
    return Joints(*joints, pairs.copy(), number, np.zeros(1, np.int64), none)


def weights_of(joints: Joints, suspension: int) -> np.ndarray:
    """Return the weights (k, n) of a suspension's points, a view: of each particle of their body."""
    first, end = joints.suspension_particles[suspension]
    rows = slice(*joints.suspension_start[suspension : suspension + 2])
    return joints.weight[rows].reshape(-1, end - first)


def carried(joints: Joints, suspension: int, rows: np.ndarray) -> np.ndarray:
    """Return Σ w x (k, 3) of `rows` (n, 3) of all particles, for each of a suspension's points."""
    return np.asarray(weights_of(joints, suspension) @ rows[slice(*joints.suspension_particles[suspension])])


def joint_ends(joints: Joints, state: State) -> np.ndarray:
    """Return where both ends of each joint are (j, 2, 3) [m]."""
    count = len(joints.joint_stiffness)
    ends = joints.joint_place.reshape(count, 2, 3).copy()
    particles, weights = joints.joint_particles.reshape(count, 2, 3), joints.joint_weights.reshape(count, 2, 3)
    for k, end in np.argwhere(particles[:, :, 0] != NOBODY):
        ends[k, end] = weights[k, end] @ state.particle_position[particles[k, end]]
    inside = joints.joint_inside.reshape(count, 2, 2)
    for k, end in np.argwhere(inside[:, :, 0] != NOBODY):
        suspension, point = inside[k, end]
        ends[k, end] = carried(joints, suspension, state.particle_position)[point]
    for k, end in np.argwhere(joints.joint_box != NOBODY):
        box = joints.joint_box[k, end]
        ends[k, end] = state.box_position[box] + rotation_matrix(state.box_orientation[box]) @ ends[k, end]
    return ends


def joint_energy(joints: Joints, state: State) -> float:
    """Return ½ Σ k (l − l0)² [J] of all joints."""
    ends = joint_ends(joints, state)
    stretch = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1) - joints.joint_rest_length
    return float(0.5 * (joints.joint_stiffness * stretch**2).sum())


def joint_rates(joints: Joints, model: Model) -> tuple[float, float]:
    """Return upper bounds of the highest frequency [1/s] and of the fastest damping rate [1/s] that joints have.

    For each joint |x_a − x_b|² ≤ 2 |x_a|² + 2 |x_b|²; a point of a triangle moves by no more than its corners, by their
    weights, and a point at an arm r of a box by (1/M + r² max 1/I) times its energy, twice. Of a point inside a body
    weights may be below 0: |Σ w x|² ≤ Σ |w| Σ |w| |x|². So ω² is at most twice the largest sum of k times that over the
    joints of one particle or box, and γ the same of c.
    """
    sums = np.zeros((2, len(model.particle_inverse_mass) + model.box_count))
    first_box = len(model.particle_inverse_mass)
    count = len(joints.joint_stiffness)
    particles, weights = joints.joint_particles.reshape(count, 2, 3), joints.joint_weights.reshape(count, 2, 3)
    with np.errstate(over="ignore", invalid="ignore"):  # what is too much is inf
        for row, rate in enumerate((joints.joint_stiffness, joints.joint_damping)):
            for end in range(2):
                on_soft = particles[:, end, 0] != NOBODY
                np.add.at(sums[row], particles[on_soft, end], rate[on_soft, None] * weights[on_soft, end])
                inside = joints.joint_inside.reshape(count, 2, 2)[:, end]
                for k in np.flatnonzero(inside[:, 0] != NOBODY):
                    share = np.abs(weights_of(joints, inside[k, 0])[inside[k, 1]])
                    sums[row, slice(*joints.suspension_particles[inside[k, 0]])] += rate[k] * share * share.sum()
                on_box = joints.joint_box[:, end] != NOBODY
                box = joints.joint_box[on_box, end]
                arm = joints.joint_place.reshape(count, 2, 3)[on_box, end]
                turning = _times((arm**2).sum(axis=1), model.box_inverse_inertia[box].max(axis=1, initial=0.0))
                mobility = model.box_inverse_mass[box] + turning
                np.add.at(sums[row], first_box + box, _times(rate[on_box], mobility))
        sums[:, :first_box] = _times(sums[:, :first_box], model.particle_inverse_mass)
        most = 2.0 * sums.max(axis=1, initial=0.0)
    return float(np.sqrt(most[0])), float(most[1])


def _times(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a · b, where nothing times what is too much is nothing."""
    return np.nan_to_num(a * b, nan=0.0, posinf=np.inf)
