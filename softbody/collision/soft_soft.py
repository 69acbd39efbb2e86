"""What happens where a particle of one soft body is inside another?"""

from __future__ import annotations

import numpy as np

from softbody.collision.patch import WHOLE, Corners, patch_mobility, patch_point, push_patch
from softbody.jit import jit_lean
from softbody.vec import Vec, dot, norm, scale, sub


@jit_lean
def part_particle_and_patch(
    particle: int,
    corners: Corners,
    weights: Vec,
    normal: Vec,
    depth: float,
    restitution: float,
    friction: float,
    inverse_mass: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
) -> float:
    """Part a particle and the patch of skin that it has gone through; return the normal impulse [N s]; paper §4.3.

    First both move apart along the unit `normal`, out of the skin, by `depth` [m] in proportion to how easily they
    move (the paper: half each, for equal masses). Then, where the two points now coincide, an impulse along the
    normal turns the approach into e times itself, and Coulomb friction takes at most μ times that impulse off the
    sliding. `position`, `velocity` (n, 3) [m], [m/s] are changed; `inverse_mass` (n,) [1/kg].
    """
    self = (particle, particle, particle)
    give = inverse_mass[particle] + patch_mobility(inverse_mass, corners, weights)
    if give == 0.0:
        return 0.0
    shift = scale(depth / give, normal)
    push_patch(position, inverse_mass, self, WHOLE, shift)
    push_patch(position, inverse_mass, corners, weights, scale(-1.0, shift))
    u = sub(patch_point(velocity, self, WHOLE), patch_point(velocity, corners, weights))
    approach = -dot(u, normal)
    if approach <= 0.0:
        return 0.0
    j = (1.0 + restitution) * approach / give
    push_patch(velocity, inverse_mass, self, WHOLE, scale(j, normal))
    push_patch(velocity, inverse_mass, corners, weights, scale(-j, normal))
    slide = sub(u, scale(dot(u, normal), normal))
    speed = norm(slide)
    if friction > 0.0 and speed > 0.0:
        drag = scale(-min(friction * j, speed / give) / speed, slide)
        push_patch(velocity, inverse_mass, self, WHOLE, drag)
        push_patch(velocity, inverse_mass, corners, weights, scale(-1.0, drag))
    return j
