"""How do the materials of two bodies combine at a contact?"""

from __future__ import annotations

from math import sqrt

from softbody.jit import jit


@jit
def combined_restitution(a: float, b: float) -> float:
    """Return the restitution of a pair: the larger one, so that a lively ball bounces on a dead floor."""
    return max(a, b)


@jit
def combined_friction(a: float, b: float) -> float:
    """Return the friction coefficient of a pair: the geometric mean, so that one slippery side is enough."""
    return sqrt(a * b)
