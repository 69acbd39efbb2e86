"""Contacts of a soft body with itself: of near features, those that could come nearer than the skin is thick.

They are found before anything goes through: where features are when a step begins says from which side they meet. Of
all pairs about one place, that is taken which is nearest as seen from both sides; else what slides over an edge would
catch on it.
"""

from __future__ import annotations

import numpy as np

from softbody.collision.contact import Contacts, Side, Touch, add_contact, soft_side
from softbody.collision.soft.near_features import (
    TRIANGLE,
    Members,
    features_of,
    kind_of,
    members,
    nearest_weights,
    way_to,
)
from softbody.collision.soft.surface import Surface
from softbody.compiler.jit import jit_lean
from softbody.geometry.triangle import weighted_point
from softbody.linalg.vec import Vec, add, cross, dot, load, norm, scale, sub
from softbody.model.material import Material
from softbody.model.surface_point import SurfacePoint, at_particle

# Sine of the angle by which what is beside a feature may be nearer: bent inwards by less, a surface counts as flat.
SLACK = 0.1

# Part of the skin's distance below which all pairs count, whatever is nearer: nothing must be missed there.
CLOSE = 0.3


@jit_lean
def add_self_contacts(
    surface: Surface,
    moved: tuple[np.ndarray, np.ndarray, np.ndarray, float],
    pairs: np.ndarray,
    gaps: np.ndarray,
    distance: float,
    material: Material,
    contacts: Contacts,
) -> None:
    """Add the contacts that `pairs` (p,) with `gaps` (p,) [m] at a step's start may have, at a `distance` [m].

    `moved`: vertices (n, 3) [m] before and after the step, where their common motion carries them, and its stretch.
    """
    before, after, carried, stretch = moved
    for k in range(pairs.shape[0]):
        if not gaps[k] > 0.0:
            continue
        kind, gap, four = kind_of(pairs[k]), gaps[k], members(surface, pairs[k])
        far = stretch * gap - _most_way(kind, four, after, carried) > distance
        if far or gap - own_way(kind, four, before, after)[0] > distance:
            continue
        (i, j, m, n), features = four, features_of(pairs[k])
        weights, place = nearest_weights(kind, load(before, i), load(before, j), load(before, m), load(before, n))
        if kind == TRIANGLE:
            p = load(before, i)
            q = weighted_point(weights, load(before, j), load(before, m), load(before, n))
            normal = way_to(p, q, gap)
            if not _face_is_nearest(surface, before, features, weights, q, normal, gap <= CLOSE * distance):
                continue
            a, b = at_particle(i), SurfacePoint((j, m, n), weights)
        else:
            u, v = place[0], weights[0]
            if u <= 0.0 or u >= 1.0 or v <= 0.0 or v >= 1.0:
                continue
            p = _between(before, i, j, u)
            q = _between(before, m, n, v)
            normal = way_to(p, q, gap)
            if gap > CLOSE * distance and not _edges_are_nearest(surface, before, features, four, (p, q), normal):
                continue
            (third, facing), (other, other_facing) = (
                _beside(surface, before, features[0], normal),
                _beside(surface, before, features[1], normal),
            )
            a = SurfacePoint((i, j, third), (1.0 - u, u, 0.0))
            b = SurfacePoint((m, n, other), (1.0 - v, v, 0.0))
            if facing > other_facing:  # what reacts has to have a triangle that the line through both meets
                a, b, normal = b, a, scale(-1.0, normal)
        apart = sub(_value(after, a), _value(after, b))
        middle = scale(0.5, add(_value(after, a), _value(after, b)))
        touch = Touch(middle, normal, distance - dot(apart, normal), 0)
        add_contact(contacts, _side(surface, a), _side(surface, b), touch, material)


@jit_lean
def _side(surface: Surface, point: SurfacePoint) -> Side:
    """Return the side of a contact that a point of a surface is."""
    (i, j, k), first = point.particles, surface.first
    return soft_side(SurfacePoint((first + i, first + j, first + k), point.weights))


@jit_lean
def _value(rows: np.ndarray, point: SurfacePoint) -> Vec:
    """Return where a point of a surface is [m]."""
    (i, j, k), (u, v, w) = point.particles, point.weights
    return add(scale(u, load(rows, i)), add(scale(v, load(rows, j)), scale(w, load(rows, k))))


@jit_lean
def _between(rows: np.ndarray, i: int, j: int, place: float) -> Vec:
    return add(scale(1.0 - place, load(rows, i)), scale(place, load(rows, j)))


@jit_lean
def _most_way(kind: int, four: Members, after: np.ndarray, carried: np.ndarray) -> float:
    """Return how far the features of a pair move against each other at most, besides what carries both."""
    i, j, k, m = four
    a, b, c, d = _off(after, carried, i), _off(after, carried, j), _off(after, carried, k), _off(after, carried, m)
    return a + max(b, c, d) if kind == TRIANGLE else max(a, b) + max(c, d)


@jit_lean
def _off(after: np.ndarray, carried: np.ndarray, i: int) -> float:
    return norm(sub(load(after, i), load(carried, i)))


