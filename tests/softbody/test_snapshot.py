"""Does a world that is put back, read from a file or unpickled go on to the same bits?"""

import pickle

import numpy as np
import pytest

import softbody
from softbody import ParameterError, World
from softbody.scenes import boxes_on_torus

STEP = 1e-3


@pytest.fixture(scope="module")
def halfway():
    """Boxes that lie on a torus, its snapshot, and what they are after 40 more steps."""
    world = boxes_on_torus.build()
    world.step(STEP, 400)
    assert world.contacts.number[0] > 0
    snapshot = world.snapshot()
    world.step(STEP, 40)
    return world, snapshot, world.state_hash()


def test_a_run_resumed_from_a_snapshot_equals_the_unbroken_run(halfway):
    world, snapshot, end = halfway
    world.restore(snapshot)
    assert world.state_hash() != end
    assert (world.steps, world.time) == (400, pytest.approx(0.4))
    world.step(STEP, 40)
    assert world.state_hash() == end


def test_a_snapshot_shares_no_memory(halfway):
    world, snapshot, end = halfway
    world.restore(snapshot)
    world.step(STEP, 40)
    world.state.particle_position[:] += 1.0
    world.restore(snapshot)
    world.step(STEP, 40)
    assert world.state_hash() == end


def test_a_world_from_a_file_goes_on_to_the_same_bits(halfway, tmp_path):
    _, snapshot, end = halfway
    first = World()
    first.restore(snapshot)
    first.save(tmp_path / "world.npz")
    assert [path.name for path in tmp_path.iterdir()] == ["world.npz"]
    world = World.load(tmp_path / "world.npz")
    world.step(STEP, 40)
    assert world.state_hash() == end


def test_an_unpickled_world_goes_on_to_the_same_bits(halfway):
    _, snapshot, end = halfway
    world = World(integrator="rk4")
    world.restore(snapshot)
    world = pickle.loads(pickle.dumps(world))
    world.step(STEP, 40)
    assert world.state_hash() == end
    assert world.integrator == "rk4_velocity"


def test_a_restored_world_takes_more_bodies(halfway):
    _, snapshot, _ = halfway
    world = World()
    world.restore(snapshot)
    ball = world.add_soft_body(softbody.icosphere(1), 1.0, 50.0, 5.0, (0.0, 0.0, 5.0))
    world.step(STEP, 3)
    assert ball.index == 1


def test_the_papers_choices_go_along():
    world = pickle.loads(pickle.dumps(World.paper()))
    assert world.settings == World.paper().settings
    assert world.integrator == "rk4_velocity"
    world.add_box((1.0, 1.0, 1.0), 1.0, friction=0.7)
    assert world.model.box_friction[0] == 0.0


def test_the_hash_sees_the_last_bit():
    world = World()
    world.add_soft_body(softbody.tetrahedron(), 1.0, 50.0, 5.0)
    before = world.state_hash()
    assert world.state_hash() == before
    world.state.particle_velocity[2, 1] = np.nextafter(0.0, 1.0)
    assert world.state_hash() != before


def test_what_is_no_snapshot_is_refused_and_changes_nothing(tmp_path):
    world = World()
    world.add_soft_body(softbody.tetrahedron(), 1.0, 50.0, 5.0)
    before = world.state_hash()
    lacking = world.snapshot()
    del lacking["rings.particle"]
    with pytest.raises(ParameterError, match=r"'rings\.particle' is missing"):
        world.restore(lacking)
    with pytest.raises(ParameterError, match="precision is 'half'; choose one of double, single"):
        world.restore(world.snapshot() | {"precision": np.array("half")})
    for integrator in (np.array("euler"), np.array(7)):
        with pytest.raises(ParameterError, match=r"settings\.integrator"):
            world.restore(world.snapshot() | {"settings.integrator": integrator})
    assert world.state_hash() == before
    (tmp_path / "text.npz").write_text("no archive")
    with pytest.raises(ParameterError, match=r"text\.npz is no NPZ file of a world"):
        World.load(tmp_path / "text.npz")
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    with pytest.raises(ParameterError, match="missing"):
        World.load(tmp_path / "other.npz")
