"""Does a world that is put back, read from a file or unpickled go on to the same bits?"""

import pickle
import re

import numpy as np
import pytest

import softbody
from softbody import OverlapWarning, SnapshotError, World
from softbody.scenes import boxes_on_torus

STEP = 1e-3


@pytest.fixture(scope="module")
def halfway():
    """Boxes that lie on a torus, its snapshot, and what they are after 40 more steps."""
    world = boxes_on_torus.build()
    world.step(STEP, 400)
    assert world.store.contacts.number[0] > 0
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
    assert world.integrator == "symplectic_euler"


def test_a_restored_world_takes_more_bodies(halfway):
    _, snapshot, _ = halfway
    world = World()
    world.restore(snapshot)
    ball = world.add_soft_body(softbody.icosphere(1), 1.0, 50.0, 5.0, (0.0, 0.0, 5.0))
    world.step(STEP, 3)
    assert ball.index == 1


def test_the_papers_choices_go_along():
    world = pickle.loads(pickle.dumps(World.paper()))
    assert world.store.settings == World.paper().store.settings
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


@pytest.fixture(scope="module")
def mixed():
    """The snapshot of a world of two soft bodies, boxes and a ground that touch each other, and a point that hangs."""
    world = World()
    world.add_ground()
    world.add_soft_body(softbody.icosphere(1, 0.4), 1.0, 100.0, 20.0, (0.0, 0.0, 0.38), fixed=(3,))
    world.add_soft_body(softbody.octahedron(0.4), 1.0, 100.0, 10.0, (0.1, 0.0, 1.1))
    for k in range(2):
        world.add_box((0.5, 0.4, 0.3), 2.0, (0.6, 0.0, 0.149 + 0.298 * k))
    world.add_box((0.5, 0.4, 0.3), None, (5.0, 0.0, 0.0))
    for k in range(2):
        world.add_joint((world.soft_bodies[1], k), (world.boxes[k], (0.6, 0.0, 0.2)), 1.0)
    world.suspend(world.soft_bodies[1].centre, world.soft_bodies[1])
    with pytest.warns(OverlapWarning):
        world.step(STEP, 5)
    assert world.store.contacts.cache.number[0] > 4
    assert world.store.contacts.cache.soft[0] > 0
    return world.snapshot()


def damaged(snapshot, name, place, value):
    array = snapshot[name].copy()
    array[place] = value
    return snapshot | {name: array}


def refused(snapshot, message):
    """A world that was to take a snapshot says why it does not, and is as it was."""
    world = World(integrator="rk4")
    world.add_box((1.0, 1.0, 1.0), 1.0)
    before = world.snapshot()
    with pytest.raises(SnapshotError, match=message):
        world.restore(snapshot)
    after = world.snapshot()
    assert after.keys() == before.keys()
    assert all((after[name] == before[name]).all() for name in before)