@jit_lean
def own_way(kind: int, four: Members, before: np.ndarray, after: np.ndarray) -> tuple[float, Vec]:
    """Return how far the features of a pair move against each other at most, and the mean motion of its members."""
    i, j, k, m = four
    a, b = sub(load(after, i), load(before, i)), sub(load(after, j), load(before, j))
    c, d = sub(load(after, k), load(before, k)), sub(load(after, m), load(before, m))
    mean = scale(0.25, add(add(a, b), add(c, d)))
    one, two, three, four_ = norm(sub(a, mean)), norm(sub(b, mean)), norm(sub(c, mean)), norm(sub(d, mean))
    if kind == TRIANGLE:
        return one + max(two, three, four_), mean
    return max(one, two) + max(three, four_), mean


@jit_lean
def _rises(x: np.ndarray, u: int, place: Vec, normal: Vec) -> bool:
    """Tell whether a vertex beside a place rises along a normal, so that something nearer is beside it."""
    way = sub(load(x, u), place)
    return dot(way, normal) > SLACK * norm(way)


@jit_lean
def _face_is_nearest(
    surface: Surface, x: np.ndarray, features: tuple[int, int], weights: Vec, place: Vec, normal: Vec, is_close: bool
) -> bool:
    """Tell whether a triangle has the point nearest to a particle, seen from all that is beside that; else another has.

    A triangle beside one that the particle is a corner of has it in any case: the two must not fold on to each other.
    """
    v, t = features
    zeros = (weights[0] == 0.0) + (weights[1] == 0.0) + (weights[2] == 0.0)
    if zeros == 0 or is_close:
        return True
    if zeros == 1:
        c = 0 if weights[0] == 0.0 else 1 if weights[1] == 0.0 else 2
        side = surface.sides[t, (c + 1) % 3]
        edge = side if side >= 0 else -1 - side
        third = surface.triangles[t, c]
        u = surface.ridges[edge, 2] if surface.ridges[edge, 3] == third else surface.ridges[edge, 3]
        other = surface.wings[edge, 0] if surface.wings[edge, 1] == t else surface.wings[edge, 1]
        return u == v or not (_faces_more(surface, x, other, t, normal) or _rises(x, u, place, normal))
    c = 0 if weights[0] != 0.0 else 1 if weights[1] != 0.0 else 2
    corner, beside, is_best = surface.triangles[t, c], False, True
    now = t
    while True:  # around the corner, from triangle to triangle
        c = 0 if surface.triangles[now, 0] == corner else 1 if surface.triangles[now, 1] == corner else 2
        u, side = surface.triangles[now, (c + 1) % 3], surface.sides[now, c]
        if u == v:
            beside = True
        elif _rises(x, u, place, normal):
            return False
        edge = side if side >= 0 else -1 - side
        now = surface.wings[edge, 0] if surface.wings[edge, 1] == now else surface.wings[edge, 1]
        if now == t:
            return beside or is_best
        is_best = is_best and not _faces_more(surface, x, now, t, normal)


@jit_lean
def _faces_more(surface: Surface, x: np.ndarray, one: int, other: int, normal: Vec) -> bool:
    """Tell whether a triangle faces a normal more than another does; of two that face it alike, the first does."""
    more, less = _facing(surface, x, one, normal), _facing(surface, x, other, normal)
    return more > less or (more == less and one < other)


@jit_lean
def _edges_are_nearest(
    surface: Surface, x: np.ndarray, features: tuple[int, int], four: Members, places: tuple[Vec, Vec], normal: Vec
) -> bool:
    """Tell whether two edges have the points nearest to each other, seen from the triangles beside them."""
    (i, j, k, m), (p, q), back = four, places, scale(-1.0, normal)
    for side in range(2, 4):
        u = surface.ridges[features[1], side]
        if u != i and u != j and _rises(x, u, q, normal):
            return False
        u = surface.ridges[features[0], side]
        if u != k and u != m and _rises(x, u, p, back):
            return False
    return True


@jit_lean
def _beside(surface: Surface, x: np.ndarray, edge: int, normal: Vec) -> tuple[int, float]:
    """Return the third corner of that triangle beside an edge which faces a normal the most, and how much it does."""
    third, steepest = surface.ridges[edge, 2], _facing(surface, x, surface.wings[edge, 0], normal)
    steep = _facing(surface, x, surface.wings[edge, 1], normal)
    if steep > steepest:
        third, steepest = surface.ridges[edge, 3], steep
    return 0 + third, steepest  # of 64 bits, as others are


@jit_lean
def _facing(surface: Surface, x: np.ndarray, t: int, normal: Vec) -> float:
    """Return the squared cosine between a triangle's normal and another one; 0 without an area."""
    a = load(x, surface.triangles[t, 0])
    up = cross(sub(load(x, surface.triangles[t, 1]), a), sub(load(x, surface.triangles[t, 2]), a))
    square, rise = dot(up, up), dot(up, normal)
    return rise * rise / square if square > 0.0 else 0.0
