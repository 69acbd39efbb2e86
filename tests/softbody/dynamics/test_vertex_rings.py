"""Is every particle surrounded by its neighbours, in order, wherever memory holds it?"""

import numpy as np
import pytest

import softbody
from softbody import Mesh, World
from softbody.compiler.simd import LANES
from softbody.dynamics.reference_forces import plain_accelerations
from softbody.dynamics.soft_bodies import motion_of, ring_accelerations
from softbody.dynamics.vertex_rings import WINDOW, build_rings, one_rings, with_springs
from softbody.model.arrays import soft_bodies_of


def two_tetrahedra_that_share_a_corner():
    """Corner 0 is where two fans of triangles meet: every edge is fine, the vertex is not a manifold's."""
    a = softbody.tetrahedron()
    other = np.where(a.triangles == 0, 0, a.triangles + 3)
    mirrored = 2.0 * a.vertices[0] - a.vertices
    return Mesh(np.concatenate([a.vertices, mirrored[1:]]), np.concatenate([a.triangles, other[:, ::-1]]))


def double_fan(n):
    """A bipyramid: two vertices of degree n, n of degree 4."""
    angle = 2.0 * np.pi * np.arange(n) / n
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros(n)], axis=1)
    ahead = (np.arange(n) + 1) % n
    top = np.stack([np.arange(n), ahead, np.full(n, n)], axis=1)
    bottom = np.stack([ahead, np.arange(n), np.full(n, n + 1)], axis=1)
    return Mesh(np.concatenate([rim, [[0, 0, 1.0], [0, 0, -1.0]]]), np.concatenate([top, bottom]))


MESHES = {
    "tetrahedron": softbody.tetrahedron(),
    "octahedron": softbody.octahedron(),
    "sphere": softbody.icosphere(2),
    "larger than a window": softbody.torus(1.0, 0.4, 60, 40),
    "box": softbody.box((1.0, 2.0, 1.0), 4),
    "degree 7": double_fan(7),
    "degree 8": double_fan(8),
    "degree 15": double_fan(15),
    "a corner of two fans": two_tetrahedra_that_share_a_corner(),
}
meshes = pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES.keys())


@meshes
def test_every_ring_is_closed_and_turns_with_the_triangles(mesh):
    start, ring, after, is_cycle = one_rings(len(mesh.vertices), mesh.triangles)
    corners = {tuple(np.roll(t, k)) for t in mesh.triangles.tolist() for k in range(3)}
    for i in range(len(mesh.vertices)):
        own, following = ring[start[i] : start[i + 1]], after[start[i] : start[i + 1]]
        assert {(i, j, k) for j, k in zip(own.tolist(), following.tolist())} <= corners
        assert sorted(own) == sorted(following)
        if is_cycle[i]:
            assert following.tolist() == np.roll(own, -1).tolist()


def test_only_a_corner_of_two_fans_is_not_a_cycle():
    for name, mesh in MESHES.items():
        is_cycle = one_rings(len(mesh.vertices), mesh.triangles)[3]
        assert np.flatnonzero(~is_cycle).tolist() == ([0] if name == "a corner of two fans" else [])


@meshes
def test_blocks_hold_every_particle_once_and_one_degree_each(mesh):
    n, e = len(mesh.vertices), len(mesh.edges)
    rings = build_rings(n, mesh.edges, mesh.triangles, np.ones(e), np.ones(e))
    assert rings.block[0, 0] == 0
    assert rings.start.tolist() == [0, rings.block[-1, 1]]
    assert len(rings.particle) == rings.start[1]
    assert (rings.block[1:, 0] == rings.block[:-1, 1]).all()
    assert (rings.block[:, 1] - rings.block[:, 0] <= WINDOW).all()
    degree, counted = np.bincount(mesh.edges.ravel()), []
    for first, end, number, size, _, behind, differ in rings.block:
        assert (end - first) % LANES == 0
        assert 0 <= end - first - number < LANES
        particle = rings.particle[first:end]
        assert (particle[number:] == particle[number - 1]).all()
        assert set(degree[particle]) == {size}
        assert differ == -1
        assert behind < 0 or mesh is MESHES["a corner of two fans"]
        counted += particle[:number].tolist()
    assert sorted(counted) == list(range(n))


def test_stiffness_is_kept_for_bodies_whose_springs_differ_only():
    world, mesh = World(), softbody.icosphere(1)
    alike, differ = np.full(len(mesh.edges), 10.0), np.linspace(1.0, 2.0, len(mesh.edges))
    for k, stiffness in enumerate((alike, differ, alike)):
        world.add_soft_body(mesh, 1.0, stiffness, 1.0, (5.0 * k, 0.0, 0.0))
    rings = world.store.rings
    assert len(rings.stiffness) * 3 == len(rings.rest_tension)
    assert np.isnan(rings.common_stiffness).tolist() == [False, True, False]
    changed = with_springs(rings, world.model.edge_rest_length, np.tile(differ, 3), world.model.soft_edge_start)
    assert changed.stiffness.tolist() == np.tile(differ, 3)[changed.edge].tolist()
    assert (
        with_springs(
            changed, world.model.edge_rest_length, np.tile(alike, 3), world.model.soft_edge_start
        ).stiffness.tolist()
        == []
    )


@meshes
@pytest.mark.parametrize("differ", [False, True])
def test_the_fast_force_is_the_obvious_one(mesh, differ):
    """… on two bodies that do not begin at row 0, with springs all alike and all different."""
    random = np.random.default_rng(3)
    world = World(gravity=(1.0, 2.0, 3.0))
    for k in range(2):
        stiffness = random.uniform(10.0, 20.0, len(mesh.edges)) if differ else 15.0
        body = world.add_soft_body(mesh, 1.0, stiffness, 3.0, (9.0 * k, 0.0, 0.0), fixed=[0])
        body.external_force = random.normal(size=3)
    state = world.state
    state.particle_position[:] += random.normal(0.0, 0.02, state.particle_position.shape)
    plain, fast = np.empty_like(state.particle_position), np.empty_like(state.particle_position)
    plain_accelerations(world.model, world.controls, state.particle_position, plain)
    motion = motion_of(world.model.soft_particle_start, world.store.rings)
    ring_accelerations(soft_bodies_of(world.model, world.controls, state), motion, fast)
    assert fast == pytest.approx(plain, abs=1e-13 * np.abs(plain).max())
    assert (fast[0] == 0.0).all()


def test_neighbours_lie_close_together_in_memory():
    mesh = softbody.icosphere(4)
    shuffled = np.random.default_rng(0).permutation(len(mesh.vertices))
    mesh = Mesh(mesh.vertices[shuffled], np.argsort(shuffled)[mesh.triangles])
    e = len(mesh.edges)
    rings = build_rings(len(mesh.vertices), mesh.edges, mesh.triangles, np.ones(e), np.ones(e))
    index = np.argsort(rings.particle)[np.searchsorted(np.sort(rings.particle), np.arange(len(mesh.vertices)))]
    distances = np.abs(index[mesh.edges[:, 0]] - index[mesh.edges[:, 1]])
    assert np.median(distances) < 120  # 2 562 vertices; at random it would be 750