@pytest.mark.parametrize(
    ("name", "place", "value", "message"),
    [
        ("model.particle_inverse_mass", 3, -1.0, r"inverse_mass\[3\] is -1\.0; it must be a finite number ≥ 0"),
        ("model.particle_inverse_mass", slice(42), 0.0, r"soft body 0 is 0 everywhere"),
        ("model.edge_particles", (7, 1), 10**9, r"edge_particles of soft body 0 are not the edges of its triangles"),
        ("model.edge_particles", (-1, 0), 3, r"edge_particles of soft body 1"),
        ("model.edge_rest_length", 0, 0.0, r"edge_rest_length\[0\] is 0\.0; it must be a finite number > 0"),
        ("model.edge_stiffness", 0, np.inf, r"edge_stiffness\[0\] is inf"),
        (
            "model.edge_tear_at",
            7,
            0.5,
            r"model\.edge_tear_at\[7\] is 0\.5; it must be 0, or a finite number of a size > 1",
        ),
        ("model.triangle_particles", (5, 2), 10**9, r"soft body 0, from 0 on: triangle 5 is .* 1000000000\], but"),
        ("model.triangle_particles", (5, 2), -1, r"triangle_particles of soft body 0"),
        ("model.triangle_particles", (-1, 2), 0, r"triangle_particles of soft body 1"),
        ("model.triangle_particles", 3, [0, 1, 2], r"triangle_particles of soft body 0, .* is met by"),
        ("model.soft_particle_start", 0, 1, r"soft_particle_start is \[ 1 42 48\]; it must begin with 0 and grow"),
        ("model.soft_particle_start", 2, 10**15, r"has shape .*; it must be \(1000000000000000,\)"),
        ("model.soft_edge_start", 1, 2**62, r"soft_edge_start"),
        ("model.soft_triangle_start", 1, -(2**63), r"soft_triangle_start\[1\] is -9223372036854775808"),
        ("model.soft_restitution", 0, 1.5, r"soft_restitution\[0\] is 1\.5; it must be a finite number ≥ 0 and ≤ 1"),
        ("model.box_size", (1, 2), -1.0, r"box_size\[1, 2\] is -1\.0; it must be a finite number > 0"),
        ("model.box_inverse_inertia", (0, 1), 1.0, r"box_inverse_inertia\[0\] is .*; of a homogeneous box"),
        ("model.box_inverse_inertia", (2, 1), 1.0, r"box_inverse_inertia\[2\] is .*; of a homogeneous box"),
        ("model.ground_height", (), np.inf, r"ground_height is inf"),
        ("model.ground_friction", (), -1.0, r"ground_friction is -1\.0"),
        ("model.soft_count", (), 3, r"soft_particle_start has shape \(3,\); it must be \(4,\)"),
        ("model.box_count", (), -1, r"box_count is -1"),
        ("controls.soft_gas", 0, -1.0, r"soft_gas\[0\] is -1\.0"),
        ("controls.gravity", 1, np.nan, r"gravity\[1\] is nan"),
        ("state.particle_position", (9, 2), np.nan, r"particle_position\[9, 2\] is nan"),
        ("state.particle_velocity", (9, 2), 1e200, r"particle_velocity\[9, 2\] is 1e\+200; .* up to 1e\+50"),
        ("state.box_orientation", 0, [0.5, 0.0, 0.0, 0.0], r"box_orientation\[0\] has length 0\.5; it must be 1"),
        ("cache.number", 0, 10**9, r"cache\.box has shape"),
        ("cache.soft", 0, 10**9, r"cache\.soft\[0\] is 1000000000; it must be a whole number"),
        ("cache.box", (0, 0), 99, r"cache\.box is no list of pairs of boxes"),
        ("cache.box", 0, [1, 0], r"cache\.box is no list of pairs of boxes"),
        ("cache.impulse", (0, 0), np.inf, r"cache\.impulse\[0, 0\] is inf"),
        ("settings.integrator", (), 7, r"settings\.integrator is 7; there are 0 \(rk4_velocity\), 1"),
        ("settings.substeps", (), 10**9, r"settings\.substeps is 1000000000\.0; give .* ≤ 1e\+07"),
        ("settings.iterations", (), 10**12, r"settings\.iterations is 1000000000000"),
        ("settings.speed_ceiling", (), np.nan, r"settings\.speed_ceiling is nan"),
        ("steps", (), -1, r"steps is -1"),
        ("time", (), np.inf, r"time is inf"),
    ],
)
def test_a_changed_number_is_refused_by_the_name_of_its_entry(mixed, name, place, value, message):
    refused(damaged(mixed, name, place, value), message)


def test_every_entry_must_be_there_and_be_an_array_of_its_kind_and_shape(mixed):
    for name, array in mixed.items():
        lacking = {key: mixed[key] for key in mixed if key != name}
        refused(lacking, f"'{re.escape(name)}' is missing")
        refused(mixed | {name: None}, re.escape(name))
        refused(mixed | {name: array.astype(object)}, f"{re.escape(name)} holds object")
        refused(mixed | {name: array.astype(complex) if array.dtype.kind != "U" else 1j}, re.escape(name))
        refused(mixed | {name: array[None]}, f"{re.escape(name)} has shape")
        if array.ndim:
            refused(mixed | {name: array[..., :-1]}, "has shape|must be")
            refused(mixed | {name: np.zeros(array.shape, np.float32)}, f"{re.escape(name)} holds float32")


