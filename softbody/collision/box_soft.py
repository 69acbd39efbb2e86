"""What happens where a particle is inside a box, or a corner of a box inside a soft body?"""

from __future__ import annotations

import numpy as np

from softbody.collision.impulse import apply_impulse, point_mobility, point_velocity
from softbody.collision.patch import Corners, patch_mobility, patch_point, push_patch
from softbody.jit import jit_lean
from softbody.quaternion import Quaternion, rotate, rotate_inverse
from softbody.state import RigidBodies
from softbody.vec import Vec, accumulate, dot, norm, scale, sub


@jit_lean
def point_in_box(p: Vec, size: Vec, position: Vec, orientation: Quaternion) -> tuple[float, Vec]:
    """Return (depth [m], normal): how far `p` is behind the closest face, and that face's outward normal; paper §4.7.

    A negative depth: outside. `size` is the full extent [m].
    """
    local = rotate_inverse(orientation, sub(p, position))
    depth = np.inf
    normal = (0.0, 0.0, 0.0)
    for axis in range(3):
        behind = 0.5 * size[axis] - abs(local[axis])
        if behind < depth:
            depth = behind
            side = 1.0 if local[axis] >= 0.0 else -1.0
            normal = (side if axis == 0 else 0.0, side if axis == 1 else 0.0, side if axis == 2 else 0.0)
    return depth, rotate(orientation, normal)


@jit_lean
def part_patch_and_box(
    corners: Corners,
    weights: Vec,
    box: int,
    normal: Vec,
    depth: float,
    restitution: float,
    friction: float,
    inverse_mass: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
    bodies: RigidBodies,
) -> float:
    """Part a patch of skin and a box that overlap; return the normal impulse [N s]; paper §4.2.

    `normal` is the unit vector from the box to the skin. First both move apart by `depth` [m], by inverse mass; the
    box without turning. Then one impulse at the patch's point, with the mobility 1/m + 1/M + n · [(I⁻¹ (r × n)) × r]
    (the paper bounces from the masses alone), and friction as between soft bodies. Arrays as in soft_soft.
    """
    soft = patch_mobility(inverse_mass, corners, weights)
    give = soft + bodies.inverse_mass[box]
    if give == 0.0:
        return 0.0
    shift = scale(depth / give, normal)
    push_patch(position, inverse_mass, corners, weights, shift)
    accumulate(bodies.position, box, scale(-bodies.inverse_mass[box], shift))
    point = patch_point(position, corners, weights)
    u = sub(patch_point(velocity, corners, weights), point_velocity(bodies, box, point))
    approach = -dot(u, normal)
    if approach <= 0.0:
        return 0.0
    j = (1.0 + restitution) * approach / (soft + point_mobility(bodies, box, point, normal))
    push_patch(velocity, inverse_mass, corners, weights, scale(j, normal))
    apply_impulse(bodies, box, point, scale(-j, normal))
    if friction > 0.0:
        u = sub(patch_point(velocity, corners, weights), point_velocity(bodies, box, point))
        slide = sub(u, scale(dot(u, normal), normal))
        speed = norm(slide)
        if speed > 0.0:
            along = scale(1.0 / speed, slide)
            drag = min(friction * j, speed / (soft + point_mobility(bodies, box, point, along)))
            push_patch(velocity, inverse_mass, corners, weights, scale(-drag, along))
            apply_impulse(bodies, box, point, scale(drag, along))
    return j
