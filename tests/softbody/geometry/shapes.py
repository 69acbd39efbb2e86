"""Meshes good and bad that the tests of the structures share."""

import numpy as np

import softbody

BALL = softbody.icosphere(2)
TORUS = softbody.torus(1.0, 0.4, 12, 8)
CUBE = softbody.box((1.0, 1.0, 1.0), 2)
V, T = BALL.vertices, BALL.triangles


def turned(vertices):
    """The same in a direction in which nothing is aligned."""
    matrix, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    return np.ascontiguousarray(vertices @ matrix.T)


def split(vertices, triangles):
    """Every triangle with corners of its own, as in an STL file."""
    return vertices[triangles].reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3)


def join(*meshes):
    """Several meshes as one, each with its own vertices."""
    starts = np.cumsum([0, *(len(v) for v, _ in meshes)])
    return np.concatenate([v for v, _ in meshes]), np.concatenate([t + s for (_, t), s in zip(meshes, starts)])


def flattened(axis):
    squashed = V.copy()
    squashed[:, axis] = 0.25
    return squashed, T


def changed(rows, i, value):
    rows = rows.copy()
    rows[i] = value
    return rows


FIN = np.vstack([V, [[0.0, 0.0, 2.0]]])  # one vertex more, for triangles that stick out

CLOSED = {
    "ball": (V, T),
    "torus": (TORUS.vertices, TORUS.triangles),
    "cube": (CUBE.vertices, CUBE.triangles),
    "ball, turned": (turned(V), T),
    "torus, turned": (turned(TORUS.vertices), TORUS.triangles),
    "tetrahedron": (softbody.tetrahedron().vertices, softbody.tetrahedron().triangles),
    "inside out": (V, np.ascontiguousarray(T[:, ::-1])),
    "every other triangle flipped": (V, np.where(np.arange(len(T))[:, None] % 2, T, T[:, ::-1])),
    "two apart": join((V, T), (V + 3.0, T)),
    "two that overlap": join((V, T), (V + [0.7, 0.2, 0.1], T)),
    "two at one place": join((V, T), (V, T)),
    "one in another": join((V, T), (0.5 * V, T)),
    "every triangle twice": (V, np.concatenate([T, T])),
    "every triangle three times": (V, np.concatenate([T, T, T])),
    "two cubes that share an edge": join(
        (CUBE.vertices, CUBE.triangles), (CUBE.vertices + [1.0, 1.0, 0.0], CUBE.triangles)
    ),
    "two cubes that share a corner": join((CUBE.vertices, CUBE.triangles), (CUBE.vertices + 1.0, CUBE.triangles)),
    "two cubes that share a face": join(
        (CUBE.vertices, CUBE.triangles), (CUBE.vertices + [0.0, 0.0, 1.0], CUBE.triangles)
    ),
    "crumpled": (np.random.default_rng(0).normal(size=V.shape), T),
    "crumpled on a grid": (np.random.default_rng(0).integers(-2, 3, V.shape).astype(float), T),
    "one vertex far away": (changed(V, 7, [50.0, 30.0, -20.0]), T),
    "one vertex extremely far away": (changed(V, 7, [1e9, 3e8, -2e9]), T),
    "one vertex on another": (changed(V, 7, V[8]), T),
    "collapsed edges": (V[np.arange(len(V)) // 3 * 3], T),
    "thin as a needle": (V * [1e-9, 1e-9, 1.0], T),
    "thin as a plate": (V * [1.0, 1.0, 1e-9], T),
    "flat along x": flattened(0),
    "flat along y": flattened(1),
    "flat along z": flattened(2),
    "a line": (V * [0.0, 0.0, 1.0], T),
    "a point": (V * 0.0 + 0.5, T),
    "a few roundings wide": (V * 1e-15 + 1.0, T),
    "far away": (V + [1e6, -2e6, 3e6], T),
    "tiny": (V * 1e-6, T),
    "huge": (V * 1e6, T),
    "a triangle that repeats a vertex": (V, np.vstack([T, [[0, 0, 1]]])),
    "a triangle that is one vertex": (V, np.vstack([T, [[5, 5, 5]]])),
    "unused vertices": (np.vstack([V, [[9.0, 9.0, 9.0]]]), T),
    "two sides of one triangle": (V[:3], np.array([[0, 1, 2], [2, 1, 0]])),
    "three fins on an edge": (FIN, np.vstack([T, [[0, 1, 162]], [[1, 2, 162]], [[2, 0, 162]], [[0, 2, 1]]])),
}

OPEN = {
    "a triangle missing": (V, T[1:]),
    "half missing": (V, T[: len(T) // 2]),
    "every other triangle missing": (V, T[::2]),
    "one triangle": (V, T[:1]),
    "one triangle upright": (np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.0, 1.0]]), np.array([[0, 1, 2]])),
    "one triangle without area": (np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]]), np.array([[0, 1, 2]])),
    "a fin": (FIN, np.vstack([T, [[0, 1, 162]]])),
    "a triangle twice": (V, np.vstack([T, T[:1]])),
    "unmerged": split(V, T),
    "unmerged, turned": split(turned(V), T),
    "an unmerged cube": split(CUBE.vertices, CUBE.triangles),
    "unmerged and crumpled": (np.random.default_rng(2).normal(size=(3 * len(T), 3)), split(V, T)[1]),
    "triangles at random": (V, np.random.default_rng(3).integers(0, len(V), (200, 3))),
    "a tube": (TORUS.vertices, TORUS.triangles[:40]),
    "a sheet": (V * [1.0, 1.0, 0.0], T[: len(T) // 2]),
}

ALL = {**CLOSED, **OPEN}


def questions(vertices, triangles, seed=0, count=150):
    """Points in and around, on vertices, edges and faces, above and below them, and a rounding off."""
    rng = np.random.default_rng(seed)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    size = np.ptp(vertices, axis=0).max()
    corners = vertices[triangles[rng.integers(0, len(triangles), count)]]
    on_faces = (rng.dirichlet((1.0, 1.0, 1.0), count)[:, :, None] * corners).sum(axis=1)
    on_edges = 0.5 * (corners[:, 0] + corners[:, 1])
    some = vertices[rng.integers(0, len(vertices), count)]
    up = np.array([0.0, 0.0, 1.0]) * rng.uniform(-1.0, 1.0, (count, 1)) * np.ptp(vertices[:, 2])
    special = np.concatenate([some, on_edges, on_faces])
    return np.concatenate(
        [
            rng.uniform(low - 0.1 * size, high + 0.1 * size, (count, 3)),
            special,
            np.nextafter(special, rng.choice([-np.inf, np.inf], special.shape)),
            some + up,
            on_edges + up,
            [low, high, 0.5 * (low + high), low - size, high + size],
        ]
    )