def test_what_no_snapshot_has_is_refused(mixed):
    refused(mixed | {"model.colour": np.zeros(3)}, "'model.colour' is no entry of a snapshot")
    refused(mixed | {"precision": np.array("half")}, "precision is 'half'; choose one of double, single")
    refused(mixed | {"settings.integrator": np.array("euler")}, r"settings\.integrator holds <U5")
    for order in "<>":
        no_letter = np.frombuffer(np.array([0x110000], f"{order}u4").tobytes(), f"{order}U1")
        refused(mixed | {"precision": no_letter.reshape(())}, "precision holds 0x110000, which is no letter")
        refused(mixed | {"names.box": np.resize(no_letter, len(mixed["names.box"]))}, r"names\.box holds 0x110000")
    refused(list(mixed), "a snapshot is a dict of arrays, and this is a list")
    refused({}, "'format' is missing")


def test_a_snapshot_of_a_later_format_says_so_and_one_of_the_first_is_read_without_its_rings(mixed):
    refused(mixed | {"format": np.array(14)}, "format is 14, and this softbody reads formats up to 13")
    first = {name: array for name, array in mixed.items() if name.partition(".")[0] not in ("format", "names", "rest")}
    first |= {"rings.particle": np.array([10**9]), "rings.order": np.array([-1])}
    worlds = World(), World()
    for world, snapshot in zip(worlds, (mixed, first)):
        world.restore(snapshot)
        world.step(STEP, 20)
    assert worlds[0].state_hash() == worlds[1].state_hash()


def test_arrays_that_lie_otherwise_in_memory_are_the_same_snapshot(mixed):
    other = {name: np.asfortranarray(array) if array.ndim == 2 else array.copy() for name, array in mixed.items()}
    other["state.particle_velocity"] = np.repeat(other["state.particle_velocity"], 2, axis=0)[::2]
    for array in other.values():
        array.flags.writeable = False
    worlds = World(), World()
    for world, snapshot in zip(worlds, (mixed, other)):
        world.restore(snapshot)
        world.step(STEP, 20)
    assert worlds[0].state_hash() == worlds[1].state_hash()


def two_tips():
    """Two tetrahedra that share a vertex, about which triangles lie in two rings."""
    corners = 0.5 * np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1)])
    one = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
    other = [(0, 4, 5), (0, 6, 4), (4, 6, 5), (5, 6, 0)]
    return softbody.Mesh(corners, one + other)


@pytest.mark.parametrize("precision", ["double", "single"])
def test_vertex_rings_are_rebuilt_as_they_were(precision):
    world = World(precision=precision)
    meshes = two_tips(), softbody.octahedron(), two_tips(), softbody.torus(1.0, 0.4, 9, 7), softbody.octahedron()
    for k, mesh in enumerate(meshes):
        stiffness = np.linspace(1.0, 2.0, len(mesh.edges)) if k in (2, 3) else 100.0
        world.add_soft_body(mesh, 1.0, stiffness, 1.0, (3.0 * k, 0.0, 0.0), rest_length=0.3 if k == 3 else None)
    for changed in (None, 0, 3):
        if changed is not None:
            body = softbody.SoftBody(world, changed)
            count = len(meshes[changed].edges)
            body.set_springs(np.linspace(1.0, 3.0, count) if changed == 0 else 5.0, np.linspace(0.1, 0.2, count))
        before = world.store.rings
        world.restore(world.snapshot())
        for name, array in world.store.rings._asdict().items():
            assert array.dtype == getattr(before, name).dtype
            np.testing.assert_array_equal(array, getattr(before, name), name)


def test_the_state_of_a_pickle_is_checked_as_a_snapshot_is(mixed):
    world = World.__new__(World)
    with pytest.raises(SnapshotError, match="triangle_particles"):
        world.__setstate__(damaged(mixed, "model.triangle_particles", (0, 0), 10**9))
