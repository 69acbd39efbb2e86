"""The same step in C++: as one would write it (plain_step.cpp), and as fast as we can (ring_step.cpp)."""

from __future__ import annotations

import ctypes
import functools
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from benchmarks.peers import GAS, GRAVITY, MASS, STIFFNESS
from softbody import Mesh

WIDTH = 8  # particles of a block, as in ring_step.cpp
OPTIONS = {"plain_step": (), "ring_step": ("-mprefer-vector-width=512",)}  # beside -O3

Stepping = Callable[[], np.ndarray]  # returns where the particles are, in the peer's own order


class Blocks(NamedTuple):
    """Particles in the order in which ring_step.cpp takes them, eight by eight."""

    order: np.ndarray  # (n,) the mesh's vertices
    degree: np.ndarray  # (blocks,) neighbours of each particle
    first: np.ndarray  # (blocks,) of its rows in `ring`
    own: np.ndarray  # (blocks,) first particle
    used: np.ndarray  # (blocks,) how many particles are its own
    ring: np.ndarray  # (rows, WIDTH) a neighbour of each particle
    rest_length: np.ndarray  # (rows, WIDTH) [m]


@functools.cache
def _library(name: str) -> ctypes.CDLL | None:
    """Compile a source for this machine; None where there is no compiler."""
    compiler = shutil.which("g++") or shutil.which("clang++")
    if compiler is None:
        return None
    library = Path(tempfile.mkdtemp()) / f"{name}.so"
    source = Path(__file__).with_name(f"{name}.cpp")
    command = [compiler, "-O3", "-march=native", *OPTIONS[name], "-shared", "-fPIC", "-o", str(library), str(source)]
    subprocess.run(command, check=True)
    return ctypes.CDLL(str(library))


def plain_stepping(mesh: Mesh, h: float, steps: int) -> Stepping | None:
    """Return a call that steps the mesh in plain C++, or None where there is no compiler."""
    library = _library("plain_step")
    if library is None:
        return None
    x, v, work = mesh.vertices.copy(), np.zeros_like(mesh.vertices), np.zeros(9 * len(mesh.vertices))
    edges, triangles = mesh.edges.astype(np.int32), mesh.triangles.astype(np.int32)
    rest = np.linalg.norm(x[edges[:, 1]] - x[edges[:, 0]], axis=1)

    def call() -> np.ndarray:
        library.rk4_velocity_steps(
            _pointer(x),
            _pointer(v),
            ctypes.c_long(len(x)),
            _pointer(edges),
            _pointer(rest),
            ctypes.c_long(len(edges)),
            _pointer(triangles),
            ctypes.c_long(len(triangles)),
            *_constants(len(x), h),
            ctypes.c_long(steps),
            _pointer(work),
        )
        assert np.isfinite(x[0, 0])
        return x

    return call


def ring_stepping(mesh: Mesh, h: float, steps: int) -> Stepping | None:
    """Return a call that steps the mesh in C++ with vectors of eight, or None where there is no compiler."""
    library = _library("ring_step")
    if library is None:
        return None
    blocks = blocks_of(mesh)
    n = len(mesh.vertices)
    padded, v, work = np.zeros(3 * n + WIDTH), np.zeros((3, n)), np.zeros((12, n))
    x = padded[: 3 * n].reshape(3, n)
    x[:] = mesh.vertices[blocks.order].T

    def call() -> np.ndarray:
        library.ring_steps(
            _pointer(x),
            _pointer(v),
            ctypes.c_long(n),
            *(_pointer(array) for array in blocks[1:5]),
            ctypes.c_long(len(blocks.own)),
            _pointer(blocks.ring),
            _pointer(blocks.rest_length),
            *_constants(n, h),
            ctypes.c_long(steps),
            _pointer(work),
        )
        assert np.isfinite(x[0, 0])
        return x.T[np.argsort(blocks.order)]

    return call


def _pointer(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def _constants(particles: int, h: float) -> tuple[ctypes.c_double, ...]:
    values = STIFFNESS, GAS, particles / MASS, GRAVITY, h
    return tuple(ctypes.c_double(value) for value in values)


def blocks_of(mesh: Mesh) -> Blocks:
    """Return a mesh's particles eight by eight: neighbours near each other, those of a degree together."""
    n = len(mesh.vertices)
    i, j = mesh.edges.T
    links = coo_array((np.ones(2 * len(i), np.int8), (np.r_[i, j], np.r_[j, i])), (n, n)).tocsr()
    near = reverse_cuthill_mckee(links, symmetric_mode=True)
    order = near[np.argsort(np.diff(links.indptr)[near], kind="stable")]
    place = np.argsort(order)
    rings = _rings(place[mesh.triangles], n)
    degree = (rings >= 0).sum(axis=1)
    starts = np.flatnonzero(np.diff(degree, prepend=-1))  # of a degree
    own = np.concatenate([np.arange(a, b, WIDTH) for a, b in zip(starts, [*starts[1:], n])])
    used = np.diff(own, append=n)
    particles = own[:, None] + np.minimum(np.arange(WIDTH), used[:, None] - 1)
    x = mesh.vertices[order]
    rows = [rings[block][:, :around].T for block, around in zip(particles, degree[own])]
    ring = np.concatenate(rows)
    of = np.repeat(particles, degree[own], axis=0)
    rest_length = np.linalg.norm(x[ring] - x[of], axis=2)
    first = np.concatenate([[0], np.cumsum(degree[own])[:-1]])

    def packed(indices: np.ndarray) -> np.ndarray:
        return np.ascontiguousarray(indices, np.int32)

    of_blocks = packed(degree[own]), packed(first), packed(own), packed(used)
    return Blocks(order, *of_blocks, packed(ring), rest_length)


def _rings(triangles: np.ndarray, n: int) -> np.ndarray:
    """Return (n, most) the neighbours of each vertex in turn, −1 after the last."""
    corner = np.concatenate([triangles, np.roll(triangles, -1, axis=1), np.roll(triangles, -2, axis=1)]).astype(
        np.int64
    )
    key = corner[:, 0] * n + corner[:, 1]
    sorted_by = np.argsort(key)
    key, after = key[sorted_by], corner[sorted_by, 2]
    starts = np.searchsorted(key // n, np.arange(n + 1))
    degree = np.diff(starts)
    rings = np.full((n, degree.max()), -1)
    now = key[starts[:-1]] % n
    for k in range(degree.max()):
        rings[:, k] = np.where(k < degree, now, -1)
        now = after[np.searchsorted(key, np.arange(n) * n + now)]
    return rings
