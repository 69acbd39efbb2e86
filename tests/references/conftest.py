"""Meshes and impacts that several references are asked about; built here, because a reference never meets softbody."""

import numpy as np
import pytest

from references.analytic import rotation_matrix


def torus_mesh(R, r, nu, nv):
    u, v = np.meshgrid(2 * np.pi * np.arange(nu) / nu, 2 * np.pi * np.arange(nv) / nv, indexing="ij")
    rho = R + r * np.cos(v)
    vertices = np.stack([rho * np.cos(u), rho * np.sin(u), r * np.sin(v)], axis=-1).reshape(-1, 3)
    index = np.arange(nu * nv).reshape(nu, nv)
    a, b = index, np.roll(index, -1, 0)
    c, d = np.roll(b, -1, 1), np.roll(a, -1, 1)
    return vertices, np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])


def cube_mesh():
    """Corners at 0 and 1, corner 4 x + 2 y + z."""
    vertices = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return vertices, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def regular_solid(name, radius):
    golden = (1 + 5**0.5) / 2
    corners = {
        "tetrahedron": [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)],
        "octahedron": [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)],
        "icosahedron": [
            np.roll((0, i, j * golden), k) for i in (-1, 1) for j in (-1, 1) for k in range(3)
        ],
    }[name]  # fmt: skip
    vertices = np.array(corners, float)
    vertices *= radius / np.linalg.norm(vertices, axis=1, keepdims=True)
    return vertices, convex_hull(vertices)


def convex_hull(vertices):
    """Triangles of the triples of vertices that all others lie behind."""
    triangles = []
    for i in range(len(vertices)):
        for j in range(len(vertices)):
            for k in range(len(vertices)):
                if i < j and i < k and j != k:
                    n = np.cross(vertices[j] - vertices[i], vertices[k] - vertices[i])
                    if np.all((vertices - vertices[i]) @ n < 1e-9):
                        triangles.append((i, j, k))
    return np.array(triangles)


def edges_of(triangles):
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def quaternions(rng, m):
    q = rng.normal(size=(m, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def box_pairs(rng, m):
    """Size, position, orientation of a and of b, about half of which overlap."""
    sizes = rng.uniform(0.4, 2.0, (2, m, 3))
    direction = rng.normal(size=(m, 3))
    apart = direction / np.linalg.norm(direction, axis=1, keepdims=True) * rng.uniform(0.5, 2.4, (m, 1))
    here = rng.normal(size=(m, 3))
    return sizes[0], here, quaternions(rng, m), sizes[1], here + apart, quaternions(rng, m)


def impacts(rng, m, kind):
    """Boxes a and b that overlap by 1e-9 … 1e-4 at one point, with random motion; every third has a static box.

    "corner": a corner of b in a face of a. "edge": an edge of a across an edge of b. Returns the first twelve
    arguments of an impact and the unit normal (m, 3) from b to a.
    """
    size_a, size_b = rng.uniform(0.4, 2.0, (2, m, 3))
    q_a, q_b = quaternions(rng, m), quaternions(rng, m)
    R_a, R_b = rotation_matrix(q_a), rotation_matrix(q_b)
    rows, i, j = np.arange(m), rng.integers(0, 3, m), rng.integers(0, 3, m)
    n = R_a[rows, :, i] if kind == "corner" else np.cross(R_a[rows, :, i], R_b[rows, :, j])
    n = n / np.linalg.norm(n, axis=1, keepdims=True) * rng.choice([-1.0, 1.0], (m, 1))
    corner_a = -np.sign(np.einsum("mji,mj->mi", R_a, n)) * size_a / 2
    corner_b = np.sign(np.einsum("mji,mj->mi", R_b, n)) * size_b / 2
    if kind == "corner":
        along = rng.uniform(-0.4, 0.4, (m, 3)) * size_a
        along[rows, i] = corner_a[rows, i]
        corner_a = along
    else:
        corner_a[rows, i] *= rng.uniform(-0.8, 0.8, m)
        corner_b[rows, j] *= rng.uniform(-0.8, 0.8, m)
    depth = 10 ** rng.uniform(-9, -4, (m, 1))
    x_a = rng.normal(size=(m, 3))
    x_b = x_a + np.einsum("mij,mj->mi", R_a, corner_a) + depth * n - np.einsum("mij,mj->mi", R_b, corner_b)
    mass_a, mass_b = 10 ** rng.uniform(-1, 1, (2, m))
    motion = rng.normal(size=(4, m, 3))
    static_a, static_b = rows % 6 == 0, rows % 6 == 3
    mass_a[static_a] = mass_b[static_b] = np.inf
    motion[:2, static_a] = motion[2:, static_b] = 0.0
    v_a, w_a, v_b, w_b = motion
    return (size_a, mass_a, x_a, q_a, v_a, w_a, size_b, mass_b, x_b, q_b, v_b, w_b), n


class Cases:
    """The functions above, for tests to call."""

    torus = staticmethod(torus_mesh)
    cube = staticmethod(cube_mesh)
    solid = staticmethod(regular_solid)
    edges = staticmethod(edges_of)
    box_pairs = staticmethod(box_pairs)
    impacts = staticmethod(impacts)


@pytest.fixture(scope="session")
def cases():
    return Cases


@pytest.fixture
def rng():
    return np.random.default_rng(20081)
