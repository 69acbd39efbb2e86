"""Soft bodies tear: when, into what, and what flows out."""

import numpy as np
import pytest

from softbody import ParameterError, World, icosphere, octahedron, torus
from softbody.dynamics.reference_forces import plain_accelerations
from softbody.dynamics.soft_bodies import motion_of, ring_accelerations
from softbody.model.arrays import soft_bodies_of

STILL = 1e-15  # [s] a step in which nothing moves


def stretched(world, factor=1.1, mesh=None, **options):
    """Return a ball whose positions are so many times as far from each other as at rest."""
    options = {"name": "ball", "damping": 0.0, **options}
    mesh = icosphere(2) if mesh is None else mesh
    body = world.add_soft_body(mesh, 2.0, 100.0, 3.0, **options)
    body.positions = body.positions * factor
    return body


def open_ball(world, seed=0, **options):
    """Return a ball that has torn at a weak place, and lost its shape."""
    mesh, rng = icosphere(2), np.random.default_rng(seed)
    limits = np.where(mesh.vertices[mesh.edges].mean(axis=1)[:, 0] > 0.8, 1.05, 5.0)
    body = stretched(world, tear_at=limits, **options)
    while not body.is_torn or body.volume < 0.0:
        world.step(STILL)
        body.positions = body.positions + 0.03 * rng.normal(size=body.positions.shape)
    return body


@pytest.mark.parametrize(("limit", "tears"), [(1.1 * (1.0 + 1e-9), False), (1.1 * (1.0 - 1e-9), True)])
@pytest.mark.parametrize("alone", [True, False])
def test_it_tears_beyond_its_limit(limit, tears, alone):
    world = World(gravity=(0.0, 0.0, 0.0))
    body = stretched(world, tear_at=limit)
    if not alone:
        world.add_box((1.0, 1.0, 1.0), None, (9.0, 0.0, 0.0))
    world.step(STILL)
    assert body.is_torn == tears
    assert bool(world.events) == tears


@pytest.mark.interpreted
@pytest.mark.parametrize(("precision", "integrator"), [("double", "symplectic_euler"), ("single", "rk4")])
@pytest.mark.parametrize("seed", range(2))
def test_it_tears_in_the_same_step_as_if_it_was_looked_at_after_each(seed, precision, integrator):
    """In many steps at once springs are looked at only where one may have come to its limit."""
    worlds = []
    for _ in range(2):
        rng = np.random.default_rng(seed)
        world, mesh = World(gravity=(0.0, 0.0, 0.0), precision=precision, integrator=integrator), icosphere(1)
        body = stretched(world, 1.05, mesh, tear_at=rng.uniform(1.1, 1.3, len(mesh.edges)))
        body.velocities = 6.0 * body.positions + rng.normal(0.0, 0.2, mesh.vertices.shape)
        worlds.append(world)
    at_once, one_by_one = worlds
    at_once.step(1e-3, 40)
    for _ in range(40):
        one_by_one.step(1e-3)
    times = [event.time for event in at_once.events]
    assert times == pytest.approx([event.time for event in one_by_one.events])
    assert times
    assert times[0] > 5e-3
    for one, other in zip(at_once.soft_bodies, one_by_one.soft_bodies, strict=True):
        assert np.array_equal(one.positions, other.positions)


def test_a_tear_keeps_what_there_was():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = stretched(world, tear_at=np.random.default_rng(1).uniform(1.0001, 1.2, len(icosphere(2).edges)))
    body.velocities = np.random.default_rng(0).normal(size=body.positions.shape)
    body.external_force = np.random.default_rng(2).normal(size=body.positions.shape)
    mass, push, spring = body.mass, body.masses @ body.velocities, world.energies().spring
    force = body.external_force.sum(axis=0)
    world.step(STILL)
    pieces = world.soft_bodies
    assert body.is_torn
    assert sum(each.mass for each in pieces) == pytest.approx(mass, rel=1e-14)
    assert sum(each.masses @ each.velocities for each in pieces) == pytest.approx(push, abs=1e-12)
    assert sum(each.external_force.sum(axis=0) for each in pieces) == pytest.approx(force, rel=1e-12)
    assert world.energies().spring == pytest.approx(spring, rel=1e-12)
    assert sum(each.gas for each in pieces) == pytest.approx(3.0, rel=1e-12)


def test_forces_in_a_torn_skin_are_those_of_its_springs_and_its_gas():
    world = World(gravity=(0.0, 0.0, -9.81))
    body = open_ball(world)
    model, controls, state, rings, _ = world.store.parts
    assert body.gas > 0.0
    plain, fast = np.empty((2, *state.particle_position.shape))
    plain_accelerations(model, controls, state.particle_position, plain)
    ring_accelerations(soft_bodies_of(model, controls, state), motion_of(model.soft_particle_start, rings), fast)
    assert fast == pytest.approx(plain, rel=1e-11, abs=1e-11 * np.abs(plain).max())


def test_gas_leaks_out_of_the_hole():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = open_ball(world, leak=0.0)
    gas = body.gas
    world.step(1e-6)
    assert body.gas == gas
    body.leak = 50.0
    world.step(1e-6)
    assert 0.99 * gas < body.gas < gas


