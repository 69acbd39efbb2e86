"""Shadow map (Williams 1978) of parallel light, held up by undersides."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from softbody.compiler.jit import jit_lean
from softbody.render.coverage import faces_up, span, weights_at

TEXELS = 512  # of the shadow map, each way: about as fine as the pixels of a scene that fills the picture
BIAS = 0.01  # of the scene's unit that a caster must be above what it shades: what touches is 0 apart
LIGHT = np.array([-0.55, -0.45, 1.0]) / np.linalg.norm([-0.55, -0.45, 1.0])  # where the light comes from
SLANT = LIGHT[:2] / LIGHT[2]  # how far a ray of it goes sideways [m] for each metre of height


class Shadow(NamedTuple):
    """How high the light is held up: a ray of light belongs to the texel in which it passes z = 0."""

    highest: np.ndarray  # (TEXELS, TEXELS) height of the highest underside that the ray meets [m], −inf for none
    low: np.ndarray  # (2,) corner of the map [m]
    step: float  # side of a texel [m]
    bias: float  # [m] that a caster must be above what it shades


def shadow_of(meshes: Sequence[tuple[np.ndarray, np.ndarray]], unit: float) -> Shadow:
    """Return the shadow that `meshes`, vertices and triangles of each, cast together, on the ground and each other.

    `unit` [m] is a length of the size of what is seen.
    """
    highest = np.full((TEXELS, TEXELS), -np.inf)
    passing = [vertices[:, :2] - vertices[:, 2:] * SLANT for vertices, _ in meshes]
    if not passing:
        return Shadow(highest, np.zeros(2), 1.0, BIAS * unit)
    every = np.concatenate(passing)
    low = every.min(axis=0)
    step = float((every.max(axis=0) - low).max()) / (TEXELS - 2) + 1e-9 * unit  # a picture of one point has a step, too
    for (vertices, triangles), flat in zip(meshes, passing):
        _hold_up(highest, (flat - low) / step, vertices[:, 2], np.ascontiguousarray(triangles))
    return Shadow(highest, low, step, BIAS * unit)


@jit_lean
def _hold_up(highest, flat, heights, triangles):
    """Enter the undersides of a thing, whose vertices are at texels `flat` (n, 2) and `heights` (n,) [m].

    Undersides alone, so that no surface in the light is shaded by itself, on a map that is coarser than it.
    """
    for t in range(triangles.shape[0]):
        i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        a, b, c = flat[i], flat[j], flat[k]
        if faces_up(a, b, c):
            continue
        for x in span(a, b, c, 0, highest.shape[0]):
            for y in span(a, b, c, 1, highest.shape[1]):
                u, v, w = weights_at(a, b, c, x + 0.5, y + 0.5)
                if u >= 0.0 and v >= 0.0 and w >= 0.0:
                    height = u * heights[i] + v * heights[j] + w * heights[k]
                    highest[x, y] = max(highest[x, y], height)


@jit_lean
def light_at(shadow, x, y, z):
    """Return which part of the light reaches a point [m]: of the four texels around it, by their nearness.

    That is percentage-closer filtering (Reeves, Salesin and Cook 1987).
    """
    across = (x - z * SLANT[0] - shadow.low[0]) / shadow.step - 0.5
    along = (y - z * SLANT[1] - shadow.low[1]) / shadow.step - 0.5
    if not (0.0 <= across < TEXELS - 1.0 and 0.0 <= along < TEXELS - 1.0):
        return 1.0
    i, j = int(across), int(along)
    p, q = across - i, along - j
    high = shadow.highest
    dark = (1.0 - p) * (1.0 - q) * (high[i, j] > z + shadow.bias) + p * (1.0 - q) * (high[i + 1, j] > z + shadow.bias)
    dark += (1.0 - p) * q * (high[i, j + 1] > z + shadow.bias) + p * q * (high[i + 1, j + 1] > z + shadow.bias)
    return 1.0 - dark
