"""Are sums over the rings those over the triangles, and where several fans meet in a particle?"""

import numpy as np
import pytest

import softbody
from softbody import Mesh, World
from softbody.dynamics.liquid_forces import Moving
from softbody.dynamics.ring_pressure import PLACE, SLOPE, TURN, RingWork, memory_for_rings, sum_around
from softbody.dynamics.vertex_rings import build_rings

pytestmark = pytest.mark.interpreted


def two_that_meet():
    """Return two octahedra that share a vertex."""
    one = softbody.octahedron()
    points = np.concatenate([one.vertices, np.delete(one.vertices, 5, axis=0) + one.vertices[4] - one.vertices[5]])
    other = np.array([6, 7, 8, 9, 10, 4])[one.triangles]
    return Mesh(points, np.concatenate([one.triangles, other]))


@pytest.mark.parametrize("mesh", [softbody.icosphere(1), softbody.torus(0.5, 0.2, 8, 6), two_that_meet()])
def test_sums_around_particles_are_those_over_triangles(mesh):
    rng, along = np.random.default_rng(1), np.array([0.3, -2.0, 9.0])
    edges, none = mesh.edges, np.ones(len(mesh.edges))
    rings = build_rings(len(mesh.vertices), edges, mesh.triangles, none, none)
    x, v = mesh.vertices + rng.normal(scale=0.03, size=mesh.vertices.shape), rng.normal(size=mesh.vertices.shape)
    work = RingWork(rings, memory_for_rings(rings))
    sum_around(work, 0, Moving(x, v, 0.01), tuple(along))
    there, wanted = x + 0.01 * v, np.zeros((6, len(x)))
    for triangle in mesh.triangles:
        a, b, c = there[triangle]
        normal = np.cross(b - a, c - a)
        for corner in triangle:
            wanted[:, corner] += [*normal, *(along @ (a + b + c - 3.0 * there[corner]) * normal)]
    found = work.rows[:, : len(rings.particle)]
    assert np.array_equal(found[PLACE : PLACE + 3], there[rings.particle].T)
    assert found[TURN : SLOPE + 3] == pytest.approx(wanted[:, rings.particle], abs=1e-13)


@pytest.mark.parametrize("around", [0.0, 1000.0])
def test_a_liquid_gives_the_same_to_a_body_alone_and_to_one_beside_a_box_far_away(around):
    """Worlds of one soft body are moved by another kernel."""
    worlds = []
    for is_alone in (True, False):
        world = World()
        if around:
            world.add_liquid(around, 0.1, drag=50.0)
        world.add_ground(-0.6)
        body = world.add_soft_body(softbody.icosphere(1, 0.5), 5.0, 4e3, 3e3, liquid_density=800.0)
        if not is_alone:
            world.add_box((0.1, 0.1, 0.1), 1.0, (50.0, 0.0, 0.0))
        world.step(2e-4, 20)
        worlds.append((body.positions.tobytes(), body.velocities.tobytes()))
    assert worlds[0] == worlds[1]
