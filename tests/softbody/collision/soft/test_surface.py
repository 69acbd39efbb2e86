"""Is what is found on surfaces the same whenever their trees were made, and do bodies of one mesh share them?"""

import numpy as np
import pytest

import softbody
from softbody import World
from softbody.collision.contact import new_contacts
from softbody.collision.soft.soft_contacts import find_soft_contacts
from softbody.collision.soft.surface import RIDGES, _kind_of, build_surfaces
from softbody.scenes import tray


@pytest.fixture(scope="module")
def landed():
    """Return six balls that press each other, and where they were at the start."""
    world = tray.build(6)
    start = world.state.particle_position.copy()
    world.run(0.6, 0.9 * world.stable_time_step())
    return world, start


def found(world, surfaces):
    contacts = find_soft_contacts(
        world.model, world.state, world.state, surfaces, None, world.store.settings, new_contacts(8)
    )
    return [rows[: contacts.number[0]].tobytes() for rows in contacts[1:7]]


def test_contacts_and_their_order_do_not_depend_on_where_bodies_were_when_their_trees_were_made(landed):
    world, start = landed
    contacts = found(world, build_surfaces(world.model, world.state.particle_position))
    assert len(contacts[-1]) > 8 * 100
    assert found(world, build_surfaces(world.model, start)) == contacts


def test_bodies_of_one_mesh_share_what_does_not_move():
    world = World()
    ball, bar = softbody.icosphere(2, 0.5), softbody.box((2.0, 0.3, 0.3))
    for k, mesh in enumerate((ball, bar, ball)):
        world.add_soft_body(mesh, mass=1.0, stiffness=100.0, gas=10.0, position=(0.0, 0.0, 2.0 * k))
    surfaces = build_surfaces(world.model, world.state.particle_position)
    assert surfaces.shapes.kind.tolist() == [0, 1, 0]
    assert np.ptp(surfaces.shapes.spans[:, RIDGES], axis=1).tolist() == [4 * 480, 4 * 18]


def test_a_ridge_is_an_edge_and_the_corners_beside_it():
    mesh = softbody.torus(1.0, 0.4, 12, 8)
    _, (triangles, _, _, _, _, ridges, wings, sides, touching) = _kind_of(mesh.vertices, mesh.triangles, mesh.edges)
    for (i, j, left, right), (one, other) in zip(ridges, wings, strict=True):
        assert i < j
        assert [i, j, left] in [np.roll(triangles[one], k).tolist() for k in range(3)]
        assert [j, i, right] in [np.roll(triangles[other], k).tolist() for k in range(3)]
    assert all(vertex in triangles[t] for vertex, t in enumerate(touching))
    for t in range(len(triangles)):
        for k in range(3):
            start, end, edge = triangles[t, k], triangles[t, (k + 1) % 3], sides[t, k]
            leads = [start, end] if edge >= 0 else [end, start]
            assert ridges[edge if edge >= 0 else -1 - edge, :2].tolist() == leads
