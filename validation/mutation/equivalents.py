"""Mutants that nobody can tell from the core, each with the reason, by `Mutant.key`."""

from __future__ import annotations

_ANY_VERTEX = "sums are taken about some vertex of the mesh; any will do, and the centroid differs by rounding alone"
_EITHER_OF_EQUALS = "of two equal squares it does not matter which is kept: they are the same number"
_BEFORE_ANY = "overwritten by the first face, whose distance is below ∞"
_ONE_SYMMETRY = "|a − b| against |a| + |b|: the same bits whichever of the two is named first"

EQUIVALENTS: dict[str, str] = {
    "collision/impulse.py:inverse_effective_mass_at: inverse_effective_mass(sub(point, load(bodies.position, body)), "
    "direction, bodies.inverse_mass[body], load(bodies.inverse_inertia, body), load_quaternion(bodies.orientation, "
    "body)) -> inverse_effective_mass(direction, sub(point, load(bodies.position, body)), bodies.inverse_mass[body], "
    "load(bodies.inverse_inertia, body), load_quaternion(bodies.orientation, body))": (
        "arm and direction may change places: n · [(I⁻¹ (r × n)) × r] = (r × n) · I⁻¹ (r × n), the same for n × r"
    ),
    "collision/sat_boxes.py:_best_edge_pair: rounding_of(size, a, b) -> rounding_of(size, b, a)": (
        "the same sum in another order, of a bound on rounding that has no sharp value"
    ),
    "collision/sat_boxes.py:box_box_separation: 1 -> 0": (
        "the axis before any was tried; the first is always taken, for its gap is above −∞"
    ),
    "collision/sat_boxes.py:box_pairs_overlap: True -> False": (
        "only ends the search at the first axis that parts the boxes; a later one cannot bring them together again"
    ),
    "geometry/box.py:point_in_box: 0.0 -> 1.0": _BEFORE_ANY,
    "geometry/box.py:point_in_box: 0.0 -> 1.0 #1": _BEFORE_ANY,
    "geometry/box.py:point_in_box: 0.0 -> 1.0 #2": _BEFORE_ANY,
    "geometry/polyhedron.py:_is_clear: LINE_ROUNDING -> LINE_ROUNDING * 1.01": (
        "a filter that asks exact arithmetic a little more often, which gives the same answer"
    ),
    "geometry/polyhedron.py:centroid: triangles[0, 0] -> triangles[0, 1]": _ANY_VERTEX,
    "geometry/polyhedron.py:centroid: triangles[0, 0] -> triangles[1, 0]": _ANY_VERTEX,
    "geometry/polyhedron.py:point_in_polyhedron: p[1] -> p[0]": (
        "a y that is not finite is above all corners of a triangle or above none, so that the ray meets nothing anyway"
    ),
    "geometry/polyhedron.py:ray_hits_triangle_filtered: _is_clear(bc, cb) -> _is_clear(cb, bc)": _ONE_SYMMETRY,
    "geometry/tetrahedron.py:point_in_tetrahedron: 1.0 -> 1.01": "a factor of which only the sign is asked for",
    "geometry/tetrahedron.py:point_in_tetrahedron: 1.0 -> 1.01 #1": "a factor of which only the sign is asked for",
    "geometry/tetrahedron.py:point_in_tetrahedron: whole > 0.0 -> whole >= 0.0": (
        "another sign for a flat tetrahedron only, which contains nothing whatever the sign"
    ),
    "geometry/tetrahedron.py:points_in_tetrahedra: point_in_tetrahedron(p, a, b, c, d) -> "
    "point_in_tetrahedron(p, a, b, d, c)": (
        "inside out all five determinants change their signs, to the bit, and the answer is for either orientation"
    ),
    "geometry/triangle.py:_along_edge: t > 0.0 -> t >= 0.0": "for t = 0 either branch gives 0",
    "geometry/triangle.py:squared_distance_to_triangle: square < best -> square <= best": _EITHER_OF_EQUALS,
    "geometry/triangle.py:squared_distance_to_triangle: square < best -> square <= best #1": _EITHER_OF_EQUALS,
    "geometry/triangle.py:squared_distance_to_triangle: square < best -> square <= best #2": _EITHER_OF_EQUALS,
}
