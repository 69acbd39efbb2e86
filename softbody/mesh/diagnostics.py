"""Diagnostics of a closed mesh, on request: findings too slow to look for, or too often meant, to refuse it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softbody.geometry.connected import fans, half_edges
from softbody.geometry.self_intersections import self_intersections
from softbody.mesh.shells import Shells, enclosing, shells_of, volume_of_rounding
from softbody.mesh.weld import first_at_place

THIN = 1e-3  # of its longest edge: the height of a triangle below which it counts as one without area
UNEQUAL = 100.0  # times the shortest edge: the longest, from which on springs of one stiffness are told


@dataclass(frozen=True, eq=False)
class Finding:
    """What is doubtful in a mesh. `str(finding)` says all of it.

    `kind`, and what the rows of `where` are:
    "several shells": the first triangle of each (s,);
    "nested": the first triangle of each shell (s,) that faces outwards within another, so that its volume counts twice;
    "flat shell": that of each shell (s,) that encloses no volume;
    "coincident triangles": pairs of triangles (p, 2) that have their corners at the same three places;
    "self-intersections": pairs of triangles (p, 2) that go through each other, touch, or lie on each other;
    "pinched vertices": vertices (v,) with more than one fan of triangles;
    "touching vertices": vertices (v,) at the place of another one;
    "thin triangles": triangles (t,) lower than a thousandth of their longest edge;
    "unequal edges": vertices (2, 2) of the shortest and the longest edge.
    """

    kind: str
    what: str  # in a sentence, with the first culprit
    cure: str
    where: np.ndarray

    def __str__(self) -> str:
        return f"{self.kind}: {self.what}; {self.cure}"


def findings(vertices: np.ndarray, triangles: np.ndarray, edges: np.ndarray, edge_of: np.ndarray) -> list[Finding]:
    """Return what is doubtful in a closed mesh, of edges (e, 2) and the edge (3 t,) of each half-edge."""
    place = first_at_place(vertices)
    meeting, coincident = self_intersections(vertices, triangles, place)
    found = shells_of(vertices, triangles, edge_of)
    several = (
        _about_shells(vertices, triangles, found, np.concatenate([meeting, coincident])) if len(found.volume) else []
    )
    return [
        *several,
        *_about_pairs(meeting, coincident),
        *_about_vertices(place, fans(triangles, half_edges(edge_of))),
        *_about_shapes(vertices, triangles, edges),
    ]


def _about_shells(vertices: np.ndarray, triangles: np.ndarray, found: Shells, meeting: np.ndarray) -> list[Finding]:
    """Return what is doubtful in how several shells lie; of those whose triangles meet nobody says which is within."""
    volume, first = found.volume, found.first
    flat = np.abs(volume) <= volume_of_rounding(vertices, triangles)
    between = found.of[meeting]
    crossing = np.unique(between[between[:, 0] != between[:, 1]])
    clear = np.flatnonzero(~(flat | np.isin(np.arange(len(volume)), crossing)))
    is_cavity = enclosing(vertices, triangles, found, clear) % 2 == 1
    return [
        Finding(
            "several shells",
            f"{len(first)} shells share one gas, and nothing joins them; triangle {first[1]} is not of the first one",
            "make a body of each, if they are to move apart",
            first,
        ),
        *_each(
            "nested",
            "{n} shell(s) within another face outwards, so that their volume counts twice: that of triangle {0}",
            "reverse its triangles for a cavity, or make a body of its own of it",
            first[clear[(volume[clear] > 0.0) & is_cavity]],
        ),
        *_each("flat shell", "{n} shell(s) enclose no volume: that of triangle {0}", "remove it", first[flat]),
    ]


def _about_pairs(meeting: np.ndarray, coincident: np.ndarray) -> list[Finding]:
    return [
        *_each(
            "coincident triangles",
            "{n} pair(s) of triangles have the same three corners: {0[0]} and {0[1]}",
            "remove one shell of those that lie on each other",
            coincident,
        ),
        *_each(
            "self-intersections",
            "{n} pair(s) of triangles go through each other or touch: {0[0]} and {0[1]}",
            "what is inside is in doubt there: unite the parts, or move them apart, in a mesh editor",
            meeting,
        ),
    ]


def _about_vertices(place: np.ndarray, fans_of: np.ndarray) -> list[Finding]:
    at_one_place = np.bincount(place, minlength=len(place))[place] > 1
    return [
        *_each(
            "pinched vertices",
            "{n} vertices join parts that have nothing else in common there: vertex {0}",
            "give each part a vertex of its own, if they are to come apart",
            np.flatnonzero(fans_of > 1),
        ),
        *_each(
            "touching vertices",
            "{n} vertices are at the place of another one: vertex {0}",
            "merge them, if they are to stay together: Mesh.from_soup(vertices, triangles)",
            np.flatnonzero(at_one_place),
        ),
    ]


def _about_shapes(vertices: np.ndarray, triangles: np.ndarray, edges: np.ndarray) -> list[Finding]:
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    twice_area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    longest = np.max([np.linalg.norm(side, axis=1) for side in (b - a, c - b, a - c)], axis=0)
    length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    ends = edges[[np.argmin(length), np.argmax(length)]]
    thin = _each(
        "thin triangles",
        f"{{n}} triangle(s) are lower than {THIN:g} of their longest edge: triangle {{0}}",
        "remesh there: their springs hold hardly anything across",
        np.flatnonzero(twice_area < THIN * longest * longest),
    )
    if not length.max() > UNEQUAL * length.min():
        return thin
    return [
        *thin,
        Finding(
            "unequal edges",
            f"edge {ends[1][0]}–{ends[1][1]} is {length.max() / length.min():.3g} times as long as edge "
            f"{ends[0][0]}–{ends[0][1]}",
            "remesh, or give springs a stiffness each: of one stiffness, short ones make a surface stiffer",
            ends,
        ),
    ]


def _each(kind: str, what: str, cure: str, where: np.ndarray) -> list[Finding]:
    """Return a finding, with how many there are and the first of them in its sentence; none if there is none."""
    return [Finding(kind, what.format(where[0], n=len(where)), cure, where)] if len(where) else []
