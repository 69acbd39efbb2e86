"""Pure predicates and measures on points, triangles, tetrahedra, polyhedra and boxes."""
