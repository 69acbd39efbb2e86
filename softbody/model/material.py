"""The law of contact: how materials combine, and Newton's restitution and Coulomb's friction for one impulse.

Every response asks here: single impulses, the ground, soft bodies, and the solver of many contacts.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from softbody.compiler.jit import jit, jit_lean
from softbody.compiler.simd import Lanes, square_root, where_less
from softbody.model.arrays import Model


class Material(NamedTuple):
    """What a contact knows of the materials that meet."""

    restitution: float  # e, 0 … 1
    friction: float  # Coulomb coefficient μ, ≥ 0


@jit
def combined(a: Material, b: Material) -> Material:
    """Return the material of a pair.

    The larger restitution, so that a lively ball bounces on a dead floor; the geometric mean of the friction
    coefficients, so that one slippery side is enough.
    """
    return Material(max(a.restitution, b.restitution), sqrt(a.friction * b.friction))


@jit_lean
def material_of_soft(model: Model, body: int) -> Material:
    """Return the material of a soft body."""
    return Material(model.soft_restitution[body], model.soft_friction[body])


@jit_lean
def material_of_box(model: Model, box: int) -> Material:
    """Return the material of a box."""
    return Material(model.box_restitution[box], model.box_friction[box])


@jit_lean
def material_of_ground(model: Model) -> Material:
    """Return the material of the ground."""
    return Material(model.ground_restitution, model.ground_friction)


@jit
def speed_after(approach: float, restitution: float) -> float:
    """Return the speed [m/s] at which two points must part that approached at `approach` [m/s]: e times that."""
    return restitution * approach


@jit
def normal_impulse(approach: float, inverse_mass: float, restitution: float) -> float:
    """Return j = (1 + e) approach / inverse mass [N s]: what turns the approach [m/s] of two points into e times that.

    `inverse_mass` [1/kg] is the inverse effective mass along the normal, of both sides together.
    """
    return (1.0 + restitution) * approach / inverse_mass


@jit
def friction_impulse(sliding: float, inverse_mass: float, limit: float) -> float:
    """Return the impulse [N s] against a `sliding` [m/s]: what stops it, and at most `limit`, μ j."""
    return min(limit, sliding / inverse_mass)


@jit
def sliding_kept(sliding: float, approach: float, material: Material) -> float:
    """Return the share of its `sliding` [m/s] that friction leaves a point that strikes something fixed.

    A free point, such as a particle, whose inverse effective mass is the same in every direction: it loses at most
    μ (1 + e) times its `approach` [m/s].
    """
    return max(0.0, 1.0 - material.friction * (1.0 + material.restitution) * approach / sliding)


@jit
def within_friction_cone(first: float, second: float, limit: float) -> tuple[float, float]:
    """Return two components of a tangential impulse [N s], made shorter where it is longer than `limit`, μ j."""
    square = first * first + second * second
    if square > limit * limit:
        kept = limit / sqrt(square)
        return kept * first, kept * second
    return first, second


@jit_lean
def within_friction_cones(first: Lanes, second: Lanes, limit: Lanes) -> tuple[Lanes, Lanes]:
    """Do the same in lanes."""
    square = first * first + second * second
    kept = limit / square_root(where_less(0.0, square, square, 1.0))  # of nothing, all is kept
    return (
        where_less(limit * limit, square, kept * first, first),
        where_less(limit * limit, square, kept * second, second),
    )