def test_pieces_are_bodies_with_names_and_events():
    world = World(gravity=(0.0, 0.0, 0.0))
    mesh = torus(1.0, 0.3, 24, 8)
    middle = mesh.vertices[mesh.edges].mean(axis=1)
    limits = np.where((np.abs(middle[:, 0]) < 0.08), 1.01, 9.0)
    ring = world.add_soft_body(mesh, 2.0, 100.0, 0.0, tear_at=limits, name="ring")
    other = world.add_soft_body(icosphere(1, 0.1), 1.0, 100.0, 1.0, (5.0, 0.0, 0.0), name="other")
    joint = world.add_joint((other, other.centre), (9.0, 0.0, 0.0), 1.0)
    ring.velocities = np.sign(mesh.vertices[:, :1]) * (3.0, 0.0, 0.0)
    world.run(0.3)
    names = [each.name for each in world.soft_bodies]
    assert names[:2] == ["ring", "other"]
    assert "ring.1" in names
    assert len(names) == len(set(names))
    assert joint.ends[0] == pytest.approx(other.centre, abs=0.1)
    apart = [event for event in world.events if len(event.bodies) > 1]
    assert apart[0].kind == "tear"
    assert apart[0].bodies[0] == ring
    assert 0.0 < apart[0].time < 0.3
    assert np.abs(apart[0].places[:, 0]).max() < 0.5
    assert sum(each.mass for each in world.soft_bodies) == pytest.approx(3.0, rel=1e-13)


def test_springs_near_a_tear_wait_until_they_give_way():
    world = World(gravity=(0.0, 0.0, 0.0))
    limits = np.full(len(icosphere(2).edges), 5.0)
    limits[77] = 1.05
    body = stretched(world, tear_at=limits)
    world.step(STILL, 5)
    assert len(world.events) == 1
    assert (body.tear_at == 1.05).sum() == 1
    body.positions = body.positions / 1.1
    world.step(STILL)
    body.positions = body.positions * 1.1
    world.step(STILL)
    assert len(world.events) == 2


def test_a_torn_world_is_saved_and_goes_on_the_same():
    world = World()
    body = open_ball(world)
    world.add_box((1.0, 1.0, 1.0), None, (0.0, 0.0, -2.5))
    world.step(1e-4, 20)
    twin = World()
    twin.restore(world.snapshot())
    for each in (world, twin):
        each.step(1e-4, 50)
    assert world.state_hash() == twin.state_hash()
    assert twin.soft_bodies[0].is_torn == body.is_torn


@pytest.mark.parametrize("bad", [1.0, 0.5, -2.0, np.nan, np.inf, "much", [1.5, 1.6]])
def test_limits_are_checked(bad):
    world = World()
    with pytest.raises(ParameterError, match="tear_at"):
        world.add_soft_body(icosphere(1), 1.0, 100.0, 1.0, tear_at=bad)
    body = world.add_soft_body(icosphere(1), 1.0, 100.0, 1.0)
    with pytest.raises(ParameterError, match="tear_at"):
        body.set_springs(tear_at=bad)


@pytest.mark.parametrize("what", ["self_contact", "liquid", "around", "inside", "hangs"])
def test_what_cannot_tear_is_named(what):
    world = World()
    more = {"self_contact": {"self_contact": True}, "liquid": {"liquid_density": 10.0}}.get(what, {})
    body = world.add_soft_body(icosphere(2), 1.0, 100.0, 1.0, tear_at=2.0, name="ball", **more)
    if what == "around":
        world.add_liquid(1000.0, -5.0)
    if what == "inside":
        world.add_box((0.1, 0.1, 0.1), 0.01, inside=body)
    if what == "hangs":
        world.suspend(np.zeros((1, 3)), body)
    with pytest.raises(ParameterError, match=r"'ball' may tear, or has torn, and .*tear_at"):
        world.step(1e-4)
    body.set_springs(tear_at=0.0)
    world.step(1e-4)


def test_what_has_torn_is_neither_cut_nor_joined():
    world = World(gravity=(0.0, 0.0, 0.0))
    body = open_ball(world)
    other = world.add_soft_body(icosphere(1), 1.0, 100.0, 1.0, (9.0, 0.0, 0.0))
    with pytest.raises(ParameterError, match="has torn"):
        body.cut(body.centre, (1.0, 0.0, 0.0))
    with pytest.raises(ParameterError, match="has torn"):
        world.join(other, body, (1.0, 0.0, 0.0))


def test_single_triangles_may_be_what_is_left():
    world = World()
    world.add_ground(-2.0)
    body = stretched(world, 1.5, octahedron(), tear_at=1.1)
    world.run(0.5)
    assert len(world.soft_bodies) == 8
    assert all(len(each.positions) == 3 for each in world.soft_bodies)
    assert body.mass == pytest.approx(0.25)
    assert min(each.positions[:, 2].min() for each in world.soft_bodies) >= -2.0 - 1e-9


def test_cuts_and_joins_are_events_too():
    world = World(gravity=(0.0, 0.0, 0.0))
    ball = world.add_soft_body(icosphere(2), 1.0, 100.0, 1.0, name="ball")
    pieces = ball.cut((0.1, 0.0, 0.0), (1.0, 0.0, 0.0))
    world.join(*pieces, within=1e-6)
    cut, join = world.events
    assert (cut.kind, join.kind) == ("cut", "join")
    assert cut.places.tolist() == [[0.1, 0.0, 0.0]]
    assert cut.bodies[0] == join.bodies[0] == ball


def test_what_was_said_of_boxes_is_remembered_by_their_new_numbers():
    world = World(gravity=(0.0, 0.0, 0.0))
    stretched(world, 1.5, octahedron(), tear_at=2.0)
    for x in (5.0, 5.4):
        world.add_box((1.0, 1.0, 1.0), 1.0, (x, 0.0, 0.0))
    world.step(1e-6)
    assert world.runner.memory.started_inside == {(1, 2)}
    world.soft_bodies[0].set_springs(tear_at=1.1)
    world.step(1e-6, 2)
    assert len(world.soft_bodies) == 8
    assert world.runner.memory.started_inside == {(8, 9)}
